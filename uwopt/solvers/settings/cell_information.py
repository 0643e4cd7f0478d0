"""Information over a cell of settings: values on fixed nodes, and upper bounds that are tight to second order.

In the logarithms of f-number and time, ln MTF at any frequency is concave (so are ln of a sinc, of a jinc and
of the pupil's transfer, each falling from 1), and so is ln SNR in ln light. Information is an integral of
(1/2) log2(1 + e^(2z)), z = ln(C_t SNR MTF), over frequency. The integrand's logarithm is concave in z and rises
with it, and z is concave in the settings and the logarithms of the frequencies together, whose volume element is
itself the exponential of a linear function: so the logarithm of the integral is concave in the settings
(Prekopa 1973), and its tangent lies above it. What is bounded is the exponential of that tangent: convex, with its
greatest value over a polytope at a vertex.

Lateral colour falls along every ray from the centre, but not along both frequencies at once: there the rays are
integrals of their own. Where it comes back after a null, every node is. So is it where the transfer ends well inside
the Nyquist square: the sum over the nodes, which is what is bounded, is no longer the integral to `RULE_ERROR`.

The nodes do not move with the settings, unlike those of `model.sharpness`; both rules agree to `RULE_ERROR` where
the images are worth taking.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.sharpness import SharpRows
from uwopt.model.lateral import SpreadTable, spread_mtf
from uwopt.model.sharpness import (
    J1_ZERO,
    ORDERS,
    TEXTURE_CONTRAST,
    defocus_mtf,
    diffraction_mtf,
    jinc_and_slope,
    lens_mtf,
    sinc_and_slope,
    sinc_mtf,
)

Array = NDArray[Any]
RULE_ERROR = 3e-5  # relative, between these nodes and those of the model (measured at each answer as well)
MOST_NUMBERS = 60_000  # cells x nodes held at once, so that arrays stay in the cache
SMEARED_PX, SMEARED_RMS_PX = (
    2.0,
    1.0,
)  # motion that ends inside the square is given finer nodes, those of this colour
SHARP_PX = 1.5  # of motion and of defocus: tangents are taken where the image is no worse, for the nodes' sake
#: Period of the frequency at which pupil or disc end the transfer, and motion, to which the usual nodes and those of
#: smeared images give the integral to `RULE_ERROR` in its curvature, too; beyond, nodes are told apart.
KINK_PX, FINE_KINK_PX, FINE_SMEARED_PX = 2.0, 2.4, 2.2
NULL = 1e-9  # of a transfer: below it a tangent says nothing
DARK_BIT = 1e-12  # of an integral: below it a tangent says nothing
LATERAL_FROM, LATERAL_STEP = 0.1, 0.02  # of colour's phase: a bell below it; steps of its logarithm
BENDS = 1e-4  # of a slope in logarithms: the table is piecewise linear
Joined = Literal["all", "rays", "none"]  # which nodes are one integral whose logarithm is concave


@dataclass(frozen=True)
class Nodes:
    """Frequencies of one rule: `base` radii shared by the octants, their along part and weights [bit]."""

    radius_cyc_per_px: Array  # (n_base,)
    along: Array  # (n_octants * n_base,)
    across: Array
    weight: Array

    @staticmethod
    def of(orders: tuple[int, int], *, both_signs: bool) -> Nodes:
        """Gauss-Legendre in radius and angle of an octant of the Nyquist square, mirrored as needed."""
        (radial, radial_weight), (angular, angular_weight) = (
            ((x + 1.0) / 2.0, w / 2.0) for x, w in (np.polynomial.legendre.leggauss(n) for n in orders)
        )
        phi = angular[:, None] * np.pi / 4.0
        end = 0.5 / np.cos(phi)
        radius = end * radial
        large, small = (radius * np.cos(phi)).ravel(), (radius * np.sin(phi)).ravel()
        weight = (angular_weight[:, None] * np.pi / 4.0 * radial_weight * end * radius).ravel()
        signs = (1.0, -1.0) if both_signs else (1.0,)
        octants = [(a, s * b) for s in signs for a, b in ((large, small), (small, large))]
        scale = 8.0 / len(octants) * 0.5 / np.log(2.0)
        return Nodes(
            radius.ravel(), np.concatenate([a for a, _ in octants]), np.concatenate([b for _, b in octants]),
            np.tile(weight * scale, len(octants)),
        )  # fmt: skip


@dataclass(frozen=True)
class TransferGroup:
    """Designs that share a rule, with what no setting changes of their transfer."""

    nodes: Nodes
    n_radial: int
    joined: Joined
    still2: Array  # (n, n_nodes) squared

    @property
    def folds(self) -> int:
        """Octants."""
        return len(self.nodes.along) // len(self.nodes.radius_cyc_per_px)

    def sums(self, by_node: Array, joined: Joined) -> Array:
        """Nodes (m, n_nodes), weighed, as integrals (m, n_integrals)."""
        weighed = by_node * self.nodes.weight
        if joined == "all":
            return np.asarray(weighed.sum(axis=1, keepdims=True))
        return weighed if joined == "none" else weighed.reshape(len(by_node), -1, self.n_radial).sum(axis=2)


def log_pupil(s: Array) -> tuple[Array, Array]:
    """Ln of the diffraction transfer and its slope in ln s; -inf and 0 at the cut-off."""
    inside = np.minimum(s, 1.0 - 1e-12)
    root = np.sqrt(1.0 - inside**2)
    value = (2.0 / np.pi) * (np.arccos(inside) - inside * root)
    dead = (s >= 1.0 - 1e-9) | (value < NULL)
    safe = np.where(dead, 1.0, value)
    return np.where(dead, -np.inf, np.log(safe)), np.where(dead, 0.0, -4.0 / np.pi * inside * root / safe)


def log_lens(sharp: SharpRows, design: Array, f_number: Array, radius_cyc_per_px: Array) -> tuple[Array, Array]:
    """Ln of the lens's transfer by radius and its slope in ln 1/N, (n, n_base); both fall with 1/N."""
    scale = -np.log(2.0) * (2.0 * radius_cyc_per_px) ** 2
    pitch2 = np.square(sharp.lens_pitch_px("rms", f_number=f_number, rows=design))
    closed2 = np.square(sharp.lens_blur("rms") * sharp.rated_pitch_px[design])
    return scale * pitch2[:, None], scale * (sharp.aberration_exponent[design] * (pitch2 - closed2))[:, None]


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
    """Integrals (m, n_integrals) [bit per px] at a point, and the slopes of their logarithms.

    Of nodes told apart: their powers (C_t SNR MTF)^2 in place of integrals, and the slopes of ln MTF.
    """

    nodes: Array | None  # weights, where they are told apart
    bits: Array
    by_snr: Array | float
    by_n: Array
    by_blur: Array

    def at(self, on: Array, shift_snr: Array, shift_n: Array, shift_blur: Array, dark_bits: Array) -> Array:
        """Bit per px on the tangents, (k,), at shifts (k,) of some rows; `dark_bits` for what was dark."""
        by_snr = self.by_snr if isinstance(self.by_snr, float) else self.by_snr[on]
        rise = by_snr * shift_snr[:, None] + self.by_n[on] * shift_n[:, None]
        rise += self.by_blur[on] * shift_blur[:, None]
        grown = self.bits[on] * np.exp(np.minimum(rise, 600.0))
        if self.nodes is not None:
            grown = np.log1p(grown) * self.nodes
        return np.asarray(np.where(self.dark[on], dark_bits[on], grown).sum(axis=1))

    def or_flat(self, sharpest: Array, shift_n: Array, shift_blur: Array) -> Tangents:
        """Of nodes told apart: their power at the sharpest of the cell, where tangents would be further off.

        Both are bounds: the tangent unless it is further off at its worst than the other is at the point.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            over = np.log(sharpest / self.bits)
        most = sum(
            np.maximum(slope * shift.max(axis=1)[:, None], slope * shift.min(axis=1)[:, None])
            for slope, shift in ((self.by_n, shift_n), (self.by_blur, shift_blur))
        )
        flat = self.dark | ~(most - over <= over)
        by_n, by_blur = (np.where(flat, 0.0, slope) for slope in (self.by_n, self.by_blur))
        return replace(self, bits=np.where(flat, np.maximum(sharpest, DARK_BIT), self.bits), by_n=by_n, by_blur=by_blur)

    @property
    def dark(self) -> Array:
        """Where a tangent says nothing."""
        return np.asarray(self.bits < DARK_BIT)


class Information:
    """Information per pixel of designs in one scene, at settings and over cells."""

    def __init__(self, sharp: SharpRows, longest_s: Array):
        self.sharp = sharp
        n = len(sharp.wavelength_nm)
        self.groups: list[TransferGroup] = []
        self.group, self.place = np.zeros((2, n), int), np.zeros((2, n), int)  # of sharp images, and of smeared ones
        smears = sharp.blur_px_per_s[:, 1] * longest_s > SMEARED_PX
        self.has_fine = np.zeros(n, bool)
        for rows, spread in sharp.groups("rms"):
            k = np.hypot(sharp.rms_k_along[rows], sharp.rms_k_across[rows])
            rms_px = np.zeros(len(rows)) if spread is None else k * spread.index_rms / (2.0 * np.pi)
            self._grouped(0, rows, rms_px, spread)
            mine = smears[rows] | (spread is None)
            self.has_fine[rows[mine]] = True
            self._grouped(1, rows[mine], np.maximum(rms_px[mine], SMEARED_RMS_PX), spread)

    def _grouped(self, smeared: int, rows: Array, rms_px: Array, spread: SpreadTable | None) -> None:
        """Give designs the rule that serves so wide a colour."""
        sharp = self.sharp
        lowest = -1.0
        for highest, *orders in ORDERS:
            some = rows[(rms_px > lowest) & (rms_px <= highest)]
            lowest = highest
            if len(some) == 0:
                continue
            nodes = Nodes.of((orders[0], orders[1]), both_signs=spread is not None)
            still = sinc_mtf(nodes.along) * sinc_mtf(nodes.across)
            if spread is None:
                self._add(smeared, some, TransferGroup(nodes, orders[0], "all", np.square(still)[None, :]))
                continue
            k_al, k_ac = sharp.rms_k_along[some][:, None], sharp.rms_k_across[some][:, None]
            seen = still * spread_mtf(k_al * nodes.along + k_ac * nodes.across, table=spread)
            falls = np.hypot(k_al, k_ac)[:, 0] * np.sqrt(0.5) <= bell_until(spread)
            for joined, which in (("rays", falls), ("none", ~falls)):
                if which.any():
                    group = TransferGroup(nodes, orders[0], joined, np.square(seen[which]))  # type: ignore[arg-type]
                    self._add(smeared, some[which], group)

    def _add(self, smeared: int, rows: Array, group: TransferGroup) -> None:
        self.group[smeared, rows] = len(self.groups)
        self.place[smeared, rows] = np.arange(len(rows)) if len(group.still2) > 1 else 0
        self.groups.append(group)

    def blur_px(self, design: Array, time_s: Array) -> Array:
        """Motion in a time, nominal altitude."""
        return np.asarray(self.sharp.blur_px_per_s[design, 1] * time_s)

    # ------------------------------------------------------------ one rule

    def _transfer(
        self, group: TransferGroup, design: Array, f_numbers: tuple[Array, Array], blur: Array
    ) -> tuple[Array, Array, Array, Array, Array]:
        """Transfer of the lens by radius with its slope in ln N, that of motion by node and its slope in ln blur.

        f_numbers : as engraved and working, those that defocus and diffraction go with; and whether it moves
        """
        sharp, nodes = self.sharp, group.nodes
        f_number, working = f_numbers
        cycle = working * sharp.wavelength_nm[design] * 1e-9 / sharp.pixel_pitch_m[design]
        inside = np.minimum(cycle[:, None] * nodes.radius_cyc_per_px, 1.0 - 1e-12)
        root = np.sqrt(1.0 - inside**2)
        pupil = (2.0 / np.pi) * (np.arccos(inside) - inside * root)
        by_n = (-4.0 / np.pi) * inside * root / np.maximum(pupil, NULL)
        disc = sharp.rms_disc_px[design, 1] / f_number
        defocus, by_disc = jinc_and_slope(disc[:, None] * nodes.radius_cyc_per_px)
        lens, by_lens = log_lens(sharp, design, f_number, nodes.radius_cyc_per_px)
        still = pupil * defocus * np.exp(lens)
        twice = 2 * len(nodes.radius_cyc_per_px)  # the other octants move as these do
        moving, by_blur = sinc_and_slope(blur[:, None] * nodes.along[:twice])
        return still, by_n - by_disc - by_lens, moving, by_blur, disc

    def _seen(
        self, group: TransferGroup, design: Array, f_numbers: tuple[Array, Array], blur: Array
    ) -> tuple[Array, Array]:
        """The transfers of `_transfer` without their slopes."""
        sharp, nodes = self.sharp, group.nodes
        f_number, working = f_numbers
        radius = nodes.radius_cyc_per_px
        cycle = working * sharp.wavelength_nm[design] * 1e-9 / sharp.pixel_pitch_m[design]
        disc = sharp.rms_disc_px[design, 1] / f_number
        pitch = sharp.lens_pitch_px("rms", f_number=f_number, rows=design)
        still = diffraction_mtf(radius, cycle_px=cycle[:, None]) * defocus_mtf(radius, disc_px=disc[:, None])
        still *= lens_mtf(radius, lens_pitch_px=pitch[:, None])
        return still, sinc_mtf(nodes.along[: 2 * len(radius)], width_px=blur[:, None])

    def _power(self, group: TransferGroup, place: Array, still: Array, moving: Array, snr: Array) -> Array:
        """(C_t SNR MTF)^2 by node."""
        power = np.tile(np.square(still), (1, group.folds))
        power *= np.tile(np.square(moving), (1, group.folds // 2))
        power *= group.still2[place]
        power *= np.square(TEXTURE_CONTRAST * snr)[:, None]
        return power

    def value(self, design: Array, snr: Array, *, f_number: Array, working: Array, blur_s: Array) -> Array:
        """Bit per pixel at these settings, (n,)."""
        out = np.zeros(len(design))
        snr = snr * self.sharp.texture_gain[design]
        blur_px = self.blur_px(design, blur_s)
        for group, place, mine, _ in self._chunks(design, self._rule(design, f_number, working, blur_px)):
            still, moving = self._seen(group, design[mine], (f_number[mine], working[mine]), blur_px[mine])
            out[mine] = np.log1p(self._power(group, place, still, moving, snr[mine])) @ group.nodes.weight
        return out

    def _tangents(
        self, group: TransferGroup, design: Array, place: Array, snr: Array, f_number: Array, working: Array,
        blur: Array, joined: Joined,
    ) -> Tangents:  # fmt: skip
        """Integrals at these settings with the slopes of their logarithms."""
        still, by_n, moving, by_blur, _ = self._transfer(group, design, (f_number, working), blur)
        power = self._power(group, place, still, moving, snr)
        n_slope, blur_slope = np.tile(by_n, (1, group.folds)), np.tile(by_blur, (1, group.folds // 2))
        if joined == "none":
            return Tangents(group.nodes.weight, power, 2.0, 2.0 * n_slope, 2.0 * blur_slope)
        bits = group.sums(np.log1p(power), joined)
        rising = np.divide(power, 1.0 + power, out=power)  # half the slope of the integrand in ln MTF
        scale = 2.0 / np.maximum(bits, 1e-300)
        return Tangents(
            None, bits, group.sums(rising, joined) * scale, group.sums(rising * n_slope, joined) * scale,
            group.sums(rising * blur_slope, joined) * scale,
        )  # fmt: skip

    # ------------------------------------------------------------ cells

    def bound(
        self, design: Array, log_snr: Array, shift_n: Array, shift_t: Array, *, centre_log_snr: Array,
        f_number: tuple[Array, Array, Array], factor: Array, blur_s: tuple[Array, Array], wanted: Array | None = None,
        surely: Array | None = None,
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
        blur = np.minimum(middle, np.maximum(least, SHARP_PX))
        at_n = np.clip(self.sharp.rms_disc_px[design, 1] / SHARP_PX, centre, high)
        if surely is not None:
            blur, at_n = np.where(surely, middle, blur), np.where(surely, centre, at_n)
        shift_n = shift_n + np.log(centre / at_n)[:, None]
        shift_t = shift_t + np.log(np.where(blur > 0.0, middle / np.maximum(blur, 1e-300), 1.0))[:, None]
        shift_snr = log_snr - centre_log_snr[:, None]
        snr = np.exp(np.clip(centre_log_snr, -600.0, 300.0))
        for group, place, mine, apart in self._chunks(design, self._rule(design, at_n, at_n * factor, blur)):
            d, joined = design[mine], "none" if apart else group.joined
            at = self._tangents(
                group, d, place, snr[mine], at_n[mine], at_n[mine] * factor[mine], blur[mine], joined
            )
            rest = np.zeros_like(at.bits)
            rows = np.arange(len(mine)) if apart else np.nonzero(at.dark.any(axis=1))[0]
            if len(rows):
                some = mine[rows]
                still, moving = self._seen(group, d[rows], (high[some], low[some] * factor[some]), least[some])
                most = snr[some] if apart else np.exp(np.clip(log_snr[some].max(axis=1), -600.0, 300.0))
                power = self._power(group, place[rows], still, moving, most)
                if apart:
                    at = at.or_flat(power, shift_n[some], shift_t[some])
                else:
                    rest[rows] = group.sums(np.log1p(power), joined)
            for v in range(log_snr.shape[1]):
                on = np.arange(len(mine)) if wanted is None else np.nonzero(wanted[mine, v])[0]
                here = mine[on]
                out[here, v] = at.at(on, shift_snr[here, v], shift_n[here, v], shift_t[here, v], rest)
        return out

    def _rule(self, design: Array, f_number: Array, working: Array, blur_px: Array) -> Array:
        """Which nodes serve images: 0 the usual ones, 1 those of smeared images, 2 these told apart."""
        sharp = self.sharp
        pupil_px = working * sharp.wavelength_nm[design] * 1e-9 / sharp.pixel_pitch_m[design]
        ends_px = np.maximum(pupil_px, np.pi / J1_ZERO * sharp.rms_disc_px[design, 1] / f_number)
        fine = (ends_px >= KINK_PX) | (blur_px > SMEARED_PX)
        apart = (ends_px >= FINE_KINK_PX) | (blur_px > FINE_SMEARED_PX) | ~self.has_fine[design]
        return np.where(fine, np.where(apart, 2, 1), 0)

    def _chunks(self, design: Array, rule: Array) -> list[tuple[TransferGroup, Array, Array, bool]]:
        """Cells or points by group, few at a time: the group, places in it, which they are, whether told apart."""
        chunks = []
        fine = ((rule > 0) & self.has_fine[design]).astype(int)
        of, places = self.group[fine, design], self.place[fine, design]
        for index, group in enumerate(self.groups):
            step = max(1, MOST_NUMBERS // len(group.nodes.along))
            ours = of == index
            for apart in (False, True):
                mine = np.nonzero(ours & ((rule == 2) == apart))[0]
                for start in range(0, len(mine), step):
                    some = mine[start : start + step]
                    chunks.append((group, places[some], some, apart))
        return chunks
