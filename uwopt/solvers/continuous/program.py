"""The settings of given hardware as a smooth program: what the continuous solvers are handed.

Unknowns are natural logarithms of f-number (common, or by scene with a motorised lens), light-collecting
time, light level and gain of every scene, and of the worst scene's power or SNR (epigraph variables).
In logarithms light, X = light * level * time / N_w^2, is linear, every noise variance is a sum of
exponentials, and so each rule below is convex: a geometric program, whose stationary point is the global
optimum. The exceptions are those of dark current, by as much as dark electrons count against the image's:
a wanted mean level becomes a curve, and an exposure is shorter than its time by the sensor's offset.

The program is written once, over anything that NumPy's elementary functions take: floats (checks),
complex arrays (derivatives by complex step), CasADi symbols (derivatives by CasADi).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, Protocol

import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.continuous.pieces import (
    NUMBERS,
    Piece,
    Range,
    SmoothScene,
    SmoothSettings,
    Symbolic,
    common_range,
    worst_scene_snr,
)
from uwopt.tolerances import SLACK
from uwopt.units import ratio_to_db

Goal = Literal["power", "snr", "sum", "restore"]

MARGIN_WANTED = -1.0  # restoration stops when every rule holds with this margin, in logarithms
POWER_SLACK = 1e-9  # relative, by which the search lets power exceed its limit
FIXED = 1e-13  # a range narrower than this, in logarithms, is a constant


@dataclass(frozen=True)
class Rules:
    """Values of a program's rules at a point, by name: each inequality <= 0, each equality 0, in logarithms."""

    objective: Symbolic
    inequalities: dict[str, Symbolic]
    equalities: dict[str, Symbolic]


class Smooth(Protocol):
    """A program as solvers see it: whoever has these."""

    @property
    def names(self) -> tuple[str, ...]:
        """The unknowns."""

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest of each."""

    def rules(self, x: Sequence[Symbolic]) -> Rules:
        """Objective and rules at a point: floats, complex arrays or symbols."""


@dataclass(frozen=True)
class Program:
    """min objective(x) under inequalities(x) <= 0, equalities(x) = 0, low <= x <= high."""

    scenes: tuple[SmoothScene, ...]
    pieces: tuple[Piece, ...]
    motorised: bool
    goal: Goal
    power_weight: float
    snr_weight: float
    light_limit_w: float

    # ------------------------------------------------------------ unknowns

    @cached_property
    def ranges(self) -> dict[str, Range]:
        """Every quantity with its range in natural logarithms, the fixed ones too."""
        ranges: dict[str, Range] = {}
        for index, (scene, piece) in enumerate(zip(self.scenes, self.pieces, strict=True)):
            ranges |= {self._key(name, index): ends for name, ends in piece.ranges(scene).items()}
        if not self.motorised:
            low, high = common_range(self.scenes)
            ranges["f_number"] = float(np.log(low)), float(np.log(self._high(low, high)))
        if self.goal in ("power", "sum") and any(scene.draws for scene in self.scenes):
            ranges["power"] = self._power_range()
        if self.goal in ("snr", "sum"):
            ranges["snr"] = self._snr_range(ranges)
        return ranges

    @staticmethod
    def _high(low: float, high: float) -> float:
        return low if low * (1.0 - SLACK) <= high < low else high

    def _key(self, name: str, index: int) -> str:
        """A number of one scene among the unknowns."""
        return name if name == "f_number" and not self.motorised else f"{name}[{index}]"

    def _of_scene(self, values: Mapping[str, Any], index: int) -> dict[str, Any]:
        """What is known of each number of one scene among all."""
        return {name: values[self._key(name, index)] for name in NUMBERS}

    def _power_range(self) -> Range:
        ends = []
        for scene, piece in zip(self.scenes, self.pieces, strict=True):
            if scene.draws:
                low = SmoothSettings(1.0, piece.time_low_s, piece.level_low, 1.0)
                high = SmoothSettings(1.0, piece.time_high_s, piece.level_high, 1.0)
                ends.append((piece.light_power_w(scene, low), piece.light_power_w(scene, high)))
        most = min(max(high for _, high in ends), max(self.light_limit_w, 0.0) * (1.0 + POWER_SLACK))
        least = max(low for low, _ in ends)
        with np.errstate(divide="ignore"):
            return float(np.log(least)), float(np.log(self._high(least, most)))

    def _snr_range(self, ranges: dict[str, Range]) -> Range:
        """Between every quantity at its worst and at its best for light, worst scene."""
        each = [
            [scene.nominal_snr(at) for at in piece.ends(self._of_scene(ranges, index))]
            for index, (scene, piece) in enumerate(zip(self.scenes, self.pieces, strict=True))
        ]
        with np.errstate(divide="ignore"):
            low, high = np.log(np.min(each, axis=0))
        return float(low), float(high)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The unknowns; what has no range is a constant."""
        free = tuple(name for name, (low, high) in self.ranges.items() if high - low > FIXED)
        return (*free, "violation") if self.goal == "restore" else free

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest of each unknown."""
        ranges = dict(self.ranges)
        if self.goal == "restore":
            middle = [0.5 * sum(self.ranges[name]) for name in self.names[:-1]]
            inequalities, equalities = self._plain_rules([*middle, 0.0])
            worst = max([0.0, *inequalities.values(), *map(abs, equalities.values())])
            ranges["violation"] = (MARGIN_WANTED, float(worst) + 1.0)
        pairs = np.array([ranges[name] for name in self.names], float).reshape(-1, 2)
        return pairs[:, 0], pairs[:, 1]

    @property
    def empty(self) -> bool:
        """Whether some range has no point: the common f-number, or power beyond its limit."""
        if any(scene.draws for scene in self.scenes):
            least_w = np.exp(self._power_range()[0])
            if not least_w <= self.light_limit_w * (1.0 + POWER_SLACK):
                return True
        return any(not -np.inf < low <= high for low, high in self.ranges.values())

    # ------------------------------------------------------------ points

    def middle(self) -> Array:
        """Middle of all ranges, the epigraph variables where they are just large or small enough."""
        low, high = self.bounds
        return self.complete(0.5 * (low + high))

    def complete(self, x: Array) -> Array:
        """The point with its epigraph variables moved to where their rules hold, within their bounds."""
        x, (low, high) = np.clip(x, *self.bounds), self.bounds
        at = self.settings(list(x))
        for index, name in enumerate(self.names):
            if name == "power":
                x[index] = np.log(max(s.light_power_w(a) for s, a in zip(self.scenes, at, strict=True)))
            elif name == "snr":
                x[index] = np.log(worst_scene_snr(self.scenes, at))
            elif name == "violation":
                inequalities, equalities = self._plain_rules(list(x))
                x[index] = max([low[index], *inequalities.values(), *map(abs, equalities.values())])
        return np.clip(x, low, high)

    def point(self, start: Sequence[SmoothSettings]) -> Array:
        """The program's unknowns at given settings, clipped to the ranges."""
        given: dict[str, float] = {}
        for index, at in enumerate(start):
            given |= {self._key(name, index): float(np.log(getattr(at, name))) for name in NUMBERS}
        low, high = self.bounds
        middle = 0.5 * (low + high)
        return self.complete(np.array([given.get(n, m) for n, m in zip(self.names, middle, strict=True)]))

    def settings(self, x: Sequence[Symbolic]) -> list[SmoothSettings]:
        """The settings of every scene at a point."""
        logs: dict[str, Symbolic] = {name: low for name, (low, _) in self.ranges.items()}
        logs.update(zip(self.names, x, strict=True))
        return [piece.settings(self._of_scene(logs, index)) for index, piece in enumerate(self.pieces)]

    def set_points(self, x: Array) -> list[SmoothSettings]:
        """The settings at a point, rounding of the logarithms taken back at the ends of each range."""
        each = zip(self.pieces, self.scenes, self.settings(list(x)), strict=True)
        return [piece.set_point(scene, at) for piece, scene, at in each]

    # ------------------------------------------------------------ rules

    def rules(self, x: Sequence[Symbolic]) -> Rules:
        """Objective and rules at a point."""
        inequalities, equalities = self._plain_rules(x)
        if self.goal == "restore":
            worst = x[-1]
            sides = {f"{name} {side}": sign * value for name, value in equalities.items()
                     for side, sign in (("above", 1.0), ("below", -1.0))}  # fmt: skip
            return Rules(worst, {name: value - worst for name, value in (inequalities | sides).items()}, {})
        return Rules(self._objective(self._epigraph(x)), inequalities, equalities)

    def _epigraph(self, x: Sequence[Symbolic]) -> dict[str, Symbolic]:
        values: dict[str, Symbolic] = {
            name: self.ranges[name][0] for name in ("power", "snr") if name in self.ranges
        }
        values.update({name: x[i] for i, name in enumerate(self.names) if name in values})
        return values

    def _objective(self, epigraph: dict[str, Symbolic]) -> Symbolic:
        """The logarithm of power or of 1/SNR; of a sum, the sum in units of its SNR term."""
        if self.goal == "power":
            return epigraph.get("power", 0.0)
        if self.goal == "snr":
            return -epigraph["snr"]
        power_w = np.exp(epigraph["power"]) if "power" in epigraph else 0.0
        return self.power_weight * power_w / self.sum_unit - epigraph["snr"]

    @property
    def sum_unit(self) -> float:
        """What one unit of ln SNR is worth in the minimised sum: dB per e-fold times the weight of a dB."""
        return self.snr_weight * float(ratio_to_db(np.e))

    def _power_rule(self, scene: SmoothScene, piece: Piece) -> bool:
        """Whether a scene's power is a rule: it can vary, and something asks for it."""
        asked = self.goal in ("power", "sum") or bool(np.isfinite(self.light_limit_w))
        return asked and scene.draws and not piece.fixes_power(scene)

    def _plain_rules(self, x: Sequence[Symbolic]) -> tuple[dict[str, Symbolic], dict[str, Symbolic]]:
        epigraph, inequalities, equalities = self._epigraph(x), dict[str, Symbolic](), dict[str, Symbolic]()
        each = zip(self.scenes, self.pieces, self.settings(list(x)), strict=True)
        for index, (scene, piece, at) in enumerate(each):
            inequalities |= {f"{name}[{index}]{where}": v for (name, where), v in scene_rules(scene, at).items()}
            wanted = scene.wanted_dn
            if wanted is not None:
                nominal_dn = scene.digital_dn(scene.total_e[scene.nominal], at, offset_dn=0.0)
                equalities[f"mean_level[{index}]"] = np.log(nominal_dn / wanted)
            if self._power_rule(scene, piece):
                name, limit = "power_limit", epigraph.get("power")
                if limit is None:
                    limit = float(np.log(self.light_limit_w))
                else:
                    name = "power"
                inequalities[f"{name}[{index}]"] = np.log(piece.light_power_w(scene, at)) - limit
            if self.goal in ("snr", "sum"):
                inequalities[f"snr[{index}]"] = epigraph["snr"] - np.log(scene.nominal_snr(at))
        return inequalities, equalities


def scene_rules(scene: SmoothScene, at: SmoothSettings) -> dict[tuple[str, str], Symbolic]:
    """Enough SNR where it is darkest, no saturation where it is brightest: both grow with signal. By name and place."""
    rules: dict[tuple[str, str], Symbolic] = {}
    for place, (signal, total, wanted) in enumerate(scene.wanted):
        where = f" at {place}" if len(scene.wanted) > 1 else ""
        rules["min_snr", where] = -np.log(scene.snr(signal, at, total_e=total) / wanted)
    brightest = max(scene.total_e)
    if brightest > 0.0:
        rules["saturation", ""] = np.log(scene.digital_dn(brightest, at, offset_dn=0.0) / scene.headroom_dn)
    if np.isfinite(scene.well_e) and brightest > 0.0:
        allowed = scene.well_e / scene.highlight_ratio
        rules["full_well", ""] = np.log((scene.electrons(brightest, at) + scene.dark_e(at)) / allowed)
    return rules


def names_of_rules(program: Smooth) -> tuple[list[str], list[str]]:
    """Names of a program's inequalities and equalities, which are the same at every point."""
    low, high = program.bounds
    with np.errstate(all="ignore"):
        rules = program.rules((0.5 * (low + high)).tolist())
    return [*rules.inequalities], [*rules.equalities]
