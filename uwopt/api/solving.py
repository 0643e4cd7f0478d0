"""The two things uwopt does, for Python and for the command line: solve and evaluate."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from uwopt.api.accuracy import (
    Searched,
    accuracy_warnings,
    checked_tolerance,
    estimator_of,
    estimator_of_search,
    of_integrals,
    plain_accuracy,
    search_within,
)
from uwopt.api.floats import own_float_rules
from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import Choice, Selection, select
from uwopt.catalog.compatibility import explain_pair
from uwopt.catalog.load import load_catalog as _load_catalog
from uwopt.deadline import Deadline
from uwopt.errors import CatalogError, MissionError
from uwopt.evaluation.accuracy import coarsest
from uwopt.evaluation.design import evaluate_design
from uwopt.evaluation.design_model import Hardware, SceneSettings, design_model
from uwopt.evaluation.outside import Departure, departures
from uwopt.forward.batch import influences_of
from uwopt.forward.effects import Influence, effects_kept
from uwopt.forward.lamps import Mount
from uwopt.forward.part_columns import FLASH
from uwopt.forward.problem import Parts, Problem
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.system import System, load_system
from uwopt.model.fineness import DEFAULT, Fineness
from uwopt.objectives.objective import Objective
from uwopt.objectives.requirements import SATISFIED_REL
from uwopt.results.result import Certificate, Design, Margin, Result, is_settable
from uwopt.solvers import recommend
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.explain.robustness import SLOW_S
from uwopt.solvers.recommend import GENERIC_GAIN, Sought, design_of, seek
from uwopt.solvers.settable.rounding import exact_settings
from uwopt.solvers.settable.scene import LEVEL_TOLERANCE_REL
from uwopt.solvers.settings.best import scenes_need_cells

Source = str | Path | Mapping[str, Any]
Progress = Callable[[float, str], None]
PROVEN_GAP_REL = 2e-4  # a wider gap is told, and not called an optimum
SOLVERS = ("exact", "casadi", "nlopt", "bonmin")
NOT_MODELLED = (
    "light scattered more than once towards the camera", "shadows and relief of the floor", "ripples of sunlight",
    "reflections between port and lens", "lens distortion and vignetting beyond cos^4",
)  # fmt: skip


def load_catalog(mission: Mission | None = None) -> Catalog:
    """The built-in catalogue, with the own parts and quotes that a mission names."""
    if mission is None:
        return _load_catalog()
    files = [str(mission.resolve_path(name)) for name in mission.catalog.files]
    prices = None if mission.catalog.prices is None else str(mission.resolve_path(mission.catalog.prices))
    return _load_catalog(files, prices, mission.base_dir)


def prepared(mission: Source | Mission, physics: str | None, objective: Any) -> Mission:
    """A mission with the physics and objective of the call."""
    loaded = load_mission(mission)
    changes: dict[str, Any] = {}
    if physics is not None:
        changes["physics"] = physics
    if objective is not None:
        changes["objective"] = objective
    made = loaded.with_changes(**changes) if changes else loaded
    check_physical(made)
    return made


@own_float_rules
def solve(
    mission: Source | Mission,
    *,
    solver: str = "exact",
    objective: str | Mapping[str, float] | None = None,
    physics: str | None = None,
    top: int = 5,
    audit: int = 0,
    seconds: float | None = None,
    alternatives: bool = False,
    accuracy: bool = False,
    tolerance: float | None = None,
    progress: Progress | None = None,
) -> Result:
    """The best system for a mission, with a certificate; see the package's documentation.

    Parameters
    ----------
    mission : file name, mapping or Mission
    solver : exact (search with certificate); casadi or nlopt also solve the settings of the best
        hardware again and report what they find; bonmin solves hardware and settings of the best together
    top : how many designs with other hardware to list, the best included
    audit : how many other combinations to attack, half of them discarded
    seconds : for all of it: what is proven by then is reported with the gap that is left, and what is told of
        a result beyond its proof is left out where there is no time for it
    alternatives : also say what systems of other makers lack
    accuracy : estimate the numerical error of every figure, in `result.accuracy`
    tolerance : largest error of a figure, a share: integrals are taken as coarsely as it allows
    """
    start, deadline = time.perf_counter(), Deadline.after(seconds)
    if solver not in SOLVERS:
        raise MissionError(f"solver {solver!r} is not one of {', '.join(SOLVERS)}")
    wanted = prepared(mission, physics, objective)
    checked_tolerance(tolerance)
    goal = Objective.of(wanted.objective)
    timing: dict[str, float] = {}
    with recommend.timed(timing, "catalogue"):
        catalog = load_catalog(wanted)

    def search(fineness: Fineness) -> Searched:
        return searched(wanted, catalog, goal, top, deadline, progress, timing, fineness)

    if tolerance is None:
        (sought, alternative), measured = search(DEFAULT), None
    else:
        paper = wanted.physics == "paper"
        sunlit = any(view.scene.sun_lux > 0 for view in wanted.views)
        (sought, alternative), measured = search_within(
            tolerance, search, goal, paper=paper, sunlit=sunlit, deadline=deadline
        )
    result = base_result("solve", wanted, goal, sought.problem)
    if not sought.outcome.best:
        result = infeasible_result(
            result, wanted, catalog, goal, sought, alternative, timing, deadline, progress
        )
    else:
        result = found_result(result, goal, sought, alternative, timing, deadline, solver=solver)
        if measured is None and accuracy and not interrupted(result):
            try:
                estimator = estimator_of_search(sought, goal, deadline)
                with recommend.timed(timing, "accuracy"):
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
    if (
        alternatives
        and result.recommendation is not None
        and sought.outcome.complete
        and not interrupted(result)
    ):
        from uwopt.solvers.explain.alternatives import beside_best

        with recommend.timed(timing, "alternatives"):
            told = beside_best(sought.selection, sought.problem, goal, result.recommendation, deadline)
        result = replace(result, alternatives=told)
    if audit:
        result = audited(result, sought, goal, audit, wanted.seed, timing, deadline)
    timing.update({f"search_{name}": value for name, value in sought.outcome.timing_s.items()})
    timing["total"] = time.perf_counter() - start
    return replace(result, timing_s=timing, warnings=[*result.warnings, *time_warnings(deadline)])


def searched(
    mission: Mission, catalog: Catalog, goal: Objective, top: int, deadline: Deadline,
    progress: Progress | None, timing: dict[str, float], fineness: Fineness,
) -> Searched:  # fmt: skip
    """The search over parts that are sold, and with parts to be made where they could matter."""
    policy = mission.catalog.generic
    first: recommend.Generic = "allow" if policy == "allow" else "never"
    with recommend.timed(timing, "search"):
        sought = seek(
            mission, catalog, goal, generic=first, top=top, deadline=deadline, progress=progress,
            fineness=fineness,
        )  # fmt: skip
    alternative: Sought | None = None
    if policy == "fallback" and sought.outcome.complete:
        extra = bool(sought.outcome.best) and scenes_need_cells(sought.problem.scenes, goal)
        patience = deadline.at_most(SLOW_S) if extra else deadline  # no closed form is slow
        with recommend.timed(timing, "search_generic"):
            alternative = generic_search(mission, catalog, goal, sought, top, patience, progress)
        if not sought.outcome.best and alternative is not None and alternative.outcome.best:
            sought, alternative = alternative, None
    return sought, alternative


def generic_search(
    mission: Mission, catalog: Catalog, goal: Objective, sought: Sought, top: int, deadline: Deadline,
    progress: Progress | None,
) -> Sought | None:  # fmt: skip
    """Generic parts come second: searched in full when nothing real fits, else only for a gain of 10 %."""
    best = sought.outcome.best
    ceiling = math.inf
    if best:
        ceiling = best[0].minimised - GENERIC_GAIN * abs(best[0].minimised)
    return seek(
        mission, catalog, goal, generic="allow", top=1 if best else top, deadline=deadline, progress=progress,
        ceiling=ceiling, fineness=sought.problem.fineness,
    )  # fmt: skip


def found_result(
    result: Result,
    goal: Objective,
    sought: Sought,
    alternative: Sought | None,
    timing: dict[str, float],
    deadline: Deadline,
    *,
    solver: str,
) -> Result:
    """A result with a recommendation."""
    from uwopt.solvers.explain.robustness import assumptions

    best = sought.outcome.best
    cut = alternative is not None and alternative.outcome.interrupted
    in_haste = cut or sought.outcome.interrupted
    others: list[Design] = []
    with recommend.timed(timing, "evaluation"):
        try:
            winner = design_of(sought, best[0], goal)
            others = [design_of(sought, found, goal, with_rounding=False) for found in best[1:]]
        except KeyboardInterrupt:  # what is proven is not lost; asked again, it is
            cut, winner = True, design_of(sought, best[0], goal)
    in_haste = in_haste or cut
    generic = None
    if alternative is not None and alternative.outcome.best:
        generic = design_of(alternative, alternative.outcome.best[0], goal)
    doubt: dict[str, Any] | None = None
    opinions: list[dict[str, Any]] = []
    try:
        with recommend.timed(timing, "robustness"):
            if not in_haste:
                doubt = deadline.within(
                    "how firm the answer is", lambda: doubts(sought, goal, winner, deadline), None
                )
        with recommend.timed(timing, "second_opinion"):
            if not in_haste:
                opinions = deadline.within(
                    "second opinions", lambda: second_opinions(sought, goal, solver, deadline), []
                )
    except KeyboardInterrupt:  # what is proven is not lost
        cut = True
    proven = sought.outcome.complete
    hardware = recommend.hardware_of(best[0])
    model = design_model(sought.problem, hardware)
    given = [exact_settings(model, i, numbers) for i, numbers in enumerate(best[0].settings)]
    influences = influences_of(sought.problem, hardware, given, goal)
    proof = certificate(sought.selection, sought.problem, sought.outcome, goal)
    wide = proven and (proof.gap_rel or 0.0) > PROVEN_GAP_REL
    return replace(
        result,
        physics={**result.physics, "effects": [item.as_dict() for item in proven_in_full(influences)]},
        status="stopped" if not proven else "optimal" if is_settable(winner) and not wide else "feasible",
        recommendation=winner,
        runners_up=others,
        generic_alternative=generic,
        certificate=proof,
        assumptions=assumptions(sought.problem, best[0]),
        robustness=doubt,
        solvers=opinions,
        objective={**result.objective, "value": winner.objective_value},
        warnings=[
            *result.warnings,
            *selection_warnings(sought.selection),
            *winner.warnings,
            *(haste_warnings(sought) or (cut_warnings() if cut else [])),
            *(gap_warnings(proof) if wide else []),
        ],
    )


def doubts(
    sought: Sought, goal: Objective, winner: Design, deadline: Deadline
) -> dict[str, Any] | None:
    """What the estimates, the choice of water table and the lamps' places could change."""
    from uwopt.solvers.explain.lamp_places import polished_mount, tilt_tolerance
    from uwopt.solvers.explain.robustness import robustness
    from uwopt.solvers.explain.waters import in_other_waters

    found = robustness(sought, goal, deadline=deadline)
    if found is None:
        return None
    return {
        **found,
        "waters": in_other_waters(sought, goal, deadline),
        "tilt": tilt_tolerance(sought, winner, goal, deadline),
        "outside_certificate": polished_mount(sought, goal, deadline),
    }


def second_opinions(
    sought: Sought, goal: Objective, solver: str, deadline: Deadline
) -> list[dict[str, Any]]:
    """The winner's settings solved again by continuous solvers, compared by objective."""
    from uwopt.solvers.continuous import opinions

    if solver == "bonmin":
        return [
            opinions.mixed_opinion(sought, goal, max_seconds=min(opinions.BONMIN_S, deadline.left_s))
        ]
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


def infeasible_result(
    result: Result, mission: Mission, catalog: Catalog, goal: Objective, sought: Sought,
    alternative: Sought | None, timing: dict[str, float], deadline: Deadline, progress: Progress | None,
) -> Result:  # fmt: skip
    """A result without a recommendation: why, and what would help."""
    from uwopt.solvers.explain.infeasible import explain

    used = alternative or sought
    proof = certificate(used.selection, used.problem, used.outcome, goal)
    with_generic = alternative is not None or mission.catalog.generic == "allow"
    generic: recommend.Generic = "allow" if with_generic else "never"
    why = None
    if used.outcome.complete:
        with recommend.timed(timing, "explanation"):
            why = explain(
                mission, catalog, goal, proof, generic=generic, deadline=deadline, progress=progress
            )
    status = "infeasible" if used.outcome.complete else "stopped"
    return replace(
        result,
        status=status,
        certificate=proof,
        infeasible=why,
        warnings=[
            *result.warnings, *haste_warnings(used), *half_warnings(sought, used), *selection_warnings(used.selection)
        ],
    )  # fmt: skip


def half_warnings(sought: Sought, used: Sought) -> list[dict[str, str]]:
    """That parts on sale are proven not to fit, where the search with parts to be made was cut short."""
    if used is sought or used.outcome.complete or not sought.outcome.complete:
        return []
    text = "no combination of parts on sale fits, which is proven; the search with parts to be made was cut short"
    return [{"code": "parts_on_sale", "path": "catalog.generic", "message": text}]


def audited(
    result: Result, sought: Sought, goal: Objective, count: int, seed: int, timing: dict[str, float],
    deadline: Deadline,
) -> Result:  # fmt: skip
    """A result with the outcome of an attack on its certificate."""
    from uwopt.solvers.exact.audit import audit as attack

    best = sought.outcome.best[0].minimised if sought.outcome.best else None
    with recommend.timed(timing, "audit"):
        report = attack(
            sought.search, goal, count=count, seed=seed, best_value=best,
            lower_bound=sought.outcome.lower_bound, deadline=deadline,
        )  # fmt: skip
    return replace(result, audit=report)


def gap_warnings(proof: Certificate) -> list[dict[str, str]]:
    """That the bounds on settings without a closed form did not close."""
    share = 100.0 * (proof.gap_rel or 0.0)
    text = f"no combination is more than {share:.2g} % better, but the settings' bounds do not close further"
    return [{"code": "gap", "path": "objective", "message": text}]


def haste_warnings(sought: Sought) -> list[dict[str, str]]:
    """That the search was interrupted, if it was."""
    text = "interrupted: the best found so far, without the tests of its doubts"
    if not sought.outcome.best:
        text = "interrupted before a system was found"
    return [{"code": "interrupted", "path": "", "message": text}] if sought.outcome.interrupted else []


def cut_warnings() -> list[dict[str, str]]:
    """That what follows the proof was interrupted."""
    text = "interrupted: the system is proven, but not all that is usually told of it was worked out"
    return [{"code": "interrupted", "path": "", "message": text}]


def time_warnings(deadline: Deadline) -> list[dict[str, str]]:
    """What there was no time for."""
    if not deadline.left_out:
        return []
    text = "the time that was given is over; not worked out: " + "; ".join(dict.fromkeys(deadline.left_out))
    return [{"code": "time", "path": "", "message": text}]


def interrupted(result: Result) -> bool:
    """Whether a person wants no more."""
    return any(warning["code"] == "interrupted" for warning in result.warnings)


def selection_warnings(selection: Selection) -> list[dict[str, str]]:
    """Patterns that match nothing."""
    return [{"code": "pattern", "path": "catalog", "message": text} for text in selection.warnings]


def proven_in_full(influences: Sequence[Influence]) -> list[Influence]:
    """What a certified search keeps: every effect that is there at all, whatever `auto` would leave out."""
    return [replace(item, kept=item.bound > 0.0, time_saved_s=0.0) for item in influences]


def base_result(
    command: str, mission: Mission, goal: Objective, problem: Problem, influences: Sequence[Influence] = ()
) -> Result:
    """What every result carries; physics `full` keeps every effect, however small."""
    import uwopt

    tables = {scene.name: scene.water_table for scene in problem.scenes}
    physics = {
        "name": mission.physics,
        "asked": mission.physics,
        "tolerance": mission.tolerance,
        "fineness": problem.fineness.by_part(),
        "water_table": tables[problem.scenes[0].name] if len(set(tables.values())) == 1 else tables,
        "effects": [
            (item if mission.physics == "auto" else replace(item, kept=True, time_saved_s=0.0)).as_dict()
            for item in influences
        ],
        "not_modelled": list(NOT_MODELLED),
    }
    return Result(
        command=command,
        status="feasible",
        mission=mission.to_dict(),
        physics=physics,
        objective={
            "name": goal.name, "direction": goal.direction, "value": None, "unit": goal.unit(mission.limits.currency)
        },
        uwopt_version=uwopt.__version__,
        seed=mission.seed,
        versions=versions(),
        mission_file=mission.source_file,
    )  # fmt: skip


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that numbers depend on."""
    return dict(installed_versions())


@cache
def installed_versions() -> dict[str, str]:
    """The same, looked up once: reading packages' metadata costs as much as a small evaluation."""
    out = {"python": sys.version.split()[0]}
    for name in ("numpy", "scipy", "casadi", "nlopt", "pymoo", "jerlov"):
        try:
            out[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return out


# ---------------------------------------------------------------- evaluate


@own_float_rules
def evaluate(
    mission: Source | Mission, system: Source | System, *, physics: str | None = None, accuracy: bool = False,
    tolerance: float | None = None,
) -> Result:  # fmt: skip
    """What a given system would do in a mission: figures and margins of every scene.

    `accuracy`: with estimated numerical errors of every figure. `tolerance`: largest error of a figure, a
    share; integrals are then taken as coarsely as it allows.
    """
    start = time.perf_counter()
    timing: dict[str, float] = {}
    wanted = prepared(mission, physics, None)
    auto = wanted.physics == "auto"
    allowed = math.inf  # error of integrals
    if checked_tolerance(tolerance) is not None:
        allowed = of_integrals(tolerance or 0.0, may_leave_out=auto)
        wanted = wanted.with_changes(tolerance=(tolerance or 0.0) - allowed) if auto else wanted
    built = load_system(system)
    built.check_scenes(wanted)
    asked = wanted
    if built.camera_count != wanted.vehicle.camera_count:
        vehicle = {**wanted.to_dict()["vehicle"], "camera_count": built.camera_count}
        wanted = wanted.with_changes(vehicle=vehicle)
    goal = Objective.of(wanted.objective)
    with recommend.timed(timing, "catalogue"):
        problem, hardware = system_problem(wanted, built)
    given = [scene_settings(problem, hardware, built, scene.name) for scene in problem.scenes]
    with recommend.timed(timing, "effects"):
        influences = influences_of(problem, hardware, given, goal)
    if auto:
        problem = problem.with_effects(effects_kept(influences))

    def evaluated(at: Problem) -> Design:
        return evaluate_design(at, hardware, given, goal, level_tolerance_rel=LEVEL_TOLERANCE_REL)

    measured = None
    if accuracy or tolerance is not None:
        with recommend.timed(timing, "accuracy"):
            estimator = estimator_of(problem, evaluated)
            if tolerance is None:
                measured = estimator.errors(problem.fineness)
            else:
                measured = estimator.cheapest(allowed, coarsest(estimator.parts))
                problem = problem.with_fineness(measured.fineness)
    with recommend.timed(timing, "evaluation"):
        elsewhere = departures(asked, load_catalog(asked), built, problem, hardware, given, goal)
        design = with_compatibility(evaluated(problem), problem, wanted, elsewhere)
    result = base_result("evaluate", wanted, goal, problem, influences)
    return replace(
        result,
        status="feasible" if design.feasible else "violated",
        design=design,
        system=built.to_dict(absolute_paths=True),
        objective={**result.objective, "value": design.objective_value},
        warnings=[*result.warnings, *design.warnings, *accuracy_warnings(measured, allowed)],
        accuracy=plain_accuracy(measured, allowed, None, []),
        timing_s={**timing, "total": time.perf_counter() - start},
    )


def system_problem(mission: Mission, system: System) -> tuple[Problem, Hardware]:
    """Tables of one system: its parts from the catalogue or inline."""
    from uwopt.catalog.inline import part_from_inline

    selection = select(
        load_catalog(mission), Choice(owned=mission.catalog.owned), camera_count=mission.vehicle.camera_count
    )

    def part(kind: str) -> Any:
        named = getattr(system, kind)
        if isinstance(named, str):
            return selection.catalog.part(named, kind)  # type: ignore[arg-type]
        try:
            return part_from_inline(kind, named, system.base_dir)  # type: ignore[arg-type]
        except CatalogError as error:
            raise CatalogError([f"{system.source_name}: {kind}: {text}" for text in error.faults]) from None

    parts = Parts((part("camera"),), (part("lens"),), (part("port"),), (part("light"),))
    if system.light_mounts:
        mount = Mount(explicit=tuple(system.light_mounts))
    else:
        vehicle = mission.vehicle
        baseline = (
            system.light_baseline_m
            if system.light_baseline_m is not None
            else vehicle.light_baseline_grid_m[0]
        )
        tilt = system.light_tilt_deg if system.light_tilt_deg is not None else vehicle.light_tilt_grid_deg[0]
        explicit = tuple(vehicle.light_mounts or ()) if system.light_baseline_m is None else ()
        mount = Mount(explicit=explicit) if len(explicit) == system.light_count else Mount(baseline, tilt)
    problem = Problem(
        mission, parts, paper=mission.physics == "paper", owned_lights=recommend.owned_ids(selection),
        counts=(system.light_count, system.light_count), mounts=[mount],
    )  # fmt: skip
    refuse_unknown(system, problem)
    return problem, Hardware(0, 0, 0, system.orientation == "landscape", 0, system.light_count, mount)


def refuse_unknown(system: System, problem: Problem) -> None:
    """Raise where a part of the catalogue lacks a number that nothing can stand in for."""
    vital = {
        "camera": ("pixel pitch", problem.cameras.pixel_pitch_m[0]),
        "port": ("radius", problem.ports.outer_radius_m[0] if problem.ports.is_dome[0] else 1.0),
        "light": ("light output", problem.lights.full_light[0]),
    }
    for kind, (what, value) in vital.items():
        if not value > 0.0:
            raise MissionError(
                f"{system.source_name}: {kind} = {getattr(system, kind)}: its {what} is not known, so nothing can be "
                f"computed with it; write the {kind} as a section with its numbers, or name another"
            )


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
    notes = [{"code": f.rule, "path": "hardware", "message": f.message} for f in findings]
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


def inexact_level_notes(design: Design) -> list[dict[str, str]]:
    """That a mean level is met as well as a gain in steps can, where `solve` meets it exactly."""
    text = f"the mean level is met to {100 * LEVEL_TOLERANCE_REL:g} %, a step of the gain; solve meets it exactly"
    return [
        {"code": "outside_search", "path": "settings.gain", "message": f"{scene.name}: {text}"}
        for scene in design.scenes
        for level in scene.margins
        if level.requirement == "mean_level" and level.satisfied
        if (level.margin or 0.0) < -SATISFIED_REL * (level.limit or 0.0)
    ]


def breathing_notes(design: Design) -> list[dict[str, str]]:
    """A warning where focusing so near changes the field of view, or leaves no image."""
    notes = []
    for scene in design.scenes:
        n, working = scene.figures["f_number"], scene.figures["working_f_number"]
        if n and working is None:
            text = f"{scene.name}: the focus lies within the focal length of the lens; there is no image"
            notes.append({"code": "no_image", "path": "lens", "message": text})
        if n and working and working / n > 1.02:
            share = 100 * (working / n - 1)
            text = f"{scene.name}: focused so near, the lens extends by {share:.1f} % and sees that much less"
            notes.append({"code": "breathing", "path": "lens", "message": text})
    return notes
