"""Second opinions: the settings of found hardware solved again by a continuous solver."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwopt.objectives.objective import Objective
from uwopt.solvers.continuous import solve_settings
from uwopt.solvers.goals import scenes_need_cells
from uwopt.solvers.imagers import limit
from uwopt.solvers.ranking import Found
from uwopt.solvers.recommend import Sought, scene_rows_of
from uwopt.solvers.settings import Chosen

AGREES_REL = 1e-4
APERTURE_RESIDUAL = 1e-6


def smooth(sought: Sought, objective: Objective) -> bool:
    """Whether the continuous solvers' program holds what the mission asks: no sun, no sharpness, no contrast."""
    return not (scenes_need_cells(sought.problem.scenes, objective) or objective.weight("contrast"))


def aperture_opinions(sought: Sought, found: Found, objective: Objective) -> list[dict[str, Any]]:
    """CasADi's word on the aperture of a winner chosen for its information, one a scene."""
    if not objective.weight("information"):
        return []
    from uwopt.solvers.aperture import confirmed

    rows = scene_rows_of(sought.search, found)
    names = Chosen.__dataclass_fields__
    made = []
    for row, numbers in zip(rows, found.settings, strict=True):
        chosen = Chosen(**{n: np.array([numbers[n]]) for n in names if n in numbers})
        word = confirmed(row, chosen)
        if word is not None:
            parts = sought.problem.parts
            made.append(
                {
                    "method": "casadi",
                    "hardware": [
                        parts.cameras[found.camera].id,
                        parts.lenses[found.lens].id,
                        parts.ports[found.port].id,
                        parts.lights[found.light].id,
                    ],
                    "status": "optimal" if word["kkt_residual"] < APERTURE_RESIDUAL else "failed",
                    "objective_value": objective.reported(found.minimised) * (1.0 + word["gain_rel"])
                    if objective.single
                    else None,
                    "difference_rel": abs(word["gain_rel"]),
                    "agrees": abs(word["gain_rel"]) <= AGREES_REL,
                    "max_violation": 0.0,
                    "kkt_residual": word["kkt_residual"],
                    "multipliers": {},
                    "iterations": 0,
                    "run_time_s": 0.0,
                    "message": f"f-number {word['f_number']:.4g} for information, time and gain as chosen; the search "
                    f"has {word['searched_f_number']:.4g}",
                }
            )
    return made


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
