"""Subjects that move by themselves: blur and skew by hand, and nothing else that speed decides."""

from __future__ import annotations

from typing import Any

import pytest
from dome_system import BEHIND_DOME

from uwopt.api.evaluating import evaluate
from uwopt.results.design import SceneResult

# Physics paper behind a dome: a pixel on the floor is p d / f = 5 um * 2 m / 8 mm = 1.25 mm.
MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "paper",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 10},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0, "orientation": "landscape"},
    "requirements": {"frame_interval_s": 1.0, "max_blur_px": 1.0},
}
SYSTEM: dict[str, Any] = {
    **BEHIND_DOME, "camera": {**BEHIND_DOME["camera"], "shutter": "rolling"}, "light_count": 1,
    "light": {"luminous_flux_lm": 10_000, "power_w": 100, "beam": "disc", "beam_half_angle_deg": 45},
}  # fmt: skip


def seen(subject_m_s: float, **vehicle: float) -> SceneResult:
    """The scene as the system takes it."""
    made = {
        **MISSION,
        "scene": {**MISSION["scene"], "subject_speed_m_s": subject_m_s},
        "vehicle": {**MISSION["vehicle"], **vehicle},
    }
    design = evaluate(made, SYSTEM).design
    assert design is not None
    return design.scenes[0]


def test_a_fish_before_a_lander_blurs_and_skews_by_its_own_speed() -> None:
    figures = seen(0.2).figures
    assert figures["blur_px"] == pytest.approx(0.2 * 5e-3 / 1.25e-3)  # 0.8 px
    assert figures["exposure_max_ms"] == pytest.approx(1.25 / 0.2)  # ms: a pixel takes 6.25 ms
    assert figures["skew_px"] == pytest.approx(0.2 * 20e-3 / 1.25e-3)  # 3.2 px


def test_it_may_swim_against_the_vehicle() -> None:
    assert seen(0.2, speed_m_s=0.1).figures["blur_px"] == pytest.approx(0.3 * 5e-3 / 1.25e-3)


def test_it_may_swim_across_while_the_vehicle_rolls() -> None:
    # 1 degree a second at 2 m: 34.9 mm/s more; along the motion there is nothing but its own speed
    across_m_s = 0.2 + 0.017453293 * 2.0
    assert seen(0.2, roll_rate_deg_s=1.0).figures["blur_px"] == pytest.approx(across_m_s * 5e-3 / 1.25e-3)


def test_overlap_and_frame_rate_are_the_vehicles_alone() -> None:
    still, swimming = (seen(v, speed_m_s=0.1) for v in (0.0, 0.2))
    # an image of 800 pixels is 1 m long; at 0.1 m/s and one a second nine tenths are seen again
    assert swimming.figures["overlap"] == pytest.approx(0.9)
    for name in ("overlap", "frame_rate_min_hz", "area_m2_h", "swath_m"):
        assert swimming.figures[name] == still.figures[name], name


def test_the_exposure_left_out_is_as_short_as_the_fish_asks() -> None:
    free = {**SYSTEM, "settings": {"f_number": 4.0}}
    scene = {**MISSION["scene"], "subject_speed_m_s": 0.5}
    design = evaluate({**MISSION, "scene": scene}, free).design
    assert design is not None and design.scenes[0].settings["exposure_ms"] == pytest.approx(1.25 / 0.5)
