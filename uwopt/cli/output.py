"""What a command does with its result: write the files, print it, say where it is."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwopt.cli.status import DONE, print_notice
from uwopt.deadline import NEVER, Deadline
from uwopt.errors import OutputError

if TYPE_CHECKING:
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.text.layout import Block
    from uwopt.results.front import FrontResult
    from uwopt.results.result import Result


PAGE_S = 0.7  # of a time that is given, for the page around its pictures, of which the last may end late


def print_first(result: Result, bar: ProgressBar) -> None:
    """Print what the page begins with, while what follows is worked out."""
    from uwopt.report.text.console import print_blocks
    from uwopt.report.text.looked_at import wording_of
    from uwopt.report.text.short import first_text_blocks

    with bar.aside():
        print_blocks(first_text_blocks(result), said=wording_of(result))


def hand_over(
    result: Result | FrontResult, *, as_json: bool, out: str | None, quiet: bool, full: bool = False,
    begun: bool = False, deadline: Deadline = NEVER,
) -> None:  # fmt: skip
    """Write the files and print the result, on one page or in full; what cannot be written is printed all the same.

    begun : the page's beginning stands there already, by `print_first`
    deadline : past which the report does without pictures, which is told
    """
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import write_front, write_results
    from uwopt.results.result import Result

    written, refused = [], None
    pictures = replace(deadline, end_s=deadline.end_s - PAGE_S)
    try:
        with ProgressBar(quiet=quiet) as bar:
            if bar.report is not None:
                bar.report(0.0, "writing the report")
            if out is None:
                pass
            elif isinstance(result, Result):
                written = write_results(result, out, deadline=pictures)
            else:
                written = write_front(result, out, deadline=pictures)
    except OutputError as fault:
        refused = fault
    print_result(result, partial(blocks_of, full=full, begun=begun, has_page=bool(written)), as_json=as_json)
    if refused is not None:
        raise refused
    if written and not quiet:
        tell_written(written, quiet=quiet)
        if isinstance(result, Result) and result.command == "solve" and result.best is not None:
            command = f"uwopt tender {out}/result.json --out {out}/tender"
            print_notice(f"to ask makers for quotes, sheets and a letter: {command}", DONE)
    if deadline.left_out:
        print_notice(no_time_for(deadline), DONE)


def blocks_of(result: Result | FrontResult, *, full: bool, begun: bool, has_page: bool) -> Iterable[Any]:
    """What is printed of a result, on one page or in full; `begun`: without what stands there already."""
    from uwopt.results.result import Result

    if not isinstance(result, Result):
        from uwopt.report.text.front_tables import front_blocks

        return front_blocks(result)
    from uwopt.report.text.short import full_text_blocks, rest_text_blocks, short_text_blocks

    if full:
        return full_text_blocks(result)
    shown = rest_text_blocks if begun else short_text_blocks
    return shown(result, has_page=has_page)


def print_result(
    made: Any, blocks: Callable[[Any], Iterable[Any]], *, as_json: bool, said: Callable[[str], str] | None = None
) -> None:
    """Print a result as JSON and nothing else, or as blocks; `said`: other words than those of what is looked at."""
    from uwopt.report.text.console import print_blocks, print_text
    from uwopt.report.text.looked_at import wording_of
    from uwopt.report.write import json_text

    if as_json:
        print_text(json_text(made, getattr(sys.stdout, "encoding", None) or "utf-8"))
    else:
        print_blocks(blocks(made), said=wording_of(made) if said is None else said)


def tell_written(files: Sequence[object], *, quiet: bool) -> None:
    """Tell which files were written, if any."""
    if files and not quiet:
        print_notice("written: " + ", ".join(map(str, files)), DONE)


def no_time_for(deadline: Deadline) -> str:
    """What a page does without, and how to make it."""
    return f"no time was left for {', '.join(dict.fromkeys(deadline.left_out))}; `uwopt report` makes them."


def print_made(blocks: Sequence[Block], written: Sequence[Path], *, mission: Mapping[str, Any], quiet: bool) -> None:
    """Print blocks in the words of what is looked at, and which files were written."""
    from uwopt.report.text.console import print_blocks
    from uwopt.report.text.looked_at import wording

    print_blocks(blocks, said=wording(mission))
    tell_written(written, quiet=quiet)
