"""The sensor: electrons, digital numbers and noise, by hand, by mpmath and by simulated pixels."""

import math
from typing import Any

import casadi
import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.physics import photo_electrons

from uwopt.model import sensor

IMX250 = {"read_noise_e": 2.44, "gain_dn_per_e": 5.556}  # 16-bit numbers

signals = st.floats(1e-3, 1e6)
noises = st.floats(0.5, 50.0)
gains = st.floats(0.01, 10.0)
ratios = st.floats(0.0, 3.0)


# ---------------------------------------------------------------- electrons

WAVELENGTH_NM = np.arange(500.0, 601.0, 1.0)
CASE: dict[str, Any] = {
    "wavelength_nm": WAVELENGTH_NM,
    "quantum_efficiency": 0.6,
    "pixel_pitch_m": 3.45e-6,
    "exposure_s": 0.010,
}


def test_flat_spectrum_matches_closed_form() -> None:
    # E = 1e-5 W/m2/nm on 500-600 nm: integral of E lambda d lambda = 1e-5 (600^2 - 500^2) / 2 = 0.55 nm W/m2
    # 0.6 (3.45e-6)^2 0.010 * 0.55e-9 / (h c) = 197.73 electrons, by hand
    got = photo_electrons(np.full(101, 1e-5), **CASE)
    assert got == pytest.approx(197.73, rel=1e-4)  # rounding of the hand value


def test_one_photon_per_pixel_and_second_is_one_electron() -> None:
    # 555 nm: h c / lambda = 3.579182e-19 J; a line one nm wide (two half steps of the trapezoid)
    line = np.where(WAVELENGTH_NM == 555.0, 3.5791817e-19 / (3.45e-6) ** 2, 0.0)
    perfect = CASE | {"quantum_efficiency": 1.0, "exposure_s": 1.0}
    assert photo_electrons(line, **perfect) == pytest.approx(1.0, rel=1e-6)


@given(factor=st.floats(0.01, 100.0))
def test_electrons_grow_linearly_with_exposure(factor: float) -> None:
    once = photo_electrons(np.full(101, 1e-5), **CASE)
    longer = photo_electrons(np.full(101, 1e-5), **CASE | {"exposure_s": 0.010 * factor})
    assert longer == pytest.approx(factor * once, rel=1e-12)


def test_designs_broadcast_over_the_leading_axes() -> None:
    irradiance = np.full((4, 3, 101), 1e-5)
    pitch_m = np.array([2e-6, 4e-6, 8e-6])
    got = photo_electrons(irradiance, **CASE | {"pixel_pitch_m": pitch_m})
    assert got.shape == (4, 3)
    np.testing.assert_allclose(got[0] / got[0, 0], [1.0, 4.0, 16.0])


def test_a_bayer_mosaic_has_two_green_pixels_in_four() -> None:
    assert sensor.colour_mean_efficiency(0.4, green=0.6, blue=0.2) == pytest.approx(0.45)


# ---------------------------------------------------------------- gain and digital numbers


def test_digital_mean_and_level_by_hand() -> None:
    # 0.5 * (3 + 100) + 64 = 115.5 DN of 1023
    camera = {"gain_dn_per_e": 0.5, "dark_e": 3.0, "offset_dn": 64.0}
    assert sensor.digital_mean_dn(100.0, **camera) == pytest.approx(115.5)
    assert sensor.mean_level(100.0, bits=10, **camera) == pytest.approx(115.5 / 1023.0)


# ---------------------------------------------------------------- signal to noise


def test_papers_snr_by_hand() -> None:
    # 100 / sqrt(2.44^2 + 1/12/5.556^2 + 100) = 100 / sqrt(105.9563) = 9.714861
    assert sensor.snr(100.0, **IMX250) == pytest.approx(9.714861, rel=1e-6)


def test_full_snr_by_hand() -> None:
    # all 150, dark 5, PRNU 1 %: 100 / sqrt(5.9536 + 0.0027 + 150 + 5 + 2.25) = 7.827653
    got = sensor.snr(100.0, veil_e=50.0, dark_e=5.0, prnu_frac=0.01, **IMX250)
    assert got == pytest.approx(7.827653, rel=1e-6)


def test_simulated_pixels_have_that_snr() -> None:
    # Poisson light and dark, normal read noise, rounding to whole numbers: mean over spread of 400 000 pixels
    rng = np.random.default_rng(1)
    count, gain = 400_000, 0.3
    electrons = rng.poisson(80.0 + 20.0, count) + rng.poisson(6.0, count) + rng.normal(0.0, 3.0, count)
    numbers = np.round(gain * electrons)
    got = sensor.snr(80.0, read_noise_e=3.0, gain_dn_per_e=gain, veil_e=20.0, dark_e=6.0)
    assert got == pytest.approx(80.0 * gain / numbers.std(), rel=5e-3)  # 1/sqrt(2 * 400 000) = 0.1 %, 4 sigma


def test_with_much_light_snr_is_the_square_root_of_the_electrons() -> None:
    assert sensor.snr(1e8, **IMX250) == pytest.approx(1e4, rel=1e-6)


@given(signal=signals, more=st.floats(1.001, 10.0))
def test_snr_rises_with_light(signal: float, more: float) -> None:
    assert sensor.snr(more * signal, prnu_frac=0.01, **IMX250) > sensor.snr(signal, prnu_frac=0.01, **IMX250)


# ---------------------------------------------------------------- light for a wanted ratio


def test_electrons_for_an_snr_is_the_physics_pages_closed_form() -> None:
    # S = 10, kappa = 0.5, sigma^2 = 6: (150 + sqrt(22500 + 2400)) / 2 = 153.8987
    got = sensor.electrons_for_snr(10.0, noise_variance_e2=6.0, veil_ratio=0.5)
    assert got == pytest.approx(153.8987, rel=1e-6)


@settings(deadline=None)  # a loaded machine is no failure
@given(snr=st.floats(0.1, 60.0), sigma2=st.floats(0.1, 400.0), kappa=ratios, q=st.floats(0.0, 0.01))
def test_electrons_for_an_snr_solve_the_noise_equation(
    snr: float, sigma2: float, kappa: float, q: float
) -> None:
    prnu = 0.003

    def shortfall(log_mu: Any) -> Any:
        mu = mpmath.e**log_mu
        variance = sigma2 + (1 + kappa) * mu + (q * mu) ** 2 + (prnu * (1 + kappa) * mu) ** 2
        return mpmath.log(mu / mpmath.sqrt(variance)) - mpmath.log(snr)

    root = float(mpmath.exp(mpmath.findroot(shortfall, (-20, 60), solver="bisect", tol=1e-14, maxsteps=300)))
    got = sensor.electrons_for_snr(
        snr, noise_variance_e2=sigma2, veil_ratio=kappa, quantisation_frac=q, prnu_frac=prnu
    )
    assert got == pytest.approx(root, rel=1e-6)


@given(snr=st.floats(0.1, 100.0), read=noises, gain=gains, kappa=ratios)
def test_electrons_for_an_snr_inverts_the_snr(snr: float, read: float, gain: float, kappa: float) -> None:
    sigma2 = read**2 + 1.0 / 12.0 / gain**2
    mu = sensor.electrons_for_snr(snr, noise_variance_e2=sigma2, veil_ratio=kappa)
    assert sensor.snr(mu, read_noise_e=read, gain_dn_per_e=gain, veil_e=kappa * mu) == pytest.approx(snr)


def test_gain_that_follows_the_signal_counts_as_relative_noise() -> None:
    # an image kept at T = 100 DN: K = T / mu, and q = 1 / (T sqrt(12))
    target_dn = 100.0
    mu = sensor.electrons_for_snr(
        20.0, noise_variance_e2=6.0, quantisation_frac=1.0 / (target_dn * math.sqrt(12.0))
    )
    back = sensor.snr(mu, read_noise_e=math.sqrt(6.0), gain_dn_per_e=target_dn / mu)
    assert back == pytest.approx(20.0, rel=1e-12)


def test_beyond_the_pixels_non_uniformity_no_light_is_enough() -> None:
    # PRNU 1 % caps SNR at 100
    got = sensor.electrons_for_snr(np.array([99.0, 100.0, 101.0]), noise_variance_e2=6.0, prnu_frac=0.01)
    assert np.isfinite(got[0])
    np.testing.assert_array_equal(got[1:], np.inf)


@given(
    snr=st.floats(0.1, 60.0),
    per_light=st.floats(1e-3, 1e3),
    veil=ratios,
    read=noises,
    dark=st.floats(0.0, 50.0),
)
def test_light_for_an_snr_inverts_the_snr_at_a_fixed_gain(
    snr: float, per_light: float, veil: float, read: float, dark: float
) -> None:
    pixel = {"read_noise_e": read, "dark_e": dark, "prnu_frac": 0.003, "gain_dn_per_e": 0.2}
    light = sensor.light_for_snr(
        snr, signal_per_light_e=per_light, total_per_light_e=(1.0 + veil) * per_light, **pixel
    )
    signal_e = per_light * light
    assert sensor.snr(signal_e, veil_e=veil * signal_e, **pixel) == pytest.approx(snr, rel=1e-9)


@given(snr=st.floats(0.1, 30.0), per_light=st.floats(1e-3, 1e3), dark=st.floats(0.0, 50.0))
def test_light_for_an_snr_inverts_the_snr_when_the_gain_holds_a_level(
    snr: float, per_light: float, dark: float
) -> None:
    # the nominal pixel, twice as bright as this one, and its dark electrons make 500 DN
    pixel = {"read_noise_e": 3.0, "dark_e": dark, "prnu_frac": 0.003}
    light = sensor.light_for_snr(
        snr, signal_per_light_e=per_light, level_per_light_e=2.0 * per_light, level_dn=500.0, **pixel
    )
    gain = 500.0 / (2.0 * per_light * light + dark)
    assert sensor.snr(per_light * light, gain_dn_per_e=gain, **pixel) == pytest.approx(snr, rel=1e-9)


def test_no_wish_needs_no_light_and_an_impossible_wish_infinite_light() -> None:
    got = sensor.light_for_snr(
        np.array([0.0, 200.0]), signal_per_light_e=np.array([0.0, 1.0]), read_noise_e=2.0, prnu_frac=0.01
    )
    np.testing.assert_array_equal(got, [0.0, np.inf])


def test_sensor_accepts_symbols(symbol: Any) -> None:
    function = casadi.Function(
        "sensor",
        [symbol],
        [
            sensor.snr(symbol, veil_e=5.0, dark_e=1.0, prnu_frac=0.01, **IMX250),
            sensor.digital_mean_dn(symbol, gain_dn_per_e=0.5, dark_e=3.0, offset_dn=64.0),
            sensor.mean_level(symbol, gain_dn_per_e=0.5, bits=10),
        ],
    )
    got = [float(value) for value in function(100.0)]
    plain = sensor.snr(100.0, veil_e=5.0, dark_e=1.0, prnu_frac=0.01, **IMX250)
    assert got == pytest.approx([plain, 115.5, 50.0 / 1023.0], rel=1e-12)


@pytest.mark.parametrize(("other_signal_e", "other_veil_e"), [(40.0, 10.0), (300.0, 0.0), (5.0, 200.0)])
def test_light_for_an_snr_counts_what_the_sun_brings(other_signal_e: float, other_veil_e: float) -> None:
    pixel = {"read_noise_e": 3.0, "dark_e": 20.0, "prnu_frac": 0.004, "gain_dn_per_e": 0.3}
    light = sensor.light_for_snr(
        30.0, signal_per_light_e=2.0, total_per_light_e=2.5, other_signal_e=other_signal_e,
        other_light_e=other_signal_e + other_veil_e, **pixel,
    )  # fmt: skip
    assert light > 0.0
    reached = sensor.snr(2.0 * light + other_signal_e, veil_e=0.5 * light + other_veil_e, **pixel)
    assert reached == pytest.approx(30.0, rel=1e-12)


def test_light_for_an_snr_holds_a_level_that_the_sun_fills_too() -> None:
    # gain 500 DN over all electrons of the nominal pixel: lamps 3 a unit of light, sun 80, dark 20
    light = sensor.light_for_snr(
        30.0, signal_per_light_e=2.0, read_noise_e=3.0, dark_e=20.0, level_per_light_e=3.0, level_dn=500.0,
        other_signal_e=60.0, other_light_e=60.0, other_level_e=80.0,
    )  # fmt: skip
    gain = 500.0 / (3.0 * light + 80.0 + 20.0)
    reached = sensor.snr(2.0 * light + 60.0, read_noise_e=3.0, dark_e=20.0, gain_dn_per_e=gain)
    assert reached == pytest.approx(30.0, rel=1e-12)


@pytest.mark.parametrize("enough", [True, False])
def test_sun_alone_may_be_enough(enough: bool) -> None:
    # 900 electrons have an SNR of 900 / sqrt(900 + 9) = 29.85 without quantisation
    wanted = 29.8 if enough else 29.9
    light = sensor.light_for_snr(
        wanted, signal_per_light_e=1.0, read_noise_e=3.0, other_signal_e=900.0, other_light_e=900.0
    )
    assert bool(light == 0.0) is enough
