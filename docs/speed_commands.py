"""Whole commands as cold processes, each beside the same command of an earlier version: a table of docs/speed.md.

Both versions run in turn with the same Python and libraries, so that their ratio is that of one run on one machine.
Each solves the missions that were shipped with it; one that the earlier version did not have has no ratio.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[1]
LONGEST_S = 300.0
OUT = "{out}"  # stands for a fresh folder
KEPT = (0, 3)  # exit status of an answer: also that nothing fits, or that it is not certain enough
TOWED = """\
name: Towed camera at 2.1 m/s, half a pixel of blur, all parts
practice: bare
scene: {water: II, seafloor: sand, depth_m: 200}
vehicle: {altitude_m: 3.0, altitude_tolerance_m: 0.5, speed_m_s: 2.1, light_baseline_m: 1.0, light_count: [1, 4]}
requirements: {overlap: 0.5, max_blur_px: 0.5, min_dof_m: 1.0, min_snr_db: 25, max_gsd_mm: 1.5, mean_level: 0.3}
limits: {depth_rating_m: 250}
catalog: {generic: allow}
objective: cost
"""
#: Which nothing meets: why, and what would help.
HARBOUR = """\
name: Harbour wall through 3 m of turbid water, on a small budget
practice: bare
scene: {target: wall, water: 9C, seafloor: 0.1, depth_m: 15}
vehicle: {distance_m: 3.0, distance_tolerance_m: 0.3, speed_m_s: 0.3, light_baseline_m: 0.5, light_count: [1, 4]}
requirements: {overlap: 0.5, max_blur_px: 1.0, min_dof_m: 0.5, min_snr_db: 30, max_gsd_mm: 2.0}
limits: {cost: 3000, power_w: 50}
catalog: {generic: allow}
objective: power
"""
OWN = {
    "towed.yaml": TOWED,
    "harbour.yaml": HARBOUR,
    "harbour-practice.yaml": HARBOUR.replace("practice: bare", "practice: recommended"),
}


@dataclass(frozen=True)
class Command:
    """Words after `uwopt`, and the seconds that it may take on two quiet cores; None: only told."""

    words: tuple[str, ...]
    goal_s: float | None = None

    def __str__(self) -> str:
        return "uwopt " + " ".join("DIR" if word == OUT else word for word in self.words)


def commands() -> list[Command]:
    """What a user waits for."""
    problems = sorted((ROOT / "problems").glob("*.yaml"))
    missions = [f"problems/{path.name}" for path in problems if not path.stem.endswith(".system")]
    jobs = [f"problems/jobs/{path.name}" for path in sorted((ROOT / "problems" / "jobs").glob("*.yaml"))]
    return [
        Command(("--help",), 0.4),
        *(Command(("solve", mission), 5.0) for mission in missions),
        Command(("solve", "problems/reef-mosaic.yaml", "--out", OUT), 5.0),
        Command(("pareto", "problems/reef-mosaic.yaml", "--out", OUT), 10.0),
        Command(("solve", "towed.yaml"), 5.0),
        Command(("solve", "harbour.yaml"), 10.0),
        Command(("solve", "harbour-practice.yaml"), 10.0),
        *(Command(("solve", job), 10.0 if "harbour-wall" in job else None) for job in jobs),
    ]


@dataclass(frozen=True)
class Run:
    """One cold process: seconds by the clock and of the processor; None where there is no answer."""

    elapsed_s: float | None
    processor_s: float | None
    status: int | None


def cold(tree: Path, command: Command) -> Run:
    """Run a command of the version that lies in a folder, which may keep its bytecode as an installed one does."""
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryDirectory() as out:
        words = [out if word == OUT else word for word in command.words]
        if any(word.startswith("problems/") and not (tree / word).exists() for word in words):
            return Run(None, None, None)
        before_s, start = children_s(), time.perf_counter()
        try:
            done = subprocess.run(
                [sys.executable, "-m", "uwopt", *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                env=environment, cwd=tree, timeout=LONGEST_S, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return Run(None, None, None)
        elapsed_s = time.perf_counter() - start
    if done.returncode not in KEPT:
        return Run(None, None, done.returncode)
    return Run(elapsed_s, children_s() - before_s, done.returncode)


def children_s() -> float:
    """Processor time of all processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@contextmanager
def version(revision: str) -> Iterator[Path]:
    """The files of a revision in a folder of their own, with the missions of this page."""
    with tempfile.TemporaryDirectory() as folder:
        tree, packed = Path(folder) / "tree", Path(folder) / "tree.tar"
        subprocess.run(["git", "archive", "-o", str(packed), revision], cwd=ROOT, check=True)
        with tarfile.open(packed) as archive:
            archive.extractall(tree, filter="data")
        yield tree


def measured(before: str | None, repeats: int) -> list[str]:
    """The table of all commands, and what of the goals is met."""
    with version("HEAD") as now:
        if before is None:
            return rows_of(now, None, None, repeats)
        with version(before) as then:
            return rows_of(now, then, before, repeats)


@dataclass(frozen=True)
class Timed:
    """A command with the runs of two versions."""

    command: Command
    now: Sequence[Run]
    then: Sequence[Run]

    @property
    def seconds(self) -> float | None:
        """Median by the clock."""
        return middle(self.now)

    @property
    def is_shipped(self) -> bool:
        """Whether it solves one of the missions of problems/, with an answer."""
        words = self.command.words
        return words[0] == "solve" and len(words) == 2 and Path(words[1]).parent.name == "problems"

    def cells(self) -> list[str]:
        """The row of the table."""
        seconds, goal, was = self.seconds, self.command.goal_s, middle(self.then)
        missed = goal is not None and (seconds is None or seconds > goal)
        wanted = "" if goal is None else f"**{goal:g}**" if missed else f"{goal:g}"
        times = "" if seconds is None or was is None else f"{was / seconds:.2g}"
        of_processor = cell(middle(self.now, "processor_s"))
        return [f"`{self.command}`", cell(seconds), of_processor, wanted, *([cell(was), times] if self.then else [])]


def rows_of(now: Path, then: Path | None, before: str | None, repeats: int) -> list[str]:
    """Run everything in turn and make the lines of the page."""
    for tree in filter(None, (now, then)):
        for name, text in OWN.items():
            own = text if tree is now else text.replace("practice: bare\n", "")
            (tree / name).write_text(own, encoding="utf-8")
        cold(tree, Command(("solve", "problems/reef-mosaic.yaml", "--quiet")))  # compiles the bytecode
    found = []
    for command in commands():
        runs = [[cold(tree, command) for tree in (now, then) if tree] for _ in range(repeats)]
        found.append(Timed(command, [run[0] for run in runs], [run[1] for run in runs] if then else []))
        print(" | ".join(found[-1].cells()), file=sys.stderr, flush=True)
    shipped = [one.seconds for one in found if one.is_shipped and one.seconds is not None]
    head = ["command", "s", "processor s", "goal s", *([f"at {before}, s", "times"] if before else [])]
    beside = f" The same command at {before} ran in turn with it; *times*: how often longer it took." if before else ""
    return [
        "## Whole commands, cold process",
        "",
        f"Seconds by the clock, medians of {repeats}; a goal that is missed is bold.{beside}",
        f"An empty cell: no such mission then, no answer, or more than {LONGEST_S:g} s.",
        "",
        *(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *(one.cells() for one in found))),
        "",
        f"`solve` over the {len(shipped)} missions of problems/: median {median(shipped):.1f} s (goal 2), "
        f"longest {max(shipped):.1f} s (goal 5).",
    ]


def middle(runs: Sequence[Run], of: str = "elapsed_s") -> float | None:
    """Median over the runs that have an answer."""
    values = [value for value in (getattr(run, of) for run in runs) if value is not None]
    return median(values) if values else None


def cell(seconds: float | None) -> str:
    """Seconds in words of a table."""
    return "" if seconds is None else f"{seconds:.2f}"


if __name__ == "__main__":
    print("\n".join(measured(sys.argv[1] if len(sys.argv) > 1 else None, 1)))
