"""What decides whether hardware holds: the uncertain number on which it depends most, and what asked less would do.

Scenarios are sorted by a number; where its low third holds far more often than its high third, or the other way round,
to know that number is to know whether the hardware will do.

What asked less would do is found by moving one requirement at a time, and counted in the same scenarios.

What it would be worth to know a number before buying: scenarios are sorted into bins by the number. With it known, the
best hardware of each bin would be bought: the expected value of partial perfect information (Strong and Oakley 2013,
Med. Decis. Making 33:755) is by how much the mean of the bins' medians falls. Hardware is chosen on half of the
scenarios and judged on the other, so that luck is worth nothing in the mean; told is a number that is worth more than
whenever it is shuffled over the scenarios, many times.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.arrays import Array
from uwopt.catalog.parts.doubts import doubtful
from uwopt.catalog.records import Housing, Part, Port
from uwopt.deadline import NEVER, Deadline, OutOfTimeError, effort_s
from uwopt.errors import MissionError
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Varied, VariedMission
from uwopt.mission.weakened import (
    LEAST_SNR_DB,
    RELAXABLE,
    asked_value,
    in_all_scenes,
    is_from_above,
    with_limit,
)
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Moved
from uwopt.results.certainty import Decides
from uwopt.solvers.confidence.counted import Counted
from uwopt.solvers.confidence.draws import probabilities
from uwopt.solvers.confidence.outcomes import outcomes
from uwopt.solvers.confidence.scenarios import BEAM_FACTS, PORTS, Scenarios
from uwopt.solvers.confidence.search import Certain, at_its_stop
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.infeasible.least_change import rounded_away
from uwopt.solvers.one_hardware import matters, pieces_of, problem_of
from uwopt.units import split_unit

PART = 3  # of the scenarios, sorted by a number: its first and its last such share are set against each other
LEAST = 0.2  # by which these shares differ at least, to be told
MOST_TOLD = 2  # numbers
OF_LUCK = 20  # numbers that mean nothing: what tells no more than the most telling of them is not told
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


def decided_by(problem: Problem, objective: Objective, seen: Counted, scenarios: Scenarios) -> list[Decides]:
    """The numbers on which it depends most whether hardware holds, the first most; none where luck does as well."""
    held = np.isfinite(seen.outcomes.value[seen.stop])
    if held.all() or not held.any():
        return []
    luck = np.random.default_rng(scenarios.seed).random((OF_LUCK, len(held)))
    least = max(LEAST, *(abs(np.subtract(*shares(held, number))) for number in luck))
    every = [
        Decides(what, part, *shares(held, number))
        for what, part, number in numbers_of(problem, objective, scenarios, seen.found)
    ]
    told = [one for one in every if apart(one) > least]
    return sorted(told, key=apart, reverse=True)[:MOST_TOLD]


def apart(one: Decides) -> float:
    """How far the shares at both sides of a number differ."""
    return abs(one.held_high - one.held_low)


def shares(held: NDArray[np.bool_], number: Array) -> tuple[float, float]:
    """Share that holds where a number is low, and where it is high; of two values, by value."""
    values = np.unique(number)
    if len(values) == 2:
        return tuple(float(held[number == value].mean()) for value in values)  # pyrefly: ignore[bad-return]
    order = np.argsort(number, kind="stable")
    count = max(len(order) // PART, 1)
    return float(held[order[:count]].mean()), float(held[order[-count:]].mean())


def would_hold(
    problem: Problem, objective: Objective, seen: Counted, scenarios: Scenarios, share: float, deadline: Deadline,
    shares: Shares | None = None,
) -> list[Moved]:  # fmt: skip
    """Keys of which less would let the hardware hold as often as asked, each moved alone, as far as time goes.

    What is told was counted; its lens may stand at another stop then. With little time less is found than would do.

    shares : what was counted goes into it
    """
    made, was_coarse, known = [], False, {} if shares is None else shares
    patience = deadline.or_after(EASED_S, effort_s).at_most(EASED_S)
    for ease in eases(problem.mission, all_missed(problem, objective, seen, scenarios)):
        coarse = len(ease.values) > 1
        if coarse and not was_coarse:  # these come last
            patience, was_coarse = deadline.or_after(TRIED_S, effort_s).at_most(TRIED_S), True
        if made and ease.key == ALTITUDE:
            break

        def holds(value: float, ease: Ease = ease, until: Deadline = patience) -> bool:
            until.check()
            try:
                mission = ease.mission_at(value)
            except MissionError:
                return False
            light = light_with(ease, value, scenarios)
            known[ease.key, value] = held_with(problem, objective, seen.found, scenarios, mission, light, until)
            return known[ease.key, value] >= share

        try:
            far = next((value for value in ease.values if holds(value)), None)
            if far is not None:
                needed = far if coarse else nearest(ease.asked, far, holds)
                if ease.key == TOLERANCE:
                    needed = halved((ease.asked, *ease.values), far, holds)
                made.append(Moved(ease.key, ease.asked, needed, ease.unit, not coarse))
        except OutOfTimeError:
            continue
    return made


def halved(values: Sequence[float], far: float, holds: Callable[[float], bool]) -> float:
    """Of values in turn one between the first with which it holds and that before it, by halves; as of `nearest`."""
    near = values[values.index(far) - 1]
    with suppress(OutOfTimeError):
        for _ in range(HALVED):
            middle = rounded_away(0.5 * (near + far), values[0])
            near, far = (near, middle) if holds(middle) else (middle, far)
    return far


def nearest(asked: float, far: float, holds: Callable[[float], bool]) -> float:
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


@dataclass(frozen=True)
class Ease:
    """A key of which less may be asked: values in turn, the first with which hardware holds is told."""

    key: str
    unit: str
    asked: float
    values: tuple[float, ...]  # one alone lies far from what is asked: a nearer one is looked for
    mission_at: Callable[..., Mission]  # takes a value, and a mission in which other keys have moved


def all_missed(problem: Problem, objective: Objective, seen: Counted, scenarios: Scenarios) -> dict[str, int]:
    """What hardware misses first at its stop, in how many scenarios: what no settings can mend as well.

    Hardware that is counted with others behind one port does not tell that.
    """
    if seen.outcomes.lost:
        return seen.outcomes.missed(seen.stop)
    alone = outcomes(problem, seen.found, objective, scenarios, f_numbers=[float(seen.outcomes.f_numbers[seen.stop])])
    return alone.missed(0)


def eases(mission: Mission, missed: Iterable[str]) -> Iterator[Ease]:
    """What may be eased where these requirements are missed: they, and what a vehicle would do to meet them.

    A battery where it holds too little; a steadier height, for all must hold over the band; at last a lower one, which
    eases most, but takes longest: light is worked out anew.
    """
    wanted = {key for name in missed for key in (FOR_LIGHT if name == "light" else (name,))}
    for name, (section, key, _) in RELAXABLE.items():
        asked = asked_value(mission, section, key) if wanted.intersection((name, key)) else None
        if not asked:
            continue
        unit, above = mission.limits.currency if name == "cost" else split_unit(key)[1], is_from_above(name)
        if unit == "db":
            far = asked + FARTHEST_DB if above else max(asked - FARTHEST_DB, LEAST_SNR_DB)
        else:
            far = asked * FARTHEST if above else asked / FARTHEST

        def with_value(
            value: float, there: Mission = mission, section: str = section, key: str = key, asked: float = asked
        ) -> Mission:
            return with_limit(there, section, key, asked, value)

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


def light_with(ease: Ease, value: float, scenarios: Scenarios) -> dict[Any, Any]:
    """How light changes with the water once a key has another value, by image, as far as that is known."""
    if ease.key == TOLERANCE:
        return {image: known.in_narrower_band(value / ease.asked) for image, known in scenarios.responses.items()}
    return {} if ease.key == ALTITUDE else scenarios.responses


def held_with(
    problem: Problem, objective: Objective, found: Found, scenarios: Scenarios, mission: Mission,
    light: dict[Any, Any] | None = None, deadline: Deadline = NEVER,
) -> float:  # fmt: skip
    """Share of the same scenarios in which one hardware holds in another mission; the rest as of `outcomes_with`."""
    return float(outcomes_with(problem, objective, found, scenarios, mission, light, deadline)[1].outcomes.held.max())


def set_and_held_with(
    problem: Problem, objective: Objective, found: Found, scenarios: Scenarios, mission: Mission,
    light: dict[Any, Any] | None = None, deadline: Deadline = NEVER, least: float = 0.0,
) -> float:  # fmt: skip
    """The same at a stop at which it fits by likeliest values too, as what is recommended has to; 0 where none does.

    least : a smaller share is told as 0
    """
    alone, one = outcomes_with(problem, objective, found, scenarios, mission, light, deadline)
    for stop in np.argsort(-one.outcomes.held, kind="stable"):
        if one.outcomes.held[stop] == 0.0 or one.outcomes.held[stop] < least:
            break
        if at_its_stop(alone, objective, replace(one, stop=int(stop))) is not None:
            return float(one.outcomes.held[stop])
    return 0.0


def outcomes_with(
    problem: Problem, objective: Objective, found: Found, scenarios: Scenarios, mission: Mission,
    light: dict[Any, Any] | None = None, deadline: Deadline = NEVER,
) -> tuple[Problem, Counted]:  # fmt: skip
    """One hardware alone in another mission, counted in the same scenarios.

    light : how it changes with the water, by image, at the heights of that mission; None: they are the same
    deadline : raises OutOfTimeError past it
    """
    alone = problem_of(problem, found, mission=mission, scenes=problem.scenes_for(mission))
    here = scenarios.seen_by(mission, alone.scenes)
    here = replace(here, responses=scenarios.responses if light is None else light)
    there = replace(found, camera=0, lens=0, port=0, light=0)
    return alone, Counted(there, outcomes(alone, there, objective, here, deadline), 0)


# ---------------------------------------------------------------- what a number is worth


BINS = 3
LEAST_REL = 0.005  # of the median: what is worth less is not told
SHUFFLED = 100  # times, of a number over the scenarios: what is worth no more than once so is luck, and not told either


@dataclass(frozen=True)
class Worth:
    """One uncertain number and what it is worth to know, in the minimised objective."""

    what: str
    part: str
    worth: float


def worth_of_knowing(problem: Problem, objective: Objective, certain: Certain) -> list[Worth]:
    """Uncertain numbers of the best hardware and of the water, those worth most first."""
    values = np.array([one.outcomes.value[one.stop] for one in certain.tried])
    best = next(k for k, one in enumerate(certain.tried) if one.outcomes is certain.best.outcomes)
    plain = float(np.median(values[best]))
    if len(values) < 2 or not np.isfinite(plain):
        return []

    def worth_of(number: Array) -> float:
        return 0.5 * sum(gained(values, best, number, certain.asked, chosen=half) for half in (0, 1))

    of_best = problem, objective, certain.scenarios, certain.best.found
    told = [(what, part, number, worth_of(number)) for what, part, number in numbers_of(*of_best)]
    found = [
        Worth(what, part, worth) for what, part, number, worth in told
        if worth > LEAST_REL * abs(plain) and is_no_luck(worth_of, number, certain.scenarios.seed)
    ]  # fmt: skip
    return sorted(found, key=lambda one: -one.worth)


def is_no_luck(worth_of: Callable[[Array], float], number: Array, seed: int) -> bool:
    """Whether a number is worth more than whenever it is shuffled over the scenarios: at most one in 101 is by chance.

    A permutation test; Phipson and Smyth 2010, Stat. Appl. Genet. Mol. Biol. 9:39, for the share.
    """
    rng, worth = np.random.default_rng(seed), worth_of(number)
    return all(worth_of(rng.permutation(number)) < worth for _ in range(SHUFFLED))


def gained(values: Array, best: int, number: Array, share: float, *, chosen: int) -> float:
    """By how much the mean of the bins' medians falls; hardware is chosen on every other scenario of a bin."""
    order, saved = np.argsort(number, kind="stable"), 0.0
    for rows in np.array_split(order, BINS):
        ours, theirs = rows[chosen::2], rows[1 - chosen :: 2]
        held = np.isfinite(values[:, ours]).mean(axis=1)
        medians = np.where(held >= min(share, held[best]), middle(values[:, ours]), np.inf)
        pick = int(np.argmin(medians)) if np.isfinite(medians).any() else best
        before, after = middle(values[best : best + 1, theirs])[0], middle(values[pick : pick + 1, theirs])[0]
        if np.isfinite(before) and np.isfinite(after):
            saved += (before - after) / BINS
    return saved


def middle(values: Array) -> Array:
    """Lower median of each row: one of its values, inf where most are."""
    return np.asarray(np.sort(values, axis=1)[:, (values.shape[1] - 1) // 2])


def numbers_of(
    problem: Problem, objective: Objective, scenarios: Scenarios, found: Found
) -> Iterator[tuple[str, str, Array]]:
    """Each uncertain number as it is in every scenario: name, part, a number that grows with it."""
    states = scenarios.states
    for name, text in (
        ("clarity", "clarity of the water"), ("lamp_leg", "K of the lamps' way"), ("floor", "reflectance of the floor"),
        ("other_table", "which table of the Jerlov types holds"), ("beyond", "altitude beyond its band"),
    ):  # fmt: skip
        column = np.array([float(getattr(state, name)) for state in states])
        if np.ptp(column) > 0.0:
            yield text, "", column
    if np.ptp(scenarios.focus) > 0.0:
        yield "distance at which the lens stands", "", np.abs(scenarios.focus - 1.0)
    if not scenarios.doubt.parts:
        return
    for kind, part in pieces_of(problem, found):
        for name in (name for name, _ in doubtful(part) if matters(name, problem, objective)):
            yield f"{kind}.{name}", part.id, drawn(scenarios, part, name)


def drawn(scenarios: Scenarios, part: Part, name: str) -> Array:
    """The probability at which a number of a part is drawn in each scenario."""
    if isinstance(part, (Port, Housing)):
        return probabilities(scenarios.seed, f"{part.id} {name}", PORTS)[scenarios.port]
    if name in BEAM_FACTS:
        return scenarios.beam_probability(part, name)
    return probabilities(scenarios.seed, f"{part.id} {name}", scenarios.count)
