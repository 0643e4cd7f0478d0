"""The search of large catalogues, forced on small ones: its bounds hold, its account adds up, its audit passes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import front_cases
import numpy as np
import pytest
from numpy.typing import NDArray
from random_cases import CHOSEN, FEW, Case, case, lamp, planted
from thorough import drawn

from uwopt.bench.scaling_parts import central
from uwopt.catalog.records import exact
from uwopt.deadline import Deadline
from uwopt.forward.problem import Problem
from uwopt.objectives.dominance import hypervolume
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact import large, lightings, port_groups, tree
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.audit import audit
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.imagers import Imagers, enumerate_imagers, fitting_pairs
from uwopt.solvers.exact.lightings import Corner
from uwopt.solvers.exact.outline import Level, OutlineRows, OutlineScene
from uwopt.solvers.exact.pair_groups import PairGroups
from uwopt.solvers.exact.port_groups import port_tree
from uwopt.solvers.exact.search import Search
from uwopt.solvers.front.designs import found_of
from uwopt.solvers.front.search import Front, FrontSearch

Array = NDArray[Any]
#: Loss tables of searches of three parts a kind do not all reach as far: each is good to so much.
TABLES = drawn(1e-9, 1e-6)
VARIED = ("read_noise_e", "saturation_e", "qe_scale", "power_w", "price")  # of cameras that see alike


@pytest.fixture(autouse=True)
def as_if_large(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few pairs, ports and imagers at a time."""
    monkeypatch.setattr(exact_search, "MOST_IMAGERS", 0)
    monkeypatch.setattr(port_groups, "BRANCHES", 2)
    for module, name, value in (
        (tree, "FIRST_ROWS", 1), (tree, "LARGEST_ROWS", 4), (large, "FIRST_LEAVES", 1), (large, "LARGEST_LEAVES", 2),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, value)


@cache
def solved_large(seed: int) -> Outcome:
    """What the search of a large catalogue, forced as here, finds in a case."""
    return case(seed).solve()[1]


@pytest.mark.parametrize("seed", drawn(CHOSEN[::2], tuple(range(100))))
def test_outlines_bound_their_imagers(seed: int) -> None:
    """No imager behind a port of a group is cheaper, nearer, slower or wider than the group's outline says."""
    outlines_hold(case(seed).problem())


def outlines_hold(problem: Problem) -> None:
    """Every number of the outlines of a problem is on the safe side of its imagers'."""
    imagers = enumerate_imagers(problem)
    if len(imagers) == 0:
        pytest.skip("no imager")
    slack, ports = 1e-9, port_tree(problem)
    pairs = PairGroups.levels(problem, fitting_pairs(problem), Objective.of("power"))
    levels = [Level(problem, ports[0], groups) for groups in pairs] + [Level(problem, groups) for groups in ports]
    for level in levels:
        rows = rows_of(level, imagers)
        seen = level.imagers(rows)
        for name in ("cost", "limit_cost", "mass_kg", "camera_power_w", "gsd_mm"):
            assert (getattr(seen, name) <= getattr(imagers, name) * (1 + slack)).all(), name
        for rule, passes in level.rules(rows, seen):
            assert passes.all(), f"{rule} discards an imager that passes"
        group, own = level.problem.cameras.take(rows.camera), problem.cameras.take(imagers.camera)
        for name in ("read_noise_e", "prnu_frac", "min_exposure_s"):  # less makes a bound of the light lower
            assert (getattr(group, name) <= getattr(own, name)).all(), name
        for name in ("saturation_e", "max_gain", "gain_dn_per_e", "max_exposure_s", "exposure_offset_s", "disk_gb"):
            assert (getattr(group, name) >= getattr(own, name)).all(), name
        for name in ("pixel_pitch_m", "bits", "black_level_dn", "qe_index"):
            assert (getattr(group, name) == getattr(own, name)).all(), name
        for own, out in zip(imagers.scenes, seen.scenes, strict=True):
            for name in ("n_low", "working_factor", "rate_hz"):
                assert (getattr(out.focused, name) <= getattr(own.focused, name) * (1 + slack)).all(), name
            assert (out.focused.blur_time_s * (1 + slack) >= own.focused.blur_time_s).all()
            assert (out.view.collecting_m2 * (1 + slack) >= own.view.collecting_m2).all()
            assert isinstance(out, OutlineScene)
            for name in ("footprint_along_m", "footprint_across_m", "covered_along_m", "covered_across_m", "area_m2"):
                low, one, high = (getattr(view, name) for view in (out.view, own.view, out.most))
                assert (low <= one * (1 + slack)).all() and (one <= high * (1 + slack)).all(), name
            for name in ("pixel_along_m", "pixel_across_m"):
                assert (getattr(own.view, name) <= getattr(out.most, name) * (1 + slack)).all(), name
            assert (out.view.gsd_m <= own.view.gsd_m * (1 + slack)).all()
            assert (out.view.tan_along <= own.view.tan_along * (1 + slack)).all()


def rows_of(level: Level, imagers: Imagers) -> OutlineRows:
    """The row of a level that each imager is in."""

    def group(order: Array, start: Array, part: Array) -> Array:
        return np.asarray(np.searchsorted(start, np.argsort(order)[part], side="right") - 1)

    camera, lens, pairs = imagers.camera, imagers.lens, level.pairs
    if pairs is not None:
        camera = group(pairs.camera_order, pairs.camera_start, camera)
        lens = group(pairs.lens_order, pairs.lens_start, lens)
    return OutlineRows(camera, lens, imagers.landscape, group(level.groups.order, level.groups.start, imagers.port))


def with_variants(made: Case, seed: int) -> Case:
    """The same case with three variants of each of its first two cameras, which see alike, and none dominates."""
    rng = np.random.default_rng([seed, 7])
    cameras = []
    for camera in made.parts.cameras[:2]:
        for i in range(3):
            more = {
                name: exact(central(getattr(camera, name)) * float(factor))
                for name, factor in zip(VARIED, np.exp(rng.uniform(-0.5, 0.5, len(VARIED))), strict=True)
                if getattr(camera, name) is not None
            }
            cameras.append(replace(camera, id=f"{camera.id}-{i}", **more))
    return replace(made, parts=replace(made.parts, cameras=tuple(cameras)))


@pytest.mark.parametrize("seed", FEW)
def test_cameras_that_see_alike_are_bounded_together(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Groups of them bound each, and the search finds what that of a small catalogue finds."""
    case_ = with_variants(case(seed), seed)
    problem = case_.problem()
    _, groups, _ = PairGroups.levels(problem, fitting_pairs(problem), Objective.of("power"))
    assert len(groups.camera_start) < len(problem.parts.cameras)
    large_, small = case_.solve(top=1)[1], small_search(case_, monkeypatch)
    assert large_.complete and large_.account.adds_up() and large_.account.total == small.account.total
    assert [f.minimised for f in large_.best] == pytest.approx([f.minimised for f in small.best[:1]], rel=1e-6)
    outlines_hold(problem)


@pytest.mark.parametrize("seed", FEW)
def test_every_pair_that_fits_is_in_one_group_of_each_level(seed: int) -> None:
    """However groups are parted, each fitting pair comes out once; and the example of a group is one of its own."""
    problem = case(seed).problem()
    pairs = fitting_pairs(problem)
    fit = sorted(zip(pairs.camera.tolist(), pairs.lens.tolist(), strict=True))
    _, coarse, fine = PairGroups.levels(problem, pairs, Objective.of("power"))
    assert coarse.count.sum() == fine.count.sum() == len(fit)
    camera, lens = np.nonzero(coarse.count)
    _, one, other = coarse.parted(camera, lens, fine)
    held = sorted(zip(one.tolist(), other.tolist(), strict=True))
    assert held == [(i, j) for i, j in np.argwhere(fine.count).tolist()]
    for groups, of in ((coarse, (camera, lens)), (fine, (one, other))):
        row, each, its = groups.parted(*of)
        assert sorted(zip(each.tolist(), its.tolist(), strict=True)) == fit
        assert (np.bincount(row, minlength=len(of[0])) == groups.count[of]).all()


@pytest.mark.parametrize("seed", drawn(FEW[:2], FEW))
def test_audit_passes(seed: int) -> None:
    """What the search of pairs discards holds nothing better."""
    search, outcome = case(seed).solve(top=1)
    best = outcome.best[0].minimised if outcome.best else None
    report = audit(search, case(seed).objective, count=12, seed=seed, best_value=best)
    assert report["passed"], report["better"]


@pytest.mark.parametrize("seed", FEW)
def test_without_time_it_claims_nothing(seed: int) -> None:
    """A deadline of zero leaves a bound that the optimum respects, and an account that adds up."""
    full, outcome = solved_large(seed), case(seed).solve(deadline=Deadline.after(0.0))[1]
    assert outcome.account.adds_up() and full.complete
    assert not outcome.complete or outcome.account.discarded.get("not_reached", 0) == 0
    if full.best:
        best = full.best[0].minimised
        assert outcome.lower_bound <= best + 1e-9 * abs(best)


@pytest.mark.parametrize("seed", FEW)
@pytest.mark.parametrize("calls", [0, 2])
def test_account_adds_up_when_interrupted(seed: int, calls: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in the middle of an evaluation: nothing is counted twice and the bound stays valid."""
    full, search = solved_large(seed), case(seed).searcher()
    honest, made = Search._evaluate_pairs, []

    def stopping(self: Search, *given: object) -> None:
        if len(made) == calls:
            raise KeyboardInterrupt
        made.append(1)
        honest(self, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(Search, "_evaluate_pairs", stopping)
    outcome = search.run()
    assert outcome.account.adds_up()
    assert outcome.complete == (not outcome.interrupted)
    if full.best:
        best = full.best[0].minimised
        assert outcome.lower_bound <= best + 1e-9 * abs(best)


# ---------------------------------------------------------------- fronts

FRONTS = (
    (3, ("power", "cost")), (front_cases.SEVERAL, ("power", "mass", "gsd_mm")), (22, ("power", "cost")),
    (24, ("cost", "snr_db")),
    ("steps", ("power", "cost", "snr_db")), ("counts and mounts", ("power", "cost", "snr_db")),
    (front_cases.SEVERAL, ("power", "contrast", "cost")),
)  # fmt: skip


def small_front(case_: Any, names: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> Front:
    """The same front by the search of small catalogues."""
    with monkeypatch.context() as small:
        small.setattr(exact_search, "MOST_IMAGERS", 10**9)
        return front_cases.searched(case_, names)[1]


@pytest.mark.parametrize(("key", "names"), FRONTS)
def test_the_front_of_a_large_catalogue_is_that_of_a_small_one(
    key: int | str, names: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Point by point, every combination counted once, and each point a design with those values."""
    case_ = front_cases.case_of(key)
    small = small_front(case_, names, monkeypatch)
    search, front = front_cases.searched(case_, names)
    assert front.complete and sum(front.account.values()) == front_cases.combinations(search.problem)
    one, other = (found.values[np.lexsort(found.values.T[::-1])] for found in (front, small))
    assert len(one) and one == pytest.approx(other, rel=TABLES)
    for place, values in enumerate(front.values):
        found = found_of(search.search, front, place)
        own = {"power": found.power_w, "cost": found.cost, "mass": found.mass_kg}
        for name, value in zip(names, values, strict=True):
            assert own.get(name, value) == pytest.approx(value, rel=1e-9)


@pytest.mark.parametrize("calls", [0, 1, 3])
def test_a_large_front_that_is_interrupted_leaves_what_it_may_miss(
    calls: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C before a wave: nothing is counted twice, and what is left keeps the bound of the volume above it all."""
    case_, names = front_cases.case_of("counts and mounts"), ("power", "cost")
    honest, made = FrontSearch._take, []

    def stopping(self: FrontSearch, *given: Any) -> bool:
        if len(made) == calls:
            raise KeyboardInterrupt
        made.append(1)
        return honest(self, *given)

    small = small_front(case_, names, monkeypatch)
    monkeypatch.setattr(FrontSearch, "_take", stopping)
    search, front = front_cases.searched(case_, names)
    assert front.interrupted == (not front.complete)
    assert sum(front.account.values()) == front_cases.combinations(search.problem)
    if front.interrupted and len(front.values):
        assert front.frame is not None
        assert front.hypervolume_bound >= hypervolume(small.values, front.frame) - 1e-9


# ---------------------------------------------------------------- what was wrong once


def small_search(case_: Case, monkeypatch: pytest.MonkeyPatch) -> Outcome:
    """The same problem by the search of small catalogues."""
    with monkeypatch.context() as small:
        small.setattr(exact_search, "MOST_IMAGERS", 10**9)
        return case_.solve()[1]


def same_best(case_: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both searches find the same optimum, and there is one."""
    one, other = case_.solve()[1], small_search(case_, monkeypatch)
    assert one.complete and one.account.adds_up() and other.best and one.best
    assert one.best[0].minimised == pytest.approx(other.best[0].minimised, rel=1e-6)


BURNING = lamp("burning", flux_lm=2e4, power_w=200.0)


def test_scene_without_depth_of_field_asks_for_no_f_number(monkeypatch: pytest.MonkeyPatch) -> None:
    """A small circle of confusion counts in no scene but those that ask for a depth of field."""
    sharp = {"requirements": {"circle_of_confusion_px": 0.01}}
    deep = {"requirements": {"min_dof_m": 0.5}}
    wanted = {"min_snr_db": 20.0, "max_blur_px": 1.0}
    same_best(planted("power", (BURNING,), wanted, scenes=(sharp, deep)), monkeypatch)


def test_steps_below_the_least_share_of_a_dial(monkeypatch: pytest.MonkeyPatch) -> None:
    """A lamp that dims in steps takes any of them, whatever its least share says."""
    steps = lamp("steps", flux_lm=2e5, power_w=2000.0, dim_levels=(0.001, 0.3, 1.0), dim_min_frac=0.5)
    free = planted("power", (steps,), {"min_snr_db": 20.0, "max_blur_px": 1.0})
    power_w = 1.01 * small_search(free, monkeypatch).best[0].power_w
    assert power_w < 1000.0, "the lamp was made to shine at less than half"
    limits = free.mission.limits.model_copy(update={"power_w": power_w})
    same_best(replace(free, mission=free.mission.model_copy(update={"limits": limits})), monkeypatch)


def test_interrupted_while_only_what_cannot_win_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in a search of imagers beside which only pairs wait that are beaten keeps what was found."""
    made = planted("power", (BURNING,), {"min_snr_db": 20.0, "max_blur_px": 1.0})
    noise_e, power_w = (40.0, 2.0, 1.0, 1.0), (1.0, 1.1, 1.2, 5000.0)
    cameras = tuple(
        replace(made.parts.cameras[0], id=f"camera-{i}", read_noise_e=exact(noise_e[i]), power_w=exact(power_w[i]))
        for i in range(4)
    )  # fmt: skip
    case_ = replace(made, parts=replace(made.parts, cameras=cameras))
    full, search = case_.solve(top=1)[1], case_.searcher(top=1)
    honest, searched = large.PairTree.handed_over, []

    def stopping(self: large.PairTree, rows: OutlineRows) -> tuple[Bounds, Array]:
        searched.append(1)
        if len(searched) == 2:
            raise KeyboardInterrupt
        return honest(self, rows)

    monkeypatch.setattr(large.PairTree, "handed_over", stopping)
    outcome = search.run()
    assert outcome.interrupted and not outcome.complete and outcome.account.adds_up()
    assert outcome.account.discarded["not_reached"] > 0, "what is beaten is closed when its turn comes"
    assert outcome.lower_bound <= full.best[0].minimised <= outcome.best[0].minimised


def test_many_lights_share_places_of_a_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """A table of fewer places than lights is still a bound, and one of as many is exact."""
    rng = np.random.default_rng(0)
    value, budget = rng.uniform(size=60), np.round(rng.uniform(size=60), 1)
    at, left = np.arange(61).repeat(20), np.tile(np.linspace(-0.1, 1.2, 20), 61)
    least = [value[a:][budget[a:] <= b].min(initial=np.inf) for a, b in zip(at, left, strict=True)]
    assert (Corner.of(value, budget).within(at, left) == least).all()
    monkeypatch.setattr(lightings, "MOST_PLACES", 7)
    small = Corner.of(value, budget)
    assert small.least.shape == (7, 7) and (small.within(at, left) <= least).all()


def test_rounding_does_not_buy_a_lamp() -> None:
    """Of two designs that draw the same power but for rounding the cheaper comes first."""
    found = planted("gsd_mm", (BURNING,), {"min_snr_db": 20.0}).solve(top=1)[1].best[0]
    dearer = replace(
        found, count=found.count + 1, cost=found.cost + 500.0, power_w=found.power_w * (1.0 - 1e-15)
    )
    assert dearer.power_w < found.power_w
    assert found.tie_key(("",)) < dearer.tie_key(("",))


@pytest.mark.parametrize("objective", ["snr_db", {"power": 0.1, "snr_db": 1.0}])
def test_a_level_below_black_is_accounted_for(
    objective: str | dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A camera whose black level is above the wanted mean level is infeasible, in both searches' accounts."""
    camera = {"bit_depth": 8, "black_level_dn": 4.0}
    made = planted(objective, (BURNING,), {"mean_level": 0.012}, camera=camera)
    monkeypatch.setattr(exact_search, "TOO_FEW_TO_BOUND", 0)
    for outcome in (made.solve()[1], small_search(made, monkeypatch)):
        assert outcome.complete and not outcome.best and outcome.account.adds_up()
