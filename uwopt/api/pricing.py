"""What requirements cost over a useful range: each binding one made stricter step by step, all parts searched again."""

from __future__ import annotations

from dataclasses import replace

from uwopt.api.common import Source
from uwopt.api.floats import own_float_rules
from uwopt.api.varied import SHARP, Switches, Systems, VariedGrid
from uwopt.api.watch import STAGES
from uwopt.deadline import NEVER, Deadline, OutOfTimeError, Progress, processor_s, unheard
from uwopt.errors import MissionError
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Varied, VariedMission, rounded
from uwopt.objectives.goal import goal_of
from uwopt.results.basis import Price
from uwopt.results.result import Result
from uwopt.results.whatif import WhatIfPoint
from uwopt.solvers.explain.prices import priced_keys, prices, what_it_costs, without_each
from uwopt.solvers.recommend import Sought
from uwopt.solvers.warm.searches import Warm
from uwopt.units import split_unit

STEPS = 4  # beyond what is asked
WITHOUT_SHARE = 0.5  # of the time left, for what would be best without each requirement
AS_GOOD = 1e-3  # of the objective: the optimum is that of the recommended system
PRICES_S = 10.0  # of the processor, where no time is given


@own_float_rules
def range_prices(
    mission: Source | Mission, result: Result, *, deadline: Deadline = NEVER, progress: Progress = unheard,
    sought: Sought | None = None, every: bool = False,
) -> list[Price]:  # fmt: skip
    """What a step more of each binding requirement and of the speed costs with the best system for it.

    Each value is solved at likeliest values, with its certificate; `until` is where the recommended system is no longer
    the best. What the result tells of the system as it is stays; where that is not the best so, nothing is added.
    `sought`: the search that the result tells of, so that what it has worked out is not worked out again.
    `every`: also of requirements that do not bind.
    """
    if result.recommendation is None:
        return []
    base = VariedMission(mission, {})
    deadline = deadline.or_after(PRICES_S, processor_s)
    systems, warm = Systems(goal_of(base.base)), Warm(deadline)
    if sought is not None:
        warm.take(sought)
    told, asked_for = {price.name: price for price in result.prices}, list[WhatIfPoint]()
    keys = [*priced_keys(base.base, result.recommendation, every=every)]
    for number, (key, asked, step) in enumerate(keys):
        if deadline.passed():
            deadline.left_out.append(STAGES["ranges"])
            break
        progress(number / len(keys), f"what {key.name} costs")
        price = range_price(
            base, key, asked, step, systems, warm, best=result.objective.value, asked_for=asked_for,
            free=told[key.name].free_until if key.name in told else None,
        )  # fmt: skip
        if price is not None:
            known = told.get(key.name, price)
            told[key.name] = replace(known, change=price.change, until=price.until, then=price.then)
    return [told[key.name] for key, _, _ in keys if key.name in told]


@own_float_rules
def every_price(
    result: Result, sought: Sought, deadline: Deadline, progress: Progress = unheard
) -> tuple[list[Price], bool]:
    """What every requirement costs as far as there is time, and whether nobody interrupted it.

    First a step more of each with the system as it is, and up to where it costs nothing; then what would be best
    without each, as `prices.without_each`; then as `range_prices`.
    """
    told, mission = list(result.prices), sought.problem.mission
    if result.recommendation is None:
        return told, True
    generic = sought.selection.generic
    try:
        told = prices(sought, result.recommendation, (), deadline, every=True)
        keys = {price.name: place for place, price in enumerate(told)}
        progress(0.0, "what would be best without each requirement")
        phase = deadline.part(WITHOUT_SHARE)
        for key, value in without_each(sought, list(keys), generic, phase):
            told[keys[key]] = replace(told[keys[key]], without=value)
        told = range_prices(
            mission, replace(result, prices=told), deadline=deadline, progress=progress, sought=sought, every=True
        )
    except OutOfTimeError:
        deadline.left_out.append(STAGES["prices"])
    except KeyboardInterrupt:
        return told, False
    return told, True


def range_price(
    base: VariedMission, key: Varied, asked: float, step: float, systems: Systems, warm: Warm, *,
    best: float | None = None, asked_for: list[WhatIfPoint] | None = None, free: float | None = None,
) -> Price | None:  # fmt: skip
    """One key from what is asked on; None where there is no time for the first step, or another optimum than `best`.

    asked_for : the optimum of the mission as it is, once it is known: that of other keys too
    free : value up to which the optimum is known to stay
    """
    far = free if free is not None and abs(free - asked) >= abs(step) else asked  # where it may begin to cost something
    more = [rounded(far + n * step) for n in range(1, STEPS + 1)]
    values = allowed(base, key, [asked, *([far] if far != asked else []), *more])
    varied = Varied(key.key, key.section, key.name, tuple(values))
    if len(values) < 2:
        return None
    grid, points = VariedGrid(base, (varied,), systems, warm), list[WhatIfPoint]()
    same = asked_for if asked_for is not None and values[0] == asked else []
    if same:
        grid.points[values[0],] = replace(same[0], values=[values[0]])
    for value in values:
        if warm.deadline.passed():
            break
        points.append(grid.solve((value,)))
        if len(points) == 1 and not same and points[0].status == "optimal":
            same.append(points[0])
        if value == asked and far != asked:
            grid.points[far,] = replace(points[0], values=[far])
        if points[-1].system != points[0].system:
            break
    if len(points) < 2 or points[0].objective is None or points[1].status == "stopped":
        return None
    if best is not None and abs(points[0].objective - best) > AS_GOOD * abs(best):
        return None  # certainty, or settings that can be set, chose another system
    first, second = points[0].objective, points[1].objective
    change = what_it_costs(first, second, systems.objective)
    price = Price(key.name, split_unit(key.name)[1], asked, step, change)
    if points[-1].system == points[0].system:
        return price
    last, other = (tuple(one.values) for one in points[-2:])
    found = Switches(grid, warm.deadline, unheard).first(0, last, other, SHARP * abs(step))
    until, then = (found.low, found.second) if step > 0 else (found.high, found.first)
    return Price(
        price.name, price.unit, asked, step, price.change, until=rounded(until),
        then="" if then is None else grid.systems.found[then].parts,
    )  # fmt: skip


def allowed(base: VariedMission, key: Varied, values: list[float | int]) -> list[float | int]:
    """The first of these values, up to one that the mission does not allow."""
    made = []
    for value in values:
        try:
            base.with_values({key: value})
        except MissionError:
            break
        made.append(value)
    return made
