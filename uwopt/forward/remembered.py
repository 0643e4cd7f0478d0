"""Light of images that are alike, worked out once a scene.

Cameras with the same sensor behind the same lens and port see the same light per collecting area, and so do their
counterparts in the next search in that scene: a catalogue of ten thousand imagers has some hundred images.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import spend
from uwopt.forward.columns import array_in_places, rows_alike
from uwopt.forward.lamp_light import LampField
from uwopt.forward.lamps import one_side
from uwopt.forward.light_columns import SunLight
from uwopt.forward.scene import COLOURS, Pixels
from uwopt.forward.spectra import sees_colours
from uwopt.forward.sun_light import SunField
from uwopt.forward.views import Views
from uwopt.model import sensor
from uwopt.model.image_mean import field_mean
from uwopt.model.imaging import Lamps

MOST_NUMBERS = 4_000_000  # that are kept of one lighting: light at pixels takes some thousand an image
ImageKey = tuple[float, float]


def once_an_image(known: dict[ImageKey, Any], view: Views, make: Callable[[Views], Array]) -> Array:
    """Rows (n, ...) of images, one made of each field of view that is not known yet; shorter ones repeat their end."""
    first, back = rows_alike(view.tan_along, view.tan_across)
    keys = list(zip(view.tan_along[first].tolist(), view.tan_across[first].tolist(), strict=True))
    new = [place for place, key in enumerate(keys) if key not in known]
    rows = {key: known[key] for key in keys if key in known}
    if new:
        made = make(view.take(first[new]))
        rows.update((keys[place], row) for place, row in zip(new, made, strict=True))
        if (len(known) + len(new)) * made[0].size > MOST_NUMBERS:
            known.clear()
        known.update(rows)
    parts = [rows[key] for key in keys]
    if len({part.shape for part in parts}) == 1:
        return np.stack(parts)[back]
    return array_in_places([(np.array([n]), part[None]) for n, part in enumerate(parts)], len(parts))[back]


class RememberedField(LampField):
    """One lighting seen by imagers, each image of which is integrated once; see `LampField`."""

    memory = "light"

    def once(self, what: Any, view: Views, make: Callable[[Views], Array]) -> Array:
        """Rows of images from the scene's memory, or made."""
        water = (*self.contraction.key(self.spectrum, self.efficiency, self.channel), self.contraction.reach_m)
        model = (self.effects, self.fineness, self.problem.lowest_m(self.scene_index))
        key = (self.memory, what, self.beam, self.shape, water, model)
        return once_an_image(self.scene.cache.setdefault(key, {}), view, make)

    def mean_gain(self, view: Views, *, forward: bool) -> Array:
        """As `LampField`."""
        make = super().mean_gain
        return self.once(("mean", self.lamps, forward), view, lambda new: make(new, forward=forward))

    def far_balance(self, view: Views) -> Array:
        """White balance of the means over these images at the farthest altitude, (n,); 1 of a mono sensor."""
        if not sees_colours(self.problem.efficiencies[self.efficiency]):
            return np.ones(len(view.tan_along))

        def made(new: Views) -> Array:
            return sensor.white_balance(np.stack([self.far_signal(new, name) for name in COLOURS], axis=1))

        return self.once(("far balance", self.lamps), view, made)

    def far_signal(self, view: Views, channel: str) -> Array:
        """Signal of a channel per collecting area at the farthest altitude, (n,); as `LampField.light`."""
        loss = self.problem.table(self.scene_index, self.spectrum, self.efficiency, channel)
        gain = field_mean(
            view.tan_along, view.tan_across, lamps=one_side(self.lamps), table=loss, fineness=self.fineness.image,
            **self.common(float(self.scene.range_m[-1])),
        )  # fmt: skip
        return np.asarray(self.contraction.response(self.spectrum, self.efficiency, channel) * gain)

    def mean_backscatter(self, view: Views) -> Array:
        """As `LampField`."""
        return self.once(("backscatter", self.lamps), view, super().mean_backscatter)

    def mean_background(self, view: Views, order: int | None = None) -> Array:
        """As `LampField`."""
        make = super().mean_background
        return self.once(("background", self.lamps, order), view, lambda new: make(new, order))

    def coarse_backscatter(self, view: Views, altitudes: list[int]) -> Array:
        """As `LampField`."""
        make = super().coarse_backscatter
        return self.once(("coarse", self.lamps), view, lambda new: make(new, altitudes))

    def likely_gain(self, view: Views, pixels: Pixels, lamps: Lamps) -> Array:
        """As `LampField`."""
        make = super().likely_gain
        return self.once(("likely", lamps, pixels), view, lambda new: make(new, pixels, lamps))

    def likely_veiled(self, view: Views, pixels: Pixels) -> tuple[Array, Array]:
        """As `LampField`."""
        make = super().likely_veiled

        def per_area(new: Views) -> Array:
            return np.stack(make(new, pixels), axis=2) / new.collecting_m2[:, None, None, None]

        both = self.once(("likely veiled", self.lamps, pixels), view, per_area)
        both = both * view.collecting_m2[:, None, None, None]
        return both[:, :, 0], both[:, :, 1]

    def asked_pixels(
        self, view: Views, pixels: Pixels, *, veils: bool, ranges_m: Array
    ) -> tuple[Array, Array | None]:
        """As `LampField`; of the darkest pixels those are kept that others are asked for too, so none is remembered."""
        make = super().asked_pixels
        if pixels == "darkest":
            return make(view, pixels, veils=veils, ranges_m=ranges_m)

        def per_area(new: Views) -> Array:
            spend("pixels")
            signal, veil_there = make(new, pixels, veils=veils, ranges_m=ranges_m)
            both = signal[:, :, None] if veil_there is None else np.stack([signal, veil_there], axis=2)
            return both / new.collecting_m2[:, None, None, None]

        key = "pixels", self.lamps, veils, tuple(ranges_m.tolist())
        both = self.once(key, view, per_area) * view.collecting_m2[:, None, None, None]
        return both[:, :, 0], both[:, :, 1] if self.veiled(veils) else None


class LoneField(RememberedField):
    """The same of images that are integrated one at a time.

    What stands beside an image in a mean moves its figures by some 1e-7; a design that is evaluated has the
    same ones whatever was searched before.
    """

    memory = "light of one image"


class RememberedSunField(SunField):
    """Daylight seen by imagers, each image of which is worked out once; see `SunField`."""

    def light(
        self, view: Views, *, pixels: Pixels | None = None, half_grid: bool = False, few: bool = False
    ) -> SunLight:
        """As `SunField`."""
        make = super().light
        curves = tuple(sorted(self.curves.items()))
        points = self.problem.pixels_a_side(self.scene_index)
        key = ("sun", self.multiple, self.shape, curves, self.channel, pixels, half_grid, few, points, self.fineness)

        def per_area(new: Views) -> Array:
            light = make(new, pixels=pixels, half_grid=half_grid, few=few)
            means = np.stack([light.signal_e_s, light.forward_e_s, light.path_e_s], axis=2)
            there = [c for c in (light.worst_e_s, light.worst_veil_e_s) if c is not None]
            return np.concatenate([means, *there], axis=2) / new.collecting_m2[:, None, None]

        rows = once_an_image(self.scene.cache.setdefault(key, {}), view, per_area)
        rows = rows * view.collecting_m2[:, None, None]
        signal, forward, path = np.moveaxis(rows[:, :, :3], 2, 0)
        if pixels is None:
            return SunLight(signal, forward, path)
        worst, veil = np.split(rows[:, :, 3:], 2, axis=2)
        return SunLight(signal, forward, path, worst, veil)
