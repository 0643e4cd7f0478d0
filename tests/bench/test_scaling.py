"""The catalogues and missions of the scaling benchmark are what they claim; its search finds what enumeration finds."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from itertools import pairwise

import brute_force
import numpy as np
import pytest
from thorough import THOROUGH, drawn

from uwopt.bench import scaling
from uwopt.bench.scaling import MISSIONS, Point, measured, mission_for, search_of
from uwopt.bench.scaling_parts import (
    STATES,
    TRAITS,
    base_parts,
    central,
    counts_for,
    family,
    made_parts,
    merit,
)
from uwopt.bench.suite import BenchRow, Budget
from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.part import Part
from uwopt.catalog.parts.port import Port
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.search import Search

KINDS = ("cameras", "lenses", "ports", "lights")
SMALL, MEDIUM = 1e3, 1e6
MANY = drawn(["cost-bound", "power-bound"], list(MISSIONS))  # missions over as many parts as MEDIUM says
ENOUGH_S = 1e5  # the clock ends nothing


@cache
def solved(name: str, size: float) -> Outcome:
    """One of the missions over a made catalogue."""
    return search_of(mission_for(name), made_parts(size)).run()


# ---------------------------------------------------------------- parts


@pytest.mark.parametrize("kind", KINDS)
def test_made_parts_have_ids_of_their_own(kind: str) -> None:
    """No two parts share an id or all their numbers."""
    parts = getattr(made_parts(1e9), kind)
    assert len({p.id for p in parts}) == len(parts)
    prices = [central(p.price) for p in parts]
    assert len(set(prices)) == len(prices)


@pytest.mark.parametrize("kind", KINDS)
def test_no_made_part_dominates_another(kind: str) -> None:
    """A part as good as another of its family in everything with a worth is dearer."""
    parts = getattr(made_parts(1e8), kind)
    for name in {family(p) for p in parts}:
        own = [p for p in parts if family(p) == name]
        gains = {key: trait.worth for key, trait in TRAITS[name].items() if trait.worth}
        good = np.array(
            [[np.sign(worth) * central(getattr(p, key)) for key, worth in gains.items()] for p in own]
        )
        price = np.array([central(p.price) for p in own])
        as_good = (good[:, None, :] >= good[None, :, :]).all(axis=2)
        cheaper = price[:, None] <= price[None, :]
        assert not (as_good & cheaper & ~np.eye(len(own), dtype=bool)).any()


def test_price_rises_with_merit() -> None:
    """Within a family the order by price is the order by merit."""
    parts = made_parts(1e7).cameras
    assert sorted(parts, key=lambda p: central(p.price)) == sorted(parts, key=merit)


def plausible(part: Part) -> bool:
    """What no record may break."""
    if isinstance(part, Camera):
        return central(part.power_w) > 0 and central(part.saturation_e) > central(part.read_noise_e) > 0
    if isinstance(part, Lens):
        return (
            1.0 < central(part.f_number_min) <= central(part.f_number_max)
            and central(part.transmission_frac) < 1.0
        )
    if isinstance(part, Port):
        return part.geometry == "flat" or central(part.outer_radius_mm) > central(part.thickness_mm) > 0
    assert isinstance(part, Light)
    efficacy_lm_w = central(part.flux_lm) / central(part.power_w)
    return part.kind == "flash" or 0 < efficacy_lm_w < 250.0  # white light cannot have more than about 300


@pytest.mark.parametrize("kind", KINDS)
def test_made_parts_are_plausible_records(kind: str) -> None:
    """Numbers are positive, ranges are in order, nothing is better than physics allows."""
    assert all(plausible(p) for p in getattr(made_parts(1e9), kind))


def test_small_catalogues_begin_the_large_ones() -> None:
    """So that the optimum can only get better with size."""
    for kind in KINDS:
        small, large = getattr(made_parts(1e4), kind), getattr(made_parts(1e8), kind)
        assert large[: len(small)] == small


@pytest.mark.parametrize("size", [1e6, 1e9, 1e12])
def test_kinds_grow_by_one_factor(size: float) -> None:
    """The number of combinations is the one asked for, and all kinds have grown alike."""
    counts, base = counts_for(size), [len(kind) for kind in base_parts()]
    assert STATES * math.prod(counts) == pytest.approx(size, rel=0.15)  # parts come in whole numbers
    factors = [n / b for n, b in zip(counts, base, strict=True)]
    assert max(factors) / min(factors) < 1.2


# ---------------------------------------------------------------- missions


@cache
def enumerated() -> tuple[Parts, list[tuple[float, float]]]:
    """A small catalogue, and least power and cost of every design of it that can be built, by enumeration."""
    made = made_parts(SMALL)
    parts = replace(made, lenses=made.lenses[:4])
    mission = mission_for("loose")
    brute = brute_force
    bench = brute.Bench(Problem(mission, parts, paper=False))
    found = brute.enumerate_all(bench, Objective.of("power"))
    feasible = [one for one in found if math.isfinite(one.value)]
    costs = [brute.fixed_terms(bench.model(one.hardware))["cost"] for one in feasible]
    return parts, [(one.power_w, cost) for one, cost in zip(feasible, costs, strict=True)]


@pytest.mark.skipif(not THOROUGH, reason="random catalogues are enumerated beside the exact search")
@pytest.mark.parametrize("name", MISSIONS)
def test_search_equals_enumeration(name: str) -> None:
    """Hundreds of combinations, each through the forward model, its settings by grids; budgets applied afterwards."""
    parts, designs = enumerated()
    mission = mission_for(name)
    cost_limit, power_limit_w = mission.limits.cost or math.inf, mission.limits.power_w or math.inf
    allowed = [(power, cost) for power, cost in designs if power <= power_limit_w and cost <= cost_limit]
    outcome = Search(
        Problem(mission, parts, paper=False),
        Objective.of(mission.objective),
        top=1,
        progress=None,
    ).run()
    assert outcome.complete and outcome.account.adds_up()
    if name == "infeasible":
        assert not allowed and not outcome.best
        return
    best = min(cost if name == "power-bound" else power for power, cost in allowed)
    assert outcome.best[0].minimised == pytest.approx(best, rel=2e-3)  # what the enumeration's grids may miss
    assert outcome.best[0].minimised <= best * (1 + 1e-6)


@pytest.mark.parametrize(
    ("name", "size"), [*((name, SMALL) for name in MISSIONS), *((name, MEDIUM) for name in MANY)]
)
def test_every_combination_is_accounted_for(name: str, size: float) -> None:
    """The account adds up to the combinations loaded, with no gap left."""
    outcome = solved(name, size)
    assert outcome.account.total == STATES * math.prod(counts_for(size))
    assert scaling.proof_status(outcome) == ("infeasible" if name == "infeasible" else "optimal")


def test_the_loose_mission_is_bound_by_no_budget() -> None:
    """It has none."""
    assert mission_for("loose").limits.cost is None and mission_for("loose").limits.power_w is None


@pytest.mark.parametrize(("name", "key"), [("cost-bound", "cost"), ("power-bound", "power_w")])
def test_the_budget_binds(name: str, key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its budget the mission has a better optimum, which the budget forbids."""
    bound, limit = solved(name, MEDIUM).best[0], MISSIONS[name]["limits"][key]
    monkeypatch.setitem(MISSIONS, name, {**MISSIONS[name], "limits": {}})
    free = search_of(mission_for(name), made_parts(MEDIUM)).run().best[0]
    assert free.minimised < bound.minimised
    assert (free.cost if key == "cost" else free.power_w) > limit
    assert (bound.cost if key == "cost" else bound.power_w) <= limit


@pytest.mark.parametrize("key", ["cost", "power_w"])
def test_each_budget_of_the_infeasible_mission_can_be_met_alone(
    key: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only together they cannot: at 10^6 combinations one budget alone leaves designs."""
    alone = {"objective": "power", "limits": {key: MISSIONS["infeasible"]["limits"][key]}}
    monkeypatch.setitem(MISSIONS, "infeasible", alone)
    assert search_of(mission_for("infeasible"), made_parts(MEDIUM)).run().best


@pytest.mark.parametrize("name", MANY)
def test_large_and_small_search_agree(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The search from pairs on finds what the search from imagers on finds."""
    monkeypatch.setattr(exact_search, "MOST_IMAGERS", 0)
    large, small = search_of(mission_for(name), made_parts(MEDIUM)).run(), solved(name, MEDIUM)
    assert large.complete and large.account.adds_up()
    assert large.account.total == small.account.total
    assert [(f.camera, f.lens, f.port, f.light, f.count) for f in large.best] == [
        (f.camera, f.lens, f.port, f.light, f.count) for f in small.best
    ]
    for one, other in zip(large.best, small.best, strict=True):
        assert one.minimised == pytest.approx(other.minimised, rel=1e-6)  # water's tables reach farther


@pytest.mark.parametrize("name", drawn(["cost-bound"], ["loose", "cost-bound"]))
def test_more_parts_never_make_it_worse(name: str) -> None:
    """Catalogues are nested, so the optimum falls with size."""
    values = [solved(name, size).best[0].minimised for size in (SMALL, 1e5, MEDIUM)]
    assert all(later <= before * (1 + 1e-9) for before, later in pairwise(values))


# ---------------------------------------------------------------- the suite


def test_a_point_in_a_process_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    """What a fresh process writes is the point that this process measures, time and memory apart."""
    apart = scaling.apart("loose", SMALL, seconds=ENOUGH_S)
    here = measured("loose", SMALL)
    assert apart is not None and apart.status == "optimal" and apart.value == here.value
    assert apart.memory_mib > 10.0 and apart.time_s > 0.0
    scaling.main(["loose", "1e3", "full", "60"])
    assert Point(**json.loads(capsys.readouterr().out)).design == here.design


def test_rows_stop_when_the_time_is_over() -> None:
    """Every mission is told of once, as stopped."""
    rows = list(scaling.measure(Budget(quick=True, seconds=-1.0)))
    assert [(row.case, row.status) for row in rows] == [(name, "stopped") for name in MISSIONS]


def test_rows_and_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """A row carries the combinations loaded, and the table has a line a size."""
    point = Point(1440.0, 0.5, 0.6, 70.0, "optimal", 12, 3.0, "camera, lens, port, 2 x light")
    monkeypatch.setattr(scaling, "apart", lambda *given, **more: point)
    rows = list(scaling.size_rows(Budget(quick=True, seconds=ENOUGH_S), (SMALL,), "full"))
    assert {row.case for row in rows} == set(MISSIONS) and all(isinstance(row, BenchRow) for row in rows)
    assert rows[0].size == 1440.0 and rows[0].memory_mib == 70.0 and "12 evaluated" in rows[0].note
    seconds, memory = scaling.tables(rows)
    assert seconds.rows == [("1.44e+03", *["0.50"] * len(MISSIONS))]
    assert memory.rows == [("1.44e+03", *["70"] * len(MISSIONS))]
