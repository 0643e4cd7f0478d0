"""Objectives of the user's own: a Python function of figures, for many designs at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.records import OF_A_DESIGN
from uwopt.errors import MissionError
from uwopt.quantities import QUANTITIES

OwnFunction = Callable[[Mapping[str, Array]], Any]
DIRECTIONS = ("minimise", "maximise")

#: Figure -> (unit, which scene counts where there are several: the one with the most or the least).
FIGURES = {one.name: (one.unit, one.worst_scene) for one in QUANTITIES if one.name not in ("dof_m", "white_balance")}
#: Beside them: index of each part into the search's parts, and its id.
PARTS = OF_A_DESIGN


@dataclass(frozen=True)
class OwnObjective:
    """A figure of merit that uwopt does not know.

    `function` takes a mapping of arrays, one entry a design (see `FIGURES`, and `camera`, `camera_id` and so on
    for the parts), and returns as many numbers. It is called for feasible designs alone.
    """

    name: str
    function: OwnFunction
    direction: str = "minimise"
    unit: str = ""

    def __post_init__(self) -> None:
        if not self.name or not callable(self.function):
            raise MissionError(f"objective {self.name!r}: an own objective needs a name and a function")
        if self.direction not in DIRECTIONS:
            raise MissionError(
                f"objective {self.name}: direction {self.direction!r} is not one of {', '.join(DIRECTIONS)}"
            )

    @staticmethod
    def of(given: OwnObjective | OwnFunction) -> OwnObjective:
        """The objective itself, or a bare function under its own name."""
        if isinstance(given, OwnObjective):
            return given
        return OwnObjective(getattr(given, "__name__", type(given).__name__), given)

    def minimised(self, figures: Mapping[str, Array]) -> Array:
        """The function's values (n,), negated where more is better; faults name the function."""
        n = len(figures["power_w"])
        try:
            returned = self.function(figures)
            values = np.asarray(returned, float)
        except KeyError as fault:
            known = ", ".join(sorted(figures))
            raise MissionError(
                f"objective {self.name}: there is no figure {fault}; known: {known}"
            ) from fault
        except Exception as fault:  # a user's function may raise anything
            raise MissionError(f"objective {self.name}: {type(fault).__name__}: {fault}") from fault
        if values.shape != (n,):
            raise MissionError(
                f"objective {self.name}: returned an array of shape {values.shape} for {n} designs; one number a "
                f"design is wanted, shape ({n},)"
            )
        if np.isnan(values).any():
            raise MissionError(
                f"objective {self.name}: returned NaN for {int(np.isnan(values).sum())} of {n} feasible designs; "
                "return a number for each"
            )
        if np.isinf(values).any():
            raise MissionError(
                f"objective {self.name}: returned infinity for {int(np.isinf(values).sum())} of {n} feasible designs; "
                "return a large number instead"
            )
        return -values if self.direction == "maximise" else values
