"""What the camera sees: fields, footprints and pixels on the floor behind flat ports and domes.

An imager is camera x lens x port x orientation; its view is geometry alone, as arrays over many designs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns, groups_alike
from uwopt.forward.part_columns import Cameras, Lenses, Ports
from uwopt.forward.scene import PAPER_N_WATER, SceneOptics
from uwopt.model import defocus, operation, port, stereo
from uwopt.model.footprint import floor_steps
from uwopt.model.imaging import PortShape, descent, floor_point, ray_spread

PAPER_COC_PER_DIAGONAL = 1.0 / 1500.0
CORNERS_REACH = 1.5  # of tables, in distances of the image's corner from the axis: with a margin
CORNER_FIELD = 0.8  # of the half diagonal: where a corner's sharpness counts; 9 to 14 % of the image lie beyond
PLACES_ALONG = 17  # of an image behind a flat port, where pixels on a tilted plane are compared
PAPER_PORT = PortShape(True, 0.0, 0.0, 1.0, 0.0, PAPER_N_WATER)  # rays start at the port's middle, unbent
STRIP_PLACES = (0.0, 0.5, 1.0)  # of half the strip that a stereo pair sees, where its error is worked out
RMS_FIELD = 1.0 / np.sqrt(3.0)  # of the corner's tangent: the 2-point Gauss rule's node along and across


@dataclass(frozen=True)
class Views(Columns):
    """Geometry of n imagers in one scene. [near, nominal, far] altitudes are the second axis (n, 3)."""

    tan_along: Array  # tangent in air of the half angle of view along the motion
    tan_across: Array
    footprint_along_m: Array  # (n, 3) full width at the middle of the image's edges
    footprint_across_m: Array  # at the near edge, where the target's plane is tilted
    area_m2: Array  # (n, 3) of the footprint
    covered_along_m: Array  # (n, 3) of it, what the image surely covers where the lens is focused; see `at_focus`
    covered_across_m: Array
    gsd_m: Array  # (n, 3) largest pixel
    pixel_along_m: Array  # (n, 3) smallest pixel along the motion, where the lens is focused
    pixel_across_m: Array
    far_m: Array  # (n,) how far from the axis the image reaches at the highest altitude; tilted: from the port
    farthest: Array  # (n,) the far edge's middle over the axis, as distances along it; inf at the horizon
    coc_m: Array  # circle of confusion
    focal_length_m: Array  # effective
    collecting_m2: Array  # p^2 * T_lens * T_port * QE scale
    axis_image: Array  # (n, 2, 3) where the floor's image lies on the axis; see `image_places`
    corner_image: Array  # the same where a corner's sharpness counts; (n, 4, 3), near and far, of a tilted plane
    rms_image: Array  # the same at the field points that stand for the image's mean
    common_across_m: Array  # (n, 3) wide, what both cameras of a stereo pair surely see; what others cover
    depth_error_m: Array  # (n, 3) largest over it, of the distance by a stereo pair; 0 of others, inf without a strip


def narrowest_m(view: Views) -> Array:
    """The strip that surely is seen at every altitude of the band [m], (n,): neighbouring lines overlap by it."""
    return np.asarray(view.common_across_m.min(axis=1))


def port_shape(ports: Ports, index: int, scene: SceneOptics) -> PortShape:
    """One port as scalars, with the water in front of it."""
    return PortShape(
        bool(ports.is_dome[index]),
        float(ports.outer_radius_m[index]),
        float(ports.thickness_m[index]),
        float(ports.refractive_index[index]),
        float(ports.gap_m[index]),
        scene.n_water,
        slope=scene.slope,
    )


def port_shapes(ports: Ports, index: Array, scene: SceneOptics) -> Iterator[tuple[Array, PortShape]]:
    """Ports row by row, (n,), as columns: one shape for all of a geometry, with the places of its rows."""
    for is_dome in (True, False):
        mine = np.flatnonzero(ports.is_dome[index] == is_dome)
        if len(mine):
            at = index[mine]
            yield mine, PortShape(
                is_dome, ports.outer_radius_m[at], ports.thickness_m[at], ports.refractive_index[at], ports.gap_m[at],
                scene.n_water, slope=scene.slope,
            )  # fmt: skip


def table_reach_m(view: Views) -> float:
    """How far from the axis tables of water's loss must reach: past the widest image."""
    return CORNERS_REACH * float(view.far_m.max(initial=0.0))


def views(
    scene: SceneOptics, cameras: Cameras, lenses: Lenses, shape: PortShape, *, landscape: bool
) -> Views:
    """Geometry of imagers behind one port; camera and lens columns row by row.

    What is the same of like sensors behind lenses of one focal length is worked out once: a catalogue
    has some twenty pairs of each kind.
    """
    pitch, (along, across, effective) = cameras.pixel_pitch_m, field_of_view(scene, cameras, lenses, shape, landscape)
    alike, ranges = (along, across, pitch, effective), altitudes_m(scene)
    if len(along) > 1:
        first, back = groups_alike(*alike, *own_ranges(ranges))
        few_m = ranges[first] if ranges.ndim > 1 else ranges
        made = geometry(scene, shape, *(own[first] for own in alike), ranges=few_m)
        seen = {name: column.take(back, axis=0) for name, column in made.items()}
    else:
        seen = geometry(scene, shape, *alike, ranges=ranges)
    axis = np.broadcast_to(image_places(scene, shape, None, 1), (len(along), 2, 3))
    return Views(
        tan_along=along, tan_across=across, **seen, axis_image=axis, coc_m=circle_of_confusion_m(scene, cameras),
        focal_length_m=effective, collecting_m2=collecting_m2(scene, cameras, lenses, shape),
    )  # fmt: skip


def collecting_m2(scene: SceneOptics, cameras: Cameras, lenses: Lenses, shape: PortShape) -> Array:
    """What a pixel gathers light with, (n,) [m^2]: its area times what lens, port and quantum efficiency leave."""
    transmission = lenses.transmission * (1.0 if scene.paper else port_transmission(shape))
    return np.asarray(np.square(cameras.pixel_pitch_m) * transmission * cameras.qe_scale)


def own_ranges(ranges: Array) -> tuple[Array, ...]:
    """Ranges of each row, where they have ranges of their own, as columns."""
    return tuple(ranges.T) if ranges.ndim > 1 else ()


def geometry(
    scene: SceneOptics, shape: PortShape, along: Array, across: Array, pitch: Array, effective: Array, *, ranges: Array
) -> dict[str, Array]:
    """The columns of `Views` that follow from the field of view and the pixel: footprints, and where images lie."""
    covered = footprints(scene, shape, along, across, pitch, effective, ranges)
    if (pair := pair_of(scene)) is not None and pair.turn_rad and not (scene.slope or scene.paper):
        most_m = stereo.largest_step_m(across[:, None], shape=shape.over(1), range_m=ranges, turn_rad=pair.turn_rad)
        covered["gsd_m"] = np.maximum(covered["gsd_m"], (pitch / effective)[:, None] * most_m)
    return dict(
        **covered, covered_along_m=covered["footprint_along_m"], covered_across_m=covered["footprint_across_m"],
        **seen_by_pair(scene, shape, across, pitch / effective, covered["footprint_across_m"], ranges),
        corner_image=tilted_places(scene, shape, along, across, CORNER_FIELD),
        rms_image=tilted_places(scene, shape, along, across, float(RMS_FIELD)),
    )


def pair_of(scene: SceneOptics) -> stereo.Pair | None:
    """How the cameras of a stereo pair stand; None of others."""
    vehicle = scene.view.vehicle
    if vehicle.camera_baseline_m is None:
        return None
    return stereo.Pair(vehicle.camera_baseline_m, 0.5 * float(np.deg2rad(vehicle.camera_convergence_deg)))


def seen_by_pair(
    scene: SceneOptics, shape: PortShape, across: Array, tan_per_px: Array, footprint_across_m: Array, ranges: Array
) -> dict[str, Array]:
    """The columns of `Views` that say what a stereo pair sees and measures of the target's plane.

    The error is the largest of three places from the middle of the strip to its edge, in the middle along the motion.
    """
    pair = pair_of(scene)
    if pair is None:
        return dict(common_across_m=footprint_across_m, depth_error_m=np.zeros_like(footprint_across_m))
    shape = PAPER_PORT if scene.paper else shape
    wide_m = stereo.common_width_m(across[:, None], shape=shape, range_m=ranges, pair=pair)
    places = 0.5 * wide_m[..., None] * np.array(STRIP_PLACES)
    errors = stereo.depth_error_m(
        places, shape=shape, range_m=ranges[..., None], pair=pair, tan_per_px=tan_per_px[:, None, None],
        disparity_error_px=scene.view.requirements.disparity_error_px,
    )
    return dict(common_across_m=wide_m, depth_error_m=np.where(wide_m > 0.0, errors.max(axis=2), np.inf))


def field_of_view(
    scene: SceneOptics, cameras: Cameras, lenses: Lenses, shape: PortShape, landscape: bool | Array
) -> tuple[Array, Array, Array]:
    """Tangents in air of the half angles of view along and across the motion, and the effective focal length [m]."""
    focal = lenses.focal_length_m
    effective = focal * PAPER_N_WATER if scene.paper and not shape.is_dome else focal
    half_x = cameras.resolution_x_px * cameras.pixel_pitch_m / (2.0 * effective)
    half_y = cameras.resolution_y_px * cameras.pixel_pitch_m / (2.0 * effective)
    return np.where(landscape, half_y, half_x), np.where(landscape, half_x, half_y), effective


def circle_of_confusion_m(scene: SceneOptics, cameras: Cameras) -> Array:
    """Width of a point that counts as sharp: as many pixels as are asked for, else a share of the diagonal."""
    wanted_px = scene.view.requirements.circle_of_confusion_px
    if wanted_px is not None:
        return np.asarray(wanted_px * cameras.pixel_pitch_m)
    diagonal_px = np.hypot(cameras.resolution_x_px, cameras.resolution_y_px)
    return np.asarray(diagonal_px * cameras.pixel_pitch_m * PAPER_COC_PER_DIAGONAL)


def footprints(
    scene: SceneOptics, shape: PortShape, along: Array, across: Array, pitch: Array, focal: Array, ranges: Array
) -> dict[str, Array]:
    """The columns of `Views` that say what the images cover of the target's plane, at ranges of which the last counts
    as the farthest. Ports of many images are columns of `shape`."""
    if scene.slope:
        return oblique_footprints(shape, along, across, pitch / focal, ranges)
    wide_along, wide_across = (2.0 * edge_m(scene, shape, side, ranges) for side in (along, across))
    pixel_along, pixel_across = smallest_pixels_m(scene, shape, along, across, pitch, focal, ranges)
    return dict(
        footprint_along_m=wide_along, footprint_across_m=wide_across, area_m2=wide_along * wide_across,
        gsd_m=largest_pixel_m(scene, shape, pitch, focal, ranges), pixel_along_m=pixel_along,
        pixel_across_m=pixel_across, far_m=0.5 * np.hypot(wide_along[:, -1], wide_across[:, -1]),
        farthest=np.ones(len(along)),
    )  # fmt: skip


def oblique_footprints(
    shape: PortShape, along: Array, across: Array, pixel: Array, ranges: Array
) -> dict[str, Array]:
    """The same of a tilted plane: a trapezoid, near edge below.

    Its depth is that of the middle column, its width that of the near edge: so wide a strip all images of a line
    cover, each with the whole depth. The largest pixel is looked for over the image, as is what the motion moves most.
    pixel : (n,) its tangent; ranges : (k,) along the axis, or (n, k)
    """
    near, far = -along[:, None], along[:, None]
    side, middle, spread = across[:, None], np.zeros((len(along), 1)), shape.over(1)

    def point(u: Array, v: Array) -> tuple[Array, Array, Array]:
        x_m, y_m, _ = floor_point(u, v, shape=spread, range_m=ranges)
        return x_m, y_m, ranges + shape.slope * x_m

    deep = np.hypot(1.0, shape.slope) * (point(far, middle)[0] - point(near, middle)[0])
    wide = 2.0 * point(near, side)[1]
    corner = point(far, side)
    u, v = (part.ravel() for part in np.meshgrid(np.linspace(-1.0, 1.0, PLACES_ALONG), np.linspace(0.0, 1.0, 3)))
    if shape.is_dome:  # pixels grow towards the far corner, throughout
        u, v = np.array([-1.0, 1.0]), np.ones(2)
    steps = floor_steps(
        (along[:, None] * u)[:, None], (across[:, None] * v)[:, None], shape=shape.over(2), range_m=ranges[..., None]
    )
    moved = [least.min(axis=2) * pixel[:, None] for least in steps.least_moved_m]
    with np.errstate(divide="ignore"):
        fall = 1.0 - shape.slope * along * ray_spread(np.square(along), shape)[1]
        farthest = np.where(fall > 0.0, 1.0 / np.maximum(fall, 0.0), np.inf)
    return dict(
        footprint_along_m=deep, footprint_across_m=wide, area_m2=deep * (0.5 * wide + corner[1]),
        gsd_m=steps.longest_m.max(axis=2) * pixel[:, None], pixel_along_m=moved[0], pixel_across_m=moved[1],
        far_m=np.sqrt(sum(np.square(part[:, -1]) for part in corner)), farthest=farthest,
    )  # fmt: skip


def tilted_places(scene: SceneOptics, shape: PortShape, tan_along: Array, tan_across: Array, share: float) -> Array:
    """`image_places` at a share of the corner's field; of a tilted plane near and far, after each other, (n, 4, 3).

        a ray that meets the plane at z = (d + s A u) / (1 - s u W) has p1 / (z + p2) = p1' / (d + p2'),
        p1' = p1 (1 - s u W),   p2' = s A u + p2 (1 - s u W)
    """
    tan_air = np.hypot(tan_along, tan_across) * share
    places = image_places(scene, shape, tan_air)
    if not scene.slope:
        return places
    start_m, per_m = ray_spread(np.square(tan_air), shape)
    both = []
    for u in (-share * tan_along, share * tan_along):
        fall = descent(u, per_m, shape.slope)[:, None]
        own = np.array(places)
        own[..., 1] *= fall
        own[..., 2] = (shape.slope * start_m * u)[:, None] + own[..., 2] * fall
        both.append(own)
    return np.concatenate(both, axis=1)


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
                defocus.flat_field_dioptres_per_m(range_m, tan_air=tan_air, **shape.plates)
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
    """Near, nominal and far altitude, as ranges along the optical axis, (3,); of rows with their own (n, 3)."""
    return scene.range_m[[0, scene.nominal, -1]].T


def heights_m(scene: SceneOptics) -> Array:
    """The same as heights over the target's plane."""
    return scene.altitude_m[[0, scene.nominal, -1]]


def port_transmission(shape: PortShape) -> float:
    """T_port at normal incidence, both faces."""
    return float(port.normal_port_transmittance(n_water=shape.n_water, n_glass=shape.n_glass))


def edge_m(scene: SceneOptics, shape: PortShape, tangent: Array, ranges: Array) -> Array:
    """Distance on the floor from the axis to the middle of an image edge, (n, 3)."""
    tangent, shape = tangent[:, None], shape.over(1)
    if scene.paper:
        return tangent * ranges
    if shape.is_dome:
        return np.asarray(
            port.dome_floor_distance_m(tangent, outer_radius_m=shape.outer_radius_m, range_m=ranges)
        )
    return np.asarray(port.flat_floor_distance_m(tangent, **shape.plates, range_m=ranges))


def largest_pixel_m(scene: SceneOptics, shape: PortShape, pitch: Array, focal: Array, ranges: Array) -> Array:
    """Largest ground sample of the image, (n, 3): uniform behind a dome, at the centre behind a flat port."""
    scale, shape = (pitch / focal)[:, None], shape.over(1)
    if scene.paper:
        return scale * ranges
    if shape.is_dome:
        return scale * (ranges + shape.outer_radius_m)
    return np.asarray(
        operation.flat_largest_pixel_m(
            ranges, pixel_pitch_m=pitch[:, None], focal_length_m=focal[:, None], **shape.plates
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
        pixel_pitch_m=pitch[:, None], focal_length_m=focal[:, None], **shape.over(1).plates, range_m=ranges
    )
    one = operation.flat_smallest_pixel_along_m(along[:, None], tan_across_edge=across[:, None], **common)
    other = operation.flat_smallest_pixel_along_m(across[:, None], tan_across_edge=along[:, None], **common)
    return np.asarray(one), np.asarray(other)


def widest_corner(seen: Sequence[Views]) -> Array:
    """Tangent of the angle between the axis and the widest of these views' corners, inside the port, (n,)."""
    return np.max([np.hypot(view.tan_along, view.tan_across) for view in seen], axis=0)


def focus_map(scene: SceneOptics, shape: PortShape) -> port.FocusMap:
    """The port's map between distance in water and dioptre at the lens."""
    if not shape.is_dome:
        if scene.paper:
            return port.identity_focus_map()
        return port.flat_focus_map(**shape.plates)
    build = port.paper_dome_focus_map if scene.paper else port.dome_focus_map
    return build(
        outer_radius_m=shape.outer_radius_m,
        thickness_m=shape.thickness_m,
        n_glass=shape.n_glass,
        n_water=shape.n_water,
    )
