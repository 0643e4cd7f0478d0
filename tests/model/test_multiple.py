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
