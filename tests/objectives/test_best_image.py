"""The best image for its price: what is minimised by hand, its prices in other currencies, and its keys."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uwopt.errors import MissionError
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.mission import load_mission
from uwopt.objectives.goal import goal_of, taken_instead
from uwopt.objectives.objective import Objective, Terms


def mission(objective: Any, **limits: Any) -> Any:
    """A survey in one water."""
    return load_mission(
        {
            "practice": "bare", "objective": objective, "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30},
            "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3}, "requirements": {"overlap": 0.5}, "limits": limits,
        }
    )  # fmt: skip


def terms(*, information: float = 1.0, snr_db: float = 0.0, power: float = 0.0, cost: float = 0.0) -> Terms:
    """One design."""
    one = np.ones(1)
    return Terms(power * one, cost * one, one, snr_db * one, one, information=information * one)


def value(goal: Objective, **figures: float) -> float:
    """As the mission reads it."""
    return goal.reported(float(goal.cost_to_minimise(terms(**figures))[0]))


# ---------------------------------------------------------------- the sum


def test_a_watt_and_100_usd_each_take_one_percent() -> None:
    # 1e6 bit/m2 at 4 W and 5000 USD: 1e6 / 1.01^4 / 1.01^50; 54 ln 1.01 = 0.537318, whose exponential is 1.711410
    found = value(goal_of(mission("best_image")), information=1e6, power=4.0, cost=5000.0)
    assert found == pytest.approx(1e6 / 1.711410, rel=2e-6)


def test_gains_that_the_mission_states() -> None:
    goal = goal_of(mission({"best_image": {"per_w": 0.25, "per_100_usd": 1.0}}))
    assert value(goal, information=1000.0, power=2.0, cost=300.0) == pytest.approx(1000.0 / 1.25**2 / 2.0**3)


def test_prices_hold_in_the_currency_of_the_mission() -> None:
    goal = goal_of(mission("best_image", currency="EUR", rates={"EUR": 1.25}))  # 400 EUR are 500 USD
    assert value(goal, information=1e6, cost=400.0) == pytest.approx(1e6 / 1.01**5)


def test_signal_to_noise_counts_as_a_ratio() -> None:
    goal = goal_of(mission({"best_image": {"of": "snr", "per_w": 0.1}}))
    assert value(goal, snr_db=40.0, power=2.0) == pytest.approx(100.0 / 1.1**2)  # 40 dB: 100
    assert goal.unit("USD") == ""


def test_gains_of_nothing_leave_the_image_alone() -> None:
    goal = goal_of(mission({"best_image": {"per_w": 0, "per_100_usd": 0}}))
    assert value(goal, information=1e6, power=400.0, cost=9e4) == pytest.approx(1e6)
    assert goal.name == "best_image" and goal.direction == "maximise"


def test_what_no_setting_changes_is_the_price_alone() -> None:
    goal = goal_of(mission("best_image"))
    assert goal.constant(terms(power=4.0))[0] == pytest.approx(4.0 * np.log(1.01))


def test_steps_are_shares_of_the_value() -> None:
    goal = goal_of(mission("best_image"))
    best = goal.minimised(1e6)
    assert goal.reported(best - goal.step(0.1, best)) == pytest.approx(1.1e6)
    assert goal.share(goal.step(0.1, best), best) == pytest.approx(0.1)
    assert goal.amount(goal.step(0.1, best), best) == pytest.approx(1e5)


def test_steps_of_a_sum_are_those_of_its_value() -> None:
    watts = Objective.of("power")
    assert watts.step(0.1, 50.0) == pytest.approx(5.0) and watts.amount(5.0, 50.0) == 5.0
    assert watts.share(5.0, 50.0) == pytest.approx(0.1)


HOVERING = {"vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 5.0}}


@pytest.mark.parametrize(("changes", "why"), [
    ({}, ""),
    (HOVERING, "information grows without end as the image shrinks"),
    ({**HOVERING, "requirements": {"frame_interval_s": 5.0, "min_swath_m": 1.0}}, ""),
    ({"physics": "paper"}, "information needs sharpness, which physics paper does not know"),
])  # fmt: skip
def test_signal_to_noise_is_taken_and_told_where_information_cannot_be_asked(changes: Any, why: str) -> None:
    wanted = mission("best_image").with_changes(**changes)
    assert goal_of(wanted).quality == ("snr_db" if why else "information")
    assert [note.message.startswith(f"Best image is by signal to noise: {why}") for note in taken_instead(wanted)] == (
        [True] if why else []
    )


def test_who_chooses_a_quality_gets_it_or_an_error() -> None:
    by_snr = mission({"best_image": {"of": "snr"}})
    assert goal_of(by_snr).quality == "snr_db" and taken_instead(by_snr.with_changes(**HOVERING)) == []
    with pytest.raises(MissionError, match="information grows without end"):
        check_physical(mission({"best_image": {"of": "information"}}).with_changes(**HOVERING))


# ---------------------------------------------------------------- keys


@pytest.mark.parametrize("given", ["best_image", "Best-Image", {"best_image": None}, {"best image": {}}])
def test_every_spelling_has_the_defaults(given: Any) -> None:
    assert mission(given).to_dict()["objective"] == {
        "best_image": {"of": "auto", "per_w": 0.01, "per_100_usd": 0.01}
    }


def test_a_dumped_mission_loads_again() -> None:
    plain = mission({"best_image": {"of": "snr", "per_w": 0.02}}).to_dict()
    assert load_mission(plain).to_dict() == plain


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"best_image": {"per_watt": 0.01}}, "holds per_watt, which is no key of best_image; did you mean per_w?"),
        ({"best_image": {"per_w": "1 %"}}, "has a wrong per_w; give the share by which one more watt"),
        ({"best_image": {"per_w": -1}}, "has a wrong per_w"),
        ({"best_image": {"of": "colour"}}, "has a wrong of; give the quality of the image"),
        ({"best_image": 3}, "gives best_image no keys; write {best_image: {per_w: 0.01, per_100_usd: 0.01}}"),
        ({"best_image": {}, "power": 1}, "weighs best_image with power"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_told(given: Any, said: str) -> None:
    with pytest.raises(MissionError) as told:
        mission(given)
    assert said in str(told.value)
