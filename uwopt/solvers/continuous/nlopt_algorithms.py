"""NLopt: other algorithms than IPOPT's, with derivatives by complex step or without any.

The only module that imports nlopt. What NLopt's page of algorithms says of each, and how it is run here:

slsqp     sequential quadratic programming; takes equalities and inequalities; gradients
mma       method of moving asymptotes; inequalities, no equalities; gradients
ccsaq     its sister with quadratic models; inequalities, no equalities; gradients
lbfgs     quasi-Newton; takes no rules but bounds, so within an augmented Lagrangian; gradients
cobyla    linear models of objective and rules; takes both; no gradients; in rounds of smaller first steps
isres     evolution strategy; takes both; global; no gradients
ags       space-filling curve; inequalities, at most 10 of them, and at most 10 unknowns (5 are advised); global
direct_l  dividing rectangles, the original code, which takes inequalities; global; no gradients
mlsl      L-BFGS from a low-discrepancy sequence of starts; takes bounds only, so within an augmented
          Lagrangian; global
global    ISRES, then SLSQP from its best point: of the global ones ISRES takes rules as they are and closes
          in slowly, hence the polish

Those that take no equalities are given a program without them (`reduced`); those without gradients one
without the worst scene's unknowns. All work in logarithms, within bounds.
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
from uwopt.solvers.continuous.reduced import Reduced

RULE_TOLERANCE = 1e-9  # in logarithms
HUGE = 1e6  # stands in for a value that is no number
SEED = 20200913
COBYLA_STEPS = (None, 0.1, 0.01, 0.001)  # first steps of its rounds, in logarithms; None: NLopt's own choice
SETTLED = 1e-8  # a residual that needs no further round


@dataclass(frozen=True)
class Way:
    """How one algorithm is run."""

    code: int
    most: int  # evaluations, for each unknown
    most_in_all: int = 0  # in place of them; 0: none
    gradients: bool = True
    settles: bool = True  # it ends where unknowns or objective settle
    reduced: bool = True  # given the program without equalities
    within: bool = False  # an augmented Lagrangian, which turns rules into penalties
    starts: bool = False  # it starts L-BFGS from many points


FAR = dict(gradients=False, settles=False)  # of global ones, which mostly do not stop by themselves
WAYS = {
    "slsqp": Way(nlopt.LD_SLSQP, 0, 300, reduced=False),
    "cobyla": Way(nlopt.LN_COBYLA, 0, 1500, gradients=False, reduced=False),
    "mma": Way(nlopt.LD_MMA, 200),
    "ccsaq": Way(nlopt.LD_CCSAQ, 200),
    "lbfgs": Way(nlopt.LD_LBFGS, 400, within=True),
    "isres": Way(nlopt.GN_ISRES, 600, **FAR),
    "ags": Way(nlopt.GN_AGS, 600, **FAR),
    "direct_l": Way(nlopt.GN_ORIG_DIRECT_L, 150, **FAR),
    "mlsl": Way(nlopt.G_MLSL_LDS, 400, within=True, starts=True),
}
NEAR = Way(nlopt.GN_ISRES, 200, reduced=False, **FAR)  # ISRES where SLSQP goes on
SUBSIDIARY = 50  # evaluations for each unknown within one round of an augmented Lagrangian
SUBSIDIARY_REL = 1e-8  # change of unknowns and objective at which such a round ends


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

    def worst_rule(self, x: Array, gradient: Array) -> float:
        """NLopt's view of the only inequality, for algorithms without gradients."""
        self.at(x, False)
        return float(finite(self.inequalities)[0])

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


def solve(
    program: Program, start: Array, *, algorithm: str, max_seconds: float | None = None
) -> Attempt:
    """One run from a start; multipliers are those that fit best, and the residual says how well."""
    if len(start) == 0:
        x, count, message = start, 0, "nothing is left open"
    elif algorithm == "global":
        half = None if max_seconds is None else 0.5 * max_seconds
        near, first, found = run("isres", program, start, half, how=NEAR)
        x, count, message = run("slsqp", program, near, half)
        count, message = first + count, f"{found}, then {message}"
    elif algorithm == "cobyla":
        return in_rounds(program, start, max_seconds)
    else:
        x, count, message = run(algorithm, program, start, max_seconds)
    return assessed(program, x, count, message)


def assessed(program: Program, x: Array, count: int, message: str) -> Attempt:
    """A run's end with its epigraph variables drawn tight, and how well multipliers fit there."""
    x = program.complete(x)
    at = derivatives(program, x)
    multipliers = fitted_multipliers(at)
    return Attempt(x, count, message, multipliers, kkt_residual(at, multipliers))


def in_rounds(program: Program, start: Array, max_seconds: float | None) -> Attempt:
    """COBYLA from where it ended, with smaller first steps, until the conditions of an optimum hold.

    Its trust region only shrinks: where the objective is curved, or directions are free, it shrinks too soon.
    """
    share = None if max_seconds is None else max_seconds / len(COBYLA_STEPS)
    x, total = start, 0
    for first_step in COBYLA_STEPS:
        x, count, message = run("cobyla", program, x, share, first_step=first_step)
        total += count
        found = assessed(program, x, total, message)
        if found.kkt_residual <= SETTLED:
            break
    return found


def run(
    name: str, program: Program, start: Array, max_seconds: float | None, *, how: Way | None = None,
    first_step: float | None = None,
) -> tuple[Array, int, str]:  # fmt: skip
    """One NLopt algorithm: where it ends as the program's point, evaluations, what it says."""
    how = how or WAYS[name]
    asked = Reduced(program, worst_scene=how.gradients) if how.reduced else program
    n = len(asked.names)
    if n == 0 and isinstance(asked, Reduced):
        return asked.full(np.empty(0)), 0, f"NLopt {name}: nothing is left open"
    evaluations = Evaluations(asked)
    low, high = asked.bounds
    solver: Any = nlopt.opt(nlopt.AUGLAG if how.within else how.code, n)
    if how.within:
        solver.set_local_optimizer(subsidiary(how, low, high))
    solver.set_lower_bounds(low)
    solver.set_upper_bounds(high)
    solver.set_min_objective(evaluations.minimised)
    for which, names in enumerate(names_of_rules(asked)):
        if not names:
            continue
        tolerances = np.full(len(names), RULE_TOLERANCE)
        if which:
            solver.add_equality_mconstraint(evaluations.rules(which), tolerances)
        elif how.gradients or not how.reduced:
            solver.add_inequality_mconstraint(evaluations.rules(which), tolerances)
        else:  # one alone: the original DIRECT and AGS know no vectors of rules
            solver.add_inequality_constraint(evaluations.worst_rule, RULE_TOLERANCE)
    solver.set_maxeval(how.most_in_all or how.most * n)
    if how.settles:
        solver.set_xtol_abs(1e-11)
        solver.set_ftol_abs(1e-13)
    nlopt.srand(SEED)
    if first_step is not None:
        solver.set_initial_step(np.minimum(first_step, 0.25 * (high - low)))
    if max_seconds is not None:
        solver.set_maxtime(max(max_seconds, 1e-3))
    if not isinstance(asked, Reduced):
        return ended(name, solver, evaluations, start)
    x, count, message = ended(name, solver, evaluations, asked.start(start))
    return asked.full(x), max(count, evaluations.count), message


def subsidiary(how: Way, low: Array, high: Array) -> Any:
    """What an augmented Lagrangian calls within its bounds, round by round."""
    n = len(low)
    inner: Any = nlopt.opt(how.code, n)
    inner.set_lower_bounds(low)
    inner.set_upper_bounds(high)
    inner.set_xtol_rel(SUBSIDIARY_REL)
    inner.set_ftol_rel(SUBSIDIARY_REL)
    inner.set_maxeval(SUBSIDIARY * n)
    if how.starts:
        local: Any = nlopt.opt(nlopt.LD_LBFGS, n)
        local.set_xtol_rel(SUBSIDIARY_REL)
        local.set_ftol_rel(SUBSIDIARY_REL)
        inner.set_local_optimizer(local)
    return inner


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
