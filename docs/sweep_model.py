"""A discrete-event model of a sweep on a cluster: who asks, the scheduler and the workers are queues with one server.

Batches go round: who asks sends one (`send_s`), the scheduler assigns it to the worker with least to do (`assign_s`),
the worker works, the scheduler passes the reply on (`assign_s` again), who asks keeps it (`row_s` a mission, and
`write_s` for a file that takes all replies which are waiting by then) and sends the next. So many batches are under way
as the program itself allows. All times are measured; a batch's work is drawn from the mean and spread of the missions'.
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from uwopt.sweeps.run import AHEAD, MOST_ROWS, Pace


@dataclass(frozen=True)
class Rates:
    """What was measured, all in seconds."""

    mission_s: float  # of a worker, mean
    spread_s: float  # its standard deviation
    batch_s: float  # of a worker a batch, beside its missions
    assign_s: float  # of the scheduler, each way
    send_s: float  # of who asks, a batch
    row_s: float  # of who asks, a mission
    write_s: float  # of who asks, a file


@dataclass(frozen=True)
class Projection:
    """What came of a simulated sweep."""

    seconds: float
    batches: int
    scheduler_busy: float  # shares of the time
    asker_busy: float
    workers_busy: float


def projected(rates: Rates, *, workers: int, missions: int, seed: int = 0) -> Projection:
    """Simulate a sweep of so many missions on so many workers, all there from the beginning."""
    draw = np.random.default_rng(seed)
    pace = Pace(workers, rates.mission_s)
    left, batches, now = missions, 0, 0.0
    events: list[tuple[float, int, str, int, int]] = []  # time, number, what is done, missions, worker
    scheduler_free = 0.0
    scheduler_s = asker_s = work_s = 0.0
    backlog = [(0.0, worker) for worker in range(workers)]  # when each worker is free
    waiting: deque[int] = deque()  # missions of replies that who asks has not taken yet
    asker_free = 0.0

    def through_scheduler(at: float) -> float:
        nonlocal scheduler_free, scheduler_s
        scheduler_free = max(scheduler_free, at) + rates.assign_s
        scheduler_s += rates.assign_s
        return scheduler_free

    def send(at: float) -> float:
        """Send the next batch; returns when who asks is free again."""
        nonlocal left, batches, asker_s, work_s
        size = min(pace.size(left), left)
        if not size:
            return at
        left, batches, asker_s = left - size, batches + 1, asker_s + rates.send_s
        there = through_scheduler(at + rates.send_s)
        free, worker = heapq.heappop(backlog)
        took = rates.batch_s + max(draw.normal(size * rates.mission_s, math.sqrt(size) * rates.spread_s), 0.0)
        done = max(free, there) + took
        work_s += took
        heapq.heappush(backlog, (done, worker))
        heapq.heappush(events, (done, batches, "worked", size, worker))
        return at + rates.send_s

    for _ in range(AHEAD * workers):
        asker_free = send(asker_free)
    asked = False  # whether who asks is to look at what waits
    while events:
        now, number, what, size, worker = heapq.heappop(events)
        if what == "worked":
            heapq.heappush(events, (through_scheduler(now), number, "replied", size, worker))
            continue
        if what == "replied":
            waiting.append(size)
        else:
            asked, taken = False, list[int]()
            while waiting and sum(taken) < MOST_ROWS:
                taken.append(waiting.popleft())
            spent = rates.write_s + rates.row_s * sum(taken)
            asker_s += spent
            asker_free = now + spent
            for _ in taken:
                asker_free = send(asker_free)
        if waiting and not asked:
            asked = True
            heapq.heappush(events, (max(now, asker_free), number, "take", 0, worker))
    end = max(now, asker_free)
    return Projection(end, batches, scheduler_s / end, asker_s / end, work_s / (end * workers))
