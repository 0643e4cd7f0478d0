"""What costs much less and is little worse: the cheapest system that gives up no more than a quarter of the goal.

Where prices are no part of the goal, its optimum may pay thousands for what nobody notices: a camera, a dome or a lamp
for milliwatts.
"""

from __future__ import annotations

import math

from uwopt.deadline import NEVER, Deadline, processor_s
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.results.basis import LessMoney
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.knee import limit_cost_of, with_limits
from uwopt.solvers.one_hardware import as_set, best_of, pieces_by_kind
from uwopt.solvers.recommend import Sought, evaluated

GIVEN_UP = 0.25  # of the goal, at most
SAVED = 0.1  # of the price, at least: prices that are ranges tell no finer
LIMIT_OF = {"power": "power_w", "mass": "mass_kg"}
LESS_MONEY_S = 5.0  # of the processor, where no time is given
CHEAPEST = Objective.of("cost")


def less_money(sought: Sought, deadline: Deadline = NEVER) -> LessMoney | None:
    """The cheapest system, by likeliest values, that is at most a quarter worse than the first of a search.

    None where none saves a tenth of the price. Raises OutOfTimeError.
    """
    limit, best, problem = holding_limit(sought.goal), sought.outcome.best[0], sought.problem
    if limit is None:
        return None
    deadline = deadline.or_after(LESS_MONEY_S, processor_s)
    within = no_more_than(problem, limit, (1.0 + GIVEN_UP) * best.minimised)
    ceiling = (1.0 - SAVED) * best.cost
    found = Search(within, CHEAPEST, top=1, deadline=deadline, ceiling=ceiling).whole().best
    deadline.check()  # the cheapest of half a search is not
    if not found:
        return None
    alone, imagers = as_set(problem, found[0], None, None)
    own = best_of(alone, sought.goal, deadline, imagers)
    if not math.isfinite(own):  # what fits to the last digit of a limit may not without it
        return None
    prices, values = (found[0].cost, best.cost), (own, best.minimised)
    return cheaper_record(sought, found[0], prices, values, cost_limit=limit_cost_of(sought, found[0]))


def holding_limit(goal: Objective) -> str | None:
    """The limit that can hold a goal; None of a goal that none can."""
    return LIMIT_OF.get(goal.single or "")


def no_more_than(problem: Problem, limit: str, most: float) -> Problem:
    """The same tables with no more of one figure than this, nor than the mission allows."""
    asked = getattr(problem.mission.limits, limit)
    return with_limits(problem, {limit: most if asked is None else min(most, asked)})


def cheaper_record(
    sought: Sought, found: Found, prices: tuple[float, float], values: tuple[float, float], *,
    held: float | None = None, cost_limit: float | None = None,
) -> LessMoney:  # fmt: skip
    """The record of a system that fits by likeliest values, with its price and value beside those of the first."""
    value, of_best = map(sought.goal.reported, values)
    return LessMoney(
        hardware={kind: part.id for kind, part in pieces_by_kind(sought.problem, found).items()},
        light_count=sought.problem.lamps_carried(found),
        price=prices[0], price_of_best=prices[1], currency=sought.problem.mission.limits.currency, value=value,
        value_of_best=of_best, held=held, cost_limit=cost_limit,
        uniformity=evaluated(sought.problem, found, sought.goal).least("uniformity"),
    )  # fmt: skip
