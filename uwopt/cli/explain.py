"""The command `uwopt explain`: why nothing fits, and what would help; or what each requirement costs."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from uwopt.cli.options import (
    JsonOption,
    MissionArgument,
    PhysicsOption,
    QuietOption,
    command_deadline,
    seconds_as,
    time_to_answer,
)
from uwopt.cli.output import print_result
from uwopt.cli.status import command, result_status
from uwopt.errors import MissionError

HOLDS = "`uwopt whatif MISSION --vary KEY=VALUES --confidence 0.9` tells what more of a requirement costs then"


@command
def explain_command(
    mission: MissionArgument,
    physics: PhysicsOption = None,
    confidence: Annotated[str | None, typer.Option(hidden=True)] = None,  # as of `solve`: refused with what holds it
    seconds: Annotated[float | None, seconds_as("Time for all of it; more finds more that would help.")] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Say why nothing fits and what would help: how far each requirement, speed, height or water must move.

    Where something fits, say what each requirement costs: a step more of it, up to where it costs nothing, what would
    be best without it, and where another system takes over.
    """
    from uwopt.mission.doubt import CENTRAL
    from uwopt.quantities import AT_LIKELIEST
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.text.explanation import explanation_blocks

    deadline = command_deadline(seconds)
    if confidence not in (None, CENTRAL):
        raise MissionError(f"--confidence: explain tells all {AT_LIKELIEST}; {HOLDS}.")
    with ProgressBar(quiet=quiet) as bar:
        from uwopt.api.common import central_notes
        from uwopt.api.solving import solve
        from uwopt.mission.mission import load_mission

        asked = load_mission(mission)
        result = solve(
            asked, physics=physics and physics.value, confidence=CENTRAL, seconds=time_to_answer(deadline),
            quick=True, every_price=True, progress=bar.report,
        )  # fmt: skip
    result = replace(result, warnings=[*result.warnings, *central_notes(asked, HOLDS)])
    print_result(result, explanation_blocks, as_json=as_json)
    return result_status(result)
