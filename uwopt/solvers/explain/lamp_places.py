"""Where the lamps stand: how far a tilt may be off, and what places between the grid's points would give.

Both solve the winner's settings again for lamps that stand or lean a little differently. Neither belongs to
the certificate, which covers the declared grid of mounts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from uwopt.deadline import Deadline
from uwopt.evaluation.leaning import LeaningModel, leaning, lost_when_leaning, settings_of
from uwopt.forward.lamps import Mount
from uwopt.forward.problem import Problem
from uwopt.model.bisection import bisected
from uwopt.objectives.objective import Objective
from uwopt.results.design import Design
from uwopt.solvers.exact.imagers import enumerate_imagers
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.one_hardware import best_of, problem_of
from uwopt.solvers.recommend import Sought
from uwopt.solvers.settings.best import scenes_need_cells

TRIED_DEG = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
BISECTIONS = 3
POLISH_ROUNDS = 12
FIRST_STEP = (0.025, 1.25)  # half a grid step of baseline [m] and tilt [deg]


def tilt_tolerance(
    sought: Sought, design: Design, deadline: Deadline
) -> dict[str, Any] | None:
    """How far the lamps' tilt may be off, outward and inward, before a requirement breaks [deg].

    Once with the settings held as they are to be set but for the gain, once with light, exposure and gain set anew.
    """
    objective = sought.goal
    if sought.problem.paper:
        return None
    found = sought.outcome.best[0]
    own, mount = problem_of(sought.problem, found), found.lighting.mount
    value_at = by_mount(own, objective, deadline)

    def missed(by_deg: float) -> list[str]:
        return missed_when_leaning(own, found, design, by_deg)

    def held(by_deg: float) -> bool:
        deadline.check()
        return not missed(by_deg)

    def readjusted(by_deg: float) -> bool:
        return math.isfinite(value_at(leaning(mount, by_deg)))

    slow = scenes_need_cells(sought.problem.scenes, objective)
    start = missed(0.0)
    ends = {
        f"{name}_{way}_deg": reach(holds, sign)
        for name, holds in (("held", held), ("readjusted", readjusted))
        for way, sign in (("outward", 1.0), ("inward", -1.0))
        if (not slow if name == "readjusted" else not start)
    }
    breaks: set[str] = set()
    for way, sign in (("outward", 1.0), ("inward", -1.0)):
        end = ends.get(f"held_{way}_deg")
        if end is not None and end < TRIED_DEG[-1]:
            breaks.update(missed(sign * (end + 0.5)))
    return {**ends, "first_to_break": sorted(breaks), "tried_up_to_deg": TRIED_DEG[-1]}


def reach(holds: Callable[[float], bool], sign: float) -> float:
    """The largest angle tried at which something holds, from doubling steps and a few bisections [deg]."""
    good = 0.0
    for angle in TRIED_DEG:
        if not holds(sign * angle):
            return float(bisected(lambda tried: holds(sign * tried), good, angle, steps=BISECTIONS)[0])
        good = angle
    return good


def missed_when_leaning(own: Problem, found: Found, design: Design, by_deg: float) -> list[str]:
    """Requirements as asked for, their reserve used up, that break when the lamps lean and the settings stay as set.

    But the mean level, which a gain sets anew.

    own : the problem over the design's parts alone
    """
    mount = leaning(found.lighting.mount, by_deg)
    model = LeaningModel(own.standing_at(mount), replace(found.hardware.alone, mount=mount))
    return lost_when_leaning(model, [settings_of(scene.settings_to_set or scene.settings) for scene in design.scenes])


def by_mount(own: Problem, objective: Objective, deadline: Deadline) -> Callable[[Mount], float]:
    """Best objective over one design's parts by where its lamps stand; inf where it is not feasible."""
    imagers = cache(lambda: enumerate_imagers(own))  # the same wherever lamps stand
    return lambda mount: best_of(own.standing_at(mount), objective, deadline, imagers())


def polished_mount(sought: Sought, deadline: Deadline) -> dict[str, Any] | None:
    """Baseline and tilt between the grid's points that do better for the winner's parts, if any.

    A pattern search from the winner's mount within the mission's ranges; None where nothing may vary.
    """
    objective = sought.goal
    vehicle = sought.problem.mission.vehicle
    found = sought.outcome.best[0]
    ranges = (vehicle.light_baseline_range_m, vehicle.light_tilt_range_deg)
    still = found.lighting.mount.explicit or all(low == high for low, high in ranges)
    if still or scenes_need_cells(sought.problem.scenes, objective):
        return None
    at = np.array([found.lighting.mount.baseline_m, found.lighting.mount.tilt_deg])
    low, high = (np.array([r[end] for r in ranges]) for end in (0, 1))
    best, step = found.minimised, np.array(FIRST_STEP)
    value_at = by_mount(problem_of(sought.problem, found), objective, deadline)
    for _ in range(POLISH_ROUNDS):
        moved = False
        for axis in (0, 1):
            for sign in (1.0, -1.0):
                tried = at.copy()
                tried[axis] = np.clip(at[axis] + sign * step[axis], low[axis], high[axis])
                if tried[axis] == at[axis]:
                    continue
                value = value_at(Mount(float(tried[0]), float(tried[1])))
                if value < best - 1e-9 * abs(best):
                    best, at, moved = value, tried, True
                    break
        if not moved:
            step = step / 2.0
            if step[0] < FIRST_STEP[0] / 8:
                break
    gain = found.minimised - best
    return {
        "baseline_m": float(at[0]), "tilt_deg": float(at[1]), "objective_value": objective.reported(best),
        "gain_rel": objective.share(gain, found.minimised),
    }  # fmt: skip
