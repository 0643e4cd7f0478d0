"""Sunlight in the water: what reaches the floor, and what it scatters into a camera that looks at the floor.

Angles: the elevation of the sun is measured in air from the horizon; the zenith angle of its light in water
from the vertical. Depth is measured from the surface down; a ray runs from the port towards the floor.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.errors import RangeError
from uwopt.model.multiple import SUN_OFTEN, SUN_ONCE
from uwopt.model.phase_formulas import molecular_per_sr
from uwopt.model.port import fresnel_by_polarisation
from uwopt.model.scattering import PhaseTable, look_up

# Share of the horizontal irradiance that enters the water, sun and sky, for the sun at 60 deg: physics page,
# section 8. Other elevations are relative to it.
REFERENCE_TRANSMITTANCE = 0.95
REFERENCE_ELEVATION_RAD = np.deg2rad(60.0)
LEAST_ABSORPTION_PER_M = 1e-4  # of `diffuse_path_radiance_w_m2_sr_nm`: a tenth of the clearest water's
N_AZIMUTH = 64  # of a mean over azimuth; trapezoid rule of a periodic function


def refracted_cos_zenith(elevation_rad: ArrayLike, *, n_water: ArrayLike) -> Any:
    """Cosine of the zenith angle of the sun's light in the water, mu_w.

        mu_w = sqrt(1 - (cos(elevation) / n_w)^2)

    Parameters
    ----------
    elevation_rad : (...,) [rad], of the sun in air, above the horizon; above 0 and at most pi/2
    n_water : broadcasting [1]

    Returns
    -------
    (...,) [1]; flat water
    """
    elevation = _checked_elevation(elevation_rad)
    return np.sqrt(1 - (np.cos(elevation) / np.asarray(n_water, dtype=float)) ** 2)


def surface_factor(elevation_rad: ArrayLike, *, n_water: ArrayLike) -> Any:
    """Share of the horizontal irradiance above the water that enters it.

        0.95 T(elevation) / T(60 deg),   T = 1 - (r_s^2 + r_p^2)/2  of flat water

    Parameters
    ----------
    elevation_rad : (...,) [rad], of the sun in air, above 0 and at most pi/2
    n_water : broadcasting [1]

    Returns
    -------
    (...,) [1]; 0.95 at 60 deg, 0 at grazing light

    Notes
    -----
    0.95 covers sun, sky and waves together; only its change with the sun's elevation is Fresnel's, which makes
    it too low below about 20 deg, where sky light and waves count.

    References
    ----------
    Physics page, section 8. Fresnel: Born and Wolf, Principles of Optics, section 1.5.
    """
    reference = _fresnel_transmittance(REFERENCE_ELEVATION_RAD, n_water)
    return REFERENCE_TRANSMITTANCE * _fresnel_transmittance(elevation_rad, n_water) / reference


def path_factor(elevation_rad: ArrayLike, *, n_water: ArrayLike) -> Any:
    """How much longer light's way down is than with the sun at 60 deg: mu_w(60 deg) / mu_w(elevation) [1]."""
    reference = refracted_cos_zenith(REFERENCE_ELEVATION_RAD, n_water=n_water)
    return reference / refracted_cos_zenith(elevation_rad, n_water=n_water)


def downwelling_irradiance_w_m2_nm(
    surface_w_m2_nm: ArrayLike,
    *,
    kd_per_m: ArrayLike,
    depth_m: ArrayLike,
    elevation_rad: float,
    n_water: float,
) -> FloatArray:
    """Irradiance of daylight on a horizontal plane in the water.

        E_d(z) = E_surface * 0.95 T(e)/T(60 deg) * exp(-K_d z mu_w(60 deg)/mu_w(e))

    Parameters
    ----------
    surface_w_m2_nm : (n,) [W m^-2 nm^-1], horizontal, just above the water
    kd_per_m : (n,) [1/m], diffuse attenuation, as tabulated for a high sun
    depth_m : scalar or (...,) [m], below the surface, 0 or more
    elevation_rad : scalar [rad], of the sun in air, above 0 and at most pi/2
    n_water : scalar [1]

    Returns
    -------
    (..., n) [W m^-2 nm^-1]

    Notes
    -----
    K_d is taken as the same at all depths. At 60 deg both factors of elevation drop out.

    References
    ----------
    Physics page, section 8.
    """
    depth = np.asarray(depth_m, dtype=float)
    if np.any(depth < 0):
        raise RangeError(f"a depth of {depth.min():g} m is above the surface; depths are 0 m or more")
    loss_per_m = np.asarray(kd_per_m, dtype=float) * path_factor(elevation_rad, n_water=n_water)
    entering = np.asarray(surface_w_m2_nm, dtype=float) * surface_factor(elevation_rad, n_water=n_water)
    return np.asarray(entering * np.exp(-loss_per_m * depth[..., None]), dtype=float)


def scattering_cosine(
    cos_field: ArrayLike, *, azimuth_rad: ArrayLike, elevation_rad: float, n_water: float
) -> Any:
    """Cosine of the angle by which sunlight turns on its way into the camera.

        cos psi = -(mu_w cos a + sqrt(1 - mu_w^2) sin a cos phi)

    Parameters
    ----------
    cos_field : (...,) [1], cosine of the angle a of the camera's ray in water from straight down
    azimuth_rad : broadcasting [rad], phi, of the ray against the direction in which sunlight travels
    elevation_rad, n_water : scalars [rad], [1]

    Returns
    -------
    broadcast [1]; -1 where the camera looks along the sunlight, away from the sun
    """
    cos_ray = np.asarray(cos_field, dtype=float)
    cos_sun = refracted_cos_zenith(elevation_rad, n_water=n_water)
    sines = np.sqrt((1 - cos_sun * cos_sun) * np.maximum(1 - cos_ray * cos_ray, 0.0))
    return -(cos_sun * cos_ray + sines * np.cos(azimuth_rad))


def path_radiance_w_m2_sr_nm(
    surface_w_m2_nm: ArrayLike,
    *,
    kd_per_m: ArrayLike,
    attenuation_per_m: ArrayLike,
    scattering_per_m: ArrayLike,
    table: PhaseTable,
    molecular_scattering_per_m: ArrayLike = 0.0,
    depth_m: ArrayLike,
    path_m: ArrayLike,
    cos_field: ArrayLike = 1.0,
    azimuth_rad: ArrayLike | None = None,
    elevation_rad: float,
    n_water: float,
    n_azimuth: int = N_AZIMUTH,
) -> FloatArray:
    """Radiance of the veil that sunlight makes along a camera's ray from the port to the floor.

        L = integral from 0 to R of beta(psi) E_d(z(r)) / mu_w exp(-c r) dr
          = beta(psi) E_d(z_port) / mu_w * R (1 - exp(-k R)) / (k R),   k = c + K cos a
        z(r) = z_port + r cos a,   z_port = z_floor - R cos a,   K = K_d mu_w(60 deg)/mu_w(e)
        beta = b p(psi) + b_w p_w(psi)

    Parameters
    ----------
    surface_w_m2_nm : (n,) [W m^-2 nm^-1], horizontal, just above the water
    kd_per_m, attenuation_per_m : (n,) [1/m], K_d and c
    scattering_per_m : (n,) [1/m], b that `table` distributes: of the particles, or of all where the measured
        function holds the water too
    table : PhaseTable
    molecular_scattering_per_m : (n,) or scalar [1/m], b_w; 0 where `table` holds it
    depth_m : (...,) [m], of the floor below the surface
    path_m : (...,) [m], R, along the ray in water
    cos_field : (...,) [1], cosine of the ray's angle a in water from straight down
    azimuth_rad : (...,) [rad] of the ray against the direction in which sunlight travels; None: mean over all
    elevation_rad, n_water : scalars [rad], [1]
    n_azimuth : points of the mean over azimuth

    Returns
    -------
    (..., n) [W m^-2 sr^-1 nm^-1], in water, at the port

    Notes
    -----
    Single scattering; all daylight counts as coming from the sun's direction, dimmed with K_d, so that light
    scattered forward is still in the beam. Any c R is safe: it can only underflow to 0.
    RangeError where the port would be above the surface.

    References
    ----------
    Physics page, section 8; Jaffe (1990), IEEE J. Oceanic Eng. 15, 101, for the integral along the ray.
    """
    depth, path, cos_ray = (np.asarray(x, dtype=float) for x in (depth_m, path_m, cos_field))
    port_depth = depth - path * cos_ray
    if np.any(port_depth < -1e-9 * np.abs(depth)):
        raise RangeError(
            f"a floor at {np.max(depth):g} m seen over {np.max(path):g} m puts the camera above the surface; "
            "make the scene deeper than the altitude, or set sun_lux to 0"
        )
    at_port = downwelling_irradiance_w_m2_nm(
        surface_w_m2_nm,
        kd_per_m=kd_per_m,
        depth_m=np.maximum(port_depth, 0.0),
        elevation_rad=elevation_rad,
        n_water=n_water,
    )
    beam = at_port / refracted_cos_zenith(elevation_rad, n_water=n_water)
    phase, molecular = _mean_phase_per_sr(cos_ray, azimuth_rad, table, elevation_rad, n_water, n_azimuth)
    volume = np.asarray(scattering_per_m, dtype=float) * phase[..., None] + (
        np.asarray(molecular_scattering_per_m, dtype=float) * molecular[..., None]
    )
    loss_per_m = np.asarray(kd_per_m, dtype=float) * path_factor(elevation_rad, n_water=n_water)
    total_per_m = np.asarray(attenuation_per_m, dtype=float) + loss_per_m * cos_ray[..., None]
    return np.asarray(volume * beam * path[..., None] * _mean_exp(total_per_m * path[..., None]), dtype=float)


def diffuse_path_radiance_w_m2_sr_nm(
    surface_w_m2_nm: ArrayLike,
    *,
    kd_per_m: ArrayLike,
    absorption_per_m: ArrayLike,
    turned_per_m_sr: ArrayLike,
    backward_per_m: ArrayLike,
    depth_m: ArrayLike,
    path_m: ArrayLike,
    cos_field: ArrayLike,
    elevation_rad: float,
    n_water: float,
) -> FloatArray:
    """The same veil with light scattered more than once, lost by absorption alone.

        L = B E_d(z_port) / mu_w * R (1 - exp(-k R)) / (k R),   k = a + K cos a
        B = 0.897 b p + 1.10 (K_d / a - 1) b_b / (2 pi)

    Light that comes as it entered the water is turned by the angle between, that which was turned before comes from all
    about: the more there is of it, the more K_d is over a.

    Parameters
    ----------
    absorption_per_m : (n,) [1/m], a
    turned_per_m_sr : (..., n) [1/(m sr)], b p, the mean over where daylight comes from; see `turned_per_sr`
    backward_per_m : (n,) [1/m], b_b
    surface_w_m2_nm, kd_per_m, depth_m, path_m, cos_field, elevation_rad, n_water : as in `path_radiance_w_m2_sr_nm`

    Returns
    -------
    (..., n) [W m^-2 sr^-1 nm^-1], in water, at the port

    Notes
    -----
    K_d counts as no less than a. Fitted to a Monte Carlo of all orders under an even sky, c R up to 8 and albedo of 0.3
    to 0.95, 0.5 to 5 attenuation lengths under the surface: docs/validation.md, section 10.
    """
    depth, path, cos_ray = (np.asarray(x, dtype=float) for x in (depth_m, path_m, cos_field))
    kd, absorbed = np.asarray(kd_per_m, dtype=float), np.asarray(absorption_per_m, dtype=float)
    at_port = downwelling_irradiance_w_m2_nm(
        surface_w_m2_nm, kd_per_m=kd, depth_m=np.maximum(depth - path * cos_ray, 0.0), elevation_rad=elevation_rad,
        n_water=n_water,
    )  # fmt: skip
    often = np.maximum(kd / np.maximum(absorbed, LEAST_ABSORPTION_PER_M) - 1.0, 0.0)
    source = SUN_ONCE * np.asarray(turned_per_m_sr, dtype=float)
    source = source + SUN_OFTEN * often * np.asarray(backward_per_m, dtype=float) / (2 * np.pi)
    beam = at_port / refracted_cos_zenith(elevation_rad, n_water=n_water)
    total_per_m = absorbed + kd * path_factor(elevation_rad, n_water=n_water) * cos_ray[..., None]
    return np.asarray(source * beam * path[..., None] * _mean_exp(total_per_m * path[..., None]), dtype=float)


def turned_per_sr(
    cos_field: ArrayLike, table: PhaseTable | None, *, elevation_rad: float, n_water: float, n_azimuth: int = N_AZIMUTH
) -> FloatArray:  # fmt: skip
    """Phase function by which sunlight turns into a camera's ray, the mean over azimuth.

        integral over phi of p(psi) d phi / (2 pi),   psi as in `scattering_cosine`

    Parameters
    ----------
    cos_field : (...,) [1], cosine of the ray's angle in water from straight down
    table : PhaseTable; None: the water's molecules
    elevation_rad, n_water : scalars [rad], [1]
    n_azimuth : points of the mean

    Returns
    -------
    (...,) [1/sr]
    """
    round_rad = 2 * np.pi * (np.arange(n_azimuth) + 0.5) / n_azimuth
    cos_ray = np.asarray(cos_field, dtype=float)[..., None]
    cosine = scattering_cosine(cos_ray, azimuth_rad=round_rad, elevation_rad=elevation_rad, n_water=n_water)
    phase = molecular_per_sr(cosine) if table is None else look_up(cosine, table)
    return np.asarray(np.mean(phase, axis=-1))


def _mean_phase_per_sr(
    cos_ray: FloatArray,
    azimuth_rad: ArrayLike | None,
    table: PhaseTable,
    elevation_rad: float,
    n_water: float,
    n_azimuth: int,
) -> tuple[FloatArray, FloatArray]:
    """Phase functions of particles and of water at the ray's scattering angle, or their means over azimuth."""
    sun: dict[str, float] = {"elevation_rad": elevation_rad, "n_water": n_water}
    if azimuth_rad is not None:
        cosine = scattering_cosine(cos_ray, azimuth_rad=azimuth_rad, **sun)
        return np.asarray(look_up(cosine, table)), molecular_per_sr(cosine)
    particles, water = (turned_per_sr(cos_ray, one, n_azimuth=n_azimuth, **sun) for one in (table, None))
    return particles, water


def _mean_exp(x: FloatArray) -> FloatArray:
    """Mean of exp(-x u) over u from 0 to 1: (1 - exp(-x))/x, and 1 at x = 0."""
    safe = np.where(x == 0, 1.0, x)
    return np.where(x == 0, 1.0, -np.expm1(-safe) / safe)


def _fresnel_transmittance(elevation_rad: ArrayLike, n_water: ArrayLike) -> FloatArray:
    """Transmittance of a flat surface from air into water for unpolarised light."""
    cos_air = np.sin(_checked_elevation(elevation_rad))
    across, along, _ = fresnel_by_polarisation(cos_air, n_from=1.0, n_to=np.asarray(n_water, dtype=float))
    return np.asarray((across + along) / 2, dtype=float)


def _checked_elevation(elevation_rad: ArrayLike) -> FloatArray:
    elevation = np.asarray(elevation_rad, dtype=float)
    if not np.all(elevation > 0):
        raise RangeError("a sun below the horizon gives no light: set sun_lux to 0")
    if not np.all(elevation <= np.pi / 2 * (1 + 1e-12)):
        raise RangeError(
            f"elevation of the sun is {np.rad2deg(np.max(elevation)):g} deg; it must be at most 90 deg"
        )
    return elevation
