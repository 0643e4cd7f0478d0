"""The bill of materials as a workbook: totals for any number of systems, second sources, what is not in the sum."""

from __future__ import annotations

from typing import Any

from uwopt.catalog.offers import BILL_SHEET
from uwopt.documents.faults import plain_name
from uwopt.report.order.book import MONEY, PERCENT, WHOLE, Page, book_bytes, new_book
from uwopt.report.order.other_parts import AS_GOOD, OtherSystem, instead_of, other_systems, why_this
from uwopt.report.text import formats, words
from uwopt.report.text.not_counted import NotCounted, not_counted
from uwopt.report.text.opening import how_far
from uwopt.report.text.tables import LIKELIEST_LEGEND
from uwopt.results.design import BillRow, Design
from uwopt.results.result import Result

SECOND, ABOUT = "Second sources", "About"
HEADS = (
    "line", "part", "maker", "model", "id", "in one system", "owned", "to order", "price each", "low", "high",
    "your quote each", "currency", "price is", "price of", "to pay", "to pay, low", "to pay, high", "lead time",
    "sold", "source", "where the price is from", "why this part", "what else would do in its place", "note",
)  # fmt: skip
WIDTHS = (5, 11, 18, 30, 30, 8, 7, 8, 12, 12, 12, 13, 9, 12, 12, 13, 13, 13, 14, 11, 34, 34, 40, 40, 40)
SYSTEMS = "$C$3"  # the one cell with the number of systems
MOST_SYSTEMS = 1000
SHARE = '0.00%;-0.00%;"as good"'  # of what is worse by nothing, in words
LEAD_UNKNOWN = "not known, ask"


def bom_book(result: Result) -> bytes:
    """The workbook of a result's bill; without a design it holds the heads only."""
    book = new_book(f"Order: {formats.one_line(result.mission.get('name') or 'mission', 100)}")
    best = result.best
    order_page(book, result, best)
    if best is not None:
        second_page(book, result, other_systems(result))
    about_page(book, result)
    return book_bytes(book)


def order_page(book: Any, result: Result, best: Design | None) -> None:
    """Lines to order with live totals, and below what is not in the sum."""
    page = Page(book, BILL_SHEET, WIDTHS)
    page.line(formats.one_line(result.mission.get("name") or "Mission", 120), bold=True)
    page.line(words.as_sentence(how_far(result)))
    page.text(1, "number of systems", bold=True)
    page.check(page.entry(3, 1, WHOLE), "whole", 1, MOST_SYSTEMS, f"a whole number from 1 to {MOST_SYSTEMS}")
    page.row += 1
    page.line("Cells in yellow are yours to fill in. A quote takes the place of the price beside it.")
    page.row += 1
    head = page.heads(HEADS)
    page.freeze(head + 1, 6)
    rows = best.bom if best is not None else []
    first = page.row
    for number, row in enumerate(rows, 1):
        bill_line(page, result, row, number)
    if best is None:
        return
    last = page.row - 1
    total_row = sum_lines(page, first, last, rows, best.totals.cost.currency)
    left_out(page, not_counted(result, best.as_set), total_row, best.totals.cost.currency)


def bill_line(page: Page, result: Result, row: BillRow, number: int) -> None:
    """One line of the bill; what is to pay is a formula."""
    n = page.row
    texts = (number, row.kind, row.manufacturer, row.model, row.id)
    for column, value in enumerate(texts, 1):
        page.text(column, value, wrap=column in (3, 4, 5))
    page.number(6, row.count, WHOLE)
    page.number(7, owned_pieces(result, row), WHOLE)
    page.formula(8, f"=MAX(0,F{n}*{SYSTEMS}-G{n})", WHOLE)
    for column, price in ((9, row.unit_price), (10, row.unit_price_low), (11, row.unit_price_high)):
        page.number(column, price, MONEY)
    page.check(page.entry(12, None, MONEY), "decimal", 0, 1e9, "a price of 0 or above, in the currency beside it")
    page.text(13, row.currency)
    page.text(14, formats.known_price(row).split(",")[0] if row.unit_price is not None else "unknown")
    page.text(15, row.price_date or "no date")
    for column, each in ((16, "I"), (17, "J"), (18, "K")):
        page.formula(column, f'=IF(L{n}<>"",H{n}*L{n},IF({each}{n}<>"",H{n}*{each}{n},""))', MONEY)
    page.entry(19, LEAD_UNKNOWN)
    page.text(20, row.availability or ("to be made" if row.generic else ""))
    tail = (row.source, row.price_basis, why_this(result, row), "; ".join(instead_of(result, row)), row.note)
    for column, value in enumerate(tail, 21):
        page.text(column, value, wrap=True)
    page.row += 1


def owned_pieces(result: Result, row: BillRow) -> int:
    """How many pieces of a line are there already: of lamps all that the mission names, for systems to come."""
    owned = (result.mission.get("catalog") or {}).get("owned") or []
    named = [item.get("quantity", 1) for item in owned if plain_name(str(item.get("id"))) == plain_name(row.id)]
    return max([row.owned, *(int(number) for number in named)]) if row.kind == "light" else row.owned


def free_for_one(row: BillRow) -> bool:
    """Whether the price of a part is less than its full price because pieces are owned, which holds for one system."""
    return row.kind != "light" and "owned" in row.price_basis


def sum_lines(page: Page, first: int, last: int, rows: list[BillRow], currency: str) -> int:
    """Totals below the lines, and what they lack; returns the row of the total."""
    page.row += 1
    total = page.row
    page.text(1, "sum of these lines", bold=True)
    page.text(13, currency, bold=True)
    for column in "PQR":
        page.formula(ord(column) - 64, f"=SUM({column}{first}:{column}{last})", MONEY, bold=True)
    page.row += 1
    page.text(1, "of it for one system, on average")
    page.text(13, currency)
    for column in "PQR":
        page.formula(ord(column) - 64, f"={column}{total}/{SYSTEMS}", MONEY)
    page.row += 1
    page.text(1, "pieces without a price")
    lacking = f'SUMPRODUCT((I{first}:I{last}="")*(L{first}:L{last}="")*H{first}:H{last})'
    page.formula(16, f"={lacking}", WHOLE)
    page.row += 1
    if any(free_for_one(row) for row in rows):
        page.text(1, "owned parts are free for one system only: give a quote for those of further systems")
        page.row += 1
    return total


def left_out(page: Page, items: list[NotCounted], total_row: int, currency: str) -> None:
    """Lines for what the sum does not hold, with what is known of each, and the total with them."""
    page.row += 1
    page.text(1, "Not in the sum above: fill in for the whole order", bold=True)
    page.row += 1
    titles = {2: "what", 4: "what is known of it", 8: "pieces", 9: "price each", 13: "currency", 16: "to pay"}
    page.heads([titles.get(column, "") for column in range(1, 17)])
    first = page.row
    for item in items:
        n = page.row
        page.text(2, item.what)
        page.text(4, item.known, wrap=True)
        page.sheet.merge_cells(start_row=n, start_column=4, end_row=n, end_column=7)
        page.sheet.row_dimensions[n].height = 15.0 * max(1, -(-len(item.known) // 70))
        page.check(page.entry(8, None, "General"), "decimal", 0, 1e6, "a number of pieces, 0 or above")
        page.check(page.entry(9, None, MONEY), "decimal", 0, 1e9, "a price of 0 or above")
        page.text(13, currency)
        page.formula(16, f'=IF(I{n}<>"",IF(H{n}<>"",H{n},1)*I{n},0)', MONEY)
        page.row += 1
    last, n = page.row - 1, page.row
    page.text(2, "tax and customs")
    page.text(4, "a share of everything above; whether a price holds tax is not recorded: ask", wrap=True)
    page.sheet.merge_cells(start_row=n, start_column=4, end_row=n, end_column=7)
    page.sheet.row_dimensions[n].height = 30.0
    page.check(page.entry(9, None, PERCENT), "decimal", 0, 1, "a share from 0 to 100 %")
    page.text(13, currency)
    page.formula(16, f"=I{n}*(P{total_row}+SUM(P{first}:P{last}))", MONEY)
    page.row += 1
    page.text(1, "total with what you filled in", bold=True)
    page.text(13, currency, bold=True)
    for column in "PQR":
        beside = f"SUM($P{first}:$P{last})"
        page.formula(ord(column) - 64, f"=({column}{total_row}+{beside})*(1+$I{n})", MONEY, bold=True)
    page.row += 1


def second_page(book: Any, result: Result, others: list[OtherSystem]) -> None:
    """Systems close to the best, by what they have instead; which are close enough is live."""
    page = Page(book, SECOND, (30, 14, 10, 12, 14, 44, 13, 13, 13, 11, 10, 30, 30, 34, 26, 34, 9))
    page.line("Systems that could be bought in place of the recommended one", bold=True)
    page.text(1, "close enough: at most this much worse")
    page.check(page.entry(2, 0.1, PERCENT), "decimal", 0, 10, "a share of 0 or above")
    page.row += 1
    if words.by_likeliest_values(result):
        page.text(1, LIKELIEST_LEGEND)
        page.row += 1
    page.row += 1
    kinds = [*(result.best.hardware.parts if result.best is not None else ())]
    head = page.heads(
        (f"system, by {result.objective.name}", "value", "unit", "worse by", "close enough", "has instead", "price",
         "low", "high", "power, W", "mass, kg", *kinds, "lamps")
    )  # fmt: skip
    page.freeze(head + 1, 2)
    if not others:
        page.line("none is known: solve with --top 5 or more")
    for other in others:
        n, design = page.row, other.design
        page.text(1, other.place, wrap=True)
        page.number(2, other.objective_value, "0.000")
        page.text(3, result.objective.unit)
        share = other.worse_frac
        page.number(4, 0.0 if share is not None and share <= AS_GOOD else share, SHARE)
        page.formula(5, f'=IF(D{n}="","",IF(D{n}<=$B$2,"yes","no"))')
        page.text(6, other.differs, wrap=True)
        if design is not None:
            cost = design.totals.cost
            for column, value in ((7, cost.value), (8, cost.low), (9, cost.high)):
                page.number(column, value, MONEY)
            page.number(10, design.totals.power_w, "0.00")
            page.number(11, design.totals.mass_kg, "0.00")
        for column, kind in enumerate(kinds, 12):
            page.text(column, other.hardware.get(kind, ""), wrap=True)
        page.number(12 + len(kinds), other.light_count, WHOLE)
        page.row += 1


def about_page(book: Any, result: Result) -> None:
    """What the order rests on, and what may go wrong with it."""
    page = Page(book, ABOUT, (34, 100))
    page.line("What this order rests on", bold=True)
    facts = (
        ("mission", result.mission.get("name") or ""), ("best by", result.objective.name),
        ("made by", f"uwopt {result.uwopt_version}, catalogue {result.versions.get('catalogue', 'not named')}"),
        ("prices", "in one currency, at the mission's exchange rates; low and high are the ends of what is estimated"),
    )  # fmt: skip
    for name, value in facts:
        page.line(name, value, wrap=True)
    page.row += 1
    if result.risks:
        page.line("What may go wrong, the most serious first", bold=True)
    for risk in result.risks:
        figure = f" ({risk.figure})" if risk.figure else ""
        page.line(words.as_sentence(risk.what), f"{risk.because}{figure}", wrap=True)
