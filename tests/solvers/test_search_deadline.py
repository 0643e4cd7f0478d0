"""A search whose time ends anywhere: what it found stays, what it did not reach is counted, its bound is valid."""

from __future__ import annotations

import math
from itertools import count

import pytest
from random_cases import THOROUGH, case

from uwopt.deadline import Deadline
from uwopt.objectives.axes import Axes
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.front import search as front_search
from uwopt.solvers.front.search import FrontSearch

SEEDS = range(40) if THOROUGH else (1, 3)  # the fast ones
READINGS = range(0, 60) if THOROUGH else (0, 1, 2, 3, 5, 9, 17)


def cut_at(seed: int, readings: int) -> Outcome:
    """The search of a case, whose clock counts its readings and ends it after so many."""
    return case(seed).solve(deadline=Deadline(readings + 0.5, count(1).__next__))[1]


def assert_valid(outcome: Outcome, full: Outcome) -> None:
    assert outcome.account.adds_up()
    assert outcome.account.total == full.account.total
    assert outcome.complete == (outcome.account.discarded.get("not_reached", 0) == 0)
    optimum = full.best[0].minimised if full.best else math.inf
    slack = 1e-9 * abs(optimum) if math.isfinite(optimum) else 0.0
    assert outcome.lower_bound <= optimum + slack
    assert all(found.minimised >= optimum - slack for found in outcome.best)
    assert not outcome.interrupted


@pytest.mark.parametrize("seed", SEEDS)
def test_wherever_time_ends_bound_and_account_hold(seed: int) -> None:
    full = case(seed).solve()[1]
    for readings in READINGS:
        assert_valid(cut_at(seed, readings), full)


@pytest.mark.parametrize("seed", SEEDS)
def test_wherever_time_ends_bound_and_account_of_pairs_hold(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = case(seed).solve()[1]
    monkeypatch.setattr(exact_search, "MOST_IMAGERS", 0)
    for readings in READINGS:
        assert_valid(cut_at(seed, readings), full)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_search_tells_how_much_is_accounted_for(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between its batches, too, for all of a small catalogue is one step."""
    monkeypatch.setattr(exact_search, "FIRST_BATCH", 1)
    monkeypatch.setattr(exact_search, "UNBEATEN_GROWTH", 1)
    told: list[tuple[float, str]] = []

    def hear(share: float, what: str) -> None:
        told.append((share, what))

    case(seed).solve(progress=hear)
    shares = [share for share, what in told if what.startswith("settings")]
    assert len(set(shares)) > 1 and shares == sorted(shares)
    assert min(shares) >= 0.0 and max(shares) < 1.0 and told[-1][0] == 1.0


def test_time_that_ends_within_a_batch_ends_it() -> None:
    """At the second reading, within the first batch, nothing is solved yet, though the batch is the whole search."""
    assert [cut_at(seed, 1).complete for seed in SEEDS if case(seed).solve()[1].best] == [False] * sum(
        bool(case(seed).solve()[1].best) for seed in SEEDS
    )


@pytest.mark.parametrize("readings", READINGS)
def test_wherever_time_ends_a_front_is_valid(readings: int) -> None:
    problem, axes = case(3).problem(), Axes.of(["power", "cost"])
    clock = count(1).__next__
    front = FrontSearch(problem, axes, deadline=Deadline(readings + 0.5, clock)).run()
    full = FrontSearch(case(3).problem(), axes).run()
    assert sum(front.account.values()) == sum(full.account.values())
    assert front.complete == (front.account.get("not_reached", 0) == 0)
    assert front.hypervolume <= front.hypervolume_bound
    assert not front.interrupted


def test_a_front_cut_in_a_later_step_keeps_what_the_steps_before_it_settled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Node by node: time ends among the veils of the third of three, whose two designs are not reached."""
    monkeypatch.setattr(front_search, "FIRST_NODES", 1)
    monkeypatch.setattr(front_search, "GROWTH", 1)
    axes, clock = Axes.of(["power", "cost"]), count(1).__next__
    front = FrontSearch(case(10).problem(), axes, deadline=Deadline(22.5, clock)).run()
    assert front.account["not_reached"] == 2 and front.account["evaluated"] > 0
    assert 0.0 < front.hypervolume <= front.hypervolume_bound < 1.0
