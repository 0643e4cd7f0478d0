"""Hardware with its outcomes in all scenarios, and which of it is best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.forward.problem import Problem
from uwopt.solvers.confidence.fixed import Settings
from uwopt.solvers.confidence.outcomes import Outcomes
from uwopt.solvers.exact.ranking import Found, told_apart
from uwopt.solvers.one_hardware import own_id, parts_of


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


def rank(one: Counted, share: float) -> tuple[Any, ...]:
    """Hardware that holds by its median; behind it, what holds most often. Of what is alike, the cheapest first."""
    holds, median = one.held >= share, one.quantile(0.5)
    median = float(told_apart(median)) if np.isfinite(median) else median
    return (not holds, median if holds else -one.held, one.outcomes.price)


def best_of(tried: Sequence[Counted], share: float) -> Counted | None:
    """The best of what was counted."""
    return min(tried, key=lambda one: rank(one, share), default=None)


def names(problem: Problem, found: Found) -> tuple[Any, ...]:
    """What tells one hardware from another."""
    ids = [own_id(part) for _, part in parts_of(problem, found)]
    return (*ids, found.count, found.landscape, found.lighting.mount)
