"""The searches of one mission: parts that are sold, parts to be made where they could matter, gain without its cap."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from uwopt.api.watch import Watch
from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.records import Kind, Part
from uwopt.deadline import Deadline, unheard
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.yielding import Yield
from uwopt.model.fineness import DEFAULT, Fineness
from uwopt.objectives.objective import Objective
from uwopt.solvers.beside import ahead
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.explain.robustness import SLOW_S
from uwopt.solvers.infeasible.relaxer import ANY
from uwopt.solvers.recommend import GENERIC_GAIN, TO_BE_MADE, Sought, fewest_made, seek
from uwopt.solvers.settings.best import scenes_need_cells

MOST_IN_VAIN = 200_000  # designs below a cap of gain that yields, of which none fits: then it is asked if any does
SETTINGS_SHARE = 0.1  # of the time that is given, which a search leaves for settings that can be set


@dataclass(frozen=True)
class Searched:
    """What was found for a mission."""

    mission: Mission  # with what of good practice has given way
    sought: Sought  # over parts that are sold; over all of them where only these do
    alternative: Sought | None = None  # with parts to be made, where nothing that is sold fits
    given_way: tuple[Yield, ...] = ()
    in_vain: Sought | None = None  # with as little of good practice as may be: the proof that even so nothing fits
    is_in_vain: bool = False  # whether that is proven, by this or by missions before
    cut: bool = False  # whether a person wants no more

    @property
    def fits(self) -> bool:
        """Whether something was found."""
        return bool(self.sought.outcome.best)

    @property
    def widest(self) -> Sought:
        """Over the most parts that were searched."""
        return self.alternative or self.sought

    @property
    def proves_nothing_fits(self) -> bool:
        """Whether nothing was found of all that there is."""
        return not self.fits and self.widest.outcome.complete


@dataclass(frozen=True)
class Searches:
    """What the searches for one answer share; `top`: how many designs are listed."""

    catalog: Catalog
    goal: Objective
    top: int = 1
    watch: Watch = field(default_factory=Watch)
    fineness: Fineness = DEFAULT

    def seek(
        self, mission: Mission, *, goal: Objective | None = None, top: int = 0, deadline: Deadline | None = None,
        **how: Any,
    ) -> Sought:  # fmt: skip
        """One search, as `recommend.seek`."""
        return seek(
            mission, self.catalog, goal or self.goal, top=top or self.top, deadline=deadline or self.watch.deadline,
            progress=self.watch.progress, fineness=self.fineness, **how,
        )  # fmt: skip

    @property
    def quietly(self) -> Searches:
        """The same, of which nobody is told how far they are."""
        return replace(self, watch=replace(self.watch, progress=unheard))

    def of(
        self, mission: Mission, like: Sought | None = None, scenes_of: Problem | None = None, *, fits: bool = False
    ) -> Searched:
        """The search over parts that are sold, and with parts to be made where nothing that is sold fits.

        Where nothing that is sold fits and the gain has a cap that yields, all parts without it are asked first for any
        design that fits: where none does, nothing fits with the cap either. A search below the cap that goes long in
        vain is left for that question, and goes on where the answer is that something fits. `like` is a search of the
        same parts in the same scenes that differs in the cap of gain alone, `scenes_of` a problem whose scenes may be
        the same, `fits`: of all parts something is known to, without the cap at least.
        """
        policy, capless = mission.catalog.generic, mission.without_gain_cap
        first = mission.catalog.generic_at_first
        with self.watch.timed("search"):
            in_vain = math.inf if capless is mission or policy == "fallback" else MOST_IN_VAIN
            known = known_from(like) or {"like": scenes_of}
            sought = self.seek(mission, generic=first, most_in_vain=in_vain, **known)
            if sought.search.is_in_vain:
                some = self.seek(capless, generic=first, enough=True, **known_from(sought))
                if not some.outcome.best:
                    return Searched(mission, some)
                sought = self.seek(mission, generic=first, **known_from(sought))
        alternative: Sought | None = None
        if policy == "fallback" and sought.outcome.complete and not sought.outcome.best:
            with self.watch.timed("search_generic"):
                if capless is not mission and not fits:
                    any_of_all = self.seek(capless, goal=ANY, generic="allow", like=sought.problem, enough=True)
                    if any_of_all.outcome.interrupted:
                        return Searched(mission, sought, any_of_all, cut=True)
                    if any_of_all.outcome.complete and not any_of_all.outcome.best:
                        sought = self.seek(capless, generic=first, **known_from(sought))
                        return Searched(mission, sought, any_of_all, cut=sought.outcome.interrupted)
                alternative = self.seek(mission, generic="allow", like=sought.problem)
                if alternative.outcome.best:
                    sought, alternative = of_fewest_kinds(alternative, self), None
        ended = alternative is not None and alternative.outcome.interrupted
        if not (sought.outcome.best or ended) and sought.outcome.complete and capless is not mission:  # out of reach
            return replace(self.of(capless, sought), mission=mission)
        return Searched(mission, sought, alternative)


def known_from(like: Sought | None) -> dict[str, Any]:
    """What a search takes from another of the same parts and scenes: their light and, of a small catalogue, imagers."""
    if like is None:
        return {}
    return {"like": like.problem, "imagers": like.search.every_imager}


def of_fewest_kinds(every: Sought, searches: Searches) -> Sought:
    """The search with parts to be made of as few kinds as come within 10 % of the best of all kinds; that if it is cut.

    Mostly none of fewer do: while it is asked whether any of the first do, another core asks it of the others.

    every : the search with parts to be made of all kinds
    """
    mission, like, best = every.problem.mission, every.problem, every.outcome.best[0].minimised
    if not every.outcome.complete or every.outcome.interrupted:
        return every
    ceiling = best + every.goal.step(GENERIC_GAIN, best)
    serve, known = [kinds_made(every)], dict[tuple[Kind, ...], set[Kind] | None]()

    def made_of(kinds: tuple[Kind, ...], seek: Callable[..., Sought]) -> set[Kind] | None:
        """The kinds of which the best has parts to be made, if none others are; None where that is not near enough."""
        found = seek(mission, generic=kinds, like=like, ceiling=ceiling, enough=True, whole=True)
        return kinds_made(found) if found.outcome.best else None

    def is_served(kinds: tuple[Kind, ...]) -> bool:
        return any(made <= set(kinds) for made in serve)

    def serves(kinds: tuple[Kind, ...]) -> bool:
        if not is_served(kinds):
            made = known[kinds] if kinds in known else made_of(kinds, searches.seek)
            serve.extend([] if made is None else [made])
        return is_served(kinds)

    asked = list[tuple[Kind, ...]]()  # in turn, as long as none of them serve
    fewest_made(lambda kinds: is_served(kinds) or asked.append(kinds) is not None)

    def others() -> dict[tuple[Kind, ...], set[Kind] | None]:
        """What is known of these after the first, up to those that serve."""
        made, quiet = dict[tuple[Kind, ...], set[Kind] | None](), searches.quietly.seek
        for kinds in asked[1:]:
            made[kinds] = made_of(kinds, quiet)
            if made[kinds] is not None:
                break
        return made

    try:
        if len(asked) > 1:
            with ahead(others, lists=[searches.watch.deadline.left_out]) as further:
                known[asked[0]] = made_of(asked[0], searches.seek)
                known.update(further() if known[asked[0]] is None else {})
        kinds = fewest_made(serves)
    except KeyboardInterrupt:
        return replace(every, outcome=replace(every.outcome, interrupted=True))
    if set(kinds) == set(TO_BE_MADE):
        return every
    found = searches.seek(mission, generic=kinds, like=like)
    ended = replace(every, outcome=replace(every.outcome, interrupted=found.outcome.interrupted))
    return replace(found, of_all_kinds=every) if found.outcome.best else ended


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


def of_all_parts(sought: Sought, watch: Watch, *, top: int = 0, **how: Any) -> Sought:
    """The same search with parts to be made, of all kinds."""
    if sought.of_all_kinds is not None and not top:
        return sought.of_all_kinds
    problem = sought.problem
    searches = Searches(sought.selection.catalog, sought.goal, top or sought.search.top, watch, problem.fineness)
    return searches.seek(problem.mission, generic="allow", like=problem, **how)


def much_better_if_made(sought: Sought, proven: Outcome, deadline: Deadline) -> Sought:
    """The search for what is better by 10 % with parts to be made than all that is sold.

    proven : what the search of these found
    """
    best, goal = proven.best[0].minimised, sought.goal
    if scenes_need_cells(sought.problem.scenes, goal):  # no closed form is slow
        deadline = deadline.at_most(SLOW_S)
    return of_all_parts(sought, Watch(deadline), top=1, ceiling=best - goal.step(GENERIC_GAIN, best))
