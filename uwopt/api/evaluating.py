"""`uwopt.evaluate`: what a given system would do in a mission."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from uwopt.api.accuracy import (
    accuracy_warnings,
    checked_tolerance,
    estimator_of,
    of_integrals,
    plain_accuracy,
)
from uwopt.api.common import Source, base_result, beyond_cap, prepared, time_warnings
from uwopt.api.floats import own_float_rules
from uwopt.api.risks.told import with_risks
from uwopt.api.watch import STAGES, Watch
from uwopt.catalog.compatibility import explain_pair
from uwopt.deadline import Deadline
from uwopt.errors import MissionError
from uwopt.evaluation.accuracy import Accuracy, coarsest
from uwopt.evaluation.breathing import breathing_notes
from uwopt.evaluation.design import evaluate_design, meets_all
from uwopt.evaluation.influences import influences_of
from uwopt.evaluation.leaning import settings_of, tilt_notes
from uwopt.evaluation.outside import Departure, departures
from uwopt.forward.assembly import load_catalog, system_problem
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.effects import effects_kept
from uwopt.forward.part_columns import FLASH
from uwopt.forward.problem import Problem
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.mission import Mission
from uwopt.mission.system import System, load_system
from uwopt.mission.yielding import with_yields, yields_of
from uwopt.objectives.goal import goal_of
from uwopt.objectives.objective import Objective
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL
from uwopt.results.certainty import Confidence
from uwopt.results.design import MISFIT, PRACTICE_MISSED, Design, Margin, Note
from uwopt.results.result import Result
from uwopt.tolerances import SATISFIED_REL

GAIN_STEP_DB = 0.1  # in which most cameras are set
STEP_DIGITS = 1e-4  # of a step: as nearly as a gain typed as a ratio tells


@dataclass(frozen=True)
class GivenSystem:
    """A system in a mission: its tables, and what is set in each scene."""

    problem: Problem
    hardware: Hardware
    settings: list[SceneSettings]
    goal: Objective

    @staticmethod
    def of(mission: Mission, system: System) -> GivenSystem:
        """Tables of the system in a mission, which is taken to have as many cameras."""
        system.check_scenes(mission)
        if system.camera_count != mission.vehicle.camera_count:
            if mission.vehicle.camera_baseline_m is not None:
                raise MissionError([
                    f"{system.source_name}: camera_count = {system.camera_count}, where the mission asks for a stereo "
                    "pair (vehicle.camera_baseline_m); set it to 2"
                ])  # fmt: skip
            vehicle = {**mission.to_dict()["vehicle"], "camera_count": system.camera_count}
            mission = mission.with_changes(vehicle=vehicle)
        goal = goal_of(mission)
        problem, hardware = system_problem(mission, system)
        settings = [scene_settings(problem, hardware, system, scene.name) for scene in problem.scenes]
        return GivenSystem(problem, hardware, settings, goal)

    def design(self, problem: Problem | None = None) -> Design:
        """All that it does; `problem`: the same tables taken more or less finely."""
        return evaluate_design(
            problem or self.problem, self.hardware, self.settings, self.goal, level_tolerance_rel=LEVEL_TOLERANCE_REL
        )

    def errors(self, deadline: Deadline) -> Accuracy | None:
        """Numerical errors of its figures; None where there is no time for them."""
        in_time = estimator_of(self.problem, lambda at: deadline.in_time(lambda: self.design(at)))
        return deadline.within("errors of figures", lambda: in_time.errors(self.problem.fineness), None)

    def as_coarse_as(self, allowed: float) -> tuple[GivenSystem, Accuracy]:
        """The same with integrals that are taken as coarsely as this error of figures allows, and the errors."""
        estimator = estimator_of(self.problem, self.design)
        measured = estimator.cheapest(allowed, coarsest(estimator.parts))
        return replace(self, problem=self.problem.with_fineness(measured.fineness)), measured

    def confidence(self, design: Design, deadline: Deadline) -> Confidence | None:
        """In how many scenarios it holds; None where there is no time for them."""
        from uwopt.api.certainty import confidence_of  # brings the search, which nothing else here needs

        asked = self.problem.mission.confidence
        return deadline.within(
            STAGES["certainty"],
            lambda: confidence_of(self.problem, self.hardware, self.goal, asked, self.settings[0], design, deadline),
            None,
        )


@own_float_rules
def evaluate(
    mission: Source | Mission, system: Source | System, *, physics: str | None = None, accuracy: bool = False,
    tolerance: float | None = None, confidence: float | str | None = None, seconds: float | None = None,
) -> Result:  # fmt: skip
    """What a given system would do in a mission: figures and margins of every scene.

    `confidence`: also in how many scenarios of what is uncertain it holds, against this share of them.

    `accuracy`: with estimated numerical errors of every figure. `tolerance`: largest error of a figure, a
    share; integrals are then taken as coarsely as it allows.

    `seconds`: for errors and scenarios, which are left out where there is no time for them.
    """
    watch = Watch.begun(seconds)
    deadline = watch.deadline
    as_written = prepared(mission, physics, None, confidence)
    asked = as_written.without_gain_cap  # what is given is not refused for it
    auto = asked.physics == "auto"
    allowed = math.inf  # error of integrals
    if checked_tolerance(tolerance) is not None:
        allowed = of_integrals(tolerance or 0.0, may_leave_out=auto)
        asked = asked.with_changes(tolerance=(tolerance or 0.0) - allowed) if auto else asked
    with watch.timed("catalogue"):
        built = load_system(system, load_catalog(asked))
        given = GivenSystem.of(asked, built)
    with watch.timed("effects"):
        influences = influences_of(given.problem, given.hardware, given.settings)
    if auto:
        given = replace(given, problem=given.problem.with_effects(effects_kept(influences)))
    measured = None
    if accuracy or tolerance is not None:
        with watch.timed("accuracy"):
            if tolerance is None:
                measured = given.errors(deadline)
            else:
                given, measured = given.as_coarse_as(allowed)
    problem, hardware, settings, goal = given.problem, given.hardware, given.settings, given.goal
    with watch.timed("evaluation"):
        elsewhere = departures(asked, load_catalog(asked), built, problem, hardware, settings, goal)
        design = with_compatibility(given.design(), problem, elsewhere)
    counted = None
    if confidence is not None and asked.confidence != CENTRAL:
        with watch.timed("certainty"):
            counted = given.confidence(design, deadline)
    result = base_result("evaluate", problem.mission, goal, problem, influences)
    made = replace(
        result,
        status="feasible" if design.feasible else "violated",
        design=design,
        confidence=counted,
        system=built.to_dict(absolute_paths=True),
        objective=replace(result.objective, value=design.objective_value),
        warnings=[
            *result.warnings,
            *design.warnings,
            *tilt_notes(problem, hardware, settings, [margin.requirement for margin in design.missed]),
            *gain_notes(as_written, design),
            *practice_notes(given, design),
            *accuracy_warnings(measured, allowed),
            *time_warnings(deadline),
        ],
        accuracy=plain_accuracy(measured, allowed, None, []),
        timing_s=watch.total(),
    )
    return with_risks(made)


def practice_notes(given: GivenSystem, design: Design) -> list[Note]:
    """That a system misses what good practice has filled in alone, and nothing that the mission itself says.

    Set as it is told: its requirements are held against what the mission itself says, over the same tables.
    """
    missed = {margin.requirement for margin in design.missed}
    every = yields_of(given.problem.mission) if missed else ()
    if not every or any(name.startswith(MISFIT) for name in missed):
        return []
    plain = given.problem.asking(with_yields(given.problem.mission, every))
    shown = [settings_of(scene.settings) for scene in design.scenes]
    text = (
        "what the mission itself says is met: all that is missed is good practice, which solve relaxes where nothing "
        "meets it"
    )
    is_met = meets_all(plain, given.hardware, shown)
    return [Note(PRACTICE_MISSED, "practice", text)] if is_met else []


def scene_settings(problem: Problem, hardware: Hardware, system: System, name: str) -> SceneSettings:
    """One scene's settings of a system file in SI; a level from lumens or joules."""
    given = system.settings_for(name)
    level = given.dim_frac
    lights = problem.lights
    is_flash = int(lights.kind[0]) == FLASH
    key = "flux_lm" if is_flash else "flash_energy_j"
    if getattr(given, key) is not None:
        kind, other = ("a flash", "flash_energy_j") if is_flash else ("no flash", "flux_lm")
        raise MissionError(
            f"{system.source_name}: settings.{key} = {getattr(given, key):g} does not suit the light, which is {kind}; "
            f"give {other} or dim_frac"
        )
    if given.flux_lm is not None:
        level = given.flux_lm / (float(lights.full_light[0]) * hardware.count)
    if given.flash_energy_j is not None and lights.stored_energy_j[0] > 0:
        level = given.flash_energy_j / float(lights.stored_energy_j[0])

    def seconds(value_ms: float | None) -> float | None:
        return None if value_ms is None else value_ms * 1e-3

    return SceneSettings(
        f_number=given.f_number,
        exposure_s=seconds(given.exposure_ms),
        pulse_s=seconds(given.pulse_ms),
        gain=given.gain,
        level=level,
        rate_hz=given.frame_rate_hz,
        focus_distance_m=given.focus_distance_m,
    )


def with_compatibility(design: Design, problem: Problem, elsewhere: Sequence[Departure]) -> Design:
    """A design with what does not fit together among its parts, or not on the vehicle, as margins that are missed."""
    mission = problem.mission
    findings = explain_pair(
        **{kind: part for kind, (part,) in problem.parts.by_kind.items()},
        frame_rate_hz=max(float(s.settings["frame_rate_hz"] or 0.0) for s in design.scenes) or None,
    )  # fmt: skip
    strict = "lens rating" if mission.catalog.lens_rating == "limit" else ""
    faults = [f.rule for f in findings if f.severity == "fault" or f.rule == strict]
    faults += unwanted_kind(problem)
    faults += [departure.rule for departure in elsewhere if departure.binds]
    notes = [Note(f.rule, "hardware", f.message) for f in findings]
    notes += [*(departure.note for departure in elsewhere), *breathing_notes(design), *design.warnings]
    notes += inexact_level_notes(design)
    if not faults:
        return replace(design, warnings=notes)
    missed = [Margin(f"{MISFIT}{rule}", 0.0, 1.0, ">=", -1.0, "", None, False, False) for rule in faults]
    scenes = [replace(scene, margins=[*scene.margins, *missed]) for scene in design.scenes]
    return replace(design, scenes=scenes, feasible=False, warnings=notes)


def unwanted_kind(problem: Problem) -> list[str]:
    """Where the camera's shutter or colour is not what a scene asks for."""
    camera = problem.parts.cameras[0]
    return sorted(
        {
            key
            for view in problem.mission.views
            for key in ("shutter", "colour")
            if getattr(view.requirements, key) not in ("any", getattr(camera, key))
        }
    )


def inexact_level_notes(design: Design) -> list[Note]:
    """That a mean level is met only as well as a gain in steps can, where nobody needs steps: `solve` meets it exactly.

    A gain on its steps is what `solve` has set too, so nothing is said of it.
    """
    text = f"the mean level is met to {100 * LEVEL_TOLERANCE_REL:g} %, a step of the gain; solve meets it exactly"
    return [
        Note("outside_search", "settings.gain", f"{scene.name}: {text}")
        for scene in design.scenes
        if not on_a_step(scene.settings.get("gain_db") or 0.0)
        for level in scene.margins
        if level.requirement == "mean_level" and level.satisfied
        if (level.margin or 0.0) < -SATISFIED_REL * (level.limit or 0.0)
    ]


def on_a_step(gain_db: float) -> bool:
    """Whether a gain is one of those that cameras are set to, in steps from 0 dB."""
    return abs(gain_db / GAIN_STEP_DB - round(gain_db / GAIN_STEP_DB)) < STEP_DIGITS


def gain_notes(mission: Mission, design: Design) -> list[Note]:
    """That a gain is beyond the cap below which `solve` looks first; nothing is refused for it."""
    cap_db = mission.reserve.max_gain_db
    return [
        Note("gain_cap", "reserve.max_gain_db", f"{scene.name}: {beyond_cap(gain_db, cap_db)}; solve would take it "
             "only where nothing fits below")
        for scene in design.scenes
        if cap_db is not None and (gain_db := scene.settings.get("gain_db") or 0.0) > cap_db * (1 + SATISFIED_REL)
    ]  # fmt: skip
