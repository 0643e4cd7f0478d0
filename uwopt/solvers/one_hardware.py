"""One hardware of a search, or a few variants of it, solved again: other places, scenes, limits or estimates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.catalog.records import Part, Port
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.designs import Hardware
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.node_designs import NodeDesigns
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search

KINDS = ("camera", "lens", "port", "light")


def parts_of(problem: Problem, found: Found | Hardware) -> list[tuple[str, Part]]:
    """The four parts of a design by kind."""
    parts = problem.parts
    return [
        ("camera", parts.cameras[found.camera]),
        ("lens", parts.lenses[found.lens]),
        ("port", parts.ports[found.port]),
        ("light", parts.lights[found.light]),
    ]


def pieces_of(problem: Problem, found: Found) -> list[tuple[str, Part]]:
    """All pieces of a design by kind: its parts, and the housing that its port is built into."""
    before = problem.parts.ports[found.port]
    housing = None if before.complete else before.housing
    camera, lens, port, light = parts_of(problem, found)
    return [camera, lens, port, *([] if housing is None else [("housing", housing)]), light]


def problem_of(
    base: Problem, found: Found | Hardware, *, mission: Mission | None = None, scenes: list[SceneOptics] | None = None,
    lists: Mapping[str, Sequence[Any]] | None = None,
) -> Problem:  # fmt: skip
    """A problem over one design's parts, count and mount, or over variants of them.

    mission : another one brings its own scenes; scenes : in their place; lists : variants of a kind of part
    """
    every: dict[str, Sequence[Any]] = {kind: [part] for kind, part in parts_of(base, found)} | dict(lists or {})
    mount = found.mount if isinstance(found, Hardware) else found.lighting.mount
    return base.over(
        Parts(*(tuple(every[kind]) for kind in KINDS)), mission=mission, scenes=scenes,
        counts=(found.count, found.count), mounts=[mount],
    )  # fmt: skip


def best_of(
    problem: Problem, objective: Objective, deadline: Deadline = NEVER, imagers: Imagers | None = None
) -> float:
    """Best objective of a problem over one part of each kind; inf where it is not feasible."""
    return best_of_each(problem, objective, [dict.fromkeys(KINDS, 0)], deadline, imagers)[0]


def best_of_each(
    problem: Problem, objective: Objective, places: Sequence[dict[str, int]], deadline: Deadline = NEVER,
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
    return [own_id(p) for _, p in parts_of(one, a)] == [own_id(p) for _, p in parts_of(other, b)]


def among(problem: Problem, found: Found, mixed: Problem) -> Found:
    """A design of the mixed problem, which may hold a part twice, by the places of its parts in another.

    Raises ValueError where a part is not there.
    """
    own_parts = problem.parts
    lists = dict(zip(KINDS, (own_parts.cameras, own_parts.lenses, own_parts.ports, own_parts.lights), strict=True))
    places: dict[str, Any] = {
        kind: [own_id(own) for own in lists[kind]].index(own_id(part))
        for kind, part in parts_of(mixed, found)
    }
    return replace(found, **places)
