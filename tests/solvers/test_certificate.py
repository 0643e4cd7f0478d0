"""The certificate by hand: where every combination went, what bound is left, and whose word breaks a tie."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from one_of_each import one, with_parts

from uwopt.deadline import Deadline
from uwopt.objectives.objective import Objective
from uwopt.results.result import Certificate
from uwopt.solvers.exact import large, tree
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.account import Account, Outcome
from uwopt.solvers.exact.certificate import accounted, certificate
from uwopt.solvers.exact.ranking import Found, Ranking
from uwopt.solvers.exact.search import Search

FAST = {"max_blur_px": 1.0, "min_snr_db": 26.0}


# ---------------------------------------------------------------- the account


def selection() -> Any:
    """Three cameras of which one has no colour, two lenses, a port, two lamps of which one is not deep enough."""
    sizes = {"camera": 3, "lens": 2, "port": 1, "light": 2}
    return SimpleNamespace(
        catalog=SimpleNamespace(parts=lambda kind: range(sizes[kind])),
        indices={"camera": (0, 2), "lens": (0, 1), "port": (0,), "light": (1,)},
        counts={"camera": {"colour": 1}, "lens": {}, "port": {}, "light": {"depth": 1}},
    )


def four_ways() -> Any:
    """One or two lamps, both orientations."""
    return one(vehicle={"light_count": [1, 2], "orientation": "any"}).problem()


def test_every_combination_is_counted_once_by_hand() -> None:
    """3 x 2 x 1 x 2 x 4 = 48; a camera takes 2 x 1 x 2 x 4 with it, a lamp then 2 x 2 x 1 x 4; 16 are searched."""
    found = accounted(selection(), four_ways(), 6, {"mount": 10, "cost": 0})
    assert (found["loaded"], found["selected"], found["evaluated"]) == (48, 16, 6)
    assert found["discarded"] == [
        {"rule": "camera: colour", "count": 16}, {"rule": "light: depth", "count": 16}, {"rule": "mount", "count": 10},
    ]  # fmt: skip


def proof(best: float | None, lower: float, objective: Any = "power", *, evaluated: int = 6) -> Certificate:
    """The certificate of an outcome made up."""
    outcome = SimpleNamespace(
        best=[] if best is None else [SimpleNamespace(minimised=best)], lower_bound=lower, complete=False,
        account=SimpleNamespace(evaluated=evaluated, discarded={"mount": 10}),
    )  # fmt: skip
    return certificate(selection(), four_ways(), outcome, Objective.of(objective))  # type: ignore[arg-type]


def test_an_account_that_counts_twice_does_not_add_up() -> None:
    """Six evaluated add up, seven do not."""
    assert proof(10.0, 8.0).adds_up() and not proof(10.0, 8.0, evaluated=7).adds_up()


def test_a_gap_that_is_open_is_told() -> None:
    """Best 10 W, none below 8 W: 2 W are open, a fifth."""
    found = proof(10.0, 8.0)
    assert (found.lower_bound, found.best_value, found.gap_abs) == (8.0, 10.0, 2.0)
    assert found.gap_rel == pytest.approx(0.2) and not found.complete


def test_bounds_of_what_is_maximised_lie_above() -> None:
    """30 dB found, 31 dB not excluded."""
    found = proof(-30.0, -31.0, "snr_db")
    assert (found.lower_bound, found.best_value, found.gap_abs) == (31.0, 30.0, 1.0)


def test_nothing_found_has_no_gap() -> None:
    """Infinite is no number of a result."""
    found = proof(None, math.inf)
    assert found.lower_bound is None and found.gap_rel is None


@pytest.mark.parametrize(
    ("evaluated", "discarded", "whole"),
    [(6, {"mount": 4}, True), (6, {"mount": 5}, False), (5, {"mount": 4}, False)],
)
def test_the_search_holds_its_account_against_all_combinations(
    evaluated: int, discarded: dict[str, int], whole: bool
) -> None:
    """Ten in all."""
    assert Account(10, evaluated, discarded).adds_up() == whole


# ---------------------------------------------------------------- what bound is left


def cut(monkeypatch: pytest.MonkeyPatch, calls: int, *, way: str = "small") -> tuple[Outcome, Outcome]:
    """A search of three cameras that Ctrl-C ends before an evaluation, and the whole one."""
    case_ = with_parts(
        one(wanted=FAST),
        cameras=[{"read_noise_e": 40.0, "power_w": 3.1}, {"read_noise_e": 80.0, "power_w": 3.2}],
    )
    for name in ("FIRST_BATCH", "LARGEST_BATCH"):
        monkeypatch.setattr(exact_search, name, 1)
    for name in ("FIRST_ROWS", "FIRST_NODES"):
        monkeypatch.setattr(tree, name, 1)
    monkeypatch.setattr(large, "FIRST_LEAVES", 1)
    monkeypatch.setattr(exact_search, "TOO_FEW_TO_BOUND", 0)
    monkeypatch.setattr(exact_search, "MOST_IMAGERS", 10**9 if way == "small" else 0)
    case_ = replace(case_, parts=replace(case_.parts, cameras=case_.parts.cameras[::-1]))
    full, sound, made = case_.solve(top=3)[1], Search._evaluate_pairs, []

    def stopping(self: Search, *given: Any) -> None:
        made.append(1)
        if len(made) > calls:
            raise KeyboardInterrupt
        sound(self, *given)

    with monkeypatch.context() as patched:
        patched.setattr(Search, "_evaluate_pairs", stopping)
        return case_.solve(top=3)[1], full


@pytest.mark.parametrize(("way", "calls"), [("small", 1), ("large", 0)])
def test_a_search_cut_short_has_a_bound_below_what_it_found(
    way: str, calls: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next camera draws 3.1 W and any light: less cannot be excluded, and nothing below it is claimed.

    Of a large catalogue all cameras wait with the bounds of their light, which are higher.
    """
    outcome, full = cut(monkeypatch, calls, way=way)
    assert outcome.interrupted and not outcome.complete and outcome.account.adds_up()
    assert 3.0 <= outcome.lower_bound <= full.best[0].minimised
    if way == "small":
        assert outcome.lower_bound == pytest.approx(3.1)
    else:
        assert outcome.lower_bound > 3.2, "what waits has been bounded with its light"


def test_a_search_that_found_nothing_yet_has_a_bound_below_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    """3 W for the first camera's electronics alone."""
    outcome, full = cut(monkeypatch, 0)
    assert not outcome.best and outcome.lower_bound == pytest.approx(3.0)
    assert outcome.lower_bound < full.best[0].minimised


def test_a_search_out_of_time_has_the_bound_of_the_next_unit() -> None:
    """Above the electronics' 3 W, as the unit's light is bounded too, and no more than the best of all."""
    case_ = one(wanted=FAST)
    ticks = iter(range(10_000))
    late = Deadline(3.0, clock=lambda: float(next(ticks)))  # once imagers are listed and nodes bounded
    grown = with_parts(case_, lenses=[{"focal_length_mm": f} for f in np.linspace(7.0, 9.0, 9)])
    outcome, full = grown.solve(deadline=late)[1], grown.solve()[1]
    assert not outcome.complete and outcome.account.adds_up()
    assert 3.0 < outcome.lower_bound <= full.best[0].minimised


def test_a_gap_of_settings_is_left_in_the_bound() -> None:
    """Information is found to a gap, and by another quadrature: the bound lies above the best, by a little."""
    outcome = one("information", wanted={**FAST, "min_swath_m": 1.0}).solve()[1]
    best = -outcome.best[0].minimised
    assert best < -outcome.lower_bound <= best * (1.0 + 2e-4)


def test_a_design_that_draws_too_much_leaves_no_gap() -> None:
    """The cheaper of two flashes cannot do with the power that is allowed: it proves nothing about the other's cost."""
    fading = {
        "kind": "flash", "flux_lm": None, "power_w": None, "flash_energy_j": 30.0, "flash_efficacy_lm_s_per_j": 35.0,
        "flash_duration_us": 800.0, "flash_duration_at_frac": 0.3, "recycle_s": 0.5, "dim_min_frac": 0.02,
        "charging_efficiency_frac": 0.7, "price": 300.0,
    }  # fmt: skip

    def solved(objective: str, **limits: float) -> Outcome:
        camera = {"dark_current_e_s": 50.0, "min_exposure_us": 20.0}
        case_ = one(objective, wanted=FAST, light=fading, camera=camera, limits=limits)
        dearer = {"price": 900.0, "charging_efficiency_frac": 0.9}
        return with_parts(case_, lights=[dearer]).solve(top=2)[1]

    thrifty, cheap = solved("power").best
    assert (thrifty.light, cheap.light) == (1, 0) and thrifty.power_w < 0.99 * cheap.power_w
    outcome = solved("cost", power_w=0.9993 * cheap.power_w)  # enough but for the veil
    assert [found.light for found in outcome.best] == [1]
    assert outcome.complete and outcome.lower_bound == outcome.best[0].minimised > cheap.cost


# ---------------------------------------------------------------- ties and runners-up


def ranked(top: int = 3) -> tuple[Ranking, Found]:
    """An empty list of the best, and a design that draws 10 W."""
    search, outcome = with_parts(one(wanted=FAST), cameras=[{}, {}, {}]).solve(top=1)
    sample = replace(
        outcome.best[0], minimised=10.0, power_w=10.0, cost=2000.0, mass_kg=2.0, count=2, pulse_s=1e-3
    )
    return Ranking(search.problem, search.imagers, top=top, ceiling=math.inf), sample


@pytest.mark.parametrize(
    "better",
    [{"power_w": 9.9}, {"cost": 1999.0}, {"mass_kg": 1.9}, {"count": 1}, {"pulse_s": 9e-4}],
    ids=lambda given: next(iter(given)),
)
def test_a_tie_is_broken_by(better: dict[str, float]) -> None:
    """Of two designs with the same objective the one with less of it, though its id comes later."""
    ranking, design = ranked()
    ranking._insert(replace(design, camera=0))
    ranking._insert(replace(design, camera=1, minimised=10.0 * (1.0 + 0.5e-9), **better))  # type: ignore[arg-type]
    assert [found.camera for found in ranking.best] == [1, 0]


def test_what_breaks_a_tie_first_decides() -> None:
    """Less power at a higher price wins where power and price both differ."""
    ranking, design = ranked()
    ranking._insert(replace(design, camera=0, power_w=9.0, cost=9000.0))
    ranking._insert(replace(design, camera=1))
    assert [found.camera for found in ranking.best] == [0, 1]


def test_ids_break_the_last_tie() -> None:
    """In whatever order they are found."""
    for order in ((0, 1), (1, 0)):
        ranking, design = ranked()
        for camera in order:
            ranking._insert(replace(design, camera=camera))
        assert [found.camera for found in ranking.best] == [0, 1]


def test_more_than_a_tie_is_no_tie() -> None:
    """A billionth and a little more decides before all else."""
    ranking, design = ranked()
    ranking._insert(replace(design, camera=1, minimised=10.0 * (1.0 + 3e-9), power_w=1.0))
    ranking._insert(replace(design, camera=0))
    assert [found.camera for found in ranking.best] == [0, 1]


def test_runners_up_have_other_hardware() -> None:
    """Of one hardware only the best number of lamps is listed, and only so many in all; what has left may return."""
    ranking, design = ranked(top=2)
    for camera, value in ((0, 12.0), (0, 11.0), (1, 13.0), (0, 14.0), (2, 12.5)):
        ranking._insert(replace(design, camera=camera, minimised=value))
    assert [(found.camera, found.minimised) for found in ranking.best] == [(0, 11.0), (2, 12.5)]
    ranking._insert(replace(design, camera=1, minimised=12.0))
    ranking.best = [replace(found, imager=7) for found in ranking.best]  # as who brings them into another order does
    ranking._insert(replace(design, camera=0, minimised=10.0))
    assert [(found.camera, found.minimised) for found in ranking.best] == [(0, 10.0), (1, 12.0)]


def test_the_last_place_is_what_must_be_beaten() -> None:
    """Ties included; anything while there is room."""
    ranking, design = ranked(top=2)
    ranking._insert(replace(design, camera=0))
    assert ranking.threshold() == math.inf
    assert not ranking.shut_out(*(np.array([1e9]) for _ in range(4))).any()
    ranking._insert(replace(design, camera=1, minimised=20.0, power_w=20.0))
    assert ranking.threshold() == pytest.approx(20.0, rel=2e-9) and ranking.threshold() > 20.0


def test_ties_are_shut_out_by_what_comes_after_all_that_are_known() -> None:
    """Of lower bounds of objective, power, cost and mass the first that differs decides; equal ones may still win."""
    ranking, design = ranked(top=2)
    known = replace(design, minimised=10.0, power_w=5.0, cost=100.0, mass_kg=2.0)
    ranking._insert(replace(known, camera=0))
    ranking._insert(replace(known, camera=1, mass_kg=3.0))
    last, tied = (10.0, 5.0, 100.0, 3.0), 10.0 * (1.0 + 5e-10)
    for bounds, shut in (
        (last, False), ((tied, *last[1:]), False), ((10.0 * (1.0 - 3e-9), 9.0, 900.0, 9.0), False),
        ((10.0, 4.0, 900.0, 9.0), False), ((10.0, 5.0, 99.0, 9.0), False), ((10.0, 5.0, 100.0, 2.5), False),
        ((10.0, 5.1, 1.0, 1.0), True), ((tied, 5.0, 101.0, 1.0), True), ((10.0, 5.0, 100.0, 3.1), True),
        ((10.0 * (1.0 - 5e-10), 5.1, 1.0, 1.0), True), ((10.0 * (1.0 + 3e-9), 1.0, 1.0, 1.0), True),
        ((10.0, 5.0 * (1.0 + 1e-14), 100.0, 3.0), False),
    ):  # fmt: skip
        assert ranking.shut_out(*(np.array([bound]) for bound in bounds)).tolist() == [shut], bounds


def test_a_search_lists_runners_up_in_their_order() -> None:
    """Cameras that draw 3, 4 and 5 W are the three best."""
    case_ = with_parts(one(wanted=FAST), cameras=[{"power_w": 5.0}, {"power_w": 4.0}, {"power_w": 6.0}])
    outcome = case_.solve(top=3)[1]
    assert [found.camera for found in outcome.best] == [0, 2, 1]
    assert np.diff([found.minimised for found in outcome.best]).tolist() == pytest.approx([1.0, 1.0])
