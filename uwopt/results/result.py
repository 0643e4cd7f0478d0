"""Typed results, to and from JSON: what `solve` and `evaluate` return.

Absent figures are None, never missing; infinite ones are None with a companion flag. The layout is
that of the documented result file, schema `uwopt.result/1`.
"""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from uwopt.results.basis import (
    Assumption,
    Knee,
    LessMoney,
    ObjectiveValue,
    Opinion,
    OtherMaker,
    Price,
    Risk,
    UsedPhysics,
    WhyNothing,
)
from uwopt.results.certainty import Confidence
from uwopt.results.design import Design, Note
from uwopt.results.frames import bill_rows, design_rows, figure_rows, frame_of, margin_rows, settings_rows
from uwopt.results.record import RECORD, FiledRecord, Flag, Number, Record, Whole
from uwopt.results.shown import Shown

if TYPE_CHECKING:
    import pandas as pd

RESULT_SCHEMA = "uwopt.result/1"


@dataclass(frozen=True, config=RECORD)
class RuleCount(Record):
    """How many combinations a rule discards."""

    rule: str = Field(description="the first that applies to them")
    count: Whole = Field(description="combinations")


@dataclass(frozen=True, config=RECORD)
class PartsLeft(Record):
    """How many parts of each kind a mission leaves to choose from."""

    cameras: Whole = Field(description="sold without a lens or housing")
    lenses: Whole = Field(description="sold alone")
    ports: Whole = Field(description="that go on a housing of those left, where the mission asks for one")
    lights: Whole = Field(description="lamps and flashes")
    housings: Whole = Field(default=0, description="that a port of those left goes on; 0: none, or none is asked for")
    complete_cameras: Whole = Field(default=0, description="camera, lens and port bought as one")
    generic: Whole = Field(default=0, description="of all of these: to be made, as nobody sells such a part")
    places: Whole = Field(default=1, description="ways in which lamps may stand and lean, each tried with every part")

    def by_kind(self) -> dict[str, int]:
        """Parts that are sold or made as such, in the order that light meets them; kinds that may lack only if any."""
        may_lack = {"housings": self.housings, "complete_cameras": self.complete_cameras}
        return {
            "cameras": self.cameras, "lenses": self.lenses, "ports": self.ports,
            **{kind: number for kind, number in may_lack.items() if number}, "lights": self.lights,
        }  # fmt: skip

    def in_words(self) -> str:
        """`121 cameras, 1 lens, 5 ports, 12 housings, 5 lights`."""
        return ", ".join(
            f"{number} {(kind if number != 1 else SINGLE[kind]).replace('_', ' ')}"
            for kind, number in self.by_kind().items()
        )


SINGLE = {
    "cameras": "camera", "lenses": "lens", "ports": "port", "housings": "housing",
    "complete_cameras": "complete_camera", "lights": "light",
}  # fmt: skip


@dataclass(frozen=True, config=RECORD)
class Certificate(Record):
    """How far the claim of an optimum reaches, and where every combination went."""

    lower_bound: Number | None = Field(description="no system can be better than this")
    best_value: Number | None = Field(description="of the objective, as found")
    gap_abs: Number | None = Field(description="between the two")
    gap_rel: Number | None = Field(description="the same as a share of the best value")
    complete: Flag = Field(description="whether the search came to its end")
    scope: str = Field(description="what the proof covers, in words")
    loaded: Whole = Field(description="combinations of all parts of the catalogue")
    selected: Whole = Field(description="of them of parts that the mission allows")
    evaluated: Whole = Field(description="of them evaluated")
    discarded: list[RuleCount] = Field(description="the others, by the first rule that applies")
    parts_left: PartsLeft | None = Field(
        default=None, description="what the mission leaves to choose from; null: an earlier version wrote this"
    )

    def adds_up(self) -> bool:
        """Whether every combination loaded is accounted for exactly once."""
        return self.loaded == self.evaluated + sum(item.count for item in self.discarded)

    def rows(self) -> list[dict[str, Any]]:
        """The account as rows: every combination is in one of them."""
        return [{"rule": "evaluated", "count": self.evaluated}, *map(asdict, self.discarded)]


@dataclass(frozen=True, repr=False, config=RECORD)
class Result(Shown, FiledRecord):
    """What a command found, as it is written to result.json."""

    command: str = Field(description="solve | evaluate")
    status: str = Field(description="optimal | feasible | violated | infeasible | stopped")
    mission: dict[str, Any] = Field(description="as understood, defaults filled in")
    physics: UsedPhysics = Field(description="which, how fine, and what is left out")
    objective: ObjectiveValue = Field(description="name, direction, value and unit")
    uwopt_version: str = Field(description="that wrote this")
    recommendation: Design | None = Field(default=None, description="the best system")
    design: Design | None = Field(default=None, description="the system that was evaluated")
    runners_up: list[Design] = Field(default_factory=list, description="the next best, with other hardware")
    generic_alternative: Design | None = Field(default=None, description="what parts to be made could give")
    certificate: Certificate | None = Field(default=None, description="how far the claim reaches")
    infeasible: WhyNothing | None = Field(default=None, description="why nothing fits")
    assumptions: list[Assumption] = Field(default_factory=list, description="what is not known but taken")
    robustness: dict[str, Any] | None = Field(default=None, description="what the estimates could change")
    confidence: Confidence | None = Field(
        default=None, description="in how many scenarios it holds; null where numbers are taken as central"
    )
    prices: list[Price] = Field(default_factory=list, description="what more of a binding requirement costs")
    risks: list[Risk] = Field(default_factory=list, description="what may go wrong, the most serious first")
    solvers: list[Opinion] = Field(default_factory=list, description="second opinions on the settings")
    audit: dict[str, Any] | None = Field(default=None, description="the attack on what was discarded")
    warnings: list[Note] = Field(default_factory=list, description="what to know of this result")
    accuracy: dict[str, Any] = Field(default_factory=dict, description="gap, residual, and errors of figures")
    timing_s: dict[str, Number] = Field(default_factory=dict, description="by part of the run")
    seed: Whole = Field(default=0, description="of all that is drawn")
    versions: dict[str, str] = Field(default_factory=dict, description="of Python and libraries")
    schema: str = Field(default=RESULT_SCHEMA, description="of this file")
    knee: Knee | None = Field(default=None, description="of the best image: what more power and money would buy")
    less_money: LessMoney | None = Field(
        default=None, description="the cheapest system that is at most a quarter worse; null: none saves a tenth"
    )
    alternatives: list[OtherMaker] = Field(
        default_factory=list, description="other makers' best, and why not"
    )
    mission_file: dict[str, str] | None = Field(
        default=None, description="name, folder, text as the user wrote it"
    )
    mission_as_solved: str | None = Field(
        default=None, description="text of a mission file that states what of good practice was relaxed; null: none"
    )
    system: dict[str, Any] | None = Field(
        default=None, description="what was evaluated, inline parts included"
    )

    @property
    def best(self) -> Design | None:
        """The recommendation, or the design that was evaluated."""
        return self.recommendation or self.design

    @property
    def deepest_m(self) -> float:
        """Depth of the mission's deepest scene."""
        return max((float(scene.get("depth_m") or 0.0) for scene in self.mission.get("scenes") or []), default=0.0)

    @property
    def parts_left(self) -> PartsLeft | None:
        """What the mission leaves to choose from; None where an earlier version wrote this."""
        return None if self.certificate is None else self.certificate.parts_left

    def frame(self, name: str = "margins") -> "pd.DataFrame":
        """A table of the result: margins, bill, settings, figures, designs, certificate, assumptions or warnings."""
        best, proof = self.best, self.certificate
        return frame_of(
            {
                "margins": lambda: margin_rows(best),
                "bill": lambda: bill_rows(best),
                "settings": lambda: settings_rows(best),
                "figures": lambda: figure_rows(best),
                "designs": lambda: design_rows([*([best] if best else []), *self.runners_up]),
                "certificate": lambda: [] if proof is None else proof.rows(),
                "assumptions": self.assumptions,
                "warnings": self.warnings,
            },
            name,
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        data = super().to_dict()
        absent = (
            ("design", "system")
            if self.command == "solve"
            else (
                "mission_as_solved", "recommendation", "certificate", "generic_alternative", "alternatives", "knee",
                "less_money", "prices",
            )
        )  # fmt: skip
        return {key: value for key, value in data.items() if key not in absent}
