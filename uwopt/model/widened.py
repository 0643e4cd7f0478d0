"""A lamp's lobe as light that is scattered on its way from the lamp widens it.

Light that turns by psi at a share s of its way r arrives as if it had left the lamp by (1 - s) psi aside. Of order l of
the lobe's Legendre series arrives, all orders of scattering counted, as in `model.detail` for what is seen,

    I_l exp(-c r + b r chi_l),   chi_l = integral over s from 0 to 1, psi from 0 to 90 deg, of p P_l(cos((1 - s) psi))

Nothing in it is fitted; light that turns by more than 90 deg counts as lost. The lobe stands beside the water's loss of
all that is not turned far, exp(-K r) with K = c - b (1 - s_K) of `model.multiple`, so that what is left over it is

    I_l exp(b r (chi_l - 1 + s_K))

What turns by less than the last order resolves, half a degree, keeps the lamp's own shape, edges included; the rest is
a smooth halo. For light on the floor r is the way to it along the axis; for backscatter, which comes from all along the
way, the lobe goes with the distance from the lamp.

Wells (1969), J. Opt. Soc. Am. 59, 686, for small angles; docs/validation.md, section 10, for all.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from uwopt.model import beam as beams
from uwopt.model.detail import masses_by_angle
from uwopt.model.halo import Widening
from uwopt.model.image_mean import gauss
from uwopt.model.path_table import product
from uwopt.model.phase_formulas import molecular_per_sr
from uwopt.model.scattering import PhaseTable, phase_table_of
from uwopt.model.spectrum import FloatArray

ORDERS = 120
WAY_NODES = 12
PANELS, PANEL_NODES = 20, 16  # over the lobe, for its own series
HALO_CELLS = 1024  # even in sqrt(1 - cos): 0.08 deg at the axis
BACK_ROWS = 49  # of ways, even in their square root
MOST_LOG = 300.0  # of a gain: products of it are numbers


class Turned(NamedTuple):
    """What one kind of thing in the water scatters on the way."""

    thickness: ArrayLike  # b r: one, or of each way (k,)
    lost_share: float  # s_K of the attenuation that the lobe stands beside
    phase: PhaseTable | None  # None: the water's molecules


def ways_m(reach_m: float) -> FloatArray:
    """Ways from the lamp to its reach at which a lobe that widens along them is worked out (BACK_ROWS,) [m]."""
    return reach_m * np.square(np.linspace(0.0, 1.0, BACK_ROWS))


def widened(lobe: beams.Beam, turned: Sequence[Turned], reach_m: float = 0.0) -> beams.Beam:
    """A lobe with what scattering on a way makes of it, over what the attenuation K of that way leaves of it.

        I_w = e^(t_L) I + sum over l of (2 l + 1) / (4 pi) I_l (e^(t_l) - e^(t_L)) P_l(cos theta)
        t_l = sum over kinds of b r (chi_l - 1 + s_K),   I_l = 2 pi integral of I P_l d cos theta,   L = 120

    Parameters
    ----------
    lobe : the lamp's own beam
    turned : kinds of things that scatter, on one way or on each of `ways_m`
    reach_m : the last of those ways

    Returns
    -------
    Beam, its flux that of the lobe times e^(t_0) but for what would go behind the front plane, which counts as lost,
    and for ripples below 0, which are cut

    Notes
    -----
    Valid for lobes and ways of `multiple.TESTED_LOBES_DEG` and up to c r = `multiple.TESTED_THICKNESS`; without limit
    in form. At b r = 0 the lobe is left as it is.
    """
    log_gain = sum(
        np.multiply.outer(np.atleast_1d(one.thickness), carried_share(one.phase) - 1.0 + one.lost_share)
        for one in turned
    )
    gain = np.exp(np.clip(log_gain, -MOST_LOG, MOST_LOG))
    order = np.arange(ORDERS + 1)
    series = (2 * order + 1) / (4.0 * np.pi) * lobe_series(lobe) * (gain - gain[:, -1:])
    return beams.widened_by(lobe, Widening.of(gain[:, -1], product(series, _at_knots()), reach_m))


def bounding(lobes: Sequence[beams.Beam], weights: Sequence[float], *, most: bool) -> beams.Beam:
    """A beam that at every angle and way is no less than any of these, times its weight; or no more than any.

        share = least of w_i share_i,   halo at knots = most of w_i halo_i + (w_i share_i - share) I

    Parameters
    ----------
    lobes : one lamp's beam as several waters widen it, on the same ways
    weights : one each [1]
    most : the greatest, or the least

    Returns
    -------
    Beam; of I the most, or the least, about each knot, so that it is a bound between knots too

    Notes
    -----
    Where a beam ends sharply its halo must not, so that shares and halos are taken apart: valid, less tight.
    """
    lobe, pick = beams.own(lobes[0]), np.max if most else np.min
    made = [one.widening for one in lobes if one.widening is not None]
    shares = np.array([weight * one.share for weight, one in zip(weights, made, strict=True)])
    halos = np.array([weight * one.halo_per_sr for weight, one in zip(weights, made, strict=True)])
    if beams.has_sharp_edge(lobe):
        share = pick(shares, axis=0)
    else:
        share = shares.min(axis=0)
        fine = beams.intensity_per_sr(1.0 - np.square(np.linspace(0.0, 1.0, 8 * HALO_CELLS + 1)), lobe)
        near = np.pad(fine, 8, mode="edge")
        about = pick(np.lib.stride_tricks.sliding_window_view(near, 17)[::8], axis=1)
        halos = halos + (shares - share)[:, :, None] * about
    return beams.widened_by(lobe, Widening.of(share, pick(halos, axis=0), made[0].reach_m, bound=most))


@lru_cache(maxsize=64)
def carried_share(phase: PhaseTable | None) -> FloatArray:
    """chi_l for l = 0 to 120 (ORDERS + 1,) [1], at most the share scattered forward."""
    angle, mass = masses_by_angle(_molecules() if phase is None else phase)
    forward = angle < 0.5 * np.pi
    angle, mass = angle[forward], mass[forward]
    node, weight = gauss(WAY_NODES)
    ways = zip(0.5 * (node + 1.0), weight, strict=True)
    return np.sum([part * (legendre(np.cos((1.0 - s) * angle)) @ mass) for s, part in ways], axis=0)


@lru_cache(maxsize=1024)
def lobe_series(lobe: beams.Beam) -> FloatArray:
    """I_l for l = 0 to 120 (ORDERS + 1,) [1]: of the lobe's flux per lumen, the mean of P_l over it."""
    edge = beams.edge_half_angle_rad(lobe)
    polynomial, ring = _within(edge)
    cos = np.cos(_nodes(edge)[0])
    return np.asarray(polynomial @ (ring * beams.intensity_per_sr(cos, beams.without_edge(lobe))))


@lru_cache(maxsize=16)
def _within(edge_rad: float) -> tuple[FloatArray, FloatArray]:
    """P_l at the nodes of a lobe up to its edge, and the solid angle about each."""
    angle, weight = _nodes(edge_rad)
    return legendre(np.cos(angle)), 2.0 * np.pi * np.sin(angle) * weight


def _nodes(edge_rad: float) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre in panels over angles up to the edge, crowded at the axis with the square."""
    node, weight = gauss(PANEL_NODES)
    share = ((np.arange(PANELS)[:, None] + 0.5 * (node + 1.0)) / PANELS).ravel()
    return edge_rad * np.square(share), 2.0 * edge_rad * share * np.tile(weight / PANELS, PANELS)


@cache
def _at_knots() -> FloatArray:
    """P_l at the halo's knots, (ORDERS + 1, HALO_CELLS + 1)."""
    return legendre(1.0 - np.square(np.linspace(0.0, 1.0, HALO_CELLS + 1)))


@cache
def _molecules() -> PhaseTable:
    return phase_table_of(lambda psi: molecular_per_sr(np.cos(psi)))


def legendre(x: FloatArray) -> FloatArray:
    """P_0 to P_120 (ORDERS + 1, ...), by (n + 1) P_(n+1) = (2 n + 1) x P_n - n P_(n-1)."""
    made = np.empty((ORDERS + 1, *x.shape))
    made[0], made[1] = 1.0, x
    for n in range(1, ORDERS):
        made[n + 1] = ((2 * n + 1) * x * made[n] - n * made[n - 1]) / (n + 1)
    return made
