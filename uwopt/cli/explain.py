"""The command `uwopt explain`: why nothing fits, and what would help; or what each requirement costs."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from uwopt.cli.options import (
    JsonOption,
    MissionArgument,
    PhysicsOption,
    QuietOption,
    limit_of,
    time_to_answer,
)
from uwopt.cli.status import command, result_status


@command
def explain_command(
    mission: MissionArgument,
    physics: PhysicsOption = None,
    seconds: Annotated[
        float | None, typer.Option(metavar="S", help="Time for all of it; more finds more that would help.")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Say why nothing fits and what would help: how far each requirement, speed, height or water must move.

    Where something fits, say what each requirement costs: a step more of it, up to where it costs nothing, what would
    be best without it, and where another system takes over.
    """
    from uwopt.report.text.console import ProgressBar, print_blocks, print_text
    from uwopt.report.text.explanation import explanation_blocks
    from uwopt.report.text.looked_at import wording_of
    from uwopt.report.write import json_text

    deadline = limit_of(seconds)
    with ProgressBar(quiet=quiet) as bar:
        from uwopt.api.solving import solve

        result = solve(
            mission, physics=physics and physics.value, confidence="central", seconds=time_to_answer(deadline),
            quick=True, every_price=True, progress=bar.report,
        )  # fmt: skip
    if as_json:
        print_text(json_text(result, getattr(sys.stdout, "encoding", None) or "utf-8"))
    else:
        print_blocks(explanation_blocks(result), said=wording_of(result))
    return result_status(result)
