"""The command `uwopt`: arguments in, results out, and the exit status.

Nothing heavy is imported before a command runs, so that help is there at once.
"""

from __future__ import annotations

import gc
import os
import re
import signal
import sys
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer
import typer.core

from uwopt.catalog.edition import AS_OF, EDITION
from uwopt.cli import INTERRUPTED, NO_RESULT
from uwopt.cli.bench import bench_command
from uwopt.cli.calibrate import calibrate_command
from uwopt.cli.card import card_command
from uwopt.cli.catalog import catalog_app
from uwopt.cli.compare import compare_command
from uwopt.cli.explain import explain_command
from uwopt.cli.explore import explore_command
from uwopt.cli.options import (
    AccuracyOption,
    FullOption,
    HoldPracticeOption,
    JsonOption,
    MissionArgument,
    PhysicsOption,
    QuietOption,
    ToleranceOption,
    command_deadline,
    folder_as,
    objective_as,
    parsed_objective,
    seconds_as,
    share_as,
    time_to_answer,
)
from uwopt.cli.output import hand_over, print_first
from uwopt.cli.pareto import pareto_command
from uwopt.cli.plot import plot_command
from uwopt.cli.report import report_command
from uwopt.cli.status import BAD_INPUT, DONE, EXIT_STATUS, command, print_notice, result_status
from uwopt.cli.sweep import sweep_command
from uwopt.cli.tender import quotes_command, tender_command
from uwopt.cli.whatif import whatif_command
from uwopt.results.version import __version__

if TYPE_CHECKING:
    from uwopt.results.result import Result


class PlainGroup(typer.core.TyperGroup):
    """Commands whose refusals of an argument say what is wrong, without the name of an exception before it."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that is named; its own arguments are read here."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:  # before the work of a command, which tells it itself
            raise typer.Exit(print_notice(NO_RESULT, INTERRUPTED)) from None
        except Exception as fault:
            if isinstance(said := getattr(fault, "message", None), str):
                for theirs, ours in PLAIN_WORDS:
                    said = re.sub(theirs, ours, said)
                fault.message = said  # pyrefly: ignore[missing-attribute]
            raise


GARBAGE_AFTER = 250_000  # objects, so that Python seldom looks for circles, of which a search makes few: 7 % of time
#: What Pydantic says, by which Typer reads words and numbers, in ours.
PLAIN_WORDS = (
    ("^Value error, ", ""), (", unable to parse string as an? .*", ""), ("^Input should be", "it must be"),
    ("a valid number", "a number without a unit"), ("a valid integer", "a whole number"),
    ("greater than or equal to", "at least"), ("less than or equal to", "at most"),
)  # fmt: skip
app = typer.Typer(
    name="uwopt",
    cls=PlainGroup,
    help="From an underwater imaging mission to a camera system that can be bought, with a proof.",
    epilog=EXIT_STATUS,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
    no_args_is_help=True,
)
app.add_typer(catalog_app, name="catalog")


class Solver(StrEnum):
    """How the settings of the best hardware are solved."""

    exact = "exact"
    casadi = "casadi"
    nlopt = "nlopt"
    bonmin = "bonmin"


class DocumentKind(StrEnum):
    """Files that a person writes."""

    mission = "mission"
    system = "system"


OutOption = Annotated[
    str | None, folder_as("Write result.json, system.yaml, bom.csv, bom.xlsx and report.html into DIR.")
]


# ---------------------------------------------------------------- solve and evaluate


@app.command("solve", short_help="Find the best system, and prove it.")
@command
def solve_command(
    mission: MissionArgument,
    solver: Annotated[
        Solver,
        typer.Option(
            help="exact proves the optimum; casadi and nlopt solve the settings again, bonmin hardware and settings."
        ),
    ] = Solver.exact,
    objective: Annotated[
        str | None, objective_as("What is to be best, such as cost, best_image or power=1,cost=0.01.")
    ] = None,
    physics: PhysicsOption = None,
    confidence: Annotated[
        str | None, share_as("Share of scenarios in which hardware must hold, such as 0.9; central (none) or ends.")
    ] = None,
    top: Annotated[int, typer.Option(metavar="K", min=1, max=1000, help="How many systems to list.")] = 5,
    audit: Annotated[
        int,
        typer.Option(
            metavar="N", min=0, max=1_000_000, help="Try N other combinations, half of them discarded."
        ),
    ] = 0,
    hold_practice: HoldPracticeOption = False,
    seconds: Annotated[
        float | None, seconds_as("Stop after S seconds; the gap and what is left out are told.")
    ] = None,
    accuracy: AccuracyOption = False,
    tolerance: ToleranceOption = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Leave out how firm the answer is, and second opinions.")
    ] = False,
    full: FullOption = False,
    as_json: JsonOption = False,
    out: OutOption = None,
    quiet: QuietOption = False,
) -> int:
    """Find the best system of the catalogue for a mission, and prove it."""
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import check_folder
    from uwopt.solvers.beside import cores

    deadline = command_deadline(seconds)
    wanted = None if objective is None else parsed_objective(objective)
    if out is not None:
        check_folder(out)
    begun: list[Result] = []
    with ProgressBar(quiet=quiet) as bar, cores():
        from uwopt.api import solving as api

        def first(result: Result) -> None:
            print_first(result, bar)
            begun.append(result)

        result = api.solve(
            mission,
            solver=solver.value,
            objective=wanted,
            physics=physics and physics.value,
            confidence=confidence,
            top=top,
            audit=audit,
            seconds=time_to_answer(deadline, writes=out is not None),
            alternatives=out is not None,
            ranges=out is not None,
            accuracy=accuracy,
            tolerance=tolerance,
            progress=bar.report,
            quick=quick,
            first=None if as_json or full else first,
            so_far=bar.line,
            hold_practice=hold_practice,
        )
    hand_over(result, full=full, as_json=as_json, out=out, quiet=quiet, begun=bool(begun), deadline=deadline)
    return result_status(result)


@app.command("evaluate", short_help="Say what a given system would do.")
@command
def evaluate_command(
    mission: MissionArgument,
    system: Annotated[
        str, typer.Argument(metavar="SYSTEM", help="System file (YAML); `uwopt init --system` writes one.")
    ],
    physics: PhysicsOption = None,
    check: Annotated[
        bool, typer.Option("--check", help="Exit with status 3 when a requirement is missed.")
    ] = False,
    accuracy: AccuracyOption = False,
    tolerance: ToleranceOption = None,
    confidence: Annotated[
        str | None, share_as("Count in how many scenarios it holds, against this share; or ends.")
    ] = None,
    seconds: Annotated[
        float | None, seconds_as("Time for --accuracy and --confidence: what it does not reach is left out.")
    ] = None,
    full: FullOption = False,
    as_json: JsonOption = False,
    out: OutOption = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No notes.")] = False,
) -> int:
    """Say what a given system would do in a mission: figures and margins."""
    from uwopt.report.write import check_folder

    deadline = command_deadline(seconds)
    if out is not None:
        check_folder(out)
    from uwopt.api.evaluating import evaluate

    result = evaluate(
        mission, system, physics=physics and physics.value, accuracy=accuracy, tolerance=tolerance,
        confidence=confidence, seconds=time_to_answer(deadline, writes=out is not None),
    )  # fmt: skip
    hand_over(result, full=full, as_json=as_json, out=out, quiet=quiet, deadline=deadline)
    return result_status(result, check=check)


app.command("pareto", short_help="Trade two or three objectives: the whole front.")(pareto_command)
app.command("explain", short_help="Say why nothing fits, or what each requirement costs.")(explain_command)
app.command("whatif", short_help="Vary the mission: the optimum, and where another system wins.")(whatif_command)
app.command("explore", short_help="Explore the design space in a page.")(explore_command)
app.command("plot", short_help="Draw one plot of a system in a mission.")(plot_command)
app.command("sweep", short_help="Many missions: a row each, on all processors.")(sweep_command)
app.command("bench", short_help="Measure error against run time on this machine.")(bench_command)
app.command("report", short_help="Make the page of a result again.")(report_command)
app.command("tender", short_help="Write what makers are asked for.")(tender_command)
app.command("quotes", short_help="Decide again with makers' answers.")(quotes_command)
app.command("compare", short_help="Hold systems against each other.")(compare_command)
app.command("calibrate", short_help="Fit test shots; a mission with what they tell.")(calibrate_command)
app.command("card", short_help="Print what to set at sea, on one page.")(card_command)

# ---------------------------------------------------------------- init and schema


@app.command("init", short_help="Write a mission to start from.")
@command
def init_command(
    file: Annotated[
        str | None, typer.Argument(metavar="FILE", help="File to write; printed when left out.")
    ] = None,
    system: Annotated[bool, typer.Option("--system", help="A system file instead of a mission.")] = False,
) -> None:
    """Write a mission with comments to start from; an existing file is left alone."""
    from uwopt.mission.templates import mission_template, system_template
    from uwopt.report.text.console import print_text
    from uwopt.report.write import write_new

    text = system_template() if system else mission_template()
    if file in (None, "-"):
        print_text(text.rstrip("\n"))
        return
    print_notice(f"written: {write_new(str(file), text)}", DONE)


@app.command("schema", short_help="Print a JSON schema for editors.")
@command
def schema_command(
    document: Annotated[
        DocumentKind, typer.Argument(help="Which file the schema is for.")
    ] = DocumentKind.mission,
) -> None:
    """Print the JSON schema of a mission or system file, for editors."""
    from uwopt.mission.templates import mission_json_schema, system_json_schema
    from uwopt.report.text.console import print_json

    print_json(mission_json_schema() if document is DocumentKind.mission else system_json_schema())


# ---------------------------------------------------------------- the program


def print_version(wanted: bool) -> None:
    """Print the version and leave."""
    if wanted:
        typer.echo(f"uwopt {__version__}, catalogue {EDITION} of {AS_OF}")
        raise typer.Exit(DONE)


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """From an underwater imaging mission to a camera system that can be bought, with a proof."""
    del version


def main() -> None:
    """The program `uwopt`."""
    # Its products of matrices are small: threads would wait for each other, on a busy machine a hundred times as long.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # to find them it reads every installed package's list
    gc.set_threshold(GARBAGE_AFTER)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # `timeout` and queues end it as a person does: by Ctrl-C
    if not sys.warnoptions and os.environ.get("UWOPT_DEBUG") != "1":
        import warnings

        warnings.simplefilter("ignore")
    try:
        app()
    except OSError as fault:  # help and version are printed by typer itself
        from uwopt.report.text.console import discard_rest

        discard_rest(sys.stdout)
        sys.exit(print_notice(f"standard output cannot be written ({fault.strerror or fault}).", BAD_INPUT, fault))


if __name__ == "__main__":
    main()
