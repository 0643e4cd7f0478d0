"""Which settings of designs are best: the question that every solver of settings takes, and its answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.columns import Columns
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import MAXIMISED, Objective
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.mean_limit import MeanLimit

GAP = 1e-4  # relative, where cells are searched
MOST_CELLS = 30_000  # bounded for one design, which is then left with its bound


def gap_if_told(objective: Objective, gap_rel: float) -> float:
    """The gap to ask for where settings are not told, but what they make of an objective: inf where that is nothing.

    Whether any fit is then all that counts.
    """
    return gap_rel if any(objective.weight(name) for name in ("power", *MAXIMISED)) else np.inf


@dataclass(frozen=True)
class Question(Columns):
    """What is asked of the settings of n designs, the worst scene of each counting."""

    rows: list[SceneRows]  # by scene
    motorised: Array
    camera_power_w: Array
    power_limit_w: Array  # of lights and cameras together
    constant: Array  # of the minimised objective, what no setting changes, the camera's power too
    cutoff: Array  # designs that cannot get below it are dropped
    hardware: Array  # an index a design
    objective: Objective
    near: Array | None = None  # (n, 2) f-number and time [s] near which the best are thought to be, nan: unknown
    gap_rel: float = GAP  # inf: settings that fit, however good
    top: int | None = None  # designs are dropped, too, that so many of other hardware surely beat
    mean_limit: MeanLimit | None = None
    most_cells: int = MOST_CELLS  # of one design
    deadline: Deadline = NEVER

    @staticmethod
    def of(
        rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array,
        power_limit_w: float | Array, *, constant: Array | float = 0.0, cutoff: float | Array = np.inf,
        hardware: Array | None = None, **more: Any,
    ) -> Question:  # fmt: skip
        """Numbers that stand for all designs may be given once; `more` are the other fields."""
        n = len(motorised)

        def each(one: float | Array) -> Array:
            return np.broadcast_to(one, (n,))

        return Question(
            rows, motorised, each(camera_power_w), each(power_limit_w), each(constant), each(cutoff),
            np.arange(n) if hardware is None else hardware, objective, **more,
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.motorised)

    @property
    def light_limit_w(self) -> Array:
        """What is left of the limit of power for the lights."""
        return np.asarray(self.power_limit_w - self.camera_power_w)


@dataclass(frozen=True)
class Best(Columns):
    """Best settings of n designs by scene, the worst scene's figures, and what no settings can beat."""

    chosen: list[Chosen]
    feasible: Array
    snr_db: Array
    contrast: Array  # image mean at the nominal altitude
    information: Array  # bit/m2; 0 where it does not count
    lower_bound: Array | None = None  # of the minimised objective; None: the value itself; inf: there are none

    def value(self, question: Question) -> Array:
        """The minimised objective, constants included, inf where nothing is feasible; no sum that holds information."""
        objective = question.objective
        value = question.constant + objective.weight("power") * np.max([c.light_power_w for c in self.chosen], axis=0)
        for name in ("snr_db", "contrast"):
            if objective.weight(name):
                value = value - objective.weight(name) * getattr(self, name)
        return np.where(self.feasible, value, np.inf)

    def bound(self, question: Question) -> Array:
        """What no settings can beat; inf: there are none."""
        return self.value(question) if self.lower_bound is None else self.lower_bound
