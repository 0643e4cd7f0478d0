"""One scene's designs over boxes of settings: what the best point of a box can reach at most, and points.

A box has ranges of f-number, light-collecting time, open shutter and level. Each quantity is bounded at its own
best corner: light at (least N, longest time), diffraction at the least N, defocus at the greatest, motion at the
shortest time, the sun's signal at its most and its veil and level at their least. A box of one point gives the
truth, apart from the gain's effect on noise, which a point's own figures hold.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.bars import StillBars
from uwopt.forward.columns import Columns
from uwopt.forward.flash_times import WHOLE_FLASH
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.model.sharpness import sinc_mtf
from uwopt.solvers.settings import closed_form
from uwopt.solvers.settings.cell_sun import Brightest, Mixture, longest_open_s
from uwopt.solvers.settings.cell_windows import MEETS, balance_window, bars_contrast, figures_at, window_over
from uwopt.solvers.settings.few_pixels import deciding_pixels
from uwopt.solvers.settings.sharp_time import longest_sharp_s
from uwopt.solvers.settings.windows import Sun
from uwopt.tolerances import SLACK

Rows = TypeVar("Rows", bound=Columns)
PIXELS_AT_ONCE = 250_000  # arrays of them, altitude by altitude, stay in the processor's cache: twice as quick


@dataclass(frozen=True)
class Box(Columns):
    """Ranges of settings of m cells in one scene; open times count where the sun shines."""

    n_lo: Array
    n_hi: Array
    t_lo: Array
    t_hi: Array
    open_lo: Array
    open_hi: Array
    u_lo: Array
    u_hi: Array


@dataclass(frozen=True)
class Reach(Columns):
    """What boxes can reach at most in one scene; `alive` is False where they hold no feasible point."""

    alive: Array
    power_w: Array
    snr: Array
    contrast: Array
    x_lo: Array
    x_hi: Array
    x_cap: Array  # by level and saturation alone
    u_lo: Array  # levels in use
    u_hi: Array


@dataclass(frozen=True)
class Points(Columns):
    """Settings in one scene with their figures; `fits` where all requirements hold."""

    chosen: closed_form.Chosen
    fits: Array
    snr: Array
    contrast: Array
    blur_s: Array


def in_blocks(work: Callable[..., Rows], columns: Sequence[Any], rows_at_once: int) -> Rows:
    """What a work makes of columns, row by row, of so many rows at a time; numbers go with every row."""
    count = len(columns[0])
    if count <= rows_at_once:
        return work(*columns)

    def some(column: Any, rows: slice) -> Any:
        if isinstance(column, Columns):
            return column.take(rows)
        return column[rows] if np.ndim(column) else column

    parts = [slice(first, first + rows_at_once) for first in range(0, count, rows_at_once)]
    made = [work(*(some(column, rows) for column in columns)) for rows in parts]
    return made[0].joined(made)


class SceneCells:
    """One scene's designs."""

    def __init__(self, rows: SceneRows, light_limit_w: Array):
        self.sharp, self.light_limit_w = rows.sharp, light_limit_w
        self.sunlit = rows.sunlit
        self.rows = replace(rows, sharp=None)
        if not self.sunlit:  # then no setting changes what bars keep, which is told of all pixels below
            self.rows = deciding_pixels(replace(self.rows, resolve_m=0.0))
        self.flash, self.flash_full_s = rows.flash, rows.flash.full_s
        self.share = rows.share_within(light_limit_w)  # level allowed by mean power
        pixels = 0 if self.rows.worst_e is None else int(np.prod(self.rows.worst_e.shape[1:]))
        self.rows_at_once = max(PIXELS_AT_ONCE // max(pixels, 1), 1)
        self.timed, self.leads_s = rows.timed, np.where(rows.timed, rows.leads_s, 0.0)
        top = np.minimum(rows.max_level, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            most = self.share * (1 + 1e-9) / rows.on_share(rows.time_min_s)
        self.u_max = np.where(rows.kind == PULSED, top, np.minimum(top, np.where(np.isnan(most), np.inf, most)))
        self.u_min = np.where(rows.dims_freely, rows.min_level, 0.0)
        self.constant_window = None
        if not self.sunlit and not np.any(rows.dark_current_e_s > 0):
            self.constant_window = window_over(self.rows, 0.0, 0.0, 0.0, 0.0)
        self.bars = [] if self.sharp is None else [StillBars.of(bars, self.sharp) for bars in rows.bars]
        if self.bars:
            self.least_contrast, self.most_contrast = rows.contrast_within()

    def share_beside(self, d: Array, rows: SceneRows, exposure_s: Array) -> Array:
        """Level that mean power allows beside what cameras draw for an exposure; `rows` are those of `d`."""
        if rows.camera_w is None:
            return np.asarray(self.share[d])
        drawn = rows.full_draw_w
        with np.errstate(divide="ignore", invalid="ignore"):
            taken = np.where(drawn > 0.0, rows.exposing_w(exposure_s) / drawn, 0.0)
        return np.asarray(self.share[d] - taken)

    # ------------------------------------------------------------ time and shutter

    def opened_s(self, d: Array, time_s: Array) -> Array:
        """Open shutter that collects light for a time, of what is not free to be open longer."""
        return self.flash.take(d).open_s(time_s) if self.flash.fade else time_s

    def blurred_s(self, d: Array, time_s: Array) -> Array:
        """Steady light that blurs as much."""
        return self.flash.take(d).blur_s(time_s) if self.flash.fade else time_s

    def within_s(self, d: Array, smear_s: Array) -> Array:
        """Longest time that smears no more than this, under the sun while the shutter is open; -1 stays."""
        if not self.flash.fade:
            return smear_s
        flash, some_s = self.flash.take(d), np.maximum(smear_s, 0.0)
        within = flash.light_s(some_s) if self.sunlit else flash.within_blur_s(some_s)
        return np.where(smear_s < 0.0, smear_s, within)

    def open_range_s(self, d: Array, t_lo: Array, t_hi: Array) -> tuple[Array, Array]:
        """Open shutter that goes with light-collecting times: shortest and longest."""
        rows = self.rows
        offset = rows.exposure_offset_s[d]
        freely = self.freely_open(d, t_lo)
        lo_s, hi_s = self.opened_s(d, t_lo), self.opened_s(d, t_hi)
        around = np.maximum(rows.min_exposure_s[d], lo_s + rows.readout_s[d]) + offset
        most = np.maximum(rows.min_exposure_s[d], hi_s + rows.readout_s[d]) + offset
        if rows.open_max_s is not None:
            most = rows.open_max_s[d]
        return np.where(freely, around, lo_s), np.where(freely, most, hi_s)

    def freely_open(self, d: Array, time_s: Array) -> Array:
        """Whether the shutter may be open longer than the light that is collected."""
        rows = self.rows
        whole = (rows.kind[d] == FLASH) & (time_s >= self.flash_full_s[d] * WHOLE_FLASH)
        return (rows.kind[d] == PULSED) | whole

    def exposure_s(self, d: Array, time_s: Array, open_s: Array) -> Array:
        """Exposure of the longest of these: with the sun what is open, else what the lamps need."""
        rows = self.rows
        if self.sunlit:
            return np.asarray(np.maximum(open_s - rows.exposure_offset_s[d], 0.0))
        lit_s = self.opened_s(d, time_s)
        around = np.maximum(rows.min_exposure_s[d], lit_s + rows.readout_s[d])
        cut = lit_s - rows.exposure_offset_s[d]
        return np.maximum(np.where(self.freely_open(d, time_s), around, cut), 0.0)

    # ------------------------------------------------------------ MTF

    def sharp_enough(
        self, d: Array, n_low: Array, n_high: Array, blur_s: Array, contrast: Array, slack: float
    ) -> Array:
        """Whether all bars arrive at the best of a range of f-numbers, (m,); `contrast` (m, 3)."""
        enough, factor = np.ones(len(d), bool), self.rows.working_factor[d]
        for still in self.bars:
            along, across = still.best_between(d, n_low, n_high, working_factor=factor)
            moved = still.sharp.blur_px_per_s[d] * blur_s[:, None]
            along = along * sinc_mtf(still.bars.frequency_cyc_per_px[d], width_px=moved)
            left = np.minimum(along, across) * (contrast if still.bars.veiled else 1.0)
            enough &= left.min(axis=1) >= still.bars.least * (1 - slack)
        return enough

    def sharp_time_s(self, d: Array, n_low: Array, n_high: Array, *, safe: bool) -> Array:
        """Longest blur time at which the MTF may hold, -1 if none; `safe`: surely holds at that time.

        The contrast is the best that lamps and sun can leave, or the least where it must be safe.
        """
        if not self.bars:
            return np.full(len(d), np.inf)
        seen = (self.least_contrast if safe else self.most_contrast)[d]
        factor = self.rows.working_factor[d]
        return longest_sharp_s(self.bars, d, n_low, n_high, working_factor=factor, contrast=seen, safe=safe)

    # ------------------------------------------------------------ boxes

    def tightened(self, d: Array, box: Box) -> tuple[Box, Array]:
        """The box without times that cannot be, and whether anything is left."""
        t_lo, t_hi, open_lo, open_hi = box.t_lo, box.t_hi, box.open_lo, box.open_hi
        sharp = self.sharp_time_s(d, box.n_lo, box.n_hi, safe=False)
        if self.sunlit:
            free = self.freely_open(d, t_lo)
            least, _ = self.open_range_s(d, t_lo, t_hi)
            open_lo, open_hi = np.maximum(open_lo, least), np.minimum(open_hi, sharp)
            around = open_hi - self.rows.exposure_offset_s[d] - self.rows.readout_s[d]
            t_hi = np.minimum(t_hi, self.within_s(d, np.where(free, around, open_hi)))
            open_lo = np.where(free, open_lo, np.maximum(open_lo, self.opened_s(d, t_lo)))
            t_lo = np.where(free, t_lo, np.maximum(t_lo, self.within_s(d, open_lo)))
            open_hi = np.where(free, open_hi, np.minimum(open_hi, self.opened_s(d, t_hi)))
        else:
            t_hi = np.minimum(t_hi, self.within_s(d, sharp))
        near = 1 + 1e-11
        alive = (t_lo <= t_hi * near) & (open_lo <= open_hi * near)
        t_hi, open_hi = np.maximum(t_hi, t_lo), np.maximum(open_hi, open_lo)
        return replace(box, t_lo=t_lo, t_hi=t_hi, open_lo=open_lo, open_hi=open_hi), alive

    def reach(self, d: Array, box: Box) -> Reach:
        """What tightened boxes can reach."""
        return in_blocks(self._reach, (d, box), self.rows_at_once)

    def _reach(self, d: Array, box: Box) -> Reach:
        rows = self.rows.take(d)
        factor2 = np.square(rows.working_factor)
        n2_lo, n2_hi = np.square(box.n_lo) * factor2, np.square(box.n_hi) * factor2
        y_lo, y_hi = box.open_lo / n2_hi, box.open_hi / n2_lo
        if self.constant_window is not None:
            low, high = (w[d] for w in self.constant_window)
        else:
            shortest = self.exposure_s(d, box.t_lo, box.open_lo)
            longest = self.exposure_s(d, box.t_hi, box.open_hi)
            low, high = window_over(rows, y_lo, y_hi, shortest, longest)
        per_level_lo = rows.light_lm * box.t_lo / n2_hi
        per_level_hi = rows.light_lm * box.t_hi / n2_lo
        timed, duty = self.timed[d], rows.on_share(box.t_lo)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = self.share_beside(d, rows, self.exposure_s(d, box.t_lo, box.open_lo))
            capped = timed | (rows.camera_w is not None)
            top = np.minimum(box.u_hi, np.where(capped, share * (1 + 1e-9) / duty, np.inf))
            top = np.minimum(top, np.where(per_level_lo > 0, high / per_level_lo * (1 + SLACK), np.inf))
            bottom = np.maximum(box.u_lo, low / per_level_hi * (1 - SLACK))
        if self.sunlit and rows.colour_e is not None and np.isfinite(rows.max_white_balance):
            bottom, top = self.balanced_levels(rows, box, bottom, top)
        bottom, top = self.steps(d, bottom, top)
        alive = (
            (bottom <= top * (1 + 4 * SLACK)) & (low <= high * (1 + SLACK)) & np.isfinite(bottom) & (top >= 0)
        )
        with np.errstate(invalid="ignore"):  # lamps without light where no level is in use: dropped
            x_cap = np.minimum(high, top * per_level_hi)
            x_lo = np.maximum(low, bottom * per_level_lo)
        alive &= x_lo <= x_cap * (1 + 4 * SLACK)
        x_cap, x_lo = (np.where(alive, np.maximum(x, 0.0), 0.0) for x in (x_cap, x_lo))
        with np.errstate(divide="ignore", invalid="ignore"):
            least_energy = np.maximum(bottom * duty, low * n2_lo / rows.light_lm * np.minimum(
                1.0 / box.t_hi, rows.rate_hz * (1.0 + self.leads_s[d] / box.t_hi)))  # fmt: skip
        drawn = rows.full_draw_w
        with np.errstate(invalid="ignore"):  # a lamp that draws nothing, at no level: dropped
            power = drawn * np.where(timed, least_energy, bottom) + rows.idle
        if rows.camera_w is not None:
            power = power + rows.exposing_w(self.exposure_s(d, box.t_lo, box.open_lo))
        alive &= np.isfinite(power)
        snr, contrast = self._snr_and_contrast(rows, box, bottom, top, x_lo, x_cap, y_lo, y_hi)
        of_mean = rows.min_snr if rows.worst_e is None else rows.min_snr_mean  # pixels may reach more than the mean has
        alive &= snr >= of_mean * (1 - 1e-9)
        if self.sunlit and any(still.bars.veiled for still in self.bars):
            mixture = self._mixture(rows, box, (bottom, top), (x_lo, x_cap), (y_lo, y_hi))
            seen = np.nan_to_num(mixture.most_contrast(rows)[:, rows.three], nan=1.0) * (1 + SLACK)
            seen = np.minimum(np.minimum(seen, 1.0), self.most_contrast[d] * (1 + SLACK))
            alive &= self.sharp_enough(d, box.n_lo, box.n_hi, box.open_lo, seen, 1e-9)
        return Reach(alive, power, snr, contrast, x_lo, x_cap, high, bottom, top)

    def balanced_levels(self, rows: SceneRows, box: Box, bottom: Array, top: Array) -> tuple[Array, Array]:
        """Levels at which lamps and sun together may be balanced: what decides is X / Y, whatever the f-number."""
        least, most = balance_window(rows, 1.0, 1.0, np.zeros(len(bottom)), np.full(len(bottom), np.inf))
        most_lit, least_lit = self.lit_share(rows, box)
        with np.errstate(divide="ignore", invalid="ignore"):
            from_level = np.where(least > 0.0, least / (rows.light_lm * most_lit) * (1 - SLACK), 0.0)
            to_level = np.where(np.isfinite(most), most / (rows.light_lm * least_lit) * (1 + SLACK), np.inf)
        return np.maximum(bottom, from_level), np.minimum(top, to_level)

    def steps(self, d: Array, bottom: Array, top: Array) -> tuple[Array, Array]:
        """Least and greatest level in use within a range; inf and -inf where there is none."""
        free = self.rows.dims_freely[d]
        levels = self.rows.levels[d]
        inside = (levels >= bottom[:, None] * (1 - 4 * SLACK)) & (levels <= top[:, None] * (1 + 4 * SLACK))
        least = np.where(inside, levels, np.inf).min(axis=1)
        most = np.where(inside, levels, -np.inf).max(axis=1)
        return np.where(free, bottom, least), np.where(free, top, most)

    def _snr_and_contrast(
        self, rows: SceneRows, box: Box, u_lo: Array, u_hi: Array, x_lo: Array, x_hi: Array, y_lo: Array, y_hi: Array
    ) -> tuple[Array, Array]:  # fmt: skip
        """Highest SNR (a ratio) and contrast at the nominal altitude."""
        at = rows.nominal
        lamp, lamp_all = rows.signal_e[:, at], rows.total_e[:, at]
        if not self.sunlit:
            open_s = box.open_lo
            dark_rows = replace(rows, dark_time_s=self._shortest(rows, box, open_s))
            snr = closed_form.nominal_snr(dark_rows, x_hi)
            share = np.where(lamp_all > 0, lamp / np.where(lamp_all > 0, lamp_all, 1.0), 0.0)
            return snr, share
        mixture = self._mixture(rows, box, (u_lo, u_hi), (x_lo, x_hi), (y_lo, y_hi))
        best = np.nan_to_num(mixture.most_contrast(rows)[:, at], nan=0.0)
        return mixture.brightest(self._quiet(rows, box)).snr, np.minimum(best, 1.0)

    def brightest(self, d: Array, box: Box, reach: Reach) -> Brightest:
        """What bounds the SNR of boxes under the sun."""
        rows = self.rows.take(d)
        n_w2 = [np.square(n * rows.working_factor) for n in (box.n_hi, box.n_lo)]
        y = box.open_lo / n_w2[0], box.open_hi / n_w2[1]
        mixture = self._mixture(rows, box, (reach.u_lo, reach.u_hi), (reach.x_lo, reach.x_hi), y)
        return mixture.brightest(self._quiet(rows, box))

    def _quiet(self, rows: SceneRows, box: Box) -> SceneRows:
        """Rows with the least dark current of boxes under the sun."""
        return replace(rows, dark_time_s=self._shortest(rows, box, box.open_lo))

    def _mixture(
        self, rows: SceneRows, box: Box, level: tuple[Array, Array], x: tuple[Array, Array], y: tuple[Array, Array]
    ) -> Mixture:
        """Lamps and sun in boxes, by the ranges of level, X and Y."""
        return Mixture.of(x, y, level, rows, self.lit_share(rows, box))

    def filled_s(self, d: Array, f_number: Array, time_s: Array, u_lo: Array, u_hi: Array) -> Array:
        """Longest open shutter at which the sun and the least light of the lamps do not overfill a pixel, (m,)."""
        rows = self.rows.take(d)
        square = np.square(f_number * rows.working_factor)
        least, _ = self.steps(d, u_lo, u_hi)
        light = np.where(np.isfinite(least), least, 0.0) * rows.light_lm
        free = self.freely_open(d, time_s)
        return longest_open_s(rows, square, np.where(free, light * time_s / square, 0.0), np.where(free, 0.0, light))

    def brightly_s(self, d: Array, f_number: Array, time_s: Array, u_hi: Array) -> Array:
        """Times no longer than the most light at the highest level takes, (m,): the same light in less blur; no sun."""
        rows = self.rows.take(d)
        exposure, square = self.exposure_s(d, time_s, time_s), np.square(f_number * rows.working_factor)
        high = window_over(rows, 0.0, 0.0, exposure, exposure)[1] if self.constant_window is None else (
            self.constant_window[1][d])  # fmt: skip
        with np.errstate(divide="ignore", invalid="ignore"):
            share = self.share_beside(d, rows, exposure)
            _, level = self.steps(d, np.zeros(len(d)), np.minimum(u_hi, share / rows.on_share(time_s)))
            filled = high * (1 - SLACK) * square / (rows.light_lm * level)
        return np.asarray(np.where(filled >= rows.time_min_s, np.minimum(time_s, filled), time_s))

    def lit_share(self, rows: SceneRows, box: Box) -> tuple[Array, Array]:
        """Light-collecting over open time, most and least."""
        free = (rows.kind != CONTINUOUS) & (box.open_hi > box.t_lo)
        return (
            np.where(free, np.minimum(box.t_hi / box.open_lo, 1.0), 1.0),
            np.where(free, box.t_lo / box.open_hi, 1.0),
        )

    def _shortest(self, rows: SceneRows, box: Box, open_s: Array) -> Array:
        """Exposure of the shortest time of boxes."""
        if self.sunlit:
            return np.maximum(open_s - rows.exposure_offset_s, 0.0)
        return np.maximum(rows.exposure_s(box.t_lo), 0.0)

    # ------------------------------------------------------------ points

    def points(
        self, d: Array, f_number: Array, time_s: Array, open_s: Array, u_lo: Array, u_hi: Array,
        share: Array | float,
    ) -> Points:
        """Settings at these f-numbers and times; of the levels that fit the one at `share` of the range."""
        return in_blocks(self._points, (d, f_number, time_s, open_s, u_lo, u_hi, share), self.rows_at_once)

    def _points(
        self, d: Array, f_number: Array, time_s: Array, open_s: Array, u_lo: Array, u_hi: Array,
        share: Array | float,
    ) -> Points:  # fmt: skip
        rows = self.rows.take(d)
        square = np.square(f_number * rows.working_factor)
        level, fits, step, exact_s = self._level(d, rows, square, time_s, open_s, u_lo, u_hi, share)
        late = ~fits & ~rows.dims_freely
        if not self.sunlit and late.any():
            # A step too bright for the time gives the least light in a shorter one; dark current follows it.
            for _ in range(3):
                time_s = np.where(late, exact_s, time_s)
                open_s = time_s
                again, now, _, exact_s = self._level(
                    d, rows, square, time_s, open_s, u_lo, u_hi, share, step=step
                )
            level, fits = np.where(late, again, level), np.where(late, now, fits)
        exposure = self.exposure_s(d, time_s, open_s)
        dark_rows = replace(rows, dark_time_s=exposure)
        y, per_level = open_s / square, rows.light_lm * time_s / square
        level = np.where(fits, level, np.nan)
        light_x = level * per_level
        sun = Sun.at(rows, y) if self.sunlit else None
        gain = closed_form.best_gain(dark_rows, light_x, sun)
        power = closed_form.drawn_power_w(rows, level, time_s, exposure)
        peak = closed_form.peak_power_w(rows, level)
        snr, contrast, holds = figures_at(dark_rows, light_x, gain, sun)
        blur_s = open_s if self.sunlit else self.blurred_s(d, time_s)
        full_w = rows.full_draw_w
        drawn_most = (
            np.where(full_w > 0, self.share[d], 0.0) * full_w
        )  # a flash that never fires draws nothing
        lights_w = power - rows.idle - rows.exposing_w(exposure)
        fits &= holds & (lights_w <= drawn_most * (1 + 2e-9))
        if rows.camera_w is not None:
            fits &= power <= self.light_limit_w[d] * (1 + 2e-9)
        if self.bars:
            seen = bars_contrast(rows, light_x, sun)[:, rows.three] if self.sunlit else self.most_contrast[d]
            fits &= self.sharp_enough(d, f_number, f_number, blur_s, seen, MEETS)
        chosen = closed_form.Chosen(f_number, level, time_s, gain, light_x, power, peak, exposure)
        return Points(chosen, fits, snr, contrast, blur_s)

    def _level(
        self, d: Array, rows: SceneRows, square: Array, time_s: Array, open_s: Array, u_lo: Array, u_hi: Array,
        share: Array | float, step: Array | None = None,
    ) -> tuple[Array, Array, Array, Array]:  # fmt: skip
        """Level at these times, whether one fits; the step that is bright enough, and its time for least light."""
        exposure, y = self.exposure_s(d, time_s, open_s), open_s / square
        if self.constant_window is not None:
            low, high = (w[d] for w in self.constant_window)
        else:
            low, high = window_over(rows, y, y, exposure, exposure)
        per_level = rows.light_lm * time_s / square
        duty = rows.on_share(time_s)
        with np.errstate(divide="ignore", invalid="ignore"):
            least = np.maximum(u_lo, low / per_level)
            allowed = self.share_beside(d, rows, exposure) * (1 + 1e-9) / duty
            top = np.minimum(np.minimum(u_hi, high / per_level), allowed)
            if step is None:
                step, _ = self.steps(d, least, u_hi)
            exact = np.where(np.isfinite(step), low * square / (rows.light_lm * step), time_s)
        bottom, top = self.steps(d, least, top)
        fits = (bottom <= top * (1 + 4 * SLACK)) & np.isfinite(bottom)
        first, last = np.where(fits, bottom, 0.0), np.where(fits, top, 0.0)
        place = np.where(rows.dims_freely | (np.asarray(share) == 1.0), share, 0.0)
        level = first + place * (last - first)
        return level, fits, step, np.clip(
            exact, np.minimum(rows.time_min_s, time_s), np.minimum(1.001 * time_s, np.maximum(rows.time_max_s, time_s))
        )  # fmt: skip


