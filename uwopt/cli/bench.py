"""The command `uwopt bench`: error against run time on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwopt.cli import INTERRUPTED
from uwopt.cli.options import QuietOption, checked_seconds, folder_as, seconds_as
from uwopt.cli.output import tell_written
from uwopt.cli.status import DEFECT, DONE, command


@command
def bench_command(
    missions: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[MISSION]...",
            help="Missions for the solvers, or folders of them; the one of `uwopt init` unless given.",
        ),
    ] = None,
    quick: Annotated[
        bool,
        typer.Option("--quick", help="Few cases and seeds, within a minute; own missions may take longer."),
    ] = False,
    suite: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="Only spectral, quadrature, physics, solvers, pareto or scaling; repeatable."
        ),
    ] = None,
    seconds: Annotated[float | None, seconds_as("Share S seconds among the benchmarks.")] = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of everything random.")] = 0,
    out: Annotated[str | None, folder_as("Write bench.html, bench.json and CSV files into DIR.")] = None,
    quiet: QuietOption = False,
) -> int:
    """Measure error against run time on this machine: integrals, physics, solvers, fronts, catalogue size.

    Ctrl-C ends a run; what has been measured is kept.
    """
    from uwopt.report.text.console import ProgressBar, print_blocks
    from uwopt.report.write import check_folder

    if out is not None:
        check_folder(out)
    with ProgressBar(quiet=quiet, of_all=True) as bar:
        from uwopt.bench.page import bench_blocks, write_bench
        from uwopt.bench.run import Bench, mission_files, run

        written: list[Path] = []

        def keep(bench: Bench) -> None:
            if out is not None:
                written[:] = write_bench(bench, out)

        made = run(
            suite or (),
            quick=quick,
            seed=seed,
            seconds=checked_seconds(seconds),
            missions=mission_files(missions or ()),
            keep=keep,
            progress=bar.report,
        )
    print_blocks(iter(bench_blocks(made)))
    tell_written(written, quiet=quiet)
    if made.interrupted:
        return INTERRUPTED
    return DEFECT if made.faults else DONE
