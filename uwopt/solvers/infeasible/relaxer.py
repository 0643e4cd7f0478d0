"""Searches of a mission without some requirement, that share what it leaves alone: parts, light, and what else fails.

An imager that breaks a rule which no dropped requirement stands behind need not be looked at again. Each imager's
broken rules are found once; a search without a requirement takes those that break nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import Selection, ToBeMade
from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.assembly import build_problem, selected
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.account import NOT_REACHED
from uwopt.solvers.exact.imagers import (
    FittingPairs,
    Imagers,
    PortBlock,
    enumerate_imagers,
    fitting_pairs,
    landscapes,
)
from uwopt.solvers.exact.never_sharp import MAY_SHOW
from uwopt.solvers.exact.search import are_too_many
from uwopt.solvers.infeasible.broken_rules import Broken
from uwopt.solvers.infeasible.freed_rules import (
    FREES,
    HOURS,
    MAY_PASS,
    MOVES_PASS,
    OF_HOURS,
    OF_IMAGERS,
    OF_LIGHT,
    OTHER_WATER,
    in_the_way,
)
from uwopt.solvers.infeasible.none_left import DEPTH
from uwopt.solvers.infeasible.settled import untouched
from uwopt.solvers.infeasible.sharpest import SHARP, Sharpest, asked_of, most_of_parts
from uwopt.solvers.recommend import Sought, seek
from uwopt.solvers.warm.tables import asking, imagers_of
from uwopt.tolerances import ROUND

Array = NDArray[Any]
FEW_PAIRS = 5000  # of camera and lens behind ports, likewise, of which most break some rule
FEW_IMAGERS = 250  # that are tried before all: where something fits at all, it is mostly among them
QUICK = 30_000  # imagers: of so many bounds tell about as soon as of a few that none of them fits
FEW_CHEAPEST = 1500  # the same, of those that cost least, of which many are of no use
FEW_SHARPEST = 8  # the same, of those that may be sharpest
FEW_PLACES = 12  # behind which these are: ports of like optics, by orientation
CHEAPEST = Objective.of("cost")
FEWER_PARTS = ("min_snr_red_db",)  # that some cameras never meet, and are left out for
ANY = Objective.of("power")  # where any design that fits will do: by no other objective takes a search less

class Relaxer:
    """One mission's searches without this or that requirement."""

    def __init__(self, mission: Mission, catalog: Catalog, generic: ToBeMade, like: Sought | None = None):
        """`like`: the search that found nothing, whose parts, light and imagers are known."""
        self.mission, self.catalog, self.generic, self.like = mission, catalog, generic, like

    @cached_property
    def selection(self) -> Selection:
        """The parts that the mission allows."""
        return selected(self.mission, self.catalog, generic=self.generic) if self.like is None else self.like.selection

    @cached_property
    def problem(self) -> Problem:
        """The mission's tables."""
        return build_problem(self.mission, self.selection) if self.like is None else self.like.problem

    @cached_property
    def are_too_many(self) -> bool:
        """Whether the catalogue is too large to look at every imager."""
        return are_too_many(self.problem, self.pairs)

    @cached_property
    def pairs(self) -> FittingPairs:
        """Cameras with the lenses that go on them."""
        return fitting_pairs(self.problem)

    @cached_property
    def broken(self) -> Broken | None:
        """What each imager breaks; None of a catalogue too large to look at every imager."""
        return None if self.are_too_many else Broken.of(self.problem)

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

    def effort(self, freed: Collection[str]) -> float:
        """How many imagers a search without these requirements looks at, about; inf: all there are."""
        if not set(freed) <= FREES.keys() or self.are_too_many:
            return math.inf
        if OF_LIGHT.issuperset(freed):
            return 0.0
        return float(sum(map(len, self._freed_pairs(freed).values())))

    def is_soon_known(self, freed: Collection[str] = ()) -> bool:
        """Whether a search of all imagers without these requirements takes hardly longer than one of a few.

        So it is where there are few, and what is asked was settled by bounds alone: no design had to be tried.
        """
        known = self.known_in_best_housing
        if self.like is None or self.like.outcome.account.evaluated:
            return False
        return known is not None and max(self.effort(freed), len(known)) <= QUICK

    def _freed_pairs(self, freed: Collection[str]) -> dict[tuple[int, bool], Array]:
        """Pairs behind like ports that break nothing but rules behind what is dropped."""
        assert self.broken is not None
        rules = frozenset[str]().union(*(FREES[name] for name in freed))
        return self.broken.no_more_than(rules, some=OF_IMAGERS.issuperset(freed))

    @cached_property
    def _pair_prices(self) -> Array:
        """What the camera and the lens of each pair count against a limit of cost, all cameras together."""
        problem, pairs = self.problem, self.pairs
        each = problem.cameras.limit_price[pairs.camera] + problem.lenses.limit_price[pairs.lens]
        return np.asarray(problem.mission.vehicle.camera_count * each)

    def _with_cheapest(
        self, few: dict[tuple[int, bool], Array], every: dict[tuple[int, bool], Array]
    ) -> dict[tuple[int, bool], Array]:
        """Some pairs behind like ports, and the cheapest behind the cheapest ports: what costs least is often there.

        Of the cheapest alone many are of no use, and evenly from all over few are cheap.
        """
        prices = self.problem.ports.limit_price
        cheap = sorted((place for place in every if len(every[place])), key=lambda place: prices[place[0]])[:FEW_PLACES]
        made, most = {**few}, FEW_CHEAPEST // max(len(cheap), 1)
        for place in cheap:
            first = np.argsort(self._pair_prices[every[place]], kind="stable")[:most]
            made[place] = np.union1d(every[place][first], few.get(place, first[:0]))
        return made

    def _affordable(self, mission: Mission, rows: Array, place: tuple[int, bool]) -> Array:
        """Of some pairs behind like ports those that may keep a mission's limit of cost, without any lamp."""
        problem, most = self.problem, mission.limits.cost
        if most is None:
            return rows
        alike = next(ports for ports in problem.port_groups if ports[0] == place[0])
        beside = problem.extras[0] + mission.vehicle.camera_count * problem.ports.limit_price[alike].min()
        return np.asarray(rows[self._pair_prices[rows] + beside <= most * ROUND])

    def imagers_in_time(
        self, problem: Problem, freed: Collection[str], deadline: Deadline, *, one_housing: bool
    ) -> Imagers | None:
        """As `imagers`; None where the time ends before they are listed, and the search with it."""
        try:
            return self.imagers(problem, freed, deadline, one_housing=one_housing)
        except OutOfTimeError:
            return None

    def imagers(
        self, problem: Problem, freed: Collection[str], deadline: Deadline = NEVER, *, one_housing: bool
    ) -> Imagers:
        """Those imagers that break nothing but rules behind what is dropped, under all rules that are left.

        `one_housing`: where one limit at most tells housings apart, the best of them alone. Raises OutOfTimeError.
        """
        known = self.known_in_best_housing if one_housing else self.known_imagers
        if known is not None and OF_LIGHT.issuperset(freed):
            if SHARP in freed and one_housing and self.sharpest is not None:
                return known.take(self.sharpest.at_least(problem.mission))
            return known
        return self._imagers_of(problem, self._freed_pairs(freed), deadline, one_housing=one_housing)

    def _imagers_of(
        self, problem: Problem, rows: dict[tuple[int, bool], Array], deadline: Deadline, *, one_housing: bool
    ) -> Imagers:
        """Those of some pairs behind like ports that keep all rules that are left."""
        assert self.broken is not None
        pairs = self.broken.pairs
        rows = {place: self._affordable(problem.mission, own, place) for place, own in rows.items()}
        some = {place: (pairs.camera[own], pairs.lens[own]) for place, own in rows.items()}

        def kept(block: PortBlock) -> PortBlock:
            return in_best_housing(problem, block) if one_housing else block

        return imagers_of(problem, some, kept, deadline)

    @cached_property
    def sharpest(self) -> Sharpest | None:
        """What those imagers reach of fine detail that break no other rule; None where no fine detail is asked for."""
        known = self.known_in_best_housing
        is_asked = not self.problem.paper and bool(asked_of(self.mission).any())
        return Sharpest(self.problem, known) if known is not None and is_asked and not self.are_too_many else None

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

    @cached_property
    def known_imagers(self) -> Imagers | None:
        """All that break no rule, as a search that looked at every imager and found nothing knows them."""
        return None if self.like is None else self.like.outcome.imagers

    @cached_property
    def known_in_best_housing(self) -> Imagers | None:
        """Those of them that suffice to know whether something fits."""
        known = self.known_imagers
        if known is None:
            return None
        optics = np.empty(len(self.problem.parts.ports), int)
        for number, ports in enumerate(self.problem.port_groups):
            optics[ports] = number
        alike = known.lens, known.camera, optics[known.port], known.landscape
        rows = best_housings(self.problem, known.port, *alike)
        return known if rows is None else known.take(rows)


def few_places(places: Iterable[tuple[int, bool]]) -> list[tuple[int, bool]]:
    """Some ports with their orientations, evenly spread: what is seen behind each takes its time, however few pairs."""
    every = list(places)
    return every[:: max(1, len(every) // FEW_PLACES)]


def fitting(found: Sought | None) -> Sought | None:
    """A search that found something or that a person ended; None of any other, which proves nothing."""
    return found if found is not None and (found.outcome.best or found.outcome.interrupted) else None


def hope(found: Sought) -> float:
    """The share of a search's designs that no rule discards: solved, or not reached in time."""
    account = found.outcome.account
    return (account.evaluated + account.discarded.get(NOT_REACHED, 0)) / max(account.total, 1)


def in_best_housing(problem: Problem, block: PortBlock) -> PortBlock:
    """Each pair of those behind like ports in the one housing of `best_housings`."""
    rows = best_housings(problem, block.port, block.lens, block.camera)
    return block if rows is None else block.take(rows)


def best_housings(problem: Problem, port: Array, *alike: Array) -> Array | None:
    """Rows of imagers in the one housing that a limit of cost or of mass leaves most room; None where both count.

    alike : columns of what imagers are that differ in their housing alone
    Whether something fits is then as it was: housings that hold a pair differ in nothing else.
    """
    limits, ports = problem.mission.limits, problem.ports
    counted = [
        column
        for column, most in ((ports.limit_price, limits.cost), (ports.mass_kg, limits.mass_kg))
        if most is not None
    ]
    if len(counted) > 1:
        return None
    worth = (counted or [ports.price])[0][port]
    order = np.lexsort((worth, *alike))
    one = np.stack(alike)[:, order]
    first = np.ones(len(order), bool)
    first[1:] = (one[:, 1:] != one[:, :-1]).any(axis=0)
    return np.asarray(np.sort(order[first]))
