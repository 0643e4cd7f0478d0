"""What costs much less and is little worse: the cheapest system that gives up no more than a quarter of the goal.

Where prices are no part of the goal, its optimum may pay thousands for what nobody notices: a second lamp for four
milliwatts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from uwopt.deadline import NEVER, Deadline, processor_s
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.results.basis import LessMoney
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.knee import limit_cost_of, with_limits
from uwopt.solvers.one_hardware import as_set, pieces_of
from uwopt.solvers.recommend import Sought

if TYPE_CHECKING:
    from uwopt.solvers.confidence.search import Certain

GIVEN_UP = 0.25  # of the goal, at most
SAVED = 0.1  # of the price, at least: prices that are ranges tell no finer
LIMIT_OF = {"power": "power_w", "mass": "mass_kg"}  # goals that a limit can hold
LESS_MONEY_S = 5.0  # of the processor, where no time is given
CHEAPEST = Objective.of("cost")


def less_money(sought: Sought, deadline: Deadline = NEVER, choice: Certain | None = None) -> LessMoney | None:
    """The cheapest system that is at most a quarter worse than the first of a search; None where none saves a tenth.

    choice : of hardware that holds in the doubt: then one that holds as often as asked, by its medians, among those
        that are cheapest in worse numbers than in most scenarios, and all that was counted

    Raises OutOfTimeError.
    """
    limit = LIMIT_OF.get(sought.goal.single or "")
    if limit is None:
        return None
    deadline = deadline.or_after(LESS_MONEY_S, processor_s)
    return at_likeliest(sought, limit, deadline) if choice is None else in_doubt(sought, choice, limit, deadline)


def at_likeliest(sought: Sought, limit: str, deadline: Deadline) -> LessMoney | None:
    """The cheapest by likeliest values, of all that the search was made over."""
    problem, best = sought.problem, sought.outcome.best[0]
    within = no_more_than(problem, limit, (1.0 + GIVEN_UP) * best.minimised)
    ceiling = (1.0 - SAVED) * best.cost
    found = Search(within, CHEAPEST, top=1, deadline=deadline, ceiling=ceiling).whole().best
    deadline.check()  # the cheapest of half a search is not
    if not found:
        return None
    alone, imagers = as_set(problem, found[0], None, None)
    own = Search(alone, sought.goal, top=1, imagers=imagers).whole().best[0]
    prices, values = (found[0].cost, best.cost), (own.minimised, best.minimised)
    return told(sought, found[0], prices, values, cost_limit=limit_cost_of(sought, found[0]))


def in_doubt(sought: Sought, choice: Certain, limit: str, deadline: Deadline) -> LessMoney | None:
    """The cheapest that holds as often as asked, of what has room and of what was counted."""
    from uwopt.solvers.confidence.counted import Looked, names
    from uwopt.solvers.confidence.roomy import WORSE, RoomySearches
    from uwopt.solvers.confidence.search import at_its_stop

    problem, ours = sought.problem, choice.best
    if not (choice.enough and choice.scenarios.is_drawn):
        return None
    seen = Looked(problem, sought.goal, choice.asked, choice.scenarios, [*choice.tried])
    within = no_more_than(problem, limit, (1.0 + GIVEN_UP) * ours.quantile(WORSE[0]))
    had = {names(problem, one.found) for one in seen.tried}
    cheap = RoomySearches.of(within, CHEAPEST, choice.scenarios, rungs=(), with_room=True, had=had, fits={})
    seen.count(cheap.next(deadline) or [], deadline)
    most, dearest = (1.0 + GIVEN_UP) * ours.quantile(0.5), (1.0 - SAVED) * ours.outcomes.price
    for one in sorted(seen.tried, key=lambda one: one.outcomes.price):
        serves = one.held >= seen.share and one.quantile(0.5) <= most and one.outcomes.price <= dearest
        if serves and at_its_stop(problem, sought.goal, one, deadline) is not None:
            prices, values = (one.outcomes.price, ours.outcomes.price), (one.quantile(0.5), ours.quantile(0.5))
            return told(sought, one.found, prices, values, held=one.held)
    return None


def no_more_than(problem: Problem, limit: str, most: float) -> Problem:
    """The same tables with no more of one figure than this, nor than the mission allows."""
    asked = getattr(problem.mission.limits, limit)
    return with_limits(problem, {limit: most if asked is None else min(most, asked)})


def told(
    sought: Sought, found: Found, prices: tuple[float, float], values: tuple[float, float], *,
    held: float | None = None, cost_limit: float | None = None,
) -> LessMoney:  # fmt: skip
    """The record of a system, with its price and value beside those of the first."""
    value, of_best = map(sought.goal.reported, values)
    return LessMoney(
        hardware={kind: part.id for kind, part in pieces_of(sought.problem, found)}, light_count=found.count,
        price=prices[0], price_of_best=prices[1], currency=sought.problem.mission.limits.currency, value=value,
        value_of_best=of_best, held=held, cost_limit=cost_limit,
    )  # fmt: skip
