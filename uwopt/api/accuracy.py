"""How exact a result is: estimated errors of its figures, and integrals no finer than a tolerance asks for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from numbers import Real
from typing import TYPE_CHECKING, Any

from uwopt.deadline import Deadline
from uwopt.errors import MissionError
from uwopt.evaluation.accuracy import Accuracy, Estimator, coarsest, parts_that_count
from uwopt.evaluation.design import evaluate_design
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.model.fineness import DEFAULT, Fineness
from uwopt.results.basis import Opinion
from uwopt.results.design import Design, Note
from uwopt.results.record import plain as plain_values
from uwopt.results.result import Certificate

if TYPE_CHECKING:  # what a given system is evaluated for has no use for a search
    from uwopt.api.searching import Searched
    from uwopt.solvers.recommend import Sought

MOST_SEARCHES = 4  # at rising fineness, until the errors of what is found are within the tolerance
LARGEST_TOLERANCE = 0.5
OF_INTEGRALS = 0.5  # of the tolerance, where physics `auto` may leave out effects for the rest


def of_integrals(tolerance: float, *, may_leave_out: bool) -> float:
    """What integrals may err by; physics `auto` has the rest for the effects that an evaluation leaves out."""
    return tolerance * OF_INTEGRALS if may_leave_out else tolerance


def checked_tolerance(tolerance: Any) -> float | None:
    """A tolerance above 0 and at most 0.5."""
    if tolerance is None:
        return None
    known = isinstance(tolerance, Real)
    if not known or not 0.0 < float(tolerance) <= LARGEST_TOLERANCE:
        shown = f"{tolerance:g}" if known else repr(tolerance)
        raise MissionError(
            f"tolerance = {shown} is no share above 0 and at most {LARGEST_TOLERANCE:g}; 0.001 asks for 0.1 %"
        )
    return float(tolerance)


def estimator_of_search(sought: Sought, deadline: Deadline) -> Estimator:
    """Errors of the best design of a search: of figures with its settings, of the objective with the best ones."""
    from uwopt.solvers.one_hardware import best_of, problem_of
    from uwopt.solvers.settable.rounding import given_of
    from uwopt.solvers.settings.best import scenes_need_cells

    found, problem, goal = sought.outcome.best[0], sought.problem, sought.goal
    slow = scenes_need_cells(problem.scenes, goal)
    small = problem_of(problem, found)
    hardware = found.hardware.alone
    given = given_of(problem, found.hardware, found.settings)

    def evaluate(at: Problem) -> Design:
        deadline.check()
        design = evaluate_design(at, hardware, given, goal)
        if slow:  # searched to a gap; the value at fixed settings tells of quality, but not of power
            return replace(design, objective_value=None) if goal.weight("power") else design
        value = best_of(at, goal, deadline)
        told = goal.told(value)
        return replace(design, objective_value=told)

    return estimator_of(small, evaluate)


def estimator_of(problem: Problem, evaluate: Callable[[Problem], Design]) -> Estimator:
    """Errors of a design that `evaluate` works out over the same parts at another fineness."""
    return Estimator(
        lambda fineness: evaluate(
            problem if fineness == problem.fineness else problem.with_fineness(fineness)
        ),
        paper=problem.paper,
        sunlit=any(scene.sunlit for scene in problem.scenes) and problem.effects.sunlight,
    )


def search_within(
    tolerance: float, mission: Mission, search: Callable[[Fineness], Searched], deadline: Deadline
) -> tuple[Searched, Accuracy | None]:
    """Search with integrals as coarse as the tolerance allows at the design that is found.

    Begins with coarse ones; where the errors at the winner are too large, the parts that make them are taken
    more finely and all is searched again. Without a winner there is nothing to measure: then at the default.
    """
    sunlit = any(view.scene.sun_lux > 0 for view in mission.views)
    fineness = coarsest(parts_that_count(paper=mission.physics == "paper", sunlit=sunlit))
    measured = None
    for _ in range(MOST_SEARCHES):
        found = search(fineness)
        sought = found.sought
        if not found.fits:
            return (found if fineness == DEFAULT or not sought.outcome.complete else search(DEFAULT)), None
        estimator = estimator_of_search(sought, deadline)
        measured = deadline.within(
            "errors of figures", partial(estimator.cheapest, tolerance, fineness), None
        )
        if measured is None or measured.fineness == fineness or not sought.outcome.complete:
            break
        fineness = measured.fineness
    return found, measured


def plain_accuracy(
    measured: Accuracy | None,
    tolerance: float,
    proof: Certificate | None,
    opinions: list[Opinion],
) -> dict[str, Any]:
    """A result's section: always gap and residual of a search, and the estimated errors where asked for.

    `tolerance`: of the integrals; inf where none was asked for.
    """
    plain: dict[str, Any] = {}
    if proof is not None:
        residuals = [word.kkt_residual for word in opinions if word.kkt_residual is not None]
        plain = {
            "gap_abs": proof.gap_abs,
            "gap_rel": proof.gap_rel,
            "kkt_residual": max(residuals) if residuals else None,
        }
    if measured is not None:
        plain.update(plain_values(measured.as_dict()))
        if math.isfinite(tolerance):
            plain.update(tolerance=tolerance, meets_tolerance=measured.meets(tolerance))
    return plain


def accuracy_warnings(measured: Accuracy | None, tolerance: float) -> list[Note]:
    """That the tolerance could not be met, and by which figure."""
    if measured is None or measured.meets(tolerance):
        return []
    worst = measured.largest
    text = (
        f"{worst['figure']} may err by {worst['error_rel']:.1e}, more than the {tolerance:g} that is asked of "
        "integrals, with the finest that are tried"
    )
    return [Note("tolerance", "tolerance", text)]
