"""Designs that an exact front must not miss: settings of every hardware, tried through the forward model alone.

Nothing of `solvers` takes part: settings are drawn over all that a data sheet allows, their ends included, the
gain follows from the figures at unit gain, and `DesignModel.margins` judges. Scenes are put together at common
f-numbers. What is feasible becomes a point; the exact front must not be beaten by any.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import population_cases as cases
import random_cases as rc
from scene_search import SceneSearch

from uwopt.catalog.records import exact
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.figures import SettingRows
from uwopt.forward.focus import place_focus
from uwopt.forward.motion import required_rate_hz
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.objectives.axes import Axes
from uwopt.objectives.objective import MAXIMISED
from uwopt.solvers.front.designs import found_of
from uwopt.solvers.front.search import Front, FrontSearch

QUALITIES = ("snr_db", "information", "contrast")
MISSED_REL = 1e-6
#: A random case whose fronts have several points; of three parts a kind seed 7 has no design.
SEVERAL = 45 if rc.THOROUGH else 7


WANTED = {"min_snr_db": 10.0, "max_blur_px": 2.0}
DARK = {"dark_current_e_s": exact(3000.0)}  # a warm sensor: a hundred times the dark current of a good one
ROLLING = {"shutter": "rolling", "max_frame_rate_hz": exact(30.0), "max_exposure_us": exact(1e6)}
FREE, PULSED_FREE, STEPS, FLASHING = (cases.LAMPS[name] for name in ("free", "pulsed", "steps", "flash"))
ON = rc.lamp("on", kind="continuous", flux_lm=20_000.0, power_w=200.0, dim_levels=(1.0,))
PULSED_ON = rc.lamp(
    "pulsed-on", kind="pulsed_led", flux_lm=40_000.0, power_w=400.0, min_pulse_us=10.0, max_pulse_us=5_000.0,
    max_duty_frac=0.5, max_rate_hz=30.0, dim_levels=(1.0,),
)  # fmt: skip
FLASH_STEPS = rc.lamp(
    "flash-steps", kind="flash", flash_energy_j=20.0, flash_efficacy_lm_s_per_j=35.0, flash_duration_us=500.0,
    recycle_s=0.1, charging_efficiency_frac=exact(0.7), dim_levels=(0.3, 1.0),
)  # fmt: skip


def in_sun(case: Any) -> Any:
    """The same case at 20 m under a bright sky."""
    scenes = [one.model_copy(update={"sun_lux": 20_000.0, "depth_m": 20.0}) for one in case.mission.scenes]
    return rc.Case(case.parts, case.mission.model_copy(update={"scenes": scenes}), case.objective)


#: Cases with one camera that show one kind of curve each.
PLANTED = {
    "dims": rc.planted("power", (FREE,), WANTED),
    "steps": rc.planted("power", (STEPS,), WANTED),
    "on": rc.planted("power", (ON,), WANTED),
    "pulses": rc.planted("power", (PULSED_FREE,), WANTED),
    "pulses on": rc.planted("power", (PULSED_ON,), WANTED),
    "flash": rc.planted("power", (FLASHING,), WANTED),
    "flash rolling": rc.planted("power", (FLASHING, FLASH_STEPS), WANTED, camera=ROLLING),
    "all": rc.planted("power", (*cases.LAMPS.values(), ON, PULSED_ON), WANTED),
    "dark": rc.planted("power", (FREE, PULSED_FREE, STEPS), WANTED, camera=DARK),
    "dark at a level": rc.planted(
        "power", (FREE, PULSED_FREE, FLASHING), {**WANTED, "mean_level": 0.3}, camera=DARK
    ),
    "dark flashes at a level": rc.planted("power", (FREE, FLASHING), {**WANTED, "mean_level": 0.3}, camera=DARK),
    "level": rc.planted("power", (FREE, PULSED_FREE, ON), {"mean_level": 0.3, "max_blur_px": 2.0}),
    "altitudes": rc.planted("power", (FREE, STEPS), {**WANTED, "mean_level": 0.3}, altitude_tolerance_m=0.4),
    "sharp": rc.planted("power", (FREE, PULSED_FREE, ON), {**WANTED, "min_mtf_half_nyquist": 0.25}),
    "bars": rc.planted("power", (STEPS,), {**WANTED, "resolve_mm": 3.5}, altitude_tolerance_m=0.3),
    "bars over the frame": rc.planted("power", (STEPS,), {**WANTED, "resolve_mm": 3.2, "snr_at": "worst"}),
    "still": rc.planted("power", (PULSED_FREE, FREE, FLASH_STEPS), {"min_snr_db": 20.0}, speed_m_s=0.0),
    "nothing asked": rc.planted("power", (FREE, PULSED_FREE, ON), {"max_blur_px": 1.0}),
    "clear": rc.planted("power", (FREE, PULSED_FREE), {**WANTED, "min_contrast": 0.5}),
    "counts and mounts": rc.planted(
        "power",
        (FREE, FLASH_STEPS),
        WANTED,
        light_count=[1, 3],
        light_baseline_m=[0.4, 0.45],
        orientation="any",
    ),
    "impossible": rc.planted("power", (FREE, FLASHING), {**WANTED, "min_snr_db": 95.0}),
    "sun": in_sun(rc.planted("power", (STEPS, PULSED_ON), WANTED)),
    "steps in the sun": in_sun(rc.planted("power", (STEPS,), WANTED)),
    "bars in the sun": in_sun(rc.planted("power", (STEPS,), {**WANTED, "resolve_mm": 3.5})),
    "sun at a level": in_sun(
        rc.planted("power", (FREE, PULSED_FREE), {"mean_level": 0.3, "max_blur_px": 2.0})
    ),
}


def case_of(key: int | str) -> Any:
    """A random case by seed or a planted one by name."""
    return PLANTED[key] if isinstance(key, str) else rc.case(key)


@cache
def front_of(key: int | str, names: tuple[str, ...]) -> tuple[FrontSearch, Front]:
    """The exact front of a case as shipped, made once."""
    return searched(case_of(key), names)


@cache
def samples(key: int | str, *, information: bool) -> list[Any]:
    """Tried settings of a case, drawn once, with information where an axis asks for it."""
    return samples_of(case_of(key), information=information)


def tried_of(key: int | str, names: Sequence[str]) -> Any:
    """Points of a case that an exact front must not be beaten by."""
    points = tried_points(samples(key, information="information" in names), names)
    return points[np.isfinite(points).all(axis=1)]


def searched(case: Any, names: Sequence[str], parts: Any = None, **options: Any) -> tuple[FrontSearch, Front]:
    """The exact front of a case."""
    search = FrontSearch(case.problem(parts), Axes.of(names), **options)
    return search, search.run()


def combinations(problem: Any) -> int:
    """All combinations of a problem."""
    low, high = problem.count_range
    sizes = [len(getattr(problem.parts, kind)) for kind in ("cameras", "lenses", "ports", "lights")]
    return (
        math.prod(sizes) * (high - low + 1) * len(problem.mounts) * len(problem.mission.vehicle.orientations)
    )


def tried_points(samples: Any, names: Sequence[str]) -> Any:
    """Values (n, n_axes), minimised, of feasible designs among the samples of a case."""
    return np.concatenate([np.empty((0, len(names))), *(points_of(one, names) for one in samples)])


def samples_of(case: Any, n: int = 3000, seed: int = 0, *, information: bool = True) -> list[Any]:
    """By hardware: what no setting changes, and by group of common f-numbers the tried settings of each scene."""
    bench = brute.Bench(case.problem())
    rng = np.random.default_rng(seed)
    information = information and case.mission.physics != "paper"
    found = []
    for hardware in brute.buildable(bench.problem):
        model = bench.model(hardware)
        if not brute.passes_without_light(model) or brute.misses_limits(model):
            continue
        groups = groups_of(model, n, rng, information=information)
        if groups:
            found.append((brute.fixed_terms(model), groups))
    return found


def groups_of(model: DesignModel, n: int, rng: np.random.Generator, *, information: bool) -> list[Any]:
    """Tried settings of every scene, at common f-numbers where there are several and the iris is fixed."""
    lens, scenes = model.lenses, range(len(model.views))
    ends = [sharpest(model, index) for index in scenes]
    if any(end is None for end in ends):
        return []
    low, high = max(e for e in ends if e is not None), float(lens.f_number_max[0])
    common = np.unique(np.concatenate([np.geomspace(low, max(high, low), 9), drawn(rng, low, high, 3), ends]))
    alone = len(scenes) == 1 or bool(lens.motorised[0])
    groups = []
    for one in [None] if alone else list(common):
        parts = [tried(model, i, n, rng, one, common, information=information) for i in scenes]
        if all(len(part["power"]) for part in parts):
            groups.append(parts)
    return groups


def points_of(sample: Any, names: Sequence[str]) -> Any:
    """Points of one hardware: in several scenes every quality found is a floor, over which each draws its least."""
    terms, groups = sample
    quality = next((name for name in names if name in QUALITIES), "snr_db")
    out = [np.empty((0, len(names)))]
    for parts in groups:
        if len(parts) == 1:
            light, worst = parts[0]["power"], parts[0][quality]
        else:
            floors = np.unique(np.concatenate([part[quality] for part in parts]))
            chosen = [least_power(part["power"], part[quality], floors) for part in parts]
            light = np.max([power for power, _ in chosen], axis=0)
            worst = np.min([part[quality][at] for part, (_, at) in zip(parts, chosen, strict=True)], axis=0)
        ok = np.isfinite(light)
        known = {
            "power": terms["camera_power_w"] + light, "cost": terms["cost"], "mass": terms["mass_kg"],
            "gsd_mm": terms["gsd_mm"], quality: worst,
        }  # fmt: skip
        columns = [
            (-1.0 if m in MAXIMISED else 1.0) * np.broadcast_to(known[m], light.shape)[ok] for m in names
        ]
        out.append(np.stack(columns, axis=1))
    return np.concatenate(out)


def least_power(power: Any, quality: Any, floors: Any) -> tuple[Any, Any]:
    """Least power among samples with at least each floor of quality, and which sample draws it; inf: none."""
    order = np.argsort(-quality, kind="stable")
    best, at, least, holder = math.inf, 0, np.empty(len(order)), np.empty(len(order), int)
    for k, i in enumerate(order):
        if power[i] < best:
            best, at = power[i], i
        least[k], holder[k] = best, at
    enough = np.searchsorted(-quality[order], -floors, side="right")
    row = np.maximum(enough - 1, 0)
    return np.where(enough > 0, least[row], np.inf), holder[row]


def sharpest(model: DesignModel, index: int) -> float | None:
    """The smallest f-number with the depth of field, by the bisection of the enumeration; None: there is none."""
    focus = place_focus(model.problem.scenes, model.maps, model.views)
    start, end = SceneSearch(model, index, float(focus.dioptre_per_m[index][0]), np.inf).f_range
    return start if start <= end else None


def drawn(rng: np.random.Generator, low: float, high: float, n: int) -> Any:
    """Numbers evenly spread in their logarithm."""
    return np.exp(rng.uniform(np.log(low), np.log(max(high, low)), n))


def tried(
    model: DesignModel, index: int, n: int, rng: np.random.Generator, f_number: float | None, good: Any, *,
    information: bool,
) -> dict[str, Any]:  # fmt: skip
    """Light power and qualities of feasible settings of one scene, drawn over all that the data sheets allow."""
    light, high = model.lights, float(model.lenses.f_number_max[0])
    f = np.full(n, f_number or 1.0)
    if f_number is None:
        f = np.where(rng.random(n) < 0.5, rng.choice(good, n), drawn(rng, good.min(), high, n))
    steps = light.levels[0][~np.isnan(light.levels[0])]
    level = rng.choice(steps, n) if len(steps) else np.ones(n)
    if light.dims_freely[0]:
        least = max(float(light.min_level[0]), 1e-6)
        level = np.where(rng.random(n) < 0.2, rng.choice([least, 1.0], n), drawn(rng, least, 1.0, n))
    focus = place_focus(model.problem.scenes, model.maps, model.views)
    limit_w = model.problem.mission.limits.power_w
    left_w = np.inf if limit_w is None else limit_w - brute.fixed_terms(model)["camera_power_w"]
    scene = SceneSearch(model, index, float(focus.dioptre_per_m[index][0]), left_w)
    if not scene.possible:
        return {"power": np.empty(0)}
    low, most = scene.time[0], max(scene.time)
    time = np.where(rng.random(n) < 0.4, rng.choice([low, most], n), drawn(rng, low, most, n))
    meeting = scene.prepare(9)
    at = np.array([f_number]) if f_number is not None else brute.f_numbers(*scene.f_range, meeting)
    _, _, *there = scene.candidates(
        np.unique(at)
    )  # the enumeration's grids hold every end of what is allowed
    time, level, f = (np.append(a, b) for a, b in zip((time, level, f), there, strict=True))
    exposure = np.asarray(scene.exposure_s(time), float) * np.ones(len(f))
    return judged(model, index, f, level, time, exposure, information=information)


def judged(
    model: DesignModel, index: int, f: Any, level: Any, time: Any, exposure: Any, *, information: bool
) -> dict[str, Any]:
    """Light power and qualities of those settings that miss nothing."""
    scene, light = model.problem.scenes[index], model.lights
    focus, view = place_focus(model.problem.scenes, model.maps, model.views), scene.view
    seen = model.view_at(index, float(focus.dioptre_per_m[index][0]))
    rate_hz = float(required_rate_hz(view.requirements, view.vehicle.speed_m_s, seen.covered_along_m).max())
    kind, one = int(light.kind[0]), np.ones(len(f))
    pulse = {CONTINUOUS: np.inf * one, PULSED: time, FLASH: light.flash_duration_s[0] * one}[kind]
    dioptre = float(focus.dioptre_per_m[index][0])
    unit = SettingRows(f, exposure, pulse, one, level, rate_hz * one, dioptre * one)
    rows = replace(unit, gain=gains(model, index, unit))
    figures = model.figures(index, rows, information=information)
    ok = np.ones(len(f), bool)
    for margin in model.margins(index, rows, figures):
        size = np.where(np.isfinite(margin.limit), np.abs(margin.limit), 1.0)
        ok &= np.broadcast_to(margin.margin >= -MISSED_REL * size, ok.shape)
    at = scene.nominal
    found = {
        "power": figures.light_power_w, "snr_db": 20.0 * np.log10(np.maximum(figures.snr[:, at], 1e-300)),
        "contrast": np.broadcast_to(figures.contrast, figures.snr.shape)[:, at],
    }  # fmt: skip
    if information:
        found["information"] = figures.information_bit_per_m2
    return {name: np.broadcast_to(values, ok.shape)[ok] for name, values in found.items()}


def gains(model: DesignModel, index: int, unit: SettingRows) -> Any:
    """The gain of the wanted mean level, or the highest that does not saturate."""
    cam, scene = model.cameras, model.problem.scenes[index]
    level = model.figures(index, unit).mean_level
    black = cam.black_level_dn[0] / (2.0 ** cam.bits[0] - 1.0)
    needs = scene.view.requirements
    if needs.mean_level is None:
        gain = (1.0 / needs.highlight_ratio - black) / np.maximum(level.max(axis=1) - black, 1e-300)
    else:
        gain = (needs.mean_level - black) / np.maximum(level[:, scene.nominal] - black, 1e-300)
    return np.clip(gain, 1.0, cam.max_gain[0])


def evaluated_values(search: FrontSearch, front: Front, place: int) -> tuple[Any, list[str]]:
    """What `evaluate_design` says of a front's point, and which requirements it misses."""
    found = found_of(search.search, front, place)
    design, values = cases.evaluated_values(search.search, found, front.axes.names)
    missed = [
        f"{m.requirement} = {m.value} against {m.limit}"
        for s in design.scenes
        for m in s.margins
        if not m.satisfied
    ]
    return values, missed
