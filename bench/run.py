"""Measure uwopt and print tables; with --write also into bench/results.md.

    python bench/run.py [--write] [--quick] [--note TEXT]

Numbers are medians. They hold for the machine and the load they were measured under; where two things are
compared, the ratio is of the same run. No test depends on them.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from statistics import median
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import uwopt  # noqa: E402
from uwopt.bench.machine import processor  # noqa: E402

PROBLEMS = ROOT / "problems"
REEF = PROBLEMS / "reef-mosaic.yaml"
MISSIONS = sorted(p for p in PROBLEMS.glob("*.yaml") if not p.stem.endswith(".system"))
LIBRARIES = ("numpy", "scipy", "casadi", "nlopt", "pydantic", "jerlov")
Row = Sequence[str]


def process_s(*arguments: str) -> float:
    """Duration of one cold process of the command line."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "uwopt", *arguments],
        check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment, cwd=ROOT,
    )  # fmt: skip
    return time.perf_counter() - start


def command_table(repeats: int) -> list[str]:
    """Cold processes, and the most memory that one of them took."""
    rows = []
    for arguments in (["--help"], ["solve", "problems/reef-mosaic.yaml"]):
        process_s(*arguments)  # the first run may compile bytecode
        seconds = [process_s(*arguments) for _ in range(repeats)]
        rows.append([f"`uwopt {' '.join(arguments)}`", f"{median(seconds):.2f}", spread(seconds)])
    # Linux counts in KiB, macOS in bytes
    unit = 2**20 if sys.platform == "darwin" else 2**10
    memory_mib = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / unit
    return [
        "## Commands, cold process",
        "",
        *table(["command", "median s", "from - to"], rows),
        "",
        f"Most memory of any of these processes: {memory_mib:.0f} MiB.",
    ]


def open_reef(folder: Path) -> Path:
    """The reef mission with no choice of makers: every part of the catalogue may be taken."""
    text = REEF.read_text(encoding="utf-8").replace(
        'cameras: ["flir", "allied*", "basler"]', "generic: never"
    )
    path = folder / "reef-mosaic, any maker.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def search_table(repeats: int) -> list[str]:
    """Search over the built-in catalogue in process, by mission and physics."""
    rows, slower = [], []
    with tempfile.TemporaryDirectory() as folder:
        for path in [*MISSIONS, open_reef(Path(folder))]:
            seconds = {}
            for physics in ("paper", "full"):
                results = [uwopt.solve(path, physics=physics) for _ in range(repeats)]
                rows.append(search_row(path.stem, physics, results))
                seconds[physics] = median(r.timing_s["search"] for r in results)
            slower.append(seconds["full"] / seconds["paper"])
    return [
        "## Search, in process",
        "",
        "*search*: tables, bounds and proof over the parts that the mission allows (parts that are sold, unless it",
        "allows parts to be made). *to be made*: the further search with them, where it is only a fallback.",
        "*whole call*: also evaluation, robustness and a second opinion. *loaded* counts all combinations of the",
        f"catalogue that the certificate accounts for. Medians of {repeats}.",
        "",
        *table(
            ["mission", "physics", "search s", "to be made s", "whole call s", "loaded", "loaded / search s"],
            rows,
        ),
        "",
        f"Physics full against paper, same run: search {median(slower):.1f} times as long (median of missions).",
    ]


def search_row(name: str, physics: str, results: Sequence[Any]) -> Row:
    """One mission in one physics; medians over the runs."""

    def middle(key: str) -> float | None:
        values = [r.timing_s[key] for r in results if key in r.timing_s]
        return median(values) if values else None

    search_s, generic_s = middle("search") or 0.0, middle("search_generic")
    loaded = results[0].certificate.loaded
    return [
        name, physics, f"{search_s:.2f}", "-" if generic_s is None else f"{generic_s:.2f}",
        f"{middle('total'):.2f}", f"{loaded:.2e}", f"{loaded / search_s:.1e}",
    ]  # fmt: skip


def throughput_table(repeats: int) -> list[str]:
    """The forward model on designs of the catalogue."""
    from throughput import CHUNK, N_LAMPS, measure

    rows, n_designs = [], 0
    for physics in ("paper", "full"):
        found = measure(str(REEF), physics, repeats=repeats)
        one, two = found.designs_per_s[1], found.designs_per_s[2]
        n_designs = found.n_designs
        rows.append(
            [
                physics,
                f"{one / 1e6:.2f}",
                f"{two / 1e6:.2f}",
                f"{two / one:.2f}",
                f"{found.integrals_per_s:,.0f}",
            ]
        )
    return [
        "## Forward model",
        "",
        f"{n_designs} designs of the catalogue with random settings, {N_LAMPS} lamps, in chunks of {CHUNK}; figures",
        "of all requirements at every altitude. What depends on hardware alone (the integral of the lamps' light",
        "over the image) is a table by then; how many of those integrals are worked out a second stands beside.",
        "",
        *table(
            ["physics", "10⁶ designs/s, 1 thread", "2 threads", "2 against 1", "integrals/s, 1 thread"],
            rows,
        ),
    ]


def physics_table(repeats: int) -> list[str]:
    """Physics `full` and `auto` over the same batches of designs."""
    from physics import N_DESIGNS, SCENES, compare

    rows: list[Row] = []
    for name, mission, tolerance in SCENES:
        c = compare(name, mission, tolerance=tolerance, repeats=repeats)
        rows.append(
            [
                name, f"{tolerance:g}", ", ".join(c.kept) or "nothing", f"{c.full_s:.2f}", f"{c.auto_s:.2f}",
                f"{c.full_s / c.auto_s:.2f}", f"{c.designs_per_s / 1e6:.2f}",
            ]
        )  # fmt: skip
    return [
        "## Physics `full` and `auto` in batches",
        "",
        f"{N_DESIGNS} designs drawn from the catalogue, 2 lamps, hardware integrals and figures together; both physics",
        "in turn in one run. Last column: figures of all requirements in `full` once hardware is tabulated.",
        "",
        *table(
            ["scene", "tolerance", "kept by auto", "full s", "auto s", "full / auto", "10⁶ designs/s, full"],
            rows,
        ),
    ]


def audit_table(count: int) -> list[str]:
    """How long an audit takes."""
    result = uwopt.solve(REEF, audit=count)
    seconds, report = result.timing_s["audit"], result.audit or {}
    verdict = "passed" if report.get("passed") else "FAILED"
    return [
        "## Audit",
        "",
        f"`uwopt solve problems/reef-mosaic.yaml --audit {count}`: {report.get('tried')} discarded combinations tried,",
        f"{seconds:.1f} s in one run ({1e3 * seconds / count:.0f} ms each), {verdict}.",
    ]


def table(head: Row, rows: Sequence[Row]) -> list[str]:
    """A Markdown table."""
    return [f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *rows)]


def spread(seconds: Sequence[float]) -> str:
    """Shortest and longest."""
    return f"{min(seconds):.2f} - {max(seconds):.2f}"


def heading(note: str, repeats: int, command: str = "python bench/run.py --write") -> list[str]:
    """Where and when this was measured."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in LIBRARIES)
    load = " ".join(f"{value:.1f}" for value in os.getloadavg()) if hasattr(os, "getloadavg") else "unknown"
    return [
        "# Measured",
        "",
        f"Written by `{command}`.",
        "",
        f"- {datetime.now(UTC):%Y-%m-%d %H:%M} UTC, uwopt {uwopt.__version__}",
        f"- {platform.system()} {platform.machine()}, {processor()}, {os.cpu_count()} cores",
        f"- load average before the run: {load}",
        f"- Python {platform.python_version()}, {versions}",
        f"- medians of {repeats} runs unless said otherwise",
        *([f"- {note}"] if note else []),
    ]


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description="Measure uwopt.")
    parser.add_argument("--write", action="store_true", help="write bench/results.md")
    parser.add_argument("--quick", action="store_true", help="one run each and a short audit")
    parser.add_argument("--note", default="", help="a line on the circumstances")
    asked = parser.parse_args()
    repeats = 1 if asked.quick else 5
    sections = [heading(asked.note, repeats)]
    print("\n".join(sections[0]), flush=True)
    for measure in (
        lambda: command_table(repeats),
        lambda: throughput_table(repeats),
        lambda: physics_table(repeats),
        lambda: search_table(min(repeats, 3)),
        lambda: audit_table(40 if asked.quick else 1000),
    ):
        sections.append(measure())
        print("\n" + "\n".join(sections[-1]), flush=True)
    if asked.write:
        text = "\n\n".join("\n".join(section) for section in sections) + "\n"
        (ROOT / "bench" / "results.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
