"""What is told beyond an answer: of a mission that nothing meets why, and what would help; of others what all costs."""

from __future__ import annotations

from dataclasses import replace

from uwopt.api.common import base_result, selection_warnings
from uwopt.api.practice_left import with_practice_left
from uwopt.api.search_notes import cut_warnings, interruption_warnings, on_sale_warnings, patience_warnings
from uwopt.api.searching import Searched
from uwopt.api.watch import Watch
from uwopt.api.yielding import in_vain_note, less_practice_note, patience_of, with_least_practice
from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import processor_s
from uwopt.mission.yielding import with_yields, yields_of
from uwopt.results.result import Result
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.recommend import Sought

EXPLAIN_S = 8.8  # of the processor, for a mission that nothing meets and what would help, where no time is given
LEFT_SHARE = 0.2  # of the time, for what of good practice gives way where a told change is made
LEAST_EXPLAIN_S = 6.0  # for what would help, however long the search took: in less hardly any is found
GO_ON_SHARE = 3.0  # of the time for what would help, beside it, where nothing is known to by then
NOT_TRIED = "that nothing fits is proven, but not all that may help was tried"


def left_s(watch: Watch) -> float:
    """Seconds of the processor for an explanation where no time is given: a quicker search never leaves it less.

    That other programs make it wait takes nothing from it, as it would of the wall's clock, though a core that is
    shared does about half as much in a second. Counted work, which is the same everywhere, is no measure here: most of
    what is done lists and bounds imagers, of which next to nothing is counted. So the proof is the same on every
    machine, but not how much is told beside it.
    """
    return max(EXPLAIN_S - (processor_s() - watch.since_s), LEAST_EXPLAIN_S)


def priced(made: Result, sought: Sought, watch: Watch) -> Result:
    """A result with what every requirement costs, in time; `sought`: the search at likeliest values."""
    from uwopt.api.pricing import every_price

    seconds = left_s(watch)
    patience = watch.deadline.or_after(seconds, processor_s)
    with watch.stage("prices"):
        prices, complete = every_price(made, sought, patience, watch.progress)
    notes = [] if complete else cut_warnings()  # what is proven is not lost
    if patience is not watch.deadline:
        notes += patience_warnings(patience, seconds, watch.began_s)
    return replace(made, prices=prices, warnings=[*made.warnings, *notes])


def infeasible_result(
    found: Searched, catalog: Catalog, watch: Watch, explain: bool, would_yield: bool
) -> Result:
    """A result without a recommendation: why, and what would help.

    Where nothing fits even with as little of good practice as may be, that mission is explained, for `solve` lets
    practice give way where a change makes something fit. Whether it does is asked as long as `solve` asks it, so that
    both explain the same mission, and is no part of the time for what would help.

    would_yield : search with so little of it here, and say so where something is found
    """
    from uwopt.solvers.infeasible.none_left import none_left, stays_empty
    from uwopt.solvers.infeasible.trials import Trials
    from uwopt.solvers.infeasible.why_nothing import why_nothing

    goal, used, mission, weakest, why = found.sought.goal, found.widest, found.mission, found.in_vain, None
    choice = mission.catalog
    generic = choice.generic_at_first if found.alternative is None else choice.generic_at_last
    notes = [*(cut_warnings(NOT_TRIED) if found.cut else []), *interruption_warnings(used)]
    explain = explain and not found.cut and used.outcome.complete
    empty = stays_empty(none_left(mission, used.selection))  # then practice is not what stands in the way
    if empty:
        weakest = None
    elif explain and would_yield:
        try:
            with watch.stage("practice"):
                weakest = with_least_practice(mission, catalog, used.problem, patience_of(watch.deadline))
        except KeyboardInterrupt:
            explain, notes = False, cut_warnings(NOT_TRIED)
    if explain and weakest is not None:
        notes = [*notes, less_practice_note(weakest)]
        if weakest.outcome.complete and not weakest.outcome.best:
            used, mission = weakest, with_yields(mission, yields_of(mission))
    elif found.is_in_vain and not empty:
        notes = [*notes, in_vain_note()]
    proof = certificate(used.selection, used.problem, used.outcome, goal)
    seconds = left_s(watch)
    patience = watch.deadline.or_after(seconds, processor_s)
    if explain:
        in_vain = mission is not found.mission
        first = patience.but_for(LEFT_SHARE) if in_vain else patience
        more_s = 0.0 if patience is watch.deadline else GO_ON_SHARE * seconds
        trials = Trials(mission.without_gain_cap, catalog, goal, generic, first, watch.progress, used, more_s)
        with watch.timed("explanation"):
            why = why_nothing(trials, proof)
            if more_s and not trials.more_s:
                patience, seconds = replace(patience, end_s=patience.end_s + more_s), seconds + more_s
            if in_vain and not trials.interrupted:
                why = with_practice_left(why, found.mission, catalog, used.problem, patience)
        if trials.interrupted:
            notes += cut_warnings(NOT_TRIED)
        if patience is not watch.deadline:
            notes += patience_warnings(patience, seconds, watch.began_s)
    return replace(
        base_result("solve", mission, goal, found.sought.problem),
        status="infeasible" if used.outcome.complete else "stopped",
        certificate=proof,
        infeasible=why,
        warnings=[*notes, *on_sale_warnings(found.sought, used), *selection_warnings(used.selection)],
    )
