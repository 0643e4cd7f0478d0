"""The two things uwopt does, for Python and for the command line: solve and evaluate."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from uwopt.api.accuracy import (
    Searched,
    accuracy_warnings,
    checked_tolerance,
    estimator_of_search,
    plain_accuracy,
    search_within,
)
from uwopt.api.choosing import Recommendation, chosen_of, held_by_yielding
from uwopt.api.common import (
    Progress,
    Source,
    base_result,
    prepared,
    selection_warnings,
    time_warnings,
)
from uwopt.api.doubting import ToTell, doubted
from uwopt.api.floats import own_float_rules
from uwopt.api.risks import with_risks
from uwopt.api.search_notes import (
    cut_warnings,
    gain_warnings,
    gap_warnings,
    interrupted,
    interruption_warnings,
    on_sale_warnings,
    patience_warnings,
)
from uwopt.api.searching import searched
from uwopt.api.so_far import SoFar, central_line, proven_line, untold
from uwopt.api.timing import timed
from uwopt.api.yielding import GivenWay, gives_way, less_practice_note, with_least_practice, yield_notes
from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import Deadline, processor_s
from uwopt.errors import MissionError
from uwopt.evaluation.breathing import breathing_notes
from uwopt.evaluation.influences import influences_of
from uwopt.forward.assembly import load_catalog
from uwopt.forward.effects import Influence
from uwopt.mission.as_solved import as_solved
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.mission import Mission
from uwopt.mission.yielding import with_yields, yields_of
from uwopt.model.fineness import DEFAULT, Fineness
from uwopt.objectives.goal import goal_of, taken_instead
from uwopt.objectives.objective import Objective
from uwopt.results.design import Note
from uwopt.results.result import Result
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.recommend import (
    BETTER_UNSETTABLE,
    Sought,
    colour_notes,
    design_of,
    hardware_of,
)
from uwopt.solvers.settable.rounding import given_of
from uwopt.tolerances import PROVEN_GAP_REL

EXPLAIN_S = 9.0  # of the processor, for a mission that nothing meets and what would help, where no time is given
EXPLAIN_SHARE = 0.4  # of the time that the search took, where that is more
YIELD_SHARE = 0.3  # of the time for all that would help, for whether less of good practice would do
LEAST_EXPLAIN_S = 5.0  # for what would help, however long the search took: in less hardly any is found
SEARCH_SHARE = 0.9  # of the time that is given: the rest is for settings that can be set
NOT_TRIED = "that nothing fits is proven, but not all that may help was tried"
SOLVERS = ("exact", "casadi", "nlopt", "bonmin")
First = Callable[[Result], None]  # takes a result whose recommendation is proven and not yet doubted


@own_float_rules
def solve(
    mission: Source | Mission,
    *,
    solver: str = "exact",
    objective: str | Mapping[str, float] | None = None,
    physics: str | None = None,
    confidence: float | str | None = None,
    top: int = 5,
    audit: int = 0,
    seconds: float | None = None,
    alternatives: bool = False,
    ranges: bool = False,
    every_price: bool = False,
    accuracy: bool = False,
    tolerance: float | None = None,
    progress: Progress | None = None,
    quick: bool = False,
    first: First | None = None,
    so_far: SoFar = untold,
    explain: bool = True,
) -> Result:
    """The best system for a mission, with a certificate; see the package's documentation.

    Parameters
    ----------
    mission : file name, mapping or Mission
    solver : exact (search with certificate); casadi or nlopt also solve the settings of the best
        hardware again and report what they find; bonmin solves hardware and settings of the best together
    top : how many designs with other hardware to list, the best included
    confidence : share of the scenarios in which hardware must hold, `central` or `ends`, instead of the mission's
    audit : how many other combinations to attack, half of them discarded
    seconds : for all of it: what is proven by then is reported with the gap that is left, and what is told of
        a result beyond its proof is left out where there is no time for it
    alternatives : also say what systems of other makers lack
    ranges : also say up to where the system stays the best as each binding requirement becomes stricter
    every_price : also say what requirements cost that do not bind, and what would be best without each
    accuracy : estimate the numerical error of every figure, in `result.accuracy`
    tolerance : largest error of a figure, a share: integrals are taken as coarsely as it allows
    quick : leave out how firm the answer is, and second opinions
    first : called with the result as soon as its recommendation is proven, before all that is told beyond the proof
    so_far : called with a line whenever something is known that who waits may want to read
    explain : where nothing fits, let give way what good practice has filled in, as little of it as possible, with a
        warning; where nothing fits even so, say why and what would help
    """
    start, since_s, deadline = time.perf_counter(), processor_s(), Deadline.after(seconds)
    for_search = deadline if seconds is None else deadline.at_most(SEARCH_SHARE * seconds)
    if solver not in SOLVERS:
        raise MissionError(f"solver {solver!r} is not one of {', '.join(SOLVERS)}")
    wanted = prepared(mission, physics, objective, confidence)
    checked_tolerance(tolerance)
    goal = goal_of(wanted)
    timing: dict[str, float] = {}
    with timed(timing, "catalogue"):
        catalog = load_catalog(wanted)

    def search(fineness: Fineness, mission: Mission = wanted) -> Searched:
        return searched(mission, catalog, goal, top, for_search, progress, timing, fineness)

    if tolerance is None:
        (sought, alternative), measured = search(DEFAULT), None
    else:
        paper = wanted.physics == "paper"
        sunlit = any(view.scene.sun_lux > 0 for view in wanted.views)
        (sought, alternative), measured = search_within(
            tolerance, search, goal, paper=paper, sunlit=sunlit, deadline=deadline
        )
    given_way, notes = GivenWay(), list[Note]()
    asked, may_yield = wanted, explain and not every_price and bool(yields_of(wanted))
    if not sought.outcome.best and (alternative or sought).outcome.complete and may_yield:
        so_far("nothing meets all of good practice: what of it has to give way is looked for")
        try:
            with timed(timing, "practice", progress):
                given_way = gives_way(wanted, catalog, (alternative or sought).problem, for_search)
        except KeyboardInterrupt:
            explain, notes = False, cut_warnings(NOT_TRIED)
        if given_way.yields:
            wanted = with_yields(wanted, given_way.yields)
            sought, alternative = search(sought.problem.fineness, wanted)
    if not sought.outcome.best:
        result = infeasible_result(
            replace(base_result("solve", wanted, goal, sought.problem), warnings=notes), wanted, catalog, goal,
            sought, alternative, given_way.in_vain, timing, deadline, progress, explain=explain, since_s=since_s,
            would_yield=every_price,
        )  # fmt: skip
    else:
        central = sought
        if wanted.confidence != CENTRAL and sought.outcome.complete:
            so_far(central_line(sought, goal))
        chosen = chosen_of(
            wanted, sought, alternative, goal, deadline, progress, timing, given_way=given_way.yields
        )
        if may_yield:
            look_again = partial(search, sought.problem.fineness)
            chosen = held_by_yielding(asked, chosen, look_again, goal, deadline, progress, timing, so_far)
            wanted = chosen.mission
        result, sought = found_result(
            base_result("solve", wanted, goal, chosen.sought.problem), goal, chosen, timing, deadline, progress,
            solver=solver, first=first, so_far=so_far,
            wanted=ToTell(
                chosen.sought, doubts=not quick, ranges=ranges and not every_price, alternatives=alternatives
            ),
        )  # fmt: skip
        assert result.recommendation is not None
        yielded = gain_warnings(wanted, sought, result.recommendation)
        result = replace(result, warnings=[*result.warnings, *yielded])
        if every_price and central.outcome.complete and not interrupted(result):
            result = priced(result, central, goal, timing, deadline, progress, since_s)
        if measured is None and accuracy and not interrupted(result):
            try:
                estimator = estimator_of_search(sought, goal, deadline)
                with timed(timing, "accuracy", progress):
                    measured = deadline.within(
                        "errors of figures", lambda: estimator.errors(sought.problem.fineness), None
                    )
            except KeyboardInterrupt:
                result = replace(result, warnings=[*result.warnings, *cut_warnings()])
        result = replace(
            result,
            accuracy=plain_accuracy(measured, tolerance or math.inf, result.certificate, result.solvers),
            warnings=[*result.warnings, *accuracy_warnings(measured, tolerance or math.inf)],
        )
    if audit:
        result = audited(result, sought, goal, audit, wanted.seed, timing, deadline)
    timing.update({f"search_{name}": value for name, value in sought.outcome.timing_s.items()})
    timing["total"] = time.perf_counter() - start
    return with_risks(
        replace(result, timing_s=timing, warnings=[*result.warnings, *time_warnings(deadline)])
    )



def found_result(
    result: Result,
    goal: Objective,
    chosen: Recommendation,
    timing: dict[str, float],
    deadline: Deadline,
    progress: Progress | None,
    *,
    solver: str,
    wanted: ToTell,
    first: First | None = None,
    so_far: SoFar = untold,
) -> tuple[Result, Sought]:
    """A result with a recommendation, and the search with what is recommended at its head.

    `first` is called with it before the doubts, unless a person wants no more.
    """
    from uwopt.solvers.explain.assumptions import assumptions

    sought, winner, sure, alternative = chosen.sought, chosen.design, chosen.made_sure, chosen.alternative
    cut_short = chosen.cut or sought.outcome.interrupted
    cut_short |= alternative is not None and alternative.outcome.interrupted
    best = sought.outcome.best[0]
    generic = None
    if alternative is not None and alternative.outcome.best:
        generic = design_of(alternative, alternative.outcome.best[0], goal, deadline=deadline)
    proven = sought.outcome.complete
    hardware = hardware_of(best)
    given = given_of(sought.problem, hardware, best.settings)
    influences = influences_of(sought.problem, hardware, given)
    proof = certificate(sought.selection, sought.problem, chosen.proven, goal)
    wide = proven and (proof.gap_rel or 0.0) > PROVEN_GAP_REL
    second_best = any(warning["code"] == BETTER_UNSETTABLE for warning in winner.warnings)
    surely_best, choice = sure is None or sure.is_best, None if sure is None else sure.choice
    made = replace(
        result,
        physics=replace(result.physics, effects=[item.used() for item in proven_in_full(influences)]),
        confidence=chosen.counted,
        mission_as_solved=as_solved(chosen.mission, chosen.given_way) if chosen.given_way else None,
        status=status_of(proven=proven, exact=winner.is_settable and not wide and surely_best),
        recommendation=winner,
        runners_up=chosen.others,
        generic_alternative=generic,
        certificate=proof,
        assumptions=assumptions(sought.problem, best),
        objective=replace(result.objective, value=winner.objective_value),
        warnings=[
            *yield_notes(chosen.given_way, winner, to_hold=chosen.to_hold),
            *result.warnings,
            *selection_warnings(sought.selection),
            *winner.warnings,
            *breathing_notes(winner.as_set),
            *taken_instead(sought.problem.mission),
            *colour_notes(sought.problem, hardware),
            *(interruption_warnings(sought) or (cut_warnings() if chosen.cut else [])),
            *(gap_warnings(proof) if wide and not second_best else []),
        ],
    )
    if proven and first is None:
        so_far(proven_line(winner, goal, sought.problem.mission.limits.currency))
    if cut_short:
        return made, sought
    if first is not None:
        first(with_risks(made))
    return doubted(made, sought, goal, timing, deadline, progress, solver, choice, wanted), sought


def priced(
    made: Result, sought: Sought, goal: Objective, timing: dict[str, float], deadline: Deadline,
    progress: Progress | None, since_s: float,
) -> Result:  # fmt: skip
    """A result with what every requirement costs, in time; `since_s`: of the processor, when it was asked."""
    from uwopt.api.pricing import every_price

    left_s = max(EXPLAIN_S - (processor_s() - since_s), LEAST_EXPLAIN_S)
    patience = deadline.or_after(left_s, processor_s)
    cut: list[Note] = []
    with timed(timing, "prices", progress):
        prices, complete = every_price(made, sought, goal, patience, progress)
    if not complete:  # what is proven is not lost
        cut = cut_warnings()
    if patience is not deadline:
        cut += patience_warnings(patience, left_s)
    return replace(made, prices=prices, warnings=[*made.warnings, *cut])


def status_of(*, proven: bool, exact: bool) -> str:
    """The status of a result with a recommendation."""
    if not proven:
        return "stopped"
    return "optimal" if exact else "feasible"


def infeasible_result(
    result: Result, mission: Mission, catalog: Catalog, goal: Objective, sought: Sought,
    alternative: Sought | None, weakest: Sought | None, timing: dict[str, float], deadline: Deadline,
    progress: Progress | None, *, explain: bool = True, since_s: float = 0.0, would_yield: bool = False,
) -> Result:  # fmt: skip
    """A result without a recommendation: why, and what would help; `since_s`: of the processor, when it was asked.

    weakest : the search with as little of good practice as may be, which found nothing: then that mission is explained,
        for `solve` lets practice give way where a change makes something fit
    would_yield : make that search here, and say so where it finds something

    Where nobody gave a time, its patience is of the processor: that other programs make it wait takes nothing from it,
    as it would of the wall's clock, though a core that is shared does about half as much in a second. Counted work,
    which is the same everywhere, is no measure here: most of what is done lists and bounds imagers, of which next to
    nothing is counted. So the proof is the same on every machine, but not how much is told beside it.
    """
    from uwopt.solvers.infeasible.trials import Trials
    from uwopt.solvers.infeasible.why_nothing import why_nothing

    used, why = alternative or sought, None
    choice = mission.catalog
    generic = choice.generic_at_first if alternative is None else choice.generic_at_last
    notes, explain = interruption_warnings(used), explain and used.outcome.complete
    spent_s = processor_s() - since_s
    left_s = max(EXPLAIN_S - spent_s, LEAST_EXPLAIN_S, EXPLAIN_SHARE * spent_s)
    patience = deadline.or_after(left_s, processor_s)
    if explain and would_yield:
        turn = patience.at_most(YIELD_SHARE * patience.left_s)
        try:
            with timed(timing, "practice", progress):
                weakest = with_least_practice(mission, catalog, used.problem, turn)
        except KeyboardInterrupt:
            explain, notes = False, cut_warnings(NOT_TRIED)
    if explain and weakest is not None:
        notes = [*notes, less_practice_note(weakest)]
        if weakest.outcome.complete and not weakest.outcome.best:
            used, mission = weakest, with_yields(mission, yields_of(mission))
            result = replace(result, mission=mission.to_dict())
    proof = certificate(used.selection, used.problem, used.outcome, goal)
    if explain:
        trials = Trials(mission.without_gain_cap, catalog, goal, generic, patience, progress, used)
        with timed(timing, "explanation"):
            why = why_nothing(trials, proof)
        if trials.interrupted:
            notes += cut_warnings(NOT_TRIED)
        if patience is not deadline:
            notes += patience_warnings(patience, left_s)
    return replace(
        result,
        status="infeasible" if used.outcome.complete else "stopped",
        certificate=proof,
        infeasible=why,
        warnings=[
            *result.warnings, *notes, *on_sale_warnings(sought, used),
            *selection_warnings(used.selection),
        ],
    )  # fmt: skip


def audited(
    result: Result, sought: Sought, goal: Objective, count: int, seed: int, timing: dict[str, float],
    deadline: Deadline,
) -> Result:  # fmt: skip
    """A result with the outcome of an attack on its certificate."""
    from uwopt.solvers.exact.audit import audit as attack

    best = min((found.minimised for found in sought.outcome.best), default=None)
    with timed(timing, "audit"):
        report = attack(
            sought.search, goal, count=count, seed=seed, best_value=best,
            lower_bound=sought.outcome.lower_bound, deadline=deadline,
        )  # fmt: skip
    return replace(result, audit=report)





def proven_in_full(influences: Sequence[Influence]) -> list[Influence]:
    """What a certified search keeps: every effect that is there at all, whatever `auto` would leave out."""
    return [replace(item, kept=item.bound > 0.0, time_saved_s=0.0) for item in influences]
