"""CasADi and IPOPT: exact derivatives of the program's own formulas, an interior-point solver, multipliers.

Through CasADi also Bonmin, for hardware and settings together. The only module that imports casadi.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING, Any

import casadi
import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.continuous.optimality import Attempt, Derivatives, derivatives, kkt_residual
from uwopt.solvers.continuous.program import Smooth

if TYPE_CHECKING:
    from uwopt.solvers.continuous.mixed import Answer, MixedProgram

if hasattr(casadi.GlobalOptions, "setNumpyMode"):
    # From 3.8: NumPy's functions return symbols, without a warning.
    casadi.GlobalOptions.setNumpyMode(1)

SILENT = {
    "print_time": False,
    "show_eval_warnings": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",  # no banner
}
OPTIONS = {
    **SILENT,
    "ipopt.tol": 1e-11,
    "ipopt.constr_viol_tol": 1e-11,
    "ipopt.compl_inf_tol": 1e-11,
    "ipopt.dual_inf_tol": 1e-9,
    "ipopt.acceptable_tol": 1e-9,
    "ipopt.bound_relax_factor": 1e-9,  # rules that leave a single point need an interior
    "ipopt.honor_original_bounds": "yes",
    "ipopt.max_iter": 300,
}
#: B-BB, branch and bound with IPOPT at each node, is what its manual advises where functions may not be convex.
BONMIN = {
    "print_time": False,
    "show_eval_warnings": False,
    "bonmin.algorithm": "B-BB",
    "bonmin.tol": 1e-9,
    "bonmin.print_level": 0,
    "bonmin.sb": "yes",
    **{f"bonmin.{part}_log_level": 0 for part in ("bb", "nlp", "lp", "milp", "oa", "fp")},
}


class SymbolicProgram:
    """A program's formulas in CasADi symbols."""

    def __init__(self, program: Smooth):
        self.program = program
        self.x = casadi.SX.sym("x", len(program.names))
        rules = program.rules([self.x[i] for i in range(len(program.names))])
        self.objective = casadi.SX(rules.objective)
        self.n_inequalities = len(rules.inequalities)
        self.rules = casadi.vertcat(casadi.SX(0, 1), *rules.inequalities.values(), *rules.equalities.values())

    def solver(self, max_seconds: float) -> casadi.Function:
        """IPOPT for this program, silent."""
        options: dict[str, Any] = dict(OPTIONS)
        if np.isfinite(max_seconds):
            options["ipopt.max_wall_time"] = max(max_seconds, 1e-3)
        problem = {"x": self.x, "f": self.objective, "g": self.rules}
        return casadi.nlpsol("settings", "ipopt", problem, options)

    def derivatives(self, x: Array) -> Derivatives:
        """Values and gradients of objective, rules and bounds at a point, by automatic differentiation."""
        outputs = [
            self.objective,
            casadi.gradient(self.objective, self.x),
            self.rules,
            casadi.jacobian(self.rules, self.x),
        ]
        evaluated = casadi.Function("derivatives", [self.x], outputs)(x)
        objective, gradient, values, jacobian = (value.full() for value in evaluated)
        low, high = self.program.bounds
        n, cut = len(x), self.n_inequalities
        values = values.reshape(-1)
        return Derivatives(
            objective=float(objective[0, 0]),
            gradient=gradient.reshape(-1),
            values=np.concatenate([values[:cut], low - x, x - high, values[cut:]]),
            jacobian=np.concatenate([jacobian[:cut], -np.eye(n), np.eye(n), jacobian[cut:]]),
            n_equalities=len(values) - cut,
        )


def solve_by_ipopt(program: Smooth, start: Array, *, max_seconds: float = np.inf) -> Attempt:
    """One run of IPOPT from a start, with multipliers and the residual of the optimum's conditions.

    The residual is computed here, from CasADi's gradients and IPOPT's multipliers.
    """
    if len(start) == 0:
        at = derivatives(program, start)
        return Attempt(start, 0, "nothing is left open", np.zeros(len(at.values)), 0.0)
    symbolic = SymbolicProgram(program)
    low, high = program.bounds
    n_rules, cut = symbolic.rules.shape[0], symbolic.n_inequalities
    least = np.concatenate([np.full(cut, -np.inf), np.zeros(n_rules - cut)])
    solver = symbolic.solver(max_seconds)
    answer = solver(x0=start, lbx=low, ubx=high, lbg=least, ubg=np.zeros(n_rules))
    x = answer["x"].full().reshape(-1)
    of_rules, of_bounds = answer["lam_g"].full().reshape(-1), answer["lam_x"].full().reshape(-1)
    multipliers = np.concatenate(
        [of_rules[:cut], np.maximum(-of_bounds, 0.0), np.maximum(of_bounds, 0.0), of_rules[cut:]]
    )
    stats = solver.stats()
    return Attempt(
        x=x,
        iterations=int(stats.get("iter_count", 0)),
        message=f"IPOPT: {stats['return_status']}",
        multipliers=multipliers,
        kkt_residual=kkt_residual(symbolic.derivatives(x), multipliers),
    )


def solve_mixed(program: MixedProgram, *, max_seconds: float) -> Answer:
    """Hardware and settings by Bonmin, which is exact for convex programs only and else a heuristic."""
    from uwopt.solvers.continuous.mixed import Answer

    low, high = program.bounds
    n, n_binary = len(low), len(program.options)
    x = casadi.SX.sym("x", n)
    objective, rules, choices = program.formulas([x[i] for i in range(n)])
    problem: dict[str, Any] = {"x": x, "f": casadi.SX(objective), "g": casadi.vertcat(*rules, *choices)}
    options: dict[str, Any] = {
        **BONMIN,
        "bonmin.time_limit": max(max_seconds, 1e-2),
        "bonmin.max_cpu_time": max(max_seconds, 1e-2),  # of one relaxation, within which the other is not looked at
        "discrete": [False] * (n - n_binary) + [True] * n_binary,
    }
    least = np.concatenate([np.full(len(rules), -np.inf), np.zeros(len(choices))])
    with quiet():
        solver = casadi.nlpsol("mixed", "bonmin", problem, options)
        try:
            answer = solver(x0=program.start(), lbx=low, ubx=high, lbg=least, ubg=0.0)
        except RuntimeError as fault:  # CasADi raises when Bonmin finds no relaxation to begin with
            return Answer(program.start(), f"Bonmin: {str(fault).splitlines()[-1]}", 0, False)
    stats = solver.stats()
    return Answer(
        answer["x"].full().reshape(-1),
        f"Bonmin: {stats['return_status']}",
        int(stats.get("iter_count", 0)),
        bool(stats.get("success")),
    )


@contextmanager
def quiet() -> Iterator[None]:
    """Without what Bonmin prints of its relaxations, which no option turns off: CasADi hands it to `sys.stdout`.

    Libraries below may write to the process's output themselves, so that is turned away as well.
    """
    sys.stdout.flush()
    try:
        kept = os.dup(1)
    except OSError:  # there is no such output
        with redirect_stdout(io.StringIO()):
            yield
        return
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 1)
        with redirect_stdout(io.StringIO()):
            yield
    finally:
        os.dup2(kept, 1)
        os.close(nothing)
        os.close(kept)
