"""How what files state becomes a record: numbers with their doubt, class estimates, identity and price.

A row of a table has an estimate of its class wherever it is silent and the table of class estimates has one.
An inline record of a system file has none: what it leaves out is unknown, or has a default of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

from uwopt.catalog.catalogue import Exclusion
from uwopt.catalog.estimates import ClassEstimate, first_class, slug
from uwopt.catalog.mounts import counterpart, is_free
from uwopt.catalog.parts.cell import Field, kept_fields
from uwopt.catalog.parts.part import Kind, Part
from uwopt.catalog.parts.port import Port
from uwopt.catalog.parts.quantity import Curve, Quantity, Status, exact
from uwopt.catalog.userparts import PartRow

Origin = Literal["published", "user", "generic"]  # whose row it is: the catalogue's, the user's, to be made

#: What is sold for something else, and no part of a camera system: by `purpose`, why not.
_MADE_FOR_OTHERS = {
    "dive torch": "a diver's hand torch, with a narrow beam and a switch to press",
    "astronomy camera": "made to stand behind a telescope",
    "complete camera": "a camera with lens and port of its own, no body to build in",
}
_WITHDRAWN = {"discontinued": "no longer sold", "not_a_product": "nobody sells it as a part"}


@dataclass(frozen=True, slots=True)
class Built:
    """A record and the vital facts it lacks, as (rule, reason)."""

    part: Part
    lacks: tuple[str, ...]

    def exclusions(self, kind: Kind) -> list[Exclusion]:
        """Why the part cannot be searched; empty when it can."""
        found = []
        if self.part.availability in _WITHDRAWN:
            found.append(Exclusion(self.part.id, kind, "availability", _WITHDRAWN[self.part.availability]))
        purpose = getattr(self.part, "purpose", "")
        if purpose in _MADE_FOR_OTHERS:
            found.append(Exclusion(self.part.id, kind, "purpose", _MADE_FOR_OTHERS[purpose]))
        if self.lacks:
            found.append(Exclusion(self.part.id, kind, "vital facts", "; ".join(self.lacks)))
        if isinstance(self.part, Port) and not is_free(self.part.mount):
            found.append(Exclusion(self.part.id, kind, "port mount", f"needs {counterpart(self.part.mount)}"))
        return found


@dataclass(frozen=True, slots=True)
class Reader:
    """How the records of a kind are made: from a row of a table, and from an inline record."""

    from_row: Callable[[PartRow, Origin], Built]
    from_inline: Callable[[Mapping[str, Any], Path | None], Part]


# ---------------------------------------------------------------- rows of tables


def row_fields(record: type[Part], row: PartRow, origin: Origin, classes: tuple[str, ...]) -> dict[str, Any]:
    """The fields of a record as a row states them; estimates of the first class that has one for the rest."""
    made = {}
    for field in kept_fields(record):
        if field.cell.in_files and field.cell.form is None:
            value = _from_row(field, row, origin, classes)
            if value is not None:
                made[field.name] = value
    return made


def _from_row(field: Field, row: PartRow, origin: Origin, classes: tuple[str, ...]) -> Any:
    if field.is_quantity:
        return known(row, field.name, origin) or _estimated(f"{row.kind}-{slug(field.name)}", classes)
    value = row.cells.get(field.name)
    return int(value) if field.bare_type is int and isinstance(value, float) else value


def identity(
    row: PartRow, origin: Origin, price_class: ClassEstimate | Quantity, price_currency: str, mass: Quantity
) -> dict[str, Any]:
    """Availability, price and mass; the class stands in where the row has none."""
    price, currency = _price(row, origin, price_class, price_currency)
    return {
        "availability": row.text("availability") or ("current" if origin == "user" else "unknown"),
        "generic": origin == "generic",
        "price": price,
        "currency": currency,
        "mass_g": _with_ends(row, "mass_g", "mass_low_g", "mass_high_g", origin) or mass,
    }


def known(row: PartRow, name: str, origin: Origin) -> Quantity | None:
    """The number that a row states, without a range; None when the cell is empty."""
    value = row.number(name)
    return None if value is None else exact(value, origin, row.text("source_url"))


@cache
def _estimated(prefix: str, classes: tuple[str, ...]) -> Quantity | None:
    estimate = first_class(prefix, *classes)
    return None if estimate is None else estimate.quantity()


def _with_ends(row: PartRow, name: str, low: str, high: str, status: Status) -> Quantity | None:
    value = row.number(name)
    if value is None:
        return None
    low_value, high_value = row.number(low), row.number(high)
    return Quantity(
        value,
        value if low_value is None else low_value,
        value if high_value is None else high_value,
        status,
        row.text("source_url"),
    )


def _price(
    row: PartRow, origin: Origin, price_class: ClassEstimate | Quantity, price_currency: str
) -> tuple[Quantity, str]:
    told = row.text("price_status")
    status: Status = origin
    if origin == "published":
        status = "derived" if told == "derived" else "estimated" if told == "estimated" else "quoted"
    own = _with_ends(row, "price", "price_low", "price_high", status)
    if own is not None:
        return own, (row.text("currency") or "USD").upper()
    if isinstance(price_class, ClassEstimate):
        return price_class.quantity(), price_class.currency
    return price_class, price_currency


# ---------------------------------------------------------------- inline records


def inline_fields(record: type[Part], kind: Kind, values: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a record as an inline part states them; curves are left to the kind's own reader."""
    made: dict[str, Any] = {"inline": True}
    for field in kept_fields(record):
        inline, value = field.inline, values.get(field.name)
        if inline is None or field.bare_type is Curve:
            continue
        if field.is_quantity:
            made[field.name] = user_number(value) or inline.estimate
        elif value is not None:
            made[field.name] = value
        if field.cell.status:
            made[field.cell.status] = "user"
    named = {"id": f"inline-{kind}", "model": f"inline {kind}"}
    return named | made | {"currency": made["currency"].upper()}


def user_number(value: float | None) -> Quantity | None:
    """A number that the user stated."""
    return None if value is None else exact(value, "user", "system file")


def is_csv(name: str) -> bool:
    """Whether a name is that of a CSV file."""
    return name.casefold().endswith(".csv")
