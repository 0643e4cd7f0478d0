"""The tree above the imagers of a large catalogue: groups of cameras with groups of lenses, behind groups of ports.

Whatever has the best bound comes next, at any level: groups are bounded, those that it does not settle are split, and
the imagers behind the last of them are handed to whoever searches. Every combination is counted once, by the rule that
discards it. What can matter is for a `Goal` to say: a search for one optimum and one for a front take the same way.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
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
from uwopt.solvers.exact.imager_rules import Behind, Tally, limit
from uwopt.solvers.exact.imagers import FittingPairs, imagers_in, landscapes
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.node_bounds import by_rule
from uwopt.solvers.exact.oblique import PlaneReach, deepest_m
from uwopt.solvers.exact.open_rows import OpenRows, WaitingRows
from uwopt.solvers.exact.outline import Level, OutlineRows, OutlineTables
from uwopt.solvers.exact.pair_groups import PairGroups, spread
from uwopt.solvers.exact.port_groups import port_tree
from uwopt.tolerances import COARSE_ROUND

Array = NDArray[Any]
FIRST_ROWS, LARGEST_ROWS = 512, 32768  # of an outline, that are bounded together
SHARE_OF_GROUPS = 16  # of that many are groups of pairs, which come apart into many rows
FIRST_LEAVES, LARGEST_LEAVES = 256, 16384  # imagers that are searched together


class Goal(Protocol):
    """What a search of a large catalogue looks for."""

    def ideals(self, terms: Terms) -> Array:
        """What designs are at best, by the best of each term, (n, n_objectives); less is better."""

    def beaten(self, ideals: Array) -> Array:
        """Which of them cannot matter any more, (n,)."""

    def order(self, ideals: Array) -> Array:
        """Their places, those to look at first before the others."""

    @property
    def search(self) -> Callable[[Candidates], bool]:
        """Search among imagers; False when time ran out."""


class PairTree:
    """Pairs of camera and lens behind groups of ports, and how far they are searched."""

    def __init__(
        self, problem: Problem, objective: Objective, pairs: FittingPairs, goal: Goal, account: Account, *,
        lights: Array | None = None,
    ):  # fmt: skip
        """`account` is charged with what is discarded here; `lights` marks those that are searched."""
        self.problem, self.objective, self.pairs, self.goal, self.account = problem, objective, pairs, goal, account
        ports = port_tree(problem)
        alike, *grouped = (Level(problem, ports[0], groups) for groups in PairGroups.levels(problem, pairs, objective))
        self.alike = alike  # every view that there is, and no other
        self.levels = [*grouped, *(Level(problem, groups) for groups in ports)]
        self.n_port, self.orientations = len(problem.parts.ports), landscapes(problem)
        self.every = len(problem.parts.lights) * problem.lamp_variants
        self.outline_s = 0.0
        self.tally = Tally(samples=pairs.tally.samples)  # of what is discarded here
        none = imagers_in(problem, [], self.tally)
        tables = FieldTables(
            problem, none, widest_m=[CORNERS_REACH * self._farthest_m(i) for i in range(len(problem.scenes))]
        )
        for index, scene in enumerate(problem.scenes):
            for altitude in {scene.nominal, len(scene.range_m) - 1}:
                tables.set_widest(index, altitude, self._widest(index, altitude))
        bounds = Bounds(objective, none, tables, lights=lights)
        self.none = Candidates(none, tables, bounds)  # its tables of lights serve all others
        rows = self._every_row(self.levels[0])
        floors = goal.ideals(self.floor_terms(self.levels[0], rows))
        self.n_ideals = floors.shape[1]
        self.open = OpenRows.none(len(self.levels) + 1, goal).put(0, rows, floors)

    @property
    def _sizes(self) -> int:
        """How many lights, numbers and mounts an imager comes with."""
        return int(self.none.bounds.sizes.sum())

    def open_account(self) -> None:
        """Every combination of the parts, and the pairs that do not fit."""
        parts = self.problem.parts
        pairs = len(parts.cameras) * len(parts.lenses)
        self.account.total = pairs * self.n_port * len(self.orientations) * self.every
        for rule, count in self.pairs.tally.discarded.items():
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
        """Views behind one group of ports whose pixels may be small enough, and that may end."""
        level, scene, rows = self.alike, self.problem.scenes[scene_index], self._every_row(self.alike)
        rows = rows.take((rows.group == group) & (rows.landscape == landscape))
        limit_mm = limit(scene.view.requirements.max_gsd_mm)
        small = rows.take(level.gsd_m(scene_index, rows)[:, 2] * 1e3 <= limit_mm * COARSE_ROUND)
        if not scene.slope:
            return small
        return small.take(level.view(scene_index, small, most=False).farthest <= FARTHEST * COARSE_ROUND)

    def _reach(self, scene_index: int, altitude: int) -> PlaneReach:
        """The most of `Level.reach` over all such pairs, as columns of length one."""
        level, scene = self.alike, self.problem.scenes[scene_index]
        most = np.full((len(PlaneReach._fields), 1), 1e-6)
        for group in range(len(level.groups.start)):
            for landscape in self.orientations:
                rows = self._small_enough(scene_index, group, landscape=landscape)
                found = np.array(level.reach(scene, rows, float(scene.range_m[altitude])))
                most = np.maximum(most, found.max(axis=1, initial=0.0)[:, None])
        return PlaneReach(*most)

    def _widest_m(self, scene_index: int, altitude: int) -> tuple[float, float]:
        """No image of a pair whose pixels are small enough reaches farther from the axis, either way."""
        level, scene = self.alike, self.problem.scenes[scene_index]
        range_m, widest = np.array([scene.range_m[altitude]]), 1e-6
        for group in range(len(level.groups.start)):
            rows = self._small_enough(scene_index, group, landscape=self.orientations[0])
            for _, _, most in level.ends(scene, rows.group[:1]):
                tangent = np.max(level.tangents(scene, rows, most), keepdims=True)[0]
                widest = max(widest, float(edge_m(scene, most, tangent, range_m)[0, 0]))
        return widest, widest

    def _every_row(self, level: Level) -> OutlineRows:
        """Every group of pairs behind every group of ports of a level, in all orientations."""
        assert level.pairs is not None
        pairs = level.pairs
        camera, lens = np.nonzero(pairs.count)
        groups = range(len(level.groups.start))
        return OutlineRows.joined([
            OutlineRows(camera, lens, np.full(len(lens), landscape), np.full(len(lens), group))
            for group in groups for landscape in self.orientations
        ])  # fmt: skip

    def floor_terms(self, level: Level, rows: OutlineRows) -> Terms:
        """What rows are at best, before they are bounded: no light, the cheapest port, the smallest pixel."""
        problem, cameras, lenses, ports = self.problem, level.problem.cameras, level.problem.lenses, level.groups.least
        count, (extra_cost, extra_mass, _) = problem.mission.vehicle.camera_count, problem.extras
        gsd_m = np.max([level.gsd_m(index, rows)[:, 1] for index in range(len(problem.scenes))], axis=0)
        cost = cameras.price[rows.camera] + lenses.price[rows.lens] + ports.price[rows.group]
        mass = cameras.mass_kg[rows.camera] + lenses.mass_kg[rows.lens] + ports.mass_kg[rows.group]
        information = np.full(len(rows), np.inf if self.objective.weight("information") else 0.0)
        return Terms(
            problem.least_camera_power_w(cameras)[rows.camera], count * cost + extra_cost, count * mass + extra_mass,
            np.full(len(rows), snr_ceiling(self.objective)), gsd_m * 1e3, np.ones(len(rows)), information,
        )  # fmt: skip

    # ------------------------------------------------------------ best first

    def search(self, deadline: Deadline) -> bool:
        """Take all that may matter; False when time ran out. Interrupted, it stays as it was before the step."""
        chunk, leaves = FIRST_ROWS, FIRST_LEAVES
        while len(self.open):
            if deadline.passed():
                return False
            before, dear = self.account.snapshot(), max(1, leaves // self._ports_in_a_row)
            depth, some, rest = self.open.next(max(1, chunk // SHARE_OF_GROUPS), chunk, dear)
            last = depth == len(self.levels)
            try:
                if last:
                    if not self._search_leaves(some):
                        return False
                    leaves = min(4 * leaves, LARGEST_LEAVES)
                else:
                    start = time.perf_counter()
                    rest = rest.put(depth + 1, *self._parts_of(depth, some))
                    chunk = min(2 * chunk, LARGEST_ROWS)
                    self.outline_s += time.perf_counter() - start
            except KeyboardInterrupt:
                self.account.restore(before)
                raise
            self.open = rest
        return True

    def open_ideals(self) -> Array:
        """What is not searched yet could be at best, (n, n_objectives)."""
        return self.open.ideals()

    @property
    def _ports_in_a_row(self) -> int:
        """How many ports stand behind a row of the last level, about."""
        return max(1, int(self.levels[-1].groups.size.mean()))

    def _search_leaves(self, block: WaitingRows) -> bool:
        """Search the imagers of rows of the last level; False when time ran out before the end."""
        candidates = self.candidates(self._hopeful(self.levels[-1], block)[0])
        return len(candidates.imagers) == 0 or self.goal.search(candidates)

    def _hopeful(self, level: Level, block: WaitingRows) -> tuple[OutlineRows, Array]:
        """The rows that may still matter, with their ideals; the others are counted."""
        beaten = self.goal.beaten(block.ideals)
        lost = np.flatnonzero(beaten)
        self.account.charge("bound", int(level.imagers_in(block.rows.take(lost)).sum()) * self._sizes)
        self._remember("bound", level, block.rows, lost)
        return block.rows.take(~beaten), block.ideals[~beaten]

    def _parts_of(self, depth: int, block: WaitingRows) -> tuple[OutlineRows, Array]:
        """The parts of the rows of one level that its bounds leave, with what the rows are at best."""
        left, ideals = self._bounded(self.levels[depth], self._hopeful(self.levels[depth], block)[0])
        if depth + 1 == len(self.levels):
            return left, ideals
        row, parts = self._parted(depth, left)
        return parts, ideals[row]

    def _parted(self, depth: int, rows: OutlineRows) -> tuple[Array, OutlineRows]:
        """The same rows split into those of the next level, and of each which it comes from."""
        groups, pairs = self.levels[depth].groups, self.levels[depth].pairs
        if pairs is not None:
            row, camera, lens = pairs.parted(rows.camera, rows.lens, self.levels[depth + 1].pairs)
            return row, OutlineRows(camera, lens, rows.landscape[row], rows.group[row])
        starts = self.levels[depth + 1].groups.start
        first, end = np.searchsorted(starts, groups.start), np.searchsorted(starts, groups.stop)
        row, group = spread(first[rows.group], end[rows.group])
        return row, OutlineRows(rows.camera[row], rows.lens[row], rows.landscape[row], group)

    def _remember(self, rule: str, level: Level, rows: OutlineRows, discarded: Array) -> None:
        """Some of what a rule discards, for an audit: the first imager of each row."""
        self.tally.remember(rule, len(discarded), lambda at: (*level.one_of(rows, int(discarded[at])), None))

    def _bounded(self, level: Level, rows: OutlineRows) -> tuple[OutlineRows, Array]:
        """The rows that may matter, with their ideals; the others are counted by what discards them."""
        account, imagers, size = self.account, level.imagers(rows), level.imagers_in(rows)
        alive = np.ones(len(rows), bool)
        for rule, passes in level.rules(rows, imagers):
            failed = np.nonzero(alive & ~passes)[0]
            account.charge(rule, int(size[failed].sum()) * self.every)
            self._remember(rule, level, rows, failed)
            alive &= passes
        index = np.nonzero(alive)[0]
        if len(index) == 0:
            return rows.take(index), np.empty((0, self.n_ideals))
        own = self.none.bounds
        tables = OutlineTables(level, rows, imagers, self.none.tables)
        bounds = Bounds(self.objective, imagers, tables, lights=own.searched, like=own)
        dark = bounds.leaves_dark(index)
        if dark.any():
            account.charge("light", int(size[index[dark]].sum()) * self._sizes)
            self._remember("light", level, rows, index[dark])
            index = index[~dark]
        best, rules = np.full((len(index), self.n_ideals), np.inf), []
        open_ = np.zeros(len(index), bool)
        for k in range(len(tables.lightings)):
            node = bounds.by_light(k, index)
            able = np.flatnonzero((node.rule < 0) & np.isfinite(node.value))
            ideals = self.goal.ideals(node.terms(able, imagers.gsd_mm[index[able]]))
            matters = ~self.goal.beaten(ideals)
            open_[able[matters]] = True
            best[able[matters]] = np.minimum(best[able[matters]], ideals[matters])
            rules.append(node.rule.astype(np.int8))
        closed = np.nonzero(~open_)[0]
        for k, found in enumerate(rules):
            weights = size[index[closed]] * own.sizes[k]
            for name, mine in by_rule(found[closed]):
                account.charge(name, int(weights[mine].sum()))
                if k == 0:
                    self._remember(name, level, rows, index[closed[mine]])
            account.charge("bound", int(weights[found[closed] < 0].sum()))
        return rows.take(index[open_]), best[open_]

    # ------------------------------------------------------------ imagers

    def candidates(self, rows: OutlineRows) -> Candidates:
        """The imagers behind the ports of these rows that pass all rules."""
        groups, tally = self.levels[-1].groups, Tally(dict.fromkeys(self.account.discarded, 0), self.tally.samples)
        asked = []
        for number in np.unique(rows.group):
            alike = groups.order[groups.start[number] : groups.stop[number]]
            for landscape in self.orientations:
                mine = np.nonzero((rows.group == number) & (rows.landscape == landscape))[0]
                asked.append(Behind(rows.camera[mine], rows.lens[mine], alike, landscape))
        imagers = imagers_in(self.problem, asked, tally)
        for rule, count in tally.discarded.items():
            self.account.charge(rule, count * self.every)
        return self.none.others(replace(imagers, tally=self.tally))
