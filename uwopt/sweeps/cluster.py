"""A running Dask cluster as the workers of a sweep: the same batches, sent to its scheduler.

The job goes out as a task of its own, so that a worker that joins late gets it too and none that dies takes it along;
each worker process reads the catalogue once. A batch whose worker dies is sent to another by Dask; where it dies with
each (`KilledWorker`), the sweep looks for the mission that does it.
"""

from __future__ import annotations

import asyncio
import pickle
import queue
import time
from collections.abc import Mapping
from typing import Any

from uwopt.errors import SchedulerError
from uwopt.sweeps.identity import differences, program_identity
from uwopt.sweeps.job import SweepBatch, SweepJob
from uwopt.sweeps.work import work
from uwopt.sweeps.workers import Died, Outcome

REACH_S = 10.0  # for the scheduler to answer, and for a first worker to be there
COUNT_EVERY_S = 2.0  # between two looks at how many workers there are
LONGEST = 300  # of a message of another program


class ClusterWorkers:
    """The workers of a Dask scheduler, however many there are at a time."""

    def __init__(self, job: SweepJob, address: str):
        self._address = address
        self._done: queue.SimpleQueue[tuple[SweepBatch, Any]] = queue.SimpleQueue()
        self._client = connected(address)
        self._counted_s, self._count = 0.0, 1
        try:
            refuse_others(self._client, address, job.identity)
            self._job = self._client.submit(pickle.loads, pickle.dumps(job.for_workers), pure=False)
        except BaseException:
            self.close()
            raise

    @property
    def count(self) -> int:
        """Worker processes; one works on one batch at a time, whatever threads it has."""
        if time.monotonic() - self._counted_s > COUNT_EVERY_S:
            self._counted_s = time.monotonic()
            self._count = max(len(self._client.nthreads()), 1)
        return self._count

    def submit(self, batch: SweepBatch) -> None:
        """As `Workers`."""
        future = self._client.submit(work, self._job, batch, pure=False)
        future.add_done_callback(lambda done: self._done.put((batch, done)))

    def next(self, timeout_s: float) -> tuple[SweepBatch, Outcome] | None:
        """As `Workers`; raises SchedulerError where the scheduler is gone."""
        from distributed import KilledWorker

        try:
            batch, future = self._done.get(timeout=timeout_s)
        except queue.Empty:
            if self._client.status in ("closed", "closing"):
                raise self._gone() from None
            return None
        try:
            return batch, future.result()
        except KilledWorker:
            return batch, Died()
        except (asyncio.CancelledError, OSError):  # a TimeoutError too
            raise self._gone() from None
        except Exception as fault:  # a task catches its own: this is of the cluster
            if type(fault).__name__ in ("CancelledError", "FutureCancelledError"):
                raise self._gone() from None
            raise SchedulerError(
                f"{self._address}: a worker could not take its work: {fault_line(fault)}"
            ) from None

    def close(self) -> None:
        """As `Workers`."""
        self._client.close(timeout=REACH_S)

    def _gone(self) -> SchedulerError:
        return SchedulerError(
            f"{self._address}: the scheduler is gone. What was done is kept: the same command goes on with the rest, "
            "there or elsewhere."
        )


def connected(address: str) -> Any:
    """A client of a scheduler with one worker at least; raises SchedulerError."""
    try:
        from distributed import Client
    except ImportError:
        raise SchedulerError("--scheduler needs Dask; install uwopt[cluster]") from None
    try:
        client = Client(address, timeout=REACH_S, set_as_default=False)
    except (OSError, ValueError) as fault:  # a TimeoutError too
        text = f"no Dask scheduler answers ({fault_line(fault)}); give its address, such as tcp://127.0.0.1:8786"
        raise SchedulerError(f"{address}: {text}") from None
    try:
        client.wait_for_workers(1, timeout=REACH_S)
    except TimeoutError:
        client.close()
        raise SchedulerError(
            f"{address}: the scheduler has no worker; start some, with --nthreads 1"
        ) from None
    return client


def refuse_others(client: Any, address: str, here: Mapping[str, str]) -> None:
    """Raise SchedulerError where a worker lacks the program, or has another one."""
    try:
        found = client.run(program_identity)
    except Exception as fault:  # whatever a worker makes of a program that it does not have
        text = f"its workers have not this uwopt ({fault_line(fault)}); install the same on all of them"
        raise SchedulerError(f"{address}: {text}") from None
    other = {worker: differences(here, there) for worker, there in found.items()}
    for worker, what in other.items():
        if what:
            raise SchedulerError(
                f"{address}: worker {worker} has {'; '.join(what)}; install the same on all of them"
            )


def fault_line(fault: BaseException) -> str:
    """What another program says, in one line."""
    return (" ".join(str(fault).split()) or type(fault).__name__)[:LONGEST]
