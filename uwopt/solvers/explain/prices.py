"""What a binding requirement costs: the same system with a little more asked of it, and CasADi's word on the slope.

    dV / d(20 lg SNR) = lambda ln(10) / 20

lambda is the multiplier of ln(SNR) >= ln(least SNR) in the program of the winner's settings, in the objective's unit.
The slope is confirmed by a central difference of the search of that hardware, which owes nothing to CasADi. Of other
keys, which are no constraints of that program of their own, the slope is that difference alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from uwopt.deadline import Deadline
from uwopt.errors import MissionError
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Varied, VariedMission, rounded
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Price
from uwopt.results.design import Design
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.one_hardware import problem_of
from uwopt.solvers.explain.weakened import RELAXABLE, asked_value, is_from_above
from uwopt.solvers.recommend import Sought, same_scenes
from uwopt.units import split_unit

STEP_SHARE = 0.1  # of what is asked; of decibels one
SMALL = 1e-2  # of a step, for the slope
SNR = "min_snr_db"
SNR_RULE = "min_snr["  # how CasADi's rules of SNR begin


def priced_keys(mission: Mission, winner: Design) -> Iterator[tuple[Varied, float, float]]:
    """What binds of requirements and image interval, and the speed: key, what is asked, a step that asks for more."""
    binding = {margin.requirement for scene in winner.scenes for margin in scene.margins if margin.binding}
    for name, (section, key, _) in RELAXABLE.items():
        asked = asked_value(mission, section, key) if key in binding else None
        if asked and key not in ("depth_rating_m", "mean_level"):
            step = step_of(key, asked)
            yield Varied(key, section, key, (asked,)), asked, -step if is_from_above(name) else step
    intervals = {view.asked.frame_interval_s for view in mission.views}
    if "frame_interval_s" in binding and len(intervals) == 1 and (interval := intervals.pop()):
        name = "frame_interval_s"
        yield Varied(name, "requirements", name, (interval,)), interval, -step_of(name, interval)
    speeds = {view.vehicle.speed_m_s for view in mission.views}
    if len(speeds) == 1 and (speed := speeds.pop()) > 0.0:
        yield Varied("speed_m_s", "vehicle", "speed_m_s", (speed,)), speed, step_of("speed_m_s", speed)


def step_of(key: str, asked: float) -> float:
    """A step that a person would take: a decibel, or about a tenth with one digit."""
    if split_unit(key)[1] == "db":
        return 1.0
    share = STEP_SHARE * abs(asked)
    unit = 10.0 ** math.floor(math.log10(share))
    return rounded(round(share / unit) * unit)


def prices(
    sought: Sought, goal: Objective, winner: Design, opinions: Sequence[Mapping[str, Any]], deadline: Deadline
) -> list[Price]:
    """What a step more of each binding requirement costs with this system, as far as there is time."""
    mission, found = sought.problem.mission, sought.outcome.best[0]
    base, made, solved = VariedMission(mission, {}), [], list[tuple[Mission, float | None]]()
    for key, asked, step in priced_keys(mission, winner):
        deadline.check()

        def at(more: float, key: Varied = key, asked: float = asked) -> float | None:
            return reached(sought, found, base, goal, key, rounded(asked + more), solved)

        here, there = at(0.0), at(step)
        if here is None:
            continue
        slope = slope_at(at, SMALL * abs(step))
        told = snr_slope(opinions, goal) if key.name == SNR else None
        change = None if there is None else there - here
        made.append(Price(key.name, split_unit(key.name)[1], asked, step, change, slope, told))
    return made


def reached(
    sought: Sought, found: Found, base: VariedMission, goal: Objective, key: Varied, value: float,
    solved: list[tuple[Mission, float | None]],
) -> float | None:  # fmt: skip
    """The objective, as it is reported, of one system where a key has another value; None where it does not fit.

    solved : what missions reached before: what is asked of one key is asked of all, so that its mission comes again
    """
    try:
        mission = base.with_values({key: value})
    except MissionError:
        return None
    for other, before in solved:
        if other == mission:
            return before
    problem = problem_of(sought.problem, found, mission=mission, scenes=same_scenes(sought.problem, mission))
    best = Search(problem, goal, top=1).run().best
    solved.append((mission, goal.reported(best[0].minimised) if best else None))
    return solved[-1][1]


def slope_at(at: Any, small: float) -> float | None:
    """Slope by a central difference."""
    low, high = at(-small), at(small)
    return None if low is None or high is None else (high - low) / (2.0 * small)


def snr_slope(opinions: Sequence[Mapping[str, Any]], goal: Objective) -> float | None:
    """CasADi's change of the objective per decibel of SNR that is asked for; None where it has none to tell."""
    if goal.single != "power" or len(opinions) == 0 or opinions[0].get("status") != "optimal":
        return None
    rules = (opinions[0].get("multipliers") or {}).items()
    found = [value for name, value in rules if name.startswith(SNR_RULE)]
    return sum(found) * math.log(10.0) / 20.0 if found else None
