"""What a search chooses from at a time: imagers with the tables and bounds of their light, as one value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.light_tables import FieldTables

Array = NDArray[Any]


@dataclass(frozen=True)
class Candidates:
    """Imagers under all lightings; of a large catalogue some of many, whose tables of lights are common to all."""

    imagers: Imagers
    tables: FieldTables
    bounds: Bounds

    @staticmethod
    def of(
        problem: Problem, objective: Objective, imagers: Imagers, *, lights: Array | None = None,
        widest_m: Sequence[float] | None = None,
    ) -> Candidates:  # fmt: skip
        """All imagers of a small catalogue. `lights` marks those that are searched; `widest_m` as of `FieldTables`."""
        tables = FieldTables(problem, imagers, widest_m=widest_m)
        bounds = Bounds(objective, imagers, tables, lights=lights)
        return Candidates(imagers, tables, bounds)

    def others(self, imagers: Imagers) -> Candidates:
        """Other imagers of the same catalogue; the tables of lights are the same."""
        own, tables = self.bounds, FieldTables(self.tables.problem, imagers, like=self.tables)
        bounds = Bounds(own.objective, imagers, tables, lights=own.searched, like=own)
        return Candidates(imagers, tables, bounds)

    @cached_property
    def motorised(self) -> Array:
        """Whether each imager's lens is motorised."""
        lenses = self.tables.problem.lenses
        return lenses.motorised[self.imagers.lens] if len(self.imagers) else np.empty(0, bool)
