"""What a search does with nodes: their light, then their designs, bounded by what is known of it and solved.

Veils, pixels and other integrals over the image are worked out for those that may still win, best bound first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline, UntilFound, spend
from uwopt.forward.columns import distinct, rows_alike
from uwopt.forward.lamp_light import Veils
from uwopt.forward.light_columns import ImageLight
from uwopt.forward.problem import Problem
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.exact.account import NOT_REACHED, Account
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.design_rows import NodeRows
from uwopt.solvers.exact.imagers import Imagers, imagers_in
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.node_bounds import by_rule, first_missed
from uwopt.solvers.exact.node_designs import NodeDesigns, Waiting
from uwopt.solvers.exact.ranking import Ranking
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.question import GAP, Question, gap_if_told
from uwopt.tolerances import ROUND, SLACK

MOST_ROWS_AT_ONCE = 60_000
ENOUGH_ASKED, MOST_REFUSED = 24, 0.9  # designs, and the share of them, that say which rules to ask first
ROUGH_GAP = 1e-2  # of bounds over settings that are searched cell by cell


@dataclass
class Refusals:
    """How many designs came to the rules which no setting can mend, and how many these refused."""

    asked: int = 0
    refused: int = 0

    def count(self, kept: Array) -> None:
        """Some more designs, and which of them were kept."""
        self.asked, self.refused = self.asked + len(kept), self.refused + int((~kept).sum())

    @property
    def are_most(self) -> bool:
        """Whether nearly all that came as far were refused: then these rules are the first to be asked."""
        return self.asked >= ENOUGH_ASKED and self.refused >= MOST_REFUSED * self.asked


class Evaluation:
    """Nodes of some imagers, evaluated; and the best of all that were."""

    def __init__(
        self, problem: Problem, objective: Objective, *, top: int, deadline: Deadline = NEVER, ceiling: float = np.inf,
        only: Mapping[str, Array] | None = None, enough: bool = False, most_in_vain: float = np.inf,
    ):  # fmt: skip
        """The best `top` below a ceiling; `only` marks parts by kind; `enough`: one design that fits, whichever.

        most_in_vain : designs; where more are looked at and none fits, the search ends without a proof
        """
        self.problem, self.objective, self.top, self.ceiling = problem, objective, max(1, top), ceiling
        self.only, self.enough = only or {}, enough
        self.most_in_vain, self.is_in_vain = most_in_vain, False  # it ended as none fits of so many designs
        self.deadline = deadline
        if enough or np.isfinite(most_in_vain):
            self.deadline = UntilFound.of(deadline, self._is_over)
        self.ranking = Ranking(problem, imagers_in(problem, []), top=self.top, ceiling=ceiling)
        self.account = Account()
        self.limits = problem.mission.limits
        self.open_gap_bound = np.inf  # below which no settings get, where they are not optimal to rounding
        self._waiting: list[Waiting] = []
        self.refusals = Refusals()
        self._patient = False  # designs wait while others have lower bounds

    def _is_over(self) -> bool:
        """Whether a search ends before its time: one design was enough, or too many were looked at in vain."""
        if self.ranking.best:
            return self.enough
        self.is_in_vain |= self.account.evaluated > self.most_in_vain
        return self.is_in_vain

    # ------------------------------------------------------------ imagers

    def take_up(self, bounds: Bounds) -> None:
        """Evaluate the nodes of their imagers from now on; the best that were found stay."""
        self.bounds = bounds
        self.design_rows = NodeRows(self.problem, self.objective, bounds, self.deadline)
        self.ranking = self.ranking.among(bounds.imagers)

    @property
    def imagers(self) -> Imagers:
        """Those of the bounds."""
        return self.bounds.imagers

    @property
    def tables(self) -> FieldTables:
        """Those of the bounds."""
        return self.bounds.tables

    @property
    def motorised(self) -> Array:
        """Whether each imager's lens is."""
        return self.bounds.motorised

    @property
    def rows(self) -> Callable[..., list[SceneRows]]:
        """Designs of the imagers as rows of settings; see `NodeRows.rows`."""
        return self.design_rows.rows

    # ------------------------------------------------------------ nodes

    def evaluate_nodes(self, lighting_index: Array, imager: Array) -> None:
        """Exact signal of these nodes, then all their lights and counts; those without lamps apart."""
        under = Under(self.tables.lightings, lighting_index)
        if self.refusals.are_most:
            kept = self._may_keep_rules(imager, under)
            self.refusals.count(kept)
            self.account.evaluated += int(self.bounds.sizes[lighting_index[~kept]].sum())
            imager, under = imager[kept], under.take(kept)
        for some in self.together(under):
            lights = self.tables.in_scenes(under.take(some), imager[some], veils="none", deadline=self.deadline)
            self._evaluate_pairs(imager[some], lights, under.take(some))

    def together(self, under: Under) -> Iterator[Array]:
        """Nodes whose designs are looked at together: not too many, and those without lamps apart.

        Where one that fits ends the search, those under the lighting of the first alone, then under twice as many each:
        light for all the others would be in vain.
        """
        sizes = self.bounds.sizes[under.index]
        unlit = np.array([self.problem.are_unlit(table.light) for table in self.bounds.light_tables], bool)[under.index]
        turn = np.zeros(len(unlit), int)
        if self.enough and len(turn):
            _, first, back = np.unique(under.index, return_index=True, return_inverse=True)
            turn = np.log2(np.argsort(np.argsort(first))[back] + 1.0).astype(int)
        for alike in (np.flatnonzero((turn == one) & (unlit == dark)) for one in range(turn.max(initial=0) + 1)
                      for dark in (False, True)):  # fmt: skip
            part = np.cumsum(sizes[alike]) // MOST_ROWS_AT_ONCE
            yield from (alike[part == value] for value in distinct(part)[0])

    def _evaluate_pairs(self, imager: Array, lights: list[ImageLight], under: Under) -> None:
        """Every (node, light, count): drop what misses a limit or cannot win, solve the rest."""
        imagers, pairs = self.imagers, NodeDesigns.every(self.imagers, imager, under, self.bounds.light_tables)
        row = pairs.row
        floor = self.objective.cost_to_minimise(
            Terms.at_best(
                imagers.camera_power_w[row], pairs.cost, pairs.mass_kg, imagers.gsd_mm[row],
                self.bounds.information_ceiling(imager)[pairs.node],
            )
        )  # fmt: skip
        beaten = self.ranking.shut_out(floor, imagers.camera_power_w[row], pairs.cost, pairs.mass_kg)
        rule = first_missed([*pairs.kept_limits(self.limits), ("bound", ~beaten)])
        for name, lost in by_rule(rule):
            self.account.charge(name, len(lost))
        keep = np.nonzero(rule < 0)[0]
        self.account.evaluated += len(keep)
        if len(keep):
            self._solve_pairs(pairs.take(keep), lights)

    def _solve_pairs(self, pairs: NodeDesigns, lights: list[ImageLight]) -> None:
        """Settings of these designs, and their place among the best.

        Where there are veils, pixels or other integrals over the image, designs are bounded first as if there were
        no veil and as if few pixels counted; the integrals are worked out for those that may still win, best bound
        first.
        """
        veiled = self.problem.effects.veils
        if not veiled and not any(self.design_rows.asks_of_image(index) for index in range(len(lights))):
            self._rank(pairs, [light.take(pairs.node) for light in lights])
            return
        sunlit = any(self.bounds.needs.is_sunlit(index) for index in range(len(lights)))
        if sunlit or self.refusals.are_most:  # bounds of settings cost more than rules
            pairs = self._keeping_rules(pairs, whole=False)
            if len(pairs) == 0:
                return
        found, bound = 0, np.full(len(pairs.node), -np.inf)
        stages = self._stages()
        for stage in stages:
            if stage in ("forward", "coarse"):
                lights = self._with_veils(pairs, lights, stage)
            bound = np.maximum(bound, self._bound(pairs, lights, stage, closed_alone=stage != stages[-1]))
            found = found or int(np.isfinite(bound).sum())
            kept = np.nonzero(np.isfinite(bound) & ~self._beaten(pairs, bound))[0]
            if len(kept) == 0:
                break
            pairs, used = pairs.alone(kept)
            lights, bound = [light.take(used) for light in lights], bound[kept]
        self.account.evaluated -= found
        self.account.charge("bound", found)
        if len(kept):
            self._waiting.append(Waiting.of(pairs, bound, lights))
            if not self._patient:  # else other nodes may hold better bounds
                self._solve_waiting()

    def _may_keep_rules(self, imager: Array, under: Under) -> Array:
        """Whether some number of the lamps keeps the rules which no setting can mend, by node."""
        kept = np.zeros(len(imager), bool)
        tables = dict(zip(self.tables.lightings, self.bounds.light_tables, strict=True))
        for lighting, rows in under.each():
            table = tables[lighting]
            kept[rows] = any(self.problem.unlit(int(one)) for one in table.light)
            for item in np.unique(table.count, return_index=True)[1]:
                mine = rows[~kept[rows]]
                lamps = np.full(len(mine), table.light[item]), np.full(len(mine), table.count[item])
                kept[mine] = self.design_rows.keep_rules(
                    imager[mine], *lamps, Under.one(lighting, len(mine)), whole=False
                )
        return kept

    def _keeping_rules(self, pairs: NodeDesigns, *, whole: bool = True) -> NodeDesigns:
        """Those designs that keep the rules which no setting can mend, as few or all places of the floor tell."""
        kept = self.design_rows.keep_rules(pairs.row, pairs.light, pairs.count, pairs.lit, whole=whole)
        self.refusals.count(kept)
        return pairs.take(np.nonzero(kept)[0])

    def _beaten(self, pairs: NodeDesigns, bound: Array) -> Array:
        """Which of these designs, by lower bounds of their objective, get no place among the best."""
        power, weight = self.imagers.camera_power_w[pairs.row], self.objective.weight("power")
        if self.objective.single == "power" and weight:
            power = np.maximum(power, bound / weight * (1.0 - 10.0 * SLACK))
        return self.ranking.shut_out(bound, power, pairs.cost, pairs.mass_kg)

    def _stages(self) -> tuple[Veils, ...]:
        """What designs are bounded by, in turn; each costs more than the one before."""
        if not self.problem.effects.veils:
            return ("none",)
        scenes = enumerate(self.problem.scenes)
        veiled = any(s.pixels is not None and s.scatters and not self.bounds.needs.is_sunlit(i) for i, s in scenes)
        return ("none", "forward", "coarse", "likely") if veiled else ("none", "forward", "coarse")

    def _bound(
        self, pairs: NodeDesigns, lights: list[ImageLight], stage: Veils, *, closed_alone: bool
    ) -> Array:
        """Lower bounds on the objective from the light known so far; inf: infeasible with any veil."""
        spend("designs", len(pairs))
        seen = [light.take(pairs.node) for light in lights]
        return self.solve(pairs, seen, optimistic=True, stage=stage, closed_alone=closed_alone)[0]

    def _with_veils(self, pairs: NodeDesigns, lights: list[ImageLight], veils: Veils) -> list[ImageLight]:
        """Further veils beside the light that is known, by scene; raises OutOfTimeError past the deadline."""
        self.deadline.check()
        return self.tables.in_scenes(pairs.under, pairs.imager, known=lights, veils=veils, deadline=self.deadline)

    def _solve_fully(self, some: NodeDesigns, lights: list[ImageLight]) -> None:
        """Rank those of some designs that keep the rules, with all their veils beside the light of all nodes."""
        some = self._keeping_rules(some)
        if len(some):
            some, used = some.alone(np.arange(len(some)))
            full = self._with_veils(some, [light.take(used) for light in lights], "all")
            self._rank(some, [light.take(some.node) for light in full])

    def _solve_waiting(self, until: float = np.inf) -> None:
        """Solve what waits with all its veils, best bound first, as far as it may win and nothing else has less."""
        while self._waiting:
            first = min(self._waiting, key=lambda group: group.lowest)
            most = min(until, self.ranking.threshold())
            if first.lowest > most:
                break
            self._solve_next(first, most)
        threshold = self.ranking.threshold()
        self._waiting = [group for group in self._waiting if group.lowest <= threshold]

    def _solve_until_beatable(self) -> None:
        """Under the sun, solve what waits, best bound first, until there is something to beat.

        Until then no bound discards any, and there each is dear; without sun what waits is dearer than bounds.
        """
        sunlit = any(scene.sunlit for scene in self.problem.scenes)
        while sunlit and self._waiting and not np.isfinite(self.ranking.threshold()):
            self._solve_next(min(self._waiting, key=lambda group: group.lowest), np.inf)

    def _solve_next(self, group: Waiting, most: float) -> None:
        """Solve the next few of a group that waits, with no more than some bound."""
        self.deadline.check()
        some, left = group.taken(most, ~self._beaten(group.pairs, group.bound))
        self._solve_fully(some, group.lights)
        self.account.evaluated += len(some)
        self.account.charge("bound", -len(some))
        rest = [other for other in self._waiting if other is not group]
        self._waiting = [*rest, *([left] if np.isfinite(left.lowest) else [])]

    def _not_reached(self) -> float:
        """Count what waits as not reached, as time is over; the least of its bounds."""
        lowest, threshold = np.inf, self.ranking.threshold()
        for group in self._waiting:
            left = group.left() & (group.bound <= threshold)
            self.account.charge("bound", -int(left.sum()))
            self.account.charge(NOT_REACHED, int(left.sum()))
            lowest = min(lowest, group.lowest)
        self._waiting = []
        return lowest

    def _rank(self, pairs: NodeDesigns, lights: list[ImageLight]) -> None:
        """Solve these designs and put them in their place among the best."""
        self.ranking.add(pairs, *self.solve(pairs, lights))

    def solve(
        self, pairs: NodeDesigns, lights: list[ImageLight], *, optimistic: bool = False,
        stage: Veils = "none", closed_alone: bool = False,
    ) -> tuple[Array, Terms, list[Chosen]]:  # fmt: skip
        """Objective (inf where infeasible), its terms and settings of these designs.

        `optimistic`: lower bounds for any veil that the lights may have, at this stage; `closed_alone` as in
        `best_settings`. Raises OutOfTimeError past the deadline.
        """
        self.deadline.check()
        imager = pairs.row
        rows = self.rows(imager, lights, pairs.light, pairs.count, pairs.lit, optimistic=optimistic, stage=stage)
        question = pairs.asked(
            self.problem, self.imagers, self.objective, rows,
            gap_rel=gap_if_told(self.objective, ROUGH_GAP) if optimistic else GAP,
            cutoff=self.ranking.threshold(), hardware=rows_alike(imager, pairs.light)[1],
            top=None if optimistic else self.top, deadline=self.deadline,
        )  # fmt: skip
        best = best_settings(question, closed_alone=closed_alone)
        value, terms = pairs.worth(self.imagers, question, best)
        feasible = best.feasible & (terms.power <= self.problem.scene_power_limit_w * ROUND)
        if best.lower_bound is not None and not optimistic:
            open_ = np.isfinite(best.lower_bound) & ~feasible & (best.lower_bound <= self.ranking.threshold())
            hopeless = self._draw_too_much(question, np.flatnonzero(open_))
            best = replace(best, lower_bound=np.where(hopeless, np.inf, best.lower_bound))
        value = np.where(feasible & np.isfinite(value), value, np.inf)
        if best.lower_bound is not None:
            if optimistic:
                return best.lower_bound, terms, best.chosen
            self.open_gap_bound = min(self.open_gap_bound, float(best.lower_bound.min(initial=np.inf)))
        return value, terms, best.chosen

    def _draw_too_much(self, question: Question, which: Array) -> Array:
        """Which of some designs draw more than the limit at any settings, by a bound of their power alone, (n,)."""
        hopeless, limit_w = np.zeros(len(question), bool), self.problem.scene_power_limit_w
        if len(which) and np.isfinite(limit_w):
            some = question.take(which)
            least = best_settings(Question.of(
                some.rows, some.motorised, Objective.of("power"), some.camera_power_w, limit_w,
                constant=some.camera_power_w, cutoff=limit_w * ROUND, mean_limit=some.mean_limit,
            ))  # fmt: skip
            if least.lower_bound is None:  # the least itself
                least_w = some.camera_power_w + np.max([c.light_power_w for c in least.chosen], axis=0)
                hopeless[which] = least.feasible & (least_w > limit_w * ROUND)
            else:
                hopeless[which] = least.lower_bound > limit_w * ROUND
        return hopeless
