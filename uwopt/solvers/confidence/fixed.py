"""Settings that are fixed before the water is seen: one exposure, gain and light level in all scenarios.

Tried are those that are best in some scenario, in order of the light that scenarios ask for, with gains that saturate
in none of them, in few, or in half: those that hold often enough with the least median are taken, else those that hold
most often. A mean level that is asked for is not held: nothing fixed keeps it in waters that differ.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.scene_rows import SceneRows
from uwopt.solvers.settings import closed_form
from uwopt.solvers.settings.best import is_sharp
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.question import Best
from uwopt.tolerances import ROUND
from uwopt.units import ratio_to_db

if TYPE_CHECKING:
    from uwopt.solvers.confidence.outcomes import Judge

BEYOND = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # of the way from the share asked for to all
FEWER = (0.5, 0.75)  # of the scenarios: where no settings hold as often as asked
DARKER = (0.0, 0.03, 0.5)  # of the scenarios: those in which the gain saturates


@dataclass(frozen=True)
class SceneSetting:
    """What is set in one scene."""

    level: float
    time_s: float
    gain: float


Settings = list[SceneSetting]  # by scene


def best_fixed(
    judge: Judge, adapted: Best, sizes: Sequence[int], count: int, share: float, given: Settings | None
) -> tuple[tuple[Array, Array], list[Settings]]:
    """The verdict of the best settings of each block of rows, one hardware at one stop each; and those settings.

    sizes : of the blocks, one after another
    count : of all scenarios, of which a block may know fewer
    given : settings instead
    """
    block = np.repeat(np.arange(len(sizes)), sizes)
    value, first = np.full(len(block), np.inf), np.full(len(block), "light", dtype="<U12")
    rank = np.full((len(sizes), 2), np.inf)
    kept: list[Settings] = [[] for _ in sizes]
    middle = max(int(np.ceil(0.5 * count)) - 1, 0)
    for settings in [[given] * len(sizes)] if given else tried(judge.rows, adapted, block, len(sizes), share):
        values, missed = judge.verdict(settled(judge.rows, adapted, settings, block))
        order = np.lexsort((values, block))
        begin = np.cumsum([0, *sizes[:-1]])
        for b, size in enumerate(sizes):
            held = float(np.isfinite(values[begin[b] : begin[b] + size]).sum()) / count
            median = values[order[begin[b] + middle]] if size > middle else np.inf
            own = (0.0, median) if held >= share else (1.0 - held, 0.0)
            if own < tuple(rank[b]):
                mine = slice(begin[b], begin[b] + size)
                rank[b], kept[b], value[mine], first[mine] = own, settings[b], values[mine], missed[mine]
    return (value, first), kept


def tried(rows: Sequence[SceneRows], adapted: Best, block: Array, count: int, share: float) -> Iterator[list[Settings]]:
    """Settings by block and scene, one choice after another: those of which a share of the scenarios needs no more."""
    for asked, darker in product((*FEWER, *(share + beyond * (1.0 - share) for beyond in BEYOND)), DARKER):
        scenes = []
        for r, chosen in zip(rows, adapted.chosen, strict=True):
            light = np.where(adapted.feasible, chosen.level * chosen.time_s, np.nan)
            pick = at_quantile(light, block, count, asked)
            level, time_s = chosen.level[pick], chosen.time_s[pick]
            x = light_of(r, chosen.f_number, level[block], time_s[block])
            gain = closed_form.best_gain(replace(r, mean_level=None), np.where(np.isfinite(x), x, 1.0))
            gain = gain[at_quantile(np.where(adapted.feasible, gain, np.nan), block, count, darker)]
            scenes.append((level.tolist(), time_s.tolist(), gain.tolist()))
        yield [[SceneSetting(*(column[b] for column in columns)) for columns in scenes] for b in range(count)]


def at_quantile(values: Array, block: Array, count: int, share: float) -> Array:
    """The row of each block at a quantile of its numbers; any where it has none."""
    order = np.lexsort((values, block))  # what is no number comes last
    known = np.bincount(block[np.isfinite(values)], minlength=count)
    begin = np.searchsorted(block[order], np.arange(count))
    place = begin + np.ceil(share * np.maximum(known - 1, 0) - 1e-9).astype(int)
    return order[np.minimum(place, len(order) - 1)]


def light_of(rows: SceneRows, f_number: Array, level: Array, time_s: Array) -> Array:
    """X, lm s, with these settings."""
    return np.asarray(rows.light_lm * level * time_s / np.square(f_number * rows.working_factor))


def settled(rows: Sequence[SceneRows], adapted: Best, settings: Sequence[Settings], block: Array) -> Best:
    """Settings of each block as all of its rows have them, with their figures, and where they meet what is asked."""
    from uwopt.solvers.settings.cell_windows import figures_at

    chosen, holds = [], np.ones(len(block), bool)
    snr, contrast = np.full(len(block), np.inf), np.full(len(block), np.inf)
    for index, (r, best) in enumerate(zip(rows, adapted.chosen, strict=True)):
        own = [one[index] if one else SceneSetting(np.nan, np.nan, np.nan) for one in settings]
        level, time_s, gain = (
            np.array([getattr(one, name) for one in own])[block] for name in ("level", "time_s", "gain")
        )
        x = light_of(r, best.f_number, level, time_s)
        power, peak = closed_form.drawn_power_w(r, level, time_s), closed_form.peak_power_w(r, level)
        made = Chosen(best.f_number, level, time_s, gain, x, power, peak)
        lit = closed_form.with_exposure(replace(r, mean_level=None), made)
        with np.errstate(invalid="ignore"):
            own_snr, own_contrast, fits = figures_at(lit, x, gain, None)
            fits &= (time_s >= r.time_min_s / ROUND) & (time_s <= r.time_max_s * ROUND)
            fits &= (level <= r.max_level * ROUND) & (gain <= r.max_gain * ROUND)
        holds &= fits & is_sharp(lit, made) & np.isfinite(x)
        chosen.append(made)
        snr, contrast = np.minimum(snr, own_snr), np.minimum(contrast, own_contrast)
    with np.errstate(invalid="ignore", divide="ignore"):
        snr_db = ratio_to_db(np.where(holds, snr, 1.0))
    return Best(chosen, holds, np.asarray(snr_db), contrast, np.zeros(len(block)))
