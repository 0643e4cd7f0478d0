"""What all four kinds share when a row becomes a record: identity, price, mass, published numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict

from uwopt.catalog.catalogue import Exclusion
from uwopt.catalog.estimates import ClassEstimate
from uwopt.catalog.records import Availability, Kind, Part, Quantity, Status
from uwopt.catalog.userparts import PartRow

Origin = Literal["published", "user", "generic"]  # whose row it is: the catalogue's, the user's, to be made

_AVAILABILITY: dict[str, Availability] = {
    name: name for name in ("current", "discontinued", "not_a_product", "unknown")
}
_WITHDRAWN = {"discontinued": "no longer sold", "not_a_product": "nobody sells it as a part"}


class Identity(TypedDict):
    """The fields of `Part` that every builder fills alike."""

    id: str
    manufacturer: str
    model: str
    availability: Availability
    generic: bool
    price_date: str
    source_url: str
    note: str
    price: Quantity | None
    currency: str
    mass_g: Quantity | None


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
        if self.lacks:
            found.append(Exclusion(self.part.id, kind, "vital facts", "; ".join(self.lacks)))
        return found


def identity(
    row: PartRow, origin: Origin, price_class: ClassEstimate | Quantity, price_currency: str, mass: Quantity
) -> Identity:
    """Identity, price and mass; the class stands in where the row has none."""
    price, currency = _price(row, origin, price_class, price_currency)
    return {
        "id": row.text("id"),
        "manufacturer": row.text("manufacturer"),
        "model": row.text("model"),
        "availability": _AVAILABILITY.get(
            row.text("availability"), "current" if origin == "user" else "unknown"
        ),
        "generic": origin == "generic",
        "price_date": row.text("price_date"),
        "source_url": row.text("source_url"),
        "note": row.text("note"),
        "price": price,
        "currency": currency,
        "mass_g": _with_ends(row, "mass_g", "mass_low_g", "mass_high_g", origin) or mass,
    }


def known(row: PartRow, name: str, origin: Origin) -> Quantity | None:
    """The number that a row states, without a range; None when the cell is empty."""
    value = row.number(name)
    return None if value is None else Quantity(value, value, value, origin, row.text("source_url"))


def known_or(row: PartRow, name: str, origin: Origin, estimate: ClassEstimate | None) -> Quantity | None:
    """The number that a row states, else the class estimate."""
    return known(row, name, origin) or (None if estimate is None else estimate.quantity())


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
