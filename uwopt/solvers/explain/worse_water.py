"""What one system takes in water worse than planned.

Worse is the next Jerlov type of the table, or a reading (attenuation, visibility, Secchi depth, turbidity) worse by a
quarter, a half, and by two. The hardware stays; its settings are searched anew with their proof. Where none do, the
altitude is lowered in steps of a tenth until some do.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from uwopt.catalog.curves.spectra import water_types
from uwopt.deadline import NEVER, Deadline
from uwopt.errors import UwoptError
from uwopt.evaluation.design import evaluate_design
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.problem import Problem
from uwopt.mission.keys import CLARITY_KEYS, JERLOV_TYPES
from uwopt.mission.mission import Mission
from uwopt.objectives.goal import goal_of
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL
from uwopt.results.design import Design
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.other_makers import furthest_rule
from uwopt.solvers.one_hardware import problem_of
from uwopt.solvers.recommend import evaluated

WORSE = (1.25, 1.5, 2.0)  # of a reading
MOST_TYPES = 3  # Jerlov types beyond the planned one
LOWER = tuple(1.0 - 0.1 * step for step in range(8))  # of the altitude
GROWS = ("c_per_m", "turbidity_ntu")  # in worse water; visibility and Secchi depth fall
ANY_MOUNT = ("C",)  # of parts that fit, for they stand in a system
TABLE: Literal["measured"] = "measured"


@dataclass(frozen=True)
class InWorseWater:
    """What one system takes in worse water; `design` is None where nothing down to the least altitude does."""

    water: str
    as_planned: Design  # with the settings of the planned water
    altitude_frac: float
    design: Design | None
    obstacle: str = ""  # the rule that keeps the vehicle from going nearer, where one does and nothing helps


def in_worse_water(
    problem: Problem, hardware: Hardware, given: list[SceneSettings], deadline: Deadline = NEVER
) -> list[InWorseWater]:
    """One system in each worse water, the least bad first; it ends with the first in which nothing does.

    given : the settings of the planned water
    """
    found: list[InWorseWater] = []
    for water, murkier in worse_missions(problem.mission):
        mission = with_its_iris(murkier, problem, hardware, given)
        if deadline.passed():
            break
        one, goal = alone(problem, hardware, mission), goal_of(mission)
        planned = evaluate_design(one, hardware.alone, given, goal, level_tolerance_rel=LEVEL_TOLERANCE_REL)
        share, design, obstacle = nearest_that_does(problem, hardware, mission, deadline)
        found.append(InWorseWater(water, planned, share, design, obstacle))
        if design is None:
            break
    return found


def with_its_iris(mission: Mission, problem: Problem, hardware: Hardware, given: list[SceneSettings]) -> Mission:
    """The mission with the f-number held as it is set: behind a sealed port nobody turns the iris of a manual lens."""
    if problem.lenses.motorised[hardware.lens]:
        return mission
    return mission.with_changes(fixed=dict(mission.fixed.given()) | {"f_number": given[0].f_number})


def alone(problem: Problem, hardware: Hardware, mission: Mission) -> Problem:
    """Tables of one hardware in another mission; parts written out without a mount stand together as they do."""
    own, lists = problem.parts.of(hardware), dict[str, list[Any]]()
    if not (own["camera"].mounts and own["lens"].mounts):
        lists = {kind: [replace(own[kind], mounts=ANY_MOUNT)] for kind in ("camera", "lens")}
    return problem_of(problem, hardware, mission=mission, lists=lists)


def nearest_that_does(
    problem: Problem, hardware: Hardware, mission: Mission, deadline: Deadline
) -> tuple[float, Design | None, str]:
    """The highest share of the altitude at which some settings do, and the best design there; or what stops it."""
    obstacle = ""
    for share in LOWER:
        lower = flown(mission, share, landscape=hardware.landscape)
        if lower is None:
            continue
        one, goal = alone(problem, hardware, lower), goal_of(lower)
        outcome = Search(one, goal, top=1, deadline=deadline).whole()
        if outcome.best:
            return share, evaluated(one, outcome.best[0], goal), ""
        if share < 1.0 and not obstacle:
            obstacle = furthest_rule(outcome.account.discarded) or ""
    return LOWER[-1], None, obstacle


def worse_missions(mission: Mission) -> Iterator[tuple[str, Mission]]:
    """The mission in worse and worse water, all scenes together; none where no scene's water can be made worse."""
    scenes = mission.to_dict()["scenes"]
    for step in range(MOST_TYPES):
        made = [worse_scene(scene, step) for scene in scenes]
        if any(one is None for one in made):
            return
        told = dict.fromkeys(name for one in made if one is not None for name in [one[0]])
        changed = [one[1] for one in made if one is not None]
        try:
            yield ", ".join(told), mission.with_changes(scenes=changed)
        except UwoptError:  # beyond what a reading may be
            return


def worse_scene(scene: Mapping[str, Any], step: int) -> tuple[str, dict[str, Any]] | None:
    """A scene in worse water, with that water in words; None where there is none."""
    for key in CLARITY_KEYS:
        reading = scene.get(key)
        if reading is not None:
            worse = reading * WORSE[step] if key in GROWS else reading / WORSE[step]
            shown = float(f"{worse:.3g}")
            return f"{key} {shown:g}", {**scene, key: shown}
    water = scene.get("water")
    table = scene.get("water_table") or TABLE
    known = [name for name in JERLOV_TYPES if name in water_types(table)]
    if water not in known or known.index(water) + step + 1 >= len(known):
        return None
    next_type = known[known.index(water) + step + 1]
    return f"Jerlov {next_type}", {**scene, "water": next_type}


def flown(mission: Mission, share: float, *, landscape: bool) -> Mission | None:
    """The mission at a share of its altitudes with the camera as it is mounted; None where that is none any more."""
    data = mission.to_dict()
    altitude_m, orientation = data["vehicle"]["altitude_m"] * share, "landscape" if landscape else "portrait"
    scenes = []
    for scene in data["scenes"]:
        own = scene.get("vehicle") or {}
        lower = {**own, "altitude_m": own["altitude_m"] * share} if own.get("altitude_m") else own
        scenes.append({**scene, "vehicle": lower} if own else scene)
    vehicle = {**data["vehicle"], "altitude_m": altitude_m, "orientation": orientation}
    try:
        return mission.with_changes(vehicle=vehicle, scenes=scenes)
    except UwoptError:  # such as nearer than its tolerance
        return None
