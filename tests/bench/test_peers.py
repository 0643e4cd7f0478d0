"""The suite `solvers`: peers beside the exact search, on catalogues small enough for all of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import random_cases
from thorough import drawn

from uwopt.bench import contest, peers
from uwopt.bench.contest import Contest, Referee
from uwopt.bench.suite import BenchRow, Budget
from uwopt.forward.problem import Problem

LEAST_GAP = -1e-6  # requirements count as met to 1e-6, which buys as much of the objective
SEEDS = drawn((3,), (3, 9))  # random catalogues that have designs
FEW_S = drawn(0.06, 0.25)  # for each method; no verdict depends on how far it comes


@dataclass(frozen=True)
class SmallContest(Contest):
    """A random catalogue as a contest."""

    case: Any = None

    def problem(self) -> Problem:
        return self.case.problem()  # type: ignore[no-any-return]


@cache
def small(seed: int) -> SmallContest:
    case = random_cases.case(seed)
    found = contest.certified(case.problem(), case.objective, 60.0)
    assert found.best and found.complete
    return SmallContest(
        f"case {seed}", case.mission, None, case.objective, found.best[0].minimised, found.lower_bound, True, False,  # type: ignore[arg-type]
        case,
    )  # fmt: skip


@cache
def run(method: str, seed: int) -> tuple[BenchRow, ...]:
    peers.load_libraries()
    return tuple(peers.run_peer(small(seed), method, 0, FEW_S))


@pytest.mark.parametrize("seed", SEEDS)
def test_exact_search_ends_with_its_proof(seed: int) -> None:
    rows = peers.run_exact(small(seed))
    assert rows[-1].status == "optimal" and rows[-1].error is not None
    assert LEAST_GAP <= rows[-1].error <= 2e-4  # what settings without closed form may leave open
    assert all(row.status == "running" for row in rows[:-1])


@pytest.mark.parametrize("method", peers.PEERS)
@pytest.mark.parametrize("seed", SEEDS)
def test_nobody_beats_the_certificate(method: str, seed: int) -> None:
    rows = run(method, seed)
    assert all(row.error is None or row.error >= LEAST_GAP for row in rows)
    errors = [row.error for row in rows[:-1] if row.error is not None]
    assert errors == sorted(errors, reverse=True)  # the best so far
    assert rows[-1].error == (errors[-1] if errors else None)


@pytest.mark.parametrize("method", peers.PEERS)
def test_a_run_says_how_it_ended(method: str) -> None:
    for row in (run(method, seed)[-1] for seed in SEEDS):
        assert row.status in ("reached", "stopped", "not applicable")
        assert (row.status == "reached") == (row.error is not None and row.error <= peers.TARGET)


@pytest.mark.parametrize("method", ["pymoo-ga", "scipy-de", "random"])
def test_population_finds_a_feasible_design_of_a_small_catalogue(method: str) -> None:
    referee = Referee(small(SEEDS[0]), 60.0, small(SEEDS[0]).problem())
    referee.over = lambda: np.isfinite(referee.best)  # type: ignore[method-assign]
    peers.PEERS[method](referee, 0)
    assert referee.gap is not None


def test_claim_that_misses_a_requirement_is_refused() -> None:
    one = small(SEEDS[0])
    outcome = contest.certified(one.problem(), one.objective, 60.0)
    found = outcome.best[0]
    referee = Referee(one, 10.0, one.problem())
    dark = [{**numbers, "level": numbers["level"] * 1e-3} for numbers in found.settings]
    referee.claim(found.minimised - 1.0, found.hardware, dark)
    assert referee.refused == 1 and referee.gap is None
    referee.claim(
        found.minimised - 1.0, found.hardware, found.settings
    )  # its true value counts, not its word
    assert referee.gap == pytest.approx(0.0, abs=1e-6)


def test_sunlit_mission_is_not_for_smooth_solvers() -> None:
    class Sunlit(SmallContest):
        pass

    one = small(SEEDS[0])
    changed = Sunlit(**{**one.__dict__, "objective": replace(one.objective, weights={"contrast": 1.0})})
    rows = peers.run_peer(changed, "casadi-ipopt", 0, FEW_S)
    assert [row.status for row in rows] == ["not applicable"] and rows[0].note


# ---------------------------------------------------------------- rows and tables


def rows_by_hand() -> Sequence[BenchRow]:
    def ends(
        method: str, *times: tuple[float, float | None], status: str, case: str = "reef"
    ) -> list[BenchRow]:
        made = [BenchRow("solvers", case, method, 1.0, 0, t, e, status="running") for t, e in times]
        return [*made[:-1], replace(made[-1], status=status)]

    return [
        *ends("exact", (0.1, 0.5), (0.3, 0.0), (0.5, 0.0), status="optimal"),
        *ends("pymoo-ga", (1.0, 0.1), (2.0, 5e-4), (2.5, 5e-4), status="reached"),
        *ends("pymoo-ga", (1.0, 0.1), (4.0, 5e-4), (4.5, 5e-4), status="reached"),
        *ends("pymoo-ga", (1.0, 0.1), (5.0, 0.1), status="stopped"),
        *ends("random", (5.0, None), status="stopped"),
        *ends("bonmin", (0.0, None), status="not applicable"),
    ]


def test_time_to_the_target_is_the_median_of_the_runs() -> None:
    times, longest, status = peers.arrivals(rows_by_hand(), "reef", "pymoo-ga")
    assert times == [2.0, 4.0, np.inf] and longest == 5.0 and status == "stopped"
    (table,) = peers.time_tables(rows_by_hand())
    assert table.head == ["method", "reef"]
    assert dict(table.rows) == {
        "exact, found": "0.30", "exact, proven": "0.50", "bonmin": "-", "pymoo-ga": "4.00", "random": "not in 5.0",
    }  # fmt: skip


def test_missions_stand_beside_each_other_a_few_a_table() -> None:
    many = [replace(row, case=f"reef {k}") for k in range(7) for row in rows_by_hand()]
    assert [len(table.head) - 1 for table in peers.time_tables(many)] == [
        peers.CASES_A_TABLE,
        7 - peers.CASES_A_TABLE,
    ]


def test_exact_is_ahead_only_with_its_proof() -> None:
    (row,) = peers.ahead_table(rows_by_hand()).rows
    assert row == ["reef", "0.30", "0.50", "pymoo-ga, 4.00", "exact, 8.0 times, proof included"]
    faster = [replace(r, time_s=0.4) if r.method == "random" else r for r in rows_by_hand()]
    faster = [replace(r, error=0.0) if r.method == "random" else r for r in faster]
    assert "its proof takes longer" in peers.ahead_table(faster).rows[0][-1]


def test_suite_runs_the_mission_that_init_writes_where_none_is_named() -> None:
    assert contest.sources_of(Budget(quick=True, seconds=math.inf)) == [("uwopt init", None)]
    assert contest.mission_of(None).practice == "recommended"


def test_suite_runs_the_missions_that_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "LONGEST_RUN_S", FEW_S)
    budget = Budget(quick=True, seconds=math.inf, missions=("problems/mbari-lass-2013.yaml",))
    rows = list(peers.measure(budget, methods=["random"]))
    assert {row.method for row in rows} == {"exact", "random"}
    assert {row.case for row in rows} == {"mbari-lass-2013"}
    assert [table.title for table in peers.SUITE.tables(rows)]
