"""Which hardware may hold often enough and be better than the best known: by waters that are no harder, worst first.

Each group of scenarios of like water lends its bounds to those in it. What they discard is lost in too many scenarios
whatever the others would say, so that most hardware is looked at in few of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import Deadline
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.outcomes import Judge, groups_of
from uwopt.solvers.confidence.panels import Anchor, least_covered
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.states import Together
from uwopt.solvers.exact.ranking import Found


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
