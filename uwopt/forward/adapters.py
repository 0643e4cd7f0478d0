"""Adapter flanges: what stands between a port and a housing that is narrower than it."""

from __future__ import annotations

from dataclasses import dataclass

from uwopt.catalog.choose import matches
from uwopt.catalog.estimates import required_class
from uwopt.catalog.parts.housing import ANY_PORT
from uwopt.catalog.records import Port, Quantity, exact
from uwopt.catalog.rest import depth_class

ESTIMATED_AT_MM = 200.0  # diameter that the class estimates are for; the plate's area counts


@dataclass(frozen=True)
class Adapter:
    """One flange between a port and its housing."""

    wide_mm: float
    price: Quantity  # in USD
    mass_g: Quantity
    displaced_g: Quantity  # of seawater


NO_ADAPTER = Adapter(0.0, exact(0.0), exact(0.0), exact(0.0))


def flange_mm(port: Port) -> float:
    """Outer diameter of the adapter that a port needs on its housing; 0 where none stands between.

    An end cap is made for any port that is no wider than the tube, and a port that a housing names has its own.
    """
    housing = port.housing
    if housing is None or housing.outer_diameter_mm is None or housing.shape == "sphere":
        return 0.0
    if any(matches(pattern, port) for pattern in housing.ports if pattern != ANY_PORT):
        return 0.0
    wide_mm = port.outer_width_mm
    return wide_mm if wide_mm is not None and wide_mm > housing.outer_diameter_mm.value else 0.0


def adapter_of(port: Port) -> Adapter | None:
    """The adapter between a port and its housing, by depth and area; None where none is needed."""
    wide_mm = flange_mm(port)
    if wide_mm == 0.0 or port.housing is None:
        return None
    kind, area = f"adapter-{depth_class(port.housing.depth_rating_m)}", (wide_mm / ESTIMATED_AT_MM) ** 2
    mass_g = required_class("housing-mass-g", kind).quantity(area)
    return Adapter(
        wide_mm, required_class("housing-price", kind).quantity(area), mass_g,
        required_class("housing-displaced-over-mass", kind).quantity(mass_g.value),
    )  # fmt: skip
