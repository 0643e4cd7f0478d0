"""What is stated of a housing becomes a `Housing`: wall, size, mass and price by its material where it is silent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwopt.catalog.estimates import ClassEstimate, first_class, required_class
from uwopt.catalog.parts.housing import Housing
from uwopt.catalog.parts.quantity import Quantity, Status
from uwopt.catalog.readers.reading import Built, Origin, Reader, identity, inline_fields, known, row_fields
from uwopt.catalog.userparts import PartRow
from uwopt.model import hull

KG_M3_TO_G_MM3 = 1e-6
MPA, GPA = 1e6, 1e9


@dataclass(frozen=True, slots=True)
class Material:
    """What a wall is made of."""

    yield_pa: float
    young_pa: float
    poisson: float
    density: ClassEstimate

    @staticmethod
    def of(name: str) -> Material:
        """The material of that name, aluminium where it is not known."""

        def value(prefix: str) -> ClassEstimate:
            return required_class(f"housing-{prefix}", name, "unknown")

        return Material(
            value("yield-mpa").central * MPA, value("young-gpa").central * GPA, value("poisson").central,
            value("density-kg-m3"),
        )  # fmt: skip


def from_row(row: PartRow, origin: Origin) -> Built:
    """The housing of a row, with what the model needs filled in."""
    material = Material.of(row.text("material"))
    is_tube = row.text("shape") != "sphere"
    wall = known(row, "wall_mm", origin) or _wall(row, material)
    cap_mm = _cap_mm(row, material) if is_tube else 0.0
    mass = _mass(row, material, wall, cap_mm)
    made = row_fields(Housing, row, origin, ())
    made |= identity(row, origin, _price(row, origin, made.get("mass_g") or mass), "USD", mass)
    made |= {"wall_mm": wall}
    made |= _outer_sizes(row, origin, wall, cap_mm)
    return Built(Housing(**made), tuple(_lacking(row, is_tube)))


def _lacking(row: PartRow, is_tube: bool) -> list[str]:
    lacks = []
    if row.number("inner_diameter_mm") is None:
        lacks.append("inner diameter unknown")
    if is_tube and row.number("inner_length_mm") is None:
        lacks.append("length inside unknown")
    if not row.items("ports"):
        lacks.append("no port is known to fit")
    return lacks


def _design_pressure_pa(row: PartRow) -> float | None:
    depth_m = row.number("depth_rating_m")
    return None if depth_m is None else hull.pressure_pa(depth_m) * required_class("housing-safety", "any").central


def _wall(row: PartRow, material: Material) -> Quantity | None:
    """Half of what the diameters differ by, else what its depth needs; None where nothing tells."""
    inner, outer, pressure = row.number("inner_diameter_mm"), row.number("outer_diameter_mm"), _design_pressure_pa(row)
    if inner is None:
        return None
    if outer is not None:
        half = 0.5 * (outer - inner)
        return Quantity(half, half, half, "derived", "half of outer less inner diameter") if half > 0.0 else None
    if pressure is None:
        return None
    wall = hull.tube_wall_mm(
        inner, pressure_pa=pressure, yield_pa=material.yield_pa, young_pa=material.young_pa, poisson=material.poisson
    )
    if not math.isfinite(wall):
        return None
    return Quantity(wall, wall, 1.5 * wall, "estimated", "housing-safety-any: neither buckles nor yields at depth")


def _cap_mm(row: PartRow, material: Material) -> float:
    inner, pressure = row.number("inner_diameter_mm"), _design_pressure_pa(row)
    if inner is None or pressure is None:
        return 0.0
    return hull.cap_thickness_mm(inner, pressure_pa=pressure, yield_pa=material.yield_pa, poisson=material.poisson)


def _outer_sizes(row: PartRow, origin: Origin, wall: Quantity | None, cap_mm: float) -> dict[str, Quantity | None]:
    inner, length = row.number("inner_diameter_mm") or 0.0, row.number("inner_length_mm") or 0.0
    thick = Quantity(0.0, 0.0, 0.0, "estimated") if wall is None else wall
    source = f"inside and walls; {thick.source}"
    width = Quantity(
        inner + 2.0 * thick.value, inner + 2.0 * thick.low, inner + 2.0 * thick.high, "estimated", source
    )
    flange = required_class("housing-flange-mm", "any")  # of two end caps beside the tube
    over = Quantity(
        length + 2.0 * cap_mm + flange.central, length + 2.0 * cap_mm + flange.low,
        length + 2.0 * cap_mm + flange.high, "estimated", f"{flange.key}: {flange.basis}",
    )  # fmt: skip
    stated = {"outer_diameter_mm": width, "outer_length_mm": over if row.text("shape") != "sphere" else width}
    return {name: known(row, name, origin) or other for name, other in stated.items()}


def _mass(row: PartRow, material: Material, wall: Quantity | None, cap_mm: float) -> Quantity:
    """Density times the volume of tube and end caps, with bolts and seals; by class where its size is unknown."""
    inner, length = row.number("inner_diameter_mm"), row.number("inner_length_mm")
    if inner is None or wall is None:
        return required_class("housing-mass-g", "any").quantity()
    if row.text("shape") == "sphere":
        bulk = math.pi / 6.0 * ((inner + 2.0 * wall.value) ** 3 - inner**3)
    else:
        bulk = hull.tube_material_mm3(inner, inner_length_mm=length or 0.0, wall_mm=wall.value, cap_mm=cap_mm)
    return required_class("housing-mass-over-bulk", "any").quantity(material.density.central * KG_M3_TO_G_MM3 * bulk)


def _price(row: PartRow, origin: Origin, mass: Quantity) -> Quantity:
    """Work on one housing, and its material by the kilogram; three digits are more than anybody knows of it."""
    name = row.text("material")
    work = required_class("housing-price-work", name, "unknown")
    by_kg = first_class("housing-price-per-kg", name) or required_class("housing-price-per-kg", "unknown")
    kg = mass.value * 1e-3
    exact = (work.central + kg * by_kg.central, work.low + kg * by_kg.low, work.high + kg * by_kg.high)
    ends = [float(f"{price:.3g}") for price in exact]
    status: Status = "generic" if origin == "generic" else "estimated"
    return Quantity(ends[0], ends[1], ends[2], status, f"{work.key} and {by_kg.key}: {work.basis}")


def from_inline(values: Mapping[str, Any], base_dir: Path | None) -> Housing:
    """The record of an inline housing."""
    return Housing(**inline_fields(Housing, "housing", values))


READER = Reader(from_row, from_inline)
