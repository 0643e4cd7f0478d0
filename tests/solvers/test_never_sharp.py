"""What no f-number shows, against f-numbers tried one by one."""

from __future__ import annotations

import numpy as np
from settings_attack import sharp

from uwopt.forward.sharpness import SharpRows
from uwopt.solvers.exact.never_sharp import blurred

TRIED = 400  # f-numbers a lens


def lenses(rng: np.random.Generator, count: int) -> SharpRows:
    """Lenses that are soft wide open, with image curvature, before pixels of 3.45 um."""
    return SharpRows.joined([
        sharp(place=rng.uniform(0.0, 8.0), rated=rng.uniform(0.0, 1.2), aberration=rng.uniform(0.0, 12.0))
        for _ in range(count)
    ])  # fmt: skip


def test_only_what_no_f_number_shows_is_never_sharp() -> None:
    """Of a quarter of the Nyquist square, and bars of a width on the floor; few that none shows are missed."""
    rng = np.random.default_rng(3)
    rows, factor = lenses(rng, 300), rng.uniform(1.0, 1.1, 300)
    low = np.exp(rng.uniform(np.log(1.4), np.log(8.0), 300))
    high = low * np.exp(rng.uniform(0.0, np.log(8.0), 300)) * rng.choice([1.0, 0.0], 300, p=[0.9, 0.1])
    for asked in (dict(min_mtf=0.35, resolve_m=0.0), dict(min_mtf=0.0, resolve_m=1.5e-3)):
        (bars,) = rows.asked(**asked)
        shown = np.zeros(300, bool)
        for share in np.linspace(0.0, 1.0, TRIED):
            n = low * (np.maximum(high, low) / low) ** share
            left = rows.transfer(bars, f_number=n, working_f_number=n * factor, blur_s=np.zeros(300))
            shown |= left.min(axis=1) >= bars.least * (1.0 - 1e-9)
        never = blurred(rows, bars, factor, low, high)
        assert not (never & shown).any()
        assert 20 < never.sum() < 280 and (~never & ~shown).sum() <= 0.1 * (~shown).sum()
