"""Workers as seen by who asks: batches go in, replies come out of a queue, in whatever order they are done.

On this machine workers are processes that are made anew when one dies. `cluster` has the same door for Dask.
"""

from __future__ import annotations

import multiprocessing
import queue
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Protocol

from uwopt.sweeps.job import SweepBatch, SweepJob
from uwopt.sweeps.work import SweepReply, SweepWorker, begin, work_on

TRIED = 2  # missions, before other processes are started
START_S = 3.0  # of work that is left, for which it pays to start them


class Died(Exception):  # noqa: N818 - no error of the program: a process is gone
    """A worker died while it had a batch, this one or another."""


Outcome = SweepReply | Died


class Workers(Protocol):
    """What sends batches to workers."""

    @property
    def count(self) -> int:
        """How many there are."""

    def submit(self, batch: SweepBatch) -> None:
        """Send a batch."""

    def next(self, timeout_s: float) -> tuple[SweepBatch, Outcome] | None:
        """A batch that is done, or of which the worker died; None where none is by then."""

    def close(self) -> None:
        """Let workers go; what they have not finished is lost."""


class ThisProcess:
    """No workers: batches are worked on where they are asked for."""

    count = 1

    def __init__(self, job: SweepJob):
        self._worker = SweepWorker(job)
        self.waiting: list[SweepBatch] = []
        self.n_done, self.last_s = 0, 0.0  # missions, and how long the last one took

    def submit(self, batch: SweepBatch) -> None:
        """As `Workers`."""
        self.waiting.append(batch)

    def next(self, timeout_s: float) -> tuple[SweepBatch, Outcome] | None:
        """As `Workers`."""
        if not self.waiting or not timeout_s:
            return None
        batch = self.waiting.pop(0)
        reply = self._worker.reply(batch)
        if reply.rows:
            self.n_done, self.last_s = self.n_done + len(reply.rows), reply.rows[-1]["time_s"]
        return batch, reply

    def close(self) -> None:
        """As `Workers`."""


class LocalWorkers:
    """Processes on this machine, each with the catalogue of its own.

    The first missions are worked out in the process that asks: few that are quick are done before others start.
    """

    def __init__(self, job: SweepJob, count: int, left: int):
        self.count = count
        self._job, self._left = job.for_workers, left
        self._here: ThisProcess | None = ThisProcess(job)
        self._done: queue.SimpleQueue[tuple[SweepBatch, Future[SweepReply]]] = queue.SimpleQueue()
        self._pool: ProcessPoolExecutor | None = None

    def submit(self, batch: SweepBatch) -> None:
        """As `Workers`; where a process has died, others are made."""
        if self._here is not None:
            self._here.submit(batch)
            return
        try:
            future = self._running().submit(work_on, batch)
        except BrokenProcessPool:
            self.close()
            future = self._running().submit(work_on, batch)
        future.add_done_callback(lambda done: self._done.put((batch, done)))

    def next(self, timeout_s: float) -> tuple[SweepBatch, Outcome] | None:
        """As `Workers`."""
        if self._here is not None and (done := self._here.next(timeout_s)) is not None:
            self._left -= len(done[0].tasks)
            if self._here.n_done >= TRIED and self._left * self._here.last_s > START_S:
                here, self._here = self._here, None
                for batch in here.waiting:
                    self.submit(batch)
            return done
        try:
            batch, future = self._done.get(timeout=timeout_s)
        except queue.Empty:
            return None
        try:
            return batch, future.result()
        except BrokenProcessPool:
            return batch, Died()

    def close(self) -> None:
        """As `Workers`."""
        pool, self._pool = self._pool, None
        if pool is not None:
            processes = list((pool._processes or {}).values())
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()
            for process in processes:
                process.join()

    def _running(self) -> ProcessPoolExecutor:
        if self._pool is None:
            self._pool = ProcessPoolExecutor(
                self.count, mp_context=new_processes(), initializer=begin, initargs=(self._job,)
            )
        return self._pool


def new_processes() -> Any:
    """How processes are made: from a clean one that has the program loaded, where the system knows that."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["uwopt.sweeps.work"])
    return context


def local_workers(job: SweepJob, count: int, left: int) -> Workers:
    """So many processes of this machine for so many missions; one worker needs none of its own."""
    return ThisProcess(job) if count == 1 else LocalWorkers(job, count, left)
