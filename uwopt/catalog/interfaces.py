"""Interfaces of cameras: how far their cables carry images to a computer."""

from __future__ import annotations

from functools import cache

from uwopt.catalog.tables import built_in_rows

LINK = "GigE"  # by which a computer beside the camera sends its images on
#: Through two walls and the water between them a cable is no shorter (engineering assumption: two bulkhead connectors
#: with the bend of a cable behind each).
BETWEEN_HOUSINGS_M = 0.5
IN_HOUSING = "in the camera's housing"  # where a computer must stand that no cable reaches from there


@cache
def reaches_m() -> dict[str, float]:
    """The longest passive cable of each interface of which that is known."""
    rows = built_in_rows("interfaces.csv")
    return {row["interface"]: float(row["reach_m"]) for row in rows if row["reach_m"]}


@cache
def fed_v(interface: str) -> tuple[str, str]:
    """Lowest and highest voltage that cameras of an interface are fed with over its cable, as the table states them."""
    rows = {row["interface"]: row for row in built_in_rows("interfaces.csv")}
    row = rows.get(interface, {})
    return row.get("supply_v_min", ""), row.get("supply_v_max", "")


def does_reach(interface: str, cable_m: float | None) -> bool:
    """Whether a cable of this length carries the images; without a length the computer stands beside the camera."""
    return cable_m is None or cable_m <= reaches_m().get(interface, 0.0)


def leaves_housing(interface: str) -> bool:
    """Whether a cable of this interface gets from one housing to another; of an unknown reach nothing is held."""
    return reaches_m().get(interface, BETWEEN_HOUSINGS_M) >= BETWEEN_HOUSINGS_M


def shares_computer(interface: str, cable_m: float | None, camera_count: int) -> bool:
    """Whether one computer takes the images of all cameras, each of which has a housing of its own."""
    return does_reach(interface, cable_m) and (camera_count == 1 or leaves_housing(interface))
