"""The light of imagers behind many ports at once, integrated: a second, tight bound for those that a first one spares.

The integral is that of `imaging.field_mean`, node by node; here the port's numbers are columns, so that
imagers of a large catalogue need not be taken port by port. Veils are left out: they never help the signal.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.lamps import one_side
from uwopt.model import beam as beams
from uwopt.model.image_mean import along_symmetric, gauss, orders_needed
from uwopt.model.imaging import PortShape, field_loss, floor_point, lamp_light
from uwopt.model.path_table import log_mean_transmission
from uwopt.solvers.exact.light_tables import FieldTables, Lighting

Array = NDArray[Any]
MARGIN = 1.0 + 1e-6  # of the integral: sums in another order, tables interpolated elsewhere
MOST_NODES = 400_000  # that are worked on together


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
        view = imagers.scenes[scene_index].view
        contraction = problem.contractions[scene_index]
        spectrum = int(contraction.spectrum_of[lighting.optics])
        curve = problem.cameras.qe_index[imagers.camera[rows]]
        response = {int(q): contraction.response(spectrum, int(q)) for q in np.unique(curve)}
        gain, dome = np.empty(len(rows)), problem.ports.is_dome[imagers.port[rows]]
        for is_dome in (True, False):
            mine = np.nonzero(dome == is_dome)[0]
            if len(mine):
                gain[mine] = self._mean_gain(scene_index, lighting, altitude, rows[mine], is_dome)
        return np.asarray(view.collecting_m2[rows] * np.array([response[int(q)] for q in curve]) * gain)

    def _mean_gain(
        self, scene_index: int, lighting: Lighting, altitude: int, rows: Array, is_dome: bool
    ) -> Array:
        """Mean of `imaging.local_gain` over images behind ports of one geometry [1/m^2]."""
        problem, view = self.problem, self.imagers.scenes[scene_index].view
        scene, beam = problem.scenes[scene_index], problem.beam(scene_index, lighting.optics)
        lamps, range_m = one_side(lighting.mount.lamps(2)), float(scene.range_m[altitude])
        along, across = view.tan_along[rows], view.tan_across[rows]
        shape = self._shape(scene_index, rows, is_dome, ())
        orders = orders_needed(along, across, shape, range_m, lamps, beam, scene.fineness.image)
        gain = np.empty(len(rows))
        for order in np.unique(orders):
            mine = np.nonzero(orders == order)[0]
            step = max(1, MOST_NODES // int(order) ** 2)
            for start in range(0, len(mine), step):
                some = mine[start : start + step]
                gain[some] = self._rule_mean(scene_index, lighting, range_m, rows[some], is_dome, int(order))
        return gain

    def _shape(self, scene_index: int, rows: Array, is_dome: bool, axes: tuple[None, ...]) -> PortShape:
        """The ports of these imagers as one shape whose numbers are columns, with further axes."""
        ports, at = self.problem.ports, (self.imagers.port[rows], *axes)
        columns = (ports.outer_radius_m, ports.thickness_m, ports.refractive_index, ports.gap_m)
        numbers = [column[at[0]][(slice(None), *axes)] for column in columns]
        radius, thickness, index, gap = (cast(float, number) for number in numbers)
        return PortShape(
            is_dome, radius, thickness, index, gap, self.problem.scenes[scene_index].n_water,
            self.problem.effects.window_angle, self.problem.scenes[scene_index].slope,
        )  # fmt: skip

    def _rule_mean(
        self, scene_index: int, lighting: Lighting, range_m: float, rows: Array, is_dome: bool, order: int
    ) -> Array:
        """The product rule of `imaging.mean_of_order` for these imagers."""
        problem, view = self.problem, self.imagers.scenes[scene_index].view
        beam, lamps = problem.beam(scene_index, lighting.optics), one_side(lighting.mount.lamps(2))
        spectrum = int(problem.contractions[scene_index].spectrum_of[lighting.optics])
        across_nodes, across_weights = gauss(order)
        along_nodes, along_weights = across_nodes, across_weights
        shape = self._shape(scene_index, rows, is_dome, (None, None))
        if along_symmetric(lamps, shape):
            along_nodes, along_weights = gauss(max(4, order // 2))
            along_nodes = 0.5 * (along_nodes + 1.0)
        along, across = np.broadcast_arrays(
            view.tan_along[rows, None, None] * along_nodes[:, None],
            view.tan_across[rows, None, None] * across_nodes,
        )
        x_m, y_m, path_m = floor_point(along, across, shape=shape, range_m=range_m)
        curve = problem.cameras.qe_index[self.imagers.camera[rows]]
        total = np.zeros(x_m.shape)
        for index, share in enumerate(lamps.share):
            vacuum, lamp_m, _ = lamp_light(
                x_m, y_m, lamps=lamps, index=index, beam=beam, range_m=range_m, slope=shape.slope
            )
            for q in np.unique(curve):
                mine = curve == q
                table = problem.table(scene_index, spectrum, int(q))
                loss = np.exp(log_mean_transmission(table, lamp_m[mine], path_m[mine]))
                total[mine] += share * vacuum[mine] * loss
        gain = total * field_loss(along, across, shape=shape)
        return np.asarray((gain @ across_weights) @ along_weights)
