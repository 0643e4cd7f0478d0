"""Changes that help together: each a smaller share of what is asked than any that helps alone.

    limit_i (1 +- s), and where that is not enough speed, altitude and its tolerance (1 - s),
    for want of energy also hours (1 - s) and battery (1 + s)

or, where nothing is known to help alone, limits from above by as large a factor, limit_i / (1 - s); with the least
common share s at which something fits: s is halved between what fits and what does not (among a few imagers, the
brightest first, it is not halved, but budgets stay as asked if something then fits too); of the hardware that is left
each key is drawn back towards what was asked as far as it can be, one after another. Whatever is told has been solved
with all the others as they are told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import partial

from uwopt.deadline import Deadline
from uwopt.errors import UwoptError
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Varied, VariedMission
from uwopt.mission.weakened import is_from_above
from uwopt.results.basis import Relaxed
from uwopt.results.design import Design
from uwopt.solvers.infeasible.freed_rules import BATTERY, BUDGETS, MAY_PASS, OF_LARGER
from uwopt.solvers.infeasible.least_change import Change, fitting, rounded_away, with_its_hardware
from uwopt.solvers.infeasible.move_keys import shared_keys
from uwopt.solvers.infeasible.reached import UNKNOWN, judged_by, miss, missed_by
from uwopt.solvers.infeasible.relaxer import ANY, FEW_IMAGERS
from uwopt.solvers.infeasible.trials import BRIGHT, Trials
from uwopt.solvers.recommend import Sought

KEPT = frozenset({"mean_level", "lens_stop_down"})  # neither more nor less of these is weaker by a share
TURN = 0.4  # of the time left: what one search may take of it
FEWER = "whether fewer changes together would do"
Giving = tuple[list[str], Sought]  # requirements, and what fits without them
VERY_FEW = 100  # imagers: most fit where nothing is asked
FIRST_TURN = 0.7  # of the time for a few imagers, for the first of them that fits
SHARES = 4  # by which all together are tried to give
FARTHEST = (0.4, 0.75)  # shares that are tried where nothing is known to help alone
FARTHEST_SOON = (0.75, 0.85)  # among a few imagers, of which a share that is small finds none
SOON_TURN = 0.7  # of the time left, for one search of these, and for the first of all that fits
DRAW_SHARE = 0.5  # of all the time left, for what their hardware needs no more
SOON_IMAGERS = 75  # where speed and height give too
NO_MORE = 0.95  # of a limit from below: all of it would ask for nothing


@dataclass(frozen=True)
class CommonFit:
    """Changes that help together, each needed by the hardware that was found, and that."""

    changes: list[Relaxed]
    found: Sought


@dataclass
class CommonShare:
    """One mission's limits and keys of the vehicle, which give all at once; `few`: among a few imagers alone."""

    trials: Trials
    phase: Deadline
    few: bool = False
    vehicle: dict[str, float] = field(init=False)  # speed and height, and what holds and takes energy, as asked
    moved: dict[str, float] = field(default_factory=dict)  # those of them that give too
    by_factor: bool = False  # limits from above, not by a share

    def __post_init__(self) -> None:
        self.limits = {
            name: limit
            for name, limit in sorted(self.trials.limits.items(), key=lambda one: not self.trials.is_own(one[0]))
            if name in MAY_PASS and limit and name not in KEPT
        }
        may_lack_energy = not self.trials.short_of.isdisjoint(BUDGETS)  # it counts last, of what no other takes out
        self.vehicle = shared_keys(self.trials.mission, for_want_of_energy=may_lack_energy)
        self.base = VariedMission(self.trials.mission, {})

    @property
    def asked(self) -> dict[str, float]:
        """What gives: keys of the vehicle, then limits, those last that good practice fills in: they give most."""
        return {**self.moved, **self.limits}

    def smaller_than(self, alone: float) -> list[Relaxed]:
        """Changes each smaller than the one that helps alone; none where no less than that is known to do."""
        if not math.isfinite(alone) or alone >= UNKNOWN:
            return []
        for moved in ({}, self.vehicle):
            self.moved = moved
            known = None if len(self.asked) < 2 else self._halved(0.0, min(alone, NO_MORE), None)
            made = [] if known is None else self._drawn_back(*known).changes
            if len(made) > 1 and max(one.miss_rel for one in made) < alone:
                return made
        return []

    def of_all(self) -> CommonFit | None:
        """Changes that help together where none is known to alone, and what fits with them.

        Limits alone before them with the vehicle's keys; soon, where light lacks, it is these that bring it.
        """
        low, self.by_factor = 0.0, True
        ways = [self.vehicle] if self.few and "light" in self.trials.short_of else [{}, self.vehicle]
        if BATTERY in self.vehicle and OF_LARGER & self.limits.keys():  # a larger one takes up what they give
            ways.append({key: value for key, value in self.vehicle.items() if key != BATTERY})
        far = FARTHEST[-1:] if self.trials.relaxer.are_too_many else FARTHEST  # of all parts any share is as soon known
        for share in FARTHEST_SOON if self.few else far:
            for moved in ways:
                self.moved = moved
                found = self._search(share, SOON_TURN) if len(self.asked) > 1 else None
                if found is not None and found.outcome.best:
                    if not self.few:
                        known = self._halved(low, share, found)
                        return None if known is None else self._drawn_back(*known)
                    self.phase = self.trials.deadline.part(DRAW_SHARE)
                    return self._drawn_back(share, self._in_budget(share, found))
                if found is None and len(self.asked) > 1 and not self.few:
                    self.trials.deadline.left_out.append("whether changes together would do")
                    return None
            low = share
        return None

    def _halved(self, low: float, high: float, found: Sought | None) -> tuple[float, Sought] | None:
        """The least share that is known to do, at most `high`, and a design; None where none smaller is."""
        for _ in range(SHARES):
            share = 0.5 * (low + high)
            others = self._search(share)
            if others is None:
                self.trials.deadline.left_out.append("whether smaller changes together would do")
                break
            low, high, found = (low, share, others) if others.outcome.best else (share, high, found)
        return None if found is None or self.trials.interrupted else (high, found)

    # ------------------------------------------------------------ one share

    def weaker_by(self, share: float) -> dict[str, float]:
        """Everything by a share of itself in the sense that asks for less."""
        made = {}
        for name, value in self.asked.items():
            more = is_from_above(name) if name in self.limits else name == BATTERY
            up = share / (1.0 - share) if self.by_factor else share
            made[name] = rounded_away(value + abs(value) * (up if more else -share), value)
        return made

    def mission(self, values: Mapping[str, float | None]) -> Mission:
        """The mission with other limits and keys of the vehicle."""
        moved = {
            key: value for key, value in values.items() if key in self.moved and value != self.moved[key]
        }
        mission = self.trials.mission
        if moved:
            mission = self.base.with_values(
                {Varied(key, "vehicle", key, ()): value for key, value in moved.items() if value is not None}
            )
        return self.trials.with_limits(
            mission, {name: values[name] for name in values if name in self.limits}
        )

    def _search(self, share: float, turn_share: float = TURN, kept: Collection[str] = ()) -> Sought | None:
        """A search with everything weaker by a share but what is `kept`; None where it ends before it knows, or is no
        mission.
        """
        trials = self.trials
        if trials.over or self.phase.passed():
            return None
        turn = self.phase.part(SOON_TURN if self.few else turn_share)
        try:
            mission = self.mission(self.weaker_by(share) | {name: self.limits[name] for name in kept})
            if self.few:
                found = self._among_few(mission, turn)
            else:
                found = trials.relaxer.seek(mission, ANY, set(self.asked), deadline=turn, enough=True)
        except UwoptError:
            return None
        if found is None:
            return None
        trials.interrupted |= found.outcome.interrupted
        return found if found.outcome.best or found.outcome.complete or self.few else None

    def _in_budget(self, share: float, found: Sought) -> Sought:
        """What fits with the budgets as they are asked, as many as can be, where the brightest hardware passes them."""
        mission = self.mission(self.weaker_by(share) | self.limits)
        over = missed_by(judged_by(mission, found, self.trials.objective), BUDGETS)
        missed = [name for name in BUDGETS if name in over]
        for kept in [missed, *([name] for name in missed)] if len(missed) > 1 else [missed]:
            less = self._search(share, kept=kept) if kept else None
            if less is not None and less.outcome.best:
                return less
        return found

    def _among_few(self, mission: Mission, turn: Deadline) -> Sought | None:
        """A search of a few imagers, the brightest first: what needs little power is seldom bright enough."""
        number = SOON_IMAGERS if self.moved else FEW_IMAGERS
        return self.trials.relaxer.among_few(mission, BRIGHT, set(self.asked), turn, number=number)

    # ------------------------------------------------------------ back towards what was asked

    def _drawn_back(self, share: float, found: Sought) -> CommonFit:
        """What a design's hardware needs where all give by a share: of each in turn as little as will do."""
        asked = self.asked
        kept, found = self._without_what_is_kept({**self.weaker_by(share)}, found)
        changed = [name for name, value in asked.items() if kept[name] != value]
        for name in changed:
            if not self.phase.passed() and (less := self._fits(found, {**kept, name: asked[name]})) is not None:
                kept[name], found = asked[name], less
        far = {name: kept[name] for name in changed if kept[name] != asked[name]}
        told, found = one_by_one(asked, kept, far, found, self.mission, self.phase)
        return CommonFit([one for one in told if one.needed != one.limit], found)

    def _without_what_is_kept(
        self, kept: dict[str, float | None], found: Sought
    ) -> tuple[dict[str, float | None], Sought]:
        """The same with all that the design keeps as it is asked, and the others no weaker than what it reaches."""
        design = judged_by(self.mission({**kept, **self.limits}), found, self.trials.objective)
        missed = missed_by(design, list(self.limits))
        fewer = kept | {name: value for name, value in self.limits.items() if name not in missed}
        reached = fewer | {name: self._no_weaker(design, name, kept[name]) for name in missed}
        for values in (reached, fewer):
            if (less := self._fits(found, values)) is not None:
                return values, less
        return kept, found

    def _no_weaker(self, design: Design, name: str, weaker: float | None) -> float | None:
        """The limit that a design reaches, as it would be typed; that which was searched with where it is no nearer."""
        limit, reached = self.limits[name], self.trials.typed(name, design)
        if reached is None or weaker is None:
            return weaker
        return reached if abs(reached - limit) < abs(weaker - limit) else weaker

    def _fits(self, found: Sought, values: Mapping[str, float | None]) -> Sought | None:
        """A design's hardware in the mission with other values, if it fits."""
        return fitting(found, partial(self.mission, values))


def one_by_one(
    asked: Mapping[str, float], kept: dict[str, float | None], far: Mapping[str, float | None], found: Sought,
    mission: Callable[[Mapping[str, float | None]], Mission], deadline: Deadline,
) -> tuple[list[Relaxed], Sought]:  # fmt: skip
    """Values that give together, each in turn drawn back from `far` as its hardware allows, the others as `kept`."""
    for name, limit in far.items():
        if limit is not None:

            def wanted(value: float, name: str = name) -> Mission:
                return mission({**kept, name: value})

            least = with_its_hardware(asked[name], Change(limit, found), wanted, deadline)
            kept[name], found = least.limit, least.found
    return [Relaxed(name, limit, kept[name], miss(limit, kept[name])) for name, limit in asked.items()], found


# ---------------------------------------------------------------- all that give


def least_set(trials: Trials, known: Giving | None) -> tuple[list[Relaxed], Design | None]:
    """Requirements of which all have to give for a system to fit, as far as there is time, and that system.

    known : some that give together, with a system that fits without them, where nothing is to be looked for
    """
    limits = {name: limit for name, limit in trials.by_effort().items() if name in MAY_PASS}
    if known is not None:
        trials.deadline.left_out.append(FEWER)
        return drawn_in(trials, {name: limits[name] for name in limits if name in known[0]}, known[1])
    found = first_of_all(trials, limits)
    if found is None:
        return [], None
    given, found, sure = without_fewer(trials, limits, found, trials.seek_without)
    if not sure:
        trials.deadline.left_out.append(FEWER)
    return drawn_in(trials, {name: limits[name] for name in limits if name in given}, found)


def few_that_give(trials: Trials) -> Giving | None:
    """Requirements that give together, by searches of a few imagers; those last that the mission states itself."""
    names = sorted((name for name in trials.limits if name in MAY_PASS), key=trials.is_own)
    found = trials.few_without(names, trials.deadline.part(FIRST_TURN), VERY_FEW)
    if found is None or not found.outcome.best:
        return None

    def seek(some: Collection[str]) -> Sought | None:
        return trials.few_without(some, trials.turn(), VERY_FEW)

    given, found, _ = without_fewer(trials, names, found, seek)
    return [name for name in names if name in given], found


def without_fewer(
    trials: Trials, names: Collection[str], found: Sought, seek: Callable[[Collection[str]], Sought | None]
) -> tuple[set[str], Sought, bool]:
    """Of what a design misses as little as a search finds; the names in turn; whether every search had its answer."""
    order = list(names)
    given, kept, sure = missed_by(trials.judged(found), names), set[str](), True
    while given - kept and not trials.over:
        name = min(given - kept, key=order.index)
        others = seek(given - {name})
        sure = sure and others is not None
        if others is not None and others.outcome.best:
            found = others
            given = missed_by(trials.judged(found), names)
        else:
            kept.add(name)
    return given, found, sure and not given - kept


def drawn_in(trials: Trials, asked: dict[str, float], found: Sought) -> tuple[list[Relaxed], Design]:
    """What a design's hardware can keep of limits that give together: of each in turn as much as can be."""
    design = trials.judged(found)
    far = {name: trials.typed(name, design) for name in asked}
    mission = partial(trials.with_limits, trials.mission)
    told, found = one_by_one(asked, dict.fromkeys(asked), far, found, mission, trials.deadline)
    return told, trials.judged(found)


def first_of_all(trials: Trials, names: Collection[str]) -> Sought | None:
    """A design that fits where many requirements are dropped: of imagers that fit if there are any, else of all.

    Without an SNR to keep the brightest is looked for, which takes longer than any: that is dropped last.
    """
    lit = [name for name in names if name != "min_snr"]
    for some in ([name for name in names if not MAY_PASS[name]], lit, [*names]):
        found = trials.seek_without(set(some)) if some else None
        if found is not None and found.outcome.best:
            return found
    return None
