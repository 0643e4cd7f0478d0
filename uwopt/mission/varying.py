"""Missions in which some keys take other values: what is varied, over what, and whether more of it asks for more.

A key is named as in the mission file; where two sections have it, with the section (`reserve.max_gain_db`), and with a
scene's name for one scene alone (`lagoon.altitude_m`). It is set in every scene otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from uwopt.documents.faults import nearest, show
from uwopt.documents.key_types import OUT_OF_REACH, keys_of
from uwopt.documents.reading import read_document
from uwopt.errors import MissionError
from uwopt.mission.checks import in_one_form
from uwopt.mission.keys import CLARITY_KEYS, OTHER_NAMES
from uwopt.mission.mission import Mission, load_mission, mission_sections
from uwopt.mission.strictness import sign_of

MOST_VALUES = 1000
DIGITS = 12  # of the values of a range: no tails of rounding
OF_SCENES = ("vehicle", "requirements")  # sections of which a scene may state keys of its own
NOT_VARIED = ("name", "vehicle", "requirements", "time_share", "extras", "owned", "rates", "light_mounts")
#: One way of asking for a thing replaces the others.
ONE_OF = (("min_snr", "min_snr_db"), CLARITY_KEYS)

Value = float | int | str
Asked = Mapping[str, Sequence[Any] | str]


@dataclass(frozen=True)
class Varied:
    """One key and the values that it takes, in the order in which they were given."""

    key: str  # as a person names it
    section: str  # scene, vehicle, requirements, reserve, limits or catalog
    name: str  # of the field's key in it
    values: tuple[Value, ...]
    scene: str = ""  # the only scene where it is set; empty: all

    @property
    def is_numeric(self) -> bool:
        """Whether there is something between its values."""
        return all(isinstance(value, (int, float)) for value in self.values)

    def stricter(self, mission: Mission) -> int:
        """1 where more of it asks for more, -1 where less does, 0 where neither is sure."""
        return sign_of(mission, self.section, self.name) if self.is_numeric else 0


class VariedMission:
    """A mission's plain values, in which keys can be set and the mission made again."""

    def __init__(
        self,
        source: str | Path | Mapping[str, Any] | Mission,
        changes: Mapping[str, Any],
        base_dir: Path | None = None,
    ):
        """`changes`: other top-level values, such as the objective of the call; `base_dir` as of `load_mission`."""
        self.base = load_mission(source, base_dir=base_dir)
        self.base_dir = self.base.base_dir
        if isinstance(source, Mission):
            data = source.to_dict()
        else:
            data = in_one_form(read_document(source, "mission").data)[0]
        self.data = {**data, **changes}
        if changes:
            self.base = self.base.with_changes(**changes)

    def with_values(self, values: Mapping[Varied, Value]) -> Mission:
        """The mission with these values; raises MissionError where they cannot stand together."""
        data = deepcopy(self.data)
        for varied, value in values.items():
            for place in self._places(data, varied):
                set_key(place, varied.name, value)
        own = {f"{varied.section}.{varied.name}" for varied in values}
        return self._made(data).stating(self.base.stated | own)

    def scaled(self, varied: Varied, factor: float) -> Mission:
        """The mission with a key times a factor wherever it stands."""
        data = deepcopy(self.data)
        for place in self._stated(data, varied):
            place[varied.name] = rounded(float(place[varied.name]) * factor)
        return self._made(data).stating(self.base.stated)

    def stated_numbers(self) -> Iterator[Varied]:
        """Keys that the mission itself states as one number other than 0, those that count pieces left out."""
        for section, names in self._names().items():
            for name in names:
                varied = Varied(name, section, name, ())
                found = [place[name] for place in self._stated(self.data, varied)]
                if found and all(type(value) in (int, float) and value for value in found) and "count" not in name:
                    yield Varied(name, section, name, (found[0],))

    def varied(self, key: str, values: Sequence[Any] | str) -> Varied:
        """A key that is in the mission's language, with checked values."""
        if not isinstance(key, str):
            raise MissionError(f"vary {show(key)}: is no key; write such as speed_m_s")
        return replace(self.named(key), values=checked_values(f"vary {key.strip()}", values))

    @staticmethod
    def is_allowed(varied: Varied, value: Value) -> bool:
        """Whether a key may have a value, whatever else a mission says, and whether or not anything can meet it."""
        try:
            mission_sections()[varied.section].model_validate({varied.name: value})
        except ValidationError as error:
            faults = [one["type"] for one in error.errors(include_url=False) if one["loc"][:1] == (varied.name,)]
            return all(kind == OUT_OF_REACH for kind in faults)
        return True

    def named(self, key: str) -> Varied:
        """A key that is in the mission's language, without values; raises MissionError for others."""
        plain, told = key.strip(), f"vary {key.strip()}"
        head, _, name = plain.rpartition(".")
        name = OTHER_NAMES.get(name, name)
        places, scenes = self._names(), [scene.name for scene in self.base.scenes]
        scene = head if head in scenes and head not in places else ""
        if head and not scene and head not in places:
            there = ", ".join((*places, *scenes))
            raise MissionError(f"{told}: {head!r} is neither a section nor a scene of this mission; there are {there}")
        of_head = {head: places[head]} if head in places else places
        found = [section for section, names in of_head.items() if name in names]
        if scene:
            found = [section for section in found if section in ("scene", *OF_SCENES)]
        if not found:
            known = [one for names in of_head.values() for one in names]
            known += OTHER_NAMES if "vehicle" in of_head else ()
            near = nearest(name, known)
            mend = f"did you mean {near}?" if near else "uwopt schema lists the keys of a mission"
            raise MissionError(f"{told}: {name!r} is no key that can be varied; {mend}")
        if len(found) > 1:
            both = " or ".join(f"{section}.{name}" for section in found)
            raise MissionError(f"{told}: {' and '.join(found)} both have this key; write {both}")
        return Varied(plain, found[0], name, (), scene)

    def _made(self, data: Mapping[str, Any]) -> Mission:
        return load_mission(data, base_dir=self.base_dir)

    @staticmethod
    def _names() -> dict[str, tuple[str, ...]]:
        """The keys that can be varied, by section."""
        return {
            section: tuple(name for name in keys_of(model) if name not in NOT_VARIED)
            for section, model in mission_sections().items()
            if section
        }

    def _places(self, data: dict[str, Any], varied: Varied) -> list[dict[str, Any]]:
        """Where a key is set; scenes that state it themselves no longer do."""
        scenes = [s for s in data["scenes"] if not varied.scene or s.get("name") == varied.scene]
        if varied.section == "scene":
            return scenes
        if varied.scene:
            return [scene.setdefault(varied.section, {}) for scene in scenes]
        for scene in scenes:
            own = scene.get(varied.section)
            for name in same_as(varied.name) if isinstance(own, dict) else ():
                own.pop(name, None)
        given = data.get(varied.section)
        if not isinstance(given, dict):  # left out, or the word `recommended`: what else it stands for stays
            given = self.base.reserve.model_dump(mode="json") if varied.section == "reserve" else {}
        data[varied.section] = given
        return [given]

    @staticmethod
    def _stated(data: Mapping[str, Any], varied: Varied) -> list[dict[str, Any]]:
        """The places that state a key."""
        scenes = [scene for scene in data["scenes"] if isinstance(scene, dict)]
        own = scenes if varied.section == "scene" else [scene.get(varied.section) for scene in scenes]
        places = own if varied.section == "scene" else [data.get(varied.section), *own]
        return [place for place in places if isinstance(place, dict) and place.get(varied.name) is not None]


def set_key(place: dict[str, Any], name: str, value: Value) -> None:
    """A key set in a section, in place of other ways of asking for the same."""
    for other in same_as(name):
        place.pop(other, None)
    place[name] = value


def same_as(name: str) -> tuple[str, ...]:
    """The keys that ask for the same thing, this one among them."""
    return next((names for names in ONE_OF if name in names), (name,))


def checked_values(told: str, given: Iterable[Any] | str) -> tuple[Value, ...]:
    """The values of a range `from:to:count`, of a list by commas, or of a sequence; each once, two at least."""
    if isinstance(given, str):
        told = f"{told}={given.strip()}"
        values = range_values(told, given) if ":" in given else [plain_value(text) for text in given.split(",")]
    else:
        values = [plain_value(value) for value in (given if isinstance(given, Iterable) else [given])]
    if any(value == "" for value in values):
        raise MissionError(f"{told}: a value is empty; write {EXAMPLES}")
    if len(values) < 2:
        holds = "has one value" if values else "is an empty range"
        raise MissionError(f"{told}: {holds}, two at least are wanted; write {EXAMPLES}")
    if len(values) > MOST_VALUES:
        raise MissionError(f"{told}: asks for {len(values)} values, {MOST_VALUES} at most are solved; take fewer")
    twice = next((value for value in values if values.count(value) > 1), None)
    if twice is not None:
        raise MissionError(f"{told}: {show(twice)} stands twice; give each value once")
    return tuple(values)


EXAMPLES = "such as speed_m_s=0.2:2:40 (from:to:how many) or water=I,II,1C"


def range_values(told: str, text: str) -> list[Value]:
    """Evenly spaced values of `from:to:count`."""
    parts = [part.strip() for part in text.split(":")]
    try:
        low, high, count = (float(part) for part in parts)
    except ValueError:
        raise MissionError(f"{told}: is no range; write {EXAMPLES}") from None
    if not all(map(math.isfinite, (low, high, count))):
        raise MissionError(f"{told}: its ends are not finite; write {EXAMPLES}")
    if count != int(count) or count < 2 or low == high:
        raise MissionError(f"{told}: is an empty range; give two different ends and 2 values at least")
    if count > MOST_VALUES:
        raise MissionError(f"{told}: asks for {count:.0f} values, {MOST_VALUES} at most are solved; take fewer")
    step = (high - low) / (count - 1)
    return [rounded(low + index * step) for index in range(int(count))]


def rounded(value: float) -> float | int:
    """A number without a tail of rounding; a whole one as such, as counts want them."""
    short = float(f"{value:.{DIGITS}g}")
    return int(short) if short == int(short) and abs(short) < 1e15 else short


def plain_value(value: Any) -> Value:
    """A value as a mission file would have it."""
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, str):
        text = value.strip()
        try:
            number = float(text)
        except ValueError:
            return text
        return rounded(number) if math.isfinite(number) else text
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise MissionError(f"vary: {show(value)} is no value of a key; give numbers or words")
    return rounded(float(value))
