"""Which pixels of an image may decide its SNR, at whatever settings: few of those that are looked at."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def worst_candidates(signal: Array, veil_there: Array | None) -> Array:
    """Pixels with, for some row and altitude, no other pixel that has less signal and is veiled more.

    Arrays (n, n_altitudes, n_pixels); returns the indices of these pixels. Veiled more: see `decisive_pixels`.
    """
    if veil_there is None:
        return np.unique(signal.argmin(axis=2))
    flat_signal, flat_veiled = (a.reshape(-1, a.shape[2]) for a in (signal, veiled(signal, veil_there)))
    order = np.lexsort((-flat_veiled, flat_signal), axis=1)
    in_order = np.take_along_axis(flat_veiled, order, axis=1)
    before = np.maximum.accumulate(in_order, axis=1)
    leads = np.ones_like(in_order, bool)
    leads[:, 1:] = in_order[:, 1:] > before[:, :-1]
    keep = np.zeros_like(leads)
    np.put_along_axis(keep, order, leads, axis=1)
    return np.nonzero(keep.any(axis=0))[0]


def veiled(signal: Array, veil_there: Array) -> Array:
    """Veil over signal, (...,); inf where no signal is."""
    return np.where(signal > 0.0, veil_there / np.where(signal > 0.0, signal, 1.0), np.inf)


def decisive_pixels(signal: Array, veil_there: Array, may_miss: int) -> tuple[Array, Array]:
    """Pixels (n, n_altitudes, n_pixels) of which one decides what all but k = `may_miss` reach, at any settings.

        SNR^2 = 1 / (F / (s X)^2 + (1 + v/s) / (s X) + (PRNU (1 + v/s))^2),   F: noise without light

    rises with the signal s and falls with its veil v/s, whatever light X, noise and gain are; so does contrast,
    1 / (1 + v/s). Left out are pixels that k + 1 others or more have no more signal and no less v/s than: these come
    first. Rows that keep fewer end with what is easier than any pixel, as does each row, so that its end may be
    repeated.
    """
    shape = signal.shape
    flat, veil = (a.reshape(-1, shape[2]) for a in (signal, veil_there))
    keep = np.empty(flat.shape, bool)
    earlier = np.tri(shape[2], k=-1, dtype=bool)
    for row, (s, v) in enumerate(zip(flat, veiled(flat, veil), strict=True)):
        worse = (s <= s[:, None]) & (v >= v[:, None])
        keep[row] = (worse & (~worse.T | earlier)).sum(axis=1) <= may_miss
    most = int(keep.sum(axis=1).max()) + 1
    order = np.argsort(~keep, axis=1, kind="stable")[:, :most]
    kept = np.take_along_axis(keep, order, axis=1)
    kept[:, -1] = False
    flat, veil = (
        np.where(kept, np.take_along_axis(a, order, axis=1), easiest)
        for a, easiest in ((flat, flat.max(axis=1)[:, None]), (veil, veil.min(axis=1)[:, None]))
    )
    return flat.reshape(*shape[:2], -1), veil.reshape(*shape[:2], -1)
