"""Light scattered more than once, as attenuations that are less than c.

What is scattered by a small angle is not lost: from a lamp it still falls into its lobe, from the floor or the water it
still comes to the camera, though not where it belongs. So each leg of the light's way loses what is absorbed and a
share s of what is scattered,

    K = a + s b = c - b (1 - s)

with s from the phase function, for each purpose its own; S(psi) is the share scattered by more than psi, beta the
lobe's half angle at half power in water. Only c counts for what forms the image.

    lamp to floor                  s = S(20.2 deg + 0.86 beta)
    floor to camera, near its way  s = S(13.3 deg)
    floor to camera, all           1 - s what turns by less than 81.3 deg and bears its longer way
    backscatter, both legs         s = (3.47 - 3.54 beta / rad) S(90 deg), at most 1
    daylight, floor to camera      s = S(59.4 deg); what the way sends: `sunlight.diffuse_path_radiance_w_m2_sr_nm`

What the third leg lets through and the second does not comes from elsewhere on the floor: `veil.wide` says from where.

What is turned on the lamps' legs widens their lobes (`widened`), which stand beside these losses.

The constants are fitted to a Monte Carlo of all orders on half of its cases up to c d = 4, and judged on the other
half: docs/validation.md, section 10. Image means follow it there, and corners but the darkest.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray

LAMP_DEG, LAMP_BY_LOBE = 20.2, 0.86
NEAR_DEG, VEIL_DEG = 13.3, 81.3
BACK, BACK_BY_LOBE = 3.47, 3.54
BACK_WAY = 2.82  # of `sent_back`: times what small angles alone widen the phase function by
LEAST_OF_ABSORPTION = 0.5  # K of backscatter over a, no less: wide lobes get some back that was lost beside them
#: Factor on the share that lamp light loses of what is scattered, where the phase function is not known: that of
#: Fournier-Forand functions of b_b/b 0.005 to 0.03 and Petzold's over 0.0183's is 0.3 to 1.8 for lobes up to 40 deg.
LOST_FACTORS = (0.3, 1.8)
SUN_VEIL_DEG = 59.4
SUN_ONCE, SUN_OFTEN = 0.897, 1.10  # of `sunlight.diffuse_path_radiance_w_m2_sr_nm`
TINY = 1e-300
MOST_RETURNED = 1.0  # log of a gain: of water that turns more than half of its light back two streams do not tell
TESTED_THICKNESS = 4.0  # c times the altitude up to which the constants were fitted and judged
TESTED_FROM = 0.2  # and from which: in thinner water nothing of it matters
TESTED_LOBES_DEG = (10.0, 70.0)  # half angles at half power, in water


def lamp_angle_rad(half_power_angle_rad: ArrayLike) -> Any:
    """Angle beyond which scattered lamp light is lost on its way to the floor [rad].

        psi = 20.2 deg + 0.86 beta

    Valid for lobes of 10 to 70 deg whose middle falls into or near the image.
    """
    return np.deg2rad(LAMP_DEG) + LAMP_BY_LOBE * np.asarray(half_power_angle_rad, dtype=float)


def back_share(half_power_angle_rad: ArrayLike) -> Any:
    """How much of what is scattered backwards is lost to backscatter on its legs [1].

        3.47 - 3.54 beta / rad

    Below 0 for lobes of 56 deg and more: what went aside comes back by a second turn.
    """
    return BACK - BACK_BY_LOBE * np.asarray(half_power_angle_rad, dtype=float)


def returned_gain(absorbed: ArrayLike, *, turned_back: ArrayLike, reflectance: ArrayLike) -> FloatArray:
    """All lamp light on a floor over that which never turned back, water above and below the lamp.

        G = exp(2 (a + b_b - k) r) / (1 - R R_w),   k = sqrt(a (a + 2 b_b)),   R_w = (a + b_b - k) / b_b

    Two streams of even radiance, whose light goes twice as far as it gets on: what they have over exp(-(a + b_b) r)
    beside a light that goes straight.

    Parameters
    ----------
    absorbed, turned_back : broadcasting [1], a r and b_b r on the way to the floor
    reflectance : broadcasting [1], R of the floor, below 1

    Returns
    -------
    (...,) [1], 1 or more; 1 where nothing is turned back

    Notes
    -----
    Valid for albedos up to 0.95 and c r up to 8; beyond b_b r = 1 a rough number.

    References
    ----------
    Kubelka and Munk (1931), Z. techn. Physik 12, 593; Kubelka (1948), J. Opt. Soc. Am. 38, 448.
    """
    a, back = np.asarray(absorbed, dtype=float), np.asarray(turned_back, dtype=float)
    returned = np.square(back) / (a + back + np.sqrt(a * (a + 2.0 * back)) + TINY)  # a + b_b - k without cancellation
    water = returned / (back + TINY)
    return np.asarray(np.exp(np.minimum(2.0 * returned, MOST_RETURNED)) / (1.0 - np.asarray(reflectance) * water))


def effective_attenuation_per_m(
    attenuation_per_m: ArrayLike, *, scattering_per_m: ArrayLike, lost_share: ArrayLike
) -> FloatArray:
    """Attenuation of light of which a share of what is scattered is lost.

        K = c - b (1 - s)

    Parameters
    ----------
    attenuation_per_m, scattering_per_m : (..., n) [1/m], c and b
    lost_share : broadcasting [1], s, at most 1

    Returns
    -------
    (..., n) [1/m], at most c
    """
    b = np.asarray(scattering_per_m, dtype=float)
    return np.asarray(np.asarray(attenuation_per_m, dtype=float) - b * (1.0 - np.asarray(lost_share, dtype=float)))
