"""What a told change is drawn in by: its own hardware, the best of a few imagers, and more time for the best of all."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from test_least_change import POWER, mission

from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import Deadline
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.infeasible import least_change, relaxed_imagers, why_nothing
from uwopt.solvers.infeasible.least_change import Change, Narrowing, with_its_hardware
from uwopt.solvers.infeasible.least_limit import FIGURE_S, LeastLimit, Relaxation
from uwopt.solvers.infeasible.reached import judged_by, reached_value
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.infeasible.singles import Singles
from uwopt.solvers.infeasible.trials import Trials
from uwopt.solvers.recommend import seek


@pytest.mark.parametrize(("needs", "reached", "asked"), [(43.0, 43.0, [42.4]), (36.87, 36.9, None)])
def test_hardware_that_needs_all_of_a_change_is_asked_once_for_less(monkeypatch, needs, reached, asked):
    tried: list[float] = []

    def same_hardware(found: Any, limit: Any) -> Any:
        tried.append(limit)
        return SimpleNamespace(outcome=SimpleNamespace(best=[1] * (limit >= needs)))

    monkeypatch.setattr(least_change, "same_hardware", same_hardware)
    drawn = with_its_hardware(12.0, Change(43.0, cast(Any, None)), cast(Any, lambda limit: limit))
    assert drawn.limit == reached
    assert asked is None or tried == asked


def without_gsd(parts: Path, catalog: Catalog) -> LeastLimit:
    """Images finer than any, and what fits without: that which takes least power, or else the coarser of two lenses."""
    wanted = mission(parts, lenses=("zz-lens", "zz-wide"), max_gsd_mm=0.5)
    relaxed = mission(parts, lenses=("zz-wide",))
    trials = Trials(wanted, catalog, POWER, "never")
    coarse = seek(relaxed, catalog, POWER, generic="never", top=1)
    return LeastLimit(trials, "max_gsd_mm", 0.5, mission(parts, lenses=("zz-lens", "zz-wide")), coarse)


def test_the_best_of_a_few_imagers_takes_the_place_of_a_design_that_needs_more(parts, catalog, monkeypatch):
    one = without_gsd(parts, catalog)

    def all_of_them(self: Relaxer, wanted: Any, goal: Any, freed: Any, *_: Any, **more: Any) -> Any:
        return self.seek(wanted, goal, freed)

    monkeypatch.setattr(Relaxer, "among_few", all_of_them)
    turn = Deadline(0.5 * FIGURE_S, lambda: 0.0)
    coarse = reached_value(judged_by(one.trials.mission, one.found, POWER), "max_gsd_mm")
    one.step(turn)
    assert one.told().needed == pytest.approx(coarse, rel=0.01)
    one.step(turn)
    assert one.told().needed < 0.9 * coarse
    assert one.found.problem.parts.lenses[one.found.outcome.best[0].lens].id == "zz-lens"


def test_the_best_figure_is_asked_for_again_with_more_time(parts, catalog, monkeypatch):
    one, turns = without_gsd(parts, catalog), list[float]()

    def too_long(self: LeastLimit, goal: Any, turn: Deadline) -> Any:
        turns.append(turn.left_s)
        return SimpleNamespace(outcome=SimpleNamespace(best=[], complete=False, interrupted=False))

    monkeypatch.setattr(LeastLimit, "_best_without", too_long)
    one.by_few = True
    for seconds in (FIGURE_S, 1.1 * FIGURE_S, 2.0 * FIGURE_S, 2.1 * FIGURE_S):
        one.step(Deadline(seconds, lambda: 0.0))
    assert turns == [FIGURE_S, 2.0 * FIGURE_S]


def test_what_is_found_late_is_drawn_in_before_others_are_asked_again(parts, catalog, monkeypatch):
    """The time is over before it begins; a finer image is had from lower, and 1 m is far lower than it need be."""
    wanted, at_first = mission(parts, max_gsd_mm=0.5), list[float]()
    found = seek(wanted, catalog, POWER, generic="never", top=1)
    proof = certificate(found.selection, found.problem, found.outcome, POWER)

    def ask_open(singles: Any, mover: Any) -> None:
        at_first.extend(move.drawn.gap for move in mover.helpful)

    monkeypatch.setattr(why_nothing, "ask_open", ask_open)
    over = Deadline(0.0, lambda: 1.0)
    why_nothing.why_nothing(Trials(wanted, catalog, POWER, "never", over, more_s=100.0), proof)
    assert at_first and max(at_first) < 1.0 and math.isfinite(max(at_first))


def test_a_few_imagers_are_tried_first_though_all_are_soon_known(parts, catalog, monkeypatch):
    """Where something likely fits: without what likely stands in the way, and half-way to what is asked."""
    one, asked = without_gsd(parts, catalog), list[Any]()
    monkeypatch.setattr(Relaxer, "is_soon_known", lambda self, freed=(): True)
    monkeypatch.setattr(Relaxer, "_few_known", lambda self, problem, *_: asked.append(problem.mission))
    one.by_few = True
    for _ in range(2):
        one.step(Deadline(0.5 * FIGURE_S, lambda: 0.0))
    assert len(asked) == 1
    singles = Singles(one.trials)
    singles._ask_suspect("max_gsd_mm", 1.0)
    assert len(asked) == 2 and [one.name for one in singles.helpful] == ["max_gsd_mm"]


def test_what_bounds_tell_of_a_change_is_not_searched_for(monkeypatch):
    """Nothing fits from 0.799 on, and the hardware at hand reaches 0.797: of a change from 0.9 that is all."""
    monkeypatch.setattr(least_change, "same_hardware", lambda found, limit: fitting(limit <= 0.797))
    nothing = cast(Any, None)
    one = Narrowing(0.9, Change(0.5, nothing), cast(Any, lambda limit: limit), nothing, beyond=0.799)
    one.step(Deadline(1.0, lambda: 0.0))
    assert one.is_done and one.change.limit == 0.797


def fitting(does: bool) -> Any:
    """A search that found something, or nothing."""
    return SimpleNamespace(outcome=SimpleNamespace(best=[1] * does))


def dear(parts: Path, catalog: Catalog, cost: float) -> Relaxer:
    """What a mission of two cameras, two lenses and two ports shares that is to cost less than any of them."""
    wanted = mission(parts, lenses=("zz-lens", "zz-wide")).with_changes(limits={"cost": cost})
    data = wanted.to_dict()["catalog"] | {"cameras": ["zz-cam", "zz-other"], "lenses": ["zz-lens", "zz-corner"]}
    wanted = wanted.with_changes(catalog=data)
    return Relaxer(wanted, catalog, "never", seek(wanted, catalog, POWER, generic="never", top=1))


def test_pairs_that_a_limit_of_cost_allows_by_no_port_are_not_looked_at_and_no_others(parts, catalog, monkeypatch):
    """zz-cam 500, zz-other up to 2000, each lens 300, ports 200 and 900: 1000, 2500, 1700, 3200 USD."""
    relaxer, listed = dear(parts, catalog, 100.0), relaxed_imagers.imagers_of_pairs
    looked_at = list[int]()

    def counted(problem: Any, some: Any, *more: Any) -> Any:
        looked_at.append(sum(len(camera) for camera, _ in some.values()))
        return listed(problem, some, *more)

    monkeypatch.setattr(relaxed_imagers, "imagers_of_pairs", counted)
    found = []
    for limit in (999.0, 1000.0, 1699.0, 2499.0, 2500.0, 9999.0):
        problem = relaxer.asking(relaxer.mission.with_changes(limits={"cost": limit}))
        found.append(len(relaxer.imagers(problem, {"cost"}, one_housing=False)))
    assert found == [0, 2, 2, 4, 6, 8] and looked_at == [0, 2, 2, 4, 6, 8]


def test_the_cheapest_behind_the_cheapest_ports_are_among_a_few(parts, catalog, monkeypatch):
    monkeypatch.setattr(relaxed_imagers, "FEW_CHEAPEST", 2)
    monkeypatch.setattr(relaxed_imagers, "FEW_PLACES", 1)
    relaxer = dear(parts, catalog, 100.0)
    every = relaxer._freed_pairs({"cost"})
    (place,) = (one for one in every if relaxer.problem.parts.ports[one[0]].id == "zz-port")
    last = {one: rows[-1:] for one, rows in every.items()}
    made = relaxer._with_cheapest(last, every)
    names = {relaxer.problem.parts.cameras[relaxer.pairs.camera[row]].id for row in made[place]}
    assert names == {"zz-cam", "zz-other"} and len(made[place]) == 3  # both lenses of the one, and what was there
    assert all(list(made[one]) == list(last[one]) for one in every if one != place)


def test_a_signal_in_as_much_noise_is_drawn_in_by_the_best_of_a_few(parts, catalog, monkeypatch):
    """What takes least power has 0 dB, and can do no more; the lamp has light for far more behind any lens."""
    wanted, asked = mission(parts, min_snr_db=90.0), list[bool]()
    relaxed = mission(parts, min_snr_db=0.0)
    found = seek(relaxed, catalog, POWER, generic="never", top=1)

    def all_of_them(self: Relaxer, wanted: Any, goal: Any, freed: Any, *_: Any, enough: bool, **more: Any) -> Any:
        asked.append(enough)
        return self.seek(wanted, goal, freed)

    monkeypatch.setattr(Relaxer, "among_few", all_of_them)
    monkeypatch.setattr(least_change, "same_hardware", lambda found, limit: fitting(False))
    one = LeastLimit(Trials(wanted, catalog, POWER, "never"), "min_snr", 90.0, relaxed, found)
    one.step(Deadline(0.5 * FIGURE_S, lambda: 0.0))
    assert one.told().needed > 30.0 and asked == [False]


def test_what_lets_only_noise_through_is_not_what_comes_nearest():
    """0.97 dB for 20 are 95 % less, and 3 px of blur for 1 three times as much: the latter is an image."""
    noise = Relaxation("min_snr", 20.0, 0.97, 0.95, cast(Any, None))
    blur = Relaxation("max_blur_px", 1.0, 3.0, 2.0, cast(Any, None))
    changes = [SimpleNamespace(told=lambda one=one: one) for one in (noise, blur)]
    singles = SimpleNamespace(trials=SimpleNamespace(interrupted=True), left=[], helpful=changes)
    mover = SimpleNamespace(left=[], helpful=[])
    told, _ = why_nothing.least_changes(cast(Any, singles), cast(Any, mover))
    assert [one.name for one in told] == ["max_blur_px", "min_snr"]
