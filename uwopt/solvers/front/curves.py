"""The curves of some designs, as far as they are asked: segments between limits of power, and their corners."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.beside import shares, side_by_side
from uwopt.solvers.front.hopeful import Hopeful
from uwopt.solvers.front.trade_curves import ABOVE, DIMMEST, Answers, Trade

CLOSE = np.array([0.5, 1.0])  # in ln f-number and ln time: between settings so near to each other others are guessed
FEWEST_ASKED = 64  # limits of power that a core looks within


@dataclass
class Curves:
    """The curves of some designs, as far as they are known; `answers` by design, then limit."""

    trade: Trade
    some: Hopeful
    answers: Answers
    tried: list[Answers] = field(default_factory=list)  # settings beside those, which bound nothing

    def segments(self) -> tuple[Array, Array]:
        """Pairs of consecutive limits of one design, as places in `answers`: lower and upper."""
        a = self.answers
        lower = np.nonzero(a.design[1:] == a.design[:-1])[0]
        return lower, lower + 1

    def corners(self) -> tuple[Array, Array]:
        """The best that each segment could hold: (power [W], quality); inf where it can hold nothing new.

        Within a limit no quality is above its bound, and what is above the bound of the lower limit needs more
        power than that limit; where power has steps, the power of the next.
        """
        a = self.answers
        lower, upper = self.segments()
        known = np.where(np.isfinite(a.quality[lower]), a.quality[lower], -np.inf)
        stepped = self.some.stepped[a.design[lower]]
        power = np.where(stepped, np.maximum(a.limit_w[lower], a.limit_w[upper] / ABOVE), a.limit_w[lower])
        return np.where(a.bound[upper] > known, power, np.inf), a.bound[upper]

    def ask(self, which: Array, wanted: Array, pieces: Array) -> Answers:
        """Ask these segments at their upper end, or where that is known at places between; the new answers.

        wanted : (n,) by segment, the quality below which an answer matters to nobody
        pieces : (n,) into how many pieces each is cut, evenly in the logarithm of the lights' power
        """
        a = self.answers
        lower, upper = (side[which] for side in self.segments())
        known = a.asked[upper]
        ends, first = np.unique(upper[~known], return_index=True)
        segment = np.repeat(np.nonzero(known)[0], pieces[known] - 1)
        step = np.concatenate([np.arange(1, n) / n for n in pieces[known]]) if known.any() else np.empty(0)
        low_at, high_at = lower[segment], upper[segment]
        camera = self.some.camera_power_w[a.design[low_at]]
        low = a.limit_w[low_at] - camera
        high = np.fmin(a.limit_w[high_at], np.fmax(a.power_w[high_at], a.limit_w[low_at])) - camera
        low = np.maximum(low, DIMMEST * high)
        between = camera + low * (high / np.where(low > 0, low, 1.0)) ** step
        design = np.concatenate([a.design[ends], a.design[low_at]])
        limit = np.concatenate([a.limit_w[ends], between])
        least = np.concatenate([wanted[~known][first], wanted[segment]])
        new = self._answered(design, limit, least)
        kept = np.ones(len(a.design), bool)
        kept[ends] = False
        self.answers = Answers.joined([a.take(np.nonzero(kept)[0]), new]).drawn_in()
        return new

    def _answered(self, design: Array, limit_w: Array, wanted: Array) -> Answers:
        """Best qualities of these designs within these limits, (n,) each: a share of them on a core."""
        near = self._near(design, limit_w)

        def of_share(share: slice) -> Answers:
            beside = None if near is None else near[share]
            return self.trade.best_quality(
                self.some, design[share], limit_w[share], wanted=wanted[share], near=beside
            )

        parts = shares(len(design), FEWEST_ASKED)
        return Answers.joined(side_by_side([partial(of_share, share) for share in parts]))

    def _near(self, design: Array, limit_w: Array) -> Array | None:
        """F-number and time (n, 2) between the best settings within the limits below and above these, evenly in the
        logarithms; nan where those are not known or not alike. None where scenes differ."""
        if len(self.some.rows) > 1:
            return None
        a, (chosen,) = self.answers, self.answers.chosen
        known = np.nonzero(a.asked & np.isfinite(chosen.f_number) & np.isfinite(chosen.time_s))[0]
        if len(known) == 0:
            return None
        # Complex numbers are in the order of designs, then limits.
        above = np.searchsorted(a.design[known] + 1j * a.limit_w[known], design + 1j * limit_w)
        low, high = (known[np.clip(above + side, 0, len(known) - 1)] for side in (-1, 0))
        camera_w = self.some.camera_power_w[design]
        first, here, last = (np.maximum(w - camera_w, 1e-300) for w in (a.limit_w[low], limit_w, a.limit_w[high]))
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.log(here / first) / np.log(last / first)
        ends = np.log(np.stack([chosen.f_number, chosen.time_s], axis=1))
        close = (a.design[low] == design) & (a.design[high] == design)
        close &= (np.abs(ends[high] - ends[low]) <= CLOSE).all(axis=1) & np.isfinite(share)
        between = ends[low] + np.where(close, share, np.nan)[:, None] * (ends[high] - ends[low])
        return np.asarray(np.exp(between))

    @staticmethod
    def bounded(trade: Trade, some: Hopeful) -> Curves | None:
        """Curves of which nothing is known but bounds; None where no design has settings."""
        bounds = trade.first_bounds(some)
        if bounds is None:
            return None
        alive = np.unique(bounds.design)
        return Curves(trade, some.take(alive), replace(bounds, design=np.searchsorted(alive, bounds.design)))

    def with_least_power(self) -> Curves | None:
        """Curves that are bounded alone, known at their least power."""
        a = self.answers
        begins = np.append(True, a.design[1:] != a.design[:-1])
        least = self.trade.least_power(self.some)
        least = replace(least, limit_w=np.fmin(least.power_w, a.limit_w[begins]))
        answers = Answers.joined([least, a.take(np.nonzero(~begins)[0])])
        return replace(self, answers=answers).without(np.isnan(least.bound))

    def without(self, gone: Array) -> Curves | None:
        """Without these designs; None when none is left."""
        left = np.nonzero(~gone)[0]
        if len(left) == 0:
            return None
        place = np.full(len(gone), -1)
        place[left] = np.arange(len(left))

        def kept(answers: Answers) -> Answers:
            some = answers.take(np.nonzero(~gone[answers.design])[0])
            return replace(some, design=place[some.design])

        return Curves(self.trade, self.some.take(left), kept(self.answers), [kept(one) for one in self.tried])
