"""How near pymoo's front comes to the exact one, from a cold start; and what the exact fronts cost.

    python bench/pareto.py [--seconds 10] [--seeds 5] [--mission FILE] [--algorithm nsga2] [--write]

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
SUNLIT = ("usgs-squid5",)  # no closed form: by pymoo alone unless asked
LAST_S = 0.4  # of a process: reading its archive back as designs, and writing it


def cold(mission: Path, names: Sequence[str], algorithm: str, seed: int, seconds: float, out: Path) -> None:
    """One run in this process; what it found goes to a file, with times since the process began."""
    began = started_s()
    from uwopt.api.common import prepared
    from uwopt.forward.assembly import build_problem, load_catalog, selected
    from uwopt.objectives.objective import Objective
    from uwopt.solvers.exact.search import Search
    from uwopt.solvers.population.pymoo_front import population_front

    wanted = prepared(mission, None, None)
    selection = selected(wanted, load_catalog(wanted), generic="never")
    objective = Objective(dict.fromkeys(names, 1.0))
    search = Search(build_problem(wanted, selection), objective, top=1)
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
    """The exact front's values (n, n_axes), all of them, less is better."""
    from uwopt.bench.fronts import exact_front

    return exact_front(mission, names).values


def exact_table(seconds_note: str = "") -> list[str]:
    """Time, size and gap of the exact front of every mission."""
    from run import table

    from uwopt.bench.fronts import LONGEST_S, exact_front
    from uwopt.errors import MissionError

    rows = []
    for path in sorted((ROOT / "problems").glob("*.yaml")):
        if path.name.endswith(".system.yaml") or path.stem in SUNLIT:
            continue
        for names in FRONTS:
            try:
                front = exact_front(path, names)
                kind = "sold"
                if front.complete and not len(front.values):
                    front, kind = exact_front(path, names, "allow"), "to be made too"
            except MissionError as fault:
                why = str(fault).partition(": objective: ")[2].partition(";")[0]
                rows.append([path.stem, names[-1], *["-"] * 6, why])
                continue
            curves = {(int(some.imager[a.design[i]]), int(some.light[a.design[i]]), int(some.count[a.design[i]]),
                       int(some.lighting[a.design[i]])) for some, a, i in front.designs}  # fmt: skip
            bound = front.hypervolume_bound
            rows.append([
                path.stem, names[-1], kind, f"{front.seconds:.1f}", str(len(front.values)), str(len(curves)),
                str(front.account["evaluated"]), f"{1 - front.hypervolume / bound:.1e}" if bound else "-",
                "complete" if front.complete else "stopped",
            ])  # fmt: skip
            print(rows[-1], file=sys.stderr, flush=True)
    head = ["mission", "power, cost and", "parts", "s", "points", "hardware", "evaluated", "gap", "status"]
    return [
        "## Exact fronts",
        "",
        "Search in process, tables included; *gap*: the share of the hypervolume that bounds leave open; *evaluated*:",
        f"combinations whose settings were solved; stopped after {LONGEST_S:g} s. {seconds_note}",
        f"Left out: {', '.join(SUNLIT)}, whose sunlit settings have no closed form.",
        "",
        *table(head, rows),
    ]


def pareto_table(
    mission: Path = REEF, *, algorithm: str = "nsga2", seeds: int = 5, seconds: float = 10.0
) -> list[str]:
    """Ratios by time, median of the seeds and the least."""
    from run import table

    from uwopt.bench.fronts import latest
    from uwopt.objectives.axes import Axes, Frame
    from uwopt.objectives.dominance import hypervolume

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


def main() -> None:
    """Measure and print; or, with --cold, be one of the processes."""
    parser = argparse.ArgumentParser(description="Measure pymoo's fronts against the exact ones.")
    parser.add_argument("--mission", type=Path, default=REEF)
    parser.add_argument("--algorithm", default="nsga2")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--note", default="", help="a line on the circumstances")
    parser.add_argument("--write", action="store_true", help="write bench/pareto.md")
    for name in ("--cold", "--objectives", "--seed"):
        parser.add_argument(name, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.cold:
        names = asked.objectives.split(",")
        cold(asked.mission, names, asked.algorithm, int(asked.seed), asked.seconds, Path(asked.cold))
        return
    from run import heading

    made = heading(asked.note, asked.seeds, "python bench/pareto.py --write")
    made += [
        "",
        *pareto_table(asked.mission, algorithm=asked.algorithm, seeds=asked.seeds, seconds=asked.seconds),
    ]
    made += ["", *exact_table()]
    text = "\n".join(made) + "\n"
    print(text)
    if asked.write:
        (ROOT / "bench" / "pareto.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
