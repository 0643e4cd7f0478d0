"""The command `uwopt report`: the page of a result, made again from its JSON."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwopt.cli.options import command_deadline, seconds_as
from uwopt.cli.output import tell_written
from uwopt.cli.status import DONE, command


@command
def report_command(
    result: Annotated[
        str, typer.Argument(metavar="RESULT.json", help="result.json or front.json, as --out wrote it.")
    ],
    out: Annotated[
        str | None,
        typer.Option(
            "--out", metavar="FILE|DIR", help="Page to write; report.html beside the result unless given."
        ),
    ] = None,
    seconds: Annotated[
        float | None, seconds_as("Stop after S seconds: pictures that there is no time for are left out.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no notes.")] = False,
) -> int:
    """Make the page of a result again: verdict, figures and margins from the file, pictures by the model."""
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import PAGE_FILE, check_page, page_in, write_page
    from uwopt.results.reading import read_result

    deadline = command_deadline(seconds)
    target = check_page(page_in(str(Path(result).parent) if out is None else out, PAGE_FILE))
    with ProgressBar(quiet=quiet) as bar:
        if bar.report is not None:
            bar.report(0.0, "making the report")
        written = write_page(read_result(result), target, deadline=deadline)
    tell_written([written], quiet=quiet)
    return DONE
