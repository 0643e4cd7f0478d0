"""Whether the recommendation rests on the choice of water table.

Two published tables of the Jerlov types disagree by up to three times. The systems shown are solved
again in the other table's water; a full search in it is a change of `scene.water_table` away.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from uwopt.catalog.spectra import water_types
from uwopt.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.problem import Parts, Problem
from uwopt.scene import SceneOptics, scene_optics
from uwopt.solvers.exact import Search
from uwopt.solvers.ranking import Found
from uwopt.solvers.recommend import Sought
from uwopt.solvers.robustness import parts_of, values_at

OTHER = {"measured": "solonenko-mobley", "solonenko-mobley": "measured"}


def other_scenes(mission: Mission, scenes: Sequence[SceneOptics]) -> list[SceneOptics] | None:
    """The scenes in the other table's water; None when no scene's type stands in both tables."""
    changed, made = False, []
    for index, scene in enumerate(scenes):
        other = OTHER.get(scene.water_table)
        known = other is not None and scene.view.scene.water in water_types(other)
        changed = changed or known
        made.append(
            scene_optics(mission.scene_view(index), paper=False, base_dir=mission.base_dir, water_table=other)
            if known
            else scene
        )
    return made if changed else None


def in_other_water(sought: Sought, objective: Objective) -> dict[str, Any] | None:
    """The systems shown, solved again with the other water table; None where there is no other."""
    problem = sought.problem
    if problem.paper or not sought.outcome.best:
        return None
    scenes = other_scenes(problem.mission, problem.scenes)
    if scenes is None:
        return None
    shown = sought.outcome.best
    values = [value_in(problem, scenes, found, objective) for found in shown]
    best = int(np.argmin(values))
    winner = shown[best]
    return {
        "tables": sorted({scene.water_table for scene in scenes}),
        "feasible": math.isfinite(values[0]),
        "objective_value": objective.reported(values[0]) if math.isfinite(values[0]) else None,
        "best_of_shown": [part.id for _, part in parts_of(problem, winner)]
        if math.isfinite(values[best])
        else None,
        "changes": not math.isfinite(values[0]) or values[best] < values[0] - 1e-9 * abs(values[0]),
    }


def value_in(problem: Problem, scenes: list[SceneOptics], found: Found, objective: Objective) -> float:
    """Best objective of one hardware in other scenes; inf where it is not feasible."""
    parts = Parts(*((part,) for _, part in parts_of(problem, found)))  # type: ignore[arg-type]
    small = Problem(
        problem.mission, parts, paper=False, owned_lights=problem.owned_lights, counts=(found.count, found.count),
        mounts=[found.lighting.mount], scenes=scenes,
    )  # fmt: skip
    search = Search(small, objective, top=1, deadline_s=None, progress=None)
    return values_at(
        search, search.prepare(), [dict.fromkeys(("camera", "lens", "port", "light"), 0)], found.count
    )[0]
