"""A mission as it was solved, as a file: the user's own text, with the keys of good practice that gave way stated."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping
from typing import Any

import yaml

from uwopt.documents.yaml_lines import compose
from uwopt.errors import MissionError
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.yielding import Yield

BY_OPTIONS = ("objective", "physics", "confidence")  # keys that a call may give in place of the file
HEAD = "# As solved: what of good practice was relaxed is stated, so that the same comes out at once.\n"


def as_solved(solved: Mission, given_way: Collection[Yield]) -> str:
    """The text of a mission that asks for what was solved, after this gave way.

    The user's text with keys added, where that is seen to mean the same; else every key with its value.
    """
    known = solved.source_file
    if known is not None and not known["folder"]:  # files that it names are found from there alone
        text = known["text"]
        wanted, given = solved.to_dict(), load_mission(compose(text, "mission")[0] or {}).to_dict()
        stated = {(one.section, one.key): wanted[one.section][one.key] for one in given_way}
        top = {(key,): wanted[key] for key in BY_OPTIONS if wanted[key] != given[key]}
        made = with_keys(text, {**stated, **top})
        if means(made, solved):
            return HEAD + made
    return HEAD + yaml.safe_dump(solved.to_dict(absolute_paths=True), sort_keys=False, allow_unicode=True)


def means(text: str, mission: Mission) -> bool:
    """Whether a text is read as a mission."""
    data, _, faults = compose(text, "mission")
    try:
        return not faults and load_mission(data or {}).to_dict() == mission.to_dict()
    except MissionError:
        return False


def with_keys(text: str, keys: Mapping[tuple[str, ...], Any]) -> str:
    """A YAML text with keys added, each the first of its section, or a section of its own at the end."""
    for path, value in keys.items():
        *sections, key = path
        line = f"{key}: {json.dumps(value)}"
        text = in_section(text, sections[0], line) if sections else on_top(text, key, line)
    return text


def on_top(text: str, key: str, line: str) -> str:
    """A text with a line in the place of a key, or at the end."""
    made, count = re.subn(rf"^{re.escape(key)}:.*$", lambda _: line, text, count=1, flags=re.MULTILINE)
    return made if count else text.rstrip("\n") + f"\n{line}\n"


def in_section(text: str, section: str, line: str) -> str:
    """A text with a line more in a section, written in lines, in braces or as a word; the key's own goes."""
    own = re.escape(line.partition(":")[0])
    block = re.search(rf"^{section}:[ \t]*(?:#.*)?\n(?:[ \t]*(?:#.*)?\n)*([ \t]+)\S", text, flags=re.MULTILINE)
    if block is not None:
        indent, start = block.group(1), block.start(1)
        rest = re.sub(rf"^{indent}{own}:.*\n", "", text[start:], count=1, flags=re.MULTILINE)
        return f"{text[:start]}{indent}{line}\n{rest}"
    braces = re.search(rf"^{section}:[ \t]*\{{", text, flags=re.MULTILINE)
    if braces is not None:
        return f"{text[: braces.end()]}{line}, {text[braces.end() :]}"
    made, count = re.subn(rf"^{section}:.*$", lambda _: f"{section}:\n  {line}", text, count=1, flags=re.MULTILINE)
    return made if count else text.rstrip("\n") + f"\n{section}:\n  {line}\n"
