"""Pictures for the page: complete, plain, small, told in words, and drawn to scale."""

from __future__ import annotations

import base64
import dataclasses
import io
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plain_replay import plain_figures_of

import uwopt
from uwopt.evaluation.recompute import replayed, telling_figures
from uwopt.report.pictures.curves import DepthOfField
from uwopt.report.pictures.design_pictures import (
    MOST_BYTES,
    design_pictures,
    png_bytes,
    png_uri,
    rounded,
    sharp_pictures,
)
from uwopt.report.pictures.plots import numbers
from uwopt.units import format_quantity

PROBLEMS = Path(__file__).parents[2] / "problems"
NAMES = {
    "rig-behind", "rig-above", "chart-whole", "picture-whole", "chart-detail", "picture-detail", "picture-corner",
    "spectrum", "dof-aperture", "dof-focus", "rate", "exposure", "illuminance", "snr",
}  # fmt: skip
FIELD = {"picture-corner", "illuminance", "snr"}  # physics `paper` knows no field


def evaluated(name: str, system: Any = None) -> Any:
    return uwopt.evaluate(PROBLEMS / f"{name}.yaml", system or PROBLEMS / f"{name}.system.yaml")


@pytest.fixture(scope="module", params=["nui-acfr", "paper-tool-window", "colour"])
def made(request, colour_system):
    result = evaluated("nui-acfr", colour_system) if request.param == "colour" else evaluated(request.param)
    return result, design_pictures(result, result.best)


def test_every_picture_is_there(made):
    result, pictures = made
    names = [one.id for one in pictures]
    assert len(set(names)) == len(names)
    assert set(names) == (NAMES - FIELD if result.mission["physics"] == "paper" else NAMES)


def test_every_picture_is_told_in_words(made):
    for one in made[1]:
        assert one.title
        assert len(one.caption) > 20
        assert re.search(r"\d", one.alt), one.id
        assert not re.search(r"\bnan\b|\binf\b|None", one.title + one.caption + one.alt), one.id


def test_plots_are_plain_numbers_without_colours_for_text(made):
    for one in made[1]:
        if one.kind != "plotly":
            continue
        assert set(one.content) == {"data", "layout"}
        text = json.dumps(one.content, allow_nan=False)
        assert '"template"' not in text
        assert "NaN" not in text
        layout = one.content["layout"]
        assert "font" not in layout
        assert layout["paper_bgcolor"] == layout["plot_bgcolor"] == "rgba(0,0,0,0)"
        titles = [axis["title"]["text"] for key, axis in layout.items() if key.startswith(("xaxis", "yaxis"))]
        assert all(re.search(r"\[.+\]|f-number|/nm", title) for title in titles), titles  # units


def test_all_pictures_of_a_design_stay_small(made):
    sizes = [len(one.content if isinstance(one.content, str) else json.dumps(one.content)) for one in made[1]]
    assert sum(sizes) < 1_200_000
    for one in made[1]:
        if one.kind == "image":
            data = base64.b64decode(one.content.removeprefix("data:image/png;base64,"))
            assert len(data) <= MOST_BYTES
            width, height = (int.from_bytes(data[at : at + 4], "big") for at in (16, 20))  # of IHDR
            assert (width, height) == (one.width_px, one.height_px)


def test_key_numbers_are_those_of_the_result(made):
    result, pictures = made
    figures, by_id = result.best.scenes[0].figures, {one.id: one for one in pictures}
    assert f"{figures['dof_near_m']:.3g} m" in by_id["dof-aperture"].alt
    assert format_quantity(figures["frame_rate_min_hz"], "hz") in by_id["rate"].alt
    assert f"{figures['fov_x_m']:.3g} m" in by_id["rig-above"].alt
    if "illuminance" in by_id:
        assert f"{rounded(figures['floor_illuminance_mean_lx'])} lx" in by_id["illuminance"].alt
        assert f"SNR {figures['snr_db_centre']:.1f} dB" in by_id["picture-detail"].alt


def test_what_holds_for_all_simulated_pictures_is_said_once(made):
    told = [one.caption for one in made[1] if one.id.startswith("picture-")]
    assert [caption.count("not a photograph") for caption in told] == [1, *([0] * (len(told) - 1))]
    assert all("Applied: " in caption for caption in told)


def test_pairs_are_the_details(made):
    result, pictures = made
    chart, seen = design_pictures(result, result.best, whole=False)
    by_id = {one.id: one for one in pictures}
    assert (chart.content, seen.content) == (by_id["chart-detail"].content, by_id["picture-detail"].content)


def test_an_image_with_dark_parts_has_pictures_too():
    system = evaluated("paper-tank").system
    result = evaluated("paper-tank", {**system, "light": {**system["light"], "beam_half_angle_deg": 3}})
    by_id = {one.id: one for one in design_pictures(result, result.best)}
    assert set(by_id) == NAMES
    assert "no signal" in by_id["snr"].alt
    assert "no signal" in by_id["picture-corner"].caption


# ---------------------------------------------------------------- parts of them


def test_noise_is_made_coarser_until_it_fits():
    noise = np.random.default_rng(5).integers(0, 256, (300, 400, 3), dtype=np.uint8)
    assert len(png_bytes(noise)) > MOST_BYTES
    assert len(png_uri(noise // 8)) * 0.75 < len(png_uri(noise, most_bytes=10**9)) * 0.75
    grey = np.repeat(noise[..., :1] // 4, 3, axis=2)
    assert len(base64.b64decode(png_uri(grey).split(",")[1])) <= MOST_BYTES


def test_an_image_comes_back_as_it_went():
    from PIL import Image

    image = np.random.default_rng(6).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    data = base64.b64decode(png_uri(image).split(",")[1])
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(data))), image)


@pytest.mark.parametrize(
    ("value", "text"), [(1383.6, "1 380"), (99.94, "99.9"), (0.012345, "0.0123"), (0.0, "0")]
)
def test_large_numbers_have_no_power_of_ten(value, text):
    assert rounded(value) == text


def test_numbers_are_short_and_finite():
    assert numbers([1 / 3, math.inf, math.nan, 0.0, 123456.789]) == [0.33333, None, None, 0.0, 123460.0]
    assert numbers(np.eye(2)) == [[1.0, 0.0], [0.0, 1.0]]


def test_figures_that_tell_of_changed_inputs_are_those_of_the_report(made: Any) -> None:
    result, _ = made
    again = replayed(result, result.best)
    whole = plain_figures_of(again)
    for name, value in telling_figures(again, 0).items():
        assert value == pytest.approx(whole[name], rel=1e-12)  # the same numbers by a shorter way


@pytest.mark.parametrize(("asked_m", "told"), [(None, ""), (0.0, ""), (0.4, "wants 0.4 m of depth")])
def test_no_depth_is_wanted_where_none_is_asked(asked_m: float | None, told: str) -> None:
    known = np.array([1.0, 2.0])
    dof = DepthOfField(known, known, known, 2.0, known, known, known, 2.0, 1.8, 2.0, 2.2, asked_m, 1.0)
    (caption, _) = (one.caption for one in sharp_pictures(dof))
    assert ("The mission wants" in caption) == bool(told) and told in caption
    for one in sharp_pictures(dof):  # a screen of 390 px has room for so much below a plot
        assert len(one.content["layout"]["xaxis"]["title"]["text"]) <= 36
    (kept, _) = (one.caption for one in sharp_pictures(dataclasses.replace(dof, dof_reserve_m=0.04)))
    assert ("m of depth, with its reserve." in kept) == bool(told) and "reserve" not in caption
