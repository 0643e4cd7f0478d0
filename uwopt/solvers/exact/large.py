"""The levels above the imagers of a large catalogue: groups of cameras with groups of lenses, behind groups of ports.

Groups are bounded, those that this does not settle are split, and the last of them are leaves: what is left of the
imagers behind their ports is handed to whoever searches.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.problem import Problem
from uwopt.forward.views import CORNERS_REACH, edge_m
from uwopt.model.imaging import FARTHEST
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.exact.account import Account
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.floor_rectangles import Rectangles
from uwopt.solvers.exact.imager_rules import Behind, Tally, limit
from uwopt.solvers.exact.imagers import FittingPairs, Imagers, imagers_in, landscapes
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.node_bounds import by_rule
from uwopt.solvers.exact.oblique import PlaneReach, deepest_m
from uwopt.solvers.exact.outline import Level, OutlineRows, OutlineTables
from uwopt.solvers.exact.pair_groups import PairGroups, every_between
from uwopt.solvers.exact.port_groups import port_tree
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.tree import Goal, Tree
from uwopt.tolerances import COARSE_ROUND

FIRST_LEAVES, LARGEST_LEAVES = 256, 16384  # imagers that are searched together


class PairTree(Tree):
    """Pairs of camera and lens behind groups of ports, and how far they are searched."""

    def __init__(
        self, problem: Problem, objective: Objective, pairs: FittingPairs, goal: Goal, account: Account, *,
        lights: Array | None = None,
    ):  # fmt: skip
        """`account` is charged with what is discarded here; `lights` marks those that are searched."""
        self.problem, self.objective = problem, objective
        ports = port_tree(problem)
        alike, *grouped = (Level(problem, ports[0], groups) for groups in PairGroups.levels(problem, pairs, objective))
        self.alike = alike  # every view that there is, and no other
        self.levels = [*grouped, *(Level(problem, groups) for groups in ports)]
        self.levels.append(self.levels[-1])  # of the leaves
        self.orientations = landscapes(problem)
        tally = Tally(samples=pairs.tally.samples)
        no_imagers = imagers_in(problem, [], tally)
        tables = FieldTables(
            problem, no_imagers, widest_m=[CORNERS_REACH * self._farthest_m(i) for i in range(len(problem.scenes))]
        )
        for index, scene in enumerate(problem.scenes):
            for altitude in {scene.nominal, len(scene.range_m) - 1}:
                tables.set_widest(index, altitude, self._widest(index, altitude))
        none = Bounds(objective, tables, lights=lights)
        self.begin(none, goal, account, tally, depth=len(self.levels) - 1)
        self.leaves, self.most, self.a_leaf = FIRST_LEAVES, LARGEST_LEAVES, max(1, int(ports[-1].size.mean()))
        rows = self._every_row(self.levels[0])
        floors = goal.ideals(self.floor_terms(self.levels[0], rows))
        self.n_ideals = floors.shape[1]
        self.open = self.open.put(0, rows, floors)
        self.charge_imagers(pairs.tally.discarded)

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
        power = problem.least_camera_power_w(cameras)[rows.camera]
        return Terms.at_best(power, count * cost + extra_cost, count * mass + extra_mass, gsd_m * 1e3)

    # ------------------------------------------------------------ levels

    def imagers_in(self, depth: int, rows: OutlineRows) -> Array:
        """As `Tree`."""
        return self.levels[depth].imagers_in(rows)

    def one_of(self, depth: int, rows: OutlineRows, row: int) -> tuple[int, int, int, bool]:
        """As `Tree`."""
        return self.levels[depth].one_of(rows, row)

    def parts_of(self, depth: int, rows: OutlineRows) -> tuple[OutlineRows, Array]:
        """As `Tree`."""
        left, ideals = self._bounded(depth, rows)
        if self.levels[depth + 1] is self.levels[depth]:
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
        row, group = every_between(first[rows.group], end[rows.group])
        return row, OutlineRows(rows.camera[row], rows.lens[row], rows.landscape[row], group)

    def _bounded(self, depth: int, rows: OutlineRows) -> tuple[OutlineRows, Array]:
        """The rows that may matter, with their ideals; the others are counted by what discards them."""
        level, account = self.levels[depth], self.account
        imagers, size = level.imagers(rows), level.imagers_in(rows)
        alive = np.ones(len(rows), bool)
        for rule, passes in level.rules(rows, imagers):
            failed = np.nonzero(alive & ~passes)[0]
            account.charge(rule, int(size[failed].sum()) * self.problem.illuminators)
            self.remember(rule, depth, rows, failed)
            alive &= passes
        index = np.nonzero(alive)[0]
        if len(index) == 0:
            return rows.take(index), np.empty((0, self.n_ideals))
        own = self.bounds
        tables = OutlineTables(level, rows, imagers, own.tables)
        bounds = own.over(tables)
        dark = bounds.leaves_dark(index)
        if dark.any():
            account.charge("light", int(size[index[dark]].sum()) * self.designs)
            self.remember("light", depth, rows, index[dark])
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
                    self.remember(name, depth, rows, index[closed[mine]])
            account.charge("bound", int(weights[found[closed] < 0].sum()))
        return rows.take(index[open_]), best[open_]

    def handed_over(self, rows: OutlineRows) -> tuple[Bounds, Array]:
        """As `Tree`."""
        groups, tally = self.levels[-1].groups, Tally(dict.fromkeys(self.account.discarded, 0), self.tally.samples)
        asked = []
        for number in np.unique(rows.group):
            alike = groups.order[groups.start[number] : groups.stop[number]]
            for landscape in self.orientations:
                mine = np.nonzero((rows.group == number) & (rows.landscape == landscape))[0]
                asked.append(Behind(rows.camera[mine], rows.lens[mine], alike, landscape))
        imagers = imagers_in(self.problem, asked, tally)
        self.charge_imagers(tally.discarded)
        return self.others(imagers), np.arange(len(imagers))

    def others(self, imagers: Imagers) -> Bounds:
        """Some imagers of the catalogue, with a sample of what is discarded here."""
        return self.bounds.others(replace(imagers, tally=self.tally))

    def keeping(self, best: list[Found]) -> tuple[Bounds, list[Found]]:
        """Their own imagers alone."""
        found = imagers_in(self.problem, [one.behind for one in best])
        return self.others(found), [replace(one, imager=place) for place, one in enumerate(best)]
