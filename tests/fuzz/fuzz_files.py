"""Strategies for mission files, system files and tables of own parts: plausible, extreme, and wrong.

Numbers come from the limits that fields and columns themselves state, so that a new key joins by itself: an end of
what is allowed, or a number between, evenly spread in its logarithm. What is wrong is wrong in structure (keys
dropped, misspelt, doubled, misplaced, nested, aliased) or in value (types, units as text, NaN, infinity, size).
"""

from __future__ import annotations

import copy
import json
import math
import os
from functools import partial
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import annotated_types
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from pydantic import AfterValidator
from thorough import drawn

from uwopt.catalog.columns import COLUMNS
from uwopt.catalog.inline import INLINE_MODELS
from uwopt.catalog.parts.cell import LARGEST
from uwopt.catalog.parts.kinds import ALL_FIELDS
from uwopt.documents.key_types import keys_of
from uwopt.mission.checks import HARDWARE_KEYS
from uwopt.mission.keys import JERLOV_TYPES, OBJECTIVES, SEAFLOORS
from uwopt.mission.mission import mission_sections
from uwopt.mission.sections.vehicle import LightMount
from uwopt.mission.system import system_sections

MISSION, SYSTEM = mission_sections(), system_sections()
PHYSICS = ("auto", "full", "paper")
SPANS = {field.name: field.cell.span for field in ALL_FIELDS}
FUZZ = float(os.environ.get("UWOPT_FUZZ", drawn("0.2", "5")))  # times the number of examples
Draw = Any


def examples(count: int) -> Any:
    """Hypothesis's settings for so many examples times UWOPT_FUZZ; without that for fewer, but no fewer than 3.

    They are the same in every run unless UWOPT_FUZZ asks for as many or more.
    """
    alike = FUZZ < 1.0
    return settings(
        max_examples=max(math.ceil(count * FUZZ), min(count, 3)), derandomize=alike, deadline=None, database=None,
        suppress_health_check=list(HealthCheck), print_blob=not alike,
        phases=[phase for phase in Phase if phase is not Phase.shrink],
    )  # fmt: skip


# ---------------------------------------------------------------- values that are allowed


def between(low: float, high: float) -> st.SearchStrategy[float]:
    """The ends, and numbers evenly spread: in their logarithm, or plainly where zero lies within."""
    ends = st.sampled_from([low, high])
    if low < 0:
        return ends | st.floats(low, high) | st.just(0.0)
    least = math.log(low) if low > 0 else -20.0
    spread = st.floats(least, max(math.log(high), least))
    return ends | spread.map(lambda v: min(max(math.exp(v), low), high))


def numbers(metadata: Any, *, whole: bool, name: str) -> st.SearchStrategy[Any]:
    """Numbers within the limits of a field and, of parts, of what can be made."""
    low, high = -1e12, 1e12
    for item in metadata:
        for found in getattr(item, "metadata", (item,)):
            if isinstance(found, annotated_types.Ge):
                low = max(low, found.ge)
            elif isinstance(found, annotated_types.Gt):
                low = max(low, found.gt + 1e-9)
            elif isinstance(found, AfterValidator) and isinstance(found.func, partial):  # `at_least`
                low = max(low, found.func.keywords["low"])
            elif isinstance(found, annotated_types.Le):
                high = min(high, found.le)
            elif isinstance(found, annotated_types.Lt):
                high = min(high, found.lt - 1e-9)
    least, most = SPANS.get(name, (low, high))
    low, high = max(low, least) if low > 0 else low, min(high, most)
    return st.integers(math.ceil(low), int(min(high, 1e6))) if whole else between(float(low), float(high))


def allowed(annotation: Any, metadata: Any = (), name: str = "") -> st.SearchStrategy[Any] | None:
    """Values that a field of this type takes; None where no rule here knows."""
    if hasattr(annotation, "__metadata__"):
        return allowed(annotation.__origin__, (*annotation.__metadata__, *metadata), name)
    origin = get_origin(annotation)
    if origin is Literal:
        return st.sampled_from(get_args(annotation))
    if annotation in (float, int):
        return numbers(metadata, whole=annotation is int, name=name)
    if origin is None or origin in (list, tuple, dict):
        return None
    known = [found for item in get_args(annotation) if (found := allowed(item, metadata, name)) is not None]
    return st.one_of(known) if known else None


def extremes(model: Any) -> dict[str, st.SearchStrategy[Any]]:
    """By key of a section: values at and within its limits."""
    found = {key: allowed(info.annotation, tuple(info.metadata), key) for key, info in keys_of(model).items()}
    return {key: strategy for key, strategy in found.items() if strategy is not None}


ODD: dict[str, dict[str, st.SearchStrategy[Any]]] = {
    "practice": "bare", "": {"objective": st.sampled_from(OBJECTIVES) | st.dictionaries(
        st.sampled_from([name for name in OBJECTIVES if name != "information"]), between(1e-6, 1e6), min_size=1)},
    "vehicle": {
        "light_count": st.integers(1, 3) | st.sampled_from([[1, 2], [2, 3]]),
        "light_baseline_m": between(0.0, 20.0) | st.just([0.4, 0.45]),
        "light_tilt_deg": st.floats(-89.0, 89.0) | st.just([0.0, 2.5]),
        "light_mounts": st.lists(st.fixed_dictionaries({}, optional=extremes(LightMount)), min_size=1, max_size=3),
        "camera_count": st.integers(1, 3),
    },
    "scene": {
        "water": st.sampled_from(JERLOV_TYPES),
        "seafloor": st.sampled_from(SEAFLOORS) | between(0.0, 1.0),
        "depth_m": between(0.0, 11000.0) | st.just(50.0),
        "sun_lux": st.just(0.0) | between(0.0, 2e5),
    },
}  # fmt: skip
KNOWN = {name: {**extremes(model), **ODD.get(name, {})} for name, model in MISSION.items()}
KNOWN["scene"].pop("time_share")

# ---------------------------------------------------------------- missions


def plain_mission() -> dict[str, Any]:
    """A mission that many systems can serve."""
    return {
        "practice": "bare", "name": "fuzz", "objective": "power", "physics": "full",
        "scene": {"water": "II", "seafloor": 0.2, "depth_m": 50.0},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "light_count": [1, 2]},
        "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "min_snr": 3.0}, "limits": {},
    }  # fmt: skip


PLACES = [
    (section, key) for section in ("scene", "vehicle", "requirements", "limits", "") for key in KNOWN[section]
]


@st.composite
def missions(draw: Draw, most: int = 4, waters: tuple[str, ...] = ()) -> dict[str, Any]:
    """A plausible mission with up to a few values at or within their limits; sometimes of two scenes."""
    made = plain_mission()
    made["physics"] = draw(st.sampled_from(PHYSICS))
    for section, key in draw(st.lists(st.sampled_from(PLACES), max_size=most, unique=True)):
        place = made[section] if section else made
        place[key] = draw(KNOWN[section][key])
    if waters and draw(st.integers(0, 3)) == 0:
        made["scene"]["water"] = draw(st.sampled_from(waters))
    if made["requirements"].get("min_snr_db") is not None:
        made["requirements"].pop("min_snr", None)
    if "light_mounts" in made["vehicle"]:
        made["vehicle"].pop("light_count", None)
    if draw(st.integers(0, 4)) == 0:
        made["scenes"] = [
            made.pop("scene"),
            {"name": "b", "water": "III", "seafloor": "sand", "depth_m": 40.0},
        ]
        for section in draw(st.lists(st.sampled_from(["scene", "vehicle", "requirements"]), max_size=2)):
            key = draw(st.sampled_from([k for k in KNOWN[section] if k not in HARDWARE_KEYS]))
            made["scenes"][1][key] = draw(KNOWN[section][key])
    return made


# ---------------------------------------------------------------- systems


PLAIN_PARTS: dict[str, dict[str, Any]] = {
    "camera": {
        "resolution_x_px": 1600, "resolution_y_px": 1200, "pixel_pitch_um": 4.5, "read_noise_e": 6,
        "saturation_e": 20000, "bit_depth": 12, "quantum_efficiency": 0.6,
    },
    "lens": {"focal_length_mm": 8, "f_number_min": 1.8, "f_number_max": 16, "transmission": 0.9},
    "port": {"geometry": "flat", "thickness_mm": 10, "gap_mm": 5},
    "light": {"flux_lm": 12000, "power_w": 120, "beam": "cosine-power", "beam_half_angle_deg": 40},
}  # fmt: skip
PORTS: tuple[dict[str, Any], ...] = (
    PLAIN_PARTS["port"], {"geometry": "dome", "outer_radius_mm": 80, "thickness_mm": 10, "refractive_index": 1.5}
)  # fmt: skip
LIGHTS: tuple[dict[str, Any], ...] = (
    PLAIN_PARTS["light"],
    {"kind": "pulsed_led", "flux_lm": 30000, "power_w": 300, "beam": "disc", "beam_angle_deg": 80, "min_pulse_us": 10,
     "max_pulse_us": 5000, "max_duty_frac": 0.5, "max_rate_hz": 30},
    {"kind": "flash", "flash_energy_j": 20, "flash_duration_us": 500, "recycle_s": 0.1, "beam_half_angle_deg": 45},
)  # fmt: skip
INLINE = {kind: extremes(model) for kind, model in INLINE_MODELS.items()}
INLINE["camera"] |= {"resolution_x_px": st.sampled_from([1, 2, 640, 100_000]), "resolution_y_px": st.sampled_from(
    [1, 2, 480, 100_000]), "quantum_efficiency": between(1e-9, 1.0) | st.just("imx264c-filled")}  # fmt: skip
INLINE["light"]["dim_levels"] = st.sampled_from([[1.0], [0.1, 1.0], [1e-9, 1.0], [0.5]])
SETTINGS = extremes(SYSTEM["settings"])


@st.composite
def systems(draw: Draw, most: int = 4) -> dict[str, Any]:
    """A system of inline parts with up to a few values at or within their limits."""
    made: dict[str, Any] = {kind: dict(part) for kind, part in PLAIN_PARTS.items()}
    made["port"], made["light"] = dict(draw(st.sampled_from(PORTS))), dict(draw(st.sampled_from(LIGHTS)))
    made |= {
        "light_count": draw(st.integers(1, 3)),
        "orientation": draw(st.sampled_from(["landscape", "portrait"])),
    }
    made["settings"] = {"f_number": 4.0, "exposure_ms": 1.0}
    places = [(kind, key) for kind in PLAIN_PARTS for key in INLINE[kind]] + [
        ("settings", key) for key in SETTINGS
    ]
    for section, key in draw(st.lists(st.sampled_from(places), max_size=most, unique=True)):
        made[section][key] = draw((SETTINGS if section == "settings" else INLINE[section])[key])
    return made


# ---------------------------------------------------------------- tables of own parts


ROWS: dict[str, dict[str, Any]] = {
    "camera": {"id": "own-cam", "resolution_x_px": 1600, "resolution_y_px": 1200, "pixel_pitch_um": 4.5, "mounts": "C",
               "shutter": "global", "colour": "mono", "bit_depth": 12, "read_noise_e": 6, "saturation_e": 20000,
               "qe": 0.6, "qe_nm": 525, "max_frame_rate_hz": 30, "power_w": 3, "mass_g": 60, "price": 900},
    "lens": {"id": "own-lens", "focal_length_mm": 8, "f_number_min": 1.8, "f_number_max": 16, "image_circle_mm": 11,
             "mounts": "C", "mass_g": 80, "price": 300},
    "port": {"id": "own-port", "geometry": "dome", "outer_radius_mm": 80, "thickness_mm": 8, "refractive_index": 1.5,
             "depth_rating_m": 500, "mass_g": 500, "price": 400},
    "light": {"id": "own-light", "kind": "continuous", "flux_lm": 12000, "power_w": 120, "beam_angle_deg": 80,
              "beam_medium": "water", "depth_rating_m": 500, "mass_g": 700, "price": 500},
}  # fmt: skip


def cells(kind: str) -> dict[str, st.SearchStrategy[Any]]:
    """By column: values at and within its limits; of an open limit up to 1e12."""
    found: dict[str, st.SearchStrategy[Any]] = {}
    for name, column in COLUMNS[kind].items():  # type: ignore[index]
        if column.form == "number":
            (least, most), within = column.span, column.within
            low, high = max(within.low, -LARGEST), min(within.high, most)
            low = max(low, least) if within.open_low else low
            found[name] = (
                st.integers(math.ceil(low), int(min(high, 1e6))) if column.whole else between(low, high)
            )
        elif column.form in ("choice", "list") and column.choices and name != "part":
            found[name] = st.sampled_from(column.choices)
    found.pop("availability")
    return found


CELLS = {kind: cells(kind) for kind in ROWS}
CELLS["camera"] |= {"resolution_x_px": st.sampled_from([1, 640, 100_000]), "resolution_y_px": st.sampled_from(
    [1, 480, 100_000])}  # fmt: skip
CELLS["light"] |= {"dim_levels": st.sampled_from(["none", "continuous", "1|0.5|0.25", "1|1e-9"])}
OTHER_LIGHTS: tuple[dict[str, Any], ...] = (
    {}, {"kind": "pulsed_led", "min_pulse_us": 10, "max_pulse_us": 5000, "max_duty_frac": 0.5},
    {"kind": "flash", "flux_lm": "", "flash_energy_j": 20, "flash_duration_us": 500, "recycle_s": 0.1},
)  # fmt: skip


@st.composite
def own_parts(draw: Draw, most: int = 3) -> dict[str, list[dict[str, Any]]]:
    """A table a kind, of one or two parts, with up to a few cells at or within their limits."""
    made: dict[str, list[dict[str, Any]]] = {}
    for kind, row in ROWS.items():
        made[kind] = [{**row, "id": f"{row['id']}-{n}"} for n in range(draw(st.integers(1, 2)))]
    for row in made["light"]:
        row |= draw(st.sampled_from(OTHER_LIGHTS))
    places = [(kind, name) for kind in ROWS for name in CELLS[kind]]
    for kind, name in draw(st.lists(st.sampled_from(places), max_size=most, unique=True)):
        row = draw(st.sampled_from(made[kind]))
        row[name] = draw(CELLS[kind][name])
    return made


def write_parts(folder: Path, parts: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """Files of own parts, and the section `catalog` of a mission that takes nothing else."""
    for kind, rows in parts.items():
        header = list(dict.fromkeys(name for row in rows for name in row))
        lines = [",".join(header), *(",".join(str(row.get(name, "")) for name in header) for row in rows)]
        (folder / f"{kind}s.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")
    return {
        "files": [f"{kind}s.csv" for kind in parts], "cameras": ["own-*"], "lenses": ["own-*"], "ports": ["own-*"],
        "lights": ["own-*"], "generic": "never",
    }  # fmt: skip


# ---------------------------------------------------------------- what is wrong


HOSTILE = [
    None, True, False, "", " ", "x", "2 m", "2,5", "1e400", "nan", "-inf", math.nan, math.inf, -math.inf, -1, 0, -0.0,
    1e-300, 5e-324, 1e300, -1e300, 2**63, 10**400, "é→😀", "a\u0000b", "\u202e", "x" * 400, [], {}, [1, 2, 3], [5, 1],
    [[]], {"a": 1}, {"": 1}, [None], "no", "1:30", "0x10", "2026-01-01", "~", "../../etc/passwd", "missing.csv", "*a",
    "!!python/object:x", "{", "%",
]  # fmt: skip
KEYS = [
    "altitude",
    "altitude_cm",
    "snr",
    "Speed_m_s",
    "scene",
    "vehicle",
    "water",
    "<<",
    "",
    " ",
    "é",
    "1",
    "null",
]


@st.composite
def broken(draw: Draw, whole: Draw, most: int = 3) -> Any:
    """Plain values with something wrong in them."""
    made = copy.deepcopy(draw(whole))
    for _ in range(draw(st.integers(1, most))):
        places = list(everywhere(made))
        holder, key = draw(st.sampled_from(places))
        deed = draw(
            st.sampled_from(["value", "value", "value", "drop", "rename", "wrap", "add", "move", "nest"])
        )
        if deed == "value":
            holder[key] = copy.deepcopy(draw(st.sampled_from(HOSTILE)))
        elif deed == "wrap":
            holder[key] = [holder[key]]
        elif deed == "nest":
            for _ in range(draw(st.sampled_from([1, 30]))):
                holder[key] = {"a": holder[key]}
        elif deed == "drop":
            del holder[key]
        elif isinstance(holder, dict):
            value = holder[key]
            if deed == "rename":
                del holder[key]
                holder[key[:-1] + "x" if key else "x"] = value
            elif deed == "add":
                holder[draw(st.sampled_from(KEYS))] = draw(st.sampled_from([1, "x", {}, []]))
            else:
                made[key] = value
    return made


def everywhere(value: Any) -> Any:
    """Every (container, key) of nested plain values."""
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from everywhere(value[key])


DEEDS = ["", "", "", "double", "cut", "alias", "tab", "garble", "document", "merge", "tag", "bom"]


@st.composite
def texts(draw: Draw, whole: Draw) -> bytes:
    """A file's bytes: YAML of plain values, sometimes with lines doubled, cut, aliased, tabbed or garbled."""
    lines = yaml_lines(draw(whole))
    deed = draw(st.sampled_from(DEEDS))
    at = draw(st.integers(0, max(len(lines) - 1, 0)))
    if deed == "double" and lines:
        lines.insert(at, lines[at])
    elif deed == "alias":
        lines = ["here: &a {x: 1}" if draw(st.booleans()) else "here: &a [*a]", *lines, "there: *a"]
    elif deed == "merge":
        lines = ["base: &b {altitude_m: 3}", *lines, "<<: *b"]
    elif deed == "tab" and lines:
        lines[at] = "\t" + lines[at]
    elif deed == "document":
        lines.insert(at, "---")
    elif deed == "tag" and lines:
        lines[at] = lines[at].replace(": ", ": !!int ", 1)
    raw = "\n".join([*lines, ""]).encode("utf-8", "surrogatepass")
    if deed == "bom":
        return b"\xef\xbb\xbf" + raw
    if deed == "cut":
        return raw[: draw(st.integers(0, len(raw)))]
    if deed == "garble":
        place, junk = draw(st.integers(0, len(raw))), draw(st.binary(max_size=4))
        return raw[:place] + junk + raw[place + len(junk) :]
    return raw


def yaml_lines(value: Any, indent: int = 0) -> list[str]:
    """YAML in block form, its scalars as JSON, its numbers as Python writes them."""
    pad = "  " * indent
    if not isinstance(value, dict) or not value:
        return [pad + flow(value)]
    lines = []
    for key, item in value.items():
        name = key if key.replace("_", "").isalnum() and key.isascii() else json.dumps(key)
        if isinstance(item, dict) and item and indent < 30:
            lines += [f"{pad}{name}:", *yaml_lines(item, indent + 1)]
        else:
            lines.append(f"{pad}{name}: {flow(item)}")
    return lines


def flow(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return (
        json.dumps(value, ensure_ascii=False)
        if not isinstance(value, int) or value in (True, False)
        else str(value)
    )
