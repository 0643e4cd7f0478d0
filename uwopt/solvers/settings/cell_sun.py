"""What lamps and sun together can reach in boxes of settings: both fill the same pixels.

X is the lamps' light * level * time / N_w^2, Y the open shutter / N_w^2. A box has a range of each, and what a pixel
holds limits their sum: the best of the box lies in a polygon of X and Y.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.scene_rows import SceneRows
from uwopt.model.sensor import QUANTISATION_VARIANCE_DN2
from uwopt.solvers.settings import closed_form, windows
from uwopt.solvers.settings.windows import Sun
from uwopt.tolerances import SLACK


@dataclass(frozen=True)
class Mixture:
    """Ranges of the lamps' X and the sun's Y of m boxes, and of X / Y."""

    x_lo: Array
    x_hi: Array
    y_lo: Array
    y_hi: Array
    ratio_lo: Array
    ratio_hi: Array

    @staticmethod
    def of(x: tuple[Array, Array], y: tuple[Array, Array], level: tuple[Array, Array], rows: SceneRows,
           lit_share: tuple[Array, Array]) -> Mixture:  # fmt: skip
        """From ranges of X, Y, level, and of light-collecting over open time (most, least)."""
        (x_lo, x_hi), (y_lo, y_hi), (u_lo, u_hi), (most, least) = x, y, level, lit_share
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio_hi = np.minimum(x_hi / y_lo, rows.light_lm * u_hi * most)
            ratio_lo = np.minimum(np.maximum(x_lo / y_hi, rows.light_lm * u_lo * least), ratio_hi)
        return Mixture(x_lo, x_hi, y_lo, y_hi, ratio_lo, ratio_hi)

    def most_contrast(self, rows: SceneRows) -> Array:
        """Highest contrast by altitude, (m, n_altitudes): at an end of the lamps' light over the sun's."""
        assert rows.sun_signal_e_s is not None and rows.sun_veil_e_s is not None
        sun, every = rows.sun_signal_e_s, rows.sun_signal_e_s + rows.sun_veil_e_s
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = [
                (rows.signal_e * ratio[:, None] + sun) / (rows.total_e * ratio[:, None] + every)
                for ratio in (self.ratio_lo, self.ratio_hi)
            ]
        return np.asarray(np.fmax(*ends))  # without any light there is none

    def vertices(self, every: Array, sun_every: Array, most_e: Array) -> tuple[Array, Array, Array]:
        """Corners of the polygon in which every * X + sun_every * Y <= most_e: X, Y (m, 5), and which are inside."""
        x_lo, x_hi, y_lo, y_hi = (side[:, None] for side in (self.x_lo, self.x_hi, self.y_lo, self.y_hi))
        xs, ys = np.concatenate([x_lo, x_hi], axis=1), np.concatenate([y_lo, y_hi], axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            x_left = (most_e[:, None] - sun_every[:, None] * ys) / every[:, None]
            y_left = (most_e[:, None] - every[:, None] * xs) / sun_every[:, None]
        x_left, y_left = (np.where(np.isnan(left), np.inf, left) for left in (x_left, y_left))
        x = np.concatenate([xs, np.clip(x_left, x_lo, x_hi), x_lo], axis=1)
        y = np.concatenate([np.clip(y_left, y_lo, y_hi), ys, y_lo], axis=1)
        inside = every[:, None] * x + sun_every[:, None] * y <= most_e[:, None] * (1 + 1e-9)
        return x, y, inside

    def brightest(self, rows: SceneRows) -> Brightest:
        """What bounds the SNR at the nominal altitude; rows have the least dark current of the boxes."""
        assert rows.sun_signal_e_s is not None and rows.sun_veil_e_s is not None
        at = rows.nominal
        lamp, every, sun = rows.signal_e[:, at], rows.total_e[:, at], rows.sun_signal_e_s[:, at]
        sun_every = sun + rows.sun_veil_e_s[:, at]
        x, y, inside = self.vertices(every, sun_every, most_electrons(rows))
        signal, total = (a[:, None] * x + b[:, None] * y for a, b in ((lamp, sun), (every, sun_every)))
        gain = rows.gain_dn_per_e * closed_form.best_gain(rows, self.x_lo, Sun.at(rows, self.y_lo))
        floor_e2 = np.square(rows.read_noise_e) + QUANTISATION_VARIANCE_DN2 / np.square(gain)
        floor_e2 = floor_e2 + windows.dark_e(rows)
        with np.errstate(divide="ignore", invalid="ignore"):
            alone = np.where(inside, np.square(signal) / (floor_e2[:, None] + total), 0.0).max(axis=1)
            clearest = np.where(inside & (signal > 0), total / signal, np.inf).min(axis=1)
            square = 1.0 / (
                1.0 / alone + np.square(np.where(rows.prnu_frac > 0, rows.prnu_frac * clearest, 0.0))
            )
        return Brightest(
            np.sqrt(np.where(alone > 0, square, 0.0)), np.where(inside, signal, 0.0).max(axis=1),
            sun + lamp * self.ratio_hi, np.where(np.isfinite(clearest), clearest, 1.0), floor_e2, rows.prnu_frac,
        )  # fmt: skip


@dataclass(frozen=True)
class Brightest:
    """The highest SNR of boxes, and what bounds it along the shutter; (m,) each.

        1 / SNR^2 = (sigma^2 + T) / S^2 + PRNU^2 (T / S)^2,   S, T linear in X and Y

    S^2 / (sigma^2 + T) is convex and T / S lies between its values at vertices: each is best at one of them.
    """

    snr: Array
    signal_e: Array  # S, most
    per_y_e: Array  # S / Y, most
    clearest: Array  # T / S, least
    floor_e2: Array  # sigma^2, least
    prnu_frac: Array

    def log_snr_and_slope(self, log_signal: Array) -> tuple[Array, Array]:
        """Ln SNR of a signal with the least noise that it can have, and its slope in ln S: concave."""
        signal = np.exp(log_signal)
        total = self.clearest * signal
        uneven_e2 = np.square(self.prnu_frac * total)
        variance = self.floor_e2 + total + uneven_e2
        return log_signal - 0.5 * np.log(variance), 1.0 - 0.5 * (total + 2.0 * uneven_e2) / variance


def longest_open_s(rows: SceneRows, square: Array, light_x: Array, light_over_y: Array) -> Array:
    """Longest open shutter at which lamps and sun do not overfill a pixel at any altitude, (m,).

    light_x : the lamps' X, what of it does not grow with the shutter; light_over_y : X / Y of what does
    """
    assert rows.sun_signal_e_s is not None and rows.sun_veil_e_s is not None
    sun, total = rows.sun_signal_e_s + rows.sun_veil_e_s, rows.total_e
    held_e = np.broadcast_to((rows.well_e / rows.highlight_ratio)[:, None], total.shape)
    range_dn = rows.headroom_dn[:, None]
    if rows.wanted_dn is not None:
        nominal = np.arange(total.shape[1]) == rows.nominal
        range_dn = np.where(nominal, rows.wanted_dn[:, None], np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        left_e = np.minimum(held_e, range_dn / rows.gain_dn_per_e[:, None]) - total * light_x[:, None]
        by_open = (sun + total * light_over_y[:, None]) / square[:, None] + rows.dark_current_e_s[:, None]
        longest = (left_e / by_open).min(axis=1)
    return np.asarray(np.where(np.isnan(longest), np.inf, longest) * (1 - 1e-12))


def most_electrons(rows: SceneRows) -> Array:
    """What a pixel of the mean may hold of light at most, at the nominal altitude: well, range, or the wanted level."""
    dark = windows.dark_e(rows)
    held_e = rows.well_e / rows.highlight_ratio
    range_dn = rows.headroom_dn if rows.wanted_dn is None else rows.wanted_dn
    return np.asarray(np.minimum(held_e, range_dn / rows.gain_dn_per_e) - dark) * (1 + SLACK)
