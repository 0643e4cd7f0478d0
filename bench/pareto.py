"""How near pymoo's front comes to the exact one, from a cold start: hypervolume ratio against seconds.

    python bench/pareto.py [--seconds 10] [--seeds 5] [--mission FILE] [--algorithm nsga2]

Each seed runs in a process of its own, that is stopped after so many seconds since it began: start of Python,
imports, catalogue and tables are part of them. Ratios are of the archive as it stood at each time, in the
frame of the exact front (logarithms of power and cost, reference 1.1 times the range).
"""

from __future__ import annotations

import argparse
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(ROOT / "bench"))

REEF = ROOT / "problems" / "reef-mosaic.yaml"
FRONTS = (("power", "cost", "information"), ("power", "cost", "snr_db"))
TIMES_S = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
LAST_S = 0.4  # of a process: reading its archive back as designs, and writing it


def cold(mission: Path, names: Sequence[str], algorithm: str, seed: int, seconds: float, out: Path) -> None:
    """One run in this process; what it found goes to a file, with times since the process began."""
    began = started_s()
    from uwopt.api import load_catalog, prepared
    from uwopt.objectives.objective import Objective
    from uwopt.solvers.exact import Search
    from uwopt.solvers.pymoo_front import population_front
    from uwopt.solvers.recommend import build_problem, selected

    wanted = prepared(mission, None, None)
    selection = selected(wanted, load_catalog(wanted), generic="never")
    objective = Objective(dict.fromkeys(names, 1.0))
    search = Search(build_problem(wanted, selection), objective, top=1, deadline_s=None, progress=None)
    search.prepare()
    before = time.time() - began
    front = population_front(
        search, list(names), algorithm=algorithm, seed=seed, seconds=seconds - before - LAST_S
    )
    history = [(before + at, values) for at, values in front.history]
    total = time.time() - began
    out.write_bytes(pickle.dumps((front.values, history, total, front.status, front.evaluations)))


def started_s() -> float:
    """When the parent started this process, in seconds of the clock."""
    return float(os.environ["UWOPT_BENCH_START"])


def run(mission: Path, names: Sequence[str], algorithm: str, seed: int, seconds: float) -> Any:
    """One cold process."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "front.pickle"
        command = [
            sys.executable, str(Path(__file__)), "--cold", str(out), "--mission", str(mission), "--objectives",
            ",".join(names), "--algorithm", algorithm, "--seed", str(seed), "--seconds", str(seconds),
        ]  # fmt: skip
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "UWOPT_BENCH_START": repr(time.time())}
        subprocess.run(command, check=True, env=environment, cwd=ROOT)
        return pickle.loads(out.read_bytes())


def exact_values(mission: Path, names: Sequence[str]) -> Any:
    """The exact front's values (n, n_axes), less is better."""
    import numpy as np

    import uwopt
    from uwopt.objectives.objective import MAXIMISED

    front = uwopt.pareto(mission, objectives=list(names), solver="exact")
    sign = [-1.0 if name in MAXIMISED else 1.0 for name in names]
    return np.array([[s * p.values[n] for s, n in zip(sign, names, strict=True)] for p in front.points])


def pareto_table(
    mission: Path = REEF, *, algorithm: str = "nsga2", seeds: int = 5, seconds: float = 10.0
) -> list[str]:
    """Ratios by time, median of the seeds and the least."""
    from run import table

    from uwopt.objectives.axes import Axes, Frame
    from uwopt.solvers.dominance import hypervolume

    rows = []
    for names in FRONTS:
        reference = exact_values(mission, names)
        frame = Frame.of(Axes.of(names), reference)
        whole = hypervolume(reference, frame)
        runs = [run(mission, names, algorithm, seed, seconds) for seed in range(seeds)]
        ratios = {
            at: [hypervolume(latest(history, at), frame) / whole for _, history, *_ in runs] for at in TIMES_S
        }
        shown = [hypervolume(values, frame) / whole for values, *_ in runs]
        took = [total for _, _, total, *_ in runs]
        rows.append([
            ", ".join(names), *(f"{median(ratios[at]):.4f}" for at in TIMES_S), f"{min(ratios[TIMES_S[-1]]):.4f}",
            f"{median(shown):.4f}", f"{median(took):.1f}",
        ])  # fmt: skip
    head = ["objectives", *(f"{at:g} s" for at in TIMES_S), "least of seeds", "front shown", "process s"]
    return [
        "## Fronts by pymoo",
        "",
        f"{mission.stem}: hypervolume of {algorithm}'s archive over that of the exact front, by seconds since the",
        f"process began; median of {seeds} seeds. *front shown*: without points within 0.1 % of each other.",
        "",
        *table(head, rows),
    ]


def latest(history: Any, at_s: float) -> Any:
    """The archive as it stood."""
    return next((values for when, values in reversed(history) if when <= at_s), [])


def main() -> None:
    """Measure and print; or, with --cold, be one of the processes."""
    parser = argparse.ArgumentParser(description="Measure pymoo's fronts against the exact ones.")
    parser.add_argument("--mission", type=Path, default=REEF)
    parser.add_argument("--algorithm", default="nsga2")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seeds", type=int, default=5)
    for name in ("--cold", "--objectives", "--seed"):
        parser.add_argument(name, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.cold:
        names = asked.objectives.split(",")
        cold(asked.mission, names, asked.algorithm, int(asked.seed), asked.seconds, Path(asked.cold))
        return
    lines = pareto_table(asked.mission, algorithm=asked.algorithm, seeds=asked.seeds, seconds=asked.seconds)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
