"""Light on the floor over one image's footprint: mean, least, and at a point."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.model import beam as beams
from uwopt.model import port
from uwopt.model.fineness import DEFAULT, Fineness, scaled
from uwopt.model.image_mean import (
    MAX_NODES_AT_ONCE,
    SMOOTH_ORDER,
    cells,
    cells_needed,
    each_lamp,
    gauss,
    orders_needed,
    spot_box,
)
from uwopt.model.imaging import (
    LEAST_STARTS,
    LEAST_ZOOMS,
    Lamps,
    PortShape,
    covered_share,
    descent,
    flat_slope_m,
    floor_point,
    lamp_light,
    levelled,
    ray_spread,
)

LAMP_RANGES = 257  # between which the loss of the lamp's leg is interpolated
FOOTPRINT_CELLS = 60  # a side of the grid on which the darkest place of the floor is looked for
FEW_PLACES = 7  # a side of those of its places that give a bound of the darkest
LEAST_GAIN_REL = 1e-6  # of the least light: a closer look that wins less is the last, where beams are smooth
UNIFORMITY_MARGIN = 1.001  # of a bound: one table of water's loss serves many footprints


def floor_illuminance_per_lm(
    x_m: Array, y_m: Array, *, lamps: Lamps, beam: beams.Beam, range_m: float, weight: Array, attenuation_per_m: Array,
    slope: float = 0.0, edge_share: bool = False, n_ranges: int = LAMP_RANGES, leg: LegLoss | None = None,
) -> Array:  # fmt: skip
    """Illuminance on the floor per lumen of all lamps [1/m^2], water's loss on the lamp leg included.

        E / Phi = sum over lamps of share * I/Phi * cos(theta_i) / r^2 * mean of exp(-K r) over V S

    Parameters
    ----------
    x_m, y_m : (...,) floor points off the optical axis; range_m, slope : of the floor z = range_m + slope x
    weight : (n,) V(lambda) times the lamp's spectrum and the steps; attenuation_per_m : (n,) K(lambda)
    edge_share : points are cells of a regular grid, and a sharp beam counts by the share it covers
    n_ranges : of `lamp_leg_loss`
    leg : the water's loss where it has been tabulated for all of these points; None: it is tabulated here

    References
    ----------
    Physics page, sections 1 and 2.
    """
    total = np.zeros(np.broadcast(x_m, y_m).shape)
    share_of_wave = weight / weight.sum()
    shape = beams.without_edge(beam) if edge_share else beam
    for index, share in enumerate(lamps.share):
        vacuum, range_lamp, cos_beam = lamp_light(
            x_m, y_m, lamps=lamps, index=index, beam=shape, range_m=range_m, slope=slope
        )
        if edge_share:
            vacuum = vacuum * covered_share(cos_beam, np.cos(beams.edge_half_angle_rad(beam)))
        if leg is None:
            lost = lamp_leg_loss(range_lamp, share_of_wave, attenuation_per_m, n_ranges)
        else:
            lost = leg.at(range_lamp)
        total += share * vacuum * lost
    return total


@dataclass(frozen=True)
class LegLoss:
    """Logarithm of the mean of exp(-K r) over a spectrum at even ranges [m]."""

    range_m: Array
    log_mean: Array

    @staticmethod
    def between(
        nearest_m: float, farthest_m: float, share_of_wave: Array, attenuation_per_m: Array, n_ranges: int
    ) -> LegLoss:
        """The table from the nearest to the farthest range.

        exp(-K (r_0 + (i b + j) h)) is a product of two, so that a matrix product of few exponentials makes all.
        """
        ranges, step_m = np.linspace(nearest_m, farthest_m, n_ranges, retstep=True)
        lit = share_of_wave > 0.0  # what the lamp does not emit may be attenuated far less
        least = attenuation_per_m[lit].min()
        beyond = attenuation_per_m[lit] - least
        block = math.isqrt(n_ranges) + 1
        with np.errstate(under="ignore"):
            coarse = np.exp(-ranges[::block, None] * beyond) * share_of_wave[lit]
            fine = np.exp(-step_m * np.arange(block)[:, None] * beyond)
            means = (coarse @ fine.T).reshape(-1)[:n_ranges]
            return LegLoss(ranges, np.log(means) - ranges * least)

    def at(self, range_m: Array) -> Array:
        """The loss at these ranges [m], its logarithm interpolated linearly."""
        with np.errstate(under="ignore"):
            return np.asarray(np.exp(np.interp(range_m, self.range_m, self.log_mean)))


def lamp_leg_loss(
    range_m: Array, share_of_wave: Array, attenuation_per_m: Array, n_ranges: int = LAMP_RANGES
) -> Array:
    """Mean of exp(-K r) over a spectrum, its logarithm interpolated linearly between even ranges.

    The second difference of the logarithm is at most the variance of K times the step squared / 8:
    under 1e-5 for a footprint a few metres deep.
    """
    ends_m = float(range_m.min()), float(range_m.max())
    return LegLoss.between(*ends_m, share_of_wave, attenuation_per_m, n_ranges).at(range_m)


def leg_loss_over(
    x_m: Array, y_m: Array, *, lamps: Lamps, range_m: float, weight: Array, attenuation_per_m: Array, n_ranges: int,
    slope: float = 0.0,
) -> LegLoss:  # fmt: skip
    """The loss between any of the lamps and any place among floor points that reach to the footprint's edge [m].

    No place is nearer than a lamp's height, and none farther than one of the edge: distance is convex.
    """
    over, port_m = levelled(lamps, slope, range_m)
    heights_m = [port_m - z for z in over.z_m]
    along_m = x_m * np.hypot(1.0, slope)
    far_m = [
        float(np.sqrt(np.square(along_m - x) + np.square(y_m - y) + height**2).max())
        for x, y, height in zip(over.x_m, over.y_m, heights_m, strict=True)
    ]
    return LegLoss.between(min(heights_m), max(far_m), weight / weight.sum(), attenuation_per_m, n_ranges)


def footprint_illuminance_per_lm(
    tan_along: float, tan_across: float, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    weight: Array, attenuation_per_m: Array, fineness: Fineness = DEFAULT,
) -> tuple[float, float]:  # fmt: skip
    """Mean and least illuminance per lumen over the image's footprint on the floor [1/m^2].

    The footprint is traced through the port: behind a flat one its corners are drawn in. The mean is
    over floor area, each field point weighted with |d(x, y) / d(u, v)| = (r/t) dr/dt of the radial map.
    """
    water: dict[str, Any] = dict(
        weight=weight, attenuation_per_m=attenuation_per_m, range_m=range_m, slope=shape.slope
    )
    cells_a_side = scaled(FOOTPRINT_CELLS, fineness.places)
    images = np.array([tan_along]), np.array([tan_across])

    grid = np.linspace(-1.0, 1.0, cells_a_side + 1)
    u, v = np.meshgrid(grid, grid, indexing="ij")
    x_m, y_m, _ = floor_point(tan_along * u, tan_across * v, shape=shape, range_m=range_m)
    leg = leg_loss_over(x_m, y_m, lamps=lamps, n_ranges=scaled(LAMP_RANGES, fineness.spectrum), **water)
    common: dict[str, Any] = dict(lamps=lamps, beam=beam, leg=leg, **water)

    def part(u: Array, v: Array, **of_light: Any) -> tuple[Array, Array]:
        along, across = np.meshgrid(tan_along * u, tan_across * v, indexing="ij")
        x_m, y_m, _ = floor_point(along, across, shape=shape, range_m=range_m)
        area = floor_area_ratio(along, across, shape=shape, range_m=range_m)
        return area, floor_illuminance_per_lm(x_m, y_m, **(common | of_light))

    def mean_of(one: beams.Beam) -> float:
        needed = cells_needed if beams.has_sharp_edge(one) else orders_needed
        order = int(needed(*images, shape, range_m, lamps, one, fineness.image)[0])
        return footprint_mean(
            partial(part, beam=one), order, *images, shape=shape, range_m=range_m, lamps=lamps, beam=one
        )

    mean = sum(map(mean_of, beams.parts(beam)))

    def there(u: Array, v: Array) -> Array:
        x_m, y_m, _ = floor_point(tan_along * u, tan_across * v, shape=shape, range_m=range_m)
        return floor_illuminance_per_lm(x_m, y_m, **common)

    gain_rel = LEAST_GAIN_REL if beams.is_smooth(beam) else -math.inf
    return mean, least_of(there, u.ravel(), v.ravel(), 2.0 / cells_a_side, gain_rel)


def most_uniformity(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    weight: Array, attenuation_per_m: Array, fineness: Fineness = DEFAULT,
) -> Array:  # fmt: skip
    """Upper bound of least over mean illuminance over the footprints of many images (n,): the least of few places.

        min E / mean E <= min of E at some places / mean E

    Parameters
    ----------
    tan_along, tan_across : (n,) tangents in air of the half angles of view; the rest as in
        `footprint_illuminance_per_lm`, whose mean is taken by the same rule, and whose places hold those tried here

    Notes
    -----
    Valid for all beams; 1 where a beam ends sharply, and so is not worth the cells of its mean.
    """
    most = np.ones(len(tan_along))
    if beams.has_sharp_edge(beam):
        return most
    water: dict[str, Any] = dict(
        weight=weight, attenuation_per_m=attenuation_per_m, range_m=range_m, slope=shape.slope
    )
    corners = [
        np.concatenate([sign * side for sign in signs])
        for side, signs in ((tan_along, (1, -1, 1, -1)), (tan_across, (1, -1, -1, 1)))
    ]
    edges = floor_point(*corners, shape=shape, range_m=range_m)[:2]
    leg = leg_loss_over(*edges, lamps=lamps, n_ranges=scaled(LAMP_RANGES, fineness.spectrum), **water)
    orders = orders_needed(tan_along, tan_across, shape, range_m, lamps, beam, fineness.image)
    side = np.linspace(-1.0, 1.0, FEW_PLACES if scaled(FOOTPRINT_CELLS, fineness.places) % (FEW_PLACES - 1) == 0 else 2)

    def there(rows: Array, nodes: Array) -> tuple[Array, Array]:
        along, across = np.broadcast_arrays(
            tan_along[rows, None, None] * nodes[:, None], tan_across[rows, None, None] * nodes
        )
        x_m, y_m, _ = floor_point(along, across, shape=shape, range_m=range_m)
        area = floor_area_ratio(along, across, shape=shape, range_m=range_m)
        return area, floor_illuminance_per_lm(x_m, y_m, lamps=lamps, beam=beam, leg=leg, **water)

    for order in np.unique(orders):
        nodes, weights = gauss(max(SMOOTH_ORDER, int(order)))
        rule = np.outer(weights, weights)
        mine = np.nonzero(orders == order)[0]
        for rows in np.array_split(mine, 1 + len(mine) * rule.size // MAX_NODES_AT_ONCE):
            area, light_there = there(rows, nodes)
            mean = (light_there * area * rule).sum(axis=(1, 2)) / (area * rule).sum(axis=(1, 2))
            with np.errstate(divide="ignore", invalid="ignore"):
                share = there(rows, side)[1].min(axis=(1, 2)) / mean
            most[rows] = np.where(mean > 0.0, share, 0.0)
    return np.minimum(most * UNIFORMITY_MARGIN, 1.0)


def footprint_mean(
    part: Callable[..., tuple[Array, Array]], order: int, tan_along: Array, tan_across: Array, *, shape: PortShape,
    range_m: float, lamps: Lamps, beam: beams.Beam,
) -> float:  # fmt: skip
    """Mean over the footprint of what `part` gives: floor area and illuminance at field points in half widths [1/m^2].

    Beams that end sharply: cells on each lamp's spot, extrapolated, as in `edge_mean`.
    """
    nodes, weights = gauss(max(SMOOTH_ORDER, 1 if beams.has_sharp_edge(beam) else order))
    rule = np.outer(weights, weights)
    if not beams.has_sharp_edge(beam):
        area, light_there = part(nodes, nodes)
        return float((light_there * area * rule).sum() / (area * rule).sum())
    total, whole = 0.0, float((part(nodes, nodes)[0] * rule).sum())
    for lamp in each_lamp(lamps):
        box = spot_box(tan_along, tan_across, shape=shape, range_m=range_m, lamps=lamp, beam=beam)[:, 0]
        lit = 0.25 * max(box[1] - box[0], 0.0) * max(box[3] - box[2], 0.0)
        if lit > 0.0:
            means = []
            for k in (order, max(order // 2, 2)):
                u, v = (0.5 * (low + high + (high - low) * cells(k)[0]) for low, high in (box[:2], box[2:]))
                area, light_there = part(u, v, lamps=lamp, edge_share=True)
                means.append(float((light_there * area).mean()))
            total += lit * max((4.0 * means[0] - means[1]) / 3.0, 0.0)
    return total / whole


def least_of(
    function: Callable[[Array, Array], Array], u: Array, v: Array, cell: float, gain_rel: float = -math.inf
) -> float:
    """Least value of a function over the square |u|, |v| <= 1: on a grid, then ever closer about its lowest points.

    Narrow beams leave dark wedges between the grid's points; a few of the lowest are followed down.

    gain_rel : of the value, that a step must win for another to follow. Steps are a third as long as those before, so
        that about a smooth minimum the next win a ninth of it; in a crease they may win more
    """
    values = function(u, v)
    steps = np.linspace(-1.0, 1.0, 7)
    step_u, step_v = (part.ravel() for part in np.meshgrid(steps, steps))
    for _ in range(LEAST_ZOOMS):
        low = np.argsort(values, kind="stable")[:LEAST_STARTS]
        u = np.clip(u[low, None] + cell * step_u, -1.0, 1.0).ravel()
        v = np.clip(v[low, None] + cell * step_v, -1.0, 1.0).ravel()
        before, values, cell = float(values.min()), function(u, v), cell / 3.0
        if float(values.min()) > before * (1.0 - gain_rel):
            break
    return float(values.min())


class FloorSteps(NamedTuple):
    """How far a floor point moves for a step of its field tangents [m]: along the floor and across, by u and by v."""

    along_u: Array
    along_v: Array
    across_u: Array
    across_v: Array

    @property
    def area_m2(self) -> Array:
        """Floor area per area of field tangents."""
        return np.asarray(np.abs(self.along_u * self.across_v - self.along_v * self.across_u))

    @property
    def longest_m(self) -> Array:
        """The longer side of what a square of tangents covers, over the square's."""
        return np.maximum(np.hypot(self.along_u, self.across_u), np.hypot(self.along_v, self.across_v))

    @property
    def least_moved_m(self) -> tuple[Array, Array]:
        """Way along and across the floor that moves the image by one tangent, in whatever direction it then goes."""
        along, across = np.hypot(self.across_v, self.across_u), np.hypot(self.along_v, self.along_u)
        return self.area_m2 / along, self.area_m2 / across


def floor_steps(tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: Any) -> FloorSteps:
    """Derivatives of the floor point of a ray by its field tangents u, v, on a plane of any slope s.

        (x, y) = (u, v) F,   F = (A + d W) / (1 - s u W),   along the floor X = x sqrt(1 + s^2)

    Parameters
    ----------
    tan_along, tan_across : (...,) u, v [1]; range_m : d, along the axis [m]; they broadcast

    Returns
    -------
    FloorSteps (...,) [m]; dA/dq and dW/dq of `imaging.ray_spread` follow from -(n^2 - 1) / 2 times their cubes

    Notes
    -----
    Valid where the ray meets the plane, s u W < 1; beyond `imaging.FARTHEST` the descent is held.

    References
    ----------
    Plane geometry and Snell's law; physics page, sections 4 and 7.
    """
    u, v, s = np.asarray(tan_along, float), np.asarray(tan_across, float), shape.slope
    square = u * u + v * v
    start_m, per_m = ray_spread(square, shape)
    start_q = per_q = 0.0 * square
    if not shape.is_dome:
        glass = 1.0 / port.bend(square, n=shape.n_glass)
        start_q = -0.5 * shape.thickness_m * (shape.n_glass**2 - 1.0) * glass**3
        per_q = -0.5 * (shape.n_water**2 - 1.0) * per_m**3
    reach_m, reach_q = start_m + range_m * per_m, start_q + range_m * per_q
    fall = descent(u, per_m, s)
    fall_u, fall_v = -s * (per_m + 2.0 * u * u * per_q), -2.0 * s * u * v * per_q
    scale = reach_m / fall
    scale_u = (2.0 * u * reach_q - scale * fall_u) / fall
    scale_v = (2.0 * v * reach_q - scale * fall_v) / fall
    secant = np.hypot(1.0, s)
    return FloorSteps(
        secant * (scale + u * scale_u), secant * u * scale_v, v * scale_u, scale + v * scale_v
    )


def floor_area_ratio(tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float) -> Array:
    """Floor area per area of field tangents, |d(x, y) / d(u, v)| [m^2]; constant behind a dome over a square plane."""
    if shape.slope:
        return floor_steps(tan_along, tan_across, shape=shape, range_m=range_m).area_m2
    if shape.is_dome:
        return np.full(np.broadcast(tan_along, tan_across).shape, (range_m + shape.outer_radius_m) ** 2)
    radius = np.hypot(tan_along, tan_across)
    steep = port.flat_floor_derivative(radius, **shape.plates, range_m=range_m)
    return np.asarray(flat_slope_m(radius, shape=shape, range_m=range_m) * steep)
