"""Tables of one problem used for another mission: its columns with other requirements, some of its imagers alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.choose import Selection
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.assembly import build_problem
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.solvers.exact.imagers import IMAGER_RULES, Imagers, PortBlock, imagers_behind, joined, landscapes

Array = NDArray[Any]
Pairs = Mapping[tuple[int, bool], tuple[Array, Array]]  # camera and lens by the first of like ports and landscape


def asking(problem: Problem, mission: Mission, selection: Selection) -> Problem:
    """The tables of the same parts for a mission that asks for more or less of them in the same scenes."""
    if in_columns(mission) != in_columns(problem.mission):
        return build_problem(mission, selection, scenes=problem.scenes_for(mission))
    return problem.asking(mission)


def in_columns(mission: Mission) -> tuple[Any, ...]:
    """What of a mission's requirements and limits stands in the columns of parts."""
    limits = mission.limits
    return limits.cost_basis, limits.max_exposure_ms, mission.required_depth_m, mission.vehicle.duration_h


def imagers_of(
    problem: Problem, pairs: Pairs, keep: Callable[[PortBlock], PortBlock], deadline: Deadline = NEVER
) -> Imagers:
    """The imagers of some pairs of camera and lens that pass every rule, and of those what is kept.

    Raises OutOfTimeError.
    """
    discarded, blocks, none = dict.fromkeys(IMAGER_RULES, 0), list[PortBlock](), np.empty(0, int)
    for ports in problem.port_groups:
        for landscape in landscapes(problem):
            camera, lens = pairs.get((int(ports[0]), landscape), (none, none))
            if len(camera):
                deadline.check()
                made = imagers_behind(problem, camera, lens, ports, landscape, discarded, {})
                blocks += (keep(block) for block in made)
    return joined(problem, blocks, dict.fromkeys(discarded, 0), {})


def of_block(block: PortBlock, rows: Array) -> PortBlock:
    """Some imagers of those behind like ports."""
    scenes = [scene.take(rows) for scene in block.scenes]
    return PortBlock(block.camera[rows], block.lens[rows], block.port[rows], block.landscape, scenes)
