"""The exact search: best design of a catalogue with a proof that nothing better is in it.

Designs are imagers under a lighting (light optics at a mount) with a number of lamps of one light.
Every (imager, lighting) is a node with a lower bound on the objective; nodes are taken best first,
their signal is computed exactly, their lights and counts are solved in closed form, and the search
stops when no bound beats the best. Each combination is counted once, by the first rule that discards
it, so that the account adds up.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.deadline import NEVER, Deadline, OutOfTimeError, UntilFound
from uwopt.forward.columns import rows_alike
from uwopt.forward.floor_light import even_enough
from uwopt.forward.lamp_light import LIKELY_PLACES, ImageLight, SunLight, Veils
from uwopt.forward.lamp_views import keeps_clear, lamps_refused
from uwopt.forward.problem import Problem
from uwopt.forward.remembered import RememberedSunField
from uwopt.forward.scene import Pixels
from uwopt.forward.setting_rows import SceneRows, of_darkest_pixels, setting_rows
from uwopt.forward.sharpness import SharpRows, sharpness_of
from uwopt.forward.sun_light import sun_light
from uwopt.model.image_mean import FRAME_MAY_MISS
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.exact.account import Account, Outcome, Sample, snr_ceiling
from uwopt.solvers.exact.bounds import NODE_RULES, Bounds, LampChoices, NodeBounds
from uwopt.solvers.exact.imagers import (
    FittingPairs,
    Imagers,
    enumerate_imagers,
    fitting_pairs,
    landscapes,
    limit,
)
from uwopt.solvers.exact.light_tables import FieldTables, Lighting
from uwopt.solvers.exact.ranking import Ranking
from uwopt.solvers.settings.best import GAP, best_settings
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.mean_limit import MeanLimit
from uwopt.tolerances import ROUND, SLACK

Array = NDArray[Any]

FIRST_BATCH, LARGEST_BATCH = 32, 2048
LARGEST_COSTLY = 256  # where each node takes light at pixels: the next batch then knows what this one found
DEAR_REFINED, CHEAP_REFINED = 256, 2048  # at least, where bounds weigh quality: each call sorts all nodes anew
REFINED_AHEAD = 8  # batches of nodes whose bounds are made better before the first of them is taken
FIRST_DEAR = 4  # of a first batch where one may be enough, or where information counts: dear to bound while nothing is
# found that others must beat
FIRST_CHUNK = 400_000  # imagers times lightings that are bounded first: cheaper than to evaluate the wrong ones
LARGEST_CHUNK = 65536  # imagers that are bounded together
MOST_IMAGERS = 600_000  # beyond which pairs of camera and lens are bounded before their ports
MOST_UNITS = 6_000_000  # imagers times lightings: what memory allows
SAMPLES_A_TIME, MOST_SAMPLES = 64, 1024
MOST_ROWS_AT_ONCE = 60_000
FIRST_VEILS, LARGEST_VEILS = 8, 256  # imagers whose veils are worked out together
ROUGH_GAP = 1e-2  # of bounds over settings that are searched cell by cell
TOO_FEW_TO_BOUND = 8  # nodes: evaluating them is cheaper
Sift = Callable[
    [Array, Array], None
]  # evaluates nodes, given by lighting and imager, as far as they are worth it


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


def are_too_many(problem: Problem, pairs: FittingPairs) -> bool:
    """Whether pairs of camera and lens are bounded before their ports."""
    return len(pairs.camera) * len(problem.port_groups) * len(landscapes(problem)) > MOST_IMAGERS


class Search:
    """State of one search."""

    def __init__(
        self, problem: Problem, objective: Objective, *, top: int, deadline: Deadline = NEVER,
        progress: Callable[[float, str], None] | None = None, ceiling: float = np.inf,
        only: Mapping[str, Array] | None = None, imagers: Imagers | None = None, enough: bool = False,
    ):  # fmt: skip
        """`imagers`: those to search, of all that there are; `enough`: one design that fits, whichever."""
        self.given, self.enough = imagers, enough
        self.only = only or {}  # camera, light: masks of the parts to search; the others count as bounded
        self.ceiling = ceiling  # designs that are no better than this are not wanted
        self.problem, self.objective, self.top = problem, objective, max(1, top)
        self.deadline = UntilFound.of(deadline, lambda: bool(self.ranking.best)) if enough else deadline
        self.progress = progress or (lambda share, what: None)
        self.account = Account()
        self.limits = problem.mission.limits
        self.bounds_s = 0.0
        self.interrupted = False
        self.sift: Sift | None = None
        self.open_gap_bound = np.inf  # below which no settings get, where they are not optimal to rounding
        self._samples: dict[str, list[Sample]] = {}
        self._waiting: list[Waiting] = []
        self._patient = False  # designs wait while others have lower bounds

    # ------------------------------------------------------------ run

    def run(self) -> Outcome:
        """Enumerate, bound, evaluate best first."""
        start = time.perf_counter()
        self.progress(0.0, "imagers")
        pairs = None if self.given is not None else fitting_pairs(self.problem, cameras=self._cameras_below_ceiling())
        if pairs is not None and are_too_many(self.problem, pairs):
            from uwopt.solvers.exact.large import (
                LargeSearch,  # a search of its own, of no use to small catalogues
            )

            return LargeSearch(self, pairs).run()
        imagers = self.prepare()
        self._start_account(imagers)
        after_imagers = time.perf_counter()
        lower, complete = self._by_floor()
        self.progress(1.0, "done")
        timing = {
            "imagers": after_imagers - start,
            "bounds": self.bounds_s,
            "evaluation": time.perf_counter() - after_imagers - self.bounds_s,
        }
        return Outcome(
            self.ranking.best, self.account, lower, complete, imagers, self.tables, timing, self.interrupted
        )

    def prepare(self) -> Imagers:
        """Enumerate imagers and tabulate lights: all that evaluation needs."""
        imagers = self.imagers = (
            enumerate_imagers(self.problem, cameras=self._cameras_below_ceiling()) if self.given is None else self.given
        )
        self.tables = FieldTables(self.problem, imagers)
        self.bounds = Bounds(self.objective, imagers, self.tables, lights=self.only.get("light"))
        self.ranking = Ranking(self.problem, imagers, top=self.top, ceiling=self.ceiling)
        self.motorised = self.problem.lenses.motorised[imagers.lens] if len(imagers) else np.empty(0, bool)
        return imagers

    def _cameras_below_ceiling(self) -> Array:
        """Cameras that are not beyond the ceiling by themselves."""
        rows, count = self.problem.cameras, self.problem.mission.vehicle.camera_count
        extra_cost, extra_mass, _ = self.problem.extras
        floor = self.objective.cost_to_minimise(
            Terms(
                self.problem.least_camera_power_w(rows), count * rows.price + extra_cost,
                count * rows.mass_kg + extra_mass,
                np.full(len(rows.price), snr_ceiling(self.objective)), np.zeros(len(rows.price)), 1.0, np.inf,
            )
        )  # fmt: skip
        return np.asarray(floor <= self.ceiling) & self.only.get("camera", True)

    def _start_account(self, imagers: Imagers) -> None:
        """Every combination of the parts in the search, and what the imagers' rules discard."""
        problem = self.problem
        low, high = problem.count_range
        illuminators = len(problem.parts.lights) * (high - low + 1) * len(problem.mounts)
        for rule, count in imagers.discarded.items():
            self.account.discarded[rule] += count * illuminators
        self.account.total = (len(imagers) + sum(imagers.discarded.values())) * illuminators

    # ------------------------------------------------------------ best first

    def _by_floor(self) -> tuple[float, bool]:
        """Take imagers in order of what they cost without any light, until none can beat the best."""
        imagers = self.imagers
        ceiling = np.full(len(imagers), snr_ceiling(self.objective))
        floor = self.objective.cost_to_minimise(
            Terms(
                imagers.camera_power_w, imagers.cost, imagers.mass_kg, ceiling, imagers.gsd_mm, 1.0,
                self.bounds.information_ceiling(np.arange(len(imagers))),
            )
        )  # fmt: skip
        order = np.argsort(floor, kind="stable")
        every = int(sum(len(t.light) for t in self.bounds.light_tables))
        lightings = max(1, len(self.tables.lightings))
        most = max(64, MOST_UNITS // lightings)
        position, chunk = 0, min(max(1, FIRST_CHUNK // lightings), LARGEST_CHUNK, most)
        while position < len(order):
            rows = order[position : position + chunk]
            useful = rows[floor[rows] <= self.ranking.threshold()]
            self.account.discarded["bound"] += every * (len(rows) - len(useful))
            self._sample("bound", np.nonzero(floor[rows] > self.ranking.threshold())[0], rows, any_light=True)
            if len(useful):
                before = (self.account.evaluated, dict(self.account.discarded))
                try:
                    finished = self._best_first(useful)
                except KeyboardInterrupt:  # keep what was found; these imagers count as not reached
                    self.interrupted, self._waiting = True, []
                    self.account.evaluated, self.account.discarded = before
                    self.account.discarded["not_reached"] = every * len(useful)
                    finished = float(floor[useful].min())
                if finished is not None:
                    return self._cut_short(finished, every, floor, order[position + len(rows) :])
            position += len(rows)
            chunk = min(2 * chunk, LARGEST_CHUNK, most)
            self.progress(0.1 + 0.9 * position / len(order), "search")
        return min(
            self.ranking.best[0].minimised if self.ranking.best else self.ceiling, self.open_gap_bound
        ), True

    def _cut_short(self, lowest: float, every: int, floor: Array, rest: Array) -> tuple[float, bool]:
        """Account for what was not reached when time ran out, and the bound that is left."""
        reached = self.account.discarded.get("not_reached", 0)
        self.account.discarded["not_reached"] = reached + every * len(rest)
        lowest = min(lowest, float(floor[rest].min(initial=np.inf)))
        best = self.ranking.best[0].minimised if self.ranking.best else np.inf
        return min(lowest, best, self.open_gap_bound), False

    def _best_first(self, rows: Array) -> float | None:
        """Take the nodes of these imagers in order of their bound until none can beat the best.

        Returns the lowest bound not looked at when time ran out, else None.
        """
        start = time.perf_counter()
        few = len(rows) * len(self.tables.lightings) <= TOO_FEW_TO_BOUND
        bounds = [
            NodeBounds.none(len(rows)) if few else self.bounds.of_nodes(k, rows)
            for k in range(len(self.tables.lightings))
        ]
        self.bounds_s += time.perf_counter() - start
        if not bounds:
            return None
        n = len(rows)
        value = np.concatenate([b.value for b in bounds])
        power = np.concatenate([b.power for b in bounds])
        rule = np.concatenate([b.rule for b in bounds])
        size = np.repeat([len(t.light) for t in self.bounds.light_tables], n)
        for index, name in enumerate(NODE_RULES):
            failed = rule == index
            self.account.discarded[name] += int(size[failed].sum())
            self._sample(name, np.nonzero(failed)[0], rows)
        alive = np.nonzero(np.isfinite(value) & (rule < 0))[0]
        cost = self.imagers.cost[rows]
        order = alive[np.lexsort((cost[alive % n], power[alive], value[alive]))]
        position, batch = 0, FIRST_DEAR if self.enough or self.objective.weight("information") else FIRST_BATCH
        rough = np.full(len(value), not few and self.sift is None and self.bounds.can_refine())
        largest = LARGEST_COSTLY if rough.any() else LARGEST_BATCH
        self._patient = self.sift is None and self.bounds.weighs_quality()
        least_look = 0
        if self._patient:
            least_look = DEAR_REFINED if self.bounds.asks_of_images() else CHEAP_REFINED
        look = max(least_look, REFINED_AHEAD * batch)
        while position < len(order):
            if self._waiting:
                try:
                    self._solve_waiting(float(value[order[position]]))
                except OutOfTimeError:
                    return min(self._none_left(order[position:], value, size), self._not_reached())
            threshold = self.ranking.threshold()
            if rough[order[position]] and value[order[position]] <= threshold:
                ahead = order[position : position + look]
                ahead = ahead[rough[ahead] & (value[ahead] <= threshold)]
                try:
                    self._refine(ahead, rows, value, power, size)
                except OutOfTimeError:
                    return min(self._none_left(order[position:], value, size), self._not_reached())
                rough[ahead] = False
                rest = order[position:]
                rest = rest[np.isfinite(value[rest])]
                order = rest[np.lexsort((cost[rest % n], power[rest], value[rest]))]
                position, look = 0, 2 * look  # while nothing comes to the front that can be evaluated
                continue
            ahead = order[position : position + batch]
            ahead = ahead[np.logical_and.accumulate(~rough[ahead])]
            ahead = ahead[value[ahead] <= threshold]
            if len(ahead) == 0:
                break
            useful = ahead[~self.ranking.shut_out(value[ahead], power[ahead], cost[ahead % n])]
            before, waited = (self.account.evaluated, dict(self.account.discarded)), list(self._waiting)
            self.account.discarded["bound"] += int(size[ahead].sum() - size[useful].sum())
            try:
                self.deadline.check()
                if len(useful):
                    (self.sift or self.evaluate_nodes)(useful // n, rows[useful % n])
            except OutOfTimeError:  # what was found of this batch stays; the batch counts as not reached
                (self.account.evaluated, self.account.discarded), self._waiting = before, waited
                return min(self._none_left(order[position:], value, size), self._not_reached())
            position += len(ahead)
            batch = min(2 * batch, largest)
            look = max(least_look, REFINED_AHEAD * batch)
        try:
            self._solve_waiting()
        except OutOfTimeError:
            return min(self._none_left(order[position:], value, size), self._not_reached())
        self.account.discarded["bound"] += int(size[order[position:]].sum())
        self._sample("bound", order[position:], rows)
        return None

    def _none_left(self, rest: Array, value: Array, size: Array) -> float:
        """Count nodes as not reached, as time is over; the least of their bounds."""
        rest = rest[np.isfinite(value[rest])]
        self.account.discarded["not_reached"] = int(size[rest].sum())
        return float(value[rest].min(initial=np.inf))

    def _refine(self, nodes: Array, rows: Array, value: Array, power: Array, size: Array) -> None:
        """Bounds of these nodes by pixels and settings, in place; inf, and accounted for, where a rule discards one.

        Raises OutOfTimeError, with the bounds that are done in place: those left stay as valid as they were.
        """
        n = len(rows)
        for k in np.unique(nodes // n):
            self.deadline.check()
            mine = nodes[nodes // n == k]
            bounds = self.bounds.refined(int(k), rows[mine % n])
            value[mine], power[mine] = np.maximum(value[mine], bounds.value), np.maximum(power[mine], bounds.power)
            for index, name in enumerate(NODE_RULES):
                failed = mine[bounds.rule == index]
                value[failed] = np.inf
                self.account.discarded[name] += int(size[failed].sum())
                self._sample(name, failed, rows)

    def _sample(self, rule: str, nodes: Array, rows: Array, *, any_light: bool = False) -> None:
        """Remember some of the nodes that a rule discards, evenly spread, for an audit."""
        kept = self._samples.setdefault(rule, [])
        if len(nodes) and len(kept) < MOST_SAMPLES:
            step = max(1, len(nodes) // SAMPLES_A_TIME)
            n = len(rows)
            some = nodes[::step][: 2 * SAMPLES_A_TIME]
            kept += [self.imagers.sample(int(rows[u % n]), None if any_light else int(u // n)) for u in some]

    def discarded_samples(
        self, count: int, rng: np.random.Generator
    ) -> dict[str, list[tuple[int, int, int, bool, int | None]]]:
        """Combinations that each rule discarded, as (camera, lens, port, landscape, light or None for any)."""
        imagers = self.imagers
        pools: dict[str, list[tuple[int, int, int, bool, int | None]]] = {
            rule: [(c, le, p, o, None) for c, le, p, o in samples]
            for rule, samples in imagers.samples.items()
        }
        for rule, nodes in self._samples.items():
            pool = pools.setdefault(rule, [])
            for place in rng.permutation(len(nodes))[: max(count, 1)]:
                camera, lens, port, landscape, k = nodes[int(place)]
                lights = None if k is None else self.bounds.light_tables[k].light
                if lights is None or len(lights):  # a table of no lights holds no combination
                    light = None if lights is None else int(rng.choice(lights))
                    pool.append((camera, lens, port, landscape, light))
        return pools

    # ------------------------------------------------------------ evaluation

    def evaluate_nodes(self, lighting_index: Array, imager: Array) -> None:
        """Exact signal of these nodes, then all their lights and counts; the lighting of the first node first."""
        keys, first = np.unique(lighting_index, return_index=True)
        for k in keys[np.argsort(first)]:
            rows = imager[lighting_index == k]
            lighting, table = self.tables.lightings[k], self.bounds.light_tables[k]
            lights = [
                self.tables.exact(s, lighting, rows, veils="none", deadline=self.deadline)
                for s in range(len(self.problem.scenes))
            ]
            step = max(1, MOST_ROWS_AT_ONCE // max(1, len(table.light)))
            for start in range(0, len(rows), step):
                part = np.arange(start, min(start + step, len(rows)))
                self._evaluate_pairs(rows[part], [light.take(part) for light in lights], lighting, table)

    def _evaluate_pairs(
        self, imager: Array, lights: list[ImageLight], lighting: Lighting, table: LampChoices
    ) -> None:
        """Every (imager, light, count): drop what misses a limit or cannot win, solve the rest."""
        n_light = len(table.light)
        node = np.repeat(np.arange(len(imager)), n_light)
        item = np.tile(np.arange(n_light), len(imager))
        imagers, limits = self.imagers, self.limits
        cost = imagers.cost[imager[node]] + table.cost[item]
        mass = imagers.mass_kg[imager[node]] + table.mass_kg[item]
        rule = np.full(len(node), -1)
        limit_cost = imagers.limit_cost[imager[node]] + table.limit_cost[item]
        rule = np.where(limit_cost > limit(limits.cost) * ROUND, NODE_RULES.index("cost"), rule)
        rule = np.where(
            (rule < 0) & (mass > limit(limits.mass_kg) * ROUND), NODE_RULES.index("mass_kg"), rule
        )
        floor = self.objective.cost_to_minimise(
            Terms(
                imagers.camera_power_w[imager[node]], cost, mass, np.full(len(node), snr_ceiling(self.objective)),
                imagers.gsd_mm[imager[node]], 1.0, self.bounds.information_ceiling(imager)[node],
            )
        )  # fmt: skip
        beaten = self.ranking.shut_out(floor, imagers.camera_power_w[imager[node]], cost, mass)
        rule = np.where((rule < 0) & beaten, NODE_RULES.index("bound"), rule)
        for index, name in enumerate(NODE_RULES):
            self.account.discarded[name] += int((rule == index).sum())
        keep = np.nonzero(rule < 0)[0]
        self.account.evaluated += len(keep)
        if len(keep):
            pairs = NodeDesigns(
                imager, node[keep], table.light[item[keep]], table.count[item[keep]], cost[keep], mass[keep]
            )
            self._solve_pairs(pairs, lights, lighting)

    def _solve_pairs(self, pairs: NodeDesigns, lights: list[ImageLight], lighting: Lighting) -> None:
        """Settings of these designs, and their place among the best.

        Where there are veils, pixels or other integrals over the image, designs are bounded first as if there were
        no veil and as if few pixels counted; the integrals are worked out for those that may still win, best bound
        first.
        """
        veiled = self.problem.effects.veils
        if not veiled and not any(self._asks_of_image(index) for index in range(len(lights))):
            self._rank(pairs, [light.take(pairs.node) for light in lights], lighting)
            return
        if any(self.bounds.is_sunlit(index) for index in range(len(lights))):  # bounds of settings cost more than rules
            pairs = pairs.take(np.nonzero(self._keeps_rules(pairs, lighting))[0])
            if len(pairs.node) == 0:
                return
        found, bound = 0, np.full(len(pairs.node), -np.inf)
        stages = self._stages()
        for stage in stages:
            if stage in ("forward", "coarse"):
                lights = self._with_veils(pairs.imager, lights, lighting, stage)
            bound = np.maximum(bound, self._bound(pairs, lights, lighting, stage, closed_alone=stage != stages[-1]))
            found = found or int(np.isfinite(bound).sum())
            kept = np.nonzero(np.isfinite(bound) & ~self._beaten(pairs, bound))[0]
            if len(kept) == 0:
                break
            used, back = np.unique(pairs.node[kept], return_inverse=True)
            lights = [light.take(used) for light in lights]
            pairs = replace(pairs.take(kept), imager=pairs.imager[used], node=back.reshape(-1))
            bound = bound[kept]
        solved = 0
        if self._patient and len(kept):  # other nodes may hold better bounds
            self._waiting.append(Waiting.of(pairs, bound, lights, lighting))
        elif len(kept):
            solved = self._solve_best_first(pairs, bound, lights, lighting)
        self.account.evaluated -= found - solved
        self.account.discarded["bound"] += found - solved

    def _beaten(self, pairs: NodeDesigns, bound: Array) -> Array:
        """Which of these designs, by lower bounds of their objective, get no place among the best."""
        power, weight = self.imagers.camera_power_w[pairs.imager[pairs.node]], self.objective.weight("power")
        if self.objective.single == "power" and weight:
            power = np.maximum(power, bound / weight * (1.0 - 10.0 * SLACK))
        return self.ranking.shut_out(bound, power, pairs.cost, pairs.mass_kg)

    def _stages(self) -> tuple[Veils, ...]:
        """What designs are bounded by, in turn; each costs more than the one before."""
        if not self.problem.effects.veils:
            return ("none",)
        scenes = enumerate(self.problem.scenes)
        veiled = any(s.pixels is not None and s.scatters and not self.bounds.is_sunlit(i) for i, s in scenes)
        return ("none", "forward", "coarse", "likely") if veiled else ("none", "forward", "coarse")

    def _bound(
        self, pairs: NodeDesigns, lights: list[ImageLight], lighting: Lighting, stage: Veils, *, closed_alone: bool
    ) -> Array:
        """Lower bounds on the objective from the light known so far; inf: infeasible with any veil."""
        seen = [light.take(pairs.node) for light in lights]
        return self.solve(pairs, seen, lighting, optimistic=True, stage=stage, closed_alone=closed_alone)[0]

    def _with_veils(
        self, imager: Array, lights: list[ImageLight], lighting: Lighting, veils: Veils
    ) -> list[ImageLight]:
        """Further veils beside the light that is known, by scene; raises OutOfTimeError past the deadline."""
        self.deadline.check()
        return [
            self.tables.exact(s, lighting, imager, known=light, veils=veils, deadline=self.deadline)
            for s, light in enumerate(lights)
        ]

    def _solve_best_first(
        self, pairs: NodeDesigns, bound: Array, lights: list[ImageLight], lighting: Lighting
    ) -> int:
        """Designs that may win, best bound first, with all their veils; how many were solved."""
        order = np.lexsort((pairs.cost, bound))
        nodes, first = np.unique(pairs.node[order], return_index=True)
        order = nodes[np.argsort(first)]  # nodes by the best of their designs
        batch, solved = FIRST_VEILS, 0
        while len(order):
            left = ~self._beaten(pairs, bound)
            order = order[np.isin(order, pairs.node[left])]
            nodes, order = order[:batch], order[batch:]
            some = pairs.take(np.flatnonzero(left & np.isin(pairs.node, nodes)))
            solved += len(some.node)
            some = some.take(np.nonzero(self._keeps_rules(some, lighting))[0])
            if len(some.node):
                nodes, place = np.unique(some.node, return_inverse=True)
                full = self._with_veils(
                    pairs.imager[nodes], [light.take(nodes) for light in lights], lighting, "all"
                )
                self._rank(some, [light.take(place) for light in full], lighting)
            batch = min(2 * batch, LARGEST_VEILS)
        return solved

    def _solve_waiting(self, until: float = np.inf) -> None:
        """Solve what waits with all its veils, best bound first, as far as it may win and nothing else has less."""
        while self._waiting:
            first = min(self._waiting, key=lambda group: group.lowest)
            most = min(until, self.ranking.threshold())
            if first.lowest > most:
                break
            self.deadline.check()
            nodes, group = first.taken(most)
            some = first.pairs.take(np.isin(first.pairs.node, nodes) & (first.bound <= self.ranking.threshold()))
            n_solved = len(some.node)
            some = some.take(np.nonzero(self._keeps_rules(some, first.lighting))[0])
            if n_solved and len(some.node):
                used, place = np.unique(some.node, return_inverse=True)
                lights = [light.take(used) for light in first.lights]
                full = self._with_veils(first.pairs.imager[used], lights, first.lighting, "all")
                self._rank(some, [light.take(place) for light in full], first.lighting)
            self.account.evaluated += n_solved
            self.account.discarded["bound"] -= n_solved
            rest = [other for other in self._waiting if other is not first]
            self._waiting = [*rest, *([group] if np.isfinite(group.lowest) else [])]
        threshold = self.ranking.threshold()
        self._waiting = [group for group in self._waiting if group.lowest <= threshold]

    def _not_reached(self) -> float:
        """Count what waits as not reached, as time is over; the least of its bounds."""
        lowest, threshold = np.inf, self.ranking.threshold()
        for group in self._waiting:
            left = group.left() & (group.bound <= threshold)
            self.account.discarded["bound"] -= int(left.sum())
            self.account.discarded["not_reached"] = self.account.discarded.get("not_reached", 0) + int(left.sum())
            lowest = min(lowest, group.lowest)
        self._waiting = []
        return lowest

    def _rank(self, pairs: NodeDesigns, lights: list[ImageLight], lighting: Lighting) -> None:
        """Solve these designs and put them in their place among the best."""
        solved = self.solve(pairs, lights, lighting)
        self.ranking.add(pairs.imager[pairs.node], pairs.light, pairs.count, lighting, *solved)

    def solve(
        self, pairs: NodeDesigns, lights: list[ImageLight], lighting: Lighting, *, optimistic: bool = False,
        stage: Veils = "none", closed_alone: bool = False,
    ) -> tuple[Array, Terms, list[Chosen], list[Array]]:  # fmt: skip
        """Objective (inf where infeasible), its terms, settings and exposures of these designs.

        `optimistic`: lower bounds for any veil that the lights may have, at this stage; `closed_alone` as in
        `best_settings`. Raises OutOfTimeError past the deadline.
        """
        self.deadline.check()
        imager, cost, mass = pairs.imager[pairs.node], pairs.cost, pairs.mass_kg
        rows = self.rows(imager, lights, pairs.light, pairs.count, lighting, optimistic=optimistic, stage=stage)
        motorised = self.motorised[imager]
        camera_power = self.imagers.camera_power_w[imager]
        fixed = Terms(camera_power, cost, mass, np.zeros(len(imager)), self.imagers.gsd_mm[imager])
        hardware = rows_alike(imager, pairs.light)[1]
        best = best_settings(
            rows, motorised, self.objective, camera_power, self.problem.scene_power_limit_w,
            gap_rel=ROUGH_GAP if optimistic else GAP, constant=self.objective.constant(fixed),
            cutoff=self.ranking.threshold(), hardware=hardware, top=None if optimistic else self.top,
            mean_limit=MeanLimit.of(self.problem), closed_alone=closed_alone,
        )  # fmt: skip
        chosen = best.chosen
        power = camera_power + np.max([c.light_power_w for c in chosen], axis=0)
        feasible = best.feasible & (power <= self.problem.scene_power_limit_w * ROUND)
        if best.lower_bound is not None and not optimistic:
            open_ = np.isfinite(best.lower_bound) & ~feasible & (best.lower_bound <= self.ranking.threshold())
            hopeless = self._draw_too_much(rows, motorised, camera_power, np.flatnonzero(open_))
            best = replace(best, lower_bound=np.where(hopeless, np.inf, best.lower_bound))
        terms = Terms(
            power, cost, mass, best.snr_db, self.imagers.gsd_mm[imager], best.contrast, best.information
        )
        with np.errstate(invalid="ignore"):
            value = self.objective.cost_to_minimise(terms)
        value = np.where(feasible & np.isfinite(value), value, np.inf)
        exposure = [
            r.exposure_s(c.time_s) if c.exposure_s is None else c.exposure_s
            for r, c in zip(rows, chosen, strict=True)
        ]
        if best.lower_bound is not None:
            if optimistic:
                return best.lower_bound, terms, chosen, exposure
            self.open_gap_bound = min(self.open_gap_bound, float(best.lower_bound.min(initial=np.inf)))
        return value, terms, chosen, exposure

    def _draw_too_much(
        self, rows: list[SceneRows], motorised: Array, camera_power_w: Array, which: Array
    ) -> Array:
        """Which of some designs draw more than the limit at any settings, by a bound of their power alone, (n,)."""
        hopeless, limit_w = np.zeros(len(motorised), bool), self.problem.scene_power_limit_w
        if len(which) and np.isfinite(limit_w):
            least = best_settings(
                [r.take(which) for r in rows], motorised[which], Objective.of("power"), camera_power_w[which], limit_w,
                constant=camera_power_w[which], cutoff=limit_w * ROUND, mean_limit=MeanLimit.of(self.problem),
            )  # fmt: skip
            if least.lower_bound is None:  # the least itself
                least_w = camera_power_w[which] + np.max([c.light_power_w for c in least.chosen], axis=0)
                hopeless[which] = least.feasible & (least_w > limit_w * ROUND)
            else:
                hopeless[which] = least.lower_bound > limit_w * ROUND
        return hopeless

    def rows(
        self, imager: Array, lights: list[ImageLight], light: Array, count: Array, lighting: Lighting, *,
        optimistic: bool = False, stage: Veils = "none", with_rules: bool = True,
    ) -> list[SceneRows]:  # fmt: skip
        """The settings' view of these designs, by scene; `with_rules`: none for what no setting mends."""
        result = []
        for index, seen in enumerate(lights):
            pixels = self.problem.scenes[index].pixels
            unlit = optimistic and pixels == "frame" and self.bounds.is_sunlit(index) and self._are_unlit(light)
            if unlit:  # the sun alone says which pixels are dark
                likely = np.repeat(seen.signal_e[:, :, None], LIKELY_PLACES, axis=2)
                seen = seen.with_pixels(ImageLight(seen.signal_e, worst_e=likely, may_miss=FRAME_MAY_MISS))
            elif pixels is not None:
                veils: Veils = "none" if optimistic else "all"
                with_pixels = self._with_pixels
                if optimistic and not self.bounds.is_sunlit(index):
                    veils = stage
                    with_pixels = self._with_pixels if stage == "likely" else self._with_likely_pixel
                seen = with_pixels(index, imager, count, lighting, seen, veils=veils)
            rows = setting_rows(
                self.problem, index, camera=self.imagers.camera[imager], light=light, count=count,
                focused=self.imagers.scenes[index].focused.take(imager), image_light=seen,
                sun=self._sun(index, imager, count, lighting, pixels=pixels, few=unlit),
                sharp=self._sharp(index, imager, lighting),
            )  # fmt: skip
            if optimistic:
                rows = of_darkest_pixels(rows, LIKELY_PLACES)
            if with_rules and not optimistic and self._has_rules(index):
                kept = self._keeps_rules_in(index, imager, light, count, lighting)
                rows = replace(rows, time_max_s=np.where(kept, rows.time_max_s, -1.0))
            result.append(replace(rows, optimistic=optimistic))
        return result

    def _are_unlit(self, light: Array) -> bool:
        """Whether all of these lights stand for no lamp."""
        return all(self.problem.unlit(int(one)) for one in np.unique(light))

    def _sharp(self, scene_index: int, imager: Array, lighting: Lighting) -> SharpRows | None:
        """What MTF and information depend on, where either is asked for."""
        needs = self.problem.scenes[scene_index].view.requirements
        if not needs.asks_sharpness and not self.objective.weight("information"):
            return None
        unique, back = np.unique(imager, return_inverse=True)
        imagers, seen = self.imagers, self.imagers.scenes[scene_index]
        return sharpness_of(
            self.problem, scene_index, seen.view.take(unique), camera=imagers.camera[unique], lens=imagers.lens[unique],
            port=imagers.port[unique], optics=lighting.optics,
            dioptre_per_m=seen.focused.dioptre_per_m[unique],
        ).take(back)  # fmt: skip

    def _sun(
        self, scene_index: int, imager: Array, count: Array, lighting: Lighting, *, pixels: Pixels | None, few: bool
    ) -> SunLight | None:
        """The sun's light in these images; the pixels looked at depend on the number of lamps."""
        parts = []
        for number in np.unique(count) if pixels else [int(count.max(initial=1))]:
            mine = np.nonzero(count == number)[0] if pixels else np.arange(len(count))
            unique, back = np.unique(imager[mine], return_inverse=True)
            sun = sun_light(
                self.problem,
                scene_index,
                self.imagers.scenes[scene_index].view.take(unique),
                self.imagers.camera[unique],
                port_index=self.imagers.port[unique],
                mount=lighting.mount,
                count=int(number),
                pixels=pixels,
                few=few,
                field_type=RememberedSunField,
            )
            if sun is None:
                return None
            alike = len(unique) == len(back) and bool((back == np.arange(len(back))).all())
            parts.append((mine, sun if alike else sun.take(back)))
        return parts[0][1] if len(parts) == 1 else SunLight.in_places(parts, len(count))

    def _has_rules(self, scene_index: int) -> bool:
        """Whether one scene asks for even light, or for lamps out of the view."""
        needs = self.problem.scenes[scene_index].view.requirements
        return needs.min_uniformity is not None or lamps_refused(self.problem, scene_index)

    def _asks_of_image(self, scene_index: int) -> bool:
        """Whether one scene asks for what takes integrals over the image beside its mean."""
        return self.problem.scenes[scene_index].at_worst or self._has_rules(scene_index)

    def _keeps_rules(self, pairs: NodeDesigns, lighting: Lighting) -> Array:
        """Whether designs keep in all scenes the rules that no setting can mend: even light, no lamp in the view."""
        kept, imager = np.ones(len(pairs.node), bool), pairs.imager[pairs.node]
        for index in range(len(self.problem.scenes)):
            if self._has_rules(index):
                self.deadline.check()
                kept &= self._keeps_rules_in(index, imager, pairs.light, pairs.count, lighting)
        return kept

    def _keeps_rules_in(
        self, scene_index: int, imager: Array, light: Array, count: Array, lighting: Lighting
    ) -> Array:
        """The same in one scene; no lamp is none in the view, and its light is even."""
        wanted = self.problem.scenes[scene_index].view.requirements.min_uniformity
        kept = np.array([self.problem.unlit(one) for one in range(len(self.problem.parts.lights))])[light]
        for number in np.unique(count):
            mine = np.nonzero((count == number) & ~kept)[0]
            view = self.imagers.scenes[scene_index].view.take(imager[mine])
            port = self.imagers.port[imager[mine]]
            fine = np.ones(len(mine), bool)
            lamps: dict[str, Any] = dict(mount=lighting.mount, count=int(number))
            if lamps_refused(self.problem, scene_index):
                fine = keeps_clear(self.problem, scene_index, view, port=port, **lamps)
            if wanted is not None and fine.any():
                fine[fine] = even_enough(
                    self.problem, scene_index, view.take(fine), port=port[fine], optics=lighting.optics,
                    wanted=wanted, deadline=self.deadline, **lamps,
                )  # fmt: skip
            kept[mine] = fine
        return kept

    def _with_likely_pixel(
        self, scene_index: int, imager: Array, count: Array, lighting: Lighting, seen: ImageLight, *, veils: Veils
    ) -> ImageLight:  # fmt: skip
        """With no less than the light at the pixel that decides, at all altitudes as at the farthest: for bounds."""
        del veils
        pixels = self.problem.scenes[scene_index].pixels
        assert pixels is not None
        most_e = np.empty(len(imager))
        for number in np.unique(count):
            mine = np.nonzero(count == number)[0]
            unique, back = np.unique(imager[mine], return_inverse=True)
            most_e[mine] = self.tables.likely_pixel(
                scene_index, lighting, unique, count=int(number), pixels=pixels
            )[back]
        worst_e = np.broadcast_to(most_e[:, None, None], (*seen.signal_e.shape, 1))
        return seen.with_pixels(ImageLight(seen.signal_e, worst_e=worst_e))

    def _with_pixels(
        self,
        scene_index: int,
        imager: Array,
        count: Array,
        lighting: Lighting,
        seen: ImageLight,
        *,
        veils: Veils,
    ) -> ImageLight:
        """With the light at the pixels that the SNR is asked of: their share of each lamp depends on the number."""
        first, back = rows_alike(imager, count)
        parts = []
        for number in np.unique(count):
            mine = np.nonzero(count[first] == number)[0]
            at = self.tables.exact(
                scene_index,
                lighting,
                imager[first[mine]],
                count=int(number),
                pixels=self.problem.scenes[scene_index].pixels,
                means=False,
                veils=veils,
                deadline=self.deadline,
            )
            parts.append((mine, at))
        return seen.with_pixels(ImageLight.in_places(parts, len(first)).take(back))
