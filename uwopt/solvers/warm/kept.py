"""Bounds of one mission that are kept for those that ask for more.

    least(i, k; stricter) >= least(i, k; weaker) >= bound(i, k)        for every imager i under every lighting k

A node that has no design within the rules of the weaker mission has none in the stricter, and none better: of the
stricter mission only those nodes are searched whose bound is no more than what is reached there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.choose import Selection
from uwopt.deadline import Deadline
from uwopt.forward.problem import Problem
from uwopt.forward.views import table_reach_m
from uwopt.solvers.exact.imagers import Imagers, PortBlock
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.node_designs import NodeDesigns
from uwopt.solvers.exact.search import Search
from uwopt.solvers.warm.tables import imagers_of


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

    return imagers_of(problem, pairs, kept)


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


