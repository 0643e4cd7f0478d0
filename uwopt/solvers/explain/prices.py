"""What a binding requirement costs: the same system with a little more asked of it, and CasADi's word on the slope.

    dV / d(20 lg SNR) = lambda ln(10) / 20

lambda is the multiplier of ln(SNR) >= ln(least SNR) in the program of the winner's settings, in the objective's unit.
The slope is confirmed by a central difference of the search of that hardware, which owes nothing to CasADi. Of other
keys, which are no constraints of that program of their own, the slope is that difference alone.

As a whole a requirement costs what the best system without it is better by: a search for something better, below what
is known, says how much, or that nothing is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from uwopt.catalog.choose import ToBeMade
from uwopt.deadline import Deadline
from uwopt.errors import MissionError
from uwopt.mission.mission import Mission
from uwopt.mission.reserves import asked_when_held
from uwopt.mission.varying import Varied, VariedMission, rounded
from uwopt.mission.weakened import RELAXABLE, asked_value, in_all_scenes, is_from_above, without
from uwopt.model.bisection import bisected, half_way
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Opinion, Price
from uwopt.results.design import Design
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.infeasible.least_change import rounded_away
from uwopt.solvers.infeasible.reached import reached_value
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.one_hardware import best_of, problem_of
from uwopt.solvers.recommend import Sought
from uwopt.units import split_unit

Objectives = Callable[[float], "float | None"]  # of one system where so much more is asked of a key
STEP_SHARE = 0.1  # of what is asked; of decibels one
SMALL = 1e-2  # of a step, for the slope
HALVINGS = 6  # of the way to where a requirement may cost nothing
SAME_REL = 2e-4  # of the objective: twice what settings are searched to
NO_STEP = ("depth_rating_m", "mean_level", "lens_stop_down")  # a rating of parts, a middle, a count
SNR, MEAN_SNR, SNR_LESS = "min_snr_db", "min_snr_mean_db", "snr_at_less_db"
SNR_RULE = "min_snr["  # how CasADi's rules of SNR begin


def priced_keys(mission: Mission, winner: Design, *, every: bool = False) -> Iterator[tuple[Varied, float, float]]:
    """What binds of requirements and image interval, and the speed: key, what is asked, a step that asks for more.

    `every`: also requirements that do not bind, after those that do.
    """
    binding = binding_keys(winner)
    rest = [name for name, (_, key, _) in RELAXABLE.items() if every and key not in binding]
    for name in [*(name for name, (_, key, _) in RELAXABLE.items() if key in binding), *rest]:
        section, key, _ = RELAXABLE[name]
        asked = asked_value(mission, name)
        if asked and key not in NO_STEP:
            step = step_of(key, asked)
            yield Varied(key, section, key, (asked,)), asked, -step if is_from_above(name) else step
    yield from frame_keys(mission, binding, every=every)
    name = "frame_interval_s"
    if name in binding and (interval := in_all_scenes(mission, "requirements", name)):
        yield Varied(name, "requirements", name, (interval,)), interval, -step_of(name, interval)
    if speed := in_all_scenes(mission, "vehicle", "speed_m_s"):
        yield Varied("speed_m_s", "vehicle", "speed_m_s", (speed,)), speed, step_of("speed_m_s", speed)


def frame_keys(mission: Mission, binding: set[str], *, every: bool) -> Iterator[tuple[Varied, float, float]]:
    """What the frame may have less than its mean, where the frame's own signal to noise binds."""
    if (less := in_all_scenes(mission, "requirements", SNR_LESS)) and (every or SNR_LESS in binding):
        yield Varied(SNR_LESS, "requirements", SNR_LESS, (less,)), less, -min(step_of(SNR_LESS, less), less)


def binding_keys(winner: Design) -> set[str]:
    """Requirements that a design just meets; of the signal to noise the one that is asked, of mean or frame."""
    names = {margin.requirement for margin in winner.margins if margin.binding}
    return names | ({SNR_LESS} if SNR in names else set()) | ({SNR} if MEAN_SNR in names else set())


def met_as_it_is(mission: Mission, winner: Design, key: str, asked: float) -> float | None:
    """The value of a requirement that a design meets as it is; None where that is no figure.

    Where mean and frame are both held to one signal to noise, what is left of either counts, and what the frame may
    lack is as much less as is left of the frame's.
    """
    spare_db = {
        name: min(spare)
        for name in (SNR, MEAN_SNR)
        if (spare := [
            float(one.value - one.limit)
            for one in winner.margins
            if one.requirement == name and one.value is not None and one.limit is not None
        ])
    }  # fmt: skip
    if key == SNR_LESS:
        return asked - spare_db[SNR] if SNR in spare_db else None
    if key == SNR and MEAN_SNR in spare_db:
        return asked + min(spare_db.values())
    reached = reached_value(winner, key)
    return None if reached is None else asked_when_held(mission.reserve, key, reached)


def free_until(mission: Mission, winner: Design, key: str, asked: float, step: float) -> float | None:
    """The value of a requirement that a design reaches as it is, to three digits; None where it binds, or is no figure.

    What asks for more allows no more systems, and up to there it allows the best of those that are allowed now: so that
    system stays the best, at what it costs now.
    """
    held = None if key in binding_keys(winner) else met_as_it_is(mission, winner, key, asked)
    if held is None:
        return None
    value = rounded_away(held, math.inf if held > asked else -math.inf)  # no further than it reaches
    return value if (value - asked) * step > 0.0 else None


def step_of(key: str, asked: float) -> float:
    """A step that a person would take: a decibel, or about a tenth with one digit."""
    if split_unit(key)[1] == "db":
        return 1.0
    share = STEP_SHARE * abs(asked)
    unit = 10.0 ** math.floor(math.log10(share))
    return rounded(round(share / unit) * unit)


def prices(
    sought: Sought, winner: Design, opinions: Sequence[Opinion], deadline: Deadline, *,
    every: bool = False,
) -> list[Price]:  # fmt: skip
    """What a step more of each binding requirement costs with this system, as far as there is time.

    `every`: of all requirements, and up to where those that do not bind cost nothing.
    """
    mission, found = sought.problem.mission, sought.outcome.best[0]
    base, made, solved = VariedMission(mission, {}), [], list[tuple[Mission, float | None]]()
    for key, asked, step in priced_keys(mission, winner, every=every):
        deadline.check()

        def at(more: float, key: Varied = key, asked: float = asked) -> float | None:
            return reached(sought, found, base, key, rounded(asked + more), solved)

        here = at(0.0)
        if here is None:
            continue

        def is_free(value: float, here: float = here, asked: float = asked, at: Objectives = at) -> bool:
            return costs_nothing(here, at(value - asked))

        reach = free_until(mission, winner, key.key, asked, step) if every else None
        free = None if reach is None else free_by(is_free, asked, reach)
        unit = split_unit(key.name)[1]
        if free is not None and abs(free - asked) >= abs(step):
            made.append(Price(key.name, unit, asked, step, 0.0, 0.0, free_until=free))
            continue
        there = at(step)
        slope = 0.0 if free is not None else slope_at(at, SMALL * abs(step))
        told = snr_slope(opinions, sought.goal) if key.name == SNR else None
        change = what_it_costs(here, there, sought.goal)
        made.append(Price(key.name, unit, asked, step, change, slope, told, free_until=free))
    return made


def free_by(is_free: Callable[[float], bool], asked: float, reach: float) -> float | None:
    """The value farthest from what is asked, up to a reach, that is known to cost nothing; None where none is.

    A key may count for more than the limit of its figure: depth of field also says where it has to lie.
    """
    if is_free(reach):
        return reach

    def middle(near: float, far: float) -> float:
        return rounded_away(half_way(near, far), math.inf if reach > asked else -math.inf)

    near = float(bisected(is_free, asked, reach, steps=HALVINGS, middle=middle)[0])
    return None if near == asked else near


def what_it_costs(here: float, there: float | None, goal: Objective) -> float | None:
    """By how much an objective changes where more is asked; None where nothing fits then.

    What is better cannot be a price: more may be made then of what is sold where less is asked (`of_fewest_kinds`).
    """
    if there is None:
        return None
    is_worse = there < here if goal.direction == "maximise" else there > here
    return there - here if is_worse and not costs_nothing(here, there) else 0.0


def costs_nothing(here: float, there: float | None) -> bool:
    """Whether an objective is the same in two missions, to what settings are searched to."""
    return there is not None and abs(there - here) <= SAME_REL * max(abs(here), abs(there))


def reached(
    sought: Sought, found: Found, base: VariedMission, key: Varied, value: float,
    solved: list[tuple[Mission, float | None]],
) -> float | None:  # fmt: skip
    """The objective, as it is reported, of one system where a key has another value; None where it does not fit.

    solved : what missions reached before: what is asked of one key is asked of all, so that its mission comes again
    """
    goal = sought.goal
    try:
        mission = base.with_values({key: value})
    except MissionError:
        return None
    for other, before in solved:
        if other == mission:
            return before
    problem = problem_of(sought.problem, found, mission=mission, scenes=sought.problem.scenes_for(mission))
    best = best_of(problem, goal)
    solved.append((mission, goal.told(best)))
    return solved[-1][1]


def slope_at(at: Any, small: float) -> float | None:
    """Slope by a central difference."""
    low, high = at(-small), at(small)
    return None if low is None or high is None else (high - low) / (2.0 * small)


def snr_slope(opinions: Sequence[Opinion], goal: Objective) -> float | None:
    """CasADi's change of the objective per decibel of SNR that is asked for; None where it has none to tell."""
    if goal.single != "power" or len(opinions) == 0 or opinions[0].status != "optimal":
        return None
    rules = opinions[0].multipliers.items()
    found = [value for name, value in rules if value is not None and name.startswith(SNR_RULE)]
    return sum(found) * math.log(10.0) / 20.0 if found else None


# ---------------------------------------------------------------- as a whole


TURN = 0.4  # of the time left: what one search may take of it


def without_each(
    sought: Sought, keys: Sequence[str], generic: ToBeMade, deadline: Deadline
) -> Iterator[tuple[str, float]]:
    """Requirements by their keys, and the objective as it is reported of the best system without each, as time allows.

    sought : a complete search, whose parts, light and imagers are known
    """
    goal = sought.goal
    mission, best = sought.problem.mission, sought.outcome.best[0].minimised
    relaxer, ceiling = Relaxer(mission, sought.selection.catalog, generic, sought), best - goal.step(SAME_REL, best)
    for name, (_, key, _) in RELAXABLE.items():
        weaker = without(mission, name) if key in keys else None
        if weaker is None or deadline.passed():
            continue
        found = relaxer.seek(weaker, goal, {name}, deadline=deadline.part(TURN), ceiling=ceiling).outcome
        if found.interrupted:
            raise KeyboardInterrupt
        if found.complete:
            yield key, goal.reported(found.best[0].minimised if found.best else best)
