"""What uwopt's model makes of daylight in the cases of `daylight`: its forward veil and its path radiance.

A case has no K_d of a table: it is that of the walks, between port and floor, and the sun that is told to the model
stands at 60 deg; what is turned once comes from all of Snell's cone. Constants are those of `uwopt.model.multiple`,
fitted here on half of the cases up to c d = 4.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from uwopt.model import multiple, scattering, sunlight
from uwopt.model.water import illumination_attenuation_per_m

from .daylight import COS_SKY, TALLIES, Case, Light, read
from .model import backscatter_ratio, phase_table

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
ELEVATION_RAD, N_WATER = float(sunlight.REFERENCE_ELEVATION_RAD), 1.34
SCALE = 0.05


class Constants(NamedTuple):
    """As in `uwopt.model.multiple`."""

    veil_deg: float
    once: float
    often: float


USED = Constants(multiple.SUN_VEIL_DEG, multiple.SUN_ONCE, multiple.SUN_OFTEN)


def rays_of(case: Case, *, corner: bool) -> tuple[np.ndarray, np.ndarray]:
    """Cosines of the rays from straight down, and their weights times cos^4."""
    if corner:
        cos = np.array([1.0 / np.sqrt(1.0 + 2.0 * case.tangent**2)])
        return cos, cos**4
    u, v = np.meshgrid(NODES, NODES)
    cos = 1.0 / np.sqrt(1.0 + case.tangent**2 * (u * u + v * v).ravel())
    return cos, np.outer(WEIGHTS, WEIGHTS).ravel() / 4.0 * cos**4


def turned_per_m_sr(case: Case, cos: np.ndarray, cosine: float) -> np.ndarray:
    """What is scattered into rays of light that comes from one cosine in water, from everywhere about (n, 1)."""
    table = phase_table(case.phase)
    turned = sunlight.turned_per_sr(cos, table, elevation_rad=elevation_rad(cosine), n_water=N_WATER)
    return case.c_per_m * case.albedo * turned[:, None]


def elevation_rad(cosine: float) -> float:
    """Of a sun in air whose light has this cosine in water."""
    return float(np.arccos(min(N_WATER * np.sqrt(1.0 - cosine**2), 1.0)))


@lru_cache(maxsize=256)
def turned_of_sky(case: Case, *, corner: bool) -> np.ndarray:
    """The same of an even sky."""
    cos, _ = rays_of(case, corner=corner)
    share, weight = 0.5 * (NODES + 1.0), 0.5 * WEIGHTS
    each = [turned_per_m_sr(case, cos, COS_SKY + (1.0 - COS_SKY) * float(one)) for one in share]
    return np.asarray(np.tensordot(weight, each, axes=1))


def beyond(case: Case, degrees: float) -> float:
    """Share scattered by more than an angle."""
    return scattering.share_beyond(float(np.deg2rad(np.clip(degrees, 1.0, 179.0))), phase_table(case.phase))


def model(row: Light, constants: Constants = USED, *, multiple_scattering: bool = True) -> dict[str, float]:
    """Forward veil and path radiance over the irradiance at the port [1/sr]."""
    case, (cos, weight) = row.case, rays_of(row.case, corner=row.place == "corner")
    b = case.c_per_m * case.albedo
    a, path_m = case.c_per_m - b, case.altitude_m / cos
    kd = float(np.log(row.at_port / row.at_floor) / case.altitude_m)
    table = phase_table(case.phase)
    seen = dict(
        kd_per_m=np.array([kd]), depth_m=case.altitude_m, path_m=path_m, cos_field=cos, elevation_rad=ELEVATION_RAD,
        n_water=N_WATER,
    )  # fmt: skip
    entering = np.ones(1) / sunlight.REFERENCE_TRANSMITTANCE  # the port lies just below the surface
    if multiple_scattering:
        every = case.c_per_m - b * (1.0 - beyond(case, constants.veil_deg))
        path = sunlight.diffuse_path_radiance_w_m2_sr_nm(
            entering, absorption_per_m=np.array([a]),
            turned_per_m_sr=constants.once / multiple.SUN_ONCE * turned_of_sky(case, corner=row.place == "corner"),
            backward_per_m=np.array([constants.often / multiple.SUN_OFTEN * b * backscatter_ratio(table)]),
            **seen,
        )  # fmt: skip
    else:
        ratio = backscatter_ratio(table)
        every = float(illumination_attenuation_per_m(a, b_per_m=b, kd_per_m=kd, backscatter_ratio=ratio))
        path = sunlight.path_radiance_w_m2_sr_nm(
            entering, attenuation_per_m=np.array([case.c_per_m]), scattering_per_m=np.array([b]), table=table, **seen
        )
    floor = case.reflectance / np.pi * row.at_floor / row.at_port
    veil = floor * (np.exp(-every * path_m) - np.exp(-case.c_per_m * path_m))
    return {"veil": float(weight @ veil), "path": float(weight @ path[:, 0])}


def errors(row: Light, constants: Constants = USED, *, multiple_scattering: bool = True) -> dict[str, float]:
    """Relative errors of both."""
    found = model(row, constants, multiple_scattering=multiple_scattering)
    return {tally: found[tally] / getattr(row, tally) - 1.0 for tally in TALLIES}


@cache
def fitted() -> Constants:
    """The constants, from `fit` cases up to c d = 4, both places; rows count less where their own error is large."""
    rows = [row for row in read() if row.case.use == "fit" and row.case.thickness <= multiple.TESTED_THICKNESS]
    found = USED
    for tally, names in {"veil": ("veil_deg",), "path": ("once", "often")}.items():

        doubt = np.array([getattr(row, f"{tally}_error") / getattr(row, tally) for row in rows])

        def off(
            x: np.ndarray, tally: str = tally, names: tuple[str, ...] = names, known: Constants = found,
            doubt: np.ndarray = doubt,
        ) -> np.ndarray:  # fmt: skip
            now = known._replace(**dict(zip(names, map(float, x), strict=True)))
            return np.log1p([errors(row, now)[tally] for row in rows]) / np.hypot(1.0, doubt / SCALE)

        start = [getattr(found, name) for name in names]
        best = least_squares(off, start, x_scale=np.abs(start), diff_step=0.02, loss="soft_l1", f_scale=SCALE)
        found = found._replace(**dict(zip(names, map(float, best.x), strict=True)))
    return found
