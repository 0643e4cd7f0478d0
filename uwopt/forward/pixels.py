"""Which pixels of an image may decide its SNR, at whatever settings: few of those that are looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.light_columns import ImageLight, SunLight

AT_ONCE = 2**16  # pixels of some rows, that stay in the processor's cache
SPARE = 60  # pixels that others are compared with, beside those that may miss an SNR


def worst_candidates(signal: Array, veil_there: Array | None) -> Array:
    """Pixels with, for some row and altitude, no other pixel that has less signal and more veil.

    Arrays (n, n_altitudes, n_pixels); returns the indices of these pixels.
    """
    if veil_there is None:
        return np.unique(signal.argmin(axis=2))
    flat_signal, flat_veil = (a.reshape(-1, a.shape[2]) for a in (signal, veil_there))
    order = np.lexsort((-flat_veil, flat_signal), axis=1)
    sorted_veil = np.take_along_axis(flat_veil, order, axis=1)
    before = np.maximum.accumulate(sorted_veil, axis=1)
    leads = np.ones_like(sorted_veil, bool)
    leads[:, 1:] = sorted_veil[:, 1:] > before[:, :-1]
    keep = np.zeros_like(leads)
    np.put_along_axis(keep, order, leads, axis=1)
    return np.nonzero(keep.any(axis=0))[0]


def decisive_pixels(signal: Array, veil_there: Array, may_miss: int) -> tuple[Array, Array]:
    """Pixels (n, n_altitudes, n_pixels) of which one decides what all but k = `may_miss` reach, at any settings.

    Left out are those that k + 1 others or more have no more signal and no less veil than: these come first. Rows that
    keep fewer end with what is easier than any pixel, as does each row, so that its end may be repeated.
    """
    shape = signal.shape
    flat, veil = (a.reshape(-1, shape[2]) for a in (signal, veil_there))
    keep = np.empty(flat.shape, bool)
    earlier = np.tri(shape[2], k=-1, dtype=bool)
    for row, (s, v) in enumerate(zip(flat, veil, strict=True)):
        worse = (s <= s[:, None]) & (v >= v[:, None])
        keep[row] = (worse & (~worse.T | earlier)).sum(axis=1) <= may_miss
    most = int(keep.sum(axis=1).max()) + 1
    order = np.argsort(~keep, axis=1, kind="stable")
    order = np.concatenate([order, order[:, -1:]], axis=1)[:, :most]
    kept = np.take_along_axis(keep, order, axis=1)
    kept[:, -1] = False
    flat, veil = (
        np.where(kept, np.take_along_axis(a, order, axis=1), easiest)
        for a, easiest in ((flat, flat.max(axis=1)[:, None]), (veil, veil.min(axis=1)[:, None]))
    )
    return flat.reshape(*shape[:2], -1), veil.reshape(*shape[:2], -1)


def fewest_pixels(
    sources: Sequence[tuple[Array, Array]], may_miss: int, *, unlit: Sequence[tuple[Array, Array]] = ()
) -> list[tuple[Array, Array]]:
    """Pixels of which one decides what all but k = `may_miss` reach in SNR and contrast, however sources are mixed.

        SNR = s / sqrt(F + a + (PRNU a)^2),   a = s + v,   s = sum of X_m s_m,   v = sum of X_m v_m,   X_m >= 0

    rises with s and falls with v/s, and so does contrast, s/a. Pixel i is never worse than pixel j if for all sources

        s_im >= s_jm,   v_im s_jn + v_in s_jm <= v_jm s_in + v_jn s_im

    Left out are pixels that are never worse than k + 1 others or more.

    Parameters
    ----------
    sources : signal and veil, (n, n_altitudes, n_pixels) each, of the lamps and perhaps of the sun
    may_miss : scalar
    unlit : likewise, of sources that give next to nothing, so that they decide nothing

    Returns
    -------
    The same, these last, with fewer pixels, each row's first. Rows that keep fewer end with what is easier than any.

    Notes
    -----
    Exact but for the rounding of products. Each pixel is compared with some of the worst ones, not with all: what is
    left out is left out for good reason, what stays may be one too many. `decisive_pixels` keeps more, by signal and
    veil alone: among them the veil's mean tells how an image changes with the water.
    """
    shape = sources[0][0].shape
    flat = [tuple(np.ascontiguousarray(part).reshape(-1, shape[2]) for part in s) for s in (*sources, *unlit)]
    step = max(1, AT_ONCE // shape[2])
    keep = np.concatenate(
        [
            _may_decide([(s[at : at + step], v[at : at + step]) for s, v in flat[: len(sources)]], may_miss)
            for at in range(0, len(flat[0][0]), step)
        ]
    )
    most = min(int(keep.sum(axis=1).max()) + 1, shape[2])
    order = np.argsort(~keep, axis=1, kind="stable")[:, :most]
    kept = np.take_along_axis(keep, order, axis=1)

    def few(column: Array, easiest: Array) -> Array:
        return np.where(kept, np.take_along_axis(column, order, axis=1), easiest[:, None]).reshape(*shape[:2], -1)

    return [(few(s, s.max(axis=1)), few(v, v.min(axis=1))) for s, v in flat]


def _may_decide(sources: Sequence[tuple[Array, Array]], may_miss: int) -> Array:
    """Which pixels (n, n_pixels) are no worse than at most k of those that look worse, of which some are looked at.

    Most are no worse than any of the k + 1 that look worst: only the others are compared with more.
    """
    columns: list[Array] = []
    bright: Array = np.ones(sources[0][0].shape)  # s^2 / a of all sources: greater of what is never worse
    for s, v in sources:
        largest = np.maximum(np.maximum(s, v).max(axis=1), 1e-300)[:, None]  # products neither vanish nor overflow
        columns += [s / largest, v / largest]
        signal = columns[-2]
        bright *= signal * (signal / np.maximum(signal + columns[-1], 1e-300))
    order = np.argsort(bright, axis=1, kind="stable")
    columns = [np.take_along_axis(column, order, axis=1) for column in columns]
    keep = ~_surely_no_worse(columns, may_miss + 1)
    keep[:, : may_miss + 1] = True
    some = _first(keep)
    few = [np.take_along_axis(column, some, axis=1) for column in columns]
    harder: Array = np.zeros(some.shape, int)
    for j in range(min(may_miss + 1 + SPARE, int(some.max()))):  # those that come later have no more to leave out
        if j == may_miss + 1 < some.shape[1]:  # most are no worse than any of these: no more is asked of them
            still = _first(harder <= may_miss)
            some, harder, *few = (np.take_along_axis(column, still, axis=1) for column in (some, harder, *few))
        harder += _never_worse(few, [column[:, j, None] for column in columns]) & (some > j)
    may = np.take_along_axis(keep, some, axis=1) & (harder <= may_miss)
    kept = np.zeros(order.shape, bool)
    np.put_along_axis(kept, np.take_along_axis(order, some, axis=1), may, axis=1)
    return kept


def _first(wanted: Array) -> Array:
    """The places (n, most) of what is wanted in each row, (n, n_pixels), and of others where there is less of it."""
    return np.argsort(~wanted, axis=1, kind="stable")[:, : int(wanted.sum(axis=1).max())]


def _surely_no_worse(columns: Sequence[Array], first: int) -> Array:
    """Whether pixels are never worse than any of the first, told by these' most signal and least share of veil."""
    found: Array = np.ones(columns[0].shape, bool)
    most, least = np.zeros(found.shape), np.full((len(found), 1), np.inf)
    for s, v in zip(columns[::2], columns[1::2], strict=True):
        found &= s >= s[:, :first].max(axis=1, keepdims=True)
        veiled = v / np.maximum(s, 1e-300)
        most, least = np.maximum(most, veiled), np.minimum(least, veiled[:, :first].min(axis=1, keepdims=True))
    return found & (most <= least)


def _never_worse(mine: Sequence[Array], theirs: Sequence[Array]) -> Array:
    """Whether pixels are never worse than others: signal and veil of each source, broadcasting."""
    found: Array = np.ones(mine[0].shape, bool)
    for s_i, s_j in zip(mine[::2], theirs[::2], strict=True):
        found &= s_i >= s_j
    pairs = list(zip(mine[::2], mine[1::2], theirs[::2], theirs[1::2], strict=True))
    for (s_im, v_im, s_jm, v_jm), (s_in, v_in, s_jn, v_jn) in combinations_with_replacement(pairs, 2):
        found &= v_im * s_jn + v_in * s_jm <= v_jm * s_in + v_jn * s_im
    return found


def at_fewest_pixels(light: ImageLight, sun: SunLight | None) -> tuple[ImageLight, SunLight | None]:
    """The same light at those pixels alone that may decide: figures of many settings look at no others."""
    worst = light.worst_e
    if worst is None or worst.shape[2] <= light.may_miss + 1:
        return light, sun
    veil = light.worst_veil_e
    sources = [(worst, np.zeros_like(worst) if veil is None else veil)]
    shining = None if sun is None else sun.worst_e_s
    if sun is not None and shining is not None:
        over = sun.worst_veil_e_s
        sources += [(shining, np.zeros_like(shining) if over is None else over)]
    (worst_e, worst_veil_e), *others = fewest_pixels(sources, light.may_miss)
    light = replace(light, worst_e=worst_e, worst_veil_e=None if veil is None else worst_veil_e)
    for at_sun, over_sun in others:
        assert sun is not None
        kept = None if sun.worst_veil_e_s is None else over_sun
        sun = replace(sun, worst_e_s=at_sun, worst_veil_e_s=kept)
    return light, sun
