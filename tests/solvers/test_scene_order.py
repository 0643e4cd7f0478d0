"""The order in which a mission lists its scenes is no part of the mission."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import random_cases as cases
import small_catalogues as small

from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.ranking import Found

FAST = (10, 33)
SEEDS = range(40) if cases.THOROUGH else FAST
OBJECTIVES: tuple[Any, ...] = ("power", "snr_db", {"power": 0.2, "snr_db": 1.0})
WATERS = ({"temperature_c": 30.0, "salinity_psu": 0.0}, {"temperature_c": 0.0, "salinity_psu": 40.0}, {})


def case_of(seed: int, order: tuple[int, ...], objective: Any) -> cases.Case:
    """One random mission whose scenes differ in water, height and wishes, its scenes in a given order."""
    rng = np.random.default_rng(seed)
    parts, plain = small.parts(rng, 2), small.mission(rng)
    in_air = tuple(
        replace(light, beam_medium="air") for light in parts.lights
    )  # what each water bends its own way
    parts = replace(parts, lights=in_air)
    altitude_m = plain["vehicle"]["altitude_m"]
    scenes = [{**small.scene(rng, n), **water} for n, water in enumerate(WATERS[: len(order)])]
    scenes[1] |= {"altitude_m": altitude_m * 1.1, "min_snr_db": float(rng.uniform(5, 25))}
    plain |= {"scenes": [scenes[n] for n in order], "objective": objective, "physics": "full"}
    return cases.Case(parts, small.loaded(plain), Objective.of(objective))


@cache
def solved(seed: int, order: tuple[int, ...]) -> Outcome:
    """What the search finds, once."""
    return case_of(seed, order, OBJECTIVES[seed % len(OBJECTIVES)]).solve()[1]


def design(found: Found) -> tuple[Any, ...]:
    """What a person would buy."""
    return found.camera, found.lens, found.port, found.landscape, found.light, found.count


@pytest.mark.parametrize("seed", SEEDS)
def test_the_order_of_scenes_changes_no_optimum(seed: int) -> None:
    orders = [(0, 1, 2), (2, 0, 1), (1, 0, 2)] if seed % 2 else [(0, 1), (1, 0)]
    outcomes = [solved(seed, order) for order in orders]
    first = outcomes[0]
    for other in outcomes[1:]:
        assert [design(f) for f in other.best] == [design(f) for f in first.best]
        values = [f.minimised for f in first.best]
        # Tables of the water are interpolated over reaches that no order changes: sums differ by rounding alone.
        assert [f.minimised for f in other.best] == pytest.approx(values, rel=1e-9)
        assert other.lower_bound == pytest.approx(first.lower_bound, rel=1e-9)


def test_the_seeds_of_the_default_run_have_systems() -> None:
    assert all(solved(seed, (0, 1)).best for seed in FAST)


def test_a_beam_stated_in_air_is_refracted_into_each_scenes_own_water() -> None:
    # Half angle 45 deg in air: sin 45 / n in water, by Snell. Fresh warm water bends less than cold brine.
    lamp = cases.lamp("lamp", kind="continuous", flux_lm=1e4, power_w=100.0, beam="cone", beam_medium="air",
                      beam_angle_deg=90.0, spectrum_id="generic-led")  # fmt: skip
    problem = cases.planted("power", (lamp,), {}, scenes=WATERS[:2]).problem()
    for index, scene in enumerate(problem.scenes):
        expected = math.asin(math.sin(math.pi / 4) / scene.n_water)
        assert problem.beam(index, 0).half_angle_water_rad == pytest.approx(expected, rel=1e-12)
    assert problem.scenes[1].n_water - problem.scenes[0].n_water > 0.01
