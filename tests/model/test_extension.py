"""Lenses on rings, by hand and by a seller's table of lengths."""

from __future__ import annotations

import math

import pytest

from uwopt.model.extension import extended_distance_m, extension_m, focus_range_m


def test_extension_and_distance_are_the_thin_lens_by_hand():
    # 10 mm focused at 110 mm: 1/10 - 1/110 = 1/11, so the image lies 11 mm behind it, 1 mm farther than at infinity
    assert extension_m(0.110, focal_length_m=0.010) == pytest.approx(0.001)
    assert extended_distance_m(0.001, focal_length_m=0.010) == pytest.approx(0.110)
    assert extension_m(math.inf, focal_length_m=0.010) == 0.0 and extension_m(0.010, focal_length_m=0.010) == math.inf


@pytest.mark.parametrize(
    ("ring_mm", "far_mm", "near_mm"),
    [(0.5, 5050, 463), (1.0, 2552, 432), (1.5, 1719, 406), (5.0, 553, 289), (10.0, 303, 216)],
)
def test_lens_of_50_mm_focuses_on_rings_as_a_seller_tabulates(ring_mm: float, far_mm: float, near_mm: float):
    """Vision Elements' table of C-mount rings, nearest focus 500 mm without; the last is 1/f = 1/s + 1/(f + x)."""
    near, far = focus_range_m(0.050, nearest_m=0.500, spacer_m=ring_mm * 1e-3)
    assert (near, far) == pytest.approx((near_mm * 1e-3, far_mm * 1e-3), rel=0.025)  # it counts from the lens's front


def test_without_ring_a_lens_focuses_from_its_makers_distance_to_infinity():
    assert focus_range_m(0.008, nearest_m=0.1, max_magnification=0.01) == (0.1, math.inf)
    assert focus_range_m(0.008, nearest_m=0.0) == (0.008, math.inf)


def test_a_ring_goes_no_nearer_than_the_lens_bears():
    # 10 mm, nearest 0.26 m: own x_0 = 0.1 / 250 m = 0.4 mm; on 1 mm 1.4 mm, s = 10 + 100 / 1.4 = 81.4 mm;
    # but no more than a magnification of 0.1, 1.0 mm, s = 110 mm
    assert focus_range_m(0.010, nearest_m=0.26, spacer_m=1e-3)[0] == pytest.approx(0.0814286, rel=1e-5)
    assert focus_range_m(0.010, nearest_m=0.26, spacer_m=1e-3, max_magnification=0.1)[0] == pytest.approx(0.110)


def test_a_lens_screwed_out_of_its_thread_keeps_infinity():
    # 6 mm, nearest 0.306 m: x_0 = 36 / 300 = 0.12 mm, with 0.3 mm of thread 0.42 mm, s = 6 + 36 / 0.42 = 91.7 mm
    near, far = focus_range_m(0.006, nearest_m=0.306, thread_m=3e-4)
    assert near == pytest.approx(0.0917143, rel=1e-5) and far == math.inf
