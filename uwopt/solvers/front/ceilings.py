"""Information that no settings of designs exceed, by pieces of their ranges of f-numbers and by what lights can give.

In each piece the SNR is that of its widest aperture, the light's wave that of its widest and the defocus that of its
smallest, the motion that of the shortest time. What is seen then depends on the SNR alone, and designs of which all
else is equal (lamps, numbers of them, ports, limits of power) share one table over it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns, rows_alike
from uwopt.forward.scene_rows import SceneRows
from uwopt.model.information import TEXTURE_CONTRAST
from uwopt.model.lateral import rms_px
from uwopt.solvers.front.hopeful import Hopeful, unhindered
from uwopt.solvers.settings import closed_form, windows
from uwopt.solvers.settings.information import least_blur_s
from uwopt.tolerances import SLACK
from uwopt.units import db_to_ratio

SnrWithin = Callable[[Hopeful, Array], Array]
MOST_ROWS = 100_000  # whose SNR is worked out at a time
#: ln(1 + g^2), g = C_t SNR, that tables know. A transfer m <= 1 tells (1/2) log2(1 + g^2 m^2), convex in it: between
#: two levels information is below their chord.
LEVELS = np.concatenate([[0.0, 0.03, 0.08, 0.16, 0.3, 0.5], np.arange(0.75, 20.1, 0.25)])
#: Factor on the nodes of integrals: bounds need not be as close as figures. What that costs, relative, at most, and
#: with more than so much lateral colour: twice what tests saw, 1e-3 and 4e-3.
ROUGHLY, RULE_SLACK, WIDE_SLACK, NARROW_PX = 0.5, 2e-3, 8e-3, 0.7
#: How closely bounds are drawn in, one after the other: into how many parts each piece is cut, the colour [px rms] of
#: which more counts as so much, and every which level is known.
DRAWN: tuple[tuple[int, float, int], ...] = ((4, NARROW_PX, 4), (4, 2.0, 2), (4, 2.0, 1))
IN_SUN = 2  # of these, for there the SNR of a piece is dear


@dataclass(frozen=True)
class Pieces(Columns):
    """Pieces of the f-numbers of designs within limits of power: rows and columns of (n, k) limits, (m,) each."""

    row: Array
    column: Array
    number: Array
    of: int  # pieces of the whole range

    def cut(self, parts: int) -> Pieces:
        """Each of them cut in parts."""
        row, column = np.repeat(self.row, parts), np.repeat(self.column, parts)
        number = np.repeat(self.number * parts, parts) + np.tile(np.arange(parts), len(self.number))
        return Pieces(row, column, number, self.of * parts)


@dataclass(frozen=True)
class Span:
    """The range of f-numbers of n designs."""

    low: Array
    high: Array

    def ends(self, row: Array, number: Array, of: int) -> tuple[Array, Array]:
        """Both f-numbers of pieces (m,), evenly in the logarithm."""
        low, ratio = self.low[row], (self.high / self.low)[row]
        return low * ratio ** (number / of), low * ratio ** ((number + 1) / of)


def most_information(some: Hopeful, limits_w: Array, wanted: Array, snr_in_sun: SnrWithin) -> Array:
    """Information [bit/m2] that no settings within limits of power (n, k), nan: none, exceed; -inf: there are none.

    wanted : (n, k) below which a bound need not be close
    snr_in_sun : SNR in dB that settings of designs exceed nowhere within a limit each (n,), asked under the sun

    Scenes share the f-number unless the lens is motorised: then each has its own.
    """
    out = np.empty(limits_w.shape)
    apart = some.motorised & (len(some.rows) > 1)
    for mine, groups in ((~apart, [some]), (apart, [some.of_scene(s) for s in range(len(some.rows))])):
        if (which := np.nonzero(mine)[0]).size:
            found = [_most_of(one.take(which), limits_w[which], wanted[which], snr_in_sun) for one in groups]
            out[which] = np.min(found, axis=0)
    return out


def _most_of(some: Hopeful, limits_w: Array, wanted: Array, snr_in_sun: SnrWithin) -> Array:
    """The worst scene's at the best of f-numbers that all scenes share."""
    low, high = np.max([r.n_low for r in some.rows], axis=0), np.min([r.n_high for r in some.rows], axis=0)
    span = Span(low, np.maximum(low, high))
    lit = [None if r.sunlit else Lit.of(r, limits_w - some.camera_power_w[:, None]) for r in some.rows]
    out = np.full(limits_w.shape, -np.inf)
    row, column = np.nonzero(np.isfinite(limits_w))
    pieces, bound = Pieces(row, column, np.zeros(len(row), int), 1), np.full(len(row), np.inf)
    for parts, widest_px, every in DRAWN[: IN_SUN if some.sunlit else None]:
        pieces, bound = pieces.cut(parts), np.repeat(bound, parts)
        ends = span.ends(pieces.row, pieces.number, pieces.of)
        for index, (r, lamps) in enumerate(zip(some.rows, lit, strict=True)):
            if lamps is None:
                snr = _snr_by_cells(some.of_scene(index), limits_w, pieces, ends, snr_in_sun)
            else:
                snr = lamps.snr(pieces, ends[0])
            bound = np.minimum(bound, _seen(r, snr, pieces, span, widest_px, LEVELS[::every]))
        open_ = bound > wanted[pieces.row, pieces.column]
        np.maximum.at(out, (pieces.row[~open_], pieces.column[~open_]), bound[~open_])
        pieces, bound = pieces.take(open_), bound[open_]
    np.maximum.at(out, (pieces.row, pieces.column), bound)
    return out


@dataclass(frozen=True)
class Lit:
    """The most light of lamps within limits of power, in one scene without sun."""

    rows: SceneRows
    least_x: Array  # (n,) of the window; inf: none
    most_x: Array
    open_x: Array  # (n, k) at f-number 1, were no light too much

    @staticmethod
    def of(rows: SceneRows, light_limits_w: Array) -> Lit:
        """Of designs, within limits (n, k) of the power of their lights."""
        (rows,) = unhindered([rows])
        low, high = windows.window(rows)
        one, everything = np.ones((len(low), 1)), np.full(len(low), np.inf)
        open_x = [
            closed_form.light_by_level(rows, one, np.zeros(len(low)), everything, limit_w).max(axis=1)
            for limit_w in light_limits_w.T
        ]
        possible = np.isfinite(low) & (low <= high * (1.0 + SLACK))
        return Lit(replace(rows, sharp=None), np.where(possible, low, np.inf), high, np.stack(open_x, axis=1))

    def snr(self, pieces: Pieces, first: Array) -> Array:
        """SNR with the most light at the wide end of each piece, (m,); 0: no settings."""
        out = np.zeros(len(first))
        light_x = np.minimum(self.open_x[pieces.row, pieces.column] / np.square(first), self.most_x[pieces.row])
        fits = np.nonzero((light_x >= self.least_x[pieces.row] * (1.0 - SLACK)) & (light_x > 0.0))[0]
        for start in range(0, len(fits), MOST_ROWS):
            some = fits[start : start + MOST_ROWS]
            out[some] = closed_form.nominal_snr(self.rows.take(pieces.row[some]), light_x[some])
        return out


def _snr_by_cells(
    some: Hopeful, limits_w: Array, pieces: Pieces, ends: tuple[Array, Array], snr_in_sun: SnrWithin
) -> Array:
    """The same of one scene under the sun."""
    alone = some.take(pieces.row)
    (rows,) = alone.rows
    inside = replace(rows, n_low=np.maximum(rows.n_low, ends[0]), n_high=np.minimum(rows.n_high, ends[1]))
    snr_db = snr_in_sun(replace(alone, rows=[inside]), limits_w[pieces.row, pieces.column])
    return np.where(np.isfinite(snr_db), db_to_ratio(snr_db), 0.0)


def _seen(rows: SceneRows, snr: Array, pieces: Pieces, span: Span, widest_px: float, levels: Array) -> Array:
    """Information [bit/m2] at most at SNR (m,) in pieces of the f-numbers; -inf where that is 0."""
    sharp = rows.sharp
    assert sharp is not None
    out = np.full(len(snr), -np.inf)
    lit = np.nonzero(snr > 0.0)[0]
    if len(lit) == 0:
        return out
    row, number = pieces.row[lit], pieces.number[lit]
    level = np.log1p(np.square(TEXTURE_CONTRAST * snr[lit] * sharp.texture_gain[row]))
    least_s = least_blur_s(rows)
    first, back = rows_alike(
        sharp.wavelength_nm, sharp.pixel_pitch_m, sharp.rated_pitch_px, sharp.aberration_px, sharp.aberration_exponent,
        sharp.rms_disc_px[:, 1], sharp.rms_k_along, sharp.rms_k_across, sharp.spread_index,
        least_s * sharp.blur_px_per_s[:, 1], rows.working_factor, span.low, span.high,
    )  # fmt: skip
    nodes, place = np.unique(back[row] * pieces.of + number, return_inverse=True)
    mine, number = first[nodes // pieces.of], nodes % pieces.of
    wide_end, small_end = span.ends(mine, number, pieces.of)
    place, known = place.reshape(-1), _around(levels, level)
    wanted, below = np.zeros((len(mine), len(known)), bool), _below(known, level)
    wanted[place, below] = wanted[place, below + 1] = True
    table = sharp.take(mine).most_bit_per_px(
        np.sqrt(np.expm1(known)), f_number=small_end, working_f_number=wide_end * rows.working_factor[mine],
        blur_s=least_s[mine], widest_px=widest_px, wanted=wanted, fineness=ROUGHLY,
    )  # fmt: skip
    wide = rms_px(sharp.rms_k_along, sharp.rms_k_across, max((t.index_rms for t in sharp.spreads), default=0.0))
    room = np.where(wide > NARROW_PX, 1.0 + WIDE_SLACK, 1.0 + RULE_SLACK) / sharp.pixel_area_m2
    out[lit] = _on_chords(table, known, place, level) * room[row]
    return out


def _around(levels: Array, wanted: Array) -> Array:
    """Neighbours among levels that hold all that are wanted between them, as far as there are such."""
    begin = min(max(int(np.searchsorted(levels, wanted.min(), side="right")) - 1, 0), len(levels) - 2)
    end = int(np.searchsorted(levels, wanted.max())) + 1
    return levels[begin : max(end, begin + 2)]


def _below(levels: Array, level: Array) -> Array:
    """Places of the levels from which chords to the next begin."""
    return np.clip(np.searchsorted(levels, level, side="right") - 1, 0, len(levels) - 2)


def _on_chords(table: Array, levels: Array, row: Array, level: Array) -> Array:
    """Rows of a table (., n_levels) at levels (m,); inf beyond the last."""
    below = _below(levels, level)
    share = (level - levels[below]) / (levels[below + 1] - levels[below])
    value = table[row, below] + share * (table[row, below + 1] - table[row, below])
    return np.where(level <= levels[-1], value, np.inf)
