"""Windows of light: the least and the most X = light * time / N_w^2 [lm s] that requirements leave a design.

Signal is C X. SNR asks for a least X, the wanted mean level for a least and a most, wells and full scale for a most;
the sun's light and dark electrons are there beside the lamps'.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.scene_rows import SceneRows
from uwopt.model import sensor
from uwopt.model.image_mean import needed_by_most
from uwopt.tolerances import SLACK

Light = Literal["mean", "worst", "red"]  # what an SNR may be asked of


def dark_e(rows: SceneRows) -> Array:
    """Dark electrons in the exposure of the rows, almost always under 1."""
    return np.asarray(rows.dark_current_e_s * rows.dark_time_s)


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

    def at_altitude(self, altitude: int, of: Light) -> tuple[Array, Array]:
        """Signal and all light at one altitude, (n, n_pixels): see `light_of_each`."""
        picked = self.signal_e, self.total_e
        if of == "worst" and self.worst_signal_e is not None and self.worst_total_e is not None:
            picked = self.worst_signal_e, self.worst_total_e
        elif of == "red" and self.colour_e is not None and self.red_total_e is not None:
            picked = self.colour_e[:, :, 0], self.red_total_e
        one, every = (p[:, altitude] if p.ndim == 3 else p[:, altitude, None] for p in picked)
        return one, every


@dataclass(frozen=True)
class Beside:
    """Electrons that are there beside the lamps' light, from least to most; at given settings both are the same."""

    least_e: Array  # of the sun, by altitude
    most_e: Array
    dark_e: Array  # the least
    most_dark_e: Array  # that may help to fill the wanted level
    bright_dark_e: Array  # that is there where another altitude is brighter than the nominal one


@dataclass(frozen=True)
class Window(Columns):
    """What bounds X in each scene's window; more dark electrons raise `for_snr` and lower the other two of the first
    three, while `gain_at_brightest` grows in proportion to them."""

    for_level: Array  # least X at the highest gain, for the wanted mean level
    for_snr: Array
    full: Array  # most X: wells, full scale, the wanted level at the lowest gain
    gain_at_brightest: Array  # most X: the gain of the wanted level must not saturate at another altitude

    def without_nan(self) -> Window:
        """Where a side is unknown, nothing fits; no X is below 0."""
        lows = (np.maximum(np.where(np.isnan(low), np.inf, low), 0.0) for low in (self.for_level, self.for_snr))
        highs = (np.where(np.isnan(high), -np.inf, high) for high in (self.full, self.gain_at_brightest))
        return Window(*lows, *highs)

    @property
    def low(self) -> Array:
        """Least X."""
        return np.maximum(self.for_level, self.for_snr)

    @property
    def high(self) -> Array:
        """Most X."""
        return np.minimum(self.full, self.gain_at_brightest)


def window(
    rows: SceneRows, *, snr_floor: Array | float = 0.0, sun: Sun | None = None, asked: Window | None = None
) -> tuple[Array, Array]:
    """Lowest and highest X that the requirements on SNR, level and saturation allow; inf: none does.

    `snr_floor` is wanted at the nominal altitude beside the mission's own requirement over all, whose window is `asked`
    where it is known.
    """
    sides = window_sides(rows, snr_floor=snr_floor, sun=sun, asked=asked)
    return sides.low, sides.high


def window_sides(
    rows: SceneRows, *, snr_floor: Array | float = 0.0, sun: Sun | None = None, asked: Window | None = None
) -> Window:
    """The window of X by what bounds it, as `window` takes its arguments."""
    sides = asked_sides(rows, sun) if asked is None else asked
    if np.ndim(snr_floor) == 0 and snr_floor == 0.0:
        return sides
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        floor = light_for_snr(rows, rows.nominal, snr_floor, of="mean", sun=sun)
    return replace(sides, for_snr=np.maximum(sides.for_snr, floor))


def asked_sides(rows: SceneRows, sun: Sun | None = None) -> Window:
    """The window of X that the mission's own requirements leave, by what bounds it."""
    other = np.zeros_like(rows.bright_e) if sun is None else sun.total_e
    dark = dark_e(rows)
    level_dark = dark if rows.spare_dark_s is None else dark + rows.dark_current_e_s * rows.spare_dark_s
    sides = level_sides(rows, Beside(other, other, dark, level_dark, level_dark))
    full, for_snr = sides.full, np.zeros(len(dark))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for_snr = np.maximum(for_snr, light_asked_for(rows, sun=sun))
    if rows.min_contrast > 0.0 and sun is None:
        full = np.where(contrast(rows) < rows.min_contrast * (1 - 1e-9), -np.inf, full)
    return replace(sides, full=full, for_snr=for_snr).without_nan()


def level_sides(rows: SceneRows, beside: Beside) -> Window:
    """The window of X that wells, full scale and the wanted mean level leave; no X outside serves. May hold nan."""
    total = rows.bright_e
    nominal, none = total[:, rows.nominal], np.zeros(len(total))
    least_nominal = beside.least_e[:, rows.nominal] + beside.dark_e
    most_nominal = beside.most_e[:, rows.nominal] + beside.most_dark_e
    dark, wanted_dn, headroom_dn = beside.dark_e[:, None], rows.wanted_dn, rows.headroom_dn
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        well = (rows.well_e / rows.highlight_ratio)[:, None] - dark
        full = ((well - beside.least_e) / total).min(axis=1)
        if wanted_dn is None:
            scale = (headroom_dn / rows.least_dn_per_e)[:, None] - dark
            full = np.minimum(full, ((scale - beside.least_e) / total).min(axis=1))
            return Window(none, none, full, np.full(len(total), np.inf))
        full = np.minimum(full, (wanted_dn / rows.least_dn_per_e - least_nominal) / nominal)
        least_e = wanted_dn / (rows.gain_dn_per_e * rows.max_gain) - most_nominal
        if rows.optimistic:
            for_level = none
            if rows.most_veil_e is not None:
                for_level = least_e / (rows.signal_e + rows.most_veil_e)[:, rows.nominal]
            return Window(for_level, none, full, np.full(len(total), np.inf))
        # The gain follows the nominal level; the brightest altitude must not saturate with it.
        excess = wanted_dn[:, None] * total - (headroom_dn * nominal)[:, None]
        there = beside.least_e + beside.bright_dark_e[:, None]
        spare = (headroom_dn * most_nominal)[:, None] - wanted_dn[:, None] * there
        steep = np.abs(excess) > SLACK * wanted_dn[:, None] * total
        brightest = np.where(steep & (excess > 0), spare / excess, np.inf).min(axis=1)
        darkest = np.where(steep & (excess < 0), spare / excess, 0.0).max(axis=1)
        return Window(np.maximum(least_e / nominal, darkest), none, full, brightest)


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


def light_asked_for(rows: SceneRows, *, sun: Sun | None = None, never: float = np.inf) -> Array:
    """Least X that reaches every SNR that the mission asks for at all altitudes, (n,): of mean, pixels and red."""
    of: Light = "mean" if rows.worst_e is None else "worst"
    asked: list[tuple[Light, float]] = [(of, rows.min_snr)]
    beside: list[tuple[Light, float]] = [("mean", rows.min_snr_mean), ("red", rows.min_snr_red)]
    wanted = np.zeros(len(rows.signal_e))
    for light, snr in asked + [one for one in beside if one[1] > 0.0]:
        seen = rows.worst_e if light == "worst" and rows.worst_e is not None else rows.signal_e
        for altitude in range(-seen.shape[1], 0):  # counted from the farthest, which bounds know alone of pixels
            wanted = np.maximum(wanted, light_for_snr(rows, altitude, snr, of=light, sun=sun, never=never))
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


def of_lamps(rows: SceneRows, altitude: int, of: Light) -> tuple[Array, Array | float]:
    """Signal and veil per X at one altitude, (n, n_pixels): see `light_of_each`."""
    signal, veil = rows.signal_e[:, altitude], None if rows.veil_e is None else rows.veil_e[:, altitude]
    if of == "worst" and rows.worst_e is not None:
        signal = rows.worst_e[:, altitude]
        veil = None if rows.worst_veil_e is None else rows.worst_veil_e[:, altitude]
    elif of == "red":
        assert rows.colour_e is not None
        signal = rows.colour_e[:, altitude, 0]
        veil = None if rows.red_veil_e is None else rows.red_veil_e[:, altitude]
    if signal.ndim == 1:
        signal, veil = signal[:, None], None if veil is None else veil[:, None]
    return signal, 0.0 if veil is None else veil


def light_of_each(
    rows: SceneRows, altitude: int, snr: Array | float, *, of: Light, sun: Sun | None = None
) -> Array:
    """Least X at which each pixel reaches an SNR at one altitude, (n, n_pixels); of what is no pixel one column.

    The gain lowers quantisation noise; it is as high as the wanted mean level or saturation lets it
    be. Up to the X where the highest gain fills the range, that gain counts; beyond it the noise
    follows the level. SNR grows with X throughout, so the larger of the two answers that apply holds. `of`: the
    image's mean, the pixels that the SNR is asked of, or the red channel.
    """
    signal, veil = of_lamps(rows, altitude, of)
    dark, other = dark_e(rows)[:, None], np.zeros((len(signal), 1))
    common: dict[str, Any] = dict(
        read_noise_e=rows.read_noise_e[:, None],
        dark_e=dark,
        prnu_frac=rows.prnu_frac[:, None],
        signal_per_light_e=signal,
        total_per_light_e=signal + veil,
    )
    if sun is not None:
        one, every = sun.at_altitude(altitude, of)
        common.update(other_signal_e=one, other_light_e=every)
        other = sun.total_e
    wanted = np.reshape(np.asarray(snr, float), (-1, 1))
    total = rows.total_e
    if rows.wanted_dn is not None:
        return np.asarray(
            sensor.light_for_snr(
                wanted,
                level_per_light_e=total[:, rows.nominal, None],
                level_dn=rows.wanted_dn[:, None],
                other_level_e=other[:, min(rows.nominal, other.shape[1] - 1), None],
                **common,
            )
        )
    brightest = rows.bright_e.max(axis=1)[:, None]
    other_brightest = other.max(axis=1)[:, None]
    headroom_dn = rows.headroom_dn[:, None]
    top_gain = (rows.gain_dn_per_e * rows.max_gain)[:, None]
    fills = (headroom_dn / top_gain - dark - other_brightest) / brightest
    at_top_gain = sensor.light_for_snr(wanted, gain_dn_per_e=top_gain, **common)
    following = sensor.light_for_snr(
        wanted, level_per_light_e=brightest, level_dn=headroom_dn, other_level_e=other_brightest, **common
    )
    return np.where(at_top_gain <= fills, at_top_gain, np.maximum(following, fills))
