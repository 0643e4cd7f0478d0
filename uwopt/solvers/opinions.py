"""Second opinions: the settings of found hardware solved again by a continuous solver."""

from __future__ import annotations

from typing import Any

from uwopt.objectives.objective import Objective
from uwopt.solvers.continuous import solve_settings
from uwopt.solvers.goals import scenes_need_cells
from uwopt.solvers.imagers import limit
from uwopt.solvers.ranking import Found
from uwopt.solvers.recommend import Sought, scene_rows_of

AGREES_REL = 1e-4


def smooth(sought: Sought, objective: Objective) -> bool:
    """Whether the continuous solvers' program holds what the mission asks: no sun, no sharpness, no contrast."""
    return not (scenes_need_cells(sought.problem.scenes, objective) or objective.weight("contrast"))


def opinion(sought: Sought, found: Found, objective: Objective, method: str) -> dict[str, Any]:
    """What a continuous solver finds for one hardware, beside the search's value."""
    search, problem = sought.search, sought.problem
    answer = solve_settings(
        scene_rows_of(search, found),
        motorised=bool(problem.lenses.motorised[found.lens]),
        objective=objective,
        camera_power_w=float(search.imagers.camera_power_w[found.imager]),
        cost=found.cost,
        mass_kg=found.mass_kg,
        gsd_mm=float(search.imagers.gsd_mm[found.imager]),
        power_limit_w=limit(problem.mission.limits.power_w),
        method=method,  # type: ignore[arg-type]
    )
    parts = problem.parts
    value = answer.objective_value
    difference = None
    if value is not None:
        difference = abs(value - found.minimised) / max(abs(found.minimised), 1e-12)
    return {
        "method": answer.method,
        "hardware": [
            parts.cameras[found.camera].id, parts.lenses[found.lens].id, parts.ports[found.port].id,
            parts.lights[found.light].id,
        ],
        "status": answer.status,
        "objective_value": None if value is None else objective.reported(value),
        "difference_rel": difference,
        "agrees": difference is not None and difference <= AGREES_REL,
        "max_violation": answer.max_violation,
        "kkt_residual": answer.kkt_residual,
        "multipliers": answer.multipliers,
        "iterations": answer.iterations,
        "run_time_s": answer.run_time_s,
        "message": answer.message,
    }  # fmt: skip
