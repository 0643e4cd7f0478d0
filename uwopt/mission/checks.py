"""What a mission's keys must fulfil among each other, and the one form that all missions are brought to.

Plain values in, faults out: each fault is the path of a key and the rest of a sentence about it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from uwopt.documents.faults import KeyPath
from uwopt.documents.key_types import given_values, keys_of, without_empty
from uwopt.mission.keys import CLARITY_KEYS, JERLOV_TYPES, OTHER_NAMES, TARGET_WORDS
from uwopt.mission.sections.requirements import Requirements
from uwopt.mission.sections.vehicle import Vehicle

HARDWARE_KEYS = (
    "light_count",
    "light_baseline_m",
    "light_tilt_deg",
    "light_mounts",
    "lamp_size_m",
    "lamp_supply",
    "camera_count",
    "camera_baseline_m",
    "camera_convergence_deg",
    "orientation",
    "supply",
    "cable_m",
)

WHOLE_MISSION_KEYS = ("duration_h", "battery_wh")

REQUIRED_OF_VEHICLE = {"altitude_m": (1e-3, 1000.0), "speed_m_s": (0.0, 50.0)}

Values = Mapping[str, Any]
Fault = tuple[KeyPath, str]


def in_one_form(data: Values) -> tuple[dict[str, Any], list[Fault]]:
    """`scene` as a list of one, scenes named, and overrides of a scene in their sections."""
    plain: dict[str, Any] = dict(data)
    faults: list[Fault] = []
    if plain.get("scene") is not None and plain.get("scenes") is not None:
        faults.append((("scene",), "and scenes are both given; keep one of them"))
    if "scene" in plain:
        scene = plain.pop("scene")
        if scene is not None and plain.get("scenes") is None:
            plain["scenes"] = scene if isinstance(scene, (list, tuple)) else [scene]
    for section in ("requirements", "reserve", "limits", "fixed", "catalog"):
        if section in plain and plain[section] is None:
            del plain[section]
    plain["vehicle"], twice = _by_usual_names(plain.get("vehicle"), ("vehicle",))
    faults += twice
    if plain["vehicle"] is None:
        del plain["vehicle"]
    if isinstance(plain.get("scenes"), Mapping):
        plain["scenes"] = [plain["scenes"]]
    if isinstance(plain.get("scenes"), (list, tuple)):
        scenes = []
        for index, scene in enumerate(plain["scenes"]):
            made, wrong = _scene_in_one_form(scene, index) if isinstance(scene, Mapping) else (scene, [])
            scenes.append(made)
            faults += wrong
        plain["scenes"] = scenes
        plain["vehicle"] = _with_what_every_scene_gives(plain.get("vehicle"), scenes)
        if plain["vehicle"] is None:
            del plain["vehicle"]
    return plain, faults


def _by_usual_names(section: Any, path: KeyPath) -> tuple[Any, list[Fault]]:
    """A section with the usual names of keys that have another one; a key that is given by both is told of."""
    if not isinstance(section, Mapping):
        return section, []
    made, faults = dict(section), []
    for other, usual in OTHER_NAMES.items():
        if other not in made:
            continue
        value = made.pop(other)
        if made.get(usual) is not None and value is not None:
            faults.append(((*path, other), f"and {usual} are both given and mean the same; keep one of them"))
        elif value is not None:
            made[usual] = value
    return made, faults


def _with_what_every_scene_gives(vehicle: Any, scenes: Sequence[Any]) -> Any:
    """`vehicle`, what it must hold taken from the first scene where every scene overrides it anyhow."""
    if vehicle is not None and not isinstance(vehicle, Mapping):
        return vehicle
    made = dict(vehicle or {})
    for key, (low, high) in REQUIRED_OF_VEHICLE.items():
        own = [
            s["vehicle"].get(key)
            for s in scenes
            if isinstance(s, Mapping) and isinstance(s.get("vehicle"), Mapping)
        ]
        good = [isinstance(v, (int, float)) and not isinstance(v, bool) and low <= v <= high for v in own]
        if made.get(key) is None and own and len(own) == len(scenes) and all(good):
            made[key] = own[0]
    return made or vehicle


def _scene_in_one_form(scene: Values, index: int) -> tuple[dict[str, Any], list[Fault]]:
    made, faults = _by_usual_names(dict(scene), ("scenes", index))
    if "vehicle" in made:
        made["vehicle"], twice = _by_usual_names(made["vehicle"], ("scenes", index, "vehicle"))
        faults += twice
    if made.get("name") is None:
        made["name"] = f"scene {index + 1}"
    for section, model in (("vehicle", Vehicle), ("requirements", Requirements)):
        nested = made.get(section)
        if nested is not None and not isinstance(nested, Mapping):
            continue
        inside = dict(nested or {})
        keys = keys_of(model)
        for key in [key for key in made if key in keys]:
            value = made.pop(key)
            if key in inside:
                path: KeyPath = ("scenes", index, section, key)
                faults.append((path, f"is given twice in this scene, also under {section}; remove one"))
            inside[key] = value
        if inside := without_empty(inside, model):
            made[section] = inside
        else:
            made.pop(section, None)
    return made, faults


def origins(path: KeyPath) -> Iterator[KeyPath]:
    """Where the source may hold what now stands at a path, most direct first, and by which name."""
    others = [(*path[:-1], other) for other, usual in OTHER_NAMES.items() if path and path[-1] == usual]
    for named in (path, *others):
        yield from _places(named)


def _places(path: KeyPath) -> Iterator[KeyPath]:
    """The places of one path."""
    if path == ("scenes",):
        yield ("scene",)
    yield path
    short = (
        (*path[:2], *path[3:])
        if len(path) > 3 and path[0] == "scenes" and path[2] in ("vehicle", "requirements")
        else path
    )
    yield short
    if path[:2] == ("scenes", 0):
        yield ("scene", *path[2:])
        yield ("scene", *short[2:])
        yield ("scene", *path[1:])


def overridden(base: Values, own: Values) -> dict[str, Any]:
    """Values with a scene's own on top; one way of asking for SNR replaces the other."""
    merged = dict(base)
    for given, other in (("min_snr", "min_snr_db"), ("min_snr_db", "min_snr")):
        if own.get(given) is not None and own.get(other) is None:
            merged.pop(other, None)
    return merged | dict(own)


def make_paths_absolute(data: dict[str, Any], resolve: Callable[[str], str]) -> None:
    """Every file name of a dumped mission, resolved in place."""
    for scene in data["scenes"]:
        for key in ("water", "seafloor"):
            if isinstance(scene[key], str) and scene[key].casefold().endswith(".csv"):
                scene[key] = resolve(scene[key])
    catalog = data["catalog"]
    catalog["files"] = [resolve(name) for name in catalog["files"]]
    if catalog["prices"] is not None:
        catalog["prices"] = resolve(catalog["prices"])


def missing_waters(scenes: Any) -> list[Fault]:
    """Scenes, as a file gives them, that say nothing of their water."""
    types, others = ", ".join(JERLOV_TYPES), ", ".join(CLARITY_KEYS)
    text = f"is missing; give the Jerlov type ({types}), the name of a CSV profile, or one of {others}"
    return [
        (("scenes", index, "water"), text)
        for index, scene in enumerate(scenes if isinstance(scenes, (list, tuple)) else ())
        if isinstance(scene, Mapping) and all(scene.get(key) is None for key in ("water", *CLARITY_KEYS))
    ]


def cross_faults(parts: Values) -> list[Fault]:
    """Faults between keys; keys that are wrong on their own have been left out of `parts`."""
    scenes: Sequence[Values] = parts["scenes"] or [{}]
    faults: list[Fault] = []
    for index, scene in enumerate(scenes):
        vehicle = overridden(parts["vehicle"], scene.get("vehicle") or {})
        wanted = overridden(parts["requirements"], scene.get("requirements") or {})
        for section, key, text in (
            *_vehicle_faults(vehicle, scene.get("target") or "floor"),
            *_target_faults(vehicle, wanted, scene.get("target") or "floor"),
            *_ceiling_faults(vehicle, scene),
            *_snr_faults(wanted),
            *_area_faults(vehicle, wanted),
            *_pair_faults(vehicle, wanted),
            *_rate_faults(vehicle, wanted, scene.get("target") or "floor"),
        ):
            inside = key in (scene.get(section) or {})
            faults.append((("scenes", index, section, key) if inside else (section, key), text))
        faults += _hardware_faults(scene, index)
        faults += _dark_faults(scene, index, vehicle)
        faults += _sun_faults(scene, index)
        faults += _clarity_faults(scene, index)
        faults += _rating_faults(parts["limits"], scene, vehicle)
    faults += _less_faults(parts["requirements"], scenes)
    faults += _name_faults(scenes)
    faults += _share_faults(scenes)
    faults += _duration_faults(parts["vehicle"], parts["limits"])
    faults += _battery_faults(parts["vehicle"])
    faults += _housing_faults(parts["limits"], parts.get("catalog") or {})
    faults += _currency_faults(parts["limits"])
    return list(dict.fromkeys(faults))


def _vehicle_faults(vehicle: Values, target: str) -> Iterator[tuple[str, str, str]]:
    altitude_m, tolerance_m = vehicle.get("altitude_m"), vehicle.get("altitude_tolerance_m") or 0.0
    if altitude_m is not None and tolerance_m >= altitude_m:
        key = "altitude_tolerance_m"
        text = f"= {tolerance_m:g} is not below {TARGET_WORDS[target][1]}_m = {altitude_m:g}; lower it"
        yield "vehicle", key, text
    mounts, counts = vehicle.get("light_mounts"), vehicle.get("light_count")
    if mounts is not None and counts is not None and counts[1] > len(mounts):
        text = f"reaches {counts[1]} but light_mounts has {len(mounts)} place(s); add places or lower it"
        yield "vehicle", "light_count", text
    if mounts is not None and counts is not None and counts[0] == 0:
        text = "begins at 0 but light_mounts says where lamps stand; begin at 1, or leave light_mounts out"
        yield "vehicle", "light_count", text
    if mounts is not None and len(mounts) == 0:
        yield "vehicle", "light_mounts", "is empty; list at least one place, or leave the key out"


def _target_faults(vehicle: Values, wanted: Values, target: str) -> Iterator[tuple[str, str, str]]:
    """In mid-water there is no ground that images could cover."""
    if target != "mid_water":
        return
    if vehicle.get("pitch_deg"):
        text = f"= {vehicle['pitch_deg']:g} is of floor, wall or ceiling, and target: mid_water has none; leave it out"
        yield "vehicle", "pitch_deg", text
    for key in ("overlap", "min_area_m2_h"):
        if wanted.get(key) is not None:
            text = "is asked of ground that is passed over, and target: mid_water has none; leave it out"
            yield "requirements", key, text
    if wanted.get("sidelap"):
        text = "is of lines over ground, and target: mid_water has none; leave it out"
        yield "requirements", "sidelap", text


def _sun_faults(scene: Values, index: int) -> Iterator[Fault]:
    """How much daylight a wall or a fish gets depends on which way it faces, which no key says; ice and what floats are
    lit from behind, and the water before them against the light.

    What faces the sun gets of its light tan(zenith angle in water) of what a floor gets, which refraction holds below
    tan(asin(1 / 1.34)) = 1.12, and of light from all above a half: a floor at that depth tells about the most.
    """
    target = scene.get("target") or "floor"
    if target != "floor" and scene.get("sun_lux"):
        why = "it depends on where that faces" if target != "ceiling" else "it comes from behind, through it or past it"
        text = (
            f"= {scene['sun_lux']:g} is daylight, which is reckoned on a floor alone: on a {TARGET_WORDS[target][0]} "
            f"{why}; set sun_lux: 0 (by night, or by lamps that outshine the day)"
        )
        if target != "ceiling":
            text += (
                "; whether they do, uwopt evaluate tells of that system in the same mission with target: floor, which "
                "gets about the most daylight that anything does at that depth"
            )
        yield ("scenes", index, "sun_lux"), text


def _ceiling_faults(vehicle: Values, scene: Values) -> Iterator[tuple[str, str, str]]:
    """Nothing under water is farther above the camera than its surface."""
    depth_m, distance_m = scene.get("depth_m"), vehicle.get("altitude_m")
    if scene.get("target") != "ceiling" or depth_m is None or distance_m is None:
        return
    if distance_m > depth_m:
        text = f"= {distance_m:g} puts the ceiling above the surface: depth_m = {depth_m:g} is the camera's depth; "
        yield "vehicle", "altitude_m", text + "correct one of them"


def _dark_faults(scene: Values, index: int, vehicle: Values) -> Iterator[tuple[KeyPath, str]]:
    """Without lamps only the sun shows anything."""
    counts = vehicle.get("light_count")
    if counts is not None and counts[0] == 0 and not scene.get("sun_lux"):
        text = "is 0, and vehicle.light_count begins at 0: nothing would be seen; give the sun's lux, or begin at 1"
        yield ("scenes", index, "sun_lux"), text


def _area_faults(vehicle: Values, wanted: Values) -> Iterator[tuple[str, str, str]]:
    if wanted.get("min_area_m2_h") is not None and vehicle.get("speed_m_s") == 0:
        yield "requirements", "min_area_m2_h", "is asked, but vehicle.speed_m_s is 0: nothing is covered; give a speed"


def _pair_faults(vehicle: Values, wanted: Values) -> Iterator[tuple[str, str, str]]:
    """What only a stereo pair has, and how many cameras make one."""
    if vehicle.get("camera_baseline_m") is None:
        asked = [("vehicle", key) for key in ("camera_convergence_deg",) if vehicle.get(key)]
        asked += [("requirements", key) for key in ("max_depth_error_mm", "min_common_swath_m") if wanted.get(key)]
        for section, key in asked:
            text = "is of a stereo pair; add vehicle.camera_baseline_m, the metres between its ports, or leave it out"
            yield section, key, text
        return
    if vehicle.get("camera_count", 1) != 2:
        count = vehicle.get("camera_count", 1)
        text = f"is of a stereo pair, but camera_count is {count}; set it to 2, or leave it out"
        yield "vehicle", "camera_baseline_m", text
    if vehicle.get("pitch_deg", 0.0) != 0.0:
        text = "is of a pair that looks square at what it sees, but pitch_deg is not 0; leave one of them out"
        yield "vehicle", "camera_baseline_m", text


def _snr_faults(wanted: Values) -> Iterator[tuple[str, str, str]]:
    if wanted.get("min_snr") is not None and wanted.get("min_snr_db") is not None:
        yield "requirements", "min_snr", "and min_snr_db are both given; keep one of them"
    if wanted.get("min_snr_red_db") is not None and wanted.get("colour") == "mono":
        text = "is asked of a mono sensor, which has no red channel; set colour: colour, or leave it out"
        yield "requirements", "min_snr_red_db", text


def _less_faults(common: Values, scenes: Sequence[Values]) -> Iterator[Fault]:
    """Less SNR at pixels where every scene asks of the mean; one that overrides `snr_at` leaves it to the others."""
    text = "is less at pixels than in the mean, but snr_at is mean; set snr_at: worst, or leave it out"
    own = [scene.get("requirements") or {} for scene in scenes]
    of_mean = [overridden(common, one).get("snr_at", "mean") == "mean" for one in own]
    if common.get("snr_at_less_db") and common.get("snr_at", "mean") == "mean" and all(of_mean):
        yield ("requirements", "snr_at_less_db"), text
    for index, (one, is_mean) in enumerate(zip(own, of_mean, strict=True)):
        if one.get("snr_at_less_db") and is_mean:
            yield ("scenes", index, "requirements", "snr_at_less_db"), text


def _rate_faults(vehicle: Values, wanted: Values, target: str) -> Iterator[tuple[str, str, str]]:
    if target == "mid_water" and wanted.get("frame_interval_s") is None:
        text = "is missing; in mid_water no overlap sets the frame rate: give the longest time between images"
        yield "requirements", "frame_interval_s", text
    elif (
        vehicle.get("speed_m_s") == 0
        and wanted.get("frame_interval_s") is None
        and wanted.get("overlap") is None
    ):
        text = "= 0 leaves the frame rate open; add requirements.frame_interval_s, the seconds between images"
        yield "vehicle", "speed_m_s", text


def _hardware_faults(scene: Values, index: int) -> Iterator[Fault]:
    for key in HARDWARE_KEYS:
        if key in (scene.get("vehicle") or {}):
            text = "cannot differ from scene to scene: the hardware is common to all; move it to vehicle"
            yield ("scenes", index, "vehicle", key), text
    for key in WHOLE_MISSION_KEYS:
        if key in (scene.get("vehicle") or {}):
            text = "is of the whole mission, not of one scene; move it to vehicle, and give the scene a time_share"
            yield ("scenes", index, "vehicle", key), text


def _clarity_faults(scene: Values, index: int) -> Iterator[Fault]:
    given = [key for key in CLARITY_KEYS if scene.get(key) is not None]
    for key in given[1:]:
        text = f"and {given[0]} are both given; keep {given[0]}, which is known better"
        yield ("scenes", index, key), text
    water = scene.get("water")
    if given and isinstance(water, str) and water.casefold().endswith(".csv"):
        text = f"= {water!r} says all of this water; leave out {given[0]}, or name a Jerlov type for its colour"
        yield ("scenes", index, "water"), text


def _rating_faults(limits: Values, scene: Values, vehicle: Values) -> Iterator[Fault]:
    rating_m, depth_m = limits.get("depth_rating_m"), scene.get("depth_m")
    altitude_m = vehicle.get("altitude_m")
    level = (scene.get("target") or "floor") != "floor"
    if rating_m is None or depth_m is None or altitude_m is None:
        return
    works_at_m, why = (depth_m, "") if level else (depth_m - altitude_m, " (depth_m less altitude_m)")
    if rating_m < works_at_m:
        text = f"= {rating_m:g} is less than the {works_at_m:g} m at which the camera works{why}"
        yield ("limits", "depth_rating_m"), f"{text}; raise it or leave it out"


def _name_faults(scenes: Sequence[Values]) -> Iterator[Fault]:
    seen: dict[str, int] = {}
    for index, scene in enumerate(scenes):
        name = scene.get("name")
        if name in seen:
            text = f"= {name!r} is the name of scenes[{seen[name]}] too; give each scene its own"
            yield ("scenes", index, "name"), text
        elif name is not None:
            seen[name] = index


def _share_faults(scenes: Sequence[Values]) -> Iterator[Fault]:
    shares = [scene.get("time_share") for scene in scenes]
    total, complete = sum(s for s in shares if s is not None), None not in shares
    if total > 1.005 or (complete and total < 0.995):
        index = max(i for i, share in enumerate(shares) if share is not None)
        text = f"= {shares[index]:g} makes all shares sum to {total:g}; they are shares of one whole"
        yield ("scenes", index, "time_share"), text


def time_shares(given: Sequence[float | None]) -> tuple[float, ...]:
    """Shares that sum to 1; those not given divide the rest equally."""
    total, n_open = sum(s for s in given if s is not None), given.count(None)
    rest = max(0.0, 1.0 - total) / n_open if n_open else 0.0
    shares = [rest if s is None else s for s in given]
    whole = sum(shares) or 1.0
    return tuple(share / whole for share in shares)


def _duration_faults(vehicle: Values, limits: Values) -> Iterator[Fault]:
    for key in ("energy_wh", "storage_gb"):
        if limits.get(key) is not None and vehicle.get("duration_h") is None:
            text = "is counted over the mission's time; add vehicle.duration_h, the hours that it takes"
            yield ("limits", key), text


def _battery_faults(vehicle: Values) -> Iterator[Fault]:
    if vehicle.get("supply") == "battery" and vehicle.get("battery_wh") is None:
        yield ("vehicle", "supply"), "= battery needs the energy that it holds; add vehicle.battery_wh"


def _housing_faults(limits: Values, catalog: Values) -> Iterator[Fault]:
    for key in ("size_mm", "diameter_mm", "mass_water_kg"):
        if limits.get(key) is not None and catalog.get("housing", "none") == "none":
            yield ("limits", key), "is of the housing; add catalog.housing: required, or leave it out"


def _currency_faults(limits: Values) -> Iterator[Fault]:
    currency = limits.get("currency") or "USD"
    own = limits.get("rates") or {}
    if currency == "USD" or currency in own:
        return
    from uwopt.catalog.money import known_rates

    known: Iterable[str] = known_rates()
    if currency not in known:
        text = f"= {currency!r} has no exchange rate; known are {', '.join(sorted(known))}"
        yield ("limits", "currency"), f"{text}, or add limits.rates: {{{currency}: USD per unit}}"


def valid_values(model: type[BaseModel], raw: Any) -> dict[str, Any]:
    """The keys of a section that are right on their own."""
    if not isinstance(raw, Mapping):
        return {}
    kept = dict(raw)
    for _ in range(2):
        try:
            return given_values(model.model_validate(kept))
        except ValidationError as error:
            wrong = {detail["loc"][0] for detail in error.errors(include_url=False) if detail["loc"]}
            kept = {key: value for key, value in kept.items() if key not in wrong}
    return {}
