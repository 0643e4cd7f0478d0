"""Reserves and refusals: what is asked, what is held, and how far apart they are."""

import pytest

from uwopt.errors import MissionError
from uwopt.mission.mission import load_mission
from uwopt.mission.reserves import asked_when_held

BASE = {
    "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 40},
    "vehicle": {"altitude_m": 2, "speed_m_s": 0.5},
}
WANTED = {"min_snr_db": 30, "max_blur_px": 1.0, "min_swath_m": 2.0, "min_dof_m": 0.5, "overlap": 0.5}
FULL = {"snr_db": 3.0, "blur": 0.2, "swath": 0.1, "dof": 0.1, "depth": 1.25}
#: By hand: 30 + 3 dB, 1 px less a fifth, 2 m and a tenth, 0.5 m and a tenth.
HELD = {"min_snr_db": 33.0, "max_blur_px": 0.8, "min_swath_m": 2.2, "min_dof_m": 0.55}


def mission(wanted=None, **more):
    return load_mission({**BASE, "requirements": WANTED if wanted is None else wanted, **more})


def message_of(**given):
    with pytest.raises(MissionError) as caught:
        mission(**given)
    return str(caught.value)


def test_without_a_reserve_what_is_asked_is_held():
    view = mission().views[0]
    assert view.requirements == view.asked
    assert mission().required_depth_m == 40


@pytest.mark.parametrize(("key", "held"), HELD.items())
def test_a_reserve_tightens_what_is_held(key, held):
    view = mission(reserve=FULL).views[0]
    assert getattr(view.requirements, key) == pytest.approx(held, rel=1e-12)
    assert getattr(view.asked, key) == WANTED[key]
    assert view.kept(key) == pytest.approx(abs(held - WANTED[key]), rel=1e-12)


@pytest.mark.parametrize(("key", "held"), HELD.items())
def test_taking_the_reserve_off_gives_what_was_asked(key, held):
    assert asked_when_held(mission(reserve=FULL).reserve, key, held) == pytest.approx(WANTED[key], rel=1e-12)


def test_a_reserve_in_decibels_multiplies_a_ratio():
    # 20 dB are a factor of 10
    view = mission({"min_snr": 7.0}, reserve={"snr_db": 20}).views[0]
    assert view.requirements.min_snr == pytest.approx(70.0)
    assert view.kept("min_snr_db") == pytest.approx(20.0)


def test_the_reserve_of_signal_to_noise_is_kept_of_red_too():
    view = mission({"min_snr_red_db": 12}, reserve={"snr_db": 3}).views[0]
    assert (view.requirements.min_snr_red_db, view.kept("min_snr_red_db")) == (15.0, 3.0)


def test_what_is_not_asked_has_no_reserve():
    view = mission({}, reserve="recommended").views[0]
    assert view.requirements == view.asked.model_copy(update={"max_gain_db": 12.0})
    assert [view.kept(key) for key in HELD] == [0.0] * len(HELD)


def test_a_scene_that_asks_for_more_keeps_the_reserve_of_that():
    scenes = [{**BASE["scene"], "name": "a"}, {**BASE["scene"], "name": "b", "min_snr_db": 34}]
    made = load_mission(
        {
            "practice": "bare", "scenes": scenes, "vehicle": BASE["vehicle"], "requirements": WANTED,
            "reserve": {"snr_db": 3},
        }
    )
    assert [view.requirements.min_snr_db for view in made.views] == [33.0, 37.0]


def test_the_word_recommended_gives_the_recommended_values():
    # issue of the project: 3 dB, 20 % of the blur, 10 % of swath and depth of field, 1.25 in depth, 3 degrees
    others = {"tilt_deg": 3.0, "max_gain_db": 12.0, "energy": 0.2}
    assert mission(reserve="recommended").reserve.model_dump() == {**FULL, **others}


@pytest.mark.parametrize(
    ("given", "needed"),
    [
        ({"reserve": {"depth": 1.25}}, 50.0),
        ({"reserve": {"depth": 1.25}, "limits": {"depth_rating_m": 100}}, 100.0),  # a rating has its own margin
        ({"wanted": {"refuse": "depth"}}, 44.0),
        ({"wanted": {"refuse": "depth"}, "reserve": {"depth": 1.25}}, 50.0),
        ({"wanted": {"refuse": "depth"}, "reserve": {"depth": 1.0}}, 40.0),  # what is given decides
        ({"wanted": {"refuse": "depth"}, "reserve": {"blur": 0.1}}, 44.0),
    ],
)
def test_depth_rating_is_asked_for_with_its_reserve(given, needed):
    made = mission(**given)
    assert made.required_depth_m == pytest.approx(needed)
    assert made.with_changes(physics="paper").required_depth_m == pytest.approx(needed)


def test_a_mission_read_from_its_own_values_keeps_its_depth():
    made = mission(wanted={"refuse": "depth"})
    assert load_mission(made.to_dict()).required_depth_m == pytest.approx(44.0)


def test_one_scene_may_refuse_for_the_whole_system():
    scenes = [{**BASE["scene"], "name": "a"}, {**BASE["scene"], "name": "b", "refuse": ["depth"]}]
    made = load_mission({"practice": "bare", "scenes": scenes, "vehicle": BASE["vehicle"]})
    assert made.required_depth_m == pytest.approx(44.0)


@pytest.mark.parametrize(
    ("word", "key", "value"),
    [
        ("airy", "max_airy_px", 2), ("skew", "max_skew_px", 2), ("swath", "min_swath_m", 1),
        ("white_balance", "max_white_balance", 4),
    ],
)  # fmt: skip
def test_a_refusal_stands_for_a_requirement_that_is_not_given(word, key, value):
    wanted = {"overlap": 0.5}
    assert getattr(mission({**wanted, "refuse": [word]}).views[0].requirements, key) == value
    assert getattr(mission({**wanted, "refuse": "all"}).views[0].requirements, key) == value
    assert getattr(mission({**wanted, "refuse": [word], key: 7}).views[0].requirements, key) == 7
    assert getattr(mission(wanted).views[0].requirements, key) is None


def test_a_narrow_swath_is_refused_in_a_survey_alone():
    assert mission({"refuse": ["swath"]}).views[0].requirements.min_swath_m is None  # no overlap
    still = {**BASE, "vehicle": {"altitude_m": 2, "speed_m_s": 0}}
    wanted = {"overlap": 0.5, "frame_interval_s": 1, "refuse": ["swath"]}
    assert load_mission({**still, "requirements": wanted}).views[0].requirements.min_swath_m is None


def test_who_works_near_is_refused_no_swath_that_is_wider_than_far():
    near = {**BASE, "vehicle": {"altitude_m": 0.6, "altitude_tolerance_m": 0.2, "speed_m_s": 0.3}}
    wanted = {"overlap": 0.5, "refuse": ["swath"]}
    assert load_mission({**near, "requirements": wanted}).views[0].requirements.min_swath_m == pytest.approx(0.4)
    given = {**wanted, "min_swath_m": 1.5}
    assert load_mission({**near, "requirements": given}).views[0].requirements.min_swath_m == 1.5


def test_what_a_file_says_comes_back_without_the_reserve():
    data = mission(reserve="recommended").to_dict()
    assert data["requirements"]["min_snr_db"] == 30
    assert data["reserve"]["snr_db"] == 3
    assert load_mission(data).views[0].requirements.min_snr_db == 33


@pytest.mark.parametrize(
    ("given", "piece"),
    [
        ({"reserve": "high"}, "reserve = 'high' is not one of recommended; or give keys such as {snr_db: 3"),
        ({"reserve": {"blur": 20}}, "reserve.blur = 20 is above 0.9"),
        ({"reserve": {"depth": 0.8}}, "reserve.depth = 0.8 is below 1"),
        ({"reserve": {"snr": 3}}, "reserve.snr is unknown; the key is snr_db"),
        ({"wanted": {"refuse": ["airi"]}}, "is not one of airy, skew, swath, depth, lamp, white_balance, all; did you"),
        ({"wanted": {"lens_stop_down": -1}}, "requirements.lens_stop_down = -1 is below 0"),
    ],
)
def test_faults_are_told(given, piece):
    assert piece in message_of(**given)
