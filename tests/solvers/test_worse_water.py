"""One system in worse water: what breaks unchanged, and settings that do."""

from __future__ import annotations

from typing import Any

import pytest
from priced_system import PRICED

from uwopt.api.evaluating import evaluate
from uwopt.evaluation.recompute import given_settings, replay
from uwopt.mission.mission import load_mission
from uwopt.solvers.explain.worse_water import (
    InWorseWater,
    flown,
    in_worse_water,
    worse_missions,
    worse_scene,
)

MISSION: dict[str, Any] = {
    "physics": "paper", "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_count": 2},
    "requirements": {"overlap": 0.6, "max_blur_px": 1.0, "min_snr_db": 26.5},
}  # fmt: skip
SETTINGS = {"f_number": 4.0, "exposure_ms": 3.0, "pulse_ms": 1.0, "gain": 4.0, "frame_rate_hz": 2.0}
SEALED = PRICED | {"light": PRICED["light"] | {"flux_lm": 30_000.0}, "light_count": 2, "settings": SETTINGS}
SYSTEM = SEALED | {"lens": SEALED["lens"] | {"aperture_control": "motorised"}}


@pytest.fixture(scope="module")
def worse() -> list[InWorseWater]:
    result = evaluate(MISSION, SYSTEM)
    assert result.status == "feasible"
    made = replay(result.mission, result.best, physics=result.physics, system=result.system)
    given = [given_settings(made.model, 0, result.best.scenes[0].settings)]
    return in_worse_water(made.model.problem, made.model.hardware, given)


def test_unchanged_settings_miss_the_signal_and_new_ones_do_not(worse: list[InWorseWater]) -> None:
    assert [item.water for item in worse] == ["Jerlov III", "Jerlov 1C", "Jerlov 3C"]
    for item in worse:
        assert [m.requirement for m in item.as_planned.scenes[0].margins if not m.satisfied] == ["min_snr_db"]
        assert item.design is not None
        assert all(m.satisfied for m in item.design.scenes[0].margins)


def test_behind_a_sealed_port_the_iris_stays_as_it_is(worse: list[InWorseWater]) -> None:
    result = evaluate(MISSION, SEALED)
    made = replay(result.mission, result.best, physics=result.physics, system=result.system)
    given = [given_settings(made.model, 0, result.best.scenes[0].settings)]
    found = in_worse_water(made.model.problem, made.model.hardware, given)
    f_numbers = [[one.design.scenes[0].settings["f_number"] for one in some if one.design] for some in (found, worse)]
    assert f_numbers[0] == [4.0, 4.0, 4.0] and max(f_numbers[1]) < 4.0
    for sealed, free in zip(found, worse, strict=True):  # it must go nearer where a motorised lens opens
        assert sealed.altitude_frac <= free.altitude_frac


def test_what_is_told_of_worse_water_is_what_evaluate_says_there(worse: list[InWorseWater]) -> None:
    scene = {**MISSION["scene"], "water": "III"}
    again = evaluate({**MISSION, "scene": scene}, SYSTEM)
    assert worse[0].as_planned.scenes[0].figures["snr_db"] == pytest.approx(again.best.scenes[0].figures["snr_db"])


def test_the_altitude_is_lowered_only_where_settings_alone_do_not_help(worse: list[InWorseWater]) -> None:
    assert [item.altitude_frac for item in worse[:2]] == [1.0, 1.0]
    assert worse[2].altitude_frac == pytest.approx(0.9)
    design = worse[2].design
    assert design is not None
    assert design.scenes[0].figures["gsd_mm"] == pytest.approx(0.9 * worse[2].as_planned.scenes[0].figures["gsd_mm"])


def test_what_stops_the_vehicle_on_its_way_down_is_told() -> None:
    needs = MISSION["requirements"] | {"min_swath_m": 1.45}  # 1.504 m wide at 2 m, and less below
    result = evaluate({**MISSION, "requirements": needs}, SYSTEM)
    made = replay(result.mission, result.best, physics=result.physics, system=result.system)
    given = [given_settings(made.model, 0, result.best.scenes[0].settings)]
    last = in_worse_water(made.model.problem, made.model.hardware, given)[-1]
    assert (last.design, last.obstacle) == (None, "min_swath_m")


@pytest.mark.parametrize(
    ("scene", "worse_by_one"),
    [
        ({"c_per_m": 0.2}, {"c_per_m": 0.25}), ({"visibility_m": 10.0}, {"visibility_m": 8.0}),
        ({"turbidity_ntu": 2.0}, {"turbidity_ntu": 2.5}), ({"water": "II"}, {"water": "III"}),
        ({"water": "9C"}, None), ({"water": "harbour.csv"}, None),
    ],
)  # fmt: skip
def test_worse_is_more_attenuation_or_the_next_type(scene: dict[str, Any], worse_by_one: dict[str, Any] | None) -> None:
    made = worse_scene(scene, 0)
    assert (made and made[1]) == worse_by_one


def test_no_reading_beyond_what_a_mission_may_hold_is_tried() -> None:
    mission = load_mission({**MISSION, "scene": {"c_per_m": 14.0, "seafloor": "sand", "depth_m": 20}})
    assert [name for name, _ in worse_missions(mission)] == ["c_per_m 17.5"]


def test_altitudes_of_scenes_are_lowered_with_the_vehicle_s() -> None:
    scenes = [{**MISSION["scene"], "name": "a"}, {**MISSION["scene"], "name": "b", "vehicle": {"altitude_m": 4.0}}]
    mission = load_mission({key: value for key, value in MISSION.items() if key != "scene"} | {"scenes": scenes})
    lower = flown(mission, 0.5, landscape=True)
    assert lower is not None
    assert [view.vehicle.altitude_m for view in lower.views] == [1.0, 2.0]
    assert lower.vehicle.orientation == "landscape"
