"""Designs of nodes, and those that wait for their turn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.lamp_light import ImageLight
from uwopt.solvers.exact.lightings import Lighting

Array = NDArray[Any]
FIRST_VEILS, LARGEST_VEILS = 8, 256  # imagers whose veils are worked out together


@dataclass(frozen=True)
class NodeDesigns:
    """Designs as (node, light, count): `node` points into `imager`."""

    imager: Array
    node: Array
    light: Array
    count: Array
    cost: Array
    mass_kg: Array

    def take(self, index: Array) -> NodeDesigns:
        """These designs only; the list of imagers stays."""
        return NodeDesigns(
            self.imager,
            self.node[index],
            self.light[index],
            self.count[index],
            self.cost[index],
            self.mass_kg[index],
        )


@dataclass(frozen=True)
class Waiting:
    """Designs of one lighting that are bounded and not solved, their nodes in the order of the least bound of each."""

    pairs: NodeDesigns
    bound: Array
    lights: list[ImageLight]
    lighting: Lighting
    order: Array
    least: Array  # of the nodes in their order
    begin: int = 0
    batch: int = FIRST_VEILS

    @staticmethod
    def of(pairs: NodeDesigns, bound: Array, lights: list[ImageLight], lighting: Lighting) -> Waiting:
        """All of a group."""
        least = np.full(len(pairs.imager), np.inf)
        np.minimum.at(least, pairs.node, bound)
        order = np.argsort(least, kind="stable")
        return Waiting(pairs, bound, lights, lighting, order, least[order])

    @property
    def lowest(self) -> float:
        """The least bound that waits."""
        return float(self.least[self.begin]) if self.begin < len(self.least) else np.inf

    def taken(self, most: float) -> tuple[Array, Waiting]:
        """The next nodes with no more than some bound, and the group without them."""
        end = self.begin + int((self.least[self.begin : self.begin + self.batch] <= most).sum())
        batch = min(2 * self.batch, LARGEST_VEILS)
        return self.order[self.begin : end], replace(self, begin=end, batch=batch)

    def left(self) -> Array:
        """Which designs wait."""
        return np.isin(self.pairs.node, self.order[self.begin :])
