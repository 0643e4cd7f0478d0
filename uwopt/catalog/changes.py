"""What somebody has changed in the catalogue: a log, one cell a line, that is read like a file of own parts.

The built-in tables stay as they are. Played over them, cell by cell in its order, the log gives the catalogue that its
owner works with, and says of every cell since when and by which source it is so. One file holds both the changes
and their record, so that the two cannot part.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from uwopt.catalog.columns import COLUMNS, REQUIRED
from uwopt.catalog.parts.kinds import PARTS
from uwopt.catalog.parts.part import KINDS, Kind
from uwopt.catalog.tables import DATA_DIR, Row, Table, read_table
from uwopt.catalog.userparts import PartRow, typed_rows
from uwopt.documents.faults import plain_name
from uwopt.documents.files import csv_text
from uwopt.errors import CatalogError

COLUMNS_OF_LOG = ("date", "part", "id", "cell", "old", "new", "source")
HEAD = (
    "# Changes to the catalogue of uwopt, one cell a line, in their order; `uwopt catalog update` adds to them.\n"
    "# old: what stood there, empty for nothing known; new: empty where a cell was cleared. A part that the catalogue\n"
    "# does not have begins with its first line here. Name this file in a mission: `catalog: {files: [...]}`.\n"
)


@dataclass(frozen=True, slots=True)
class CellChange:
    """One cell of one part, before and after, when it was changed and by which source."""

    date: str
    part: str
    id: str
    cell: str
    old: str
    new: str
    source: str


def is_change_table(table: Table) -> bool:
    """Whether a CSV is a log of changes."""
    return table.header == COLUMNS_OF_LOG


def changes_of(table: Table) -> tuple[list[CellChange], list[str]]:
    """The changes of a log, and every fault of its lines."""
    faults = list(table.faults)
    changes = []
    for row in table.rows:
        change = CellChange(**{name: row.cells.get(name, "") for name in COLUMNS_OF_LOG})
        kind = kind_named(change.part)
        if kind is None:
            faults.append(f"{row.where()}: part = {change.part!r} is not one of {', '.join(KINDS)}.")
        elif not change.id or change.cell not in COLUMNS[kind] or change.cell in ("id", "part"):
            faults.append(f"{row.where()}: {change.cell!r} is no cell of a {kind} that can be changed.")
        else:
            changes.append(change)
    return changes, faults


def read_changes(path: Path) -> list[CellChange] | None:
    """The changes of a file; None where it is no log; raises once with every fault."""
    if path.suffix.casefold() != ".csv":
        return None
    table = read_table(path)
    if not is_change_table(table):
        return None
    changes, faults = changes_of(table)
    if faults:
        raise CatalogError(faults)
    return changes


def log_text(changes: Iterable[CellChange]) -> str:
    """The log as CSV."""
    return HEAD + csv_text([COLUMNS_OF_LOG, *([getattr(one, name) for name in COLUMNS_OF_LOG] for one in changes)])


def kind_named(name: str) -> Kind | None:
    """The kind of that name, if there is one."""
    return next((kind for kind in KINDS if kind == name), None)


@cache
def built_in_cells(origin: str = "published") -> dict[str, tuple[Kind, Row]]:
    """Rows of the built-in tables of products, or of classes "to be made", as written, by their plain names."""
    return {
        plain_name(row.cells["id"]): (kind, row)
        for kind, part in PARTS.items()
        for file, of in part.files.items()
        if of == origin
        for row in read_table(DATA_DIR / file).rows
    }


def rows_after_changes(changes: Sequence[CellChange], file: str) -> dict[str, tuple[Kind, Row]]:
    """Rows that a log changes or adds, as they stand after its last line, by their plain names."""
    rows: dict[str, tuple[Kind, Row]] = {}
    for line, change in enumerate(changes, start=1):
        key, kind = plain_name(change.id), kind_named(change.part)
        if kind is None:
            continue
        known_kind, row = rows.get(key) or built_in_cells().get(key) or (kind, Row(file, line, {"id": change.id}))
        rows[key] = known_kind, replace(row, file=file, cells=row.cells | {change.cell: change.new})
    return rows


def moved_on(changes: Iterable[CellChange]) -> list[str]:
    """Cells whose first change was made to something else than the built-in table holds today, in words."""
    first: dict[tuple[str, str], CellChange] = {}
    for change in changes:
        first.setdefault((plain_name(change.id), change.cell), change)
    return [
        f"{change.id}: {name} was {change.old or 'empty'} when it was changed, it is {now or 'empty'} now."
        for (key, name), change in first.items()
        if key in built_in_cells() and (now := built_in_cells()[key][1].cells.get(name, "")) != change.old
    ]


def checked_rows(rows: Iterable[tuple[Kind, Row]], base_dir: Path) -> tuple[list[PartRow], list[str]]:
    """Typed rows, and every fault: those of a cell, and what a part that the catalogue does not have must say."""
    typed: list[PartRow] = []
    faults: list[str] = []
    for kind, row in rows:
        told = Table(row.file, tuple(row.cells), (row,))
        found, wrong = typed_rows(told, kind, base_dir, built_in=True)
        typed += found
        faults += wrong
        if plain_name(row.cells["id"]) not in built_in_cells():
            needed = (*REQUIRED[kind], "source_url", *(("purpose",) if "purpose" in COLUMNS[kind] else ()))
            lacks = [name for name in needed if not row.cells.get(name)]
            faults += [f"{row.where()}: {name} is empty; a new {kind} needs it." for name in lacks]
    return typed, faults
