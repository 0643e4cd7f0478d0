"""One hardware of a search, or a few variants of it, solved again: other places, scenes, limits or estimates.

Parts whose doubtful numbers stand at an end of their ranges, and which of these can matter at all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.catalog.parts.doubts import doubtful, taken_as, with_numbers
from uwopt.catalog.parts.kinds import EITHER, FAVOURED
from uwopt.catalog.records import OF_A_DESIGN, Part, Port, Quantity, exact
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.designs import Hardware
from uwopt.forward.parts import Parts
from uwopt.forward.problem import MeantFocus, Problem
from uwopt.forward.scene import SceneOptics
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.imager_rules import Behind
from uwopt.solvers.exact.imagers import Imagers, imagers_in
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.node_designs import NodeDesigns
from uwopt.solvers.exact.ranking import Found, ids_in
from uwopt.solvers.exact.search import Search


def pieces_by_kind(problem: Problem, found: Found) -> dict[str, Part]:
    """All pieces of a design by kind: its parts, and before its light the housing that its port is built into."""
    parts = problem.parts.of(found)
    port, light = parts["port"], parts.pop("light")
    housing = {} if port.complete or port.housing is None else {"housing": port.housing}
    return {**parts, **housing, "light": light}


def ids_of_pieces(problem: Problem, found: Found) -> list[str]:
    """Ids of all pieces of a design."""
    return [part.id for part in pieces_by_kind(problem, found).values()]


def problem_of(
    base: Problem, found: Found | Hardware, *, mission: Mission | None = None, scenes: list[SceneOptics] | None = None,
    lists: Mapping[str, Sequence[Any]] | None = None,
) -> Problem:  # fmt: skip
    """A problem over one design's parts, count and mount, or over variants of them.

    mission : another one brings its own scenes; scenes : in their place; lists : variants of a kind of part
    """
    every: dict[str, Sequence[Any]] = {kind: [part] for kind, part in base.parts.of(found).items()} | dict(lists or {})
    mount = found.mount if isinstance(found, Hardware) else found.lighting.mount
    return base.over(
        Parts.of_each(lambda kind: every[kind]), mission=mission, scenes=scenes,
        counts=(found.count, found.count), mounts=[mount],
    )  # fmt: skip


def as_set(
    base: Problem, found: Found, f_number: float | None, meant_m: MeantFocus | float | None
) -> tuple[Problem, Imagers]:
    """A design's parts, their iris and focus where these are set, and their imager, or none where rules discard it.

    f_number : None: it is free; meant_m : as `Problem.focused_on` takes it
    """
    problem = problem_of(base, found).focused_on(meant_m)
    if f_number is not None:
        problem = problem.at_f_number(f_number)
    return problem, only_imager(problem, found.landscape)


def only_imager(problem: Problem, landscape: bool) -> Imagers:
    """The imager of a problem of one part of each kind in one orientation, or none."""
    only = np.array([0])
    return imagers_in(problem, [Behind(only, only, only, landscape)])


def best_of(
    problem: Problem, objective: Objective, deadline: Deadline = NEVER, imagers: Imagers | None = None
) -> float:
    """Best objective of a problem over one part of each kind; inf where it is not feasible."""
    return best_of_each(problem, objective, [dict.fromkeys(OF_A_DESIGN, 0)], deadline, imagers)[0]


def best_of_each(
    problem: Problem, objective: Objective, places: Sequence[Mapping[Any, int]], deadline: Deadline = NEVER,
    imagers: Imagers | None = None,
) -> list[float]:  # fmt: skip
    """Best objective of each choice of parts over all orientations; those in light of the same optics together.

    places : of each choice, the index of its part in the problem's list of each kind
    imagers : the problem's, where another with the same cameras in the same scenes has them
    """
    search = Search(problem, objective, top=1, deadline=deadline, imagers=imagers)
    imagers, optics_of = search.prepare(), problem.lights.optics_index
    rows_of = [
        np.nonzero(
            (imagers.camera == place["camera"])
            & (imagers.lens == place["lens"])
            & (imagers.port == place["port"])
        )[0]
        for place in places
    ]
    best = np.full(len(places), np.inf)
    for optics in {int(optics_of[place["light"]]) for place in places}:
        mine = [n for n, place in enumerate(places) if optics_of[place["light"]] == optics and len(rows_of[n])]
        if mine:
            rows = np.concatenate([rows_of[n] for n in mine])
            owner = np.repeat(mine, [len(rows_of[n]) for n in mine])
            light = np.array([place["light"] for place in places])[owner]
            np.minimum.at(best, owner, values_under(search, imagers, rows, light, optics))
    return [float(value) for value in best]


def values_under(search: Search, imagers: Any, rows: Any, light: Any, optics: int) -> Any:
    """Objective of these imagers, each under a light of the same optics; inf where a limit is missed."""
    problem = search.problem
    lighting = next(item for item in search.tables.lightings if item.optics == optics)
    unique, back = np.unique(rows, return_inverse=True)
    under, count = Under.one(lighting, len(unique)), np.full(len(rows), problem.count_range[0])
    pairs = NodeDesigns.of(problem, imagers, unique, under, back, light, count)
    lights = search.tables.in_scenes(under, unique)
    value = search.solve(pairs, [seen.take(back) for seen in lights])[0]
    return np.where(pairs.within(search.limits), value, np.inf)


def own_id(part: Part) -> str:
    """The id of a part; of a port with that of its housing."""
    return part.enclosure_id if isinstance(part, Port) else part.id


def same_parts(one: Problem, a: Found, other: Problem, b: Found) -> bool:
    """Whether two designs are made of the same parts."""
    return ids_in(one.parts, a) == ids_in(other.parts, b)


def among(problem: Problem, found: Found, mixed: Problem) -> Found:
    """A design of the mixed problem, which may hold a part twice, by the places of its parts in another.

    Raises ValueError where a part is not there.
    """
    lists = problem.parts.by_kind
    places: dict[str, Any] = {
        kind: [own_id(own) for own in lists[kind]].index(own_id(part)) for kind, part in mixed.parts.of(found).items()
    }
    return replace(found, **places)


# ---------------------------------------------------------------- parts at an end of what is estimated


def at_end(part: Any, end: str, only: str | None = None) -> Any:
    """A part with its doubtful numbers (or one of them) put at one end of their ranges.

    `good` and `bad` move what has such ends; `low` and `high` what may favour a design at either.
    """

    def value_at(name: str, known: Quantity) -> Quantity | None:
        if only is not None and name != only:
            return None
        if end in ("low", "high"):
            value = known.low if end == "low" else known.high
            return exact(value, known.status, known.source) if name in EITHER else None
        best, worst = (known.high, known.low) if FAVOURED.get(name, 0) > 0 else (known.low, known.high)
        return taken_as(name, known, best if end == "good" else worst) if FAVOURED.get(name, 0) else None

    return with_numbers(part, value_at, housing=only is None)


def with_either_end(part: Any) -> list[Any]:
    """A part as it is, and at both ends of what may favour a design at either."""
    if any(name in EITHER for name, _ in doubtful(part)):
        return [part, at_end(part, "low"), at_end(part, "high")]
    return [part]


def housing_at_end(port: Port, end: str, only: str | None = None) -> Port:
    """A port whose housing's doubtful numbers (or one of them) are put at one end of their ranges."""
    return replace(port, housing=at_end(port.housing, end, only))


def matters(name: str, problem: Problem, objective: Objective) -> bool:
    """Whether a field can enter the objective or a limit at all."""
    limits = problem.mission.limits
    if name == "price":
        return bool(objective.weight("cost")) or limits.cost is not None
    if name == "mass_g":
        return bool(objective.weight("mass")) or limits.mass_kg is not None
    return bool(FAVOURED.get(name)) or name in EITHER
