"""The light of imagers behind many ports at once, integrated: a second, tight bound for those that a first one spares.

The mean is that of `image_mean.field_mean` over columns of ports, so that imagers of a large catalogue need not be
taken port by port. Veils are left out: they never help the signal.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.lamps import one_side
from uwopt.model import beam as beams
from uwopt.model.image_mean import field_mean
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.lightings import Lighting

Array = NDArray[Any]
MARGIN = 1.0 + 1e-6  # of the integral: tables interpolated elsewhere


class SignalTables(FieldTables):
    """Bounds of the light, integrated at the farthest altitude where the beam has no sharp edge."""

    def bound(
        self, scene_index: int, lighting: Lighting, altitude: int, rows: Array, *, channel: str | None = None
    ) -> Array:
        """Upper bound on the electrons per lm s of these imagers at one altitude, (n,); of a channel not integrated."""
        scene, beam = self.problem.scenes[scene_index], self.problem.beam(scene_index, lighting.optics)
        coarse = super().bound(scene_index, lighting, altitude, rows, channel=channel)
        if channel is not None or self.problem.paper:
            return coarse
        if altitude != len(scene.range_m) - 1 or beams.has_sharp_edge(beam):
            return coarse
        return np.asarray(
            np.minimum(coarse, self._integrated(scene_index, lighting, altitude, rows) * MARGIN)
        )

    def _integrated(self, scene_index: int, lighting: Lighting, altitude: int, rows: Array) -> Array:
        """Electrons per lm s that form the image, at one altitude."""
        problem, imagers = self.problem, self.imagers
        view, contraction = imagers.scenes[scene_index].view, problem.contractions[scene_index]
        spectrum, curve = int(contraction.spectrum_of[lighting.optics]), problem.cameras.qe_index[imagers.camera[rows]]
        range_m = float(problem.scenes[scene_index].range_m[altitude])
        lit: dict[str, Any] = dict(
            beam=problem.floor_lobe(scene_index, lighting.optics, lighting.mount, range_m),
            lamps=one_side(lighting.mount.lamps(2)), range_m=range_m,
            fineness=problem.scenes[scene_index].fineness.image,
        )  # fmt: skip
        gain = np.empty(len(rows))
        for mine, shape in problem.shapes(imagers.port[rows], scene_index):
            for q in np.unique(curve[mine]):
                own = np.flatnonzero(curve[mine] == q)
                some = rows[mine[own]]
                mean = field_mean(
                    view.tan_along[some], view.tan_across[some], shape=shape.take(own),
                    table=problem.table(scene_index, spectrum, int(q)), **lit,
                )  # fmt: skip
                gain[mine[own]] = contraction.response(spectrum, int(q)) * mean
        return np.asarray(view.collecting_m2[rows] * gain)
