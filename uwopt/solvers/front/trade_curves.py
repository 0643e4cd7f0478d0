"""Curves of quality against power: what the settings of given hardware can trade, for many designs at once.

A curve is known at power limits: what no settings within the limit can beat, and, once it is asked, the best
quality within the limit with the least power that gives it. Between two limits no point is better than the
corner (lower limit, bound at the upper limit). Segments whose corner may still matter are asked at their
upper end, then in their middle, until they are small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import product
from typing import Any, Self

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import Deadline
from uwopt.forward.columns import Columns
from uwopt.objectives.objective import Objective
from uwopt.solvers.beside import shares, side_by_side
from uwopt.solvers.exact.node_bounds import bit_per_px_bound
from uwopt.solvers.front.ceilings import most_information
from uwopt.solvers.front.hopeful import Hopeful, unhindered
from uwopt.solvers.settings import closed_form, windows
from uwopt.solvers.settings.best import best_settings, bound_if_any
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.information import information_of
from uwopt.solvers.settings.question import Best, Question
from uwopt.units import ratio_to_db

ABOVE = 1.0 + 1e-9  # a limit that equals the least power must admit it
POWER, SNR = Objective({"power": 1.0}), Objective({"snr_db": 1.0})
CURVE_GAP = 5e-4  # relative, of qualities without a closed form
DIMMEST = 1e-4  # of the power at the far end: where a curve that begins without light is first asked
LIMITS = 7  # power limits that a curve is first known at
FEWEST_DRAWN = 128  # designs whose bounds a core draws in
TRIED_F_NUMBERS, TRIED_LIGHT, TRIED_TIMES = (0.0, 0.35, 0.7), (0.0, 0.4, 0.7, 1.0), (1.0, 0.4)
#: Nodes of integrals in radius and angle that tell which tries are worth more, and how closely, relative.
GLANCE, GLANCE_REL = (5, 3), 0.02


@dataclass(frozen=True)
class Answers(Columns):
    """What n designs do within n power limits."""

    design: Array
    limit_w: Array  # of lights and cameras together
    power_w: Array  # nan: not asked, or no settings
    quality: Array
    bound: Array  # no settings within the limit have a higher quality; -inf: there are none
    asked: Array
    chosen: list[Chosen]

    @property
    def found(self) -> Array:
        """Which limits have settings."""
        return np.asarray(np.isfinite(self.power_w))

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """All answers of some lists, by design and limit."""
        every = super().joined(parts)
        return every.take(np.lexsort((every.limit_w, every.design)))

    def drawn_in(self) -> Answers:
        """With bounds no higher than those of higher limits of the same design."""
        bound, same = self.bound.copy(), self.design[1:] == self.design[:-1]
        while True:
            lower = np.where(same, np.minimum(bound[:-1], bound[1:]), bound[:-1])
            if np.array_equal(lower, bound[:-1]):
                return replace(self, bound=bound)
            bound[:-1] = lower

    @staticmethod
    def unasked(design: Array, limit_w: Array, bound: Array, n_scenes: int) -> Answers:
        """Limits of which only a bound is known."""
        nothing = np.full(len(design), np.nan)
        chosen = [Chosen(**dict.fromkeys((f.name for f in fields(Chosen)), nothing)) for _ in range(n_scenes)]
        return Answers(design, limit_w, nothing, nothing, bound, np.zeros(len(design), bool), chosen)


class Trade:
    """Least power and best quality of designs, quality being one term of an objective, or None.

    What is asked of cells of settings raises OutOfTimeError past the deadline.
    """

    def __init__(self, quality: str | None, deadline: Deadline):
        self.quality, self.deadline = quality, deadline

    # ------------------------------------------------------------ settings

    def least_power(self, some: Hopeful) -> Answers:
        """Settings of least power within the limit, and the quality that they have."""
        best = best_settings(self._asked(some, POWER, some.power_limit_w))
        quality = np.zeros(len(some)) if self.quality is None else self._quality_of(some, best)
        return self._answers(some, np.arange(len(some)), best, quality, None, None)

    def best_quality(
        self, some: Hopeful, design: Array, limit_w: Array, *, wanted: Array | float = -np.inf,
        near: Array | None = None,
    ) -> Answers:  # fmt: skip
        """Settings of best quality of these designs within these limits of power, and its bound.

        Those that cannot have a `wanted` quality may be given up, with a bound below it. `near` : (n, 2) f-number and
        time [s] near which the best are thought to be, nan: unknown.
        """
        assert self.quality is not None
        mine = some.take(design)
        limit = np.minimum(limit_w * ABOVE, some.power_limit_w)
        goal = Objective({self.quality: 1.0})
        best = best_settings(self._asked(mine, goal, limit, cutoff=-np.asarray(wanted, float), near=near))
        bound = self._quality_bound(best)
        quality = np.asarray(getattr(best, self.quality))
        return self._answers(mine, design, best, quality, limit_w, bound)

    def _asked(self, some: Hopeful, goal: Objective, limit_w: Array | float, **more: Any) -> Question:
        """For which settings of designs one goal asks."""
        return Question.of(
            some.rows, some.motorised, goal, some.camera_power_w, limit_w, gap_rel=CURVE_GAP, deadline=self.deadline,
            constant=some.camera_power_w if goal.weight("power") else 0.0, mean_limit=some.mean_limit, **more,
        )  # fmt: skip

    def _quality_bound(self, best: Best) -> Array:
        """What no settings can beat: the value in closed form, or a bound beside it."""
        if best.lower_bound is not None:
            return np.where(np.isfinite(best.lower_bound), -best.lower_bound, -np.inf)
        return np.where(best.feasible, best.snr_db, -np.inf)

    def _quality_of(self, some: Hopeful, best: Best) -> Array:
        """Quality of settings that were chosen for their power."""
        if self.quality != "information":
            return np.asarray(getattr(best, str(self.quality)))
        return information_of(some.rows, best.chosen, best.feasible)

    def _answers(
        self, some: Hopeful, design: Array, best: Best, quality: Array, limit_w: Array | None, bound: Array | None
    ) -> Answers:
        """Settings as answers; what has none is nan."""
        power = some.camera_power_w + np.max([c.light_power_w for c in best.chosen], axis=0)
        possible = best.feasible & (power <= some.power_limit_w * ABOVE)
        ok = possible & np.isfinite(quality)
        power = np.where(ok, power, np.nan)
        if bound is None:  # settings without an image are no point, yet a curve begins there
            bound = np.where(possible & ~ok, -np.inf, quality)
            bound = np.where(possible, bound, np.nan)
        else:
            bound = np.fmax(bound, np.where(ok, quality, -np.inf))
        quality = np.where(ok, quality, np.nan)
        return Answers(
            design,
            power if limit_w is None else limit_w,
            power,
            quality,
            bound,
            np.ones(len(design), bool),
            best.chosen,
        )

    def tried(self, some: Hopeful, design: Array) -> list[Answers]:
        """A few settings of these designs that any solver might try: points to beat, before curves are asked."""
        some = some.take(design)
        if len(some) and some.sunlit:
            return self._tried_sunlit(some, design)
        if len(some) == 0 or self.quality != "information" or any(r.asks_sharpness for r in some.rows):
            return []
        low = np.max([r.n_low for r in some.rows], axis=0)
        high = np.min([r.n_high for r in some.rows], axis=0)
        tries = [
            self._one_try(some, low * (np.maximum(high, low) / low) ** aperture, light, time)
            for aperture, light, time in product(TRIED_F_NUMBERS, TRIED_LIGHT, TRIED_TIMES)
        ]
        powers = np.array([power for _, power in tries])
        each = [Chosen.joined(scene) for scene in zip(*(chosen for chosen, _ in tries), strict=True)]
        glance, possible = np.full(powers.size, np.nan), np.flatnonzero(np.isfinite(powers))
        glance[possible] = information_of(  # all at once: calls are dear
            some.take(possible % len(some)).rows, [one.take(possible) for one in each], np.ones(len(possible), bool),
            orders=GLANCE,
        )  # fmt: skip
        which, mine = np.nonzero(_best_by_power(powers, glance.reshape(powers.shape)))
        place = which * len(some) + mine
        power, chosen = powers.ravel()[place], [one.take(place) for one in each]
        every = np.ones(len(place), bool)
        quality = information_of(some.take(mine).rows, chosen, every)
        return [Answers(design[mine], power, power, quality, quality, every, chosen)]

    def _tried_sunlit(self, some: Hopeful, design: Array) -> list[Answers]:
        """Points of least power, and of best quality within all of it."""
        from uwopt.solvers.settings.cells import best_by_cells

        goals = [POWER] if self.quality is None else [POWER, Objective({self.quality: 1.0})]
        tried = []
        for goal in goals:
            best = best_by_cells(self._asked(some, goal, some.power_limit_w), halve=False)
            quality = self._quality_of(some, best) if self.quality else np.zeros(len(some))
            tried.append(self._answers(some, design, best, quality, None, None))
        return tried

    def _one_try(
        self, some: Hopeful, f_number: Array, light_share: float, time_share: float
    ) -> tuple[list[Chosen], Array]:
        """The same place in every design's range of light, at one f-number: settings and their power, nan: none."""
        chosen, ok = [], np.ones(len(some), bool)
        for r in some.rows:
            rows = replace(r, time_max_s=np.maximum(r.time_max_s * time_share, r.time_min_s))
            with np.errstate(divide="ignore", invalid="ignore"):
                low, high = windows.window(rows)
                _, greatest = closed_form.reach(rows)
                most = np.nanmax(np.where(np.isnan(greatest), -1.0, greatest), axis=1)
                top = np.minimum(high, most / np.square(f_number * rows.working_factor))
                wanted = np.maximum(low, 1e-6 * top)
                wanted = wanted * np.maximum(top / wanted, 1.0) ** light_share
                one = closed_form.settle(rows, f_number, np.where(top > 0, wanted, np.nan), high)
                ok &= np.isfinite(one.level) & (one.light_x <= high * ABOVE) & (one.light_x >= low / ABOVE)
                ok &= (one.time_s <= r.time_max_s * ABOVE) & (f_number <= r.n_high * ABOVE)
            chosen.append(one.exposed(r))
        ok &= np.isfinite(np.max([c.light_power_w for c in chosen], axis=0))
        power = some.camera_power_w + np.where(ok, np.max([c.light_power_w for c in chosen], axis=0), np.nan)
        ok &= power <= some.power_limit_w * ABOVE
        if some.mean_limit is not None:
            ok &= some.mean_limit.met_by(chosen, some.camera_power_w)
        return chosen, np.where(ok, power, np.nan)

    # ------------------------------------------------------------ bounds

    def first_bounds(self, some: Hopeful, least_w: Array | None = None) -> Answers | None:
        """What no settings can beat at some limits of power; None: nothing is impossible.

        (n * LIMITS) answers, the least power of each design among the limits. `least_w` : (n,) [W] that power's
        bound, where it is known.
        """
        least_w = self.least_power_bound(some) if least_w is None else least_w
        alive = np.nonzero(np.isfinite(least_w))[0]
        if len(alive) == 0:
            return None
        some, least_w, n_scenes = some.take(alive), least_w[alive], len(some.rows)
        start = Answers.unasked(alive, least_w, np.full(len(alive), -np.inf), n_scenes)
        if self.quality is None:
            return replace(start, bound=np.zeros(len(alive)))
        limits = some.camera_power_w[:, None] + first_limits_w(some, np.maximum(least_w - some.camera_power_w, 0.0))
        row, column = np.nonzero(np.isfinite(limits))
        bounds = self.bounds_within(some, limits)
        return Answers.joined([start, Answers.unasked(
            alive[row], limits[row, column], bounds[row, column], n_scenes
        )])  # fmt: skip

    def least_power_bound(self, some: Hopeful) -> Array:
        """No settings of designs draw less, lamps and cameras together; inf: they have none."""
        if some.sunlit:
            least_w = self._whole_bound(some, POWER, some.power_limit_w)
        else:
            chosen, feasible = closed_form.least_power(unhindered(some.rows), some.motorised)
            light_w = np.max([c.light_power_w for c in chosen], axis=0)
            least_w = np.where(feasible, some.camera_power_w + light_w, np.inf)
        return np.where(least_w <= some.power_limit_w * ABOVE, least_w, np.inf)

    def may_fit(self, some: Hopeful) -> Array:
        """Whether any settings of designs may meet all requirements, (n,).

        Under the sun cells are halved until a point fits or all have died: that a curve begins nowhere takes several
        times as long to learn of the whole image as of the few pixels and the one altitude that bounds look at.
        """
        if not some.sunlit or not len(some):
            return np.ones(len(some), bool)
        return np.isfinite(bound_if_any(self._asked(some, POWER, some.power_limit_w)))

    def bound_within(self, some: Hopeful, limit_w: Array) -> Array:
        """The quality that no settings within a power exceed; -inf: there are none.

        By closed forms without hindrances; under the sun, by all settings of a design as one cell.
        """
        if self.quality is None:
            return np.zeros(len(some))
        if self.quality == "contrast":  # without the sun no setting changes it
            return -self._whole_bound(some, Objective({self.quality: 1.0}), limit_w * ABOVE)
        return self._most_quality(some, limit_w * ABOVE)

    def bounds_within(self, some: Hopeful, limits_w: Array) -> Array:
        """`bound_within` at several limits of each design, (n, k), nan: none; what no limit changes is found once."""
        if not some.sunlit and self.quality not in (None, "contrast"):
            return self._most_quality(some, limits_w * ABOVE)
        row, column = np.nonzero(np.isfinite(limits_w))  # side by side: what cells cost is calls more than columns
        bounds = np.full(limits_w.shape, np.nan)
        if len(row):
            bounds[row, column] = self.bound_within(some.take(row), limits_w[row, column])
        return bounds

    def most_snr_db(self, some: Hopeful, limit_w: Array) -> Array:
        """SNR that no settings within a power, (n,) or (n, k), exceed; -inf: there are none."""
        if some.sunlit:
            return -self._whole_bound(some, SNR, limit_w)
        camera_w = some.camera_power_w.reshape(-1, *[1] * (limit_w.ndim - 1))
        most = closed_form.greatest_snr(unhindered(some.rows), some.motorised, limit_w - camera_w)
        with np.errstate(divide="ignore"):
            return np.asarray(np.where(np.isfinite(most), ratio_to_db(np.where(most > 0, most, np.nan)), -np.inf))

    def _whole_bound(self, some: Hopeful, goal: Objective, limit_w: Array | float) -> Array:
        """What no settings of each design can beat for one goal, all of them as one cell; inf: there are none."""
        from uwopt.solvers.settings.cells import best_by_cells

        asked = self._asked(some, goal, np.minimum(limit_w, some.power_limit_w))
        return best_by_cells(asked, halve=False, points=False).bound(asked)

    def _most_quality(self, some: Hopeful, limit_w: Array) -> Array:
        """SNR, or the information that each scene's own SNR allows at most, within powers (n,) or (n, k)."""
        if self.quality == "snr_db":
            return self.most_snr_db(some, limit_w)
        best = np.full(limit_w.shape, np.inf)
        for index, scene in enumerate(some.rows):
            assert scene.sharp is not None
            most = self.most_snr_db(some.of_scene(index), limit_w)
            gain_db, pitch_px, area_m2 = (
                column.reshape(-1, *[1] * (most.ndim - 1)) for column in (
                    ratio_to_db(scene.sharp.texture_gain), scene.sharp.rated_pitch_px * scene.sharp.lens_blur("rms"),
                    scene.sharp.pixel_area_m2,
                )
            )  # fmt: skip
            bits = bit_per_px_bound(np.maximum(most, -1e3) + gain_db, pitch_px) / area_m2
            best = np.minimum(best, np.where(np.isfinite(most), bits, -np.inf))
        return best

    def drawn_in(self, some: Hopeful, bounds: Answers, which: Array, wanted: Array | float = -np.inf) -> Answers:
        """Some bounds of information drawn in: light of wide apertures does not come with the depth of small ones.

        wanted : (n,) or scalar, the quality below which a bound need not be close
        """
        counts = np.isfinite(bounds.bound[which]) & (bounds.bound[which] > 0)
        asked, enough = which[counts], np.broadcast_to(wanted, which.shape)[counts]
        if self.quality != "information" or len(asked) == 0:
            return bounds
        design, row = np.unique(bounds.design[asked], return_inverse=True)
        row = row.reshape(-1)
        starts = np.searchsorted(bounds.design, design)
        column = asked - starts[row]
        limits_w = np.full((len(design), int(column.max()) + 1), np.nan)
        limits_w[row, column] = bounds.limit_w[asked] * ABOVE
        least = np.full(limits_w.shape, np.inf)
        least[row, column] = enough
        works = [
            partial(most_information, some.take(design[part]), limits_w[part], least[part], self.most_snr_db)
            for part in shares(len(design), FEWEST_DRAWN)
        ]
        most = np.concatenate(side_by_side(works))
        bound = bounds.bound.copy()
        bound[asked] = np.fmin(bound[asked], most[row, column])
        return replace(bounds, bound=bound).drawn_in()


def _best_by_power(power_w: Array, quality: Array) -> Array:
    """Which of k settings of n designs (k, n) none of the same design beats for no more power; quality is rough."""
    worth = np.isfinite(power_w) & np.isfinite(quality)
    for mine_w, mine in zip(power_w, quality, strict=True):
        worth &= ~((mine_w <= power_w * ABOVE) & (mine > quality * (1.0 + GLANCE_REL)))
    return worth


def first_limits_w(some: Hopeful, least_w: Array) -> Array:
    """Powers of the lights at which curves are first known, (n, n_limits) rising, nan beyond the last.

    Evenly in the logarithm from the least to full power; of lamps whose power has steps, every step.
    """
    far = np.maximum(some.full_power_w - some.camera_power_w, least_w)
    near = np.maximum(least_w, DIMMEST * far)
    share = np.arange(1, LIMITS + 1) / LIMITS
    with np.errstate(invalid="ignore", divide="ignore"):
        even = np.where(near[:, None] > 0, near[:, None] * (far / near)[:, None] ** share, far[:, None])
    even[:, -1] = far
    inside = (even > least_w[:, None] * ABOVE) & (even * ABOVE < far[:, None])
    even = np.where(inside, even, np.nan)
    even[:, -1] = far
    stepped = some.stepped
    if not stepped.any():
        return even
    steps = np.concatenate([(r.levels * r.full_draw_w[:, None]).T + r.idle for r in some.rows]).T
    steps = np.where((steps >= least_w[:, None] / ABOVE) & (steps <= far[:, None] * ABOVE), steps, np.nan)
    steps = np.sort(np.where(np.isnan(steps), np.inf, steps), axis=1)
    width = max(LIMITS, steps.shape[1])
    limits = np.full((len(some), width), np.nan)
    limits[:, :LIMITS] = even
    limits[stepped] = np.nan
    limits[stepped, : steps.shape[1]] = np.where(np.isfinite(steps), steps, np.nan)[stepped]
    return limits
