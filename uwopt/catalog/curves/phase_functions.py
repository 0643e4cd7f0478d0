"""Phase functions by name: formulas for a wanted backscatter ratio, Petzold's stations, users' CSVs.

Petzold's functions come from the library jerlov, which keeps the printed tables.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.catalog.columns import CellError, Column, parse_number
from uwopt.catalog.curves.spectra import pure_water
from uwopt.catalog.parts.cell import POSITIVE, Range
from uwopt.catalog.tables import Row, Table, read_table, unknown_columns
from uwopt.documents.whole_file import resolve_path
from uwopt.errors import CatalogError, RangeError
from uwopt.model import phase_formulas, scattering

DEFAULT = "fournier-forand"
FORMULAS = (DEFAULT, "henyey-greenstein")

#: Friendly names of the three stations that the literature uses most.
STATION_ALIASES: Mapping[str, str] = MappingProxyType(
    {"clear-ocean": "AUTEC 8", "coastal-ocean": "HAOCE 11", "turbid-harbor": "NUC 2040"}
)

ANGLE = Column("angle_deg", within=Range(0.0, 180.0), meaning="scattering angle, increasing")
VALUES = {
    column.name: column
    for column in (
        Column("phase_per_sr", within=POSITIVE, meaning="integral over the sphere is 1"),
        Column("vsf_per_m_sr", within=POSITIVE, meaning="volume scattering function, water included"),
    )
}
MIN_ROWS = 4
LAST_DEG = 170.0  # lamps beside a camera scatter back at 150-180 deg
VSF_FIRST_DEG = 1.0  # a function that begins later says nothing about how much is scattered in all
SALINITY_OF_TABLE_PSU = 35.0


@dataclass(frozen=True, eq=False)
class PhaseFunction:
    """A phase function ready for look-up."""

    table: scattering.PhaseTable
    includes_water: bool  # then the molecular term is not added


@cache
def phase_function_names() -> tuple[str, ...]:
    """Names that `phase_function` knows; a CSV does as well."""
    from jerlov import PETZOLD_STATIONS

    stations = (*STATION_ALIASES, *(_station_id(station) for station in PETZOLD_STATIONS))
    return (*FORMULAS, *(f"petzold-{name}" for name in stations))


def phase_function(
    name: str = DEFAULT, *, backscatter_ratio: float, base_dir: Path | None = None
) -> PhaseFunction:
    """The phase function of a name, or of a CSV.

    `fournier-forand` and `henyey-greenstein` are made for the wanted backscatter ratio of the particles;
    `petzold-<station>` and a CSV (angle_deg with phase_per_sr or vsf_per_m_sr) have their own.
    """
    if name.casefold().endswith(".csv"):
        return _custom(resolve_path(name, base_dir))
    key = name.strip().casefold().replace("_", "-").replace(" ", "-").replace("harbour", "harbor")
    if key in FORMULAS:
        return _formula(key, float(backscatter_ratio))
    stations = _stations()
    key = key.removeprefix("petzold-")
    if key not in stations:
        names = phase_function_names()
        near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
        shown = f"did you mean {', '.join(near)}?" if near else f"known are {', '.join(names)}."
        raise CatalogError(f"scene.phase_function = {name!r} is unknown; {shown} A CSV also does.")
    return _petzold(stations[key])


def pure_water_scattering_per_m(
    wavelength_nm: ArrayLike, *, salinity_psu: float = SALINITY_OF_TABLE_PSU
) -> FloatArray:
    """Scattering coefficient b_w of water itself at 20 degC, from the table of Zhang, Hu and He (2009).

    Linear in salinity; a power law of wavelength between the table's 5 nm, and outside it a RangeError.
    """
    water = pure_water()
    wavelength = np.asarray(wavelength_nm, dtype=float)
    first_nm, last_nm = water.wavelength_nm[0], water.wavelength_nm[-1]
    if np.any(wavelength < first_nm) or np.any(wavelength > last_nm):
        raise RangeError(
            f"wavelengths {wavelength.min():g}-{wavelength.max():g} nm are outside the {first_nm:g}-{last_nm:g} nm "
            "of pure_water.csv; choose wavelengths within"
        )
    share = salinity_psu / SALINITY_OF_TABLE_PSU
    table_per_m = water.b_fresh_per_m + share * (water.b_sea_per_m - water.b_fresh_per_m)
    logarithm = np.interp(np.log(wavelength), np.log(water.wavelength_nm), np.log(table_per_m))
    return np.asarray(np.exp(logarithm), dtype=float)


# ---------------------------------------------------------------- formulas and stations


@cache
def _formula(name: str, ratio: float) -> PhaseFunction:
    try:
        if name == DEFAULT:
            index, slope = phase_formulas.fournier_forand_for_backscatter(ratio)
            table = scattering.phase_table_of(
                lambda angle_rad: phase_formulas.fournier_forand_per_sr(angle_rad, index=index, slope=slope)
            )
        else:
            asymmetry = phase_formulas.asymmetry_for_backscatter(ratio)
            table = scattering.phase_table_of(
                lambda angle_rad: phase_formulas.henyey_greenstein_per_sr(np.cos(angle_rad), asymmetry=asymmetry)
            )
    except RangeError as fault:
        raise CatalogError(f"phase function {name}: {fault}.") from None
    return PhaseFunction(table, includes_water=False)


def _station_id(station: str) -> str:
    return station.casefold().replace(" ", "-")


@cache
def _stations() -> Mapping[str, str]:
    """Names of stations in small letters, friendly ones too, to the library's."""
    from jerlov import PETZOLD_STATIONS

    named = {_station_id(station): station for station in PETZOLD_STATIONS}
    return MappingProxyType(named | dict(STATION_ALIASES))


@cache
def _petzold(station: str) -> PhaseFunction:
    import jerlov

    measured = jerlov.petzold_scattering(station)
    table = scattering.phase_table(np.deg2rad(measured.angles_deg), measured.phase_function())
    return PhaseFunction(table, includes_water=True)


# ---------------------------------------------------------------- users' files


def _custom(path: Path) -> PhaseFunction:
    angle_deg, value, includes_water = _read_curve(read_table(path))
    angle_rad = np.deg2rad(angle_deg)
    try:
        if includes_water:
            value = value / scattering.scattering_coefficient_per_m(angle_rad, value)
        table = scattering.phase_table(angle_rad, value)
    except RangeError as fault:
        raise CatalogError(f"{path.name}: {fault}.") from None
    return PhaseFunction(table, includes_water)


def _read_curve(table: Table) -> tuple[FloatArray, FloatArray, bool]:
    """Angles, values, and whether they are a volume scattering function; raises with every fault."""
    faults = list(table.faults) + _header_faults(table)
    names = [name for name in table.header if name in VALUES]
    if not faults:
        pairs: list[tuple[float, float]] = []
        for row in table.rows:
            faults += _stored(row, VALUES[names[0]], pairs)
        faults += _extent_faults(table.file, [angle for angle, _ in pairs], vsf=names[0] == "vsf_per_m_sr")
    if faults:
        raise CatalogError(faults)
    angle_deg, value = np.array(pairs).T
    return angle_deg, value, names[0] == "vsf_per_m_sr"


def _header_faults(table: Table) -> list[str]:
    faults = unknown_columns(table, (ANGLE.name, *VALUES))
    if ANGLE.name not in table.header or sum(name in VALUES for name in table.header) != 1:
        faults.append(f"{table.file}: needs angle_deg and one of {', '.join(VALUES)}.")
    return faults


def _stored(row: Row, column: Column, pairs: list[tuple[float, float]]) -> list[str]:
    """Put a row's angle and value to the others; the faults of the row."""
    cells, faults = [], []
    for wanted in (ANGLE, column):
        text = row.cells.get(wanted.name, "")
        try:
            if text == "":
                raise CellError(f"{wanted.name} is empty; a curve has no gaps")
            cells.append(parse_number(wanted, text))
        except CellError as fault:
            cells.append(math.nan)
            faults.append(f"{row.where()}: {fault}.")
    before = max((angle for angle, _ in pairs if math.isfinite(angle)), default=-math.inf)
    if cells[0] <= before:
        faults.append(
            f"{row.where()}: angle_deg = {cells[0]:g} does not increase (before it {before:g}); sort the rows."
        )
    pairs.append((cells[0], cells[1]))
    return faults


def _extent_faults(file: str, angles_deg: list[float], *, vsf: bool) -> list[str]:
    finite = [angle for angle in angles_deg if math.isfinite(angle)]
    if len(finite) < MIN_ROWS:
        return [f"{file}: has {len(finite)} usable row(s); a phase function needs {MIN_ROWS} or more."]
    faults = []
    if max(finite) < LAST_DEG:
        faults.append(f"{file}: ends at {max(finite):g} deg; it must reach {LAST_DEG:g} deg: extend it.")
    if vsf and min(finite) > VSF_FIRST_DEG:
        faults.append(
            f"{file}: begins at {min(finite):g} deg, so that its integral b is unknown; add angles down to "
            f"{VSF_FIRST_DEG:g} deg or less, or divide by b yourself and give phase_per_sr."
        )
    return faults
