"""The recommendation that holds in the doubt, which `solve` takes in place of the central optimum."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from uwopt.api.counting import CERTAINTY_S, Counts, counts_of
from uwopt.api.recommendation import Recommendation
from uwopt.api.watch import STAGES, Watch
from uwopt.deadline import NEVER, Deadline, effort_s
from uwopt.evaluation.leaning import settings_of
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.problem import Problem
from uwopt.mission.doubt import ENDS
from uwopt.objectives.objective import Objective
from uwopt.quantities import AT_LIKELIEST
from uwopt.results.certainty import Confidence
from uwopt.results.design import AS_CENTRAL, FARTHEST_M, Design, Note
from uwopt.solvers.confidence.counted import Counted, names
from uwopt.solvers.confidence.fixed import SceneSetting
from uwopt.solvers.confidence.outcomes import outcomes_of_each
from uwopt.solvers.confidence.search import (
    Certain,
    at_its_stop,
    best_counted,
    check_fixed,
    judged_anew,
    scenarios_of,
)
from uwopt.solvers.confidence.summary import confidence_record
from uwopt.solvers.exact.lightings import Lighting
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.recommend import BETTER_UNSETTABLE, Sought, best_settable, design_of, within_reach
from uwopt.units import percent

MADE_IS_SURER = "made_is_surer"  # code of the warning that more parts to be made were taken, for they hold more often
NOT_CERTAIN = "not_certain"  # code of the warning that nothing holds as often as asked
MOST_SET = 6  # stops of a ring, of one hardware or the next, that are tried to be set
OF_A_SYSTEM = 10_000  # scenarios in which a given system is counted


def with_confidence(
    sought: Sought, winner: Design | None, watch: Watch, before: Counts | None = None
) -> Recommendation:
    """What is recommended at the mission's confidence: its design, and what was counted.

    There must be a design, and a mission that does not take every number as central.

    winner : the best at likeliest values, as it can be set; None: made only where nothing was counted
    before : what was counted for a mission that differs in a few keys: its waters and its hardware are known
    """
    asked, goal, deadline = sought.problem.mission.confidence, sought.goal, watch.deadline
    patient = watch.until(deadline.or_after(CERTAINTY_S, effort_s))
    counts, certain = counts_of(sought, patient, before, deadline), None
    if counts is not None:
        with watch.stage("certainty"):
            certain = best_counted(counts.seen, patient.deadline, watch.progress)
    if counts is None or certain is None:
        why = "no time was left to count other hardware; --seconds gives more"
        if not patient.deadline.left_out:
            why = f"of the hardware that was likely to hold none meets every requirement {AT_LIKELIEST} as well"
        return as_central(sought, winner, watch, counts, why)
    sought, proven = counts.sought, counts.sought.outcome
    with watch.stage("certainty"):
        certain, design = as_settable(sought, certain, deadline)
        if not design.is_settable:
            certain, design = of_known(sought, certain, design, deadline)
        if asked != ENDS:
            certain = judged_anew(sought.problem, goal, certain, focus_to_set_m(design), deadline)
        counted = confidence_record(sought.problem, goal, certain, sought.outcome.best[0], ends=asked == ENDS)
    if not counted.enough:
        share = "every end" if asked == ENDS else f"{100.0 * certain.asked:g} % of the scenarios"
        none = "nothing in the catalogue" if certain.proven else "nothing that was counted"
        held = counted.held if asked == ENDS or counted.held < certain.asked else counted.held_in_choice
        text = f"{none} holds in {share}; this does in {percent(held)}"
        design = with_note(design, Note(NOT_CERTAIN, "confidence", text))
    if counts.of_all_parts:
        share = "at every end" if asked == ENDS else f"in {100.0 * certain.asked:g} % of the scenarios"
        text = (
            f"nothing with fewer parts to be made that was counted holds {share}; this does in "
            f"{percent(counted.held)}"
        )
        design = with_note(design, Note(MADE_IS_SURER, "catalog.generic", text))
    next_best = [one for one in sought.outcome.best if not same_hardware(one, certain.central)]
    headed = replace(sought, outcome=replace(sought.outcome, best=[certain.central, *next_best]))
    return Recommendation(
        sought.problem.mission, headed, proven, design, counted=counted, counts=counts, choice=certain,
        is_best=counted.enough and certain.proven,
    )  # fmt: skip


def with_note(design: Design, note: Note) -> Design:
    """A design with a warning before its others."""
    return replace(design, warnings=[note, *design.warnings])


def as_central(
    sought: Sought, winner: Design | None, watch: Watch, counts: Counts | None, why: str
) -> Recommendation:
    """The best at likeliest values, where none was counted that fits by them, and in how many scenarios it holds."""
    goal, deadline, proven = sought.goal, watch.deadline, sought.outcome
    if winner is None:
        sought, winner = best_settable(sought, deadline)
    design, found = winner, sought.outcome.best[0]
    problem, first = sought.problem.with_mount(found.lighting.mount), winner.scenes[0]
    asked, given = problem.mission.confidence, settings_of(first.settings_to_set or first.settings)
    counted = deadline.within(
        STAGES["certainty"],
        lambda: confidence_of(problem, found.hardware, goal, asked, given, design, deadline), None,
    )  # fmt: skip
    held = "which alone are held" if counted is None else f"and holds in {percent(counted.held)} of the scenarios"
    enough = ", as often as is asked, but was not chosen by that" if counted is not None and counted.enough else ""
    passed_over = any(note.code == BETTER_UNSETTABLE for note in winner.warnings)
    best = f"the best that can be set {AT_LIKELIEST}" if passed_over else f"the best {AT_LIKELIEST}"
    design = with_note(winner, Note(AS_CENTRAL, "confidence", f"this is {best}, {held}{enough}: {why}"))
    return Recommendation(
        sought.problem.mission, sought, proven, design, counted=counted, counts=None if counted is None else counts,
        is_best=False,
    )  # fmt: skip


def as_settable(sought: Sought, certain: Certain, deadline: Deadline) -> tuple[Certain, Design]:
    """The choice at the stop of its ring that can be set at likeliest values too, and its design.

    At the best stop depth of field may be met to the last digit, so that no focus mark keeps it; the others that hold
    as often are tried in the order of their medians, then other hardware. Where none can be set, the best, with a
    warning.
    """
    problem, goal = sought.problem, sought.goal
    tried: list[tuple[Certain, Design]] = []
    for one in islice(stops_that_hold(certain), MOST_SET):
        if tried and deadline.passed():
            break
        found = certain.central if one is certain.best else at_its_stop(problem, goal, one, deadline)
        if found is None:
            continue
        at = problem if one.f_number is None else problem.at_f_number(one.f_number)
        design = design_of(replace(sought, problem=at), found, deadline=deadline)
        chosen = certain if one is certain.best else replace(certain, best=one, central=found)
        tried.append((chosen, design))
        if design.is_settable:
            return chosen, design
    return tried[0]


def of_known(sought: Sought, certain: Certain, design: Design, deadline: Deadline) -> tuple[Certain, Design]:
    """Where nothing that was counted can be set: what the search at likeliest values finds that can, counted as well.

    Taken where it holds as often as the choice does, or as often as is asked for; else the choice, with its warning.
    """
    problem, goal, least = sought.problem, sought.goal, min(certain.asked, certain.best.held)
    had = {names(problem, one.found) for one in certain.tried}
    for found in within_reach(sought, deadline):
        if deadline.passed():
            break
        if names(problem, found) in had:
            continue
        made = design_of(sought, found, deadline=deadline)
        if not made.is_settable:
            continue
        outcomes = outcomes_of_each(problem, [found], goal, certain.scenarios)[0]
        other = Counted(found, outcomes, outcomes.best(certain.asked))
        central = at_its_stop(problem, goal, other) if other.held >= least else None
        if central is None:
            continue
        ranked = [other, *certain.ranked]
        more = replace(certain, best=other, central=central, tried=[*certain.tried, other], ranked=ranked)
        more, made = as_settable(sought, more, deadline)
        if made.is_settable:
            return more, made
    return certain, design


def focus_to_set_m(design: Design) -> float:
    """Where the lens is focused in the first scene's water, as that is typed in."""
    first = design.scenes[0]
    distance_m = (first.settings_to_set or first.settings).get("focus_distance_m")
    return FARTHEST_M if distance_m is None else distance_m


def stops_that_hold(certain: Certain) -> Iterator[Counted]:
    """The best hardware at its stop, then at the others at which it holds as often as was asked for; then the next."""
    least = min(certain.asked, certain.best.held)
    others = [one for one in certain.ranked if one is not certain.best]
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
    from uwopt.solvers.confidence.summary import counted_confidence

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
    made = outcomes(problem, found, goal, scenarios, deadline, f_numbers=stops, given=own, tells=True)
    share = 1.0 if asked == ENDS else float(asked)
    seen = Counted(found, made, made.best(share))
    by = [] if asked == ENDS else decided_by(problem, goal, seen, scenarios)
    known = counted_confidence(problem, goal, seen, asked=asked, share=share, decided_by=by)
    if known.enough or asked == ENDS:
        return known
    few = scenarios_of(problem, share, problem.mission.seed, problem.mission.doubt.scenarios, scenarios)
    seen = Counted(found, outcomes(problem, found, goal, few, f_numbers=[seen.f_number] if seen.f_number else None), 0)
    return eased(problem, goal, known, Certain(share, few, seen, found, [seen], complete=True), deadline)


def eased(problem: Problem, goal: Objective, known: Confidence, choice: Certain, deadline: Deadline) -> Confidence:
    """What was counted, and where that is not enough, with what asked less it would be in the scenarios of a choice."""
    from uwopt.solvers.confidence.changes import other_changes
    from uwopt.solvers.confidence.eased import Shares, would_hold

    if known.enough or known.asked == ENDS:
        return known
    best, scenarios, share, shares = choice.best, choice.scenarios, choice.asked, Shares()
    if alone := would_hold(problem, goal, best, scenarios, share, deadline, shares):
        return replace(known, would_hold=alone)
    others, in_vain = other_changes(problem, goal, best, scenarios, share, choice.ranked, deadline, shares)
    return replace(known, would_hold_else=others, in_vain=in_vain)


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


