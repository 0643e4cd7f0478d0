"""What solve, evaluate and pareto share: the mission prepared, what every result carries, warnings."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import date
from functools import cache
from importlib import metadata
from numbers import Integral
from pathlib import Path
from typing import Any

from uwopt.catalog.choose import Selection
from uwopt.catalog.curves.clarity import Clarity
from uwopt.catalog.edition import EDITION
from uwopt.deadline import Deadline
from uwopt.documents.faults import show
from uwopt.errors import MissionError
from uwopt.forward.effects import Influence
from uwopt.forward.problem import Problem
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.doubt import CENTRAL, ENDS
from uwopt.mission.mission import Mission, load_mission
from uwopt.objectives.objective import Objective
from uwopt.quantities import AT_LIKELIEST
from uwopt.results.basis import ObjectiveValue, UsedPhysics, UsedWater
from uwopt.results.design import Note
from uwopt.results.result import Result
from uwopt.results.version import __version__
from uwopt.units import texts_apart

Source = str | Path | Mapping[str, Any]
NOT_MODELLED = (
    "shadows and relief of the floor", "ripples of sunlight",
    "reflections between port and lens", "lens distortion and vignetting beyond cos^4",
)  # fmt: skip


def given(**asked: Any) -> dict[str, Any]:
    """What a call changes of a mission: what is not None."""
    return {key: value for key, value in asked.items() if value is not None}


def check_count(name: str, value: object, least: int) -> None:
    """Raise MissionError for what is no whole number, or too small a one."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise MissionError(f"{name} = {show(value)} is no whole number from {least}")


def check_day(text: str) -> None:
    """Raise MissionError for what is no day."""
    try:
        date.fromisoformat(text)
    except ValueError:
        raise MissionError(f"date = {show(text)} is no day; write YYYY-MM-DD") from None


def prepared(mission: Source | Mission, physics: str | None, objective: Any, confidence: Any = None) -> Mission:
    """A mission with the physics, objective and confidence of the call."""
    loaded, changes = load_mission(mission), given(physics=physics, objective=objective, confidence=confidence)
    made = loaded.with_changes(**changes) if changes else loaded
    check_physical(made)
    return made


def halfway(held: float, asked: float | str) -> float:
    """Share of scenarios half as far from what is asked as what was counted: less is not worth what it takes."""
    assert not isinstance(asked, str)
    return 0.5 * (held + asked)


def beyond_cap(gain_db: float, cap_db: float) -> str:
    """A gain that is higher than good practice has it, in words."""
    gain, cap = texts_apart(gain_db, cap_db, text=lambda value, digits: f"{value:.{digits}g}")
    return f"gain {gain} dB, beyond {cap} dB"


def selection_warnings(selection: Selection) -> list[Note]:
    """Patterns that match nothing."""
    return [Note("pattern", "catalog", text) for text in selection.warnings]


def base_result(
    command: str, mission: Mission, goal: Objective, problem: Problem, influences: Sequence[Influence] = ()
) -> Result:
    """What every result carries; physics `full` keeps every effect, however small."""
    tables = {scene.name: scene.water_table for scene in problem.scenes}
    physics = UsedPhysics(
        name=mission.physics,
        asked=mission.physics,
        tolerance=mission.tolerance,
        fineness=problem.fineness.by_part(),
        water_table=tables[problem.scenes[0].name] if len(set(tables.values())) == 1 else tables,
        effects=[
            (item if mission.physics == "auto" else replace(item, kept=True, time_saved_s=0.0)).used()
            for item in influences
        ],
        not_modelled=list(NOT_MODELLED),
        waters=[used_water(scene.name, scene.clarity) for scene in problem.scenes if scene.clarity],
    )
    return Result(
        command=command,
        status="feasible",
        mission=mission.to_dict(),
        physics=physics,
        objective=ObjectiveValue(goal.name, goal.direction, None, goal.unit(mission.limits.currency)),
        uwopt_version=__version__,
        seed=mission.seed,
        versions=versions(),
        mission_file=mission.source_file,
    )  # fmt: skip


def used_water(scene: str, known: Clarity) -> UsedWater:
    """What a result says of a water that was made from a reading."""
    relation = known.relation
    return UsedWater(
        scene, relation.key, known.value, known.c_per_m(), known.c_per_m("low"), known.c_per_m("high"),
        known.profiles["central"].name, f"{relation.text} ({relation.source})", relation.advice,
    )  # fmt: skip


@cache
def versions() -> dict[str, str]:
    """Versions of Python and of libraries that numbers depend on, once: to look them up costs as a small evaluation."""
    out = {"catalogue": EDITION, "python": sys.version.split()[0]}
    for name in ("numpy", "scipy", "casadi", "nlopt", "pymoo", "jerlov"):
        try:
            out[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return out


def central_notes(mission: Mission, instead: str) -> list[Note]:
    """That a mission's confidence is not held, where only the likeliest values are taken; and what holds it instead."""
    asked = mission.confidence
    if asked == CENTRAL:
        return []
    share = "the worst end of all that is in doubt" if asked == ENDS else f"a confidence of {asked:g}"
    text = f"all is told {AT_LIKELIEST}; {share}, which the mission asks for, is not held here; {instead}"
    return [Note("central_numbers", "confidence", text)]


def time_warnings(deadline: Deadline) -> list[Note]:
    """What there was no time for."""
    if not deadline.left_out:
        return []
    text = "the time that was given is over; not worked out: " + "; ".join(dict.fromkeys(deadline.left_out))
    return [Note("time", "", text)]
