"""Lamps that stand in the camera's view, or so near to it that what the water scatters there is not known."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.lamps import LAMP_FRONT_M, Mount
from uwopt.forward.problem import Problem
from uwopt.forward.remembered import once_an_image
from uwopt.forward.views import Views
from uwopt.model.veil.geometry import nearest_approach_m

Array = NDArray[Any]
AT_A_TIME = 256  # images, each with some hundred rays


def lamp_clearance_m(
    problem: Problem, scene_index: int, view: Views, *, port: Array, mount: Mount, count: int
) -> Array:
    """Least distance of a lamp's middle from any ray of each image, at the lowest altitude."""
    range_m, lamps = float(problem.scenes[scene_index].range_m[0]), mount.lamps(count)
    clear = np.full(len(port), np.inf)
    for one in np.unique(port):
        mine = np.nonzero(port == one)[0]
        for some in np.array_split(mine, len(mine) // AT_A_TIME + 1):
            clear[some] = nearest_approach_m(
                view.tan_along[some], view.tan_across[some], shape=problem.shape(int(one), scene_index),
                range_m=range_m, lamps=lamps,
            )  # fmt: skip
    return clear


def lamps_refused(problem: Problem, scene_index: int) -> bool:
    """Whether the mission refuses lamps in the view; physics `paper` puts them on the axis."""
    scene = problem.scenes[scene_index]
    return "lamp" in scene.view.requirements.refuse and not scene.paper


def keeps_clear(
    problem: Problem, scene_index: int, view: Views, *, port: Array, mount: Mount, count: int
) -> Array:
    """Whether no lamp stands in the image, or nearer to it than the radius of its front; tried once an image."""
    clear = np.ones(len(port), bool)
    for one in np.unique(port):
        mine = np.nonzero(port == one)[0]

        def judged(new: Views, one: int = int(one)) -> Array:
            behind = np.full(len(new.tan_along), one)
            clear_m = lamp_clearance_m(problem, scene_index, new, port=behind, mount=mount, count=count)
            return clear_m >= LAMP_FRONT_M * (1 - 1e-9)

        key = ("clear", mount.lamps(count), problem.shape(int(one), scene_index))
        known = problem.scenes[scene_index].cache.setdefault(key, {})
        clear[mine] = once_an_image(known, view.take(mine), judged)
    return clear
