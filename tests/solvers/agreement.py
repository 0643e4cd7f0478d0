"""What it means that the exact search agrees with the enumeration of a random case."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

from random_cases import TOP, Case, ids

from uwopt.forward.problem import Problem
from uwopt.solvers.exact.account import Outcome

BEATEN_REL = 1e-6  # the enumeration may find rounding, nothing more
REACHED_REL = 2e-3  # what its grids of SNR against power may miss


def agree(
    case_: Case, outcome: Outcome, best_of: dict[tuple[int, ...], Any], *, gap_rel: float = 0.0
) -> None:
    """The search's list is the enumeration's, its account adds up, its bound is not beaten.

    gap_rel : what the search may leave open where settings have no closed form
    """
    assert outcome.complete and outcome.account.adds_up()
    assert outcome.account.total == combinations(case_.problem())
    assert len(outcome.best) == min(TOP, len(best_of)), "feasible hardware missed or made up"
    keys = [ids(found) for found in outcome.best]
    assert len(set(keys)) == len(keys)
    first = next(iter(best_of.values()), None)
    room = gap_rel * first.scale if gap_rel and first else room_for_dark(case_, outcome)
    for found, key, place in zip(outcome.best, keys, best_of.values(), strict=False):
        for other in (best_of[key], place):  # the same hardware, and what enumeration puts in this place
            assert found.minimised <= other.value + BEATEN_REL * other.scale + room, f"beaten by {other}"
            assert found.minimised >= other.value - REACHED_REL * other.scale, f"out of reach: {other}"
    if outcome.best and first:
        assert outcome.lower_bound >= outcome.best[0].minimised - max(room, 1e-12 * first.scale)
        assert outcome.lower_bound <= first.value + BEATEN_REL * first.scale, f"bound beaten by {first}"
        assert outcome.lower_bound <= outcome.best[0].minimised
    values = [found.minimised for found in outcome.best]
    assert all(a <= b + 1e-9 * abs(b) for a, b in pairwise(values))


def room_for_dark(case_: Case, outcome: Outcome) -> float:
    """What may be left of the optimum where SNR counts and sensors have dark current: 0.005 dB.

    Exposure and dark current are not optimised together then, and the certificate's lower bound says so.
    Everywhere else the gap is closed.
    """
    dark = any(part.dark_current_e_s and part.dark_current_e_s.value > 0 for part in case_.parts.cameras)
    if case_.objective.weight("snr_db") and dark:
        return 0.005 * case_.objective.weight("snr_db")
    assert not outcome.best or outcome.lower_bound == outcome.best[0].minimised
    return 0.0


def combinations(problem: Problem) -> int:
    """All combinations of a problem."""
    low, high = problem.count_range
    sizes = [len(getattr(problem.parts, kind)) for kind in ("cameras", "lenses", "ports", "lights")]
    return (
        math.prod(sizes) * (high - low + 1) * len(problem.mounts) * len(problem.mission.vehicle.orientations)
    )
