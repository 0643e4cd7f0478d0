"""Searches of a mission without some requirement, that share what it leaves alone: parts, light, imagers."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from functools import cached_property
from typing import Any

import numpy as np

from uwopt.catalog.choose import Selection
from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.assembly import build_problem, selected
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.account import NOT_REACHED
from uwopt.solvers.exact.imagers import FittingPairs, Imagers, enumerate_imagers, fitting_pairs, landscapes
from uwopt.solvers.exact.never_sharp import MAY_SHOW
from uwopt.solvers.exact.search import are_too_many
from uwopt.solvers.infeasible.freed_rules import (
    FREES,
    HOURS,
    MAY_PASS,
    MOVES_PASS,
    OF_HOURS,
    OF_LIGHT,
    OTHER_WATER,
    in_the_way,
    untouched,
)
from uwopt.solvers.infeasible.none_left import DEPTH
from uwopt.solvers.infeasible.relaxed_imagers import RelaxedImagers, few_places, in_best_housing
from uwopt.solvers.infeasible.sharpest import SHARP, asked_of, most_of_parts
from uwopt.solvers.recommend import Sought, seek
from uwopt.solvers.warm.tables import asking, imagers_of

FEW_PAIRS = 5000  # of camera and lens behind ports, likewise, of which most break some rule
FEW_IMAGERS = 250  # that are tried before all: where something fits at all, it is mostly among them
FEW_SHARPEST = 8  # the same, of those that may be sharpest
CHEAPEST = Objective.of("cost")
FEWER_PARTS = ("min_snr_red_db",)  # that some cameras never meet, and are left out for
ANY = Objective.of("power")  # where any design that fits will do: by no other objective takes a search less


class Relaxer(RelaxedImagers):
    """One mission's searches without this or that requirement."""

    def seek(
        self, mission: Mission, goal: Objective, freed: Collection[str], *, deadline: Deadline = NEVER,
        enough: bool = False, ceiling: float = math.inf, few_first: bool = True, likely: bool = False,
    ) -> Sought:  # fmt: skip
        """Search for a mission that differs in these requirements, which ask for less. `enough` as in `Search`.

        few_first : where one design is enough, look for it among a few imagers before all
        likely : that something fits: so too where all are soon known
        """
        if not set(freed) <= FREES.keys() or self.are_too_many:
            few_first &= enough and self.are_too_many
            if few_first and (soon := fitting(self.among_few(mission, goal, freed, deadline))) is not None:
                return soon
            return seek(
                mission, self.catalog, goal, generic=self.generic, deadline=deadline, like=self.problem,
                enough=enough, ceiling=ceiling,
            )  # fmt: skip
        few_first &= enough and (likely or not self.is_soon_known(freed))
        if few_first and (soon := fitting(self.among_few(mission, goal, freed, deadline))) is not None:
            return soon
        problem = self.asking(mission)
        imagers = self.imagers_in_time(problem, freed, deadline, one_housing=enough)
        return Sought.of(
            self.selection, problem, goal, deadline=deadline, ceiling=ceiling, enough=enough, imagers=imagers
        )

    def among_few(
        self, mission: Mission, goal: Objective, freed: Collection[str], deadline: Deadline = NEVER, *,
        enough: bool = True, number: int | None = None, **how: Any,
    ) -> Sought | None:  # fmt: skip
        """A search of a few imagers from all over the catalogue; None where that is of no use.

        Where none of them fits, that proves nothing. `mission` differs in these requirements, which ask for less;
        `how` as `Search` takes it.
        """
        if not set(freed) <= FREES.keys() or deadline.passed():
            return None
        if self.are_too_many:
            pairs = FEW_PAIRS * (number or FEW_IMAGERS) // FEW_IMAGERS
            asked = self.asking(mission)
            return self._soon(self.selection, asked, self.pairs, deadline, pairs, goal, enough=enough, **how)
        known, problem = self.known_in_best_housing, self.asking(mission)
        if known is not None and OF_LIGHT.issuperset(freed):
            share = len(known) // (number or FEW_IMAGERS)
            if share < 2:
                return None
            imagers = known.take(np.arange(0, len(known), share))
            if self.sharpest is not None and set(freed) == {SHARP}:
                imagers = known.take(self.sharpest.first(FEW_SHARPEST))
        else:
            freed_pairs = self._freed_pairs(freed)
            most = number or FEW_IMAGERS
            if sum(map(len, freed_pairs.values())) < 2 * most:
                return None
            some = few_places(place for place, rows in freed_pairs.items() if len(rows))
            share = max(1, sum(len(freed_pairs[place]) for place in some) // most)
            few = {place: freed_pairs[place][start % share :: share] for start, place in enumerate(some)}
            if set(freed) == {"cost"}:
                few = self._with_cheapest(few, freed_pairs)
            imagers = self._imagers_of(problem, few, NEVER, one_housing=True)
        return Sought.of(self.selection, problem, goal, imagers=imagers, deadline=deadline, enough=enough, **how)

    def cheapest(
        self, mission: Mission, freed: Collection[str], *, deadline: Deadline = NEVER, ceiling: float = math.inf
    ) -> Sought:
        """A search for what fits at the least prices, as these count against the mission's limit of cost."""
        problem = self.asking(mission).at_limit_prices()
        imagers: Imagers | None = None
        if set(freed) <= MAY_PASS.keys() and not self.are_too_many:
            imagers = self.imagers_in_time(problem, freed, deadline, one_housing=mission.limits.mass_kg is None)
        return Sought.of(self.selection, problem, CHEAPEST, deadline=deadline, ceiling=ceiling, imagers=imagers)

    def any_design(
        self, mission: Mission, deadline: Deadline, depth_m: float | None = None, *, few_first: bool = True,
        moved: str = "",
    ) -> Sought | None:  # fmt: skip
        """A search for any design of a mission that may be in other scenes; None where imagers alone take too long.

        `moved`: the one key in which it differs and asks for less, or `OTHER_WATER` where that is all that differs.
        """
        few_first &= not self.is_soon_known()
        if self._is_known_of(moved):
            soon = fitting(self._of_known(mission, deadline, moved, few=True)) if few_first else None
            return soon or self._of_known(mission, deadline, moved)
        selection = selected(mission, self.catalog, generic=self.generic, depth_m=depth_m)
        problem = build_problem(mission, selection, scenes=self.problem.scenes_for(mission))
        pairs = fitting_pairs(problem)
        few = not are_too_many(problem, pairs)
        if few_first and (soon := fitting(self._soon(selection, problem, pairs, deadline))) is not None:
            return soon
        try:
            imagers = enumerate_imagers(problem, deadline=deadline) if few else None
        except OutOfTimeError:
            return None
        return Sought.of(selection, problem, ANY, deadline=deadline, enough=True, imagers=imagers)

    def few_designs(
        self, mission: Mission, deadline: Deadline, moved: str = "", number: int | None = None,
        goal: Objective = ANY,
    ) -> Sought | None:  # fmt: skip
        """As `any_design`, of a few imagers from all over the catalogue; None where that is of no use."""
        if self._is_known_of(moved):
            return self._of_known(mission, deadline, moved, few=True)
        selection = selected(mission, self.catalog, generic=self.generic)
        problem = build_problem(mission, selection, scenes=self.problem.scenes_for(mission))
        return self._soon(selection, problem, fitting_pairs(problem), deadline, number, goal)

    def _is_known_of(self, moved: str) -> bool:
        """Whether the imagers that a moved key leaves are among those of which it is known what they break."""
        if self.are_too_many or (moved == HOURS and any(one.rule in OF_HOURS for one in self.selection.excluded)):
            return False
        return moved in MOVES_PASS or (moved == OTHER_WATER and self.known_in_best_housing is not None)

    def _of_known(self, mission: Mission, deadline: Deadline, moved: str, *, few: bool = False) -> Sought | None:
        """A search of those imagers, or of a few of them; None where that is of no use."""
        if moved in MOVES_PASS:
            if few:
                return self.among_few(mission, ANY, {moved}, deadline)
            return self.seek(mission, ANY, {moved}, deadline=deadline, enough=True, few_first=False)
        known = self.known_in_best_housing
        assert known is not None
        share = len(known) // FEW_IMAGERS if few else 1
        if few and (share < 2 or deadline.passed()):
            return None
        imagers = known.take(np.arange(0, len(known), share)) if few else known
        problem = build_problem(mission, self.selection)
        return Sought.of(self.selection, problem, ANY, imagers=imagers, deadline=deadline, enough=True)

    def _soon(
        self, selection: Selection, problem: Problem, pairs: FittingPairs, deadline: Deadline,
        number: int | None = None, goal: Objective = ANY, *, enough: bool = True, **how: Any,
    ) -> Sought | None:  # fmt: skip
        """A search of a few pairs of camera and lens behind all ports."""
        every = [(int(ports[0]), landscape) for ports in problem.port_groups for landscape in landscapes(problem)]
        most = number or FEW_PAIRS
        if len(pairs.camera) * len(every) < 2 * most or deadline.passed():
            return None
        places = few_places(every)
        share = max(1, len(pairs.camera) * len(places) // most)
        some = {
            place: (pairs.camera[start % share :: share], pairs.lens[start % share :: share])
            for start, place in enumerate(places)
        }
        imagers = imagers_of(problem, some, lambda block: in_best_housing(problem, block))
        return Sought.of(selection, problem, goal, imagers=imagers, deadline=deadline, enough=enough, **how)

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
        out = {"depth_rating_m": (DEPTH,), HOURS: OF_HOURS}.get(name, ())
        has_more = any(one.kind == "complete" and one.rule in out for one in self.selection.excluded)
        return () if has_more else (SHARP,)

    @cached_property
    def is_never_sharp(self) -> bool:
        """Whether no camera with any lens leaves the fine detail that is asked for, whatever else is asked."""
        wanted = asked_of(self.mission)
        if not wanted.any() or self.problem.paper or self.are_too_many or not len(self.pairs.camera):
            return False
        most = most_of_parts(self.problem, self.pairs.camera, self.pairs.lens).max(axis=0)
        return bool((most < wanted).any())

    def beyond(self, name: str, asked: float) -> float:
        """The limit of a requirement nearest to what is asked at which bounds already tell that nothing fits."""
        if name != SHARP or self.sharpest is None:
            return asked
        wanted, most = asked_of(self.mission), self.sharpest.most
        return float(min([asked, *(most[most < wanted] / MAY_SHOW)]))


def fitting(found: Sought | None) -> Sought | None:
    """A search that found something or that a person ended; None of any other, which proves nothing."""
    return found if found is not None and (found.outcome.best or found.outcome.interrupted) else None


def hope(found: Sought) -> float:
    """The share of a search's designs that no rule discards: solved, or not reached in time."""
    account = found.outcome.account
    return (account.evaluated + account.discarded.get(NOT_REACHED, 0)) / max(account.total, 1)
