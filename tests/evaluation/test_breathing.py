"""What a lens that is focused near covers: less than at infinity, by the thin lens that moves as a whole."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import pytest

import uwopt
from uwopt.evaluation.breathing import breathing_notes
from uwopt.forward.scene import scene_optics
from uwopt.mission.mission import load_mission
from uwopt.report.pictures.design_pictures import view_pictures
from uwopt.report.pictures.photograph import whole_view
from uwopt.results.design import Design
from uwopt.results.result import Result

MISSION: dict[str, Any] = {
    "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_count": [1, 2]},
    "requirements": {"overlap": 0.6, "max_blur_px": 1.0, "min_snr_db": 20.0},
    "catalog": {"cameras": ["flir"], "lenses": ["computar*"], "ports": ["*dome*"], "generic": "never"},
}  # fmt: skip
FOCAL_M, RADIUS_M, WALL_M, N_DOME = 8e-3, 0.05, 0.005, 1.5
SYSTEM: dict[str, Any] = {
    "camera": {
        "resolution_x_px": 1000, "resolution_y_px": 800, "pixel_pitch_um": 5.0, "saturation_e": 10_000,
        "read_noise_e": 3.0, "quantum_efficiency": 0.5, "shutter": "global", "max_frame_rate_hz": 50.0,
    },
    "lens": {"focal_length_mm": 8, "f_number_min": 1.4, "f_number_max": 16},
    "port": {"geometry": "dome", "outer_radius_mm": 50, "thickness_mm": 5, "refractive_index": N_DOME},
    "light": {"luminous_flux_lm": 10_000, "power_w": 100, "beam": "cosine-power", "beam_angle_deg": 90},
    "light_count": 2, "orientation": "landscape", "settings": {"exposure_ms": 1.0, "f_number": 4.0},
}  # fmt: skip


def closer() -> float:
    """1 / (1 + m) = 1 - f D: the thin lens images 1 / D at f / (1 - f D), and the dome shows 2 m of water there."""
    n_water = scene_optics(load_mission(MISSION).views[0], paper=False).n_water
    faces = (1.0 / N_DOME - 1.0 / n_water) / RADIUS_M + (1.0 - 1.0 / N_DOME) / (RADIUS_M - WALL_M)
    return 1.0 - FOCAL_M * (faces + 1.0 / (n_water * (2.0 + RADIUS_M)))


@cache
def behind_dome(overlap: float = 0.6) -> Result:
    asked = MISSION["requirements"] | {"overlap": overlap}
    return uwopt.evaluate(MISSION | {"requirements": asked}, SYSTEM)


def design_of(result: Result) -> Design:
    assert result.design is not None
    return result.design


def test_swath_and_blur_are_those_of_a_lens_that_moves_as_a_whole() -> None:
    figures, pixel_m = design_of(behind_dome()).scenes[0].figures, 2.05 * 5e-6 / FOCAL_M
    assert figures["swath_m"] == pytest.approx(1000 * pixel_m * closer(), rel=1e-9)
    assert figures["blur_px"] == pytest.approx(0.5 * 1e-3 / (pixel_m * closer()), rel=1e-9)
    assert figures["gsd_mm"] == pytest.approx(1e3 * pixel_m, rel=1e-9)  # the lens may keep its field


def test_images_overlap_through_a_lens_that_moves_as_a_whole() -> None:
    along_m = 800 * 2.05 * 5e-6 / FOCAL_M * closer()
    figures = design_of(behind_dome()).scenes[0].figures
    assert figures["frame_rate_min_hz"] == pytest.approx(0.5 / (along_m * (1.0 - 0.6)), rel=1e-9)
    assert figures["overlap"] == pytest.approx(0.6, rel=1e-9)


@pytest.mark.parametrize("orientation", ["landscape", "portrait"])
def test_the_simulated_photograph_is_as_wide_as_the_image_surely_covers(orientation: str, replayed: Any) -> None:
    design, _ = replayed(MISSION, SYSTEM | {"orientation": orientation})
    width_m = 1000 * 2.05 * 5e-6 / FOCAL_M * closer()
    assert whole_view(design).width_mm == pytest.approx(1e3 * width_m, rel=1e-9)
    assert f"{width_m:.3g} m of floor lie on 1000 px" in view_pictures(whole_view(design), "whole", "")[0].caption


def test_what_is_counted_is_told_behind_a_dome() -> None:
    result = behind_dome()
    (note,) = [one for one in result.warnings if one.code == "breathing"]
    assert breathing_notes(design_of(result)) == [note]
    assert f"extends by {100 * (1 / closer() - 1):.1f} %" in note.message


def test_a_proven_swath_is_seen_by_a_lens_that_moves_as_a_whole() -> None:
    """Asked for a little more than the best covers, so that a field at infinity would still do, another is chosen."""
    plain = uwopt.solve(MISSION, quick=True).best
    assert plain is not None
    figures = plain.scenes[0].figures
    wanted_m = figures["swath_m"] * math.sqrt(figures["working_f_number"] / figures["f_number"])
    best = uwopt.solve(MISSION | {"requirements": MISSION["requirements"] | {"min_swath_m": wanted_m}}, quick=True).best
    assert best is not None and best.scenes[0].figures["swath_m"] >= wanted_m * (1 - 1e-9)
