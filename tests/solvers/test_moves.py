"""Keys that are no requirements move as little as lets something fit; sets that clash are irreducible."""

from __future__ import annotations

from collections.abc import Collection
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_least_change import mission, written

from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import NEVER, Deadline
from uwopt.errors import MissionError
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Moved
from uwopt.results.result import Certificate
from uwopt.solvers.exact.account import Account
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.infeasible import why_nothing as infeasible
from uwopt.solvers.infeasible.joint_changes import CommonShare
from uwopt.solvers.infeasible.least_change import CLOSER, in_rounds
from uwopt.solvers.infeasible.move_keys import tries_of
from uwopt.solvers.infeasible.moves import Mover, NearestType
from uwopt.solvers.infeasible.singles import Singles
from uwopt.solvers.infeasible.trials import BRIGHT, Trials
from uwopt.solvers.infeasible.why_nothing import (
    Contradiction,
    ask_budget,
    clash_of,
    contradiction,
    why_nothing,
)
from uwopt.solvers.recommend import seek

POWER = Objective.of("power")


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return written(tmp_path_factory.mktemp("parts"))


def fits(wanted: Mission, catalog: Catalog) -> bool:
    return bool(seek(wanted, catalog, POWER, generic="never", top=1).outcome.best)


def moves(wanted: Mission) -> dict[str, Moved]:
    """What may be moved, by key."""
    catalog = load_catalog(wanted)
    sought = seek(wanted, catalog, POWER, generic="never", top=1)
    assert not sought.outcome.best
    mover = Mover(Trials(wanted, catalog, POWER, "never", like=sought))
    mover.try_few()
    mover.try_all()
    in_rounds([move.drawn for move in mover.helpful if move.drawn is not None], NEVER)
    return {move.name: move for move in (change.told() for change in mover.helpful)}


def test_speed_and_height_move_as_far_as_they_must(parts):
    wanted = mission(parts, min_snr_db=30.0, max_blur_px=0.25)  # 0.25 px of blur leave too little light
    catalog, told = load_catalog(wanted), moves(wanted)
    assert {"speed_m_s", "altitude_m"} <= told.keys()
    for name in ("speed_m_s", "altitude_m"):
        move = told[name]
        assert move.nearest
        assert move.needed < move.asked
        at = wanted.to_dict()["vehicle"]
        nearer = move.needed + 2.0 * CLOSER * (move.asked - move.needed)
        assert fits(wanted.with_changes(vehicle=at | {name: move.needed}), catalog)
        assert not fits(wanted.with_changes(vehicle=at | {name: nearer}), catalog)


def test_the_nearest_clearer_water_is_told(parts):
    murky = mission(parts, min_snr_db=18.0, max_blur_px=0.25)
    scene = murky.to_dict()["scenes"][0] | {"water": "5C"}
    wanted = murky.with_changes(scenes=[scene])
    catalog, told = load_catalog(wanted), moves(wanted)["water"]
    order = ["I", "IA", "IB", "II", "1C", "III", "3C", "5C"]
    place = order.index(told.needed)
    tried = [wanted.with_changes(scenes=[scene | {"water": water}]) for water in order[place : place + 2]]
    assert [fits(one, catalog) for one in tried] == [True, False]


@pytest.mark.parametrize(("asked", "clearest", "beyond"), [
    ({"c_per_m": 0.3}, 0.055, 0.054), ({"visibility_m": 12.0}, 80.0, 81.0),
    ({"secchi_m": 11.0}, 80.0, 81.0), ({"turbidity_ntu": 0.1}, 0.02, 0.019),
])  # fmt: skip
def test_water_is_tried_as_clear_as_a_mission_can_say(parts, asked, clearest, beyond):
    """40 and 8 times as clear as these none is, so that it was told not to help without a trial."""
    murky = mission(parts)
    scene = murky.to_dict()["scenes"][0] | {"water": None}
    wanted = murky.with_changes(scenes=[scene | asked])
    (name,) = asked
    (one,) = (one for one in tries_of(wanted) if one.key.name == name)
    assert one.values == (clearest,)
    assert Mover(Trials(wanted, None, POWER, "never"))._at(one.key, clearest).scenes[0].clarity == (name, clearest)
    with pytest.raises(MissionError):
        wanted.with_changes(scenes=[scene | {name: beyond}])
    clear = wanted.with_changes(scenes=[scene | {name: clearest}])
    assert name not in {one.key.name for one in tries_of(clear)}


def test_a_type_of_water_that_takes_too_long_is_asked_once_and_clearer_ones_instead():
    asked: list[str] = []

    def search(water: str, turn: Deadline) -> Any:
        asked.append(water)
        return SimpleNamespace(outcome=SimpleNamespace(best=[1] * (water == "IB"), complete=False))

    change = NearestType("7C", search)
    in_rounds([change], NEVER)
    assert asked == ["1C", "IB", "II"]  # in the middle between the clearest, which does, and 7C; then nearer to it
    assert change.needed == "IB" and not change.is_least


def lander(parts: Any, **carried: Any) -> Mission:
    """What hovers with a battery of its own and takes an image every ten minutes, its lamp off between them."""
    wanted = mission(parts, min_snr_db=10.0, overlap=None, frame_interval_s=600.0)
    given = {"speed_m_s": 0.0, "lamps_between_images": "off", "supply": "battery", **carried}
    return wanted.with_changes(vehicle=wanted.to_dict()["vehicle"] | given)


def test_what_holds_and_takes_energy_moves_as_far_as_it_must(parts):
    wanted = lander(parts, duration_h=50.0, battery_wh=75.0)  # a camera of 3 W takes 150 Wh
    catalog, told = load_catalog(wanted), moves(wanted)
    assert list(told)[:3] == ["camera_between_images", "battery_wh", "duration_h"]  # what lacks comes first
    at = wanted.to_dict()["vehicle"]
    assert told["camera_between_images"].needed == "off"
    assert fits(wanted.with_changes(vehicle=at | {"camera_between_images": "off"}), catalog)
    for name, needed in (("battery_wh", 150.0), ("duration_h", 25.0)):
        assert told[name].needed == pytest.approx(needed, rel=0.02)  # what the lamp takes is little beside it
        assert told[name].nearest
        assert fits(wanted.with_changes(vehicle=at | {name: told[name].needed}), catalog)
        nearer = told[name].needed + 2.0 * CLOSER * (told[name].asked - told[name].needed)
        assert not fits(wanted.with_changes(vehicle=at | {name: nearer}), catalog)


def test_a_battery_of_which_a_share_is_kept_is_told_with_it(parts):
    wanted = lander(parts, duration_h=50.0, battery_wh=75.0).with_changes(reserve={"energy": 0.2})
    made = moves(wanted)["battery_wh"]
    assert made.asked == 75.0 and made.needed == pytest.approx(150.0 / 0.8, rel=0.02)


def test_what_holds_and_takes_energy_gives_together_with_all_else_where_energy_lacks(parts):
    wanted = lander(parts, duration_h=50.0, battery_wh=75.0)
    catalog = load_catalog(wanted)
    like = seek(wanted, catalog, POWER, generic="never", top=1)
    both = CommonShare(Trials(wanted, catalog, POWER, "never", like=like), NEVER)
    fit = both.of_all()
    assert fit is not None
    told = {one.name: one.needed for one in fit.changes}
    assert told.keys() == {"battery_wh", "duration_h"} and told["battery_wh"] > 75.0 and told["duration_h"] < 50.0
    at = wanted.to_dict()["vehicle"]
    assert fits(wanted.with_changes(vehicle=at | told), catalog)
    assert not any(fits(wanted.with_changes(vehicle=at | {name: value}), catalog) for name, value in told.items())


def test_a_battery_that_only_times_endurance_is_no_key_to_move(parts):
    names = {one.key.name for one in tries_of(lander(parts, duration_h=50.0, battery_wh=75.0, supply="vehicle"))}
    assert names.isdisjoint({"battery_wh", "duration_h", "camera_between_images"})


def priced_lander(parts, cost: float) -> Mission:
    """A lander whose battery of 1000 Wh counts in its price."""
    wanted = lander(parts, duration_h=50.0, battery_wh=1000.0)
    given = wanted.to_dict()
    limits, catalog = given["limits"] | {"cost": cost}, given["catalog"] | {"rest": "estimate"}
    return wanted.with_changes(limits=limits, catalog=catalog)


def test_a_battery_is_smaller_by_what_the_budget_lacks(parts):
    """At 5 USD a watt-hour, the high end: 1000 USD less than it takes are 200 of 1000 Wh; 150 Wh are needed."""

    def priced(cost: float) -> Mission:
        return priced_lander(parts, cost)

    catalog, low, high = load_catalog(priced(1.0)), 5e3, 1e5
    while high - low > 1.0:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(priced(middle), catalog) else (middle, high)
    wanted = priced(high - 1000.0)
    told = moves(wanted)
    assert next(iter(told)) == "battery_wh" and told["battery_wh"].nearest
    assert told["battery_wh"].needed == pytest.approx(800.0, abs=5.0)
    at = wanted.to_dict()["vehicle"]
    assert fits(wanted.with_changes(vehicle=at | {"battery_wh": told["battery_wh"].needed}), catalog)


def test_a_budget_that_a_smaller_battery_keeps_is_told_too_without_a_search(parts, monkeypatch):
    """A scallop survey for 15 000 USD was told that 655 of 800 Wh would do, and not that 1 000 USD more would."""
    wanted = priced_lander(parts, 6000.0)  # about 7 000 USD at high prices, 3 000 USD at the likeliest
    catalog = load_catalog(wanted)
    sought = seek(wanted, catalog, POWER, generic="never", top=1)
    assert not sought.outcome.best
    trials = Trials(wanted, catalog, POWER, "never", like=sought)
    singles, mover = Singles(trials), Mover(trials)
    mover.try_all()
    assert "battery_wh" in [one.name for one in mover.helpful] and not singles.helpful
    monkeypatch.setattr(trials.relaxer, "seek", None)
    ask_budget(singles, mover)
    (told,) = singles.helpful
    assert (told.name, told.at_central_prices) == ("cost", True)


def test_what_does_not_help_is_not_told(parts):
    assert moves(mission(parts, min_snr_db=100.0)) == {}  # more electrons than the pixel holds


# ---------------------------------------------------------------- what contradicts what

NAMES = "abcdef"


def test_a_depth_that_stands_in_the_way_too_is_named_beside_what_contradicts_it():
    """A shallower place would do, and so would more money: it is not the budget that no parts meet by themselves."""
    trials: Any = SimpleNamespace(
        over=False, interrupted=False, say=lambda *said: None, by_effort=lambda: {"cost": 1.0},
        fits_without=lambda names: True, deadline=SimpleNamespace(left_out=[]),
    )  # fmt: skip
    helpful: list[Any] = [SimpleNamespace(name=name) for name in ("depth_rating_m", "cost")]
    assert clash_of(trials, helpful).names == ("depth_rating_m", "cost")
    assert clash_of(trials, helpful[1:]).names == ("cost",)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.sets(st.sampled_from(NAMES), min_size=1, max_size=4), min_size=1, max_size=4),
    st.sets(st.sampled_from(NAMES)),
)
def test_a_contradiction_is_irreducible(clashes, at_once):
    def possible(without: Collection[str]) -> bool:
        return not any(clash.isdisjoint(without) for clash in clashes)

    alone = {name for name in NAMES if possible([name])}
    found = contradiction(NAMES, alone, possible, at_once)
    assert found.is_least
    others = set(NAMES) - set(found.names)
    assert not possible(others)
    assert all(possible(others | {one}) for one in found.names)


def test_a_contradiction_is_not_told_where_a_search_is_cut_short():
    assert contradiction(NAMES, set(), lambda without: None) == Contradiction()


def test_what_is_known_of_a_contradiction_is_told_where_a_search_is_cut_short():
    """Leaving out c ends without an answer: the set that is left is none too few, and maybe one too many."""

    def fits(without: Collection[str]) -> bool | None:
        return None if "c" in without else bool({"a", "b"} & set(without))

    assert contradiction(NAMES, {"a", "b"}, fits) == Contradiction(("a", "b", "c"))


def of_murky_water(parts: Any, deadline: Deadline = NEVER) -> tuple[Trials, Certificate]:
    """25 dB through 4 m of 7C: of all single changes only clearer water helps."""
    murky = mission(parts, max_blur_px=0.25)
    at = murky.to_dict()
    wanted = murky.with_changes(scenes=[at["scenes"][0] | {"water": "7C"}], vehicle=at["vehicle"] | {"altitude_m": 4.0})
    catalog = load_catalog(wanted)
    like = seek(wanted, catalog, POWER, generic="never", top=1)
    proof = certificate(like.selection, like.problem, like.outcome, POWER)
    return Trials(wanted, catalog, POWER, "never", deadline, like=like), proof


def test_changes_in_the_water_as_it_is_are_looked_for_soon_beside_clearer_water(parts, monkeypatch):
    """Nobody can order water; where little time is left after it, what was found soon is told."""
    trials, proof = of_murky_water(parts)
    looked_for = []
    soon = CommonShare(trials, NEVER).of_all()
    assert soon is not None and {"altitude_m", "min_snr"} <= {one.name for one in soon.changes}

    def found_soon(trials: Trials, singles: Any, mover: Mover) -> Any:
        looked_for.append([move.name for move in mover.helpful])
        trials.deadline = Deadline(0.0, lambda: 1.0)  # no time for more
        return soon

    monkeypatch.setattr(infeasible, "together_soon", found_soon)
    monkeypatch.setattr(Mover, "try_few", Mover.try_all)  # of so few imagers no few are looked at
    why = why_nothing(trials, proof)
    assert looked_for == [["water"]]
    assert [move.name for move in why.moves] == ["water"] and not why.relaxations
    assert why.together == soon.changes


def test_where_light_lacks_speed_and_height_give_from_the_first(parts, monkeypatch):
    trials, moved = of_murky_water(parts)[0], []
    monkeypatch.setattr(CommonShare, "_search", lambda self, *of: moved.append(set(self.moved)))
    for lacks, expected in ((False, [set(), {"speed_m_s", "altitude_m"}]), (True, [{"speed_m_s", "altitude_m"}])):
        trials.short_of = frozenset({"light"} if lacks else ())
        moved.clear()
        CommonShare(trials, NEVER, few=True).of_all()
        assert moved[: len(expected)] == expected and (set() in moved) is not lacks


def test_the_brightest_hardware_spends_no_more_than_is_asked_where_less_fits(parts, monkeypatch):
    """Four lamps take 800 W and 2 800 USD beside 1 000 for the rest; one of 200 W and 700 USD has light enough."""
    murky = of_murky_water(parts)[0].mission
    at, limits = murky.to_dict()["vehicle"], {"cost": 2000.0, "power_w": 300.0}
    wanted = murky.with_changes(vehicle=at | {"light_count": [1, 4]}, limits=limits)
    catalog, asked = load_catalog(wanted), []

    def brightest(self: CommonShare, mission: Mission, turn: Deadline) -> Any:
        asked.append((mission.limits.cost, mission.limits.power_w))
        return self.trials.relaxer.seek(mission, BRIGHT, set(self.asked), few_first=False)

    monkeypatch.setattr(CommonShare, "_among_few", brightest)
    fit = CommonShare(Trials(wanted, catalog, POWER, "never"), NEVER, few=True).of_all()
    assert fit is not None and {"cost", "power_w"}.isdisjoint(one.name for one in fit.changes)
    assert asked[0] == (8000.0, 1200.0) and asked[-1] == (2000.0, 300.0)
    possible = {one.name: one.needed for one in fit.changes}
    limits_told = {name: value for name, value in possible.items() if name not in at}
    trials = Trials(wanted, catalog, POWER, "never")
    moved = at | {name: value for name, value in possible.items() if name in at}
    assert fits(trials.with_limits(wanted, limits_told).with_changes(vehicle=moved | {"light_count": 1}), catalog)


def test_a_value_at_which_nothing_fits_is_not_searched_again(parts):
    wanted, asked = mission(parts, min_snr_db=60.0, max_blur_px=0.25), []
    mover = Mover(Trials(wanted, None, POWER, "never"))
    (one,) = (one for one in mover.tries if one.key.name == "altitude_m")

    def found(key: Any, value: Any, how: Any) -> Any:
        asked.append(value)
        return SimpleNamespace(outcome=SimpleNamespace(best=[], complete=value != one.values[1]))

    mover._search = found
    mover.trials.relaxer.why_not = lambda *of: ()
    mover._try_far(one, NEVER)
    mover._try_far(one, NEVER)
    assert asked == [*one.values, one.values[1]]


def by_day(parts: Any, *suns_lux: float, lamps: int = 0) -> Mission:
    """Divers in 3 m of water, on so many days."""
    asked = mission(parts, min_snr_db=30.0, max_blur_px=0.5).to_dict()
    scene, vehicle = asked["scenes"][0] | {"depth_m": 3.0}, asked["vehicle"] | {"light_count": lamps}
    scenes = [scene | {"sun_lux": sun_lux, "name": f"day {n}"} for n, sun_lux in enumerate(suns_lux)]
    catalog = asked["catalog"] | ({} if lamps else {"lights": []})
    return mission(parts).with_changes(
        physics="full", scenes=scenes, requirements=asked["requirements"], vehicle=vehicle, catalog=catalog
    )


def test_a_brighter_day_is_told_as_bright_as_it_must_be(parts):
    """Divers without lamps were told of clearer water and less speed, and not to come at noon."""
    wanted = by_day(parts, 300.0)
    catalog, told = load_catalog(wanted), moves(wanted)["sun_lux"]
    assert told.unit == "lux" and told.asked == 300.0 and told.nearest
    nearer = told.needed + 2.0 * CLOSER * (told.asked - told.needed)
    assert fits(by_day(parts, told.needed), catalog) and not fits(by_day(parts, nearer), catalog)


@pytest.mark.parametrize("suns_lux", [(0.0,), (100_000.0,), (20_000.0, 300.0)])
def test_no_day_is_brightened_at_night_or_at_noon_or_where_days_differ(parts, suns_lux):
    assert "sun_lux" in {one.key.name for one in tries_of(by_day(parts, 300.0, lamps=1))}
    wanted = by_day(parts, *suns_lux, lamps=1)
    assert "sun_lux" not in {one.key.name for one in tries_of(wanted)}
    assert "sun_lux" not in {one.key.name for one in tries_of(by_day(parts, 300.0).with_changes(physics="paper"))}


# ---------------------------------------------------------------- lamps


def lit(parts: Any, vehicle: dict[str, Any], **asked: Any) -> Mission:
    """A survey with all physics, its lamps so."""
    wanted = mission(parts, min_snr_db=10.0, **asked).with_changes(physics="full")
    return wanted.with_changes(vehicle=wanted.to_dict()["vehicle"] | vehicle)


def test_lamps_move_as_far_as_they_must_and_no_less_will_do(parts):
    """One lamp lights one side: what makes it even is one more, or it nearer to the port or aimed under it."""
    wanted = lit(parts, {}, min_uniformity=0.6)
    catalog, told = load_catalog(wanted), moves(wanted)
    assert told["light_count"].needed == 2.0
    assert told["light_baseline_m"].needed < 0.8 and told["light_tilt_deg"].needed < 0.0
    at = wanted.to_dict()["vehicle"]
    for name in ("light_count", "light_baseline_m", "light_tilt_deg"):
        move = told[name]
        assert move.nearest
        assert fits(wanted.with_changes(vehicle=at | {name: move.needed}), catalog), name
        if name != "light_count":  # nothing is between one and two
            half = move.asked + 0.5 * (move.needed - move.asked)
            assert not fits(wanted.with_changes(vehicle=at | {name: half}), catalog), name


def test_lamps_farther_from_the_port_light_less_of_the_water_before_it(parts):
    wanted = lit(parts, {"light_count": 2, "light_baseline_m": 0.1}, min_contrast=0.5)
    catalog = load_catalog(wanted)
    like = seek(wanted, catalog, POWER, generic="never", top=1)
    mover = Mover(Trials(wanted, catalog, POWER, "never", like=like))
    mover.try_lamps()
    in_rounds([move.drawn for move in mover.helpful if move.drawn is not None], NEVER)
    (told,) = [change.told() for change in mover.helpful]
    assert told.name == "light_baseline_m" and 0.1 < told.needed < 0.2 and told.nearest
    assert "light_count" in mover.useless, "twice as many lamps light the water as they light the floor"


def test_all_moves_of_lamps_are_known_in_vain_by_one_search(parts, monkeypatch):
    wanted = lit(parts, {"light_count": [1, 2]}, min_contrast=0.95)
    catalog = load_catalog(wanted)
    like = seek(wanted, catalog, POWER, generic="never", top=1)
    mover = Mover(Trials(wanted, catalog, POWER, "never", like=like))
    monkeypatch.setattr(mover.trials.relaxer, "seek", None)
    mover.try_lamps()
    assert {"light_baseline_m", "light_tilt_deg"} <= mover.useless.keys() and not mover.helpful


def test_places_of_lamps_that_there_was_no_time_for_stay_open(parts, monkeypatch):
    cut = SimpleNamespace(best=[], complete=False, interrupted=False, account=Account())
    wanted = lit(parts, {"light_count": [1, 2]})
    mover = Mover(Trials(wanted, load_catalog(wanted), POWER, "never"))
    monkeypatch.setattr(mover.trials.relaxer, "standing_anywhere", lambda *asked: SimpleNamespace(outcome=cut))
    mover.try_lamps()
    assert {"light_baseline_m", "light_tilt_deg"} <= {one.key.name for one in mover.left}


@pytest.mark.parametrize(("vehicle", "names"), [
    ({}, {"light_baseline_m", "light_tilt_deg", "light_count"}),
    ({"light_baseline_m": [0.3, 0.8], "light_count": [1, 4]}, {"light_tilt_deg"}),
    ({"light_tilt_deg": [-20.0, 20.0]}, {"light_baseline_m", "light_count"}),
    ({"light_mounts": [{"y_m": 0.5}], "light_baseline_m": None, "light_tilt_deg": None}, set()),
])  # fmt: skip
def test_lamps_that_the_mission_leaves_free_are_not_told(parts, vehicle, names):
    wanted = lit(parts, vehicle)
    assert {one.key.name for one in tries_of(wanted)} & {"light_baseline_m", "light_tilt_deg", "light_count"} == names
