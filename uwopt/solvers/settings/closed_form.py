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

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.model import light, sensor
from uwopt.solvers.settings.windows import Sun, Window, asked_sides, dark_e, window
from uwopt.tolerances import SLACK


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
    exposure_s: Array | None = None  # None: what the lamps need, which `exposed` fills in

    def exposed(self, rows: SceneRows) -> Chosen:
        """With the exposure, where it follows from the time that collects light."""
        return self if self.exposure_s is not None else replace(self, exposure_s=rows.exposure_s(self.time_s))

    def of_row(self, row: int) -> dict[str, float]:
        """One design's settings by name."""
        return {name: float(column[row]) for name, column in vars(self).items() if column is not None}


def with_exposure(rows: SceneRows, chosen: Chosen) -> SceneRows:
    """The rows with dark current charged for the exposure that was chosen; infeasible ones stay as they are."""
    exposure = rows.exposure_s(chosen.time_s)
    return replace(rows, dark_time_s=np.where(np.isfinite(exposure), exposure, rows.dark_time_s))


def reach(rows: SceneRows) -> tuple[Array, Array]:
    """Least and greatest light * time [lm s] at each level, (n, n_levels); NaN where there is no level.

    A lamp that dims freely has one entry from its least to its greatest level.
    """
    low_level, high_level = levels_up_to(rows, rows.max_level)
    usable = rows.time_min_s <= rows.time_max_s * (1 + SLACK)
    light = np.where(usable, rows.light_lm, np.nan)[:, None]
    return low_level * light * rows.time_min_s[:, None], high_level * light * rows.time_max_s[:, None]


def levels_up_to(rows: SceneRows, top: Array) -> tuple[Array, Array]:
    """Least and greatest level of each way to set a lamp no brighter than a top (n,), (n, n_levels); NaN: none.

    Steps are one way each; a lamp that dims freely has one entry from its least level to the top.
    """
    low = np.where(rows.dims_freely[:, None], np.nan, rows.levels)
    low = np.where(low <= top[:, None] * (1 + SLACK), low, np.nan)
    high, free = low.copy(), rows.dims_freely & (rows.min_level <= top)
    low[:, 0] = np.where(free, rows.min_level, low[:, 0])
    high[:, 0] = np.where(free, np.minimum(top, 1.0), high[:, 0])
    return low, high


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


def least_f_numbers(ranges: list[tuple[Array, Array]], motorised: Array) -> list[Array]:
    """The smallest f-number of each scene: one that is common to all where the lens is not motorised."""
    common = smallest_common_f_number(ranges)
    if len(ranges) == 1:
        return [common]
    return [np.where(motorised, smallest_common_f_number([own]), common) for own in ranges]


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


def drawn_power_w(rows: SceneRows, level: Array, time_s: Array, exposure_s: Array | None = None) -> Array:
    """Mean electrical power of all lights (PHYSICS section 1), and of cameras for the exposure.

    exposure_s : (n,) [s], None: what the lamps need
    """
    burning = light.continuous_power_w(level, full_power_w=rows.full_power_w, count=1) * rows.on_share(time_s)
    flashing = light.flash_power_w(rows.pulse_energy_j * level, count=1, frame_rate_hz=rows.rate_hz)
    lights_w = np.where(rows.kind == FLASH, flashing, burning) + rows.idle
    if rows.camera_w is None:
        return lights_w
    return lights_w + rows.exposing_w(rows.exposure_s(time_s) if exposure_s is None else exposure_s)


def peak_power_w(rows: SceneRows, level: Array) -> Array:
    """Peak electrical power of all lights; of flashes while they recharge."""
    flashing = light.flash_peak_power_w(
        rows.pulse_energy_j * level, charging_power_w=rows.charging_power_w, frame_rate_hz=rows.rate_hz
    )
    return np.where(rows.kind == FLASH, flashing, rows.full_power_w * level)


def best_gain(rows: SceneRows, light_x: Array, sun: Sun | None = None) -> Array:
    """The gain that gives the wanted mean level; without one, the highest that does not saturate."""
    dark = dark_e(rows)
    every = rows.bright_e * light_x[:, None]
    if sun is not None:
        every = every + sun.total_e
    wanted_dn = rows.wanted_dn
    if wanted_dn is not None:
        level_e = every[:, rows.nominal] + dark
    else:
        level_e, wanted_dn = every.max(axis=1) + dark, rows.headroom_dn
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.clip(wanted_dn / (rows.gain_dn_per_e * level_e), rows.min_gain, rows.max_gain)


def least_power(
    scenes: list[SceneRows], motorised: Array, *, snr_floor: Array | float = 0.0, asked: list[Window] | None = None
) -> tuple[list[Chosen], Array]:
    """Settings of least power that meet every scene, and whether there are any.

    asked : `asked_sides` of each scene, where they are known
    """
    asked = [asked_sides(rows) for rows in scenes] if asked is None else asked
    windows = [window(rows, snr_floor=snr_floor, asked=own) for rows, own in zip(scenes, asked, strict=True)]
    ranges = [f_number_ranges(rows, low, high) for rows, (low, high) in zip(scenes, windows, strict=True)]
    chosen, feasible = [], np.ones(len(motorised), bool)
    for rows, (low, high), f_number in zip(scenes, windows, least_f_numbers(ranges, motorised), strict=True):
        settings = settle(rows, f_number, low, high)
        feasible &= np.isfinite(f_number) & np.isfinite(settings.level) & np.isfinite(settings.light_power_w)
        chosen.append(settings)
    return chosen, feasible


def greatest_snr(
    scenes: list[SceneRows], motorised: Array, power_limit_w: Array, *, asked: list[Window] | None = None
) -> Array:
    """Highest SNR at the nominal altitude that all scenes can reach within their light power.

    power_limit_w : (n,), or (n, k) of k limits each, nan: none; the answer has its shape, nan where there is none.
    asked : as in `least_power`

    The worst scene counts. At a given level more light comes through a smaller f-number, so the best is
    where some level's range of f-numbers starts; each such start is tried. Of one scene each level has its own.
    """
    asked = [asked_sides(rows) for rows in scenes] if asked is None else asked
    windows = [(own.low, own.high) for own in asked]
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
    burnt = np.isfinite(rows.leads_s) & (rows.kind == CONTINUOUS)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = rows.share_within(power_limit_w)
        energy_cap = np.where(rows.kind == PULSED, share / rows.rate_hz, np.inf)
        level_cap = np.where(rows.kind == PULSED, np.inf, share)
        energy_cap = np.where(np.isnan(energy_cap), np.inf, energy_cap)
        # Off between images: a dial at the longest time, at the level that it leaves; a step for as long as it may.
        level_cap = np.where(
            burnt, np.where(rows.dims_freely, share / rows.on_share(rows.time_max_s), np.inf), level_cap
        )
        lead_s = np.where(burnt, rows.leads_s, 0.0)
    top = np.minimum(np.minimum(level_cap, rows.max_level), 1.0)
    floor_level, levels = levels_up_to(rows, top)
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


def worst_snr(scenes: list[SceneRows], chosen: list[Chosen]) -> Array:
    """`nominal_snr` of settings by scene, of the scene that has least."""
    return np.min([nominal_snr(rows, one.light_x) for rows, one in zip(scenes, chosen, strict=True)], axis=0)
