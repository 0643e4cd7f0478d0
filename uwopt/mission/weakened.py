"""A mission's requirements as limits that can be dropped or weakened, and the mission that asks for less."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from uwopt.mission.mission import Mission
from uwopt.mission.practice import ACCEPTABLE_SNR_DB, LEAST_UNIFORMITY, RECOMMENDED_KEYS, SHARP_OVER_THE_BAND
from uwopt.mission.reserves import REFUSED
from uwopt.units import ratio_to_db

DEEP = "depth_rating_m"  # which chooses parts, and is of no scene
FAR_TIMES = 10.0
USELESS_DB = 6.0  # of signal to noise: below, noise is more than half of the signal
LEAST_SNR_DB = 0.0  # below which noise is more than signal, and no image is of use
NOTHING_AT_ZERO = ("lens_stop_down", "min_uniformity")  # requirements of which 0 asks for nothing


class Relaxable(NamedTuple):
    """A requirement that can be dropped or weakened: where it stands, and the objective that makes its figure best."""

    section: str
    key: str
    best: str | None  # where there is one


#: By the names that requirements have.
RELAXABLE = {
    "min_snr": Relaxable("requirements", "min_snr_db", "snr_db"),
    "min_snr_red_db": Relaxable("requirements", "min_snr_red_db", None),
    "max_white_balance": Relaxable("requirements", "max_white_balance", None),
    "max_gsd_mm": Relaxable("requirements", "max_gsd_mm", "gsd_mm"),
    "min_swath_m": Relaxable("requirements", "min_swath_m", None),
    "min_common_swath_m": Relaxable("requirements", "min_common_swath_m", None),
    "max_depth_error_mm": Relaxable("requirements", "max_depth_error_mm", None),
    "min_dof_m": Relaxable("requirements", "min_dof_m", None),
    "max_blur_px": Relaxable("requirements", "max_blur_px", None),
    "max_skew_px": Relaxable("requirements", "max_skew_px", None),
    "max_airy_px": Relaxable("requirements", "max_airy_px", None),
    "max_gain_db": Relaxable("requirements", "max_gain_db", None),
    "lens_stop_down": Relaxable("requirements", "lens_stop_down", None),
    "overlap": Relaxable("requirements", "overlap", None),
    "mean_level": Relaxable("requirements", "mean_level", None),
    "min_contrast": Relaxable("requirements", "min_contrast", "contrast"),
    "min_uniformity": Relaxable("requirements", "min_uniformity", None),
    "min_mtf_half_nyquist": Relaxable("requirements", "min_mtf_half_nyquist", None),
    "resolve_mm": Relaxable("requirements", "resolve_mm", None),
    "cost": Relaxable("limits", "cost", "cost"),
    "power_w": Relaxable("limits", "power_w", "power"),
    "peak_power_w": Relaxable("limits", "peak_power_w", None),
    "mass_kg": Relaxable("limits", "mass_kg", "mass"),
    "mass_water_kg": Relaxable("limits", "mass_water_kg", None),
    "data_rate_mb_s": Relaxable("limits", "data_rate_mb_s", None),
    "energy_wh": Relaxable("limits", "energy_wh", None),
    "storage_gb": Relaxable("limits", "storage_gb", None),
    DEEP: Relaxable("limits", DEEP, None),
}


def asked_value(mission: Mission, name: str) -> float | None:
    """What the mission asks for without its reserve, in any scene the first that does; None when none does."""
    section, key, _ = RELAXABLE[name]
    if name == DEEP:
        return mission.asked_depth_m or None
    if section == "limits":
        value = getattr(mission.limits, key)
        return None if value is None else float(value)
    for view in mission.views:
        if key == "min_snr_db":
            ratio = view.asked.min_snr
            value = None if ratio is None else float(ratio_to_db(ratio))
        else:
            value = getattr(view.asked, key)
        if value is not None and (value or key not in NOTHING_AT_ZERO):
            return float(value)
    return None


def in_all_scenes(mission: Mission, section: str, key: str) -> Any:
    """A requirement as asked, or a key of the vehicle, where it is the same in all scenes; None where they differ."""
    values = {getattr(view.vehicle if section == "vehicle" else view.asked, key) for view in mission.views}
    return values.pop() if len(values) == 1 else None


#: What good practice fills in of the requirements.
FILLED_IN = {
    **RECOMMENDED_KEYS["requirements"], "min_uniformity": LEAST_UNIFORMITY, "min_dof_m": SHARP_OVER_THE_BAND,
    "min_snr_db": ACCEPTABLE_SNR_DB,
}  # fmt: skip


def is_filled_in(mission: Mission, name: str) -> bool:
    """Whether good practice asks for it, and no person who wrote another number into the mission."""
    section, key, _ = RELAXABLE[name]
    if section == "limits":
        return getattr(mission.limits, key) is None
    given = [mission.requirements, *(scene.requirements for scene in mission.scenes)]
    values = {getattr(one, key, None) for one in given if one is not None}
    return values <= {None, FILLED_IN.get(key)}


def without(mission: Mission, name: str) -> Mission | None:
    """The mission without one requirement, in all scenes; None when it cannot be dropped.

    Of the SNR so much is left that something is seen.
    """
    section, key, _ = RELAXABLE[name]
    data = mission.to_dict()
    for own in (data[section], *(scene.get(section) or {} for scene in data["scenes"])):
        if key == "min_snr_db":
            leave_little_snr(own)
        else:
            own.pop(key, None)
        if own.get("refuse"):
            own["refuse"] = [word for word in own["refuse"] if word not in words_of(key)]
    if key == "overlap" and mission.requirements.frame_interval_s is None and mission.vehicle.speed_m_s == 0:
        return None
    return mission.with_changes(**{part: data[part] for part in ("requirements", "limits", "scenes")})


def leave_little_snr(asked: dict[str, Any]) -> None:
    """In place of an SNR that is asked for, the least that shows anything; none where no more was asked for."""
    ratio, value_db = asked.pop("min_snr", None), asked.pop("min_snr_db", None)
    if ratio is not None and value_db is None:
        value_db = float(ratio_to_db(ratio))
    if value_db is not None and value_db > LEAST_SNR_DB:
        asked["min_snr_db"] = LEAST_SNR_DB


def with_central_prices(mission: Mission) -> Mission:
    """The mission whose limit of cost holds estimated prices at their middle."""
    return mission.with_changes(limits=mission.to_dict()["limits"] | {"cost_basis": "central"})


def words_of(key: str) -> list[str]:
    """The refusals that stand for a key."""
    return [word for word, (held, _) in REFUSED.items() if held == key]


def is_from_above(name: str) -> bool:
    """Whether a requirement holds a value down."""
    section, key, _ = RELAXABLE[name]
    return section == "limits" or key.startswith("max_") or key == "resolve_mm"


def with_limit(mission: Mission, name: str, asked: float, value: float) -> Mission:
    """The mission with another limit in all scenes; one that already asks for less stays as it is.

    A rating of depth is asked for by the limits, or by the deepest scene: a mission that is told the depth alone goes
    no deeper than that.
    """
    section, key, _ = RELAXABLE[name]
    data = mission.to_dict()
    if name == DEEP and is_of_scenes(data):
        return mission.with_changes(scenes=[{**one, "depth_m": min(one["depth_m"], value)} for one in data["scenes"]])
    if name == DEEP:
        return mission.with_changes(limits=data["limits"] | {DEEP: value})

    def weaker(old: float) -> float:
        if key == "mean_level":
            return value if old == asked else old
        return max(old, value) if value > asked else min(old, value)

    for place in (data, *data["scenes"]):
        own = place.get(section) or {}
        if own.get(key) is not None:
            own[key] = weaker(float(own[key]))
        elif set(own.get("refuse") or ()).intersection(words_of(key)):
            own[key] = weaker(asked)
    return mission.with_changes(**{part: data[part] for part in ("requirements", "limits", "scenes")})


def is_of_scenes(mission: Mapping[str, Any]) -> bool:
    """Whether the depth that parts are rated for is that of a mission's scenes, by its plain values."""
    return (mission.get("limits") or {}).get(DEEP) is None


def is_far(name: str, asked: float | None, needed: float | None) -> bool:
    """Whether a change is out of reach: to ten times what is asked, or a tenth of it; of decibels to mere noise."""
    if name in ("min_snr", "min_snr_red_db"):
        return asked is not None and needed is not None and needed < min(asked, USELESS_DB)
    if not asked or not needed:
        return False
    times = needed / asked
    return times >= FAR_TIMES or 0.0 < times <= 1.0 / FAR_TIMES
