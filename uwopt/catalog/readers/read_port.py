"""What is stated of a port becomes a `Port`: wall, index and mass by class where it is silent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwopt.catalog.estimates import ClassEstimate, first_class, required_class
from uwopt.catalog.parts.port import REFRACTIVE_INDEX, Port
from uwopt.catalog.parts.quantity import Quantity
from uwopt.catalog.readers.reading import (
    Built,
    Origin,
    Reader,
    identity,
    inline_fields,
    known,
    row_fields,
)
from uwopt.catalog.userparts import PartRow

PLASTICS = ("acrylic", "polycarbonate")
LARGE_SPHERE_RADIUS_MM = 120.0  # above: glass pressure spheres of 10 to 17 inch
SMALL_WINDOW_MM = 60.0
KG_M3_TO_G_MM3 = 1e-6


def from_row(row: PartRow, origin: Origin) -> Built:
    """The port of a row, with what the model needs filled in."""
    thickness = known(row, "thickness_mm", origin) or _thickness(row)
    price = _price_class(row)
    made = row_fields(Port, row, origin, ())
    made |= identity(row, origin, price, price.currency, _mass(row, thickness))
    made |= {"thickness_mm": thickness, "refractive_index": _index(row, origin)}
    return Built(Port(**made), tuple(_lacking(row, thickness)))


def _lacking(row: PartRow, thickness: Quantity | None) -> list[str]:
    if not row.text("geometry"):
        return ["flat or dome not stated"]
    if row.text("geometry") == "dome" and row.number("outer_radius_mm") is None:
        return ["radius of curvature unknown"]
    return ["thickness and diameter unknown"] if thickness is None else []


def _index(row: PartRow, origin: Origin) -> Quantity | None:
    """The stated constant; None where a dispersion formula is named; else by material."""
    stated = known(row, "refractive_index", origin)
    if stated is not None or row.text("glass"):
        return stated
    return required_class("port-refractive-index", row.text("material"), "unknown").quantity()


def _diameter_mm(row: PartRow) -> float | None:
    clear_mm = row.number("clear_diameter_mm")
    return row.number("nominal_diameter_mm") if clear_mm is None else clear_mm


def _thickness(row: PartRow) -> Quantity | None:
    """Wall by the ratio of its class: to the outer radius of a dome, to the diameter of a flat window."""
    plastic = row.text("material") in (*PLASTICS, "")
    radius_mm, diameter_mm = row.number("outer_radius_mm"), _diameter_mm(row)
    if row.text("geometry") == "dome":
        if radius_mm is None:
            return None
        if plastic:
            name = "shallow-acrylic-dome"
        else:
            name = "deep-glass-sphere" if radius_mm > LARGE_SPHERE_RADIUS_MM else "small-deep-glass-dome"
        return required_class("port-thickness-over-outer-radius", name).quantity(radius_mm)
    if diameter_mm is None:
        return None
    name = "flat-acrylic" if plastic else "flat-fused-silica"
    return required_class("port-thickness-over-clear-diameter", name).quantity(diameter_mm)


def _mass(row: PartRow, thickness: Quantity | None) -> Quantity:
    """Density times the volume of the bare window or hemisphere; by class where its size is unknown."""
    density = first_class("port-density-kg-m3", row.text("material"))
    radius_mm, diameter_mm = row.number("outer_radius_mm"), _diameter_mm(row)
    is_dome = row.text("geometry") == "dome"
    if density is None or thickness is None or (radius_mm if is_dome else diameter_mm) is None:
        return required_class("port-mass-g", "dome" if is_dome else "flat").quantity()

    def volume_mm3(wall_mm: float) -> float:
        if is_dome:
            inner_mm = max((radius_mm or 0.0) - wall_mm, 0.0)
            return 2.0 / 3.0 * math.pi * ((radius_mm or 0.0) ** 3 - inner_mm**3)
        return math.pi / 4.0 * (diameter_mm or 0.0) ** 2 * wall_mm

    ends = (
        (density.central, thickness.value),
        (density.low, thickness.low),
        (density.high, thickness.high),
    )
    masses = [rho * KG_M3_TO_G_MM3 * volume_mm3(wall_mm) for rho, wall_mm in ends]
    return Quantity(
        masses[0], masses[1], masses[2], "estimated", f"{density.key}: bare window, without flange"
    )


def _price_class(row: PartRow) -> ClassEstimate:
    material, radius_mm = row.text("material"), row.number("outer_radius_mm")
    diameter_mm = _diameter_mm(row)
    if row.text("geometry") == "dome":
        if material in (*PLASTICS, ""):
            name = "plastic-dome"
        else:
            name = "deep-glass-sphere" if (radius_mm or 0.0) > LARGE_SPHERE_RADIUS_MM else "glass-dome"
    elif material in PLASTICS:
        name = "acrylic-end-cap"
    elif row.number("depth_rating_m") is None and diameter_mm is not None and diameter_mm <= SMALL_WINDOW_MM:
        name = "small-window"
    else:
        name = "deep-window" if material in ("sapphire", "fused silica") else "any"
    return required_class("port-price", name)


def from_inline(values: Mapping[str, Any], base_dir: Path | None) -> Port:
    """The record of an inline port."""
    made = inline_fields(Port, "port", values)
    if made["refractive_index"] is None and "glass" not in made:
        made["refractive_index"] = REFRACTIVE_INDEX
    return Port(**made)


READER = Reader(from_row, from_inline)
