"""The part of the forward veil that comes from elsewhere on the floor.

Light from the floor that is scattered by a large angle on its way leaves its own pixel and falls into others. Seen the
other way round, a pixel looks not only along its ray but, weakly, about it:

    V(u) = cos^4 * integral over directions u' of k(u . u') E(u') (exp(-K_all r') - exp(-K_near r')) d Omega'

with E the floor's illuminance where u' meets it, r' the way from there, and a kernel of integral 1,

    k = (n + 1) / (2 pi) cos^n,   n = 8

The floor under a lamp is taken as spots of equal flux, light by light of its lobe, so that no integral over the floor
has to follow the lobe's flank: E d Omega' = Phi cos(theta_c) / r_c^2 for a spot that gets the flux Phi. The spots are
the same for all images of one port, and the kernel so wide that a few nodes over an image give its mean.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwopt.model import beam as beams
from uwopt.model import port
from uwopt.model.fineness import scaled
from uwopt.model.image_mean import gauss
from uwopt.model.imaging import Lamps, PortShape, field_loss
from uwopt.model.path_table import PathTable, log_transmissions_anywhere

Array = NDArray[np.float64]

KERNEL_DOUBLINGS = 3
KERNEL_POWER = 2**KERNEL_DOUBLINGS  # n, fitted with the attenuations of `multiple`
RINGS, AZIMUTHS = 8, 12  # of a lobe: shares of its flux, and azimuths
IMAGE_NODES = 6  # a side
CROWDING = 2  # power by which rings crowd
CDF_ANGLES = 4001
LEAST_DESCENT = 0.1  # cosine from the floor's normal of rays that count as never meeting it
REACH = 12.0  # altitudes to which tables of water's loss should go for these spots
AT_ONCE = 2_000_000  # pairs of pixel and spot


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


def wide_gain(
    tan_along: Array, tan_across: Array, *, spots: Spots, shape: PortShape, table: PathTable
) -> Array:  # fmt: skip
    """The veil from elsewhere at field points [1/m^2], in the unit of `imaging.local_gain`.

    tan_along, tan_across : (...,) tangents in air; table : loss over lamp and camera leg, K_all less K_near on the
    latter. Valid for what is seen within 90 deg of its own way: nothing comes round a corner.
    """
    loss = log_transmissions_anywhere((table,), spots.lamp_m, spots.camera_m)[0]
    amount = (KERNEL_POWER + 1) / (2.0 * np.pi) * spots.share * np.exp(loss)
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
        kernel = np.maximum(pixel[start : start + step] @ spots.direction, 0.0)
        for _ in range(KERNEL_DOUBLINGS):
            kernel *= kernel
        found[start : start + step] = kernel @ amount
    return np.asarray(found.reshape(along.shape) * field_loss(along, across, shape=shape))


def mean_wide_gain(
    tan_along: Array, tan_across: Array, *, spots: Spots, shape: PortShape, table: PathTable, fineness: float = 1.0
) -> Array:  # fmt: skip
    """Mean of `wide_gain` over the rectangles of images of these half widths in air, (n,) [1/m^2]."""
    nodes, weights = gauss(scaled(IMAGE_NODES, fineness))
    u, v = np.meshgrid(nodes, nodes, indexing="ij")
    gain = wide_gain(
        np.multiply.outer(tan_along, u.ravel()), np.multiply.outer(tan_across, v.ravel()), spots=spots, shape=shape,
        table=table,
    )  # fmt: skip
    return np.asarray(gain @ np.outer(weights, weights).ravel())


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
