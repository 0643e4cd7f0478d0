"""Whether the recommendation rests on how well the water is known: what a reading of it leaves open, which table of
types is right, and what K is on the way from lamp to floor.

A visibility or a Secchi depth leaves the attenuation open within a range, and two published tables of the Jerlov types
disagree by up to three times. The systems shown are solved again in the clearest and the murkiest water of the reading
and in the other table's water; a full search in it is a change of `scene.c_per_m` or `scene.water_table` away.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Literal

import numpy as np

from uwopt.catalog.curves.clarity import ClarityEnd
from uwopt.catalog.curves.spectra import water_types
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.scene import LampLeg, SceneOptics, scene_optics
from uwopt.mission.mission import Mission
from uwopt.solvers.one_hardware import best_of, ids_of_pieces, problem_of
from uwopt.solvers.recommend import Sought
from uwopt.solvers.settings.best import scenes_need_cells

MOST_SHOWN = 3  # systems that are solved again in each water
LAMP_LEGS: dict[LampLeg, str] = {
    "diffuse": "as the model has it", "least": "the least", "most": "the most",
}  # fmt: skip
READING_ENDS: dict[ClarityEnd, str] = {"low": "clearest", "high": "murkiest"}
Table = Literal["measured", "solonenko-mobley"]
OTHER: dict[str, Table] = {"measured": "solonenko-mobley", "solonenko-mobley": "measured"}


def in_other_waters(sought: Sought, deadline: Deadline = NEVER) -> list[dict[str, Any]]:
    """The systems shown, solved again with the water's range, the other table and both bounds of K on the lamp leg."""
    problem = sought.problem
    if problem.paper or not sought.outcome.best:
        return []
    return [
        {"case": name, **verdict(sought, scenes, deadline)}
        for name, scenes in (
            *ends_of_readings(problem.mission, problem.scenes),
            *variants(problem.mission, problem.scenes),
        )
    ]


def ends_of_readings(
    mission: Mission, scenes: Sequence[SceneOptics]
) -> Iterator[tuple[dict[str, str], list[SceneOptics]]]:
    """The clearest and the murkiest water that the readings leave open, in all scenes at once."""
    if not any(scene.clarity for scene in scenes):
        return
    for end, name in READING_ENDS.items():
        made = [
            in_water(mission, i, scene, water_end=end) if scene.clarity else scene for i, scene in enumerate(scenes)
        ]
        said = [
            f"{s.clarity.relation.key} {s.clarity.value:g} (c = {s.clarity.c_per_m(end):.3g} 1/m at 530 nm)"
            for s in scenes
            if s.clarity
        ]
        case = {"water_table": table_names(made), "lamp_attenuation": LAMP_LEGS["diffuse"]}
        yield {"reading": f"{name} water that fits {', '.join(dict.fromkeys(said))}", **case}, made


def variants(
    mission: Mission, scenes: Sequence[SceneOptics]
) -> Iterator[tuple[dict[str, str], list[SceneOptics]]]:
    """Other waters that the same mission could mean, each unlike the one in use."""
    for table in (None, "other"):
        for leg in LAMP_LEGS:
            if table is None and leg == "diffuse":
                continue
            made = [changed_scene(mission, i, scene, table, leg) for i, scene in enumerate(scenes)]
            if any(one is not None for one in made):
                full = [one or scene for one, scene in zip(made, scenes, strict=True)]
                yield {"water_table": table_names(full), "lamp_attenuation": LAMP_LEGS[leg]}, full


def table_names(scenes: Sequence[SceneOptics]) -> str:
    """The tables of all scenes."""
    return " and ".join(sorted({scene.water_table for scene in scenes}))


def changed_scene(
    mission: Mission, index: int, scene: SceneOptics, table: str | None, leg: LampLeg
) -> SceneOptics | None:
    """One scene in another water; None where there is no other."""
    name = own_table(scene) if table is None else other_table(scene)
    if (table is not None and name is None) or (table is None and not scene.scattering):  # K is c already
        return None
    return in_water(mission, index, scene, water_table=name, lamp_leg=leg)


def in_water(mission: Mission, index: int, scene: SceneOptics, **other: Any) -> SceneOptics:
    """A scene in other water, as `scene_optics` takes it."""
    view = mission.scene_view(index)
    return scene_optics(view, paper=False, base_dir=mission.base_dir, fineness=scene.fineness, **other)


def own_table(scene: SceneOptics) -> Table | None:
    """The table that a scene's water is from, where it is one of the two."""
    return OTHER.get(OTHER.get(scene.water_table, ""))


def other_table(scene: SceneOptics) -> Table | None:
    """The other table of the Jerlov types, where it has this water."""
    other, water = OTHER.get(scene.water_table), scene.view.scene.water
    if other is None:
        return None
    of_no_type = scene.clarity is not None and water is None
    return other if of_no_type or water in water_types(other) else None


def verdict(
    sought: Sought, scenes: list[SceneOptics], deadline: Deadline
) -> dict[str, Any]:
    """How the systems shown do in other waters, and whether another of them would be chosen."""
    problem, objective = sought.problem, sought.goal
    slow = scenes_need_cells(problem.scenes, objective)
    shown = sought.outcome.best[: 1 if slow else MOST_SHOWN]
    values = [best_of(problem_of(problem, found, scenes=scenes), objective, deadline) for found in shown]
    best = int(np.argmin(values))
    return {
        "feasible": math.isfinite(values[0]),
        "objective_value": objective.told(values[0]),
        "best_of_shown": ids_of_pieces(problem, shown[best])
        if math.isfinite(values[best])
        else None,
        "changes": not math.isfinite(values[0]) or values[best] < values[0] - 1e-9 * abs(values[0]),
    }
