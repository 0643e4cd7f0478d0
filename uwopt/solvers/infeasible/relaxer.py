"""Searches of a mission without some requirement, that share what it leaves alone: parts, light, imagers."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from uwopt.catalog.choose import Selection
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.assembly import build_problem, selected
from uwopt.forward.bars import MAY_SHOW
from uwopt.forward.lamps import Mount
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.weakened import DEEP
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.account import NOT_REACHED
from uwopt.solvers.exact.imagers import FittingPairs, Imagers, fitting_pairs, landscapes
from uwopt.solvers.infeasible.freed_rules import (
    FREES,
    HOURS,
    OF_HOURS,
    OF_LIGHT,
    OTHER_LAMPS,
    OTHER_WATER,
    in_the_way,
    untouched,
)
from uwopt.solvers.infeasible.none_left import DEPTH
from uwopt.solvers.infeasible.relaxed_imagers import RelaxedImagers, few_places, in_best_housing
from uwopt.solvers.infeasible.sharpest import SHARP, least_contrast_asked, most_of_parts
from uwopt.solvers.recommend import Sought
from uwopt.solvers.warm.tables import asking, imagers_of_pairs

FEW_PAIRS = 5000  # of camera and lens behind ports, likewise, of which most break some rule
FEW_IMAGERS = 250  # that are tried before all: where something fits at all, it is mostly among them
FEW_SHARPEST = 8  # the same, of those that may be sharpest

CHEAPEST = Objective.of("cost")
FEWER_PARTS = ("min_snr_red_db",)  # that some cameras never meet, and are left out for
ANY = Objective.of("power")  # where any design that fits will do: by no other objective takes a search less


@dataclass(frozen=True)
class Searchable:
    """Where designs of a mission that asks for less are looked for."""

    selection: Selection
    problem: Problem
    few: Callable[[int], Imagers | None]  # about so many from all over; None where that is of no use
    every: Callable[..., Imagers | None]  # in time, of every housing or one; None: whoever searches lists them

    def search(self, goal: Objective, imagers: Imagers | None, **how: Any) -> Sought:
        """What a search of some imagers finds, or of all; `how` as `Search` takes it."""
        return Sought.of(self.selection, self.problem, goal, imagers=imagers, **how)


class Relaxer(RelaxedImagers):
    """One mission's searches without this or that requirement, or with a key moved.

    A mission differs from it in what is `freed`: requirements that are dropped or ask for less, keys that are moved and
    ask for less, `OTHER_WATER`, `OTHER_LAMPS`; any other name stands for parts or scenes that may be others.
    """

    def seek(
        self, mission: Mission, goal: Objective, freed: Collection[str], *, deadline: Deadline = NEVER,
        enough: bool = False, ceiling: float = math.inf, few_first: bool = True, likely: bool = False,
        depth_m: float | None = None,
    ) -> Sought:  # fmt: skip
        """Search for a mission that differs in these. `enough` as in `Search`.

        few_first : where one design is enough, look for it among a few imagers before all
        likely : that something fits: so too where all are soon known
        depth_m : for which parts must be rated; None: as the mission asks
        """
        where = self._searchable(mission, freed, depth_m)
        soon_known = self.is_soon_known(freed if self._has_same_parts(freed) else ())
        if few_first and enough and (likely or not soon_known) and not deadline.passed():
            few = where.few(FEW_IMAGERS)
            found = None if few is None else where.search(goal, few, deadline=deadline, enough=True)
            if found is not None and (found.outcome.best or found.outcome.interrupted):  # else it proves nothing
                return found
        every = where.every(deadline, one_housing=enough)
        return where.search(goal, every, deadline=deadline, ceiling=ceiling, enough=enough)

    def among_few(
        self, mission: Mission, goal: Objective, freed: Collection[str], deadline: Deadline = NEVER, *,
        enough: bool = True, number: int = FEW_IMAGERS, **how: Any,
    ) -> Sought | None:  # fmt: skip
        """A search of about so many imagers from all over the catalogue; None where that is of no use.

        Where none of them fits, that proves nothing. `how` as `Search` takes it.
        """
        if deadline.passed():
            return None
        where = self._searchable(mission, freed)
        few = where.few(number)
        return None if few is None else where.search(goal, few, deadline=deadline, enough=enough, **how)

    def cheapest(
        self, mission: Mission, freed: Collection[str], *, deadline: Deadline = NEVER, ceiling: float = math.inf
    ) -> Sought:
        """A search for what fits at the least prices, as these count against the mission's limit of cost."""
        problem = self.asking(mission).at_limit_prices()
        imagers: Imagers | None = None
        if self._is_known(freed):
            imagers = self.imagers_in_time(problem, freed, deadline, one_housing=mission.limits.mass_kg is None)
        return Sought.of(self.selection, problem, CHEAPEST, deadline=deadline, ceiling=ceiling, imagers=imagers)

    def standing_anywhere(self, mounts: Collection[Mount], deadline: Deadline) -> Sought | None:
        """A search of what is asked with lamps at any of these places; None of a catalogue too large for a list."""
        known = self.known_in_best_housing
        if known is None:
            return None
        problem = self.asking(self.mission).having(mounts=tuple(mounts))
        return Sought.of(self.selection, problem, ANY, imagers=known, enough=True, deadline=deadline)

    # ------------------------------------------------------------ where to look

    def _searchable(self, mission: Mission, freed: Collection[str], depth_m: float | None = None) -> Searchable:
        """Of imagers of which it is known what they break; of the same parts; or of parts chosen anew."""
        if not self._has_same_parts(freed):
            selection = selected(mission, self.catalog, generic=self.generic, depth_m=depth_m)
            problem = build_problem(mission, selection, scenes=self.problem.scenes_for(mission))
            pairs = fitting_pairs(problem)
        else:
            selection, pairs = self.selection, self.pairs
            problem = build_problem(mission, selection) if OTHER_WATER in freed else self.asking(mission)
            if OTHER_LAMPS in freed:
                problem = problem.standing_as_asked()
        if self._is_known(freed):
            few, every = partial(self._few_known, problem, freed), partial(self.imagers_in_time, problem, freed)
            return Searchable(selection, problem, few, every)
        few = partial(few_behind_ports, problem, pairs)
        return Searchable(selection, problem, few, lambda deadline, one_housing: None)

    def _has_same_parts(self, freed: Collection[str]) -> bool:
        """Whether the mission allows no other parts, nor other scenes but for their water."""
        others = HOURS in freed and any(one.rule in OF_HOURS for one in self.selection.excluded)
        return set(freed) <= FREES.keys() and not others

    def _is_known(self, freed: Collection[str]) -> bool:
        """Whether the imagers that are left are among those of which it is known what they break."""
        return self._has_same_parts(freed) and not self.are_too_many

    def _few_known(self, problem: Problem, freed: Collection[str], number: int) -> Imagers | None:
        """About so many imagers that break nothing but rules behind what is freed; None where there are hardly more."""
        known = self.known_in_best_housing
        if known is not None and OF_LIGHT.issuperset(freed):
            share = len(known) // number
            if share < 2:
                return None
            if self.sharpest is not None and set(freed) == {SHARP}:
                return known.take(self.sharpest.first(FEW_SHARPEST))
            return known.take(np.arange(0, len(known), share))
        freed_pairs = self._freed_pairs(freed)
        if sum(map(len, freed_pairs.values())) < 2 * number:
            return None
        some = few_places(place for place, rows in freed_pairs.items() if len(rows))
        share = max(1, sum(len(freed_pairs[place]) for place in some) // number)
        few = {place: freed_pairs[place][start % share :: share] for start, place in enumerate(some)}
        if set(freed) == {"cost"}:
            few = self._with_cheapest(few, freed_pairs)
        return self._imagers_of(problem, few, NEVER, one_housing=True)

    def asking(self, mission: Mission) -> Problem:
        """The tables for a mission that asks for less of the same parts in the same scenes."""
        return asking(self.problem, mission, self.selection)

    def why_not(self, found: Sought, name: str) -> tuple[str, ...]:
        """What stands in the way of a search without a requirement or with a key moved; `name`: of it.

        Where it had no imager, that is what leaves none in the search of all that is asked.
        """
        none = () if self.like is None or self.like.outcome.best else in_the_way(self.like, name)
        return in_the_way(found, name) or none

    @cached_property
    def settled(self) -> dict[str, tuple[str, ...]]:
        """What the search that found nothing proves not to help alone, and what is in the way even so."""
        like = self.like
        if like is None or not like.outcome.complete or like.outcome.best or like.problem.mission != self.mission:
            return {}
        return {name: in_the_way(like, name) for name in untouched(like.outcome.account)}

    def useless_alone(self, names: Iterable[str]) -> dict[str, tuple[str, ...]]:
        """Requirements or keys of these that are known not to help alone, and what is in the way even so."""
        known = {name: self.settled[name] for name in names if name in self.settled}
        return known | {name: rules for name in names if (rules := self.never_without(name))}

    def never_without(self, name: str) -> tuple[str, ...]:
        """What stands in the way whatever a requirement or key is, as no part ever meets it; nothing where any may."""
        if name in (SHARP, *FEWER_PARTS) or not self.is_never_sharp:
            return ()
        out = {DEEP: (DEPTH,), HOURS: OF_HOURS}.get(name, ())
        has_more = any(one.kind == "complete" and one.rule in out for one in self.selection.excluded)
        return () if has_more else (SHARP,)

    @cached_property
    def is_never_sharp(self) -> bool:
        """Whether no camera with any lens leaves the fine detail that is asked for, whatever else is asked."""
        wanted = least_contrast_asked(self.mission)
        if not wanted.any() or self.problem.paper or self.are_too_many or not len(self.pairs.camera):
            return False
        most = most_of_parts(self.problem, self.pairs.camera, self.pairs.lens).max(axis=0)
        return bool((most < wanted).any())

    def beyond(self, name: str, asked: float) -> float:
        """The limit of a requirement nearest to what is asked at which bounds already tell that nothing fits."""
        if name != SHARP or self.sharpest is None:
            return asked
        wanted, most = least_contrast_asked(self.mission), self.sharpest.most
        return float(min([asked, *(most[most < wanted] / MAY_SHOW)]))


def few_behind_ports(problem: Problem, pairs: FittingPairs, number: int) -> Imagers | None:
    """The imagers of a few pairs of camera and lens behind all ports; None where there are hardly more pairs."""
    every = [(int(ports[0]), landscape) for ports in problem.port_groups for landscape in landscapes(problem)]
    most = FEW_PAIRS * number // FEW_IMAGERS
    if len(pairs.camera) * len(every) < 2 * most:
        return None
    places = few_places(every)
    share = max(1, len(pairs.camera) * len(places) // most)
    some = {
        place: (pairs.camera[start % share :: share], pairs.lens[start % share :: share])
        for start, place in enumerate(places)
    }
    return imagers_of_pairs(problem, some, lambda block: in_best_housing(problem, block))


def hope(found: Sought) -> float:
    """The share of a search's designs that no rule discards: solved, or not reached in time."""
    account = found.outcome.account
    return (account.evaluated + account.discarded.get(NOT_REACHED, 0)) / max(account.total, 1)
