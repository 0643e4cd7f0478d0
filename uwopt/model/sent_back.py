"""The phase function as light meets it that has turned on its way.

Where the water sends lamp light back, light that was scattered forward before comes aslant, and what it sends is turned
once more on its way to the camera. Both meet the phase function at angles about the one between the straight ways:

    p_w = p - p_0 + sum over l of (2 l + 1) / (4 pi) p_0l exp(t (chi_l - chi_0)) P_l(cos psi)
    chi_l = mean over s from 0 to 1, integral over psi up to 90 deg, of p P_l(cos(psi - alpha))

alpha is where light seems to come from that turns by psi at a share s of its way (`widened`), psi - alpha how much it
comes aslant. p_0 is p but even within 60 deg: what turns by less is not sent back, and stays as it is. Where the
function is hollow its surroundings fill it; an even one stays. No light is lost by it: that is K of backscatter.

t = 2.82 b times the mean way, from the lamp and to the camera, of what evenly lit water sends back once from within d,

    2 d (1 / x - 1 / (e^x - 1)),   x = 2 c d

which is d in clear water and 1 / c in murky water. 2.82 is fitted with the other constants of `multiple`: one turn
alone would have 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.model.image_mean import gauss
from uwopt.model.path_table import product
from uwopt.model.scattering import PhaseTable, look_up
from uwopt.model.widened import ORDERS, WAY_NODES, forward_masses, legendre, seen_from_lamp

EVEN_WITHIN_RAD = np.deg2rad(60.0)
SIDE_NODES = 128  # of the cosine, on either side of that angle
KNOTS = 1024  # of what is turned, even in sin(psi / 2), among the nodes of any table
THIN = 1e-3  # of x, below which its series stands


def mean_way_m(range_m: ArrayLike, lost_per_m: ArrayLike) -> FloatArray:
    """Mean way, there and back, of what evenly lit water sends back from within a range.

        2 d (1 / x - 1 / (e^x - 1)),   x = 2 k d

    Parameters
    ----------
    range_m : broadcasting [m], d; may be as long as is wanted
    lost_per_m : broadcasting [1/m], k, what either leg loses, 0 or more

    Returns
    -------
    (...,) [m], d at most; 1 / k for a long range
    """
    d = np.asarray(range_m, dtype=float)
    x = 2.0 * d * np.asarray(lost_per_m, dtype=float)
    safe = np.maximum(x, THIN)
    with np.errstate(over="ignore"):
        return np.asarray(2.0 * d * np.where(x < THIN, 0.5 - x / 12.0, 1.0 / safe - 1.0 / np.expm1(safe)))


def widened_phase(table: PhaseTable, turned: Sequence[tuple[float, PhaseTable | None]]) -> PhaseTable:
    """A phase function as light meets it that kinds of things in the water have turned.

    Parameters
    ----------
    table : PhaseTable, p
    turned : t of each kind [1], and its own function; None: the water's molecules

    Returns
    -------
    PhaseTable of integral 1, no less than 0; p itself within 60 deg but for what comes there

    Notes
    -----
    Fitted and judged for c d up to 4, good to 20 % up to 8: docs/validation.md, section 10.
    """
    log_gain = np.zeros(ORDERS + 1)
    for thickness, phase in turned:
        aslant = aslant_share(phase)
        log_gain += thickness * (aslant - aslant[0])
    gain = np.exp(log_gain)
    series = _sent_series(table) * (gain - gain[-1])
    halo = product(series[None, :], _at_knots())[0]
    return _not_below_0(_at_nodes(table, gain[-1], halo))


def least_widened_phase(table: PhaseTable, turned: Sequence[tuple[FloatArray, PhaseTable | None]]) -> PhaseTable:
    """At every angle the least of a phase function as light meets it in several waters: a bound of what is sent back.

        p(psi) = min over waters i of p_i(psi),   p_i as of `widened_phase`

    Parameters
    ----------
    table : PhaseTable, p
    turned : t of each kind in each water (n,) [1], and its own function; None: the water's molecules

    Returns
    -------
    PhaseTable, of integral 1 at most
    """
    log_gain = np.zeros((len(turned[0][0]), ORDERS + 1))
    for thickness, phase in turned:
        aslant = aslant_share(phase)
        log_gain += np.multiply.outer(thickness, aslant - aslant[0])
    gain = np.exp(log_gain)
    halos = product(_sent_series(table) * (gain - gain[:, -1:]), _at_knots())
    least = np.full_like(table.phase_per_sr, np.inf)
    for left, halo in zip(gain[:, -1], halos, strict=True):  # one by one: all at once take much memory
        np.minimum(least, _at_nodes(table, left, halo), out=least)
    return _not_below_0(least)


def _at_nodes(table: PhaseTable, left: float, halo: FloatArray) -> FloatArray:
    """What is left of a phase function, at its nodes, and a halo between knots."""
    part = KNOTS / table.n_cell * np.arange(table.n_cell // KNOTS)  # cells between two knots
    between = halo[:-1, None] + np.diff(halo)[:, None] * part
    values = _made_even(table) * (left - 1.0)
    values += table.phase_per_sr
    values[:-2] += between.ravel()
    values[-2:] += halo[-1]
    return values


def _not_below_0(values: FloatArray) -> PhaseTable:
    np.maximum(values, 0.0, out=values)
    values.setflags(write=False)
    return PhaseTable(values)


@lru_cache(maxsize=64)
def aslant_share(phase: PhaseTable | None) -> FloatArray:
    """chi_l for l = 0 to 120 (ORDERS + 1,) [1]: how light comes aslant that this scatters forward on its way."""
    angle, mass = forward_masses(phase)
    share = np.zeros(ORDERS + 1)
    for node, weight in zip(*gauss(WAY_NODES), strict=True):
        apparent, _ = seen_from_lamp(angle, 0.5 * (node + 1.0))
        share += weight * (legendre(np.cos(angle - apparent)) @ mass)
    return share


@lru_cache(maxsize=64)
def _made_even(table: PhaseTable) -> FloatArray:
    """p_0 at the nodes of the table."""
    within = int(np.ceil(np.sin(0.5 * EVEN_WITHIN_RAD) * table.n_cell))
    values = table.phase_per_sr.copy()
    values[:within] = look_up(np.cos(EVEN_WITHIN_RAD), table)
    return np.asarray(values)


@lru_cache(maxsize=64)
def _sent_series(table: PhaseTable) -> FloatArray:
    """(2 l + 1) / (4 pi) p_0l for l = 0 to 120, p_0l the mean of P_l over p_0."""
    node, weight = gauss(SIDE_NODES)
    edge, order = float(np.cos(EVEN_WITHIN_RAD)), np.arange(ORDERS + 1)
    found = np.zeros(ORDERS + 1)
    for low, high in ((-1.0, edge), (edge, 1.0)):
        cos = low + 0.5 * (node + 1.0) * (high - low)
        found += legendre(cos) @ (look_up(np.minimum(cos, edge), table) * weight) * (high - low)
    return np.asarray(0.5 * (2 * order + 1) * found)


@cache
def _at_knots() -> FloatArray:
    """P_l at the knots, (ORDERS + 1, KNOTS + 1)."""
    return legendre(1.0 - 2.0 * np.square(np.arange(KNOTS + 1) / KNOTS))
