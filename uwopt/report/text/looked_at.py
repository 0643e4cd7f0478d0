"""The words for what is looked at: a report of a wall speaks of that wall, not of a floor."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from uwopt.mission.keys import OTHER_NAMES, TARGET_WORDS

MARKUP = re.compile(r"(<(?:script|style|pre)\b.*?</(?:script|style|pre)>|<[^>]*>)", re.DOTALL)
SPOKEN = re.compile(r"\b(?:sea ?floor|floor|altitude)(s?|_m|_tolerance_m)\b( {2,})?", re.IGNORECASE)


class OfMission(Protocol):
    """What is made of a mission: its plain values, and the file that it was read from."""

    @property
    def mission(self) -> dict[str, Any]:
        """Plain values of the mission."""
        ...

    @property
    def mission_file(self) -> dict[str, str] | None:
        """Name, folder and text; None from Python."""
        ...


def wording_of(made: OfMission) -> Callable[[str], str]:
    """As `wording`, with keys told as the mission's file has them."""
    return wording(made.mission, keys_in((made.mission_file or {}).get("text", "")))


def keys_in(text: str) -> dict[str, str]:
    """Of keys that have two names, by the usual one, that which a mission's file has."""
    return {
        usual: name for other, usual in OTHER_NAMES.items() for name in (other, usual)
        if re.search(rf"""^[^#\n]*\b{name}["']?\s*:""", text, re.MULTILINE)
    }  # fmt: skip


def wording(mission: Mapping[str, Any], keys: Mapping[str, str] | None = None) -> Callable[[str], str]:
    """What turns a text about floors into one about the mission's targets; of floors, and of several kinds, itself.

    keys : names to tell keys by, instead of that which belongs to what is looked at
    """
    said = of_target(mission, keys or {})
    vehicle = mission.get("vehicle")
    is_turned = isinstance(vehicle, Mapping) and vehicle.get("pitch_deg")
    if not (is_turned or len(targets_of(mission)) > 1):
        return said
    return lambda text: said(text.replace("aimed straight down", "aimed where the camera looks"))


def of_target(mission: Mapping[str, Any], keys: Mapping[str, str]) -> Callable[[str], str]:
    """The same by what is looked at, however the camera is turned."""
    targets = targets_of(mission)
    target = targets.pop() if len(targets) == 1 else "floor"
    if target not in TARGET_WORDS or (target == "floor" and all(usual == name for usual, name in keys.items())):
        return unchanged
    thing, way = TARGET_WORDS[target]

    def word(found: re.Match[str]) -> str:
        spoken = found[0].rstrip()
        said = keys.get(spoken) or (way if spoken.casefold().startswith("altitude") else thing) + found[1]
        said = said.capitalize() if found[0][0].isupper() else said
        return said + " " * max(len(found[0]) - len(said), 1) if found[2] else said  # columns stay in line

    way_to_it = "straight up" if target == "ceiling" else "straight ahead"
    return lambda text: SPOKEN.sub(word, text).replace("straight down", way_to_it)


def targets_of(mission: Mapping[str, Any]) -> set[str]:
    """What the scenes of a mission look at."""
    scenes = [scene for scene in mission.get("scenes") or () if isinstance(scene, Mapping)]
    return {str(scene.get("target") or "floor") for scene in scenes}


def unchanged(text: str) -> str:
    """A text as it is."""
    return text


def in_page(page: str, said: Callable[[str], str]) -> str:
    """The texts of an HTML page in other words; tags, scripts, styles and quoted files stay."""
    if said is unchanged:
        return page
    return "".join(part if n % 2 else said(part) for n, part in enumerate(MARKUP.split(page)))


def in_figure(value: Any, said: Callable[[str], str]) -> Any:
    """The texts of a drawn figure in other words."""
    if said is unchanged:
        return value
    if isinstance(value, str):
        return said(value)
    if isinstance(value, Mapping):
        return {key: in_figure(item, said) for key, item in value.items()}
    return [in_figure(item, said) for item in value] if isinstance(value, (list, tuple)) else value
