"""What a larger budget, more power or a larger battery would make certain, where nothing holds as often as asked."""

from __future__ import annotations

from dataclasses import replace

from uwopt.api.certainty import eased
from uwopt.api.counting import Counts
from uwopt.deadline import Deadline, OutOfTimeError, unheard
from uwopt.results.certainty import Confidence, WouldHold
from uwopt.solvers.confidence.changes import limits_of, with_limits_far, with_limits_raised
from uwopt.solvers.confidence.counted import Looked
from uwopt.solvers.confidence.search import Certain, count_near, look
from uwopt.solvers.recommend import Sought

RAISED_S = 4.0  # of work, where no time is given
SEARCH_SHARE = 0.7  # of it, for hardware that holds; the rest is for how little more it needs


def eased_or_raised(
    sought: Sought, counted: Confidence, choice: Certain, counts: Counts | None, deadline: Deadline
) -> Confidence:
    """What was counted, with what asked less would make it certain, or where nothing does, more of a limit.

    counts : all that was counted within the limits; None: nothing is told of these
    """
    known = eased(sought.problem, sought.goal, counted, choice, deadline)
    if known.would_hold or known.would_hold_else or counts is None:
        return known
    more, beyond = raised(counts.sought, counts.seen, deadline)
    return replace(known, would_hold_else=more, beyond_limits=beyond)


def raised(sought: Sought, seen: Looked, deadline: Deadline) -> tuple[list[WouldHold], float | None]:
    """Hardware that holds with a limit raised, each by as little as was found; else the most often that any holds.

    All limits are put far off together, and what is counted then is asked which of them it needs. Nothing is told where
    the mission sets no limit, or time does not reach.

    seen : what was counted within the limits
    """
    problem, goal = sought.problem, sought.goal
    if not limits_of(problem):
        return [], None
    patience = deadline.of_work(RAISED_S)
    mission = with_limits_far(problem)
    wider = problem.over(problem.parts, mission=mission, scenes=problem.scenes_for(mission))
    looking = patience.part(SEARCH_SHARE)
    try:
        found = Sought.of(sought.selection, wider, goal, top=sought.search.top, whole=True, deadline=looking)
        like = seen.scenarios.seen_by(mission, wider.scenes)
        known = [one.found for one in seen.ranked[:1]]
        there = look(found, seen.asked, looking, unheard, like=like, known=known)
        count_near(there, looking, 1.0)
    except OutOfTimeError:
        return [], None
    holding = [one for one in there.ranked if one.held >= there.share]
    if not holding:
        return [], there.held
    return with_limits_raised(problem, goal, holding, seen.scenarios, seen.share, patience), None
