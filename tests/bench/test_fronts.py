"""The suite `pareto`: nobody leaves out less than the exact search's bounds allow, and archives only grow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from uwopt.bench import fronts
from uwopt.bench.suite import BenchRow, Budget
from uwopt.solvers.front.search import FRONT_GAP


@pytest.fixture(scope="module")
def rows() -> Sequence[BenchRow]:
    budget = Budget(quick=True, seconds=math.inf, missions=("problems/mbari-lass-2013.yaml",))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fronts, "LONGEST_RUN_S", 1.0)
        return list(fronts.measure(budget, algorithms=["nsga2", "ctaea"]))


def test_exact_front_comes_first_and_is_proven(rows: Sequence[BenchRow]) -> None:
    (end,) = [row for row in rows if row.method == fronts.EXACT and row.status == "optimal"]
    assert rows[0].method == fronts.EXACT and end.error is not None
    assert 0.0 <= end.error <= 10 * FRONT_GAP


def test_no_front_exceeds_the_bound(rows: Sequence[BenchRow]) -> None:
    assert all(row.error is None or row.error >= -1e-9 for row in rows)


@pytest.mark.parametrize("method", ["nsga2", "ctaea"])
def test_archive_only_grows(rows: Sequence[BenchRow], method: str) -> None:
    (run,) = fronts.runs_of(rows, rows[0].case, method)
    gaps = [row.error for row in run if row.error is not None]
    assert gaps and np.all(np.diff(gaps) <= 1e-12)
    times = [row.time_s for row in run if row.time_s is not None]
    assert times == sorted(times) and run[-1].status in ("complete", "stopped")


def test_table_tells_every_method(rows: Sequence[BenchRow]) -> None:
    (table,) = fronts.SUITE.tables(rows)
    assert [line[1] for line in table.rows] == ["exact", "nsga2", "ctaea"]
    late = [replace(row, error=0.5) if row.method == "nsga2" and row.error else row for row in rows]
    assert "not in" in fronts.fronts_table(late).rows[1][3]


def test_mission_without_an_exact_front_is_told_so() -> None:
    budget = Budget(quick=True, seconds=math.inf, missions=("problems/paper-tool-window.yaml",))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fronts, "AXES", ("snr_db", "information"))
        made = list(fronts.measure(budget, algorithms=["nsga2"]))
    assert [row.status for row in made] == ["not applicable"] and made[0].note
