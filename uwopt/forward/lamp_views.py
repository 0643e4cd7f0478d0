"""Lamps that may not stand where they are put: in the camera's view or near to it, in one another, in the port."""

from __future__ import annotations

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.lamps import LAMP_FRONT_M, LampGroup, Mount
from uwopt.forward.problem import Problem
from uwopt.forward.remembered import once_an_image
from uwopt.forward.views import Views
from uwopt.model.veil.geometry import nearest_approach_m

AT_A_TIME = 256  # images, each with some hundred rays


def lamp_clearance_m(
    problem: Problem, scene_index: int, view: Views, *, port: Array, lit: LampGroup
) -> Array:
    """Least distance of a lamp's middle from any ray of each image, at the lowest altitude."""
    range_m, lamps = float(problem.scenes[scene_index].range_m[0]), lit.lamps
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
    """Whether the mission refuses places of lamps; physics `paper` puts them on the axis."""
    return views_refused(problem, scene_index) or bodies_refused(problem)


def views_refused(problem: Problem, scene_index: int) -> bool:
    """Whether lamps in the view are refused."""
    return "lamp" in problem.scenes[scene_index].view.requirements.refuse and not problem.paper


def bodies_refused(problem: Problem) -> bool:
    """Whether lamps have bodies, that may not stand in others."""
    return problem.mission.vehicle.lamp_size_m is not None and not problem.paper


def least_clearance_m(problem: Problem) -> float:
    """How far a lamp's middle must stay from the view: the radius of its body, or of its front where that is all."""
    size_m = problem.mission.vehicle.lamp_size_m
    return LAMP_FRONT_M if size_m is None else max(0.5 * size_m, LAMP_FRONT_M)


def places_m(mount: Mount, count: int) -> Array:
    """Where each of the lamps stands, (count, 3); at a baseline alternately to either side."""
    if mount.explicit:
        return np.array([(m.x_m, m.y_m, m.z_m) for m in mount.explicit], float)
    return np.array([(0.0, mount.baseline_m * (-1.0) ** n, 0.0) for n in range(count)], float)


def lamps_apart_m(mount: Mount, count: int) -> float:
    """Least distance between the middles of two lamps; inf of one."""
    places = places_m(mount, count)
    first, second = np.triu_indices(len(places), k=1)
    return float(np.linalg.norm(places[first] - places[second], axis=1).min(initial=np.inf))


def from_port_axis_m(mount: Mount, count: int) -> float:
    """Least distance of a lamp's middle from the port's axis, along which port and housing lie."""
    return float(np.hypot(*places_m(mount, count)[:, :2].T).min())


def port_radius_m(problem: Problem, port: Array) -> Array:
    """Radius of the ports' bodies at least: of a dome's rim, or a window's free aperture, 0 where that is unknown."""
    ports = problem.ports
    window = np.where(np.isfinite(ports.clear_radius_m), ports.clear_radius_m, 0.0)
    rim = np.sqrt(ports.outer_radius_m**2 - np.where(ports.is_dome, ports.rim_gap_m, 0.0) ** 2)
    return np.asarray(np.where(ports.is_dome, rim, window)[port])


def bodies_fit(problem: Problem, *, port: Array, lit: LampGroup) -> Array:
    """Whether the lamps' bodies stand beside one another and beside each port's, (n,)."""
    size_m = problem.mission.vehicle.lamp_size_m
    if size_m is None or problem.paper:
        return np.ones(len(port), bool)
    mount, count = lit.mount, lit.count
    if mount.explicit and len(mount.explicit) != count:  # the places of another number of lamps
        return np.zeros(len(port), bool)
    apart = lamps_apart_m(mount, count) >= size_m * (1 - 1e-9)
    beside = from_port_axis_m(mount, count) >= (port_radius_m(problem, port) + 0.5 * size_m) * (1 - 1e-9)
    return np.asarray(beside & apart)


def keeps_clear(
    problem: Problem, scene_index: int, view: Views, *, port: Array, lit: LampGroup
) -> Array:
    """Whether lamps stand beside each other, the port and the image; the image is tried once."""
    clear = bodies_fit(problem, port=port, lit=lit)
    if not views_refused(problem, scene_index):
        return clear
    least_m = least_clearance_m(problem)
    for one in np.unique(port):
        mine = np.nonzero(port == one)[0]

        def judged(new: Views, one: int = int(one)) -> Array:
            behind = np.full(len(new.tan_along), one)
            clear_m = lamp_clearance_m(problem, scene_index, new, port=behind, lit=lit)
            return clear_m >= least_m * (1 - 1e-9)

        key = ("clear", least_m, lit.lamps, problem.shape(int(one), scene_index))
        known = problem.scenes[scene_index].cache.setdefault(key, {})
        clear[mine] &= once_an_image(known, view.take(mine), judged)
    return clear
