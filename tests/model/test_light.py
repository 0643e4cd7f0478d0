"""Spectral flux, electrical power, pulses and flashes."""

from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt.errors import RangeError
from uwopt.model import light
from uwopt.model.spectrum import integrate_nm, two_gaussian_led, wavelength_grid_nm

REFERENCE = Path(__file__).parents[1] / "reference"
PHOTOPIC = pd.read_csv(REFERENCE / "photopic_v_5nm.csv", comment="#")
GRID_NM = wavelength_grid_nm()
V = np.interp(GRID_NM, PHOTOPIC.wavelength_nm, PHOTOPIC.V)


def test_a_watt_of_555_nm_is_683_lumens() -> None:
    line = np.where(GRID_NM == 555, 1.0, 0.0)
    flux = light.spectral_flux_w_nm(683.002, relative_spectrum=line, wavelength_nm=GRID_NM, photopic=V)
    assert integrate_nm(flux, GRID_NM) == pytest.approx(1.0, rel=1e-12)  # V(555) = 1 by definition


def test_efficacy_of_illuminant_a_cut_to_the_grid_is_that_of_the_tables() -> None:
    # sum of 5 nm products by pandas: 683.002 * sum(V S) / sum(S), ends halved by hand
    a = pd.read_csv(REFERENCE / "cie_illuminant_a.csv", comment="#").set_index("wavelength_nm").relative_power
    v = PHOTOPIC.set_index("wavelength_nm").V
    half_ends = a.copy() * 0 + 1
    half_ends.iloc[[0, -1]] = 0.5
    efficacy = 683.002 * (a * v * half_ends).dropna().sum() / (a * half_ends).sum()
    flux = light.spectral_flux_w_nm(1000.0, relative_spectrum=a.to_numpy(), wavelength_nm=GRID_NM, photopic=V)
    assert 1000 / integrate_nm(flux, GRID_NM) == pytest.approx(efficacy, rel=1e-12)  # rounding


@given(scale=st.floats(1e-6, 1e6), flux_lm=st.floats(1, 1e5))
def test_spectral_flux_holds_the_lumens_whatever_the_scale_of_the_spectrum(
    scale: float, flux_lm: float
) -> None:
    flux = light.spectral_flux_w_nm(
        flux_lm, relative_spectrum=scale * two_gaussian_led(GRID_NM), wavelength_nm=GRID_NM, photopic=V
    )
    assert 683.002 * integrate_nm(V * flux, GRID_NM) == pytest.approx(flux_lm, rel=1e-12)  # rounding


def test_spectral_flux_broadcasts_over_lamps() -> None:
    flux = light.spectral_flux_w_nm(
        np.array([1.0, 2.0]), relative_spectrum=np.ones((2, GRID_NM.size)), wavelength_nm=GRID_NM, photopic=V
    )
    assert flux.shape == (2, GRID_NM.size)
    assert flux[1] == pytest.approx(2 * flux[0])


def test_infrared_has_no_lumens() -> None:
    with pytest.raises(RangeError, match="visible"):
        light.spectral_flux_w_nm(1.0, relative_spectrum=0 * V, wavelength_nm=GRID_NM, photopic=V)


def test_powers_by_hand() -> None:
    assert light.continuous_power_w(0.5, full_power_w=100.0, count=4) == 200.0
    # 0.5 * 100 W * 4 * (2 ms * 5 Hz = 1 %) = 2 W
    pulsed = light.pulsed_led_power_w(0.5, full_power_w=100.0, count=4, pulse_s=2e-3, frame_rate_hz=5.0)
    assert pulsed == pytest.approx(2.0, rel=1e-15)
    # 100 J * 0.5 Hz * 2 = 100 W
    assert light.flash_power_w(100.0, count=2, frame_rate_hz=0.5) == pytest.approx(100.0, rel=1e-15)
    assert light.flash_light_lm_s(100.0, efficacy_lm_s_per_j=35.0) == 3500.0


def test_a_pulse_longer_than_the_frame_burns_all_the_time() -> None:
    assert light.duty_frac(0.3, frame_rate_hz=10.0) == 1.0


def test_power_formulas_run_on_symbols_and_agree_with_floats(symbol: Any) -> None:
    formulas = [
        lambda x: light.continuous_power_w(x, full_power_w=100.0, count=3),
        lambda x: light.pulsed_led_power_w(0.7, full_power_w=9.0, count=2, pulse_s=x, frame_rate_hz=4.0),
        lambda x: light.pulsed_led_power_w(x, full_power_w=9.0, count=2, pulse_s=0.01, frame_rate_hz=4.0),
        lambda x: light.flash_power_w(x, count=2, frame_rate_hz=x),
        lambda x: light.flash_light_lm_s(x, efficacy_lm_s_per_j=35.0),
        lambda x: light.duty_frac(x, frame_rate_hz=7.0),
    ]
    for formula in formulas:
        symbolic = casadi.Function("f", [symbol], [formula(symbol)])
        for value in (0.1, 0.4, 2.0):
            assert float(symbolic(value)) == pytest.approx(formula(value), rel=1e-15)  # same operations
