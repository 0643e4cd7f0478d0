"""Room in a housing, by hand: a body of 30 x 40 x 35 mm, 45 mm for the plug, a lens of 50 mm with its pupil at 20."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from uwopt.model.enclosure import Bodies, dome_needed_m, mouth_needed_m, sphere_needed_m, tube_needed_m


def bodies(**changes: float) -> Bodies:
    """In metres, one row."""
    sizes = {
        "camera_width_m": 0.030, "camera_height_m": 0.040, "camera_length_m": 0.035, "plug_m": 0.045,
        "lens_diameter_m": 0.030, "lens_length_m": 0.050, "pupil_m": 0.020, **changes,
    }  # fmt: skip
    return Bodies(**{name: np.array([value]) for name, value in sizes.items()})


def test_tube_behind_a_dome_begins_at_the_pupil():
    # across the corners 50 mm; behind the pupil 30 + 35 + 45; 2 mm to each wall
    width, length = tube_needed_m(bodies(), is_dome=True, gap_m=0.0)
    assert width[0] == pytest.approx(0.054)
    assert length[0] == pytest.approx(0.112)


def test_tube_behind_a_flat_port_holds_the_whole_lens():
    assert tube_needed_m(bodies(), is_dome=False, gap_m=0.0)[1][0] == pytest.approx(0.132)
    assert tube_needed_m(bodies(), is_dome=False, gap_m=0.060)[1][0] == pytest.approx(0.172)  # 40 mm of air in front


def test_wide_lens_decides_where_the_body_is_slender():
    assert tube_needed_m(bodies(lens_diameter_m=0.070), is_dome=True, gap_m=0.0)[0][0] == pytest.approx(0.074)


def test_lens_front_stands_in_the_dome():
    # 20 mm before the centre, 15 mm from the axis: 25 mm away
    assert dome_needed_m(bodies())[0] == pytest.approx(0.027)
    assert dome_needed_m(bodies(lens_diameter_m=0.0, pupil_m=0.0))[0] == 0.0


def test_behind_a_spherical_cap_the_pupil_stands_deeper_in_the_tube():
    # a sphere of 50 mm inside, open over 80 mm: its middle lies sqrt(50^2 - 40^2) = 30 mm behind the rim
    assert tube_needed_m(bodies(), is_dome=True, gap_m=0.030)[1][0] == pytest.approx(0.142)


def test_the_corner_ray_of_a_cap_needs_a_mouth_as_wide_as_it_is_there():
    # 30 mm from the pupil to the rim, half a field of 45 degrees: 30 mm to each side
    assert mouth_needed_m(np.array([1.0]), gap_m=np.array([0.030]))[0] == pytest.approx(0.060)
    assert mouth_needed_m(np.array([np.inf]), gap_m=np.array([0.0]))[0] == 0.0  # a hemisphere's pupil stands in it


def test_a_lens_free_in_a_cap_passes_its_opening():
    # 50 mm inside, open over 96 mm, 14 mm from middle to rim: what is free of the glass 20 mm ahead, 43.6 mm from the
    # axis, is 4.4 mm from the rim
    widest = 2.0 * (math.sqrt(48.0**2 - 20.0**2))
    assert dome_needed_m(bodies(lens_diameter_m=1e-3 * widest))[0] == pytest.approx(0.050)
    assert widest / 2 + 2.0 < 48.0


def test_sphere_holds_the_rear_corner():
    # 110 mm behind the centre, 25 mm from the axis
    assert sphere_needed_m(bodies())[0] == pytest.approx(2 * (math.hypot(110, 25) + 2) * 1e-3)
    short = replace(bodies(), camera_length_m=np.zeros(1), plug_m=np.zeros(1), camera_width_m=np.zeros(1))
    assert sphere_needed_m(replace(short, lens_length_m=np.array([0.02])))[0] == pytest.approx(0.054)  # front: 25 + 2
