"""Pictures of missions without lamps: the sun is shown, and nothing of a lamp; and cells that are saturated."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import uwopt
from uwopt.evaluation.recompute import Replay, replay
from uwopt.report.pictures.curves import rig_measures, spectrum_way
from uwopt.report.pictures.design_pictures import design_pictures, map_pictures
from uwopt.report.pictures.maps import field_at, floor_map, image_map
from uwopt.report.pictures.plots import snr_plot
from uwopt.results.result import Result

MISSION = {
    "practice": "bare", "name": "diver", "objective": "power", "physics": "full", "confidence": "central",
    "scene": {"water": "IB", "seafloor": "coral", "depth_m": 6.0, "sun_lux": 80_000.0},
    "vehicle": {"altitude_m": 1.5, "altitude_tolerance_m": 0.3, "speed_m_s": 0.3, "light_count": 0},
    "requirements": {"overlap": 0.7, "max_blur_px": 2.0, "min_snr_db": 25.0, "min_dof_m": 0.4},
    "catalog": {"cameras": ["daheng-mer2-041-528u3m"], "lenses": ["raspberry-pi-16-mm-telephoto-hq-camera"],
                "ports": ["blue-robotics-3-in-acrylic-end-cap-2026"], "generic": "never"},
}  # fmt: skip


@pytest.fixture(scope="module")
def result() -> Result:
    """A system without lamps."""
    return uwopt.solve(MISSION, quick=True)


@pytest.fixture(scope="module")
def made(result: Result) -> Replay:
    """Its model with the settings to set."""
    assert result.best is not None
    return replay(result.mission, result.best.as_set, physics=result.physics)


def test_no_lamp_is_drawn_or_told_of_where_there_is_none(result: Result, made: Replay) -> None:
    assert result.best is not None
    pictures = {one.id: one for one in design_pictures(result, result.best.as_set)}
    assert "illuminance" not in pictures
    assert "sun at 60°" in pictures["rig-behind"].content and "sun 60°" in pictures["rig-behind"].alt
    assert not rig_measures(made).lamps
    told = " ".join(f"{one.title} {one.caption} {one.alt}" for one in pictures.values())
    assert re.findall(r"\b(?:[Bb]eams?|lamps'|[Tt]he lamps|W/nm)\b", told) == []
    assert pictures["spectrum"].title == "Spectrum from the sun to the sensor"


def test_spectrum_of_the_sun_adds_up_to_the_electrons_in_the_middle(made: Replay) -> None:
    # two ways: wavelength by wavelength here, contracted and fitted over the field in what the figures are made of
    way = spectrum_way(made)
    middle = field_at(made, np.zeros(1), np.zeros(1)).signal_e
    assert way.electrons == pytest.approx(float(middle[0]), rel=2e-3)  # fits, and a rule of integration each
    # a day of 80 000 lux, K_m = 683.002 lm/W: what is above the water has this illuminance again
    photopic = made.model.problem.scenes[0].photopic
    assert 683.002 * np.trapezoid(way.source * photopic, way.wavelength_nm) == pytest.approx(80_000.0, rel=1e-3)


def test_saturated_cells_have_no_signal_to_noise(made: Replay) -> None:
    image = image_map(made)
    assert image is not None and not image.saturated.any() and floor_map(made) is None
    ten_times = replace(made, settings=tuple(replace(one, gain=one.gain * 10.0) for one in made.settings))
    bright = image_map(ten_times)
    assert bright is not None
    clipped = bright.mean_level > 1.0
    assert clipped.any() and np.isnan(bright.snr_db[clipped]).all()
    shown = np.array(snr_plot(bright)["data"][0]["z"], dtype=object)
    assert all(value is None for value in shown[clipped])
    assert "aturated" in map_pictures(bright, None)[0].caption
