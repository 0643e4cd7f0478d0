"""What a sweep over many missions amounts to: which hardware wins how often, and how few kits serve most.

What `sweep` returns and sweep.json holds, schema `uwopt.sweep/1`; its rows lie beside it as Parquet.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import Field
from pydantic.dataclasses import dataclass

from uwopt.results.design import Note, lamps_in_words
from uwopt.results.frames import frame_of
from uwopt.results.record import RECORD, FiledRecord, Flag, Number, Record, Whole
from uwopt.results.shown import Reported

if TYPE_CHECKING:
    import pandas as pd

SWEEP_SCHEMA = "uwopt.sweep/1"
SWEEP_PARQUET = "sweep.parquet"


@dataclass(frozen=True, config=RECORD)
class SweepKit(Record):
    """Hardware as it is bought: parts, and how many."""

    camera: str = Field(description="id")
    lens: str = Field(description="id")
    port: str = Field(description="id")
    housing: str | None = Field(description="id; null where none is asked for")
    complete: str | None = Field(
        description="id of the complete camera that these are pieces of; null where none is"
    )
    light: str = Field(description="id")
    camera_count: Whole = Field(description="of cameras")
    light_count: Whole = Field(description="of lights")
    generic: Flag = Field(description="whether one of its parts is to be made, and not sold")
    wins: Whole = Field(description="missions in which it is the best")
    price: Number | None = Field(
        default=None, description="the most that it costs in those; null: several currencies"
    )
    serves: Whole | None = Field(
        default=None,
        description="missions whose every requirement some settings of it meet; null: not counted",
    )

    @property
    def parts(self) -> str:
        """In one line."""
        cameras = "" if self.camera_count == 1 else f"{self.camera_count} x "
        before = [self.complete] if self.complete else [self.camera, self.lens, self.port]
        housing = [self.housing] if self.housing and not self.complete else []
        return f"{cameras}{' + '.join([*before, *housing, lamps_in_words(self.light_count, self.light)])}"


@dataclass(frozen=True, config=RECORD)
class SweepPortfolio(Record):
    """The most that so many kits can serve, and what they cost."""

    kits: list[Whole] = Field(
        description="indices of kits, the cheapest of those that serve as many missions"
    )
    serves: Whole = Field(description="missions that at least one of them serves")
    price: Number | None = Field(description="of one of each; null where prices are not in one currency")


@dataclass(frozen=True, config=RECORD)
class FailedMissions(Record):
    """Missions that could not be worked out for one reason."""

    message: str = Field(description="why")
    count: Whole = Field(description="missions")


@dataclass(frozen=True, repr=False, config=RECORD)
class SweepSummary(Reported, FiledRecord):
    """What many missions amount to, as it is written to sweep.json."""

    status: str = Field(description="complete | interrupted, stopped by --seconds: missions are missing")
    what: str = Field(description="solve | evaluate | pareto")
    missions: Whole = Field(description="that are asked for")
    counts: dict[str, Whole] = Field(description="missions by their status; missing: not worked out yet")
    keys: list[str] = Field(description="that are set in the missions")
    uwopt_version: str = Field(description="that wrote this")
    identity: dict[str, str] = Field(description="of program, catalogue and libraries")
    kits: list[SweepKit] = Field(default_factory=list, description="that win somewhere, the most often first")
    tried: Whole = Field(default=0, description="of these kits were tried in every mission")
    servable: Whole = Field(default=0, description="missions that any of the kits tried serves")
    portfolio: list[SweepPortfolio] = Field(default_factory=list, description="of one kit, of two, and so on")
    one_each_price: Number | None = Field(
        default=None, description="of every mission's own best kit, one of each; null where not one currency"
    )
    currency: str = Field(default="", description="of the prices; empty where there are several")
    gave_way: dict[str, Whole] = Field(
        default_factory=dict,
        description="missions by each key of good practice that was relaxed there, what is held instead beside it",
    )
    failed: list[FailedMissions] = Field(default_factory=list, description="missions that failed, by why")
    kept: Whole = Field(default=0, description="rows that an earlier run had worked out")
    passed_over: Whole = Field(
        default=0, description="rows of an earlier run with other inputs or another catalogue"
    )
    workers: Whole = Field(default=1, description="that shared the work")
    memory_mb: Number = Field(default=0.0, description="the most that one of them held")
    timing_s: dict[str, Number] = Field(default_factory=dict, description="by part of the run")
    warnings: list[Note] = Field(default_factory=list, description="what to know of this")
    folder: str = Field(default="", description="where the rows lie")
    command: str = Field(default="sweep", description="always sweep")
    schema: str = Field(default=SWEEP_SCHEMA, description="of this file")

    def __repr__(self) -> str:
        return f"<SweepSummary of {self.missions} missions: {self.status}, {len(self.kits)} kits>"

    def frame(self, name: str = "rows") -> "pd.DataFrame":
        """A table: rows (one a mission), kits, portfolio, failed or warnings."""
        if name == "rows":
            import pandas as pd

            return pd.read_parquet(Path(self.folder) / SWEEP_PARQUET)
        tables = {"kits": self.kits, "portfolio": self.portfolio, "failed": self.failed, "warnings": self.warnings}
        return frame_of(tables, name)
