"""Figures of designs with given settings, for one or for millions: the forward model.

The same functions that the search rests on, read the other way: hardware and settings in, what the
images would be like out. Arrays run over designs; a second axis runs over altitudes where a
requirement holds over a band.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward import switching
from uwopt.forward.columns import Columns
from uwopt.forward.focus import held_at_corner
from uwopt.forward.light_columns import ImageLight, SunLight, added, share_of
from uwopt.forward.motion import motion_across, motion_along, skew_by_altitude_px, subject_m_s
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED, Cameras, Lenses, Lights
from uwopt.forward.scene import SceneOptics
from uwopt.forward.sharpness import SharpRows
from uwopt.forward.views import Views, altitudes_m
from uwopt.model import lens as lens_model
from uwopt.model import light as light_model
from uwopt.model import operation, sensor
from uwopt.model.image_mean import reached_by_most
from uwopt.model.port import FocusMap, water_distance_m

PIXELS_AT_ONCE = 16_000  # whose arrays stay in the cache


@dataclass(frozen=True)
class SettingRows(Columns):
    """What is set on n designs in one scene; SI. `pulse_s` counts for pulsed LEDs and flashes only."""

    f_number: Array
    exposure_s: Array
    pulse_s: Array
    gain: Array
    level: Array
    rate_hz: Array
    dioptre_per_m: Array


@dataclass(frozen=True)
class DesignRows:
    """Hardware of n designs in one scene, row by row."""

    cameras: Cameras
    lenses: Lenses
    lights: Lights
    count: Array
    view: Views
    focus_map: FocusMap  # fields may be arrays
    lever_m: Array  # (n, 3) distance from the camera's turning point to the floor
    light: ImageLight  # electrons per lm s of nameplate light
    sun: SunLight | None = None  # electrons per second of open shutter
    sharp: SharpRows | None = None  # what MTF and information depend on
    spacer_m: Array | float = 0.0  # of rings behind the lenses


def lit_s(rows: DesignRows, settings: SettingRows) -> Array:
    """How long the lamps' light is collected: exposure + t_0, or the pulse if it is shorter."""
    window = settings.exposure_s + rows.cameras.exposure_offset_s
    flash = np.minimum(rows.lights.flash_duration_s, settings.pulse_s)
    pulse = np.where(rows.lights.kind == FLASH, flash, settings.pulse_s)
    return np.where(rows.lights.kind == CONTINUOUS, window, np.minimum(pulse, window))


def full_light_lm(lights: Lights, count: Array) -> Array:
    """Light of all lamps at full level; of a flash that at its peak."""
    return np.asarray(lights.brightest_lm * count)


@dataclass(frozen=True)
class Figures:
    """Figures by design; (n, 3) near, nominal, far; (n, n_altitudes) for light."""

    working_f_number: Array
    light_x: Array
    light_time_s: Array  # how long light is collected
    peak_time_s: Array  # at full brightness that gives as much; of a flash that fades less
    smear_s: Array  # steady light that smears as much as the lamps do, or the sun over the open shutter
    electrons_signal: Array  # (n, n_altitudes), image-forming, of lamps and sun
    electrons_forward: Array | None  # veils, (n, n_altitudes); None: left out
    electrons_backscatter: Array | None
    electrons_sun: Array | None  # of all these, what the sun brings
    electrons_dark: Array
    contrast: Array  # (n, n_altitudes), 0 where there is no light at all
    snr: Array  # (n, n_altitudes)
    snr_pixels: Array | None  # what the pixels reach that it is asked of
    snr_red: Array | None  # (n, n_altitudes), where something is asked of it; 0 of a mono sensor
    white_balance: Array | None  # (n, n_altitudes), the same; 1 of a mono sensor
    mean_level: Array  # (n, n_altitudes)
    saturation_fraction: Array  # of the brightest: at any altitude, or of open water
    blur_px: Array
    skew_px: Array
    overlap: Array
    dof_near_m: Array
    dof_far_m: Array
    focus_distance_m: Array
    camera_power_w: Array  # of one camera, on average
    light_power_w: Array
    light_peak_power_w: Array
    duty_frac: Array
    data_rate_mb_s: Array
    mtf_half_nyquist: Array | None  # (n, 3), where the mission wants it
    smallest_bars_m: Array | None  # (n, 3), where the mission wants some resolved
    information_bit_per_m2: Array | None  # (n,), nominal altitude
    background_e: Array | None = None  # (n, 1), of open water behind the targets, image mean
    background_level: Array | None = None  # (n,), the same

    @property
    def bright_level(self) -> Array:
        """Levels of all that must not saturate: behind the altitudes, open water where there is any."""
        behind = self.background_level
        return self.mean_level if behind is None else np.concatenate([self.mean_level, behind[:, None]], axis=1)


def figures_of(
    scene: SceneOptics, rows: DesignRows, settings: SettingRows, *, information: bool = False
) -> Figures:
    """All figures that requirements need, for n designs in one scene; `information` where it is asked for."""
    cam, view = rows.cameras, rows.view
    factor: Any = 1.0
    if not scene.paper:
        imaged = forms_image(rows, settings)
        with np.errstate(divide="ignore"):
            object_m = np.where(imaged, 1.0 / settings.dioptre_per_m, np.inf)
        extended = lens_model.working_f_number(
            1.0, focal_length_m=view.focal_length_m, object_distance_m=object_m
        )
        factor = np.where(imaged, extended, np.inf)
    working = settings.f_number * factor
    collected_s = lit_s(rows, settings)
    at_peak_s = rows.lights.flash.light_s(collected_s)  # gives as much light
    light_x = full_light_lm(rows.lights, rows.count) * settings.level * at_peak_s / np.square(working)
    gain = cam.gain_dn_per_e * settings.gain
    dark = cam.dark_current_e_s * settings.exposure_s
    open_y = open_s(rows, settings) / np.square(working)
    seen = electrons_in_image(rows, light_x, open_y)
    noise = dict(
        read_noise_e=cam.read_noise_e[:, None],
        gain_dn_per_e=gain[:, None],
        dark_e=dark[:, None],
        prnu_frac=cam.prnu_frac[:, None],
    )
    veil = 0.0 if seen.veil_e is None else seen.veil_e
    every = seen.signal_e if seen.veil_e is None else seen.signal_e + seen.veil_e
    bright = every if seen.background_e is None else np.concatenate([every, seen.background_e], axis=1)
    bright_level = np.asarray(sensor.mean_level(
        bright,
        gain_dn_per_e=gain[:, None],
        bits=cam.bits[:, None],
        dark_e=dark[:, None],
        offset_dn=cam.black_level_dn[:, None],
    ))
    level = bright_level[:, : every.shape[1]]
    near, far = depth_of_field_m(scene, rows, settings)
    power, peak = power_w(scene, rows, settings, collected_s)
    snr = np.asarray(sensor.snr(seen.signal_e, veil_e=veil, **noise))
    blur_s = rows.lights.flash.blur_s(at_peak_s) if rows.sun is None else open_s(rows, settings)
    apertures = dict(f_number=settings.f_number, working_f_number=working, blur_s=blur_s)
    needs = scene.view.requirements
    needs_mtf = rows.sharp is not None and needs.min_mtf_half_nyquist is not None
    needs_bars = rows.sharp is not None and needs.resolve_mm is not None
    contrast = share_of(seen.signal_e, every)
    return Figures(
        working_f_number=working,
        light_x=light_x,
        light_time_s=collected_s,
        peak_time_s=at_peak_s,
        smear_s=blur_s,
        electrons_signal=seen.signal_e,
        electrons_forward=seen.forward_e,
        electrons_backscatter=seen.backscatter_e,
        electrons_sun=seen.sun_e,
        electrons_dark=dark,
        contrast=contrast,
        snr=snr,
        snr_pixels=snr_of_pixels(rows, light_x, open_y, noise),
        snr_red=None if seen.colour_e is None else np.asarray(
            sensor.snr(seen.colour_e[:, :, 0], veil_e=0.0 if seen.red_veil_e is None else seen.red_veil_e, **noise)
        ),
        white_balance=None if seen.colour_e is None else np.asarray(sensor.white_balance(seen.colour_e)),
        mean_level=level,
        background_e=seen.background_e,
        background_level=None if seen.background_e is None else bright_level[:, -1],
        saturation_fraction=saturation_fraction(scene, cam, bright_level, bright, dark),
        blur_px=blur_px(scene, rows, blur_s),
        skew_px=skew_px(scene, rows),
        overlap=overlap(scene, view, settings.rate_hz),
        dof_near_m=near,
        dof_far_m=far,
        focus_distance_m=np.asarray(water_distance_m(settings.dioptre_per_m, focus_map=rows.focus_map)),
        camera_power_w=switching.camera_power_w(scene.view.vehicle, cam, settings.rate_hz, settings.exposure_s),
        light_power_w=power,
        light_peak_power_w=peak,
        duty_frac=np.asarray(light_model.duty_frac(collected_s, frame_rate_hz=settings.rate_hz)),
        data_rate_mb_s=cam.frame_mb * settings.rate_hz,
        mtf_half_nyquist=rows.sharp.mtf_half_nyquist(**apertures) if needs_mtf and rows.sharp else None,
        smallest_bars_m=rows.sharp.smallest_bars_m(
            bars_contrast(rows, light_x, open_y, contrast)[:, [0, scene.nominal, -1]], **apertures
        )
        if needs_bars and rows.sharp
        else None,
        information_bit_per_m2=rows.sharp.information_bit_per_m2(snr[:, scene.nominal], **apertures)
        if information and rows.sharp
        else None,
    )


@dataclass(frozen=True)
class Electrons:
    """Electrons of n designs, image means (n, n_altitudes)."""

    signal_e: Array
    forward_e: Array | None
    backscatter_e: Array | None
    sun_e: Array | None
    veil_e: Array | None
    colour_e: Array | None = None  # image-forming, of the channels asked for (n, n_altitudes, n_channels), red first
    red_veil_e: Array | None = None
    background_e: Array | None = None


def electrons_in_image(rows: DesignRows, light_x: Array, open_y: Array) -> Electrons:
    """The lamps' constants times light, the sun's times open shutter over N_w^2."""
    lamps, sun = rows.light, rows.sun

    def lit(column: Array | None) -> Array | None:
        return None if column is None else scaled(column, light_x)

    def sunlit(column: Array | None) -> Array | None:
        return None if column is None else scaled(column, open_y)

    signal, forward, back = lit(lamps.signal_e), lit(lamps.forward_e), lit(lamps.backscatter_e)
    colour, red_veil = lit(lamps.colour_e), lit(lamps.red_veil_e)
    sun_e = None
    assert signal is not None
    if sun is not None:
        sun_signal, sun_forward, sun_path = (
            sunlit(c) for c in (sun.signal_e_s, sun.forward_e_s, sun.path_e_s)
        )
        sun_e = added(sun_signal, added(sun_forward, sun_path))
        signal, forward, back = signal + sun_signal, added(forward, sun_forward), added(back, sun_path)
        if colour is not None:
            colour = added(colour, sunlit(sun.colour_e_s))
            red_veil = added(red_veil, sunlit(sun.red_veil_e_s))
    veil = added(forward, back)
    return Electrons(
        signal, forward, back, sun_e, veil, colour, red_veil, lit(lamps.background_e)
    )


def scaled(column: Array, factor: Array) -> Array:
    """A column, every row times its own factor."""
    return np.asarray(column * factor.reshape(-1, *([1] * (column.ndim - 1))))


def of_each(column: Array, some: slice) -> Array:
    """Some designs' part of a column; one of a single row is that of all."""
    return column if len(column) == 1 else column[some]


def at_pixels(rows: DesignRows, light_x: Array, open_y: Array) -> Iterator[tuple[slice, Array, Array | None]]:
    """Signal and veil at the pixels that an SNR is asked of, (some, n_altitudes, n_pixels), and of which designs.

    A few designs at a time, so that arrays stay in the cache.
    """
    lamps, sun = rows.light, rows.sun
    if lamps.worst_e is None:
        return
    step = max(1, PIXELS_AT_ONCE // max(1, lamps.worst_e[0].size))
    for at in range(0, len(light_x), step):
        some = slice(at, at + step)

        def lit(column: Array | None, factor: Array, some: slice = some) -> Array | None:
            return None if column is None else scaled(of_each(column, some), of_each(factor, some))

        signal, veil = lit(lamps.worst_e, light_x), lit(lamps.worst_veil_e, light_x)
        if sun is not None:
            signal, veil = added(signal, lit(sun.worst_e_s, open_y)), added(veil, lit(sun.worst_veil_e_s, open_y))
        assert signal is not None
        yield some, signal, veil


def snr_of_pixels(rows: DesignRows, light_x: Array, open_y: Array, noise: dict[str, Array]) -> Array | None:
    """The SNR that all but `may_miss` of the pixels reach, (n, n_altitudes); None where none is asked of them."""
    found = []
    for some, signal, veil in at_pixels(rows, light_x, open_y):
        there = {name: of_each(column, some)[:, :, None] for name, column in noise.items()}
        each = sensor.snr(signal, veil_e=0.0 if veil is None else veil, **there)
        found.append(reached_by_most(np.asarray(each), rows.light.may_miss))
    return np.concatenate(found) if found else None


def bars_contrast(rows: DesignRows, light_x: Array, open_y: Array, mean: Array) -> Array:
    """Image-forming over all light where bars must arrive, (n, n_altitudes): the image's `mean`, or less at pixels.

        C = min(mean, what all but `may_miss` of the pixels reach that the SNR is asked of)
    """
    found = [
        mean[some] if veil is None
        else np.minimum(mean[some], reached_by_most(share_of(signal, signal + veil), rows.light.may_miss))
        for some, signal, veil in at_pixels(rows, light_x, open_y)
    ]  # fmt: skip
    return np.concatenate(found) if found else mean


def bars_contrast_at(rows: DesignRows, settings: SettingRows, figures: Figures) -> Array:
    """The same of designs whose figures are known."""
    open_y = open_s(rows, settings) / np.square(figures.working_f_number)
    return bars_contrast(rows, figures.light_x, open_y, figures.contrast)


def forms_image(rows: DesignRows, settings: SettingRows) -> Array:
    """Whether the lens, focused so near, has an image at all: f D < 1. Within its focal length it has none.

    N_w is infinite then: no light arrives, nothing is sharp, and the margin `nearest_focus_m` is missed.
    """
    return np.asarray(rows.view.focal_length_m * settings.dioptre_per_m < 1.0)


def open_s(rows: DesignRows, settings: SettingRows) -> Array:
    """Time that collects sunlight: the whole exposure and its offset."""
    return np.asarray(settings.exposure_s + rows.cameras.exposure_offset_s)


def saturation_fraction(scene: SceneOptics, cam: Cameras, level: Array, signal: Array, dark: Array) -> Array:
    """highlight_ratio times the brightest mean level over the altitudes, of full scale or of the full well."""
    ratio = scene.view.requirements.highlight_ratio
    in_well = (signal.max(axis=1) + dark) / cam.saturation_e
    return np.asarray(ratio * np.maximum(level.max(axis=1), in_well))


def depth_of_field_m(scene: SceneOptics, rows: DesignRows, settings: SettingRows) -> tuple[Array, Array]:
    """Nearest and farthest sharp distance in water; inf where infinity is sharp.

    On the axis; where the mission wants the corners sharp too, at both. A lens without an image has no depth
    of field: both ends lie at the focus.
    """
    lens = dict(focal_length_m=rows.view.focal_length_m, circle_of_confusion_m=rows.view.coc_m)
    near, far = lens_model.near_far_water_m(
        settings.f_number, focus_dioptre_per_m=settings.dioptre_per_m, focus_map=rows.focus_map, **lens
    )
    imaged = forms_image(rows, settings)
    if not imaged.all():
        focus = water_distance_m(settings.dioptre_per_m, focus_map=rows.focus_map)
        near, far = np.where(imaged, near, focus), np.where(imaged, far, focus)
    if not held_at_corner(scene) or not imaged.any():
        return np.asarray(near), np.asarray(far)
    high, low = lens_model.near_far_dioptre_per_m(
        settings.f_number, focus_dioptre_per_m=settings.dioptre_per_m, **lens
    )
    places = rows.view.corner_image
    with np.errstate(divide="ignore"):
        first, last = (
            places[..., 1] / np.maximum(end[:, None] - places[..., 0], 0.0) - places[..., 2]
            for end in (np.asarray(high), np.asarray(low))
        )
    first, last = (np.where(imaged[:, None], end, near[:, None]) for end in (first, last))
    return np.maximum(near, first.max(axis=1)), np.minimum(far, last.min(axis=1))


def blur_px(scene: SceneOptics, rows: DesignRows, collected_s: Array) -> Array:
    """Motion blur at near, nominal and far altitude, (n, 3): the worse of both axes."""
    along = operation.blur_px(
        collected_s[:, None], ground_sample_m=rows.view.pixel_along_m, **motion_along(scene, rows.lever_m)
    )
    if scene.view.vehicle.roll_rate_deg_s == 0.0 and subject_m_s(scene) == 0.0:
        return np.asarray(along)
    across = operation.blur_px(
        collected_s[:, None], ground_sample_m=rows.view.pixel_across_m, **motion_across(scene, rows.lever_m)
    )
    return np.asarray(np.maximum(along, across))


def skew_px(scene: SceneOptics, rows: DesignRows) -> Array:
    """Skew of a rolling shutter under lamps that burn, (n, 3); a pulse freezes all rows at once."""
    if not rows.cameras.readout_s.any():
        return np.zeros_like(rows.view.pixel_along_m)
    skew = skew_by_altitude_px(scene, rows.view, rows.cameras.readout_s, rows.lever_m)
    return np.where((rows.lights.kind == CONTINUOUS)[:, None], skew, 0.0)


def overlap(scene: SceneOptics, view: Views, rate_hz: Array) -> Array:
    """Share of each image that the next one sees again, (n, 3); negative where there are gaps."""
    speed = scene.view.vehicle.speed_m_s
    if speed == 0.0:
        return np.ones_like(view.covered_along_m)
    with np.errstate(divide="ignore"):
        shared = operation.overlap_at_rate(
            rate_hz[:, None], speed_m_s=speed, footprint_along_m=view.covered_along_m
        )
    return np.asarray(shared)


def power_w(
    scene: SceneOptics, rows: DesignRows, settings: SettingRows, collected_s: Array
) -> tuple[Array, Array]:
    """Mean and peak electrical power of all lights."""
    lights, count, vehicle = rows.lights, rows.count, scene.view.vehicle
    lead_s = switching.lead_s(vehicle, lights, rows.cameras)
    pulse_s = np.where(lights.kind == PULSED, settings.pulse_s, collected_s)
    burning = light_model.continuous_power_w(settings.level, full_power_w=lights.full_power_w, count=count)
    pulsed = light_model.pulsed_led_power_w(
        settings.level,
        full_power_w=lights.full_power_w,
        count=count,
        pulse_s=pulse_s + np.where(np.isfinite(lead_s), lead_s, 0.0),
        frame_rate_hz=settings.rate_hz,
    )
    flashing = light_model.flash_power_w(
        lights.pulse_energy_j * settings.level, count=count, frame_rate_hz=settings.rate_hz
    )
    timed = (lights.kind == PULSED) | np.isfinite(lead_s)
    mean = np.where(timed, pulsed, np.where(lights.kind == FLASH, flashing, burning))
    mean = mean + switching.standby_w(vehicle, lights, count)
    recharging = light_model.flash_peak_power_w(
        lights.pulse_energy_j * settings.level * count,
        charging_power_w=lights.charging_power_w * count,
        frame_rate_hz=settings.rate_hz,
    )
    peak = np.where(lights.kind == FLASH, recharging, burning)
    return np.asarray(mean), np.asarray(peak)


def levers_m(scene: SceneOptics, outer_radius_m: Array) -> Array:
    """Distance from the camera's turning point to the floor at near, nominal and far altitude, (n, 3)."""
    radius = 0.0 if scene.paper else np.asarray(outer_radius_m)[:, None]
    return np.asarray(altitudes_m(scene)[None, :] + radius)
