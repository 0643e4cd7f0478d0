"""Where conditions cease to hold."""

from __future__ import annotations

import math

import numpy as np
import pytest

from uwopt.model.bisection import bisected


def test_roots_are_found_between_ends_on_either_side() -> None:
    square = np.array([2.0, 3.0, 9.0])
    below = bisected(lambda x: x * x <= square, np.zeros(3), np.full(3, 10.0), steps=60)
    above = bisected(lambda x: x * x >= square, np.full(3, 10.0), np.zeros(3), steps=60)
    for inside, outside in (below, above):
        assert inside == pytest.approx(np.sqrt(square), rel=1e-15)
        assert outside == pytest.approx(inside, rel=1e-15)
    assert (below[0] ** 2 <= square).all() and (above[0] ** 2 >= square).all()


def test_ends_are_a_power_of_two_closer_after_as_many_halves() -> None:
    inside, outside = bisected(lambda x: x < math.pi, 3.0, 4.0, steps=7)
    assert inside < math.pi < outside
    assert float(outside - inside) == 2.0**-7


def test_no_halves_are_made_where_every_middle_is_an_end() -> None:
    asked: list[float] = []

    def holds(place: float) -> bool:
        asked.append(place)
        return place < 7.0

    inside, outside = bisected(holds, 0.0, 9.0, steps=20, middle=lambda a, b: float(round(0.5 * (a + b))))
    assert (float(inside), float(outside)) == (6.0, 7.0)
    assert len(asked) < 6
