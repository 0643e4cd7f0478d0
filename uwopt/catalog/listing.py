"""The catalogue as rows for people: what there is, what is known of a part and from where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

from uwopt.catalog.catalogue import Catalog, Exclusion
from uwopt.catalog.choose import matches
from uwopt.catalog.columns import KINDS, Kind
from uwopt.catalog.records import Camera, Curve, Lens, Light, Part, Port, Quantity

SILENT_FIELDS = frozenset(
    {
        "generic",
        "inline",
        "currency",
        "bit_depth_status",
        "image_circle_status",
        "dim_status",
        "beam_profile_is_candela",
    }
)
STATUS_FIELDS = {
    "bit_depth": "bit_depth_status",
    "image_circle_mm": "image_circle_status",
    "dim_levels": "dim_status",
}


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
    lines = [
        line
        for f in fields(part)
        if f.name not in SILENT_FIELDS and (line := _field_line(part, f.name)) is not None
    ]
    return lines, catalog.exclusions_of(part.id)


def _part_line(part: Part, kind: Kind, reasons: tuple[str, ...]) -> PartLine:
    return PartLine(
        part.id,
        kind,
        part.manufacturer,
        part.model,
        part.availability,
        summary(part),
        part.price,
        part.currency,
        part.generic,
        not reasons,
        reasons,
    )


def summary(part: Part) -> str:
    """A part in a few words with units; `~` marks an estimate."""
    if isinstance(part, Camera):
        size = f"{part.resolution_x_px} x {part.resolution_y_px} px, {part.pixel_pitch_um:g} µm"
        return ", ".join(
            word
            for word in (part.chip, part.colour, size, part.shutter, "/".join(part.mounts), part.interface)
            if word
        )
    if isinstance(part, Lens):
        circle = "" if part.image_circle_mm is None else f"circle {part.image_circle_mm:g} mm"
        words = (
            f"{part.focal_length_mm:g} mm",
            _shown("F", part.f_number_min, ""),
            circle,
            "/".join(part.mounts),
        )
        return ", ".join(word for word in words if word)
    if isinstance(part, Port):
        size = "" if part.outer_radius_mm is None else f"radius {part.outer_radius_mm:g} mm"
        return ", ".join(word for word in (part.geometry, part.material, size, _depth(part)) if word)
    if isinstance(part, Light):
        light = (
            _shown("", part.flash_energy_j, " J") if part.kind == "flash" else _shown("", part.flux_lm, " lm")
        )
        power = "" if part.kind == "flash" else _shown("", part.power_w, " W")
        medium = "(medium not stated)" if part.beam_medium == "not stated" else f"in {part.beam_medium}"
        angle = _shown("", part.beam_angle_deg, f" deg {medium}")
        return ", ".join(word for word in (part.kind, light, power, angle, _depth(part)) if word)
    return part.model


def estimated_fields(part: Part) -> list[str]:
    """Fields that no source states for this part: class estimates stand there."""
    names = []
    for f in fields(part):
        value = getattr(part, f.name)
        status = (
            value.status if isinstance(value, Quantity) else getattr(part, STATUS_FIELDS.get(f.name, ""), "")
        )
        if status == "estimated":
            names.append(f.name)
    return names


def _shown(before: str, quantity: Quantity | None, after: str) -> str:
    if quantity is None:
        return ""
    number = f"{quantity.value:.3g}" if abs(quantity.value) < 1000.0 else f"{quantity.value:.0f}"
    return f"{before}{'~' if quantity.estimated else ''}{number}{after}"


def _depth(part: Port | Light) -> str:
    return "" if part.depth_rating_m is None else f"to {part.depth_rating_m:g} m"


def _field_line(part: Part, name: str) -> FieldLine | None:
    value = getattr(part, name)
    if value is None or value == "" or value == () or value == {}:
        return None
    if isinstance(value, Quantity):
        text = f"{value.value:.6g}" + (f" {part.currency}" if name == "price" else "")
        return FieldLine(name, text, value.low, value.high, value.status, value.source)
    status = getattr(part, STATUS_FIELDS[name]) if name in STATUS_FIELDS else ""
    return FieldLine(name, _in_words(value), None, None, status, "")


def _in_words(value: object) -> str:
    if isinstance(value, Curve):
        return f"{len(value.x)} points from {value.x[0]:g} to {value.x[-1]:g}"
    if isinstance(value, dict):
        return ", ".join(f"{name}: {_in_words(item)}" for name, item in value.items())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(_in_words(item) for item in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
