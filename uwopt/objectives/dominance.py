"""Which points no other beats in every objective; less is better in every column.

Filters and hypervolumes come from moocore; a table of the best third objective answers at once which of
millions of bounds some point found beats.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.objectives.axes import Frame, scale
from uwopt.tolerances import TIE

PAIRS = 1_000_000  # of points compared at a time
NEAR = 1e-3  # relative in every objective: one of two such points is enough


def nondominated(values: Array) -> Array:
    """Mask of the rows that no other row dominates; of equal rows the first."""
    if len(values) == 0:
        return np.zeros(0, bool)
    import moocore

    return np.asarray(moocore.is_nondominated(values, keep_weakly=False))


def clearly(values: Array, resolved_rel: Array) -> Array:
    """Mask of nondominated rows that owe their place to more than the last digits of their values.

    resolved_rel : (n_axes,) relative differences that mean nothing, such as the gap of a quality without a closed
    form. A row goes if another is no worse than that in every objective and better by more in some.
    Only rows that stay send others away: a long run of small steps would leave nothing but its first.
    """
    kept: Array = nondominated(values)
    rows = np.nonzero(kept)[0]
    if len(rows) == 0:
        return kept
    points = values[rows]
    slack = resolved_rel * np.abs(points)
    loser, winner = _clearly_beaten(points, slack)
    doubtful, begins = np.unique(loser, return_index=True)
    winners = dict(zip(doubtful.tolist(), np.split(rows[winner], begins[1:]), strict=True)) if len(doubtful) else {}
    resolved = np.maximum(resolved_rel * np.median(np.abs(points), axis=0), 1e-300)
    kept[rows[doubtful]] = False
    for place in doubtful[np.argsort((points[doubtful] / resolved).sum(axis=1), kind="stable")].tolist():
        kept[rows[place]] = not kept[winners[place]].any()
    return kept


def _clearly_beaten(points: Array, slack: Array) -> tuple[Array, Array]:
    """Pairs of a point and another that is no worse, to the point's slack, and better by more somewhere, by point.

    No point dominates another, so that the other is worse in some objective, within the slack: next above the point
    in the order of that objective.
    """
    pairs = [np.empty((2, 0), int)]
    for point, room in zip(points.T, slack.T, strict=True):
        order = np.argsort(point, kind="stable")
        ordered = point[order]
        begin = np.searchsorted(ordered, point, side="right")
        end = np.searchsorted(ordered, point + room * (1.0 + TIE), side="right")
        for loser, place in _ranges(begin, end):
            winner = order[place]
            step = points[loser] - points[winner]  # above 0: the winner is better
            found = (step >= -slack[loser]).all(axis=1) & (step > slack[loser]).any(axis=1)
            pairs.append(np.stack([loser[found], winner[found]]))
    loser, winner = np.unique(np.concatenate(pairs, axis=1), axis=1)
    return loser, winner


def _ranges(begin: Array, end: Array) -> Iterator[tuple[Array, Array]]:
    """Rows and all places from begin to end of each, (m,) both, some rows at a time."""
    count = np.maximum(end - begin, 0)
    block = np.cumsum(count) // PAIRS
    for rows in np.split(np.arange(len(count)), np.nonzero(np.diff(block))[0] + 1):
        row = np.repeat(rows, count[rows])
        first = np.cumsum(count[rows]) - count[rows]
        yield row, np.arange(len(row)) + np.repeat(begin[rows] - first, count[rows])


def hypervolume(values: Array, frame: Frame) -> float:
    """Share of the frame's box that points dominate; those beyond its reference count for nothing."""
    import moocore

    unit = frame.unit(values) if len(values) else np.empty((0, len(frame.span)))
    inside = unit[(unit < frame.reference).all(axis=1)]
    if len(inside) == 0:
        return 0.0
    whole = float(np.prod(frame.reference))
    return float(moocore.hypervolume(np.maximum(inside, 0.0), ref=frame.reference)) / whole


def would_add(values: Array, corners: Array, frame: Frame) -> Array:
    """Share of the frame's box that each corner alone would add to what points dominate, (m,).

    The objective of fewest values is cut where points begin. In each slab they are a staircase in the other two, and
    what a corner adds lies between it and the steps, up to the first that is as low.
    """
    reference = np.append(frame.reference, np.ones(3 - len(frame.span)))
    points, mine = (three(np.maximum(frame.unit(some), 0.0)) for some in (values, corners))
    points = points[(points < reference).all(axis=1)]
    order = np.argsort([len(np.unique(column)) for column in points.T], kind="stable")
    points, mine, reference = points[:, order], mine[:, order], reference[order]
    points = points[np.argsort(points[:, 1], kind="stable")]
    steps = np.concatenate([[0.0], points[:, 1], reference[1:2]])
    ends = np.append(np.unique(points[:, 0]), reference[0])
    added = np.zeros(len(mine))
    order = np.argsort(mine[:, 0], kind="stable")
    order = order[(mine[order, 1:] < reference[1:]).all(axis=1)]
    entered, here = 0, np.empty(0, int)
    for low, high in zip(np.append(0.0, ends[:-1]), ends, strict=True):
        until = int(np.searchsorted(mine[order, 0], high))
        here, entered = np.concatenate([here, order[entered:until]]), until
        begun = np.where(points[:, 0] <= low, points[:, 2], np.inf)
        height = np.minimum.accumulate(np.append(reference[2], begun))
        area = np.append(0.0, np.cumsum(np.diff(steps) * height))  # under the staircase, up to each step
        begin, start, least = mine[here].T
        end = np.searchsorted(-height, -least)
        beyond = area[end] - np.interp(start, steps, area) - least * (steps[end] - start)
        some = steps[end] > start
        added[here] += (high - np.maximum(low, begin)) * np.where(some, np.maximum(beyond, 0.0), 0.0)
        here = here[some]  # a staircase that is as low at its start stays so in all slabs that follow
    return added / float(np.prod(reference))


def igd_plus(values: Array, front: Array, frame: Frame) -> float | None:
    """IGD+ of points to a front, axes scaled to the front's range; None without points."""
    if len(values) == 0 or len(front) == 0:
        return None
    import moocore

    return float(moocore.igd_plus(frame.unit(values), ref=frame.unit(front)))


class BestPoints:
    """Points found so far, and whether any of them is at least as good as a bound in every objective."""

    def __init__(self, n_axes: int):
        self.values: Array = np.empty((0, n_axes))
        self._table: Staircase | None = None

    def add(self, values: Array) -> None:
        """Merge points; those dominated go."""
        if len(values) == 0:
            return
        every = np.concatenate([self.values, values])
        self.values = every[nondominated(every)]
        self._table = None

    def dominates(self, values: Array) -> Array:
        """Whether some point is better than each of these, by more than a tie, (n,)."""
        if len(self.values) == 0 or len(values) == 0:
            return np.zeros(len(values), bool)
        return Staircase.of(self.values).reached(values - TIE * np.abs(values))

    def best(self, bounds: Array, axis: int) -> Array:
        """The least of one objective over the points no worse than each bound in the others; inf: none is."""
        if len(self.values) == 0:
            return np.full(len(bounds), np.inf)
        return Staircase.of(self.values, axis).least(bounds + TIE * np.abs(bounds))

    def beats(self, bounds: Array) -> Array:
        """Whether some point is as good as each bound, ties included, (n,)."""
        if len(self.values) == 0 or len(bounds) == 0:
            return np.zeros(len(bounds), bool)
        if self._table is None:
            self._table = Staircase.of(self.values)
        return self._table.reached(bounds + TIE * np.abs(bounds))


@dataclass(frozen=True)
class Staircase:
    """The least last objective of the points up to each first and second one."""

    order: Array  # of the columns: first, second, last
    first: Array
    second: Array
    best: Array

    @staticmethod
    def of(values: Array, last: int | None = None) -> Staircase:
        """The table of some points (n, 2 or 3); `last` is the column with most values unless it is named."""
        columns = [np.unique(column, return_inverse=True) for column in three(values).T]
        sizes = np.array([len(edges) for edges, _ in columns], float)
        if last is not None:
            sizes[last] = np.inf
        order = np.argsort(sizes, kind="stable")
        (first, i), (second, j) = columns[order[0]], columns[order[1]]
        best = np.full((len(first), len(second)), np.inf)
        np.minimum.at(best, (i.reshape(-1), j.reshape(-1)), three(values)[:, order[2]])
        best = np.minimum.accumulate(np.minimum.accumulate(best, axis=0), axis=1)
        return Staircase(order, first, second, best)

    def least(self, bounds: Array) -> Array:
        """The least last objective of the points that are no more than each bound in the others; inf: none is."""
        bounds = three(bounds)
        i = np.searchsorted(self.first, bounds[:, self.order[0]], side="right") - 1
        j = np.searchsorted(self.second, bounds[:, self.order[1]], side="right") - 1
        inside = (i >= 0) & (j >= 0)
        return np.where(inside, self.best[np.maximum(i, 0), np.maximum(j, 0)], np.inf)

    def reached(self, bounds: Array) -> Array:
        """Whether a point is no more than each bound in every objective."""
        return np.asarray(self.least(bounds) <= three(bounds)[:, self.order[2]])


def three(values: Array) -> Array:
    """Values in three columns."""
    return values if values.shape[1] == 3 else np.column_stack([values, np.zeros(len(values))])


MARGIN = 1.1  # of a front's range, where the box ends that volumes are measured in


def unlike_rows(values: Array, log: Array, alike_rel: float = NEAR) -> Array:
    """Indices of rows of which no two are alike in every column, in the order of the columns.

    Those that dominate most by themselves stay first: the ends of curves, without which a whole slab is lost
    (0.2 % of the hypervolume goes where the first in a sorted list would lose 2 %).
    """
    if len(values) == 0:
        return np.empty(0, int)
    from moocore import hv_contributions

    unit = in_box(values, values, log)
    alone = np.asarray(hv_contributions(unit, ref=np.full(values.shape[1], MARGIN)))
    kept: list[int] = []
    for row in np.lexsort((*values.T[::-1], -alone)):
        if not near(values[kept], values[row], alike_rel).all(axis=1).any():
            kept.append(int(row))
    index = np.array(kept)
    return index[np.lexsort(values[index].T[::-1])]


def in_box(values: Array, front: Array, log: Array) -> Array:
    """Values with the front's best corner at 0 and its worst at 1, logarithms where axes are compared by ratio."""
    low, high = (scale(end[None, :], log)[0] for end in (front.min(axis=0), front.max(axis=0)))
    return np.asarray((scale(values, log) - low) / np.where(high > low, high - low, 1.0))


def near(one: Any, other: Any, alike_rel: float) -> Any:
    """Whether values are alike to a relative difference."""
    return np.abs(one - other) <= alike_rel * np.maximum(np.abs(one), np.abs(other))
