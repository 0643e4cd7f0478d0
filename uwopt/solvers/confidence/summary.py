"""What was counted in scenarios, as a result tells it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import takewhile

import numpy as np

from uwopt.forward.problem import Problem
from uwopt.mission.doubt import Doubt
from uwopt.model.multiple import LOST_FACTORS
from uwopt.objectives.objective import Objective
from uwopt.results.certainty import (
    CertaintyPoint,
    CertaintyProof,
    Confidence,
    FixedSettings,
    LostTo,
    Surest,
    WorthKnowing,
)
from uwopt.solvers.confidence.counted import Counted, rank
from uwopt.solvers.confidence.deciding import decided_by, worth_of_knowing
from uwopt.solvers.confidence.outcomes import outcomes
from uwopt.solvers.confidence.proof import NoneBetter
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.search import Certain
from uwopt.solvers.confidence.waters import may_leave_band
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.one_hardware import ids_of_pieces
from uwopt.units import ratio_to_db

Z95 = 1.959964
LEVELS = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.99)
MOST_LOST, MOST_ASKED = 4, 5


def wilson(held: float, count: int) -> tuple[float, float]:
    """Interval that holds a probability with 95 % confidence, from a share p of n draws (Wilson 1927).

        (p + z^2/2n -+ z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n)
    """
    z2n = Z95**2 / count
    centre, half = held + z2n / 2.0, Z95 * math.sqrt(held * (1.0 - held) / count + z2n / (4.0 * count))
    return max((centre - half) / (1.0 + z2n), 0.0), min((centre + half) / (1.0 + z2n), 1.0)


def confidence_record(
    problem: Problem, objective: Objective, certain: Certain, central: Found, *, ends: bool
) -> Confidence:
    """The record of a choice: how often it holds in scenarios that it was not made on, and what certainty costs."""
    seen, first = certain.fresh or certain.best, certain.tried[0]
    return counted_confidence(
        problem, objective, seen, asked="ends" if ends else certain.asked, share=certain.asked,
        in_choice=certain.best,
        central_objective=objective.reported(central.minimised), central_hardware=ids_of_pieces(problem, central),
        central_held=first.held, central_p50=objective.told(first.quantile(0.5)),
        counted=len(certain.tried), complete=certain.complete, fresh=ends or certain.fresh is not None,
        proof=None if certain.proof is None else proof_told(problem, objective, certain.proof),
        surest=None if ends else surest(problem, objective, certain),
        curve=[] if ends else list(curve(problem, objective, certain)),
        decided_by=[] if ends else decided_by(problem, objective, certain.best, certain.scenarios),
        ask_first=[] if ends else [
            WorthKnowing(one.what, one.part, objective.amount(one.worth, certain.best.quantile(0.5)))
            for one in worth_of_knowing(problem, objective, certain)[:MOST_ASKED]
        ],
    )  # fmt: skip


def surest(problem: Problem, objective: Objective, certain: Certain) -> Surest | None:
    """What holds more often than a choice that is not certain enough, though nothing fits by likeliest values."""
    first = min(certain.tried, key=lambda one: rank(one, certain.asked))
    if certain.enough or first.held <= certain.best.held:
        return None
    return Surest(ids_of_pieces(problem, first.found), first.held, missed_centrally(problem, objective, first))


def missed_centrally(problem: Problem, objective: Objective, one: Counted) -> list[str]:
    """What hardware misses first with every number at its central value, iris and focus where scenarios want them."""
    mission = problem.mission
    central = Scenarios.drawn(mission, problem.scenes, mission.doubt.none, seed=mission.seed, count=1)
    stops = None if one.f_number is None else [one.f_number]
    there = problem.focused_on(one.outcomes.meant_m)
    return list(outcomes(there, one.found, objective, central, f_numbers=stops, tells=True).missed(0))


def proof_told(problem: Problem, objective: Objective, proof: NoneBetter) -> CertaintyProof:
    """A proof as a result tells it."""
    return CertaintyProof(
        best_possible=objective.told(proof.lower_bound), complete=proof.left == 0, combinations=proof.total,
        by_panel=proof.by_panel, by_bounds=proof.by_bounds, counted=proof.counted, left=proof.left,
        argued=list(argued(problem)) if proof.by_panel or proof.by_bounds else [],
    )  # fmt: skip


def argued(problem: Problem) -> Iterator[str]:
    """What bounds of a panel and of groups of scenarios take for granted, in words: argued in `panels`, not proven."""
    low, high = problem.mission.doubt.focus
    if problem.effects.veils:
        yield "that no water sends back less light, beside the image, than the best of its group"
    if any(scene.pixels is not None for scene in problem.scenes):
        yield "which pixel decides whether the SNR is reached"
    if high > low:
        yield "that no focus serves better than the sharpest"


def counted_confidence(
    problem: Problem, objective: Objective, seen: Counted, *, asked: float | str, share: float,
    in_choice: Counted | None = None, **more: object,
) -> Confidence:  # fmt: skip
    """The record of one hardware in its scenarios."""
    count = seen.outcomes.value.shape[1]
    low, high = wilson(seen.held, count)
    chosen = in_choice or seen
    missed = list(seen.outcomes.missed(seen.stop).items())[:MOST_LOST]
    return Confidence(
        asked=asked, enough=bool(chosen.held >= share <= max(seen.held, high)), held=seen.held, held_low=low,
        held_high=high, scenarios=count,
        held_in_choice=chosen.held, scenarios_in_choice=chosen.outcomes.value.shape[1],
        p50_in_choice=objective.told(chosen.quantile(0.5)),
        objective_p50=objective.told(seen.quantile(0.5)), objective_p90=objective.told(seen.quantile(0.9)),
        price_p50=None if asked == "ends" or not math.isfinite(seen.outcomes.price) else seen.outcomes.price,
        f_number=seen.f_number, lost_to=[LostTo(name, number / count) for name, number in missed],
        fixed=[
            FixedSettings(scene.name, one.level, 1e3 * one.time_s, ratio_to_db(one.gain))
            for scene, one in zip(problem.scenes, chosen.settings or [], strict=False)
        ],
        drawn=list(drawn(problem.mission.doubt, problem)), **more,  # pyrefly: ignore[bad-argument-type]
    )  # fmt: skip


def curve(problem: Problem, objective: Objective, certain: Certain) -> Iterator[CertaintyPoint]:
    """The least median among the hardware counted, by confidence, as far as any holds so often.

    What the choice has passed over is left out: no settings by likeliest values can be told of it.
    """
    passed = {id(one.found) for one in takewhile(lambda one: one.found is not certain.best.found, certain.ranked)}
    tried = [one for one in certain.tried if id(one.found) not in passed]
    for level in LEVELS:
        stops = [Counted(one.found, one.outcomes, one.outcomes.best(level)) for one in tried]
        best = min(stops, key=lambda one: rank(one, level))
        if best.held >= level and np.isfinite(best.quantile(0.5)):
            again = certain.held_again.get(id(best.outcomes)) if level == certain.asked else None
            median = objective.reported(best.quantile(0.5))
            yield CertaintyPoint(level, median, ids_of_pieces(problem, best.found), again)


def drawn(doubt: Doubt, problem: Problem) -> Iterator[str]:
    """What the scenarios draw, in words."""
    if doubt.parts:
        yield "every estimated number of a part, triangular over its low, central and high value"
    if not problem.paper:
        if doubt.clarity and any(scene.clarity for scene in problem.scenes):
            yield "the water's clarity, within what the reading leaves open"
        if doubt.lamp_leg and any(scene.scattering for scene in problem.scenes):
            if all(scene.counts_orders for scene in problem.scenes):
                low, high = LOST_FACTORS
                yield f"K on the lamps' way, by a factor of {low:g} to {high:g} on the scattered light that is lost"
            else:
                yield "K on the lamps' way, between a + b_b and c"
        if doubt.other_water_table > 0.0:
            share = 100.0 * doubt.other_water_table
            yield f"the other table of the Jerlov types, where it has the water, in {share:g} % of all"
    if doubt.beyond_band > 0.0 and any(map(may_leave_band, problem.scenes)):
        yield f"altitude beyond its band, by up to {100.0 * doubt.beyond_band:g} % of the tolerance"
    seen_px = f", but no farther off than a blur disc of {doubt.focus_px:g} px at the widest opening tells"
    for name, (low, high), than in (
        ("reflectance of the floor", doubt.floor, "what is stated"),
        ("lumens of the lamps", doubt.lamp_output, "what is stated"),
        ("distance at which the lens is focused before its port is sealed", doubt.focus, f"what is meant{seen_px}"),
    ):
        if high > low:
            yield f"{name}, {low:g} to {high:g} times {than}"
