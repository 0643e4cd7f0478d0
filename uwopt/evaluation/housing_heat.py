"""How warm the air around a camera may become in its housing, as totals name it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uwopt.catalog.estimates import required_class
from uwopt.catalog.parts.quantity import exact
from uwopt.catalog.records import Housing, Quantity
from uwopt.forward.designs import Hardware
from uwopt.forward.problem import Problem
from uwopt.model.housing_heat import cooled_m2, warmer_k


def heated(problem: Problem, hardware: Hardware, drawn_w: Mapping[str, float]) -> dict[str, Any]:
    """Heat in each housing [W], and by how much its air is warmer than the water, at the least and the most [K].

    A computer heats it only where its cable does not leave it. Nothing without a housing whose size and wall are known.

    drawn_w : mean power by what draws it, of all cameras
    """
    port, camera = problem.parts.ports[hardware.port], problem.parts.cameras[hardware.camera]
    housing = port.housing
    if housing is None or port.complete or housing.inner_diameter_mm is None:
        return {}
    is_tube, wall = housing.shape != "sphere", wall_of(housing, housing.inner_diameter_mm)
    if wall is None or (is_tube and housing.inner_length_mm is None):
        return {}
    inside = problem.beside_camera(camera)
    heat_w = (drawn_w["camera"] + (drawn_w["computer"] if inside else 0.0)) / problem.mission.vehicle.camera_count
    cooled = cooled_m2(1e-3 * housing.inner_diameter_mm, 1e-3 * (housing.inner_length_mm or 0.0) if is_tube else None)
    lead = required_class("housing-conductivity-w-mk", housing.material, "unknown")
    air, water = required_class("housing-air-w-m2k", "any"), required_class("housing-water-w-m2k", "any")

    def warmer(end: str) -> float:
        """At the ends of what is not known that leave it coolest or warmest."""
        thick_mm = getattr(wall, "low" if end == "high" else "high")
        return warmer_k(
            heat_w, cooled, wall_m=1e-3 * thick_mm, conductivity_w_mk=getattr(lead, end),
            air_w_m2k=getattr(air, end), water_w_m2k=getattr(water, end),
        )  # fmt: skip

    return {"housing_heat_w": heat_w, "housing_warmer_k": [warmer("high"), warmer("low")]}


def wall_of(housing: Housing, inner_mm: float) -> Quantity | None:
    """The thickness of its wall, stated or half of what the diameters differ by; None where that is not known [mm]."""
    if housing.wall_mm is not None or housing.outer_diameter_mm is None:
        return housing.wall_mm
    half_mm = 0.5 * (housing.outer_diameter_mm.value - inner_mm)
    return exact(half_mm, housing.outer_diameter_mm.status) if half_mm > 0.0 else None
