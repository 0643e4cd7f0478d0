"""Test shots: what was set, how far away it was looked at, and how bright it came out, from a CSV.

    shot,exposure_ms,gain_db,distance_m,level_dn,dark_dn,f_number,light_pct
    1,0.6,0,1.5,1830,64,4,100

One row a shot. The unit stands in the column's name; `f_number`, `pulse`, `light` and the shot's name may be left out.
Levels are means over the image, or over a patch in its middle; the dark level is what the same exposure and gain give
without any light.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from uwopt.catalog.tables import Row, Table, column_fault, parse_table, read_text
from uwopt.documents.faults import nearest, show
from uwopt.errors import CatalogError, MissionError
from uwopt.units import db_to_ratio

MOST_SHOTS = 2000
LevelUnit = Literal["dn", "frac"]


@dataclass(frozen=True)
class ShotColumn:
    """What a column may hold: factors to SI by the end of its name, and whether it must be there."""

    words: str
    units: Mapping[str, float]
    needed: bool = True
    or_zero: bool = False


LEVELS = {"_dn": 1.0, "_pct": 0.01, "_frac": 1.0}
COLUMNS: dict[str, ShotColumn] = {
    "exposure": ShotColumn("exposure", {"_ms": 1e-3, "_us": 1e-6, "_s": 1.0}),
    "gain": ShotColumn("gain over the camera's lowest", {"_db": math.nan, "": 1.0}, or_zero=True),
    "distance": ShotColumn("distance from port to target", {"_m": 1.0, "_cm": 1e-2, "_mm": 1e-3}),
    "level": ShotColumn("mean level", LEVELS, or_zero=True),
    "dark": ShotColumn("level without light", LEVELS, or_zero=True),
    "f_number": ShotColumn("f-number", {"": 1.0}, needed=False),
    "pulse": ShotColumn("light pulse", {"_ms": 1e-3, "_us": 1e-6, "_s": 1.0}, needed=False),
    "light": ShotColumn("light level", {"_pct": 0.01, "_frac": 1.0}, needed=False),
}
NAMES = {f"{name}{unit}": (name, unit) for name, one in COLUMNS.items() for unit in one.units}
BESIDE = ("shot", "note")


@dataclass(frozen=True)
class Shot:
    """One test shot in SI; levels in DN of the camera, or as shares of its full scale. None: as the system has it."""

    name: str
    line: int
    exposure_s: float
    gain: float
    distance_m: float
    level: float
    dark: float
    unit: LevelUnit
    f_number: float | None = None
    pulse_s: float | None = None
    light_frac: float | None = None


def read_shots(path: str | Path) -> list[Shot]:
    """The shots of a CSV; raises one MissionError with every fault."""
    name = Path(path).name
    try:
        table = parse_table(read_text(Path(path)), name)
    except CatalogError as fault:
        raise MissionError(list(fault.faults)) from None
    faults = [text.replace("; `uwopt catalog template` prints one", "") for text in table.faults]
    if not faults or (table.rows and not NAMES.keys() & {*table.header}):  # then its rows are no shots
        faults = [*header_faults(table)]
    if faults:
        raise MissionError(faults)
    shots: list[Shot] = []
    for row in table.rows:
        made = shot_of(row, table.header, faults)
        if made is not None:
            shots.append(made)
    if not table.rows:
        faults.append(f"{name}: holds no shot; write one row for each.")
    if len(table.rows) > MOST_SHOTS:
        faults.append(f"{name}: holds {len(table.rows)} shots; {MOST_SHOTS} at most, means of like ones.")
    faults += [f"{name} row {shot.line}: shot {show(shot.name)} stands twice; give each its own name."
               for n, shot in enumerate(shots) if shot.name in [other.name for other in shots[:n]]]  # fmt: skip
    if faults:
        raise MissionError(faults)
    return shots


def header_faults(table: Table) -> Iterator[str]:
    """Columns that are missing, stand in two units, or are not known."""
    found, strange = dict[str, list[str]](), list[str]()
    for column in table.header:
        near = nearest(column, [*NAMES, *BESIDE])
        if column in NAMES:
            found.setdefault(NAMES[column][0], []).append(column)
        elif column in COLUMNS:
            yield f"{table.file}: column {show(column)} is not known; the unit belongs in its name: {allowed(column)}."
        elif column not in BESIDE and near and near not in table.header:
            yield f"{table.file}: column {show(column)} is not known; did you mean {near}?"
        elif column and column not in BESIDE:
            strange.append(column)
    yield from column_fault(table, strange, ", ".join([*map(allowed, COLUMNS), *BESIDE]))
    for name, columns in found.items():
        if len(columns) > 1:
            yield f"{table.file}: {COLUMNS[name].words} stands in {' and in '.join(columns)}; keep one of them."
    bare = [name for name in COLUMNS if name in table.header]
    missing = [name for name, one in COLUMNS.items() if one.needed and name not in found and name not in bare]
    if missing:
        told = "; ".join(f"{COLUMNS[name].words} ({allowed(name)})" for name in missing)
        yield f"{table.file}: has no column of {told}."
    kinds = {level_unit(columns[0]) for name, columns in found.items() if name in ("level", "dark")}
    if len(kinds) > 1:
        yield f"{table.file}: level and dark are in different units; give both in _dn, or both as shares."


def allowed(name: str) -> str:
    """The names that a column may have: `exposure_ms, exposure_us or exposure_s`."""
    *first, last = [f"{name}{unit}" for unit in COLUMNS[name].units] if name in COLUMNS else [name]
    return f"{', '.join(first)} or {last}" if first else last


def level_unit(column: str) -> LevelUnit:
    """Whether a column of levels holds digital numbers or shares of the full scale."""
    return "dn" if column.endswith("_dn") else "frac"


def shot_of(row: Row, header: tuple[str, ...], faults: list[str]) -> Shot | None:
    """One row; what is wrong with it is added to the faults."""
    values: dict[str, float | None] = {}
    before = len(faults)
    for column in header:
        if column not in NAMES:
            continue
        name, unit = NAMES[column]
        text, one = row.cells.get(column, ""), COLUMNS[name]
        where = f"{row.file} row {row.line}: {column} = {show(text)}"
        if not text:
            values[name] = None
            if one.needed:
                faults.append(f"{row.file} row {row.line}: {column} is empty; fill it in, or leave out the row.")
            continue
        try:
            number = float(text)
        except ValueError:
            faults.append(f"{where} is not a number; the unit belongs in the header.")
            continue
        if not math.isfinite(number):
            faults.append(f"{where} is not a finite number; leave out the row where nothing was read.")
            continue
        number = float(db_to_ratio(number)) if unit == "_db" else number * one.units[unit]
        if number < 0.0 or (number == 0.0 and not one.or_zero):
            faults.append(f"{where} is {'below 0' if number < 0.0 else '0'}; it must be above.")
        elif name in ("level", "dark", "light") and unit != "_dn" and number > 1.0 + 1e-9:
            faults.append(f"{where} is more than the whole; shares end at 1, percent at 100.")
        elif name == "gain" and number == 0.0:
            faults.append(f"{where} is 0 as a ratio; 1 is the camera's lowest gain, or give gain_db.")
        values[name] = number
    if len(faults) > before:
        return None
    shot = str(row.cells.get("shot") or f"row {row.line}")
    unit_of = next(level_unit(column) for column in header if NAMES.get(column, ("",))[0] == "level")
    number_of = {name: value for name, value in values.items() if value is not None}
    return Shot(
        shot, row.line, number_of["exposure"], number_of["gain"], number_of["distance"], number_of["level"],
        number_of["dark"], unit_of, values.get("f_number"), values.get("pulse"), values.get("light"),
    )  # fmt: skip
