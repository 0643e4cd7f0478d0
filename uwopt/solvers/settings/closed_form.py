"""Best settings of given hardware, in closed form, for many designs at once.

Signal is C X with X = light * level * time / N_w^2 [lm s]. Requirements put X into a window
[low, high]; the f-number lies in [N_dof, N_max]; the level in a set. Least power is reached at the
least level whose reach meets the window, at the smallest f-number that fits, then the shortest time
(DESIGN: how the optimum is found, step 3). Scenes share the f-number unless the lens is motorised.

Every kind of light is written as light [lm] times time [s]: a flash of Q lm s and duration tau gives
Q / tau for at most tau. Kinds differ in what power they draw.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.columns import Columns
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.forward.setting_rows import SceneRows
from uwopt.model import light, sensor
from uwopt.model.image_mean import needed_by_most
from uwopt.tolerances import SLACK

Array = NDArray[Any]
Light = Literal["mean", "worst", "red"]  # what an SNR may be asked of


@dataclass(frozen=True)
class Chosen(Columns):
    """Settings of n designs in one scene; NaN where there are none."""

    f_number: Array
    level: Array
    time_s: Array
    gain: Array
    light_x: Array  # X, lm s
    light_power_w: Array
    peak_power_w: Array
    exposure_s: Array | None = None  # None: what the lamps need, `SceneRows.exposure_s`


def dark_e(rows: SceneRows) -> Array:
    """Dark electrons in the exposure of the rows, almost always under 1."""
    return np.asarray(rows.dark_current_e_s * rows.dark_time_s)


def with_exposure(rows: SceneRows, chosen: Chosen) -> SceneRows:
    """The rows with dark current charged for the exposure that was chosen; infeasible ones stay as they are."""
    exposure = rows.exposure_s(chosen.time_s)
    return replace(rows, dark_time_s=np.where(np.isfinite(exposure), exposure, rows.dark_time_s))


@dataclass(frozen=True)
class Sun:
    """Electrons of the sun at one choice of shutter and f-number, image mean by altitude (n, n_altitudes)."""

    signal_e: Array
    total_e: Array
    worst_signal_e: Array | None = None  # (n, n_altitudes, n_pixels)
    worst_total_e: Array | None = None
    colour_e: Array | None = None  # (n, n_altitudes, n_channels), red first
    red_total_e: Array | None = None

    @staticmethod
    def at(rows: SceneRows, open_over_n2_s: Array) -> Sun | None:
        """With the shutter open for a time, over the square of the working f-number; None without sun."""
        if rows.sun_signal_e_s is None or rows.sun_veil_e_s is None:
            return None
        share = open_over_n2_s[:, None]
        signal, veil = rows.sun_signal_e_s * share, rows.sun_veil_e_s * share
        made = Sun(signal, signal + veil)
        if rows.sun_colour_e_s is not None and rows.sun_red_veil_e_s is not None:
            colour = rows.sun_colour_e_s * share[:, None]
            made = replace(made, colour_e=colour, red_total_e=colour[:, :, 0] + rows.sun_red_veil_e_s * share)
        if rows.worst_sun_signal_e_s is None or rows.worst_sun_veil_e_s is None:
            return made
        worst, over = (c * share[:, None] for c in (rows.worst_sun_signal_e_s, rows.worst_sun_veil_e_s))
        return replace(made, worst_signal_e=worst, worst_total_e=worst + over)


@dataclass(frozen=True)
class Window:
    """What bounds X in each scene's window; more dark electrons raise `for_snr` and lower the other two of the first
    three, while `gain_at_brightest` grows in proportion to them."""

    for_level: Array  # least X at the highest gain, for the wanted mean level
    for_snr: Array
    full: Array  # most X: wells, full scale, the wanted level at the lowest gain
    gain_at_brightest: Array  # most X: the gain of the wanted level must not saturate at another altitude

    @property
    def low(self) -> Array:
        """Least X."""
        return np.maximum(self.for_level, self.for_snr)

    @property
    def high(self) -> Array:
        """Most X."""
        return np.minimum(self.full, self.gain_at_brightest)


def window(rows: SceneRows, *, snr_floor: Array | float = 0.0, sun: Sun | None = None) -> tuple[Array, Array]:
    """Lowest and highest X that the requirements on SNR, level and saturation allow; inf: none does.

    `snr_floor` is wanted at the nominal altitude beside the mission's own requirement over all.
    """
    sides = window_sides(rows, snr_floor=snr_floor, sun=sun)
    return sides.low, sides.high


def window_sides(rows: SceneRows, *, snr_floor: Array | float = 0.0, sun: Sun | None = None) -> Window:
    """The window of X by what bounds it, as `window` takes its arguments."""
    total = rows.bright_e
    nominal = total[:, rows.nominal]
    dark = dark_e(rows)
    level_dark = dark if rows.spare_dark_s is None else dark + rows.dark_current_e_s * rows.spare_dark_s
    other = np.zeros_like(total) if sun is None else sun.total_e
    other_nominal = other[:, rows.nominal] + level_dark
    headroom_dn = rows.full_scale_dn / rows.highlight_ratio - rows.black_level_dn
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        well = (rows.well_e / rows.highlight_ratio - dark)[:, None]
        full = ((well - other) / total).min(axis=1)
        brightest = np.full(len(nominal), np.inf)
        for_level, for_snr = np.zeros(len(nominal)), np.zeros(len(nominal))
        if rows.mean_level is None:
            scale = (headroom_dn / rows.least_dn_per_e - dark)[:, None]
            full = np.minimum(full, ((scale - other) / total).min(axis=1))
        else:
            wanted_dn = rows.mean_level * rows.full_scale_dn - rows.black_level_dn
            most_e = wanted_dn / rows.least_dn_per_e - other[:, rows.nominal] - dark
            full = np.minimum(full, most_e / nominal)
            least_e = wanted_dn / (rows.gain_dn_per_e * rows.max_gain) - other_nominal
            if not rows.optimistic:
                for_level = least_e / nominal
                # The gain follows the nominal level; the brightest altitude must not saturate with it.
                excess = wanted_dn[:, None] * total - (headroom_dn * nominal)[:, None]
                spare = (headroom_dn * other_nominal)[:, None] - wanted_dn[:, None] * (
                    other + level_dark[:, None]
                )
                steep = np.abs(excess) > SLACK * wanted_dn[:, None] * total
                brightest = np.where(steep & (excess > 0), spare / excess, np.inf).min(axis=1)
                for_level = np.maximum(
                    for_level, np.where(steep & (excess < 0), spare / excess, 0.0).max(axis=1)
                )
            elif rows.most_veil_e is not None:
                for_level = least_e / (rows.signal_e + rows.most_veil_e)[:, rows.nominal]
        for altitude in range(rows.signal_e.shape[1]):
            for_snr = np.maximum(for_snr, light_asked_for(rows, altitude, sun=sun))
        for_snr = np.maximum(for_snr, light_for_snr(rows, rows.nominal, snr_floor, of="mean", sun=sun))
    if rows.min_contrast > 0.0 and sun is None:
        full = np.where(contrast(rows) < rows.min_contrast * (1 - 1e-9), -np.inf, full)
    lows = (np.maximum(np.where(np.isnan(low), np.inf, low), 0.0) for low in (for_level, for_snr))
    highs = (np.where(np.isnan(high), -np.inf, high) for high in (full, brightest))
    return Window(*lows, *highs)


def contrast(rows: SceneRows) -> Array:
    """Image-forming over all light of the lamps, image mean, at the worst altitude; no setting changes it."""
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (rows.signal_e / rows.total_e).min(axis=1)
    return np.where(np.isfinite(share), share, 0.0)


def nominal_contrast(rows: SceneRows) -> Array:
    """Image-forming over all light of the lamps, image mean at the nominal altitude."""
    every = rows.total_e[:, rows.nominal]
    lit = every > 0
    return np.where(lit, rows.signal_e[:, rows.nominal] / np.where(lit, every, 1.0), 0.0)


def light_asked_for(rows: SceneRows, altitude: int, *, sun: Sun | None = None, never: float = np.inf) -> Array:
    """Least X that reaches every SNR that the mission asks for at one altitude: of mean or pixels, and of red."""
    of: Light = "mean" if rows.worst_e is None else "worst"
    wanted = light_for_snr(rows, altitude, rows.min_snr, of=of, sun=sun, never=never)
    if rows.min_snr_red > 0.0:
        red = light_for_snr(rows, altitude, rows.min_snr_red, of="red", sun=sun, never=never)
        wanted = np.maximum(wanted, red)
    return wanted


def light_for_snr(
    rows: SceneRows, altitude: int, snr: Array | float, *, of: Light, sun: Sun | None = None, never: float = np.inf
) -> Array:
    """Least X that reaches an SNR at one altitude, with the gain at its best; at all its pixels that may not miss it.

    All but k pixels reach it from the X that is the (k + 1)-th greatest of theirs: see `light_of_each`. `never` is what
    a pixel asks for that no X serves.
    """
    each = light_of_each(rows, altitude, snr, of=of, sun=sun)
    may_miss = rows.may_miss if of == "worst" and rows.worst_e is not None else 0
    return needed_by_most(np.where(np.isfinite(each), each, never), may_miss)


def light_of_each(
    rows: SceneRows, altitude: int, snr: Array | float, *, of: Light, sun: Sun | None = None
) -> Array:
    """Least X at which each pixel reaches an SNR at one altitude, (n, n_pixels); of what is no pixel one column.

    The gain lowers quantisation noise; it is as high as the wanted mean level or saturation lets it
    be. Up to the X where the highest gain fills the range, that gain counts; beyond it the noise
    follows the level. SNR grows with X throughout, so the larger of the two answers that apply holds. `of`: the
    image's mean, the pixels that the SNR is asked of, or the red channel.
    """
    at_worst = of == "worst" and rows.worst_e is not None
    if at_worst and rows.worst_e is not None:
        signal = rows.worst_e[:, altitude]
        veil: Any = 0.0 if rows.worst_veil_e is None else rows.worst_veil_e[:, altitude]
    elif of == "red":
        assert rows.colour_e is not None
        signal = rows.colour_e[:, altitude, 0]
        veil = 0.0 if rows.red_veil_e is None else rows.red_veil_e[:, altitude]
    else:
        signal = rows.signal_e[:, altitude]
        veil = 0.0 if rows.veil_e is None else rows.veil_e[:, altitude]
    if signal.ndim == 1:
        signal = signal[:, None]
        veil = veil if np.ndim(veil) == 0 else veil[:, None]
    dark = dark_e(rows)[:, None]
    common: dict[str, Any] = dict(
        read_noise_e=rows.read_noise_e[:, None],
        dark_e=dark,
        prnu_frac=rows.prnu_frac[:, None],
        signal_per_light_e=signal,
        total_per_light_e=signal + veil,
    )
    other = np.zeros((len(signal), 1))
    if sun is not None:
        picked = (sun.signal_e, sun.total_e)
        if at_worst and sun.worst_signal_e is not None and sun.worst_total_e is not None:
            picked = (sun.worst_signal_e, sun.worst_total_e)
        elif of == "red" and sun.colour_e is not None and sun.red_total_e is not None:
            picked = (sun.colour_e[:, :, 0], sun.red_total_e)
        one, every = (p[:, altitude] if p.ndim == 3 else p[:, altitude, None] for p in picked)
        common.update(other_signal_e=one, other_light_e=every)
        other = sun.total_e
    wanted = np.reshape(np.asarray(snr, float), (-1, 1))
    total = rows.total_e
    if rows.mean_level is not None:
        wanted_dn = rows.mean_level * rows.full_scale_dn - rows.black_level_dn
        return np.asarray(
            sensor.light_for_snr(
                wanted,
                level_per_light_e=total[:, rows.nominal, None],
                level_dn=wanted_dn[:, None],
                other_level_e=other[:, min(rows.nominal, other.shape[1] - 1), None],
                **common,
            )
        )
    brightest = rows.bright_e.max(axis=1)[:, None]
    other_brightest = other.max(axis=1)[:, None]
    headroom_dn = (rows.full_scale_dn / rows.highlight_ratio - rows.black_level_dn)[:, None]
    top_gain = (rows.gain_dn_per_e * rows.max_gain)[:, None]
    fills = (headroom_dn / top_gain - dark - other_brightest) / brightest
    at_top_gain = sensor.light_for_snr(wanted, gain_dn_per_e=top_gain, **common)
    following = sensor.light_for_snr(
        wanted, level_per_light_e=brightest, level_dn=headroom_dn, other_level_e=other_brightest, **common
    )
    return np.where(at_top_gain <= fills, at_top_gain, np.maximum(following, fills))


def reach(rows: SceneRows) -> tuple[Array, Array]:
    """Least and greatest light * time [lm s] at each level, (n, n_levels); NaN where there is no level.

    A lamp that dims freely has one entry from its least to its greatest level.
    """
    low_level = np.where(rows.dims_freely[:, None], np.nan, rows.levels)
    high_level = np.where(low_level <= rows.max_level[:, None] * (1 + SLACK), low_level, np.nan)
    low_level = np.where(np.isnan(high_level), np.nan, low_level)
    free = rows.dims_freely & (rows.min_level <= rows.max_level)
    low_level[:, 0] = np.where(free, rows.min_level, low_level[:, 0])
    high_level[:, 0] = np.where(free, np.minimum(rows.max_level, 1.0), high_level[:, 0])
    usable = rows.time_min_s <= rows.time_max_s * (1 + SLACK)
    light = np.where(usable, rows.light_lm, np.nan)[:, None]
    return low_level * light * rows.time_min_s[:, None], high_level * light * rows.time_max_s[:, None]


def f_number_ranges(rows: SceneRows, low: Array, high: Array) -> tuple[Array, Array]:
    """For each level the f-numbers at which its reach meets the window; from > to: none."""
    least, greatest = reach(rows)
    with np.errstate(divide="ignore", invalid="ignore"):
        start = np.sqrt(least / high[:, None]) / rows.working_factor[:, None]
        end = np.sqrt(greatest / low[:, None]) / rows.working_factor[:, None]
    end = np.where(low[:, None] == 0.0, np.inf, end)
    start = np.where(high[:, None] > 0.0, start, np.inf)
    closed = np.isnan(least) | (low > high * (1 + SLACK))[:, None] | ~np.isfinite(low)[:, None]
    start = np.where(closed, np.inf, np.maximum(start, rows.n_low[:, None]))
    end = np.where(closed, -np.inf, np.minimum(end, rows.n_high[:, None]))
    return start, end


def smallest_common_f_number(ranges: list[tuple[Array, Array]]) -> Array:
    """The smallest f-number that lies in some range of every scene; NaN where there is none.

    The smallest is the start of one of the ranges, so only those are tried.
    """
    tried = np.concatenate([start for start, _ in ranges], axis=1)
    fits = np.isfinite(tried)
    for start, end in ranges:
        inside = (tried[:, :, None] >= start[:, None, :] * (1 - SLACK)) & (
            tried[:, :, None] <= end[:, None, :] * (1 + SLACK)
        )
        fits &= inside.any(axis=2)
    best = np.where(fits, tried, np.inf).min(axis=1)
    return np.where(np.isfinite(best), best, np.nan)


def settle(rows: SceneRows, f_number: Array, low: Array, high: Array) -> Chosen:
    """Level, time and gain of least power at a given f-number."""
    square = np.square(f_number * rows.working_factor)
    with np.errstate(divide="ignore", invalid="ignore"):
        need = low * square / rows.light_lm  # level * time
        cap = high * square / rows.light_lm
        level = np.where(rows.dims_freely, free_level(rows, need), stepped_level(rows, need, cap))
        time = np.fmax(rows.time_min_s, need / level)  # no light needed: level 0, the shortest time
        light_x = rows.light_lm * level * time / square
    power, peak = drawn_power_w(rows, level, time), peak_power_w(rows, level)
    return Chosen(f_number, level, time, best_gain(rows, light_x), light_x, power, peak)


def free_level(rows: SceneRows, need: Array) -> Array:
    """Least power of a lamp that dims freely: the longest time; for a pulsed LED the shortest pulse."""
    top = np.minimum(rows.max_level, 1.0)
    longest = np.clip(need / rows.time_max_s, rows.min_level, top)
    shortest = np.clip(need / rows.time_min_s, rows.min_level, top)
    return np.where(rows.kind == PULSED, shortest, longest)


def stepped_level(rows: SceneRows, need: Array, cap: Array) -> Array:
    """The step of least power; of a pulsed LED the one that wastes least, then the shortest pulse."""
    levels = np.where(rows.levels <= rows.max_level[:, None] * (1 + SLACK), rows.levels, np.nan)
    reaches = levels * rows.time_max_s[:, None] >= need[:, None] * (1 - SLACK)
    fits = reaches & (levels * rows.time_min_s[:, None] <= cap[:, None] * (1 + SLACK))
    energy = np.maximum(levels * rows.time_min_s[:, None], need[:, None])
    pulsed = (rows.kind == PULSED)[:, None]
    merit = np.where(pulsed, energy * (1.0 - 1e-13 * np.nan_to_num(levels)), levels)
    merit = np.where(fits, merit, np.inf)
    pick = merit.argmin(axis=1)
    rows_index = np.arange(len(pick))
    return np.where(np.isfinite(merit[rows_index, pick]), levels[rows_index, pick], np.nan)


def drawn_power_w(rows: SceneRows, level: Array, time_s: Array) -> Array:
    """Mean electrical power of all lights (PHYSICS section 1)."""
    burning = light.continuous_power_w(level, full_power_w=rows.full_power_w, count=1) * rows.on_share(time_s)
    flashing = light.flash_power_w(
        rows.pulse_energy_j * level, count=1, frame_rate_hz=rows.rate_hz, charging_efficiency=1.0
    )
    return np.where(rows.kind == FLASH, flashing, burning) + rows.idle


def peak_power_w(rows: SceneRows, level: Array) -> Array:
    """Peak electrical power of all lights."""
    return np.where(rows.kind == FLASH, rows.pulse_energy_j * level * rows.rate_hz, rows.full_power_w * level)


def best_gain(rows: SceneRows, light_x: Array, sun: Sun | None = None) -> Array:
    """The gain that gives the wanted mean level; without one, the highest that does not saturate."""
    dark = dark_e(rows)
    every = rows.bright_e * light_x[:, None]
    if sun is not None:
        every = every + sun.total_e
    if rows.mean_level is not None:
        level_e = every[:, rows.nominal] + dark
        wanted_dn = rows.mean_level * rows.full_scale_dn - rows.black_level_dn
    else:
        level_e = every.max(axis=1) + dark
        wanted_dn = rows.full_scale_dn / rows.highlight_ratio - rows.black_level_dn
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.clip(wanted_dn / (rows.gain_dn_per_e * level_e), rows.min_gain, rows.max_gain)


def least_power(
    scenes: list[SceneRows], motorised: Array, *, snr_floor: Array | float = 0.0
) -> tuple[list[Chosen], Array]:
    """Settings of least power that meet every scene, and whether there are any.

    The f-number is common to all scenes where the lens is not motorised.
    """
    windows = [window(rows, snr_floor=snr_floor) for rows in scenes]
    ranges = [f_number_ranges(rows, low, high) for rows, (low, high) in zip(scenes, windows, strict=True)]
    common = smallest_common_f_number(ranges)
    chosen = []
    feasible = np.ones(len(common), bool)
    for rows, (low, high), own in zip(scenes, windows, ranges, strict=True):
        f_number = (
            common if len(scenes) == 1 else np.where(motorised, smallest_common_f_number([own]), common)
        )
        settings = settle(rows, f_number, low, high)
        feasible &= np.isfinite(f_number) & np.isfinite(settings.level) & np.isfinite(settings.light_power_w)
        chosen.append(settings)
    return chosen, feasible


def greatest_snr(scenes: list[SceneRows], motorised: Array, power_limit_w: Array) -> Array:
    """Highest SNR at the nominal altitude that all scenes can reach within their light power.

    power_limit_w : (n,), or (n, k) of k limits each, nan: none; the answer has its shape, nan where there is none.

    The worst scene counts. At a given level more light comes through a smaller f-number, so the best is
    where some level's range of f-numbers starts; each such start is tried. Of one scene each level has its own.
    """
    windows = [window(rows) for rows in scenes]
    ranges = [f_number_ranges(rows, low, high) for rows, (low, high) in zip(scenes, windows, strict=True)]
    starts = [start for start, _ in ranges]

    def within(limit_w: Array) -> Array:
        own = [
            brightest_snr(rows, start, low, high, limit_w)
            for rows, start, (low, high) in zip(scenes, starts, windows, strict=True)
            if len(scenes) == 1 or motorised.any()
        ]
        if len(scenes) == 1:
            return own[0]
        tried = np.concatenate(starts, axis=1)
        common = np.min([
            best_over(rows, tried, low, high, limit_w) for rows, (low, high) in zip(scenes, windows, strict=True)
        ], axis=0).max(axis=1)  # fmt: skip
        return np.where(motorised, np.min(own, axis=0), common) if own else np.asarray(common)

    if power_limit_w.ndim == 1:
        best = within(power_limit_w)
    else:
        best = np.stack([within(limit_w) for limit_w in power_limit_w.T], axis=1)
    return np.where(np.isfinite(best) & ~np.isnan(power_limit_w), best, np.nan)


def brightest_snr(rows: SceneRows, starts: Array, low: Array, high: Array, power_limit_w: Array) -> Array:
    """Nominal SNR with the most light of any level at its own smallest f-number (n, n_levels), -inf: none; (n,)."""
    inside = np.isfinite(starts) & (starts <= (rows.n_high * (1 + SLACK))[:, None])
    light_x = light_by_level(rows, np.where(inside, starts, np.nan), low, high, power_limit_w).max(axis=1)
    found = np.isfinite(light_x)  # SNR grows with the light
    return np.where(found, nominal_snr(rows, np.where(found, light_x, 0.0)), -np.inf)


def best_over(rows: SceneRows, f_numbers: Array, low: Array, high: Array, power_limit_w: Array) -> Array:
    """Nominal SNR with the most light at each of these f-numbers, -inf where there is none; (n, n_tried)."""
    columns = []
    for column in range(f_numbers.shape[1]):
        f_number = f_numbers[:, column]
        light_x = most_light(
            rows, np.where(np.isfinite(f_number), f_number, np.nan), low, high, power_limit_w
        )
        inside = np.isfinite(light_x) & (f_number <= rows.n_high * (1 + SLACK))
        columns.append(np.where(inside, nominal_snr(rows, np.where(inside, light_x, 0.0)), -np.inf))
    return np.stack(columns, axis=1)


def most_light(rows: SceneRows, f_number: Array, low: Array, high: Array, power_limit_w: Array) -> Array:
    """Greatest X in the window that the lights reach at this f-number within a mean power; NaN: none."""
    best = light_by_level(rows, f_number[:, None], low, high, power_limit_w).max(axis=1)
    return np.where(np.isfinite(best), best, np.nan)


def light_by_level(rows: SceneRows, f_number: Array, low: Array, high: Array, power_limit_w: Array) -> Array:
    """Greatest X in the window at each level and f-number, (n, 1) or (n, n_levels), within a power; -inf: none."""
    square = np.square(f_number * rows.working_factor[:, None])
    left_w = power_limit_w - rows.idle
    burnt = np.isfinite(rows.leads_s) & (rows.kind == CONTINUOUS)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(
            rows.kind == FLASH,
            left_w / (rows.pulse_energy_j * rows.rate_hz),
            left_w / rows.full_power_w,
        )
        share = np.where(np.isnan(share), np.inf, share)
        energy_cap = np.where(rows.kind == PULSED, share / rows.rate_hz, np.inf)
        level_cap = np.where(rows.kind == PULSED, np.inf, share)
        energy_cap = np.where(np.isnan(energy_cap), np.inf, energy_cap)
        # Off between images: a dial at the longest time, at the level that it leaves; a step for as long as it may.
        level_cap = np.where(
            burnt, np.where(rows.dims_freely, share / rows.on_share(rows.time_max_s), np.inf), level_cap
        )
        lead_s = np.where(burnt, rows.leads_s, 0.0)
    top = np.minimum(np.minimum(level_cap, rows.max_level), 1.0)
    levels = np.where(rows.dims_freely[:, None], np.nan, rows.levels)
    levels = np.where(levels <= top[:, None] * (1 + SLACK), levels, np.nan)
    levels[:, 0] = np.where(rows.dims_freely, np.where(top >= rows.min_level, top, np.nan), levels[:, 0])
    floor_level = np.where(rows.dims_freely[:, None], rows.min_level[:, None], levels)
    with np.errstate(divide="ignore", invalid="ignore"):
        left = (share / rows.rate_hz)[:, None] - levels * lead_s[:, None]
        shortened = (burnt & ~rows.dims_freely)[:, None] & (levels > share[:, None])
        energy = np.where(shortened, left, energy_cap[:, None])
        most = np.minimum(levels * rows.time_max_s[:, None], energy)
        least = floor_level * rows.time_min_s[:, None]
        scale = rows.light_lm[:, None] / square
        light_x = np.minimum(most * scale, high[:, None])
        fits = (
            (least * scale <= high[:, None] * (1 + SLACK))
            & (light_x >= low[:, None] * (1 - SLACK))
            & (least <= most * (1 + SLACK))
        )
    return np.where(fits, light_x, -np.inf)


def nominal_snr(rows: SceneRows, light_x: Array) -> Array:
    """SNR of the image mean at the nominal altitude with the gain at its best."""
    gain = rows.gain_dn_per_e * best_gain(rows, light_x)
    return np.asarray(
        sensor.snr(
            rows.signal_e[:, rows.nominal] * light_x,
            veil_e=0.0 if rows.veil_e is None else rows.veil_e[:, rows.nominal] * light_x,
            read_noise_e=rows.read_noise_e,
            gain_dn_per_e=gain,
            dark_e=dark_e(rows),
            prnu_frac=rows.prnu_frac,
        )
    )
