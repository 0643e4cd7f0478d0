"""From files to the catalogue: built-in parts, generic parts, users' parts and prices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TypeVar

from uwopt.catalog.catalogue import Catalog, Exclusion, unknown_part
from uwopt.catalog.changes import CellChange, checked_rows, read_changes, rows_after_changes
from uwopt.catalog.parts.kinds import PARTS
from uwopt.catalog.readers.readers import READERS
from uwopt.catalog.readers.reading import Built, Origin
from uwopt.catalog.records import KINDS, Camera, Complete, Housing, Kind, Lens, Light, Part, Port, Quantity
from uwopt.catalog.tables import DATA_DIR, read_table
from uwopt.catalog.userparts import PartRow, PriceQuote, read_parts, read_prices, typed_rows
from uwopt.documents.faults import plain_name
from uwopt.documents.whole_file import resolve_path
from uwopt.errors import CatalogError

PathLike = str | Path
P = TypeVar("P", bound=Part)


def read_catalog(
    user_files: Sequence[PathLike] = (), prices: PathLike | None = None, base_dir: PathLike | None = None
) -> Catalog:
    """The whole catalogue; users' files are looked for in `base_dir` (the mission file's folder).

    Raises one CatalogError with every fault of every file.
    """
    catalog = built_in_catalog()
    if not user_files and prices is None:
        return catalog
    base = Path(base_dir) if base_dir is not None else Path()
    faults: list[str] = []
    rows: list[PartRow] = []
    changes: list[CellChange] = []
    for file in user_files:
        path = resolve_path(file, base)
        try:
            log = read_changes(path)
            if log is None:
                rows += read_parts(path)
            else:
                changes += log
                catalog = with_changes(built_in_catalog(), changes, path)
        except CatalogError as fault:
            faults += fault.faults
    faults += _taken_ids(rows, catalog)
    if not faults:
        try:
            catalog = _with_user_parts(catalog, rows, tuple(str(file) for file in user_files))
        except CatalogError as fault:
            faults += fault.faults
    if prices is not None:
        try:
            catalog = with_prices(catalog, read_prices(resolve_path(prices, base)))
        except CatalogError as fault:
            faults += fault.faults
    if faults:
        raise CatalogError(faults)
    return catalog


@cache
def built_in_catalog() -> Catalog:
    """Built-in and generic parts, read once per process."""
    built: list[tuple[Kind, Built]] = []
    for origin in ("published", "generic"):
        for kind, part in PARTS.items():
            for file in (name for name, of in part.files.items() if of == origin):
                built += build_rows(_built_in(file, kind), origin)
    return assembled(built)


def build_rows(rows: Iterable[PartRow], origin: Origin) -> list[tuple[Kind, Built]]:
    """Records of rows; raises once with every fault."""
    faults: list[str] = []
    built = []
    for row in rows:
        try:
            built.append((row.kind, READERS[row.kind].from_row(row, origin)))
        except CatalogError as fault:
            faults += fault.faults
    if faults:
        raise CatalogError(faults)
    return built


def assembled(built: Iterable[tuple[Kind, Built]]) -> Catalog:
    """A catalogue of built parts, in their order."""
    parts: dict[Kind, list[Part]] = {kind: [] for kind in KINDS}
    exclusions: list[Exclusion] = []
    for kind, item in built:
        parts[kind].append(item.part)
        exclusions += item.exclusions(kind)
    return Catalog(
        cameras=tuple(part for part in parts["camera"] if isinstance(part, Camera)),
        lenses=tuple(part for part in parts["lens"] if isinstance(part, Lens)),
        ports=tuple(part for part in parts["port"] if isinstance(part, Port)),
        lights=tuple(part for part in parts["light"] if isinstance(part, Light)),
        exclusions=tuple(exclusions),
        housings=tuple(part for part in parts["housing"] if isinstance(part, Housing)),
        completes=tuple(part for part in parts["complete"] if isinstance(part, Complete)),
    )


def with_changes(catalog: Catalog, log: Sequence[CellChange], path: Path) -> Catalog:
    """The catalogue after a log of changes: changed parts in their places, new ones behind."""
    rows, faults = checked_rows(rows_after_changes(log, path.name).values(), path.parent)
    if faults:
        raise CatalogError(faults)
    changed = assembled(build_rows(rows, "published"))
    keys = {plain_name(part_id) for part_id in changed.ids()}
    kept = tuple(e for e in catalog.exclusions if plain_name(e.part_id) not in keys)
    return replace(
        catalog,
        cameras=_in_place(catalog.cameras, changed.cameras),
        lenses=_in_place(catalog.lenses, changed.lenses),
        ports=_in_place(catalog.ports, changed.ports),
        lights=_in_place(catalog.lights, changed.lights),
        housings=_in_place(catalog.housings, changed.housings),
        completes=_in_place(catalog.completes, changed.completes),
        exclusions=kept + changed.exclusions,
    )


def _in_place(parts: tuple[P, ...], changed: tuple[P, ...]) -> tuple[P, ...]:
    by_key = {plain_name(part.id): part for part in changed}
    return (*(by_key.pop(plain_name(part.id), part) for part in parts), *by_key.values())


def with_prices(catalog: Catalog, quotes: Sequence[PriceQuote]) -> Catalog:
    """The catalogue with a user's quotes in place of its own prices."""
    known = {plain_name(part_id) for part_id in catalog.ids()}
    faults = [
        f"{quote.where}: {unknown_part(quote.part_id, catalog.ids())}"
        for quote in quotes
        if plain_name(quote.part_id) not in known
    ]
    if faults:
        raise CatalogError(faults)
    by_key = {plain_name(quote.part_id): quote for quote in quotes}
    return replace(
        catalog,
        cameras=tuple(_priced(part, by_key) for part in catalog.cameras),
        lenses=tuple(_priced(part, by_key) for part in catalog.lenses),
        ports=tuple(_priced(part, by_key) for part in catalog.ports),
        lights=tuple(_priced(part, by_key) for part in catalog.lights),
        housings=tuple(_priced(part, by_key) for part in catalog.housings),
        completes=tuple(_priced(part, by_key) for part in catalog.completes),
    )


def _priced(part: P, by_key: dict[str, PriceQuote]) -> P:
    quote = by_key.get(plain_name(part.id))
    if quote is None:
        return part
    price = Quantity(quote.price, quote.low, quote.high, "user", quote.where)
    return replace(part, price=price, currency=quote.currency, price_date=quote.date)


def _built_in(file: str, kind: Kind) -> list[PartRow]:
    rows, faults = typed_rows(read_table(DATA_DIR / file), kind, DATA_DIR, built_in=True)
    if faults:
        raise CatalogError(faults)
    return rows


def _taken_ids(rows: Iterable[PartRow], catalog: Catalog) -> list[str]:
    taken = {plain_name(part_id): "of the built-in catalogue" for part_id in catalog.ids()}
    faults = []
    for row in rows:
        key = plain_name(row.text("id"))
        if key in taken:
            faults.append(f"{row.where}: id is already that of a part {taken[key]}; choose another.")
        elif key:
            taken[key] = f"in {row.where}"
    return faults


def _with_user_parts(catalog: Catalog, rows: Iterable[PartRow], files: tuple[str, ...]) -> Catalog:
    own = assembled(build_rows(rows, "user"))
    return Catalog(
        catalog.cameras + own.cameras,
        catalog.lenses + own.lenses,
        catalog.ports + own.ports,
        catalog.lights + own.lights,
        catalog.exclusions + own.exclusions,
        files,
        catalog.housings + own.housings,
        catalog.completes + own.completes,
    )
