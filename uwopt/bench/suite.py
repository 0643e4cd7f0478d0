"""What a benchmark is: a suite yields rows, one a measurement, and says how they are to be read.

Rows have one layout for all suites, so that one CSV, one table and three kinds of chart serve all of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Literal

Chart = Literal["precision", "progress", "scaling"]


@dataclass(frozen=True)
class BenchRow:
    """One measurement. What does not apply is None."""

    suite: str
    case: str  # what was computed: a scene, a mission
    method: str  # how: a rule, a solver
    size: float | None = None  # nodes, order, combinations: `Suite.size_name`
    seed: int | None = None
    time_s: float | None = None  # see `Suite.time_name`
    error: float | None = None  # see `Suite.error_name`; None: no answer (yet)
    memory_mib: float | None = None
    status: str = ""  # such as optimal, stopped, failed
    note: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For a table."""
        return {f.name: getattr(self, f.name) for f in fields(self)}


COLUMNS = tuple(f.name for f in fields(BenchRow))


@dataclass(frozen=True)
class BenchTable:
    """A summary of rows, as text cells."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    text: str = ""  # how to read it


@dataclass
class Budget:
    """How much a suite may take: its share of the time, and whether few cases must do."""

    quick: bool
    seconds: float  # wall clock for this suite; it stops itself between measurements
    seed: int = 0
    missions: tuple[str, ...] = ()  # files; the mission that `uwopt init` writes when empty
    start: float = field(default_factory=time.perf_counter)
    report: Callable[[float, str], None] | None = None

    @property
    def left_s(self) -> float:
        """Seconds that are left; below 0 when the suite is late."""
        return self.seconds - (time.perf_counter() - self.start)

    def tell(self, share: float, what: str) -> None:
        """Progress within the suite, 0 to 1."""
        if self.report is not None:
            self.report(min(max(share, 0.0), 1.0), what)


@dataclass(frozen=True)
class Suite:
    """One benchmark and how its rows are read."""

    name: str  # short, also the name of its CSV file
    title: str
    text: str  # what is measured against what, and how: plain sentences for the report
    chart: Chart  # precision: error over time; progress: error over elapsed time; scaling: time over size
    measure: Callable[[Budget], Iterator[BenchRow]]
    quick_s: float  # share of a quick run
    full_s: float  # of a full one
    size_name: str = "size"
    time_name: str = "time, s"
    error_name: str = "relative error"
    tables: Callable[[Sequence[BenchRow]], Sequence[BenchTable]] = lambda rows: ()
    charted: Callable[[BenchRow], bool] = lambda row: True  # which rows the charts show


def error_text(error: float | None) -> str:
    """An error in a cell; empty where there is none."""
    return "" if error is None else "0" if error == 0 else f"{error:.1e}"


def least_size(rows: Sequence[BenchRow], target: float) -> str:
    """The least size of one method from which on all errors are within the target, as a cell."""
    found = None
    tried = sorted(rows, key=lambda row: row.size or 0.0)
    for row in reversed(tried):
        if row.error is None or row.error > target:
            break
        found = row.size
    if found is not None:
        return f"{found:g}"
    return f"more than {tried[-1].size:g}" if tried else ""


def timed(work: Callable[[], Any], *, at_least_s: float = 0.02, repeats: int = 3) -> tuple[Any, float]:
    """What `work` gives, and the least seconds of several runs, each long enough for the clock."""
    result = work()
    best, count = float("inf"), 1
    for _ in range(repeats):
        while True:
            start = time.perf_counter()
            for _ in range(count):
                work()
            took = time.perf_counter() - start
            if took >= at_least_s or count >= 10_000:
                break
            count *= 2
        best = min(best, took / count)
    return result, best
