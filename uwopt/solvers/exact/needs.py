"""What imagers need before any light is chosen: electrons, times, and how clear an image the water leaves at most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.part_columns import FLASH, Cameras
from uwopt.forward.scene import SceneOptics
from uwopt.model import sensor
from uwopt.model.image_mean import FRAME_SHARE
from uwopt.solvers.exact.least_veil import LeastVeil
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.lightings import Lighting
from uwopt.tolerances import ROUND

LATTICE_MARGIN = 0.95  # of a share of the image that is counted at places: discs are met to 0.01 of the image


@dataclass(frozen=True)
class Needs:
    """What imagers need in one scene before any light is chosen."""

    by_snr_e: Array  # electrons of the mean, at the farthest altitude and the nominal one, (n, 2)
    by_pixel_e: Array  # of the pixel that must reach the SNR, at the farthest altitude
    by_red_e: Array | None  # of the red channel, at every altitude; None: nothing is asked of it
    by_gain_e: Array  # electrons, at the nominal altitude
    sun_e: Array  # electrons of the sun's signal at most, at the farthest altitude and the nominal one, (n, 2)
    square: Array  # of the smallest working f-number
    longest_s: Array
    rate_hz: Array


class ImagerNeeds:
    """The needs of the imagers of some tables, the same under every lighting."""

    def __init__(self, tables: FieldTables):
        self.problem, self.imagers, self.tables = tables.problem, tables.imagers, tables
        self.limits = self.problem.mission.limits
        self.veils = LeastVeil(self.problem, self.imagers)
        self._known: tuple[Array, dict[int, Needs]] | None = None

    def of(self, scene_index: int, rows: Array) -> Needs:
        """What these imagers need in one scene, the same under every lighting."""
        if self._known is None or self._known[0] is not rows:
            self._known = (rows, {})
        known = self._known[1]
        if scene_index not in known:
            focused = self.imagers.scenes[scene_index].focused.take(rows)
            by_snr, by_pixel, by_gain = self._electrons(scene_index, rows)
            square, longest_s = np.square(focused.n_low * focused.working_factor), self._longest_time_s(focused, rows)
            sun_e = self._of_sun(scene_index, rows, np.maximum(longest_s, 0.0) / square)
            by_snr = np.maximum(by_snr - sun_e.max(axis=1)[:, None], 0.0)
            known[scene_index] = Needs(
                by_snr, by_pixel, self._red(scene_index, rows), by_gain, sun_e, square, longest_s,
                focused.rate_hz,
            )  # fmt: skip
        return known[scene_index]

    def _electrons(self, scene_index: int, rows: Array) -> tuple[Array, Array, Array]:
        """Fewest electrons that form the image for the SNR, at the farthest altitude and the nominal one, (n, 2), inf
        where no well holds them beside their veil; those of the pixel that must reach it, at the farthest altitude; and
        of all light for the mean level at the highest gain, at the nominal altitude. Quantisation and dark current are
        left out."""
        cameras = self.problem.cameras.take(self.imagers.camera[rows])
        scene = self.problem.scenes[scene_index]
        needs = scene.view.requirements
        need, by_pixel = np.zeros((len(rows), 2)), np.zeros(len(rows))
        if scene.least_snr:
            veil = self.least_veil(scene_index, rows)
            noise: dict[str, Any] = dict(
                noise_variance_e2=np.square(cameras.read_noise_e)[:, None], veil_ratio=veil,
                prnu_frac=cameras.prnu_frac[:, None],
            )
            need = least_mean_frac(scene) * sensor.electrons_for_snr(scene.least_snr, **noise)
            by_pixel = need[:, 0] / least_mean_frac(scene)
            if scene.least_mean_snr:
                need = np.maximum(need, sensor.electrons_for_snr(scene.least_mean_snr, **noise))
            held = need[:, 1] <= most_held_e(cameras, scene) / (1.0 + veil[:, 1]) * ROUND
            need, by_pixel = np.where(held[:, None], need, np.inf), np.where(held, by_pixel, np.inf)
        if needs.mean_level is None or self.problem.effects.veils or self.is_sunlit(scene_index):
            # veils and the sun help to fill the range
            return np.asarray(need), by_pixel, np.zeros(len(rows))
        wanted_dn = needs.mean_level * (2.0**cameras.bits - 1.0) - cameras.black_level_dn
        by_gain = wanted_dn / (cameras.gain_dn_per_e * self.problem.gains(scene_index, cameras.max_gain)[1])
        longest = np.minimum(self.limits.max_exposure_ms * 1e-3, cameras.max_exposure_s)
        return np.asarray(need), by_pixel, np.asarray(by_gain - cameras.dark_current_e_s * longest)

    def _of_sun(self, scene_index: int, rows: Array, open_over_n2_s: Array) -> Array:
        """The most electrons of the sun's signal at the farthest and the nominal altitude, (n, 2)."""
        scene = self.problem.scenes[scene_index]
        if not self.is_sunlit(scene_index):
            return np.zeros((len(rows), 2))
        return np.asarray(self.tables.most_sun(scene_index, rows)[:, [-1, scene.nominal]] * open_over_n2_s[:, None])

    def _red(self, scene_index: int, rows: Array) -> Array | None:
        """Fewest electrons of the red channel for the SNR that is asked of it; None where none must be of a lamp."""
        wanted = self.problem.scenes[scene_index].view.requirements.min_snr_red
        if wanted is None or self.is_sunlit(scene_index):
            return None
        cameras = self.problem.cameras.take(self.imagers.camera[rows])
        return np.asarray(sensor.electrons_for_snr(
            wanted, noise_variance_e2=np.square(cameras.read_noise_e), prnu_frac=cameras.prnu_frac
        ))  # fmt: skip

    def _longest_time_s(self, focused: Any, rows: Array) -> Array:
        """An upper bound of the light-collecting time of any light."""
        cameras = self.problem.cameras.take(self.imagers.camera[rows])
        with np.errstate(divide="ignore"):
            exposure = np.minimum(
                np.minimum(cameras.max_exposure_s, self.limits.max_exposure_ms * 1e-3), 1.0 / focused.rate_hz
            )
        return np.asarray(np.minimum(exposure + cameras.exposure_offset_s, focused.blur_time_s))

    def is_sunlit(self, scene_index: int) -> bool:
        """Whether light counts that no lamp gives."""
        return bool(self.problem.scenes[scene_index].sunlit and self.problem.effects.sunlight)

    def most_contrast(
        self, scene_index: int, lightings: Sequence[Lighting], rows: Array, altitude: int | None = None
    ) -> Array:
        """Most contrast in one scene under the clearest of some lightings, at the nominal altitude unless given."""
        if not self.problem.effects.forward_veil or self.is_sunlit(scene_index):
            return np.ones(len(rows))
        at = self.problem.scenes[scene_index].nominal if altitude is None else altitude
        return 1.0 / (1.0 + self.veils.least(scene_index, lightings, rows, at))

    @cached_property
    def _of_each_optics(self) -> list[Lighting]:
        """One lighting of each optics: bounds of veils know no mount, of which there may be hundreds."""
        return list({one.optics: one for one in self.tables.lightings}.values())

    def least_veil(self, scene_index: int, rows: Array) -> Array:
        """Least veil over signal under any lighting, at the farthest altitude and the nominal one, (n, 2)."""
        clearest = [self.most_contrast(scene_index, self._of_each_optics, rows, altitude) for altitude in (-1, None)]
        return 1.0 / np.stack(clearest, axis=1) - 1.0


def light_for_signal(need: Needs, signal_e: Array) -> Array:
    """Light * time over the square of the f-number that the SNR of the mean and the gain need, (n,).

    signal_e : electrons per lm s at most, at the farthest altitude and the nominal one, (n, 2)
    """
    light_x = np.where(need.by_snr_e > 0, need.by_snr_e / signal_e, 0.0).max(axis=1)
    return np.asarray(np.maximum(light_x, np.where(need.by_gain_e > 0, need.by_gain_e / signal_e[:, -1], 0.0)))


def light_times(need: Needs, light_x: Array, kind: int) -> tuple[Array, Array]:
    """The same as light * time at the smallest f-number, and as the capacity of lamps of one kind that it takes."""
    light_time = np.where(light_x > 0, light_x * need.square, 0.0)
    wanted = light_time if kind == FLASH else light_time / need.longest_s
    return light_time, np.where(need.longest_s > 0, wanted, np.inf)


def least_mean_frac(scene: SceneOptics) -> float:
    """Least mean signal of an image over that of the pixel that must reach the SNR.

    No mean is below its darkest pixel. Where a share of the image may be dark, the mean has at least the rest's.
    """
    return FRAME_SHARE * LATTICE_MARGIN if scene.pixels == "frame" else 1.0


def most_held_e(cameras: Cameras, scene: SceneOptics) -> Array:
    """The most electrons of all light that sensors hold as a mean at the nominal altitude, (n,)."""
    needs, full_scale = scene.view.requirements, 2.0**cameras.bits - 1.0
    share = 1.0 / needs.highlight_ratio if needs.mean_level is None else needs.mean_level
    by_level = (share * full_scale - cameras.black_level_dn) / cameras.gain_dn_per_e
    return np.asarray(np.minimum(cameras.saturation_e / needs.highlight_ratio, by_level))
