"""A front of designs that do not fit, or that time does not reach: known soon, counted, and nothing lost."""

from __future__ import annotations

from itertools import count

import front_cases as fc
import pytest
import random_cases as rc

from uwopt.deadline import Deadline


@pytest.mark.parametrize(("asked_db", "solved"), [(30.0, True), (38.0, False)])
def test_no_curve_is_begun_under_the_sun_where_nothing_fits(asked_db: float, solved: bool) -> None:
    """Cells as wide as all settings do not tell it at 38 dB: without the question both designs were solved in full."""
    wanted = {**fc.WANTED, "min_snr_db": asked_db, "snr_at": "worst"}
    case = fc.in_sun(rc.planted("power", (fc.STEPS, fc.PULSED_ON), wanted))
    search, front = fc.searched(case, ("power", "cost"))
    assert front.complete and bool(len(front.values)) == solved
    assert bool(front.account["evaluated"]) == solved
    assert sum(front.account.values()) == fc.combinations(search.problem)


def test_a_front_that_time_cuts_short_keeps_its_points_and_counts() -> None:
    """Cells of one wave may take longer than all the time there is; time here is how often it is looked at."""
    case, ends = fc.case_of("sun at a level"), list[bool]()
    for looks in (3, 10, 30, 10**9):
        clock = count()
        deadline = Deadline(float(looks), lambda clock=clock: float(next(clock)))
        search, front = fc.searched(case, ("power", "cost"), deadline=deadline)
        ends.append(front.complete)
        assert sum(front.account.values()) == fc.combinations(search.problem)
        assert front.complete or next(clock) <= looks + 10  # nothing goes on for long once it is over
        assert search.trade.deadline is deadline  # which cells of settings look at
    assert ends[0] is False and ends[-1] is True
