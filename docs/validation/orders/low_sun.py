"""Path radiance under a sun that stands low: the walks of `daylight`, sorted by where they leave the water.

Light may be walked in either sense, so that one set of walks tells what every sun sends: a walk that leaves towards a
place of the sky counts for a sun there. Suns fill rings of the cosine in water; about the camera's rays into the corner
of the image a ring is cut in four.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from uwopt.model import sunlight
from uwopt.model.multiple import TESTED_THICKNESS

from .camera import STEP_U, STEP_V
from .daylight import SEED, Case, drawn_cases, first_turned, irradiances, left
from .model import backscatter_ratio, phase_table
from .sunlit import N_WATER, elevation_rad, rays_of, turned_per_m_sr
from .walk import Water, compiled, phase_of, water_of

RINGS = ((0.67, 0.71), (0.74, 0.78), (0.84, 0.88), (0.95, 0.99))  # cosines in water
WALKS, N_IRRADIANCE, BATCHES = 1_600_000, 1_600_000, 8
QUARTERS = 4  # of the azimuth between ray and sun: towards it, aside twice, away


@compiled
def paths(
    rng: Any, water: Water, depth: float, floor: float, tangent: float, spread: float, rings: Any, n: int, out: Any
) -> None:  # fmt: skip
    """Adds to `out` (rings, quarters) what n scattered walks from the camera leave there, times cos^4."""
    su, sv = rng.random(), rng.random()
    for i in range(n):
        tx, ty, uz, weight, z, dx, dy, dz = first_turned(
            rng, water, floor, tangent, spread, su + i * STEP_U, sv + i * STEP_V
        )
        end, weight, dx, dy, dz = left(rng, water, depth, floor, z, dx, dy, dz, weight)
        if end < 0.0:
            for k in range(len(rings)):
                if rings[k, 0] < -dz < rings[k, 1]:
                    azimuth = abs(np.arctan2(tx * dy - ty * dx, tx * dx + ty * dy))
                    out[k, min(int(azimuth / np.pi * 4.0), 3)] += weight * uz**4


@dataclass(frozen=True)
class Sun:
    """What one ring sends: path radiance over the irradiance at the port [1/sr], image mean and corner by quarter."""

    case: Case
    cosine: float
    mean: float
    error: float
    corner: tuple[float, ...]  # the sun before the camera's ray, at 45 to 90 deg, 90 to 135, and behind it
    model: float  # of the image mean
    model_corner: float


def suns(case: Case, share: float = 1.0) -> list[Sun]:
    """All rings over one water."""
    water, rings = water_of(case.c_per_m, case.albedo, phase_of(case.phase)), np.array(RINGS)
    common = (water, case.depth_m, case.altitude_m)
    seeds = np.random.SeedSequence((SEED, case.number, 7)).spawn(BATCHES + 1)
    level = np.zeros((2, len(rings)))
    rng, n_level = np.random.default_rng(seeds[-1]), int(N_IRRADIANCE * share)
    for row, z in zip(level, (0.0, case.altitude_m), strict=True):
        irradiances(rng, *common, case.reflectance, z, rings, n_level, row)
    found, n = np.zeros((2, BATCHES, len(rings), QUARTERS)), int(WALKS * share) // BATCHES
    for k, seed in enumerate(seeds[:-1]):
        rng = np.random.default_rng(seed)
        for place, spread in zip(found, (1.0, 0.0), strict=True):
            paths(rng, *common, case.tangent, spread, rings, n, place[k])
    over_port = found / n / (np.pi * level[0] / n_level)[:, None]
    means = over_port[0].sum(axis=-1)
    corner = QUARTERS * over_port[1].mean(axis=0)
    kd = np.log(level[0] / level[1]) / case.altitude_m
    made = []
    for k, ring in enumerate(RINGS):
        cosine = 0.5 * sum(ring)
        ours = [modelled(case, cosine, float(kd[k]), corner=at) for at in (False, True)]
        doubt = float(means[:, k].std(ddof=1) / np.sqrt(BATCHES))
        made.append(Sun(case, cosine, float(means[:, k].mean()), doubt, tuple(map(float, corner[k])), *ours))
    return made


def modelled(case: Case, cosine: float, k_per_m: float, *, corner: bool) -> float:
    """The model's path radiance over the irradiance at the port, told the walks' K under that sun."""
    elevation = elevation_rad(cosine)
    cos, weight = rays_of(case, corner=corner)
    kd = k_per_m / float(sunlight.path_factor(elevation, n_water=N_WATER))
    backward = case.c_per_m * case.albedo * backscatter_ratio(phase_table(case.phase))
    radiance = sunlight.diffuse_path_radiance_w_m2_sr_nm(
        np.ones(1) / sunlight.surface_factor(elevation, n_water=N_WATER), kd_per_m=np.array([kd]),
        absorption_per_m=np.array([case.c_per_m * (1.0 - case.albedo)]),
        turned_per_m_sr=turned_per_m_sr(case, cos, cosine), backward_per_m=np.array([backward]),
        depth_m=case.altitude_m, path_m=case.altitude_m / cos,
        cos_field=cos, elevation_rad=elevation, n_water=N_WATER,
    )  # fmt: skip
    return float(weight @ radiance[:, 0])


@cache
def all_suns() -> tuple[Sun, ...]:
    """Of the held-out waters of `daylight` up to c d = 4."""
    wanted = [case for case in drawn_cases() if case.use == "held out" and case.thickness <= TESTED_THICKNESS]
    return tuple(sun for case in wanted for sun in suns(case))
