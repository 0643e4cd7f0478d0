"""Points of `whatif` at which hardware is recommended with certainty: each a `solve` of its own, without its doubts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from uwopt.api.solving import interrupted, solve
from uwopt.api.varied import Systems
from uwopt.deadline import Deadline
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Value
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.results.whatif import WhatIfPoint, WinningSystem


def certain_point(values: Sequence[Value], mission: Mission, systems: Systems, deadline: Deadline) -> WhatIfPoint:
    """What `solve` recommends for a mission at its confidence; the objective is its median over the scenarios.

    Hardware that does not hold as often as asked counts as nothing that fits. Raises KeyboardInterrupt.
    """
    seconds = deadline.left_s if math.isfinite(deadline.left_s) else None
    result = solve(mission, quick=True, explain=False, seconds=seconds)
    if interrupted(result):
        raise KeyboardInterrupt
    counted, design = result.confidence, result.recommendation
    if design is None:
        return WhatIfPoint(list(values), "infeasible" if result.status == "infeasible" else "stopped")
    if counted is None:
        return WhatIfPoint(list(values), "stopped")
    if not counted.enough:
        return WhatIfPoint(list(values), "infeasible", figures={"held": counted.held})
    status = "optimal" if result.status == "optimal" else "feasible"
    return WhatIfPoint(
        list(values), status, systems.place_of(system_of(design)), counted.objective_p50,
        figures=figures_of(result, design),
    )  # fmt: skip


def system_of(design: Design) -> WinningSystem:
    """The hardware of a design."""
    parts = design.hardware.named
    ids = {kind: parts[kind].id for kind in ("camera", "lens", "port", "light")}
    generic = any(part.generic for part in parts.values())
    return WinningSystem(**ids, light_count=design.hardware.light_count, generic=generic)


def figures_of(result: Result, design: Design) -> dict[str, float]:
    """In how many fresh scenarios it holds, and what it costs and draws by central numbers."""
    assert result.confidence is not None
    made = {
        "held": result.confidence.held, "power_w": design.totals.power_w, "cost": design.totals.cost.value,
        "mass_kg": design.totals.mass_kg,
    }  # fmt: skip
    return {name: float(value) for name, value in made.items() if value is not None}
