"""Power of lamps and cameras that are off between images, by hand: a lander with one image an hour."""

from __future__ import annotations

from typing import Any

import pytest

import uwopt
from uwopt.catalog.parts.doubts import doubtful
from uwopt.errors import MissionError
from uwopt.forward.assembly import system_problem
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system

OFF = {"lamps_between_images": "off", "camera_between_images": "off"}
MISSION: dict[str, Any] = {
    "practice": "bare", "name": "lander", "physics": "paper",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 300.0},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0, "light_count": 2, "duration_h": 4380.0, "battery_wh": 1000.0},
    "requirements": {"frame_interval_s": 3600.0, "circle_of_confusion_px": 2.0}, "limits": {"max_exposure_ms": 100.0},
}  # fmt: skip
SYSTEM: dict[str, Any] = {
    "camera": {"resolution_x_px": 2000, "resolution_y_px": 1000, "pixel_pitch_um": 5.0, "read_noise_e": 5.0,
               "quantum_efficiency": 0.5, "bit_depth": 12, "max_frame_rate_hz": 10.0, "power_w": 4.0,
               "wake_up_s": 8.0, "standby_w": 0.002},
    "lens": {"focal_length_mm": 10.0, "f_number_min": 1.4, "f_number_max": 16.0},
    "port": {"geometry": "flat", "gap_mm": 5.0, "thickness_mm": 10.0},
    "light": {"flux_lm": 3_000, "power_w": 29.4, "beam": "cosine-power", "beam_half_angle_deg": 40.0,
              "warm_up_s": 1.5, "standby_w": 0.005},
    "light_count": 2,
    "settings": {"f_number": 4.0, "exposure_ms": 50.0, "gain": 1.0, "dim_frac": 0.5},
}  # fmt: skip
# Lamps: 2 x 29.4 W x 0.5 = 29.4 W for 1.5 s + 0.05 s an hour = 12.658 mW, and 2 x 5 mW of standby: 22.658 mW.
# Camera: 4 W for 8 s to wake up, 0.05 s of exposure, 0.1 s of transfer: 9.056 mW, and 2 mW of standby.
LAMPS_W = 29.4 * 1.55 / 3600.0 + 0.010
CAMERA_W = 4.0 * 8.15 / 3600.0 + 0.002


def totals(vehicle: dict[str, Any], **changes: Any) -> Any:
    """What the system draws with other keys of the vehicle and of its parts."""
    system = {**SYSTEM, **{part: {**SYSTEM[part], **more} for part, more in changes.items()}}
    result = uwopt.evaluate({**MISSION, "vehicle": {**MISSION["vehicle"], **vehicle}}, system)
    assert result.design is not None
    return result.design.totals


def test_a_lander_draws_milliwatts_with_lamps_and_camera_off_between_images() -> None:
    found = totals(OFF)
    assert found.light_power_w == pytest.approx(LAMPS_W, rel=1e-9)
    assert found.light_power_w == pytest.approx(22.658e-3, rel=1e-4)
    assert found.power_w == pytest.approx(LAMPS_W + CAMERA_W, rel=1e-9)
    assert found.power_w == pytest.approx(33.714e-3, rel=1e-5)
    assert found.energy_wh == pytest.approx(4380.0 * (LAMPS_W + CAMERA_W))  # 148 Wh in six months
    assert found.light_peak_power_w == pytest.approx(29.4)  # as ever


FLASH: dict[str, Any] = {
    "kind": "flash", "flux_lm": None, "power_w": None, "warm_up_s": None, "standby_w": None, "flash_energy_j": 50.0,
    "flash_duration_us": 2000.0, "charging_efficiency_frac": 0.7,
}  # fmt: skip


@pytest.mark.parametrize(
    ("recycle_s", "peak_w"),  # 50 J at 70 % are 71.43 J from the supply of each of two; half of them once an hour
    [(2.0, 2 * 71.43 / 2.0), (None, 2 * 71.43 * 0.5 / 3600.0)],  # however little is used; over the whole pause
)
def test_flashes_draw_most_while_they_recharge(recycle_s: float | None, peak_w: float) -> None:
    found = totals({}, light=FLASH | {"recycle_s": recycle_s})
    assert found.light_power_w == pytest.approx(2 * 71.43 * 0.5 / 3600.0, rel=1e-4)
    assert found.light_peak_power_w == pytest.approx(peak_w, rel=1e-4)


def test_lamps_that_stay_on_burn_all_the_time() -> None:
    assert totals({}).power_w == pytest.approx(29.4 + 4.0)
    assert totals({"camera_between_images": "off"}).power_w == pytest.approx(29.4 + CAMERA_W)
    assert totals(OFF, light={"switchable": "no"}).power_w == pytest.approx(29.4 + CAMERA_W)


def test_lamps_are_on_all_the_time_where_images_follow_faster_than_they_warm_up() -> None:
    wanted = {**MISSION["requirements"], "frame_interval_s": 1.0}
    result = uwopt.evaluate(
        {**MISSION, "vehicle": {**MISSION["vehicle"], **OFF}, "requirements": wanted}, SYSTEM
    )
    assert result.design is not None
    assert result.design.totals.power_w == pytest.approx(29.4 + 0.010 + 4.0 + 0.002)


def test_a_rolling_shutter_keeps_lamps_on_for_all_of_its_rows() -> None:
    # All rows of a 10 Hz camera are read in 0.1 s.
    assert totals(OFF, camera={"shutter": "rolling"}).light_power_w == pytest.approx(
        29.4 * 1.65 / 3600.0 + 0.010
    )


def test_what_parts_do_not_say_is_estimated_and_told() -> None:
    lamp = {key: value for key, value in SYSTEM["light"].items() if key not in ("warm_up_s", "standby_w")}
    mission, system = {**MISSION, "vehicle": {**MISSION["vehicle"], **OFF}}, {**SYSTEM, "light": lamp}
    problem, _ = system_problem(load_mission(mission), load_system(system))
    told = {name: (q.value, q.low, q.high) for name, q in doubtful(problem.parts.lights[0])}
    assert told["warm_up_s"] == (1.0, 0.1, 3.0)
    assert told["standby_w"] == (0.01, 0.0, 0.1)
    assert "wake_up_s" not in dict(doubtful(problem.parts.cameras[0]))
    result = uwopt.evaluate(mission, system)
    assert result.design is not None
    assert result.design.totals.light_power_w == pytest.approx(29.4 * 1.05 / 3600.0 + 0.020)


@pytest.mark.parametrize(("given", "kept"), [(True, "on"), (False, "off"), ("off", "off"), ("ON", "on")])
def test_on_and_off_are_what_yaml_reads_as_true_and_false(given: Any, kept: str) -> None:
    vehicle = {**MISSION["vehicle"], "lamps_between_images": given}
    assert load_mission({**MISSION, "vehicle": vehicle}).vehicle.lamps_between_images == kept


def test_other_words_between_images_are_faults() -> None:
    with pytest.raises(MissionError, match=r"lamps_between_images = 'dimmed'"):
        load_mission({**MISSION, "vehicle": {**MISSION["vehicle"], "lamps_between_images": "dimmed"}})
