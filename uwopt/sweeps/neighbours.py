"""A mission solved with what its neighbours have found: the same proof and the same row as by itself, in less time.

Bounds, tables and incumbents of earlier missions serve (`solvers.warm`); the best is then evaluated and its settings
are rounded as `solve` does. Where another than the best might be recommended, for what can be set costs the best much,
or where scenarios are to be counted, the mission is solved by itself. Where nothing fits, good practice gives way as in
`solve`: what did in earlier missions is asked first.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from uwopt.api.common import base_result, prepared, selection_warnings
from uwopt.api.floats import own_float_rules
from uwopt.api.practice_known import PracticeKnown
from uwopt.api.search_notes import gain_warnings
from uwopt.api.yielding import GivenWay, gives_way_alone, in_vain_note, yield_notes
from uwopt.deadline import NEVER
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.mission import Mission
from uwopt.mission.yielding import Yield, with_yields
from uwopt.objectives.goal import goal_of, taken_instead
from uwopt.solvers.recommend import WORTH_REL, Sought, colour_notes, design_of, value_as_set
from uwopt.solvers.warm.searches import Warm, WarmAnswer
from uwopt.sweeps.rows import NOTHING_FITS, Row, row_of, with_gave_way, with_practice_held
from uwopt.tolerances import PROVEN_GAP_REL


@own_float_rules
def warm_row(mission: Mission, warm: Warm, known: PracticeKnown | None = None) -> Row | None:
    """The row of a mission by what its neighbours have found; None where it is to be solved by itself.

    known : what of good practice gave way in them; None: all of it is held

    Raises KeyboardInterrupt where a person wants no more.
    """
    wanted = prepared(mission, None, None)
    if wanted.confidence != CENTRAL:
        return None
    held, answer, given = wanted, warm.best(wanted), GivenWay()
    if answer.complete and answer.found is None and known is not None:
        given = gives_way_alone(wanted, NEVER, known)
        if given.yields:
            held = with_yields(wanted, given.yields)
            answer = warm.best(held)
    if not answer.complete:
        return None
    if answer.found is None or answer.sought is None:
        row = nothing_fits(held, given)
        return row if given.is_in_vain else with_practice_held(row, wanted)
    row = row_of_best(held, answer, answer.sought, given.yields)
    return None if row is None else with_gave_way(row, wanted, held.to_dict())


def nothing_fits(mission: Mission, given: GivenWay) -> Row:
    """The row of a mission that nothing meets."""
    goal = goal_of(mission)
    return {
        "mission": mission.name, "status": "infeasible", "message": NOTHING_FITS, "objective_name": goal.name,
        "objective_unit": goal.unit(mission.limits.currency), "beyond_gain_cap": False,
        "warnings": in_vain_note().code if given.is_in_vain else "",
    }  # fmt: skip


def row_of_best(
    mission: Mission, answer: WarmAnswer, sought: Sought, given_way: Collection[Yield] = ()
) -> Row | None:
    """The row of a mission with its best system; None where another might be recommended."""
    assert answer.found is not None
    goal, best, proven = goal_of(mission), answer.found, sought.outcome.best[0]  # the same, or with more lamps
    winner = design_of(sought, best)
    if best.minimised < value_as_set(winner, goal) - goal.step(WORTH_REL, best.minimised):
        return None  # the next may be better as it can be set
    gap = goal.share(max(proven.minimised - answer.lower_bound, 0.0), proven.minimised)
    if gap > PROVEN_GAP_REL:
        return None
    result = replace(
        base_result("solve", mission, goal, sought.problem),
        status="optimal" if winner.is_settable else "feasible",
        recommendation=winner,
        warnings=[
            *yield_notes(given_way),
            *selection_warnings(sought.selection),
            *winner.warnings,
            *taken_instead(sought.problem.mission),
            *colour_notes(sought.problem, best.hardware),
            *gain_warnings(mission, sought.problem, [winner]),
        ],
    )
    return row_of(result) | {"lower_bound": goal.reported(answer.lower_bound), "gap_rel": gap}
