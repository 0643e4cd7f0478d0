"""Searches of a mission that nothing meets, with less asked of it: what they share, and how long each may take."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import ToBeMade
from uwopt.deadline import NEVER, Deadline, Progress, unheard
from uwopt.mission.mission import Mission
from uwopt.mission.reserves import asked_when_held
from uwopt.mission.weakened import RELAXABLE, asked_value, is_filled_in, with_limit, without
from uwopt.objectives.objective import Objective
from uwopt.results.design import Design
from uwopt.solvers.infeasible.freed_rules import OF_LIGHT, in_the_way
from uwopt.solvers.infeasible.least_change import rounded_away
from uwopt.solvers.infeasible.reached import judged_by, reached_value
from uwopt.solvers.infeasible.relaxer import ANY, FEW_IMAGERS, Relaxer
from uwopt.solvers.recommend import Sought

BRIGHT = Objective.of("snr_db")  # without an SNR to ask for, where least power would try what is too dark first
FINEST = Objective.of("gsd_mm")
TURN = 0.25  # of the time left: what one search may take of it


@dataclass
class Trials:
    """One mission; what is known when time ends, or when a person interrupts, stays.

    `like` is the search that found nothing, whose light is known.
    """

    mission: Mission
    catalog: Catalog
    objective: Objective
    generic: ToBeMade
    deadline: Deadline = NEVER
    say: Progress = unheard  # how far it is
    like: Sought | None = None
    more_s: float = 0.0  # than the deadline gives, where nothing is known to help by then
    interrupted: bool = False
    _judged: dict[int, tuple[Sought, Design]] = field(default_factory=dict)  # each kept, so that its number is its own

    @cached_property
    def relaxer(self) -> Relaxer:
        """What the searches share."""
        return Relaxer(self.mission, self.catalog, self.generic, self.like)

    @property
    def over(self) -> bool:
        """Whether nothing more is to be tried."""
        return self.interrupted or self.deadline.passed()

    @contextmanager
    def until_interrupted(self) -> Iterator[None]:
        """What a person ends here; what is known by then stays."""
        try:
            yield
        except KeyboardInterrupt:
            self.interrupted = True

    @contextmanager
    def within(self, deadline: Deadline) -> Iterator[None]:
        """What has another deadline than the rest."""
        whole, self.deadline = self.deadline, deadline
        try:
            yield
        finally:
            self.deadline = whole

    def go_on(self) -> None:
        """Take the time that is left for who would else be told nothing."""
        self.deadline, self.more_s = replace(self.deadline, end_s=self.deadline.end_s + self.more_s), 0.0

    def judged(self, found: Sought) -> Design:
        """What a search found, judged by the mission as it stands."""
        if id(found) not in self._judged:
            self._judged[id(found)] = found, judged_by(self.mission, found, self.objective)
        return self._judged[id(found)][1]

    def typed(self, name: str, design: Design) -> float | None:
        """The limit of a requirement that a design would keep, as it would be typed; None where that is no figure."""
        key = RELAXABLE[name].key
        value = reached_value(design, key)
        if value is None:
            return None
        return rounded_away(asked_when_held(self.mission.reserve, key, value), self.limits[name])

    def turn(self) -> Deadline:
        """The time for one search among others."""
        return self.deadline.part(TURN)

    @cached_property
    def short_of(self) -> frozenset[str]:
        """By which rules the last designs of the search that found nothing fall: for want of light, say, or money."""
        like = self.relaxer.like
        return frozenset() if like is None else frozenset(in_the_way(like))

    @cached_property
    def limits(self) -> dict[str, float]:
        """What the mission asks for and can do without, with its limits."""
        asked = {name: asked_value(self.mission, name) for name in RELAXABLE}
        return {name: limit for name, limit in asked.items() if limit is not None}

    def is_own(self, name: str) -> bool:
        """Whether the mission states a requirement itself: what it does is likelier in the way than good practice."""
        return not is_filled_in(self.mission, name)

    def by_effort(self) -> dict[str, float]:
        """The same: first what takes least to try."""
        if self.over or OF_LIGHT.issuperset(self.limits):
            return dict(self.limits)
        return {
            name: self.limits[name]
            for name in sorted(self.limits, key=lambda name: self.relaxer.effort({name}))
        }

    def without(self, names: Collection[str]) -> Mission:
        """The mission without all of these, as far as they can be dropped."""
        mission = self.mission
        for name in names:
            mission = without(mission, name) or mission
        return mission

    def few_without(self, names: Collection[str], turn: Deadline, number: int) -> Sought | None:
        """A search without all of these among a few imagers; None where that is of no use."""
        return self.among_few(self.without(names), ANY, set(names), turn, number)

    def among_few(
        self, mission: Mission, goal: Objective, freed: Collection[str], turn: Deadline, number: int = FEW_IMAGERS
    ) -> Sought | None:
        """As `Relaxer.among_few`; that a person ends it is noted."""
        found = self.relaxer.among_few(mission, goal, freed, turn, number=number)
        self.interrupted |= found is not None and found.outcome.interrupted
        return found

    def seek(self, mission: Mission, goal: Objective, freed: Collection[str], deadline: Deadline, **how: Any) -> Sought:
        """As `Relaxer.seek`; raises KeyboardInterrupt where a person ends it."""
        found = self.relaxer.seek(mission, goal, freed, deadline=deadline, **how)
        if found.outcome.interrupted:
            raise KeyboardInterrupt
        return found

    def seek_without(self, names: Collection[str], *, few_first: bool = True) -> Sought | None:
        """A search without all of these; None where it ends before it knows. `few_first` as in `Relaxer.seek`."""
        if self.over:
            return None
        goal = BRIGHT if "min_snr" in names else ANY
        found = self.relaxer.seek(
            self.without(names), goal, set(names), deadline=self.turn(), enough=True, few_first=few_first
        )
        if found.outcome.interrupted:
            self.interrupted = True
            return None
        return found if found.outcome.best or found.outcome.complete else None

    def fits_without(self, names: Collection[str]) -> bool | None:
        """Whether something fits without all of these; None where that is not known."""
        found = self.seek_without(names)
        return None if found is None else bool(found.outcome.best)

    def with_limits(self, mission: Mission, limits: Mapping[str, float | None]) -> Mission:
        """A mission like this one with other limits; None: left out."""
        for name, limit in limits.items():
            if limit is None:
                mission = without(mission, name) or mission
            else:
                mission = with_limit(mission, name, self.limits[name], limit)
        return mission
