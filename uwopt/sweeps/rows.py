"""One row a mission: what its result says, in columns of one kind each.

Names carry their unit. Of several scenes the first stands in plain columns, all of them in `scenes` as JSON.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from uwopt.catalog.records import OF_A_DESIGN
from uwopt.mission.doubt import ENDS
from uwopt.mission.mission import Mission
from uwopt.mission.yielding import gave_way_between, yields_of
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.units import is_number

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult

Row = dict[str, Any]
SETTING, EXACT = "set_", "exact_"  # before settings to type in, and before those of the exact optimum
FRONT, POINTS = "front_", "front"  # before objectives of a point; a column of all points, until they are rows
FAILED = "failed"  # status of a mission that could not be worked out
NOTHING_FITS = "nothing fits"
DIED = "the process that worked on this mission ended"  # begins the message of such a row
#: Columns of text, whole numbers and flags; all others are numbers with a point.
TEXTS = frozenset({
    "key", "input_hash", "catalogue_hash", "version", "inputs", "mission", "status", "message", "camera", "lens",
    "port", "housing", "complete", "light", "orientation", "lamps", "objective_name", "objective_unit", "currency",
    "missed", "warnings", "scenes", "confidence_asked", "gave_way", "practice_held", "served", "point", "curve",
    "front",
})  # fmt: skip
WHOLES = frozenset({"n", "camera_count", "light_count", "points"})
FLAGS = frozenset({"generic", "settable", "beyond_gain_cap"})
#: In this order, before settings and figures.
FIRST = (
    "key", "mission", "inputs", "status", "message", "points", "point", "curve", "camera", "lens", "port",
    "housing", "complete", "light", "camera_count", "light_count", "orientation", "spacer_mm", "lamps", "generic",
    "objective_name", "objective", "objective_as_set", "objective_unit", "lower_bound", "gap_rel",
    "confidence_asked", "confidence", "gave_way", "practice_held", "settable", "beyond_gain_cap", "missed", "warnings",
    "cost", "cost_low", "cost_high", "currency", "power_w", "mass_kg",
)  # fmt: skip
LAST = ("scenes", "time_s", "processor_s", "version", "input_hash", "catalogue_hash")
#: Columns that a result always has, so that an input of the same name gets its section before it.
OUTPUTS = frozenset({*FIRST, *LAST, "n"})


def row_of(result: Result) -> Row:
    """The row of a result of `solve` or `evaluate`."""
    proof, best, goal = result.certificate, result.best, result.objective
    row: Row = {
        "mission": str(result.mission.get("name") or "mission"),
        "status": result.status,
        "message": NOTHING_FITS if result.status == "infeasible" else "",
        "objective_name": goal.name,
        "objective_unit": goal.unit,
        "lower_bound": None if proof is None else proof.lower_bound,
        "gap_rel": None if proof is None else proof.gap_rel,
        "confidence_asked": None if result.confidence is None else str(result.confidence.asked),
        "confidence": None if result.confidence is None else result.confidence.held,
        "beyond_gain_cap": any(note.code == "gain_cap" for note in result.warnings),
        "warnings": " ".join(dict.fromkeys(note.code for note in result.warnings)),
    }
    return row if best is None else row | design_columns(best, best.as_set)


def with_gave_way(row: Row, asked: Mission, held: Mapping[str, Any]) -> Row:
    """The row of a mission in which something fits, with what of good practice is not held: `held`, plain values."""
    given_way = () if row["status"] == "infeasible" else gave_way_between(asked, held)
    return row | {"gave_way": ", ".join(one.as_held for one in given_way) or None}


def with_practice_held(row: Row, mission: Mission) -> Row:
    """The row of a mission, with what of good practice is held where less of it may do.

    That is where nothing fits, or holds as often as is asked.
    """
    known = yields_of(mission)
    asked, held = row.get("confidence_asked"), row.get("confidence")
    if asked is not None and held is not None and asked != ENDS and held < float(asked):
        known = tuple(one for one in known if one.for_certainty)
    elif row["status"] != "infeasible":
        return row
    return row | {"practice_held": ", ".join(dict.fromkeys(one.path for one in known)) or None}


def row_of_front(front: FrontResult) -> Row:
    """The row of a trade-off: how it ended, and its points as JSON, each of them a row of the table at the end."""
    points = [
        {"point": one.id, "curve": one.curve, **design_columns(one.design, one.design)}
        | {FRONT + name: value for name, value in one.values.items()}
        for one in front.points
    ]
    return {
        "mission": str(front.mission.get("name") or "mission"), "status": front.status,
        "message": NOTHING_FITS if front.status == "infeasible" else "",
        "objective_name": ", ".join(one.name for one in front.objectives),
        "warnings": " ".join(dict.fromkeys(note.code for note in front.warnings)), "points": len(points),
        POINTS: json.dumps(points, allow_nan=False) if points else None,
    }  # fmt: skip


def point_rows(rows: Sequence[Row]) -> list[Row]:
    """Rows of trade-offs with a row a point; those without points as they are."""
    made = []
    for row in rows:
        told = row.get(POINTS)
        rest = {name: value for name, value in row.items() if name != POINTS}
        made += [rest | point for point in json.loads(told)] if told else [rest]
    return made


def failed_row(mission: str, message: str) -> Row:
    """The row of a mission that could not be worked out."""
    return {"mission": mission, "status": FAILED, "message": message}


def design_columns(best: Design, shown: Design) -> Row:
    """What a row says of a system: settings of both kinds, figures of the design as it is shown."""
    used, exact = best.hardware, best.scenes[0]
    totals, scene = shown.totals, shown.scenes[0]
    missed = [m.requirement for m in best.missed]
    row: Row = {
        **{kind: getattr(used, kind).id for kind in OF_A_DESIGN},
        "housing": None if used.housing is None else used.housing.id,
        "complete": None if used.complete is None else used.complete.id,
        "camera_count": used.camera_count,
        "light_count": used.light_count,
        "orientation": used.orientation,
        "spacer_mm": used.spacer_mm,
        "lamps": json.dumps(
            [[one.x_m, one.y_m, one.z_m, one.tilt_x_deg, one.tilt_y_deg] for one in used.light_mounts]
        ),
        "generic": any(part.generic for part in used.parts.values()),
        "objective": best.objective_value,
        "objective_as_set": None if best.rounded is None else best.rounded.objective_value,
        "settable": best.is_settable,
        "missed": " ".join(dict.fromkeys(missed)),
        "cost": totals.cost.value,
        "cost_low": totals.cost.low,
        "cost_high": totals.cost.high,
        "currency": totals.cost.currency,
        "power_w": totals.power_w,
        "mass_kg": totals.mass_kg,
    }
    row |= {SETTING + name: value for name, value in (scene.settings_to_set or {}).items()}
    row |= {EXACT + name: value for name, value in exact.settings.items()}
    row |= {name: value for name, value in scene.figures.items() if name not in row and is_number(value)}
    if len(best.scenes) > 1:
        told = [
            {"name": one.name, "settings": one.settings, "settings_to_set": one.settings_to_set,
             "figures": as_set.figures}
            for one, as_set in zip(best.scenes, shown.scenes, strict=True)
        ]  # fmt: skip
        row["scenes"] = json.dumps(told, allow_nan=False)
    return row
