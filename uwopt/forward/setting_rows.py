"""Designs under their lights made into `SceneRows`, and of the pixels of such rows those that may decide."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward import switching
from uwopt.forward.focus import Focused
from uwopt.forward.light_columns import ImageLight, SunLight
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED, Cameras, Lights
from uwopt.forward.pixels import fewest_pixels
from uwopt.forward.problem import Problem
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.sharpness import SharpRows, airy_f_number
from uwopt.mission.sections.requirements import Requirements
from uwopt.model import sensor

PIXEL_COLUMNS = ("worst_e", "worst_veil_e", "worst_sun_signal_e_s", "worst_sun_veil_e_s")


def of_fewest_pixels(rows: SceneRows, *, unlit: bool) -> SceneRows:
    """Rows under the sun with those pixels alone that may decide their SNR and contrast, at whatever settings.

    unlit : whether all lights stand for no lamp, so that the sun alone decides
    """
    lamps, sun = rows.worst_e, rows.worst_sun_signal_e_s
    if lamps is None or sun is None or lamps.shape != sun.shape or lamps.shape[2] <= rows.may_miss + 1:
        return rows
    veils = rows.worst_veil_e, rows.worst_sun_veil_e_s
    over, sun_over = (np.zeros_like(lamps) if veil is None else veil for veil in veils)
    of_lamps, of_sun = (lamps, over), (sun, sun_over)
    if unlit:
        (sun, sun_over), (lamps, over) = fewest_pixels([of_sun], rows.may_miss, unlit=[of_lamps])
    else:
        (sun, sun_over), (lamps, over) = fewest_pixels([of_sun, of_lamps], rows.may_miss)
    return replace(
        rows, worst_e=lamps, worst_veil_e=None if veils[0] is None else over, worst_sun_signal_e_s=sun,
        worst_sun_veil_e_s=None if veils[1] is None else sun_over,
    )  # fmt: skip


def of_farthest_pixels(rows: SceneRows, *, unlit: bool) -> SceneRows:
    """Rows for bounds under the sun: of pixels those alone that may decide at the farthest altitude."""
    farthest: dict[str, Any] = {name: c[:, -1:] for name in PIXEL_COLUMNS if (c := getattr(rows, name)) is not None}
    return of_fewest_pixels(replace(rows, **farthest), unlit=unlit)


SHORTEST_TIME_S = 1e-9
BALANCE_ROUND = 1.0 + 1e-9
#: Longest times of what no setting lets pass: for any reason; for its lamps' places; as the whole flash smears too far.
NO_TIME_S, MISPLACED_S, SMEARED_S = -1.0, -2.0, -3.0


def light_times_s(
    camera: Cameras, light: Lights, focused: Focused, exposure_limit_s: float, *, sunlit: bool = False
) -> tuple[Array, Array, Array]:
    """Shortest and longest light-collecting time, and the longest exposure that dark current sees.

    Continuous: exposure + t_0. Pulsed LED: the pulse, all rows open. Flash: its whole duration, or less
    when a global shutter cuts it (exposure + t_0), as times at its peak brightness. Where the sun shines, what moves
    is smeared for as long as the shutter is open, else by the lamps alone.
    """
    with np.errstate(divide="ignore"):
        exposure = np.minimum(np.minimum(camera.max_exposure_s, exposure_limit_s), 1.0 / focused.rate_hz)
        duty_time = light.max_duty / focused.rate_hz
    offset = camera.exposure_offset_s
    shortest = np.maximum(camera.min_exposure_s + offset, SHORTEST_TIME_S)
    longest = np.minimum(exposure + offset, focused.blur_time_s)
    fading, full = light.flash, light.flash.full_s
    within_blur = fading.light_s(focused.blur_time_s) if sunlit else fading.within_blur_s(focused.blur_time_s)
    open_time = exposure - camera.readout_s
    pulse_max = np.minimum(
        np.minimum(light.max_pulse_s, duty_time), np.minimum(open_time, focused.blur_time_s)
    )
    pulse_min = np.maximum(light.min_pulse_s, SHORTEST_TIME_S)
    cuts = camera.readout_s == 0.0
    flash_min = np.where(cuts, fading.light_s(np.minimum(shortest, light.flash_duration_s)), full)
    cut_max = np.minimum(fading.light_s(np.minimum(exposure + offset, light.flash_duration_s)), within_blur)
    whole = np.where(open_time >= light.flash_duration_s, full, -1.0)
    flash_max = np.where(cuts, cut_max, np.where(whole <= within_blur, whole, SMEARED_S))
    pulsed, flash = light.kind == PULSED, light.kind == FLASH
    time_min = np.where(pulsed, pulse_min, np.where(flash, flash_min, shortest))
    time_max = np.where(pulsed, pulse_max, np.where(flash, flash_max, longest))
    time_max = np.where(camera.min_exposure_s > exposure * (1 + 1e-12), -1.0, time_max)
    lit = fading.open_s(np.maximum(time_max, 0.0))
    dark_time = np.where(pulsed | flash, lit + camera.readout_s, lit - offset)
    return time_min, time_max, np.maximum(dark_time, 0.0)


def colours_may_do(light: ImageLight, sun: SunLight | None, needs: Requirements) -> Array:
    """Whether some settings may give the colours that are asked for, (n,): the sensor sees red if it must, and the
    lamps' colours, where no other light mixes with them, are balanced at every altitude."""
    may = np.ones(len(light.signal_e), bool)
    if light.colour_e is None:
        return may
    if needs.min_snr_red is not None:
        red = light.colour_e[:, :, 0]
        if sun is not None and sun.colour_e_s is not None:
            red = red + sun.colour_e_s[:, :, 0]
        may &= (red > 0.0).all(axis=1)
    if needs.max_white_balance is not None and sun is None:
        ratio = sensor.white_balance(light.colour_e).max(axis=1)
        may &= ratio <= needs.max_white_balance * BALANCE_ROUND
    return may


def setting_rows(
    problem: Problem, scene_index: int, *, camera: Array, light: Array, count: Array, focused: Focused,
    image_light: ImageLight, sun: SunLight | None = None, sharp: SharpRows | None = None,
) -> SceneRows:  # fmt: skip
    """What the settings of n designs depend on in one scene."""
    scene = problem.scenes[scene_index]
    needs, limits = scene.view.requirements, problem.mission.limits
    cam, lamp = problem.cameras.take(camera), problem.lights.take(light)
    flash = lamp.kind == FLASH
    least_gain, most_gain = problem.gains(scene_index, cam.max_gain)
    time_min, time_max, dark_time = light_times_s(
        cam, lamp, focused, limits.max_exposure_ms * 1e-3, sunlit=sun is not None
    )
    light_lm = lamp.brightest_lm * count
    full_power = lamp.full_power_w * count
    pulse_energy = lamp.pulse_energy_j * count
    sunlit_cap = None
    if sun is not None:  # the sun smears over the whole open shutter
        with np.errstate(divide="ignore"):
            longest = np.minimum(
                np.minimum(cam.max_exposure_s, limits.max_exposure_ms * 1e-3), 1.0 / focused.rate_hz
            )
        sunlit_cap = np.minimum(longest + cam.exposure_offset_s, focused.blur_time_s)
    peak_at_full = np.where(flash, pulse_energy * focused.rate_hz, full_power)
    with np.errstate(divide="ignore", invalid="ignore"):
        peak_for_lights = (limits.peak_power_w or np.inf) - problem.camera_power_w(cam)
        max_level = np.minimum(1.0, peak_for_lights / peak_at_full)
    charging_power = lamp.charging_power_w * count
    max_level = np.where(np.isnan(max_level), 1.0, max_level)
    allowed = (focused.rate_hz <= lamp.max_rate_hz * (1 + 1e-12)) | (lamp.kind == CONTINUOUS)
    allowed &= cam.fires_lamps | (lamp.kind == CONTINUOUS)
    allowed &= ~flash | (charging_power <= peak_for_lights * (1 + 1e-12))
    allowed &= least_gain <= most_gain * BALANCE_ROUND
    if needs.max_skew_px is not None:
        allowed &= (focused.skew_px <= needs.max_skew_px) | (lamp.kind != CONTINUOUS)
    vehicle = scene.view.vehicle
    stays_on = vehicle.camera_between_images == "on"
    n_high = focused.n_high
    if needs.max_airy_px is not None:
        working = airy_f_number(problem, scene_index, needs.max_airy_px, camera, light)
        n_high = np.minimum(n_high, working / focused.working_factor)
    shining = image_light.scaled(lamp.output_factor)
    allowed &= colours_may_do(shining, sun, needs)
    return SceneRows(
        signal_e=shining.signal_e,
        worst_e=shining.worst_e,
        veil_e=shining.veil_e,
        worst_veil_e=shining.worst_veil_e,
        may_miss=shining.may_miss,
        most_veil_e=shining.most_veil_e,
        open_max_s=sunlit_cap,
        sun_signal_e_s=None if sun is None else sun.signal_e_s,
        sun_veil_e_s=None if sun is None else sun.veil_e_s,
        worst_sun_signal_e_s=None if sun is None else sun.worst_e_s,
        worst_sun_veil_e_s=None if sun is None else sun.worst_veil_e_s,
        colour_e=shining.colour_e,
        red_veil_e=shining.red_veil_e,
        background_e=shining.background_e,
        sun_colour_e_s=None if sun is None else sun.colour_e_s,
        sun_red_veil_e_s=None if sun is None else sun.red_veil_e_s,
        min_snr_red=needs.min_snr_red or 0.0,
        max_white_balance=needs.max_white_balance or np.inf,
        min_contrast=needs.min_contrast or 0.0,
        min_mtf=needs.min_mtf_half_nyquist or 0.0,
        resolve_m=(needs.resolve_mm or 0.0) * 1e-3,
        sharp=sharp,
        nominal=scene.nominal,
        read_noise_e=cam.read_noise_e,
        gain_dn_per_e=cam.gain_dn_per_e,
        full_scale_dn=2.0**cam.bits - 1.0,
        black_level_dn=cam.black_level_dn,
        min_gain=least_gain,
        max_gain=most_gain,
        well_e=cam.saturation_e,
        prnu_frac=cam.prnu_frac,
        dark_current_e_s=cam.dark_current_e_s,
        dark_time_s=dark_time,
        min_exposure_s=cam.min_exposure_s,
        exposure_offset_s=cam.exposure_offset_s,
        readout_s=cam.readout_s,
        flash_duration_s=lamp.flash_duration_s,
        flash_decay_s=lamp.flash_decay_s,
        time_min_s=time_min,
        time_max_s=np.where(allowed, time_max, NO_TIME_S),
        rate_hz=focused.rate_hz,
        kind=lamp.kind,
        light_lm=light_lm,
        full_power_w=full_power,
        pulse_energy_j=pulse_energy,
        charging_power_w=charging_power,
        levels=lamp.levels,
        dims_freely=lamp.dims_freely,
        min_level=lamp.min_level,
        max_level=max_level,
        working_factor=focused.working_factor,
        n_low=focused.n_low,
        n_high=n_high,
        min_snr=scene.least_snr,
        min_snr_mean=scene.least_mean_snr,
        mean_level=needs.mean_level,
        highlight_ratio=needs.highlight_ratio,
        lead_s=switching.lead_s(vehicle, lamp, cam),
        camera_w=None if stays_on else vehicle.camera_count * cam.power_w,
        awake_s=None if stays_on else cam.awake_s,
        idle_w=switching.standby_w(vehicle, lamp, count) + focused.beside_w,
    )
