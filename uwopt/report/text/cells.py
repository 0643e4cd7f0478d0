"""Cells of tables that a spreadsheet opens: no text of a file is ever taken for a formula."""

from __future__ import annotations

from typing import Any

from uwopt.documents.files import FORMULA_SIGNS
from uwopt.results.design import BillRow


def defused(value: Any) -> Any:
    """A cell that no spreadsheet takes for a formula: text that begins like one gets an apostrophe."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        return value
    text = str(value).encode("utf-8", "replace").decode("utf-8").replace("\0", "")
    return "'" + text if text.startswith(FORMULA_SIGNS) else text


def to_pay(row: BillRow, unit_price: float | None) -> float | None:
    """Price of the pieces of one row that are not owned yet; None when the price is unknown."""
    if not row.to_buy:
        return 0.0
    return None if unit_price is None else row.to_buy * unit_price
