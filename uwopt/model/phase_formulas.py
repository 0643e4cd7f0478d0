"""Phase functions as formulas: Henyey-Greenstein, Fournier-Forand, and that of water's own molecules.

A phase function p(psi) is the share of the scattered light that goes into a unit of solid angle at the scattering angle
psi; its integral over the sphere is 1. Quadratures ask `scattering` instead, which keeps each as a table.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.errors import RangeError
from uwopt.model.bisection import bisected, half_way

SEA_WATER_DEPOLARISATION = 0.039  # Farinato and Rowell (1976), as Zhang, Hu and He (2009) recommend
# Refractive index against slope of the size distribution, n = 1.01 + 0.1542 (mu - 3): Mobley et al. (2002).
MOBLEY_INDEX_AT_3 = 1.01
MOBLEY_INDEX_PER_SLOPE = 0.1542
FOURNIER_FORAND_RATIOS = (1e-4, 0.4)  # backscatter ratios that the Ocean Optics Web Book tabulates
SMALLEST_ANGLE_RAD = 1e-9  # the Fournier-Forand function has a pole at 0; a smaller knot counts as 0


def henyey_greenstein_per_sr(cos_angle: ArrayLike, *, asymmetry: float) -> FloatArray:
    """Henyey-Greenstein phase function.

        p = (1 - g^2) / (4 pi (1 + g^2 - 2 g cos psi)^(3/2))

    Parameters
    ----------
    cos_angle : (...,) [1], cosine of the scattering angle
    asymmetry : scalar [1], g, the mean cosine; above -1 and below 1

    Returns
    -------
    (...,) [sr^-1]

    Notes
    -----
    Made for interstellar dust; for a wanted b_b/b its forward peak is too low and its middle too high for sea
    water, so that Fournier-Forand is preferred.

    References
    ----------
    Henyey and Greenstein (1941), Astrophys. J. 93, 70.
    """
    g = float(asymmetry)
    if not -1 < g < 1:
        raise RangeError(f"asymmetry of a phase function is {g:g}; it must be above -1 and below 1")
    # 1 + g^2 - 2 g c as a sum of positive terms: no cancellation at the forward peak.
    denominator = (1 - g) ** 2 + 2 * g * (1 - np.asarray(cos_angle, dtype=float))
    return np.asarray((1 - g) * (1 + g) / (4 * np.pi * denominator**1.5), dtype=float)


def henyey_greenstein_backscatter_ratio(asymmetry: float) -> float:
    """Share scattered beyond 90 degrees by Henyey-Greenstein's function of mean cosine g.

    b_b/b = (1 - g)/(2 g) ((1 + g)/sqrt(1 + g^2) - 1), here in a form that is regular at g = 0.
    """
    g = float(asymmetry)
    root = float(np.hypot(1.0, g))
    return (1 - g) / (root * (1 + g + root))


def asymmetry_for_backscatter(ratio: float) -> float:
    """Mean cosine g of the Henyey-Greenstein function that scatters a wanted share b_b/b backwards.

    Parameters
    ----------
    ratio : scalar [1], b_b/b, above 0 and below 1; 0.5 is g = 0

    Returns
    -------
    scalar [1], root of `henyey_greenstein_backscatter_ratio`, to 1e-15
    """
    if not 0 < ratio < 1:
        raise RangeError(f"backscatter ratio b_b/b is {ratio:g}; it must be above 0 and below 1")

    def excess(asymmetry: float) -> float:
        return henyey_greenstein_backscatter_ratio(asymmetry) - ratio

    return _root(excess, -1.0, 1.0)


def fournier_forand_per_sr(angle_rad: ArrayLike, *, index: float, slope: float) -> FloatArray:
    """Fournier-Forand phase function: particles of all sizes, their numbers falling as a power of the size.

        p = [nu (1 - d) - (1 - d^nu) + (d (1 - d^nu) - nu (1 - d)) / sin^2(psi/2)] / (4 pi (1 - d)^2 d^nu)
            + (1 - d180^nu) (3 cos^2 psi - 1) / (16 pi (d180 - 1) d180^nu)
        nu = (3 - mu)/2,   d = 4 sin^2(psi/2) / (3 (n - 1)^2),   d180 = d at psi = 180 deg

    Parameters
    ----------
    angle_rad : (...,) [rad], scattering angle, 0 to pi
    index : scalar [1], n, refractive index of the particles relative to water, above 1 and below 2
    slope : scalar [1], mu of the number density ~ size^-mu, above 3 and at most 5

    Returns
    -------
    (...,) [sr^-1]; it rises without end towards 0, an angle below 1e-9 rad counts as 1e-9 rad

    Notes
    -----
    Anomalous diffraction, spheres without absorption; integrates to 1. The removable pole at d = 1 (some
    degrees from the axis) is bridged by its series.

    References
    ----------
    Fournier and Forand (1994), Proc. SPIE 2258, 194, doi:10.1117/12.190063; this form: Fournier and Jonasz
    (1999), Proc. SPIE 3761, 62, doi:10.1117/12.366488.
    """
    d180 = _ff_delta(1.0, index, slope)
    s = (slope - 3) / 2  # -nu
    angle = np.maximum(np.asarray(angle_rad, dtype=float), SMALLEST_ANGLE_RAD)
    sin2 = np.sin(angle / 2) ** 2
    _, g, h = _ff_parts(d180 * sin2, s)
    q180, _, _ = _ff_parts(np.asarray(d180), s)
    back = q180 / (16 * np.pi) * (3 * np.cos(angle) ** 2 - 1)
    return np.asarray((g / sin2 - h) / (4 * np.pi) + back, dtype=float)


def fournier_forand_backscatter_ratio(index: float, *, slope: float) -> float:
    """Share scattered beyond 90 degrees by the Fournier-Forand function, in closed form.

        b_b/b = 1 - (1 - d90^(nu+1) - (1 - d90^nu)/2) / ((1 - d90) d90^nu) = (d90^-nu - 1) / (2 (d90 - 1))

    with d90 = 2 / (3 (n - 1)^2). Source: Mobley, Sundman and Boss (2002), Appl. Opt. 41, 1035.
    """
    q, _, _ = _ff_parts(np.asarray(_ff_delta(0.5, index, slope)), (slope - 3) / 2)
    return float(q / 2)


def fournier_forand_for_backscatter(ratio: float) -> tuple[float, float]:
    """Index n and slope mu of the Fournier-Forand function that scatters a wanted share b_b/b backwards.

        n = 1.01 + 0.1542 (mu - 3), and mu such that b_b/b is met

    Parameters
    ----------
    ratio : scalar [1], b_b/b of the particles, 1e-4 to 0.4

    Returns
    -------
    n, mu : scalars [1]; `fournier_forand_backscatter_ratio` of them is the ratio, to 1e-12

    Notes
    -----
    Many pairs have the same ratio; for one ratio their functions differ little. The line gives Petzold's mean
    (n = 1.10, mu = 3.5835, b_b/b = 0.0183) and mixtures of living (n low) and mineral (n high) particles.

    References
    ----------
    Mobley, Sundman and Boss (2002), Appl. Opt. 41, 1035, doi:10.1364/AO.41.001035.
    """
    low, high = FOURNIER_FORAND_RATIOS
    if not low <= ratio <= high:
        raise RangeError(
            f"backscatter ratio b_b/b is {ratio:g}; a Fournier-Forand function takes {low:g} to {high:g}"
        )

    def excess(slope: float) -> float:
        return fournier_forand_backscatter_ratio(_mobley_index(slope), slope=slope) - ratio

    slope = _root(excess, 3.001, 5.0)
    return _mobley_index(slope), slope


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """The root between two ends of unlike sign, halved to rounding; SciPy's would cost every solve 0.3 s to import."""
    rising = function(high) > 0
    ends = bisected(lambda place: (function(place) > 0) != rising, low, high, steps=80)
    return float(half_way(*ends))


def _mobley_index(slope: float) -> float:
    return MOBLEY_INDEX_AT_3 + MOBLEY_INDEX_PER_SLOPE * (slope - 3)


def _ff_delta(sin2: float, index: float, slope: float) -> float:
    if not (1 < index < 2 and 3 < slope <= 5):
        raise RangeError(
            f"a Fournier-Forand function of index {index:g} and slope {slope:g} is not defined; "
            "the index must be above 1 and below 2, the slope above 3 and at most 5"
        )
    return 4 * sin2 / (3 * (index - 1) ** 2)


def _ff_parts(delta: FloatArray, s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The three quotients that are 0/0 at d = 1, where their series stand instead.

    q = (d^s - 1)/(d - 1),   g = (q d - s d^s)/(d - 1),   h = (q - s d^s)/(d - 1) = g - q
    """
    y = delta - 1
    near = np.abs(y) < 0.05  # direct formulas lose eps/y^2 = 1e-13; 12 terms leave 0.05^12
    y_direct = np.where(near, 1.0, y)
    log_delta = np.log(np.where(near, 2.0, delta))
    power = np.exp(s * log_delta)
    q = np.expm1(s * log_delta) / y_direct
    g, h = (q * delta - s * power) / y_direct, (q - s * power) / y_direct
    if np.any(near):
        y_near = np.where(near, y, 0.0)
        binomial = np.cumprod([1.0, *((s - k) / (k + 1) for k in range(14))])
        q_series = np.polynomial.polynomial.polyval(y_near, binomial[1:14])
        h_series = np.polynomial.polynomial.polyval(y_near, binomial[2:14] - s * binomial[1:13])
        q, g, h = (
            np.where(near, series, direct)
            for series, direct in ((q_series, q), (h_series + q_series, g), (h_series, h))
        )
    return q, g, h


def molecular_per_sr(cos_angle: ArrayLike, *, depolarisation: float = SEA_WATER_DEPOLARISATION) -> FloatArray:
    """Phase function of water itself: scattering by fluctuations of density and concentration.

        p = 3 / (4 pi (3 + f)) (1 + f cos^2 psi),   f = (1 - delta) / (1 + delta)

    Parameters
    ----------
    cos_angle : (...,) [1], cosine of the scattering angle
    depolarisation : scalar [1], delta of natural light scattered at 90 degrees, 0 to below 1

    Returns
    -------
    (...,) [sr^-1]; the integral over the sphere is 1, half of it beyond 90 degrees

    Notes
    -----
    Valid for fresh and sea water; 0.09 gives Morel's older f = 0.835.

    References
    ----------
    Morel (1974) in Optical Aspects of Oceanography; Zhang, Hu and He (2009), Opt. Express 17, 5698,
    doi:10.1364/OE.17.005698.
    """
    if not 0 <= depolarisation < 1:
        raise RangeError(f"depolarisation is {depolarisation:g}; it must be at least 0 and below 1")
    f = (1 - depolarisation) / (1 + depolarisation)
    return np.asarray(3 / (4 * np.pi * (3 + f)) * (1 + f * np.square(cos_angle)), dtype=float)
