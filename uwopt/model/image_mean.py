"""Means over the image: rules of quadrature for smooth lobes, measured profiles and beams that end sharply."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.model import beam as beams
from uwopt.model.imaging import Lamps, PortShape, flat_slope_m, levelled, local_gain
from uwopt.model.path_table import PathTable

SMOOTH_ORDER = 14  # Gauss-Legendre nodes a side for lobes given by a formula
TABLE_ORDER = 48  # for measured profiles, whose knots are half a degree apart
EDGE_CELLS = 96  # midpoint cells a side, with the edge's share of each cell, for beams that end sharply
SPOT_CELLS = 128  # the same where the cells lie on the spot alone
CELLS_PER_SPOT = 64.0  # a side, for each half axis of a spot: where tilted lamps make it long
WIDEST_SPOT_RAD = np.deg2rad(85.0)  # a beam that reaches further from the vertical lights all of the floor
MOST_ORDER = 768
MAX_NODES_AT_ONCE = 400_000
PIXELS_A_SIDE = 17  # of the grid on which the worst pixel is looked for
FRAME_PLACES, FRAME_STEP = 377, 233  # Fibonacci numbers: a lattice whose points share out the image's area evenly
FEW_FRAME_PLACES, FEW_FRAME_STEP = 89, 55  # likewise, where shares of it are asked for roughly
FRAME_SHARE = 0.95  # of the image: what is reached there counts as reached over the frame
FRAME_MAY_MISS = int(FRAME_PLACES * (1.0 - FRAME_SHARE))
FEW_FRAME_MAY_MISS = int(FEW_FRAME_PLACES * (1.0 - FRAME_SHARE))


def field_means(
    tan_along: Array, tan_across: Array, *, shape: PortShape, ranges_m: Array, lobes: Sequence[beams.Beam],
    **common: Any,
) -> Array:  # fmt: skip
    """`field_mean` of n images at each of m ranges, (n, m) [1/m^2]; one smooth beam takes all of them at once.

    lobes : one beam as it is at each range
    """
    beam, count = lobes[0], len(ranges_m)
    if len(beams.parts(beam)) > 1 or beams.has_sharp_edge(beam):
        each = [
            field_mean(tan_along, tan_across, shape=shape, range_m=float(r), beam=one, **common)
            for r, one in zip(ranges_m, lobes, strict=True)
        ]
        return np.stack(each, axis=1)
    if any(other is not beam for other in lobes):
        beam = beams.numbered(tuple(lobes))
    image, place = (part.ravel() for part in np.indices((len(tan_along), count)))
    return field_mean(
        tan_along[image], tan_across[image], shape=shape.take(image), range_m=ranges_m[place], beam=beam, lobe=place,
        **common,
    ).reshape(len(tan_along), count)  # fmt: skip


def field_mean(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float | Array, lamps: Lamps, beam: beams.Beam,
    table: PathTable, order: int | None = None, fineness: float = 1.0, lobe: Array | None = None,
) -> Array:  # fmt: skip
    """Mean over the image rectangle of `local_gain`, for many images at once [1/m^2].

    Parameters
    ----------
    tan_along, tan_across : (n,) tangents in air of the half angles of view along and across the motion
    shape : the port of all images, or the ports of each
    range_m : of all images, or of each, (n,), where the beam does not end sharply
    order : nodes a side of the image (smooth beams: Gauss-Legendre), or cells a side of each lamp's spot in it
        (sharp ones: midpoint, extrapolated)
    fineness : factor on the order that is chosen where none is given
    lobe : (n,), which of smooth beams side by side lights each image

    Notes
    -----
    Images are symmetric about the axis, so lamps that mirror each other give the same mean.
    When no lamp stands or leans along the motion over a plane square to the axis, half of the image stands for all.
    """
    if len(parts := beams.parts(beam)) > 1:
        common: dict[str, Any] = dict(
            shape=shape, range_m=range_m, lamps=lamps, table=table, order=order, fineness=fineness, lobe=lobe
        )
        return sum(
            (field_mean(tan_along, tan_across, beam=one, **common) for one in parts), start=np.zeros(len(tan_along))
        )
    if order:
        orders = np.full(len(tan_along), order)
    elif beams.has_sharp_edge(beam):
        orders = cells_needed(tan_along, tan_across, shape, float(range_m), lamps, beam, fineness)
    else:
        orders = orders_needed(tan_along, tan_across, shape, range_m, lamps, beam, fineness)
    mean = np.empty(len(tan_along))
    for n in np.unique(orders):
        rows = np.nonzero(orders == n)[0]
        mean[rows] = mean_of_order(
            int(n),
            tan_along[rows],
            tan_across[rows],
            shape=shape.take(rows),
            range_m=range_m[rows] if isinstance(range_m, np.ndarray) else range_m,
            lamps=lamps,
            beam=beam,
            table=table,
            lobe=None if lobe is None else lobe[rows],
        )
    return mean


def orders_needed(
    tan_along: Array, tan_across: Array, shape: PortShape, range_m: float | Array, lamps: Lamps, beam: beams.Beam,
    fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Nodes or cells a side for each image: more where a lamp's spot is small in it.

    Gauss-Legendre resolves a spot of standard deviation s, in half widths of the image, with about
    2.7 / s nodes to 1e-6; cells on the whole image follow a sharp edge of radius a to some 1e-4 with 32 / a.
    """
    half_m = (range_m + shape.outer_radius_m + shape.gap_m + shape.thickness_m) * np.maximum(
        tan_along, tan_across
    )
    height = range_m - max(lamps.z_m)
    spot_m = np.tan(beams.half_power_angle_rad(beam)) * height
    if beams.has_sharp_edge(beam):
        least, wanted = EDGE_CELLS, 32.0 * half_m / spot_m
    else:
        least = TABLE_ORDER if beam.kind == "tabulated" else SMOOTH_ORDER
        wanted = 2.7 * 1.18 * half_m / spot_m
    steps = np.ceil(np.log2(np.maximum(wanted / least, 1.0)) * 2.0)
    orders = np.minimum(2 * np.round(0.5 * least * 2.0 ** (0.5 * steps)), MOST_ORDER)
    return np.maximum(2 * np.round(0.5 * fineness * orders), 2).astype(int)


def cells_needed(
    tan_along: Array, tan_across: Array, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Cells a side of each lamp's spot in an image, for beams that end sharply: (n,), more for long spots.

    128 follow an edge to 2e-5 of the mean or better as a rule, whatever part of the image the spot takes.
    """
    wanted = np.full(len(tan_along), float(SPOT_CELLS))
    for lamp in each_lamp(lamps):
        box = spot_box(tan_along, tan_across, shape=shape, range_m=range_m, lamps=lamp, beam=beam)
        scale_m = range_m + shape.outer_radius_m + shape.gap_m + shape.thickness_m
        long_m = 0.5 * scale_m * np.maximum((box[1] - box[0]) * tan_along, (box[3] - box[2]) * tan_across)
        spot_m = np.tan(beams.edge_half_angle_rad(beam)) * (range_m - lamp.z_m[0])
        wanted = np.maximum(wanted, CELLS_PER_SPOT * long_m / spot_m)
    steps = np.ceil(np.log2(wanted / SPOT_CELLS) * 2.0)
    orders = np.minimum(SPOT_CELLS * 2.0 ** (0.5 * steps), MOST_ORDER)
    return np.maximum(4 * np.round(0.25 * fineness * orders), 4).astype(int)


def each_lamp(lamps: Lamps) -> list[Lamps]:
    """Lamps one by one, each with its share."""
    rows = zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, lamps.share, strict=True)
    return [Lamps((x,), (y,), (z,), (aim,), (share,)) for x, y, z, aim, share in rows]


def spot_box(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam
) -> Array:
    """The part of each image that holds one lamp's spot: (4, n) = u from, to, v from, to, in half widths.

    On the floor the edge of a beam is an ellipse: half axes a = h (tan(t + b) - tan(t - b)) / 2 along the tilt t
    and a sqrt(1 - sin^2(t) / cos^2(b)) across it. Empty (to = from) where the spot lies outside.
    """
    over, port_m = levelled(lamps, shape.slope, range_m)
    edge, aim = beams.edge_half_angle_rad(beam), over.aim[0]
    tilt = float(np.arctan2(np.hypot(aim[0], aim[1]), aim[2]))
    box = np.repeat([[-1.0], [1.0], [-1.0], [1.0]], len(tan_along), axis=1)
    if tilt + edge >= WIDEST_SPOT_RAD:
        return box
    height_m = port_m - over.z_m[0]
    far_m, near_m = height_m * np.tan(tilt + edge), height_m * np.tan(tilt - edge)
    long_m, centre_m = 0.5 * (far_m - near_m), 0.5 * (far_m + near_m)
    short_m = long_m * np.sqrt(max(1.0 - (np.sin(tilt) / np.cos(edge)) ** 2, 0.0))
    across_tilt = max(float(np.hypot(aim[0], aim[1])), 1e-300)
    lean = (aim[0] / across_tilt, aim[1] / across_tilt) if tilt > 0.0 else (1.0, 0.0)
    reach_m = [float(np.hypot(long_m * lean[axis], short_m * lean[1 - axis])) for axis in (0, 1)]
    middle_m = [foot_m + centre_m * lean[axis] for axis, foot_m in enumerate((over.x_m[0], over.y_m[0]))]
    ends_m = [(middle - reach, middle + reach) for middle, reach in zip(middle_m, reach_m, strict=True)]
    corner, secant = np.hypot(tan_along, tan_across), np.hypot(1.0, shape.slope)
    sin, cos = shape.slope / secant, 1.0 / secant
    scales_m = [spot_scales_m(corner, shape, range_m + sin * along_m) for along_m in ends_m[0]]
    first, last = (
        [cos * end / (s * tan_along) for s in scales] for end, scales in zip(ends_m[0], scales_m, strict=True)
    )
    box[0], box[1] = np.clip(np.min(first, axis=0), -1.0, 1.0), np.clip(np.max(last, axis=0), -1.0, 1.0)
    left, right = ([end / (s * tan_across) for s in (*scales_m[0], *scales_m[1])] for end in ends_m[1])
    box[2], box[3] = np.clip(np.min(left, axis=0), -1.0, 1.0), np.clip(np.max(right, axis=0), -1.0, 1.0)
    return box


def spot_scales_m(corner: Array, shape: PortShape, range_m: float) -> list[Array]:
    """Least and most distance from the axis over the tangent in air, of image points so far along the axis [m]."""
    if shape.is_dome:
        return [np.broadcast_to(np.maximum(range_m + shape.outer_radius_m, 1e-9), corner.shape)]
    ahead_m = max(range_m, 1e-9)  # a spot may begin behind the port, where no ray goes
    return [flat_slope_m(t, shape=shape, range_m=ahead_m) for t in (0.0 * corner, corner)]


def edge_mean(
    n: int, tan_along: Array, tan_across: Array, *, shape: PortShape, lamps: Lamps, **common: Any
) -> Array:
    """`field_mean` with n cells a side of each lamp's spot: midpoint rule, extrapolated from n and n/2 [1/m^2]."""
    mean = np.zeros(len(tan_along))
    for lamp in each_lamp(lamps):
        box = spot_box(
            tan_along, tan_across, shape=shape, lamps=lamp, range_m=common["range_m"], beam=common["beam"]
        )
        along_cells = 2 if along_symmetric(lamp, shape) else 1  # half of the image stands for the whole
        if along_cells == 2:
            box[0] = 0.0
        area = along_cells * 0.25 * np.maximum(box[1] - box[0], 0.0) * np.maximum(box[3] - box[2], 0.0)
        rows = np.nonzero(area > 0.0)[0]
        fine, half = (
            box_mean(
                (max(k // along_cells, 2), max(k, 2)),
                tan_along[rows],
                tan_across[rows],
                box[:, rows],
                shape=shape.take(rows),
                lamps=lamp,
                **common,
            )
            for k in (n, n // 2)
        )
        # the midpoint rule's error is quadratic in the cell
        mean[rows] += area[rows] * np.maximum((4.0 * fine - half) / 3.0, 0.0)
    return mean


def box_mean(
    count: tuple[int, int], tan_along: Array, tan_across: Array, box: Array, *, shape: PortShape, **common: Any
) -> Array:
    """Mean of `local_gain` over a part of each image, (4, n) as `spot_box` gives it, by even cells [1/m^2]."""
    (u, _), (v, _) = cells(count[0]), cells(count[1])
    mean = np.empty(len(tan_along))
    step = max(1, MAX_NODES_AT_ONCE // (count[0] * count[1]))
    for start in range(0, len(tan_along), step):
        rows = slice(start, start + step)
        low, high, left, right = (side[rows, None] for side in box)
        along = tan_along[rows, None] * (0.5 * (low + high) + 0.5 * (high - low) * u)
        across = tan_across[rows, None] * (0.5 * (left + right) + 0.5 * (right - left) * v)
        gain = local_gain(
            *np.broadcast_arrays(along[:, :, None], across[:, None, :]), edge_share=True,
            shape=shape.take(rows).over(2), **common,
        )  # fmt: skip
        mean[rows] = gain.mean(axis=(1, 2))
    return mean


def mean_of_order(
    n: int, tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float | Array, lamps: Lamps,
    beam: beams.Beam, table: PathTable, lobe: Array | None = None,
) -> Array:  # fmt: skip
    """`field_mean` with n nodes or cells a side."""
    common: dict[str, Any] = dict(shape=shape, lamps=lamps, beam=beam, table=table)
    if beams.has_sharp_edge(beam):
        return edge_mean(n, tan_along, tan_across, range_m=range_m, **common)
    along_rule = gauss(n)
    if along_symmetric(lamps, shape):
        nodes, weights = gauss(max(4, n // 2))
        along_rule = (0.5 * (nodes + 1.0), weights)
    each = np.broadcast_to(np.asarray(range_m, float), tan_along.shape)
    which = np.zeros(tan_along.shape, int) if lobe is None else lobe
    return rule_mean(tan_along, tan_across, along_rule, gauss(n), range_m=each, lobe=which, **common)


def rule_mean(
    tan_along: Array, tan_across: Array, along_rule: tuple[Array, Array], across_rule: tuple[Array, Array], *,
    shape: PortShape, range_m: Array, lobe: Array, **common: Any,
) -> Array:  # fmt: skip
    """Mean of `local_gain` over images, each at its range under its lobe, by a product rule, a few at a time."""
    along_nodes, along_weights = along_rule
    across_nodes, across_weights = across_rule
    mean = np.empty(len(tan_along))
    step = max(1, MAX_NODES_AT_ONCE // (len(along_nodes) * len(across_nodes)))
    for start in range(0, len(tan_along), step):
        rows = slice(start, start + step)
        along, across = np.broadcast_arrays(
            tan_along[rows, None, None] * along_nodes[:, None], tan_across[rows, None, None] * across_nodes
        )
        gain = local_gain(
            along, across, shape=shape.take(rows).over(2), range_m=range_m[rows, None, None],
            lobe=lobe[rows, None, None], **common,
        )  # fmt: skip
        mean[rows] = (gain @ across_weights) @ along_weights
    return mean


def pixel_grid(
    tan_along: Array, tan_across: Array, *, n_points: int = PIXELS_A_SIDE, half: bool = False
) -> tuple[Array, Array]:
    """Field points on a regular grid over each image, corners and edges included: tangents [1], (n, n_pixels) each.

    `half` leaves out what mirrors along the motion: enough when no lamp stands or leans along it.
    """
    nodes = np.linspace(-1.0, 1.0, n_points)
    along_nodes = nodes[n_points // 2 :] if half else nodes
    along, across = (g.ravel() for g in np.meshgrid(along_nodes, nodes, indexing="ij"))
    return tan_along[:, None] * along, tan_across[:, None] * across


def frame_places(tan_along: Array, tan_across: Array, *, few: bool = False) -> tuple[Array, Array]:
    """Places that share out each image evenly: tangents [1], (n, FRAME_PLACES) each, or (n, FEW_FRAME_PLACES).

        u_i = 2 (i + 1/2) / F - 1,   v_i = 2 ((i F' mod F) + 1/2) / F - 1,   F, F' Fibonacci numbers

    No two stand in one row or column, so that an image's symmetry makes no groups of equal light: shares of the
    image are counted to 1/F of it.

    References
    ----------
    Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods, SIAM 1992: good lattice points.
    """
    count, step = (FEW_FRAME_PLACES, FEW_FRAME_STEP) if few else (FRAME_PLACES, FRAME_STEP)
    index = np.arange(count)
    along = (2.0 * index + 1.0) / count - 1.0
    across = (2.0 * (index * step % count) + 1.0) / count - 1.0
    return tan_along[:, None] * along, tan_across[:, None] * across


def reached_by_most(values: Array, may_miss: int) -> Array:
    """What all but k = `may_miss` values on the last axis reach: the (k + 1)-th of them in rising order."""
    if may_miss == 0:
        return np.asarray(values.min(axis=-1))
    return np.asarray(np.partition(values, may_miss, axis=-1)[..., may_miss])


def needed_by_most(values: Array, may_miss: int) -> Array:
    """What serves all but k = `may_miss` of those on the last axis, each of which needs its value."""
    return -reached_by_most(-values, may_miss)


def along_symmetric(lamps: Lamps, shape: PortShape) -> bool:
    """Whether nothing stands or leans along the motion, so that half of an image stands for the whole."""
    upright = all(x == 0.0 for x in lamps.x_m) and all(aim[0] == 0.0 for aim in lamps.aim)
    return upright and shape.slope == 0.0


@cache
def gauss(order: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes on [-1, 1] and weights of the mean."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    return nodes, weights / 2.0


def cells(count: int) -> tuple[Array, Array]:
    """Midpoints of equal cells on [-1, 1] and weights of the mean."""
    return (np.arange(count) + 0.5) * (2.0 / count) - 1.0, np.full(count, 1.0 / count)
