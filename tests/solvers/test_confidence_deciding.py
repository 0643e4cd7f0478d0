"""What decides whether hardware holds, and what asked less would do: shares and limits by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from one_of_each import RATE_HZ, one, with_parts
from test_confidence import FAST, NOTHING, between, counted, sought_of

from uwopt.deadline import NEVER, Deadline, OutOfTimeError, add_effort, effort_s
from uwopt.mission.doubt import Doubt
from uwopt.solvers.confidence import deciding, eased
from uwopt.solvers.confidence.counted import Counted
from uwopt.solvers.confidence.deciding import decided_by, shares
from uwopt.solvers.confidence.eased import (
    EASED_S,
    TRIED_S,
    MovedKeys,
    eases,
    light_with,
    nearest_that_holds,
    would_hold,
)
from uwopt.solvers.confidence.outcomes import outcomes, outcomes_of_each
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.recommend import Sought

COUNT = 400
LOW, MODE, HIGH = 2.0, 3.0, 8.0  # W that the camera draws


def seen(sought: Sought, share: float, **doubt: Any) -> tuple[Counted, Scenarios]:
    """What was counted of the best hardware."""
    problem = sought.problem
    scenarios = Scenarios.drawn(
        problem.mission, problem.scenes, Doubt.model_validate(NOTHING | doubt), seed=0, count=COUNT
    )
    found = sought.outcome.best[0]
    made = outcomes(problem, found, sought.search.objective, scenarios)
    return Counted(found, made, made.best(share)), scenarios


def quantile(share: float) -> float:
    """Of the triangle of the camera's power, above its mode."""
    return HIGH - float(np.sqrt((1.0 - share) * (HIGH - LOW) * (HIGH - MODE)))


@pytest.fixture(scope="module")
def short_of_power() -> Sought:
    """A camera that draws 2 to 8 W, most likely 3, where 4.2 W are left beside the lamp."""
    plain = sought_of(one(wanted=FAST))
    lamp_w = plain.outcome.best[0].power_w - 3.0
    camera = {"power_w": between(LOW, MODE, HIGH), "read_noise_e": between(1.9, 2.0, 2.1)}
    return sought_of(one(wanted=FAST, camera=camera, limits={"power_w": lamp_w + 4.2}))


def test_shares_are_of_the_low_and_of_the_high_third() -> None:
    number = np.arange(9.0)[::-1]
    held = np.array([1, 1, 1, 1, 0, 0, 0, 0, 0], bool)  # where the number is 8 to 5
    assert shares(held, number) == (0.0, 1.0)
    assert shares(held, np.array([0.0] * 3 + [1.0] * 6)) == (1.0, pytest.approx(1 / 6))


def test_it_depends_on_the_number_that_crosses_the_limit(short_of_power: Sought) -> None:
    one_, scenarios = seen(short_of_power, 0.9)
    told = decided_by(short_of_power.problem, short_of_power.search.objective, one_, scenarios)
    assert [(made.what, made.part) for made in told] == [("camera.power_w", "camera")]
    assert told[0].held_low == 1.0 and told[0].held_high == 0.0


def test_of_many_numbers_that_mean_nothing_none_is_told(short_of_power: Sought, monkeypatch: Any) -> None:
    """Which of forty numbers looks most telling is luck: a dark current of 0.03 electrons was said to decide.

    Told is one in a twenty-first of such answers: of 200, 10 with a standard deviation of 3.
    """
    one_, _ = seen(short_of_power, 0.9)
    rng, told = np.random.default_rng(3), 0
    for seed in range(200):
        held = rng.random(256) < 0.55
        outcome = SimpleNamespace(value=[np.where(held, 1.0, np.inf)])
        numbers = [(f"number {k}", "", column) for k, column in enumerate(rng.random((40, 256)))]
        monkeypatch.setattr(deciding, "numbers_of", lambda *_, numbers=numbers: iter(numbers))
        made: Any = SimpleNamespace(outcomes=outcome, stop=0, found=one_.found)
        there: Any = SimpleNamespace(seed=seed)
        told += bool(decided_by(short_of_power.problem, short_of_power.search.objective, made, there))
    assert told <= 20


def test_what_holds_in_all_scenarios_depends_on_nothing() -> None:
    sought = sought_of(one(wanted=FAST, camera={"power_w": between(LOW, MODE, HIGH)}))
    one_, scenarios = seen(sought, 0.9)
    assert one_.held == 1.0
    assert decided_by(sought.problem, sought.search.objective, one_, scenarios) == []


def test_a_limit_is_moved_as_far_as_its_number_reaches(short_of_power: Sought) -> None:
    """The limit of power at which the camera's draw fits in nine of ten: that quantile of its triangle higher."""
    problem, goal = short_of_power.problem, short_of_power.search.objective
    one_, scenarios = seen(short_of_power, 0.9)
    asked = problem.mission.limits.power_w
    assert asked is not None and one_.held < 0.9
    told = {made.name: made for made in would_hold(problem, goal, one_, scenarios, 0.9, NEVER)}
    made = told["power_w"]
    change = quantile(0.9) - 4.2
    assert made.unit == "w" and made.asked == asked
    assert change * 0.98 <= float(made.needed) - asked <= change * 1.15


def test_a_battery_is_as_large_as_the_cameras_draw_may_be() -> None:
    """As above, in ten hours: the energy grows with the draw, whatever share of a battery may be used."""
    lamp_w = sought_of(one(wanted=FAST)).outcome.best[0].power_w - 3.0
    camera = {"power_w": between(LOW, MODE, HIGH), "read_noise_e": between(1.9, 2.0, 2.1)}

    def of_battery(wh: float) -> Sought:
        vehicle = {"duration_h": 10.0, "battery_wh": wh, "supply": "battery"}
        return sought_of(one(wanted=FAST, camera=camera, vehicle=vehicle))

    usable_w = of_battery(1e4).problem.duration.mean_power_limit_w  # of 1 kW
    asked = 1e4 * (lamp_w + 4.2) / usable_w
    sought = of_battery(asked)
    one_, scenarios = seen(sought, 0.9)
    assert one_.held < 0.9 and one_.outcomes.missed(one_.stop)
    told = {made.name: made for made in would_hold(
        sought.problem, sought.search.objective, one_, scenarios, 0.9, NEVER)}  # fmt: skip
    change = asked * (quantile(0.9) - 4.2) / (lamp_w + 4.2)
    assert told["battery_wh"].unit == "wh" and told["battery_wh"].asked == pytest.approx(asked)
    assert change * 0.98 <= float(told["battery_wh"].needed) - asked <= change * 1.15


def test_less_signal_to_noise_holds_where_the_floor_is_dark() -> None:
    """A floor of 0.4 to 1.6 times its reflectance and a lamp that can give no more: what is told holds as counted."""
    light = {"dim_levels": (1.0,), "flux_lm": 3000.0}
    sought = sought_of(one("snr_db", wanted={"max_blur_px": 1.0, "min_snr_db": 1.0}, light=light), floor=[0.4, 1.6])
    best = sought.outcome.best[0].snr_db
    asked = float(np.floor(10.0 * best) / 10.0)
    tight = sought_of(
        one(wanted={"max_blur_px": 1.0, "min_snr_db": asked}, light=light), floor=[0.4, 1.6]
    )
    one_, scenarios = seen(tight, 0.9, floor=[0.4, 1.6])
    assert 0.2 < one_.held < 0.9
    told = {made.name: made for made in would_hold(
        tight.problem, tight.search.objective, one_, scenarios, 0.9, NEVER)}  # fmt: skip
    needed = float(told["min_snr_db"].needed)
    assert needed < asked
    for value, enough in ((needed, True), (needed + 0.2 * (asked - needed), False)):
        there = sought_of(one(wanted={"max_blur_px": 1.0, "min_snr_db": value}, light=light), floor=[0.4, 1.6])
        made = counted(there, Doubt.model_validate(NOTHING | {"floor": [0.4, 1.6]}), count=COUNT)
        assert bool(made.held.max() >= 0.9) is enough


def test_a_steadier_height_is_told_where_a_vehicle_leaves_its_band() -> None:
    """A pixel as large as from 2.52 m. Of 0.5 m about 2 m it leaves up to a quarter: 2.625 m; of 0.375 m, 2.47 m."""
    wanted = {"min_snr_db": 10.0, "max_gsd_mm": 0.5 * (2.52 + 0.08)}
    sought = sought_of(one(wanted=wanted, vehicle={"altitude_tolerance_m": 0.5}), beyond_band=0.25)
    one_, scenarios = seen(sought, 0.9, beyond_band=0.25)
    assert 0.0 < one_.held < 0.9 and [*one_.outcomes.missed(one_.stop)] == ["max_gsd_mm"]
    told = would_hold(sought.problem, sought.search.objective, one_, scenarios, 0.9, NEVER)
    assert [made.name for made in told] == ["max_gsd_mm", "altitude_tolerance_m"]
    assert (told[1].needed, told[1].nearest) == (0.437, False)  # within a quarter of a step of 0.125 m
    for tolerance_m, enough in ((0.437, True), (0.469, False)):  # 0.375 and 0.5 m, by halves
        there = sought_of(one(wanted=wanted, vehicle={"altitude_tolerance_m": tolerance_m}), beyond_band=0.25)
        made = counted(there, Doubt.model_validate(NOTHING | {"beyond_band": 0.25}), count=COUNT)
        assert bool(made.held.max() >= 0.9) is enough


@pytest.mark.parametrize(("asked_db", "least_db"), [(20.0, 6.0), (26.5, 6.5), (7.0, 6.0), (5.0, 0.0)])
def test_images_of_noise_alone_are_no_way_to_be_certain(asked_db: float, least_db: float) -> None:
    mission = one(wanted={"min_snr_db": asked_db}).mission
    (ease,) = [ease for ease in eases(mission, ["light"]) if ease.key == "min_snr_db"]
    assert ease.values == pytest.approx((least_db,))


@pytest.mark.parametrize(
    ("supply", "moved"), [("battery", {"battery_wh", "cost"}), ("vehicle", {"battery_wh"})], ids=["own", "there"]
)
def test_a_larger_battery_may_cost_more_where_it_is_bought(supply: str, moved: set[str]) -> None:
    """A year of coral was told that another battery is no help: the budget stood in its way, not named at all."""
    vehicle = {"duration_h": 10.0, "battery_wh": 100.0, "supply": supply}
    mission = one(vehicle=vehicle, limits={"cost": 8000.0}).mission
    assert {ease.key for ease in eases(mission, ["energy_wh"])} == moved | {"altitude_m"}


def test_light_in_a_narrower_band_is_that_worked_out_there() -> None:
    """In murky water that is not known, within 0.4 of 0.9 m: by what is known of all of it, and worked out anew."""
    doubt = {"clarity": True, "lamp_leg": True}
    case_ = one(
        wanted={"max_blur_px": 2.0, "min_snr_db": 3.0}, vehicle={"altitude_tolerance_m": 0.9}, scenes=({"water": "3C"},)
    )
    sought = sought_of(case_, **doubt)
    one_, scenarios = seen(sought, 0.9, **doubt)
    problem, goal = sought.problem, sought.search.objective
    (ease,) = [ease for ease in eases(problem.mission, []) if ease.key == "altitude_tolerance_m"]
    trial = MovedKeys(problem, goal, scenarios, 0.9)
    known_w, afresh_w, wide_w = (
        trial.outcomes_in(ease.mission_at(0.4), one_.found, light)[1].outcomes.value[0] - 3.0
        for light in (light_with([(ease, 0.4)], scenarios), {}, light_with([(ease, 0.9)], scenarios))
    )  # of the lamp
    assert known_w == pytest.approx(afresh_w, rel=1e-4)
    assert np.abs(wide_w / afresh_w - 1.0).max() > 2e-2


def test_without_time_nothing_is_told(short_of_power: Sought) -> None:
    one_, scenarios = seen(short_of_power, 0.9)
    over = Deadline(0.0, lambda: 1.0)
    assert would_hold(short_of_power.problem, short_of_power.search.objective, one_, scenarios, 0.9, over) == []


def test_what_would_hold_is_looked_for_in_counted_work(
    short_of_power: Sought, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each count would take a thousand times as long as there is; it is broken off, by work alone, at what is given."""
    one_, scenarios = seen(short_of_power, 0.9, clarity=True)
    problem, goal, mission = short_of_power.problem, short_of_power.search.objective, short_of_power.problem.mission
    with pytest.raises(OutOfTimeError):
        over = MovedKeys(problem, goal, scenarios, 0.9, Deadline(0.0, lambda: 1.0))
        over.outcomes_in(mission, one_.found, {})  # light is made anew

    def count_slowly(trial: MovedKeys, *given: Any) -> float:
        for _ in range(1000):
            add_effort(TRIED_S / 10.0)
            trial.deadline.check()
        return 0.0

    monkeypatch.setattr(MovedKeys, "held", count_slowly)
    began_s = effort_s()
    assert would_hold(problem, goal, one_, scenarios, 0.9, NEVER) == []
    assert EASED_S < effort_s() - began_s <= (EASED_S + TRIED_S) * 1.2


def test_where_time_runs_out_the_nearest_that_was_counted_is_told() -> None:
    """Of 4 asked and 16 far, it holds from 7 on; three counts find 4.38, 4.75 and 5.5 too little, a fourth 7."""
    counts: list[float] = []

    def holds(value: float) -> bool:
        if len(counts) == 4:
            raise OutOfTimeError
        counts.append(value)
        return value >= 6.9

    told = nearest_that_holds(4.0, 16.0, holds)
    assert told == counts[-1] >= 6.9 and all(value < 6.9 for value in counts[:-1])
    counts[:] = [0.0] * 4
    assert nearest_that_holds(4.0, 16.0, holds) == 16.0


def test_numbers_of_one_lamp_count_together_as_alone() -> None:
    """Two lamps light other pixels than three: which of them decides is not the same."""
    wanted = {"max_blur_px": 1.0, "min_snr_db": 20.0, "snr_at": "worst"}
    vehicle = {"light_count": [2, 3], "light_baseline_m": 0.9}
    case_ = one(wanted=wanted, vehicle=vehicle)
    problem = case_.problem()
    scenarios = Scenarios.drawn(problem.mission, problem.scenes, Doubt(), seed=3, count=24)
    outcome = case_.solve(top=5)[1]
    few = [replace(outcome.best[0], count=count) for count in (2, 3)]
    together = outcomes_of_each(problem, few, case_.objective, scenarios)
    for found, made in zip(few, together, strict=True):
        (alone,) = outcomes_of_each(problem, [found], case_.objective, scenarios)
        assert np.isfinite(alone.value).any()
        assert made.value == pytest.approx(alone.value, rel=1e-6)


def test_how_light_changes_is_known_by_what_is_asked_of_it() -> None:
    """Counted in a mission that asks for a white balance, then in one that does not, and has fewer columns of light."""
    sought = sought_of(one(wanted=FAST))
    one_, scenarios = seen(sought, 0.9, clarity=True, floor=[0.5, 1.5])
    problem, goal, mission = sought.problem, sought.search.objective, sought.problem.mission
    balanced = mission.with_changes(requirements=mission.to_dict()["requirements"] | {"max_white_balance": 4.0})
    afresh = MovedKeys(problem, goal, replace(scenarios, responses={}), 0.9)
    for there in (balanced, mission):  # mono: 1 in any water
        assert afresh.outcomes_in(there, one_.found)[1].outcomes.held.max() == one_.held


def test_what_cannot_be_set_by_central_numbers_holds_in_no_scenario_of_a_weaker_mission(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """0.284 images/s are asked: the first camera is as fast in most scenarios, but not by its central number."""
    slow = {"max_frame_rate_hz": between(0.2, 0.25, 0.9)}
    sought = sought_of(with_parts(one(wanted=FAST, camera=slow), cameras=[{"max_frame_rate_hz": 100.0}]))
    problem, goal = sought.problem, sought.search.objective
    scenarios = Scenarios.drawn(problem.mission, problem.scenes, Doubt.model_validate(NOTHING), seed=0, count=COUNT)
    (fast,) = sought.outcome.best
    trial = MovedKeys(problem, goal, scenarios, 0.0)
    held = {
        camera: [trial.held(replace(fast, camera=camera), [], as_set=as_set) for as_set in (False, True)]
        for camera in (0, 1)
    }
    assert held[1] == [1.0, 1.0]
    assert held[0] == [pytest.approx((0.9 - RATE_HZ) ** 2 / (0.65 * 0.7), abs=0.01), 0.0]
    monkeypatch.setattr(eased, "at_its_stop", lambda *given: pytest.fail("settings were looked for"))
    slower = replace(fast, camera=0)  # of which settings are asked only where it holds in as many
    assert replace(trial, share=held[0][0] + 0.01).held(slower, [], as_set=True) == 0.0
