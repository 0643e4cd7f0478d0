"""Lamps and cameras that are off between images, in the exact search: against enumeration and by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from agreement import agree
from energy_cases import enumerated_of, switched_case
from hand_made_rows import FADING, FLASHES, STEPS, scene
from random_cases import CHOSEN, in_batches, lamp, planted, ranked, solved
from settings_attack import lit, sharp
from thorough import THOROUGH

from uwopt.evaluation.design import evaluate_design
from uwopt.forward.part_columns import CONTINUOUS, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import Objective
from uwopt.solvers.settable.rounding import given_of
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.cells import best_by_cells
from uwopt.solvers.settings.closed_form import drawn_power_w, most_light
from uwopt.solvers.settings.question import GAP, Question
from uwopt.solvers.settings.switched import least_power_w
from uwopt.solvers.settings.windows import window

FEW = (17, 24, 33, 81)  # one scene and two, both physics, all kinds of lamps, quickly enumerated
SEEDS = tuple(s for s in CHOSEN if solved(s).best) if THOROUGH else FEW


@pytest.mark.parametrize(("batches", "seed"), in_batches(SEEDS), indirect=["batches"])
def test_search_with_lamps_off_between_images_equals_enumeration(batches: str, seed: int) -> None:
    found = ranked(enumerated_of(switched_case, seed))
    agree(switched_case(seed), switched_case(seed).solve()[1], found, gap_rel=2 * GAP)


@pytest.mark.parametrize("seed", SEEDS)
def test_claims_hold_with_lamps_off_between_images(seed: int) -> None:
    case = switched_case(seed)
    for found in case.solve()[1].best:
        problem, hardware = case.problem(), found.hardware
        design = evaluate_design(
            problem, hardware, given_of(problem, hardware, found.settings), case.objective
        )
        assert design.feasible
        assert design.totals.power_w == pytest.approx(found.power_w, rel=1e-9)
        assert not math.isnan(found.minimised)


# ---------------------------------------------------------------- parts of the search


def off(lead_s: float, image: Any = None, **changed: Any) -> SceneRows:
    """200 W of lamps, off between images, 0.5 W of standby, an image in ten seconds."""
    return lit(image, rate_hz=0.1, lead_s=lead_s, idle_w=0.5, **changed)


@pytest.mark.parametrize("lead_s", [0.0, 0.02, 1.0])
@pytest.mark.parametrize("wanted", ["power", "snr_db"])
def test_cells_and_closed_form_agree_on_switched_lamps(wanted: str, lead_s: float) -> None:
    image = sharp(blur=0.0, place=0.0)
    args = (np.array([False]), Objective.of(wanted), np.array([3.0]), 6.0)
    easy = best_settings(Question.of([off(lead_s, image)], *args))
    cells = best_by_cells(Question.of([off(lead_s, image, min_mtf=1e-12)], *args))
    assert easy.feasible[0]
    assert cells.feasible[0]
    value = easy.chosen[0].light_power_w[0] + 3.0 if wanted == "power" else -easy.snr_db[0]
    found = cells.chosen[0].light_power_w[0] + 3.0 if wanted == "power" else -cells.snr_db[0]
    assert found == pytest.approx(value, rel=2e-4)
    assert cells.lower_bound[0] <= found


@pytest.mark.parametrize("camera_w", [1.0, 8.0, 40.0])
def test_lamps_and_cameras_share_the_least_power_by_hand(camera_w: float) -> None:
    """A dial at level u for t s, the camera on for 2 s + t: with u t = q an image takes F q (lead / t + 1) + W t
    joules, least at t = sqrt(F q lead / W)."""
    lead_s, args = 0.5, (np.array([False]), Objective.of("power"), np.array([3.0]), np.inf)
    rows = off(lead_s, time_max_s=1.0, min_level=0.0, dark_current_e_s=0.0)
    alone = best_settings(Question.of([rows], *args)).chosen[0]
    q = float(alone.level[0] * alone.time_s[0])  # what the images need, whoever draws for it
    exposing = replace(rows, camera_w=np.array([camera_w]), awake_s=np.array([2.0]))
    found = best_settings(Question.of([exposing], *args, constant=3.0))
    time_s = float(np.clip(np.sqrt(200.0 * q * lead_s / camera_w), rows.time_min_s[0], 1.0))
    joules = 200.0 * q * (lead_s / time_s + 1.0) + camera_w * (time_s - rows.min_exposure_s[0])
    least_w = 3.0 + 0.5 + 0.1 * joules
    drawn_w = 3.0 + found.chosen[0].light_power_w[0]
    assert found.lower_bound is not None
    assert found.lower_bound[0] <= least_w * (1 + 1e-9)
    assert drawn_w == pytest.approx(least_w, rel=GAP)
    assert drawn_w - found.lower_bound[0] <= 1.01 * GAP * drawn_w
    assert 3.0 + least_power_w(exposing)[0] == pytest.approx(least_w, rel=1e-9)


PULSES: dict[str, Any] = {"kind": PULSED}
KINDS: tuple[dict[str, Any], ...] = ({}, STEPS, FADING, FLASHES, FADING | STEPS, PULSES, STEPS | PULSES)


@pytest.mark.parametrize("place", range(len(KINDS)))
def test_no_level_and_time_draw_less_than_the_least_of_lamps_and_cameras(place: int) -> None:
    """Ten thousand settings each that give the light which is asked for, at the smallest f-number, of drawn designs."""
    rng, kind = np.random.default_rng(place), KINDS[place]
    for _ in range(20):
        def drawn(low: float, high: float) -> float:
            return float(np.exp(rng.uniform(np.log(low), np.log(high))))

        rate_hz, lead_s = drawn(1e-3, 1.0), drawn(1e-3, 3.0) if rng.random() < 0.8 else np.inf
        times = {} if "time_max_s" in kind else {"time_max_s": drawn(0.05, 0.9) / rate_hz}
        rows = scene(**times | kind | dict(rate_hz=rate_hz, min_level=drawn(1e-3, 0.1), max_level=drawn(0.3, 1.0),
                     signal_e=[drawn(0.1, 1e3)], readout_s=0.01))  # fmt: skip
        rows = replace(rows, lead_s=np.array([lead_s]), camera_w=np.array([drawn(0.1, 50.0)]),
                       awake_s=np.array([drawn(1e-3, 2.0)]), idle_w=np.array([0.2]))  # fmt: skip
        low = window(rows)[0][0]
        spread = np.geomspace(float(rows.min_level[0]), float(rows.max_level[0]), 100)
        levels = spread if rows.dims_freely[0] else rows.levels[0][rows.levels[0] <= rows.max_level[0]]
        times_s = np.geomspace(float(rows.time_min_s[0]), float(rows.time_max_s[0]), 10_000 // max(len(levels), 1))
        level, time_s = (grid.ravel() for grid in np.meshgrid(levels, times_s))
        bright = rows.light_lm[0] * level * time_s >= low * (rows.n_low[0] * rows.working_factor[0]) ** 2
        power_w = drawn_power_w(rows, level[bright], time_s[bright])
        least_w = least_power_w(rows)[0]
        assert least_w <= power_w.min(initial=np.inf) * (1.0 + 1e-9)
        if rows.kind[0] == CONTINUOUS and len(power_w):
            assert power_w.min() <= 1.1 * least_w  # neighbours on the grid differ by a tenth at most


def test_power_is_left_for_the_exposure_of_the_highest_snr() -> None:
    rows = replace(off(0.02, dark_current_e_s=0.0), camera_w=np.array([20.0]), awake_s=np.array([2.0]))
    args = (np.array([False]), Objective.of("snr_db"), np.array([3.0]), 3.6)
    found, free = (best_settings(Question.of([each], *args)) for each in (rows, replace(rows, camera_w=None)))
    assert found.feasible[0]
    assert found.lower_bound is not None
    assert found.chosen[0].light_power_w[0] + 3.0 <= 3.6 * (1 + 1e-8)
    assert free.snr_db[0] - 1.0 < found.snr_db[0] <= -found.lower_bound[0] < free.snr_db[0]


def test_most_light_within_a_power_by_hand() -> None:
    """4.5 W less 0.5 W of standby are 2 % of 200 W: 0.2 s at full in ten seconds, less what the warm-up takes.

    A dial: the longest time t at the level u with u (lead + t) = 0.2 s. A step of 1 or 0.5: 0.2 s / u - lead.
    """
    lens = np.array([2.0])
    square = (2.0 * 1.02) ** 2

    def most_s(rows: SceneRows) -> float:
        low, high = np.array([0.0]), np.array([np.inf])
        return float(most_light(rows, lens, low, high, np.array([4.5]))[0]) * square / 20_000.0

    dial = off(0.3, time_max_s=0.1)
    assert most_s(dial) == pytest.approx(0.2 / 0.4 * 0.1)
    steps = {"dims_freely": False, "levels": [0.5, 1.0]}
    assert most_s(off(0.15, time_max_s=1.0, **steps)) == pytest.approx(0.5 * (0.4 - 0.15))
    assert most_s(off(0.15, time_max_s=0.1, **steps)) == pytest.approx(0.05)  # a twentieth either way


def test_bounds_are_no_higher_than_what_switched_lamps_draw() -> None:
    burning = lamp("burning", flux_lm=2e4, power_w=200.0, warm_up_s=0.5, standby_w=0.01)
    case = planted("power", (burning,), {"min_snr_db": 20.0, "frame_interval_s": 60.0, "overlap": None},
                   speed_m_s=0.0, lamps_between_images="off")  # fmt: skip
    search, outcome = case.solve()
    best = outcome.best[0]
    k = next(i for i, one in enumerate(search.tables.lightings) if one is best.lighting)
    bound = search.bounds.of_nodes(k, np.array([best.imager]))
    assert bound.power[0] <= best.power_w * (1 + 1e-9)
    assert best.power_w < 2.0 + 200.0 * 1.5 / 60.0 + 0.02  # camera, lamp at full for 1.5 s a minute, standby
