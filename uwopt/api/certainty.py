"""The recommendation that holds in the doubt, which `solve` takes in place of the central optimum."""

from __future__ import annotations

from dataclasses import replace

from uwopt.api.common import Progress
from uwopt.api.timing import STAGES, timed
from uwopt.deadline import Deadline
from uwopt.mission.doubt import CENTRAL, ENDS
from uwopt.objectives.objective import Objective
from uwopt.results.certainty import Confidence
from uwopt.results.design import Design, Note
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.recommend import Sought, design_of

NOT_CERTAIN = "not_certain"  # code of the warning that nothing holds as often as asked
AS_CENTRAL = "certainty_left_out"  # that there was no time for it


def with_confidence(
    sought: Sought, winner: Design, goal: Objective, deadline: Deadline, progress: Progress | None,
    timing: dict[str, float],
) -> tuple[Sought, Design, Confidence | None]:  # fmt: skip
    """What is recommended at the mission's confidence: the search with it at its head, its design, what was counted.

    Where numbers are taken as central, the central optimum.
    """
    from uwopt.solvers.confidence.search import most_certain
    from uwopt.solvers.confidence.summary import told

    asked, problem = sought.problem.mission.confidence, sought.problem
    if asked == CENTRAL or not sought.outcome.best:
        return sought, winner, None
    with timed(timing, "certainty", progress):
        certain = deadline.within(
            STAGES["certainty"], lambda: most_certain(sought, goal, asked, deadline, progress), None
        )
    first = sought.outcome.best[0]
    if certain is None:
        text = "no time was left to count scenarios: this is the best by central numbers"
        note = Note(AS_CENTRAL, "confidence", text)
        return sought, replace(winner, warnings=[note, *winner.warnings]), None
    with timed(timing, "certainty", progress):
        found, stop = certain.central, certain.best.f_number
        as_set = replace(sought, problem=problem if stop is None else problem.at_f_number(stop))
        design = design_of(as_set, found, goal, deadline=deadline)
        counted = told(problem, goal, certain, first, ends=asked == ENDS)
    if not certain.enough:
        share = "every end" if asked == ENDS else f"{100.0 * certain.asked:g} % of the scenarios"
        text = f"nothing that was counted holds in {share}; this does in {100.0 * counted.held_in_choice:.0f} %"
        design = replace(design, warnings=[Note(NOT_CERTAIN, "confidence", text), *design.warnings])
    others = [one for one in sought.outcome.best if not same_hardware(one, found)]
    outcome = replace(sought.outcome, best=[found, *others])
    return replace(sought, outcome=outcome), design, counted


def same_hardware(one: Found, other: Found) -> bool:
    """Whether two designs are of the same parts, as many lamps, mounted alike."""
    names = ("camera", "lens", "port", "light", "count", "landscape", "lighting")
    return all(getattr(one, name) == getattr(other, name) for name in names)


