"""Points that a search for a front has found, and what they leave of curves that are not asked to their end.

What nodes, or groups of them, are at best is a point, too; where a point found is as good as it in every objective, no
design of theirs is missed: a search looks for what is left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.errors import MissionError
from uwopt.forward.problem import Problem
from uwopt.model.bisection import bisected
from uwopt.objectives.axes import OF_SETTINGS, Axes, Frame
from uwopt.objectives.dominance import BestPoints, clearly, hypervolume, nondominated, would_add
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.front.curves import Curves
from uwopt.solvers.front.hopeful import Hopeful
from uwopt.solvers.front.trade_curves import ABOVE, Answers

RESOLVED_REL = {"information": 2e-4}  # of a quality that is found to a gap
HALVINGS = 40  # of the range of segments' sizes
SAME_REL = 1e-6  # of the others: to this a requirement counts as met


class PointsFound:
    """Points of which none is dominated, by the axes of a front, one of which may be a quality that settings change."""

    def __init__(self, axes: Axes, quality: str | None):
        self.axes, self.quality = axes, quality
        self.resolved_rel = np.array([RESOLVED_REL.get(name, SAME_REL) for name in axes.names])
        self.archive = BestPoints(len(axes))

    @property
    def trades_power(self) -> bool:
        """Whether settings of least power are on the front: power counts, or nothing that settings change does."""
        return self.quality is None or "power" in self.axes.names

    @property
    def has_curves(self) -> bool:
        """Whether a design has a curve of quality against power, not one point alone."""
        return self.quality is not None and self.trades_power

    # ------------------------------------------------------------ values

    def values(self, some: Hopeful, power: Array, quality: Array, design: Array) -> Array:
        """Values (n, n_axes), minimised, at powers and qualities of designs."""
        values = some.fixed[design]
        for name, numbers in (("power", power), (self.quality, quality)):
            column = self.axes.index(str(name))
            if column is not None:
                values[:, column] = numbers * self.axes.signs[column]
        return values

    def of_answers(self, curves: Curves, answers: Answers, which: Array) -> Array:
        """Values of some answers, (n, n_axes)."""
        return self.values(
            curves.some, answers.power_w[which], answers.quality[which], answers.design[which]
        )

    def of_segments(self, curves: Curves) -> Array:
        """The best that each segment could hold, (n, n_axes)."""
        lower, _ = curves.segments()
        power, quality = curves.corners()
        return self.values(curves.some, power, quality, curves.answers.design[lower])

    def best_left(self, curves: Curves) -> tuple[Array, Array]:
        """The best that each segment could hold, (n, n_axes), or each design where it is one point; whose it is."""
        a = curves.answers
        if not self.has_curves:
            return self.values(curves.some, a.limit_w, a.bound, a.design), a.design
        return self.of_segments(curves), a.design[curves.segments()[0]]

    # ------------------------------------------------------------ what points leave

    def may_be_new(self, values: Array) -> Array:
        """Whether no point found is as good as each of these in every objective, (n,)."""
        return np.asarray(np.isfinite(values).all(axis=1) & ~self.archive.beats(values))

    def are_open(self, curves: Curves) -> Array:
        """Whether each design may hold something new, by the bounds of its curve."""
        open_ = np.zeros(len(curves.some), bool)
        best, design = self.best_left(curves)
        open_[design[self.may_be_new(best)]] = True
        return open_

    def add(self, curves: Curves, answers: Answers) -> None:
        """Answers as points found."""
        self.archive.add(self.of_answers(curves, answers, np.nonzero(answers.found)[0]))

    def on_front(self, curves: Curves, answers: Answers) -> Array:
        """Places of the answers that no point dominates."""
        found = np.nonzero(answers.found)[0]
        values = self.of_answers(curves, answers, found)
        return np.asarray(found[~self.archive.dominates(values)])

    def wanted(self, curves: Curves, which: Array) -> Array:
        """The quality that each of these segments must exceed to hold something new."""
        return self.better_than(self.of_segments(curves)[which])

    def better_than(self, values: Array) -> Array:
        """The best quality of the points that are as good as each of these in all else; -inf: there is none."""
        axis = self.axes.names.index(str(self.quality))
        best = self.archive.best(values, axis) * self.axes.signs[axis]
        return np.where(np.isfinite(best), best, -np.inf)

    def open_segments(self, curves: Curves, largest: float) -> tuple[Array, Array]:
        """Segments whose corner no point beats and would add more than `largest` of the box around all, and how much.

        Those that may hold the best quality of all are asked at their upper end whatever they span.
        """
        lower, upper = curves.segments()
        if len(lower) == 0:
            return np.empty(0, int), np.empty(0)
        corner = self.of_segments(curves)
        which = np.nonzero(self.may_be_new(corner))[0]
        if len(which) == 0:
            return which, np.empty(0)
        a = curves.answers
        frame = Frame.of(self.axes, np.concatenate([self.archive.values, corner[which]]))
        # What is known to be there counts once it is asked: cuts do not close a bound that stays above it.
        top = np.where(a.asked[upper] & a.found[upper], a.quality[upper], a.bound[upper])
        power, _ = curves.corners()
        reached = self.values(curves.some, power[which], top[which], a.design[lower][which])
        spans = would_add(self.archive.values, reached, frame)
        far = np.fmin(a.power_w[upper], a.limit_w[upper])
        stepped = curves.some.stepped[a.design[lower]] | (far <= a.limit_w[lower] * ABOVE)
        narrow = (a.asked[upper] & stepped)[which]
        # What may be the best quality of all is an end of the front, however little it spans.
        best = self.better_than(np.full((1, len(self.axes)), np.inf))
        end = ~a.asked[upper][which] & (a.bound[upper][which] > best)
        wide = ((spans > largest) | end) & ~narrow
        return which[wide], spans[wide]

    # ------------------------------------------------------------ what is missed

    def open_corners(self, every: Sequence[Curves]) -> Array:
        """The best that may still be found, by segment, or by design where it is one point."""
        parts = [np.empty((0, len(self.axes)))]
        for curves in every:
            best, _ = self.best_left(curves)
            parts.append(best[self.may_be_new(best)])
        return np.concatenate(parts)

    def volumes(self, every: Sequence[Curves]) -> tuple[float, float]:
        """Hypervolume of the points, and what no front can exceed."""
        values = self.archive.values
        if len(values) == 0:
            return 0.0, 0.0
        frame = Frame.of(self.axes, values[clearly(values, self.resolved_rel)])
        lower = hypervolume(values, frame)
        return lower, max(lower, hypervolume(np.concatenate([values, self.open_corners(every)]), frame))


def largest_left(spans: Array, share: float) -> float:
    """How much a segment may add when all together add no more than a share of what they do.

    One that is cut in k pieces adds a k-th in all, and each piece as little as the square of that.
    """

    def is_small(most: float) -> bool:
        return bool(np.minimum(spans, np.sqrt(spans * most)).sum() <= share * spans.sum())

    def middle(low: float, high: float) -> float:
        return float(np.sqrt(low * high)) if low > 0.0 else high * 1e-12

    return float(bisected(is_small, 0.0, float(spans.max(initial=0.0)), steps=HALVINGS, middle=middle)[0])


def quality_of(problem: Problem, axes: Axes) -> str | None:
    """The one axis beside power that settings change; more than one has no exact front here."""
    names = [*OF_SETTINGS, *(["contrast"] if any(s.sunlit for s in problem.scenes) else [])]
    found = [name for name in axes.names if name in names]
    if len(found) > 1:
        raise MissionError(
            f"objectives: {' and '.join(found)} both depend on the settings; the exact front knows one such quality "
            "beside power, cost, mass and gsd_mm. Leave one out, or use a population solver such as nsga2."
        )
    return found[0] if found else None


# ---------------------------------------------------------------- what a search looks for


WITHOUT_BOUND = 1e300  # in place of infinity, which has no differences


@dataclass(frozen=True)
class Undominated:
    """Designs that no point found beats, as the goal of a search."""

    axes: Axes
    archive: BestPoints
    search: Callable[[Bounds, Array], Array]

    def ideals(self, terms: Terms) -> Array:
        """The best of each objective, (n, n_axes)."""
        return np.clip(self.axes.minimised(terms), -WITHOUT_BOUND, WITHOUT_BOUND)

    def beaten(self, ideals: Array) -> Array:
        """What some point found is as good as in every objective."""
        return self.archive.beats(ideals)

    def order(self, ideals: Array) -> Array:
        """As `in_layers` has them."""
        return in_layers(ideals)


def in_layers(ideals: Array) -> Array:
    """Places of ideal points (n, n_axes): those that no other dominates, then by the worst of their ranks."""
    first = nondominated(ideals)
    order = np.argsort(ideals, axis=0, kind="stable")
    rank = np.empty_like(order)
    for column in range(ideals.shape[1]):
        rank[order[:, column], column] = np.arange(len(ideals))
    worst = rank.max(axis=1, initial=0)
    return np.argsort(np.where(first, -1.0, worst), kind="stable")
