"""Least power where dark current counts: exposure and dark electrons are settled together.

The window of light X moves with the exposure, because dark electrons are noise, fill the well, and help a wanted
mean level. `settings` answers for dark electrons that are given; taken again with the exposure that it chose it
mostly ends at the optimum, and `surely_least` tells where. Elsewhere `least_power_in_the_dark` looks over the times.

What it rests on, t being the time that collects light and d(t) the dark electrons of the exposure it needs. The light
that SNR asks for grows with d, yet slower than in proportion: twice the electrons of both kinds never have a lower
SNR. Of the sides of the window (`settings.Window`) the other lows and highs fall with d or grow in proportion. So

- the times whose window is not empty are one interval: from where it is bright enough for the level up to
  where dark electrons leave no room for what SNR asks,
- t over low(t) and t over high(t) never fall: a level that is bright enough at some time is at longer ones, and one
  that is too bright at some time is at longer ones.

Each end is then found by halving. A flash that may be cut or whole jumps in its exposure: two ranges of times.
Where a flash fades none of this holds, for its exposure grows faster than its light (`outruns_light`): such designs
are answered with a bound, as those of which a SNR is wanted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.part_columns import FLASH, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.solvers.settings import closed_form, windows
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.windows import Window
from uwopt.tolerances import SLACK

CUTS = 7  # of a range of times at once, in its logarithm
MOST_ROUNDS = 40  # some twenty settle a range of many orders of magnitude
LAST_DIGITS = 2e-14  # of a time: what powers of ratios round
CUT = 1.0 - 2e-9  # of a flash: the longest that still counts as cut


def at_time(rows: SceneRows, time_s: Array) -> SceneRows:
    """The rows with dark current charged for the exposure that collects light for a time."""
    return replace(rows, dark_time_s=np.maximum(rows.exposure_s(time_s), 0.0))


def relaxed(rows: SceneRows) -> SceneRows:
    """Rows for bounds: dark current of the shortest exposure where it harms, of the longest where it helps.

    It is charged as `spare_dark_s`; the dark current that is left must not be charged again. Cameras that are off
    between images draw what the shortest exposure takes.
    """
    shortest, longest = rows.lit_exposures_s
    return replace(rows, dark_time_s=shortest, camera_w=None, spare_dark_s=longest - shortest)


def may_be_cut(rows: SceneRows) -> Array:
    """Which are flashes that may be cut short, and need not, (n,): between these exposures jump."""
    at_least, at_most = (rows.is_whole_flash(time_s) for time_s in (rows.time_min_s, rows.time_max_s))
    return np.asarray((rows.kind == FLASH) & ~at_least & at_most)


def outruns_light(rows: SceneRows) -> Array:
    """Whether dark electrons may grow faster than light: of flashes that fade and may be cut short, (n,)."""
    fades = np.isfinite(rows.flash.decay_s) & (rows.kind == FLASH)
    return np.asarray(fades & ~rows.is_whole_flash(rows.time_min_s) & (rows.dark_current_e_s > 0.0))


# ---------------------------------------------------------------- where the closed form is enough


def surely_least(scenes: list[SceneRows], chosen: list[Chosen], motorised: Array) -> Array:
    """Whether settings of least power for their own dark electrons have the least power of all, (n,).

    `scenes` have the dark electrons of the settings.
    """
    common = np.max([r.n_low for r in scenes], axis=0)
    sure = np.ones(len(common), bool)
    for rows, one in zip(scenes, chosen, strict=True):
        widest = one.f_number <= np.where(motorised, rows.n_low, common) * (1 + SLACK)
        pulsed = rows.kind == PULSED
        least = (rows.dark_current_e_s == 0.0) | (~pulsed & _dimmest(rows, one))
        for holds, of_kind in ((_longest, ~pulsed), (_shortest_pulse, pulsed)):
            asked = np.flatnonzero(of_kind & widest & ~least)
            if len(asked):
                least[asked] = holds(rows.take(asked), one.take(asked))
        sure &= least
    return sure


def _dimmest(rows: SceneRows, one: Chosen) -> Array:
    """Whether no lower level exists."""
    steps = np.where(np.isnan(rows.levels), np.inf, rows.levels).min(axis=1)
    return np.asarray(one.level <= np.where(rows.dims_freely, rows.min_level, steps) * (1 + SLACK))


def _longest(rows: SceneRows, one: Chosen) -> Array:
    """Whether lights that burn, and flashes with one kind of shutter, are too dim one level lower at any time."""
    jumps = may_be_cut(rows)
    lower = np.where(rows.levels < one.level[:, None] * (1 - SLACK), rows.levels, -np.inf).max(axis=1)
    low = windows.window_sides(at_time(rows, rows.time_max_s)).low
    x_per_level = rows.light_lm * rows.time_max_s / np.square(one.f_number * rows.working_factor)
    full_time = one.time_s >= rows.time_max_s * (1 - SLACK)
    outruns = outruns_light(rows)
    if outruns.any():  # least light at any time, whatever its dark electrons
        low = np.where(outruns, windows.window_sides(relaxed(rows)).low, low)
        full_time = np.where(outruns, one.level * x_per_level <= low * (1 + SLACK), full_time)
    reach = lower * x_per_level
    return np.asarray(~jumps & np.where(rows.dims_freely, full_time, reach < low * (1 - SLACK)))


def _shortest_pulse(rows: SceneRows, one: Chosen) -> Array:
    """Whether a pulse is the shortest, and dark current, were it more, would ask for more light only."""
    sides = windows.window_sides(at_time(rows, rows.time_min_s))
    usable = np.where(rows.levels <= rows.max_level[:, None] * (1 + SLACK), rows.levels, -np.inf)
    top = rows.dims_freely | (one.level >= usable.max(axis=1) * (1 - SLACK))
    return np.asarray(top & (sides.for_level <= sides.for_snr))


# ---------------------------------------------------------------- the joint optimum


@dataclass(frozen=True)
class Branch(Columns):
    """Ranges of levels and of times, a row each: every level of every design that it can be set to at some time."""

    design: Array  # whose it is
    option: Array  # which of the design's
    rows: SceneRows
    low_level: Array
    high_level: Array
    first_s: Array
    last_s: Array
    level: Array  # that is asked whether it reaches the window
    x_per_s: Array  # X of a second at full level; NaN until the f-number is known

    def window(self, time_s: Array) -> Window:
        """What bounds X at a time."""
        return windows.window_sides(at_time(self.rows, time_s))

    # Conditions on a time; each holds from some time on, or until some time, and nowhere else.

    def bright_enough(self, time_s: Array) -> Array:
        """Whether the level that is wanted, and its gain, stay within what saturates; from a time on."""
        sides = self.window(time_s)
        above = sides.for_level <= sides.high * (1 + SLACK)
        return np.asarray(above & (sides.for_snr <= sides.gain_at_brightest * (1 + SLACK)))

    def lacks_room(self, time_s: Array) -> Array:
        """Whether dark electrons leave no room for what SNR asks; from a time on."""
        sides = self.window(time_s)
        return ~(np.isfinite(sides.for_snr) & (sides.for_snr <= sides.full * (1 + SLACK)))

    def reaches(self, time_s: Array) -> Array:
        """Whether `level` is bright enough; from a time on."""
        return np.asarray(self.level * time_s * self.x_per_s >= self.window(time_s).low * (1 - SLACK))

    def too_bright(self, time_s: Array) -> Array:
        """Whether even the lowest level is too bright; from a time on."""
        return ~(self.low_level * time_s * self.x_per_s <= self.window(time_s).high * (1 + SLACK))

    def dark_is_no_help(self, time_s: Array) -> Array:
        """Whether a longer exposure would save no light; from a time on."""
        sides = self.window(time_s)
        return np.asarray(
            sides.for_level <= np.maximum(sides.for_snr, self.low_level * time_s * self.x_per_s)
        )

    def first_true(self, holds: Condition, start: Array, end: Array) -> Array:
        """The least time from which on a condition holds; NaN where it does not hold at the end."""
        at_start, at_end = holds(self, start), holds(self, end)
        high = self.halved_where(~at_start & at_end, holds, start, end)[1]
        return np.where(at_start, start, np.where(at_end, high, np.nan))

    def last_false(self, holds: Condition, start: Array, end: Array) -> Array:
        """The longest time until which a condition does not hold; NaN where it holds at the start."""
        at_start, at_end = holds(self, start), holds(self, end)
        low = self.halved_where(~at_start & at_end, holds, start, end)[0]
        return np.where(~at_end, end, np.where(~at_start, low, np.nan))

    def halved_where(
        self, asked: NDArray[np.bool_], holds: Condition, start: Array, end: Array
    ) -> tuple[Array, Array]:
        """As `halved`, of those rows that are asked for; NaN for the rest, which both ends decide."""
        if asked.all():
            return self.halved(holds, start, end)
        low, high = np.full((2, len(asked)), np.nan)
        if len(rows := np.flatnonzero(asked)):
            low[rows], high[rows] = self.take(rows).halved(holds, start[rows], end[rows])
        return low, high

    def halved(self, holds: Condition, start: Array, end: Array) -> tuple[Array, Array]:
        """Both sides of the time from which on a condition holds, to the last digit but two.

        A range is cut into several pieces at a time: a condition on many rows takes hardly longer than on few.
        """
        n = len(self.design)
        wide, share = self.take(np.tile(np.arange(n), CUTS)), np.arange(1, CUTS + 1)[:, None] / (CUTS + 1)
        low, high = start, end
        for _ in range(MOST_ROUNDS):
            if not np.any(high - low > LAST_DIGITS * high):
                break
            times = low * (high / low) ** share
            false = (~holds(wide, times.reshape(-1)).reshape(CUTS, n)).sum(axis=0)
            ends = np.concatenate([low[None], times, high[None]])
            low, high = ends[false, np.arange(n)], ends[false + 1, np.arange(n)]
        return low, high

    # What follows from them.

    def narrowed(self) -> Branch:
        """With the times only at which the window is not empty."""
        first = self.first_true(Branch.bright_enough, self.first_s, self.last_s)
        return replace(
            self, first_s=first, last_s=self.last_false(Branch.lacks_room, self.first_s, self.last_s)
        )

    @property
    def open(self) -> Array:
        """Whether there are times and levels left."""
        return np.asarray((self.first_s <= self.last_s * (1 + SLACK)) & (self.low_level <= self.high_level))

    def f_number_range(self) -> tuple[Array, Array]:
        """f-numbers at which some level and time meet the window; from > to: none."""
        rows = self.rows
        with np.errstate(divide="ignore", invalid="ignore"):
            high, low = self.window(self.first_s).high, self.window(self.last_s).low
            start = np.sqrt(rows.light_lm * self.low_level * self.first_s / high) / rows.working_factor
            end = np.sqrt(rows.light_lm * self.high_level * self.last_s / low) / rows.working_factor
        start = np.where(self.open & (high > 0.0), np.maximum(start, rows.n_low), np.inf)
        end = np.where(low == 0.0, np.inf, end)
        return start, np.where(self.open, np.minimum(end, rows.n_high), -np.inf)

    def by_design(self, values: Array, n: int, missing: float) -> Array:
        """Values of all rows as (n designs, n options); `missing` where a design has no such option."""
        table = np.full((n, int(self.option.max(initial=0)) + 1), missing)
        table[self.design, self.option] = values
        return table

    def settled(self, f_number: Array) -> Chosen:
        """Level, time and gain of least power at a given f-number; NaN where there are none."""
        rows, x_per_s = self.rows, self.rows.light_lm / np.square(f_number * self.rows.working_factor)
        at = replace(self, level=self.high_level, x_per_s=x_per_s)
        first = at.first_true(Branch.reaches, self.first_s, self.last_s)
        last = at.last_false(Branch.too_bright, self.first_s, self.last_s)
        ok = self.open & (first <= last * (1 + SLACK))
        pulsed, where = rows.kind == PULSED, last
        if pulsed.any():
            pulse = at.first_true(Branch.dark_is_no_help, first, last)
            where = np.where(pulsed & ~np.isnan(pulse), pulse, last)
        with np.errstate(divide="ignore", invalid="ignore"):
            level = np.clip(self.window(where).low / (where * x_per_s), self.low_level, self.high_level)
            time = where
            if not pulsed.all():  # pulses are as long as dark electrons help; other light burns as long as it must
                shortest = replace(at, level=level).first_true(Branch.reaches, first, last)
                time = np.where(pulsed, where, shortest)
            time = np.where(ok, time, np.nan)
            level = np.where(ok, level, np.nan)
            light_x = level * time * x_per_s
        seen = at_time(rows, np.where(ok, time, rows.time_min_s))
        power, peak = closed_form.drawn_power_w(rows, level, time), closed_form.peak_power_w(rows, level)
        return Chosen(f_number, level, time, closed_form.best_gain(seen, light_x), light_x, power, peak)


Condition = Callable[[Branch, Array], Array]


def branches(rows: SceneRows) -> Branch:
    """All levels and times of a scene's designs, at which the window is not empty."""
    jumps = may_be_cut(rows)
    spans = [(rows.time_min_s, np.where(jumps, rows.flash.full_s * CUT, rows.time_max_s))]
    if jumps.any():
        spans.append((np.where(jumps, rows.time_max_s, np.inf), np.where(jumps, rows.time_max_s, -1.0)))
    low, high = closed_form.levels_up_to(rows, rows.max_level)
    low_level, high_level = (np.tile(side, len(spans)) for side in (low, high))
    first, last = (
        np.repeat(np.stack(ends, axis=1), low.shape[1], axis=1) for ends in zip(*spans, strict=True)
    )
    design, option = np.nonzero((first <= last * (1 + SLACK)) & ~np.isnan(low_level))
    at = (design, option)
    return Branch(
        design, option, rows.take(design), low_level[at], high_level[at], first[at],
        np.maximum(last[at], first[at]), high_level[at], np.full(len(design), np.nan),
    ).narrowed()  # fmt: skip


def least_power_in_the_dark(scenes: list[SceneRows], motorised: Array) -> tuple[list[Chosen], Array]:
    """Settings of least power that meet every scene, and whether there are any: as `closed_form.least_power`, with
    the dark electrons of the exposure that is chosen."""
    n = len(motorised)
    parts = [branches(rows) for rows in scenes]
    ranges = []
    for branch in parts:
        start, end = branch.f_number_range()
        ranges.append((branch.by_design(start, n, np.inf), branch.by_design(end, n, -np.inf)))
    chosen, feasible = [], np.ones(n, bool)
    for branch, f_number in zip(parts, closed_form.least_f_numbers(ranges, motorised), strict=True):
        one = cheapest(branch, branch.settled(f_number[branch.design]), n)
        feasible &= np.isfinite(f_number) & np.isfinite(one.light_power_w)
        chosen.append(replace(one, f_number=f_number))
    return chosen, feasible


def cheapest(branch: Branch, options: Chosen, n: int) -> Chosen:
    """Of the options of every design the settings of least power, among equals the shortest time."""
    power = branch.by_design(
        np.where(np.isnan(options.light_power_w), np.inf, options.light_power_w), n, np.inf
    )
    time = branch.by_design(np.where(np.isnan(options.time_s), np.inf, options.time_s), n, np.inf)
    time = np.where(power <= power.min(axis=1, keepdims=True) * (1 + SLACK), time, np.inf)
    pick = time.argmin(axis=1)
    return options.with_arrays(lambda column: branch.by_design(column, n, np.nan)[np.arange(n), pick])
