"""Which keys are sure to ask for more of the same hardware, and missions compared by what they ask for.

Where one mission asks for no less than another in such keys and is like it in all else, no hardware is better in it:
what misses the weaker one misses the stricter, and a bound that holds there holds here.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from uwopt.mission.mission import Mission

#: Keys of which more asks for more of the same hardware, all else equal: what misses it at a value misses it beyond.
#: Those of which less does are below. Of keys in neither, such as an altitude, anything may change.
STRICTER_UP = frozenset({
    "speed_m_s", "pitch_rate_deg_s", "roll_rate_deg_s", "subject_speed_m_s", "duration_h", "overlap", "min_snr",
    "min_snr_db", "min_snr_red_db", "min_swath_m", "min_common_swath_m", "disparity_error_px",
    "min_area_m2_h", "sidelap", "min_contrast", "min_uniformity", "min_mtf_half_nyquist", "depth_rating_m",
})  # fmt: skip
STRICTER_DOWN = frozenset({
    "frame_interval_s", "max_blur_px", "max_skew_px", "max_gsd_mm", "max_depth_error_mm", "max_white_balance",
    "max_airy_px", "cost", "power_w", "peak_power_w", "energy_wh", "storage_gb", "mass_kg", "mass_water_kg", "size_mm",
    "diameter_mm", "data_rate_mb_s", "max_exposure_ms",
})  # fmt: skip
STRICTER_RESERVE = frozenset({"snr_db", "blur", "swath", "energy"})
#: Where cameras go into housings, the cheapest that fits stands for all: another may be left when these ask for more.
OF_HOUSINGS = frozenset({"size_mm", "diameter_mm", "depth_rating_m"})
SECTIONS = ("vehicle", "requirements", "limits", "reserve")
UNHEARD = ("name", "seed", "confidence", "doubt")  # keys of a mission that no search at likeliest values asks
#: Keys of a scene that change the light alone, not what is seen: nothing of an index of refraction, or of heights.
OF_LIGHT = (
    "water", "c_per_m", "visibility_m", "secchi_m", "turbidity_ntu", "water_table", "seafloor", "backscatter_ratio",
    "phase_function", "multiple_scattering",
)  # fmt: skip


def sign_of(mission: Mission, section: str, name: str) -> int:
    """1 where more of a key asks for more, -1 where less does, 0 where neither is sure."""
    if section not in SECTIONS and name != "subject_speed_m_s":
        return 0
    if section == "reserve":
        return 1 if name in STRICTER_RESERVE else 0
    if name in OF_HOUSINGS and mission.catalog.housing != "none":
        return 0
    if name == "speed_m_s" and any(view.asked.min_area_m2_h is not None for view in mission.views):
        return 0  # faster covers more
    return 1 if name in STRICTER_UP else -1 if name in STRICTER_DOWN else 0


@dataclass(frozen=True)
class Asking:
    """What a mission asks for: how much, where more is sure to ask for more, and all else."""

    family: str  # all else, as text: missions of one family are compared by their amounts
    amounts: tuple[float, ...]  # turned so that more asks for more

    @staticmethod
    def of(mission: Mission) -> Asking:
        """A mission, taken apart."""
        data, amounts = mission.to_dict(absolute_paths=True), list[float]()
        for name in UNHEARD:
            data.pop(name, None)
        for section, place in sections_of(data):
            for name, value in place.items():
                if type(value) in (int, float) and (sign := sign_of(mission, section, name)):
                    amounts.append(sign * float(value))
                    place[name] = "amount"
        return Asking(json.dumps([data, str(mission.base_dir)], sort_keys=True, default=str), tuple(amounts))

    def asks_no_more(self, other: Asking) -> bool:
        """Whether whatever meets another mission meets this one."""
        if self.family != other.family:
            return False
        return all(mine <= its for mine, its in zip(self.amounts, other.amounts, strict=True))


def sections_of(data: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The sections of a mission and of its scenes, with the name that keys have in them."""
    for section in SECTIONS:
        if isinstance(data.get(section), dict):
            yield section, data[section]
    for scene in data["scenes"]:
        yield "scene", scene
        for section in ("vehicle", "requirements"):
            if isinstance(scene.get(section), dict):
                yield section, scene[section]


def apart_from_light(mission: Mission) -> str:
    """All that a mission says, as text, but for what of its scenes changes the light alone."""
    data = mission.to_dict(absolute_paths=True)
    for place, names in ((data, UNHEARD), *((scene, OF_LIGHT) for scene in data["scenes"])):
        for name in names:
            place.pop(name, None)
    return json.dumps([data, str(mission.base_dir)], sort_keys=True, default=str)
