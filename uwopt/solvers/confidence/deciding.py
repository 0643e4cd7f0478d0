"""What decides whether hardware holds: the uncertain number on which it depends most, and what it is worth to know one.

Scenarios are sorted by a number; where its low third holds far more often than its high third, or the other way round,
to know that number is to know whether the hardware will do.

What it would be worth to know a number before buying: scenarios are sorted into bins by the number. With it known, the
best hardware of each bin would be bought: the expected value of partial perfect information (Strong and Oakley 2013,
Med. Decis. Making 33:755) is by how much the mean of the bins' medians falls. Hardware is chosen on half of the
scenarios and judged on the other, so that luck is worth nothing in the mean; told is a number that is worth more than
whenever it is shuffled over the scenarios, many times.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwopt.arrays import Array
from uwopt.catalog.parts.doubts import doubtful
from uwopt.catalog.records import Housing, Part, Port
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.results.certainty import Decides
from uwopt.solvers.confidence.counted import Counted
from uwopt.solvers.confidence.draws import probabilities
from uwopt.solvers.confidence.scenarios import BEAM_FACTS, PORTS, Scenarios
from uwopt.solvers.confidence.search import Certain
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.one_hardware import matters, pieces_by_kind

PART = 3  # of the scenarios, sorted by a number: its first and its last such share are set against each other
LEAST = 0.2  # by which these shares differ at least, to be told
MOST_TOLD = 2  # numbers
OF_LUCK = 20  # times as many numbers that mean nothing: what tells no more than the most telling of them is not told


def decided_by(problem: Problem, objective: Objective, seen: Counted, scenarios: Scenarios) -> list[Decides]:
    """The numbers on which it depends most whether hardware holds, the first most; none where luck does as well.

    Of forty numbers one looks telling by luck alone, so that they are held against twenty times as many that mean
    nothing: in one of 21 answers whose numbers all mean nothing one of them is told all the same.
    """
    held = np.isfinite(seen.outcomes.value[seen.stop])
    if held.all() or not held.any():
        return []
    numbers = list(numbers_of(problem, objective, scenarios, seen.found))
    luck = np.random.default_rng(scenarios.seed).random((OF_LUCK * len(numbers), len(held)))
    least = np.abs(np.subtract(*thirds(held, np.argsort(luck, axis=1)))).max(initial=LEAST)
    every = [Decides(what, part, *shares(held, number)) for what, part, number in numbers]
    told = [one for one in every if apart(one) > least]
    return sorted(told, key=apart, reverse=True)[:MOST_TOLD]


def apart(one: Decides) -> float:
    """How far the shares at both sides of a number differ."""
    return abs(one.held_high - one.held_low)


def shares(held: NDArray[np.bool_], number: Array) -> tuple[float, float]:
    """Share that holds where a number is low, and where it is high; of two values, by value."""
    values = np.unique(number)
    if len(values) == 2:
        return tuple(float(held[number == value].mean()) for value in values)  # pyrefly: ignore[bad-return]
    low, high = thirds(held, np.argsort(number, kind="stable"))
    return float(low), float(high)


def thirds(held: NDArray[np.bool_], order: NDArray[np.int64]) -> tuple[Array, Array]:
    """The same of the first third and the last of scenarios in order, (..., n_scenarios)."""
    count = max(order.shape[-1] // PART, 1)
    return held[order[..., :count]].mean(axis=-1), held[order[..., -count:]].mean(axis=-1)


# ---------------------------------------------------------------- what a number is worth


BINS = 3
LEAST_REL = 0.005  # of the median: what is worth less is not told
SHUFFLED = 100  # times, of a number over the scenarios: what is worth no more than once so is luck, and not told either


@dataclass(frozen=True)
class Worth:
    """One uncertain number and what it is worth to know, in the minimised objective."""

    what: str
    part: str
    worth: float


def worth_of_knowing(problem: Problem, objective: Objective, certain: Certain) -> list[Worth]:
    """Uncertain numbers of the best hardware and of the water, those worth most first."""
    values = np.array([one.outcomes.value[one.stop] for one in certain.tried])
    best = next(k for k, one in enumerate(certain.tried) if one.outcomes is certain.best.outcomes)
    plain = float(np.median(values[best]))
    if len(values) < 2 or not np.isfinite(plain):
        return []

    def worth_of(number: Array) -> float:
        return 0.5 * sum(gained(values, best, number, certain.asked, chosen=half) for half in (0, 1))

    of_best = problem, objective, certain.scenarios, certain.best.found
    told = [(what, part, number, worth_of(number)) for what, part, number in numbers_of(*of_best)]
    found = [
        Worth(what, part, worth) for what, part, number, worth in told
        if worth > LEAST_REL * abs(plain) and is_no_luck(worth_of, number, certain.scenarios.seed)
    ]  # fmt: skip
    return sorted(found, key=lambda one: -one.worth)


def is_no_luck(worth_of: Callable[[Array], float], number: Array, seed: int) -> bool:
    """Whether a number is worth more than whenever it is shuffled over the scenarios: at most one in 101 is by chance.

    A permutation test; Phipson and Smyth 2010, Stat. Appl. Genet. Mol. Biol. 9:39, for the share.
    """
    rng, worth = np.random.default_rng(seed), worth_of(number)
    return all(worth_of(rng.permutation(number)) < worth for _ in range(SHUFFLED))


def gained(values: Array, best: int, number: Array, share: float, *, chosen: int) -> float:
    """By how much the mean of the bins' medians falls; hardware is chosen on every other scenario of a bin."""
    order, saved = np.argsort(number, kind="stable"), 0.0
    for rows in np.array_split(order, BINS):
        ours, theirs = rows[chosen::2], rows[1 - chosen :: 2]
        held = np.isfinite(values[:, ours]).mean(axis=1)
        medians = np.where(held >= min(share, held[best]), middle(values[:, ours]), np.inf)
        pick = int(np.argmin(medians)) if np.isfinite(medians).any() else best
        before, after = middle(values[best : best + 1, theirs])[0], middle(values[pick : pick + 1, theirs])[0]
        if np.isfinite(before) and np.isfinite(after):
            saved += (before - after) / BINS
    return saved


def middle(values: Array) -> Array:
    """Lower median of each row: one of its values, inf where most are."""
    return np.asarray(np.sort(values, axis=1)[:, (values.shape[1] - 1) // 2])


def numbers_of(
    problem: Problem, objective: Objective, scenarios: Scenarios, found: Found
) -> Iterator[tuple[str, str, Array]]:
    """Each uncertain number as it is in every scenario: name, part, a number that grows with it."""
    states = scenarios.states
    for name, text in (
        ("clarity", "clarity of the water"), ("lamp_leg", "K of the lamps' way"), ("floor", "reflectance of the floor"),
        ("other_table", "which table of the Jerlov types holds"), ("beyond", "altitude beyond its band"),
    ):  # fmt: skip
        column = np.array([float(getattr(state, name)) for state in states])
        if np.ptp(column) > 0.0:
            yield text, "", column
    if np.ptp(scenarios.focus) > 0.0:
        yield "distance at which the lens stands", "", np.abs(scenarios.focus - 1.0)
    if not scenarios.doubt.parts:
        return
    for kind, part in pieces_by_kind(problem, found).items():
        for name in (name for name, _ in doubtful(part) if matters(name, problem, objective)):
            yield f"{kind}.{name}", part.id, drawn(scenarios, part, name)


def drawn(scenarios: Scenarios, part: Part, name: str) -> Array:
    """The probability at which a number of a part is drawn in each scenario."""
    if isinstance(part, (Port, Housing)):
        return probabilities(scenarios.seed, f"{part.id} {name}", PORTS)[scenarios.port]
    if name in BEAM_FACTS:
        return scenarios.beam_probability(part, name)
    return probabilities(scenarios.seed, f"{part.id} {name}", scenarios.count)
