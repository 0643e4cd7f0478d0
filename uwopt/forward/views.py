"""What the camera sees: fields, footprints and pixels on the floor behind flat ports and domes.

An imager is camera x lens x port x orientation; its view is geometry alone, as arrays over many designs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.columns import Columns
from uwopt.forward.part_columns import Cameras, Lenses, Ports
from uwopt.forward.scene import PAPER_N_WATER, SceneOptics
from uwopt.model import defocus, operation, port
from uwopt.model.imaging import PortShape

Array = NDArray[Any]

PAPER_COC_PER_DIAGONAL = 1.0 / 1500.0
CORNERS_REACH = 1.5  # of tables, in distances of the image's corner from the axis: with a margin
CORNER_FIELD = 0.8  # of the half diagonal: where a corner's sharpness counts; 9 to 14 % of the image lie beyond
RMS_FIELD = 1.0 / np.sqrt(3.0)  # of the corner's tangent: the 2-point Gauss rule's node along and across


@dataclass(frozen=True)
class Views(Columns):
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
    corner_image: Array  # the same where a corner's sharpness counts
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


def table_reach_m(view: Views) -> float:
    """How far from the axis tables of water's loss must reach: past the widest image."""
    corner_m = 0.5 * np.hypot(view.footprint_along_m[:, 2], view.footprint_across_m[:, 2])
    return CORNERS_REACH * float(corner_m.max(initial=0.0))


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
        corner_image=image_places(scene, shape, np.hypot(along, across) * CORNER_FIELD),
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
