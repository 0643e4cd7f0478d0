"""Users' own spectra and profiles: CSV columns against wavelength or angle, checked as a whole."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from uwopt.arrays import FloatArray
from uwopt.catalog.columns import CellError, Column, parse_number
from uwopt.catalog.parts.cell import FROM_ZERO, SHARE, Range
from uwopt.catalog.parts.quantity import Curve
from uwopt.catalog.tables import Row, Table, read_table, unknown_columns
from uwopt.errors import CatalogError

VISIBLE_NM = (400.0, 700.0)  # what a spectrum must cover

WAVELENGTH = Column("wavelength_nm", within=Range(200.0, 2500.0), meaning="in vacuum, increasing")
ANGLE = Column("angle_deg", within=Range(0.0, 180.0), meaning="from the axis, increasing from 0")
CHANNELS = ("mono", "red", "green", "blue")

VALUE_COLUMNS = {
    column.name: column
    for column in (
        Column("relative_power", within=FROM_ZERO),
        Column("reflectance", within=SHARE),
        Column("attenuation_per_m", within=FROM_ZERO),
        Column("a_per_m", within=FROM_ZERO),
        Column("b_per_m", within=FROM_ZERO),
        Column("kd_per_m", within=FROM_ZERO),
        Column("qe", within=SHARE),
        Column("intensity", within=FROM_ZERO, meaning="relative, or in candela"),
    )
}


@dataclass(frozen=True, slots=True)
class CurveFile:
    """Columns of a curve file by channel ("" where it has none), and what is wrong with it."""

    abscissa: str
    columns: dict[str, dict[str, FloatArray]]
    faults: tuple[str, ...]


def is_curve_table(table: Table) -> bool:
    """Whether a CSV is a spectrum or a profile, by its header."""
    return "wavelength_nm" in table.header or "angle_deg" in table.header


def read_columns(path: Path, wanted: tuple[str, ...]) -> dict[str, FloatArray]:
    """Wavelengths and those of the wanted columns that the file has; raises with every fault."""
    curve_file = check_curves(read_table(path))
    faults = list(curve_file.faults)
    columns = curve_file.columns.get("", next(iter(curve_file.columns.values()), {}))
    if not faults and not any(name in columns for name in wanted):
        faults.append(f"{path.name}: has none of the columns {', '.join(wanted)}.")
    if faults:
        raise CatalogError(faults)
    return columns


def read_channels(path: Path, value: str) -> dict[str, Curve]:
    """One curve per channel ("mono" where the file names none) of a quantum-efficiency file."""
    curve_file = check_curves(read_table(path))
    faults = list(curve_file.faults)
    if not faults and not all(value in columns for columns in curve_file.columns.values()):
        faults.append(f"{path.name}: needs the columns {curve_file.abscissa}, {value}.")
    if faults:
        raise CatalogError(faults)
    return {
        channel or "mono": Curve(tuple(columns[curve_file.abscissa].tolist()), tuple(columns[value].tolist()))
        for channel, columns in curve_file.columns.items()
    }


def check_curves(table: Table) -> CurveFile:
    """Every value checked: numbers, ranges, increasing abscissa, visible range covered."""
    abscissa = ANGLE if "angle_deg" in table.header else WAVELENGTH
    known = {abscissa.name, "channel", *VALUE_COLUMNS}
    faults = [*table.faults, *unknown_columns(table, sorted(known))]
    names = [name for name in table.header if name in VALUE_COLUMNS]
    if abscissa.name not in table.header or not names:
        faults.append(
            f"{table.file}: needs wavelength_nm or angle_deg, and one of {', '.join(VALUE_COLUMNS)}."
        )
        return CurveFile(abscissa.name, {}, tuple(faults))
    columns: dict[str, dict[str, list[float]]] = {}
    for row in table.rows:
        faults += _stored(row, abscissa, names, columns)
    arrays = {c: {name: np.array(values) for name, values in store.items()} for c, store in columns.items()}
    faults += _coverage_faults(table.file, abscissa, arrays)
    return CurveFile(abscissa.name, arrays, tuple(faults))


def _stored(
    row: Row, abscissa: Column, names: list[str], columns: dict[str, dict[str, list[float]]]
) -> list[str]:
    """Put a row's values into the columns of its channel; the faults of the row."""
    channel = row.cells.get("channel", "")
    if channel and channel not in CHANNELS:
        return [f"{row.where()}: channel = {channel!r} is not one of {', '.join(CHANNELS)}."]
    store = columns.setdefault(channel, {name: [] for name in (abscissa.name, *names)})
    before = max((x for x in store[abscissa.name] if math.isfinite(x)), default=-math.inf)
    faults = []
    for column in (abscissa, *(VALUE_COLUMNS[name] for name in names)):
        value, fault = _number(column, row.cells.get(column.name, ""))
        store[column.name].append(value)
        if fault:
            faults.append(f"{row.where()}: {fault}.")
    x = store[abscissa.name][-1]
    if x <= before:
        faults.append(
            f"{row.where()}: {abscissa.name} = {x:g} does not increase (before it {before:g}); sort the rows."
        )
    return faults


def _number(column: Column, text: str) -> tuple[float, str]:
    if text == "":
        return math.nan, f"{column.name} is empty; a curve has no gaps"
    try:
        return parse_number(column, text), ""
    except CellError as fault:
        return math.nan, str(fault)


def _coverage_faults(file: str, abscissa: Column, columns: dict[str, dict[str, FloatArray]]) -> list[str]:
    if not columns:
        return [f"{file}: holds no rows below its header."]
    faults = []
    for channel, store in columns.items():
        x = store[abscissa.name]
        x = x[np.isfinite(x)]
        name = f"{file}, channel {channel}" if channel else file
        if x.size < 2:
            faults.append(f"{name}: has {x.size} usable row(s); a curve needs two or more.")
        elif abscissa is WAVELENGTH:
            faults += [f"{name}: covers {x.min():g}-{x.max():g} nm; {gap}." for gap in _visible_gaps(x)]
    return faults


def _visible_gaps(wavelength_nm: FloatArray) -> list[str]:
    low_nm, high_nm = VISIBLE_NM
    first_nm, last_nm = float(wavelength_nm.min()), float(wavelength_nm.max())
    gaps = []
    if first_nm > low_nm:
        gaps.append((low_nm, min(first_nm, high_nm)))
    if last_nm < high_nm:
        gaps.append((max(last_nm, low_nm), high_nm))
    visible = f"{low_nm:g}-{high_nm:g} nm"
    return [f"{start:g}-{end:g} nm of the visible range {visible} is missing: 0 where dark" for start, end in gaps]
