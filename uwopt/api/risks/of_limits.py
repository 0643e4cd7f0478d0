"""Risks of what is asked for: requirements that fail, or may once estimates turn out badly."""

from __future__ import annotations

from uwopt.api.risks.margins import (
    OFF_FOCUS,
    asked_name,
    in_hand_names,
    in_words,
    missed_figure,
    sharp_where,
    tight,
    tight_figure,
)
from uwopt.api.risks.worst import Weighed
from uwopt.quantities import LOST_TO
from uwopt.results.basis import MISSED, MISSED_OF_PRACTICE, Risk
from uwopt.results.design import PRACTICE_MISSED, Design
from uwopt.results.result import Result
from uwopt.units import counted, percent


def missed(result: Result, design: Design) -> Weighed:
    """Requirements that fail as it stands."""
    by, because = "asked for", MISSED
    if any(note.code == PRACTICE_MISSED for note in result.warnings):
        by, because = "good practice asks", MISSED_OF_PRACTICE
    for name, margin in {asked_name(m): m for m in design.missed}.items():
        yield 100.0, Risk(f"{name} is not as {by}", because, missed_figure(margin, sharp_where(result)))


def uncertain(result: Result, design: Design) -> Weighed:
    """That it holds less often than was asked for."""
    known = result.confidence
    if known is None or known.enough:
        return
    because = f"settings that meet every requirement exist in {percent(known.held)} of the scenarios"
    if known.lost_to:
        first = known.lost_to[0].requirement
        because += f"; else {LOST_TO.get(first, in_words(first))} is missed first"
    wanted = "all ends" if known.asked == "ends" else f"{100.0 * float(known.asked):g} % asked"
    yield 95.0, Risk("it may not do what is asked", because, wanted)


def at_bad_ends(result: Result, design: Design) -> Weighed:
    """Requirements that may fail when estimated numbers turn out badly."""
    if result.confidence is not None or (result.robustness or {}).get("feasible_at_bad_end") is not False:
        return  # what was counted in scenarios says more
    number = sum(
        1 for item in result.assumptions if item.low != item.high and not item.path.endswith(".price")
    )
    because = "with its estimated numbers at the bad ends of their ranges a requirement is missed"
    if names := in_hand_names(design):
        because += f", for there is no margin in {names}"
    yield 80.0, Risk("it may not do what is asked", because, counted(number, "estimated number"))


def nothing_in_hand(result: Result, design: Design) -> Weighed:
    """Requirements that are met to the last digit; where estimates tell the same, they do."""
    least = tight(design)
    if result.confidence is not None and result.confidence.enough:
        return  # settings are found anew where the scenario asks for others
    if not least or (result.robustness or {}).get("feasible_at_bad_end") is False:
        return
    because = (
        f"there is no margin in {in_hand_names(design)}: whatever is a little worse than computed misses it"
    )
    if (end := least[0].key) in OFF_FOCUS:
        because += f"; {OFF_FOCUS[end]}{sharp_where(result)}"
    yield 52.0, Risk("it may not do what is asked", because, tight_figure(least[0], sharp_where(result)))
