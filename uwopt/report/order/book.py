"""Workbooks: cells of text that can never be formulas, cells of formulas that we wrote, cells to fill in.

openpyxl (MIT licence, kept by its own team) writes the file; it is loaded only when a workbook is made.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from uwopt.report.text.cells import defused

MOST_CHARS = 32_000  # of a cell; a spreadsheet takes 32 767
HEAD_FILL, ENTRY_FILL = "FFDDEAF0", "FFFFF6D6"
MONEY, WHOLE, PERCENT = "#,##0.00", "0", "0.0%"


def new_book(title: str) -> Any:
    """An empty workbook."""
    from openpyxl import Workbook

    book = Workbook()
    book.remove(book.active)
    book.properties.title, book.properties.creator = title[:200], "uwopt"
    return book


def book_bytes(book: Any) -> bytes:
    """The workbook as a file holds it."""
    held = io.BytesIO()
    book.save(held)
    return held.getvalue()


def plain_text(value: object) -> Any:
    """Text of a cell: without control signs, defused, not longer than a spreadsheet takes; a number stays one."""
    if not isinstance(value, str):
        return defused(value)
    kept = "".join(c for c in value if c in "\n\t" or (ord(c) >= 32 and c not in "\ufffe\uffff"))
    return defused(kept)[:MOST_CHARS]


class Page:
    """One sheet that is filled from the top; every kind of cell has one way to be written."""

    def __init__(self, book: Any, name: str, widths: Sequence[float]):
        from openpyxl.utils import get_column_letter

        self.sheet = book.create_sheet(sheet_name(name, [sheet.title for sheet in book.worksheets]))
        for number, width in enumerate(widths, 1):
            self.sheet.column_dimensions[get_column_letter(number)].width = width
        self.sheet.page_setup.orientation, self.sheet.page_setup.fitToHeight = "landscape", 0
        self.sheet.sheet_properties.pageSetUpPr.fitToPage = True
        self.row = 1

    def text(
        self, column: int, value: object, *, bold: bool = False, wrap: bool = False, row: int | None = None
    ) -> Any:
        """Text of ours or of a file, or a number; never a formula."""
        from openpyxl.styles import Alignment, Font

        cell = self.sheet.cell(row or self.row, column)
        written = plain_text(value)
        if isinstance(written, str):
            if written:
                cell.value, cell.data_type = written, "s"  # in this order: a value such as #N/A has a type of its own
        else:
            cell.value = written
        cell.font = Font(bold=bold)
        cell.alignment = Alignment(wrap_text=wrap, vertical="top")
        return cell

    def number(self, column: int, value: float | None, form: str = "General") -> Any:
        """A number; empty where it is not known."""
        cell = self.text(column, value)
        cell.number_format = form
        return cell

    def formula(self, column: int, formula: str, form: str = "General", *, bold: bool = False) -> Any:
        """A formula that this program wrote; nothing of a file may stand in it."""
        cell = self.text(column, None, bold=bold)
        cell.value = formula
        cell.number_format = form
        return cell

    def entry(self, column: int, value: object = None, form: str = "General") -> Any:
        """A cell for a person to fill in, in its colour."""
        from openpyxl.styles import Border, PatternFill, Side

        cell = self.text(column, value, wrap=True)
        side = Side(style="thin", color="FFB9A65C")
        cell.fill, cell.border = PatternFill("solid", fgColor=ENTRY_FILL), Border(side, side, side, side)
        cell.number_format = form
        return cell

    def heads(self, names: Sequence[str]) -> int:
        """A row of heads; returns its number."""
        from openpyxl.styles import PatternFill

        for column, name in enumerate(names, 1):
            self.text(column, name, bold=True, wrap=True).fill = PatternFill("solid", fgColor=HEAD_FILL)
        self.row += 1
        return self.row - 1

    def line(self, *values: object, bold: bool = False, wrap: bool = False) -> None:
        """A row of texts and numbers."""
        for column, value in enumerate(values, 1):
            if value is not None:
                self.text(column, value, bold=bold, wrap=wrap)
        self.row += 1

    def freeze(self, row: int, column: int = 1) -> None:
        """What is above this row and left of this column stays in sight."""
        self.sheet.freeze_panes = self.sheet.cell(row, column)

    def check(self, cell: Any, kind: str, low: float, high: float, say: str) -> None:
        """Only a number between two ends may be typed into a cell."""
        from openpyxl.worksheet.datavalidation import DataValidation

        ends: dict[str, Any] = dict(operator="between", formula1=f"{low:g}", formula2=f"{high:g}")
        rule = DataValidation(type=kind, allow_blank=True, **ends)
        rule.error, rule.errorTitle, rule.showErrorMessage = say[:220], "Not taken", True
        self.sheet.add_data_validation(rule)
        rule.add(cell)

    def choice(self, cell: Any, words: Sequence[str]) -> None:
        """Only one of these words may be typed into a cell."""
        from openpyxl.worksheet.datavalidation import DataValidation

        rule = DataValidation(type="list", formula1=f'"{",".join(words)}"', allow_blank=True)
        rule.error, rule.errorTitle, rule.showErrorMessage = f"One of {', '.join(words)}"[:220], "Not taken", True
        self.sheet.add_data_validation(rule)
        rule.add(cell)


def sheet_name(name: str, taken: Sequence[str]) -> str:
    """A name that a spreadsheet allows for a sheet, and that no other sheet has."""
    plain = "".join(" " if c in "[]:*?/\\'" or ord(c) < 32 else c for c in name).strip()[:28] or "sheet"
    used = {one.casefold() for one in taken}
    number, made = 2, plain
    while made.casefold() in used:
        made, number = f"{plain[:26]} {number}", number + 1
    return made
