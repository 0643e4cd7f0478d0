"""What a tab of the page holds: a mission, one to five systems and own files, as plain values of their files.

The server keeps none of it. A control reads one key and writes it back; everything else stays as it was loaded.
"""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

import yaml

from uwopt.catalog.inline import SYNONYMS
from uwopt.documents.yaml_lines import compose
from uwopt.errors import MissionError
from uwopt.explore.controls import BY_ID, FIRST_RECORDS, OWN, PARTS, Control
from uwopt.mission.checks import in_one_form
from uwopt.mission.system import LEVEL_KEYS

#: {"mission": {...}, "systems": [{...}], "shown": 0, "scene": 0, "files": {name: text}}, and of lamps the last "move".
State = dict[str, Any]
MOST_SYSTEMS = 5
PLACE_OF_LAMP = ("x_m", "y_m", "z_m", "tilt_x_deg", "tilt_y_deg")
MOST_FILE_BYTES, MOST_FILES, MOST_ADDRESS = 1_000_000, 10, 60_000
FILE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._ -]{0,63}\.(csv|ies|yaml|yml)\Z", re.IGNORECASE)
FILE_ENDINGS = (".csv", ".ies", ".yaml", ".yml")
#: The window of the founding paper's tool as it opens; problems/paper-tool-window.yaml says where each number is from.
OPENING: State = {
    "mission": {
        "name": "Default window of the paper's tool", "practice": "bare",
        "scenes": [{"water": "I", "water_table": "solonenko-mobley", "seafloor": "benthic-average", "depth_m": 100}],
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 1.0, "orientation": "portrait"},
        "requirements": {"overlap": 0.25, "max_blur_px": 1.0, "min_dof_m": 3.7, "min_snr_db": 20, "max_gsd_mm": 0.87,
                         "min_swath_m": 1.76},
        "objective": "power", "physics": "paper",
    },
    "systems": [{
        "name": "system 1", "camera": "seed-imx250m",
        "lens": {"focal_length_mm": 8, "f_number_min": 1.4, "f_number_max": 16, "transmission_frac": 0.9},
        "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10, "refractive_index": 1.5},
        "light": {"spectrum": "generic-led", "flux_lm": 20000, "power_w": 200, "beam": "disc",
                  "beam_half_angle_deg": 45},
        "light_count": 1, "orientation": "portrait",
        "settings": {"f_number": 4.0, "exposure_ms": 0.86, "gain": 1.0, "flux_lm": 20000},
    }],
    "shown": 0, "scene": 0, "files": {},
}  # fmt: skip


# ---------------------------------------------------------------- controls


def text_of(state: State, control: Control) -> str:
    """What a control shows: the key as its file states it, empty where it does not."""
    if control.is_part:
        part = shown_system(state).get(control.key)
        return OWN if isinstance(part, Mapping) else str(part or "")
    place = place_of(state, control)
    value = None if place is None else place.get(control.key)
    return plain_text(value)


def plain_text(value: Any) -> str:
    """A value as a person types it."""
    if value is None:
        return ""
    if isinstance(value, float) and value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return value if isinstance(value, str) else json.dumps(value)


def shown_system(state: State) -> dict[str, Any]:
    """The system that the controls act on."""
    found: dict[str, Any] = state["systems"][state["shown"]]
    return found


def place_of(state: State, control: Control) -> dict[str, Any] | None:
    """The section that holds a control's key, the scene's own where that has it; None where there is none."""
    if control.file == "mission":
        mission = state["mission"]
        first = mission["scenes"][state["scene"]]
        if control.section == "scene":
            return dict_or_none(first)
        if control.section == "":
            return dict_or_none(mission)
        own = first.get(control.section)
        if isinstance(own, dict) and control.key in own:
            return own
        return dict_or_none(mission.get(control.section))
    system = shown_system(state)
    if control.section == "":
        return system
    if control.section == "settings":
        own = (system.get("scenes") or {}).get(scene_name(state))
        if isinstance(own, dict) and control.key in own:
            return own
    return dict_or_none(system.get(control.section))


def scene_name(state: State) -> str:
    """The scene that the controls act on."""
    return str(state["mission"]["scenes"][state["scene"]].get("name") or f"scene {state['scene'] + 1}")


def dict_or_none(value: Any) -> dict[str, Any] | None:
    """A section that can be written to."""
    return value if isinstance(value, dict) else None


def with_texts(state: State, texts: Mapping[str, str]) -> State:
    """The state after controls were typed in; those that say what they said change nothing."""
    made = deepcopy(state)
    for name, text in texts.items():
        control = BY_ID[name]
        plain = str(text or "").strip()
        if plain == text_of(state, control):
            continue
        if control.is_part:
            set_part(made, control.key, plain)
        elif control.section not in PARTS or text_of(made, BY_ID[f"s-{control.section}"]) == OWN:
            set_key(made, control, plain)
    return made


def set_part(state: State, kind: str, text: str) -> None:
    """A part by its id, or as own numbers."""
    system = shown_system(state)
    system[kind] = {**FIRST_RECORDS[kind]} if text == OWN else text
    for key in ("complete", "housing") if kind != "light" else ():
        system.pop(key, None)


def set_key(state: State, control: Control, text: str) -> None:
    """One key; left empty it is left out."""
    place = place_of(state, control)
    if place is None:
        owner = state["mission"] if control.file == "mission" else shown_system(state)
        owner[control.section] = place = {}
    if control.key in LEVEL_KEYS and control.section == "settings":
        for other in LEVEL_KEYS:
            place.pop(other, None)
    if control.key in ("light_count", "light_baseline_m", "light_tilt_deg"):
        shown_system(state).pop("light_mounts", None)
    if text:
        place[control.key] = typed(text)
    else:
        place.pop(control.key, None)


def with_lamps(state: State, moved: Mapping[str, Any] | None) -> State:
    """The state after lamps were moved on the drawing; a move that it has seen changes nothing."""
    if not moved or moved.get("move") == state.get("move"):
        return state
    made = deepcopy(state)
    system, places = shown_system(made), moved.get("places")
    if not isinstance(places, list) or not all(isinstance(place, Mapping) for place in places):
        raise MissionError("lamps: each needs its place and tilt.")
    for key in ("light_baseline_m", "light_tilt_deg"):
        system.pop(key, None)
    system["light_mounts"] = [{key: place.get(key) for key in PLACE_OF_LAMP} for place in places]
    return {**made, "move": moved.get("move")}


def typed(text: str) -> Any:
    """A number, a list or a word, as YAML would have it; what is none of them stays text, and is told as such."""
    for read in (int, float, json.loads):
        try:
            value = read(text)
        except ValueError:
            continue
        return value
    return text


# ---------------------------------------------------------------- files and addresses


def loaded(text: str, name: str, what: str) -> dict[str, Any]:
    """A mission or system from YAML text; raises MissionError with every fault of its form."""
    if len(text.encode()) > MOST_FILE_BYTES:
        raise MissionError(f"{name}: is larger than {MOST_FILE_BYTES // 1_000_000} MB; a {what} is a file of a few kB.")
    data, _, faults = compose(text, name)
    if faults or not isinstance(data, dict):
        raise MissionError([*faults] or [f"{name}: is not a mapping of keys to values; `uwopt init` writes a {what}."])
    return data


def with_mission(state: State, data: Mapping[str, Any]) -> State:
    """The state with another mission."""
    plain, faults = in_one_form(data)
    if faults:
        raise MissionError([text for _, text in faults])
    if not isinstance(plain.get("scenes"), list) or not plain["scenes"]:
        raise MissionError("mission: scene is missing; load a file as `uwopt init` writes it.")
    for scene in plain["scenes"]:
        if not isinstance(scene, dict):
            raise MissionError("mission: each scene is a section of keys; load a file as `uwopt init` writes it.")
    return {**deepcopy(state), "mission": plain, "scene": 0}


def with_system(state: State, data: Mapping[str, Any]) -> State:
    """The state with another system in the place of the one that is shown."""
    made = deepcopy(state)
    made["systems"][made["shown"]] = in_own_names(data)
    return made


def in_own_names(data: Mapping[str, Any]) -> dict[str, Any]:
    """A system whose own records use the names that the controls have, not their synonyms."""
    made = deepcopy(dict(data))
    for kind in PARTS:
        record = made.get(kind)
        if isinstance(record, Mapping):
            made[kind] = {SYNONYMS[kind].get(key, key): value for key, value in record.items()}
    return made


def with_copy(state: State) -> State:
    """The state with a copy of the shown system behind it, which is then shown."""
    if len(state["systems"]) >= MOST_SYSTEMS:
        raise MissionError(f"{MOST_SYSTEMS} systems stand side by side at most; remove one first.")
    made = deepcopy(state)
    names = [system.get("name") for system in made["systems"]]
    number = next(n for n in range(2, 99) if f"system {n}" not in names)
    made["systems"].append({**deepcopy(shown_system(state)), "name": f"system {number}"})
    return {**made, "shown": len(made["systems"]) - 1}


def without_shown(state: State) -> State:
    """The state without the shown system; the last one stays."""
    if len(state["systems"]) == 1:
        raise MissionError("one system must stay; load another in its place.")
    made = deepcopy(state)
    del made["systems"][made["shown"]]
    return {**made, "shown": max(made["shown"] - 1, 0)}


def with_file(state: State, name: str, text: str) -> State:
    """The state with one more file of own parts or curves."""
    plain = name.strip()
    if not FILE_NAME.match(plain):
        raise MissionError(
            f"{plain[:80]!r} cannot be loaded: a name of letters, digits, . _ and - is wanted that ends in "
            f"{', '.join(FILE_ENDINGS)}."
        )
    if len(text.encode()) > MOST_FILE_BYTES:
        raise MissionError(f"{plain}: is larger than {MOST_FILE_BYTES // 1_000_000} MB; leave out what is not needed.")
    if len({*state["files"], plain}) > MOST_FILES:
        raise MissionError(f"{plain}: {MOST_FILES} files are held at most; reload the page to begin anew.")
    for cell in re.split(r"[,;\"'\t\r\n]", text):
        said = cell.strip()
        if said.casefold().endswith(FILE_ENDINGS) and re.search(r"[/\\]|^~", said) and "://" not in said:
            raise MissionError(
                f"{plain}: names a file in a folder, {said[:60]!r}; load that file too, and name it alone."
            )
    return {**deepcopy(state), "files": {**state["files"], plain: text}}


def named_files(value: Any) -> set[str]:
    """Names of files in a mission or system."""
    if isinstance(value, Mapping):
        listed = value.get("catalog")
        own = set()
        if isinstance(listed, Mapping):
            given = [*(listed.get("files") or ()), listed.get("prices")]
            own = {str(name) for name in given if name is not None}
        return own.union(*(named_files(item) for item in value.values()))
    if isinstance(value, (list, tuple)):
        return set().union(*(named_files(item) for item in value))
    return {value} if isinstance(value, str) and value.strip().casefold().endswith(FILE_ENDINGS) else set()


def address_of(state: State) -> str:
    """The state for an address, own files left out; "" where it would be too long for one."""
    plain = json.dumps({key: state[key] for key in ("mission", "systems", "shown", "scene")}, separators=(",", ":"))
    text = base64.urlsafe_b64encode(zlib.compress(plain.encode(), 9)).decode()
    return text if len(text) <= MOST_ADDRESS else ""


def unpacked(text: str) -> State:
    """A state from an address; raises MissionError where it is none."""
    try:
        stream = zlib.decompressobj()
        plain = stream.decompress(base64.urlsafe_b64decode(text[: MOST_ADDRESS + 4]), MOST_FILE_BYTES)
        data = json.loads(plain)
        made: State = {**with_mission(OPENING, data["mission"]), "systems": [dict(one) for one in data["systems"]]}
        made["shown"], made["scene"] = int(data["shown"]), int(data["scene"])
        inside = 0 <= made["shown"] < len(made["systems"]) <= MOST_SYSTEMS
        if not inside or not 0 <= made["scene"] < len(made["mission"]["scenes"]):
            raise ValueError("shown or scene")
    except (ValueError, KeyError, TypeError, AttributeError, zlib.error) as fault:
        raise MissionError("this address holds no state of the page; it may have been cut off.") from fault
    return made


def yaml_text(data: Mapping[str, Any]) -> str:
    """A mission or system as a file."""
    return yaml.safe_dump(dict(data), sort_keys=False, allow_unicode=True, width=110)
