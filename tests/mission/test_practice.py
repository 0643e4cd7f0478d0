"""`practice: recommended` fills in what a mission leaves out, and nothing that it says."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest

from uwopt.errors import MissionError
from uwopt.mission.keys import Refusal
from uwopt.mission.mission import Mission, load_mission, mission_sections
from uwopt.mission.practice import RECOMMENDED_KEYS, with_practice
from uwopt.mission.reserves import RECOMMENDED_RESERVE, Reserve
from uwopt.mission.yielding import with_yields, yields_of


def mission(practice: str | None = None, **given: dict[str, Any]) -> Mission:
    """A survey that says the least a mission must."""
    plain: dict[str, Any] = {
        "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5},
        "requirements": {"overlap": 0.6, "min_snr_db": 20},
    }
    for section, keys in given.items():
        plain[section] = {**plain.get(section, {}), **keys}
    return load_mission(plain if practice is None else {"practice": practice, **plain})


@pytest.mark.parametrize("practice", [None, "recommended", " Recommended"])
def test_good_practice_is_asked_for_unless_a_mission_says_otherwise(practice: str | None) -> None:
    made = mission(practice)
    asked = made.requirements
    assert (asked.snr_at, asked.dof_at, asked.lens_stop_down, asked.min_uniformity) == ("worst", "corner", 1.0, 0.3)
    assert asked.min_mtf_half_nyquist == 0.3
    assert set(asked.refuse) == set(get_args(Refusal))
    assert made.reserve.model_dump() == pytest.approx(RECOMMENDED_RESERVE)
    assert made.catalog.host == "estimate"


def test_without_it_nothing_is_asked_for() -> None:
    made = mission("bare")
    assert (made.requirements.snr_at, made.requirements.lens_stop_down, made.requirements.refuse) == ("mean", 0.0, ())
    assert made.reserve == Reserve()


def test_what_a_mission_says_stays() -> None:
    made = mission(requirements={"snr_at": "mean", "lens_stop_down": 0, "refuse": []}, reserve={"snr_db": 1})
    assert (made.requirements.snr_at, made.requirements.lens_stop_down, made.requirements.refuse) == ("mean", 0.0, ())
    assert made.requirements.dof_at == "corner"
    assert (made.reserve.snr_db, made.reserve.blur) == (1.0, 0.2)  # one key changes one key


def test_a_key_left_empty_is_left_out() -> None:
    assert load_mission({**mission().to_dict(), "practice": None}).practice == "recommended"
    assert mission(requirements={"snr_at": None}).requirements.snr_at == "worst"


@pytest.mark.parametrize(("given", "in_db"), [
    ({"min_snr_db": None}, 20.0), ({"min_snr_db": 6}, 6.0),
    ({"min_snr_db": None, "min_snr": 3.0}, 20.0 * np.log10(3.0)),
])  # fmt: skip
def test_images_are_to_be_of_use_unless_a_mission_says_how_much(given: dict[str, Any], in_db: float) -> None:
    asked = mission(requirements=given).requirements
    assert asked.min_snr is not None
    assert 20.0 * np.log10(asked.min_snr) == pytest.approx(in_db)
    assert mission("bare", requirements={"min_snr_db": None}).requirements.min_snr is None


def test_a_scene_may_ask_for_its_own_ratio() -> None:
    scene = {"name": "a", "water": "II", "seafloor": "sand", "depth_m": 20}
    plain = {
        "scenes": [{**scene, "requirements": {"min_snr": 3.0}}, {**scene, "name": "b"}],
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5}, "requirements": {"overlap": 0.6},
    }
    assert [view.asked.min_snr for view in load_mission(plain).views] == [pytest.approx(3.0), pytest.approx(10.0)]


def test_an_snr_of_good_practice_gives_way_to_what_is_still_seen() -> None:
    filled, said = mission(requirements={"min_snr_db": None}), mission(requirements={"min_snr_db": 20})
    assert {one.instead for one in yields_of(filled) if one.key == "min_snr_db"} == {14.0}
    assert all(one.key != "min_snr_db" for one in yields_of(said))
    assert with_yields(filled, yields_of(filled)).requirements.min_snr_db == 14.0


def test_where_no_lamp_is_allowed_none_must_shine_evenly() -> None:
    dark = mission(vehicle={"light_count": 0}, scene={"water": "II", "seafloor": "sand", "depth_m": 5, "sun_lux": 1e5})
    assert dark.requirements.min_uniformity is None


def test_a_computer_among_the_extras_is_not_counted_twice() -> None:
    assert mission(catalog={"extras": [{"name": "computer", "power_w": 8}]}).catalog.host == "none"


@pytest.mark.parametrize(("interval_s", "lamps", "camera"), [(2, "on", "on"), (10, "off", "on"), (3600, "off", "off")])
def test_what_waits_long_between_images_is_switched_off(interval_s: float, lamps: str, camera: str) -> None:
    carried = mission(requirements={"frame_interval_s": interval_s}).vehicle
    assert (carried.lamps_between_images, carried.camera_between_images) == (lamps, camera)


def test_each_scene_is_switched_off_by_its_own_interval() -> None:
    """A lander with an image a minute of bait, in a scene of its own, kept camera and computer on: 291 Wh, not 201."""
    place = {"water": "IB", "seafloor": 0.2, "depth_m": 30}
    scenes = [
        {**place, "name": "bait", "requirements": {"frame_interval_s": 60}},
        {**place, "name": "visitors", "requirements": {"frame_interval_s": 5}},
        {**place, "name": "slow", "requirements": {"frame_interval_s": 60}, "vehicle": {"camera_between_images": "on"}},
        {**place, "name": "any"},
    ]
    vehicle = {"altitude_m": 2.0, "speed_m_s": 0.1}

    def switched(common: dict[str, Any], **more: Any) -> list[tuple[str, str]]:
        mission = load_mission({"scenes": scenes, "vehicle": vehicle | more, "requirements": common})
        return [(v.vehicle.lamps_between_images, v.vehicle.camera_between_images) for v in mission.views]

    assert switched({}) == [("off", "off"), ("on", "on"), ("off", "on"), ("on", "on")]
    # what the mission asks of all is off where no scene says otherwise
    assert switched({"frame_interval_s": 3600}) == [("off", "off"), ("on", "on"), ("off", "on"), ("off", "off")]
    assert switched({}, camera_between_images="on") == [("off", "on"), ("on", "on"), ("off", "on"), ("on", "on")]


def test_a_mission_with_all_filled_in_comes_back() -> None:
    made = mission()
    assert load_mission(made.to_dict()).to_dict() == made.to_dict()


def test_a_loaded_mission_can_be_asked_for_good_practice() -> None:
    changed = mission("bare", requirements={"dof_at": "axis"}).with_changes(practice="recommended")
    assert (changed.requirements.snr_at, changed.requirements.dof_at) == ("worst", "axis")
    assert changed.vehicle.lamp_supply == "external"


def test_each_key_that_is_filled_in_says_that_it_is_recommended() -> None:
    for section, keys in RECOMMENDED_KEYS.items():
        for key in keys:
            assert "recommended" in (mission_sections()[section].model_fields[key].description or ""), key


def test_another_word_is_told_with_those_there_are() -> None:
    with pytest.raises(MissionError, match=r"practice.*recommended"):
        mission("best")


def test_band_of_altitudes_is_sharp_unless_something_is_said() -> None:
    band: dict[str, Any] = {"scene": {"water": "II", "depth_m": 30.0}, "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5}}
    still, moved = with_practice(band), dict(band, vehicle=band["vehicle"] | {"altitude_tolerance_m": 0.25})
    assert "min_dof_m" not in still["requirements"]
    assert with_practice(moved)["requirements"]["min_dof_m"] == 0.0
    assert with_practice(moved | {"requirements": {"min_dof_m": 0.6}})["requirements"]["min_dof_m"] == 0.6
    assert "min_dof_m" not in with_practice(moved | {"practice": "bare"}).get("requirements", {})
    scenes = [{"name": "a", "vehicle": {"altitude_tolerance_m": 0.5}}]
    assert with_practice(band | {"scenes": scenes})["requirements"]["min_dof_m"] == 0.0
