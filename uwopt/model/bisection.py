"""Where conditions cease to hold, by halves: of one range, or of many at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from uwopt.arrays import Array


def half_way(inside: Any, outside: Any) -> Any:
    """Of two ends their mean, middle = (inside + outside) / 2."""
    return 0.5 * (inside + outside)


def bisected(
    holds: Callable[[Any], Any], inside: Array | float, outside: Array | float, *, steps: int,
    middle: Callable[[Any, Any], Any] = half_way,
) -> tuple[Array, Array]:  # fmt: skip
    """Ranges at whose one end a condition holds and at whose other it does not, halved about where it ceases to.

        middle = (inside + outside) / 2, and the end on its side moves there

    Parameters
    ----------
    holds : whether it does, at places (...,); one number where both ends are
    inside, outside : (...,), ends at which it holds and at which it does not
    steps : halvings at most: none is made where every middle is an end
    middle : of two ends, where it is not their mean

    Returns
    -------
    inside, outside : (...,), 2^-steps as far apart

    Notes
    -----
    Where it ceases to hold more than once, one of these places is found.
    """
    for _ in range(steps):
        tried = middle(inside, outside)
        if not np.any((np.minimum(inside, outside) < tried) & (tried < np.maximum(inside, outside))):
            break
        is_in = holds(tried)
        inside, outside = np.where(is_in, tried, inside), np.where(is_in, outside, tried)
    return np.asarray(inside), np.asarray(outside)
