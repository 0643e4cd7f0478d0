"""Half as many lamps that burn twice as long take the same power: a ten-millionth must not decide on their price."""

from __future__ import annotations

import pytest
from one_of_each import one
from reef_of_few import reef_of_few_parts
from test_confidence import sought_of

import uwopt
from uwopt.api.searching import Searches
from uwopt.forward.assembly import load_catalog
from uwopt.forward.lamps import Mount
from uwopt.objectives.goal import goal_of
from uwopt.solvers.recommend import Sought, with_fewest_lamps


@pytest.fixture(scope="module")
def reef() -> Sought:
    """What the search finds for the reef of few parts and any budget: four strobes, which save 0.1 uW."""
    base = reef_of_few_parts()
    mission = base.with_changes(limits=base.to_dict()["limits"] | {"cost": 30_000.0})
    return Searches(load_catalog(mission), goal_of(mission), 3).of(mission).sought


def test_one_strobe_a_side_is_recommended_where_two_do_no_better(reef: Sought) -> None:
    four, few = reef.outcome.best[0], with_fewest_lamps(reef)
    first, *others = few.outcome.best
    assert (four.count, first.count) == (4, 2)  # one alone takes the same power, from one side
    assert first.minimised == pytest.approx(four.minimised, rel=1e-6)
    assert first.cost == pytest.approx(four.cost - 6600.0, abs=50.0)
    assert first.settings[0]["time_s"] == pytest.approx(2.0 * four.settings[0]["time_s"], rel=1e-3)
    assert [one.count for one in others] == [2 for _ in reef.outcome.best[1:]]  # so that prices compare
    told = uwopt.solve(reef.problem.mission, quick=True)
    assert told.status == "optimal" and told.recommendation is not None
    assert told.recommendation.hardware.light_count == 2


def test_from_one_place_no_number_is_lopsided() -> None:
    beside, ahead = Mount(baseline_m=0.5), Mount()
    assert [beside.is_lopsided(count) for count in (1, 2, 3)] == [True, False, True]
    assert not ahead.is_lopsided(1)


def test_lamps_that_are_needed_stay(reef: Sought) -> None:
    """Where each shines at full for all of the exposure that blur leaves, one alone is too dark."""
    mission = reef.problem.mission
    short = mission.with_changes(limits=mission.to_dict()["limits"] | {"max_exposure_ms": 0.2})
    sought = Searches(load_catalog(short), goal_of(short), 1).of(short).sought
    assert sought.outcome.best[0].count == 4
    assert with_fewest_lamps(sought) is sought


def test_lamps_that_make_it_better_stay() -> None:
    short, dim = {"max_exposure_ms": 0.2}, {"min_snr_db": 1.0}
    sought = sought_of(one("snr_db", vehicle={"light_count": [1, 3]}, limits=short, wanted=dim))
    assert sought.outcome.best[0].count == 3
    assert with_fewest_lamps(sought) is sought


def test_a_goal_that_weighs_the_cost_has_told_them_apart() -> None:
    sought = sought_of(one("cost", vehicle={"light_count": [1, 3]}))
    assert with_fewest_lamps(sought) is sought
