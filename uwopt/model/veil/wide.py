"""The part of the forward veil that comes from elsewhere on the floor.

Light from the floor that is scattered by a large angle on its way leaves its own pixel and falls into others. Seen the
other way round, a pixel looks not only along its ray but, weakly, about it:

    V(u) = cos^4 * integral over directions u' of k(u . u') E(u') (exp(-K_all r') - exp(-K_near r')) d Omega'

with E the floor's illuminance where u' meets it, r' the way from there, and a kernel of integral 1 that is the wider
the more often light has turned on its way; of what comes from elsewhere the share q_i has turned i times,

    k = q_1 (0.85 k_16 + 0.15 k_2) + q_2 k_8 + (1 - q_1 - q_2) k_4,   k_n = (n + 1) / (2 pi) cos^n
    q_i = x^i / (i! (e^x - 1)),   x = (K_near - K_all) d

The floor under a lamp is taken as spots of equal flux, light by light of its lobe, so that no integral over the floor
has to follow the lobe's flank: E d Omega' = Phi cos(theta_c) / r_c^2 for a spot that gets the flux Phi. The spots are
the same for all images of one port, and the kernel so wide that a few nodes over an image give its mean.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwopt.model import beam as beams
from uwopt.model import port
from uwopt.model.fineness import scaled
from uwopt.model.image_mean import gauss
from uwopt.model.imaging import Lamps, PortShape, field_loss
from uwopt.model.path_table import PathTable, log_transmissions_anywhere

Array = NDArray[np.float64]

POWERS = (2, 4, 8, 16)  # n of the kernels: each the square of the one before
ONCE = {16: 0.85, 2: 0.15}  # of light that turned once: most from nearby, and a long tail
TWICE, OFTEN = 8, 4
FEW = 1e-9  # turns, below which all of it turned once
RINGS, AZIMUTHS = 10, 16  # of a lobe: shares of its flux, and azimuths
IMAGE_NODES, LARGE_NODES = 6, 8  # a side
LARGE_TANGENT = 0.6  # of the half of a side, from which an image is large
CROWDING = 2  # power by which rings crowd
CDF_ANGLES = 4001
LEAST_DESCENT = 0.1  # cosine from the floor's normal of rays that count as never meeting it
REACH = 12.0  # altitudes to which tables of water's loss should go for these spots
AT_ONCE = 2_000_000  # pairs of pixel and spot
LEAST_HALF, MOST_HALF, N_HALVES = 0.03, 2.5, 24  # tangents in water of half images in the table of `least_within`
WITHIN_NODES, WITHIN_PLACES = 16, 3  # a side of the image, and of its quarter
WITHIN_POWER, MOST_ASIDE = 3, 0.3  # of a bound for places that a window shows aside of where it looks


class Spots(NamedTuple):
    """The lit floor as the camera sees it, (n,) each."""

    direction: Array  # (3, n) unit vectors from the camera, vehicle frame
    share: Array  # flux of the spot per lumen, times cos(theta_c) / r_c^2 [1/m^2]
    lamp_m: Array
    camera_m: Array


@lru_cache(maxsize=1024)  # the same in all water and for all images: 10 kB a lighting, port and altitude
def floor_spots(
    *, lamps: Lamps, beam: beams.Beam, shape: PortShape, range_m: float, fineness: float = 1.0
) -> Spots:  # fmt: skip
    """Where the light of lamps falls on the plane z = range_m + slope x, and how large it is seen from the camera.

    lamps, beam, shape, range_m : as in `imaging.local_gain`; one port. Rays that never meet the plane are left out.
    fineness : factor on rings and azimuths of each lobe
    """
    angle, flux = _rings(beam, scaled(RINGS, fineness))
    n_round = scaled(AZIMUTHS, fineness)
    azimuth = 2.0 * np.pi * (np.arange(n_round) + 0.5) / n_round
    sine = np.sin(angle)[:, None]
    local = np.stack(np.broadcast_arrays(sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(angle)[:, None]))
    local, flux = local.reshape(3, -1), np.repeat(flux / n_round, n_round)
    behind_m = float(shape.outer_radius_m) if shape.is_dome else 0.0
    normal = np.array([-shape.slope, 0.0, 1.0]) / np.hypot(1.0, shape.slope)
    parts = []
    for x, y, z, aim, share in zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, lamps.share, strict=True):
        ray = _frame(aim) @ local
        descent = normal @ ray
        meets = descent > LEAST_DESCENT
        height_m = (range_m + shape.slope * x - z) * normal[2]
        lamp_m = height_m / descent[meets]
        place = np.array([[x], [y], [z + behind_m]]) + lamp_m * ray[:, meets]
        far_m = np.sqrt(np.square(place).sum(axis=0))
        cosine = np.maximum(normal @ place, 0.0) / far_m
        seen = share * flux[meets] * cosine / np.square(far_m)
        parts.append((place / far_m, seen, lamp_m, np.maximum(far_m - behind_m, 0.0)))
    return Spots(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))


def kernel_shares(turns: ArrayLike) -> Array:
    """How much of what comes from elsewhere comes by each of the kernels k_2, k_4, k_8 and k_16, 1 in all.

        q_1 (0.85 k_16 + 0.15 k_2) + q_2 k_8 + (1 - q_1 - q_2) k_4,   q_i = x^i / (i! (e^x - 1))

    Parameters
    ----------
    turns : (...,) [1], x = (K_near - K_all) d, 0 or more: Poisson's mean number of turns, of which at least one is

    Returns
    -------
    (..., 4) [1], the powers as in `POWERS`
    """
    x = np.maximum(np.asarray(turns, dtype=float), FEW)
    with np.errstate(over="ignore"):
        once = x / np.expm1(x)
    twice = 0.5 * x * once
    shares = np.zeros((*x.shape, len(POWERS)))
    for power, part in ONCE.items():
        shares[..., POWERS.index(power)] = part * once
    shares[..., POWERS.index(TWICE)] = twice
    shares[..., POWERS.index(OFTEN)] = 1.0 - once - twice
    return shares


def wide_gain(
    tan_along: Array, tan_across: Array, *, spots: Spots, shape: PortShape, table: PathTable, shares: Array
) -> Array:  # fmt: skip
    """The veil from elsewhere at field points [1/m^2], in the unit of `imaging.local_gain`.

    tan_along, tan_across : (...,) tangents in air; table : loss over lamp and camera leg, K_all less K_near on the
    latter; shares : of the kernels, see `kernel_shares`. Valid for what is seen within 90 deg of its own way: nothing
    comes round a corner.
    """
    loss = log_transmissions_anywhere((table,), spots.lamp_m, spots.camera_m)[0]
    amount = spots.share * np.exp(loss)
    along, across = np.broadcast_arrays(np.asarray(tan_along, float), np.asarray(tan_across, float))
    bend = 1.0
    if not shape.is_dome:
        tangent = np.maximum(np.hypot(along, across), 1e-9)
        bend = port.water_tangent(tangent, n=shape.n_water) / tangent
    pixel = np.stack([(along * bend).ravel(), (across * bend).ravel(), np.ones(along.size)], axis=1)
    pixel /= np.sqrt(np.square(pixel).sum(axis=1))[:, None]
    found = np.empty(along.size)
    step = max(1, AT_ONCE // max(amount.size, 1))
    for start in range(0, along.size, step):
        kernel, total = np.maximum(pixel[start : start + step] @ spots.direction, 0.0), 0.0
        for share, power in zip(shares, POWERS, strict=True):
            kernel *= kernel
            total = total + (kernel @ amount) * (share * (power + 1) / (2.0 * np.pi))
        found[start : start + step] = total
    return np.asarray(found.reshape(along.shape) * field_loss(along, across, shape=shape))


def mean_wide_gain(
    tan_along: Array, tan_across: Array, *, spots: Spots, shape: PortShape, table: PathTable, shares: Array,
    fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Mean of `wide_gain` over the rectangles of images of these half widths in air, (n,) [1/m^2]."""
    along, across = np.asarray(tan_along, dtype=float), np.asarray(tan_across, dtype=float)
    large = np.maximum(along, across) > LARGE_TANGENT
    found = np.empty(len(along))
    for mine, count in ((~large, IMAGE_NODES), (large, LARGE_NODES)):
        if mine.any():
            nodes, weights = gauss(scaled(count, fineness))
            u, v = np.meshgrid(nodes, nodes, indexing="ij")
            gain = wide_gain(
                np.multiply.outer(along[mine], u.ravel()), np.multiply.outer(across[mine], v.ravel()), spots=spots,
                shape=shape, table=table, shares=shares,
            )  # fmt: skip
            found[mine] = gain @ np.outer(weights, weights).ravel()
    return found


def least_within(half_along: ArrayLike, half_across: ArrayLike, *, aside: ArrayLike = 0.0) -> Array:
    """What an image gets back at least of its own floor's light as veil from elsewhere, by kernel and loss (n, 4) [1].

        mean V / mean S >= h g(r) / exp(-c r)
        h = least over u' of integral over u of k(u . u') cos u / cos u' d Omega

    with V of a kernel of `POWERS` alone, S what forms the image, g the loss of the wide veil, both losses straight down
    over the shortest ray. u and u' are directions in water within the image; the sums over both may be taken in either
    order, and the light on the floor, however uneven, is the same in V and S. What comes from beside the image is left
    out.

    Parameters
    ----------
    half_along, half_across : (n,) tangents in water of half the image's sides
    aside : broadcasting [1], by how much farther from the axis, at most, places on the floor lie than a ray from the
        port's middle would have them; the bound is 0 beyond 0.3

    Notes
    -----
    Level floors, half images of 0.03 to 2.5; of others 0. By a table, linear in logarithms, at most 1 % more than h. An
    image that a window bends to a barrel holds the rectangle of its corners.
    """
    spread = np.log(MOST_HALF / LEAST_HALF) / (N_HALVES - 1)
    halves = np.broadcast_arrays(np.asarray(half_along, float), np.asarray(half_across, float))
    place = [np.log(np.clip(half, LEAST_HALF, MOST_HALF) / LEAST_HALF) / spread for half in halves]
    at = [np.minimum(one.astype(int), N_HALVES - 2) for one in place]
    (i, j), (p, q) = at, (one - low for one, low in zip(place, at, strict=True))
    p, q, table = p[..., None], q[..., None], _within_table()
    low, high = ((1.0 - q) * table[k, j] + q * table[k, j + 1] for k in (i, i + 1))
    beside = np.asarray(aside, dtype=float)
    lost = np.where(beside <= MOST_ASIDE, (1.0 + np.maximum(beside, 0.0)) ** -WITHIN_POWER, 0.0)
    known = (np.minimum(*halves) >= LEAST_HALF) & (np.maximum(*halves) <= MOST_HALF)
    return np.asarray(np.exp((1.0 - p) * low + p * high) * (lost * known)[..., None])


@cache
def _within_table() -> Array:
    """Logarithms of h, (N_HALVES, N_HALVES, 4) by half along and across."""
    halves = np.geomspace(LEAST_HALF, MOST_HALF, N_HALVES)
    nodes, weights = gauss(WITHIN_NODES)
    steps = np.linspace(0.0, 1.0, WITHIN_PLACES)
    found = np.empty((N_HALVES, N_HALVES, len(POWERS)))
    for i, along in enumerate(halves):
        across = halves[: i + 1]
        from_, weight = _directions(along * nodes, np.multiply.outer(across, nodes))
        weight = weight**4 * np.outer(weights, weights).ravel() * (4.0 * along * across)[:, None]
        to, cosine = _directions(along * steps, np.multiply.outer(across, steps))
        kernel = np.maximum(np.einsum("acn,acm->anm", to, from_), 0.0)
        for k, power in enumerate(POWERS):
            kernel *= kernel
            sums = (kernel @ weight[:, :, None])[:, :, 0] * (power + 1) / (2.0 * np.pi) / cosine
            found[i, : i + 1, k] = found[: i + 1, i, k] = sums.min(axis=1)
    return np.asarray(np.log(found))


def _directions(along: Array, across: Array) -> tuple[Array, Array]:
    """Unit vectors (a, 3, n) of tangents along (u,) by across (a, v), and their cosines from the axis (a, n)."""
    u, v = np.broadcast_arrays(along[None, :, None], across[:, None, :])
    u, v = u.reshape(len(across), -1), v.reshape(len(across), -1)
    cosine = 1.0 / np.sqrt(1.0 + u * u + v * v)
    return np.stack([u * cosine, v * cosine, cosine], axis=1), cosine


@lru_cache(maxsize=256)
def _rings(beam: beams.Beam, count: int) -> tuple[Array, Array]:
    """Angles from the axis at Gauss nodes of the flux within, crowded towards the lobe's tail, and the flux of each."""
    angle = np.linspace(0.0, np.pi / 2, CDF_ANGLES)
    per_angle = 2.0 * np.pi * np.sin(angle) * beams.intensity_per_sr(np.cos(angle), beam)
    within = np.concatenate([[0.0], np.cumsum(0.5 * (per_angle[1:] + per_angle[:-1]) * np.diff(angle))])
    nodes, weights = gauss(count)
    left = 0.5 * (1.0 - nodes)
    share, slope = 1.0 - left**CROWDING, CROWDING * left ** (CROWDING - 1)
    return np.interp(share * within[-1], within, angle), weights * slope * within[-1]


def _frame(aim: tuple[float, float, float]) -> Array:
    """Matrix whose last column is the aim, the others square to it."""
    z = np.array(aim)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.sqrt(np.square(x).sum())
    return np.stack([x, np.cross(z, x), z], axis=1)
