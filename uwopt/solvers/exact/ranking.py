"""The best designs found so far, one of each hardware, ties broken as the certificate says."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import rows_alike
from uwopt.forward.designs import Hardware
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.imager_rules import Behind
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import Lighting
from uwopt.solvers.exact.node_designs import NodeDesigns
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.tolerances import SLACK, TIE


def told_apart(value: Array | float) -> Array:
    """Numbers to nine digits: what differs by rounding alone must not decide between one lamp more or less."""
    size = np.floor(np.log10(np.maximum(np.abs(value), 1e-300)))
    step = 10.0 ** (size - 8.0)
    return np.asarray(np.round(value / step) * step)


@dataclass(frozen=True)
class Found:
    """One feasible design with its settings of least power, by indices into the problem's tables."""

    imager: int
    camera: int
    lens: int
    port: int
    landscape: bool
    light: int
    count: int
    lighting: Lighting
    minimised: float
    power_w: float
    cost: float
    mass_kg: float
    snr_db: float
    settings: list[dict[str, float]]  # by scene
    pulse_s: float

    @staticmethod
    def of(imagers: Imagers, imager: int, settings: Sequence[dict[str, float]], **own: Any) -> Found:
        """One of some imagers with its settings by scene, to which focus and rate are added; `own` are the rest."""
        scenes = [
            {**numbers, **{name: float(getattr(seen.focused, name)[imager]) for name in ("dioptre_per_m", "rate_hz")}}
            for numbers, seen in zip(settings, imagers.scenes, strict=True)
        ]
        return Found(
            imager, int(imagers.camera[imager]), int(imagers.lens[imager]), int(imagers.port[imager]),
            bool(imagers.landscape[imager]), settings=scenes, pulse_s=max(s["time_s"] for s in scenes), **own,
        )  # fmt: skip

    @property
    def hardware(self) -> Hardware:
        """Without its settings."""
        mount = self.lighting.mount
        return Hardware(self.camera, self.lens, self.port, self.landscape, self.light, self.count, mount)

    @property
    def behind(self) -> Behind:
        """Its camera and lens behind its port."""
        camera, lens, port = (np.array([part]) for part in (self.camera, self.lens, self.port))
        return Behind(camera, lens, port, self.landscape)

    @cached_property
    def figures(self) -> tuple[float, ...]:
        """Power, cost and mass as they are told apart; kept, for long lists of ties ask for them often."""
        return tuple(told_apart(np.array([self.power_w, self.cost, self.mass_kg])).tolist())

    def tie_key(self, ids: tuple[str, ...]) -> tuple[Any, ...]:
        """What breaks ties: power, cost, mass, lamps, pulse, ids."""
        return (*self.figures, self.count, self.pulse_s, ids)


class Ranking:
    """The best designs with distinct hardware, and what a further design must beat to enter."""

    def __init__(self, problem: Problem, imagers: Imagers, *, top: int, ceiling: float):
        self.problem, self.imagers, self.top, self.ceiling = problem, imagers, top, ceiling
        self.best: list[Found] = []
        self.known_ids: dict[tuple[int, int, int, int], tuple[str, ...]] = {}
        self._listed, self._by_ids = self.best, dict[tuple[str, ...], Found]()

    def among(self, imagers: Imagers) -> Self:
        """The same, for designs of other imagers to enter; what was found stays."""
        made = copy(self)
        made.imagers, made._by_ids = imagers, dict(self._by_ids)
        return made

    def threshold(self) -> float:
        """The objective that a design must not exceed to matter: that of the last place, ties included."""
        if len(self.best) < self.top:
            return self.ceiling
        worst = self.best[-1].minimised
        return min(worst + TIE * abs(worst), self.ceiling)

    def shut_out(self, value: Array, power: Array, cost: Array, mass: Array | float = 0.0) -> Array:
        """Designs that get no place, by lower bounds of their objective, power, cost and mass, (n,).

        They exceed the threshold, or tie at best with designs that come before them in power, in cost or in mass.
        """
        limit, out = self.threshold(), value > self.threshold()
        if len(self.best) < self.top:
            return out
        tied = np.flatnonzero(~out & (value >= limit - 3 * TIE * abs(limit)))
        if len(tied):
            own = [told_apart(np.broadcast_to(one, out.shape)[tied] * (1.0 - SLACK)) for one in (power, cost, mass)]
            near = [one for one in self.best if one.minimised >= limit - 8 * TIE * abs(limit)]  # none passes others
            out[tied] = ~np.any([self._may_pass(design, value[tied], own) for design in near], axis=0)
        return out

    def _may_pass(self, design: Found, value: Array, own: list[Array]) -> Array:
        """Whether a design may come before one that is known, by lower bounds of its objective and of its tie key."""
        least, slack = design.minimised, TIE * abs(design.minimised)
        before, level = np.zeros(len(value), bool), np.ones(len(value), bool)
        for mine, its in zip(own, design.figures, strict=True):
            before |= level & (mine < its)
            level &= mine == its
        tied = value <= least + TIE * np.maximum(np.abs(value), abs(least))
        return (value < least - slack) | (tied & (before | level))

    def add(self, designs: NodeDesigns, value: Array, terms: Terms, chosen: list[Chosen]) -> None:
        """Merge designs into the list of the best with other hardware; of each its objective, terms and settings."""
        hopeful = np.nonzero(np.isfinite(value) & (value <= self.threshold()))[0]
        if len(hopeful) == 0:
            return
        pulse = np.max([c.time_s[hopeful] for c in chosen], axis=0)
        tie_class = np.round(value[hopeful] / (TIE * max(float(np.abs(value[hopeful]).min()), 1e-12)))
        keys = (
            pulse,
            designs.count[hopeful],
            *(told_apart(figure[hopeful]) for figure in (terms.mass, terms.cost, terms.power)),
            tie_class,
        )
        order = hopeful[np.lexsort(keys)]
        order = order[~self.shut_out(value[order], terms.power[order], terms.cost[order], terms.mass[order])]
        im = self.imagers
        rows = designs.row[order]
        # each hardware's best comes first
        first, _ = rows_alike(im.camera[rows], im.lens[rows], im.port[rows], designs.light[order])
        order = order[np.sort(first)]
        while len(order):
            i, known = int(order[0]), self.best
            self._insert(self._found(i, designs, float(value[i]), terms, chosen))
            order = order[1:]
            if self.best is not known:
                order = order[~self.shut_out(value[order], terms.power[order], terms.cost[order], terms.mass[order])]

    def _found(self, i: int, designs: NodeDesigns, value: float, terms: Terms, chosen: list[Chosen]) -> Found:
        node = int(designs.node[i])
        return Found.of(
            self.imagers, int(designs.imager[node]), [one.of_row(i) for one in chosen], light=int(designs.light[i]),
            count=int(designs.count[i]), lighting=designs.under.of(node), minimised=value,
            power_w=float(terms.power[i]), cost=float(terms.cost[i]), mass_kg=float(terms.mass[i]),
            snr_db=float(terms.snr_db[i]),
        )  # fmt: skip

    def _insert(self, design: Found) -> None:
        """Put a design in its place; of equal hardware only the better stays."""
        parts, own = self.problem.parts, self._ids(design)
        same = self._of_ids(own)
        if same is not None and not comes_before(design, same, parts):
            return
        rest = [f for f in self.best if f is not same]
        ahead = design.minimised - 4.0 * TIE * abs(design.minimised)  # none of these is passed
        first = bisect_left(rest, ahead, key=lambda f: f.minimised)
        place = next((n for n in range(first, len(rest)) if comes_before(design, rest[n], parts)), len(rest))
        rest.insert(place, design)
        self.best = rest[: self.top]
        self._by_ids[own], self._listed = design, self.best

    def _of_ids(self, own: tuple[str, ...]) -> Found | None:
        """The best design of these parts, if one was listed: what is worse than one that has left never enters."""
        if self._listed is not self.best:  # it was set anew
            self._listed, self._by_ids = self.best, {self._ids(f): f for f in self.best}
        return self._by_ids.get(own)

    def _ids(self, design: Found) -> tuple[str, ...]:
        """Ids of a design's parts, kept: long lists ask for them often."""
        place = design.camera, design.lens, design.port, design.light
        if place not in self.known_ids:
            self.known_ids[place] = ids_in(self.problem.parts, design)
        return self.known_ids[place]


def ids_in(parts: Parts, design: Found) -> tuple[str, str, str, str]:
    """Ids of a design's parts."""
    own = parts.of(design)
    return own["camera"].id, own["lens"].id, own["port"].enclosure_id, own["light"].id


def comes_before(a: Found, b: Found, parts: Parts) -> bool:
    """Whether a design of these parts has its place before another: by objective, else by its key."""
    if abs(a.minimised - b.minimised) > TIE * max(abs(a.minimised), abs(b.minimised)):
        return a.minimised < b.minimised
    return a.tie_key(ids_in(parts, a)) < b.tie_key(ids_in(parts, b))
