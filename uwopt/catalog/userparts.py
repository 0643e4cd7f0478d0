"""Users' own parts (CSV or YAML) and prices (CSV): read, checked as a whole, faults told once.

The built-in files have the same columns, so a row is checked and built in one way for both.
"""

from __future__ import annotations

import datetime as dt
import difflib
import math
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from uwopt.catalog.columns import COLUMNS, REQUIRED, TELLTALE, Cell, CellError, Column, parse_cell
from uwopt.catalog.parts.cell import FROM_ZERO, beyond
from uwopt.catalog.parts.kinds import ORDERED_PAIRS
from uwopt.catalog.parts.part import KINDS, Kind
from uwopt.catalog.tables import Row, Table, parse_table, read_text, unknown_columns
from uwopt.documents.faults import KeyPath
from uwopt.documents.files import MOST_BYTES
from uwopt.errors import CatalogError, MissionError

NESTED = "{...}"  # what is no cell: a mapping, or a list in a list
MOST_VALUES = 500_000  # in a YAML file of parts, some ten thousand of them
PRICE_COLUMNS = {
    column.name: column
    for column in (
        Column("id", "text"),
        Column("price", within=FROM_ZERO),
        Column("price_low", within=FROM_ZERO),
        Column("price_high", within=FROM_ZERO),
        Column("currency", "text", meaning="three letters, e.g. USD"),
        Column("date", "text", meaning="YYYY-MM-DD"),
        Column("note", "text"),
    )
}


@dataclass(frozen=True, slots=True)
class PartRow:
    """One part as typed cells, before anything is estimated."""

    kind: Kind
    where: str
    cells: dict[str, Cell]
    base_dir: Path | None = None  # where the curve files it names are looked for

    def number(self, name: str) -> float | None:
        """A number cell; None when empty."""
        value = self.cells.get(name)
        return value if isinstance(value, float) else None

    def text(self, name: str) -> str:
        """A text cell; "" when empty."""
        value = self.cells.get(name)
        return value if isinstance(value, str) else ""

    def items(self, name: str) -> tuple[str, ...]:
        """A list cell; () when empty."""
        value = self.cells.get(name)
        return value if isinstance(value, tuple) else ()


@dataclass(frozen=True, slots=True)
class PriceQuote:
    """A user's own price for a part."""

    part_id: str
    price: float
    low: float
    high: float
    currency: str
    date: str
    where: str


def read_parts(path: Path) -> list[PartRow]:
    """All parts of a user's CSV or YAML file; raises once with every fault."""
    rows, faults = check_parts(path)
    if faults:
        raise CatalogError(faults)
    return rows


def check_parts(path: Path) -> tuple[list[PartRow], list[str]]:
    """Parts of a file that could be read, and every fault."""
    text = read_text(path)
    if path.suffix.casefold() in (".yaml", ".yml"):
        table = yaml_table(text, path.name)
    else:
        table = parse_table(text, path.name)
    return typed_rows(table, base_dir=path.parent)


def typed_rows(
    table: Table, kind: Kind | None = None, base_dir: Path | None = None, *, built_in: bool = False
) -> tuple[list[PartRow], list[str]]:
    """Rows with typed cells; `kind` where the caller knows it, else told by row, file name or header.

    A built-in row may lack a required cell: such a part stays in the catalogue and out of the search.
    """
    faults = list(table.faults)
    told = kind or kind_of_table(table)
    known = set().union(*(COLUMNS[k] for k in ((told,) if told else KINDS)))
    faults += [
        _unknown_column(table.file, name, known) for name in table.header if name and name not in known
        and ";" not in name  # columns that were not told apart, which is a fault of its own
    ]
    rows: list[PartRow] = []
    seen: dict[str, int] = {}
    for row in table.rows:
        row_kind = _kind_of_row(row, told)
        if row_kind is None:
            faults.append(f"{row.where()}: which kind of part? Add a column part = {', '.join(KINDS)}.")
            continue
        cells, row_faults = _typed_cells(row, row_kind, ("id",) if built_in else REQUIRED[row_kind])
        part_id = row.cells.get("id", "")
        if part_id in seen:
            row_faults.append(f"id stands already in row {seen[part_id]}; ids are unique")
        elif part_id:
            seen[part_id] = row.line
        faults += [f"{row.where()}: {fault}." for fault in row_faults]
        rows.append(PartRow(row_kind, row.where(), cells, base_dir))
    if not table.rows and not faults:
        faults.append(f"{table.file}: holds no parts below its header.")
    return rows, faults


def kind_of_table(table: Table) -> Kind | None:
    """The kind of all parts in a file, where one column or the file's name tells it."""
    if "part" in table.header:
        return None
    for name, kind in TELLTALE.items():
        if name in table.header:
            return kind
    stem = Path(table.file).stem.casefold()
    named: list[Kind] = [kind for kind in KINDS if kind in stem or f"{kind}es" in stem]
    return named[0] if len(named) == 1 else None


def _kind_of_row(row: Row, told: Kind | None) -> Kind | None:
    for kind in KINDS:
        if kind in (row.cells.get("part"), row.cells.get("kind")):
            return kind
    return told


def _typed_cells(row: Row, kind: Kind, required: tuple[str, ...]) -> tuple[dict[str, Cell], list[str]]:
    cells: dict[str, Cell] = {}
    faults = []
    for name, text in row.cells.items():
        column = COLUMNS[kind].get(name)
        if column is None:
            if text and any(name in COLUMNS[other] for other in KINDS):
                faults.append(f"{name} is no column of a {kind}")
            continue
        try:
            cells[name] = parse_cell(column, text)
        except CellError as fault:
            faults.append(str(fault))
            continue
        value = cells[name]
        if isinstance(value, float) and (far := beyond(value, column.span)):
            faults.append(f"{name} = {text} {far}, as none is made; check its unit")
    faults += [f"{name} is empty; a {kind} needs it" for name in required if not row.cells.get(name)]
    return cells, faults + _cross_faults(cells)


def _cross_faults(cells: dict[str, Cell]) -> list[str]:
    faults = []
    for smaller, larger in ORDERED_PAIRS:
        low, high = cells.get(smaller), cells.get(larger)
        if isinstance(low, float) and isinstance(high, float) and low > high:
            faults.append(f"{smaller} = {low:g} is above {larger} = {high:g}; swap or correct them")
    for name, parse in (("dim_levels", parse_dim_levels), ("spacers_mm", parse_spacers)):
        text = cells.get(name)
        if isinstance(text, str):
            try:
                parse(text)
            except CellError as fault:
                faults.append(str(fault))
    return faults


def parse_spacers(text: str) -> tuple[float, ...]:
    """Lengths of spacer rings in millimetres, the shortest first; none for a lens that takes none."""
    if text == "none":
        return ()
    lengths = _listed_numbers(text)
    if not lengths or not 0.0 < lengths[0] <= lengths[-1] <= 100.0:
        raise CellError(f"spacers_mm = {text!r} must be lengths above 0 and at most 100, such as 0.5|1|5, or none")
    return tuple(lengths)


def parse_dim_levels(text: str) -> tuple[float, ...] | None:
    """Shares of full, brightest first; None for continuous dimming, (1,) for a lamp that cannot dim."""
    if text == "continuous":
        return None
    if text == "none":
        return (1.0,)
    levels = _listed_numbers(text)[::-1]
    if not levels or levels[0] != 1.0 or levels[-1] <= 0.0:
        raise CellError(
            f"dim_levels = {text!r} must be shares of full with 1 among them, such as 1|0.5|0.25, "
            "or continuous, or none"
        )
    return tuple(levels)


def _listed_numbers(text: str) -> list[float]:
    """The different numbers of `1|0.5|0.25`, the least first; none at all where one of them is no number."""
    try:
        numbers = {float(item) for item in text.split("|")}
    except ValueError:
        return []
    return sorted(numbers) if all(map(math.isfinite, numbers)) else []


def _unknown_column(file: str, name: str, known: Collection[str]) -> str:
    with_unit = [column for column in known if column.startswith(f"{name}_")]
    near = with_unit or difflib.get_close_matches(name, sorted(known), n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}?" if near else "`uwopt catalog template` prints the known ones."
    return f"{file}: column {name!r} is unknown; {hint}"


def yaml_table(text: str, file: str) -> Table:
    """A YAML list of parts as a table, so that both forms are checked alike; cells keep their lines."""
    from uwopt.documents.yaml_lines import compose  # loads PyYAML, and most runs have no YAML parts

    try:
        root, lines, faults = compose(text, file, scalar=_plain_text, max_nodes=MOST_VALUES)
    except MissionError as fault:
        return Table(file, (), (), tuple(fault.faults))
    place: KeyPath = ()
    if isinstance(root, dict) and list(root) == ["parts"]:
        root, place = root["parts"], ("parts",)
    if not isinstance(root, list):
        faults.append(f"{file}: must be a list of parts, each beginning with `- part: camera`.")
        return Table(file, (), (), tuple(faults))
    rows, n_signs = [], 0
    for number, part in enumerate(root):
        line = lines.get((*place, number), 1)
        if not isinstance(part, dict):
            faults.append(f"{file} row {line}: is not a part; write keys and values.")
            continue
        cells = {name.strip(): _cell_text(value) for name, value in part.items()}
        rows.append(Row(file, line, cells))
        n_signs += sum(map(len, cells.values()))
        if n_signs > MOST_BYTES:  # aliases grow a file beyond its size
            raise CatalogError(f"{file}: its aliases stand for more than {MOST_BYTES / 1e6:.0f} MB of text.")
    header = tuple(dict.fromkeys(name for row in rows for name in row.cells))
    return Table(file, header, tuple(rows), tuple(faults))


def _plain_text(text: str) -> str:
    """Plain YAML text as a cell holds it: as it was written, nothing for null."""
    from uwopt.documents.yaml_lines import resolve_scalar

    return "" if resolve_scalar(text) is None else text


def _cell_text(value: object) -> str:
    if isinstance(value, list):
        return "|".join(item.strip() if isinstance(item, str) else NESTED for item in value)
    return value.strip() if isinstance(value, str) else NESTED


def read_prices(path: Path) -> list[PriceQuote]:
    """A user's price list; raises once with every fault."""
    quotes, faults = check_prices(parse_table(read_text(path), path.name))
    if faults:
        raise CatalogError(faults)
    return quotes


def is_price_table(table: Table) -> bool:
    """Whether a CSV is a price list: ids and prices, no column that describes a part."""
    return {"id", "price"} <= set(table.header) <= set(PRICE_COLUMNS)


def check_prices(table: Table) -> tuple[list[PriceQuote], list[str]]:
    """Quotes that could be read, and every fault."""
    faults = [*table.faults, *unknown_columns(table, PRICE_COLUMNS)]
    quotes: list[PriceQuote] = []
    seen: dict[str, int] = {}
    for row in table.rows:
        cells: dict[str, Cell] = {}
        row_faults = []
        for name, column in PRICE_COLUMNS.items():
            try:
                cells[name] = parse_cell(column, row.cells.get(name, ""))
            except CellError as fault:
                row_faults.append(str(fault))
        row_faults += [f"{name} is empty" for name in ("id", "price") if not row.cells.get(name)]
        row_faults += [*_cross_faults(cells), *_quote_faults(row)]
        part_id = row.cells.get("id", "")
        if part_id in seen:
            row_faults.append(f"id stands already in row {seen[part_id]}")
        seen.setdefault(part_id, row.line)
        faults += [f"{row.where()}: {fault}." for fault in row_faults]
        if not row_faults:
            quotes.append(_quote(cells, row.where()))
    return quotes, faults


def _quote_faults(row: Row) -> list[str]:
    """What is wrong with the day of a quote, which is text."""
    day = row.cells.get("date", "")
    try:
        dt.date.fromisoformat(day + "-01-01"[len(day) - 4 :] if 4 <= len(day) < 10 else day or "2000-01-01")
    except ValueError:
        return [f"date = {day!r} is no day; write YYYY-MM-DD"]
    return []


def _quote(cells: dict[str, Cell], where: str) -> PriceQuote:
    price = cells["price"]
    assert isinstance(price, float)
    low, high = cells.get("price_low"), cells.get("price_high")
    return PriceQuote(
        str(cells["id"]),
        price,
        low if isinstance(low, float) else price,
        high if isinstance(high, float) else price,
        str(cells.get("currency") or "USD").upper(),
        str(cells.get("date") or ""),
        where,
    )
