"""What a design of a weaker mission reaches of what the mission itself asks."""

from __future__ import annotations

from collections.abc import Collection

from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import ToBeMade
from uwopt.deadline import Deadline
from uwopt.evaluation.design import evaluate_design
from uwopt.mission.mission import Mission
from uwopt.mission.weakened import RELAXABLE
from uwopt.objectives.objective import Objective
from uwopt.results.design import Design
from uwopt.solvers.one_hardware import problem_of
from uwopt.solvers.recommend import Sought, seek
from uwopt.solvers.settable.rounding import given_of

UNKNOWN = 1e9  # how far a limit is missed, where that cannot be said


def judged_by(mission: Mission, found: Sought, objective: Objective) -> Design:
    """The best design of a relaxed search, judged by the mission as it stands: what it misses shows."""
    best = found.outcome.best[0]
    problem = problem_of(found.problem, best, mission=mission)
    hardware = best.hardware.alone
    return evaluate_design(problem, hardware, given_of(problem, hardware, best.settings), objective)


def missed_by(design: Design, names: Collection[str]) -> set[str]:
    """Those requirements that a design does not meet."""
    missed = {margin.requirement for margin in design.missed}
    return {name for name in names if RELAXABLE[name].key in missed or name in missed}


def deepest(
    found: Sought, mission: Mission, catalog: Catalog, goal: Objective, *, generic: ToBeMade, deadline: Deadline
) -> Sought:
    """Of designs whose parts are not rated deep enough, one whose are rated deepest."""
    while (rated := rated_depth(found)) is not None and not deadline.passed():
        deeper = seek(
            mission, catalog, goal, generic=generic, depth_m=rated * (1 + 1e-6), deadline=deadline,
            like=found.problem, whole=True,
        )  # fmt: skip
        if not deeper.outcome.best or (rated_depth(deeper) or 0.0) <= rated:
            break
        found = deeper
    return found


def rated_depth(found: Sought) -> float | None:
    """Depth that the relaxed design's parts are rated for; None where it is unknown."""
    best, parts = found.outcome.best[0], found.problem.parts
    port = parts.ports[best.port]
    ratings = [port.depth_rating_m, parts.lights[best.light].depth_rating_m]
    ratings += [] if port.housing is None else [port.housing.depth_rating_m]
    known = [rating for rating in ratings if rating is not None]
    return min(known) if len(known) == len(ratings) else None


def reached_value(design: Design, key: str) -> float | None:
    """What the design reaches of a requirement, at its worst over altitudes and scenes."""
    found = [one for one in design.margins if one.requirement == key]
    values = [one.value for one in found if one.value is not None]
    if not values:
        return None
    return min(values) if found[0].sense == ">=" else max(values)


def miss(limit: float | None, needed: float | None) -> float:
    """How far a limit is missed, relative; large when it cannot be said."""
    if limit is None or needed is None:
        return UNKNOWN
    return abs(needed - limit) / max(abs(limit), 1e-12)
