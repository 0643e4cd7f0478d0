"""How much of the image light that is scattered nearly forward still carries: Wells' small-angle transfer.

    H(nu) = exp(-c r) exp(b r chi),   chi = integral over s from 0 to 1 of the Hankel transform of p at 2 pi nu s

nu in cycles per radian. exp(-c r) alone is the image-forming light of the model, so that exp(b r chi) is what detail of
that frequency has beside it. Wells (1969), J. Opt. Soc. Am. 59, 686; below the angles at which a phase function was
measured it is its formula, or a power law, that speaks.
"""

from __future__ import annotations

import numpy as np
from scipy.special import j0

from .walk import Water, phase_of, water_of

STEPS = 40  # of s
LEAST_RAD = 1e-8


def carried(phase: str, cycles_per_rad: float) -> float:
    """chi of a phase function at a spatial frequency."""
    water: Water = water_of(1.0, 1.0, phase_of(phase))
    angle = np.r_[0.0, np.geomspace(LEAST_RAD, np.pi, 100_001)]
    share = np.interp(angle, water.angle, water.share)
    first = water.angle[1]
    power = np.log(water.share[3] / water.share[2]) / np.log(water.angle[3] / water.angle[2])
    share = np.where(angle < first, water.share[1] * (angle / first) ** power, share)
    middle, mass = np.sqrt(angle[1:] * np.maximum(angle[:-1], 0.1 * LEAST_RAD)), np.diff(share)
    steps = (np.arange(STEPS) + 0.5) / STEPS
    return float(np.mean([mass @ j0(2 * np.pi * cycles_per_rad * s * middle) for s in steps]))
