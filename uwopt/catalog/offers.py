"""Offers of makers as rows of parts: what a tender asks of them, and their answers read cell by cell.

An answer is a number in the column's unit, a number with a unit of its own behind it, or a word. What does not fit is
told and left out; nothing is guessed.
"""

from __future__ import annotations

import datetime as dt
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from uwopt.catalog.changes import built_in_cells, kind_named
from uwopt.catalog.columns import COLUMNS, REQUIRED, CellError, Column, parse_cell
from uwopt.catalog.parts.cell import beyond, fields_of
from uwopt.catalog.parts.kinds import PARTS
from uwopt.catalog.parts.part import Kind
from uwopt.documents.faults import plain_name
from uwopt.documents.files import FORMULA_SIGNS
from uwopt.units import SYMBOLS, convert, split_unit

FORM = "uwopt tender, form 1"
BILL_SHEET = "Order"  # the first sheet of a bill, which somebody may take for a tender
KEYS = ("part", "candidate", "pieces")  # above the table of a sheet, in this order
MAKERS = 3  # columns of answers
BUSINESS = ("named_part", "valid_until", "lead_time_weeks")  # answers that are no cells of a part
DATED = ("price_date", "valid_until")
WITH_UNIT = re.compile(r"([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)\s*([^\d\s].*)", re.IGNORECASE)
DIFFERS = 0.02  # a share: by more an answer contradicts the data sheet
LONGEST = 300  # signs of an answer


@dataclass(frozen=True)
class MakerAnswers:
    """What one maker wrote on one sheet: texts by key, and where."""

    where: str
    part: str
    candidate: str
    texts: Mapping[str, str]


@dataclass(frozen=True)
class Offer:
    """One part that is offered: the row it makes in a file of parts, and what is to be known of it."""

    where: str
    kind: Kind
    candidate: str
    part_id: str
    cells: Mapping[str, str]
    named: bool  # the part of the catalogue itself
    valid_until: str = ""
    lead_time_weeks: str = ""
    missing: tuple[str, ...] = ()
    contradicts: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    usable: bool = True


@dataclass
class Reading:
    """One maker's answers while they are read."""

    answers: MakerAnswers
    kind: Kind
    cells: dict[str, str] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    def take(self, key: str, text: str) -> None:
        """One answer, checked; what is wrong becomes a fault and is left out."""
        column = COLUMNS[self.kind].get(key)
        if len(text) > LONGEST:
            self.faults.append(f"{key}: is longer than {LONGEST} signs")
        elif text.startswith(FORMULA_SIGNS) and not number_of(text):
            self.faults.append(f"{key}: {text[:40]!r} begins like a formula; write words or a number")
        elif key in DATED:
            self.dated(key, text)
        elif column is None and key not in BUSINESS:
            self.faults.append(f"{key}: is no fact of a {self.kind}")
        elif column is None:
            self.cells[key] = text
        else:
            self.checked(column, text)

    def dated(self, key: str, text: str) -> None:
        """A day."""
        day = text[:10]
        try:
            dt.date.fromisoformat(day)
        except ValueError:
            self.faults.append(f"{key}: {text[:40]!r} is no day; write YYYY-MM-DD")
            return
        self.cells[key] = day

    def checked(self, column: Column, text: str) -> None:
        """A cell of a part, in the column's unit."""
        told = text.strip()
        if column.form == "number" and number_of(told) is None:
            converted, fault = in_unit(column, told)
            if fault:
                self.faults.append(fault)
                return
            told = converted
        try:
            value = parse_cell(column, told)
        except CellError as fault:
            self.faults.append(str(fault))
            return
        if isinstance(value, float) and (far := beyond(value, column.span)):
            self.faults.append(f"{column.name} = {told} {far}, as none is made; check its unit")
            return
        self.cells[column.name] = told


def number_of(text: str) -> float | None:
    """A finite number, or None."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def in_unit(column: Column, text: str) -> tuple[str, str]:
    """A number with a unit behind it in the column's unit; or what is wrong with it."""
    own = split_unit(column.name)[1]
    if "," in text:
        return "", f"{column.name}: {text[:40]!r} is no number; write it without commas, such as 4500.00"
    found = WITH_UNIT.fullmatch(text)
    if found is None:
        return "", f"{column.name}: {text[:40]!r} is no number"
    unit = unit_named(found[2])
    value = convert(float(found[1]), unit, own) if own else None
    if value is None:
        wanted = f"in {SYMBOLS.get(own, own)}" if own else "a bare number"
        return "", f"{column.name}: {text[:40]!r} is in another unit; it is asked {wanted}"
    return f"{value:.10g}", ""


def unit_named(text: str) -> str:
    """A unit as people write it by the name that the program has for it."""
    plain = text.strip().replace("μ", "µ")
    by_symbol = {shown: name for name, shown in SYMBOLS.items()}
    return by_symbol.get(plain) or plain.casefold().replace("µ", "u").replace("/", "_")


def offers_of(sheets: Sequence[MakerAnswers], today: str) -> list[Offer]:
    """Every offer of a tender's answers; columns that nobody filled in are none."""
    return [offer_of(one, today) for one in sheets if any(text.strip() for text in one.texts.values())]


def offer_of(answers: MakerAnswers, today: str) -> Offer:
    """One maker's answers as a part: the named one with what is new of it, or one of its own."""
    kind = kind_named(answers.part)
    if kind is None:
        fault = f"part {answers.part[:40]!r} is no kind of part"
        return Offer(answers.where, "camera", answers.candidate, "", {}, False, faults=(fault,), usable=False)
    read = Reading(answers, kind)
    for key, text in answers.texts.items():
        if text.strip():
            read.take(key, text.strip())
    key = plain_name(answers.candidate)
    sold, made = built_in_cells().get(key), built_in_cells("generic").get(key)
    named = read.cells.pop("named_part", "no").casefold() in ("yes", "y", "true") and sold is not None
    until, weeks = read.cells.pop("valid_until", ""), read.cells.pop("lead_time_weeks", "")
    base = (sold or made or (kind, None))[1]
    of_named = dict(base.cells) if base is not None else {}
    price_faults = priced(read, until, today)
    cells = with_source(of_named_part(read.cells) if named else of_its_own(kind, read.cells, of_named), answers, today)
    part_id = answers.candidate if named else new_id(cells)
    missing = tuple(name for name in answers.texts if name not in read.cells and name in COLUMNS[kind] and name != "id")
    lacks = [] if named else [name for name in REQUIRED[kind] if name != "id" and not cells.get(name)]
    nameless = [] if named or part_id else ["maker and model are not told, so the part has no name"]
    lacking = [f"{', '.join(lacks)} must be known of a {kind}"] if lacks else []
    faults = (*read.faults, *price_faults, *nameless, *lacking)
    return Offer(
        answers.where, kind, answers.candidate, part_id, {"part": kind, "id": part_id, **cells}, named, until, weeks,
        missing, contradictions(read.cells, of_named) if named else (), faults, not (nameless or lacking),
    )  # fmt: skip


def priced(read: Reading, until: str, today: str) -> list[str]:
    """Takes a price back that does not count: without currency or day, or no longer held."""
    if "price" not in read.cells:
        return []
    why = ""
    if "currency" not in read.cells:
        why = "has no currency"
    elif "price_date" not in read.cells:
        why = "has no day"
    elif until and until < today:
        why = f"held until {until}"
    if not why:
        read.cells["currency"] = read.cells["currency"].upper()
        return []
    for name in ("price", "currency", "price_date"):
        read.cells.pop(name, None)
    return [f"price: {why}, so it does not count"]


def of_named_part(told: Mapping[str, str]) -> dict[str, str]:
    """Cells that are new of the part that was named; its name stays as the catalogue has it."""
    return {name: text for name, text in told.items() if name not in ("manufacturer", "model")}


def of_its_own(kind: Kind, told: Mapping[str, str], named: Mapping[str, str]) -> dict[str, str]:
    """Cells of a part of its own: what is told, and of words that are not (mount, shape) what the named part has."""
    kept = ("id", "manufacturer", "model", "note", "source_url", "checked", "correction", "currency", "price_date",
            "price_status", "availability")  # fmt: skip
    words = {
        name: text
        for name, text in named.items()
        if text and name not in kept and name in COLUMNS[kind] and COLUMNS[kind][name].form != "number"
    }
    made_for = next((f.default for f in fields_of(PARTS[kind].record) if f.name == "purpose"), "")
    meant = {"purpose": str(made_for)} if made_for else {}
    return {"availability": "current", **meant, **words, **told}


def with_source(cells: Mapping[str, str], answers: MakerAnswers, today: str) -> dict[str, str]:
    """Cells with where they are from."""
    maker = answers.texts.get("manufacturer", "").strip().lstrip("".join(FORMULA_SIGNS))[:LONGEST] or "a maker"
    return {**cells, "source_url": f"answer to a tender by {maker}, read {today}"}


def new_id(cells: Mapping[str, str]) -> str:
    """`maker-model`, as ids of the catalogue are written."""
    if not (cells.get("manufacturer") and cells.get("model")):
        return ""
    return re.sub(r"[^a-z0-9]+", "-", f"{cells['manufacturer']} {cells['model']}".casefold()).strip("-")[:80]


def contradictions(told: Mapping[str, str], sheet: Mapping[str, str]) -> tuple[str, ...]:
    """MakerAnswers on the named part that its data sheet, as the catalogue has it, says otherwise."""
    found = []
    for name, text in told.items():
        before = sheet.get(name, "")
        if not before or name in ("price", "currency", "price_date", "manufacturer", "model", "source_url"):
            continue
        new, old = number_of(text), number_of(before)
        apart = abs(new - old) > DIFFERS * abs(old) if new is not None and old is not None else text != before
        if apart:
            found.append(f"{name} is {text} in the answer, {before} in the data sheet")
    return tuple(found)
