"""Run `uwopt bench` on the missions of `problems/` and write what its page says as docs/bench.md.

    python docs/make_bench.py [--quick] [--seconds S] [--out DIR] [--note TEXT]

With --out also bench.html, bench.json and the CSV files. No test depends on the numbers.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from uwopt.bench.page import machine_facts, suite_tables, write_bench  # noqa: E402
from uwopt.bench.run import Bench, mission_files, run  # noqa: E402
from uwopt.bench.suite import BenchTable  # noqa: E402


def markdown(bench: Bench, note: str) -> str:
    """The tables of all suites."""
    lines = [
        "# Error against run time",
        "",
        "Written by `python docs/make_bench.py`, as `uwopt bench problems` measures it.",
        "",
    ]
    facts = machine_facts(bench)
    versions = ", ".join(f"{name} {version}" for name, version in bench.machine["versions"].items())
    lines += [
        f"- {facts['measured']}, {facts['machine']}, load before {facts['load before']}",
        f"- {versions}",
    ]
    lines += [f"- seed {facts['seed']}", *([f"- {note}"] if note else []), ""]
    for suite in bench.suites:
        lines += [f"## {suite.title}", "", suite.text, ""]
        if suite.name in bench.faults:
            lines += [f"Failed: {bench.faults[suite.name]}", ""]
        for table in suite_tables(bench, suite):
            lines += [f"### {table.title}", "", *([table.text, ""] if table.text else []), *cells(table), ""]
    return "\n".join(lines).rstrip() + "\n"


def cells(table: BenchTable) -> list[str]:
    """A table in Markdown."""

    def row(texts: Any) -> str:
        return "| " + " | ".join(str(text).replace("|", "\\|") for text in texts) + " |"

    return [row(table.head), row("---" for _ in table.head), *(row(one) for one in table.rows)]


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description="Measure error against run time.")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out")
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--note", default="")
    asked = parser.parse_args()

    def keep(bench: Bench) -> None:
        (ROOT / "docs" / "bench.md").write_text(markdown(bench, asked.note), encoding="utf-8")
        if asked.out:
            write_bench(bench, asked.out)

    run(
        quick=asked.quick, seconds=asked.seconds, missions=mission_files([str(ROOT / "problems")]), keep=keep,
        progress=lambda share, what: print(f"{100 * share:3.0f} % {what}", file=sys.stderr),
    )  # fmt: skip


if __name__ == "__main__":
    main()
