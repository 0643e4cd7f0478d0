"""Points of `whatif` at which hardware is recommended with certainty: each by a search of its own, which takes light in
waters and the hardware of the last one where it is about the same water and heights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from uwopt.api.choosing import chosen_of, held_by_yielding
from uwopt.api.counting import Counts
from uwopt.api.recommending import solve_status
from uwopt.api.searching import SETTINGS_SHARE, Searches
from uwopt.api.solving import with_less_practice
from uwopt.api.varied import Systems
from uwopt.api.watch import Watch
from uwopt.catalog.records import OF_A_DESIGN
from uwopt.deadline import Deadline
from uwopt.evaluation.recompute import enclosure_id
from uwopt.forward.assembly import load_catalog
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Value
from uwopt.mission.yielding import Yield
from uwopt.objectives.goal import goal_of
from uwopt.results.certainty import Confidence
from uwopt.results.design import Design
from uwopt.results.whatif import WhatIfPoint, WinningSystem
from uwopt.solvers.exact.certificate import certificate
from uwopt.tolerances import PROVEN_GAP_REL

LISTED = 5  # designs of the central search that its best settable one is taken from


@dataclass
class CertainPoints:
    """Points of one table, one after another."""

    systems: Systems
    deadline: Deadline
    last: Counts | None = None
    scenes_of: Problem | None = None

    def point(self, values: Sequence[Value], mission: Mission) -> WhatIfPoint:
        """What `solve` recommends for a mission at its confidence; the objective is its median over the scenarios.

        Hardware that does not hold as often as asked counts as nothing that fits. Raises KeyboardInterrupt.
        """
        goal, watch = goal_of(mission), Watch(self.deadline)
        for_search = watch.until(self.deadline.but_for(SETTINGS_SHARE))
        found = Searches(load_catalog(mission), goal, LISTED, for_search).of(mission, scenes_of=self.scenes_of)
        sought = found.sought
        if sought.outcome.interrupted or found.widest.outcome.interrupted:
            raise KeyboardInterrupt
        self.scenes_of = sought.problem
        if not sought.outcome.best:
            return WhatIfPoint(list(values), "infeasible" if sought.outcome.complete else "stopped")
        made = chosen_of(found, watch, self.last)
        if made.cut:
            raise KeyboardInterrupt
        counted, design = made.counted, made.design
        if counted is None:
            return WhatIfPoint(list(values), "stopped")
        self.last = made.counts
        if not counted.enough:
            return WhatIfPoint(list(values), "infeasible", figures={"held": counted.held})
        proof = certificate(made.sought.selection, made.sought.problem, made.proven, goal)
        exact = design.is_settable and made.is_best and (proof.gap_rel or 0.0) <= PROVEN_GAP_REL
        status = solve_status(proven=made.sought.outcome.complete, exact=exact)
        status = "optimal" if status == "optimal" else "feasible"
        return WhatIfPoint(
            list(values), status, self.systems.place_of(system_of(design)), counted.objective_p50,
            figures=certain_figures(counted, design),
        )  # fmt: skip


def gives_way_with_certainty(mission: Mission, deadline: Deadline) -> tuple[tuple[Yield, ...], bool, bool]:
    """What of good practice gives way in `solve`; whether any of it did so that something holds as often as is asked;
    and whether it is proven that nothing fits at likeliest values even so.

    Raises KeyboardInterrupt where a person wants no more: what had given way by then is not all.
    """
    watch = Watch(deadline)
    searches = Searches(load_catalog(mission), goal_of(mission), LISTED, watch)
    found = searches.of(mission)
    if found.proves_nothing_fits:
        found = with_less_practice(found, searches, watch)
    if not (found.fits or found.cut):
        return found.given_way, False, found.proves_nothing_fits
    chosen = None if found.cut else held_by_yielding(mission, chosen_of(found, watch), searches, watch)
    if chosen is None or chosen.cut:
        raise KeyboardInterrupt
    return chosen.given_way, chosen.to_hold, False


def system_of(design: Design) -> WinningSystem:
    """The hardware of a design by the ids that a search knows: a complete camera's pieces, a port in its housing."""
    parts = design.hardware.parts
    ids = {kind: parts[kind].id for kind in OF_A_DESIGN} | {"port": enclosure_id(design)}
    generic = any(part.generic for part in parts.values())
    return WinningSystem(**ids, light_count=design.hardware.light_count, generic=generic)


def certain_figures(counted: Confidence, design: Design) -> dict[str, float]:
    """In how many fresh scenarios it holds, and what it costs and draws at likeliest values."""
    made = {
        "held": counted.held, "power_w": design.totals.power_w, "cost": design.totals.cost.value,
        "mass_kg": design.totals.mass_kg,
    }  # fmt: skip
    return {name: float(value) for name, value in made.items() if value is not None}
