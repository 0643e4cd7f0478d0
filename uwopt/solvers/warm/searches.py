"""The certified optimum of many missions that differ in some keys, each search helped by those before it.

Missions of one family differ in keys of which more is sure to ask for more (a speed, a least SNR, a budget that
shrinks). Of the first of them every imager is bounded; a stricter one is searched among the imagers whose bound is no
more than what is reached there, which are few: what it finds is the optimum over the whole catalogue. Missions in other
water or at another height start anew, with what the last winners reach there as a ceiling.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from uwopt.arrays import Array
from uwopt.catalog.choose import Selection, ToBeMade
from uwopt.catalog.records import Kind
from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.mission.mission import Mission
from uwopt.mission.strictness import Asking, apart_from_light
from uwopt.model.fineness import DEFAULT
from uwopt.objectives.goal import goal_of
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.imagers import Imagers, enumerate_imagers, fitting_pairs
from uwopt.solvers.exact.ranking import Found, comes_before
from uwopt.solvers.exact.search import Search, are_too_many
from uwopt.solvers.recommend import GENERIC_GAIN, Sought, fewest_made, with_fewest_lamps
from uwopt.solvers.settings.best import scenes_need_cells
from uwopt.solvers.warm.kept import Family, KeptBounds, Met, least_of_designs, least_of_nodes, some_nodes
from uwopt.solvers.warm.parts import PartIds, ids_of, joined_ids, only
from uwopt.solvers.warm.tables import asking
from uwopt.tolerances import AGREES_REL

FIRST = 500  # nodes that are searched first where no weaker mission is known to be met
MANY = 50_000  # nodes to search where nothing is known to fit: worth a closer look at the last mission that was met
WORTH_BOUNDING = 1000  # nodes that had to be searched: few of them are left once they are bounded at this mission
MOST_FAMILIES = 12  # whose bounds are kept: up to 10 MB each
MOST_SCENES = 8  # problems that are remembered for the light of their scenes


@dataclass(frozen=True)
class WarmAnswer:
    """The optimum of one mission."""

    sought: Sought | None  # None: known to fit nowhere without a search
    found: Found | None
    complete: bool
    lower_bound: float
    generic: bool  # whether parts to be made were needed
    capped: bool  # whether the gain cap of the mission's reserve holds
    kept: bool  # proven by bounds of another mission


@dataclass(frozen=True)
class WarmStage:
    """One of the searches of a mission, of which the first that finds something counts."""

    mission: Mission
    asks: Asking
    generic: ToBeMade
    capped: bool
    selection: Selection

    def answer(self, sought: Sought | None, *, kept: bool) -> WarmAnswer:
        """What a search in this stage has found."""
        by = self.generic != "never", self.capped, kept
        if sought is None:
            return WarmAnswer(None, None, True, math.inf, *by)
        outcome = sought.outcome
        found = outcome.best[0] if outcome.best else None
        return WarmAnswer(sought, found, outcome.complete, outcome.lower_bound, *by)


class Warm:
    """Searches of missions, one after another; those that ask for least are best given first (`weakest_first`)."""

    def __init__(self, deadline: Deadline = NEVER):
        self.deadline = deadline
        self.families: dict[tuple[str, ToBeMade], Family] = {}
        self.asked: dict[str, list[tuple[Asking, Mission]]] = {}
        self.selections: dict[Any, Selection] = {}
        self.winners: list[PartIds] = []
        self.known: list[Problem] = []
        self.listed: tuple[Any, Imagers] | None = None  # the last that were listed, and of what
        self.n_searches = 0

    # ------------------------------------------------------------ one mission

    def best(self, mission: Mission, *, ahead: bool = True) -> WarmAnswer:
        """The optimum of a mission: of parts on sale, else with parts to be made, as `solve` has it.

        Raises KeyboardInterrupt.

        ahead : missions that ask for more will follow, so that bounds pay
        """
        return self._first_stage(mission, lambda stage: self._in_stage(stage, ahead=ahead))

    def among(self, mission: Mission, parts: PartIds) -> WarmAnswer:
        """The same among a few parts."""

        def searched(stage: WarmStage) -> WarmAnswer:
            return stage.answer(self._few(stage, parts), kept=False)

        return self._first_stage(mission, searched)

    def _first_stage(self, mission: Mission, search: Callable[[WarmStage], WarmAnswer]) -> WarmAnswer:
        """The answer of the first stage in which something fits, or in which that is not known; lamps as in `solve`."""
        lifted = mission.without_gain_cap
        answer = self._with_fewest_made(mission, search, capped=True)
        if answer.found is None and answer.complete and lifted is not mission:
            answer = self._with_fewest_made(lifted, search, capped=False)
        if answer.found is None or answer.sought is None:
            return answer
        return replace(answer, found=with_fewest_lamps(answer.sought, self.deadline).outcome.best[0])

    def _with_fewest_made(
        self, mission: Mission, search: Callable[[WarmStage], WarmAnswer], *, capped: bool
    ) -> WarmAnswer:
        """The answer with the parts to be made that the mission lets in at first, else of fewest kinds, as `solve`."""
        asks, choice, goal = Asking.of(mission), mission.catalog, goal_of(mission)
        answers: dict[ToBeMade, WarmAnswer] = {}

        def answer(generic: ToBeMade) -> WarmAnswer:
            selection = self._selected(mission, asks, generic)
            answers[generic] = search(WarmStage(mission, asks, generic, capped, selection))
            return answers[generic]

        first, last = choice.generic_at_first, choice.generic_at_last
        made = answer(first)
        if made.found is not None or first == last or not made.complete:
            return made
        every = answer(last)
        if every.found is None or not every.complete:
            return every
        ceiling = every.found.minimised + goal.step(GENERIC_GAIN, every.found.minimised)

        def serves(kinds: tuple[Kind, ...]) -> bool:
            found = answer(kinds).found
            return found is not None and found.minimised <= ceiling

        return answers.get(fewest_made(serves), every)  # of all kinds, that is `every`

    def _in_stage(self, stage: WarmStage, *, ahead: bool) -> WarmAnswer:
        """The optimum with parts to be made or without, with the cap of gain or without."""
        asks, family = stage.asks, self._family(stage)
        before = self.asked.setdefault(asks.family, [])
        try:
            if any(one.asks_no_more(asks) for one in family.missed):
                return stage.answer(None, kept=True)
            sought = self._warm(stage, family, ahead)
            kept = sought is not None
            if sought is None:
                sought = self._cold(stage, family, ahead)
        finally:
            if not any(asks == other for other, _ in before):
                before.append((asks, stage.mission))
        best, complete = sought.outcome.best, sought.outcome.complete
        if best:
            self._remember(sought)
        if best:
            family.show(goal_of(stage.mission), asks, best[0].minimised)
        if complete:
            family.prove(goal_of(stage.mission), asks, sought.outcome.lower_bound)
        if best and complete:
            family.met.append(Met(asks, stage.mission, best[0].minimised, sought.outcome.lower_bound))
        elif complete:
            family.missed.append(asks)
        return stage.answer(sought, kept=kept)

    def take(self, sought: Sought) -> None:
        """What a search over all parts of a mission has worked out, as if it had been the first of these."""
        problem, outcome, mission = sought.problem, sought.outcome, sought.problem.mission
        if problem.fineness != DEFAULT or not outcome.best:
            return
        self._remember(sought)
        asks, search = Asking.of(mission), sought.search
        if not outcome.complete or search.every_imager is None or search.only:
            return
        policies: tuple[ToBeMade, ...] = (sought.selection.generic, "allow")
        for generic in dict.fromkeys(policies):
            selection = self._selected(mission, asks, generic)
            if selection.indices == sought.selection.indices:
                family = self._family(WarmStage(mission, asks, generic, True, selection))
                family.waiting = asks, sought
                family.met.append(Met(asks, mission, reached_by(sought), outcome.lower_bound))
                self.asked.setdefault(asks.family, []).append((asks, mission))

    # ------------------------------------------------------------ with what is known

    def _warm(self, stage: WarmStage, family: Family, ahead: bool) -> Sought | None:
        """The optimum by bounds of a mission that asks for no more; None where there are none."""
        weaker = family.nearest_met(stage.asks)
        goal, most = goal_of(stage.mission), math.nan
        if weaker is not None:
            most = weaker.minimised + goal.step(family.share, weaker.minimised)
        try:
            kept = self._bounds(stage, family, most)
            if kept is None or not len(kept):
                return None
            if weaker is None:
                most = float(kept.least[min(FIRST, len(kept)) - 1])
            sought = self._within(stage, kept, most)
            reached = reached_by(sought)
            if sought.outcome.complete and reached > most:
                if math.isinf(reached) and weaker is not None:
                    kept = self._closer(family, kept, weaker)
                sought, most = self._beyond(stage, kept, most, sought)
            if weaker is not None and sought.outcome.best:
                family.learn(goal, weaker, reached_by(sought))
            if ahead and sought.outcome.best and sought.outcome.complete:
                self._refresh(stage, family, kept, min(most, reached_by(sought)))
        except OutOfTimeError:
            return None
        return sought

    def _bounds(self, stage: WarmStage, family: Family, most: float) -> KeptBounds | None:
        """The bounds of a mission that asks for no more by which least is to be searched; None where there are none."""
        if family.waiting is not None and family.waiting[0].asks_no_more(stage.asks):
            (asks, sought), family.waiting = family.waiting, None
            family.keep(asks, KeptBounds.of(sought.search, sought.selection, self._least(sought.search)))
        if not any(asks.asks_no_more(stage.asks) for asks, _ in family.bounds):
            self._anchor(stage, family)
        holding = [kept for asks, kept in family.bounds if asks.asks_no_more(stage.asks)]
        holding = [kept for kept in holding if kept.selection.indices == stage.selection.indices]
        return min(holding, key=lambda kept: len(kept.within(most)), default=None)

    def _anchor(self, stage: WarmStage, family: Family) -> None:
        """Bounds of the strictest mission known that asks for less, of which only other stages were searched."""
        asked = self.asked[stage.asks.family]
        weaker = [one for one in asked if one[0].asks_no_more(stage.asks) and one[0] != stage.asks]
        if not weaker:
            return
        asks, mission = max(weaker, key=lambda one: one[0].amounts)
        selection = self._selected(mission, asks, stage.generic)
        problem = build_problem(mission, selection, scenes=self._scenes(mission))
        if not are_too_many(problem, fitting_pairs(problem)):
            search = self._search(problem, goal_of(mission))
            search.prepare()
            family.keep(asks, KeptBounds.of(search, selection, self._least(search)))

    def _closer(self, family: Family, kept: KeptBounds, met: Met) -> KeptBounds:
        """Bounds by the light of every design, where very many nodes would have to be searched otherwise."""
        if kept.tight or len(kept) < MANY or self._is_slow(kept.problem, goal_of(met.mission)):
            return kept
        search = self._of_nodes(met.mission, kept, kept.node)
        search.prepare()
        made = replace(KeptBounds.of(search, kept.selection, least_of_designs(search, self.deadline)), tight=True)
        family.keep(met.asks, made)
        return made

    def _refresh(self, stage: WarmStage, family: Family, kept: KeptBounds, most: float) -> None:
        """Bounds of this mission for those to come, where many nodes had to be searched by older ones."""
        some = kept.within(most)
        if len(some) > WORTH_BOUNDING:
            search = self._of_nodes(stage.mission, kept, some)
            search.prepare()
            made = KeptBounds.of(search, kept.selection, self._least(search, tight=True))
            family.keep(stage.asks, kept.with_some(some, made))

    def _least(self, search: Search, *, tight: bool = False) -> Array:
        """Bounds of the nodes of a search."""
        slow = not tight or self._is_slow(search.problem, search.objective)
        return (least_of_nodes if slow else least_of_designs)(search, self.deadline)

    @staticmethod
    def _is_slow(problem: Problem, goal: Objective) -> bool:
        """Whether settings have no closed form, so that no design is looked at for its bound alone."""
        return scenes_need_cells(problem.scenes, goal)

    def _within(self, stage: WarmStage, kept: KeptBounds, most: float) -> Sought:
        """A search of the nodes whose bound is no more than a value."""
        return self._run(stage.selection, self._of_nodes(stage.mission, kept, kept.within(most)))

    def _beyond(self, stage: WarmStage, kept: KeptBounds, most: float, first: Sought) -> tuple[Sought, float]:
        """The better of what is found and of nodes whose bound is more than a value, and up to where these count."""
        reached = reached_by(first)
        ceiling = reached + AGREES_REL * abs(reached) if math.isfinite(reached) else math.inf
        rest = kept.within(ceiling, beyond=most if math.isfinite(reached) else -math.inf)
        other = self._run(stage.selection, self._of_nodes(stage.mission, kept, rest, ceiling))
        best = other if not first.outcome.best or is_better(other, first) else first
        if not other.outcome.complete:
            best = replace(best, outcome=replace(best.outcome, complete=False, lower_bound=other.outcome.lower_bound))
        return best, ceiling

    def _of_nodes(
        self, mission: Mission, kept: KeptBounds, some: Array, ceiling: float = math.inf
    ) -> Search:
        """A search of some nodes for a mission."""
        problem = asking(kept.problem, mission, kept.selection)
        imagers, lights = some_nodes(problem, some)
        return self._search(
            problem, goal_of(mission), ceiling=ceiling, imagers=imagers, lights=lights, widest_m=kept.widest_m
        )

    # ------------------------------------------------------------ anew

    def _cold(self, stage: WarmStage, family: Family, ahead: bool) -> Sought:
        """A search over all parts, below what the last winners reach; its bounds are taken once they are asked for."""
        mission, selection, goal = stage.mission, stage.selection, goal_of(stage.mission)
        reached = self._reached(stage)
        ceiling = reached + AGREES_REL * abs(reached) if math.isfinite(reached) else math.inf
        problem = build_problem(mission, selection, scenes=self._scenes(mission))
        imagers: Imagers | None = None
        if ahead and not are_too_many(problem, fitting_pairs(problem)):
            imagers = self._every_imager(problem, selection)  # those too that are beyond the ceiling here
        sought = self._run(selection, self._search(problem, goal, ceiling=ceiling, imagers=imagers))
        if not sought.outcome.best and sought.outcome.complete and math.isfinite(ceiling):
            sought = self._run(selection, self._search(problem, goal, imagers=imagers))  # reached by rounding alone
        if imagers is not None and sought.outcome.complete:
            family.waiting = stage.asks, sought
        return sought

    def _every_imager(self, problem: Problem, selection: Selection) -> Imagers:
        """All imagers of a mission: those of the last where it was the same but for its light."""
        index = tuple(scene.n_water for scene in problem.scenes)
        key = apart_from_light(problem.mission), index, selection.indices
        if self.listed is None or self.listed[0] != key:
            self.listed = key, enumerate_imagers(problem)
        return self.listed[1]

    def _reached(self, stage: WarmStage) -> float:
        """What the parts of the last winners reach here; inf where they do not fit."""
        if not self.winners:
            return math.inf
        return reached_by(self._few(stage, joined_ids(self.winners)))

    def _few(self, stage: WarmStage, parts: PartIds) -> Sought:
        """A search among a few parts."""
        few = only(stage.selection, parts)
        problem = build_problem(stage.mission, few, scenes=self._scenes(stage.mission))
        goal = goal_of(stage.mission)
        sought = self._run(few, self._search(problem, goal))
        self._remember_scenes(problem)
        if sought.outcome.best:
            self._family(stage).show(goal, stage.asks, reached_by(sought))
        return sought

    # ------------------------------------------------------------ what all share

    def _search(
        self, problem: Problem, goal: Objective, *, ceiling: float = math.inf, imagers: Imagers | None = None,
        lights: Array | None = None, widest_m: Sequence[float] | None = None,
    ) -> Search:  # fmt: skip
        """One certified search, of some imagers and lights or of all."""
        only = {} if lights is None else {"light": lights}
        return Search(
            problem, goal, top=1, ceiling=ceiling, deadline=self.deadline, imagers=imagers, only=only, widest_m=widest_m
        )

    def _run(self, selection: Selection, search: Search) -> Sought:
        """What a search finds; raises KeyboardInterrupt where a person ends it."""
        self.n_searches += 1
        found = Sought(selection, search.problem, search, search.run())
        if found.outcome.interrupted:
            raise KeyboardInterrupt
        return found

    def _family(self, stage: WarmStage) -> Family:
        """What is known of missions like this; of the families the last few are kept."""
        key = stage.asks.family, stage.generic
        made = self.families.pop(key, None) or Family()
        self.families[key] = made
        while len(self.families) > MOST_FAMILIES:
            del self.families[next(iter(self.families))]
        return made

    def _selected(self, mission: Mission, asks: Asking, generic: ToBeMade) -> Selection:
        """The parts that a mission allows, chosen once for missions that ask for the same of parts alone."""
        key = asks.family, generic, mission.required_depth_m, mission.vehicle.duration_h
        if key not in self.selections:
            self.selections[key] = selected(mission, load_catalog(mission), generic=generic)
        return self.selections[key]

    def _scenes(self, mission: Mission) -> list[SceneOptics] | None:
        """The scenes with the light that an earlier search in them has worked out; None where they are new."""
        for problem in reversed(self.known):
            scenes = problem.scenes_for(mission)
            if scenes is not None:
                return scenes
        return None

    def _remember(self, sought: Sought) -> None:
        """The winner's parts, and its scenes."""
        ids = ids_of(sought.problem, sought.outcome.best[0])
        self.winners = [ids, *(one for one in self.winners if one != ids)][:2]
        self._remember_scenes(sought.problem)

    def _remember_scenes(self, problem: Problem) -> None:
        """The light of a problem's scenes, for others in these."""
        if self._scenes(problem.mission) is None:
            self.known = [*self.known[1 - MOST_SCENES :], problem]


def reached_by(sought: Sought) -> float:
    """The best value that a search has found; inf of none."""
    best = sought.outcome.best
    return best[0].minimised if best else math.inf


def is_better(other: Sought, first: Sought) -> bool:
    """Whether a search of further nodes of the same parts has found what comes before what is known."""
    found = other.outcome.best
    return bool(found) and comes_before(found[0], first.outcome.best[0], first.problem.parts)


def weakest_first(missions: Sequence[Mission]) -> list[int]:
    """The order in which missions are best solved: families together, and in each what asks for less first."""
    asks = [Asking.of(mission) for mission in missions]
    place = {family: n for n, family in enumerate(dict.fromkeys(one.family for one in asks))}
    return sorted(range(len(missions)), key=lambda n: (place[asks[n].family], asks[n].amounts))
