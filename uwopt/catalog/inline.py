"""Parts written into a system file: what they may hold, and the records they become.

An inline part states only what the model uses; the keys are the fields of the records, as bare numbers.
What it leaves out is not checked against anything (`inline=True`), and these defaults stand in for it:

    camera  12 bits, global shutter, mono; gain unknown: full scale at saturation; up to 48 dB of gain
    lens    F1.4 to F16, 90 % transmission (80 to 100 %)
    port    index 1.5, 10 mm thick
    light   continuous, all nameplate lumens leave the window (output_factor 1), generic white LED
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError, ValidationInfo, field_validator, model_validator

from uwopt.catalog.parts.cell import LARGEST, SMALLEST, beyond
from uwopt.catalog.parts.kinds import ALL_FIELDS
from uwopt.catalog.records import Camera, Curve, Lens, Light, Port, Quantity, exact
from uwopt.errors import CatalogError
from uwopt.fields import (
    CHOICE,
    NUMBER,
    WHOLE,
    NonNegative,
    Number,
    Positive,
    Section,
    Share,
    Text,
    Texts,
    refusal,
    to_number,
    to_text,
)

MAX_GAIN_DB = 48.0  # of a camera that does not say
F_NUMBERS = (1.4, 16.0)
TRANSMISSION = Quantity(0.9, 0.8, 1.0, "estimated", "default of an inline lens")
REFRACTIVE_INDEX = Quantity(1.5, 1.46, 1.52, "estimated", "default of an inline port")
THICKNESS_MM = Quantity(10.0, 5.0, 15.0, "estimated", "default of an inline port")
FLAT_NM = (200.0, 1200.0)  # span of an efficiency that is one number

#: Other names that an inline record may use, by kind.
SYNONYMS: dict[str, dict[str, str]] = {
    "camera": {"qe": "quantum_efficiency", "qe_curve": "quantum_efficiency", "sensor_chip": "chip"},
    "lens": {"transmission": "transmission_frac", "f_min": "f_number_min", "f_max": "f_number_max"},
    "port": {"radius_mm": "outer_radius_mm"},
    "light": {"luminous_flux_lm": "flux_lm", "spectrum_id": "spectrum", "beam_profile_id": "beam_profile"},
}

Kind = Literal["camera", "lens", "port", "light"]
SPANS = {field.name: field.cell.span for field in ALL_FIELDS}
PositiveShare = Annotated[float, Field(gt=0, le=1), NUMBER]


def renamed(kind: str, data: Any) -> Any:
    """An inline record with its synonyms under their own names."""
    if not isinstance(data, Mapping):
        return data
    plain = dict(data)
    for other, name in SYNONYMS[kind].items():
        if other in plain:
            if plain.get(name) is not None:
                raise refusal(f"holds both {other} and {name}", "keep one of them")
            plain[name] = plain.pop(other)
    return plain


def _number_or_name(value: Any) -> float | str:
    if isinstance(value, str) and not value.strip()[:1].isdigit():
        return to_text(value)
    if isinstance(value, str) and value.strip().casefold().endswith(".csv"):
        return to_text(value)
    number = to_number(value)
    if not 0 < number <= 1:
        raise refusal("is not an efficiency above 0 and up to 1", "write 0.6 for 60 %")
    return number


class InlinePart(Section):
    """What any inline part may hold besides its own keys."""

    id: Text | None = Field(default=None, description="name of the part in results")
    manufacturer: Text | None = Field(default=None, description="maker of the part")
    model: Text | None = Field(default=None, description="maker's name of the part")
    price: NonNegative | None = Field(default=None, description="price of one piece")
    currency: Text = Field(default="USD", description="currency of the price, three letters")
    mass_g: NonNegative | None = Field(default=None, description="mass of one piece in grams")
    note: Text | None = Field(default=None, description="remark")

    @field_validator("*")
    @classmethod
    def _of_a_part(cls, value: Any, info: ValidationInfo) -> Any:
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        fault = (
            beyond(float(value), SPANS.get(info.field_name or "", (SMALLEST, LARGEST))) if is_number else ""
        )
        if fault:
            raise refusal(f"{fault}, as none is made", "check its unit")
        return value


class InlineCamera(InlinePart):
    """A camera in a system file."""

    resolution_x_px: Annotated[int, Field(ge=1, le=100_000), WHOLE] = Field(
        description="image width in pixels"
    )
    resolution_y_px: Annotated[int, Field(ge=1, le=100_000), WHOLE] = Field(
        description="image height in pixels"
    )
    pixel_pitch_um: Annotated[float, Field(gt=0, le=100), NUMBER] = Field(
        description="pixel pitch in micrometres"
    )
    read_noise_e: NonNegative = Field(description="temporal dark noise in electrons")
    quantum_efficiency: Annotated[float | str, BeforeValidator(_number_or_name)] = Field(
        description="quantum efficiency: a number 0..1, the id of a curve, or a CSV with wavelength_nm and qe"
    )
    colour: Annotated[Literal["mono", "colour"], CHOICE] = Field(
        default="mono", description="sensor: mono or colour"
    )
    shutter: Annotated[Literal["global", "rolling"], CHOICE] = Field(
        default="global", description="shutter: global or rolling"
    )
    chip: Text | None = Field(default=None, description="type of the sensor")
    mounts: Texts = Field(default=(), description="lens mounts, such as [C]")
    interface: Text | None = Field(default=None, description="interface, such as USB3")
    bit_depth: Annotated[int, Field(ge=1, le=32), WHOLE] = Field(
        default=12, description="bits of the transmitted image"
    )
    gain_dn_per_e: Positive | None = Field(default=None, description="system gain at 0 dB in DN per electron")
    gain_bits: Annotated[int, Field(ge=1, le=32), WHOLE] | None = Field(
        default=None, description="bit depth that gain_dn_per_e refers to; bit_depth unless given"
    )
    max_gain_db: NonNegative = Field(default=MAX_GAIN_DB, description="highest gain setting in decibels")
    saturation_e: Positive | None = Field(default=None, description="saturation capacity in electrons")
    dark_current_e_s: NonNegative | None = Field(
        default=None, description="dark current in electrons per second"
    )
    black_level_dn: NonNegative = Field(default=0.0, description="offset of the image in digital numbers")
    prnu_frac: Share | None = Field(default=None, description="photo response non-uniformity, a share 0..1")
    min_exposure_us: NonNegative | None = Field(default=None, description="shortest exposure in microseconds")
    max_exposure_us: Positive | None = Field(default=None, description="longest exposure in microseconds")
    exposure_offset_us: NonNegative | None = Field(
        default=None, description="time that the sensor adds to each exposure, in microseconds"
    )
    max_frame_rate_hz: Positive | None = Field(default=None, description="highest frame rate in hertz")
    bandwidth_mb_s: Positive | None = Field(
        default=None, description="what the interface carries, 10^6 byte/s"
    )
    power_w: NonNegative | None = Field(default=None, description="electrical power in watts")

    @model_validator(mode="before")
    @classmethod
    def _one_name_a_key(cls, data: Any) -> Any:
        return renamed("camera", data)


class InlineLens(InlinePart):
    """A lens in a system file."""

    focal_length_mm: Annotated[float, Field(gt=0, le=10_000), NUMBER] = Field(
        description="focal length in air in millimetres"
    )
    f_number_min: Annotated[float, Field(gt=0.4, le=128), NUMBER] = Field(
        default=F_NUMBERS[0], description="f-number of the widest opening"
    )
    f_number_max: Annotated[float, Field(gt=0.4, le=128), NUMBER] | None = Field(
        default=None, description=f"f-number of the smallest opening, {F_NUMBERS[1]:g} unless given"
    )
    transmission_frac: PositiveShare | None = Field(
        default=None, description="transmission (share 0..1 of the light), 0.9 unless given"
    )
    aperture_control: Annotated[Literal["manual", "motorised", "fixed", "unknown"], CHOICE] = Field(
        default="unknown", description="how the aperture is set: manual, motorised, fixed or unknown"
    )
    image_circle_mm: Positive | None = Field(
        default=None, description="diameter of the image circle in millimetres"
    )
    mounts: Texts = Field(default=(), description="lens mounts, such as [C]")
    rated_pixel_pitch_um: Positive | None = Field(
        default=None, description="rated pixel pitch in micrometres"
    )
    rated_lp_per_mm: Positive | None = Field(
        default=None, description="rated resolution in line pairs per millimetre"
    )
    min_object_distance_m: NonNegative | None = Field(
        default=None, description="nearest focus in air in metres"
    )
    distortion_pct: Number | None = Field(default=None, description="distortion in per cent")
    length_mm: Positive | None = Field(default=None, description="length in millimetres")
    diameter_mm: Positive | None = Field(default=None, description="diameter in millimetres")

    @model_validator(mode="before")
    @classmethod
    def _one_name_a_key(cls, data: Any) -> Any:
        return renamed("lens", data)


class InlinePort(InlinePart):
    """A port in a system file."""

    geometry: Annotated[Literal["flat", "dome"], CHOICE] = Field(
        description="shape of the window: flat or dome"
    )
    outer_radius_mm: Positive | None = Field(
        default=None, description="outer radius of a dome in millimetres"
    )
    thickness_mm: Positive | None = Field(
        default=None, description="thickness in millimetres, 10 unless given"
    )
    refractive_index: Annotated[float, Field(gt=1, le=3), NUMBER] | None = Field(
        default=None, description="refractive index of the window, 1.5 unless glass or this is given"
    )
    glass: Text | None = Field(default=None, description="id of a dispersion formula, such as n_bk7")
    material: Text | None = Field(default=None, description="material, such as acrylic")
    clear_diameter_mm: Positive | None = Field(default=None, description="clear diameter in millimetres")
    gap_mm: NonNegative = Field(
        default=0.0, description="distance from the lens's entrance pupil to a flat port in millimetres"
    )
    depth_rating_m: Positive | None = Field(default=None, description="depth rating in metres")

    @model_validator(mode="before")
    @classmethod
    def _one_name_a_key(cls, data: Any) -> Any:
        return renamed("port", data)


class InlineLight(InlinePart):
    """A light in a system file; all numbers are of one lamp."""

    kind: Annotated[Literal["continuous", "pulsed_led", "flash"], CHOICE] | None = Field(
        default=None, description="kind of lamp: continuous, pulsed_led or flash; continuous unless given"
    )
    flux_lm: Positive | None = Field(default=None, description="flux at full (pulsed: while on) in lumens")
    power_w: NonNegative | None = Field(
        default=None, description="electrical power at full (pulsed: while on) in watts"
    )
    output_factor: PositiveShare = Field(
        default=1.0, description="share 0..1 of the flux that leaves the window"
    )
    beam: Annotated[Literal["disc", "cone", "cosine-power", "tabulated"], CHOICE] | None = Field(
        default=None, description="shape of the beam: disc, cone, cosine-power or tabulated"
    )
    beam_half_angle_deg: Annotated[float, Field(gt=0, lt=90), NUMBER] | None = Field(
        default=None, description="half-angle of the beam in water in degrees"
    )
    beam_angle_deg: Annotated[float, Field(gt=0, lt=180), NUMBER] | None = Field(
        default=None, description="full angle of the beam in beam_medium in degrees"
    )
    beam_medium: Annotated[Literal["air", "water", "not stated"], CHOICE] | None = Field(
        default=None, description="where beam_angle_deg is measured: air, water or not stated (taken as air)"
    )
    beam_profile: Text | None = Field(
        default=None, description="id of a beam profile, or a CSV with angle_deg and intensity"
    )
    spectrum: Text | None = Field(
        default=None, description="id of a spectrum, or a CSV with wavelength_nm and relative_power"
    )
    front_radius_mm: Positive = Field(default=20.0, description="radius of the lamp's front in millimetres")
    dim_levels: tuple[Share, ...] | None = Field(
        default=None, description="list of the light levels as shares 0..1"
    )
    dim_min_frac: Share = Field(
        default=0.0, description="least light level of a continuous dimmer, a share 0..1"
    )
    min_pulse_us: NonNegative | None = Field(default=None, description="shortest pulse in microseconds")
    max_pulse_us: Positive | None = Field(default=None, description="longest pulse in microseconds")
    max_duty_frac: PositiveShare | None = Field(
        default=None, description="highest share 0..1 of time that it is on"
    )
    max_rate_hz: Positive | None = Field(default=None, description="highest pulse rate in hertz")
    flash_energy_j: Positive | None = Field(default=None, description="full energy of one flash in joules")
    flash_efficacy_lm_s_per_j: Positive | None = Field(
        default=None, description="light of a flash in lumen-seconds per joule, 35 unless given"
    )
    flash_duration_us: Positive | None = Field(
        default=None, description="duration of a flash in microseconds"
    )
    recycle_s: NonNegative | None = Field(default=None, description="time between full flashes in seconds")
    charging_efficiency_frac: PositiveShare | None = Field(
        default=None, description="share 0..1 of the power drawn that the flash stores"
    )
    colour_temperature_k: Positive | None = Field(default=None, description="colour temperature in kelvin")
    depth_rating_m: Positive | None = Field(default=None, description="depth rating in metres")

    @model_validator(mode="before")
    @classmethod
    def _one_name_a_key(cls, data: Any) -> Any:
        return renamed("light", data)


INLINE_MODELS: dict[str, type[InlinePart]] = {
    "camera": InlineCamera,
    "lens": InlineLens,
    "port": InlinePort,
    "light": InlineLight,
}


def inline_faults(kind: str, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Keys of an inline record that do not agree: (key, rest of the sentence)."""
    check = {"camera": _camera_faults, "lens": _lens_faults, "port": _port_faults, "light": _light_faults}[
        kind
    ]
    return check(values)


def part_from_inline(
    kind: Kind, mapping: Mapping[str, Any] | InlinePart, base_dir: Path | None = None
) -> Camera | Lens | Port | Light:
    """The record of an inline part; files that it names are looked for in `base_dir`.

    Given numbers have status "user"; defaults are those of this module's head.
    """
    from uwopt.catalog import inline_records

    part = _validated_part(kind, mapping)
    if kind == "camera":
        return inline_records.camera(part, base_dir)
    if kind == "lens":
        return inline_records.lens(part)
    return inline_records.port(part) if kind == "port" else inline_records.light(part, base_dir)


def _validated_part(kind: str, mapping: Mapping[str, Any] | InlinePart) -> InlinePart:
    if isinstance(mapping, InlinePart):
        return mapping
    try:
        part = INLINE_MODELS[kind].model_validate(mapping)
    except ValidationError as error:
        details = error.errors(include_url=False)
        raise CatalogError(
            [
                f"inline {kind}: {'.'.join(map(str, d['loc']))} {d['msg'][:1].lower()}{d['msg'][1:]}."
                for d in details
            ]
        ) from None
    values = {name: getattr(part, name) for name in type(part).model_fields}
    faults = [f"inline {kind}: {key} {text}." for key, text in inline_faults(kind, values)]
    if faults:
        raise CatalogError(faults)
    return part


def _camera_faults(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    return _unordered(values, "min_exposure_us", "max_exposure_us")


def _lens_faults(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    return _unordered(values, "f_number_min", "f_number_max")


def _port_faults(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    radius_mm, thickness_mm = values.get("outer_radius_mm"), values.get("thickness_mm")
    is_dome = values.get("geometry") == "dome"
    faults = []
    if is_dome and radius_mm is None:
        faults.append(("outer_radius_mm", "is missing; a dome needs its outer radius in millimetres"))
    if is_dome and radius_mm is not None and thickness_mm is not None and thickness_mm >= radius_mm:
        faults.append(
            ("thickness_mm", f"= {thickness_mm:g} is not below outer_radius_mm = {radius_mm:g}; lower it")
        )
    if values.get("refractive_index") is not None and values.get("glass") is not None:
        faults.append(("glass", "and refractive_index are both given; keep one of them"))
    return faults


def _light_faults(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    faults = _unordered(values, "min_pulse_us", "max_pulse_us")
    given = {name for name, value in values.items() if value is not None}
    is_flash = values.get("kind") == "flash" or (values.get("kind") is None and "flash_energy_j" in given)
    if is_flash and "flash_energy_j" not in given:
        faults.append(("flash_energy_j", "is missing; give the energy of one flash in joules"))
    if not is_flash and "flux_lm" not in given:
        faults.append(("flux_lm", "is missing; give the flux of one lamp at full in lumens"))
    if {"beam_half_angle_deg", "beam_angle_deg"} <= given:
        faults.append(("beam_half_angle_deg", "and beam_angle_deg are both given; keep one of them"))
    if "beam_medium" in given and "beam_half_angle_deg" in given:
        faults.append(("beam_medium", "belongs to beam_angle_deg; beam_half_angle_deg is always in water"))
    if not given & {"beam_half_angle_deg", "beam_angle_deg", "beam_profile"}:
        text = "is missing; give the half-angle in water in degrees, or beam_angle_deg, or beam_profile"
        faults.append(("beam_half_angle_deg", text))
    if values.get("beam") == "tabulated" and "beam_profile" not in given:
        faults.append(
            ("beam_profile", "is missing; a tabulated beam needs a CSV with angle_deg and intensity")
        )
    return faults


def _unordered(values: Mapping[str, Any], low: str, high: str) -> list[tuple[str, str]]:
    if values.get(low) is None or values.get(high) is None or values[low] <= values[high]:
        return []
    return [(low, f"= {values[low]:g} is above {high} = {values[high]:g}; swap them")]


def user_number(value: float | None) -> Quantity | None:
    """A number that the user stated."""
    return None if value is None else exact(value, "user", "system file")


def flat_curve(value: float) -> Curve:
    """A spectrum with one value everywhere."""
    return Curve(FLAT_NM, (value, value))
