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

Those that take no equalities are given a program without them (`Reduced`); those without gradients one
without the worst scene's unknowns. All work in logarithms, within bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import nlopt
import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.continuous.optimality import Attempt, derivatives, fitted_multipliers, kkt_residual
from uwopt.solvers.continuous.pieces import SmoothSettings, Symbolic
from uwopt.solvers.continuous.program import Program, Rules, Smooth, names_of_rules

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
    program: Program, start: Array, *, algorithm: str, max_seconds: float = np.inf
) -> Attempt:
    """One run from a start; multipliers are those that fit best, and the residual says how well."""
    if len(start) == 0:
        x, count, message = start, 0, "nothing is left open"
    elif algorithm == "global":
        near, first, found = run("isres", program, start, 0.5 * max_seconds, how=NEAR)
        x, count, message = run("slsqp", program, near, 0.5 * max_seconds)
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


def in_rounds(program: Program, start: Array, max_seconds: float) -> Attempt:
    """COBYLA from where it ended, with smaller first steps, until the conditions of an optimum hold.

    Its trust region only shrinks: where the objective is curved, or directions are free, it shrinks too soon.
    """
    x, total = start, 0
    for first_step in COBYLA_STEPS:
        x, count, message = run("cobyla", program, x, max_seconds / len(COBYLA_STEPS), first_step=first_step)
        total += count
        found = assessed(program, x, total, message)
        if found.kkt_residual <= SETTLED:
            break
    return found


def run(
    name: str, program: Program, start: Array, max_seconds: float, *, how: Way | None = None,
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
    if np.isfinite(max_seconds):
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


# ---------------------------------------------------------------- in fewer unknowns


APART = 1e-8  # in logarithms: half the width of the gap that stands for an equality
WORST = ("power", "snr", "violation")


class Reduced:
    """A program whose equalities are gone, and the unknowns with them that they determine; as `program.Smooth`.

    A wanted mean level is an equality in every scene. It is solved for the gain, or for the light level where
    no gain can be turned: in logarithms both stand alone in it. Where neither is free the equality becomes a
    pair of inequalities, a little apart. Without derivatives the worst scene's power and SNR need no unknown
    of their own either: they are worked out from the others.

    Parameters
    ----------
    program : any
    worst_scene : whether power, SNR or violation of the worst scene stay unknowns; if not, values at a
        point are numbers only, without derivatives, and all rules are drawn together into the worst of them
    """

    def __init__(self, program: Program, *, worst_scene: bool):
        self.program, self.worst_scene = program, worst_scene
        _, equalities = names_of_rules(program)
        self.solved: dict[int, str] = {}  # scene: the unknown that its mean level determines
        for name in equalities:
            scene = scene_of(name)
            free = [f"{key}[{scene}]" for key in ("gain", "level") if f"{key}[{scene}]" in program.names]
            if free:
                self.solved[scene] = free[0]
        self.paired = [name for name in equalities if scene_of(name) not in self.solved]
        gone = set(self.solved.values()) | (set() if worst_scene else set(WORST))
        self.kept = [i for i, name in enumerate(program.names) if name not in gone]
        self.names = tuple(program.names[i] for i in self.kept)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest of each unknown that is left."""
        low, high = self.program.bounds
        return low[self.kept], high[self.kept]

    def start(self, x: Array) -> Array:
        """The unknowns that are left of a point of the program."""
        return np.asarray(x)[self.kept]

    def full(self, x: Array) -> Array:
        """The program's point, within its bounds, its worst scene's figures drawn tight."""
        point = np.array(self._expanded([float(v) for v in x]), float)
        return self.program.complete(np.nan_to_num(point))

    def _expanded(self, x: Sequence[Symbolic]) -> list[Symbolic]:
        """All unknowns of the program from those that are left."""
        program = self.program
        point: list[Symbolic] = [0.0] * len(program.names)
        for place, value in zip(self.kept, x, strict=True):
            point[place] = value
        for scene, name in self.solved.items():
            point[program.names.index(name)] = self._determined(scene, name, program.settings(point)[scene])
        return point

    def _determined(self, index: int, name: str, at: SmoothSettings) -> Symbolic:
        """The logarithm of gain or level that gives the wanted mean level, the other settings as they are."""
        scene = self.program.scenes[index]
        wanted, total_e = scene.wanted_dn or np.nan, scene.total_e[scene.nominal]
        if name.startswith("gain"):
            unit = SmoothSettings(at.f_number, at.time_s, at.level, 1.0, at.exposure_s)
            return np.log(wanted / scene.digital_dn(total_e, unit, offset_dn=0.0))
        full = SmoothSettings(at.f_number, at.time_s, 1.0, at.gain, at.exposure_s)
        needed_e = wanted / (scene.gain_dn_per_e * at.gain) - scene.dark_e(at)
        return np.log(needed_e / scene.electrons(total_e, full))

    def rules(self, x: Sequence[Symbolic]) -> Rules:
        """Objective and inequalities at a point; no equalities."""
        point = self._expanded(x)
        low, high = self.program.bounds
        sides: dict[str, Symbolic] = {}
        for name in self.solved.values():
            place = self.program.names.index(name)
            sides |= {f"{name} at least": low[place] - point[place], f"{name} at most": point[place] - high[place]}
        if not self.worst_scene:
            tight = self.program.complete(np.nan_to_num(np.array(point, float)))
            for place, name in enumerate(self.program.names):
                if name in WORST:
                    point[place] = float(tight[place])
        found = self.program.rules(point)
        for name in self.paired:
            value = found.equalities[name]
            sides |= {f"{name} above": value - APART, f"{name} below": -value - APART}
        inequalities = found.inequalities | sides
        if not self.worst_scene and inequalities:
            values = np.nan_to_num(np.array([*inequalities.values()], float), nan=np.inf)
            inequalities = {"worst": float(np.max(values))}
        return Rules(found.objective, inequalities, {})


def scene_of(rule: str) -> int:
    """The scene that the name of a rule tells: `mean_level[2]` is of the third."""
    return int(rule.partition("[")[2].partition("]")[0])
