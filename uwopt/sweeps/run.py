"""`uwopt.sweep`: many missions worked out, each a row of a table; nothing that is done is lost.

Tasks go to workers in batches of a few seconds, sized by what the last ones took. Whoever dies takes no rows along:
what it had is sent again, alone, and only a mission that ends its process each time is given up, with a message.
"""

from __future__ import annotations

import contextlib
import itertools
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from uwopt.deadline import NEVER, Deadline, Progress
from uwopt.errors import OutputError, RangeError, SchedulerError
from uwopt.mission.system import System
from uwopt.mission.varying import Asked
from uwopt.results.sweep import SweepKit, SweepSummary
from uwopt.sweeps.inputs import Named, job_of
from uwopt.sweeps.job import SweepBatch, SweepJob, SweepTask, SweepWays, hash_of
from uwopt.sweeps.kits import YES
from uwopt.sweeps.rows import DIED, Row, failed_row
from uwopt.sweeps.store import SERVED, SweepStore
from uwopt.sweeps.summary import SolvedMission, solved_keys, summary_of, with_portfolio, write_sweep
from uwopt.sweeps.work import SweepReply, labels_of
from uwopt.sweeps.workers import Died, Workers, local_workers

MOST_KITS = 8  # tried in every mission, unless said otherwise
BATCH_S = 2.0  # of a worker's time, before what it costs to send a batch counts
OVERHEAD_S = (
    0.02  # a batch and worker: batches of many workers grow, so that who sends and keeps them keeps up
)
MOST_TASKS = 1000  # in one batch
MOST_ROWS = 5000  # in one file of those that are done at once
AHEAD = 2  # batches a worker: one that it works on, one that waits
DEATHS = 3  # of a mission's processes, alone, before it is given up
WAIT_S = 0.5  # between two looks at the time
NEWEST = 0.3  # weight of the newest batch in the mean


def sweep(
    named: Named | Sequence[Named],
    vary: Asked | None = None,
    *,
    out: str | Path,
    system: str | Path | Mapping[str, Any] | System | None = None,
    objective: str | Mapping[str, float] | None = None,
    physics: str | None = None,
    confidence: float | str | None = None,
    pareto: Sequence[str] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    kits: int = MOST_KITS,
    seconds: float | None = None,
    hold_practice: bool = False,
    progress: Progress | None = None,
) -> SweepSummary:
    """Many missions solved, or a system evaluated in each: a row a mission, in a folder that a later run goes on with.

    Parameters
    ----------
    named : mission files, folders of them, missions; or a table (CSV, Parquet, a key a column) and a mission
    vary : values by key, as of `whatif`; every combination is a mission
    out : folder for the rows, the table, the summary and the page
    system : a system that is evaluated in each mission, instead of looking for the best
    confidence : share of the scenarios in which hardware must hold, `central` or `ends`, instead of the missions'
    pareto : two or three objectives, as of `pareto`: the trade-off of each mission, a row a point, instead of its best
    kits : how many of the kits that win most often are tried in every mission, for a portfolio; 0 leaves it out
    hold_practice : as of `solve`; else what good practice has filled in gives way in a mission that nothing meets
    seconds : for all missions; what is worked out by then is kept, a mission under way is left to a later run
    workers : processes of this machine; with more than 1 call it below `if __name__ == "__main__":`

    scheduler : address of a running Dask cluster, such as tcp://127.0.0.1:8786, instead of processes of this machine

    Raises
    ------
    SchedulerError : it does not answer, has no workers, or they are another program
    MissionError : what is named holds no mission, a key does not exist, a table cannot be read
    OutputError : the folder cannot be written, or its disk is full; the rows there stay valid
    """
    if workers < 1:
        raise RangeError(f"sweep: workers = {workers}; at least one is needed")
    start, deadline = time.perf_counter(), Deadline.asked(seconds)
    several: list[Named] = list(named) if isinstance(named, (list, tuple)) else [named]  # pyrefly: ignore[bad-assignment]
    ways = SweepWays(
        objective=objective, physics=physics, confidence=confidence, pareto=tuple(pareto or ()),
        hold_practice=hold_practice,
    )  # fmt: skip
    job = job_of(several, vary, ways=ways, system=system, with_files=scheduler is not None)
    folder = Path(out)
    with (
        SweepStore(folder) as store,
        SweepStore(folder, SERVED) as served,
        Crew(job, workers, scheduler) as crew,
    ):
        run = SweepRun(job, store, progress, deadline=deadline)
        run.all(crew)
        made = summary_of(job, store, interrupted=bool(run.ended), kept=run.kept)
        timing = {"missions": run.spent_s}
        if len(made.kits[:kits]) > 1 and not run.ended:
            trial = Trial(job, tuple(made.kits[:kits]), solved_keys(job, store))
            second = SweepRun(
                trial.job, served, progress, trial.tasks, trial.kits, f"{len(trial.kits)} kits tried in ",
                deadline=deadline,
            )
            second.all(crew)
            timing["kits"] = second.spent_s
            run.memory_mb, run.ended = max(run.memory_mb, second.memory_mb), second.ended
            made = with_portfolio(made, *trial.table(served))
        timing["total"] = time.perf_counter() - start
        made = replace(
            made, status=run.ended or made.status, workers=crew.count,
            memory_mb=run.memory_mb, timing_s=timing,
        )  # fmt: skip
        write_sweep(made, job, store, folder)
    return made


class Crew:
    """The workers of a sweep, started when there is work for them; use as a context, at whose end they go."""

    def __init__(self, job: SweepJob, count: int, scheduler: str | None = None):
        self._job, self._count, self._scheduler = job, count, scheduler
        self._workers: Workers | None = None

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, *given: object) -> None:
        if self._workers is not None:
            self._workers.close()

    def workers(self, left: int) -> Workers:
        """Those for so many missions."""
        if self._workers is None and self._scheduler is not None:
            from uwopt.sweeps.cluster import ClusterWorkers

            self._workers = ClusterWorkers(self._job, self._scheduler)
        elif self._workers is None:
            self._workers = local_workers(self._job, self._count, left)
        return self._workers

    @property
    def count(self) -> int:
        """How many there were."""
        return self._count if self._scheduler is None or self._workers is None else self._workers.count


@dataclass(frozen=True)
class Trial:
    """Kits tried in every mission in which something fits."""

    job: SweepJob
    kits: tuple[SweepKit, ...]
    solved: Mapping[str, SolvedMission]  # by key

    def tasks(self) -> Iterator[SweepTask]:
        """One a mission, under a key of its own."""
        for task in self.job.tasks():
            if task.key in self.solved:
                yield replace(task, key=self.key(task.key), gave_way=self.solved[task.key].gave_way)

    def key(self, of_mission: str) -> str:
        """That of a mission with these kits, held to what its best is."""
        gave_way = self.solved[of_mission].gave_way
        return hash_of([of_mission, [kit.parts for kit in self.kits], *([gave_way] if gave_way else [])])

    def table(self, store: SweepStore) -> tuple[list[str], int]:
        """A sign a kit for each mission that was tried, its own winner served for certain; and how many kits."""
        made, mine = [], [task.key for task in self.job.tasks() if task.key in self.solved]
        for found, rows in store.pieces(map(self.key, mine), ["key", "served"]):
            signs = rows.column("served").to_pylist() if "served" in rows.column_names else [None] * len(rows)
            for place, told in zip(found.tolist(), signs, strict=True):
                if told:
                    won = self.solved[mine[place]].kit
                    made.append(told if won is None or won >= len(told) else told[:won] + YES + told[won + 1 :])
        return made, len(self.kits)


@dataclass
class Pace:
    """How long missions take, and how many go into a batch."""

    workers: int
    task_s: float | None = None  # of a worker's time; None before the first is done

    @property
    def batch_s(self) -> float:
        """How long a batch should take: longer for many workers, whose scheduler must keep up."""
        return max(BATCH_S, OVERHEAD_S * self.workers)

    def learn(self, rows: int, seconds: float) -> None:
        """What a batch took."""
        if rows:
            new = seconds / rows
            self.task_s = new if self.task_s is None else (1.0 - NEWEST) * self.task_s + NEWEST * new

    def size(self, left: int) -> int:
        """How many tasks the next batch takes; fewer towards the end, so that all workers end together."""
        if self.task_s is None:
            return 1
        fair = -(-left // (AHEAD * self.workers))
        return max(1, min(round(self.batch_s / max(self.task_s, 1e-6)), MOST_TASKS, fair))


@dataclass
class SweepRun:
    """The missions of a job on their way through workers into a store."""

    job: SweepJob
    store: SweepStore
    progress: Progress | None = None
    tasks: Callable[[], Iterator[SweepTask]] | None = None  # those of the job unless given
    kits: tuple[SweepKit, ...] = ()  # tried in each mission, instead of a search for the best
    does: str = ""  # before the number of missions, for who waits
    deadline: Deadline = NEVER
    ended: str = ""  # before all was done: interrupted by a person, or stopped where time was over
    kept: int = 0
    memory_mb: float = 0.0
    spent_s: float = 0.0
    total: int = 0
    done: int = 0
    _suspects: deque[SweepBatch] = field(default_factory=deque)
    _deaths: dict[str, int] = field(default_factory=dict)  # of single tasks, by their keys
    _flying: int = 0
    _stop: bool = False  # a person wants no more
    _start_s: float = 0.0

    def all(self, crew: Crew) -> None:
        """Every mission that the store does not have yet."""
        self._start_s = time.perf_counter()
        keys = {task.key for task in self._asked()}
        self.total = len(keys)
        self.done = self.kept = len(keys & self.store.keys)
        if self.kept < self.total:
            self._tell()
            workers = crew.workers(self.total - self.kept)
            try:
                self._work(workers, Pace(workers.count))
            except KeyboardInterrupt:
                self.ended = "interrupted"
                self._late(workers)
        self.spent_s = time.perf_counter() - self._start_s

    def _asked(self) -> Iterator[SweepTask]:
        return self.job.tasks() if self.tasks is None else self.tasks()

    def _work(self, workers: Workers, pace: Pace) -> None:
        """Send batches and keep what comes back, until nothing is left."""
        tasks, more = self._tasks(), True
        while True:
            if self.done < self.total and self.deadline.passed():
                self.ended = "stopped"
                self._late(workers)
                return
            if self._suspects and not self._flying:
                self._send(workers, self._suspects.popleft())  # alone, so that it is clear whose process ends
            while more and not self._suspects and self._flying < AHEAD * workers.count:
                some = tuple(itertools.islice(tasks, pace.size(self.total - self.done)))
                if more := bool(some):
                    self._send(workers, SweepBatch(some, self.kits))
            if not self._flying and not self._suspects:
                return
            self._receive(workers, pace)
            if self._stop:
                raise KeyboardInterrupt
            self._tell()

    def _tasks(self) -> Iterator[SweepTask]:
        """Tasks that are not worked out yet, each once; of what is no mission the rows are made here."""
        sent: set[str] = set()
        for task in self._asked():
            if task.key in self.store.keys or task.key in sent:
                continue
            sent.add(task.key)
            base = self.job.bases[task.base]
            if base.fault:
                self._keep([failed_row(base.name, base.fault) | labels_of(self.job, task) | {"time_s": 0.0}])
            else:
                yield task

    def _send(self, workers: Workers, batch: SweepBatch) -> None:
        workers.submit(batch)
        self._flying += 1

    def _receive(self, workers: Workers, pace: Pace) -> None:
        """Wait for a batch, and keep its rows and those of all that are done by then, in one file."""
        rows: list[Row] = []
        try:
            finished = workers.next(WAIT_S)
            while finished is not None:
                rows += self._take(*finished, pace)
                finished = workers.next(0.0) if len(rows) < MOST_ROWS else None
        finally:
            self._keep(rows)

    def _take(self, batch: SweepBatch, outcome: SweepReply | Died, pace: Pace) -> list[Row]:
        """The rows of a batch; where a process ended, look for the mission that ends it."""
        alone = self._flying == 1
        self._flying -= 1
        if isinstance(outcome, Died):
            return self._died(batch, alone=alone)
        if outcome.refusal:
            raise SchedulerError(
                f"a worker is not the same program: {outcome.refusal}; install the same everywhere"
            )
        pace.learn(len(outcome.rows), sum(row["time_s"] for row in outcome.rows))
        self.memory_mb = max(self.memory_mb, outcome.memory_mb)
        self._stop = self._stop or outcome.cut
        return outcome.rows

    def _died(self, batch: SweepBatch, *, alone: bool) -> list[Row]:
        """Send again what a process had that ended, in halves; give up a mission that ends each of its own."""
        first = batch.tasks[0]
        if len(batch.tasks) > 1 and alone:
            half = len(batch.tasks) // 2
            self._suspects.extend(
                replace(batch, tasks=some) for some in (batch.tasks[:half], batch.tasks[half:])
            )
            return []
        if alone:
            self._deaths[first.key] = self._deaths.get(first.key, 0) + 1
        if self._deaths.get(first.key, 0) < DEATHS:
            self._suspects.append(batch)
            return []
        told = f"{DIED} {DEATHS} times, for want of memory perhaps; a run to come tries it again"
        base = self.job.bases[first.base].name
        return [failed_row(base, told) | labels_of(self.job, first) | {"time_s": 0.0}]

    def _keep(self, rows: Sequence[Row]) -> None:
        """Rows onto the disk."""
        try:
            self.store.add(rows)
        except OutputError as fault:
            raise OutputError(
                f"{str(fault).rstrip('.')}. What is there stays valid, {self.done} of {self.total} missions: make "
                "room, and the same command goes on with the rest."
            ) from None
        self.done += len(rows)

    def _late(self, workers: Workers) -> None:
        """Keep what was done when a person interrupted, or time was over."""
        with contextlib.suppress(KeyboardInterrupt):
            while (finished := workers.next(0.0)) is not None:
                if isinstance(finished[1], SweepReply):
                    self._keep(finished[1].rows)

    def _tell(self) -> None:
        """How far it is, how fast, and how long it will take."""
        if self.progress is None:
            return
        new, spent_s = self.done - self.kept, time.perf_counter() - self._start_s
        said = f"{self.does}{self.done} of {self.total} missions"
        if new:
            rate = new / spent_s
            said += f", {rate:.3g} a second, {duration_text((self.total - self.done) / rate)} left"
        self.progress(self.done / self.total, said)


def duration_text(seconds: float) -> str:
    """A time in the largest unit that suits it."""
    for unit, length_s in (("days", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length_s:
            return f"{seconds / length_s:.0f} {unit}"
    return f"{seconds:.0f} s"
