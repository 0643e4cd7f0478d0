"""Systems that estimates cannot tell apart from the recommendation: which of them is better is a toss.

A runner-up is one of them where each lies within the other's range: the runner-up is no worse than the recommendation
may turn out by what is estimated of the parts that differ, and may itself turn out no worse than the recommendation.
What both are made of moves both alike, and stays as it is.

Where the recommendation was chosen over scenarios, these tell instead: of the runners-up those are equal that were
counted, hold as often as is asked, and whose median is as good but for luck.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.one_hardware import best_of, own_id, parts_of, problem_of
from uwopt.solvers.part_ends import at_end, housing_at_end
from uwopt.solvers.recommend import Sought
from uwopt.solvers.settings.best import scenes_need_cells
from uwopt.tolerances import TIE

LONGEST_S = 1.5  # for all of them: those that are not reached by then are left out
UNREACHED = "whether some of the runners-up are equal within the estimates"


def equals(
    sought: Sought, deadline: Deadline = NEVER,
    tied: Callable[[Found], bool] | None = None,
) -> list[dict[str, Any]]:
    """Runners-up that cannot be told from the first, by their place in the result, with their ranges.

    tied : tells of hardware whether the scenarios cannot, where the first was chosen over these
    """
    objective = sought.goal
    winner, *others = sought.outcome.best
    if tied is not None:
        return [
            {"runner_up": place, **dict.fromkeys(("value", "best", "recommendation_at_worst"))}
            for place, other in enumerate(others)
            if tied(other)
        ]
    patience, found = deadline.at_most(LONGEST_S), list[dict[str, Any]]()
    try:
        for place, other in enumerate(others):
            ends = ends_if_equal(sought.problem, winner, other, objective, patience)
            if ends is not None:
                told = {name: objective.reported(end) if math.isfinite(end) else None for name, end in ends.items()}
                found.append({"runner_up": place, **told})
    except OutOfTimeError:
        deadline.left_out.append(UNREACHED)
    return found


def ends_if_equal(
    problem: Problem, winner: Found, other: Found, objective: Objective, patience: Deadline
) -> dict[str, float] | None:
    """A runner-up's value and best end, and the worst of the first, where they cannot be told apart."""
    own, slow = dict(parts_of(problem, winner)), scenes_need_cells(problem.scenes, objective)
    differing = [kind for kind, part in parts_of(problem, other) if own_id(part) != own_id(own[kind])]
    tied = other.minimised - winner.minimised <= TIE * abs(winner.minimised)
    if not differing or (slow and not tied):
        return None
    patience.check()
    worst = winner.minimised if slow else with_ends(problem, winner, other, differing, "bad", objective, patience)
    best = other.minimised if slow else with_ends(problem, other, winner, differing, "good", objective, patience)
    if tied or (other.minimised <= worst and best <= winner.minimised):
        return {"value": other.minimised, "best": best, "recommendation_at_worst": worst}
    return None


def with_ends(
    problem: Problem, own: Found, other: Found, differing: list[str], end: str, objective: Objective, deadline: Deadline
) -> float:  # fmt: skip
    """Best objective of a design whose parts of these kinds are at one end of their estimates; inf: infeasible."""
    parts, against = dict(parts_of(problem, own)), dict(parts_of(problem, other))
    lists: dict[str, list[Any]] = {}
    for kind in differing:
        part: Any = parts[kind]
        alike = kind == "port" and part.id == against[kind].id  # another housing alone
        lists[kind] = [housing_at_end(part, end) if alike else at_end(part, end)]
    return best_of(problem_of(problem, own, lists=lists), objective, deadline)
