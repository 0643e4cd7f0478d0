"""The command `uwopt sweep`: many missions, a row each."""

from __future__ import annotations

import os
from typing import Annotated

import typer

from uwopt.cli.options import (
    HoldPracticeOption,
    JsonOption,
    PhysicsOption,
    QuietOption,
    checked_seconds,
    folder_as,
    objective_as,
    parsed_objective,
    seconds_as,
    share_as,
)
from uwopt.cli.output import print_result, tell_written
from uwopt.cli.status import DONE, ENDS, command
from uwopt.cli.whatif import by_key


@command
def sweep_command(
    missions: Annotated[
        list[str],
        typer.Argument(
            metavar="MISSION|DIR|TABLE...",
            help="Mission files, folders of them, or a table (.csv, .parquet: a key a column) and a mission.",
        ),
    ],
    out: Annotated[
        str,
        folder_as("Folder for rows, sweep.parquet, sweep.csv, sweep.json and report.html; a later run goes on there."),
    ],
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=VALUES",
            help="A key of the mission and its values, such as speed_m_s=0.2:2:40 or water=I,II,1C; any number.",
        ),
    ] = None,
    system: Annotated[
        str | None,
        typer.Option(
            metavar="SYSTEM", help="Evaluate this system (YAML) in each mission instead of a search."
        ),
    ] = None,
    objective: Annotated[str | None, objective_as("What is to be best; the missions' unless given.")] = None,
    physics: PhysicsOption = None,
    confidence: Annotated[
        str | None, share_as("Share of scenarios in which hardware must hold; central, which is quick; or ends.")
    ] = None,
    pareto: Annotated[
        str | None,
        typer.Option(
            metavar="A,B[,C]",
            help="The trade-off of each mission between two or three objectives, a row a point, instead of the best.",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Processes on this machine; one a processor unless given."),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Send the work to a running Dask cluster, such as tcp://127.0.0.1:8786."
        ),
    ] = None,
    kits: Annotated[
        int,
        typer.Option(
            metavar="K",
            min=0,
            max=100,
            help="Try the K kits that win most often in every mission: few kits for many.",
        ),
    ] = 8,
    hold_practice: HoldPracticeOption = False,
    seconds: Annotated[
        float | None, seconds_as("Stop after S seconds; what is done is kept, and a later run goes on.")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> int:
    """Work out many missions: every combination of values, a folder of missions, or a row of a table each."""
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.text.sweep_tables import sweep_blocks
    from uwopt.report.write import check_folder

    wanted = None if objective is None else parsed_objective(objective)
    varied = by_key(vary or [])
    check_folder(out)
    with ProgressBar(quiet=quiet, of_all=True) as bar:
        from uwopt.sweeps.run import sweep

        made = sweep(
            missions, varied or None, out=out, system=system, objective=wanted, physics=physics and physics.value,
            confidence=confidence, pareto=pareto.split(",") if pareto else None, workers=workers or processors(),
            scheduler=scheduler, kits=kits, seconds=checked_seconds(seconds),
            hold_practice=hold_practice, progress=bar.report,
        )  # fmt: skip
    print_result(made, sweep_blocks, as_json=as_json, said=str)
    tell_written([out], quiet=quiet)
    return ENDS.get(made.status, DONE)


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
