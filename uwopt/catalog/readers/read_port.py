"""What is stated of a port becomes a `Port`: wall, index and mass by class where it is silent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwopt.catalog.estimates import ClassEstimate, first_class, required_class
from uwopt.catalog.mounts import mount_table
from uwopt.catalog.parts.port import REFRACTIVE_INDEX, Port
from uwopt.catalog.parts.quantity import Quantity, exact
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
    radius = _radius(row, origin)
    thickness = known(row, "thickness_mm", origin) or _thickness(row, radius)
    price = _price_class(row, radius)
    made = row_fields(Port, row, origin, ())
    made |= identity(row, origin, price, price.currency, _mass(row, radius, thickness))
    made |= {"outer_radius_mm": radius, "thickness_mm": thickness, "refractive_index": _index(row, origin)}
    made |= {"clear_diameter_mm": known(row, "clear_diameter_mm", origin) or _clear_diameter(row)}
    return Built(Port(**made), tuple(_lacking(row, radius, thickness)))


def _lacking(row: PartRow, radius: Quantity | None, thickness: Quantity | None) -> list[str]:
    if not row.text("geometry"):
        return ["flat or dome not stated"]
    if row.text("geometry") == "dome" and radius is None:
        return ["radius of curvature unknown and no diameter given"]
    return ["thickness and diameter unknown"] if thickness is None else []


def _radius(row: PartRow, origin: Origin) -> Quantity | None:
    """Radius of curvature of a dome: as stated; between stated ends; else by its nominal diameter D.

    A hemisphere of a tube series has R a little below D / 2 (the wall may lie inside); a spherical cap of a photo
    port any from D / 2 up, in practice to 3/4 D. The centre of a range is the geometric mean of its ends.
    """
    low_mm, high_mm = row.number("outer_radius_low_mm"), row.number("outer_radius_high_mm")
    stated = known(row, "outer_radius_mm", origin)
    if stated is None and low_mm is not None and high_mm is not None:
        return Quantity(math.sqrt(low_mm * high_mm), low_mm, high_mm, "derived", row.text("source_url"))
    if stated is not None or row.text("geometry") != "dome":
        return stated
    nominal_mm, mount = row.number("nominal_diameter_mm"), mount_table().get(row.text("mount"))
    if nominal_mm is None:
        return None
    shapes = {"tube series": "hemisphere", "photo housing": "spherical-cap"}
    name = shapes.get(mount.on if mount else "", "any")
    return required_class("port-outer-radius-over-nominal-diameter", name).quantity(nominal_mm)


def _clear_diameter(row: PartRow) -> Quantity | None:
    """Eight tenths of the nominal diameter; None where that is unknown too."""
    nominal_mm = row.number("nominal_diameter_mm")
    if nominal_mm is None:
        return None
    return required_class("port-clear-over-nominal-diameter", "any").quantity(nominal_mm)


def _index(row: PartRow, origin: Origin) -> Quantity | None:
    """The stated constant; None where a dispersion formula is named; else by material."""
    stated = known(row, "refractive_index", origin)
    if stated is not None or row.text("glass"):
        return stated
    return required_class("port-refractive-index", row.text("material"), "unknown").quantity()


def _diameter_mm(row: PartRow) -> float | None:
    clear_mm = row.number("clear_diameter_mm")
    return row.number("nominal_diameter_mm") if clear_mm is None else clear_mm


def _thickness(row: PartRow, radius: Quantity | None) -> Quantity | None:
    """Wall by the ratio of its class: to the outer radius of a dome, to the diameter of a flat window."""
    plastic = row.text("material") in (*PLASTICS, "")
    diameter_mm = _diameter_mm(row)
    if row.text("geometry") == "dome":
        if radius is None:
            return None
        return required_class("port-thickness-over-outer-radius", _wall_class(row, radius)).quantity(radius.value)
    if diameter_mm is None:
        return None
    name = "flat-acrylic" if plastic else "flat-fused-silica"
    return required_class("port-thickness-over-clear-diameter", name).quantity(diameter_mm)


def _wall_class(row: PartRow, radius: Quantity) -> str:
    """What kind of dome it is by material, purpose, size and whether it is rated."""
    if row.text("material") in (*PLASTICS, ""):
        return "shallow-acrylic-dome" if row.number("depth_rating_m") is None else "rated-plastic-dome"
    if row.text("purpose") == "photo port":
        return "photo-glass-dome"
    return "deep-glass-sphere" if radius.value > LARGE_SPHERE_RADIUS_MM else "small-deep-glass-dome"


def _mass(row: PartRow, radius: Quantity | None, thickness: Quantity | None) -> Quantity:
    """Density times the volume of the bare window or hemisphere; by class where its size is unknown."""
    density = first_class("port-density-kg-m3", row.text("material"))
    diameter_mm, is_dome = _diameter_mm(row), row.text("geometry") == "dome"
    if density is None or thickness is None or (radius if is_dome else diameter_mm) is None:
        return required_class("port-mass-g", "dome" if is_dome else "flat").quantity()

    def volume_mm3(wall_mm: float, radius_mm: float) -> float:
        if is_dome:
            inner_mm = max(radius_mm - wall_mm, 0.0)
            return 2.0 / 3.0 * math.pi * (radius_mm**3 - inner_mm**3)
        return math.pi / 4.0 * (diameter_mm or 0.0) ** 2 * wall_mm

    outer = radius or exact(0.0)
    ends = (
        (density.central, thickness.value, outer.value),
        (density.low, thickness.low, outer.low),
        (density.high, thickness.high, outer.high),
    )
    masses = [rho * KG_M3_TO_G_MM3 * volume_mm3(wall_mm, radius_mm) for rho, wall_mm, radius_mm in ends]
    return Quantity(
        masses[0], masses[1], masses[2], "estimated", f"{density.key}: bare window, without flange"
    )


def _price_class(row: PartRow, radius: Quantity | None) -> ClassEstimate:
    material, radius_mm = row.text("material"), 0.0 if radius is None else radius.value
    diameter_mm = _diameter_mm(row)
    if row.text("geometry") == "dome":
        if material in (*PLASTICS, ""):
            name = "plastic-dome"
        else:
            is_sphere = radius_mm > LARGE_SPHERE_RADIUS_MM and row.text("purpose") != "photo port"
            name = "deep-glass-sphere" if is_sphere else "glass-dome"
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
