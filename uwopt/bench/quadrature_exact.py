"""Signal and veil of an image by adaptive quadrature: the reference of the suite `quadrature`.

The integrands of physics page, sections 1 to 4 and 8, written again point by point: rays traced by angles, each
wavelength's loss by itself. The mean over the image is QUADPACK's adaptive rule within another one, split where
the edge of a beam enters or leaves; along a ray it is the double exponential rule in the distance itself, split
at the lamp's closest approach and where the ray meets the edge. `uwopt.model` lends its records only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.model.beam import Beam
from uwopt.model.bisection import bisected, half_way
from uwopt.model.imaging import Lamps, PortShape

Place = tuple[float, float, float]
Level = Callable[[float, float], float]

Tolerances = tuple[float, float]
TOLERANCES = (1e-8, 1e-7)  # relative, of the inner and the outer adaptive rule
PROFILE_TOLERANCES = (
    2e-5,
    3e-5,
)  # the same for veils of measured profiles, whose curve bends every half degree
SCAN_INNER, SCAN_OUTER = 25, 33  # points on which edges are looked for
BISECTIONS = 44
REACH, STEP = 3.4, 1.0 / 16.0  # of the double exponential rule
SHORT_STEP = 1.0 / 6.0  # the same between two entries of a measured profile
SAMPLES = (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9)  # of the image, along and across
DARK = 1e-10  # of the brightest sample: absolute tolerance of both rules, where nothing is lit
EDGE_NOISE = 1e-12  # of a cosine: a ray that begins in the lamp's own plane crosses nothing


@dataclass(frozen=True, eq=False)
class Water:
    """A few colours: losses on both legs, how much each counts in the signal, and what scatters."""

    k_per_m: Array
    c_per_m: Array
    signal_weight: Array
    scatter_weights: tuple[Array, ...]
    phases: tuple[Callable[[Any], Any], ...]  # of the cosine of the scattering angle [1/sr]


@dataclass(frozen=True, eq=False)
class ImageCase:
    """One image: half its field as tangents in air, port, altitude, lamps, beam and water."""

    name: str
    half: tuple[float, float]
    shape: PortShape
    range_m: float
    lamps: Lamps
    beam: Beam
    water: Water


@dataclass(frozen=True)
class Ray:
    """A pixel's ray in water, from the port to the floor."""

    start: Place
    along: Place
    length_m: float


def traced(u: float, v: float, shape: PortShape, range_m: float) -> Ray:
    """The ray of a field point, by angles: through a dome unbent, through a flat window by Snell's law."""
    radius = math.hypot(u, v)
    theta = math.atan(radius)
    cos_turn, sin_turn = (u / radius, v / radius) if radius > 0.0 else (1.0, 0.0)
    if shape.is_dome:
        sin, cos, dome_m = math.sin(theta), math.cos(theta), shape.outer_radius_m
        along = (sin * cos_turn, sin * sin_turn, cos)
        start = (dome_m * along[0], dome_m * along[1], dome_m * (cos - 1.0))
        return Ray(start, along, (range_m - start[2]) / cos)
    in_glass, in_water = (
        math.asin(math.sin(theta) / shape.n_glass),
        math.asin(math.sin(theta) / shape.n_water),
    )
    off_m = shape.gap_m * radius + shape.thickness_m * math.tan(in_glass)
    along = (math.sin(in_water) * cos_turn, math.sin(in_water) * sin_turn, math.cos(in_water))
    return Ray((off_m * cos_turn, off_m * sin_turn, 0.0), along, range_m / along[2])


def dot(a: Place, b: Place) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def each_lamp(lamps: Lamps) -> Iterator[tuple[Place, Place, float]]:
    """Place, aim and share of each."""
    for x, y, z, aim, share in zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, lamps.share, strict=True):
        yield (x, y, z), aim, share


@lru_cache(maxsize=32)
def profile_of(beam: Beam) -> Any:
    """A measured profile between its entries: monotone cubic."""
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(np.array(beam.table_angle_rad), np.array(beam.table_intensity_per_sr))


def cos_edge(beam: Beam) -> float:
    """Cosine of the angle at which a beam ends: its edge, the table's end, or the lamp's front plane."""
    if beam.kind in ("disc", "cone"):
        return math.cos(beam.half_angle_water_rad or 0.0)
    return math.cos(beam.table_angle_rad[-1]) if beam.kind == "tabulated" else 0.0


def intensity(cos: Any, beam: Beam) -> Any:
    """Intensity per lumen [1/sr] within the beam; what lies beyond its edge is not asked for."""
    if beam.kind == "cosine-power":
        m = beam.exponent or 0.0
        return (m + 1.0) / (2.0 * math.pi) * np.maximum(cos, 0.0) ** m
    if beam.kind == "tabulated":
        return profile_of(beam)(np.arccos(np.clip(cos, cos_edge(beam), 1.0)))
    half_rad = beam.half_angle_water_rad or 0.0
    if beam.kind == "cone":
        return 1.0 / (2.0 * math.pi * (1.0 - math.cos(half_rad))) + 0.0 * cos
    return 1.0 / (math.pi * math.tan(half_rad) ** 2 * cos**3)


# ---------------------------------------------------------------- the two integrands over the image


def floor_signal(u: float, v: float, light: ImageCase) -> float:
    """cos^4 times illuminance per lumen times the loss in water on both legs [1/m^2]; 1 for the whole weight."""
    ray = traced(u, v, light.shape, light.range_m)
    floor: Place = tuple(s + ray.length_m * a for s, a in zip(ray.start, ray.along, strict=True))  # pyrefly: ignore[bad-assignment]
    water, total = light.water, 0.0
    for place, aim, share in each_lamp(light.lamps):
        way: Place = (floor[0] - place[0], floor[1] - place[1], floor[2] - place[2])
        lamp_m = math.sqrt(dot(way, way))
        cos_beam = dot(way, aim) / lamp_m
        if cos_beam < cos_edge(light.beam):
            continue
        loss = np.exp(-water.k_per_m * lamp_m - water.c_per_m * ray.length_m)
        seen = float(loss @ water.signal_weight) / float(water.signal_weight.sum())
        total += share * float(intensity(cos_beam, light.beam)) * way[2] / lamp_m**3 * seen
    return total / (1.0 + u * u + v * v) ** 2


def ray_veil(u: float, v: float, light: ImageCase) -> float:
    """cos^4 times the integral of the light scattered towards a pixel, per lumen [weight / (m sr)]."""
    ray = traced(u, v, light.shape, light.range_m)
    water, total = light.water, 0.0
    for place, aim, share in each_lamp(light.lamps):
        seen = SeenLamp(ray, place, aim)
        r, steps = double_exponential(seen.lit_pieces(light.beam), light.beam.kind == "tabulated")
        if not r.size:
            continue
        lamp_m, cos_beam, cos_scatter = seen.at(r)
        loss = np.exp(-np.multiply.outer(lamp_m, water.k_per_m) - np.multiply.outer(r, water.c_per_m))
        scattered = sum(
            phase(cos_scatter) * (loss @ weight)
            for phase, weight in zip(water.phases, water.scatter_weights, strict=True)
        )
        total += share * float((steps * intensity(cos_beam, light.beam) / lamp_m**2 * scattered).sum())
    return total / (1.0 + u * u + v * v) ** 2


class SeenLamp:
    """A lamp from a ray: with q = start - lamp, way(r) = q + r along."""

    def __init__(self, ray: Ray, place: Place, aim: Place):
        q: Place = (ray.start[0] - place[0], ray.start[1] - place[1], ray.start[2] - place[2])
        self.length_m = ray.length_m
        self.square, self.slant = dot(q, q), dot(q, ray.along)
        self.aim_start, self.aim_slope = dot(q, aim), dot(ray.along, aim)

    def at(self, r: Any) -> tuple[Any, Any, Any]:
        """Distance from the lamp [m], cosine from its axis, cosine of the scattering angle."""
        lamp_m = np.sqrt(self.square + r * (2.0 * self.slant + r))
        return lamp_m, (self.aim_start + self.aim_slope * r) / lamp_m, -(self.slant + r) / lamp_m

    def cos_beam(self, r: float) -> float:
        """Cosine from the lamp's axis at one place."""
        return (self.aim_start + self.aim_slope * r) / math.sqrt(self.square + r * (2.0 * self.slant + r))

    def brightest(self) -> float:
        """Greatest cosine from the lamp's axis along the ray."""
        bottom = self.aim_slope * self.slant - self.aim_start
        places = [0.0, self.length_m]
        if bottom != 0.0:
            r = (self.aim_start * self.slant - self.aim_slope * self.square) / bottom
            places.append(min(max(r, 0.0), self.length_m))
        return max(self.cos_beam(r) for r in places)

    def crossings(self, cos: float) -> list[float]:
        """Where the ray crosses the cone of this angle: (p + q r)^2 = cos^2 |way|^2."""
        p, q, square = self.aim_start, self.aim_slope, cos * cos
        a, b, c = q * q - square, p * q - square * self.slant, p * p - square * self.square
        root = math.sqrt(max(b * b - a * c, 0.0))
        far = -(b + math.copysign(root, b))  # without cancellation
        found = [far / a] if a != 0.0 else []
        return [*found, c / far] if far != 0.0 else found

    def lit_pieces(self, beam: Beam) -> list[tuple[float, float]]:
        """Parts of the ray within the beam, split at the closest approach and at the entries of a profile."""
        edge = cos_edge(beam)
        cones = [edge, *(math.cos(angle) for angle in beam.table_angle_rad[1:])]
        inner = [-self.slant, *(r for cos in cones for r in self.crossings(cos))]
        ends = sorted({0.0, self.length_m, *(r for r in inner if 0.0 < r < self.length_m)})
        return [(low, high) for low, high in pairwise(ends) if self.cos_beam(0.5 * (low + high)) > edge]


@lru_cache(maxsize=4)
def unit_rule(step: float) -> tuple[Array, Array]:
    """Double exponential nodes, as shares of an interval, and weights."""
    t = np.arange(-round(REACH / step), round(REACH / step) + 1) * step
    inner = 0.5 * np.pi * np.sinh(t)
    share = 1.0 / (1.0 + np.exp(-2.0 * inner))
    return share, step * 0.25 * np.pi * np.cosh(t) / np.cosh(inner) ** 2


def double_exponential(pieces: list[tuple[float, float]], short: bool) -> tuple[Array, Array]:
    """Nodes and weights over all pieces."""
    if not pieces:
        return np.empty(0), np.empty(0)
    share, weight = unit_rule(SHORT_STEP if short else STEP)
    low, high = np.array(pieces).T
    width = (high - low)[:, None]
    return (low[:, None] + width * share).ravel(), (width * weight).ravel()


# ---------------------------------------------------------------- the mean over the image


def signal_levels(light: ImageCase) -> list[Level]:
    """What changes sign on the image where a lamp's edge lies on the floor."""
    edge = cos_edge(light.beam)

    def level(u: float, v: float, place: Place, aim: Place) -> float:
        ray = traced(u, v, light.shape, light.range_m)
        return SeenLamp(ray, place, aim).cos_beam(ray.length_m) - edge

    return [partial(level, place=place, aim=aim) for place, aim, _ in each_lamp(light.lamps)]


def veil_levels(light: ImageCase) -> list[Level]:
    """The same for the veil: also where rays begin to touch the beam, or begin within it."""
    edge = cos_edge(light.beam)

    def start(u: float, v: float, place: Place, aim: Place) -> float:
        return SeenLamp(traced(u, v, light.shape, light.range_m), place, aim).cos_beam(0.0) - edge

    def touch(u: float, v: float, place: Place, aim: Place) -> float:
        return SeenLamp(traced(u, v, light.shape, light.range_m), place, aim).brightest() - edge

    more = [
        partial(what, place=place, aim=aim)
        for place, aim, _ in each_lamp(light.lamps)
        for what in (start, touch)
    ]
    return [*signal_levels(light), *more]


def crossings_of(u: float, half_across: float, levels: list[Level]) -> list[list[float]]:
    """By level: the v at which it changes sign on the line of this u."""
    from scipy.optimize import brentq

    found = []
    for level in levels:
        here = partial(level, u)
        scan, values = scanned(here, half_across)
        found.append(
            [
                brentq(here, scan[i], scan[i + 1], xtol=1e-15)
                for i in range(len(scan) - 1)
                if values[i] * values[i + 1] < 0.0 and max(abs(values[i]), abs(values[i + 1])) > EDGE_NOISE
            ]
        )
    return found


def scanned(level: Callable[[float], float], half: float) -> tuple[list[float], list[float]]:
    """A level on even points and, where all are below 0, at its top between them: a narrow spot shows there."""
    from scipy.optimize import minimize_scalar

    scan = np.linspace(-half, half, SCAN_INNER).tolist()
    values = [level(v) for v in scan]
    top = int(np.argmax(values))
    if values[top] >= 0.0:
        return scan, values
    ends = (scan[max(top - 1, 0)], scan[min(top + 1, SCAN_INNER - 1)])
    v = float(
        minimize_scalar(lambda v: -level(v), bounds=ends, method="bounded", options={"xatol": 1e-9 * half}).x
    )
    at = int(np.searchsorted(scan, v))
    return [*scan[:at], v, *scan[at:]], [*values[:at], level(v), *values[at:]]


def outer_splits(low: float, high: float, half_across: float, levels: list[Level]) -> list[float]:
    """The u at which the number of edges on a line changes: tangents of the edge, and corners of the image."""

    def kind(u: float) -> tuple[int, ...]:
        return tuple(len(found) for found in crossings_of(u, half_across, levels))

    scan = np.linspace(low, high, SCAN_OUTER).tolist()
    kinds, splits = [kind(u) for u in scan], []
    for i in range(len(scan) - 1):
        if kinds[i] == kinds[i + 1]:
            continue
        ends = bisected(lambda u, of=kinds[i]: kind(u) == of, scan[i], scan[i + 1], steps=BISECTIONS)
        splits.append(float(half_way(*ends)))
    return splits


def image_mean(
    light: ImageCase,
    function: Callable[[float, float, ImageCase], float],
    levels: list[Level],
    tolerances: Tolerances = TOLERANCES,
) -> float:
    """Mean over the image by adaptive quadrature across, within one along."""
    from scipy.integrate import quad

    half_along, half_across = light.half
    mirrored = all(place[0] == 0.0 and aim[0] == 0.0 for place, aim, _ in each_lamp(light.lamps))
    low = 0.0 if mirrored else -half_along

    grid = [(a * half_along, b * half_across) for a in SAMPLES for b in SAMPLES]
    samples = [function(u, v, light) for u, v in grid]
    least = max(DARK * max(samples), 0.1 * tolerances[0] * math.fsum(samples) / len(samples))

    def line(u: float) -> float:
        inner = [v for found in crossings_of(u, half_across, levels) for v in found]
        return pieced(lambda v: function(u, v, light), [-half_across, half_across, *inner], tolerances[0])

    def pieced(integrand: Callable[[float], float], ends: list[float], tolerance: float) -> float:
        ordered = sorted(set(ends))
        return math.fsum(
            quad(integrand, a, b, epsabs=least * (b - a), epsrel=tolerance, limit=200)[0]
            for a, b in pairwise(ordered)
            if b - a > 1e-13 * half_across
        )

    splits = outer_splits(low, half_along, half_across, levels)
    return pieced(line, [low, half_along, *splits], tolerances[1]) / ((half_along - low) * 2.0 * half_across)


def mean_signal(light: ImageCase) -> float:
    """Mean of `floor_signal` over the image [1/m^2]."""
    if light.beam.kind == "tabulated":
        return polar_mean_signal(light)
    return image_mean(light, floor_signal, signal_levels(light))


def polar_mean_signal(light: ImageCase) -> float:
    """The same in polar coordinates about the foot of one lamp, ring by ring between a profile's entries.

    For lamps that look straight down, and domes, whose image of a level floor is to scale.
    """
    if not light.shape.is_dome or any(aim[:2] != (0.0, 0.0) for aim in light.lamps.aim):
        raise ValueError(f"{light.name}: rings are for domes and lamps that look straight down")
    return math.fsum(rings(light, place, share) for place, _, share in each_lamp(light.lamps))


def rings(light: ImageCase, place: Place, share: float) -> float:
    """One lamp's part of the mean."""
    from scipy.integrate import quad

    scale_m, height_m = light.range_m + light.shape.outer_radius_m, light.range_m - place[2]
    half_x, half_y = (scale_m * half for half in light.half)
    x, y, z = place
    alone = replace(light, lamps=Lamps((x,), (y,), (z,), ((0.0, 0.0, 1.0),), (share,)))

    def arcs(radius_m: float) -> list[float]:
        turns = [0.0, 2.0 * math.pi]
        for limit, offset, first in ((half_x, place[0], 0.0), (half_y, place[1], 0.5 * math.pi)):
            for side in (-limit, limit):
                if abs(side - offset) < radius_m:
                    turn = math.acos((side - offset) / radius_m)
                    turns += [(first + turn) % (2.0 * math.pi), (first - turn) % (2.0 * math.pi)]
        return sorted(turns)

    def seen(x_m: float, y_m: float) -> float:
        return floor_signal(x_m / scale_m, y_m / scale_m, alone)

    def ring(angle_rad: float) -> float:
        radius_m, total = height_m * math.tan(angle_rad), 0.0

        def at(turn: float) -> tuple[float, float]:
            return place[0] + radius_m * math.cos(turn), place[1] + radius_m * math.sin(turn)

        ends = arcs(radius_m)
        for low, high in pairwise(ends):
            x_m, y_m = at(0.5 * (low + high))
            if abs(x_m) < half_x and abs(y_m) < half_y:
                total += quad(
                    lambda turn: seen(*at(turn)),
                    low, high, epsabs=0.0, epsrel=TOLERANCES[0], limit=100,
                )[0]  # fmt: skip
        return total * radius_m * height_m / math.cos(angle_rad) ** 2

    corners = [math.hypot(x - place[0], y - place[1]) for x in (-half_x, half_x) for y in (-half_y, half_y)]
    sides = [abs(half_x - place[0]), abs(half_x + place[0]), abs(half_y - place[1]), abs(half_y + place[1])]
    last = min(math.acos(cos_edge(light.beam)) * (1.0 - 1e-14), math.atan(max(corners) / height_m))
    knots = [*light.beam.table_angle_rad, *(math.atan(r / height_m) for r in (*corners, *sides))]
    ends = sorted({0.0, last, *(knot for knot in knots if knot < last)})
    total = math.fsum(
        quad(ring, low, high, epsabs=0.0, epsrel=TOLERANCES[1], limit=100)[0] if high - low > 1e-13 else 0.0
        for low, high in pairwise(ends)
    )
    return total / (4.0 * half_x * half_y)


def mean_veil(light: ImageCase) -> float:
    """Mean of `ray_veil` over the image [weight / (m sr)]."""
    tolerances = PROFILE_TOLERANCES if light.beam.kind == "tabulated" else TOLERANCES
    return image_mean(light, ray_veil, veil_levels(light), tolerances)
