"""What of good practice `solve` still gives up where a change is made that lets something fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from uwopt.api.practice_known import PracticeKnown
from uwopt.api.yielding import gives_way
from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import Deadline
from uwopt.errors import UwoptError
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.varying import VariedMission
from uwopt.mission.weakened import with_central_prices, with_limit, without
from uwopt.results.basis import Moved, Relaxed, WhyNothing
from uwopt.results.design import Design
from uwopt.solvers.warm.parts import PartIds

Told = TypeVar("Told", Relaxed, Moved)


def with_practice_left(
    why: WhyNothing, asked: Mission, catalog: Catalog, like: Problem, deadline: Deadline
) -> WhyNothing:
    """Each told change with what is given up then too, as many as there is time for, the smallest first.

    asked : the mission with all of good practice, which nothing meets with as little of it as may be
    """
    known = PracticeKnown(hardware=[] if why.nearest_miss is None else [ids_of_design(why.nearest_miss)])

    def told(changes: Sequence[Told]) -> list[Told]:
        return [replace(one, gives_up=given_up(one, asked, catalog, like, deadline, known)) for one in changes]

    try:
        why = replace(why, relaxations=told(why.relaxations))
        return replace(why, moves=told(why.moves))
    except KeyboardInterrupt:  # what is known is not lost
        return why


def given_up(
    one: Relaxed | Moved, asked: Mission, catalog: Catalog, like: Problem, deadline: Deadline, known: PracticeKnown
) -> list[str] | None:
    """What gives way after a change, each with what is held instead; None where that is not known in time."""
    if deadline.passed():
        return None
    try:
        made = gives_way(changed(asked, one), catalog, like, deadline, known)
    except UwoptError:
        return None
    return [each.as_held for each in made.yields] if made.yields and made.is_least else None


def changed(mission: Mission, one: Relaxed | Moved) -> Mission:
    """The mission with a told change; raises UwoptError where that cannot be written into it."""
    if isinstance(one, Moved):
        base = VariedMission(mission, {})
        return base.with_values({base.named(one.name): one.needed})
    if one.fits_at_central_prices:
        return with_central_prices(mission)
    if one.needed is None:
        return without(mission, one.name) or mission
    return with_limit(mission, one.name, one.needed if one.limit is None else one.limit, one.needed)


def ids_of_design(design: Design) -> PartIds:
    """Ids of a design's parts by kind."""
    return {kind: frozenset({part.id}) for kind, part in design.hardware.named.items()}  # pyrefly: ignore[bad-return]
