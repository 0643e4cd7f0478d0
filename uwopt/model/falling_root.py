"""Where functions that fall meet a level: one root each, of many designs at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from uwopt.arrays import Array

Falling = Callable[[Array, Array], Array]  # values at places (m,) of some of the functions, whose numbers come second

CONVERGED = 1e-12  # of a root relative to the end of its range
_ALIKE = 1e-14  # of a value and its level
_MOST_STEPS = 100


def falling_roots(values: Falling, *, level: Array, start: Array, end: Array, at_end: Array) -> Array:
    """Where each function falls to its level between 0 and the end of its range.

    Parameters
    ----------
    values : of some of the functions
    level, start : (n,), level wanted, and value at 0, no less
    end : (n,) of the range, >= 0
    at_end : (n,) value there; where it is the level or more, the end is the answer

    Returns
    -------
    (n,) relative error 1e-12 of the end; each is the same whatever stands beside it.

    Notes
    -----
    Held between two bounds by false position after Illinois, every fourth step a bisection (Dowell and Jarratt 1971).
    Functions that have settled are left out of the steps that others need.
    """
    found = np.where(at_end >= level, end, 0.0)
    open_: Array = np.flatnonzero(at_end < level)
    level, high, whole = level[open_], end[open_], end[open_]
    low: Array = np.zeros(len(open_))
    side: Array = np.zeros(len(open_))  # 1: the low end moved last, -1: the high end
    at_low, at_high = start[open_] - level, at_end[open_] - level
    for step in range(1, _MOST_STEPS):
        if len(open_) == 0:
            break
        share = 0.5 if step % 4 == 0 else at_low / (at_low - at_high)
        place = low + share * (high - low)
        value = values(place, open_) - level
        above = value >= 0.0
        stuck = np.where(above, side > 0, side < 0)  # twice the same end: halve the other's weight
        at_low = np.where(above, value, np.where(stuck, 0.5 * at_low, at_low))
        at_high = np.where(above, np.where(stuck, 0.5 * at_high, at_high), value)
        moved = np.where(above, place - low, high - place)
        low, high = np.where(above, place, low), np.where(above, high, place)
        side = np.where(above, 1.0, -1.0)
        found[open_] = place
        settled = (high - low <= CONVERGED * whole) | (np.abs(value) <= _ALIKE) | (moved <= 0.0)
        if settled.any():
            left = np.flatnonzero(~settled)
            open_, level, whole, side = open_[left], level[left], whole[left], side[left]
            low, high, at_low, at_high = low[left], high[left], at_low[left], at_high[left]
    return found
