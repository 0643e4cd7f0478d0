"""What is stated of a light becomes a `Light`: flux from power or the reverse, a flash by its guide number."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwopt.catalog.curves.spectra import light_spectrum
from uwopt.catalog.curves.usercurves import read_channels, read_columns
from uwopt.catalog.estimates import ClassEstimate, required_class
from uwopt.catalog.parts.light import Light, LightKind
from uwopt.catalog.parts.quantity import Curve, Quantity, Status, exact
from uwopt.catalog.readers.reading import (
    Built,
    Origin,
    Reader,
    identity,
    inline_fields,
    is_csv,
    known,
    row_fields,
    user_number,
)
from uwopt.catalog.readers.tabled import beam_profiles
from uwopt.catalog.tables import read_text
from uwopt.catalog.userparts import PartRow, parse_dim_levels
from uwopt.documents.faults import plain_name
from uwopt.documents.whole_file import resolve_path
from uwopt.errors import CatalogError

CANDELA_SECONDS_PER_GUIDE_NUMBER_SQUARED = 2.15  # on axis; guide number on land in m at ISO 100
WATER_INDEX = 1.34
WIDEST_LOBE_DEG = 179.0
SHALLOW_M, MIDDLE_M = 150.0, 1000.0  # borders of the price and efficacy classes

_CLASS_OF: dict[str, str] = {"continuous": "continuous", "pulsed_led": "pulsed-led", "flash": "flash"}

# ---------------------------------------------------------------- rows of tables


def from_row(row: PartRow, origin: Origin) -> Built:
    """The light of a row, with what the model needs filled in."""
    kind: LightKind = row.cells["kind"]  # pyrefly: ignore[bad-assignment]
    made = row_fields(Light, row, origin, (_CLASS_OF[kind],))
    flux, power = _flux_and_power(row, origin, kind)
    price, currency = _price_class(row, kind, flux)
    levels, dim_status = _dimming(row, origin, kind)
    profile, is_candela = _profile_of_row(row)
    spectrum_id, spectrum = _spectrum_of_row(row, kind)
    made |= identity(row, origin, price, currency, made["mass_g"])
    energy = known(row, "flash_energy_j", origin) or _energy_from_guide_number(
        row, made.get("beam_angle_deg"), made.get("flash_efficacy_lm_s_per_j")
    )
    if kind == "flash":
        made |= {"flux_lm": None, "power_w": None, "flash_energy_j": energy}
    else:
        made |= {"flux_lm": flux, "power_w": power, "flash_energy_j": None}
    made |= {"dim_levels": levels, "dim_status": dim_status, "spectrum_id": spectrum_id, "spectrum": spectrum}
    made |= _profile_fields(profile, is_candela, row.text("beam_profile"), row.text("beam"))
    made["output_factor"] = _output_factor(row, origin, kind)
    made |= _supply_fields(row, origin)
    light = Light(**made)
    return Built(light, tuple(_lacking(row, light)))


def _supply_fields(row: PartRow, origin: Origin) -> dict[str, Any]:
    """Whose power it takes: a product's row that does not say leaves it open; a torch is switched by hand."""
    supply = row.text("supply") or ("unknown" if origin == "published" else "external")
    own = {"switchable": "no"} if supply == "battery" and not row.text("switchable") else {}
    return {"supply": supply} | own


def _lacking(row: PartRow, light: Light) -> list[str]:
    lacks = []
    if row.number("beam_angle_deg") is None and light.beam_profile is None:
        lacks.append("no beam angle or profile stated")
    if light.kind == "flash" and light.flash_energy_j is None:
        lacks.append("no flash energy or guide number stated")
    if light.kind != "flash" and light.flux_lm is None:
        lacks.append("no flux or power stated")
    if light.beam == "tabulated" and light.beam_profile is None:
        lacks.append("no beam profile")
    return lacks


def _flux_and_power(row: PartRow, origin: Origin, kind: LightKind) -> tuple[Quantity | None, Quantity | None]:
    """Both as stated, or one from the other by the efficacy of the class; while the lamp is on."""
    flux, power = known(row, "flux_lm", origin), known(row, "power_w", origin)
    if kind == "flash" or (flux is None) == (power is None):
        return flux, power
    efficacy = required_class("light-efficacy-lm-per-w", _efficacy_class(row, kind))
    if flux is None and power is not None:
        return efficacy.quantity(power.value), power
    return flux, None if flux is None else efficacy.divided_into(flux.value)


def _efficacy_class(row: PartRow, kind: LightKind) -> str:
    if kind == "pulsed_led":
        return "pulsed-led"
    return "led-6000m-2010s" if (row.number("depth_rating_m") or 0.0) > MIDDLE_M else "led"


def _output_factor(row: PartRow, origin: Origin, kind: LightKind) -> Quantity:
    """Measured where the row has it; nameplate lumens are derated; a flash's light is counted outside."""
    stated = row.number("output_factor")
    if stated is not None:
        return exact(stated, "measured" if origin == "published" else origin, row.text("source_url"))
    if kind == "flash":
        return exact(1.0, "derived", "guide number and efficacy count the light that leaves the flash")
    return required_class("light-output-factor", "nameplate").quantity()


def peak_candela_per_lumen(beam_angle_deg: float) -> float:
    """On-axis intensity of one lumen in a cosine-power lobe of that full angle at half power."""
    half_rad = math.radians(min(beam_angle_deg, WIDEST_LOBE_DEG) / 2.0)
    exponent = math.log(0.5) / math.log(math.cos(half_rad))
    return (exponent + 1.0) / (2.0 * math.pi)


def _energy_from_guide_number(
    row: PartRow, angle: Quantity | None, efficacy: Quantity | None
) -> Quantity | None:
    """Energy that puts 2.15 GN^2 candela seconds on the axis of the flash's beam in air."""
    guide_number_m = row.number("guide_number_m")
    if guide_number_m is None or angle is None or efficacy is None:
        return None
    candela_s = CANDELA_SECONDS_PER_GUIDE_NUMBER_SQUARED * guide_number_m**2
    # Behind a flat front the axis gains n^2 in water: I_w(0) = n^2 I_a(0), the flux being the same.
    narrowing = WATER_INDEX**2 if row.text("beam_medium") == "water" else 1.0

    def energy_j(angle_deg: float, lm_s_per_j: float) -> float:
        return candela_s * narrowing / peak_candela_per_lumen(angle_deg) / lm_s_per_j

    return Quantity(
        energy_j(angle.value, efficacy.value),
        energy_j(angle.low, efficacy.high),
        energy_j(angle.high, efficacy.low),
        "estimated",
        f"guide number {guide_number_m:g} m: 2.15 GN^2 cd s on axis, {angle.value:g} deg lobe, "
        f"{efficacy.value:g} lm s/J",
    )


def _price_class(
    row: PartRow, kind: LightKind, flux: Quantity | None
) -> tuple[ClassEstimate | Quantity, str]:
    """Light per money by depth class; pulsed LEDs and flashes as a whole."""
    if kind != "continuous" or flux is None:
        return required_class("light-price", "pulsed-led" if kind == "pulsed_led" else "flash"), "USD"
    depth_m = row.number("depth_rating_m")
    if depth_m is None:
        name = "depth-unknown"
    else:
        name = "to-150m" if depth_m <= SHALLOW_M else "to-1000m" if depth_m <= MIDDLE_M else "to-6000m"
    light_per_money = required_class("light-flux-lm-per-price", name)
    return light_per_money.divided_into(flux.value), light_per_money.currency


def _dimming(row: PartRow, origin: Origin, kind: LightKind) -> tuple[tuple[float, ...] | None, Status]:
    """Stated steps; else steps of unknown size (halving a flash, equal shares of a lamp); else only full."""
    stated = row.text("dim_levels")
    if stated:
        return parse_dim_levels(stated), origin
    steps = int(row.number("dim_step_count") or 1)
    if kind == "flash":
        return tuple(0.5**step for step in range(steps)), "estimated"
    return tuple((steps - step) / steps for step in range(steps)), "estimated"


def _profile_of_row(row: PartRow) -> tuple[Curve | None, bool]:
    """A built-in profile by id, a user's CSV (relative: scaled to the flux) or IES file (candela)."""
    name = row.text("beam_profile")
    if not name:
        return None, False
    if name.casefold().endswith(".ies"):
        return _ies_profile((row.base_dir or Path()) / name), True
    if is_csv(name):
        return read_channels((row.base_dir or Path()) / name, "intensity")["mono"], False
    profiles = beam_profiles()
    if name not in profiles:
        raise CatalogError(
            f"{row.where}: beam_profile = {name!r} is no CSV or IES file, and none of {', '.join(profiles)}."
        )
    return profiles[name]


def _ies_profile(path: Path) -> Curve:
    from uwopt.catalog.curves.photometry import parse_ies

    try:
        photometry = parse_ies(read_text(path))
    except CatalogError as fault:
        raise CatalogError([f"{path.name}: {words}" for words in fault.faults]) from None
    return Curve(tuple(photometry.angle_deg.tolist()), tuple(photometry.candela.tolist()))


def _spectrum_of_row(row: PartRow, kind: LightKind) -> tuple[str, Curve | None]:
    name = row.text("spectrum")
    if not name:
        return _own_spectrum(kind), None
    if is_csv(name):
        return name, _spectrum_file((row.base_dir or Path()) / name)
    try:
        light_spectrum(name)
    except CatalogError as fault:
        raise CatalogError(f"{row.where}: {fault}") from None
    return name, None


def _own_spectrum(kind: LightKind) -> str:
    return "xenon-flash" if kind == "flash" else "generic-led"


def _spectrum_file(path: Path) -> Curve:
    columns = read_columns(path, ("relative_power",))
    return Curve(tuple(columns["wavelength_nm"].tolist()), tuple(columns["relative_power"].tolist()))


def _profile_fields(profile: Curve | None, is_candela: bool, name: str, beam: str) -> dict[str, Any]:
    """A beam whose shape is not stated is that of its profile, else a cosine to a power."""
    return {
        "beam": beam or ("cosine-power" if profile is None else "tabulated"),
        "beam_profile": profile,
        "beam_profile_is_candela": is_candela,
        "beam_profile_id": name,
    }


# ---------------------------------------------------------------- inline records


def from_inline(values: Mapping[str, Any], base_dir: Path | None) -> Light:
    """The record of an inline light; a half-angle in water becomes the full angle there."""
    made = inline_fields(Light, "light", values)
    kind: LightKind = made.setdefault("kind", "continuous" if made["flash_energy_j"] is None else "flash")
    if kind == "flash" and made["flash_duration_at_frac"] is None:
        made["flash_duration_at_frac"] = required_class("light-flash-duration-at-frac", "flash").quantity()
    half_deg = values["beam_half_angle_deg"]
    if half_deg is not None:
        made |= {"beam_angle_deg": user_number(2.0 * half_deg), "beam_medium": "water"}
    name, spectrum_name = values["beam_profile"], values["spectrum"] or _own_spectrum(kind)
    profile, is_candela = (None, False) if name is None else _profile(name, base_dir)
    own = _spectrum_file(resolve_path(spectrum_name, base_dir)) if is_csv(spectrum_name) else None
    made |= _profile_fields(profile, is_candela, name or "", values["beam"] or "")
    return Light(**made | {"spectrum_id": spectrum_name, "spectrum": own})


def _profile(name: str, base_dir: Path | None) -> tuple[Curve, bool]:
    if is_csv(name):
        columns = read_columns(resolve_path(name, base_dir), ("intensity",))
        return Curve(tuple(columns["angle_deg"].tolist()), tuple(columns["intensity"].tolist())), False
    by_name = {plain_name(known_id): found for known_id, found in beam_profiles().items()}
    if plain_name(name) not in by_name:
        known_ids = ", ".join(sorted(beam_profiles()))
        raise CatalogError(f"beam_profile {name!r} is unknown; known are {known_ids}, or name a CSV.")
    return by_name[plain_name(name)]


READER = Reader(from_row, from_inline)
