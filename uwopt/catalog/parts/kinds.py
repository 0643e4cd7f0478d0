"""All kinds of parts, and tables by field name that hold for all of them."""

from __future__ import annotations

from uwopt.catalog.parts import camera, complete, housing, lens, light, port
from uwopt.catalog.parts.cell import Field, fields_of
from uwopt.catalog.parts.part import Kind, PartKind

PARTS: dict[Kind, PartKind] = {
    "camera": camera.KIND,
    "lens": lens.KIND,
    "port": port.KIND,
    "light": light.KIND,
    "housing": housing.KIND,
    "complete": complete.KIND,
}


def stated_fields(kind: PartKind) -> tuple[Field, ...]:
    """The fields that a row of a kind states: its own, then those of the pieces that it is made of."""
    own = fields_of(kind.record)
    taken = {field.name: field for field in own}
    for record, left_out in kind.pieces.items():
        taken |= {f.name: f for f in fields_of(record) if f.name not in taken and f.name not in left_out}
    return tuple(taken.values())


ALL_FIELDS: tuple[Field, ...] = tuple(field for kind in PARTS.values() for field in fields_of(kind.record))

#: +1: more favours a design, -1: less does. Only fields whose estimate enters a figure stand here.
FAVOURED = {
    f.name: 1 if f.cell.favours == "high" else -1 for f in ALL_FIELDS if f.cell.favours in ("low", "high")
}

#: Fields of which more favours one design and less another: both ends are tried.
EITHER = frozenset(f.name for f in ALL_FIELDS if f.cell.favours == "either")

#: (smaller, larger) pairs of fields.
ORDERED_PAIRS = tuple(dict.fromkeys((f.name, f.cell.at_most) for f in ALL_FIELDS if f.cell.at_most))
