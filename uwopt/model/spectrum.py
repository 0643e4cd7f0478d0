"""Wavelength grids, integrals over wavelength, and spectra that are formulas.

Every spectral quantity is sampled on one grid, in nm, increasing; the spectral axis is the last one.
Tables come in as arguments: nothing here reads a file.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.errors import RangeError

Symbolic = Any  # a float, an array or a CasADi symbol: whatever elementwise NumPy functions accept

PLANCK_J_S = 6.62607015e-34  # exact in the SI since 2019
LIGHT_SPEED_M_S = 299_792_458.0  # exact in the SI
BOLTZMANN_J_PER_K = 1.380649e-23  # exact in the SI since 2019
# 683 lm/W holds at 540 THz exactly; at the maximum of V (555 nm in air) it is 683.002 (CIE 018:2019).
MAX_LUMINOUS_EFFICACY_LM_W = 683.002
PLANCK_REFERENCE_NM = 560.0  # where the CIE scales its thermal illuminants to one value

# Phosphor-converted white LED: blue die and phosphor as two normal densities (area, mean nm, sigma nm).
LED_BLUE = (24.49, 450.70, 11.67)
LED_PHOSPHOR = (119.86, 565.43, 64.63)
FIRST_NM, LAST_NM = 380.0, 780.0  # of what is visible
SPAN_NM = LAST_NM - FIRST_NM


def wavelength_grid_nm(step_nm: float = 5.0) -> FloatArray:
    """Equidistant wavelengths of what is visible, both ends included; the step must divide the span."""
    n_step = round(SPAN_NM / step_nm) if step_nm > 0 else 0
    if n_step < 1 or abs(FIRST_NM + n_step * step_nm - LAST_NM) > 1e-9 * LAST_NM:
        raise RangeError(f"a step of {step_nm:g} nm does not divide {FIRST_NM:g}-{LAST_NM:g} nm")
    return np.linspace(FIRST_NM, LAST_NM, n_step + 1)


def trapezoid_weights_nm(wavelength_nm: ArrayLike) -> FloatArray:
    """Weights w of the trapezoid rule, so that sum(f w) integrates f over wavelength [nm]."""
    wavelength = _increasing(wavelength_nm, "wavelength grid")
    weights = np.zeros_like(wavelength)
    half_step = np.diff(wavelength) / 2
    weights[:-1] += half_step
    weights[1:] += half_step
    return weights


def integrate_nm(values: ArrayLike, wavelength_nm: ArrayLike) -> Any:
    """Integral over wavelength by the trapezoid rule: (..., n) [u/nm] -> (...) [u].

    Exact where the integrand is linear between samples; else the error falls with the step squared.
    """
    return np.asarray(values, dtype=float) @ trapezoid_weights_nm(wavelength_nm)


def resample(
    wavelength_nm: ArrayLike,
    *,
    table_nm: ArrayLike,
    table_values: ArrayLike,
    outside: Literal["zero", "hold", "raise"],
) -> FloatArray:
    """A tabulated spectrum on another grid, linear between entries.

    Parameters
    ----------
    wavelength_nm : (n,) [nm], where the values are wanted
    table_nm, table_values : (m,) [nm] increasing, (m,) any unit
    outside : beyond the table the value is zero, or its end value, or a RangeError naming the gap

    Returns
    -------
    (n,) in the unit of the table
    """
    wanted = np.asarray(wavelength_nm, dtype=float)
    table = _increasing(table_nm, "table")
    values = np.asarray(table_values, dtype=float)
    if values.shape != table.shape:
        raise RangeError(f"a table has {table.size} wavelengths but {values.size} values")
    if outside == "raise":
        _require_cover(wanted, table)
    fill = 0.0 if outside == "zero" else None
    return np.asarray(np.interp(wanted, table, values, left=fill, right=fill), dtype=float)


def resample_power(wavelength_nm: ArrayLike, *, table_nm: ArrayLike, table_values: ArrayLike) -> FloatArray:
    """A lamp's tabulated spectrum on a grid, zero beyond the table, so that no line falls between the points.

        S_i = integral of S h_i d lambda / integral of h_i d lambda,   h_i the hat function of point i

    Arguments as in `resample`; (n,) in the unit of the table. Where no two entries are closer than any of the
    grid's points it is `resample`. Else sum(w S f), w the trapezoid's weights, is the integral of S f for every f that
    is linear between the points, however narrow the lines of S are.
    """
    grid, table = np.asarray(wavelength_nm, dtype=float), _increasing(table_nm, "table")
    if np.diff(table).min() >= np.diff(grid).max():
        return resample(grid, table_nm=table, table_values=table_values, outside="zero")
    low, high = max(table[0], grid[0]), min(table[-1], grid[-1])
    knots = np.unique(np.concatenate([table, grid]))
    knots = knots[(knots >= low) & (knots <= high)]
    mean = np.zeros_like(grid)
    if knots.size < 2:
        return mean
    power = resample(knots, table_nm=table, table_values=table_values, outside="hold")
    start, end, width = power[:-1], power[1:], np.diff(knots)
    cell = np.clip(np.searchsorted(grid, knots[:-1], side="right") - 1, 0, grid.size - 2)
    share = (np.stack([knots[:-1], knots[1:]]) - grid[cell]) / np.diff(grid)[cell]  # of the cell's upper hat
    upper = width / 6.0 * (start * (2.0 * share[0] + share[1]) + end * (share[0] + 2.0 * share[1]))
    np.add.at(mean, cell + 1, upper)
    np.add.at(mean, cell, np.maximum(width / 2.0 * (start + end) - upper, 0.0))
    return mean / trapezoid_weights_nm(grid)


def planck_spectrum(wavelength_nm: ArrayLike, *, temperature_k: float) -> FloatArray:
    """Relative spectral power per nm of a black body, 1 at 560 nm.

        S = (560/lambda)^5 (exp(c2/(560 T)) - 1) / (exp(c2/(lambda T)) - 1),   c2 = h c / k

    Parameters
    ----------
    wavelength_nm : (...,) [nm], in vacuum
    temperature_k : scalar [K], above 0

    Returns
    -------
    (...,) [1], power per nm relative to that at 560 nm

    Notes
    -----
    Incandescent lamps; a filament's emissivity is left out. CIE illuminant A is T = 2855.5 K with this c2.

    References
    ----------
    CIE 015:2018, definition of illuminant A (scaled to 100 at 560 nm there).
    """
    if not temperature_k > 0:
        raise RangeError(f"temperature of a black body is {temperature_k:g} K; it must be above 0 K")
    wavelength = np.asarray(wavelength_nm, dtype=float)
    c2_nm_k = PLANCK_J_S * LIGHT_SPEED_M_S / BOLTZMANN_J_PER_K * 1e9
    x = c2_nm_k / (wavelength * temperature_k)
    x_reference = c2_nm_k / (PLANCK_REFERENCE_NM * temperature_k)
    # (e^a - 1)/(e^b - 1) as e^(a-b) times factors near 1: no overflow for cold bodies.
    ratio = np.exp(x_reference - x) * np.expm1(-x_reference) / np.expm1(-x)
    return np.asarray((PLANCK_REFERENCE_NM / wavelength) ** 5 * ratio, dtype=float)


def two_gaussian_led(wavelength_nm: ArrayLike) -> FloatArray:
    """Relative spectral power per nm of a generic white LED: a blue line and a broad phosphor band.

        S = 24.49 N(450.70, 11.67) + 119.86 N(565.43, 64.63),   N(mean, sigma) normal densities in nm

    Parameters
    ----------
    wavelength_nm : (...,) [nm]

    Returns
    -------
    (...,) [1/nm], arbitrary scale; the integral over all wavelengths is 144.35

    Notes
    -----
    Valid for phosphor-converted white LEDs; 0.2 % of the power lies beyond 380-780 nm.

    References
    ----------
    Billings, Iscar, Johnson-Roberson (2020), generic LED of the design tool. Physics page, section 1.
    """
    wavelength = np.asarray(wavelength_nm, dtype=float)
    total = np.zeros_like(wavelength)
    for area, mean_nm, sigma_nm in (LED_BLUE, LED_PHOSPHOR):
        density = np.exp(-0.5 * ((wavelength - mean_nm) / sigma_nm) ** 2) / (sigma_nm * np.sqrt(2 * np.pi))
        total = total + area * density
    return total


def _increasing(wavelength_nm: ArrayLike, what: str) -> FloatArray:
    wavelength = np.asarray(wavelength_nm, dtype=float)
    if wavelength.ndim != 1 or wavelength.size < 2 or not (wavelength[1:] > wavelength[:-1]).all():
        raise RangeError(f"the wavelengths of a {what} must be at least two, one row, increasing [nm]")
    return wavelength


def _require_cover(wanted: FloatArray, table: FloatArray) -> None:
    gaps = []
    if wanted.size and wanted.min() < table[0]:
        gaps.append(f"{wanted.min():g}-{table[0]:g} nm")
    if wanted.size and wanted.max() > table[-1]:
        gaps.append(f"{table[-1]:g}-{wanted.max():g} nm")
    if gaps:
        raise RangeError(
            f"wavelengths {' and '.join(gaps)} are outside the table's {table[0]:g}-{table[-1]:g} nm; "
            "extend the table, or choose a rule for outside: hold or zero"
        )
