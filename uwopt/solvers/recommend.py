"""From a mission to a recommendation: select, search, read back, round, doubt, explain; of which kinds parts are made.

The search works on tables; here its designs become results. Every design is evaluated again through
the forward model, and a claim that does not hold there is a defect, not a result.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

import numpy as np

from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import Selection, ToBeMade
from uwopt.catalog.compatibility import explain_pair
from uwopt.catalog.records import Kind
from uwopt.deadline import NEVER, Deadline
from uwopt.errors import SolverError
from uwopt.evaluation.design import evaluate_design
from uwopt.evaluation.leaning import TILT_RESERVE, settings_of, tilt_notes
from uwopt.forward.assembly import build_problem, selected, wish
from uwopt.forward.designs import Hardware
from uwopt.forward.problem import Problem
from uwopt.forward.scene_rows import SceneRows
from uwopt.mission.keys import MadeKind
from uwopt.mission.mission import Mission
from uwopt.model.fineness import DEFAULT, Fineness
from uwopt.objectives.objective import Objective
from uwopt.results.design import COLOUR_LEFT_OPEN, NOT_SETTABLE, Design, Note, SettableCheck
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.one_hardware import only_imager, problem_of
from uwopt.solvers.settable.rounding import given_of, rounded_design
from uwopt.solvers.settable.scene import Near
from uwopt.solvers.settable.steps import printed
from uwopt.solvers.settings.best import scenes_need_cells
from uwopt.tolerances import AGREES_REL
from uwopt.units import format_quantity, texts_apart

GENERIC_GAIN = 0.10
SETTINGS_TO_SET = "settings that can be set"  # where there is no time for them
WORTH_REL = 0.05  # of the objective: what settings to set must cost the best before the next are tried
FARTHER, FARTHER_REL = 20, 0.25  # more designs, and how much worse, that are looked at where none listed can be set
BETTER_UNSETTABLE = "better_unsettable"  # code of the warning that better parts cannot be set


@dataclass
class Sought:
    """One search with what it was made of."""

    selection: Selection
    problem: Problem
    search: Search
    outcome: Outcome
    of_all_kinds: Sought | None = None  # the same search with parts to be made of all kinds, where this has some of few

    @property
    def goal(self) -> Objective:
        """What it searched the best of."""
        return self.search.objective

    @staticmethod
    def of(
        selection: Selection, problem: Problem, goal: Objective, *, top: int = 1, whole: bool = False, **how: Any
    ) -> Sought:
        """What a search of tables finds; whole : as `Search.whole`; how : as `Search` takes it."""
        search = Search(problem, goal, top=top, **how)
        return Sought(selection, problem, search, search.whole() if whole else search.run())


def seek(
    mission: Mission, catalog: Catalog, objective: Objective, *, generic: ToBeMade, depth_m: float | None = None,
    fineness: Fineness = DEFAULT, like: Problem | None = None, **how: Any,
) -> Sought:  # fmt: skip
    """Select, tabulate and search; light that another search in these scenes has worked out is not worked out again.

    how : as `Sought.of` takes it
    """
    selection = selected(mission, catalog, generic=generic, depth_m=depth_m)
    scenes = None if like is None or like.fineness != fineness else like.scenes_for(mission)
    problem = build_problem(mission, selection, fineness=fineness, scenes=scenes)
    return Sought.of(selection, problem, objective, **how)


def scene_rows_of(search: Search, found: Found) -> list[SceneRows]:
    """The settings' view of one found design, by scene."""
    imager, under = np.array([found.imager]), Under.one(found.lighting, 1)
    lights = search.tables.in_scenes(under, imager)
    return search.rows(imager, lights, np.array([found.light]), np.array([found.count]), under)


def design_of(
    sought: Sought, found: Found, *, with_rounding: bool = True, deadline: Deadline = NEVER
) -> Design:
    """A found design as a result: evaluated again, checked, and rounded as far as there is time."""
    problem, objective = sought.problem, sought.goal
    hardware, design = found.hardware, evaluated(problem, found, objective)
    check_claim(design, found, objective)
    design = replace(design, warnings=[*part_warnings(problem, hardware), *design.warnings])

    def rounded() -> Design:
        return with_tilt(problem, hardware, with_rounded(problem, found, design, objective, deadline))

    return deadline.within(SETTINGS_TO_SET, rounded, design) if with_rounding else design


def with_tilt(problem: Problem, hardware: Hardware, design: Design) -> Design:
    """A design with warnings of what lamps lose that lean as far as the mission's reserve, at the settings to set."""
    given = [settings_of(scene.settings_to_set or scene.settings) for scene in design.scenes]
    return replace(design, warnings=[*design.warnings, *tilt_notes(problem, hardware, given)])


def with_fewest_lamps(sought: Sought, deadline: Deadline = NEVER) -> Sought:
    """The search with as few lamps in the first of its systems as do as well, to what objectives agree to.

    Half as many that burn twice as long take the same power but for what the sensor's dark current adds meanwhile, a
    ten-millionth, which must not decide on the price of a lamp. Where it would, the next best are told with as few too.
    A goal that weighs the cost has told them apart.
    """
    best, problem, goal = sought.outcome.best, sought.problem, sought.goal
    if goal.weight("cost") or scenes_need_cells(problem.scenes, goal):
        return sought
    first = of_fewest_lamps(problem, goal, best[0], deadline)
    if first is best[0]:
        return sought
    few = [first, *(of_fewest_lamps(problem, goal, one, deadline) for one in best[1:])]
    return replace(sought, outcome=replace(sought.outcome, best=few))


def of_fewest_lamps(problem: Problem, goal: Objective, found: Found, deadline: Deadline) -> Found:
    """The same parts with as few lamps as do as well; lamps on both sides stay so: one side lights less evenly."""
    mount = found.lighting.mount
    for count in range(problem.count_range[0], 0 if mount.explicit else found.count):
        if deadline.passed():
            break
        if mount.is_lopsided(count) and not mount.is_lopsided(found.count):
            continue
        alone = problem_of(problem, replace(found, count=count))
        made = Search(alone, goal, top=1, imagers=only_imager(alone, found.landscape)).whole().best
        if made and made[0].minimised <= found.minimised + AGREES_REL * abs(found.minimised):
            names = ("camera", "lens", "port", "light", "imager", "lighting")
            return replace(made[0], **{name: getattr(found, name) for name in names})
    return found


def best_settable(sought: Sought, deadline: Deadline = NEVER) -> tuple[Sought, Design]:
    """The best design as a person can set it, and the search with it at the head of those it found.

    By exact numbers the first is best. Where it cannot be set, or not so that lamps may lean as far as the mission's
    reserve, or what can be set costs it much, the next may be better as set; none can be better as set than by exact
    numbers, so few are tried, and the bound of the search holds for all. Where none can be set, those farther
    off are tried, and where none of them can, the first is recommended all the same, with a warning. What the deadline
    does not reach is not tried.
    """
    objective = sought.goal
    found = sought.outcome.best
    first = design_of(sought, found[0], deadline=deadline)
    better = best_as_set(sought, found[1:], value_as_set(first, objective), deadline)
    if better is None and not first.is_settable:
        better = best_as_set(sought, farther(sought, deadline), math.inf, deadline)
    if better is None:
        return sought, first
    one, chosen = better
    best = [one, *(other for other in found if other is not one)]
    note = better_but_unsettable(first, chosen, objective, sought.problem.mission.limits.currency)
    chosen = replace(chosen, warnings=[note, *chosen.warnings])
    return replace(sought, outcome=replace(sought.outcome, best=best)), chosen


def best_as_set(
    sought: Sought, others: Sequence[Found], value: float, deadline: Deadline
) -> tuple[Found, Design] | None:
    """Of some designs, the best first, the one that is better as set than a value by much; None: none is."""
    objective = sought.goal
    chosen, much = None, objective.step(WORTH_REL, sought.outcome.best[0].minimised)
    for other in others:
        if other.minimised >= value - much or deadline.passed():
            break
        design = design_of(sought, other, deadline=deadline)
        own = value_as_set(design, objective)
        if own < value - much:
            value, chosen = own, (other, design)
    return chosen


def within_reach(sought: Sought, deadline: Deadline) -> Iterator[Found]:
    """What a search has listed, the best first, then what is farther off, which is looked for only then."""
    yield from sought.outcome.best
    yield from farther(sought, deadline)


def farther(sought: Sought, deadline: Deadline) -> list[Found]:
    """The next best hardware after what a search has listed, the best first: few, and not much worse than the best.

    None of a catalogue so large that its imagers are not listed. Raises KeyboardInterrupt.
    """
    search, listed, objective = sought.search, sought.outcome.best, sought.goal
    if search.every_imager is None or len(listed) < search.top or deadline.passed():
        return []
    known = {(one.camera, one.lens, one.port, one.light) for one in listed}
    worst = listed[0].minimised + objective.step(FARTHER_REL, listed[0].minimised)
    more = Search(
        sought.problem, objective, top=search.top + FARTHER, deadline=deadline, ceiling=worst, only=search.only,
        imagers=search.every_imager,
    ).whole()  # fmt: skip
    return [one for one in more.best if (one.camera, one.lens, one.port, one.light) not in known]


def value_as_set(design: Design, objective: Objective) -> float:
    """The minimised objective with the settings to set; inf where none hold, or none while lamps lean."""
    value = design.rounded.objective_value if design.rounded is not None else None
    return math.inf if value is None or leans(design) else objective.minimised(value)


def leans(design: Design) -> bool:
    """Whether lamps that lean as far as the mission's reserve lose what is asked for."""
    return any(note.code == TILT_RESERVE for note in design.warnings)


def better_but_unsettable(first: Design, chosen: Design, objective: Objective, currency: str) -> Note:
    """That other parts would be better by exact numbers that nobody can type in."""

    def told(*values: float | None) -> tuple[str, ...]:
        unit = objective.unit(currency)
        return texts_apart(*values, text=lambda value, digits: format_quantity(value, unit, digits), digits=4)

    names = ", ".join(first.hardware.ids)
    text = f"with {names} the exact optimum is {told(first.objective_value)[0]}, but "
    if first.is_settable and leans(first):
        text += "its lamps may not lean as far as reserve.tilt_deg; recommended is the best of the next whose lamps may"
    elif first.is_settable and first.rounded is not None and chosen.rounded is not None:
        as_set, ours = told(first.rounded.objective_value, chosen.rounded.objective_value)
        text += f"{as_set} with settings that can be set; recommended is what is better as set, {ours}"
    else:
        text += (
            "no stop of the lens with steps of time, gain and light was found that meets every requirement there; "
            "recommended is the best of the next that can be set"
        )
    return Note(BETTER_UNSETTABLE, "hardware", text)


def evaluated(problem: Problem, found: Found, objective: Objective) -> Design:
    """A found design with all its figures and margins, by the forward model."""
    hardware = found.hardware
    return evaluate_design(problem, hardware, given_of(problem, hardware, found.settings), objective)


def check_claim(design: Design, found: Found, objective: Objective) -> None:
    """The forward model must agree with what the search claims."""
    claimed = objective.reported(found.minimised)
    value = design.objective_value
    if value is None or abs(value - claimed) > AGREES_REL * max(abs(claimed), 1e-12):
        raise SolverError(
            f"the search claims an objective of {claimed:.9g}, the evaluation of the same design says {value}; "
            "this is a defect of uwopt"
        )
    check_feasible(design, "the search")


def check_feasible(design: Design, claimant: str) -> None:
    """What is claimed to meet every requirement must do so by the forward model."""
    if missed := "; ".join(f"{m.requirement} = {m.value} against {m.limit}" for m in design.missed):
        raise SolverError(
            f"{claimant} claims a feasible design, but its evaluation misses {missed}; this is a defect of uwopt"
        )


def with_rounded(
    problem: Problem, found: Found, design: Design, objective: Objective | Near, deadline: Deadline = NEVER
) -> Design:
    """Add the settings a person can set, and how the design does with them; a warning where there are none.

    What is ordered and warned of is then what belongs to the settings to set. Raises OutOfTimeError past the deadline.
    """
    again = rounded_design(problem, found.hardware, found.settings, objective, deadline).design
    missed = list(dict.fromkeys(m.requirement for m in again.missed))
    if not again.feasible:
        rounded = SettableCheck(False, None, missed)
        return replace(design, rounded=rounded, warnings=[*design.warnings, not_settable()])
    scenes = [
        replace(
            scene, settings_to_set=printed(other.settings), figures_as_set=other.figures, margins_as_set=other.margins
        )
        for scene, other in zip(design.scenes, again.scenes, strict=True)
    ]
    rounded = SettableCheck(True, again.objective_value, missed, again.totals.power_w, again.totals)
    notes = [*part_warnings(problem, found.hardware), *again.warnings]
    return replace(design, scenes=scenes, rounded=rounded, bom=again.bom, warnings=notes)


def not_settable() -> Note:
    """That no stop, time, gain and level that can be set were found to keep every requirement."""
    text = (
        "no settings to type in are offered: no stop of the lens with steps of time, gain and light was found that "
        "meets every requirement; the settings shown are exact numbers"
    )
    return Note(NOT_SETTABLE, "settings_to_set", text)


def colour_notes(problem: Problem, hardware: Hardware) -> list[Note]:
    """What sensor was chosen where the mission leaves open whether it sees colours."""
    if any(wish(view.requirements, "colour") != "any" for view in problem.mission.views):
        return []
    got = problem.parts.cameras[hardware.camera].colour
    other = "colour" if got == "mono" else "mono"
    text = f"Camera is {got}: neither colour nor mono was asked for; requirements.colour: {other} asks for the other"
    if got == "mono":
        text = "Camera is mono: no colour was asked for; requirements.colour: colour asks for it"
    return [Note(COLOUR_LEFT_OPEN, "requirements.colour", text)]


def part_warnings(problem: Problem, hardware: Hardware) -> list[Note]:
    """What should be known of these parts together: a lens rated for larger pixels, and the like."""
    findings = explain_pair(**problem.parts.of(hardware))
    return [Note(f.rule, "hardware", f.message) for f in findings if f.severity == "warning"]


# ---------------------------------------------------------------- as few to be made as serve


#: The worst first: a lamp has to be developed, a dome is ground to order, a tube is turned in any workshop.
TO_BE_MADE: tuple[Kind, ...] = get_args(MadeKind)


def fewest_made(serves: Callable[[tuple[Kind, ...]], bool]) -> tuple[Kind, ...]:
    """The kinds of part to be made, all of which serve: each is left out in turn if the others serve still.

    serves : whether parts to be made of these kinds and no others do; False where that is not known
    """
    made = TO_BE_MADE
    for kind in TO_BE_MADE:
        fewer = tuple(other for other in made if other != kind)
        if fewer and serves(fewer):  # of no kind at all nothing fits
            made = fewer
    return made
