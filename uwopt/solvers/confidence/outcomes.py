"""How one hardware does in each scenario: whether settings meet every requirement, and the best objective with them.

Hardware is bought now. Exposure, gain and light level are set once the water is seen, or fixed before (`fixed`); the
f-number of a lens behind a sealed port is not, so that each stop of its ring is tried in all scenarios. Its focus is
one distance in all of them (`sealed_focus`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.part_columns import Lenses
from uwopt.forward.problem import Problem
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.setting_rows import MISPLACED_S, NO_TIME_S, SMEARED_S
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.fixed import Settings, best_fixed
from uwopt.solvers.confidence.response import unbalanced
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.states import Together
from uwopt.solvers.exact.imager_rules import limit
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.node_designs import NodeDesigns
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.settable.steps import stops
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.question import Best, Question, gap_if_told
from uwopt.tolerances import ROUND

STOPS_ON = (0.0, 1 / 3, 2 / 3, 4 / 3)  # from the widest stop that most scenarios allow: those that are looked at
GAP = 1e-2  # of a scenario's objective where settings have no closed form: far less than scenarios differ
A_SCENARIO = 2000  # cells of one scenario: it counts as missed where none of them does by then
MOST_TOGETHER = 48  # hardware whose rows are in memory at once
LIGHT, SHARP = "light", ("min_mtf_half_nyquist", "resolve_mm")  # what no settings reach
MOST = 0.9  # of the scenarios: a stop that as many allow is not too wide


@dataclass(frozen=True)
class Outcomes:
    """Minimised objective by stop and scenario, (n_stops, n_scenarios); inf where nothing can be set that is enough.

    `lost` : rules that no setting can mend, with the scenarios in which each is the first to be missed
    `short` : by stop, likewise, what settings at that stop cannot reach
    """

    f_numbers: Array  # nan of a lens whose iris is moved at sea
    value: Array
    lost: dict[str, int]
    short: list[dict[str, int]] = field(default_factory=list)
    fixed: list[Settings] = field(default_factory=list)  # by stop, where settings are fixed before the water is seen
    meant_m: float | None = None  # where the lens is focused in the first scene; None: where each scenario wants it
    price: float = np.inf  # of all that is to buy, in half of the scenarios no more

    def missed(self, stop: int) -> dict[str, int]:
        """What is missed first in how many scenarios at one stop, the most frequent first."""
        every = Counter(self.lost) + Counter(self.short[stop] if self.short else {})
        return dict(every.most_common())

    def best(self, confidence: float) -> int:
        """The stop that holds often enough with the least median; where none does, that which holds most often."""
        held = self.held
        enough = held >= confidence
        if not enough.any():
            return int(np.argmax(held))
        median = np.where(enough, self.quantile(0.5), np.inf)
        return int(np.argmin(median))

    @property
    def held(self) -> Array:
        """Share of the scenarios in which each stop holds."""
        return np.asarray(np.isfinite(self.value).mean(axis=1))

    def quantile(self, share: float) -> Array:
        """The objective that each stop keeps or betters in so many of the scenarios."""
        ordered = np.sort(self.value, axis=1)
        return np.asarray(ordered[:, max(int(np.ceil(share * ordered.shape[1])) - 1, 0)])


def outcomes(
    base: Problem, found: Found, objective: Objective, scenarios: Scenarios, deadline: Deadline = NEVER, *,
    f_numbers: Sequence[float] | None = None, given: Settings | None = None, tells: bool = False,
) -> Outcomes:  # fmt: skip
    """How one hardware does in all scenarios, at the stops of its ring or at these, with settings that are given.

    tells : fine detail that blurs from a lack of light
    """
    more = {"f_numbers": f_numbers, "given": given, "tells": tells}
    return outcomes_of_each(base, [found], objective, scenarios, deadline, **more)[0]


def outcomes_of_each(
    base: Problem, found: Sequence[Found], objective: Objective, scenarios: Scenarios, deadline: Deadline = NEVER, *,
    f_numbers: Sequence[float] | None = None, every_stop: bool = False, given: Settings | None = None,
    tells: bool = False,
) -> list[Outcomes]:  # fmt: skip
    """How each hardware does in all scenarios.

    f_numbers : nan: wherever the iris may stand best in each scenario, which no stop of a ring betters
    every_stop : at each stop that any scenario allows, not at likely ones alone
    """
    made: dict[int, Outcomes] = {}
    for places in groups_of(found):
        group = Together.of(base, [found[k] for k in places], scenarios)
        marks = [marks_of(base, group, hardware, f_numbers, every_stop) for hardware in range(len(places))]
        rows = group.rows(objective, deadline) if any(marks) else []
        made |= zip(places, outcomes_together(group, objective, rows, marks, given, tells), strict=True)
    return [made[k] for k in range(len(found))]


def outcomes_where(
    base: Problem, found: Sequence[Found], objective: Objective, scenarios: Scenarios, deadline: Deadline, *,
    wanted: Callable[[Outcomes], bool],
) -> dict[int, Outcomes]:  # fmt: skip
    """The outcomes, at every stop that any scenario allows, of hardware that is wanted even with its iris free.

    The iris and the focus then stand in each scenario where they are best, which nothing betters that is set before.
    """
    made: dict[int, Outcomes] = {}
    for places in groups_of(found):
        deadline.check()
        group = Together.of(base, [found[k] for k in places], scenarios, in_focus=True)
        free = [marks_of(base, group, hardware, [np.nan]) for hardware in range(len(places))]
        if not any(free):
            continue
        rows = group.rows(objective, deadline)
        may = [wanted(one) for one in outcomes_together(group, objective, rows, free)]
        some = [place for place, own in zip(places, may, strict=True) if own]
        if some:
            every = outcomes_of_each(base, [found[k] for k in some], objective, scenarios, deadline, every_stop=True)
            made |= zip(some, every, strict=True)
    return made


def groups_of(found: Sequence[Found]) -> Iterator[list[int]]:
    """Places of hardware that is counted together: what sees through one port side by side."""

    def views(place: int) -> tuple[Any, ...]:
        one = found[place]
        return one.landscape, one.port, one.camera, one.lens, one.light

    order = sorted(range(len(found)), key=views)
    for first in range(0, len(order), MOST_TOGETHER):
        yield order[first : first + MOST_TOGETHER]


def outcomes_together(
    group: Together, objective: Objective, rows: list[SceneRows], marks: Sequence[list[float]],
    given: Settings | None = None, tells: bool = False,
) -> list[Outcomes]:  # fmt: skip
    """How each of a group does with its iris at these marks; `given`: with these settings, where they are fixed."""
    count = group.scenarios.count
    meant_m = [None if np.isnan(own) else float(own) for own in group.meant_m]
    nowhere = np.array([np.nan]), np.full((1, count), np.inf)
    made = [Outcomes(*nowhere, lost, meant_m=own) for lost, own in zip(group.lost, meant_m, strict=True)]
    if not any(marks):
        return made
    imager = [np.tile(np.flatnonzero(group.hardware == h), len(own)) for h, own in enumerate(marks)]
    stop = [np.repeat(own, len(mine) // max(len(own), 1)) for own, mine in zip(marks, imager, strict=True)]
    judge = Judge.of(group, objective, rows, np.concatenate(imager), np.concatenate(stop))
    adapted = judge.adapted()
    fixed: list[list[Settings]] = [[] for _ in marks]
    if group.scenarios.doubt.settings == "fixed" and np.isfinite(np.concatenate(stop)).all():
        sizes = [len(mine) // max(len(own), 1) for own, mine in zip(marks, imager, strict=True) for _ in own]
        every, settings = best_fixed(judge, adapted, sizes, count, share_of(group.problem), given)
        ends = np.cumsum([0, *map(len, marks)])
        fixed = [settings[first:last] for first, last in pairwise(ends)]
    else:
        every = judge.verdict(adapted)
        every = judge.told(*every) if tells else every
    ends = np.cumsum([0, *map(len, imager)])
    for h, own in enumerate(marks):
        if own:
            mine = slice(ends[h], ends[h + 1])
            value, first = every[0][mine].reshape(len(own), -1), every[1][mine].reshape(len(own), -1)
            filled = np.full((len(own), count), np.inf)
            filled[:, group.scenario[imager[h][: value.shape[1]]]] = value
            short = [{name: n for name, n in Counter(row.tolist()).items() if name} for row in first]
            price = float(np.median(judge.designs.cost[mine]))
            made[h] = Outcomes(np.array(own), filled, group.lost[h], short, fixed[h], meant_m[h], price)
    return made


def share_of(problem: Problem) -> float:
    """The share of scenarios that a mission asks for."""
    asked = problem.mission.confidence
    return asked if isinstance(asked, float) else 1.0


def marks_of(
    base: Problem, group: Together, hardware: int, f_numbers: Sequence[float] | None, every: bool = False
) -> list[float]:
    """Where the iris of one hardware is tried: nan where it is moved at sea; nowhere where nothing is seen."""
    mine = np.flatnonzero(group.hardware == hardware)
    if len(mine) == 0:
        return []
    lens = base.lenses.take(np.array([group.found[hardware].lens]))
    if bool(lens.motorised[0]) and group.scenarios.doubt.settings != "fixed":
        return [np.nan]
    if base.f_number is not None:
        return [base.f_number]
    return [float(n) for n in f_numbers] if f_numbers else wanted_stops(lens, group.imagers, mine, every)


def wanted_stops(lens: Lenses, imagers: Imagers, rows: Array, every: bool) -> list[float]:
    """Stops of the lens's ring, and halfway between them, that any scenario allows, or those that most do.

    Of those that most allow the widest, which asks for the least light, some that are closed a little more, and one in
    the middle; the widest that half of them allow, and that any does: where light is short, it decides.
    """
    low = np.max([seen.focused.n_low[rows] for seen in imagers.scenes], axis=0) / ROUND
    high = np.min([seen.focused.n_high[rows] for seen in imagers.scenes], axis=0) * ROUND
    marks = stops(lens, between=True)
    allowed = ((marks[:, None] >= low) & (marks[:, None] <= high)).mean(axis=1)
    useful, share = marks[allowed > 0.0], allowed[allowed > 0.0]
    if len(useful) > len(STOPS_ON) and not every:
        most = useful[share >= min(float(share.max()), MOST)]
        wanted = most[0] * 2.0 ** (np.array(STOPS_ON) / 2.0)
        wider = useful[0], useful[share >= 0.5 * float(share.max())][0]
        useful = np.unique([*wider, *most[np.abs(most[:, None] - wanted).argmin(axis=0)], most[len(most) // 2]])
    return [float(n) for n in useful]


@dataclass(frozen=True)
class Judge:
    """Imagers with the iris of each at its own stop, and what they cost and weigh, (n,): judges their settings."""

    group: Together
    objective: Objective
    rows: list[SceneRows]
    designs: NodeDesigns
    misplaced: Array  # the iris may not stand there

    @staticmethod
    def of(group: Together, objective: Objective, rows: list[SceneRows], imager: Array, stop: Array) -> Judge:
        """Of these imagers of a group."""
        own, lamps = [r.take(imager) for r in rows], (group.light[imager], group.count[imager])
        each = np.arange(len(imager))
        return Judge(
            group, objective, [at_stop(r, stop) for r in own],
            NodeDesigns.of(group.problem, group.imagers, imager, group.under.take(imager), each, *lamps),
            ~np.logical_and.reduce([may_stand_at(r, stop) for r in own]),
        )  # fmt: skip

    @cached_property
    def question(self) -> Question:
        """What is asked of the settings in each scenario."""
        are_told = self.group.scenarios.doubt.settings == "fixed"
        return self.designs.asked(
            self.group.problem, self.group.imagers, self.objective, self.rows,
            gap_rel=GAP if are_told else gap_if_told(self.objective, GAP), most_cells=A_SCENARIO,
        )  # fmt: skip

    def adapted(self) -> Best:
        """The best settings in each scenario, once the water is seen."""
        return best_settings(self.question)

    def verdict(self, best: Best) -> tuple[Array, Array]:
        """Minimised objective with these settings, inf where they miss something, and what is missed first, by name."""
        problem = self.group.problem
        value, terms = self.designs.worth(self.group.imagers, self.question, best)
        limits, designs, power = problem.mission.limits, self.designs, terms.power
        misses = {
            "min_dof_m": self.misplaced,
            **{name: ~kept for name, kept in designs.kept_limits(limits)},
            **{name: lost & ~self.misplaced for name, lost in self.lost_rules()},
            LIGHT: ~best.feasible,
            "power_w": power > limit(limits.power_w) * ROUND,
            "energy_wh": power > problem.scene_power_limit_w * ROUND,  # what is left of it for one scene
        }
        feasible = ~np.logical_or.reduce(list(misses.values()))
        first = np.select(list(misses.values()), list(misses), "")
        return np.where(feasible & np.isfinite(value), value, np.inf), first

    def lost_rules(self) -> Iterator[tuple[str, Array]]:
        """Which designs some rule refuses whatever is set, by the rule's name; the last holds what is left of them."""
        asks_evenness = any(s.view.requirements.min_uniformity is not None for s in self.group.problem.scenes)
        misplaced, smeared = (
            np.logical_or.reduce([r.time_max_s == why for r in self.rows]) for why in (MISPLACED_S, SMEARED_S)
        )
        yield "max_white_balance", np.logical_or.reduce([unbalanced(r) for r in self.rows])
        yield "min_uniformity" if asks_evenness else "lamp_clear_m", misplaced
        yield "max_blur_px", smeared
        yield "rules", np.logical_or.reduce([r.time_max_s < 0.0 for r in self.rows])

    def told(self, value: Array, first: Array) -> tuple[Array, Array]:
        """The verdict, in which fine detail that blurs is no lack of light: that has settings where none is asked for.

        Under the sun, where it takes long to know, both stay one.
        """
        dark = np.flatnonzero(first == LIGHT)
        asked = np.max([[r.min_mtf, r.resolve_m] for r in self.rows], axis=0) > 0.0
        if not (len(dark) and asked.any()) or any(r.sunlit for r in self.rows):
            return value, first
        easier = [replace(r, min_mtf=0.0, resolve_m=0.0) for r in self.rows]
        lit = best_settings(replace(self.question, rows=easier).take(dark)).feasible
        named = np.array(first, dtype=object)
        named[dark[lit]] = SHARP[int(np.argmax(asked))]
        return value, named


def may_stand_at(rows: SceneRows, f_number: Array) -> Array:
    """Whether the iris may stand there: sharp enough, and not closed too far."""
    inside = (f_number >= rows.n_low / ROUND) & (f_number <= rows.n_high * ROUND)
    return np.asarray(inside | ~np.isfinite(f_number))


def at_stop(rows: SceneRows, f_number: Array) -> SceneRows:
    """Rows with the iris at one f-number; nothing is in time where it may not stand there."""
    may, fixed = may_stand_at(rows, f_number), np.isfinite(f_number)
    return replace(
        rows,
        n_low=np.where(fixed & may, f_number, rows.n_low),
        n_high=np.where(fixed & may, f_number, rows.n_high),
        time_max_s=np.where(may, rows.time_max_s, NO_TIME_S),
    )
