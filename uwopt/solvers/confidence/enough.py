"""At which stops one hardware holds in so many scenarios: no more settings are looked for than it takes to tell.

The stop that is likeliest to is asked of all scenarios. The others are asked first of those that it misses, which are
hard for them too; of the rest only where so few are missed that they may hold in as many.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.counted import Counted
from uwopt.solvers.confidence.outcomes import Judge, Outcomes, marks_of, outcomes_together
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.states import Together
from uwopt.solvers.exact.ranking import Found


def stops_that_hold(
    base: Problem, found: Found, objective: Objective, scenarios: Scenarios, least: float,
    likely: float | None = None, deadline: Deadline = NEVER,
) -> Iterator[Counted]:  # fmt: skip
    """One hardware at each stop at which it holds in a share of the scenarios, as these are told.

    What is told of other stops is not counted in all of them: there the objective is inf.

    likely : f-number of the stop that is likeliest to hold, which is asked first; None: not known
    """
    group = Together.of(base, [found], scenarios)
    marks = marks_of(base, group, 0, None)
    rows = group.rows(objective, deadline) if marks else []
    if len(marks) < 2 or scenarios.doubt.settings == "fixed":
        (whole,) = outcomes_together(group, objective, rows, [marks])
        yield from those_that_hold(found, whole, range(len(whole.f_numbers)), least)
        return
    value, every = np.full((len(marks), scenarios.count), np.inf), np.arange(len(group.scenario))
    meant_m = None if np.isnan(group.meant_m[0]) else float(group.meant_m[0])
    made = Outcomes(np.array(marks), value, group.lost[0], meant_m=meant_m)

    def judge(stops: Sequence[int], some: Array) -> None:
        """Settings of some imagers, each in its scenario, at these stops."""
        imager, stop = np.tile(some, len(stops)), np.repeat(np.array(stops, int), len(some))
        if len(imager):
            one = Judge.of(group, objective, rows, imager, made.f_numbers[stop])
            value[stop, group.scenario[imager]] = one.verdict(one.adapted())[0]

    first = len(marks) // 2 if likely is None else int(np.abs(np.log(made.f_numbers / likely)).argmin())
    judge([first], every)
    yield from those_that_hold(found, made, [first], least)
    others = [stop for stop in range(len(marks)) if stop != first]
    is_hard = ~np.isfinite(value[first, group.scenario])
    judge(others, every[is_hard])
    most = np.isfinite(value[:, group.scenario[is_hard]]).sum(axis=1) + (~is_hard).sum()
    may = [stop for stop in others if most[stop] / scenarios.count >= least]
    judge(may, every[~is_hard])
    yield from those_that_hold(found, made, may, least)


def those_that_hold(found: Found, made: Outcomes, stops: Sequence[int], least: float) -> Iterator[Counted]:
    """The hardware at those of some stops at which it holds in a share of the scenarios, the most often first."""
    for stop in sorted(stops, key=lambda stop: -made.held[stop]):
        if made.held[stop] >= max(least, 1.0 / made.value.shape[1]):
            yield Counted(found, made, stop)
