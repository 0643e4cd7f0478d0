"""What a search for a front looks for: designs that no point found is as good as in every objective.

What nodes, or groups of them, are at best is a point; where a point found is as good as it everywhere, no design of
theirs is missed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.objectives.axes import Axes
from uwopt.objectives.dominance import BestPoints, nondominated
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.bounds import Bounds

WITHOUT_BOUND = 1e300  # in place of infinity, which has no differences


@dataclass(frozen=True)
class Undominated:
    """Designs that no point found beats, as the goal of a search."""

    axes: Axes
    archive: BestPoints
    search: Callable[[Bounds, Array], Array]

    def ideals(self, terms: Terms) -> Array:
        """The best of each objective, (n, n_axes)."""
        return np.clip(self.axes.minimised(terms), -WITHOUT_BOUND, WITHOUT_BOUND)

    def beaten(self, ideals: Array) -> Array:
        """What some point found is as good as in every objective."""
        return self.archive.beats(ideals)

    def order(self, ideals: Array) -> Array:
        """As `in_layers` has them."""
        return in_layers(ideals)


def in_layers(ideals: Array) -> Array:
    """Places of ideal points (n, n_axes): those that no other dominates, then by the worst of their ranks."""
    first = nondominated(ideals)
    order = np.argsort(ideals, axis=0, kind="stable")
    rank = np.empty_like(order)
    for column in range(ideals.shape[1]):
        rank[order[:, column], column] = np.arange(len(ideals))
    worst = rank.max(axis=1, initial=0)
    return np.argsort(np.where(first, -1.0, worst), kind="stable")
