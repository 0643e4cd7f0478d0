"""One objective by pymoo's genetic algorithm, at the setting that pymoo's documentation gives for integers.

Beside `solvers.population.pymoo_front` the only module that imports pymoo; import it late. It shares nothing
with the fronts but the coding of designs, which is handed over.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pymoo.config import Config

Config.warnings["not_compiled"] = False  # a plain install has no compiled modules, and none are needed

from pymoo.algorithms.soo.nonconvex.ga import GA  # noqa: E402
from pymoo.core.problem import Problem  # noqa: E402
from pymoo.core.termination import NoTermination  # noqa: E402
from pymoo.operators.crossover.sbx import SBX  # noqa: E402
from pymoo.operators.mutation.pm import PM  # noqa: E402
from pymoo.operators.repair.rounding import RoundingRepair  # noqa: E402

from uwopt.arrays import Array  # noqa: E402

Evaluate = Callable[[Array], tuple[Array, Array]]
POP_SIZE = 100  # pymoo's default of this algorithm
ETA = 3.0  # of both operators, as its page on discrete variables has them
WORST = 1e30  # of infeasible vectors: they are told apart by their violation


class SingleVectors(Problem):
    """Integer vectors with one objective, all of a generation at once."""

    def __init__(self, evaluate: Evaluate, upper: Array):
        super().__init__(n_var=len(upper), n_obj=1, n_ieq_constr=1, xl=0, xu=upper, vtype=int)
        self.evaluate_vectors = evaluate

    def _evaluate(self, x: Array, out: dict[str, Array], *args: Any, **kwargs: Any) -> None:
        values, violation = self.evaluate_vectors(np.asarray(x, int))
        out["F"] = np.where(violation > 0.0, WORST, values)[:, None]
        out["G"] = violation[:, None]


def genetic(evaluate: Evaluate, upper: Array, first: Array, *, seed: int, over: Callable[[], bool]) -> None:
    """Breed until it is over; what is best is seen by `evaluate`.

    Parameters
    ----------
    evaluate : vectors (n, n_genes) -> values to minimise (n,) and violations (n,), 0 where feasible
    upper : the highest value of every gene; the lowest is 0
    first : the first population
    over : asked after every generation
    """
    repair = RoundingRepair()
    algorithm = GA(
        pop_size=len(first),
        sampling=first,
        crossover=SBX(prob=1.0, eta=ETA, vtype=float, repair=repair),
        mutation=PM(prob=1.0, eta=ETA, vtype=float, repair=repair),
        eliminate_duplicates=True,
    )
    algorithm.setup(SingleVectors(evaluate, upper), termination=NoTermination(), seed=seed, verbose=False)
    while not over() and algorithm.has_next():
        algorithm.next()


__all__ = ["POP_SIZE", "genetic"]
