"""Best settings with a proven gap where no closed form holds: sharpness, information, sunlight.

The logarithms of f-number, light-collecting time, open shutter and (where a sum holds power against quality)
light level span a box for every design. Boxes of all designs are bounded and halved together; points inside
give values to beat. What bounds are left when boxes are dropped bounds the truth from below, so an answer is
optimal to its gap, and a design whose boxes have all died is infeasible.

Level and gain have closed forms at fixed f-number and times: least light for power, most for quality.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.columns import Columns
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.setting_rows import SceneRows
from uwopt.model.information import RULE_ERROR
from uwopt.objectives.objective import LEAST, Objective
from uwopt.solvers.settings.cell_bounds import Box, Points, Reach, SceneCells
from uwopt.solvers.settings.cell_information import Information
from uwopt.solvers.settings.cell_start import likely_places
from uwopt.solvers.settings.cell_tangent import (
    DIMMEST,
    quality_bound,
    surrogate_bit_per_px,
    typical_bit_per_px,
)
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.mean_limit import MeanLimit
from uwopt.solvers.settings.windows import nominal_contrast
from uwopt.units import ratio_to_db

Array = NDArray[Any]
QUALITIES = ("snr_db", "contrast", "information")
BATCH = 4096  # cells halved at a time
MOST_CELLS = 30_000  # bounded in one call, beside FEWEST a design
FEWEST = 4_000
PATTERNS = (
    (0.0, 1.0), (0.5, 0.5), (0.0, 0.5), (0.5, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0), (1.0, 0.5), (0.5, 0.0),
)  # fmt: skip
SMALLEST = 1e-12  # width of a side in logarithms
LIKELY = 24  # points of a design at a time whose information is worked out
MOST_POINTS = 4096  # tried at a time
TELLS = 0.02  # of the most that halving some side lifts the bounds
THINNEST = 8.0  # times as wide as the widest side that tells: halved all the same
LEAST_SCALE = 0.1  # of the terms' sum: a sum near 0 has no relative gap
NEAR = 1e-9  # relative, of ties
#: Directions in ln f-number and ln time in which settings are polished: both alone, and with the same light.
TOWARDS = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 2.0]])
INSIDE = 1e-8  # of ln f-number: beside a corner of what light allows, where there is enough or no more than that
WIDEST, NARROWER, MOST_STEP = 0.3, 0.2, 2.0  # steps: at first, how much shorter at a time, and towards a parabola's top
POLISHED, LATER = 4, 2  # rounds after which settings are polished no more, and that of designs not known to be wanted


@dataclass(frozen=True)
class CellResult:
    """Best settings found of n designs, and how good any could be."""

    chosen: list[Chosen]
    feasible: Array
    snr_db: Array
    contrast: Array  # image mean at the nominal altitude, worst scene, as the other two
    information: Array  # bit/m2, nan where not asked for
    lower_bound: Array  # of the minimised objective, constants included; inf: proven infeasible
    dropped: Array  # some of it was left unsearched, being worse than the cutoff


@dataclass(frozen=True)
class Pool(Columns):
    """Cells: their design, box in logarithms (m, n_dims) and lower bound."""

    design: Array
    lo: Array
    hi: Array
    bound: Array


def best_by_cells(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array,
    power_limit_w: float | Array, *,
    gap_rel: float = 1e-4, constant: Array | float = 0.0, cutoff: float | Array = np.inf, hardware: Array | None = None,
    top: int | None = None, mean_limit: MeanLimit | None = None, halve: bool = True, points: bool = True,
) -> CellResult:  # fmt: skip
    """Best settings of n designs to a relative gap of the objective, worst scene.

    `constant` : (n,) of the minimised objective, what no setting changes, the camera's power too. Designs that
    cannot get below `cutoff`, common or each its own, are dropped;
    with `top`, neither are those that `top` others (of other `hardware`,
    an index a design) surely beat. Without `halve` boxes are bounded as a whole, and without `points` none is tried.
    """
    n = len(motorised)
    groups = [np.arange(n)]
    if len(rows) > 1:
        groups = [g for g in (np.nonzero(motorised)[0], np.nonzero(~motorised)[0]) if len(g)]
    fixed = np.broadcast_to(np.asarray(constant, float), (n,))
    light_limit_w = np.broadcast_to(power_limit_w - camera_power_w, (n,))
    ceiling = np.broadcast_to(np.asarray(cutoff, float), (n,))
    camera = np.broadcast_to(np.asarray(camera_power_w, float), (n,))
    results = []
    for mine in groups:
        search = CellSearch(
            [r.take(mine) for r in rows], objective, light_limit_w[mine],
            own_f_number=len(rows) > 1 and bool(motorised[mine[0]]), gap_rel=gap_rel, constant=fixed[mine],
            cutoff=ceiling[mine], hardware=None if hardware is None else hardware[mine], top=top,
            mean_limit=mean_limit, camera_power_w=camera[mine],
        )  # fmt: skip
        results.append(search.run(halve=halve, points=points))
    return results[0] if len(results) == 1 else merged(groups, results, n)


def merged(groups: list[Array], results: list[CellResult], n: int) -> CellResult:
    """Results of groups of designs, each design in its place."""

    def column(parts: list[Array]) -> Array:
        out = np.empty(n, parts[0].dtype)
        for mine, part in zip(groups, parts, strict=True):
            out[mine] = part
        return out

    chosen = [
        Chosen(**{f.name: column([getattr(r.chosen[s], f.name) for r in results]) for f in fields(Chosen)})
        for s in range(len(results[0].chosen))
    ]
    rest = {
        f.name: column([getattr(r, f.name) for r in results])
        for f in fields(CellResult)
        if f.name != "chosen"
    }
    return CellResult(chosen=chosen, **rest)


class CellSearch:
    """State of one search over the settings of designs that have the same dimensions."""

    def __init__(
        self, rows: list[SceneRows], objective: Objective, light_limit_w: Array, *, own_f_number: bool,
        gap_rel: float, constant: Array, cutoff: Array, hardware: Array | None, top: int | None,
        mean_limit: MeanLimit | None = None, camera_power_w: Array | float = 0.0,
    ):  # fmt: skip
        self.rows, self.constant, self.cutoff = rows, constant, cutoff
        self.hardware = np.arange(len(constant)) if hardware is None else hardware
        self.top, self.mean_limit = top, mean_limit
        self.camera_power_w = np.broadcast_to(camera_power_w, constant.shape)
        self.n = len(constant)
        self.scenes = [SceneCells(r, light_limit_w) for r in rows]
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
        traded = bool(self.weight["power"]) or mean_limit is not None  # the level is no matter of course
        self.mixed = quality and (traded or any(self.sunlit))
        self.share = (0.0, 0.5, 1.0) if self.mixed else (1.0,) if quality else (0.0,)
        self.objective = objective
        self.gap = gap_rel * (0.3 if self.weight["information"] and not objective.by_ratio else 0.99)
        self.information: list[Information] = []
        if self.weight["information"]:
            assert all(r.sharp is not None for r in rows)
            self.information = [Information(r.sharp) for r in rows if r.sharp is not None]
        self._dimensions(own_f_number)
        self.best = np.full(self.n, np.inf)
        self.start = np.full((self.n, self.n_dims), np.nan)  # where designs look best, until something is found
        self.hopeful = np.empty((0, 2))  # ln f-number and ln time of the last cells where their tangents are best
        self.near_by = np.full(self.n, WIDEST)  # steps that are tried beside the best settings
        self.scale = np.zeros(self.n)  # what the gap is relative to
        self.closed = np.full(self.n, np.inf)
        self.dropped = np.zeros(self.n, bool)
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
            (box.take(index), Reach(**{f.name: getattr(r, f.name)[index] for f in fields(Reach)}))
            for box, r in seen
        ]

    def _opened(self, pool: Pool, s: int, box: Box, reach: Reach) -> Box:
        """The box without f-numbers that leave too little of the lamps' light."""
        rows, d, dim = self.rows[s], pool.design, self.n_dim[s]
        with np.errstate(divide="ignore", invalid="ignore"):
            light = rows.light_lm[d] * reach.u_hi * box.t_hi / np.square(rows.working_factor[d])
            most = np.sqrt(light / reach.x_lo) * (1.0 + 1e-12)
        most = np.where(np.isfinite(most), np.clip(most, box.n_lo, box.n_hi), box.n_hi)
        pool.hi[:, dim] = np.clip(np.log(most), pool.lo[:, dim], pool.hi[:, dim])
        return replace(box, n_hi=most)

    def _value(self, power: Array, snr: Array, contrast: Array, information: Array | float) -> Array:
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
        pool, seen = self._reached(pool)
        d = pool.design
        if len(d) == 0:
            return pool, seen
        power = np.max([r.power_w for _, r in seen], axis=0)
        snr = np.min([r.snr for _, r in seen], axis=0)
        contrast = np.min([r.contrast for _, r in seen], axis=0)
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

        def cheap(design: Array, place: Array) -> tuple[Array, Array]:
            return self._cheap(Pool(design, place.copy(), place.copy(), np.arange(len(design), dtype=float)))

        return likely_places(self.n, roots.design, roots.lo, roots.hi, self.n_dim, cheap)

    # ------------------------------------------------------------ points

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
            cell = np.tile(np.arange(len(pool.design)), len(some))
            a, b, share = np.repeat(some, len(pool.design), axis=0).T
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

    def _at_places(self, design: Array, place: Array) -> Array:
        """Values of designs at f-numbers and times, (m,), by their logarithms (m, 2)."""
        low, high = (side[design] for side in self.range)
        place = np.clip(place, low, high)
        pool = Pool(design, place, place, np.zeros(len(design)))
        point = self._points_in(pool, 0, self._box(pool, 0), np.exp(place[:, 0]), np.zeros(len(design)), np.ones(1))
        return self._keep(design, [point])

    def _try_places(self, design: Array, place: Array) -> None:
        """Where the tangents of cells say that most could be: at a corner of what is allowed it is the best itself."""
        if len(design):
            sides = [place + np.array([side, 0.0]) for side in (-INSIDE, INSIDE)]
            self._at_places(np.tile(design, 2), np.concatenate(sides))

    def _again(self, pool: Pool) -> Pool:
        """Cells bounded by tangents at the best settings that points and polishing have found since."""
        pool, _ = self._bounded(pool)
        if len(pool.design):
            self._try_places(pool.design, self.hopeful)
        return self._prune(pool)

    def _polish_open(self, pool: Pool, turn: int) -> None:
        """Polish the designs with open cells that may be wanted: a few times, where settings are two numbers."""
        if not self._two_numbers or turn > POLISHED:
            return
        design = np.unique(pool.design)
        best = self.best[design]
        likely = best < self._threshold()[design] if turn < LATER else np.isfinite(best)
        if likely.any():
            self._polish(design[likely])

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
            guess.append(bits / _area(self.rows[s])[d])
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
        return np.asarray(bits / _area(self.rows[s])[d])

    # ------------------------------------------------------------ search

    def run(self, *, halve: bool = True, points: bool = True) -> CellResult:
        """Halve the cells with the least bounds until none can beat the best by more than the gap."""
        roots = self._roots()
        self.start = self._looks_best(roots)
        pool, seen = self._bounded(roots)
        if points:
            if self._two_numbers:
                design = np.unique(pool.design[self._open(pool)])
                self._try_places(design, self.start[design])
            open_ = np.nonzero(self._open(pool) & self._unknown(pool))[0]
            self._try_points(pool.take(open_), [(b.take(open_), r) for b, r in seen], list(PATTERNS))
        if not halve:
            np.minimum.at(self.closed, pool.design, pool.bound)
            return self._result()
        if points and self._two_numbers:
            self._try_places(pool.design, self.hopeful)
        pool, spent, turn = self._prune(pool), len(pool.design), 0
        self._polish_open(pool, turn)
        if points and self._two_numbers:
            pool = self._again(pool)
            spent += len(pool.design)
        budget = max(MOST_CELLS, FEWEST * min(self.n, 50))
        while len(pool.design) and spent < budget:
            if len(pool.design) > BATCH:
                order = np.argsort(pool.bound - np.where(np.isfinite(self.best), self.best, 0.0)[pool.design])
                active, rest = pool.take(order[:BATCH]), pool.take(order[BATCH:])
            else:
                active, rest = pool, pool.take(np.empty(0, int))
            children, seen = self._bounded(self._halved(active))
            hopeful = self.hopeful
            spent += len(active.design) * 2
            open_ = np.nonzero(self._open(children))[0]
            some = [(PATTERNS[(4 * turn + k) % len(PATTERNS)]) for k in range(4)]
            tried = np.nonzero(self._open(children) & self._unknown(children))[0]
            boxes = [(box.take(tried), reach) for box, reach in seen]
            self._try_points(children.take(tried), boxes, some)
            if self._two_numbers:
                self._try_places(children.design[open_], hopeful[open_])
            pool = self._prune(Pool.joined([children, rest]))
            turn += 1
            self._polish_open(pool, turn)
        np.minimum.at(self.closed, pool.design, pool.bound)
        return self._result()

    def _threshold(self) -> Array:
        """What each design must not exceed: the cutoff, or what `top` pieces of hardware surely reach."""
        if self.top is None or self.power_decides:
            return np.full(self.n, np.inf) if self.power_decides else self.cutoff
        per = np.full(int(self.hardware.max(initial=0)) + 1, np.inf)
        np.minimum.at(per, self.hardware, self.best)
        if len(per) < self.top:
            return self.cutoff
        least = float(np.partition(per, self.top - 1)[self.top - 1])
        return np.minimum(self.cutoff, least + NEAR * abs(least) if np.isfinite(least) else np.inf)

    def _open(self, pool: Pool) -> Array:
        """Whether cells may still hold something better by more than the gap."""
        best = self.best[pool.design]
        with np.errstate(invalid="ignore"):
            closed = np.isfinite(best) & (pool.bound >= best - self.gap * self.scale[pool.design])
        return ~closed & (pool.bound <= self._threshold()[pool.design])

    def _prune(self, pool: Pool) -> Pool:
        """Cells that are still open; the others leave their bound behind."""
        alive: Array = np.asarray(self._open(pool))
        gone = pool.take(~alive)
        np.minimum.at(self.closed, gone.design, gone.bound)
        worse = gone.bound > self._threshold()[gone.design]
        self.dropped[gone.design[worse]] = True
        return pool.take(alive)

    def _halved(self, pool: Pool) -> Pool:
        """Both halves of each cell, along the side that tells most."""
        width = pool.hi - pool.lo
        point: Array = np.asarray((width <= SMALLEST).all(axis=1))  # all told that can be
        np.minimum.at(self.closed, pool.design[point], pool.bound[point])
        pool, width = pool.take(~point), width[~point]
        m = len(pool.design)
        if m == 0:
            return pool
        dims = [k for k in range(self.n_dims) if width[:, k].max() > 0]
        if len(dims) <= 1:
            side = np.full(m, dims[0] if dims else 0)
        else:
            score = self._gains(pool, dims)
            # Where a half dies at once the side counts as much as the best of the others.
            dies = np.isnan(score)
            most = np.where(dies, 0.0, score).max(axis=1)[:, None]
            score = np.where(dies, np.where(most > 0, most, 1.0), score)
            # Sides that tell little are left alone; of the others the widest, or slivers would never be told apart.
            lens = np.isin(np.arange(self.n_dims), self.n_dim)
            scaled = width * np.where(lens, 2.0, 1.0)
            tells = score > TELLS * score.max(axis=1)[:, None]
            # Sharpness rules settings out and lifts no bound: no cell gets so thin that it never sees the f-number.
            tells |= lens & (scaled > THINNEST * np.where(tells, scaled, 0.0).max(axis=1)[:, None])
            score = np.where(tells, scaled, 1e-6 * scaled)
            side = score.argmax(axis=1)
        middle = 0.5 * (pool.lo + pool.hi)
        at = np.arange(m)
        left = Pool(pool.design, pool.lo.copy(), pool.hi.copy(), pool.bound.copy())
        right = Pool(pool.design, pool.lo.copy(), pool.hi.copy(), pool.bound.copy())
        left.hi[at, side] = middle[at, side]
        right.lo[at, side] = middle[at, side]
        return Pool.joined([left, right])

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
        power = np.max([r.power_w for _, r in seen], axis=0)
        snr = np.min([r.snr for _, r in seen], axis=0)
        contrast = np.min([r.contrast for _, r in seen], axis=0)
        information: Array | float = 0.0
        if self.weight["information"]:
            information = np.min([
                surrogate_bit_per_px(self.scenes[s], kept.design, box, reach) / _area(self.rows[s])[kept.design]
                for s, (box, reach) in enumerate(seen)
            ], axis=0)  # fmt: skip
        return alive, self._value(power, snr, contrast, information)

    # ------------------------------------------------------------ result

    def _result(self) -> CellResult:
        """Everything by design, information by the model's own rule."""
        self.dropped &= ~(self.best <= self._threshold())
        feasible = np.isfinite(self.best) & ~self.dropped
        chosen = [Chosen(**kept) for kept in self.kept]
        lower = np.minimum(self.closed, self.best)
        if self.weight["information"] and feasible.any():
            exact, index = self._model_information(np.nonzero(feasible)[0]), np.nonzero(feasible)[0]
            own = self.figures["information"][index]
            slack = np.maximum(np.abs(exact - own), RULE_ERROR * np.abs(own))
            if self.objective.by_ratio:
                slack = np.log1p(slack / np.maximum(np.minimum(exact, own), LEAST))
            lower[index] -= self.weight["information"] * slack
            self.figures["information"][index] = exact
        if self.power_decides:
            lower = np.where(np.isfinite(lower), self.constant, np.inf)
        return CellResult(
            chosen, feasible, self.figures["snr_db"], self.figures["contrast"], self.figures["information"], lower,
            self.dropped,
        )  # fmt: skip

    def _model_information(self, index: Array) -> Array:
        """Information of the settings kept, worst scene, by `SharpRows`."""
        out = []
        for s, rows in enumerate(self.rows):
            assert rows.sharp is not None
            kept = {name: column[index] for name, column in self.kept[s].items()}
            blur = (
                self.scenes[s].blurred_s(index, kept["time_s"])
                if not self.sunlit[s]
                else kept["exposure_s"] + rows.exposure_offset_s[index]
            )
            snr = self._snr_kept(s, index)
            out.append(rows.sharp.take(index).information_bit_per_m2(
                snr, f_number=kept["f_number"], working_f_number=kept["f_number"] * rows.working_factor[index],
                blur_s=blur,
            ))  # fmt: skip
        return np.asarray(np.min(out, axis=0))

    def _snr_kept(self, s: int, index: Array) -> Array:
        """SNR of the settings kept in one scene, a ratio."""
        scene, kept = self.scenes[s], {k: v[index] for k, v in self.kept[s].items()}
        open_s = kept["exposure_s"] + self.rows[s].exposure_offset_s[index]
        point = scene.points(
            index, kept["f_number"], kept["time_s"], open_s if self.sunlit[s] else kept["time_s"],
            kept["level"] * (1 - 1e-12), kept["level"] * (1 + 1e-12), 1.0,
        )  # fmt: skip
        return np.asarray(np.where(np.isfinite(point.snr), point.snr, 1e-300))


def _logs(low: Array, high: Array) -> tuple[Array, Array]:
    """Logarithms of a range, at least a point."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a = np.log(np.maximum(low, 1e-300))
        b = np.log(np.maximum(high, 1e-300))
    return a, np.maximum(a, b)


def _area(rows: SceneRows) -> Array:
    """Floor of one pixel."""
    assert rows.sharp is not None
    return rows.sharp.pixel_area_m2
