"""How much of a floor's detail arrives through water: walks of all orders against `uwopt.model.detail`.

The camera looks straight down on a floor in even light whose reflectance varies as a wave. Walks from the camera that
are scattered on their way meet the floor aside by x; the mean of cos(2 pi k x) over them, beside what arrives straight,
is what the wave has more of than the image-forming light alone would show.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uwopt.model.detail import detail_gain, detail_table

from .camera import BATCHES, View, to_floor
from .model import phase_table
from .walk import Water, compiled, drawn_angle, phase_of, turned, water_of

CASES = (
    ("ff 0.0183", 1.0, 0.8), ("ff 0.0183", 3.0, 0.8), ("ff 0.005", 2.0, 0.9), ("ff 0.03", 2.0, 0.6),
    ("hg 0.9", 2.0, 0.9), ("petzold HAOCE 11", 2.0, 0.7), ("petzold NUC 2200", 4.0, 0.85),
)  # fmt: skip
CYCLES_PER_RAD = (10.0, 30.0, 100.0, 300.0, 1000.0)
N = 4_000_000


class Transfer(NamedTuple):
    """Detail over what the image-forming light has of it, by frequency, of one water over one floor."""

    phase: str
    thickness: float
    albedo: float
    cycles_per_rad: Any
    found: Any
    error: Any  # one standard error
    model: Any


@compiled
def beside(rng: Any, water: Water, view: View, n: int, frequency: Any, out: Any) -> None:
    """Adds n walks to `out`, (n_frequencies,): weight times the wave, over what arrives straight."""
    straight = np.exp(-water.c * view.floor)
    for _ in range(n):
        way = -np.log1p(-rng.random() * (1.0 - straight)) / water.c
        dx, dy, dz = turned(rng, 0.0, 0.0, 1.0, drawn_angle(rng, water, 1.0))
        x, y, weight = to_floor(
            rng, water, view, 0.0, 0.0, way, dx, dy, dz, (1.0 - straight) * water.albedo
        )
        if weight > 0.0:
            for k in range(len(frequency)):
                cycle = 2.0 * np.pi * frequency[k] / view.floor
                out[k] += weight / straight * 0.5 * (np.cos(cycle * x) + np.cos(cycle * y))


def transfer(phase: str, thickness: float, albedo: float, *, n: int = N, seed: int = 18) -> Transfer:
    """By walks, and by the model."""
    water, view = water_of(thickness, albedo, phase_of(phase)), View(0.5, 0.5, 1.0, 0.3)
    frequency, sums = np.array(CYCLES_PER_RAD), np.zeros((BATCHES, len(CYCLES_PER_RAD)))
    for k, source in enumerate(np.random.SeedSequence(seed).spawn(BATCHES)):
        beside(np.random.default_rng(source), water, view, n // BATCHES, frequency, sums[k])
    means = sums / (n // BATCHES)
    model = detail_gain(frequency, scattered=thickness * albedo, table=detail_table(phase_table(phase)))
    error = means.std(axis=0, ddof=1) / np.sqrt(BATCHES)
    return Transfer(phase, thickness, albedo, frequency, 1.0 + means.mean(axis=0), error, model)


def gain(phase: str, scattered: float, cycles_per_rad: float) -> float:
    """The model's factor."""
    return float(detail_gain(cycles_per_rad, scattered=scattered, table=detail_table(phase_table(phase))))
