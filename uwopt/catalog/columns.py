"""Columns of tables: what may stand in a cell, those of parts made from the fields of their records.

Parsing gives typed cells; a cell that is wrong gives a sentence that says what is allowed.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from uwopt.catalog.money import currency_fault
from uwopt.catalog.parts.cell import ANY, LARGEST, SMALLEST, Field, Form, Range, fields_of
from uwopt.catalog.parts.kinds import PARTS, stated_fields
from uwopt.catalog.parts.part import OPENING, Kind, Part, PartKind
from uwopt.documents.faults import without_comma

Cell = float | str | bool | tuple[str, ...] | None


@dataclass(frozen=True, slots=True)
class Column:
    """Name, form and allowed range of one column."""

    name: str
    form: Form = "number"
    within: Range = ANY
    whole: bool = False
    choices: tuple[str, ...] = ()
    meaning: str = ""
    span: tuple[float, float] = (SMALLEST, LARGEST)  # outside, a part's number has a wrong unit

    def allowed(self) -> str:
        """What may stand here, in words."""
        if self.form in ("choice", "list") and self.choices:
            joined = ", ".join(self.choices)
            return f"one of {joined}" if self.form == "choice" else f"any of {joined}, separated by |"
        if self.form == "flag":
            return "yes or no"
        if self.form != "number":
            return "text"
        return f"{'a whole number' if self.whole else 'a number'} {self.within.words()}".strip()


def column_of(field: Field) -> Column:
    """The column of a part's field."""
    cell = field.cell
    whole = field.bare_type is int
    return Column(field.name, field.form, cell.within, whole, field.choices, cell.doc, cell.span)


def _columns_of(kind: PartKind) -> dict[str, Column]:
    """Identity first, then what is the kind's own, then price, mass and sources."""
    told = [field for field in stated_fields(kind) if field.cell.in_files]
    shared = {field.name for field in fields_of(Part)}

    def group(field: Field) -> int:
        return 0 if field.name in OPENING else 2 if field.name in shared else 1

    return {field.name: column_of(field) for field in sorted(told, key=group)}


COLUMNS: dict[Kind, dict[str, Column]] = {kind: _columns_of(part) for kind, part in PARTS.items()}

#: Without these a row says nothing about a part.
REQUIRED: dict[Kind, tuple[str, ...]] = {
    kind: tuple(field.name for field in stated_fields(part) if field.cell.needed)
    for kind, part in PARTS.items()
}

#: Columns whose mere presence tells the kind of part; a kind made of pieces, which has theirs too, stands first.
TELLTALE: dict[str, Kind] = {
    field.name: kind
    for kind, part in sorted(PARTS.items(), key=lambda item: not item[1].pieces)
    for field in fields_of(part.record)
    if field.cell.tells
}

_FLAGS = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}


class CellError(ValueError):
    """A cell is wrong; the text says what it holds and what is allowed."""


def parse_cell(column: Column, text: str) -> Cell:
    """The typed value of a cell; an empty cell is unknown (None)."""
    if text == "":
        return None
    if column.form == "number":
        return parse_number(column, text)
    if column.form == "flag":
        if text.casefold() not in _FLAGS:
            raise CellError(f"{column.name} = {text!r} is not {column.allowed()}")
        return _FLAGS[text.casefold()]
    if column.form == "choice":
        if text not in column.choices:
            raise CellError(f"{column.name} = {text!r} is not {column.allowed()}")
        return text
    if column.form == "list":
        items = tuple(item.strip() for item in text.split("|") if item.strip())
        wrong = [item for item in items if column.choices and item not in column.choices]
        if wrong:
            raise CellError(f"{column.name} = {text!r} is not {column.allowed()}")
        return items
    if column.name == "currency" and (fault := currency_fault(text)):
        raise CellError(fault)
    return text


def parse_number(column: Column, text: str) -> float:
    """A finite number within the column's range."""
    try:
        value = float(text)
    except ValueError:
        raise CellError(f"{column.name} = {text!r} {_why_no_number(text)}") from None
    if not math.isfinite(value):
        raise CellError(
            f"{column.name} = {text!r} is not a finite number; leave the cell empty if it is unknown"
        )
    if not column.within.holds(value) or (column.whole and value != int(value)):
        raise CellError(f"{column.name} = {text} must be {column.allowed()}")
    return value


def _why_no_number(text: str) -> str:
    if mend := without_comma(text):
        return f"has a comma; {mend}"
    if re.match(r"^[+-]?[\d.]+\s*[a-zA-Zµ°%\"]", text):
        return "is not a number; the unit belongs in the header"
    return "is not a number"
