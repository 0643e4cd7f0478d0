"""What the solvers of one call of `pareto` found, and how a result tells of it: status, proof, methods, frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from uwopt.api.front_asked import EXACT
from uwopt.arrays import Array
from uwopt.errors import SolverError
from uwopt.evaluation.design import evaluate_designs
from uwopt.forward.problem import Problem
from uwopt.objectives.axes import Frame
from uwopt.objectives.dominance import hypervolume, igd_plus
from uwopt.objectives.objective import Objective
from uwopt.results.design import Design
from uwopt.results.front import FrontMethod, FrontObjective, FrontPoint
from uwopt.solvers.exact.certificate import accounted, parts_left, scope
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.front.search import Front
from uwopt.solvers.recommend import check_feasible, part_warnings
from uwopt.solvers.settable.rounding import given_of
from uwopt.tolerances import AGREES_REL

VEILED_REL = 1e-4  # veils are integrated for many images at once and for one, on grids that differ
VEILED = ("contrast", "information", "snr_db")


@dataclass
class FrontSearched:
    """One problem with the fronts found in it."""

    selection: Any
    problem: Problem
    search: Search
    front: Front | None
    peers: list[Any]  # PopulationFront
    cut: str = ""  # the population solver that was interrupted
    points: list[FrontPoint] | None = None  # of the exact front, where they are known already


def is_empty(sought: FrontSearched) -> bool:
    """Whether nothing was found, and time was left to look."""
    if sought.front is not None:
        return sought.front.complete and len(sought.front.values) == 0
    return all(len(peer.values) == 0 and peer.status == "complete" for peer in sought.peers)


def front_proof(sought: FrontSearched, front: Front) -> dict[str, Any]:
    """What the exact front proves, and where every combination went."""
    by_rule = {rule: count for rule, count in front.account.items() if rule != "evaluated"}
    gap = front.hypervolume_bound - front.hypervolume
    known = front.frame is not None or front.complete  # without a point there is no box to measure in
    return {
        "complete": front.complete,
        "scope": scope(sought.problem),
        "parts_left": asdict(parts_left(sought.problem)),
        "hypervolume": front.hypervolume,
        "hypervolume_bound": front.hypervolume_bound if known else None,
        "gap_rel": gap / front.hypervolume_bound if front.hypervolume_bound > 0 else None,
        "points_found": len(front.values),
        **accounted(sought.selection, sought.problem, front.account["evaluated"], by_rule),
    }


def methods_of(sought: FrontSearched, frame: Frame) -> list[FrontMethod]:
    """How each solver did, in one frame."""
    front, out = sought.front, []
    whole = None
    if front is not None and front.frame is not None:
        whole = front.hypervolume
        out.append(
            FrontMethod(
                EXACT, front_status(front), front.seconds, len(front.values), whole, 1.0 if whole else None, 0.0,
                front.account["evaluated"], None, history(front.history, frame), front.hypervolume_bound,
            )
        )  # fmt: skip
    for peer in sought.peers:
        volume = hypervolume(peer.values, frame)
        distance = None if front is None else igd_plus(peer.values, front.values, frame)
        out.append(
            FrontMethod(
                peer.algorithm, peer.status, peer.seconds, len(peer.values), volume,
                volume / whole if whole else None, distance, peer.evaluations, peer.seed,
                history(peer.history, frame),
            )
        )  # fmt: skip
    return out


def front_search_status(sought: FrontSearched, *, limited: bool) -> str:
    """In one word, how the search ended; `limited`: the call set a time."""
    if sought.front is not None:
        empty = len(sought.front.values) == 0
        return "infeasible" if empty and sought.front.complete else front_status(sought.front)
    if sought.cut:
        return "interrupted"
    empty = all(len(peer.values) == 0 for peer in sought.peers)
    if empty and all(peer.status == "complete" for peer in sought.peers):
        return "infeasible"
    cut = limited and any(peer.status == "stopped" for peer in sought.peers)
    return "stopped" if empty or cut else "complete"


def front_status(front: Front) -> str:
    """complete, stopped or interrupted."""
    return "interrupted" if front.interrupted else "complete" if front.complete else "stopped"


def points_evaluated(problem: Problem, founds: Sequence[Found]) -> list[Design]:
    """Designs evaluated again through the forward model: figures and margins."""
    asked = [
        (hardware := found.hardware, given_of(problem, hardware, found.settings)) for found in founds
    ]
    designs = evaluate_designs(problem, asked, Objective({"power": 1.0}))
    return [
        replace(design, objective_value=None, warnings=[*part_warnings(problem, hardware), *design.warnings])
        for design, (hardware, _) in zip(designs, asked, strict=True)
    ]


def check_point_claim(claimed: dict[str, float], reported: dict[str, float], design: Design) -> None:
    """The forward model must agree with the search, and every requirement must hold."""
    for name, value in claimed.items():
        rel = VEILED_REL if name in VEILED else AGREES_REL
        if not math.isclose(value, reported[name], rel_tol=rel, abs_tol=1e-9):
            raise SolverError(
                f"the front claims {name} = {value:.9g}, the evaluation of the same design says "
                f"{reported[name]:.9g}; this is a defect of uwopt"
            )
    check_feasible(design, "the front")


def reference(objectives: Sequence[FrontObjective], frame: Frame) -> dict[str, Any]:
    """The frame by objective: its best and worst corner, where hypervolumes are measured from, and logarithms."""
    signs = np.array([o.sign for o in objectives])
    corners = {"ideal": np.zeros(len(signs)), "nadir": np.ones(len(signs)), "point": frame.reference}
    named = {
        key: dict(zip([o.name for o in objectives], (frame.values(unit) * signs).tolist(), strict=True))
        for key, unit in corners.items()
    }
    return {**named, "log": {o.name: bool(log) for o, log in zip(objectives, frame.log, strict=True)}}


def history(snapshots: Sequence[tuple[float, Array]], frame: Frame) -> list[list[float]]:
    """Hypervolume over time."""
    return [[float(seconds), hypervolume(values, frame)] for seconds, values in snapshots]
