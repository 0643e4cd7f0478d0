"""What would make hardware certain enough where no key moved alone does: other hardware, or several keys together.

It is looked for in the scenarios that the choice was made on; what is told was counted in fresh ones, with settings by
likeliest values as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import combinations, islice

from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.weakened import DEEP, RELAXABLE
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Moved
from uwopt.results.certainty import InVain, WouldHold
from uwopt.solvers.confidence.counted import Counted, names
from uwopt.solvers.confidence.eased import (
    ALTITUDE,
    BATTERY,
    Ease,
    Holds,
    Move,
    MovedKeys,
    Shares,
    all_missed,
    eases,
    nearest_that_holds,
)
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.search import unseen
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.infeasible.least_change import rounded_away
from uwopt.solvers.infeasible.reached import miss
from uwopt.solvers.one_hardware import ids_of_pieces

CHANGES_S = 4.0  # of work, for all of it, where no time is given
JOINT_SHARE = 0.6  # of what is left then, for keys that are moved together
LESS = 0.9  # of a change, that another has to do with to be told in place of what was found
MOST_WIDENED, WIDER = 4, 1.2  # times that a change is made larger, each by so much, until fresh scenarios agree
DRAWN_BACK = 3  # halves of the last of these steps: to 2.5 % of the change
OTHERS = 4  # hardware that was counted, the best first, that is asked as well
MOST_PAIRS = 4  # pairs of keys that hold, the surest first, which are drawn in
LIMITS = tuple(name for name, one in RELAXABLE.items() if one.section == "limits" and name != DEEP)


def told_with(trial: MovedKeys, found: Found, moves: Sequence[Move], ours: Found | None) -> WouldHold | None:
    """As it is told, whatever the time: with what is enough in scenarios that the choice has not seen, too.

    What is just enough in those of the choice owes some of that to luck; it is moved farther then, and drawn back
    as near as these allow while there is time. None where that is in vain, or no settings can be told.
    `ours`: what is recommended.
    """
    anew = replace(trial, scenarios=unseen(trial.problem, trial.share, trial.scenarios), deadline=NEVER)
    widths = [WIDER**number for number in range(MOST_WIDENED)]
    tried = ((width, anew.held(found, by_share(moves, width), as_set=True)) for width in widths)
    enough, held = next(((width, held) for width, held in tried if held >= trial.share), (0.0, 0.0))
    if not enough:
        return None
    if enough > 1.0:
        enough, held = drawn_back(replace(anew, deadline=trial.deadline), found, moves, enough, held)
    moves = by_share(moves, enough)
    same = ours is not None and names(trial.problem, found) == names(trial.problem, ours)
    parts = [] if same else ids_of_pieces(trial.problem, found)
    if parts and found.count > 1:
        parts[-1] = f"{found.count} x {parts[-1]}"
    return WouldHold([moved(*move) for move in moves], parts, held)


def drawn_back(
    trial: MovedKeys, found: Found, moves: Sequence[Move], enough: float, held: float
) -> tuple[float, float]:
    """The least width of some moves with which hardware holds, and how often; a step of `WIDER` less does not do.

    enough, held : the width that does, and how often it holds then
    """
    short = enough / WIDER
    with suppress(OutOfTimeError):
        for _ in range(DRAWN_BACK):
            middle = 0.5 * (short + enough)
            now = trial.held(found, by_share(moves, middle), as_set=True)
            if now >= trial.share:
                enough, held = middle, now
            else:
                short = middle
    return enough, held


def moved(ease: Ease, value: float) -> Moved:
    """A key as it is told."""
    return Moved(ease.key, ease.asked, value, ease.unit, nearest=False)


def far_of(ease: Ease) -> float:
    """The farthest value at which a key is tried; of the altitude the nearest, as light is made anew for each."""
    return ease.values[0] if ease.key == ALTITUDE else ease.values[-1]


def other_changes(
    problem: Problem, objective: Objective, seen: Counted, scenarios: Scenarios, share: float,
    others: Sequence[Counted], deadline: Deadline, shares: Shares | None = None,
) -> tuple[list[WouldHold], list[InVain]]:  # fmt: skip
    """Where no key moved alone is enough for hardware: what else is, and how far each of these comes.

    Two keys moved for the same hardware, or where no two are enough, as few as are; where that is in vain, other
    hardware of those that were counted with one key moved. With little time less is found than would do.

    shares : in which it was found to hold with one key moved; of these nothing is counted again
    """
    patience = deadline.of_work(CHANGES_S)
    trial, ours = MovedKeys(problem, objective, scenarios, share, patience), seen.found
    may_move = [*eases(problem.mission, all_missed(problem, objective, seen, scenarios))]
    alone: list[tuple[Move, float]] = []
    with suppress(OutOfTimeError):
        for ease in may_move:
            far = ease, far_of(ease)
            known = None if shares is None else shares.get((ease.key, far[1]))
            alone.append((far, trial.held(ours, [far]) if known is None else known))
    joint = replace(trial, deadline=patience.part(JOINT_SHARE))
    made = joint_change(joint, ours, alone) or with_other_hardware(trial, ours, [move for move, _ in alone], others)
    return made, [InVain(moved(*move), held) for move, held in alone]


def joint_change(trial: MovedKeys, found: Found, alone: Sequence[tuple[Move, float]]) -> list[WouldHold]:
    """The pair of keys of which the least change is enough together; where none is, as few keys as are."""
    fast = [one for one in alone if one[0][0].key != ALTITUDE]  # for which light is worked out anew each time
    surest_first = sorted(combinations(fast, 2), key=lambda pair: -sum(held for _, held in pair))
    every, holds, enough = [move for move, _ in fast], trial.holds(found), list[list[Move]]()
    with suppress(OutOfTimeError):
        for pair in surest_first:
            moves = [move for move, _ in pair]
            if holds(moves):
                enough.append(moves)
            if len(enough) == MOST_PAIRS:
                break
        if not enough and len(every) > 2 and holds(every):
            enough = [needed(every, holds)]
    near = list[list[Move]]()  # each less than those before it
    with suppress(OutOfTimeError):
        for moves in enough:
            most = min([1.0, *(LESS * size(one) / size(moves) for one in near[-1:])])
            if not near or holds(by_share(moves, most)):
                near.append(drawn_by_share(moves, holds, most))
    least = reversed(near)
    return [*islice((told for moves in least if (told := told_with(trial, found, drawn_in(moves, holds), found))), 1)]


def with_other_hardware(
    trial: MovedKeys, ours: Found, far: Sequence[Move], others: Sequence[Counted]
) -> list[WouldHold]:
    """Other hardware that was counted, with the one key whose least change lets some of it hold."""
    best: tuple[float, list[Move], Found] | None = None
    own = names(trial.problem, ours)
    with suppress(OutOfTimeError):
        for one in [one for one in others if names(trial.problem, one.found) != own][:OTHERS]:
            holds = trial.holds(one.found)
            for move in far:
                if move[0].key != ALTITUDE and holds([move]):
                    moves = drawn_in([move], holds)
                    if best is None or size(moves) < best[0]:
                        best = size(moves), moves, one.found
    told = None if best is None else told_with(trial, best[2], best[1], ours)
    return [] if told is None else [told]


def with_limits_far(problem: Problem) -> Mission:
    """The mission with all of its limits as far off as they are tried."""
    mission = problem.mission
    for ease in limits_of(problem):
        mission = ease.mission_at(far_of(ease), mission)
    return mission


def with_limits_raised(
    problem: Problem, objective: Objective, holding: Sequence[Counted], scenarios: Scenarios, share: float,
    deadline: Deadline,
) -> list[WouldHold]:  # fmt: skip
    """Of hardware that holds without limits what asks for the least of each limit alone; else of as few as are enough.

    problem : with the mission as it is asked; holding : its places are of this problem, the best first
    """
    trial = MovedKeys(problem, objective, scenarios, share, deadline)
    limits = [*limits_of(problem)]
    made, by_price = list[WouldHold](), sorted(holding, key=lambda one: one.outcomes.price)
    some = list({id(one): one for one in (*by_price[:OTHERS], *holding[:OTHERS])}.values())
    with suppress(OutOfTimeError):  # what was found by then was counted
        for ease in limits:
            drawn, far = list[tuple[Found, list[Move]]](), far_of(ease)
            for one in some:
                holds = trial.holds(one.found)
                if holds([(ease, far)]):  # with less than what did before
                    moves = drawn_in([(ease, far)], holds)
                    drawn.append((one.found, moves))
                    far = rounded_away(ease.asked + LESS * (moves[0][1] - ease.asked), ease.asked)
            least = reversed(drawn)
            made += islice((told for found, moves in least if (told := told_with(trial, found, moves, None))), 1)
        if not made and some:
            every = [(ease, far_of(ease)) for ease in limits]
            first = next((one.found for one in some if trial.held(one.found, every) >= share), None)
            if first is not None:
                holds = trial.holds(first)
                moves = drawn_in(drawn_by_share(needed(every, holds), holds), holds)
                made += [told for told in [told_with(trial, first, moves, None)] if told is not None]
    return made


def limits_of(problem: Problem) -> list[Ease]:
    """The limits that a mission sets, and the battery that feeds it: what other hardware may need more of."""
    wanted = {*LIMITS, BATTERY}
    return [ease for ease in eases(problem.mission, (*LIMITS, "energy_wh")) if ease.key in wanted]


def needed(moves: Sequence[Move], holds: Holds) -> list[Move]:
    """As few of these moves as are enough: each that is not needed is dropped."""
    left = [*moves]
    for move in moves:
        rest = [one for one in left if one is not move]
        if rest and holds(rest):
            left = rest
    return left


def by_share(moves: Sequence[Move], share: float) -> list[Move]:
    """Moves by a share of their way, the same of all."""
    return [(ease, rounded_away(ease.asked + share * (far - ease.asked), ease.asked)) for ease, far in moves]


def drawn_by_share(moves: Sequence[Move], holds: Holds, most: float = 1.0) -> list[Move]:
    """Moves by as small a share of their way as is enough, the same of all; `most` is."""
    return by_share(moves, nearest_that_holds(0.0, most, lambda share: holds(by_share(moves, share))))


def drawn_in(moves: Sequence[Move], holds: Holds) -> list[Move]:
    """Moves of which each is as near to what is asked as is enough while the others stay; all are enough as they are.

    None may be left out. Where time ends, as near as was known by then.
    """
    near = [*moves]
    for place, (ease, far) in enumerate(near):
        before, after = near[:place], near[place + 1 :]
        still = partial(holds_at, holds, ease, before, after)
        near = [*before, (ease, nearest_that_holds(ease.asked, far, still)), *after]
    return near


def holds_at(holds: Holds, ease: Ease, before: Sequence[Move], after: Sequence[Move], value: float) -> bool:
    """Whether it holds with one key at a value among others that are moved."""
    return holds([*before, (ease, value), *after])


def size(moves: Sequence[Move]) -> float:
    """How much is asked less, as a share of what is asked, of all keys together."""
    return sum(miss(ease.asked, value) for ease, value in moves)
