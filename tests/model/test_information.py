"""Information against plain sums and adaptive quadrature, its transfer's factors from NumPy, SciPy and mpmath."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, special
from sharpness_cases import GOOD, NOTHING, PLAIN, with_colour
from thorough import THOROUGH, drawn

from uwopt.model import lateral
from uwopt.model.information import (
    RULE_ERROR,
    information_bit_per_m2,
    information_bit_per_px,
    information_of_gains,
)
from uwopt.model.sharpness import Sharpness, mtf50_cyc_per_px

J1_NULL = float(special.jn_zeros(1, 1)[0])

blurs = st.floats(0.0, 4.0)
f_numbers = st.floats(1.0, 32.0)
discs = st.floats(0.0, 12.0)
ratings = st.floats(0.0, 3.0)

SNRS = (3.0, 30.0, 250.0)


@cache
def plain_sums_bit_per_px(name: str, cells: int) -> dict[float, float]:
    """By SNR, mean over midpoints of equal cells of the Nyquist square, factors from NumPy and SciPy.

    Half the square is enough: a transfer is the same at the opposite frequency.
    """
    sharp = CASES[name]
    nu = (np.arange(cells) + 0.5) / cells - 0.5
    along, across = nu[cells // 2 :, np.newaxis], nu
    radius = np.hypot(along, across)
    x = np.pi * np.maximum(sharp.defocus_px, 1e-9) * radius
    disc = np.where(x < special.jn_zeros(1, 1)[0], 2.0 * special.j1(x) / x, 0.0)
    s = np.minimum(radius * sharp.diffraction_px, 1.0)
    pupil = (2 * np.arccos(s) - np.sin(2 * np.arccos(s))) / np.pi
    moving = np.where(np.abs(along) * sharp.motion_blur_px < 1.0, np.sinc(along * sharp.motion_blur_px), 0.0)
    rating = 0.5 ** ((2 * sharp.lens_pitch_px * radius) ** 2)
    value = disc * pupil * moving * rating * np.sinc(along) * np.sinc(across)
    if sharp.spread is not None:
        k = sharp.lateral_k_along * along + sharp.lateral_k_across * across
        value = value * lateral.spread_mtf(k, table=sharp.spread)
    return {snr: float(np.mean(0.5 * np.log2(1.0 + (0.1 * snr * value) ** 2))) for snr in SNRS}


CASES = {
    "sharp": GOOD,
    "plain": PLAIN,
    "cut-off between side and corner": replace(GOOD, working_f_number=11.0),  # at 0.581 cycles per px
    "cut-off inside": replace(GOOD, working_f_number=16.0, motion_blur_px=1.0),
    "corner of a dome out of focus": replace(PLAIN, defocus_px=8.5),
    "fast": replace(PLAIN, motion_blur_px=3.0),
    "little colour": with_colour(PLAIN, 0.5, 0.7),
    "much colour, backward": with_colour(GOOD, 3.0, 2.2),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("snr", SNRS)
def test_information_is_that_of_a_plain_sum(name: str, snr: float) -> None:
    # midpoint sum with 1500^2 cells: 1e-5 in the kinks of the worst case, mostly far less
    expected = plain_sums_bit_per_px(name, 1500)[snr]
    assert information_bit_per_px(snr, sharpness=CASES[name]) == pytest.approx(expected, rel=2e-5)


def adaptive_bit_per_px(sharp: Sharpness, snr: float, double: Callable[..., float], m: Any) -> float:
    """Four times the mean over a quadrant, by an adaptive rule over the frequencies at which anything is left.

    double : of a function of (across, along), along from 0 to a number, across from 0 to a function of it; m : where
    functions of a number come from, `math` with SciPy's or mpmath.
    """
    null = J1_NULL / math.pi / max(sharp.defocus_px, 1e-9)
    circle = min(null, 1.0 / sharp.diffraction_px)
    most = min(0.5, circle, 1.0 / max(sharp.motion_blur_px, 1e-9))

    def integrand(across: Any, along: Any) -> Any:
        radius = m.sqrt(along**2 + across**2)
        if radius >= circle:
            return 0.0 * radius
        x, s = m.pi * sharp.defocus_px * radius, radius * sharp.diffraction_px
        disc = 2 * m.besselj(1, x) / x if x > 1e-6 else 1.0
        pupil = 2 / m.pi * (m.acos(s) - s * m.sqrt(1 - s**2))
        rating = m.exp(-m.log(2) * (2 * sharp.lens_pitch_px * radius) ** 2)
        boxes = m.sincpi(along) * m.sincpi(across) * m.sincpi(along * sharp.motion_blur_px)
        return m.log(1 + (0.1 * snr * disc * pupil * rating * boxes) ** 2) / m.log(2) / 2

    def farthest(along: Any) -> Any:
        return min(0.5, m.sqrt(max(circle**2 - along**2, 0.0)))

    return 4.0 * double(integrand, most, farthest)


class Numbers:
    """Functions of a number from the standard library and SciPy, by mpmath's names."""

    pi, sqrt, log, exp, acos = math.pi, math.sqrt, math.log, math.exp, math.acos
    sincpi, besselj = staticmethod(np.sinc), staticmethod(special.jv)


def by_quadpack(integrand: Callable[..., float], most: float, farthest: Callable[..., float]) -> float:
    return float(integrate.dblquad(integrand, 0.0, most, 0.0, farthest, epsrel=1e-8, epsabs=1e-13)[0])


def by_mpmath(integrand: Callable[..., Any], most: float, farthest: Callable[..., Any]) -> float:
    def column(along: Any) -> Any:
        return mpmath.quad(lambda across: integrand(across, along), [0, farthest(along)], maxdegree=5)

    return float(mpmath.quad(column, [0, most], maxdegree=5))


#: Ends far inside the Nyquist square, which a rule that does not end there sees with few of its nodes or none.
STIFF = {
    "disc that ends at 0.02": (replace(PLAIN, defocus_px=61.0), 100.0),
    "pupil that ends at 0.02": (replace(PLAIN, working_f_number=320.0), 100.0),
    "smear of 40 px": (replace(PLAIN, motion_blur_px=40.0), 100.0),
    "smear that ends before a disc": (replace(PLAIN, motion_blur_px=4.3, defocus_px=3.1), 250.0),
    "smear and disc that cut the side off": (replace(PLAIN, motion_blur_px=4.3, defocus_px=2.2), 250.0),
    "disc that cuts corners off": (replace(PLAIN, defocus_px=2.1), 250.0),
    "smear just inside": (replace(GOOD, motion_blur_px=2.05), 250.0),
    "soft lens": (replace(PLAIN, lens_pitch_px=40.0), 250.0),
    "soft lens in a faint image": (replace(GOOD, lens_pitch_px=7.0, motion_blur_px=30.0), 2.0),
}


@cache
def stiff_bit_per_px(name: str, snr: float) -> float:
    """The information of one of them, by adaptive quadrature."""
    return adaptive_bit_per_px(STIFF[name][0], snr, by_quadpack, Numbers)


@pytest.mark.parametrize("name", STIFF)
def test_transfers_that_end_early_are_summed_as_sharp_ones_are(name: str) -> None:
    sharp, snr = STIFF[name]
    assert information_bit_per_px(snr, sharpness=sharp) == pytest.approx(stiff_bit_per_px(name, snr), rel=RULE_ERROR)
    if THOROUGH:
        expected = adaptive_bit_per_px(sharp, snr, by_mpmath, mpmath.mp)
        assert information_bit_per_px(snr, sharpness=sharp) == pytest.approx(expected, rel=RULE_ERROR)


@pytest.mark.parametrize("name", ["smear and disc that cut the side off", "disc that cuts corners off", "soft lens"])
def test_several_contrasts_at_once_tell_what_each_does(name: str) -> None:
    sharp, most = STIFF[name]
    snrs = np.array([most / 40.0, most / 5.0, most])
    columns = replace(sharp, **{n: np.array([getattr(sharp, n)] * 2) for n in ("defocus_px", "motion_blur_px")})
    found = information_of_gains(0.1 * snrs, sharpness=columns)
    truth = [stiff_bit_per_px(name, float(snr)) for snr in snrs]
    assert found == pytest.approx(np.array([truth, truth]), rel=RULE_ERROR)


def random_designs(n: int, most_motion_px: float) -> tuple[np.ndarray, Sharpness]:
    """SNR (0 to 48 dB) and designs spread over what catalogues hold."""
    rng = np.random.default_rng(3)
    sharp = Sharpness(
        working_f_number=rng.choice([1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0], n),
        wavelength_nm=rng.uniform(450.0, 620.0, n),
        pixel_pitch_m=rng.uniform(2e-6, 9e-6, n),
        motion_blur_px=rng.uniform(0.0, most_motion_px, n),
        defocus_px=rng.choice([0.0, 0.5, 1.0, 2.0, 4.0, 8.0], n) * rng.uniform(0.8, 1.2, n),
        lens_pitch_px=rng.uniform(0.0, 1.5, n),
    )
    return 10 ** rng.uniform(0.0, 2.4, n), sharp


@pytest.mark.parametrize("end", ["usual", "disc", "pupil", "smear", "soft", "all"])
def test_default_orders_are_good_wherever_the_transfer_ends(end: str) -> None:
    snr, sharp = random_designs(3000 if THOROUGH else 200, most_motion_px=2.0)
    rng = np.random.default_rng(11)
    early = np.exp(rng.uniform(np.log(1.3), np.log(60.0), snr.size))
    if end in ("disc", "all"):
        sharp = replace(sharp, defocus_px=1.22 * early)
    if end in ("pupil", "all"):
        one_px = sharp.pixel_pitch_m / (sharp.wavelength_nm * 1e-9)
        sharp = replace(sharp, working_f_number=rng.permutation(early) * one_px)
    if end in ("smear", "all"):
        sharp = replace(sharp, motion_blur_px=2.0 * rng.permutation(early))
    if end == "soft":
        sharp = replace(sharp, lens_pitch_px=0.3 * early)
    fine = information_bit_per_px(snr, sharpness=sharp, orders=(64, 40))
    assert information_bit_per_px(snr, sharpness=sharp) == pytest.approx(fine, rel=RULE_ERROR)


@pytest.mark.parametrize(
    ("motion_px", "colour_px"),
    drawn([(4.0, 0.0), (2.0, 0.8), (4.0, 3.9)], [(4.0, 0.0), (2.0, 0.6), (2.0, 0.8), (2.0, 1.9), (4.0, 3.9)]),
)
def test_default_orders_with_much_motion_or_colour_are_good_to_5e_5(
    motion_px: float, colour_px: float
) -> None:
    snr, sharp = random_designs(200, most_motion_px=motion_px)
    sharp = with_colour(sharp, colour_px, 0.7)
    fine = information_bit_per_px(snr, sharpness=sharp, orders=(160, 120))
    assert information_bit_per_px(snr, sharpness=sharp) == pytest.approx(fine, rel=5e-5)


def test_information_without_any_blur_is_shannons() -> None:
    # a lens-less pixel far below its null: only sinc sinc is left. Small SNR: (1/2) log2(1+x) -> x / (2 ln 2),
    # mean of sinc^2 over half a cycle squared = (integral of sinc^2 from -1/2 to 1/2)^2 = 0.7736990^2
    snr = 1e-4
    expected = (0.1 * snr) ** 2 * 0.7736990**2 / (2 * math.log(2))
    assert information_bit_per_px(snr, sharpness=NOTHING) == pytest.approx(expected, rel=1e-5)


def test_information_does_not_change_when_the_radius_points_the_other_way() -> None:
    one, other = with_colour(PLAIN, 1.5, 0.4), with_colour(PLAIN, 1.5, 0.4 + math.pi)
    mirrored = with_colour(PLAIN, 1.5, -0.4)
    bits = [information_bit_per_px(40.0, sharpness=s) for s in (one, other, mirrored)]
    assert bits[1:] == pytest.approx([bits[0]] * 2, rel=1e-12)


@given(n=f_numbers, blur=blurs, disc=discs, rating=ratings, snr=st.floats(0.0, 300.0))
def test_information_rises_with_snr_and_falls_with_blur(
    n: float, blur: float, disc: float, rating: float, snr: float
) -> None:
    base = replace(GOOD, working_f_number=n, motion_blur_px=blur, defocus_px=disc, lens_pitch_px=rating)
    bit = information_bit_per_px(snr, sharpness=base)
    slack = 1e-4 * bit + 1e-15  # the rule's error
    assert 0.0 <= bit <= 0.5 * math.log2(1.0 + (0.1 * snr) ** 2) + 1e-15
    assert information_bit_per_px(snr + 1.0, sharpness=base) >= bit - slack
    for worse in ({"motion_blur_px": blur + 0.5}, {"defocus_px": disc + 0.5}, {"working_f_number": n + 1.0}):
        assert information_bit_per_px(snr, sharpness=replace(base, **worse)) <= bit + slack


def test_designs_broadcast_and_do_not_disturb_each_other() -> None:
    table = replace(
        PLAIN,
        working_f_number=np.array([2.8, 8.0, 16.0]),
        defocus_px=np.array([[0.0], [1.8]]),
    )
    for sharp in (table, with_colour(table, 0.5, 1.0)):
        bits = information_bit_per_px(30.0, sharpness=sharp)
        mtf50 = mtf50_cyc_per_px(sharp)
        assert bits.shape == mtf50.shape == (2, 3)
        single = replace(sharp, working_f_number=16.0, defocus_px=1.8)
        assert bits[1, 2] == pytest.approx(float(information_bit_per_px(30.0, sharpness=single)))
        assert mtf50[1, 2] == pytest.approx(float(mtf50_cyc_per_px(single)), rel=1e-10)


def test_information_per_area_by_hand() -> None:
    # 0.8 bit on 2 mm x 1 mm: 0.8 / 2e-6 m2
    assert information_bit_per_m2(0.8, pixel_area_m2=2e-6) == pytest.approx(4e5)


def test_infinite_blur_tells_nothing() -> None:
    blind = replace(GOOD, defocus_px=np.array([math.inf, 1.0]), working_f_number=np.array([4.0, math.inf]))
    smeared = replace(GOOD, motion_blur_px=math.inf)
    assert np.all(information_bit_per_px(100.0, sharpness=blind) == 0.0)
    assert information_bit_per_px(100.0, sharpness=smeared) < 1e-200  # bit per px: no number is as small
