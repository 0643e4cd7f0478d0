"""How text for the terminal is laid out: titled blocks, tables without lines, sentences that wrap."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal, cast

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from uwopt.report import words

INDENT = 2
UNBROKEN = ("id", "field")  # titles of columns whose text is copied, and must stay on one line


def block(title: str, lines: Sequence[RenderableType]) -> RenderableType:
    """A heading, its lines set in, an empty line."""
    return Group(Text(title, "bold"), *(Padding(line, (0, 0, 0, INDENT)) for line in lines), Text(""))


def sentence(text: str, style: str = "") -> Text:
    """Running text that wraps at words."""
    return Text(words.one_line(text, 2000), style)


def columns(*heads: tuple[str, str], header: bool = True) -> Table:
    """A table without lines; each head is (title, left | right)."""
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=header, header_style="dim")
    for title, side in heads:
        justify = cast(Literal["left", "right"], side)
        table.add_column(
            Text(title), justify=justify, no_wrap=side == "right" or title in UNBROKEN, overflow="fold"
        )
    return table


def fact_lines(facts: Iterable[tuple[str, str]]) -> RenderableType:
    """Names and values below each other; what is empty is left out."""
    table = columns(("", "left"), ("", "left"), header=False)
    for name, value in facts:
        if value:
            table.add_row(Text(name), Text(words.one_line(value, 2000)))
    return table
