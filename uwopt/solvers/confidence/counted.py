"""Hardware with its outcomes in all scenarios, and which of it is best."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from uwopt.deadline import NEVER, Deadline
from uwopt.forward.problem import Problem
from uwopt.mission.doubt import ENDS
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.fixed import Settings
from uwopt.solvers.confidence.outcomes import Outcomes, outcomes_of_each
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.exact.ranking import Found, ids_in, told_apart


@dataclass(frozen=True)
class Counted:
    """One hardware with its outcomes, at the stop that is best for the confidence asked for."""

    found: Found
    outcomes: Outcomes
    stop: int

    @property
    def held(self) -> float:
        """Share of the scenarios in which it holds."""
        return float(self.outcomes.held[self.stop])

    @property
    def f_number(self) -> float | None:
        """Where the iris stands; None where it is moved at sea."""
        number = float(self.outcomes.f_numbers[self.stop])
        return number if np.isfinite(number) else None

    @property
    def settings(self) -> Settings | None:
        """What is set in each scene, where that is fixed before the water is seen."""
        return self.outcomes.fixed[self.stop] if self.outcomes.fixed else None

    def quantile(self, share: float) -> float:
        """Minimised objective that it keeps or betters in so many scenarios; inf where it does not hold in as many."""
        return float(self.outcomes.quantile(share)[self.stop])


@dataclass(frozen=True)
class Looked:
    """Hardware of a problem that is counted in scenarios; nothing is compared or proven yet."""

    problem: Problem
    objective: Objective
    asked: float | str
    scenarios: Scenarios
    tried: list[Counted]
    complete: bool = True  # whether there was time for every search
    fits: dict[float, bool] = field(default_factory=dict)  # whether anything does with numbers worse than in so many
    held_again: dict[int, float] = field(default_factory=dict)  # share of further scenarios, by the id of the outcomes

    @property
    def share(self) -> float:
        """Of the scenarios, that is asked for."""
        return 1.0 if self.asked == ENDS else float(self.asked)

    @property
    def held(self) -> float:
        """The greatest share in which any holds."""
        return max((one.held for one in self.tried), default=0.0)

    @property
    def holding(self) -> int:
        """How many hold as often as asked."""
        return sum(one.held >= self.share for one in self.tried)

    @property
    def ranked(self) -> list[Counted]:
        """What was counted, the best first."""
        return sorted(self.tried, key=lambda one: rank(one, self.share))

    @property
    def best(self) -> Counted | None:
        """The best of it."""
        return best_of(self.tried, self.share)

    def count(self, some: Sequence[Found], deadline: Deadline = NEVER) -> None:
        """Count more hardware in all scenarios. Raises OutOfTimeError."""
        made = outcomes_of_each(self.problem, some, self.objective, self.scenarios, deadline) if some else []
        self.tried.extend(Counted(found, one, one.best(self.share)) for found, one in zip(some, made, strict=True))


def rank(one: Counted, share: float) -> tuple[Any, ...]:
    """Hardware that holds by its median; behind it, what holds most often. Of what is alike, the cheapest first."""
    holds, median = one.held >= share, one.quantile(0.5)
    median = float(told_apart(median)) if np.isfinite(median) else median
    return (not holds, median if holds else -one.held, one.outcomes.price)


def best_of(tried: Sequence[Counted], share: float) -> Counted | None:
    """The best of what was counted."""
    return min(tried, key=lambda one: rank(one, share), default=None)


def by_names(problem: Problem, some: Iterable[Found], had: Collection[Any] = ()) -> dict[Any, Found]:
    """Hardware by what tells it apart, without what was had."""
    return {name: one for one in some if (name := names(problem, one)) not in had}


def names(problem: Problem, found: Found) -> tuple[Any, ...]:
    """What tells one hardware from another."""
    return (*ids_in(problem.parts, found), found.count, found.landscape, found.lighting.mount)
