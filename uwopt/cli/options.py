"""Arguments and options that several commands share."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated, Any

import typer

from uwopt.deadline import Deadline
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
HoldPracticeOption = Annotated[
    bool,
    typer.Option("--hold-practice", help="Hold all of good practice, where nothing meets it too: none is relaxed."),
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no notes.")]


def seconds_as(told: str) -> Any:
    """An option of a time, told in a command's own words."""
    return typer.Option(metavar="S", help=told)


def folder_as(told: str) -> Any:
    """An option of a folder to write into, told in a command's own words."""
    return typer.Option("--out", metavar="DIR", help=told)


def share_as(told: str) -> Any:
    """An option of a share of scenarios, told in a command's own words."""
    return typer.Option(metavar="P", help=told)


def objective_as(told: str) -> Any:
    """An option of what is to be best, told in a command's own words."""
    return typer.Option(metavar="NAME|WEIGHTS", help=told)


WRITE_S, PRINT_S = 2.0, 0.3  # at most, of a time that is given: for what follows the answer
AFTER_SHARE = 0.25  # of a short time, instead


def command_deadline(seconds: float | None) -> Deadline:
    """When a command's time is over, which runs from now on: what it takes to load a program is of it."""
    return Deadline.after(checked_seconds(seconds))


def time_to_answer(limit: Deadline, *, writes: bool = False) -> float | None:
    """Seconds that an answer may take of a command's time, so that what is written and printed then is in time too."""
    if math.isinf(limit.left_s):
        return None
    return limit.left_s - min(WRITE_S if writes else PRINT_S, AFTER_SHARE * limit.left_s)


def checked_seconds(seconds: float | None) -> float | None:
    """A time limit above 0."""
    if seconds is not None and not (math.isfinite(seconds) and seconds > 0):
        raise MissionError(f"--seconds = {seconds:g} is not a time above 0; leave it out for no limit.")
    return seconds


def parsed_objective(text: str) -> str | dict[str, float]:
    """`power`, or weights by name from `power=1,cost=0.01`."""
    from uwopt.documents.faults import nearest
    from uwopt.mission.best_image import NAME as BEST_IMAGE
    from uwopt.mission.keys import OBJECTIVES

    def known(name: str) -> str:
        plain = name.strip().casefold().replace("-", "_")
        if plain == BEST_IMAGE and "=" not in text:
            return plain
        if plain not in OBJECTIVES:
            near = nearest(plain, (*OBJECTIVES, BEST_IMAGE))
            hint = f"did you mean {near}?" if near else f"there are {', '.join((*OBJECTIVES, BEST_IMAGE))}."
            raise MissionError(f"--objective: {name.strip()!r} is no figure that can be best; {hint}")
        return plain

    if "=" not in text:
        return known(text)
    weights: dict[str, float] = {}
    for item in text.split(","):
        name, _, number = item.partition("=")
        try:
            weight = float(number)
        except ValueError:
            weight = math.nan
        if not (math.isfinite(weight) and weight >= 0):
            raise MissionError(
                f"--objective: {item.strip()!r} must be a name and a weight of 0 or above, such as power=1,cost=0.01"
            )
        if known(name) in weights:
            raise MissionError(f"--objective: {known(name)} stands twice; give one weight a figure.")
        weights[known(name)] = weight
    if not any(weights.values()):
        raise MissionError("--objective: no weight is above 0; write such as power=1,cost=0.01")
    return weights
