"""Which imagers see colours too far apart under lamps alone: by what the water leaves at least, then by images.

A channel's mean over an image sums the same places with the same weights as any other channel's, so that the ratio
of two means is nowhere below the least ratio over the paths that light can take.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import distinct
from uwopt.forward.scene import COLOURS
from uwopt.forward.spectra import Contraction, sees_colours
from uwopt.model.path_table import product

if TYPE_CHECKING:
    from uwopt.solvers.exact.light_tables import FieldTables

Box = tuple[float, float]
CELLS = 64  # of paths on either leg, least where paths are short: there colours are apart least, as a rule
SUMS_DIFFER = 0.998  # of a ratio: channels are tabulated apart, and cells of sharp beams extrapolated
NEAR = 0.75  # of a limit: how much of their white balance images owe to the water's shortest paths, as a rule
MET = 1.0 + 1e-8  # of a limit, beyond what an evaluation takes for met


def least_white_balance(
    contraction: Contraction, spectrum: int, efficiency: int, *, lamp_m: Box, camera_m: Box
) -> float:
    """Lower bound of the strongest over the weakest channel under one light, whatever the image.

        max_c mu_c / min_c mu_c >= max over pairs (A, B) of min over paths of A(r_lamp, r_camera) / B(r_lamp, r_camera)

    lamp_m, camera_m : shortest and longest path [m] on either leg; both channels fall along either, so that in a cell
        of paths A / B is no less than A at its far corner over B at its near one. 1 of a mono sensor.
    """
    if not sees_colours(contraction.efficiencies[efficiency]):
        return 1.0
    scene = contraction.scene
    lamp, camera = (
        near + max(far - near, 0.0) * np.square(np.linspace(0.0, 1.0, CELLS + 1)) for near, far in (lamp_m, camera_m)
    )
    weights = {name: contraction.weight(spectrum, efficiency, name) for name in COLOURS}
    lit = np.max(list(weights.values()), axis=0) > 0.0
    if not lit.any():
        return 1.0
    lost_lamp, lost_camera = (
        np.exp(-np.outer(path, loss[lit] - loss[lit].min()))  # what all lose alike changes no ratio
        for path, loss in ((lamp, contraction.lamp_leg_per_m(spectrum)), (camera, scene.attenuation_per_m))
    )
    seen = {name: product(lost_lamp * weight[lit], lost_camera.T) for name, weight in weights.items()}
    return max(1.0, SUMS_DIFFER * max(least_ratio(seen[a], seen[b]) for a, b in permutations(COLOURS, 2)))


def least_ratio(strong: Array, weak: Array) -> float:
    """Least of one channel over another in all cells between these paths; inf where only the other sees nothing."""
    far, near = strong[1:, 1:], weak[:-1, :-1]
    dark = np.where(far > 0.0, np.inf, 1.0)
    return float(np.divide(far, near, out=dark, where=near > 0.0).min())


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
