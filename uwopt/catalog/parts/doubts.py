"""Which numbers of a part are uncertain, those that no source states for it, and a part at some value of theirs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from uwopt.catalog.parts.part import Part
from uwopt.catalog.parts.quantity import Quantity, exact

DOUBTFUL = ("estimated", "generic", "derived")
PRICES = frozenset({"price", "host_price"})
SIZES = ("body_width_mm", "body_height_mm", "body_length_mm", "plug_mm", "length_mm", "diameter_mm")
EITHER_SIZE = ("pupil_mm",)  # that takes room at its low end or at its high one


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

    A price keeps its high end: what may have to be paid counts against a budget, whatever it turns out to be. So do
    sizes, and both of its ends a size that may take room at either: a housing that is to be made is ordered for them
    before they are known.
    """
    if name in PRICES or name in SIZES:
        return Quantity(value, value, max(value, known.high), known.status, known.source)
    if name in EITHER_SIZE:
        return Quantity(value, min(value, known.low), max(value, known.high), known.status, known.source)
    return exact(value, known.status, known.source)


def with_numbers(part: Any, value_at: Callable[[str, Quantity], Quantity | None], *, housing: bool = True) -> Any:
    """A part whose doubtful numbers are those that a rule gives; None: as it is. `housing`: a port's own likewise."""
    made: dict[str, Any] = {
        name: value for name, known in doubtful(part) if (value := value_at(name, known)) is not None
    }
    if housing and getattr(part, "housing", None) is not None:
        made["housing"] = with_numbers(part.housing, value_at)
    return replace(part, **made) if made else part


def each_with(part: Any, columns: Mapping[str, Sequence[Any]], count: int) -> list[Any]:
    """So many times the same part, each with other values of these fields; where there are none, itself.

    Far quicker than `replace`, which asks each field anew; values are those of the same fields, drawn or at an end.
    """
    if not columns:
        return [part] * count
    rest = [(f.name, getattr(part, f.name)) for f in fields(part) if f.name not in columns]
    made = []
    for place in range(count):
        one = object.__new__(type(part))
        for name, value in rest:
            object.__setattr__(one, name, value)
        for name, values in columns.items():
            object.__setattr__(one, name, values[place])
        made.append(one)
    return made
