"""Reflection at the floor."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from uwopt.model.seafloor import lambertian_radiance


@given(irradiance=st.floats(1e-6, 1e6), reflectance=st.floats(0, 1))
def test_a_matt_floor_sends_back_the_share_that_it_reflects(irradiance: float, reflectance: float) -> None:
    # exitance = integral over the hemisphere of L cos(t) d Omega = E M
    radiance = lambertian_radiance(irradiance, reflectance=reflectance)
    exitance = radiance * quad(lambda t: 2 * np.pi * np.cos(t) * np.sin(t), 0, np.pi / 2)[0]
    assert exitance == pytest.approx(irradiance * reflectance, rel=1e-12)  # quadrature of a sine


def test_radiance_broadcasts_over_a_spectrum() -> None:
    assert lambertian_radiance(
        np.pi * np.ones((2, 3)), reflectance=np.array([0.1, 0.2, 0.3])
    ) == pytest.approx(np.array([[0.1, 0.2, 0.3]] * 2))
