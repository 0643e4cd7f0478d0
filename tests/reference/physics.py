"""Textbook forms of the physics page that the program itself takes another way, or not at all."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwopt.model.scattering import PhaseTable, share_beyond
from uwopt.model.sensor import electron_rate_per_m2_s_nm


def photo_electrons(
    irradiance_w_m2_nm: Any,
    *,
    wavelength_nm: Any,
    quantum_efficiency: Any,
    pixel_pitch_m: Any,
    exposure_s: Any,
) -> Any:
    """Mean electrons of one pixel and exposure, p^2 t / (h c) integral of E lambda eta (5), by trapezoids."""
    rate = electron_rate_per_m2_s_nm(
        irradiance_w_m2_nm, wavelength_nm=wavelength_nm, quantum_efficiency=quantum_efficiency
    )
    return np.trapezoid(rate, wavelength_nm, axis=-1) * pixel_pitch_m**2 * exposure_s


def solid_angle_integral(table: PhaseTable) -> float:
    """Integral of a phase function over the sphere, 2 pi integral of p sin psi d psi: 1."""
    return _moment(table, 0)


def backscatter_ratio(table: PhaseTable) -> float:
    """Share of a table scattered beyond 90 degrees: b_b/b [1]."""
    return share_beyond(np.pi / 2, table)


def mean_cosine(table: PhaseTable) -> float:
    """Mean cosine of the scattering angle, g = 2 pi integral of p cos psi sin psi d psi."""
    return _moment(table, 1)


def _moment(table: PhaseTable, cosine_power: int) -> float:
    """Gauss's rule in each cell of a table that is linear in x = sin(psi / 2); d Omega = 8 pi x dx."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    share = 0.5 * (1.0 + nodes)
    cell = np.arange(table.n_cell)
    low, high = table.phase_per_sr[cell], table.phase_per_sr[cell + 1]
    x = (cell[:, None] + share) / table.n_cell
    phase = low[:, None] + (high - low)[:, None] * share
    terms = phase * 8 * np.pi * x * (1 - 2 * x**2) ** cosine_power
    return float(np.sum(terms * weights) / (2 * table.n_cell))
