"""Backscatter as the mean over an image: a ladder of rules, each lamp where it is seen."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.model import beam as beams
from uwopt.model import port
from uwopt.model.bisection import bisected
from uwopt.model.fineness import scaled
from uwopt.model.image_mean import along_symmetric, gauss
from uwopt.model.imaging import Lamps, PortShape
from uwopt.model.veil.geometry import Scatterer, _lamp_view, camera_rays
from uwopt.model.veil.ray import (
    N_PROBES,
    NODES_AT_ONCE,
    TABLE_NODES_IN_MEAN,
    WIDE_EXPONENT,
    _log_gain,
    _log_sum,
)

FIELD_ORDERS = (4, 6, 8, 12, 18, 26, 38, 56, 80, 112, 160, 224)
BOX_POINTS = 25  # a side of the grid that finds the lit part of an image
BISECTIONS = 12  # of one cell of that grid: what is missed counts with the square
MOST_RUNG = 4  # of the ladder, to begin at
SPOT_ORDER = 18  # a beam that ends sharply may leave a lit spot that lower orders miss
SMOOTH_CHANGE = 5e-4  # of the mean between two orders: a smooth integrand's error is then under 5e-5
EDGE_CHANGE = 1.2e-4  # where a beam's edge crosses the image, errors fall with the square of the order only


class _Images(NamedTuple):
    """Images in water, (n,) each: tangents in air of their half angles of view, their ranges, what scatters there."""

    along: Array
    across: Array
    range_m: Array
    scatterers: tuple[Scatterer, ...]

    def take(self, rows: Any) -> _Images:
        """Some of them."""
        along, across, range_m = (column[rows] for column in self[:3])
        return _Images(along, across, range_m, tuple(one.take(rows) for one in self.scatterers))


def mean_backscatter(
    tan_along_half: Array, tan_across_half: Array, *, shape: PortShape, range_m: float | Array, lamps: Lamps,
    beam: beams.Beam, scatterers: tuple[Scatterer, ...], order: int | None = None, fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Mean over the image rectangle of `backscatter_gain`, for many images at once.

    Parameters
    ----------
    tan_along_half, tan_across_half : (n,) tangents in air of the half angles of view
    range_m : of all images, or of each, (n,)
    scatterers : likewise, see `geometry.of_each`
    order : nodes a side of the image; None raises it for each image until the mean stands still
    fineness : factor on all nodes; the change that counts as standing still falls with its square

    Returns
    -------
    (n,) [weight integral / (m sr)]

    Notes
    -----
    Lamps that mirror each other across track give the same mean: one side, with both shares, will do.
    Half of the image stands for the whole along each direction in which no lamp stands or leans.
    For a beam that ends sharply the nodes are laid within the part of the image that it lights.
    Default: relative error 1e-4 or less, judged by the change between orders; the last order is 224.

    References
    ----------
    Jaffe (1990), IEEE J. Oceanic Eng. 15(2), 101-111; physics page, section 8.
    """
    return np.exp(
        log_mean_backscatter(
            tan_along_half,
            tan_across_half,
            shape=shape,
            range_m=range_m,
            lamps=lamps,
            beam=beam,
            scatterers=scatterers,
            order=order,
            fineness=fineness,
        )
    )


def log_mean_backscatter(
    tan_along_half: Array, tan_across_half: Array, *, shape: PortShape, range_m: float | Array, lamps: Lamps,
    beam: beams.Beam, scatterers: tuple[Scatterer, ...], order: int | None = None, fineness: float = 1.0,
) -> Array:  # fmt: skip
    """ln of `mean_backscatter` (same arguments), (n,) [ln of weight integral / (m sr)].

    -inf where no lamp lights the water before the image; finite where e^x underflows.
    """
    along, across = np.atleast_1d(np.asarray(tan_along_half, float), np.asarray(tan_across_half, float))
    images = _Images(along, across, np.broadcast_to(np.asarray(range_m, float), along.shape), scatterers)
    common: dict[str, Any] = dict(
        shape=shape, lamps=lamps, beam=beam, ray_nodes=None, table_nodes=scaled(TABLE_NODES_IN_MEAN, fineness),
        fineness=fineness,
    )  # fmt: skip
    if len(parts := beams.parts(beam)) > 1:
        given: dict[str, Any] = dict(
            shape=shape, range_m=range_m, lamps=lamps, scatterers=scatterers, order=order, fineness=fineness
        )
        return np.asarray(
            np.logaddexp.reduce([log_mean_backscatter(along, across, beam=one, **given) for one in parts], axis=0)
        )
    if order:
        return _log_means((order,), images, _lit_boxes(images, **common), **common)[0]
    first = _first_rungs(images, shape, lamps, beam)
    mean = np.empty(len(along))
    for rung in np.unique(first):
        rows = np.nonzero(first == rung)[0]
        mean[rows] = _climbed(FIELD_ORDERS[rung:], images.take(rows), **common)
    return mean


def _climbed(orders: tuple[int, ...], images: _Images, **common: Any) -> Array:
    """ln of the mean over each image, by finer and finer rules until it stands still."""
    beam, fineness = common["beam"], common["fineness"]
    ladder = tuple(2 * scaled(n // 2, fineness) for n in orders)
    steep = _has_steep_flank(beam)
    allowed = (EDGE_CHANGE if steep else SMOOTH_CHANGE) / fineness**2
    together = 3 if steep or _front_plane_may_show(common["lamps"], beam) else 2
    boxes = _lit_boxes(images, **common)
    recent = _log_means(ladder[:together], images, boxes, **common)
    mean = recent[-1].copy()
    pending = np.nonzero(~_settled(recent, allowed, may_hide=steep))[0]
    recent = recent[:, pending]
    for n in ladder[together:]:
        if not pending.size:
            break
        finer = _log_means((n,), images.take(pending), boxes[:, :, pending], **common)
        recent = np.concatenate([recent[1:], finer])
        mean[pending] = finer[0]
        moving = ~_settled(recent, allowed, may_hide=steep and n < SPOT_ORDER)
        pending, recent = pending[moving], recent[:, moving]
    return mean


def _has_steep_flank(beam: beams.Beam) -> bool:
    """True where the mean over an image converges slowly: sharp edges and measured profiles."""
    return beams.has_sharp_edge(beam) or beam.kind == "tabulated"


def _front_plane_may_show(lamps: Lamps, beam: beams.Beam) -> bool:
    """True where a wide lobe is tilted or stands in front of the port: it ends in the image with a kink."""
    wide = beam.kind == "cosine-power" and (beam.exponent or 0.0) < WIDE_EXPONENT
    return wide and (any(z > 0.0 for z in lamps.z_m) or any(aim[2] < 0.999 for aim in lamps.aim))


def _first_rungs(images: _Images, shape: PortShape, lamps: Lamps, beam: beams.Beam) -> Array:
    """Where on the ladder of orders each image begins: one below what spot and place of the lamps ask for.

    Each image is asked alone, so that its mean is the same whatever stands beside it.
    """
    along, across, range_m = images[:3]
    depth_m = range_m + shape.outer_radius_m + shape.gap_m + shape.thickness_m
    height_m = np.maximum(range_m - max(lamps.z_m), 1e-3 * range_m)
    spot_m = np.tan(min(_half_power_angle_rad(beam), 1.5)) * height_m
    wanted = 2.7 * 1.18 * np.maximum(along, across) * depth_m / spot_m  # as in `image_mean.orders_needed`
    for x, y, z in zip(lamps.x_m, lamps.y_m, lamps.z_m, strict=True):
        if z > 0.0:  # in front of the port the veil is nearly singular beside the field of view
            half_x, half_y = (_half_width_m(t, z, shape) for t in (along, across))
            beside = np.hypot(np.maximum(abs(x) - half_x, 0.0), np.maximum(abs(y) - half_y, 0.0))
            beside = beside / np.maximum(half_x, half_y)
            # Gauss-Legendre falls like rho^(-2 n), rho the ellipse through the singularity
            wanted = np.maximum(wanted, 8.0 / np.arcsinh(np.maximum(beside, 0.05)))
    return np.clip(np.searchsorted(FIELD_ORDERS, wanted) - 1, 0, MOST_RUNG)


def _half_width_m(tangent: Array, ahead_m: float, shape: PortShape) -> Array:
    """Half width of the field of view at a distance before the port, for tangents in air of half angles."""
    if shape.is_dome:
        return tangent * (ahead_m + shape.outer_radius_m)
    in_water = port.water_tangent(tangent, n=shape.n_water)
    return np.asarray(tangent * (shape.gap_m + shape.thickness_m) + ahead_m * in_water)


@lru_cache(maxsize=256)
def _half_power_angle_rad(beam: beams.Beam) -> float:
    return beams.half_power_angle_rad(beam)


def _settled(recent: Array, allowed: float, *, may_hide: bool) -> Array:
    """Whether the means (rungs, n) of the last orders agree; an image dark throughout does, if nothing may
    hide between the nodes."""
    with np.errstate(invalid="ignore"):
        steady = np.all(np.abs(np.diff(recent, axis=0)) <= allowed, axis=0)
    return np.asarray(steady | (np.all(np.isneginf(recent), axis=0) & (not may_hide)))


def _log_means(orders: tuple[int, ...], images: _Images, boxes: Array, **common: Any) -> Array:
    """ln of the mean over each image by product rules: (orders, images), a few images at a time.

    The rules' nodes are evaluated together, which for few images costs little more than one of them.
    With boxes, each lamp has nodes of its own, all where it shines.
    """
    lamps = common["lamps"]
    if len(boxes):
        by_lamp = [
            _log_means_of_nodes(
                [_lit_rule(n, images, box, lamp, **common) for n in orders], images, **(common | dict(lamps=lamp)),
            )
            for lamp, box in zip(_each_lamp(lamps), boxes, strict=True)
        ]  # fmt: skip
        return np.asarray(np.logaddexp.reduce(by_lamp, axis=0))
    rules = [_image_rule(n, lamps, common["shape"]) for n in orders]
    return _log_means_of_nodes(rules, images, **common)


def _log_means_of_nodes(rules: list[tuple[Array, Array, Array]], images: _Images, **common: Any) -> Array:
    """ln of the means by rules (nodes u, v and weights), each of shape (k,) or (images, k)."""
    ends = np.cumsum([0, *(weight.shape[-1] for _, _, weight in rules)])
    u, v, weight = (np.concatenate(parts, axis=-1) for parts in zip(*rules, strict=True))
    count = len(images.along)
    u, v, weight = (np.broadcast_to(part, (count, ends[-1])) for part in (u, v, weight))
    mean = np.empty((len(rules), count))
    step = max(1, NODES_AT_ONCE // (int(ends[-1]) * N_PROBES))
    for start in range(0, count, step):
        rows = slice(start, start + step)
        some = images.take(rows)
        log_gain = _log_gain(
            some.along[:, None] * u[rows], some.across[:, None] * v[rows], range_m=some.range_m[:, None],
            scatterers=some.scatterers, **common,
        )  # fmt: skip
        with np.errstate(divide="ignore"):
            log_gain = log_gain + np.log(weight[rows])
        for i in range(len(rules)):
            mean[i, rows] = _log_sum(log_gain[:, ends[i] : ends[i + 1]])
    return mean


def _each_lamp(lamps: Lamps) -> list[Lamps]:
    return [
        Lamps((x,), (y,), (z,), (aim,), (share,))
        for x, y, z, aim, share in zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, lamps.share, strict=True)
    ]


def _is_lit(u: Array, v: Array, images: _Images, lamp: Lamps, **common: Any) -> Array:
    """Whether field points (images, ...) see water that the lamp lights."""
    along, across, range_m = (column.reshape(-1, *([1] * (u.ndim - 1))) for column in images[:3])
    rays = camera_rays(along * u, across * v, shape=common["shape"], range_m=range_m)
    view = _lamp_view(rays, lamps=lamp, index=0, beam=common["beam"])
    return np.asarray(view.high > view.low)


def _lit_boxes(images: _Images, **common: Any) -> Array:
    """The part of each image that each lamp lights, for beams that end sharply: (lamps, 4, images).

    First and last u with lit points, and the v between which they lie, in half widths of the image. Empty
    where nothing is to be cut: smooth beams, or images that are lit all over.
    """
    if not beams.has_sharp_edge(common["beam"]):
        return np.empty((0, 4, len(images.along)))
    boxes = [_lit_box(images, lamp, **common) for lamp in _each_lamp(common["lamps"])]
    whole = all(np.all(found) for _, found in boxes)
    return np.empty((0, 4, len(images.along))) if whole else np.array([box for box, _ in boxes])


def _lit_box(images: _Images, lamp: Lamps, **common: Any) -> tuple[Array, Array]:
    """(4, images): u from, u to, v from, v to; and whether all of the grid was lit."""
    box = np.repeat([[-1.0], [1.0], [-1.0], [1.0]], len(images.along), axis=1)
    steps = np.linspace(0.0, 1.0, BOX_POINTS)
    lit_all = np.zeros(len(images.along), dtype=bool)
    for turn in range(2):
        u = (box[0] + np.multiply.outer(steps, box[1] - box[0])).T[:, :, None]
        v = (box[2] + np.multiply.outer(steps, box[3] - box[2])).T[:, None, :]
        lit = _is_lit(u, v, images, lamp, **common)
        if turn == 0:
            lit_all = np.asarray(lit.all(axis=(1, 2)))
        for axis, (low, high) in ((2, (0, 1)), (1, (2, 3))):
            some = np.asarray(lit.any(axis=axis))
            first = np.argmax(some, axis=-1)
            last = BOX_POINTS - 1 - np.argmax(some[:, ::-1], axis=-1)
            span, start = box[high] - box[low], box[low].copy()
            box[low] = start + span * steps[np.maximum(first - 1, 0)]
            box[high] = start + span * steps[np.minimum(last + 1, BOX_POINTS - 1)]
    return box, lit_all


def _lit_rule(n: int, images: _Images, box: Array, lamp: Lamps, **common: Any) -> tuple[Array, Array, Array]:
    """Nodes u, v and weights (images, n * n): Gauss in u over the box, and in v over the lit part of each u.

    Behind a dome the lit part of an image is convex (a convex beam seen from a point), so it is one
    interval of v; its ends are found by bisection.
    """
    nodes, weights = gauss(n)
    u = box[0][:, None] + (box[1] - box[0])[:, None] * (0.5 * (nodes + 1.0))
    steps = np.linspace(0.0, 1.0, BOX_POINTS)
    grid = (box[2] + np.multiply.outer(steps, box[3] - box[2])).T[:, None, :]
    lit = _is_lit(u[:, :, None], grid, images, lamp, **common)
    grid = np.broadcast_to(grid, lit.shape)
    first = np.argmax(lit, axis=-1)
    last = BOX_POINTS - 1 - np.argmax(lit[..., ::-1], axis=-1)
    dark_at = np.stack([np.maximum(first - 1, 0), np.minimum(last + 1, BOX_POINTS - 1)], axis=-1)
    inside, outside = (np.take_along_axis(grid, at, -1) for at in (np.stack([first, last], axis=-1), dark_at))
    both = np.repeat(u[:, :, None], 2, -1)
    inside, _ = bisected(lambda v: _is_lit(both, v, images, lamp, **common), inside, outside, steps=BISECTIONS)
    span = np.where(lit.any(axis=-1), inside[..., 1] - inside[..., 0], 0.0)
    v = inside[..., :1] + span[..., None] * (0.5 * (nodes + 1.0))
    weight = 0.25 * (box[1] - box[0])[:, None, None] * (weights[:, None] * span[..., None]) * weights
    u = np.broadcast_to(u[:, :, None], v.shape)
    flat = (len(u), -1)
    return u.reshape(flat), v.reshape(flat), weight.reshape(flat)


def _image_rule(n: int, lamps: Lamps, shape: PortShape) -> tuple[Array, Array, Array]:
    """Gauss-Legendre over the image [-1, 1]^2, or over its half where nothing breaks the symmetry."""
    no_x = along_symmetric(lamps, shape)
    no_y = all(y == 0.0 for y in lamps.y_m) and all(aim[1] == 0.0 for aim in lamps.aim)
    return _product_rule(n, no_x, no_y)


@cache
def _product_rule(n: int, half_along: bool, half_across: bool) -> tuple[Array, Array, Array]:
    (u, u_weight), (v, v_weight) = (_half_rule(n) if half else gauss(n) for half in (half_along, half_across))
    u, v = (part.ravel() for part in np.meshgrid(u, v, indexing="ij"))
    return u, v, np.multiply.outer(u_weight, v_weight).ravel()


def _half_rule(n: int) -> tuple[Array, Array]:
    """Gauss-Legendre on 0..1, for one half of a symmetric image."""
    nodes, weights = gauss(max(2, n // 2))
    return 0.5 * (nodes + 1.0), weights
