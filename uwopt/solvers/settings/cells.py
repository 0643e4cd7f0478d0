"""Best settings with a proven gap where no closed form holds: sharpness, information, sunlight.

Boxes of all designs (`cell_pool`) are bounded and halved together; points inside (`cell_points`) give values to beat.
What bounds are left when boxes are dropped bounds the truth from below, so an answer is optimal to its gap, and a
design whose boxes have all died is infeasible.
"""

from __future__ import annotations

import numpy as np

from uwopt.arrays import Array
from uwopt.model.information import RULE_ERROR
from uwopt.objectives.objective import LEAST
from uwopt.solvers.settings.cell_points import TriedCells
from uwopt.solvers.settings.cell_pool import Pool
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.solvers.settings.information import information_of
from uwopt.solvers.settings.question import MOST_CELLS, Best, Question

BATCH = 4096  # cells halved at a time
FEWEST = 4_000  # bounded in one call for each of up to fifty designs, where that is more than for one
PATTERNS = (
    (0.0, 1.0), (0.5, 0.5), (0.0, 0.5), (0.5, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0), (1.0, 0.5), (0.5, 0.0),
)  # fmt: skip
SOME_POINTS = 4  # of a cell at a time
FEW_POINTS = 2  # the same where it is only asked whether any fits: of most designs none does
NEAR = 1e-9  # relative, of ties
POLISHED, LATER = 4, 2  # rounds after which settings are polished no more, and that of designs not known to be wanted


def best_by_cells(question: Question, *, halve: bool = True, points: bool = True) -> Best:
    """Best settings to the relative gap of the objective, worst scene, with a bound of each.

    What is dropped is not feasible, and its bound is more than the cutoff, or than what beats it. Without `halve` boxes
    are bounded as a whole, and without `points` none is tried. Of a bound of inf it is proven that nothing is feasible.
    Raises OutOfTimeError past the deadline: nothing is known then of any.
    """
    if len(question.rows) == 1:
        return CellSearch(question, own_f_number=False).run(halve=halve, points=points)
    apart = question.motorised
    groups = [np.nonzero(each)[0] for each in (apart, ~apart) if each.any()]
    found = [
        CellSearch(question.take(mine), own_f_number=bool(apart[mine[0]])).run(halve=halve, points=points)
        for mine in groups
    ]
    return Best.in_places(list(zip(groups, found, strict=True)), len(question))


class CellSearch(TriedCells):
    """One search over the settings of designs that have the same dimensions."""

    def run(self, *, halve: bool = True, points: bool = True) -> Best:
        """Halve the cells with the least bounds until none can beat the best by more than the gap."""
        roots = self._roots()
        self.start = self._looks_best(roots)
        pool, seen = self._bounded(roots)
        if points:
            if self._two_numbers:
                design = np.unique(pool.design[self._open(pool)])
                self._try_places(design, self.start[design])
            open_ = np.nonzero(self._open(pool) & self._unknown(pool))[0]
            patterns = list(PATTERNS[: FEW_POINTS if self.any_will_do else None])
            self._try_points(pool.take(open_), [(b.take(open_), r) for b, r in seen], patterns)
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
            self.deadline.check()
            if len(pool.design) > BATCH:
                order = np.argsort(pool.bound - np.where(np.isfinite(self.best), self.best, 0.0)[pool.design])
                active, rest = pool.take(order[:BATCH]), pool.take(order[BATCH:])
            else:
                active, rest = pool, pool.take(np.empty(0, int))
            children, seen = self._bounded(self._halved(active))
            hopeful = self.hopeful
            spent += len(active.design) * 2
            self.taken += 2 * np.bincount(active.design, minlength=self.n)
            open_ = np.nonzero(self._open(children))[0]
            few = FEW_POINTS if self.any_will_do else SOME_POINTS
            some = [PATTERNS[(few * turn + k) % len(PATTERNS)] for k in range(few)]
            tried = np.nonzero(self._open(children) & self._unknown(children))[0]
            boxes = [(box.take(tried), reach) for box, reach in seen]
            self._try_points(children.take(tried), boxes, some)
            if self._two_numbers:
                self._try_places(children.design[open_], hopeful[open_])
            pool = self._left(self._prune(Pool.joined([children, rest])), self.taken < self.most_cells)
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
            closed = np.isfinite(best) & (self.any_will_do | (pool.bound >= best - self.gap * self.scale[pool.design]))
        return ~closed & (pool.bound <= self._threshold()[pool.design])

    def _prune(self, pool: Pool) -> Pool:
        """Cells that are still open; the others leave their bound behind."""
        alive: Array = np.asarray(self._open(pool))
        gone = pool.take(~alive)
        np.minimum.at(self.closed, gone.design, gone.bound)
        worse = gone.bound > self._threshold()[gone.design]
        self.dropped[gone.design[worse]] = True
        return pool.take(alive)

    def _left(self, pool: Pool, going_on: Array) -> Pool:
        """Cells of the designs that go on; those of the others leave their bound behind, unproven."""
        mine = going_on[pool.design]
        np.minimum.at(self.closed, pool.design[~mine], pool.bound[~mine])
        return pool if mine.all() else pool.take(mine)

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

    # ------------------------------------------------------------ result

    def _result(self) -> Best:
        """Everything by design, information by the model's own rule."""
        self.dropped &= ~(self.best <= self._threshold())
        feasible = np.isfinite(self.best) & ~self.dropped
        chosen = [Chosen(**kept) for kept in self.kept]
        lower = np.minimum(self.closed, self.best)
        if self.weight["information"] and feasible.any():
            index = np.nonzero(feasible)[0]
            exact = information_of(self.rows, chosen, feasible)[index]
            own = self.figures["information"][index]
            slack = np.maximum(np.abs(exact - own), RULE_ERROR * np.abs(own))
            if self.objective.by_ratio:
                slack = np.log1p(slack / np.maximum(np.minimum(exact, own), LEAST))
            lower[index] -= self.weight["information"] * slack
            self.figures["information"][index] = exact
        if self.power_decides:
            lower = np.where(np.isfinite(lower), self.constant, np.inf)
        information = np.nan_to_num(self.figures["information"])
        return Best(chosen, feasible, self.figures["snr_db"], self.figures["contrast"], information, lower)
