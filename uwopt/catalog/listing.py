"""The catalogue as rows for people: what there is, what is known of a part and from where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from uwopt.catalog.catalogue import Catalog, Exclusion
from uwopt.catalog.choose import matches
from uwopt.catalog.parts.cell import Field, kept_fields
from uwopt.catalog.parts.kinds import PARTS
from uwopt.catalog.records import KINDS, Complete, Curve, Kind, Part, Quantity
from uwopt.units import format_within


@dataclass(frozen=True, slots=True)
class PartLine:
    """One part in a list: what it is in a few words, its price, and why it cannot be searched."""

    id: str
    kind: Kind
    manufacturer: str
    model: str
    availability: str
    summary: str
    price: Quantity | None
    currency: str
    generic: bool
    searchable: bool
    reasons: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FieldLine:
    """One field of a part: its value in words, range, status and source."""

    name: str
    value: str
    low: float | None
    high: float | None
    status: str
    source: str


def list_parts(
    catalog: Catalog, kind: Kind | None = None, pattern: str = "", excluded: bool = False
) -> list[PartLine]:
    """Parts that can be searched, or (`excluded`) those that cannot, of one kind or all."""
    reasons: dict[str, list[str]] = {}
    for exclusion in catalog.exclusions:
        reasons.setdefault(exclusion.part_id, []).append(f"{exclusion.rule}: {exclusion.reason}")
    lines = []
    for each in KINDS if kind is None else (kind,):
        for part in catalog.parts(each):
            if (part.id in reasons) != excluded or (pattern and not matches(pattern, part)):
                continue
            lines.append(_part_line(part, each, tuple(reasons.get(part.id, ()))))
    return lines


def show_part(catalog: Catalog, part_id: str) -> tuple[list[FieldLine], tuple[Exclusion, ...]]:
    """Every known field of a part with its status and source, and why it cannot be searched, if so."""
    part = catalog.part(part_id)
    lines: dict[str, FieldLine] = {}
    for one in (part, *parts_of_complete(part)):
        for field in kept_fields(type(one)):
            if field.cell.shown and field.name not in lines and (line := _field_line(one, field)) is not None:
                lines[field.name] = line
    return list(lines.values()), catalog.exclusions_of(part.id)


def parts_of_complete(part: Part) -> tuple[Part, ...]:
    """Camera, lens and port of a complete camera, for what they alone state; nothing of any other part."""
    return (part.own_camera, part.own_lens, part.own_port) if isinstance(part, Complete) else ()


def _part_line(part: Part, kind: Kind, reasons: tuple[str, ...]) -> PartLine:
    return PartLine(
        part.id,
        kind,
        part.manufacturer,
        part.model,
        part.availability,
        summary(part, kind),
        part.price,
        part.currency,
        part.generic,
        not reasons,
        reasons,
    )


def summary(part: Part, kind: Kind) -> str:
    """A part in a few words with units; `~` marks an estimate."""
    return ", ".join(word for word in PARTS[kind].summary(part) if word)


def estimated_fields(part: Part) -> list[str]:
    """Fields that no source states for this part: class estimates stand there."""
    return list(dict.fromkeys(
        field.name
        for one in (part, *parts_of_complete(part))
        for field in kept_fields(type(one))
        if _status(one, field) == "estimated" and (one is part or not hasattr(part, field.name))
    ))  # fmt: skip


def _field_line(part: Part, field: Field) -> FieldLine | None:
    value = getattr(part, field.name)
    if value is None or value == "" or value == () or value == {}:
        return None
    if isinstance(value, Quantity):
        if field.name == "price":
            text = format_within(value.value, value.low, value.high, part.currency)
        else:
            text = f"{value.value:.6g}"
        return FieldLine(field.name, text, value.low, value.high, value.status, value.source)
    return FieldLine(field.name, _in_words(value), None, None, _status(part, field), "")


def _status(part: Part, field: Field) -> str:
    """How a field is known, "" where nothing tells."""
    value = getattr(part, field.name)
    if isinstance(value, Quantity):
        return value.status
    return getattr(part, field.cell.status) if field.cell.status else ""


def _in_words(value: object) -> str:
    if isinstance(value, Curve):
        return f"{len(value.x)} points from {value.x[0]:g} to {value.x[-1]:g}"
    if isinstance(value, dict):
        return ", ".join(f"{name}: {_in_words(item)}" for name, item in value.items())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(_in_words(item) for item in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
