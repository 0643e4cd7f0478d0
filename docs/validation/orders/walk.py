"""Steps that every walk of light in homogeneous water is made of; compiled where numba is installed.

A phase function is three arrays: scattering angles [rad], the share scattered by less than each, and its values
[1/sr]. Nothing is truncated: angles are drawn from the whole function.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..photons import FINE, Phase, fournier_forand, petzold

_njit: Any = None
if not os.environ.get("NUMBA_DISABLE_JIT"):  # tests follow a few hundred walks without it
    with contextlib.suppress(ImportError):
        from numba import njit as _njit

COMPILED = _njit is not None


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, compiled and kept for the next run where numba is there."""
    return function if _njit is None else _njit(cache=True)(function)


class Water(NamedTuple):
    """Homogeneous water of one wavelength."""

    c: float  # beam attenuation [1/m]
    albedo: float  # b / c
    angle: Any  # (n,) [rad]
    share: Any  # (n,), scattered by less than the angle
    values: Any  # (n,) [1/sr]

    @property
    def a(self) -> float:
        """Absorption [1/m]."""
        return self.c * (1.0 - self.albedo)

    @property
    def b(self) -> float:
        """Scattering [1/m]."""
        return self.c * self.albedo


def phase_of(name: str) -> Phase:
    """`ff 0.0183` (Fournier-Forand, b_b/b), `hg 0.9` (Henyey-Greenstein, g), `petzold HAOCE 11`, `isotropic`."""
    kind, _, rest = name.partition(" ")
    if kind == "ff":
        return fournier_forand(float(rest))
    if kind == "petzold":
        return petzold(rest)
    g = float(rest) if kind == "hg" else 0.0
    return Phase(FINE, (1 - g * g) / (4 * np.pi * ((1 - g) ** 2 + 4 * g * np.sin(FINE / 2) ** 2) ** 1.5))


def water_of(c: float, albedo: float, phase: Phase) -> Water:
    """Water with the arrays of a phase function, and with what its peak holds below the first angle."""
    values = np.exp(phase.log)
    steepness = -(phase.log[1] - phase.log[0]) / np.log(phase.angle[1] / phase.angle[0])
    peak = 2 * np.pi * values[0] * phase.angle[0] ** 2 / (2 - steepness)
    whole = peak + phase.total
    share = np.r_[0.0, peak + phase.total * phase.cumulative] / whole
    return Water(c, albedo, np.r_[0.0, phase.angle], share, np.r_[values[0], values] / whole)


@compiled
def drawn_angle(rng: Any, water: Water, most: float) -> float:
    """A scattering angle [rad] among the share `most` that turns least."""
    u = rng.random() * most
    i = min(np.searchsorted(water.share, u, side="right"), len(water.share) - 1)
    low, high = water.share[i - 1], water.share[i]
    at = (u - low) / (high - low) if high > low else 0.0
    return water.angle[i - 1] + at * (water.angle[i] - water.angle[i - 1])


@compiled
def phase_at(cos: float, water: Water) -> float:
    """The phase function [1/sr] at the cosine of a scattering angle."""
    psi = np.arccos(min(max(cos, -1.0), 1.0))
    i = min(max(np.searchsorted(water.angle, psi), 1), len(water.angle) - 1)
    at = (psi - water.angle[i - 1]) / (water.angle[i] - water.angle[i - 1])
    return water.values[i - 1] + min(max(at, 0.0), 1.0) * (water.values[i] - water.values[i - 1])


@compiled
def across(x: float, y: float, z: float) -> tuple[float, float, float, float, float, float]:
    """Two unit vectors square to a unit vector and to each other (Duff et al. 2017, J. Comput. Graph. Tech. 6, 1)."""
    sign = 1.0 if z >= 0.0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return 1.0 + sign * x * x * a, sign * b, -sign * x, b, sign + y * y * a, -y


@compiled
def turned(rng: Any, x: float, y: float, z: float, psi: float) -> tuple[float, float, float]:
    """A unit vector after a turn by the angle psi, azimuth drawn."""
    ax, ay, az, bx, by, bz = across(x, y, z)
    phi = 2.0 * np.pi * rng.random()
    sine = np.sin(psi)
    s, t, u = sine * np.cos(phi), sine * np.sin(phi), np.cos(psi)
    vx, vy, vz = u * x + s * ax + t * bx, u * y + s * ay + t * by, u * z + s * az + t * bz
    length = np.sqrt(vx * vx + vy * vy + vz * vz)
    return vx / length, vy / length, vz / length


@compiled
def survivor(rng: Any, weight: float, least: float) -> float:
    """The weight after a draw that ends faint walks: 0, or no less than `least`; the same on average."""
    if weight >= least:
        return weight
    return least if rng.random() * least < weight else 0.0
