"""Targets in open water: the search against enumeration where the water behind them may be what saturates."""

from __future__ import annotations

import math

import brute_force as brute
import pytest
from agreement import agree
from random_cases import CASES, Case, case, enumerated, lamp, planted, ranked
from thorough import drawn

from uwopt.catalog.records import exact
from uwopt.evaluation.design_model import DesignModel

BURNING = lamp("burning", flux_lm=2e5, power_w=2000.0, beam_angle_deg=20.0)


@pytest.mark.usefixtures("batches")
@pytest.mark.parametrize("seed", drawn((24,), CASES))
def test_search_in_mid_water_equals_enumeration(seed: int) -> None:
    made = case(seed, in_mid_water=True)
    agree(made, made.solve()[1], ranked(enumerated(seed, in_mid_water=True)))


def black_target(**asked: float | None) -> Case:
    """A nearly black target at 0.3 m; the lamp's narrow beam crosses the image behind it, where it is brightest."""
    wanted = {"frame_interval_s": 1.0, "overlap": None, **asked}
    scene = {"target": "mid_water", "seafloor": 0.001, "water": "3C"}
    vehicle = {"altitude_m": 0.3, "speed_m_s": 0.0, "light_baseline_m": 0.5, "light_tilt_deg": -45.0}
    camera = {"gain_dn_per_e": None, "prnu_frac": exact(0.0), "black_level_dn": 0.0, "bit_depth": 12, "gain_bits": 12}
    return planted("power", (BURNING,), wanted, camera=camera, scenes=(scene,), **vehicle)


def best_of(made: Case) -> list[brute.Best]:
    """The designs of an enumeration, which the search must find too."""
    found = brute.enumerate_all(brute.Bench(made.problem()), made.objective)
    agree(made, made.solve()[1], ranked(found))
    return [one for one in found if math.isfinite(one.value)]


def electrons_per_light() -> tuple[float, float, float]:
    """Signal, all light of the target and that of open water, per lm s."""
    problem = black_target().problem()
    light = DesignModel(problem, next(iter(brute.buildable(problem)))).rows[0].light
    return tuple(float(c[0, 0]) for c in (light.signal_e, light.signal_e + light.veil_e, light.background_e))  # type: ignore[return-value]


def test_the_well_holds_open_water_and_so_limits_the_signal_of_the_target() -> None:
    # 20 000 e hold 1.5 times the brightest; of that light the target has total / background, and SNR = s / sqrt(total)
    signal, total, background = electrons_per_light()
    assert background > 1.5 * total
    most_x = 20_000.0 / 1.5 / background
    most_db = 20.0 * math.log10(signal * most_x / math.sqrt(total * most_x))
    assert best_of(black_target(min_snr_db=most_db - 0.3))
    assert not best_of(black_target(min_snr_db=most_db + 0.01))


def test_a_wanted_level_of_the_target_leaves_room_for_the_water_behind_it() -> None:
    # 1.5 * level * background / total may not exceed full scale
    _, total, background = electrons_per_light()
    highest = total / background / 1.5
    assert best_of(black_target(mean_level=highest * 0.95)) and not best_of(black_target(mean_level=highest * 1.05))
