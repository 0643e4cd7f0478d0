"""Good practice that nothing meets in full gives way, as little as possible, and what a mission says itself never."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
import yaml
from thorough import drawn

import uwopt
from uwopt.api import certain_points, certainty, explaining, trading, varied_work, yielding
from uwopt.api.certain_points import CertainPoints, gives_way_with_certainty
from uwopt.api.choosing import chosen_of, surer
from uwopt.api.practice_known import PracticeKnown
from uwopt.api.risks.told import risks_of
from uwopt.api.searching import Searches
from uwopt.api.varied_work import Work
from uwopt.api.watch import Watch
from uwopt.api.whatif import full_practice_notes
from uwopt.api.yielding import YieldTrials, gives_way_alone, patience_of, with_room, yield_notes
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.mission.mission import load_mission
from uwopt.mission.strictness import Asking
from uwopt.mission.yielding import (
    FRAME_LESS_DB,
    YIELDS,
    gave_way_between,
    with_yields,
    yields_named,
    yields_of,
)
from uwopt.objectives.goal import goal_of
from uwopt.quantities import AT_LIKELIEST
from uwopt.report.compare.rows import sentences
from uwopt.report.page.page import opening, status_words
from uwopt.report.text.explanation import explanation_blocks
from uwopt.report.text.layout import Block
from uwopt.report.text.opening import GAVE_WAY, verdict_lines
from uwopt.report.text.short import nothing_blocks
from uwopt.report.text.verdict import verdict
from uwopt.report.write import SOLVED_FILE, system_yaml, write_results
from uwopt.results.basis import WhyNothing
from uwopt.results.design import PRACTICE_IN_VAIN, PRACTICE_MISSED, PRACTICE_WOULD_YIELD, PRACTICE_YIELDS
from uwopt.results.whatif import WhatIfPoint
from uwopt.solvers.confidence import search
from uwopt.solvers.exact.search import Search
from uwopt.solvers.infeasible import moves
from uwopt.solvers.infeasible import why_nothing as infeasible
from uwopt.sweeps.inputs import job_of
from uwopt.sweeps.job import SweepTask, SweepWays
from uwopt.sweeps.rows import with_practice_held
from uwopt.sweeps.work import SweepWorker

HARDWARE = {
    "cameras": ["flir-bfs-u3-120s4m"], "lenses": ["kowa-lm8h*", "kowa-lm8x*"],
    "ports": ["blue-robotics-4-in-dome-plastic*", "generic-dome-bk7-100*"],
    "lights": ["generic-lamp-flood-20000lm"],
    "generic": "allow", "host": "none", "rest": "none", "housing": "none", "spacers": "none",
}  # fmt: skip
RESERVE = {"depth": 1.0, "tilt_deg": 0.0}


def survey(min_snr_db: float, **more: Any) -> dict[str, Any]:
    """One lamp over a floor, with good practice in its reserves alone."""
    return {
        "practice": "recommended", "confidence": "central", "physics": "paper",
        "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "light_count": 1, "lamp_supply": "any"},
        "requirements": {
            "overlap": 0.3, "max_blur_px": 1.0, "min_snr_db": min_snr_db, "snr_at": "mean", "dof_at": "axis",
            "lens_stop_down": 0.5, "min_uniformity": 0, "refuse": [], "min_mtf_half_nyquist": 0,
        },
        "catalog": HARDWARE, "reserve": RESERVE | more,
    }  # fmt: skip


def reached_db(mission: dict[str, Any]) -> float:
    """The best signal to noise of a mission, with nothing told beside it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("uwopt.api.solving.doubted", lambda made, *given: made)
        return float(uwopt.solve(mission | {"objective": "snr_db"}, top=1, quick=True).objective.value or 0.0)


@cache
def brightest_db() -> float:
    """What the hardware reaches with the other reserves kept."""
    return round(reached_db(survey(0.0, snr_db=0.0, max_gain_db=None)), 2)


@pytest.fixture
def unexplained(monkeypatch: pytest.MonkeyPatch) -> None:
    """Do not ask what would help where nothing fits: that has tests of its own, and takes longer than the search."""
    monkeypatch.setattr(infeasible, "why_nothing", lambda *given: WhyNothing([], [], None))


@dataclass(frozen=True)
class Told:
    """An answer, what was shown before its doubts, and the words of who waited."""

    result: Any
    shown: list[Any]
    words: list[str]


@cache
def solved(less_db: float) -> Told:
    """The survey of so much less signal to noise than the hardware reaches, solved once for all that look at it."""
    shown: list[Any] = []
    words: list[str] = []
    asked = survey(brightest_db() - less_db)
    progress = lambda share, what: words.append(what)  # noqa: E731 - a line long
    return Told(uwopt.solve(asked, top=1, quick=True, first=shown.append, progress=progress), shown, words)


def given_way(result: Any) -> list[str]:
    """The keys that are told to have given way."""
    return [note.path for note in result.warnings if note.code == PRACTICE_YIELDS]


def test_a_reserve_that_nothing_keeps_gives_way_and_is_told_first() -> None:
    result = solved(1.0).result  # 1 dB is there, 3 dB are to be kept
    assert given_way(result) == ["reserve.snr_db"]
    assert result.mission["reserve"]["snr_db"] == 0.0 and result.mission["reserve"]["blur"] == 0.2
    assert risks_of(result)[0].what.startswith("nothing meets all of good practice; what was relaxed: no reserve on")


@pytest.mark.usefixtures("undoubted")
def test_the_mission_as_solved_answers_the_same_without_a_search_for_what_gives_way(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "survey.yaml"
    file.write_text(yaml.safe_dump(survey(brightest_db() - 1.0)), "utf-8")
    first = uwopt.solve(file, top=1, quick=True)
    assert first.mission_as_solved is not None and "snr_db: 0.0" in first.mission_as_solved
    written = write_results(first, tmp_path / "out")
    assert (tmp_path / "out" / SOLVED_FILE) in written
    monkeypatch.setattr("uwopt.api.solving.gives_way", None)
    again = uwopt.solve(tmp_path / "out" / SOLVED_FILE, top=1, quick=True)
    assert again.recommendation is not None and again.recommendation == first.recommendation
    assert again.mission == first.mission and again.mission_as_solved is None and given_way(again) == []
    assert (tmp_path / "out" / SOLVED_FILE) not in write_results(again, tmp_path / "out")
    assert not (tmp_path / "out" / SOLVED_FILE).exists()  # that of the earlier run


def test_nobody_reads_on_without_knowing_that_practice_gave_way() -> None:
    for told in (solved(1.0).result, solved(1.0).shown[0]):  # and before its doubts
        assert next(line.plain for line in verdict_lines(told)) == GAVE_WAY
        assert opening(told)[0].endswith(GAVE_WAY) and status_words(told)[1] == "warn"
    kept = solved(4.0).result
    assert GAVE_WAY not in opening(kept)[0] and status_words(kept)[1] == "good"


def at_depth(depth_m: float, min_snr_db: float = 20.0, **more: Any) -> dict[str, Any]:
    """The survey there, with practice's reserve of depth."""
    asked = survey(min_snr_db)
    return asked | {"scene": {**asked["scene"], "depth_m": depth_m}, "reserve": {"tilt_deg": 0.0}, **more}


@pytest.mark.parametrize(("less_db", "also"), [(6.0, []), (1.0, ["reserve.snr_db"])], ids=["alone", "with light"])
def test_nobody_is_kept_from_6000_m_by_a_reserve_that_no_part_has(less_db: float, also: list[str]) -> None:
    """Dome and lamp are rated to 6000 m, and 7500 m are not made. What fits at 6000 m tells nothing of those."""
    result = uwopt.solve(at_depth(6000.0, brightest_db() - less_db), top=1, quick=True)
    assert given_way(result) == [", ".join([*also, "reserve.depth"])] and result.mission["reserve"]["depth"] == 1.0
    assert "no reserve on depth" in risks_of(result)[0].what
    stand = next(one for one in risks_of(result) if "pressure" in one.what)
    assert stand.figure == "6 000 m against 6 000 m"


@pytest.mark.parametrize(
    ("asked", "may"),
    [
        (at_depth(4800.0), False),  # 6000 m are made
        (at_depth(4801.0), True),
        (at_depth(6000.0), True),
        (at_depth(6001.0), False),  # nor are they enough
        (at_depth(6000.0, limits={"depth_rating_m": 6000.0}), False),  # a rating has a reserve of its own
        (at_depth(6000.0, reserve={"depth": 1.25, "tilt_deg": 0.0}), False),
    ],
    ids=["4800 m", "4801 m", "6000 m", "6001 m", "rating", "stated"],
)
def test_the_reserve_of_depth_gives_way_only_where_no_part_could_have_it(asked: dict[str, Any], may: bool) -> None:
    assert ("reserve.depth" in {one.path for one in yields_of(load_mission(asked))}) == may


def test_what_is_kept_does_not_give_way() -> None:
    assert given_way(solved(4.0).result) == []


def test_a_system_is_told_whether_good_practice_is_all_that_it_misses() -> None:
    asked = survey(brightest_db() - 1.0)
    recommended = yaml.safe_load(system_yaml(solved(1.0).result))
    (note,) = (note for note in uwopt.evaluate(asked, recommended).warnings if note.code == PRACTICE_MISSED)
    assert note.message.startswith("what the mission itself says is met")
    for other in (survey(brightest_db() + 1.0), asked | {"practice": "bare"}, survey(brightest_db() - 4.0)):
        told = [note.code for note in uwopt.evaluate(other, recommended).warnings]
        assert PRACTICE_MISSED not in told


def test_what_is_recommended_is_compared_by_what_is_held_of_it() -> None:
    asked = survey(brightest_db() - 1.0)
    recommended = yaml.safe_load(system_yaml(solved(1.0).result))
    made = uwopt.compare(asked, [recommended], recommended=True)
    assert [one.design.feasible for one in made.systems] == [True, True]
    assert "no reserve on signal to noise" in next(sentences(made))


@pytest.mark.usefixtures("unexplained")
def test_what_a_mission_says_itself_does_not_give_way() -> None:
    result = uwopt.solve(survey(brightest_db() - 1.0, snr_db=2.0, blur=0.1, swath=0.2, dof=0.2), top=1, quick=True)
    assert result.status == "infeasible" and result.infeasible is not None


@pytest.mark.usefixtures("unexplained")
def test_an_explanation_tells_of_good_practice_in_full() -> None:
    result = uwopt.solve(survey(brightest_db() - 1.0), top=1, quick=True, every_price=True)
    assert result.status == "infeasible"


def test_a_white_balance_of_its_own_keeps_a_mission_from_yielding_that_of_practice() -> None:
    mission = survey(20.0)
    del mission["requirements"]["refuse"]
    for own, may in (({}, True), ({"max_white_balance": 3.0}, False)):
        asked = load_mission(mission | {"requirements": mission["requirements"] | own})
        assert ("refuse" in {one.key for one in yields_of(asked)}) == may


def test_bare_missions_have_nothing_that_gives_way() -> None:
    assert yields_of(load_mission(survey(20.0) | {"practice": "bare"})) == ()


@pytest.mark.usefixtures("unexplained")
def test_nobody_is_told_of_practice_that_was_not_asked_for() -> None:
    lines: list[str] = []
    for practice in ("bare", "recommended"):
        uwopt.solve(survey(brightest_db() + 20.0) | {"practice": practice}, top=1, quick=True, so_far=lines.append)
        assert bool(lines) == (practice == "recommended")


@pytest.mark.parametrize("one", YIELDS, ids=lambda one: one.path)
def test_each_key_gives_way_alone(one: Any) -> None:
    """The weaker mission asks for less of that key, and is otherwise the same."""
    deep = {"scene": {"water": "II", "seafloor": 0.2, "depth_m": 6000}}
    plain = {key: value for key, value in survey(20.0).items() if key not in ("reserve", "physics")}
    carried = plain["vehicle"] | {"duration_h": 10, "battery_wh": 500, "supply": "battery"}
    full = load_mission(plain | deep | {"requirements": {"overlap": 0.3, "min_swath_m": 1}, "vehicle": carried})
    assert one in yields_of(full)
    weaker = with_yields(full, [one])
    gone = {other.path for other in set(yields_of(full)) - set(yields_of(weaker))}
    assert gone == {one.path} | ({"requirements.snr_at_less_db"} if one.key == "snr_at" else set())
    least_db = one.instead if one.key == "min_snr_db" else 20.0
    assert weaker.practice == "recommended" and weaker.requirements.min_snr_db == least_db


def sharp_over(dof_m: float, **refused: Any) -> dict[str, Any]:
    """The survey sharp over so much, by a sensor of pixels of 1.85 um, with nothing in reserve."""
    mission = survey(10.0, snr_db=0.0, blur=0.0, swath=0.0, dof=0.0)
    del mission["requirements"]["refuse"]
    mission["requirements"] |= {"min_dof_m": dof_m, "circle_of_confusion_px": 2.0, "max_skew_px": 100.0} | refused
    return mission


def test_diffraction_gives_way_to_what_must_be_sharp() -> None:
    """Behind the f-number that a depth of field needs the Airy disc, 2.44 times the wavelength times that, is wider."""
    assert gives_way_alone(load_mission(sharp_over(1.0)), NEVER).yields[0].as_held == "requirements.max_airy_px = 4"
    for stated in ({"refuse": "all"}, {"max_airy_px": 2.0}):
        assert not gives_way_alone(load_mission(sharp_over(1.0, **stated)), NEVER).yields  # the mission says it itself
    result = uwopt.solve(sharp_over(1.0), top=1, quick=True)
    assert given_way(result) == ["requirements.max_airy_px"] and result.recommendation is not None
    f_number = result.recommendation.scenes[0].settings["f_number"]
    assert 2.0 < 2.44 * 0.53 * f_number / 1.85 <= 4.0


def on_battery(battery_wh: float | None = None) -> dict[str, Any]:
    """A survey of ten hours on a battery of the system's own, of which alone good practice keeps something."""
    mission = survey(brightest_db() - 4.0, snr_db=0.0, blur=0.0, swath=0.0, dof=0.0)
    own = {} if battery_wh is None else {"duration_h": 10.0, "battery_wh": battery_wh, "supply": "battery"}
    return mission | {"vehicle": mission["vehicle"] | own}


@pytest.mark.usefixtures("undoubted")
@pytest.mark.parametrize(("share", "gone"), [(0.79, []), (0.81, ["reserve.energy"]), (0.99, ["reserve.energy"])])
def test_a_fifth_of_a_battery_stays_unused_unless_nothing_fits_so(share: float, gone: list[str]) -> None:
    """A battery that the survey used up to its last watt hour was recommended."""
    least_w = uwopt.solve(on_battery(), top=1, quick=True).certificate
    assert least_w is not None
    battery_wh = 10.0 * least_w.best_value / share
    result = uwopt.solve(on_battery(battery_wh), top=1, quick=True)
    assert given_way(result) == gone and result.best is not None
    (margin,) = (one for one in result.best.margins if one.requirement == "energy_wh")
    assert (margin.limit, margin.asked) == pytest.approx((battery_wh * (1.0 if gone else 0.8), battery_wh))


def test_a_battery_that_the_vehicle_carries_has_no_reserve_that_could_give_way() -> None:
    mission = on_battery(100.0)
    supplied = ({"vehicle": mission["vehicle"] | {"supply": supply}} for supply in ("battery", "vehicle"))
    own, other = ({one.path for one in yields_of(load_mission(mission | vehicle))} for vehicle in supplied)
    assert own - other == {"reserve.energy"} and not other - own


def test_a_front_of_what_gives_way_says_so() -> None:
    """The same practice gives way as for its best system."""
    mission = survey(brightest_db() - 1.0)
    front = uwopt.pareto(mission, objectives=["power", "cost"], solver="exact")
    assert given_way(front) == ["reserve.snr_db"] and front.mission["reserve"]["snr_db"] == 0.0
    assert "not all of good practice is kept" in verdict(front)[1].lower()
    best = solved(1.0).result.objective.value
    assert min(point.values["power"] for point in front.points) == pytest.approx(best, rel=1e-6)
    assert given_way(uwopt.pareto(survey(brightest_db() - 4.0), objectives=["power", "cost"], solver="exact")) == []


@pytest.mark.parametrize(("less_db", "gone"), [(1.0, ["reserve.snr_db"]), (-4.0, []), (5.0, [])])
def test_no_front_is_searched_where_nothing_meets_all_of_practice(
    less_db: float, gone: list[str], monkeypatch: pytest.MonkeyPatch, unexplained: None
) -> None:
    """That nothing fits is asked first; what is searched then is the front that is told, whatever has given way."""
    asked: list[float] = []
    build = trading.FrontSearch

    def search(problem: Any, *args: Any, **named: Any) -> Any:
        asked.append(problem.mission.reserve.snr_db)
        return build(problem, *args, **named)

    monkeypatch.setattr(trading, "FrontSearch", search)
    front = uwopt.pareto(survey(brightest_db() - less_db), objectives=["power", "cost"], solver="exact")
    assert given_way(front) == gone and len(asked) == 1
    assert asked[0] == front.mission["reserve"]["snr_db"] == (0.0 if gone else 3.0)
    assert bool(front.points) == (less_db > 0.0)


def test_who_waits_is_told_what_for() -> None:
    """As the command line does: in a process without its bar this stage had no words."""
    assert "what of good practice has to be relaxed" in solved(1.0).words


def test_who_waits_for_settings_is_told_so_and_that_none_fits_yet() -> None:
    """All of a search that was dear was told as "imagers", which are listed in a second."""
    words = solved(1.0).words
    assert words.index("imagers") < words.index("bounds of systems") < words.index("settings of systems, none fits yet")


def over_frame(min_snr_db: float, **asked: Any) -> dict[str, Any]:
    """A survey in all physics of which an SNR is asked over the frame, and nothing is kept in hand.

    Practice asks it, unless `asked` says more of it: then the mission itself does.
    """
    mission = survey(min_snr_db, snr_db=0.0, blur=0.0, swath=0.0, dof=0.0) | {"physics": "full"}
    del mission["requirements"]["snr_at"]
    return mission | {"requirements": mission["requirements"] | ({"snr_at": "worst"} | asked if asked else {})}


@cache
def brightest_mean_db() -> float:
    """What the hardware reaches in all physics, meant over the image."""
    return reached_db(over_frame(0.0, snr_at="mean"))


def test_what_the_frame_reaches_is_told_where_it_is_held() -> None:
    """Over a band of distances the frame is held to its SNR at the worst of them; the figure is of the middle one."""
    margin = SimpleNamespace(requirement="min_snr_db", value=21.2)
    scene = SimpleNamespace(margins=[margin], figures={"snr_db_p05": 25.0})
    winner: Any = SimpleNamespace(as_set=SimpleNamespace(scenes=[scene]))
    for key, told in (("snr_at_less_db", "21.2 dB at the worst"), ("snr_at", "25.0 dB at the middle")):
        (note,) = yield_notes([next(one for one in YIELDS if one.key == key)], winner)
        assert note.message.endswith(f"(95 % of which reach {told} distance)")


@pytest.mark.usefixtures("undoubted")
@pytest.mark.parametrize(("short_of_mean_db", "expected"), [(2.0, 3.0), (0.5, 6.0)])
def test_the_frame_has_as_little_less_than_its_mean_as_will_do(short_of_mean_db: float, expected: float) -> None:
    """Where nothing gives way, the step that is told fits if it is asked for, and the one before does not."""
    asked_db = brightest_mean_db() - short_of_mean_db
    result = uwopt.solve(over_frame(asked_db), top=1, quick=True)
    assert given_way(result) == ["requirements.snr_at_less_db"]
    step = result.mission["requirements"]["snr_at_less_db"]
    before = FRAME_LESS_DB[FRAME_LESS_DB.index(step) - 1] if step > FRAME_LESS_DB[0] else 0.0
    bare = [over_frame(asked_db, snr_at_less_db=less) | {"practice": "bare"} for less in (before, step)]
    fits = [uwopt.solve(one, top=1, quick=True, explain=False).status != "infeasible" for one in bare]
    assert (fits, step) == ([False, True], expected)
    assert result.recommendation is not None
    reached = result.recommendation.as_set.scenes[0].figures
    assert reached["snr_db"] >= asked_db - 1e-6 and reached["snr_db_p05"] >= asked_db - step - 1e-6
    every = result.recommendation.as_set.scenes[0].margins
    (margin,) = [one for one in every if one.requirement == "min_snr_db"]
    told = f"(95 % of which reach {margin.value:.1f} dB at the worst distance)"
    assert f"with {step:g} dB less over the frame {told}" in risks_of(result)[0].what


@pytest.mark.usefixtures("undoubted")
def test_what_fits_by_a_hair_is_not_enough_where_more_room_can_be_had() -> None:
    """3 dB less over the frame fit, by half a decibel; settings come in steps, so that 6 dB less are allowed."""
    asked_db = brightest_mean_db() - 1.2
    just = uwopt.solve(over_frame(asked_db, snr_at_less_db=3.0) | {"practice": "bare"}, top=1, quick=True)
    made = uwopt.solve(over_frame(asked_db), top=1, quick=True)
    assert just.status != "infeasible" and made.mission["requirements"]["snr_at_less_db"] == 6.0


@pytest.mark.parametrize(("can_be_set", "last"), [(True, "reserve.blur"), (False, "requirements.min_uniformity")])
def test_for_room_no_key_gives_way_that_would_after_those_that_have_to_unless_nothing_can_be_set(
    monkeypatch: pytest.MonkeyPatch, can_be_set: bool, last: str
) -> None:
    """Without blur in hand something fits; with a decibel to spare a floor with dark places has to do as well."""
    mission = load_mission({**survey(20.0), "reserve": {}, "requirements": {"overlap": 0.3, "min_snr_db": 20.0}})
    every = yields_of(mission.without_gain_cap)

    def fits(asked: YieldTrials, given_way: Any, part: float = 0.0) -> bool:
        paths, roomy = {one.path for one in given_way}, asked.mission.requirements.min_snr != asks
        return ({"reserve.blur", "requirements.min_uniformity"} if roomy else {"reserve.blur"}) <= paths

    asks = mission.requirements.min_snr
    monkeypatch.setattr(YieldTrials, "fits", fits)
    monkeypatch.setattr(yielding, "_can_be_set", lambda *given: can_be_set)
    made = yielding.gives_way(mission, cast(Any, None), cast(Any, None), NEVER).yields
    assert len(every) > 10 and [one.path for one in made] == ["reserve.blur", last][: 1 if can_be_set else 2]


def test_what_can_be_set_can_be_in_a_mission_that_asks_less(monkeypatch: pytest.MonkeyPatch) -> None:
    known, asked = PracticeKnown(), load_mission(survey(brightest_db() - 1.5, snr_db=0.0))
    like = build_problem(asked, selected(asked, load_catalog(asked), generic="allow"))
    assert yielding._can_be_set(asked, load_catalog(asked), like, NEVER, known)
    monkeypatch.setattr(yielding, "seek", None)
    weaker, stricter = (load_mission(survey(brightest_db() - less_db, snr_db=0.0)) for less_db in (2.0, 1.0))
    assert yielding._can_be_set(weaker, cast(Any, None), like, NEVER, known) and not known.can_be_set(stricter)


@pytest.mark.usefixtures("undoubted")
def test_the_frame_gives_way_though_one_scene_asks_of_its_mean() -> None:
    mission = over_frame(brightest_mean_db() - 2.0)
    scene = mission.pop("scene")
    mission["scenes"] = [scene | {"name": "mosaic"}, scene | {"name": "look", "snr_at": "mean"}]
    assert given_way(uwopt.solve(mission, top=1, quick=True)) == ["requirements.snr_at_less_db"]


@pytest.mark.usefixtures("unexplained", "undoubted")
@pytest.mark.parametrize("key", ["snr_db", "blur"])
def test_what_a_mission_says_itself_never_gives_way(key: str) -> None:
    """A reserve that is written down holds, though practice has the same; another one yields as ever."""
    kept = {"snr_db": 3.0, "blur": 0.2}[key]
    asked = survey(brightest_db() - 1.0, **{key: kept})
    result = uwopt.solve(asked, top=1, quick=True)
    assert given_way(result) == ([] if key == "snr_db" else ["reserve.snr_db"])
    assert (result.status == "infeasible") == (key == "snr_db")
    assert load_mission(asked).with_changes(seed=1).stated >= {f"reserve.{key}", "requirements.min_snr_db"}
    (point, *_) = uwopt.whatif(asked, {"speed_m_s": [0.3, 0.2]}).points
    assert (point.status == "infeasible") == (key == "snr_db")


@pytest.mark.usefixtures("unexplained")
def test_no_more_room_is_kept_than_can_be_asked() -> None:
    result = uwopt.solve(survey(199.5), top=1, quick=True)
    assert result.status == "infeasible" and given_way(result) == []
    assert with_room(load_mission(survey(199.5))) is None  # 200 dB are the most that can be
    roomy = with_room(load_mission(survey(20.0)))
    assert roomy is not None and roomy.requirements.min_snr == pytest.approx(10.0 ** (21.0 / 20.0))


@cache
def brightest_frame_db() -> float:
    """What the hardware reaches in all physics, over the frame."""
    return reached_db(over_frame(0.0))


def in_doubt(**asked: Any) -> dict[str, Any]:
    """A frame in which something fits with all of good practice, but not often: 3 dB are kept in hand."""
    mission = over_frame(brightest_frame_db() - 8.0, **asked) | {"confidence": 0.9}
    return mission | {"reserve": mission["reserve"] | {"snr_db": 3.0}, "doubt": {"scenarios": 64}}


@pytest.mark.usefixtures("undoubted")
def test_practice_gives_way_so_that_what_is_recommended_holds_as_often_as_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The step that is told holds as often if it is asked for; with less, and with all of practice, nothing does."""
    monkeypatch.setattr(search, "FRESH", 128)
    mission, lines, scenes, honest = in_doubt(), list[str](), list[Any](), Searches.of

    def of(self: Any, mission: Any, like: Any = None, scenes_of: Any = None, **how: Any) -> Any:
        scenes.append(like or scenes_of)
        return honest(self, mission, like, scenes_of, **how)

    monkeypatch.setattr(Searches, "of", of)
    result = uwopt.solve(mission, top=1, quick=True, so_far=lines.append)
    at_likeliest, with_all, proven = lines  # who waits reads what is known as soon as it is
    assert at_likeliest.startswith(f"best {AT_LIKELIEST}: ") and proven.startswith("proven best: ")
    share = re.search(r"it holds in (\d+) % of the scenarios, 90 % are asked", with_all)
    assert share is not None and float(share[1]) < 90
    assert given_way(result) == ["requirements.snr_at_less_db"] and result.confidence is not None
    assert result.confidence.enough and "good practice as often as is asked; " in risks_of(result)[0].what
    assert scenes[0] is None and len(scenes) > 1 and None not in scenes[1:]  # light is worked out once
    step = result.mission["requirements"]["snr_at_less_db"]
    before = FRAME_LESS_DB[FRAME_LESS_DB.index(step) - 1]
    held = []
    for less in (before, step):  # and if it does not hold with less, it does not with all of practice
        known = uwopt.solve(in_doubt(snr_at_less_db=less) | {"practice": "bare"}, top=1, quick=True).confidence
        held.append(known is not None and known.enough)
    assert held == [False, True]


def test_a_table_with_certainty_lets_give_way_what_holds_as_often_not_only_what_fits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mission, first = load_mission(survey(20.0)), YIELDS[:1]
    found = SimpleNamespace(proves_nothing_fits=False, fits=True, cut=False, given_way=())
    monkeypatch.setattr(certain_points.Searches, "of", lambda *_: found)
    monkeypatch.setattr(certain_points, "chosen_of", lambda *_: None)
    made = SimpleNamespace(given_way=first, to_hold=True, cut=False)
    monkeypatch.setattr(certain_points, "held_by_yielding", lambda *_: made)
    assert gives_way_with_certainty(mission, NEVER) == (first, True, False)
    made.cut = True
    with pytest.raises(KeyboardInterrupt):
        gives_way_with_certainty(mission, NEVER)


def test_a_table_with_certainty_begins_again_with_what_gives_way_in_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a point holds less often than is asked, though something fits."""
    frame = next(one for one in YIELDS if one.key == "snr_at_less_db")
    asked: list[float] = []

    def point(self: Any, values: Any, mission: Any) -> WhatIfPoint:
        asked.append(mission.requirements.snr_at_less_db)
        status = "optimal" if asked[-1] else "infeasible"
        return WhatIfPoint(list(values), status, figures={"held": 0.5})

    monkeypatch.setattr(CertainPoints, "point", point)
    monkeypatch.setattr(certain_points, "gives_way_with_certainty", lambda *_: ((frame,), True, False))
    table = uwopt.whatif(in_doubt(), {"speed_m_s": [0.2, 0.3]}, confidence=0.9)
    assert asked == [0.0, 3.0, 3.0] and table.gave_way == ["requirements.snr_at_less_db"]
    assert "as often as is asked" in next(note.message for note in table.warnings if note.code == PRACTICE_YIELDS)
    held = uwopt.whatif(in_doubt(), {"speed_m_s": [0.2, 0.3]}, confidence=0.9, hold_practice=True)
    assert not held.gave_way and {point.status for point in held.points} == {"infeasible"}


def test_all_waters_of_a_table_begin_again_where_practice_gives_way_in_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else its waters would be asked for different things."""
    frame = next(one for one in YIELDS if one.key == "snr_at_less_db")
    asked: list[tuple[Any, ...]] = []

    def point(self: Any, values: Any, mission: Any) -> WhatIfPoint:
        less_db = mission.requirements.snr_at_less_db
        asked.append((*values, less_db))
        return WhatIfPoint(list(values), "optimal" if less_db or values[1] == "I" else "infeasible", objective=less_db)

    monkeypatch.setattr(CertainPoints, "point", point)
    monkeypatch.setattr(certain_points, "gives_way_with_certainty", lambda *_: ((frame,), True, False))
    table = uwopt.whatif(in_doubt(), {"speed_m_s": [0.2, 0.3], "water": ["I", "II"]}, confidence=0.9)
    assert table.gave_way == ["requirements.snr_at_less_db"]
    assert [point.objective for point in table.points] == [3.0] * 4
    kept, given = [one[:2] for one in asked if not one[2]], [one[:2] for one in asked if one[2]]
    assert sorted(kept) == [(0.2, "I"), (0.2, "II"), (0.3, "I")] and len(given) == 4


@pytest.mark.parametrize(("held", "taken"), [(0.9, True), (0.71, True), (0.69, False)])
def test_practice_does_not_give_way_for_less_than_half_of_what_is_short(held: float, taken: bool) -> None:
    first, other = (
        cast(Any, SimpleNamespace(counted=SimpleNamespace(asked=0.9, held=share, enough=share >= 0.9)))
        for share in (0.5, held)
    )
    assert (surer(first, other) is other) is taken


def test_a_table_lets_give_way_at_every_point_what_the_mission_as_it_stands_needs():
    """So that the point of the mission as it stands is what `solve` answers, and its neighbours are asked the same."""
    asked_db = round(brightest_db() - 1.0, 2)  # 3 dB in hand are too much
    alone = solved(1.0).result
    table = uwopt.whatif(survey(asked_db), {"min_snr_db": [asked_db, asked_db - 10.0]})
    assert table.gave_way == given_way(alone) == ["reserve.snr_db"] == [row["gave_way"] for row in table.rows()][:1]
    assert [note.path for note in table.warnings if note.code == PRACTICE_YIELDS] == ["reserve.snr_db"]
    assert table.mission["reserve"]["snr_db"] == 0.0
    stated = uwopt.solve(survey(asked_db - 10.0, snr_db=0.0), top=1, quick=True)
    values = [alone.objective.value, stated.objective.value]
    assert [point.objective for point in table.points] == [pytest.approx(one, rel=1e-3) for one in values]


def test_a_table_asks_nothing_of_practice_where_something_fits_everywhere(monkeypatch):
    def asked(*_: Any) -> Any:
        raise AssertionError("asked what gives way")

    monkeypatch.setattr(Work, "ask_practice", asked)
    easy_db = round(brightest_db() - 20.0, 2)
    table = uwopt.whatif(survey(easy_db), {"min_snr_db": [easy_db, easy_db + 1.0]})
    assert not table.gave_way and all("gave_way" not in row for row in table.rows())


def test_what_is_varied_gives_way_at_no_point_and_full_practice_is_told_where_nothing_fits():
    asked_db = round(brightest_db() - 1.0, 2)
    table = uwopt.whatif(survey(asked_db), {"reserve.snr_db": [0.0, 3.0]})
    assert [point.status for point in table.points] == ["optimal", "infeasible"]
    easy_db = asked_db - 10.0
    table = uwopt.whatif(survey(easy_db), {"min_snr_db": [easy_db, asked_db]})
    assert [point.status for point in table.points] == ["optimal", "infeasible"] and not table.gave_way
    assert "practice_held" in [note.code for note in table.warnings]


def test_where_the_mission_as_it_stands_has_no_system_a_table_lets_give_way_what_a_point_needs():
    """Else it said that nothing fits at a point where `solve` has a system."""
    asked_db = round(brightest_db() - 1.0, 2)
    alone = solved(1.0).result
    table = uwopt.whatif(survey(asked_db + 12.0), {"min_snr_db": [asked_db + 12.0, asked_db]})
    assert table.gave_way == given_way(alone) == ["reserve.snr_db"]
    assert [point.status for point in table.points] == ["infeasible", "optimal"]
    assert table.points[1].objective == pytest.approx(alone.objective.value, rel=1e-3)
    (told,) = (note.message for note in table.warnings if note.code == "practice_at")
    assert f"uwopt solve relaxes at min_snr_db {asked_db:g}, for the mission as it stands has no system" in told


def test_a_table_with_certainty_lets_give_way_what_a_point_needs_as_one_without(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It held all of good practice at every point where the mission as it stands has no system."""
    monkeypatch.setattr(search, "FRESH", 128)
    asked_db = round(brightest_db() - 1.0, 2)
    doubt = {"doubt": {"scenarios": 64}}
    table = uwopt.whatif(survey(asked_db + 12.0) | doubt, {"min_snr_db": [asked_db + 12.0, asked_db]}, confidence=0.5)
    alone = uwopt.solve(survey(asked_db) | doubt, confidence=0.5, top=1, quick=True)
    assert table.gave_way == given_way(alone) == ["reserve.snr_db"]
    (nothing, point), counted = table.points, alone.confidence
    assert nothing.status == "infeasible" and point.status in ("optimal", "feasible") and counted is not None
    assert point.objective == pytest.approx(counted.objective_p50, rel=1e-6) and point.figures["held"] == counted.held
    (told,) = (note.message for note in table.warnings if note.code == "practice_at")
    assert f"uwopt solve relaxes at min_snr_db {asked_db:g}, for the mission as it stands has no system" in told


def test_a_sweep_lets_give_way_what_solve_does_and_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Row by row: some gives way, a little stricter the same does, and then nothing helps."""
    asked_db = [brightest_db() - less for less in (1.1, 1.0, -10.0)]
    alone, begun, honest = solved(1.0).result, list[float](), yielding._anything

    def anything(weaker: Any, *given: Any) -> Any:
        begun.append(round(brightest_db() - 10.0 * math.log10(weaker.requirements.min_snr) * 2.0, 2))
        return honest(weaker, *given)

    monkeypatch.setattr(yielding, "_anything", anything)
    made = uwopt.sweep(survey(0.0), {"min_snr_db": asked_db}, out=tmp_path, kits=0, workers=1)
    rows, held = made.frame(), "reserve.snr_db = 0"
    assert rows["gave_way"].fillna("").tolist() == [held, held, ""] and made.gave_way == {held: 2}
    assert ["practice_yields" in codes for codes in rows["warnings"]] == [True, True, False]
    assert rows["warnings"].iloc[2] == PRACTICE_IN_VAIN and "practice_held" not in rows
    assert given_way(alone) == ["reserve.snr_db"] and rows["objective"].iloc[1] == pytest.approx(alone.objective.value)
    assert set(begun) == {1.1, -10.0}  # none at 0 and 1 dB, nor for room: what gave way and fitted before does


def test_what_is_known_of_a_mission_holds_in_those_that_ask_less() -> None:
    known, fits, asked = PracticeKnown(), load_mission(survey(20.0)), load_mission
    assert known.fits(fits) is None
    known.met.append(Asking.of(fits))
    known.missed.append(Asking.of(asked(survey(30.0))))
    told = [known.fits(asked(survey(snr_db))) for snr_db in (19.0, 20.0, 25.0, 30.0, 31.0)]
    assert told == [True, True, None, False, False]
    assert known.fits(asked(survey(19.0) | {"physics": "full"})) is None  # another family


def test_a_sweep_that_is_to_holds_practice_in_full_and_says_so(tmp_path: Path) -> None:
    asked = survey(brightest_db() - 1.0)  # 1 dB is there, 3 dB are to be kept
    made = uwopt.sweep(asked, out=tmp_path, kits=0, workers=1, hold_practice=True)
    assert made.counts == {"infeasible": 1} and not made.gave_way
    (note,) = (note for note in made.warnings if note.code == "practice_held")
    assert "in 1 of 1 missions nothing fits with all of good practice" in note.message
    assert "reserve.snr_db" in note.message and "--hold-practice" in note.message
    assert "reserve.snr_db" in made.frame()["practice_held"].iloc[0]
    held = uwopt.solve(asked, top=1, quick=True, hold_practice=True, explain=False)
    assert held.status == "infeasible" and not given_way(held)


def test_kits_are_held_to_what_the_best_is_of_a_mission_of_python_too(tmp_path: Path) -> None:
    mission = load_mission(survey(brightest_db() - 1.0))
    job, task = job_of([mission]), SweepTask("key", 0, (), "", gave_way="reserve.snr_db = 0")
    (kept,) = job_of([mission], ways=SweepWays(hold_practice=True)).tasks()
    assert kept.key not in {one.key for one in job.tasks()}  # rows of the one are no answers of the other
    made = uwopt.sweep(mission, out=tmp_path, kits=0, workers=1)
    assert made.gave_way == {"reserve.snr_db = 0": 1}
    served = [SweepWorker(job).row(one, made.kits)["served"] for one in (task, replace(task, gave_way=""))]
    assert served == ["1", "0"]


def test_what_has_given_way_is_named_so_that_it_can_be_read_again() -> None:
    mission = load_mission({**over_frame(20.0), "requirements": over_frame(20.0)["requirements"] | {"refuse": "all"}})
    for some in (YIELDS[:1], YIELDS[:5], YIELDS[1:6], YIELDS[2:4]):
        text = ", ".join(one.as_held for one in some)
        assert yields_named(text) == tuple(some)
    weaker = with_yields(mission, yields_of(mission)).to_dict()
    last = {one.path: one for one in yields_of(mission)}
    assert {one.path for one in gave_way_between(mission, weaker)} <= set(last) and not gave_way_between(
        mission, mission.to_dict()
    )


def test_a_row_that_holds_less_often_than_is_asked_names_what_would_give_way_for_it() -> None:
    mission = load_mission(survey(20.0))
    row = {"status": "feasible", "confidence_asked": "0.9", "confidence": 0.5}
    assert "reserve.snr_db" in with_practice_held(row, mission)["practice_held"]
    for other in (row | {"confidence": 0.95}, row | {"confidence_asked": "ends"}, {"status": "optimal"}):
        assert with_practice_held(other, mission) == other
    bare = load_mission(survey(20.0) | {"practice": "bare"})
    assert with_practice_held(row | {"status": "infeasible"}, bare)["practice_held"] is None


def test_a_table_with_certainty_says_that_practice_gives_way_as_for_the_mission_as_it_stands() -> None:
    def notes(mission: dict[str, Any], *points: WhatIfPoint) -> list[str]:
        return [note.message for note in full_practice_notes(points, work_on(mission))]

    def work_on(mission: dict[str, Any]) -> Any:
        return SimpleNamespace(certain=True, given_way=(), base=SimpleNamespace(base=load_mission(mission)))

    seldom = WhatIfPoint([0.3], "infeasible", figures={"held": 0.4})
    (told,) = notes(survey(20.0), seldom)
    assert told.startswith("every point is held to what is left of good practice in the mission as it stands")
    assert notes(survey(20.0) | {"practice": "bare"}, seldom) == []
    assert notes(survey(20.0), WhatIfPoint([0.3], "optimal", figures={"held": 0.95})) == []


def test_a_spider_is_of_the_mission_that_solve_answers(monkeypatch):
    monkeypatch.setattr(varied_work, "SPIDER_FACTORS", (1.0,))  # what is moved has a test beside the tables
    asked_db = round(brightest_db() - 1.0, 2)
    table = uwopt.whatif(survey(asked_db), spider=True)
    assert table.gave_way == ["reserve.snr_db"]
    as_asked = [point for line in table.spider for point in line.points if point.values == [1.0]]
    assert as_asked and {point.status for point in as_asked} == {"optimal"}


def test_explain_says_that_solve_has_a_system_with_less_of_good_practice(unexplained):
    asked_db = round(brightest_db() - 1.0, 2)
    assert given_way(solved(1.0).result) == ["reserve.snr_db"]
    explained = uwopt.solve(survey(asked_db), top=1, quick=True, every_price=True)
    assert explained.status == "infeasible" and not given_way(explained)
    first = next(explanation_blocks(explained))
    assert isinstance(first, Block) and "uwopt solve relaxes what it must" in " ".join(map(str, first.lines))
    never = uwopt.solve(survey(asked_db + 10.0), top=1, quick=True, every_price=True)
    assert PRACTICE_WOULD_YIELD not in [note.code for note in never.warnings]


def test_explain_asks_of_less_practice_as_long_as_solve_does(monkeypatch, unexplained):
    """Else it explains the mission with all of practice where `solve` explains that with the least."""
    honest, asked_s = explaining.with_least_practice, list[float]()

    def watched(*given: Any) -> Any:
        asked_s.append(given[3].left_s)
        return honest(*given)

    monkeypatch.setattr(explaining, "with_least_practice", watched)
    uwopt.solve(survey(brightest_db() + 10.0), top=1, quick=True, every_price=True)
    assert asked_s == [pytest.approx(yielding.patience_of(NEVER).left_s)]


def test_explain_says_where_it_does_not_know_whether_less_of_practice_would_do(monkeypatch, unexplained):
    honest = explaining.with_least_practice

    def in_no_time(*given: Any) -> Any:
        made = honest(*given)
        return replace(made, outcome=replace(made.outcome, best=[], complete=False))

    monkeypatch.setattr(explaining, "with_least_practice", in_no_time)
    explained = uwopt.solve(survey(round(brightest_db() - 1.0, 2)), top=1, quick=True, every_price=True)
    first = next(explanation_blocks(explained))
    assert isinstance(first, Block) and "is not known in this time" in " ".join(map(str, first.lines))
    assert explained.mission["reserve"]["snr_db"] == 3.0  # all of practice is explained


def told_in_vain(nothing: Any, blocks: Any) -> float:
    """Holds a refusal with all of practice relaxed that may be to its words; the signal to noise said to be needed."""
    assert PRACTICE_IN_VAIN in [note.code for note in nothing.warnings] and not given_way(nothing)
    assert nothing.mission["reserve"]["snr_db"] == 0.0 and nothing.infeasible is not None
    said = " ".join(str(line) for block in blocks(nothing) if isinstance(block, Block) for line in block.lines)
    assert "good practice relaxed as far as uwopt may" in said
    assert "the mission itself says but signal to noise" in opening(nothing)[0]  # not all that is asked
    (change,) = (one for one in nothing.infeasible.relaxations if one.name == "min_snr")
    assert change.needed is not None and change.needed > brightest_db() - 0.1  # 3 dB less with all in hand
    return float(change.needed)


@pytest.mark.usefixtures("undoubted")
def test_what_would_help_is_what_solve_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing fits even with good practice relaxed as far as it may be: else changes are told that need not be.

    Requirements alone are asked: moving water, height or speed takes most of the time, and is told beside.
    """
    monkeypatch.setattr(moves, "tries_of", lambda *given, **more: iter(()))
    nothing = uwopt.solve(survey(brightest_db() + 10.0), top=1, quick=True)
    needed_db = told_in_vain(nothing, nothing_blocks)
    answer = uwopt.solve(survey(needed_db), top=1, quick=True)
    (change,) = (one for one in nothing.infeasible.relaxations if one.name == "min_snr")
    gave_way = gave_way_between(load_mission(survey(needed_db)), answer.mission)
    said = " ".join(str(line) for block in nothing_blocks(nothing) if isinstance(block, Block) for line in block.lines)
    assert change.gives_up == [one.as_held for one in gave_way] and gave_way[0].words in " ".join(said.split())
    assert answer.best is not None and "reserve.snr_db" in given_way(answer)[0]
    assert uwopt.solve(survey(needed_db + 1.0), top=1, quick=True, explain=False).best is None


@pytest.mark.usefixtures("undoubted")
def test_explain_says_what_would_help_as_solve_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a change gives up is asked of the mission with all of practice, as by `solve`; here it is given."""

    def with_practice_left(why: WhyNothing, asked: Any, *given: Any) -> WhyNothing:
        assert asked.to_dict() == wanted.to_dict()
        return replace(why, relaxations=[replace(one, gives_up=["reserve.blur = 0"]) for one in why.relaxations])

    monkeypatch.setattr(explaining, "with_practice_left", with_practice_left)
    wanted = load_mission(survey(brightest_db() + 10.0))
    nothing = uwopt.solve(wanted, top=1, quick=True, every_price=True)
    told_in_vain(nothing, explanation_blocks)
    assert all(one.gives_up == ["reserve.blur = 0"] for one in nothing.infeasible.relaxations)
    lines = [str(line) for block in explanation_blocks(nothing) if isinstance(block, Block) for line in block.lines]
    assert any("good practice is then relaxed, too: no reserve on motion blur." in line for line in lines)


class Watched:
    """Searches, counted as they begin to take nodes; a person wants no more at one of them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, at: int):
        self.begun, honest = 0, Search._best_first

        def best_first(one: Search, rows: Any) -> Any:
            self.begun += 1
            if self.begun == at:
                raise KeyboardInterrupt
            return honest(one, rows)

        monkeypatch.setattr(Search, "_best_first", best_first)


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize(("short_db", "every_price"), [(-1.0, False), (10.0, False), (10.0, True)])
def test_whoever_wants_no_more_is_not_kept_waiting(short_db: float, every_price: bool) -> None:
    """Whichever search an interruption falls into, it is told, and next to nothing is searched after it."""
    wanted = survey(brightest_db() + short_db) | {"confidence": 0.9, "doubt": {"scenarios": 32}}
    never_keeps_waiting(wanted, every_price=every_price)


@pytest.mark.usefixtures("unexplained")
def test_whoever_wants_no_more_is_not_kept_waiting_for_parts_to_be_made() -> None:
    """Where nothing that is sold fits, and whether anything does without the cap of gain is asked first."""
    only_made = {"catalog": HARDWARE | {"generic": "fallback"}, "confidence": 0.9, "doubt": {"scenarios": 32}}
    never_keeps_waiting(survey(brightest_db() + 10.0, max_gain_db=12.0) | only_made)


def test_whoever_ends_any_search_of_a_mission_is_heard() -> None:
    """Of what is sold, of all parts, of the fewest kinds to be made: the last was taken for nothing found."""
    wanted = load_mission(survey(10.0, max_gain_db=12.0) | {"catalog": HARDWARE | {"generic": "fallback"}})
    searches = Searches(load_catalog(wanted), goal_of(wanted), 1, Watch(NEVER))
    with pytest.MonkeyPatch.context() as patched:
        watched = Watched(patched, at=0)
        assert searches.of(wanted).sought.of_all_kinds is not None
    for at in range(1, watched.begun + 1):
        with pytest.MonkeyPatch.context() as patched:
            Watched(patched, at)
            found = searches.of(wanted)
        assert found.cut or found.sought.outcome.interrupted or found.widest.outcome.interrupted, at


def never_keeps_waiting(wanted: dict[str, Any], **how: Any) -> None:
    """That hardly any search begins after one that an interruption falls into."""
    with pytest.MonkeyPatch.context() as patched:
        watched = Watched(patched, at=0)
        uwopt.solve(wanted, top=1, quick=True, **how)
    assert watched.begun > 1
    for at in sorted({*range(1, 5), *range(5, watched.begun + 1, 1 + watched.begun // drawn(3, 8)), watched.begun}):
        with pytest.MonkeyPatch.context() as patched:
            stopped = Watched(patched, at)
            try:
                result = uwopt.solve(wanted, top=1, quick=True, **how)
            except KeyboardInterrupt:
                continue
        assert stopped.begun < at or "interrupted" in [note.code for note in result.warnings], at


def test_who_ends_a_search_does_not_wait_for_hardware_to_be_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """What it found can be set all the same."""
    wanted = load_mission(survey(10.0) | {"confidence": 0.9})
    found = Searches(load_catalog(wanted), goal_of(wanted), 1, Watch(NEVER)).of(wanted)
    outcome = replace(found.sought.outcome, interrupted=True)
    monkeypatch.setattr(certainty, "with_confidence", lambda *given: pytest.fail("counted"))
    made = chosen_of(replace(found, sought=replace(found.sought, outcome=outcome)), Watch(NEVER))
    assert made.is_cut_short and not made.cut and made.counted is None and made.design.is_settable


def test_hardware_that_fitted_is_asked_before_all_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same gives way as when every question is a search of all parts, in fewer of them."""
    wanted = load_mission(survey(brightest_db() - 1.0))
    searched: list[float] = []
    seek = yielding.seek

    def counted(*given: Any, **more: Any) -> Any:
        searched.append(1.0)
        return seek(*given, **more)

    monkeypatch.setattr(yielding, "seek", counted)
    told, searches = [], []
    for few in (yielding.WITNESSES, 0):
        monkeypatch.setattr(yielding, "WITNESSES", few)
        searched.clear()
        told.append([one.path for one in gives_way_alone(wanted, NEVER).yields])
        searches.append(len(searched))
    assert told[0] == told[1] == ["reserve.snr_db"] and searches[0] < searches[1]


def test_a_long_time_that_is_given_is_no_shorter_than_none() -> None:
    assert patience_of(Deadline.after(1000.0)).left_s > yielding.YIELD_S
    assert patience_of(NEVER).left_s == pytest.approx(yielding.YIELD_S)


def all_that_may_give_way() -> tuple[Any, tuple[Any, ...]]:
    """A mission with all of good practice, and what of it may give way."""
    mission = load_mission({**survey(20.0), "reserve": {}}).without_gain_cap
    return mission, yields_of(mission)


def test_no_question_takes_the_time_of_those_after_it_but_whether_anything_fits(monkeypatch: Any) -> None:
    mission, every = all_that_may_give_way()
    spent, left_s = [0.0], list[float]()

    def anything(weaker: Any, catalog: Any, like: Any, deadline: Deadline) -> Any:
        """Nothing is found in all the time that it gets, but where all gives way: there it is at once."""
        left_s.append(deadline.left_s)
        found = with_yields(mission, every).to_dict() == weaker.to_dict()
        spent[0] += 0.0 if found else deadline.left_s
        return SimpleNamespace(outcome=SimpleNamespace(best=[1] if found else [], complete=False))

    monkeypatch.setattr(yielding, "_anything", anything)
    monkeypatch.setattr(YieldTrials, "_take", lambda *given: None)
    patience = Deadline.after(100.0, lambda: spent[0])
    made = yielding._least(mission, every, cast(Any, None), cast(Any, None), patience, PracticeKnown(), roomy=False)
    assert left_s[:3] == pytest.approx([100.0, 25.0, 18.75]) and not patience.passed() and not made.is_least


def test_known_hardware_is_asked_though_time_is_over(monkeypatch: Any) -> None:
    """It needs no signal in hand to give way, and no other key: so much is known, that less does not do is not."""
    mission, every = all_that_may_give_way()

    def on_hardware(asked: YieldTrials, weaker: Any) -> bool | None:
        return True if weaker.reserve.snr_db == 0.0 else None

    monkeypatch.setattr(YieldTrials, "_on_hardware", on_hardware)
    late, none = Deadline.after(0.0), cast(Any, None)
    made = yielding._least(mission, every, none, none, late, PracticeKnown(), roomy=False)
    assert [one.path for one in made.yields] == ["reserve.snr_db"] and not made.is_least and len(every) > 1


def shares_held(monkeypatch: pytest.MonkeyPatch, held: Any) -> Any:
    """Counts of hardware that holds in so large a share of 256 scenarios of a mission; 0.9 are asked."""
    monkeypatch.setattr(yielding, "most_held", lambda counts, mission, known, least: held(mission))
    return SimpleNamespace(seen=SimpleNamespace(share=0.9, scenarios=SimpleNamespace(count=256)))


def test_what_gave_way_so_that_anything_fits_comes_back_where_the_rest_is_enough(monkeypatch: Any) -> None:
    """Blur in hand was given up for a fit; it is not needed beside signal in hand, swath in hand still is."""
    mission = load_mission({**survey(20.0), "reserve": {}})
    swath, _, blur = YIELDS[:3]
    (snr,) = (one for one in YIELDS if one.path == "reserve.snr_db")

    def held(asked: Any) -> float:
        return 0.95 if asked.reserve.swath == asked.reserve.snr_db == 0.0 else 0.4

    counts = shares_held(monkeypatch, held)
    every = yielding.all_to_hold(mission, (swath, blur))
    assert yielding.fewest_to_hold(mission, (swath, blur), every, counts, NEVER, {}) == (swath, snr)


def test_nothing_is_told_of_less_where_nothing_holds_with_all(monkeypatch: Any) -> None:
    """What no hardware holds in with all that may give way is not asked of with less: each is counted anew."""
    mission, asked = load_mission({**survey(20.0), "reserve": {}}), list[Any]()
    (swath,) = (one for one in YIELDS if one.path == "reserve.swath")

    def held(weaker: Any) -> float:
        asked.append(weaker)
        return 0.0

    counts = shares_held(monkeypatch, held)
    every = yielding.all_to_hold(mission, (swath,))
    assert yielding.fewest_to_hold(mission, (swath,), every, counts, NEVER, {}) is None and len(asked) == 1


def test_hardware_is_counted_once_for_each_mission_that_it_is_asked_of(monkeypatch: pytest.MonkeyPatch) -> None:
    counted: list[float] = []

    def held_as_set(moved: Any, mission: Any, found: Any) -> float:
        counted.append(mission.reserve.snr_db)
        held = 0.5 if mission.reserve.snr_db else 0.8
        return held if held >= moved.share else 0.0

    monkeypatch.setattr("uwopt.solvers.confidence.eased.MovedKeys.held_as_set", held_as_set)
    monkeypatch.setattr("uwopt.solvers.confidence.counted.names", lambda problem, found: found)
    missions = [load_mission({**survey(20.0), "reserve": {"snr_db": snr_db}}) for snr_db in (3.0, 0.0, 3.0, 0.0)]
    known = yielding.KnownToHold()
    shares = []
    for mission in missions:  # what is counted in each round is another object
        tried = [SimpleNamespace(held=0.8, found=name) for name in "ab"]
        seen = SimpleNamespace(share=0.9, scenarios=SimpleNamespace(count=256), tried=tried)
        counts = cast(Any, SimpleNamespace(
            sought=SimpleNamespace(problem=SimpleNamespace(mission=mission), goal=None), seen=seen
        ))  # fmt: skip
        shares.append(yielding.most_held(counts, mission, known))
    assert shares == [0.5, 0.8, 0.5, 0.8] and counted == [3.0, 3.0, 0.0, 0.0]
    assert yielding.most_held(counts, missions[0], {}, 0.5) == 0.5 and counted[4:] == [3.0]  # the first is enough
    few: dict[Any, float] = {}
    assert [yielding.most_held(counts, missions[0], few, 0.9) for _ in range(2)] == [0.0, 0.0] and len(counted) == 7
    assert yielding.most_held(counts, missions[0], few) == 0.5 and len(counted) == 9  # more is asked than was before
