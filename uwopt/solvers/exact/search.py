"""The exact search: best design of a catalogue with a proof that nothing better is in it.

Designs are imagers under a lighting (light optics at a mount) with a number of lamps of one light.
Every (imager, lighting) is a node with a lower bound on the objective; nodes are taken best first,
their signal is computed exactly, their lights and counts are solved in closed form, and the search
stops when no bound beats the best. Each combination is counted once, by the first rule that discards
it, so that the account adds up.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline, OutOfTimeError, Progress, unheard
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.exact.account import NOT_REACHED, Outcome
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.evaluation import Evaluation
from uwopt.solvers.exact.imager_rules import Sample, Tally
from uwopt.solvers.exact.imagers import (
    FittingPairs,
    Imagers,
    enumerate_imagers,
    fitting_pairs,
    imagers_in,
    landscapes,
)
from uwopt.solvers.exact.large import PairTree
from uwopt.solvers.exact.node_bounds import NodeBounds
from uwopt.solvers.exact.open_nodes import OpenNodes
from uwopt.solvers.exact.tree import Goal, Tree

FIRST_BATCH, LARGEST_BATCH = 32, 8192
UNBEATEN_GROWTH = 4  # of batches while nothing is found: light is cheaper for many nodes at once
LARGEST_COSTLY = 256  # where each node takes light at pixels: the next batch then knows what this one found
LARGEST_UNBEATEN = 16384  # the same as long as nothing is found: where nothing fits all nodes are evaluated
DEAR_REFINED, CHEAP_REFINED = 256, 2048  # at least, where bounds weigh quality: each call sorts all nodes anew
REFINED_AHEAD = 8  # batches of nodes whose bounds are made better before the first of them is taken
FIRST_ENOUGH = 1  # of a first batch where one is enough: often the first does, and the light of each is dear
FIRST_DEAR = 4  # of a first batch where information counts: dear to bound while nothing is
# found that others must beat
MOST_IMAGERS = 700_000  # beyond which pairs are bounded before their ports: more than the whole catalogue has
SAMPLES = 64  # of nodes that a rule discards, about
FIRST_BOUNDED = 4096  # imagers: of fewer, bounds cost about as much
MORE_BOUNDED = 3  # times as many as have bounds are bounded next
TOO_FEW_TO_BOUND = 8  # nodes: evaluating them is cheaper
#: What is told of a search beside how far it is; a line of its own for every number of them would fill a log.
BOUNDS, SETTINGS, SETTINGS_IN_VAIN = "bounds of systems", "settings of systems", "settings of systems, none fits yet"
TAKEN = 1.0 + 1e-12  # of a threshold: outlines are summed in another order


def are_too_many(problem: Problem, pairs: FittingPairs) -> bool:
    """Whether pairs of camera and lens are bounded before their ports."""
    return len(pairs.camera) * len(problem.port_groups) * len(landscapes(problem)) > MOST_IMAGERS


@dataclass(frozen=True)
class Cheapest:
    """The least of one objective, as the goal of a search."""

    objective: Objective
    search: Callable[[Bounds, Array], Array]
    threshold: Callable[[], float]

    def ideals(self, terms: Terms) -> Array:
        """Least objective, (n, 1)."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.objective.cost_to_minimise(terms))[:, None]

    def beaten(self, ideals: Array) -> Array:
        """What gets no place among the best."""
        return np.asarray(ideals[:, 0] > self.threshold() * TAKEN)

    def order(self, ideals: Array) -> Array:
        """Least first."""
        return np.argsort(ideals[:, 0], kind="stable")


class Search(Evaluation):
    """State of one search."""

    def __init__(
        self, problem: Problem, objective: Objective, *, progress: Progress | None = None,
        imagers: Imagers | None = None, widest_m: Sequence[float] | None = None, **how: Any,
    ):  # fmt: skip
        """`imagers`: those to search, of all that there are; `how` as of `Evaluation`.

        widest_m : by scene, how far tables of light reach whatever the imagers see; None: as far as they do
        """
        super().__init__(problem, objective, **how)
        self.given, self.widest_m = imagers, widest_m
        self.every_imager: Imagers | None = None  # of all parts, once they are listed
        self.progress, self.waited = progress or unheard, 0  # told; and of how many combinations it tells how far it is
        self.bounds_s = 0.0
        self.tally = Tally()  # some of the nodes that are discarded; of imagers, theirs has it

    # ------------------------------------------------------------ run

    def run(self) -> Outcome:
        """Enumerate, bound, evaluate best first."""
        start, complete, interrupted = time.perf_counter(), False, False
        self.progress(0.0, "imagers")
        try:
            tree = self.tree(Cheapest(self.objective, self.among, lambda: self.ranking.threshold()))
        except OutOfTimeError:  # before they were listed
            none = imagers_in(self.problem, [])
            self.take_up(Bounds.of(self.problem, self.objective, none, lights=self.only.get("light")))
            imagers_s, lowest = time.perf_counter() - start, float(self._camera_floor().min(initial=np.inf))
        else:
            imagers_s = time.perf_counter() - start
            self.waited = self.account.waiting
            complete = tree.search(self.deadline, self._tell)
            imagers_s, lowest = imagers_s + tree.groups_s, float(tree.open_ideals().min(initial=np.inf))
            interrupted = tree.interrupted
            bounds, winners = tree.keeping(self.ranking.best)
            self.take_up(bounds)
            self.ranking.best = winners
        if not complete:
            self.account.leave_the_rest()
        timing = {
            "imagers": imagers_s, "bounds": self.bounds_s,
            "evaluation": time.perf_counter() - start - imagers_s - self.bounds_s,
        }  # fmt: skip
        best = self.ranking.best[0].minimised if self.ranking.best else self.ceiling if complete else np.inf
        lower = min(lowest, best, self.open_gap_bound)
        return Outcome(
            self.ranking.best, self.account, lower, complete, self.imagers, self.tables, timing, interrupted
        )

    def _tell(self, what: str) -> None:
        """Tell how far it is, by what is accounted for."""
        self.progress(1.0 - self.account.waiting / self.waited if self.waited else 0.0, what)

    def whole(self) -> Outcome:
        """As `run`, where what was found until a person wants no more is of no use. Raises KeyboardInterrupt then."""
        outcome = self.run()
        if outcome.interrupted:
            raise KeyboardInterrupt
        return outcome

    def tree(self, goal: Goal) -> Tree:
        """All that there is to search, pairs of camera and lens first where imagers are too many to list.

        Every combination is accounted for or waits in it. Raises OutOfTimeError, with the account's total known.
        """
        self.account.total = self._every_imager * self.problem.illuminators
        pairs = None if self.given is not None else fitting_pairs(self.problem, cameras=self._cameras_below_ceiling())
        if pairs is None or not are_too_many(self.problem, pairs):
            self.prepare(self.deadline)
            return Tree(self.bounds, goal, self.account, self.tally)
        tree = PairTree(self.problem, self.objective, pairs, goal, self.account, lights=self.only.get("light"))
        self.take_up(tree.bounds)
        return tree

    def prepare(self, deadline: Deadline = NEVER) -> Imagers:
        """Enumerate imagers and tabulate lights: all that evaluation needs. Raises OutOfTimeError."""
        imagers = self.given
        if imagers is None:
            cameras = self._cameras_below_ceiling()
            imagers = enumerate_imagers(self.problem, cameras=cameras, deadline=deadline)
            if cameras.all():
                self.every_imager = imagers
        self.take_up(Bounds.of(
            self.problem, self.objective, imagers, lights=self.only.get("light"), widest_m=self.widest_m
        ))  # fmt: skip
        return imagers

    def _cameras_below_ceiling(self) -> Array:
        """Cameras that are not beyond the ceiling by themselves."""
        return np.asarray(self._camera_floor() <= self.ceiling) & self.only.get("camera", True)

    def _camera_floor(self) -> Array:
        """What each camera is at best by itself, whatever goes with it."""
        rows, count = self.problem.cameras, self.problem.mission.vehicle.camera_count
        extra_cost, extra_mass, _ = self.problem.extras
        return np.asarray(self.objective.cost_to_minimise(
            Terms.at_best(
                self.problem.least_camera_power_w(rows), count * rows.price + extra_cost,
                count * rows.mass_kg + extra_mass, np.zeros(len(rows.price)),
            )
        ))  # fmt: skip

    @property
    def _every_imager(self) -> int:
        """How many there are of the parts in the search, or were given, those that no rule passes with them."""
        if self.given is not None:
            return len(self.given) + sum(self.given.tally.discarded.values())
        parts = self.problem.parts
        return len(parts.cameras) * len(parts.lenses) * len(parts.ports) * len(landscapes(self.problem))

    # ------------------------------------------------------------ best first

    def among(self, bounds: Bounds, imagers: Array) -> Array:
        """Search all nodes of some imagers; the least bound of what is left, (1, 1), (0, 1) where nothing is.

        Raises OutOfTimeError before there are bounds.
        """
        self.take_up(bounds)
        lowest = self._best_first(imagers)
        return np.empty((0, 1)) if lowest is None else np.array([[lowest]])

    def _best_first(self, rows: Array) -> float | None:
        """Take the nodes of these imagers in order of their bound until none can beat the best.

        Returns the lowest bound not looked at when time ran out, else None. Raises OutOfTimeError before the first is
        bounded: then none is accounted for.
        """
        if not len(self.tables.lightings):
            return None
        few = len(rows) * len(self.tables.lightings) <= TOO_FEW_TO_BOUND
        nodes = self._unbounded(rows)
        self._bound_more(nodes, len(rows), few=few)
        self._patient = self.bounds.weighs_quality()
        batch, least_look, costly = self._first_batch(), self._least_look(), bool(nodes.rough.any())
        look = max(least_look, REFINED_AHEAD * batch)
        try:
            while len(nodes):
                self._solve_waiting(nodes.lowest)
                threshold = self.ranking.threshold()
                unbounded = nodes.to_bound(look if costly else batch, threshold)
                if unbounded > 0:
                    self._bound_more(nodes, unbounded)
                    continue
                if nodes.begins_rough(threshold):
                    self._refine(nodes, nodes.rough_ahead(look, threshold))
                    look *= 2  # while nothing comes to the front that can be evaluated
                    continue
                ahead = nodes.ahead(batch, threshold)
                if len(ahead) == 0:
                    break
                self._take(nodes, ahead)
                self._solve_until_beatable()
                growth = 2 if self.ranking.best else UNBEATEN_GROWTH
                batch = min(growth * batch, self._largest_batch(costly=costly))
                look = max(least_look, REFINED_AHEAD * batch)
            self._solve_waiting()
        except OutOfTimeError:
            nodes.sort()  # where bounds were raised in part
            self.account.charge(NOT_REACHED, nodes.designs_left)
            return min(nodes.lowest, self._not_reached())
        self.account.charge("bound", nodes.designs_left)
        self._sample("bound", nodes.imager_of(nodes.waiting), nodes.lighting_of(nodes.waiting))
        self._sample("bound", nodes.unbounded)
        return None

    def _unbounded(self, rows: Array) -> OpenNodes:
        """The nodes of these imagers, with what each is at best whatever lights it."""
        floor = self.objective.cost_to_minimise(self.bounds.without_light(rows))
        return OpenNodes.of(rows, np.asarray(floor), self.imagers.cost[rows], self.bounds.sizes)

    def _bound_more(self, nodes: OpenNodes, count: int, *, few: bool = False) -> None:
        """First bounds of so many imagers that come next; what these discard is counted.

        count : not all at once while little is known of light: the first of them may leave nothing to the others
        few : so few nodes that to evaluate them all is cheaper
        Raises OutOfTimeError before any is accounted for.
        """
        self._tell(BOUNDS)
        start = time.perf_counter()
        rows = nodes.unbounded[: min(count, max(FIRST_BOUNDED, MORE_BOUNDED * nodes.bounded))]
        dark = np.zeros(len(rows), bool) if few else self.bounds.leaves_dark(rows, self.deadline)
        bounds = []
        for k in range(len(self.tables.lightings)):
            self.deadline.check()
            bounds.append(NodeBounds.none(len(rows)) if few else self.bounds.of_nodes(k, rows[~dark]))
        self.bounds_s += time.perf_counter() - start
        if dark.any():
            self.account.charge("light", int(self.bounds.sizes.sum() * dark.sum()))
            self._sample("light", rows[dark])
        for name, failed in nodes.bound(~dark, bounds, rough=not few and self.bounds.can_refine()):
            self._discard(name, nodes, failed)

    def _discard(self, rule: str, nodes: OpenNodes, failed: Array) -> None:
        """Count nodes that a rule discards, and remember some."""
        self.account.charge(rule, nodes.size_of(failed))
        self._sample(rule, nodes.imager_of(failed), nodes.lighting_of(failed))

    def _first_batch(self) -> int:
        """Nodes that are evaluated together at first."""
        if self.enough:
            return FIRST_ENOUGH
        return FIRST_DEAR if self.objective.weight("information") else FIRST_BATCH

    def _least_look(self) -> int:
        """Nodes at least whose bounds are made better together."""
        if not self._patient:
            return 0
        return DEAR_REFINED if self.bounds.asks_of_images() else CHEAP_REFINED

    def _largest_batch(self, *, costly: bool) -> int:
        """Nodes that are evaluated together, where each is costly: few as soon as there is something to beat."""
        if not costly:
            return LARGEST_BATCH
        return LARGEST_COSTLY if np.isfinite(self.ranking.threshold()) else LARGEST_UNBEATEN

    def _take(self, nodes: OpenNodes, ahead: Array) -> None:
        """Evaluate the nodes that come next. Raises OutOfTimeError: what was found stays, the batch is not reached."""
        useful = ahead[~self.ranking.shut_out(nodes.value[ahead], nodes.power_w[ahead], nodes.cost_of(ahead))]
        before, waited = self.account.snapshot(), list(self._waiting)
        self.account.charge("bound", nodes.size_of(ahead) - nodes.size_of(useful))
        try:
            self.deadline.check()
            if len(useful):
                self._tell(SETTINGS if self.ranking.best else SETTINGS_IN_VAIN)
                self.evaluate_nodes(nodes.lighting_of(useful), nodes.imager_of(useful))
        except OutOfTimeError:
            self.account.restore(before)
            self._waiting = waited
            raise
        nodes.drop(len(ahead))

    def _refine(self, nodes: OpenNodes, some: Array) -> None:
        """Bounds of some nodes by pixels and settings; what a rule discards is accounted for.

        Raises OutOfTimeError, with the bounds that are done in place: those left stay as valid as they were.
        """
        lighting = nodes.lighting_of(some)
        for k in np.unique(lighting):
            self.deadline.check()
            mine = some[lighting == k]
            for name, failed in nodes.refine(mine, self.bounds.refined(int(k), nodes.imager_of(mine))):
                self._discard(name, nodes, failed)
        nodes.rough[some] = False
        nodes.sort()

    def _sample(self, rule: str, imager: Array, lighting: Array | None = None) -> None:
        """Remember some of the nodes that a rule discards, for an audit; None: with any light."""
        self.tally.remember(rule, len(imager), lambda at: self.imagers.sample(
            int(imager[at]), None if lighting is None else int(lighting[at])
        ), SAMPLES)  # fmt: skip

    def discarded_samples(self) -> dict[str, list[Sample]]:
        """Combinations that each rule discarded; a lighting without lamps holds none."""
        pools: dict[str, list[Sample]] = {}
        for tally in (self.imagers.tally, self.tally):
            for rule, some in tally.samples.items():
                held = (one for one in some if one[4] is None or len(self.bounds.light_tables[one[4]].light))
                pools.setdefault(rule, []).extend(held)
        return pools
