"""An attack on the certificate: what it says is not worth having, solved again by other means.

Combinations are drawn from what each rule discarded, and from what differs from the recommendation by a part or
two: there a part that was thrown away by mistake shows. Each gets the forward model in full physics and a generic
search over its settings; one that is feasible and better than the recommendation makes the audit fail.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice, zip_longest
from typing import Any

import numpy as np

from uwopt.deadline import NEVER, Deadline
from uwopt.forward.designs import Hardware
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.attack import attack, fits
from uwopt.solvers.exact.imagers import landscapes
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.settings.best import scenes_need_cells
from uwopt.solvers.settings.question import GAP
from uwopt.tolerances import BEATS_REL

BESIDE = "beside the best"  # the draw that follows no rule
TWO_PARTS = 0.4  # share of these that differ in a second part


@dataclass(frozen=True)
class Retry:
    """One combination tried again."""

    rule: str
    hardware: Hardware
    value: float  # minimised objective of the best feasible settings found; inf: none


def audit(
    search: Search, objective: Objective, *, count: int, seed: int, best_value: float | None,
    lower_bound: float = np.inf, deadline: Deadline = NEVER,
) -> dict[str, Any]:  # fmt: skip
    """Draw, attack, report.

    What a rule discarded must not beat the best. Beside the best there is what was not reached in time, or not
    settled to the last digit: the certificate claims no more of it than its `lower_bound`.
    """
    rng = np.random.default_rng(seed)
    tries = drawn(search, count, rng)
    found: list[Retry] = []
    for rule, hardware in tries:
        if deadline.passed():
            deadline.left_out.append(f"{len(tries) - len(found)} of the audit's {len(tries)} attempts")
            break
        found.append(Retry(rule, hardware, attack(search.problem, hardware, objective, rng)))
    most = np.inf if best_value is None else least_that_beats(search.problem, objective, best_value)
    open_from = min(most, lower_bound - BEATS_REL * abs(lower_bound)) if np.isfinite(lower_bound) else most
    better = [a for a in found if a.value < (open_from if a.rule == BESIDE else most)]
    by_rule: dict[str, int] = {}
    for attempt in found:
        by_rule[attempt.rule] = by_rule.get(attempt.rule, 0) + 1
    return {
        "tried": len(found),
        "by_rule": by_rule,
        "feasible": sum(bool(np.isfinite(a.value)) for a in found),
        "passed": not better,
        "better": [facts(search.problem, objective, a) for a in better],
    }


def least_that_beats(problem: Problem, objective: Objective, best_value: float) -> float:
    """What is below this is better than the best: by more than rounding, or than the gap that is claimed where
    settings have no closed form."""
    gap = GAP if scenes_need_cells(problem.scenes, objective) else BEATS_REL
    return best_value - gap * abs(best_value)


def facts(problem: Problem, objective: Objective, attempt: Retry) -> dict[str, Any]:
    """One attempt in the words of a result."""
    at = attempt.hardware
    return {
        "rule": attempt.rule, **{kind: part.id for kind, part in problem.parts.of(at).items()},
        "light_count": problem.lamps_carried(at), "objective_value": objective.reported(attempt.value),
    }  # fmt: skip


# ---------------------------------------------------------------- what is drawn


def drawn(search: Search, count: int, rng: np.random.Generator) -> list[tuple[str, Hardware]]:
    """Half from what rules discarded, half from around the best; all from the rules where nothing was found."""
    best = search.ranking.best
    beside = [] if not best else neighbours(search.problem, best[0], count // 2, rng)
    by_rule = from_rules(search, count - len(beside), rng)
    return by_rule + [(BESIDE, hardware) for hardware in beside]


def from_rules(search: Search, count: int, rng: np.random.Generator) -> list[tuple[str, Hardware]]:
    """Combinations from each rule's discards, as evenly as there are rules."""
    problem = search.problem
    low, high = problem.count_range
    pools = {rule: pool for rule, pool in search.discarded_samples().items() if pool}
    picked: list[tuple[str, Hardware]] = []
    rules, n_lights = sorted(pools), len(problem.parts.lights)
    for number in range(count if rules and n_lights else 0):
        rule = rules[number % len(rules)]
        camera, lens, port, landscape, k = pools[rule][int(rng.integers(len(pools[rule])))]
        light = int(rng.integers(n_lights)) if k is None else int(rng.choice(search.bounds.light_tables[k].light))
        mount = problem.mounts[int(rng.integers(len(problem.mounts)))]
        picked.append(
            (rule, Hardware(camera, lens, port, landscape, light, int(rng.integers(low, high + 1)), mount))
        )
    return picked


def neighbours(problem: Problem, best: Found, count: int, rng: np.random.Generator) -> list[Hardware]:
    """Hardware that differs from the best by one part, number, mount or orientation, some by a second one.

    Of each kind as many while there are some; parts that do not go together are no use.
    """
    home = best.hardware
    choices = {
        name: [value for value in options if value != getattr(home, name)]
        for name, options in options_of(problem).items()
    }
    by_turns = zip_longest(*(
        [replace(home, **{name: values[int(place)]}) for place in rng.permutation(len(values))]
        for name, values in choices.items()
    ))  # fmt: skip
    single = (hardware for turn in by_turns for hardware in turn if hardware is not None)
    found = []
    for hardware in islice((one for one in single if fits(problem, one)), count):
        twice = hardware
        name = list(choices)[int(rng.integers(len(choices)))]
        if choices[name] and rng.random() < TWO_PARTS:
            twice = replace(hardware, **{name: choices[name][int(rng.integers(len(choices[name])))]})
        found.append(twice if fits(problem, twice) else hardware)
    return found


def options_of(problem: Problem) -> dict[str, list[Any]]:
    """All that each choice of a hardware may be."""
    parts, (low, high) = problem.parts, problem.count_range
    return {
        "camera": list(range(len(parts.cameras))),
        "lens": list(range(len(parts.lenses))),
        "port": list(range(len(parts.ports))),
        "landscape": landscapes(problem),
        "light": list(range(len(parts.lights))),
        "count": list(range(low, high + 1)),
        "mount": list(problem.mounts),
    }
