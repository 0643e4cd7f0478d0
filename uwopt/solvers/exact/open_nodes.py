"""Nodes of a search that wait, the best bound first: imagers under lightings, with what each could be at best."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.exact.node_bounds import NodeBounds, by_rule


@dataclass
class OpenNodes:
    """Every node of some imagers, lighting by lighting: node k n + i is the i-th of n imagers under lighting k."""

    imager: Array  # (n,) rows of the imagers
    cost: Array  # (n,)
    value: Array  # (n_lightings n,) bounds of the objective; inf: discarded
    power_w: Array  # of the electrical power
    rule: Array  # that the first bounds discard a node by, -1: none
    size: Array  # designs in a node
    rough: Array  # whether its bounds can be made better
    waiting: Array  # nodes to take, the best first

    @staticmethod
    def of(bounds: Sequence[NodeBounds], imager: Array, cost: Array, sizes: Array, *, rough: bool) -> OpenNodes:
        """From the bounds under each lighting and the number of lights and counts there."""
        value, power, rule = (
            np.concatenate([getattr(b, name) for b in bounds]) for name in ("value", "power", "rule")
        )
        size = np.repeat(sizes, len(imager))
        nodes = OpenNodes(imager, cost, value, power, rule, size, np.full(len(value), rough), np.arange(len(value)))
        nodes.value[rule >= 0] = np.inf
        nodes.sort()
        return nodes

    def __len__(self) -> int:
        return len(self.waiting)

    @property
    def lowest(self) -> float:
        """Least bound of what waits, in order; inf where nothing does."""
        return float(self.value[self.waiting[0]]) if len(self) else np.inf

    @property
    def designs_left(self) -> int:
        """How many designs wait."""
        return int(self.size[self.waiting].sum())

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
        first = self.waiting[0]
        return bool(self.rough[first]) and bool(self.value[first] <= threshold)

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

    def failed(self) -> Iterator[tuple[str, Array]]:
        """By rule, the nodes that the first bounds discard."""
        return by_rule(self.rule)
