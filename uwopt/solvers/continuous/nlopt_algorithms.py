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
from typing import Any, Literal

import nlopt
import numpy as np

from uwopt.solvers.continuous.optimality import Array, Attempt, derivatives, fitted_multipliers, kkt_residual
from uwopt.solvers.continuous.program import Program
from uwopt.solvers.continuous.reduced import Reduced

Algorithm = Literal["slsqp", "cobyla", "global", "mma", "ccsaq", "lbfgs", "isres", "ags", "direct_l", "mlsl"]

RULE_TOLERANCE = 1e-9  # in logarithms
HUGE = 1e6  # stands in for a value that is no number
SEED = 20200913
EVALUATIONS = {"slsqp": 300, "cobyla": 1500}
EVALUATIONS_PER_UNKNOWN = 200  # of ISRES
COBYLA_STEPS = (None, 0.1, 0.01, 0.001)  # first steps of its rounds, in logarithms; None: NLopt's own choice
SETTLED = 1e-8  # a residual that needs no further round
CODES = {"slsqp": nlopt.LD_SLSQP, "cobyla": nlopt.LN_COBYLA, "isres": nlopt.GN_ISRES}


@dataclass(frozen=True)
class Alone:
    """How one algorithm is run that is given a reduced program."""

    code: int
    gradients: bool
    most: int  # evaluations, for each unknown
    within: bool = False  # an augmented Lagrangian, which turns rules into penalties
    starts: bool = False  # it starts L-BFGS from many points


#: Local ones may stop by themselves long before; global ones mostly do not.
ALONE = {
    "mma": Alone(nlopt.LD_MMA, True, 200),
    "ccsaq": Alone(nlopt.LD_CCSAQ, True, 200),
    "lbfgs": Alone(nlopt.LD_LBFGS, True, 400, within=True),
    "isres": Alone(nlopt.GN_ISRES, False, 600),
    "ags": Alone(nlopt.GN_AGS, False, 600),
    "direct_l": Alone(nlopt.GN_ORIG_DIRECT_L, False, 150),
    "mlsl": Alone(nlopt.G_MLSL_LDS, True, 400, within=True, starts=True),
}
SUBSIDIARY = 50  # evaluations for each unknown within one round of an augmented Lagrangian
SUBSIDIARY_REL = 1e-8  # change of unknowns and objective at which such a round ends


class Evaluations:
    """A program's values for NLopt's callbacks, computed once a point."""

    def __init__(self, program: Program | Reduced):
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
            self.inequalities = np.array(rules.inequalities, float)
            self.equalities = np.array(rules.equalities, float)

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
    program: Program, start: Array, *, algorithm: Algorithm = "slsqp", max_seconds: float | None = None
) -> Attempt:
    """One run from a start; multipliers are those that fit best, and the residual says how well."""
    if len(start) == 0:
        x, count, message = start, 0, "nothing is left open"
    elif algorithm == "global":
        half = None if max_seconds is None else 0.5 * max_seconds
        near, first, found = run("isres", program, start, half)
        x, count, message = run("slsqp", program, near, half)
        count, message = first + count, f"{found}, then {message}"
    elif algorithm == "cobyla":
        return in_rounds(program, start, max_seconds)
    elif algorithm in ALONE:
        x, count, message = run_alone(algorithm, program, start, max_seconds)
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
        x, count, message = run("cobyla", program, x, share, first_step)
        total += count
        found = assessed(program, x, total, message)
        if found.kkt_residual <= SETTLED:
            break
    return found


def run(
    name: str, program: Program, start: Array, max_seconds: float | None, first_step: float | None = None
) -> tuple[Array, int, str]:
    """One NLopt algorithm: where it ends, evaluations, what it says."""
    n = len(start)
    evaluations = Evaluations(program)
    low, high = program.bounds
    inequalities, equalities = program.rule_names()
    solver: Any = nlopt.opt(CODES[name], n)
    solver.set_lower_bounds(low)
    solver.set_upper_bounds(high)
    solver.set_min_objective(evaluations.minimised)
    if inequalities:
        solver.add_inequality_mconstraint(evaluations.rules(0), np.full(len(inequalities), RULE_TOLERANCE))
    if equalities:
        solver.add_equality_mconstraint(evaluations.rules(1), np.full(len(equalities), RULE_TOLERANCE))
    solver.set_maxeval(EVALUATIONS.get(name, EVALUATIONS_PER_UNKNOWN * n))
    if name != "isres":
        solver.set_xtol_abs(1e-11)
        solver.set_ftol_abs(1e-13)
    else:
        nlopt.srand(SEED)
    if first_step is not None:
        solver.set_initial_step(np.minimum(first_step, 0.25 * (high - low)))
    if max_seconds is not None:
        solver.set_maxtime(max(max_seconds, 1e-3))
    return ended(name, solver, evaluations, start)


def run_alone(name: str, program: Program, start: Array, max_seconds: float | None) -> tuple[Array, int, str]:
    """One algorithm on the program without equalities: where it ends as the program's point, evaluations, word."""
    how = ALONE[name]
    reduced = Reduced(program, worst_scene=how.gradients)
    n = len(reduced.names)
    if n == 0:
        return reduced.full(np.empty(0)), 0, f"NLopt {name}: nothing is left open"
    evaluations = Evaluations(reduced)
    low, high = reduced.bounds
    inequalities, _ = reduced.rule_names()
    solver: Any = nlopt.opt(nlopt.AUGLAG if how.within else how.code, n)
    if how.within:
        solver.set_local_optimizer(subsidiary(how, low, high))
    solver.set_lower_bounds(low)
    solver.set_upper_bounds(high)
    solver.set_min_objective(evaluations.minimised)
    if inequalities and how.gradients:
        solver.add_inequality_mconstraint(evaluations.rules(0), np.full(len(inequalities), RULE_TOLERANCE))
    elif inequalities:  # one by one: the original DIRECT and AGS know no vectors of rules
        solver.add_inequality_constraint(evaluations.worst_rule, RULE_TOLERANCE)
    solver.set_maxeval(how.most * n)
    if how.gradients:
        solver.set_xtol_abs(1e-11)
        solver.set_ftol_abs(1e-13)
    nlopt.srand(SEED)
    if max_seconds is not None:
        solver.set_maxtime(max(max_seconds, 1e-3))
    begin = np.clip(reduced.start(start), low, high)
    x, count, message = ended(name, solver, evaluations, begin)
    return reduced.full(x), max(count, evaluations.count), message


def subsidiary(how: Alone, low: Array, high: Array) -> Any:
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
