"""Detail in light scattered nearly forward: Wells' closed form, plain quadrature, limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import itj0y0

from uwopt.model import detail, phase_formulas, scattering

THETA_0 = 0.03


def wells(angle: np.ndarray) -> np.ndarray:
    """Wells' (1973) phase function theta_0 / (2 pi (theta_0^2 + theta^2)^1.5), theta = 2 sin(psi / 2), cut at 2."""
    whole = 1 - THETA_0 / np.hypot(THETA_0, 2.0)
    return np.asarray(THETA_0 / (2 * np.pi * (THETA_0**2 + (2 * np.sin(angle / 2)) ** 2) ** 1.5) / whole)


WELLS = detail.detail_table(scattering.phase_table_of(wells))


@pytest.mark.parametrize("frequency", [3.0, 10.0, 30.0, 100.0, 1000.0])
def test_wells_phase_function_has_the_transfer_of_his_closed_form(frequency: float) -> None:
    # exp(-c r + b r (1 - e^-x) / x), x = 2 pi theta_0 f: Wells (1973), as Hou et al. (2007), equation (6), write it
    x = 2 * np.pi * THETA_0 * frequency
    whole = 1 - THETA_0 / np.hypot(THETA_0, 2.0)
    known = -np.expm1(-x) / x / whole
    assert float(detail.detail_share(frequency, table=WELLS)) == pytest.approx(known, rel=3e-3)  # the cut at 2


@pytest.mark.parametrize("frequency", [5.0, 100.0, 1000.0])
def test_share_of_a_sea_like_function_is_the_plain_integral(frequency: float) -> None:
    index, slope = phase_formulas.fournier_forand_for_backscatter(0.0183)

    def phase(psi: np.ndarray) -> np.ndarray:
        return phase_formulas.fournier_forand_per_sr(psi, index=index, slope=slope)

    def shown(log_psi: float) -> float:
        psi = float(np.exp(log_psi))
        y = 2 * np.pi * frequency * psi
        return float(2 * np.pi * np.sin(psi) * psi * phase(np.array(psi)) * itj0y0(y)[0] / y)

    known = quad(shown, np.log(1e-9), np.log(np.pi), limit=2000, epsabs=1e-7)[0]
    table = detail.detail_table(scattering.phase_table_of(phase))
    # the table holds p even within 0.0035 deg, which takes some of the finest detail
    assert float(detail.detail_share(frequency, table=table)) == pytest.approx(known, rel=2e-3)


def test_the_thickest_water_has_a_gain_that_can_be_squared() -> None:
    assert np.isfinite(np.square(detail.detail_gain(0.1, scattered=1e4, table=WELLS)))


@given(st.floats(0.01, 1e7), st.floats(0.0, 8.0))
def test_coarser_detail_and_longer_ways_have_more_beside_the_straight_light(frequency: float, scattered: float) -> None:
    one = detail.detail_gain(frequency, scattered=scattered, table=WELLS)
    assert 1.0 <= one <= np.exp(scattered)
    assert detail.detail_gain(2 * frequency, scattered=scattered, table=WELLS) <= one
    assert detail.detail_gain(frequency, scattered=2 * scattered, table=WELLS) == pytest.approx(one**2)
