"""Half as many lamps that burn twice as long take the same power: a ten-millionth must not decide on their price."""

from __future__ import annotations

import pytest
from one_of_each import one
from reef_of_few import reef_of_few_parts
from test_confidence import sought_of

import uwopt
from uwopt.api.searching import Searches
from uwopt.forward.assembly import load_catalog
from uwopt.objectives.goal import goal_of
from uwopt.solvers.recommend import Sought, with_fewest_lamps


@pytest.fixture(scope="module")
def reef() -> Sought:
    """What the search finds for the reef of few parts: two strobes, which save 20 nW."""
    mission = reef_of_few_parts()
    return Searches(load_catalog(mission), goal_of(mission), 3).of(mission).sought


def test_one_strobe_is_recommended_where_two_do_no_better(reef: Sought) -> None:
    two, few = reef.outcome.best[0], with_fewest_lamps(reef)
    first, *others = few.outcome.best
    assert (two.count, first.count) == (2, 1)
    assert first.minimised == pytest.approx(two.minimised, rel=1e-6)
    assert first.cost == pytest.approx(two.cost - 3300.0, abs=50.0)
    assert first.settings[0]["time_s"] == pytest.approx(2.0 * two.settings[0]["time_s"], rel=1e-3)
    assert others == reef.outcome.best[1:]
    told = uwopt.solve(reef.problem.mission, quick=True)
    assert told.status == "optimal" and told.recommendation is not None
    assert told.recommendation.hardware.light_count == 1


def test_lamps_that_are_needed_stay(reef: Sought) -> None:
    """Where each shines at full for all of the exposure that blur leaves, one alone is too dark."""
    mission = reef.problem.mission
    short = mission.with_changes(limits=mission.to_dict()["limits"] | {"max_exposure_ms": 0.4})
    sought = Searches(load_catalog(short), goal_of(short), 1).of(short).sought
    assert sought.outcome.best[0].count == 2
    assert with_fewest_lamps(sought) is sought


def test_lamps_that_make_it_better_stay() -> None:
    short, dim = {"max_exposure_ms": 0.2}, {"min_snr_db": 1.0}
    sought = sought_of(one("snr_db", vehicle={"light_count": [1, 3]}, limits=short, wanted=dim))
    assert sought.outcome.best[0].count == 3
    assert with_fewest_lamps(sought) is sought


def test_a_goal_that_weighs_the_cost_has_told_them_apart() -> None:
    sought = sought_of(one("cost", vehicle={"light_count": [1, 3]}))
    assert with_fewest_lamps(sought) is sought
