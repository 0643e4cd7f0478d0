"""NLopt: other algorithms than IPOPT's, with derivatives by complex step or without any.

Beside `bench.nlopt_peers` the only module that imports nlopt. What NLopt's page of algorithms says of each, and how it
is run here:

slsqp     sequential quadratic programming; takes equalities and inequalities; gradients
cobyla    linear models of objective and rules; takes both; no gradients; in rounds of smaller first steps
global    ISRES, an evolution strategy that takes both and closes in slowly, then SLSQP from its best point

All work in logarithms, within bounds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import nlopt
import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.continuous.optimality import Attempt, derivatives, fitted_multipliers, kkt_residual
from uwopt.solvers.continuous.program import Program, Smooth, names_of_rules

RULE_TOLERANCE = 1e-9  # in logarithms
HUGE = 1e6  # stands in for a value that is no number
SEED = 20200913
COBYLA_STEPS = (None, 0.1, 0.01, 0.001)  # first steps of its rounds, in logarithms; None: NLopt's own choice
SETTLED = 1e-8  # a residual that needs no further round


class Evaluations:
    """A program's values for NLopt's callbacks, computed once a point."""

    def __init__(self, program: Smooth):
        self.program = program
        self.n = len(program.names)
        self.count = 0
        self.last_x = np.full(self.n, np.nan)
        self.with_gradient = False
        self.objective, self.gradient = 0.0, np.zeros(self.n)
        self.inequalities, self.equalities = np.empty(0), np.empty(0)
        self.jacobians = (np.empty((0, self.n)), np.empty((0, self.n)))

    def at(self, x: Array, gradient: bool) -> None:
        """Evaluate, unless this point is the last one."""
        if np.array_equal(x, self.last_x) and (self.with_gradient or not gradient):
            return
        self.last_x, self.with_gradient = np.array(x), gradient
        self.count += 1
        if gradient:
            found = derivatives(self.program, self.last_x)
            first = len(found.values) - found.n_equalities
            cut = first - 2 * self.n
            self.objective, self.gradient = found.objective, found.gradient
            self.inequalities, self.equalities = found.values[:cut], found.values[first:]
            self.jacobians = (found.jacobian[:cut], found.jacobian[first:])
        else:
            rules = self.program.rules([float(v) for v in self.last_x])
            self.objective = float(rules.objective)
            self.inequalities, self.equalities = (
                np.array([*some.values()], float) for some in (rules.inequalities, rules.equalities)
            )

    def minimised(self, x: Array, gradient: Array) -> float:
        """NLopt's view of the objective."""
        self.at(x, gradient.size > 0)
        if gradient.size:
            gradient[:] = finite(self.gradient)
        return float(finite(np.array([self.objective]))[0])

    def rules(self, which: int) -> Callable[[Array, Array, Array], None]:
        """NLopt's view of the inequalities (0) or the equalities (1)."""

        def values(result: Array, x: Array, gradient: Array) -> None:
            self.at(x, gradient.size > 0)
            result[:] = finite((self.inequalities, self.equalities)[which])
            if gradient.size:
                gradient[:] = finite(self.jacobians[which])

        return values


def finite(values: Array) -> Array:
    """Values a solver can work with; nearly all are, and asking is ten times quicker than mending."""
    if np.isfinite(values).all():
        return values
    return np.nan_to_num(values, nan=HUGE, posinf=HUGE, neginf=-HUGE)


@dataclass(frozen=True)
class Way:
    """How one algorithm is run."""

    name: str
    code: int
    most: int  # evaluations, for each unknown
    most_in_all: int = 0  # in place of them; 0: none
    gradients: bool = True
    settles: bool = True  # it ends where unknowns or objective settle

    def run(
        self, program: Program, start: Array, max_seconds: float, *, first_step: float | None = None
    ) -> tuple[Array, int, str]:
        """Where it ends, evaluations, what it says."""
        return self.optimised(Evaluations(program), start, max_seconds, first_step)

    def solver(self, low: Array, high: Array) -> Any:
        """NLopt's, for unknowns between these."""
        return nlopt.opt(self.code, len(low))

    def hold(self, solver: Any, evaluations: Evaluations) -> None:
        """Give the solver the program's rules."""
        inequalities, equalities = (np.full(len(n), RULE_TOLERANCE) for n in names_of_rules(evaluations.program))
        if len(inequalities):
            solver.add_inequality_mconstraint(evaluations.rules(0), inequalities)
        if len(equalities):
            solver.add_equality_mconstraint(evaluations.rules(1), equalities)

    def optimised(
        self, evaluations: Evaluations, start: Array, max_seconds: float, first_step: float | None
    ) -> tuple[Array, int, str]:
        """One run on a program as it is."""
        low, high = evaluations.program.bounds
        solver = self.solver(low, high)
        solver.set_lower_bounds(low)
        solver.set_upper_bounds(high)
        solver.set_min_objective(evaluations.minimised)
        self.hold(solver, evaluations)
        solver.set_maxeval(self.most_in_all or self.most * len(low))
        if self.settles:
            solver.set_xtol_abs(1e-11)
            solver.set_ftol_abs(1e-13)
        nlopt.srand(SEED)
        if first_step is not None:
            solver.set_initial_step(np.minimum(first_step, 0.25 * (high - low)))
        if np.isfinite(max_seconds):
            solver.set_maxtime(max(max_seconds, 1e-3))
        return ended(self.name, solver, evaluations, start)


WAYS = {
    "slsqp": Way("slsqp", nlopt.LD_SLSQP, 0, 300),
    "cobyla": Way("cobyla", nlopt.LN_COBYLA, 0, 1500, gradients=False),
}
NEAR = Way("isres", nlopt.GN_ISRES, 200, gradients=False, settles=False)  # which SLSQP goes on from


def solve_by_nlopt(
    program: Program, start: Array, *, algorithm: str | Way, max_seconds: float = np.inf
) -> Attempt:
    """One run from a start; multipliers are those that fit best, and the residual says how well."""
    if len(start) == 0:
        x, count, message = start, 0, "nothing is left open"
    elif algorithm == "global":
        near, first, found = NEAR.run(program, start, 0.5 * max_seconds)
        x, count, message = WAYS["slsqp"].run(program, near, 0.5 * max_seconds)
        count, message = first + count, f"{found}, then {message}"
    elif algorithm == "cobyla":
        return in_rounds(program, start, max_seconds)
    else:
        way = WAYS[algorithm] if isinstance(algorithm, str) else algorithm
        x, count, message = way.run(program, start, max_seconds)
    return assessed(program, x, count, message)


def assessed(program: Program, x: Array, count: int, message: str) -> Attempt:
    """A run's end with its epigraph variables drawn tight, and how well multipliers fit there."""
    x = program.complete(x)
    at = derivatives(program, x)
    multipliers = fitted_multipliers(at)
    return Attempt(x, count, message, multipliers, kkt_residual(at, multipliers))


def in_rounds(program: Program, start: Array, max_seconds: float) -> Attempt:
    """COBYLA from where it ended, with smaller first steps, until the conditions of an optimum hold.

    Its trust region only shrinks: where the objective is curved, or directions are free, it shrinks too soon.
    """
    x, total = start, 0
    for first_step in COBYLA_STEPS:
        x, count, message = WAYS["cobyla"].run(program, x, max_seconds / len(COBYLA_STEPS), first_step=first_step)
        total += count
        found = assessed(program, x, total, message)
        if found.kkt_residual <= SETTLED:
            break
    return found


def ended(name: str, solver: Any, evaluations: Evaluations, start: Array) -> tuple[Array, int, str]:
    """A run to its end: the point, evaluations, and what the algorithm says."""
    low, high = evaluations.program.bounds
    try:
        x = solver.optimize(np.clip(start, low, high))
    except (nlopt.RoundoffLimited, nlopt.runtime_error, RuntimeError, ValueError, MemoryError) as fault:
        x = evaluations.last_x
        message = f"NLopt {name}: {type(fault).__name__}"
    else:
        code = solver.last_optimize_result()
        message = f"NLopt {name}: {RESULTS.get(code, f'code {code}')}"
    if not np.all(np.isfinite(x)):
        x = start
    return np.clip(np.asarray(x, float), low, high), solver.get_numevals(), message


RESULTS = {
    nlopt.SUCCESS: "success",
    nlopt.STOPVAL_REACHED: "value reached",
    nlopt.FTOL_REACHED: "objective settled",
    nlopt.XTOL_REACHED: "unknowns settled",
    nlopt.MAXEVAL_REACHED: "evaluations used up",
    nlopt.MAXTIME_REACHED: "time used up",
}
