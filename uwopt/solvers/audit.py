"""An attack on the certificate: discarded combinations solved again by other means.

Combinations are drawn from what each rule discarded. Each gets the forward model in full physics and
a generic search over its settings (random, then shrinking around the best); one that is feasible and
better than the recommendation makes the audit fail.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.compatibility import explain_pair
from uwopt.design_model import DesignModel, Hardware
from uwopt.figures import SettingRows, figures_of
from uwopt.hardware import CONTINUOUS, FLASH
from uwopt.objectives.margins import SATISFIED_REL
from uwopt.objectives.objective import Objective, Terms
from uwopt.optics import place_focus, required_rate_hz
from uwopt.problem import Problem
from uwopt.solvers.exact import Search
from uwopt.solvers.imagers import view_clears

Array = NDArray[Any]
POINTS, ROUNDS = 384, 7
BEATS_REL = 1e-6


@dataclass(frozen=True)
class Attempt:
    """One combination tried again."""

    rule: str
    hardware: Hardware
    value: float  # minimised objective of the best feasible settings found; inf: none


def audit(
    search: Search, objective: Objective, *, count: int, seed: int, best_value: float | None
) -> dict[str, Any]:
    """Draw, attack, report."""
    rng = np.random.default_rng(seed)
    drawn = draw(search, count, rng)
    goal = np.inf if best_value is None else best_value
    found = [Attempt(rule, hw, attack(search.problem, hw, objective, rng)) for rule, hw in drawn]
    better = [a for a in found if a.value < goal - BEATS_REL * abs(goal)] if np.isfinite(goal) else [
        a for a in found if np.isfinite(a.value)
    ]  # fmt: skip
    by_rule: dict[str, int] = {}
    for attempt in found:
        by_rule[attempt.rule] = by_rule.get(attempt.rule, 0) + 1
    parts = search.problem.parts
    return {
        "tried": len(found),
        "by_rule": by_rule,
        "feasible": sum(bool(np.isfinite(a.value)) for a in found),
        "passed": not better,
        "better": [
            {
                "rule": a.rule, "camera": parts.cameras[a.hardware.camera].id, "lens": parts.lenses[a.hardware.lens].id,
                "port": parts.ports[a.hardware.port].id, "light": parts.lights[a.hardware.light].id,
                "light_count": a.hardware.count, "objective_value": objective.reported(a.value),
            }
            for a in better
        ],
    }  # fmt: skip


def draw(search: Search, count: int, rng: np.random.Generator) -> list[tuple[str, Hardware]]:
    """Combinations from each rule's discards, as evenly as there are rules."""
    problem = search.problem
    low, high = problem.count_range
    pools = {rule: pool for rule, pool in search.discarded_samples(max(count, 1), rng).items() if pool}
    drawn: list[tuple[str, Hardware]] = []
    rules = sorted(pools)
    n_lights = len(problem.parts.lights)
    if n_lights == 0:
        return drawn
    for number in range(count):
        if not rules:
            break
        rule = rules[number % len(rules)]
        camera, lens, port, landscape, light = pools[rule][int(rng.integers(len(pools[rule])))]
        chosen = int(rng.integers(n_lights)) if light is None else light
        mount = problem.mounts[int(rng.integers(len(problem.mounts)))]
        drawn.append(
            (rule, Hardware(camera, lens, port, landscape, chosen, int(rng.integers(low, high + 1)), mount))
        )
    return drawn


def attack(problem: Problem, hardware: Hardware, objective: Objective, rng: np.random.Generator) -> float:
    """Best feasible objective that a generic search over the settings finds for one hardware."""
    parts = problem.parts
    strict = "lens rating" if problem.mission.catalog.lens_rating == "limit" else ""
    faults = explain_pair(
        parts.cameras[hardware.camera], parts.lenses[hardware.lens], parts.ports[hardware.port],
        parts.lights[hardware.light], required_depth_m=problem.mission.required_depth_m,
    )  # fmt: skip
    if any(
        (f.severity == "fault" or f.rule == strict) and f.rule in ("mount", "image circle", "lens rating")
        for f in faults
    ):
        return np.inf
    try:
        model = DesignModel(problem, hardware)
    except ArithmeticError:
        return np.inf
    if not reachable_focus(model) or not all(
        view_clears(problem, hardware.port, v).all() for v in model.views
    ):
        return np.inf
    spread = Spread(model)
    best_point, best_violation, best_value = None, np.inf, np.inf
    for number in range(ROUNDS):
        points = spread.sample(rng, POINTS, around=best_point, width=0.5**number)
        value, violation = judge(model, spread, points, objective)
        score = np.where(violation <= 0, value, np.inf)
        if np.isfinite(score).any():
            pick = int(score.argmin())
            if score[pick] < best_value:
                best_value, best_point, best_violation = float(score[pick]), points[pick], 0.0
        elif best_violation > 0:
            pick = int(violation.argmin())
            if violation[pick] < best_violation:
                best_point, best_violation = points[pick], float(violation[pick])
    return best_value


def reachable_focus(model: DesignModel) -> bool:
    """Whether the lens focuses as near as the virtual image of the wanted depth lies."""
    focus = place_focus(model.problem.scenes, model.maps, model.views)
    near, focal = float(model.lenses.min_object_distance_m[0]), float(model.lenses.focal_length_m[0])
    distances = [1.0 / float(dioptre[0]) for dioptre in focus.dioptre_per_m]
    return all(distance >= near * (1 - 1e-9) and distance > focal for distance in distances)


class Spread:
    """The box of settings of one design: f-number, then time, level and gain by scene, in logarithms.

    The focus is placed by the same rule as in the search: it is part of what the certificate covers.
    """

    def __init__(self, model: DesignModel):
        self.model = model
        self.focus = place_focus(model.problem.scenes, model.maps, model.views)
        lens, cam, light = model.lenses, model.cameras, model.lights
        limits = model.problem.mission.limits
        self.rates = [
            float(required_rate_hz(s.view.requirements, s.view.vehicle.speed_m_s, v.footprint_along_m).max())
            for s, v in zip(model.problem.scenes, model.views, strict=True)
        ]
        low, high = [np.log(lens.f_number_min[0])], [np.log(lens.f_number_max[0])]
        for rate in self.rates:
            longest = min(
                cam.max_exposure_s[0], limits.max_exposure_ms * 1e-3, 1.0 / rate if rate > 0 else np.inf
            )
            shortest = max(cam.min_exposure_s[0], 1e-9)
            if light.kind[0] not in (CONTINUOUS, FLASH):
                longest = min(longest, light.max_pulse_s[0])
                shortest = max(light.min_pulse_s[0], 1e-7)
            longest = max(longest, shortest)
            low += [np.log(shortest), np.log(max(light.min_level[0], 1e-4)), 0.0]
            high += [np.log(longest), 0.0, np.log(max(cam.max_gain[0], 1.0))]
        self.low, self.high = np.array(low), np.array(high)

    def sample(self, rng: np.random.Generator, count: int, *, around: Array | None, width: float) -> Array:
        """Points in the box, all of it at first, then ever closer around the best."""
        span = self.high - self.low
        points = self.low + span * rng.random((count, len(span)))
        if around is not None:
            near = around + 0.5 * width * span * rng.standard_normal((count, len(span)))
            points = np.where(rng.random((count, 1)) < 0.8, near, points)
        points = np.clip(points, self.low, self.high)
        points[: len(span)] = np.where(
            rng.random((len(span), len(span))) < 0.5, self.low, points[: len(span)]
        )
        return np.asarray(points)

    def settings(self, index: int, points: Array) -> SettingRows:
        """One scene's settings of these points."""
        model = self.model
        dioptre = np.full(len(points), float(self.focus.dioptre_per_m[index][0]))
        time_s, level, gain = (np.exp(points[:, 1 + 3 * index + k]) for k in range(3))
        light, cam = model.lights, model.cameras
        if not light.dims_freely[0]:
            steps = light.levels[0][~np.isnan(light.levels[0])]
            level = steps[np.abs(np.log(steps)[None, :] - np.log(level)[:, None]).argmin(axis=1)]
        n = len(points)
        if light.kind[0] == CONTINUOUS:
            exposure, pulse = time_s, np.full(n, np.inf)
        elif light.kind[0] == FLASH:
            pulse = np.full(n, light.flash_duration_s[0])
            exposure = np.where(cam.readout_s[0] > 0, pulse + cam.readout_s[0], time_s)
        else:
            pulse = time_s
            exposure = np.maximum(cam.min_exposure_s[0], time_s + cam.readout_s[0])
        rate = np.full(n, self.rates[index])
        rows = SettingRows(np.exp(points[:, 0]), exposure, pulse, gain, level, rate, dioptre)
        return self._with_wanted_gain(index, rows)

    def _with_wanted_gain(self, index: int, rows: SettingRows) -> SettingRows:
        """Where a mean level is wanted, the gain that gives it: no random draw would hit it."""
        model = self.model
        scene, cam = model.problem.scenes[index], model.cameras
        wanted = scene.view.requirements.mean_level
        if wanted is None:
            return rows
        unit = SettingRows(
            rows.f_number,
            rows.exposure_s,
            rows.pulse_s,
            np.ones_like(rows.gain),
            rows.level,
            rows.rate_hz,
            rows.dioptre_per_m,
        )
        figures = figures_of(scene, model.rows[index], unit)
        full, black = 2.0 ** cam.bits[0] - 1.0, cam.black_level_dn[0]
        reached = np.maximum(figures.mean_level[:, scene.nominal] * full - black, 1e-300)
        gain = np.clip((wanted * full - black) / reached, 1.0, cam.max_gain[0])
        return SettingRows(
            rows.f_number, rows.exposure_s, rows.pulse_s, gain, rows.level, rows.rate_hz, rows.dioptre_per_m
        )


def judge(model: DesignModel, spread: Spread, points: Array, objective: Objective) -> tuple[Array, Array]:
    """Objective and total violation (0: feasible) of these points."""
    n = len(points)
    violation, power, snr = np.zeros(n), np.zeros(n), np.full(n, np.inf)
    terms: dict[str, Array] = {}
    for index in range(len(model.problem.scenes)):
        settings = spread.settings(index, points)
        figures = model.figures(index, settings)
        terms = model.totals(index, figures)
        for margin in model.margins(index, settings, figures):
            scale = np.maximum(np.abs(np.where(np.isfinite(margin.limit), margin.limit, 1.0)), 1e-12)
            with np.errstate(invalid="ignore"):
                missed = np.maximum(-margin.margin / scale - SATISFIED_REL, 0.0)
            violation = violation + np.minimum(np.nan_to_num(missed, nan=1e3, posinf=1e3), 1e3)
        power = np.maximum(power, terms["power_w"])
        snr = np.minimum(snr, figures.snr[:, model.problem.scenes[index].nominal])
    gsd = max(float(view.gsd_m[0, 1]) * 1e3 for view in model.views)
    snr_db = 20.0 * np.log10(np.maximum(snr, 1e-30))
    ones = np.ones(n)
    value = objective.cost_to_minimise(
        Terms(power, terms["cost"] * ones, terms["mass_kg"] * ones, snr_db, gsd * ones)
    )
    return value, violation
