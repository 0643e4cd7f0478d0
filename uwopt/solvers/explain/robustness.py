"""Whether the recommendation would change if what is estimated were known.

The regret puts the winner's parts at the bad end of their ranges and all rivals' at the good end, and searches once
more. A quote matters when that one number, at its bad end, would let another design win. Of a number that favours one
design at its high end and another at its low one (the radius of a dome: a large one is easier to focus through, a small
one brings the camera nearer) both ends are tried: the winner has the worse one, a rival any of them.

Of systems that estimates cannot tell apart from the recommendation it is a toss which is better. A runner-up is one of
them where each lies within the other's range: the runner-up is no worse than the recommendation may turn out by what is
estimated of the parts that differ, and may itself turn out no worse than the recommendation. What both are made of
moves both alike, and stays as it is. Where the recommendation was chosen over scenarios, these tell instead: those are
equal that were counted, hold as often as is asked, and whose median is as good but for luck.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from uwopt.catalog.parts.doubts import doubtful
from uwopt.catalog.parts.kinds import EITHER
from uwopt.catalog.records import OF_A_DESIGN, Part, Quantity
from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.assumptions import field_unit
from uwopt.solvers.one_hardware import (
    among,
    at_end,
    best_of,
    best_of_each,
    housing_at_end,
    ids_of_pieces,
    matters,
    own_id,
    pieces_by_kind,
    problem_of,
    same_parts,
    with_either_end,
)
from uwopt.solvers.recommend import Sought
from uwopt.solvers.settings.best import scenes_need_cells
from uwopt.tolerances import TIE

SLOW_S = 2.5  # for a rival, where settings have no closed form
MOST_QUOTES = 12  # that are told
TURN = 0.5  # of the time left: what the search for a rival may take of it


def at_worst(
    problem: Problem, found: Found, objective: Objective, deadline: Deadline
) -> tuple[dict[str, Part], float]:
    """A design's parts at the bad ends, and its best objective with them; inf where infeasible then."""
    bad = {kind: at_end(part, "bad") for kind, part in problem.parts.of(found).items()}
    worst, worst_value = bad, -math.inf
    for port in with_either_end(bad["port"]):
        lists = {kind: [part] for kind, part in (bad | {"port": port}).items()}
        value = best_of(problem_of(problem, found, lists=lists), objective, deadline)
        if value > worst_value:
            worst, worst_value = bad | {"port": port}, value
    return worst, worst_value


Variant = tuple[str, str, str]  # kind, field ("" for all), end


def values_with(
    sought: Sought, found: Found, variants: Sequence[Variant | None],
    deadline: Deadline,
) -> list[float]:  # fmt: skip
    """Best objective of one hardware with one number, or all, of one part changed; inf where infeasible.

    None stands for the hardware as it is. All variants are parts of one small catalogue, so that one
    pass evaluates them.
    """
    base = sought.problem
    lists: dict[str, list[Any]] = {kind: [part] for kind, part in base.parts.of(found).items()}
    places = []
    for variant in variants:
        place: dict[str, int] = dict.fromkeys(OF_A_DESIGN, 0)
        if variant is not None:
            kind, name, end = variant
            slot = "port" if kind == "housing" else kind
            made = housing_at_end if kind == "housing" else at_end
            place[slot] = len(lists[slot])
            lists[slot].append(made(lists[slot][0], end, only=name or None))
        places.append(place)
    return best_of_each(problem_of(base, found, lists=lists), sought.goal, places, deadline)


def robustness(sought: Sought, deadline: Deadline = NEVER) -> dict[str, Any] | None:
    """Regret, rival, and the quotes that could change the answer.

    The search for a rival ends after half of the time left, or after a while where settings have no closed form
    (`complete` says so); then single quotes are not tried.
    """
    objective = sought.goal
    if not sought.outcome.best:
        return None
    winner = sought.outcome.best[0]
    problem = sought.problem
    bad, bad_value = at_worst(problem, winner, objective, deadline)
    mixed = mixed_problem(problem, bad)
    slow = scenes_need_cells(problem.scenes, objective)
    patience = deadline.at_most(SLOW_S) if slow else deadline.part(TURN)
    outcome = Search(mixed, objective, top=2, deadline=patience, ceiling=bad_value).whole()  # no better: no rival
    deadline.check()  # a rival of half a search is none
    rival = next((f for f in outcome.best if not same_parts(mixed, f, problem, winner)), None)
    best = min([f.minimised for f in outcome.best] + [bad_value])
    regret = max(0.0, bad_value - best) if math.isfinite(bad_value) else None
    return {
        "max_regret": None if regret is None else objective.amount(regret, bad_value),
        "regret_rel": None if regret is None else objective.share(regret, winner.minimised),
        "value_at_bad_end": objective.told(bad_value),
        "feasible_at_bad_end": math.isfinite(bad_value),
        "complete": outcome.complete and not slow,
        "rival": None
        if rival is None or rival.minimised >= bad_value
        else rival_dict(mixed, rival, objective),
        "quotes_that_matter": []
        if slow
        else deadline.within(
            "which quotes matter",
            lambda: quotes_that_matter(
                sought, outcome_rivals(sought, outcome.best, mixed), deadline
            ),
            list[dict[str, Any]](),
        ),
    }


def mixed_problem(problem: Problem, bad: dict[str, Part]) -> Problem:
    """The winner's parts at their bad end among all others at their good end."""

    def mixed(kind: str) -> list[Any]:
        return [
            variant
            for part in problem.parts.by_kind[kind]
            for variant in (
                [bad[kind]] if own_id(part) == own_id(bad[kind]) else with_either_end(at_end(part, "good"))
            )
        ]

    return problem.over(Parts.of_each(mixed))


def rival_dict(problem: Problem, rival: Found, objective: Objective) -> dict[str, Any]:
    """A rival by its ids, with what it would reach."""
    return {
        **{kind: part.id for kind, part in pieces_by_kind(problem, rival).items()},
        "light_count": problem.lamps_carried(rival),
        "objective_value": objective.reported(rival.minimised),
    }


def outcome_rivals(sought: Sought, good: Sequence[Found], mixed: Problem) -> list[Found]:
    """Designs that could take the winner's place: its runner-up, and the rival of the regret search."""
    winner = sought.outcome.best[0]
    rivals = list(sought.outcome.best[1:2])
    for other in good:
        found = among(sought.problem, other, mixed)
        if not any(same_parts(sought.problem, found, sought.problem, known) for known in (winner, *rivals)):
            rivals.append(found)
    return rivals[:2]


def quotes_that_matter(
    sought: Sought, rivals: Sequence[Found], deadline: Deadline
) -> list[dict[str, Any]]:
    """Single numbers whose bad end for the winner, or good end for a rival, would change the answer."""
    problem = sought.problem
    winner = sought.outcome.best[0]
    matter: list[dict[str, Any]] = []
    for rival in rivals:
        asked = [
            (kind, part, name, doubt, end)
            for design, end in ((winner, "bad"), (rival, "good"))
            for kind, part in pieces_by_kind(problem, design).items()
            for name, doubt in doubtful(part)
            if matters(name, problem, sought.goal)
            for end in (("low", "high") if name in EITHER else (end,))
        ]
        ours = with_changes(sought, winner, asked, deadline)
        theirs = with_changes(sought, rival, asked, deadline)
        for (kind, part, name, doubt, _), mine, other in zip(asked, ours, theirs, strict=True):
            known = any(q["part"] == part.id and q["field"] == name for q in matter)
            if not known and other < mine and other < mine - 1e-9 * abs(other):
                matter.append(
                    {
                        "part": part.id, "kind": kind, "field": name, "value": doubt.value, "low": doubt.low,
                        "high": doubt.high, "unit": field_unit(name, part),
                        "then_better": " + ".join(ids_of_pieces(problem, rival)),
                    }
                )  # fmt: skip
    return matter[:MOST_QUOTES]


def with_changes(
    sought: Sought, design: Found, asked: Sequence[tuple[str, Part, str, Quantity, str]],
    deadline: Deadline = NEVER,
) -> list[float]:  # fmt: skip
    """A design's objective under each change in turn; changes of parts it does not have leave it as it is."""
    own = {kind: part.id for kind, part in pieces_by_kind(sought.problem, design).items()}
    variants: list[Variant | None] = [
        (kind, name, end) if own.get(kind) == part.id else None for kind, part, name, _, end in asked
    ]
    return values_with(sought, design, variants, deadline)


# ---------------------------------------------------------------- what cannot be told from the first


LONGEST_S = 1.5  # for all of them: those that are not reached by then are left out
UNREACHED = "whether some of the runners-up are equal within the estimates"


def equals(
    sought: Sought, deadline: Deadline = NEVER,
    tied: Callable[[Found], bool] | None = None,
) -> list[dict[str, Any]]:
    """Runners-up that cannot be told from the first, by their place in the result, with their ranges.

    tied : tells of hardware whether the scenarios cannot, where the first was chosen over these
    """
    objective = sought.goal
    winner, *others = sought.outcome.best
    if tied is not None:
        return [
            {"runner_up": place, **dict.fromkeys(("value", "best", "recommendation_at_worst"))}
            for place, other in enumerate(others)
            if tied(other)
        ]
    patience, found = deadline.at_most(LONGEST_S), list[dict[str, Any]]()
    try:
        for place, other in enumerate(others):
            ends = ends_if_equal(sought.problem, winner, other, objective, patience)
            if ends is not None:
                found.append({"runner_up": place, **{name: objective.told(end) for name, end in ends.items()}})
    except OutOfTimeError:
        deadline.left_out.append(UNREACHED)
    return found


def ends_if_equal(
    problem: Problem, winner: Found, other: Found, objective: Objective, patience: Deadline
) -> dict[str, float] | None:
    """A runner-up's value and best end, and the worst of the first, where they cannot be told apart."""
    own, slow = problem.parts.of(winner), scenes_need_cells(problem.scenes, objective)
    differing = [kind for kind, part in problem.parts.of(other).items() if own_id(part) != own_id(own[kind])]
    tied = other.minimised - winner.minimised <= TIE * abs(winner.minimised)
    if not differing or (slow and not tied):
        return None
    patience.check()
    worst = winner.minimised if slow else with_ends(problem, winner, other, differing, "bad", objective, patience)
    best = other.minimised if slow else with_ends(problem, other, winner, differing, "good", objective, patience)
    if tied or (other.minimised <= worst and best <= winner.minimised):
        return {"value": other.minimised, "best": best, "recommendation_at_worst": worst}
    return None


def with_ends(
    problem: Problem, own: Found, other: Found, differing: list[str], end: str, objective: Objective, deadline: Deadline
) -> float:  # fmt: skip
    """Best objective of a design whose parts of these kinds are at one end of their estimates; inf: infeasible."""
    parts, against = problem.parts.of(own), problem.parts.of(other)
    lists: dict[str, list[Any]] = {}
    for kind in differing:
        part: Any = parts[kind]
        alike = kind == "port" and part.id == against[kind].id  # another housing alone
        lists[kind] = [housing_at_end(part, end) if alike else at_end(part, end)]
    return best_of(problem_of(problem, own, lists=lists), objective, deadline)
