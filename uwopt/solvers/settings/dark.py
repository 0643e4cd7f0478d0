"""Least power where dark current counts: exposure and dark electrons are settled together.

The window of light X moves with the exposure, because dark electrons are noise, fill the well, and help a wanted
mean level. `settings` answers for dark electrons that are given; taken again with the exposure that it chose it
mostly ends at the optimum, and `surely_least` tells where. Elsewhere `least_power` looks over the times.

What it rests on, t being the time that collects light and d(t) the dark electrons of the exposure it needs. The light
that SNR asks for grows with d, yet slower than in proportion: twice the electrons of both kinds never have a lower
SNR. Of the sides of the window (`settings.Window`) the other lows and highs fall with d or grow in proportion. So

- the times whose window is not empty are one interval: from where it is bright enough for the level up to
  where dark electrons leave no room for what SNR asks,
- t over low(t) and t over high(t) never fall: a level that is bright enough at some time is at longer ones, and one
  that is too bright at some time is at longer ones.

Each end is then found by halving. A flash that may be cut or whole jumps in its exposure: two ranges of times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.part_columns import FLASH, PULSED
from uwopt.forward.setting_rows import WHOLE_FLASH, SceneRows
from uwopt.solvers.settings import closed_form
from uwopt.solvers.settings.closed_form import Chosen, Window
from uwopt.tolerances import SLACK

Array = NDArray[Any]
HALVINGS = 60  # of a range of times, in its logarithm: to the last digit
CUT = 1.0 - 2e-9  # of a flash: the longest that still counts as cut


def at_time(rows: SceneRows, time_s: Array) -> SceneRows:
    """The rows with dark current charged for the exposure that collects light for a time."""
    return replace(rows, dark_time_s=np.maximum(rows.exposure_s(time_s), 0.0))


def relaxed(rows: SceneRows) -> SceneRows:
    """Rows for bounds: dark current of the shortest exposure where it harms, of the longest where it helps.

    It is charged as `spare_dark_s`; the dark current that is left must not be charged again.
    """
    shortest = np.maximum(rows.exposure_s(rows.time_min_s), 0.0)
    longest = np.maximum(rows.exposure_s(np.maximum(rows.time_max_s, rows.time_min_s)), shortest)
    return replace(rows, dark_time_s=shortest, spare_dark_s=longest - shortest)


# ---------------------------------------------------------------- where the closed form is enough


def surely_least(scenes: list[SceneRows], chosen: list[Chosen], motorised: Array) -> Array:
    """Whether settings of least power for their own dark electrons have the least power of all, (n,).

    `scenes` have the dark electrons of the settings.
    """
    common = np.max([r.n_low for r in scenes], axis=0)
    sure = np.ones(len(common), bool)
    for rows, one in zip(scenes, chosen, strict=True):
        widest = one.f_number <= np.where(motorised, rows.n_low, common) * (1 + SLACK)
        burning = _dimmest(rows, one) | (widest & _longest(rows, one))
        least = np.where(rows.kind == PULSED, widest & _shortest_pulse(rows, one), burning)
        sure &= (rows.dark_current_e_s == 0.0) | least
    return sure


def _dimmest(rows: SceneRows, one: Chosen) -> Array:
    """Whether no lower level exists."""
    steps = np.where(np.isnan(rows.levels), np.inf, rows.levels).min(axis=1)
    return np.asarray(one.level <= np.where(rows.dims_freely, rows.min_level, steps) * (1 + SLACK))


def _longest(rows: SceneRows, one: Chosen) -> Array:
    """Whether lights that burn, and flashes with one kind of shutter, are too dim one level lower at any time."""
    jumps = (rows.kind == FLASH) & (rows.time_min_s < rows.flash_duration_s * WHOLE_FLASH)
    jumps &= rows.time_max_s >= rows.flash_duration_s * WHOLE_FLASH
    lower = np.where(rows.levels < one.level[:, None] * (1 - SLACK), rows.levels, -np.inf).max(axis=1)
    low = closed_form.window_sides(at_time(rows, rows.time_max_s)).low
    reach = rows.light_lm * lower * rows.time_max_s / np.square(one.f_number * rows.working_factor)
    full_time = one.time_s >= rows.time_max_s * (1 - SLACK)
    return np.asarray(~jumps & np.where(rows.dims_freely, full_time, reach < low * (1 - SLACK)))


def _shortest_pulse(rows: SceneRows, one: Chosen) -> Array:
    """Whether a pulse is the shortest, and dark current, were it more, would ask for more light only."""
    sides = closed_form.window_sides(at_time(rows, rows.time_min_s))
    usable = np.where(rows.levels <= rows.max_level[:, None] * (1 + SLACK), rows.levels, -np.inf)
    top = rows.dims_freely | (one.level >= usable.max(axis=1) * (1 - SLACK))
    return np.asarray(top & (sides.for_level <= sides.for_snr))


# ---------------------------------------------------------------- the joint optimum


@dataclass(frozen=True)
class Branch:
    """One range of levels and of times of every design; empty where a level is not to be had or times end first."""

    rows: SceneRows
    low_level: Array
    high_level: Array
    first_s: Array
    last_s: Array
    floor: Array | float  # of SNR, at the nominal altitude

    def window(self, time_s: Array) -> Window:
        """What bounds X at a time."""
        return closed_form.window_sides(at_time(self.rows, time_s), snr_floor=self.floor)

    def narrowed(self) -> Branch:
        """With the times only at which the window is not empty."""

        def bright_enough(time_s: Array) -> Array:
            sides = self.window(time_s)
            above = sides.for_level <= sides.high * (1 + SLACK)
            return above & (sides.for_snr <= sides.gain_at_brightest * (1 + SLACK))

        def has_room(time_s: Array) -> Array:
            sides = self.window(time_s)
            return np.asarray(np.isfinite(sides.for_snr) & (sides.for_snr <= sides.full * (1 + SLACK)))

        first = first_true(bright_enough, self.first_s, self.last_s)
        return replace(self, first_s=first, last_s=last_true(has_room, self.first_s, self.last_s))

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

    def settled(self, f_number: Array) -> Chosen:
        """Level, time and gain of least power at a given f-number; NaN where there are none."""
        rows = self.rows
        per_time = rows.light_lm / np.square(f_number * rows.working_factor)  # X of a second at full level

        def reaches(level: Array) -> Callable[[Array], Array]:
            return lambda time_s: np.asarray(
                level * time_s * per_time >= self.window(time_s).low * (1 - SLACK)
            )

        def fits(time_s: Array) -> Array:
            return np.asarray(self.low_level * time_s * per_time <= self.window(time_s).high * (1 + SLACK))

        def dark_is_no_help(time_s: Array) -> Array:
            sides = self.window(time_s)
            return sides.for_level <= np.maximum(sides.for_snr, self.low_level * time_s * per_time)

        first = first_true(reaches(self.high_level), self.first_s, self.last_s)
        last = last_true(fits, self.first_s, self.last_s)
        ok = self.open & (first <= last * (1 + SLACK))
        pulse = first_true(dark_is_no_help, first, last)
        pulse = np.where(np.isnan(pulse), last, pulse)
        pulsed = rows.kind == PULSED
        with np.errstate(divide="ignore", invalid="ignore"):
            where = np.where(pulsed, pulse, last)
            level = self.window(where).low / (where * per_time)
            level = np.clip(level, self.low_level, self.high_level)
            time = np.where(pulsed, pulse, first_true(reaches(level), first, last))
            time, level = np.where(ok, time, np.nan), np.where(ok, level, np.nan)
            light_x = level * time * per_time
        seen = at_time(rows, np.where(ok, time, rows.time_min_s))
        power = closed_form.drawn_power_w(rows, level, time)
        peak = closed_form.peak_power_w(rows, level)
        return Chosen(f_number, level, time, closed_form.best_gain(seen, light_x), light_x, power, peak)


def first_true(holds: Callable[[Array], Array], start: Array, end: Array) -> Array:
    """The least time from which on a condition holds; NaN where it does not hold at the end."""
    low, high = start, end
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        yes = holds(middle)
        low, high = np.where(yes, low, middle), np.where(yes, middle, high)
    return np.where(holds(start), start, np.where(holds(end), high, np.nan))


def last_true(holds: Callable[[Array], Array], start: Array, end: Array) -> Array:
    """The longest time until which a condition holds; NaN where it does not hold at the start."""
    low, high = start, end
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        yes = holds(middle)
        low, high = np.where(yes, middle, low), np.where(yes, high, middle)
    return np.where(holds(end), end, np.where(holds(start), low, np.nan))


def branches(rows: SceneRows, snr_floor: Array | float) -> list[Branch]:
    """All levels and times of a scene's designs."""
    whole = rows.flash_duration_s * WHOLE_FLASH
    jumps = (rows.kind == FLASH) & (rows.time_min_s < whole) & (rows.time_max_s >= whole)
    spans = [(rows.time_min_s, np.where(jumps, rows.flash_duration_s * CUT, rows.time_max_s))]
    if jumps.any():
        spans.append((np.where(jumps, rows.time_max_s, np.inf), np.where(jumps, rows.time_max_s, -1.0)))
    top = np.minimum(rows.max_level, 1.0)
    made = []
    for column in range(rows.levels.shape[1]):
        step = rows.levels[:, column]
        step = np.where(step <= rows.max_level * (1 + SLACK), step, np.nan)
        free = rows.dims_freely & (column == 0)
        low = np.where(free, rows.min_level, np.where(rows.dims_freely, np.nan, step))
        high = np.where(free, top, low)
        for first, last in spans:
            none = ~(first <= last * (1 + SLACK)) | np.isnan(low)
            ends = np.where(none, 1.0, first), np.where(none, 1.0, np.maximum(last, first))
            made.append(Branch(rows, np.where(none, np.nan, low), high, *ends, snr_floor).narrowed())
    return made


def least_power(
    scenes: list[SceneRows], motorised: Array, *, snr_floor: Array | float = 0.0
) -> tuple[list[Chosen], Array]:
    """Settings of least power that meet every scene, and whether there are any: as `settings.least_power`, with
    the dark electrons of the exposure that is chosen."""
    parts = [branches(rows, snr_floor) for rows in scenes]
    ranges = []
    for some in parts:
        starts, ends = zip(*(branch.f_number_range() for branch in some), strict=True)
        ranges.append((np.stack(starts, axis=1), np.stack(ends, axis=1)))
    common = closed_form.smallest_common_f_number(ranges)
    chosen, feasible = [], np.ones(len(common), bool)
    for some, own in zip(parts, ranges, strict=True):
        f_number = np.where(motorised, closed_form.smallest_common_f_number([own]), common)
        one = cheapest([branch.settled(f_number) for branch in some])
        feasible &= np.isfinite(f_number) & np.isfinite(one.light_power_w)
        chosen.append(one)
    return chosen, feasible


def cheapest(options: list[Chosen]) -> Chosen:
    """Of some settings of every design those of least power, among equals the shortest time."""
    power = np.stack([np.where(np.isnan(c.light_power_w), np.inf, c.light_power_w) for c in options])
    time = np.stack([c.time_s for c in options])
    time = np.where(power <= power.min(axis=0) * (1 + SLACK), time, np.inf)
    pick = np.where(np.isnan(time), np.inf, time).argmin(axis=0)

    def picked(name: str) -> Array:
        return np.asarray(np.stack([getattr(c, name) for c in options])[pick, np.arange(len(pick))])

    names = [name for name in Chosen.__dataclass_fields__ if name != "exposure_s"]
    return Chosen(**{name: picked(name) for name in names})
