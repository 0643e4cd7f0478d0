"""The test chart: the same floor and board at any scale."""

from __future__ import annotations

import numpy as np
import pytest

from uwopt.report.pictures import chart


def value_noise(x, y, level):
    down, across = chart.noise_factors(x, y, level)
    return down @ across


def test_the_same_floor_lies_under_every_system():
    x, fine = np.arange(-40.0, 40.0, 1.0), np.arange(-40.0, 40.0, 0.5)
    one, other = value_noise(x / 8, x / 8, 3), value_noise(fine / 8, fine / 8, 3)
    assert other[::2, ::2] == pytest.approx(one)


def test_grain_has_the_contrast_it_names():
    x = np.arange(-600.0, 600.0, 2.0)
    octave = value_noise(x / 16, x / 16, 5)
    assert octave.std() == pytest.approx(chart.VALUE_NOISE_RMS, rel=0.03)  # 75 x 75 lattice points
    assert abs(octave.mean()) < 0.03


def test_bars_of_the_board_are_as_wide_as_named():
    x = np.arange(-70, 70, 0.05) + 0.025
    y = np.array([10.0])
    row = chart.board(x, y, floor=np.ones((1, len(x))))[0, :, 0]
    for index, width in enumerate(chart.BAR_WIDTHS):
        left = -66.0 + 13.0 * index
        bars = row[(x > left) & (x < left + 12.0)]
        edges = np.flatnonzero(np.diff(bars)) * 0.05
        assert np.diff(edges) == pytest.approx(width, abs=0.051)


@pytest.mark.parametrize(
    ("length", "unit"), [(1.0, 1.0), (0.99, 0.7), (14.9, 10.0), (15.0, 15.0), (0.04, 0.03)]
)
def test_units_are_round(length, unit):
    assert chart.nice_unit_mm(length) == unit
