"""Stereo pairs: the search against enumeration with the cameras' places drawn, and outlines against their imagers."""

from __future__ import annotations

import pytest
from agreement import agree
from random_cases import CASES, Case, case, enumerated, in_batches, ranked
from test_large import outlines_hold
from thorough import drawn

from uwopt.solvers.exact.imagers import enumerate_imagers

SOME = drawn((14, 35), CASES)


@pytest.mark.parametrize(("batches", "seed"), in_batches(SOME), indirect=["batches"])
def test_search_of_stereo_pairs_equals_enumeration(batches: str, seed: int) -> None:
    made = case(seed, paired=True)
    agree(made, made.solve()[1], ranked(enumerated(seed, paired=True)))


def wanted_of(made: Case) -> tuple[float | None, float | None]:
    wanted = made.problem().mission.requirements
    return wanted.min_common_swath_m, wanted.max_depth_error_mm


@pytest.mark.parametrize("seed", drawn((14, 29, 35, 57), tuple(range(300))))
def test_outlines_of_stereo_pairs_bound_their_imagers(seed: int) -> None:
    outlines_hold(case(seed, paired=True).problem())


def test_both_rules_of_pairs_discard_imagers_in_these_cases() -> None:
    """Else the cases would say nothing of them."""
    lost = dict.fromkeys(("min_common_swath_m", "max_depth_error_mm"), 0)
    for seed in (14, 35):
        found = enumerate_imagers(case(seed, paired=True).problem()).tally.discarded
        lost = {rule: count + found[rule] for rule, count in lost.items()}
    assert all(lost.values()), lost
