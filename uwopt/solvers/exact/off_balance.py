"""Which imagers see colours too far apart under lamps alone: by what the water leaves at least, then by images."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import distinct
from uwopt.solvers.exact.light_tables import FieldTables

NEAR = 0.75  # of a limit: how much of their white balance images owe to the water's shortest paths, as a rule
MET = 1.0 + 1e-8  # of a limit, beyond what an evaluation takes for met


def by_water(tables: FieldTables, k: int, rows: Array) -> Array:
    """Whether the water alone takes the colours of these imagers too far apart, in some scene; (n,)."""
    off = np.zeros(len(rows), bool)
    for index, least, most in balances(tables, k, rows):
        if tables.problem.scenes[index].view.requirements.min_snr:  # without any light no colour is stronger
            off |= least > most
    return off


def by_image(tables: FieldTables, k: int, rows: Array) -> Array:
    """Whether images are off balance under one lighting in some scene, asked where the water nearly says so; (n,)."""
    off = np.zeros(len(rows), bool)
    for index, least, most in balances(tables, k, rows):
        doubtful = np.flatnonzero(~off & (least > NEAR * most))
        if len(doubtful) and not tables.problem.paper:
            seen = tables.balance(index, tables.lightings[k], rows[doubtful])
            off[doubtful] = seen > most * MET
    return off


def balances(tables: FieldTables, k: int, rows: Array) -> Iterator[tuple[int, Array, float]]:
    """Each scene in which lamps alone keep a white balance, what the water leaves at least, and what is asked."""
    problem = tables.problem
    lit_alone = [
        (index, scene.view.requirements.max_white_balance)
        for index, scene in enumerate(problem.scenes)
        if not (scene.sunlit and problem.effects.sunlight)
    ]
    asked = [(index, most) for index, most in lit_alone if most is not None]
    if not asked:
        return
    curves, back = distinct(problem.cameras.qe_index[tables.imagers.camera[rows]])
    for index, most in asked:
        least = [tables.least_balance(index, tables.lightings[k], int(curve)) for curve in curves]
        yield index, np.array(least)[back], most
