"""Systems that estimates cannot tell apart, from cameras that differ by their price alone."""

from __future__ import annotations

from typing import Any

import pytest
from one_of_each import one, with_parts

from uwopt.catalog.parts.quantity import Quantity
from uwopt.deadline import Deadline, OutOfTimeError
from uwopt.solvers.explain import robustness as module
from uwopt.solvers.explain.robustness import equals
from uwopt.solvers.recommend import Sought

Ends = tuple[float, float, float]
FAST = {"max_blur_px": 1.0, "min_snr_db": 26.0}


def price(ends: Ends) -> dict[str, Any]:
    """A price from its low end to its high one, estimated where they differ."""
    low, value, high = ends
    return {"price": Quantity(value, low, high, "estimated" if high > low else "published")}


def of_three(*rivals: Ends) -> Sought:
    """A search among a camera of 900 to 1500 and these."""
    cameras = [price(rival) for rival in rivals]
    case_ = with_parts(one("cost", wanted=FAST, camera=price((900.0, 1000.0, 1500.0))), cameras=cameras)
    search, outcome = case_.solve(top=3)
    assert len(outcome.best) == 3
    return Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]


def told(winner: Ends, rival: Ends, objective: str = "cost") -> list[dict[str, Any]]:
    """What is said of two cameras of these prices."""
    case_ = with_parts(one(objective, wanted=FAST, camera=price(winner)), cameras=[price(rival)])
    search, outcome = case_.solve(top=2)
    assert len(outcome.best) == 2
    return equals(Sought(None, search.problem, search, outcome))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("winner", "rival", "toss"),
    [
        ((900.0, 1000.0, 1500.0), (950.0, 1100.0, 1200.0), True),  # either may be the cheaper one
        ((900.0, 1000.0, 1050.0), (950.0, 1100.0, 1200.0), False),  # 1000 is never 1100
        ((900.0, 1000.0, 1500.0), (1050.0, 1100.0, 1200.0), False),  # 1100 is never 1000
        ((1000.0, 1000.0, 1000.0), (1000.0, 1000.0, 1000.0), True),  # both are quoted at the same price
        ((1000.0, 1000.0, 1000.0), (1001.0, 1001.0, 1001.0), False),
    ],
)
def test_a_choice_is_a_toss_where_each_may_be_the_other(winner: Ends, rival: Ends, toss: bool) -> None:
    assert [item["runner_up"] for item in told(winner, rival)] == ([0] if toss else [])


def test_the_ends_are_those_of_the_parts_that_differ() -> None:
    (item,) = told((900.0, 1000.0, 1500.0), (950.0, 1100.0, 1200.0))
    assert item["value"] - item["best"] == pytest.approx(150.0)
    assert item["recommendation_at_worst"] - item["value"] == pytest.approx(400.0)


def test_what_time_does_not_reach_is_told_and_what_it_reached_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    sought = of_three((950.0, 1100.0, 1200.0), (950.0, 1200.0, 1300.0))
    assert [item["runner_up"] for item in equals(sought)] == [0, 1]
    whole, asked = module.with_ends, []

    def two_of_four(*given: Any) -> float:
        asked.append(given)
        if len(asked) > 2:
            raise OutOfTimeError
        return whole(*given)

    monkeypatch.setattr(module, "with_ends", two_of_four)
    deadline = Deadline()
    assert [item["runner_up"] for item in equals(sought, deadline)] == [0]
    assert deadline.left_out == [module.UNREACHED]


def test_what_was_chosen_over_scenarios_is_tied_with_what_these_cannot_tell_apart() -> None:
    sought = of_three((950.0, 1100.0, 1200.0), (950.0, 1200.0, 1300.0))
    second = sought.outcome.best[1]
    assert [item["runner_up"] for item in equals(sought, tied=lambda found: found is second)] == [0]
    assert equals(sought, tied=lambda found: False) == []
