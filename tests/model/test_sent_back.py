"""The phase function as turned light meets it: one turn by plain rotation, energy, limits, and bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad

from uwopt.model import phase_formulas
from uwopt.model.scattering import PhaseTable, look_up, phase_table_of, share_beyond
from uwopt.model.sent_back import least_widened_phase, mean_way_m, widened_phase

Array = NDArray[Any]
PSI = np.deg2rad([62.0, 75.0, 90.0, 110.0, 135.0, 160.0, 180.0])


def henyey_greenstein(g: float) -> PhaseTable:
    return phase_table_of(lambda psi: phase_formulas.henyey_greenstein_per_sr(np.cos(psi), asymmetry=g))


def all_light(table: PhaseTable) -> float:
    """Integral over the sphere, exact for the table."""
    return share_beyond(0.0, PhaseTable(table.phase_per_sr))


@pytest.mark.parametrize("k", [0.0, 1e-4, 0.3, 2.0])
@pytest.mark.parametrize("range_m", [0.5, 6.0])
def test_the_mean_way_is_that_of_evenly_lit_water(range_m: float, k: float) -> None:
    sent = quad(lambda r: np.exp(-2.0 * k * r), 0.0, range_m)[0]
    way = quad(lambda r: 2.0 * r * np.exp(-2.0 * k * r), 0.0, range_m)[0]
    assert mean_way_m(range_m, k) == pytest.approx(way / sent, rel=1e-6)


def test_endless_water_sends_back_from_one_attenuation_length() -> None:
    assert mean_way_m(1e9, np.array([0.5, 0.25])) == pytest.approx([2.0, 4.0])


def test_one_turn_is_a_rotation() -> None:
    """Of light that turns by psi after a share s of its way: by vectors, azimuth by azimuth, no Legendre orders."""
    table, thin = henyey_greenstein(0.8), 1e-3
    made = look_up(np.cos(PSI), widened_phase(table, [(thin, table)]))
    own = look_up(np.cos(PSI), table)
    node, part = np.polynomial.legendre.leggauss(40)
    s, psi = 0.5 * (node + 1.0), 0.25 * np.pi * (node + 1.0)
    mass = 2 * np.pi * np.sin(psi) * phase_formulas.henyey_greenstein_per_sr(np.cos(psi), asymmetry=0.8) * part
    mass *= 0.25 * np.pi
    azimuth = 2 * np.pi * (np.arange(180) + 0.5) / 180
    found = np.zeros(len(PSI))
    for share, weight in zip(s, 0.5 * part, strict=True):
        square = np.square(share * np.cos(psi)) - share**2 + 1.0  # the place where it meets the unit sphere
        second = np.sqrt(square) - share * np.cos(psi)
        aslant = psi - np.arctan2(second * np.sin(psi), share + second * np.cos(psi))
        cos = np.cos(PSI)[:, None, None] * np.cos(aslant)[:, None]
        cos = cos + np.sin(PSI)[:, None, None] * np.sin(aslant)[:, None] * np.cos(azimuth)
        met = look_up(np.minimum(cos, 0.5), table).mean(axis=2)
        found += weight * ((met - own[:, None]) @ mass)
    assert (made - own) / thin == pytest.approx(found, rel=0.02, abs=2e-3 * float(own.max()))


@pytest.mark.parametrize("thickness", [0.0, 0.3, 3.0, 12.0])
@pytest.mark.parametrize("g", [0.5, 0.8, 0.95])
def test_what_is_sent_back_is_spread_but_neither_lost_nor_made(g: float, thickness: float) -> None:
    table = henyey_greenstein(g)
    made = widened_phase(table, [(thickness, table), (0.1 * thickness, None)])
    assert all_light(made) == pytest.approx(1.0, rel=1e-4)
    assert np.all(made.phase_per_sr > 0.0)
    if thickness == 0.0:
        np.testing.assert_allclose(made.phase_per_sr, table.phase_per_sr, rtol=1e-12)


def test_an_even_function_stays_even() -> None:
    even = phase_table_of(lambda psi: np.full_like(psi, 1 / (4 * np.pi)))
    made = widened_phase(even, [(3.0, henyey_greenstein(0.8))])
    np.testing.assert_allclose(made.phase_per_sr, even.phase_per_sr, rtol=1e-6)


def test_more_turns_fill_what_is_hollow() -> None:
    table = henyey_greenstein(0.8)
    straight_back = [float(look_up(-1.0, widened_phase(table, [(t, table)]))) for t in (0.0, 0.5, 1.0, 2.0, 4.0)]
    assert np.all(np.diff(straight_back) > 0.0)


def test_the_least_in_several_waters_is_that_of_each_alone() -> None:
    table, thickness = henyey_greenstein(0.8), np.array([0.1, 2.0, 0.7])
    least = least_widened_phase(table, [(thickness, table), (0.1 * thickness[::-1], None)])
    pairs = zip(thickness, 0.1 * thickness[::-1], strict=True)
    every = np.array([widened_phase(table, [(t, table), (m, None)]).phase_per_sr for t, m in pairs])
    np.testing.assert_allclose(least.phase_per_sr, every.min(axis=0), rtol=1e-12)
    assert len(np.unique(np.argmin(every, axis=0))) > 1
