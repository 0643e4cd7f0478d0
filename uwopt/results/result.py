"""Typed results, to and from JSON: what `solve` and `evaluate` return.

Absent figures are None, never missing; infinite ones are None with a companion flag. The layout is
that of the documented result file, schema `uwopt.result/1`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import TYPE_CHECKING, Any

from uwopt.results.frames import bill_rows, design_rows, figure_rows, frame_of, margin_rows, settings_rows
from uwopt.results.shown import Shown

if TYPE_CHECKING:
    import pandas as pd

RESULT_SCHEMA = "uwopt.result/1"
NOT_SETTABLE = "not_settable"  # code of the warning that no settings to type in are offered


@dataclass(frozen=True)
class Margin:
    """One requirement held against its limit, worst over the altitudes."""

    requirement: str
    value: float | None
    limit: float | None
    sense: str
    margin: float | None
    unit: str
    at_altitude_m: float | None
    satisfied: bool
    binding: bool
    word: str = ""  # in place of a value that is no number


@dataclass(frozen=True)
class SceneResult:
    """Settings, figures at the nominal altitude, and margins of one scene."""

    name: str
    settings: dict[str, float | None]
    settings_to_set: dict[str, float | None] | None  # rounded to what a person can set
    figures: dict[str, Any]
    margins: list[Margin]


@dataclass(frozen=True)
class Design:
    """One system with its settings."""

    hardware: dict[str, Any]
    objective_value: float | None
    feasible: bool
    totals: dict[str, Any]
    scenes: list[SceneResult]
    bom: list[dict[str, Any]]
    rounded: dict[str, Any] | None = None  # the settings to set, checked again
    warnings: list[dict[str, str]] = field(default_factory=list)

    def margins_frame(self) -> pd.DataFrame:
        """All margins as a table, one row a requirement and scene."""
        return frame_of({"margins": lambda: margin_rows(self)}, "margins")

    def figures_frame(self) -> pd.DataFrame:
        """All figures as a table, one column a scene."""
        return frame_of({"figures": lambda: figure_rows(self)}, "figures").set_index("figure")

    def bom_frame(self) -> pd.DataFrame:
        """The bill of materials as a table."""
        return frame_of({"bill": lambda: bill_rows(self)}, "bill")


@dataclass(frozen=True)
class Certificate:
    """How far the claim of an optimum reaches, and where every combination went."""

    lower_bound: float | None
    best_value: float | None
    gap_abs: float | None
    gap_rel: float | None
    complete: bool
    scope: str
    loaded: int
    selected: int
    evaluated: int
    discarded: list[dict[str, Any]]

    def adds_up(self) -> bool:
        """Whether every combination loaded is accounted for exactly once."""
        return self.loaded == self.evaluated + sum(item["count"] for item in self.discarded)

    def rows(self) -> list[dict[str, Any]]:
        """The account as rows: every combination is in one of them."""
        return [{"rule": "evaluated", "count": self.evaluated}, *map(dict, self.discarded)]


@dataclass(frozen=True, repr=False)
class Result(Shown):
    """What a command found, as it is written to result.json."""

    command: str
    status: str
    mission: dict[str, Any]
    physics: dict[str, Any]
    objective: dict[str, Any]
    uwopt_version: str
    recommendation: Design | None = None
    design: Design | None = None
    runners_up: list[Design] = field(default_factory=list)
    generic_alternative: Design | None = None
    certificate: Certificate | None = None
    infeasible: dict[str, Any] | None = None
    assumptions: list[dict[str, Any]] = field(default_factory=list)
    robustness: dict[str, Any] | None = None
    solvers: list[dict[str, Any]] = field(default_factory=list)  # second opinions on the settings
    audit: dict[str, Any] | None = None
    warnings: list[dict[str, str]] = field(default_factory=list)
    accuracy: dict[str, Any] = field(default_factory=dict)
    timing_s: dict[str, float] = field(default_factory=dict)
    seed: int = 0
    versions: dict[str, str] = field(default_factory=dict)
    schema: str = RESULT_SCHEMA
    alternatives: list[dict[str, Any]] = field(default_factory=list)  # other makers' best, and why not
    mission_file: dict[str, str] | None = None  # {name, folder, text} as the user wrote it
    system: dict[str, Any] | None = None  # what was evaluated, inline parts included

    @property
    def best(self) -> Design | None:
        """The recommendation, or the design that was evaluated."""
        return self.recommendation or self.design

    def frame(self, name: str = "margins") -> pd.DataFrame:
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
                "assumptions": lambda: list(self.assumptions),
                "warnings": lambda: list(self.warnings),
            },
            name,
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        data = plain(self)
        absent = (
            ("design", "system")
            if self.command == "solve"
            else ("recommendation", "certificate", "generic_alternative", "alternatives")
        )
        return {key: value for key, value in data.items() if key not in absent}

    def to_json(self) -> str:
        """The result file's text."""
        return json.dumps(self.to_dict(), indent=1, allow_nan=False, ensure_ascii=False)

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Result:
        """A result from plain values, as read from a result file."""
        known = {f.name for f in fields(Result)}
        values = {key: value for key, value in data.items() if key in known}
        for key in ("recommendation", "design", "generic_alternative"):
            if values.get(key):
                values[key] = design_from_dict(values[key])
        values["runners_up"] = [design_from_dict(item) for item in values.get("runners_up") or []]
        if values.get("certificate"):
            values["certificate"] = Certificate(**values["certificate"])
        return Result(**values)


def design_from_dict(data: Mapping[str, Any]) -> Design:
    """A design from plain values."""
    values = dict(data)
    values["scenes"] = [
        SceneResult(**{**scene, "margins": [Margin(**margin) for margin in scene["margins"]]})
        for scene in data["scenes"]
    ]
    return Design(**values)


def is_settable(design: Design) -> bool:
    """Whether no settings to set were looked for, or some were found with which every requirement holds."""
    return design.rounded is None or bool(design.rounded.get("feasible"))


def plain(value: Any) -> Any:
    """Dataclasses, arrays and NumPy numbers as plain values; what is not finite becomes None."""
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
