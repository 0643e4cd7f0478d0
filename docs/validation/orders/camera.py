"""What a pinhole camera sees of lamp light of all orders: signal, forward veil, backscatter.

Walks begin at the camera and go the light's way backwards. Signal: light that comes from the floor without being
scattered again, whatever happened to it before. Forward veil: what was scattered on its way from the floor.
Backscatter: what never touched the floor. Where a walk meets the floor it asks `lamps.lamp_light` for all light
that comes there, and goes on from there, reflected, for light that touches the floor more than once.

Backscatter is counted by its last large turn (seen from the camera the first one): walks from the camera turn by
little, walks from the lamp by anything, and where they meet the phase function is asked for a turn of more than
TURN_DEG. What comes back by small turns alone is left out; `checks` says how little that is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .lamps import MOST_STEPS, Lamp, lamp_light
from .walk import Water, compiled, drawn_angle, survivor, turned

TURN_DEG = 35.0
BATCHES = 32
NEAR_RAD = (np.deg2rad(0.1), np.deg2rad(0.5), np.deg2rad(2.0))  # shares of the veil that arrive so near
N_TALLIES = 3 + len(NEAR_RAD)
LEAST = 0.2  # weights below this share of the first survive by a draw
STEP_U, STEP_V = 0.7548776662466927, 0.5698402909980532  # of places that fill a square evenly (Roberts 2018)


class View(NamedTuple):
    """A pinhole image over an even floor: half widths as tangents, height, and what the floor reflects."""

    tan_x: float
    tan_y: float
    floor: float  # [m] below camera and lamp
    reflectance: float


@compiled
def floor_radiance(
    rng: Any, water: Water, lamp: Lamp, view: View, x: float, y: float, path: Any
) -> float:  # fmt: skip
    """Radiance [1/(m^2 sr)] of a floor place per lumen, all touches of the floor."""
    total, weight = 0.0, view.reflectance
    while weight > 0.0:
        straight, scattered = lamp_light(
            rng, water, lamp, view.floor, x, y, view.floor, 0.0, 0.0, 0.0, 0.0, -1.0, path, True
        )
        total += weight / np.pi * (straight + scattered)
        x, y, back = next_touch(rng, water, view, x, y)
        weight *= view.reflectance * back
    return total


@compiled
def next_touch(rng: Any, water: Water, view: View, x: float, y: float) -> tuple[float, float, float]:
    """Where a walk that leaves the floor evenly touches it again, and 1; or 0 where it does not."""
    z = view.floor
    dz = -np.sqrt(rng.random())
    phi = 2.0 * np.pi * rng.random()
    sine = np.sqrt(1.0 - dz * dz)
    return to_floor(rng, water, view, x, y, z, sine * np.cos(phi), sine * np.sin(phi), dz, 1.0)[:3]


@compiled
def to_floor(
    rng: Any, water: Water, view: View, x: float, y: float, z: float, dx: float, dy: float, dz: float, weight: float
) -> tuple[float, float, float]:
    """Follows a walk through the water until it touches the floor: place, and its weight there or 0."""
    first = weight
    for _ in range(MOST_STEPS):
        way = -np.log(1.0 - rng.random()) / water.c
        if dz > 0.0 and way * dz >= view.floor - z:
            way = (view.floor - z) / dz
            return x + way * dx, y + way * dy, weight
        x, y, z = x + way * dx, y + way * dy, z + way * dz
        weight = survivor(rng, weight * water.albedo, LEAST * first)
        if weight == 0.0 or view.floor - z > 4.0 * view.floor + 12.0 / water.c:
            break
        dx, dy, dz = turned(rng, dx, dy, dz, drawn_angle(rng, water, 1.0))
    return x, y, 0.0


@compiled
def veil_of(
    rng: Any, water: Water, lamp: Lamp, view: View, ux: float, uy: float, uz: float, path: Any, out: Any
) -> None:
    """Adds one walk's forward veil to `out[1]`, and to `out[3:]` what arrives near the pixel's own ray."""
    reach = view.floor / uz
    weight = -np.expm1(-water.c * reach)
    way = -np.log1p(-rng.random() * weight) / water.c
    dx, dy, dz = turned(rng, ux, uy, uz, drawn_angle(rng, water, 1.0))
    x, y, weight = to_floor(
        rng, water, view, way * ux, way * uy, way * uz, dx, dy, dz, weight * water.albedo
    )
    if weight == 0.0:
        return
    seen = weight * floor_radiance(rng, water, lamp, view, x, y, path)
    out[1] += seen
    qx, qy, qz = uy * view.floor - uz * y, uz * x - ux * view.floor, ux * y - uy * x
    sine = np.sqrt((qx * qx + qy * qy + qz * qz) / (x * x + y * y + view.floor**2))
    for k in range(len(NEAR_RAD)):
        if sine < NEAR_RAD[k]:
            out[3 + k] += seen


@compiled
def backscatter_of(
    rng: Any, water: Water, lamp: Lamp, view: View, ux: float, uy: float, uz: float, path: Any, orders: int,
    cos_in: float, small: float,
) -> float:  # fmt: skip
    """One walk's backscatter [1/(m^2 sr)]: on each of its straight pieces one place where it meets lamp light.

    orders : 1 follows single scattering only, as a check.
    """
    x, y, z, dx, dy, dz = 0.0, 0.0, 0.0, ux, uy, uz
    weight, total = 1.0, 0.0
    for _ in range(MOST_STEPS):
        end = (view.floor - z) / dz if dz > 0.0 else 12.0 / water.c
        t, density = place_on(rng, water.c, lamp.x - x, lamp.y - y, -z, dx, dy, dz, end)
        straight, scattered = lamp_light(
            rng, water, lamp, view.floor, x + t * dx, y + t * dy, z + t * dz, -dx, -dy, -dz, cos_in, small, path,
            orders > 1,
        )  # fmt: skip
        total += weight * np.exp(-water.c * t) * water.c * water.albedo / density * (straight + scattered)
        if orders == 1:
            break
        way = -np.log(1.0 - rng.random()) / water.c
        if way >= end:
            break
        x, y, z = x + way * dx, y + way * dy, z + way * dz
        weight = survivor(rng, weight * water.albedo * small, LEAST)
        if weight == 0.0:
            break
        dx, dy, dz = turned(rng, dx, dy, dz, drawn_angle(rng, water, small))
    return total


@compiled
def place_on(
    rng: Any, c: float, lx: float, ly: float, lz: float, dx: float, dy: float, dz: float, end: float
) -> tuple[float, float]:
    """A place on a straight piece, and its density [1/m]: half by angle seen from the lamp, half by attenuation.

    Kulla and Fajardo (2012), Comput. Graph. Forum 31, 1519: equal angles take the 1/r^2 of a near lamp away.
    """
    near = lx * dx + ly * dy + lz * dz
    aside = np.sqrt(max(lx * lx + ly * ly + lz * lz - near * near, 1e-18))
    low, high = np.arctan(-near / aside), np.arctan((end - near) / aside)
    whole = -np.expm1(-c * end)
    if rng.random() < 0.5:
        t = near + aside * np.tan(low + rng.random() * (high - low))
        t = min(max(t, 0.0), end)
    else:
        t = -np.log1p(-rng.random() * whole) / c
    by_angle = aside / ((high - low) * (aside * aside + (t - near) ** 2))
    return t, 0.5 * by_angle + 0.5 * c * np.exp(-c * t) / whole


@compiled
def batch(
    rng: Any, water: Water, lamp: Lamp, view: View, n: int, spread: float, at_u: float, at_v: float, orders: int,
    cos_in: float, small: float, out: Any,
) -> None:  # fmt: skip
    """Adds n walks to `out` (N_TALLIES,): radiance times cos^4, signal, veil, backscatter, near veil.

    spread : 1 fills the image; 0 stays at the field point (at_u, at_v), shares of the half widths.
    """
    path, here = np.empty((MOST_STEPS, 3)), np.empty(N_TALLIES)
    su, sv = rng.random(), rng.random()
    for i in range(n):
        u = at_u + spread * (2.0 * ((su + i * STEP_U) % 1.0) - 1.0)
        v = at_v + spread * (2.0 * ((sv + i * STEP_V) % 1.0) - 1.0)
        tx, ty = u * view.tan_x, v * view.tan_y
        uz = 1.0 / np.sqrt(1.0 + tx * tx + ty * ty)
        ux, uy = tx * uz, ty * uz
        here[:] = 0.0
        reach = view.floor / uz
        here[0] = np.exp(-water.c * reach) * floor_radiance(rng, water, lamp, view, reach * ux, reach * uy, path)
        veil_of(rng, water, lamp, view, ux, uy, uz, path, here)
        here[2] = backscatter_of(rng, water, lamp, view, ux, uy, uz, path, orders, cos_in, small)
        for k in range(N_TALLIES):
            out[k] += here[k] * uz**4


class Seen(NamedTuple):
    """Means and their doubt, (N_TALLIES,) each."""

    mean: Any
    error: Any  # one standard error, from batches
    largest: Any  # largest batch over the mean: far above 1 + a few errors where a tail is heavy


def seen(
    water: Water, lamp: Lamp, view: View, n: int, seed: Any, *, place: tuple[float, float] | None = None,
    orders: int = 99, turn_deg: float = TURN_DEG,
) -> Seen:  # fmt: skip
    """Mean over the image, or at a field point, of radiance times cos^4 per lumen [1/(m^2 sr)], by n walks."""
    small = float(np.interp(np.deg2rad(turn_deg), water.angle, water.share)) if orders > 1 else 1.0
    cos_in = float(np.cos(np.deg2rad(turn_deg))) if orders > 1 else 2.0
    at_u, at_v = place or (0.0, 0.0)
    sums = np.zeros((BATCHES, N_TALLIES))
    for k, source in enumerate(np.random.SeedSequence(seed).spawn(BATCHES)):
        rng = np.random.default_rng(source)
        batch(
            rng, water, lamp, view, n // BATCHES, float(place is None), at_u, at_v, orders, cos_in, small, sums[k]
        )
    means = sums / (n // BATCHES)
    mean = means.mean(axis=0)
    error = means.std(axis=0, ddof=1) / np.sqrt(BATCHES)
    return Seen(mean, error, means.max(axis=0) / np.where(mean > 0.0, mean, 1.0))
