"""Light on the floor over one image: mean and least illuminance, uniformity."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.lamps import (
    Mount,
    luminous_weight,
    on_axis_gain,
)
from uwopt.forward.problem import Problem
from uwopt.forward.views import Views
from uwopt.model.footprint import footprint_illuminance_per_lm

Array = NDArray[Any]


def footprint_light(
    problem: Problem, scene_index: int, view: Views, *, port_index: int, optics: int, mount: Mount, count: int,
    altitude: int,
) -> tuple[float, float]:  # fmt: skip
    """Mean and least floor illuminance per lumen over one imager's footprint [1/m^2]."""
    scene, beam = problem.scenes[scene_index], problem.beam(scene_index, optics)
    range_m = float(scene.range_m[altitude])
    weight = luminous_weight(scene, problem.optics[optics])
    if problem.paper:
        axis = float(on_axis_gain(beam, np.array([range_m]))[0])
        loss = float((weight * np.exp(-scene.lamp_attenuation_per_m * range_m)).sum() / weight.sum())
        return axis * loss, axis * loss
    return footprint_illuminance_per_lm(
        float(view.tan_along[0]), float(view.tan_across[0]), shape=problem.shape(port_index, scene_index),
        range_m=range_m, lamps=mount.lamps(count), beam=beam, weight=weight,
        attenuation_per_m=scene.lamp_attenuation_per_m, fineness=scene.fineness,
    )  # fmt: skip


def uniformity(problem: Problem, scene_index: int, view: Views, **hardware: Any) -> Array:
    """Least over mean floor illuminance at every altitude; 0 where the footprint is dark."""
    pairs = [
        footprint_light(problem, scene_index, view, altitude=n, **hardware)
        for n in range(len(problem.scenes[scene_index].range_m))
    ]
    return np.array([least / mean if mean > 0 else 0.0 for mean, least in pairs])
