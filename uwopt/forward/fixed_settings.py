"""Settings that a mission fixes: which parts can be set so, and their columns as if they could not be set otherwise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from uwopt.catalog.parts.light import NO_LAMP
from uwopt.catalog.records import Camera, Complete, Lens, Light, Part
from uwopt.forward.part_columns import Cameras, Lights
from uwopt.forward.part_rows import number
from uwopt.mission.fixed import US_PER_MS, Fixed
from uwopt.tolerances import ROUND
from uwopt.units import db_to_ratio

UNKNOWN_F_NUMBER = (1.0, 16.0)  # of a lens, as its columns have it


def at_exposure(cameras: Cameras, exposure_ms: float | None) -> Cameras:
    """Cameras with no other exposure; one that does not reach it has none."""
    if exposure_ms is None:
        return cameras
    fixed_s = 1e-3 * exposure_ms
    return replace(
        cameras,
        min_exposure_s=np.maximum(cameras.min_exposure_s, fixed_s),
        max_exposure_s=np.minimum(cameras.max_exposure_s, fixed_s),
    )


def at_level(lights: Lights, level: float | None) -> Lights:
    """Lights with no other level."""
    if level is None:
        return lights
    count = len(lights.min_level)
    return replace(lights, levels=np.full((count, 1), level), dims_freely=np.zeros(count, bool))


def cannot_be_set(part: Part, fixed: Fixed) -> str:
    """Why a part cannot be set as a mission fixes it; "" where it can."""
    if isinstance(part, Complete):
        return next(filter(None, (cannot_be_set(piece, fixed) for piece in part.pieces)), "")
    for name, value in fixed.given():
        low, high = reach(part, name, value)
        if not low <= value * ROUND or not value <= high * ROUND:
            return f"cannot be set to {name} {value:g}: it has {low:g} to {high:g}"
    return ""


def reach(part: Part, name: str, value: float) -> tuple[float, float]:
    """Least and most of one setting that a part has; without end where it is a setting of another kind of part."""
    if isinstance(part, Lens) and name == "f_number":
        return number(part.f_number_min, *UNKNOWN_F_NUMBER[:1]), number(
            part.f_number_max, *UNKNOWN_F_NUMBER[1:]
        )
    if isinstance(part, Camera) and name == "exposure_ms":
        shortest_us, longest_us = number(part.min_exposure_us, 0.0), number(part.max_exposure_us, np.inf)
        return shortest_us / US_PER_MS, longest_us / US_PER_MS
    if isinstance(part, Camera) and name == "gain":
        return 1.0, float(db_to_ratio(number(part.max_gain_db, 0.0)))
    if isinstance(part, Light) and name == "dim_frac" and part.id != NO_LAMP.id:
        if part.dim_levels is None:
            return number(part.dim_min_frac, 0.0), 1.0
        nearest = min(part.dim_levels, key=lambda step: abs(step - value))
        return nearest, nearest
    return 0.0, np.inf
