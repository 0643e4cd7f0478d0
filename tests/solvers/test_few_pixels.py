"""Pixels left out before settings are sought: what all but k ask for is the same as of all, at any exposure."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hand_made_rows import scene
from settings_attack import lit

from uwopt.forward.scene_rows import SceneRows
from uwopt.solvers.settings import dark, windows
from uwopt.solvers.settings.cell_bounds import SceneCells
from uwopt.solvers.settings.few_pixels import deciding_pixels

PIXELS = 60


def image(seed: int, may_miss: int, **changed: Any) -> SceneRows:
    """Two altitudes of pixels with light and veil drawn at random, under a lamp whose exposure spans 1 to 250 ms."""
    rng = np.random.default_rng(seed)
    signal, veil = (rng.uniform(*ends, (1, 2, PIXELS)) for ends in ((0.5, 2.0), (0.0, 3.0)))
    rows = scene(
        signal_e=[2.0, 1.8], dark_current_e_s=rng.choice([3.0, 100.0, 2000.0]), time_min_s=1e-3, time_max_s=0.25,
        min_snr=rng.uniform(2.0, 12.0), **changed,
    )  # fmt: skip
    return replace(rows, worst_e=signal, worst_veil_e=veil, may_miss=may_miss)


@pytest.mark.parametrize("more", [{}, {"mean_level": 0.2}], ids=["gain at its best", "a wanted level"])
@pytest.mark.parametrize("seed", range(8))
def test_few_pixels_ask_for_what_all_but_k_of_all_do(seed: int, more: dict[str, Any]) -> None:
    """At twenty exposures the window of the few is that of all; by sorting what all pixels ask for."""
    rows = image(seed, may_miss=seed, **more)
    few = deciding_pixels(rows)
    assert few.worst_e is not None and few.worst_e.shape[2] < PIXELS
    for time_s in np.geomspace(1e-3, 0.25, 20):
        at = dark.at_time(rows, np.array([time_s]))
        for altitude in range(2):
            asked = windows.light_of_each(at, altitude, rows.min_snr, of="worst")[0]
            short = dark.at_time(few, np.array([time_s]))
            of_few = windows.light_for_snr(short, altitude, rows.min_snr, of="worst")
            assert of_few[0] == sorted(asked)[-1 - seed]


def test_a_design_where_pixels_miss_at_any_light_keeps_them() -> None:
    # no light makes up for a veil a thousand times the signal: PRNU alone is above it; two such pixels, one may miss
    rows = image(0, may_miss=1, prnu_frac=0.01)
    assert rows.worst_veil_e is not None
    veil = rows.worst_veil_e.copy()
    veil[:, :, :2] = 2000.0
    few = deciding_pixels(replace(rows, worst_veil_e=veil))
    assert np.isinf(windows.light_asked_for(few)[0])


def test_designs_of_different_pixels_keep_their_own() -> None:
    one, other = (image(seed, may_miss=3) for seed in (1, 2))
    assert one.worst_e is not None and other.worst_e is not None
    assert one.worst_veil_e is not None and other.worst_veil_e is not None
    both = replace(
        one.take(np.array([0, 0])),
        worst_e=np.concatenate([one.worst_e, other.worst_e]),
        worst_veil_e=np.concatenate([one.worst_veil_e, other.worst_veil_e]),
    )
    few = deciding_pixels(both)
    for time_s in (1e-3, 0.02, 0.25):
        full, less = (dark.at_time(rows, np.array([time_s, time_s])) for rows in (both, few))
        assert (windows.light_asked_for(less) == windows.light_asked_for(full)).all()


@pytest.mark.parametrize("more", [{}, {"resolve_m": 2.2e-3}], ids=["no bars", "bars behind the veil"])
def test_cells_of_settings_look_at_few_pixels_but_under_the_sun(more: dict[str, Any]) -> None:
    given = dict(may_miss=3, veil=4.0, dark_current_e_s=50.0, **more)
    lamps, sun = (lit(**given, **beside) for beside in ({}, {"sun": (3e3, 4e3), "open_max_s": 5e-3}))
    sun = replace(sun, worst_sun_signal_e_s=None, worst_sun_veil_e_s=None)  # as bright at every pixel as in the mean
    no_limit = np.array([np.inf])
    few, every = (SceneCells(rows, no_limit).rows.worst_e for rows in (lamps, sun))
    assert lamps.worst_e is not None and few is not None and every is not None
    assert few.shape[2] < lamps.worst_e.shape[2] == every.shape[2]
