"""Hypervolume gap over time of pymoo's algorithms against the exact front: the suite `pareto`."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from statistics import median

import numpy as np

from uwopt.arrays import Array
from uwopt.bench.contest import at_most, mission_of, sources_of
from uwopt.bench.suite import BenchRow, BenchTable, Budget, Suite
from uwopt.catalog.choose import ToBeMade
from uwopt.deadline import Deadline
from uwopt.errors import MissionError
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.objectives.axes import Axes
from uwopt.objectives.dominance import hypervolume
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.search import Search
from uwopt.solvers.front.search import Front, FrontSearch

AXES = ("power", "cost", "snr_db")
QUICK_ALGORITHMS = ("nsga2", "nsga3", "smsemoa")
TARGET = 1e-2  # of the hypervolume: 99 % of the exact front's
LONGEST_S = 120.0  # for an exact front
MOST_SEEN = 24  # points of a run that become rows
LONGEST_RUN_S, SHORTEST_RUN_S = 10.0, 0.5
EXACT = "exact"


def problem_of(mission: Mission, generic: ToBeMade) -> Problem:
    """Fresh tables of the parts that a mission allows."""
    return build_problem(mission, selected(mission, load_catalog(mission), generic=generic))


# ---------------------------------------------------------------- runs as rows


def gap_of(values: Array, front: Front) -> float | None:
    """Share of the volume that no front can exceed which points leave out; None without points in the box."""
    assert front.frame is not None
    reached = hypervolume(np.asarray(values, float).reshape(-1, len(front.axes)), front.frame)
    return 1.0 - reached / front.hypervolume_bound if reached > 0.0 else None


def front_rows(
    case: str, method: str, seed: int | None, history: Sequence[tuple[float, Array]], front: Front, last: BenchRow
) -> Iterator[BenchRow]:  # fmt: skip
    """Some of the archives of a run, evenly spread in the logarithm of time, then its end."""
    if history:
        times = np.array([at for at, _ in history])
        wanted = np.geomspace(max(times[0], 1e-3), max(times[-1], 2e-3), MOST_SEEN)
        for k in sorted({min(int(np.searchsorted(times, at)), len(times) - 1) for at in wanted}):
            at_s, values = history[k]
            yield BenchRow(
                "pareto",
                case,
                method,
                float(len(values)),
                seed,
                at_s,
                gap_of(values, front),
                status="running",
            )
    yield last


def run_exact(
    case: str, mission: Mission, generic: ToBeMade, longest_s: float = LONGEST_S
) -> tuple[Front, list[BenchRow]]:
    """The exact front, and how it came about."""
    problem = problem_of(mission, generic)
    front = FrontSearch(problem, Axes.of(AXES), deadline=Deadline.after(longest_s)).run()
    if front.interrupted:  # the search keeps what it found; a benchmark ends
        raise KeyboardInterrupt
    status = "optimal" if front.complete else "stopped"
    if front.frame is None or not front.hypervolume_bound:
        why = "infeasible" if front.complete and not len(front.values) else status
        return front, [BenchRow("pareto", case, EXACT, 0.0, None, front.seconds, status=why)]
    gap = 1.0 - front.hypervolume / front.hypervolume_bound
    last = BenchRow("pareto", case, EXACT, float(len(front.values)), None, front.seconds, gap, status=status)
    return front, list(front_rows(case, EXACT, None, front.history, front, last))


def run_population(
    case: str, mission: Mission, generic: ToBeMade, front: Front, algorithm: str, seed: int, seconds: float
) -> list[BenchRow]:
    """One algorithm with one seed, from tables built to the end of its time."""
    from uwopt.solvers.population.pymoo_front import population_front

    problem = problem_of(mission, generic)
    start = time.perf_counter()
    search = Search(problem, Objective(dict.fromkeys(AXES, 1.0)), top=1, progress=None)
    search.prepare()
    before_s = time.perf_counter() - start
    left_s = max(seconds - before_s, 0.05)
    found = population_front(search, list(AXES), algorithm=algorithm, seed=seed, seconds=left_s)
    if found.status == "interrupted":
        raise KeyboardInterrupt
    took_s = time.perf_counter() - start
    history = [(before_s + at, values) for at, values in found.history]
    gap = gap_of(history[-1][1], front) if history else None
    last = BenchRow("pareto", case, algorithm, float(len(history[-1][1])) if history else 0.0, seed, took_s, gap,
               status=found.status, note=f"{found.evaluations} evaluations within {seconds:.3g} s")  # fmt: skip
    return list(front_rows(case, algorithm, seed, history, front, last))


def measure(budget: Budget, algorithms: Sequence[str] | None = None) -> Iterator[BenchRow]:
    """Every mission: the exact front, then every algorithm with every seed, as long as there is time."""
    from uwopt.solvers.population.pymoo_front import ALGORITHMS, create

    names = list(algorithms or (QUICK_ALGORITHMS if budget.quick else ALGORITHMS))
    for name in names:  # pymoo imports each when it is first made, which no clock should see
        create(name, len(AXES), 20, {"sampling": np.zeros((20, 1), int)})
    seeds = [budget.seed] if budget.quick else [budget.seed + k for k in range(3)]
    sources = sources_of(budget)
    total = left = len(sources) * len(seeds) * len(names)
    for case, source in sources:
        budget.tell(1.0 - left / total, f"{case}: exact front")
        try:
            mission = mission_of(source)
            choice = mission.catalog
            for generic in dict.fromkeys((choice.generic_at_first, choice.generic_at_last)):
                front, rows = run_exact(case, mission, generic, at_most(LONGEST_S, budget))
                if len(front.values) or not front.complete:
                    break
        except MissionError as fault:
            yield BenchRow("pareto", case, EXACT, status="not applicable", note=str(fault).splitlines()[0])
            left -= len(seeds) * len(names)
            continue
        yield from rows
        if rows[-1].status != "optimal":
            left -= len(seeds) * len(names)
            continue
        for seed in seeds:
            for name in names:
                share_s = max(budget.left_s, 0.0) / left
                left -= 1
                if budget.left_s <= 0.0:
                    return
                budget.tell(1.0 - (left + 1) / total, f"{case}: {name}")
                seconds = min(LONGEST_RUN_S, max(SHORTEST_RUN_S, share_s))
                yield from run_population(case, mission, generic, front, name, seed, seconds)


# ---------------------------------------------------------------- tables


def runs_of(rows: Sequence[BenchRow], case: str, method: str) -> list[list[BenchRow]]:
    """Rows of one method in one mission, run by run."""
    runs: list[list[BenchRow]] = [[]]
    for row in rows:
        if row.case == case and row.method == method:
            runs[-1].append(row)
            if row.status != "running":
                runs.append([])
    return [run for run in runs if run]


def fronts_table(rows: Sequence[BenchRow]) -> BenchTable:
    """Seconds to the target and the gap at the end, by mission and method."""
    body = []
    for case in dict.fromkeys(row.case for row in rows):
        for method in dict.fromkeys(row.method for row in rows if row.case == case):
            runs = runs_of(rows, case, method)
            near = [
                min(
                    (r.time_s or 0.0 for r in run if r.error is not None and r.error <= TARGET),
                    default=np.inf,
                )
                for run in runs
            ]
            ends = [np.inf if run[-1].error is None else run[-1].error for run in runs]
            took = max(run[-1].time_s or 0.0 for run in runs)
            body.append([
                case, method, str(len(runs)),
                f"{median(near):.2f}" if np.isfinite(median(near)) else f"not in {took:.1f}",
                f"{median(ends):.1e}" if np.isfinite(median(ends)) else "-",
                f"{max(ends):.1e}" if np.isfinite(max(ends)) else "-", f"{took:.2f}",
            ])  # fmt: skip
    return BenchTable(
        f"Seconds to a hypervolume gap of {TARGET:g}, and the gap at the end",
        ["mission", "method", "runs", "s to the target", "gap at the end, median", "worst seed", "s in all"],
        body,
        "Gap: the share of the hypervolume that no front can exceed, by the exact search's bounds, which points leave "
        "out. The exact search ends with a proof, and its points leave out what its gap says: so much nearer the bound "
        "others may come. These stop by themselves or with their time.",
    )


SUITE = Suite(
    name="pareto",
    title="Fronts: pymoo's algorithms against the exact front",
    text=(
        "The front of power, cost and SNR. The gap is the share of hypervolume left out, in the frame of the exact "
        "front: logarithms of power and cost, reference 1.1 times the range. All runs take place in this process, one "
        "after the other, with pymoo imported and the parts loaded before the clock starts; enumeration of imagers "
        "and bounds count for all. pymoo's algorithms have 200 vectors a generation, half of the first population "
        "from the designs that are best by the exact search's bounds, and keep an archive of all they met."
    ),
    chart="progress",
    measure=measure,
    quick_s=12.0,
    full_s=600.0,
    size_name="points",
    time_name="elapsed time, s",
    error_name="hypervolume gap",
    tables=lambda rows: (fronts_table(rows),),
)
