"""Energy, storage and endurance of a mission, by hand."""

from __future__ import annotations

from typing import Any

import pytest

import uwopt
from uwopt.errors import MissionError
from uwopt.mission.duration import Duration
from uwopt.mission.mission import load_mission
from uwopt.report.text.words import power_sentence

MISSION: dict[str, Any] = {
    "practice": "bare", "name": "six hours", "physics": "paper",
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_count": 2, "duration_h": 6.0, "battery_wh": 500.0},
    "requirements": {"frame_interval_s": 2.0, "circle_of_confusion_px": 2.0}, "limits": {},
    "scenes": [
        {"name": "far", "water": "II", "seafloor": 0.2, "depth_m": 100.0, "time_share": 0.25},
        {"name": "near", "water": "II", "seafloor": 0.2, "depth_m": 100.0, "altitude_m": 1.0, "frame_interval_s": 0.5},
    ],
}  # fmt: skip
SYSTEM: dict[str, Any] = {
    "camera": {"resolution_x_px": 2000, "resolution_y_px": 1000, "pixel_pitch_um": 5.0, "read_noise_e": 5.0,
               "quantum_efficiency": 0.5, "bit_depth": 12, "max_frame_rate_hz": 10.0, "power_w": 4.0},
    "lens": {"focal_length_mm": 10.0, "f_number_min": 1.4, "f_number_max": 16.0},
    "port": {"geometry": "flat", "gap_mm": 5.0, "thickness_mm": 10.0},
    "light": {"kind": "pulsed_led", "flux_lm": 10_000, "power_w": 100.0, "beam": "cosine-power",
              "beam_half_angle_deg": 40.0},
    "light_count": 2,
    "settings": {"f_number": 4.0, "exposure_ms": 1.0, "pulse_ms": 1.0, "gain": 1.0},
}  # fmt: skip
# Frames a second 0.5 and 2 (overlap asks for less); lamps 2 x 100 W x 1 ms x rate = 0.1 W and 0.4 W; camera 4 W.
# Energy: 6 h x (0.25 x 4.1 W + 0.75 x 4.4 W) = 6 x 4.325 = 25.95 Wh, and 500 Wh last 500 / 4.325 = 115.607 h.
# One image has 2000 x 1000 x 12 / 8 = 3 MB: 3 MB x (0.25 x 0.5 + 0.75 x 2) /s x 21 600 s = 105.3 GB.
ENERGY_WH, STORAGE_GB, ENDURANCE_H = 25.95, 105.3, 115.6069


def design(**changes: Any) -> Any:
    """What `evaluate` says of the system, with other limits."""
    result = uwopt.evaluate({**MISSION, **changes}, SYSTEM)
    assert result.design is not None
    return result.design


def test_energy_storage_and_endurance_are_those_by_hand() -> None:
    found = design()
    assert found.totals.energy_wh == pytest.approx(ENERGY_WH, rel=1e-9)
    assert found.totals.storage_gb == pytest.approx(STORAGE_GB, rel=1e-9)
    assert found.totals.endurance_h == pytest.approx(ENDURANCE_H, rel=1e-5)
    far, near = (scene.figures for scene in found.scenes)
    assert (far["energy_wh"], near["energy_wh"]) == pytest.approx((6 * 0.25 * 4.1, 6 * 0.75 * 4.4))
    assert (far["storage_gb"], near["storage_gb"]) == pytest.approx((8.1, 97.2))
    assert found.totals.power_w == pytest.approx(4.4)  # the worst scene's, as before


@pytest.mark.parametrize(("key", "value"), [("energy_wh", ENERGY_WH), ("storage_gb", STORAGE_GB)])
def test_limits_over_scenes_hold_just_inside_and_are_missed_just_outside(key: str, value: float) -> None:
    for room, holds in ((1.0 + 1e-5, True), (1.0 - 1e-5, False)):
        found = design(limits={key: value * room})
        margins = [m for scene in found.scenes for m in scene.margins if m.requirement == key]
        assert [m.satisfied for m in margins] == [holds] * 2
        assert found.feasible <= holds


def test_without_a_duration_nothing_is_counted() -> None:
    vehicle = {k: v for k, v in MISSION["vehicle"].items() if k not in ("duration_h", "battery_wh")}
    found = design(vehicle=vehicle)
    assert (found.totals.energy_wh, found.totals.storage_gb, found.totals.endurance_h) == (None, None, None)
    assert found.scenes[0].figures["energy_wh"] is None


def test_scenes_without_a_share_divide_the_rest() -> None:
    duration = Duration.of(load_mission(MISSION))
    assert duration.shares == (0.25, 0.75)
    assert duration.mean([4.0, 8.0]) == 7.0


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5}, "limits": {"energy_wh": 5.0}},
         "limits.energy_wh is counted over the mission's time; add vehicle.duration_h"),
        ({"vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5}, "limits": {"storage_gb": 5.0}},
         "limits.storage_gb is counted over the mission's time"),
        ({"scenes": [{"name": "far", "water": "II", "seafloor": 0.2, "depth_m": 100.0, "duration_h": 3.0}]},
         "duration_h is of the whole mission, not of one scene"),
    ],
)  # fmt: skip
def test_faults_of_duration_are_told(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(MissionError, match=told):
        load_mission({**MISSION, **changes})


def test_the_text_says_what_the_mission_uses_up() -> None:
    assert power_sentence(design().totals).endswith("energy 26.0 Wh, storage 105 GB, battery lasts 116 h")


@pytest.mark.parametrize(
    ("vehicle", "drawn_w"),
    [({"lamp_supply": "battery"}, 0.0), ({"supply": "battery"}, 0.0), ({}, 1.0)],
    ids=["torches are asked for", "the system has a battery", "the vehicle feeds all"],
)
@pytest.mark.parametrize("kind", ["pulsed_led", "flash"])
def test_lamps_on_batteries_of_their_own_draw_nothing_from_that_of_the_system(
    kind: str, vehicle: dict[str, str], drawn_w: float
) -> None:
    """By hand: lamps fed from outside add 0.1 W and 0.4 W to the camera's 4 W, or 2 x 35 J at the frame rates."""
    flash = {"kind": "flash", "flash_energy_j": 35.0, "flash_duration_us": 1000.0, "flash_duration_at_frac": 1.0}
    light = {"beam": "cosine-power", "beam_half_angle_deg": 40.0, "supply": "battery", "trigger": "electrical"}
    lamp = light | (flash if kind == "flash" else {"kind": kind, "flux_lm": 10_000, "power_w": 100.0})
    asked = {**MISSION, "vehicle": MISSION["vehicle"] | vehicle}
    found = uwopt.evaluate(asked, SYSTEM | {"light": lamp}).design
    assert found is not None
    by_scene = (35.0, 140.0) if kind == "flash" else (0.1, 0.4)
    assert [scene.figures["light_power_w"] for scene in found.scenes] == pytest.approx([drawn_w * w for w in by_scene])
    far_w, near_w = (4.0 + drawn_w * w for w in by_scene)
    assert found.totals.energy_wh == pytest.approx(6.0 * (0.25 * far_w + 0.75 * near_w))
