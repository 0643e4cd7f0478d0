"""Windows of light that requirements leave over ranges of settings, and whether they hold at points."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.light_columns import share_of
from uwopt.forward.scene_rows import SceneRows
from uwopt.model import sensor
from uwopt.model.image_mean import reached_by_most
from uwopt.solvers.settings.windows import Beside, Sun, dark_e, level_sides, light_asked_for

MEETS = 1e-9  # relative, by which a point may miss a requirement
NARROW, POINT = 4.0, 1.0 + 1e-9  # of a range of the sun's light, most over least: until it is none


def bars_contrast(rows: SceneRows, light_x: Array, sun: Sun | None) -> Array:
    """Image-forming over all light by altitude, (n, n_altitudes): of the mean, or less where pixels count."""
    signal, total = rows.signal_e * light_x[:, None], rows.total_e * light_x[:, None]
    if sun is not None:
        signal, total = signal + sun.signal_e, total + sun.total_e
    mean = share_of(signal, total)
    if not rows.veils_pixels:
        return mean
    one, veil = at_pixels(rows, light_x, sun)
    return np.minimum(mean, reached_by_most(share_of(one, one + veil), rows.may_miss))


def at_pixels(rows: SceneRows, light_x: Array, sun: Sun | None) -> tuple[Array, Array]:
    """Signal and veil at the pixels that the SNR is asked of, (n, n_altitudes, n_pixels)."""
    assert rows.worst_e is not None
    x = light_x[:, None, None]
    one = rows.worst_e * x
    veil: Any = np.zeros_like(one) if rows.worst_veil_e is None else rows.worst_veil_e * x
    if sun is not None and sun.worst_signal_e is not None and sun.worst_total_e is not None:
        return one + sun.worst_signal_e, veil + (sun.worst_total_e - sun.worst_signal_e)
    if sun is not None:
        return one + sun.signal_e[:, :, None], veil + (sun.total_e - sun.signal_e)[:, :, None]
    return one, veil


def figures_at(rows: SceneRows, light_x: Array, gain: Array, sun: Sun | None) -> tuple[Array, Array, Array]:
    """SNR and contrast at the nominal altitude and whether SNR, level, saturation and contrast hold everywhere."""
    x = light_x[:, None]
    signal, total = rows.signal_e * x, rows.total_e * x
    if sun is not None:
        signal, total = signal + sun.signal_e, total + sun.total_e
    dark = dark_e(rows)[:, None]
    noise: dict[str, Any] = dict(
        read_noise_e=rows.read_noise_e[:, None], gain_dn_per_e=(rows.gain_dn_per_e * gain)[:, None], dark_e=dark,
        prnu_frac=rows.prnu_frac[:, None],
    )  # fmt: skip
    with np.errstate(invalid="ignore", divide="ignore"):
        snr = sensor.snr(signal, veil_e=total - signal, **noise)
        share = np.where(total > 0, signal / total, 0.0)
        lowest = mean = snr.min(axis=1)
        if rows.worst_e is not None:
            one, veil = at_pixels(rows, light_x, sun)
            there = {name: column[:, :, None] for name, column in noise.items()}
            each = np.asarray(sensor.snr(one, veil_e=veil, **there))
            lowest = reached_by_most(each, rows.may_miss).min(axis=1)
        ratio = rows.highlight_ratio
        brightest = (total + dark).max(axis=1)
        if rows.background_e is not None:
            brightest = np.maximum(brightest, (rows.background_e * x + dark)[:, 0])
        holds = (lowest >= rows.min_snr * (1 - MEETS)) & (mean >= rows.min_snr_mean * (1 - MEETS))
        if rows.colour_e is not None:
            holds &= colours_hold(rows, light_x, sun, noise)
        holds &= ratio * brightest <= rows.well_e * (1 + MEETS)
        level_dn = rows.gain_dn_per_e * gain * brightest + rows.black_level_dn
        if not (rows.optimistic and rows.mean_level is not None):
            holds &= ratio * level_dn <= rows.full_scale_dn * (1 + MEETS)
        if rows.mean_level is not None:
            nominal_dn = rows.gain_dn_per_e * gain * (total + dark)[:, rows.nominal] + rows.black_level_dn
            wanted = rows.mean_level * rows.full_scale_dn
            holds &= nominal_dn <= wanted * (1 + MEETS)
            if not rows.optimistic:
                holds &= nominal_dn >= wanted * (1 - MEETS)
        if rows.min_contrast > 0 and not rows.optimistic:
            holds &= share.min(axis=1) >= rows.min_contrast * (1 - MEETS)
    return snr[:, rows.nominal], share[:, rows.nominal], np.asarray(holds)


def colours_hold(rows: SceneRows, light_x: Array, sun: Sun | None, noise: dict[str, Any]) -> Array:
    """Whether the red channel's SNR and the white balance hold at every altitude."""
    assert rows.colour_e is not None
    colour = rows.colour_e * light_x[:, None, None]
    red_veil = 0.0 if rows.red_veil_e is None else rows.red_veil_e * light_x[:, None]
    if sun is not None and sun.colour_e is not None and sun.red_total_e is not None:
        colour = colour + sun.colour_e
        red_veil = red_veil + (sun.red_total_e - sun.colour_e[:, :, 0])
    holds = np.ones(len(light_x), bool)
    if rows.min_snr_red > 0.0:
        snr = sensor.snr(colour[:, :, 0], veil_e=red_veil, **noise)
        holds &= np.min(snr, axis=1) >= rows.min_snr_red * (1 - MEETS)
    if np.isfinite(rows.max_white_balance):
        holds &= np.max(sensor.white_balance(colour), axis=1) <= rows.max_white_balance * (1 + MEETS)
    return np.asarray(holds)


def window_over(
    rows: SceneRows, y_lo: Any, y_hi: Any, shortest_s: Any, longest_s: Any
) -> tuple[Array, Array]:
    """The window over ranges of open shutter over N_w^2 and of exposures: an X outside fits nowhere."""
    n = len(rows.total_e)
    dark, most_dark = (
        np.broadcast_to(rows.dark_current_e_s * np.asarray(s, float), n) for s in (shortest_s, longest_s)
    )
    quiet = replace(rows, dark_time_s=np.broadcast_to(np.asarray(shortest_s, float), n))
    none = np.zeros_like(rows.bright_e)
    beside, helping = Beside(none, none, dark, most_dark, dark), None
    if rows.sun_signal_e_s is not None:
        at_least, at_most = Sun.at(rows, y_lo), Sun.at(rows, y_hi)
        assert at_least is not None and at_most is not None
        beside = replace(beside, least_e=at_least.total_e, most_e=at_most.total_e)
        helping = Sun(
            at_most.signal_e, np.minimum(at_least.total_e, at_most.total_e), at_most.worst_signal_e,
            at_least.worst_total_e, at_most.colour_e, at_least.red_total_e,
        )  # fmt: skip
    sides = level_sides(rows, beside)
    low, high = sides.for_level, sides.high
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        never = np.inf if helping is None else 0.0  # with sun of another contrast it rules no X out
        low = np.maximum(low, light_asked_for(quiet, sun=helping, never=never))
        if helping is not None:
            low = np.maximum(low, light_beside_most_sun(quiet, y_lo, y_hi))
        if rows.min_contrast > 0.0 and not rows.optimistic:
            low, high = contrast_window(rows, y_lo, y_hi, low, high)
        if np.isfinite(rows.max_white_balance):
            low, high = balance_window(rows, y_lo, y_hi, low, high)
    low = np.maximum(np.where(np.isnan(low), np.inf, low), 0.0)
    return low, np.where(np.isnan(high), -np.inf, high)


def light_beside_most_sun(rows: SceneRows, y_lo: Array, y_hi: Array) -> Array:
    """Least X that the SNR may ask for over a narrow range of the sun's Y, from what it asks for at the most; else 0.

    The most signal with the least noise of a range asks for no lamps long before none are needed. But with X / Y as it
    is the SNR grows with Y, whatever is the noise:

        SNR^2 = (a X/Y + s)^2 / (sigma^2 / Y^2 + (b X/Y + t) / Y + PRNU^2 (b X/Y + t)^2)

    So where an X is enough at some Y, Y_hi / Y times as much is at Y_hi, and none below Y_lo / Y_hi of what is asked
    for there is enough anywhere.
    """
    least = np.zeros(len(y_lo))
    some = np.flatnonzero((y_hi <= NARROW * y_lo) & (y_hi > POINT * y_lo))
    if len(some):
        rows, share = rows.take(some), y_lo[some] / y_hi[some]
        sun = Sun.at(rows, y_hi[some])
        least[some] = share * light_asked_for(rows, sun=sun, never=0.0)
    return least


def contrast_window(rows: SceneRows, y_lo: Any, y_hi: Any, low: Array, high: Array) -> tuple[Array, Array]:
    """The window where the contrast holds at every altitude: (C X + s Y) >= k (A X + a Y)."""
    wanted = rows.min_contrast * (1 - 1e-10)
    gains = rows.signal_e - wanted * rows.total_e
    if rows.sun_signal_e_s is None or rows.sun_veil_e_s is None:
        return low, np.where((gains < 0).any(axis=1), -np.inf, high)
    misses = wanted * (rows.sun_signal_e_s + rows.sun_veil_e_s) - rows.sun_signal_e_s
    return share_window(gains, misses, y_lo, y_hi, low, high)


def balance_window(rows: SceneRows, y_lo: Any, y_hi: Any, low: Array, high: Array) -> tuple[Array, Array]:
    """The window where no channel is more than k times another: k (C_j X + s_j Y) >= C_i X + s_i Y.

    Without sun no X changes it, and rows that miss it have no times.
    """
    if rows.colour_e is None or rows.sun_colour_e_s is None:
        return low, high
    most, n = rows.max_white_balance * (1 + 1e-10), len(low)

    def over(channels: Array) -> Array:
        """k c_j - c_i of every pair at every altitude, (n, n_altitudes * 9)."""
        pairs = np.asarray(most * channels[..., None, :] - channels[..., :, None])
        return pairs.reshape(n, int(np.prod(pairs.shape[1:])))

    return share_window(over(rows.colour_e), -over(rows.sun_colour_e_s), y_lo, y_hi, low, high)


def share_window(
    gains: Array, misses: Array, y_lo: Any, y_hi: Any, low: Array, high: Array
) -> tuple[Array, Array]:
    """The window of X in which gains * X >= misses * Y may hold for some Y in its range, in every column of (n, m)."""
    y_lo, y_hi = (np.reshape(y, (-1, 1)) for y in (y_lo, y_hi))
    with np.errstate(divide="ignore", invalid="ignore"):  # a channel that neither lamps nor sun reach asks for nothing
        need = np.where(misses > 0, np.where(gains > 0, misses * y_lo / gains, np.inf), 0.0)
        cap = np.where(gains < 0, np.where(misses < 0, misses * y_hi / gains, 0.0), np.inf)
    need = np.where((misses > 0) & (gains <= 0) & (y_lo <= 0), 0.0, need)
    return np.maximum(low, need.max(axis=1)), np.minimum(high, cap.min(axis=1))
