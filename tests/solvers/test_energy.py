"""Limits of energy and storage in the exact search: against enumeration, over scenes, and in cells."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from agreement import agree
from energy_cases import energy_case, enumerated_of
from random_cases import CHOSEN, in_batches, lamp, planted, ranked, solved
from settings_attack import lit, sharp
from thorough import THOROUGH, drawn

from uwopt.catalog.records import exact
from uwopt.evaluation.design import evaluate_design
from uwopt.objectives.objective import Objective
from uwopt.solvers.settable.rounding import given_of
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.cells import best_by_cells
from uwopt.solvers.settings.mean_limit import MeanLimit
from uwopt.solvers.settings.question import Question

BURNING = lamp("burning", flux_lm=2e4, power_w=200.0)

#: With one scene and two, all kinds of lamps, and SNR alone, in a sum, or not in the objective.
SEEDS = tuple(s for s in CHOSEN if solved(s).best) if THOROUGH else (24, 33, 75, 81)


@pytest.mark.parametrize(("batches", "seed"), in_batches(SEEDS), indirect=["batches"])
def test_search_with_an_energy_limit_equals_enumeration(batches: str, seed: int) -> None:
    agree(energy_case(seed), energy_case(seed).solve()[1], ranked(enumerated_of(energy_case, seed)))


def test_the_limit_changes_what_is_found() -> None:
    changed = 0
    for seed in SEEDS:
        free, bound = solved(seed).best, energy_case(seed).solve()[1].best
        changed += not bound or bound[0].minimised > free[0].minimised + 1e-6 * abs(free[0].minimised)
    assert changed >= len(SEEDS) // 3


@pytest.mark.parametrize("seed", SEEDS)
def test_claims_hold_with_an_energy_limit(seed: int) -> None:
    """Each design that is found keeps within the energy, counted over its scenes by hand from their powers."""
    case = energy_case(seed)
    mission = case.mission
    for found in case.solve()[1].best:
        problem, hardware = case.problem(), found.hardware
        given = given_of(problem, hardware, found.settings)
        design = evaluate_design(problem, hardware, given, case.objective)
        assert design.feasible
        power_w = [scene.figures["power_w"] for scene in design.scenes]
        shares = [scene.time_share or 0.0 for scene in mission.scenes]
        energy_wh = float(np.dot(shares, power_w)) * (mission.vehicle.duration_h or math.nan)
        assert design.totals.energy_wh == pytest.approx(energy_wh, rel=1e-12)
        assert energy_wh <= (mission.limits.energy_wh or 0.0) * (1 + 1e-6)


# ---------------------------------------------------------------- over scenes: cells, rules


@pytest.mark.parametrize("share", drawn([0.7], [0.2, 0.7]))
@pytest.mark.parametrize("wanted", ["power", "snr_db", {"power": 1.0, "snr_db": 2.0}])
def test_cells_and_closed_form_agree_on_energy_over_two_scenes(wanted: Any, share: float) -> None:
    """One scene asks for ten times the SNR; a wanted sharpness of nothing leaves the closed form."""
    image = sharp(blur=0.0, place=0.0)
    easy = [lit(image, min_snr=snr) for snr in (4.0, 40.0)]
    hard = [replace(rows, min_mtf=1e-12) for rows in easy]
    camera_w, still = np.array([3.0]), np.array([False])
    least = best_settings(Question.of(easy, still, Objective.of("power"), camera_w, np.inf))
    needed = [float(c.light_power_w[0]) for c in least.chosen]
    mean_w = share * needed[0] + (1 - share) * needed[1] + 3.0
    for room, fits in ((0.99, False), (1.3, True)):
        args = (still, Objective.of(wanted), camera_w, np.inf)
        limit = MeanLimit((share, 1.0 - share), room * mean_w)
        closed, cells = (
            best_settings(Question.of(easy, *args, mean_limit=limit)),
            best_by_cells(Question.of(hard, *args, mean_limit=limit)),
        )
        assert closed.feasible[0] == fits
        assert cells.feasible[0] == fits
        if not fits:
            assert cells.lower_bound[0] == np.inf
            continue
        drawn_w = [float(c.light_power_w[0]) for c in closed.chosen]
        assert share * drawn_w[0] + (1 - share) * drawn_w[1] + 3.0 <= room * mean_w * (1 + 1e-9)
        assert cells.snr_db[0] == pytest.approx(closed.snr_db[0], abs=0.01)
        if wanted == "snr_db":  # nothing but the energy holds the SNR down
            free = best_settings(Question.of(easy, *args))
            assert closed.snr_db[0] < free.snr_db[0] - 0.1
            assert share * drawn_w[0] + (1 - share) * drawn_w[1] + 3.0 == pytest.approx(
                room * mean_w, rel=1e-6
            )


def test_storage_discards_by_the_mean_over_scenes() -> None:
    """Two scenes, one at ten times the rate: a tenth and nine tenths of the time, 1.9 images a second on average."""
    case = planted("power", (BURNING,), {"frame_interval_s": 1.0, "overlap": None}, scenes=(
        {"frame_interval_s": 0.1, "time_share": 0.1}, {"time_share": 0.9}), speed_m_s=0.0,
        camera={"max_frame_rate_hz": exact(50.0)})  # fmt: skip
    camera = case.parts.cameras[0]
    frame_gb = camera.resolution_x_px * camera.resolution_y_px * camera.bit_depth / 8.0 / 1e9
    needed_gb = (0.1 * 10.0 + 0.9 * 1.0) * 7.0 * 3600.0 * frame_gb
    for room, found in ((1.0 - 1e-6, 0), (1.0 + 1e-6, 1)):
        data = case.mission.to_dict()
        data["vehicle"]["duration_h"], data["limits"]["storage_gb"] = 7.0, room * needed_gb
        mission = case.mission.with_changes(vehicle=data["vehicle"], limits=data["limits"])
        outcome = replace(case, mission=mission).solve()[1]
        assert len(outcome.best) == found
        assert outcome.account.adds_up()
        assert (outcome.account.discarded["storage_gb"] > 0) is not bool(found)


def test_bounds_of_the_mean_power_are_no_higher_than_what_designs_draw() -> None:
    """A tenth of the time in a scene that asks for far more light."""
    case = planted("power", (BURNING,), {"max_blur_px": 1.0}, scenes=(
        {"min_snr_db": 22.0, "time_share": 0.1}, {"min_snr_db": 10.0, "time_share": 0.9}))  # fmt: skip
    search, outcome = case.solve()
    assert outcome.best
    shares = [scene.time_share or 0.0 for scene in case.mission.scenes]
    for found in outcome.best:
        k = next(i for i, one in enumerate(search.tables.lightings) if one is found.lighting)
        bound = search.bounds.of_nodes(k, np.array([found.imager])).mean_power_w[0]
        problem, hardware = case.problem(), found.hardware
        given = given_of(problem, hardware, found.settings)
        design = evaluate_design(problem, hardware, given, case.objective)
        assert bound <= float(np.dot(shares, [s.figures["power_w"] for s in design.scenes])) * (1 + 1e-9)
