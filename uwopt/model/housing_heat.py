"""How much warmer than the water the air in a housing becomes by what the camera draws."""

from __future__ import annotations

import math


def cooled_m2(inner_diameter_m: float, inner_length_m: float | None) -> float:
    """Inside of a wall that water cools: a tube's with one end cap, for the other is the port; a sphere's half.

        A = pi D L + pi D^2 / 4,   pi D^2 / 2

    Parameters
    ----------
    inner_diameter_m, inner_length_m : [m]; without a length a sphere, whose other half the camera looks through

    Returns
    -------
    [m2]. The port and what fixings hide are left out and in about equal parts: valid to some 20 %.
    """
    if inner_length_m is None:
        return 0.5 * math.pi * inner_diameter_m**2
    return math.pi * inner_diameter_m * (inner_length_m + 0.25 * inner_diameter_m)


def warmer_k(
    power_w: float, cooled_m2: float, *, wall_m: float, conductivity_w_mk: float, air_w_m2k: float, water_w_m2k: float
) -> float:
    """Air in a closed housing over the water around it, once neither changes any more.

        dT = P / A (1 / h_air + t / k + 1 / h_water)

    Parameters
    ----------
    power_w : that becomes heat inside, on average over an hour [W]
    cooled_m2 : wall that water cools [m2], above 0
    wall_m, conductivity_w_mk : its thickness [m] and conductivity [W/(m K)]
    air_w_m2k, water_w_m2k : from air to wall, with what is radiated, and from wall to water [W/(m2 K)]

    Returns
    -------
    [K]. Valid for: thin walls (t << D), air that moves by its own warmth, no fan and no bracket that leads heat into an
    end cap, each of which cools better. The coefficient of the air is known to a factor of 1.6 and decides; that of
    water matters little.

    References
    ----------
    Resistances in series: Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, ch. 3.
    """
    return power_w / cooled_m2 * (1.0 / air_w_m2k + wall_m / conductivity_w_mk + 1.0 / water_w_m2k)
