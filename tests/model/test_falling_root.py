"""Roots of falling functions with closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from uwopt.model.falling_root import falling_roots

POWER = np.array([0.5, 1.0, 2.0, 3.0, 8.0])
END = np.array([0.3, 1.0, 0.7, 2.0, 1e-3])


def arches(place: np.ndarray, some: np.ndarray) -> np.ndarray:
    """1 - (x / end)^p, which falls from 1 to 0."""
    return 1.0 - (place / END[some]) ** POWER[some]


@pytest.mark.parametrize("level", [0.9, 0.5, 1e-3])
def test_roots_are_those_of_the_closed_form(level):
    # 1 - (x / e)^p = L at x = e (1 - L)^(1 / p)
    given = dict(level=np.full(5, level), start=np.ones(5), end=END, at_end=np.zeros(5))
    expected = END * (1.0 - level) ** (1.0 / POWER)
    assert falling_roots(arches, **given) == pytest.approx(expected, rel=1e-11)


def test_what_stays_above_its_level_ends_where_its_range_does():
    half = 0.5 * END  # where the functions are 1 - 0.5^p: 0.29, 0.5, 0.75, 0.875, 0.996
    level = np.array([0.2, 0.4, 0.7, 0.8, 0.9])
    at_end = arches(half, np.arange(5))
    assert falling_roots(arches, level=level, start=np.ones(5), end=half, at_end=at_end).tolist() == half.tolist()


def test_a_level_that_is_reached_at_once_has_its_root_at_zero():
    none = np.zeros(2)
    found = falling_roots(arches, level=np.ones(2), start=np.ones(2), end=none, at_end=none)
    assert found == pytest.approx(none, abs=1e-300)


def test_a_root_is_the_same_whatever_stands_beside_it():
    """To the last digit: functions that need few steps are not moved on with those that need many."""
    rng = np.random.default_rng(3)
    power, end = rng.uniform(0.2, 9.0, 200), rng.uniform(0.1, 3.0, 200)

    def roots(which: np.ndarray) -> np.ndarray:
        def values(place: np.ndarray, some: np.ndarray) -> np.ndarray:
            return 1e6 * (1.0 - (place / end[which][some]) ** power[which][some])  # so large that none is just 0.3e6

        ones = np.ones(len(which))
        return falling_roots(values, level=0.3e6 * ones, start=1e6 * ones, end=end[which], at_end=0.0 * ones)

    together = roots(np.arange(200))
    assert [float(roots(np.array([n]))[0]) for n in range(200)] == together.tolist()
