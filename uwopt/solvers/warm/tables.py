"""Tables of one problem used for another mission: its columns with other requirements, some of its imagers alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from uwopt.arrays import Array
from uwopt.catalog.choose import Selection
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.assembly import build_problem
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.solvers.exact.imager_rules import Behind
from uwopt.solvers.exact.imagers import Imagers, PortBlock, imagers_in, landscapes, no_tally

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


def imagers_of_pairs(
    problem: Problem, pairs: Pairs, keep: Callable[[PortBlock], PortBlock], deadline: Deadline = NEVER
) -> Imagers:
    """The imagers of some pairs of camera and lens that pass every rule, and of those what is kept.

    Raises OutOfTimeError.
    """
    asked = (
        Behind(*pairs[place], ports, landscape)
        for ports in problem.port_groups for landscape in landscapes(problem)
        if (place := (int(ports[0]), landscape)) in pairs and len(pairs[place][0])
    )  # fmt: skip
    return replace(imagers_in(problem, asked, keep=keep, deadline=deadline), tally=no_tally())
