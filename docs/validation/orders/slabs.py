"""Known numbers of radiative transfer, against the steps of `walk`: what slabs reflect, transmit and absorb."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .lamps import MOST_STEPS
from .walk import Water, compiled, drawn_angle, survivor, turned

# Slab of optical thickness 2, albedo 0.9, Henyey-Greenstein g = 0.75, light straight in, no surfaces: total reflectance
# and transmittance of van de Hulst (1980), as Wang, Jacques and Zheng (1995), Comput. Methods Programs Biomed. 47, 131,
# doi:10.1016/0169-2607(95)01640-F, quote them for their own Monte Carlo.
HULST = {"phase": "hg 0.75", "thickness": 2.0, "albedo": 0.9, "reflected": 0.09739, "transmitted": 0.66096}
ENDLESS = 60.0  # optical thickness that stands for a half-space


class Fate(NamedTuple):
    """Shares of the light that came in, and one standard error of the reflected share."""

    reflected: float
    transmitted: float
    absorbed: float
    error: float


@compiled
def through(rng: Any, water: Water, thickness: float, mu: float, n: int, out: Any) -> None:
    """Adds n photons that enter a slab (c = 1) at the cosine mu to `out`: back, through, absorbed, back squared."""
    for _ in range(n):
        dx, dy, dz, z, weight, back = np.sqrt(1.0 - mu * mu), 0.0, mu, 0.0, 1.0, 0.0
        for _ in range(10 * MOST_STEPS):
            z -= dz * np.log(1.0 - rng.random())
            if z < 0.0:
                back = weight
            if z >= thickness:
                out[1] += weight
            if z < 0.0 or z >= thickness:
                break
            out[2] += weight * (1.0 - water.albedo)
            weight = survivor(rng, weight * water.albedo, 0.05)
            if weight == 0.0:
                break
            dx, dy, dz = turned(rng, dx, dy, dz, drawn_angle(rng, water, 1.0))
        out[0] += back
        out[3] += back * back


def fate(water: Water, thickness: float, mu: float, n: int, seed: int) -> Fate:
    """What becomes of light that enters a slab."""
    out = np.zeros(4)
    through(np.random.default_rng(seed), water, thickness, mu, n, out)
    back, on, absorbed, square = (float(value) / n for value in out)
    return Fate(back, on, absorbed, float(np.sqrt(max(square - back * back, 0.0) / n)))


def h_function(mu: float, albedo: float) -> float:
    """Chandrasekhar's H(mu) of isotropic scattering.

    1/H = sqrt(1 - w) + (w/2) integral over mu' of mu' H(mu') / (mu + mu'), solved by iteration at Gauss nodes
    (Radiative Transfer, 1950, section 37).
    """
    nodes, weights = np.polynomial.legendre.leggauss(64)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    root, known = np.sqrt(1.0 - albedo), np.ones(64)
    for _ in range(60):
        known = 1.0 / (root + 0.5 * albedo * (weights * nodes * known / (nodes[:, None] + nodes)).sum(axis=1))
    return float(1.0 / (root + 0.5 * albedo * float((weights * nodes * known / (mu + nodes)).sum())))


def plane_albedo(mu: float, albedo: float) -> float:
    """Share that an isotropically scattering half-space reflects: 1 - H(mu) sqrt(1 - w)."""
    return 1.0 - h_function(mu, albedo) * float(np.sqrt(1.0 - albedo))
