"""Spectra, water types and glasses: the tables that ship with uwopt, and users' own CSVs.

Everything is read when first asked for and kept. Values stand at their own wavelengths; bringing them to
one grid, and the rules beyond a table's ends, are the model's business.
"""

from __future__ import annotations

import difflib
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Literal

import numpy as np

from uwopt.arrays import FloatArray
from uwopt.catalog.curves.usercurves import read_columns
from uwopt.catalog.tables import built_in_rows
from uwopt.documents.faults import plain_name
from uwopt.documents.whole_file import resolve_path
from uwopt.errors import CatalogError

WaterTable = Literal["solonenko-mobley", "measured", "custom"]

SECOND_RADIATION_CONSTANT_NM_K = 1.438776877e7  # h c / k, CODATA 2018
GRID_NM = (380.0, 780.0, 1.0)  # of spectra that are formulas rather than tables

#: No spectrum of a bare xenon flash tube is published in the sources read; this is the usual proxy.
XENON_PROXY_K = 6000.0


#: Williamson and Hollins (2022), as the library jerlov names it.
MEASURED_SOURCE = "williamson2022"
MEASURED_NOTE = "a and b model_extrapolation at 300-411 and 716-800 nm"


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Values against wavelength, with where they come from."""

    name: str
    wavelength_nm: FloatArray
    value: FloatArray
    source: str = ""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class WaterProfile:
    """Absorption, scattering and attenuation of one water; `kd_per_m` stands at `kd_wavelength_nm`."""

    name: str
    table: WaterTable
    wavelength_nm: FloatArray
    attenuation_per_m: FloatArray
    a_per_m: FloatArray | None
    b_per_m: FloatArray | None
    kd_wavelength_nm: FloatArray | None
    kd_per_m: FloatArray | None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class PureWater:
    """Absorption and scattering of water itself, at 20 degC."""

    wavelength_nm: FloatArray
    a_per_m: FloatArray
    b_sea_per_m: FloatArray  # salinity 35, 20 degC
    b_fresh_per_m: FloatArray


@dataclass(frozen=True, slots=True)
class GlassFormula:
    """Dispersion formula of a material: its name and coefficients by index."""

    formula: str
    coefficients: FloatArray


@dataclass(frozen=True, slots=True)
class _Group:
    """Rows of one name in a long table."""

    columns: Mapping[str, list[str]] = field(default_factory=dict)

    def numbers(self, column: str) -> FloatArray:
        return np.array([float(text) if text else np.nan for text in self.columns[column]])


@cache
def _groups(file: str, by: str) -> Mapping[str, _Group]:
    groups: dict[str, dict[str, list[str]]] = {}
    for row in built_in_rows(file):
        columns = groups.setdefault(row[by], {name: [] for name in row})
        for name, text in row.items():
            columns[name].append(text)
    return MappingProxyType({name: _Group(columns) for name, columns in groups.items()})


@cache
def photopic() -> Spectrum:
    """V(lambda), CIE 1924."""
    rows = list(built_in_rows("photopic_v.csv"))
    wavelength_nm = np.array([float(row["wavelength_nm"]) for row in rows])
    return Spectrum("photopic", wavelength_nm, np.array([float(row["V"]) for row in rows]), "CIE 1924")


@cache
def light_spectrum_names() -> tuple[str, ...]:
    """Ids that `light_spectrum` knows; besides them `planck-<kelvin>`."""
    return ("generic-led", "xenon-flash", *sorted(_groups("light_spectra.csv", "name")))


@cache
def light_spectrum(spectrum_id: str) -> Spectrum:
    """Relative power per nm of a light: `generic-led`, `xenon-flash`, `planck-2856`, or a table's name."""
    key = plain_name(spectrum_id)
    if key == "generic_led":
        return _generic_led()
    if key == "xenon_flash":
        note = f"no spectrum of a xenon tube at hand: a black body of {XENON_PROXY_K:g} K stands for it"
        return Spectrum("xenon-flash", *_planck(XENON_PROXY_K), "proxy", (note,))
    if key.startswith("planck_"):
        return _named_planck(spectrum_id)
    groups = _groups("light_spectra.csv", "name")
    by_key = {plain_name(name): name for name in groups} | {
        plain_name(name.removeprefix("CIE ")): name for name in groups if name.startswith("CIE ")
    }
    if key not in by_key:
        raise CatalogError(_unknown("light spectrum", spectrum_id, (*light_spectrum_names(), "planck-2856")))
    group = groups[by_key[key]]
    return Spectrum(
        by_key[key], group.numbers("wavelength_nm"), group.numbers("relative_power"), "light_spectra.csv"
    )


def _named_planck(spectrum_id: str) -> Spectrum:
    try:
        temperature_k = float(spectrum_id.split("-", 1)[-1].removesuffix("K").removesuffix("k"))
    except ValueError:
        temperature_k = 0.0
    if not 1000.0 <= temperature_k <= 25000.0:
        raise CatalogError(f"light spectrum {spectrum_id!r}: write planck-<kelvin> with 1000 to 25000 K.")
    return Spectrum(spectrum_id, *_planck(temperature_k), "Planck's law")


def _grid_nm() -> FloatArray:
    first, last, step = GRID_NM
    return np.arange(first, last + 0.5 * step, step)


def _planck(temperature_k: float) -> tuple[FloatArray, FloatArray]:
    wavelength_nm = _grid_nm()
    exponent = SECOND_RADIATION_CONSTANT_NM_K / (wavelength_nm * temperature_k)
    power = wavelength_nm**-5.0 / np.expm1(exponent)
    return wavelength_nm, power / power.max()


def _generic_led() -> Spectrum:
    """Sum of Gaussian bands, each weight times a normal density."""
    wavelength_nm = _grid_nm()
    power = np.zeros_like(wavelength_nm)
    for row in built_in_rows("generic_led.csv"):
        weight, mean_nm, sigma_nm = (float(row[name]) for name in ("weight", "mean_nm", "sigma_nm"))
        power += (
            weight
            / (sigma_nm * np.sqrt(2 * np.pi))
            * np.exp(-0.5 * ((wavelength_nm - mean_nm) / sigma_nm) ** 2)
        )
    return Spectrum("generic-led", wavelength_nm, power, "generic_led.csv")


@cache
def seafloor_names() -> tuple[str, ...]:
    """Names that `seafloor_reflectance` knows: flat values first, then measured spectra."""
    return (*_flat_seafloors(), *sorted(_groups("bottom_reflectance.csv", "type")))


@cache
def _flat_seafloors() -> dict[str, float]:
    return {row["name"]: float(row["reflectance"]) for row in built_in_rows("seafloor_flat.csv")}


def seafloor_reflectance(floor: str | float, base_dir: Path | None = None) -> Spectrum:
    """Reflectance 0..1 of a floor: a number, a name, or a CSV with wavelength_nm and reflectance."""
    if isinstance(floor, (int, float)):
        if not 0.0 <= float(floor) <= 1.0:
            raise CatalogError(f"seafloor reflectance {floor:g} must be at least 0 and at most 1.")
        return _flat(f"{float(floor):g}", float(floor), "mission")
    if floor.casefold().endswith(".csv"):
        columns = read_columns(resolve_path(floor, base_dir), ("reflectance",))
        return Spectrum(floor, columns["wavelength_nm"], columns["reflectance"], floor)
    key = plain_name(floor)
    flat = {plain_name(name): (name, value) for name, value in _flat_seafloors().items()}
    if key in flat:
        return _flat(*flat[key], "seafloor_flat.csv")
    groups = _groups("bottom_reflectance.csv", "type")
    names = {plain_name(name): name for name in groups}
    if key not in names:
        raise CatalogError(
            _unknown("seafloor", floor, seafloor_names()) + " A number 0..1 or a CSV also does."
        )
    group = groups[names[key]]
    doubtful = any(quality == "doubtful" for quality in group.columns["quality"])
    return Spectrum(
        names[key],
        group.numbers("wavelength_nm"),
        group.numbers("reflectance"),
        group.columns["source"][0],
        ("part of this spectrum is doubtful in its source",) if doubtful else (),
    )


def _flat(name: str, value: float, source: str) -> Spectrum:
    ends_nm = np.array(GRID_NM[:2])
    return Spectrum(name, ends_nm, np.full(2, value), source)


@cache
def water_types(table: WaterTable) -> tuple[str, ...]:
    """Jerlov types that a table covers."""
    if table == "measured":
        from jerlov import get_source

        return tuple(get_source(MEASURED_SOURCE).water_types)
    return tuple(_groups("jerlov_iop.csv", "water_type")) if table == "solonenko-mobley" else ()


def _measured(water: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Wavelengths, a and b of the measured table, from the library that keeps it.

    The library warns of every flagged row; `MEASURED_NOTE` says the same once.
    """
    import jerlov

    profile = jerlov.water(water, source=MEASURED_SOURCE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jerlov.ProvenanceWarning)
        wavelength_nm = np.asarray(profile.wavelengths, float)
        return wavelength_nm, np.asarray(profile.a(wavelength_nm)), np.asarray(profile.b(wavelength_nm))


def water_profile(
    water: str,
    table: Literal["solonenko-mobley", "measured"] | None = None,
    base_dir: Path | None = None,
) -> WaterProfile:
    """Optical properties of a Jerlov type (`measured` where that table has it), or of a user's CSV."""
    if water.casefold().endswith(".csv"):
        return _custom_water(resolve_path(water, base_dir))
    names = {plain_name(name): name for name in water_types("solonenko-mobley")}
    key = plain_name(water.removeprefix("jerlov").removeprefix("Jerlov").lstrip(" -_"))
    if key not in names:
        raise CatalogError(_unknown("water", water, tuple(names.values())) + " A CSV profile also does.")
    return _jerlov(names[key], table)


@cache
def _jerlov(water: str, table: Literal["solonenko-mobley", "measured"] | None) -> WaterProfile:
    measured_types = water_types("measured")
    if table == "measured" and water not in measured_types:
        raise CatalogError(
            f"water {water}: the measured table covers {', '.join(measured_types)} only; "
            "use water_table: solonenko-mobley."
        )
    used: WaterTable = table or ("measured" if water in measured_types else "solonenko-mobley")
    modelled = _groups("jerlov_iop.csv", "water_type")[water]
    if used == "measured":
        wavelength_nm, a_per_m, b_per_m = _measured(water)
        notes: tuple[str, ...] = (MEASURED_NOTE,)
    else:
        wavelength_nm = modelled.numbers("wavelength_nm")
        a_per_m, b_per_m = modelled.numbers("a_per_m"), modelled.numbers("b_per_m")
        notes = _water_notes(modelled)
    return WaterProfile(
        water,
        used,
        wavelength_nm,
        a_per_m + b_per_m,
        a_per_m,
        b_per_m,
        modelled.numbers("wavelength_nm"),
        modelled.numbers("kd_per_m"),
        notes,
    )


def _water_notes(group: _Group) -> tuple[str, ...]:
    """Which rows of the table are not as published, by status and wavelength span."""
    wavelengths_nm = group.numbers("wavelength_nm")
    notes = []
    for column, statuses in group.columns.items():
        if not column.endswith("status"):
            continue
        for status in sorted(set(statuses) - {"published", "ok"}):
            at_nm = wavelengths_nm[[text == status for text in statuses]]
            quantity = column.removesuffix("_status").removesuffix("status") or "a and b"
            notes.append(f"{quantity} {status} at {_spans(at_nm)} nm")
    return tuple(notes)


def _spans(wavelengths_nm: FloatArray) -> str:
    if wavelengths_nm.size <= 5:
        return ", ".join(f"{value:g}" for value in wavelengths_nm)
    breaks = np.flatnonzero(np.diff(wavelengths_nm) > np.min(np.diff(wavelengths_nm)) * 1.5)
    pieces = np.split(wavelengths_nm, breaks + 1)
    return " and ".join(f"{piece[0]:g}-{piece[-1]:g}" for piece in pieces)


def _custom_water(path: Path) -> WaterProfile:
    columns = read_columns(path, ("attenuation_per_m", "a_per_m", "b_per_m", "kd_per_m"))
    a_per_m, b_per_m = columns.get("a_per_m"), columns.get("b_per_m")
    attenuation_per_m = columns.get("attenuation_per_m")
    if attenuation_per_m is None:
        if a_per_m is None or b_per_m is None:
            raise CatalogError(f"{path.name}: needs attenuation_per_m, or both a_per_m and b_per_m.")
        attenuation_per_m = a_per_m + b_per_m
    elif a_per_m is None and b_per_m is not None:
        a_per_m = attenuation_per_m - b_per_m
    elif b_per_m is None and a_per_m is not None:
        b_per_m = attenuation_per_m - a_per_m
    elif (
        a_per_m is not None
        and b_per_m is not None
        and not np.allclose(a_per_m + b_per_m, attenuation_per_m, rtol=0.01)
    ):
        raise CatalogError(f"{path.name}: attenuation_per_m differs from a_per_m + b_per_m by more than 1 %.")
    for name, values in (("a_per_m", a_per_m), ("b_per_m", b_per_m)):
        if values is not None and np.any(values < 0):
            raise CatalogError(f"{path.name}: {name} = attenuation less the other part is negative.")
    kd_per_m = columns.get("kd_per_m")
    wavelength_nm = columns["wavelength_nm"]
    return WaterProfile(
        path.stem,
        "custom",
        wavelength_nm,
        attenuation_per_m,
        a_per_m,
        b_per_m,
        None if kd_per_m is None else wavelength_nm,
        kd_per_m,
    )


@cache
def pure_water() -> PureWater:
    """Absorption (20 degC, no salt) and scattering of pure water, 350-800 nm."""
    names = (
        "wavelength_nm",
        "a_per_m",
        "bw_zhang2009_S35_T20_per_m",
        "bw_zhang2009_S0_T20_per_m",
    )
    rows = list(built_in_rows("pure_water.csv"))
    return PureWater(*(np.array([float(row[name]) for row in rows]) for name in names))


@cache
def glass_names() -> tuple[str, ...]:
    """Ids of materials with a dispersion formula."""
    return tuple(sorted(_groups("refractive_index_coefficients.csv", "material")))


@cache
def glass_coefficients(material: str) -> GlassFormula:
    """The dispersion formula of a port's material, by id such as `n_bk7`."""
    groups = _groups("refractive_index_coefficients.csv", "material")
    names = {plain_name(name): name for name in groups}
    if plain_name(material) not in names:
        raise CatalogError(_unknown("glass", material, glass_names()))
    group = groups[names[plain_name(material)]]
    order = np.argsort(group.numbers("index"))
    return GlassFormula(group.columns["formula"][0], group.numbers("coefficient")[order])


def quan_fry_coefficients() -> FloatArray:
    """n0 ... n9 of Quan and Fry (1995) for sea water."""
    return glass_coefficients("seawater_quan_fry").coefficients


def _unknown(what: str, name: str, known: Iterable[str]) -> str:
    names = list(known)
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    shown = f"did you mean {', '.join(near)}?" if near else f"known are {', '.join(names)}."
    return f"{what} {name!r} is unknown; {shown}"
