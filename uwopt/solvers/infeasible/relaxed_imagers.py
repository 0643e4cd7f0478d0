"""The imagers that searches of a mission without some requirement look at: those that break nothing else.

An imager that breaks a rule which no dropped requirement stands behind need not be looked at again. Each imager's
broken rules, whatever it breaks before, are found once; a search without a requirement takes those that break nothing
else.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import Selection, ToBeMade
from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.assembly import build_problem, selected
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.solvers.exact.imager_rules import focus_rules, view_rules
from uwopt.solvers.exact.imagers import (
    FittingPairs,
    Imagers,
    PortBlock,
    fitting_pairs,
    focused_behind,
    landscapes,
)
from uwopt.solvers.exact.search import are_too_many
from uwopt.solvers.exact.seen import seen_behind
from uwopt.solvers.infeasible.freed_rules import FREES, OF_IMAGERS, OF_LIGHT
from uwopt.solvers.infeasible.sharpest import SHARP, Sharpest, least_contrast_asked
from uwopt.solvers.recommend import Sought
from uwopt.solvers.warm.tables import imagers_of_pairs
from uwopt.tolerances import ROUND

QUICK = 30_000  # imagers: of so many bounds tell about as soon as of a few that none of them fits
FEW_CHEAPEST = 1500  # imagers that are tried before all, of those that cost least, of which many are of no use
FEW_PLACES = 12  # behind which they are: ports of like optics, by orientation


class RelaxedImagers:
    """One mission's imagers without this or that requirement."""

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

        return imagers_of_pairs(problem, some, kept, deadline)

    @cached_property
    def sharpest(self) -> Sharpest | None:
        """What those imagers reach of fine detail that break no other rule; None where no fine detail is asked for."""
        known = self.known_in_best_housing
        is_asked = not self.problem.paper and bool(least_contrast_asked(self.mission).any())
        return Sharpest(self.problem, known) if known is not None and is_asked and not self.are_too_many else None

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


# ---------------------------------------------------------------- what each breaks


@dataclass(frozen=True)
class Broken:
    """Which rules that ports of the same optics share each pair of camera and lens breaks behind them."""

    pairs: FittingPairs
    behind: dict[tuple[int, bool], Array]  # by the first of like ports and landscape: bits of `names`, (n_pairs,)
    names: tuple[str, ...]

    @staticmethod
    def of(problem: Problem) -> Broken:
        """Every rule of every pair, whatever it breaks before."""
        pairs, behind, names = fitting_pairs(problem), {}, dict[str, int]()
        of_camera, _, of_port = problem.ties

        def mark(bits: Array, rows: Array, rules: Iterator[tuple[str, Array]]) -> None:
            for rule, passes in rules:
                bits[rows[~passes]] |= 1 << names.setdefault(rule, len(names))

        for ports in problem.port_groups:
            port, bits = int(ports[0]), np.full(len(pairs.camera), -1)  # pieces of others break everything
            own = np.flatnonzero(of_camera[pairs.camera] == of_port[port])
            for landscape in landscapes(problem) if len(own) else []:
                behind[port, landscape] = bits = bits.copy()
                bits[own] = 0
                camera, lens = pairs.camera[own], pairs.lens[own]
                seen, dioptre, spacers_m = seen_behind(problem, camera, lens, port, landscape)
                mark(bits, own, view_rules(problem, port, seen, spacers_m, np.arange(len(own))))
                focused = focused_behind(problem, camera, lens, port, seen, dioptre[None, :], spacers_m)
                mark(bits, own, focus_rules(problem, camera, lens, focused))
        return Broken(pairs, behind, tuple(names))

    def no_more_than(self, rules: Collection[str], *, some: bool) -> dict[tuple[int, bool], Array]:
        """Pairs behind like ports that break these rules alone, and one of them at least if that is wanted."""
        forgiven = sum(1 << bit for bit, name in enumerate(self.names) if name in rules)
        return {
            place: np.flatnonzero((bits & ~forgiven == 0) & ((bits != 0) if some else True))
            for place, bits in self.behind.items()
        }
