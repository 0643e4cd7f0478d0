"""Marks on a lens's ring: engraved f-numbers are rounded, what they stand for are powers of the sixth root of 2."""

from __future__ import annotations

import math
from functools import lru_cache

# As lenses are engraved, a third of a stop apart from 1.0 on.
THIRD_STOPS = (
    1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.5, 2.8, 3.2, 3.5, 4.0, 4.5, 5.0, 5.6, 6.3, 7.1, 8.0, 9.0, 10.0, 11.0,
    13.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 29.0, 32.0, 36.0, 40.0, 45.0, 51.0, 57.0, 64.0,
)  # fmt: skip
THIRDS = 3  # marks a stop
SAME_REL = 1e-6  # as a mark and its number in a table agree


@lru_cache(maxsize=65536)  # more than there are lenses: with fewer places none would be found again
def f_number_closed(f_number_min: float, stops: float) -> float:
    """The smallest f-number that counts as closed by so many stops from the widest opening.

        N = N_min 2^(stops / 2), or the mark that stands for it where that is less

    Mark k of `THIRD_STOPS` is engraved with a rounded number and stands for 2^(k / 6): f/2 one stop down is 2.83, and
    the ring says 2.8; f/1.8 stands for 1.78, and one stop down for 2.52: the ring says 2.5.

    Parameters
    ----------
    f_number_min : the widest opening [-], as a lens's data give it
    stops : [stops], 0 or more

    Returns
    -------
    [-], never above N_min 2^(stops / 2).

    Notes
    -----
    Valid for: all; a mark is taken for whole thirds of a stop of a lens whose widest opening is a mark itself.

    References
    ----------
    ISO 517, apertures and related properties of photographic lenses: nominal and true f-numbers.
    """
    exact = f_number_min * 2.0 ** (stops / 2.0)
    steps = round(THIRDS * stops)
    if not math.isclose(steps, THIRDS * stops, rel_tol=SAME_REL):
        return exact
    for index, mark in enumerate(THIRD_STOPS):
        if math.isclose(mark, f_number_min, rel_tol=SAME_REL) and index + steps < len(THIRD_STOPS):
            return min(exact, THIRD_STOPS[index + steps])
    return exact
