"""Words for faults: paths of keys, values shortened, and the nearest known word."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from functools import lru_cache

KeyPath = tuple[str | int, ...]
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")
_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(,\d{3})+")


def path_text(path: KeyPath) -> str:
    """A path as a person writes it: `scenes[1].vehicle.speed_m_s`."""
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += ("." if text else "") + _printable_key(step)
    return text


def show(value: object, limit: int = 60) -> str:
    """A value for a message, shortened."""
    if isinstance(value, Mapping):
        return "{...}" if value else "{}"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    try:
        text = "[" + ", ".join(map(show, value)) + "]" if isinstance(value, (list, tuple)) else repr(value)
    except Exception:  # whatever a caller's object does in its repr, the fault must be told
        text = f"a {type(value).__name__}"
    return text if len(text) <= limit else text[: limit - 3] + "..."


@lru_cache(maxsize=8192)
def plain_name(name: str) -> str:
    """A name as it is compared with others: case ignored, `-` and blanks as `_`."""
    return name.strip().casefold().replace("-", "_").replace(" ", "_")


MISSPELT = 0.8  # as like as this is a word with a letter or two amiss


def nearest(word: str, known: Iterable[str], cutoff: float = 0.6) -> str | None:
    """The known word most like this one; None when none is near."""
    by_plain = {plain_name(name): name for name in known}
    plain = plain_name(word)[:80]
    longer = [name for key, name in by_plain.items() if len(plain) > 2 and key.startswith(plain + "_")]
    if len(longer) == 1:
        return longer[0]
    found = difflib.get_close_matches(plain, by_plain, n=1, cutoff=cutoff)
    shorter = [key for key in by_plain if plain.startswith(key + "_")]  # a key with a unit that it does not have
    if shorter and not difflib.get_close_matches(plain, by_plain, n=1, cutoff=MISSPELT):
        return by_plain[max(shorter, key=len)]
    return by_plain[found[0]] if found else None


def without_comma(text: str) -> str:
    """How to write a number that has commas; empty where it is no such number. `10,000` may mean two numbers."""
    plain = text.strip()
    if _THOUSANDS.fullmatch(plain):
        decimal = (
            f", or {plain.replace(',', '.')} if the comma is a decimal one" if plain.count(",") == 1 else ""
        )
        return f"write {plain.replace(',', '')}{decimal}"
    return f"write a decimal point: {plain.replace(',', '.')}" if _DECIMAL_COMMA.fullmatch(plain) else ""


def _printable_key(key: str) -> str:
    plain = key.isprintable() and key.strip() == key and key != ""
    return key if plain and len(key) <= 60 else show(key)
