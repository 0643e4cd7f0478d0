"""Exhaustive enumeration of small problems through the forward model alone, to hold the exact search against.

Every combination of hardware is taken; its settings come from dense grids over f-number, time, level and
light that hold the ends of every range, found by bisection of the formulas that give an image's SNR, level
and depth of field. What is best is read back through `DesignModel.margins`; nothing of `solvers` takes part.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scene_search import SceneSearch

from uwopt.catalog.compatibility import image_circle_ok, mount_compatible, sensor_diagonal_mm
from uwopt.evaluation.design_light import DesignLight
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.focus import place_focus
from uwopt.forward.problem import Problem
from uwopt.forward.views import table_reach_m
from uwopt.objectives.objective import Objective, Terms

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
    sizes = (
        range(len(parts.cameras)),
        range(len(parts.lenses)),
        range(len(parts.ports)),
        range(len(parts.lights)),
    )
    low, high = problem.count_range
    for (c, le, p, li), name, mount, count in itertools.product(
        itertools.product(*sizes), problem.mission.vehicle.orientations, problem.mounts, range(low, high + 1)
    ):
        camera, lens = parts.cameras[c], parts.lenses[le]
        if camera.complete != lens.complete or lens.complete != parts.ports[p].complete:
            continue
        if not camera.fires_lamps and parts.lights[li].kind in ("pulsed_led", "flash"):
            continue
        if mount.explicit and len(mount.explicit) != count:  # places of another number of lamps
            continue
        diagonal = sensor_diagonal_mm(camera.resolution_x_px, camera.resolution_y_px, camera.pixel_pitch_um)
        if mount_compatible([camera.mounts], [lens.mounts])[0, 0] and image_circle_ok(
            diagonal, lens.image_circle_mm
        ) and goes_inside(camera, lens, parts.ports[p]):
            yield Hardware(c, le, p, name == "landscape", li, count, mount)


def cap_mm(port: Any) -> float:
    """How deep the middle of a dome lies behind its rim, where its opening is stated and no hemisphere's."""
    if port.geometry != "dome" or port.complete or not port.clear_diameter_mm:
        return 0.0
    inner, half = port.outer_radius_mm.value - port.thickness_mm.value, port.clear_diameter_mm.value / 2
    return math.sqrt(inner**2 - half**2) if inner > half else 0.0


def goes_inside(camera: Any, lens: Any, port: Any, ring_mm: float = 0.0) -> bool:
    """Whether camera with lens and a ring between them goes into the port's housing, 2 mm from any wall."""
    if port.housing is None or port.complete:
        return True
    body = math.hypot(camera.body_width_mm.value, camera.body_height_mm.value)
    glass, pupil = lens.diameter_mm.value, lens.pupil_mm.value
    behind = lens.length_mm.value - pupil + camera.body_length_mm.value + camera.plug_mm.value + ring_mm
    if port.housing.shape == "sphere":
        farthest = max(math.hypot(behind, body / 2), math.hypot(pupil, glass / 2))
        return bool(2 * (farthest + 2) <= port.housing.inner_diameter_mm)
    dome = port.geometry == "dome"
    if dome and math.hypot(pupil, glass / 2) + 2 > port.outer_radius_mm.value - port.thickness_mm.value:
        return False
    inset = cap_mm(port)
    long = behind + 2 + (inset if dome else max(pupil, port.gap_mm))
    return bool(max(body, glass) + 4 <= port.housing.inner_diameter_mm and long <= port.housing.inner_length_mm)


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
            for hw in {
                replace(h, light=0, count=problem.count_range[0], mount=problem.mounts[0])
                for h in buildable(problem)
            }:
                for view in DesignLight(problem, hw).views:
                    widest = max(widest, table_reach_m(view))
            shared = problem.reaching([widest] * len(problem.scenes))
            problem.reaching = lambda widest_m: shared  # type: ignore[method-assign]
            self._tables_ready = True

    def model(self, hardware: Hardware) -> DesignModel:
        """The forward model of one hardware."""
        self._reach_once()
        lights = self.problem.lights
        optics = int(lights.optics_index[hardware.light])
        # Image means do not depend on how many lamps share the light: those at + and - mirror each other. Pixels do.
        alike = not hardware.mount.explicit and not any(
            scene.at_worst or scene.view.requirements.min_uniformity for scene in self.problem.scenes
        )
        place = replace(hardware, light=optics, count=0 if alike else hardware.count)
        key = (place, float(lights.output_factor[hardware.light]))
        if key not in self._models:
            self._models[key] = DesignModel(self.problem, hardware)
        made = self._models[key]
        if made.hardware == hardware:
            return made
        twin = object.__new__(DesignModel)
        twin.__dict__.update(made.__dict__, hardware=hardware, lights=lights.take(np.array([hardware.light])))
        count = np.array([hardware.count])
        twin.rows = [replace(rows, lights=twin.lights, count=count) for rows in made.rows]
        return twin


def ring_for(lens: Any, distance_mm: float) -> float | None:
    """The least ring in millimetres on which a lens focuses at a distance in air; None where none does.

    The lens stands f^2 / (s - f) out from where it is at infinity; a ring adds its length to all that it can. Screwed
    out of its thread, or on a ring, its image is no larger than it bears, or than it is at its own nearest distance.
    """
    focal, near = lens.focal_length_mm, 1e3 * (lens.min_object_distance_m.value if lens.min_object_distance_m else 0)
    if distance_mm <= focal:
        return None
    needed = focal**2 / (distance_mm - focal)
    own = math.inf if near <= focal else focal**2 / (near - focal)
    thread = lens.thread_travel_mm.value if lens.thread_travel_mm else 0.0
    bears = lens.max_magnification.value if lens.max_magnification else math.inf
    if distance_mm >= near * (1 - 1e-9):
        return 0.0
    if needed / focal > bears * (1 + 1e-9):
        return None
    for ring in (0.0, *sorted(lens.spacers_mm or ())):
        if ring * (1 - 1e-9) <= needed <= (ring + own + thread) * (1 + 1e-9):
            return float(ring)
    return None


def passes_without_light(model: DesignModel) -> bool:
    """Port clears the corner ray, lens focuses at the virtual image, on a ring that the housing has room for."""
    problem, hw = model.problem, model.hardware
    focus = place_focus(problem.scenes, model.maps, model.views)
    parts = problem.parts
    for index, view in enumerate(model.views):
        ring = ring_for(parts.lenses[hw.lens], 1e3 / float(focus.dioptre_per_m[index][0]))
        if ring is None or not goes_inside(parts.cameras[hw.camera], parts.lenses[hw.lens], parts.ports[hw.port], ring):
            return False
        corner = float(np.hypot(view.tan_along[0], view.tan_across[0]))
        port = parts.ports[hw.port]
        before_mm = cap_mm(port) if problem.ports.is_dome[hw.port] else port.gap_mm
        rim_mm = port.clear_diameter_mm.value / 2 if port.clear_diameter_mm else math.inf
        if not problem.paper and corner * before_mm > rim_mm:
            return False
    return True


def settle_all(
    model: DesignModel, objective: Objective
) -> tuple[float, float, float, list[dict[str, float]]]:
    """Best value of one hardware with its power, SNR and settings by scene; inf: nothing is feasible."""
    problem = model.problem
    nothing: tuple[float, float, float, list[dict[str, float]]] = (np.inf, np.inf, 0.0, [])
    focus = place_focus(problem.scenes, model.maps, model.views)
    terms = fixed_terms(model)
    limit = problem.mission.limits.power_w
    left = np.inf if limit is None else limit - terms["camera_power_w"]
    if len(problem.scenes) == 1:
        left = min(left, mean_light_limit_w(problem, terms))
    scenes = [
        SceneSearch(model, i, float(focus.dioptre_per_m[i][0]), left) for i in range(len(problem.scenes))
    ]
    if not all(scene.possible for scene in scenes):
        return nothing
    weighs = bool(objective.weight("snr_db"))
    best = one_pass(scenes, [s.prepare(33 if weighs else 2) for s in scenes], objective, terms)
    for reach in (0.5, 0.1, 0.02) if weighs and best[3] else ():
        lights = [s.light_of(numbers) for s, numbers in zip(scenes, best[3], strict=True)]
        meeting = [s.prepare(21, x, reach) for s, x in zip(scenes, lights, strict=True)]
        meeting = [
            np.append(m, n["f_number"] * np.exp(np.linspace(-reach, reach, 5)))
            for m, n in zip(meeting, best[3], strict=True)
        ]
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
            best = min(best, joined(scenes, group, objective, terms), key=lambda b: b[:2])
    return best


def mean_light_limit_w(problem: Problem, terms: dict[str, float]) -> float:
    """What an energy over the mission's hours leaves for the lamps on average."""
    energy_wh, hours = problem.mission.limits.energy_wh, problem.mission.vehicle.duration_h
    return np.inf if energy_wh is None else energy_wh / (hours or np.nan) - terms["camera_power_w"]


def f_numbers(low: float, high: float, meeting: Array) -> Array:
    """F-numbers to try: both ends, a grid, and where the ends of other ranges meet."""
    if low > high:
        return np.empty(0)
    inside = meeting[(meeting > low) & (meeting < high)]
    return np.unique(np.concatenate([np.geomspace(low, high, 13), inside * (1 + 1e-12), inside]))


def joined(
    scenes: list[SceneSearch], found: list[list[Array]], objective: Objective, terms: dict[str, float]
) -> tuple[float, float, float, list[dict[str, float]]]:
    """The best of all scenes together: every SNR found is tried as a floor, over which each draws its least."""
    floors = np.unique(np.concatenate([c[1] for c in found])) if objective.weight("snr_db") else np.zeros(1)
    least = [_least_power(c[0], c[1], floors) for c in found]
    light_w = np.max([p for p, _ in least], axis=0)
    snr = np.min([c[1][at] for c, (_, at) in zip(found, least, strict=True)], axis=0)
    power, one = terms["camera_power_w"] + light_w, np.ones_like(light_w)
    with np.errstate(invalid="ignore", divide="ignore"):
        value = objective.cost_to_minimise(
            Terms(
                power, terms["cost"] * one, terms["mass_kg"] * one, 20 * np.log10(snr), terms["gsd_mm"] * one
            )
        )
    value = np.where(np.isfinite(light_w), value, np.inf)
    if len(found) > 1:  # shares of the time, as the mission was drawn with them
        shares = [float(s.model.problem.mission.scenes[s.index].time_share or 1 / len(found)) for s in scenes]
        mean_w = sum(share * p for share, (p, _) in zip(shares, least, strict=True))
        value = np.where(mean_w <= mean_light_limit_w(scenes[0].model.problem, terms), value, np.inf)
    k = int(np.lexsort((power, value))[0])
    settings = [
        {"time_s": float(c[2][at[k]]), "level": float(c[3][at[k]]), "f_number": float(c[4][at[k]])}
        for c, (_, at) in zip(found, least, strict=True)
    ]
    return float(value[k]), float(power[k]), float(snr[k]), settings


def fixed_terms(model: DesignModel) -> dict[str, float]:
    """Cost, mass, power without light and ground sample of one hardware, from the forward model."""
    unit = model.settings(0, SceneSettings(gain=1.0))
    unit = replace(unit, exposure_s=model.cameras.min_exposure_s)
    totals = {name: float(np.ravel(v)[0]) for name, v in model.totals(model.figures(0, unit)).items()}
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
                missed.append(
                    f"{margin.requirement}: {float(margin.value[0])} against {float(margin.limit[0])}"
                )
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
    room = all(m.satisfied.all() for index in range(len(model.views)) for m in model.lamp_margins(index))
    if not room or not passes_without_light(model) or misses_limits(model):
        return Best(hardware, np.inf, np.inf, 1.0, [])
    value, power, snr, settings = settle_all(model, objective)
    if settings:
        missed = margins_missed(model, settings)
        assert not missed, f"the enumeration itself is wrong: {hardware} misses {missed}"
    return Best(hardware, value, power, scale_of(objective, value, power, snr), settings)


def misses_limits(model: DesignModel) -> bool:
    """Whether something that no setting changes is missed: coverage, money, mass, data."""
    names = (
        "horizon", "max_gsd_mm", "min_swath_m", "cost", "mass_kg", "data_rate_mb_s", "frame_rate", "min_uniformity",
        "min_contrast", "storage_gb", "card_gb", "max_white_balance", "size_mm", "diameter_mm",
        "mass_water_kg", "min_common_swath_m", "max_depth_error_mm",
    )  # fmt: skip
    for index in range(len(model.problem.scenes)):
        focus = model.searched_dioptre_per_m(index)
        unit = model.settings(index, SceneSettings(gain=1.0, dioptre_per_m=focus))
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
