"""What may stand in the columns of a parts table: the one description of built-in and users' files.

Parsing gives typed cells; a cell that is wrong gives a sentence that says what is allowed.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Literal

Kind = Literal["camera", "lens", "port", "light"]
KINDS: tuple[Kind, ...] = ("camera", "lens", "port", "light")
Cell = float | str | bool | tuple[str, ...] | None


@dataclass(frozen=True, slots=True)
class Column:
    """Name, form and allowed range of one column."""

    name: str
    form: Literal["number", "text", "choice", "list", "flag"] = "number"
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False  # the lower limit itself is not allowed
    whole: bool = False
    choices: tuple[str, ...] = ()
    meaning: str = ""

    def allowed(self) -> str:
        """What may stand here, in words."""
        if self.form in ("choice", "list") and self.choices:
            joined = ", ".join(self.choices)
            return f"one of {joined}" if self.form == "choice" else f"any of {joined}, separated by |"
        if self.form == "flag":
            return "yes or no"
        if self.form != "number":
            return "text"
        noun = "a whole number" if self.whole else "a number"
        low = "" if self.low == -math.inf else f"{'above' if self.open_low else 'at least'} {self.low:g}"
        high = "" if self.high == math.inf else f"at most {self.high:g}"
        return " ".join([noun, " and ".join(part for part in (low, high) if part)]).strip()


def _positive(name: str, meaning: str = "", high: float = math.inf, whole: bool = False) -> Column:
    return Column(name, low=0.0, high=high, open_low=True, whole=whole, meaning=meaning)


def _from_zero(name: str, meaning: str = "", high: float = math.inf) -> Column:
    return Column(name, low=0.0, high=high, meaning=meaning)


def _text(name: str, meaning: str = "") -> Column:
    return Column(name, "text", meaning=meaning)


def _choice(name: str, *choices: str, meaning: str = "") -> Column:
    return Column(name, "choice", choices=choices, meaning=meaning)


MOUNT_NAMES = ("C", "CS", "S", "M12", "F", "EF", "MFT", "TFL", "TFL-II", "M42", "M58", "M72", "T2", "none")

IDENTITY = (
    _choice("part", *KINDS, meaning="kind of part, where a file holds several kinds"),
    _text("id", "maker_model; never reused"),
    _text("manufacturer"),
    _text("model"),
    _choice("availability", "current", "discontinued", "not_a_product", "unknown"),
)

COMMERCE = (
    _from_zero("mass_g", "mass of one piece"),
    _from_zero("mass_low_g"),
    _from_zero("mass_high_g"),
    _from_zero("price", "of one piece"),
    _from_zero("price_low"),
    _from_zero("price_high"),
    _text("currency", "three letters, e.g. USD"),
    _text("price_date", "YYYY-MM-DD"),
    _choice("price_status", "quoted", "derived", "estimated", meaning="how the price is known"),
    _text("source_url", "where the numbers are from"),
    _text("correction", "old value and reason, where a source was corrected"),
    _text("note"),
)

CAMERA = (
    _text("chip", "maker and type of the sensor"),
    _choice("colour", "mono", "colour"),
    _positive("resolution_x_px", whole=True),
    _positive("resolution_y_px", whole=True),
    _positive("pixel_pitch_um", high=100.0),
    _choice("shutter", "global", "rolling"),
    _text("optical_format_in", "such as 2/3"),
    Column("mounts", "list", choices=MOUNT_NAMES, meaning="lens mounts, separated by |"),
    _text("interface", "such as USB3 or GigE"),
    _positive("bandwidth_mb_s", "what the interface carries, 10^6 byte/s"),
    _positive("max_frame_rate_hz", "at full resolution"),
    Column("bit_depth", low=1, high=32, whole=True, meaning="of the transmitted image"),
    _from_zero("read_noise_e", "temporal dark noise"),
    _positive("saturation_e", "EMVA 1288 saturation capacity"),
    _from_zero("dark_current_e_s"),
    _positive("gain_dn_per_e", "at 0 dB, in numbers of gain_bits"),
    Column("gain_bits", low=1, high=32, whole=True, meaning="bit depth that gain_dn_per_e refers to"),
    _from_zero("max_gain_db"),
    _from_zero("black_level_dn"),
    _positive("min_exposure_us"),
    _positive("max_exposure_us"),
    _from_zero("exposure_offset_us", "added to each exposure by the sensor"),
    _from_zero("prnu_frac", high=1.0),
    _positive("qe", "quantum efficiency at qe_nm, 0..1", high=1.0),
    Column("qe_nm", low=200, high=1200, meaning="wavelength of qe"),
    _text("qe_curve", "id of a curve, or a CSV with wavelength_nm, qe and channel for colour"),
    _positive("power_w"),
    _choice("perf_quality", "A", "B", "C", "D", meaning="grade of the sensor's figures"),
    _positive("snr_max_db"),
    _positive("dynamic_range_db"),
)

LENS = (
    _positive("focal_length_mm"),
    _positive("f_number_min", "widest opening"),
    _positive("f_number_max", "smallest opening"),
    _choice("aperture_control", "manual", "motorised", "fixed", "unknown"),
    _positive("image_circle_mm", "diameter"),
    _text("optical_format_in", "such as 2/3"),
    Column("mounts", "list", choices=MOUNT_NAMES, meaning="mounts, separated by |"),
    _positive("transmission_frac", high=1.0),
    _positive("rated_megapixel"),
    _positive("rated_pixel_pitch_um"),
    _positive("rated_lp_per_mm"),
    _from_zero("min_object_distance_m", "from the lens's front, in air"),
    Column("distortion_pct"),
    _positive("length_mm"),
    _positive("diameter_mm"),
    _text("filter_thread"),
    Column("is_zoom", "flag"),
)

PORT = (
    _choice("geometry", "flat", "dome"),
    _text("material"),
    _text("glass", "id of a dispersion formula, such as n_bk7"),
    Column("refractive_index", low=1.0, high=3.0, open_low=True),
    _positive("outer_radius_mm", "radius of curvature of a dome"),
    _positive("thickness_mm"),
    _positive("clear_diameter_mm"),
    _positive("nominal_diameter_mm", "trade size"),
    _from_zero("gap_mm", "from the lens's entrance pupil to a flat port"),
    _positive("depth_rating_m"),
)

LIGHT = (
    _choice("kind", "continuous", "pulsed_led", "flash"),
    _positive("flux_lm", "nameplate, one lamp at full; while on"),
    _positive("power_w", "electrical, one lamp at full; while on"),
    _positive("mean_power_w", "of a pulsed lamp"),
    _positive("output_factor", "share of flux_lm that leaves the window", high=1.0),
    _choice("beam", "disc", "cone", "cosine-power", "tabulated"),
    _positive("beam_angle_deg", "full angle", high=180.0),
    _choice("beam_medium", "air", "water", "not stated"),
    _text("beam_profile", "id of a profile, a CSV with angle_deg, intensity, or an IES file"),
    _positive("peak_candela"),
    _text("dim_levels", "shares of full such as 1|0.5|0.25, or continuous, or none"),
    Column("dim_step_count", low=1, whole=True),
    _from_zero("dim_min_frac", high=1.0),
    _positive("min_pulse_us"),
    _positive("max_pulse_us"),
    _positive("max_duty_frac", high=1.0),
    _positive("max_rate_hz"),
    _positive("flash_energy_j", "full energy of one pulse"),
    _positive("flash_efficacy_lm_s_per_j"),
    _positive("flash_duration_us"),
    _positive("recycle_s"),
    _positive("charging_efficiency_frac", high=1.0),
    _positive("guide_number_m", "on land, ISO 100"),
    _positive("colour_temperature_k"),
    _positive("cri", high=100.0),
    _text("spectrum", "id of a spectrum, or a CSV with wavelength_nm, relative_power"),
    _positive("front_radius_mm"),
    _positive("depth_rating_m"),
    _positive("supply_v_min"),
    _positive("supply_v_max"),
    _from_zero("mass_water_g"),
)

_OWN: dict[Kind, tuple[Column, ...]] = {"camera": CAMERA, "lens": LENS, "port": PORT, "light": LIGHT}
COLUMNS: dict[Kind, dict[str, Column]] = {
    kind: {column.name: column for column in (*IDENTITY, *own, *COMMERCE)} for kind, own in _OWN.items()
}

#: Without these a row says nothing about a part.
REQUIRED: dict[Kind, tuple[str, ...]] = {
    "camera": ("id", "resolution_x_px", "resolution_y_px", "pixel_pitch_um"),
    "lens": ("id", "focal_length_mm"),
    "port": ("id", "geometry"),
    "light": ("id", "kind"),
}

_DECIMAL_COMMA = re.compile(r"^[+-]?\d+,\d+$")
_FLAGS = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}


class CellError(ValueError):
    """A cell is wrong; the text says what it holds and what is allowed."""


def parse_cell(column: Column, text: str) -> Cell:
    """The typed value of a cell; an empty cell is unknown (None)."""
    if text == "":
        return None
    if column.form == "number":
        return parse_number(column, text)
    if column.form == "flag":
        if text.casefold() not in _FLAGS:
            raise CellError(f"{column.name} = {text!r} is not {column.allowed()}")
        return _FLAGS[text.casefold()]
    if column.form == "choice":
        if text not in column.choices:
            raise CellError(f"{column.name} = {text!r} is not {column.allowed()}")
        return text
    if column.form == "list":
        items = tuple(item.strip() for item in text.split("|") if item.strip())
        wrong = [item for item in items if column.choices and item not in column.choices]
        if wrong:
            raise CellError(f"{column.name} = {text!r} is not {column.allowed()}")
        return items
    return text


def parse_number(column: Column, text: str) -> float:
    """A finite number within the column's range."""
    try:
        value = float(text)
    except ValueError:
        raise CellError(f"{column.name} = {text!r} {_why_no_number(text)}") from None
    if not math.isfinite(value):
        raise CellError(
            f"{column.name} = {text!r} is not a finite number; leave the cell empty if it is unknown"
        )
    below = value <= column.low if column.open_low else value < column.low
    if below or value > column.high or (column.whole and value != int(value)):
        raise CellError(f"{column.name} = {text} must be {column.allowed()}")
    return value


def _why_no_number(text: str) -> str:
    if _DECIMAL_COMMA.match(text):
        return f"has a decimal comma; write {text.replace(',', '.')}"
    if re.match(r"^[+-]?[\d.]+\s*[a-zA-Zµ°%\"]", text):
        return "is not a number; the unit belongs in the header"
    return "is not a number"
