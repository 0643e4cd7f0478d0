"""How a report is laid out: titled blocks of sentences, facts and tables without lines.

Terminal and page are made from the same blocks: Rich prints them, the page turns them into HTML.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias, TypeVar, cast

from uwopt.report.text import formats, words
from uwopt.results.design import Note
from uwopt.units import counted

if TYPE_CHECKING:
    from rich import table, text
    from rich.console import Console, ConsoleOptions, RenderableType
    from rich.measure import Measurement

Row = TypeVar("Row")
INDENT = 2
#: Stands for a blank at which no line ends. Rich ends lines at no-break spaces too; a sign of nobody's it takes for a
#: letter, and `formats.printable` lets none through from a file.
SOLID = "\ue000"
UNBROKEN = ("id", "field")  # titles of columns whose text is copied, and must stay on one line


@dataclass(frozen=True)
class Text:
    """Running text; `style` is one of Rich's, such as `dim` or `bold red`."""

    plain: str
    style: str = ""

    def __rich__(self) -> text.Text:
        from rich.text import Text as RichText

        return RichText(formats.tied(self.plain, SOLID), self.style)


@dataclass(frozen=True)
class AtHyphens:
    """A cell whose words break at their hyphens where one is longer than its column, as ids of parts may be."""

    cell: Text

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        from rich.measure import Measurement

        return Measurement.get(console, options, self.cell.__rich__())

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[text.Text]:
        import textwrap

        told = self.cell.__rich__()
        if any(len(word) > options.max_width for word in told.plain.split()):
            told.plain = "\n".join(textwrap.wrap(told.plain, options.max_width))
        yield told


@dataclass
class Grid:
    """A table without lines; each head is (title, left | right)."""

    heads: tuple[tuple[str, str], ...]
    header: bool = True
    rows: list[tuple[Text, ...]] = field(default_factory=list)

    @property
    def row_count(self) -> int:
        """How many rows there are."""
        return len(self.rows)

    def add_row(self, *cells: Text) -> None:
        """One row more."""
        self.rows.append(cells)

    def __rich__(self) -> table.Table:
        from rich.table import Table

        made = Table(
            box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=self.header, header_style="dim"
        )
        for title, side in self.heads:
            made.add_column(
                Text(title).__rich__(), justify=cast(Literal["left", "right"], side), overflow="fold",
                no_wrap=side == "right" or title in UNBROKEN,
            )  # fmt: skip
        free = [side == "left" and title not in UNBROKEN for title, side in self.heads]
        for row in self.rows:
            made.add_row(*(AtHyphens(cell) if may else cell for cell, may in zip(row, free, strict=False)))
        return made


@dataclass(frozen=True)
class Facts:
    """Names and values below each other; a value without a name goes on from the one above."""

    pairs: tuple[tuple[str, str], ...]

    def __rich__(self) -> table.Table:
        grid = columns(("", "left"), ("", "left"), header=False)
        for name, value in self.pairs:
            grid.add_row(Text(name), Text(value))
        return grid.__rich__()


@dataclass(frozen=True)
class Joined:
    """Pieces of one line, each in its own style."""

    pieces: tuple[Text, ...]

    def __rich__(self) -> text.Text:
        from rich.text import Text as RichText

        return RichText.assemble(*(piece.__rich__() for piece in self.pieces))


Line: TypeAlias = Text | Joined | Grid | Facts


@dataclass(frozen=True)
class Block:
    """A heading and its lines, set in; an empty line ends it. Without a title the lines stand as they are."""

    title: str
    lines: tuple[Line, ...]

    def __rich__(self) -> RenderableType:
        from rich.console import Group
        from rich.padding import Padding

        lines = [Padding(line, (0, 0, 0, INDENT if self.title else 0)) for line in self.lines]
        head = [Text(self.title, "bold")] if self.title else []
        return Group(*head, *lines, Text(""))


def block(title: str, lines: Sequence[Line]) -> Block:
    """A heading, its lines set in, an empty line."""
    return Block(title, tuple(lines))


def sentence(text: str, style: str = "") -> Text:
    """Running text that wraps at words."""
    return Text(formats.one_line(text, 2000), style)


def columns(*heads: tuple[str, str], header: bool = True) -> Grid:
    """A table without lines; each head is (title, left | right)."""
    return Grid(heads, header)


def fact_lines(facts: Iterable[tuple[str, str]]) -> Facts:
    """Names and values below each other; what is empty is left out."""
    return Facts(tuple((name, formats.one_line(value, 2000)) for name, value in facts if value))


def more_in_files(number: int, noun: str) -> list[Text]:
    """That a table of points, say, shows so many less than there are; nothing where it shows all."""
    told = sentence(f"{counted(number, noun)} more in the files that --out DIR writes", "dim")
    return [told] if number > 0 else []


def evenly(rows: Sequence[Row], most: int) -> list[Row]:
    """All of these, or of more than a table shows the first, the last and some between."""
    if len(rows) <= most:
        return list(rows)
    return [rows[round(n * (len(rows) - 1) / (most - 1))] for n in range(most)]


def note_blocks(notes: Sequence[Note]) -> Iterator[Block]:
    """Remarks as sentences, where there are any."""
    if notes:
        yield block("Notes", [sentence(words.as_sentence(note.message)) for note in notes])
