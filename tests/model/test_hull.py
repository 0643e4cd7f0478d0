"""Walls of pressure hulls against hand calculations, and against enclosures that were tested to failure."""

from __future__ import annotations

import math

import pytest

from uwopt.model import hull

ALUMINIUM = {"yield_pa": 276e6, "young_pa": 68.9e9, "poisson": 0.33}
ACRYLIC = {"yield_pa": 65e6, "young_pa": 3.0e9, "poisson": 0.37}


def test_a_kilometre_of_seawater_is_a_hundred_bar():
    assert hull.pressure_pa(1000.0) == pytest.approx(100.55e5, rel=1e-3)  # 1025 * 9.81 * 1000


def test_thin_tube_buckles_at_the_pressure_of_its_ring():
    # E I = 68.9e9 t^3 / (12 (1 - nu^2)) a metre; a ring of mean radius R buckles at 3 E I / R^3
    wall = hull.tube_wall_mm(100.0, pressure_pa=1e6, **ALUMINIUM)
    mean_radius = 50.0 + wall / 2.0
    stiffness = 68.9e9 * wall**3 / (12.0 * (1.0 - 0.33**2))
    assert 3.0 * stiffness / mean_radius**3 == pytest.approx(1e6, rel=1e-9)


def test_thick_tube_yields_by_the_hoop_stress_inside():
    # 80 MPa on aluminium: Lame's hoop stress at the bore, 2 p Ro^2 / (Ro^2 - Ri^2), is 276 MPa at Ro = 77.1 mm
    wall = hull.tube_wall_mm(100.0, pressure_pa=80e6, **ALUMINIUM)
    outer = 50.0 + wall
    assert 2.0 * 80e6 * outer**2 / (outer**2 - 50.0**2) == pytest.approx(276e6, rel=1e-9)
    assert outer == pytest.approx(77.1, abs=0.1)


def test_no_wall_holds_half_the_yield_stress():
    assert hull.tube_wall_mm(100.0, pressure_pa=0.5 * 276e6, **ALUMINIUM) == math.inf


def test_the_tube_that_failed_at_200_m_would_have_been_made_thicker():
    # Blue Robotics 2 in series: 50.8 mm inside, 3.2 mm of acrylic, 12 in long; rated 100 m, failed at 200 m. A long
    # tube, which no end caps stiffen, is the safer one: its wall for 100 m is no more, that for 200 m is more.
    wall = {m: hull.tube_wall_mm(50.8, pressure_pa=hull.pressure_pa(m), **ACRYLIC) for m in (100.0, 200.0)}
    assert wall[100.0] < 3.2 < wall[200.0]


def test_end_cap_bends_to_its_yield_stress():
    # Roark: a simply supported plate under p has 3 (3 + nu) / 8 p (a / t)^2 at its middle
    cap = hull.cap_thickness_mm(100.0, pressure_pa=15e6, yield_pa=276e6, poisson=0.33)
    assert 3.0 * 3.33 / 8.0 * 15e6 * (50.0 / cap) ** 2 == pytest.approx(276e6)
    assert cap == pytest.approx(13.03, abs=0.01)  # 50 sqrt(1.24875 * 15 / 276)


def test_material_of_a_tube_with_two_ends():
    # 100 mm inside, 5 mm wall, 200 mm long: pi / 4 (110^2 - 100^2) 200 = 329 867; two ends of 10 mm: 190 066
    volume = hull.tube_material_mm3(100.0, inner_length_mm=200.0, wall_mm=5.0, cap_mm=10.0)
    assert volume == pytest.approx(519933, abs=1)
