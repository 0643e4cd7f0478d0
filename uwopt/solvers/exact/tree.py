"""The search of a catalogue as a tree whose leaves are imagers: whatever has the best bound comes next, at any level.

What can matter is for a `Goal` to say: a search for one optimum and one for a front take the same way. A small
catalogue has leaves alone; `large` has the groups above them. Every combination is counted once, by the rule that
discards it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import Deadline, OutOfTimeError
from uwopt.forward.columns import Columns
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.account import Account
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.imager_rules import Tally
from uwopt.solvers.exact.ranking import Found

FIRST_ROWS, LARGEST_ROWS = 512, 32768  # that are bounded together
SHARE_OF_GROUPS = 16  # of that many are taken of the first level, whose rows come apart into many
FIRST_NODES = 400_000  # imagers times lightings that are bounded first: cheaper than to evaluate the wrong ones
MOST_NODES = 6_000_000  # of them at a time: what memory allows
LARGEST_LISTED = 65536  # imagers that are bounded together
GROWTH = 4  # of the imagers that are searched together
MOST_OPEN = 4_000_000  # rows that wait; beyond it the smallest groups go first, whatever their bounds


class Goal(Protocol):
    """What a search looks for."""

    def ideals(self, terms: Terms) -> Array:
        """What designs are at best, by the best of each term, (n, n_objectives); less is better."""

    def beaten(self, ideals: Array) -> Array:
        """Which of them cannot matter any more, (n,)."""

    def order(self, ideals: Array) -> Array:
        """Their places, (n,), those to look at first before the others."""

    @property
    def search(self) -> Callable[[Bounds, Array], Array]:
        """Search some imagers of these bounds: ideals (n, n_objectives) of what is left when time ran out.

        What raises OutOfTimeError or KeyboardInterrupt has searched none of them.
        """


@dataclass(frozen=True)
class ListedRows(Columns):
    """Imagers by their place in a list."""

    imager: Array


class Tree:
    """What waits, and how far it is searched; here the imagers of a small catalogue, of which all are listed."""

    def __init__(self, bounds: Bounds, goal: Goal, account: Account, tally: Tally):
        """Imagers wait in the order of what they are at best; `account` and `tally` have what is discarded."""
        self.begin(bounds, goal, account, tally, depth=0)
        lightings, every = max(1, len(bounds.tables.lightings)), np.arange(len(bounds.imagers))
        self.most = min(LARGEST_LISTED, max(64, MOST_NODES // lightings))
        self.leaves = min(self.most, max(1, FIRST_NODES // lightings))
        self.charge_imagers(bounds.imagers.tally.discarded)
        self.open = self.open.put(0, ListedRows(every), goal.ideals(bounds.without_light(every)))

    def begin(self, bounds: Bounds, goal: Goal, account: Account, tally: Tally, *, depth: int) -> None:
        """Nothing waits; so many levels stand above the leaves. Their tables of lights serve all imagers."""
        self.bounds, self.goal, self.account, self.tally, self.depth = bounds, goal, account, tally, depth
        self.open = OpenRows.none(depth + 1, goal)
        self.left = np.empty((0, 1))  # ideals of what was taken and not searched to its end
        self.leaves, self.most, self.a_leaf = 1, 1, 1  # imagers searched together, next and ever; and in a leaf, about
        self.groups_s, self.interrupted = 0.0, False

    # ------------------------------------------------------------ best first

    def search(self, deadline: Deadline, tell: Callable[[str], object] = str) -> bool:
        """Take all that may matter; False when time ran out, or who waits wants no more: then a step that is cut short
        counts for nothing. `tell` is called with a word after each."""
        rows = FIRST_ROWS
        while len(self.open):
            before = self.account.snapshot()
            try:
                if deadline.passed():
                    return False
                groups, leaves = max(1, rows // SHARE_OF_GROUPS), max(1, self.leaves // self.a_leaf)
                depth, some, rest = self.open.next(groups, rows, leaves)
                hopeful = self._hopeful(depth, some)
                if depth == self.depth:
                    bounds, imagers = self.handed_over(hopeful)
                    self.left = self.goal.search(bounds, imagers) if len(imagers) else self.left
                    self.leaves = min(GROWTH * self.leaves, self.most)
                else:
                    start = time.perf_counter()
                    rest = rest.put(depth + 1, *self.parts_of(depth, hopeful))
                    rows = min(2 * rows, LARGEST_ROWS)
                    self.groups_s += time.perf_counter() - start
                self.open = rest
                if len(self.left):
                    return False
                tell("search")
            except (KeyboardInterrupt, OutOfTimeError) as cut:
                self.account.restore(before)
                self.interrupted = isinstance(cut, KeyboardInterrupt)
                return False
        return True

    def open_ideals(self) -> Array:
        """What is not searched yet could be at best, (n, n_objectives)."""
        return np.concatenate([some for some in (self.left, self.open.ideals()) if len(some)] or [self.left])

    def _hopeful(self, depth: int, block: WaitingRows) -> Columns:
        """The rows that may still matter; the others are counted."""
        beaten = self.goal.beaten(block.ideals)
        lost = np.flatnonzero(beaten)
        self.account.charge("bound", int(self.imagers_in(depth, block.rows.take(lost)).sum()) * self.designs)
        self.remember("bound", depth, block.rows, lost)
        return block.rows.take(~beaten)

    @property
    def designs(self) -> int:
        """With how many lights in how many numbers each imager comes."""
        return int(self.bounds.sizes.sum())

    def charge_imagers(self, discarded: Mapping[str, int]) -> None:
        """Count imagers that rules discard under any light."""
        for rule, count in discarded.items():
            self.account.charge(rule, count * self.bounds.tables.problem.illuminators)

    def remember(self, rule: str, depth: int, rows: Any, lost: Array) -> None:
        """Some of what a rule discards, for an audit: the first imager of each row."""
        self.tally.remember(rule, len(lost), lambda at: (*self.one_of(depth, rows, int(lost[at])), None))

    # ------------------------------------------------------------ levels

    def imagers_in(self, depth: int, rows: Any) -> Array:
        """How many imagers each row of a level holds."""
        return np.ones(len(rows.imager), int)

    def one_of(self, depth: int, rows: Any, row: int) -> tuple[int, int, int, bool]:
        """Camera, lens, port and orientation of the first imager of a row."""
        return self.bounds.imagers.sample(int(rows.imager[row]), None)[:4]

    def parts_of(self, depth: int, rows: Any) -> tuple[Columns, Array]:
        """The parts of the rows of a level that its bounds leave, with what the rows are at best."""
        raise IndexError(depth)  # leaves have none

    def handed_over(self, rows: Any) -> tuple[Bounds, Array]:
        """Bounds of the imagers behind leaves that pass all rules, and which of them these are."""
        return self.bounds, rows.imager

    def keeping(self, best: list[Found]) -> tuple[Bounds, list[Found]]:
        """Bounds of imagers that hold the best designs, and these as designs of them."""
        return self.bounds, best


# ---------------------------------------------------------------- what waits


@dataclass(frozen=True)
class WaitingRows:
    """Rows with their ideals, best first."""

    rows: Columns
    ideals: Array

    @staticmethod
    def of(rows: Columns, ideals: Array, by: Goal) -> WaitingRows:
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
    by: Goal

    @staticmethod
    def none(levels: int, by: Goal) -> OpenRows:
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
