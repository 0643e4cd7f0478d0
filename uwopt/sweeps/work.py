"""What a worker does: tasks in, rows out. It reads the catalogue once and keeps what neighbours share."""

from __future__ import annotations

import contextlib
import json
import signal
import sys
import tempfile
import threading
import time
import warnings
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwopt.api.practice_known import PracticeKnown
from uwopt.api.search_notes import interrupted
from uwopt.api.solving import solve
from uwopt.errors import UwoptError
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Value, Varied, VariedMission
from uwopt.mission.yielding import with_yields, yields_named
from uwopt.results.design import PRACTICE_IN_VAIN
from uwopt.results.sweep import SweepKit
from uwopt.solvers.warm.searches import Warm
from uwopt.sweeps.identity import differences, program_identity
from uwopt.sweeps.job import LABEL, SweepBatch, SweepJob, SweepTask
from uwopt.sweeps.kits import served_by
from uwopt.sweeps.neighbours import warm_row
from uwopt.sweeps.rows import Row, failed_row, row_of, row_of_front, with_gave_way, with_practice_held

MOST_BASES = 64  # missions of files that are kept read


@dataclass(frozen=True)
class SweepReply:
    """What came of a batch."""

    rows: list[Row]
    memory_mb: float  # the most that the worker has held so far
    cut: bool = False  # whether a person wants no more, so that rows are missing
    refusal: str = ""  # why this worker may not work on the job


class SweepWorker:
    """One worker's view of a job."""

    def __init__(self, job: SweepJob):
        self.job = job
        self._bases: OrderedDict[int, tuple[VariedMission, tuple[Varied | None, ...]]] = OrderedDict()
        self._warm = Warm()
        self._practice = None if job.ways.hold_practice else PracticeKnown()
        self._unpacked = None if not job.files else UnpackedFiles(job.files)
        self.refusal = "; ".join(differences(job.identity, program_identity()))

    def reply(self, batch: SweepBatch) -> SweepReply:
        """Rows of a batch, in its order; what is done when a person interrupts is kept."""
        if self.refusal:
            return SweepReply([], 0.0, refusal=self.refusal)
        rows: list[Row] = []
        try:
            rows.extend(self.row(task, batch.kits) for task in batch.tasks)
        except KeyboardInterrupt:
            return SweepReply(rows, most_memory_mb(), cut=True)
        return SweepReply(rows, most_memory_mb())

    def row(self, task: SweepTask, kits: Sequence[SweepKit] = ()) -> Row:
        """One mission worked out, or kits tried in it; what goes wrong is its row's message."""
        start_s, busy_s = time.perf_counter(), time.process_time()
        name = self.job.bases[task.base].name
        try:
            row = self._served(task, kits) if kits else self._worked_out(task)
        except UwoptError as fault:
            row = failed_row(name, str(fault))
        except Exception as fault:  # one mission must not stop the others
            what = " ".join(str(fault).split())[:300]
            row = failed_row(name, f"a defect of uwopt: {type(fault).__name__}: {what}")
        return row | labels_of(self.job, task) | {
            "time_s": time.perf_counter() - start_s,
            "processor_s": time.process_time() - busy_s,
        }

    def mission(self, task: SweepTask) -> Mission:
        """The mission of a task; raises MissionError where its values cannot stand together."""
        base, named = self._base(task.base)
        pairs = zip(named, task.values, strict=True)
        return base.with_values({k: self._here(v) for k, v in pairs if k is not None and v is not None})

    def _served(self, task: SweepTask, kits: Sequence[SweepKit]) -> Row:
        mission = self.mission(task)
        held = with_yields(mission, yields_named(task.gave_way))
        return {"mission": mission.name, "served": served_by(held, kits)}

    def _worked_out(self, task: SweepTask) -> Row:
        ways, mission = self.job.ways, self.mission(task)
        if ways.command == "evaluate":
            from uwopt.api.evaluating import evaluate

            assert ways.system is not None
            system = ways.system if self._unpacked is None else self._unpacked.at_home(ways.system)
            return row_of(evaluate(mission, system, confidence=ways.confidence))
        if ways.command == "pareto":
            from uwopt.api.trading import pareto

            front = pareto(mission, objectives=ways.pareto, solver="exact", hold_practice=ways.hold_practice)
            if front.status == "interrupted":
                raise KeyboardInterrupt
            return with_gave_way(row_of_front(front), mission, front.mission)
        return warm_row(mission, self._warm, self._practice) or self._solved(mission)

    def _solved(self, mission: Mission) -> Row:
        """The row of a mission that is solved by itself."""
        held = self._practice is None
        result = solve(
            mission, top=TOP, quick=True, explain=False, hold_practice=held, known=self._practice
        )
        if interrupted(result):
            raise KeyboardInterrupt
        row = with_gave_way(row_of(result), mission, result.mission)
        in_vain = any(note.code == PRACTICE_IN_VAIN for note in result.warnings)
        return with_practice_held(row, mission) if held or (row["status"] == "infeasible" and not in_vain) else row

    def _base(self, index: int) -> tuple[VariedMission, tuple[Varied | None, ...]]:
        """A base and its keys; read again where it was long ago."""
        if index not in self._bases:
            given = self.job.bases[index]
            data, folder = given.data, given.base_dir
            if self._unpacked is not None:
                data, folder = self._unpacked.at_home(data), str(self._unpacked.place(folder))
            made = VariedMission(data, self.job.ways.changes(), base_dir=Path(folder) if folder else None)
            if given.stated is not None:
                made.base.stating(given.stated)
            self._bases[index] = (
                made,
                tuple(None if key == LABEL else made.named(key) for key in self.job.keys),
            )
            if len(self._bases) > MOST_BASES:
                self._bases.popitem(last=False)
        self._bases.move_to_end(index)
        return self._bases[index]

    def _here(self, value: Value) -> Value:
        """A value as it is named on this machine."""
        return value if self._unpacked is None else self._unpacked.at_home(value)


TOP = 5  # systems that a search lists, as `solve` does: where the best cannot be set, the next may be


def labels_of(job: SweepJob, task: SweepTask) -> Row:
    """Which task a row is of, with what it was worked out."""
    given = {key: value for key, value in zip(job.keys, task.values, strict=True) if value is not None}
    label = {} if given.get(LABEL) is None else {"mission": str(given[LABEL])}
    return label | {
        "key": task.key,
        "inputs": json.dumps(given, ensure_ascii=False),
        "version": job.identity["uwopt"],
        "input_hash": task.input_hash,
        "catalogue_hash": job.identity["catalogue"],
    }


class UnpackedFiles:
    """Files of the machine that asks, on this one: each below a folder of its own, under its own name."""

    def __init__(self, files: Mapping[str, bytes]):
        self._folder = tempfile.TemporaryDirectory(prefix="uwopt-", ignore_cleanup_errors=True)
        self._files = files
        for name, held in files.items():
            path = self.place(name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(held)

    def place(self, name: str) -> Path:
        """Where a path of the other machine lies here."""
        return Path(self._folder.name, *Path(name).parts[1:])

    def at_home(self, value: Any) -> Any:
        """Plain values in which the files that were sent are named as they lie here."""
        if isinstance(value, Mapping):
            return {key: self.at_home(one) for key, one in value.items()}
        if isinstance(value, (list, tuple)):
            return [self.at_home(one) for one in value]
        return str(self.place(value)) if isinstance(value, str) and value in self._files else value


def most_memory_mb() -> float:
    """The most memory that this process has held [MiB]; 0 where the system does not tell."""
    with contextlib.suppress(ImportError):
        import resource

        held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return held / (1 << 20 if sys.platform == "darwin" else 1 << 10)
    return 0.0


# ---------------------------------------------------------------- in a process of its own

_workers: dict[str, SweepWorker] = {}
_one_at_a_time = threading.Lock()  # tables that neighbours share are not for two threads


def work(job: SweepJob, batch: SweepBatch) -> SweepReply:
    """The reply of this process to a batch of a job; its worker is made once, those of other jobs are given up."""
    with _one_at_a_time:
        if job.name not in _workers:
            _workers.clear()
            _workers[job.name] = SweepWorker(job)
        return _workers[job.name].reply(batch)


_job: list[SweepJob] = []


def begin(job: SweepJob) -> None:
    """Make a new process of this machine ready for a job; interruptions are for the process that asks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("ignore")
    _job[:] = [job]


def work_on(batch: SweepBatch) -> SweepReply:
    """The reply to a batch of the job that this process was made ready for."""
    return work(_job[0], batch)
