"""`uwopt catalog update`: rows or quotes that are brought become changes of cells, all checked before one is kept."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from uwopt.catalog.catalogue import unknown_part
from uwopt.catalog.changes import (
    CellChange,
    built_in_cells,
    changes_of,
    checked_rows,
    is_change_table,
    kind_named,
    rows_after_changes,
)
from uwopt.catalog.columns import COLUMNS
from uwopt.catalog.money import known_rates
from uwopt.catalog.parts.part import Kind
from uwopt.catalog.readers.readers import READERS
from uwopt.catalog.tables import Row, parse_table, read_text
from uwopt.catalog.userparts import is_price_table, kind_of_table, yaml_table
from uwopt.documents.faults import nearest, plain_name
from uwopt.documents.files import FORMULA_SIGNS
from uwopt.errors import CatalogError

CLEARED = "-"  # in a row that is brought: the cell becomes empty; an empty one stays as it was
DATE = re.compile(r"\d{4}(-\d{2}(-\d{2})?)?")
SUFFIXES = (".csv", ".yaml", ".yml")
NUMBER = re.compile(r"[-+]?[\d.]+(e[-+]?\d+)?", re.IGNORECASE)
BREAKS = re.compile(r"\s*[\r\n]+\s*")


@dataclass(frozen=True, slots=True)
class Update:
    """What an update would change, after what was changed before."""

    before: tuple[CellChange, ...]
    changes: tuple[CellChange, ...]

    @property
    def log(self) -> tuple[CellChange, ...]:
        """The whole log with the new lines at its end."""
        return (*self.before, *self.changes)


def planned(sources: Sequence[Path], log: Path, *, date: str, source: str = "") -> Update:
    """The changes that files or folders bring to the catalogue as the log leaves it; raises once with every fault."""
    faults = [] if DATE.fullmatch(date) else [f"date {date!r} is not YYYY-MM-DD."]
    before, wrong = known_changes(log)
    faults += wrong
    if faults:
        raise CatalogError(faults)
    standing = built_in_cells() | rows_after_changes(before, log.name)
    changes: list[CellChange] = []
    seen: dict[str, Row] = {}
    for kind, row in _brought([path for path in _files(sources, faults) if path != log], standing, faults):
        key = plain_name(row.cells.get("id", ""))
        if key in seen:
            faults.append(f"{row.where()}: id stands already in {seen[key].where()}; ids are unique.")
        elif key in built_in_cells("generic"):
            faults.append(f"{row.where()}: is a class of parts to be made; give your part an id of its own.")
        elif not key:
            faults.append(f"{row.where()}: id is empty.")
        else:
            seen[key] = row
            found, wrong = _changes_of_row(kind, row, standing.get(key), date, source)
            changes += found
            faults += wrong
    faults += _faults_after(before, changes, log, seen)
    if faults:
        raise CatalogError(faults)
    return Update(tuple(before), tuple(changes))


def known_changes(log: Path) -> tuple[list[CellChange], list[str]]:
    """What a log holds so far; nothing where there is none yet."""
    if not log.exists():
        return [], []
    table = parse_table(read_text(log), log.name)
    if not is_change_table(table):
        return [], [f"{log}: is no log of changes to the catalogue; name another file."]
    return changes_of(table)


def _brought(
    sources: Iterable[Path], standing: dict[str, tuple[Kind, Row]], faults: list[str]
) -> list[tuple[Kind, Row]]:
    """Rows of all files, each with its kind."""
    rows = []
    for path in sources:
        try:
            text = read_text(path)
        except CatalogError as fault:
            faults += fault.faults
            continue
        table = parse_table(text, path.name) if path.suffix.casefold() == ".csv" else yaml_table(text, path.name)
        faults += table.faults
        if is_change_table(table):
            faults.append(f"{path}: is a log of changes already; name it beside others in catalog.files.")
            continue
        prices = is_price_table(table)
        for row in (_as_part(row) for row in table.rows) if prices else table.rows:
            part_id = row.cells.get("id", "")
            known = standing.get(plain_name(part_id))
            kind = kind_named(row.cells.get("part", "")) or kind_of_table(table) or (known[0] if known else None)
            if prices and known is None:
                faults.append(f"{row.where()}: {unknown_part(part_id, [r.cells['id'] for _, r in standing.values()])}")
            elif kind is None:
                faults.append(f"{row.where()}: which kind of part? Add a column part.")
            else:
                rows.append((kind, row))
    return rows


def _files(sources: Iterable[Path], faults: list[str]) -> list[Path]:
    found: list[Path] = []
    for path in sources:
        inside = sorted(p for p in path.iterdir() if p.suffix.casefold() in SUFFIXES) if path.is_dir() else [path]
        if not inside:
            faults.append(f"{path}: holds no CSV or YAML file.")
        found += inside
    return found


def _as_part(row: Row) -> Row:
    """A line of a price list as cells of a part: its note is where the quote is from."""
    cells = {name: row.cells.get(name, "") for name in ("id", "price", "price_low", "price_high", "currency")}
    cells |= {"price_date": row.cells.get("date", ""), "source_url": row.cells.get("note", "")}
    return Row(row.file, row.line, cells | {"currency": cells["currency"] or "USD"})


def _changes_of_row(
    kind: Kind, row: Row, known: tuple[Kind, Row] | None, date: str, source: str
) -> tuple[list[CellChange], list[str]]:
    """The cells of a row that say something new, and what is wrong with it as a record."""
    if known and known[0] != kind:
        return [], [f"{row.where()}: is a {known[0]} of the catalogue, not a {kind}."]
    old = known[1].cells if known else {}
    part_id = old.get("id") or row.cells["id"]
    told = {name: BREAKS.sub(" ", text) for name, text in row.cells.items() if text and name not in ("id", "part")}
    said_by = told.get("source_url") or source
    faults = [f"{row.where()}: {_no_column(name, kind)}" for name in told if name not in COLUMNS[kind]]
    faults += _formula_faults(row, {"id": part_id, **told, "source": said_by})
    new = {name: "" if text == CLEARED else text for name, text in told.items()}
    if "price" in told and new["price"] != old.get("price", ""):
        of_old = dict.fromkeys(("price_low", "price_high", "price_status", "price_date"), "")
        new = of_old | ({"price_status": "quoted"} if new["price"] else {}) | new
        faults += _quote_faults(row, new)
    new = {name: text for name, text in new.items() if text != old.get(name, "")}
    if not said_by or said_by == CLEARED:
        faults.append(f"{row.where()}: by which source? Fill source_url, or give --source.")
    if faults or not set(new) - {"source_url"}:
        return [], faults
    new |= {"source_url": _with_source(old.get("source_url", ""), said_by), "checked": date}
    return [
        CellChange(date, kind, part_id, name, old.get(name, ""), text, said_by)
        for name, text in new.items()
        if text != old.get(name, "")
    ], []


def _formula_faults(row: Row, cells: dict[str, str]) -> list[str]:
    """What a spreadsheet that opens the log would take for a formula and work out."""
    risky = [name for name, text in cells.items() if text.startswith(FORMULA_SIGNS) and text != CLEARED]
    return [
        f"{row.where()}: {name} = {cells[name]!r} begins like a formula of a spreadsheet; begin it with a letter."
        for name in risky
        if not NUMBER.fullmatch(cells[name])
    ]


def _no_column(name: str, kind: Kind) -> str:
    """That a kind of part has no such column, and what may be meant."""
    near = nearest(name, COLUMNS[kind], cutoff=0.5)
    meant = f"did you mean {near}?" if near else f"`uwopt catalog template {kind}` prints the known ones."
    return f"{name!r} is no column of a {kind}; {meant}"


def _quote_faults(row: Row, new: dict[str, str]) -> list[str]:
    """A price counts with its currency, of which a rate is known, and its date."""
    if not new["price"]:
        return []
    currency, dated = new.get("currency", ""), new.get("price_date", "")
    faults = []
    if currency.upper() not in known_rates():
        faults.append(f"{row.where()}: currency {currency!r} is not one of {', '.join(sorted(known_rates()))}.")
    if not DATE.fullmatch(dated):
        faults.append(f"{row.where()}: price_date {dated!r} is not YYYY-MM-DD; a price counts with its date.")
    return faults


def _with_source(old: str, new: str) -> str:
    """Where a row's facts are from: the new source joins those of the cells that stay."""
    return old if new in old.split(" | ") else " | ".join(text for text in (old, new) if text)


def _faults_after(
    before: Sequence[CellChange], changes: Sequence[CellChange], log: Path, brought: Mapping[str, Row]
) -> list[str]:
    """What is wrong with the parts as the changes would leave them, told by the rows that were brought."""
    touched = {plain_name(change.id) for change in changes}
    rows = [
        (kind, Row(brought[key].file, brought[key].line, row.cells))
        for key, (kind, row) in rows_after_changes([*before, *changes], log.name).items()
        if key in touched
    ]
    typed, faults = checked_rows(rows, log.parent)
    if faults:
        return faults
    for row in typed:
        try:
            READERS[row.kind].from_row(row, "published")
        except CatalogError as fault:
            faults += fault.faults
    return faults
