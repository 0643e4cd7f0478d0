"""The exact search of a large catalogue: pairs of camera and lens are bounded before their ports are tried.

Pairs are taken in order of what they cost without any port or light. Each is bounded behind groups of ports,
the groups are split where the bound does not settle them, and the imagers that are left are searched as those
of a small catalogue, best bound first. Every combination is still counted once, by the rule that discards it.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.views import CORNERS_REACH, edge_m
from uwopt.model.imaging import FARTHEST
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.bounds import NODE_RULES, Bounds
from uwopt.solvers.exact.imagers import (
    SAMPLES,
    FittingPairs,
    Imagers,
    PortBlock,
    imagers_behind,
    joined,
    landscapes,
    limit,
)
from uwopt.solvers.exact.light_tables import FieldTables, Rectangles
from uwopt.solvers.exact.oblique import PlaneReach, deepest_m
from uwopt.solvers.exact.outline import Level, OutlineRows, OutlineTables, port_tree
from uwopt.solvers.exact.ranking import Found, Ranking
from uwopt.solvers.exact.screen import pair_rules
from uwopt.solvers.exact.signals import SignalTables
from uwopt.tolerances import COARSE_ROUND

if TYPE_CHECKING:
    from uwopt.solvers.exact.account import Outcome
    from uwopt.solvers.exact.search import Search

Array = NDArray[Any]
FIRST_PAIRS, LARGEST_PAIRS = 512, 32768  # that are bounded together
MOST_ROWS = 65536  # rows of an outline that are bounded together
MOST_PENDING = 50_000  # imagers that wait for their search
FIRST_LEAVES, LARGEST_LEAVES = 256, 16384  # imagers that are searched together
FIRST_NODES, LARGEST_NODES = 8, 2048  # that are evaluated together once their light is known
MOST_PAIRS = 500_000  # imagers times lights that are bounded together
MOST_SAMPLES = 1024  # discarded imagers remembered per rule, for an audit
TAKEN = 1.0 + 1e-12  # of a threshold: outlines are summed in another order


class LargeSearch:
    """State of one search of a large catalogue, on top of the search that evaluates."""

    def __init__(self, search: Search, pairs: FittingPairs):
        from uwopt.solvers.exact.account import snr_ceiling

        self.search, self.problem, self.pairs = search, search.problem, pairs
        self.snr_ceiling = snr_ceiling(search.objective)
        self.levels = [Level(self.problem, groups) for groups in port_tree(self.problem)]
        self.n_port, self.orientations = len(self.problem.parts.ports), landscapes(self.problem)
        low, high = self.problem.count_range
        self.every = len(self.problem.parts.lights) * (high - low + 1) * len(self.problem.mounts)
        self.pending: list[tuple[OutlineRows, Array]] = []  # imagers with their bounds
        self.samples = pairs.samples
        self.outline_s = 0.0

    # ------------------------------------------------------------ run

    def run(self) -> Outcome:
        """Bound, split, search; see the module's docstring."""
        from uwopt.solvers.exact.account import Outcome

        search, start = self.search, time.perf_counter()
        search.sift = self._sift
        self._start_account()
        self._tabulate()
        lower, complete = self._by_pairs()
        self._keep_winners()
        search.progress(1.0, "done")
        timing = {
            "imagers": self.outline_s, "bounds": search.bounds_s,
            "evaluation": time.perf_counter() - start - self.outline_s - search.bounds_s,
        }  # fmt: skip
        return Outcome(
            search.ranking.best, search.account, lower, complete, search.imagers, search.tables, timing,
            search.interrupted,
        )  # fmt: skip

    def _start_account(self) -> None:
        """Every combination of the parts, and the pairs that do not fit."""
        account, parts = self.search.account, self.problem.parts
        account.total = (
            len(parts.cameras) * len(parts.lenses) * self.n_port * len(self.orientations)
            * len(self.problem.parts.lights) * (self.problem.count_range[1] - self.problem.count_range[0] + 1)
            * len(self.problem.mounts)
        )  # fmt: skip
        for rule, count in self.pairs.discarded.items():
            account.discarded[rule] += count * self.every

    def _tabulate(self) -> None:
        """Tables that reach as far as any image; the lights' tables serve all that is bounded."""
        search, problem = self.search, self.problem
        none = joined(problem, [], {}, self.samples)
        self.like = FieldTables(
            problem, none, widest_m=[CORNERS_REACH * self._farthest_m(i) for i in range(len(problem.scenes))]
        )
        for index, scene in enumerate(problem.scenes):
            for altitude in {scene.nominal, len(scene.range_m) - 1}:
                self.like.set_widest(index, altitude, self._widest(index, altitude))
        self.bounds = Bounds(search.objective, none, self.like, lights=search.only.get("light"), coupled=True)
        search.ranking = Ranking(problem, none, top=search.top, ceiling=search.ceiling)
        self._hand_over(none)

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

    def _hand_over(self, imagers: Imagers) -> None:
        """Make these the imagers that the search evaluates."""
        search, problem = self.search, self.problem
        search.imagers = search.ranking.imagers = imagers
        search.tables = FieldTables(problem, imagers, like=self.like)
        search.bounds = Bounds(
            search.objective, imagers, search.tables, lights=search.only.get("light"), coupled=True,
            like=self.bounds,
        )  # fmt: skip
        search.motorised = problem.lenses.motorised[imagers.lens]
        self.signal_bounds = Bounds(
            search.objective, imagers, SignalTables(problem, imagers, like=self.like),
            lights=search.only.get("light"), coupled=True, like=self.bounds,
        )  # fmt: skip

    # ------------------------------------------------------------ pairs

    def _by_pairs(self) -> tuple[float, bool]:
        """Take pairs in order of what they cost without light, until none can beat the best."""
        search, floor = self.search, self._floors()
        order = np.argsort(floor, kind="stable")
        position, chunk = 0, FIRST_PAIRS
        while position < len(order):
            pairs = order[position : position + chunk]
            if floor[pairs[0]] > search.ranking.threshold() * TAKEN:
                break
            before, waiting = self._snapshot(), list(self.pending)
            try:
                if search.deadline.passed():
                    return self._cut_short(float(floor[pairs[0]]))
                self._outline(pairs)
                position += len(pairs)
                full = sum(len(rows) for rows, _ in self.pending) > MOST_PENDING
                if chunk == FIRST_PAIRS or full or position >= len(order):
                    before, waiting = self._snapshot(), []
                    if not self._search_pending():
                        return self._cut_short(float(floor[order[position:]].min(initial=np.inf)))
            except KeyboardInterrupt:
                search.interrupted = True
                self._restore(before)
                self.pending = waiting or self.pending
                return self._cut_short(float(floor[pairs[0]]))
            chunk = min(2 * chunk, LARGEST_PAIRS)
            search.progress(0.1 + 0.9 * position / len(order), "search")
        self._close_pairs(order[position:])
        before = self._snapshot()
        try:
            finished = self._search_pending()
        except KeyboardInterrupt:
            search.interrupted, finished = True, False
            self._restore(before)
        if not finished:
            return self._cut_short(np.inf)
        best = search.ranking.best[0].minimised if search.ranking.best else search.ceiling
        return min(best, search.open_gap_bound), True

    def _snapshot(self) -> tuple[int, dict[str, int]]:
        return self.search.account.evaluated, dict(self.search.account.discarded)

    def _restore(self, snapshot: tuple[int, dict[str, int]]) -> None:
        self.search.account.evaluated, self.search.account.discarded = snapshot

    def _cut_short(self, lowest: float) -> tuple[float, bool]:
        """Account for what was not reached when time ran out, and the bound that is left."""
        search, account = self.search, self.search.account
        account.discarded.pop("not_reached", None)
        left = account.total - account.evaluated - sum(account.discarded.values())
        account.discarded["not_reached"] = left
        lowest = min([lowest, *(float(value.min(initial=np.inf)) for _, value in self.pending)])
        best = search.ranking.best[0].minimised if search.ranking.best else np.inf
        return min(lowest, best, search.open_gap_bound), False

    def _floors(self) -> Array:
        """What each pair costs at least: no light, the cheapest port, the smallest pixel."""
        problem, pairs, level = self.problem, self.pairs, self.levels[0]
        cameras, lenses, ports = problem.cameras, problem.lenses, problem.ports
        count, (extra_cost, extra_mass, _) = problem.mission.vehicle.camera_count, problem.extras
        gsd_mm = np.full(len(pairs.camera), np.inf)
        for group in range(len(level.groups.start)):
            rows = self._rows(np.arange(len(pairs.camera)), group, landscape=True)
            turned = self._rows(np.arange(len(pairs.camera)), group, landscape=False)
            worst_m = np.max([
                np.minimum(*(level.gsd_m(index, one)[:, 1] for one in (rows, turned)))
                for index in range(len(problem.scenes))
            ], axis=0)  # fmt: skip
            gsd_mm = np.minimum(gsd_mm, worst_m * 1e3)
        cost = cameras.price[pairs.camera] + lenses.price[pairs.lens] + ports.price.min()
        mass = cameras.mass_kg[pairs.camera] + lenses.mass_kg[pairs.lens] + ports.mass_kg.min()
        information = np.inf if self.search.objective.weight("information") else 0.0
        return self.search.objective.cost_to_minimise(
            Terms(
                problem.least_camera_power_w(cameras)[pairs.camera], count * cost + extra_cost,
                count * mass + extra_mass, np.full(len(pairs.camera), self.snr_ceiling), gsd_mm, 1.0, information,
            )
        )  # fmt: skip

    def _close_pairs(self, pairs: Array) -> None:
        """Pairs that cannot beat the best."""
        if len(pairs) == 0:
            return
        sizes = sum(len(table.light) for table in self.bounds.light_tables)
        self.search.account.discarded["bound"] += len(pairs) * self.n_port * len(self.orientations) * sizes
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
            left, value = self._bounded(level, some)
            if len(left) == 0:
                continue
            if depth + 1 < len(self.levels):
                self._descend(depth + 1, self._split(depth, left))
            else:
                self.pending.append((left, value))

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
        """The rows that may hold the best, with their bounds; the others are counted by what discards them."""
        account, objective = self.search.account, self.search.objective
        imagers, size = level.imagers(rows), level.groups.size[rows.group]
        alive = np.ones(len(rows), bool)
        for rule, passes in level.rules(rows, imagers):
            failed = np.nonzero(alive & ~passes)[0]
            account.discarded[rule] += int(size[failed].sum()) * self.every
            self._remember(rule, level, rows, failed)
            alive &= passes
        index = np.nonzero(alive)[0]
        if len(index) == 0:
            return rows.take(index), np.empty(0)
        tables = OutlineTables(level, rows, imagers, self.like)
        bounds = Bounds(
            objective, imagers, tables, lights=self.search.only.get("light"), coupled=True,
            like=self.bounds,
        )  # fmt: skip
        value, rules = np.full(len(index), np.inf), []
        for k in range(len(tables.lightings)):
            node = bounds.of_nodes(k, index)
            value = np.minimum(value, np.where(node.rule >= 0, np.inf, node.value))
            rules.append(node.rule.astype(np.int8))
        open_ = np.isfinite(value) & (value <= self.search.ranking.threshold() * TAKEN)
        closed = np.nonzero(~open_)[0]
        for k, found in enumerate(rules):
            lights = len(self.bounds.light_tables[k].light)
            weights = size[index[closed]] * lights
            for number, name in enumerate(NODE_RULES):
                mine = found[closed] == number
                account.discarded[name] += int(weights[mine].sum())
                if k == 0:
                    self._remember(name, level, rows, index[closed[mine]])
            account.discarded["bound"] += int(weights[found[closed] < 0].sum())
        return rows.take(index[open_]), value[open_]

    # ------------------------------------------------------------ imagers

    def _search_pending(self) -> bool:
        """Search the imagers that wait, best bound first; False when time ran out before the end."""
        if not self.pending:
            return True
        search, level = self.search, self.levels[-1]
        rows = OutlineRows.joined([rows for rows, _ in self.pending])
        value = np.concatenate([value for _, value in self.pending])
        order = np.argsort(value, kind="stable")
        rows, value = rows.take(order), value[order]
        sizes = sum(len(table.light) for table in self.bounds.light_tables)
        position, batch = 0, FIRST_LEAVES
        each = max(1, int(level.groups.size.mean()))  # ports behind a row
        while position < len(rows):
            self.pending = [(rows.take(np.arange(position, len(rows))), value[position:])]
            ahead = np.arange(position, min(position + max(1, batch // each), len(rows)))
            if value[position] > search.ranking.threshold() * TAKEN:
                rest = np.arange(position, len(rows))
                search.account.discarded["bound"] += int(level.groups.size[rows.group[rest]].sum()) * sizes
                self._remember("bound", level, rows, rest)
                break
            before = self._snapshot()
            try:
                finished = self._search_imagers(rows.take(ahead))
            except KeyboardInterrupt:
                self._restore(before)
                raise
            if not finished:
                return False
            position += len(ahead)
            batch = min(4 * batch, LARGEST_LEAVES)
        self.pending = []
        return True

    def _search_imagers(self, rows: OutlineRows) -> bool:
        """Search these imagers as those of a small catalogue; False when time ran out."""
        search = self.search
        blocks: list[PortBlock] = []
        groups = self.levels[-1].groups
        discarded = dict.fromkeys(search.account.discarded, 0)
        for number in np.unique(rows.group):
            alike = groups.order[groups.start[number] : groups.stop[number]]
            for landscape in self.orientations:
                mine = np.nonzero((rows.group == number) & (rows.landscape == landscape))[0]
                blocks += list(imagers_behind(
                    self.problem, rows.camera[mine], rows.lens[mine], alike, landscape, discarded, self.samples
                ))  # fmt: skip
        for rule, count in discarded.items():
            search.account.discarded[rule] += count * self.every
        imagers = joined(self.problem, blocks, {}, self.samples)
        if len(imagers) == 0:
            return True
        self._hand_over(imagers)
        left = search._best_first(np.arange(len(imagers)))
        return left is None

    def _sift(self, lighting_index: Array, imager: Array) -> None:
        """Evaluate the nodes that may still be best when their light is known, best first; count the others."""
        search, account = self.search, self.search.account
        value = np.full(len(imager), np.inf)
        for k in np.unique(lighting_index):
            every = np.nonzero(lighting_index == k)[0]
            step = max(1, MOST_PAIRS // len(self.bounds.light_tables[k].light))
            for mine in (every[start : start + step] for start in range(0, len(every), step)):
                node = self.signal_bounds.of_nodes(int(k), imager[mine])
                limit_value = search.ranking.threshold() * TAKEN
                rule, value[mine] = pair_rules(self.signal_bounds, int(k), imager[mine], node, limit_value)
                closed = ~np.isfinite(value[mine])
                lost, rows = rule[closed], imager[mine[closed]]
                for number, name in enumerate(NODE_RULES):
                    account.discarded[name] += int((lost == number).sum())
                    nodes = np.nonzero((lost == number).any(axis=1))[0]
                    search._sample(name, int(k) * len(rows) + nodes, rows)
                account.discarded["bound"] += int((lost < 0).sum())  # what the node's own bound discards
        sizes = np.array([len(table.light) for table in self.bounds.light_tables])
        order = np.argsort(value, kind="stable")
        order = order[np.isfinite(value[order])]
        position, batch = 0, FIRST_NODES
        while position < len(order):
            ahead = order[position : position + batch]
            useful = ahead[value[ahead] <= search.ranking.threshold() * TAKEN]
            account.discarded["bound"] += int(sizes[lighting_index[ahead]].sum())
            account.discarded["bound"] -= int(sizes[lighting_index[useful]].sum())
            search.evaluate_nodes(lighting_index[useful], imager[useful])
            position += len(ahead)
            batch = min(4 * batch, LARGEST_NODES)

    def _keep_winners(self) -> None:
        """Leave the search with the imagers of the best designs alone."""
        search = self.search
        blocks: list[PortBlock] = []
        places: list[Found] = []
        for found in search.ranking.best:
            one = imagers_behind(
                self.problem, np.array([found.camera]), np.array([found.lens]), np.array([found.port]), found.landscape,
                dict.fromkeys(search.account.discarded, 0), {},
            )  # fmt: skip
            places.append(replace(found, imager=len(blocks)))
            blocks += list(one)
        search.ranking.best = places
        self._hand_over(joined(self.problem, blocks, {}, self.samples))
