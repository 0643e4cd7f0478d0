"""Kinds of parts of which a mission's choice leaves none: an own hull that lacks a size, a camera that is not sold."""

from __future__ import annotations

from collections.abc import Iterator

from uwopt.catalog.choose import PATTERN_KEYS, Selection, matches
from uwopt.catalog.records import Kind
from uwopt.mission.mission import Mission
from uwopt.results.basis import NoneLeft

KINDS: tuple[Kind, ...] = ("camera", "lens", "port", "light", "housing")
MOST_NAMED = 3
NOT_NAMED = ("pattern", "generic", "form", "exclude")  # rules of parts that the mission does not want
DEPTH = "depth rating"  # which is told as a limit that can be moved


def none_left(mission: Mission, selection: Selection) -> Iterator[NoneLeft]:
    """The kinds, each with the parts that the mission names and why they are left out."""
    for kind in KINDS:
        needed = kind != "housing" or mission.catalog.housing == "required"
        if kind == "light":
            needed = mission.vehicle.light_count[1] > 0
        elif selection.completes:
            needed = False
        out = [one for one in selection.excluded if one.kind == kind]
        patterns = getattr(mission.catalog, PATTERN_KEYS[kind])
        asked = {part.id for part in selection.catalog.parts(kind) if any(matches(one, part) for one in patterns)}
        named = [one for one in out if one.rule not in NOT_NAMED and (one.part_id in asked or not patterns)]
        if needed and not selection.indices[kind] and any(one.rule != DEPTH for one in named):
            few = {one.part_id: one.reason for one in sorted(named, key=lambda one: one.rule == DEPTH)[:MOST_NAMED]}
            yield NoneLeft(kind, few, len(out) - len(few))
