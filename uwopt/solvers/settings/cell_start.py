"""Where settings of best information are likely: a few places of each design by a stand-in that is cheap.

The tangent of a concave logarithm bounds a whole box closely only near its top. A stand-in finds the top to a
few percent before anything is integrated, so that most boxes are settled by their first bound.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from itertools import product

import numpy as np

from uwopt.arrays import Array

Cheap = Callable[[Array, Array], tuple[Array, Array]]
SHARES = np.linspace(0.0, 1.0, 16)  # of the range of ln f-number, at the longest times
BESIDE, SHORTER = (-0.08, 0.0, 0.08), (-0.8, -0.4, -0.15, 0.0)  # then of ln f-number and ln time from the best of those


def likely_settings(n: int, design: Array, lo: Array, hi: Array, f_dims: Collection[int], cheap: Cheap) -> Array:
    """Logarithms of settings at which n designs look best, (n, n_dims); nan where no tried settings fit.

    design, lo, hi : boxes (m,), (m, n_dims) of the designs; f_dims : which numbers are f-numbers, the others times
    cheap : of places (k,), (k, n_dims) which fit, and the stand-in there, less being better
    """
    low, high = np.full((n, lo.shape[1]), np.inf), np.full((n, lo.shape[1]), -np.inf)
    np.minimum.at(low, design, lo)
    np.maximum.at(high, design, hi)
    some = np.unique(design)
    low, high = low[some], high[some]
    lens = np.isin(np.arange(lo.shape[1]), list(f_dims))
    at_longest = low + np.where(lens, SHARES[:, None], 1.0)[:, None, :] * (high - low)
    first = _best_of(some, at_longest, cheap)
    steps = np.array([np.where(lens, beside, shorter) for beside, shorter in product(BESIDE, SHORTER)])
    out = np.full((n, lo.shape[1]), np.nan)
    out[some] = _best_of(some, np.clip(first + steps[:, None, :], low, high), cheap)
    return out


def _best_of(design: Array, places: Array, cheap: Cheap) -> Array:
    """The best of some places (k, m, n_dims) of each design, (m, n_dims)."""
    k, m, n_dims = places.shape
    which, seen = cheap(np.tile(design, k), places.reshape(k * m, n_dims))
    value = np.full(k * m, np.inf)
    value[which] = seen
    value = value.reshape(k, m)
    found = places[value.argmin(axis=0), np.arange(m)]
    return np.where(np.isfinite(value.min(axis=0))[:, None], found, np.nan)
