"""Boxes of settings of many designs: which there are, what no point inside can beat, and into which halves they come.

The logarithms of f-number, light-collecting time, open shutter and (where a sum holds power against quality)
light level span a box for every design.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import spend
from uwopt.forward.columns import Columns
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.scene_rows import SceneRows
from uwopt.solvers.settings.cell_bounds import Box, Reach, SceneCells
from uwopt.solvers.settings.cell_information import Information
from uwopt.solvers.settings.cell_start import likely_settings
from uwopt.solvers.settings.cell_tangent import (
    DIMMEST,
    quality_bound,
    surrogate_bit_per_px,
)
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.question import Question
from uwopt.solvers.settings.windows import nominal_contrast
from uwopt.units import ratio_to_db

QUALITIES = ("snr_db", "contrast", "information")
SMALLEST = 1e-12  # width of a side in logarithms
SOON = 20  # cells of a design: most of those that do not fit are known by then
TELLS = 0.02  # of the most that halving some side lifts the bounds
THINNEST = 8.0  # times as wide as the widest side that tells: halved all the same


@dataclass(frozen=True)
class Pool(Columns):
    """Cells: their design, box in logarithms (m, n_dims) and lower bound."""

    design: Array
    lo: Array
    hi: Array
    bound: Array


class BoundedCells:
    """Boxes of designs that have the same dimensions, with their bounds; and the best settings known of each."""

    def __init__(self, question: Question, *, own_f_number: bool):
        """`own_f_number`: each scene has one, else they share it."""
        rows, objective, constant = question.rows, question.objective, question.constant
        self.near, self.deadline, self.hardware = question.near, question.deadline, question.hardware
        self.rows, self.constant, self.cutoff = rows, constant, question.cutoff
        self.most_cells = question.most_cells
        self.top, self.mean_limit, self.camera_power_w = question.top, question.mean_limit, question.camera_power_w
        self.n = len(question)
        self.scenes = [SceneCells(r, question.light_limit_w) for r in rows]
        self.sunlit = [r.sunlit for r in rows]
        weight = {name: objective.weight(name) for name in ("power", *QUALITIES)}
        if weight["contrast"] and not any(self.sunlit):  # no setting changes that of the lamps
            share = np.min([nominal_contrast(r) for r in rows], axis=0)
            constant = self.constant = constant - weight["contrast"] * share
            weight["contrast"] = 0.0
        self.power_decides = not any(weight.values())  # among equals
        self.weight = {**weight, "power": 1.0} if self.power_decides else weight
        self.offset = np.zeros(self.n) if self.power_decides else constant
        quality = any(self.weight[q] for q in QUALITIES)
        traded = bool(self.weight["power"]) or self.mean_limit is not None  # the level is no matter of course
        self.mixed = quality and (traded or any(self.sunlit))
        self.share = (0.0, 0.5, 1.0) if self.mixed else (1.0,) if quality else (0.0,)
        self.objective = objective
        self.gap = question.gap_rel * (0.3 if self.weight["information"] and not objective.by_ratio else 0.99)
        self.any_will_do = bool(np.isinf(question.gap_rel))
        self.information: list[Information] = []
        if self.weight["information"]:
            assert all(r.sharp is not None for r in rows)
            self.information = [Information(r.sharp) for r in rows if r.sharp is not None]
        self._dimensions(own_f_number)
        self.best = np.full(self.n, np.inf)
        self.start = np.full((self.n, self.n_dims), np.nan)  # where designs look best, until something is found
        self.hopeful = np.empty((0, 2))  # ln f-number and ln time of the last cells where their tangents are best
        self.scale = np.zeros(self.n)  # what the gap is relative to
        self.closed = np.full(self.n, np.inf)
        self.dropped = np.zeros(self.n, bool)
        self.taken = np.zeros(self.n, int)  # halves, by design
        self.kept: list[dict[str, Array]] = [
            {f.name: np.full(self.n, np.nan) for f in fields(Chosen)} for _ in rows
        ]
        self.figures = {name: np.full(self.n, np.nan) for name in QUALITIES}

    # ------------------------------------------------------------ boxes

    def _dimensions(self, own_f_number: bool) -> None:
        """Which coordinate is whose: f-number, time, open shutter, level, by scene."""
        count = 0
        self.n_dim, self.t_dim, self.open_dim, self.u_dim = [], [], [], []
        for s, rows in enumerate(self.rows):
            if s == 0 or own_f_number:
                shared, count = count, count + 1
            self.n_dim.append(shared)
            self.t_dim.append(count)
            count += 1
            self.open_dim.append(-1)
            if self.sunlit[s] and np.any(rows.kind != CONTINUOUS):
                self.open_dim[s], count = count, count + 1
            self.u_dim.append(-1)
            if self.mixed:
                self.u_dim[s], count = count, count + 1
        self.n_dims = count

    def _roots(self) -> Pool:
        """The whole box of every design, cut where a formula has a kink."""
        lo, hi = np.zeros((self.n, self.n_dims)), np.zeros((self.n, self.n_dims))
        alive = (self.constant <= self.cutoff) | (not self.power_decides)
        self.dropped |= ~alive
        self.closed = np.where(alive, self.closed, 0.0)
        for dim in set(self.n_dim):
            mine = [r for r, d in zip(self.rows, self.n_dim, strict=True) if d == dim]
            low, high = np.max([r.n_low for r in mine], axis=0), np.min([r.n_high for r in mine], axis=0)
            alive &= (low <= high * (1 + 1e-12)) & np.isfinite(low) & (low > 0)
            lo[:, dim], hi[:, dim] = _logs(low, high)
        for s, rows in enumerate(self.rows):
            usable = (rows.time_min_s <= rows.time_max_s * (1 + 1e-12)) & (rows.time_max_s > 0)
            alive &= usable
            lo[:, self.t_dim[s]], hi[:, self.t_dim[s]] = _logs(rows.time_min_s, rows.time_max_s)
            scene = self.scenes[s]
            if self.open_dim[s] >= 0:
                every = np.arange(self.n)
                least, _ = scene.open_range_s(every, rows.time_min_s, rows.time_max_s)
                _, most = scene.open_range_s(every, rows.time_max_s, rows.time_max_s)
                lo[:, self.open_dim[s]], hi[:, self.open_dim[s]] = _logs(least, most)
                alive &= least <= most * (1 + 1e-12)
            elif self.sunlit[s] and rows.open_max_s is not None:
                most = np.minimum(np.exp(hi[:, self.t_dim[s]]), rows.open_max_s)
                alive &= rows.time_min_s <= most * (1 + 1e-12)
                hi[:, self.t_dim[s]] = np.maximum(np.log(np.maximum(most, 1e-300)), lo[:, self.t_dim[s]])
            if self.u_dim[s] >= 0:
                alive &= scene.u_max > 0
                floor = np.maximum(scene.u_min, DIMMEST * scene.u_max)
                lo[:, self.u_dim[s]], hi[:, self.u_dim[s]] = _logs(floor, scene.u_max)
        self.range = lo, hi
        index = np.nonzero(alive)[0]
        pool = Pool(index, lo[index], hi[index], np.full(len(index), -np.inf))
        for s, rows in enumerate(self.rows):
            pool = self._cut_at_kinks(pool, s, rows)
        return pool

    def _cut_at_kinks(self, pool: Pool, s: int, rows: SceneRows) -> Pool:
        """A duty of 1 of pulsed LEDs and of lamps off between images, the time from which their mean power is capped,
        a flash's whole duration."""
        dim = self.t_dim[s]
        with np.errstate(divide="ignore", invalid="ignore"):
            on_s = np.where(rows.timed, 1.0 / rows.rate_hz, np.nan)  # at a duty of 1
            leads_s, share = self.scenes[s].leads_s, self.scenes[s].share / self.scenes[s].u_max
            full, capped = np.log(on_s - leads_s), np.log(on_s * share - leads_s)
        for kink in (full, capped):
            at = kink[pool.design]
            inside = (at > pool.lo[:, dim] + 1e-12) & (at < pool.hi[:, dim] - 1e-12)
            first, second = pool.take(inside), pool.take(inside)
            first.hi[:, dim], second.lo[:, dim] = at[inside], at[inside]
            pool = Pool.joined([pool.take(~inside), first, second])
        if self.sunlit[s]:
            at = np.log(rows.flash.full_s)[pool.design]
            flash = (
                (rows.kind == FLASH)[pool.design]
                & (pool.hi[:, dim] >= at - 1e-9)
                & (pool.lo[:, dim] < at - 1e-9)
            )
            cut, whole = pool.take(flash), pool.take(flash)
            cut.hi[:, dim] = at[flash] - 2e-9
            whole.lo[:, dim] = whole.hi[:, dim] = at[flash]
            pool = Pool.joined([pool.take(~flash), cut, whole])
        return pool

    def _box(self, pool: Pool, s: int) -> Box:
        """Settings of cells in one scene."""
        scene, d = self.scenes[s], pool.design
        n, t, o, u = self.n_dim[s], self.t_dim[s], self.open_dim[s], self.u_dim[s]
        t_lo, t_hi = np.exp(pool.lo[:, t]), np.exp(pool.hi[:, t])
        open_lo, open_hi = (t_lo, t_hi) if o < 0 else (np.exp(pool.lo[:, o]), np.exp(pool.hi[:, o]))
        if o >= 0:
            burning = ~scene.freely_open(d, t_lo)
            cut_lo, cut_hi = scene.opened_s(d, t_lo), scene.opened_s(d, t_hi)
            open_lo, open_hi = np.where(burning, cut_lo, open_lo), np.where(burning, cut_hi, open_hi)
        u_lo, u_hi = scene.u_min[d], scene.u_max[d]
        if u >= 0:
            dimmest = pool.lo[:, u] <= np.log(DIMMEST * u_hi) + 1e-9
            u_lo, u_hi = np.where(dimmest, u_lo, np.exp(pool.lo[:, u])), np.exp(pool.hi[:, u])
        return Box(
            np.exp(pool.lo[:, n]), np.exp(pool.hi[:, n]), t_lo, t_hi, open_lo, open_hi, u_lo, u_hi
        )  # fmt: skip

    # ------------------------------------------------------------ bounds

    def _reached(self, pool: Pool) -> tuple[Pool, list[tuple[Box, Reach]]]:
        """Cells that may hold a feasible point, shrunk to it, and what they reach by scene."""
        alive = np.ones(len(pool.design), bool)
        seen = []
        for s, scene in enumerate(self.scenes):
            box, fits = scene.tightened(pool.design, self._box(pool, s))
            reach = scene.reach(pool.design, box)
            alive &= fits & reach.alive
            if not self.sunlit[s]:
                box = self._opened(pool, s, box, reach)
            pool.lo[:, self.t_dim[s]], pool.hi[:, self.t_dim[s]] = np.log(box.t_lo), np.log(box.t_hi)
            if self.open_dim[s] >= 0:
                pool.lo[:, self.open_dim[s]] = np.log(box.open_lo)
                pool.hi[:, self.open_dim[s]] = np.log(box.open_hi)
            if self.u_dim[s] >= 0:
                u_lo = np.where(reach.u_lo > box.u_lo, reach.u_lo * (1 - 1e-13), 0.0)
                u_hi = np.where(np.isfinite(reach.u_hi), reach.u_hi, 0.0) * (1 + 1e-13)
                lo, hi = pool.lo[:, self.u_dim[s]], pool.hi[:, self.u_dim[s]]
                lo = np.minimum(np.maximum(lo, np.log(np.clip(u_lo, 1e-300, 1.0))), hi)
                hi = np.maximum(np.minimum(hi, np.log(np.maximum(u_hi, 1e-300))), lo)
                pool.lo[:, self.u_dim[s]], pool.hi[:, self.u_dim[s]] = lo, hi
                box = replace(box, u_lo=np.clip(np.maximum(box.u_lo, u_lo), 0.0, box.u_hi))
            seen.append((box, reach))
        if self.mean_limit is not None:
            alive &= self.mean_limit.holds([r.power_w for _, r in seen], self.camera_power_w[pool.design])
        index = np.nonzero(alive)[0]
        return pool.take(index), [
            (box.take(index), reach.take(index)) for box, reach in seen
        ]

    def _opened(self, pool: Pool, s: int, box: Box, reach: Reach) -> Box:
        """The box without f-numbers and times that leave too little of the lamps' light."""
        rows, d, dim = self.rows[s], pool.design, self.n_dim[s]
        with np.errstate(divide="ignore", invalid="ignore"):
            light = rows.light_lm[d] * reach.u_hi / np.square(rows.working_factor[d])
            most = np.sqrt(light * box.t_hi / reach.x_lo) * (1.0 + 1e-12)
            least_s = reach.x_lo * np.square(box.n_lo) / light * (1.0 - 1e-12)
        most = np.where(np.isfinite(most), np.clip(most, box.n_lo, box.n_hi), box.n_hi)
        enough = np.isfinite(least_s) & bool(self.information)  # no other bound gets closer by it
        least_s = np.where(enough, np.clip(least_s, box.t_lo, box.t_hi), box.t_lo)
        pool.hi[:, dim] = np.clip(np.log(most), pool.lo[:, dim], pool.hi[:, dim])
        return replace(box, n_hi=most, t_lo=least_s)

    def _value(self, power: Array, snr: Array, contrast: Array | float, information: Array | float) -> Array:
        """The settings' part of the objective."""
        w = self.weight
        total = w["power"] * power
        if w["snr_db"]:
            total = total - w["snr_db"] * ratio_to_db(np.maximum(snr, 1e-300))
        if w["contrast"]:
            total = total - w["contrast"] * contrast
        if w["information"]:
            total = total - w["information"] * self.objective.counted("information", information)
        return np.asarray(total)

    def _bounded(self, pool: Pool) -> tuple[Pool, list[tuple[Box, Reach]]]:
        """Cells that are alive, with a lower bound each."""
        spend("cells", len(pool.design))
        pool, seen = self._reached(pool)
        d = pool.design
        if len(d) == 0:
            return pool, seen
        power, snr, contrast = over_scenes(seen)
        information: Array | float = 0.0
        joint = np.full(len(d), -np.inf)
        tangents = bool(self.weight["information"]) or (self.mixed and not any(self.sunlit))
        if tangents:
            info: list[Information | None] = [*self.information] or [None for _ in self.rows]
            found = [
                quality_bound(
                    self.scenes[s], info[s], d, box, reach, self.weight, mixed=self.mixed,
                    by_ratio=self.objective.by_ratio, near=self._near(s, d),
                )
                for s, (box, reach) in enumerate(seen)
            ]
            if self.weight["information"]:
                information = np.min([f[0] for f in found], axis=0)
            joint = np.max([f[1] for f in found], axis=0) - self.weight["contrast"] * contrast
            self.hopeful = found[0][2]
        bound = np.maximum(self._value(power, snr, contrast, information), joint)
        return replace(pool, bound=np.maximum(pool.bound, bound + self.offset[d])), seen

    def _near(self, s: int, design: Array) -> Array:
        """Ln f-number and ln time, under the sun of the open shutter, of the best settings so far, (m, 2); of those
        that look best where there are none, nan where that is not known either."""
        kept = self.kept[s]
        time_s = kept["time_s"] if not self.sunlit[s] else kept["exposure_s"] + self.rows[s].exposure_offset_s
        with np.errstate(divide="ignore"):
            found = np.log(np.stack([kept["f_number"][design], time_s[design]], axis=1))
        return np.where(np.isnan(found), self.start[design][:, [self.n_dim[s], self.t_dim[s]]], found)

    def _looks_best(self, roots: Pool) -> Array:
        """Where designs look best by the stand-in for information, (n, n_dims); nan where that is not sought."""
        if not self.information or self.mixed or any(self.sunlit) or len(roots.design) == 0:
            return self.start
        start = self.start if self.near is None or self.n_dims > 2 else np.log(self.near)
        unknown: Array = np.asarray(np.isnan(start).any(axis=1))
        roots = roots.take(unknown[roots.design])
        if len(roots.design) == 0:
            return start

        def cheap(design: Array, place: Array) -> tuple[Array, Array]:
            return self._cheap(Pool(design, place.copy(), place.copy(), np.arange(len(design), dtype=float)))

        return np.where(np.isnan(start), likely_settings(
            self.n, roots.design, roots.lo, roots.hi, self.n_dim, cheap
        ), start)  # fmt: skip

    # ------------------------------------------------------------ halves

    def _halved(self, pool: Pool) -> Pool:
        """Both halves of each cell, along the side that tells most."""
        width = pool.hi - pool.lo
        point: Array = np.asarray((width <= SMALLEST).all(axis=1))  # all told that can be
        np.minimum.at(self.closed, pool.design[point], pool.bound[point])
        pool, width = pool.take(~point), width[~point]
        m = len(pool.design)
        if m == 0:
            return pool
        lens = np.isin(np.arange(self.n_dims), self.n_dim)
        scaled = width * np.where(lens, 2.0, 1.0)
        # How long the shutter is open beside a pulse tells least.
        side = np.where(np.isin(np.arange(self.n_dims), self.open_dim), scaled / THINNEST, scaled).argmax(axis=1)
        # Where nothing is known to fit most cells of bounds soon die: at first what tells is dearer than halves.
        soon = (self.any_will_do or self.rows[0].optimistic) & np.isinf(self.best) & (self.taken < SOON)
        told = np.flatnonzero(~soon[pool.design])
        if len(told) and np.count_nonzero(width[told].max(axis=0) > 0) > 1:
            side[told] = self._telling(pool.take(told), scaled[told], lens)
        middle = 0.5 * (pool.lo + pool.hi)
        at = np.arange(m)
        left = Pool(pool.design, pool.lo.copy(), pool.hi.copy(), pool.bound.copy())
        right = Pool(pool.design, pool.lo.copy(), pool.hi.copy(), pool.bound.copy())
        left.hi[at, side] = middle[at, side]
        right.lo[at, side] = middle[at, side]
        return Pool.joined([left, right])

    def _telling(self, pool: Pool, scaled: Array, lens: Array) -> Array:
        """The side of each cell whose halves tell most; `scaled`: how wide its sides count, which are f-numbers'."""
        score = self._gains(pool, np.flatnonzero(scaled.max(axis=0) > 0).tolist())
        # Where a half dies at once the side counts as much as the best of the others.
        dies = np.isnan(score)
        most = np.where(dies, 0.0, score).max(axis=1)[:, None]
        score = np.where(dies, np.where(most > 0, most, 1.0), score)
        # Sides that tell little are left alone; of the others the widest, or slivers would never be told apart.
        tells = score > TELLS * score.max(axis=1)[:, None]
        # Sharpness rules settings out and lifts no bound: no cell gets so thin that it never sees the f-number.
        tells |= lens & (scaled > THINNEST * np.where(tells, scaled, 0.0).max(axis=1)[:, None])
        return np.asarray(np.where(tells, scaled, 1e-6 * scaled).argmax(axis=1))

    def _gains(self, pool: Pool, dims: list[int]) -> Array:
        """By how much halving each of these sides lifts the bounds of both halves, by a cheap measure, (m, n_dims).

        NaN where a half dies. All halves are measured together: numbers are few, calls are dear.
        """
        m, middle = len(pool.design), 0.5 * (pool.lo + pool.hi)
        parts = 1 + 2 * len(dims)
        lo, hi = np.tile(pool.lo, (parts, 1)), np.tile(pool.hi, (parts, 1))
        for place, dim in enumerate(dims):
            left = slice((1 + 2 * place) * m, (2 + 2 * place) * m)
            right = slice((2 + 2 * place) * m, (3 + 2 * place) * m)
            hi[left, dim] = lo[right, dim] = middle[:, dim]
        # Cells are told apart by their place, kept in the bound.
        every = Pool(np.tile(pool.design, parts), lo, hi, np.arange(parts * m, dtype=float))
        kept, seen = self._cheap(every)
        value = np.full(parts * m, np.nan)
        value[kept] = seen
        whole, *halves = value.reshape(parts, m)
        whole = np.nan_to_num(whole, nan=0.0)
        scale = np.abs(whole) + 1e-30
        score = np.zeros((m, self.n_dims))
        for place, dim in enumerate(dims):
            score[:, dim] = ((halves[2 * place] - whole) + (halves[2 * place + 1] - whole)) / scale
        return score

    def _cheap(self, pool: Pool) -> tuple[Array, Array]:
        """Which cells are alive and their bound with a stand-in for information."""
        kept, seen = self._reached(pool)
        alive = kept.bound.astype(int)
        if len(alive) == 0:
            return alive, np.empty(0)
        power, snr, contrast = over_scenes(seen)
        information: Array | float = 0.0
        if self.weight["information"]:
            information = np.min([
                surrogate_bit_per_px(self.scenes[s], kept.design, box, reach) / pixel_area_m2(self.rows[s])[kept.design]
                for s, (box, reach) in enumerate(seen)
            ], axis=0)  # fmt: skip
        return alive, self._value(power, snr, contrast, information)


def _logs(low: Array, high: Array) -> tuple[Array, Array]:
    """Logarithms of a range, at least a point."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a = np.log(np.maximum(low, 1e-300))
        b = np.log(np.maximum(high, 1e-300))
    return a, np.maximum(a, b)


def over_scenes(seen: list[tuple[Box, Reach]]) -> tuple[Array, Array, Array]:
    """Power, SNR and contrast of boxes, each as in the scene that decides, (m,)."""
    power_w = np.max([reach.power_w for _, reach in seen], axis=0)
    snr, contrast = (np.min([getattr(reach, name) for _, reach in seen], axis=0) for name in ("snr", "contrast"))
    return power_w, snr, contrast


def pixel_area_m2(rows: SceneRows) -> Array:
    """Floor of one pixel."""
    assert rows.sharp is not None
    return rows.sharp.pixel_area_m2
