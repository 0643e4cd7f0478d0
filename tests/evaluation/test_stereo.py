"""A stereo pair in a mission: its figures, lines, lamps as each camera sees them, and what a mission must say of it."""

from __future__ import annotations

import copy
import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import uwopt
from uwopt.errors import MissionError
from uwopt.evaluation.recompute import replay
from uwopt.forward.scene import scene_optics
from uwopt.mission.mission import load_mission
from uwopt.report.card.blocks import stands, work_rows
from uwopt.report.pictures.curves import rig_measures
from uwopt.report.pictures.drawing import view_from_behind
from uwopt.report.text import words
from uwopt.results.result import Result

MISSION: dict[str, Any] = {
    "practice": "bare", "name": "pair", "physics": "full",
    "scene": {"name": "reef", "water": "II", "seafloor": 0.2, "depth_m": 30},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "camera_count": 2, "camera_baseline_m": 0.4, "light_count": 2,
                "light_baseline_m": 0.5},
    "requirements": {"overlap": 0.3, "sidelap": 0.2, "max_depth_error_mm": 10.0, "disparity_error_px": 0.5},
}  # fmt: skip
SYSTEM: dict[str, Any] = {
    "camera": {
        "resolution_x_px": 2000, "resolution_y_px": 1500, "pixel_pitch_um": 4.0, "read_noise_e": 2.4,
        "quantum_efficiency": 0.6, "gain_dn_per_e": 0.35, "bit_depth": 12,
    },
    "lens": {"focal_length_mm": 8.0, "transmission": 0.9},
    "port": {"geometry": "dome", "outer_radius_mm": 80, "thickness_mm": 10, "refractive_index": 1.5},
    "light": {
        "flux_lm": 4000, "power_w": 40, "spectrum": "generic-led", "beam": "cosine-power", "beam_half_angle_deg": 40,
    },
    "camera_count": 2, "light_count": 2, "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0},
}  # fmt: skip


def changed(section: str, **values: Any) -> dict[str, Any]:
    made = copy.deepcopy(MISSION)
    made[section] |= values
    return made


def seen(mission: dict[str, Any], **system: Any) -> Result:
    return uwopt.evaluate(mission, {**SYSTEM, **system})


@pytest.fixture(scope="module")
def pair() -> Result:
    return seen(MISSION)


@pytest.fixture(scope="module")
def swath_m() -> float:
    """Footprint 2.08 m across from the dome's middle, 2.08 m away, of which the lens sees 1 / (1 + m) = 1 - f D."""
    n_water = scene_optics(load_mission(MISSION).views[0], paper=False).n_water
    outer, inner = (1.0 / 1.5 - 1.0 / n_water) / 0.08, (1.0 - 1.0 / 1.5) / 0.07
    return 2.08 * (1.0 - 8e-3 * (outer + inner + 1.0 / (n_water * 2.08)))


def test_figures_of_a_pair_are_those_by_hand(pair: Result, swath_m: float) -> None:
    """Both cameras see the footprint less 0.4 m; 0.5 px of 4 um behind 8 mm."""
    assert pair.design is not None
    figures = pair.design.scenes[0].figures
    assert figures["swath_m"] == pytest.approx(swath_m, rel=1e-9)
    assert figures["common_swath_m"] == pytest.approx(swath_m - 0.4, rel=1e-9)
    assert figures["depth_error_mm"] == pytest.approx(0.5 * 0.5e-3 * 2.08**2 / 0.4 * 1e3, rel=1e-9)


def test_lines_and_area_of_a_pair_count_what_both_cameras_see(pair: Result, swath_m: float) -> None:
    assert pair.design is not None
    figures = pair.design.scenes[0].figures
    assert figures["line_spacing_m"] == pytest.approx(0.8 * (swath_m - 0.4), rel=1e-9)
    assert figures["area_m2_h"] == pytest.approx(0.8 * (swath_m - 0.4) * 0.3 * 3600, rel=1e-9)


def test_an_area_asks_for_a_strip_that_both_cameras_see(swath_m: float) -> None:
    seen_m2_h = 0.8 * (swath_m - 0.4) * 0.3 * 3600
    for area_m2_h, fits in ((0.9997 * seen_m2_h, True), (1.0003 * seen_m2_h, False)):
        design = seen(changed("requirements", min_area_m2_h=area_m2_h)).design
        assert design is not None
        (strip,) = [m for m in design.scenes[0].margins if m.requirement == "min_common_swath_m"]
        assert strip.satisfied is fits and strip.value == pytest.approx(swath_m - 0.4)


def test_one_camera_has_no_figures_of_a_pair(swath_m: float) -> None:
    alone = copy.deepcopy(MISSION)
    del alone["vehicle"]["camera_baseline_m"], alone["requirements"]["max_depth_error_mm"]
    design = seen(alone).design
    assert design is not None
    assert not {"common_swath_m", "depth_error_mm"} & set(design.scenes[0].figures)
    assert design.scenes[0].figures["line_spacing_m"] == pytest.approx(0.8 * swath_m)


def test_how_a_pair_stands_is_told(pair: Result, swath_m: float) -> None:
    assert pair.design is not None
    turned = replace(pair.design.hardware, camera_convergence_deg=8.0)
    assert words.camera_stand(turned).endswith("ports 0.4 m apart across track, each turned 4° inward")
    lines = dict(stands(pair.design).pairs)
    assert lines["camera"].endswith("ports 0.4 m apart across track, side by side, not turned")
    work = dict(work_rows(pair, pair.design))
    assert work["swath of both cameras"] == [f"{swath_m - 0.4:.3g} m"]
    assert work["error of a distance by stereo"] == ["2.70 mm"]


def test_both_cameras_are_drawn_with_the_ends_of_their_views(pair: Result, swath_m: float) -> None:
    """At +-0.2 m, each seeing half its swath to either side from there."""
    assert pair.design is not None
    rig, half_m = rig_measures(replay(pair.mission, pair.design, physics=pair.physics, system=pair.system)), swath_m / 2
    left, right = (-0.2, -0.2 - half_m, half_m - 0.2), (0.2, 0.2 - half_m, 0.2 + half_m)
    assert rig.pair_m == pytest.approx(np.array([left, right]))
    assert view_from_behind(rig, title="a", description="b").count('class="view"') == 2


# ---------------------------------------------------------------- lamps as each camera sees them


def test_light_of_each_camera_is_that_of_lamps_shifted_against_it() -> None:
    """As a single camera sees them that has them at 0.5 - 0.4 and -0.5 - 0.4 m: the note tells that camera's SNR."""
    far = changed("vehicle", camera_baseline_m=0.8)
    note = next(w for w in seen(far).warnings if w.code == "pair_light")
    alone = copy.deepcopy(MISSION)
    del alone["vehicle"]["camera_baseline_m"], alone["requirements"]["max_depth_error_mm"]
    shifted = [{"y_m": 0.1}, {"y_m": -0.9}]
    design = seen(alone, light_mounts=shifted).design
    assert design is not None
    told = [float(number) for number in re.findall(r"(-?\d+\.\d) (?:and|dB)", note.message)]
    assert told[1:] == pytest.approx([float(design.scenes[0].figures["snr_db"])] * 2, abs=0.051)


def test_a_camera_of_a_pair_that_misses_what_the_middle_meets_is_told() -> None:
    """The least SNR is put just below that of the middle."""
    far = changed("vehicle", camera_baseline_m=0.8)
    design = seen(far).design
    assert design is not None
    result = seen({**far, "requirements": {
        **far["requirements"], "min_snr_db": float(design.scenes[0].figures["snr_db"]) - 1e-3}})
    note = next(w for w in result.warnings if w.code == "pair_light")
    assert result.design is not None and result.design.feasible
    assert "misses signal to noise" in note.message


def test_a_lamp_at_a_port_is_told() -> None:
    result = seen(changed("vehicle", light_baseline_m=0.2))
    assert "lamp_at_port" in {w.code for w in result.warnings}


# ---------------------------------------------------------------- what a mission must say


@pytest.mark.parametrize(
    ("section", "values", "message"),
    [
        ("vehicle", {"camera_count": 1}, "camera_baseline_m is of a stereo pair, but camera_count is 1; set it to 2"),
        ("vehicle", {"camera_count": 3}, "camera_baseline_m is of a stereo pair, but camera_count is 3; set it to 2"),
        ("vehicle", {"pitch_deg": 10}, "camera_baseline_m is of a pair that looks square at what it sees"),
        ("vehicle", {"camera_baseline_m": None}, "max_depth_error_mm is of a stereo pair; add vehicle.camera_baseline"),
        ("vehicle", {"camera_baseline_m": 0}, "camera_baseline_m = 0"),
        ("vehicle", {"camera_convergence_deg": -4}, "camera_convergence_deg = -4"),
        ("requirements", {"disparity_error_px": math.nan}, "disparity_error_px"),
        ("requirements", {"max_depth_error_mm": 0}, "max_depth_error_mm = 0"),
    ],
)  # fmt: skip
def test_a_pair_that_is_half_stated_is_refused(section: str, values: dict[str, Any], message: str) -> None:
    with pytest.raises(MissionError) as caught:
        seen(changed(section, **values))
    assert message in str(caught.value), caught.value


def test_a_system_of_one_camera_is_refused_where_a_pair_is_asked() -> None:
    with pytest.raises(MissionError, match="camera_count = 1, where the mission asks for a stereo pair"):
        seen(MISSION, camera_count=1)
