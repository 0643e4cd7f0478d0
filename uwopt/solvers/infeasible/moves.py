"""Keys of a mission that nothing meets which a person would move: how high, how fast, lit from where, in what water.

They are no requirements that could be dropped; each is tried far from where it stands, and where something fits there,
drawn back as near as something still fits (`least_change`). Whatever is told has been solved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

from uwopt.deadline import Deadline
from uwopt.errors import UwoptError
from uwopt.forward.lamps import Mount, mission_mounts
from uwopt.mission.keys import WATER_KEYS
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Value, Varied, VariedMission, rounded
from uwopt.results.basis import Moved
from uwopt.solvers.infeasible.freed_rules import (
    ENERGY,
    LAMPS,
    LAMPS_AT,
    LAMPS_LEAN,
    OF_LAMPS,
    OTHER_LAMPS,
    OTHER_WATER,
    SWITCHES,
)
from uwopt.solvers.infeasible.least_change import Change, Narrowing, same_hardware
from uwopt.solvers.infeasible.move_keys import CLEAREST_FIRST, Try, tries_of
from uwopt.solvers.infeasible.relaxer import ANY
from uwopt.solvers.infeasible.trials import Trials
from uwopt.solvers.recommend import Sought
from uwopt.units import split_unit

LAMP_SHARE = 0.25  # of the time left, for lamps that stand or lean otherwise
SHARE = 0.6  # of the time, for trying all keys far from where they stand
FEW_SHARE, FEW_TURN = 0.7, 0.4  # of the time left, for all among a few imagers, and of that for each
FEW_S = 2.5  # at least for each of these: they take that
LEAST_S = 0.5  # in less than that no search of all imagers finds anything, and the time is lost to what else helps
TURN = 0.7  # of the time left: what one key may take of it


@dataclass
class NearestType:
    """The type of water, or number of lamps, nearest to what is asked at which something fits: by halves of the rest.

    order : from the farthest, which fits, to what is asked at least
    """

    asked: Value
    search: Callable[[Value, Deadline], Sought | None]
    order: Sequence[Value] = CLEAREST_FIRST
    fits: int = 0  # the farthest does
    steps: int = 0
    not_known: int = field(init=False)  # the first at which nothing fits; what is asked does not
    too_long: int | None = None  # farther than that, where a search took longer than its turn

    def __post_init__(self) -> None:
        self.not_known = self.order.index(self.asked)

    @property
    def is_least(self) -> bool:
        """Whether the next type is known not to do."""
        return self.not_known - self.fits <= 1

    @property
    def is_done(self) -> bool:
        """Whether no step is left, or many gave no more."""
        return self.is_least or self._to_ask <= self.fits or self.steps > len(self.order)

    @property
    def gap(self) -> float:
        """The share of them of which it is not known whether they do."""
        return (self.not_known - self.fits) / len(self.order)

    @property
    def size(self) -> float:
        """Of the change: by so large a part of all."""
        return (self.order.index(self.asked) - self.fits) / len(self.order)

    @property
    def needed(self) -> Value:
        """The nearest to what is asked that is known to do."""
        return self.order[self.fits]

    def step(self, turn: Deadline) -> None:
        """Ask of the one in the middle."""
        self.steps += 1
        middle = self._to_ask
        found = self.search(self.order[middle], turn)
        if found is not None and found.outcome.best:
            self.fits = middle
        elif found is None or found.outcome.complete:
            self.not_known = middle
        else:
            self.too_long = middle

    @property
    def _to_ask(self) -> int:
        """In the middle of what is open, or of what is farther than one that took too long."""
        return (self.fits + (self.not_known if self.too_long is None else self.too_long)) // 2


@dataclass(frozen=True)
class Move:
    """A key at a value at which something fits, and what draws it back; None: of two words, which have none between."""

    tried: Try
    value: Value
    found: Sought
    drawn: Narrowing | NearestType | None

    @property
    def name(self) -> str:
        """Of the key."""
        return self.tried.key.name

    def told(self) -> Moved:
        """As far as it is drawn in."""
        drawn = self.drawn
        if isinstance(drawn, Narrowing):
            unit = split_unit(self.name)[1]
            return Moved(self.name, drawn.asked, rounded(drawn.change.limit), unit, drawn.is_least)
        needed, is_least = (self.value, True) if drawn is None else (drawn.needed, drawn.is_least)
        if not isinstance(needed, str):
            return Moved(self.name, float(self.tried.asked), float(needed), "", is_least)
        return Moved(self.name, str(self.tried.asked), str(needed), "", is_least)


@dataclass
class Mover:
    """Searches of one mission with single keys moved."""

    trials: Trials
    helpful: list[Move] = field(default_factory=list)
    useless: dict[str, tuple[str, ...]] = field(default_factory=dict)  # known not to help: `freed_rules.in_the_way`
    in_vain: set[tuple[str, Value]] = field(default_factory=set)  # values at which nothing fits
    base: VariedMission = field(init=False)

    def __post_init__(self) -> None:
        self.base = VariedMission(self.trials.mission, {})
        self.useless |= self.trials.relaxer.useless_alone([one.key.name for one in self.tries])

    def try_lamps(self) -> None:
        """Let lamps stand and lean otherwise, all at once: where nothing fits even so, no such move helps.

        Where something does, its place tells which does. Then another number of them, where that is open.
        """
        phase, places = self.trials.deadline.part(LAMP_SHARE), dict[Mount, tuple[Try, Value]]()
        lamps = {one.key.name: one for one in self.left if one.key.name in OF_LAMPS}
        for one in [lamps[name] for name in (LAMPS_AT, LAMPS_LEAN) if name in lamps]:
            for value in one.values:
                places |= dict.fromkeys(mission_mounts(self._at(one.key, value)), (one, value))
        found = self.trials.relaxer.standing_anywhere(places, phase) if places else None
        if found is None:
            return
        self.trials.interrupted |= found.outcome.interrupted
        if found.outcome.best:
            one, value = places[found.outcome.best[0].lighting.mount]
            self._take(one, value, self._search(one.key, value, partial(same_hardware, found)))
        elif found.outcome.complete:
            names = {one.key.name for one, _ in places.values()}
            self.useless |= {name: self.trials.relaxer.why_not(found, name) for name in names}
        if LAMPS in lamps and not self.trials.interrupted:
            with self.trials.until_interrupted():
                self._try_far(lamps[LAMPS], phase)

    def try_few(self) -> None:
        """Move each key far and look among a few imagers, as `Singles.try_few`: first those of few values to try."""
        phase = self.trials.deadline.part(FEW_SHARE)
        for one in sorted(self.left, key=lambda one: len(one.values)):
            for value in one.values:
                if phase.left_s < LEAST_S or self.trials.interrupted:
                    return
                turn = phase.at_most(max(FEW_TURN * phase.left_s, FEW_S))
                if self._take(one, value, self._search(one.key, value, partial(self._among_few, one.key, turn))):
                    break

    def try_hardware(self, known: Sought, phase: Deadline) -> None:
        """Move each key far and see whether some hardware fits there, which takes no search: where not, all is open."""
        for one in self.left:
            for value in one.values:
                if phase.passed() or self.trials.interrupted:
                    return
                if self._take(one, value, self._search(one.key, value, partial(same_hardware, known))):
                    break

    def take_for_far(self, name: str, value: Value | None, found: Sought) -> None:
        """Something is known to fit with a key at this value, all else as asked."""
        for one in self.tries:
            if one.key.name == name and value is not None:
                self._take(one, value, found)

    def try_all(self, share: float = SHARE, *, one_is_enough: bool = False) -> None:
        """Move each key far, as long as there is time, a share of what is left, or until one is known to help."""
        phase = self.trials.deadline.part(share)
        for one in self.left:
            if self.trials.interrupted or phase.left_s <= LEAST_S or (one_is_enough and self.helpful):
                break
            with self.trials.until_interrupted():
                self._try_far(one, phase)

    @property
    def left(self) -> list[Try]:
        """Those of which it is not known whether they help."""
        known = {one.name for one in self.helpful} | self.useless.keys()
        return [one for one in self.tries if one.key.name not in known]

    @property
    def helps_in_this_water(self) -> bool:
        """Whether a key helps that a person can move: clearer water can only be waited for."""
        return any(move.name not in WATER_KEYS for move in self.helpful)

    def tell_open(self) -> None:
        """Note what is not known."""
        self.trials.deadline.left_out.extend(f"whether another {one.key.name} would do" for one in self.left)

    @cached_property
    def tries(self) -> tuple[Try, ...]:
        """The keys that may be moved, in turn."""
        short_of = self.trials.short_of
        return tuple(tries_of(
            self.trials.mission, for_want_of_energy=ENERGY in short_of,
            for_want_of_budget=not short_of.isdisjoint(("cost", "mass_kg")),
        ))  # fmt: skip

    # ------------------------------------------------------------ far, and back

    def _try_far(self, one: Try, phase: Deadline) -> None:
        """Try a key far away, and keep what is known then of whether that helps."""
        known, rules = True, tuple[str, ...]()
        for value in one.values:
            if (one.key.name, value) in self.in_vain:
                continue
            turn = phase.part(TURN)
            found = self._search(one.key, value, partial(self._seek, one.key, turn=turn, few_first=False))
            if self._take(one, value, found):
                return
            if found is None or found.outcome.complete:
                self.in_vain.add((one.key.name, value))
            else:
                known = False
            rules = rules if found is None else self.trials.relaxer.why_not(found, one.key.name)
        if known:
            self.useless[one.key.name] = rules

    def _take(self, one: Try, value: Value, found: Sought | None) -> bool:
        """Whether something is found with a key at a value: then it helps."""
        if found is None or not found.outcome.best:
            return False
        self.helpful.append(Move(one, value, found, self._drawn(one.key, one.asked, value, found)))
        return True

    def _drawn(self, key: Varied, asked: Value, far: Value, found: Sought) -> Narrowing | NearestType | None:
        """What draws a key back towards what is asked."""
        if key.name in SWITCHES:
            return None
        if isinstance(far, str) or key.name == LAMPS:

            def at(one: Value, turn: Deadline) -> Sought | None:
                return self._search(key, one, partial(self._seek, key, turn=turn))

            return NearestType(asked, at, CLEAREST_FIRST if isinstance(far, str) else counts_from(far, asked))
        return Narrowing(
            float(asked), Change(float(far), found), lambda value: self._at(key, value), partial(self._seek, key)
        )

    def _at(self, key: Varied, value: Value) -> Mission:
        return self.base.with_values({key: value})

    def _search(self, key: Varied, value: Value, how: Callable[[Mission], Sought | None]) -> Sought | None:
        """What is found with a key at another value; None where there is no such mission, or nothing is found."""
        try:
            return how(self._at(key, value))
        except UwoptError:
            return None

    def _among_few(self, key: Varied, turn: Deadline, mission: Mission) -> Sought | None:
        """A design among a few imagers, if any."""
        return self.trials.among_few(mission, ANY, {what_moves(key)}, turn)

    def _seek(self, key: Varied, mission: Mission, turn: Deadline, *, few_first: bool = True) -> Sought:
        """A search for any design."""
        return self.trials.seek(mission, ANY, {what_moves(key)}, turn, enough=True, few_first=few_first)


def counts_from(far: Value, asked: Value) -> tuple[int, ...]:
    """All numbers of lamps from one to another."""
    first, last = int(far), int(asked)
    step = 1 if first < last else -1
    return tuple(range(first, last + step, step))


def what_moves(key: Varied) -> str:
    """What a key frees, as the searches take it: of a scene the water alone is moved."""
    if key.name in OF_LAMPS:
        return OTHER_LAMPS
    return OTHER_WATER if key.section == "scene" else key.name
