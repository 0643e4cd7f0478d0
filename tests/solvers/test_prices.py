"""A step more of a requirement costs what the same system takes for it; CasADi's multiplier agrees with differences."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest
from reef_of_few import reef_of_few_parts

import uwopt
from uwopt.api.pricing import range_price, range_prices
from uwopt.api.searching import Searches
from uwopt.api.varied import Systems
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import Mission
from uwopt.mission.varying import VariedMission
from uwopt.objectives.goal import goal_of
from uwopt.objectives.objective import Objective
from uwopt.report.text.prices import requirement_price_text, short_price_sentence
from uwopt.results.basis import Price
from uwopt.results.result import Result
from uwopt.solvers.explain.prices import priced_keys, step_of, what_it_costs
from uwopt.solvers.warm.searches import Warm


@pytest.fixture(scope="module")
def reef() -> Mission:
    """The reef with few parts and one altitude."""
    return reef_of_few_parts()


@pytest.fixture(scope="module")
def solved(reef: Mission) -> Result:
    return uwopt.solve(reef)


def with_speed(reef: Mission, speed_m_s: float) -> Mission:
    """The reef at another speed."""
    return reef.with_changes(vehicle=reef.to_dict()["vehicle"] | {"speed_m_s": speed_m_s})


def changed(reef: Mission, speed_m_s: float) -> float:
    """The optimum at another speed."""
    value = uwopt.solve(with_speed(reef, speed_m_s), quick=True).objective.value
    assert value is not None
    return value


def test_slope_of_snr_is_the_multiplier(solved):
    price = next(price for price in solved.prices if price.name == "min_snr_db")
    assert price.slope_casadi == pytest.approx(price.slope, rel=1e-3)  # IPOPT's barrier, and the difference's curvature


def test_speed_costs_what_the_lamps_draw_more(solved):
    """Flashes come as often as images: by hand, a tenth more speed is a tenth more light's power."""
    price = next(price for price in solved.prices if price.name == "speed_m_s")
    light_w = solved.recommendation.totals.light_power_w
    assert price.change == pytest.approx(light_w * price.step / price.asked, rel=1e-6)


def test_slopes_are_those_of_the_steps_where_the_objective_is_a_straight_line(solved):
    """Light's power is proportional to the speed, so that slope times step is what the step costs."""
    price = next(price for price in solved.prices if price.name == "speed_m_s")
    assert price.slope * price.step == pytest.approx(price.change, rel=1e-4)


def test_prices_over_a_range_are_those_of_searches_of_their_own(reef, solved):
    base, best = VariedMission(reef, {}), solved.objective.value
    (asked,) = (key for key in priced_keys(reef, solved.recommendation) if key[0].name == "speed_m_s")
    told = range_price(base, asked[0], 0.5, 0.2, Systems(goal_of(reef)), Warm())
    assert told is not None and told.until is not None
    assert changed(reef, 0.7) - best == pytest.approx(told.change, rel=1e-4)
    assert 0.5 < told.until < 1.3
    beyond = uwopt.solve(with_speed(reef, told.until + 0.005), quick=True).recommendation
    before = uwopt.solve(with_speed(reef, told.until - 0.005), quick=True).recommendation
    bought = [(one.hardware.ids, one.hardware.light_count) for one in (before, solved.recommendation, beyond)]
    assert bought[0] == bought[1] != bought[2]
    assert all(one in told.then for one in beyond.hardware.ids)


def test_a_search_that_is_known_changes_no_price_and_spares_its_own(reef, solved):
    goal = goal_of(reef)
    sought = Searches(load_catalog(reef), goal, 5).of(reef).sought
    anew, known = Warm(), Warm()
    known.take(sought)
    (family,) = known.families.values()
    assert family.waiting is not None and family.waiting[1] is sought
    told = [warm.best(with_speed(reef, 0.6)) for warm in (anew, known)]
    assert [one.kept for one in told] == [False, True]
    assert told[0].found.minimised == pytest.approx(told[1].found.minimised, rel=1e-6)
    plain = range_prices(reef, solved)
    for ours, theirs in zip(range_prices(reef, solved, sought=sought), plain, strict=True):
        assert (ours.name, ours.until, ours.then) == (theirs.name, theirs.until, theirs.then)
        assert ours.change == pytest.approx(theirs.change, rel=1e-4)


def test_what_is_not_the_central_optimum_keeps_the_prices_of_its_own(reef, solved):
    """Certainty may recommend another system: no search over a range is about that."""
    dearer = replace(solved, objective=replace(solved.objective, value=1.1 * solved.objective.value))
    assert range_prices(reef, dearer) == solved.prices


@pytest.mark.parametrize(
    ("goal", "there", "price"),
    [("power", 5.5, 0.5), ("power", 4.8, 0.0), ("power", None, None), ("snr_db", 4.8, -0.2), ("snr_db", 5.5, 0.0)],
)  # fmt: skip
def test_what_more_is_asked_for_costs_nothing_where_other_parts_are_better(goal, there, price):
    """5 W or dB where it is asked; better, as where one more kind of part is made then."""
    assert what_it_costs(5.0, there, Objective.of(goal)) == (None if price is None else pytest.approx(price))


def test_the_first_page_tells_what_asking_for_more_costs(solved):
    told = replace(solved, prices=[
        Price("min_snr_db", "db", 30.0, 1.0, 0.4), Price("speed_m_s", "m_s", 0.5, 0.05, 0.09, until=0.7, then="a + b"),
        Price("max_gsd_mm", "mm", 1.0, -0.1, 0.0), Price("frame_interval_s", "s", 2.0, -0.2, 0.1, until=1.5),
    ])  # fmt: skip
    assert short_price_sentence(told) == (
        "1 dB more signal to noise: +0.400 W; 0.05 m/s faster: +0.0900 W, beyond 0.700 m/s another system; "
        "0.2 s shorter between images: +0.100 W, beyond 1.50 s nothing fits."
    )
    assert short_price_sentence(replace(told, prices=told.prices[2:3])) == ""


def test_a_limit_from_above_gets_less_and_one_from_below_more(reef):
    names = ("min_snr_db", "max_gsd_mm", "cost", "overlap", "light_level_max", "frame_interval_s")
    margins = [SimpleNamespace(requirement=name, binding=True) for name in names]
    winner = SimpleNamespace(margins=margins)
    steps = {key.name: step for key, _, step in priced_keys(reef, winner)}
    assert steps == {"min_snr_db": 1.0, "max_gsd_mm": -0.1, "cost": -800, "overlap": 0.06, "speed_m_s": 0.05}


@pytest.mark.parametrize(
    ("key", "asked", "step"), [("min_snr_db", 30.0, 1.0), ("speed_m_s", 0.5, 0.05), ("cost", 8000.0, 800.0)]
)
def test_steps_are_such_as_a_person_takes(key, asked, step):
    assert step_of(key, asked) == pytest.approx(step)


def test_sentences_tell_step_change_and_what_takes_over(solved):
    price = Price("min_snr_db", "db", 30.0, 1.0, 0.4, until=31.2, then="a + b + c + 2 x d")
    text = requirement_price_text(solved, price)
    assert text.startswith("1.00 dB more signal to noise (min_snr_db, now 30.0 dB): +0.400 W")
    assert "beyond 31.2 dB another system: a + b + c + 2 x d" in text
    assert "nothing fits" in requirement_price_text(solved, Price("min_snr_db", "db", 30.0, 1.0, None, until=30.4))
