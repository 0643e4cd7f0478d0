"""A generic search over the settings of one hardware: the audit's weapon, for any objective.

It knows no closed form and no bound of the exact search: settings are drawn at random, then ever closer around
the best, and judged by the forward model's own figures and margins.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.compatibility import explain_pair
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import Hardware
from uwopt.forward.figures import SettingRows, figures_of
from uwopt.forward.focus import place_focus
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.problem import Problem
from uwopt.forward.spacers import needed_spacer_m
from uwopt.objectives.objective import Objective, Terms
from uwopt.objectives.requirements import MarginRows
from uwopt.units import ratio_to_db

POINTS, ROUNDS, NARROWER = 256, 14, 0.6
AT_AN_END = 0.15  # share of the numbers that are drawn at either end of their range, where optima often lie
UNCHANGED = 0.3  # share of the numbers of a point that stay as they are in the best one
DIMMEST, DIMMEST_IN_SUN = 1e-4, 1e-7  # of full light; the sun may do almost all
EXACT_REL, LEAST_SIZE = 1e-9, 1e-3  # a margin missed by rounding alone: no gain comes from tolerances
MOST_MISSED = 1e3
LEVEL_STEPS = 4


def attack(problem: Problem, hardware: Hardware, objective: Objective, rng: np.random.Generator) -> float:
    """Best feasible objective, minimised, that is found for one hardware; inf: none."""
    if not fits(problem, hardware):
        return np.inf
    try:
        model = DesignModel(problem, hardware)
    except ArithmeticError:
        return np.inf
    if not reachable_focus(model):
        return np.inf
    spread = Spread(model)
    best_point, least_missed, best_value = None, np.inf, np.inf
    for number in range(ROUNDS):
        points = spread.sample(rng, POINTS, around=best_point, width=NARROWER**number)
        value, missed = judge(model, spread, points, objective)
        score = np.where((missed <= 0) & np.isfinite(value), value, np.inf)
        if np.isfinite(score).any():
            pick = int(score.argmin())
            if score[pick] < best_value:
                best_value, best_point, least_missed = float(score[pick]), points[pick], 0.0
        elif least_missed > 0 and missed.min() < least_missed:
            pick = int(missed.argmin())
            best_point, least_missed = points[pick], float(missed[pick])
    return best_value


def fits(problem: Problem, hardware: Hardware) -> bool:
    """Whether camera and lens go together, and the lens is sharp enough where that is a limit."""
    strict = "lens rating" if problem.mission.catalog.lens_rating == "limit" else ""
    faults = explain_pair(**problem.parts.of(hardware), required_depth_m=problem.mission.required_depth_m)
    return not any(
        (f.severity == "fault" or f.rule == strict) and f.rule in ("complete", "mount", "image circle", "lens rating")
        for f in faults
    )


def reachable_focus(model: DesignModel) -> bool:
    """Whether the lens, on a ring where it has some, focuses where the virtual image of the wanted depth lies."""
    focus = place_focus(model.problem.scenes, model.maps, model.views)
    return all(np.isfinite(needed_spacer_m(model.lenses, dioptre)[0]) for dioptre in focus.dioptre_per_m)


@dataclass(frozen=True)
class Numbers:
    """What a point says of one scene, in the order of its columns."""

    f_number: Array
    time_s: Array  # that collects light
    level: Array
    gain: Array
    open_s: Array  # least exposure


class Spread:
    """The box of settings of one design, in logarithms: f-number, time, level, gain and open shutter by scene.

    The f-number is common to all scenes unless the lens is motorised. The focus is placed by the same rule as in
    the search: it is part of what the certificate covers.
    """

    def __init__(self, model: DesignModel):
        self.model = model
        self.focus = place_focus(model.problem.scenes, model.maps, model.views)
        self.rates = [model.asked_rate_hz(index, float(at[0])) for index, at in enumerate(self.focus.dioptre_per_m)]
        ranges: list[tuple[float, float]] = []
        self.places: list[list[int]] = []  # by scene: where its five numbers stand in a point
        own = bool(model.lenses.motorised[0])
        for index in range(len(model.problem.scenes)):
            of_scene = self._ranges(index)
            if index > 0 and not own:
                self.places.append([0, *range(len(ranges), len(ranges) + 4)])
                ranges += of_scene[1:]
            else:
                self.places.append(list(range(len(ranges), len(ranges) + 5)))
                ranges += of_scene
        self.low, self.high = np.log(np.array(ranges)).T

    def _ranges(self, index: int) -> list[tuple[float, float]]:
        """Least and most f-number, light-collecting time, level, gain and exposure in one scene."""
        model, rate = self.model, self.rates[index]
        lens, cam, light = model.lenses, model.cameras, model.lights
        limit_s = model.problem.mission.limits.max_exposure_ms * 1e-3
        open_s = min(cam.max_exposure_s[0], limit_s, 1.0 / rate if rate > 0 else np.inf)
        shut_s = max(cam.min_exposure_s[0], 1e-9)
        longest, shortest = open_s, shut_s
        if light.kind[0] not in (CONTINUOUS, FLASH):
            longest = min(open_s, light.max_pulse_s[0])
            shortest = max(light.min_pulse_s[0], 1e-7)
        sunlit = model.rows[index].sun is not None
        dimmest = max(light.min_level[0], DIMMEST_IN_SUN if sunlit else DIMMEST)
        levelled = model.problem.scenes[index].view.requirements.mean_level is not None
        widest = lens.f_number_from(model.problem.scenes[index].view.requirements.lens_stop_down)[0]
        closest = lens.f_number_max[0]
        if model.problem.f_number is not None:
            widest = closest = model.problem.f_number
        least, most = model.problem.gains(index, cam.max_gain)
        return [
            (widest, max(widest, closest)), (shortest, max(longest, shortest)), (dimmest, 1.0),
            (1.0, np.e) if levelled else (least, max(most[0], least)),
            (shut_s, max(open_s, shut_s) if sunlit else shut_s),
        ]  # fmt: skip

    def sample(self, rng: np.random.Generator, count: int, *, around: Array | None, width: float) -> Array:
        """Points in the box, all of it at first, then ever closer around the best, some numbers at an end."""
        span, shape = self.high - self.low, (count, len(self.low))
        end = rng.random(shape)

        def pushed(points: Array) -> Array:
            return np.where(end < AT_AN_END, self.low, np.where(end > 1.0 - AT_AN_END, self.high, points))

        points = pushed(self.low + span * rng.random(shape))
        if around is not None:
            near = around + 0.5 * width * span * rng.standard_normal(shape)
            near = np.where(rng.random(shape) < UNCHANGED, around, near)
            share = rng.random((count, 1))
            points = np.where(share < 0.6, near, np.where(share < 0.85, pushed(near), points))
        return np.clip(points, self.low, self.high)

    def settings(self, index: int, points: Array) -> SettingRows:
        """One scene's settings of these points."""
        numbers = Numbers(*np.exp(points[:, self.places[index]]).T)
        light = self.model.lights
        if not light.dims_freely[0]:
            steps = light.levels[0][~np.isnan(light.levels[0])]
            nearest = np.abs(np.log(steps)[None, :] - np.log(numbers.level)[:, None]).argmin(axis=1)
            numbers = replace(numbers, level=steps[nearest])
        if self.model.problem.scenes[index].view.requirements.mean_level is not None:
            numbers = self._at_wanted_level(index, numbers)
        return self._rows(index, numbers)

    def _rows(self, index: int, at: Numbers) -> SettingRows:
        """These numbers as settings: shutter and pulse as the lamp needs them."""
        light, cam, n = self.model.lights, self.model.cameras, len(at.time_s)
        if light.kind[0] == CONTINUOUS:
            exposure, pulse = at.time_s, np.full(n, np.inf)
        elif light.kind[0] == FLASH:
            pulse = np.full(n, light.flash_duration_s[0])
            exposure = np.where(cam.readout_s[0] > 0, pulse + cam.readout_s[0], at.time_s)
        else:
            pulse = at.time_s
            exposure = np.maximum(cam.min_exposure_s[0], at.time_s + cam.readout_s[0])
        if light.kind[0] != CONTINUOUS:  # the sun shines while no lamp does
            exposure = np.maximum(exposure, at.open_s)
        rate, dioptre = (
            np.full(n, value) for value in (self.rates[index], self.focus.dioptre_per_m[index][0])
        )
        return SettingRows(at.f_number, exposure, pulse, at.gain, at.level, rate, dioptre)

    def _at_wanted_level(self, index: int, at: Numbers) -> Numbers:
        """With the gain that gives the wanted mean level, and where none does, with as much more or less light:
        no random draw would hit it. What was drawn as gain says whether the level or the time gives way first."""
        by_level = at.gain < np.sqrt(np.e)
        low, high = np.exp(self.low[self.places[index]]), np.exp(self.high[self.places[index]])
        wanted = self._times_to_wanted(index, replace(at, gain=np.ones_like(at.gain)))
        least, most = self.model.problem.gains(index, self.model.cameras.max_gain)
        at = replace(at, gain=np.clip(wanted, least, most[0]))
        own = index == 0 or self.places[index][0] != 0
        for _ in range(LEVEL_STEPS):  # dark current and the sun do not follow the light
            more = self._times_to_wanted(index, at)
            for first in (True, False):
                if self.model.lights.dims_freely[0]:
                    level = np.where(by_level == first, np.clip(at.level * more, low[2], high[2]), at.level)
                    more, at = more * at.level / level, replace(at, level=level)
                time_s = np.where(by_level != first, np.clip(at.time_s * more, low[1], high[1]), at.time_s)
                more, at = more * at.time_s / time_s, replace(at, time_s=time_s)
            if own:
                at = replace(at, f_number=np.clip(at.f_number / np.sqrt(more), low[0], high[0]))
        return at

    def _times_to_wanted(self, index: int, at: Numbers) -> Array:
        """How many times more than now is wanted in the image, black level apart."""
        scene, cam = self.model.problem.scenes[index], self.model.cameras
        figures = figures_of(scene, self.model.rows[index], self._rows(index, at))
        full, black = 2.0 ** cam.bits[0] - 1.0, cam.black_level_dn[0]
        reached = np.maximum(figures.mean_level[:, scene.nominal] * full - black, 1e-300)
        return np.clip((scene.view.requirements.mean_level * full - black) / reached, 1e-9, 1e9)


def judge(model: DesignModel, spread: Spread, points: Array, objective: Objective) -> tuple[Array, Array]:
    """Objective, minimised, and how much all margins together are missed (0: feasible) at these points."""
    scenes = model.problem.scenes
    missed, by_scene, every_scene = np.zeros(len(points)), [], []
    for index, scene in enumerate(scenes):
        settings = spread.settings(index, points)
        figures = model.figures(index, settings, information=bool(objective.weight("information")))
        terms = model.totals(figures)
        bits = figures.information_bit_per_m2
        by_scene.append(
            (
                -terms["power_w"], figures.snr[:, scene.nominal], figures.contrast[:, scene.nominal],
                np.zeros(len(points)) if bits is None else bits,
            )
        )  # fmt: skip
        for margin in model.margins(index, settings, figures):
            missed = missed + missed_share(margin)
        every_scene.append(figures)
    for margin in model.duration_margins(every_scene) if len(scenes) > 1 else ():
        missed = missed + missed_share(margin)
    less_power, snr, contrast, information = np.min(by_scene, axis=0)  # the worst scene counts
    every = np.ones(len(points))
    value = objective.cost_to_minimise(
        Terms(
            -less_power, terms["cost"] * every, terms["mass_kg"] * every,
            ratio_to_db(np.maximum(snr, 1e-30)), max(float(v.gsd_m[0, 1]) * 1e3 for v in model.views) * every,
            contrast, information,
        )
    )  # fmt: skip
    return value, missed


def missed_share(margin: MarginRows) -> Array:
    """How much one margin is missed beyond rounding, as a share of its limit."""
    size = np.maximum(np.abs(np.where(np.isfinite(margin.limit), margin.limit, 1.0)), LEAST_SIZE)
    with np.errstate(invalid="ignore"):
        share = np.maximum(-margin.margin / size - EXACT_REL, 0.0)
    return np.minimum(np.nan_to_num(share, nan=MOST_MISSED, posinf=MOST_MISSED), MOST_MISSED)
