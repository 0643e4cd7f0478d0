"""The answers to a tender as makers sent them back: a workbook of its form, or a CSV of the same columns."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from uwopt.catalog.offers import FORM, KEYS, MakerAnswers
from uwopt.catalog.tables import parse_table, read_text
from uwopt.documents.workbooks import Sheet, read_workbook
from uwopt.errors import CatalogError

MAKER = re.compile(r"maker \d+")


def read_answers(path: Path) -> list[MakerAnswers]:
    """Every maker's column of every sheet; raises where there is none."""
    if path.suffix.casefold() == ".xlsx":
        found = [one for name, sheet in read_workbook(path).items() for one in of_sheet(path.name, name, sheet)]
    else:
        found = [*of_table(path)]
    if not found:
        raise CatalogError(
            f"{path}: holds no sheet of the form {FORM!r}; send back tender.xlsx filled in, or a CSV with "
            "part, candidate, key and a column maker 1."
        )
    return found


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
    if table.faults:
        raise CatalogError(list(table.faults))
    makers = [name for name in table.header if MAKER.fullmatch(name)]
    if not makers or not {"part", "candidate", "key"} <= set(table.header):
        raise CatalogError(f"{path}: has no columns part, candidate, key and maker 1; those of tender.xlsx are meant.")
    sheets = dict.fromkeys((row.cells.get("part", ""), row.cells.get("candidate", "")) for row in table.rows)
    for part, candidate in sheets:
        own = [row for row in table.rows if (row.cells.get("part"), row.cells.get("candidate")) == (part, candidate)]
        rows = [[row.cells.get("key", ""), *(row.cells.get(maker, "") for maker in makers)] for row in own]
        yield from columns_of(f"{path.name}, {part}", part, candidate, ["key", *makers], rows)
