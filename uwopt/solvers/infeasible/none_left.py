"""Kinds of parts of which a mission's choice leaves none: too deep a dive, an own hull that lacks a size."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from uwopt.catalog.catalogue import Exclusion
from uwopt.catalog.choose import PATTERN_KEYS, Selection, matches
from uwopt.catalog.records import OF_A_DESIGN, Kind, Part
from uwopt.mission.mission import Mission
from uwopt.results.basis import NoneLeft, TooShallow

KINDS: tuple[Kind, ...] = (*OF_A_DESIGN, "housing")
MOST_NAMED = 3
NOT_NAMED = ("pattern", "generic", "form", "exclude")  # rules of parts that the mission does not want
NOT_SOLD = ("availability", "purpose")  # rules of parts that no fact and no limit would let in
DEPTH = "depth rating"  # which is told as a limit that can be moved
MAY_LET_IN = {DEPTH, "run time", "rated time", "colour"}  # rules that a depth, a duration or a red channel less moves


def none_left(mission: Mission, selection: Selection) -> Iterator[NoneLeft]:
    """The kinds, each with what every rule leaves out of it, and why those that the mission names are not."""
    for kind in KINDS:
        needed = kind != "housing" or mission.catalog.housing == "required"
        if kind == "light":
            needed = mission.vehicle.light_count[1] > 0
        elif selection.completes:
            needed = False
        out = [one for one in selection.excluded if one.kind == kind]
        if not (needed and out) or selection.indices[kind]:
            continue
        parts = {part.id: part for part in selection.catalog.parts(kind)}
        named = worth_naming(mission, kind, parts, out)
        few = {one.part_id: one.reason for one in named[:MOST_NAMED]}
        shallow = [parts[one.part_id] for one in out if one.rule == DEPTH]
        yield NoneLeft(kind, few, selection.counts[kind], too_shallow(mission, shallow))


def stays_empty(lacking: Iterable[NoneLeft]) -> bool:
    """Whether some kind has no part whatever less is asked: the mission's choice of parts alone leaves none."""
    return any(MAY_LET_IN.isdisjoint(one.by_rule) for one in lacking)


def worth_naming(mission: Mission, kind: Kind, parts: dict[str, Part], out: Sequence[Exclusion]) -> list[Exclusion]:
    """Parts that the mission names; where it names none, those rated deep enough of which a fact keeps them out."""
    patterns = getattr(mission.catalog, PATTERN_KEYS[kind])
    wanted = [one for one in out if one.rule not in NOT_NAMED]
    if patterns:
        asked = {name for name, part in parts.items() if any(matches(one, part) for one in patterns)}
        named = [one for one in wanted if one.part_id in asked]
        return sorted(named, key=lambda one: one.rule == DEPTH)
    enough = [one for one in wanted if one.rule not in (DEPTH, *NOT_SOLD)]
    return [one for one in enough if (rating_m(parts[one.part_id]) or 0.0) >= mission.required_depth_m]


def too_shallow(mission: Mission, parts: Sequence[Part]) -> TooShallow | None:
    """What parts that are left out for their rating lack; what is to be made counts where it may be used."""
    if not parts:
        return None
    may_be_made = mission.catalog.generic != "never"
    rated = {part.id: depth for part in parts if (depth := rating_m(part)) and (may_be_made or not part.generic)}
    deepest = max(rated, key=lambda name: rated[name], default="")
    unrated = sum(rating_m(part) is None for part in parts)
    return TooShallow(mission.required_depth_m, unrated, deepest, rated.get(deepest))


def rating_m(part: Part) -> float | None:
    """What a part is rated for; None where that is not known, or nothing that can be told of it."""
    return getattr(part, "depth_rating_m", None)
