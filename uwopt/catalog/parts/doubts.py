"""Which numbers of a part are uncertain, those that no source states for it, and a part at some value of theirs."""

from __future__ import annotations

from dataclasses import fields

from uwopt.catalog.parts.part import Part
from uwopt.catalog.parts.quantity import Quantity, exact

DOUBTFUL = ("estimated", "generic", "derived")
PRICES = frozenset({"price", "host_price"})


def doubtful(part: Part) -> list[tuple[str, Quantity]]:
    """Fields whose value is not stated by a source for this very part and has a range."""
    found = []
    for f in fields(part):
        value = getattr(part, f.name)
        if isinstance(value, Quantity) and value.status in DOUBTFUL and value.high > value.low:
            found.append((f.name, value))
    return found


def taken_as(name: str, known: Quantity, value: float) -> Quantity:
    """A doubtful number of this field as it is drawn, or at one of its ends.

    A price keeps its high end: what may have to be paid counts against a budget, whatever it turns out to be.
    """
    if name in PRICES:
        return Quantity(value, value, max(value, known.high), known.status, known.source)
    return exact(value, known.status, known.source)
