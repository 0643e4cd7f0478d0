"""The sensor: from irradiance to electrons, digital numbers and signal-to-noise ratio (EMVA 1288).

The linear model of the standard: every pixel counts photons with Poisson noise, adds read noise, and is
digitised. Digital numbers (DN) are those of the transmitted bit depth. Functions marked [sym] also take
CasADi scalars.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Numeric = Any  # float, array that broadcasts, or (where marked [sym]) a CasADi scalar

PLANCK_J_S = 6.62607015e-34  # exact, SI 2019
LIGHT_SPEED_M_S = 299_792_458.0  # exact, SI
QUANTISATION_VARIANCE_DN2 = 1.0 / 12.0  # of a uniform error one DN wide


# ---------------------------------------------------------------- electrons


def electron_rate_per_m2_s_nm(
    irradiance_w_m2_nm: Numeric, *, wavelength_nm: Numeric, quantum_efficiency: Numeric
) -> Numeric:
    """Electrons per second, pixel area and wavelength, E lambda eta / (h c): the integrand of (5).

        mu_e = p^2 t / (h c) * integral of E(lambda) lambda eta(lambda) d lambda                     (5)

    Parameters
    ----------
    irradiance_w_m2_nm : (..., n_wavelength) [W m^-2 nm^-1]
        Arriving at the camera's window; what the window loses belongs to the efficiency.
    wavelength_nm : (n_wavelength,) [nm], in vacuum, increasing
    quantum_efficiency : (..., n_wavelength) or scalar [electrons per photon]
        As EMVA 1288 measures it: fill factor and window are part of it.

    Returns
    -------
    (..., n_wavelength) [m^-2 s^-1 nm^-1]

    References
    ----------
    EMVA Standard 1288, signal model of the linear camera. Physics page, section 6.
    """
    energy_per_photon_j = PLANCK_J_S * LIGHT_SPEED_M_S / (np.asarray(wavelength_nm) * 1e-9)
    return irradiance_w_m2_nm * (quantum_efficiency / energy_per_photon_j)


def colour_mean_efficiency(red: Numeric, *, green: Numeric, blue: Numeric) -> Numeric:
    """Efficiency of a Bayer mosaic taken as one pixel: (R + 2 G + B) / 4 [sym]."""
    return 0.25 * (red + 2.0 * green + blue)


# ---------------------------------------------------------------- gain and digital numbers


def digital_mean_dn(
    electrons_e: Numeric, *, gain_dn_per_e: Numeric, dark_e: Numeric = 0.0, offset_dn: Numeric = 0.0
) -> Numeric:
    """Mean digital number, mu_y = K (mu_d + mu_e) + offset, not clipped at full scale (6) [sym]."""
    return gain_dn_per_e * (dark_e + electrons_e) + offset_dn


def mean_level(
    electrons_e: Numeric,
    *,
    gain_dn_per_e: Numeric,
    bits: Numeric,
    dark_e: Numeric = 0.0,
    offset_dn: Numeric = 0.0,
) -> Numeric:
    """Mean digital number as a share of full scale, mu_y / (2^bits - 1); above 1 is clipped [sym].

    electrons_e counts all light, veils included. Physics page, section 6.
    """
    mean_dn = digital_mean_dn(electrons_e, gain_dn_per_e=gain_dn_per_e, dark_e=dark_e, offset_dn=offset_dn)
    return mean_dn / (2.0**bits - 1.0)


def above_black_dn(level: Numeric, *, full_scale_dn: Numeric, offset_dn: Numeric) -> Numeric:
    """Digital numbers above black at a mean level, level (2^bits - 1) - offset: what gain and light must fill [sym]."""
    return level * full_scale_dn - offset_dn


# ---------------------------------------------------------------- signal to noise


def noise_variance_e2(
    all_light_e: Numeric,
    *,
    read_noise_e: Numeric,
    gain_dn_per_e: Numeric,
    dark_e: Numeric = 0.0,
    prnu_frac: Numeric = 0.0,
) -> Numeric:
    """Variance of one pixel [e^2]: sigma_d^2 + sigma_q^2/K^2 + dark + all + (PRNU all)^2 [sym]."""
    floor_e2 = read_noise_e**2 + QUANTISATION_VARIANCE_DN2 / gain_dn_per_e**2 + dark_e
    return floor_e2 + all_light_e + (prnu_frac * all_light_e) ** 2


def snr(
    signal_e: Numeric,
    *,
    read_noise_e: Numeric,
    gain_dn_per_e: Numeric,
    veil_e: Numeric = 0.0,
    dark_e: Numeric = 0.0,
    prnu_frac: Numeric = 0.0,
) -> Numeric:
    """Signal-to-noise ratio of one pixel.

        SNR = mu / sqrt(sigma_d^2 + sigma_q^2/K^2 + mu_all + mu_dark + (PRNU mu_all)^2)              (7) [sym]

    Parameters
    ----------
    signal_e : (...,) [e], mu, image-forming electrons
    read_noise_e : broadcast [e], sigma_d, temporal dark noise
    gain_dn_per_e : broadcast [DN/e], K in the transmitted image
    veil_e : broadcast [e], light that forms no image; mu_all = mu + veil
    dark_e : broadcast [e], of the dark current
    prnu_frac : broadcast, photo response non-uniformity, left uncorrected

    Returns
    -------
    (...,) a ratio of amplitudes, not decibel.

    Notes
    -----
    With veil, dark and PRNU zero this is the paper's equation. sigma_q^2 = 1/12 DN^2.

    References
    ----------
    EMVA Standard 1288. Physics page, section 6.
    """
    variance_e2 = noise_variance_e2(
        signal_e + veil_e,
        read_noise_e=read_noise_e,
        gain_dn_per_e=gain_dn_per_e,
        dark_e=dark_e,
        prnu_frac=prnu_frac,
    )
    return signal_e / np.sqrt(variance_e2)


def electrons_for_snr(
    snr: Numeric,
    *,
    noise_variance_e2: Numeric,
    veil_ratio: Numeric = 0.0,
    quantisation_frac: Numeric = 0.0,
    prnu_frac: Numeric = 0.0,
) -> Numeric:
    """Fewest image-forming electrons that reach a wanted SNR, when veils grow with the signal.

        mu^2 = S^2 (sigma^2 + (1 + kappa) mu + b mu^2),   b = q^2 + (PRNU (1 + kappa))^2
        mu = [S^2 (1 + kappa) + sqrt(S^4 (1 + kappa)^2 + 4 S^2 sigma^2 (1 - S^2 b))] / (2 (1 - S^2 b))

    Parameters
    ----------
    snr : (...,) S, a ratio
    noise_variance_e2 : broadcast [e^2], sigma^2: read noise, quantisation at a fixed gain, dark current, and
        light that does not scale with the lamps
    veil_ratio : broadcast, kappa, veil over image-forming electrons
    quantisation_frac : broadcast, q, when the gain follows the signal so that the image-forming electrons
        always make T digital numbers: q = 1 / (T sqrt(12)), and quantisation is not in sigma^2
    prnu_frac : broadcast

    Returns
    -------
    (...,) [e]; inf where no amount of light is enough (S^2 b >= 1).

    Notes
    -----
    PRNU acts on the lamps' light only: that of sun or other constant light belongs to sigma^2, where its
    cross term with the signal is missing.

    References
    ----------
    Physics page, section 6.
    """
    snr2 = snr**2
    slope = snr2 * (1.0 + veil_ratio)
    left = 1.0 - snr2 * (quantisation_frac**2 + (prnu_frac * (1.0 + veil_ratio)) ** 2)
    reachable = np.where(left > 0.0, left, 1.0)
    root = np.sqrt(slope**2 + 4.0 * snr2 * noise_variance_e2 * reachable)
    return np.where(left > 0.0, 0.5 * (slope + root) / reachable, np.inf)[()]


def light_for_snr(
    snr: Numeric,
    *,
    signal_per_light_e: Numeric,
    read_noise_e: Numeric,
    total_per_light_e: Numeric | None = None,
    dark_e: Numeric = 0.0,
    prnu_frac: Numeric = 0.0,
    gain_dn_per_e: Numeric = np.inf,
    level_per_light_e: Numeric = 0.0,
    level_dn: Numeric = np.inf,
    other_signal_e: Numeric = 0.0,
    other_light_e: Numeric = 0.0,
    other_level_e: Numeric = 0.0,
) -> Numeric:
    """Least light X whose signal C X reaches a wanted SNR; the inverse of (7) with X in place of electrons.

        (C X + s)^2 = S^2 (sigma_d^2 + sigma_q^2 / K^2 + mu_dark + A X + a + (PRNU (A X + a))^2)
        1 / K = 1 / gain, or (L X + l + mu_dark) / T where the gain keeps some level at T digital numbers

    Parameters
    ----------
    snr : (...,) S, a ratio; 0 asks for no light
    signal_per_light_e : broadcast [e per unit of light], C
    total_per_light_e : broadcast, A, all light that grows with the lamps; C when not given
    read_noise_e, dark_e, prnu_frac : broadcast, as in `snr`
    gain_dn_per_e : broadcast [DN per electron], a gain that does not depend on the light
    level_per_light_e, level_dn : broadcast, L [e per unit of light] and T [DN] of a gain that follows it
    other_signal_e, other_light_e, other_level_e : broadcast [e], s, a and l: image-forming electrons, all
        electrons and those of the level that do not grow with the lamps (the sun's)

    Returns
    -------
    (...,) in the unit of light, inf where no amount is enough, 0 where none is needed.

    Notes
    -----
    A quadratic in X with one positive root while the noise that grows with X stays below the signal.
    With other light that is enough by itself the answer is 0, though lamps with much more veil than
    signal could undo it.

    References
    ----------
    Physics page, section 6.
    """
    total = signal_per_light_e if total_per_light_e is None else total_per_light_e
    follow = QUANTISATION_VARIANCE_DN2 / level_dn**2
    fixed = QUANTISATION_VARIANCE_DN2 / gain_dn_per_e**2
    snr2, prnu2 = snr**2, prnu_frac**2
    base_e = dark_e + other_level_e
    square = signal_per_light_e**2 - snr2 * (prnu2 * total**2 + follow * level_per_light_e**2)
    noise_slope = snr2 * (
        total * (1.0 + 2.0 * prnu2 * other_light_e) + 2.0 * follow * level_per_light_e * base_e
    )
    helped = bool(other_signal_e if isinstance(other_signal_e, float) else np.any(other_signal_e))
    half = 0.5 * noise_slope - signal_per_light_e * other_signal_e if helped else 0.5 * noise_slope
    noise_floor = (
        read_noise_e**2 + fixed + dark_e + other_light_e + prnu2 * other_light_e**2 + follow * base_e**2
    )
    floor = snr2 * noise_floor - other_signal_e**2
    reachable = np.where(square > 0.0, square, 1.0)
    wanting = np.maximum(floor, 0.0)
    middle = np.sqrt(half**2 + reachable * wanting)
    root = (half + middle) / reachable
    if helped:  # the larger root, written so that nothing cancels where the slope is negative
        away = middle - half
        root = np.where(half >= 0.0, root, wanting / np.where(away > 0.0, away, 1.0))
    enough = (snr2 == 0.0) | (floor < 0.0) | ((floor == 0.0) & (half <= 0.0))
    return np.where(enough, 0.0, np.where(square > 0.0, root, np.inf))[()]


def white_balance(channels_e: Numeric) -> Numeric:
    """Ratio of the strongest to the weakest channel of a grey floor, max mu_c / min mu_c over the channels c.

    Parameters
    ----------
    channels_e : (..., n_channels) [e], image-forming electrons of each channel, not negative

    Returns
    -------
    (...,) at least 1: the largest gain that makes grey look grey; inf where a channel sees nothing, 1 where none does.

    Notes
    -----
    Valid for gains that a camera applies to each channel as a whole; veils, which look grey to nobody, are left out.

    References
    ----------
    EMVA Standard 1288, signal of each channel; physics page, section 6.
    """
    most, least = np.max(channels_e, axis=-1), np.min(channels_e, axis=-1)
    seen = least > 0.0
    return np.where(seen, most / np.where(seen, least, 1.0), np.where(most > 0.0, np.inf, 1.0))[()]
