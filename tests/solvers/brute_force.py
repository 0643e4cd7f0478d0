"""Exhaustive enumeration of small problems through the forward model alone, to hold the exact search against.

Every combination of hardware is taken; its settings come from dense grids over f-number, time, level and
light that hold the ends of every range, found by bisection of the formulas that give an image's SNR, level
and depth of field. What is best is read back through `DesignModel.margins`; nothing of `solvers` takes part.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.compatibility import image_circle_ok, mount_compatible, sensor_diagonal_mm
from uwopt.evaluation import DesignModel, Hardware, SceneSettings
from uwopt.figures import SettingRows, depth_of_field_m, skew_px
from uwopt.hardware import CONTINUOUS, FLASH, PULSED
from uwopt.model import sensor
from uwopt.objectives.objective import Objective, Terms
from uwopt.optics import blur_time_s, place_focus, required_rate_hz
from uwopt.problem import Problem

Array = NDArray[Any]


@dataclass(frozen=True)
class Best:
    """Best settings found for one hardware."""

    hardware: Hardware
    value: float  # minimised objective; inf: nothing feasible
    power_w: float
    scale: float  # of the terms of the objective, for relative comparisons
    settings: list[dict[str, float]]


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


class SceneSearch:
    """One scene of one hardware: candidates of settings by f-number, with their power and SNR.

    Four numbers describe a setting: time t, level u, light X and f-number N, tied by X = light u t / N_w^2.
    Candidates pin three of them to grids that hold every end of what is allowed; the fourth follows.
    """

    def __init__(self, model: DesignModel, index: int, dioptre_per_m: float, power_limit_w: float):
        self.model, self.index, self.dioptre = model, index, dioptre_per_m
        self.scene, self.rows = model.problem.scenes[index], model.rows[index]
        self.cam, self.light = model.cameras, model.lights
        needs, speed = self.scene.view.requirements, self.scene.view.vehicle.speed_m_s
        self.needs, self.kind = needs, int(self.light.kind[0])
        self.rate = float(required_rate_hz(needs, speed, self.rows.view.footprint_along_m).max())
        self.factor = 1.0
        if not self.scene.paper:
            self.factor = 1.0 / (1.0 - float(self.rows.view.focal_length_m[0]) * dioptre_per_m)
        count = model.hardware.count
        flash = self.kind == FLASH
        self.lumen = float(self.light.full_light[0]) * count / (float(self.light.flash_duration_s[0]) if flash else 1.0)
        self.full_w = float(self.light.pulse_energy_j[0] * self.rate if flash else self.light.full_power_w[0]) * count
        self.power_limit_w = power_limit_w
        self.time = self._time_range()
        self.levels = self._levels()
        self.f_range = self._f_range()

    # ------------------------------------------------------------ what hardware allows

    def _time_range(self) -> tuple[float, float]:
        """Shortest and longest time that collects light, from the data sheets' limits; low > high: none."""
        cam, light = self.cam, self.light
        offset, readout, least = (float(a[0]) for a in (cam.exposure_offset_s, cam.readout_s, cam.min_exposure_s))
        limits = self.model.problem.mission.limits
        most = min(float(cam.max_exposure_s[0]), limits.max_exposure_ms * 1e-3, 1 / self.rate if self.rate else np.inf)
        blur = float(blur_time_s(self.scene, self.model.shapes[self.index], self.rows.view)[0])
        if least > most or self.rate > cam.max_rate_hz[0] * (1 + 1e-9):
            return 1.0, 0.0
        if self.kind == CONTINUOUS:
            skew = float(skew_px(self.scene, self.rows).max())
            if self.needs.max_skew_px is not None and skew > self.needs.max_skew_px:
                return 1.0, 0.0
            return least + offset, min(most + offset, blur)
        if self.rate > light.max_rate_hz[0] * (1 + 1e-9):
            return 1.0, 0.0
        if self.kind == PULSED:
            duty = float(light.max_duty[0]) / self.rate if self.rate else np.inf
            return max(float(light.min_pulse_s[0]), 1e-9), min(float(light.max_pulse_s[0]), duty, most - readout, blur)
        flash = float(light.flash_duration_s[0])
        if readout > 0:
            return flash, flash if flash <= min(most - readout, blur) else 0.0
        return min(least + offset, flash), min(most + offset, flash, blur)

    def _levels(self) -> tuple[Array, bool]:
        """Levels that the lamp has within peak power (their ends if it dims freely), and whether it does."""
        light, peak = self.light, self.model.problem.mission.limits.peak_power_w
        top = min(1.0, peak / self.full_w) if peak is not None and self.full_w > 0 else 1.0
        if not light.dims_freely[0]:
            steps = light.levels[0][~np.isnan(light.levels[0])]
            return steps[steps <= top * (1 + 1e-12)], False
        least = float(light.min_level[0])
        return (np.array([least, top]) if least <= top else np.empty(0)), True

    def _f_range(self) -> tuple[float, float]:
        """Smallest f-number that keeps the wanted depth sharp, by bisection of the forward model, and the largest."""
        low, high = float(self.model.lenses.f_number_min[0]), float(self.model.lenses.f_number_max[0])
        depth = self.needs.min_dof_m
        if depth is None:
            return low, high
        first, last = float(self.scene.range_m[0]), float(self.scene.range_m[-1])

        def sharp(f_number: float) -> bool:
            one = np.array([f_number])
            settings = SettingRows(one, one, one, one, one, one, np.array([self.dioptre]))
            near, far = (float(a[0]) for a in depth_of_field_m(self.rows, settings))
            return near <= first * (1 + 1e-10) and far >= last * (1 - 1e-10) and far - near >= depth * (1 - 1e-10)

        if not sharp(high):
            return 1.0, 0.0
        if sharp(low):
            return low, high
        dull, clear = low, high
        for _ in range(50):
            middle = 0.5 * (dull + clear)
            dull, clear = (dull, middle) if sharp(middle) else (middle, clear)
        return clear, high

    @property
    def possible(self) -> bool:
        """Whether any setting may exist."""
        return self.time[0] <= self.time[1] * (1 + 1e-12) and len(self.levels[0]) > 0 and self.f_range[0] <= self.f_range[1]

    # ------------------------------------------------------------ what images need

    def exposure_s(self, time_s: Array) -> Array:
        """Exposure to set for a time that collects light."""
        cam, flash = self.cam, float(self.light.flash_duration_s[0])
        around = np.maximum(cam.min_exposure_s[0], time_s + cam.readout_s[0])
        if self.kind == PULSED:
            return around
        cut = time_s - cam.exposure_offset_s[0]
        return np.where(time_s >= flash * (1 - 1e-9), around, cut) if self.kind == FLASH else cut

    def image(self, light_x: Array, time_s: Array) -> tuple[Array, Array, Array]:
        """SNR at the nominal altitude, and whether the image is too dark or too bright, gain at its best."""
        cam, nominal, needs = self.cam, self.scene.nominal, self.needs
        dark = float(cam.dark_current_e_s[0]) * self.exposure_s(time_s)[..., None]
        signal = self.rows.signal_e[0] * light_x[..., None]
        full, black, gain = 2.0 ** float(cam.bits[0]) - 1.0, float(cam.black_level_dn[0]), float(cam.gain_dn_per_e[0])
        shown = signal.max(axis=-1) if needs.mean_level is None else signal[..., nominal]
        goal_dn = full / needs.highlight_ratio if needs.mean_level is None else needs.mean_level * full
        wanted = (goal_dn - black) / (gain * np.maximum(shown + dark[..., 0], 1e-300))
        system = gain * np.clip(wanted, 1.0, float(cam.max_gain[0]))[..., None]
        noise = dict(read_noise_e=cam.read_noise_e[0], gain_dn_per_e=system, dark_e=dark, prnu_frac=cam.prnu_frac[0])
        bright = wanted < 1.0
        level = (system * (signal + dark) + black) / full
        bright = bright | (needs.highlight_ratio * level.max(axis=-1) > 1.0 + 1e-11)
        bright |= needs.highlight_ratio * (signal.max(axis=-1) + dark[..., 0]) > cam.saturation_e[0]
        dim = np.zeros(light_x.shape, bool)
        if needs.mean_level is not None:
            dim = wanted > cam.max_gain[0]
        if needs.min_snr is not None:
            pixel = signal
            if needs.snr_at == "worst" and self.rows.worst_e is not None:
                pixel = self.rows.worst_e[0] * light_x[..., None]
            dim = dim | (np.asarray(sensor.snr(pixel, **noise)).min(axis=-1) < needs.min_snr)
        return np.asarray(sensor.snr(signal, **noise))[..., nominal], dim, bright

    def light_of(self, numbers: dict[str, float]) -> float:
        """Light X of a setting."""
        return self.lumen * numbers["level"] * numbers["time_s"] / (numbers["f_number"] * self.factor) ** 2

    def setting_rows(self, numbers: dict[str, float]) -> SettingRows:
        """A candidate as settings of the forward model, the gain by its own figures at unit gain."""
        time_s = np.array([numbers["time_s"]])
        pulse = {CONTINUOUS: np.inf, PULSED: time_s, FLASH: self.light.flash_duration_s}[self.kind]
        unit = SettingRows(
            np.array([numbers["f_number"]]), self.exposure_s(time_s), pulse * np.ones(1), np.ones(1),
            np.array([numbers["level"]]), np.array([self.rate]), np.array([self.dioptre]),
        )  # fmt: skip
        level = self.model.figures(self.index, unit).mean_level
        needs, black = self.needs, self.cam.black_level_dn[0] / (2.0 ** self.cam.bits[0] - 1.0)
        if needs.mean_level is None:
            gain = (1.0 / needs.highlight_ratio - black) / np.maximum(level.max(axis=1) - black, 1e-300)
        else:
            gain = (needs.mean_level - black) / np.maximum(level[:, self.scene.nominal] - black, 1e-300)
        return replace(unit, gain=np.clip(gain, 1.0, self.cam.max_gain[0]))

    def light_range(self, time_s: Array) -> tuple[Array, Array]:
        """Least light that is not too dark and most that is not too bright, by bisection."""
        ends = []
        for bright in (False, True):
            low, high = np.full(time_s.shape, -40.0), np.full(time_s.shape, 40.0)
            for _ in range(42):
                middle = 0.5 * (low + high)
                over = self.image(np.exp(middle), time_s)
                past = over[2] if bright else ~over[1]
                low, high = np.where(past, low, middle), np.where(past, middle, high)
            ends.append(np.exp(low if bright else high))
        return ends[0], ends[1]

    # ------------------------------------------------------------ candidates

    def prepare(self, n_light: int, around: float | None = None, reach: float = 0.0) -> Array:
        """Grids of time, level and light; returns f-numbers at which several ends meet.

        `around`: a light that proved good, to look closer at e^reach to each side of it.
        """
        low, high = self.time
        if around is None:
            self.times = np.unique(np.geomspace(low, high, 9)) if high > low else np.array([low])
            least, most = self.light_range(self.times)
            self.ends = np.minimum(least, np.where(least <= most * (1 + 1e-9), most, np.inf)), most
        least, most = self.ends
        near = np.maximum(least, 1e-5 * most) if around is None else np.full(len(least), around * np.exp(-reach))
        far = most if around is None else np.full(len(most), around * np.exp(reach))
        grid = near[:, None] * (far / near)[:, None] ** np.linspace(0.0, 1.0, n_light)
        grid = np.concatenate([grid, least[:, None], most[:, None]], axis=1)
        inside = (grid >= least[:, None] * (1 - 1e-13)) & (grid <= most[:, None] * (1 + 1e-13))
        self.lights = np.where(inside & (grid < 1e15), grid, np.nan)  # more than 1e15: no light reaches the image
        levels, free = self.levels
        if self.kind != PULSED and free and np.isfinite(self.power_limit_w) and self.full_w > 0:
            levels = np.unique(np.append(levels, np.clip(self.power_limit_w / self.full_w, levels[0], levels[-1])))
        self.pinned = levels
        x = np.stack([least[[0, -1]], most[[0, -1]]], axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            f_number = np.sqrt(self.lumen * levels[:, None, None] * self.times[[0, -1]][:, None] / x) / self.factor
        return f_number[np.isfinite(f_number)]

    def candidates(self, f_number: Array) -> list[Array]:
        """The feasible candidates at these f-numbers: power, SNR, time, level and f-number, (n,) each."""
        square = ((f_number * self.factor) ** 2 / self.lumen)[:, None]  # level * time per light
        t, u, x = [], [], []

        def add(time_s: Array, level: Array, light_x: Array) -> None:
            for column, values in ((t, time_s), (u, level), (x, light_x)):
                column.append(np.broadcast_to(values, np.broadcast_shapes(time_s.shape, level.shape, light_x.shape)))

        every = self.lights.ravel()
        if self.levels[1]:
            times = np.broadcast_to(self.times[:, None], self.lights.shape).ravel()
            add(times, every * square / times, every)
        many = np.concatenate([np.broadcast_to(every, (len(f_number), len(every))), self._at_power_limit(square)], axis=1)
        for level in self.pinned[self.pinned > 0]:
            add(many * square / level, np.array(level), many)
            for end in self.ends:
                light_x = self._at_its_own_time(end, square / level)
                add(light_x * square / level, np.array(level), light_x)
            add(self.times, np.array(level), level * self.times / square)
        time_s, level, light_x = (np.concatenate(parts, axis=1).ravel() for parts in (t, u, x))
        f_number = np.repeat(f_number, len(time_s) // len(f_number))
        levels = self.levels[0]
        with np.errstate(invalid="ignore"):
            ok = (time_s >= self.time[0] * (1 - 1e-11)) & (time_s <= self.time[1] * (1 + 1e-11)) & (light_x > 0)
            ok &= (level >= levels.min() * (1 - 1e-11)) & (level <= levels.max() * (1 + 1e-11))
        time_s, level, light_x, f_number = time_s[ok], level[ok], light_x[ok], f_number[ok]
        snr = self.image(light_x, time_s)[0]
        dim, bright = self.image(light_x * (1 + 1e-9), time_s)[1], self.image(light_x * (1 - 1e-9), time_s)[2]
        power = self.full_w * level * (np.minimum(1.0, time_s * self.rate) if self.kind == PULSED else 1.0)
        good = ~dim & ~bright & (power <= self.power_limit_w * (1 + 1e-9))
        return [column[good] for column in (power, snr, time_s, level, f_number)]

    def _at_its_own_time(self, end: Array, time_per_light: Array) -> Array:
        """An end of the light's range, which dark current shifts with the time that this light takes."""
        light_x = np.full(time_per_light.shape, end[0])
        for _ in range(6):
            light_x = np.interp(light_x * time_per_light, self.times, end)
        return light_x

    def _at_power_limit(self, square: Array) -> Array:
        """Light of pulsed lamps that use all the power there is."""
        if self.kind != PULSED or not np.isfinite(self.power_limit_w) or self.rate == 0:
            return np.empty((len(square), 0))
        return self.power_limit_w / (self.full_w * self.rate) / square


def settle_all(model: DesignModel, objective: Objective) -> tuple[float, float, float, list[dict[str, float]]]:
    """Best value of one hardware with its power, SNR and settings by scene; inf: nothing is feasible."""
    problem = model.problem
    nothing: tuple[float, float, float, list[dict[str, float]]] = (np.inf, np.inf, 0.0, [])
    focus = place_focus(problem.scenes, model.maps, model.views)
    terms = fixed_terms(model)
    limit = problem.mission.limits.power_w
    left = np.inf if limit is None else limit - terms["camera_power_w"]
    scenes = [SceneSearch(model, i, float(focus.dioptre_per_m[i][0]), left) for i in range(len(problem.scenes))]
    if not all(scene.possible for scene in scenes):
        return nothing
    weighs = bool(objective.weight("snr_db"))
    best = one_pass(scenes, [s.prepare(33 if weighs else 2) for s in scenes], objective, terms)
    for reach in (0.5, 0.1, 0.02) if weighs and best[3] else ():
        lights = [s.light_of(numbers) for s, numbers in zip(scenes, best[3], strict=True)]
        meeting = [s.prepare(21, x, reach) for s, x in zip(scenes, lights, strict=True)]
        meeting = [np.append(m, n["f_number"] * np.exp(np.linspace(-reach, reach, 5))) for m, n in zip(meeting, best[3], strict=True)]
        best = min(best, one_pass(scenes, meeting, objective, terms), key=lambda b: b[:2])
    return best


def one_pass(
    scenes: list[SceneSearch], meeting: list[Array], objective: Objective, terms: dict[str, float]
) -> tuple[float, float, float, list[dict[str, float]]]:
    """The best of all candidates of all scenes on the grids that they have now."""
    best: tuple[float, float, float, list[dict[str, float]]] = (np.inf, np.inf, 0.0, [])
    if len(scenes) > 1 and not scenes[0].model.lenses.motorised[0]:
        low, high = max(s.f_range[0] for s in scenes), min(s.f_range[1] for s in scenes)
        common = f_numbers(low, high, np.concatenate(meeting))
        if len(common) == 0:
            return best
        found = [scene.candidates(common) for scene in scenes]
        groups = [[[c[columns[4] == n] for c in columns] for columns in found] for n in common]
    else:
        groups = [[s.candidates(f_numbers(*s.f_range, m)) for s, m in zip(scenes, meeting, strict=True)]]
    for group in groups:
        if all(len(columns[0]) for columns in group):
            best = min(best, joined(group, objective, terms), key=lambda b: b[:2])
    return best


def f_numbers(low: float, high: float, meeting: Array) -> Array:
    """F-numbers to try: both ends, a grid, and where the ends of other ranges meet."""
    if low > high:
        return np.empty(0)
    inside = meeting[(meeting > low) & (meeting < high)]
    return np.unique(np.concatenate([np.geomspace(low, high, 13), inside * (1 + 1e-12), inside]))


def joined(
    found: list[list[Array]], objective: Objective, terms: dict[str, float]
) -> tuple[float, float, float, list[dict[str, float]]]:
    """The best of all scenes together: every SNR found is tried as a floor, over which each draws its least."""
    floors = np.unique(np.concatenate([c[1] for c in found])) if objective.weight("snr_db") else np.zeros(1)
    least = [_least_power(c[0], c[1], floors) for c in found]
    light_w = np.max([p for p, _ in least], axis=0)
    snr = np.min([c[1][at] for c, (_, at) in zip(found, least, strict=True)], axis=0)
    power, one = terms["camera_power_w"] + light_w, np.ones_like(light_w)
    with np.errstate(invalid="ignore", divide="ignore"):
        value = objective.cost_to_minimise(
            Terms(power, terms["cost"] * one, terms["mass_kg"] * one, 20 * np.log10(snr), terms["gsd_mm"] * one)
        )
    value = np.where(np.isfinite(light_w), value, np.inf)
    k = int(np.lexsort((power, value))[0])
    settings = [
        {"time_s": float(c[2][at[k]]), "level": float(c[3][at[k]]), "f_number": float(c[4][at[k]])}
        for c, (_, at) in zip(found, least, strict=True)
    ]
    return float(value[k]), float(power[k]), float(snr[k]), settings


def fixed_terms(model: DesignModel) -> dict[str, float]:
    """Cost, mass, power without light and ground sample of one hardware, from the forward model."""
    unit = model.settings(0, SceneSettings(gain=1.0))
    totals = {name: float(np.ravel(v)[0]) for name, v in model.totals(0, model.figures(0, unit)).items()}
    return totals | {"gsd_mm": max(float(view.gsd_m[0, 1]) * 1e3 for view in model.views)}


def margins_missed(model: DesignModel, settings: list[dict[str, float]], relative: float = 1e-6) -> list[str]:
    """Requirements that settings miss in the forward model, in words."""
    focus = place_focus(model.problem.scenes, model.maps, model.views)
    missed = []
    for index, numbers in enumerate(settings):
        scene = SceneSearch(model, index, float(focus.dioptre_per_m[index][0]), np.inf)
        rows = scene.setting_rows(numbers)
        for margin in model.margins(index, rows, model.figures(index, rows)):
            size = abs(float(margin.limit[0])) if np.isfinite(margin.limit[0]) else 1.0
            if not float(margin.margin[0]) >= -relative * size:
                missed.append(f"{margin.requirement}: {float(margin.value[0])} against {float(margin.limit[0])}")
    return missed


def _least_power(power: Array, snr: Array, floors: Array) -> tuple[Array, Array]:
    """Least power among points with at least each floor of SNR, and which point draws it."""
    order = np.argsort(-snr, kind="stable")
    running = np.minimum.accumulate(power[order])
    holder = np.maximum.accumulate(
        np.where(np.concatenate([[True], power[order][1:] < running[:-1]]), np.arange(len(order)), 0)
    )
    enough = np.searchsorted(-snr[order], -floors * (1 - 1e-14), side="right")
    at = np.maximum(enough - 1, 0)
    return np.where(enough > 0, running[at], np.inf), order[holder[at]]


def best_of(bench: Bench, hardware: Hardware, objective: Objective) -> Best:
    """Best settings of one hardware, read back through the margins of the forward model."""
    model = bench.model(hardware)
    if not passes_without_light(model) or misses_limits(model):
        return Best(hardware, np.inf, np.inf, 1.0, [])
    value, power, snr, settings = settle_all(model, objective)
    if settings:
        missed = margins_missed(model, settings)
        assert not missed, f"the enumeration itself is wrong: {hardware} misses {missed}"
    return Best(hardware, value, power, scale_of(objective, value, power, snr), settings)


def misses_limits(model: DesignModel) -> bool:
    """Whether something that no setting changes is missed: coverage, money, mass, data."""
    names = ("max_gsd_mm", "min_swath_m", "cost", "mass_kg", "data_rate_mb_s", "frame_rate")
    for index in range(len(model.problem.scenes)):
        unit = model.settings(index, SceneSettings(gain=1.0))
        for margin in model.margins(index, unit, model.figures(index, unit)):
            if margin.requirement in names and float(margin.margin[0]) < -1e-9 * abs(float(margin.limit[0])):
                return True
    return False


def scale_of(objective: Objective, value: float, power_w: float, snr: float) -> float:
    """What a relative difference of a weighted sum refers to: terms may cancel, so the largest counts."""
    sizes = [abs(value) if np.isfinite(value) else 1.0]
    if objective.weight("snr_db") and snr > 0:
        sizes.append(objective.weight("snr_db") * abs(20 * np.log10(snr)))
    if objective.weight("power") and np.isfinite(power_w):
        sizes.append(objective.weight("power") * power_w)
    return max(sizes)


def enumerate_all(bench: Bench, objective: Objective) -> list[Best]:
    """Best settings of every hardware, best first."""
    found = [best_of(bench, hw, objective) for hw in buildable(bench.problem)]
    return sorted(found, key=lambda b: (b.value, b.power_w))
