"""What the lamps' light becomes in the pixels of many imagers: signal, veils, and where the image is worst.

Everything is in electrons per lm s of light behind the lamps' windows, at a working f-number of 1, by
altitude: constants of hardware and scene that settings only scale.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import distinct
from uwopt.forward.lamps import (
    LampGroup,
    on_axis_gain,
    one_side,
)
from uwopt.forward.light_columns import ImageLight, added
from uwopt.forward.pixels import decisive_pixels, worst_candidates
from uwopt.forward.problem import Problem
from uwopt.forward.scene import Pixels
from uwopt.forward.spectra import LightPart, sees_colours
from uwopt.forward.views import Views
from uwopt.model import beam as beams
from uwopt.model.image_mean import (
    FEW_FRAME_MAY_MISS,
    FRAME_MAY_MISS,
    along_symmetric,
    each_lamp,
    field_means,
    frame_places,
    pixel_grid,
    reached_by_most,
)
from uwopt.model.imaging import Lamps, local_gain, local_gains
from uwopt.model.veil.geometry import of_each
from uwopt.model.veil.mean import mean_backscatter
from uwopt.model.veil.ray import backscatter_gain
from uwopt.model.veil.spots import Spots, floor_spots
from uwopt.model.veil.wide import mean_wide_gain, wide_gain
from uwopt.tolerances import ROUND

Veils = Literal["none", "forward", "coarse", "likely", "all"]  # what is worked out, each with those before it

COARSE_ORDER = 4  # nodes a side of the image in bounds of backscatter
SMOOTH_MARGIN = 1.5  # times and over a coarse integral: bounds; errors of wide lobes stay below 5 %
NEXT_TO_NONE_PER_M2 = 1e-9  # of what stands for no lamp: less than any lamp gives
LIKELY_PLACES = 72  # of those over the frame, the outermost: the darkest 5 % are among them as a rule
LIKELY_A_SIDE = 3  # of the grid on which the darkest is looked for: its middle, edges and corners
COARSE_FROM_RAD = float(np.deg2rad(15.0))  # half-power angle from which a lobe counts as wide


class LampField:
    """One lighting seen by imagers that share scene, port and efficiency curve."""

    def __init__(
        self, problem: Problem, scene_index: int, *, port_index: int, lit: LampGroup, efficiency: int,
        channel: str | None = None,
    ):  # fmt: skip
        self.problem, self.scene_index, self.effects = problem, scene_index, problem.effects
        self.scene, self.contraction = problem.scenes[scene_index], problem.contractions[scene_index]
        self.fineness = self.scene.fineness
        self.shape = problem.shape(port_index, scene_index)
        self.beam = problem.beam(scene_index, lit.optics)
        self.spectrum = int(self.contraction.spectrum_of[lit.optics])
        self.efficiency, self.channel = efficiency, channel
        self.lamps, self.mount, self.optics = lit.lamps, lit.mount, lit.optics

    # ------------------------------------------------------------ means

    def light(
        self, view: Views, *, pixels: Pixels | None = None, veils: Veils, means: bool = True,
        known: ImageLight | None = None, altitude: int | None = None,
    ) -> ImageLight:  # fmt: skip
        """All light of these imagers; `known` holds what has been worked out already.

        Without `means` only the pixels count, and the darkest stands for the mean; with an `altitude` those there,
        which stand for all.
        """
        if not means:
            assert pixels is not None
            if veils == "likely":
                return self.at_likely_veiled(view, pixels)
            return self.at_asked_pixels(view, pixels, veils=veils != "none", altitude=altitude)
        columns = view.collecting_m2[:, None]
        response = self.contraction.response(self.spectrum, self.efficiency, self.channel)
        if self.problem.paper:
            loss = self.contraction.straight_loss(self.spectrum, self.efficiency, self.channel)
            return ImageLight(
                columns * response * (on_axis_gain(self.beam, self.scene.range_m) * loss)[None, :]
            )
        signal = columns * response * self.mean_gain(view, forward=False) if known is None else known.signal_e
        forward = backscatter = None
        if known is not None and known.forward_e is not None:
            forward = known.forward_e
        elif veils != "none" and self.effects.forward_veil and self.scene.scatters:
            forward = columns * response * self.mean_gain(view, forward=True)
        if veils == "all" and self.effects.backscatter and self.scene.scatters:
            backscatter = columns * self.mean_backscatter(view)
        light = ImageLight(signal, forward, backscatter)
        if veils == "all" and self.effects.backscatter and self.scene.open_water:
            light = replace(light, background_e=(view.collecting_m2 * self.mean_background(view))[:, None])
        if veils == "coarse" and self.effects.backscatter and self.scene.scatters:
            light = self.between_bounds(view, light)
        if pixels is None:
            return light
        return light.with_pixels(self.at_asked_pixels(view, pixels, veils=veils != "none"))

    def common(self, range_m: float) -> dict[str, Any]:
        """What all functions of light on the floor take."""
        return dict(shape=self.shape, range_m=range_m, beam=self.lobe(range_m))

    def lobe(self, range_m: float) -> beams.Beam:
        """The lamps' beam as it falls on the floor."""
        return self.problem.floor_lobe(self.scene_index, self.optics, self.mount, range_m)

    def sent_back(self, range_m: float | Array) -> dict[str, Any]:
        """The same of light that the water sends back."""
        return dict(shape=self.shape, range_m=range_m, beam=self.contraction.back_lobe(self.optics))

    def loss_table(self, part: LightPart = "image", range_m: float = 0.0) -> Any:
        """Water's loss on both legs; see `Contraction.table`."""
        return self.problem.table(
            self.scene_index, self.spectrum, self.efficiency, self.channel, part=part, range_m=range_m
        )

    def mean_gain(self, view: Views, *, forward: bool) -> Array:
        """Mean over the image of the light that forms it, or of the forward veil, (n, n_altitudes) [1/m^2]."""
        near = field_means(
            view.tan_along, view.tan_across, ranges_m=self.scene.range_m, shape=self.shape, lamps=one_side(self.lamps),
            lobes=[self.lobe(float(range_m)) for range_m in self.scene.range_m],
            table=self.loss_table("near" if forward else "image"), fineness=self.fineness.image,
        )  # fmt: skip
        return near + self.mean_wide(view) if forward and self.contraction.multiple else near

    def mean_wide(self, view: Views) -> Array:
        """Mean over the image of the forward veil from elsewhere on the floor, (n, n_altitudes) [1/m^2]."""
        return np.stack(
            [
                mean_wide_gain(
                    view.tan_along, view.tan_across, spots=self.spots(range_m, one_side(self.lamps)), shape=self.shape,
                    fineness=self.fineness.image, **self.wide(range_m),
                )
                for range_m in map(float, self.scene.range_m)
            ],
            axis=1,
        )  # fmt: skip

    def wide(self, range_m: float) -> dict[str, Any]:
        """Loss of the veil from elsewhere, and the shares of its kernels."""
        curve = self.spectrum, self.efficiency, self.channel
        return dict(
            table=self.loss_table("wide", range_m), shares=self.contraction.wide_shares(*curve, range_m=range_m)
        )

    def spots(self, range_m: float, lamps: Lamps) -> Spots:
        """The lit floor as cameras behind this port see it."""
        return floor_spots(lamps=lamps, fineness=self.fineness.image, **self.common(range_m))

    def forward_at(self, along: Array, across: Array, range_m: float) -> tuple[Array, Array]:
        """Gains of the light that forms the image and of the forward veil at field points [1/m^2]."""
        tables = self.loss_table(), self.loss_table("near")
        image, veil = local_gains(along, across, tables=tables, lamps=self.lamps, **self.common(range_m))
        if self.contraction.multiple:
            spots = self.spots(range_m, self.lamps)
            veil = veil + wide_gain(along, across, spots=spots, shape=self.shape, **self.wide(range_m))
        return image, veil

    def scatterers(self, range_m: float) -> Any:
        """Particles and molecules before a floor so far off, with their loss tables."""
        return self.contraction.scatterers(self.spectrum, self.efficiency, self.channel, range_m=range_m)

    def is_wide(self) -> bool:
        """Whether a coarse integral over the image is near enough to bound the fine one."""
        smooth = self.beam.kind == "cosine-power" and not beams.has_sharp_edge(self.beam)
        level = all(z <= 0.0 and aim[2] > 0.9 for z, aim in zip(self.lamps.z_m, self.lamps.aim, strict=True))
        return smooth and level and beams.half_power_angle_rad(self.beam) >= COARSE_FROM_RAD

    def between_bounds(self, view: Views, light: ImageLight) -> ImageLight:
        """The light with backscatter at its least and its most, from coarse integrals at three altitudes.

        Altitudes between take the lesser and the greater of their neighbours. Where a coarse integral tells nothing,
        the least is none and the most has no end.
        """
        if not self.is_wide():
            none = np.zeros_like(light.signal_e)
            return replace(light, backscatter_e=none, most_veil_e=np.full_like(none, np.inf))
        count = len(self.scene.range_m)
        places = sorted({0, count // 2, count - 1})
        coarse = view.collecting_m2[:, None] * self.coarse_backscatter(view, places)
        before = np.searchsorted(places, np.arange(count), side="right") - 1
        after = np.searchsorted(places, np.arange(count))
        least = np.minimum(coarse[:, before], coarse[:, after]) / SMOOTH_MARGIN
        most = np.maximum(coarse[:, before], coarse[:, after]) * SMOOTH_MARGIN
        return replace(light, backscatter_e=least, most_veil_e=added(light.forward_e, most))

    def coarse_backscatter(self, view: Views, altitudes: list[int]) -> Array:
        """Mean of the lamps' path radiance at some altitudes by few nodes, (n, n_altitudes)."""
        return self.backscatter_at(self.scene.range_m[altitudes], view, order=COARSE_ORDER)

    def mean_backscatter(self, view: Views) -> Array:
        """Mean of the lamps' path radiance over the image, (n, n_altitudes)."""
        return self.backscatter_at(self.scene.range_m, view, fineness=self.fineness.veil)

    def backscatter_at(self, ranges_m: Array, view: Views, **how: Any) -> Array:
        """Mean of the lamps' path radiance over the image at some altitudes, all in one, (n, n_altitudes)."""
        image, altitude = (part.ravel() for part in np.indices((len(view.tan_along), len(ranges_m))))
        means = mean_backscatter(
            view.tan_along[image], view.tan_across[image], lamps=one_side(self.lamps),
            scatterers=of_each([self.scatterers(float(range_m)) for range_m in ranges_m], altitude),
            **self.sent_back(ranges_m[altitude]), **how,
        )  # fmt: skip
        return means.reshape(len(view.tan_along), len(ranges_m))

    def mean_background(self, view: Views, order: int | None = None) -> Array:
        """Mean over the image of what the lamps' light makes of water without a target or an end, (n,)."""
        scatterers, end_m = self.contraction.endless_scatterers(self.spectrum, self.efficiency, self.channel)
        return mean_backscatter(
            view.tan_along, view.tan_across, lamps=one_side(self.lamps), scatterers=scatterers, order=order,
            fineness=self.fineness.veil, **self.sent_back(max(end_m, 2.0 * float(self.scene.range_m[-1]))),
        )  # fmt: skip

    # ------------------------------------------------------------ pixels

    def at_asked_pixels(
        self, view: Views, pixels: Pixels, *, veils: bool, altitude: int | None = None
    ) -> ImageLight:
        """Signal and veil at the pixels that may decide whether an SNR holds; the darkest stands for the mean.

        altitude : the only one that counts, which stands for all; all unless given
        """
        ranges_m = self.scene.range_m if altitude is None else self.scene.range_m[altitude : altitude + 1]
        signal, veil_there = self.asked_pixels(view, pixels, veils=veils, ranges_m=ranges_m)
        shape = (len(signal), len(self.scene.range_m), signal.shape[2])
        signal = np.broadcast_to(signal, shape)
        veil_there = None if veil_there is None else np.broadcast_to(veil_there, shape)
        may_miss = self.may_miss if pixels == "frame" and signal.shape[2] > 1 else 0
        return ImageLight(signal.min(axis=2), worst_e=signal, worst_veil_e=veil_there, may_miss=may_miss)

    def asked_pixels(
        self, view: Views, pixels: Pixels, *, veils: bool, ranges_m: Array
    ) -> tuple[Array, Array | None]:
        """Signal and veil there at some altitudes, (n, n_altitudes, n_pixels).

        Where no veil and no sun change their order, the pixels that may miss an SNR are the darkest: one is left; where
        there are veils alone, those that may decide.
        """
        if pixels == "darkest":
            return self.at_worst_pixels(view, veils=veils, ranges_m=ranges_m)
        places = frame_places(view.tan_along, view.tan_across, few=self.fineness.few_places)
        signal, veil_there = self.at_pixels(view, *places, veils=veils, ranges_m=ranges_m)
        if self.sunlit:  # which are worst depends on lamps and sun together
            return signal, veil_there
        if veil_there is None:
            return reached_by_most(signal, self.may_miss)[:, :, None], None
        return decisive_pixels(signal, veil_there, self.may_miss)

    @property
    def may_miss(self) -> int:
        """How many of the places over the frame may be darker."""
        return FEW_FRAME_MAY_MISS if self.fineness.few_places else FRAME_MAY_MISS

    def at_likely_pixels(self, view: Views, pixels: Pixels) -> Array:
        """Upper bound on the signal of the pixel that decides, at the farthest altitude: some of those asked for, (n,).

        What all but k of many pixels reach is no more than what all but k of some of them do.
        """
        gain = np.zeros(())
        for lamp, share in zip(each_lamp(self.lamps), self.lamps.share, strict=True):
            gain = gain + share * self.likely_gain(view, pixels, replace(lamp, share=(1.0,)))
        response = self.contraction.response(self.spectrum, self.efficiency, self.channel)
        may_miss = FRAME_MAY_MISS if pixels == "frame" else 0
        return np.asarray(view.collecting_m2 * response * reached_by_most(gain, may_miss) * ROUND)

    def at_likely_veiled(self, view: Views, pixels: Pixels) -> ImageLight:
        """Signal and veil at some of those pixels at the farthest altitude alone: for bounds.

        What all but k of many pixels ask for is no less than what all but k of some do, nor at any altitude less than
        at one of them.
        """
        signal, veil_there = self.likely_veiled(view, pixels)
        may_miss = FRAME_MAY_MISS if pixels == "frame" else 0
        return ImageLight(signal.min(axis=2), worst_e=signal, worst_veil_e=veil_there, may_miss=may_miss)

    def likely_veiled(self, view: Views, pixels: Pixels) -> tuple[Array, Array]:
        """Signal and veil there, (n, 1, n_pixels), of the pixels that may decide."""
        places, farthest_m = likely_dark_places(view, pixels), self.scene.range_m[-1:]
        signal, over = self.at_pixels(view, *places, veils=True, ranges_m=farthest_m)
        veil_there = np.zeros_like(signal) if over is None else over
        if self.sunlit:  # which decide depends on lamps and sun together
            return signal, veil_there
        return decisive_pixels(signal, veil_there, FRAME_MAY_MISS if pixels == "frame" else 0)

    def likely_gain(self, view: Views, pixels: Pixels, lamps: Lamps) -> Array:
        """`local_gain` of some lamps there, (n, n_pixels) [1/m^2]."""
        places = likely_dark_places(view, pixels)
        return local_gain(
            *places, table=self.loss_table(), lamps=lamps, **self.common(float(self.scene.range_m[-1]))
        )

    @property
    def sunlit(self) -> bool:
        """Whether the sun's light comes on top of the lamps'."""
        return self.scene.sunlit and self.effects.sunlight

    def at_worst_pixels(self, view: Views, *, veils: bool, ranges_m: Array) -> tuple[Array, Array | None]:
        """Signal and veil at every pixel of a grid that some setting could make the worst."""
        along, across = pixel_grid(
            view.tan_along, view.tan_across, half=along_symmetric(self.lamps, self.shape),
            n_points=self.problem.pixels_a_side(self.scene_index),
        )  # fmt: skip
        signal, veil_there = self.at_pixels(view, along, across, veils=veils, ranges_m=ranges_m)
        if self.sunlit:  # which is worst depends on lamps and sun together
            return signal, veil_there
        keep = worst_candidates(signal, veil_there)
        return signal[:, :, keep], None if veil_there is None else veil_there[:, :, keep]

    def at_pixels(
        self, view: Views, along: Array, across: Array, *, veils: bool, ranges_m: Array | None = None
    ) -> tuple[Array, Array | None]:
        """Signal and veil at field points (n, n_pixels) of these imagers, (n, n_altitudes, n_pixels).

        ranges_m : the altitudes that count; all unless given
        """
        collecting = view.collecting_m2[:, None]
        response = self.contraction.response(self.spectrum, self.efficiency, self.channel)
        signals, veil_sum = [], []
        scatters = veils and self.scene.scatters
        forward = scatters and self.effects.forward_veil
        for range_m in self.scene.range_m if ranges_m is None else ranges_m:
            if forward:
                signal, over = (response * gain for gain in self.forward_at(along, across, float(range_m)))
            else:
                signal = response * local_gain(
                    along, across, table=self.loss_table(), lamps=self.lamps, **self.common(float(range_m))
                )
                over = np.zeros_like(signal)
            if scatters and self.effects.backscatter:
                sent_back = partial(
                    backscatter_gain, scatterers=self.scatterers(float(range_m)), fineness=self.fineness.veil,
                    lamps=self.lamps, **self.sent_back(float(range_m)),
                )  # fmt: skip
                over = over + np.stack(list(map(sent_back, along, across)))  # by image: its rays choose the nodes
            signals.append(signal * collecting)
            veil_sum.append(over * collecting)
        return np.stack(signals, axis=1), np.stack(veil_sum, axis=1) if self.veiled(veils) else None

    def veiled(self, veils: bool) -> bool:
        """Whether pixels have a veil, if it is asked for."""
        return veils and self.scene.scatters and self.effects.veils

    def veils_at_pixels(self, along: Array, across: Array) -> tuple[Array, Array]:
        """Forward veil and backscatter over the image-forming light at field points, farthest and nearest."""
        shares: list[tuple[Array, Array]] = []
        response = self.contraction.response(self.spectrum, self.efficiency, self.channel)
        for range_m in (float(self.scene.range_m[0]), float(self.scene.range_m[-1])):
            signal, over = (gain * response for gain in self.forward_at(along, across, range_m))
            back = backscatter_gain(
                along, across, scatterers=self.scatterers(range_m), lamps=self.lamps, **self.sent_back(range_m)
            )
            lit = np.maximum(signal, 1e-300)
            with np.errstate(over="ignore"):
                shares.append((over / lit, back / lit))
        forward, backs = (np.maximum(a, b) for a, b in zip(*shares, strict=True))
        return forward, backs


class NoLampField(LampField):
    """What stands for no lamp, which lights nothing: next to no light, the same everywhere, and no veil.

    Its parts are made as a lamp's, so that a catalogue with it is one of lamps; none of it has to be integrated.
    """

    def mean_gain(self, view: Views, *, forward: bool) -> Array:
        """As `LampField`."""
        return np.full((len(view.tan_along), len(self.scene.range_m)), 0.0 if forward else NEXT_TO_NONE_PER_M2)

    def backscatter_at(self, ranges_m: Array, view: Views, **how: Any) -> Array:
        """As `LampField`."""
        return np.zeros((len(view.tan_along), len(ranges_m)))

    def mean_background(self, view: Views, order: int | None = None) -> Array:
        """As `LampField`."""
        return np.zeros(len(view.tan_along))

    def at_pixels(
        self, view: Views, along: Array, across: Array, *, veils: bool, ranges_m: Array | None = None
    ) -> tuple[Array, Array | None]:
        """As `LampField`."""
        ranges_m = self.scene.range_m if ranges_m is None else ranges_m
        response = self.contraction.response(self.spectrum, self.efficiency, self.channel)
        signal = view.collecting_m2[:, None] * response * np.full(along.shape, NEXT_TO_NONE_PER_M2)
        everywhere = np.repeat(signal[:, None], len(ranges_m), axis=1)
        return everywhere, np.zeros_like(everywhere) if self.veiled(veils) else None


def kind_of_field(problem: Problem, optics: int, of_lamps: type[LampField] = LampField) -> type[LampField]:
    """Of light with such optics: that of lamps, unless no lamp has them."""
    return NoLampField if problem.is_dark(optics) else of_lamps


def likely_dark_places(view: Views, pixels: Pixels) -> tuple[Array, Array]:
    """Pixels, of those that an SNR is asked of, that are likely to be darkest: tangents (n, n_pixels)."""
    if pixels == "darkest":
        return pixel_grid(view.tan_along, view.tan_across, n_points=LIKELY_A_SIDE)
    along, across = frame_places(view.tan_along, view.tan_across)
    outer = np.argpartition(-np.square(along) - np.square(across), LIKELY_PLACES, axis=1)[:, :LIKELY_PLACES]
    return np.take_along_axis(along, outer, axis=1), np.take_along_axis(across, outer, axis=1)


def with_colours(
    light: ImageLight, field: Callable[..., LampField], view: Views, *, veils: Veils, known: ImageLight | None
) -> ImageLight:
    """The light with that of the channels that something is asked of; none of a mono sensor.

    The veil of the red channel comes with the last of the veils; bounds do without.
    """
    first = field(channel=None)
    names = first.scene.channels
    if not sees_colours(first.problem.efficiencies[first.efficiency]):
        none = np.zeros_like(light.signal_e)
        return replace(light, colour_e=np.repeat(none[:, :, None], len(names), axis=2), red_veil_e=none)
    if known is None or known.colour_e is None:
        signals = [field(channel=name).light(view, veils="none").signal_e for name in names]
        colour = np.stack(signals, axis=2)
    else:
        colour = known.colour_e
    red_veil = np.zeros_like(light.signal_e)
    if veils == "all" and first.effects.veils and not first.problem.paper:
        red = field(channel="red").light(view, veils="all", known=ImageLight(colour[:, :, 0]))
        red_veil = red_veil if red.veil_e is None else red.veil_e
    return replace(light, colour_e=colour, red_veil_e=red_veil)


def image_light(
    problem: Problem, scene_index: int, view: Views, camera: Array, *, port_index: int, lit: LampGroup,
    channel: str | None = None, pixels: Pixels | None = None, veils: Veils = "all", means: bool = True,
    known: ImageLight | None = None, field_type: type[LampField] = LampField, altitude: int | None = None,
) -> ImageLight:  # fmt: skip
    """Electrons per lm s of light behind the lamps' windows, by altitude: the constants of the imaging chain.

    All rows of `view` share the port; `camera` says whose sensor each is. `channel` picks one colour.
    `pixels`: also at the pixels that an SNR is asked of; without `means` there alone, and then perhaps at one
    `altitude` that stands for all. `veils` says which are worked out, beside what is `known`. `field_type` may
    remember what it has worked out.
    """
    efficiency = problem.cameras.qe_index[camera]
    parts = []
    kind = kind_of_field(problem, lit.optics, field_type)
    for curve in distinct(efficiency)[0]:
        mine = np.nonzero(efficiency == curve)[0]
        field = partial(kind, problem, scene_index, port_index=port_index, lit=lit, efficiency=int(curve))
        given, seen = None if known is None else known.take(mine), view.take(mine)
        light = field(channel=channel).light(
            seen, pixels=pixels, veils=veils, means=means, known=given, altitude=altitude
        )
        if means and channel is None and problem.scenes[scene_index].channels:
            light = with_colours(light, field, seen, veils=veils, known=given)
        parts.append((mine, light))
    return ImageLight.in_places(parts, len(camera))
