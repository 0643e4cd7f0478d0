"""What a lamp emits and what it draws: spectral flux, electrical power, pulses and flashes.

The functions for power and pulses take floats, arrays or CasADi symbols.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uwopt.errors import RangeError
from uwopt.model.spectrum import MAX_LUMINOUS_EFFICACY_LM_W, Symbolic, integrate_nm


def spectral_flux_w_nm(
    flux_lm: ArrayLike, *, relative_spectrum: ArrayLike, wavelength_nm: ArrayLike, photopic: ArrayLike
) -> Any:
    """Spectral radiant flux of a lamp of known luminous flux.

        Phi_lambda = Phi_v S / (683.002 * integral of V S d lambda)

    Parameters
    ----------
    flux_lm : (...,) [lm], leaving the lamp; lumen-seconds give energy instead of power
    relative_spectrum : (n,) or (..., n) [any unit per nm], zero or more
    wavelength_nm : (n,) [nm], increasing
    photopic : (n,) [1], luminous efficiency V of the CIE on the same grid

    Returns
    -------
    (..., n) [W nm^-1]

    Notes
    -----
    Valid for photopic lumens. Trapezoid rule. Light beyond the grid counts neither as lumens nor as watts.
    A spectrum without visible light has no lumens to scale by and raises RangeError.

    References
    ----------
    CIE 018:2019. Physics page, section 1.
    """
    spectrum = np.asarray(relative_spectrum, dtype=float)
    luminous = integrate_nm(np.asarray(photopic, dtype=float) * spectrum, wavelength_nm)
    if not np.all(luminous > 0):
        raise RangeError(
            "a spectrum without visible light cannot be scaled to lumens: lamps of infrared alone are not modelled"
        )
    lumens_per_unit = np.asarray(MAX_LUMINOUS_EFFICACY_LM_W * luminous)
    return np.asarray(flux_lm, dtype=float)[..., None] * spectrum / lumens_per_unit[..., None]


def continuous_power_w(level_frac: Symbolic, *, full_power_w: Symbolic, count: Symbolic) -> Symbolic:
    """Mean (and peak) electrical power of lamps that burn all the time: u P count [W]."""
    return level_frac * full_power_w * count


def duty_frac(pulse_s: Symbolic, *, frame_rate_hz: Symbolic) -> Symbolic:
    """Share of the time a lamp is on that pulses once a frame: min(1, t f)."""
    return np.minimum(1.0, pulse_s * frame_rate_hz)


def pulsed_led_power_w(
    level_frac: Symbolic,
    *,
    full_power_w: Symbolic,
    count: Symbolic,
    pulse_s: Symbolic,
    frame_rate_hz: Symbolic,
) -> Symbolic:
    """Mean electrical power of LEDs that are on for one pulse a frame: u P count min(1, t f) [W]."""
    return level_frac * full_power_w * count * duty_frac(pulse_s, frame_rate_hz=frame_rate_hz)


def flash_power_w(energy_j: Symbolic, *, count: Symbolic, frame_rate_hz: Symbolic) -> Symbolic:
    """Mean electrical power of flashes fired once a frame: W f count [W], with the pulse's energy at the supply."""
    return energy_j * frame_rate_hz * count


def flash_peak_power_w(energy_j: Symbolic, *, charging_power_w: Symbolic, frame_rate_hz: Symbolic) -> Symbolic:
    """Highest electrical power of flashes [W], from the supply: max(W_full / recycle time, W f).

    A charger fills its capacitor as fast as it can, at full energy within the recycle time, however long the pause is;
    where that is not known it is taken to fill it over the whole pause.
    """
    return np.maximum(charging_power_w, energy_j * frame_rate_hz)


def flash_light_lm_s(energy_j: Symbolic, *, efficacy_lm_s_per_j: Symbolic) -> Symbolic:
    """Light of one flash from its electrical energy [lm s]; xenon tubes give 30-40 lm s per joule."""
    return energy_j * efficacy_lm_s_per_j


def measured_lumens(angle_deg: ArrayLike, intensity_cd: ArrayLike) -> float:
    """Flux of a lamp [lm] by its intensity over the angle from its axis, both (n,): 2 pi integral of I sin."""
    angle = np.deg2rad(np.asarray(angle_deg, float))
    fine = np.linspace(angle[0], angle[-1], 4001)
    intensity = np.interp(fine, angle, np.asarray(intensity_cd, float))
    return float(2.0 * np.pi * np.trapezoid(intensity * np.sin(fine), fine))
