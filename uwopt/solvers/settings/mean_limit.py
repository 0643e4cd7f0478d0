"""A limit on the mean power over several scenes, which no scene alone meets or misses.

Settings of least power draw least in every scene at once, so their mean is the least too; and what a floor of SNR
takes grows with that floor in every scene. The highest floor within the limit is found by halving.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.problem import Problem
from uwopt.forward.scene_rows import SceneRows
from uwopt.model.bisection import bisected
from uwopt.solvers.settings import closed_form
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.windows import Window
from uwopt.tolerances import ROUND

HALVINGS = 60  # of a range of SNR, in its logarithm
FAINTEST = 1e-6  # of the highest SNR: where the range starts


@dataclass(frozen=True)
class MeanLimit:
    """Highest mean power of lights and cameras over scenes that share the time."""

    shares: tuple[float, ...]
    limit_w: float

    @staticmethod
    def of(problem: Problem) -> MeanLimit | None:
        """The limit that a mission's energy sets over its scenes; None where it is none, or that of one scene."""
        duration = problem.duration
        return MeanLimit(duration.shares, duration.mean_power_limit_w) if duration.over_scenes else None

    def mean_w(self, by_scene: Sequence[Array]) -> Array:
        """Mean of the lights' power; a scene that takes no time counts for nothing."""
        return np.asarray(sum(s * p for s, p in zip(self.shares, by_scene, strict=True) if s > 0.0))

    def holds(self, by_scene: Sequence[Array], camera_power_w: Array) -> Array:
        """Whether the lights' power by scene keeps within it; not where there is no number."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.mean_w(by_scene) + camera_power_w <= self.limit_w * ROUND)

    def met_by(self, chosen: Sequence[Chosen], camera_power_w: Array) -> Array:
        """Whether settings keep within it."""
        return self.holds([c.light_power_w for c in chosen], camera_power_w)

    def highest_snr(
        self, rows: list[SceneRows], motorised: Array, top: Array, camera_power_w: Array, asked: list[Window]
    ) -> Array:
        """The highest floor of SNR up to `top` whose least power keeps within the limit; 0 where none does.

        asked : as in `closed_form.least_power`
        """

        def within(floor: Array) -> Array:
            chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=floor, asked=asked)
            return np.asarray(feasible & self.met_by(chosen, camera_power_w))

        done = within(top)
        if done.all():
            return top
        low, high = np.log(np.maximum(top * FAINTEST, 1e-300)), np.log(np.maximum(top, 1e-300))
        fits = within(np.exp(low))
        low, _ = bisected(lambda middle: within(np.exp(middle)), low, high, steps=HALVINGS)
        return np.where(done, top, np.where(fits, np.exp(low), 0.0))
