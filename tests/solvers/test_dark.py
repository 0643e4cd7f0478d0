"""Dark current and exposure settled together: by hand where it can be, else attacked by settings drawn at random.

The attack's electrons, noise, gain and level are written out in `settings_attack` from the physics page.
"""

from __future__ import annotations

import math
import os
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hand_made_rows import FADING, STEPS, scene
from settings_attack import attacked, figures, lit

from uwopt.forward.part_columns import CONTINUOUS, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import Objective
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.dark import Branch, branches
from uwopt.solvers.settings.question import Best, Question

POWER, SNR = Objective({"power": 1.0}), Objective({"snr_db": 1.0})
CAMERA_W = np.array([3.0])
SEEDS = range(400 if os.environ.get("UWOPT_THOROUGH") == "1" else 12)


def best_of(scenes: list[SceneRows], objective: Objective = POWER, *, motorised: bool = False) -> Best:
    """Best settings of one design."""
    return best_settings(Question.of(scenes, np.array([motorised]), objective, CAMERA_W, np.inf))


def watt(best: Best) -> float:
    """Power of the lights, worst scene; inf where there are no settings."""
    return max(float(c.light_power_w[0]) for c in best.chosen) if best.feasible[0] else math.inf


# ---------------------------------------------------------------- by hand


def filled_by_dark() -> SceneRows:
    """Pulses for a wanted level that much dark current helps."""
    return scene(kind=PULSED, mean_level=0.3, min_snr=5.0, dark_current_e_s=20_000.0)


def test_pulse_as_long_as_allowed_lets_dark_current_fill_the_wanted_level():
    # 0.3 * 4095 DN at the highest gain, 16 * 0.37 DN/e, are 207.5 e; 5 ms at 20000 e/s bring 100 of them, the lamps
    # the rest at 100 e per unit of light. Power = 200 W * 5 Hz * X N_w^2 / light.
    rows = filled_by_dark()
    wanted_e = 0.3 * 4095.0 / (0.37 * 16.0) - 100.0
    assert watt(best_of([rows])) == pytest.approx(
        200.0 * 5.0 * wanted_e / 100.0 * (1.4 * 1.02) ** 2 / 20_000.0
    )


def test_pulse_ends_where_more_dark_current_would_ask_for_more_light():
    # Of the 207.5 e above SNR 5 asks for mu^2 = 25 (read noise^2 + quantisation + 207.5) from the lamps; dark electrons
    # bring the rest, 134.6 e, in 6.7 ms, and a longer pulse brings more noise than it saves light.
    rows = replace(filled_by_dark(), time_max_s=np.array([0.02]))
    gain = 0.37 * 16.0
    wanted_e = 0.3 * 4095.0 / gain
    mu = 5.0 * math.sqrt(2.3**2 + 1.0 / gain**2 / 12.0 + wanted_e)
    best = best_of([rows])
    assert best.chosen[0].time_s[0] == pytest.approx((wanted_e - mu) / 20_000.0, rel=1e-6)
    assert watt(best) == pytest.approx(200.0 * 5.0 * mu / 100.0 * (1.4 * 1.02) ** 2 / 20_000.0)


def test_lamp_burns_until_dark_electrons_leave_no_room_in_the_well():
    # Wells of 10500 e / 1.5 hold mu + d = 7000 e, at gain (4095 / 1.5) / 7000 DN/e. SNR 10 asks for
    # mu^2 = 100 (read noise^2 + quantisation + 7000); what is left is d = 2.5e6 e/s * t.
    rows = scene(dark_current_e_s=2.5e6)
    mu = 10.0 * math.sqrt(2.3**2 + (7000.0 / (4095.0 / 1.5)) ** 2 / 12.0 + 7000.0)
    time_s = (7000.0 - mu) / 2.5e6
    best = best_of([rows])
    assert best.chosen[0].time_s[0] == pytest.approx(time_s, rel=1e-8)
    assert watt(best) == pytest.approx(200.0 * mu / 100.0 * (1.4 * 1.02) ** 2 / (20_000.0 * time_s), rel=1e-8)


def test_step_that_dark_current_rules_out_at_its_longest_time_is_still_used_at_a_shorter_one():
    rows = scene(dark_current_e_s=2.5e6, **STEPS)
    assert watt(best_of([rows])) == 0.5 * 200.0  # 0.25 would need more than the level 0.336 of the case above


def test_at_a_step_the_shortest_time_that_reaches_is_taken():
    # Half the lamp gives mu = a t electrons, a = 100 * 0.5 * 20000 lm / N_w^2. SNR 10 asks for
    # (a t)^2 = 100 (read noise^2 + a t + 2.5e6 t), but for the quantisation, which is less than 0.1 e^2 there.
    a, lit_or_dark = 1e6 / (1.4 * 1.02) ** 2, 2.5e6
    asked = [a * a, -100.0 * (a + lit_or_dark), -100.0 * 2.3**2]
    best = best_of([scene(dark_current_e_s=2.5e6, **STEPS)])
    assert best.chosen[0].level[0] == 0.5
    assert best.chosen[0].time_s[0] == pytest.approx(max(np.roots(asked)), rel=1e-3)


def test_a_time_is_looked_for_only_where_neither_end_decides():
    places = np.zeros(3, np.intp)
    branch = branches(scene(dark_current_e_s=2.5e6).take(places))
    start, end, looked_at = np.full(3, 1e-5), np.full(3, 1e-2), set()

    def has_begun(some: Branch, time_s: np.ndarray) -> np.ndarray:
        if len(time_s) != len(places):
            looked_at.update(some.x_per_s)
        return np.asarray(time_s >= some.x_per_s)

    begins = replace(branch, x_per_s=np.array([1e-6, 3e-4, 1.0]))
    assert begins.first_true(has_begun, start, end) == pytest.approx([1e-5, 3e-4, math.nan], rel=1e-12, nan_ok=True)
    assert begins.last_false(has_begun, start, end) == pytest.approx([math.nan, 3e-4, 1e-2], rel=1e-12, nan_ok=True)
    assert looked_at == {3e-4}


def test_lower_step_at_the_widest_opening_fills_the_level_with_dark_electrons_though_none_fits_without():
    # 0.3 * 4095 DN are 3320 e at gain 1 and 1660 e at gain 2; 2 ms bring 324 e of dark current, 5 ms 810 e.
    # Wide open, N_w^2 = 2.04 and X N_w^2 = 40000 lm * level * time: the full lamp gives 3923 + 324 e at least, too
    # many, and a tenth of it 981 e at most: too few beside the dark electrons of 2 ms, enough beside those of 5 ms.
    # Closed so far that the full lamp fits, N_w^2 = 8 / 2.996, a tenth gives 749 + 810 e at most, which is too few.
    rows = scene(
        mean_level=0.3, min_snr=3.0, max_gain=2.0, light_lm=40_000.0, time_min_s=2e-3, time_max_s=5e-3,
        dims_freely=False, levels=[0.1, 1.0], dark_current_e_s=162_000.0,
    )  # fmt: skip
    best = best_of([rows])
    assert watt(best) == pytest.approx(0.1 * 200.0)
    assert best.chosen[0].f_number[0] == 1.4


def test_common_f_number_is_that_of_the_scene_that_needs_it():
    # The second scene's lamp has one level and 20 us at least: X N_w^2 = 20000 * 20e-6 = 0.4 lm s, and 1e5 e per lm s
    # must stay within 7000 e with 50 e of dark current: N_w^2 = 0.4e5 / 6950.
    bright = dict(signal_e=[1e5], dims_freely=False, levels=[1.0], dark_current_e_s=2.5e6)
    best = best_of([scene(dark_current_e_s=2.5e6), scene(**bright)])
    assert best.chosen[0].f_number[0] == pytest.approx(math.sqrt(0.4e5 / 6950.0) / 1.02, rel=1e-8)
    assert best.chosen[1].f_number[0] == best.chosen[0].f_number[0]


# ---------------------------------------------------------------- attacked


def drawn(seed: int) -> SceneRows:
    """One design with much dark current under a lamp of some kind."""
    rng = np.random.default_rng(seed)
    kind = rng.choice([CONTINUOUS, PULSED])
    shape = np.array([1.2, 1.0, 0.8])
    values: dict[str, Any] = dict(
        kind=kind, dark_current_e_s=10 ** rng.uniform(2, 6.3), mean_level=rng.choice([None, 0.1, 0.3]),
        min_snr=10 ** rng.uniform(0, 1.5), max_gain=10 ** rng.uniform(0, 1.3), light_lm=10 ** rng.uniform(3.0, 6.0),
        time_min_s=10 ** rng.uniform(-5, -3.5), time_max_s=10 ** rng.uniform(-3.3, -1.7),
        n_low=rng.choice([1.4, 2.8]), signal_e=list(shape * 10 ** rng.uniform(0.5, 2)),
        black_level_dn=rng.choice([0.0, 60.0]),
    )  # fmt: skip
    if kind == PULSED:
        values.update(readout_s=rng.choice([0.0, 1e-3]), min_exposure_s=rng.choice([2e-5, 5e-3]))
    levels = [dict(min_level=0.0), dict(min_level=0.05), dict(dims_freely=False, levels=[0.1, 0.3, 1.0])]
    return lit(**values, **levels[rng.integers(3)])


@pytest.mark.parametrize("seed", SEEDS)
def test_no_settings_need_less_power_and_those_chosen_hold(seed):
    rows = drawn(seed)
    best, attack = best_of([rows]), attacked(rows, POWER, np.random.default_rng(seed))
    assert attack >= watt(best) * (1 - 1e-7)
    if best.feasible[0]:
        one = best.chosen[0]
        seen = figures(
            rows, one.f_number, one.time_s, one.time_s + rows.exposure_offset_s, one.level, info=False
        )
        assert seen["ok"].all()
        assert seen["power"][0] == pytest.approx(watt(best))


@pytest.mark.parametrize("seed", SEEDS)
def test_no_settings_have_a_higher_snr_than_the_bound_and_the_gap_is_small(seed):
    rows = drawn(seed)
    best, attack = best_of([rows], SNR), attacked(rows, SNR, np.random.default_rng(seed))
    assert best.lower_bound is not None
    assert attack >= best.lower_bound[0] - 1e-7
    if best.feasible[0]:
        assert best.lower_bound[0] == pytest.approx(-best.snr_db[0], rel=1.1e-4)


@pytest.mark.parametrize("objective", [POWER, SNR])
@pytest.mark.parametrize("dark_current_e_s", [1e4, 1e6])
def test_a_flash_that_fades_is_cut_where_dark_electrons_outrun_its_light(objective, dark_current_e_s):
    rows = lit(**{**FADING, "light_lm": 1e5, "dark_current_e_s": dark_current_e_s, "min_level": 0.05, "min_snr": 20.0})
    best, attack = best_of([rows], objective), attacked(rows, objective, np.random.default_rng(3))
    assert best.feasible[0] and best.lower_bound is not None
    one = best.chosen[0]
    seen = figures(rows, one.f_number, one.time_s, one.time_s, one.level, info=False)
    assert seen["ok"].all()
    value = float(seen["power"][0]) if objective is POWER else -float(seen["snr_db"][0])
    assert attack >= best.lower_bound[0] - 1e-7 * abs(value)
    assert value == pytest.approx(best.lower_bound[0], rel=1.1e-4)


def test_bounds_for_any_veil_are_no_higher_than_the_power_with_the_least_veil():
    tried = [drawn(seed) for seed in SEEDS]
    tried = [replace(rows, most_veil_e=np.zeros_like(rows.signal_e)) for rows in tried]
    tried += [replace(filled_by_dark(), most_veil_e=np.zeros((1, 1)))]
    bounds = [best_of([replace(rows, optimistic=True)]) for rows in tried]
    truths = [best_of([rows]) for rows in tried]
    assert any(truth.feasible[0] for truth in truths)
    for bound, truth in zip(bounds, truths, strict=True):
        assert watt(bound) <= watt(truth) * (1 + 1e-9)
