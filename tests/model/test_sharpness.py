"""Sharpness against SciPy's Bessel functions, pupils and boxes transformed numerically, and plain sums."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize, special
from sharpness_cases import GOOD, LED, NOTHING, PLAIN, with_colour

from uwopt.model import lateral, sharpness
from uwopt.model.sharpness import Sharpness

FREQUENCIES = np.linspace(0.0, 1.0, 401)
blurs = st.floats(0.0, 4.0)
f_numbers = st.floats(1.0, 32.0)
discs = st.floats(0.0, 12.0)
ratings = st.floats(0.0, 3.0)


# ---------------------------------------------------------------- factors


@pytest.mark.parametrize("width_px", [0.25, 1.0, 1.7])
def test_box_transfer_is_the_fourier_transform_of_a_box(width_px: float) -> None:
    # midpoint sum over the box; its error is (pi nu w / n)^2 / 24
    places = (np.arange(20_000) + 0.5) / 20_000 * width_px - width_px / 2
    for nu in np.linspace(0.0, 1.0 / width_px, 9):
        expected = np.abs(np.mean(np.exp(2j * math.pi * nu * places)))
        assert sharpness.sinc_mtf(nu, width_px=width_px) == pytest.approx(expected, abs=1e-8)


def test_box_transfer_is_that_of_numpy_up_to_its_null() -> None:
    assert sharpness.sinc_mtf(FREQUENCIES) == pytest.approx(np.sinc(FREQUENCIES), abs=5e-16)


@pytest.mark.parametrize("disc_px", [0.0, 0.3, 1.0, 1.2])
def test_disc_transfer_is_that_of_the_bessel_function(disc_px: float) -> None:
    # 1.2 < 1.2197: the null lies beyond 1 cycle per px
    x = np.maximum(math.pi * disc_px * FREQUENCIES, 1e-12)
    expected = 2.0 * special.j1(x) / x
    assert sharpness.defocus_mtf(FREQUENCIES, disc_px=disc_px) == pytest.approx(expected, abs=1e-14)


def test_first_zero_of_the_bessel_function() -> None:
    assert special.jn_zeros(1, 1)[0] == pytest.approx(sharpness.J1_ZERO, rel=1e-15)


NODES = np.polynomial.legendre.leggauss(60)


def disc_overlap(shift: float) -> float:
    """Area common to two unit circles, centres `shift` apart, over the area of one: by quadrature of chords."""
    y, weights = NODES
    reach = math.sqrt(max(1.0 - shift**2 / 4, 0.0))
    angle = y * math.asin(reach)  # y = sin(angle): chords without a root at their ends
    chord = np.maximum(2 * np.cos(angle) - shift, 0.0)
    return float(weights @ (chord * np.cos(angle))) * math.asin(reach) / math.pi


def test_diffraction_is_the_autocorrelation_of_a_circular_pupil() -> None:
    for s in np.linspace(0.0, 1.0, 21):
        expected = disc_overlap(2.0 * s)
        assert sharpness.diffraction_mtf(s, cycle_px=1.0) == pytest.approx(expected, abs=1e-9)


def test_diffraction_by_hand() -> None:
    # F8, 550 nm, 3.45 um: period 8 * 0.55 / 3.45 = 1.27536 px; s = 0.5 at nu = 0.39204,
    # (2/pi) (acos 0.5 - 0.5 sqrt(0.75)) = 2/3 - sqrt(3)/(2 pi) = 0.391002
    sharp = Sharpness(working_f_number=8.0, wavelength_nm=550.0, pixel_pitch_m=3.45e-6)
    assert sharp.diffraction_px == pytest.approx(1.275362, rel=1e-6)
    got = sharpness.diffraction_mtf(0.5 / 1.2753623, cycle_px=sharp.diffraction_px)
    assert got == pytest.approx(0.391002, abs=1e-6)


def test_lens_rating_halves_the_contrast_at_its_nyquist_frequency() -> None:
    # rated for 2.4 um on 3.45 um pixels: nu_r = 1 / (2 * 2.4 um) = 0.5 / 0.69565 cycles per px
    rated_px = 2.4 / 3.45
    assert sharpness.lens_mtf(0.5 / rated_px, lens_pitch_px=rated_px) == pytest.approx(0.5)
    assert sharpness.lens_mtf(1.0 / rated_px, lens_pitch_px=rated_px) == pytest.approx(0.5**4)


@pytest.mark.parametrize("infinite", [1e6, 1e200, math.inf])
def test_each_factor_is_zero_beyond_its_null_and_one_without_cause(infinite: float) -> None:
    for factor, cause in (
        (sharpness.sinc_mtf, "width_px"),
        (sharpness.diffraction_mtf, "cycle_px"),
        (sharpness.defocus_mtf, "disc_px"),
    ):
        assert factor(0.5, **{cause: infinite}) == pytest.approx(0.0, abs=1e-15)
        assert factor(0.0, **{cause: infinite}) == 1.0
        assert factor(0.5, **{cause: 0.0}) == 1.0
    assert sharpness.lens_mtf(0.5, lens_pitch_px=0.0) == 1.0


@given(cause=st.floats(0.0, 20.0), more=st.floats(0.0, 5.0), nu=st.floats(0.0, 2.0))
def test_factors_fall_with_frequency_and_cause(cause: float, more: float, nu: float) -> None:
    for factor, name in (
        (sharpness.sinc_mtf, "width_px"),
        (sharpness.diffraction_mtf, "cycle_px"),
        (sharpness.defocus_mtf, "disc_px"),
        (sharpness.lens_mtf, "lens_pitch_px"),
    ):
        here = factor(nu, **{name: cause})
        assert 0.0 <= here <= 1.0
        assert factor(nu, **{name: cause + more}) <= here + 1e-15
        assert factor(nu + 0.1 * more, **{name: cause}) <= here + 1e-15


# ---------------------------------------------------------------- product and levels


@settings(deadline=None)  # a loaded machine is no failure
@given(
    n=f_numbers,
    blur=blurs,
    disc=discs,
    rating=ratings,
    spread=st.floats(0.0, 4.0),
    level=st.floats(0.01, 0.9),
)
def test_frequencies_at_a_level_are_those_of_a_root_finder(
    n: float, blur: float, disc: float, rating: float, spread: float, level: float
) -> None:
    base = replace(GOOD, working_f_number=n, motion_blur_px=blur, defocus_px=disc, lens_pitch_px=rating)
    sharp = with_colour(base, spread, 0.6)
    root = optimize.brentq(
        lambda nu: min(sharpness.mtf_axes(nu, sharpness=sharp, falling=True)) - level, 0.0, 1.0, xtol=1e-14
    )
    got = sharpness.highest_frequency_cyc_per_px(level, sharpness=sharp)
    assert got == pytest.approx(root, rel=1e-9, abs=1e-12)


def test_a_bare_pixel_resolves_what_a_sinc_does() -> None:
    # sinc(x) = 1/2 at x = 0.6033545; at half Nyquist sin(pi/4)/(pi/4) = 0.9003163
    assert sharpness.mtf50_cyc_per_px(NOTHING) == pytest.approx(0.6033545, abs=1e-7)
    assert sharpness.mtf_half_nyquist(NOTHING) == pytest.approx(0.9003163, abs=1e-7)


def test_motion_counts_along_and_the_worse_direction_is_reported() -> None:
    # one pixel of blur doubles the sinc along: sinc^2 = 1/2 at nu = 0.4429465
    moving = replace(NOTHING, motion_blur_px=1.0)
    assert sharpness.mtf50_cyc_per_px(moving) == pytest.approx(0.4429465, abs=1e-7)
    assert sharpness.mtf_half_nyquist(moving) == pytest.approx(0.9003163**2, abs=1e-6)


def test_resolution_is_a_full_cycle_on_the_ground() -> None:
    # sinc = 0.1 at nu = 0.9094... of a bare pixel: a cycle is 1.0996 px
    nu10 = optimize.brentq(lambda nu: np.sinc(nu) - 0.1, 0.5, 1.0)
    got = sharpness.resolution_10_m(NOTHING, ground_sample_m=2e-3)
    assert got == pytest.approx(2e-3 / nu10, rel=1e-9)


def test_infinite_blur_resolves_nothing_without_nan() -> None:
    blind = replace(GOOD, defocus_px=np.array([math.inf, 1.0]), working_f_number=np.array([4.0, math.inf]))
    assert np.all(sharpness.highest_frequency_cyc_per_px(0.1, sharpness=blind) < 1e-200)
    length = sharpness.resolution_10_m(blind, ground_sample_m=1e-3)
    assert np.all(length > 1e100)


def test_transfer_along_and_across_are_the_ends_of_the_plane() -> None:
    sharp = with_colour(PLAIN, 1.0, 0.4)
    nu = FREQUENCIES
    assert sharpness.mtf_axes(nu, sharpness=sharp)[0] == pytest.approx(
        sharpness.mtf(nu, across_cyc_per_px=0 * nu, sharpness=sharp), abs=1e-15
    )
    assert sharpness.mtf_axes(0.3, sharpness=sharp)[1] == pytest.approx(
        np.sinc(0.3)
        * sharpness.round_mtf(0.3, sharpness=sharp)
        * lateral.spread_mtf(0.3 * sharp.lateral_k_across, table=LED)
    )


# ---------------------------------------------------------------- symbols


def test_factors_accept_symbols(symbol: Any) -> None:
    sharp = replace(PLAIN, working_f_number=symbol * 8.0, defocus_px=symbol * 2.0, motion_blur_px=symbol)
    expressions = [
        sharpness.sinc_mtf(symbol, width_px=0.7),
        sharpness.diffraction_mtf(symbol, cycle_px=1.3),
        sharpness.defocus_mtf(symbol, disc_px=1.1),
        sharpness.lens_mtf(symbol, lens_pitch_px=0.8),
        sharpness.mtf(0.2, across_cyc_per_px=0.1, sharpness=sharp),
        sharpness.mtf_half_nyquist(sharp),
    ]
    function = casadi.Function(
        "mtf", [symbol], [*expressions, *(casadi.gradient(e, symbol) for e in expressions)]
    )
    # 2.0 lies beyond every null: zeros, and slopes that are finite
    for x in (0.01, 0.4, 0.9, 2.0):
        number = replace(PLAIN, working_f_number=x * 8.0, defocus_px=x * 2.0, motion_blur_px=x)
        expected = [
            sharpness.sinc_mtf(x, width_px=0.7),
            sharpness.diffraction_mtf(x, cycle_px=1.3),
            sharpness.defocus_mtf(x, disc_px=1.1),
            sharpness.lens_mtf(x, lens_pitch_px=0.8),
            sharpness.mtf(0.2, across_cyc_per_px=0.1, sharpness=number),
            sharpness.mtf_half_nyquist(number),
        ]
        got = [float(value) for value in function(x)]
        assert got[: len(expected)] == pytest.approx(expected, rel=1e-9, abs=1e-15)
        assert np.all(np.isfinite(got))


def test_narrowest_bars_are_where_a_tenth_of_all_light_is_left() -> None:
    # a lens for pixels twice as wide: at 0.25 cycles per px 0.5^1 of it and sin(pi / 4) / (pi / 4) of the pixel are
    # left, 0.4501582. A veil that leaves 0.1 / 0.4501582 of contrast makes a tenth of it: bars two pixels wide
    soft = replace(NOTHING, lens_pitch_px=2.0)
    for gsd_m in (1e-3, 3e-3):
        got = sharpness.smallest_bars_m(soft, contrast=0.1 / 0.4501582, ground_sample_m=gsd_m)
        assert got == pytest.approx(2.0 * gsd_m, rel=1e-6)


def test_bars_are_no_narrower_than_a_pixel_and_none_arrive_through_nine_tenths_of_veil() -> None:
    assert sharpness.smallest_bars_m(NOTHING, contrast=1.0, ground_sample_m=1e-3) == pytest.approx(1e-3)
    assert sharpness.smallest_bars_m(NOTHING, contrast=np.array([0.1, 0.05]), ground_sample_m=1e-3).min() == np.inf


def test_bars_are_those_of_the_worse_axis_with_colours_that_spread() -> None:
    """Against the frequencies of blur along alone and across alone; more designs than are looked at together."""
    n, rng = sharpness._BLOCK_ROOTS + 50, np.random.default_rng(5)
    colours = dict(electrons_per_nm=[1.0, 2.0, 1.0], n_water=[1.346, 1.340, 1.337])
    spread = lateral.spread_table([450.0, 550.0, 650.0], **colours)
    blurred = sharpness.Sharpness(
        rng.uniform(2.0, 16.0, n), wavelength_nm=530.0, pixel_pitch_m=3.45e-6, motion_blur_px=rng.uniform(0.0, 3.0, n),
        defocus_px=rng.uniform(0.0, 3.0, n), lens_pitch_px=1.0, lateral_k_along=rng.uniform(0.0, 1500.0, n),
        lateral_k_across=rng.uniform(0.0, 1500.0, n), spread=spread,
    )  # fmt: skip
    contrast = rng.uniform(0.05, 1.0, n)
    got = sharpness.smallest_bars_m(blurred, contrast=contrast, ground_sample_m=1e-3)
    along, across = (
        sharpness.highest_frequency_cyc_per_px(0.1 / contrast, sharpness=replace(blurred, **same))
        for same in (
            {"lateral_k_across": blurred.lateral_k_along},
            {"motion_blur_px": 0.0, "lateral_k_along": blurred.lateral_k_across},
        )
    )  # fmt: skip
    with np.errstate(divide="ignore"):
        expected = 1e-3 / (2.0 * np.minimum(np.minimum(along, across), 0.5))
    assert np.allclose(got, expected, rtol=1e-9)
    assert min(np.sum(along < across), np.sum(across < along), np.sum(np.isinf(got)), np.sum(got == 1e-3)) > 10


def test_frequencies_of_a_level_are_those_of_each_design_alone():
    """Bisection and false position stop at each design's own root, to the last digit."""
    f_numbers, discs = np.array([[1.4], [8.0], [22.0]]), np.array([[0.1, 3.0, 0.7]])
    common = dict(wavelength_nm=530.0, pixel_pitch_m=3.45e-6)
    together = sharpness.highest_frequency_cyc_per_px(
        0.1, sharpness=sharpness.Sharpness(f_numbers, defocus_px=discs, motion_blur_px=0.4, **common)
    )
    for (i, j), of_all in np.ndenumerate(together):
        one = sharpness.Sharpness(f_numbers[i], defocus_px=discs[0, j], motion_blur_px=0.4, **common)
        assert sharpness.highest_frequency_cyc_per_px(0.1, sharpness=one) == of_all
