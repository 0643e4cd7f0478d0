"""The least limit of one requirement with which a mission that nothing meets can be met, drawn in step by step.

Where an objective makes its figure best, one search tells the least; where that takes longer than its turn, and of all
other requirements, the limit is drawn in as any change is (`least_change`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial

from uwopt.deadline import Deadline
from uwopt.mission.mission import Mission
from uwopt.mission.weakened import DEEP, RELAXABLE, is_far, with_limit
from uwopt.objectives.objective import Objective
from uwopt.solvers.infeasible.least_change import Change, Narrowing, less_of, rounded_away
from uwopt.solvers.infeasible.reached import deepest, judged_by, miss, rated_depth, reached_value
from uwopt.solvers.infeasible.relaxer import ANY, CHEAPEST
from uwopt.solvers.infeasible.sharpest import SHARP
from uwopt.solvers.infeasible.trials import Trials
from uwopt.solvers.recommend import Sought

MOST_TIMES = 30.0  # what is asked of an image: beyond, it is another image that would be of no use
FIGURE_S = 2.0  # in less the best figure of all hardware is seldom known, and a limit half-way often is
FEW_S = 0.8  # at least for that of a few imagers: it takes that
LONGER = 1.5  # times the turn in which the best figure was not known: in that it may be
SOON = 0.7  # of the time for the best figure: for the best of a few imagers


@dataclass(frozen=True)
class Relaxation:
    """A requirement whose loss alone makes the mission feasible."""

    name: str
    limit: float | None
    needed: float | None
    miss_rel: float
    found: Sought
    fits_at_central_prices: bool = False
    is_least: bool = False  # known to be

    @property
    def is_far(self) -> bool:
        """Whether it is out of reach, so that what it lets through comes near to nothing."""
        return is_far(self.name, self.limit, self.needed)

    @property
    def is_of_use(self) -> bool:
        """Whether a person could live with it: any limit may give, but not an image many times over."""
        if RELAXABLE[self.name].section == "limits" or self.name == "min_snr" or not self.limit or not self.needed:
            return True
        return 1.0 / MOST_TIMES <= self.needed / self.limit <= MOST_TIMES


@dataclass
class LeastLimit:
    """A requirement that helps, and the limit nearest to what is asked with which something is known to fit."""

    trials: Trials
    name: str
    limit: float  # as asked
    mission: Mission  # without it
    found: Sought  # meets the rest; later the nearest that is known
    at_central_prices: bool = False  # the limit of cost is kept, but for estimated prices at their high ends
    narrowing: Narrowing | None = None  # once the figure of the design at hand is known
    is_least: bool = False
    figure_s: float = FIGURE_S  # in less the best figure is not asked for
    by_few: bool = False  # whether a few imagers were asked for theirs

    @property
    def is_done(self) -> bool:
        """Whether no step is left."""
        return self.is_least or (self.narrowing is not None and self.narrowing.is_done)

    @property
    def gap(self) -> float:
        """The share of the change of which it is not known whether it is needed."""
        return 1.0 if self.narrowing is None else self.narrowing.gap

    @property
    def size(self) -> float:
        """Of the change, relative to what is asked: that of the design at hand at first."""
        return self._at_first if self.narrowing is None else self.narrowing.size

    @cached_property
    def _at_first(self) -> float:
        """How far the design that is found first misses what is asked."""
        far = miss(self.limit, self._reached(self.found))
        return 0.0 if far > MOST_TIMES else far  # an image of no use, or a figure that is not known

    def step(self, turn: Deadline) -> None:
        """Draw the limit in once."""
        self.trials.say(0.5, f"the least change of {self.name}")
        best = RELAXABLE[self.name].best
        if self.narrowing is not None:
            if best is not None and not self.by_few:
                self._draw_by_few(self.narrowing, Objective.of(best), turn)
            elif not (turn.left_s >= self.figure_s and self._by_figure(turn)):
                self.narrowing.step(turn)
        elif self.name == DEEP:
            trials = self.trials
            self.found = deepest(
                self.found, self.mission, trials.catalog, ANY, generic=trials.generic, deadline=turn
            )
            self.is_least = not turn.passed()
        elif not (turn.left_s >= self.figure_s and self._by_figure(turn)):
            self._narrow(turn)

    def _by_figure(self, turn: Deadline) -> bool:
        """Whether one search tells the least: it seeks the design with the best figure."""
        self.figure_s, best = LONGER * turn.left_s, RELAXABLE[self.name].best
        if best is None or not self._is_what_counts():
            self.figure_s = math.inf
            return False
        sought = self._best_without(Objective.of(best), turn)
        self.is_least = sought.outcome.complete
        self.found = sought if sought.outcome.best else self.found
        if self.is_least:
            self.narrowing = None
        elif self.narrowing is not None:
            self._offer(self.narrowing, self.found, turn)
        if sought.outcome.interrupted:
            raise KeyboardInterrupt
        return self.is_least

    def _narrow(self, turn: Deadline) -> None:
        """Begin at what the design at hand reaches; where that has no figure, nothing less is known."""
        if self.name == SHARP:
            few = self.trials.relaxer.among_few(self.mission, ANY, {SHARP}, turn)
            self.found = few if few is not None and few.outcome.best else self.found
        needed = self._reached(self.found)
        if needed is None:
            self.is_least = True
            return
        relaxed = partial(with_limit, self.trials.mission, self.name, self.limit)
        beyond = self.trials.relaxer.beyond(self.name, self.limit)
        self.narrowing = Narrowing(
            self.limit, Change(needed, self.found), relaxed, self._search, beyond=beyond
        )
        self.narrowing.step(turn)
        best = RELAXABLE[self.name].best
        if best is not None and not self.by_few and is_far(self.name, self.limit, self.narrowing.change.limit):
            self._draw_by_few(self.narrowing, Objective.of(best), turn, enough=False)

    def _draw_by_few(
        self, narrowing: Narrowing, goal: Objective, turn: Deadline, *, enough: bool = True
    ) -> None:
        """Take the first of a few imagers by what their figure can be, where it needs less than the design at hand.

        It is often near the best, and known long before that. Where another figure is what counts, it mostly is too.
        enough : the first; else the best that is found in time, where the design at hand is far out of reach
        """
        self.by_few = True
        soon = self.trials.deadline.at_most(max(turn.left_s, FEW_S))
        few = self.trials.relaxer.among_few(self.mission, goal, {self.name}, soon, enough=enough)
        if few is not None and few.outcome.best:
            self._offer(narrowing, few, soon)

    def _offer(self, narrowing: Narrowing, other: Sought, turn: Deadline) -> None:
        """Take what another search found, where that needs less."""
        needed = self._reached(other)
        if needed is not None and narrowing.take(Change(needed, other), turn):
            self.found = narrowing.change.found

    def _search(self, wanted: Mission, turn: Deadline) -> Sought:
        """A search of all hardware."""
        return self.trials.seek(wanted, ANY, {self.name}, turn, enough=True, likely=True)

    def told(self) -> Relaxation:
        """As far as it is drawn in."""
        change = self.narrowing.change if self.narrowing else None
        is_least = self.is_least or (self.narrowing is not None and self.narrowing.is_least)
        if not is_least:
            self.trials.deadline.left_out.append(less_of(self.name))
        needed, found = (self._reached(self.found), self.found) if change is None else (change.limit, change.found)
        return Relaxation(
            self.name, self.limit, needed, miss(self.limit, needed), found, self.at_central_prices,
            is_least and needed is not None,
        )  # fmt: skip

    def _reached(self, found: Sought) -> float | None:
        """The limit that a design would keep, as it would be typed."""
        if self.name != DEEP:
            return self.trials.typed(self.name, self.trials.judged(found))
        rated = rated_depth(found)
        return None if rated is None else rounded_away(rated / self.trials.mission.depth_factor, self.limit)

    def _is_what_counts(self) -> bool:
        """Whether the best figure is the best of what is asked: the SNR to get best is that of the mean."""
        views = self.trials.mission.views
        return self.name != "min_snr" or all(view.requirements.snr_at == "mean" for view in views)

    def _best_without(self, goal: Objective, turn: Deadline) -> Sought:
        """A search for the design whose figure is best without its limit, better than the one at hand."""
        relaxer = self.trials.relaxer
        if goal == CHEAPEST:
            return self._cheapest(turn)
        first = judged_by(self.mission, self.found, goal).objective_value
        ceiling = math.inf if first is None else goal.minimised(first)
        soon = turn.part(SOON)
        self.by_few = True
        few = relaxer.among_few(self.mission, goal, {self.name}, soon, enough=False, ceiling=ceiling)
        if few is not None and few.outcome.best:
            self.found, ceiling = few, few.outcome.best[0].minimised
        return relaxer.seek(self.mission, goal, {self.name}, deadline=turn, ceiling=ceiling)

    def _cheapest(self, turn: Deadline) -> Sought:
        """A search for the design with which the least limit of cost can be kept, by the prices that count there."""
        first = reached_value(judged_by(self.trials.mission, self.found, CHEAPEST), "cost")
        free = self.trials.without([self.name])
        ceiling = math.inf if first is None else first
        return self.trials.relaxer.cheapest(free, {self.name}, deadline=turn, ceiling=ceiling)
