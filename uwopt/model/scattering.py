"""Where scattered light goes: one look-up table for all phase functions.

Formulas of some are in `phase_formulas`; others come as measured rows. Quadratures of backscatter ask for it millions
of times: `PhaseTable` answers with one square root, one multiplication and one linear interpolation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.errors import RangeError
from uwopt.model.phase_formulas import SEA_WATER_DEPOLARISATION, SMALLEST_ANGLE_RAD

N_CELL = 32768  # of a look-up table: relative error below 1e-5 beyond 5 deg, 256 kB
N_HALVING = 14  # steps from the first node towards 0, where forward peaks are integrated
MAX_FORWARD_POWER = 1.999  # p ~ angle^-2 has no finite integral
CHUNK = 16384  # points looked up at a time, so that intermediate arrays stay in the cache
MAX_NORM_ERROR = 0.02
MIN_LAST_ANGLE_RAD = np.deg2rad(170.0)  # lamps beside a camera scatter back at 150-180 deg


@dataclass(frozen=True, eq=False)
class PhaseTable:
    """A phase function at equal steps of sin(psi/2), from 0 to 1; the last value stands twice."""

    phase_per_sr: FloatArray  # (n_cell + 2,); linear between the nodes
    shares: dict[float, float] = field(
        default_factory=dict, repr=False, compare=False
    )  # by angle, once asked for

    @property
    def n_cell(self) -> int:
        """Number of steps."""
        return self.phase_per_sr.size - 2


def phase_table(angle_rad: ArrayLike, phase_per_sr: ArrayLike) -> PhaseTable:
    """Look-up table of a phase function that is known at some angles.

    Parameters
    ----------
    angle_rad : (n,) [rad], scattering angles, increasing within 0 to pi; the last at least 170 deg
    phase_per_sr : (n,) [sr^-1], above 0; its integral over the sphere must be 0.98 to 1.02

    Returns
    -------
    PhaseTable, scaled so that its integral is 1

    Notes
    -----
    Monotone cubic (PCHIP) in log p against log psi, so that no new peaks arise and nothing has a kink. The
    function is even about 180 deg, as it is for particles in random orientation: flat there, and held from
    the last angle on. Below the first angle it goes on as the power law through the first two; if the first
    is 0, log p is taken as quadratic up to the second. RangeError where the angles or values cannot be those
    of a phase function, or the integral is off by more than 2 %.
    """
    return _normalised(_sampled(angle_rad, phase_per_sr))


def scattering_coefficient_per_m(angle_rad: ArrayLike, vsf_per_m_sr: ArrayLike) -> float:
    """Scattering coefficient b = 2 pi * integral of the volume scattering function * sin psi d psi [1/m].

    Interpolated as in `phase_table`, which takes the same function divided by this b.
    """
    masses, tail = _masses(_sampled(angle_rad, vsf_per_m_sr))
    return 8 * np.pi * (tail + float(np.sum(masses)))


def phase_table_of(function: Callable[[FloatArray], ArrayLike]) -> PhaseTable:
    """Look-up table of a formula p(psi) [sr^-1] that takes an array of scattering angles [rad], 0 excluded.

    The formula is evaluated at the nodes, and on the way to 0 for the integral of its forward peak, which
    must be 0.98 to 1.02 over the sphere, as for `phase_table`.
    """
    phase = np.asarray(function(_sample_angle_rad()), dtype=float)
    if not np.all(np.isfinite(phase) & (phase > 0)):
        raise RangeError("a phase function must be finite and above 0 at every angle above 0 deg")
    return _normalised(phase)


def look_up(cos_angle: ArrayLike, table: PhaseTable) -> Any:
    """Phase function at any scattering angle, from a table.

        x = sin(psi/2) = sqrt((1 - cos psi)/2), then linear in x

    Parameters
    ----------
    cos_angle : (...,) [1], cosine of the scattering angle; round-off beyond -1 and 1 does no harm
    table : PhaseTable

    Returns
    -------
    (...,) [sr^-1]

    Notes
    -----
    Relative error below 1e-5 from 5 to 180 deg, against the formula or the smooth curve through the knots;
    2e-4 from 0.2 deg on, 6e-4 from 0.1 deg on; below 0.0035 deg a finite value that keeps the integral.
    A peak straight back is resolved if it is wider than some 20 deg, as all those of sea water are.
    """
    cosine = np.asarray(cos_angle, dtype=float)
    phase = table.phase_per_sr
    flat, result = cosine.reshape(-1), np.empty(cosine.size)
    for start in range(0, flat.size, CHUNK):
        piece = slice(start, start + CHUNK)
        place = np.subtract(1.0, flat[piece])
        np.abs(place, out=place)
        place *= 0.5 * table.n_cell**2
        np.sqrt(place, out=place)
        cell = place.astype(np.intp)
        place -= cell
        low = phase.take(cell, mode="clip")
        high = phase[1:].take(cell, mode="clip")
        high -= low
        high *= place
        np.add(low, high, out=result[piece])
    return result.reshape(cosine.shape)[()]


def share_beyond(angle_rad: float, table: PhaseTable | None) -> float:
    """Share scattered by more than an angle [1], 0 to pi; without a table, of the molecules' own function.

    Molecules: 3 / (2 (3 + f)) (1 + cos psi + f (1 + cos^3 psi) / 3).
    """
    if table is not None:
        if angle_rad not in table.shares:
            table.shares[angle_rad] = _moment(table, float(np.sin(angle_rad / 2)))
        return table.shares[angle_rad]
    f = (1 - SEA_WATER_DEPOLARISATION) / (1 + SEA_WATER_DEPOLARISATION)
    cos = float(np.cos(angle_rad))
    return 1.5 / (3 + f) * (1 + cos + f * (1 + cos**3) / 3)


def _sample_x() -> FloatArray:
    """sin(psi/2) where a function is sampled: the first node halved again and again, then all nodes but 0."""
    return np.concatenate([0.5 ** np.arange(N_HALVING, 0, -1), np.arange(1, N_CELL + 1)]) / N_CELL


def _sample_angle_rad() -> FloatArray:
    x = _sample_x()
    return np.asarray(2 * np.arctan2(x, np.sqrt((1 - x) * (1 + x))), dtype=float)


def _moment(table: PhaseTable, x_from: float) -> float:
    """Integral of p over the solid angle with sin(psi/2) above x_from: exact for the table."""
    x = np.arange(table.n_cell + 1) / table.n_cell
    edges = np.concatenate([[x_from], x[x > x_from]])
    abscissa, weight = np.polynomial.legendre.leggauss(3)  # exact up to x^5; the integrand has x^4 at most
    half = np.diff(edges) / 2
    at = (edges[:-1] + half)[:, None] + half[:, None] * abscissa
    values = np.interp(at, x, table.phase_per_sr[:-1])
    # d Omega = 2 pi sin psi d psi = 8 pi x dx
    return float(np.sum(8 * np.pi * values * at * weight * half[:, None]))


def _checked_knots(angle_rad: ArrayLike, phase_per_sr: ArrayLike) -> tuple[FloatArray, FloatArray]:
    angle, phase = np.asarray(angle_rad, dtype=float), np.asarray(phase_per_sr, dtype=float)
    if angle.ndim != 1 or angle.size < 4 or angle.shape != phase.shape:
        raise RangeError("a phase function needs four angles or more in one row, and a value for each")
    angle = np.where(np.abs(angle) < SMALLEST_ANGLE_RAD, 0.0, angle)
    if not (np.all(np.diff(angle) > 0) and angle[0] >= 0 and angle[-1] <= np.pi * (1 + 1e-9)):
        raise RangeError("the angles of a phase function must increase within 0 to 180 deg")
    if angle[-1] < MIN_LAST_ANGLE_RAD * (1 - 1e-9):
        raise RangeError(
            f"a phase function ends at {np.rad2deg(angle[-1]):.4g} deg; it must reach 170 deg or more: extend it"
        )
    if not np.all(np.isfinite(phase) & (phase > 0)):
        raise RangeError("the values of a phase function must be finite and above 0")
    return angle, phase


def _forward(at_rad: FloatArray, angle: FloatArray, log_phase: FloatArray) -> FloatArray:
    """log p below the first angle above 0: a power law, or a parabola from the value at 0."""
    if angle[0] == 0:
        return log_phase[0] + (log_phase[1] - log_phase[0]) * (at_rad / angle[1]) ** 2
    power = -(log_phase[1] - log_phase[0]) / np.log(angle[1] / angle[0])
    if power >= MAX_FORWARD_POWER:
        raise RangeError(
            f"the phase function rises like angle^-{power:.3g} towards 0 deg, which has no finite integral; "
            f"add angles below the first, {np.rad2deg(angle[0]):.3g} deg"
        )
    return np.asarray(log_phase[0] - max(power, 0.0) * np.log(at_rad / angle[0]), dtype=float)


def _between(at_rad: FloatArray, angle: FloatArray, log_phase: FloatArray) -> FloatArray:
    """log p from the first angle above 0 on: PCHIP, and over the last interval an even function about pi.

    There log p = log p(pi) + D (a t^2 + (1 - a) t^4), t = (pi - psi)/(pi - psi_last): it meets value and slope
    at psi_last and is monotone for the slopes that PCHIP gives.
    """
    from scipy.interpolate import PchipInterpolator

    if np.pi - angle[-1] < 1e-9:
        angle = np.append(angle[:-1], np.pi)
    else:
        angle, log_phase = np.append(angle, np.pi), np.append(log_phase, log_phase[-1])
    curve = PchipInterpolator(np.log(angle), log_phase)
    value = np.asarray(curve(np.log(at_rad)), dtype=float)
    last_rad = angle[-2]
    span_rad = np.pi - last_rad
    rise = log_phase[-2] - log_phase[-1]
    slope = -float(curve.derivative()(np.log(last_rad))) / last_rad * span_rad  # d log p / d t at t = 1
    t2 = ((np.pi - at_rad) / span_rad) ** 2
    even = log_phase[-1] + (2 * rise - slope / 2) * t2 + (slope / 2 - rise) * t2 * t2
    return np.where(at_rad > last_rad, even, value)


def _normalised(sampled: FloatArray) -> PhaseTable:
    """Table whose integral is 1, from values at `_sample_x`; the value at node 0 is chosen here.

    Chords of a convex curve lie above it. Each cell's surplus, against a power law between its ends, is taken
    off its two nodes: the table then keeps the integral, and its largest error falls to two thirds.
    """
    sample_x = _sample_x()
    sample_mass, tail_mass = _masses(sampled)
    integral = 8 * np.pi * (tail_mass + float(np.sum(sample_mass)))  # d Omega = 8 pi x dx
    if not abs(integral - 1) <= MAX_NORM_ERROR:
        raise RangeError(
            f"the integral of the phase function over the sphere is {integral:.4g}; it must be "
            f"{1 - MAX_NORM_ERROR:g} to {1 + MAX_NORM_ERROR:g}: divide by the scattering coefficient b, "
            "and give angles small enough to hold the forward peak"
        )
    x, phase, mass = sample_x[N_HALVING:], sampled[N_HALVING:], sample_mass[N_HALVING:]
    first_mass = tail_mass + float(np.sum(sample_mass[:N_HALVING]))
    step = x[0]
    left, right = step / 6 * (2 * x[:-1] + x[1:]), step / 6 * (x[:-1] + 2 * x[1:])
    half_surplus = (left * phase[:-1] + right * phase[1:] - mass) / 2
    surplus, weight = np.zeros_like(phase), np.zeros_like(phase)
    surplus[:-1] += half_surplus
    surplus[1:] += half_surplus
    weight[:-1] += left
    weight[1:] += right
    corrected = phase - surplus / weight
    first = 6 * first_mass / step**2 - 2 * corrected[0]
    values = np.concatenate([[first], corrected, corrected[-1:]]) / integral
    values.setflags(write=False)
    return PhaseTable(values)


def _sampled(angle_rad: ArrayLike, values: ArrayLike) -> FloatArray:
    """Values at `_sample_x` of a function known at some angles."""
    angle, phase = _checked_knots(angle_rad, values)
    sample_rad = _sample_angle_rad()
    first = 1 if angle[0] == 0 else 0
    outer = _forward(sample_rad, angle, np.log(phase))
    inner = _between(sample_rad, angle[first:], np.log(phase[first:]))
    return np.asarray(np.exp(np.where(sample_rad < angle[first], outer, inner)), dtype=float)


def _masses(sampled: FloatArray) -> tuple[FloatArray, float]:
    """Integrals of p x dx from sample to sample, and from 0 to the first, p a power law between samples."""
    x = _sample_x()
    forward_power = float(np.clip(np.log2(sampled[0] / sampled[1]), 0.0, MAX_FORWARD_POWER))
    tail = float(sampled[0] * x[0] ** 2 / (2 - forward_power))
    span = np.log(x[1:] / x[:-1])
    exponent = np.log(sampled[1:] / sampled[:-1]) / span + 2
    flat = np.abs(exponent) < 1e-9
    safe = np.where(flat, 1.0, exponent)
    growth = np.where(flat, span, np.expm1(safe * span) / safe)
    return np.asarray(sampled[:-1] * x[:-1] ** 2 * growth, dtype=float), tail
