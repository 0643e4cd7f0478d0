"""Where the best image stands on its knee: what one more watt, or 100 USD more, would buy of its quality.

Each step is a search of its own over the same tables, for the most of the quality within the winner's power and cost
and that step; the mission's own limits of the two may be passed, for a reader decides by it whether to raise them.
"""

from __future__ import annotations

import math

import numpy as np

from uwopt.catalog.money import to_currency
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.problem import Problem
from uwopt.mission.best_image import BestImageGoal
from uwopt.objectives.goal import NAME_OF
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Bought, Knee
from uwopt.solvers.exact.imagers import imagers_in
from uwopt.solvers.exact.node_designs import WithLamps
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.one_hardware import pieces_by_kind
from uwopt.solvers.recommend import Sought

MORE_W, MORE_USD = 1.0, 100.0
TOLD_REL = 2e-4  # of a gain: twice what settings are searched to


def knee(sought: Sought, deadline: Deadline = NEVER) -> Knee | None:
    """What more power and money buy beside the best of a search; None where the objective has no knee."""
    goal = sought.goal
    mission, found = sought.problem.mission, sought.outcome.best[0]
    wanted = mission.objective
    if not goal.quality or not isinstance(wanted, BestImageGoal):
        return None
    limits, gains = mission.limits, wanted.best_image
    step = to_currency(MORE_USD, "USD", limits.currency, limits.rates)
    power_w, cost = found.power_w, limit_cost_of(sought, found)
    bought = []
    for what, amount, unit, limit in (
        ("power_w", MORE_W, "W", limits.power_w), ("cost", step, limits.currency, limits.cost)
    ):  # fmt: skip
        more = {"power_w": power_w, "cost": cost}
        more[what] += amount
        gain, parts = best_within(sought, more, deadline)
        bought.append(Bought(what, amount, unit, gain, parts, limit is not None and more[what] > limit))
    log_quality = log_quality_of(goal, found)
    unit = goal.unit(limits.currency)
    return Knee(NAME_OF[goal.quality], math.exp(log_quality), unit, gains.per_w, gains.per_100_usd, bought)


def log_quality_of(goal: Objective, found: Found) -> float:
    """Logarithm of a design's quality: what is minimised, with the prices taken off again."""
    return goal.weight("power") * found.power_w + goal.weight("cost") * found.cost - found.minimised


def best_within(
    sought: Sought, limits: dict[str, float], deadline: Deadline
) -> tuple[float, dict[str, str]]:
    """The share by which the best within other limits is better, and its parts; 0 and none where nothing is."""
    goal = sought.goal
    quality = Objective.best_image(goal.quality, per_w=0.0, per_money=0.0)
    mine = -log_quality_of(goal, sought.outcome.best[0])
    problem = with_limits(sought.problem, limits)
    outcome = Search(problem, quality, top=1, deadline=deadline, ceiling=mine - quality.step(TOLD_REL, mine)).whole()
    deadline.check()  # the best of half a search tells nothing
    if not outcome.best:
        return 0.0, {}
    best = outcome.best[0]
    ids = {kind: part.id for kind, part in pieces_by_kind(problem, best).items()}
    return quality.share(mine - best.minimised, mine), ids


def with_limits(problem: Problem, limits: dict[str, float]) -> Problem:
    """The same tables under other limits of power and cost."""
    mission = problem.mission
    given = mission.limits.model_dump(mode="json", by_alias=True)
    return problem.with_mission(mission.with_changes(limits={**given, **limits}))


def limit_cost_of(sought: Sought, found: Found) -> float:
    """What a design counts against a limit of cost: estimated prices at the end that the mission says."""
    own = imagers_in(sought.problem, [found.behind])  # over scenarios it is found beside the search
    one, *lamps = (np.array([number]) for number in (0, found.light, found.count))
    return float(WithLamps.of(sought.problem, own, one, *lamps).limit_cost[0])
