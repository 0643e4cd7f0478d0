"""One mission as a contest: what all solvers start from, and a referee who keeps time and checks every claim."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from uwopt.api.common import prepared
from uwopt.arrays import Array
from uwopt.bench.suite import Budget
from uwopt.catalog.choose import Selection
from uwopt.deadline import Deadline
from uwopt.evaluation.design import evaluate_design
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.designs import Hardware
from uwopt.forward.problem import Problem
from uwopt.forward.scene_rows import SceneRows
from uwopt.mission.mission import Mission
from uwopt.objectives.goal import goal_of
from uwopt.objectives.objective import MAXIMISED, Objective, Terms
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.imager_rules import limit
from uwopt.solvers.exact.search import Search
from uwopt.solvers.population.coding import CodedHardware, Coding
from uwopt.solvers.population.decoding import shortfall
from uwopt.solvers.population.evaluator import Evaluator, lacking_without_veils, scene_rows
from uwopt.solvers.population.light_store import LightStore
from uwopt.solvers.settable.rounding import given_of
from uwopt.tolerances import ROUND

REACHED = 1e-6  # a gap at which nothing is left to see: the run is ended
SAME = 1e-9  # relative
BATCH = 256  # hardware whose light is worked out together
ORDERED = 200_000  # hardware drawn and put in order at a time
LONGEST_S = 120.0  # for a certificate
LEAST_S = 2.0  # the same, when a benchmark has hardly any time left


def mission_of(source: str | None, physics: str | None = None) -> Mission:
    """A mission file, or the mission that `uwopt init` writes; in another physics if one is named."""
    if source is not None:
        return prepared(source, physics, None)
    from uwopt.documents.yaml_lines import compose
    from uwopt.mission.templates import mission_template

    return prepared(compose(mission_template(), "mission")[0], physics, None)


def sources_of(budget: Budget) -> list[tuple[str, str | None]]:
    """Names and files of the missions that a budget asks for."""
    if not budget.missions:
        return [("uwopt init", None)]
    return [(Path(name).stem, name) for name in budget.missions]


def at_most(longest_s: float, budget: Budget) -> float:
    """Seconds for one exact run: no more than half of what a benchmark has left."""
    return min(longest_s, max(0.5 * budget.left_s, LEAST_S))


@dataclass(frozen=True)
class Contest:
    """One mission with its certified optimum. Problems are built anew for every run, before its clock starts."""

    name: str
    mission: Mission
    selection: Selection
    objective: Objective
    best: float | None  # minimised
    lower: float
    complete: bool
    generic: bool  # over parts to be made too, since nothing that is sold fits

    @staticmethod
    def of(name: str, mission: Mission, *, longest_s: float = LONGEST_S) -> Contest:
        """Solve the mission once; where nothing sold fits and the mission lets it be so, with parts to be made."""
        objective, catalog = goal_of(mission), load_catalog(mission)
        policy = mission.catalog.generic
        for generic in ("never", "allow") if policy == "fallback" else (policy,):
            selection = selected(mission, catalog, generic=generic)
            found = certified(build_problem(mission, selection), objective, longest_s)
            if found.best or not found.complete:
                break
        best = found.best[0].minimised if found.best else None
        return Contest(
            name, mission, selection, objective, best, found.lower_bound, found.complete, generic == "allow"
        )

    def problem(self) -> Problem:
        """Tables of the parts, fresh."""
        return build_problem(self.mission, self.selection)

    def gap(self, minimised: float) -> float:
        """How far a value is above what no system can be below, relative to the best."""
        return (minimised - self.lower) / max(abs(self.best or 0.0), 1e-12)


def certified(problem: Problem, objective: Objective, longest_s: float) -> Outcome:
    """The exact search, until its proof is complete or time is up."""
    return Search(problem, objective, top=1, deadline=Deadline.after(longest_s)).whole()


@dataclass(frozen=True)
class Snapshot:
    """Where a run stood at one time."""

    time_s: float
    evaluations: int
    gap_rel: float | None


@dataclass
class Referee:
    """Keeps the time of one run, checks every claim by the forward model, and writes down what improved.

    The clock stands still while a claim is checked: that is no work of the solver's. Claims are checked on
    tables of the referee's own, so that the solver's are neither warmed nor made to reach elsewhere.
    """

    contest: Contest
    seconds: float
    problem: Problem
    evaluations: int = 0
    best: float = np.inf  # minimised, confirmed
    refused: int = 0  # claims that the forward model does not confirm
    seen: list[Snapshot] = field(default_factory=list)
    _judge: Problem = field(init=False)
    _start: float = field(init=False)
    _waited_s: float = 0.0

    def __post_init__(self) -> None:
        self._judge = self.contest.problem()
        self._start = time.perf_counter()

    @property
    def time_s(self) -> float:
        """Seconds that the solver had so far."""
        return time.perf_counter() - self._start - self._waited_s

    @property
    def left_s(self) -> float:
        """Seconds that it still has."""
        return self.seconds - self.time_s

    @property
    def gap(self) -> float | None:
        """Of the best that was confirmed."""
        return self.contest.gap(self.best) if np.isfinite(self.best) else None

    def over(self) -> bool:
        """Whether time is up, or nothing is left to see."""
        gap = self.gap
        return self.left_s <= 0.0 or (gap is not None and gap <= REACHED)

    def claim(self, minimised: float, hardware: Hardware, settings: list[dict[str, float]]) -> None:
        """A solver says that it has a design of this value; believed if better and confirmed."""
        if not minimised < self.best - SAME * abs(self.best if np.isfinite(self.best) else 0.0):
            return
        at_s, began = self.time_s, time.perf_counter()
        value = self._confirmed(hardware, settings)
        self._waited_s += time.perf_counter() - began
        if value is None:
            self.refused += 1
        elif value < self.best:
            self.best = value
            self.seen.append(Snapshot(at_s, self.evaluations, self.contest.gap(value)))

    def _confirmed(self, hardware: Hardware, settings: list[dict[str, float]]) -> float | None:
        """The design's value by the forward model, None where a requirement is missed."""
        given = given_of(self._judge, hardware, settings)
        objective = self.contest.objective
        design = evaluate_design(self._judge, hardware, given, objective)
        if not design.feasible or design.objective_value is None:
            return None
        if objective.single is None:
            return float(design.objective_value)
        sign = -1.0 if objective.single in MAXIMISED else 1.0
        return sign * objective.weight(objective.single) * float(design.objective_value)


class Ground:
    """What the peers of the exact search work on: its tables of imagers and lights."""

    def __init__(self, referee: Referee):
        self.referee, self.problem = referee, referee.problem
        self.objective = referee.contest.objective
        self.search = Search(self.problem, self.objective, top=1, progress=None)
        self.imagers = self.search.prepare()


class VectorGround(Ground):
    """Designs as vectors, and their evaluation in batches: for populations and random search."""

    def __init__(self, referee: Referee):
        super().__init__(referee)
        names = [name for name, weight in self.objective.weights.items() if weight]
        self.weights = np.array([self.objective.weight(name) for name in names])
        self.coding = Coding(self.search, names)
        self.evaluator = Evaluator(self.search, names, self.coding)

    def evaluate(self, vectors: Array) -> tuple[Array, Array]:
        """Values to minimise (n,), inf where infeasible, and violations (n,); the best is claimed."""
        values, violation = self.evaluator.evaluate(vectors)
        self.referee.evaluations += len(vectors)
        minimised = np.where(violation > 0.0, np.inf, values @ self.weights)
        first = int(np.argmin(minimised)) if len(vectors) else 0
        if len(vectors) and minimised[first] < self.referee.best:
            _, found = self.evaluator.found(vectors[first : first + 1])
            if found:
                self.referee.claim(float(minimised[first]), found[0].hardware, found[0].settings)
        return minimised, violation


class LoopGround(Ground):
    """Hardware one by one, for solvers of continuous settings."""

    def __init__(self, referee: Referee):
        super().__init__(referee)
        self.store = LightStore(self.search, sharp=False)

    def batches(self, rng: np.random.Generator) -> Iterator[tuple[CodedHardware, list[SceneRows]]]:
        """Hardware with the settings' view of it, by scene, until it is over.

        Drawn at random from all imagers, lamps, numbers and mounts, as many as are ordered at a time; those
        that limits allow, by what they cost the objective without any light, equals as they were drawn. Light is
        worked out for many together, and what surely gets too little or too much of it is left out.
        """
        while not self.referee.over():
            built = self._drawn(rng)
            built = built.take(np.nonzero(self._allowed(built))[0])
            floor = self.floor(built)
            order = np.argsort(floor, kind="stable")
            for start in range(0, len(order), BATCH):
                some = order[start : start + BATCH]
                some = some[floor[some] < self.referee.best]
                if self.referee.over() or len(some) == 0:
                    break
                part = built.take(some)
                self.referee.evaluations += len(some)
                if self.problem.effects.veils:
                    lacking = lacking_without_veils(self.search, self.store, part)
                    part = part.take(np.nonzero(lacking <= 0.0)[0])
                    if len(part.imager) == 0:
                        continue
                rows = self._rows(part)
                fits = np.nonzero(shortfall(rows, self.search.motorised[part.imager]) <= 0.0)[0]
                if len(fits):
                    yield part.take(fits), [r.take(fits) for r in rows]

    def _drawn(self, rng: np.random.Generator) -> CodedHardware:
        problem, n = self.problem, len(self.imagers)
        low, high = problem.count_range
        sizes = (n, len(problem.parts.lights), high - low + 1, len(problem.mounts))
        every = int(np.prod(sizes, dtype=float))
        drawn = rng.permutation(every) if every <= ORDERED else rng.integers(0, every, ORDERED)
        imager, light, count, mount = np.unravel_index(drawn, sizes)
        optics = problem.lights.optics_index[light]
        return CodedHardware(imager, light, low + count, optics * len(problem.mounts) + mount)

    def _allowed(self, built: CodedHardware) -> Array:
        """What the budgets of cost and mass allow."""
        limits, own = self.problem.mission.limits, built.with_lamps(self.search)
        fits = (own.limit_cost <= limit(limits.cost) * ROUND) & (own.mass_kg <= limit(limits.mass_kg) * ROUND)
        return np.asarray(fits)

    def floor(self, built: CodedHardware) -> Array:
        """The objective of hardware that needs no light at all."""
        imagers, own = self.imagers, built.with_lamps(self.search)
        terms = Terms.at_best(
            imagers.camera_power_w[built.imager], own.cost, own.mass_kg, imagers.gsd_mm[built.imager]
        )
        return np.asarray(self.objective.cost_to_minimise(terms))

    def _rows(self, built: CodedHardware) -> list[SceneRows]:
        return [
            scene_rows(self.search, s, built, self.store.seen(s, built.imager, built.lighting, built.count))
            for s in range(len(self.problem.scenes))
        ]

    def fixed(self, built: CodedHardware, i: int) -> dict[str, Any]:
        """What settings do not change of one design, as the continuous solvers take it."""
        imager, own = int(built.imager[i]), built.take(np.array([i])).with_lamps(self.search)
        return {
            "motorised": bool(self.search.motorised[imager]),
            "camera_power_w": float(self.imagers.camera_power_w[imager]),
            "cost": float(own.cost[0]),
            "mass_kg": float(own.mass_kg[0]),
            "gsd_mm": float(self.imagers.gsd_mm[imager]),
        }

    @property
    def power_limit_w(self) -> float:
        """Of camera and lights together."""
        return limit(self.problem.mission.limits.power_w)

    def claim(self, value: float, built: CodedHardware, i: int, settings: list[dict[str, float]]) -> None:
        """A solver's claim for one design; settings by scene: f_number, time_s, level, gain, exposure_s."""
        imager = int(built.imager[i])
        full = []
        for scene, numbers in zip(self.imagers.scenes, settings, strict=True):
            dioptre_per_m = float(scene.focused.dioptre_per_m[imager])
            rate_hz = float(scene.focused.rate_hz[imager])
            full.append({**numbers, "dioptre_per_m": dioptre_per_m, "rate_hz": rate_hz})
        lighting = self.search.tables.lightings[int(built.lighting[i])]
        hardware = Hardware(
            int(self.imagers.camera[imager]), int(self.imagers.lens[imager]), int(self.imagers.port[imager]),
            bool(self.imagers.landscape[imager]), int(built.light[i]), int(built.count[i]), lighting.mount,
        )  # fmt: skip
        self.referee.claim(value, hardware, full)
