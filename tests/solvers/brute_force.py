"""Exhaustive enumeration of small problems through the forward model alone, to hold the exact search against.

Every combination of hardware is taken; its settings are found by a dense grid over f-number, time and
level that zooms in on the best (or, while nothing is feasible, on the least violation). A setting counts
as feasible when every margin of `DesignModel.margins` is met; nothing of `solvers` takes part.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.compatibility import image_circle_ok, mount_compatible, sensor_diagonal_mm
from uwopt.evaluation import DesignModel, Hardware
from uwopt.figures import Figures, SettingRows, figures_of
from uwopt.hardware import CONTINUOUS, FLASH, PULSED
from uwopt.objectives.objective import Objective, Terms
from uwopt.optics import place_focus, required_rate_hz
from uwopt.problem import Problem

Array = NDArray[Any]
FIRST_GRID, ZOOM_GRID = (25, 13, 13), (9, 7, 7)  # f-number, time, level
FEWEST_ROUNDS, ROUNDS = 6, 24
MEETS = 1e-9  # relative: the enumeration takes no advantage of the 1e-6 that a margin may be missed by
LEVEL_MEETS = 1e-7


@dataclass(frozen=True)
class Best:
    """Best settings found for one hardware."""

    hardware: Hardware
    value: float  # minimised objective; inf: nothing feasible
    power_w: float
    scale: float  # of the terms of the objective, for relative comparisons


def buildable(problem: Problem) -> Iterator[Hardware]:
    """Every hardware whose parts fit together, written anew from the rules in words."""
    parts = problem.parts
    sizes = range(len(parts.cameras)), range(len(parts.lenses)), range(len(parts.ports)), range(len(parts.lights))
    low, high = problem.count_range
    for (c, le, p, li), name, mount, count in itertools.product(
        itertools.product(*sizes), problem.mission.vehicle.orientations, problem.mounts, range(low, high + 1)
    ):
        camera, lens = parts.cameras[c], parts.lenses[le]
        diagonal = sensor_diagonal_mm(camera.resolution_x_px, camera.resolution_y_px, camera.pixel_pitch_um)
        if mount_compatible([camera.mounts], [lens.mounts])[0, 0] and image_circle_ok(diagonal, lens.image_circle_mm):
            yield Hardware(c, le, p, name == "landscape", li, count, mount)


class Bench:
    """Models of one problem's hardware; designs that differ by their lamps alone share the fields."""

    def __init__(self, problem: Problem):
        self.problem = problem
        self._models: dict[Any, DesignModel] = {}
        self._tables_ready = False

    def _reach_once(self) -> None:
        """Water's tables over all that any hardware sees, built once."""
        if not self._tables_ready:
            problem, widest = self.problem, 0.0
            for hw in {replace(h, light=0, count=problem.count_range[0], mount=problem.mounts[0]) for h in buildable(problem)}:
                for view in DesignModel(problem, hw).views:
                    widest = max(widest, 0.75 * float(np.hypot(view.footprint_along_m[0, 2], view.footprint_across_m[0, 2])))
            for index in range(len(problem.scenes)):
                problem.set_reach(index, widest)
            problem.set_reach = lambda scene_index, widest_m: None  # type: ignore[method-assign]
            self._tables_ready = True

    def model(self, hardware: Hardware) -> DesignModel:
        """The forward model of one hardware."""
        self._reach_once()
        lights = self.problem.lights
        optics = int(lights.optics_index[hardware.light])
        key = (replace(hardware, light=optics), float(lights.output_factor[hardware.light]))
        if key not in self._models:
            self._models[key] = DesignModel(self.problem, hardware)
        made = self._models[key]
        if made.hardware == hardware:
            return made
        twin = object.__new__(DesignModel)
        twin.__dict__.update(made.__dict__, hardware=hardware, lights=lights.take(np.array([hardware.light])))
        twin.rows = [replace(rows, lights=twin.lights) for rows in made.rows]
        return twin


def passes_without_light(model: DesignModel) -> bool:
    """Port clears the corner ray, lens focuses at the virtual image: what no margin says."""
    problem, hw = model.problem, model.hardware
    focus = place_focus(problem.scenes, model.maps, model.views)
    near, focal = float(model.lenses.min_object_distance_m[0]), float(model.lenses.focal_length_m[0])
    for index, view in enumerate(model.views):
        distance = 1.0 / float(focus.dioptre_per_m[index][0])
        if distance <= focal or distance < near * (1 - 1e-9):
            return False
        corner = float(np.hypot(view.tan_along[0], view.tan_across[0]))
        flat = not problem.ports.is_dome[hw.port]
        if not problem.paper and flat and corner * problem.ports.gap_m[hw.port] > problem.ports.clear_radius_m[hw.port]:
            return False
    return True


@dataclass(frozen=True)
class Tried:
    """Points tried in one scene: (n_f_number, n_others)."""

    power_w: Array
    snr: Array
    missed: Array  # total relative violation; 0: feasible
    terms: dict[str, float]


class Grid:
    """The settings of one hardware as a box in logarithms: f-number, and time and level of each scene."""

    def __init__(self, model: DesignModel, objective: Objective):
        self.model, self.objective, self.problem = model, objective, model.problem
        self.focus = place_focus(self.problem.scenes, model.maps, model.views)
        light = model.lights
        self.steps = None if light.dims_freely[0] else light.levels[0][~np.isnan(light.levels[0])]
        self.rates = [
            float(required_rate_hz(s.view.requirements, s.view.vehicle.speed_m_s, v.footprint_along_m).max())
            for s, v in zip(self.problem.scenes, model.views, strict=True)
        ]
        self.gsd_mm = max(float(view.gsd_m[0, 1]) * 1e3 for view in model.views)
        self.shared = len(self.rates) > 1 and not model.lenses.motorised[0]

    def box(self, index: int, step: float | None) -> tuple[Array, Array]:
        """Lowest and highest logarithm of f-number, time and level in one scene; the level may be given."""
        cam, light, lens = self.model.cameras, self.model.lights, self.model.lenses
        rate = self.rates[index]
        longest = min(cam.max_exposure_s[0], self.problem.mission.limits.max_exposure_ms * 1e-3, 1 / rate if rate else np.inf)
        shortest = cam.min_exposure_s[0]
        if light.kind[0] == PULSED:
            longest, shortest = min(longest - cam.readout_s[0], light.max_pulse_s[0]), light.min_pulse_s[0]
            longest = min(longest, light.max_duty[0] / rate if rate else np.inf)
        longest = max(longest, 1e-9)
        level = (float(np.log(light.min_level[0])) if light.min_level[0] > 0 else -9.0, 0.0)
        if step is not None:
            level = (float(np.log(step)),) * 2
        low = np.array([np.log(lens.f_number_min[0]), np.log(max(min(shortest, longest), 1e-9)), level[0]])
        return low, np.array([np.log(lens.f_number_max[0]), np.log(longest), level[1]])

    def try_points(self, index: int, f_number: Array, time_s: Array, level: Array) -> Tried:
        """Power, SNR and violation of a product of settings, (n_f_number, n_time * n_level)."""
        model, cam, light = self.model, self.model.cameras, self.model.lights
        n, t, u = (a.ravel() for a in np.broadcast_arrays(f_number[:, None, None], time_s[:, None], level))
        kind, readout = int(light.kind[0]), float(cam.readout_s[0])
        pulse, exposure = np.full(len(t), np.inf), t
        if kind == FLASH:
            pulse = np.full(len(t), float(light.flash_duration_s[0]))
            exposure = np.maximum(pulse + readout, cam.min_exposure_s[0]) if readout > 0 else t
        elif kind == PULSED:
            pulse, exposure = t, np.maximum(cam.min_exposure_s[0], t + readout)
        dioptre = float(self.focus.dioptre_per_m[index][0])
        unit = SettingRows(n, exposure, pulse, np.ones_like(t), u, np.full_like(t, self.rates[index]), np.full_like(t, dioptre))
        rows = replace(unit, gain=self._gain(index, figures_of(self.problem.scenes[index], model.rows[index], unit)))
        figures = model.figures(index, rows)
        missed = np.zeros(len(t))
        for margin in model.margins(index, rows, figures):
            limit = np.where(np.isfinite(margin.limit), np.abs(margin.limit), 1.0)
            slack = LEVEL_MEETS if margin.requirement == "mean_level" else MEETS
            with np.errstate(invalid="ignore"):
                by = np.nan_to_num(-margin.margin / np.maximum(limit, 1e-12), nan=1e3, posinf=1e3)
            missed = missed + np.where(by > slack, np.minimum(by, 1e3), 0.0)
        totals = model.totals(index, figures)
        terms = {name: float(np.ravel(totals[name])[0]) for name in ("cost", "mass_kg")}
        shape = (len(f_number), -1)
        power = np.broadcast_to(totals["power_w"], missed.shape)
        snr = figures.snr[:, self.problem.scenes[index].nominal]
        return Tried(power.reshape(shape), snr.reshape(shape), missed.reshape(shape), terms)

    def _gain(self, index: int, at_unit: Figures) -> Array:
        """The gain for the wanted mean level, or the highest that saturates nothing; both are linear in it."""
        scene, cam = self.problem.scenes[index], self.model.cameras
        needs, full = scene.view.requirements, 2.0 ** cam.bits[0] - 1.0
        wanted = needs.mean_level
        level = at_unit.mean_level[:, scene.nominal] if wanted is not None else at_unit.mean_level.max(axis=1)
        goal = wanted if wanted is not None else (1 - 1e-12) / needs.highlight_ratio
        black = cam.black_level_dn[0] / full
        return np.clip((goal - black) / np.maximum(level - black, 1e-300), 1.0, cam.max_gain[0])

    def value(self, power: Array, snr: Array, terms: dict[str, float]) -> Array:
        """The minimised objective."""
        one = np.ones_like(power)
        snr_db = 20 * np.log10(np.maximum(snr, 1e-30))
        return self.objective.cost_to_minimise(
            Terms(power, terms["cost"] * one, terms["mass_kg"] * one, snr_db, self.gsd_mm * one)
        )

    def join(self, tried: list[Tried]) -> tuple[float, float, float, list[tuple[int, int]]]:
        """Best value, power and SNR over the scenes, and where; the same f-number index where it is shared.

        Scenes meet in the worst power and the worst SNR: every SNR that one scene offers is tried as a
        floor, over which each scene draws its least power.
        """
        groups = range(tried[0].power_w.shape[0]) if self.shared else [None]
        best: tuple[float, float, float, list[tuple[int, int]]] = (np.inf, np.inf, 0.0, [])
        for group in groups:
            found = [self._feasible(one, group) for one in tried]
            if any(len(flat) == 0 for _, _, flat in found):
                continue
            floors = np.concatenate([snr for _, snr, _ in found])
            if not self.objective.weight("snr_db"):
                floors = np.array([0.0])
            least = [_least_power(power, snr, floors) for power, snr, _ in found]
            power = np.max([p for p, _ in least], axis=0)
            with np.errstate(invalid="ignore"):
                value = self.value(power, np.maximum(floors, 1e-30), tried[0].terms)
            value = np.where(np.isfinite(power), value, np.inf)
            k = int(np.lexsort((power, value))[0])
            if (value[k], power[k]) < best[:2]:
                width = tried[0].power_w.shape[1]
                places = [divmod(int(flat[at[k]]), width) for (_, _, flat), (_, at) in zip(found, least, strict=True)]
                best = (float(value[k]), float(power[k]), float(floors[k]), places)
        return best

    @staticmethod
    def _feasible(one: Tried, group: int | None) -> tuple[Array, Array, Array]:
        missed = one.missed.copy()
        if group is not None:
            missed[np.arange(len(missed)) != group] = 1.0
        flat = np.nonzero(missed.ravel() == 0.0)[0]
        return one.power_w.ravel()[flat], one.snr.ravel()[flat], flat

    def nearest(self, tried: list[Tried]) -> list[tuple[int, int]]:
        """Where the violation is least, with one f-number where it is shared."""
        width = tried[0].missed.shape[1]
        if not self.shared:
            return [divmod(int(one.missed.argmin()), width) for one in tried]
        row = int(np.sum([one.missed.min(axis=1) for one in tried], axis=0).argmin())
        return [(row, int(one.missed[row].argmin())) for one in tried]

    def solve(self) -> tuple[float, float, float]:
        """Best value with its power and SNR, from each combination of steps of light."""
        results = [self._zoom(list(levels)) for levels in self._level_choices()]
        return min(results, default=(np.inf, np.inf, 0.0))

    def _level_choices(self) -> Iterator[tuple[float | None, ...]]:
        """One step for each scene; None where the lamp dims freely."""
        one: list[float | None] = [None] if self.steps is None else [float(s) for s in self.steps]
        yield from itertools.product(one, repeat=len(self.rates))

    def _zoom(self, levels: list[float | None]) -> tuple[float, float, float]:
        boxes = [self.box(i, level) for i, level in enumerate(levels)]
        if any((high < low - 1e-12).any() for low, high in boxes):
            return np.inf, np.inf, 0.0
        around, best = boxes, (np.inf, np.inf, 0.0)
        for number in range(ROUNDS):
            sizes = FIRST_GRID if number == 0 else ZOOM_GRID
            axes = [[logspaced(low[k], high[k], sizes[k]) for k in range(3)] for low, high in around]
            if self.shared:
                common = np.unique(np.concatenate([a[0] for a in axes]))
                axes = [[common, *a[1:]] for a in axes]
            tried = [self.try_points(i, *(np.exp(axis) for axis in a)) for i, a in enumerate(axes)]
            value, power, snr, places = self.join(tried)
            if np.isfinite(value):
                better = value < best[0] - 1e-7 * abs(best[0]) if np.isfinite(best[0]) else True
                best = min(best, (value, power, snr))
                if not better and number > FEWEST_ROUNDS:
                    break
            else:
                places = [] if np.isfinite(best[0]) else self.nearest(tried)
            around = [shrunk(*one) for one in zip(around, boxes, axes, places or [None] * len(axes), strict=True)]
        return best


def logspaced(low: float, high: float, count: int) -> Array:
    """Points from low to high, or the only one."""
    return np.linspace(low, high, count) if high > low else np.array([low])


def shrunk(
    around: tuple[Array, Array], box: tuple[Array, Array], axes: list[Array], place: tuple[int, int] | None
) -> tuple[Array, Array]:
    """A box of a cell and a half to each side of the chosen point; as wide as before where that lies on its rim."""
    low, high = around
    if place is None:
        middle, reach = 0.5 * (low + high), 0.25 * (high - low)
        return np.maximum(middle - reach, box[0]), np.minimum(middle + reach, box[1])
    at = (place[0], *divmod(place[1], len(axes[2])))
    middle = np.array([axis[i] for axis, i in zip(axes, at, strict=True)])
    cell = (high - low) / np.array([max(len(axis) - 1, 1) for axis in axes])
    on_rim = ((middle <= low) & (low > box[0])) | ((middle >= high) & (high < box[1]))
    reach = np.where(on_rim, 0.5 * (high - low), 1.5 * cell)
    return np.maximum(middle - reach, box[0]), np.minimum(middle + reach, box[1])


def _least_power(power: Array, snr: Array, floors: Array) -> tuple[Array, Array]:
    """Least power among points with at least each floor of SNR, and which point draws it."""
    order = np.argsort(snr)
    ordered, where = power[order][::-1], order[::-1]
    running = np.minimum.accumulate(ordered)
    is_new = np.concatenate([[True], ordered[1:] < running[:-1]])
    holder = np.maximum.accumulate(np.where(is_new, np.arange(len(ordered)), 0))
    enough = len(order) - np.searchsorted(snr[order], floors * (1 - 1e-15))
    at = np.maximum(enough - 1, 0)
    return np.where(enough > 0, running[at], np.inf), where[holder[at]]


def best_of(bench: Bench, hardware: Hardware, objective: Objective) -> Best:
    """Best settings of one hardware."""
    model = bench.model(hardware)
    if not passes_without_light(model):
        return Best(hardware, np.inf, np.inf, 1.0)
    grid = Grid(model, objective)
    if any(rate > model.cameras.max_rate_hz[0] * (1 + 1e-9) for rate in grid.rates):
        return Best(hardware, np.inf, np.inf, 1.0)
    value, power, snr = grid.solve()
    return Best(hardware, value, power, scale_of(objective, value, power, snr))


def scale_of(objective: Objective, value: float, power_w: float, snr: float) -> float:
    """What a relative difference of a weighted sum refers to: terms may cancel, so the largest counts."""
    sizes = [abs(value) if np.isfinite(value) else 1.0]
    if objective.weight("snr_db") and snr > 0:
        sizes.append(objective.weight("snr_db") * abs(20 * np.log10(snr)))
    if objective.weight("power") and np.isfinite(power_w):
        sizes.append(objective.weight("power") * power_w)
    return max(sizes)


def enumerate_all(problem: Problem, objective: Objective) -> list[Best]:
    """Best settings of every hardware, best first."""
    bench = Bench(problem)
    found = [best_of(bench, hw, objective) for hw in buildable(problem)]
    return sorted(found, key=lambda b: (b.value, b.power_w))


__all__ = ["CONTINUOUS", "Bench", "Best", "best_of", "buildable", "enumerate_all", "passes_without_light"]
