"""What is to be best: one figure, a weighted sum of figures, or the best image for its price; less is better."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.errors import MissionError
from uwopt.quantities import TERMS

UNITS = {term: one.unit for term, one in TERMS.items()}
MAXIMISED = tuple(term for term, one in TERMS.items() if one.better == "more")
BEST_IMAGE = "best_image"
LEAST = 1e-300  # of a figure whose logarithm counts
MOST_SNR_DB = 200.0  # that no design exceeds: that of 10^20 electrons a pixel


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

    @staticmethod
    def at_best(
        power: Array, cost: Array, mass: Array, gsd_mm: Array, information: Array | float = np.inf
    ) -> Terms:  # fmt: skip
        """Those that no light betters, nor any setting; `information`: that nothing in reach exceeds."""
        return Terms(power, cost, mass, np.full(np.shape(power), MOST_SNR_DB), gsd_mm, 1.0, information)


@dataclass(frozen=True)
class Objective:
    """Weights by term; every term in its unit.

    `quality` names the figure that counts by its logarithm where the image is to be best for its price: then power
    and cost have prices in e-folds of it, and the value is that figure with its price taken off.
    """

    weights: Mapping[str, float]
    quality: str = ""

    @staticmethod
    def of(wanted: str | Mapping[str, float]) -> Objective:
        """The objective a mission names."""
        weights = {wanted: 1.0} if isinstance(wanted, str) else dict(wanted)
        unknown = [name for name in weights if name not in UNITS]
        if unknown:
            raise MissionError(f"objective: {', '.join(unknown)} is not one of {', '.join(UNITS)}")
        return Objective(weights)

    @staticmethod
    def best_image(quality: str, *, per_w: float, per_money: float) -> Objective:
        """The most of `information` or `snr_db`, where each watt and each unit of money must buy a share of it.

            minimise  -ln Q + P ln(1 + g_P) + C ln(1 + g_C)

        At the optimum nothing in reach has more than (1 + g_P)^dP (1 + g_C)^dC times its Q for dP more watts and dC
        more money: whatever had would have a smaller sum.
        """
        weights = {quality: math.log(10.0) / 20.0 if quality == "snr_db" else 1.0}
        weights |= {"power": math.log1p(per_w), "cost": math.log1p(per_money)}
        return Objective({name: weight for name, weight in weights.items() if weight}, quality)

    @property
    def by_ratio(self) -> bool:
        """Whether information counts by its logarithm; decibels are one already."""
        return self.quality == "information"

    @property
    def name(self) -> str:
        """As the mission writes it."""
        if self.quality:
            return BEST_IMAGE
        if self.single:
            return self.single
        return " + ".join(f"{weight:g} {name}" for name, weight in self.weights.items())

    @property
    def single(self) -> str | None:
        """The only term, if there is one."""
        return next(iter(self.weights)) if len(self.weights) == 1 and not self.quality else None

    @property
    def direction(self) -> str:
        """minimise or maximise."""
        return "maximise" if self.quality or self.single in MAXIMISED else "minimise"

    def unit(self, currency: str) -> str:
        """Unit of the reported value; a sum has none, nor has a signal to noise that counts as a ratio."""
        if self.quality:
            return UNITS[self.quality] if self.by_ratio else ""
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
                total = total + sign * weight * self.counted(name, getattr(terms, name))
        return total

    def counted(self, name: str, figure: Any) -> Any:
        """A figure as its weight takes it: itself, or its logarithm."""
        return np.log(np.maximum(figure, LEAST)) if self.by_ratio and name == "information" else figure

    def constant(self, terms: Terms) -> Array:
        """What no image adds to the value, (n,): that of designs with an SNR of 0 dB and no information."""
        return self.cost_to_minimise(replace(terms, information=1.0 if self.by_ratio else 0.0))

    def minimised(self, reported: float) -> float:
        """The value that solvers minimise, from the value as the mission reads it."""
        if self.quality:
            return -math.log(max(reported, LEAST))
        if self.single is None:
            return reported
        return self.weights[self.single] * (-reported if self.single in MAXIMISED else reported)

    def reported(self, minimised: float) -> float:
        """The value as the mission reads it: a maximised figure is not negated."""
        if self.quality:
            return math.exp(min(-minimised, 700.0))
        if self.single is None:
            return minimised
        value = minimised / self.weights[self.single] if self.weights[self.single] else 0.0
        return -value if self.single in MAXIMISED else value

    def told(self, minimised: float) -> float | None:
        """The same where it is finite; None where no design has it."""
        return self.reported(minimised) if math.isfinite(minimised) else None

    def step(self, share: float, minimised: float) -> float:
        """By how much what is minimised falls when the value gets better by a share of itself."""
        return math.log1p(share) if self.quality else share * abs(minimised)

    def share(self, step: float, minimised: float) -> float:
        """The share by which the value gets better when what is minimised falls by a step."""
        return math.expm1(min(step, 700.0)) if self.quality else step / max(abs(minimised), LEAST)

    def amount(self, step: float, minimised: float) -> float:
        """The same in the unit of the value."""
        return self.reported(minimised) * self.share(step, minimised) if self.quality else step

    def scale(self, minimised: Array) -> Array:
        """What a relative gap is relative to, (n,)."""
        return np.ones_like(minimised) if self.quality else np.abs(minimised)
