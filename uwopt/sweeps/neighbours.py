"""A mission solved with what its neighbours have found: the same proof and the same row as by itself, in less time.

Bounds, tables and incumbents of earlier missions serve (`solvers.warm`); the best is then evaluated and its settings
are rounded as `solve` does. Where another than the best might be recommended, for what can be set costs the best much,
or where scenarios are to be counted, the mission is solved by itself.
"""

from __future__ import annotations

from dataclasses import replace

from uwopt.api.common import base_result, prepared, selection_warnings
from uwopt.api.floats import own_float_rules
from uwopt.api.search_notes import gain_warnings
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.mission import Mission
from uwopt.objectives.goal import goal_of, taken_instead
from uwopt.solvers.recommend import WORTH_REL, Sought, colour_notes, design_of, hardware_of, value_as_set
from uwopt.solvers.warm.searches import Warm, WarmAnswer
from uwopt.sweeps.rows import NOTHING_FITS, Row, row_of
from uwopt.tolerances import PROVEN_GAP_REL


@own_float_rules
def warm_row(mission: Mission, warm: Warm) -> Row | None:
    """The row of a mission by what its neighbours have found; None where it is to be solved by itself.

    Raises KeyboardInterrupt where a person wants no more.
    """
    wanted = prepared(mission, None, None)
    if wanted.confidence != CENTRAL:
        return None
    answer = warm.best(wanted)
    if answer.interrupted:
        raise KeyboardInterrupt
    if not answer.complete:
        return None
    if answer.found is None or answer.sought is None:
        return nothing_fits(wanted)
    return row_of_best(wanted, answer, answer.sought)


def nothing_fits(mission: Mission) -> Row:
    """The row of a mission that nothing meets."""
    goal = goal_of(mission)
    return {
        "mission": mission.name, "status": "infeasible", "message": NOTHING_FITS, "objective_name": goal.name,
        "objective_unit": goal.unit(mission.limits.currency), "beyond_gain_cap": False, "warnings": "",
    }  # fmt: skip


def row_of_best(mission: Mission, answer: WarmAnswer, sought: Sought) -> Row | None:
    """The row of a mission with its best system; None where another might be recommended."""
    assert answer.found is not None
    goal, best = goal_of(mission), answer.found
    winner = design_of(sought, best, goal)
    if best.minimised < value_as_set(winner, goal) - goal.step(WORTH_REL, best.minimised):
        return None  # the next may be better as it can be set
    gap = goal.share(max(best.minimised - answer.lower_bound, 0.0), best.minimised)
    if gap > PROVEN_GAP_REL:
        return None
    result = replace(
        base_result("solve", mission, goal, sought.problem),
        status="optimal" if winner.is_settable else "feasible",
        recommendation=winner,
        warnings=[
            *selection_warnings(sought.selection),
            *winner.warnings,
            *taken_instead(sought.problem.mission),
            *colour_notes(sought.problem, hardware_of(best)),
            *gain_warnings(mission, sought, winner),
        ],
    )
    return row_of(result) | {"lower_bound": goal.reported(answer.lower_bound), "gap_rel": gap}
