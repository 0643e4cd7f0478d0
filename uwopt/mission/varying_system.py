"""Systems in which some keys take other values, as `varying` has it for missions.

A key is named as in the system file: `f_number` of its settings, `light_tilt_deg` of the system, `lens.focal_length_mm`
of a part that is written out in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from uwopt.documents.faults import nearest
from uwopt.documents.key_types import keys_of
from uwopt.errors import MissionError
from uwopt.mission.system import LEVEL_KEYS, PART_KINDS, Settings
from uwopt.mission.varying import Value

OWN_KEYS = ("camera_count", "light_count", "light_baseline_m", "light_tilt_deg", "spacer_mm", "orientation")


def is_system_key(key: str) -> bool:
    """Whether a key belongs to a system file: a setting, a part's key, or a place of its lights."""
    head, _, name = key.rpartition(".")
    return (
        head in ("settings", *PART_KINDS)
        or key in PART_KINDS
        or (not head and (name in keys_of(Settings) or name in OWN_KEYS))
    )


def with_system_value(system: Mapping[str, Any], key: str, value: Value) -> dict[str, Any]:
    """A system's plain values with another value of one key; raises MissionError where it has no such place."""
    data = deepcopy(dict(system))
    head, _, name = key.rpartition(".")
    if head in PART_KINDS:
        part = data.get(head)
        if not isinstance(part, dict):
            raise MissionError(
                f"vary {key}: the {head} of this system is {part!r} of the catalogue; write the {head} as a section "
                "with its numbers to vary one"
            )
        part[name] = value
        return data
    if not head and (key in OWN_KEYS or key in PART_KINDS):
        return _with_own_key(data, key, value)
    if name not in keys_of(Settings):
        near = nearest(name, keys_of(Settings))
        mend = f"did you mean {near}?" if near else "`uwopt schema system` lists them"
        raise MissionError(f"vary {key}: {name!r} is no setting; {mend}")
    for place in (data.setdefault("settings", {}), *(data.get("scenes") or {}).values()):
        others = LEVEL_KEYS if name in LEVEL_KEYS else (name,)
        for other in others:
            place.pop(other, None)
    data["settings"][name] = value
    return data


def _with_own_key(data: dict[str, Any], key: str, value: Value) -> dict[str, Any]:
    if key in ("light_baseline_m", "light_tilt_deg", "light_count") and data.get("light_mounts"):
        raise MissionError(
            f"vary {key}: this system names the place of each light (light_mounts); leave them out to vary it"
        )
    data[key] = value
    return data

