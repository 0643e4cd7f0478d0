"""How far a lens stands out from its camera, and between which distances it focuses then.

A lens that focuses by moving as a whole stands x farther from the sensor than at infinity. Its own focus ring gives
x up to what its nearest distance needs; a spacer ring between lens and camera adds its length at both ends. All
distances are those of the object in air, or of the virtual image that a port makes of it, from the principal plane.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Numeric = Any  # float or array that broadcasts


def extension_m(object_distance_m: Numeric, *, focal_length_m: Numeric) -> Numeric:
    """Extension of a lens focused at a distance, from its place at infinity.

        1/f = 1/s + 1/(f + x):   x = f^2 / (s - f),   m = x / f

    Parameters
    ----------
    object_distance_m, focal_length_m : broadcast [m]

    Returns
    -------
    (...,) [m]; 0 for s = inf, inf for s <= f: no extension focuses there. Valid for: thin lens.

    References
    ----------
    Gaussian imaging; Physics page, section 5.
    """
    reach = np.asarray(object_distance_m - focal_length_m, float)
    with np.errstate(divide="ignore"):
        return np.where(reach > 0.0, focal_length_m**2 / np.where(reach > 0.0, reach, 1.0), np.inf)[()]


def extended_distance_m(extension_m: Numeric, *, focal_length_m: Numeric) -> Numeric:
    """Distance at which a lens is focused that stands out so far: s = f + f^2 / x.

    Parameters
    ----------
    extension_m, focal_length_m : broadcast [m], x >= 0

    Returns
    -------
    (...,) [m]; inf for x = 0. The inverse of `extension_m`: D = 1/s = x / (f (f + x)).

    References
    ----------
    Gaussian imaging; Physics page, section 5.
    """
    with np.errstate(divide="ignore"):
        return focal_length_m + focal_length_m**2 / np.asarray(extension_m, float)


def focus_range_m(
    focal_length_m: Numeric, *, nearest_m: Numeric, spacer_m: Numeric = 0.0, thread_m: Numeric = 0.0,
    max_magnification: Numeric = np.inf,
) -> tuple[Numeric, Numeric]:  # fmt: skip
    """Nearest and farthest distance at which a lens focuses on a spacer ring.

        x = e ... e + x_0 + t,   x_0 = f^2 / (s_0 - f),   and m = x / f <= max(m_max, x_0 / f)

    Parameters
    ----------
    focal_length_m, nearest_m : broadcast [m], f and s_0, the nearest distance without a ring; s_0 <= f: no limit
    spacer_m : broadcast [m], e, length of the ring
    thread_m : broadcast [m], t, how far the lens may be screwed out of its thread beyond its own focus
    max_magnification : broadcast, m_max, that the lens bears beyond its own range

    Returns
    -------
    near, far : (...,) [m]; far is inf without a ring. Nothing lies between them where near > far.

    Notes
    -----
    Valid for: thin lens that focuses as a whole. Without ring and thread it is max(s_0, f) to inf, whatever m_max.

    References
    ----------
    Gaussian imaging; held against the table of lengths of Vision Elements, www.visionelements.co.uk.
    """
    own_near_m = np.maximum(nearest_m, focal_length_m)
    own_m = extension_m(own_near_m, focal_length_m=focal_length_m)
    most_m = np.maximum(max_magnification * focal_length_m, own_m)
    beyond = np.asarray(spacer_m) + thread_m
    reached = extended_distance_m(np.minimum(own_m + beyond, most_m), focal_length_m=focal_length_m)
    near = np.asarray(np.where(beyond > 0.0, reached, own_near_m))
    return near[()], extended_distance_m(spacer_m, focal_length_m=focal_length_m)
