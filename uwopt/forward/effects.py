"""What a scene does not need: an upper bound of each effect's influence, and what may be left out.

The influence of an effect is the largest change that leaving it out makes to any requirement or
objective: of ratios absolutely, of decibels by a tenth of a decibel's number (0.05 dB count as 0.005), of
all else relatively. Veils change signal, noise, level and contrast by no more than their share of the
image-forming light, so bounds are bounds of shares; they come from coarse integrals with a margin.
Effects are left out while the sum of their bounds stays within the tolerance.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.designs import Hardware
from uwopt.forward.figures import SettingRows, full_light_lm
from uwopt.forward.lamp_light import COARSE_ORDER, SMOOTH_MARGIN, LampField
from uwopt.forward.lamps import LampGroup, one_side
from uwopt.forward.part_columns import CONTINUOUS
from uwopt.forward.problem import Problem
from uwopt.forward.spectra import LARGEST_EXPONENT, TINY, sees_colours
from uwopt.forward.sun_light import SunField
from uwopt.forward.views import Views
from uwopt.model import beam as beams
from uwopt.model import port
from uwopt.model.effects import Effects
from uwopt.model.image_mean import pixel_grid
from uwopt.model.imaging import floor_point
from uwopt.results.basis import UsedEffect

EDGE_MARGIN = 3.0  # where the beam ends sharply
FORWARD_MARGIN = 1.05  # the spectrum at the ends of the lamp's ranges bounds what lies between
PIXELS = 5  # a side, where the worst pixel counts
FULL_OVER_COARSE = 12.0  # nodes of the full backscatter integral over the coarse one, as measured
MOST_SHARE = 1e200  # of a veil over what it veils: sums of such are finite
KEPT = float("inf")


@dataclass(frozen=True)
class Influence:
    """One effect in the scenes at hand."""

    name: str
    bound: float  # inf: asked for by a requirement of its own, not worth bounding
    kept: bool
    time_saved_s: float  # estimated

    def used(self) -> UsedEffect:
        """As a result tells it."""
        bound = None if np.isinf(self.bound) else self.bound
        return UsedEffect(self.name, bound, self.kept, self.time_saved_s)


@dataclass(frozen=True)
class InScene:
    """One design in one scene, as wide as it looks, with what is set on it."""

    scene_index: int
    view: Views
    hardware: Hardware
    settings: SettingRows | None = None  # None: not known yet, so that sunlight is kept
    signal_e: Array | None = None  # image-forming light per lm s, where it is known

    def field(self, problem: Problem, channel: str | None = None) -> LampField:
        """Its lamps' light, all of it or one colour."""
        lit = LampGroup(self.optics(problem), self.hardware.mount, self.hardware.count)
        return LampField(
            problem, self.scene_index, port_index=self.hardware.port, lit=lit, efficiency=self.efficiency(problem),
            channel=channel,
        )  # fmt: skip

    def optics(self, problem: Problem) -> int:
        """Of its lamps."""
        return int(problem.lights.optics_index[self.hardware.light])

    def efficiency(self, problem: Problem) -> int:
        """The curves of its sensor."""
        return int(problem.cameras.qe_index[self.hardware.camera])


def choose(influences: dict[str, tuple[float, float]], tolerance: float) -> list[Influence]:
    """Leave out the smallest bounds as long as their sum stays within the tolerance."""
    spent, chosen = 0.0, []
    for name, (bound, saved_s) in sorted(influences.items(), key=lambda item: item[1][0]):
        fits = spent + bound <= tolerance
        spent += bound if fits else 0.0
        chosen.append(Influence(name, bound, not fits, saved_s if fits else 0.0))
    order = Effects.names()
    return sorted(chosen, key=lambda item: order.index(item.name))


def effects_kept(influences: Sequence[Influence]) -> Effects:
    """The model that keeps what must be kept."""
    return Effects().without(item.name for item in influences if not item.kept)


def judge(
    problem: Problem, scenes: Sequence[InScene], *, information: bool = False
) -> dict[str, tuple[float, float]]:
    """Largest bound of each effect over the scenes of a design, and the time that leaving it out would save [s].

    `information`: the objective asks for it.
    """
    worst = dict.fromkeys(Effects.names(), 0.0)
    saved = dict.fromkeys(Effects.names(), 0.0)
    for seen in scenes:
        for name, (bound, saved_s) in bounds_of(problem, seen, information=information).items():
            worst[name] = max(worst[name], bound)
            saved[name] += saved_s
    return {name: (worst[name], saved[name]) for name in worst}


def bounds_of(problem: Problem, seen: InScene, *, information: bool) -> dict[str, tuple[float, float]]:
    """Bound and time saved of each effect for a design in one scene."""
    scene = problem.scenes[seen.scene_index]
    needs = scene.view.requirements
    found = dict.fromkeys(Effects.names(), (0.0, 0.0))
    shape = problem.shape(seen.hardware.port, seen.scene_index)
    view, field = seen.view, partial(seen.field, problem)
    if needs.dof_at == "corner" or needs.resolve_mm is not None or information:
        found["image_curvature"] = found["lateral_colour"] = (KEPT, 0.0)
    if not shape.is_dome:
        corner = np.hypot(view.tan_along, view.tan_across)
        oblique = port.flat_port_transmittance(corner, n_water=shape.n_water, n_glass=shape.n_glass)
        head_on = port.normal_port_transmittance(n_water=shape.n_water, n_glass=shape.n_glass)
        found["window_angle"] = (float(np.max(1.0 - oblique / head_on)), 0.0)
    start = time.perf_counter()
    signal = seen.signal_e
    if signal is None or problem.is_dark(seen.optics(problem)):  # shares are those of a lamp that burns
        signal = field().light(view, veils="none").signal_e
    signal_s = time.perf_counter() - start
    lights = {None: signal} | {
        name: field(channel=name).light(view, veils="none").signal_e for name in channels_of(problem, seen)
    }
    if scene.scatters:
        bound = max(forward_bound(field(channel=one), view, light) for one, light in lights.items())
        found["forward_veil"] = (bound, signal_s)
        start = time.perf_counter()
        bound = max(backscatter_bound(field(channel=one), view, light) for one, light in lights.items())
        found["backscatter"] = (bound, FULL_OVER_COARSE * (time.perf_counter() - start))
    if scene.at_worst and scene.scatters:
        forward, back = worst_pixel_shares(field(), view)
        found["forward_veil"] = (max(found["forward_veil"][0], forward), found["forward_veil"][1])
        found["backscatter"] = (max(found["backscatter"][0], back), found["backscatter"][1])
    if field().contraction.multiple:
        once = problem.with_effects(problem.effects.without(["multiple_scattering"]))
        bound = max(
            orders_bound(field(channel=one), seen.field(once, one), view, light) for one, light in lights.items()
        )
        found["multiple_scattering"] = (bound + found["forward_veil"][0] + found["backscatter"][0], 0.0)
    if scene.sunlit:
        sun = max(
            sun_bound(problem, seen, light, information=information, channel=one) for one, light in lights.items()
        )
        found["sunlight"] = (sun, 0.0)
        if field().contraction.multiple:  # daylight's veils change too, by no more than either of them
            other = max(
                sun_bound(once, seen, light, information=information, channel=one) for one, light in lights.items()
            )
            bound, saved_s = found["multiple_scattering"]
            found["multiple_scattering"] = (bound + sun + other, saved_s)
    return found


def channels_of(problem: Problem, seen: InScene) -> tuple[str, ...]:
    """Colour channels of a design's sensor that something is asked of."""
    curves = problem.efficiencies[seen.efficiency(problem)]
    return problem.scenes[seen.scene_index].channels if sees_colours(curves) else ()


def orders_bound(many: LampField, once: LampField, view: Views, signal: Array) -> float:
    """Most that single scattering changes of the image-forming light, with the veils that it has itself.

    What the veils of all orders are is bounded apart: two positive numbers differ by no more than the greater.
    """
    if not many.contraction.response(many.spectrum, many.efficiency, many.channel) > 0.0:  # a black floor
        return 0.0
    changed = most_apart(signal, once.light(view, veils="none").signal_e)
    if many.scene.at_worst or many.scene.view.requirements.min_uniformity is not None:
        along, across = pixel_grid(view.tan_along, view.tan_across, n_points=PIXELS)
        there = [field.at_pixels(view, along, across, veils=False)[0] for field in (many, once)]
        changed += most_apart(*there) * margin(many)
    if not changed < MOST_SHARE:
        return KEPT
    return changed + forward_bound(once, view, signal) + backscatter_bound(once, view, signal) * (1.0 + changed)


def most_apart(one: Array, other: Array) -> float:
    """Largest relative difference of light from another (...,); inf where one alone is dark."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        apart = np.where(one == other, 0.0, np.abs(one / other - 1.0))
    return float(np.max(apart, initial=0.0))


def forward_bound(field: LampField, view: Views, signal: Array) -> float:
    """Most that exp(-K r) - exp(-c r) can be of exp(-c r) over the detected spectrum, on the longest ray; and the mean
    of what comes from elsewhere on the floor over the image-forming light."""
    scene, contraction = field.scene, field.contraction
    weight = contraction.weight(field.spectrum, field.efficiency, field.channel)
    excess = scene.attenuation_per_m - contraction.near_leg_per_m()
    lamp_leg = contraction.lamp_leg_per_m(field.spectrum)
    lit = weight > 0
    if not lit.any():  # a black floor
        return 0.0
    most = 0.0
    for range_m in (float(scene.range_m[0]), float(scene.range_m[-1])):
        _, _, path_m = floor_point(view.tan_along, view.tan_across, shape=field.shape, range_m=range_m)
        longest = float(path_m.max())
        for lamp_m in lamp_ways_m(field, view, range_m):
            optical = lamp_leg * lamp_m + scene.attenuation_per_m * longest
            seen = weight[lit] * np.exp(-(optical[lit] - optical[lit].min()))
            veil = np.expm1(np.minimum(excess[lit] * longest, LARGEST_EXPONENT))
            most = max(most, float((seen * veil).sum() / seen.sum()))
    if contraction.multiple:
        response = contraction.response(field.spectrum, field.efficiency, field.channel)
        wide = response * view.collecting_m2[:, None] * field.mean_wide(view)
        most += min(float(np.max(wide / np.maximum(signal, TINY))), MOST_SHARE)
    return most * FORWARD_MARGIN


def lamp_ways_m(field: LampField, view: Views, range_m: float) -> tuple[float, float]:
    """No lamp's way to a place in the image is shorter, and none longer [m]."""
    x_m, y_m, _ = floor_point(view.tan_along, view.tan_across, shape=field.shape, range_m=range_m)
    height = min(range_m - z for z in field.lamps.z_m)
    aside = float(np.hypot(x_m, y_m).max()) + max(
        float(np.hypot(x, y)) for x, y in zip(field.lamps.x_m, field.lamps.y_m, strict=True)
    )
    return height, float(np.hypot(height, aside))


def margin(field: LampField) -> float:
    """What a coarse integral is multiplied with."""
    return EDGE_MARGIN if beams.has_sharp_edge(field.beam) else SMOOTH_MARGIN


def backscatter_bound(field: LampField, view: Views, signal: Array) -> float:
    """A coarse mean of the lamps' path radiance over the image-forming light, with a margin."""
    from uwopt.model.veil.mean import mean_backscatter

    most = 0.0
    for index in {0, len(field.scene.range_m) - 1}:
        range_m = float(field.scene.range_m[index])
        coarse = mean_backscatter(
            view.tan_along, view.tan_across, lamps=one_side(field.lamps), scatterers=field.scatterers(range_m),
            order=COARSE_ORDER, **field.sent_back(range_m),
        )  # fmt: skip
        share = coarse * view.collecting_m2 / np.maximum(signal[:, index], TINY)
        most = max(most, float(np.max(share)))
    if field.scene.open_water:
        behind = field.mean_background(view, order=COARSE_ORDER) * view.collecting_m2 * margin(field)
        if np.any(behind > signal.max(axis=1)):  # the brightest that must not saturate
            return KEPT
    return most * margin(field)


def worst_pixel_shares(field: LampField, view: Views) -> tuple[float, float]:
    """Most that each veil can be of the image-forming light in any pixel."""
    along, across = pixel_grid(view.tan_along, view.tan_across, n_points=PIXELS)
    forward, back = field.veils_at_pixels(along, across)
    shares = float(forward.max()) * FORWARD_MARGIN, float(back.max()) * margin(field)
    return min(shares[0], MOST_SHARE), min(shares[1], MOST_SHARE)


def sun_bound(
    problem: Problem, seen: InScene, signal: Array, *, information: bool, channel: str | None = None
) -> float:
    """Most that sunlight can be of the lamps' image-forming light; inf where it would smear the image."""
    settings, scene, hardware = seen.settings, problem.scenes[seen.scene_index], seen.hardware
    if settings is None or scene.at_worst:  # the worst pixel may have no other light
        return KEPT
    cameras = problem.cameras.take(np.array([hardware.camera]))
    lights = problem.lights.take(np.array([hardware.light]))
    open_s = settings.exposure_s + cameras.exposure_offset_s
    pulsed = lights.kind != CONTINUOUS
    lit_s = np.where(pulsed, np.minimum(settings.pulse_s, open_s), open_s)
    needs = scene.view.requirements
    if np.any(lit_s < open_s) and (
        needs.max_blur_px is not None or needs.asks_sharpness or information
    ):
        return KEPT
    sun = SunField(
        problem, seen.scene_index, port_index=hardware.port, efficiency=int(cameras.qe_index[0]), channel=channel
    ).light(seen.view)
    lamps = full_light_lm(lights, np.array([hardware.count])) * settings.level * lit_s * lights.output_factor
    every = (sun.signal_e_s + sun.veil_e_s) * open_s[:, None]
    return float(np.max(every / np.maximum(signal * lamps[:, None], TINY)))
