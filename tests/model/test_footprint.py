"""The darkest place of a footprint, against SciPy's minimum of a formula that is written out here."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from uwopt.model import beam as beams
from uwopt.model.footprint import LEAST_GAIN_REL, footprint_illuminance_per_lm, least_of
from uwopt.model.imaging import Lamps, PortShape

Array = np.ndarray
PINHOLE = PortShape(True, 0.0, 0.0, 1.5, 0.0, 1.34)
HEIGHT_M, K_PER_M, WIDTH_RAD = 1.6, 0.11, float(np.deg2rad(40.0))
APART = Lamps((0.03, -0.07), (0.9, -0.8), (0.0, 0.0), ((0.0, 0.0, 1.0), (0.0, 0.0, 1.0)), (0.5, 0.5))
BESIDE = Lamps((0.1,), (0.5,), (0.0,), ((0.0, 0.0, 1.0),), (1.0,))


def illuminance_per_lm(place: Any, lamps: Lamps) -> float:
    """Of lamps that look straight down on a level floor: (m + 1) / (2 pi) cos^(m + 1) / r^2 exp(-K r), summed."""
    power, total = math.log(0.5) / math.log(math.cos(0.5 * WIDTH_RAD)), 0.0
    for x_m, y_m, share in zip(lamps.x_m, lamps.y_m, lamps.share, strict=True):
        range_m = math.sqrt((place[0] - x_m) ** 2 + (place[1] - y_m) ** 2 + HEIGHT_M**2)
        cos = HEIGHT_M / range_m
        total += share * (power + 1) / (2 * math.pi) * cos ** (power + 1) / range_m**2 * math.exp(-K_PER_M * range_m)
    return total


@pytest.mark.parametrize(("lamps", "u", "v"), [(APART, 0.12, 0.35), (BESIDE, 0.3, 0.4)], ids=["between", "in a corner"])
def test_darkest_place_is_the_minimum(lamps: Lamps, u: float, v: float) -> None:
    """Between two lamps that stand far apart, off the grid's points, and in the corner farthest from one."""
    wide_x, wide_y = u * HEIGHT_M, v * HEIGHT_M
    starts = [(a * wide_x, b * wide_y) for a in (-0.9, 0.1, 0.9) for b in (-0.9, 0.1, 0.9)]
    limits = [(-wide_x, wide_x), (-wide_y, wide_y)]
    scale = illuminance_per_lm((0.0, 0.0), lamps)

    def scaled(place: Any) -> float:
        return illuminance_per_lm(place, lamps) / scale

    reference = scale * min(float(minimize(scaled, start, bounds=limits, tol=1e-14).fun) for start in starts)
    least = footprint_illuminance_per_lm(
        u, v, shape=PINHOLE, range_m=HEIGHT_M, lamps=lamps, beam=beams.cosine_power_beam(WIDTH_RAD),
        weight=np.ones(2), attenuation_per_m=np.full(2, K_PER_M),
    )[1]  # fmt: skip
    assert least == pytest.approx(reference, rel=2e-6)


def counted(calls: list[int]) -> Any:
    """Even, but for a dip at one of the grid's points that draws looks, and a hole that the second of them finds."""

    def function(u: Array, v: Array) -> Array:
        calls.append(u.size)
        hole = (u > 0.99) & (np.abs(v - 2.0 / 60 / 9) < 1e-3)
        return np.where(hole, 0.0, 1.0 - 1e-9 * (u == 1.0) * (np.abs(v) < 1e-9))

    return function


def test_a_look_that_wins_nothing_is_the_last_where_nothing_can_hide() -> None:
    """All looks are taken of beams that may leave dark wedges: only they have such holes."""
    side = np.linspace(-1.0, 1.0, 61)
    u, v = (part.ravel() for part in np.meshgrid(side, side, indexing="ij"))
    patient, hasty = list[int](), list[int]()
    assert least_of(counted(patient), u, v, 2.0 / 60) == 0.0
    assert least_of(counted(hasty), u, v, 2.0 / 60, LEAST_GAIN_REL) == pytest.approx(1.0)
    assert len(hasty) == 2 < len(patient)
