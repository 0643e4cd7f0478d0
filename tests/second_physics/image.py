"""Means over the image and least values in it, by brute force; slow ones are kept."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from second_physics.case import KEPT, LUMENS_PER_W, STEPS_NM, Array, Case, Lamp, gauss
from second_physics.lobes import intensity
from second_physics.rays import (
    Rays,
    backscatter_at,
    electrons_at,
    elsewhere_at,
    floor_veil_at,
    forward_at,
)
from second_physics.tables import column, led, legs, resampled


def smooth_mean(
    case: Case, panels: int = 1, order: int = 32, values_at: Callable[..., Array] = electrons_at
) -> float:
    """Mean over the image by Gauss-Legendre, in panels for lobes with kinks."""
    edges = np.linspace(-1.0, 1.0, panels + 1)
    parts = [gauss(low, high, order) for low, high in pairwise(edges)]
    nodes, weights = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    values = values_at(case, nodes[:, None], nodes[None, :])
    return float(weights @ values @ weights) / 4.0


@KEPT.values
def smooth_electrons(case: Case) -> float:
    """Mean electrons of the signal under lobes without kinks."""
    return smooth_mean(case)


@KEPT.values
def veil_means(case: Case) -> tuple[float, float]:
    """Mean forward veil and mean backscatter; the latter on 12 x 12 points (24 x 24 change it by 1e-7 or less)."""
    forward = smooth_mean(case, values_at=forward_at)
    if case.orders:
        forward += smooth_mean(case, order=8, values_at=elsewhere_at)
    return forward, smooth_mean(case, order=12, values_at=backscatter_at)


def lit_pieces(case: Case, lamp: Lamp, v: float) -> list[tuple[float, float]]:
    """Where along u a sharp beam lights the image's line v."""
    rays, edge = Rays(case), math.cos(math.radians(case.half_angle))

    def above(u: Any) -> Any:
        x, y, _, _ = rays.floor(np.asarray(u, float), np.asarray(v, float))
        return rays.lamp(x, y, lamp)[1] - edge

    tried = np.linspace(-1.0, 1.0, 41)
    level = above(tried)
    if 0 < (top := int(level.argmax())) < 40 and level[top] < 0.0:  # a sliver between two points
        best = minimize_scalar(
            lambda u: -above(u), bounds=(tried[top - 1], tried[top + 1]), method="bounded"
        ).x
        tried = np.insert(tried, np.searchsorted(tried, best), best)
        level = above(tried)
    turns = [brentq(above, tried[i], tried[i + 1]) for i in np.nonzero(level[1:] * level[:-1] < 0)[0]]
    return [(low, high) for low, high in pairwise([-1.0, *turns, 1.0]) if above((low + high) / 2) > 0]


def pattern(case: Case, lamp: Lamp, v: float) -> tuple[tuple[bool, bool], ...]:
    """Which pieces of a line are lit, and whether they touch the image's border."""
    return tuple((low == -1.0, high == 1.0) for low, high in lit_pieces(case, lamp, v))


def corners(case: Case, lamp: Lamp) -> list[float]:
    """Where along v the pattern changes: there the length of the pieces has a kink or a root."""
    tried = np.linspace(-1.0, 1.0, 41)
    found = [-1.0]
    for low, high in pairwise(tried):
        before = pattern(case, lamp, low)
        if pattern(case, lamp, high) == before:
            continue
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if pattern(case, lamp, middle) == before else (low, middle)
        found.append(high)
    return [*found, 1.0]


@KEPT.values
def sharp_electrons(case: Case) -> float:
    """Mean electrons of the signal under beams that end sharply."""
    return sharp_mean(case, electrons_at)


@KEPT.values
def sharp_lux(case: Case) -> float:
    """Mean illuminance of the floor that is seen, under such beams."""
    nodes, weights = gauss(-1.0, 1.0, 32)
    whole = weights @ floor_area(case, nodes[:, None], nodes[None, :]) @ weights / 4.0
    return float(sharp_mean(case, lambda *at, **only: lux_at(*at, **only) * floor_area(*at)) / whole)


def sharp_mean(case: Case, values_at: Callable[..., Array], order: int = 16) -> float:
    """Mean over the image of what lamps give one by one, each line cut where the beam ends.

    v = middle + half sin(pi s / 2) smooths the square roots at the ends of each stretch of lines.
    """
    total = 0.0
    for number, lamp in enumerate(case.lamps):
        us, vs, weights = [], [], []
        for low, high in pairwise(corners(case, lamp)):
            for s, weight_s in zip(*gauss(-1.0, 1.0, order), strict=True):
                v = (low + high) / 2 + (high - low) / 2 * math.sin(math.pi / 2 * s)
                weight_v = weight_s * (high - low) / 2 * math.pi / 2 * math.cos(math.pi / 2 * s)
                for piece in lit_pieces(case, lamp, v):
                    u, weight_u = gauss(*piece, 16)
                    us.append(u)
                    vs.append(np.full_like(u, v))
                    weights.append(weight_u * weight_v)
        if us:
            values = values_at(case, np.concatenate(us), np.concatenate(vs), only=number)
            total += float(values @ np.concatenate(weights))
    return total / 4.0


def noise_variance(light: Any, dark: float = 0.0, prnu: float = 0.0) -> Any:
    """(7) with read noise 2.4 e and the quantisation of 0.35 DN/e; all light counts, veils included."""
    return 2.4**2 + 1 / 12 / 0.35**2 + light + dark + (prnu * light) ** 2


@KEPT.values
def least_snr(case: Case) -> float:
    """Of 41 pixels a side, the darkest."""
    border = np.linspace(-1.0, 1.0, 41)
    at = (case, border[:, None], border[None, :])
    signal, veil = electrons_at(*at), floor_veil_at(*at) + backscatter_at(*at)
    return float((signal / np.sqrt(noise_variance(signal + veil))).min())


@KEPT.values
def snr_of_twentieth(case: Case) -> float:
    """What 95 % of 65 x 65 pixels reach."""
    cells = (np.arange(65) + 0.5) * 2.0 / 65 - 1.0
    at = (case, cells[:, None], cells[None, :])
    signal, veil = electrons_at(*at), floor_veil_at(*at) + backscatter_at(*at)
    counted = np.sort((signal / np.sqrt(noise_variance(signal + veil))).ravel())
    return float(counted[int(0.05 * counted.size)])


def floor_area(case: Case, u: Array, v: Array) -> Array:
    """Area of floor per unit of u and v, by differences."""
    rays, step = Rays(case), 1e-4
    ahead, behind = rays.floor(u + step, v), rays.floor(u - step, v)
    right, left = rays.floor(u, v + step), rays.floor(u, v - step)
    along = [(a - b) / (2 * step) for a, b in zip(ahead[:2], behind[:2], strict=True)]
    across = [(a - b) / (2 * step) for a, b in zip(right[:2], left[:2], strict=True)]
    return np.asarray(np.abs(along[0] * across[1] - along[1] * across[0]))


def lux_at(case: Case, u: Array, v: Array, only: int | None = None) -> Array:
    """Illuminance of the floor where the pixels u, v look; edges of beams not yet cut."""
    rays, k = Rays(case), legs(case).lamp
    share = resampled(*column("photopic_v.csv", "V"), outside=0.0) * led() * STEPS_NM * LUMENS_PER_W
    x, y, _, _ = rays.floor(u, v)
    total = np.zeros(np.broadcast(u, v).shape)
    for number, at in enumerate(case.lamps):
        if only in (None, number):
            length, cos_beam, cos_floor = rays.lamp(x, y, at)
            lux = case.flux_lm / len(case.lamps) * intensity(case, cos_beam) * cos_floor / length**2
            total += lux * (np.exp(-k * length[..., None]) @ share)
    return total
