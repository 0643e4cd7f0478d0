"""What fails first, in words: the least margin on what is asked for."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest

from uwopt.report.text.in_hand import fails_first, share_in_hand
from uwopt.results.design import Margin


def margin(name: str, value: float, limit: float, sense: str, unit: str, reserve: float = 0.0) -> Margin:
    """A margin with what is left worked out by its sense."""
    left = limit - value if sense == "<=" else value - limit
    return Margin(name, value, limit, sense, left, unit, None, left >= 0, left == 0, reserve=reserve)


@dataclass
class Scene:
    """What of a scene counts here."""

    margins: list[Margin]
    name: str = "reef"


@dataclass
class Design:
    """What of a design counts here."""

    scenes: list[Scene] = field(default_factory=list)
    feasible: bool = True
    totals: Any = field(default_factory=lambda: SimpleNamespace(cost=None))


BLUR = margin("max_blur_px", 0.5, 0.8, "<=", "px", 0.2)
SNR = margin("min_snr_db", 33.0, 33.0, ">=", "dB", 3.0)
SWATH = margin("min_swath_m", 1.0, 1.0, ">=", "m")
RATE = margin("overlap", 0.5, 0.5, ">=", "")


def said(*margins: Margin) -> str:
    return fails_first(Design([Scene(list(margins))]))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("one", "share"),
    [
        (BLUR, 0.5),  # 0.5 px of 1 px asked are left
        (SNR, 0.4125),  # 3 dB: 10^(3/20) - 1
        (SWATH, 0.0),
        (margin("depth_rating_m (dome)", 300.0, 125.0, ">=", "m", 25.0), 2.0),  # 300 m where 100 m are asked
    ],
)
def test_what_is_in_hand_is_a_share_of_what_is_asked(one, share):
    assert share_in_hand(one) == pytest.approx(share, abs=1e-4)


@pytest.mark.parametrize("one", [RATE, margin("cost", 10.0, 10.0, "<=", "USD"), margin("gain_min", 1, 1, ">=", "")])
def test_settings_and_budgets_break_no_image(one):
    assert share_in_hand(one) is None
    assert said(one) == ""


def test_the_least_in_hand_is_named_with_its_reserve():
    assert said(BLUR, SNR, RATE) == "signal to noise, margin 0 dB beyond the 3 dB reserve"


def test_a_depth_rating_counts_from_the_deepest_scene():
    """A dome rated to 6000 m, as was asked for 5500 m, was told to fail first, with a margin of 0 m."""
    dome = margin("depth_rating_m (dome)", 6000.0, 6000.0, ">=", "m")
    assert share_in_hand(dome, 5500.0) == pytest.approx(0.0909, abs=1e-4)
    design = Design([Scene([margin("max_gsd_mm", 3.8, 4.0, "<=", "mm"), dome])])  # 5 % left
    assert fails_first(design, 5500.0) == "pixel on the floor, margin 0.200 mm"  # type: ignore[arg-type]
    for deepest_m, left in ((6000.0, "0 m"), (5900.0, "100 m")):
        told = fails_first(design, deepest_m)  # type: ignore[arg-type]
        assert told == f"depth rating (dome), {left} over the deepest scene"


def test_without_a_reserve_none_is_told():
    assert said(BLUR, SNR, SWATH) == "swath, margin 0 m"


def test_what_fails_together_is_named_together():
    gsd = margin("max_gsd_mm", 1.0, 1.0, "<=", "mm")
    assert said(gsd, SWATH) == "pixel on the floor, margin 0 mm; swath, margin 0 m"


def test_the_scene_is_named_where_there_are_several():
    two = Design([Scene([BLUR], "reef"), Scene([SWATH], "sand")])
    assert fails_first(two) == "swath in sand, margin 0 m"  # type: ignore[arg-type]


def test_a_design_that_misses_something_already_fails():
    assert fails_first(Design([Scene([SWATH])], feasible=False)) == ""  # type: ignore[arg-type]
