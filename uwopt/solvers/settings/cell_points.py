"""Points inside boxes of settings, tried as answers: at fixed patterns, where tangents are best, and polished.

Level and gain have closed forms at fixed f-number and times: least light for power, most for quality.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.settings.cell_bounds import Box, Points, Reach
from uwopt.solvers.settings.cell_pool import BoundedCells, Pool, pixel_area_m2
from uwopt.solvers.settings.cell_tangent import (
    typical_bit_per_px,
)
from uwopt.units import ratio_to_db

LIKELY = 24  # points of a design at a time whose information is worked out
MOST_POINTS = 4096  # tried at a time
LEAST_SCALE = 0.1  # of the terms' sum: a sum near 0 has no relative gap
#: Directions in ln f-number and ln time in which settings are polished: both alone, and with the same light.
TOWARDS = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 2.0]])
INSIDE = 1e-8  # of ln f-number: beside a corner of what light allows, where there is enough or no more than that
WIDEST, NARROWER, MOST_STEP = 0.3, 0.2, 2.0  # steps: at first, how much shorter at a time, and towards a parabola's top


class TriedCells(BoundedCells):
    """The same, with points that are tried in them and kept where they are better than what was known."""

    @cached_property
    def near_by(self) -> Array:
        """Steps that are tried beside the best settings of each design, (n,)."""
        return np.full(self.n, WIDEST)

    def _try_points(
        self, pool: Pool, seen: list[tuple[Box, Reach]], patterns: list[tuple[float, float]]
    ) -> None:
        """Points of the cells as answers."""
        if len(pool.design) == 0:
            return
        kinds = [(a, b, share) for a, b in patterns for share in self.share]
        together = max(1, MOST_POINTS // len(pool.design))  # numbers are few, calls are dear
        for start in range(0, len(kinds), together):
            some = np.array(kinds[start : start + together])
            left = np.flatnonzero(self.best[pool.design] > pool.bound)  # where a point may still better what is known
            if not len(left):
                return
            cell = np.tile(left, len(some))
            a, b, share = np.repeat(some, len(left), axis=0).T
            each = pool.take(cell)
            f_numbers: dict[int, Array] = {}
            points = []
            for s, (box, _) in enumerate(seen):
                dim = self.n_dim[s]
                f_numbers.setdefault(dim, np.exp(each.lo[:, dim] + a * (each.hi[:, dim] - each.lo[:, dim])))
                points.append(self._points_in(each, s, box.take(cell), f_numbers[dim], b, share))
            self._keep(each.design, points)

    def _points_in(self, pool: Pool, s: int, box: Box, f_number: Array, place: Array, share: Array) -> Points:
        """Points at these f-numbers and a place in the times, drawn back to where the image is sharp."""
        scene, d = self.scenes[s], pool.design
        time = box.t_lo * (box.t_hi / box.t_lo) ** place
        sharp = scene.sharp_time_s(d, f_number, f_number, safe=True)
        open_s = time
        if not self.sunlit[s]:
            lit = scene.within_s(d, sharp)
            time = np.where(lit >= box.t_lo, np.minimum(time, lit), time)
            if self.information and not self.mixed:
                time = scene.brightly_s(d, f_number, time, box.u_hi)
            open_s = time
        else:
            free = scene.freely_open(d, time)
            unfilled = np.minimum(sharp, scene.filled_s(d, f_number, time, box.u_lo, box.u_hi))
            lit = scene.within_s(d, unfilled)
            time = np.where(~free & (lit >= box.t_lo), np.minimum(time, lit), time)
            least, most = scene.open_range_s(d, time, box.t_hi)
            wanted = box.open_lo * (box.open_hi / box.open_lo) ** np.where(share > 0.0, place, 1.0 - place)
            wanted = np.minimum(np.minimum(np.maximum(wanted, least), unfilled), most)
            open_s = np.where(free, np.maximum(wanted, least), scene.opened_s(d, time))
        return scene.points(d, f_number, time, open_s, box.u_lo, box.u_hi, share)

    def _polish(self, design: Array) -> None:
        """Move these designs' best settings to the tops of parabolas through points on both sides, in every direction.

        Halving alone doubles what is known of the best settings by two rounds each; a parabola by one.
        """
        low, high = (side[design, :2] for side in self.range)
        start, before, width = self._near(0, design), self.best[design], self.near_by[design]

        def tried(steps: Array) -> tuple[Array, Array]:
            """Values (k, m) at steps (k, m, 2) from the best settings, and how much of each step the range allows."""
            place = np.clip(start + steps, low, high)
            share = np.abs(place - start).max(axis=2) / np.abs(steps).max(axis=2)
            return self._at_places(np.tile(design, len(steps)), place.reshape(-1, 2)).reshape(len(steps), -1), share

        sides = TOWARDS[:, None, :] * width[:, None]
        value, share = tried(np.concatenate([sides, -sides]))
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = np.split(share, 2)
            up, down = ((end - before) / length for end, length in zip(np.split(value, 2), (a, b), strict=True))
            bend = (up + down) / (a + b)
            top = (bend * a - up) / (2.0 * bend)
        top = np.where(np.isfinite(top) & (bend > 0.0), np.clip(top, -MOST_STEP, MOST_STEP), 0.0)
        tried(np.where(top == 0.0, 1e-9, top)[:, :, None] * sides)
        rose = np.abs(self._near(0, design) - start).max(axis=1)
        self.near_by[design] = np.clip(rose, NARROWER * width, width)

    def _unknown(self, pool: Pool) -> Array:
        """Cells in which points are tried at large: of settings that are two numbers only until some are found."""
        return np.isinf(self.best[pool.design]) | (not self._two_numbers)

    @property
    def _two_numbers(self) -> bool:
        """Whether f-number and time of one scene are all that settings need for information."""
        return bool(self.information) and self.n_dims == 2 and not any(self.sunlit)

    def _at_places(self, design: Array, place: Array, sides: int = 1) -> Array:
        """Values of designs at f-numbers and times, (m,), by their logarithms (m, 2).

        `sides` : how many parts of the list are sides of one place, of which the first that fits stands for all
        """
        low, high = (side[design] for side in self.range)
        place = np.clip(place, low, high)
        pool = Pool(design, place, place, np.zeros(len(design)))
        point = self._points_in(pool, 0, self._box(pool, 0), np.exp(place[:, 0]), np.zeros(len(design)), np.ones(1))
        if sides > 1:
            fits = point.fits.reshape(sides, -1)
            fits[1:] &= ~np.logical_or.accumulate(fits)[:-1]
        return self._keep(design, [point])

    def _try_places(self, design: Array, place: Array) -> None:
        """Where the tangents of cells say that most could be: at a corner of what is allowed it is the best itself."""
        if len(design):
            sides = [place + np.array([side, 0.0]) for side in (-INSIDE, INSIDE)]
            self._at_places(np.tile(design, 2), np.concatenate(sides), sides=2)

    # ------------------------------------------------------------ what is kept

    def _keep(self, design: Array, points: list[Points]) -> Array:
        """Remember the points that beat what their designs had; their values, inf of those that were not looked at."""
        values = np.full(len(design), np.inf)
        fits = np.logical_and.reduce([p.fits for p in points])
        if self.mean_limit is not None:
            fits &= self.mean_limit.met_by([p.chosen for p in points], self.camera_power_w[design])
        index = np.nonzero(fits)[0]
        if len(index) == 0:
            return values
        d = design[index]
        power = np.max([p.chosen.light_power_w[index] for p in points], axis=0)
        snr = np.min([p.snr[index] for p in points], axis=0)
        contrast = np.min([p.contrast[index] for p in points], axis=0)
        information: Array | float = 0.0
        if self.information:
            # Information is dear: only the points that look best by a stand-in.
            few = self._likely(d, index, points, power, snr, contrast)
            index, d, power, snr, contrast = index[few], d[few], power[few], snr[few], contrast[few]
            information = np.min([self._information(s, d, index, p) for s, p in enumerate(points)], axis=0)
        value = self._value(power, snr, contrast, information) + self.offset[d]
        values[index] = value
        order = np.lexsort((points[0].chosen.f_number[index], value, d))
        first = np.unique(d[order], return_index=True)[1]
        pick = order[first]
        better = value[pick] < self.best[d[pick]]
        pick = pick[better]
        self.best[d[pick]] = value[pick]
        self.scale[d[pick]] = self._scale(d, value, power, snr, contrast, information)[pick]
        for kept, p in zip(self.kept, points, strict=True):
            for name, column in kept.items():
                column[d[pick]] = getattr(p.chosen, name)[index[pick]]
        self.figures["snr_db"][d[pick]] = ratio_to_db(np.maximum(snr[pick], 1e-300))
        self.figures["contrast"][d[pick]] = contrast[pick]
        if self.information:
            self.figures["information"][d[pick]] = np.asarray(information)[pick]
        return values

    def _scale(
        self, d: Array, value: Array, power: Array, snr: Array, contrast: Array, information: Array | float
    ) -> Array:
        """What the gap is relative to: the value, but no less than a share of its terms."""
        if self.objective.quality:
            return self.objective.scale(value)
        parts = [power * self.weight["power"], *(abs(self._value(0.0 * power, *figures)) for figures in (
            (snr, 0.0, 0.0), (np.ones_like(snr), contrast, 0.0), (np.ones_like(snr), 0.0, information)))]  # fmt: skip
        whole = np.abs(self.offset[d]) + np.sum(parts, axis=0)
        return np.maximum(np.abs(value), LEAST_SCALE * whole)

    def _likely(
        self, d: Array, index: Array, points: list[Points], power: Array, snr: Array, contrast: Array
    ) -> Array:
        """Places of the few points of each design that look best."""
        guess = []
        for s, p in enumerate(points):
            scene, f_number, blur = self.scenes[s], p.chosen.f_number[index], p.blur_s[index]
            bits = typical_bit_per_px(scene, d, p.snr[index], f_number, f_number, blur)
            guess.append(bits / pixel_area_m2(self.rows[s])[d])
        value = self._value(power, snr, contrast, np.min(guess, axis=0))
        order = np.lexsort((value, d))
        starts = np.searchsorted(d[order], d[order])
        return np.asarray(order[np.arange(len(order)) - starts < LIKELY])

    def _information(self, s: int, d: Array, index: Array, p: Points) -> Array:
        """Bit per m2 of points."""
        f_number = p.chosen.f_number[index]
        bits = self.information[s].value(
            d, p.snr[index], f_number=f_number, working=f_number * self.rows[s].working_factor[d],
            blur_s=p.blur_s[index],
        )  # fmt: skip
        return np.asarray(bits / pixel_area_m2(self.rows[s])[d])
