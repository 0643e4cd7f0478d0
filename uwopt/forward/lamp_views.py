"""Lamps that stand in the camera's view, or so near to it that what the water scatters there is not known."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.lamps import LAMP_FRONT_M, Mount
from uwopt.forward.problem import Problem
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
    """Whether no lamp stands in the image, or nearer to it than the radius of its front."""
    clear = lamp_clearance_m(problem, scene_index, view, port=port, mount=mount, count=count)
    return np.asarray(clear >= LAMP_FRONT_M * (1 - 1e-9))
