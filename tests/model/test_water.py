"""Attenuation, refractive index, and the contraction of a spectrum over two paths."""

from pathlib import Path
from typing import Any

import casadi
import jerlov
import mpmath
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import logsumexp

from uwopt.errors import RangeError
from uwopt.model import path_table, water
from uwopt.model.spectrum import planck_spectrum, two_gaussian_led, wavelength_grid_nm

REFERENCE = Path(__file__).parents[1] / "reference"
JERLOV = pd.read_csv(REFERENCE / "jerlov_iop_four_types.csv", comment="#")
PURE = pd.read_csv(REFERENCE / "pure_water_absorption.csv", comment="#")
QUAN_FRY = pd.read_csv(REFERENCE / "quan_fry_coefficients.csv", comment="#").coefficient.tolist()
GRID_NM = wavelength_grid_nm()
LED_WEIGHT = two_gaussian_led(GRID_NM) * GRID_NM
PURE_WATER = {"pure_water_nm": PURE.wavelength_nm, "pure_water_a_per_m": PURE.a_per_m}


def optics(water_type: str) -> dict[str, Any]:
    """Grid and attenuations of the two paths in one Jerlov type."""
    table = JERLOV[JERLOV.water_type == water_type]
    a = water.extend_absorption_per_m(
        GRID_NM, table_nm=table.wavelength_nm, table_a_per_m=table.a_per_m, **PURE_WATER
    )
    b = np.interp(GRID_NM, table.wavelength_nm, table.b_per_m)
    kd = np.interp(GRID_NM, table.wavelength_nm, table.kd_per_m)
    k = water.illumination_attenuation_per_m(a, b_per_m=b, kd_per_m=kd, backscatter_ratio=0.0183)
    return {"wavelength_nm": GRID_NM, "k_lamp_per_m": k, "c_camera_per_m": water.beam_attenuation_per_m(a, b)}


def summed_log_transmission(
    weight: Any, *, wavelength_nm: Any, k_lamp_per_m: Any, c_camera_per_m: Any, lamp_m: Any, camera_m: Any
) -> Any:
    """ln of the mean transmission by the trapezoid sum over the spectrum."""
    share = weight * np.convolve(np.diff(wavelength_nm), [0.5, 0.5], "full")
    share[[0, -1]] = weight[[0, -1]] * np.diff(wavelength_nm)[[0, -1]] / 2
    exponent = -np.multiply.outer(lamp_m, k_lamp_per_m) - np.multiply.outer(camera_m, c_camera_per_m)
    return logsumexp(exponent, b=share / share.sum(), axis=-1)


def test_beam_attenuation_agrees_with_the_jerlov_package() -> None:
    theirs = jerlov.water("II", source="solonenko2015")
    table = JERLOV[JERLOV.water_type == "II"]
    inside = table[table.wavelength_nm.between(400, 700)]
    ours = water.beam_attenuation_per_m(inside.a_per_m.to_numpy(), inside.b_per_m.to_numpy())
    assert ours == pytest.approx(theirs.c(inside.wavelength_nm.to_numpy()), rel=1e-12)  # same printed table


def test_lamp_attenuation_is_kd_within_physical_bounds() -> None:
    # a = 0.1, b = 0.2, ratio 0.05: K_d below 0.11 and above 0.3 is clipped
    k = water.illumination_attenuation_per_m(
        0.1, b_per_m=0.2, kd_per_m=np.array([0.05, 0.2, 0.9]), backscatter_ratio=0.05
    )
    assert k == pytest.approx([0.11, 0.2, 0.3])


def test_absorption_continues_with_pure_water_beyond_the_table() -> None:
    # the table of type II ends at 700 nm; pure water's rise from there is added
    table = JERLOV[JERLOV.water_type == "II"].set_index("wavelength_nm")
    pure = PURE.set_index("wavelength_nm").a_per_m
    by_hand = table.a_per_m[700] + pure[750] - pure[700]
    ours = water.extend_absorption_per_m(
        [550.0, 700.0, 750.0], table_nm=table.index, table_a_per_m=table.a_per_m, **PURE_WATER
    )
    assert ours == pytest.approx([table.a_per_m[550], table.a_per_m[700], by_hand], rel=1e-14)  # rounding


def test_absorption_never_falls_below_zero_and_names_missing_pure_water() -> None:
    table = {"table_nm": [400.0, 750.0], "table_a_per_m": [0.01, 0.2]}
    falling = {"pure_water_nm": [700.0, 800.0], "pure_water_a_per_m": [3.0, 0.0]}
    assert water.extend_absorption_per_m([800.0], **table, **falling) == 0.0
    with pytest.raises(RangeError, match="800-810 nm"):
        water.extend_absorption_per_m([810.0], **table, **falling)
    inside = water.extend_absorption_per_m(
        [500.0], **table, pure_water_nm=[1.0, 2.0], pure_water_a_per_m=[0, 0]
    )
    assert inside == pytest.approx(0.01 + 0.19 * 100 / 350)  # no pure water needed inside


@pytest.mark.parametrize("kind", ["SX", "MX"])
def test_index_runs_on_symbols(kind: str) -> None:
    mode = casadi.GlobalOptions.getNumpyMode()
    casadi.GlobalOptions.setNumpyMode(1)
    try:
        x = getattr(casadi, kind).sym("x")
        index = water.refractive_index_quan_fry(
            550.0, temperature_c=x, salinity_psu=35.0, coefficients=QUAN_FRY
        )
        n = casadi.Function("n", [x], [index])
        assert float(n(15.0)) == pytest.approx(1.341266, abs=1e-6)  # same formula, tabulated elsewhere
    finally:
        casadi.GlobalOptions.setNumpyMode(mode)


@pytest.mark.parametrize(
    ("wavelength_nm", "temperature_c", "salinity_psu", "expected"),
    [
        (589.3, 20.0, 0.0, 1.33300),  # distilled water at the sodium line, handbooks
        (589.0, 20.0, 35.0, 1.33941),  # sea water, Quan and Fry (1995)
        (500.0, 15.0, 35.0, 1.34345),  # a table computed elsewhere from the same coefficients
    ],
)
def test_refractive_index_of_known_waters(
    wavelength_nm: float, temperature_c: float, salinity_psu: float, expected: float
) -> None:
    n = water.refractive_index_quan_fry(
        wavelength_nm, temperature_c=temperature_c, salinity_psu=salinity_psu, coefficients=QUAN_FRY
    )
    assert n == pytest.approx(expected, abs=2e-5)  # last printed digit, and the fit's own error


def test_refractive_index_needs_ten_coefficients() -> None:
    with pytest.raises(RangeError, match="10"):
        water.refractive_index_quan_fry(550.0, temperature_c=10, salinity_psu=35, coefficients=QUAN_FRY[:9])


def test_mean_transmission_of_linear_spectra_agrees_with_mpmath() -> None:
    # weight 1, K = c = 0.01 (l - 380) on 380..780: (1 - exp(-4 R)) / (4 R), R = 3 m
    grid = np.linspace(380, 780, 20_001)
    k = 0.01 * (grid - 380)
    exact = mpmath.quad(lambda x: mpmath.exp(-mpmath.mpf(3) * x / 100), [0, 400]) / 400
    table = path_table.build_path_table(
        np.ones_like(grid),
        wavelength_nm=grid,
        k_lamp_per_m=k,
        c_camera_per_m=k,
        lamp_range_m=(1.0, 1.0),
        camera_range_m=(2.0, 2.0),
    )
    ours = np.exp(path_table.log_mean_transmission(table, 1.0, 2.0))
    assert ours == pytest.approx(float(exact), rel=1e-6)  # trapezoid step 0.02 nm: (0.03 * 0.02)^2 / 12


def test_grey_water_gives_beers_law() -> None:
    table = path_table.build_path_table(
        LED_WEIGHT,
        wavelength_nm=GRID_NM,
        k_lamp_per_m=np.full_like(GRID_NM, 0.2),
        c_camera_per_m=np.full_like(GRID_NM, 0.5),
        lamp_range_m=(0.5, 8.0),
        camera_range_m=(1.0, 5.0),
    )
    assert table.order == (0, 0)
    assert path_table.log_mean_transmission(table, 3.0, 2.0) == pytest.approx(-1.6, rel=1e-13)  # rounding


def test_tables_looked_up_together_are_each_the_sum_of_two_colours() -> None:
    # (w_1 exp(-K_1 r - c_1 d) + w_2 exp(-K_2 r - c_2 d)) / (w_1 + w_2), within what a table may be off
    box, weights = (0.1, 6.0), ((1.0, 1.0), (1.0, 9.0))
    losses = (np.array([0.05, 3.0]), np.array([0.2, 0.5]))
    tables = tuple(
        path_table.build_path_table(
            weight, wavelength_nm=None, k_lamp_per_m=k, c_camera_per_m=2.0 * k, lamp_range_m=box, camera_range_m=box
        )
        for weight, k in zip(weights, losses, strict=True)
    )
    assert tables[0].lamp_warp != tables[1].lamp_warp  # each maps its ranges in its own way
    lamp_m, camera_m = np.random.default_rng(1).uniform(*box, (2, 50))
    found = path_table.log_mean_transmissions(tables, lamp_m, camera_m)
    for ours, weight, k in zip(found, weights, losses, strict=True):
        mean = np.exp(-np.multiply.outer(lamp_m + 2.0 * camera_m, k)) @ np.array(weight) / sum(weight)
        assert np.exp(ours) == pytest.approx(mean, rel=5e-6)


def test_table_holds_where_hardly_a_photon_is_left() -> None:
    kw, box = optics("9C"), (600.0, 601.0)  # exponents that no product of factors can hold
    table = path_table.build_path_table(LED_WEIGHT, **kw, lamp_range_m=box, camera_range_m=box)
    lamp_m, camera_m = np.random.default_rng(1).uniform(*box, (2, 100))
    exact = summed_log_transmission(LED_WEIGHT, **kw, lamp_m=lamp_m, camera_m=camera_m)
    assert np.abs(path_table.log_mean_transmission(table, lamp_m, camera_m) - exact).max() <= 1.2e-6


@pytest.mark.parametrize("water_type", ["I", "II", "III", "9C"])
@pytest.mark.parametrize("box", [(2.0, 2.0), (1.5, 2.5), (0.3, 5.0), (0.2, 20.0)])
def test_table_meets_its_tolerance_against_the_sum_over_the_spectrum(
    water_type: str, box: tuple[float, float]
) -> None:
    kw = optics(water_type)
    table = path_table.build_path_table(LED_WEIGHT, **kw, lamp_range_m=box, camera_range_m=box)
    lamp_m, camera_m = np.random.default_rng(1).uniform(*box, (2, 3000))
    lamp_m[:4], camera_m[:4] = [box[0], box[0], box[1], box[1]], [box[0], box[1], box[0], box[1]]
    exact = summed_log_transmission(LED_WEIGHT, **kw, lamp_m=lamp_m, camera_m=camera_m)
    ours = path_table.log_mean_transmission(table, lamp_m, camera_m)
    assert np.abs(ours - exact).max() <= 1.2e-6  # tolerance 1e-6, checked on a grid: 20 % between its points
    assert np.abs(ours - exact).max() <= 3 * table.max_error_log + 1e-12


def test_an_incandescent_lamp_is_harder_and_still_met() -> None:
    weight = planck_spectrum(GRID_NM, temperature_k=3200) * GRID_NM
    table = path_table.build_path_table(
        weight, **optics("I"), lamp_range_m=(0.2, 20), camera_range_m=(0.5, 20)
    )
    assert table.max_error_log <= 1e-6


def test_a_capped_order_reports_its_error() -> None:
    kw = optics("9C")
    table = path_table.build_path_table(
        LED_WEIGHT, **kw, lamp_range_m=(0.2, 50.0), camera_range_m=(0.2, 50.0), max_order=4
    )
    assert table.order == (4, 4)
    assert table.max_error_log > 1e-6
    fixed = path_table.build_path_table(LED_WEIGHT, **kw, lamp_range_m=(1, 2), camera_range_m=(1, 2), order=3)
    assert fixed.order == (3, 3)


def test_two_thousand_optical_depths_stay_finite() -> None:
    kw = dict(optics("9C"))
    kw["c_camera_per_m"] = 20 * np.ones_like(GRID_NM) + 0.001 * (GRID_NM - 380)
    table = path_table.build_path_table(
        LED_WEIGHT, **kw, lamp_range_m=(1.0, 2.0), camera_range_m=(99.0, 100.0)
    )
    ours = path_table.log_mean_transmission(table, 1.5, 100.0)
    # mpmath: the same sum in 60 digits
    with mpmath.workdps(60):
        steps = np.full(GRID_NM.size, 5.0)
        steps[[0, -1]] = 2.5
        rows = list(zip(LED_WEIGHT * steps, kw["k_lamp_per_m"], kw["c_camera_per_m"], strict=True))
        dark = mpmath.fsum(
            mpmath.mpf(w) * mpmath.exp(-mpmath.mpf(k) * 1.5 - mpmath.mpf(c) * 100) for w, k, c in rows
        )
        exact = mpmath.log(dark / mpmath.fsum(mpmath.mpf(w) for w, _, _ in rows))
    assert ours < -2000
    assert ours == pytest.approx(float(exact), abs=1e-6)  # the table's tolerance


def test_channels_share_a_table_and_agree_with_their_own() -> None:
    kw = optics("II")
    channels = np.array(
        [[LED_WEIGHT, LED_WEIGHT * (GRID_NM > 550)], [GRID_NM, np.where(GRID_NM < 480, 1.0, 0.0)]]
    )
    boxes: dict[str, Any] = {"lamp_range_m": (1.0, 3.0), "camera_range_m": (1.5, 2.5)}
    table = path_table.build_path_table(channels, **kw, **boxes)
    lamp_m, camera_m = np.linspace(1, 3, 7)[:, None], np.linspace(1.5, 2.5, 5)
    together = path_table.log_mean_transmission(table, lamp_m, camera_m)
    assert together.shape == (2, 2, 7, 5)
    for i, j in np.ndindex(2, 2):
        alone = path_table.build_path_table(channels[i, j], **kw, **boxes)
        assert together[i, j] == pytest.approx(
            path_table.log_mean_transmission(alone, lamp_m, camera_m), abs=2e-6
        )
        assert table.weight_integral[i, j] == pytest.approx(np.trapezoid(channels[i, j], GRID_NM), rel=1e-13)


def test_a_weight_with_its_own_quadrature_steps_needs_no_grid() -> None:
    kw = optics("II")
    steps = np.full(GRID_NM.size, 5.0)
    steps[[0, -1]] = 2.5
    boxes: dict[str, Any] = {"lamp_range_m": (1.0, 3.0), "camera_range_m": (1.5, 2.5)}
    plain = path_table.build_path_table(LED_WEIGHT, **kw, **boxes)
    stepped = path_table.build_path_table(LED_WEIGHT * steps, **(kw | {"wavelength_nm": None}), **boxes)
    assert stepped.weight_integral == pytest.approx(plain.weight_integral, rel=1e-13)
    assert path_table.log_mean_transmission(stepped, 2.0, 2.0) == pytest.approx(
        path_table.log_mean_transmission(plain, 2.0, 2.0), abs=1e-12
    )


def test_a_blind_channel_gives_zero_weight_and_a_finite_logarithm() -> None:
    kw = optics("II")
    table = path_table.build_path_table(0 * GRID_NM, **kw, lamp_range_m=(1, 3), camera_range_m=(1, 3))
    assert table.weight_integral == 0
    assert np.isfinite(path_table.log_mean_transmission(table, 2.0, 2.0))


@settings(max_examples=25, deadline=None)
@given(lamp=st.floats(1.0, 3.0), camera=st.floats(1.0, 3.0), step=st.floats(1e-3, 0.5))
def test_longer_paths_transmit_less(lamp: float, camera: float, step: float) -> None:
    table = TABLE_II
    here = path_table.log_mean_transmission(table, lamp, camera)
    assert path_table.log_mean_transmission(table, lamp + step, camera) < here < 0
    assert path_table.log_mean_transmission(table, lamp, camera + step) < here


TABLE_II = path_table.build_path_table(
    LED_WEIGHT, **optics("II"), lamp_range_m=(1, 3.5), camera_range_m=(1, 3.5)
)


@pytest.mark.parametrize("lamp_m", [0.9, 3.6, np.nan, np.inf])
def test_ranges_outside_the_table_are_refused(lamp_m: float) -> None:
    with pytest.raises(RangeError, match="lamp range"):
        path_table.log_mean_transmission(TABLE_II, np.array([2.0, lamp_m]), 2.0)


@pytest.mark.parametrize("box", [(2.0, 1.0), (-1.0, 1.0), (1.0, np.inf), (np.nan, 1.0)])
def test_impossible_range_boxes_are_refused(box: tuple[float, float]) -> None:
    with pytest.raises(RangeError, match="camera range"):
        path_table.build_path_table(LED_WEIGHT, **optics("II"), lamp_range_m=(1, 2), camera_range_m=box)


def test_empty_arrays_give_empty_results() -> None:
    assert path_table.log_mean_transmission(TABLE_II, np.empty((0, 3)), 2.0).shape == (0, 3)


@pytest.mark.parametrize("bad", [-1.0, np.nan])
def test_impossible_weights_are_refused(bad: float) -> None:
    weight = LED_WEIGHT.copy()
    weight[3] = bad
    with pytest.raises(RangeError, match="weight"):
        path_table.build_path_table(weight, **optics("II"), lamp_range_m=(1, 2), camera_range_m=(1, 2))


@pytest.mark.parametrize("rows", [1, 25, 26, 61, 165])
def test_a_product_in_parts_is_the_whole(rows: int) -> None:
    rng = np.random.default_rng(rows)
    left, right = rng.random((rows, 301)), rng.random((65, 301)).T
    assert path_table.product(left, right) == pytest.approx(np.einsum("ik,kj->ij", left, right), rel=1e-13)
