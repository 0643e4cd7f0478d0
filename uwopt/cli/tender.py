"""The commands `uwopt tender` and `uwopt quotes`: ask makers, and decide again with their answers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwopt.cli.options import (
    MissionArgument,
    PhysicsOption,
    QuietOption,
    command_deadline,
    folder_as,
    seconds_as,
)
from uwopt.cli.output import print_made, tell_written
from uwopt.cli.status import DONE, command, print_notice, result_status


@command
def tender_command(
    result: Annotated[str, typer.Argument(metavar="RESULT.json", help="result.json, as --out wrote it.")],
    out: Annotated[str, folder_as("Write tender.xlsx, letter.txt and not-for-makers.txt into DIR.")],
    seconds: Annotated[
        float | None, seconds_as("Stop after S seconds: parts that are not begun by then go without limits.")
    ] = None,
    quiet: QuietOption = False,
) -> int:
    """Write what makers are asked: per part what it must fulfil, with cells for their answers, and a letter."""
    from uwopt.report.order.tender_book import (
        BOOK_FILE,
        BUYER_FILE,
        LETTER_FILE,
        kept_back,
        letter,
        tender_book,
    )
    from uwopt.report.order.tender_lines import falls_short, lines_of
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import check_folder, made_folder, write_files
    from uwopt.results.reading import read_solved

    deadline = command_deadline(seconds)
    folder = check_folder(out)
    held = read_solved(result)
    with ProgressBar(quiet=quiet) as bar:
        if bar.report is not None:
            bar.report(0.0, "what each part must fulfil")
        lines = lines_of(held, result, deadline)
    files: dict[str, str | bytes] = {
        BOOK_FILE: tender_book(held, lines), LETTER_FILE: letter(held, lines), BUYER_FILE: kept_back(lines),
    }  # fmt: skip
    written = write_files(made_folder(folder), files)
    if not quiet:
        if short := falls_short(held):
            print_notice(f"{short}.", DONE)
        tell_written(written, quiet=quiet)
        if deadline.left_out:
            print_notice(f"no time was left for {', '.join(deadline.left_out)}; more --seconds find them", DONE)
    return DONE


@command
def quotes_command(
    mission: MissionArgument,
    answers: Annotated[
        str, typer.Argument(metavar="ANSWERS", help="tender.xlsx as makers filled it in, or a CSV of its columns.")
    ],
    out: Annotated[str | None, folder_as("Keep the answers as quotes.csv in DIR, and the new result.")] = None,
    date: Annotated[str, typer.Option(help="Day on which the answers are read, YYYY-MM-DD; today unless given.")] = "",
    physics: PhysicsOption = None,
    quiet: QuietOption = False,
) -> int:
    """Read makers' answers as own parts and prices, solve again, and say what changed and why."""
    from datetime import date as calendar

    from uwopt.report.order.answers import answer_blocks
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import check_folder, made_folder, write_results, write_text

    folder = None if out is None else check_folder(out)
    with ProgressBar(quiet=quiet) as bar:
        from uwopt.api.quoting import LOG_FILE, with_quotes

        kept: list[Path] = []

        def keep(log: str) -> Path:
            assert folder is not None
            kept.append(write_text(log, made_folder(folder) / LOG_FILE))
            return kept[0].absolute()

        made = with_quotes(
            mission, answers, today=date or calendar.today().isoformat(), keep=None if folder is None else keep,
            physics=physics and physics.value, progress=bar.report,
        )  # fmt: skip
    written = kept if folder is None else [*kept, *write_results(made.after, folder)]
    print_made(answer_blocks(made), written, mission=made.after.mission, quiet=quiet)
    return result_status(made.after)
