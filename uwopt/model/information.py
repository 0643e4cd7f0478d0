"""Information: what an image tells about a texture of the floor, an integral over spatial frequencies.

The transfer ends at a first null: the pupil's or the disc's is a circle about the zero frequency, the motion's a line
across it. Where an end lies inside the Nyquist square it is an edge of the rule, whose nodes go no further: a kink
inside a rule costs it most of its digits. So the sum is the integral to `RULE_ERROR`, however early the transfer
ends, and what is proven of the integral holds of the figure.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.model.fineness import scaled
from uwopt.model.lateral import SpreadTable, rms_px, spread_mtf
from uwopt.model.sharpness import (
    J1_ZERO,
    NUMBERS,
    NYQUIST_CYC_PER_PX,
    Sharpness,
    as_columns,
    common_shape,
    round_mtf,
    sharpness_rows,
    sinc_mtf,
)

Numeric = Any  # float, array that broadcasts

TEXTURE_CONTRAST = 0.1  # C_t, rms contrast of the floor's texture at every frequency (physics page, 8)
#: Gauss-Legendre nodes in radius and angle of each part of the rule, by the largest lateral colour [px rms] they
#: serve: wide colour is a narrow ridge in one direction.
ORDERS: tuple[tuple[float, int, int], ...] = (
    (0.0, 13, 7),
    (0.7, 13, 8),
    (2.0, 24, 16),
    (4.0, 48, 24),
    (np.inf, 64, 48),
)
#: No fewer of transfers by how hard they are: sharp ones in the whole square, those that end inside it, and those of
#: lenses so soft or smears so long that a bell or a ridge is narrow for these nodes.
LEAST_ORDERS = ((0, 0), (20, 8), (24, 12))
#: Relative, of the sum against the integral, up to an SNR of 300, without lateral colour or with
#: little. With more than 0.7 px rms of it 5e-5, with 8 px 2e-4.
RULE_ERROR = 1e-5
#: Of the contrast over the noise: from there on a lens without a null leaves nothing that `RULE_ERROR` would show.
LENS_LEAVES = 1e-4
MOST_GAIN = 3e4  # C_t SNR whose eighth power single precision holds
SOFT_PX = (1.2, 2.0)  # pitch of a lens from which the second and third of `LEAST_ORDERS` are needed
SMEAR_PX = 100.0  # motion from which the third are

# Where the transfer ends: nowhere inside the square, or at a circle inside it, or at one that cuts its corners off;
# and the same of what motion leaves of the square, where the circle cuts its corners or its long sides off.
SQUARE, CIRCLE, CUT_CORNERS, SMEARED, SMEARED_CUT, SMEARED_CIRCLE = range(6)
MIRRORED = (SQUARE, CIRCLE, CUT_CORNERS)

_HUGE = 1e300  # a blur that is called infinite: nothing arrives
_BLOCK_NODES = 40_000  # held at once, so that arrays stay in the cache


def information_bit_per_px(
    snr: Numeric,
    *,
    sharpness: Sharpness,
    orders: tuple[int, int] | None = None,
    fineness: float = 1.0,
) -> Array:
    """Information that one pixel carries about a texture of the floor.

        I = mean over |nu_x|, |nu_y| <= 1/2 of (1/2) log2(1 + (C_t SNR)^2 MTF(nu)^2),   C_t: `TEXTURE_CONTRAST`

    Parameters
    ----------
    snr : (...,) of a pixel on the plain floor, as a ratio
    sharpness : fields broadcast
    orders : Gauss-Legendre nodes in radius and angle of each part of the rule; None: as `ORDERS` says
    fineness : factor on the nodes of `ORDERS`

    Returns
    -------
    (...,) [bit per pixel].

    Notes
    -----
    The sum over `rule`, accurate to `RULE_ERROR`. Octants that are mirror images in |MTF| are computed once.

    References
    ----------
    Shannon's capacity of a Gaussian channel per sample, frequency by frequency. Physics page, section 8.
    """
    shape = common_shape(sharpness, snr)
    gain = np.broadcast_to(TEXTURE_CONTRAST * np.asarray(snr, dtype=float), shape).reshape(-1, 1, 1)
    bit = np.zeros(gain.shape[0])
    table = as_columns(sharpness, shape, (-1, 1, 1))
    for some, rows, nodes in _ruled(table, gain[:, 0, 0], orders, fineness):
        bit[some] = _sum_bit(gain[some], rows, nodes)
    return bit.reshape(shape)[()]


def information_of_gains(
    gain: Array, *, sharpness: Sharpness, fineness: float = 1.0, wanted: Array | None = None,
    orders: tuple[int, int] | None = None,
) -> Array:  # fmt: skip
    """Information of images that are equally sharp at several contrasts over the noise.

        I(g) = mean over |nu_x|, |nu_y| <= 1/2 of (1/2) log2(1 + g^2 MTF(nu)^2),   g = C_t SNR

    Parameters
    ----------
    gain : (k,) g
    sharpness : fields (n,)
    wanted : (n, k) which are worked out; None: all
    orders : as of `information_bit_per_px`

    Returns
    -------
    (n, k) [bit per pixel], nan where it is not wanted.

    Notes
    -----
    The rule of `information_bit_per_px` at the greatest gain: the transfer is worked out once for all. Up to
    `MOST_GAIN` logarithms are of single precision, each node's to 3e-7 of it: far below what `RULE_ERROR` leaves open.

    References
    ----------
    As `information_bit_per_px`.
    """
    shape = common_shape(sharpness)
    bit = np.full((*shape, len(gain)), np.nan)
    most = np.full(shape, gain.max())
    number = np.float32 if gain.max() <= MOST_GAIN else np.float64
    for some, rows, nodes in _ruled(as_columns(sharpness, shape, (-1, 1, 1)), most, orders, fineness):
        squares = [np.square(transfer).astype(number) for transfer in _folds(1.0, rows, nodes)]
        for column, one in enumerate(gain):
            mine = slice(None) if wanted is None or wanted[some, column].all() else wanted[some, column]
            if len(asked := some[mine]):
                seen = [square[mine] for square in squares]
                bit[asked, column] = _sum_of(number(np.square(one)), seen, rows, nodes.take(mine))
    return bit


def information_bit_per_m2(bit_per_px: Numeric, *, pixel_area_m2: Numeric) -> Numeric:
    """Information per area of floor, bit per px / ground area of a pixel [bit/m^2]; broadcasts [sym]."""
    return bit_per_px / pixel_area_m2


# ---------------------------------------------------------------- where the transfer ends


@dataclass(frozen=True)
class Ends:
    """Where transfers end, (n,): at a circle, at a line across the motion, and what that leaves of the square."""

    round_cyc_per_px: Array
    motion_cyc_per_px: Array  # the Nyquist frequency where motion ends beyond it
    kind: Array  # SQUARE, ...
    hard: Array  # which of `LEAST_ORDERS`


def transfer_ends(gain: Array, *, sharpness: Sharpness) -> Ends:
    """Ends of transfers, (n,) [cycles per px].

    gain : (n,) C_t SNR; sharpness : fields (n,). A lens, which has no null, ends where the contrast that it leaves is
    `LENS_LEAVES` of the noise, or of the texture where that is less.
    """
    faintest = np.log2(np.maximum(gain, 1.0) / LENS_LEAVES)
    lens_px = 2.0 * np.asarray(sharpness.lens_pitch_px) / np.sqrt(faintest)
    disc_px = np.asarray(sharpness.defocus_px) * (np.pi / J1_ZERO)
    cycle_px = np.maximum(np.maximum(sharpness.diffraction_px, disc_px), lens_px)
    return table_ends(1.0 / np.clip(cycle_px, 1.0, _HUGE), sharpness.motion_blur_px, soft=sharpness.lens_pitch_px)


def table_ends(round_cyc_per_px: Array, motion_blur_px: Array, *, soft: Array) -> Ends:
    """The same by the radius of the circle [cycles per px], the motion [px] and the lens's pitch [px], (n,)."""
    side = NYQUIST_CYC_PER_PX
    motion = 1.0 / np.clip(motion_blur_px, 1.0 / side, _HUGE)
    motion = np.where(motion < round_cyc_per_px, motion, side)  # beyond the circle nothing is left to end
    cut = round_cyc_per_px < np.hypot(motion, side)
    kind = np.where(cut, np.where(round_cyc_per_px <= side, CIRCLE, CUT_CORNERS), SQUARE)
    smeared = np.where(cut, np.where(round_cyc_per_px <= side, SMEARED_CIRCLE, SMEARED_CUT), SMEARED)
    kind = np.where(motion < side, smeared, kind)
    least_px, most_px = SOFT_PX
    hard = np.where((kind != SQUARE) | (soft > least_px), 1, 0)
    return Ends(round_cyc_per_px, motion, kind, np.where((soft > most_px) | (motion_blur_px > SMEAR_PX), 2, hard))


def orders_of(usual: tuple[int, int], hard: int, fineness: float = 1.0) -> tuple[int, int]:
    """Nodes of rays and how many rays: max(usual, `LEAST_ORDERS`) of transfers that are so hard to sum, by index."""
    least = LEAST_ORDERS[hard]
    return max(usual[0], scaled(least[0], fineness)), max(usual[1], scaled(least[1], fineness))


# ---------------------------------------------------------------- the rule


@dataclass(frozen=True)
class Rule:
    """Frequencies in a quadrant of the Nyquist square, (n or 1, n_rays, n_radial), and their weights.

    A ray is a direction with all its radii. Where the rule is `mirrored` it covers half the quadrant, and each
    node counts with along and across for each other, too.
    """

    along: Array
    across: Array
    weight: Array  # of the mean of (1/2) log2, over one quadrant that stands for all
    mirrored: bool

    def take(self, rows: Array | slice) -> Rule:
        """Of some rows, where each has its own."""
        if len(self.weight) == 1:
            return self
        return Rule(self.along[rows], self.across[rows], self.weight[rows], self.mirrored)


def rule(kind: int, round_cyc_per_px: Array, motion_cyc_per_px: Array, orders: tuple[int, int]) -> Rule:
    """Gauss-Legendre nodes of transfers that end alike, radii scaled to where each ends [cycles per px], (n,).

    Parts: rays that end at the square's side or the motion's, those that end at the circle, those that end at the
    other side. To a side at x = X a ray's direction is y = x sinh(v), in which the length of the ray,
    X cosh(v), is smooth however long the smear.
    """
    if kind == SQUARE:
        return _square_rule(orders)
    circle, motion, side = round_cyc_per_px, motion_cyc_per_px, NYQUIST_CYC_PER_PX
    mirrored, cut = kind in MIRRORED, kind not in (SQUARE, SMEARED)
    first = np.zeros(1)  # angle at which the circle begins
    parts = []
    if kind != CIRCLE:
        steepest = np.sqrt(np.maximum(np.square(circle) - np.square(motion), 0.0)) if cut else np.full(1, side)
        parts.append(_to_side(motion, steepest / motion, orders))
        first = np.arctan2(steepest, motion)
    last = np.full(1, np.pi / 4.0 if mirrored else np.pi / 2.0)
    if kind in (SMEARED, SMEARED_CUT):
        widest = np.sqrt(np.maximum(np.square(circle) - side**2, 0.0)) if cut else motion
        across, along, weight = _to_side(np.full(1, side), widest / side, orders)
        parts.append((along, across, weight))
        last = np.arctan2(side, widest)
    if cut:
        parts.append(_to_circle(circle, first, np.maximum(last - first, 0.0), orders))
    many = max(len(array) for part in parts for array in part)
    columns = [
        np.concatenate([np.broadcast_to(array, (many, *array.shape[1:])) for array in each], axis=1)
        for each in zip(*parts, strict=True)
    ]
    return Rule(columns[0], columns[1], columns[2], mirrored)


@cache
def _square_rule(orders: tuple[int, int]) -> Rule:
    """Of transfers that do not end inside the square."""
    return Rule(*_to_side(np.full(1, NYQUIST_CYC_PER_PX), np.ones(1), orders), mirrored=True)


def _to_side(end: Array, steepest: Array, orders: tuple[int, int]) -> tuple[Array, Array, Array]:
    """Nodes of the triangle from the origin to a side at along = end, up to across / along = steepest: (n, ., .)."""
    radial, radial_weight, angular, angular_weight = _gauss(orders)
    most = np.arcsinh(steepest)[:, None, None]
    angle = most * angular
    end = end[:, None, None]
    along = end * radial
    weight = np.square(end) * radial * radial_weight * (most * angular_weight * np.cosh(angle))
    return along + 0.0 * angle, along * np.sinh(angle), weight * (2.0 / np.log(2.0))


def _to_circle(end: Array, first: Array, width: Array, orders: tuple[int, int]) -> tuple[Array, Array, Array]:
    """Nodes of the sector of a circle: (n, ., .)."""
    radial, radial_weight, angular, angular_weight = _gauss(orders)
    angle = first[:, None, None] + width[:, None, None] * angular
    radius = end[:, None, None] * radial
    weight = end[:, None, None] * radius * radial_weight * (width[:, None, None] * angular_weight)
    return radius * np.cos(angle), radius * np.sin(angle), weight * (2.0 / np.log(2.0))


@cache
def _gauss(orders: tuple[int, int]) -> tuple[Array, Array, Array, Array]:
    """Gauss-Legendre nodes and weights on [0, 1]: radial (n,), angular (n, 1)."""
    (radial, radial_weight), (angular, angular_weight) = (
        ((nodes + 1.0) / 2.0, weights / 2.0) for nodes, weights in map(np.polynomial.legendre.leggauss, orders)
    )
    return radial, radial_weight, angular[:, None], angular_weight[:, None]


# ---------------------------------------------------------------- the sum


def _ruled(
    table: Sharpness, gain: Array, orders: tuple[int, int] | None, fineness: float
) -> Iterator[tuple[Array, Sharpness, Rule]]:
    """Rows of a table of columns (n, 1, 1) that one rule serves, few at a time: which, their columns and nodes."""
    ends = transfer_ends(gain, sharpness=_flat(table))
    colour_px = _colour_rms_px(table)
    lowest_px = -1.0
    for highest_px, *usual in ORDERS:
        served = (colour_px > lowest_px) & (colour_px <= highest_px)
        lowest_px = highest_px
        spread = table.spread if highest_px > 0.0 else None
        for kind, hard in sorted(set(zip(ends.kind[served].tolist(), ends.hard[served].tolist(), strict=True))):
            rows = np.flatnonzero(served & (ends.kind == kind) & (ends.hard == hard))
            wanted = orders or orders_of((scaled(usual[0], fineness), scaled(usual[1], fineness)), int(hard), fineness)
            block = max(1, _BLOCK_NODES // (wanted[0] * wanted[1]))
            for start in range(0, rows.size, block):
                some = rows[start : start + block]
                nodes = rule(int(kind), ends.round_cyc_per_px[some], ends.motion_cyc_per_px[some], wanted)
                yield some, sharpness_rows(table, some, spread=spread), nodes


def _sum_bit(gain: Array, sharpness: Sharpness, nodes: Rule) -> Array:
    """The sum over a rule; columns (n, 1, 1) give (n,) bit per px."""
    return _sum_of(1.0, (np.square(transfer) for transfer in _folds(gain, sharpness, nodes)), sharpness, nodes)


def _sum_of(scale: Numeric, squares: Iterable[Array], sharpness: Sharpness, nodes: Rule) -> Array:
    """The sum over a rule of what squares of transfers, times a scale, tell: (n,) bit per px."""
    signs = 1 if sharpness.spread is None else 2
    logs = log_of_all(scale * square for square in squares)
    return np.asarray((logs * nodes.weight).sum(axis=(1, 2)) / signs)


def log_of_all(powers: Iterable[Array]) -> Array:
    """Sum of ln(1 + power) over what a node stands for: one logarithm for all, that of the product.

    By ln(1 + p) = ln(u) - ((u - 1) - p) / u, u = 1 + p as rounded, to the last digit or two: `log1p` is dearer.
    """
    product: Array | None = None  # of 1 + power, less 1
    for power in powers:
        product = power if product is None else product + power * (1.0 + product)
    assert product is not None
    whole = 1.0 + product
    left = whole - 1.0
    left -= product
    left /= whole
    return np.asarray(np.subtract(np.log(whole, out=whole), left, out=left))


def _folds(gain: Numeric, sharpness: Sharpness, nodes: Rule) -> Iterator[Array]:
    """The transfer times the gain (n, 1, 1) at all that the nodes of a rule stand for."""
    large, small = nodes.along, nodes.across
    radius = np.sqrt(np.square(large) + np.square(small))
    common = (gain * round_mtf(radius, sharpness=sharpness)) * (sinc_mtf(large) * sinc_mtf(small))
    for along, across in ((large, small), (small, large))[: 1 + nodes.mirrored]:
        moving = common * sinc_mtf(along, width_px=sharpness.motion_blur_px)
        if sharpness.spread is None:
            yield moving
            continue
        for sign in (1.0, -1.0):
            yield moving * _colour(along, sign * across, sharpness)


def _colour(along: Array, across: Array, sharpness: Sharpness) -> Array:
    """What lateral colour leaves at frequencies; where all rows share these, once for all that are alike."""
    k_along, k_across, table = sharpness.lateral_k_along, sharpness.lateral_k_across, sharpness.spread
    assert table is not None
    alike = len(along) == 1 < len(k_along) and isinstance(table, SpreadTable)
    if not alike:
        return np.asarray(spread_mtf(k_along * along + k_across * across, table=table))
    found, which = np.unique((k_along + 1j * k_across)[:, 0, 0], return_inverse=True)
    k = found.real[:, None, None] * along + found.imag[:, None, None] * across
    return np.asarray(spread_mtf(k, table=table))[which]


def _flat(table: Sharpness) -> Sharpness:
    """A table of columns as (n,)."""
    return Sharpness(**{name: getattr(table, name)[:, 0, 0] for name in NUMBERS})


def _colour_rms_px(table: Sharpness) -> Array:
    """Lateral colour of each design [px rms] to first order, from columns: (n,)."""
    index_rms = table.spread.index_rms if isinstance(table.spread, SpreadTable) else 0.0
    return np.asarray(rms_px(table.lateral_k_along, table.lateral_k_across, index_rms), dtype=float)[:, 0, 0]
