"""`uwopt.solve`: the best system for a mission, with a certificate."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from uwopt.api.accuracy import (
    accuracy_warnings,
    checked_tolerance,
    estimator_of_search,
    plain_accuracy,
    search_within,
)
from uwopt.api.choosing import chosen_of, held_by_yielding
from uwopt.api.common import Source, check_count, prepared, time_warnings
from uwopt.api.doubting import ToTell, doubted, others_in_time
from uwopt.api.explaining import infeasible_result, priced
from uwopt.api.floats import own_float_rules
from uwopt.api.practice_known import PracticeKnown
from uwopt.api.recommendation import Recommendation
from uwopt.api.recommending import recommended
from uwopt.api.risks.told import with_risks
from uwopt.api.search_notes import cut_warnings, gain_warnings, interrupted
from uwopt.api.searching import SETTINGS_SHARE, Searched, Searches
from uwopt.api.so_far import PRACTICE_LINE, central_line, proven_line
from uwopt.api.watch import SoFar, Watch, untold
from uwopt.api.yielding import gives_way
from uwopt.deadline import Progress
from uwopt.errors import MissionError
from uwopt.evaluation.accuracy import Accuracy
from uwopt.forward.assembly import load_catalog
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.mission import Mission
from uwopt.mission.yielding import with_yields, yields_of
from uwopt.objectives.goal import goal_of
from uwopt.results.design import Note
from uwopt.results.result import Result
from uwopt.solvers.recommend import Sought

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
    hold_practice: bool = False,
    known: PracticeKnown | None = None,
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
    explain : where nothing fits even with as little of good practice as may be, say why and what would help
    hold_practice : hold what good practice has filled in, where nothing fits with all of it too: else as little of it
        as possible gives way then, with a warning
    known : what gave way in missions like this, which is asked first; what does here goes into it
    """
    watch = Watch.begun(seconds, progress, so_far)
    until = watch.deadline.but_for(SETTINGS_SHARE)
    if solver not in SOLVERS:
        raise MissionError(f"solver {solver!r} is not one of {', '.join(SOLVERS)}")
    check_count("top", top, 1)
    check_count("audit", audit, 0)
    asked = prepared(mission, physics, objective, confidence)
    checked_tolerance(tolerance)
    goal = goal_of(asked)
    with watch.timed("catalogue"):
        searches = Searches(load_catalog(asked), goal, top, watch.until(until))
    found, measured = found_within(tolerance, asked, searches, watch)
    searches = replace(searches, fineness=found.sought.problem.fineness)
    may_yield = not hold_practice and not every_price and bool(yields_of(asked))
    if may_yield and found.proves_nothing_fits:
        found = with_less_practice(found, searches, watch, known)
    if not found.fits:
        held, sought = every_price or hold_practice, found.sought
        result = infeasible_result(found, searches.catalog, watch, explain, held)
        return ended(audited(result, sought, audit, watch), sought, watch)
    if asked.confidence != CENTRAL and found.sought.outcome.complete:
        so_far(central_line(found.sought))
    chosen = chosen_of(found, watch)
    if may_yield:
        chosen = held_by_yielding(asked, chosen, searches, watch)
    wanted = ToTell(solver, doubts=not quick, ranges=ranges and not every_price, alternatives=alternatives)
    result, sought = told_of(chosen, wanted, watch, first), chosen.sought
    if every_price and found.sought.outcome.complete and not interrupted(result):
        result = priced(result, found.sought, watch)
    result = with_accuracy(result, sought, tolerance, measured, watch, measure=accuracy)
    return ended(audited(result, sought, audit, watch), sought, watch)


def found_within(
    tolerance: float | None, mission: Mission, searches: Searches, watch: Watch
) -> tuple[Searched, Accuracy | None]:
    """What a search finds, with integrals as coarse as is allowed, and what they err by; None: with usual ones."""
    if tolerance is None:
        return searches.of(mission), None
    return search_within(
        tolerance, mission, lambda fineness: replace(searches, fineness=fineness).of(mission), watch.deadline
    )


def with_less_practice(
    nothing: Searched, searches: Searches, watch: Watch, known: PracticeKnown | None = None
) -> Searched:
    """What is found where as little of good practice gives way as has to; what was found before where that is in vain.

    nothing : proves that nothing meets all of it
    known : what gave way in missions like this
    """
    if nothing.cut:
        return nothing
    watch.so_far(PRACTICE_LINE)
    mission = nothing.mission
    try:
        with watch.stage("practice"):
            given_way = gives_way(mission, searches.catalog, nothing.widest.problem, searches.watch.deadline, known)
    except KeyboardInterrupt:
        return replace(nothing, cut=True)
    if not given_way.yields:
        return replace(nothing, in_vain=given_way.in_vain, is_in_vain=given_way.is_in_vain)
    found = searches.of(with_yields(mission, given_way.yields), scenes_of=nothing.widest.problem, fits=True)
    return replace(found, given_way=given_way.yields, in_vain=given_way.in_vain)


def told_of(chosen: Recommendation, wanted: ToTell, watch: Watch, first: First | None) -> Result:
    """The result, with what is told of it beyond its proof; `first` is called with it before that.

    Unless a person wants no more.
    """
    made = recommended(chosen)
    if chosen.is_proven and first is None:
        watch.so_far(proven_line(chosen))
    if not chosen.is_cut_short:
        if first is not None:
            first(with_risks(made))
        made = doubted(made, chosen, wanted, watch)
    if interrupted(made) and not made.runners_up and not chosen.cut and chosen.listed is not None:
        with contextlib.suppress(KeyboardInterrupt):  # they were found, and take a moment
            made = replace(made, runners_up=others_in_time(chosen.listed, watch.deadline))
    beyond = gain_warnings(chosen.mission, chosen.sought.problem, [chosen.design])
    return replace(made, warnings=[*made.warnings, *beyond])


def with_accuracy(
    result: Result, sought: Sought, tolerance: float | None, measured: Accuracy | None, watch: Watch, *, measure: bool
) -> Result:
    """A result with its gap, and what its figures may err by where that is measured, or to be."""
    notes = list[Note]()
    if measure and measured is None and not interrupted(result):
        try:
            estimator = estimator_of_search(sought, watch.deadline)
            measured = watch.within("accuracy", lambda _: estimator.errors(sought.problem.fineness), None)
        except KeyboardInterrupt:
            notes = cut_warnings()
    allowed = tolerance or math.inf
    return replace(
        result,
        accuracy=plain_accuracy(measured, allowed, result.certificate, result.solvers),
        warnings=[*result.warnings, *notes, *accuracy_warnings(measured, allowed)],
    )


def audited(result: Result, sought: Sought, count: int, watch: Watch) -> Result:
    """A result with the outcome of an attack on its certificate by so many combinations, if any."""
    if not count:
        return result
    from uwopt.solvers.exact.audit import audit

    outcome = sought.outcome
    with watch.timed("audit"):
        report = audit(
            sought.search, sought.goal, count=count, seed=sought.problem.mission.seed, deadline=watch.deadline,
            best_value=min((found.minimised for found in outcome.best), default=None), lower_bound=outcome.lower_bound,
        )  # fmt: skip
    return replace(result, audit=report)


def ended(result: Result, sought: Sought, watch: Watch) -> Result:
    """A result with its risks, how long its stages took, and what there was no time for."""
    searched_s = {f"search_{name}": value for name, value in sought.outcome.timing_s.items()}
    notes = [*result.warnings, *time_warnings(watch.deadline)]
    return with_risks(replace(result, timing_s=watch.total(searched_s), warnings=notes))
