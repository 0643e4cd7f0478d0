"""The controls of the page: what each sets in the mission or the system, over which span a slider runs.

A control is text as a person types it; what it means, and what is allowed, the mission and system files say. The span
of a slider is what is usual, no limit: a number beyond it may be typed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

from uwopt.catalog.curves.spectra import light_spectrum_names
from uwopt.catalog.records import OF_A_DESIGN
from uwopt.documents.key_types import keys_of
from uwopt.mission.keys import JERLOV_TYPES, OBJECTIVES, SEAFLOORS
from uwopt.mission.mission import mission_sections
from uwopt.mission.system import system_sections
from uwopt.units import split_unit, symbol

OWN = "own numbers"  # in place of a part's id: the record that the controls below it state
PARTS = OF_A_DESIGN


@dataclass(frozen=True)
class Control:
    """One key of the mission or the system."""

    file: Literal["mission", "system"]
    section: str  # of the file; "" is its top level
    key: str
    label: str
    group: str
    low: float | None = None  # ends of the slider; None where there is none
    high: float | None = None
    log: bool = False
    choices: tuple[str, ...] = ()
    is_part: bool = False

    @property
    def id(self) -> str:
        """Its name among all controls."""
        return "-".join(part for part in (self.file[0], self.section, self.key) if part)

    @property
    def unit(self) -> str:
        """Of its number, as it is printed."""
        if self.choices or self.is_part or self.key.startswith("f_number"):  # its least is no minute
            return ""
        return symbol(split_unit(self.key)[1])

    @property
    def meaning(self) -> str:
        """What the file's schema says of the key."""
        model = (mission_sections if self.file == "mission" else system_sections)()[self.section]
        return keys_of(model)[self.key].description or ""


LIGHT, WATER, LENS, CAMERA, PORT = "Light", "Water and floor", "Lens", "Camera", "Port"
MOTION, SETTINGS, WANTED, LIMITS, MODEL = "Operation", "Settings", "Requirements", "Limits", "Model"
_s, _m = partial(Control, "system"), partial(Control, "mission")
CONTROLS: tuple[Control, ...] = (
    _s("", "light", "Light", LIGHT, is_part=True),
    _s("light", "spectrum", "Light type (spectrum)", LIGHT, choices=light_spectrum_names()),
    _s("light", "flux_lm", "Light of one lamp", LIGHT, 100, 200_000, log=True),
    _s("light", "beam_half_angle_deg", "Beam half-angle", LIGHT, 5, 85),
    _s("light", "beam", "Shape of the beam", LIGHT, choices=("disc", "cosine-power")),
    _s("light", "power_w", "Power of one lamp", LIGHT, 1, 2000, log=True),
    _s("", "light_count", "Number of lamps", LIGHT, 0, 8),
    _s("", "light_baseline_m", "Lamps from the port, across track", LIGHT, 0, 3),
    _s("", "light_tilt_deg", "Outward tilt of the lamps", LIGHT, -45, 45),
    _m("scene", "sun_lux", "Sunlight at the surface", LIGHT, 0, 120_000),
    _m("scene", "sun_elevation_deg", "Elevation of the sun", LIGHT, 0, 90),
    _m("scene", "water", "Water type", WATER, choices=JERLOV_TYPES),
    _m("scene", "water_table", "Table of the water types", WATER, choices=("measured", "solonenko-mobley")),
    _m("scene", "seafloor", "Bottom type", WATER, choices=SEAFLOORS),
    _m("scene", "depth_m", "Depth", WATER, 0, 1000),
    _s("", "camera", "Camera", CAMERA, is_part=True),
    _s("camera", "resolution_x_px", "Pixels, image width", CAMERA, 320, 8000),
    _s("camera", "resolution_y_px", "Pixels, image height", CAMERA, 240, 6000),
    _s("camera", "pixel_pitch_um", "Pixel pitch", CAMERA, 1, 12),
    _s("camera", "read_noise_e", "Read noise", CAMERA, 0.5, 50, log=True),
    _s("camera", "saturation_e", "Saturation", CAMERA, 1000, 100_000, log=True),
    _s("", "orientation", "Orientation", CAMERA, choices=("landscape", "portrait")),
    _s("", "lens", "Lens", LENS, is_part=True),
    _s("lens", "focal_length_mm", "Focal length", LENS, 2, 75, log=True),
    _s("lens", "transmission_frac", "Transmission", LENS, 0.5, 1),
    _s("lens", "f_number_min", "Widest f-number", LENS, 0.8, 8),
    _s("lens", "f_number_max", "Narrowest f-number", LENS, 2, 32),
    _s("", "port", "Port", PORT, is_part=True),
    _s("port", "geometry", "Flat or dome", PORT, choices=("flat", "dome")),
    _s("port", "outer_radius_mm", "Outer radius of the dome", PORT, 20, 200),
    _s("port", "thickness_mm", "Thickness", PORT, 1, 40),
    _s("port", "refractive_index", "Refractive index", PORT, 1.3, 1.9),
    _m("vehicle", "altitude_m", "Altitude", MOTION, 0.3, 10),
    _m("vehicle", "altitude_tolerance_m", "Tolerance of the altitude", MOTION, 0, 2),
    _m("vehicle", "speed_m_s", "Speed", MOTION, 0, 3),
    _m("requirements", "overlap", "Overlap of images", MOTION, 0, 0.95),
    _m("requirements", "max_blur_px", "Motion blur allowed", MOTION, 0.1, 5),
    _s("settings", "f_number", "f-number", SETTINGS, 0.8, 22, log=True),
    _s("settings", "exposure_ms", "Exposure", SETTINGS, 0.01, 200, log=True),
    _s("settings", "gain", "Gain, a ratio", SETTINGS, 1, 64, log=True),
    _s("settings", "flux_lm", "Light of all lamps", SETTINGS, 100, 200_000, log=True),
    _s("settings", "frame_rate_hz", "Frame rate", SETTINGS, 0.1, 60, log=True),
    _s("settings", "focus_distance_m", "Focus, in water from the port", SETTINGS, 0.2, 20, log=True),
    _m("requirements", "min_snr_db", "Least signal to noise", WANTED, 0, 50),
    _m("requirements", "min_dof_m", "Least depth of field", WANTED, 0, 5),
    _m("requirements", "max_gsd_mm", "Largest pixel on the floor", WANTED, 0.05, 5, log=True),
    _m("requirements", "min_swath_m", "Least swath", WANTED, 0, 5),
    _m("requirements", "min_contrast", "Least contrast", WANTED, 0, 1),
    _m("requirements", "mean_level", "Wanted mean image level", WANTED, 0.01, 0.9),
    _m("limits", "cost", "Highest cost", LIMITS, 500, 50_000, log=True),
    _m("limits", "power_w", "Highest mean power", LIMITS, 1, 2000, log=True),
    _m("limits", "mass_kg", "Highest mass", LIMITS, 0.5, 50, log=True),
    _m("", "physics", "Physics", MODEL, choices=("auto", "full", "paper")),
    _m("", "practice", "What is left open asks for", MODEL, choices=("bare", "recommended")),
    _m("", "objective", "What is to be best", MODEL, choices=OBJECTIVES),
)
BY_ID = {one.id: one for one in CONTROLS}
GROUPS = tuple(dict.fromkeys(one.group for one in CONTROLS))
#: Where a part is an own record for the first time, what it states.
FIRST_RECORDS: dict[str, dict[str, float | str]] = {
    "camera": {"resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.5,
               "saturation_e": 10_500, "quantum_efficiency": 0.6},
    "lens": {"focal_length_mm": 8, "f_number_min": 1.4, "f_number_max": 16, "transmission_frac": 0.9},
    "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10, "refractive_index": 1.5},
    "light": {"spectrum": "generic-led", "flux_lm": 20_000, "power_w": 200, "beam": "disc",
              "beam_half_angle_deg": 45},
}  # fmt: skip
