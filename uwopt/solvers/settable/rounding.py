"""Settings as a person can set them: stops, tenths of a decibel, microseconds, per cents of light.

Whatever is offered to be set has been evaluated with all light counted and meets every requirement. Among
thirds of a stop (then between them) the best by the objective is taken; where no mark holds, nothing is offered.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from uwopt.deadline import NEVER, Deadline
from uwopt.evaluation.design import evaluate_design
from uwopt.evaluation.design_model import DesignModel, design_model
from uwopt.evaluation.focus_marks import focus_distances_m, focus_marks_m
from uwopt.evaluation.influences import influences_of
from uwopt.evaluation.leaning import leaning_models
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.effects import effects_kept
from uwopt.forward.figures import SettingRows
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.forward.problem import Problem
from uwopt.model.port import lens_dioptre_per_m, water_distance_m
from uwopt.objectives.objective import Objective
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL
from uwopt.results.design import FARTHEST_M, Design
from uwopt.solvers.settable.scene import Near, SettableScene, Tried, terms_of
from uwopt.solvers.settable.steps import rates_hz, stops
from uwopt.tolerances import SATISFIED_REL

HOPELESS = 0.05  # share by which a requirement is missed that no finer rate or focus can mend
MOST_LEAN = 2  # models with effects left out that the search heeds, one after the other
BY_POWER = Objective({"power": 1.0})  # of a design that only has to stay near the optimum


@dataclass(frozen=True)
class Rounded:
    """The settable settings that come nearest to the requirements, and the design that they make."""

    given: list[SceneSettings]
    design: Design


def rounded_design(
    problem: Problem, hardware: Hardware, exact: Sequence[dict[str, Any]], objective: Objective | Near,
    deadline: Deadline = NEVER,
) -> Rounded:  # fmt: skip
    """The best design that can be set; feasible, or the nearest miss where none is. Raises OutOfTimeError.

    `exact` : the optimum's settings by scene, to which the design stays as near as it can where that is the goal.
    What is asked for holds with lamps that lean as far as the mission's reserve as well, where settings are found with
    which it does: else, and past the deadline, with lamps as they should be.
    """
    model = design_model(problem, hardware)
    optimum = [model.settings(i, exact_settings(model, i, numbers)) for i, numbers in enumerate(exact)]
    made = first = rounded_with(problem, hardware, optimum, objective, [], deadline)
    heeded: list[DesignModel] = []
    while made.design.feasible:
        lost = [one for one in leaning_models(problem, hardware).values() if not holds(one, made.given)]
        if not lost:
            return made
        if any(one in heeded for one in lost):
            break
        heeded += lost
        again = partial(rounded_with, problem, hardware, optimum, objective, heeded, deadline)
        made = deadline.within("settings that hold while lamps lean", again, first)
    return first


def rounded_with(
    problem: Problem, hardware: Hardware, optimum: Sequence[SettingRows], objective: Objective | Near,
    heeded: Sequence[DesignModel], deadline: Deadline,
) -> Rounded:  # fmt: skip
    """The same, of which further models are heeded.

    Physics `auto` leaves effects out when the settings are evaluated; the requirements then hold with and without.
    """
    goal = BY_POWER if isinstance(objective, Near) else objective
    model = design_model(problem, hardware)
    leaner: list[DesignModel] = []
    while True:
        given = settable(model, optimum, objective, [*heeded, *leaner], deadline)
        made = Rounded(given, evaluated(problem, hardware, given, goal))
        if not made.design.feasible or problem.mission.physics != "auto":
            return made
        lean = problem.with_effects(effects_kept(influences_of(problem, hardware, given)))
        if lean.effects == problem.effects or holds(design_model(lean, hardware), given):
            return made
        if len(leaner) == MOST_LEAN:
            return Rounded(given, evaluated(lean, hardware, given, goal))
        leaner.append(design_model(lean, hardware))


def settable(
    model: DesignModel,
    optimum: Sequence[SettingRows],
    objective: Objective | Near,
    leaner: Sequence[DesignModel],
    deadline: Deadline,
) -> list[SceneSettings]:
    """The best settings that can be set, or those of the nearest miss; `leaner` models must agree that all holds."""
    nearest: tuple[float, list[SceneSettings]] = (np.inf, [])
    for rates, dioptres in variants(model, optimum):
        scenes = [
            SettableScene(
                model, i, one, objective, rate_hz=rates[i], dioptre_per_m=dioptres[i], leaner=leaner,
                deadline=deadline,
            )
            for i, one in enumerate(optimum)
        ]
        for between in (False, True):
            tried = best_common(model, scenes, objective, between=between)
            nearest = min(nearest, tried, key=lambda found: found[0])
            if nearest[0] == 0.0:
                return nearest[1]
        if nearest[0] > HOPELESS:
            break
    return nearest[1]


def evaluated(problem: Problem, hardware: Hardware, given: list[SceneSettings], goal: Objective) -> Design:
    """A design with these settings, evaluated."""
    return evaluate_design(problem, hardware, given, goal, level_tolerance_rel=LEVEL_TOLERANCE_REL)


def holds(model: DesignModel, given: Sequence[SceneSettings]) -> bool:
    """Whether these settings meet every requirement in a model."""
    by_scene = []
    for index, one in enumerate(given):
        settings = model.settings(index, one)
        figures = model.figures(index, settings)
        by_scene.append(figures)
        margins = model.margins(index, settings, figures, level_tolerance_rel=LEVEL_TOLERANCE_REL)
        if not all(bool(m.satisfied[0]) for m in margins):
            return False
    return len(by_scene) == 1 or all(bool(m.satisfied[0]) for m in model.duration_margins(by_scene))


def variants(model: DesignModel, optimum: Sequence[SettingRows]) -> Iterator[tuple[list[float], list[float]]]:
    """Frame rates and focus to try, by scene: in few figures first; the focus ring stands alike in all scenes."""
    for number, mark_m in enumerate(focus_marks_m(model, float(optimum[0].dioptre_per_m[0]))):
        ring = float(lens_dioptre_per_m(mark_m, focus_map=model.maps[0]))
        dioptres = [typed_dioptre_per_m(model, i, ring) for i in range(len(optimum))]
        asked = [model.asked_rate_hz(index, at) for index, at in enumerate(dioptres)]
        rates = [rates_hz(max(float(one.rate_hz[0]), least)) for one, least in zip(optimum, asked, strict=True)]
        for finer in (False, True):
            if number == 0 or finer:
                yield [rate[finer] for rate in rates], dioptres


def typed_dioptre_per_m(model: DesignModel, index: int, ring: float) -> float:
    """The lens's focus in one scene when its distance in that scene's water is typed in as it is printed."""
    return float(lens_dioptre_per_m(typed_focus_m(model, index, ring), focus_map=model.maps[index]))


def typed_focus_m(model: DesignModel, index: int, dioptre_per_m: float) -> float:
    """The distance in one scene's water at which a lens is focused, as a person sets it."""
    distance_m = float(water_distance_m(dioptre_per_m, focus_map=model.maps[index]))
    return focus_distances_m(distance_m)[0] if 0 < distance_m < FARTHEST_M else FARTHEST_M


def best_common(
    model: DesignModel, scenes: Sequence[SettableScene], objective: Objective | Near, *, between: bool
) -> tuple[float, list[SceneSettings]]:
    """The best settings with an f-number common to all scenes unless the iris has a motor, and what they miss."""
    fixed = model.problem.f_number
    marks = stops(model.lenses, between=between) if fixed is None else np.array([fixed])
    sharp = np.logical_and.reduce([scene.keep_depth(marks) for scene in scenes], axis=0)
    tried = [scene.best_by_stop(marks[sharp] if sharp.any() else marks[-1:]) for scene in scenes]
    if model.lenses.motorised[0]:
        every = np.zeros(len(tried[0].shortfall), np.intp)
        tried = [one.take(one.best_of_each(every)) for one in tried]
    missed = np.max([one.shortfall for one in tried], axis=0)
    mean_power_w = model.problem.duration.mean([one.power_w for one in tried])
    over = mean_power_w / model.problem.duration.mean_power_limit_w - 1.0
    missed = np.maximum(missed, np.where(over > SATISFIED_REL, over, 0.0))
    value = np.max([one.value for one in tried], axis=0)
    if isinstance(objective, Objective):
        value = np.where(missed == 0.0, objective.cost_to_minimise(terms_of(tried)), np.inf)
    in_hand = np.sort(np.concatenate([one.in_hand for one in tried], axis=1), axis=1)
    common = replace(tried[0], shortfall=missed, value=value, in_hand=in_hand, power_w=terms_of(tried).power)
    best = common.best_of_each(np.zeros(len(missed), np.intp))
    return float(missed[best[0]]), [
        scene_settings(scene, one.take(best)) for scene, one in zip(scenes, tried, strict=True)
    ]


def scene_settings(scene: SettableScene, tried: Tried) -> SceneSettings:
    """One scene's settings as the evaluation takes them."""
    one = tried.settings
    pulse_s = float(one.pulse_s[0])
    return SceneSettings(
        f_number=float(one.f_number[0]), exposure_s=float(one.exposure_s[0]),
        pulse_s=pulse_s if np.isfinite(pulse_s) else None, gain=float(one.gain[0]), level=float(one.level[0]),
        rate_hz=float(one.rate_hz[0]), focus_distance_m=typed_focus_m(scene.model, scene.index, scene.dioptre_per_m),
    )  # fmt: skip


def exact_settings(model: DesignModel, index: int, numbers: dict[str, Any]) -> SceneSettings:
    """The search's own settings of one scene, unrounded, as the evaluation takes them."""
    kind = int(model.lights.kind[0])
    pulse = {
        CONTINUOUS: None,
        PULSED: float(numbers["time_s"]),
        FLASH: float(model.lights.flash_duration_s[0]),
    }[kind]
    wanted = model.problem.scenes[index].view.requirements.mean_level
    return SceneSettings(
        f_number=float(numbers["f_number"]),
        exposure_s=float(numbers["exposure_s"]),
        pulse_s=pulse,
        gain=None if wanted is not None else float(numbers["gain"]),
        level=float(numbers["level"]),
        rate_hz=float(numbers["rate_hz"]),
        dioptre_per_m=float(numbers["dioptre_per_m"]),
    )


def given_of(problem: Problem, hardware: Hardware, settings: Sequence[dict[str, Any]]) -> list[SceneSettings]:
    """The search's own settings of one hardware by scene, as the evaluation takes them."""
    model = design_model(problem, hardware)
    return [exact_settings(model, index, numbers) for index, numbers in enumerate(settings)]
