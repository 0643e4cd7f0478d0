"""Light of all orders from a lamp to a given place, without asking a phase function for its forward peak.

A walk is begun at the lamp in any direction. Where it crosses the sphere about the lamp that goes through the place,
the whole walk is turned about the lamp until the crossing falls on the place; the direction in which it left then says
how much of the lamp's lobe it carries. That is exact: light that leaves a point evenly arrives evenly on a sphere, and
the lobe only weighs how it left. Every angle is drawn, none is evaluated, so that no tail is heavier than 1/cos of the
crossing. Light that has not been scattered is added in closed form, and the first collision is forced.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .walk import Water, across, compiled, drawn_angle, phase_at, survivor, turned

MOST_STEPS = 400
LEAST_COS = 0.02  # crossings flatter than this count with their mean, 2 / LEAST_COS
INSIDE = 0.85  # share of the walks whose first collision is forced to lie within the sphere
FAR = 12.0  # attenuation lengths beyond the sphere from which a walk is not followed back
FAINT = 0.3  # weights below this share of the first survive by a draw


class Lamp(NamedTuple):
    """One lamp in the plane of the camera, which stands at the origin and looks along z; aim a unit vector."""

    x: float
    y: float
    aim_x: float
    aim_y: float
    aim_z: float
    exponent: float  # of its lobe cos^m


@compiled
def intensity(cos: float, lamp: Lamp) -> float:
    """Intensity per lumen [1/sr] of a lobe cos^m."""
    m = lamp.exponent
    return (m + 1.0) / (2.0 * np.pi) * cos**m if cos > 0.0 else 0.0


@compiled
def received(
    cos_in: float, vx: float, vy: float, vz: float, ox: float, oy: float, oz: float, water: Water, from_share: float
) -> float:
    """What a place makes of light that comes along v: the cosine on a floor, or the phase function towards o.

    `from_share` < 0: a floor. Else only turns beyond the angle of that share of the phase function count.
    """
    if from_share < 0.0:
        return max(vz, 0.0)
    cos = vx * ox + vy * oy + vz * oz
    return phase_at(cos, water) if cos < cos_in else 0.0


@compiled
def lamp_light(
    rng: Any, water: Water, lamp: Lamp, floor: float, x: float, y: float, z: float,
    ox: float, oy: float, oz: float, cos_in: float, from_share: float, path: Any, scattered: bool,
) -> tuple[float, float]:  # fmt: skip
    """Lamp light that arrives at a place without having touched the floor, per lumen: unscattered, and one walk.

    On a floor [1/m^2]; else what one scattering sends towards o per unit of b [1/(m^2 sr)]. `path` is a work space
    of (MOST_STEPS, 3) for the places of collisions.
    """
    tx, ty, tz = x - lamp.x, y - lamp.y, z
    r = np.sqrt(tx * tx + ty * ty + tz * tz)
    tx, ty, tz = tx / r, ty / r, tz / r
    straight = intensity(tx * lamp.aim_x + ty * lamp.aim_y + tz * lamp.aim_z, lamp) / (r * r)
    straight *= np.exp(-water.c * r) * received(cos_in, tx, ty, tz, ox, oy, oz, water, from_share)
    if not scattered:
        return straight, 0.0
    # the walk: lamp at the origin, first along z
    meets = -np.expm1(-water.c * r)
    if rng.random() < INSIDE:
        way, weight = -np.log1p(-rng.random() * meets) / water.c, meets / INSIDE
    else:
        way, weight = r - np.log(1.0 - rng.random()) / water.c, (1.0 - meets) / (1.0 - INSIDE)
    px, py, pz, dx, dy, dz = 0.0, 0.0, way, 0.0, 0.0, 1.0
    total, least = 0.0, FAINT * weight
    for n in range(MOST_STEPS):
        path[n, 0], path[n, 1], path[n, 2] = px, py, pz
        weight = survivor(rng, weight * water.albedo, least)
        if weight == 0.0:
            break
        dx, dy, dz = turned(rng, dx, dy, dz, drawn_angle(rng, water, 1.0))
        along = px * dx + py * dy + pz * dz
        square = along * along - (px * px + py * py + pz * pz) + r * r
        if square > 0.0:
            half = np.sqrt(square)
            for end in (-half, half):
                t = end - along
                if t > 0.0:
                    qx, qy, qz = (px + t * dx) / r, (py + t * dy) / r, (pz + t * dz) / r
                    cos = half / r
                    flat = 1.0 / cos if cos > LEAST_COS else 2.0 / LEAST_COS
                    carried = turned_over(
                        rng, water, lamp, floor, (qx, qy, qz), (dx, dy, dz), (tx, ty, tz), (ox, oy, oz),
                        cos_in, from_share, path, n + 1,
                    )  # fmt: skip
                    total += weight * np.exp(-water.c * t) * carried * flat / (r * r)
        way = -np.log(1.0 - rng.random()) / water.c
        px, py, pz = px + way * dx, py + way * dy, pz + way * dz
        if px * px + py * py + pz * pz > (r + FAR / water.c) ** 2:
            break
    return straight, total


@compiled
def turned_over(
    rng: Any, water: Water, lamp: Lamp, floor: float, crossing: Any, direction: Any, place: Any, out: Any,
    cos_in: float, from_share: float, path: Any, n: int,
) -> float:  # fmt: skip
    """What a walk carries once it is turned so that its crossing (a unit vector) falls on the place.

    Lobe times what the place makes of it; 0 where the turned walk goes through the floor.
    """
    qx, qy, qz = crossing
    dx, dy, dz = direction
    tx, ty, tz = place
    ax, ay, az, bx, by, bz = across(qx, qy, qz)
    fx, fy, fz, gx, gy, gz = across(tx, ty, tz)
    phi = 2.0 * np.pi * rng.random()
    cosine, sine = np.cos(phi), np.sin(phi)
    ux, uy, uz = cosine * fx + sine * gx, cosine * fy + sine * gy, cosine * fz + sine * gz
    wx, wy, wz = cosine * gx - sine * fx, cosine * gy - sine * fy, cosine * gz - sine * fz
    left = qz * (tx * lamp.aim_x + ty * lamp.aim_y + tz * lamp.aim_z)
    left += az * (ux * lamp.aim_x + uy * lamp.aim_y + uz * lamp.aim_z)
    left += bz * (wx * lamp.aim_x + wy * lamp.aim_y + wz * lamp.aim_z)
    carried = intensity(left, lamp)
    if carried == 0.0:
        return 0.0
    for k in range(n):
        s, p, q = path[k, 0], path[k, 1], path[k, 2]
        depth = (s * qx + p * qy + q * qz) * tz + (s * ax + p * ay + q * az) * uz + (s * bx + p * by + q * bz) * wz
        if depth >= floor:
            return 0.0
    s, p, q = dx * qx + dy * qy + dz * qz, dx * ax + dy * ay + dz * az, dx * bx + dy * by + dz * bz
    vx, vy, vz = s * tx + p * ux + q * wx, s * ty + p * uy + q * wy, s * tz + p * uz + q * wz
    return carried * received(cos_in, vx, vy, vz, out[0], out[1], out[2], water, from_share)
