"""What is known of missions that differ in what is sure to ask for more: bounds, what meets them, and what does not.

    least(i, k; stricter) >= least(i, k; weaker) >= bound(i, k)        for every imager i under every lighting k

A node that has no design within the rules of the weaker mission has none in the stricter, and none better: of the
stricter mission only those nodes are searched whose bound is no more than what is reached there. Whatever contradicts a
proof is a defect and no answer: what something reaches in a mission holds in all that ask for less, and what nothing
betters there is bettered by nothing where more is asked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.choose import Selection
from uwopt.deadline import Deadline
from uwopt.errors import SolverError
from uwopt.forward.problem import Problem
from uwopt.forward.views import table_reach_m
from uwopt.mission.mission import Mission
from uwopt.mission.strictness import Asking
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.imagers import Imagers, PortBlock
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.node_designs import NodeDesigns
from uwopt.solvers.exact.search import Search
from uwopt.solvers.recommend import Sought
from uwopt.solvers.warm.tables import imagers_of_pairs
from uwopt.tolerances import AGREES_REL


@dataclass(frozen=True)
class KeptBounds:
    """The nodes of one search of which some design may fit, by their bound, least first.

    Those that are not in it have no design that fits.
    """

    selection: Selection
    problem: Problem
    node: Array  # imager's number (see `numbers`) times the number of light optics, plus its lighting's
    least: Array
    tight: bool = False  # whether the light of every design has been looked at
    widest_m: Sequence[float] | None = None  # by scene, as far as tables of light reach: those of all searches are one

    def __len__(self) -> int:
        return len(self.node)

    @staticmethod
    def of(search: Search, selection: Selection, least: Array) -> KeptBounds:
        """The bounds of a search that has its imagers, (n_lightings, n); nodes without a design are left out."""
        lighting, imager = np.nonzero(np.isfinite(least))
        node = numbers(search.problem, search.imagers)[imager] * len(search.problem.optics)
        node += np.array([each.optics for each in search.tables.lightings], int)[lighting]
        widest_m = search.widest_m or [table_reach_m(scene.view) for scene in search.imagers.scenes]
        return KeptBounds(selection, search.problem, node, least[lighting, imager], widest_m=widest_m).in_order()

    def in_order(self) -> KeptBounds:
        """The same, least first."""
        order = np.argsort(self.least, kind="stable")
        return replace(self, node=self.node[order], least=self.least[order])

    def with_some(self, some: Array, made: KeptBounds) -> KeptBounds:
        """These bounds, of some nodes those that were made for a mission that asks for no less."""
        new = np.isin(made.node, some)
        order = np.argsort(self.node)
        old = self.least[order[np.searchsorted(self.node[order], made.node[new])]]
        rest = ~np.isin(self.node, some)
        node = np.concatenate([self.node[rest], made.node[new]])
        least = np.concatenate([self.least[rest], np.maximum(old, made.least[new])])
        return replace(self, node=node, least=least).in_order()

    def within(self, most: float, beyond: float = -np.inf) -> Array:
        """The nodes whose bound is no more than a value, and more than another."""
        first, last = (np.searchsorted(self.least, value, side="right") for value in (beyond, most))
        return self.node[first:last]


def numbers(problem: Problem, imagers: Imagers | PortBlock) -> Array:
    """A number of each imager that tells it from the others of the same parts, (n,)."""
    places = imagers.camera, imagers.lens, imagers.port, np.asarray(imagers.landscape, int)
    return np.asarray(np.ravel_multi_index(places, sizes(problem)))


def sizes(problem: Problem) -> tuple[int, int, int, int]:
    """How many cameras, lenses, ports and orientations there are."""
    parts = problem.parts
    return len(parts.cameras), len(parts.lenses), len(parts.ports), 2


def some_nodes(problem: Problem, node: Array) -> tuple[Imagers, Array]:
    """The imagers of some nodes that pass the rules of a problem, and which lights shine in those nodes."""
    imager, optics = np.divmod(node, len(problem.optics))
    lights = np.isin(problem.lights.optics_index, np.unique(optics))
    return imagers_by_number(problem, np.unique(imager)), lights


def imagers_by_number(problem: Problem, wanted: Array) -> Imagers:
    """Those of some imagers, rising, that pass the rules of a problem."""
    camera, lens, port, landscape = np.unravel_index(wanted, sizes(problem))
    n_lens = len(problem.parts.lenses)
    like, pairs = problem.like_port[port], dict[tuple[int, bool], tuple[Array, Array]]()
    place = 2 * like + landscape
    for one in np.unique(place):
        mine = place == one
        both = np.unique(camera[mine] * n_lens + lens[mine])
        pairs[int(one) // 2, bool(one % 2)] = both // n_lens, both % n_lens

    def kept(block: PortBlock) -> PortBlock:
        number = numbers(problem, block)
        place = np.minimum(np.searchsorted(wanted, number), len(wanted) - 1)  # they rise
        return block.take(np.flatnonzero(wanted[place] == number))

    return imagers_of_pairs(problem, pairs, kept)


def least_of_nodes(search: Search, deadline: Deadline) -> Array:
    """Lower bounds on the objective of any design of each node, inf where none fits, (n_lightings, n)."""
    rows, made = np.arange(len(search.imagers)), list[Array]()
    for k in range(len(search.tables.lightings)):
        deadline.check()
        bounds = search.bounds.of_nodes(k, rows)
        made.append(np.where(bounds.rule < 0, bounds.value, np.inf))
    return np.stack(made) if made else np.empty((0, len(rows)))


def least_of_designs(search: Search, deadline: Deadline) -> Array:
    """The same, dearer and tighter: every design in the light that it has, as if there were no veil."""
    least = least_of_nodes(search, deadline)
    lighting, imager = np.nonzero(np.isfinite(least))
    for some in search.together(Under(search.tables.lightings, lighting)):
        deadline.check()
        at = lighting[some], imager[some]
        least[at] = np.maximum(least[at], least_under(search, *at))
    return least


def least_under(search: Search, lighting: Array, imager: Array) -> Array:
    """The least that a design of each imager can have under the lighting of each without a veil, (n,)."""
    under, least = Under(search.tables.lightings, lighting), np.full(len(imager), np.inf)
    designs = NodeDesigns.every(search.imagers, imager, under, search.bounds.light_tables)
    designs = designs.take(np.flatnonzero(designs.within(search.limits)))
    if len(designs):
        lights = [light.take(designs.node) for light in search.tables.in_scenes(under, imager, veils="none")]
        np.minimum.at(least, designs.node, search.solve(designs, lights, optimistic=True, stage="none")[0])
    return least


# ---------------------------------------------------------------- of missions that differ in some keys


LEAST_GUESS, MOST_GUESS = 0.02, 0.15  # by which share the optimum is worse than that of a weaker mission, it is guessed
MOST_BOUNDS = 12  # of one family
MOST_SHOWN = 64  # values of a family that what is proven is held against


class Met(NamedTuple):
    """A mission that something meets."""

    asks: Asking
    mission: Mission
    minimised: float  # the optimum
    lower_bound: float  # that is proven


@dataclass
class Family:
    """What is known of missions that differ in what is sure to ask for more, of the same parts."""

    bounds: list[tuple[Asking, KeptBounds]] = field(default_factory=list)
    met: list[Met] = field(default_factory=list)
    missed: list[Asking] = field(default_factory=list)  # by everything
    shown: list[tuple[Asking, float]] = field(default_factory=list)  # values that something reaches
    waiting: tuple[Asking, Sought] | None = None  # a search whose bounds are not taken yet
    share: float = MOST_GUESS  # by which the next optimum is guessed to be worse than that of a weaker mission

    def learn(self, goal: Objective, weaker: Met, reached: float) -> None:
        """Guess the next step as twice the last."""
        seen = goal.share(max(reached - weaker.minimised, 0.0), weaker.minimised)
        self.share = min(max(2.0 * seen, LEAST_GUESS), MOST_GUESS)

    def nearest_met(self, asks: Asking) -> Met | None:
        """Of the missions that ask for no more the one whose optimum is the worst."""
        weaker = [one for one in self.met if one.asks.asks_no_more(asks)]
        return max(weaker, key=lambda one: one.minimised, default=None)

    def show(self, goal: Objective, asks: Asking, reached: float) -> None:
        """Something reaches a value in a mission; raises SolverError where nothing should in one that asks for less."""
        if any(one.asks.asks_no_more(asks) and is_below(goal, reached, one.lower_bound) for one in self.met):
            raise SolverError(contradiction(goal, reached))
        self.shown = [*self.shown[1 - MOST_SHOWN :], (asks, reached)]

    def prove(self, goal: Objective, asks: Asking, lower_bound: float) -> None:
        """Nothing is better in a mission; raises SolverError where something is, in that or one that asks for more."""
        for stricter, reached in self.shown:
            if asks.asks_no_more(stricter) and is_below(goal, reached, lower_bound):
                raise SolverError(contradiction(goal, reached))

    def keep(self, asks: Asking, kept: KeptBounds) -> None:
        """Further bounds; of many the first and the last few stay."""
        self.bounds.append((asks, kept))
        if len(self.bounds) > MOST_BOUNDS:
            del self.bounds[1]


def is_below(goal: Objective, value: float, bound: float) -> bool:
    """Whether a value is below a bound by more than two ways of computing it differ."""
    if math.isinf(bound):
        return value < bound
    return goal.share(max(bound - value, 0.0), bound) > AGREES_REL


def contradiction(goal: Objective, reached: float) -> str:
    """What to say where a search that was helped by others has missed something."""
    return (
        f"something reaches {goal.reported(reached):.9g} that a search which used bounds of other missions has missed; "
        "this is a defect of uwopt"
    )
