"""What an experienced engineer asks for without being told: all recommended keys, by one word of a mission.

`practice: recommended`, the default, fills in what a mission leaves out, and nothing that it says. What is filled in
stands in the mission of a result like any other key. `practice: bare` asks for nothing beside what is written.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from uwopt.mission.reserves import RECOMMENDED, RECOMMENDED_RESERVE

Practice = Literal["recommended", "bare"]
DEFAULT_PRACTICE: Practice = "recommended"

#: Keys by section, with the values that fill them.
RECOMMENDED_KEYS: Mapping[str, Mapping[str, Any]] = {
    "requirements": {
        "snr_at": "worst", "dof_at": "corner", "lens_stop_down": 1.0, "min_mtf_half_nyquist": 0.3, "refuse": "all",
    },
    "vehicle": {"lamp_supply": "external"},
    "catalog": {"host": "estimate", "rest": "estimate", "housing": "required", "spacers": "allow"},
}
RECOMMENDED_CONFIDENCE = 0.9  # share of the scenarios of what is uncertain in which hardware must hold
LEAST_UNIFORMITY = 0.3  # darkest over mean illuminance of the floor, where there are lamps
#: Signal to noise of 10:1, the first acceptable one of ISO 12232: noise then covers detail of a tenth of the signal.
ACCEPTABLE_SNR_DB = 20.0
SNR_KEYS = ("min_snr", "min_snr_db")  # by which a mission says what it wants itself
SHARP_OVER_THE_BAND = 0.0  # least depth of field: no length of its own, but every altitude of the band is sharp
HOUSING_WORDS = ("hous", "enclos", "hull", "pressure case", "canister")  # in the names of extras
SLOW_LAMP_S, SLOW_CAMERA_S = 10.0, 60.0  # between images; from here on what is switched off between them saves much


def with_practice(data: Mapping[str, Any]) -> dict[str, Any]:
    """A mission's plain values with what good practice asks for, where it is wanted and nothing else is said."""
    made = dict(data)
    if made.get("practice", DEFAULT_PRACTICE) is None:
        del made["practice"]  # a key left empty is left out
    if not is_wanted(made.get("practice", DEFAULT_PRACTICE)):
        return made
    filled: dict[str, dict[str, Any]] = {section: dict(keys) for section, keys in RECOMMENDED_KEYS.items()}
    vehicle, requirements, catalog = (_section(made, name) for name in ("vehicle", "requirements", "catalog"))
    if _most_lamps(vehicle.get("light_count")) > 0:
        filled["requirements"]["min_uniformity"] = LEAST_UNIFORMITY
    if all(requirements.get(key) is None for key in SNR_KEYS):
        filled["requirements"]["min_snr_db"] = ACCEPTABLE_SNR_DB
    if _leaves_its_altitude(made):
        filled["requirements"]["min_dof_m"] = SHARP_OVER_THE_BAND
    if catalog.get("extras"):
        left_out = ["host", "rest", *(["housing"] if _names_a_housing(catalog["extras"]) else [])]
        for key in left_out:  # computer and cables may be among them, and would count twice
            del filled["catalog"][key]
    interval_s = requirements.get("frame_interval_s")
    filled["vehicle"] |= {key: "off" for key, word in _switched(interval_s).items() if word == "off"}
    made |= _switched_by_scene(made, filled["vehicle"])
    for section, keys in filled.items():
        given = made.get(section)
        if given is None or isinstance(given, Mapping):
            said = {key: value for key, value in (given or {}).items() if value is not None or key not in keys}
            made[section] = {**keys, **said}
    reserve = made.get("reserve")
    if reserve is None:
        made["reserve"] = RECOMMENDED
    elif isinstance(reserve, Mapping):  # one key changes one key; a highest gain that is left empty stays lifted
        left_empty = {key for key, value in reserve.items() if value is None and key in RECOMMENDED_RESERVE}
        given = {key: value for key, value in reserve.items() if key not in left_empty - {"max_gain_db"}}
        made["reserve"] = {**RECOMMENDED_RESERVE, **given}
    if made.get("confidence") is None:
        made["confidence"] = RECOMMENDED_CONFIDENCE
    return made


def _switched(interval_s: Any) -> dict[str, str]:
    """What is on or off between images that are so far apart; nothing where no number says how far."""
    if not isinstance(interval_s, (int, float)):
        return {}
    slow = {"lamps_between_images": SLOW_LAMP_S, "camera_between_images": SLOW_CAMERA_S}
    return {key: "off" if interval_s >= least_s else "on" for key, least_s in slow.items()}


def _switched_by_scene(made: Mapping[str, Any], filled: Mapping[str, Any]) -> dict[str, Any]:
    """The scenes, each with what is on or off between its own images, where that differs and nobody says it."""
    scenes = made.get("scenes")
    if not isinstance(scenes, (list, tuple)):
        return {}
    said = {key for key, value in _section(made, "vehicle").items() if value is not None}
    told = []
    for scene in scenes:
        own = _section(scene, "vehicle") if isinstance(scene, Mapping) else {}
        words = _switched(_section(scene, "requirements").get("frame_interval_s")) if isinstance(scene, Mapping) else {}
        differs = {key: word for key, word in words.items() if word != filled.get(key, "on") and key not in said}
        is_open = isinstance(scene, Mapping) and (scene.get("vehicle") is None or own)
        told.append({**scene, "vehicle": {**differs, **own}} if differs and is_open else scene)
    return {"scenes": told}


def _names_a_housing(extras: Any) -> bool:
    """Whether a housing is among what every system carries besides its parts."""
    items = extras if isinstance(extras, (list, tuple)) else []
    names = [str(item.get("name")).casefold() for item in items if isinstance(item, Mapping)]
    return any(word in name for name in names for word in HOUSING_WORDS)


def is_wanted(practice: Any) -> bool:
    """Whether a mission asks for good practice."""
    return isinstance(practice, str) and practice.strip().casefold() == RECOMMENDED


def _section(data: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    given = data.get(name)
    return given if isinstance(given, Mapping) else {}


def _leaves_its_altitude(data: Mapping[str, Any]) -> bool:
    """Whether some scene has a band of altitudes; what is no number is told elsewhere."""
    scenes = data.get("scenes")
    places = [data, *(scenes if isinstance(scenes, (list, tuple)) else [data.get("scene")])]
    bands = [_section(one, "vehicle").get("altitude_tolerance_m") for one in places if isinstance(one, Mapping)]
    return any(isinstance(band, (int, float)) and band > 0 for band in bands)


def _most_lamps(count: Any) -> float:
    """The most lamps that a mission's `light_count` allows; what is no number is told elsewhere."""
    numbers = count if isinstance(count, (list, tuple)) else [count]
    return max((n for n in numbers if isinstance(n, (int, float))), default=1)
