"""How long an image may move while the bars that are asked for still arrive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.bars import StillBars
from uwopt.forward.scene_rows import SceneRows
from uwopt.model.sharpness import sinc_mtf

_RATIO = (
    np.sin(np.linspace(0.0, np.pi / 2.0, 20_001)) ** 2
)  # of a frequency over the first null, dense at both ends
_BOX = sinc_mtf(_RATIO)
_TABLE_ERROR = 1e-7


def longest_sharp_s(
    every: Sequence[StillBars], rows: Array, n_low: Array, n_high: Array, *, working_factor: Array, contrast: Array,
    safe: bool,
) -> Array:  # fmt: skip
    """Longest blur time [s] at which some rows' bars may all arrive between two f-numbers, (m,); -1 where at none.

    contrast : (m, 3) of all light, which counts for veiled bars
    safe : they surely arrive at that time, at f-numbers that are the same
    """
    longest = np.full(len(rows), np.inf)
    for still in every:
        wanted: Any = still.bars.least
        if still.bars.veiled:
            wanted = still.bars.least / np.maximum(contrast, 1e-300)
        along, across = still.best_between(rows, n_low, n_high, working_factor=working_factor)
        fits = (across >= wanted * (1 - 1e-12)).all(axis=1) & (along >= wanted * (1 - 1e-12)).all(axis=1)
        need = np.clip(wanted / np.maximum(along, 1e-300), 0.0, 1.0)
        sign = -1.0 if safe else 1.0
        ratio = np.interp(-need, -_BOX, _RATIO) * (1.0 + sign * _TABLE_ERROR) + max(sign, 0.0) * 1e-9
        with np.errstate(divide="ignore"):
            nu = still.bars.frequency_cyc_per_px[rows]
            time = (ratio / nu / still.sharp.blur_px_per_s[rows]).min(axis=1)
        longest = np.minimum(longest, np.where(fits, time, -1.0))
    return longest


def while_sharp(rows: SceneRows) -> SceneRows:
    """Rows without light-collecting times in which the bars that are asked for arrive at no f-number, without sun.

    Closed forms know no sharpness: of them this is what they may know of it.
    """
    if rows.sharp is None or not rows.bars or rows.sunlit:
        return rows
    bars, every = [StillBars.of(one, rows.sharp) for one in rows.bars], np.arange(len(rows.kind))
    blur_s = longest_sharp_s(
        bars, every, rows.n_low, np.maximum(rows.n_high, rows.n_low), working_factor=rows.working_factor,
        contrast=rows.most_contrast(), safe=False,
    )  # fmt: skip
    within_s = np.where(blur_s < 0.0, -1.0, rows.flash.within_blur_s(np.maximum(blur_s, 0.0)))
    return replace(rows, time_max_s=np.minimum(rows.time_max_s, within_s))
