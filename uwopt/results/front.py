"""Typed fronts, to and from JSON: what `pareto` returns and front.json holds, schema `uwopt.front/1`.

A front is a list of points, none of which is better than another in every objective. Points carry the
whole design; those that share hardware lie on one curve of settings.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any

from uwopt.results.frames import frame_of
from uwopt.results.result import Design, design_from_dict, plain
from uwopt.results.shown import Shown

if TYPE_CHECKING:
    import pandas as pd

FRONT_SCHEMA = "uwopt.front/1"


@dataclass(frozen=True)
class FrontObjective:
    """One axis of a front."""

    name: str  # a term of `objectives.objective.UNITS`, or the name of the user's own function
    direction: str  # minimise | maximise
    unit: str
    own: bool = False  # a function of the user's


@dataclass(frozen=True)
class FrontPoint:
    """One design on the front, with its settings, figures and margins."""

    id: str  # p1, p2, ... along the first objective
    values: dict[str, float]  # by objective, in its unit, not negated
    curve: str  # c1, c2, ...: points of one curve share hardware
    method: str  # exact, or the name of the population solver that found it
    design: Design


@dataclass(frozen=True)
class Pick:
    """A point of the front with a name."""

    name: str  # cheapest | least power | best image | knee
    point: str  # id
    definition: str  # one sentence


@dataclass(frozen=True)
class FrontMethod:
    """How one solver did; hypervolumes are shares of the box from the exact front's best corner to the reference."""

    name: str  # exact | nsga2 | nsga3 | ...
    status: str  # complete | stopped | interrupted
    seconds: float
    n_points: int
    hypervolume: float
    hypervolume_ratio: float | None  # of the exact front's; None without one
    igd_plus: float | None  # to the exact front, axes scaled to its range
    evaluations: int
    seed: int | None
    history: list[list[float]] = field(default_factory=list)  # [seconds, hypervolume]
    hypervolume_bound: float | None = None  # no front can have more (exact only)


@dataclass(frozen=True, repr=False)
class FrontResult(Shown):
    """The trade-off between two or three objectives, as it is written to front.json."""

    status: str  # complete | stopped | interrupted | infeasible
    mission: dict[str, Any]
    physics: dict[str, Any]
    objectives: list[FrontObjective]
    uwopt_version: str
    points: list[FrontPoint] = field(default_factory=list)
    picks: list[Pick] = field(default_factory=list)
    methods: list[FrontMethod] = field(default_factory=list)
    peers: list[dict[str, Any]] = field(
        default_factory=list
    )  # {method, values, hardware: [4 ids]} of other fronts
    reference: dict[str, Any] = field(default_factory=dict)  # {ideal, nadir, point, log}, by objective
    certificate: dict[str, Any] | None = None
    alternatives: list[dict[str, Any]] = field(default_factory=list)
    infeasible: dict[str, Any] | None = None
    assumptions: list[dict[str, Any]] = field(default_factory=list)
    warnings: list[dict[str, str]] = field(default_factory=list)
    accuracy: dict[str, Any] = field(default_factory=dict)
    timing_s: dict[str, float] = field(default_factory=dict)
    seed: int = 0
    versions: dict[str, str] = field(default_factory=dict)
    command: str = "pareto"
    mission_file: dict[str, str] | None = None  # {name, text} as the user wrote it
    schema: str = FRONT_SCHEMA

    def point(self, name: str) -> FrontPoint:
        """A point by its id or by the name of its pick."""
        wanted = next((pick.point for pick in self.picks if pick.name == name), name)
        return next(point for point in self.points if point.id == wanted)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        data: dict[str, Any] = plain(self)
        return data

    def to_json(self) -> str:
        """The front file's text."""
        return json.dumps(self.to_dict(), indent=1, allow_nan=False, ensure_ascii=False)

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> FrontResult:
        """A front from plain values, as read from a front file."""
        known = {f.name for f in fields(FrontResult)}
        values = {key: value for key, value in data.items() if key in known}
        values["objectives"] = [FrontObjective(**item) for item in values.get("objectives") or []]
        values["points"] = [
            FrontPoint(**{**item, "design": design_from_dict(item["design"])})
            for item in values.get("points") or []
        ]
        values["picks"] = [Pick(**item) for item in values.get("picks") or []]
        values["methods"] = [FrontMethod(**item) for item in values.get("methods") or []]
        return FrontResult(**values)

    def frame(self, name: str = "points") -> pd.DataFrame:
        """A table of the front: points, picks, methods, assumptions or warnings."""
        return frame_of(
            {
                "points": self.rows,
                "picks": lambda: [asdict(pick) for pick in self.picks],
                "methods": lambda: [asdict(method) for method in self.methods],
                "assumptions": lambda: list(self.assumptions),
                "warnings": lambda: list(self.warnings),
            },
            name,
        )

    def rows(self) -> list[dict[str, Any]]:
        """The table's rows: objectives, hardware ids, then settings, figures and margins by scene."""
        names = {pick.point: pick.name for pick in reversed(self.picks)}
        return [point_row(point, names.get(point.id, "")) for point in self.points]


def point_row(point: FrontPoint, pick: str) -> dict[str, Any]:
    """One row of a front's table; scenes after the first carry their name in the column."""
    hardware, totals = point.design.hardware, point.design.totals
    row: dict[str, Any] = {"point": point.id, "pick": pick, "curve": point.curve, "method": point.method}
    row |= {f"objective: {name}": value for name, value in point.values.items()}
    row |= {kind: hardware[kind]["id"] for kind in ("camera", "lens", "port", "light")}
    row |= {key: hardware[key] for key in ("camera_count", "light_count", "orientation")}
    row |= {f"cost_{end}": totals["cost"].get(end) for end in ("low", "high")}
    for index, scene in enumerate(point.design.scenes):
        mark = f" [{scene.name}]" if index else ""
        row |= {f"{key}{mark}": value for key, value in scene.figures.items()}
        row |= {f"set: {key}{mark}": value for key, value in scene.settings.items()}
        row |= {f"margin: {m.requirement}{mark}": m.margin for m in scene.margins}
    return row
