"""That no other hardware holds as often as asked with a better median: panels, bounds, and counts of what they leave.

A panel (`panels`) is searched for all hardware at once; what it leaves is bounded in groups of scenarios of like water,
the worst first: what those discard is lost in too many whatever the others would say. What these leave is counted in
every scenario, at every stop of its ring. Each combination is accounted for once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from math import prod
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import Deadline, OutOfTimeError, Progress
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.counted import Counted, Looked, names
from uwopt.solvers.confidence.local_search import seen_beside
from uwopt.solvers.confidence.outcomes import Judge, Outcomes, groups_of, outcomes_where
from uwopt.solvers.confidence.panels import Anchor, anchors_of, least_covered, panel_of
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.states import Together, imagers_among
from uwopt.solvers.exact.certificate import per_light
from uwopt.solvers.exact.imagers import landscapes
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.one_hardware import among, problem_of
from uwopt.tolerances import TIE

MOST_LISTED = 800  # hardware that a panel leaves: of more the best by its values
PANEL_S = 5.0  # that its search may last where there is a limit: of what takes longer too much is left to prove
HOPELESS = 0.5  # of its median that the best known is better by in the panel, which then leaves what is twice as bad
OFTEN = 0.5  # of the scenarios, in which the surest holds where nothing holds as often as asked
FEW = 100_000  # combinations, of which a panel may leave a large share
MOST_VARIANTS = 64  # numbers, mounts and orientations
A_SCREEN = 160  # hardware that is bounded before what is left of it is counted
GLANCED, GLANCE_SHARE = 96, 0.3  # hardware of these that is looked at first, and of the time that is left
A_BATCH = 48  # hardware that is counted before the best known is asked for again


@dataclass(frozen=True)
class NoneBetter:
    """Where all combinations went, and what no hardware betters.

    `lower_bound` : minimised median of whatever holds as often as asked; inf where nothing does
    """

    total: int
    by_panel: int  # that miss a requirement in the panel, or are no better in it
    by_bounds: int  # likewise, by bounds in too many scenarios
    counted: int
    lower_bound: float

    @property
    def left(self) -> int:
        """Combinations of which nothing but the bound is known."""
        return self.total - self.by_panel - self.by_bounds - self.counted


@dataclass
class Prover:
    """The hardware that has been counted, and what may still be better."""

    seen: Looked
    deadline: Deadline
    progress: Progress

    @property
    def ceiling(self) -> float:
        """The least median of what holds; inf where nothing does."""
        best = self.seen.best
        return best.quantile(0.5) if best is not None and best.held >= self.seen.share else np.inf

    def run(self) -> NoneBetter | None:
        """Prove what can be proven in time; None: nothing."""
        proof, out = None, set[Any]()
        for _ in range(2):  # once more where the first pass found the first that holds, and had to leave some
            before = self.ceiling
            try:
                proof = self._passed(before, out)
            except OutOfTimeError:
                return proof
            if proof is None or not proof.left or self.ceiling >= before:
                break
        return proof

    def _passed(self, ceiling: float, out: set[Any]) -> NoneBetter | None:
        """Search the panel, bound and count what it leaves."""
        covered = least_covered(self.seen.scenarios.count, 0.5 if np.isfinite(ceiling) else self.seen.share)
        panel = panel_of(self.seen.problem, self.seen.scenarios, self.seen.objective, covered)
        if panel.covered < covered:
            return None
        timed = math.isfinite(self.deadline.left_s)
        if timed and self._total > FEW and self._is_hopeless(panel.problem, ceiling):
            return None
        patience = self.deadline.at_most(min(PANEL_S, self.deadline.left_s)) if timed else self.deadline
        search = Search(panel.problem, self.seen.objective, top=MOST_LISTED, ceiling=below(ceiling), deadline=patience)
        outcome = search.whole()
        if not outcome.complete:
            return None
        cut = len(outcome.best) >= MOST_LISTED
        beyond = outcome.best[-1].minimised if cut else ceiling
        if np.isfinite(ceiling):
            self._glance_at([among(self.seen.problem, found, panel.problem) for found in outcome.best[:GLANCED]])
            if cut:  # of more than are listed the bound alone is known, whatever is counted
                return NoneBetter(self._total, 0, 0, 0, min(self.ceiling, beyond))
        listed = list(self._variants(panel.problem, outcome.best, min(beyond, below(ceiling))))
        excluded = 0 if cut else self._total - len(listed)
        counted, dropped, waits = self._counted(sorted(listed, key=lambda one: one.minimised), ceiling, out)
        return NoneBetter(self._total, excluded, dropped, counted, min(self.ceiling, beyond, waits))

    def _is_hopeless(self, panel: Problem, ceiling: float) -> bool:
        """Whether a panel leaves more than time allows to count.

        It does where the best known is far better in it than it is; where none is known that holds as often as asked,
        if the surest holds so often that much else fits into the panel, which is as easy as the easiest scenarios.
        """
        best = self.seen.best
        if best is None or not np.isfinite(ceiling):
            return best is not None and best.held > OFTEN
        port = self.seen.problem.parts.ports[best.found.port].enclosure_id
        both_ends = [one for one in panel.parts.ports if one.enclosure_id == port]
        alone = problem_of(panel, best.found, lists={"port": both_ends})
        seen = Search(alone, self.seen.objective, top=1, deadline=self.deadline).whole().best
        return bool(seen) and ceiling - seen[0].minimised > HOPELESS * abs(ceiling)

    def _glance_at(self, some: Sequence[Found]) -> None:
        """Count what seems better in some scenarios: the sooner the best is known, the less has to be counted."""
        patience, best = self.deadline.part(GLANCE_SHARE), self.seen.best
        assert best is not None
        seen_beside(self.seen, some, patience, best)

    @property
    def _total(self) -> int:
        """All combinations."""
        return prod(map(len, self.seen.problem.parts.by_kind.values())) * per_light(self.seen.problem)

    def _variants(self, problem: Problem, best: Sequence[Found], ceiling: float) -> Iterator[Found]:
        """The same parts in every number, mount and orientation that is better in the panel; a search lists one."""
        low, high = problem.count_range
        kinds = list(product(range(low, high + 1), problem.mounts, landscapes(self.seen.problem)))
        if len(kinds) == 1 or not best:
            yield from (among(self.seen.problem, found, problem) for found in best)
            return
        if len(kinds) > MOST_VARIANTS:
            raise OutOfTimeError
        for count, mount, landscape in kinds:
            alone = problem.standing_at(mount).with_count(count)
            imagers = imagers_among(alone, best, landscape)
            if len(imagers):
                top = len(problem.parts.lights) * len(imagers)
                search = Search(
                    alone, self.seen.objective, top=top, imagers=imagers, ceiling=ceiling, deadline=self.deadline
                )
                outcome = search.whole()
                if not outcome.complete:
                    raise OutOfTimeError
                yield from (among(self.seen.problem, found, problem) for found in outcome.best)

    def _counted(self, listed: list[Found], ceiling: float, out: set[Any]) -> tuple[int, int, float]:
        """Bound and count hardware, best value in the panel first, as far as there is time.

        How many were counted, how many the bounds discard, and the value of the first that nobody looked at.
        """
        counted = dropped = 0
        anchors = anchors_of(self.seen.problem, self.seen.scenarios)
        for first in range(0, len(listed), A_SCREEN):
            some = listed[first : first + A_SCREEN]
            try:
                fresh = [found for found in some if names(self.seen.problem, found) not in out]
                left = may_be_better(
                    self.seen.problem, fresh, self.seen.objective, self.seen.scenarios, anchors,
                    share=self.seen.share, ceiling=below(min(ceiling, self.ceiling)), deadline=self.deadline,
                )  # fmt: skip
                out.update(names(self.seen.problem, found) for found, may in zip(fresh, left, strict=True) if not may)
                hopeful = [found for found, may in zip(fresh, left, strict=True) if may]
                for batch in range(0, len(hopeful), A_BATCH):
                    self.deadline.check()
                    self._count(hopeful[batch : batch + A_BATCH])
            except OutOfTimeError:
                return counted, dropped, some[0].minimised
            counted, dropped = counted + len(hopeful), dropped + len(some) - len(hopeful)
            self.progress(min(first / len(listed), 0.99), "proof that nothing else holds as often")
        return counted, dropped, np.inf

    def _count(self, some: Sequence[Found]) -> None:
        """Count hardware with its iris where that is best in each scenario; what may be better, at every stop."""

        def may(one: Outcomes) -> bool:
            return bool(one.held[0] >= self.seen.share and one.quantile(0.5)[0] <= self.ceiling)

        seen, problem = self.seen, self.seen.problem
        made = outcomes_where(problem, some, seen.objective, seen.scenarios, self.deadline, wanted=may)
        for found, one in ((some[place], one) for place, one in made.items()):
            name = names(problem, found)
            seen.tried[:] = [known for known in seen.tried if names(problem, known.found) != name]
            seen.tried.append(Counted(found, one, one.best(seen.share)))


def below(ceiling: float) -> float:
    """What is better than a value by more than rounding."""
    return ceiling - TIE * abs(ceiling) if np.isfinite(ceiling) else ceiling


# ---------------------------------------------------------------- bounds by groups of scenarios


def may_be_better(
    base: Problem, found: Sequence[Found], objective: Objective, scenarios: Scenarios, anchors: Sequence[Anchor], *,
    share: float, ceiling: float, deadline: Deadline,
) -> Array:  # fmt: skip
    """Of each hardware whether it may hold in so large a share of the scenarios with a median below the ceiling."""
    lost, worse = least_covered(scenarios.count, share), least_covered(scenarios.count, 0.5)
    rule, left = partial(passes, ceiling=ceiling, lost_at_most=lost, worse_at_most=worse), np.ones(len(found), bool)
    for places in groups_of(found):
        group = Together.of(base, [found[k] for k in places], scenarios, in_focus=True)
        left[places] = rule(bounds_of(group, objective, anchors, deadline, rule))
    return left


def bounds_of(
    group: Together, objective: Objective, anchors: Sequence[Anchor], deadline: Deadline,
    wanted: Callable[[Array], Array],
) -> Array:  # fmt: skip
    """Lower bounds of the objective by hardware and scenario, as far as they are wanted of the bounds so far."""
    value = bounds_before_light(group)
    for anchor in anchors:
        ours = np.flatnonzero(wanted(value)[group.hardware] & np.isin(group.scenario, anchor.scenarios))
        if len(ours):
            deadline.check()
            some = group.only(ours)
            rows = some.bounded_rows(objective, anchor, deadline)
            judge = Judge.of(some, objective, rows, np.arange(len(ours)), np.full(len(ours), np.nan))
            value[some.hardware, some.scenario] = judge.verdict(judge.adapted())[0]
    return value


def bounds_before_light(group: Together) -> Array:
    """Bounds of the objective by hardware and scenario: inf where a rule that knows no light discards it."""
    value = np.full((len(group.found), group.scenarios.count), np.inf)
    value[group.hardware, group.scenario] = -np.inf
    return value


def passes(value: Array, *, ceiling: float, lost_at_most: int, worse_at_most: int) -> Array:
    """Which rows are lost in few scenarios, and no better than the ceiling in few."""
    lost, worse = np.isinf(value) & (value > 0.0), value >= ceiling
    return np.asarray((lost.sum(axis=1) < lost_at_most) & (worse.sum(axis=1) < worse_at_most))
