"""Work as a clock: the same work counts the same, in each thread its own."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest

import uwopt
from uwopt.deadline import COSTS_S, effort_s, spend

TOOL = Path(__file__).parents[1] / "problems" / "paper-tool-window.yaml"


def spent_on_a_solve() -> float:
    """What one cold solve counts."""
    before = effort_s()
    uwopt.solve(TOOL, quick=True)
    return effort_s() - before


def test_the_same_work_counts_the_same_whatever_the_machine_does_beside() -> None:
    first = spent_on_a_solve()
    time.sleep(0.01)
    assert first > 0.0
    assert spent_on_a_solve() == pytest.approx(first, rel=1e-9)


def test_threads_count_their_own_work() -> None:
    other: list[float] = []

    def work() -> None:
        spend("bounds", 1000)
        other.append(effort_s())

    before = effort_s()
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert other == [pytest.approx(1000 * COSTS_S["bounds"])]
    assert effort_s() == before
