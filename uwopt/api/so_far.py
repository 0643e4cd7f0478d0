"""Lines for who waits: what is known so far, and what is looked for next."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from uwopt.objectives.objective import Objective
from uwopt.quantities import AT_LIKELIEST
from uwopt.solvers.recommend import Sought
from uwopt.units import format_quantity, percent

if TYPE_CHECKING:
    from uwopt.api.recommendation import Recommendation

PRACTICE_LINE = "nothing meets all of good practice: what of it has to be relaxed is looked for"


def central_line(sought: Sought) -> str:
    """The best at likeliest values, where it is counted next how often hardware holds."""
    best, goal, mission = sought.outcome.best[0], sought.goal, sought.problem.mission
    value = goal.reported(best.minimised)
    parts = (part.id for part in sought.problem.parts.of(best).values())
    return f"best {AT_LIKELIEST}: {of_parts(parts, goal, value, mission.limits.currency)}"


def held_line(made: Recommendation) -> str:
    """How often what would be recommended holds, where practice may give way so that something does more often."""
    counted = made.counted
    assert counted is not None and not isinstance(counted.asked, str)
    return (
        f"best so far: {of_design(made)}; it holds in {percent(counted.held)} of the scenarios, "
        f"{100.0 * counted.asked:g} % are asked: something else may, with good practice relaxed further"
    )


def proven_line(made: Recommendation) -> str:
    """The recommendation in a line, for who waits for its doubts."""
    return f"proven best: {of_design(made)}"


def of_design(made: Recommendation) -> str:
    """What is recommended, and its objective."""
    parts = (part.id for part in made.design.hardware.named.values())
    return of_parts(parts, made.sought.goal, made.design.objective_value, made.mission.limits.currency)


def of_parts(ids: Iterable[str], goal: Objective, value: float | None, currency: str) -> str:
    """Hardware and its objective."""
    return f"{' + '.join(ids)}, {goal.name} {format_quantity(value, goal.unit(currency), 4)}"
