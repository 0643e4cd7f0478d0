"""NLopt's other algorithms, which no answer needs: peers of the exact search, and of SLSQP and COBYLA.

mma       method of moving asymptotes; inequalities, no equalities; gradients
ccsaq     its sister with quadratic models; inequalities, no equalities; gradients
lbfgs     quasi-Newton; takes no rules but bounds, so within an augmented Lagrangian; gradients
isres     evolution strategy; takes both; global; no gradients
ags       space-filling curve; inequalities, at most 10 of them, and at most 10 unknowns (5 are advised); global
direct_l  dividing rectangles, the original code, which takes inequalities; global; no gradients
mlsl      L-BFGS from a low-discrepancy sequence of starts; takes bounds only, so within an augmented
          Lagrangian; global

All are given a program without equalities (`Reduced`); those without gradients one without the worst scene's unknowns.
Import it late: it imports nlopt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import nlopt
import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.continuous.nlopt_algorithms import RULE_TOLERANCE, Evaluations, Way, finite
from uwopt.solvers.continuous.pieces import SmoothSettings, Symbolic
from uwopt.solvers.continuous.program import Program, Rules, names_of_rules

SUBSIDIARY = 50  # evaluations for each unknown within one round of an augmented Lagrangian
SUBSIDIARY_REL = 1e-8  # change of unknowns and objective at which such a round ends


@dataclass(frozen=True)
class Reducing(Way):
    """An algorithm that is given a program without equalities."""

    within: bool = False  # an augmented Lagrangian, which turns rules into penalties
    starts: bool = False  # it starts L-BFGS from many points

    def run(
        self, program: Program, start: Array, max_seconds: float, *, first_step: float | None = None
    ) -> tuple[Array, int, str]:
        """Where it ends as the program's point, evaluations, what it says."""
        asked = Reduced(program, worst_scene=self.gradients)
        if not asked.names:
            return asked.full(np.empty(0)), 0, f"NLopt {self.name}: nothing is left open"
        evaluations = Evaluations(asked)
        x, count, message = self.optimised(evaluations, asked.start(start), max_seconds, first_step)
        return asked.full(x), max(count, evaluations.count), message

    def solver(self, low: Array, high: Array) -> Any:
        """NLopt's, for unknowns between these."""
        if not self.within:
            return super().solver(low, high)
        solver: Any = nlopt.opt(nlopt.AUGLAG, len(low))
        solver.set_local_optimizer(subsidiary(self, low, high))
        return solver

    def hold(self, solver: Any, evaluations: Evaluations) -> None:
        """Give the solver the program's rules; of those without gradients one alone: the original DIRECT and AGS know
        no vectors of rules."""
        if self.gradients or not names_of_rules(evaluations.program)[0]:
            super().hold(solver, evaluations)
            return

        def worst(x: Array, gradient: Array) -> float:
            evaluations.at(x, False)
            return float(finite(evaluations.inequalities)[0])

        solver.add_inequality_constraint(worst, RULE_TOLERANCE)


FAR = dict(gradients=False, settles=False)  # of global ones, which mostly do not stop by themselves
OTHERS = {
    one.name: one
    for one in (
        Reducing("mma", nlopt.LD_MMA, 200),
        Reducing("ccsaq", nlopt.LD_CCSAQ, 200),
        Reducing("lbfgs", nlopt.LD_LBFGS, 400, within=True),
        Reducing("isres", nlopt.GN_ISRES, 600, **FAR),
        Reducing("ags", nlopt.GN_AGS, 600, **FAR),
        Reducing("direct_l", nlopt.GN_ORIG_DIRECT_L, 150, **FAR),
        Reducing("mlsl", nlopt.G_MLSL_LDS, 400, within=True, starts=True),
    )
}


def subsidiary(how: Reducing, low: Array, high: Array) -> Any:
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
