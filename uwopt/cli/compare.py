"""The command `uwopt compare`: systems side by side in one mission."""

from __future__ import annotations

from typing import Annotated

import typer

from uwopt.cli.options import (
    MissionArgument,
    PhysicsOption,
    QuietOption,
    command_deadline,
    folder_as,
    seconds_as,
    time_to_answer,
)
from uwopt.cli.output import print_made
from uwopt.cli.status import DONE, command


@command
def compare_command(
    mission: MissionArgument,
    systems: Annotated[list[str], typer.Argument(metavar="SYSTEM...", help="System files (YAML), one or more.")],
    recommended: Annotated[
        bool, typer.Option("--recommended", help="Beside them what solve recommends.")
    ] = False,
    physics: PhysicsOption = None,
    seconds: Annotated[float | None, seconds_as("Time for the search of what solve recommends.")] = None,
    out: Annotated[str | None, folder_as("Write compare.html and compare.csv into DIR.")] = None,
    quiet: QuietOption = False,
) -> int:
    """Hold systems against a mission side by side, requirement by requirement."""
    from uwopt.report.compare.page import PAGE, TABLE, comparison_blocks, comparison_csv, comparison_html
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import check_folder, made_folder, write_files

    deadline = command_deadline(seconds)
    folder = None if out is None else check_folder(out)
    with ProgressBar(quiet=quiet) as bar:
        from uwopt.api.comparing import compare

        made = compare(
            mission, systems, recommended=recommended, physics=physics and physics.value,
            seconds=time_to_answer(deadline, writes=out is not None), progress=bar.report,
        )  # fmt: skip
    written = []
    if folder is not None:
        files = {PAGE: comparison_html(made), TABLE: comparison_csv(made)}
        written = write_files(made_folder(folder), files)
    print_made(comparison_blocks(made), written, mission=made.systems[0].result.mission, quiet=quiet)
    return DONE
