"""Arguments and options that several commands share."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated

import typer

from uwopt.errors import MissionError


class Physics(StrEnum):
    """How much physics takes part."""

    auto = "auto"
    full = "full"
    paper = "paper"


MissionArgument = Annotated[
    str, typer.Argument(metavar="MISSION", help="Mission file (YAML); `uwopt init` writes one.")
]
PhysicsOption = Annotated[
    Physics | None, typer.Option(help="Physics of the model; the mission's unless given.")
]
AccuracyOption = Annotated[
    bool, typer.Option("--accuracy", help="Estimate the numerical error of every figure.")
]
ToleranceOption = Annotated[
    float | None,
    typer.Option(metavar="SHARE", help="Largest error of any figure, such as 0.001; coarser is faster."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the result as JSON and nothing else.")]
FullOption = Annotated[
    bool,
    typer.Option("--full", help="Print all there is: proof, every requirement, other choices, assumptions."),
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no notes.")]


def checked_seconds(seconds: float | None) -> float | None:
    """A time limit above 0."""
    if seconds is not None and not (math.isfinite(seconds) and seconds > 0):
        raise MissionError(f"--seconds = {seconds:g} is not a time above 0; leave it out for no limit.")
    return seconds
