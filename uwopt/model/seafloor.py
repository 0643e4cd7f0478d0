"""What the seafloor makes of the light that reaches it."""

from __future__ import annotations

import numpy as np

from uwopt.model.spectrum import Symbolic


def lambertian_radiance(irradiance_w_m2_nm: Symbolic, *, reflectance: Symbolic) -> Symbolic:
    """Radiance of a floor that scatters evenly.

        L = E M / pi                                                                      (2)

    Parameters
    ----------
    irradiance_w_m2_nm : (...,) [W m^-2 nm^-1], on the floor, the cosine of incidence included
    reflectance : scalar or broadcasting [1], M(lambda), 0 to 1

    Returns
    -------
    (...,) [W m^-2 sr^-1 nm^-1], the same in every direction

    Notes
    -----
    Valid for matt floors. Densities and totals, radiant and luminous alike: lux in, cd/m^2 out.

    References
    ----------
    Billings, Iscar, Johnson-Roberson (2020), equation (2).
    """
    return irradiance_w_m2_nm * reflectance / np.pi
