"""Measure sweeps over many missions and print a page; with --write into docs/sweep.md.

    python docs/make_sweep.py [--write] [--missions N] [--rounds R]

One worker and two take turns on the same missions, in time of the processor; the costs of
sending and keeping are measured on a Dask scheduler of this machine. From these rates `sweep_model` projects larger
clusters. No test depends on the numbers.
"""

from __future__ import annotations

import argparse
import json
import os
import pickle
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import mean, median, stdev
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs")]

from sweep_model import Projection, Rates, projected  # noqa: E402

from uwopt.api.solving import solve  # noqa: E402
from uwopt.bench.machine import processor  # noqa: E402
from uwopt.mission.mission import load_mission  # noqa: E402
from uwopt.sweeps import workers as workers_room  # noqa: E402
from uwopt.sweeps.inputs import job_of  # noqa: E402
from uwopt.sweeps.job import SweepBatch  # noqa: E402
from uwopt.sweeps.run import BATCH_S, sweep  # noqa: E402
from uwopt.sweeps.store import SweepStore  # noqa: E402
from uwopt.sweeps.work import SweepReply, SweepWorker  # noqa: E402

PAGE = ROOT / "docs" / "sweep.md"
CLUSTER = ROOT / "tests" / "sweeps" / "dask_processes.py"
MISSION = ROOT / "problems" / "mbari-lass-2013.yaml"
NO_OPS = 1000
SEASON = 1000  # missions for which two workers are told
SIZES = ((1, 10**3), (2, 10**3), (10, 10**4), (100, 10**6), (1000, 10**7))


def varied(missions: int) -> dict[str, str]:
    """Speeds and heights of so many missions."""
    return {"speed_m_s": f"0.05:0.3:{missions // 5}", "altitude_m": "3:4:5"}


def measured(missions: int, workers: int) -> dict[str, Any]:
    """One sweep: seconds on the clock, of the processor each mission, and a worker's memory [MiB]."""
    with tempfile.TemporaryDirectory() as folder:
        made = sweep(MISSION, varied(missions), out=folder, workers=workers, kits=0)
        spent = [float(x) for x in made.frame()["processor_s"]]
        return {"clock_s": made.timing_s["missions"], "mission_s": spent, "memory_mb": made.memory_mb}


def efficiency(missions: int, rounds: int) -> dict[str, Any]:
    """One worker and two, turn by turn."""
    workers_room.START_S = 0.0
    turns = [(measured(missions, 1), measured(missions, 2)) for _ in range(rounds)]
    one, two = ([turn[k] for turn in turns] for k in (0, 1))
    return {
        "one_s": median(mean(run["mission_s"]) for run in one), "two_s": median(mean(run["mission_s"]) for run in two),
        "clock": median(a["clock_s"] / b["clock_s"] for a, b in turns),
        "memory_mb": max(run["memory_mb"] for run in two),
        "spent_s": [x for run in two for x in run["mission_s"][2:]],
    }  # fmt: skip


def of_start() -> float:
    """Seconds of the processor that a worker takes before its first mission: the program and the catalogue."""
    script = "import time, uwopt.sweeps.work, uwopt; uwopt.load_catalog(); print(time.process_time())"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, "-c", script]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def of_scheduler() -> tuple[float, float, float]:
    """Seconds a batch of the scheduler each way, of who asks to send one, and of a worker beside its missions.

    Of the scheduler it is time of the processor; batches that hold no mission go there and back.
    """
    import psutil
    from distributed import Client

    folder = tempfile.mkdtemp()
    with subprocess.Popen(
        [sys.executable, str(CLUSTER), "2", folder], env={**os.environ, "PYTHONPATH": str(ROOT)}, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, text=True,
    ) as running:  # fmt: skip
        assert running.stdout is not None
        known = json.loads(running.stdout.readline())
        with Client(known["address"], set_as_default=False) as client:
            pids = {"scheduler": client.run_on_scheduler(os.getpid), "worker": known["workers"][0]}
            processes = {name: psutil.Process(pid) for name, pid in pids.items()}
            client.gather([client.submit(int, pure=False) for _ in range(50)])
            before = {name: sum(process.cpu_times()[:2]) for name, process in processes.items()}
            start_s = time.process_time()
            held = client.submit(pickle.loads, pickle.dumps(job_of([MISSION])), pure=False)
            client.gather([client.submit(nothing, held, SweepBatch(()), pure=False) for _ in range(NO_OPS)])
            sent_s = time.process_time() - start_s
            spent = {name: sum(process.cpu_times()[:2]) - before[name] for name, process in processes.items()}
        running.stdin.close()  # type: ignore[union-attr]
    return spent["scheduler"] / NO_OPS / 2.0, sent_s / NO_OPS, 2.0 * spent["worker"] / NO_OPS


def nothing(job: Any, batch: SweepBatch) -> SweepReply:
    """A batch that asks for no work."""
    del job, batch
    return SweepReply([], 0.0)


def of_asker() -> tuple[float, float]:
    """Seconds of who asks a mission (its key, its row taken apart and kept) and a file."""
    job = job_of([MISSION], varied(1000))
    start_s = time.process_time()
    tasks = list(job.tasks())
    key_s = (time.process_time() - start_s) / len(tasks)
    row = SweepWorker(job).row(tasks[0])
    rows = [row | {"key": task.key} for task in tasks]
    held = pickle.dumps(SweepReply(rows, 0.0))
    start_s = time.process_time()
    rows = pickle.loads(held).rows
    row_s = (time.process_time() - start_s) / len(rows)
    with tempfile.TemporaryDirectory() as folder, SweepStore(Path(folder)) as store:
        store.add(rows)
        took = []
        for some in (rows[:1], rows):
            spent = []
            for _ in range(5):
                start_s = time.perf_counter()
                store.add(some)
                spent.append(time.perf_counter() - start_s)
            took.append(median(spent))
    return 3.0 * key_s + row_s + max(took[1] - took[0], 0.0) / len(rows), took[0]


def table(rates: Rates) -> list[tuple[int, int, Projection]]:
    """What the model makes of the rates."""
    return [(workers, missions, projected(rates, workers=workers, missions=missions)) for workers, missions in SIZES]


def duration(seconds: float) -> str:
    """Seconds, minutes or hours."""
    for unit, length_s in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length_s:
            return f"{seconds / length_s:.1f} {unit}"
    return f"{seconds:.0f} s"


def cold_s() -> float:
    """Seconds of the processor that a mission takes when it is solved by itself."""
    job = job_of([MISSION], varied(1000))
    some = [task for n, task in enumerate(job.tasks()) if n % 199 == 7]
    spent = []
    for task in some:
        mission = SweepWorker(job).mission(task)
        start_s = time.process_time()
        solve(mission, quick=True, explain=False)
        spent.append(time.process_time() - start_s)
    return mean(spent)


def page(missions: int, rounds: int) -> str:
    """The page."""
    assert load_mission(MISSION).practice == "bare"  # likeliest values: no scenarios
    found = efficiency(missions, rounds)
    spent = found["spent_s"]
    assign_s, send_s, batch_s = of_scheduler()
    row_s, write_s = of_asker()
    rates = Rates(mean(spent), stdev(spent), batch_s, assign_s, send_s, row_s, write_s)
    asker_s = row_s + (send_s + write_s) * found["two_s"] / BATCH_S
    one_alone_s = SEASON * (found["one_s"] + asker_s)
    two_alone_s = of_start() + SEASON * (found["two_s"] + asker_s) / 2.0
    lines = [
        f"| {workers} | {missions:,} | {duration(one.seconds)} | {missions / one.seconds:.0f} | {one.batches:,} | "
        f"{100 * one.workers_busy:.0f} % | {100 * one.scheduler_busy:.1f} % | {100 * one.asker_busy:.0f} % |".replace(
            ",", " "
        )
        for workers, missions, one in table(rates)
    ]
    load = ", ".join(f"{value:.1f}" for value in os.getloadavg()) if hasattr(os, "getloadavg") else "unknown"
    return TEXT.format(
        missions=missions, rounds=rounds, machine=f"{processor()}, {os.cpu_count()} processors, load {load}",
        no_ops=NO_OPS, one_ms=1e3 * found["one_s"], two_ms=1e3 * found["two_s"], start_s=of_start(),
        asker_ms=1e3 * asker_s, clock=found["clock"], ratio=one_alone_s / two_alone_s,
        rate=SEASON / two_alone_s, memory=found["memory_mb"], cold_ms=1e3 * cold_s(),
        mission_ms=1e3 * rates.mission_s, spread_ms=1e3 * rates.spread_s, batch_ms=1e3 * batch_s,
        assign_us=1e6 * assign_s, send_us=1e6 * send_s, row_us=1e6 * row_s, write_ms=1e3 * write_s,
        lines="\n".join(lines),
    )  # fmt: skip


TEXT = """# How fast sweeps are

Written by `python docs/make_sweep.py --write` on {machine}.
Others use the machine as well: what is compared is time of the processor; the clock is told where it stands.

## One worker and two

{missions} missions of `mbari-lass-2013` (speeds, at 5 heights; likeliest values, no portfolio), one worker and two by
turns (medians of turns: {rounds}):

| what | time of the processor |
|---|---|
| a mission by itself (`solve --quick`, no neighbour known) | {cold_ms:.0f} ms |
| a mission among its neighbours, one worker | {one_ms:.0f} ms |
| a mission among its neighbours, two workers at once | {two_ms:.0f} ms |
| the start of a worker: program and catalogue | {start_s:.1f} s |
| who asks, a mission (keys, rows, files) | {asker_ms:.2f} ms |

So two processors of which nobody else takes time work out 1000 missions {ratio:.2f} times as fast as one, {rate:.1f} a
second: the start of the workers and who asks are counted, the table and the page at the end are not. On the clock of
this run, loaded as it was and with {missions} missions alone, they were {clock:.2f} times as fast. A worker held
{memory:.0f} MiB at most. Most of a mission among its neighbours is the evaluation of the best and the rounding of its
settings, not the search.

## What a batch and a mission cost beside the work

Measured with {no_ops} empty batches on a Dask scheduler with two workers, all on this machine, in time of the
processor; of writing on the clock, for it waits for the disk (`fsync` of file and folder).

| who | what | cost |
|---|---|---|
| scheduler | a batch, each way | {assign_us:.0f} µs |
| worker | a batch, beside its missions | {batch_ms:.2f} ms |
| who asks | a batch, sent | {send_us:.0f} µs |
| who asks | a mission: its key, its row taken and kept | {row_us:.0f} µs |
| who asks | a file | {write_ms:.1f} ms |

## Larger clusters, projected

A discrete-event model ([sweep_model.py](sweep_model.py)) with these rates (a mission {mission_ms:.0f} ms, standard
deviation {spread_ms:.0f} ms): who asks, the scheduler and each worker are queues with one server; batches grow with the
number of workers by the rule of the program itself.

| workers | missions | time | missions a second | batches | workers busy | scheduler busy | who asks busy |
|---|---|---|---|---|---|---|---|
{lines}

Assumptions: all workers are there from the beginning, are as fast as here and have read the catalogue; none dies; a
message takes no time on its way (each batch takes many times as long); the scheduler's cost a batch does not grow with
the number of workers; batches differ as the sum of missions drawn apart; the disk of who asks is as fast as here. Not
in it: the whole table at the end, which is put together piece by piece, 20 000 rows at a time: of 100 000 rows it took
3 s of the processor, and the most that the process held rose by 30 MiB.
"""


def main() -> None:
    """Measure, print, write."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--write", action="store_true", help="into docs/sweep.md")
    asked.add_argument("--missions", type=int, default=200)
    asked.add_argument("--rounds", type=int, default=3)
    given = asked.parse_args()
    text = page(given.missions, given.rounds)
    print(text)
    if given.write:
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
