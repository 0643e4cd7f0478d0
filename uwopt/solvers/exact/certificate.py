"""The certificate: what was proven, over which parts, and where every combination went."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from uwopt.catalog.choose import Selection
from uwopt.catalog.records import OF_A_DESIGN, Part
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.results.result import Certificate, PartsLeft
from uwopt.solvers.exact.account import RULES, Outcome


def per_light(problem: Problem) -> int:
    """How many numbers and mounts each light comes in, times orientations of each imager."""
    return problem.lamp_variants * len(problem.mission.vehicle.orientations)


def certificate(
    selection: Selection, problem: Problem, outcome: Outcome, objective: Objective
) -> Certificate:
    """The account of one search over all combinations of the catalogue it was given."""
    account = outcome.account
    counted = accounted(selection, problem, account.evaluated, account.discarded)
    best = outcome.best[0].minimised if outcome.best else None
    lower = outcome.lower_bound if math.isfinite(outcome.lower_bound) else None
    gap = None if best is None or lower is None else max(0.0, best - lower)
    return Certificate(
        lower_bound=None if lower is None else objective.reported(lower),
        best_value=None if best is None else objective.reported(best),
        gap_abs=None if gap is None or best is None else objective.amount(gap, best),
        gap_rel=None if gap is None or best is None else objective.share(gap, best),
        complete=outcome.complete,
        scope=scope(problem),
        parts_left=parts_left(problem),
        **counted,
    )


def accounted(
    selection: Selection, problem: Problem, evaluated: int, by_rule: Mapping[str, int]
) -> dict[str, Any]:
    """Where every combination of the catalogue went: loaded, selected, evaluated, discarded by rule."""
    catalog, asked = selection.catalog, problem.mission.catalog
    kinds = [*OF_A_DESIGN, *(kind for kind in ("housing", "complete") if getattr(asked, kind) != "none")]
    left: dict[str, int] = {kind: len(catalog.parts(kind)) for kind in kinds}  # pyrefly: ignore[bad-argument-type]
    factor = per_light(problem)
    loaded = combinations(left)
    discarded: list[dict[str, Any]] = []
    for kind in kinds:
        for rule, count in selection.counts[kind].items():  # pyrefly: ignore[bad-index]
            before = combinations(left)
            left[kind] -= count
            discarded.append({"rule": f"{kind}: {rule}", "count": (before - combinations(left)) * factor})
    if "housing" in kinds:
        enclosures = sum(not port.complete for port in problem.parts.ports)
        apart = left["port"] * left["housing"] - enclosures  # no port of that kind goes on it
        others = combinations(left | {"port": apart, "housing": 1}) - combinations(left | {"port": 0})
        if apart:
            discarded.append({"rule": "housing: port", "count": others * factor})
    order = [*RULES, *(rule for rule in by_rule if rule not in RULES)]
    discarded += [{"rule": rule, "count": by_rule[rule]} for rule in order if by_rule.get(rule)]
    return {
        "loaded": factor * loaded,
        "selected": factor * combinations(left),
        "evaluated": evaluated,
        "discarded": discarded,
    }


def combinations(sizes: Mapping[str, int]) -> int:
    """Combinations of so many parts of each kind; a complete camera brings a camera, a lens and a port."""
    whole = sizes.get("complete", 0)
    enclosures = sizes["port"] * sizes.get("housing", 1)
    return (sizes["camera"] + whole) * (sizes["lens"] + whole) * (enclosures + whole) * sizes["light"]


def parts_left(problem: Problem) -> PartsLeft:
    """How many parts of each kind the mission leaves to choose from."""
    parts = problem.parts
    whole = {port.complete for port in parts.ports if port.complete}
    return PartsLeft(
        cameras=len(parts.cameras) - len(whole),
        lenses=len(parts.lenses) - len(whole),
        ports=len({port.id for port in parts.ports if not port.complete}),
        lights=len(parts.lights),
        housings=len({port.housing.id for port in parts.ports if port.housing is not None and not port.complete}),
        complete_cameras=len(whole),
        generic=sum(part.generic for part in all_parts(parts)),
        places=len(problem.mounts),
    )


def scope(problem: Problem) -> str:
    """In words, what the proof covers."""
    left = parts_left(problem)
    low, high = problem.count_range
    mounts = len(problem.mounts)
    return (
        left.in_words()
        + (f" ({left.generic} of these parts generic)" if left.generic else " (real parts only)")
        + f", {low if low == high else f'{low} to {high}'} of them at once, in {mounts} place{'s' * (mounts != 1)}, "
        f"{' and '.join(problem.mission.vehicle.orientations)}; every estimate at its likeliest value; "
        "focus where both ends of the wanted depth are equally sharp; "
        f"physics {'paper' if problem.paper else 'full'}"
        + (
            "; under the sun the whole shutter within the blur limit"
            if any(s.sunlit for s in problem.scenes)
            else ""
        )
    )


def all_parts(parts: Any) -> list[Part]:
    """All parts of a problem in one list."""
    ports = {port.id: port for port in parts.ports}
    housings = {
        port.housing.id: port.housing for port in parts.ports if port.housing is not None and not port.complete
    }
    return [*parts.cameras, *parts.lenses, *ports.values(), *housings.values(), *parts.lights]
