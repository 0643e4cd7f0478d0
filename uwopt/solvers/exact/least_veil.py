"""Lower bounds of the forward veil over the light that forms the image, before any field is integrated.

What comes near its straight way holds at every pixel: the same place on the floor sends both. What comes from elsewhere
on the floor is bounded in the mean of the image alone, by what the image's own floor sends into it
(`veil.wide.least_within`): however a lamp lights it, no light in the image is without this veil.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.columns import distinct
from uwopt.forward.problem import Problem
from uwopt.forward.views import Views
from uwopt.model import port
from uwopt.model.veil.wide import least_within
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import Lighting

Array = NDArray[Any]
GRAZING = 9.0  # lamps farther aside than so many of their heights: little of their light counts as meeting the floor
WORTH = 1e-3  # of the veil: less from elsewhere is not worth its bound


class LeastVeil:
    """Bounds of the veil of some imagers under some lightings."""

    def __init__(self, problem: Problem, imagers: Imagers, lightings: Sequence[Lighting]):
        self.problem, self.imagers, self.lightings = problem, imagers, lightings
        self._within: dict[int, Array] = {}

    def least(self, scene_index: int, lightings: Sequence[Lighting], rows: Array, altitude: int) -> Array:
        """Least veil over signal of imagers under any of some lightings at one altitude, (n,).

        Where an SNR is asked of pixels, near their straight ways alone: the veil from elsewhere may be less there.
        """
        problem = self.problem
        contraction = problem.contractions[scene_index]
        curves, back = distinct(problem.cameras.qe_index[self.imagers.camera[rows]])
        spectra = {int(contraction.spectrum_of[lighting.optics]) for lighting in lightings}
        nearest_m, veil = problem.nearest_m(scene_index, altitude), np.zeros(len(rows))
        for k, curve in enumerate(curves):
            each = [contraction.least_veil(s, int(curve), altitude, nearest_m) for s in spectra]
            mine = back == k
            veil[mine] = min((near for near, _ in each), default=0.0)
            if self.counts_elsewhere(scene_index) and any(wide.sum() > WORTH * (1.0 + near) for near, wide in each):
                within = self.within(scene_index)[rows[mine]]
                veil[mine] = np.min([near + within @ wide for near, wide in each], axis=0)
        return veil

    def counts_elsewhere(self, scene_index: int) -> bool:
        """Whether what comes from elsewhere is bounded: of means, over a level floor."""
        scene = self.problem.scenes[scene_index]
        return self.problem.contractions[scene_index].multiple and scene.pixels is None and not scene.slope

    def within(self, scene_index: int) -> Array:
        """What each imager's floor sends into its image at least, by kernel (n, 4)."""
        if scene_index not in self._within:
            ends = self.imagers.scenes[scene_index].ends
            bends = [self._bend(scene_index, view) for view in ends]
            aside = np.max([self._aside(scene_index, *end) for end in zip(ends, bends, strict=True)], axis=0)
            sent = [
                least_within(view.tan_along / bend, view.tan_across / bend, aside=aside) * passed[:, None]
                for view, bend, passed in zip(ends, bends, self._passed(scene_index, ends), strict=True)
            ]
            self._within[scene_index] = np.min(sent, axis=0)
        return self._within[scene_index]

    def _bend(self, scene_index: int, view: Views) -> Array:
        """Tangent in air over that in water at the image's corner."""
        square = np.square(view.tan_along) + np.square(view.tan_across)
        return np.where(self._is_dome, 1.0, port.bend(square, n=self.problem.scenes[scene_index].n_water))

    def _aside(self, scene_index: int, view: Views, bend: Array) -> Array:
        """By how much farther aside than a ray from the middle of its window an image's corner falls, at most; inf
        where lamps stand so far aside that some of their light in the image may count as missing the floor."""
        nearest_m = float(self.problem.scenes[scene_index].range_m[0])
        most = np.zeros(len(bend))
        for tangent, wide_m in ((view.tan_along, view.footprint_along_m), (view.tan_across, view.footprint_across_m)):
            straight_m = nearest_m * tangent / port.bend(np.square(tangent), n=self.problem.scenes[scene_index].n_water)
            most = np.maximum(most, 0.5 * wide_m[:, 0] / straight_m - 1.0)
        most = np.where(self._is_dome, 0.0, most * bend)  # at a corner no more than bend times as much
        far_m = 0.5 * np.hypot(view.footprint_along_m[:, -1], view.footprint_across_m[:, -1])
        return np.where(far_m < self._lit_m(nearest_m), most, np.inf)

    def _lit_m(self, range_m: float) -> float:
        """How far from the axis light of every lamp meets the floor steeply enough."""
        lamps = [lighting.mount.lamps(self.problem.count_range[1]) for lighting in self.lightings]
        return min((
            GRAZING * (range_m - z) - float(np.hypot(x, y))
            for one in lamps for x, y, z in zip(one.x_m, one.y_m, one.z_m, strict=True)
        ), default=np.inf)  # fmt: skip

    def _passed(self, scene_index: int, ends: Sequence[Views]) -> list[Array]:
        """What a flat window passes in the image's corner over what it passes on the axis."""
        problem, n_water = self.problem, self.problem.scenes[scene_index].n_water
        if not problem.effects.window_angle or self._is_dome.all():
            return [np.ones(len(self._is_dome)) for _ in ends]
        passed, glass = [], problem.ports.refractive_index
        for view in ends:
            tangent = np.hypot(view.tan_along, view.tan_across)
            each = [
                port.flat_port_transmittance(tangent, n_water=n_water, n_glass=n)
                / port.normal_port_transmittance(n_water=n_water, n_glass=n)
                for n in (float(glass.min()), float(glass.max()))
            ]
            passed.append(np.where(self._is_dome, 1.0, np.min(each, axis=0)))
        return passed

    @cached_property
    def _is_dome(self) -> Array:
        return np.asarray(self.problem.ports.is_dome[self.imagers.port])
