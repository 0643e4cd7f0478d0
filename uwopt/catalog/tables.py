"""Reading CSV tables with their line numbers, and the folder of built-in data.

A table is a CSV with `#` comment lines and one header row. Nothing is converted here.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from uwopt.documents.faults import show
from uwopt.documents.files import UnfitFileError, content, other_kind
from uwopt.errors import CatalogError

DATA_DIR = Path(__file__).parent / "data"
MOST_NAMED = 6  # columns in a message


@dataclass(frozen=True, slots=True)
class Row:
    """One row of a table: its cells by column, stripped, and where it stands."""

    file: str
    line: int
    cells: dict[str, str]

    def where(self) -> str:
        """File, line and, where the row has one, the id: the start of every message."""
        part_id = self.cells.get("id", "")
        return f"{self.file} row {self.line}" + (f" ({part_id})" if part_id else "")


@dataclass(frozen=True, slots=True)
class Table:
    """Header and rows of one CSV file."""

    file: str
    header: tuple[str, ...]
    rows: tuple[Row, ...]
    faults: tuple[str, ...] = ()


class _NumberedLines:
    """Lines without comments; remembers the physical number of the last one handed out."""

    def __init__(self, lines: Iterable[str]):
        self.number = 0
        self._lines = lines

    def __iter__(self) -> Iterator[str]:
        for number, line in enumerate(self._lines, start=1):
            if line.lstrip().startswith("#"):
                continue
            self.number = number
            yield line


def read_text(path: Path) -> str:
    """Text of a file that a person or a spreadsheet wrote; a byte order mark is dropped."""
    try:
        raw = content(path)
        if kind := other_kind(raw):
            raise CatalogError(f"{path}: is {kind}, no table; export the table from its program as 'CSV UTF-8'.")
        return raw.decode("utf-8-sig")
    except FileNotFoundError:
        raise CatalogError(f"{path}: no such file; paths in a mission start from its folder.") from None
    except IsADirectoryError:
        raise CatalogError(f"{path}: is a folder; name a CSV or YAML file.") from None
    except UnicodeDecodeError as fault:
        raise CatalogError(
            f"{path}: is not UTF-8 text (byte {fault.start}); export it from the spreadsheet as 'CSV UTF-8'."
        ) from None
    except UnfitFileError as fault:
        raise CatalogError(f"{path}: {fault}.") from None
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise CatalogError(f"{show(str(path), 200)[1:-1]}: cannot be read ({reason}).") from None


def read_table(path: Path) -> Table:
    """The table in a CSV file, with every fault of its form in `Table.faults`."""
    return parse_table(read_text(path), str(path.name))


def parse_table(text: str, file: str) -> Table:
    """Header and rows of CSV text; ragged rows and wrong separators become faults."""
    lines = _NumberedLines(io.StringIO(text, newline=""))
    reader = csv.reader(lines)
    try:
        return _parsed(reader, lines, file)
    except csv.Error as fault:
        return Table(file, (), (), (f"{file} row {lines.number}: is not CSV: {fault}.",))


def _parsed(reader: Iterator[list[str]], lines: _NumberedLines, file: str) -> Table:
    first = next((cells for cells in reader if any(cell.strip() for cell in cells)), None)
    if first is None:
        return Table(file, (), (), (f"{file}: holds no header row; `uwopt catalog template` prints one.",))
    header = tuple(cell.strip() for cell in first)
    separator = _wrong_separator(header)
    if separator:
        fault = (
            f"{file} row {lines.number}: columns are separated by {separator}; "
            "export the table as comma-separated CSV with decimal points."
        )
        return Table(file, header, (), (fault,))
    faults = [f"{file} row {lines.number}: column {name!r} stands twice." for name in _repeated(header)]
    faults += [f"{file} row {lines.number}: a column has no name." for name in header if not name][:1]
    rows = []
    for cells in reader:
        if not any(cell.strip() for cell in cells):
            continue
        row = Row(file, lines.number, dict(zip(header, (c.strip() for c in cells), strict=False)))
        if len(cells) < len(header) or any(cell.strip() for cell in cells[len(header) :]):
            faults.append(
                f"{row.where()}: has {len(cells)} cells, the header has {len(header)}; "
                "a cell that holds a comma needs quotes, and decimals need a point."
            )
        rows.append(row)
    return Table(file, header, tuple(rows), tuple(faults))


def unknown_columns(table: Table, known: Iterable[str]) -> list[str]:
    """One fault that names all columns that are not known; none where all are."""
    known = list(known)
    return column_fault(table, [name for name in table.header if name and name not in known], ", ".join(known))


def column_fault(table: Table, strange: Sequence[str], known: str) -> list[str]:
    """One fault that names columns that are not known, the first few of many; none where there are none."""
    if not strange:
        return []
    told = [*map(show, strange[:MOST_NAMED]), *([f"{len(strange) - MOST_NAMED} more"] if strange[MOST_NAMED:] else [])]
    *first, last = told
    named = f"columns {', '.join(first)} and {last} are" if first else f"column {last} is"
    return [f"{table.file}: {named} unknown; known are {known}."]


def built_in_rows(name: str) -> Iterator[dict[str, str]]:
    """Rows of a table that ships with uwopt; no checks, they are made by the tests."""
    with (DATA_DIR / name).open(encoding="utf-8", newline="") as lines:
        yield from csv.DictReader(line for line in lines if not line.startswith("#"))


def _wrong_separator(header: tuple[str, ...]) -> str:
    if len(header) > 1:
        return ""
    return "';'" if ";" in header[0] else "tabs" if "\t" in header[0] else ""


def _repeated(names: tuple[str, ...]) -> list[str]:
    return sorted({name for name in names if name and names.count(name) > 1})
