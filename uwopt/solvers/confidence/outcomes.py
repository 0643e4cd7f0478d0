"""How one hardware does in each scenario: whether settings meet every requirement, and the best objective with them.

Hardware is bought now. Exposure, gain and light level are set once the water is seen; the f-number of a lens behind a
sealed port is not, so that each stop of its ring is tried in all scenarios. Focus is set to the parts as they come.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.records import Light
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.forward.setting_rows import SceneRows
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.confidence.response import WaterResponse
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.exact.imagers import IMAGER_RULES, Imagers, imagers_behind, joined, limit
from uwopt.solvers.exact.light_tables import Lighting
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.one_hardware import parts_of, problem_of
from uwopt.solvers.settable.steps import stops
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.mean_limit import MeanLimit
from uwopt.tolerances import ROUND

Array = NDArray[Any]
STOPS_ON = (0.0, 1 / 3, 2 / 3, 4 / 3)  # from the widest stop that most scenarios allow: those that are looked at
GAP = 1e-2  # of a scenario's objective where settings have no closed form: far less than scenarios differ
SAME_FIELD = 0.02  # of the logarithm of a field's tangent
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
    f_numbers: Sequence[float] | None = None,
) -> Outcomes:  # fmt: skip
    """How one hardware does in all scenarios, at the stops of its ring or at these."""
    own = dict(parts_of(base, found))
    light = own["light"]
    assert isinstance(light, Light)
    lists = {
        "camera": scenarios.each(own["camera"]), "lens": scenarios.each(own["lens"]),
        "port": scenarios.ports(own["port"]), "light": scenarios.lights(light),
    }  # fmt: skip
    problem = problem_of(base, found, lists=lists)
    imagers, lost = imagers_of(problem, scenarios.port, np.arange(scenarios.count), found.landscape)
    count = scenarios.count
    nothing = Outcomes(np.array([np.nan]), np.full((1, count), np.inf), lost)
    if len(imagers) == 0:
        return nothing
    marks = [np.nan] if bool(problem.lenses.motorised[0]) else list(f_numbers or wanted_stops(problem, imagers))
    if not marks:
        return nothing
    value = np.full((len(marks), count), np.inf)
    rows = rows_of(problem, objective, scenarios, imagers, found, deadline)
    value[:, imagers.camera], short = values_at(problem, objective, imagers, rows, marks, found)
    return Outcomes(np.array(marks), value, lost, short)


def imagers_of(problem: Problem, port: Array, which: Array, landscape: bool) -> tuple[Imagers, dict[str, int]]:
    """The imagers of these scenarios, told by their cameras; and what rules discard of them.

    port : state of the port in each scenario
    """
    discarded, blocks = dict.fromkeys(IMAGER_RULES, 0), []
    for state in np.unique(port[which]):
        mine = which[port[which] == state]
        blocks += list(imagers_behind(problem, mine, mine, np.array([state]), landscape, discarded, {}))
    lost = Counter({rule: number for rule, number in discarded.items() if number})
    return joined(problem, blocks, discarded, {}), dict(lost.most_common())


def rows_of(
    problem: Problem, objective: Objective, scenarios: Scenarios, imagers: Imagers, found: Found, deadline: Deadline
) -> list[SceneRows]:
    """The settings' view of all scenarios, by scene of the mission, a row an imager.

    The light of each is worked out in the water as it is known, and scaled as one of them changes with the water.
    """
    search = Search(problem, objective, top=1, imagers=imagers, deadline=deadline)
    search.prepare()
    who = imagers.camera
    optics = problem.lights.optics_index[who]
    parts = []
    for lighting in search.tables.lightings:
        mine = np.flatnonzero(optics == lighting.optics)
        if len(mine):
            parts.append((mine, rows_under(search, mine, who[mine], lighting, found.count)))
    states = [scenarios.states[k] for k in who]
    lighting = search.tables.lightings[int(optics[0])]
    alone = imagers_of(problem, scenarios.port, who[:1], found.landscape)[0]

    def reference(scenes: list[SceneOptics]) -> list[SceneRows]:
        deadline.check()
        other = Search(problem.in_scenes(scenes), objective, top=1, imagers=alone, deadline=deadline)
        other.prepare()
        return rows_under(other, np.array([0]), who[:1], lighting, found.count, with_rules=False)

    key = image_key(problem, alone, lighting, found)
    if key not in scenarios.known:
        scenarios.known[key] = WaterResponse.of(scenarios.waters, states, reference)
    response = scenarios.known[key]
    every = range(len(problem.scenes))
    known = [SceneRows.in_places([(mine, rows[k]) for mine, rows in parts], len(who)) for k in every]
    return [response.seen_in(index, rows, states) for index, rows in enumerate(known)]


def rows_under(
    search: Search, rows: Array, light: Array, lighting: Lighting, count: int, *, with_rules: bool = True
) -> list[SceneRows]:
    """The settings' view of these imagers, each under its own light of one optics."""
    lights = [search.tables.exact(s, lighting, rows) for s in range(len(search.problem.scenes))]
    return search.rows(rows, lights, light, np.full(len(rows), count), lighting, with_rules=with_rules)


def image_key(problem: Problem, imagers: Imagers, lighting: Lighting, found: Found) -> tuple[Any, ...]:
    """What tells images apart whose light changes differently with the water: fields that differ by more than 2 %."""
    fields = [
        round(float(np.log(tangent[0])) / SAME_FIELD)
        for seen in imagers.scenes
        for tangent in (seen.view.tan_along, seen.view.tan_across)
    ]
    camera, light = problem.parts.cameras[imagers.camera[0]], problem.parts.lights[0]
    port = problem.parts.ports[0]
    ends = (port.geometry, found.lighting.mount, found.count, light.id, tuple(sorted(camera.qe_curves)))
    return (*ends, tuple(camera.qe_curves.values()), *fields)


def wanted_stops(problem: Problem, imagers: Imagers) -> list[float]:
    """Stops of the lens's ring, and halfway between them, that most scenarios allow.

    What is sharp in few scenarios is not looked at. Of the others the widest, which asks for the least light, some that
    are closed a little more, and one in the middle.
    """
    low = np.max([seen.focused.n_low for seen in imagers.scenes], axis=0) / ROUND
    high = np.min([seen.focused.n_high for seen in imagers.scenes], axis=0) * ROUND
    marks = stops(problem.lenses.take(np.array([0])), between=True)
    allowed = ((marks[:, None] >= low) & (marks[:, None] <= high)).mean(axis=1)
    useful, share = marks[allowed > 0.0], allowed[allowed > 0.0]
    if len(useful) > len(STOPS_ON):
        most = useful[share >= min(float(share.max()), MOST)]
        wanted = most[0] * 2.0 ** (np.array(STOPS_ON) / 2.0)
        useful = np.unique([*most[np.abs(most[:, None] - wanted).argmin(axis=0)], most[len(most) // 2]])
    return [float(n) for n in useful]


def values_at(
    problem: Problem, objective: Objective, imagers: Imagers, rows: list[SceneRows], marks: Sequence[float],
    found: Found,
) -> tuple[Array, list[dict[str, int]]]:  # fmt: skip
    """Minimised objective of every imager at each stop, (n_stops, n_imagers); and what is missed at each."""
    each, n = len(marks), len(imagers)
    stop = np.repeat(np.array(marks), n)
    imager = np.tile(np.arange(n), each)
    tried = [at_stop(r.take(imager), stop) for r in rows]
    light = imagers.camera[imager]
    number = np.full(len(imager), found.count)
    to_buy = problem.lamps_to_buy(light, number)
    cost = imagers.cost[imager] + to_buy * problem.lights.price[light]
    limit_cost = imagers.limit_cost[imager] + to_buy * problem.lights.limit_price[light]
    mass = imagers.mass_kg[imager] + number * problem.lights.mass_kg[light]
    camera_power = imagers.camera_power_w[imager]
    none = np.zeros(len(imager))
    best = best_settings(
        tried, problem.lenses.motorised[imagers.lens[imager]], objective, camera_power, problem.scene_power_limit_w,
        gap_rel=GAP, constant=objective.constant(Terms(camera_power, cost, mass, none, imagers.gsd_mm[imager])),
        mean_limit=MeanLimit.of(problem),
    )  # fmt: skip
    power = camera_power + np.max([c.light_power_w for c in best.chosen], axis=0)
    limits = problem.mission.limits
    misses = {
        "min_dof_m": ~np.logical_and.reduce([may_stand_at(r.take(imager), stop) for r in rows]),
        "cost": limit_cost > limit(limits.cost) * ROUND,
        "mass_kg": mass > limit(limits.mass_kg) * ROUND,
        "rules": np.logical_or.reduce([r.time_max_s[imager] < 0.0 for r in rows]),
        "light": ~best.feasible,
        "power_w": power > problem.scene_power_limit_w * ROUND,
    }
    feasible = ~np.logical_or.reduce(list(misses.values()))
    terms = Terms(power, cost, mass, best.snr_db, imagers.gsd_mm[imager], best.contrast, best.information)
    with np.errstate(invalid="ignore"):
        value = objective.cost_to_minimise(terms)
    first = np.select(list(misses.values()), list(misses), "").reshape(each, n)
    short = [{name: int(number) for name, number in Counter(row.tolist()).items() if name} for row in first]
    return np.where(feasible & np.isfinite(value), value, np.inf).reshape(each, n), short


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
        time_max_s=np.where(may, rows.time_max_s, -1.0),
    )
