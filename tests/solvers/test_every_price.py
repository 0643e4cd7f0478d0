"""What `explain` says of every requirement where something fits: held against solving the mission anew with another."""

from __future__ import annotations

from dataclasses import replace

import pytest
from reef_of_few import reef_of_few_parts

import uwopt
from uwopt.api.pricing import every_price
from uwopt.api.searching import Searches
from uwopt.deadline import NEVER
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import Mission
from uwopt.objectives.goal import goal_of
from uwopt.report.text.prices import requirement_price_text
from uwopt.results.basis import Price
from uwopt.results.result import Result
from uwopt.solvers.explain.prices import prices
from uwopt.solvers.recommend import design_of

LOOSE = {"cost", "power_w"}  # limits that keep nothing better out


@pytest.fixture(scope="module")
def reef() -> Mission:
    """The reef with few parts and one altitude, and pixels small enough to keep the better camera out."""
    return reef_of_few_parts()


@pytest.fixture(scope="module")
def solved(reef: Mission) -> Result:
    """The reef with the prices of all that is asked, however long that takes."""
    result, goal = uwopt.solve(reef, confidence="central", quick=True), goal_of(reef)
    sought = Searches(load_catalog(reef), goal, 5).of(reef).sought
    prices, complete = every_price(result, sought, NEVER)
    assert complete
    return replace(result, prices=prices)


@pytest.fixture(scope="module")
def told(solved: Result) -> dict[str, Price]:
    """What everything costs, by key."""
    return {price.name: price for price in solved.prices}


def optimum(mission: Mission) -> float | None:
    """Least power; None where nothing fits."""
    return uwopt.solve(mission, confidence="central", quick=True, explain=False).objective.value


def asking(reef: Mission, key: str, value: float | None) -> Mission:
    """The reef with one other requirement or limit, or without it."""
    section = "limits" if key in LOOSE else "requirements"
    return reef.with_changes(**{section: reef.to_dict()[section] | {key: value}})


def test_every_requirement_has_a_price(told):
    asked = {"min_snr_db", "overlap", "max_gsd_mm", "min_dof_m", "max_blur_px", "cost", "power_w", "speed_m_s"}
    assert set(told) == asked
    assert told["min_snr_db"].free_until is None  # it binds


@pytest.mark.parametrize("key", ["max_blur_px", "max_gsd_mm", "min_dof_m", "power_w"])
def test_up_to_where_it_is_said_to_cost_nothing_it_costs_nothing(reef, solved, told, key):
    free = told[key].free_until
    assert free is not None and (free - told[key].asked) * told[key].step > 0.0
    assert optimum(asking(reef, key, free)) == pytest.approx(solved.objective.value, rel=2e-4)


@pytest.mark.parametrize("key", ["min_snr_db", "overlap", "max_gsd_mm", "max_blur_px"])
def test_what_is_told_to_do_without_a_requirement_is_the_optimum_without_it(reef, solved, told, key):
    left = 0.0 if key == "min_snr_db" else None  # so much that something is seen
    value = optimum(asking(reef, key, left))
    assert told[key].without == pytest.approx(value, rel=2e-4)
    assert (value < 0.9 * solved.objective.value) == (key in ("min_snr_db", "overlap"))


def test_a_figure_that_the_system_barely_reaches_is_told_on_the_side_that_it_reaches(reef, solved, told):
    """0.862734 mm are reached: 0.863 mm may be asked for at no cost, 0.862 mm may not."""
    reached = next(m.value for m in solved.recommendation.scenes[0].margins if m.requirement == "max_gsd_mm")
    assert reached <= told["max_gsd_mm"].free_until < reached * 1.01


def test_sentences_tell_what_is_free_and_what_would_be_best_without(solved):
    free = Price("max_blur_px", "px", 1.0, -0.1, 0.0, 0.0, free_until=0.226, without=solved.objective.value)
    assert requirement_price_text(solved, free) == (
        "0.100 px less motion blur (max_blur_px, now 1.00 px): nothing, up to 0.226 px; nothing would be better "
        "without it"
    )
    dear = Price("min_snr_db", "db", 30.0, 1.0, 0.4, 0.4, without=1.38)
    assert requirement_price_text(solved, dear).endswith("+0.400 W; without it 1.38 W in all")


@pytest.mark.parametrize(("less_db", "frame_binds"), [(1.0, False), (0.3, True)])
def test_signal_to_noise_of_mean_and_frame_has_its_price_by_either(reef, less_db, frame_binds):
    """The frame reaches 0.53 dB less than its mean: whichever of both binds, what is told is another optimum."""
    asked = {**reef.to_dict()["requirements"], "snr_at": "worst", "snr_at_less_db": less_db}
    wanted = reef.with_changes(requirements=asked)
    goal = goal_of(wanted)
    sought = Searches(load_catalog(wanted), goal, 5).of(wanted).sought
    winner = design_of(sought, sought.outcome.best[0])
    told = {price.name: price for price in prices(sought, winner, (), NEVER)}
    before, snr_db = sought.outcome.best[0].power_w, 1.0 + told["min_snr_db"].asked
    more = optimum(wanted.with_changes(requirements=asked | {"min_snr": None, "min_snr_db": snr_db}))
    assert told["min_snr_db"].change == pytest.approx(more - before, rel=1e-3) and more > before
    assert ("snr_at_less_db" in told) is frame_binds
    if frame_binds:
        all_of_it = optimum(wanted.with_changes(requirements=asked | {"snr_at_less_db": 0.0}))
        assert told["snr_at_less_db"].change == pytest.approx(all_of_it - before, rel=1e-3) and all_of_it > before
    every = {price.name: price for price in prices(sought, winner, (), NEVER, every=True)}
    free_db = every["snr_at_less_db"].free_until
    assert (free_db is None) is frame_binds
    if free_db is not None:
        assert optimum(wanted.with_changes(requirements=asked | {"snr_at_less_db": free_db})) == pytest.approx(before)
        less_still = optimum(wanted.with_changes(requirements=asked | {"snr_at_less_db": 0.98 * free_db}))
        assert less_still > before * (1.0 + 1e-4)
