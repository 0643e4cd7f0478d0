"""YAML with the line of every key.

PyYAML's own loader follows YAML 1.1 (`no` is false, `1:30` is 90, `1e3` is text), forgets the lines and
lets a later key overwrite an earlier one. Its nodes know lines, but not where an alias stands, end at the first
fault and recurse. So only its events are used; scalars follow YAML 1.2, every key remembers its line, duplicates
are faults, and depth, size and aliases are bounded.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import yaml

from uwopt.documents.faults import KeyPath, path_text, show
from uwopt.errors import MissionError

MAX_NODES = 20_000  # values in one file, each alias counted as often as it is used
MAX_DEPTH = 24

_INTEGER = re.compile(r"[-+]?[0-9]+")
_HEX = re.compile(r"0x[0-9a-fA-F]{1,16}")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_SPECIAL = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".inf", "+.inf", ".Inf", "+.Inf"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_TAG = "tag:yaml.org,2002:"
_PLAIN_TAGS = {_TAG + name for name in ("int", "float", "bool", "null", "seq", "map")}


def compose(
    text: str, name: str, *, scalar: Callable[[str], Any] | None = None, max_nodes: int = MAX_NODES
) -> tuple[Any, dict[KeyPath, int], list[str]]:
    """Root value, line of each key, and faults of YAML text; raises MissionError on a syntax error.

    `scalar` makes a value of plain text: `resolve_scalar` unless told.
    """
    return _Composer(name, scalar or resolve_scalar, max_nodes).compose(text)


def too_many(name: str, max_nodes: int = MAX_NODES) -> str:
    """Fault of a source with too many values."""
    return (
        f"{name}: holds more than {max_nodes} values (aliases counted as often as they are used); "
        "put tables into CSV files."
    )


def too_deep(name: str) -> str:
    """Fault of a source that is nested too deeply."""
    return f"{name}: is nested more than {MAX_DEPTH} levels deep (or holds itself); six are enough."


@dataclass
class _Open:
    """A mapping or list that is being filled."""

    value: dict[str, Any] | list[Any]
    path: KeyPath
    anchor: str | None
    first_node: int
    key: str | None = None
    merges: list[Any] = field(default_factory=list)


class _Composer:
    """Plain values from YAML events, without recursion."""

    def __init__(self, name: str, resolve: Callable[[str], Any], max_nodes: int):
        self.name, self.resolve, self.max_nodes = name, resolve, max_nodes
        self.lines: dict[KeyPath, int] = {}
        self.faults: list[str] = []
        self.n_nodes = 0
        self.anchors: dict[str, tuple[Any, int]] = {}
        self.open: list[_Open] = []
        self.root: Any = None

    def compose(self, text: str) -> tuple[Any, dict[KeyPath, int], list[str]]:
        """Root value, line of each path, faults; raises MissionError on a syntax error."""
        n_documents = 0
        try:
            for event in yaml.parse(text, Loader=yaml.SafeLoader):
                if isinstance(event, yaml.DocumentStartEvent):
                    n_documents += 1
                    if n_documents > 1:
                        self._fault(event, "a second document starts here", "keep one in a file")
                        break
                else:
                    self._take(event)
        except yaml.YAMLError as fault:
            raise MissionError([*self.faults, self._syntax(fault)]) from None
        return self.root, self.lines, self.faults

    def _take(self, event: yaml.Event) -> None:
        if isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            self._start(event)
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            self._end()
        elif isinstance(event, yaml.ScalarEvent):
            self._count(1)
            self._scalar(event)
        elif isinstance(event, yaml.AliasEvent):
            self._alias(event)

    def _start(self, event: yaml.MappingStartEvent | yaml.SequenceStartEvent) -> None:
        self._count(1)
        if len(self.open) >= MAX_DEPTH:
            raise MissionError([*self.faults, too_deep(f"{self.name} line {_line(event)}")])
        self._check_tag(event)
        is_mapping = isinstance(event, yaml.MappingStartEvent)
        path = self._next_path(event)
        value: dict[str, Any] | list[Any] = {} if is_mapping else []
        self.open.append(_Open(value, path, event.anchor, self.n_nodes))

    def _end(self) -> None:
        done = self.open.pop()
        if isinstance(done.value, dict):
            for merged in done.merges:  # YAML's `<<`: what stands here wins over what is merged in
                for key, value in merged.items():
                    done.value.setdefault(key, value)
        if done.anchor is not None:
            self.anchors[done.anchor] = (done.value, self.n_nodes - done.first_node + 1)
        self._put(done.value)

    def _scalar(self, event: yaml.ScalarEvent) -> None:
        parent = self.open[-1] if self.open else None
        if parent is not None and isinstance(parent.value, dict) and parent.key is None:
            self._key(parent, event)
            return
        self._check_tag(event)
        plain = (event.tag is None and event.implicit[0]) or event.tag in _PLAIN_TAGS
        value = self.resolve(event.value) if plain else event.value
        if event.anchor is not None:
            self.anchors[event.anchor] = (value, 1)
        self._next_path(event)
        self._put(value)

    def _key(self, parent: _Open, event: yaml.ScalarEvent) -> None:
        key = event.value
        path = (*parent.path, key)
        if key in parent.value and key != "<<":
            self._fault(
                event,
                f"{path_text(path)} stands twice (also in line {self.lines.get(path, _line(event))})",
                "remove one",
            )
        else:
            self.lines[path] = _line(event)
        parent.key = key

    def _alias(self, event: yaml.AliasEvent) -> None:
        name = str(event.anchor)
        if name not in self.anchors:
            self._fault(event, f"alias *{name} refers to nothing before it", "write the value out")
            self.anchors[name] = (None, 1)
        value, size = self.anchors[name]
        self._count(size)
        if self.open and isinstance(self.open[-1].value, dict) and self.open[-1].key is None:
            self._fault(event, f"alias *{name} stands as a key", "write the key out")
            self.open[-1].key = ""
            return
        self._next_path(event)
        self._put(value)

    def _next_path(self, event: yaml.Event) -> KeyPath:
        if not self.open:
            return ()
        parent = self.open[-1]
        if isinstance(parent.value, list):
            path: KeyPath = (*parent.path, len(parent.value))
            self.lines[path] = _line(event)
            return path
        if parent.key is None:  # a mapping or list as a key
            self._fault(event, "a key is not plain text", "write `key: value`")
            parent.key = ""
            return (*parent.path, "")
        return (*parent.path, parent.key)

    def _put(self, value: Any) -> None:
        if not self.open:
            self.root = value
            return
        parent = self.open[-1]
        if isinstance(parent.value, list):
            parent.value.append(value)
            return
        key, parent.key = parent.key, None
        if key == "<<":
            sources = value if isinstance(value, list) else [value]
            parent.merges += [source for source in sources if isinstance(source, dict)]
        elif key is not None:
            parent.value.setdefault(key, value)

    def _count(self, n: int) -> None:
        self.n_nodes += n
        if self.n_nodes > self.max_nodes:
            raise MissionError([*self.faults, too_many(self.name, self.max_nodes)])

    def _check_tag(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent) -> None:
        tag = event.tag
        if tag is not None and tag != "!" and tag != _TAG + "str" and tag not in _PLAIN_TAGS:
            self._fault(event, f"tag {show(tag)} is not allowed", "write the plain value")

    def _fault(self, event: yaml.Event, what: str, mend: str) -> None:
        self.faults.append(f"{self.name} line {_line(event)}: {what}; {mend}.")

    def _syntax(self, fault: yaml.YAMLError) -> str:
        mark = getattr(fault, "problem_mark", None) or getattr(fault, "context_mark", None)
        where = f"{self.name} line {mark.line + 1} column {mark.column + 1}" if mark else self.name
        problem = getattr(fault, "problem", None) or getattr(fault, "reason", None) or "it cannot be parsed"
        return f"{where}: is not valid YAML: {problem}; {_syntax_hint(str(problem))}."


def resolve_scalar(text: str) -> Any:
    """Plain YAML text as a value: null, true or false, a number, else the text itself."""
    if text in _SPECIAL:
        return _SPECIAL[text]
    if len(text) > 300:
        return text
    if _INTEGER.fullmatch(text):
        return int(text)
    if _HEX.fullmatch(text):
        return int(text, 16)
    return float(text) if _FLOAT.fullmatch(text) else text


def _syntax_hint(problem: str) -> str:
    if "\\t" in problem:
        return "indent with spaces, not tabs"
    if "mapping values are not allowed" in problem:
        return "text that holds ': ' needs quotes, and keys of one level start in one column"
    if "could not find expected ':'" in problem or "simple key" in problem:
        return "each key needs a colon and a space after it"
    if "special characters" in problem:
        return "the file holds control characters; save it as plain text"
    return "check indentation, quotes and brackets there and in the line before"


def _line(event: yaml.Event) -> int:
    mark = event.start_mark
    return 1 if mark is None else int(mark.line) + 1
