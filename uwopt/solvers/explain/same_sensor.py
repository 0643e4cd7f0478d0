"""Why not the same sensor in another case or with another interface.

A sensor is told by its chip, colour, shutter, pixel pitch and size. What each is put into is solved again at likeliest
values, with all else as it is: one that meets the mission may be bought instead, whatever it draws.
"""

from __future__ import annotations

import math
from typing import Any

from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.part import OF_A_DESIGN
from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.solvers.one_hardware import best_of_each, problem_of
from uwopt.solvers.recommend import Sought

COMPLETE = "complete camera"
SAME_SIZE = 0.02  # of the pixels along a side: makers read out a few columns more or less of one chip
UNREACHED = "whether other cameras with the same sensor would do"


def siblings(sought: Sought, deadline: Deadline = NEVER) -> list[dict[str, Any]]:
    """Other cameras of the search with the sensor of the first system's that meet the mission in its place, the best
    first: `part`, `name`, `interface` and the objective's `value`."""
    problem, objective, winner = sought.problem, sought.goal, sought.outcome.best[0]
    own = problem.parts.cameras[winner.camera]
    alike = [camera for camera in problem.parts.cameras if has_sensor_of(own, camera)]
    if not alike:
        return []
    others = problem_of(problem, winner, lists={"camera": alike})
    places = [dict.fromkeys(OF_A_DESIGN, 0) | {"camera": place} for place in range(len(alike))]
    try:
        values = best_of_each(others, objective, places, deadline)
    except OutOfTimeError:
        deadline.left_out.append(UNREACHED)
        return []
    able = sorted((value, place) for place, value in enumerate(values) if math.isfinite(value))
    return [
        {
            "part": alike[place].id,
            "name": f"{alike[place].manufacturer} {alike[place].model}".strip() or alike[place].id,
            "interface": alike[place].interface,
            "value": objective.reported(value),
        }
        for value, place in able
    ]


def has_sensor_of(own: Camera, other: Camera) -> bool:
    """Whether another camera takes the same images: the same chip and colour, read out alike."""
    if other.id == own.id or not own.chip or COMPLETE in (own.purpose, other.purpose):
        return False
    if (other.chip, other.colour, other.shutter) != (own.chip, own.colour, own.shutter):
        return False
    sides = ("resolution_x_px", "resolution_y_px", "pixel_pitch_um")
    return all(math.isclose(getattr(own, side), getattr(other, side), rel_tol=SAME_SIZE) for side in sides)
