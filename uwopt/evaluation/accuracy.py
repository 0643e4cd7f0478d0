"""How far reported figures are from what finer integrals would give, and how coarse integrals may be.

Each part of the numerics (`model.fineness`) is taken twice as finely, one at a time. A figure's error is
estimated as

    error = SAFETY * sum over parts of |change| / |value| + FLOOR

Where an error falls with the step's order p, the change is 1 - 2^-p of it: SAFETY = 2 covers p = 1 and all
above. What no part makes finer, tables of phase functions and measured beams, is in the floor.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from uwopt.model.fineness import DEFAULT, Fineness
from uwopt.results.design import Design
from uwopt.units import is_number

Evaluate = Callable[[Fineness], Design]

SAFETY = 2.0
FLOOR = 1e-5  # look-up tables of phase functions, beams and lateral colour
ROUNDING = 1e-12  # of what is a formula, and of all figures in physics `paper` beside the spectrum
UNCHANGED = 1e-14  # a smaller change is rounding
COARSEST, FINEST = 0.5, 4.0
LEAST_ROOM = 0.1  # of a tolerance, for what can be made finer, where the floor leaves less
MOST_ROUNDS = 12  # of the search for the cheapest fineness: every part can go up its whole ladder
PAPER_PARTS = ("spectrum",)
OBJECTIVE = ("", "objective")  # in place of scene and figure
AS_DECIBELS = ("_db", "_db_p05", "_db_min", "_db_centre")
BELL_PER_NEPER = math.log(10.0) / 20.0  # relative change of a ratio for 1 dB


@dataclass(frozen=True)
class Accuracy:
    """Estimated errors of one design's figures."""

    fineness: Fineness
    figures: dict[str, dict[str, float]]  # by scene and figure, relative
    objective: float | None  # of its value; None where the design is not feasible at both finenesses
    by_part: dict[str, dict[str, Any]]  # largest error that each part makes, and of which figure
    floor: float  # of every figure that an integral enters, in `figures`

    @property
    def largest(self) -> dict[str, Any]:
        """The figure that is known least well."""
        every = [
            {"scene": scene, "figure": name, "error_rel": error}
            for scene, figures in self.figures.items()
            for name, error in figures.items()
        ]
        return max(every, key=lambda item: item["error_rel"], default={"error_rel": 0.0})

    def meets(self, tolerance: float) -> bool:
        """Whether every figure's estimated error is within a tolerance."""
        return bool(self.largest["error_rel"] <= tolerance)

    def as_dict(self) -> dict[str, Any]:
        """For a result."""
        return {
            "figures": self.figures,
            "objective": self.objective,
            "largest": self.largest,
            "by_part": self.by_part,
            "method": f"each integral once more with twice the nodes; {SAFETY:g} times the sum of the changes"
            + (f", and {self.floor:g} for look-up tables" if self.floor else ""),
        }


def parts_that_count(*, paper: bool, sunlit: bool) -> tuple[str, ...]:
    """Parts of the numerics that can change a figure at all."""
    if paper:
        return PAPER_PARTS
    return tuple(name for name in Fineness.names() if name != "sun" or sunlit)


class Estimator:
    """Errors of one design, evaluated again at other finenesses; each of them once."""

    def __init__(self, evaluate: Evaluate, *, paper: bool, sunlit: bool):
        self._evaluate = evaluate
        self.parts = parts_that_count(paper=paper, sunlit=sunlit)
        self.floor = 0.0 if paper else FLOOR
        self._known: dict[Fineness, Design] = {}

    def design(self, fineness: Fineness) -> Design:
        """The design at a fineness."""
        if fineness not in self._known:
            self._known[fineness] = self._evaluate(fineness)
        return self._known[fineness]

    def errors(self, fineness: Fineness = DEFAULT) -> Accuracy:
        """Estimated errors at a fineness."""
        base = self.design(fineness)
        changes = {part: changes_of(base, self.design(fineness.finer([part]))) for part in self.parts}
        figures: dict[str, dict[str, float]] = {}
        for scene in base.scenes:
            figures[scene.name] = {}
            for name, value in scene.figures.items():
                if is_number(value):
                    moved = [changes[part].get((scene.name, name), 0.0) for part in self.parts]
                    figures[scene.name][name] = self.claimed(moved, fineness)
        objective = [changes[part].get(OBJECTIVE, 0.0) for part in self.parts]
        told = all(self.design(fineness.finer([part])).objective_value is not None for part in self.parts)
        return Accuracy(
            fineness,
            figures,
            self.claimed(objective, fineness) if told and base.objective_value is not None else None,
            {part: worst_of(changes[part]) for part in self.parts},
            self.floor_at(fineness),
        )

    def claimed(self, changes: Sequence[float], fineness: Fineness) -> float:
        """The error that is claimed for these changes."""
        total = sum(changes)
        return SAFETY * total + self.floor_at(fineness) + ROUNDING if total > UNCHANGED else ROUNDING

    def floor_at(self, fineness: Fineness) -> float:
        """What look-up tables leave; more where a coarse grid of wavelengths steps over their entries."""
        return self.floor * max(1.0, fineness.spectrum**-2.0)

    def cheapest(self, tolerance: float, start: Fineness) -> Accuracy:
        """The coarsest fineness, part by part, whose estimated errors are within a tolerance; or the finest.

        From `start` up: as long as the tolerance is missed, parts that make more than their share of the
        error are taken twice as finely, at least the part that makes most of it.
        """
        found = self.errors(start)
        for _ in range(MOST_ROUNDS):
            open_parts = [part for part in self.parts if getattr(found.fineness, part) < FINEST]
            if found.meets(tolerance) or not open_parts:
                break
            room = LEAST_ROOM * max(tolerance, self.floor)
            share = max(tolerance - self.floor, room) / len(self.parts)
            made = {part: found.by_part[part]["error_rel"] for part in open_parts}
            if sum(made.values()) < room:
                break  # what is left does not come from integrals
            raised = [part for part in open_parts if made[part] > share] or [max(made, key=lambda p: made[p])]
            found = self.errors(found.fineness.finer(raised))
        return found


def coarsest(parts: Sequence[str]) -> Fineness:
    """Where the search for the cheapest fineness begins."""
    return replace(DEFAULT, **dict.fromkeys(parts, COARSEST))


def changes_of(base: Design, finer: Design) -> dict[tuple[str, str], float]:
    """Relative change of each figure, by scene and name, and of the objective under `OBJECTIVE`."""
    found = {
        (one.name, name): relative_change(name, value, other.figures[name])
        for one, other in zip(base.scenes, finer.scenes, strict=True)
        for name, value in one.figures.items()
        if is_number(value)
    }
    if base.objective_value is not None:
        found[OBJECTIVE] = relative_change("", base.objective_value, finer.objective_value)
    return found


def relative_change(name: str, value: float, other: Any) -> float:
    """|other - value| / |other|; decibels as the ratio they stand for. A figure that appears or goes: 1."""
    if not is_number(other):
        return 1.0
    if name.endswith(AS_DECIBELS):
        return abs(other - value) * BELL_PER_NEPER
    if other == value:
        return 0.0
    return abs(other - value) / max(abs(other), abs(value))


def worst_of(changes: Mapping[tuple[str, str], float]) -> dict[str, Any]:
    """Largest error among changes, with its scene and figure."""
    of_figures = {key: change for key, change in changes.items() if key != OBJECTIVE}
    key = max(of_figures, key=lambda k: of_figures[k], default=("", ""))
    return {"error_rel": SAFETY * of_figures.get(key, 0.0), "scene": key[0], "figure": key[1]}
