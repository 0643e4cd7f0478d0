"""A comparison as text, as one HTML page, and as a CSV."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from uwopt.documents.files import csv_text
from uwopt.report.compare.rows import ComparedRow, compared_figures, facts, requirement_rows, sentences
from uwopt.report.page.html_file import rendered
from uwopt.report.text import formats
from uwopt.report.text.cells import defused
from uwopt.report.text.layout import Block, Grid, Line, Text, block, columns, sentence
from uwopt.report.text.looked_at import in_page, wording_of
from uwopt.results.comparison import Comparison

PAGE, TABLE = "compare.html", "compare.csv"


def comparison_blocks(comparison: Comparison) -> list[Block]:
    """Systems, requirements, what it means, figures."""
    names = [formats.one_line(one.name, 40) for one in comparison.systems]
    scenes = len(comparison.systems[0].design.scenes)
    made = [block("Systems", [grid(names, facts(comparison))])]
    rows = [*requirement_rows(comparison)]
    made += by_scene("Requirements", names, rows, scenes)
    lines: list[Line] = [sentence(text) for text in sentences(comparison)]
    made.append(block("In words", lines))
    return made + by_scene("Figures at the nominal altitude", names, [*compared_figures(comparison)], scenes)


def by_scene(title: str, names: Sequence[str], rows: Sequence[ComparedRow], scenes: int) -> list[Block]:
    """A table a scene."""
    told = list(dict.fromkeys(row.scene for row in rows))
    return [
        block(
            f"{title}: {formats.one_line(scene, 60)}" if scenes > 1 else title,
            [grid(names, [row for row in rows if row.scene == scene])],
        )
        for scene in told
    ]


def grid(names: Sequence[str], lines: Iterable[ComparedRow]) -> Grid:
    """Rows as a table, what is missed in red; without a column of what is asked where nothing is."""
    rows = [*lines]
    asks = any(row.asked for row in rows)
    table = columns(("", "left"), *([("asked", "left")] if asks else []), *((name, "left") for name in names))
    for row in rows:
        cells = [Text(mark(cell.text, cell.met), "" if cell.met in (None, True) else "red") for cell in row.cells]
        table.add_row(Text(row.name), *([Text(row.asked)] if asks else []), *cells)
    return table


def mark(text: str, met: bool | None) -> str:
    """A value, and that it is not what is asked, for whom colours say nothing."""
    return f"{text} (missed)" if met is False and not text.endswith("missed") else text


def comparison_html(comparison: Comparison) -> str:
    """The comparison as a page."""
    first = comparison.systems[0].result
    name = formats.one_line(first.mission.get("name") or "Mission", 120)
    page = rendered(
        "sheet.html", (), {"figures": {}}, title="Comparison", name=name, version=first.uwopt_version,
        blocks=comparison_blocks(comparison),
        lead=" | ".join(formats.one_line(one.name, 60) for one in comparison.systems),
        said="Each system evaluated by the same rules; worst over the altitudes. What is missed stands in red.",
        foot="comparison",
    )  # fmt: skip
    return in_page(page, wording_of(first))


def comparison_csv(comparison: Comparison) -> str:
    """The comparison as CSV: a row a line, of each system the value and whether it is met."""
    heads = [head for one in comparison.systems for head in (one.name, f"{one.name}: met")]
    made: list[tuple[Any, ...]] = [("table", "scene", "key", "what", "asked", "unit", *heads)]
    tables = {"system": facts, "requirement": requirement_rows, "figure": compared_figures}
    for table, rows in tables.items():
        for row in rows(comparison):
            values = [
                value
                for cell in row.cells
                for value in (cell.text if cell.value is None else cell.value, cell.met)
            ]
            made.append((table, row.scene, row.key, row.name, row.asked, row.unit, *values))
    return csv_text(map(defused, row) for row in made)
