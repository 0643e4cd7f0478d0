"""Which numbers of a part are uncertain: those that no source states for it."""

from __future__ import annotations

from uwopt.catalog.parts.part import Part
from uwopt.catalog.parts.quantity import Quantity

DOUBTFUL = ("estimated", "generic", "derived")


def doubtful(part: Part) -> list[tuple[str, Quantity]]:
    """Fields whose value is not stated by a source for this very part and has a range."""
    found = []
    for name in part.__dataclass_fields__:
        value = getattr(part, name)
        if isinstance(value, Quantity) and value.status in DOUBTFUL and value.high > value.low:
            found.append((name, value))
    return found
