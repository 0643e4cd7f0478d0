"""A tender: a workbook with a sheet a part that makers fill in, and a letter that goes with it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from uwopt.catalog.columns import COLUMNS
from uwopt.catalog.offers import FORM, KEYS, MAKERS
from uwopt.catalog.parts.part import Kind
from uwopt.report.order.book import Page, book_bytes, new_book
from uwopt.report.order.tender_lines import COMMERCIAL, AskedFact, TenderLine, falls_short
from uwopt.report.text import formats, words
from uwopt.results.result import Result

BOOK_FILE, LETTER_FILE, BUYER_FILE = "tender.xlsx", "letter.txt", "not-for-makers.txt"
HEADS = ("key", "what", "unit", "needed, if all else is as in the named part",
         "enough, if it has all of these together", "the named part has", "known from")  # fmt: skip
WIDTHS = (20, 44, 18, 26, 28, 18, 13, *[24] * MAKERS)
FIRST_ANSWER = len(HEADS) + 1


def tender_book(result: Result, lines: Sequence[TenderLine]) -> bytes:
    """The workbook: how to fill it in, and a sheet a line."""
    book = new_book(f"Tender: {formats.one_line(result.mission.get('name') or 'mission', 100)}")
    read_me(book, result, lines)
    for line in lines:
        line_page(book, line)
    return book_bytes(book)


def read_me(book: Any, result: Result, lines: Sequence[TenderLine]) -> None:
    """What is tendered, and how to answer."""
    page = Page(book, "Read me", (30, 90))
    page.line(formats.one_line(result.mission.get("name") or "Mission", 120), bold=True)
    if short := falls_short(result):
        page.line(f"{short}. {MAKERS_ARE_NOT_TOLD}", bold=True)
    page.row += 1
    for text in HOW:
        page.line("", text, wrap=True)
    page.row += 1
    for line in lines:
        named = f"named: {line.name}{' (a class: to be made)' if line.generic else ''}"
        page.line(f"{line.count} x {line.kind}", named)
    page.row += 1
    page.line("made by", f"uwopt {result.uwopt_version}, catalogue {result.versions.get('catalogue', 'not named')}")


HOW = (
    "Fill in the yellow cells, one column a maker. Numbers only, in the unit beside them; a number with its own unit "
    "behind it, such as 27.4 klm, is read too. Leave empty what is not known. No formulas.",
    "Needed: the least that does our work if every other number of the part is as the named part has it. Enough: a "
    "part that has all of these together does our work.",
    "A part that is better in one number may be worse in another: every answer is worked through as a whole.",
    "Give the price of one piece with its currency, the day of the quote, until when it holds, and the lead time.",
)

MAKERS_ARE_NOT_TOLD = "Take this line out before you send it."


def line_page(book: Any, line: TenderLine) -> None:
    """The sheet of one part."""
    page = Page(book, f"{line.kind}", WIDTHS)
    page.line(FORM, bold=True)
    for name, value in zip(KEYS, (line.kind, line.part_id, line.count), strict=True):
        page.line(name, value)
    page.line("named part", line.name + (" (a class of parts: to be made)" if line.generic else ""))
    page.row += 1
    head = page.heads((*HEADS, *(f"maker {n}" for n in range(1, MAKERS + 1))))
    page.freeze(head + 1, 3)
    for key, what, unit in COMMERCIAL:
        page.text(1, key)
        page.text(2, what)
        page.text(3, unit)
        answers(page, key, line.kind)
    for fact in line.facts:
        fact_row(page, fact)
        answers(page, fact.key, line.kind)


def fact_row(page: Page, fact: AskedFact) -> None:
    """What is asked of one fact."""
    texts = (fact.key, fact.words, fact.unit, fact.needed, fact.together, fact.named, fact.known)
    for column, value in enumerate(texts, 1):
        page.text(column, value, wrap=column == 2)


def answers(page: Page, key: str, kind: Kind) -> None:
    """A cell a maker; only words that may stand there where they are few."""
    column = COLUMNS[kind].get(key)
    for n in range(MAKERS):
        cell = page.entry(FIRST_ANSWER + n)
        if key == "named_part":
            page.choice(cell, ("yes", "no"))
        elif column is not None and column.form == "choice" and len(",".join(column.choices)) < 250:
            page.choice(cell, column.choices)
        elif key == "lead_time_weeks":
            page.check(cell, "decimal", 0, 520, "weeks, from 0 to 520")
    page.row += 1


# ---------------------------------------------------------------- letter


def letter(result: Result, lines: Sequence[TenderLine]) -> str:
    """A letter to makers, as text to be sent with the workbook."""
    name = formats.one_line(result.mission.get("name") or "our mission", 120)
    wanted = "\n".join(
        f"- {line.count} x {line.kind}, such as {words.made_name(line.name, generic=line.generic)}"
        for line in lines
    )
    hard = "\n\n".join(filter(None, map(enough_text, lines)))
    short = falls_short(result)
    first = f"[{short}. {MAKERS_ARE_NOT_TOLD}]\n\n" if short else ""
    return first + LETTER.format(name=name, wanted=wanted, hard=hard)


MEDIA = ("air", "water")


def enough_text(line: TenderLine) -> str:
    """What is enough of one part, below its name; empty where nothing is asked that parts of its kind do not have."""
    medium = next((fact.named for fact in line.facts if fact.key == "beam_medium" and fact.named in MEDIA), "")
    where = {"beam_angle_deg": f", measured in {medium}"} if medium else {}  # behind a flat window water narrows it
    needed = [not fact.loose and (fact.together or fact.needed) for fact in line.facts]
    told = [(fact, text or as_named(line.kind, fact)) for fact, text in zip(line.facts, needed, strict=True)]
    facts = [f"- {fact.words}{where.get(fact.key, '')}: {text}" for fact, text in told if text]
    return "\n".join([f"{line.kind.capitalize()}:", *facts]) if facts else ""


#: Without which nobody knows what is asked for, whether or not a limit was found.
DESCRIBED = {
    "camera": ("colour", "shutter", "interface"),
    "port": ("geometry", "outer_radius_mm", "clear_diameter_mm", "thickness_mm", "mount"),
}


def as_named(kind: Kind, fact: AskedFact) -> str:
    """What the named part has of a fact that describes its kind; empty for others, and where it is not known."""
    if fact.key not in DESCRIBED.get(kind, ()) or not fact.named:
        return ""
    value = f"{fact.named} {fact.unit}" if COLUMNS[kind][fact.key].form == "number" else fact.named
    return f"{'about ' if fact.known == 'estimated' else ''}{value}, {LIKE_IT}"


LIKE_IT = "as in the named part"
LETTER = f"""\
Subject: request for quotation, {{name}}

Dear Sir or Madam,

for an underwater imaging system we ask for your quotation for any of

{{wanted}}

The named parts are examples; equivalent ones are welcome. Please fill in one of the yellow columns on the sheet of
each part that you offer in the attached tender.xlsx: price of one piece with its currency, date and validity of the
quotation, lead time, and the technical data that are asked for. Please leave a cell empty where a value is not known.

A part that meets all points below its name is suitable; of what is told {LIKE_IT}, please tell us
what yours has:

{{hard}}

If a part falls short in one point but is better in another, please offer it all the same: we assess each offer as a
whole.

With kind regards,

[name, institution, address, date by which we need your answer]
"""


# ---------------------------------------------------------------- for the buyer alone


def kept_back(lines: Sequence[TenderLine]) -> str:
    """What the buyer knows of each part and no maker should: what else would do, and what would win against it."""
    return "\n\n".join([NOT_FOR_MAKERS, *map(kept_back_of, lines)]) + "\n"


NOT_FOR_MAKERS = f"Not for makers: what {BOOK_FILE} and {LETTER_FILE} do not say."


def kept_back_of(line: TenderLine) -> str:
    """The same of one part."""
    told = [f"{line.count} x {line.kind}, {formats.one_line(line.name, 80)}",
            f"  would do as well, or nearly: {'; '.join(line.alternatives) or 'none is known'}"]  # fmt: skip
    if line.rival:
        told.append(f"  best buy against: {line.rival}")
    facts = [f"  - {fact.words}: {fact.stays_best}" for fact in line.facts if fact.stays_best]
    return "\n".join([*told, *(["  beyond these numbers we would prefer another part:"] if facts else []), *facts])
