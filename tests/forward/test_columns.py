"""Columns: gathered, joined and put back as NumPy does it with a single array."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from uwopt.forward.columns import Columns, PartColumns, distinct, each_once, groups_alike, rows_alike


@dataclass(frozen=True)
class Inner(Columns):
    pixel: np.ndarray  # (n, n_altitudes, n_pixels)


@dataclass(frozen=True)
class Record(Columns):
    value: np.ndarray
    inner: Inner
    absent: np.ndarray | None
    scenes: list[Inner]
    shared: float = 2.0


@dataclass(frozen=True)
class Parts(PartColumns):
    mass: np.ndarray
    levels: np.ndarray  # (n, n_levels)


def record(n: int, first: int, depth: int = 3) -> Record:
    pixel = 100.0 * np.arange(first, first + n)[:, None, None] + np.arange(depth)[None, None, :] * np.ones(
        (1, 2, 1)
    )
    return Record(np.arange(first, first + n), Inner(pixel), None, [Inner(pixel), Inner(-pixel)])


def test_rows_are_gathered_in_nested_columns_and_lists():
    got = record(5, 0).take(np.array([4, 1]))
    assert got.value.tolist() == [4, 1]
    assert got.inner.pixel[:, 0, 0].tolist() == [400.0, 100.0]
    assert got.scenes[1].pixel[:, 1, 2].tolist() == [-402.0, -102.0]
    assert got.absent is None
    assert got.shared == 2.0


def test_taking_all_rows_of_joined_parts_gives_the_parts_back():
    one, two = record(2, 0), record(3, 7)
    both = Record.joined([one, two])
    assert both.value.tolist() == [0, 1, 7, 8, 9]
    assert both.value.dtype == one.value.dtype
    assert np.array_equal(both.take(slice(2, 5)).scenes[0].pixel, two.scenes[0].pixel)


def test_a_part_with_fewer_pixels_repeats_its_last():
    both = Record.joined([record(1, 0, depth=2), record(1, 1, depth=4)])
    assert both.inner.pixel[0, 0].tolist() == [0.0, 1.0, 1.0, 1.0]
    assert both.inner.pixel[1, 0].tolist() == [100.0, 101.0, 102.0, 103.0]


def test_groups_come_back_to_their_places():
    whole = record(4, 0)
    even, odd = np.array([0, 2]), np.array([1, 3])
    back = Record.in_places([(odd, whole.take(odd)), (even, whole.take(even))], 4)
    assert np.array_equal(back.value, whole.value)
    assert np.array_equal(back.inner.pixel, whole.inner.pixel)


def test_put_replaces_rows_of_a_copy():
    whole = record(3, 0)
    changed = whole.put(np.array([1]), record(1, 9))
    assert changed.value.tolist() == [0, 9, 2]
    assert whole.value.tolist() == [0, 1, 2]


@pytest.mark.parametrize("row", [0, 2])
def test_every_row_is_scaled_by_its_own_factor(row):
    scaled = record(3, 1).scaled(np.array([2.0, 3.0, 5.0]))
    assert scaled.inner.pixel[row, 0, 0] == 100.0 * (row + 1) * [2.0, 3.0, 5.0][row]


def test_columns_of_parts_are_those_of_the_rows_that_were_taken():
    parts, rows = Parts(np.array([3.0, 5.0, 7.0]), np.array([[1.0], [2.0], [4.0]])), np.array([2, 0])
    taken = parts.take(rows)
    rows[:] = 1  # nobody has read a column yet
    assert taken.mass.tolist() == [7.0, 3.0]
    assert taken.take(np.array([False, True])).levels.tolist() == [[1.0]]


def test_a_column_of_parts_takes_no_default():
    with pytest.raises(TypeError, match="takes no default: mass"):

        class WithDefault(PartColumns):
            mass: np.ndarray | None = None


def test_rows_that_agree_in_all_columns_are_found_once():
    rng = np.random.default_rng(7)
    columns = rng.integers(0, 3, 40), 0.5 * rng.integers(0, 3, 40), rng.integers(0, 2, 40).astype(bool)
    unique, at, into = np.unique(np.stack(columns), axis=1, return_index=True, return_inverse=True)
    first, back = rows_alike(*columns)
    assert np.array_equal(np.stack(columns)[:, first], unique)
    assert np.array_equal(first, at)
    assert np.array_equal(back, into.reshape(-1))
    assert [len(part) for part in rows_alike(np.empty(0), np.empty(0))] == [0, 0]


def test_groups_of_rows_agree_in_all_columns_and_start_with_their_first_row():
    rng = np.random.default_rng(11)
    columns = rng.integers(0, 3, 60), rng.choice([-np.inf, 0.5, np.inf], 60), rng.integers(0, 2, 60).astype(bool)
    first, back = groups_alike(*columns)
    _, at, into = np.unique(np.stack(columns), axis=1, return_index=True, return_inverse=True)
    for column in columns:
        assert np.array_equal(column[first][back], column)
    assert set(at) <= set(first.tolist())  # sums of infinities are alike where rows are not: a group may come twice
    finite = np.isfinite(columns[1])
    counted = groups_alike(*(column[finite] for column in columns))[0]
    assert len(counted) == len(set(into.reshape(-1)[finite]))
    assert [len(part) for part in groups_alike(np.empty(0), np.empty(0))] == [0, 0]


@pytest.mark.parametrize("numbers", [[3, 0, 3, 7, 0], [10**7, 4, 10**7], [], [0], [5, 5]])
def test_distinct_numbers_are_those_of_unique(numbers):
    values, back = distinct(np.array(numbers, int))
    unique, into = np.unique(np.array(numbers, int), return_inverse=True)
    assert values.tolist() == unique.tolist()
    assert back.tolist() == into.reshape(-1).tolist()


def test_what_stands_in_many_places_is_made_once_and_stands_in_all():
    one, other, asked = [1.0], [2.0], []

    def doubled(value):
        asked.append(value)
        return 2.0 * value[0]

    assert each_once([one, other, one, one], doubled) == [2.0, 4.0, 2.0, 2.0]
    assert asked == [one, other]
    assert each_once([], doubled) == []
