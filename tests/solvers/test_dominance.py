"""Dominance against its definition: all pairs, closed forms and inclusion-exclusion; nothing of moocore here."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt.objectives import dominance
from uwopt.objectives.axes import Axes, Frame
from uwopt.objectives.dominance import (
    BestPoints,
    Staircase,
    clearly,
    hypervolume,
    igd_plus,
    nondominated,
    would_add,
)

SMALL = st.sampled_from([-3.0, -1.0, 0.0, 0.5, 1.0, 2.0])  # few values: ties and duplicates
ANY = st.floats(-1e3, 1e3, width=32)


def points(width, numbers=SMALL, least=0, most=25):
    """Arrays (n, width)."""
    row = st.tuples(*[numbers] * width)
    return st.lists(row, min_size=least, max_size=most).map(
        lambda rows: np.array(rows, float).reshape(-1, width)
    )


WIDE = st.sampled_from([2, 3])
TWO_SETS = WIDE.flatmap(
    lambda w: st.tuples(points(w, st.one_of(SMALL, ANY)), points(w, st.one_of(SMALL, ANY)))
)


def plain_front(values):
    """Rows that no other dominates, of equal rows the first, by all pairs."""
    kept = []
    for i, one in enumerate(values):
        beaten = any((other <= one).all() and (other < one).any() for other in values)
        kept.append(not beaten and not any((values[j] == one).all() for j in range(i)))
    return np.array(kept, bool)


@given(values=WIDE.flatmap(lambda w: points(w, st.one_of(SMALL, ANY))))
def test_nondominated_equals_all_pairs(values):
    assert nondominated(values).tolist() == plain_front(values).tolist()


@given(both=TWO_SETS)
def test_beats_equals_all_pairs(both):
    found, bounds = both
    archive = BestPoints(bounds.shape[1])
    archive.add(found)
    expected = [any((one <= bound + 1e-9 * np.abs(bound)).all() for one in found) for bound in bounds]
    assert archive.beats(bounds).tolist() == expected


@given(both=TWO_SETS)
def test_dominates_is_better_in_every_objective_by_more_than_a_tie(both):
    found, values = both
    archive = BestPoints(values.shape[1])
    archive.add(found)
    expected = [any((one <= value - 1e-9 * np.abs(value)).all() for one in found) for value in values]
    assert archive.dominates(values).tolist() == expected


@given(both=TWO_SETS, axis=st.integers(0, 1))
def test_best_is_the_least_over_points_no_worse_elsewhere(both, axis):
    found, bounds = both
    archive = BestPoints(bounds.shape[1])
    archive.add(found)
    others = [k for k in range(bounds.shape[1]) if k != axis]
    expected = [
        min((one[axis] for one in found if (one <= b + 1e-9 * np.abs(b))[others].all()), default=np.inf)
        for b in bounds
    ]
    assert archive.best(bounds, axis).tolist() == expected


@given(both=TWO_SETS)
def test_archive_in_parts_is_the_archive_of_all(both):
    one, other = both
    archive = BestPoints(one.shape[1])
    archive.add(one)
    archive.beats(other)  # the table that this makes must not outlive the next points
    archive.add(other)
    every = np.concatenate([one, other])
    assert sorted(archive.values.tolist()) == sorted(every[plain_front(every)].tolist())
    assert archive.beats(every).all()


@given(values=points(3, least=1), bounds=points(3))
def test_every_order_of_columns_gives_the_same_table(values, bounds):
    expected = [any((v <= b).all() for v in values) for b in bounds]
    for last in (None, 0, 1, 2):
        assert Staircase.of(values, last).reached(bounds).tolist() == expected


def test_nothing_beats_and_nothing_is_beaten_when_empty():
    archive = BestPoints(3)
    archive.add(np.empty((0, 3)))
    assert archive.beats(np.zeros((2, 3))).tolist() == [False, False]
    assert archive.dominates(np.zeros((2, 3))).tolist() == [False, False]
    assert archive.best(np.zeros((2, 3)), 0).tolist() == [np.inf, np.inf]
    assert nondominated(np.empty((0, 2))).shape == (0,)


# ---------------------------------------------------------------- hypervolume


def plain_frame(width):
    """Linear axes from 0 to 1: the reference is at 1.1."""
    return Frame(np.zeros(width, bool), np.zeros(width), np.ones(width))


def volume_by_inclusion_exclusion(values, reference):
    """Volume of a union of boxes, each from a point to the reference, by the sum over all subsets."""
    total = 0.0
    for size in range(1, len(values) + 1):
        for some in combinations(range(len(values)), size):
            total += (-1.0) ** (size + 1) * np.prod(
                np.maximum(reference - values[list(some)].max(axis=0), 0.0)
            )
    return total


@given(values=WIDE.flatmap(lambda w: points(w, st.floats(0.0, 1.3), most=7)))
def test_hypervolume_equals_inclusion_exclusion(values):
    frame = plain_frame(values.shape[1])
    expected = volume_by_inclusion_exclusion(values, frame.reference) / np.prod(frame.reference)
    assert hypervolume(values, frame) == pytest.approx(expected, abs=1e-12)


NEAR_BOX = st.one_of(st.floats(-0.2, 1.3), st.sampled_from([0.0, 0.5, 1.0]))  # ties too, and what is outside


@given(both=WIDE.flatmap(lambda w: st.tuples(points(w, NEAR_BOX, most=6), points(w, NEAR_BOX, most=4))))
def test_what_a_corner_would_add_is_the_difference_of_two_unions(both):
    found, corners = (np.maximum(values, 0.0) for values in both)
    frame = plain_frame(found.shape[1])
    alone = volume_by_inclusion_exclusion(found, frame.reference)
    expected = [
        volume_by_inclusion_exclusion(np.vstack([found, corner]), frame.reference) - alone for corner in corners
    ]
    assert would_add(*both, frame) * np.prod(frame.reference) == pytest.approx(np.array(expected), abs=1e-12)


def test_a_corner_adds_in_every_slab_until_points_are_as_good():
    # by hand, of 1.1^3 = 1.331: the points span 1.1 * 0.6^2 + 0.6 * 0.85^2 - 0.6^3 = 0.6135; the second corner spans
    # 1.1 * 0.7 * 0.5, of which 1.1 * 0.6 * 0.5 + 0.6 * 0.7 * 0.5 - 0.6 * 0.6 * 0.5 = 0.36 is theirs already
    found = np.array([[0.0, 0.5, 0.5], [0.5, 0.25, 0.25]])
    corners = np.array([[0.0, 0.0, 0.0], [0.0, 0.4, 0.6]])
    added = would_add(found, corners, plain_frame(3)) * 1.331
    assert added == pytest.approx([1.331 - 0.6135, 0.385 - 0.36])


def test_hypervolume_of_one_point_and_of_a_staircase():
    # a point at the worst corner leaves (0.1/1.1)^2; two points at (0, 1) and (1, 0): 2 * 1.1 * 0.1 - 0.1^2 of 1.21
    assert hypervolume(np.array([[1.0, 1.0]]), plain_frame(2)) == pytest.approx((0.1 / 1.1) ** 2)
    assert hypervolume(np.array([[0.0, 1.0], [1.0, 0.0]]), plain_frame(2)) == pytest.approx(0.21 / 1.21)
    assert hypervolume(np.array([[0.0, 0.0, 0.0]]), plain_frame(3)) == pytest.approx(1.0)


def test_hypervolume_ignores_what_is_beyond_the_reference_and_clips_what_is_better_than_ideal():
    frame = plain_frame(2)
    assert hypervolume(np.array([[0.0, 1.2]]), frame) == 0.0
    assert hypervolume(np.empty((0, 2)), frame) == 0.0
    assert hypervolume(np.array([[-5.0, 0.0]]), frame) == pytest.approx(1.0)


@given(values=points(3, st.floats(0.0, 1.2), most=12), more=points(3, st.floats(0.0, 1.2), most=3))
def test_hypervolume_never_shrinks_with_more_points_and_needs_the_front_alone(values, more):
    frame, every = plain_frame(3), np.concatenate([values, more])
    assert hypervolume(every, frame) >= hypervolume(values, frame) - 1e-12
    assert hypervolume(every[plain_front(every)], frame) == pytest.approx(
        hypervolume(every, frame), abs=1e-12
    )


def test_hypervolume_is_the_same_in_other_units():
    values = np.array([[10.0, 900.0], [20.0, 400.0], [80.0, 100.0]])
    axes = Axes.of(["power", "cost"])
    other = values * [1000.0, 7.5]  # mW, and another currency
    assert hypervolume(values, Frame.of(axes, values)) == pytest.approx(
        hypervolume(other, Frame.of(axes, other))
    )


# ---------------------------------------------------------------- distance


def test_igd_plus_by_hand():
    # front (0, 1) and (1, 0); the point (0.5, 1): worse by (0.5, 0) than the first, by (0, 1) than the second
    front = np.array([[0.0, 1.0], [1.0, 0.0]])
    assert igd_plus(np.array([[0.5, 1.0]]), front, plain_frame(2)) == pytest.approx((0.5 + 1.0) / 2)


def test_igd_plus_of_the_front_itself_and_of_something_better_is_zero():
    front = np.array([[0.0, 1.0], [1.0, 0.0]])
    assert igd_plus(front, front, plain_frame(2)) == 0.0
    assert igd_plus(np.array([[-1.0, -1.0]]), front, plain_frame(2)) == 0.0


def test_igd_plus_without_points_is_unknown():
    front, nothing = np.array([[0.0, 1.0]]), np.empty((0, 2))
    assert igd_plus(nothing, front, plain_frame(2)) is None
    assert igd_plus(front, nothing, plain_frame(2)) is None


# ---------------------------------------------------------------- the last digits


def test_a_run_of_small_steps_keeps_its_far_end():
    # 200 steps of 1e-4 in quality are 2 %: far more than the 2e-4 that mean nothing
    step = np.arange(201)
    values = np.column_stack([1.0 + 0.01 * step, -(1.0 + 1e-4 * step)])
    kept = values[clearly(values, np.array([1e-6, 2e-4]))]
    assert kept[:, 1].min() <= -1.02 * (1.0 - 2e-4)
    assert 50 <= len(kept) <= 101


@given(values=WIDE.flatmap(lambda w: points(w, st.floats(0.99, 1.01), most=40)))
def test_what_clearly_leaves_out_is_stood_for_by_what_stays(values):
    rel = np.full(values.shape[1], 1e-3)
    mask = clearly(values, rel)
    assert not (mask & ~plain_front(values)).any()
    for row in values[plain_front(values) & ~mask]:
        assert (values[mask] <= row + rel * np.abs(row)).all(axis=1).any()


@pytest.mark.parametrize("at_once", [3, 10**6])
@given(values=WIDE.flatmap(lambda w: points(w, st.sampled_from(np.linspace(0.99, 1.01, 33).tolist()), most=40)))
def test_pairs_that_clearly_beat_are_those_of_all_pairs(at_once, values):
    rel = np.geomspace(1e-4, 3e-3, values.shape[1])
    front = values[plain_front(values)]
    slack = rel * np.abs(front)
    every = [
        (mine, other)
        for mine, point in enumerate(front)
        for other, beside in enumerate(front)
        if (beside <= point + slack[mine]).all() and (beside < point - slack[mine]).any()
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dominance, "PAIRS", at_once)
        loser, winner = dominance._clearly_beaten(front, slack)
    assert list(zip(loser.tolist(), winner.tolist(), strict=True)) == every


def test_points_that_differ_by_enough_all_stay():
    values = np.array([[1.0, 3.0], [2.0, 2.0], [3.0, 1.0]])
    assert clearly(values, np.array([1e-6, 2e-4])).all()


def test_a_point_that_wins_by_its_last_digits_goes():
    values = np.array([[1.0, -10.0], [5.0, -10.0000001]])
    assert clearly(values, np.full(2, 1e-6)).tolist() == [True, False]
