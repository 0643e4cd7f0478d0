"""An SNR that 95 % of the image must reach: places, order of pixels, and the light that serves them, by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hand_made_rows import scene
from scipy.optimize import brentq

from uwopt.forward.setting_rows import of_farthest_pixels, of_fewest_pixels
from uwopt.model.image_mean import (
    FEW_FRAME_MAY_MISS,
    FEW_FRAME_PLACES,
    FRAME_MAY_MISS,
    FRAME_PLACES,
    frame_places,
    needed_by_most,
    reached_by_most,
)
from uwopt.solvers.exact.needs import least_mean_frac
from uwopt.solvers.settings import windows
from uwopt.solvers.settings.windows import Sun

SQUARE = np.array([1.0]), np.array([1.0])
COUNTED, FEW_COUNTED = 1.0 / FRAME_PLACES, 1.0 / FEW_FRAME_PLACES  # to so much of the image are shares counted


def radius_of(share: float) -> float:
    """Radius about the middle of a square of half width 1 outside which this share of it lies."""

    def outside(r: float) -> float:
        inside = 4.0 * (math.sqrt(r * r - 1.0) + r * r * (math.pi / 4.0 - math.acos(1.0 / r)))
        return 1.0 - inside / 4.0 - share

    return float(brentq(outside, 1.0, math.sqrt(2.0)))


@pytest.mark.parametrize(
    ("few", "may_miss", "counted"), [(False, FRAME_MAY_MISS, COUNTED), (True, FEW_FRAME_MAY_MISS, FEW_COUNTED)]
)
def test_a_twentieth_of_the_image_lies_beyond_the_place_that_counts(few: bool, may_miss: int, counted: float) -> None:
    along, across = frame_places(*SQUARE, few=few)
    # light that falls to one side, along and across: 5 % of the image lie within 0.1 of its edge
    for side in (along, across):
        assert reached_by_most(side, may_miss)[0] == pytest.approx(-0.9, abs=2.0 * counted)
    # and to all corners: 5 % lie farther out than a circle that the square's four segments cut
    found = reached_by_most(-np.hypot(along, across), may_miss)[0]
    assert -found == pytest.approx(radius_of(0.05), abs=4.0 * counted)


@pytest.mark.parametrize(("few", "count"), [(False, FRAME_PLACES), (True, FEW_FRAME_PLACES)])
def test_places_share_out_the_image_evenly(few: bool, count: int) -> None:
    along, across = frame_places(*SQUARE, few=few)
    for u, v in ((0.5, 0.5), (-0.3, 0.8), (0.1, -0.6)):
        inside = ((along < u) & (across < v)).mean()
        assert inside == pytest.approx(0.25 * (1.0 + u) * (1.0 + v), abs=4.0 / count)
    assert np.unique(along).size == np.unique(across).size == count


def test_the_darkest_few_may_miss() -> None:
    values = np.array([[5.0, 1.0, 4.0, 2.0, 3.0]])
    assert [float(reached_by_most(values, k)[0]) for k in (0, 1, 2)] == [1.0, 2.0, 3.0]
    assert [float(needed_by_most(values, k)[0]) for k in (0, 1, 2)] == [5.0, 4.0, 3.0]
    assert needed_by_most(np.array([[np.inf, 7.0, np.inf]]), 2)[0] == 7.0


def pixels(signal_e: list[float], **changed: Any) -> Any:
    """A sensor with shot noise alone, and pixels of one altitude: SNR^2 = mu."""
    rows = scene(read_noise_e=0.0, gain_dn_per_e=1e9, full_scale_dn=1e18, **changed)
    return replace(rows, worst_e=np.array([[signal_e]]))


@pytest.mark.parametrize(("may_miss", "dimmest_e"), [(0, 2.0), (1, 3.0), (2, 10.0)])
def test_light_for_an_snr_of_20_over_most_pixels(may_miss: int, dimmest_e: float) -> None:
    rows = replace(pixels([10.0, 2.0, 30.0, 3.0]), may_miss=may_miss)
    # 400 electrons in the dimmest that may not miss: X = 400 / (electrons per lm s)
    found = windows.light_for_snr(rows, 0, 20.0, of="worst")
    assert found[0] == pytest.approx(400.0 / dimmest_e, rel=1e-9)


@pytest.mark.parametrize(("of_mean", "of_pixels", "light_x"), [(20.0, 10.0, 40.0), (20.0, 16.0, 256.0 / 3.0)])
def test_the_mean_has_its_snr_where_pixels_may_have_less(of_mean: float, of_pixels: float, light_x: float) -> None:
    """SNR 20 asks for 400 electrons of a mean of 10 a lm s; 10 and 16 for 100 and 256 of the second dimmest, of 3."""
    asked = dict(min_snr_mean=of_mean, min_snr=of_pixels)
    rows = replace(pixels([10.0, 2.0, 30.0, 3.0]), may_miss=1, signal_e=np.array([[10.0]]), **asked)
    assert windows.light_asked_for(rows)[0] == pytest.approx(light_x, rel=1e-9)


def test_pixels_that_no_light_serves_may_miss_too() -> None:
    rows = replace(pixels([0.0, 8.0, 16.0]), may_miss=1, read_noise_e=np.array([1e-3]))
    assert windows.light_for_snr(rows, 0, 20.0, of="worst")[0] == pytest.approx(50.0, rel=1e-8)
    assert windows.light_for_snr(replace(rows, may_miss=0), 0, 20.0, of="worst")[0] == np.inf


def test_a_pixel_in_the_sun_needs_the_rest_alone() -> None:
    rows = replace(pixels([4.0, 4.0, 4.0]), may_miss=1)
    # 100, 200 and 300 electrons of the sun: the second needs 400 - 200 of 4 a lm s
    there = np.array([[[300.0, 100.0, 200.0]]])
    sun = Sun(np.array([[200.0]]), np.array([[200.0]]), there, there)
    assert windows.light_for_snr(rows, 0, 20.0, of="worst", sun=sun)[0] == pytest.approx(50.0, rel=1e-9)


@pytest.mark.parametrize(("pixels_asked", "least"), [(None, 1.0), ("darkest", 1.0), ("frame", 0.95)])
def test_the_mean_may_be_darker_than_what_most_of_the_image_has(pixels_asked: Any, least: float) -> None:
    """An even image of which a twentieth is black has 95 % of its light; no even or falling one has less."""
    asked: Any = type("Asked", (), {"pixels": pixels_asked})()
    frac = least_mean_frac(asked)
    assert 0.8 * least <= frac <= least


@pytest.mark.parametrize("may_miss", [0, 3])
def test_pixels_at_the_farthest_altitude_stand_for_all_under_the_sun(may_miss: int) -> None:
    """Three altitudes: what all pixels ask for at the last is no more than they do at all."""
    rng = np.random.default_rng(8)
    lamps, there = rng.uniform(1.0, 9.0, (2, 3, 40)), rng.uniform(1.0, 99.0, (2, 3, 40))
    rows = replace(
        pixels([1.0], min_snr=20.0), worst_e=lamps, worst_veil_e=0.2 * lamps, may_miss=may_miss,
        worst_sun_signal_e_s=there, worst_sun_veil_e_s=0.1 * there, signal_e=np.ones((2, 3)),
    )  # fmt: skip

    def sun(of: Any) -> Sun:
        every = of.worst_sun_signal_e_s + of.worst_sun_veil_e_s
        return Sun(np.ones((2, 3)), np.ones((2, 3)), of.worst_sun_signal_e_s, every)

    few = of_farthest_pixels(rows, unlit=False)
    assert few.worst_e is not None and few.worst_e.shape[2] < 40 and few.may_miss == may_miss
    asked = windows.light_for_snr(rows, 2, 20.0, of="worst", sun=sun(rows))
    assert windows.light_asked_for(few, sun=sun(few)) == pytest.approx(asked, rel=1e-12)
    assert (windows.light_asked_for(rows, sun=sun(rows)) >= asked).all()


@pytest.mark.parametrize("may_miss", [0, 3])
@pytest.mark.parametrize("veiled", [True, False])
@pytest.mark.parametrize("unlit", [True, False])
def test_the_few_pixels_under_the_sun_ask_for_what_all_do(may_miss: int, veiled: bool, unlit: bool) -> None:
    """In four designs, at three strengths of the sun; by sorting what all pixels ask for."""
    rng = np.random.default_rng(9)
    lamps, there, over = (rng.uniform(1.0, most, (4, 1, 40)) for most in (9.0, 99.0, 30.0))
    rows = replace(
        pixels([1.0]), worst_e=lamps, worst_veil_e=0.2 * over if veiled else None, may_miss=may_miss,
        worst_sun_signal_e_s=there, worst_sun_veil_e_s=over if veiled else None,
    )  # fmt: skip
    few: Any = of_fewest_pixels(rows, unlit=unlit)
    assert few.worst_e.shape[2] < 40 and few.may_miss == may_miss
    assert (few.worst_veil_e is None) == (few.worst_sun_veil_e_s is None) == (not veiled)

    def snr(of: Any, share: float) -> Any:
        signal = share * of.worst_sun_signal_e_s
        every = signal if of.worst_sun_veil_e_s is None else signal + share * of.worst_sun_veil_e_s
        return np.sort(signal / np.sqrt(every + 4.0), axis=2)[:, :, may_miss]

    def asked(of: Any, share: float) -> Any:
        signal = share * of.worst_sun_signal_e_s
        every = signal if of.worst_sun_veil_e_s is None else signal + share * of.worst_sun_veil_e_s
        mean = np.full((4, 1), share)
        return windows.light_of_each(of, 0, 20.0, of="worst", sun=Sun(mean, mean, signal, every))

    for share in (1.0, 4.0) if unlit else ():  # the sun alone, by hand: 4 e^2 of noise
        assert snr(few, share) == pytest.approx(snr(rows, share), rel=1e-12)
    for share in () if unlit else (0.0, 1.0, 4.0):
        of_all, of_few = (np.sort(asked(of, share), axis=1)[:, -1 - may_miss] for of in (rows, few))
        assert of_few == pytest.approx(of_all, rel=1e-12)


def test_pixels_are_left_as_they_are_where_no_sun_shines() -> None:
    rows = replace(pixels([4.0, 4.0, 5.0]), may_miss=1)
    assert of_fewest_pixels(rows, unlit=False) is rows
