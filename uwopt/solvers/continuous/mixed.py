"""Hardware, steps of light and settings in one mixed-integer program: what Bonmin is handed.

A shortlist of hardware is open to choice. Of each, every scene is cut into smooth pieces (`pieces`): one
step of the light, one side of a kink. A binary variable stands for each piece of each hardware; one piece a
scene is taken, all of the same hardware. F-number, time, level and gain are unknowns in natural logarithms
that all hardware shares; a rule of a piece holds where its variable is 1, and is let go elsewhere by as much
as it can be missed at most,

    rule(x) <= M (1 - y),      M = max of the rule over the box of all unknowns.

The rules are those of the continuous program (`program.scene_rules`), convex but for dark current, so the
maximum is taken at a corner of the box, and a branch and bound over y is exact in theory where no dark
current counts. The program is written once, over floats (checks) or CasADi symbols.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from uwopt.arrays import Array
from uwopt.objectives.objective import Objective
from uwopt.solvers.continuous.optimality import violations
from uwopt.solvers.continuous.pieces import (
    NUMBERS,
    Piece,
    Range,
    SmoothDesign,
    SmoothScene,
    SmoothSettings,
    Symbolic,
    smooth_pieces,
)
from uwopt.solvers.continuous.program import scene_rules
from uwopt.units import ratio_to_db

LEAST_W, LEAST_SNR = 1e-9, 1e-12  # stand for no power and no light, which have no logarithm
SLACK = 1e-9  # in logarithms: by which fixed quantities may be off
ROOM = 1e-6  # added to what a rule can be missed by


@dataclass(frozen=True)
class Option:
    """One piece of one scene of one candidate: what a binary variable stands for."""

    candidate: int
    scene: int
    piece: Piece


@dataclass(frozen=True)
class Answer:
    """What a mixed-integer solver returned, before anything of it is believed."""

    x: Array
    message: str
    nodes: int
    ended: bool  # its search came to an end, by its own word


@dataclass(frozen=True)
class Picked:
    """A point read back: which hardware, its settings, its value, and by how much rules are missed."""

    candidate: int
    settings: tuple[SmoothSettings, ...]
    value: float
    max_violation: float


class MixedProgram:
    """min objective(x, y) under rules(x, y) <= 0, choices(y) = 0, low <= (x, y) <= high, y binary."""

    def __init__(self, candidates: Sequence[SmoothDesign], objective: Objective, power_limit_w: float):
        self.objective, self.power_limit_w = objective, power_limit_w
        self.candidates = [one.drawn_together() for one in candidates]
        self.n_scenes = len(candidates[0].scenes) if candidates else 0
        self.options: list[Option] = []
        for index, candidate in enumerate(candidates):
            pieces = [smooth_pieces(scene) for scene in candidate.scenes]
            room_w = power_limit_w - candidate.camera_power_w
            if all(pieces) and room_w >= 0.0:
                self.options += [Option(index, s, p) for s, found in enumerate(pieces) for p in found]
        self.open_to_choice = sorted({option.candidate for option in self.options})
        self.f_number_apart = any(self.candidates[k].motorised for k in self.open_to_choice)
        self.weighs_power = bool(objective.weight("power"))
        self.weighs_snr = bool(objective.weight("snr_db"))

    # ------------------------------------------------------------ unknowns

    @cached_property
    def ranges(self) -> dict[str, Range]:
        """The continuous unknowns in logarithms: the box that holds all candidates."""
        found: dict[str, Range] = {}
        watts, snrs = list[float](), list[float]()
        for option in self.options:
            scene, own = self._scene(option), option.piece.ranges(self._scene(option))
            for name, ends in own.items():
                key = self._key(name, option.scene)
                low, high = found.get(key, ends)
                found[key] = min(low, ends[0]), max(high, ends[1])
            for at in option.piece.ends(own):
                watts.append(float(option.piece.light_power_w(scene, at)))
                snrs.append(float(scene.nominal_snr(at)))
        if self.weighs_power:
            found["power"] = (float(np.log(max(min(watts), LEAST_W))), float(np.log(max(*watts, LEAST_W))))
        if self.weighs_snr:
            found["snr"] = float(np.log(max(min(snrs), LEAST_SNR))), float(np.log(max(*snrs, LEAST_SNR)))
        return found

    def _scene(self, option: Option) -> SmoothScene:
        """Where an option belongs."""
        return self.candidates[option.candidate].scenes[option.scene]

    @property
    def n_continuous(self) -> int:
        """How many unknowns come before the binary ones."""
        return len(self.ranges)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest of all unknowns, the binary ones last."""
        pairs = np.array(list(self.ranges.values()), float).reshape(-1, 2)
        n = len(self.options)
        return np.append(pairs[:, 0], np.zeros(n)), np.append(pairs[:, 1], np.ones(n))

    def start(self) -> Array:
        """The middle of the box, every option as likely."""
        low, high = self.bounds
        x = 0.5 * (low + high)
        for s in range(self.n_scenes):
            mine = [i for i, option in enumerate(self.options) if option.scene == s]
            x[self.n_continuous + np.array(mine, int)] = 1.0 / len(mine)
        return x

    # ------------------------------------------------------------ formulas

    def _named(self, x: Sequence[Symbolic]) -> dict[str, Symbolic]:
        return dict(zip(self.ranges, x, strict=False))

    def _key(self, name: str, scene: int) -> str:
        return name if name == "f_number" and not self.f_number_apart else f"{name}[{scene}]"

    def _settings(self, option: Option, logs: dict[str, Symbolic]) -> SmoothSettings:
        return option.piece.settings({name: logs[self._key(name, option.scene)] for name in NUMBERS})

    def rules_of(self, option: Option, logs: dict[str, Symbolic]) -> list[Symbolic]:
        """What must be 0 or below where this option is taken, at logarithms of the continuous unknowns."""
        candidate, s, piece = self.candidates[option.candidate], option.scene, option.piece
        scene, at = candidate.scenes[s], self._settings(option, logs)
        found = [*scene_rules(scene, at).values()]
        for name, (low, high) in piece.ranges(scene).items():
            key = self._key(name, s)
            slack = SLACK if high - low < SLACK else 0.0
            if self.ranges[key][0] < low:
                found.append(low - slack - logs[key])
            if self.ranges[key][1] > high:
                found.append(logs[key] - high - slack)
        wanted = scene.wanted_dn
        if wanted is not None:
            off = np.log(scene.digital_dn(scene.total_e[scene.nominal], at, offset_dn=0.0) / wanted)
            found += [off - SLACK, -off - SLACK]
        if scene.draws:
            power = np.log(piece.light_power_w(scene, at))
            limit_w = self.power_limit_w - candidate.camera_power_w
            if self.weighs_power:
                found.append(power - logs["power"])
            if np.isfinite(limit_w):
                found.append(power - float(np.log(max(limit_w, LEAST_W))))
        if self.weighs_snr:
            found.append(logs["snr"] - np.log(scene.nominal_snr(at)))
        if self.f_number_apart and not candidate.motorised and s:
            apart = logs[f"f_number[{s}]"] - logs["f_number[0]"]
            found += [apart - SLACK, -apart - SLACK]
        return found

    @cached_property
    def room(self) -> list[list[float]]:
        """By how much each rule of each option can be missed at most in the box."""
        low, high = self.bounds
        ends = {name: (low[i], high[i]) for i, name in enumerate(self.ranges)}
        made = []
        for option in self.options:
            own = [self._key(name, option.scene) for name in NUMBERS]
            own += [name for name in ("power", "snr", "f_number[0]") if name in ends and name not in own]
            grid = np.array(list(itertools.product(*(ends[name] for name in own)))).T
            with np.errstate(all="ignore"):
                values = [
                    np.asarray(rule, float)
                    for rule in self.rules_of(option, dict(zip(own, grid, strict=True)))
                ]
            most = [float(np.nan_to_num(value, nan=0.0, posinf=1e3).max()) for value in values]
            made.append([max(value, 0.0) + ROOM for value in most])
        return made

    @property
    def unit(self) -> float:
        """What the objective is divided by."""
        fixed = [abs(self.candidates[k].fixed(self.objective)) for k in self.open_to_choice]
        return max(min(fixed, default=1.0), 1e-3)

    def formulas(self, x: Sequence[Symbolic]) -> tuple[Symbolic, list[Symbolic], list[Symbolic]]:
        """Objective, inequalities and equalities at a point: floats or symbols."""
        logs, n = self._named(x), self.n_continuous
        taken = [x[n + i] for i in range(len(self.options))]
        total: Symbolic = 0.0
        for i, option in enumerate(self.options):
            if option.scene == 0:
                total = total + self.candidates[option.candidate].fixed(self.objective) * taken[i]
        if self.weighs_power:
            total = total + self.objective.weight("power") * np.exp(logs["power"])
        if self.weighs_snr:
            total = total - self.objective.weight("snr_db") * float(ratio_to_db(np.e)) * logs["snr"]
        rules = [
            rule - most * (1.0 - taken[i])
            for i, option in enumerate(self.options)
            for rule, most in zip(self.rules_of(option, logs), self.room[i], strict=True)
        ]
        first = sum(taken[i] for i, option in enumerate(self.options) if option.scene == 0)
        choices: list[Symbolic] = [first - 1.0]
        for k in self.open_to_choice:
            own = [
                sum(taken[i] for i, o in enumerate(self.options) if o.candidate == k and o.scene == s)
                for s in range(self.n_scenes)
            ]
            choices += [one - own[0] for one in own[1:]]
        return total / self.unit, rules, choices

    # ------------------------------------------------------------ reading back

    def picked(self, x: Array) -> Picked:
        """The hardware and settings of a point, each rule checked in its own terms."""
        n = self.n_continuous
        share = np.asarray(x)[n:]
        by_candidate = {
            k: sum(share[i] for i, o in enumerate(self.options) if o.candidate == k)
            for k in self.open_to_choice
        }
        best = max(by_candidate, key=lambda k: by_candidate[k])
        candidate, logs = self.candidates[best], self._named([float(v) for v in x[:n]])
        settings = []
        for s, scene in enumerate(candidate.scenes):
            mine = [i for i, o in enumerate(self.options) if o.candidate == best and o.scene == s]
            option = self.options[max(mine, key=lambda i: share[i])]
            settings.append(option.piece.set_point(scene, self._settings(option, logs)))
        limit_w = self.power_limit_w - candidate.camera_power_w
        missed = violations(candidate.scenes, settings, motorised=candidate.motorised, light_limit_w=limit_w)
        value = candidate.value(self.objective, settings)
        return Picked(best, tuple(settings), value, max(0.0, *missed.values()))
