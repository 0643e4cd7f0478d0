"""What waits in the tree of a large catalogue: rows at every level, the best of which come next."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns

MOST_OPEN = 4_000_000  # rows that wait; beyond it the smallest groups go first, whatever their bounds


class Order(Protocol):
    """What comes before what."""

    def order(self, ideals: Array) -> Array:
        """Places of ideal points (n, n_objectives), those to look at first before the others."""


@dataclass(frozen=True)
class WaitingRows:
    """Rows with their ideals, best first."""

    rows: Columns
    ideals: Array

    @staticmethod
    def of(rows: Columns, ideals: Array, by: Order) -> WaitingRows:
        """In their order."""
        order = by.order(ideals)
        return WaitingRows(rows.take(order), ideals[order])

    def parted(self, count: int) -> tuple[WaitingRows, list[WaitingRows]]:
        """The first so many, and the others if there are any."""
        rest = WaitingRows(self.rows.take(slice(count, None)), self.ideals[count:])
        return WaitingRows(self.rows.take(slice(count)), self.ideals[:count]), [rest] if len(rest.ideals) else []


@dataclass(frozen=True)
class OpenRows:
    """Blocks of rows by level; those of the last level are one block. Taking some makes another record."""

    levels: tuple[tuple[WaitingRows, ...], ...]
    by: Order

    @staticmethod
    def none(levels: int, by: Order) -> OpenRows:
        """Nothing waits at so many levels."""
        return OpenRows(((),) * levels, by)

    def __len__(self) -> int:
        return sum(len(block.ideals) for block in self.blocks())

    def blocks(self) -> Iterator[WaitingRows]:
        """All of them, the smallest groups first."""
        for level in reversed(self.levels):
            yield from level

    def ideals(self) -> Array:
        """What waits could be at best, (n, n_objectives)."""
        return np.concatenate([block.ideals for block in self.blocks()] or [np.empty((0, 1))])

    def put(self, depth: int, rows: Columns, ideals: Array) -> OpenRows:
        """With more rows at a level."""
        if len(ideals) == 0:
            return self
        own = self.levels[depth]
        if depth == len(self.levels) - 1 and own:
            rows, ideals, own = type(rows).joined([own[0].rows, rows]), np.concatenate([own[0].ideals, ideals]), ()
        return self._with(depth, (*own, WaitingRows.of(rows, ideals, self.by)))

    def _with(self, depth: int, blocks: tuple[WaitingRows, ...]) -> OpenRows:
        return OpenRows((*self.levels[:depth], blocks, *self.levels[depth + 1 :]), self.by)

    def next(self, groups: int, rows: int, leaves: int) -> tuple[int, WaitingRows, OpenRows]:
        """The level and the rows that come next, and what is left: so many at most of the first level, between, and of
        the last, whose rows are dear to search: they wait until so many come before all that waits elsewhere."""
        last = len(self.levels) - 1
        inner = [(depth, n) for depth in reversed(range(last)) for n in range(len(self.levels[depth]))]
        if self.levels[last]:
            ideals = self.levels[last][0].ideals[:leaves]
            if not inner or len(self) > MOST_OPEN:
                return self._taken(last, 0, leaves)
            order = self.by.order(np.concatenate([ideals, *(self.levels[d][n].ideals[:1] for d, n in inner)]))
            if (order[:leaves] < len(ideals)).all() and len(ideals) == leaves:
                return self._taken(last, 0, leaves)
        heads = np.concatenate([self.levels[d][n].ideals[:1] for d, n in inner])
        depth, place = inner[int(self.by.order(heads)[0])]
        return self._taken(depth, place, rows if depth else groups)

    def _taken(self, depth: int, place: int, count: int) -> tuple[int, WaitingRows, OpenRows]:
        level = self.levels[depth]
        some, rest = level[place].parted(count)
        return depth, some, self._with(depth, (*level[:place], *rest, *level[place + 1 :]))
