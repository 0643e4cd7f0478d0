"""What would help a mission that nothing meets, beside single requirements: moves, and what contradicts each other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from uwopt.mission.reserves import depth_factor
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Line, sentence
from uwopt.results.basis import Moved
from uwopt.results.result import Result

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult

OF_DEPTH = ": depth rating"  # how what excludes a kind of part by its rating ends


def move_lines(result: Result | FrontResult) -> list[Line]:
    """Speed, water or height at which the mission could be met as it is."""
    moves = result.infeasible.moves if result.infeasible is not None else []
    if not moves:
        return []
    told = words.listed([move_text(move) for move in moves])
    these = "each of these" if len(moves) > 1 else "this"
    return [sentence(f"Moved alone, all else as asked, {these} would do: {told}.")]


def move_text(move: Moved) -> str:
    """`altitude_m 5.00 -> 3.15 m`, and whether less is known not to do."""
    name = formats.one_line(move.name, 40)
    if isinstance(move.asked, str) or isinstance(move.needed, str):
        text = f"{name} {formats.one_line(move.asked, 20)} -> {formats.one_line(move.needed, 20)}"
    else:
        asked, needed = formats.quantities_apart(move.asked, move.needed, unit=move.unit, digits=4)
        text = f"{name} {asked} -> {needed}"
    return text if move.nearest else f"{text} (less may do)"


def depth_lines(result: Result | FrontResult) -> list[Line]:
    """That no part of a kind is rated deep enough with its reserve, or that this alone stands in the way."""
    why, factor = result.infeasible, factor_of_depth(result.mission)
    names = [item.name for item in why.requirements] if why else []
    if why is None or not any(name.endswith(OF_DEPTH) for name in names):
        return []
    asked_m, kept = asked_depth_m(result.mission), ""
    told = f"{formats.quantity(asked_m * factor, 'm', 4)} that they must be rated for"
    if factor > 1.0:
        kept = f" ({formats.quantity(asked_m, 'm', 4)} asked for, times {factor:g} kept in reserve: reserve.depth)"
    made: list[Line] = []
    last = names[-1].partition(": ")[0]  # the kind of which none is left, where none is
    if all(": " in name for name in names) and last + OF_DEPTH in names:
        made.append(sentence(f"No {last} that the mission allows otherwise reaches the {told}{kept}."))
    needed_m = next((one.needed for one in why.relaxations if one.name == "depth_rating_m"), None)
    if needed_m is not None and factor > 1.0 and needed_m * factor >= asked_m:
        least = math.floor(1e3 * needed_m * factor / asked_m) / 1e3
        made.append(sentence(f"The reserve of depth alone stands in the way: reserve.depth {least:g} would do."))
    return made


def factor_of_depth(mission: Mapping[str, Any]) -> float:
    """What a mission's parts are rated for, over the depth that is asked for."""
    own = [(scene.get("requirements") or {}).get("refuse") for scene in mission.get("scenes") or ()]
    every = (mission.get("requirements") or {}).get("refuse") or ()
    return depth_factor((mission.get("reserve") or {}).get("depth"), [every if one is None else one for one in own])


def asked_depth_m(mission: Mapping[str, Any]) -> float:
    """The depth that a mission asks parts to be rated for."""
    given = (mission.get("limits") or {}).get("depth_rating_m")
    return float(max(scene["depth_m"] for scene in mission["scenes"]) if given is None else given)


def contradiction_lines(result: Result | FrontResult) -> list[Line]:
    """Requirements that contradict each other, none too many."""
    names = result.infeasible.contradiction if result.infeasible is not None else []
    if not names:
        return []
    told = words.listed([f"{words.requirement_name(name)} ({formats.one_line(name)})" for name in names])
    if len(names) == 1:
        return [sentence(f"No parts meet this alone, whatever else is asked: {told}.")]
    assert result.infeasible is not None
    if not result.infeasible.contradiction_is_least:
        return [sentence(f"These contradict each other, and fewer of them may do so already: {told}.")]
    return [sentence(f"These contradict each other; any one of them left out, the rest of them can be met: {told}.")]
