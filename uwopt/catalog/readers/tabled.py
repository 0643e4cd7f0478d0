"""Curves that ship with uwopt and that parts name by id: quantum efficiencies and beam profiles."""

from __future__ import annotations

from functools import cache

from uwopt.catalog.parts.quantity import Curve
from uwopt.catalog.tables import built_in_rows

Points = list[tuple[float, float]]


@cache
def efficiencies() -> dict[str, dict[str, Curve]]:
    """Quantum efficiency by id and channel."""
    points: dict[str, dict[str, Points]] = {}
    for row in built_in_rows("qe_curves.csv"):
        channels = points.setdefault(row["curve_id"], {})
        channels.setdefault(row["channel"], []).append((float(row["wavelength_nm"]), float(row["qe"])))
    return {
        curve_id: {channel: _curve(values) for channel, values in channels.items()}
        for curve_id, channels in points.items()
    }


@cache
def beam_profiles() -> dict[str, tuple[Curve, bool]]:
    """Intensity over the angle from the axis, and whether it is in candela, by id."""
    points: dict[str, Points] = {}
    is_candela: dict[str, bool] = {}
    for row in built_in_rows("beam_profiles.csv"):
        points.setdefault(row["profile_id"], []).append((float(row["angle_deg"]), float(row["intensity"])))
        is_candela[row["profile_id"]] = row["unit"] == "candela"
    return {name: (_curve(values), is_candela[name]) for name, values in points.items()}


def _curve(points: Points) -> Curve:
    return Curve(tuple(x for x, _ in points), tuple(y for _, y in points))
