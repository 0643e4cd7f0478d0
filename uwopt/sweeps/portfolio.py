"""Few kits for many missions: which choice of so many kits serves the most, and of such choices the cheapest.

A set cover, solved exactly as a mixed-integer program by HiGHS (scipy): missions that the same kits serve count as one
of their number, so that it stays small however many missions there are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from uwopt.arrays import Array
from uwopt.errors import SolverError


def portfolios(served: Array, prices: Sequence[float]) -> Iterator[tuple[list[int], int]]:
    """The best choice of one kit, of two and so on, until more serve no more: indices, and missions served.

        max_x sum_r w_r y_r,  y_r <= sum_{k in r} x_k,  sum_k x_k <= n,  x binary, y in [0, 1]

    and at that value the least sum of prices. With x binary, y is 0 or 1 of itself.

    Parameters
    ----------
    served : (missions, kits) of flags
    prices : (kits,), one currency
    """
    patterns, counts = np.unique(served[served.any(axis=1)], axis=0, return_counts=True)
    most = int(counts.sum())
    for size in range(1, served.shape[1] + 1):
        if not most:
            return
        reached = round(cheapest_kits(patterns, counts, size, -counts, np.zeros(len(prices)))[1])
        kits, _ = cheapest_kits(
            patterns, counts, size, np.zeros(len(counts)), np.asarray(prices, dtype=float), reached
        )
        yield kits, reached
        if reached == most:
            return


def cheapest_kits(
    patterns: Array, counts: Array, size: int, cost_of_pattern: Array, cost_of_kit: Array, least: int = 0
) -> tuple[list[int], float]:
    """Kits of a choice of least cost that serves so many missions at least, and how many it serves."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    n_patterns, n_kits = patterns.shape
    costs = np.concatenate([cost_of_kit, cost_of_pattern])
    covers = np.hstack([-patterns.astype(float), np.eye(n_patterns)])  # y_r - sum of its kits <= 0
    number = np.concatenate([np.ones(n_kits), np.zeros(n_patterns)])
    weight = np.concatenate([np.zeros(n_kits), counts.astype(float)])
    found = milp(
        costs,
        integrality=np.concatenate([np.ones(n_kits), np.zeros(n_patterns)]),
        bounds=Bounds(0.0, 1.0),
        constraints=[
            LinearConstraint(covers, -np.inf, 0.0),
            LinearConstraint(number[None, :], 0.0, size),
            LinearConstraint(weight[None, :], least - 0.5, np.inf),
        ],
        options={"mip_rel_gap": 0.0},
    )
    if found.x is None or found.status != 0:
        raise SolverError(f"the choice of {size} kits was not solved: {found.message}")
    kits = [index for index in range(n_kits) if found.x[index] > 0.5]
    return kits, float(counts @ patterns[:, kits].any(axis=1))
