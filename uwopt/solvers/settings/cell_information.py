"""Information over a cell of settings: values on fixed nodes, and upper bounds that are tight to second order.

In the logarithms of f-number and time, ln MTF at any frequency is concave (so are ln of a sinc, of a jinc and
of the pupil's transfer, each falling from 1), and so is ln SNR in ln light. Information is the mean of
(1/2) log2(1 + e^(2z)), convex and rising in z = ln(C_t SNR MTF): with tangents in place of z the mean is convex,
and over a polytope its greatest value is at a vertex.

The nodes do not move with the settings, unlike those of `model.sharpness`, so that a bound of the sum is a
bound of every term; both rules agree to `RULE_ERROR` where the images are worth taking.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.sharpness import SharpRows
from uwopt.model.lateral import spread_mtf
from uwopt.model.sharpness import J1_ZERO, ORDERS, TEXTURE_CONTRAST, sinc_mtf

Array = NDArray[Any]
RULE_ERROR = 3e-5  # relative, between these nodes and those of the model (measured at each answer as well)
MOST_NUMBERS = 1_500_000  # cells x vertices x nodes held at once
SMEARED_PX, SMEARED_RMS_PX = (
    2.0,
    1.0,
)  # motion that ends inside the square is given finer nodes, those of this colour
NULL = 1e-9  # of a transfer: below it a tangent says nothing


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
    log_still: Array  # (n, n_nodes)


def log_pupil(s: Array) -> tuple[Array, Array]:
    """Ln of the diffraction transfer and its slope in ln s; -inf and 0 at the cut-off."""
    inside = np.minimum(s, 1.0 - 1e-12)
    root = np.sqrt(1.0 - inside**2)
    value = (2.0 / np.pi) * (np.arccos(inside) - inside * root)
    dead = (s >= 1.0 - 1e-9) | (value < NULL)
    safe = np.where(dead, 1.0, value)
    return np.where(dead, -np.inf, np.log(safe)), np.where(dead, 0.0, -4.0 / np.pi * inside * root / safe)


def log_disc(a: Array) -> tuple[Array, Array]:
    """Ln of 2 J1(a) / a and its slope in ln a; -inf and 0 from the first null on."""
    from scipy.special import j0, j1  # 0.4 s to import: only information needs it

    small = a < 1e-4
    inside = np.where(small | (a >= J1_ZERO), 1.0, a)
    first = j1(inside)
    value, slope = 2.0 * first / inside, inside * j0(inside) / first - 2.0
    dead = (a >= J1_ZERO) | (value < NULL)
    log = np.where(small, -(a**2) / 8.0, np.log(np.where(dead, 1.0, value)))
    return np.where(dead, -np.inf, log), np.where(dead, 0.0, np.where(small, -(a**2) / 4.0, slope))


def log_box(a: Array) -> tuple[Array, Array]:
    """Ln of sin(pi a) / (pi a) and its slope in ln a; -inf and 0 from the first null on."""
    x = np.pi * np.abs(a)
    small = x < 1e-4
    inside = np.where(small | (x >= np.pi), 1.0, x)
    value = np.sin(inside) / inside
    dead = (x >= np.pi) | (value < NULL)
    log = np.where(small, -(x**2) / 6.0, np.log(np.where(dead, 1.0, value)))
    slope = np.where(small, -(x**2) / 3.0, inside / np.tan(inside) - 1.0)
    return np.where(dead, -np.inf, log), np.where(dead, 0.0, slope)


def log_lens(sharp: SharpRows, design: Array, f_number: Array, radius_cyc_per_px: Array) -> tuple[Array, Array]:
    """Ln of the lens's transfer by radius and its slope in ln 1/N, (n, n_base); both fall with 1/N."""
    scale = -np.log(2.0) * (2.0 * radius_cyc_per_px) ** 2
    pitch2 = np.square(sharp.lens_pitch_px("rms", f_number=f_number, rows=design))
    closed2 = np.square(sharp.lens_blur("rms") * sharp.rated_pitch_px[design])
    return scale * pitch2[:, None], scale * (sharp.aberration_exponent[design] * (pitch2 - closed2))[:, None]


def summed(one: tuple[Array, Array], other: tuple[Array, Array]) -> tuple[Array, Array]:
    """Logarithms and slopes of a product; where one is null the product has no slope."""
    log = one[0] + other[0]
    return log, np.where(np.isfinite(log), one[1] + other[1], 0.0)


class Information:
    """Information per pixel of designs in one scene, at settings and over cells."""

    def __init__(self, sharp: SharpRows, longest_s: Array):
        self.sharp = sharp
        smears = sharp.blur_px_per_s[:, 1] * longest_s > SMEARED_PX
        n = len(sharp.wavelength_nm)
        self.group, self.place = np.zeros(n, int), np.zeros(n, int)
        self.groups: list[TransferGroup] = []
        for rows, spread in sharp.groups("rms"):
            k = np.hypot(sharp.rms_k_along[rows], sharp.rms_k_across[rows])
            rms_px = np.zeros(len(rows)) if spread is None else k * spread.index_rms / (2.0 * np.pi)
            rms_px = np.where(smears[rows], np.maximum(rms_px, SMEARED_RMS_PX), rms_px)
            lowest = -1.0
            for highest, *orders in ORDERS:
                mine = np.nonzero((rms_px > lowest) & (rms_px <= highest))[0]
                lowest = highest
                if len(mine) == 0:
                    continue
                some = rows[mine]
                nodes = Nodes.of((orders[0], orders[1]), both_signs=spread is not None)
                still = sinc_mtf(nodes.along) * sinc_mtf(nodes.across)
                transfer = np.broadcast_to(still, (len(some), len(still)))
                if spread is not None:
                    k_al, k_ac = sharp.rms_k_along[some][:, None], sharp.rms_k_across[some][:, None]
                    transfer = transfer * spread_mtf(k_al * nodes.along + k_ac * nodes.across, table=spread)
                self.group[some], self.place[some] = len(self.groups), np.arange(len(some))
                with np.errstate(divide="ignore"):
                    self.groups.append(TransferGroup(nodes, np.log(np.maximum(transfer, 1e-300))))

    def blur_px(self, design: Array, time_s: Array) -> Array:
        """Motion in a time, nominal altitude."""
        return np.asarray(self.sharp.blur_px_per_s[design, 1] * time_s)

    def _parts(
        self, group: TransferGroup, design: Array, f_number: Array, working: Array, blur: Array
    ) -> list[Any]:
        """Pupil by radius, disc and lens by radius, motion by node: (ln, slope) each.

        (n, n_base), (n, n_base), (n, n_nodes); the slopes in ln N_w, ln 1/N and ln time.
        """
        sharp, nodes = self.sharp, group.nodes
        cycle = working * sharp.wavelength_nm[design] * 1e-9 / sharp.pixel_pitch_m[design]
        disc = np.pi * sharp.rms_disc_px[design, 1] / f_number
        return [
            log_pupil(cycle[:, None] * nodes.radius_cyc_per_px),
            summed(
                log_disc(disc[:, None] * nodes.radius_cyc_per_px),
                log_lens(sharp, design, f_number, nodes.radius_cyc_per_px),
            ),
            log_box(blur[:, None] * nodes.along),
        ]

    def value(self, design: Array, snr: Array, *, f_number: Array, working: Array, blur_s: Array) -> Array:
        """Bit per pixel at these settings, (n,)."""
        out = np.zeros(len(design))
        for group, mine in self._chunks(design, 1):
            d = design[mine]
            parts = self._parts(group, d, f_number[mine], working[mine], self.blur_px(d, blur_s[mine]))
            folds = len(group.nodes.along) // len(group.nodes.radius_cyc_per_px)
            log = np.tile(parts[0][0] + parts[1][0], folds) + parts[2][0] + group.log_still[self.place[d]]
            z = log + np.log(np.maximum(TEXTURE_CONTRAST * snr[mine], 1e-300))[:, None]
            out[mine] = bits(z) @ group.nodes.weight
        return out

    def bound(
        self, design: Array, log_snr: Array, shift_n: Array, shift_t: Array, *, f_number: tuple[Array, Array, Array],
        factor: Array, blur_s: tuple[Array, Array], wanted: Array | None = None,
    ) -> Array:  # fmt: skip
        """Bit per pixel at most, at vertices of cells (n, n_vertices): least convex majorant at hand.

        log_snr : at the vertices, of an affine bound; shift_n, shift_t : ln N and ln time at the vertices from
        the centre; f_number : least, centre, most; blur_s : least and centre; wanted : which vertices count.
        """
        out = np.zeros(log_snr.shape)
        for group, mine in self._chunks(design, log_snr.shape[1] + 4):
            d = design[mine]
            low, centre, high = (f[mine] for f in f_number)
            folds = len(group.nodes.along) // len(group.nodes.radius_cyc_per_px)
            least, middle = (self.blur_px(d, b[mine]) for b in blur_s)
            at = self._parts(group, d, centre, centre * factor[mine], middle)
            sharpest = self._parts(group, d, high, low * factor[mine], least)
            still = group.log_still[self.place[d]]
            best = np.tile(sharpest[0][0] + sharpest[1][0], folds) + sharpest[2][0] + still
            log = np.tile(at[0][0] + at[1][0], folds) + at[2][0] + still
            by_n, by_t = np.tile(at[0][1] - at[1][1], folds), at[2][1]
            live = np.isfinite(log)
            log = np.where(live, log, 0.0)
            n_shift, t_shift = shift_n[mine], shift_t[mine]
            most = (
                log
                + np.maximum(by_n * n_shift.max(axis=1)[:, None], by_n * n_shift.min(axis=1)[:, None])
                + np.maximum(by_t * t_shift.max(axis=1)[:, None], by_t * t_shift.min(axis=1)[:, None])
            )
            # Both are bounds: the tangent unless it is further off at its worst than the other is in the middle.
            tangent = live & (most - best <= best - log)
            base = np.where(tangent, log, best)
            by_n, by_t = np.where(tangent, by_n, 0.0), np.where(tangent, by_t, 0.0)
            snr = log_snr[mine] + np.log(TEXTURE_CONTRAST)
            for v in range(log_snr.shape[1]):
                on = slice(None) if wanted is None else np.nonzero(wanted[mine, v])[0]
                z = base[on] + by_n[on] * n_shift[on, v, None] + by_t[on] * t_shift[on, v, None]
                out[mine[on], v] = bits(z + snr[on, v, None]) @ group.nodes.weight
        return out

    def _chunks(self, design: Array, copies: int) -> list[tuple[TransferGroup, Array]]:
        """Cells by group, few enough at a time."""
        chunks = []
        for index, group in enumerate(self.groups):
            mine = np.nonzero(self.group[design] == index)[0]
            step = max(1, MOST_NUMBERS // (len(group.nodes.along) * copies))
            chunks += [(group, mine[start : start + step]) for start in range(0, len(mine), step)]
        return chunks


def bits(z: Array) -> Array:
    """ln(1 + e^(2z)); the weights hold the half and the unit."""
    return np.asarray(np.log1p(np.exp(np.minimum(2.0 * z, 600.0))))
