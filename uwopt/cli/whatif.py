"""The command `uwopt whatif`: the optimum over values of the mission's keys."""

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
    objective_as,
    parsed_objective,
    seconds_as,
    share_as,
    time_to_answer,
)
from uwopt.cli.output import print_result, tell_written
from uwopt.cli.status import DONE, ENDS, command
from uwopt.errors import MissionError


@command
def whatif_command(
    mission: MissionArgument,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=VALUES",
            help="A key of the mission and its values, such as speed_m_s=0.2:2:40 or water=I,II,1C; once or twice.",
        ),
    ] = None,
    spider: Annotated[
        bool, typer.Option("--spider", help="Each number that the mission states alone, by 20 % either way.")
    ] = False,
    objective: Annotated[str | None, objective_as("What is to be best; the mission's unless given.")] = None,
    physics: PhysicsOption = None,
    confidence: Annotated[
        str | None, share_as("Share of scenarios in which each must hold, such as 0.9; else central.")
    ] = None,
    hold_practice: HoldPracticeOption = False,
    seconds: Annotated[float | None, seconds_as("Stop after S seconds; keep what is solved.")] = None,
    as_json: JsonOption = False,
    out: Annotated[str | None, folder_as("Write report.html, whatif.csv, .json and .parquet into DIR.")] = None,
    quiet: QuietOption = False,
) -> int:
    """Solve the mission at many values of its keys: the optimum, and where another system takes over."""
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.text.whatif_tables import whatif_blocks
    from uwopt.report.write import check_folder, write_whatif
    from uwopt.solvers.beside import cores

    deadline = command_deadline(seconds)
    wanted = None if objective is None else parsed_objective(objective)
    varied = by_key(vary or [])
    if out is not None:
        check_folder(out)
    with ProgressBar(quiet=quiet) as bar, cores():
        from uwopt.api.whatif import whatif

        table = whatif(
            mission, varied, spider=spider, objective=wanted, physics=physics and physics.value,
            confidence=confidence, seconds=time_to_answer(deadline, writes=out is not None),
            hold_practice=hold_practice, progress=bar.report,
        )  # fmt: skip
    print_result(table, whatif_blocks, as_json=as_json)
    if out is not None:
        tell_written(write_whatif(table, out), quiet=quiet)
    return ENDS.get(table.status, DONE)


def by_key(words: list[str], option: str = "--vary") -> dict[str, str]:
    """`KEY=VALUES` of every --vary, or of another option."""
    made: dict[str, str] = {}
    for word in words:
        key, sign, values = word.partition("=")
        if not sign or not key.strip() or not values.strip():
            raise MissionError(
                f"{option} {word!r}: is no key with values; write such as speed_m_s=0.2:2:40 (from:to:how many) or "
                "water=I,II,1C"
            )
        if key.strip() in made:
            raise MissionError(f"{option}: {key.strip()} stands twice; give all its values at once")
        made[key.strip()] = values
    return made
