"""Maps of light and noise: their means are the figures, and they lie as the image does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import uwopt
from uwopt.report.pictures.maps import floor_map, image_map, image_points

PROBLEMS = Path(__file__).parents[2] / "problems"


@pytest.fixture(
    scope="module", params=["nui-acfr", "whoi-abe", "awi-ofobs", "paper-tank", "paper-tool-window"]
)
def case(request, replayed):
    return replayed(PROBLEMS / f"{request.param}.yaml", PROBLEMS / f"{request.param}.system.yaml")


def test_maps_mean_what_the_figures_say(case):
    design, figures = case
    image, floor = image_map(design), floor_map(design)
    if design.model.problem.paper:
        assert image is None
        assert floor is None
        return
    # midpoint rule of 48 x 36 cells: error of second order, 2e-4 here
    assert image.signal_e.mean() == pytest.approx(figures["electrons_signal"], rel=5e-4)
    veils = sum(figures[f"electrons_{name}"] or 0.0 for name in ("forward", "backscatter"))
    assert image.veil_e.mean() == pytest.approx(veils, rel=5e-3)
    assert floor.mean_lx == pytest.approx(figures["floor_illuminance_mean_lx"], rel=5e-4)
    # the darkest place is a corner or an edge: cells end half a cell before it
    assert image.snr_db.min() == pytest.approx(figures["snr_db_min"], abs=1.0)
    assert image.snr_db.min() >= figures["snr_db_min"]
    assert floor.least_lx == pytest.approx(figures["floor_illuminance_min_lx"], rel=0.1)


def test_middle_of_the_map_is_the_centre(case):
    design, figures = case
    if design.model.problem.paper:
        return
    odd = image_map(design, columns=3, rows=3)
    assert odd.snr_db[1, 1] == pytest.approx(figures["snr_db_centre"], abs=1e-6)


def test_portrait_turns_the_image_with_the_motion(replayed, colour_system):
    along, across = image_points(replayed(PROBLEMS / "nui-acfr.yaml", colour_system)[0], 4, 2)
    assert np.all(np.diff(along, axis=1) > 0)  # width along the motion, forward to the right
    assert np.all(np.diff(across, axis=0) > 0)


def test_daylight_is_in_the_map_as_in_the_figures(replayed):
    system = PROBLEMS / "nui-acfr.system.yaml"
    mission: dict[str, Any] = dict(uwopt.evaluate(PROBLEMS / "nui-acfr.yaml", system).mission)
    scene = {**mission["scenes"][0], "depth_m": 30, "sun_lux": 50_000}
    mission |= {"physics": "full", "scenes": [scene]}
    design, figures = replayed(mission, system)
    image = image_map(design)
    assert figures["electrons_sun"] > 0.02 * figures["electrons_signal"]
    assert image.signal_e.mean() == pytest.approx(figures["electrons_signal"], rel=5e-4)
    veils = figures["electrons_forward"] + figures["electrons_backscatter"]
    assert image.veil_e.mean() == pytest.approx(veils, rel=5e-3)


def test_narrow_beams_leave_dark_places_without_a_warning(replayed):
    tank = (PROBLEMS / "paper-tank.yaml", PROBLEMS / "paper-tank.system.yaml")
    system = uwopt.evaluate(*tank).system
    spot = {**system["light"], "beam_half_angle_deg": 3}
    design, _ = replayed(tank[0], {**system, "light": spot})
    image, floor = image_map(design), floor_map(design)
    assert np.nanmin(image.snr_db) == -np.inf  # where it is not saturated
    assert floor.least_lx == 0.0
    assert np.isfinite(image.mean_level).all()
