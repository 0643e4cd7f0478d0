"""What would help a mission that nothing meets, beside single requirements: moves, and what contradicts each other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from uwopt.deadline import longer_s
from uwopt.mission.reserves import depth_factor
from uwopt.mission.weakened import is_far
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Line, sentence
from uwopt.results.basis import Moved
from uwopt.results.design import Note
from uwopt.results.result import Result
from uwopt.units import count_text

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult

TOLD_AS_OPEN = ("whether it could be met without ", "whether another ", "whether less than that change of ")
OF_DEPTH = ": depth rating"  # how what excludes a kind of part by its rating ends


def moves_of(result: Result | FrontResult) -> list[Moved]:
    """Keys of which one moved alone would help."""
    return result.infeasible.moves if result.infeasible is not None else []


def move_text(move: Moved) -> str:
    """`altitude (altitude_m) 5.00 m -> 3.15 m`, and whether less is known not to do."""
    name, asked, needed = move_texts(move)
    text = f"{name} {asked} -> {needed}"
    return text if move.nearest else f"{text} (less may do)"


def move_texts(move: Moved) -> tuple[str, str, str]:
    """Key, where it stands, where something fits."""
    name = words.key_name(move.name)
    if isinstance(move.asked, str) or isinstance(move.needed, str):
        return name, formats.one_line(move.asked, 20), formats.one_line(move.needed, 20)
    if not move.unit:  # of pieces
        return name, f"{move.asked:g}", f"{move.needed:g}"
    asked, needed = formats.quantities_apart(move.asked, move.needed, unit=move.unit, digits=4)
    return name, asked, needed


def move_is_far(move: Moved) -> bool:
    """As `is_far`."""
    if isinstance(move.asked, str) or isinstance(move.needed, str):
        return False
    return is_far(move.name, move.asked, move.needed)


def no_help_lines(result: Result | FrontResult) -> list[Line]:
    """What is known not to help alone, with what still stands in the way, those alike together."""
    why = result.infeasible
    groups: dict[tuple[str, ...], list[str]] = {}
    for item in why.no_help if why is not None else []:
        groups.setdefault(tuple(sorted(item.still)), []).append(words.key_name(item.name))
    if not groups:
        return []
    told = [
        words.listed(names) + (f" (even so {', or '.join(words.rule_name(rule) for rule in still)})" if still else "")
        for still, names in groups.items()
    ]
    return [sentence(f"Not enough by itself, even left out or moved far: {'; '.join(told)}.")]


def not_known_lines(result: Result | FrontResult) -> list[Line]:
    """What there was no time to know, and how to give it more."""
    why = result.infeasible
    if why is None or result.status != "infeasible":
        return []
    unsure = [item.name for item in why.relaxations if not item.nearest and item.needed is not None]
    unsure += [move.name for move in why.moves if not move.nearest]
    told = []
    if why.not_known:
        names = words.listed([words.key_name(name) for name in why.not_known], "or")
        told.append(f"whether it is enough to relax {names}{in_part_text(why.in_part)}")
    if unsure:
        names = words.listed([words.key_name(name) for name in unsure])
        told.append(f"whether less than what is told of {names} is enough")
    if not told:
        return []
    spent_s = result.timing_s.get("explanation", 0.0)
    return [sentence(f"Not known yet: {'; '.join(told)}. uwopt explain with --seconds {longer_s(spent_s)} goes on.")]


def notes_beside(result: Result | FrontResult) -> list[Note]:
    """The notes of a result; of what there was no time for without that which `not_known_lines` tells."""
    if result.infeasible is None or result.status != "infeasible":
        return result.warnings
    made = []
    for note in result.warnings:
        said, _, rest = note.message.partition(": ")
        left = [text for text in rest.split("; ") if not text.startswith(TOLD_AS_OPEN)]
        if note.code != "time" or "; ".join(left) == rest:
            made.append(note)
        elif left:
            made.append(replace(note, message=f"{said}: {'; '.join(left)}"))
    return made


def in_part_text(looked_at: Mapping[str, int]) -> str:
    """` (without cost 66 507 systems were looked at in vain, not all)`; "" where nothing was looked at."""
    if not looked_at:
        return ""
    each = [f"without {words.note_subject(name)} {count_text(count)}" for name, count in looked_at.items()]
    return f" ({words.listed(each)} systems were looked at in vain, not yet all)"


def depth_lines(result: Result | FrontResult) -> list[Line]:
    """That no part of a kind is rated deep enough with its reserve, or that this alone stands in the way."""
    why, factor = result.infeasible, factor_of_depth(result.mission)
    if why is None or not any(item.name.endswith(OF_DEPTH) for item in why.requirements):
        return []
    asked_m, kept = asked_depth_m(result.mission), ""
    told = f"{formats.quantity(asked_m * factor, 'm', 4)} that they must be rated for"
    if factor > 1.0:
        kept = f" ({formats.quantity(asked_m, 'm', 4)} asked for, times {factor:g} kept in reserve: reserve.depth)"
    made: list[Line] = []
    if shallow := {one.kind: one.too_shallow for one in why.none_left if one.too_shallow is not None}:
        kinds = words.listed([*shallow], "or")
        deepest = [
            f"{kind} {formats.one_line(short.deepest, 60)}, {formats.quantity(short.deepest_m, 'm', 4)}"
            for kind, short in shallow.items()
            if short.deepest_m is not None
        ]
        ends = f". Deepest: {'; '.join(deepest)}." if deepest else "."
        made.append(sentence(f"No {kinds} that the mission allows otherwise reaches the {told}{kept}{ends}"))
    needed_m = next((one.needed for one in why.relaxations if one.name == "depth_rating_m"), None)
    if needed_m is not None and factor > 1.0 and needed_m * factor >= asked_m:
        least = math.floor(1e3 * needed_m * factor / asked_m) / 1e3
        made.append(sentence(f"The reserve of depth alone stands in the way: reserve.depth {least:g} would do."))
    return made


def factor_of_depth(mission: Mapping[str, Any]) -> float:
    """What a mission's parts are rated for, over the depth that is asked for."""
    own = [(scene.get("requirements") or {}).get("refuse") for scene in mission.get("scenes") or ()]
    every = (mission.get("requirements") or {}).get("refuse") or ()
    refused = [every if one is None else one for one in own]
    rating_m = (mission.get("limits") or {}).get("depth_rating_m")
    return depth_factor((mission.get("reserve") or {}).get("depth"), refused, rating_m)


def asked_depth_m(mission: Mapping[str, Any]) -> float:
    """The depth that a mission asks parts to be rated for."""
    given = (mission.get("limits") or {}).get("depth_rating_m")
    return float(max(scene["depth_m"] for scene in mission["scenes"]) if given is None else given)


def contradiction_lines(result: Result | FrontResult) -> list[Line]:
    """Requirements that contradict each other, none too many."""
    why = result.infeasible
    names = [] if why is None else why.contradiction or (why.unmet if len(why.unmet) > 1 else [])
    if not names:
        return []
    told = words.listed([words.key_name(name) for name in names])
    if len(names) == 1:
        return [sentence(f"As the scene and the vehicle are, no parts meet this even by itself: {told}.")]
    assert why is not None
    if not why.contradiction:
        said = "As the scene and the vehicle are, no parts meet any of these even by itself: all of them have to give"
        return [sentence(f"{said}: {told}.")]
    if not why.contradiction_is_least:
        return [sentence(f"These contradict each other, and fewer of them may do so already: {told}.")]
    return [sentence(f"These contradict each other; any one of them left out, the rest of them can be met: {told}.")]
