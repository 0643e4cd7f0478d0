"""Random cases with a limit of energy that binds, beside those that have none: drawn by generators of their own."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import small_catalogues as small
from random_cases import Case, bench, case, enumerated

from uwopt.catalog.records import exact

HOURS = (0.5, 8.0, 4000.0)


@cache
def energy_case(seed: int) -> Case:
    """A random case whose energy is what one of its designs needs, or a little more or less, over hours of its own."""
    base, rng = case(seed), np.random.default_rng([seed, 41])
    hours = small.pick(rng, HOURS)
    fits = [one for one in enumerated(seed) if math.isfinite(one.value)]
    if not fits:
        return base
    shares = shares_of(rng, len(base.mission.scenes))
    chosen = small.pick(rng, fits)
    mean_w = mean_power_w(bench(seed).model(chosen.hardware), chosen.settings, shares)
    limit_wh = mean_w * hours * small.pick(rng, [0.9, 0.98, 1.0, 1.05])
    data = base.mission.to_dict()
    for scene, share in zip(data["scenes"], shares, strict=True):
        scene["time_share"] = share
    data["vehicle"]["duration_h"], data["limits"]["energy_wh"] = hours, limit_wh
    changed = base.mission.with_changes(**{key: data[key] for key in ("scenes", "vehicle", "limits")})
    return Case(base.parts, changed, base.objective)


def shares_of(rng: np.random.Generator, count: int) -> list[float]:
    """Shares of the time: all, or most of it in one of two scenes."""
    if count == 1:
        return [1.0]
    first = small.pick(rng, [0.1, 0.25, 0.8])
    return [first, 1.0 - first]


def mean_power_w(model: Any, settings: list[dict[str, float]], shares: list[float]) -> float:
    """Mean over the scenes of cameras and lamps at given settings."""
    camera_w = brute.fixed_terms(model)["camera_power_w"]
    focus = brute.place_focus(model.problem.scenes, model.maps, model.views)
    lamps_w = []
    for index, numbers in enumerate(settings):
        scene = brute.SceneSearch(model, index, float(focus.dioptre_per_m[index][0]), np.inf)
        lamps_w.append(float(model.figures(index, scene.setting_rows(numbers)).light_power_w[0]))
    return camera_w + sum(share * w for share, w in zip(shares, lamps_w, strict=True))


@cache
def switched_case(seed: int) -> Case:
    """A random case whose lamps are off between images, with facts of their own, and its cameras in some of one scene.

    Of the limits a power just above, at or below what one of its designs needs then.
    """
    base, rng = case(seed), np.random.default_rng([seed, 43])
    lights = tuple(
        replace(
            light, switchable=small.pick(rng, ["yes", "yes", "yes", "no"]),
            warm_up_s=exact(small.pick(rng, [0.0, 0.05, 0.3, 2.0])), standby_w=exact(small.pick(rng, [0.0, 0.05, 1.0])),
        )
        for light in base.parts.lights
    )  # fmt: skip
    cameras = tuple(
        replace(
            camera,
            wake_up_s=exact(small.pick(rng, [0.1, 5.0])),
            standby_w=exact(small.pick(rng, [0.01, 0.3])),
        )
        for camera in base.parts.cameras
    )
    vehicle = base.mission.to_dict()["vehicle"] | {"lamps_between_images": "off"}
    if len(base.mission.scenes) == 1:
        vehicle["camera_between_images"] = small.pick(rng, ["on", "off"])
    limits = base.mission.to_dict()["limits"] | {"power_w": None}
    parts = replace(base.parts, lights=lights, cameras=cameras)
    free = Case(parts, base.mission.with_changes(vehicle=vehicle, limits=limits), base.objective)
    if small.chance(rng, 0.6):
        fits = [one.power_w for one in brute.enumerate_all(brute.Bench(free.problem()), free.objective)
                if math.isfinite(one.value)]  # fmt: skip
        if fits:
            limits["power_w"] = small.pick(rng, fits) * small.pick(rng, [0.95, 1.0, 1.02])
    return Case(parts, free.mission.with_changes(limits=limits), base.objective)


@cache
def enumerated_of(case_of: Callable[[int], Case], seed: int) -> list[Any]:
    """Best settings of every hardware of such a case, best first; made once for all ways to search it."""
    made = case_of(seed)
    return brute.enumerate_all(brute.Bench(made.problem()), made.objective)
