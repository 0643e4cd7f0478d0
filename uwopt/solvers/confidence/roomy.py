"""Searches for hardware with room: in parts and water that are worse than in most scenarios, best first.

What fits there is likely to hold often. Where nothing fits, numbers are less worse in turn; the brightest is searched
beside the best, where light is asked for. What a search brings up is counted before the next is made, which may then
not be needed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from uwopt.deadline import Deadline, OutOfTimeError
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.counted import by_names
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.worst_case import worse_problem
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.one_hardware import among

WORSE = (0.75, 0.9)  # than this share of the scenarios: what searches for hardware with room start from
LESS_WORSE = (0.5, 0.3)  # where nothing fits so
A_SEARCH = 4  # hardware that each brings up


@dataclass
class SearchedSoFar:
    """Which searches are left, in turn, and what those before have shown."""

    had: set[Any]  # names of what was brought up
    fits: dict[float, bool]  # whether anything does with numbers worse than in so many
    wants_light: bool  # whether the brightest is still to be searched
    left: list[tuple[float, bool]] = field(
        default_factory=lambda: [(worse, bright) for worse in (*WORSE, *LESS_WORSE) for bright in (False, True)]
    )  # how much worse, and whether for the brightest
    any_fits: bool = False
    fits_here: bool = False

    def copied(self) -> SearchedSoFar:
        """The same, to go on from without a change here."""
        return replace(self, had={*self.had}, fits={**self.fits}, left=[*self.left])


@dataclass
class RoomySearches:
    """Searches of a problem in worse numbers, one after another."""

    problem: Problem
    objective: Objective
    scenarios: Scenarios
    rungs: tuple[float, ...]  # that are searched though some hardware holds
    with_room: bool  # whether less room than that is not asked for
    shown: SearchedSoFar
    last: tuple[float, Problem, Imagers | None] | None = None  # numbers that were searched last, with what they leave

    @classmethod
    def of(
        cls, problem: Problem, objective: Objective, scenarios: Scenarios, *, rungs: tuple[float, ...],
        with_room: bool, had: set[Any], fits: dict[float, bool],
    ) -> RoomySearches:  # fmt: skip
        """All of them."""
        asked = any(scene.view.requirements.min_snr for scene in problem.scenes)
        shown = SearchedSoFar(had, fits, wants_light=objective.single != "snr_db" and asked)
        return cls(problem, objective, scenarios, rungs, with_room, shown)

    def next(
        self, deadline: Deadline, *, done: bool = False, hopeful: bool = False, once: bool = False
    ) -> list[Found] | None:
        """New hardware of the next search that brings up any, or of the next at all; None where none is worth making.

        done : whether enough holds; hopeful : whether any does. Raises OutOfTimeError.
        """
        made, shown = None, self.shown
        for worse, bright in self._worth_making(done=done, hopeful=hopeful):
            found = self._found(worse, bright, deadline)
            if deadline.passed():
                raise OutOfTimeError
            shown.fits_here |= bool(found)
            shown.any_fits |= shown.fits_here
            shown.left.pop(0)
            if self.with_room and not shown.any_fits:
                shown.fits[worse] = False
                shown.left.clear()
            elif bright:
                shown.wants_light, shown.fits[worse] = False, shown.fits_here
            new = by_names(self.problem, found, shown.had)
            made = [*new.values()]
            shown.had.update(new)
            if made or once:
                break
        return made

    def ahead(self, deadline: Deadline, *, hopeful: bool) -> tuple[list[Found] | None, SearchedSoFar]:
        """The same, and what is shown then, to be taken over: nothing of that changes here."""
        then = replace(self, shown=self.shown.copied())
        made = then.next(deadline, hopeful=hopeful)
        self.last = then.last
        return made, then.shown

    def take_over(self, then: SearchedSoFar) -> None:
        """Go on from what was searched ahead."""
        self.shown.fits.update(then.fits)
        self.shown = replace(then, fits=self.shown.fits)

    def _worth_making(self, *, done: bool, hopeful: bool) -> Iterator[tuple[float, bool]]:
        """The next search that is worth making as things stand, as long as there is one; the others are dropped."""
        shown = self.shown
        while shown.left:
            worse, bright = shown.left[0]
            if bright:
                if not (done or hopeful) and shown.wants_light and shown.any_fits:
                    yield worse, bright
                    continue
                shown.fits[worse] = shown.fits_here
            else:
                is_less = worse in LESS_WORSE
                if done or (is_less and (self.with_room or shown.any_fits)) or (hopeful and worse not in self.rungs):
                    shown.left.clear()
                    return
                shown.fits_here = False
                if worse not in shown.fits and not self._is_vain(worse):
                    yield worse, bright
                    continue
                shown.any_fits |= shown.fits.get(worse, False)
                shown.left.pop(0)
            shown.left.pop(0)

    def _is_vain(self, worse: float) -> bool:
        """Whether nothing does with these numbers, as nothing does with some that are less worse."""
        return any(worse >= share for share, fit in self.shown.fits.items() if not fit)

    def _found(self, worse: float, bright: bool, deadline: Deadline) -> list[Found]:
        """What a search finds in such numbers, by its places among all parts."""
        known = self.last if self.last is not None and self.last[0] == worse else None
        changed, imagers = (worse_problem(self.problem, self.scenarios, worse), None) if known is None else known[1:]
        goal = Objective.of("snr_db") if bright else self.objective
        search = Search(changed, goal, top=A_SEARCH, deadline=deadline, imagers=imagers)
        best = search.whole().best
        self.last = worse, changed, search.every_imager
        return [among(self.problem, one, changed) for one in best]
