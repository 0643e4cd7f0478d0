"""What is told of a proven recommendation: how firm it is, what its requirements cost, and what stands beside it.

What does not need each other is worked out side by side where there are cores for it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from uwopt.api.common import Progress
from uwopt.api.search_notes import cut_warnings, patience_warnings
from uwopt.api.timing import STAGES, timed
from uwopt.deadline import Deadline, processor_s
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Price
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.solvers.beside import side_by_side
from uwopt.solvers.recommend import Sought

if TYPE_CHECKING:
    from uwopt.solvers.confidence.search import Certain

DOUBTS_S = 6.0  # of the processor, for how firm a proven answer is, where no time is given
EQUAL = "which systems are equal within the estimates"


@dataclass(frozen=True)
class ToTell:
    """What is to be told beside the proof.

    central : the search by central numbers
    doubts : how firm the answer is, and second opinions
    """

    central: Sought
    doubts: bool = True
    ranges: bool = False  # up to where the system stays the best as each binding requirement becomes stricter
    alternatives: bool = False  # what systems of other makers lack


def doubted(
    made: Result, sought: Sought, goal: Objective, timing: dict[str, float], deadline: Deadline,
    progress: Progress | None, solver: str, choice: Certain | None, wanted: ToTell,
) -> Result:  # fmt: skip
    """A result with how firm it is, what more power and money would buy, and second opinions, in time.

    choice : of hardware that holds in the doubt, where it was made so
    """
    from uwopt.solvers.explain.knee import knee
    from uwopt.solvers.explain.prices import prices

    winner, cut, none = made.recommendation, False, list[dict[str, Any]]()
    assert winner is not None
    patience = deadline.or_after(DOUBTS_S, processor_s)
    try:
        if wanted.doubts and goal.quality:
            with timed(timing, "knee", progress):
                bought = deadline.within(STAGES["knee"], lambda: knee(sought, goal, deadline), None)
            made = replace(made, knee=bought)
        if wanted.doubts:
            with timed(timing, "second_opinion", progress):
                slow = deadline if solver != "exact" else patience  # what is asked for by name takes its time
                opinions = slow.within("second opinions", lambda: second_opinions(sought, goal, solver, slow), none)
            made = replace(made, solvers=opinions)
            with timed(timing, "prices", progress):
                costs = patience.within(
                    STAGES["prices"], lambda: prices(sought, goal, winner, opinions, patience), list[Price]()
                )
            made = replace(made, prices=costs)
        with timed(timing, "robustness", progress if wanted.doubts else None):
            made = told_together(made, sought, goal, timing, deadline, patience, choice, wanted, progress)
    except KeyboardInterrupt:  # what is proven is not lost
        cut = True
    notes = cut_warnings() if cut else []
    if patience is not deadline:
        notes += patience_warnings(patience, DOUBTS_S)
    return replace(made, warnings=[*made.warnings, *notes])


def told_together(
    made: Result, sought: Sought, goal: Objective, timing: dict[str, float], deadline: Deadline, patience: Deadline,
    choice: Certain | None, wanted: ToTell, progress: Progress | None,
) -> Result:  # fmt: skip
    """A result with how firm it is and what stands beside it, side by side, in time; `patience`: for the first."""
    winner = made.recommendation
    assert winner is not None
    doubts = doubts_of(sought, winner, goal, patience, choice) if wanted.doubts else {}
    works: dict[str, Callable[[], Any]] = {}
    counted = made.confidence
    if wanted.doubts and counted is not None and choice is not None and not counted.enough:
        from uwopt.api.certainty import eased

        works["eased"] = partial(eased, sought.problem, goal, counted, choice, deadline)
    if wanted.ranges and wanted.central.outcome.complete:
        works["ranges"] = partial(ranged, made, wanted.central, deadline)
    works |= doubts
    if wanted.alternatives and sought.outcome.complete:
        works["alternatives"] = partial(beside_it, made, sought, goal, deadline)
    lists = [deadline.left_out] if patience is deadline else [deadline.left_out, patience.left_out]

    def begins(number: int) -> None:
        if progress is not None:
            progress(0.0, STAGES.get([*works][number], STAGES["robustness"]))

    made_of_each = side_by_side([partial(clocked, work) for work in works.values()], lists=lists, begins=begins)
    answers = dict(zip(works, made_of_each, strict=True))
    timing |= {name: answers[name][1] for name in ("eased", "ranges", "alternatives") if name in answers}
    told = {name: value for name, (value, _) in answers.items()}
    firm = told.get("robustness")
    return replace(
        made, confidence=told.get("eased", counted), prices=told.get("ranges", made.prices),
        alternatives=told.get("alternatives", made.alternatives),
        robustness=None if firm is None else {**firm, **{name: told[name] for name in doubts if name != "robustness"}},
    )  # fmt: skip


def clocked(work: Callable[[], Any]) -> tuple[Any, float]:
    """What a work makes, and how long it takes [s]."""
    start_s = time.perf_counter()
    return work(), time.perf_counter() - start_s


def doubts_of(
    sought: Sought, winner: Design, goal: Objective, deadline: Deadline, choice: Certain | None = None
) -> dict[str, Callable[[], Any]]:
    """What the estimates, the choice of water table and the lamps' places could change: how to find out each."""
    from uwopt.solvers.confidence.search import tied_with_best
    from uwopt.solvers.explain.lamp_places import polished_mount, tilt_tolerance
    from uwopt.solvers.explain.other_waters import in_other_waters
    from uwopt.solvers.explain.robustness import robustness
    from uwopt.solvers.explain.same_sensor import UNREACHED, siblings
    from uwopt.solvers.explain.ties import equals

    none = list[dict[str, Any]]()
    tied = None if choice is None else partial(tied_with_best, sought.problem, choice)
    each: dict[str, tuple[str, Callable[[], Any], Any]] = {
        "robustness": (STAGES["robustness"], lambda: robustness(sought, goal, deadline=deadline), None),
        "equal": (EQUAL, lambda: equals(sought, goal, deadline, tied), none),
        "siblings": (UNREACHED, lambda: siblings(sought, goal, deadline), none),
        "waters": ("other waters", lambda: in_other_waters(sought, goal, deadline), none),
        "tilt": ("how far lamps may lean", lambda: tilt_tolerance(sought, winner, goal, deadline), None),
        "outside_certificate": (
            "lamps between the grid's places", lambda: polished_mount(sought, goal, deadline), None
        ),
    }  # fmt: skip
    return {name: partial(deadline.within, *of) for name, of in each.items()}


def ranged(made: Result, sought: Sought, deadline: Deadline) -> list[Price]:
    """Prices with the systems that take over where a binding requirement becomes stricter."""
    from uwopt.api.pricing import range_prices

    return range_prices(sought.problem.mission, made, deadline=deadline, sought=sought)


def beside_it(made: Result, sought: Sought, goal: Objective, deadline: Deadline) -> list[Any]:
    """Other makers' best systems beside what is recommended."""
    from uwopt.solvers.explain.other_makers import beside_best

    assert made.recommendation is not None
    least = None if made.confidence is None else made.confidence.central_objective
    return beside_best(sought.selection, sought.search, goal, made.recommendation, deadline, least)


def second_opinions(sought: Sought, goal: Objective, solver: str, deadline: Deadline) -> list[dict[str, Any]]:
    """The winner's settings solved again by continuous solvers, compared by objective."""
    from uwopt.solvers.continuous import opinions

    if solver == "bonmin":
        return [opinions.mixed_opinion(sought, goal, max_seconds=min(opinions.BONMIN_S, deadline.left_s))]
    methods = {"exact": ("casadi",), "casadi": ("casadi",), "nlopt": ("slsqp", "cobyla", "global")}[solver]
    if not opinions.smooth(sought, goal):
        return opinions.aperture_opinions(sought, sought.outcome.best[0], goal)
    few = sought.outcome.best[:1] if solver == "exact" else sought.outcome.best
    made = []
    for found in few:
        for method in methods:
            deadline.check()
            made.append(opinions.opinion(sought, found, goal, method, deadline))
    return made
