"""What is said of the image as a whole: always, and in plain words where it is weak."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from uwopt.report.page.page import report_html
from uwopt.report.text.console import print_blocks
from uwopt.report.text.frame import facts_of
from uwopt.report.text.short import full_text_blocks
from uwopt.results.result import Result

Make = Callable[..., Any]
FIGURES: dict[str, Any] = {
    "snr_db": 30.0, "snr_db_p05": 10.3, "snr_db_min": -4.5, "snr_db_centre": 40.0, "uniformity": 0.006,
    "defocus_corner_px": 16.9, "mtf_half_nyquist": 0.4,
}  # fmt: skip


def text_of(result: Result) -> str:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="utf-8")
    print_blocks(full_text_blocks(result), stream)
    stream.flush()
    return " ".join(raw.getvalue().decode("utf-8").split())


def told(**changed: Any) -> dict[str, str]:
    return dict(facts_of({**FIGURES, **changed}))


def test_mean_most_and_darkest_stand_side_by_side_in_text_and_page(make_result: Make) -> None:
    result = make_result()
    best = result.recommendation
    scenes = [replace(scene, figures={**scene.figures, **FIGURES}) for scene in best.scenes]
    result = replace(result, recommendation=replace(best, scenes=scenes))
    said = "mean 30.0 dB, 95 % of the frame 10.3 dB, darkest pixel -4.50 dB"
    for text in (text_of(result), report_html(result)):
        assert said in text
        assert "0.600 % of the mean: a spot, the rest is dark" in text
        assert "16.9 px at 80 % of the way from the middle: soft corners" in text


@pytest.mark.parametrize(
    ("even", "blur_px", "weak"), [(0.29, 2.01, True), (0.3, 2.0, False), (0.9, 0.0, False)]
)
def test_a_spot_and_soft_corners_are_called_so(even: float, blur_px: float, weak: bool) -> None:
    facts = told(uniformity=even, defocus_corner_px=blur_px)
    assert ("spot" in facts["evenness of the light"]) is weak
    assert ("soft" in facts["blur of the corners"]) is weak


def test_a_pixel_without_light_is_called_so() -> None:
    assert told(snr_db_min=None)["signal to noise"].endswith("darkest pixel no light")


def test_physics_without_a_field_says_nothing() -> None:
    assert told(mtf_half_nyquist=None) == {}
