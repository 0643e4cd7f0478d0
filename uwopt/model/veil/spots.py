"""The lit floor as spots, for sums over what a camera sees of it from about its rays (`veil.wide`).

Two rules see the floor under a lamp differently. Spots of equal flux, ring by ring of its lobe, follow the lobe however
narrow it is; but a lamp far aside spends few of them where the camera looks. Spots of the camera's solid angle, ring by
ring about the floor's normal, lie where a kernel about a pixel's ray does; but a narrow lobe falls between them. Both
stand together, each with a share that goes to 1 where it is the denser of the two:

    w_lamp = q^2 / (1 + q^2),   w_camera = 1 / (1 + q^2),   q = (n_l E / Phi) / (n_c cos(theta_c) / (2 pi r_c^2))

with q the spots of a lamp's flux over those of the camera's solid angle on a place of the floor. The shares are smooth
and add up to 1, so that each rule has a smooth integrand: the other takes what it would miss. Where most of what a
camera looks at is the lamp's, its spots do alone.

Veach and Guibas (1995), SIGGRAPH '95, 419-428, for shares of rules that draw at random (their power heuristic).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.model import beam as beams
from uwopt.model.fineness import scaled
from uwopt.model.image_mean import gauss
from uwopt.model.imaging import Lamps, PortShape, covered_share

RINGS, AZIMUTHS = 10, 16  # of a lobe: shares of its flux, and azimuths
SIGHT_RINGS, SIGHT_AZIMUTHS = 12, 20  # of the camera's solid angle
CROWDING = 2  # power by which rings of a lobe crowd
CDF_ANGLES = 4001
LEAST_DESCENT = 0.1  # cosine from the floor's normal of rays that count as never meeting it
LOOK_POWER = 16  # of the kernel about the optical axis by which it is judged whether a lamp's own spots will do
ENOUGH = 0.5  # of its light there that a lamp's own spots must stand for, to do alone


class Spots(NamedTuple):
    """The lit floor as the camera sees it, (n,) each."""

    direction: Array  # (3, n) unit vectors from the camera, vehicle frame
    share: Array  # flux of the spot per lumen, times cos(theta_c) / r_c^2 [1/m^2]
    lamp_m: Array
    camera_m: Array

    def times(self, share: Array) -> Spots:
        """With so much of each (n,)."""
        return self._replace(share=self.share * share)


@lru_cache(maxsize=1024)  # the same in all water and for all images: some 15 kB a lighting, port and altitude
def floor_spots(
    *, lamps: Lamps, beam: beams.Beam, shape: PortShape, range_m: float, fineness: float = 1.0
) -> Spots:  # fmt: skip
    """Where the light of lamps falls on the plane z = range_m + slope x, and how large it is seen from the camera.

        sum of share * g  ~  integral over the floor of E / Phi cos(theta_c) / r_c^2 g,   g smooth over about 30 deg

    Parameters
    ----------
    lamps, beam, shape, range_m : as in `imaging.local_gain`; one port
    fineness : factor on rings and azimuths

    Returns
    -------
    Spots of all lamps. Rays that hardly meet the plane are left out, those of lobes and those of the camera.

    Notes
    -----
    Against sums over fine cells, 1500 lamps up to 12 heights aside, 8 to 82 deg wide at half power or edge, over a
    level floor: means of the veil from elsewhere within 1 % of lobes, within 5 % (3.3 % low) of discs and cones, which
    are worst where an edge crosses a small image; nine in ten within 0.6 %. Lit pixels of corners within 2 and 6 %.
    """
    floor, lobe = _Floor(shape, range_m, fineness), _Lobe(beam, fineness)
    parts = []
    for x, y, z, aim, share in zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, lamps.share, strict=True):
        lamp = _Lamp((x, y, z), aim, floor)
        by_light, of_light = _by_light(lamp, lobe, floor)
        by_sight, of_sight = _by_sight(lamp, lobe, floor)
        shared = by_light.times(of_light), by_sight.times(1.0 - of_sight)
        seen = [float(spots.share @ np.maximum(spots.direction[2], 0.0) ** LOOK_POWER) for spots in shared]
        chosen = (by_light,) if seen[0] >= ENOUGH * sum(seen) else shared
        parts += [spots.times(np.asarray(share)) for spots in chosen]
    return Spots(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))


class _Floor:
    """The plane that is looked at, from the camera: from the port, or from the middle of a dome."""

    def __init__(self, shape: PortShape, range_m: float, fineness: float):
        self.slope, self.range_m = shape.slope, range_m
        self.behind_m = float(shape.outer_radius_m) if shape.is_dome else 0.0
        self.sight = _sight(float(shape.slope), scaled(SIGHT_RINGS, fineness), scaled(SIGHT_AZIMUTHS, fineness))
        self.normal = self.sight.normal

    def height_m(self, x_m: float, z_m: float) -> float:
        """Of a place over the plane."""
        return float((self.range_m + self.slope * x_m - z_m) * self.normal[2])


class _Sight(NamedTuple):
    """Ways from the camera to the floor, even in solid angle about its normal, (n,) each."""

    normal: Array  # (3,)
    direction: Array  # (3, n)
    descent: Array  # cosine from the normal
    solid_sr: Array
    grid: tuple[int, int]  # rings and azimuths, n in all

    @property
    def per_sr(self) -> float:
        """How many there are for each unit of solid angle [1/sr]."""
        return len(self.descent) / (2.0 * np.pi * (1.0 - LEAST_DESCENT))


@lru_cache(maxsize=64)
def _sight(slope: float, n_rings: int, n_round: int) -> _Sight:
    nodes, weights = gauss(n_rings)
    descent = LEAST_DESCENT + 0.5 * (1.0 - LEAST_DESCENT) * (1.0 + nodes)
    solid = 2.0 * np.pi * (1.0 - LEAST_DESCENT) * weights / n_round
    long = float(np.hypot(1.0, slope))
    normal = (-slope / long, 0.0, 1.0 / long)
    direction = _frame(normal) @ _around(np.arccos(descent), n_round)
    each = np.repeat(np.stack([descent, solid]), n_round, axis=1)
    return _Sight(np.array(normal), direction, each[0], each[1], (n_rings, n_round))


class _Lamp:
    """One lamp over the floor."""

    def __init__(self, place_m: tuple[float, float, float], aim: tuple[float, float, float], floor: _Floor):
        x, y, z = place_m
        self.place_m = np.array([[x], [y], [z + floor.behind_m]])
        self.aim, self.height_m = aim, floor.height_m(x, z)


class _Lobe:
    """A beam as rays of equal flux: rings at Gauss nodes of the flux within, crowded towards the tail."""

    def __init__(self, beam: beams.Beam, fineness: float):
        self.parts = beams.parts(beam)
        angle, flux = _rings(beam, scaled(RINGS, fineness))
        n_round = scaled(AZIMUTHS, fineness)
        self.ray, self.flux = _around(angle, n_round), np.repeat(flux / n_round, n_round)
        self.all_flux = float(flux.sum())

    def within_edge_per_sr(self, cos_angle: Array, grid: tuple[int, int]) -> Array:
        """Intensity on a grid of directions, where a sharp edge crosses a cell by the share that it leaves lit."""
        found = np.zeros(cos_angle.shape)
        for part in self.parts:
            inside = beams.intensity_per_sr(cos_angle, beams.without_edge(part))
            if beams.has_sharp_edge(part):
                edge = float(np.cos(beams.edge_half_angle_rad(part)))
                inside = inside * covered_share(cos_angle.reshape(grid), edge).ravel()
            found += inside
        return found

    def share(self, cos_angle: Array, lamp_m: Array, height_m: float, sight_per_m2: Array) -> Array:
        """w_lamp at places of the floor, of the beam as if no edge ended it: smooth across one."""
        intensity = sum(beams.intensity_per_sr(cos_angle, beams.without_edge(part)) for part in self.parts)
        denser = len(self.flux) / self.all_flux * intensity * height_m / lamp_m**3 / sight_per_m2
        square = np.square(denser)
        return np.asarray(square / (1.0 + square))


def _by_light(lamp: _Lamp, lobe: _Lobe, floor: _Floor) -> tuple[Spots, Array]:
    """Spots of equal flux of a lamp, and the share that is theirs where both rules stand."""
    ray = _frame(lamp.aim) @ lobe.ray
    descent = floor.normal @ ray
    meets = descent > LEAST_DESCENT
    lamp_m = lamp.height_m / descent[meets]
    place = lamp.place_m + lamp_m * ray[:, meets]
    far_m = np.sqrt(np.square(place).sum(axis=0))
    seen = np.maximum(floor.normal @ place, 0.0) / far_m / np.square(far_m)
    spots = Spots(place / far_m, lobe.flux[meets] * seen, lamp_m, np.maximum(far_m - floor.behind_m, 0.0))
    share = lobe.share(lobe.ray[2, meets], lamp_m, lamp.height_m, floor.sight.per_sr * seen)
    return spots, share


def _by_sight(lamp: _Lamp, lobe: _Lobe, floor: _Floor) -> tuple[Spots, Array]:
    """Spots of the camera's solid angle in a lamp's light, and the share of the lamp's own spots there."""
    sight = floor.sight
    far_m = floor.height_m(0.0, -floor.behind_m) / sight.descent
    way = far_m * sight.direction - lamp.place_m
    lamp_m = np.sqrt(np.square(way).sum(axis=0))
    cos_angle = np.asarray(lamp.aim) @ way / lamp_m
    lit = lobe.within_edge_per_sr(cos_angle, sight.grid) * lamp.height_m / lamp_m**3
    spots = Spots(sight.direction, lit * sight.solid_sr, lamp_m, np.maximum(far_m - floor.behind_m, 0.0))
    share = lobe.share(cos_angle, lamp_m, lamp.height_m, sight.per_sr * sight.descent / np.square(far_m))
    return spots, share


def _around(angle: Array, n_round: int) -> Array:
    """Unit vectors at these angles from z, at so many azimuths each (3, n)."""
    azimuth = 2.0 * np.pi * (np.arange(n_round) + 0.5) / n_round
    sine = np.sin(angle)[:, None]
    around = np.broadcast_arrays(sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(angle)[:, None])
    return np.stack(around).reshape(3, -1)


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


@lru_cache(maxsize=1024)
def _frame(aim: tuple[float, float, float]) -> Array:
    """Matrix whose last column is the aim, the others square to it."""
    z = np.array(aim)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.sqrt(np.square(x).sum())
    return np.stack([x, np.cross(z, x), z], axis=1)
