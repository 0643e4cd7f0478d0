"""The suite `spectral`: its reference against closed forms and against mpmath's own adaptive rule, and its rows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from thorough import drawn

from uwopt.bench import spectral, spectral_exact
from uwopt.bench.spectral import AS_USED, GAUSS, RULES, SIMPSON, TRAPEZOID, Case
from uwopt.bench.suite import BenchRow, Budget
from uwopt.model.imaging import signal_weight

ONE_NM = 401  # nodes of the whole spectrum in steps of 1 nm
PLANCK_J_S, LIGHT_M_S = 6.62607015e-34, 299792458.0


@pytest.fixture(scope="module")
def rows() -> Sequence[BenchRow]:
    return list(spectral.measure(Budget(quick=True, seconds=math.inf)))


def flat_tables(water_per_m: float) -> spectral.Tables:
    """Tables without a feature, whose integral has a closed form."""
    ends = (float(spectral.FIRST_NM), float(spectral.LAST_NM))
    return replace(
        spectral.tables_of(spectral.LED_CLEAR),
        lamp=(ends, (1.0, 1.0)),
        photopic=(ends, (1.0, 1.0)),
        reflectance=(ends, (0.3, 0.3)),
        efficiency=((1.0, (ends, (0.5, 0.5))),),
        absorption=(ends, (0.0, 0.0)),
        scattering=(ends, (0.0, water_per_m)),
        diffuse=(ends, (0.0, 0.0)),
        pure_water=(ends, (0.0, 0.0)),
        backscatter_ratio=0.0,
        index=(1.3, *(0.0,) * 9),
    )


def test_flat_tables_give_the_exponential_integral_in_closed_form() -> None:
    # S = V = 1, M = 0.3, eta = 0.5, n = 1.3, a = K_d = 0 and b = 0.5 (l - 380)/400 1/m: K = 0 and c = b.
    # int l exp(-s (l - 380)) dl over 400 nm, s = 0.5 * r / 400, times 0.3 * 0.5 / (4 * 1.3^2 h c * 683.002 * 400)
    tables = flat_tables(0.5)
    for camera_m in (1.0, 8.0):
        s, span = 0.5 * camera_m / 400.0, 400.0
        tail = np.exp(-s * span)
        by_hand = 380.0 * (1.0 - tail) / s + (1.0 - tail * (1.0 + s * span)) / s**2
        by_hand *= 0.3 * 0.5 / (4 * 1.3**2 * PLANCK_J_S * LIGHT_M_S * 1e9 * 683.002 * span)
        ours = spectral_exact.Integrand(tables).electrons(3.0, camera_m)
        assert float(ours) == pytest.approx(by_hand, rel=1e-12)


def test_the_reference_agrees_with_mpmaths_adaptive_rule_written_out() -> None:
    # two entries a table; the black body and Quan-Fry's index stay. K = a + b_b here, as K_d = 0.
    ends = (380.0, 780.0)
    tables = replace(
        spectral.tables_of(spectral.PLANCK),
        photopic=((380.0, 580.0, 780.0), (0.0, 1.0, 0.0)), reflectance=(ends, (0.1, 0.4)),
        efficiency=((1.0, (ends, (0.6, 0.2))),), absorption=(ends, (0.05, 0.3)), scattering=(ends, (0.3, 0.2)),
        diffuse=(ends, (0.0, 0.0)), backscatter_ratio=0.02,
    )  # fmt: skip

    def rise(x: mpmath.mpf, low: float, high: float) -> mpmath.mpf:
        return mpmath.mpf(low) + (mpmath.mpf(high) - mpmath.mpf(low)) * (x - 380) / 400

    def planck(x: mpmath.mpf) -> mpmath.mpf:
        h_c_over_k = mpmath.mpf("6.62607015e-34") * 299792458 / mpmath.mpf("1.380649e-23")
        return x**-5 / (mpmath.exp(h_c_over_k / (x * mpmath.mpf("1e-9") * 2856)) - 1)

    def electrons(x: mpmath.mpf) -> mpmath.mpf:
        n, (t, s) = [mpmath.mpf(v) for v in tables.index], (tables.temperature_c, tables.salinity_psu)
        index = n[0] + (n[1] + n[2] * t + n[3] * t * t) * s + n[4] * t * t
        index += (n[5] + n[6] * s + n[7] * t) / x + n[8] / x**2 + n[9] / x**3
        a, b = rise(x, 0.05, 0.3), rise(x, 0.3, 0.2)
        loss = mpmath.exp(-(a + mpmath.mpf(0.02) * b) * 4 - (a + b) * 3)
        return planck(x) * rise(x, 0.1, 0.4) * rise(x, 0.6, 0.2) * x / index**2 * loss

    with mpmath.workdps(34):
        lumens = mpmath.quad(lambda x: planck(x) * (1 - abs(x - 580) / 200), [380, 580, 780])
        photon_j_nm = mpmath.mpf("6.62607015e-34") * 299792458 * 10**9
        scale = 4 * photon_j_nm * mpmath.mpf("683.002") * lumens
        expected = mpmath.quad(electrons, [380, 480, 580, 680, 780], method="gauss-legendre") / scale
        assert abs(spectral_exact.Integrand(tables).electrons(4.0, 3.0) / expected - 1) < mpmath.mpf("1e-28")


def test_half_the_nodes_of_the_reference_change_nothing_that_shows() -> None:
    case = Case(spectral.LASERS, 5.2, 5.0)
    full, half = (spectral.reference_electrons(case, degree) for degree in (3, 2))
    assert abs(half / full - 1) < 1e-12


def test_rules_converge_at_their_order_on_a_smooth_integrand() -> None:
    tables = flat_tables(0.5)
    exact = spectral_exact.Integrand(tables).electrons(3.0, 8.0)
    errors = {
        name: [
            abs(
                float(
                    spectral.sampled(tables, *spectral.rule(name, n)).electrons(
                        np.array([3.0]), np.array([8.0])
                    )[0]
                    / exact
                    - 1
                )
            )
            for n in (17, 33)
        ]
        for name in RULES
    }
    # halving the step: 4 times less by the trapezoid rule, 16 by Simpson's, nothing left for Gauss-Legendre
    assert errors[TRAPEZOID][0] / errors[TRAPEZOID][1] == pytest.approx(4.0, rel=0.02)
    assert errors[SIMPSON][0] / errors[SIMPSON][1] == pytest.approx(16.0, rel=0.1)
    assert max(errors[GAUSS]) < 1e-13


def test_the_trapezoid_in_steps_of_one_nanometre_is_the_models_weight() -> None:
    setting = spectral.LED_TURBID
    grid_nm, rule_nm = spectral.rule(TRAPEZOID, ONE_NM)
    tables = spectral.tables_of(setting)
    ours = spectral.sampled(tables, grid_nm, rule_nm).weight
    curve = tables.efficiency[0][1]
    scene = spectral.scene_of(setting)
    held = {name: np.interp(grid_nm, *getattr(tables, name)) for name in ("reflectance", "photopic")}
    theirs = signal_weight(
        spectral.lamp_power(None, grid_nm), wavelength_nm=grid_nm, photopic=held["photopic"],
        reflectance=held["reflectance"], quantum_efficiency=np.interp(grid_nm, *curve),
        n_water=np.interp(grid_nm, scene.wavelength_nm, scene.n_water_spectrum),
    )  # fmt: skip
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)


@pytest.mark.parametrize("setting", drawn(
    [spectral.LED_COLOUR, spectral.SHUT],
    [spectral.LED_TURBID, spectral.LED_COLOUR, spectral.FILTER, spectral.SHUT],
))  # fmt: skip
def test_the_default_is_within_a_ten_thousandth(setting: spectral.Setting) -> None:
    case = Case(setting, 5.2, 5.0)
    function, _ = spectral.as_used(case)
    ours = function(np.array([case.lamp_m]), np.array([case.camera_m]))[0]
    assert abs(ours / spectral.reference_electrons(case, spectral_exact.QUICK_DEGREE) - 1) < 1e-4


def test_rows_of_a_quick_run_are_well_formed(rows: Sequence[BenchRow]) -> None:
    assert {row.case for row in rows} == {case.name for case in spectral.QUICK_CASES}
    assert {row.method for row in rows} == {AS_USED, *RULES}
    for row in rows:
        assert row.suite == "spectral"
        assert row.time_s is not None
        assert row.time_s > 0.0
        assert (row.error is None) == bool(row.status)
        assert row.error is None or 0.0 <= row.error < np.inf
    assert len({(row.case, row.method, row.size) for row in rows}) == len(rows)


def test_the_default_of_a_quick_run_is_within_a_ten_thousandth(rows: Sequence[BenchRow]) -> None:
    assert all(row.error < 1e-4 for row in rows if row.method == AS_USED)  # type: ignore[operator]


def test_the_table_has_a_line_for_each_case(rows: Sequence[BenchRow]) -> None:
    (table,) = spectral.SUITE.tables(rows)
    assert len(table.rows) == len(spectral.QUICK_CASES)
    assert all(len(line) == len(table.head) for line in table.rows)
    assert spectral.SUITE.tables([])[0].rows == []


def test_a_suite_without_time_measures_nothing() -> None:
    assert list(spectral.measure(Budget(quick=True, seconds=0.0))) == []
