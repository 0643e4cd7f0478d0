"""Fronts by pymoo's population algorithms: integer-coded vectors, rounding repair, an archive of what nothing beats.

The only module that imports pymoo; import it late. It decides which vectors to try; what they are worth is
worked out in batches by `evaluator`. Nothing here knows the exact front.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import import_module
from math import comb
from typing import Any

import moocore
import numpy as np
from pymoo.config import Config

from uwopt.arrays import Array
from uwopt.deadline import Progress, unheard
from uwopt.objectives.axes import LOGARITHMIC, scale
from uwopt.objectives.dominance import MARGIN, NEAR, in_box, nondominated, unlike_rows
from uwopt.objectives.own import OwnObjective
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.population.coding import Coding, layers
from uwopt.solvers.population.evaluator import Evaluator

Config.warnings["not_compiled"] = False  # a plain install has no compiled modules, and none are needed

from pymoo.core.algorithm import Algorithm  # noqa: E402
from pymoo.core.problem import Problem  # noqa: E402
from pymoo.core.termination import NoTermination  # noqa: E402
from pymoo.operators.crossover.sbx import SBX  # noqa: E402
from pymoo.operators.mutation.pm import PM  # noqa: E402
from pymoo.operators.repair.rounding import RoundingRepair  # noqa: E402

#: Those of pymoo that handle constraints and three objectives (MOEA/D does not) and need no further package
#: (AGE-MOEA wants numba).
ALGORITHMS = ("nsga2", "nsga3", "unsga3", "ctaea", "rvea", "spea2", "smsemoa")
WITH_DIRECTIONS = ("nsga3", "unsga3", "ctaea", "rvea")
MODULES = {"smsemoa": "sms"}  # of other names than theirs
POP_SIZE = 200
GENERATIONS = 1000
SBX_ETA, PM_ETA = 5.0, 10.0
DRAWN_ANEW = 0.5  # genes of hardware in a vector, on average
NEWCOMERS = 0.1  # of the offspring, that owe nothing to their parents
SCOUTS = 10  # vectors looked at for each of the first population
SCOUTING = 0.3  # of the time, at most
STAGNATES_AFTER = 60  # generations in which the hypervolume grew by no more than
STAGNATES_REL = 1e-4
SNAPSHOTS = 200  # of the archive, at most
WORST = 1e6  # of infeasible vectors in every objective: they are told apart by their violation


@dataclass(frozen=True)
class PopulationFront:
    """What a population search found: nondominated, feasible designs, no two alike."""

    values: Array  # (n, n_axes) less is better; maximised figures are negated
    found: list[Found]
    axes: list[str | OwnObjective]
    evaluations: int
    generations: int
    seconds: float
    status: str  # complete | stopped | interrupted
    seed: int
    algorithm: str
    history: list[tuple[float, Array]] = field(
        default_factory=list
    )  # seconds, values of the archive (not thinned)


def population_front(
    search: Search, axes: Sequence[str | OwnObjective], *, algorithm: str = "nsga2", seed: int = 0,
    seconds: float | None = None, pop_size: int | None = None, generations: int | None = None,
    progress: Progress | None = None,
) -> PopulationFront:  # fmt: skip
    """Trade-off between objectives by a population algorithm, over a search that is prepared.

    Parameters
    ----------
    search : after `prepare()`; its objective should weigh every built-in axis, so that bounds know them
    axes : names of `objectives.objective.UNITS`, or `OwnObjective`s
    algorithm : one of `ALGORITHMS`
    seconds : stop after as many
    generations : stop after as many; by default when the hypervolume stagnates

    With the same seed and no time limit the same front comes out. Ctrl-C keeps what was found.
    """
    run = PymooRun(search, list(axes), algorithm, seed, pop_size or POP_SIZE)
    status = "complete"
    if not run.coding.empty:
        status = run.until(seconds, generations, progress or unheard)
    return run.result(status)


class PymooRun:
    """State of one run."""

    def __init__(
        self, search: Search, axes: list[str | OwnObjective], algorithm: str, seed: int, pop_size: int
    ):
        self.start = time.perf_counter()
        self.search, self.axes, self.name, self.seed, self.pop_size = search, axes, algorithm, seed, pop_size
        self.coding = Coding(search, axes)
        self.evaluator = Evaluator(search, axes, self.coding)
        self.log = np.array([isinstance(axis, str) and axis in LOGARITHMIC for axis in axes])
        self.archive = Archive(self.log, len(self.coding.upper))
        self.history: list[tuple[float, Array]] = []
        self.generations = 0

    def until(self, seconds: float | None, generations: int | None, progress: Progress) -> str:
        """Breed until the front stagnates, or generations or seconds are over; why it ended."""
        most = generations or GENERATIONS
        marks = [self.archive.values]
        try:
            algorithm = self._algorithm(most, self._scouted(seconds))
            while self.generations < most:
                algorithm.next()
                self.generations += 1
                spent = self.seconds
                share = max(self.generations / most, 0.0 if seconds is None else spent / seconds)
                progress(min(share, 1.0), f"{len(self.archive)} designs on the front")
                if seconds is not None and spent > seconds:
                    return "stopped"
                marks.append(self.archive.values)
                if generations is None and self._stagnates(marks):
                    break
        except KeyboardInterrupt:  # what the archive holds is kept
            return "interrupted"
        return "complete"

    @property
    def seconds(self) -> float:
        """Since the run began."""
        return time.perf_counter() - self.start

    def evaluate(self, vectors: Array) -> tuple[Array, Array]:
        """Values as the algorithm sees them, and violations; the archive keeps what is feasible."""
        values, violation = self.evaluator.evaluate(vectors)
        good = np.nonzero(violation <= 0.0)[0]
        if len(good) and self.archive.add(vectors[good], values[good]):
            self._remember()
        scaled = np.full_like(values, WORST)
        scaled[good] = scale(values[good], self.log)
        return scaled, violation

    def result(self, status: str) -> PopulationFront:
        """The archive as designs."""
        vectors, values = self.archive.thinned()
        kept, found = self.evaluator.found(vectors)
        return PopulationFront(
            values=values[kept], found=found, axes=self.axes,
            evaluations=self.evaluator.count, generations=self.generations, seconds=self.seconds, status=status,
            seed=self.seed, algorithm=self.name, history=self.history,
        )  # fmt: skip

    # ------------------------------------------------------------ progress of the front

    def _remember(self) -> None:
        """A snapshot of the archive; every second one goes when there are too many."""
        self.history.append((self.seconds, self.archive.values))
        if len(self.history) > SNAPSHOTS:
            self.history = [*self.history[:-1:2], self.history[-1]]

    def _stagnates(self, marks: list[Array]) -> bool:
        """Whether the hypervolume hardly grew over many generations, measured in the box of the front today."""
        if len(marks) <= STAGNATES_AFTER or len(marks) % 10 or len(self.archive) == 0:
            return False
        before, now = marks[-1 - STAGNATES_AFTER], marks[-1]
        if len(before) == 0:
            return False
        if before is now:
            return True
        reference = np.full(now.shape[1], MARGIN)
        before, now = (in_box(values, now, self.log) for values in (before, now))
        gone = moocore.hypervolume(np.minimum(before, reference), ref=reference)
        grown = moocore.hypervolume(now, ref=reference) - gone
        return bool(grown <= STAGNATES_REL * moocore.hypervolume(now, ref=reference))

    # ------------------------------------------------------------ pymoo

    def _scouted(self, seconds: float | None) -> Array:
        """The first population: the best of more vectors than it has room for, feasible ones first."""
        rng = np.random.default_rng(self.seed)
        vectors = self.coding.first(SCOUTS * self.pop_size, rng)
        parts = []
        for start in range(0, len(vectors), self.pop_size):
            parts.append(self.evaluate(vectors[start : start + self.pop_size]))
            if seconds is not None and self.seconds > SCOUTING * seconds:
                break
        values, violation = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        feasible = np.nonzero(violation <= 0.0)[0]
        best = feasible[layers(values[feasible], self.pop_size)]
        others = np.argsort(np.where(violation > 0.0, violation, np.inf), kind="stable")
        return vectors[np.concatenate([best, others[: self.pop_size - len(best)]])]

    def _algorithm(self, generations: int, first: Array) -> Algorithm:
        """The algorithm, ready for its first generation."""
        common: dict[str, Any] = dict(
            sampling=first,
            crossover=Exchange(self.coding.n_hardware),
            mutation=Mutation(self.coding),
            repair=RoundingRepair(),
            eliminate_duplicates=True,
        )
        made = create(self.name, len(self.axes), self.pop_size, common)
        made.setup(
            Vectors(self), termination=terminator(self.name, generations), seed=self.seed, verbose=False
        )
        return made


class Vectors(Problem):
    """The problem as pymoo sees it: integer vectors, all of a generation at once."""

    def __init__(self, run: PymooRun):
        super().__init__(
            n_var=len(run.coding.upper), n_obj=len(run.axes), n_ieq_constr=1, xl=0, xu=run.coding.upper, vtype=int
        )
        self.run = run

    def _evaluate(self, x: Array, out: dict[str, Array], *args: Any, **kwargs: Any) -> None:
        values, violation = self.run.evaluate(np.asarray(x, int))
        out["F"], out["G"] = values, violation[:, None]


class Exchange(SBX):
    """Settings by simulated binary crossover; hardware, which has no between, is swapped gene by gene."""

    def __init__(self, n_hardware: int):
        super().__init__(prob=0.9, eta=SBX_ETA, vtype=float)
        self.n_hardware = n_hardware

    def _do(self, problem: Problem, x: Array, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
        made = super()._do(problem, x, *args, random_state=random_state, **kwargs)
        hardware = slice(0, self.n_hardware)
        swap = random_state.random(x.shape[1:])[:, hardware] < 0.5
        first, second = x[0][:, hardware], x[1][:, hardware]
        made[0][:, hardware], made[1][:, hardware] = (
            np.where(swap, second, first),
            np.where(swap, first, second),
        )
        return made


class Mutation(PM):
    """Polynomial mutation; genes of hardware are as often drawn anew, and some vectors are all new."""

    def __init__(self, coding: Coding):
        super().__init__(prob=0.9, eta=PM_ETA, vtype=float)
        self.coding = coding

    def _do(self, problem: Problem, x: Array, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
        made = super()._do(problem, x.astype(float), *args, random_state=random_state, **kwargs)
        n = self.coding.n_hardware
        anew = random_state.random((len(x), n)) < DRAWN_ANEW / n
        made[:, :n] = np.where(anew, self.coding.random(len(x), random_state)[:, :n], made[:, :n])
        fresh = np.nonzero(random_state.random(len(x)) < NEWCOMERS)[0]
        made[fresh] = self.coding.drawn(len(fresh), random_state)
        return made


def terminator(name: str, generations: int) -> Any:
    """RVEA wants to know how far it is; the others run until they are stopped."""
    if name != "rvea":
        return NoTermination()
    from pymoo.termination.max_gen import MaximumGenerationTermination

    return MaximumGenerationTermination(generations)


def create(name: str, n_axes: int, pop_size: int, common: dict[str, Any]) -> Algorithm:
    """One of pymoo's algorithms; imported one by one, since that takes time."""
    algorithm = getattr(import_module(f"pymoo.algorithms.moo.{MODULES.get(name, name)}"), name.upper())
    if name not in WITH_DIRECTIONS:
        return algorithm(pop_size=pop_size, **common)
    directions = reference_directions(n_axes, pop_size)
    if name == "ctaea":  # has as many vectors as directions
        return algorithm(ref_dirs=directions, **common | {"sampling": common["sampling"][: len(directions)]})
    return algorithm(ref_dirs=directions, pop_size=pop_size, **common)


def reference_directions(n_axes: int, pop_size: int) -> Array:
    """Evenly spread directions, those of the finest simplex lattice that has no more than the population."""
    from pymoo.util.ref_dirs import get_reference_directions

    steps = 1
    while comb(steps + n_axes, n_axes - 1) <= pop_size:
        steps += 1
    return np.asarray(get_reference_directions("das-dennis", n_axes, n_partitions=steps))


# ---------------------------------------------------------------- what was met


MOST_POINTS = 3000  # kept while a search runs
FINEST_REL = 1e-5  # by which the closest of them go first


class Archive:
    """All nondominated points seen; points that are alike go only at the end, or where there are very many."""

    def __init__(self, log: Array, n_genes: int):
        self.log = log  # axes that are compared by ratio
        self.values = np.empty((0, len(log)))
        self.vectors = np.empty((0, n_genes), int)

    def __len__(self) -> int:
        return len(self.values)

    def add(self, vectors: Array, values: Array) -> bool:
        """Merge feasible points; whether anything changed."""
        fresh = np.nonzero(nondominated(values))[0]
        if len(fresh) == 0:
            return False
        every = np.concatenate([self.values, values[fresh]])
        keep = np.nonzero(nondominated(every))[0]
        tolerance = FINEST_REL
        while len(keep) > MOST_POINTS and tolerance < NEAR:
            keep = keep[unlike_rows(every[keep], self.log, tolerance)]
            tolerance *= 3.0
        changed = len(keep) != len(self.values) or bool((keep >= len(self.values)).any())
        if changed:
            self.vectors = np.concatenate([self.vectors, vectors[fresh]])[keep]
            self.values = every[keep]
        return changed

    def thinned(self) -> tuple[Array, Array]:
        """Vectors and values without those that are alike, sorted by the columns."""
        keep = unlike_rows(self.values, self.log)
        return self.vectors[keep], self.values[keep]
