"""The highest SNR within limits of power, in closed form, against settings tried one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hand_made_rows import FLASHES, STEPS, scene

from uwopt.forward.part_columns import PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.solvers.settings import closed_form, windows

LIMITS_W = np.array([[2.0, 30.0, np.nan, 60.0, 150.0, 500.0]])
LAMPS: dict[str, dict[str, Any]] = {
    "a dial": {},
    "a dial that starts high": {"min_level": 0.3, "light_lm": 2e6},
    "steps": STEPS,
    "bright steps": {**STEPS, "light_lm": 2e6},  # each has its own smallest f-number that fills no pixel
    "flashes": FLASHES,
    "pulses in steps": {**STEPS, "kind": PULSED, "light_lm": 2e6, "full_power_w": 2e4},
}


def tried_snr(rows: SceneRows) -> list[float]:
    """The best of many f-numbers, levels and times within the window of light, by power; -inf: there is none."""
    low, high = (float(end[0]) for end in windows.window(rows))
    levels = np.linspace(rows.min_level[0], 1.0, 101) if rows.dims_freely[0] else rows.levels[0]
    levels = levels[np.isfinite(levels) & (levels > 0.0)]
    times = np.geomspace(rows.time_min_s[0], rows.time_max_s[0], 101)
    f_numbers = np.geomspace(rows.n_low[0], rows.n_high[0], 201)
    level, time_s, f_number = (one.ravel() for one in np.meshgrid(levels, times, f_numbers, indexing="ij"))
    light_x = rows.light_lm[0] * level * time_s / np.square(f_number * rows.working_factor[0])
    fits = np.flatnonzero((light_x >= low) & (light_x <= high))
    some = rows.take(np.zeros(len(fits), int))
    drawn_w = closed_form.drawn_power_w(some, level[fits], time_s[fits])
    snr = closed_form.nominal_snr(some, light_x[fits])
    return [float(snr[drawn_w <= limit_w].max(initial=-np.inf)) for limit_w in LIMITS_W[0]]


@pytest.mark.parametrize("lamp", LAMPS)
def test_highest_snr_within_each_limit_is_that_of_settings_tried(lamp: str) -> None:
    rows = scene(**LAMPS[lamp])
    found = closed_form.greatest_snr([rows], np.array([False]), LIMITS_W)
    assert np.isnan(found[0, np.isnan(LIMITS_W[0])]).all()
    for limit_w, most, tried in zip(LIMITS_W[0], found[0], tried_snr(rows), strict=True):
        if np.isnan(limit_w):
            continue
        assert np.isfinite(tried) == np.isfinite(most)
        if np.isfinite(tried):
            assert tried <= most * (1.0 + 1e-9)
            assert most <= tried * 1.03  # steps of time and level of five per cent of the light
    assert np.isfinite(found).any()
