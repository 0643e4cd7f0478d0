"""What is to be best: one figure, or a weighted sum of figures, turned so that less is better."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.errors import MissionError
from uwopt.quantities import TERMS

Array = NDArray[Any]

UNITS = {term: one.unit for term, one in TERMS.items()}
MAXIMISED = tuple(term for term, one in TERMS.items() if one.better == "more")


@dataclass(frozen=True)
class Terms:
    """The figures that objectives are made of, of n designs; the worst scene counts."""

    power: Array
    cost: Array
    mass: Array
    snr_db: Array
    gsd_mm: Array
    contrast: Array | float = 0.0  # these two only where an objective asks for them
    information: Array | float = 0.0


@dataclass(frozen=True)
class Objective:
    """Weights by term; every term in its unit."""

    weights: Mapping[str, float]

    @staticmethod
    def of(wanted: str | Mapping[str, float]) -> Objective:
        """The objective a mission names."""
        weights = {wanted: 1.0} if isinstance(wanted, str) else dict(wanted)
        unknown = [name for name in weights if name not in UNITS]
        if unknown:
            raise MissionError(f"objective: {', '.join(unknown)} is not one of {', '.join(UNITS)}")
        return Objective(weights)

    @property
    def name(self) -> str:
        """As the mission writes it."""
        if self.single:
            return self.single
        return " + ".join(f"{weight:g} {name}" for name, weight in self.weights.items())

    @property
    def single(self) -> str | None:
        """The only term, if there is one."""
        return next(iter(self.weights)) if len(self.weights) == 1 else None

    @property
    def direction(self) -> str:
        """minimise or maximise."""
        return "maximise" if self.single in MAXIMISED else "minimise"

    def unit(self, currency: str) -> str:
        """Unit of the reported value; a sum has none."""
        if self.single is None:
            return ""
        return currency if self.single == "cost" else UNITS[self.single]

    def weight(self, name: str) -> float:
        """Weight of a term, 0 when it does not count."""
        return float(self.weights.get(name, 0.0))

    def cost_to_minimise(self, terms: Terms) -> Array:
        """The value that searches minimise, (n,)."""
        total = np.zeros(np.shape(terms.power))
        for name, weight in self.weights.items():
            sign = -1.0 if name in MAXIMISED else 1.0
            if weight:
                total = total + sign * weight * getattr(terms, name)
        return total

    def minimised(self, reported: float) -> float:
        """The value that solvers minimise, from the value as the mission reads it."""
        if self.single is None:
            return reported
        return self.weights[self.single] * (-reported if self.single in MAXIMISED else reported)

    def reported(self, minimised: float) -> float:
        """The value as the mission reads it: a maximised figure is not negated."""
        if self.single is None:
            return minimised
        value = minimised / self.weights[self.single] if self.weights[self.single] else 0.0
        return -value if self.single in MAXIMISED else value
