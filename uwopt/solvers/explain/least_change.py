"""The least change of one requirement that makes a mission feasible, proven by searches.

A requirement that is dropped leaves a design that misses it by some amount, not by the least. The limit is drawn
towards what was asked: first with that design's hardware, which takes little time, then all hardware is searched
at a limit a little closer still. Where nothing fits there, the change is the least; else the next hardware is drawn
in likewise, and all hardware is searched half-way to what was asked.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from uwopt.deadline import NEVER, Deadline
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.one_hardware import problem_of
from uwopt.solvers.recommend import Sought, same_scenes

CLOSER = 0.02  # of a change: what is proven not to be enough is a change smaller by this share
DIGITS = 3  # of a limit, rounded away from what was asked: it can be typed as it stands
HALVINGS = 30
ROUNDS = 12  # each takes a search over all hardware


@dataclass(frozen=True)
class Change:
    """A limit with which the mission can be met, and the design that does."""

    limit: float
    found: Sought


def least_change(
    asked: float, reached: float, found: Sought, *, relaxed: Callable[[float], Mission],
    search: Callable[[Mission], Sought], deadline: Deadline, name: str,
) -> Change:  # fmt: skip
    """The limit nearest to what is asked with which something fits.

    Parameters
    ----------
    asked, reached : of the mission, and of a design found without the requirement
    relaxed : the mission with another limit
    search : over all hardware
    """
    change, too_near, share = with_its_hardware(asked, Change(reached, found), relaxed, deadline), asked, CLOSER
    for _ in range(ROUNDS):
        if deadline.passed():
            break
        step = change.limit + share * ((too_near if share > CLOSER else asked) - change.limit)
        closer = search(relaxed(step))
        if closer.outcome.best:  # not the least by far, it seems: halve what is left
            typed = Change(rounded_away(step, asked), closer)
            change, share = with_its_hardware(too_near, typed, relaxed, deadline), 0.5
        elif closer.outcome.complete:
            too_near, share = step, CLOSER
            if abs(too_near - change.limit) <= CLOSER * abs(asked - change.limit) * (1.0 + 1e-9):
                return change
        else:
            break
    deadline.left_out.append(f"whether less than that change of {name} would do")
    return change


def with_its_hardware(
    asked: float, change: Change, relaxed: Callable[[float], Mission], deadline: Deadline = NEVER
) -> Change:
    """The nearest limit that the hardware of a change can meet, to `DIGITS`, or as near as the time reaches."""
    far, near, found = change.limit, asked, change.found
    for _ in range(HALVINGS):
        step = rounded_away(0.5 * (far + near), asked)
        if deadline.passed() or not min(far, near) < step < max(far, near):
            break
        tried = same_hardware(found, relaxed(step))
        if tried.outcome.best:
            far, found = step, tried
        else:
            near = step
    return Change(far, found)


def rounded_away(value: float, asked: float) -> float:
    """A limit with few digits, no nearer to what is asked."""
    if value == 0.0 or not math.isfinite(value):
        return value
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - DIGITS + 1)
    steps = math.ceil(value / unit - 1e-9) if value > asked else math.floor(value / unit + 1e-9)
    return float(f"{steps * unit:.{DIGITS}g}")


def same_hardware(found: Sought, mission: Mission) -> Sought:
    """The best settings of a design's hardware for a mission."""
    scenes = same_scenes(found.problem, mission)
    problem = problem_of(found.problem, found.outcome.best[0], mission=mission, scenes=scenes)
    search = Search(problem, Objective.of("power"), top=1)
    return Sought(found.selection, problem, search, search.run())
