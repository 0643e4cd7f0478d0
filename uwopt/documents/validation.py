"""From pydantic's errors to sentences that name file, line, key, value, what is allowed and a way out."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from uwopt.documents.faults import KeyPath, nearest, path_text, plain_name, show
from uwopt.documents.key_types import FAULT, OUT_OF_REACH, keys_of, spelled_keys
from uwopt.documents.reading import Document
from uwopt.errors import MissionError
from uwopt.units import convert, db_to_ratio, is_number, split_unit

Origin = Callable[[KeyPath], Iterator[KeyPath]]
Sections = Mapping[str, type[BaseModel]]
CrossFault = tuple[KeyPath, str]  # where, and what is wrong there, a whole sentence behind the path
M = TypeVar("M", bound=BaseModel)

_LIMITS = {
    "greater_than": ("gt", "is not above"),
    "greater_than_equal": ("ge", "is below"),
    "less_than": ("lt", "is not below"),
    "less_than_equal": ("le", "is above"),
}
_NOT_MAPPINGS = {"model_type", "model_attributes_type", "dict_type", "mapping_type"}
_NOT_LISTS = {"tuple_type", "list_type", "iterable_type"}


class Reporter:
    """Sentences about one document that a model refused."""

    def __init__(self, model: type[BaseModel], document: Document, sections: Sections, origin: Origin):
        self.model, self.document, self.sections, self.origin = model, document, sections, origin

    def origin_of(self, path: KeyPath) -> KeyPath:
        """The path as the source wrote it (`scene` for `scenes[0]`, an override without its section)."""
        candidates = list(self.origin(path))
        for candidate in candidates:
            if self.document.has(candidate):
                return candidate
        parents = [c for c in candidates if len(c) > 1 and self.document.has(c[:-1])]
        return (parents or candidates)[0]

    def sentence(self, path: KeyPath, rest: str) -> str:
        """One fault: where it stands, the key, and the rest of the sentence."""
        source = self.origin_of(path)
        rest = rest if rest.endswith(("?", ".")) else rest + "."
        return f"{self.document.where(source)}: {path_text(source)} {rest}".replace(":  ", ": ").removeprefix(": ")

    def faults(self, error: ValidationError) -> list[str]:
        """Every fault of a validation, cross checks apart."""
        details = error.errors(include_url=False)
        return [self._fault(dict(detail)) for detail in details if not _is_echo(dict(detail))]

    def _fault(self, detail: dict[str, Any]) -> str:
        path: KeyPath = tuple(s for s in detail["loc"] if not (isinstance(s, str) and s[:1] + s[-1:] == "<>"))
        kind, value, context = detail["type"], detail.get("input"), detail.get("ctx", {})
        if kind == "missing":
            return self.sentence(path, f"is missing; {self._mend(path)}")
        if kind in ("extra_forbidden", "invalid_key"):
            return self.sentence(path, self._unknown(path, value))
        value = self.document.value(self.origin_of(path), value)
        what, mend = self._what(kind, value, context, str(detail.get("msg", "")))
        shown = "" if kind in _NOT_MAPPINGS and not path else f"= {show(value)} "
        return self.sentence(path, f"{shown}{what}; {mend or self._mend(path)}")

    def _what(self, kind: str, value: Any, context: Mapping[str, Any], message: str) -> tuple[str, str]:
        if kind in (FAULT, OUT_OF_REACH):
            return context["what"], context["mend"]
        if kind in _LIMITS:
            name, words = _LIMITS[kind]
            return _beyond(value, context[name], words, is_share=kind[:4] == "less" and context[name] == 1)
        if kind == "literal_error":
            known = re.findall(r"'([^']*)'", context["expected"])
            near = nearest(str(value), known, 0.5) if isinstance(value, str) else None
            return f"is not one of {', '.join(known)}", f"did you mean {near!r}?" if near else ""
        if kind in _NOT_MAPPINGS:
            return "is not a mapping", "write its keys below it, indented, each with a colon"
        if kind in _NOT_LISTS:
            return "is not a list", "write [a, b], or one item a line after a dash"
        if kind == "too_short":
            return "is too short", ""
        return f"is not allowed ({message[:1].lower()}{message[1:]})", ""

    def _mend(self, path: KeyPath) -> str:
        description = describe(self.model, path)
        return f"give the {description}" if description else "see `uwopt schema` for what may stand here"

    def _unknown(self, path: KeyPath, value: Any) -> str:
        key = str(path[-1])
        here = model_at(self.model, path[:-1])
        known = spelled_keys(here) if here else ()
        section = next((name for name, model in self.sections.items() if model is here), "")
        overrides = ("vehicle", "requirements") if section == "scene" else ()
        places = {section: (*known, *(k for name in overrides for k in spelled_keys(self.sections[name])))}
        places |= {n: spelled_keys(m) for n, m in self.sections.items() if n not in places}
        return unknown_key(key, value, section, places)


def _is_echo(detail: Mapping[str, Any]) -> bool:
    """Whether another fault says it better: cross checks stand apart, a list is short of its faulty items."""
    return detail["type"] == "cross_check" or (detail["type"] == "too_short" and bool(detail.get("input")))


def validated(
    model: type[M],
    document: Document,
    data: Mapping[str, Any],
    *,
    sections: Sections,
    origin: Origin,
    cross_faults: Callable[[Mapping[str, Any]], list[CrossFault]],
    early: list[CrossFault] | None = None,
) -> M:
    """The model of a document's data; raises one MissionError with every fault."""
    reporter = Reporter(model, document, sections, origin)
    faults = list(document.faults) + [reporter.sentence(*fault) for fault in early or []]
    made = None
    try:
        made = model.model_validate(data)
    except ValidationError as error:
        faults += reporter.faults(error)
        faults += [reporter.sentence(*fault) for fault in cross_faults(data)]
        if not faults:
            faults = [f"{document.name}: {error.errors(include_url=False)[0]['msg']}"]
    if faults or made is None:
        raise MissionError(sorted(dict.fromkeys(faults), key=_line_of)) from None
    return made


def model_at(model: type[BaseModel], path: KeyPath) -> type[BaseModel] | None:
    """The section that a path leads to, through lists and optional values; None for a plain value."""
    by_name = False  # the step names one of many, as a scene's name does
    for step in path:
        if isinstance(step, int) or by_name:
            by_name = False
            continue
        info = keys_of(model).get(step)
        inner = next(_models_in(info.annotation), None) if info else None
        if info is None or inner is None:
            return None
        model, by_name = inner, get_origin(info.annotation) is dict
    return model


def describe(model: type[BaseModel], path: KeyPath) -> str:
    """Description of the key at a path, or of the nearest key above it."""
    while path and isinstance(path[-1], int):
        path = path[:-1]
    here = model_at(model, path[:-1]) if path else None
    info = keys_of(here).get(str(path[-1])) if here else None
    return (info.description or "") if info else ""


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)


def unknown_key(key: str, value: Any, here: str, places: Mapping[str, tuple[str, ...]]) -> str:
    """Why a key is unknown and where it belongs: another section, another unit, another spelling."""
    if key.isdigit():
        return "is no key; numbers are written without commas, such as 10000 or 0.5"
    if key in places:
        return "is a section of its own here; move it to the left margin" if here else "is unknown here"
    plain = plain_name(key)
    if own := _other_unit(plain, value, places[here]):
        return f"is unknown; the key is {own[0]}{own[1]}"
    if (counted := f"{plain.removesuffix('s')}_count") in places[here] and _is_count(value):
        return f"is unknown; the key is {counted}: write {counted}: {show(value)}"
    for exact in (True, False):
        for name, keys in places.items():
            inside = name == here
            place = "" if inside or not name else f" under {name}"
            if exact and not inside and plain in keys:
                return f"belongs{place or ' at the top level'}; move it there"
            other_unit = None if exact else _other_unit(plain, value, keys)
            if other_unit:
                return f"is unknown; the key is {other_unit[0]}{place}{other_unit[1]}"
    near = nearest(key, places[here])
    if near:
        return f"is unknown; did you mean {near}?"
    for name, keys in places.items():
        near = nearest(key, keys, 0.75)
        if near:
            return f"is unknown; did you mean {near}" + (f" under {name}?" if name not in ("", here) else "?")
    return f"is unknown; known here are {', '.join(sorted(places[here]))}"


def _is_count(value: Any) -> bool:
    """Whether a value is a whole number, or a list of them."""
    values = value if isinstance(value, list) and value else [value]
    return all(isinstance(one, int) and not isinstance(one, bool) for one in values)


def _other_unit(key: str, value: Any, known: tuple[str, ...]) -> tuple[str, str] | None:
    """The known key with the same stem, and the value in its unit."""
    stem, unit = split_unit(key)
    if unit == "db" and stem in known:
        return stem, ", a ratio" + (f": write {stem}: {db_to_ratio(value):.4g}" if is_number(value) else "")
    for name in known:
        right_stem, right_unit = split_unit(name)
        if not right_unit or right_stem != stem or name == key:
            continue
        number = value if is_number(value) else None
        if not unit:
            return (
                name,
                f", with its unit: write {name}: {show(value)}" if number is not None else ", with its unit",
            )
        right = convert(number, unit, right_unit) if number is not None else None
        if right is not None:
            return name, f": write {name}: {right:.6g}"
        if convert(1.0, unit, right_unit) is not None:
            return name, ""
    return None


def _beyond(value: Any, limit: float, words: str, is_share: bool) -> tuple[str, str]:
    if is_share and isinstance(value, (int, float, str)):
        number = float(value)
        right = number / 100.0
        example = f"{right:g} for {number:g}" if 1 < number < 100 else "0.6 for 60 %"
        return f"{words} {limit:g}", f"it is a share 0..1; did you mean {example}?"
    return f"{words} {limit:g}", ""


def _line_of(fault: str) -> tuple[int, int]:
    found = re.match(r".*? line (\d+):", fault)
    return (1, int(found[1])) if found else (0, 0)
