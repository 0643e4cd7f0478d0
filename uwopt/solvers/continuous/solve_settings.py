"""Settings of given hardware from a continuous solver: a check of the closed form by other means.

A design's settings are cut into smooth pieces (`uwopt.solvers.continuous.pieces`), each choice of one piece a scene is
a convex program (`uwopt.solvers.continuous.program`), and each program goes to CasADi/IPOPT or NLopt. Scenes meet
only in the f-number and in the worst scene's figure, so the best of one scene alone bounds every choice
that holds it: choices are tried best bound first, until no bound beats the best found.

What a solver says is not taken over: rules are evaluated again in their own terms, and an optimum is
called one when, and only when, the conditions of an optimum hold at the point. Neither casadi nor nlopt
is imported before a method asks for it.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from uwopt.errors import SolverError
from uwopt.objectives.objective import Objective
from uwopt.solvers.continuous.optimality import Attempt, derivatives, optimality_gap, rule_names, violations
from uwopt.solvers.continuous.pieces import (
    Piece,
    SmoothDesign,
    SmoothSettings,
    smooth_pieces,
    worst_light_w,
    worst_scene_snr,
)
from uwopt.solvers.continuous.program import Goal, Program
from uwopt.tolerances import TIE
from uwopt.units import ratio_to_db

if TYPE_CHECKING:
    from uwopt.solvers.continuous.nlopt_algorithms import Way

Method = Literal["casadi", "slsqp", "cobyla", "global"]
Status = Literal["optimal", "feasible", "infeasible", "failed"]
FEASIBLE = 1e-6  # relative, of any rule
GAP = 1e-6  # of what is called optimal, in the program's objective: a logarithm of power or of SNR


@dataclass(frozen=True)
class Proof:
    """What a method must show before its point is called an optimum."""

    violation: float
    kkt_residual: float


USUAL = Proof(1e-6, 1e-5)
PROOF: dict[Method | Way, Proof] = {"casadi": Proof(1e-7, 1e-6), "cobyla": Proof(1e-6, 1e-4)}  # of others than `USUAL`


@dataclass(frozen=True)
class Task:
    """What all programs of one design share."""

    design: SmoothDesign
    objective: Objective
    power_limit_w: float
    method: Method | Way
    deadline: float

    @property
    def goal(self) -> Goal:
        """What remains of the objective: hardware fixes the rest, and least power breaks its ties."""
        if not self.objective.weight("snr_db"):
            return "power"
        return "sum" if self.objective.weight("power") else "snr"

    def program(self, pieces: Sequence[Piece], only: int | None = None) -> Program:
        """The smooth program of one choice of pieces; of one scene alone when asked."""
        scenes = self.design.scenes if only is None else (self.design.scenes[only],)
        return Program(
            scenes, tuple(pieces), self.design.motorised, self.goal, self.objective.weight("power"),
            self.objective.weight("snr_db"), self.power_limit_w - self.design.camera_power_w,
        )  # fmt: skip

    def value_per_unit(self, program: Program, x: Any) -> float:
        """Change of the minimised value per unit of the program's objective; watts when power is a tie."""
        if program.goal == "sum":
            return program.sum_unit
        if program.goal == "snr":
            return self.objective.weight("snr_db") * float(ratio_to_db(np.e))
        light_w = worst_light_w(program.scenes, program.set_points(x))
        return (self.objective.weight("power") or 1.0) * light_w

    @property
    def proof(self) -> Proof:
        """What its method must show."""
        return PROOF.get(self.method, USUAL)

    def seconds_left(self) -> float:
        """Until the deadline; inf where there is none."""
        return max(self.deadline - time.perf_counter(), 0.0)


@dataclass(frozen=True)
class Verdict:
    """What was found, and how far it can be trusted: rules and conditions of an optimum were checked.

    `multipliers`: by how much the minimised value grows when a rule is tightened, per relative amount
    (0.5 of min_snr[0]: asking for 1 % more SNR costs 0.005); only rules that bind.
    """

    status: Status
    message: str
    value: float = np.inf  # minimised
    merit: float = np.inf  # the program's own objective, which also tells ties in power apart
    light_power_w: float = np.inf  # of the worst scene
    settings: tuple[SmoothSettings, ...] = ()  # by scene
    max_violation: float | None = None
    kkt_residual: float | None = None
    multipliers: dict[str, float] = field(default_factory=dict)
    iterations: int = 0
    run_time_s: float = 0.0

    @property
    def objective_value(self) -> float | None:
        """The minimised value; None without settings."""
        return self.value if self.settings and np.isfinite(self.value) else None


def solve_settings(
    design: SmoothDesign,
    *,
    objective: Objective,
    power_limit_w: float,
    method: Method | Way,
    max_seconds: float = np.inf,
) -> Verdict:
    """Best settings of one design in all its scenes by one method.

    Parameters
    ----------
    design : in all its scenes
    objective : power, snr_db or a weighted sum; other terms are constants of the design
    power_limit_w : of camera and lights together; inf when there is none
    method : by name, or another algorithm of NLopt
    max_seconds : after which the best so far counts

    Returns
    -------
    Settings with status: optimal (rules met and conditions of an optimum shown), feasible (rules met),
    infeasible (shown that none are), failed (neither). Other settings may reach the same value: with SNR as
    the objective, time and level need not be those of least power.
    """
    if isinstance(method, str) and method not in get_args(Method):
        raise SolverError(f"method: {method!r} is not one of {', '.join(get_args(Method))}")
    if min(objective.weight("power"), objective.weight("snr_db")) < 0.0:
        raise SolverError("continuous solvers take no negative weight of power or snr_db")
    began = time.perf_counter()
    found = best_choice(Task(design, objective, power_limit_w, method, began + max_seconds))
    return replace(found, run_time_s=time.perf_counter() - began)


def best_choice(task: Task) -> Verdict:
    """The best of all choices of one piece a scene, best bound first."""
    options = [smooth_pieces(scene) for scene in task.design.scenes]
    for index, found in enumerate(options):
        if not found:
            return Verdict("infeasible", f"in scene {index + 1} all settings are too dark or too bright")
    alone, spent = bounds_of_scenes(task, options)
    choices = []
    for choice in itertools.product(*(range(len(found)) for found in options)):
        of_scenes = [alone[index][k] for index, k in enumerate(choice)] if alone else []
        if all(verdict.status != "infeasible" for verdict in of_scenes):
            bounds = [v.merit if v.status == "optimal" else -np.inf for v in of_scenes]
            choices.append((max(bounds, default=-np.inf), choice))
    tried: list[Verdict] = []
    skipped = -np.inf if not choices else np.inf
    for bound, choice in sorted(choices):
        best = min((v.merit for v in tried if usable(v)), default=np.inf)
        if bound >= best - TIE * max(1.0, abs(best)):
            break
        if tried and task.seconds_left() == 0.0:
            skipped = bound
            break
        verdict = solve_program(task, task.program([options[i][k] for i, k in enumerate(choice)]))
        spent += verdict.iterations
        tried.append(verdict)
    return replace(chosen_of(tried, skipped), iterations=spent)


def usable(verdict: Verdict) -> bool:
    """Whether a verdict comes with settings that meet all rules."""
    return verdict.status in ("optimal", "feasible")


def nearness(verdict: Verdict) -> tuple[bool, float]:
    """Order of verdicts: feasible ones by what they reach, the others by how much they miss."""
    if usable(verdict):
        return False, verdict.merit
    return True, np.inf if verdict.max_violation is None else verdict.max_violation


def bounds_of_scenes(task: Task, options: list[list[Piece]]) -> tuple[list[list[Verdict]], int]:
    """Each piece of each scene solved as if there were no other scene, and the iterations it took.

    Nothing when there is one choice only, or one scene: then the pieces are the choices.
    """
    if len(options) == 1 or all(len(found) == 1 for found in options):
        return [], 0
    alone = [
        [solve_program(task, task.program([piece], only=index)) for piece in found]
        for index, found in enumerate(options)
    ]
    return alone, sum(verdict.iterations for found in alone for verdict in found)


def chosen_of(tried: list[Verdict], skipped: float) -> Verdict:
    """The best verdict, downgraded to what all of them together prove."""
    if not tried:
        return Verdict("infeasible", "no scene's settings are feasible on their own")
    good = [verdict for verdict in tried if usable(verdict) and np.isfinite(verdict.merit)]
    if good:
        lowest = min(verdict.merit for verdict in good)
        tied = [verdict for verdict in good if verdict.merit <= lowest + TIE * max(1.0, abs(lowest))]
        best = min(tied, key=lambda verdict: verdict.light_power_w)
        unproven = [v for v in tried if v.status == "failed" or (v.status == "feasible" and v is not best)]
        if best.status == "optimal" and (unproven or skipped < best.merit):
            return replace(best, status="feasible", message=f"{best.message}; another piece stays open")
        return best
    failed = [verdict for verdict in tried if verdict.status == "failed"]
    if failed or np.isfinite(skipped):
        return min(failed, key=nearness) if failed else Verdict("failed", "time used up")
    return tried[0]


def attempt(task: Task, program: Program, start: Any) -> Attempt:
    """One run of the task's method; its library is loaded here, when it is first needed."""
    if task.method == "casadi":
        from uwopt.solvers.continuous import casadi_ipopt

        return casadi_ipopt.solve_by_ipopt(program, start, max_seconds=task.seconds_left())
    from uwopt.solvers.continuous import nlopt_algorithms

    return nlopt_algorithms.solve_by_nlopt(program, start, algorithm=task.method, max_seconds=task.seconds_left())


def solve_program(task: Task, program: Program) -> Verdict:
    """From the middle of the ranges; if that fails, from a point that meets the rules."""
    if program.empty:
        return Verdict("infeasible", "the scenes' f-numbers do not meet, or the power limit is too low")
    first = judged(task, program, attempt(task, program, program.middle()))
    if first.status == "optimal" or task.seconds_left() == 0.0:
        return first
    search = replace(program, goal="restore")
    found = attempt(task, search, search.middle())
    spent = first.iterations + found.iterations
    least_violation = float(search.rules(list(found.x)).objective)
    proven = found.kkt_residual <= task.proof.kkt_residual
    if least_violation > FEASIBLE:
        if proven and not usable(first):
            message = f"some rule is missed by {least_violation:.3g} at least (relative, in logarithms)"
            return Verdict("infeasible", message, iterations=spent)
        return replace(first, iterations=spent)
    again = program.point(search.set_points(found.x))
    second = judged(task, program, attempt(task, program, again))
    better = min(first, second, key=nearness)
    return replace(better, iterations=spent + second.iterations)


def judged(task: Task, program: Program, found: Attempt) -> Verdict:
    """What an attempt is worth: rules in their own terms first, then the conditions of an optimum."""
    settings = program.set_points(found.x)
    proof = task.proof
    missed = violations(program.scenes, settings, motorised=program.motorised, light_limit_w=program.light_limit_w)
    worst = max(missed, key=lambda name: missed[name])
    max_violation = max(missed[worst], 0.0)
    feasible = max_violation <= FEASIBLE
    optimal = max_violation <= proof.violation and found.kkt_residual <= proof.kkt_residual
    if optimal and len(found.x):
        at, bounds = derivatives(program, found.x), program.bounds
        optimal = optimality_gap(at, found.multipliers, found.x, *bounds) <= GAP
    status: Status = "optimal" if optimal else "feasible" if feasible else "failed"
    unit = task.value_per_unit(program, found.x)
    named = zip(rule_names(program), found.multipliers, strict=True)
    return Verdict(
        status=status,
        message=found.message if feasible else f"{found.message}; {worst} missed by {max_violation:.3g}",
        value=task.design.value(task.objective, settings, program.scenes),
        merit=merit_of(program, settings),
        light_power_w=worst_light_w(program.scenes, settings),
        settings=tuple(settings),
        max_violation=float(max_violation),
        kkt_residual=found.kkt_residual,
        multipliers={name: float(unit * value) for name, value in named if abs(value) > 1e-7},
        iterations=found.iterations,
    )


def merit_of(program: Program, settings: Sequence[SmoothSettings]) -> float:
    """The program's objective at settings, its epigraph variables as small as they may be."""
    light_w = worst_light_w(program.scenes, settings)
    if program.goal == "power":
        return float(np.log(light_w)) if light_w > 0.0 else -np.inf
    log_snr = float(np.log(worst_scene_snr(program.scenes, settings)))
    return program.power_weight * light_w / program.sum_unit - log_snr if program.goal == "sum" else -log_snr
