"""From shares between 0 and 1 to settings that requirements allow, for many designs at once.

Every gene of a setting is a share of the range that is left once the genes before it are known, so that
almost every vector is a feasible design. Two ways: along the closed-form curve of power against SNR, where
nothing but these two depends on settings; else f-number, time, shutter and level one after the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.part_columns import PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.model.bisection import bisected
from uwopt.solvers.settings import closed_form, windows
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.windows import Sun
from uwopt.tolerances import SLACK

DARK_ROUNDS = 6
DARK_SETTLED_E = 1e-10
FARTHEST = 10.0  # what a design can miss one thing by, in logarithms
SHARP_STEPS = 23  # halvings of the longest time that keeps an image sharp
DIMMEST = 1e-4  # of the most level: where a share of a range that begins at no light begins


@dataclass(frozen=True)
class Shares:
    """Genes of one scene's settings between 0 and 1, (n,)."""

    aperture_frac: Array
    time_frac: Array
    shutter_frac: Array
    level_frac: Array


@dataclass(frozen=True)
class Decoded:
    """Settings by scene with their exposures, and by how much designs miss what they need, 0: nothing."""

    chosen: list[Chosen]
    missing: Array


def log_excess(value: Array, limit: Array) -> Array:
    """By how much a positive value is above its limit, in logarithms; FARTHEST where that cannot be told."""
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = np.log(value) - np.log(np.maximum(limit, 0.0))
    gap = np.where(np.isnan(gap), np.where(value <= limit, 0.0, FARTHEST), gap)
    return np.clip(np.where(gap <= 2e-12, 0.0, gap), 0.0, FARTHEST)


# ---------------------------------------------------------------- along the curve of power and SNR


def on_curve(rows: list[SceneRows], motorised: Array, light_limit_w: Array, share: Array | None) -> Decoded:
    """Least power over an SNR between the least and the greatest that designs reach; `share` None: the least.

    Exact for power, cost, mass, SNR and ground sample: no other settings are better in all of them.
    """
    rows = [replace(r, dark_time_s=np.maximum(r.exposure_s(r.time_min_s), 0.0)) for r in rows]
    chosen: list[Chosen] = []
    feasible = np.zeros(len(motorised), bool)
    for _ in range(DARK_ROUNDS):
        asked = [windows.asked_sides(r) for r in rows]
        chosen, feasible = closed_form.least_power(rows, motorised, asked=asked)
        if share is not None:
            chosen, feasible = _above(rows, asked, chosen, feasible, motorised, light_limit_w, share)
        updated = [closed_form.with_exposure(r, c) for r, c in zip(rows, chosen, strict=True)]
        pairs = list(zip(rows, updated, strict=True))
        shift = [np.abs(windows.dark_e(a) - windows.dark_e(b)).max(initial=0.0) for a, b in pairs]
        if max(shift) <= DARK_SETTLED_E:
            break
        rows = updated
    missing = np.zeros(len(motorised))
    power = np.max([c.light_power_w for c in chosen], axis=0)
    missing[feasible] = log_excess(power[feasible], light_limit_w[feasible] * (1 + 1e-9))
    lost = np.nonzero(~feasible)[0]
    if len(lost):
        missing[lost] = np.maximum(shortfall([r.take(lost) for r in rows], motorised[lost]), 1e-3)
    return Decoded([c.exposed(r) for r, c in zip(rows, chosen, strict=True)], missing)


def _above(
    rows: list[SceneRows], asked: list[windows.Window], least: list[Chosen], feasible: Array, motorised: Array,
    light_limit_w: Array, share: Array,
) -> tuple[list[Chosen], Array]:  # fmt: skip
    """Least power over an SNR at a share of the way from that of least power to the greatest."""
    alive = np.nonzero(feasible)[0]
    if len(alive) == 0:
        return least, feasible
    some, asked = [r.take(alive) for r in rows], [own.take(alive) for own in asked]
    first = [c.take(alive) for c in least]
    exposing_w = np.max([r.exposing_w(r.longest_exposure_s) for r in some], axis=0)
    top = closed_form.greatest_snr(some, motorised[alive], light_limit_w[alive] - exposing_w, asked=asked)
    low = closed_form.worst_snr(some, first)
    reached = np.isfinite(top) & (low > 0)
    top = np.where(reached, np.maximum(top, low), low)
    with np.errstate(divide="ignore", invalid="ignore"):
        floor = np.where(reached, low * (top / low) ** share[alive], low) * (1 - 1e-12)
    higher, fits = closed_form.least_power(some, motorised[alive], snr_floor=np.nan_to_num(floor), asked=asked)
    better = fits & reached & (share[alive] > 0)
    chosen = [c.put(alive[better], h.take(better)) for c, h in zip(least, higher, strict=True)]
    return chosen, feasible


def shortfall(rows: list[SceneRows], motorised: Array) -> Array:
    """How far designs are from having settings at all: light, time and aperture that lack, in logarithms."""
    total = np.zeros(len(motorised))
    starts, ends = [], []
    for r in rows:
        low, high = windows.window(r)
        with np.errstate(invalid="ignore", divide="ignore"):
            least, greatest = closed_form.reach(r)
            dimmest = np.where(np.isnan(least), np.inf, least).min(axis=1)
            brightest = np.where(np.isnan(greatest), -np.inf, greatest).max(axis=1)
            start = np.maximum(np.sqrt(dimmest / high) / r.working_factor, r.n_low)
            end = np.minimum(np.sqrt(brightest / low) / r.working_factor, r.n_high)
        total += log_excess(low, high) + log_excess(r.time_min_s, r.time_max_s)
        total += log_excess(start, end)
        starts.append(start)
        ends.append(end)
    if len(rows) > 1:
        with np.errstate(invalid="ignore"):
            common = log_excess(np.max(starts, axis=0), np.min(ends, axis=0))
        total += np.where(motorised, 0.0, common)
    return total


# ---------------------------------------------------------------- one setting after the other


def one_by_one(
    rows: list[SceneRows], motorised: Array, light_limit_w: Array, shares: list[Shares]
) -> Decoded:
    """F-number, then time, then shutter, then level, each at its share of what is left."""
    scenes = [SceneRange(r, light_limit_w, s) for r, s in zip(rows, shares, strict=True)]
    own = motorised | (len(rows) == 1)
    lowest = np.max([s.n_start for s in scenes], axis=0)
    highest = np.min([s.n_end for s in scenes], axis=0)
    chosen = []
    missing = np.zeros(len(motorised))
    for index, scene in enumerate(scenes):
        start, end = np.where(own, scene.n_start, lowest), np.where(own, scene.n_end, highest)
        missing += log_excess(start, end)
        share = np.where(own, shares[index].aperture_frac, shares[0].aperture_frac)
        f_number = log_between(start, np.maximum(end, start), share)
        settings, lacking = scene.settle(f_number)
        missing += lacking
        chosen.append(settings)
    return Decoded(chosen, missing)


def log_between(low: Array, high: Array, share: Array) -> Array:
    """A share of the way from low to high in logarithms; both ends are met to the last bit."""
    with np.errstate(divide="ignore", invalid="ignore"):
        made = low * (high / low) ** share
    made = np.where(share <= 0.0, low, np.where(share >= 1.0, high, made))
    return np.where(np.isfinite(low) & np.isfinite(high), made, np.nan)


class SceneRange:
    """What one scene leaves open of the settings of n designs."""

    def __init__(self, rows: SceneRows, light_limit_w: Array, shares: Shares):
        self.rows, self.shares = rows, shares
        self.power_share = rows.share_within(light_limit_w)
        self.low: Array | None = None
        self.high: Array | None = None
        if not rows.sunlit:
            self.low, self.high = windows.window(rows)
        self._levels()
        self._f_numbers()

    def _levels(self) -> None:
        """Range of levels; of a lamp with steps the one step that its share picks."""
        rows = self.rows
        top = np.minimum(rows.max_level, 1.0)
        top = np.where(rows.timed, top, np.minimum(top, self.power_share * (1 + 1e-9)))
        usable, _ = closed_form.levels_up_to(rows, top)
        if self.low is not None and self.high is not None:
            reach = closed_form.f_number_ranges(replace(rows, max_level=top), self.low, self.high)
            reachable = reach[0] <= reach[1] * (1 + SLACK)
            helps = reachable & np.isfinite(usable)
            some = np.any(helps, axis=1, keepdims=True)
            usable = np.where(some, np.where(helps, usable, np.nan), usable)
        ordered = np.sort(usable, axis=1)  # NaN last
        count = np.isfinite(ordered).sum(axis=1)
        pick = np.minimum((self.shares.level_frac * count).astype(int), np.maximum(count - 1, 0))
        step = ordered[np.arange(len(pick)), pick]
        free = rows.dims_freely
        self.u_low = np.where(free, rows.min_level, np.nan_to_num(step))
        self.u_high = np.where(free, top, np.nan_to_num(step))

    def _f_numbers(self) -> None:
        """F-numbers at which the levels and times reach the wanted light."""
        rows = self.rows
        self.n_start, self.n_end = rows.n_low, rows.n_high
        if self.low is None or self.high is None:
            return
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = rows.light_lm / np.square(rows.working_factor)
            start = np.sqrt(scale * self.u_low * rows.time_min_s / self.high)
            end = np.sqrt(scale * self._most_light() / self.low)
        end = np.where(self.low <= 0.0, np.inf, end)
        start = np.where(self.high > 0.0, start, np.inf)
        self.n_start = np.maximum(start, rows.n_low)
        self.n_end = np.minimum(end, rows.n_high)

    def _most_light(self) -> Array:
        """Level times time at most; a pulse's energy is held by the mean power as well."""
        rows = self.rows
        most = self.u_high * rows.time_max_s
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(rows.kind == PULSED, np.fmin(most, self.power_share / rows.rate_hz), most)

    def settle(self, f_number: Array) -> tuple[Chosen, Array]:
        """Time, shutter and level at these f-numbers, and what is missing."""
        rows, shares = self.rows, self.shares
        square = np.square(f_number * rows.working_factor)
        t_low, t_high, missing = self._times(f_number, square)
        time_s = log_between(t_low, np.maximum(t_high, t_low), shares.time_frac)
        open_s, exposure_s = self._shutter(f_number, time_s)
        dark_rows = replace(rows, dark_time_s=np.where(np.isfinite(exposure_s), exposure_s, rows.dark_time_s))
        sun = Sun.at(rows, open_s / square) if rows.sunlit else None
        low, high = self._window(dark_rows, sun)
        per_level = rows.light_lm * time_s / square
        with np.errstate(divide="ignore", invalid="ignore"):
            duty = rows.on_share(time_s)
            u_low = np.maximum(self.u_low, low / per_level)
            u_high = np.minimum(
                np.minimum(self.u_high, high / per_level), self.power_share * (1 + 1e-9) / duty
            )
        missing += log_excess(low, high) + log_excess(u_low, u_high)
        u_high = np.maximum(u_high, u_low)
        dims = np.where(rows.dims_freely, shares.level_frac, 0.0)
        level = log_between(np.maximum(u_low, np.where(dims > 0, DIMMEST * u_high, 0.0)), u_high, dims)
        light_x = level * per_level
        power = closed_form.drawn_power_w(rows, level, time_s, exposure_s)
        peak = closed_form.peak_power_w(rows, level)
        gain = closed_form.best_gain(dark_rows, light_x, sun)
        missing = np.where(np.isfinite(light_x) & np.isfinite(gain), missing, np.maximum(missing, FARTHEST))
        return Chosen(f_number, level, time_s, gain, light_x, power, peak, exposure_s), missing

    def _times(self, f_number: Array, square: Array) -> tuple[Array, Array, Array]:
        """Shortest and longest light-collecting time at these f-numbers, and what is missing."""
        rows = self.rows
        sharp_s = self._sharp_s(f_number)
        within = rows.flash.light_s(sharp_s) if rows.sunlit else rows.flash.within_blur_s(sharp_s)
        longest = np.minimum(rows.time_max_s, within)
        shortest = rows.time_min_s
        with np.errstate(divide="ignore", invalid="ignore"):
            affordable = self.power_share / (self.u_low * rows.rate_hz)
        pulsed = (rows.kind == PULSED) & (self.u_low > 0)
        longest = np.where(pulsed, np.fmin(longest, affordable), longest)
        missing = log_excess(shortest, longest)
        if self.low is not None and self.high is not None:
            with np.errstate(divide="ignore", invalid="ignore"):
                need = self.low * square / (rows.light_lm * self.u_high)
                cap = self.high * square / (rows.light_lm * self.u_low)
            need, cap = np.where(self.low <= 0.0, 0.0, need), np.where(self.u_low <= 0.0, np.inf, cap)
            missing += np.where(missing > 0, 0.0, log_excess(need, longest) + log_excess(shortest, cap))
            shortest, longest = np.maximum(shortest, need), np.minimum(longest, cap)
        return shortest, longest, missing

    def _window(self, dark_rows: SceneRows, sun: Sun | None) -> tuple[Array, Array]:
        """The window of light with the dark current and sun of the exposure that was chosen."""
        if self.low is None or self.high is None or np.any(dark_rows.dark_current_e_s > 0):
            return windows.window(dark_rows, sun=sun)
        return self.low, self.high

    def _shutter(self, f_number: Array, time_s: Array) -> tuple[Array, Array]:
        """Time that the shutter is open, offset included, and the exposure to set."""
        rows = self.rows
        needed = rows.exposure_s(time_s)
        if not rows.sunlit or rows.open_max_s is None:
            return needed + rows.exposure_offset_s, np.maximum(needed, 0.0)
        freely = (rows.kind == PULSED) | rows.is_whole_flash(time_s)
        least = needed + rows.exposure_offset_s
        most = np.maximum(np.minimum(rows.open_max_s, self._sharp_s(f_number)), least)
        open_s = np.where(freely, log_between(least, most, self.shares.shutter_frac), least)
        return open_s, np.maximum(open_s - rows.exposure_offset_s, 0.0)

    def _sharp_s(self, f_number: Array) -> Array:
        """Longest time that keeps the wanted MTF at these f-numbers, to a hair; 0 where none does."""
        rows = self.rows
        if not rows.asks_sharpness or rows.sharp is None:
            return np.full(len(f_number), np.inf)
        working = np.where(np.isfinite(f_number), f_number, 1.0)
        longest = np.maximum(rows.time_max_s, 0.0)
        longest = rows.flash.open_s(longest) if rows.sunlit else rows.blur_s(longest)
        longest = np.where(longest > 0, longest, 1.0)

        def is_sharp(blur_s: Array) -> Array:
            return rows.sharp_enough(f_number=working, blur_s=blur_s, slack=0.0)

        sharp_s, _ = bisected(is_sharp, np.zeros(len(f_number)), longest, steps=SHARP_STEPS)
        return np.where(is_sharp(longest), longest, sharp_s)
