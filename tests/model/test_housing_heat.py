"""How warm the air in a housing becomes, against hand calculations, cabinets' tables and a pipe's exact resistance."""

from __future__ import annotations

import math

import pytest

from uwopt.model.housing_heat import cooled_m2, warmer_k


def test_a_camera_with_its_computer_in_an_acrylic_tube():
    """3 + 6 W in 89 x 200 mm behind 6.3 mm: 9 / 0.0621 (1/8 + 0.0063/0.19 + 1/300) = 144.8 x 0.16149 = 23.4 K."""
    area = cooled_m2(0.089, 0.2)
    assert area == pytest.approx(0.05592 + 0.00622, abs=2e-5)  # the tube and one end cap
    warmer = warmer_k(9.0, area, wall_m=0.0063, conductivity_w_mk=0.19, air_w_m2k=8.0, water_w_m2k=300.0)
    assert warmer == pytest.approx(23.39, abs=0.05)
    in_metal = warmer_k(9.0, area, wall_m=0.0045, conductivity_w_mk=167.0, air_w_m2k=8.0, water_w_m2k=300.0)
    assert in_metal == pytest.approx(18.6, abs=0.05)  # the wall itself is nothing


def test_a_cabinet_of_painted_steel_in_still_air():
    """Makers of cabinets reckon 5.5 W/(m2 K) from air to air: 100 W on 1 m2 make 18.2 K, by two films of 11 each."""
    warmer = warmer_k(100.0, 1.0, wall_m=0.0015, conductivity_w_mk=50.0, air_w_m2k=11.0, water_w_m2k=11.0)
    assert warmer == pytest.approx(100.0 / 5.5, rel=1e-3)


def test_a_thin_wall_leads_as_a_pipe_does():
    """ln(r_o / r_i) / (2 pi k L) of a pipe, to what the thin wall is thicker inside: 7 % at 6.3 on 89 mm."""
    inner, wall, length, k = 0.089, 0.0063, 0.3, 0.19
    pipe = math.log(1.0 + 2.0 * wall / inner) / (2.0 * math.pi * k * length)
    flat = wall / (k * math.pi * inner * length)
    assert 1.0 < flat / pipe < 1.08
    huge = {"air_w_m2k": 1e9, "water_w_m2k": 1e9}
    assert warmer_k(1.0, math.pi * inner * length, wall_m=wall, conductivity_w_mk=k, **huge) == pytest.approx(flat)


def test_half_of_a_sphere_cools():
    assert cooled_m2(0.2, None) == pytest.approx(2.0 * math.pi * 0.1**2)
