"""What asked less would do: keys of a mission moved, and hardware counted in the same scenarios."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.errors import MissionError
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Varied, VariedMission
from uwopt.mission.weakened import (
    LEAST_SNR_DB,
    RELAXABLE,
    USELESS_DB,
    asked_value,
    in_all_scenes,
    is_from_above,
    with_limit,
)
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Moved
from uwopt.solvers.confidence.counted import Counted
from uwopt.solvers.confidence.outcomes import outcomes
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.search import at_its_stop
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.infeasible.freed_rules import OF_LARGER
from uwopt.solvers.infeasible.least_change import rounded_away
from uwopt.solvers.one_hardware import problem_of
from uwopt.units import split_unit

#: What gives a lamp's light room, where too little or too much of it is what is missed first.
FOR_LIGHT = ("min_snr_db", "min_snr_mean_db", "min_snr_red_db", "min_contrast", "max_gain_db", "max_blur_px")
FOR_TIME = ("max_blur_px", "max_skew_px", "overlap", "frame_rate")  # what a slower vehicle leaves more time for
ALTITUDE, TOLERANCE, SPEED = "altitude_m", "altitude_tolerance_m", "speed_m_s"
BATTERY, OF_BATTERY = "battery_wh", "energy_wh"  # what holds too little where that is missed
FARTHEST = 4.0  # times as much, or as little
FARTHEST_DB = 20.0
LOWER = (0.9, 0.75)  # of the altitude that is asked, in turn
CLOSE = 0.05  # of a change: no nearer value is looked for
STEADIER = (0.75, 0.5, 0.25)  # of the tolerance that is asked, in turn
HALVED = 2  # times the last of these steps, of which light is known
EASED_S = 2.0  # of work, where no time is given: for keys of which any value may do
TRIED_S = 10.0  # likewise, after these: for keys of which a few values are tried, as light may have to be made anew
Shares = dict[tuple[str, float], float]  # of the scenarios, in which hardware holds with one key at a value
FIRST_STEP = 1 / 32  # of the way from what is asked to what lies far from it


@dataclass(frozen=True)
class Ease:
    """A key of which less may be asked: values in turn, the first with which hardware holds is told."""

    key: str
    unit: str
    asked: float
    values: tuple[float, ...]  # one alone lies far from what is asked: a nearer one is looked for
    mission_at: Callable[..., Mission]  # takes a value, and a mission in which other keys have moved


Move: TypeAlias = tuple[Ease, float]
Holds: TypeAlias = Callable[[Sequence[Move]], bool]


def all_missed(problem: Problem, objective: Objective, seen: Counted, scenarios: Scenarios) -> dict[str, int]:
    """What hardware misses first at its stop, in how many scenarios: what no settings can mend as well.

    Hardware that is counted with others behind one port does not tell that, nor what blurs from what is dark.
    """
    stop = float(seen.outcomes.f_numbers[seen.stop])
    return outcomes(problem, seen.found, objective, scenarios, f_numbers=[stop], tells=True).missed(0)


def eases(mission: Mission, missed: Iterable[str]) -> Iterator[Ease]:
    """What may be eased where these requirements are missed: they, and what a vehicle would do to meet them.

    A battery where it holds too little, with price and mass where it is part of the system; a steadier height, for all
    must hold over the band; at last a lower one, which eases most, but takes longest: light is worked out anew.
    """
    wanted = {key for name in missed for key in (FOR_LIGHT if name == "light" else (name,))}
    if OF_BATTERY in wanted and mission.vehicle.supply == "battery":
        wanted |= OF_LARGER
    for name, (_, key, _) in RELAXABLE.items():
        asked = asked_value(mission, name) if wanted.intersection((name, key)) else None
        if not asked:
            continue
        unit, above = mission.limits.currency if name == "cost" else split_unit(key)[1], is_from_above(name)
        if unit == "db":
            least = USELESS_DB if asked > USELESS_DB else LEAST_SNR_DB  # nobody wants images of noise alone
            far = asked + FARTHEST_DB if above else max(asked - FARTHEST_DB, least)
        else:
            far = asked * FARTHEST if above else asked / FARTHEST

        def with_value(value: float, there: Mission = mission, name: str = name, asked: float = asked) -> Mission:
            return with_limit(there, name, asked, value)

        yield Ease(key, unit, asked, (far,), with_value)
    battery = (FARTHEST,) if OF_BATTERY in wanted else ()
    slower = (1.0 / FARTHEST,) if wanted.intersection(FOR_TIME) else ()
    for key, shares in ((BATTERY, battery), (SPEED, slower), (TOLERANCE, STEADIER), (ALTITUDE, LOWER)):
        if shares and (asked := in_all_scenes(mission, "vehicle", key)):
            varied = Varied(key, "vehicle", key, ())

            def of_vehicle(value: float, there: Mission = mission, varied: Varied = varied) -> Mission:
                return VariedMission(there, {}).with_values({varied: value})

            there_to = tuple(rounded_away(one * asked, asked) for one in shares)
            yield Ease(key, split_unit(key)[1], asked, there_to, of_vehicle)


@dataclass(frozen=True)
class MovedKeys:
    """Counts hardware of a problem in its scenarios with keys of its mission moved."""

    problem: Problem
    objective: Objective
    scenarios: Scenarios
    share: float
    deadline: Deadline = NEVER

    def held(self, found: Found, moves: Sequence[Move], *, as_set: bool = False) -> float:
        """Share of the scenarios in which hardware holds; `as_set` : as of `held_as_set`.

        0 in a mission that contradicts itself. Raises OutOfTimeError.
        """
        self.deadline.check()
        mission = self.problem.mission
        try:
            for ease, value in moves:
                mission = ease.mission_at(value, mission)
        except MissionError:
            return 0.0
        light = light_with(moves, self.scenarios)
        if as_set:
            return self.held_as_set(mission, found, light)
        return float(self.outcomes_in(mission, found, light)[1].outcomes.held.max())

    def holds(self, found: Found) -> Holds:
        """Whether hardware holds as often as asked with some keys moved."""
        return lambda moves: self.held(found, moves) >= self.share

    def held_as_set(self, mission: Mission, found: Found, light: dict[Any, Any] | None = None) -> float:
        """The same at a stop at which it fits by likeliest values too, as what is recommended has to.

        0 where none does, or not as often as asked.
        """
        alone, one = self.outcomes_in(mission, found, light)
        for stop in np.argsort(-one.outcomes.held, kind="stable"):
            if one.outcomes.held[stop] == 0.0 or one.outcomes.held[stop] < self.share:
                break
            if at_its_stop(alone, self.objective, replace(one, stop=int(stop))) is not None:
                return float(one.outcomes.held[stop])
        return 0.0

    def outcomes_in(
        self, mission: Mission, found: Found, light: dict[Any, Any] | None = None
    ) -> tuple[Problem, Counted]:
        """One hardware alone in another mission, counted in the same scenarios.

        light : how it changes with the water, by image, at the heights of that mission; None: they are the same
        """
        alone = problem_of(self.problem, found, mission=mission, scenes=self.problem.scenes_for(mission))
        here = self.scenarios.seen_by(mission, alone.scenes)
        here = replace(here, responses=self.scenarios.responses if light is None else light)
        there = replace(found, camera=0, lens=0, port=0, light=0)
        return alone, Counted(there, outcomes(alone, there, self.objective, here, self.deadline), 0)


def light_with(moves: Sequence[Move], scenarios: Scenarios) -> dict[Any, Any]:
    """How light changes with the water once keys are moved, by image, as far as that is known."""
    ways = {ease.key: value / ease.asked for ease, value in moves}
    if ALTITUDE in ways:
        return {}
    if TOLERANCE in ways:
        return {image: known.in_narrower_band(ways[TOLERANCE]) for image, known in scenarios.responses.items()}
    return scenarios.responses


def would_hold(
    problem: Problem, objective: Objective, seen: Counted, scenarios: Scenarios, share: float, deadline: Deadline,
    shares: Shares | None = None,
) -> list[Moved]:  # fmt: skip
    """Keys of which less would let the hardware hold as often as asked, each moved alone, as far as time goes.

    What is told was counted; its lens may stand at another stop then. With little time less is found than would do.

    shares : what was counted goes into it
    """
    made, was_coarse, known = [], False, {} if shares is None else shares
    patience = deadline.of_work(EASED_S)
    trial = MovedKeys(problem, objective, scenarios, share, patience)
    for ease in eases(problem.mission, all_missed(problem, objective, seen, scenarios)):
        coarse = len(ease.values) > 1
        if coarse and not was_coarse:  # these come last
            patience, was_coarse = deadline.of_work(TRIED_S), True
        if made and ease.key == ALTITUDE:
            break

        def holds(value: float, ease: Ease = ease, until: Deadline = patience) -> bool:
            known[ease.key, value] = replace(trial, deadline=until).held(seen.found, [(ease, value)])
            return known[ease.key, value] >= share

        try:
            far = next((value for value in ease.values if holds(value)), None)
            if far is not None:
                needed = far if coarse else nearest_that_holds(ease.asked, far, holds)
                if ease.key == TOLERANCE:
                    needed = halved((ease.asked, *ease.values), far, holds)
                made.append(Moved(ease.key, ease.asked, needed, ease.unit, not coarse))
        except OutOfTimeError:
            continue
    return made


def halved(values: Sequence[float], far: float, holds: Callable[[float], bool]) -> float:
    """Of values in turn one between the first with which it holds and that before it, by halves."""
    near = values[values.index(far) - 1]
    with suppress(OutOfTimeError):
        for _ in range(HALVED):
            middle = rounded_away(0.5 * (near + far), values[0])
            near, far = (near, middle) if holds(middle) else (middle, far)
    return far


def nearest_that_holds(asked: float, far: float, holds: Callable[[float], bool]) -> float:
    """The value nearest to what is asked with which it holds, to a twentieth of the change: steps that double, halves.

    It holds at `far`, not at what is asked. Where time runs out, the nearest that was found by then.
    """
    near, share = asked, FIRST_STEP
    try:
        while share < 1.0:
            step = rounded_away(asked + share * (far - asked), asked)
            if holds(step):
                far = step
                break
            near, share = step, 2.0 * share
        while abs(far - near) > CLOSE * abs(far - asked):
            step = rounded_away(0.5 * (near + far), asked)
            if not min(near, far) < step < max(near, far):
                break
            if holds(step):
                far = step
            else:
                near = step
    except OutOfTimeError:
        pass  # the nearest value that was counted holds as it did
    return far
