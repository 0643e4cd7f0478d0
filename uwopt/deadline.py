"""How long an answer may take: one object for a whole call, from the search to the last remark about its result.

Steps that a result can do without run `within` the deadline: what has no time is left out and remembered, so
that the result can say so. Long work asks `check` now and then; what it has found by then is kept by its caller.

What is recommended must not depend on how fast a machine is or on what else it does. Where nobody set a limit, that is
limited in work: how much a thread has worked out, in seconds of a common machine (`effort_s`). What costs most is
counted where it is done, and stands for all that is done beside it.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Literal, TypeVar

from uwopt.errors import MissionError

Made = TypeVar("Made")
Progress = Callable[[float, str], None]  # takes how much is done, and of what
Work = Literal["loss tables", "pixels", "views", "bounds", "designs", "cells", "floors"]

#: Seconds apiece of a fast core, from `solve --confidence 0.9` of eight missions in `problems/`, told by them within a
#: factor of 1.7; 1.8 times as long on the slower core that they were fitted on.
COSTS_S: dict[Work, float] = {
    "loss tables": 0.006,  # of the water's loss on both legs, with the integrals that one serves
    "pixels": 0.03,  # of some images, that may decide
    "views": 0.0045,  # of cameras and lenses behind one port
    "bounds": 2e-7,  # one image under one kind of lamps
    "designs": 1.5e-5,  # whose settings are bounded; fitted on searches in vain of 0.3 to 1 million
    "cells": 2e-4,  # of settings, one that is bounded
    "floors": 1.1e-3,  # under one image, whose darkest place is sought at one height
}


class _Spent(threading.local):
    spent_s = 0.0


@dataclass
class _Processor:
    before_s: float = 0.0  # of a process that this one is a copy of


_SPENT, _PROCESSOR = _Spent(), _Processor()


def spend(work: Work, count: int = 1) -> None:
    """Count some work as done."""
    _SPENT.spent_s += COSTS_S[work] * count


def effort_s() -> float:
    """What this thread has spent since it began [s of a common machine]."""
    return _SPENT.spent_s


def add_effort(seconds: float) -> None:
    """Count what was worked out elsewhere for this thread, or take it off again."""
    _SPENT.spent_s += seconds


def processor_s() -> float:
    """What this process has taken of the processor, with what it is a copy of until it was made [s]."""
    return _PROCESSOR.before_s + time.process_time()


@dataclass
class PatientClock:
    """The processor's clock, but for what it stands still for: works on which no patience is spent."""

    not_counted_s: float = 0.0

    def __call__(self) -> float:
        """Seconds on it."""
        return processor_s() - self.not_counted_s

    def stand_still(self, work: Callable[[], Made]) -> Made:
        """What a work makes, of which nothing is counted."""
        began_s = processor_s()
        try:
            return work()
        finally:
            self.not_counted_s += processor_s() - began_s


def go_on_from(seconds: float) -> None:
    """Let the processor's clock go on, in a copy, from where it was."""
    _PROCESSOR.before_s = seconds - time.process_time()


def unheard(share: float, what: str) -> None:
    """Where nobody waits to be told how far it is."""


#: Times that a person is told to give [s].
TOLD_S = (60, 120, 300, 600, 1800, 3600)


def longer_s(taken_s: float, more_s: float = 0.0) -> int:
    """What `--seconds` are told to have time for more than was done: half as much again as that took, and some."""
    return next((one for one in TOLD_S if one > 1.5 * taken_s + more_s), TOLD_S[-1])


class OutOfTimeError(Exception):
    """The time that a caller gave is over; never leaves the package."""


@dataclass(frozen=True)
class Deadline:
    """A time on a clock, and what was left out because it had passed."""

    end_s: float = math.inf  # on the clock
    clock: Callable[[], float] = time.perf_counter
    left_out: list[str] = field(default_factory=list)

    @classmethod
    def after(cls, seconds: float | None, clock: Callable[[], float] = time.perf_counter) -> Deadline:
        """So many seconds from now; without a number never."""
        return cls(math.inf if seconds is None else clock() + seconds, clock)

    @classmethod
    def asked(cls, seconds: float | None) -> Deadline:
        """As `after`, of what a call is given. Raises MissionError for what is no time."""
        if seconds is not None and (isinstance(seconds, bool) or not isinstance(seconds, Real) or not seconds >= 0):
            raise MissionError(f"seconds = {seconds!r} is no number of seconds; give None for no limit")
        return cls.after(seconds)

    @property
    def left_s(self) -> float:
        """Seconds until it passes, not below 0; infinite where there is none."""
        return math.inf if math.isinf(self.end_s) else max(self.end_s - self.clock(), 0.0)

    def passed(self) -> bool:
        """Whether the time is over."""
        return self.left_s <= 0.0

    def check(self) -> None:
        """Raise OutOfTimeError once it has passed."""
        if self.passed():
            raise OutOfTimeError

    def in_time(self, work: Callable[[], Made]) -> Made:
        """What a step makes. Raises OutOfTimeError where it has passed before."""
        self.check()
        return work()

    def at_most(self, seconds: float) -> Deadline:
        """This deadline, or one in so many seconds if that is sooner; what is left out is told to neither's caller."""
        return Deadline(min(self.end_s, self.clock() + seconds), self.clock)

    def part(self, share: float) -> Deadline:
        """This deadline after a share of the time left, as `at_most`."""
        return self.at_most(share * self.left_s)

    def or_after(self, seconds: float, clock: Callable[[], float]) -> Deadline:
        """This deadline; where nobody has set one, one in so many seconds of a clock."""
        return Deadline.after(seconds, clock) if math.isinf(self.end_s) else self

    def of_work(self, seconds: float) -> Deadline:
        """So many seconds of work at most, or of the clock where somebody has set a deadline; as `at_most`."""
        return self.or_after(seconds, effort_s).at_most(seconds)

    def but_for(self, share: float) -> Deadline:
        """So much sooner by a share of the time left; what is left out is told to the same caller."""
        return self if math.isinf(self.end_s) else replace(self, end_s=self.end_s - share * self.left_s)

    def within(self, what: str, work: Callable[[], Made], otherwise: Made) -> Made:
        """What a step makes; where the time does not reach, something else instead, and a note of what is missing."""
        try:
            return self.in_time(work)
        except OutOfTimeError:
            self.left_out.append(what)
            return otherwise


@dataclass(frozen=True)
class UntilFound(Deadline):
    """A deadline that has also passed once something is found."""

    is_found: Callable[[], bool] = bool

    @classmethod
    def of(cls, other: Deadline, is_found: Callable[[], bool]) -> UntilFound:
        """As the other until then."""
        return cls(other.end_s, other.clock, other.left_out, is_found)

    @property
    def left_s(self) -> float:
        """As of a deadline; none once it is found."""
        return 0.0 if self.is_found() else super().left_s


NEVER = Deadline()
