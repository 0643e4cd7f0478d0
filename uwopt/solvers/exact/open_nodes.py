"""Nodes of a search that wait, the best bound first: imagers under lightings, with what each could be at best.

Imagers come in the order of what they are at best under any light. Those whose turn has not come are not bounded yet:
many never are, since what was found beats all that they could be.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.exact.node_bounds import NodeBounds, by_rule


@dataclass
class OpenNodes:
    """Every node of some imagers, lighting by lighting: node k n + i is the i-th of n imagers under lighting k."""

    imager: Array  # (n,) rows of the imagers, the least floor first
    floor: Array  # (n,) of the objective, whatever lights an imager
    cost: Array  # (n,)
    sizes: Array  # (n_lightings,) designs in a node
    value: Array  # (n_lightings n,) bounds of the objective; inf: discarded, or not known yet
    power_w: Array  # of the electrical power
    rough: Array  # whether its bounds can be made better
    waiting: Array  # nodes to take, the best first
    bounded: int  # so many of the imagers, the first ones, have bounds

    @staticmethod
    def of(imager: Array, floor: Array, cost: Array, sizes: Array) -> OpenNodes:
        """All nodes of these imagers, none bounded."""
        order = np.lexsort((cost, floor))
        n = len(sizes) * len(imager)
        return OpenNodes(
            imager[order], floor[order], cost[order], sizes, np.full(n, np.inf), np.full(n, np.inf), np.zeros(n, bool),
            np.arange(0), bounded=0,
        )  # fmt: skip

    def __len__(self) -> int:
        """Nodes that are bounded and wait, and imagers that are not bounded."""
        return len(self.waiting) + len(self.unbounded)

    @property
    def unbounded(self) -> Array:
        """Rows of the imagers that have no bounds yet, in order."""
        return self.imager[self.bounded :]

    @property
    def _next_floor(self) -> float:
        """Of the imagers that are not bounded; inf where all are."""
        return float(self.floor[self.bounded]) if self.bounded < len(self.floor) else np.inf

    @property
    def lowest(self) -> float:
        """Least that anything that waits could be; inf where nothing does."""
        return min(float(self.value[self.waiting[0]]) if len(self.waiting) else np.inf, self._next_floor)

    @property
    def designs_left(self) -> int:
        """How many designs wait."""
        return self.size_of(self.waiting) + int(self.sizes.sum()) * len(self.unbounded)

    def to_bound(self, count: int, threshold: float) -> int:
        """How many imagers that may win and have no bounds may hold any of so many nodes that come next."""
        most = min(threshold, float(self.value[self.waiting[count - 1]]) if len(self.waiting) >= count else np.inf)
        return int(np.searchsorted(self.floor, most, side="right")) - self.bounded

    def bound(self, lit: Array, bounds: Sequence[NodeBounds], *, rough: bool) -> Iterator[tuple[str, Array]]:
        """Take up bounds under each lighting of the next imagers, those that `lit` marks; by rule, the nodes that they
        discard."""
        some, every = self.bounded + np.flatnonzero(lit), len(self.imager)
        self.bounded += len(lit)
        for k, own in enumerate(bounds):
            nodes = k * every + some
            self.value[nodes], self.power_w[nodes] = np.where(own.rule >= 0, np.inf, own.value), own.power
            self.rough[nodes] = rough
            self.waiting = np.concatenate([self.waiting, nodes])
            for name, failed in by_rule(own.rule):
                yield name, nodes[failed]
        self.sort()

    def size_of(self, nodes: Array) -> int:
        """Designs in some nodes."""
        return int(self.sizes[self.lighting_of(nodes)].sum())

    def lighting_of(self, nodes: Array) -> Array:
        """Number of each node's lighting."""
        return np.asarray(nodes // len(self.imager))

    def imager_of(self, nodes: Array) -> Array:
        """Row of each node's imager."""
        return np.asarray(self.imager[nodes % len(self.imager)])

    def cost_of(self, nodes: Array) -> Array:
        """Price of each node's imager."""
        return np.asarray(self.cost[nodes % len(self.imager)])

    def sort(self) -> None:
        """Put what waits in order anew; what is discarded waits no more."""
        left = self.waiting[np.isfinite(self.value[self.waiting])]
        self.waiting = left[np.lexsort((self.cost_of(left), self.power_w[left], self.value[left]))]

    def begins_rough(self, threshold: float) -> bool:
        """Whether the first may win by a bound that can be made better."""
        return len(self.rough_ahead(1, threshold)) > 0

    def rough_ahead(self, count: int, threshold: float) -> Array:
        """Of so many that come next, those that may win by bounds that can be made better."""
        ahead = self.waiting[:count]
        return np.asarray(ahead[self.rough[ahead] & (self.value[ahead] <= threshold)])

    def ahead(self, count: int, threshold: float) -> Array:
        """So many at most that come next and may win, up to the first whose bound can be made better."""
        ahead = self.waiting[:count]
        ahead = ahead[np.logical_and.accumulate(~self.rough[ahead])]
        return np.asarray(ahead[self.value[ahead] <= threshold])

    def drop(self, count: int) -> None:
        """So many that came next are taken."""
        self.waiting = self.waiting[count:]

    def refine(self, nodes: Array, bounds: NodeBounds) -> Iterator[tuple[str, Array]]:
        """Raise bounds of some nodes; by rule, those that it discards now."""
        self.value[nodes] = np.maximum(self.value[nodes], bounds.value)
        self.power_w[nodes] = np.maximum(self.power_w[nodes], bounds.power)
        for name, failed in by_rule(bounds.rule):
            self.value[nodes[failed]] = np.inf
            yield name, nodes[failed]
