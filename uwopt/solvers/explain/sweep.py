"""The certified optimum at many values of a mission's keys, each search helped by those before it.

A search at one point lists all hardware whose objective is within a ceiling. Where a key only ever asks for more (a
speed, a least SNR, a budget that shrinks), no hardware is better at a stricter point than it was: what was beyond the
ceiling stays beyond. So a stricter point needs a search over the listed parts alone; whatever it finds within the
ceiling is the optimum over the whole catalogue. A point that no list covers is searched in full, with what the last
winner still reaches there as a ceiling.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from uwopt.catalog.choose import Selection
from uwopt.catalog.records import Kind
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.assembly import Generic, build_problem, load_catalog, selected
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.recommend import Sought, same_scenes
from uwopt.tolerances import AGREES_REL

MOST_LISTED = 200  # hardware in one list
FIRST_SHARE, LEAST_SHARE, MOST_SHARE = 0.3, 0.02, 1.0  # by which listed hardware may be worse than the best
MOST_SCENES = 8  # problems that are remembered for the light of their scenes
LISTS_TRIED = 2  # newest first, before a point is searched in full
At = tuple[Any, ...]  # the values of the varied keys, in their order
PartIds = Mapping[Kind, frozenset[str]]


@dataclass(frozen=True)
class Listed:
    """All hardware that is within a ceiling at a point: by parts, of each kind by ids. No parts: nothing fits there."""

    at: At
    ceiling: float
    parts: PartIds


@dataclass(frozen=True)
class SweepAnswer:
    """The optimum at one point."""

    sought: Sought
    found: Found | None
    complete: bool
    lower_bound: float
    generic: bool  # whether parts to be made were needed
    capped: bool  # whether the gain cap of the mission's reserve holds
    listed: bool  # proven by a list of an earlier point
    interrupted: bool = False


@dataclass(frozen=True)
class SweepStage:
    """One of the searches of a mission, of which the first that finds something counts."""

    mission: Mission
    generic: Generic
    capped: bool
    selection: Selection

    def answer(self, sought: Sought, *, listed: bool) -> SweepAnswer:
        """What a search in this stage has found."""
        outcome = sought.outcome
        found = outcome.best[0] if outcome.best else None
        return SweepAnswer(
            sought, found, outcome.complete, outcome.lower_bound, self.generic == "allow", self.capped, listed,
            outcome.interrupted,
        )  # fmt: skip


class Sweep:
    """Searches of missions that differ in some keys."""

    def __init__(self, objective: Objective, strictness: tuple[int, ...], deadline: Deadline = NEVER):
        """`strictness`: of each key 1 where more of it asks for more, -1 where less does, 0 where that is not sure."""
        self.objective, self.strictness, self.deadline = objective, strictness, deadline
        self.lists: dict[tuple[bool, Generic], list[Listed]] = {}
        self.winners: list[PartIds] = []
        self.known: list[Problem] = []
        self.share = FIRST_SHARE
        self.n_searches = 0

    def covers(self, weak: At, strict: At) -> bool:
        """Whether a point asks for no less than another, in keys where that is sure, and is equal in the rest."""
        return all(
            a == b or (sign and sign * (b - a) > 0)
            for a, b, sign in zip(weak, strict, self.strictness, strict=True)
        )

    def best(self, mission: Mission, at: At, *, ahead: bool = False) -> SweepAnswer:
        """The optimum of a mission at a point: of parts on sale, else with parts to be made, as `solve` has it.

        ahead : stricter points will be asked for, so that a list pays
        """
        return self._first_stage(mission, partial(self._in_stage, at, ahead))

    def among(self, mission: Mission, parts: PartIds) -> SweepAnswer:
        """The same among a few parts."""

        def searched(stage: SweepStage) -> SweepAnswer:
            few = only(stage.selection, parts)
            return stage.answer(self._search(stage.mission, few, self._scenes(stage.mission), top=1), listed=False)

        return self._first_stage(mission, searched)

    @staticmethod
    def _first_stage(mission: Mission, search: Callable[[SweepStage], SweepAnswer]) -> SweepAnswer:
        """The answer of the first stage in which something fits, or in which that is not known."""
        policy, answer = mission.catalog.generic, None
        stages: list[Generic] = ["never", "allow"] if policy == "fallback" else [policy]
        lifted = mission.without_gain_cap
        for wanted in (mission,) if lifted is mission else (mission, lifted):
            for generic in stages:
                selection = selected(wanted, load_catalog(wanted), generic=generic)
                answer = search(SweepStage(wanted, generic, wanted is mission, selection))
                if answer.found is not None or not answer.complete:
                    return answer
        assert answer is not None
        return answer

    def _in_stage(self, at: At, ahead: bool, stage: SweepStage) -> SweepAnswer:
        """The optimum with parts to be made or without, with the cap of gain or without."""
        mission, selection = stage.mission, stage.selection
        scenes, lists = self._scenes(mission), self.lists.setdefault((stage.capped, stage.generic), [])
        covering = [one for one in lists if self.covers(one.at, at)]
        if any(not one.parts for one in covering):
            return stage.answer(self._search(mission, only(selection, {}), scenes, top=1), listed=True)
        for one in covering[: -LISTS_TRIED - 1 : -1]:
            few = self._search(mission, only(selection, one.parts), scenes, top=1)
            best = few.outcome.best
            if best and best[0].minimised <= one.ceiling and few.outcome.complete:
                self._remember(few)
                return stage.answer(few, listed=True)
        sought: Sought | None = None
        reached = self._reached(mission, selection, scenes)
        if not math.isfinite(reached):
            sought = self._search(mission, selection, scenes, top=1)
            if not sought.outcome.best and sought.outcome.complete:
                lists.append(Listed(at, math.inf, {}))
            reached = sought.outcome.best[0].minimised if sought.outcome.best else math.inf
        if math.isfinite(reached) and (sought is None or ahead):
            sought = self._within(stage, scenes, at, reached, ahead) or sought
        assert sought is not None
        if sought.outcome.best:
            self._remember(sought)
        return stage.answer(sought, listed=False)

    def _within(
        self, stage: SweepStage, scenes: list[SceneOptics] | None, at: At, reached: float, ahead: bool
    ) -> Sought:
        """A search below what is known to be reached, with a list for what comes if that pays."""
        ceiling = reached + AGREES_REL * abs(reached) + (self.objective.step(self.share, reached) if ahead else 0.0)
        top = MOST_LISTED if ahead else 1
        sought = self._search(stage.mission, stage.selection, scenes, top=top, ceiling=ceiling)
        if not sought.outcome.best and sought.outcome.complete:  # what is reached is so by rounding alone
            return self._search(stage.mission, stage.selection, scenes, top=1)
        if ahead and sought.outcome.complete:
            self.lists[stage.capped, stage.generic].append(self._list(sought, at, ceiling))
        return sought

    def _list(self, sought: Sought, at: At, ceiling: float) -> Listed:
        """What a search has found within its ceiling; where its list is full, within the value of its last."""
        best = sought.outcome.best
        if len(best) == MOST_LISTED:
            last = best[-1].minimised
            ceiling, self.share = last, max(0.5 * self.share, LEAST_SHARE)
        elif len(best) < MOST_LISTED // 3:
            self.share = min(1.5 * self.share, MOST_SHARE)
        parts = joined_ids([ids_of(sought.problem, found) for found in best])
        return Listed(at, ceiling - AGREES_REL * abs(ceiling), parts)

    def _reached(self, mission: Mission, selection: Selection, scenes: list[SceneOptics] | None) -> float:
        """What the parts of the last winners reach here; inf where they do not fit."""
        if not self.winners:
            return math.inf
        few = only(selection, joined_ids(self.winners))
        best = self._search(mission, few, scenes, top=1).outcome.best
        return best[0].minimised if best else math.inf

    def _search(
        self, mission: Mission, selection: Selection, scenes: list[SceneOptics] | None, *, top: int,
        ceiling: float = math.inf,
    ) -> Sought:  # fmt: skip
        """One certified search over these parts."""
        problem = build_problem(mission, selection, scenes=scenes)
        search = Search(problem, self.objective, top=top, ceiling=ceiling, deadline=self.deadline)
        self.n_searches += 1
        return Sought(selection, problem, search, search.run())

    def _scenes(self, mission: Mission) -> list[SceneOptics] | None:
        """The scenes with the light that an earlier search in them has worked out; None where they are new."""
        for problem in reversed(self.known):
            scenes = same_scenes(problem, mission)
            if scenes is not None:
                return scenes
        return None

    def _remember(self, sought: Sought) -> None:
        """The winner's parts, and its scenes."""
        ids = ids_of(sought.problem, sought.outcome.best[0])
        self.winners = [ids, *(one for one in self.winners if one != ids)][:2]
        if self._scenes(sought.problem.mission) is None:
            self.known = [*self.known[1 - MOST_SCENES :], sought.problem]


def ids_of(problem: Problem, found: Found) -> PartIds:
    """Ids of a design's parts by kind as the catalogue has them, complete cameras whole."""
    parts = problem.parts
    port = parts.ports[found.port]
    light = frozenset({parts.lights[found.light].id})
    if port.complete:
        return {"complete": frozenset({port.complete}), "light": light}
    housing = frozenset() if port.housing is None else frozenset({port.housing.id})
    return {
        "camera": frozenset({parts.cameras[found.camera].id}), "lens": frozenset({parts.lenses[found.lens].id}),
        "port": frozenset({port.id}), "housing": housing, "light": light,
    }  # fmt: skip


def joined_ids(several: list[PartIds]) -> PartIds:
    """All ids of several designs by kind."""
    kinds = {kind for ids in several for kind in ids}
    return {kind: frozenset[str]().union(*(ids.get(kind, frozenset()) for ids in several)) for kind in kinds}


def only(selection: Selection, ids: PartIds) -> Selection:
    """A selection with no other parts than these."""
    indices = {
        kind: tuple(i for i in chosen if selection.catalog.parts(kind)[i].id in ids.get(kind, ()))
        for kind, chosen in selection.indices.items()
    }
    return replace(selection, indices=indices)
