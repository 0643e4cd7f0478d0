"""What is told of a proven recommendation: how firm it is, what its requirements cost, and what stands beside it.

What does not need each other is worked out side by side where there are cores for it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from uwopt.api.search_notes import cut_warnings, patience_warnings
from uwopt.api.searching import leaves_out_generic, much_better_if_made
from uwopt.api.watch import STAGES, Watch
from uwopt.deadline import Deadline, PatientClock, processor_s
from uwopt.results.basis import LessMoney, Opinion, Price
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.solvers.beside import side_by_side
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.recommend import Sought, design_of

if TYPE_CHECKING:
    from uwopt.api.recommendation import Recommendation
    from uwopt.solvers.confidence.search import Certain

DOUBTS_SHARE = 0.25  # of what the answer itself took, where that is more
DOUBTS_S = 6.0  # of the processor, for how firm a proven answer is, where no time is given
EQUAL = "which systems are equal within the estimates"


@dataclass(frozen=True)
class ToTell:
    """What is to be told beside the proof.

    solver : whose opinion of its settings is asked
    doubts : how firm the answer is, and second opinions
    """

    solver: str
    doubts: bool = True
    ranges: bool = False  # up to where the system stays the best as each binding requirement becomes stricter
    alternatives: bool = False  # what systems of other makers lack


def left_of(made: Result) -> str:
    """What of a proven answer was worked out before a person ended it, and what was not."""
    there = {"robustness": made.robustness is not None, "second_opinion": made.solvers, "prices": made.prices}
    done, left = ([STAGES[name] for name, told in there.items() if bool(told) is so] for so in (True, False))
    told = f"; of its doubts this was worked out: {', '.join(done)}" if done else ""
    return f"the system is proven{told}" + (f"; not, or not all: {', '.join(left)}" if left else "")


def doubted(made: Result, chosen: Recommendation, wanted: ToTell, watch: Watch) -> Result:
    """A result with how firm it is, what more power and money would buy, and second opinions, in time."""
    from uwopt.solvers.explain.knee import knee

    sought, cut = chosen.sought, False
    clock = PatientClock()
    seconds = doubts_s(watch)
    patient = watch.until(watch.deadline.or_after(seconds, clock))
    try:
        if wanted.doubts and sought.goal.quality:
            made = replace(made, knee=watch.within("knee", lambda limit: knee(sought, limit), None))
        if wanted.doubts:
            watch.progress(0.0, STAGES["robustness"])
        with watch.timed("robustness"):
            made, cut = told_together(made, chosen, wanted, watch, patient.deadline, clock)
    except KeyboardInterrupt:  # what is proven is not lost
        cut = True
    notes = cut_warnings(left_of(made)) if cut else []
    if patient.deadline is not watch.deadline:
        notes += patience_warnings(patient.deadline, seconds, watch.began_s)
    return replace(made, warnings=[*made.warnings, *notes])


def doubts_s(watch: Watch) -> float:
    """Seconds of the processor for how firm an answer is, where no time is given: more where that took long itself."""
    return max(DOUBTS_S, DOUBTS_SHARE * (processor_s() - watch.since_s))


def told_together(
    made: Result, chosen: Recommendation, wanted: ToTell, watch: Watch, patience: Deadline, clock: PatientClock
) -> tuple[Result, bool]:
    """A result with how firm it is and what stands beside it, side by side, in time; whether a person wants no more.

    What is known by then stays; second opinions and prices are worked out first.

    patience : for how firm it is, on the clock where nobody has set a time
    """
    sought, choice, deadline = chosen.sought, chosen.choice, watch.deadline
    doubts = doubts_of(sought, chosen.design, patience, choice) if wanted.doubts else {}
    works: dict[str, Callable[[], Any]] = {}
    counted = made.confidence
    costs = "second_opinion" if wanted.doubts else "ranges"  # what it begins with
    if wanted.doubts or wanted.ranges:
        works[costs] = partial(costed, made, chosen, wanted, deadline, patience, clock)
    is_of_sold = sought.of_all_kinds is None and leaves_out_generic(sought)  # else none gains enough
    if sought.outcome.complete and is_of_sold:
        works["search_generic"] = partial(
            deadline.within, STAGES["search_generic"], lambda: if_made(sought, chosen.proven, deadline), None
        )
    if wanted.doubts and counted is not None and choice is not None and not counted.enough:
        from uwopt.api.raised import eased_or_raised

        works["eased"] = partial(eased_or_raised, sought, counted, choice, chosen.counts, deadline)
    if wanted.doubts and sought.outcome.complete:
        cheapest = partial(for_less_money, sought, choice, deadline)
        works["less_money"] = partial(deadline.within, STAGES["less_money"], cheapest, None)
    if chosen.listed is not None:
        works["next_best"] = partial(others_in_time, chosen.listed, deadline)
    works = {name: work if name == costs else partial(clock.stand_still, work) for name, work in works.items()}
    works |= doubts
    if wanted.alternatives and sought.outcome.complete:
        works["alternatives"] = partial(beside_it, made, sought, deadline)
    lists = [deadline.left_out] if patience is deadline else [deadline.left_out, patience.left_out]

    def begins(number: int) -> None:
        watch.progress(0.0, STAGES.get([*works][number], STAGES["robustness"]))

    answers, cut = dict[str, tuple[Any, float]](), False

    def kept(name: str, work: Callable[[], Any]) -> tuple[Any, float]:
        answers[name] = clocked(work)
        return answers[name]

    try:
        made_of_each = side_by_side([partial(kept, *named) for named in works.items()], lists=lists, begins=begins)
        answers = dict(zip(works, made_of_each, strict=True))
    except KeyboardInterrupt:  # what this process has worked out by then is kept
        cut = True
    told = {name: value for name, (value, _) in answers.items()}
    opinions, prices, lasted_s = told.get(costs, (made.solvers, made.prices, {}))
    timed = ("search_generic", "eased", "less_money", "next_best", "alternatives")
    lasted_s |= {name: answers[name][1] for name in timed if name in answers}
    for name, seconds in lasted_s.items():
        watch.timing_s[name] = watch.timing_s.get(name, 0.0) + seconds
    firm = told.get("robustness") if doubts.keys() <= told.keys() else None
    made = replace(
        made, runners_up=told.get("next_best", []), confidence=told.get("eased", counted), solvers=opinions,
        prices=prices, generic_alternative=told.get("search_generic"), less_money=told.get("less_money"),
        alternatives=told.get("alternatives", made.alternatives),
        robustness=None if firm is None else {**firm, **{name: told[name] for name in doubts if name != "robustness"}},
    )  # fmt: skip
    return made, cut


def for_less_money(sought: Sought, choice: Certain | None, deadline: Deadline) -> LessMoney | None:
    """What costs much less and is little worse. Raises OutOfTimeError."""
    if choice is not None:
        from uwopt.solvers.confidence.less_money import less_money_in_doubt

        return less_money_in_doubt(sought, choice, deadline)

    from uwopt.solvers.explain.less_money import less_money

    return less_money(sought, deadline)


def others_in_time(sought: Sought, deadline: Deadline) -> list[Design]:
    """What else is listed, the best first, as far as there is time."""
    others = []
    for found in sought.outcome.best[1:]:
        if deadline.passed():
            deadline.left_out.append(STAGES["next_best"])
            break
        others.append(design_of(sought, found, with_rounding=False))
    return others


def costed(
    made: Result, chosen: Recommendation, wanted: ToTell, deadline: Deadline, patience: Deadline, clock: PatientClock
) -> tuple[list[Opinion], list[Price], dict[str, float]]:
    """Second opinions on the settings, what requirements cost by these too, and how long each stage takes [s]."""
    from uwopt.solvers.explain.prices import prices

    sought, watch = chosen.sought, Watch()

    def asked(limit: Deadline) -> list[Opinion]:
        ask = partial(second_opinions, sought, wanted.solver, choice=chosen.choice)
        return watch.until(limit).within("second_opinion", ask, list[Opinion]())

    opinions, costs = made.solvers, made.prices
    if wanted.doubts:
        by_name, in_time = wanted.solver != "exact", watch.until(patience)  # what is asked for by name takes its time
        opinions = clock.stand_still(partial(asked, deadline)) if by_name else asked(patience)
        costs = in_time.within("prices", lambda limit: prices(sought, chosen.design, opinions, limit), costs)
    if wanted.ranges and sought.outcome.complete:
        with watch.timed("ranges"):
            costs = clock.stand_still(partial(ranged, replace(made, prices=costs), sought, deadline))
    return opinions, costs, watch.timing_s


def clocked(work: Callable[[], Any]) -> tuple[Any, float]:
    """What a work makes, and how long it takes [s]."""
    start_s = time.perf_counter()
    return work(), time.perf_counter() - start_s


def doubts_of(
    sought: Sought, winner: Design, deadline: Deadline, choice: Certain | None
) -> dict[str, Callable[[], Any]]:
    """What the estimates, the choice of water table and the lamps' places could change: how to find out each."""
    from uwopt.solvers.confidence.search import tied_with_best
    from uwopt.solvers.explain.lamp_places import polished_mount, tilt_tolerance
    from uwopt.solvers.explain.other_waters import in_other_waters
    from uwopt.solvers.explain.robustness import equals, robustness
    from uwopt.solvers.explain.same_sensor import UNREACHED, siblings

    none = list[dict[str, Any]]()
    tied = None if choice is None else partial(tied_with_best, sought.problem, choice)
    each: dict[str, tuple[str, Callable[[], Any], Any]] = {
        "robustness": (STAGES["robustness"], lambda: robustness(sought, deadline=deadline), None),
        "equal": (EQUAL, lambda: equals(sought, deadline, tied), none),
        "siblings": (UNREACHED, lambda: siblings(sought, deadline), none),
        "waters": ("other waters", lambda: in_other_waters(sought, deadline), none),
        "tilt": ("how far lamps may lean", lambda: tilt_tolerance(sought, winner, deadline), None),
        "outside_certificate": (
            "lamps between the grid's places", lambda: polished_mount(sought, deadline), None
        ),
    }  # fmt: skip
    return {name: partial(deadline.within, *of) for name, of in each.items()}


def if_made(sought: Sought, proven: Outcome, deadline: Deadline) -> Design | None:
    """The best system with parts to be made, where it is much better than what is sold."""
    found = much_better_if_made(sought, proven, deadline)
    if found.outcome.interrupted:
        raise KeyboardInterrupt
    best = found.outcome.best
    return design_of(found, best[0], deadline=deadline) if best else None


def ranged(made: Result, sought: Sought, deadline: Deadline) -> list[Price]:
    """Prices with the systems that take over where a binding requirement becomes stricter."""
    from uwopt.api.pricing import range_prices

    return range_prices(sought.problem.mission, made, deadline=deadline, sought=sought)


def beside_it(made: Result, sought: Sought, deadline: Deadline) -> list[Any]:
    """Other makers' best systems beside what is recommended."""
    from uwopt.solvers.explain.other_makers import beside_best

    assert made.recommendation is not None
    least = None if made.confidence is None else made.confidence.central_objective
    return beside_best(sought.selection, sought.search, sought.goal, made.recommendation, deadline, least)


def second_opinions(
    sought: Sought, solver: str, deadline: Deadline, choice: Certain | None
) -> list[Opinion]:
    """The winner's settings solved again by continuous solvers, compared by objective.

    choice : of hardware that holds in the doubt: its iris and its focus stand where the scenarios want them
    """
    from uwopt.solvers.continuous import opinions

    best, *others = sought.outcome.best
    first: Sought | None = sought
    if choice is not None:
        first = opinions.alone(sought, best, choice.best.f_number, choice.best.outcomes.meant_m)
    if first is None:
        return []
    if solver == "bonmin":
        return [opinions.mixed_opinion(first, max_seconds=min(opinions.BONMIN_S, deadline.left_s))]
    methods = {"exact": ("casadi",), "casadi": ("casadi",), "nlopt": ("slsqp", "cobyla", "global")}[solver]
    if not opinions.smooth(sought):
        return opinions.aperture_opinions(sought, best) if choice is None else []
    few = [(first, first.outcome.best[0]), *((sought, other) for other in others if solver != "exact")]
    made = []
    for of, found in few:
        for method in methods:
            deadline.check()
            made.append(opinions.opinion(of, found, method, deadline))
    return made
