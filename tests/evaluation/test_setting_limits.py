"""How far settings may be off: hand computed, and attacked through `evaluate`."""

from __future__ import annotations

from typing import Any

import pytest
from priced_system import PRICED

from uwopt.api.evaluating import evaluate
from uwopt.evaluation.recompute import given_settings, replay
from uwopt.evaluation.setting_limits import BOTH_TIMES, SettingEnd, SettingLimit, setting_limits
from uwopt.results.result import Result

LEVEL = 0.030165153285760835  # what these settings reach, so that it is met exactly
MISSION: dict[str, Any] = {
    "physics": "paper", "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_count": 2},
    "requirements": {"overlap": 0.6, "max_blur_px": 1.0, "min_snr_db": 10, "mean_level": LEVEL},
}  # fmt: skip
SETTINGS = {"f_number": 4.0, "exposure_ms": 3.0, "pulse_ms": 1.0, "gain": 4.0, "frame_rate_hz": 2.0}


def evaluated(**changes: float) -> Result:
    light = PRICED["light"] | {"flux_lm": 30_000.0}
    return evaluate(MISSION, PRICED | {"light": light, "light_count": 2, "settings": SETTINGS | changes})


@pytest.fixture(scope="module")
def limits() -> dict[str, SettingLimit]:
    result = evaluated()
    assert result.status == "feasible"
    made = replay(result.mission, result.best, physics=result.physics, system=result.system)
    rows = made.model.settings(0, given_settings(made.model, 0, result.best.scenes[0].settings))
    return {limit.setting: limit for limit in setting_limits(made.model, 0, rows)}


# by hand: a pixel of 5 um behind 10 mm in water (n = 1.33) is 2 m x 5 um / 13.3 mm = 0.7519 mm on the floor, so 1 ms at
# 0.5 m/s blurs 0.665 px, and 1000 rows are 0.7519 m along track, which overlap by 60 % at 0.5 / (0.4 x 0.7519) = 1.6625
# images a second. Level grows as gain and as lit time over N^2, and may be off by 1.2 % (a tenth of a decibel).
BY_HAND = {
    ("pulse_ms", "high_bright"): (1.0 / 0.665, "max_blur_px"),
    ("pulse_ms", "high"): (1.012, "mean_level"),
    (BOTH_TIMES, "high_bright"): (1.0 / 0.665, "max_blur_px"),
    ("exposure_ms", "low"): (0.988 / 3.0, "mean_level"),
    ("gain_db", "high"): (1.012, "mean_level"),
    ("gain_db", "low"): (0.988, "mean_level"),
    ("gain_db", "low_dark"): (0.25, "gain_min"),
    ("f_number", "high"): (0.988**-0.5, "mean_level"),
    ("f_number", "low_dark"): (1.4 / 4.0, "f_number_min"),
    ("dim_frac", "high_bright"): (1.0, "light_level_max"),
    ("frame_rate_hz", "low"): (0.83125, "overlap"),
    ("frame_rate_hz", "high"): (5.0, "frame_rate"),
}


@pytest.mark.parametrize(("setting", "end"), BY_HAND)
def test_ends_are_those_computed_by_hand(limits: dict[str, SettingLimit], setting: str, end: str) -> None:
    found: SettingEnd = getattr(limits[setting], end)
    factor, requirement = BY_HAND[setting, end]
    assert found.requirement == requirement
    assert found.factor == pytest.approx(factor, rel=2e-3)  # n = 1.33 and rounding of the hand values


def test_a_longer_exposure_than_the_pulse_changes_nothing(limits: dict[str, SettingLimit]) -> None:
    assert limits["exposure_ms"].high == SettingEnd(None, "")  # 64 times 3 ms is still within a frame


@pytest.mark.parametrize("setting", ["f_number", "pulse_ms", "frame_rate_hz"])
@pytest.mark.parametrize("side", ["low", "high"])
def test_evaluate_agrees_just_within_and_just_beyond(
    limits: dict[str, SettingLimit], setting: str, side: str
) -> None:
    end: SettingEnd = getattr(limits[setting], side)
    outward = 1e-4 if side == "high" else -1e-4
    for step, held in ((-outward, True), (outward, False)):
        again = evaluated(**{setting: SETTINGS[setting] * (end.factor or 0.0) * (1.0 + step)})
        verdict = {m.requirement: m.satisfied for m in again.best.scenes[0].margins}
        assert verdict[end.requirement] is held


def test_focus_breaks_where_evaluate_says(limits: dict[str, SettingLimit]) -> None:
    end = limits["focus_distance_m"].low
    assert end.requirement == "dof_far_m"
    for step, held in ((1e-3, True), (-1e-3, False)):
        again = evaluated(focus_distance_m=2.0 * (end.factor or 0.0) * (1.0 + step))
        verdict = {m.requirement: m.satisfied for m in again.best.scenes[0].margins}
        assert verdict["dof_far_m"] is held


def test_what_is_missed_already_does_not_count() -> None:
    result = evaluated(gain=8.0)  # twice too bright
    made = replay(result.mission, result.best, physics=result.physics, system=result.system)
    rows = made.model.settings(0, given_settings(made.model, 0, result.best.scenes[0].settings))
    found = {limit.setting: limit for limit in setting_limits(made.model, 0, rows)}
    assert found["gain_db"].low == found["gain_db"].low_dark
