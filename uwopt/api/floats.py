"""How NumPy treats what a float cannot hold while uwopt works: the same whatever the caller has set."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numpy as np

P = ParamSpec("P")
R = TypeVar("R")


def own_float_rules(work: Callable[P, R]) -> Callable[P, R]:
    """A call under NumPy's own rules, but that less light than a float can hold is no light.

    Solvers of others divide by zero where the answer is infinity; a caller's `np.seterr(all="raise")` is meant for
    the caller's formulas.
    """

    @functools.wraps(work)
    def sheltered(*args: P.args, **kwargs: P.kwargs) -> R:
        with np.errstate(divide="warn", over="warn", invalid="warn", under="ignore"):
            return work(*args, **kwargs)

    return sheltered
