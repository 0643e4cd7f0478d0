"""The command `uwopt card`: a page of settings to print, from a result."""

from __future__ import annotations

from typing import Annotated

import typer

from uwopt.cli.options import QuietOption
from uwopt.cli.output import print_made
from uwopt.cli.status import DONE, command


@command
def card_command(
    result: Annotated[str, typer.Argument(metavar="RESULT.json", help="result.json, as --out wrote it.")],
    out: Annotated[
        str | None, typer.Option("--out", metavar="FILE", help="Page to write, such as card.html; text is printed.")
    ] = None,
    quiet: QuietOption = False,
) -> int:
    """Print what to set at sea: per scene every setting, how far it may be off, and what to do in worse water."""
    from uwopt.report.card.page import card_html, card_of
    from uwopt.report.text.layout import block, sentence
    from uwopt.report.write import check_page, page_in, write_text
    from uwopt.results.reading import read_solved

    target = None if out is None else check_page(page_in(out, "card.html"))
    held = read_solved(result)
    card = card_of(held, result)
    written = [] if target is None else [write_text(card_html(held, card), target)]
    head = block(card.name, [sentence(card.hardware), sentence(card.verdict)])
    print_made((head, *card.blocks), written, mission=held.mission, quiet=quiet)
    return DONE
