"""Every figure that is compared: its name in results, its words, its unit, which way is better, and its term.

One table for objectives, fronts, own objectives, key figures of a report and the words of a verdict. A term is
the name of a figure as an objective. Cost has no unit here: its currency is the mission's.
"""

from __future__ import annotations

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
#: By what figures are told that no scenarios count: of an estimated number no end of its range.
AT_LIKELIEST = "with every estimate at its likeliest value"
TERMS = {one.term: one for one in QUANTITIES if one.term}
