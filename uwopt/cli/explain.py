"""The command `uwopt explain`: why nothing fits, and what would help; or what each requirement costs."""

from __future__ import annotations

from typing import Annotated

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


@command
def explain_command(
    mission: MissionArgument,
    physics: PhysicsOption = None,
    seconds: Annotated[float | None, seconds_as("Time for all of it; more finds more that would help.")] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Say why nothing fits and what would help: how far each requirement, speed, height or water must move.

    Where something fits, say what each requirement costs: a step more of it, up to where it costs nothing, what would
    be best without it, and where another system takes over.
    """
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.text.explanation import explanation_blocks

    deadline = command_deadline(seconds)
    with ProgressBar(quiet=quiet) as bar:
        from uwopt.api.solving import solve

        result = solve(
            mission, physics=physics and physics.value, confidence="central", seconds=time_to_answer(deadline),
            quick=True, every_price=True, progress=bar.report,
        )  # fmt: skip
    print_result(result, explanation_blocks, as_json=as_json)
    return result_status(result)
