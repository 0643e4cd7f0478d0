"""Lateral colour against Snell's law ray by ray, and transforms summed without a table."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import optimize

from uwopt.model import lateral

REFERENCE = Path(__file__).parents[1] / "reference"
WAVELENGTH_NM = np.linspace(400.0, 700.0, 61)


def quan_fry() -> np.ndarray:
    """Index of sea water at 10 degC and 35 psu, written out from the published formula."""
    with (REFERENCE / "quan_fry_coefficients.csv").open() as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        n = [float(row["coefficient"]) for row in rows]
    t, s, w = 10.0, 35.0, WAVELENGTH_NM
    cold_and_salt = n[0] + (n[1] + n[2] * t + n[3] * t**2) * s + n[4] * t**2
    return cold_and_salt + (n[5] + n[6] * s + n[7] * t) / w + n[8] / w**2 + n[9] / w**3


N_WATER = quan_fry()
N_DESIGN = float(np.interp(550.0, WAVELENGTH_NM, N_WATER))


def white_led() -> np.ndarray:
    """Electrons per nm: the paper's white lamp times a sensor that peaks at 530 nm."""
    blue = 24.49 / 11.67 * np.exp(-0.5 * ((WAVELENGTH_NM - 450.7) / 11.67) ** 2)
    phosphor = 119.86 / 64.63 * np.exp(-0.5 * ((WAVELENGTH_NM - 565.43) / 64.63) ** 2)
    sensor = np.interp(WAVELENGTH_NM, [400, 450, 530, 600, 650, 700], [0.5, 0.6, 0.66, 0.55, 0.45, 0.33])
    return (blue + phosphor) * sensor * WAVELENGTH_NM


LED = white_led()
ELECTRONS = LED * np.where((WAVELENGTH_NM == 400.0) | (WAVELENGTH_NM == 700.0), 0.5, 1.0)  # trapezoid rule
LAMP = {"n_water": N_WATER, "n_design": N_DESIGN, "electrons": ELECTRONS}
IMX = {"focal_length_m": 8e-3, "pixel_pitch_m": 3.45e-6}
TABLE = lateral.spread_table(WAVELENGTH_NM, electrons_per_nm=LED, n_water=N_WATER)

tangents = st.floats(0.0, 1.2)


def radii_px(angle_air_rad: float) -> np.ndarray:
    """Exact radii by wavelength, 8 mm on 3.45 um, angles through Snell's law."""
    angle_water = math.asin(math.sin(angle_air_rad) / N_DESIGN)
    return 8e-3 / 3.45e-6 * np.tan(np.arcsin(N_WATER * math.sin(angle_water)))


# ---------------------------------------------------------------- the spread


@pytest.mark.parametrize(("angle_water_deg", "rms_px"), [(10.0, 1.2), (20.0, 3.0)])
def test_spread_of_the_physics_page(angle_water_deg: float, rms_px: float) -> None:
    # physics page, section 4; its angles are in water: 0.88 and 1.99 px were they in air
    sine_air = N_DESIGN * math.sin(math.radians(angle_water_deg))
    got = lateral.lateral_colour_px(sine_air / math.sqrt(1 - sine_air**2), **LAMP, **IMX)
    assert got == pytest.approx(rms_px, rel=0.06)  # one digit there, and the sensor is not named


@given(angle=st.floats(0.0, 0.9))
def test_spread_is_the_rms_of_traced_radii(angle: float) -> None:
    r, w = radii_px(angle), ELECTRONS / ELECTRONS.sum()
    expected = math.sqrt(max(np.sum(w * (r - np.sum(w * r)) ** 2), 0.0))
    assert lateral.lateral_colour_px(math.tan(angle), **LAMP, **IMX) == pytest.approx(
        expected, rel=1e-6, abs=1e-9
    )


@given(tangent=tangents)
def test_design_wavelength_keeps_its_place(tangent: float) -> None:
    got = lateral.colour_radius_m(tangent, n_water=N_DESIGN, n_design=N_DESIGN, focal_length_m=8e-3)
    assert got == pytest.approx(8e-3 * tangent, rel=1e-12)


@pytest.mark.parametrize(("angle_deg", "error"), [(10.0, 2e-4), (30.0, 2e-3), (40.0, 4e-3), (60.0, 2.5e-2)])
def test_first_order_spread_is_close(angle_deg: float, error: float) -> None:
    tangent = math.tan(math.radians(angle_deg))
    exact = lateral.lateral_colour_px(tangent, **LAMP, **IMX)
    first = lateral.radius_slope_px(tangent, n_design=N_DESIGN, **IMX) * TABLE.index_rms
    assert first == pytest.approx(exact, rel=error)


def test_slope_is_the_derivative_of_the_radius() -> None:
    h = 1e-5
    up, down = (
        lateral.colour_radius_m(0.7, n_water=N_DESIGN + step, n_design=N_DESIGN, focal_length_m=8e-3)
        for step in (h, -h)
    )
    slope = lateral.radius_slope_px(0.7, n_design=N_DESIGN, **IMX)
    assert slope == pytest.approx((up - down) / (2 * h) / 3.45e-6, rel=1e-8)


def test_a_wavelength_at_grazing_stays_finite() -> None:
    got = lateral.lateral_colour_px(np.array([5.0, 50.0, 1e6]), **LAMP, **IMX)
    assert np.all(np.isfinite(got))


def test_no_electrons_no_spread() -> None:
    dark = {**LAMP, "electrons": np.zeros_like(LED)}
    assert lateral.lateral_colour_px(0.5, **dark, **IMX) == 0.0
    table = lateral.spread_table(WAVELENGTH_NM, electrons_per_nm=0 * LED, n_water=N_WATER)
    assert np.all(lateral.spread_mtf(np.array([0.0, 1e3, 1e9]), table=table) == 1.0)
    single = lateral.spread_table([550.0], electrons_per_nm=[1.0], n_water=[1.34])
    assert lateral.spread_mtf(1e4, table=single) == 1.0


def floor_point_m(tan_air: float, n_water: float, gap_m: float, range_m: float) -> float:
    """Where a ray meets the floor, by angles: 20 mm acrylic of index 1.49."""
    a = math.atan(tan_air)
    glass, water = math.asin(math.sin(a) / 1.49), math.asin(math.sin(a) / n_water)
    return gap_m * tan_air + 0.02 * math.tan(glass) + range_m * math.tan(water)


@pytest.mark.parametrize("tan_air", [0.1, 0.5, 0.9])
@pytest.mark.parametrize(("gap_m", "range_m"), [(0.02, 2.0), (0.05, 0.5)])
def test_share_of_a_near_floor_is_that_of_rays_from_one_point(
    tan_air: float, gap_m: float, range_m: float
) -> None:
    point_m = floor_point_m(tan_air, N_DESIGN, gap_m, range_m)
    r = np.array(
        [
            optimize.brentq(
                lambda t, n=n: floor_point_m(t, n, gap_m, range_m) - point_m, 0.0, 3.0, xtol=1e-15
            )
            for n in N_WATER
        ]
    )
    w = ELECTRONS / ELECTRONS.sum()
    exact_px = math.sqrt(np.sum(w * (r - np.sum(w * r)) ** 2)) * 8e-3 / 3.45e-6
    far_px = lateral.lateral_colour_px(tan_air, **LAMP, **IMX)
    port = {"gap_m": gap_m, "thickness_m": 0.02, "n_glass": 1.49, "n_water": N_DESIGN, "range_m": range_m}
    share = lateral.finite_range_share(tan_air, **port)
    assert share < 0.99
    assert far_px * share == pytest.approx(exact_px, rel=5e-3)  # first order in the index


# ---------------------------------------------------------------- its transform


def direct_transform(phase: np.ndarray) -> float:
    """|sum w exp(i phase)| over 40 times finer wavelengths than the table's."""
    fine = np.linspace(400.0, 700.0, 2401)
    weights = np.interp(fine, WAVELENGTH_NM, LED)
    weights[[0, -1]] /= 2
    return float(abs(np.sum(weights * np.exp(1j * np.interp(fine, WAVELENGTH_NM, phase))) / weights.sum()))


@pytest.mark.parametrize("spread", [0.01, 0.3, 1.0, 1.7, 2.6, 4.56, 9.0, 20.0])
def test_look_up_is_the_sum_over_wavelengths(spread: float) -> None:
    k = spread / TABLE.index_rms
    expected = direct_transform(k * N_WATER)
    assert lateral.spread_mtf(k, table=TABLE) == pytest.approx(expected, abs=2e-4 if spread > 5 else 3e-5)


@pytest.mark.parametrize("angle_deg", [10.0, 25.0, 40.0])
@pytest.mark.parametrize("nu", [0.1, 0.25, 0.5, 1.0])
def test_first_order_transform_is_that_of_exact_radii(angle_deg: float, nu: float) -> None:
    angle = math.radians(angle_deg)
    exact = direct_transform(2 * math.pi * nu * radii_px(angle))
    slope = lateral.radius_slope_px(math.tan(angle), n_design=N_DESIGN, **IMX)
    got = lateral.spread_mtf(2 * math.pi * nu * slope, table=TABLE)
    assert got == pytest.approx(exact, abs=0.004)


def test_two_lines_beat_as_a_cosine() -> None:
    # narrow lines at 450 and 550 nm, index linear: |Phi| = |cos(k dn / 2)| for k small against the lines' width
    wavelength = np.arange(400.0, 600.5, 0.5)
    index = 1.35 - 1e-4 * (wavelength - 400.0)
    lines = np.where(np.isin(wavelength, [450.0, 550.0]), 1.0, 0.0)
    table = lateral.spread_table(wavelength, electrons_per_nm=lines, n_water=index)
    assert table.index_rms == pytest.approx(0.005, rel=1e-9)
    for k in (0.0, 50.0, 150.0, 250.0, 500.0):
        assert lateral.spread_mtf(k, table=table) == pytest.approx(abs(math.cos(k * 0.005)), abs=1e-4)


def test_small_spreads_cost_half_their_square() -> None:
    k = 1e-2 / TABLE.index_rms
    assert 1.0 - lateral.spread_mtf(k, table=TABLE) == pytest.approx(
        0.5e-4, rel=2e-3
    )  # trapezoid rule of the rms, 5 nm


@given(k=st.floats(-1e7, 1e7), more=st.floats(0.0, 1e5))
def test_transform_is_a_share_and_its_least_value_falls(k: float, more: float) -> None:
    assert 0.0 <= lateral.spread_mtf(k, table=TABLE) <= 1.0
    assert lateral.spread_mtf(k, table=TABLE) == lateral.spread_mtf(-k, table=TABLE)
    here = lateral.spread_mtf(abs(k), table=TABLE, falling=True)
    assert here <= lateral.spread_mtf(k, table=TABLE)
    assert lateral.spread_mtf(abs(k) + more, table=TABLE, falling=True) <= here


def test_look_up_is_continuous_at_the_end_of_the_table() -> None:
    end = TABLE.step * (TABLE.magnitude.size - 1)
    inside, outside = lateral.spread_mtf(np.array([1 - 1e-9, 1 + 1e-9]) * end, table=TABLE)
    assert outside == pytest.approx(inside, rel=1e-6)
    assert lateral.spread_mtf(1e3 * end, table=TABLE) == pytest.approx(inside * 1e-3, rel=1e-6)


def test_spread_accepts_symbols(symbol: Any) -> None:
    plates = {"gap_m": 0.02, "thickness_m": 0.01, "n_glass": 1.49, "n_water": 1.34, "range_m": 2.0}
    radius = lateral.colour_radius_m(symbol, n_water=1.345, n_design=1.34, focal_length_m=8e-3)
    slope = lateral.radius_slope_px(symbol, n_design=1.34, **IMX)
    share = lateral.finite_range_share(symbol, **plates)
    function = casadi.Function("colour", [symbol], [radius, slope, share])
    expected = [
        lateral.colour_radius_m(0.6, n_water=1.345, n_design=1.34, focal_length_m=8e-3),
        lateral.radius_slope_px(0.6, n_design=1.34, **IMX),
        lateral.finite_range_share(0.6, **plates),
    ]
    assert [float(value) for value in function(0.6)] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("falling", [False, True])
def test_rows_of_many_spectra_have_each_its_own_transform(falling):
    narrow = lateral.spread_table(
        WAVELENGTH_NM, electrons_per_nm=np.exp(-(((WAVELENGTH_NM - 520.0) / 30.0) ** 2)), n_water=N_WATER
    )
    single = lateral.spread_table([530.0], electrons_per_nm=[1.0], n_water=[1.34])  # spreads nothing
    tables, index = [TABLE, narrow, single], np.array([1, 0, 2, 0, 1, 2])
    k = np.array([40.0, 300.0, 1e4, -900.0, 1e6, 0.0])
    rows = lateral.SpreadRows.of(tables, index)
    alone = [float(lateral.spread_mtf(one, table=tables[n], falling=falling)) for one, n in zip(k, index, strict=True)]
    assert lateral.spread_mtf(k, table=rows, falling=falling).tolist() == alone
    some = np.array([4, 1])
    assert lateral.spread_mtf(k[some], table=rows.take(some), falling=falling).tolist() == [alone[4], alone[1]]
    assert alone[2] == alone[5] == 1.0
    assert 0.0 < alone[4] < alone[0] < 1.0


def test_a_table_that_never_rises_has_what_comes_back_from_the_start() -> None:
    # three numbers, by hand
    table = lateral.SpreadTable(np.array([1.0, 0.2, 0.5, 0.1]), np.array([1.0, 0.2, 0.2, 0.1]), 0.5, 1.0)
    assert lateral.never_rising(table).magnitude.tolist() == [1.0, 0.5, 0.5, 0.1]


def test_colour_in_pixels_is_k_by_the_index_over_a_turn() -> None:
    assert lateral.rms_px(3.0, 4.0, 2.0 * np.pi) == pytest.approx(5.0, rel=1e-15)
