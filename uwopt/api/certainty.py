"""The recommendation that holds in the doubt, which `solve` takes in place of the central optimum."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from uwopt.api.common import Progress
from uwopt.api.searching import leaves_out_generic, of_all_parts
from uwopt.api.timing import STAGES, timed
from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.problem import Problem
from uwopt.mission.doubt import ENDS
from uwopt.objectives.objective import Objective
from uwopt.results.certainty import Confidence
from uwopt.results.design import FARTHEST_M, Design, Note
from uwopt.solvers.confidence.counted import Counted, rank
from uwopt.solvers.confidence.fixed import SceneSetting
from uwopt.solvers.confidence.search import (
    Certain,
    at_its_stop,
    check_fixed,
    has_room,
    judged_anew,
    most_certain,
    scenarios_of,
)
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.lightings import Lighting
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.recommend import Sought, best_settable, design_of

MADE_IS_SURER = "made_is_surer"  # code of the warning that parts to be made hold as often as asked, sold ones not
ALL_PARTS = "parts to be made that may hold more often"  # where there is no time for them
NOT_CERTAIN = "not_certain"  # code of the warning that nothing holds as often as asked
CERTAINTY_S = 15.0  # of the processor, where no time is given
EASED_S = 8.0  # of the processor, likewise, for what asked less would make certain enough
MOST_SET = 6  # stops of a ring, of one hardware or the next, that are tried to be set
OF_A_SYSTEM = 10_000  # scenarios in which a given system is counted
AS_CENTRAL = "certainty_left_out"  # that there was no time for it


def with_confidence(
    sought: Sought, winner: Design | None, goal: Objective, deadline: Deadline, progress: Progress | None,
    timing: dict[str, float],
) -> tuple[Sought, Design, Confidence | None, bool]:  # fmt: skip
    """What is recommended at the mission's confidence: the search with it at its head, its design, what was counted.

    And whether it is proven best. There must be a design, and a mission that does not take every number as central.

    winner : the best by central numbers, as it can be set; None: made only where nothing was counted
    """
    from uwopt.solvers.confidence.summary import told

    asked, problem = sought.problem.mission.confidence, sought.problem
    patience = deadline if math.isfinite(deadline.end_s) else Deadline.after(CERTAINTY_S, time.process_time)
    with timed(timing, "certainty", progress):
        certain = patience.within(
            STAGES["certainty"], lambda: most_certain(sought, goal, asked, patience, progress), None
        )
    first = sought.outcome.best[0]
    if certain is None:
        why = "no time was left to count scenarios" if patience.left_out else "no stop that was counted fits by them"
        text = f"this is the best by central numbers, which alone are held: {why}"
        note = Note(AS_CENTRAL, "confidence", text)
        if winner is None:
            sought, winner = best_settable(sought, goal, deadline)
        return sought, replace(winner, warnings=[note, *winner.warnings]), None, False
    with timed(timing, "certainty", progress):
        certain, design = as_settable(sought, certain, goal, deadline)
        if asked != ENDS:
            certain = judged_anew(problem, goal, certain, focus_to_set_m(design), patience)
        counted = told(problem, goal, certain, first, ends=asked == ENDS)
    found = certain.central
    if not counted.enough:
        share = "every end" if asked == ENDS else f"{100.0 * certain.asked:g} % of the scenarios"
        none = "nothing in the catalogue" if certain.proven else "nothing that was counted"
        text = f"{none} holds in {share}; this does in {100.0 * min(counted.held, counted.held_in_choice):.0f} %"
        design = replace(design, warnings=[Note(NOT_CERTAIN, "confidence", text), *design.warnings])
    others = [one for one in sought.outcome.best if not same_hardware(one, found)]
    outcome = replace(sought.outcome, best=[found, *others])
    return replace(sought, outcome=outcome), design, counted, counted.enough and certain.proven


def surer_of_all_parts(
    sought: Sought, goal: Objective, sold: Confidence | None, deadline: Deadline, progress: Progress | None,
    timing: dict[str, float],
) -> tuple[Sought, Outcome, Design, Confidence, bool] | None:  # fmt: skip
    """The same with parts to be made, and what is proven of them by central numbers: where only they are sure enough.

    None where what is sold holds as often as asked, no other parts do, none were left out, or time is out.
    """
    if sold is None or sold.enough or not leaves_out_generic(sought):
        return None

    def found() -> Sought | None:
        with timed(timing, "search_generic"):
            every = of_all_parts(sought, goal, deadline, progress)
            if not every.outcome.complete:
                raise OutOfTimeError
            room = has_room(every.problem, goal, sold.asked, deadline)
            return every if room else None

    made = deadline.within(ALL_PARTS, found, None)
    if made is None:
        return None
    every, winner, counted, surely_best = with_confidence(made, None, goal, deadline, progress, timing)
    if counted is None or not counted.enough:
        return None
    asked = "at every end" if sold.asked == ENDS else f"in {100.0 * float(sold.asked):g} % of the scenarios"
    text = (
        f"nothing sold that was counted holds {asked}: the best of it does in {100.0 * sold.held:.0f} %; with parts to "
        f"be made this does in {100.0 * counted.held:.0f} %"
    )
    winner = replace(winner, warnings=[Note(MADE_IS_SURER, "catalog.generic", text), *winner.warnings])
    return every, made.outcome, winner, counted, surely_best


def as_settable(sought: Sought, certain: Certain, goal: Objective, deadline: Deadline) -> tuple[Certain, Design]:
    """The choice at the stop of its ring that can be set by central numbers too, and its design.

    At the best stop depth of field may be met to the last digit, so that no focus mark keeps it; the others that hold
    as often are tried in the order of their medians, then other hardware. Where none can be set, the best, with a
    warning.
    """
    problem = sought.problem
    tried: list[tuple[Certain, Design]] = []
    for one in islice(stops_that_hold(certain), MOST_SET):
        if tried and deadline.passed():
            break
        found = certain.central if one is certain.best else at_its_stop(problem, goal, one, deadline)
        if found is None:
            continue
        at = problem if one.f_number is None else problem.at_f_number(one.f_number)
        design = design_of(replace(sought, problem=at), found, goal, deadline=deadline)
        chosen = certain if one is certain.best else replace(certain, best=one, central=found)
        tried.append((chosen, design))
        if design.is_settable:
            return chosen, design
    return tried[0]


def focus_to_set_m(design: Design) -> float:
    """Where the lens is focused in the first scene's water, as that is typed in."""
    first = design.scenes[0]
    distance_m = (first.settings_to_set or first.settings).get("focus_distance_m")
    return FARTHEST_M if distance_m is None else distance_m


def stops_that_hold(certain: Certain) -> Iterator[Counted]:
    """The best hardware at its stop, then at the others at which it holds as often as was asked for; then the next."""
    least = min(certain.asked, certain.best.held)
    others = sorted((one for one in certain.tried if one is not certain.best), key=lambda one: rank(one, certain.asked))
    for hardware in (certain.best, *others):
        made = hardware.outcomes
        rest = [Counted(hardware.found, made, k) for k in range(len(made.f_numbers)) if k != hardware.stop]
        for one in (hardware, *sorted(rest, key=lambda one: one.quantile(0.5))):
            if one.held >= least:
                yield one


def confidence_of(
    problem: Problem, hardware: Hardware, goal: Objective, asked: float | str, given: SceneSettings,
    design: Design | None, deadline: Deadline = NEVER,
) -> Confidence:  # fmt: skip
    """In how many scenarios a given system holds, its iris where it stands and all else set once the water is seen.

    given : of the first scene
    design : its lens is focused so, and all else set so where the mission has that fixed before; None: as is best
    """
    from uwopt.solvers.confidence.deciding import decided_by
    from uwopt.solvers.confidence.outcomes import outcomes
    from uwopt.solvers.confidence.summary import counted

    check_fixed(problem, goal)
    scenarios = scenarios_of(problem, asked, problem.mission.seed, OF_A_SYSTEM)
    lighting = Lighting(int(problem.lights.optics_index[hardware.light]), 0, hardware.mount)
    found = Found(
        imager=0, camera=hardware.camera, lens=hardware.lens, port=hardware.port, landscape=hardware.landscape,
        light=hardware.light, count=hardware.count, lighting=lighting, minimised=math.nan, power_w=math.nan,
        cost=math.nan, mass_kg=math.nan, snr_db=math.nan, settings=[], pulse_s=0.0,
    )  # fmt: skip
    fixed = problem.mission.doubt.settings == "fixed"
    problem = problem if design is None else problem.focused_on(focus_to_set_m(design))
    stops = None if given.f_number is None else [given.f_number]
    own = as_given(problem, hardware, design) if fixed and design is not None else None
    made = outcomes(problem, found, goal, scenarios, deadline, f_numbers=stops, given=own)
    share = 1.0 if asked == ENDS else float(asked)
    seen = Counted(found, made, made.best(share))
    by = [] if asked == ENDS else decided_by(problem, goal, seen, scenarios)
    known = counted(problem, goal, seen, asked=asked, share=share, decided_by=by)
    return eased(problem, found, goal, known, deadline)


def eased(problem: Problem, found: Found, goal: Objective, known: Confidence, deadline: Deadline) -> Confidence:
    """What was counted, and where that is not enough, with what asked less it would be."""
    from uwopt.solvers.confidence.deciding import would_hold
    from uwopt.solvers.confidence.outcomes import outcomes

    if known.enough or known.asked == ENDS:
        return known
    timed = math.isfinite(deadline.end_s)
    deadline = deadline.at_most(EASED_S) if timed else Deadline.after(EASED_S, time.process_time)
    share, stops = float(known.asked), None if known.f_number is None else [known.f_number]
    scenarios = scenarios_of(problem, share, problem.mission.seed, problem.mission.doubt.scenarios)
    seen = Counted(found, outcomes(problem, found, goal, scenarios, f_numbers=stops), 0)
    return replace(known, would_hold=would_hold(problem, goal, seen, scenarios, share, deadline))


def as_given(problem: Problem, hardware: Hardware, design: Design) -> list[SceneSetting]:
    """What is set in each scene of a system."""
    light, made = problem.lights.take(np.array([hardware.light])), []
    offset_s = float(problem.cameras.exposure_offset_s[hardware.camera])
    for scene in design.scenes:
        known = {name: math.nan if value is None else float(value) for name, value in scene.settings.items()}
        lit_s = 1e-3 * known["exposure_ms"] + offset_s
        if light.kind[0] != CONTINUOUS:
            lit_s = min(lit_s, 1e-3 * known["pulse_ms"])
        if light.kind[0] == FLASH:
            lit_s = float(light.flash.light_s(np.array([lit_s]))[0])
        level = 1.0 if math.isnan(known["dim_frac"]) else known["dim_frac"]
        made.append(SceneSetting(level, lit_s, known["gain"]))
    return made


def same_hardware(one: Found, other: Found) -> bool:
    """Whether two designs are of the same parts, as many lamps, mounted alike."""
    names = ("camera", "lens", "port", "light", "count", "landscape", "lighting")
    return all(getattr(one, name) == getattr(other, name) for name in names)


