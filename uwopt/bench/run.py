"""Suites one after the other within a time, their rows kept as they come."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from uwopt.bench.machine import machine
from uwopt.bench.suite import BenchRow, Budget, Suite
from uwopt.deadline import Progress
from uwopt.documents.faults import nearest
from uwopt.errors import MissionError, UwoptError

SCHEMA = "uwopt.bench/1"
MODULES = {  # suite: module of `uwopt.bench`, imported when it is run
    "spectral": "spectral", "quadrature": "quadrature", "physics": "physics", "solvers": "peers", "pareto": "fronts",
    "scaling": "scaling",
}  # fmt: skip
QUICK_S = 48.0  # for all suites together; start, the page and what a suite is late by fit in a minute


@dataclass
class Bench:
    """What has been measured so far, and where."""

    quick: bool
    seed: int
    missions: tuple[str, ...]
    machine: dict[str, Any]
    suites: list[Suite] = field(default_factory=list)
    rows: list[BenchRow] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)  # by suite
    faults: dict[str, str] = field(default_factory=dict)  # suites that failed, and how
    interrupted: bool = False

    def of(self, suite: Suite) -> list[BenchRow]:
        """Rows of one suite."""
        return [row for row in self.rows if row.suite == suite.name]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        from uwopt.results.record import plain

        made: dict[str, Any] = plain({
            "schema": SCHEMA, "quick": self.quick, "seed": self.seed, "missions": list(self.missions),
            "interrupted": self.interrupted, "machine": self.machine, "seconds": self.seconds, "faults": self.faults,
            "rows": [row.as_dict() for row in self.rows],
        })  # fmt: skip
        return made


def chosen_suites(names: Sequence[str]) -> list[Suite]:
    """Suites by name, in their order; all of them when none is named."""
    for name in names:
        if name not in MODULES:
            near = nearest(name, tuple(MODULES))
            hint = f"did you mean {near}?" if near else f"there are {', '.join(MODULES)}."
            raise MissionError(f"--suite: {name!r} is no benchmark; {hint}")
    wanted = [name for name in MODULES if name in names or not names]
    return [importlib.import_module(f"uwopt.bench.{MODULES[name]}").SUITE for name in wanted]


def mission_files(names: Sequence[str]) -> list[str]:
    """Missions by file, or all of a folder; each must be one that loads."""
    from uwopt.mission.mission import load_mission

    files: list[str] = []
    for name in names:
        folder = Path(name)
        if folder.is_dir():
            found = sorted(str(path) for path in folder.glob("*.yaml") if not path.stem.endswith(".system"))
            if not found:
                raise MissionError(
                    f"{name}: there is no mission (*.yaml) in this folder; name another, or a file."
                )
            files += found
        else:
            files.append(name)
    for file in files:
        load_mission(file)
    return files


def run(
    names: Sequence[str] = (), *, quick: bool = False, seed: int = 0, missions: Sequence[str] = (),
    seconds: float | None = None,
    keep: Callable[[Bench], None] | None = None, progress: Progress | None = None,
) -> Bench:  # fmt: skip
    """Measure, within some `seconds` if given; `keep` is called after every suite.

    An interrupt ends the run, with what there is.
    """
    bench = Bench(quick, seed, tuple(missions), machine())
    suites = chosen_suites(names)
    shares = [suite.quick_s if quick else suite.full_s for suite in suites]
    whole = sum(shares)
    start, done = time.perf_counter(), 0.0
    limit_s = min(QUICK_S, whole) if quick and seconds is None else seconds
    for suite, share in zip(suites, shares, strict=True):
        share_s = share
        if limit_s is not None:  # what one takes too long, all that follow make up for
            share_s = (limit_s - (time.perf_counter() - start)) * share / (whole - done)
        bench.suites.append(suite)
        if progress is not None:
            progress(done / whole, suite.title)
        report = suite_progress(progress, done / whole, share / whole, suite.title)
        measured(bench, suite, Budget(quick, max(share_s, 0.0), seed, bench.missions, report=report))
        done += share
        if keep is not None:
            keep(bench)
        if bench.interrupted:
            break
    return bench


def measured(bench: Bench, suite: Suite, budget: Budget) -> None:
    """Add one suite's rows; what goes wrong with it is told, and the others go on."""
    start = time.perf_counter()
    try:
        for row in suite.measure(budget):
            bench.rows.append(row)
    except KeyboardInterrupt:
        bench.interrupted = True
    except MissionError:
        raise
    except UwoptError as fault:
        bench.faults[suite.name] = str(fault)
    bench.seconds[suite.name] = time.perf_counter() - start


def suite_progress(progress: Progress | None, begin: float, share: float, title: str) -> Progress | None:
    """Progress of a suite as progress of the whole."""
    if progress is None:
        return None
    return lambda part, what: progress(begin + share * part, f"{title}: {what}" if what else title)
