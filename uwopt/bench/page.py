"""The report of a benchmark: one HTML file, CSV tables and JSON."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from uwopt.bench.charts import charts
from uwopt.bench.run import MODULES, Bench
from uwopt.bench.suite import COLUMNS, BenchTable, Suite
from uwopt.documents.files import csv_text
from uwopt.report.page.html_file import compact_json, gzip_text, rendered
from uwopt.report.text import formats
from uwopt.report.text.cells import defused
from uwopt.report.text.layout import Block, Grid, Text, block, columns, sentence
from uwopt.report.write import check_folder, made_folder, write_files

PAGE, DATA = "bench.html", "bench.json"
MOST_COLUMNS = 8  # of a table in the terminal
PAGE_HAS = "The page that --out DIR writes tells what was done, what the columns mean, and has the charts."


def write_bench(bench: Bench, folder: str | Path) -> list[Path]:
    """Write bench.html, bench.json and a CSV for every suite into a folder, made if need be."""
    texts = {f"{suite.name}.csv": suite_csv(bench, suite) for suite in bench.suites}
    texts[DATA] = json.dumps(bench.as_dict(), indent=1, allow_nan=False) + "\n"
    texts[PAGE] = bench_html(bench)
    target = made_folder(check_folder(folder))
    written = write_files(target, texts)
    for name in MODULES:  # those of an earlier run say nothing of this one
        if f"{name}.csv" not in texts:
            (target / f"{name}.csv").unlink(missing_ok=True)
    return written


def suite_csv(bench: Bench, suite: Suite) -> str:
    """Rows of one suite."""
    return csv_text([COLUMNS, *([defused(row.as_dict()[name]) for name in COLUMNS] for row in bench.of(suite))])


def suite_tables(bench: Bench, suite: Suite) -> list[BenchTable]:
    """The summaries of one suite, of what has been measured of it."""
    rows = bench.of(suite)
    return list(suite.tables(rows)) if rows else []


def table_grid(table: BenchTable) -> Grid:
    """A table as the reports lay them out; columns that hold numbers stand right."""
    sides = [
        "left" if n == 0 or not is_numeric([row[n] for row in table.rows]) else "right"
        for n in range(len(table.head))
    ]
    grid = columns(*zip(table.head, sides, strict=True))
    for row in table.rows:
        grid.add_row(*(Text(formats.one_line(cell, 200)) for cell in row))
    return grid


def terse(table: BenchTable) -> BenchTable:
    """The same with shorter cells, for a terminal's width."""

    def short(cell: str) -> str:
        return cell.replace("more than ", ">").replace("Gauss-Legendre", "Gauss")

    return replace(
        table, head=[short(name) for name in table.head], rows=[[*map(short, row)] for row in table.rows]
    )


def is_numeric(cells: list[str]) -> bool:
    """Whether most cells begin with a digit or a sign."""
    return sum(cell[:1] in "0123456789-+<>~" for cell in cells if cell) * 2 > len([c for c in cells if c])


def bench_blocks(bench: Bench) -> list[Block]:
    """What the terminal shows."""
    facts = machine_facts(bench)
    told = "; ".join(f"{name} {value}" for name, value in facts.items())
    made = [block("Benchmark", [sentence(told), sentence(PAGE_HAS, "dim")])]
    for suite in bench.suites:
        lines: list[Any] = []
        if suite.name in bench.faults:
            lines.append(sentence(f"failed: {bench.faults[suite.name]}", "red"))
        for table in suite_tables(bench, suite):
            lines += [Text("")] if lines else []
            if len(table.head) > MOST_COLUMNS:
                lines.append(sentence(f"{table.title}: {len(table.head)} columns, on the page"))
            elif table.rows:
                lines += [sentence(table.title), table_grid(terse(table))]
            else:
                lines.append(sentence(f"{table.title}: nothing to show"))
        if not lines:
            lines.append(sentence("nothing was measured"))
        made.append(block(f"{suite.title} ({bench.seconds[suite.name]:.0f} s)", lines))
    return made


def machine_facts(bench: Bench) -> dict[str, str]:
    """Where and how it was measured."""
    at = bench.machine
    load = at["load_before"]
    return {
        "measured": at["measured"]
        + (", quick" if bench.quick else "")
        + (", interrupted" if bench.interrupted else ""),
        "machine": f"{at['system']}, {at['processor']}, {at['cores']} cores",
        "load before": "unknown" if load is None else " ".join(f"{value:g}" for value in load),
        "seed": str(bench.seed),
        "missions": ", ".join(Path(name).stem for name in bench.missions)
        or "the one that `uwopt init` writes",
        **{name: str(version) for name, version in at["versions"].items()},
    }


def bench_html(bench: Bench) -> str:
    """The page."""
    figures: dict[str, Any] = {}
    sections = []
    for suite in bench.suites:
        pictures = charts(suite, bench.of(suite))
        for picture in pictures:
            figures[picture["id"]] = picture.pop("figure")
        sections.append({
            "id": suite.name, "title": suite.title, "text": suite.text, "pictures": pictures,
            "took": f"{len(bench.of(suite))} measurements in {bench.seconds[suite.name]:.0f} s",
            "fault": formats.one_line(bench.faults.get(suite.name, "")),
            "tables": [
                {"title": table.title, "text": table.text, "grid": table_grid(table)}
                for table in suite_tables(bench, suite)
            ],
        })  # fmt: skip
    facts = machine_facts(bench)
    return rendered(
        "bench.html", ("page.js",), {"figures": figures, "front": None}, name="Error against run time",
        title="Benchmark",
        version=facts["uwopt"], facts=facts, sections=sections, interrupted=bench.interrupted, quick=bench.quick,
        raw=gzip_text(compact_json(bench.as_dict())), raw_name=DATA,
    )  # fmt: skip
