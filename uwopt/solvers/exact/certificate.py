"""The certificate: what was proven, over which parts, and where every combination went."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from uwopt.catalog.choose import Selection
from uwopt.catalog.records import Part
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.results.result import Certificate
from uwopt.solvers.exact.account import RULES, Outcome

KINDS = ("camera", "lens", "port", "light")


def per_light(problem: Problem) -> int:
    """How many numbers and mounts each light comes in, times orientations of each imager."""
    low, high = problem.count_range
    return (high - low + 1) * len(problem.mounts) * len(problem.mission.vehicle.orientations)


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
        **counted,
    )


def accounted(
    selection: Selection, problem: Problem, evaluated: int, by_rule: Mapping[str, int]
) -> dict[str, Any]:
    """Where every combination of the catalogue went: loaded, selected, evaluated, discarded by rule."""
    catalog = selection.catalog
    kinds = KINDS if problem.mission.catalog.housing == "none" else (*KINDS, "housing")
    sizes: dict[str, int] = {kind: len(catalog.parts(kind)) for kind in kinds}  # type: ignore[arg-type]
    chosen: dict[str, int] = {kind: len(selection.indices[kind]) for kind in kinds}  # type: ignore[index]
    factor = per_light(problem)
    discarded: list[dict[str, Any]] = []
    left = dict(sizes)
    for kind in kinds:
        others = math.prod(left[k] for k in kinds if k != kind)
        for rule, count in selection.counts[kind].items():  # type: ignore[index]
            discarded.append({"rule": f"{kind}: {rule}", "count": count * others * factor})
        left[kind] = chosen[kind]
    if "housing" in kinds:
        apart = chosen["port"] * chosen["housing"] - len(problem.parts.ports)  # no port of that kind goes on it
        others = math.prod(chosen[k] for k in ("camera", "lens", "light"))
        if apart:
            discarded.append({"rule": "housing: port", "count": apart * others * factor})
    order = [*RULES, *(rule for rule in by_rule if rule not in RULES)]
    discarded += [{"rule": rule, "count": by_rule[rule]} for rule in order if by_rule.get(rule)]
    return {
        "loaded": factor * math.prod(sizes.values()),
        "selected": factor * math.prod(chosen.values()),
        "evaluated": evaluated,
        "discarded": discarded,
    }


def scope(problem: Problem) -> str:
    """In words, what the proof covers."""
    parts = problem.parts
    generic = sum(p.generic for p in all_parts(parts))
    low, high = problem.count_range
    ports = {port.id for port in parts.ports}
    housings = {port.housing.id for port in parts.ports if port.housing is not None}
    return (
        f"{len(parts.cameras)} cameras, {len(parts.lenses)} lenses, {len(ports)} ports, "
        + (f"{len(housings)} housings, " if housings else "")
        + f"{len(parts.lights)} lights"
        + (f" ({generic} of these parts generic)" if generic else " (real parts only)")
        + f", {low} to {high} lights, {len(problem.mounts)} mount(s), "
        f"{' and '.join(problem.mission.vehicle.orientations)}; estimates at their central values; "
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
    housings = {port.housing.id: port.housing for port in parts.ports if port.housing is not None}
    return [*parts.cameras, *parts.lenses, *ports.values(), *housings.values(), *parts.lights]
