"""The parts that can be bought, as typed records: camera, lens, port, light.

Files use the field's units (mm, um, us, deg, g); the unit is in the name. A number that may be a
class estimate is a `Quantity`: central, low and high value, how it is known, and from where.
`None` means unknown and not estimated. Records know no mission.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

Availability = Literal["current", "discontinued", "not_a_product", "unknown"]
Status = Literal["published", "measured", "derived", "estimated", "quoted", "user", "generic"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with its doubt: low <= value <= high; equal when it is published."""

    value: float
    low: float
    high: float
    status: Status = "published"
    source: str = ""

    @property
    def estimated(self) -> bool:
        """True when no source states this number for this part."""
        return self.status == "estimated"


def exact(value: float, status: Status = "published", source: str = "") -> Quantity:
    """A number without a range."""
    return Quantity(value, value, value, status, source)


@dataclass(frozen=True, slots=True)
class Curve:
    """A tabulated spectrum or profile: abscissa increasing, one value each."""

    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Part:
    """What every part has: identity, price, and where the facts come from."""

    id: str
    manufacturer: str = ""
    model: str = ""
    availability: Availability = "unknown"
    generic: bool = False  # "to be made": no product, a class of parts
    inline: bool = False  # from a system file: what it leaves out is not checked
    price: Quantity | None = None
    currency: str = "USD"
    price_date: str = ""
    mass_g: Quantity | None = None
    source_url: str = ""
    note: str = ""


@dataclass(frozen=True, slots=True)
class Camera(Part):
    """A camera body with its sensor."""

    chip: str = ""
    colour: Literal["mono", "colour"] = "mono"
    resolution_x_px: int = 0
    resolution_y_px: int = 0
    pixel_pitch_um: float = 0.0
    shutter: Literal["global", "rolling"] = "global"
    mounts: tuple[str, ...] = ()  # of C, CS, S, M12, F, ...; () is unknown and fits nothing
    interface: str = ""
    bandwidth_mb_s: Quantity | None = None  # what the interface carries, 10^6 byte/s
    max_frame_rate_hz: Quantity | None = None
    bit_depth: int = 12  # of the transmitted image
    bit_depth_status: Status = "published"
    read_noise_e: Quantity | None = None
    saturation_e: Quantity | None = None
    dark_current_e_s: Quantity | None = None
    gain_dn_per_e: float | None = None  # at 0 dB, in DN of gain_bits
    gain_bits: int | None = None
    max_gain_db: Quantity | None = None
    black_level_dn: float = 0.0
    min_exposure_us: Quantity | None = None
    max_exposure_us: Quantity | None = None
    exposure_offset_us: Quantity | None = None
    prnu_frac: Quantity | None = None
    power_w: Quantity | None = None
    # Quantum efficiency by channel ("mono", or "red", "green", "blue"): id of a curve, scaled.
    qe_curves: dict[str, Curve] = field(default_factory=dict)
    qe_curve_id: str = ""
    qe_scale: Quantity | None = None


@dataclass(frozen=True, slots=True)
class Lens(Part):
    """A lens of fixed focal length (a zoom counts at its shortest)."""

    focal_length_mm: float = 0.0
    f_number_min: Quantity | None = None
    f_number_max: Quantity | None = None
    aperture_control: Literal["manual", "motorised", "fixed", "unknown"] = "unknown"
    image_circle_mm: float | None = None  # published, or derived from the optical format
    image_circle_status: Status = "published"
    optical_format_in: str = ""
    mounts: tuple[str, ...] = ()
    transmission_frac: Quantity | None = None
    rated_pixel_pitch_um: float | None = None
    rated_lp_per_mm: float | None = None
    min_object_distance_m: Quantity | None = None
    distortion_pct: float | None = None
    length_mm: float | None = None
    diameter_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Port(Part):
    """A window between water and lens: flat, or a concentric dome."""

    geometry: Literal["flat", "dome"] = "flat"
    material: str = ""
    refractive_index: Quantity | None = None  # constant, when no dispersion formula is used
    glass: str = ""  # id in refractive_index_coefficients.csv, or "" for the constant
    outer_radius_mm: float | None = None  # of a dome, radius of curvature
    thickness_mm: Quantity | None = None
    clear_diameter_mm: float | None = None
    gap_mm: float = 0.0  # from the lens's entrance pupil to the inner face of a flat port
    depth_rating_m: float | None = None  # never estimated


@dataclass(frozen=True, slots=True)
class Light(Part):
    """A lamp: burning (continuous), an LED that pulses (pulsed_led), or a xenon tube (flash)."""

    kind: Literal["continuous", "pulsed_led", "flash"] = "continuous"
    flux_lm: Quantity | None = None  # nameplate, one lamp at full (pulsed_led: while on)
    power_w: Quantity | None = None  # electrical, one lamp at full (pulsed_led: while on)
    output_factor: Quantity | None = None  # share of the nameplate flux that leaves the window
    beam: Literal["disc", "cone", "cosine-power", "tabulated"] = "cosine-power"
    beam_angle_deg: Quantity | None = None  # full angle; half power for cosine-power, edge for disc and cone
    beam_medium: Literal["air", "water", "not stated"] = "not stated"  # not stated counts as air, flagged
    beam_profile: Curve | None = None  # angle from the axis [deg], relative or absolute intensity
    beam_profile_is_candela: bool = False
    beam_profile_id: str = ""
    spectrum_id: str = "generic-led"
    spectrum: Curve | None = None  # the user's own: wavelength [nm], relative power per nm
    front_radius_mm: float = 20.0
    dim_levels: tuple[float, ...] | None = None  # shares of full; None: continuous from dim_min_frac
    dim_min_frac: float = 0.0
    dim_status: Status = "published"
    min_pulse_us: Quantity | None = None
    max_pulse_us: Quantity | None = None
    max_duty_frac: Quantity | None = None
    max_rate_hz: Quantity | None = None
    flash_energy_j: Quantity | None = None  # full energy of one pulse
    flash_efficacy_lm_s_per_j: Quantity | None = None
    flash_duration_us: Quantity | None = None
    recycle_s: Quantity | None = None
    charging_efficiency_frac: Quantity | None = None
    guide_number_m: float | None = None  # land, ISO 100
    colour_temperature_k: float | None = None
    depth_rating_m: float | None = None  # never estimated
