"""How a call is waited for: by when it has to answer, who is told what meanwhile, and how long its stages take."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TypeVar

from uwopt.deadline import Deadline, Progress, processor_s, unheard
from uwopt.errors import RangeError

Made = TypeVar("Made")
SoFar = Callable[[str], None]  # takes a line

#: What a person reads while a stage lasts that does not tell how far it is.
STAGES = {
    "practice": "what of good practice has to be relaxed",
    "certainty": "in how many scenarios hardware holds",
    "eased": "what would make it certain enough",
    "knee": "what more power and money would buy",
    "robustness": "how firm the answer is", "second_opinion": "second opinions",
    "less_money": "what would cost less",
    "next_best": "more of the next best systems",
    "prices": "what requirements cost", "ranges": "where other systems take over",
    "search_generic": "what parts to be made would give",
    "alternatives": "what other makers offer", "accuracy": "errors of figures",
}  # fmt: skip


def untold(line: str) -> None:
    """Where nobody waits for it."""


@dataclass(frozen=True)
class Watch:
    """One for a whole call; a step that has a time of its own gets the same with another deadline.

    progress : told how far a stage is
    so_far : takes a line where something is known that who waits may want to read
    timing_s : how long each stage took, all together
    began_s, since_s : when it was asked, on the wall's clock and the processor's
    """

    deadline: Deadline = field(default_factory=Deadline)
    progress: Progress = unheard
    so_far: SoFar = untold
    timing_s: dict[str, float] = field(default_factory=dict)
    began_s: float = field(default_factory=time.perf_counter)
    since_s: float = field(default_factory=processor_s)

    @classmethod
    def begun(cls, seconds: float | None, progress: Progress | None = None, so_far: SoFar = untold) -> Watch:
        """Of a call that is to last so many seconds at most; None: as long as it takes."""
        if progress is not None and not callable(progress):
            raise RangeError(f"progress = {progress!r} is no function; it is called with a share and a word")
        return cls(Deadline.asked(seconds), progress or unheard, so_far)

    def until(self, deadline: Deadline) -> Watch:
        """The same, with another time."""
        return replace(self, deadline=deadline)

    def apart(self) -> Watch:
        """The same, with a table of its own for how long its stages take."""
        return replace(self, timing_s={})

    @contextmanager
    def timed(self, name: str) -> Iterator[None]:
        """A context that adds how long it lasts to a stage's time."""
        start_s = time.perf_counter()
        try:
            yield
        finally:
            self.timing_s[name] = self.timing_s.get(name, 0.0) + time.perf_counter() - start_s

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """The same of one of `STAGES`, which is told."""
        self.progress(0.0, STAGES[name])
        with self.timed(name):
            yield

    def within(self, name: str, work: Callable[[Deadline], Made], otherwise: Made) -> Made:
        """What a stage makes that the answer can do without; where time does not reach, something else, and a note."""
        with self.stage(name):
            return self.deadline.within(STAGES[name], lambda: work(self.deadline), otherwise)

    def total(self, more_s: dict[str, float] | None = None) -> dict[str, float]:
        """How long each stage took, and all of it until now; `more_s`: of stages that were timed elsewhere."""
        return {**self.timing_s, **(more_s or {}), "total": time.perf_counter() - self.began_s}
