"""Least changes are drawn in by turns: whatever the time, each of them is nearer, and with enough each is the least.

Time is that of a clock of the test, which a search moves on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import pytest

from uwopt.deadline import Deadline
from uwopt.solvers.infeasible import least_change
from uwopt.solvers.infeasible.least_change import CLOSER, Change, Narrowing, in_rounds

ASKED, FAR = 1.0, 10.0
LEAST = (2.0, 3.0, 4.0)  # with which something fits


class Clock:
    """Stands still but for searches."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture(autouse=True)
def one_hardware(monkeypatch: pytest.MonkeyPatch) -> None:
    """No hardware reaches nearer than the limit that it was found at."""
    monkeypatch.setattr(least_change, "with_its_hardware", lambda asked, change, relaxed, deadline: change)


def narrowing(clock: Clock, least: float, needs_s: Callable[[float], float] = lambda limit: 1.0) -> Narrowing:
    """A limit from above whose searches take this long, or their turn if that is less."""

    def search(limit: Any, turn: Deadline) -> Any:
        done = needs_s(limit) <= turn.left_s
        clock.now_s += min(needs_s(limit), turn.left_s)
        return SimpleNamespace(outcome=SimpleNamespace(best=[1] * (done and limit >= least), complete=done))

    return Narrowing(ASKED, Change(FAR, cast(Any, None)), cast(Any, lambda limit: limit), search)


def drawn(seconds: float, needs_s: Callable[[float], float] = lambda limit: 1.0) -> list[Narrowing]:
    """All of them after so many seconds."""
    clock = Clock()
    changes = [narrowing(clock, least, needs_s) for least in LEAST]
    in_rounds(changes, Deadline(seconds, clock))
    return changes


def test_with_time_enough_each_is_the_least():
    for one, least in zip(drawn(math.inf), LEAST, strict=True):
        assert one.is_least
        typed = 0.01 * least  # three digits
        assert least <= one.change.limit <= least + CLOSER * (FAR - ASKED) + typed


def test_with_little_time_each_is_nearer():
    """A search of each takes 3 s and half of what is left in its round: in sequence the first would have it all."""
    for one, least in zip(drawn(24.0, lambda limit: 3.0), LEAST, strict=True):
        assert least <= one.change.limit <= 0.5 * (ASKED + FAR)
        assert not one.is_least


def test_where_searches_take_too_long_the_change_is_drawn_in_as_far_as_they_do_not():
    (one, *_) = drawn(1e6, lambda limit: 1.0 if limit > 5.0 else math.inf)
    assert 5.0 < one.change.limit < 5.3
    assert not one.is_least


def test_the_largest_change_comes_first():
    order: list[str] = []

    class Noted(Narrowing):
        def step(self, turn: Deadline) -> None:
            order.append(f"{self.change.limit:g}")
            super().step(turn)

    clock = Clock()
    one = narrowing(clock, 1.5)
    changes = [Noted(ASKED, Change(far, one.change.found), one.relaxed, one.search) for far in (2.0, 9.0, 4.0)]
    in_rounds(changes, Deadline(math.inf, clock))
    assert order[:3] == ["9", "4", "2"]


def test_a_sooner_deadline_tells_the_same_caller():
    whole = Deadline(10.0, Clock())
    sooner = whole.but_for(0.4)
    sooner.left_out.append("something")
    assert sooner.left_s == pytest.approx(6.0) and whole.left_out == ["something"]
    assert math.isinf(Deadline().but_for(0.4).left_s)
