"""Hardware that is better by one part than the best that is known, looked for until there is none.

Each part is replaced in turn, as are number, places and orientation. All that pass the rules without light are looked
at in some scenarios, those about the median of the best known and those that it finds hard; what seems to hold and to
be better there is counted in all of them. Searches in worse numbers rank by those; a median may rank otherwise.

What seemed better than the last best is likely to be better still with the next: such changes are tried together first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import Deadline, OutOfTimeError
from uwopt.forward.problem import Problem
from uwopt.solvers.confidence.counted import Counted, Looked, by_names, names
from uwopt.solvers.confidence.outcomes import outcomes_of_each
from uwopt.solvers.confidence.scenarios import SomeScenarios
from uwopt.solvers.confidence.states import colours_of
from uwopt.solvers.exact.imager_rules import Behind
from uwopt.solvers.exact.imagers import fitting_pairs, imagers_in, landscapes
from uwopt.solvers.exact.lightings import Lighting
from uwopt.solvers.exact.ranking import Found

ABOUT_MEDIAN, HARD = 9, 15  # scenarios that are looked at
SLACK = 0.21  # of the hard ones, in which what is counted may hold less often than the best known
EASY = 0.6  # of the scenarios, of which none is looked at for being hard
A_GLANCE, A_COUNT = 32, 8  # hardware that is looked at, or counted, at once
A_ROUND = 16  # that is counted in a round, the best by what was seen of it
ROUNDS = 4
BETTER_REL = 1e-4  # of the objective: what seems no better is not counted
CLOSE_REL, MOST_CLOSE = 0.01, 2  # but of what seems as good but for luck so many in the end, beside the best


Serves = Callable[[Counted], bool]


def whatever(one: Counted) -> bool:
    """Where all that is counted may be chosen."""
    del one
    return True


def polish(seen: Looked, deadline: Deadline, a_round_s: float = math.inf, serves: Serves = whatever) -> bool:
    """Count what may be better by one part than the best known that serves; whether there was time until nothing is.

    Who finds something better has `a_round_s` anew, as far as the deadline goes. Of what is ranked worse than the best
    that serves it is not asked.
    """
    problem, known, both = seen.problem, set[Any](), list[Found]()
    for _ in range(ROUNDS):
        best = next(filter(serves, seen.ranked), None)
        if best is None:
            return True
        near = by_names(problem, [*both, *neighbours(problem, best.found)], known)
        known.update(near)
        beside = seen_beside(seen, [*near.values()], deadline.at_most(a_round_s), best)
        better = next(filter(serves, seen.ranked), None)
        if better is best or better is None:
            if math.isfinite(a_round_s) and not deadline.passed():  # else all is looked at, or proven
                seen.count(beside.close[:MOST_CLOSE])
            return beside.complete
        both = with_both(problem, best.found, better.found, beside.better)
    return False


def with_both(problem: Problem, base: Found, best: Found, others: Sequence[Found]) -> list[Found]:
    """The best with what else is changed in each of others, all of them by few parts from a base; what fits together.

    Where both change the same, as in the other.
    """
    pairs = fitting_pairs(problem)
    fits = set(zip(pairs.camera.tolist(), pairs.lens.tolist(), strict=True))
    made = [changed_too(problem, base, best, other) for other in others if other is not best]
    return [one for one in made if (one.camera, one.lens) in fits]


def changed_too(problem: Problem, base: Found, one: Found, other: Found) -> Found:
    """Hardware with all that is changed in one or the other of two; where both change the same, as in the second."""
    changed = {
        name: getattr(other if getattr(other, name) != getattr(base, name) else one, name)
        for name in ("camera", "lens", "port", "landscape", "light", "count")
    }
    lit = other.lighting if other.lighting.mount != base.lighting.mount else one.lighting
    optics = int(problem.lights.optics_index[changed["light"]])
    return replace(base, **changed, lighting=replace(lit, optics=optics))


class SeenBeside(NamedTuple):
    """What a comparison has looked at."""

    complete: bool  # whether there was time for all
    better: list[Found]  # what seemed better than the best known, the best first
    close: list[Found]  # what seemed as good but for luck


def seen_beside(seen: Looked, others: Sequence[Found], deadline: Deadline, best: Counted) -> SeenBeside:
    """Look at other hardware beside the best known, and count what seems better."""
    problem = seen.problem
    known = {names(problem, one.found) for one in seen.tried}
    new = [
        one for one in others
        if names(problem, one) not in known and colours_of(problem.parts.cameras[one.camera]) in seen.scenarios.colours
    ]  # fmt: skip
    glance, complete = Glance.of(seen, best), True
    try:
        for first in range(0, len(new), A_GLANCE):
            glance.look_at(new[first : first + A_GLANCE], deadline)
    except OutOfTimeError:
        complete = False
    hopeful = glance.promising[:A_ROUND]
    for first in range(0, len(hopeful), A_COUNT):
        if first and deadline.passed():
            return SeenBeside(False, hopeful, glance.close)
        seen.count(hopeful[first : first + A_COUNT])
    return SeenBeside(complete, hopeful, glance.close)


@dataclass
class Glance:
    """What hardware does in some scenarios: those about the median of the best known, and those that it finds hard."""

    beside: Looked
    best: Counted
    scenarios: SomeScenarios
    about: Array
    hard: Array
    seen: list[tuple[float, Found]] = field(default_factory=list)
    no_better: list[tuple[float, Found]] = field(default_factory=list)

    @staticmethod
    def of(beside: Looked, best: Counted) -> Glance:
        """About the best known, at its stop."""
        order = np.argsort(best.outcomes.value[best.stop], kind="stable")
        middle = (len(order) - 1) // 2
        about = order[max(middle - ABOUT_MEDIAN // 2, 0) : middle + ABOUT_MEDIAN // 2 + 1]
        hard = order[np.unique(np.linspace(EASY * len(order), len(order) - 1, HARD).astype(int))]
        places = np.unique(np.concatenate([about, hard]))
        some = SomeScenarios.among(beside.scenarios, places)
        return Glance(beside, best, some, np.isin(places, about), np.isin(places, hard))

    def look_at(self, some: Sequence[Found], deadline: Deadline) -> None:
        """Keep of these what seems better than the best known, looked at beside them."""
        problem, objective, share = self.beside.problem, self.beside.objective, self.beside.share
        own, *made = outcomes_of_each(problem, [self.best.found, *some], objective, self.scenarios, deadline)
        base = own.value[own.best(share)]
        ours = float(np.isfinite(base[self.hard]).mean())
        for found, one in zip(some, made, strict=True):
            values = [(float(np.isfinite(value[self.hard]).mean()), value) for value in one.value]
            if self.best.held >= share:
                steps = [step(value[self.about], base[self.about]) for held, value in values if held >= ours - SLACK]
                least = min(steps, default=np.inf)
                (self.seen if least < -BETTER_REL else self.no_better).append((least, found))
            elif (most := max(held for held, _ in values)) > ours:
                self.seen.append((-most, found))

    @property
    def close(self) -> list[Found]:
        """What seems worse by no more than luck, the best first."""
        return [found for least, found in sorted(self.no_better, key=lambda one: one[0]) if least < CLOSE_REL]

    @property
    def promising(self) -> list[Found]:
        """What seems better, the best first."""
        return [found for _, found in sorted(self.seen, key=lambda one: one[0])]


def step(value: Array, base: Array) -> float:
    """By which share an objective is more than another in half of some scenarios; inf where it does not hold there."""
    with np.errstate(invalid="ignore", divide="ignore"):
        steps = (value - base) / np.abs(base)
    return float(np.median(np.where(np.isnan(steps), np.inf, steps)))


def neighbours(problem: Problem, found: Found) -> list[Found]:
    """The same with another camera, lens, port, light, number or place of lamps, or turned; what passes by rules.

    Another camera or lens may take another housing of the same port: it need not fit into that of the first. Of ports
    that differ in their housing alone no housing that another betters.
    """
    made = [*other_lamps(problem, found), *other_views(problem, found)]
    return [*by_names(problem, made).values()]


def other_views(problem: Problem, found: Found) -> Iterator[Found]:
    """The same with another imager, by one of its parts or turned."""
    pairs = fitting_pairs(problem)
    near = (pairs.camera == found.camera) != (pairs.lens == found.lens)
    own = np.array([found.camera]), np.array([found.lens])
    housed = np.flatnonzero(problem.like_port == problem.like_port[found.port])
    asked = [Behind(*own, ports, found.landscape) for ports in problem.port_groups]
    asked += [Behind(*own, np.array([found.port]), turned) for turned in landscapes(problem)]
    asked += [Behind(pairs.camera[near], pairs.lens[near], housed, found.landscape)]
    seen = imagers_in(problem, asked)
    for row in zip(*(each.tolist() for each in (seen.camera, seen.lens, seen.port, seen.landscape)), strict=True):
        yield replace(found, camera=row[0], lens=row[1], port=row[2], landscape=row[3])


def other_lamps(problem: Problem, found: Found) -> Iterator[Found]:
    """The same under other lamps, more or fewer, or elsewhere."""
    low, high = problem.count_range
    for light, optics in enumerate(problem.lights.optics_index.tolist()):
        for count in range(low, high + 1):
            yield replace(found, light=light, count=count, lighting=replace(found.lighting, optics=optics))
    for index, mount in enumerate(problem.mounts):
        yield replace(found, lighting=Lighting(found.lighting.optics, index, mount))
