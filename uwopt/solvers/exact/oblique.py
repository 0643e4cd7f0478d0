"""Bounds of the light that oblique views take from a tilted plane: how far images reach, how densely they sample it.

With q = u^2 + v^2 and A, W of `imaging.ray_spread`, F = (A + d W) / D, D = 1 - s u W (see `footprint.floor_steps`),
a patch of the plane holds so many samples of an image that is sampled evenly in its tangents:

    1 / (4 U V J),   J = sqrt(1 + s^2) (A + d W) (A' + d W' + s u (W' A - W A')) / D^3,   A' = A + 2 q dA/dq

    D = E / (E + s x),   E = d + A / W,   x the place on the plane forward of the axis

so that what depends on the place can be told for all ports at once, between the least and the greatest E.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.problem import Problem
from uwopt.model import port
from uwopt.model.imaging import PortShape, descent, ray_spread

BESIDE_PORT = 1e-6  # places at the port's own distance, which images behind other ports alone may reach


class PlaneReach(NamedTuple):
    """How far images reach on the plane from where the axis meets it [m], no less; and their densest samples there."""

    ahead_m: Array
    across_ahead_m: Array  # half the width, of the part ahead
    behind_m: Array
    across_behind_m: Array
    samples_per_m2: Array  # at x = 0; elsewhere times `crowding`


def reach_of(tan_along: Array, tan_across: Array, *, least: PortShape, most: PortShape, range_m: float) -> PlaneReach:
    """Upper bounds for images behind ports that start rays no nearer to the axis than `least`, no farther than `most`.

    tan_along, tan_across : (n,) tangents of the half angles; numbers of the shapes : scalars or (n,)
    """
    u, v, slope = tan_along, tan_across, most.slope
    secant = np.hypot(1.0, slope)
    (start_u, per_u), (start_v, per_v) = (ray_spread(np.square(t), most) for t in (u, v))
    corner = np.square(u) + np.square(v)
    start_c, per_c = ray_spread(corner, least)
    fall = descent(u, per_u, slope)
    wide_m = v * (start_v + range_m * per_v)
    if most.is_dome:
        steep_m, twist_m = start_c + range_m, 0.0
    else:
        glass = 1.0 / port.bend(corner, n=least.n_glass)
        steep_m = least.gap_m + least.thickness_m * least.n_glass**2 * glass**3
        steep_m = steep_m + range_m * least.n_water**2 * per_c**3
        at_axis_m, per_axis = ray_spread(np.zeros_like(u), most)
        twist_m = slope * u * at_axis_m * per_axis
    spread_m2 = (start_c + range_m * per_c) * np.maximum(steep_m - twist_m, 1e-12)
    return PlaneReach(
        ahead_m=secant * u * (start_u + range_m * per_u) / fall, across_ahead_m=wide_m / fall,
        behind_m=secant * u * (start_u + range_m * per_u) / (1.0 + slope * u * per_c), across_behind_m=wide_m,
        samples_per_m2=1.0 / (4.0 * u * v * secant * spread_m2),
    )  # fmt: skip


def least_oblique_pixel_m(tan_along: Array, *, least: PortShape, range_m: Any) -> Array:
    """Lower bound of the largest pixel over its tangent: in the middle, or far, where the port may add nothing.

        at the far edge   sqrt(1 + s^2) (A' + d W' + s u (W' A - W A')) / D^2
    """
    slope, u = least.slope, tan_along
    start_m, per_axis = ray_spread(0.0 * u, least)
    middle = start_m + range_m * per_axis
    per_m = ray_spread(np.square(u), least)[1]
    edge = middle if least.is_dome else range_m * least.n_water**2 * per_m**3
    return np.asarray(np.hypot(1.0, slope) * np.maximum(middle, edge / np.square(descent(u, per_m, slope))))


def most_oblique_pixels_m(tan_along: Array, *, most: PortShape, range_m: Any) -> tuple[Array, Array]:
    """Upper bounds of the smallest pixels along and across over their tangent: those in the middle of the near edge."""
    slope, u = most.slope, tan_along
    start_m, _ = ray_spread(0.0 * u, most)
    per_m = ray_spread(np.square(u), most)[1]
    near = 1.0 + slope * u * per_m
    deep = (start_m + range_m * per_m) / np.square(near)
    if not most.is_dome:
        deep = start_m / near + range_m * most.n_water**2 * per_m**3 / np.square(near)
    return np.asarray(np.hypot(1.0, slope) * deep), np.asarray((start_m + range_m * per_m) / near)


def crowding(along_m: Array, slope: float, range_m: float, deepest_m: float) -> Array:
    """Most samples at places (...,) along the plane over those where the axis meets it: (E / (E + s x))^3."""
    x_m = along_m / np.hypot(1.0, slope)
    centre_m = np.where(x_m >= 0.0, range_m + deepest_m, range_m)
    return np.asarray((centre_m / np.maximum(centre_m + slope * x_m, BESIDE_PORT * centre_m)) ** 3)


def deepest_m(problem: Problem, scene_index: int) -> float:
    """The most that A / W is: how far behind the port rays seem to meet the axis."""
    ports, n_water = problem.ports, problem.scenes[scene_index].n_water
    bent = port.bend(problem.widest_tangent**2, n=n_water)
    flat_m = (ports.gap_m + ports.thickness_m) * bent
    return float(np.where(ports.is_dome, ports.outer_radius_m, flat_m).max(initial=0.0))


def path_and_field(
    along_m: tuple[Array, Array], across_m: Array, *, slope: float, range_m: float, deepest_m: float
) -> tuple[Array, Array]:
    """Least path of a ray to a cell of the plane [m], and the least square of its tangent from the axis.

        path >= z sqrt(1 + (r / (z + E - d))^2),   z = d + s x: behind a flat port it is that, behind a dome more

    along_m : the cells' nearer and farther edge along the plane, signed; across_m : their nearer edge across
    """
    near_m, far_m = (edge / np.hypot(1.0, slope) for edge in along_m)
    low_m, high_m = np.maximum(range_m + slope * near_m, 0.0), range_m + slope * far_m
    aside2 = np.where(near_m * far_m < 0.0, 0.0, np.minimum(np.square(near_m), np.square(far_m))) + np.square(across_m)
    field2 = aside2 / np.square(high_m + deepest_m)
    return low_m * np.sqrt(1.0 + field2), field2
