"""The least change of one requirement that makes a mission feasible, proven by searches.

A requirement that is dropped leaves a design that misses it by some amount, not by the least. The limit is drawn
towards what was asked: first with that design's hardware, which takes little time, then all hardware is searched
half-way to what was asked, and each next hardware drawn in likewise. Where nothing fits half-way, all hardware is
searched at a limit a little closer than what does: where nothing fits there either, the change is the least.
Several changes are drawn in by turns, so that time that does not suffice for all makes each of them smaller.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

from uwopt.deadline import NEVER, Deadline
from uwopt.errors import UwoptError
from uwopt.forward.assembly import selected
from uwopt.forward.lamps import light_counts, mission_mounts
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.infeasible.reached import miss
from uwopt.solvers.one_hardware import problem_of
from uwopt.solvers.recommend import Sought
from uwopt.solvers.warm.parts import ids_of, only

CLOSER = 0.02  # of a change: what is proven not to be enough is a change smaller by this share
DIGITS = 3  # of a limit, rounded away from what was asked: it can be typed as it stands
NOTHING = 1e-12
HALVES = (0.5,) * 30
LITTLE = CLOSER  # of a change, that hardware which needs all of it cannot do with less
ROUNDS = 20  # each takes a search over all hardware
LEAST_TURN_S = 0.3  # a search over all hardware seldom finds anything in less
ROUND_SHARE = 0.5  # of the time left, for one step of every change
LAST_SHARE = 0.7  # likewise, where one alone is left


@dataclass(frozen=True)
class Change:
    """A limit with which the mission can be met, and the design that does."""

    limit: float
    found: Sought


class Stepwise(Protocol):
    """A change that is drawn in step by step."""

    @property
    def is_done(self) -> bool:
        """Whether no step is left."""

    @property
    def gap(self) -> float:
        """The share of the change of which it is not known whether it is needed: 0 to 1."""

    @property
    def size(self) -> float:
        """Of the change, relative to what is asked."""

    def step(self, turn: Deadline) -> None:
        """Draw it in once, in this time."""


def in_rounds(changes: Iterable[Stepwise], phase: Deadline) -> None:
    """Draw all in by turns until each is the least, or time ends: one step each a round, nearest to done first.

    Of those that are as near, the largest change comes first: it is of least use as it is. Each step gets a fair part
    of what another round leaves of the time, but no less than a search takes that finds anything.
    """
    left = [one for one in changes if not one.is_done]
    while left:
        for number, one in enumerate(sorted(left, key=lambda one: (one.gap, -one.size))):
            if phase.passed():
                return
            share = ROUND_SHARE if len(left) > 1 else LAST_SHARE
            fair_s = share * phase.left_s / (len(left) - number)
            one.step(phase.at_most(max(fair_s, LEAST_TURN_S)))
        left = [one for one in left if not one.is_done]


@dataclass
class Narrowing:
    """A change between what is known to do and what is known not to.

    asked : of the mission
    change : as far as it is drawn in
    relaxed : the mission with another limit
    search : over all hardware, in some time
    """

    asked: float
    change: Change
    relaxed: Callable[[float], Mission]
    search: Callable[[Mission, Deadline], Sought]
    is_least: bool = False
    steps: int = 0
    share: float = 0.5  # of what is left, that is tried next
    beyond: float | None = None  # at which nothing fits, where that is known to begin with
    too_near: float = field(init=False)  # the same, as far as it is known
    too_long: float | None = None  # nearer than the change, where a search took longer than its turn

    def __post_init__(self) -> None:
        self.too_near = self.asked if self.beyond is None else self.beyond

    @property
    def is_done(self) -> bool:
        """Whether it is the least, or gave no more in many steps."""
        return self.is_least or self.steps > ROUNDS

    @property
    def gap(self) -> float:
        """The share of the change of which it is not known whether it is needed."""
        whole = abs(self.asked - self.change.limit)
        return abs(self.too_near - self.change.limit) / whole if whole else 0.0

    @property
    def size(self) -> float:
        """Of the change, relative to what is asked."""
        return miss(self.asked, self.change.limit)

    def step(self, turn: Deadline) -> None:
        """First as near as the hardware of the change reaches, then a search a little or half-way closer."""
        self.steps += 1
        if self.steps == 1:
            self.change = with_its_hardware(self.too_near, self.change, self.relaxed, turn)
            self.is_least = self.beyond is not None and self.gap <= CLOSER
            return
        limit = self.change.limit
        near = self.asked if self.share == CLOSER else self.too_near if self.too_long is None else self.too_long
        step = limit + self.share * (near - limit)
        closer = self.search(self.relaxed(step), turn)
        if closer.outcome.best:  # not the least by far, it seems: halve what is left
            typed = Change(rounded_away(step, self.asked), closer)
            self.change, self.share = with_its_hardware(self.too_near, typed, self.relaxed, turn), 0.5
        elif closer.outcome.complete:
            self.too_near, self.share, self.too_long = step, CLOSER, None
            self.is_least = self.gap <= CLOSER * (1.0 + 1e-9)
        else:
            self._put_off(step)

    def take(self, other: Change, turn: Deadline) -> bool:
        """Put a smaller change that is known to do in the place of this, drawn in by its hardware; whether it is."""
        if abs(other.limit - self.asked) >= abs(self.change.limit - self.asked):
            return False
        self.change = with_its_hardware(self.too_near, other, self.relaxed, turn)
        return True

    def _put_off(self, step: float) -> None:
        """A search took too long: next one half as close, and from the middle again where that is no step."""
        far_enough = abs(step - self.change.limit) > CLOSER * abs(self.asked - self.change.limit)
        self.too_long, self.share = step if self.share > CLOSER and far_enough else None, 0.5


def less_of(name: str) -> str:
    """What is not known of a change that is not drawn in to the end."""
    return f"whether less than that change of {name} would do"


def with_its_hardware(
    asked: float, change: Change, relaxed: Callable[[float], Mission], deadline: Deadline = NEVER
) -> Change:
    """The nearest limit that the hardware of a change can meet, to `DIGITS`, or as near as the time reaches.

    Mostly the limit is just what its design needs: where a little less does not do, nothing nearer is tried.
    """
    far, near, found = change.limit, asked, change.found
    for share in (LITTLE, *HALVES):
        step = rounded_away(far + share * (near - far), asked)
        is_nearer = min(far, near) < step < max(far, near)
        if deadline.passed() or not (is_nearer or share == LITTLE):
            break
        if not is_nearer:
            continue
        tried = fitting(found, partial(relaxed, step))
        if tried is not None:
            far, found = step, tried
        elif share == LITTLE:
            break
        else:
            near = step
    return Change(far, found)


def rounded_away(value: float, asked: float) -> float:
    """A limit with few digits, no nearer to what is asked."""
    if not math.isfinite(value):
        return value
    if abs(value) < NOTHING:  # an SNR of 0 dB that comes of a ratio
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - DIGITS + 1)
    steps = math.ceil(value / unit - 1e-9) if value > asked else math.floor(value / unit + 1e-9)
    return float(f"{steps * unit:.{DIGITS}g}")


def fitting(found: Sought, mission: Callable[[], Mission]) -> Sought | None:
    """The best settings of a design's hardware for a mission; None where there are none, or it is no mission."""
    try:
        asked = mission()
    except UwoptError:  # as with a tolerance above the height
        return None
    less = same_hardware(found, asked)
    return less if less.outcome.best else None


def same_hardware(found: Sought, mission: Mission) -> Sought:
    """The best settings of a design's hardware for a mission; its lamps stand where that puts them if it moves them.

    None fit where one of its parts does not last as long.
    """
    best, scenes = found.outcome.best[0], found.problem.scenes_for(mission)
    problem, (least, most) = problem_of(found.problem, best, mission=mission, scenes=scenes), light_counts(mission)
    if not (least <= best.count <= most and best.lighting.mount in mission_mounts(mission)):
        problem = problem.standing_as_asked()
    ceiling = -math.inf if lasts_less(found, mission) else math.inf
    return Sought.of(found.selection, problem, Objective.of("power"), whole=True, ceiling=ceiling)


def lasts_less(found: Sought, mission: Mission) -> bool:
    """Whether a mission is longer than that of a design by so much that it does not allow one of its parts."""
    hours, before = mission.vehicle.duration_h, found.problem.mission.vehicle.duration_h
    if hours is None or (before is not None and hours <= before):
        return False
    few = only(found.selection, ids_of(found.problem, found.outcome.best[0]))
    longer = selected(mission, found.selection.catalog, generic=found.selection.generic)
    return any(not set(few.indices[kind]) <= set(longer.indices[kind]) for kind in few.indices)
