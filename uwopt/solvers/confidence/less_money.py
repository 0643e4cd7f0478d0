"""What costs much less and is little worse where hardware is chosen over scenarios: it holds as often as asked."""

from __future__ import annotations

from uwopt.deadline import NEVER, Deadline, processor_s
from uwopt.results.basis import LessMoney
from uwopt.solvers.confidence.counted import Looked, names
from uwopt.solvers.confidence.roomy import WORSE, RoomySearches
from uwopt.solvers.confidence.search import Certain, at_its_stop
from uwopt.solvers.explain.less_money import (
    CHEAPEST,
    GIVEN_UP,
    LESS_MONEY_S,
    SAVED,
    cheaper_record,
    holding_limit,
    no_more_than,
)
from uwopt.solvers.recommend import Sought


def less_money_in_doubt(sought: Sought, choice: Certain, deadline: Deadline = NEVER) -> LessMoney | None:
    """The cheapest hardware by its median price that is, by its median, at most a quarter worse than what was chosen.

    Of all that was counted, and of what is cheapest in worse numbers than in most scenarios: no proof, an offer. None
    where none saves a tenth of the price, or what was chosen is not certain enough itself. Raises OutOfTimeError.
    """
    limit, problem, ours = holding_limit(sought.goal), sought.problem, choice.best
    if limit is None or not (choice.enough and choice.scenarios.is_drawn):
        return None
    deadline = deadline.or_after(LESS_MONEY_S, processor_s)
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
            return cheaper_record(sought, one.found, prices, values, held=one.held)
    return None
