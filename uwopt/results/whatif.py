"""What happens to the optimum when keys of a mission change: points, systems, and where one takes over from another.

What `whatif` returns and whatif.json holds, schema `uwopt.whatif/1`.
"""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from uwopt.results.basis import ObjectiveValue
from uwopt.results.design import Note, lamps_in_words
from uwopt.results.frames import frame_of
from uwopt.results.record import RECORD, FiledRecord, Flag, Number, Record, Whole
from uwopt.results.shown import Reported

if TYPE_CHECKING:
    import pandas as pd

WHATIF_SCHEMA = "uwopt.whatif/1"
KeyValue = Number | str


@dataclass(frozen=True, config=RECORD)
class VariedKey(Record):
    """A key of the mission, and the values that it takes."""

    key: str = Field(description="as it was named")
    unit: str = Field(description="of its values; empty where they have none")
    values: list[KeyValue] = Field(description="in the order in which they were given")
    stricter: Whole = Field(description="1: more of it asks for more, -1: less does, 0: neither is sure")


@dataclass(frozen=True, config=RECORD)
class WinningSystem(Record):
    """Hardware that is best somewhere."""

    camera: str = Field(description="id")
    lens: str = Field(description="id")
    port: str = Field(description="id, with its housing's where that counts")
    light: str = Field(description="id")
    light_count: Whole = Field(description="of lights")
    generic: Flag = Field(description="whether one of its parts is to be made, and not sold")

    @property
    def parts(self) -> str:
        """In one line."""
        return f"{self.camera} + {self.lens} + {self.port} + {lamps_in_words(self.light_count, self.light)}"


@dataclass(frozen=True, config=RECORD)
class WhatIfPoint(Record):
    """The optimum at one choice of values."""

    values: list[KeyValue] = Field(description="of the varied keys, in their order")
    status: str = Field(description="optimal | feasible (best that was counted) | infeasible | stopped")
    system: Whole | None = Field(default=None, description="index of the best system; null where nothing fits")
    objective: Number | None = Field(default=None, description="of that system")
    gap_rel: Number | None = Field(default=None, description="no system is better by more than this share")
    figures: dict[str, Number] = Field(default_factory=dict, description="of that system, its settings among them")
    beyond_gain_cap: Flag = Field(default=False, description="whether nothing fits below the reserve's highest gain")


@dataclass(frozen=True, config=RECORD)
class Switch(Record):
    """Where, along one key, another system becomes the best, or the last stops fitting."""

    key: str = Field(description="along which")
    others: list[KeyValue | None] = Field(description="values of all keys, in their order; null for that key")
    low: Number = Field(description="value at which the first is still the best")
    high: Number = Field(description="value at which the second is")
    first: Whole | None = Field(description="index of a system; null where nothing fits")
    second: Whole | None = Field(description="index of a system; null where nothing fits")
    proven: Flag = Field(description="whether both sides are proven optima, or only the better of the two systems")


@dataclass(frozen=True, config=RECORD)
class SpiderLine(Record):
    """How the optimum follows one quantity of the mission, all others as they are."""

    key: str = Field(description="section and key")
    unit: str = Field(description="of the base")
    base: Number = Field(description="what the mission states")
    points: list[WhatIfPoint] = Field(description="by factor on the base, the only value")


@dataclass(frozen=True, repr=False, config=RECORD)
class WhatIf(Reported, FiledRecord):
    """The optimum over values of a mission's keys, as it is written to whatif.json."""

    status: str = Field(description="complete | stopped | interrupted")
    mission: dict[str, Any] = Field(description="as it stands, defaults filled in")
    objective: ObjectiveValue = Field(description="name, direction and unit; no value")
    uwopt_version: str = Field(description="that wrote this")
    keys: list[VariedKey] = Field(description="that are varied")
    points: list[WhatIfPoint] = Field(default_factory=list, description="one a choice of values")
    systems: list[WinningSystem] = Field(default_factory=list, description="that are best somewhere")
    switches: list[Switch] = Field(default_factory=list, description="where another system takes over")
    spider: list[SpiderLine] = Field(default_factory=list, description="every quantity alone, around the mission")
    warnings: list[Note] = Field(default_factory=list, description="what to know of this table")
    timing_s: dict[str, Number] = Field(default_factory=dict, description="by part of the run")
    n_searches: Whole = Field(default=0, description="that were run, most of them over listed parts")
    confidence: Number | str = Field(
        default="central",
        description="share of the scenarios in which hardware holds, or ends; the objective is then its median",
    )
    gave_way: list[str] = Field(
        default_factory=list,
        description="keys of good practice that are relaxed at every point, as nothing fits the mission as it stands, "
        "or holds as often as is asked, with all of it",
    )
    command: str = Field(default="whatif", description="always whatif")
    mission_file: dict[str, str] | None = Field(default=None, description="name, folder, text as the user wrote it")
    schema: str = Field(default=WHATIF_SCHEMA, description="of this file")

    def __repr__(self) -> str:
        keys = " and ".join(key.key for key in self.keys) or "each quantity"
        return f"<WhatIf over {keys}: {self.status}, {len(self.points)} points, {len(self.systems)} systems>"

    def rows(self) -> list[dict[str, Any]]:
        """One row a point: values, status, objective, the system's parts, figures and settings."""
        return [self.row(point) for point in self.points]

    def row(self, point: WhatIfPoint) -> dict[str, Any]:
        """One row of the table."""
        system = None if point.system is None else self.systems[point.system]
        row: dict[str, Any] = {key.key: value for key, value in zip(self.keys, point.values, strict=True)}
        row |= {"status": point.status, "objective": point.objective, "gap_rel": point.gap_rel, "system": point.system}
        row |= {"gave_way": " ".join(self.gave_way)} if self.gave_way else {}
        row |= {} if system is None else asdict(system)
        return row | {name: value for name, value in point.figures.items() if name not in row}

    def frame(self, name: str = "points") -> "pd.DataFrame":
        """A table: points, systems, switches, spider or warnings."""
        return frame_of(
            {
                "points": self.rows, "systems": self.systems, "switches": self.switches,
                "spider": self.spider_rows, "warnings": self.warnings,
            },
            name,
        )  # fmt: skip

    def spider_rows(self) -> list[dict[str, Any]]:
        """One row a quantity and factor."""
        return [
            {"key": line.key, "unit": line.unit, "factor": point.values[0], "value": line.base * float(point.values[0]),
             "status": point.status, "objective": point.objective, "system": point.system}
            for line in self.spider
            for point in line.points
        ]  # fmt: skip
