"""The hardware that holds in most scenarios with the least median objective.

Hardware with room is looked for by searches in which parts and water are worse than in most scenarios, best first; how
often each holds, and with which objective, is counted in all scenarios. That no other holds as often and is better is
then proven (`proof`), but for the sun's light and for objectives whose settings have no closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from uwopt.catalog.records import OF_A_DESIGN
from uwopt.deadline import NEVER, Deadline, OutOfTimeError, Progress
from uwopt.errors import MissionError
from uwopt.forward.problem import Problem
from uwopt.mission.doubt import ENDS
from uwopt.objectives.objective import Objective
from uwopt.solvers.beside import ahead
from uwopt.solvers.confidence.counted import Counted, Looked, by_names, names, rank
from uwopt.solvers.confidence.local_search import polish
from uwopt.solvers.confidence.outcomes import outcomes, outcomes_of_each
from uwopt.solvers.confidence.proof import NoneBetter, Prover
from uwopt.solvers.confidence.roomy import WORSE, RoomySearches
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.worst_case import EndScenarios
from uwopt.solvers.exact.ranking import Found, told_apart
from uwopt.solvers.exact.search import Search
from uwopt.solvers.one_hardware import as_set
from uwopt.solvers.recommend import Sought
from uwopt.solvers.settings.best import scenes_need_cells
from uwopt.tolerances import LUCK, TIE, TIED_MEDIANS_REL

OF_CENTRAL = 2  # of the central search
ENOUGH = 3  # hardware that holds: no further search is made
POLISH_S = 2.0  # that a round of it may last where there is a limit
PROVEN_REST, UNPROVEN_REST = 0.6, 0.2  # of the time that is left, for what comes after it: a proof, or none
PROOF_SHARE = 0.6  # of the time that is left: the rest is for what is told of the choice, or to count what is known
TIED_BEST, TIED_CHEAPEST = 2, 2  # hardware of what is as good as tied that is compared anew
TIES, TIES_SEED = 1024, 2_000_003  # scenarios in which what is as good as tied is compared
STILL_TIED_REL = 0.01  # of the median, what luck makes of it in these: less is not worth a dearer system
FRESH = 1024  # scenarios that the choice has not seen
FRESH_SEED = 1_000_003


@dataclass(frozen=True)
class Certain:
    """What was found: the best and all that was counted; as it is set, in scenarios that the choice has not seen."""

    asked: float
    scenarios: Scenarios
    best: Counted
    central: Found  # the best with every number at its central value and its iris at that stop
    tried: list[Counted]
    complete: bool  # whether there was time for every search
    ranked: list[Counted] = field(default_factory=list)  # the same, the first to buy first
    fresh: Counted | None = None
    proof: NoneBetter | None = None
    held_again: dict[int, float] = field(default_factory=dict)  # as of `Looked`

    @property
    def proven(self) -> bool:
        """Whether no other hardware holds as often with a better median, or none as often at all."""
        if self.proof is None or self.proof.left:
            return False
        least, ours = self.proof.lower_bound, self.best.quantile(0.5)
        return not np.isfinite(least) or (self.enough and ours <= least + TIE * abs(least))

    @property
    def enough(self) -> bool:
        """Whether the best holds as often as asked."""
        return self.best.held >= self.asked


def scenarios_of(
    problem: Problem, asked: float | str, seed: int, count: int, like: Scenarios | None = None
) -> Scenarios:
    """Scenarios of a problem's mission: so many drawn, or the ends of all that is uncertain."""
    mission = problem.mission
    if asked == ENDS:
        return EndScenarios.of(mission, problem.scenes, mission.doubt)
    return Scenarios.drawn(mission, problem.scenes, mission.doubt, seed=seed, count=count, like=like)


def unseen(problem: Problem, asked: float | str, like: Scenarios) -> Scenarios:
    """Scenarios that the choice has not seen, of waters as known as in others."""
    return scenarios_of(problem, asked, (problem.mission.seed + FRESH_SEED) % 2**32, FRESH, like)


def look(
    sought: Sought, asked: float | str, deadline: Deadline, report: Progress, *,
    with_room: bool = False, like: Scenarios | None = None, before: Looked | None = None, known: Sequence[Found] = (),
) -> Looked:  # fmt: skip
    """Count hardware that is likely to hold.

    with_room : no more than central optima where nothing fits with room
    like : scenarios of the same mission and scenes, whose waters are known
    before : what was counted so, to go on from
    known : hardware that is good in a mission like this
    """
    problem, objective, mission = sought.problem, sought.goal, sought.problem.mission
    check_fixed(problem, objective)
    if before is None:
        scenarios = scenarios_of(problem, asked, mission.seed, mission.doubt.scenarios, like)
        seen = Looked(problem, objective, asked, scenarios, [])
    else:
        seen = replace(before, tried=[*before.tried], complete=True, fits={**before.fits})
    central = {names(problem, one) for one in sought.outcome.best[:OF_CENTRAL]}
    brought_up = candidates(
        sought, seen, deadline, done=lambda: seen.holding >= ENOUGH, hopeful=lambda: seen.holding > 0,
        with_room=with_room, known=known,
    )  # fmt: skip
    try:
        with closing(brought_up):
            for some in brought_up:
                count_in_time(seen, some, central, deadline)
                report(0.0, f"hardware counted in scenarios: {len(seen.tried)}")  # nobody knows how many follow
    except OutOfTimeError:
        if not seen.tried:
            raise
        return replace(seen, complete=False)
    return seen


def count_in_time(seen: Looked, some: Sequence[Found], last: Collection[Any], deadline: Deadline) -> None:
    """Count hardware, all of it together; where there is no time for that, one by one. Raises OutOfTimeError.

    last : names of what is counted after the others then: it is known to do what is asked, and not to have room
    """
    try:
        seen.count(some, deadline)
    except OutOfTimeError:
        for one in sorted(some, key=lambda one: names(seen.problem, one) in last):
            seen.count([one], deadline)
        raise


def best_counted(seen: Looked, deadline: Deadline, report: Progress) -> Certain | None:
    """The best of what was counted, compared with what is near it, and proven as far as there is time."""
    problem, objective, share = seen.problem, seen.objective, seen.share
    rest = PROVEN_REST if can_be_proven(problem, objective) else UNPROVEN_REST
    count_near(seen, deadline, 1.0 - rest)
    proof = None
    if seen.complete and can_be_proven(problem, objective):
        proof = Prover(seen, deadline.part(PROOF_SHARE), report).run()
    ranked = seen.ranked
    if seen.scenarios.is_drawn and (proof is None or proof.left):
        ranked = without_luck(seen, ranked, deadline)
    best, central = first_that_fits(problem, objective, ranked)
    if best is None or central is None:
        return None
    return Certain(
        share, seen.scenarios, best, central, seen.tried, seen.complete, ranked, proof=proof, held_again=seen.held_again
    )


def count_near(seen: Looked, deadline: Deadline, part: float) -> None:
    """Count what differs by a part from the best of what was counted, in a part of the time that is left."""
    if not (seen.complete and seen.scenarios.is_drawn):
        return
    timed = math.isfinite(deadline.left_s)
    most_s, a_round_s = (part * deadline.left_s, POLISH_S) if timed else (math.inf, math.inf)
    patience = deadline.at_most(most_s)
    polish(seen, patience, a_round_s)
    serves, best = partial(fits_centrally, seen.problem, seen.objective, {}), seen.best
    if best is not None and best.held < seen.share and not serves(best):  # of what is surest no settings can be told
        polish(seen, patience, a_round_s, serves)


def without_luck(seen: Looked, ranked: list[Counted], deadline: Deadline) -> list[Counted]:
    """Hardware best first, where medians are as good as tied by those in further scenarios, if there is time.

    What these cannot tell from the best of them either is ranked by price. What does not hold as often as asked in
    them is refuted: it comes after what is not, that which holds most often first. Where the median of the best is
    itself in doubt, as where light goes by steps, what is surest to be low is compared with it, too.
    """
    share, most = seen.share, ranked[0].quantile(0.5)
    high = high_median(seen.scenarios)
    alike = [one for one in ranked if one.held >= share and one.settings is None]
    close = [one for one in alike if one.quantile(0.5) <= most + TIED_MEDIANS_REL * abs(most)]
    cheap = sorted(close[TIED_BEST:], key=lambda one: one.outcomes.price)[:TIED_CHEAPEST]
    tied = [*close[:TIED_BEST], *cheap]
    sure = min(alike, key=lambda one: one.quantile(high), default=ranked[0])
    at_most = sure.quantile(high) + TIED_MEDIANS_REL * abs(sure.quantile(high))
    if at_most < min((one.quantile(high) for one in tied), default=-math.inf):
        tied.append(sure)
    if len(tied) < 2 or not np.isfinite(most):
        return ranked
    try:
        anew = counted_anew(seen, tied, deadline)
    except OutOfTimeError:
        return ranked
    seen.held_again.update((id(one.outcomes), again.held) for one, again in zip(tied, anew, strict=True))
    held = [(one, again) for one, again in zip(tied, anew, strict=True) if again.held >= share]
    least = min((again.quantile(0.5) for _, again in held), default=0.0)
    still = least + STILL_TIED_REL * abs(least)

    def order(pair: tuple[Counted, Counted]) -> tuple[float, float]:
        """By the median anew, what is still tied with the best first and by price."""
        median, price = pair[1].quantile(0.5), float(told_apart(pair[1].outcomes.price))
        return (least, price) if median <= still else (median, price)

    rest = [one for one in ranked if all(one is not other for other in tied)]
    refuted = sorted(
        ((one, again) for one, again in zip(tied, anew, strict=True) if again.held < share),
        key=lambda pair: rank(pair[1], share),
    )
    hold = sum(one.held >= share for one in rest)  # these come first
    return [*(one for one, _ in sorted(held, key=order)), *rest[:hold], *(one for one, _ in refuted), *rest[hold:]]


def high_median(scenarios: Scenarios) -> float:
    """The quantile of what is counted in these scenarios that the true median may be as high as."""
    return 0.5 + (0.5 * LUCK / math.sqrt(scenarios.count) if scenarios.is_drawn else 0.0)


def counted_anew(seen: Looked, some: Sequence[Counted], deadline: Deadline) -> list[Counted]:
    """The same hardware, each at its stop, in further scenarios."""
    problem = seen.problem
    seed = (problem.mission.seed + TIES_SEED) % 2**32
    scenarios, anew = scenarios_of(problem, seen.asked, seed, TIES, seen.scenarios), dict[int, Counted]()
    for f_number in {one.f_number for one in some}:
        deadline.check()
        alike = [one for one in some if one.f_number == f_number]
        stops, found = None if f_number is None else [f_number], [one.found for one in alike]
        made = outcomes_of_each(problem, found, seen.objective, scenarios, deadline, f_numbers=stops)
        anew |= {id(one): Counted(one.found, own, 0) for one, own in zip(alike, made, strict=True)}
    return [anew[id(one)] for one in some]


def check_fixed(problem: Problem, objective: Objective) -> None:
    """Settings that are fixed before the water is seen are not counted under the sun, nor for information."""
    under_sun = any(scene.sunlit for scene in problem.scenes)
    if problem.mission.doubt.settings == "fixed" and (under_sun or objective.weight("information")):
        where = "under the sun" if under_sun else "for information"
        raise MissionError([f"doubt.settings: fixed is not counted {where}; leave it at adapt"])


def can_be_proven(problem: Problem, objective: Objective) -> bool:
    """Whether panels bound every scenario: not under the sun, nor where settings have no closed form."""
    return not any(scene.sunlit for scene in problem.scenes) and not scenes_need_cells(problem.scenes, objective)


def first_that_fits(
    problem: Problem, objective: Objective, ranked: Sequence[Counted]
) -> tuple[Counted | None, Found | None]:
    """The first of these that is feasible with every number at its central value too; found at once."""
    for one in ranked:
        if (found := at_its_stop(problem, objective, one)) is not None:
            return one, found
    return None, None


def fits_centrally(problem: Problem, objective: Objective, known: dict[int, bool], one: Counted) -> bool:
    """Whether one is feasible with every number at its central value too; `known`: of what was asked before."""
    if id(one) not in known:
        known[id(one)] = at_its_stop(problem, objective, one) is not None
    return known[id(one)]


def candidates(
    sought: Sought, seen: Looked, deadline: Deadline, *, done: Callable[[], bool],
    hopeful: Callable[[], bool], with_room: bool = False, known: Sequence[Found] = (),
) -> Generator[list[Found]]:  # fmt: skip
    """Hardware worth counting, some at a time: the best of the central search and what is known to be good, then of
    those with room.

    What is proven besides brings up all other hardware that holds; else worse numbers are tried. Where none of these
    holds, the brightest and worse numbers still; where nothing fits with room, less room is asked for, unless that is
    all that is wanted (`with_room`). What was looked at is not searched again, nor is counted hardware brought up.
    Where some that is known holds and a proof is to come, no other is searched for. While hardware is counted the next
    search is made, for as long as it is not known whether it is needed.
    """
    problem, objective = sought.problem, sought.goal
    provable = can_be_proven(problem, objective)
    rungs = WORSE if not provable else () if known else WORSE[:1]
    had, first = {names(problem, one.found) for one in seen.tried}, (*sought.outcome.best[:OF_CENTRAL], *known)
    new = by_names(problem, first, had)
    waiting = [*new.values()]
    had.update(new)
    searches = RoomySearches.of(
        problem, objective, seen.scenarios, rungs=rungs, with_room=with_room, had=had, fits=seen.fits
    )
    if known and provable:
        yield waiting
        waiting = []  # else they are counted with the first that have room: light is worked out once
    patience = deadline.part(PROOF_SHARE) if waiting else deadline
    try:
        more = searches.next(patience, done=done(), hopeful=hopeful(), once=bool(waiting))
    except OutOfTimeError:
        yield waiting
        raise
    waiting = [] if more is None else [*waiting, *more]
    while waiting:
        held = hopeful()
        with ahead(partial(searches.ahead, deadline, hopeful=held), lists=[deadline.left_out]) as further:
            yield waiting
            if done() or hopeful() != held:
                more = searches.next(deadline, done=done(), hopeful=hopeful())
            else:
                more, then = further()
                deadline.check()
                searches.take_over(then)
        waiting = more or []


def tied_with_best(problem: Problem, choice: Certain, other: Found) -> bool:
    """Whether other hardware was counted, holds as often as is asked, and is no worse than luck makes of the best.

    Neither in its median, nor where light goes by steps in what the true median may be.
    """
    name = names(problem, other)
    if name == names(problem, choice.best.found):
        return False
    ours = {share: choice.best.quantile(share) for share in (0.5, high_median(choice.scenarios))}
    return any(
        one.held >= choice.asked
        and all(one.quantile(share) <= at + TIED_MEDIANS_REL * abs(at) for share, at in ours.items())
        for one in choice.tried
        if names(problem, one.found) == name
    )


def judged_anew(
    problem: Problem, objective: Objective, certain: Certain, focus_m: float, deadline: Deadline
) -> Certain:
    """With what it does in scenarios that the choice has not seen, its lens focused where that is told."""
    fresh = deadline.within(
        "scenarios that the choice has not seen", lambda: anew(problem.focused_on(focus_m), objective, certain), None
    )
    return replace(certain, fresh=fresh)


def anew(problem: Problem, objective: Objective, certain: Certain) -> Counted:
    """The best in scenarios that the choice has not seen, at the same stop, with its settings where they are fixed."""
    scenarios = unseen(problem, certain.asked, certain.scenarios)
    stop = None if certain.best.f_number is None else [certain.best.f_number]
    found, given = certain.best.found, certain.best.settings
    return Counted(found, outcomes(problem, found, objective, scenarios, f_numbers=stop, given=given, tells=True), 0)


def at_its_stop(problem: Problem, objective: Objective, one: Counted, deadline: Deadline = NEVER) -> Found | None:
    """The same hardware by likeliest values, iris and focus where scenarios want them; None where nothing fits."""
    alone, imagers = as_set(problem, one.found, one.f_number, one.outcomes.meant_m)
    best = Search(alone, objective, top=1, imagers=imagers, deadline=deadline).whole().best if len(imagers) else []
    if not best:
        return None
    places = {kind: getattr(one.found, kind) for kind in OF_A_DESIGN}
    return replace(best[0], **places, imager=one.found.imager, lighting=one.found.lighting)
