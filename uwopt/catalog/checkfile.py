"""`uwopt catalog check` and `template`: is a user's file right, and what would a right one look like?"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from uwopt.catalog.changes import changes_of, is_change_table, moved_on
from uwopt.catalog.columns import COLUMNS
from uwopt.catalog.curves.usercurves import check_curves, is_curve_table
from uwopt.catalog.money import known_rates
from uwopt.catalog.parts.kinds import PARTS
from uwopt.catalog.records import KINDS
from uwopt.catalog.tables import Table, parse_table, read_text
from uwopt.catalog.userparts import PriceQuote, check_parts, check_prices, is_price_table
from uwopt.documents.files import csv_text
from uwopt.errors import CatalogError

Content = Literal["parts", "prices", "curve", "changes", "unreadable"]


@dataclass(frozen=True, slots=True)
class FileReport:
    """What a file holds and what is wrong with it; `notes` tells what will be estimated or left out."""

    path: Path
    content: Content
    n_rows: int
    faults: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the file can be used as it stands."""
        return not self.faults


def file_report(path: Path, beside: Sequence[Path] = ()) -> FileReport:
    """Check a parts file, a price list or a curve; never raises for what the file holds.

    beside : files of parts of which a price list may name some
    """
    try:
        return _checked(path, beside)
    except CatalogError as fault:
        return FileReport(path, "unreadable", 0, tuple(fault.faults))


def _checked(path: Path, beside: Sequence[Path]) -> FileReport:
    if not path.exists():
        raise CatalogError(f"{path}: no such file; check its name.")
    if path.suffix.casefold() not in (".yaml", ".yml"):
        table = parse_table(read_text(path), path.name)
        if is_curve_table(table):
            curve = check_curves(table)
            return FileReport(path, "curve", len(table.rows), curve.faults)
        if is_change_table(table):
            return _checked_changes(path, table)
        if is_price_table(table):
            quotes, faults = check_prices(table)
            faults += _unknown_ids(quotes, beside)
            return FileReport(path, "prices", len(table.rows), tuple(faults), tuple(_without_rate(quotes)))
    rows, faults = check_parts(path)
    if faults:
        return FileReport(path, "parts", len(rows), tuple(faults))
    return FileReport(path, "parts", len(rows), *_built(path))


def _checked_changes(path: Path, table: Table) -> FileReport:
    """A log of changes: its lines, the parts that it leaves, and what has moved on beneath it."""
    from uwopt.catalog.load import read_catalog

    changes, faults = changes_of(table)
    if not faults:
        try:
            read_catalog([path])
        except CatalogError as fault:
            faults = list(fault.faults)
    return FileReport(path, "changes", len(table.rows), tuple(faults), tuple(moved_on(changes)))


def _built(path: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Faults that only show when the parts are built, and what is estimated or missing."""
    from uwopt.catalog.listing import estimated_fields
    from uwopt.catalog.load import read_catalog

    try:
        catalog = read_catalog([path])
    except CatalogError as fault:
        return tuple(fault.faults), ()
    rows, _ = check_parts(path)
    notes = []
    for row in rows:
        part = catalog.part(row.text("id"))
        notes += [f"{part.id}: not searched, {e.rule}: {e.reason}." for e in catalog.exclusions_of(part.id)]
        estimated = estimated_fields(part)
        if estimated:
            notes.append(f"{part.id}: estimated by class: {', '.join(estimated)}.")
    return (), tuple(notes)


def _unknown_ids(quotes: list[PriceQuote], beside: Sequence[Path]) -> list[str]:
    """Quotes of parts that neither the catalogue nor a file beside has, which no mission takes."""
    from uwopt.catalog.catalogue import unknown_part
    from uwopt.catalog.load import read_catalog

    ids = {*read_catalog().ids()}
    for path in beside:
        with contextlib.suppress(CatalogError):  # told of itself, or no file of parts
            ids |= {*read_catalog([path]).ids()}
    known = {part_id.casefold() for part_id in ids}
    return [
        f"{quote.where}: {unknown_part(quote.part_id, ids)} Of an own part, check the file that has it beside this one."
        for quote in quotes
        if quote.part_id.casefold() not in known
    ]


def _without_rate(quotes: list[PriceQuote]) -> list[str]:
    """Quotes in a currency that has no exchange rate here."""
    known = known_rates()
    return [
        f"{quote.where}: {quote.currency} has no exchange rate here; a mission needs it in limits.rates."
        for quote in quotes
        if quote.currency not in known
    ]


OTHER_TEMPLATES = {
    "prices": "# Your own quotes; they replace the catalogue's prices. id: as in `uwopt catalog list`.\n"
    "id,price,currency,date\nflir-bfs-u3-51s5m,1304,USD,2026-08-14\n",
    "light-spectrum": "# Relative power per nm against wavelength (nm, increasing); must cover 400-700 nm.\n"
    "wavelength_nm,relative_power\n400,0.1\n450,1.0\n550,0.8\n700,0.2\n",
    "seafloor": "# Reflectance 0..1 against wavelength (nm, increasing); must cover 400-700 nm.\n"
    "wavelength_nm,reflectance\n400,0.08\n550,0.20\n700,0.28\n",
    "water": "# Absorption and scattering in 1/m (base e) against wavelength in nm, over 400-700 nm.\n"
    "# attenuation_per_m may stand for a_per_m + b_per_m; kd_per_m may be added.\n"
    "wavelength_nm,a_per_m,b_per_m\n400,0.05,0.30\n550,0.08,0.25\n700,0.65,0.20\n",
    "beam": "# Intensity (relative) against the angle from the axis (deg, increasing).\n"
    "angle_deg,intensity\n0,1.0\n30,0.9\n45,0.5\n60,0.1\n90,0.0\n",
}

TEMPLATE_KINDS = (*KINDS, *OTHER_TEMPLATES)


def template(kind: str) -> str:
    """CSV text to start from: a comment on every column, the header and one example row."""
    if kind in OTHER_TEMPLATES:
        return OTHER_TEMPLATES[kind]
    found = next((known for known in KINDS if known == kind), None)
    if found is None:
        raise CatalogError(f"no template for {kind!r}; there are {', '.join(TEMPLATE_KINDS)}.")
    columns = [column for name, column in COLUMNS[found].items() if name not in ("part", "correction")]
    head = f"# Your own parts of kind {found}. Unknown: an empty cell, never 0. Columns may be dropped.\n"
    for column in columns:
        head += f"# {column.name}: {column.allowed()}{'; ' + column.meaning if column.meaning else ''}\n"
    names = [column.name for column in columns]
    return head + csv_text([names, [PARTS[found].example.get(name, "") for name in names]])
