"""What a call of `pareto` asks for: objectives, solvers, time and seed, checked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from uwopt.documents.faults import nearest, show
from uwopt.errors import MissionError
from uwopt.forward.problem import Problem
from uwopt.objectives.axes import FEWEST, MOST, Axes, plain_names
from uwopt.objectives.own import OwnFunction, OwnObjective
from uwopt.solvers.front.points import quality_of

EXACT, PEER = "exact", "nsga2"


def checked_objectives(objectives: Sequence[str | OwnObjective | OwnFunction]) -> list[str | OwnObjective]:
    """Built-in objectives by name, and those of the user's own; a MissionError says what is wrong."""
    if isinstance(objectives, str):
        objectives = [name for name in objectives.split(",") if name.strip()]
    elif not isinstance(objectives, Iterable):
        raise MissionError(f"objectives = {show(objectives)} are no list; write such as ['power', 'cost'].")
    made = [item if isinstance(item, str) else OwnObjective.of(item) for item in objectives]
    own = [item.name for item in made if not isinstance(item, str)]
    if not own:
        return [*Axes.of([str(item) for item in made]).names]
    if not FEWEST <= len(made) <= MOST:
        raise MissionError(f"objectives: {len(made)} are named; a front has two or three.")
    plain = plain_names([item for item in made if isinstance(item, str)])
    if twice := sorted({name for name in own if (plain + own).count(name) > 1}):
        raise MissionError([f"objectives: {name} stands twice; name each once." for name in twice])
    built_in = iter(plain)
    return [next(built_in) if isinstance(item, str) else item for item in made]


def checked_solvers(solver: str | Sequence[str], *, is_plain: bool) -> list[str]:
    """Solvers by name, once each; no exact one but for objectives that are all built in."""
    from uwopt.solvers.population.pymoo_front import ALGORITHMS

    asked = solver.split(",") if isinstance(solver, str) else solver
    if not isinstance(asked, Iterable) or not all(isinstance(name, str) for name in asked):
        raise MissionError(f"solver = {show(solver)} names none; write such as 'exact', or ['exact', 'nsga2'].")
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
    if not is_plain and EXACT in found:
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
