"""Columns of equal length: the base of every record that describes n things row by row."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any, Self

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.memory import keep_freed_memory

keep_freed_memory()

MIXING = 0.5 * (5.0**0.5 - 1.0)  # irrational, so that sums of unlike rows are seldom the same
SPARSE, SHORT = 8, 1000  # of numbers an entry, and of numbers, beyond which it is quicker to sort entries


@dataclass(frozen=True)
class Columns:
    """Arrays whose first axis counts rows; a field may also be Columns, a list of Columns, or None for none.

    Whatever else a record holds (a number, a table) is common to all of its rows.
    """

    def take(self, index: Array | slice) -> Self:
        """The same columns at these rows."""
        return self.with_arrays(gathering(index))

    def with_arrays(self, change: Callable[[Array], Array]) -> Self:
        """The record with every array changed by a function."""
        made = object.__new__(type(self))  # a record checks nothing when it is made: its fields are put in place
        values = made.__dict__
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            values[name] = change(value) if type(value) is np.ndarray else changed(value, change)
        return made

    def scaled(self, factor: Array) -> Self:
        """Every row times its own factor."""
        return self.with_arrays(lambda column: column * factor.reshape(-1, *([1] * (column.ndim - 1))))

    def put(self, index: Array, part: Self) -> Self:
        """A copy in which these rows are those of `part`."""
        return replace(
            self, **{f.name: put_into(getattr(self, f.name), index, getattr(part, f.name)) for f in fields(self)}
        )

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """All rows of some lists."""
        ends = np.cumsum([0, *(len_of(part) for part in parts)]).tolist()
        places = [slice(start, end) for start, end in pairwise(ends)]
        return cls.in_places(list(zip(places, parts, strict=True)), ends[-1])

    @classmethod
    def in_places(cls, parts: Sequence[tuple[Array | slice, Self]], count: int) -> Self:
        """Groups of rows put back in their places among `count`; a group that is less deep repeats its last."""
        columns = {}
        for f in fields(cls):
            columns[f.name] = placed([(rows, getattr(part, f.name)) for rows, part in parts], count)
        return cls(**columns)


class PartColumns(Columns):
    """Columns of a catalogue's parts, of which each use reads a few: what is taken is gathered when it is read.

    Holds the list it was taken from. No column has a default, which would stand in its place.
    """

    def __init_subclass__(cls) -> None:
        if preset := [name for name in inspect.get_annotations(cls) if name in cls.__dict__]:
            raise TypeError(f"{cls.__name__}: a column of parts takes no default: {', '.join(preset)}")

    def take(self, index: Array | slice) -> Self:
        """As `Columns`."""
        made = object.__new__(type(self))
        made.__dict__["_taken"] = (self, gathering(index))
        return made

    def __getattr__(self, name: str) -> Any:
        """A column that nobody has read yet."""
        taken = self.__dict__.get("_taken")
        if taken is None or name.startswith("_"):
            raise AttributeError(f"{type(self).__name__} has no {name}")
        value = self.__dict__[name] = changed(getattr(taken[0], name), taken[1])
        return value


def rows_alike(*columns: Array) -> tuple[Array, Array]:
    """The first of the rows that agree in all columns, in increasing order of the columns, and of each row its place.

    As np.unique of a table, but that sorts rows as bytes.
    """
    return _first_of_groups(np.lexsort(columns[::-1]), columns)


def groups_alike(*columns: Array) -> tuple[Array, Array]:
    """The first rows of groups that agree in all columns, in no order, and of each row the place of its group.

    For what is worked out once a group: rows are sorted by a sum of their numbers, ten times as quick as by each. Like
    rows have the same; so may others, between which a group then comes twice.
    """
    mixed = columns[0]
    with np.errstate(invalid="ignore"):
        for column in columns[1:]:
            mixed = MIXING * mixed + column
    return _first_of_groups(np.argsort(mixed, kind="stable"), columns)


def _first_of_groups(order: Array, columns: Sequence[Array]) -> tuple[Array, Array]:
    """The first rows of groups of neighbours in this order that agree in all columns, and of each row its group."""
    new = np.zeros(len(order), bool)
    new[:1] = True
    for column in columns:
        ordered = column[order]
        new[1:] |= ordered[1:] != ordered[:-1]
    back = np.empty(len(order), np.intp)
    back[order] = np.cumsum(new) - 1
    return order[new], back


def distinct(index: Array) -> tuple[Array, Array]:
    """The values of an array of whole numbers, none negative, in rising order, and of each entry its place.

    As np.unique, but that sorts: places in a list are sooner counted, unless they are few in a long one.
    """
    if index.max(initial=0) > SPARSE * len(index) + SHORT:
        return np.unique(index, return_inverse=True)
    there = np.bincount(index) > 0
    return np.flatnonzero(there), (np.cumsum(there) - 1)[index]


def gathering(index: Array | slice) -> Callable[[Array], Array]:
    """The function that picks rows of a column; of a mask, those that it holds."""
    if not isinstance(index, np.ndarray):
        return lambda column: column[index]
    rows = np.flatnonzero(index) if index.dtype == bool else np.array(index)  # a copy: columns may be read later
    # `take` is the quicker one, but copies a whole column that does not lie in one piece
    return lambda column: column.take(rows, axis=0) if column.flags.c_contiguous else column[rows]


def changed(value: Any, change: Callable[[Array], Array]) -> Any:
    """A field with its arrays changed."""
    if isinstance(value, np.ndarray):
        return change(value)
    if isinstance(value, Columns):
        return value.with_arrays(change)
    if isinstance(value, list) and value and isinstance(value[0], Columns):
        return [one.with_arrays(change) for one in value]
    return value


def put_into(old: Any, index: Array, new: Any) -> Any:
    """A field in which some rows are new."""
    if isinstance(old, np.ndarray):
        old = np.array(old)
        old[index] = new
        return old
    if isinstance(old, Columns):
        return old.put(index, new)
    if isinstance(old, list) and old and isinstance(old[0], Columns):
        return [one.put(index, own) for one, own in zip(old, new, strict=True)]
    return old


def len_of(part: Columns) -> int:
    """How many rows a record has."""
    for f in fields(part):
        value = getattr(part, f.name)
        if isinstance(value, np.ndarray):
            return len(value)
        if isinstance(value, Columns):
            return len_of(value)
    raise TypeError(f"{type(part).__name__} has no column")


def placed(parts: Sequence[tuple[Array | slice, Any]], count: int) -> Any:
    """One field of several groups, each at its rows; what is no column is the first group's."""
    first = parts[0][1] if parts else None
    if isinstance(first, np.ndarray | None) and any((one is None) != (first is None) for _, one in parts):
        raise TypeError("some groups of rows have a column that others have not")
    if isinstance(first, np.ndarray):
        return array_in_places(parts, count)
    if isinstance(first, Columns):
        return type(first).in_places([(rows, one) for rows, one in parts if one is not None], count)
    if isinstance(first, list) and first and isinstance(first[0], Columns):
        return [placed([(rows, ones[k]) for rows, ones in parts], count) for k in range(len(first))]
    return first


def array_in_places(parts: Sequence[tuple[Array | slice, Array]], count: int) -> Array:
    """Arrays put at their rows; one whose last axis is shorter repeats its last entry."""
    first = parts[0][1]
    shape = [count, *first.shape[1:]]
    if first.ndim > 1:
        shape[-1] = max(one.shape[-1] for _, one in parts)
    out = np.empty(shape, np.result_type(*(one.dtype for _, one in parts)))
    for rows, one in parts:
        missing = shape[-1] - one.shape[-1] if one.ndim > 1 else 0
        if missing:
            one = np.pad(one, [(0, 0)] * (one.ndim - 1) + [(0, missing)], mode="edge")
        out[rows] = one
    return out


def each_once(values: Sequence[Any], made: Callable[[Any], Any]) -> list[Any]:
    """What is made of each value; of one object that stands in many places once: of states of parts most do."""
    places = list(map(id, values))
    if len(set(places)) == 1:
        return [made(values[0])] * len(values)
    one_of = dict(zip(places, values, strict=True))
    known = {key: made(value) for key, value in one_of.items()}
    return list(map(known.__getitem__, places))
