"""Figures and settings of a design by the names that reports use, in the field's units."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.evaluation.design_model import DesignModel
from uwopt.evaluation.resolved import Resolved
from uwopt.forward.breathing import extension
from uwopt.forward.figures import (
    Figures,
    SettingRows,
    electrons_in_image,
    figures_of,
    open_s,
)
from uwopt.forward.lamps import LAMP_FRONT_M
from uwopt.forward.motion import blur_time_s, required_rate_hz
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.scene import COLOURS, SceneOptics
from uwopt.forward.sharpness import airy_wavelength_nm, arriving
from uwopt.forward.spacers import scale_distance_m
from uwopt.forward.spectra import sees_colours
from uwopt.forward.views import CORNER_FIELD, Views, field_dioptres_per_m, narrowest_m, pair_of
from uwopt.model import lateral, sensor, sharpness
from uwopt.model import lens as lens_model
from uwopt.model.defocus import defocus_px, dome_decentring
from uwopt.model.footprint import floor_steps
from uwopt.model.imaging import floor_point
from uwopt.model.port import dome_virtual_image_distance_m
from uwopt.results.design import Note, SceneResult
from uwopt.tolerances import TIE
from uwopt.units import S_PER_H, ratio_to_db, split_unit

GAIN_DIGITS = 9  # of a gain in dB: a gain at the end of its range is no other for how it was rounded


def plain_settings(model: DesignModel, settings: SettingRows, figures: Figures) -> dict[str, float | None]:
    """Settings in the field's units."""
    kind = int(model.lights.kind[0])
    level, pulse = float(settings.level[0]), float(settings.pulse_s[0])
    flux = None if kind == FLASH else float(model.lights.full_light[0]) * model.hardware.count * level
    energy = float(model.lights.stored_energy_j[0]) * level if kind == FLASH else None
    focus = float(figures.focus_distance_m[0])
    return {
        "f_number": float(settings.f_number[0]),
        "exposure_ms": float(settings.exposure_s[0]) * 1e3,
        "pulse_ms": pulse * 1e3 if kind != CONTINUOUS and math.isfinite(pulse) else None,
        "gain": float(settings.gain[0]),
        "gain_db": round(float(ratio_to_db(settings.gain[0])), GAIN_DIGITS) + 0.0 if settings.gain[0] > 0 else None,
        "flux_lm": None if model.unlit else flux,
        "dim_frac": None if model.unlit else level,
        "flash_energy_j": energy,
        "frame_rate_hz": float(settings.rate_hz[0]),
        "focus_distance_m": focus if math.isfinite(focus) else None,
        "spacer_mm": model.spacer_m * 1e3 if model.spacer_m > 0.0 else None,
        "focus_scale_m": on_scale_m(model, settings),
    }


def on_scale_m(model: DesignModel, settings: SettingRows) -> float | None:
    """What to set on the lens's scale in air, as finely as one reads; None at its far end, and in physics `paper`."""
    if model.problem.paper:
        return None
    with np.errstate(divide="ignore"):
        distance = float(scale_distance_m(model.lenses, settings.dioptre_per_m, model.spacer_m)[0])
    return float(f"{distance:.3g}") if math.isfinite(distance) and settings.dioptre_per_m[0] > 0.0 else None


def plain_figures(
    model: DesignModel, index: int, settings: SettingRows, figures: Figures, sharp: Resolved | None
) -> dict[str, Any]:
    """Figures at the nominal altitude, by the names that reports use."""
    scene, view = model.problem.scenes[index], model.view_at(index, float(settings.dioptre_per_m[0]))
    landscape, at = model.hardware.landscape, scene.nominal
    fov_x_m, fov_y_m = field_of_view_m(view, landscape)
    snr = float(figures.snr[0, at])
    needs = scene.view.requirements
    speed = scene.view.vehicle.speed_m_s
    nominal_rate = float(required_rate_hz(needs, speed, view.covered_along_m[:, 1:2])[0, 0])
    far = float(figures.dof_far_m[0])
    near = float(figures.dof_near_m[0])
    cam = model.cameras
    mean_level = float(figures.mean_level[0, at])
    blur_limit = float(blur_time_s(scene.at_nominal, model.shapes[index], _nominal_view(view))[0])
    most, worst = (model.snr_at(pixels, index, settings) for pixels in ("frame", "darkest"))
    plain, totals = plain_settings(model, settings, figures), model.totals(figures)
    out: dict[str, Any] = {
        "fov_x_m": fov_x_m,
        "fov_y_m": fov_y_m,
        "gsd_mm": float(view.gsd_m[0, 1]) * 1e3,
        "blur_px": float(figures.blur_px[0, 1]),
        "skew_px": float(figures.skew_px[0, 1]),
        "swath_m": float(view.covered_across_m[0, 1]),
        **oblique_figures(model, index, float(settings.dioptre_per_m[0])),
        **pair_figures(scene, view),
        "line_spacing_m": float(narrowest_m(view)[0]) * (1.0 - needs.sidelap),
        "area_m2_h": float(narrowest_m(view)[0]) * (1.0 - needs.sidelap) * speed * S_PER_H,
        "overlap": float(figures.overlap[0, 1]),
        "frame_rate_min_hz": nominal_rate,
        "exposure_max_ms": blur_limit * 1e3,
        "exposure_ms": float(settings.exposure_s[0]) * 1e3,
        "pulse_ms": plain["pulse_ms"],
        "f_number": float(settings.f_number[0]),
        "working_f_number": float(figures.working_f_number[0]),
        "gain": float(settings.gain[0]),
        "flux_lm": plain["flux_lm"],
        "duty_frac": float(figures.duty_frac[0]),
        "dof_near_m": near,
        "dof_far_m": far,
        "dof_far_is_infinite": math.isinf(far),
        "dof_m": far - near if math.isinf(far) or far - near > TIE * far else 0.0,  # one end twice is no depth
        "focus_distance_m": plain["focus_distance_m"],
        "virtual_image_distance_m": virtual_image_m(model, index),
        "effective_focal_length_mm": effective_focal_mm(model, index),
        **illuminance(model, index, settings),
        "electrons_signal": float(figures.electrons_signal[0, at]),
        "electrons_forward": at_nominal(figures.electrons_forward, at),
        "electrons_backscatter": at_nominal(figures.electrons_backscatter, at),
        "electrons_sun": at_nominal(figures.electrons_sun, at),
        **background(figures),
        "electrons_dark": float(figures.electrons_dark[0]),
        "mean_level": mean_level,
        "mean_dn": mean_level * float(2.0 ** cam.bits[0] - 1.0),
        "saturation_fraction": float(figures.saturation_fraction[0]),
        "snr": snr,
        "snr_db": decibels(snr),
        "snr_db_p05": None if most is None else decibels(most),
        "snr_db_min": None if worst is None else decibels(worst),
        "snr_db_centre": centre_db(model, index, settings),
        **colour_figures(model, index, settings, figures),
        "contrast": None if has_no_veil(figures) else at_nominal(figures.contrast, at),
        "veil_ratio": veil_ratio(figures, at),
        **sharpness_figures(model, index, settings, figures, sharp),
        "airy_diameter_um": airy_um(model, index, float(figures.working_f_number[0])),
        "power_w": float(totals["power_w"][0]),
        "light_power_w": float(figures.light_power_w[0]),
        "light_peak_power_w": float(figures.light_peak_power_w[0]),
        "camera_power_w": float(totals["camera_power_w"][0]),
        "cost": float(totals["cost"][0]),
        "currency": model.problem.mission.limits.currency,
        "mass_kg": float(totals["mass_kg"][0]),
        "data_rate_mb_s": float(model.data_rate_mb_s(figures)[0]),
        **used_up_here(model, index, figures),
        "information_bit_per_m2": at_one(figures.information_bit_per_m2),
    }
    return with_flags(out)


def background(figures: Figures) -> dict[str, float]:
    """Electrons and level of open water behind the targets; nothing where there is none, or it is left out."""
    if figures.background_e is None or figures.background_level is None:
        return {}
    level = float(figures.background_level[0])
    return {"electrons_background": float(figures.background_e[0, 0]), "background_level": level}


def used_up_here(model: DesignModel, index: int, figures: Figures) -> dict[str, float | None]:
    """Energy and storage that a mission's time in one scene takes; None without a duration."""
    duration = model.problem.duration
    share = duration.shares[index]
    return {
        "energy_wh": duration.energy_of(share * float(model.totals(figures)["power_w"][0])),
        "storage_gb": duration.storage_of(share * float(model.data_rate_mb_s(figures)[0])),
    }


def with_flags(figures: dict[str, Any]) -> dict[str, Any]:
    """Figures without numbers that JSON cannot hold: None, with a flag beside those that are infinite."""
    out: dict[str, Any] = {}
    for key, value in figures.items():
        wild = isinstance(value, float) and not math.isfinite(value)
        out[key] = None if wild else value
        if wild and value == math.inf:
            out[f"{split_unit(key)[0]}_is_infinite"] = True
    return out


def field_of_view_m(view: Views, landscape: bool) -> tuple[float, float]:
    """Width and height of the floor that the image surely covers at the nominal altitude, of views at a focus [m]."""
    along, across = float(view.covered_along_m[0, 1]), float(view.covered_across_m[0, 1])
    return (across, along) if landscape else (along, across)


def oblique_figures(model: DesignModel, index: int, dioptre_per_m: float) -> dict[str, float]:
    """Way of the light, pixel and width at the near edge, the middle and the far edge of an oblique view, mid-column.

    The swath of the mission is that of the near edge, its pixel the largest of the frame. Widths are surely covered at
    this focus.
    """
    scene, view, shape = model.problem.scenes[index], model.views[index], model.shapes[index]
    if not scene.slope:
        return {}
    at: dict[str, Any] = dict(shape=shape, range_m=float(scene.range_m[scene.nominal]))
    along, across = (float(side[0]) for side in (view.tan_along, view.tan_across))
    closer = 1.0 / float(extension(scene, view, np.array(dioptre_per_m))[0])
    found = {}
    for end, u in (("near", -along), ("centre", 0.0), ("far", along)):
        ray, side = np.array(u), np.array(across)
        pixel = float(model.cameras.pixel_pitch_m[0] / view.focal_length_m[0])
        found[f"range_{end}_m"] = float(floor_point(ray, np.array(0.0), **at)[2])
        found[f"gsd_{end}_mm"] = float(floor_steps(ray, np.array(0.0), **at).longest_m) * pixel * 1e3
        found[f"swath_{end}_m"] = 2.0 * float(floor_point(closer * ray, closer * side, **at)[1])
    return found


def pair_figures(scene: SceneOptics, view: Views) -> dict[str, float]:
    """What a stereo pair sees with both cameras and how surely it tells distances; nothing of others."""
    if pair_of(scene) is None:
        return {}
    return {
        "common_swath_m": float(view.common_across_m[0, 1]), "depth_error_mm": float(view.depth_error_m[0, 1]) * 1e3,
    }  # fmt: skip


def _nominal_view(view: Any) -> Any:
    middle = {
        name: np.repeat(getattr(view, name)[:, 1:2], 3, axis=1)
        for name in ("covered_along_m", "covered_across_m", "gsd_m", "pixel_along_m", "pixel_across_m")
    }
    return replace(view, **middle)


def at_nominal(column: Array | None, altitude: int) -> float | None:
    """A figure of the only design at one altitude; None when it is left out."""
    return None if column is None else float(column[0, altitude])


def at_one(column: Array | None) -> float | None:
    """A figure of the only design; None when it is left out."""
    return None if column is None else float(column[0])


# Strongest over weakest channel, gains that make a grey floor grey, relative to green, and what red then lacks in SNR.
WHITE_BALANCE = ("white_balance", "white_balance_red", "white_balance_blue", "snr_red_below_green_db")
SHARPNESS = (
    "mtf50_cyc_per_px", "mtf_half_nyquist", "mtf_half_nyquist_corner", "resolution_10_mm", "resolve_mm",
    "lateral_colour_px", "defocus_corner_px", "decentring_distortion_px", "decentring_defocus_px",
)  # fmt: skip


def sharpness_figures(
    model: DesignModel, index: int, settings: SettingRows, figures: Figures, sharp: Resolved | None
) -> dict[str, float | None]:
    """MTF where the mission wants the image sharp and at the corner, what colours and defocus do there.

    The corner is the field at 80 % of the half diagonal in all of them.
    """
    scene, problem, view = model.problem.scenes[index], model.problem, model.views[index]
    if sharp is None:
        return dict.fromkeys(SHARPNESS)
    dioptre = float(settings.dioptre_per_m[0])
    f_number, working = settings.f_number, figures.working_f_number
    spectrum = int(problem.contractions[index].spectrum_of[model.optics])
    electrons = arriving(scene, problem.contractions[index], spectrum, model.efficiency)
    corner, shape = CORNER_FIELD * np.hypot(view.tan_along, view.tan_across), model.shapes[index]
    colour = 0.0
    if not shape.is_dome:
        spread = lateral.lateral_colour_px(
            corner, n_water=scene.n_water_spectrum, n_design=scene.n_water, electrons=electrons,
            focal_length_m=view.focal_length_m, pixel_pitch_m=model.cameras.pixel_pitch_m,
        ) * lateral.finite_range_share(
            corner, **shape.plates, range_m=float(scene.range_m[scene.nominal])
        )  # fmt: skip
        reflected = lateral.some_reflected(
            corner, n_water=scene.n_water_spectrum, n_design=scene.n_water, electrons=electrons
        )
        colour = math.inf if reflected[0] else float(spread[0])  # reported as null
    bent = field_dioptres_per_m(view.corner_image, float(scene.range_m[scene.nominal]))
    disc = np.array([np.inf])  # without an image; reported as null
    if np.isfinite(working[0]):
        disc = defocus_px(
            bent, f_number=f_number[:, None], focal_length_m=view.focal_length_m[:, None],
            pixel_pitch_m=model.cameras.pixel_pitch_m[:, None], focus_dioptre_per_m=dioptre,
        )  # fmt: skip
    return {
        "mtf50_cyc_per_px": float(sharp.mtf50_cyc_per_px[0]),
        "mtf_half_nyquist": float(sharpness.mtf_half_nyquist(sharp.at)[0]),
        "mtf_half_nyquist_corner": float(sharpness.mtf_half_nyquist(sharp.at_corner)[0]),
        "resolution_10_mm": float(sharp.resolution_10_m[0]) * 1e3,
        "resolve_mm": float(sharp.bars_m[0]) * 1e3,
        "lateral_colour_px": colour if problem.effects.lateral_colour else None,
        "defocus_corner_px": float(disc.max()),  # even where nothing depends on it: it is told with every image
        **decentring(model, index, float(f_number[0])),
    }


def decentring(model: DesignModel, index: int, f_number: float) -> dict[str, float | None]:
    """What 1 mm between pupil and dome centre does at the corner; None behind a flat port."""
    shape, view = model.shapes[index], model.views[index]
    if not shape.is_dome:
        return {"decentring_distortion_px": None, "decentring_defocus_px": None}
    scene = model.problem.scenes[index]
    moved = dome_decentring(
        float(scene.range_m[scene.nominal]),
        cos_field=float(1.0 / np.hypot(1.0, CORNER_FIELD * np.hypot(view.tan_along[0], view.tan_across[0]))),
        focus_map=model.maps[index], f_number=f_number, focal_length_m=float(view.focal_length_m[0]),
        pixel_pitch_m=float(model.cameras.pixel_pitch_m[0]),
    )  # fmt: skip
    distortion = max(abs(float(moved.across_distortion_px)), abs(float(moved.axial_distortion_px)))
    return {"decentring_distortion_px": distortion, "decentring_defocus_px": float(moved.axial_defocus_px)}


def has_no_veil(figures: Figures) -> bool:
    """Whether the model left all veils out."""
    return figures.electrons_forward is None and figures.electrons_backscatter is None


def veil_ratio(figures: Figures, altitude: int) -> float | None:
    """Veil over image-forming electrons; None where veils are left out or nothing forms an image."""
    if has_no_veil(figures) or not figures.electrons_signal[0, altitude] > 0:
        return None
    veils = (figures.electrons_forward, figures.electrons_backscatter)
    veil = sum(float(column[0, altitude]) for column in veils if column is not None)
    return veil / float(figures.electrons_signal[0, altitude])


def decibels(ratio: float) -> float | None:
    """20 log10, None where there is no signal."""
    return float(ratio_to_db(ratio)) if ratio > 0 else None


def virtual_image_m(model: DesignModel, index: int) -> float | None:
    """Virtual image of the floor from the dome's outer vertex."""
    shape, scene = model.shapes[index], model.problem.scenes[index]
    if not shape.is_dome:
        return None
    return float(
        dome_virtual_image_distance_m(
            float(scene.range_m[scene.nominal]),
            outer_radius_m=shape.outer_radius_m,
            thickness_m=shape.thickness_m,
            n_glass=shape.n_glass,
            n_water=shape.n_water,
        )
    )


def effective_focal_mm(model: DesignModel, index: int) -> float:
    """Focal length that the floor sees: n_w f behind a flat port (paraxial), f behind a dome."""
    focal_mm = float(model.lenses.focal_length_m[0]) * 1e3
    shape = model.shapes[index]
    return focal_mm if shape.is_dome else focal_mm * shape.n_water


def illuminance(model: DesignModel, index: int, settings: SettingRows) -> dict[str, float]:
    """Floor illuminance over the footprint at the nominal altitude, while the lights are on."""
    lumens = model.lumens(float(settings.level[0]))
    mean, least = model.floor_light(index)
    return {
        "floor_illuminance_mean_lx": lumens * mean,
        "floor_illuminance_min_lx": lumens * least,
        "uniformity": least / mean if mean > 0 else 0.0,
    }


def colour_figures(
    model: DesignModel, index: int, settings: SettingRows, figures: Figures
) -> dict[str, float | None]:
    """SNR of each channel of a colour sensor at the nominal altitude; None for a mono sensor."""
    names = COLOURS
    if not sees_colours(model.problem.efficiencies[model.efficiency]):
        return dict.fromkeys((*(f"snr_{name}" for name in names), *WHITE_BALANCE))
    scene, cam = model.problem.scenes[index], model.cameras
    out: dict[str, float | None] = {}
    signal = {}
    for name in names:
        light, sun = model.image_light(index, channel=name), model.sun_light(index, channel=name)
        open_y = open_s(model.rows[index], settings) / np.square(figures.working_f_number)
        seen = electrons_in_image(replace(model.rows[index], light=light, sun=sun), figures.light_x, open_y)
        signal[name] = float(seen.signal_e[0, scene.nominal])
        out[f"snr_{name}"] = float(
            sensor.snr(
                signal[name],
                veil_e=0.0 if seen.veil_e is None else float(seen.veil_e[0, scene.nominal]),
                read_noise_e=float(cam.read_noise_e[0]),
                gain_dn_per_e=float(cam.gain_dn_per_e[0] * settings.gain[0]),
                dark_e=float(figures.electrons_dark[0]),
                prnu_frac=float(cam.prnu_frac[0]),
            )
        )
    red, green = out["snr_red"], out["snr_green"]
    below = float(ratio_to_db(green / red)) if red and green else None
    balance = [signal["green"] / signal[name] if signal[name] > 0 else None for name in ("red", "blue")]
    ratio = float(sensor.white_balance(np.array([*signal.values()])))
    whole = ratio if math.isfinite(ratio) else None
    return {**out, **dict(zip(WHITE_BALANCE, (whole, *balance, below), strict=True))}


def centre_db(model: DesignModel, index: int, settings: SettingRows) -> float | None:
    """SNR at the middle of the image at the nominal altitude; None in physics `paper`, which knows no field."""
    scene = model.problem.scenes[index]
    if scene.paper:
        return None
    rows = replace(model.rows[index], light=model.light_at_centre(index))
    return decibels(float(figures_of(scene, rows, settings).snr[0, scene.nominal]))


def airy_um(model: DesignModel, index: int, working_f_number: float) -> float:
    """Airy disc at the electron-weighted mean wavelength of the light that arrives."""
    wave_nm = airy_wavelength_nm(model.problem, index, model.optics, model.efficiency)
    return float(lens_model.airy_diameter_m(wave_nm, working_f_number=working_f_number)) * 1e6


# ---------------------------------------------------------------- what should be known of the light


DARK_SHARE = 0.01  # of the image: a darker part is worth a warning
UNEVEN, FAR_BELOW_DB = 0.1, 15.0  # least over mean light on the floor; darkest pixel below the mean


def light_notes(model: DesignModel) -> list[Note]:
    """Warnings of images that the lamps do not fill."""
    notes: list[Note] = []
    for index, scene in enumerate(model.problem.scenes):
        if scene.paper:
            continue
        if not model.unlit and model.lamp_clearance_m(index) < LAMP_FRONT_M:
            text = (
                f"{scene.name}: a lamp stands in the camera's view, or within {100 * LAMP_FRONT_M:g} cm of it; what "
                "the water scatters there is not known, nor is what the lamp hides; move it outward"
            )
            notes.append(Note("lamp_in_view", "vehicle.light_baseline_m", text))
        dark = model.dark_share(index)
        if dark > DARK_SHARE:
            text = f"{scene.name}: no light reaches {100 * dark:.0f} % of the image; widen the beam, tilt or add lamps"
            notes.append(Note("dark_image", "light", text))
    return notes


def uneven_notes(scenes: Sequence[SceneResult]) -> list[Note]:
    """Warnings of images whose mean meets the requirements while parts of them are all but dark."""
    notes = []
    for scene in scenes:
        even, darkest = scene.figures["uniformity"], scene.figures["snr_db_min"]
        mean = scene.figures["snr_db"]
        below = None if darkest is None or mean is None else mean - darkest
        if even is None or (even >= UNEVEN and (below is None or below <= FAR_BELOW_DB)):
            continue
        said = f"{scene.name}: very uneven light: the darkest place of the floor has {100 * even:.2g} % of the mean"
        if darkest is not None:
            said += f", its SNR is {darkest:.1f} dB"
        said += "; ask for snr_at: worst or min_uniformity"
        notes.append(Note("uneven_light", "light", said))
    return notes


def stop_notes(model: DesignModel) -> list[Note]:
    """That a lens of one opening cannot be stopped down, where the mission asks for it."""
    wanted = max(scene.view.requirements.lens_stop_down for scene in model.problem.scenes)
    if not wanted or not model.lenses.one_opening[0]:
        return []
    lens = model.problem.parts.lenses[model.hardware.lens].id
    text = f"{lens} has one opening: {wanted:g} stops down cannot be asked of it, and are not"
    return [Note("one_opening", "requirements.lens_stop_down", text)]
