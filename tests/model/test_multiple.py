"""Effective attenuations: limits, and shares of phase functions against closed forms and quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from uwopt.model import multiple, phase_formulas, scattering


def test_nothing_lost_leaves_absorption_and_all_lost_leaves_c() -> None:
    c, b = np.array([0.5, 2.0]), np.array([0.4, 1.9])
    assert multiple.effective_attenuation_per_m(c, scattering_per_m=b, lost_share=0.0) == pytest.approx(c - b)
    assert multiple.effective_attenuation_per_m(c, scattering_per_m=b, lost_share=1.0) == pytest.approx(c)
    half = multiple.effective_attenuation_per_m(c, scattering_per_m=b, lost_share=0.1)
    assert half == pytest.approx([0.14, 0.29])  # 0.1 + 0.04, 0.1 + 0.19, by hand


@pytest.mark.parametrize("degrees", [3.0, 40.0, 90.0, 160.0])
def test_share_beyond_of_henyey_greenstein_is_its_closed_form(degrees: float) -> None:
    # integral of p from psi to 180 deg: (1 - g^2) / (2 g) (1 / sqrt(1 + g^2 - 2 g cos psi) - 1 / (1 + g))
    g = 0.9
    table = scattering.phase_table_of(lambda psi: phase_formulas.henyey_greenstein_per_sr(np.cos(psi), asymmetry=g))
    root = np.sqrt(1 + g * g - 2 * g * np.cos(np.deg2rad(degrees)))
    known = (1 - g * g) / (2 * g) * (1 / root - 1 / (1 + g))
    assert scattering.share_beyond(np.deg2rad(degrees), table) == pytest.approx(known, rel=1e-5)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 90.0, 150.0])
def test_share_beyond_of_molecules_is_the_integral_of_their_function(degrees: float) -> None:
    psi = np.deg2rad(degrees)
    known = quad(lambda t: 2 * np.pi * np.sin(t) * float(phase_formulas.molecular_per_sr(np.cos(t))), psi, np.pi)[0]
    assert scattering.share_beyond(psi, None) == pytest.approx(known, rel=1e-9)


def test_wider_lobes_lose_less_of_what_is_scattered() -> None:
    lobes = np.deg2rad([10.0, 40.0, 70.0])
    assert np.rad2deg(multiple.lamp_angle_rad(lobes)) == pytest.approx([28.8, 54.6, 80.4])  # by hand
    assert np.all(np.diff(multiple.back_share(lobes)) < 0)


@pytest.mark.parametrize(
    ("absorbed", "back", "floor"), [(0.1, 0.02, 0.3), (0.5, 0.2, 0.0), (1.5, 0.03, 0.9), (0.05, 0.3, 0.5)]
)
def test_light_that_turns_back_is_that_of_layers_laid_on_each_other(absorbed: float, back: float, floor: float) -> None:
    # even light goes twice as far: thin layers of 2 a r and 2 b_b r doubled (Stokes 1862), a deep sea above the lamp
    n = 20
    r, t, slab = 2.0 * back / 2**n, 1.0 - 2.0 * (absorbed + back) / 2**n, (0.0, 0.0)
    for doubled in range(n + 12):
        r, t = r + t * t * r / (1.0 - r * r), t * t / (1.0 - r * r)
        if doubled == n - 1:
            slab = r, t
    sea, (r, t) = r, slab
    down, arrived = 1.0, 0.0
    while down > 1e-18:  # turn by turn, lamp to floor and back
        held, up = down * t, down * r
        while held > 1e-18:  # between floor and slab
            up, arrived, held = up + held * floor * t, arrived + held, held * floor * r
        down = sea * up
    straight = np.exp(-2.0 * (absorbed + back))
    found = float(multiple.returned_gain(absorbed, turned_back=back, reflectance=floor))
    assert found == pytest.approx(arrived / straight, rel=1e-5)  # thin layers are thin to 1e-6


def test_no_light_turns_back_where_nothing_turns_it() -> None:
    assert float(multiple.returned_gain(0.7, turned_back=0.0, reflectance=0.5)) == 1.0
    assert float(multiple.returned_gain(0.0, turned_back=0.0, reflectance=0.5)) == 1.0
