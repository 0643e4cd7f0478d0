"""A pair of cameras side by side: what both see of the target's plane, and how well they tell its distance.

Two like cameras stand across the motion, the middles of their ports a baseline apart, each turned inward by half the
convergence about its port's middle. Everything here lies in the plane of both axes, y across, z along the middle
between the axes; the cameras mirror each other, so that the one at -B/2, which looks towards +y, stands for both.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.model import port
from uwopt.model.imaging import PortShape, ray_spread

PLACES = tuple(0.125 * place for place in range(9))  # from the middle of an image to the edge that looks farthest
NEWTON_STEPS = 12  # towards a ray behind a flat port: the error squares at each


class Pair(NamedTuple):
    """How two cameras stand: `baseline_m` between the middles of their ports, `turn_rad` of each, inward."""

    baseline_m: float
    turn_rad: float = 0.0


def ray_in_plane(tan_air: Array, *, shape: PortShape) -> tuple[Any, Any, Any, Any]:
    """Where a ray leaves the port's face off the axis [m], its tangent in water, and what both gain per tangent in air.

        a = u A,   w = u W  (A, W of `ray_spread`);   dome: a' = R, w' = 1;
        flat: a' = e + t_g n_g^2 / (n_g^2 + (n_g^2 - 1) u^2)^(3/2),   w' = n_w^2 / (n_w^2 + (n_w^2 - 1) u^2)^(3/2)

    tan_air : (...,) u. Exact Snell rays; physics page, section 4.
    """
    if shape.is_dome:
        return tan_air * shape.outer_radius_m, tan_air, shape.outer_radius_m, 1.0
    (start, end), (start_rise, end_rise) = (  # at the face; what a metre of water adds is the difference
        [at(tan_air, range_m=range_m, **shape.plates) for range_m in (0.0, 1.0)]
        for at in (port.flat_floor_distance_m, port.flat_floor_derivative)
    )
    return start, end - start, start_rise, end_rise - start_rise


def meeting_m(tan_air: Array, *, shape: PortShape, range_m: Any, turn_rad: float) -> Array:
    """Where rays of a camera that is turned towards +y meet the plane z = d, across from its port's middle [m].

        s = (d + a sin phi) / (cos phi - w sin phi),   y = a cos phi + s (w cos phi + sin phi)

    Parameters
    ----------
    tan_air : (...,) u, towards +y on the side to which the camera is turned
    range_m : broadcast [m], d from the port's middle
    turn_rad : phi

    Returns
    -------
    (...,) [m]; inf of a ray that never meets it.

    References
    ----------
    Plane geometry: rays of `ray_in_plane`, turned by phi about the port's middle.
    """
    sin, cos = np.sin(turn_rad), np.cos(turn_rad)
    start, water, _, _ = ray_in_plane(tan_air, shape=shape)
    fall = cos - water * sin
    with np.errstate(divide="ignore", invalid="ignore"):
        way = np.where(fall > 0.0, (range_m + start * sin) / fall, np.inf)
        return np.asarray(np.where(fall > 0.0, start * cos + way * (water * cos + sin), np.inf))


def common_width_m(tan_across: Array, *, shape: PortShape, range_m: Any, pair: Pair) -> Array:
    """How wide a strip of the plane both cameras see, across the motion.

        W = 2 max(0, min(y(+u) - B/2, B/2 - y(-u)));   cameras not turned: the footprint less B

    Parameters
    ----------
    tan_across : (n, 1) tangent in air of the half angle of view across
    range_m : (k,) [m]

    Returns
    -------
    (n, k) [m], 0 where nothing is seen by both.

    Notes
    -----
    In the middle of the image along the motion. Each end is linear in d: over a band of altitudes the least is at one
    of its ends.
    """
    far, near = (
        meeting_m(side * tan_across, shape=shape, range_m=range_m, turn_rad=pair.turn_rad) for side in (1.0, -1.0)
    )
    half = np.minimum(far - 0.5 * pair.baseline_m, 0.5 * pair.baseline_m - near)
    return np.asarray(2.0 * np.maximum(half, 0.0))


def ray_to(y_m: Array, *, shape: PortShape, range_m: Any, turn_rad: float) -> Array:
    """Tangent in air of the ray that reaches a place of the plane, y across from the camera's own port [m].

    In the camera's frame the place is at (y cos phi - d sin phi, y sin phi + d cos phi) = (p, q): u A + q u W = p.
    A dome's answer is p / (q + R); behind a flat port the left side bends down from its tangent at 0, so that Newton's
    steps from there rise to the ray and never pass it.
    """
    sin, cos = np.sin(turn_rad), np.cos(turn_rad)
    aside, away = y_m * cos - range_m * sin, y_m * sin + range_m * cos
    start, per_m = ray_spread(np.zeros(()), shape)
    tan_air = aside / (start + away * per_m)
    for _ in range(0 if shape.is_dome else NEWTON_STEPS):
        a, w, a_rise, w_rise = ray_in_plane(tan_air, shape=shape)
        tan_air = tan_air + (aside - a - away * w) / (a_rise + away * w_rise)
    return np.asarray(tan_air)


def ray_step(y_m: Array, *, shape: PortShape, range_m: Any, turn_rad: float) -> tuple[Array, Array]:
    """Of the ray to a place of the plane: how far across its end moves per tangent in air [m], and its tangent to z."""
    sin, cos = np.sin(turn_rad), np.cos(turn_rad)
    a, w, a_rise, w_rise = ray_in_plane(ray_to(y_m, shape=shape, range_m=range_m, turn_rad=turn_rad), shape=shape)
    fall = cos - w * sin
    way = (range_m + a * sin) / fall
    way_rise = (a_rise * fall * sin + (range_m + a * sin) * w_rise * sin) / np.square(fall)
    return a_rise * cos + way_rise * (w * cos + sin) + way * w_rise * cos, (w * cos + sin) / fall


def largest_step_m(tan_across: Array, *, shape: PortShape, range_m: Any, turn_rad: float) -> Array:
    """The most that a tangent in air moves the end of a turned camera's ray across the plane, over its image [m].

        dome: (d + R cos phi) / (cos phi - u sin phi)^2, u at the edge that looks farthest;   flat: the most at PLACES

    Parameters
    ----------
    tan_across : (n, 1) tangent in air of the half angle of view across
    range_m : (k,) [m]

    Returns
    -------
    (n, k) [m] per tangent; times a pixel's tangent its ground sample. inf where the edge never meets the plane.

    Notes
    -----
    In the middle of the image along the motion; corners have up to (tan_along sin phi)^2 / 2 of it more.

    References
    ----------
    Derivative of `meeting_m` by u.
    """
    steps = [
        np.where(np.isfinite(end), ray_step(end, shape=shape, range_m=range_m, turn_rad=turn_rad)[0], np.inf)
        for end in (
            meeting_m(share * tan_across, shape=shape, range_m=range_m, turn_rad=turn_rad) for share in PLACES
        )
    ]
    return np.asarray(np.max(steps, axis=0))


def depth_error_m(
    y_m: Array, *, shape: PortShape, range_m: Any, pair: Pair, tan_per_px: Any, disparity_error_px: float
) -> Array:
    """Standard error of the distance of a point that both cameras see.

        sigma_z = sigma_d sqrt((g_1^2 + g_2^2) / 2) / (tan alpha_1 - tan alpha_2)

    g_i is what a pixel moves the end of camera i's ray across the plane, alpha_i the ray's angle in the water, from z.
    Cameras that are not turned, behind domes: sigma_z = sigma_d (p / f) (d + R)^2 / B, the well known Z^2 / (B f)
    times the disparity's error; behind flat ports near the middle n_w f takes the place of f, and
    d + n_w (e + t_g / n_g) that of Z. Turned by phi, of points on the middle line, with alpha = atan(B / 2 Z) and
    pupils at the ports: sigma_z = sigma_d (p / f) (Z^2 + B^2 / 4) cos^2(alpha - phi) / B.

    Parameters
    ----------
    y_m : (...,) [m], the point's place across from the middle between the cameras; seen by both
    range_m : broadcast [m], d
    tan_per_px : broadcast, p / f
    disparity_error_px : sigma_d [px], the standard error of the difference of both images' places; half of its square
        belongs to each

    Returns
    -------
    (...,) [m], one standard error.

    Notes
    -----
    Random error of matching alone, to first order: neither calibration nor the way the cameras stand is in error.
    Derived from the meeting of two straight rays in water; held against traced rays with shifted pixels in the tests.
    """
    half, scale = 0.5 * pair.baseline_m, dict(shape=shape, range_m=range_m, turn_rad=pair.turn_rad)
    step, slope = ray_step(y_m + half, **scale)
    other_step, other_slope = ray_step(half - y_m, **scale)  # mirrored: its tangent counts the other way
    spread = np.sqrt(0.5 * (np.square(step) + np.square(other_step))) * tan_per_px
    return np.asarray(disparity_error_px * spread / (slope + other_slope))
