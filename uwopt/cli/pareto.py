"""The command `uwopt pareto`: the trade-off between two or three objectives."""

from __future__ import annotations

from typing import Annotated

import typer

from uwopt.cli.options import (
    HoldPracticeOption,
    JsonOption,
    MissionArgument,
    PhysicsOption,
    QuietOption,
    command_deadline,
    folder_as,
    seconds_as,
    time_to_answer,
)
from uwopt.cli.output import hand_over
from uwopt.cli.status import command, front_status

AT_ONCE_S = 1e-6  # where loading the program took all of a time: the search stops at once, and says so


@command
def pareto_command(
    mission: MissionArgument,
    objectives: Annotated[
        str,
        typer.Option(
            metavar="A,B[,C]",
            help="Two or three of power, cost, mass, snr_db, gsd_mm, contrast, information.",
        ),
    ] = "power,cost,information",
    solver: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help="exact, and pymoo's nsga2, nsga3, unsga3, ctaea, rvea, spea2 or smsemoa; several by commas.",
        ),
    ] = "exact,nsga2",
    physics: PhysicsOption = None,
    seconds: Annotated[
        float | None, seconds_as("Stop after S seconds, shared by the solvers; keep what they have.")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(metavar="N", help="Seed of pymoo; the mission's unless given.")
    ] = None,
    hold_practice: HoldPracticeOption = False,
    as_json: JsonOption = False,
    out: Annotated[str | None, folder_as("Write report.html, front.csv and front.json into DIR.")] = None,
    quiet: QuietOption = False,
) -> int:
    """Find the designs of which none is better than another in every objective."""
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import check_folder
    from uwopt.solvers.beside import cores

    deadline = command_deadline(seconds)
    if out is not None:
        check_folder(out)
    with ProgressBar(quiet=quiet, of_all=True) as bar, cores():
        from uwopt.api.trading import pareto

        left_s = time_to_answer(deadline, writes=out is not None)
        front = pareto(
            mission,
            objectives=objectives.split(","),
            solver=solver,
            seconds=None if left_s is None else max(left_s, AT_ONCE_S),
            seed=seed,
            physics=physics and physics.value,
            alternatives=out is not None,
            hold_practice=hold_practice,
            progress=bar.report,
        )
    with cores():
        hand_over(front, as_json=as_json, out=out, quiet=quiet, deadline=deadline)
    return front_status(front)
