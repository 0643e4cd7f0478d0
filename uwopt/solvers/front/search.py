"""The exact front: every design of a catalogue that no other beats in all of two or three objectives.

Each (imager, lighting) has an ideal: the least power, cost, ... and the best quality that any of its lights
and settings could have. Nodes are taken in layers of ideals that no other ideal dominates; their lights and
numbers are bounded again, one by one, with better and better bounds, and what some found point beats in every
objective is discarded. What is left gets its curve of quality against power. When every node is evaluated or
beaten, no design of the catalogue can improve on the front by more than the volume that its open segments span.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline, OutOfTimeError, Progress, unheard
from uwopt.forward.lamp_light import Veils
from uwopt.forward.light_columns import ImageLight
from uwopt.forward.problem import Problem
from uwopt.objectives.axes import Axes, Frame
from uwopt.objectives.dominance import clearly, hypervolume
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.account import RULES, Account
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.node_bounds import by_rule, first_missed
from uwopt.solvers.exact.node_designs import NodeDesigns
from uwopt.solvers.exact.search import Search
from uwopt.solvers.front.curves import Curves
from uwopt.solvers.front.hopeful import Hopeful
from uwopt.solvers.front.points import (
    WITHOUT_BOUND,
    PointsFound,
    Undominated,
    in_layers,
    largest_left,
    quality_of,
)
from uwopt.solvers.front.trade_curves import Answers, Trade
from uwopt.solvers.settings import windows
from uwopt.solvers.settings.mean_limit import MeanLimit

FIRST_NODES, LARGEST_NODES, GROWTH = 128, 16384, 6  # nodes taken together
ROUGH_SEGMENT, FINEST_SEGMENT = 1e-3, 1e-8  # share of the box that a segment may add: at first, and ever
FRONT_GAP = 5e-4  # of the hypervolume: what the sampled curves may miss
AT_ONCE = 0.15  # of what is open stays at least, before it is known what overlaps
ROUNDS, CUTS, REFINEMENTS = 1, 4, 16  # of asking the segments of one wave, and of all that stayed
MOST_PIECES = 8  # of a segment at a time
FEWEST_ASKED, MOST_ASKED = 1024, 8192  # segments at a time, before the points found are looked at
RARELY = 0.1  # share of the segments asked that hold something new
TRIED_IN_VAIN = 0.75  # share of designs that stay open after tries: no more are made
STALLED = 0.8  # of the gap before: bounds on settings that do not close are not asked for ever


@dataclass
class Front:
    """What a search found: points with their settings, and how far the proof reaches."""

    axes: Axes
    values: Array  # (n, n_axes) minimised, none dominated
    designs: list[tuple[Hopeful, Answers, int]]  # by point: designs, and the answer about one of them
    frame: Frame | None
    hypervolume: float
    hypervolume_bound: float
    complete: bool
    interrupted: bool
    account: dict[str, int]  # by rule; `evaluated` counts designs whose settings were solved
    seconds: float
    history: list[tuple[float, Array]] = field(default_factory=list)  # (s, points so far)


class FrontSearch:
    """State of one search for a front."""

    def __init__(
        self, problem: Problem, axes: Axes, *, deadline: Deadline = NEVER, progress: Progress = unheard
    ):
        self.problem, self.axes = problem, axes
        self.quality = quality_of(problem, axes)
        self.points = PointsFound(axes, self.quality)
        self.trade = Trade(self.quality, deadline)
        self.start = time.perf_counter()
        self.deadline, self.progress = deadline, progress
        self.search = Search(problem, axes.objective, top=1)
        self.stop_trying = False
        self.solved: dict[bytes, list[Array]] = {}  # by what decides a curve: axes that no setting changes
        self.curves: list[Curves] = []
        self.kept: list[Imagers] = []  # of a large catalogue, those that the first `n_kept` curves are about
        self.n_kept, self.interrupted = 0, False
        self.account = self.search.account  # what its rule `bound` discards is dominated
        self.history: list[tuple[float, Array]] = []

    # ------------------------------------------------------------ run

    def run(self) -> Front:
        """Bound all nodes, take them layer by layer, refine the curves."""
        tree = self.search.tree(Undominated(self.axes, self.points.archive, self.among))
        complete, left = tree.search(self.deadline), tree.open_ideals()
        self.interrupted |= tree.interrupted
        if len(left):
            self.account.leave_the_rest()
        if self.search.every_imager is None:
            self._keep()
            self.search.take_up(tree.bounds.others(Imagers.joined(self.kept or [tree.bounds.imagers])))
        try:
            complete = complete and self._refine()
        except KeyboardInterrupt:
            complete, self.interrupted = False, True
        return self._front(complete, left)

    def among(self, bounds: Bounds, imagers: Array) -> Array:
        """Nodes of some imagers layer by layer; the ideals of those that are left when time ran out, or a person wants
        no more."""
        if bounds is not self.search.bounds:
            self._keep()
            self.search.take_up(bounds)
        ideal, lighting, imager = self._nodes(imagers)
        left = np.ones(len(ideal), bool)
        try:
            self._layers(ideal, lighting, imager, left)
        except KeyboardInterrupt:
            if not left.any():
                raise
            self.interrupted = True
        return ideal[left]

    def _keep(self) -> None:
        """Keep the imagers that the last curves are about, as others are taken up."""
        last = self.curves[self.n_kept :]
        if not last:
            return
        used = np.unique(np.concatenate([c.some.imager for c in last]))
        begin = sum(len(part) for part in self.kept)
        self.kept.append(self.search.imagers.take(used))
        for place, curves in enumerate(last, self.n_kept):
            at = begin + np.searchsorted(used, curves.some.imager)
            self.curves[place] = replace(curves, some=replace(curves.some, imager=at))
        self.n_kept = len(self.curves)

    def _nodes(self, every: Array) -> tuple[Array, Array, Array]:
        """Ideals of all nodes of some imagers that may be feasible, with their lighting and imager."""
        bounds, imagers = self.search.bounds, self.search.imagers
        ideals, lightings, rows = [np.empty((0, len(self.axes)))], [np.empty(0, int)], [np.empty(0, int)]  # no lamps
        for k in range(len(self.search.tables.lightings)):
            seen = bounds.of_nodes(k, every)
            size = bounds.sizes[k]
            for name, lost in by_rule(seen.rule):
                self.account.charge(name, len(lost) * size)
            alive = np.nonzero((seen.rule < 0) & np.isfinite(seen.value))[0]
            ideals.append(self.axes.minimised(seen.terms(alive, imagers.gsd_mm[every[alive]])))
            lightings.append(np.full(len(alive), k))
            rows.append(every[alive])
        return np.concatenate(ideals), np.concatenate(lightings), np.concatenate(rows)

    def _layers(self, ideal: Array, lighting: Array, imager: Array, left: Array) -> None:
        """Evaluate nodes until each is evaluated or beaten by a point, or time is over; `left` marks the others."""
        sizes, total = self.search.bounds.sizes, max(len(ideal), 1)
        batch = FIRST_NODES
        while left.any():
            rows = np.nonzero(left)[0]
            beaten = self.points.archive.beats(ideal[rows])
            self.account.charge("bound", int(sizes[lighting[rows[beaten]]].sum()))
            left[rows[beaten]] = False
            rows = rows[~beaten]
            if len(rows) == 0 or self.deadline.passed():
                break
            wave = rows[in_layers(ideal[rows])[:batch]]  # none dominates those, then those next to them
            if not self._take(lighting[wave], imager[wave]):
                break
            left[wave] = False
            batch = min(GROWTH * batch, LARGEST_NODES)
            self.history.append((time.perf_counter() - self.start, self.points.archive.values))
            self.progress(0.9 * (1.0 - left.sum() / total), f"front: {len(self.points.archive.values)} points")

    def _take(self, lighting: Array, imager: Array) -> bool:
        """Evaluate these nodes; cut short, they count as not reached, and points stay."""
        before, done = self.account.snapshot(), False
        try:
            under = Under(self.search.tables.lightings, lighting)
            parts = [self._bounded_again(under.take(some), imager[some]) for some in self.search.together(under)]
            some = [part for part in parts if part is not None and len(part)]
            done = not some or self._solve(Hopeful.joined(some))
        except OutOfTimeError:
            return False
        finally:
            if not done:
                self.account.restore(before)
        return done

    # ------------------------------------------------------------ one wave

    def _bounded_again(self, under: Under, imager: Array) -> Hopeful | None:
        """Lights and numbers of these imagers, each under its lighting, that no point beats, however they are set.

        Each stage works out more of the light, and discards what the points beat at all limits of power.
        """
        search = self.search
        every = NodeDesigns.every(search.imagers, imager, under, search.bounds.light_tables)
        rule = first_missed(every.kept_limits(search.limits))
        for name, lost in by_rule(rule):
            self.account.charge(name, len(lost))
        pairs, lights = every.take(np.flatnonzero(rule < 0)), None
        stages: tuple[Veils, ...] = ("none", "forward", "coarse") if self.problem.effects.veils else ()
        for stage in stages:
            lights = search.tables.in_scenes(
                pairs.under, pairs.imager, known=lights, veils=stage, deadline=self.deadline
            )  # fmt: skip
            some = self._worth_solving(pairs, lights, optimistic=True)
            kept = self._unbeaten(some, closely=stage != stages[-1])
            if len(kept) == 0:
                return None
            pairs, used = pairs.alone(kept)
            lights = [light.take(used) for light in lights]
        lights = search.tables.in_scenes(pairs.under, pairs.imager, known=lights, deadline=self.deadline)
        return self._worth_solving(pairs, lights, optimistic=False)

    def _worth_solving(self, pairs: NodeDesigns, lights: list[ImageLight], *, optimistic: bool) -> Hopeful:
        """Designs as rows of settings."""
        search, imagers, imager = self.search, self.search.imagers, pairs.row
        rows = search.rows(
            imager, [one.take(pairs.node) for one in lights], pairs.light, pairs.count, pairs.lit,
            optimistic=optimistic,
        )  # fmt: skip
        contrast: Array | float = 0.0
        if "contrast" in self.axes.names and self.quality != "contrast":
            contrast = np.min([windows.nominal_contrast(r) for r in rows], axis=0)
        nothing = np.zeros(len(imager))
        fixed = self.axes.minimised(
            Terms(nothing, pairs.cost, pairs.mass_kg, nothing, imagers.gsd_mm[imager], contrast, nothing)
        )
        return Hopeful(
            pairs.lit.index, imager, pairs.light, pairs.count, rows, search.motorised[imager],
            imagers.camera_power_w[imager], fixed, search.problem.scene_power_limit_w, MeanLimit.of(search.problem),
        )  # fmt: skip

    def _unbeaten(self, some: Hopeful, *, closely: bool) -> Array:
        """Places of the designs that may hold something new, bounds drawn in or not; the others are counted."""
        least_w = self.trade.least_power_bound(some)
        possible = np.nonzero(np.isfinite(least_w))[0]
        self.account.charge("light", len(some) - len(possible))
        left = some.take(possible)
        best = self.points.values(
            left, least_w[possible], self.trade.bound_within(left, left.full_power_w), np.arange(len(left))
        )
        open_ = possible[self.points.may_be_new(best)]
        fits = self.trade.may_fit(some.take(open_))
        self.account.charge("light", int((~fits).sum()))
        possible, open_ = np.setdiff1d(possible, open_[~fits]), open_[fits]
        bounds = self.trade.first_bounds(some.take(open_), least_w[open_])
        if bounds is not None:
            curves = Curves(self.trade, some.take(open_), bounds)
            open_ = open_[self._drawn_in(curves)[1] if closely else self.points.are_open(curves)]
        self.account.charge("bound", len(possible) - len(open_))
        return open_

    # ------------------------------------------------------------ curves

    def _solve(self, some: Hopeful) -> bool:
        """Ends of the curves, then segments that may still matter, coarsely; False: out of time."""
        apart = self._without_twins(some)
        self.account.charge("bound", len(some) - len(apart))
        some = some.take(apart)
        if len(some) == 0:
            return True
        self.account.evaluated += len(some)
        curves = Curves.bounded(self.trade, some)
        if curves is not None:
            curves, _ = self._drawn_in(curves)
        if curves is not None:
            curves = self._after_tries(curves)
        if curves is None:
            return True
        if not self.points.trades_power:  # one point a design: its best quality
            curves = replace(curves, answers=self._best_of_each(curves.some))
        else:
            known = curves.with_least_power()
            if known is None:
                return True
            curves = known
        self.curves.append(curves)
        self.points.add(curves, curves.answers)
        in_time = True
        if self.points.has_curves:
            in_time = self._ask(curves, ROUGH_SEGMENT, ROUNDS)
            self._forget()
        return in_time

    def _without_twins(self, some: Hopeful) -> Array:
        """Places of the designs that no other with the same curve, no dearer or heavier, stands for already.

        Lamps that are alike but for their price, or so many that their power is not allowed, have the same curve.
        """
        decides, kept = some.what_decides(), []
        for place in np.lexsort(some.fixed.T[::-1]).tolist():  # what is as good in everything comes first
            like = self.solved.setdefault(decides[place], [])
            if not any((other <= some.fixed[place]).all() for other in like):
                like.append(some.fixed[place])
                kept.append(place)
        return np.sort(np.array(kept, int))

    def _drawn_in(self, curves: Curves) -> tuple[Curves | None, Array]:
        """Curves of the designs that may still matter once their bounds are drawn in, and which these are."""
        open_ = self.points.are_open(curves)
        left, kept = curves.without(~open_), np.nonzero(open_)[0]
        if left is None or self.quality != "information" or not self.points.trades_power:
            return left, kept
        which = np.nonzero(self.points.may_be_new(self.points.of_segments(left)))[0]
        wanted, upper = self.points.wanted(left, which), left.segments()[1][which]
        left = replace(left, answers=self.trade.drawn_in(left.some, left.answers, upper, wanted))
        open_ = self.points.are_open(left)
        return left.without(~open_), kept[open_]

    def _best_of_each(self, some: Hopeful) -> Answers:
        """The best quality of each design, as far as it is better than that of points that are found."""
        every, full_w = np.arange(len(some)), some.full_power_w
        wanted = self.points.better_than(self.points.values(some, full_w, np.full(len(some), WITHOUT_BOUND), every))
        return self.trade.best_quality(some, every, full_w, wanted=wanted)

    def _after_tries(self, curves: Curves) -> Curves | None:
        """Curves of the designs that may still matter once a few settings of each are tried."""
        tried = [] if self.stop_trying else self.trade.tried(curves.some, np.arange(len(curves.some)))
        if not tried:
            return curves
        self.curves.append(replace(curves, answers=curves.answers.take(np.empty(0, int)), tried=tried))
        for answers in tried:
            self.points.add(curves, answers)
        self._forget()
        open_ = self.points.are_open(curves)
        self.stop_trying = bool(open_.mean() > TRIED_IN_VAIN)
        return curves.without(~open_)

    def _ask(
        self, curves: Curves, largest: float, rounds: int, enough: Callable[[], bool] = lambda: False
    ) -> bool:
        """Ask segments that may matter and span more than a share of the frame's box, until that is `enough`.

        False: out of time.
        """
        most = FEWEST_ASKED
        while rounds > 0 and not enough():
            which, spans = self.points.open_segments(curves, largest)
            if len(which) == 0:
                break
            _, upper = curves.segments()
            known = curves.answers.asked[upper[which]]
            if known.all():
                rounds -= 1
            elif (~known).sum() > FEWEST_ASKED // 2:
                # The highest limit of each design first: it bounds the others.
                design = curves.answers.design[upper[which]]
                top = np.append(design[1:] != design[:-1], True) & ~known
                first = top if top.any() else ~known
                which, spans = which[first], spans[first]
            order = np.argsort(-spans, kind="stable")[:most]
            which, spans = which[order], spans[order]
            if self.deadline.passed():
                return False
            pieces = np.clip(np.ceil(np.sqrt(spans / largest)), 2, MOST_PIECES).astype(int)
            try:
                answers = curves.ask(which, self.points.wanted(curves, which), pieces)
            except OutOfTimeError:
                return False
            self.points.add(curves, answers)
            if answers.found.mean() < RARELY:  # points found decide little: more at a time
                most = min(2 * most, MOST_ASKED)
        return True

    def _forget(self) -> None:
        """Drop designs of the last curves of which nothing can be on the front any more."""
        curves = self.curves[-1]
        lower, _ = curves.segments()
        matters = self.points.may_be_new(self.points.of_segments(curves))
        useful = np.zeros(len(curves.some), bool)
        useful[curves.answers.design[lower[matters]]] = True
        for answers in (curves.answers, *curves.tried):
            which = self.points.on_front(curves, answers)
            useful[answers.design[which]] = True
        left = curves.without(~useful)
        self.curves[-1:] = [] if left is None else [left]

    def _refine(self) -> bool:
        """Ask until the front misses no more of the hypervolume than it may."""
        if not self.points.has_curves or not self.curves:
            return True
        joined = Hopeful.joined([c.some for c in self.curves])
        starts = np.cumsum([0, *(len(c.some) for c in self.curves)])
        parts = [replace(c.answers, design=c.answers.design + starts[n]) for n, c in enumerate(self.curves)]
        tried = [
            replace(t, design=t.design + starts[n]).take(self.points.on_front(c, t))
            for n, c in enumerate(self.curves)
            for t in c.tried
        ]
        self.curves = [Curves(self.trade, joined, Answers.joined(parts), tried)]
        gap_before = np.inf
        for _ in range(REFINEMENTS):
            self._forget()
            if not self.curves:
                break
            lower, upper = self.points.volumes(self.curves)
            self.progress(0.95, f"front: {len(self.points.archive.values)} points")
            if upper - lower <= FRONT_GAP * upper or upper - lower > STALLED * gap_before:
                break
            gap_before = upper - lower
            curves = self.curves[-1]
            _, spans = self.points.open_segments(curves, 0.0)
            share = FRONT_GAP * upper / (upper - lower)
            largest = largest_left(spans, max(share, AT_ONCE))
            last = self._is_closed if share > AT_ONCE else (lambda: False)
            if not self._ask(curves, max(largest, FINEST_SEGMENT), CUTS, last):
                return False
            self.history.append((time.perf_counter() - self.start, self.points.archive.values))
        return True

    def _is_closed(self) -> bool:
        """Whether the front misses no more of the hypervolume than it may."""
        lower, upper = self.points.volumes(self.curves)
        return upper - lower <= FRONT_GAP * upper

    # ------------------------------------------------------------ result

    def _front(self, complete: bool, open_ideals: Array) -> Front:
        """The points that stayed, each with its design."""
        values, designs = [], []
        for curves in self.curves:
            for answers in (curves.answers, *curves.tried):
                found = self.points.on_front(curves, answers)
                values.append(self.points.of_answers(curves, answers, found))
                designs += [(curves.some, answers, int(place)) for place in found]
        every = np.concatenate(values) if values else np.empty((0, len(self.axes)))
        kept = np.nonzero(clearly(every, self.points.resolved_rel))[0]
        frame, lower, upper = None, 0.0, 0.0
        if len(kept):
            frame = Frame.of(self.axes, every[kept])
            lower, upper = self.points.volumes(self.curves)
            if len(open_ideals):
                # both at once: what open segments and nodes that were not reached may add need not overlap
                still = np.concatenate([every[kept], self.points.open_corners(self.curves), open_ideals])
                upper = max(upper, hypervolume(still, frame))
        return Front(
            self.axes, every[kept], [designs[i] for i in kept], frame, lower, upper, complete, self.interrupted,
            by_front_rule(self.account), time.perf_counter() - self.start, self.history,
        )  # fmt: skip


def by_front_rule(account: Account) -> dict[str, int]:
    """Where combinations went in a front's words: evaluated, or discarded by which rule."""
    by_bound = {rule: count for rule, count in account.discarded.items() if rule != "bound"}
    others = {rule: by_bound.pop(rule) for rule in [*by_bound] if rule not in RULES}
    return {**by_bound, "dominated": account.discarded["bound"], **others, "evaluated": account.evaluated}
