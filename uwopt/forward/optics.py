"""Imagers and their light: what hardware sees in a scene before any setting is chosen.

An imager is camera x lens x port x orientation. Its view is geometry alone; its signal needs the
lights' optics (beam and spectrum) and mounts. Both are arrays over many designs; a search and the
evaluation of one system go through the same functions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.curves import spectra
from uwopt.catalog.records import Curve, Light
from uwopt.forward.part_columns import FAVOURED, Cameras, Lenses, Ports, Rows, number
from uwopt.forward.scene import PAPER_N_WATER, SceneOptics
from uwopt.mission.mission import Requirements
from uwopt.model import beam as beams
from uwopt.model import defocus, imaging, lens, operation, port, sensor, veil
from uwopt.model.fineness import scaled
from uwopt.model.imaging import Lamps, PortShape
from uwopt.model.spectrum import resample, resample_power, trapezoid_weights_nm
from uwopt.model.water import PathTable, build_path_table

Array = NDArray[Any]
PAPER_COC_PER_DIAGONAL = 1.0 / 1500.0
REACH_STEP = 1.3
MOST_ORDER, TABLE_ERROR_LOG = 16, 1e-6  # of tables of water's loss
TINY = 1e-300  # in place of a sum of weights that is zero: a black floor, a blind sensor
RMS_FIELD = 1.0 / np.sqrt(3.0)  # of the corner's tangent: the 2-point Gauss rule's node along and across
LARGEST_EXPONENT = 600.0  # of a veil over what it veils: exp(709) is the last that a float holds
CONTRAST_MARGIN = 0.98  # of the forward veil, for what lies between the paths tried
LAMP_FRONT_M = 0.02  # radius of a lamp's front, unless known: nearer than that its light is not a point's
WIDEST_DISC_RAD = float(np.deg2rad(85.0))


# ---------------------------------------------------------------- what the camera sees


@dataclass(frozen=True)
class Views(Rows):
    """Geometry of n imagers in one scene. [near, nominal, far] altitudes are the second axis (n, 3)."""

    tan_along: Array  # tangent in air of the half angle of view along the motion
    tan_across: Array
    footprint_along_m: Array  # (n, 3) full width at the middle of the image's edges
    footprint_across_m: Array
    gsd_m: Array  # (n, 3) largest pixel
    pixel_along_m: Array  # (n, 3) smallest pixel along the motion
    pixel_across_m: Array
    coc_m: Array  # circle of confusion
    focal_length_m: Array  # effective
    collecting_m2: Array  # p^2 * T_lens * T_port * QE scale
    axis_image: Array  # (n, 2, 3) where the floor's image lies on the axis; see `image_places`
    corner_image: Array  # the same at the corner
    rms_image: Array  # the same at the field point that stands for the image's mean


def port_shape(ports: Ports, index: int, scene: SceneOptics) -> PortShape:
    """One port as scalars, with the water in front of it."""
    return PortShape(
        bool(ports.is_dome[index]),
        float(ports.outer_radius_m[index]),
        float(ports.thickness_m[index]),
        float(ports.refractive_index[index]),
        float(ports.gap_m[index]),
        scene.n_water,
    )


def views(
    scene: SceneOptics, cameras: Cameras, lenses: Lenses, shape: PortShape, *, landscape: bool
) -> Views:
    """Geometry of imagers behind one port; camera and lens columns row by row."""
    pitch, focal = cameras.pixel_pitch_m, lenses.focal_length_m
    effective = focal * PAPER_N_WATER if scene.paper and not shape.is_dome else focal
    half_x = cameras.resolution_x_px * pitch / (2.0 * effective)
    half_y = cameras.resolution_y_px * pitch / (2.0 * effective)
    along, across = (half_y, half_x) if landscape else (half_x, half_y)
    ranges = altitudes_m(scene)
    diagonal = np.hypot(cameras.resolution_x_px, cameras.resolution_y_px) * pitch
    wanted_px = scene.view.requirements.circle_of_confusion_px
    coc = diagonal * PAPER_COC_PER_DIAGONAL if wanted_px is None else wanted_px * pitch
    transmission = lenses.transmission * (1.0 if scene.paper else port_transmission(shape))
    pixel_along, pixel_across = smallest_pixels_m(scene, shape, along, across, pitch, effective, ranges)
    return Views(
        tan_along=along,
        tan_across=across,
        footprint_along_m=2.0 * edge_m(scene, shape, along, ranges),
        footprint_across_m=2.0 * edge_m(scene, shape, across, ranges),
        gsd_m=largest_pixel_m(scene, shape, pitch, effective, ranges),
        pixel_along_m=pixel_along,
        pixel_across_m=pixel_across,
        coc_m=coc,
        focal_length_m=effective,
        collecting_m2=np.square(pitch) * transmission * cameras.qe_scale,
        axis_image=image_places(scene, shape, None, len(along)),
        corner_image=image_places(scene, shape, np.hypot(along, across)),
        rms_image=image_places(scene, shape, np.hypot(along, across) * RMS_FIELD),
    )


def image_places(
    scene: SceneOptics, shape: PortShape, tan_air: Array | None, count: int | None = None
) -> Array:
    """Where a port shows the floor at a field point: dioptre = p0 + p1 / (range + p2), for both images.

    (n, 2, 3): tangential and sagittal image of a flat port, the same twice for a dome. On the axis
    (`tan_air` None) it is the port's focus map. Physics page, section 4; `uwopt.model.defocus` for the equations.
    """
    at = focus_map(scene, shape)
    n = len(tan_air) if tan_air is not None else count
    axis = np.broadcast_to(np.array([at.infinity_per_m, at.scale, at.setback_m], float), (n or 0, 2, 3))
    if scene.paper or tan_air is None:
        return np.array(axis)
    if shape.is_dome:
        places = np.array(axis)
        places[:, :, 0] *= np.sqrt(1.0 + np.square(tan_air))[:, None]
        return places
    places = np.zeros((len(tan_air), 2, 3))
    one, other = (
        1.0 / np.array(image)
        for image in zip(
            *(
                defocus.flat_field_dioptres_per_m(
                    range_m, tan_air=tan_air, gap_m=shape.gap_m, thickness_m=shape.thickness_m,
                    n_glass=shape.n_glass, n_water=shape.n_water,
                )
                for range_m in (0.0, 1.0)
            ),
            strict=True,
        )
    )  # fmt: skip
    for index, (start, end) in enumerate((one, other)):  # the image's distance is linear in the range
        places[:, index, 1] = 1.0 / (end - start)
        places[:, index, 2] = start / (end - start)
    return places


def field_dioptres_per_m(places: Array, range_m: Array | float) -> Array:
    """Dioptres of the floor's two images (n, 2, ...) at ranges (...), from `image_places`."""
    ranges = np.asarray(range_m, float)
    spread = (slice(None), slice(None), *([None] * ranges.ndim))
    return np.asarray(places[..., 0][spread] + places[..., 1][spread] / (ranges + places[..., 2][spread]))


def altitudes_m(scene: SceneOptics) -> Array:
    """Near, nominal and far altitude."""
    return np.array([scene.range_m[0], scene.range_m[scene.nominal], scene.range_m[-1]])


def port_transmission(shape: PortShape) -> float:
    """T_port at normal incidence, both faces."""
    return float(port.normal_port_transmittance(n_water=shape.n_water, n_glass=shape.n_glass))


def edge_m(scene: SceneOptics, shape: PortShape, tangent: Array, ranges: Array) -> Array:
    """Distance on the floor from the axis to the middle of an image edge, (n, 3)."""
    tangent = tangent[:, None]
    if scene.paper:
        return tangent * ranges
    if shape.is_dome:
        return np.asarray(
            port.dome_floor_distance_m(tangent, outer_radius_m=shape.outer_radius_m, range_m=ranges)
        )
    return np.asarray(
        port.flat_floor_distance_m(
            tangent,
            gap_m=shape.gap_m,
            thickness_m=shape.thickness_m,
            n_glass=shape.n_glass,
            n_water=shape.n_water,
            range_m=ranges,
        )
    )


def largest_pixel_m(scene: SceneOptics, shape: PortShape, pitch: Array, focal: Array, ranges: Array) -> Array:
    """Largest ground sample of the image, (n, 3): uniform behind a dome, at the centre behind a flat port."""
    scale = (pitch / focal)[:, None]
    if scene.paper:
        return scale * ranges
    if shape.is_dome:
        return scale * (ranges + shape.outer_radius_m)
    return np.asarray(
        operation.flat_largest_pixel_m(
            ranges,
            pixel_pitch_m=pitch[:, None],
            focal_length_m=focal[:, None],
            gap_m=shape.gap_m,
            thickness_m=shape.thickness_m,
            n_glass=shape.n_glass,
            n_water=shape.n_water,
        )
    )


def smallest_pixels_m(
    scene: SceneOptics,
    shape: PortShape,
    along: Array,
    across: Array,
    pitch: Array,
    focal: Array,
    ranges: Array,
) -> tuple[Array, Array]:
    """Smallest ground samples along and across the motion, (n, 3) each."""
    if scene.paper or shape.is_dome:
        same = largest_pixel_m(scene, shape, pitch, focal, ranges)
        return same, same
    common = dict(
        pixel_pitch_m=pitch[:, None],
        focal_length_m=focal[:, None],
        gap_m=shape.gap_m,
        thickness_m=shape.thickness_m,
        n_glass=shape.n_glass,
        n_water=shape.n_water,
        range_m=ranges,
    )
    one = operation.flat_smallest_pixel_along_m(along[:, None], tan_across_edge=across[:, None], **common)
    other = operation.flat_smallest_pixel_along_m(across[:, None], tan_across_edge=along[:, None], **common)
    return np.asarray(one), np.asarray(other)


def focus_map(scene: SceneOptics, shape: PortShape) -> port.FocusMap:
    """The port's map between distance in water and dioptre at the lens."""
    if not shape.is_dome:
        if scene.paper:
            return port.identity_focus_map()
        return port.flat_focus_map(
            gap_m=shape.gap_m, thickness_m=shape.thickness_m, n_glass=shape.n_glass, n_water=shape.n_water
        )
    build = port.paper_dome_focus_map if scene.paper else port.dome_focus_map
    return build(
        outer_radius_m=shape.outer_radius_m,
        thickness_m=shape.thickness_m,
        n_glass=shape.n_glass,
        n_water=shape.n_water,
    )


# ---------------------------------------------------------------- focus and depth of field


@dataclass(frozen=True)
class Focus:
    """Common focus of an imager over its scenes, and by scene the f-number that keeps what it wants sharp."""

    dioptre_per_m: list[Array]  # by scene, at the lens
    n_depth: list[Array]  # by scene, smallest f-number; 0 where any will do


def place_focus(scenes: Sequence[SceneOptics], maps: Sequence[port.FocusMap], seen: Sequence[Views]) -> Focus:
    """Put the focus where what must be sharp needs the smallest f-number.

    One focus serves all scenes, because behind a sealed port it cannot be touched. Where no depth of field is
    asked for, the nominal altitude must be sharp: an image is wanted. Physics `paper` focuses at the altitude of
    its one scene.
    """
    count = len(seen[0].tan_along)
    if len(scenes) == 1 and (scenes[0].paper or scenes[0].view.requirements.min_dof_m is None):
        at_altitude = port.lens_dioptre_per_m(scenes[0].range_m[scenes[0].nominal], focus_map=maps[0])
        dioptre = np.full(count, float(at_altitude))
    else:
        dioptre = middle_focus(sharp_intervals(scenes, maps, seen), [view.coc_m for view in seen])
    n_depth = [
        depth_f_number(scene, at, view, dioptre) for scene, at, view in zip(scenes, maps, seen, strict=True)
    ]
    return Focus([dioptre] * len(scenes), n_depth)


def middle_focus(intervals: Sequence[tuple[Array, Array]], coc_m: Sequence[Array]) -> Array:
    """The focus that covers all intervals of dioptres (near, far) with the smallest common f-number.

        N = (f^2 / c) max(D_n - D, D - D_f) / (1 - f D) of each; near ends ask for less as D grows, far ends for more

    They meet at the pair of a near and a far end that asks for most, (D_n - D_f) / (c_n + c_f): in the dioptric
    middle where all circles of confusion c are the same.
    """
    best, most = np.zeros_like(coc_m[0]), np.full_like(coc_m[0], -np.inf)
    for (near, _), coc_near in zip(intervals, coc_m, strict=True):
        for (_, far), coc_far in zip(intervals, coc_m, strict=True):
            share = coc_near / (coc_near + coc_far)
            asked = (near - far) / (coc_near + coc_far)
            focus = near - share * (near - far)
            best, most = np.where(asked > most, focus, best), np.maximum(asked, most)
    return best


def held_at_corner(scene: SceneOptics) -> bool:
    """Whether the wanted depth of field must hold in the corners too."""
    needs = scene.view.requirements
    return needs.dof_at == "corner" and needs.min_dof_m is not None and not scene.paper


def sharp_ends_m(scene: SceneOptics, start_m: float = np.inf) -> tuple[float, float]:
    """Nearest and farthest distance that must be sharp: the nominal altitude, or the depth of field asked for.

    `start_m`: where a depth of field begins that other scenes need nearer than this one.
    """
    depth = scene.view.requirements.min_dof_m
    if depth is None:
        nominal = float(scene.range_m[scene.nominal])
        return nominal, nominal
    near, far = float(scene.range_m[0]), float(scene.range_m[-1])
    return near, max(far, min(near, start_m) + depth)


def sharp_intervals(
    scenes: Sequence[SceneOptics], maps: Sequence[port.FocusMap], seen: Sequence[Views]
) -> list[tuple[Array, Array]]:
    """Dioptres at the lens of the nearest and the farthest distance that must be sharp, by scene."""
    count = len(seen[0].tan_along)
    nearest = max(
        float(port.lens_dioptre_per_m(sharp_ends_m(scene)[0], focus_map=at))
        for scene, at in zip(scenes, maps, strict=True)
    )
    found = []
    for scene, at, view in zip(scenes, maps, seen, strict=True):
        ends_m = sharp_ends_m(scene, float(port.water_distance_m(nearest, focus_map=at)))
        near, far = (np.full(count, float(port.lens_dioptre_per_m(end, focus_map=at))) for end in ends_m)
        if held_at_corner(scene):
            ends = field_dioptres_per_m(view.corner_image, np.array(sharp_ends_m(scene)))
            near, far = np.maximum(near, ends.max(axis=(1, 2))), np.minimum(far, ends.min(axis=(1, 2)))
        found.append((near, far))
    return found


def depth_f_number(scene: SceneOptics, at: port.FocusMap, view: Views, dioptre_per_m: Array) -> Array:
    """The smallest f-number that keeps sharp what one scene wants sharp, at a given focus."""
    near_m, far_m = sharp_ends_m(scene)
    common = dict(focal_length_m=view.focal_length_m, circle_of_confusion_m=view.coc_m)
    if held_at_corner(scene):
        ends = field_dioptres_per_m(view.corner_image, np.array([near_m, far_m]))
        axis = [float(port.lens_dioptre_per_m(end, focus_map=at)) for end in (near_m, far_m)]
        return np.asarray(
            lens.f_number_to_reach(
                np.maximum(axis[0], ends.max(axis=(1, 2))),
                far_dioptre_per_m=np.minimum(axis[1], ends.min(axis=(1, 2))),
                focus_dioptre_per_m=dioptre_per_m,
                **common,
            )
        )
    depth = scene.view.requirements.min_dof_m
    return np.asarray(
        lens.f_number_for_interval(
            dioptre_per_m,
            near_m=near_m,
            far_m=near_m if depth is None else float(scene.range_m[-1]),
            min_dof_m=depth or 0.0,
            focus_map=at,
            **common,
        )
    )


def working_factor(scene: SceneOptics, focal_length_m: Array, dioptre_per_m: Array) -> Array:
    """N_w / N = 1 + m at the focus; 1 in physics `paper`."""
    if scene.paper:
        return np.ones(len(focal_length_m))
    return np.asarray(
        lens.working_f_number(1.0, focal_length_m=focal_length_m, object_distance_m=1.0 / dioptre_per_m)
    )


# ---------------------------------------------------------------- motion


def blur_time_s(scene: SceneOptics, shape: PortShape, view: Views) -> Array:
    """Longest light-collecting time within the allowed blur, worst over altitudes and both axes."""
    limit_px = scene.view.requirements.max_blur_px
    count = len(view.tan_along)
    if limit_px is None:
        return np.full(count, np.inf)
    lever = altitudes_m(scene) + shape.outer_radius_m * (not scene.paper)
    return np.asarray(
        np.minimum(
            operation.blur_exposure_s(
                limit_px, ground_sample_m=view.pixel_along_m, **motion_along(scene, lever)
            ),
            operation.blur_exposure_s(
                limit_px, ground_sample_m=view.pixel_across_m, **motion_across(scene, lever)
            ),
        ).min(axis=1)
    )


def shutter_skew_px(scene: SceneOptics, shape: PortShape, view: Views, readout_s: Array) -> Array:
    """Skew of a rolling shutter along the motion, worst over altitudes."""
    lever = altitudes_m(scene) + shape.outer_radius_m * (not scene.paper)
    return np.asarray(
        operation.skew_px(
            readout_s[:, None], ground_sample_m=view.pixel_along_m, **motion_along(scene, lever)
        ).max(axis=1)
    )


def motion_along(scene: SceneOptics, lever_m: Array) -> dict[str, Any]:
    """What moves the floor through the image along the motion: speed and pitch."""
    vehicle = scene.view.vehicle
    return dict(
        speed_m_s=vehicle.speed_m_s, rotation_rate_rad_s=np.deg2rad(vehicle.pitch_rate_deg_s), lever_m=lever_m
    )


def motion_across(scene: SceneOptics, lever_m: Array) -> dict[str, Any]:
    """What moves the floor through the image across the motion: roll."""
    vehicle = scene.view.vehicle
    return dict(speed_m_s=0.0, rotation_rate_rad_s=np.deg2rad(vehicle.roll_rate_deg_s), lever_m=lever_m)


def least_overlap(requirements: Requirements) -> float | None:
    """Overlap that images must have: what is asked for; 0, images that just touch, where nothing fixes their rate."""
    if requirements.overlap is None and requirements.frame_interval_s is None:
        return 0.0
    return requirements.overlap


def required_rate_hz(requirements: Requirements, speed_m_s: float, footprint_along_m: Array) -> Array:
    """Frame rate that overlap or frame interval ask for; frames that just touch when neither is given."""
    shared = least_overlap(requirements)
    rate = np.zeros_like(footprint_along_m)
    if shared is not None:
        rate = operation.frame_rate_hz(speed_m_s, footprint_along_m=footprint_along_m, overlap=shared)
    if requirements.frame_interval_s is not None:
        rate = np.maximum(rate, 1.0 / requirements.frame_interval_s)
    return np.asarray(rate)


# ---------------------------------------------------------------- light


@dataclass(frozen=True)
class LightOptics:
    """What one lamp's light is like: beam in each scene's water and relative spectrum. Lights that share it share
    signals."""

    beams: tuple[beams.Beam, ...]
    spectrum_id: str
    spectrum: Curve | None


def light_optics(
    light: Light, *, n_water: Sequence[float], end: str = "central", paper: bool = False
) -> LightOptics:
    """Beam and spectrum of a light; angles stated in air, or in no medium, are refracted into each scene's water.

    Physics `paper` knows one beam, the even disc: it takes the place of any other of the same angle.
    """
    made = {index: light_beam(light, n_water=index, end=end) for index in n_water}
    if paper:
        made = {
            index: beam
            if beam.kind == "disc"
            else beams.disc_beam(min(beams.half_power_angle_rad(beam), WIDEST_DISC_RAD))
            for index, beam in made.items()
        }
    return LightOptics(tuple(made[index] for index in n_water), light.spectrum_id, light.spectrum)


def light_beam(light: Light, *, n_water: float, end: str = "central") -> beams.Beam:
    """The beam of a light in water, from its data sheet's angle or its measured profile."""
    in_water = light.beam_medium == "water"
    if light.beam == "tabulated" and light.beam_profile is not None:
        angles = np.deg2rad(light.beam_profile.x)
        values = np.asarray(light.beam_profile.y, float)
        return beams.tabulated_beam(
            angles, values, medium="water" if in_water else "air", n_w=n_water, total_flux_lm=None
        )  # the shape; what a profile in candela holds of the flux is in the output factor
    half = np.deg2rad(number(light.beam_angle_deg, 90.0, end, FAVOURED["beam_angle_deg"])) / 2.0  # type: ignore[arg-type]
    if not in_water:
        half = float(beams.half_angle_in_water_rad(half, n_w=n_water))
    if light.beam == "disc":
        return beams.disc_beam(half)
    if light.beam == "cone":
        return beams.cone_beam(half)
    return beams.cosine_power_beam(2.0 * half)


def lamp_set(count: int, *, baseline_m: float, tilt_rad: float) -> Lamps:
    """n lamps across track, alternately at plus and minus the baseline, leaning outward (PHYSICS section 1)."""
    right = (count + 1) // 2
    sides = [(1.0, right / count)] + ([(-1.0, (count - right) / count)] if count > 1 else [])
    places = [(side * baseline_m, share) for side, share in sides]
    aims = [
        beams.lamp_aim(0.0, tilt_rad, lamp_x_m=0.0, lamp_y_m=side * max(baseline_m, 1e-12))
        for side, _ in sides
    ]
    return Lamps(
        x_m=tuple(0.0 for _ in places),
        y_m=tuple(y for y, _ in places),
        z_m=tuple(0.0 for _ in places),
        aim=tuple((float(a[0]), float(a[1]), float(a[2])) for a in aims),
        share=tuple(share for _, share in places),
    )


def mounted_lamps(mounts: Sequence[Any]) -> Lamps:
    """Lamps where the mission or system puts them."""
    aims = [
        beams.lamp_aim(np.deg2rad(m.tilt_x_deg), np.deg2rad(m.tilt_y_deg), lamp_x_m=m.x_m, lamp_y_m=m.y_m)
        for m in mounts
    ]
    return Lamps(
        x_m=tuple(float(m.x_m) for m in mounts),
        y_m=tuple(float(m.y_m) for m in mounts),
        z_m=tuple(float(m.z_m) for m in mounts),
        aim=tuple((float(a[0]), float(a[1]), float(a[2])) for a in aims),
        share=tuple(1.0 / len(mounts) for _ in mounts),
    )


def one_side(lamps: Lamps) -> Lamps:
    """The lamps that stand for all in the mean over a symmetric image: mirror images add nothing new."""
    if len(lamps.x_m) == 2 and mirrored(lamps):
        return Lamps(lamps.x_m[:1], lamps.y_m[:1], lamps.z_m[:1], lamps.aim[:1], (1.0,))
    return lamps


def mirrored(lamps: Lamps) -> bool:
    """Whether two lamps are each other's mirror image across the track, in place and in aim."""
    (one_x, other_x), (one_y, other_y), (one_z, other_z) = lamps.x_m, lamps.y_m, lamps.z_m
    one, other = lamps.aim
    places = one_x == other_x == 0.0 and one_y == -other_y and one_z == other_z
    return places and bool(np.allclose(one, (other[0], -other[1], other[2]), rtol=0, atol=1e-12))


def efficiency_curve(curves: dict[str, Curve], wavelength_nm: Array, *, channel: str | None = None) -> Array:
    """Quantum efficiency on the grid; a colour sensor counts as (R + 2G + B)/4 unless a channel is named."""
    on_grid = {name: efficiency_on_grid(curve, wavelength_nm) for name, curve in curves.items()}
    if channel is not None:
        return np.asarray(on_grid.get(channel, on_grid.get("mono")))
    if "mono" in on_grid:
        return np.asarray(on_grid["mono"])
    return np.asarray(
        sensor.colour_mean_efficiency(on_grid["red"], green=on_grid["green"], blue=on_grid["blue"])
    )


def efficiency_on_grid(curve: Curve, wavelength_nm: Array) -> Array:
    """One channel on the grid, held beyond its ends; steps between two points count by where they lie.

    A filter's edge is often steeper than the grid: read at the points alone it would be half a step off.
    """
    at_nm, values = np.array(curve.x), np.array(curve.y)
    if np.diff(at_nm).min(initial=np.inf) >= np.diff(wavelength_nm).max():
        return resample(wavelength_nm, table_nm=at_nm, table_values=values, outside="hold")
    ends_nm = wavelength_nm[[0, -1]]
    inside = (at_nm > ends_nm[0]) & (at_nm < ends_nm[1])
    at_ends = resample(ends_nm, table_nm=at_nm, table_values=values, outside="hold")
    return resample_power(
        wavelength_nm,
        table_nm=np.r_[ends_nm[0], at_nm[inside], ends_nm[1]],
        table_values=np.r_[at_ends[0], values[inside], at_ends[1]],
    )


class Contraction:
    """The spectrum of one scene, contracted once for every pair of light spectrum and efficiency curve.

    `response(s, q)`: electrons per m^2 of pixel and lm s per m^2 on the floor, water apart.
    `table(s, q)`: water's loss relative to it over both legs. Tables are built when first needed.
    """

    def __init__(
        self, scene: SceneOptics, optics: Sequence[LightOptics], efficiencies: Sequence[dict[str, Curve]]
    ):
        self.scene = scene
        self.spectrum_names: list[tuple[str, Curve | None]] = []
        self.spectrum_of = np.empty(len(optics), int)
        for index, item in enumerate(optics):
            key = (item.spectrum_id, item.spectrum)
            if key not in self.spectrum_names:
                self.spectrum_names.append(key)
            self.spectrum_of[index] = self.spectrum_names.index(key)
        self.efficiencies = list(efficiencies)
        self._curve_keys = [tuple(sorted(curves.items())) for curves in efficiencies]
        self._reach_m = (0.0, 0.0)

    def key(self, spectrum: int, efficiency: int, channel: str | None) -> tuple[Any, ...]:
        """What a weight depends on, in the scene's cache."""
        return (self.spectrum_names[spectrum], self._curve_keys[efficiency], channel)

    def weight(self, spectrum: int, efficiency: int, channel: str | None = None) -> Array:
        """Signal weight by wavelength; see `imaging.signal_weight`."""
        key = ("weight", *self.key(spectrum, efficiency, channel))
        scene = self.scene
        if key not in scene.cache:
            scene.cache[key] = imaging.signal_weight(
                relative_spectrum(self.spectrum_names[spectrum], scene.wavelength_nm),
                wavelength_nm=scene.wavelength_nm,
                photopic=scene.photopic,
                reflectance=scene.reflectance,
                quantum_efficiency=efficiency_curve(
                    self.efficiencies[efficiency], scene.wavelength_nm, channel=channel
                ),
                n_water=scene.radiance_index,
            )
        return np.asarray(scene.cache[key])

    def response(self, spectrum: int, efficiency: int, channel: str | None = None) -> float:
        """Sum of the weight over wavelengths."""
        return float(self.weight(spectrum, efficiency, channel).sum())

    def straight_loss(self, spectrum: int, efficiency: int, channel: str | None = None) -> Array:
        """Water's loss straight down and up, by altitude: the paper's equation (1) on the axis."""
        scene = self.scene
        weight = self.weight(spectrum, efficiency, channel)
        optical = (scene.attenuation_per_m + scene.lamp_attenuation_per_m) * scene.range_m[:, None]
        least = optical.min(axis=1, keepdims=True)
        loss = (weight * np.exp(-(optical - least))).sum(axis=1) / max(float(weight.sum()), TINY)
        return np.asarray(loss * np.exp(-least[:, 0]))

    def mean_loss(self, spectrum: int, efficiency: int, *, lamp_m: float, camera_m: float) -> float:
        """Water's loss over one pair of paths, integrated directly."""
        scene = self.scene
        weight = self.weight(spectrum, efficiency)
        optical = scene.lamp_attenuation_per_m * lamp_m + scene.attenuation_per_m * camera_m
        least = float(optical.min())
        return float((weight * np.exp(-(optical - least))).sum() / max(weight.sum(), TINY) * np.exp(-least))

    def most_contrast(self, spectrum: int, efficiency: int, altitude: int) -> float:
        """Upper bound of the image-forming share at one altitude: the forward veil on the shortest rays.

        The veil grows with both paths but for the spectrum's shift along them, so several are tried.
        """
        scene = self.scene
        key = ("most contrast", *self.key(spectrum, efficiency, None), altitude, self._reach_m)
        if key not in scene.cache:
            scene.cache[key] = self._most_contrast(spectrum, efficiency, float(scene.range_m[altitude]))
        return float(scene.cache[key])

    def _most_contrast(self, spectrum: int, efficiency: int, near: float) -> float:
        scene = self.scene
        weight = self.weight(spectrum, efficiency)
        excess = scene.attenuation_per_m - scene.lamp_attenuation_per_m
        lit = weight > 0
        if not lit.any():  # a black floor or a blind sensor
            return 1.0
        least = np.inf
        for camera_m in np.linspace(near, max(self._reach_m[1], near), 4):
            for lamp_m in np.linspace(0.5 * near, max(self._reach_m[0], near), 4):
                optical = scene.lamp_attenuation_per_m[lit] * lamp_m + scene.attenuation_per_m[lit] * camera_m
                seen = weight[lit] * np.exp(-(optical - optical.min()))
                veil = np.expm1(np.minimum(excess[lit] * camera_m, LARGEST_EXPONENT))
                least = min(least, float((seen * veil).sum() / seen.sum()))
        return 1.0 / (1.0 + CONTRAST_MARGIN * least)

    def set_reach(self, lamp_reach_m: float, camera_reach_m: float) -> None:
        """Longest paths that tables must cover, rounded up so that like problems share their tables."""
        near = float(self.scene.range_m[0])
        self._reach_m = (rounded_up(max(lamp_reach_m, near)), rounded_up(max(camera_reach_m, near)))

    def table(
        self, spectrum: int, efficiency: int, channel: str | None = None, *, lowest_m: float = 0.0,
        forward: bool = False,
    ) -> PathTable:  # fmt: skip
        """Loss over lamp leg and camera leg, as a table over both lengths.

        `forward`: of the forward veil, exp(-K r) - exp(-c r) on the camera leg: what reaches the camera, but
        forms no image.
        """
        scene = self.scene
        near = float(scene.range_m[0])
        lowest = min(lowest_m, near) * 0.999
        key = ("table", *self.key(spectrum, efficiency, channel), self._reach_m, lowest, forward)
        if key not in scene.cache:
            scene.cache[key] = build_path_table(
                self.weight(spectrum, efficiency, channel),
                wavelength_nm=None,  # the weight holds the trapezoid's steps
                k_lamp_per_m=scene.lamp_attenuation_per_m,
                c_camera_per_m=scene.attenuation_per_m,
                k_camera_per_m=scene.lamp_attenuation_per_m if forward else None,
                lamp_range_m=(lowest, self._reach_m[0]),
                camera_range_m=(near * 0.999, self._reach_m[1]),
                **self.table_settings(),
            )
        table: PathTable = scene.cache[key]
        return table

    def table_settings(self) -> dict[str, Any]:
        """Order and tolerance of the loss tables."""
        fineness = self.scene.fineness.spectrum
        return dict(
            max_order=scaled(MOST_ORDER, max(fineness, 1.0) ** 0.5),
            tolerance_log=TABLE_ERROR_LOG / fineness**2,
        )

    def scatterers(
        self, spectrum: int, efficiency: int, channel: str | None = None
    ) -> tuple[veil.Scatterer, ...]:
        """What scatters on the way to the camera, particles and molecules, each with its loss table."""
        scene = self.scene
        key = ("scatter", *self.key(spectrum, efficiency, channel), self._reach_m)
        if key not in scene.cache:
            lamp_end, camera_end = (
                min(reach, LAMP_FRONT_M + veil.OPTICAL_REACH / max(float(least.min()), TINY))
                for reach, least in zip(
                    self._reach_m, (scene.lamp_attenuation_per_m, scene.attenuation_per_m), strict=True
                )
            )
            scene.cache[key] = tuple(
                veil.Scatterer(
                    phase=part.phase,
                    table=build_path_table(
                        self.scatter_weight(part.scattering_per_m, spectrum, efficiency, channel),
                        wavelength_nm=None,
                        k_lamp_per_m=scene.lamp_attenuation_per_m,
                        c_camera_per_m=scene.attenuation_per_m,
                        lamp_range_m=(LAMP_FRONT_M, max(lamp_end, 2 * LAMP_FRONT_M)),
                        camera_range_m=(0.0, camera_end),
                        **self.table_settings(),
                    ),
                )
                for part in scene.scattering
            )
        found: tuple[veil.Scatterer, ...] = scene.cache[key]
        return found

    def scatter_weight(
        self, scattering_per_m: Array, spectrum: int, efficiency: int, channel: str | None = None
    ) -> Array:
        """Weight by wavelength of light that the water scatters; see `imaging.scatter_weight`."""
        scene = self.scene
        return imaging.scatter_weight(
            relative_spectrum(self.spectrum_names[spectrum], scene.wavelength_nm),
            wavelength_nm=scene.wavelength_nm,
            photopic=scene.photopic,
            scattering_per_m=scattering_per_m,
            quantum_efficiency=efficiency_curve(
                self.efficiencies[efficiency], scene.wavelength_nm, channel=channel
            ),
            n_water=scene.radiance_index,
        )


def rounded_up(length_m: float) -> float:
    """The next length of a series in steps of 30 %."""
    return float(REACH_STEP ** np.ceil(np.log(length_m * 1.001) / np.log(REACH_STEP)))


def relative_spectrum(key: tuple[str, Curve | None], wavelength_nm: Array) -> Array:
    """A light's relative spectrum on the grid: the user's own curve, or a named one."""
    name, curve = key
    if curve is not None:
        return resample_power(wavelength_nm, table_nm=np.array(curve.x), table_values=np.array(curve.y))
    known = spectra.light_spectrum(name)
    return resample_power(wavelength_nm, table_nm=known.wavelength_nm, table_values=known.value)


def luminous_weight(scene: SceneOptics, item: LightOptics) -> Array:
    """A light's luminous flux by wavelength, any scale: V S times the steps of the grid."""
    spectrum = relative_spectrum((item.spectrum_id, item.spectrum), scene.wavelength_nm)
    return np.asarray(scene.photopic * spectrum * trapezoid_weights_nm(scene.wavelength_nm))


def on_axis_gain(beam: beams.Beam, ranges: Array) -> Array:
    """Illuminance per lumen on the axis of a lamp that stands at the camera (physics `paper`) [1/m^2]."""
    return np.asarray(beams.intensity_per_sr(np.ones_like(ranges), beam) / np.square(ranges))
