"""The nondominated designs that a population search has met, with the vectors that they came from."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.objectives.axes import scale
from uwopt.objectives.dominance import NEAR, nondominated

Array = NDArray[Any]
MARGIN = 1.1  # of a front's range, where the box ends that volumes are measured in
MOST_POINTS = 3000  # kept while a search runs
FINEST_REL = 1e-5  # by which the closest of them go first


def distinct(values: Array, log: Array, alike_rel: float = NEAR) -> Array:
    """Indices of rows of which no two are alike in every column, in the order of the columns.

    Those that dominate most by themselves stay first: the ends of curves, without which a whole slab is lost
    (0.2 % of the hypervolume goes where the first in a sorted list would lose 2 %).
    """
    if len(values) == 0:
        return np.empty(0, int)
    from moocore import hv_contributions

    unit = in_box(values, values, log)
    alone = np.asarray(hv_contributions(unit, ref=np.full(values.shape[1], MARGIN)))
    kept: list[int] = []
    for row in np.lexsort((*values.T[::-1], -alone)):
        if not near(values[kept], values[row], alike_rel).all(axis=1).any():
            kept.append(int(row))
    index = np.array(kept)
    return index[np.lexsort(values[index].T[::-1])]


def in_box(values: Array, front: Array, log: Array) -> Array:
    """Values with the front's best corner at 0 and its worst at 1, logarithms where axes are compared by ratio."""
    low, high = (scale(end[None, :], log)[0] for end in (front.min(axis=0), front.max(axis=0)))
    return np.asarray((scale(values, log) - low) / np.where(high > low, high - low, 1.0))


def near(one: Any, other: Any, alike_rel: float) -> Any:
    """Whether values are alike to a relative difference."""
    return np.abs(one - other) <= alike_rel * np.maximum(np.abs(one), np.abs(other))


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
