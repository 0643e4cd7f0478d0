"""The nondominated designs that a population search has met, with the vectors that they came from."""

from __future__ import annotations

import numpy as np

from uwopt.arrays import Array
from uwopt.objectives.dominance import NEAR, distinct, nondominated

MOST_POINTS = 3000  # kept while a search runs
FINEST_REL = 1e-5  # by which the closest of them go first


class Archive:
    """All nondominated points seen; points that are alike go only at the end, or where there are very many."""

    def __init__(self, log: Array, n_genes: int):
        self.log = log  # axes that are compared by ratio
        self.values = np.empty((0, len(log)))
        self.vectors = np.empty((0, n_genes), int)

    def __len__(self) -> int:
        return len(self.values)

    def add(self, vectors: Array, values: Array) -> bool:
        """Merge feasible points; whether anything changed."""
        fresh = np.nonzero(nondominated(values))[0]
        if len(fresh) == 0:
            return False
        every = np.concatenate([self.values, values[fresh]])
        keep = np.nonzero(nondominated(every))[0]
        tolerance = FINEST_REL
        while len(keep) > MOST_POINTS and tolerance < NEAR:
            keep = keep[distinct(every[keep], self.log, tolerance)]
            tolerance *= 3.0
        changed = len(keep) != len(self.values) or bool((keep >= len(self.values)).any())
        if changed:
            self.vectors = np.concatenate([self.vectors, vectors[fresh]])[keep]
            self.values = every[keep]
        return changed

    def thinned(self) -> tuple[Array, Array]:
        """Vectors and values without those that are alike, sorted by the columns."""
        keep = distinct(self.values, self.log)
        return self.vectors[keep], self.values[keep]
