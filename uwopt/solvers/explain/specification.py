"""What a part must fulfil to stand in a system: limits of one property at a time, with all settings chosen anew, and
how the camera is turned where the mission leaves that open.

From the optimum each number of a part of which more or less favours a design is made worse in steps, many at once,
until no settings meet the mission (limit of feasibility) or until the system is no better than the best other one
(limit of staying best); then bisected. Of a number of which neither end is the better one, such as a focal length, both
ends are sought. What holds one by one need not hold together: all numbers of a part are moved
towards their limits of feasibility by a common share, and the largest share at which settings are found is told beside;
numbers with two ends are tried at each of them with each of the others'.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.parts.kinds import ALL_FIELDS, FAVOURED
from uwopt.catalog.records import OF_A_DESIGN, Part, Quantity, exact
from uwopt.forward.designs import Hardware
from uwopt.forward.problem import Problem
from uwopt.model.bisection import bisected
from uwopt.objectives.objective import Objective
from uwopt.solvers.one_hardware import best_of_each, problem_of

FARTHEST, STEPS = 100.0, 7  # how much worse is tried: a factor; a share comes down to a hundredth
HALVINGS = 10  # of a step: a limit to a thousandth
FINER = 1e-9  # relative: what is better by less is not
#: Numbers of which a mission needs enough and bears only so much: fine and wide, bright and even.
BOTH_ENDS = frozenset({
    "pixel_pitch_um", "resolution_x_px", "resolution_y_px", "focal_length_mm", "outer_radius_mm", "beam_angle_deg",
})  # fmt: skip
GIVEN = ("refractive_index",)  # by the material
INSIDE = 0.01  # of a range whose end is not of it
RANGES = {field.name: field.cell.within for field in ALL_FIELDS if field.name in {*FAVOURED, *BOTH_ENDS}}
SHARES = 8  # halvings of the common share


@dataclass(frozen=True)
class PropertyLimit:
    """One number of a part: what it is, which way is worse, and how bad it may become; of two ends, one of them.

    `feasible`, `best` : the last value at which settings meet the mission, and at which the system stays the best; None
    where as bad as was tried still does. `together` : a value that all numbers of the part may have at once; None of
    one that may be as bad as was tried.
    """

    kind: str
    name: str
    value: float
    more_is_better: bool
    feasible: float | None
    best: float | None
    together: float | None


@dataclass(frozen=True)
class Asked:
    """A number of a part that is to be made worse."""

    name: str
    value: float
    sign: int  # +1: more is better


def specification(
    problem: Problem, hardware: Hardware, objective: Objective, kind: str, rival: float
) -> list[PropertyLimit]:
    """Limits of the numbers of one part, each alone, and together; none where it does not fit as it is.

    rival : the minimised objective of the best system with other parts; inf where there is none
    """
    trial = PartTrial(problem, hardware, objective, kind)
    if not holds(trial.values([{}])[0], math.inf):
        return []
    asked = properties(trial.part)
    feasible, best = trial.limits(asked, (math.inf, rival))
    together = trial.together(asked, feasible)
    return [
        PropertyLimit(kind, one.name, one.value, one.sign > 0, alone, stays, None if alone is None else own)
        for one, alone, stays, own in zip(asked, feasible, best, together, strict=True)
        if alone is not None or stays is not None
    ]


def properties(part: Part) -> list[Asked]:
    """Numbers of a part that a design depends on, twice where both ends matter; what is 0, not known, or no maker's to
    choose apart."""
    found = []
    for field in fields(part):
        value = getattr(part, field.name)
        signs = (1, -1) if field.name in BOTH_ENDS else (FAVOURED.get(field.name, 0),)
        number = value.value if isinstance(value, Quantity) else value
        if any(signs) and field.name not in GIVEN and isinstance(number, (int, float)) and number > 0.0:
            found += [Asked(field.name, float(number), sign) for sign in signs]
    return found


class PartTrial:
    """One part of a system in many variants: the best objective that settings give each."""

    def __init__(self, problem: Problem, hardware: Hardware, objective: Objective, kind: str):
        self.base, self.hardware, self.objective, self.kind = problem, hardware, objective, kind
        self.part = problem.parts.of(hardware)[kind]

    def values(self, variants: Sequence[dict[str, float]]) -> list[float]:
        """Best minimised objective of each variant of the part's numbers; inf where no settings do."""
        made = [changed(self.part, variant) for variant in variants]
        one = problem_of(self.base, self.hardware, lists={self.kind: made})
        places = [dict.fromkeys(OF_A_DESIGN, 0) | {self.kind: n} for n in range(len(made))]
        return best_of_each(one, self.objective, places)

    def limits(self, asked: Sequence[Asked], rivals: Sequence[float]) -> list[list[float | None]]:
        """For each rival, the last value of each number, made worse alone, at which the objective is still better."""
        steps = np.linspace(0.0, math.log(FARTHEST), STEPS + 1)[1:]
        ladder = self.values([{one.name: worse(one, step)} for one in asked for step in steps])
        by_number = np.array(ladder).reshape(len(asked), STEPS)
        open_, bad = [], []
        for which, rival in enumerate(rivals):
            for n, values in enumerate(by_number):
                first = next((step for step, value in zip(steps, values, strict=True) if not holds(value, rival)), None)
                if first is not None:
                    open_.append((which, n))
                    bad.append(first)

        def still_better(steps: Array) -> list[bool]:
            found = self.values([{asked[n].name: worse(asked[n], s)} for (_, n), s in zip(open_, steps, strict=True)])
            return [holds(value, rivals[which]) for (which, _), value in zip(open_, found, strict=True)]

        starts, _ = bisected(still_better, np.array(bad) - steps[0], np.array(bad), steps=HALVINGS)
        made: list[list[float | None]] = [[None] * len(asked) for _ in rivals]
        for (which, n), step in zip(open_, starts, strict=True):
            made[which][n] = worse(asked[n], float(step))
        return made

    def together(self, asked: Sequence[Asked], limits: Sequence[float | None]) -> list[float]:
        """Values that all numbers may have at once: a common share of the way to each one's limit."""

        def at(share: float) -> list[float]:
            ends = [one.value if end is None else end for one, end in zip(asked, limits, strict=True)]
            return [one.value * (end / one.value) ** share for one, end in zip(asked, ends, strict=True)]

        def all_hold(share: float) -> bool:
            return all(holds(value, math.inf) for value in self.values(corners(asked, at(share))))

        return at(1.0 if all_hold(1.0) else float(bisected(all_hold, 0.0, 1.0, steps=SHARES)[0]))


def corners(asked: Sequence[Asked], values: Sequence[float]) -> list[dict[str, float]]:
    """Every choice of an end of each number, where it has two, with all others."""
    ends: dict[str, list[float]] = {}
    for one, value in zip(asked, values, strict=True):
        ends.setdefault(one.name, []).append(value)
    return [dict(zip(ends, choice, strict=True)) for choice in product(*ends.values())]


def worse(one: Asked, step: float) -> float:
    """A number made worse by a step, the logarithm of a factor; it stays within what may be stated of a part."""
    value, within = one.value * math.exp(-one.sign * step), RANGES[one.name]
    high = within.high * (1.0 - INSIDE if within.open_high else 1.0)
    low = within.low * (1.0 + INSIDE if within.open_low else 1.0)
    return max(min(value, high), low)


def holds(value: float, rival: float) -> bool:
    """Whether a system still does: with some settings, and better than its rival."""
    return math.isfinite(value) and (math.isinf(rival) or value <= rival - FINER * abs(rival))


def changed(part: Any, numbers: dict[str, float]) -> Any:
    """A part with other numbers, each as sure as it can be."""
    made: dict[str, Any] = {}
    for name, value in numbers.items():
        old = getattr(part, name)
        made[name] = exact(value, old.status, old.source) if isinstance(old, Quantity) else type(old)(value)
    return replace(part, **made)
