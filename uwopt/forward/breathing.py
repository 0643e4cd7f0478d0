"""What a lens that is focused near leaves of its field of view.

A lens that moves as a whole stands f (1 + m) before the sensor, m being its magnification, and sees 1 / (1 + m) of
its field; one that focuses inside may keep it, and makers seldom tell which. Each figure takes the kind that is
worse: swath, overlap, rate, blur and skew are those of a lens that moves, ground sample and light those of one that
keeps its field. Physics page, section 5.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import groups_alike
from uwopt.forward.focus import working_factor
from uwopt.forward.scene import SceneOptics
from uwopt.forward.views import Views, altitudes_m, edge_m, footprints, own_ranges, pair_of
from uwopt.model import stereo
from uwopt.model.imaging import PortShape

MOVED = ("footprint_along_m", "footprint_across_m", "pixel_along_m", "pixel_across_m")


def at_focus(
    scene: SceneOptics, shape: PortShape, view: Views, pixel_pitch_m: Array, dioptre_per_m: Array
) -> Views:
    """Views with what their images surely cover at a focus: swath, advance, and the smallest pixels.

    shape : of their port
    pixel_pitch_m : (n,) [m]; dioptre_per_m : (n,), or one for all, at the lens [1/m]

    Physics `paper` focuses without moving. Where a focus leaves no image the field is kept: other rules refuse it.
    """
    if scene.paper or len(view.tan_along) == 0:
        return view
    longer = extension(scene, view, dioptre_per_m)
    columns = (view.tan_along, view.tan_across, pixel_pitch_m, view.focal_length_m, longer)
    ranges_m = altitudes_m(scene)
    first, back = groups_alike(*columns, *own_ranges(ranges_m))
    along, across, pitch_m, focal_m, factor = (column[first] for column in columns)
    ranges_m = ranges_m[first] if ranges_m.ndim > 1 else ranges_m
    moved = covered(scene, shape, along, across, pitch_m, focal_m, factor, ranges_m)
    pair = pair_of(scene)
    if pair is not None:
        side = (across / factor)[:, None]
        common = stereo.common_width_m(side, shape=shape.over(1), range_m=ranges_m, pair=pair)
    moved["common_across_m"] = moved["footprint_across_m"] if pair is None else common
    kept = {name: column[back] for name, column in moved.items()}
    return replace(
        view, covered_along_m=kept["footprint_along_m"], covered_across_m=kept["footprint_across_m"],
        pixel_along_m=np.minimum(kept["pixel_along_m"], view.pixel_along_m),
        pixel_across_m=np.minimum(kept["pixel_across_m"], view.pixel_across_m),
        common_across_m=np.minimum(kept["common_across_m"], view.common_across_m),
    )  # fmt: skip


def extension(scene: SceneOptics, view: Views, dioptre_per_m: Array) -> Array:
    """1 + m at a focus, (n,): how much longer than its focal length a lens that moves stands before the sensor."""
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = working_factor(scene, view.focal_length_m, np.broadcast_to(dioptre_per_m, view.focal_length_m.shape))
    return surely(factor)


def surely(factor: Array) -> Array:
    """The factor by which a lens is surely extended: 1 where a focus leaves no image."""
    return np.where(np.isfinite(factor) & (factor > 1.0), factor, 1.0)


def covered_sides(
    scene: SceneOptics, shape: PortShape, along: Array, across: Array, factor: Array, at_infinity: dict[str, Array]
) -> tuple[Array, Array]:
    """The most that lenses can surely cover that stand at least `factor` times as far off, along and across, (n, 3).

    at_infinity : the footprints of such lenses at infinity, by name: the answer where a tilted plane or no focus
    leaves nothing better
    """
    if scene.paper or scene.slope:
        return at_infinity["footprint_along_m"], at_infinity["footprint_across_m"]
    sure, ranges_m = surely(factor), altitudes_m(scene)
    one, other = (2.0 * edge_m(scene, shape, side / sure, ranges_m) for side in (along, across))
    return one, other


def covered(
    scene: SceneOptics, shape: PortShape, along: Array, across: Array, pitch: Array, focal: Array, factor: Array,
    ranges_m: Array,
) -> dict[str, Array]:  # fmt: skip
    """Footprints and smallest pixels of lenses that stand `factor` times as far off, (n, len(ranges_m)), by name.

    along, across : (n,) tangents of the half angles of view at infinity
    """
    seen = footprints(scene, shape, along / factor, across / factor, pitch, focal * factor, ranges_m)
    return {name: seen[name] for name in MOVED}
