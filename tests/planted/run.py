"""Plants each defect in a copy of the project and runs the test that must catch it.

    python tests/planted/run.py [--match WORD] [--jobs 2]

First the named tests run on the sound copy and must pass. A defect is caught when pytest ends with a failed test; one
that keeps a test file from being read counts as a fault of the patch. The command fails when a defect lives.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

if not __package__:  # run as a script
    sys.path.insert(0, str(Path(__file__).parents[1]))

from planted.defect import ROOT, Defect, all_defects

LONGEST_S = 1200.0  # a defect may make the search endless; no test of the suite takes nearly as long
PASSED, FAILED = 0, 1  # pytest's exit codes; the others are tests not found, not read or interrupted


@dataclass(frozen=True)
class Outcome:
    """What became of one defect: `fault` is empty when it was caught."""

    defect: Defect
    fault: str
    seconds: float


def project_files() -> list[str]:
    """Paths of the project as it lies here: what git tracks, and new files that it would not ignore."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        done = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"run.py: git cannot list the files of {ROOT}: {error}")
    return sorted({name for name in done.stdout.split("\0") if name and (ROOT / name).is_file()})


def copied(names: Iterable[str], folder: Path) -> Path:
    """The project copied to a folder; an error unless Python there imports the copy."""
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    asked = [sys.executable, "-c", "import uwopt; print(uwopt.__file__)"]
    done = subprocess.run(
        asked, cwd=folder.parent, env=environment(folder), capture_output=True, text=True, check=True
    )
    if not Path(done.stdout.strip()).is_relative_to(folder):
        sys.exit(f"run.py: the copy is not what is imported, but {done.stdout.strip()}")
    return folder


def environment(copy: Path) -> dict[str, str]:
    """Variables under which this process's children, and theirs, import the copy, compiled anew each time."""
    return {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}


def pytest_in(copy: Path, *arguments: str) -> tuple[int | None, str]:
    """Exit code (none when it took too long) and output of pytest in a copy."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--assert=plain", "--tb=line", *arguments]
    try:
        done = subprocess.run(
            command, cwd=copy, env=environment(copy), capture_output=True, text=True, timeout=LONGEST_S
        )
    except subprocess.TimeoutExpired:
        return None, ""
    return done.returncode, done.stdout + done.stderr


@contextmanager
def planted(defect: Defect, copy: Path) -> Iterator[None]:
    """The defect in the copy, taken back at the end."""
    file = copy / defect.file
    sound = file.read_text(encoding="utf-8")
    file.write_text(defect.applied(sound), encoding="utf-8")
    try:
        yield
    finally:
        file.write_text(sound, encoding="utf-8")


def tried(defect: Defect, copy: Path) -> Outcome:
    """Plants one defect and runs its tests, each of which must fail."""
    started = time.perf_counter()
    try:
        with planted(defect, copy):
            faults = [
                fault for node in defect.tests if (fault := fault_of(node, *pytest_in(copy, "-x", node)))
            ]
    except (OSError, ValueError) as error:
        faults = [str(error)]
    return Outcome(defect, "; ".join(faults), time.perf_counter() - started)


def fault_of(node: str, code: int | None, output: str) -> str:
    """Why a run of pytest does not show that a test catches a defect; empty when it does."""
    if code == FAILED:
        return ""
    if code == PASSED:
        return f"lives: {node} passes"
    if code is None:
        return f"{node} did not end within {LONGEST_S:.0f} s"
    return f"{node} was not run (pytest's exit code {code}): {last_line(output)}"


def last_line(output: str) -> str:
    """The last line of a program's output that says something."""
    return next((line for line in reversed(output.splitlines()) if line.strip()), "no output")


def sound_first(defects: Iterable[Defect], copy: Path, jobs: int) -> None:
    """Runs all named tests without a defect; ends the program when one fails."""
    nodes = sorted({node for defect in defects for node in defect.tests})
    spread = ("-n", str(jobs)) if jobs > 1 else ()
    code, output = pytest_in(copy, *spread, *nodes)
    if code != PASSED:
        sys.exit(f"{output}\nrun.py: the named tests must pass before a defect is planted (exit code {code})")


def row(outcome: Outcome) -> str:
    """One line of the table."""
    defect = outcome.defect
    caught = ", ".join(defect.tests) if not outcome.fault else f"FAILED: {outcome.fault}"
    return f"{defect.name:<44}  {defect.file:<38}  {outcome.seconds:6.1f} s  {caught}"


def run(defects: tuple[Defect, ...], jobs: int) -> int:
    """Plants all defects over `jobs` copies, prints the table, gives the number that live."""
    names = project_files()
    with tempfile.TemporaryDirectory(prefix="planted-") as scratch, ThreadPoolExecutor(jobs) as pool:
        free: SimpleQueue[Path] = SimpleQueue()
        copies = [copied(names, Path(scratch).resolve() / str(index)) for index in range(jobs)]
        sound_first(defects, copies[0], jobs)
        for copy in copies:
            free.put(copy)

        def in_free_copy(defect: Defect) -> Outcome:
            copy = free.get()
            try:
                return tried(defect, copy)
            finally:
                free.put(copy)

        lived = 0
        for outcome in pool.map(in_free_copy, defects):
            print(row(outcome), flush=True)
            lived += bool(outcome.fault)
    print(f"{len(defects) - lived} passed, {lived} failed")
    return lived


def main() -> None:
    """Reads the command line."""
    parser = argparse.ArgumentParser(description="Plant defects, and see that tests catch them.")
    parser.add_argument("--match", default="", help="only defects whose name or file contains this word")
    parser.add_argument("--jobs", type=int, default=2, help="copies to work in at the same time")
    asked = parser.parse_args()
    chosen = tuple(d for d in all_defects() if asked.match in d.name or asked.match in d.file)
    if not chosen:
        sys.exit(f"run.py: no defect's name or file contains {asked.match!r}")
    sys.exit(1 if run(chosen, max(1, asked.jobs)) else 0)


if __name__ == "__main__":
    main()
