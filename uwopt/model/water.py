"""What the water does to light on its way: attenuation and refractive index.

The transmission of a spectrum over two paths, contracted for speed, is in `path_table`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.errors import RangeError
from uwopt.model.spectrum import Symbolic, resample


def beam_attenuation_per_m(a_per_m: Symbolic, b_per_m: Symbolic) -> Symbolic:
    """Beam attenuation c = a + b [1/m], from absorption and scattering."""
    return a_per_m + b_per_m


def illumination_attenuation_per_m(
    a_per_m: ArrayLike, *, b_per_m: ArrayLike, kd_per_m: ArrayLike, backscatter_ratio: ArrayLike
) -> FloatArray:
    """Attenuation of a lamp's broad beam on its way to the floor.

        K = K_d clipped to a + b_b <= K <= c,   b_b = (b_b/b) b,   c = a + b

    Parameters
    ----------
    a_per_m, b_per_m, kd_per_m : (n,) or broadcasting [1/m]
    backscatter_ratio : scalar [1], b_b/b, 0 to 1

    Returns
    -------
    (n,) [1/m]

    Notes
    -----
    Light scattered forward stays in a broad beam, light scattered back or absorbed is lost. Tables of K_d
    fall below a + b_b in places; the clip mends that. Monte Carlo agrees within 3 % in Jerlov II-III,
    K_d is 6-25 % low in 1C-5C.

    References
    ----------
    Physics page, section 2.
    """
    a, b = np.asarray(a_per_m, dtype=float), np.asarray(b_per_m, dtype=float)
    return np.asarray(np.clip(kd_per_m, a + np.asarray(backscatter_ratio) * b, a + b), dtype=float)


def extend_absorption_per_m(
    wavelength_nm: ArrayLike,
    *,
    table_nm: ArrayLike,
    table_a_per_m: ArrayLike,
    pure_water_nm: ArrayLike,
    pure_water_a_per_m: ArrayLike,
) -> FloatArray:
    """Absorption at any wavelength: linear in the table, beyond it the rise of pure water added to its end.

        a(lambda) = a(end) + a_w(lambda) - a_w(end),   never below 0

    Parameters
    ----------
    wavelength_nm : (n,) [nm]
    table_nm, table_a_per_m : (m,) [nm] increasing, [1/m]
    pure_water_nm, pure_water_a_per_m : (k,) [nm] increasing, [1/m]; RangeError where it is needed and ends

    Returns
    -------
    (n,) [1/m]

    Notes
    -----
    Takes what is dissolved or suspended as grey beyond the table: good in the red, low in the ultraviolet.
    """
    wavelength = np.asarray(wavelength_nm, dtype=float)
    ends = np.asarray(table_nm, dtype=float)[[0, -1]]
    a = resample(wavelength, table_nm=table_nm, table_values=table_a_per_m, outside="hold")
    beyond = (wavelength < ends[0]) | (wavelength > ends[1])
    if not np.any(beyond):
        return a
    pure: dict[str, Any] = {"table_nm": pure_water_nm, "table_values": pure_water_a_per_m, "outside": "raise"}
    outer = wavelength[beyond]
    a[beyond] += resample(outer, **pure) - resample(np.clip(outer, *ends), **pure)
    return np.maximum(a, 0.0)


def refractive_index_quan_fry(
    wavelength_nm: Symbolic, *, temperature_c: Symbolic, salinity_psu: Symbolic, coefficients: Sequence[float]
) -> Symbolic:
    """Refractive index of water, relative to air, at atmospheric pressure.

        n = n0 + (n1 + n2 T + n3 T^2) S + n4 T^2 + (n5 + n6 S + n7 T)/l + n8/l^2 + n9/l^3

    Parameters
    ----------
    wavelength_nm : (...,) [nm]
    temperature_c, salinity_psu : broadcasting [degC], [psu]
    coefficients : n0 ... n9

    Returns
    -------
    (...,) [1]

    Notes
    -----
    Valid for 400-700 nm, 0-30 degC, 0-35 psu; beyond that the formula extrapolates smoothly. Pressure
    raises the index a little with depth; that is left out.

    References
    ----------
    Quan and Fry (1995), Appl. Opt. 34, 3477, doi:10.1364/AO.34.003477.
    """
    if len(coefficients) != 10:
        raise RangeError(f"the Quan-Fry formula takes 10 coefficients, not {len(coefficients)}")
    n0, n1, n2, n3, n4, n5, n6, n7, n8, n9 = coefficients
    T, S, per_nm = temperature_c, salinity_psu, 1.0 / wavelength_nm
    dispersion = (n5 + n6 * S + n7 * T + (n8 + n9 * per_nm) * per_nm) * per_nm
    return n0 + (n1 + (n2 + n3 * T) * T) * S + n4 * T * T + dispersion
