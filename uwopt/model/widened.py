"""A lamp's lobe as light that is scattered on its way from the lamp widens it.

Light that turns by psi at a share s of its way r to a floor square to it arrives as if it had left the lamp by alpha
aside, on a way that is longer by r e than straight there, and so absorbed more:

    tan(alpha) = (1 - s) tan(psi),   e = s + (1 - s) / cos(psi) - 1 / cos(alpha)

Of order l of the lobe's Legendre series arrives, all orders of scattering counted, as in `model.detail` for what is
seen,

    I_l exp(-c r + b r chi_l),   chi_l = mean over s, integral over psi up to 90 deg, of p P_l(cos alpha) exp(-a r e)

Light that turns by more than 90 deg is lost to this. What of it turns again, or comes back from floor and water, is
that of two streams, and falls from all about (`multiple.returned_gain`, a lobe cos^2). Nothing in it is fitted. The
lobe stands beside the water's loss of all that is not turned far, exp(-K r) with K = c - b (1 - s_K) of
`model.multiple`, so that what is left over it is

    I_l exp(b r (chi_l - 1 + s_K))

What turns by less than the last order resolves, half a degree, keeps the lamp's own shape, edges included; the rest is
a smooth halo. For light on the floor r is the way straight to it, whatever the lamp's tilt. Backscatter comes from all
along the way, and there the lobe goes with the distance from the lamp: a place is a point of a sphere about it,

    w = sqrt(1 - s^2 sin^2(psi)) - s cos(psi),   sin(alpha) = w sin(psi),   e = s + w - 1

What the water sends back is turned on its way to the camera, too. By the rule that light's ways may be walked in either
sense this widens what a pixel looks at as it does the lobe, once more along a way of about that length, and moves light
without a loss that K of backscatter would not have:

    I_l exp(b r (2 chi_l - chi_0 - 1 + s_K))

Wells (1969), J. Opt. Soc. Am. 59, 686, for small angles; docs/validation.md, section 10, for all.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.model import beam as beams
from uwopt.model.detail import masses_by_angle
from uwopt.model.halo import Widening
from uwopt.model.image_mean import gauss
from uwopt.model.path_table import product
from uwopt.model.phase_formulas import molecular_per_sr
from uwopt.model.scattering import PhaseTable, phase_table_of, share_beyond

ORDERS = 120
WAY_NODES = 12
THICK_NODES = 64  # of a r
PANELS, PANEL_NODES = 20, 16  # over the lobe, for its own series
HALO_CELLS = 1024  # even in sqrt(1 - cos): 0.08 deg at the axis
BACK_ROWS = 49  # of ways, even in their square root
NO_LIGHT = 1e-12  # of a halo's peak: as much as all orders together that are left out of a bound
MOST_LOG = 300.0  # of a gain: products of it are numbers


class Turned(NamedTuple):
    """What one kind of thing in the water scatters on the way."""

    thickness: ArrayLike  # b r: one, or of each way (k,)
    lost_share: float  # s_K of the attenuation that the lobe stands beside
    phase: PhaseTable | None  # None: the water's molecules


def ways_m(reach_m: float) -> FloatArray:
    """Ways from the lamp to its reach at which a lobe that widens along them is worked out (BACK_ROWS,) [m]."""
    return reach_m * np.square(np.linspace(0.0, 1.0, BACK_ROWS))


def widened(
    lobe: beams.Beam, turned: Sequence[Turned], reach_m: float = 0.0, *, absorbed: ArrayLike = 0.0,
    returned: ArrayLike = 1.0, sent_back: bool = False,
) -> beams.Beam:  # fmt: skip
    """A lobe with what scattering on a way makes of it, over what K of that way leaves of it.

        I_w = e^(t_L) I + sum over l of (2 l + 1) / (4 pi) I_l (g_l - g_L) P_l(cos theta)
        g_l = e^(t_l) + (G - 1) e^(t_0) kappa_l,   kappa_l = integral from 0 to 1 of 3 mu^2 P_l(mu) d mu
        t_l = sum over kinds of b r (chi_l - 1 + s_K),   I_l = 2 pi integral of I P_l d cos theta,   L = 120

    Parameters
    ----------
    lobe : the lamp's own beam
    turned : kinds of things that scatter, on one way or on each of `ways_m`
    reach_m : the last of those ways
    absorbed : a r, one, or of each way (k,)
    returned : G, all light there over that which never turned back, one, or of each way (k,); see
        `multiple.returned_gain`
    sent_back : of backscatter, widened on both its legs; else of light on a floor

    Returns
    -------
    Beam, its flux that of the lobe times g_0 but for what would go behind the front plane, which counts as lost, and
    for ripples below 0, which are cut

    Notes
    -----
    Valid for lobes and ways of `multiple.TESTED_LOBES_DEG` and up to c r = `multiple.TESTED_THICKNESS`; without limit
    in form. At b r = 0 the lobe is left as it is.
    """
    share, series = _of_orders(slice(None), lobe, turned, absorbed, returned, sent_back=sent_back)
    return beams.widened_by(lobe, Widening.of(share, product(series, _at_knots()), reach_m))


def bounding(
    lobe: beams.Beam, turned: Sequence[Turned], reach_m: float = 0.0, *, absorbed: ArrayLike = 0.0,
    returned: ArrayLike = 1.0, sent_back: bool = False, weights: Sequence[float], most: bool,
) -> beams.Beam:  # fmt: skip
    """A beam that at every angle and way is no less than what several waters make of a lobe, each times its weight.

        share = least of w_i share_i,   halo at knots = most of w_i halo_i + (w_i share_i - share) I

    Parameters
    ----------
    turned, reach_m, absorbed, returned, sent_back : as of `widened`, the k ways of one water after those of the other,
        (waters k,)
    weights : of each water (waters,) [1]
    most : no less than any; or no more

    Returns
    -------
    Beam; of I the most, or the least, about each knot, so that it is a bound between knots too

    Notes
    -----
    Where a beam ends sharply its halo must not, so that shares and halos are taken apart: valid, less tight. Orders
    that a lobe has next to nothing of are left out, see `NO_LIGHT`.
    """
    orders, pick = _orders_of(lobe), np.maximum if most else np.minimum
    own, series = _of_orders(orders, lobe, turned, absorbed, returned, sent_back=sent_back)
    series, at_knots = series[:, :-1], np.ascontiguousarray(_at_knots()[orders[:-1]].T)  # of the last nothing is left
    weight = np.asarray(weights, dtype=float)
    each, own = series.reshape(len(weight), -1, series.shape[1]), own.reshape(len(weight), -1) * weight[:, None]
    share, about = own.min(axis=0), np.zeros(())
    if beams.has_sharp_edge(lobe):
        share = pick.reduce(own, axis=0)
    else:
        fine = beams.intensity_per_sr(1.0 - np.square(np.linspace(0.0, 1.0, 8 * HALO_CELLS + 1)), lobe)
        near = np.pad(fine, 8, mode="edge")
        about = pick.reduce(np.lib.stride_tricks.sliding_window_view(near, 17)[::8], axis=1)
    halo: FloatArray = np.array(-np.inf if most else np.inf)
    for factor, row, beside in zip(weight, each, own - share, strict=True):  # one by one: all take much memory
        there = np.maximum(product(at_knots, factor * row.T), 0.0)  # (knots, ways)
        there[-1] = 0.0
        if about.ndim:
            there += np.multiply.outer(about, beside)
        halo = pick(halo, there)
    return beams.widened_by(lobe, Widening.of(share, np.ascontiguousarray(halo.T), reach_m, bound=most))


def _orders_of(lobe: beams.Beam) -> Any:
    """The orders of a lobe, all but those that `NO_LIGHT` leaves out, and the last."""
    size = (2 * np.arange(ORDERS) + 1) * np.abs(lobe_series(lobe)[:-1])
    rising = np.argsort(size)
    some = np.cumsum(size[rising]) > NO_LIGHT * size[0]
    return np.append(np.sort(rising[some]), ORDERS)


def _of_orders(
    orders: Any, lobe: beams.Beam, turned: Sequence[Turned], absorbed: ArrayLike, returned: ArrayLike, *,
    sent_back: bool,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """What keeps the lobe's shape on each way (n,), and the halo's series of these orders, the last of all among them.

    See `widened`.
    """
    order, log_gain = np.arange(ORDERS + 1)[orders], np.zeros(())
    for one in turned:
        carried = carried_share(one.phase, absorbed, sent_back=sent_back, orders=orders)
        if sent_back:
            carried = 2.0 * carried - carried[:, :1]
        log_gain = log_gain + np.atleast_1d(one.thickness)[:, None] * (carried - 1.0 + one.lost_share)
    gain = np.exp(np.clip(log_gain, -MOST_LOG, MOST_LOG))
    gain = gain + (np.atleast_1d(returned)[:, None] - 1.0) * gain[:, :1] * _from_all_about()[order]
    return gain[:, -1], (2 * order + 1) / (4.0 * np.pi) * lobe_series(lobe)[order] * (gain - gain[:, -1:])


def carried_share(
    phase: PhaseTable | None, absorbed: ArrayLike = 0.0, *, sent_back: bool = False, orders: Any = slice(None)
) -> FloatArray:
    """chi_l for l = 0 to 120, or of these orders, at each a r (k, n) [1], at most the share scattered forward.

    By a polynomial in y / (1 + y), y = sqrt(a r), within 2e-5 up to a r = 30.
    """
    return _at_thickness(_carried(phase, sent_back)[:, orders], absorbed)


@lru_cache(maxsize=64)
def _carried(phase: PhaseTable | None, sent_back: bool) -> FloatArray:
    """chi_l as Chebyshev's series of thickness: (THICK_NODES, ORDERS + 1)."""
    angle, mass = forward_masses(phase)
    there = np.zeros((THICK_NODES, ORDERS + 1))
    for polynomial, detour, part in _turns(angle.tobytes(), sent_back):
        there += part * product(np.exp(-np.multiply.outer(_thicknesses(), detour)) * mass, polynomial)
    return _series_of_thickness(there)


def arriving_share(phase: PhaseTable | None, absorbed: ArrayLike, *, within_rad: float) -> FloatArray:
    """Share of what is scattered on a way that still arrives at its end, square to it, wherever.

        integral over s from 0 to 1, psi from 0 to the angle, of p e^(-a r e)

    Parameters
    ----------
    absorbed : (k,) [1], a r
    within_rad : scalar [rad], from which light counts as lost, below 90 deg

    Returns
    -------
    (k,) [1], at most the share scattered by less than that angle, which it is at a r = 0

    Notes
    -----
    By a polynomial in y / (1 + y), y = sqrt(a r), within 1e-7 of the sum over bins of angle up to a r = 36, which is
    within 1e-3 of the integral.
    """
    return _at_thickness(_arriving(phase, within_rad), absorbed)


@lru_cache(maxsize=64)
def _arriving(phase: PhaseTable | None, within_rad: float) -> FloatArray:
    """What arrives as Chebyshev's series of thickness (THICK_NODES,)."""
    angle, mass = forward_masses(phase)
    mass = np.where(angle < within_rad, mass, 0.0)
    kept = sum(
        part * (np.exp(-np.multiply.outer(_thicknesses(), detour)) @ mass)
        for _, detour, part in _turns(angle.tobytes(), False)
    )
    within = 1.0 - share_beyond(within_rad, phase)  # bins of angle do not end there
    return _series_of_thickness(np.asarray(within * kept / mass.sum()))


@cache
def _thicknesses() -> FloatArray:
    """Ways a r at which what depends on them is worked out, (y - 1) / (y + 1) of y = sqrt(a r) Chebyshev's nodes."""
    node = _chebyshev_nodes()
    return np.square((1.0 + node) / (1.0 - node))


@cache
def _chebyshev_nodes() -> FloatArray:
    return np.cos(np.pi * (np.arange(THICK_NODES) + 0.5) / THICK_NODES)


def _series_of_thickness(there: FloatArray) -> FloatArray:
    """Chebyshev's series of what is known at `_thicknesses`, along its first axis."""
    series = chebvander(_chebyshev_nodes(), THICK_NODES - 1).T @ there * (2.0 / THICK_NODES)
    series[0] *= 0.5
    return np.asarray(series)


def _at_thickness(series: FloatArray, absorbed: ArrayLike) -> FloatArray:
    root = np.sqrt(np.atleast_1d(np.asarray(absorbed, dtype=float)))
    return np.asarray(chebyshev_rows((root - 1.0) / (root + 1.0), THICK_NODES).T @ series)


def chebyshev_rows(x: FloatArray, count: int) -> FloatArray:
    """Chebyshev's polynomials T_0 to T_(count - 1), at least two, at x (n,) from -1 to 1: (count, n).

        T_(m + j) = 2 T_m T_j - T_(m - j),   j = 1 to m: twice as many at each step

    As NumPy's `chebvander`, which takes a step each; to 1e-13.
    """
    rows = np.empty((count, x.size))
    rows[0], rows[1] = 1.0, x
    last = 1
    while last < count - 1:
        more = min(last, count - 1 - last)
        new = rows[last + 1 : last + 1 + more]
        np.multiply(rows[1 : more + 1], 2.0 * rows[last], out=new)
        new -= rows[last - more : last][::-1]
        last += more
    return rows


@lru_cache(maxsize=64)
def forward_masses(phase: PhaseTable | None) -> tuple[FloatArray, FloatArray]:
    """Scattering angles below 90 deg, and the share scattered about each."""
    angle, mass = masses_by_angle(_molecules() if phase is None else phase)
    forward = angle < 0.5 * np.pi
    return angle[forward], mass[forward]


@lru_cache(maxsize=4)
def _turns(angles: bytes, sent_back: bool) -> list[tuple[FloatArray, FloatArray, float]]:
    """Of turns by these angles (n,) at nodes of the way: P_l(cos alpha) (n, ORDERS + 1), e (n,), weight of the node."""
    angle, found = np.frombuffer(angles), []
    for node, weight in zip(*gauss(WAY_NODES), strict=True):
        s = 0.5 * (node + 1.0)
        if sent_back:
            apparent, rest = seen_from_lamp(angle, s)
            detour = s + rest - 1.0
        else:
            apparent = np.arctan((1.0 - s) * np.tan(angle))
            detour = s + (1.0 - s) / np.cos(angle) - 1.0 / np.cos(apparent)
        found.append((np.ascontiguousarray(legendre(np.cos(apparent)).T), np.maximum(detour, 0.0), float(weight)))
    return found


def seen_from_lamp(angle_rad: FloatArray, share: float) -> tuple[FloatArray, FloatArray]:
    """alpha [rad] and w [1] of light that turns by these angles (n,) at a share of a way about the lamp (n,)."""
    rest = np.sqrt(1.0 - np.square(share * np.sin(angle_rad))) - share * np.cos(angle_rad)
    return np.arcsin(np.minimum(rest * np.sin(angle_rad), 1.0)), rest


@cache
def _from_all_about() -> FloatArray:
    """kappa_l, for l = 0 to 120: light that comes back is spread as cos^2 about the axis."""
    node, weight = gauss(ORDERS)
    mu = 0.5 * (node + 1.0)
    return np.asarray(legendre(mu) @ (3.0 * np.square(mu) * weight))


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
