"""What is looked at: names of its distance, and keys that have no meaning there."""

from __future__ import annotations

from typing import Any

import pytest

from uwopt.errors import MissionError
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.varying import VariedMission


def mission(target: str, vehicle: dict[str, Any] | None = None, limits: dict[str, Any] | None = None,
            **requirements: Any) -> Mission:  # fmt: skip
    carried = {"distance_m": 1.5, "distance_tolerance_m": 0.5, "speed_m_s": 0.1, **(vehicle or {})}
    sun = requirements.pop("sun_lux", 0)
    scene = {"water": "II", "seafloor": 0.2, "depth_m": 30, "target": target, "sun_lux": sun}
    return load_mission(
        {"practice": "bare", "scene": scene, "vehicle": carried, "requirements": requirements, "limits": limits or {}}
    )


def fault_of(target: str, **keys: Any) -> str:
    with pytest.raises(MissionError) as caught:
        check_physical(mission(target, **keys))
    text = str(caught.value)
    assert text.count("\n") == 0, text
    return text


def test_a_distance_is_an_altitude_by_another_name() -> None:
    made = mission("wall", overlap=0.3)
    assert (made.vehicle.altitude_m, made.vehicle.altitude_tolerance_m) == (1.5, 0.5)
    assert mission("mid-water", frame_interval_s=1.0).scenes[0].target == "mid_water"


def test_of_a_scene_too() -> None:
    scene = {"water": "II", "seafloor": 0.2, "depth_m": 30, "target": "wall", "distance_m": 0.7}
    made = load_mission({"practice": "bare", "scene": scene, "vehicle": {"speed_m_s": 0.1}})
    assert made.views[0].vehicle.altitude_m == 0.7


def test_faults_name_the_key_as_it_was_written() -> None:
    assert "vehicle.distance_m = -1 is not above 0" in fault_of("wall", vehicle={"distance_m": -1})
    told = fault_of("wall", vehicle={"distance_tolerance_m": 2.0})
    assert "vehicle.distance_tolerance_m = 2 is not below distance_m = 1.5" in told
    assert "vehicle.distance_m and altitude_m are both given" in fault_of("wall", vehicle={"altitude_m": 2.0})


def test_an_unknown_key_is_held_against_these_names_too() -> None:
    for key in ("distance_mm", "distance_metres"):
        with pytest.raises(MissionError, match=r"is unknown; .*\bdistance_m\b"):
            load_mission({"scene": {}, "vehicle": {key: 1200}})


def test_a_slip_in_a_varied_key_is_held_against_these_names_too() -> None:
    with pytest.raises(MissionError, match=r"did you mean distance_m\?"):
        VariedMission(mission("wall"), {}).named("distance_mm")


@pytest.mark.parametrize(("asked", "told"), [
    ({"overlap": 0.3, "frame_interval_s": 1.0}, "requirements.overlap is asked of ground"),
    ({"min_area_m2_h": 10.0, "frame_interval_s": 1.0}, "requirements.min_area_m2_h is asked of ground"),
    ({"sidelap": 0.1, "frame_interval_s": 1.0}, "requirements.sidelap is of lines over ground"),
    ({}, "requirements.frame_interval_s is missing; in mid_water no overlap sets the frame rate"),
])  # fmt: skip
def test_what_has_no_meaning_in_mid_water_is_told(asked: dict[str, float], told: str) -> None:
    assert told in fault_of("mid_water", **asked)
    if asked.get("frame_interval_s"):
        mission("wall", **asked)


@pytest.mark.parametrize("target", ["wall", "ceiling", "mid_water"])
def test_daylight_is_reckoned_on_floors_alone(target: str) -> None:
    told = fault_of(target, sun_lux=1000.0, frame_interval_s=1.0)
    assert "scene.sun_lux = 1000 is daylight, which is reckoned on a floor alone" in told
    assert ("evaluate tells of that system in the same mission with target: floor" in told) == (target != "ceiling")


def test_a_camera_that_looks_level_works_at_the_depth_of_its_target() -> None:
    # 29 m would do 1.5 m above a floor at 30 m
    told = fault_of("wall", limits={"depth_rating_m": 29.0}, overlap=0.3)
    assert "limits.depth_rating_m = 29 is less than the 30 m at which the camera works; raise it" in told
    mission("floor", limits={"depth_rating_m": 29.0}, overlap=0.3)


def test_a_lamp_behind_the_target_is_refused_in_its_words() -> None:
    told = fault_of("wall", vehicle={"light_mounts": [{"y_m": 0.3, "z_m": 1.2}]}, overlap=0.3)
    assert "puts the lamp on or behind the wall, which is 1 m before the port at the nearest" in told
    assert "raise the distance" in told


@pytest.mark.parametrize(("pitch_deg", "told"), [
    (180, "is of a camera that looks up; set scene.target: ceiling, with pitch_deg: 0 from straight up"),
    (150, "is of a camera that looks up; set scene.target: ceiling, with pitch_deg: 30 from straight up"),
    (90, "is above 80, of a camera that looks level; set scene.target: wall or mid_water, with pitch_deg: 0"),
])  # fmt: skip
def test_a_pitch_told_from_straight_down_is_told_what_it_looks_at(pitch_deg: float, told: str) -> None:
    assert f"vehicle.pitch_deg = {pitch_deg} {told}" in fault_of("floor", vehicle={"pitch_deg": pitch_deg}, overlap=0.3)


def test_a_ceiling_is_no_higher_than_the_water() -> None:
    told = fault_of("ceiling", vehicle={"distance_m": 31.0}, overlap=0.3)
    assert "vehicle.distance_m = 31 puts the ceiling above the surface: depth_m = 30 is the camera's depth" in told
    assert mission("ceiling", vehicle={"distance_m": 30.0}, overlap=0.3).asked_depth_m == 30.0
    told = fault_of("ceiling", sun_lux=1000.0, overlap=0.3)
    assert "on a ceiling it comes from behind, through it or past it; set sun_lux: 0" in told
