"""The part of the forward veil that comes from elsewhere on the floor.

Light from the floor that is scattered by a large angle on its way leaves its own pixel and falls into others. Seen the
other way round, a pixel looks not only along its ray but, weakly, about it:

    V(u) = cos^4 * integral over directions u' of k(u . u') E(u') (exp(-K_all r') - exp(-K_near r')) d Omega'

with E the floor's illuminance where u' meets it, r' the way from there, and a kernel of integral 1 that is the wider
the more often light has turned on its way; of what comes from elsewhere the share q_i has turned i times,

    k = q_1 (0.85 k_16 + 0.15 k_2) + q_2 k_8 + (1 - q_1 - q_2) k_4,   k_n = (n + 1) / (2 pi) cos^n
    q_i = x^i / (i! (e^x - 1)),   x = (K_near - K_all) d

The floor under a lamp is taken as spots (`veil.spots`), so that no integral over the floor has to follow the lobe's
flank: E d Omega' = Phi cos(theta_c) / r_c^2 for a spot that gets the flux Phi. The spots are the same for all images of
one port, and the kernel so wide that a few nodes over an image give its mean.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import Array
from uwopt.model import port
from uwopt.model.fineness import scaled
from uwopt.model.image_mean import gauss
from uwopt.model.imaging import PortShape, field_loss
from uwopt.model.path_table import PathTable, log_transmissions_anywhere
from uwopt.model.veil.spots import Spots

POWERS = (2, 4, 8, 16)  # n of the kernels: each the square of the one before
ONCE = {16: 0.85, 2: 0.15}  # of light that turned once: most from nearby, and a long tail
TWICE, OFTEN = 8, 4
FEW = 1e-9  # turns, below which all of it turned once
IMAGE_NODES, LARGE_NODES = 6, 8  # a side
LARGE_TANGENT = 0.6  # of the half of a side, from which an image is large
REACH = 12.0  # altitudes to which tables of water's loss should go for these spots
AT_ONCE = 2_000_000  # pairs of pixel and spot
#: Of `least_within`, from these tangents in water of the corner on: cells a side of the image's quarter, nodes a side
CELLS = {0.0: (1, 8), 0.35: (2, 8), 0.65: (3, 10), 1.1: (4, 14)}
WITHIN_AT_ONCE = 256  # images
MOST_CURVED = 1.0 / 16.0  # of (n - 1) times a cell's squared radius; see `least_within`


def kernel_shares(turns: ArrayLike) -> Array:
    """How much of what comes from elsewhere comes by each of the kernels k_2, k_4, k_8 and k_16, 1 in all.

        q_1 (0.85 k_16 + 0.15 k_2) + q_2 k_8 + (1 - q_1 - q_2) k_4,   q_i = x^i / (i! (e^x - 1))

    Parameters
    ----------
    turns : (...,) [1], x = (K_near - K_all) d, 0 or more: Poisson's mean number of turns, of which at least one is

    Returns
    -------
    (..., 4) [1], the powers as in `POWERS`
    """
    x = np.maximum(np.asarray(turns, dtype=float), FEW)
    with np.errstate(over="ignore"):
        once = x / np.expm1(x)
    twice = 0.5 * x * once
    shares = np.zeros((*x.shape, len(POWERS)))
    for power, part in ONCE.items():
        shares[..., POWERS.index(power)] = part * once
    shares[..., POWERS.index(TWICE)] = twice
    shares[..., POWERS.index(OFTEN)] = 1.0 - once - twice
    return shares


def wide_gain(
    tan_along: Array, tan_across: Array, *, spots: Spots, shape: PortShape, table: PathTable, shares: Array
) -> Array:  # fmt: skip
    """The veil from elsewhere at field points [1/m^2], in the unit of `imaging.local_gain`.

    tan_along, tan_across : (...,) tangents in air; table : loss over lamp and camera leg, K_all less K_near on the
    latter; shares : of the kernels, see `kernel_shares`. Valid for what is seen within 90 deg of its own way: nothing
    comes round a corner.
    """
    loss = log_transmissions_anywhere((table,), spots.lamp_m, spots.camera_m)[0]
    amount = spots.share * np.exp(loss)
    along, across = np.broadcast_arrays(np.asarray(tan_along, float), np.asarray(tan_across, float))
    bend = 1.0
    if not shape.is_dome:
        tangent = np.maximum(np.hypot(along, across), 1e-9)
        bend = port.water_tangent(tangent, n=shape.n_water) / tangent
    pixel = np.stack([(along * bend).ravel(), (across * bend).ravel(), np.ones(along.size)], axis=1)
    pixel /= np.sqrt(np.square(pixel).sum(axis=1))[:, None]
    found = np.empty(along.size)
    step = max(1, AT_ONCE // max(amount.size, 1))
    for start in range(0, along.size, step):
        kernel, total = np.maximum(pixel[start : start + step] @ spots.direction, 0.0), 0.0
        for share, power in zip(shares, POWERS, strict=True):
            kernel *= kernel
            total = total + (kernel @ amount) * (share * (power + 1) / (2.0 * np.pi))
        found[start : start + step] = total
    return np.asarray(found.reshape(along.shape) * field_loss(along, across, shape=shape))


def mean_wide_gain(
    tan_along: Array, tan_across: Array, *, spots: Spots, shape: PortShape, table: PathTable, shares: Array,
    fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Mean of `wide_gain` over the rectangles of images of these half widths in air, (n,) [1/m^2]."""
    along, across = np.asarray(tan_along, dtype=float), np.asarray(tan_across, dtype=float)
    large = np.maximum(along, across) > LARGE_TANGENT
    found = np.empty(len(along))
    for mine, count in ((~large, IMAGE_NODES), (large, LARGE_NODES)):
        if mine.any():
            nodes, weights = gauss(scaled(count, fineness))
            u, v = np.meshgrid(nodes, nodes, indexing="ij")
            gain = wide_gain(
                np.multiply.outer(along[mine], u.ravel()), np.multiply.outer(across[mine], v.ravel()), spots=spots,
                shape=shape, table=table, shares=shares,
            )  # fmt: skip
            found[mine] = gain @ np.outer(weights, weights).ravel()
    return found


def least_within(
    tan_along: ArrayLike, tan_across: ArrayLike, *, index: ArrayLike = 1.0, most_along: ArrayLike | None = None,
    most_across: ArrayLike | None = None, aside: ArrayLike = 0.0,
) -> Array:  # fmt: skip
    """What an image gets back at least of its own floor's light as veil from elsewhere, by kernel and loss (n, 4) [1].

        mean V / mean S >= h g(r) / exp(-c r)
        h = least over places u' of the image of f(u') = integral over the image of k(u . u') cos u / cos u' d Omega

    with V of a kernel of `POWERS` alone, S what forms the image, g the loss of the wide veil, both losses straight down
    over the shortest ray. u and u' are directions in water within the image; the sums over both may be taken in either
    order, and the light on the floor, however uneven, is the same in V and S. What comes from beside the image is left
    out.

    Parameters
    ----------
    tan_along, tan_across : (n,) tangents in air of half the image's sides
    index : broadcasting [1], of water behind a flat window; 1 behind a dome, where rays go straight
    most_along, most_across : (n,), where rows stand for images from these halves on up to those, at any step between:
        light is counted that the smallest gets, from the least of all places of the largest
    aside : broadcasting [1], by how much farther from the axis, at most, places on the floor lie than a ray from the
        port's middle would have them

    Returns
    -------
    (n, 4) [1], a lower bound, the powers as in `POWERS`; of small images within 1 %

    Notes
    -----
    Why no place can have less, with x = (s, t) the tangents of u' and l(x) = (s, t, 1) . u / cos u, which is linear:
    f(x) = w(x)^(1-n) times the sum of W l(x)+^n, w = sqrt(1 + s^2 + t^2) and W > 0 the kernel's factor and the solid
    angle. By Hoelder's inequality, from any place x_0,

        f(x) >= F(x) = w(x)^(1-n) [sum of W l(x_0)+^(n-1) l(x)]^n [sum of W l(x_0)+^n]^(1-n).

    The quarter of the image is cut into cells. log F is a concave function of x, the log of a linear one, less
    (n - 1) / 2 log(1 + s^2 + t^2), whose second derivatives are nowhere below -1/4: so log F + (n - 1) / 16 |x - x_m|^2
    less that is concave, and F within a cell is least at one of its corners, but for exp(-(n - 1) / 16 |x - x_m|^2),
    x_m its middle, which is 1 for places within 45 deg of the axis. A window's barrel bends a cell's sides outward: it
    lies in the box of its corners, on the axis' side of the tangent to the circle through the one that is farthest.
    A place that lies aside by a share e counts ((1 + q) (1 + e) / (1 + q (1 + e)^2))^2 times as much, q = s^2 + t^2,
    or more. Left are the Gauss nodes of a smooth integrand: 1e-6 of it for corners up to 45 deg in water, 1e-3 to 70.
    """
    given = (tan_along, tan_across, tan_along if most_along is None else most_along,
             tan_across if most_across is None else most_across, index, aside)  # fmt: skip
    columns = np.broadcast_arrays(*(np.atleast_1d(np.asarray(one, dtype=float)) for one in given))
    found = np.zeros((len(columns[0]), len(POWERS)))
    far = np.hypot(columns[2], columns[3])
    corner = port.water_tangent(far, n=columns[4]) * (1.0 + columns[5])
    for (low, (cells, nodes)), high in zip(CELLS.items(), (*list(CELLS)[1:], np.inf), strict=True):
        mine = np.flatnonzero((low <= corner) & (corner < high))
        for start in range(0, len(mine), WITHIN_AT_ONCE):
            some = mine[start : start + WITHIN_AT_ONCE]
            found[some] = _least_of_cells(*(column[some] for column in columns), cells=cells, count=nodes)
    return found


def _least_of_cells(
    along: Array, across: Array, most_along: Array, most_across: Array, index: Array, aside: Array, *, cells: int,
    count: int,
) -> Array:  # fmt: skip
    """`least_within` by so many cells a side of the image's quarter, of the least of F at their corners."""
    sums = _Sums(along, across, index, count)
    steps = np.linspace(0.0, 1.0, cells + 1)
    u, v = (np.tan(np.multiply.outer(steps, np.arctan(side))) for side in (most_along, most_across))
    far, least = 1.0 + aside, np.full((len(POWERS), len(along)), np.inf)

    def seen(i: int, j: int) -> Array:
        return np.asarray(1.0 / _bend(u[i], v[j], index))

    for i in range(cells):
        for j in range(cells):
            near_s, near_t = u[i] * seen(i, j + 1), v[j] * seen(i + 1, j)
            far_s, far_t = u[i + 1] * seen(i + 1, j) * far, v[j + 1] * seen(i, j + 1) * far
            end_s, end_t = u[i + 1] * seen(i + 1, j + 1) * far, v[j + 1] * seen(i + 1, j + 1) * far
            square = np.square(end_s) + np.square(end_t)
            cut_t = np.clip((square - far_s * end_s) / end_t, near_t, far_t)
            cut_s = np.clip((square - far_t * end_t) / end_s, near_s, far_s)
            s = np.stack([near_s, far_s, near_s, far_s, cut_s])
            t = np.stack([near_t, near_t, far_t, cut_t, far_t])
            least = np.minimum(least, sums.bound(end_s, end_t, s, t))
    square = np.square(port.water_tangent(np.hypot(most_along, most_across), n=index))
    beside = np.square((1.0 + square) * far / (1.0 + square * np.square(far)))
    return np.asarray((least * np.minimum(beside, 1.0)).T)


class _Sums:
    """Sums over the nodes of images, and what Hoelder's inequality says of a place by them."""

    def __init__(self, along: Array, across: Array, index: Array, count: int):
        nodes, weights = gauss(count)
        u, v = np.meshgrid(nodes, nodes, indexing="ij")
        u, v = np.multiply.outer(along, u.ravel()), np.multiply.outer(across, v.ravel())
        index = index[:, None]
        seen = 1.0 / _bend(u, v, index)
        self.s, self.t = u * seen, v * seen
        cosine = 1.0 / np.sqrt(1.0 + np.square(self.s) + np.square(self.t))
        solid = np.outer(weights, weights).ravel() * (4.0 * along * across)[:, None] / np.square(
            index * (1.0 + np.square(u) + np.square(v))
        )
        moments = np.stack([np.ones_like(self.s), self.s, self.t])
        self.weighted = []
        for power in POWERS:
            self.weighted.append(moments * (solid * cosine**power * ((power + 1) / (2.0 * np.pi))))

    def bound(self, at_s: Array, at_t: Array, s: Array, t: Array) -> Array:
        """Least of F from one place (n,) over cells with these corners (k, n), (4, n)."""
        level = np.maximum(1.0 + self.s * at_s[:, None] + self.t * at_t[:, None], 0.0)
        square = np.square(s) + np.square(t)
        middle = [0.5 * (side.min(axis=0) + side.max(axis=0)) for side in (s, t)]
        radius = (np.square(s - middle[0]) + np.square(t - middle[1])).max(axis=0)
        radius = np.where(square.max(axis=0) > 1.0, radius, 0.0)
        found, raised, power_of = np.empty((len(POWERS), len(at_s))), level, level
        for k, power in enumerate(POWERS):  # level^(n-1), and level^(n/2)
            if k:
                raised, power_of = raised * np.square(power_of), np.square(power_of)
            one, along, across = np.einsum("cnm,nm->cn", self.weighted[k], raised)
            here = one + along * at_s + across * at_t
            line = np.maximum(one + along * s + across * t, 0.0) / here
            each = here * line**power * (1.0 + square) ** (0.5 * (1 - power))
            found[k] = each.min(axis=0) * np.exp((1 - power) * MOST_CURVED * radius)
        return found


def _bend(along: Array, across: Array, index: Array) -> Array:
    """Tangent in air over that in water; 1 where the index is."""
    return np.asarray(port.bend(np.square(along) + np.square(across), n=index))
