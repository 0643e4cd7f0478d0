"""Which numbers of a part are uncertain: those that no source states for it."""

from __future__ import annotations

from dataclasses import fields

from uwopt.catalog.parts.part import Part
from uwopt.catalog.parts.quantity import Quantity

DOUBTFUL = ("estimated", "generic", "derived")


def doubtful(part: Part) -> list[tuple[str, Quantity]]:
    """Fields whose value is not stated by a source for this very part and has a range."""
    found = []
    for f in fields(part):
        value = getattr(part, f.name)
        if isinstance(value, Quantity) and value.status in DOUBTFUL and value.high > value.low:
            found.append((f.name, value))
    return found
