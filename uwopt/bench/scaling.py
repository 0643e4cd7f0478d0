"""How time and memory of the exact search grow with the catalogue: four missions, 10^3 to 10^12 combinations.

The catalogues are made by `scaling_parts`. Each point runs in a fresh process, so that its peak memory is its
own. From the parts as records to the proven optimum: tables of the problem, search, certificate's account.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from uwopt.bench.scaling_parts import DEPTH_M, made_parts
from uwopt.bench.suite import BenchRow, BenchTable, Budget, Suite
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission, load_mission
from uwopt.objectives.goal import goal_of
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.search import Search

NAME = "scaling"
QUICK_SIZES = (1e3, 1e4, 1e5, 1e6, 1e7)
FULL_SIZES = (*QUICK_SIZES, 1e8, 1e9, 1e10, 1e11, 1e12)
PHYSICS = "full"  # what every default run proves its optimum with
QUICK_S, FULL_S = 15.0, 200.0
START_S = 3.0  # a process, its imports and the making of the parts
MIB = 2.0**20
GAP_REL = 1e-9  # closed forms leave no more

# What all four ask of the images; the limits make them loose, bound by one budget, or impossible.
REQUIREMENTS: dict[str, Any] = {
    "overlap": 0.6, "max_blur_px": 1.0, "min_dof_m": 0.5, "min_snr_db": 26.0, "max_gsd_mm": 1.5, "mean_level": 0.3,
}  # fmt: skip
VEHICLE: dict[str, Any] = {
    "altitude_m": 2.0, "altitude_tolerance_m": 0.25, "speed_m_s": 0.5, "light_count": [1, 4], "light_baseline_m": 0.8,
}  # fmt: skip
MISSIONS: dict[str, dict[str, Any]] = {
    "loose": {"objective": "power", "limits": {}},
    "cost-bound": {"objective": "power", "limits": {"cost": 8500.0}},
    "power-bound": {"objective": "cost", "limits": {"power_w": 4.5}},
    "infeasible": {"objective": "power", "limits": {"cost": 4100.0, "power_w": 2.5}},
}


@dataclass(frozen=True)
class Point:
    """What one run of the search took and found."""

    size: float  # combinations loaded
    time_s: float  # of the processor
    elapsed_s: float
    memory_mib: float  # largest resident set of the process
    status: str  # optimal, infeasible; stopped and wrong are not proofs
    evaluated: int
    value: float | None  # of the objective
    design: str  # ids of the best parts


def mission_for(name: str, physics: str = PHYSICS) -> Mission:
    """One of the four missions."""
    limits = {"depth_rating_m": DEPTH_M, **MISSIONS[name]["limits"]}
    plain = {
        "name": name, "objective": MISSIONS[name]["objective"], "physics": physics,
        "scene": {"water": "II", "seafloor": "coral", "depth_m": DEPTH_M}, "vehicle": VEHICLE,
        "requirements": REQUIREMENTS, "limits": limits, "practice": "bare",
    }  # fmt: skip
    return load_mission(plain)


def search_of(mission: Mission, parts: Parts, *, deadline: Deadline = NEVER) -> Search:
    """The search over some parts, ready to run."""
    problem = Problem(mission, parts, paper=mission.physics == "paper")
    return Search(problem, goal_of(mission), top=1, deadline=deadline)


def proof_status(outcome: Outcome) -> str:
    """What was proven: an optimum with no gap, or that there is none, with every combination accounted for."""
    if not outcome.complete:
        return "stopped"
    if not outcome.account.adds_up():
        return "wrong"
    if not outcome.best:
        return "infeasible"
    best = outcome.best[0].minimised
    return "optimal" if best - outcome.lower_bound <= GAP_REL * abs(best) else "wrong"


def measured(name: str, size: float, *, physics: str = PHYSICS, deadline: Deadline = NEVER) -> Point:
    """One search in this process."""
    mission, parts = mission_for(name, physics), made_parts(size)
    elapsed, start_s = time.perf_counter(), time.process_time()
    outcome = search_of(mission, parts, deadline=deadline).run()
    took_s, elapsed_s = time.process_time() - start_s, time.perf_counter() - elapsed
    found = outcome.best[0] if outcome.best else None
    ids = [] if found is None else [part.id for part in parts.of(found).values()]
    ids[3:] = [] if found is None else [f"{found.count} x {ids[3]}"]
    return Point(
        float(outcome.account.total), took_s, elapsed_s, peak_mib(), proof_status(outcome), outcome.account.evaluated,
        None if found is None else found.minimised, ", ".join(ids),
    )  # fmt: skip


def peak_mib() -> float:
    """Largest resident set of this process so far.

    Linux's own figure starts with the program; `getrusage` may hand on what the starting process had.
    """
    try:
        for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) / 1024.0
    except OSError:
        pass
    most = float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    return most / MIB if sys.platform == "darwin" else most / 1024.0


def apart(name: str, size: float, *, physics: str = PHYSICS, seconds: float) -> Point | None:
    """One search in a fresh process; None when it did not end in time."""
    command = [sys.executable, "-m", "uwopt.bench.scaling", name, f"{size:g}", physics, f"{seconds:g}"]
    try:
        ran = subprocess.run(command, capture_output=True, text=True, timeout=seconds + START_S, check=True)
    except subprocess.TimeoutExpired:
        return None
    return Point(**json.loads(ran.stdout))


def measure(budget: Budget) -> Iterator[BenchRow]:
    """All missions by rising size, while time is left: a mission that was stopped is not asked for more."""
    sizes = QUICK_SIZES if budget.quick else FULL_SIZES
    yield from size_rows(budget, sizes, PHYSICS)


def size_rows(budget: Budget, sizes: Sequence[float], physics: str) -> Iterator[BenchRow]:
    """Rows of these sizes, smallest first."""
    steps, stopped = [(size, name) for size in sizes for name in MISSIONS], set()
    for step, (size, name) in enumerate(steps):
        budget.tell(step / len(steps), f"{name}, {size:.0e} combinations")
        if name in stopped:
            continue
        point = apart(name, size, physics=physics, seconds=budget.left_s) if budget.left_s > 0.0 else None
        yield row_of(point, name, size, physics)
        if point is None or point.status == "stopped":
            stopped.add(name)
    budget.tell(1.0, "done")


def row_of(point: Point | None, name: str, size: float, physics: str) -> BenchRow:
    """One point as a row."""
    method = f"exact, physics {physics}"
    if point is None:
        return BenchRow(NAME, name, method, size=size, status="stopped", note="no time left")
    value = "nothing feasible" if point.value is None else f"best {point.value:.6g}: {point.design}"
    note = f"{point.evaluated} evaluated; {point.elapsed_s:.3g} s elapsed; {value}"
    return BenchRow(
        NAME, name, method, size=point.size, time_s=point.time_s, memory_mib=point.memory_mib, status=point.status,
        error=0.0 if point.status in ("optimal", "infeasible") else None, note=note,
    )  # fmt: skip


def tables(rows: Sequence[BenchRow]) -> Sequence[BenchTable]:
    """Seconds and memory of each mission by size."""
    head = ("combinations", *MISSIONS)
    found = {(row.size, row.case): row for row in rows if row.size is not None and row.time_s is not None}
    sizes = sorted({size for size, _ in found if size is not None})
    seconds = [(f"{size:.3g}", *(time_cell(found.get((size, name))) for name in MISSIONS)) for size in sizes]
    memory = [(f"{size:.3g}", *(memory_cell(found.get((size, name))) for name in MISSIONS)) for size in sizes]
    return [
        BenchTable(
            "Seconds of the processor", head, seconds,
            "From the parts as records to the proof. Every number without a remark is of a finished proof.",
        ),
        BenchTable(
            "Most memory of the process, MiB", head, memory, "Python and its libraries take some 70 MiB of it.",
        ),
    ]  # fmt: skip


def time_cell(row: BenchRow | None) -> str:
    """Seconds, with the status where it is no proof."""
    if row is None:
        return ""
    remark = "" if row.status in ("optimal", "infeasible") else f" ({row.status})"
    return f"{row.time_s:.2f}{remark}"


def memory_cell(row: BenchRow | None) -> str:
    """Memory in MiB."""
    return "" if row is None or row.memory_mib is None else f"{row.memory_mib:.0f}"


def main(arguments: Sequence[str]) -> None:
    """One point for `apart`, as JSON on standard output: mission, size, physics, seconds."""
    name, size, physics, seconds = arguments
    point = measured(name, float(size), physics=physics, deadline=Deadline.after(float(seconds)))
    sys.stdout.write(json.dumps(asdict(point)))


SUITE = Suite(
    name=NAME,
    title="Exact search: time and memory by size of the catalogue",
    text=(
        "Cameras, lenses, ports and lights are made from the real ones, all four kinds enlarged or thinned by one "
        "factor; no made part dominates another, because prices rise with what is better. Four missions ask the "
        "same of the images: one without budgets, one whose cost binds, one whose power binds, and one whose "
        "budgets are met one by one but not together. Each search runs to its proof: no gap is left and every "
        "combination is accounted for. Times are seconds of one processor core from the parts as records to the "
        "proven optimum, tables included; imports and the making of the parts are not."
    ),
    chart="scaling",
    measure=measure,
    quick_s=QUICK_S,
    full_s=FULL_S,
    size_name="combinations loaded",
    time_name="time of the processor, s",
    tables=tables,
)

if __name__ == "__main__":
    main(sys.argv[1:])
