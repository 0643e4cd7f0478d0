"""What a call of `pareto` asks for: objectives, solvers, time and seed, checked."""

from __future__ import annotations

from collections.abc import Sequence

from uwopt.documents.faults import nearest
from uwopt.errors import MissionError
from uwopt.forward.problem import Problem
from uwopt.objectives.axes import FEWEST, MOST, Axes, plain_names
from uwopt.objectives.own import OwnFunction, OwnObjective
from uwopt.solvers.front.points import quality_of

EXACT, PEER = "exact", "nsga2"


def split(
    objectives: Sequence[str | OwnObjective | OwnFunction],
) -> tuple[list[str], list[OwnObjective]]:
    """Names of built-in objectives, and those of the user's own; a MissionError says what is wrong."""
    if isinstance(objectives, str):
        objectives = [name for name in objectives.split(",") if name.strip()]
    names = [item for item in objectives if isinstance(item, str)]
    own = [OwnObjective.of(item) for item in objectives if not isinstance(item, str)]
    if own and not FEWEST <= len(names) + len(own) <= MOST:
        raise MissionError(f"objectives: {len(names) + len(own)} are named; a front has two or three.")
    return (plain_names(names) if own else list(Axes.of(names).names)), own


def check_numbers(seconds: float | None, seed: int | None) -> None:
    """Time above 0, a seed of 0 or more."""
    faults = []
    if seconds is not None and not seconds > 0:
        faults.append(
            f"seconds = {seconds} is no time to search in; give more than 0, or none for the usual time."
        )
    if seed is not None and seed < 0:
        faults.append(f"seed = {seed} is below 0; seeds are whole numbers from 0.")
    if faults:
        raise MissionError(faults)


def checked_solvers(solver: str | Sequence[str], own: Sequence[OwnObjective]) -> list[str]:
    """Solvers by name, once each; with own objectives no exact one."""
    from uwopt.solvers.population.pymoo_front import ALGORITHMS

    asked = solver.split(",") if isinstance(solver, str) else list(solver)
    plain = list(dict.fromkeys(name.strip().casefold().replace("-", "") for name in asked if name.strip()))
    known = {name.replace("-", ""): name for name in (EXACT, *ALGORITHMS)}
    faults = []
    for name in plain:
        if name not in known:
            near = nearest(name, known)
            hint = f"did you mean {known[near]}?" if near else f"there are {', '.join(known.values())}."
            faults.append(f"solver {name!r} is not known; {hint}")
    if faults or not plain:
        raise MissionError(faults or [f"solver: none is named; there are {', '.join(known.values())}."])
    found = [known[name] for name in plain]
    if own and EXACT in found:
        found.remove(EXACT)
        found = found or [PEER]
    return found


def why_no_exact(problem: Problem, axes: Axes | None) -> str:
    """Why the exact search is left to population solvers where both are asked for; empty: it is not."""
    if axes is None:
        return ""
    try:
        quality_of(problem, axes)
    except MissionError:
        return "more than one objective depends on the settings, and the exact search knows one beside power"
    return ""
