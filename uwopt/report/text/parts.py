"""The catalogue as aligned text: lists of parts, one part with its sources, the check of a file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from uwopt.catalog.catalogue import Exclusion
from uwopt.catalog.changes import CellChange
from uwopt.catalog.checkfile import FileReport
from uwopt.catalog.edition import AS_OF, EDITION
from uwopt.catalog.listing import FieldLine, PartLine
from uwopt.catalog.records import KINDS, Quantity
from uwopt.catalog.stale import StaleRow
from uwopt.report.text import formats
from uwopt.report.text.layout import Block, Line, Text, block, columns, sentence
from uwopt.units import counted, format_number

PLURALS = {
    "camera": "Cameras", "lens": "Lenses", "port": "Ports", "light": "Lights", "housing": "Housings",
    "complete": "Complete cameras",
}  # fmt: skip
LONG_FIELDS = {"source_url": "Where no other source is named", "correction": "Corrected", "note": "Note"}
LEGEND = "~ estimated from parts of its class"


def part_list_blocks(lines: Sequence[PartLine]) -> Iterator[Block | Text]:
    """Parts by kind: id, what it is, price; and why it is left out, if so."""
    doubtful = False
    for kind in KINDS:
        own = [line for line in lines if line.kind == kind]
        if not own:
            continue
        table = columns(("id", "left"), ("what it is", "left"), ("price", "right"))
        for line in own:
            doubtful |= price_is_estimated(line.price) or "~" in line.summary
            what = formats.one_line(f"{line.summary}{'; to be made' if line.generic else ''}")
            table.add_row(
                Text(formats.one_line(line.id, 60)), Text(what), Text(field_price_text(line.price, line.currency))
            )
            for reason in line.reasons:
                table.add_row(Text(""), Text("left out: " + formats.one_line(reason), "dim"), Text(""))
        yield block(f"{PLURALS[kind]} ({len(own)})", [table])
    if doubtful:
        yield sentence(LEGEND, "dim")


def stale_blocks(rows: Sequence[StaleRow], legend: str) -> Iterator[Block | Text]:
    """Parts with what is old or missing of them."""
    counted = any(row.uses for row in rows)
    table = columns(("part", "left"), *([("used", "right")] if counted else []), ("what to ask for", "left"))
    for row in rows:
        uses = [Text(str(row.uses))] if counted else []
        table.add_row(Text(formats.one_line(row.id, 60)), *uses, Text("; ".join(row.reasons)))
    yield block(f"Old or missing ({len(rows)}), catalogue {EDITION} of {AS_OF}", [table])
    if counted and legend:
        yield sentence(legend, "dim")


def change_blocks(changes: Sequence[CellChange], written_to: str) -> Iterator[Block | Text]:
    """Cells that an update changes, and where the record of it is."""
    table = columns(("part", "left"), ("cell", "left"), ("old", "left"), ("new", "left"))
    for change in changes:
        cells = (formats.one_line(text, 60) for text in (change.id, change.cell, change.old, change.new))
        table.add_row(*(Text(cell) for cell in cells))
    n_parts = len({change.id for change in changes})
    yield block(f"Changes ({len(changes)} cells of {n_parts} parts)", [table])
    yield sentence(f"Written to {written_to}; name it in catalog.files." if written_to else "Nothing written.", "dim")


def price_is_estimated(price: Quantity | None) -> bool:
    """Whether nobody quotes this price."""
    return price is not None and price.estimated


def field_price_text(price: Quantity | None, currency: str) -> str:
    """A price with its mark."""
    if price is None:
        return "unknown"
    return formats.price_text(price.low, price.high, currency) + (", no quote" if price_is_estimated(price) else "")


def part_blocks(part_id: str, lines: Sequence[FieldLine], exclusions: Sequence[Exclusion]) -> Iterator[Block]:
    """One part field by field, with status and source, and why it is not searched."""
    texts = {line.name: line.value for line in lines if line.name in LONG_FIELDS}
    table = columns(
        ("field", "left"), ("value", "left"), ("range", "left"), ("known", "left"), ("source", "left")
    )
    for line in lines:
        if line.name in ("id", *LONG_FIELDS):
            continue
        spread = line.low is not None and line.high is not None and line.low != line.high
        span = f"{format_number(line.low or 0.0)} to {format_number(line.high or 0.0)}" if spread else ""
        mark = "~" if line.status == "estimated" else ""
        source = "" if line.source == texts.get("source_url") else formats.one_line(line.source)
        table.add_row(
            Text(line.name),
            Text(mark + formats.one_line(line.value)),
            Text(span),
            Text(line.status),
            Text(source),
        )
    notes: list[Line] = [
        Text(f"{LONG_FIELDS[name]}: {formats.one_line(text, 2000)}") for name, text in texts.items()
    ]
    notes += [sentence(f"Not searched, {item.rule}: {item.reason}.", "yellow") for item in exclusions]
    legend = [sentence(LEGEND, "dim")] if any(line.status == "estimated" for line in lines) else []
    yield block(formats.one_line(part_id), [table, *legend, *notes])


def row_of(text: str) -> int:
    """The row of a file that a remark is of; 0 of the whole file's."""
    found = re.search(r" row (\d+)", text)
    return int(found[1]) if found else 0


def check_blocks(report: FileReport) -> Iterator[Block]:
    """What a file holds, every fault with its row, what will be estimated."""
    rows = counted(report.n_rows, "row")
    n_faults = len(report.faults)
    verdict = "in order" if report.ok else f"{counted(n_faults, 'fault')}"
    told = [*((fault, "red") for fault in report.faults), *((note, "") for note in report.notes)]
    lines: list[Line] = [sentence(text, style) for text, style in sorted(told, key=lambda one: row_of(one[0]))]
    yield block(f"{formats.one_line(report.path)}: {report.content}, {rows}: {verdict}", lines)
