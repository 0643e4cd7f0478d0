"""Imagers that no f-number of the lens leaves the contrast of fine detail that is asked for, whatever the light.

Each is asked once for lamps of one spectrum, and only where no rule of light or price has discarded it.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.bars import MAY_SHOW, Bars, StillBars
from uwopt.forward.problem import Problem
from uwopt.forward.sharpness import SharpRows
from uwopt.solvers.exact.imagers import Imagers

INTERVALS = 12  # of f-numbers between the widest and the smallest opening
RULES = ("min_mtf_half_nyquist", "resolve_mm")


class NeverSharp:
    """Which imagers of a search cannot be sharp, found once for lamps of one spectrum."""

    def __init__(self, problem: Problem, imagers: Imagers):
        self.problem, self.imagers = problem, imagers
        self._known: dict[tuple[str, int, int], Array] = {}

    def under(self, optics: int, rows: Array) -> Iterator[tuple[str, Array]]:
        """Each requirement of fine detail by scene, and which of these imagers no f-number lets keep it, (n,)."""
        for index, scene in enumerate(self.problem.scenes):
            needs = scene.view.requirements
            if self.problem.paper or not needs.asks_sharpness:
                continue
            spectrum = int(self.problem.contractions[index].spectrum_of[optics])
            for rule in RULES:
                if getattr(needs, rule):
                    yield rule, self._of_scene(rule, index, spectrum, optics, rows)

    def _of_scene(self, rule: str, index: int, spectrum: int, optics: int, rows: Array) -> Array:
        """The same in one scene: worked out for those imagers that are new."""
        known = self._known.setdefault((rule, index, spectrum), np.full(len(self.imagers), -1))
        new = rows[known[rows] < 0]
        if len(new):
            known[new] = self._anew(rule, index, optics, new)
        return np.asarray(known[rows] == 1)

    def _anew(self, rule: str, index: int, optics: int, rows: Array) -> Array:
        focused = self.imagers.scenes[index].focused.take(rows)
        sharp = self.imagers.sharpness(self.problem, index, rows, optics)
        needs = self.problem.scenes[index].view.requirements
        least, width_mm = (getattr(needs, name) if name == rule else 0.0 for name in RULES)
        bars = sharp.asked(min_mtf=least, resolve_m=width_mm * 1e-3)[0]
        return blurred(sharp, bars, focused.working_factor, focused.n_low, focused.n_high)


def blurred(sharp: SharpRows, bars: Bars, working_factor: Array, low: Array, high: Array) -> Array:
    """Whether no f-number between two leaves bars their contrast, (n,): the middle one mostly does."""
    asked = StillBars.of(bars, sharp)

    def ask(rows: Array, first: Array, last: Array) -> Array:
        left = asked.best_between(rows, first[rows], last[rows], working_factor=working_factor[rows])
        return np.asarray(np.minimum(*left).min(axis=1) >= bars.least * MAY_SHOW)

    every, high = np.arange(len(low)), np.maximum(high, low)
    middle = np.sqrt(low * high)
    never = ~ask(every, middle, middle)
    open_ = np.flatnonzero(never)
    open_ = open_[ask(open_, low, high)]
    ends = np.geomspace(low, high, INTERVALS + 1)
    for first, last in pairwise(ends):
        still = open_[never[open_]]
        never[still] = ~ask(still, first, last)
    return never
