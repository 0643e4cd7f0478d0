"""What is known of missions that differ in what is sure to ask for more: bounds, what meets them, and what does not.

Whatever contradicts a proof is a defect and no answer: what something reaches in a mission holds in all that ask for
less, and what nothing betters there is bettered by nothing where more is asked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from uwopt.errors import SolverError
from uwopt.mission.mission import Mission
from uwopt.mission.strictness import Asking
from uwopt.objectives.objective import Objective
from uwopt.solvers.recommend import Sought
from uwopt.solvers.warm.kept import KeptBounds
from uwopt.tolerances import AGREES_REL

LEAST_GUESS, MOST_GUESS = 0.02, 0.15  # by which share the optimum is worse than that of a weaker mission, it is guessed
MOST_BOUNDS = 12  # of one family
MOST_SHOWN = 64  # values of a family that what is proven is held against


class Met(NamedTuple):
    """A mission that something meets."""

    asks: Asking
    mission: Mission
    minimised: float  # the optimum
    lower_bound: float  # that is proven


@dataclass
class Family:
    """What is known of missions that differ in what is sure to ask for more, of the same parts."""

    bounds: list[tuple[Asking, KeptBounds]] = field(default_factory=list)
    met: list[Met] = field(default_factory=list)
    missed: list[Asking] = field(default_factory=list)  # by everything
    shown: list[tuple[Asking, float]] = field(default_factory=list)  # values that something reaches
    waiting: tuple[Asking, Sought] | None = None  # a search whose bounds are not taken yet
    share: float = MOST_GUESS  # by which the next optimum is guessed to be worse than that of a weaker mission

    def learn(self, goal: Objective, weaker: Met, reached: float) -> None:
        """Guess the next step as twice the last."""
        seen = goal.share(max(reached - weaker.minimised, 0.0), weaker.minimised)
        self.share = min(max(2.0 * seen, LEAST_GUESS), MOST_GUESS)

    def nearest_met(self, asks: Asking) -> Met | None:
        """Of the missions that ask for no more the one whose optimum is the worst."""
        weaker = [one for one in self.met if one.asks.asks_no_more(asks)]
        return max(weaker, key=lambda one: one.minimised, default=None)

    def show(self, goal: Objective, asks: Asking, reached: float) -> None:
        """Something reaches a value in a mission; raises SolverError where nothing should in one that asks for less."""
        if any(one.asks.asks_no_more(asks) and is_below(goal, reached, one.lower_bound) for one in self.met):
            raise SolverError(contradiction(goal, reached))
        self.shown = [*self.shown[1 - MOST_SHOWN :], (asks, reached)]

    def prove(self, goal: Objective, asks: Asking, lower_bound: float) -> None:
        """Nothing is better in a mission; raises SolverError where something is, in that or one that asks for more."""
        for stricter, reached in self.shown:
            if asks.asks_no_more(stricter) and is_below(goal, reached, lower_bound):
                raise SolverError(contradiction(goal, reached))

    def keep(self, asks: Asking, kept: KeptBounds) -> None:
        """Further bounds; of many the first and the last few stay."""
        self.bounds.append((asks, kept))
        if len(self.bounds) > MOST_BOUNDS:
            del self.bounds[1]


def is_below(goal: Objective, value: float, bound: float) -> bool:
    """Whether a value is below a bound by more than two ways of computing it differ."""
    if math.isinf(bound):
        return value < bound
    return goal.share(max(bound - value, 0.0), bound) > AGREES_REL


def contradiction(goal: Objective, reached: float) -> str:
    """What to say where a search that was helped by others has missed something."""
    return (
        f"something reaches {goal.reported(reached):.9g} that a search which used bounds of other missions has missed; "
        "this is a defect of uwopt"
    )
