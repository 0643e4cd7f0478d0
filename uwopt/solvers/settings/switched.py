"""Least power of lamps together with cameras that are off between images, which draw for as long as they expose.

A lower level takes less while lamps come up, and keeps the cameras on for longer.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.part_columns import CONTINUOUS
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import MAXIMISED
from uwopt.solvers.settings import closed_form, dark, windows
from uwopt.solvers.settings.question import Question
from uwopt.tolerances import SLACK


def bound_with_cameras(question: Question, known: Array) -> Array:
    """What no settings can beat, (n,): `known`, of the lamps alone, raised by what cameras draw for their exposures.

    Where the image counts too `known` stands: longer exposures may be worth their power.
    """
    objective = question.objective
    of_power = objective.weight("power") and not any(objective.weight(name) for name in MAXIMISED)
    switched = [r for r in question.rows if r.camera_w is not None]
    if not of_power or not switched:
        return known
    least_w = np.max([least_power_w(r) for r in switched], axis=0)
    return np.maximum(known, question.constant + objective.weight("power") * least_w * (1.0 - SLACK))


def least_power_w(rows: SceneRows) -> Array:
    """What lamps and cameras draw at least for the light that is asked for, (n,) [W]; inf where it is out of reach.

        level time >= X N_w^2 / light,   P = P_lamps(level, time) + P_cameras(time)

    Both grow with the time, so that at a level the shortest is best; all levels are tried. Of a dial of lamps that burn
    P = a + b / time + c time between kinks, so that the best time is a kink or where the slope is 0; of other dials
    lamps count at their lowest level, cameras at their shortest exposure.

    Notes
    -----
    At the smallest f-number; with dark electrons where they help and none where they harm.
    """
    low, _ = windows.window(dark.relaxed(rows))
    top = np.minimum(rows.max_level, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        need = low * np.square(rows.n_low * rows.working_factor) / rows.light_lm  # level times time
        lowest = np.maximum(rows.min_level, need / rows.time_max_s)
    dial = np.where(rows.dims_freely[:, None], _of_dial(rows, need, lowest, top), np.nan)
    steps = np.where(rows.dims_freely[:, None], np.nan, rows.levels)
    levels = np.concatenate([dial, steps], axis=1)
    together = np.min([_power_w(rows, level, need, top) for level in levels.T], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        shortest_s = np.fmax(rows.time_min_s, need / top)
    apart = _power_w(replace(rows, camera_w=None), lowest, need, top) + rows.exposing_w(rows.exposure_s(shortest_s))
    return np.where(rows.dims_freely & (rows.kind != CONTINUOUS), apart, together)


def _power_w(rows: SceneRows, level: Array, need: Array, top: Array) -> Array:
    """Power at a level, nan: none, for the shortest time that is enough; inf where it cannot be."""
    with np.errstate(divide="ignore", invalid="ignore"):
        time_s = np.fmax(rows.time_min_s, need / level)
        power_w = closed_form.drawn_power_w(rows, level, time_s)
    fits = (level <= top * (1.0 + SLACK)) & (time_s <= rows.time_max_s * (1.0 + SLACK))
    return np.where(fits & np.isfinite(power_w), power_w, np.inf)


def _of_dial(rows: SceneRows, need: Array, lowest: Array, top: Array) -> Array:
    """Levels of lamps that burn, one of which draws least, (n, n_levels): ends, kinks, and where a slope is 0."""
    assert rows.camera_w is not None and rows.awake_s is not None
    with np.errstate(divide="ignore", invalid="ignore"):
        period_s = 1.0 / rows.rate_hz
        slopes = [rows.camera_w * rows.rate_hz * need / (rows.full_power_w * share)  # of lamps on for a lead, or always
                  for share in (rows.rate_hz * rows.leads_s, 1.0)]  # fmt: skip
        kinks_s = [
            rows.time_min_s, period_s - rows.leads_s,  # lamps on all the time
            rows.min_exposure_s + rows.exposure_offset_s, period_s - rows.awake_s + rows.exposure_offset_s,
        ]  # fmt: skip
        levels = np.stack([lowest, top, *(np.sqrt(one) for one in slopes), *(need / one for one in kinks_s)], axis=1)
    levels = np.where(np.isfinite(levels), levels, lowest[:, None])
    return np.asarray(np.clip(levels, lowest[:, None], np.maximum(lowest, top)[:, None]))
