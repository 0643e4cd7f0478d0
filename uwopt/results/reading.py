"""Result files read back, and held against the layout that they name: no fault shows only half-way down a page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from uwopt.documents.faults import path_text
from uwopt.documents.files import UnfitFileError, content
from uwopt.errors import ResultError
from uwopt.results.front import FRONT_SCHEMA, FrontResult
from uwopt.results.result import RESULT_SCHEMA, Result

MOST_FAULTS = 8
AGAIN = "write it again with --out"


EITHER, SOLVED = ("result.json", "front.json"), ("result.json",)  # names of files that a command takes


def read_result(path: str | Path, names: tuple[str, ...] = EITHER) -> Result | FrontResult:
    """The result or front in a file; raises ResultError with what is wrong and a way out."""
    data = read_json(path, names)
    schema = data.get("schema")
    if schema not in (RESULT_SCHEMA, FRONT_SCHEMA):
        raise ResultError(f"{path}: {other_schema(schema, names)}")
    kind: type[Result] | type[FrontResult] = Result if schema == RESULT_SCHEMA else FrontResult
    try:
        result = kind.from_dict(data)
        faults = front_faults(result) if isinstance(result, FrontResult) else []
    except ValidationError as error:
        faults = [fault_sentence(detail) for detail in error.errors(include_url=False)]
    if faults:
        more = len(faults) - MOST_FAULTS
        shown = faults[:MOST_FAULTS] + ([f"and {more} more"] if more > 0 else [])
        raise ResultError([f"{path}: {fault}" for fault in shown] + [f"{path}: changed by hand? {AGAIN}."])
    return result


def read_solved(path: str | Path) -> Result:
    """The result of solve or evaluate in a file; a front is refused."""
    result = read_result(path, SOLVED)
    if isinstance(result, FrontResult):
        raise ResultError(f"{path}: is a front of many systems; solve for one of them and name its result.json.")
    return result


def read_json(path: str | Path, names: tuple[str, ...] = EITHER) -> dict[str, Any]:
    """The JSON object in a file; `names`: of files that are asked for."""
    file, told = Path(path), f"name a {' or '.join(names)}"
    try:
        text = content(file).decode("utf-8-sig")
    except FileNotFoundError:
        raise ResultError(
            f"{path}: no such file; {told} that --out wrote."
        ) from None
    except IsADirectoryError:
        inside = next((name for name in reversed(names) if (file / name).is_file()), "")
        hint = f"name {file / inside}" if inside else told
        raise ResultError(f"{path}: is a folder; {hint}.") from None
    except UnicodeDecodeError:
        raise ResultError(f"{path}: is not text in UTF-8; {told}.") from None
    except UnfitFileError as fault:
        raise ResultError(f"{path}: {fault}; {told}.") from None
    except (OSError, ValueError) as fault:
        raise ResultError(f"{path}: cannot be read ({getattr(fault, 'strerror', None) or fault}).") from None
    if not text.strip():
        raise ResultError(f"{path}: is empty; {AGAIN}.")
    try:
        data = json.loads(text, parse_constant=no_constant)
    except json.JSONDecodeError as fault:
        rest = text[fault.pos :].strip()
        half_a_word = any(word.startswith(rest) for word in ("true", "false", "null", "-"))
        cut = half_a_word or fault.msg.startswith("Unterminated string")
        if not cut and fault.pos == 0:  # another file, such as a mission
            raise ResultError(f"{path}: is not JSON, so it is no result; {told}.") from None
        what = "ends too early, it was cut off" if cut else f"is not JSON ({fault.msg})"
        raise ResultError(f"{path}: line {fault.lineno}: {what}; {AGAIN}.") from None
    except (ValueError, RecursionError) as fault:
        raise ResultError(f"{path}: is not JSON of uwopt ({fault}); {AGAIN}.") from None
    if not isinstance(data, dict):
        raise ResultError(f"{path}: holds no result but {described(data)}; {told}.")
    return data


def no_constant(name: str) -> float:
    """JSON knows no NaN and no Infinity."""
    raise ValueError(f"{name} is no number")


def other_schema(schema: Any, names: tuple[str, ...] = EITHER) -> str:
    """What is wrong with a file of another kind or version."""
    ours = f"{RESULT_SCHEMA} and {FRONT_SCHEMA}"
    if isinstance(schema, str) and schema.partition("/")[0] in ("uwopt.result", "uwopt.front"):
        return f"schema is {schema!r}, this uwopt reads {ours}; read it with the uwopt that wrote it, or solve again."
    what = "has no schema" if schema is None else f"schema is {schema!r}"
    return f"{what}, so it is no result of uwopt (these say {ours}); name a {' or '.join(names)}."


# ---------------------------------------------------------------- faults


def fault_sentence(detail: ErrorDetails, place: tuple[str, ...] = ()) -> str:
    """One fault of a record at a place of a file: where, what stands there, and what should."""
    path, kind = path_text((*place, *detail["loc"])), detail["type"]
    if kind in STANDS_ALONE:
        return f"{path} {STANDS_ALONE[kind]}"
    return f"{path} is {described(detail['input'])}, not {WANTED.get(kind, detail['msg'])}"


STANDS_ALONE = {
    "missing": "is missing",
    "unexpected_keyword_argument": "is not known",
    "too_short": "is empty",
}
WANTED = {
    "float_type": "a number", "int_type": "a whole number", "string_type": "text", "bool_type": "true or false",
    "list_type": "a list", "dict_type": "an object", "dataclass_type": "an object",
}  # fmt: skip


def front_faults(front: FrontResult) -> list[str]:
    """Names in a front that lead nowhere, and parts that are no counts."""
    known = {point.id for point in front.points}
    missing = [
        f"points[{index}].values.{objective.name} is missing"
        for index, point in enumerate(front.points)
        for objective in front.objectives
        if objective.name not in point.values
    ]
    lost = [
        f"picks[{index}].point is {described(pick.point)}, no point of the front"
        for index, pick in enumerate(front.picks)
        if known and pick.point not in known
    ]
    try:
        _ = front.parts_left
        uncounted = list[str]()
    except ValidationError as error:
        place = ("certificate", "parts_left")
        uncounted = [fault_sentence(detail, place) for detail in error.errors(include_url=False)]
    return missing + lost + uncounted


def described(value: Any) -> str:
    """A wrong value in a message: short, with its kind where that says more."""
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "a list"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else text[:37] + "..."
