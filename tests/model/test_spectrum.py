"""Wavelength grids, integrals and spectra that are formulas."""

from pathlib import Path

import mpmath
import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt.errors import RangeError
from uwopt.model.spectrum import (
    LIGHT_SPEED_M_S,
    PLANCK_J_S,
    integrate_nm,
    planck_spectrum,
    resample,
    trapezoid_weights_nm,
    two_gaussian_led,
    wavelength_grid_nm,
)

REFERENCE = Path(__file__).parents[1] / "reference"


def test_default_grid_has_both_ends_and_81_points() -> None:
    grid = wavelength_grid_nm()
    assert (grid[0], grid[-1], grid.size) == (380.0, 780.0, 81)
    assert np.all(np.diff(grid) == 5.0)


@pytest.mark.parametrize("step_nm", [0.0, -5.0, 7.0, 1000.0])
def test_a_step_that_does_not_divide_the_span_is_refused(step_nm: float) -> None:
    with pytest.raises(RangeError, match="nm"):
        wavelength_grid_nm(step_nm)


def test_photon_energy_at_555_nm_is_the_known_value() -> None:
    # h c = 1239.841984 eV nm (CODATA 2018), e = 1.602176634e-19 C: 3.57919e-19 J at 555 nm
    expected = 1239.841984 * 1.602176634e-19 / 555
    assert (
        pytest.approx(expected, rel=1e-9) == PLANCK_J_S * LIGHT_SPEED_M_S / 555e-9
    )  # digits of CODATA's h c


def test_integral_is_exact_for_broken_lines_on_an_uneven_grid() -> None:
    # f = |x - 500| on 400..700 with a node at the kink: 100^2/2 + 200^2/2 = 25000
    grid = np.array([400.0, 430.0, 500.0, 505.0, 700.0])
    assert integrate_nm(np.abs(grid - 500), grid) == pytest.approx(25_000, rel=1e-14)  # rounding


@given(st.lists(st.floats(1, 50), min_size=1, max_size=12))
def test_weights_add_up_to_the_span(steps: list[float]) -> None:
    grid = 380 + np.cumsum([0.0, *steps])
    assert trapezoid_weights_nm(grid).sum() == pytest.approx(grid[-1] - grid[0], rel=1e-12)  # rounding


def test_integral_works_on_the_last_axis() -> None:
    grid = wavelength_grid_nm()
    values = np.ones((3, 2, grid.size)) * np.arange(1, 4)[:, None, None]
    assert integrate_nm(values, grid) == pytest.approx(400.0 * np.array([[1, 1], [2, 2], [3, 3]]))


@pytest.mark.parametrize("grid", [[500.0], [500.0, 500.0], [600.0, 500.0], [[400.0, 500.0]]])
def test_a_grid_that_does_not_increase_is_refused(grid: list[float]) -> None:
    with pytest.raises(RangeError, match="increasing"):
        trapezoid_weights_nm(grid)


def test_resample_is_linear_inside_and_follows_the_rule_outside() -> None:
    table = {"table_nm": [400.0, 500.0, 700.0], "table_values": [1.0, 3.0, 2.0]}
    at = [390.0, 400.0, 450.0, 600.0, 700.0, 701.0]
    assert resample(at, **table, outside="zero") == pytest.approx([0, 1, 2, 2.5, 2, 0])
    assert resample(at, **table, outside="hold") == pytest.approx([1, 1, 2, 2.5, 2, 2])
    assert resample(at[1:-1], **table, outside="raise") == pytest.approx([1, 2, 2.5, 2])


def test_resample_names_both_gaps() -> None:
    with pytest.raises(RangeError, match=r"380-400 nm and 700-780 nm .* 400-700 nm"):
        resample(wavelength_grid_nm(), table_nm=[400, 700], table_values=[1, 1], outside="raise")


def test_planck_reproduces_cie_illuminant_a() -> None:
    # Illuminant A has c2/T = 1.435e7/2848 nm by definition: T = 2855.5 K with the c2 of the SI.
    table = pd.read_csv(REFERENCE / "cie_illuminant_a.csv", comment="#")
    temperature_k = 1.438776877e7 * 2848 / 1.435e7
    ours = 100 * planck_spectrum(table.wavelength_nm, temperature_k=temperature_k)
    assert ours == pytest.approx(table.relative_power.to_numpy(), rel=5e-6)  # six printed digits


@given(st.floats(200, 20_000))
def test_planck_peaks_where_wien_says(temperature_k: float) -> None:
    peak_nm = 2.897771955e6 / temperature_k  # CODATA 2018
    around = planck_spectrum(peak_nm * np.array([0.99, 1.0, 1.01]), temperature_k=temperature_k)
    assert around[1] > around[0]
    assert around[1] > around[2]


def test_planck_needs_a_warm_body() -> None:
    with pytest.raises(RangeError):
        planck_spectrum(500.0, temperature_k=0.0)


def test_generic_led_holds_the_areas_of_its_two_lines() -> None:
    # normal densities integrate to 1 each: 24.49 + 119.86 over all wavelengths
    assert integrate_nm(two_gaussian_led(np.arange(0, 1200.0)), np.arange(0, 1200.0)) == pytest.approx(144.35)
    x = mpmath.mpf("450.7")
    by_mpmath = mpmath.mpf("24.49") * mpmath.npdf(x, 450.70, 11.67) + 119.86 * mpmath.npdf(x, 565.43, 64.63)
    assert two_gaussian_led(450.7) == pytest.approx(float(by_mpmath), rel=1e-13)  # rounding


def test_default_step_integrates_the_led_to_one_part_in_ten_thousand() -> None:
    grid = wavelength_grid_nm()
    exact = sum(
        area * (mpmath.ncdf(780, mean, sigma) - mpmath.ncdf(380, mean, sigma))
        for area, mean, sigma in ((24.49, 450.70, 11.67), (119.86, 565.43, 64.63))
    )
    # trapezoid rule, 5 nm: end slopes h^2/12 f' leave about 1e-5
    assert integrate_nm(two_gaussian_led(grid), grid) == pytest.approx(float(exact), rel=1e-4)
