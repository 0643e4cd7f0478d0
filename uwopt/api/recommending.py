"""The result of a search that found something: what is recommended, with its proof."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from uwopt.api.common import base_result, selection_warnings
from uwopt.api.recommendation import Recommendation
from uwopt.api.search_notes import cut_warnings, gap_warnings, interruption_warnings
from uwopt.api.yielding import yield_notes
from uwopt.evaluation.breathing import breathing_notes
from uwopt.evaluation.influences import influences_of
from uwopt.forward.effects import Influence
from uwopt.mission.as_solved import as_solved
from uwopt.objectives.goal import taken_instead
from uwopt.results.result import Result
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.explain.assumptions import assumptions
from uwopt.solvers.recommend import BETTER_UNSETTABLE, colour_notes
from uwopt.solvers.settable.rounding import given_of
from uwopt.tolerances import PROVEN_GAP_REL


def recommended(chosen: Recommendation) -> Result:
    """The result, before anything is told beyond the proof."""
    sought, winner, mission = chosen.sought, chosen.design, chosen.mission
    problem, goal, best = sought.problem, sought.goal, sought.outcome.best[0]
    hardware = best.hardware
    influences = influences_of(problem, hardware, given_of(problem, hardware, best.settings))
    proof = certificate(sought.selection, problem, chosen.proven, goal)
    wide = chosen.is_proven and (proof.gap_rel or 0.0) > PROVEN_GAP_REL
    second_best = any(warning["code"] == BETTER_UNSETTABLE for warning in winner.warnings)
    exact = winner.is_settable and not wide and chosen.is_best
    base = base_result("solve", mission, goal, problem)
    return replace(
        base,
        physics=replace(base.physics, effects=[item.used() for item in proven_in_full(influences)]),
        confidence=chosen.counted,
        mission_as_solved=as_solved(mission, chosen.given_way) if chosen.given_way else None,
        status=solve_status(proven=chosen.is_proven, exact=exact),
        recommendation=winner,
        certificate=proof,
        assumptions=assumptions(problem, best),
        objective=replace(base.objective, value=winner.objective_value),
        warnings=[
            *yield_notes(chosen.given_way, winner, to_hold=chosen.to_hold),
            *selection_warnings(sought.selection),
            *winner.warnings,
            *breathing_notes(winner.as_set),
            *taken_instead(problem.mission),
            *colour_notes(problem, hardware),
            *(interruption_warnings(sought) or (cut_warnings() if chosen.cut else [])),
            *(gap_warnings(proof) if wide and not second_best else []),
        ],
    )


def solve_status(*, proven: bool, exact: bool) -> str:
    """The status of a result with a recommendation."""
    if not proven:
        return "stopped"
    return "optimal" if exact else "feasible"


def proven_in_full(influences: Sequence[Influence]) -> list[Influence]:
    """What a certified search keeps: every effect that is there at all, whatever `auto` would leave out."""
    return [replace(item, kept=item.bound > 0.0, time_saved_s=0.0) for item in influences]
