"""Typed fronts, to and from JSON: what `pareto` returns and front.json holds, schema `uwopt.front/1`.

A front is a list of points, none of which is better than another in every objective. Points carry the
whole design; those that share hardware lie on one curve of settings.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass

from uwopt.results.basis import Assumption, OtherMaker, UsedPhysics, WhyNothing
from uwopt.results.design import Design, Note
from uwopt.results.frames import frame_of
from uwopt.results.record import RECORD, FiledRecord, Flag, Number, Record, Whole
from uwopt.results.result import PartsLeft
from uwopt.results.shown import Shown

if TYPE_CHECKING:
    import pandas as pd

FRONT_SCHEMA = "uwopt.front/1"


@dataclass(frozen=True, config=RECORD)
class FrontObjective(Record):
    """One axis of a front."""

    name: str = Field(description="a built-in objective's, or of the user's own function")
    direction: str = Field(description="minimise | maximise")
    unit: str = Field(description="of its values")
    own: Flag = Field(default=False, description="whether it is a function of the user's")

    @property
    def sign(self) -> float:
        """Times a value: the less the better, whatever the direction."""
        return -1.0 if self.direction == "maximise" else 1.0


@dataclass(frozen=True, config=RECORD)
class FrontPoint(Record):
    """One design on the front, with its settings, figures and margins."""

    id: str = Field(description="p1, p2, ... along the first objective")
    values: dict[str, Number] = Field(description="by objective, in its unit, not negated")
    curve: str = Field(description="c1, c2, ...: points of one curve share hardware")
    method: str = Field(description="exact, or the population solver that found it")
    design: Design = Field(description="the whole design")


@dataclass(frozen=True, config=RECORD)
class Pick(Record):
    """A point of the front with a name."""

    name: str = Field(description="cheapest | least power | best image | knee")
    point: str = Field(description="the point's id")
    definition: str = Field(description="one sentence")


@dataclass(frozen=True, config=RECORD)
class FrontMethod(Record):
    """How one solver did; hypervolumes are shares of the box from the exact front's best corner to the reference."""

    name: str = Field(description="exact | nsga2 | nsga3 | ...")
    status: str = Field(description="complete | stopped | interrupted")
    seconds: Number = Field(description="that it took")
    n_points: Whole = Field(description="that it found")
    hypervolume: Number = Field(description="that its points dominate")
    hypervolume_ratio: Number | None = Field(description="to the exact front's; null without one")
    igd_plus: Number | None = Field(description="distance to the exact front, axes scaled to its range")
    evaluations: Whole = Field(description="of designs")
    seed: Whole | None = Field(description="null: nothing is drawn")
    history: list[list[Number]] = Field(default_factory=list, description="[seconds, hypervolume]")
    hypervolume_bound: Number | None = Field(default=None, description="no front can have more (exact only)")


@dataclass(frozen=True, config=RECORD)
class Peer(Record):
    """A point of another solver's front, to compare with."""

    method: str = Field(description="the population solver")
    values: dict[str, Number] = Field(description="by objective, in its unit, not negated")
    hardware: list[str] = Field(description="ids of camera, lens, port and light")


@dataclass(frozen=True, repr=False, config=RECORD)
class FrontResult(Shown, FiledRecord):
    """The trade-off between two or three objectives, as it is written to front.json."""

    status: str = Field(description="complete | stopped | interrupted | infeasible")
    mission: dict[str, Any] = Field(description="as understood, defaults filled in")
    physics: UsedPhysics = Field(description="which, how fine, and what is left out")
    objectives: list[FrontObjective] = Field(description="the axes")
    uwopt_version: str = Field(description="that wrote this")
    points: list[FrontPoint] = Field(default_factory=list, description="along the first objective")
    picks: list[Pick] = Field(default_factory=list, description="points worth a look first")
    methods: list[FrontMethod] = Field(default_factory=list, description="the solvers that ran")
    peers: list[Peer] = Field(default_factory=list, description="points of the other solvers' fronts")
    reference: dict[str, Any] = Field(default_factory=dict, description="the box that fronts are compared in")
    certificate: dict[str, Any] | None = Field(
        default=None, description="how far the claim reaches, with account and parts_left as a result's"
    )
    alternatives: list[OtherMaker] = Field(
        default_factory=list, description="other makers' best, and why not"
    )
    infeasible: WhyNothing | None = Field(default=None, description="why nothing fits")
    assumptions: list[Assumption] = Field(default_factory=list, description="what is not known but taken")
    warnings: list[Note] = Field(default_factory=list, description="what to know of this front")
    accuracy: dict[str, Any] = Field(default_factory=dict, description="errors of figures, where worked out")
    timing_s: dict[str, Number] = Field(default_factory=dict, description="by part of the run")
    seed: Whole = Field(default=0, description="of the population solvers")
    versions: dict[str, str] = Field(default_factory=dict, description="of Python and libraries")
    command: str = Field(default="pareto", description="always pareto")
    mission_file: dict[str, str] | None = Field(
        default=None, description="name, folder, text as the user wrote it"
    )
    schema: str = Field(default=FRONT_SCHEMA, description="of this file")

    @property
    def parts_left(self) -> PartsLeft | None:
        """What the mission leaves to choose from; None where an earlier version wrote this, or nothing is proven."""
        return TypeAdapter(PartsLeft | None).validate_python((self.certificate or {}).get("parts_left"))

    def point(self, name: str) -> FrontPoint:
        """A point by its id or by the name of its pick."""
        wanted = next((pick.point for pick in self.picks if pick.name == name), name)
        return next(point for point in self.points if point.id == wanted)

    def values_as_set(self, point: FrontPoint) -> dict[str, float] | None:
        """The built-in objectives of a point at the settings to type in; None where none are known or can be set."""
        design = point.design.as_set
        return None if design is point.design else values_of(design, self.objectives)

    def as_told(self, point: FrontPoint) -> FrontPoint:
        """A point with its objectives at the settings to type in, where there are any."""
        return replace(point, values={**point.values, **(self.values_as_set(point) or {})})

    def frame(self, name: str = "points") -> "pd.DataFrame":
        """A table of the front: points, picks, methods, assumptions or warnings."""
        tables = {"picks": self.picks, "methods": self.methods, "assumptions": self.assumptions}
        return frame_of({"points": self.rows, **tables, "warnings": self.warnings}, name)

    def rows(self) -> list[dict[str, Any]]:
        """The table's rows: objectives, hardware ids, then settings, figures and margins by scene."""
        names = {pick.point: pick.name for pick in reversed(self.picks)}
        return [point_row(point, names.get(point.id, "")) for point in self.points]


def point_row(point: FrontPoint, pick: str) -> dict[str, Any]:
    """One row of a front's table; scenes after the first carry their name in the column."""
    hardware, totals = point.design.hardware, point.design.totals
    row: dict[str, Any] = {"point": point.id, "pick": pick, "curve": point.curve, "method": point.method}
    row |= {f"objective: {name}": value for name, value in point.values.items()}
    row |= hardware.ids_by_kind
    row |= {key: hardware[key] for key in ("camera_count", "light_count", "orientation")}
    row |= {"cost_low": totals.cost.low, "cost_high": totals.cost.high}
    for index, scene in enumerate(point.design.scenes):
        mark = f" [{scene.name}]" if index else ""
        row |= {f"{key}{mark}": value for key, value in scene.figures.items()}
        row |= {f"set: {key}{mark}": value for key, value in scene.settings.items()}
        row |= {f"margin: {m.requirement}{mark}": m.margin for m in scene.margins}
    return row


def values_of(design: Design, objectives: Iterable[FrontObjective]) -> dict[str, float]:
    """What a design's evaluation says of the built-in objectives, the worst scene's."""
    figures = [scene.figures for scene in design.scenes]
    known: dict[str, Callable[[], Any]] = {
        "power": lambda: design.totals.power_w,
        "cost": lambda: design.totals.cost.value,
        "mass": lambda: design.totals.mass_kg,
        "snr_db": lambda: min(f["snr_db"] for f in figures),
        "gsd_mm": lambda: max(f["gsd_mm"] for f in figures),
        "contrast": lambda: min(1.0 if f["contrast"] is None else f["contrast"] for f in figures),
        "information": lambda: min(f["information_bit_per_m2"] for f in figures),
    }
    return {o.name: float(known[o.name]()) for o in objectives if o.name in known}
