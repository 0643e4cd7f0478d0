"""Information over a cell of settings: values, and upper bounds that are tight to second order.

In the logarithms of f-number and time, ln MTF at any frequency is concave (so are ln of a sinc, of a jinc and
of the pupil's transfer, each falling from 1), and so is ln SNR in ln light. Information is an integral of
(1/2) log2(1 + e^(2z)), z = ln(C_t SNR MTF), over frequency. The integrand's logarithm is concave in z and rises
with it, and z is concave in the settings and the logarithms of the frequencies together, whose volume element is
itself the exponential of a linear function: so the logarithm of the integral is concave in the settings
(Prekopa 1973), and its tangent lies above it. What is bounded is the exponential of that tangent: convex, with its
greatest value over a polytope at a vertex.

Lateral colour falls along every ray from the centre, but not along both frequencies at once: there the rays are
integrals of their own. Where it comes back after a null, every node is, out to where no transfer of the cell goes on:
the tangent of a factor at nodes that lie next to its null or beyond is taken where the factor is sharpest in the cell.

Nodes and sums are those of `model.information`, which gives the integral to `RULE_ERROR`; its derivatives are sums
over the same nodes, for at a null the integrand and what moves with it are 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.sharpness import SharpRows
from uwopt.model.information import (
    LEAST_ORDERS,
    ORDERS,
    SQUARE,
    TEXTURE_CONTRAST,
    Ends,
    log_of_all,
    orders_of,
    rule,
    transfer_ends,
)
from uwopt.model.lateral import SpreadTable, rms_px, spread_mtf
from uwopt.model.sharpness import (
    J1_ZERO,
    Sharpness,
    defocus_mtf,
    diffraction_mtf,
    jinc_and_slope,
    lens_mtf,
    pupil_and_slope,
    sinc_and_slope,
    sinc_mtf,
)

MOST_NUMBERS = 60_000  # cells x nodes held at once, so that arrays stay in the cache
SHARP_PX = 1.5  # of motion and of defocus: tangents are taken where the image is no worse, and lie nearer to the best
NULL = 1e-9  # of a transfer: below it a tangent says nothing
DARK_BIT = 1e-12  # of an integral: below it a tangent says nothing
LATERAL_FROM, LATERAL_STEP = 0.1, 0.02  # of colour's phase: a bell below it; steps of its logarithm
BENDS = 1e-4  # of a slope in logarithms: the table is piecewise linear
ENDS = tuple(Ends.__dataclass_fields__)
MOST_POWER = 1e70  # (C_t SNR)^2 that no image has, and whose fourth power is still a number
#: A null at so many times a node's frequency is far enough from it; and beyond so much of a null there is nothing.
BEYOND, LAST = 1.1, 1.0 - 1e-12
Form = Callable[[Array], tuple[Array, Array]]
Joined = Literal["all", "rays", "none"]  # which nodes are one integral whose logarithm is concave


@dataclass(frozen=True)
class Nodes:
    """Frequencies of rules, (k, .), k = 1 or one a row: `base` radii that folds share, and by node of every fold.

    A fold takes the base's along and across as they are, for each other, or with the other sign of across.
    """

    radius_cyc_per_px: Array  # (k, n_base)
    along: Array  # (k, n_folds * n_base)
    across: Array
    weight: Array  # [bit]
    n_radial: int
    n_moving: int  # folds that motion tells apart; the others move as these do

    @staticmethod
    def of(kind: int, ends: Ends, orders: tuple[int, int], *, both_signs: bool) -> Nodes:
        """The rule of transfers that end alike."""
        made = rule(kind, ends.round_cyc_per_px, ends.motion_cyc_per_px, orders)
        large, small, weight = (part.reshape(len(part), -1) for part in (made.along, made.across, made.weight))
        moving = [(large, small), (small, large)][: 1 + made.mirrored]
        folds = [*moving, *((along, -across) for along, across in moving)][: len(moving) * (1 + both_signs)]
        return Nodes(
            np.hypot(large, small), np.concatenate([a for a, _ in folds], axis=1),
            np.concatenate([b for _, b in folds], axis=1),
            np.tile(weight / (1 + both_signs), (1, len(folds))), orders[0], len(moving),
        )  # fmt: skip

    def take(self, rows: Array) -> Nodes:
        """Of some rows, where each has its own."""
        if len(self.weight) == 1:
            return self
        radius, weight = self.radius_cyc_per_px[rows], self.weight[rows]
        return Nodes(radius, self.along[rows], self.across[rows], weight, self.n_radial, self.n_moving)

    @property
    def folds(self) -> int:
        """How often the base is taken."""
        return self.along.shape[1] // self.radius_cyc_per_px.shape[1]

    def as_moving(self, by_node: Array) -> Array:
        """Nodes of the folds that motion tells apart, (m, n_moving, n_base)."""
        return by_node.reshape(len(by_node), self.n_moving, self.radius_cyc_per_px.shape[1])

    def as_folds(self, by_node: Array) -> Array:
        """Nodes (m, n_nodes) as (m, n_signs, n_moving, n_base)."""
        return by_node.reshape(
            len(by_node), self.folds // self.n_moving, self.n_moving, self.radius_cyc_per_px.shape[1]
        )

    def bits(self, power: Array) -> Array:
        """Bit per px of the square of contrast over noise by node, (m, n_signs, n_moving, n_base): (m,)."""
        first = self.weight[:, : power.shape[3]]  # of every fold
        each = (power[:, sign, move] for sign in range(power.shape[1]) for move in range(power.shape[2]))
        return np.asarray((log_of_all(each) * first).sum(axis=1))

    def sums(self, by_node: Array, joined: Joined) -> Array:
        """Nodes (m, n_nodes), weighed, as integrals (m, n_integrals)."""
        weighed = by_node * self.weight
        if joined == "all":
            return np.asarray(weighed.sum(axis=1, keepdims=True))
        return weighed if joined == "none" else weighed.reshape(len(by_node), -1, self.n_radial).sum(axis=2)


def square_nodes(orders: tuple[int, int], *, both_signs: bool) -> Nodes:
    """Nodes of transfers that do not end inside the Nyquist square."""
    nowhere = np.empty(0)
    return Nodes.of(SQUARE, Ends(nowhere, nowhere, nowhere, nowhere), orders, both_signs=both_signs)


@dataclass(frozen=True)
class TransferGroup:
    """Designs whose transfers are summed alike, and what no setting changes of them."""

    orders: tuple[int, int]
    joined: Joined
    spread: SpreadTable | None
    square: list[tuple[Nodes, Array]]  # by how hard they are: nodes in the whole square, and `still2` of them


def log_lens(sharp: SharpRows, design: Array, f_number: Array, radius_cyc_per_px: Array) -> tuple[Array, Array]:
    """Ln of the lens's transfer by radius and its slope in ln 1/N, (n, n_base); both fall with 1/N."""
    scale = -np.log(2.0) * (2.0 * radius_cyc_per_px) ** 2
    pitch2 = np.square(sharp.lens_pitch_px("rms", f_number=f_number, rows=design))
    closed2 = np.square(sharp.lens_blur("rms") * sharp.rated_pitch_px[design])
    return scale * pitch2[:, None], scale * (sharp.aberration_exponent[design] * (pitch2 - closed2))[:, None]


def on_tangents(form: Form, here: Array, sharpest: Array, null: float) -> tuple[Array, Array]:
    """Ln of a factor of the transfer and its slope in ln of its argument, by node, on a tangent of it; -inf: dark.

    form : value and slope at an argument, concave in logarithms, 0 from `null` on; here, sharpest : the argument
    (m, n_nodes), the least in a cell. The tangent is that at `here`, or where the null is next to that at the sharpest.
    """
    far = here * BEYOND < null
    at = np.where(far, here, sharpest)
    value, slope = form(at)
    lit = at < null * LAST
    with np.errstate(divide="ignore"):
        log = np.log(np.where(lit, value, 0.0))
    slope = np.where(lit, slope, 0.0)
    if not far.all():
        with np.errstate(divide="ignore", invalid="ignore"):
            log += np.where(far | ~lit, 0.0, slope * np.log(here / at))
    return log, slope


def bell_until(table: SpreadTable) -> float:
    """The k to which ln |Phi| of lateral colour falls and is concave in ln k."""
    if table.index_rms == 0.0:
        return float(np.inf)
    end = 0.999 * (table.magnitude.size - 1) * table.step
    k = np.exp(np.arange(np.log(LATERAL_FROM / table.index_rms), np.log(end), LATERAL_STEP))
    slope = np.diff(np.log(np.maximum(spread_mtf(k, table=table), NULL))) / LATERAL_STEP
    bent = np.nonzero((np.diff(slope) > BENDS) | (slope[1:] > 0.0))[0]
    return float(k[bent[0]] if len(bent) else k[-1])


@dataclass(frozen=True)
class Tangents:
    """Integrals (m, n_integrals) [bit per px] at a point, and the slopes of their logarithms."""

    bits: Array
    by_snr: Array
    by_n: Array
    by_blur: Array

    def at(self, on: Array, shift_snr: Array, shift_n: Array, shift_blur: Array) -> Array:
        """Bit per px on the tangents, (k,), at shifts (k,) of some rows."""
        rise = self.by_snr[on] * shift_snr[:, None] + self.by_n[on] * shift_n[:, None]
        rise += self.by_blur[on] * shift_blur[:, None]
        return np.asarray((self.bits[on] * np.exp(np.minimum(rise, 600.0))).sum(axis=1))

    @property
    def dark(self) -> Array:
        """Where tangents say nothing, (m,)."""
        return np.asarray((self.bits < DARK_BIT).any(axis=1))


@dataclass(frozen=True)
class NodeTangents:
    """Ln of C_t SNR MTF without what no setting changes, by node on the tangents of its factors, and their slopes.

    What is round is by base node, motion by the folds that it tells apart.
    """

    nodes: Nodes
    still2: Array  # what no setting changes, squared
    round_log: Array
    by_n: Array
    blur_log: Array
    by_blur: Array

    def at(self, on: Array, shift_snr: Array, shift_n: Array, shift_blur: Array) -> Array:
        """Bit per px on the tangents, (k,), at shifts (k,) of some rows."""
        still = self.round_log[on] + shift_snr[:, None] + self.by_n[on] * shift_n[:, None]
        moved = self.nodes.as_moving(self.blur_log[on] + self.by_blur[on] * shift_blur[:, None]) + still[:, None]
        still2 = self.still2 if len(self.still2) == 1 else self.still2[on]
        grown = np.exp(2.0 * np.minimum(moved, 300.0))[:, None] * self.nodes.as_folds(still2)
        return self.nodes.take(on).bits(np.minimum(grown, MOST_POWER, out=grown))


@dataclass(frozen=True)
class Image(Columns):
    """Settings of m designs that decide the transfer: disc and lens may go with another f-number than the pupil."""

    design: Array
    snr: Array  # texture's gain included
    f_number: Array  # of disc and lens
    working: Array  # of the pupil
    blur_px: Array


@dataclass(frozen=True)
class Chunk:
    """Images whose transfers are summed alike: which they are, their nodes, what no setting changes, squared."""

    rows: Array
    joined: Joined
    nodes: Nodes
    still2: Array


class Information:
    """Information per pixel of designs in one scene, at settings and over cells."""

    def __init__(self, sharp: SharpRows):
        self.sharp = sharp
        n = len(sharp.wavelength_nm)
        self.groups: list[TransferGroup] = []
        self.group, self.place = np.zeros(n, int), np.zeros(n, int)
        for rows, spread in sharp.groups("rms"):
            k_along, k_across = sharp.rms_k_along[rows], sharp.rms_k_across[rows]
            k, wide_px = np.hypot(k_along, k_across), rms_px(k_along, k_across, spread.index_rms if spread else 0.0)
            falls = np.ones(len(rows), bool) if spread is None else k * np.sqrt(0.5) <= bell_until(spread)
            lowest = -1.0
            for highest, *orders in ORDERS:
                served = (wide_px > lowest) & (wide_px <= highest)
                lowest = highest
                if spread is None:
                    self._add(rows[served], (orders[0], orders[1]), "all", None)
                    continue
                for joined, which in (("rays", falls), ("none", ~falls)):
                    self._add(rows[served & which], (orders[0], orders[1]), joined, spread)

    def _add(self, rows: Array, orders: tuple[int, int], joined: Joined, spread: SpreadTable | None) -> None:
        """A group of designs, where there are any."""
        if len(rows) == 0:
            return
        square = []
        for hard in range(len(LEAST_ORDERS)):
            nodes = square_nodes(orders_of(orders, hard), both_signs=spread is not None)
            square.append((nodes, self._still2(nodes, rows if spread is not None else rows[:1], spread)))
        self.group[rows] = len(self.groups)
        self.place[rows] = np.arange(len(rows)) if spread is not None else 0
        self.groups.append(TransferGroup(orders, joined, spread, square))

    def _still2(self, nodes: Nodes, design: Array, spread: SpreadTable | None) -> Array:
        """Square of what no setting changes of the transfer: pixel and lateral colour, (n, n_nodes)."""
        still = sinc_mtf(nodes.along) * sinc_mtf(nodes.across)
        if spread is not None:
            k_al, k_ac = self.sharp.rms_k_along[design][:, None], self.sharp.rms_k_across[design][:, None]
            still = still * spread_mtf(k_al * nodes.along + k_ac * nodes.across, table=spread)
        return np.asarray(np.square(still))

    def blur_px(self, design: Array, time_s: Array) -> Array:
        """Motion in a time, nominal altitude."""
        return np.asarray(self.sharp.blur_px_per_s[design, 1] * time_s)

    # ------------------------------------------------------------ one rule

    def _ends(self, image: Image) -> Ends:
        """Where the transfers of images end."""
        sharp, d = self.sharp, image.design
        return transfer_ends(TEXTURE_CONTRAST * image.snr, sharpness=Sharpness(
            image.working, sharp.wavelength_nm[d], sharp.pixel_pitch_m[d], motion_blur_px=image.blur_px,
            defocus_px=sharp.rms_disc_px[d, 1] / image.f_number,
            lens_pitch_px=sharp.lens_pitch_px("rms", f_number=image.f_number, rows=d),
        ))  # fmt: skip

    def _chunks(self, image: Image, ends: Ends) -> list[Chunk]:
        """Images by group and by where their transfers end, few at a time."""
        chunks = []
        of = self.group[image.design]
        key = (of * 4 + ends.hard) * 8 + ends.kind
        for each in np.unique(key):
            every = np.nonzero(key == each)[0]
            group, kind, hard = self.groups[each // 32], int(each % 8), int(each // 8 % 4)
            whole, still2 = group.square[hard]
            step = max(1, MOST_NUMBERS // (whole.along.shape[1] * (1 if kind == SQUARE else 2)))
            for start in range(0, len(every), step):
                some = every[start : start + step]
                if kind == SQUARE:
                    seen = still2 if len(still2) == 1 else still2[self.place[image.design[some]]]
                    chunks.append(Chunk(some, group.joined, whole, seen))
                    continue
                here = Ends(*(getattr(ends, name)[some] for name in ENDS))
                nodes = Nodes.of(kind, here, orders_of(group.orders, hard), both_signs=group.spread is not None)
                seen = self._still2(nodes, image.design[some], group.spread)
                chunks.append(Chunk(some, group.joined, nodes, seen))
        return chunks

    def _transfer(self, nodes: Nodes, image: Image) -> tuple[Array, Array, Array, Array, Array]:
        """Transfer of the lens by radius with the slopes in ln N of the pupil's and of the other factors; that of
        motion by node and its slope in ln blur."""
        radius = nodes.radius_cyc_per_px
        cycle, disc = self._round_px(image)
        pupil, by_pupil = pupil_and_slope(cycle * radius)
        defocus, by_disc = jinc_and_slope(disc * radius)
        lens, by_lens = log_lens(self.sharp, image.design, image.f_number, radius)
        still = pupil * defocus * np.exp(lens)
        moving, by_blur = sinc_and_slope(image.blur_px[:, None] * self._moving(nodes))
        return still, by_pupil, -by_disc - by_lens, moving, by_blur

    def _round_px(self, image: Image) -> tuple[Array, Array]:
        """The finest cycle that the pupil passes, and the disc of defocus, (m, 1)."""
        sharp, d = self.sharp, image.design
        cycle = image.working * sharp.wavelength_nm[d] * 1e-9 / sharp.pixel_pitch_m[d]
        return cycle[:, None], (sharp.rms_disc_px[d, 1] / image.f_number)[:, None]

    def _moving(self, nodes: Nodes) -> Array:
        """Along part of the folds that motion tells apart."""
        return nodes.along[:, : nodes.n_moving * nodes.radius_cyc_per_px.shape[1]]

    def _seen(self, nodes: Nodes, image: Image) -> tuple[Array, Array]:
        """The transfers of `_transfer` without their slopes."""
        radius, (cycle, disc) = nodes.radius_cyc_per_px, self._round_px(image)
        pitch = self.sharp.lens_pitch_px("rms", f_number=image.f_number, rows=image.design)
        still = diffraction_mtf(radius, cycle_px=cycle) * defocus_mtf(radius, disc_px=disc)
        still *= lens_mtf(radius, lens_pitch_px=pitch[:, None])
        return still, sinc_mtf(self._moving(nodes), width_px=image.blur_px[:, None])

    def _power(self, chunk: Chunk, still: Array, moving: Array, snr: Array) -> Array:
        """(C_t SNR MTF)^2 by node, (m, n_signs, n_moving, n_base)."""
        nodes = chunk.nodes
        seen = np.square(still * (TEXTURE_CONTRAST * snr)[:, None])
        moved = seen[:, None] * np.square(nodes.as_moving(moving))
        return np.asarray(moved[:, None] * nodes.as_folds(chunk.still2))

    def value(self, design: Array, snr: Array, *, f_number: Array, working: Array, blur_s: Array) -> Array:
        """Bit per pixel at these settings, (n,)."""
        seen = snr * self.sharp.texture_gain[design]
        return self._bits(Image(design, seen, f_number, working, self.blur_px(design, blur_s)))

    def _bits(self, image: Image) -> Array:
        """Bit per pixel of images, (m,)."""
        out = np.zeros(len(image.design))
        for chunk in self._chunks(image, self._ends(image)):
            mine = image.take(chunk.rows)
            power = self._power(chunk, *self._seen(chunk.nodes, mine), mine.snr)
            out[chunk.rows] = chunk.nodes.bits(power)
        return out

    def _tangents(self, chunk: Chunk, image: Image) -> Tangents:
        """Integrals of images with the slopes of their logarithms."""
        nodes = chunk.nodes
        still, by_pupil, by_round, moving, by_blur = self._transfer(nodes, image)
        power = self._power(chunk, still, moving, image.snr)
        whole = 1.0 + power
        if chunk.joined == "all":
            bits = nodes.bits(power)[:, None]
        else:
            bits = nodes.sums(log_of_all([power]).reshape(len(power), -1), chunk.joined)
        rising = np.divide(power, whole, out=power)  # half the slope of the integrand in ln MTF
        scale = 2.0 / np.maximum(bits, 1e-300)

        def summed(slope: Array | float) -> Array:
            return nodes.sums((rising * slope).reshape(len(rising), -1), chunk.joined) * scale

        of_radius = (by_pupil + by_round)[:, None, None]
        return Tangents(bits, summed(1.0), summed(of_radius), summed(nodes.as_moving(by_blur)[:, None]))

    def _node_tangents(self, chunk: Chunk, image: Image, sharpest: Image) -> NodeTangents:
        """The transfer of images by node, each factor on its tangent at the image or at the sharpest of a cell."""
        nodes, radius = chunk.nodes, chunk.nodes.radius_cyc_per_px
        (cycle, disc), (least_cycle, least_disc) = self._round_px(image), self._round_px(sharpest)
        pupil_log, by_pupil = on_tangents(pupil_and_slope, cycle * radius, least_cycle * radius, 1.0)
        disc_log, by_disc = on_tangents(jinc_and_slope, disc * radius, least_disc * radius, J1_ZERO / np.pi)
        lens_log, by_lens = log_lens(self.sharp, image.design, image.f_number, radius)
        moving = self._moving(nodes)
        blur_log, by_blur = on_tangents(
            sinc_and_slope, image.blur_px[:, None] * moving, sharpest.blur_px[:, None] * moving, 1.0
        )
        seen = np.log(np.maximum(TEXTURE_CONTRAST * image.snr, 1e-300))[:, None]
        return NodeTangents(
            nodes, chunk.still2, pupil_log + disc_log + lens_log + seen, by_pupil - by_disc - by_lens, blur_log, by_blur
        )

    # ------------------------------------------------------------ cells

    def bound(
        self, design: Array, log_snr: Array, shift_n: Array, shift_t: Array, *, centre_log_snr: Array,
        f_number: tuple[Array, Array, Array], factor: Array, blur_s: tuple[Array, Array], wanted: Array,
        surely: Array,
    ) -> Array:  # fmt: skip
        """Bit per pixel at most, at vertices of cells (n, n_vertices): least convex majorant at hand.

        log_snr : at the vertices, of an affine bound; shift_n, shift_t : ln N and ln time at the vertices from
        the centre; f_number : least, centre, most; blur_s : least and centre; wanted : which vertices count;
        surely : where the tangent is taken at the centre, else where the image is no worse than `SHARP_PX`.
        """
        out = np.zeros(log_snr.shape)
        log_gain = np.log(self.sharp.texture_gain[design])
        log_snr, centre_log_snr = log_snr + log_gain[:, None], centre_log_snr + log_gain
        low, centre, high = f_number
        least, middle = (self.blur_px(design, b) for b in blur_s)
        blur = np.where(surely, middle, np.minimum(middle, np.maximum(least, SHARP_PX)))
        at_n = np.where(surely, centre, np.clip(self.sharp.rms_disc_px[design, 1] / SHARP_PX, centre, high))
        apart = np.array([group.joined == "none" for group in self.groups])[self.group[design]]
        most = log_snr.max(axis=1, initial=-600.0, where=wanted)
        from_snr = np.where(apart, most, centre_log_snr)
        snr = np.exp(np.clip(from_snr, -600.0, 300.0))
        image, sharpest = Image(design, snr, at_n, at_n * factor, blur), Image(design, snr, high, low * factor, least)
        ends = self._ends(image)
        if apart.any():
            of_sharpest = self._ends(sharpest)
            ends = Ends(*(np.where(apart, getattr(of_sharpest, name), getattr(ends, name)) for name in ENDS))
        shift_n = shift_n + np.log(centre / at_n)[:, None]
        shift_t = shift_t + np.log(np.where(blur > 0.0, middle / np.maximum(blur, 1e-300), 1.0))[:, None]
        shift_snr = log_snr - from_snr[:, None]
        dark = np.zeros(len(design), bool)
        for chunk in self._chunks(image, ends):
            mine = image.take(chunk.rows)
            tangents: Tangents | NodeTangents
            if chunk.joined == "none":
                tangents = self._node_tangents(chunk, mine, sharpest.take(chunk.rows))
            else:
                tangents = self._tangents(chunk, mine)
                dark[chunk.rows] = tangents.dark
            for v in range(log_snr.shape[1]):
                on = np.nonzero(wanted[chunk.rows, v])[0]
                here = chunk.rows[on]
                out[here, v] = tangents.at(on, shift_snr[here, v], shift_n[here, v], shift_t[here, v])
        if dark.any():
            brightest = np.exp(np.clip(most[dark], -600.0, 300.0))
            sharpest = Image(design[dark], brightest, high[dark], low[dark] * factor[dark], least[dark])
            out[dark] = self._bits(sharpest)[:, None]
        return out
