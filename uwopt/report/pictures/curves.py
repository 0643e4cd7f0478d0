"""Curves of one design: the spectrum's way, depth of field, frame rate and exposure, the rig's measures.

Recomputed from a replayed design by the functions that made its figures, as plain arrays for plots.
The spectrum and the depth of field are figures 5 and 4 of Billings, Iscar and Johnson-Roberson (2020).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.evaluation.design_model import DesignModel
from uwopt.evaluation.recompute import Replay
from uwopt.forward.breathing import covered, extension
from uwopt.forward.figures import depth_of_field_m, open_s
from uwopt.forward.lamp_light import LampField
from uwopt.forward.lamps import on_axis_gain, relative_spectrum
from uwopt.forward.motion import motion_across, motion_along, required_rate_hz
from uwopt.forward.scene import SceneOptics
from uwopt.forward.spectra import efficiency_curve
from uwopt.forward.sun_light import SunField
from uwopt.forward.views import PAPER_PORT, pair_of, port_transmission
from uwopt.model import beam as beams
from uwopt.model import lens, light, operation, seafloor, sensor
from uwopt.model.imaging import Lamps, floor_point, lamp_light
from uwopt.model.port import lens_dioptre_per_m
from uwopt.model.stereo import meeting_m

CHANNELS = ("red", "green", "blue")
N_APERTURES, N_DISTANCES, N_SPEEDS = 61, 81, 41
PLAIN_BLUR_PX = 1.0  # allowed blur of the curves where the mission allows any


@dataclass(frozen=True)
class SpectrumWay:
    """The lamps' light from lamp to pixel on the axis of the image, at the nominal altitude, while it shines.

    Without lamps the sun's, from the surface to the pixel, while the shutter is open.
    """

    wavelength_nm: Array
    source: Array  # flux leaving all lamps [W/nm]; of the sun the irradiance just above the water [W/m2/nm]
    floor_irradiance_w_m2_nm: Array
    reflected_radiance_w_m2_sr_nm: Array  # of the floor, into the water
    sensor_irradiance_w_m2_nm: Array  # image-forming, on the sensor
    electrons_per_nm: Array  # of one pixel in one exposure; a colour sensor: its mean channel
    channel_electrons_per_nm: dict[str, Array]  # red, green, blue; empty for a mono sensor
    light_time_s: float
    at_peak_s: float  # at peak brightness that gives as much: less where a flash fades
    altitude_m: float
    of_sun: bool = False

    @property
    def electrons(self) -> float:
        """All image-forming electrons on the axis, of the lamps or of the sun."""
        return float(np.trapezoid(self.electrons_per_nm, self.wavelength_nm))


@dataclass(frozen=True)
class DepthOfField:
    """Nearest and farthest sharp distance in water over the f-number and over the focus; far may be inf."""

    f_number: Array
    near_m: Array
    far_m: Array
    chosen_f_number: float
    focus_distance_m: Array
    near_by_focus_m: Array
    far_by_focus_m: Array
    chosen_focus_m: float
    lowest_altitude_m: float
    altitude_m: float
    highest_altitude_m: float
    wanted_dof_m: float | None
    circle_of_confusion_px: float
    dof_reserve_m: float = 0.0  # of what is wanted


@dataclass(frozen=True)
class Operation:
    """Frame rate that is wanted, and longest exposure by blur, over speed (columns) and altitude (rows)."""

    speed_m_s: Array
    altitude_m: Array
    frame_rate_hz: Array  # (n_altitudes, n_speeds)
    exposure_s: Array  # (n_altitudes, n_speeds), inf where nothing moves
    mission_speed_m_s: float
    mission_altitude_m: float
    mission_rate_hz: float
    set_rate_hz: float
    set_light_time_s: float
    camera_rate_hz: float  # inf when unknown
    blur_px: float
    blur_is_asked: bool
    blur_reserve_px: float = 0.0  # of what is asked


@dataclass(frozen=True)
class Lamp:
    """Place and aim of one lamp in the vehicle frame: x forward, y starboard, z down."""

    x_m: float
    y_m: float
    z_m: float
    aim: tuple[float, float, float]


@dataclass(frozen=True)
class RigMeasures:
    """What a drawing to scale needs of a design in one scene."""

    altitude_m: float
    altitude_tolerance_m: float
    half_along_m: float  # of the footprint at the nominal altitude, at the middle of its edges
    half_across_m: float
    is_dome: bool
    outer_radius_m: float
    lamps: tuple[Lamp, ...]
    beam_half_angle_rad: float
    beam_ends_sharply: bool
    image_width_is_along: bool
    speed_m_s: float
    advance_m: float | None  # from one image to the next; None when the rig stands still
    overlap: float | None
    camera_count: int
    sun_elevation_deg: float | None = None  # where the sun is the only light
    pitch_rad: float = 0.0  # by which the camera looks ahead of the target's normal
    edges_m: tuple[tuple[float, float], ...] = ()  # near and far: forward of the port, half of the width; if pitched
    pair_m: tuple[tuple[float, float, float], ...] = ()  # of a stereo pair each camera's place and its view's ends
    looks_up: bool = False  # at a ceiling: what is told as down is up

    @property
    def shown_advance_m(self) -> float | None:
        """How far ahead the next image is drawn; None where nothing moves or it is too far away."""
        along_m = self.edges_m[1][0] - self.edges_m[0][0] if self.edges_m else 2 * self.half_along_m
        return self.advance_m if self.advance_m is not None and self.advance_m < 3 * along_m else None


# ---------------------------------------------------------------- spectrum


def spectrum_way(design: Replay, scene_index: int = 0) -> SpectrumWay:
    """Equations (1), (2), (4) and (5) in a row, wavelength by wavelength; the sun apart, or alone where no lamp is.

    The integral of the electrons is the image-forming part of `LampField` in the middle of the image, or of `SunField`.
    """
    model, settings = design.model, design.settings[scene_index]
    problem = model.problem
    scene, view, shape = problem.scenes[scene_index], model.views[scene_index], model.shapes[scene_index]
    figures = model.figures(scene_index, settings)
    grid, range_m = scene.wavelength_nm, float(scene.range_m[scene.nominal])
    if model.unlit:
        sun = sun_field(design, scene_index)
        source, irradiance = sun.surface(), sun.at_floor()
        seconds = at_peak_s = float(open_s(model.rows[scene_index], settings)[0])
    else:
        source, irradiance = lamps_way(design, scene_index)
        seconds, at_peak_s = float(figures.light_time_s[0]), float(figures.peak_time_s[0])
    radiance = seafloor.lambertian_radiance(irradiance, reflectance=scene.reflectance)
    passes = float(model.lenses.transmission[0]) * (1.0 if scene.paper else port_transmission(shape))
    with np.errstate(under="ignore"):
        at_port = radiance * np.exp(-scene.attenuation_per_m * range_m)
    at_sensor = lens.image_irradiance(
        at_port / np.square(scene.radiance_index), transmission=passes,
        working_f_number=float(figures.working_f_number[0]),
    )  # fmt: skip
    area_m2 = float(view.collecting_m2[0]) / passes  # p^2 times the efficiency's scale

    def electrons(channel: str | None) -> Array:
        curve = efficiency_curve(problem.efficiencies[model.efficiency], grid, channel=channel)
        rate = sensor.electron_rate_per_m2_s_nm(at_sensor, wavelength_nm=grid, quantum_efficiency=curve)
        return np.asarray(rate * area_m2 * at_peak_s)

    return SpectrumWay(
        wavelength_nm=grid,
        source=np.asarray(source),
        floor_irradiance_w_m2_nm=np.asarray(irradiance),
        reflected_radiance_w_m2_sr_nm=np.asarray(radiance),
        sensor_irradiance_w_m2_nm=np.asarray(at_sensor),
        electrons_per_nm=electrons(None),
        channel_electrons_per_nm={name: electrons(name) for name in CHANNELS} if is_colour(design) else {},
        light_time_s=seconds,
        at_peak_s=at_peak_s,
        altitude_m=range_m,
        of_sun=model.unlit,
    )


def lamps_way(design: Replay, scene_index: int) -> tuple[Array, Array]:
    """Spectral flux that leaves the lamps [W/nm], and their irradiance where the axis meets the floor [W/m2/nm]."""
    model, settings = design.model, design.settings[scene_index]
    problem, hw, scene = model.problem, model.hardware, model.problem.scenes[scene_index]
    grid, range_m = scene.wavelength_nm, float(scene.range_m[scene.nominal])
    item = problem.optics[model.optics]
    lumens = model.lumens(float(settings.level[0]))
    flux = light.spectral_flux_w_nm(
        lumens, relative_spectrum=relative_spectrum((item.spectrum_id, item.spectrum), grid), wavelength_nm=grid,
        photopic=scene.photopic,
    )  # fmt: skip
    lamp_leg = problem.lamp_leg_per_m(scene_index, model.optics)
    lobe = problem.floor_lobe(scene_index, model.optics, hw.mount, range_m)
    return flux, flux * axis_gain_per_m2(scene, lamp_leg, lobe, hw.mount.lamps(hw.count), range_m)


def axis_gain_per_m2(
    scene: SceneOptics, lamp_leg_per_m: Array, beam: beams.Beam, lamps: Lamps, range_m: float
) -> Array:
    """Irradiance over flux where the camera's axis meets the floor, water's loss included, by wavelength [1/m^2]."""
    if scene.paper:
        gain = float(on_axis_gain(beam, np.array([range_m]))[0])
        return np.asarray(gain * np.exp(-lamp_leg_per_m * range_m))
    total = np.zeros_like(scene.wavelength_nm)
    origin = np.zeros(1)
    for index, share in enumerate(lamps.share):
        vacuum, lamp_m, _ = lamp_light(
            origin, origin, lamps=lamps, index=index, beam=beam, range_m=range_m, slope=scene.slope
        )
        total += share * float(vacuum[0]) * np.exp(-lamp_leg_per_m * float(lamp_m[0]))
    return total


def is_colour(design: Replay) -> bool:
    """Whether the camera has a red, a green and a blue channel."""
    model = design.model
    return all(name in model.problem.efficiencies[model.efficiency] for name in CHANNELS)


# ---------------------------------------------------------------- depth of field


def depth_of_field(design: Replay, scene_index: int = 0) -> DepthOfField:
    """Equation (9) over the lens's f-numbers at the chosen focus, and over the focus at the chosen f-number."""
    model, settings = design.model, design.settings[scene_index]
    scene, rows = model.problem.scenes[scene_index], model.rows[scene_index]
    low, high = float(model.lenses.f_number_min[0]), float(model.lenses.f_number_max[0])
    chosen = float(settings.f_number[0])
    apertures = np.geomspace(min(low, chosen), max(high, chosen, low * 1.01), N_APERTURES)
    many = settings.take(np.zeros(N_APERTURES, int))
    near, far = depth_of_field_m(scene, rows, replace(many, f_number=apertures))
    altitude = float(scene.range_m[scene.nominal])
    focus = float(model.figures(scene_index, settings).focus_distance_m[0])
    around = [altitude] if not np.isfinite(focus) else [altitude, focus]
    distances = np.geomspace(0.4 * min(around), 2.5 * max(around), N_DISTANCES)
    dioptres = np.asarray(lens_dioptre_per_m(distances, focus_map=model.maps[scene_index]))
    many = settings.take(np.zeros(N_DISTANCES, int))
    near_by, far_by = depth_of_field_m(scene, rows, replace(many, dioptre_per_m=dioptres))
    return DepthOfField(
        f_number=apertures,
        near_m=near,
        far_m=far,
        chosen_f_number=chosen,
        focus_distance_m=distances,
        near_by_focus_m=near_by,
        far_by_focus_m=far_by,
        chosen_focus_m=focus,
        lowest_altitude_m=float(scene.range_m[0]),
        altitude_m=altitude,
        highest_altitude_m=float(scene.range_m[-1]),
        wanted_dof_m=scene.view.requirements.min_dof_m,
        circle_of_confusion_px=float(rows.view.coc_m[0] / model.cameras.pixel_pitch_m[0]),
        dof_reserve_m=scene.view.kept("min_dof_m"),
    )


# ---------------------------------------------------------------- operation


def operation_curves(design: Replay, scene_index: int = 0) -> Operation:
    """Equations (8) and (10) over speeds up to twice the mission's, at five altitudes."""
    model, settings = design.model, design.settings[scene_index]
    scene, view, shape = (
        model.problem.scenes[scene_index],
        model.view_at(scene_index, float(settings.dioptre_per_m[0])),
        model.shapes[scene_index],
    )
    needs, vehicle = scene.view.requirements, scene.view.vehicle
    altitude, tolerance = float(scene.range_m[scene.nominal]), vehicle.altitude_tolerance_m
    spread = tolerance / np.cos(scene.pitch_rad) if tolerance > 0 else 0.25 * altitude
    altitudes = np.array([0.5 * altitude, altitude - spread, altitude, altitude + spread, 2.0 * altitude])
    altitudes = np.unique(altitudes[altitudes > 0])
    speeds = np.linspace(0.0, 2.0 * (vehicle.speed_m_s or 0.5), N_SPEEDS)
    seen = covered(
        scene, shape, view.tan_along, view.tan_across, model.cameras.pixel_pitch_m, view.focal_length_m,
        extension(scene, view, settings.dioptre_per_m), altitudes,
    )  # fmt: skip
    along, pixel_along, pixel_across = (
        seen[name][0] for name in ("footprint_along_m", "pixel_along_m", "pixel_across_m")
    )
    lever = altitudes + shape.outer_radius_m * (not scene.paper)
    blur_px = PLAIN_BLUR_PX if needs.max_blur_px is None else needs.max_blur_px
    motion: dict[str, Any] = motion_along(scene, lever[:, None])
    motion["speed_m_s"] = motion["speed_m_s"] - vehicle.speed_m_s + speeds[None, :]
    exposure = np.minimum(
        operation.blur_exposure_s(blur_px, ground_sample_m=pixel_along[:, None], **motion),
        operation.blur_exposure_s(
            blur_px, ground_sample_m=pixel_across[:, None], **motion_across(scene, lever[:, None])
        ),
    )
    here = required_rate_hz(needs, vehicle.speed_m_s, view.covered_along_m[:, 1:2])
    return Operation(
        speed_m_s=speeds,
        altitude_m=altitudes * np.cos(scene.pitch_rad),
        frame_rate_hz=np.stack([required_rate_hz(needs, float(v), along) for v in speeds], axis=1),
        exposure_s=np.asarray(exposure),
        mission_speed_m_s=vehicle.speed_m_s,
        mission_altitude_m=float(scene.altitude_m[scene.nominal]),
        mission_rate_hz=float(here[0, 0]),
        set_rate_hz=float(settings.rate_hz[0]),
        set_light_time_s=float(model.figures(scene_index, settings).light_time_s[0]),
        camera_rate_hz=float(model.cameras.max_rate_hz[0]),
        blur_px=blur_px,
        blur_is_asked=needs.max_blur_px is not None,
        blur_reserve_px=scene.view.kept("max_blur_px"),
    )


# ---------------------------------------------------------------- geometry


def rig_measures(design: Replay, scene_index: int = 0) -> RigMeasures:
    """Where everything is: port, lamps with their beams, footprint and the next one."""
    model, settings = design.model, design.settings[scene_index]
    problem, hw = model.problem, model.hardware
    scene, view = problem.scenes[scene_index], model.view_at(scene_index, float(settings.dioptre_per_m[0]))
    shape, vehicle = model.shapes[scene_index], scene.view.vehicle
    closer = 1.0 / extension(scene, view, settings.dioptre_per_m[:1])
    range_m = float(scene.range_m[scene.nominal])
    beam = problem.beam(scene_index, model.optics)
    sharp = beams.has_sharp_edge(beam)
    half_angle = beams.edge_half_angle_rad(beam) if sharp else beams.half_power_angle_rad(beam)
    lamps = hw.mount.lamps(hw.count)
    places = () if model.unlit else tuple(zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, strict=True))
    rate = float(settings.rate_hz[0])
    moves = vehicle.speed_m_s > 0.0 and rate > 0.0

    half_along, half_across = (
        0.5 * float(side[0, 1]) for side in (view.covered_along_m, view.covered_across_m)
    )
    return RigMeasures(
        altitude_m=range_m * math.cos(scene.pitch_rad),
        altitude_tolerance_m=vehicle.altitude_tolerance_m,
        half_along_m=half_along,
        half_across_m=half_across,
        is_dome=bool(shape.is_dome),
        outer_radius_m=shape.outer_radius_m,
        lamps=tuple(Lamp(*place) for place in places),
        beam_half_angle_rad=half_angle,
        beam_ends_sharply=sharp,
        image_width_is_along=not hw.landscape,
        speed_m_s=vehicle.speed_m_s,
        advance_m=vehicle.speed_m_s / rate if moves else None,
        overlap=float(model.figures(scene_index, settings).overlap[0, 1]) if moves else None,
        camera_count=vehicle.camera_count,
        sun_elevation_deg=scene.view.scene.sun_elevation_deg if model.unlit else None,
        pitch_rad=scene.pitch_rad,
        edges_m=pitched_edges_m(model, scene_index, closer) if scene.pitch_rad else (),
        pair_m=pair_places_m(model, scene_index, closer),
        looks_up=scene.view.scene.target == "ceiling",
    )


def pair_places_m(model: DesignModel, scene_index: int, closer: Array) -> tuple[tuple[float, float, float], ...]:
    """Of each camera of a stereo pair where it stands and where its view ends, across track [m]; nothing of others.

    closer : the share of its field that a lens keeps at its focus, (1,)
    """
    scene, view = model.problem.scenes[scene_index], model.views[scene_index]
    pair = pair_of(scene)
    if pair is None:
        return ()
    shape = PAPER_PORT if scene.paper else model.shapes[scene_index]
    ends = [
        float(meeting_m(side * closer * view.tan_across, shape=shape, range_m=scene.range_m[scene.nominal],
                        turn_rad=pair.turn_rad)[0])
        for side in (-1.0, 1.0)
    ]  # fmt: skip
    half_m = 0.5 * pair.baseline_m
    return (-half_m, ends[0] - half_m, ends[1] - half_m), (half_m, half_m - ends[1], half_m - ends[0])


def pitched_edges_m(model: DesignModel, scene_index: int, closer: Array) -> tuple[tuple[float, float], ...]:
    """Near and far edge of a view that looks ahead: forward of the port, and half of its width [m]."""
    scene, view = model.problem.scenes[scene_index], model.views[scene_index]
    made = []
    for along in (-closer * view.tan_along, closer * view.tan_along):
        range_m = float(scene.range_m[scene.nominal])
        x_m, y_m, _ = floor_point(along, closer * view.tan_across, shape=model.shapes[scene_index], range_m=range_m)
        forward = x_m * math.cos(scene.pitch_rad) + (range_m + scene.slope * x_m) * math.sin(scene.pitch_rad)
        made.append((float(forward[0]), float(y_m[0])))
    return tuple(made)


def lamp_field(design: Replay, scene_index: int, channel: str | None) -> LampField:
    """The lamps' light as the design's camera sees it, at the nominal altitude alone."""
    model = design.model
    field = LampField(
        model.problem, scene_index, port_index=model.hardware.port, lit=model.lit,
        efficiency=model.efficiency, channel=channel,
    )  # fmt: skip
    field.scene = field.scene.at_nominal
    return field


def sun_field(design: Replay, scene_index: int, channel: str | None = None) -> SunField:
    """Daylight as the design's camera sees it, at the nominal altitude alone."""
    model = design.model
    sun = SunField(
        model.problem, scene_index, port_index=model.hardware.port, efficiency=model.efficiency,
        channel=channel,
    )  # fmt: skip
    sun.scene = sun.scene.at_nominal
    return sun
