"""A program in fewer unknowns, for algorithms that take no equalities or few unknowns.

A wanted mean level is an equality in every scene. It is solved for the gain, or for the light level where
no gain can be turned: in logarithms both stand alone in it. Where neither is free the equality becomes a
pair of inequalities, a little apart. Without derivatives the worst scene's power and SNR need no unknown
of their own either: they are worked out from the others.

Looks like a `Program` to solvers, which ask for what `program.Smooth` has.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.continuous.pieces import SmoothSettings, Symbolic
from uwopt.solvers.continuous.program import Program, Rules, names_of_rules

APART = 1e-8  # in logarithms: half the width of the gap that stands for an equality
WORST = ("power", "snr", "violation")


class Reduced:
    """A program whose equalities are gone, and the unknowns with them that they determine.

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
