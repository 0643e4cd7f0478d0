"""Searches that share what a dropped requirement leaves alone, against tables and searches made anew."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from random_cases import Case, case

from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.varying import Varied, VariedMission
from uwopt.mission.weakened import asked_value, without
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.imager_rules import Behind
from uwopt.solvers.exact.imagers import Imagers, enumerate_imagers, fitting_pairs, imagers_in
from uwopt.solvers.exact.search import Search
from uwopt.solvers.infeasible import relaxed_imagers
from uwopt.solvers.infeasible import relaxer as relaxed_searches
from uwopt.solvers.infeasible.freed_rules import MAY_PASS, OF_IMAGERS
from uwopt.solvers.infeasible.relaxed_imagers import in_best_housing
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.recommend import Sought

ANY = Objective.of("power")
KINDS: tuple[dict[str, bool], ...] = ({}, {"housed": True}, {"spaced": True}, {"coloured": True})
CASES = [(2, 0), (14, 0), (3, 1), (21, 2), (14, 3)]


@cache
def relaxer(seed: int, number: int) -> tuple[Case, Relaxer]:
    """A random case, with what its searches share."""
    made = case(seed, **KINDS[number])
    search = made.searcher(top=1)
    return made, Relaxer(made.mission, None, "never", Sought(None, search.problem, search, search.run()))  # type: ignore[arg-type]


def dropped(mission: Mission, names: tuple[str, ...]) -> Mission | None:
    """The mission without these; None where it has one of them not, or cannot do without."""
    for name in names:
        if asked_value(mission, name) is None or (less := without(mission, name)) is None:
            return None
        mission = less
    return mission


def relaxed(seed: int, number: int, most: int = 1) -> Iterator[tuple[tuple[str, ...], Mission]]:
    """Each requirement, or so many of them, with the mission without."""
    for count in range(1, most + 1):
        for names in combinations(sorted(MAY_PASS), count):
            mission = dropped(case(seed, **KINDS[number]).mission, names)
            if mission is not None:
                yield names, mission


def rows(imagers: Imagers) -> dict[tuple[Any, ...], list[float]]:
    """What is built and how it stands, with all that light and limits know of it."""
    index = zip(imagers.camera, imagers.lens, imagers.port, imagers.landscape, strict=True)
    columns = [imagers.cost, imagers.limit_cost, imagers.mass_kg, imagers.camera_power_w, imagers.gsd_mm]
    for scene in imagers.scenes:
        focused = scene.focused
        columns += [focused.n_low, focused.n_high, focused.rate_hz, focused.blur_time_s, focused.skew_px]
        columns += [focused.dioptre_per_m, scene.view.tan_across, scene.view.collecting_m2]
    values = np.stack(columns, axis=1) if len(imagers) else np.empty((0, 0))
    return {tuple(map(int, place)): list(value) for place, value in zip(index, values, strict=True)}


@pytest.mark.parametrize(("seed", "number"), CASES)
def test_imagers_that_a_dropped_requirement_frees_are_those_of_a_mission_without_it(seed: int, number: int) -> None:
    made, one = relaxer(seed, number)
    before = rows(enumerate_imagers(one.problem))
    for names, mission in relaxed(seed, number, most=2 if (seed, number) == (14, 0) else 1):
        anew = rows(enumerate_imagers(Problem(mission, made.parts, paper=one.problem.paper)))
        if OF_IMAGERS.issuperset(names):
            anew = {place: row for place, row in anew.items() if place not in before}
        assert rows(one.imagers(one.asking(mission), names, one_housing=False)) == anew, names


@pytest.mark.parametrize(("seed", "number"), CASES)
@pytest.mark.parametrize(("key", "times"), [("speed_m_s", 20.0), ("frame_interval_s", 0.02), ("duration_h", 50.0)])
def test_imagers_that_a_moved_key_frees_are_those_of_a_mission_that_has_it_so(
    seed: int, number: int, key: str, times: float
) -> None:
    """Of a mission that asks for many times as much, moved back."""
    made, section = case(seed, **KINDS[number]), "requirements" if key == "frame_interval_s" else "vehicle"
    views = [view.asked if section == "requirements" else view.vehicle for view in made.mission.views]
    if not (asked := getattr(views[0], key)):
        return
    base = VariedMission(made.mission, {})
    hard, mission = (base.with_values({Varied(key, section, key, ()): value}) for value in (times * asked, asked))
    search = Search(Problem(hard, made.parts, paper=hard.physics == "paper"), ANY, top=1)
    one = Relaxer(hard, None, "never", Sought(None, search.problem, search, search.run()))  # type: ignore[arg-type]
    anew = rows(enumerate_imagers(Problem(mission, made.parts, paper=one.problem.paper)))
    assert rows(one.imagers(one.asking(mission), {key}, one_housing=False)) == anew


@pytest.mark.parametrize(("seed", "number"), CASES)
def test_imagers_in_other_water_are_the_same(seed: int, number: int) -> None:
    made, one = relaxer(seed, number)
    plain = [scene | {"water": "I"} for scene in made.mission.to_dict()["scenes"] if scene.get("water")]
    if len(plain) < len(made.mission.scenes):
        return
    clear = Problem(made.mission.with_changes(scenes=plain), made.parts, paper=one.problem.paper)
    assert rows(enumerate_imagers(clear)) == rows(enumerate_imagers(one.problem))


@pytest.mark.parametrize("few", [1, 500])
@pytest.mark.parametrize(("seed", "number"), [(14, 0), (3, 1)])
def test_a_first_design_is_found_where_a_whole_search_finds_one(
    seed: int, number: int, few: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With limits of power so low that nothing fits, or little else does, and whatever is tried before all."""
    monkeypatch.setattr(relaxed_searches, "FEW_IMAGERS", few)
    monkeypatch.setattr(relaxed_imagers, "QUICK", -1)  # a few come before all
    made = case(seed, **KINDS[number])
    hard = made.mission.with_changes(limits=made.mission.to_dict()["limits"] | {"power_w": 1e-3})
    search = Case(made.parts, hard, ANY).searcher(top=1)
    one = Relaxer(hard, None, "never", Sought(None, search.problem, search, search.run()))  # type: ignore[arg-type]
    assert one.like is not None and not one.like.outcome.best
    for name in ("power_w", "min_snr"):
        mission = dropped(hard, (name,))
        if mission is not None:
            found = one.seek(mission, ANY, {name}, enough=True).outcome
            whole = Case(made.parts, mission, ANY).solve(top=1)[1]
            assert bool(found.best) == bool(whole.best)
            assert found.best or found.complete


@pytest.mark.parametrize(
    ("limits", "column"),
    [({}, "price"), ({"cost": 1e5}, "limit_price"), ({"mass_kg": 1e3}, "mass_kg"), ({"cost": 1e5, "mass_kg": 1e3}, "")],
)
def test_a_pair_stands_in_the_one_housing_that_a_limit_prefers(limits: dict[str, float], column: str) -> None:
    made = case(9, housed=True)
    problem = Problem(made.mission.with_changes(limits=limits), made.parts, paper=made.mission.physics == "paper")
    worth = getattr(problem.ports, column) if column else None
    for ports in problem.port_groups:
        pairs = fitting_pairs(problem)
        asked = [Behind(pairs.camera, pairs.lens, ports, True)]
        if len(block := imagers_in(problem, asked)):
            few = imagers_in(problem, asked, keep=lambda made: in_best_housing(problem, made))
            least: dict[tuple[int, int], float] = {}
            for camera, lens, port in zip(block.camera, block.lens, block.port, strict=True):
                value = 0.0 if worth is None else float(worth[port])
                least[camera, lens] = min(value, least.get((camera, lens), np.inf))
            kept = list(zip(few.camera, few.lens, strict=True))
            assert set(kept) == set(least)
            if worth is None:
                assert len(kept) == len(block.camera)
            else:
                assert len(kept) == len(least)
                assert [least[pair] for pair in kept] == [float(worth[port]) for port in few.port]


@pytest.mark.parametrize(
    ("asked", "left"), [({"min_snr_db": 30.0}, 0.0), ({"min_snr": 20.0}, 0.0), ({"min_snr_db": -3.0}, None)]
)
def test_without_its_snr_a_mission_still_asks_to_see_something(asked: dict[str, float], left: float | None) -> None:
    plain = case(3).mission.to_dict() | {"practice": "bare"}
    plain["requirements"] = {"max_gsd_mm": 2.0, **asked}
    mission = without(load_mission(plain), "min_snr")
    assert mission is not None
    assert [view.asked.min_snr_db for view in mission.views] == [left] * len(mission.views)
    assert all(view.asked.min_snr_given is None for view in mission.views)
