"""Daylight of all orders under an even sky: what a camera over a floor sees of it, by walks back along the light.

Homogeneous water, `depth_m` of it over the camera, a level Lambertian floor `altitude_m` below, and from above even
radiance from within Snell's cone, as a sky has it behind a flat surface; the surface itself sends nothing back. A walk
from the camera ends at the floor (forward veil, if it was scattered; what was not is the signal) or at the surface
(path radiance). The floor's light and the port's come from walks of their own, touches of the floor included.
"""

from __future__ import annotations

import csv
from dataclasses import asdict, dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from .camera import BATCHES, LEAST, STEP_U, STEP_V
from .cases import PHASES, OverFloor, values_of
from .lamps import MOST_STEPS
from .walk import Water, compiled, drawn_angle, phase_of, survivor, turned, water_of

TABLE = Path(__file__).parents[1] / "daylight.csv"
SEED = 81
N_CASES = 40
COS_SKY = float(np.sqrt(1.0 - 1.0 / 1.34**2))  # of Snell's cone in water
WALKS = {"mean": 5_000_000, "corner": 2_000_000}
N_FLOOR = 200_000
TALLIES = ("veil", "path")

HEAD = """\
# Daylight of all orders of scattering under an even sky, homogeneous water over a Lambertian floor.
# at_port, at_floor: downwelling irradiance over that just below the surface [1].
# veil, path: radiance times cos^4 over the irradiance at the port [1/sr]; of light that was scattered after the floor,
# and of light that never touched it; _error: one standard error.
# Computed by docs/make_multiple_scattering.py daylight, seed {seed}.
"""


@dataclass(frozen=True)
class Case(OverFloor):
    """One water over one floor; lengths in m, angles in degrees."""

    number: int
    use: str  # `fit` or `held out`
    phase: str
    c_per_m: float  # pyrefly: ignore[bad-override]
    albedo: float
    altitude_m: float  # pyrefly: ignore[bad-override]
    depth_m: float  # of the camera
    field_deg: float  # pyrefly: ignore[bad-override]
    reflectance: float


@dataclass(frozen=True)
class Light:
    """One row."""

    case: Case
    place: str  # `mean` or `corner`
    at_port: float
    at_floor: float
    veil: float
    veil_error: float
    path: float
    path_error: float


def drawn_cases() -> list[Case]:
    """The cases: c d even in its logarithm from 0.2 to 8, 0.5 to 5 attenuation lengths of water above."""
    rng = np.random.default_rng(SEED)
    found = []
    for n, (low, high) in enumerate(pairwise(np.geomspace(0.2, 8.0, N_CASES + 1))):
        thickness = low * (high / low) ** rng.random()
        altitude = 0.5 * 12.0 ** rng.random()
        c = thickness / altitude
        depth = 0.5 * 10.0 ** rng.random() / c
        values = (c, 0.3 + 0.65 * rng.random(), altitude, depth, 30 + 60 * rng.random(), 0.02 + 0.48 * rng.random())
        use = ("fit", "held out")[n % 2]
        found.append(Case(n, use, PHASES[n % len(PHASES)], *(float(f"{value:.4g}") for value in values)))
    return found


@compiled
def left(
    rng: Any, water: Water, depth: float, floor: float, z: float, dx: float, dy: float, dz: float, weight: float
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """Follows a walk to the floor or out of the water: +1 or -1 (0: lost), its weight, its direction."""
    first = weight
    for _ in range(4 * MOST_STEPS):
        way = -np.log(1.0 - rng.random()) / water.c
        if dz > 0.0 and way * dz >= floor - z:
            return 1.0, weight, dx, dy, dz
        if dz < 0.0 and way * dz <= -depth - z:
            return -1.0, weight, dx, dy, dz
        z += way * dz
        weight = survivor(rng, weight * water.albedo, LEAST * first)
        if weight == 0.0:
            break
        dx, dy, dz = turned(rng, dx, dy, dz, drawn_angle(rng, water, 1.0))
    return 0.0, 0.0, 0.0, 0.0, 0.0


@compiled
def irradiances(
    rng: Any, water: Water, depth: float, floor: float, reflectance: float, z: float, rings: Any, n: int, out: Any
) -> None:  # fmt: skip
    """Adds to `out` (rings,) what n walks from a level place leave in each ring, touches of the floor included."""
    for _ in range(n):
        weight, at = 1.0, z
        while weight > 0.0:
            dz = -np.sqrt(rng.random())
            phi, sine = 2.0 * np.pi * rng.random(), np.sqrt(1.0 - dz * dz)
            end, weight, _x, _y, down = left(
                rng, water, depth, floor, at, sine * np.cos(phi), sine * np.sin(phi), dz, weight
            )
            if end < 0.0:
                for k in range(len(rings)):
                    if rings[k, 0] < -down < rings[k, 1]:
                        out[k] += weight
            weight = survivor(rng, weight * reflectance, LEAST) if end > 0.0 else 0.0
            at = floor


def irradiance(
    rng: Any, water: Water, depth: float, floor: float, reflectance: float, z: float, cos_sky: float, n: int
) -> float:  # fmt: skip
    """Downwelling irradiance at height z over that just below the surface, all touches of the floor, by n walks."""
    total = np.zeros(1)
    irradiances(rng, water, depth, floor, reflectance, z, np.array([[cos_sky, 2.0]]), n, total)
    return float(total[0] / n / (1.0 - cos_sky * cos_sky))


@compiled
def first_turned(
    rng: Any, water: Water, floor: float, tangent: float, spread: float, su: float, sv: float
) -> tuple[float, float, float, float, float, float, float, float]:  # fmt: skip
    """A walk from the camera that is scattered before the floor: its pixel's tangents, cosine and weight there, its
    height, and the direction in which it goes on."""
    tx = (1.0 + spread * (2.0 * (su % 1.0) - 2.0)) * tangent
    ty = (1.0 + spread * (2.0 * (sv % 1.0) - 2.0)) * tangent
    uz = 1.0 / np.sqrt(1.0 + tx * tx + ty * ty)
    weight = -np.expm1(-water.c * floor / uz)
    way = -np.log1p(-rng.random() * weight) / water.c
    dx, dy, dz = turned(rng, tx * uz, ty * uz, uz, drawn_angle(rng, water, 1.0))
    return tx, ty, uz, weight * water.albedo, way * uz, dx, dy, dz


@compiled
def batch(
    rng: Any, water: Water, depth: float, floor: float, tangent: float, spread: float, cos_sky: float, n: int, out: Any
) -> None:  # fmt: skip
    """Adds n walks to `out` (2,): share that ends at the floor, scattered, and at the sky, times cos^4."""
    su, sv = rng.random(), rng.random()
    for i in range(n):
        _tx, _ty, uz, weight, z, dx, dy, dz = first_turned(
            rng, water, floor, tangent, spread, su + i * STEP_U, sv + i * STEP_V
        )
        end, weight, _x, _y, down = left(rng, water, depth, floor, z, dx, dy, dz, weight)
        if end > 0.0:
            out[0] += weight * uz**4
        elif end < 0.0 and -down > cos_sky:
            out[1] += weight * uz**4


def computed(case: Case, place: str, share: float = 1.0) -> Light:
    """One row afresh, by a share of the usual number of walks."""
    water = water_of(case.c_per_m, case.albedo, phase_of(case.phase))
    seeds = np.random.SeedSequence((SEED, case.number, list(WALKS).index(place))).spawn(BATCHES + 1)
    heights = (0.0, case.altitude_m)
    common = (water, case.depth_m, case.altitude_m)
    rng = np.random.default_rng(seeds[-1])
    port, floor = (
        float(irradiance(rng, *common, case.reflectance, z, COS_SKY, int(N_FLOOR * share))) for z in heights
    )
    sums, n = np.zeros((BATCHES, 2)), int(WALKS[place] * share) // BATCHES
    for k, seed in enumerate(seeds[:-1]):
        batch(np.random.default_rng(seed), *common, case.tangent, float(place == "mean"), COS_SKY, n, sums[k])
    means = sums / n * np.array([case.reflectance / np.pi * floor / port, 1.0 / (np.pi * (1 - COS_SKY**2) * port)])
    mean, error = means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(BATCHES)
    return Light(case, place, port, floor, *(float(x) for pair in zip(mean, error, strict=True) for x in pair))


def write(path: Path = TABLE) -> None:
    """All cases, thin and thick mixed."""
    cases = drawn_cases()
    numbers = [field.name for field in fields(Light) if field.name not in ("case", "place")]
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(HEAD.format(seed=SEED))
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*(field.name for field in fields(Case)), "place", *numbers])
        for case in [case for first in range(7) for case in cases[first::7]]:
            for place in WALKS:
                light = computed(case, place)
                found = (f"{getattr(light, name):.5g}" for name in numbers)
                writer.writerow([*map(str, asdict(case).values()), place, *found])
                file.flush()


def read(path: Path = TABLE) -> list[Light]:
    """The table as it was written."""
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return [Light(case=Case(**values_of(Case, row)), **values_of(Light, row)) for row in rows]
