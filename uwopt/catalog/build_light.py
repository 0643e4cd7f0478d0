"""A row of lights.csv becomes a `Light`: flux from power or the reverse, a flash by its guide number."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Literal

from uwopt.catalog.build import Built, Origin, identity, known, known_or
from uwopt.catalog.estimates import ClassEstimate, first_class, required_class
from uwopt.catalog.records import Curve, Light, Quantity, Status, exact
from uwopt.catalog.spectra import light_spectrum
from uwopt.catalog.tables import built_in_rows, read_text
from uwopt.catalog.usercurves import read_channels, read_columns
from uwopt.catalog.userparts import PartRow, parse_dim_levels
from uwopt.errors import CatalogError

CANDELA_SECONDS_PER_GUIDE_NUMBER_SQUARED = 2.15  # on axis; guide number on land in m at ISO 100
WATER_INDEX = 1.34
WIDEST_LOBE_DEG = 179.0
SHALLOW_M, MIDDLE_M = 150.0, 1000.0  # borders of the price and efficacy classes

LightKind = Literal["continuous", "pulsed_led", "flash"]
_KINDS: dict[str, LightKind] = {"continuous": "continuous", "pulsed_led": "pulsed_led", "flash": "flash"}
_CLASS_OF: dict[LightKind, str] = {"continuous": "continuous", "pulsed_led": "pulsed-led", "flash": "flash"}
_BEAMS: dict[str, Literal["disc", "cone", "cosine-power", "tabulated"]] = {
    "disc": "disc",
    "cone": "cone",
    "cosine-power": "cosine-power",
    "tabulated": "tabulated",
}
_MEDIA: dict[str, Literal["air", "water"]] = {"air": "air", "water": "water"}


def build_light(row: PartRow, origin: Origin) -> Built:
    """The light of a row, with what the model needs filled in."""
    kind = _KINDS[row.text("kind")]
    flux, power = _flux_and_power(row, origin, kind)
    angle = known_or(row, "beam_angle_deg", origin, required_class("light-beam-angle-deg", _CLASS_OF[kind]))
    efficacy = known_or(
        row, "flash_efficacy_lm_s_per_j", origin, _class("light-flash-efficacy-lm-s-per-j", kind)
    )
    energy = known(row, "flash_energy_j", origin) or _energy_from_guide_number(row, angle, efficacy)
    price, currency = _price_class(row, kind, flux)
    levels, dim_status = _dimming(row, origin, kind)
    profile, is_candela = _profile(row)
    spectrum_id, spectrum = _spectrum(row, kind)
    mass = required_class("light-mass-g", _CLASS_OF[kind])
    light = Light(
        **identity(row, origin, price, currency, mass.quantity()),
        kind=kind,
        flux_lm=None if kind == "flash" else flux,
        power_w=None if kind == "flash" else power,
        output_factor=_output_factor(row, origin, kind),
        beam=_BEAMS.get(row.text("beam"), "tabulated" if profile else "cosine-power"),
        beam_angle_deg=angle,
        beam_medium=_MEDIA.get(row.text("beam_medium"), "not stated"),
        beam_profile=profile,
        beam_profile_is_candela=is_candela,
        beam_profile_id=row.text("beam_profile"),
        spectrum_id=spectrum_id,
        spectrum=spectrum,
        front_radius_mm=row.number("front_radius_mm") or 20.0,
        dim_levels=levels,
        dim_min_frac=row.number("dim_min_frac") or 0.0,
        dim_status=dim_status,
        min_pulse_us=known_or(row, "min_pulse_us", origin, _class("light-min-pulse-us", kind)),
        max_pulse_us=known_or(row, "max_pulse_us", origin, _class("light-max-pulse-us", kind)),
        max_duty_frac=known_or(row, "max_duty_frac", origin, _class("light-max-duty-frac", kind)),
        max_rate_hz=known_or(row, "max_rate_hz", origin, _class("light-max-rate-hz", kind)),
        flash_energy_j=energy if kind == "flash" else None,
        flash_efficacy_lm_s_per_j=efficacy,
        flash_duration_us=known_or(row, "flash_duration_us", origin, _class("light-flash-duration-us", kind)),
        recycle_s=known_or(row, "recycle_s", origin, _class("light-recycle-s", kind)),
        charging_efficiency_frac=known_or(
            row, "charging_efficiency_frac", origin, _class("light-charging-efficiency-frac", kind)
        ),
        guide_number_m=row.number("guide_number_m"),
        colour_temperature_k=row.number("colour_temperature_k"),
        depth_rating_m=row.number("depth_rating_m"),
    )
    return Built(light, tuple(_lacking(light)))


def _lacking(light: Light) -> list[str]:
    lacks = []
    if light.kind == "flash" and light.flash_energy_j is None:
        lacks.append("no flash energy or guide number stated")
    if light.kind != "flash" and light.flux_lm is None:
        lacks.append("no flux or power stated")
    if light.beam == "tabulated" and light.beam_profile is None:
        lacks.append("no beam profile")
    return lacks


def _class(prefix: str, kind: LightKind) -> ClassEstimate | None:
    return first_class(prefix, _CLASS_OF[kind])


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


@cache
def _built_in_profiles() -> dict[str, tuple[Curve, bool]]:
    points: dict[str, list[tuple[float, float]]] = {}
    is_candela: dict[str, bool] = {}
    for row in built_in_rows("beam_profiles.csv"):
        points.setdefault(row["profile_id"], []).append((float(row["angle_deg"]), float(row["intensity"])))
        is_candela[row["profile_id"]] = row["unit"] == "candela"
    return {
        name: (Curve(tuple(x for x, _ in values), tuple(y for _, y in values)), is_candela[name])
        for name, values in points.items()
    }


def _profile(row: PartRow) -> tuple[Curve | None, bool]:
    """A built-in profile by id, a user's CSV (relative: scaled to the flux) or IES file (candela)."""
    name = row.text("beam_profile")
    if not name:
        return None, False
    if name.casefold().endswith(".ies"):
        return _ies_profile((row.base_dir or Path()) / name), True
    if name.casefold().endswith(".csv"):
        return read_channels((row.base_dir or Path()) / name, "intensity")["mono"], False
    profiles = _built_in_profiles()
    if name not in profiles:
        raise CatalogError(
            f"{row.where}: beam_profile = {name!r} is no CSV or IES file, and none of {', '.join(profiles)}."
        )
    return profiles[name]


def _ies_profile(path: Path) -> Curve:
    from uwopt.catalog.photometry import parse_ies

    try:
        photometry = parse_ies(read_text(path))
    except CatalogError as fault:
        raise CatalogError([f"{path.name}: {words}" for words in fault.faults]) from None
    return Curve(tuple(photometry.angle_deg.tolist()), tuple(photometry.candela.tolist()))


def _spectrum(row: PartRow, kind: LightKind) -> tuple[str, Curve | None]:
    name = row.text("spectrum")
    if not name:
        return ("xenon-flash" if kind == "flash" else "generic-led"), None
    if name.casefold().endswith(".csv"):
        columns = read_columns((row.base_dir or Path()) / name, ("relative_power",))
        return name, Curve(
            tuple(columns["wavelength_nm"].tolist()), tuple(columns["relative_power"].tolist())
        )
    try:
        light_spectrum(name)
    except CatalogError as fault:
        raise CatalogError(f"{row.where}: {fault}") from None
    return name, None
