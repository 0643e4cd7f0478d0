"""Phase functions against closed forms, printed values and arbitrary precision."""

import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.physics import backscatter_ratio, mean_cosine, solid_angle_integral
from scipy.integrate import quad

from uwopt.errors import RangeError
from uwopt.model import phase_formulas, scattering

# Mobley, Ocean Optics Web Book, "The Fournier-Forand phase function", Table 1; the last row: Mobley, Sundman
# and Boss (2002), for Petzold's mean particle.
WEB_BOOK = [
    (1.021, 3.0742, 0.0001),
    (1.040, 3.2010, 0.001),
    (1.08, 3.483, 0.01),
    (1.175, 4.065, 0.1),
    (1.15, 4.874, 0.4),
    (1.10, 3.5835, 0.0183),
]
ANGLES_RAD = np.radians(np.linspace(5.0, 180.0, 20_011))

ratios = st.floats(1e-4, 0.4)
asymmetries = st.floats(-0.5, 0.98)


def henyey_greenstein(g):
    return scattering.phase_table_of(
        lambda angle: phase_formulas.henyey_greenstein_per_sr(np.cos(angle), asymmetry=g)
    )


def fournier_forand(ratio):
    index, slope = phase_formulas.fournier_forand_for_backscatter(ratio)

    def function(angle):
        return phase_formulas.fournier_forand_per_sr(angle, index=index, slope=slope)

    return function


def over_sphere(function, start_rad=0.0):
    """2 pi * integral of p sin psi d psi by adaptive quadrature in log psi and psi."""

    def in_log(u):
        return 2 * math.pi * float(function(math.exp(u))) * math.sin(math.exp(u)) * math.exp(u)

    low = math.log(max(start_rad, 1e-9))
    cuts = [u for u in np.log([1e-6, 1e-4, 1e-2, 0.1, 1.0]) if u > low]
    edges = [low, *cuts, math.log(math.pi)]
    return sum(quad(in_log, a, b, epsabs=1e-13, epsrel=1e-11)[0] for a, b in pairwise(edges))


def printed_fournier_forand(angle, n, mu):
    """The equation as printed by Fournier and Jonasz (1999), at 60 digits."""
    with mpmath.workdps(60):
        angle, n, mu = mpmath.mpf(angle), mpmath.mpf(n), mpmath.mpf(mu)
        nu = (3 - mu) / 2
        d180 = 4 / (3 * (n - 1) ** 2)
        u = mpmath.sin(angle / 2) ** 2
        d = d180 * u
        bracket = nu * (1 - d) - (1 - d**nu) + (d * (1 - d**nu) - nu * (1 - d)) / u
        first = bracket / (4 * mpmath.pi * (1 - d) ** 2 * d**nu)
        second = (1 - d180**nu) / (16 * mpmath.pi * (d180 - 1) * d180**nu) * (3 * mpmath.cos(angle) ** 2 - 1)
        return float(first + second)


# ---------------------------------------------------------------- formulas


def test_henyey_greenstein_of_zero_asymmetry_is_even_over_the_sphere():
    values = phase_formulas.henyey_greenstein_per_sr([-1.0, 0.0, 1.0], asymmetry=0.0)
    assert values == pytest.approx(1 / (4 * math.pi))


def test_henyey_greenstein_ahead_and_behind_by_hand():
    # psi = 0: (1 + g)/(4 pi (1 - g)^2); psi = 180 deg: (1 - g)/(4 pi (1 + g)^2); g = 0.9: 190/(4 pi), 0.1/(4 pi 3.61)
    ahead, behind = phase_formulas.henyey_greenstein_per_sr([1.0, -1.0], asymmetry=0.9)
    assert ahead * 4 * math.pi == pytest.approx(190.0)
    assert behind * 4 * math.pi == pytest.approx(0.1 / 3.61)


@pytest.mark.parametrize("g", [-0.6, 0.0, 0.5, 0.93])
def test_henyey_greenstein_has_the_mean_cosine_and_integral_of_its_definition(g):
    p = lambda c: float(phase_formulas.henyey_greenstein_per_sr(c, asymmetry=g))  # noqa: E731
    assert 2 * math.pi * quad(p, -1, 1, epsrel=1e-10)[0] == pytest.approx(1.0, rel=1e-9)
    assert 2 * math.pi * quad(lambda c: c * p(c), -1, 1, epsrel=1e-10)[0] == pytest.approx(g, abs=1e-9)
    expected = 2 * math.pi * quad(p, -1, 0)[0]
    assert phase_formulas.henyey_greenstein_backscatter_ratio(g) == pytest.approx(expected, rel=1e-9)


@given(g=asymmetries)
def test_asymmetry_for_backscatter_undoes_the_backscatter_of_henyey_greenstein(g):
    ratio = phase_formulas.henyey_greenstein_backscatter_ratio(g)
    assert phase_formulas.asymmetry_for_backscatter(ratio) == pytest.approx(g, abs=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 1.0, -0.1])
def test_impossible_backscatter_is_refused(ratio):
    with pytest.raises(RangeError, match="backscatter ratio"):
        phase_formulas.asymmetry_for_backscatter(ratio)
    with pytest.raises(RangeError, match=r"0\.0001 to 0\.4"):
        phase_formulas.fournier_forand_for_backscatter(ratio)


@pytest.mark.parametrize(("index", "slope", "ratio"), WEB_BOOK)
def test_fournier_forand_scatters_back_what_the_literature_tabulates(index, slope, ratio):
    # the printed index is rounded to 5e-4, and the ratio goes with (n - 1)^2; slope and ratio add 0.5 %
    got = phase_formulas.fournier_forand_backscatter_ratio(index, slope=slope)
    assert got == pytest.approx(ratio, rel=2 * 5e-4 / (index - 1) + 0.005)


@pytest.mark.parametrize(("index", "slope", "ratio"), [row for row in WEB_BOOK if row[2] != 0.4])
def test_one_parameter_family_runs_through_the_tabulated_pairs(index, slope, ratio):
    # all but the web book's 0.4, which leaves the line; the web book rounds the index to 1e-3 .. 5e-3
    n, mu = phase_formulas.fournier_forand_for_backscatter(ratio)
    assert n == pytest.approx(index, abs=5e-3)
    assert mu == pytest.approx(slope, abs=0.02)


@given(ratio=ratios)
def test_wanted_backscatter_is_met_by_the_printed_formula(ratio):
    # Mobley, Sundman and Boss (2002), equation for the backscatter fraction, as printed
    n, mu = phase_formulas.fournier_forand_for_backscatter(ratio)
    nu, d = (3 - mu) / 2, 4 / (3 * (n - 1) ** 2) * 0.5
    printed = 1 - (1 - d ** (nu + 1) - 0.5 * (1 - d**nu)) / ((1 - d) * d**nu)
    assert printed == pytest.approx(ratio, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("index", "slope"), [row[:2] for row in WEB_BOOK])
def test_fournier_forand_equals_the_printed_equation_at_sixty_digits(index, slope):
    pole = 2 * math.asin(math.sqrt(0.75) * (index - 1))  # d = 1
    near_pole = [pole * (1 + e) for e in (-0.03, -0.02, -1e-3, -1e-6, 1e-9, 1e-5, 0.01, 0.024, 0.03)]
    for angle in (1e-8, 1e-5, 1e-3, 0.02, 0.3, 1.0, 2.0, 3.0, math.pi, *near_pole):
        got = float(phase_formulas.fournier_forand_per_sr(angle, index=index, slope=slope))
        assert got == pytest.approx(printed_fournier_forand(angle, index, slope), rel=1e-10)


def test_fournier_forand_is_finite_at_its_poles():
    index = 1.1
    poles = [0.0, 2 * math.asin(math.sqrt(0.75) * (index - 1)), math.pi]
    values = phase_formulas.fournier_forand_per_sr(poles, index=index, slope=3.5835)
    assert np.all(np.isfinite(values) & (values > 0))


@pytest.mark.parametrize("ratio", [0.01, 0.0183, 0.1, 0.4])
def test_integrals_of_fournier_forand_are_one_and_the_backscatter_ratio(ratio):
    function = fournier_forand(ratio)
    # below 1e-9 rad: F(psi) = d^s to first order; at b_b/b = 0.01, s = 0.235: (1e-9/0.14)^0.47 = 1.5e-4
    assert over_sphere(function) == pytest.approx(1.0, abs=3e-4)
    assert over_sphere(function, math.pi / 2) == pytest.approx(ratio, rel=1e-8)


@given(ratio=ratios)
@settings(max_examples=30)
def test_fournier_forand_is_positive_at_all_angles(ratio):
    assert np.all(fournier_forand(ratio)(np.radians(np.linspace(0, 180, 500))) > 0)


@pytest.mark.parametrize(("index", "slope"), [(1.0, 3.5), (1.1, 3.0), (1.1, 5.1), (0.9, 4.0)])
def test_particles_without_a_fournier_forand_function_are_refused(index, slope):
    with pytest.raises(RangeError, match="not defined"):
        phase_formulas.fournier_forand_per_sr(1.0, index=index, slope=slope)


def test_molecular_scattering_at_90_degrees_follows_the_depolarisation():
    # p(90)/p(0) = 1/(1 + f) = (1 + delta)/2 = 0.5195 for delta = 0.039
    ahead, across = phase_formulas.molecular_per_sr([1.0, 0.0])
    assert across / ahead == pytest.approx(0.5195)


def test_molecular_scattering_with_morels_depolarisation_is_the_textbook_form():
    # Mobley (1994), Light and Water: 0.06225 (1 + 0.835 cos^2 psi) per steradian, delta = 0.09
    values = phase_formulas.molecular_per_sr([0.0, 0.5, -1.0], depolarisation=0.09)
    assert values == pytest.approx([0.06225, 0.06225 * (1 + 0.835 / 4), 0.06225 * 1.835], rel=1e-4)


def test_molecular_scattering_integrates_to_one():
    total = 2 * math.pi * quad(lambda c: float(phase_formulas.molecular_per_sr(c)), -1, 1)[0]
    assert total == pytest.approx(1.0, rel=1e-12)


# ---------------------------------------------------------------- the table


@pytest.mark.parametrize("ratio", [1e-4, 1e-3, 0.0183, 0.1, 0.4])
def test_table_of_fournier_forand_is_exact_to_2e_5_from_5_to_180_degrees(ratio):
    function = fournier_forand(ratio)
    got = scattering.look_up(np.cos(ANGLES_RAD), scattering.phase_table_of(function))
    np.testing.assert_allclose(got, function(ANGLES_RAD), rtol=2e-5)


@given(g=asymmetries)
@settings(max_examples=20)
def test_table_of_henyey_greenstein_is_exact_to_2e_5_at_all_angles(g):
    cosine = np.cos(np.radians(np.linspace(0.0, 180.0, 5003)))
    got = scattering.look_up(cosine, henyey_greenstein(g))
    np.testing.assert_allclose(got, phase_formulas.henyey_greenstein_per_sr(cosine, asymmetry=g), rtol=2e-5)


def test_table_of_molecular_scattering_is_exact_to_1e_8():
    table = scattering.phase_table_of(lambda angle: phase_formulas.molecular_per_sr(np.cos(angle)))
    cosine = np.linspace(-1, 1, 10_001)
    np.testing.assert_allclose(
        scattering.look_up(cosine, table), phase_formulas.molecular_per_sr(cosine), rtol=1e-8
    )
    assert backscatter_ratio(table) == pytest.approx(0.5, abs=1e-8)
    assert mean_cosine(table) == pytest.approx(0.0, abs=1e-8)


@given(g=asymmetries)
@settings(max_examples=20)
def test_moments_of_a_table_are_those_of_henyey_greenstein(g):
    table = henyey_greenstein(g)
    assert solid_angle_integral(table) == pytest.approx(1.0, abs=1e-12)
    assert mean_cosine(table) == pytest.approx(g, abs=1e-7)
    # the closed form cancels near g = 0, where its slope is -3/4
    closed = abs(g) > 1e-6
    expected = (1 - g) / (2 * g) * ((1 + g) / math.sqrt(1 + g * g) - 1) if closed else 0.5 - 0.75 * g
    assert backscatter_ratio(table) == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("ratio", [1e-4, 0.0183, 0.4])
def test_backscatter_ratio_of_a_fournier_forand_table_is_the_wanted_one(ratio):
    table = scattering.phase_table_of(fournier_forand(ratio))
    assert solid_angle_integral(table) == pytest.approx(1.0, abs=1e-12)
    assert backscatter_ratio(table) == pytest.approx(ratio, rel=1e-5)


def test_coarse_knots_of_a_smooth_function_are_joined_smoothly():
    # 55 knots spaced as Petzold's; monotone cubics between them leave 1 % of this function at most
    knots_rad = np.radians(np.concatenate([np.geomspace(0.1, 10, 21), np.arange(15, 181, 5)]))
    function = fournier_forand(0.0183)
    table = scattering.phase_table(knots_rad, function(knots_rad))
    got = scattering.look_up(np.cos(ANGLES_RAD), table)
    np.testing.assert_allclose(got, function(ANGLES_RAD), rtol=0.01)


def test_table_meets_its_knots():
    knots_rad = np.radians([0.0, 2.0, 8.0, 20.0, 60.0, 90.0, 120.0, 150.0, 171.0])
    values = phase_formulas.henyey_greenstein_per_sr(np.cos(knots_rad), asymmetry=0.6)
    table = scattering.phase_table(knots_rad, values / 1.004)
    got = scattering.look_up(np.cos(knots_rad[2:]), table) / values[2:]
    np.testing.assert_allclose(got, got[0], rtol=1e-6)


def test_function_is_flat_behind_the_last_angle():
    knots_rad = np.radians([1.0, 10.0, 30.0, 90.0, 150.0, 170.0])
    values = np.array([1.0, 0.9, 0.8, 0.7, 0.8, 0.9])
    b = scattering.scattering_coefficient_per_m(knots_rad, values)
    table = scattering.phase_table(knots_rad, values / b)
    behind = scattering.look_up(np.cos(np.radians([170.0, 173.0, 177.0, 180.0])), table)
    np.testing.assert_allclose(behind, 0.9 / b, rtol=1e-5)


def test_forward_peak_goes_on_as_a_power_law():
    # p = A psi^-1.4 from 1 deg on: at 0.3 deg (1/0.3)^1.4 = 5.396 times the first knot
    knots_rad = np.radians(np.concatenate([np.geomspace(1, 150, 40), [180.0]]))
    values = knots_rad**-1.4
    table = scattering.phase_table(
        knots_rad, values / scattering.scattering_coefficient_per_m(knots_rad, values)
    )
    first, below = scattering.look_up(np.cos(np.radians([1.0, 0.3])), table)
    assert below / first == pytest.approx(5.396, rel=1e-3)


def test_scattering_coefficient_of_a_power_law_by_quadrature():
    # 2 pi * integral of psi^-1.4 sin psi d psi from 0 to pi, without the flat end behind 175 deg
    knots_rad = np.radians(np.concatenate([np.geomspace(0.1, 175, 2000), [180.0]]))
    got = scattering.scattering_coefficient_per_m(knots_rad, knots_rad**-1.4)
    assert got == pytest.approx(2 * math.pi * quad(lambda t: t**-1.4 * math.sin(t), 0, math.pi)[0], rel=1e-5)


@given(
    logarithms=st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=12),
    first_deg=st.floats(0.0, 5.0),
)
@settings(max_examples=30)
def test_any_measured_function_stays_within_its_knots_and_integrates_to_one(logarithms, first_deg):
    knots_rad = np.radians(np.linspace(first_deg, 180.0, len(logarithms)))
    values = np.exp(np.array(logarithms))
    if first_deg > 0:
        values[:2] = values[0]  # no forward peak
    b = scattering.scattering_coefficient_per_m(knots_rad, values)
    table = scattering.phase_table(knots_rad, values / b)
    got = scattering.look_up(np.linspace(-1, 1, 2001), table) * b
    assert np.all(got >= values.min() * (1 - 1e-4))
    assert np.all(got <= values.max() * (1 + 1e-4))
    assert solid_angle_integral(table) == pytest.approx(1.0, abs=1e-12)


def test_integral_within_two_percent_is_scaled_to_one():
    knots_rad = np.radians(np.linspace(0, 180, 19))
    table = scattering.phase_table(knots_rad, np.full(19, 1.015 / (4 * math.pi)))
    assert solid_angle_integral(table) == pytest.approx(1.0, abs=1e-12)
    assert scattering.look_up(0.3, table) == pytest.approx(1 / (4 * math.pi))


@pytest.mark.parametrize("total", [0.97, 1.03, 12.566])
def test_integral_off_by_more_than_two_percent_is_refused_with_its_value(total):
    knots_rad = np.radians(np.linspace(0, 180, 19))
    with pytest.raises(RangeError, match=f"{total:.4g}.*0.98 to 1.02.*divide by"):
        scattering.phase_table(knots_rad, np.full(19, total / (4 * math.pi)))


def test_forward_peak_without_integral_is_refused():
    knots_rad = np.radians([5.0, 20.0, 90.0, 150.0, 180.0])
    with pytest.raises(RangeError, match=r"angle\^-3.*add angles below"):
        scattering.phase_table(knots_rad, knots_rad**-3.0)


@pytest.mark.parametrize(
    ("angles_deg", "values", "message"),
    [
        ([0, 90, 180], [1, 1, 1], "four angles"),
        ([0, 60, 90, 180], [1, 1, 1], "a value for each"),
        ([0, 90, 60, 180], [1, 1, 1, 1], "increase within 0 to 180"),
        ([0, 60, 90, 181], [1, 1, 1, 1], "increase within 0 to 180"),
        ([0, 60, 90, 160], [1, 1, 1, 1], "must reach 170 deg"),
        ([0, 60, 90, 180], [1, 0, 1, 1], "above 0"),
        ([0, 60, 90, 180], [1, math.nan, 1, 1], "finite"),
    ],
)
def test_knots_that_are_no_phase_function_are_refused(angles_deg, values, message):
    with pytest.raises(RangeError, match=message):
        scattering.phase_table(np.radians(angles_deg), values)


def test_formula_that_is_not_positive_is_refused():
    with pytest.raises(RangeError, match="above 0"):
        scattering.phase_table_of(np.cos)


def test_look_up_keeps_the_shape_and_bears_round_off():
    table = henyey_greenstein(0.8)
    assert np.shape(scattering.look_up(0.3, table)) == ()
    assert scattering.look_up(np.zeros((2, 0, 3)), table).shape == (2, 0, 3)
    at_ends = scattering.look_up([1.0, -1.0], table)
    beyond = scattering.look_up([1 + 4e-16, -1 - 4e-16], table)
    np.testing.assert_allclose(beyond, at_ends, rtol=1e-6)


def test_look_up_of_many_points_is_that_of_each():
    table = henyey_greenstein(0.8)
    cosine = np.linspace(-1, 1, 3 * scattering.CHUNK + 5).reshape(1, -1)
    sparse = scattering.look_up(cosine[:, ::1000], table)
    np.testing.assert_array_equal(scattering.look_up(cosine, table)[:, ::1000], sparse)
