"""Which kits serve a mission: hardware as it was bought for another, with every setting chosen anew."""

from __future__ import annotations

from collections.abc import Sequence

from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.objectives.goal import goal_of
from uwopt.results.sweep import SweepKit
from uwopt.solvers.exact.search import Search
from uwopt.solvers.warm.parts import PartIds, only

YES, NO = "1", "0"


def ids_of_kit(kit: SweepKit) -> PartIds:
    """Ids of a kit's parts by kind as the catalogue has them, complete cameras whole."""
    light = frozenset({kit.light})
    if kit.complete:
        return {"complete": frozenset({kit.complete}), "light": light}
    housing = frozenset({kit.housing} if kit.housing else ())
    of_kit = {kind: frozenset({getattr(kit, kind)}) for kind in ("camera", "lens", "port")}
    return {**of_kit, "housing": housing, "light": light}  # pyrefly: ignore[bad-return]


def served_by(mission: Mission, kits: Sequence[SweepKit]) -> str:
    """A sign a kit: whether the mission allows it and some settings of it meet every requirement."""
    selection = selected(mission, load_catalog(mission), generic="allow")
    goal, (fewest, most) = goal_of(mission), mission.vehicle.light_count
    like: Problem | None = None
    signs = []
    for kit in kits:
        allowed = fewest <= kit.light_count <= most and kit.camera_count == mission.vehicle.camera_count
        few = only(selection, ids_of_kit(kit))
        bodies = few.completes if kit.complete else few.cameras and few.lenses and few.ports
        if not (allowed and bodies and few.lights):
            signs.append(NO)
            continue
        scenes = None if like is None else like.scenes_for(mission)
        count = max(kit.light_count, 1)
        problem = build_problem(mission, few, scenes=scenes, counts=(count, count))
        outcome = Search(problem, goal, top=1).whole()
        like = like or problem
        signs.append(YES if outcome.best else NO)
    return "".join(signs)
