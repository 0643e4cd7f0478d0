"""Parts whose doubtful numbers stand at an end of their ranges, and which of these can matter at all."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from uwopt.catalog.parts.doubts import doubtful, taken_as, with_numbers
from uwopt.catalog.parts.kinds import EITHER
from uwopt.catalog.records import Port, Quantity, exact
from uwopt.forward.part_columns import FAVOURED
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective


def at_end(part: Any, end: str, only: str | None = None) -> Any:
    """A part with its doubtful numbers (or one of them) put at one end of their ranges.

    `good` and `bad` move what has such ends; `low` and `high` what may favour a design at either.
    """

    def value_at(name: str, known: Quantity) -> Quantity | None:
        if only is not None and name != only:
            return None
        if end in ("low", "high"):
            value = known.low if end == "low" else known.high
            return exact(value, known.status, known.source) if name in EITHER else None
        best, worst = (known.high, known.low) if FAVOURED.get(name, 0) > 0 else (known.low, known.high)
        return taken_as(name, known, best if end == "good" else worst) if FAVOURED.get(name, 0) else None

    return with_numbers(part, value_at, housing=only is None)


def with_either_end(part: Any) -> list[Any]:
    """A part as it is, and at both ends of what may favour a design at either."""
    if any(name in EITHER for name, _ in doubtful(part)):
        return [part, at_end(part, "low"), at_end(part, "high")]
    return [part]


def housing_at_end(port: Port, end: str, only: str | None = None) -> Port:
    """A port whose housing's doubtful numbers (or one of them) are put at one end of their ranges."""
    return replace(port, housing=at_end(port.housing, end, only))


def matters(name: str, problem: Problem, objective: Objective) -> bool:
    """Whether a field can enter the objective or a limit at all."""
    limits = problem.mission.limits
    if name == "price":
        return bool(objective.weight("cost")) or limits.cost is not None
    if name == "mass_g":
        return bool(objective.weight("mass")) or limits.mass_kg is not None
    return bool(FAVOURED.get(name)) or name in EITHER
