"""`uwopt.evaluate`: what a given system would do in a mission."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace

from uwopt.api.accuracy import (
    accuracy_warnings,
    checked_tolerance,
    estimator_of,
    of_integrals,
    plain_accuracy,
)
from uwopt.api.common import Source, base_result, beyond_cap, prepared, time_warnings
from uwopt.api.floats import own_float_rules
from uwopt.api.risks import with_risks
from uwopt.api.timing import STAGES, timed
from uwopt.catalog.compatibility import explain_pair
from uwopt.deadline import Deadline
from uwopt.errors import MissionError
from uwopt.evaluation.accuracy import coarsest
from uwopt.evaluation.breathing import breathing_notes
from uwopt.evaluation.design import evaluate_design
from uwopt.evaluation.influences import influences_of
from uwopt.evaluation.leaning import tilt_notes
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
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL
from uwopt.results.design import PRACTICE_MISSED, Design, Margin, Note
from uwopt.results.result import Result
from uwopt.tolerances import SATISFIED_REL

GAIN_STEP_DB = 0.1  # in which most cameras are set
STEP_DIGITS = 1e-4  # of a step: as nearly as a gain typed as a ratio tells


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
    start, deadline = time.perf_counter(), Deadline.after(seconds)
    timing: dict[str, float] = {}
    as_written = prepared(mission, physics, None, confidence)
    wanted = as_written.without_gain_cap  # what is given is not refused for it
    auto = wanted.physics == "auto"
    allowed = math.inf  # error of integrals
    if checked_tolerance(tolerance) is not None:
        allowed = of_integrals(tolerance or 0.0, may_leave_out=auto)
        wanted = wanted.with_changes(tolerance=(tolerance or 0.0) - allowed) if auto else wanted
    built = load_system(system)
    built.check_scenes(wanted)
    asked = wanted
    if built.camera_count != wanted.vehicle.camera_count:
        if wanted.vehicle.camera_baseline_m is not None:
            raise MissionError([
                f"{built.source_name}: camera_count = {built.camera_count}, where the mission asks for a stereo pair "
                "(vehicle.camera_baseline_m); set it to 2"
            ])  # fmt: skip
        vehicle = {**wanted.to_dict()["vehicle"], "camera_count": built.camera_count}
        wanted = wanted.with_changes(vehicle=vehicle)
    goal = goal_of(wanted)
    with timed(timing, "catalogue"):
        problem, hardware = system_problem(wanted, built)
    given = [scene_settings(problem, hardware, built, scene.name) for scene in problem.scenes]
    with timed(timing, "effects"):
        influences = influences_of(problem, hardware, given)
    if auto:
        problem = problem.with_effects(effects_kept(influences))

    def evaluated(at: Problem) -> Design:
        return evaluate_design(at, hardware, given, goal, level_tolerance_rel=LEVEL_TOLERANCE_REL)

    measured = None
    if accuracy or tolerance is not None:
        with timed(timing, "accuracy"):
            if tolerance is None:
                in_time = estimator_of(problem, lambda at: deadline.in_time(lambda: evaluated(at)))
                measured = deadline.within("errors of figures", lambda: in_time.errors(problem.fineness), None)
            else:
                estimator = estimator_of(problem, evaluated)
                measured = estimator.cheapest(allowed, coarsest(estimator.parts))
                problem = problem.with_fineness(measured.fineness)
    with timed(timing, "evaluation"):
        elsewhere = departures(asked, load_catalog(asked), built, problem, hardware, given, goal)
        design = with_compatibility(evaluated(problem), problem, wanted, elsewhere)
    counted = None
    if confidence is not None and wanted.confidence != CENTRAL:
        from uwopt.api.certainty import confidence_of  # brings the search, which nothing else here needs

        with timed(timing, "certainty"):
            counted = deadline.within(
                STAGES["certainty"],
                lambda: confidence_of(problem, hardware, goal, wanted.confidence, given[0], design, deadline),
                None,
            )
    result = base_result("evaluate", wanted, goal, problem, influences)
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
            *tilt_notes(problem, hardware, given),
            *gain_notes(as_written, design),
            *practice_notes(as_written, built, design),
            *accuracy_warnings(measured, allowed),
            *time_warnings(deadline),
        ],
        accuracy=plain_accuracy(measured, allowed, None, []),
        timing_s={**timing, "total": time.perf_counter() - start},
    )
    return with_risks(made)


def practice_notes(mission: Mission, system: System, design: Design) -> list[Note]:
    """That a system misses what good practice has filled in alone, and nothing that the mission itself says."""
    every = () if design.feasible else yields_of(mission)
    if not every:
        return []
    plain = evaluate(with_yields(mission, every), system).best
    text = (
        "what the mission itself says is met: all that is missed is good practice, of which solve lets give way what "
        "nothing keeps"
    )
    return [Note(PRACTICE_MISSED, "practice", text)] if plain is not None and plain.feasible else []


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


def with_compatibility(
    design: Design, problem: Problem, mission: Mission, elsewhere: Sequence[Departure] = ()
) -> Design:
    """A design with what does not fit together among its parts, or not on the vehicle, as margins that are missed."""
    parts = problem.parts
    findings = explain_pair(
        parts.cameras[0], parts.lenses[0], parts.ports[0], parts.lights[0],
        frame_rate_hz=max(float(s.settings["frame_rate_hz"] or 0.0) for s in design.scenes) or None,
    )  # fmt: skip
    strict = "lens rating" if mission.catalog.lens_rating == "limit" else ""
    faults = [f.rule for f in findings if f.severity == "fault" or f.rule == strict]
    faults += unwanted_kind(problem, mission)
    faults += [departure.rule for departure in elsewhere if departure.binds]
    notes = [Note(f.rule, "hardware", f.message) for f in findings]
    notes += [*(departure.note for departure in elsewhere), *breathing_notes(design), *design.warnings]
    notes += inexact_level_notes(design)
    if not faults:
        return replace(design, warnings=notes)
    missed = [Margin(f"fits: {rule}", 0.0, 1.0, ">=", -1.0, "", None, False, False) for rule in faults]
    scenes = [replace(scene, margins=[*scene.margins, *missed]) for scene in design.scenes]
    return replace(design, scenes=scenes, feasible=False, warnings=notes)


def unwanted_kind(problem: Problem, mission: Mission) -> list[str]:
    """Where the camera's shutter or colour is not what a scene asks for."""
    camera = problem.parts.cameras[0]
    return sorted(
        {
            key
            for view in mission.views
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
