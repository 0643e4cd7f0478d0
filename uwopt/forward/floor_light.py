"""Light on the floor over one image: mean and least illuminance, uniformity."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline, spend
from uwopt.forward.lamps import LampGroup, luminous_weight, on_axis_gain
from uwopt.forward.problem import Problem
from uwopt.forward.remembered import once_an_image
from uwopt.forward.views import Views
from uwopt.model.beam import has_sharp_edge
from uwopt.model.footprint import footprint_illuminance_per_lm, most_uniformity


def footprint_light(
    problem: Problem, scene_index: int, view: Views, *, port_index: int, lit: LampGroup, altitude: int
) -> tuple[float, float]:
    """Mean and least floor illuminance per lumen over one imager's footprint [1/m^2]."""
    scene = problem.scenes[scene_index]
    range_m = float(scene.range_m[altitude])
    beam = problem.floor_lobe(scene_index, lit.optics, lit.mount, range_m)
    weight = luminous_weight(scene, problem.optics[lit.optics])
    lamp_leg = problem.lamp_leg_per_m(scene_index, lit.optics)
    if problem.paper:
        axis = float(on_axis_gain(beam, np.array([range_m]))[0])
        loss = float((weight * np.exp(-lamp_leg * range_m)).sum() / weight.sum())
        return axis * loss, axis * loss
    return footprint_illuminance_per_lm(
        float(view.tan_along[0]), float(view.tan_across[0]), shape=problem.shape(port_index, scene_index),
        range_m=range_m, lamps=lit.lamps, beam=beam, weight=weight,
        attenuation_per_m=lamp_leg, fineness=scene.fineness,
    )  # fmt: skip


def uniformity(problem: Problem, scene_index: int, view: Views, **hardware: Any) -> Array:
    """Least over mean floor illuminance at every altitude; 0 where the footprint is dark."""
    altitudes = range(len(problem.scenes[scene_index].range_m))
    return np.array([evenness(problem, scene_index, view, altitude=n, **hardware) for n in altitudes])


def evenness(problem: Problem, scene_index: int, view: Views, **hardware: Any) -> float:
    """The same at one altitude."""
    mean, least = footprint_light(problem, scene_index, view, **hardware)
    return least / mean if mean > 0 else 0.0


def most_uniformities(
    problem: Problem, scene_index: int, view: Views, *, port_index: int, lit: LampGroup
) -> Array:
    """Upper bounds of the uniformity of many images behind one port at the worst altitude, (n,)."""
    scene = problem.scenes[scene_index]
    if problem.paper:
        return np.ones(len(view.tan_along))
    ends = [
        most_uniformity(
            view.tan_along, view.tan_across, shape=problem.shape(port_index, scene_index), range_m=range_m,
            lamps=lit.lamps, beam=problem.floor_lobe(scene_index, lit.optics, lit.mount, range_m),
            weight=luminous_weight(scene, problem.optics[lit.optics]),
            attenuation_per_m=problem.lamp_leg_per_m(scene_index, lit.optics), fineness=scene.fineness,
        )
        for range_m in {float(scene.range_m[0]), float(scene.range_m[-1])}
    ]  # fmt: skip
    return np.asarray(np.min(ends, axis=0))


def even_enough(
    problem: Problem, scene_index: int, view: Views, *, port: Array, lit: LampGroup, wanted: float,
    deadline: Deadline = NEVER, whole: bool = True,
) -> Array:  # fmt: skip
    """Whether lamps light each image's floor evenly enough at every altitude, (n,).

    Images that are alike are judged once a scene, and few places of the floor tell most of the uneven ones.
    Raises OutOfTimeError past the deadline.

    whole : the whole floor is looked at; else only few places of it, which refuse no even one, where they tell anything
    """
    if wanted <= 0.0:
        return np.ones(len(port), bool)
    scene, beam, lamps = problem.scenes[scene_index], problem.beam(scene_index, lit.optics), lit.lamps
    item = problem.optics[lit.optics]
    least = wanted * (1 - 1e-9)
    even = np.ones(len(port), bool)
    whole = whole or has_sharp_edge(beam)  # of these few places say nothing
    for one in np.unique(port):
        mine = np.nonzero(port == one)[0]
        shape = problem.shape(int(one), scene_index)
        key = (problem.effects.multiple_scattering, beam, item.spectrum_id, item.spectrum, lamps, shape, least)
        hardware: dict[str, Any] = dict(port_index=int(one), lit=lit)

        def lit_so(image: Views, altitude: int, hardware: dict[str, Any]) -> bool:
            spend("floors")
            return evenness(problem, scene_index, image, altitude=altitude, **hardware) >= least

        def not_uneven(new: Views, hardware: dict[str, Any] = hardware) -> Array:
            deadline.check()
            return most_uniformities(problem, scene_index, new, **hardware) >= least

        def judged(new: Views, hardware: dict[str, Any] = hardware, key: Any = key) -> Array:
            even = once_an_image(scene.cache.setdefault(("not uneven", *key), {}), new, not_uneven)
            for row in np.nonzero(even)[0]:
                deadline.check()
                image = new.take(np.array([row]))
                even[row] = all(lit_so(image, n, hardware) for n in range(len(scene.range_m)))
            return even

        what, judge = ("even", judged) if whole else ("not uneven", not_uneven)
        even[mine] = once_an_image(scene.cache.setdefault((what, *key), {}), view.take(mine), judge)
    return even
