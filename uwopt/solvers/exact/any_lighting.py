"""Which imagers no lamp at any mount gives light enough: known of all lightings at once, before each is bounded.

    light_i(V, q) = max_o [ max_m response_om(q) max_m light_om(rectangle) ]

is no less than the light under any lighting of optics o at a mount m, and the ablest lamp of a kind, however its light
spreads, is no less able than any. Who needs more than both together, or images sooner than the quickest of a kind
flashes again, is discarded by the rule of light under each lighting: one bound of an imager stands for those under all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline, spend
from uwopt.solvers.exact.floor_rectangles import FloorLightBound
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.lightings import Lighting
from uwopt.tolerances import COARSE_ROUND

if TYPE_CHECKING:
    from uwopt.solvers.exact.bounds import Bounds

FEW = 3  # lightings: fewer are as soon bounded one by one
ROUNDING = 1e-9  # of sums in another order


@dataclass(frozen=True)
class Ablest:
    """The lamps of one kind in all lightings."""

    light: Array
    most: float  # effective light of the ablest, lm, or lm s a pulse; inf where one has no number
    max_rate_hz: float  # images that the quickest keeps up with
    optics: frozenset[int]


@dataclass(frozen=True)
class AnyLighting:
    """All lightings of some bounds as if they were one."""

    bounds: Bounds

    @cached_property
    def kinds(self) -> dict[int, Ablest]:
        """The lamps that are searched, by kind."""
        tables, lightings = self.bounds.light_tables, self.bounds.tables.lightings
        made = {}
        for kind in sorted({int(kind) for table in tables for kind in table.kind}):
            own = [(lighting, table, table.kind == kind) for lighting, table in zip(lightings, tables, strict=True)]
            effective = np.concatenate([table.effective[mine] for _, table, mine in own])
            most = float(np.where(np.isnan(effective), np.inf, effective).max())
            light = np.unique(np.concatenate([table.light[mine] for _, table, mine in own]))
            rate_hz = max(float(table.max_rate_hz[mine].max(initial=0.0)) for _, table, mine in own)
            optics = frozenset(lighting.optics for lighting, _, mine in own if mine.any())
            made[kind] = Ablest(light, most, rate_hz, optics)
        return made

    def leaves_dark(self, rows: Array, deadline: Deadline = NEVER) -> Array:
        """Which of these imagers the rule of light discards under every lighting, (n,). Raises OutOfTimeError."""
        bounds, tables, n = self.bounds, self.bounds.tables, len(rows)
        if n == 0 or len(tables.lightings) < FEW or tables.problem.paper:
            return np.zeros(n, bool)
        scenes = range(len(bounds.imagers.scenes))
        dark, signals = np.ones(n, bool), [self._signals(index, rows, deadline) for index in scenes]
        for kind, ablest in self.kinds.items():
            spend("bounds", n)
            enough = np.ones(n, bool)
            for index, by_optics in enumerate(signals):
                need, signal = bounds.needs.of(index, rows), np.max([by_optics[o] for o in ablest.optics], axis=0)
                wanted = bounds.capacity_needed(need, signal, kind, ablest.light)
                enough &= wanted * (1.0 - ROUNDING) <= ablest.most
                enough &= need.rate_hz <= ablest.max_rate_hz * COARSE_ROUND
            dark &= ~enough
        return dark

    def _signals(self, scene_index: int, rows: Array, deadline: Deadline) -> dict[int, Array]:
        """Most electrons per lm s at the farthest altitude and the nominal one by optics, (n, 2)."""
        tables, scene = self.bounds.tables, self.bounds.problem.scenes[scene_index]
        altitudes = len(scene.range_m) - 1, scene.nominal
        made = {}
        for optics, some in of_like_optics(tables.lightings).items():
            deadline.check()
            most = [brightest(tables, scene_index, some, altitude, rows) for altitude in altitudes]
            made[optics] = np.stack(most, axis=1)
        return made


def of_like_optics(lightings: Sequence[Lighting]) -> dict[int, list[Lighting]]:
    """Lightings that differ in their mount alone, together."""
    return {optics: list(some) for optics, some in groupby(lightings, key=lambda lighting: lighting.optics)}


def brightest(tables: FieldTables, scene_index: int, some: list[Lighting], altitude: int, rows: Array) -> Array:
    """As `FieldTables.bound`, under whichever of these lightings is the brightest, (n,)."""
    rectangle = tables.rectangles_of_chunk(scene_index, altitude, rows)
    key = scene_index, some[0].optics, altitude
    if key not in tables.brightest:
        tables.brightest[key] = merged([tables.light_table(scene_index, one, altitude) for one in some])
    response = tables.most_response(scene_index, some, altitude, rows)
    light = np.max([table.most_light(rectangle) for table in tables.brightest[key]], axis=0)
    collecting = tables.imagers.scenes[scene_index].view.collecting_m2[rows]
    return np.asarray(collecting * response * light * rectangle.samples_per_m2)


def merged(every: list[FloorLightBound]) -> list[FloorLightBound]:
    """The most of all tables of light, one of each size."""
    made: dict[tuple[float, ...], FloorLightBound] = {}
    for table in every:
        size = float(table.along_m[-1]), float(table.across_m[-1])
        if table.behind is not None:
            size += float(table.behind.along_m[-1]), float(table.behind.across_m[-1])
        made[size] = brighter(made[size], table) if size in made else table
    return list(made.values())


def brighter(one: FloorLightBound, other: FloorLightBound) -> FloorLightBound:
    """The most of two tables of the same size."""
    behind = one.behind and other.behind and brighter(one.behind, other.behind)
    return replace(
        one, light=np.maximum(one.light, other.light), peak_per_m2=max(one.peak_per_m2, other.peak_per_m2),
        behind=behind,
    )  # fmt: skip
