"""What could stand in a part's place: systems of a result that differ from the best in few parts, and by how much."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from uwopt.report.text import formats, words
from uwopt.results.design import BillRow, Design
from uwopt.results.result import Result
from uwopt.units import db_to_ratio, format_number

AS_GOOD = 5e-5  # a share that no price or plan depends on


@dataclass(frozen=True)
class OtherSystem:
    """A system beside the best: what it has instead, and how much worse it is."""

    place: str
    differs: str
    hardware: dict[str, str]
    light_count: int | None
    objective_value: float | None
    worse_frac: float | None
    design: Design | None = None


def other_systems(result: Result) -> list[OtherSystem]:
    """Runners-up, parts to be made and other makers' best, the nearest to the best first; none that cannot be set.

    Nor the recommended one, which is among the runners-up where it was chosen for how often it holds.
    """
    best = result.best
    if best is None:
        return []
    found = [of_design(result, best, one, f"runner-up {n}") for n, one in enumerate(result.runners_up, 2)
             if not words.was_passed_over(result, one.objective_value)
             and words.differing_parts(one, best) != words.SAME_HARDWARE]  # fmt: skip
    if result.generic_alternative is not None:
        found.append(of_design(result, best, result.generic_alternative, "parts to be made"))
    known = {tuple(sorted(one.hardware.items())) for one in found}
    for other in result.alternatives:
        value = other.values.get(result.objective.name)
        ids = dict(other.hardware or {})
        if value is None or words.was_passed_over(result, value):
            continue
        if not ids or tuple(sorted(ids.items())) in known:
            continue
        own = best.hardware.ids_by_kind
        differs = ", ".join(f"{kind} {part_id}" for kind, part_id in ids.items() if own.get(kind) != part_id)
        place = f"best with a {other.kind} of {formats.one_line(other.maker, 60)}"
        found.append(OtherSystem(place, differs, ids, None, value, worse_frac(result, value), None))
    return sorted(found, key=lambda one: math.inf if one.worse_frac is None else one.worse_frac)


def of_design(result: Result, best: Design, one: Design, place: str) -> OtherSystem:
    """A design beside the best."""
    ids = one.hardware.ids_by_kind
    share = worse_frac(result, one.objective_value)
    differs = words.differing_parts(one, best)
    return OtherSystem(place, differs, ids, one.hardware.light_count, one.objective_value, share, one)


def worse_frac(result: Result, value: float | None) -> float | None:
    """How much worse a value of the objective is than the best one by the same numbers, as a share of it; of decibels
    that of the ratio."""
    best = words.central_best(result)
    if value is None or best is None:
        return None
    loss = value - best if result.objective.direction == "minimise" else best - value
    if result.objective.unit == "dB":
        return 1.0 - 1.0 / float(db_to_ratio(loss))
    return loss / abs(best) if best else None


def instead_of(result: Result, row: BillRow) -> list[str]:
    """What else could take a part's place with all others as they are, with what that costs in the objective."""
    best = result.best
    if best is None or row.kind not in best.hardware.parts:
        return []
    return [text for _, text in sorted(set(replacements(result, best, row.kind)))]


def replacements(result: Result, best: Design, kind: str) -> Iterator[tuple[float, str]]:
    """Systems that differ from the best in one kind of part alone: by how much they are worse, and in words."""
    own = best.hardware.ids_by_kind
    for other in other_systems(result):
        changed = [name for name, part_id in other.hardware.items() if own.get(name) != part_id]
        if changed == [kind] and other.worse_frac is not None:
            yield other.worse_frac, f"{other.hardware[kind]} ({worse_text(result, other.worse_frac)})"


def worse_text(result: Result, share: float) -> str:
    """How much worse a system is than the best, in words."""
    if share <= AS_GOOD:
        return "as good"
    return f"{format_number(100 * share, 2)} % worse in {result.objective.name.replace('_', ' ')}"


def why_this(result: Result, row: BillRow) -> str:
    """Why a part is in the bill."""
    best = result.best
    if best is None or row.kind == "extra":
        return "every such system needs it" if row.price_status != "own" else "the mission adds it"
    if result.command == "evaluate":
        return "as the system file has it"
    goal = result.objective.name.replace("_", " ")
    others = [one for one in other_systems(result) if one.hardware.get(row.kind) not in (None, row.id)]
    claim = f"no other {row.kind} of the catalogue gives a system that is better in {goal}"
    if result.status != "optimal":
        claim = f"of the best system found, by {goal}; better may exist"
    shares = [one.worse_frac for one in others if one.worse_frac is not None]
    if not shares:
        return claim
    return f"{claim}; the nearest system with another one is {worse_text(result, min(shares))}"
