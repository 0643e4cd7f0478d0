"""The answers to a tender as makers sent them back: a workbook of its form, or a CSV of the same columns."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from uwopt.catalog.changes import is_change_table
from uwopt.catalog.offers import BILL_SHEET, FORM, KEYS, MakerAnswers
from uwopt.catalog.tables import Table, parse_table, read_text
from uwopt.documents.workbooks import Sheet, read_workbook
from uwopt.errors import CatalogError

MAKER = re.compile(r"maker \d+")
COLUMNS = ("part", "candidate", "key")  # beside those of makers
A_BILL = "is the bill, not the tender"


def read_answers(path: Path) -> list[MakerAnswers]:
    """Every maker's column of every sheet; raises where there is none."""
    if path.is_dir():
        raise CatalogError(f"{path}: is a folder; name the tender.xlsx in it.")
    if path.suffix.casefold() != ".xlsx":
        return [*of_table(path)]
    sheets = read_workbook(path, FORM)
    found = [one for name, sheet in sheets.items() for one in of_sheet(path.name, name, sheet)]
    if not found:
        raise no_tender(path, A_BILL if BILL_SHEET in sheets else f"holds no sheet of the form {FORM!r}")
    return found


def no_tender(path: Path, why: str) -> CatalogError:
    """That a file holds no answers, and which one does."""
    return CatalogError(
        f"{path}: {why}; name tender.xlsx as makers filled it in (`uwopt tender result.json --out DIR` writes it), or "
        f"a CSV with the columns {', '.join(COLUMNS)} and maker 1."
    )


def of_sheet(file: str, name: str, sheet: Sheet) -> Iterator[MakerAnswers]:
    """The columns of one sheet; none of a sheet of another form."""
    if not sheet or not sheet[0] or sheet[0][0] != FORM:
        return
    told = {row[0]: row[1] for row in sheet[1 : 1 + len(KEYS)] if len(row) > 1}
    head = next((n for n, row in enumerate(sheet) if row and row[0] == "key"), None)
    if head is None or not set(KEYS[:2]) <= told.keys():
        raise CatalogError(f"{file}: sheet {name!r} has lost its head; copy the answers into a fresh tender.xlsx.")
    yield from columns_of(f"{file}, {name}", told["part"], told["candidate"], sheet[head], sheet[head + 1 :])


def columns_of(
    where: str, part: str, candidate: str, head: Sequence[str], rows: Sequence[Sequence[str]]
) -> Iterator[MakerAnswers]:
    """One maker a column."""
    for column, title in enumerate(head):
        if MAKER.fullmatch(title):
            texts = {row[0]: row[column] if len(row) > column else "" for row in rows if row and row[0]}
            yield MakerAnswers(f"{where}, {title}", part, candidate, texts)


def of_table(path: Path) -> Iterator[MakerAnswers]:
    """The same of a CSV: a row a key, its part and candidate beside it."""
    table = parse_table(read_text(path), path.name)
    makers = [name for name in table.header if MAKER.fullmatch(name)]
    if not makers or not set(COLUMNS) <= set(table.header):
        raise no_tender(path, told_instead(table))
    if table.faults:
        raise CatalogError(list(table.faults))
    sheets = dict.fromkeys((row.cells.get("part", ""), row.cells.get("candidate", "")) for row in table.rows)
    for part, candidate in sheets:
        own = [row for row in table.rows if (row.cells.get("part"), row.cells.get("candidate")) == (part, candidate)]
        rows = [[row.cells.get("key", ""), *(row.cells.get(maker, "") for maker in makers)] for row in own]
        yield from columns_of(f"{path.name}, {part}", part, candidate, ["key", *makers], rows)


def told_instead(table: Table) -> str:
    """What a table is that holds no answers, by its columns."""
    columns = set(table.header)
    if {"id", "to_pay"} <= columns:
        return A_BILL
    if is_change_table(table) or {"id", "manufacturer", "model"} <= columns:
        return "is a table of parts, which a mission names in catalog.files"
    if {"id", "price"} <= columns:
        return "is a price list, which a mission names in catalog.prices"
    return "holds no answers to a tender"
