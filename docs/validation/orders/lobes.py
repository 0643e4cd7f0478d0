"""A lamp's lobe as light that is scattered on its way from the lamp widens it: tried, and not in the model.

Light that turns by psi at a share s of its way r arrives as if it had left the lamp by (1 - s) psi. Of order l of the
lobe's Legendre series arrives, all orders of scattering counted, as in `uwopt.model.detail` for what is seen,

    I_l exp(-c r + b r chi_l),   chi_l = integral over s from 0 to 1, psi from 0 to 90 deg, of p P_l(cos((1 - s) psi))

Nothing in it is fitted. The unscattered lobe is kept as it is; what is scattered is added to it as a sum over l. Beyond
90 deg light counts as lost. For a floor r is the altitude; for backscatter, half of it.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from uwopt.model import beam as beams
from uwopt.model.detail import masses_by_angle

from .cases import Case
from .model import phase_table

ORDERS, MOST_RAD, BACK_WAY = 90, 0.5 * np.pi, 0.5
ANGLES_RAD = np.linspace(0.0, 0.5 * np.pi, 361)
Array = np.ndarray[Any, Any]


def legendre(x: Array) -> Array:
    """P_0 to P_ORDERS, (ORDERS + 1, ...)."""
    made = np.empty((ORDERS + 1, *x.shape))
    made[0], made[1] = 1.0, x
    for n in range(1, ORDERS):
        made[n + 1] = ((2 * n + 1) * x * made[n] - n * made[n - 1]) / (n + 1)
    return made


def nodes(count: int) -> tuple[Array, Array]:
    """Gauss-Legendre on [0, 1]."""
    x, weight = np.polynomial.legendre.leggauss(count)
    return (x + 1.0) / 2.0, weight / 2.0


@cache
def carried(phase: str) -> Array:
    """chi_l of a phase function."""
    angle, mass = masses_by_angle(phase_table(phase))
    angle, mass = angle[angle < MOST_RAD], mass[angle < MOST_RAD]
    each = [weight * (legendre(np.cos((1.0 - s) * angle)) @ mass) for s, weight in zip(*nodes(12), strict=True)]
    return np.asarray(np.sum(each, axis=0))


def widened(case: Case, lamp_per_m: float, way_m: float) -> beams.Beam:
    """The case's lobe after a way through its water, over what the attenuation `lamp_per_m` leaves of it."""
    lobe = beams.cosine_power_beam(np.deg2rad(2 * case.lobe_half_deg))
    cos, weight = nodes(400)
    order = np.arange(ORDERS + 1)
    own = 2 * np.pi * (legendre(cos) * beams.intensity_per_sr(cos, lobe) * weight).sum(axis=1)
    gained = own * np.expm1(case.c_per_m * case.albedo * way_m * carried(case.phase)) * (2 * order + 1) / (4 * np.pi)
    cos = np.cos(ANGLES_RAD)
    values = beams.intensity_per_sr(cos, lobe) + gained @ legendre(cos)
    values = np.maximum(values, 0.0) * np.exp(-(case.c_per_m - lamp_per_m) * way_m)
    return beams.Beam(
        "tabulated", table_angle_rad=tuple(ANGLES_RAD.tolist()), table_intensity_per_sr=tuple(values.tolist())
    )
