"""What would help a mission that nothing meets, beside single requirements: moves, and what contradicts each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uwopt.report.text import formats, words
from uwopt.report.text.layout import Line, sentence
from uwopt.results.basis import Moved
from uwopt.results.result import Result

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult


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
