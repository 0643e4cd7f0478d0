"""The tree above the imagers of a large catalogue: pairs of camera and lens, behind groups of ports.

Pairs are taken in order of what they are at best without any port or light. Each is bounded behind groups of ports,
the groups are split where the bound does not settle them, and the imagers that are left are handed to whoever
searches, best bound first. Every combination is counted once, by the rule that discards it. What can matter is for a
`Goal` to say: a search for one optimum and one for a front take the same way.
"""

from __future__ import annotations

import time
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from uwopt.deadline import Deadline
from uwopt.forward.problem import Problem
from uwopt.forward.views import CORNERS_REACH, edge_m
from uwopt.model.imaging import FARTHEST
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.exact.account import Account, snr_ceiling
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.candidates import Candidates
from uwopt.solvers.exact.floor_rectangles import Rectangles
from uwopt.solvers.exact.imager_rules import SAMPLES, limit
from uwopt.solvers.exact.imagers import FittingPairs, PortBlock, imagers_behind, joined, landscapes
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.node_bounds import NODE_RULES
from uwopt.solvers.exact.oblique import PlaneReach, deepest_m
from uwopt.solvers.exact.outline import Level, OutlineRows, OutlineTables, port_tree
from uwopt.tolerances import COARSE_ROUND

Array = NDArray[Any]
FIRST_PAIRS, LARGEST_PAIRS = 512, 32768  # that are bounded together
MOST_ROWS = 65536  # rows of an outline that are bounded together
MOST_PENDING = 50_000  # imagers that wait for their search
FIRST_LEAVES, LARGEST_LEAVES = 256, 16384  # imagers that are searched together
MOST_SAMPLES = 1024  # discarded imagers remembered per rule, for an audit


class Goal(Protocol):
    """What a search of a large catalogue looks for."""

    def ideals(self, terms: Terms) -> Array:
        """What designs are at best, by the best of each term, (n, n_objectives); less is better."""

    def beaten(self, ideals: Array) -> Array:
        """Which of them cannot matter any more, (n,)."""

    def order(self, ideals: Array) -> Array:
        """Their places, those to look at first before the others."""

    def search(self, candidates: Candidates) -> bool:
        """Search among imagers; False when time ran out."""


class PairTree:
    """Pairs of camera and lens behind groups of ports, and how far they are searched."""

    def __init__(
        self, problem: Problem, objective: Objective, pairs: FittingPairs, goal: Goal, account: Account, *,
        lights: Array | None = None,
    ):  # fmt: skip
        """`account` is charged with what is discarded here; `lights` marks those that are searched."""
        self.problem, self.objective, self.pairs, self.goal, self.account = problem, objective, pairs, goal, account
        self.levels = [Level(problem, groups) for groups in port_tree(problem)]
        self.n_port, self.orientations = len(problem.parts.ports), landscapes(problem)
        low, high = problem.count_range
        self.every = len(problem.parts.lights) * (high - low + 1) * len(problem.mounts)
        self.samples = pairs.samples
        self.pending: list[tuple[OutlineRows, Array]] = []  # imagers with their ideals
        self.left = np.arange(len(pairs.camera))  # pairs that are not taken yet, in their order
        self.outline_s = 0.0
        none = joined(problem, [], {}, self.samples)
        tables = FieldTables(
            problem, none, widest_m=[CORNERS_REACH * self._farthest_m(i) for i in range(len(problem.scenes))]
        )
        for index, scene in enumerate(problem.scenes):
            for altitude in {scene.nominal, len(scene.range_m) - 1}:
                tables.set_widest(index, altitude, self._widest(index, altitude))
        bounds = Bounds(objective, none, tables, lights=lights, coupled=True)
        self.none = Candidates(none, tables, bounds)  # its tables of lights serve all others
        self.floors = goal.ideals(self.floor_terms())

    @property
    def _sizes(self) -> int:
        """How many lights, numbers and mounts an imager comes with."""
        return sum(len(table.light) for table in self.none.bounds.light_tables)

    def open_account(self) -> None:
        """Every combination of the parts, and the pairs that do not fit."""
        parts = self.problem.parts
        pairs = len(parts.cameras) * len(parts.lenses)
        self.account.total = pairs * self.n_port * len(self.orientations) * self.every
        for rule, count in self.pairs.discarded.items():
            self.account.charge(rule, count * self.every)

    def _farthest_m(self, scene_index: int) -> float:
        """No such image reaches farther from the axis; of a tilted plane from the port."""
        scene = self.problem.scenes[scene_index]
        altitude = len(scene.range_m) - 1
        if not scene.slope:
            return float(np.hypot(*self._widest_m(scene_index, altitude)))
        reach = self._reach(scene_index, altitude)
        return float(np.hypot(float(scene.range_m[-1]) + reach.ahead_m, reach.across_ahead_m)[0])

    def _widest(self, scene_index: int, altitude: int) -> Rectangles:
        """The rectangle that holds all such images at one altitude."""
        problem, scene = self.problem, self.problem.scenes[scene_index]
        if scene.slope:
            return Rectangles.tilted(self._reach(scene_index, altitude), deepest_m(problem, scene_index))
        along_m, across_m = (np.array([edge]) for edge in self._widest_m(scene_index, altitude))
        behind_m, share = Rectangles.paths(problem, scene_index, float(scene.range_m[altitude]))
        return Rectangles(along_m, across_m, along_m * across_m, along_m, behind_m, share)

    def _small_enough(self, scene_index: int, group: int, *, landscape: bool) -> OutlineRows:
        """Pairs behind one group of the first level whose pixels may be small enough, and whose view may end."""
        level, scene = self.levels[0], self.problem.scenes[scene_index]
        rows = self._rows(np.arange(len(self.pairs.camera)), group, landscape=landscape)
        limit_mm = limit(scene.view.requirements.max_gsd_mm)
        small = rows.take(level.gsd_m(scene_index, rows)[:, 2] * 1e3 <= limit_mm * COARSE_ROUND)
        if not scene.slope:
            return small
        return small.take(level.view(scene_index, small, level.groups.least).farthest <= FARTHEST * COARSE_ROUND)

    def _reach(self, scene_index: int, altitude: int) -> PlaneReach:
        """The most of `Level.reach` over all such pairs, as columns of length one."""
        level, scene = self.levels[0], self.problem.scenes[scene_index]
        most = np.full((len(PlaneReach._fields), 1), 1e-6)
        for group in range(len(level.groups.start)):
            for landscape in self.orientations:
                rows = self._small_enough(scene_index, group, landscape=landscape)
                found = np.array(level.reach(scene, rows, float(scene.range_m[altitude])))
                most = np.maximum(most, found.max(axis=1, initial=0.0)[:, None])
        return PlaneReach(*most)

    def _widest_m(self, scene_index: int, altitude: int) -> tuple[float, float]:
        """No image of a pair whose pixels are small enough reaches farther from the axis, either way."""
        level, scene = self.levels[0], self.problem.scenes[scene_index]
        range_m, widest = np.array([scene.range_m[altitude]]), 1e-6
        for group in range(len(level.groups.start)):
            rows = self._small_enough(scene_index, group, landscape=True)
            for _, _, most in level.ends(scene, rows.group[:1]):
                tangent = np.max(level.tangents(scene, rows, most), keepdims=True)[0]
                widest = max(widest, float(edge_m(scene, most, tangent, range_m)[0, 0]))
        return widest, widest

    def _rows(self, pairs: Array, group: int, *, landscape: bool) -> OutlineRows:
        """Pairs behind one group of the first level."""
        n = len(pairs)
        return OutlineRows(
            self.pairs.camera[pairs], self.pairs.lens[pairs], np.full(n, landscape), np.full(n, group)
        )

    # ------------------------------------------------------------ pairs

    def search(self, deadline: Deadline) -> bool:
        """Take all pairs that may matter; False when time ran out. Interrupted, it stays as it was before the step."""
        self.left, chunk = self.goal.order(self.floors), FIRST_PAIRS
        while len(self.left):
            self._close_beaten()
            pairs, rest = self.left[:chunk], self.left[chunk:]
            if len(pairs) == 0:
                break
            if deadline.passed():
                return False
            before, waiting = self.account.snapshot(), list(self.pending)
            try:
                self._outline(pairs)
            except KeyboardInterrupt:
                self.account.restore(before)
                self.pending = waiting
                raise
            self.left = rest
            full = sum(len(rows) for rows, _ in self.pending) > MOST_PENDING
            if (chunk == FIRST_PAIRS or full or not len(rest)) and not self._search_pending():
                return False
            chunk = min(2 * chunk, LARGEST_PAIRS)
        return self._search_pending()

    def open_ideals(self) -> Array:
        """What is not searched yet could be at best, (n, n_objectives)."""
        return np.concatenate([self.floors[self.left], *(ideals for _, ideals in self.pending)])

    def floor_terms(self) -> Terms:
        """What each pair is at best: no light, the cheapest port, the smallest pixel."""
        problem, pairs, level = self.problem, self.pairs, self.levels[0]
        cameras, lenses, ports = problem.cameras, problem.lenses, problem.ports
        count, (extra_cost, extra_mass, _) = problem.mission.vehicle.camera_count, problem.extras
        every, gsd_mm = np.arange(len(pairs.camera)), np.full(len(pairs.camera), np.inf)
        for group in range(len(level.groups.start)):
            turned = [self._rows(every, group, landscape=landscape) for landscape in (True, False)]
            worst_m = np.max([
                np.minimum(*(level.gsd_m(index, one)[:, 1] for one in turned)) for index in range(len(problem.scenes))
            ], axis=0)  # fmt: skip
            gsd_mm = np.minimum(gsd_mm, worst_m * 1e3)
        cost = cameras.price[pairs.camera] + lenses.price[pairs.lens] + ports.price.min()
        mass = cameras.mass_kg[pairs.camera] + lenses.mass_kg[pairs.lens] + ports.mass_kg.min()
        information = np.full(len(every), np.inf if self.objective.weight("information") else 0.0)
        return Terms(
            problem.least_camera_power_w(cameras)[pairs.camera], count * cost + extra_cost, count * mass + extra_mass,
            np.full(len(every), snr_ceiling(self.objective)), gsd_mm, np.ones(len(every)), information,
        )  # fmt: skip

    def _close_beaten(self) -> None:
        """Pairs that cannot matter."""
        beaten = self.goal.beaten(self.floors[self.left])
        pairs, self.left = self.left[beaten], self.left[~beaten]
        if len(pairs):
            self.account.charge("bound", len(pairs) * self.n_port * len(self.orientations) * self._sizes)
            rows = self._rows(pairs, 0, landscape=self.orientations[0])
            self._remember("bound", self.levels[0], rows, np.arange(len(rows)))

    def _remember(self, rule: str, level: Level, rows: OutlineRows, discarded: Array) -> None:
        """Some of what a rule discards, for an audit: the first port of each group."""
        kept = self.samples.setdefault(rule, [])
        if len(discarded) and len(kept) < MOST_SAMPLES:
            first = level.groups.order[level.groups.start]
            for i in discarded[:: max(1, len(discarded) // SAMPLES)]:
                kept.append(
                    (
                        int(rows.camera[i]),
                        int(rows.lens[i]),
                        int(first[rows.group[i]]),
                        bool(rows.landscape[i]),
                    )
                )

    # ------------------------------------------------------------ outlines

    def _outline(self, pairs: Array) -> None:
        """Bound pairs behind ever smaller groups of ports; what is left are imagers that wait for their search."""
        start = time.perf_counter()
        groups = range(len(self.levels[0].groups.start))
        self._descend(0, OutlineRows.joined([
            self._rows(pairs, group, landscape=landscape) for group in groups for landscape in self.orientations
        ]))  # fmt: skip
        self.outline_s += time.perf_counter() - start

    def _descend(self, depth: int, rows: OutlineRows) -> None:
        """Bound rows at one level, split what is left, and so on."""
        level = self.levels[depth]
        for begin in range(0, len(rows), MOST_ROWS):
            some = rows.take(np.arange(begin, min(begin + MOST_ROWS, len(rows))))
            left, ideals = self._bounded(level, some)
            if len(left) == 0:
                continue
            if depth + 1 < len(self.levels):
                self._descend(depth + 1, self._split(depth, left))
            else:
                self.pending.append((left, ideals))

    def _split(self, depth: int, rows: OutlineRows) -> OutlineRows:
        """The same rows behind the parts of their groups."""
        starts, groups = self.levels[depth + 1].groups.start, self.levels[depth].groups
        first, end = np.searchsorted(starts, groups.start), np.searchsorted(starts, groups.stop)
        counts = (end - first)[rows.group]
        parent = np.repeat(np.arange(len(rows)), counts)
        within = np.arange(len(parent)) - np.repeat(np.cumsum(counts) - counts, counts)
        children = rows.take(parent)
        return OutlineRows(children.camera, children.lens, children.landscape, first[children.group] + within)

    def _bounded(self, level: Level, rows: OutlineRows) -> tuple[OutlineRows, Array]:
        """The rows that may matter, with their ideals; the others are counted by what discards them."""
        account, imagers, size = self.account, level.imagers(rows), level.groups.size[rows.group]
        alive = np.ones(len(rows), bool)
        for rule, passes in level.rules(rows, imagers):
            failed = np.nonzero(alive & ~passes)[0]
            account.charge(rule, int(size[failed].sum()) * self.every)
            self._remember(rule, level, rows, failed)
            alive &= passes
        index = np.nonzero(alive)[0]
        if len(index) == 0:
            return rows.take(index), self.floors[:0]
        own = self.none.bounds
        tables = OutlineTables(level, rows, imagers, self.none.tables)
        bounds = Bounds(self.objective, imagers, tables, lights=own.searched, coupled=True, like=own)
        best, rules = np.full((len(index), self.floors.shape[1]), np.inf), []
        open_ = np.zeros(len(index), bool)
        for k in range(len(tables.lightings)):
            node = bounds.of_nodes(k, index)
            able = np.flatnonzero((node.rule < 0) & np.isfinite(node.value))
            ideals = self.goal.ideals(node.terms(able, imagers.gsd_mm[index[able]]))
            matters = ~self.goal.beaten(ideals)
            open_[able[matters]] = True
            best[able[matters]] = np.minimum(best[able[matters]], ideals[matters])
            rules.append(node.rule.astype(np.int8))
        closed = np.nonzero(~open_)[0]
        for k, found in enumerate(rules):
            weights = size[index[closed]] * len(own.light_tables[k].light)
            for number, name in enumerate(NODE_RULES):
                mine = found[closed] == number
                account.charge(name, int(weights[mine].sum()))
                if k == 0:
                    self._remember(name, level, rows, index[closed[mine]])
            account.charge("bound", int(weights[found[closed] < 0].sum()))
        return rows.take(index[open_]), best[open_]

    # ------------------------------------------------------------ imagers

    def _search_pending(self) -> bool:
        """Search the imagers that wait, best first; False when time ran out before the end."""
        if not self.pending:
            return True
        level = self.levels[-1]
        rows = OutlineRows.joined([waiting for waiting, _ in self.pending])
        ideals = np.concatenate([each for _, each in self.pending])
        batch, each = FIRST_LEAVES, max(1, int(level.groups.size.mean()))  # ports behind a row
        order = self.goal.order(ideals)
        rows, ideals = rows.take(order), ideals[order]
        while True:
            beaten = self.goal.beaten(ideals)
            lost = np.flatnonzero(beaten)
            self.account.charge("bound", int(level.groups.size[rows.group[lost]].sum()) * self._sizes)
            self._remember("bound", level, rows, lost)
            rows, ideals = rows.take(~beaten), ideals[~beaten]
            self.pending = [(rows, ideals)] if len(rows) else []
            if len(rows) == 0:
                return True
            ahead = slice(max(1, batch // each))
            before = self.account.snapshot()
            try:
                candidates = self.candidates(rows.take(ahead))
                if len(candidates.imagers) and not self.goal.search(candidates):
                    return False
            except KeyboardInterrupt:
                self.account.restore(before)
                raise
            rows, ideals = rows.take(slice(ahead.stop, None)), ideals[ahead.stop :]
            batch = min(4 * batch, LARGEST_LEAVES)

    def candidates(self, rows: OutlineRows) -> Candidates:
        """The imagers behind the ports of these rows that pass all rules."""
        blocks: list[PortBlock] = []
        groups, discarded = self.levels[-1].groups, dict.fromkeys(self.account.discarded, 0)
        for number in np.unique(rows.group):
            alike = groups.order[groups.start[number] : groups.stop[number]]
            for landscape in self.orientations:
                mine = np.nonzero((rows.group == number) & (rows.landscape == landscape))[0]
                blocks += list(imagers_behind(
                    self.problem, rows.camera[mine], rows.lens[mine], alike, landscape, discarded, self.samples
                ))  # fmt: skip
        for rule, count in discarded.items():
            self.account.charge(rule, count * self.every)
        return self.none.others(joined(self.problem, blocks, {}, self.samples))
