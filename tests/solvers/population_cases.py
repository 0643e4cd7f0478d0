"""Random cases for population searches, and the fronts that an enumeration of their settings gives."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import random_cases as rc
from scene_search import SceneSearch

from uwopt.evaluation.design import evaluate_design
from uwopt.evaluation.design_model import design_model
from uwopt.forward.focus import place_focus
from uwopt.objectives.dominance import nondominated
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.exact.search import Search
from uwopt.solvers.settable.rounding import exact_settings

SMALL: dict[str, Any] = {"pop_size": 40, "generations": 25}
#: Random cases that have designs, found by trying seeds: one scene and two, steps, flashes, mean levels.
FEASIBLE = (3, 7, 8, 9, 10, 13, 14, 17, 22, 24)

LAMPS = {
    "steps": rc.lamp("steps", kind="continuous", flux_lm=20_000.0, power_w=200.0, dim_levels=(0.1, 0.25, 0.5, 1.0)),
    "free": rc.lamp("free", kind="continuous", flux_lm=20_000.0, power_w=200.0),
    "pulsed": rc.lamp("pulsed", kind="pulsed_led", flux_lm=40_000.0, power_w=400.0, min_pulse_us=1.0,
                      max_pulse_us=5_000.0, max_duty_frac=0.5, max_rate_hz=30.0),
    "flash": rc.lamp("flash", kind="flash", flash_energy_j=20.0, flash_efficacy_lm_s_per_j=35.0,
                     flash_duration_us=1_000.0, recycle_s=0.2, charging_efficiency_frac=0.7),
}  # fmt: skip


def search_of(case: Any, names: tuple[str, ...]) -> Search:
    """A prepared search that knows these terms."""
    wanted = Objective(dict.fromkeys(names, 1.0))
    search = Search(case.problem(), wanted, top=1, progress=None)
    search.prepare()
    return search


@cache
def front(seed: int, names: tuple[str, ...], **options: Any) -> tuple[Search, Any]:
    """A case's front by a short run, made once."""
    from uwopt.solvers.population.pymoo_front import population_front

    search = search_of(rc.case(seed), names)
    return search, population_front(search, names, **{**SMALL, **options})


def evaluated(search: Search, found: Any, objective: Objective) -> Any:
    """What `evaluate` says of a found design."""
    hardware = found.hardware
    model = design_model(search.problem, hardware)
    given = [exact_settings(model, i, numbers) for i, numbers in enumerate(found.settings)]
    return evaluate_design(search.problem, hardware, given, objective)


def evaluated_values(search: Search, found: Any, names: tuple[str, ...]) -> tuple[Any, Any]:
    """A found design evaluated once, and from the terms that its objective was given every one of these, minimised."""
    seen: list[Terms] = []

    class Watching(Objective):
        def cost_to_minimise(self, terms: Terms) -> Any:
            seen.append(terms)
            return super().cost_to_minimise(terms)

    design = evaluated(search, found, Watching({names[0]: 1.0}))
    (terms,) = seen
    return design, np.array([Objective.of(name).cost_to_minimise(terms)[0] for name in names])


def enumerated_power_and_cost(seed: int) -> Any:
    """Least power and cost of every hardware, by dense grids through the forward model alone."""
    bench = rc.bench(seed)
    every = brute.enumerate_all(bench, Objective.of("power"))
    return np.array(
        [
            (best.power_w, brute.fixed_terms(bench.model(best.hardware))["cost"])
            for best in every
            if math.isfinite(best.value)
        ]
    )


def enumerated_with_snr(seed: int) -> Any:
    """Power, cost and negative SNR of grids over every hardware's settings; one scene only."""
    bench = rc.bench(seed)
    limit = bench.problem.mission.limits.power_w
    found = []
    for hardware in brute.buildable(bench.problem):
        model = bench.model(hardware)
        if not brute.passes_without_light(model) or brute.misses_limits(model):
            continue
        terms = brute.fixed_terms(model)
        focus = place_focus(bench.problem.scenes, model.maps, model.views)
        left = np.inf if limit is None else limit - terms["camera_power_w"]
        scene = SceneSearch(model, 0, float(focus.dioptre_per_m[0][0]), left)
        if not scene.possible:
            continue
        meeting = scene.prepare(33)
        power, snr, *_ = scene.candidates(brute.f_numbers(*scene.f_range, meeting))
        if len(power):
            rows = np.column_stack(
                [power + terms["camera_power_w"], np.full(len(power), terms["cost"]), -20.0 * np.log10(snr)]
            )
            found.append(rows[nondominated(rows)])
    every = np.concatenate(found)
    return every[nondominated(every)]


def enumerated_with_information(case: Any) -> Any:
    """Power and negative information of grids over the settings of every hardware of a case of one scene."""
    bench = brute.Bench(case.problem())
    found = []
    for hardware in brute.buildable(bench.problem):
        model = bench.model(hardware)
        focus = place_focus(bench.problem.scenes, model.maps, model.views)
        scene = SceneSearch(model, 0, float(focus.dioptre_per_m[0][0]), np.inf)
        f_number = brute.f_numbers(*scene.f_range, scene.prepare(17))
        power, snr, time_s, level, f_number = scene.candidates(f_number)
        one = scene.setting_rows({"time_s": time_s[0], "level": level[0], "f_number": f_number[0]})
        gain = np.array([scene.setting_rows({"time_s": t, "level": u, "f_number": n}).gain[0]
                         for t, u, n in zip(time_s, level, f_number, strict=True)])  # fmt: skip
        offset = float(model.cameras.exposure_offset_s[0])
        rows = replace(one, f_number=f_number, exposure_s=time_s - offset, level=level, gain=gain, **{
            name: np.full(len(snr), getattr(one, name)[0]) for name in ("pulse_s", "rate_hz", "dioptre_per_m")
        })  # fmt: skip
        bits = model.figures(0, rows, information=True).information_bit_per_m2
        found.append(np.column_stack([power + brute.fixed_terms(model)["camera_power_w"], -bits]))
    every = np.concatenate(found)
    return every[nondominated(every)]
