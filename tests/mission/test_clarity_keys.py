"""Keys of a scene that say how far one sees: which may stand together, what is told where they may not."""

from __future__ import annotations

from typing import Any

import pytest

from uwopt.errors import MissionError
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.mission import load_mission
from uwopt.mission.templates import mission_json_schema

KEYS = {"c_per_m": 0.4, "visibility_m": 12.0, "secchi_m": 10.0, "turbidity_ntu": 0.3}


def mission(**scene: Any) -> dict[str, Any]:
    return {
        "practice": "bare", "scene": {"seafloor": "sand", "depth_m": 30, **scene},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5},
    }


def message_of(**scene: Any) -> str:
    with pytest.raises(MissionError) as caught:
        check_physical(load_mission(mission(**scene)))
    return str(caught.value)


@pytest.mark.parametrize("key", KEYS)
def test_one_reading_takes_the_place_of_the_type(key: str):
    scene = load_mission(mission(**{key: KEYS[key]})).scenes[0]
    assert scene.water is None
    assert scene.clarity == (key, KEYS[key])


def test_a_type_alone_is_no_reading():
    assert load_mission(mission(water="II")).scenes[0].clarity is None


def test_a_type_may_stand_beside_a_reading():
    scene = load_mission(mission(water="3C", c_per_m=0.4)).scenes[0]
    assert (scene.water, scene.clarity) == ("3C", ("c_per_m", 0.4))


def test_a_scene_without_any_water_is_told_what_it_may_give():
    said = message_of()
    assert said.startswith("mission: scene.water is missing; give the Jerlov type (I, IA,")
    assert all(key in said for key in KEYS)
    assert len(said.splitlines()) == 1


def test_a_wrong_water_is_not_missing_too():
    assert "missing" not in message_of(water="XI")


def test_of_two_readings_the_better_known_is_kept():
    said = message_of(secchi_m=10.0, visibility_m=12.0)
    assert "scene.secchi_m and visibility_m are both given; keep visibility_m" in said


def test_a_profile_of_ones_own_says_all():
    said = message_of(water="harbour.csv", visibility_m=12.0)
    assert "scene.water = 'harbour.csv' says all of this water; leave out visibility_m" in said


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [("visibility_m", 200, "scene.visibility_m = 200 is above 80; give the farthest distance"),
     ("turbidity_ntu", 400, "scene.turbidity_ntu = 400 is above 15; give the turbidity"),
     ("c_per_m", 0.01, "scene.c_per_m = 0.01 is below 0.055; give the beam attenuation"),
     ("secchi_m", 0.1, "scene.secchi_m = 0.1 is below 0.4; give the Secchi depth")],
)  # fmt: skip
def test_beyond_the_range_of_the_relation_one_message_tells_it(key: str, value: float, said: str):
    told = message_of(**{key: value})
    assert said in told
    assert len(told.splitlines()) == 1


def test_a_type_that_cannot_hold_so_many_particles_is_told():
    said = message_of(water="I", turbidity_ntu=3.0)
    assert "scene 'scene 1': turbidity_ntu = 3 NTU takes more than 10 times the particles" in said
    assert "name a murkier type, or none" in said


def test_another_unit_is_understood():
    assert "the key is visibility_m" in message_of(visibility_ft=40.0)


def test_the_schema_asks_for_one_of_them():
    asked = mission_json_schema()["$defs"]["Scene"]["anyOf"]
    assert [one["required"][0] for one in asked] == ["water", *KEYS]
