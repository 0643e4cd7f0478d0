"""Detail that light scattered nearly forward still carries: Wells' small-angle transfer.

Light that turns by little on its way from the floor counts as a veil, for it does not arrive where it belongs; but
what comes from near by still shows detail that is coarse enough. Of a floor whose brightness varies with f cycles per
radian of the line of sight arrives, over a path r,

    exp(-c r) exp(b r chi(f)),   chi = integral over s from 0 to 1 of the Hankel transform of p at 2 pi f s

c and b of the water, p its phase function. exp(-c r) is the image-forming light, so that exp(b r chi) is what detail
has beside it. The mean of all light is not touched: that factor belongs to what varies, the veil to what is even.

Wells (1969), J. Opt. Soc. Am. 59, 686; (1973) in Optics of the Sea, AGARD Lecture Series 61, 4.1; as Hou, Lee and
Weidemann (2007), Opt. Express 15, 2791, use it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.model.scattering import PhaseTable

FREQUENCIES = np.geomspace(0.1, 1e6, 127)  # cycles per radian, 18 a decade; held at both ends
BINS = 400  # of scattering angles, even in their logarithm
MOST_TABLES = 32  # of kinds of particles that are kept; 2 kB each
MOST_LOG = 300.0  # of a gain: its square is a number; where it is more, nothing is left to gain on
LARGE, NODES, KERNEL_STEP = 40.0, 64, 0.02  # argument from which the kernel is its asymptotic form; below, a table


@dataclass(frozen=True, eq=False)
class DetailTable:
    """chi of a phase function: the share of what is scattered in which detail still shows."""

    log_cyc_per_rad: FloatArray  # (m,) rising
    share: FloatArray  # (m,) falling, 0 to 1


@lru_cache(maxsize=MOST_TABLES)
def detail_table(table: PhaseTable) -> DetailTable:
    """chi(f) of a phase function, worked out once.

        chi = 2 pi integral of p(psi) g(2 pi f psi) sin psi d psi,   g(y) = (1/y) integral from 0 to y of J0

    Parameters
    ----------
    table : PhaseTable, of particles; below its first node, 0.0035 deg, it holds p even

    Returns
    -------
    DetailTable, f 0.1 to 1e6 cycles per radian; its least value so far where the transform comes back

    Notes
    -----
    Relative error 1e-3 up to 3000 cycles per radian. Small angles: of light that turns by much no detail is left, so
    it does not matter that y counts the angle and not its tangent. Prudent beyond: the pole of a Fournier-Forand
    function within 0.0035 deg would carry more.
    """
    angle, mass = masses_by_angle(table)
    kernel = _kernel(2.0 * np.pi * FREQUENCIES[:, None] * angle)
    share = np.clip(np.minimum.accumulate(kernel @ mass), 0.0, 1.0)
    return DetailTable(np.log(FREQUENCIES), share)


def detail_share(cycles_per_rad: ArrayLike, *, table: DetailTable) -> FloatArray:
    """chi at a frequency (...,) [cycles per radian of the line of sight in water], 0 to 1, falling."""
    frequency = np.maximum(np.asarray(cycles_per_rad, dtype=float), FREQUENCIES[0])
    return np.asarray(np.interp(np.log(frequency), table.log_cyc_per_rad, table.share))


def detail_gain(cycles_per_rad: ArrayLike, *, scattered: ArrayLike, table: DetailTable) -> FloatArray:
    """What detail has in all light over what the image-forming light alone has of it.

        F = exp(b r chi(f))

    Parameters
    ----------
    cycles_per_rad : (...,), f, of the line of sight in water
    scattered : broadcasting [1], b r, of what the table's particles scatter on the way from the floor

    Returns
    -------
    (...,) [1], 1 or more; falls with f. Times C MTF it is the contrast of detail in all light that arrives.

    Notes
    -----
    All orders of small turns. Light is taken to fall evenly on the surroundings that it comes from: within 2 degrees of
    the place for f above 10 cycles per radian.
    """
    log_gain = np.asarray(scattered, dtype=float) * detail_share(cycles_per_rad, table=table)
    return np.asarray(np.exp(np.minimum(log_gain, MOST_LOG)))


def masses_by_angle(table: PhaseTable) -> tuple[FloatArray, FloatArray]:
    """Scattering angles (BINS + 1,) and the share scattered about each: d Omega = 8 pi x dx, x = sin(psi / 2)."""
    n, phase = table.n_cell, table.phase_per_sr[:-1]
    x = np.arange(n + 1) / n
    step = 1.0 / n
    cell = 8 * np.pi * step / 6 * (phase[:-1] * (2 * x[:-1] + x[1:]) + phase[1:] * (x[:-1] + 2 * x[1:]))
    within = np.r_[0.0, np.cumsum(cell)]
    edges = np.r_[np.linspace(0.0, 1.0, 9)[:-1] * step, np.geomspace(step, 1.0, BINS - 7)]
    edges = np.sort(np.append(edges, np.sqrt(0.5)))  # 90 deg: forward or back
    in_first = within[1] * np.square(edges / step)  # p even there
    at_edge = np.where(edges < step, in_first, np.interp(edges, x, within))
    middle = np.sqrt(0.5 * (np.square(edges[1:]) + np.square(edges[:-1])))
    return 2.0 * np.arcsin(middle), np.diff(at_edge)


def _kernel(y: FloatArray) -> FloatArray:
    """g(y) = (1/y) integral from 0 to y of J0: from a table, or as 1 + sqrt(2/(pi y)) sin(y - pi/4) over y."""
    known, value = _kernel_table()
    far = np.maximum(y, LARGE)
    beyond = (1.0 + np.sqrt(2.0 / (np.pi * far)) * np.sin(far - np.pi / 4.0)) / far
    return np.where(y < LARGE, np.interp(y, known, value), beyond)


@cache
def _kernel_table() -> tuple[FloatArray, FloatArray]:
    """g by (1/pi) integral from 0 to pi of sin(y sin t) / (y sin t) dt: periodic, so the midpoint rule is exact."""
    y = np.arange(0.0, LARGE + 2 * KERNEL_STEP, KERNEL_STEP)
    sine = np.sin((np.arange(NODES) + 0.5) * np.pi / NODES)
    return y, np.mean(np.sinc(y[:, None] * sine / np.pi), axis=1)
