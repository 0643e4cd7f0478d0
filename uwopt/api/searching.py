"""The searches of one mission: parts that are sold, parts to be made where they could matter, gain without its cap."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from uwopt.api.accuracy import Searched
from uwopt.api.common import Progress
from uwopt.api.timing import timed
from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.records import Kind, Part
from uwopt.deadline import Deadline
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.model.fineness import Fineness
from uwopt.objectives.objective import Objective
from uwopt.solvers.explain.robustness import SLOW_S
from uwopt.solvers.made import TO_BE_MADE, fewest_made
from uwopt.solvers.recommend import GENERIC_GAIN, Sought, seek
from uwopt.solvers.settings.best import scenes_need_cells

MOST_IN_VAIN = 200_000  # designs below a cap of gain that yields, of which none fits: then it is asked if any does


def searched(
    mission: Mission, catalog: Catalog, goal: Objective, top: int, deadline: Deadline,
    progress: Progress | None, timing: dict[str, float], fineness: Fineness, like: Sought | None = None,
    scenes_of: Problem | None = None,
) -> Searched:  # fmt: skip
    """The search over parts that are sold, and with parts to be made where they could matter.

    Where nothing that is sold fits and the gain has a cap that yields, all parts without it are asked first for any
    design that fits: where none does, nothing fits with the cap either. A search below the cap that goes long in vain
    is left for that question, and goes on where the answer is that something fits. `like` is a search of the same parts
    in the same scenes that differs in the cap of gain alone, `scenes_of` a problem whose scenes may be the same.
    """
    policy, capless = mission.catalog.generic, mission.without_gain_cap
    first = mission.catalog.generic_at_first
    look = partial(
        seek, catalog=catalog, objective=goal, top=top, deadline=deadline, progress=progress, fineness=fineness
    )
    with timed(timing, "search"):
        in_vain = math.inf if capless is mission or policy == "fallback" else MOST_IN_VAIN
        sought = look(mission, generic=first, most_in_vain=in_vain, **(known_from(like) or {"like": scenes_of}))
        if sought.search.is_in_vain:
            some = look(capless, generic=first, enough=True, **known_from(sought))
            if not some.outcome.best:
                return some, None
            sought = look(mission, generic=first, **known_from(sought))
    alternative: Sought | None = None
    if policy == "fallback" and sought.outcome.complete:
        with timed(timing, "search_generic"):
            if sought.outcome.best:
                alternative = generic_search(mission, catalog, goal, sought, deadline, progress)
            else:
                if capless is not mission:
                    any_of_all = look(capless, generic="allow", like=sought.problem, enough=True)
                    if any_of_all.outcome.complete and not any_of_all.outcome.best:
                        return look(capless, generic=first, **known_from(sought)), any_of_all
                alternative = look(mission, generic="allow", like=sought.problem)
                if alternative.outcome.best:
                    sought, alternative = of_fewest_kinds(alternative, goal, look), None
    if not sought.outcome.best and sought.outcome.complete and capless is not mission:  # light is out of reach
        return searched(capless, catalog, goal, top, deadline, progress, timing, fineness, sought)
    return sought, alternative


def known_from(like: Sought | None) -> dict[str, Any]:
    """What a search takes from another of the same parts and scenes: their light and, of a small catalogue, imagers."""
    if like is None:
        return {}
    return {"like": like.problem, "imagers": like.search.every_imager}


def of_fewest_kinds(every: Sought, goal: Objective, look: Callable[..., Sought]) -> Sought:
    """The search with parts to be made of as few kinds as come within 10 % of the best of all kinds; that if it is cut.

    every : the search with parts to be made of all kinds
    """
    mission, like, best = every.problem.mission, every.problem, every.outcome.best[0].minimised
    if not every.outcome.complete or every.outcome.interrupted:
        return every
    ceiling = best + goal.step(GENERIC_GAIN, best)
    serve = [kinds_made(every)]

    def serves(kinds: tuple[Kind, ...]) -> bool:
        if not any(made <= set(kinds) for made in serve):
            found = look(mission, generic=kinds, like=like, ceiling=ceiling, enough=True, whole=True)
            serve.extend([kinds_made(found)] if found.outcome.best else [])
        return any(made <= set(kinds) for made in serve)

    try:
        kinds = fewest_made(serves)
    except KeyboardInterrupt:
        return replace(every, outcome=replace(every.outcome, interrupted=True))
    if set(kinds) == set(TO_BE_MADE):
        return every
    found = look(mission, generic=kinds, like=like)
    return found if found.outcome.best else every


def kinds_made(sought: Sought) -> set[Kind]:
    """The kinds of which the best design has parts to be made."""
    best, parts = sought.outcome.best[0], sought.problem.parts
    port = parts.ports[best.port]
    used: dict[Kind, Part | None] = {"light": parts.lights[best.light], "port": port, "housing": port.housing}
    return {kind for kind, part in used.items() if part is not None and part.generic}


def leaves_out_generic(sought: Sought) -> bool:
    """Whether parts to be made, which the mission takes where those that are sold do not do, were left out."""
    fallback = sought.problem.mission.catalog.generic == "fallback"
    return fallback and any(rules.get("generic") for rules in sought.selection.counts.values())


def of_all_parts(sought: Sought, goal: Objective, deadline: Deadline, progress: Progress | None) -> Sought:
    """The same search with parts to be made."""
    problem = sought.problem
    return seek(
        problem.mission, sought.selection.catalog, goal, generic="allow", top=sought.search.top, deadline=deadline,
        progress=progress, fineness=problem.fineness, like=problem, whole=True,
    )  # fmt: skip


def generic_search(
    mission: Mission, catalog: Catalog, goal: Objective, sought: Sought, deadline: Deadline, progress: Progress | None
) -> Sought:
    """More parts to be made come second: searched for a gain of 10 %."""
    best = sought.outcome.best[0].minimised
    if scenes_need_cells(sought.problem.scenes, goal):  # no closed form is slow
        deadline = deadline.at_most(SLOW_S)
    return seek(
        mission, catalog, goal, generic="allow", top=1, deadline=deadline, progress=progress,
        ceiling=best - goal.step(GENERIC_GAIN, best), fineness=sought.problem.fineness, like=sought.problem,
    )  # fmt: skip
