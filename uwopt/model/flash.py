"""How the light of a flash falls off, and what a shutter that cuts it short lets in.

A flash tube is brightest at once and then fades as its capacitor empties. Its light is told as the time at its peak
brightness that would give as much: light is then proportional to a time, as that of any other lamp, and it is the
shutter and the motion blur that follow a curve. All functions take a decay of inf: light that stays as bright as it
begins. They take floats or arrays; `light_time_s` and `open_time_s` take CasADi symbols where the decay is finite.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Numeric = Any  # float or array that broadcasts; where marked [sym] also a CasADi scalar

LEFT_AT_THE_END = 0.01  # of a flash's light when it counts as over
_SMALL = 0.3  # below it a series stands for ln(sinh u / u)
_ROUNDS = 8  # of Newton's method, which settles in five


def decay_s(duration_s: Numeric, *, at_frac: Numeric) -> Numeric:
    """Time in which a flash fades to 1/e, from its duration as a data sheet gives it.

        tau = T / ln(1 / a)

    Parameters
    ----------
    duration_s : (...,) [s], T, from the peak until the brightness is the share a of it
    at_frac : broadcast [1], a: 0.5 for t0.5, 0.1 for t0.1; 1: light that stays as bright as it begins

    Returns
    -------
    (...,) [s]; inf where a is 1.

    Notes
    -----
    Valid for: a capacitor that empties through a tube, the rise being much shorter. After t0.5 half of the light is
    still to come, after t0.1 a tenth. A flash that is dimmed by quenching ends sooner than this says.

    References
    ----------
    ISO 2827 (t0.5 and t0.1); rapid rise and exponential fall: konsul-instruments.com/en/what-is-flash-duration,
    flashonset.com, "Flash duration" (both read in 2026-11).
    """
    with np.errstate(divide="ignore"):
        return np.asarray(duration_s) / np.abs(np.log(at_frac))


def whole_s(duration_s: Numeric, *, at_frac: Numeric) -> Numeric:
    """Time after which a flash counts as over: 1 % of its light is left, t = tau ln 100; T itself where a is 1 [s]."""
    decays = np.asarray(at_frac) < 1.0
    share = np.where(decays, at_frac, np.exp(-1.0))
    return np.where(decays, decay_s(duration_s, at_frac=share) * -np.log(LEFT_AT_THE_END), duration_s)[()]


def light_time_s(open_s: Numeric, *, decay_s: Numeric) -> Numeric:
    """Time at peak brightness that gives as much light as the flash within a time from its start.

        s = tau (1 - exp(-t / tau))                                                                  [sym]

    open_s : (...,) [s], t >= 0; decay_s : broadcast [s], tau, inf: s = t. Returns (...,) [s], at most t and tau.
    """
    return _steady_where(open_s, decay_s, lambda t, tau: -tau * np.expm1(-t / tau))


def open_time_s(light_s: Numeric, *, decay_s: Numeric) -> Numeric:
    """Time from its start in which a flash gives so much light, t = -tau ln(1 - s / tau): inverse of `light_time_s`.

    light_s : (...,) [s], 0 <= s < tau; decay_s : broadcast [s], inf: t = s. Returns (...,) [s], inf from s = tau
    on [sym].
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return _steady_where(
            light_s, decay_s, lambda s, tau: -tau * np.log1p(-np.minimum(s / tau, 1.0))
        )


def fading_blur_time_s(open_s: Numeric, *, decay_s: Numeric) -> Numeric:
    """Time of steady light that blurs what moves as much as a fading flash does.

        b = 2 sqrt(3) sigma,   sigma = tau sqrt(1 - (u / sinh u)^2),   u = t / (2 tau)

    Parameters
    ----------
    open_s : (...,) [s], t, from the flash's start
    decay_s : broadcast [s], tau; inf: b = t

    Returns
    -------
    (...,) [s], at most t, at most 2 sqrt(3) tau.

    Notes
    -----
    sigma is the standard deviation of the light over time, the density exp(-t' / tau) from 0 to t; steady light of
    length b has b / sqrt(12). Transfers of equal second moment agree at low frequencies, and up to the first null of
    the box the flash's transfer is nowhere below that of the box (tests hold it for the whole range of t / tau).
    ln b rises and is convex in ln s, s of `light_time_s`.

    References
    ----------
    Variance of the truncated exponential distribution: Johnson, Kotz and Balakrishnan, Continuous Univariate
    Distributions, volume 1, chapter 19 (closed form derived anew). PHYSICS, sharpness: motion as a box.
    """
    return _steady_where(
        open_s, decay_s, lambda t, tau: tau * np.sqrt(-12.0 * np.expm1(-2.0 * _log_sinhc(0.5 * t / tau)))
    )


def open_time_of_blur_s(blur_s: Numeric, *, decay_s: Numeric) -> Numeric:
    """Time from its start in which a flash blurs so much: inverse of `fading_blur_time_s`.

    blur_s : (...,) [s], b >= 0; decay_s : broadcast [s]. Returns (...,) [s], inf from b = 2 sqrt(3) tau on.
    """

    def found(blur: Numeric, tau: Numeric) -> Numeric:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            wanted = -0.5 * np.log1p(-np.minimum(np.square(blur / tau) / 12.0, 1.0))
            u = np.sqrt(6.0 * wanted)  # too low: ln(sinh u / u) < u^2 / 6
            for _ in range(_ROUNDS):
                slope = 1.0 / np.tanh(u) - 1.0 / u
                u = np.where(wanted > 0.0, u + (wanted - _log_sinhc(u)) / slope, 0.0)
            # The slope loses its digits there: u^2 = 6 w + 6 w^2 / 5 + ... of w = u^2 / 6 - u^4 / 180 + ...
            u = np.where(wanted < 1e-5, np.sqrt(6.0 * wanted * (1.0 + wanted / 5.0)), u)
            return np.where(np.isfinite(wanted), 2.0 * tau * u, np.inf)

    return _steady_where(blur_s, decay_s, found)


def blur_elasticity(open_s: Numeric, *, decay_s: Numeric) -> Numeric:
    """By how much more the blur grows than the light, d ln b / d ln s: 1 of a short cut, rising with it.

        (d ln b / dt) / (d ln s / dt) = c^2 (coth u - 1 / u) (exp(2 u) - 1) / (2 (1 - c^2)),
        c = u / sinh u,   u = t / (2 tau)

    open_s : (...,) [s], t > 0; decay_s : broadcast [s], inf: 1. Returns (...,) [1].
    """

    def ratio(t: Numeric, tau: Numeric) -> Numeric:
        u = np.maximum(0.5 * t / tau, 1e-4)
        log_c = -_log_sinhc(u)
        by_blur = np.exp(2.0 * log_c) * (1.0 / np.tanh(u) - 1.0 / u) / (-2.0 * np.expm1(2.0 * log_c))
        return by_blur * np.expm1(2.0 * u)

    return _steady_where(np.ones_like(np.asarray(open_s, float)), decay_s, lambda _, tau: ratio(open_s, tau))


def _log_sinhc(u: Numeric) -> Numeric:
    """ln(sinh u / u)."""
    u2 = np.square(u)
    series = u2 * (1 / 6 - u2 * (1 / 180 - u2 * (1 / 2835 - u2 * (1 / 37800 - u2 / 467775))))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        large = u + np.log(-np.expm1(-2.0 * u) / (2.0 * u))
    return np.where(u < _SMALL, series, large)


def _steady_where(value: Numeric, decay_s: Numeric, fading: Any) -> Numeric:
    """A formula of flashes that fade; the value itself of light that stays."""
    if isinstance(decay_s, float):
        return fading(value, decay_s) if np.isfinite(decay_s) else value
    decays = np.isfinite(decay_s)
    if not np.any(decays):
        return value
    return np.where(decays, fading(value, np.where(decays, decay_s, 1.0)), value)[()]
