"""Every figure that is compared: its name in results, its words, its unit, which way is better, and its term.

One table for objectives, fronts, own objectives, key figures of a report and the words of a verdict. A term is
the name of a figure as an objective. Cost has no unit here: its currency is the mission's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Compared:
    """One figure of a design in a mission."""

    name: str
    words: str
    unit: str
    better: Literal["less", "more"] = "less"
    term: str = ""
    best: str = ""  # in words, the design that has the best of it

    @property
    def worst_scene(self) -> Literal["most", "least"]:
        """Which scene counts where there are several: the one with the most or the least."""
        return "least" if self.better == "more" else "most"


QUANTITIES = (
    Compared("power_w", "power", "W", term="power"),
    Compared("cost", "cost", "", term="cost"),
    Compared("mass_kg", "mass", "kg", term="mass"),
    Compared("snr_db", "signal to noise", "dB", "more", "snr_db", "highest SNR"),
    Compared("gsd_mm", "pixel on the floor", "mm", term="gsd_mm", best="finest pixel on the floor"),
    Compared("contrast", "contrast", "", "more", "contrast", "highest contrast"),
    Compared("information_bit_per_m2", "information", "bit/m2", "more", "information", "highest information"),
    Compared("white_balance", "white balance, strongest over weakest channel", ""),
    Compared("light_power_w", "power of the lights", "W"),
    Compared("f_number", "f-number", ""),
    Compared("exposure_ms", "exposure", "ms"),
    Compared("gain", "gain as a ratio", ""),
    Compared("level", "light level", ""),
    Compared("flux_lm", "light of all lamps", "lm"),
    Compared("light_count", "number of lights", ""),
    Compared("frame_rate_hz", "frame rate", "Hz"),
    Compared("swath_m", "swath", "m", "more"),
    Compared("common_swath_m", "swath of both cameras", "m", "more"),
    Compared("depth_error_mm", "error of a distance by stereo", "mm"),
    Compared("line_spacing_m", "distance between lines", "m", "more"),
    Compared("area_m2_h", "area in an hour", "m2/h", "more"),
    Compared("blur_px", "motion blur", "px"),
    Compared("dof_m", "depth of field", "m", "more"),
    Compared("dof_near_m", "nearest that is sharp", "m"),
    Compared("dof_far_m", "farthest that is sharp", "m", "more"),
    Compared("mean_level", "mean image level", ""),
    Compared("saturation_fraction", "highlights, share of saturation", ""),
    Compared("data_rate_mb_s", "data rate", "MB/s"),
)
BY_NAME = {one.name: one for one in QUANTITIES}
#: What hardware that does not hold lacks, in words, where that is no requirement.
LOST_TO = {
    "light": "enough signal without saturating", "rules": "rate, pulse or power of the lamp, or the shutter",
    "housing": "room for camera and lens in the housing", "focus": "focus behind this port",
}  # fmt: skip
#: By what figures are told that no scenarios count: of an estimated number no end of its range.
AT_LIKELIEST = "with every estimate at its likeliest value"
TERMS = {one.term: one for one in QUANTITIES if one.term}

#: Requirements in words, which stand in tables; in a sentence what comes before the comma.
REQUIREMENTS: Mapping[str, str] = {
    "max_blur_px": "motion blur",
    "max_skew_px": "rolling-shutter skew",
    "overlap": "overlap along track",
    "frame_interval_s": "time between images",
    "frame_rate": "frame rate of the camera",
    "nearest_focus_m": "nearest focus of the lens",
    "farthest_focus_m": "farthest focus of the lens on its spacer ring",
    "port_clears_view_mm": "view clear of the port's edge",
    "horizon": "far edge of the frame, times as far as its middle",
    "dof_near_m": "nearest that is sharp",
    "dof_far_m": "farthest that is sharp",
    "min_dof_m": "depth of field",
    "max_gsd_mm": "pixel on the floor",
    "min_swath_m": "swath",
    "min_common_swath_m": "swath of both cameras",
    "max_depth_error_mm": "error of a distance by stereo",
    "min_snr_db": "signal to noise",
    "min_snr": "signal to noise",
    "min_snr_mean_db": "signal to noise of the mean", "snr_at_less_db": "drop of signal to noise over the frame",
    "min_snr_red_db": "signal to noise of red",
    "max_white_balance": "white balance, strongest over weakest channel",
    "min_contrast": "contrast",
    "min_uniformity": "evenness of the light",
    "min_mtf_half_nyquist": "sharpness at half Nyquist",
    "resolve_mm": "finest bars that arrive",
    "mean_level": "mean image level",
    "saturation_fraction": "highlights, share of saturation",
    "f_number_min": "f-number, widest of the lens",
    "lens_stop_down": "lens closed from its widest opening",
    "max_airy_px": "Airy disc",
    "max_gain_db": "gain",
    "lamp_clear_m": "room between lamps and view",
    "lamp_beside_port_m": "room between lamps and port",
    "lamps_apart_m": "room between lamps",
    "f_number_max": "f-number, smallest of the lens",
    "gain_min": "gain as a ratio, lowest",
    "gain_max": "gain as a ratio, highest",
    "max_exposure_ms": "exposure, longest",
    "min_exposure_ms": "exposure, shortest",
    "light_level_max": "light level, full",
    "light_level": "light level, a step of the lamp",
    "fixed_f_number": "f-number, fixed by the mission",
    "fixed_exposure_ms": "exposure, fixed by the mission",
    "fixed_gain": "gain as a ratio, fixed by the mission",
    "fixed_dim_frac": "light level, fixed by the mission",
    "max_pulse_ms": "pulse, longest",
    "min_pulse_ms": "pulse, shortest",
    "light_duty": "duty of the lamp",
    "light_rate": "rate of the lamp",
    "shutter_open_ms": "whole sensor open for the pulse",
    "common_f_number": "f-number, one for all scenes",
    "common_focus_m": "focus, one for all scenes",
    "cost": "cost",
    "power_w": "power",
    "peak_power_w": "peak power of the lamps",
    "mass_kg": "mass",
    "mass_water_kg": "mass in water",
    "size_mm": "size of the housing",
    "diameter_mm": "diameter of the housing",
    "housing_diameter_mm": "width of camera and lens in the housing",
    "housing_length_mm": "length of camera and lens in the housing",
    "dome_radius_mm": "front of the lens in the dome",
    "tube_mouth_mm": "view through the mouth of the housing",
    "data_rate_mb_s": "data rate",
    "energy_wh": "energy of the whole mission",
    "storage_gb": "storage of the whole mission",
    "card_gb": "storage that the cameras have themselves",
    "run_time_h": "time that the cameras' own batteries last",
    "lamp_trigger": "signal that fires the lamps",
    "depth_rating_m": "depth rating",
    "rated_time_h": "time that the depth rating holds",
}
