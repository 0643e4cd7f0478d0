"""The sections of a mission file: vehicle, requirements, limits, catalog, scene.

Each key is a field with its limits and a description; messages and the JSON schema are made from them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from uwopt.documents.key_types import (
    CHOICE,
    NUMBER,
    WHOLE,
    Count,
    NonNegative,
    Positive,
    Section,
    Share,
    Text,
    Texts,
    all_optional,
    at_least,
    number_or_range,
    whole_range,
)
from uwopt.mission import keys as words
from uwopt.units import db_to_ratio

MAX_LIGHTS = 64
BASELINE_STEP_M, TILT_STEP_DEG = 0.05, 2.5  # the declared grid of mounts

Orientation = Literal["landscape", "portrait"]
BetweenImages = Annotated[Literal["on", "off"], BeforeValidator(words.to_on_off), CHOICE]


class LightMount(Section):
    """Place and aim of one light in the vehicle frame: x forward, y starboard, z down, origin at the port."""

    x_m: Annotated[float, Field(ge=-100, le=100), NUMBER] = Field(
        default=0.0, description="place forward of the port in metres"
    )
    y_m: Annotated[float, Field(ge=-100, le=100), NUMBER] = Field(
        default=0.0, description="place to starboard in metres"
    )
    z_m: Annotated[float, Field(ge=-100, le=100), NUMBER] = Field(
        default=0.0, description="place below the port in metres"
    )
    tilt_x_deg: Annotated[float, Field(gt=-90, lt=90), NUMBER] = Field(
        default=0.0, description="aim's tilt along x in degrees, outward positive, 0 is straight down"
    )
    tilt_y_deg: Annotated[float, Field(gt=-90, lt=90), NUMBER] = Field(
        default=0.0, description="aim's tilt along y in degrees, outward positive, 0 is straight down"
    )


class Vehicle(Section):
    """How the camera is carried, and which hardware it may carry."""

    altitude_m: Annotated[float, Field(gt=0, le=1000), at_least(1e-3), NUMBER] = Field(
        description="distance from the port to the floor, wall or target in metres; also as distance_m"
    )
    altitude_tolerance_m: Annotated[float, Field(ge=0, le=1000), NUMBER] = Field(
        default=0.0,
        description="half-width of the altitudes over which every requirement holds, in metres; also as "
        "distance_tolerance_m",
    )
    pitch_deg: Annotated[float, Field(ge=0, le=80), NUMBER] = Field(
        default=0.0,
        description="angle by which the camera looks ahead of the normal of the floor or wall in degrees, 0 for square "
        "on it; the lamps turn with it",
    )
    speed_m_s: Annotated[float, Field(ge=0, le=50), NUMBER] = Field(
        description="speed over the floor in metres per second, 0 when it hovers"
    )
    pitch_rate_deg_s: Annotated[float, Field(ge=0, le=360), NUMBER] = Field(
        default=0.0, description="largest pitch rate in degrees per second"
    )
    roll_rate_deg_s: Annotated[float, Field(ge=0, le=360), NUMBER] = Field(
        default=0.0, description="largest roll rate in degrees per second"
    )
    orientation: Annotated[Literal["any", "landscape", "portrait"], CHOICE] = Field(
        default="any",
        description="side of the image along the motion: landscape its height, portrait its width, or any",
    )
    camera_count: Count = Field(default=1, description="number of cameras, each with lens and port")
    camera_baseline_m: Annotated[float, Field(gt=0, le=20), at_least(1e-3), NUMBER] | None = Field(
        default=None,
        description="of a stereo pair (camera_count 2), the distance across track between the middles of the ports in "
        "metres; lamps stand about the middle between them",
    )
    camera_convergence_deg: Annotated[float, Field(ge=0, le=90), NUMBER] = Field(
        default=0.0,
        description="angle between the axes of a stereo pair in degrees, each camera turned inward by half of it",
    )
    light_count: Annotated[tuple[int, int], whole_range(0, MAX_LIGHTS)] = Field(
        default=(1, 8),
        description=f"number of lights, or [least, most], whole numbers from 0 to {MAX_LIGHTS}; 0 where the sun "
        "serves",
    )
    light_baseline_m: Annotated[float | tuple[float, float], number_or_range(0, 20)] = Field(
        default=0.5, description="distance across track from port to lights in metres, or [least, most]"
    )
    light_tilt_deg: Annotated[float | tuple[float, float], number_or_range(-89, 89)] = Field(
        default=0.0, description="outward tilt of the lights in degrees, or [least, most]"
    )
    light_mounts: Annotated[tuple[LightMount, ...], Field(max_length=MAX_LIGHTS)] | None = Field(
        default=None,
        description="places and aims of the lights, taken in this order; instead of baseline and tilt",
    )
    lamp_size_m: Annotated[float, Field(gt=0, le=2), NUMBER] | None = Field(
        default=None,
        description="diameter of a lamp's body in metres, recommended 0.1: with it lamps may not stand in one another, "
        "in the port's body or, where refuse holds lamp, with their bodies in the view; more than two lamps stand in a "
        "row on each side, along the motion",
    )

    duration_h: Positive | None = Field(
        default=None,
        description="how long the mission takes in hours; energy and storage are counted over it",
    )
    battery_wh: Positive | None = Field(
        default=None, description="energy of the battery in watt-hours, for the figure endurance"
    )
    supply: Annotated[Literal["vehicle", "battery"], CHOICE] = Field(
        default="vehicle",
        description="what feeds cameras and lamps: vehicle (it is there), or battery (one of battery_wh, part of the "
        "system, counted in cost and mass (catalog.rest: estimate) and to last duration_h where that is given)",
    )
    cable_m: Positive | None = Field(
        default=None,
        description="length of the data cable from each camera to the common computer in metres; a camera whose "
        "interface does not reach so far has a computer of its own beside it (catalog.host: estimate), or is left out "
        "(none); without it the computer stands beside the cameras",
    )
    lamp_supply: Annotated[Literal["any", "external", "battery"], CHOICE] = Field(
        default="any",
        description="lamps that may be used: external (fed by the vehicle, recommended), battery (with their own, as "
        "divers' torches) or any; a lamp that catalog.lights names by its id, or that is owned, may have either",
    )
    lamps_between_images: BetweenImages = Field(
        default="on",
        description="whether lamps that burn stay on between images: on or off; off is recommended below an image in "
        "some seconds",
    )
    camera_between_images: BetweenImages = Field(
        default="on",
        description="whether cameras stay on between images: on or off; off is recommended below an image a minute",
    )

    @model_validator(mode="before")
    @classmethod
    def _as_many_lights_as_mounts(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and data.get("light_count") is None:
            mounts = data.get("light_mounts")
            if isinstance(mounts, (list, tuple)) and 0 < len(mounts) <= MAX_LIGHTS:
                return {**data, "light_count": [len(mounts)] * 2}
        return data

    @property
    def orientations(self) -> tuple[Orientation, ...]:
        """The orientations that may be tried."""
        return ("landscape", "portrait") if self.orientation == "any" else (self.orientation,)

    @property
    def light_counts(self) -> range:
        """The numbers of lights that may be tried."""
        return range(self.light_count[0], self.light_count[1] + 1)

    @property
    def light_baseline_range_m(self) -> tuple[float, float]:
        """Lowest and highest baseline."""
        return _pair(self.light_baseline_m)

    @property
    def light_tilt_range_deg(self) -> tuple[float, float]:
        """Lowest and highest tilt."""
        return _pair(self.light_tilt_deg)

    @property
    def light_baseline_grid_m(self) -> tuple[float, ...]:
        """Baselines that count as hardware: every 0.05 m from the lower end, both ends included."""
        return grid(*self.light_baseline_range_m, BASELINE_STEP_M)

    @property
    def light_tilt_grid_deg(self) -> tuple[float, ...]:
        """Tilts that count as hardware: every 2.5 degrees from the lower end, both ends included."""
        return grid(*self.light_tilt_range_deg, TILT_STEP_DEG)


class Requirements(Section):
    """What the images must be; a key that is left out asks for nothing."""

    overlap: Annotated[float, Field(ge=0, lt=1), NUMBER] | None = Field(
        default=None,
        description="overlap of following images along track, a share 0..1; without it and frame_interval_s 0, images "
        "that just touch",
    )
    frame_interval_s: Positive | None = Field(
        default=None, description="longest time between images in seconds"
    )
    max_blur_px: Positive | None = Field(default=None, description="longest motion blur in pixels")
    max_skew_px: Positive | None = Field(default=None, description="largest rolling-shutter skew in pixels")
    min_dof_m: NonNegative | None = Field(
        default=None, description="least depth of field in metres; without it the nominal altitude is sharp"
    )
    dof_at: Annotated[Literal["axis", "corner"], CHOICE] = Field(
        default="axis",
        description="where in the image the depth of field must hold: axis, or corner (the field at 80 % of the half "
        "diagonal as well; recommended)",
    )
    circle_of_confusion_px: Annotated[float, Field(gt=0, le=1e6), at_least(1e-3), NUMBER] | None = Field(
        default=None,
        description="sharpness limit in pixels; 2, in physics paper the sensor's diagonal / 1500",
    )
    min_snr_db: Annotated[float, Field(ge=-40, le=200), NUMBER] | None = Field(
        default=None, description="least signal-to-noise ratio in decibels (20 log10), instead of min_snr"
    )
    min_snr_given: Annotated[float, Field(gt=0, le=1e10), NUMBER] | None = Field(
        default=None,
        alias="min_snr",
        description="least signal-to-noise ratio as a ratio, instead of min_snr_db",
    )
    min_snr_red_db: Annotated[float, Field(ge=-40, le=200), NUMBER] | None = Field(
        default=None,
        description="least signal-to-noise ratio of the red channel in decibels, mean of the image; asks for a colour "
        "sensor",
    )
    snr_at: Annotated[Literal["mean", "worst", "worst_px"], CHOICE] = Field(
        default="mean",
        description="where in the image the SNR must hold: mean, worst (95 % of the frame reach it; recommended) "
        "or worst_px (the darkest pixel)",
    )
    max_gsd_mm: Positive | None = Field(default=None, description="largest pixel on the floor in millimetres")
    min_swath_m: NonNegative | None = Field(
        default=None, description="least footprint across track in metres"
    )
    max_depth_error_mm: Positive | None = Field(
        default=None,
        description="largest standard error of a point's distance by a stereo pair in millimetres, over the strip that "
        "both cameras see; needs vehicle.camera_baseline_m",
    )
    disparity_error_px: Annotated[float, Field(gt=0, le=100), at_least(1e-4), NUMBER] = Field(
        default=0.5,
        description="standard error of a point's disparity, the difference of its places in both images, in pixels: "
        "0.1 to 0.3 of good texture matched by program, 0.5 to 1 of points set by hand",
    )
    min_common_swath_m: NonNegative | None = Field(
        default=None,
        description="least width across track that both cameras of a stereo pair see, in metres; needs "
        "vehicle.camera_baseline_m",
    )
    sidelap: Annotated[float, Field(ge=0, lt=1), NUMBER] = Field(
        default=0.0,
        description="overlap of neighbouring lines across track, a share 0..1; of a stereo pair, of what both cameras "
        "see",
    )
    min_area_m2_h: Positive | None = Field(
        default=None,
        description="least area covered in an hour in square metres, sidelap taken off and turns left out; of a stereo "
        "pair, seen by both cameras",
    )
    mean_level: Annotated[float, Field(gt=0, lt=1), NUMBER] | None = Field(
        default=None,
        description="wanted mean image level, a share 0..1 of full scale; the gain is chosen for it",
    )
    max_gain_db: Annotated[float, Field(ge=0, le=120), words.number_or_recommended(12.0)] | None = Field(
        default=None,
        description="highest gain in decibels above the camera's lowest, recommended 12; reserve.max_gain_db is one "
        "that yields where nothing fits",
    )
    highlight_ratio: Annotated[float, Field(ge=1, le=1000), NUMBER] = Field(
        default=1.5, description="brightest detail over mean level, at least 1, that must not saturate"
    )
    min_contrast: Share | None = Field(
        default=None, description="least image-forming over all light, a share 0..1"
    )
    min_uniformity: Share | None = Field(
        default=None, description="least over mean floor illuminance, a share 0..1"
    )
    min_mtf_half_nyquist: Share | None = Field(
        default=None, description="least MTF at half the Nyquist frequency, a share 0..1, recommended 0.3"
    )
    max_white_balance: Annotated[float, Field(ge=1, le=1e6), words.number_or_recommended(4.0)] | None = Field(
        default=None,
        description="largest ratio between the strongest and the weakest colour channel of a grey floor, at least 1, "
        "recommended 4; a mono sensor has none",
    )
    resolve_mm: Positive | None = Field(
        default=None,
        description="bars this wide on the floor, in millimetres, arrive with a contrast of a tenth in the corner, "
        "veil counted where snr_at counts; implies pixels no larger and an SNR of 20 dB",
    )
    shutter: Annotated[Literal["any", "global", "rolling"], CHOICE] = Field(
        default="any", description="shutter of the camera: any, global or rolling"
    )
    colour: Annotated[Literal["any", "mono", "colour"], CHOICE] = Field(
        default="any", description="sensor of the camera: any, mono or colour"
    )
    lens_stop_down: Annotated[float, Field(ge=0, le=10), words.number_or_recommended(1.0)] = Field(
        default=0.0,
        description="stops that the lens is closed from its widest opening at least, recommended 1; "
        "a lens of one opening is taken as it is",
    )
    max_airy_px: Annotated[Positive, words.number_or_recommended(2.0)] | None = Field(
        default=None, description="largest diameter of the Airy disc in pixels, recommended 2"
    )
    refuse: Annotated[tuple[words.Refusal, ...], BeforeValidator(words.to_refusals)] = Field(
        default=(),
        description="list of what an expert would refuse, each held as if its key were given: airy (max_airy_px 2), "
        "skew (max_skew_px 2), swath (min_swath_m 1 in a survey with overlap), depth (reserve.depth 1.1), "
        "lamp (in the camera's view), white_balance (max_white_balance 4); all for all (recommended)",
    )

    @property
    def min_snr_red(self) -> float | None:
        """The least signal-to-noise ratio of the red channel; None when none was asked for."""
        return None if self.min_snr_red_db is None else db_to_ratio(self.min_snr_red_db)

    @property
    def asks_sharpness(self) -> bool:
        """Whether a contrast of fine detail is asked for."""
        return self.min_mtf_half_nyquist is not None or self.resolve_mm is not None

    @property
    def min_snr(self) -> float | None:
        """The least signal-to-noise ratio, whichever way it was asked for; None when it was not."""
        return db_to_ratio(self.min_snr_db) if self.min_snr_db is not None else self.min_snr_given


class Limits(Section):
    """What the system may cost, draw and weigh; a key that is left out limits nothing."""

    cost: NonNegative | None = Field(
        default=None, description="highest cost of the whole system in limits.currency"
    )
    currency: Annotated[str, BeforeValidator(words.to_currency_code)] = Field(
        default="USD", description="currency of costs as three letters, such as USD"
    )
    rates: Annotated[dict[str, Positive], BeforeValidator(words.to_rates)] = Field(
        default_factory=dict,
        description="exchange rates by currency, USD per unit, that override the shipped ones",
    )
    cost_basis: Annotated[Literal["central", "high"], CHOICE] = Field(
        default="high",
        description="end of estimated prices that must be within the cost limit: high, or central; the objective cost "
        "is at central prices either way",
    )
    power_w: Positive | None = Field(default=None, description="highest mean electrical power in watts")
    peak_power_w: Positive | None = Field(
        default=None, description="highest electrical power at any moment in watts"
    )
    energy_wh: Positive | None = Field(
        default=None,
        description="most energy over vehicle.duration_h in watt-hours, scenes weighed by their time_share",
    )
    storage_gb: Positive | None = Field(
        default=None,
        description="most storage for images over vehicle.duration_h in gigabytes (10^9 byte), uncompressed",
    )
    mass_kg: Positive | None = Field(default=None, description="highest mass in kilograms")
    mass_water_kg: Annotated[float, Field(ge=-1e4, le=1e4), NUMBER] | None = Field(
        default=None,
        description="highest mass in water, in kilograms, of the cameras in their housings, lamps not counted; needs "
        "catalog.housing: required",
    )
    size_mm: Positive | None = Field(
        default=None,
        description="largest outer length or diameter of a housing with its port, in millimetres; needs "
        "catalog.housing: required",
    )
    depth_rating_m: Annotated[float, Field(ge=0, le=11_000), NUMBER] | None = Field(
        default=None,
        description="depth that ports and lights must be rated for, in metres; the deepest scene "
        "unless given",
    )
    data_rate_mb_s: Positive | None = Field(
        default=None, description="highest data rate in megabytes (10^6 byte) per second"
    )
    max_exposure_ms: Positive = Field(default=1000.0, description="longest exposure in milliseconds")


class OwnedPart(Section):
    """A part that is already there and costs nothing."""

    id: Text = Field(description="id of a part of the catalogue")
    quantity: Annotated[int, Field(ge=0, le=1000), WHOLE] = Field(
        default=1, description="number of pieces at hand"
    )


class Extra(Section):
    """Something that every system needs besides its parts: housing, cables, computer."""

    name: Text = Field(description="name of the item")
    cost: NonNegative = Field(default=0.0, description="cost in limits.currency")
    mass_kg: NonNegative = Field(default=0.0, description="mass in kilograms")
    power_w: NonNegative = Field(default=0.0, description="electrical power in watts")


class CatalogChoice(Section):
    """Which parts may be used; patterns are globs or plain parts of an id or a manufacturer."""

    cameras: Texts = Field(default=(), description="patterns of cameras that may be used; none allows all")
    lenses: Texts = Field(default=(), description="patterns of lenses that may be used; none allows all")
    ports: Texts = Field(default=(), description="patterns of ports that may be used; none allows all")
    lights: Texts = Field(default=(), description="patterns of lights that may be used; none allows all")
    housings: Texts = Field(default=(), description="patterns of housings that may be used; none allows all")
    complete_cameras: Texts = Field(
        default=(), description="patterns of complete cameras that may be used; none allows all"
    )
    exclude: Texts = Field(default=(), description="patterns of parts that must not be used")
    files: Texts = Field(
        default=(),
        description="CSV or YAML files of own parts, or of changes to the catalogue, relative to the mission file",
    )
    prices: Text | None = Field(
        default=None, description="CSV of own quotes that override prices, relative to the mission file"
    )
    owned: Annotated[tuple[OwnedPart, ...], BeforeValidator(words.to_owned)] = Field(
        default=(), description="list of parts already there, each {id, quantity}"
    )
    generic: Annotated[Literal["fallback", "allow", "never"], CHOICE] = Field(
        default="fallback", description="use of generic parts, which no shop sells: fallback, allow or never"
    )
    verified: Annotated[tuple[str, ...], BeforeValidator(words.to_part_fields)] = Field(
        default=(), description="list of part fields that must come from a source, such as price"
    )
    accept_unrated: Texts = Field(
        default=(), description="ids of parts whose unknown depth rating is accepted"
    )
    port_mounts: Texts = Field(
        default=(),
        description="mounts of ports, such as nauticam-n120, for which a housing or an adapter is to hand; ports that "
        "fit only their maker's housings are left out otherwise",
    )
    lens_rating: Annotated[Literal["warn", "limit"], CHOICE] = Field(
        default="warn",
        description="what a lens rated for larger pixels than the camera's is: warn tells of it, limit refuses it",
    )
    interfaces: Annotated[tuple[str, ...], BeforeValidator(words.to_interfaces)] = Field(
        default=(),
        description="interfaces that the host has, such as [USB3, GigE]; cameras of another, or of an unknown one, "
        "are left out; none allows all",
    )
    availability: Annotated[Literal["any", "known"], CHOICE] = Field(
        default="any",
        description="parts of which nobody says whether they are still sold: any lets them in, known leaves them out",
    )
    host: Annotated[Literal["none", "estimate"], CHOICE] = Field(
        default="none",
        description="the computer that takes the images: none leaves it out, estimate (recommended, unless it is among "
        "the extras) counts power and cost by the camera's interface",
    )
    rest: Annotated[Literal["none", "estimate"], CHOICE] = Field(
        default="none",
        description="the rest that every system needs: none leaves it out, estimate (recommended, unless there are "
        "extras) counts connectors and cables by depth, trigger electronics, a battery of its own, spares and a "
        "pressure test in the cost",
    )
    housing: Annotated[Literal["none", "required"], CHOICE] = Field(
        default="none",
        description="housing of each port: none leaves it out, required (recommended, unless it is among the extras) "
        "chooses one that takes port, camera and lens, and counts its depth rating, cost and mass",
    )
    spacers: Annotated[Literal["none", "allow"], CHOICE] = Field(
        default="none",
        description="spacer rings between lens and camera, on which it focuses nearer: none leaves them out, allow "
        "(recommended) takes the shortest that the focus needs, and counts its price",
    )
    complete: Annotated[Literal["none", "also", "only"], BeforeValidator(words.to_complete), CHOICE] = Field(
        default="none",
        description="complete cameras, which are bought with lens and port in one housing: none leaves them out, also "
        "(or true) searches them beside the assembled ones, only searches nothing else",
    )
    extras: tuple[Extra, ...] = Field(
        default=(), description="list of items added to every system: {name, cost, mass_kg, power_w}"
    )


if TYPE_CHECKING:
    VehicleOverride = Vehicle
    RequirementsOverride = Requirements
else:
    VehicleOverride = all_optional(Vehicle, "VehicleOverride")
    RequirementsOverride = all_optional(Requirements, "RequirementsOverride")


class Scene(Section):
    """Water, floor and light of one place; keys of `vehicle` and `requirements` may be overridden here."""

    name: Text = Field(default="scene 1", description="name of the scene, each its own")
    water: Annotated[str, BeforeValidator(words.to_water)] | None = Field(
        default=None,
        description=f"Jerlov type ({', '.join(words.JERLOV_TYPES)}) or the name of a CSV profile; beside one of "
        f"{', '.join(words.CLARITY_KEYS)} the type whose colour that water has",
    )
    c_per_m: Annotated[float, Field(ge=0.055, le=20), NUMBER] | None = Field(
        default=None,
        description="beam attenuation at 530 nm in 1/m, the water's own included, instead of water; of all "
        "readings the one to have",
    )
    visibility_m: Annotated[float, Field(ge=0.3, le=80), NUMBER] | None = Field(
        default=None,
        description="farthest distance in metres at which a black disc is seen horizontally in daylight, instead of "
        "water",
    )
    secchi_m: Annotated[float, Field(ge=0.4, le=80), NUMBER] | None = Field(
        default=None, description="Secchi depth in metres, instead of water"
    )
    turbidity_ntu: Annotated[float, Field(ge=0.02, le=15), NUMBER] | None = Field(
        default=None, description="turbidity in NTU or FNU, instead of water; leaves most open of all readings"
    )
    water_table: Annotated[Literal["measured", "solonenko-mobley"], CHOICE] | None = Field(
        default=None,
        description="table of the Jerlov types: measured or solonenko-mobley; measured where it has the type",
    )
    seafloor: Annotated[float | str, BeforeValidator(words.to_seafloor)] = Field(
        description=f"seafloor: {', '.join(words.SEAFLOORS)}, a reflectance 0..1, or the name of a "
        "CSV spectrum; of a wall or a target in mid-water, its reflectance"
    )
    target: Annotated[words.Target, BeforeValidator(words.to_target), CHOICE] = Field(
        default="floor",
        description="thing that is looked at: floor (the camera looks straight down), wall (it looks level and faces "
        "it), or mid_water (things that stand or swim at the distance, looked at level with open water behind them)",
    )
    depth_m: Annotated[float, Field(ge=0, le=11_000), NUMBER] = Field(
        description="depth of the scene in metres: of the floor; of the camera where it looks level"
    )
    temperature_c: Annotated[float, Field(ge=-3, le=45), NUMBER] = Field(
        default=10.0, description="temperature of the water in degrees Celsius"
    )
    salinity_psu: Annotated[float, Field(ge=0, le=50), NUMBER] = Field(
        default=35.0, description="salinity of the water in practical salinity units, 0 for fresh water"
    )
    backscatter_ratio: Annotated[float, Field(gt=0, le=0.5), NUMBER] = Field(
        default=0.0183, description="backscattered share of all scattering, b_b / b"
    )
    phase_function: Text = Field(
        default="fournier-forand",
        description="how particles scatter: fournier-forand or henyey-greenstein for the backscatter_ratio, "
        "petzold-<station> as measured, or the name of a CSV file (angle_deg, phase_per_sr)",
    )
    multiple_scattering: bool = Field(
        default=True,
        description="whether light that is scattered more than once counts; false: single scattering, as the equations "
        "of Jaffe and McGlamery have it",
    )
    sun_lux: Annotated[float, Field(ge=0, le=200_000), NUMBER] = Field(
        default=0.0, description="sunlight at the surface in lux, 0 for night"
    )
    sun_elevation_deg: Annotated[float, Field(ge=0, le=90), NUMBER] = Field(
        default=60.0, description="elevation of the sun in degrees above the horizon"
    )
    subject_speed_m_s: Annotated[float, Field(ge=0, le=50), NUMBER] = Field(
        default=0.0,
        description="largest speed of a subject over the floor in any direction in metres per second, such as of a "
        "fish; adds to blur and skew, not to overlap and frame rate",
    )
    time_share: Share | None = Field(
        default=None,
        description="share 0..1 of the mission's time spent here, for energy and storage; equal unless given",
    )
    vehicle: VehicleOverride | None = Field(
        default=None, description="keys of vehicle that differ in this scene"
    )
    requirements: RequirementsOverride | None = Field(
        default=None, description="keys of requirements that differ in this scene"
    )

    @property
    def clarity(self) -> tuple[str, float] | None:
        """The key and value of how far one sees in this water; None where a type or a file says all."""
        found = ((key, getattr(self, key)) for key in words.CLARITY_KEYS)
        return next(((key, value) for key, value in found if value is not None), None)


def grid(low: float, high: float, step: float) -> tuple[float, ...]:
    """Points every `step` from `low`, and `high`."""
    n_steps = math.floor((high - low) / step + 1e-9)
    points = [round(low + i * step, 9) for i in range(n_steps + 1)]
    return tuple(points) if high - points[-1] < 1e-9 else (*points, high)


def _pair(value: float | tuple[float, float]) -> tuple[float, float]:
    return value if isinstance(value, tuple) else (value, value)
