"""Several states of one scene's water side by side: what they do to a lamp's lobe and send back, in one.

As `SceneOptics.widened_lobe` and `sent_back` of each, of which only the extremes are kept. All have the scene's
wavelengths and things that scatter; how much these do differs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwopt.model import multiple
from uwopt.model.beam import Beam, half_power_angle_rad
from uwopt.model.scattering import PhaseTable, share_beyond
from uwopt.model.sent_back import least_widened_phase, mean_way_m
from uwopt.model.widened import Turned, bounding, ways_m

if TYPE_CHECKING:
    from uwopt.forward.scene import SceneOptics

Array = NDArray[Any]


@dataclass(frozen=True)
class WatersBeside:
    """Spectra of each water (n, n_wavelengths), [1/m] and the floor's reflectance [1]."""

    first: SceneOptics
    tables: tuple[PhaseTable | None, ...]
    attenuation_per_m: Array
    absorption_per_m: Array
    backward_per_m: Array
    reflectance: Array
    scattering_per_m: Array  # (n, n_kinds, n_wavelengths)

    @staticmethod
    def of(scenes: Sequence[SceneOptics]) -> WatersBeside:
        """Of these states."""
        tables = {tuple(one.table for one in scene.scattering) for scene in scenes}
        assert len(tables) == 1, "states of one water have the same phase functions"
        return WatersBeside(
            scenes[0], tables.pop(), np.stack([scene.attenuation_per_m for scene in scenes]),
            np.stack([scene.absorption_per_m() for scene in scenes]),
            np.stack([scene.backward_per_m() for scene in scenes]), np.stack([scene.reflectance for scene in scenes]),
            np.stack([[one.scattering_per_m for one in scene.scattering] for scene in scenes]),
        )  # fmt: skip

    def bounding_lobe(
        self, lobe: Beam, relative_spectrum: Array, lamp_leg_per_m: Array, *, way_m: float, back: bool,
        weights: Sequence[float],
    ) -> Beam:  # fmt: skip
        """At every angle the most of what all make of a lamp's lobe on the floor; the least of what they send back.

        lamp_leg_per_m : K of each, (n, n_wavelengths)
        weights : of each, on its lobe
        """
        angle = float(multiple.lamp_angle_rad(half_power_angle_rad(lobe)))
        ways = ways_m(way_m) if back else np.array([way_m])
        means = self._mean(relative_spectrum, ways, self.attenuation_per_m + lamp_leg_per_m)
        reflectance, absorbed, turned_back = means[0], ways * means[1], ways * means[2]
        returned = multiple.returned_gain(
            absorbed, turned_back=turned_back, reflectance=0.0 if back else reflectance
        )  # fmt: skip
        turned = [
            Turned((ways * scattered).ravel(), share_beyond(angle, table), table)
            for scattered, table in zip(means[3:], self.tables, strict=True)
        ]
        return bounding(
            lobe, turned, way_m, absorbed=absorbed.ravel(), returned=returned.ravel(), sent_back=back, weights=weights,
            most=not back,
        )  # fmt: skip

    def least_sent_back(self, relative_spectrum: Array, range_m: float) -> tuple[PhaseTable | None, ...]:
        """At every angle the least of the phase functions that lamp light meets; as `SceneOptics.sent_back` of each."""
        ways = mean_way_m(range_m, self.attenuation_per_m)
        weight = ways * self.first.colours_weight(relative_spectrum, self.attenuation_per_m * ways)
        turned = [
            (multiple.BACK_WAY * np.einsum("nw,nw->n", weight, self.scattering_per_m[:, kind]), table)
            for kind, table in enumerate(self.tables)
        ]
        return tuple(None if table is None else least_widened_phase(table, turned) for table in self.tables)

    def _mean(self, relative_spectrum: Array, ways: Array, lost_per_m: Array) -> Array:
        """Reflectance, a, b_b and b of each kind over the colours that get through, (., n_waters, n_ways).

            sum over colours of s exp(-c r) x / sum of s exp(-c r),   c less the least, so that some light is left
        """
        sent, told = self.first.sent_colours(relative_spectrum)
        own = [self.reflectance, self.absorption_per_m, self.backward_per_m, *np.moveaxis(self.scattering_per_m, 1, 0)]
        columns = sent[told] * np.stack([np.ones_like(self.reflectance), *own], axis=1)[:, :, told]
        lost = lost_per_m[:, told]
        sums = np.empty((len(lost), len(ways), columns.shape[1]))
        for row, loss, there in zip(sums, lost - lost.min(axis=1, keepdims=True), columns, strict=True):
            optical = np.multiply.outer(ways, -loss)
            row[:] = np.exp(optical, out=optical) @ there.T
        return np.moveaxis(sums[:, :, 1:] / sums[:, :, :1], 2, 0)
