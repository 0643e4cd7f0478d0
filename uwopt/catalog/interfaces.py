"""Interfaces of cameras: how far their cables carry images to a computer."""

from __future__ import annotations

from functools import cache

from uwopt.catalog.tables import built_in_rows

LINK = "GigE"  # by which a computer beside the camera sends its images on


@cache
def reaches_m() -> dict[str, float]:
    """The longest passive cable of each interface of which that is known."""
    rows = built_in_rows("interfaces.csv")
    return {row["interface"]: float(row["reach_m"]) for row in rows if row["reach_m"]}


def does_reach(interface: str, cable_m: float | None) -> bool:
    """Whether a cable of this length carries the images; without a length the computer stands beside the camera."""
    return cable_m is None or cable_m <= reaches_m().get(interface, 0.0)
