"""Several states of one scene's water side by side: what they do to a lamp's lobe and send back, in one.

One lobe for all colours: each counts by what gets through there and back. Of several states only the extremes are kept.
All have the scene's wavelengths and things that scatter; how much these do differs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.model import multiple
from uwopt.model.beam import Beam, half_power_angle_rad
from uwopt.model.scattering import PhaseTable, share_beyond
from uwopt.model.sent_back import least_widened_phase, mean_way_m
from uwopt.model.spectrum import trapezoid_weights_nm
from uwopt.model.widened import Turned, bounding, ways_m

if TYPE_CHECKING:
    from uwopt.forward.scene import SceneOptics

FAINTEST = 1e-9  # of a lamp's brightest colour: fainter ones count for nothing


class OnTheWay(NamedTuple):
    """What a lobe's light meets in the water: of each way in each water, one water after another."""

    turned: list[Turned]
    absorbed: Array  # a r
    returned: Array  # factor of what falls from all about: see `multiple.returned_gain`


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
        ways = ways_m(way_m) if back else np.array([way_m])
        met = self.on_the_way(ways, lobe, relative_spectrum, lamp_leg_per_m, back=back)
        return bounding(
            lobe, met.turned, way_m, absorbed=met.absorbed, returned=met.returned, sent_back=back, weights=weights,
            most=not back,
        )  # fmt: skip

    def least_sent_back(self, relative_spectrum: Array, range_m: float) -> tuple[PhaseTable | None, ...]:
        """At every angle the least of the phase functions that lamp light meets; as `SceneOptics.sent_back` of each."""
        turned = self.turned_before(range_m, relative_spectrum)
        return tuple(None if table is None else least_widened_phase(table, turned) for table in self.tables)

    def on_the_way(
        self, ways: Array, lobe: Beam, relative_spectrum: Array, lamp_leg_per_m: Array, *, back: bool
    ) -> OnTheWay:  # fmt: skip
        """What a lobe's light meets on these ways to the floor, or to what sends it `back`, over all its colours."""
        angle = float(multiple.lamp_angle_rad(half_power_angle_rad(lobe)))
        kinds = np.moveaxis(self.scattering_per_m, 1, 0)
        columns = np.stack([self.reflectance, self.absorption_per_m, self.backward_per_m, *kinds], axis=1)
        there = np.broadcast_to(ways[:, None], (len(columns), len(ways), 1))
        means = self._over_colours(relative_spectrum, there, self.attenuation_per_m + lamp_leg_per_m, columns)
        means = np.moveaxis(means, 2, 0).reshape(3 + len(kinds), -1)
        reflectance, lengths = means[0], np.tile(ways, len(self.attenuation_per_m))
        absorbed, turned_back, *scattered = lengths * means[1:]
        turned = [
            Turned(thickness, share_beyond(angle, table), table)
            for thickness, table in zip(scattered, self.tables, strict=True)
        ]
        floor = 0.0 if back else reflectance
        returned = multiple.returned_gain(absorbed, turned_back=turned_back, reflectance=floor)
        return OnTheWay(turned, absorbed, np.asarray(returned))

    def turned_before(self, range_m: float, relative_spectrum: Array) -> list[tuple[Array, PhaseTable | None]]:
        """What turns light that the water sends back before a floor so far off: thickness (n,) and phase of each."""
        ways = mean_way_m(range_m, self.attenuation_per_m)
        columns = ways[:, None, :] * self.scattering_per_m
        means = self._over_colours(relative_spectrum, ways[:, None, :], self.attenuation_per_m, columns)[:, 0]
        return [(multiple.BACK_WAY * means[:, kind], table) for kind, table in enumerate(self.tables)]

    def _over_colours(self, relative_spectrum: Array, ways: Array, lost_per_m: Array, columns: Array) -> Array:
        """Means of spectra (n, n_columns, .) over the colours that get through ways (n, n_ways, .), by way and column.

            sum over colours of s exp(-c r) x / sum of s exp(-c r)

        Of each way c r is taken less the least, so that some light is left; a colour that the lamp lacks tells nothing.
        """
        sent = relative_spectrum * trapezoid_weights_nm(self.first.wavelength_nm)
        told = sent > FAINTEST * sent.max()
        means = np.empty((len(columns), ways.shape[1], columns.shape[1]))
        for row, way, lost, there in zip(means, ways, lost_per_m, columns[:, :, told], strict=True):
            optical = (way * lost)[:, told]
            weight = sent[told] * np.exp(optical.min(axis=1, keepdims=True) - optical)
            row[:] = weight @ there.T / weight.sum(axis=1, keepdims=True)
        return means
