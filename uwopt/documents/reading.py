"""Reading a mission or system: YAML with the line of every key, or a mapping from Python.

A document is plain values; it knows its name, its folder and the line of each key, so that every fault
found later can say where it stands.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any

from uwopt.documents.faults import KeyPath, nearest, show
from uwopt.documents.files import UnfitFileError, content, other_kind
from uwopt.documents.yaml_lines import MAX_DEPTH, MAX_NODES, compose, too_deep, too_many
from uwopt.errors import MissionError

MAX_BYTES = 10_000_000
MISSION_KEYS = frozenset({"vehicle", "requirements"})  # which every mission has, and no system
SYSTEM_KEYS = frozenset({"camera", "complete"})  # of which every system has one, and no mission
_NOTHING = object()


@dataclass(frozen=True)
class Document:
    """What a source said: plain values, the line of each key, and the faults of its form."""

    name: str
    data: dict[str, Any]
    lines: Mapping[KeyPath, int] = field(default_factory=dict)
    base_dir: Path | None = None
    faults: tuple[str, ...] = ()
    text: str | None = None  # of the file as it was read
    changed: frozenset[str] = frozenset()  # keys of the top level that a call gives in place of the source

    def has(self, path: KeyPath) -> bool:
        """Whether the source holds something at this path."""
        return self.value(path, _NOTHING) is not _NOTHING

    def value(self, path: KeyPath, default: Any = None) -> Any:
        """What the source holds at a path."""
        node: Any = self.data
        for step in path:
            in_list = isinstance(node, list) and isinstance(step, int) and 0 <= step < len(node)
            if not in_list and not (isinstance(node, Mapping) and step in node):
                return default
            node = node[step]
        return node

    def where(self, path: KeyPath = ()) -> str:
        """File and line of a key, or of the nearest thing around it: `reef.yaml line 12`; none of what a call gives."""
        if path and path[0] in self.changed:
            return ""
        for length in range(len(path), 0, -1):
            line = self.lines.get(path[:length])
            if line is not None:
                return f"{self.name} line {line}"
        return self.name


def read_document(source: object, what: str = "mission") -> Document:
    """A mission or system from a file (its name) or from a mapping; raises MissionError."""
    if isinstance(source, Mapping):
        return Document(what, plain_mapping(source, what))
    if isinstance(source, (str, Path)):
        return _read_file(source, what)
    raise MissionError(
        f"{what}: is neither a file name nor a mapping (its type is {type(source).__name__}); "
        "give the name of a YAML file, or a mapping with its keys."
    )


def plain_mapping(source: Mapping[Any, Any], name: str) -> dict[str, Any]:
    """A copy of a mapping in plain Python values; refuses depth, cycles and sizes beyond the file limits."""
    counter = iter(range(MAX_NODES))
    plain = _plain(source, name, 0, counter)
    assert isinstance(plain, dict)
    return plain


def _plain(value: Any, name: str, depth: int, counter: Iterator[int]) -> Any:
    if next(counter, None) is None:
        raise MissionError(too_many(name))
    if depth > MAX_DEPTH:
        raise MissionError(too_deep(name))
    if is_dataclass(value) and not isinstance(value, type):  # a record of a result, such as a lamp's place
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(item, name, depth + 1, counter) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item, name, depth + 1, counter) for item in value]
    if isinstance(value, Path):
        return str(value)
    if type(value).__module__ == "numpy" and hasattr(value, "tolist"):
        return _plain(value.tolist(), name, depth + 1, counter)
    return value


def _read_file(source: str | Path, what: str) -> Document:
    name = str(source)
    shown = show(name, 200)[1:-1]
    if "\n" in name:
        raise MissionError(
            f"{what}: is YAML text, not the name of a file; save it, or pass yaml.safe_load(text)."
        )
    try:
        path = Path(name).expanduser() if name.startswith("~") else Path(name)
        _refuse_unreadable(path, shown, what)
        raw = content(path, MAX_BYTES)
    except UnfitFileError as fault:
        raise MissionError(f"{shown}: {fault}; a {what} is a YAML file of a few kB.") from None
    except (OSError, ValueError, RuntimeError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise MissionError(f"{shown}: cannot be read ({reason}); check its name and rights.") from None
    if kind := other_kind(raw) or ("a table" if path.suffix.lower() == ".csv" else ""):
        raise MissionError(f"{shown}: is {kind}, no {what}; name a YAML file ({_written_by(what)}).")
    text = _decode(raw, shown)
    if not text.strip():
        raise MissionError(f"{shown}: is empty; {_written_by(what)} to start from.")
    data, lines, faults = compose(text, shown)
    if data is None and not faults:
        raise MissionError(f"{shown}: is empty but for comments; {_written_by(what)} to start from.")
    if not isinstance(data, dict):
        raise MissionError(
            [*faults, f"{shown}: is not a mapping of keys to values; start with `name: reef`."]
        )
    if "uwopt_version" in data:
        beside = {"system": "name the system.yaml that --out wrote beside it"}
        raise MissionError(f"{shown}: is a result of uwopt, no {what}; {beside.get(what, f'name the {what} file')}.")
    if what == "mission" and SYSTEM_KEYS & data.keys() and not MISSION_KEYS & data.keys():
        raise MissionError(f"{shown}: is a system, no mission; name the mission file, before that of a system.")
    if what == "system" and MISSION_KEYS.issubset(data):
        raise MissionError(f"{shown}: is a mission, no system; `uwopt init --system` writes one to start from.")
    return Document(shown, data, lines, path.absolute().parent, tuple(faults), text)


def _written_by(what: str) -> str:
    """Where one may begin: a mission, a system."""
    return f"`uwopt init{' --system' if what == 'system' else ''}` writes a {what}"


def _refuse_unreadable(path: Path, shown: str, what: str) -> None:
    if path.is_dir():
        raise MissionError(f"{shown}: is a folder; name the {what} file in it.")
    if not path.exists():
        names = {Path(name).stem: name for name in _yaml_names(path.parent)}  # alike by more than how they end
        near = nearest(path.stem, names)
        hint = f"did you mean {names[near]}?" if near else f"{_written_by(what)} to start from."
        raise MissionError(f"{shown}: no such file; {hint}")


def _yaml_names(folder: Path) -> list[str]:
    try:
        return [
            entry.name
            for entry, _ in zip(folder.iterdir(), range(500), strict=False)
            if entry.suffix.lower() in (".yaml", ".yml", ".json")
        ]
    except OSError:
        return []


def _decode(raw: bytes, shown: str) -> str:
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line = raw.count(b"\n", 0, fault.start) + 1
        raise MissionError(
            f"{shown} line {line}: is not UTF-8 text (byte {fault.start}); save the file with UTF-8 encoding."
        ) from None
