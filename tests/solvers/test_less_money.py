"""What costs much less and is little worse, by cameras whose prices and watts are known by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from most_certain import most_certain
from one_of_each import one, with_parts
from random_cases import Case
from test_confidence import FAST, FEW, between, sought_of

from uwopt.results.basis import LessMoney
from uwopt.solvers.confidence.less_money import less_money_in_doubt
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.knee import with_limits
from uwopt.solvers.explain.less_money import less_money

OTHERS_USD = 500.0 + 300.0 + 500.0  # lens, port and lamp
DEAR_USD = 1000.0


def with_cheaper(watts: float, usd: float, **of_it: Any) -> Case:
    """A camera of 3 W for 1000 USD, and another that draws more and costs less."""
    return with_parts(one(wanted=FAST, camera={"power_w": 3.0}), cameras=[{"power_w": watts, "price": usd, **of_it}])


def told(watts: float, usd: float) -> LessMoney | None:
    return less_money(sought_of(with_cheaper(watts, usd)))


def test_a_camera_that_saves_a_quarter_for_a_little_more_power_is_told() -> None:
    """1700 for 2300 USD, for half a watt more."""
    sought = sought_of(with_cheaper(3.5, 400.0))
    found = less_money(sought)
    assert found is not None
    assert found.hardware["camera"] == "camera-0" and found.light_count == 1
    assert (found.price, found.price_of_best) == (OTHERS_USD + 400.0, OTHERS_USD + DEAR_USD)
    assert found.value_of_best == pytest.approx(sought.outcome.best[0].power_w)
    assert found.value == pytest.approx(found.value_of_best + 0.5, rel=1e-6)
    assert found.held is None and found.cost_limit is not None
    asked = with_limits(sought.problem, {"cost": found.cost_limit})  # as the advice says
    best = Search(asked, sought.goal, top=1).whole().best[0]
    assert best.minimised == pytest.approx(found.value, rel=1e-6)


def test_what_saves_little_or_draws_much_more_is_not() -> None:
    """9.6 % of 2300 USD; a camera that draws twice as much as all that shines and sees here."""
    least_w = sought_of(with_cheaper(3.5, 400.0)).outcome.best[0].power_w
    assert told(3.5, 780.0) is None and told(3.5, 760.0) is not None
    assert told(3.0 + 0.26 * least_w, 400.0) is None and told(3.0 + 0.24 * least_w, 400.0) is not None


def test_nothing_is_told_of_goals_that_no_limit_holds() -> None:
    sought = sought_of(with_cheaper(3.5, 400.0))
    case_ = one("cost", wanted=FAST)
    assert less_money(sought_of(case_)) is None
    assert sought.goal.single == "power"


def test_in_doubt_it_holds_as_often_as_asked() -> None:
    """0.284 images/s are asked: a camera of 0.2 to 0.6 is as fast in 91 % of a triangle."""
    sure = with_cheaper(3.4, 400.0, max_frame_rate_hz=100.0)
    unsure = with_cheaper(3.4, 400.0, max_frame_rate_hz=between(0.2, 0.4, 0.6))
    for case_, asked, expected in ((sure, 0.97, True), (unsure, 0.97, False), (unsure, 0.8, True)):
        sought = sought_of(case_, scenarios=FEW)
        choice = most_certain(sought, asked)
        assert choice is not None
        found = less_money_in_doubt(sought, choice)
        assert (found is not None) == expected
        if found is not None:
            assert found.hardware["camera"] == "camera-0" and found.cost_limit is None
            assert found.held is not None and found.held >= asked
            assert found.value == pytest.approx(found.value_of_best + 0.4, rel=1e-6)
            assert found.price == pytest.approx(found.price_of_best - 600.0)
        assert less_money_in_doubt(sought, replace(choice, asked=1.1)) is None  # of what is not certain enough
