"""Result files read back, and held against the layout that they name: no fault shows only half-way down a page."""

from __future__ import annotations

import json
import types
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, Union, get_args, get_origin, get_type_hints

from uwopt.documents.files import UnfitFileError, content
from uwopt.errors import ResultError
from uwopt.results.front import FRONT_SCHEMA, FrontResult
from uwopt.results.result import RESULT_SCHEMA, Design, Result

MOST_FAULTS = 8
AGAIN = "write it again with --out"
#: What the reports need of the parts of a design that are plain dictionaries: type by key, "?" where it may be null.
NEEDED: Mapping[str, Mapping[str, str]] = {
    "hardware": {"camera": "part", "lens": "part", "port": "part", "light": "part", "light_count": "count",
                 "camera_count": "count", "light_mounts": "mounts?"},
    "part": {"id": "text?", "name": "text?"},
    "mount": {"x_m": "number", "y_m": "number", "z_m": "number", "tilt_x_deg": "number", "tilt_y_deg": "number"},
    "totals": {"cost": "cost", "power_w": "number?"},
    "cost": {"value": "number?", "low": "number?", "high": "number?", "estimated": "number?"},
    "bom": {"count": "count", "owned": "count?", "unit_price": "number?", "unit_price_low": "number?",
            "unit_price_high": "number?"},
}  # fmt: skip


def read_result(path: str | Path) -> Result | FrontResult:
    """The result or front in a file; raises ResultError with what is wrong and a way out."""
    data = read_json(path)
    schema = data.get("schema")
    if schema not in (RESULT_SCHEMA, FRONT_SCHEMA):
        raise ResultError(f"{path}: {other_schema(schema)}")
    kind: type[Result] | type[FrontResult] = Result if schema == RESULT_SCHEMA else FrontResult
    faults = list(faults_of(kind, data, "", strict=False))
    why = data.get("infeasible")
    miss = why.get("nearest_miss") if isinstance(why, dict) else None
    if miss is not None:
        faults += faults_of(Design, miss, "infeasible.nearest_miss")
    if schema == FRONT_SCHEMA and not faults:
        faults += front_faults(data)
    if faults:
        more = len(faults) - MOST_FAULTS
        shown = faults[:MOST_FAULTS] + ([f"and {more} more"] if more > 0 else [])
        raise ResultError([f"{path}: {fault}" for fault in shown] + [f"{path}: changed by hand? {AGAIN}."])
    return kind.from_dict(data)


def read_json(path: str | Path) -> dict[str, Any]:
    """The JSON object in a file."""
    file = Path(path)
    try:
        text = content(file).decode("utf-8-sig")
    except FileNotFoundError:
        raise ResultError(
            f"{path}: no such file; name a result.json or front.json that --out wrote."
        ) from None
    except IsADirectoryError:
        inside = next((name for name in ("front.json", "result.json") if (file / name).is_file()), "")
        hint = f"name {file / inside}" if inside else "name a result.json or front.json"
        raise ResultError(f"{path}: is a folder; {hint}.") from None
    except UnicodeDecodeError:
        raise ResultError(f"{path}: is not text in UTF-8; name a result.json or front.json.") from None
    except UnfitFileError as fault:
        raise ResultError(f"{path}: {fault}; name a result.json or front.json.") from None
    except (OSError, ValueError) as fault:
        raise ResultError(f"{path}: cannot be read ({getattr(fault, 'strerror', None) or fault}).") from None
    if not text.strip():
        raise ResultError(f"{path}: is empty; {AGAIN}.")
    try:
        data = json.loads(text, parse_constant=no_constant)
    except json.JSONDecodeError as fault:
        cut = fault.pos >= len(text.rstrip()) or fault.msg.startswith("Unterminated string")
        what = "ends too early, it was cut off" if cut else f"is not JSON ({fault.msg})"
        raise ResultError(f"{path}: line {fault.lineno}: {what}; {AGAIN}.") from None
    except (ValueError, RecursionError) as fault:
        raise ResultError(f"{path}: is not JSON of uwopt ({fault}); {AGAIN}.") from None
    if not isinstance(data, dict):
        raise ResultError(f"{path}: holds no result but {described(data)}; name a result.json or front.json.")
    return data


def no_constant(name: str) -> float:
    """JSON knows no NaN and no Infinity."""
    raise ValueError(f"{name} is no number")


def other_schema(schema: Any) -> str:
    """What is wrong with a file of another kind or version."""
    ours = f"{RESULT_SCHEMA} and {FRONT_SCHEMA}"
    if isinstance(schema, str) and schema.partition("/")[0] in ("uwopt.result", "uwopt.front"):
        return f"schema is {schema!r}, this uwopt reads {ours}; read it with the uwopt that wrote it, or solve again."
    what = "has no schema" if schema is None else f"schema is {schema!r}"
    return f"{what}, so it is no result of uwopt (these say {ours}); name a result.json or front.json."


# ---------------------------------------------------------------- types


def faults_of(kind: Any, data: Any, path: str, *, strict: bool = True) -> Iterator[str]:
    """What in plain values does not fit a record's fields; unknown keys are faults where `strict`."""
    if not isinstance(data, dict):
        yield f"{path} is {described(data)}, not an object"
        return
    hints, known = layout_of(kind)
    if strict:
        yield from (f"{dotted(path, key)} is not known" for key in data if key not in known)
    for name, field in known.items():
        if name in data:
            yield from value_faults(hints[name], data[name], dotted(path, name))
        elif field.default is MISSING and field.default_factory is MISSING:
            yield f"{dotted(path, name)} is missing"
    if kind is Design:
        yield from design_faults(data, path)


@cache
def layout_of(kind: Any) -> tuple[dict[str, Any], dict[str, Field[Any]]]:
    """Types and fields of a record."""
    return get_type_hints(kind), {f.name: f for f in fields(kind)}


def value_faults(hint: Any, value: Any, path: str) -> Iterator[str]:
    """What does not fit a type: numbers, texts, lists, dictionaries, records, and either of several."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        if value is None and type(None) in inner:
            return
        yield from value_faults(next(item for item in inner if item is not type(None)), value, path)
    elif is_dataclass(hint):
        yield from faults_of(hint, value, path)
    elif origin is list:
        if not isinstance(value, list):
            yield f"{path} is {described(value)}, not a list"
            return
        for index, item in enumerate(value):
            yield from value_faults(inner[0], item, f"{path}[{index}]")
    elif origin is dict or hint is dict:
        if not isinstance(value, dict):
            yield f"{path} is {described(value)}, not an object"
            return
        for key, item in value.items():
            yield from value_faults(inner[1], item, dotted(path, key))
    elif hint is not Any and not fits(hint, value):
        yield f"{path} is {described(value)}, not {NAMES.get(hint, hint)}"


NAMES = {float: "a number", int: "a whole number", str: "text", bool: "true or false"}


def fits(hint: Any, value: Any) -> bool:
    """Whether a plain value is of a plain type; whole numbers are numbers, true and false are not."""
    if hint in (float, int):
        return isinstance(value, int if hint is int else (int, float)) and not isinstance(value, bool)
    return isinstance(value, hint)


def design_faults(data: Mapping[str, Any], path: str) -> Iterator[str]:
    """What the dictionaries of a design lack."""
    for key in ("hardware", "totals"):
        yield from needed_faults(key, data.get(key), dotted(path, key))
    rows = data.get("bom")
    for index, row in enumerate(rows if isinstance(rows, list) else []):
        yield from needed_faults("bom", row, f"{dotted(path, 'bom')}[{index}]")
    if not data.get("scenes"):
        yield f"{dotted(path, 'scenes')} is empty"


def front_faults(data: Mapping[str, Any]) -> Iterator[str]:
    """Names in a front that lead nowhere."""
    names = [item["name"] for item in data["objectives"]]
    points = data.get("points") or []
    known = {point["id"] for point in points}
    for index, point in enumerate(points):
        missing = [name for name in names if name not in point["values"]]
        yield from (f"points[{index}].values.{name} is missing" for name in missing)
    for index, pick in enumerate(data.get("picks") or []):
        if points and pick["point"] not in known:
            yield f"picks[{index}].point is {described(pick['point'])}, no point of the front"


def needed_faults(kind: str, data: Any, path: str) -> Iterator[str]:
    """What one of the dictionaries in NEEDED lacks."""
    if not isinstance(data, dict):
        yield f"{path} is {described(data)}, not an object"
        return
    for key, wanted in NEEDED[kind].items():
        value, name, here = data.get(key), wanted.rstrip("?"), dotted(path, key)
        if value is None:
            if not wanted.endswith("?"):
                yield f"{here} is missing"
        elif name in NEEDED:
            yield from needed_faults(name, value, here)
        elif name == "mounts":
            yield from value_faults(list[dict[str, Any]], value, here)
            for index, item in enumerate(value if isinstance(value, list) else []):
                yield from needed_faults("mount", item, f"{here}[{index}]")
        else:
            hint = {"text": str, "number": float, "count": int}[name]
            yield from value_faults(hint, value, here)


def dotted(path: str, key: str) -> str:
    """`recommendation.hardware`; without a dot at the top."""
    return f"{path}.{key}" if path else str(key)


def described(value: Any) -> str:
    """A wrong value in a message: short, with its kind where that says more."""
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "a list"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else text[:37] + "..."
