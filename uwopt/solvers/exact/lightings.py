"""Light optics at mounts: lights that share beam and spectrum share every signal per lumen. The lamps of each that
bounds of nodes choose from, and of each kind in it by what they can give.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward import switching
from uwopt.forward.columns import Columns, distinct
from uwopt.forward.flash_times import FlashTimes
from uwopt.forward.lamps import LampGroup, Mount
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.problem import Problem
from uwopt.tolerances import COARSE_ROUND


@dataclass(frozen=True)
class Lighting:
    """One light optics at one mount."""

    optics: int
    mount_index: int
    mount: Mount

    def of(self, count: int) -> LampGroup:
        """So many of its lamps."""
        return LampGroup(self.optics, self.mount, count)


@dataclass(frozen=True)
class Under:
    """Which lighting each of n rows is under."""

    lightings: Sequence[Lighting]
    index: Array  # (n,) into these

    @staticmethod
    def one(lighting: Lighting, n: int) -> Under:
        """All rows under the same."""
        return Under([lighting], np.zeros(n, int))

    @staticmethod
    def at(problem: Problem, optics: Array, mount: Array) -> Under:
        """Rows of some light optics at some mounts, by their places, (n,) each."""
        return Under(lightings(problem), optics * len(problem.mounts) + mount)

    def take(self, rows: Array) -> Under:
        """These rows only."""
        return replace(self, index=self.index[rows])

    def of(self, row: int) -> Lighting:
        """The lighting of one row."""
        return self.lightings[int(self.index[row])]

    def each(self) -> Iterator[tuple[Lighting, Array]]:
        """Each lighting that some rows are under, with these rows."""
        for k in distinct(self.index)[0]:
            yield self.lightings[int(k)], np.flatnonzero(self.index == k)

    def with_number(self, count: Array) -> Iterator[tuple[Lighting, int, Array]]:
        """Each lighting with each number of its lamps, `count` (n,) of the rows, and the rows of both."""
        for lighting, mine in self.each():
            for number in distinct(count[mine])[0]:
                yield lighting, int(number), mine[count[mine] == number]

    def by_optics(self) -> Iterator[tuple[int, Array]]:
        """Each light optics, and the rows that it lights from whatever mount."""
        optics = np.array([one.optics for one in self.lightings])[self.index]
        for value in distinct(optics)[0]:
            yield int(value), np.flatnonzero(optics == value)


def lightings(problem: Problem) -> list[Lighting]:
    """All pairs of light optics and mount."""
    return [
        Lighting(optics, index, mount)
        for optics in range(len(problem.optics))
        for index, mount in enumerate(problem.mounts)
    ]


# ---------------------------------------------------------------- the lamps of each


MOST_PLACES = 1024  # rows and columns of a table of lights
AS_MUCH = 1.0 - 1e-12  # of what is wanted, to rounding


@dataclass(frozen=True)
class LampChoices(Columns):
    """All (light, count) of one lighting, as columns."""

    light: Array
    count: Array
    cost: Array
    limit_cost: Array
    mass_kg: Array
    effective: Array  # count * full light * output factor: lm, or lm s a pulse
    power_per_light: Array  # electrical per unit of effective light
    kind: Array
    max_rate_hz: Array  # images that it keeps up with; inf where it burns on

    @staticmethod
    def of(problem: Problem, lighting: Lighting, searched: Array) -> LampChoices:
        """The lights of one lighting that are searched, in every number."""
        mine = np.nonzero((problem.lights.optics_index == lighting.optics) & searched)[0]
        low, high = problem.count_range
        light = np.repeat(mine, high - low + 1)
        count = np.tile(np.arange(low, high + 1), len(mine))
        rows = problem.lights.take(light)
        effective = count * rows.full_light * rows.output_factor
        with np.errstate(divide="ignore", invalid="ignore"):
            drawn = np.where(rows.kind == FLASH, rows.pulse_energy_j, rows.full_power_w)
            per_light = drawn / (rows.full_light * rows.output_factor)
        return LampChoices(
            light,
            count,
            problem.lamps_cost(light, count),
            problem.lamps_cost(light, count, "limit_price"),
            rows.mass_kg * count,
            effective,
            per_light,
            rows.kind,
            np.where(rows.kind == CONTINUOUS, np.inf, rows.max_rate_hz),
        )


@dataclass(frozen=True)
class Corner:
    """Least value of the lights that have a capacity and stay within a budget, at once."""

    budget: Array  # what lights take of it at least, by column, increasing
    least: Array  # by place in the order of capacity and by budget: of the lights from a place on, up to a budget
    size: int  # number of lights
    step: int  # lights that share a row, and that share a column

    @staticmethod
    def of(value: Array, budget: Array) -> Corner:
        """From the columns of lights in the order of their capacity; very many of them share rows and columns."""
        n = len(value)
        step = -(-n // MOST_PLACES)
        order, places = np.argsort(budget, kind="stable"), np.arange(n) // step
        column = np.empty(n, int)
        column[order] = places
        least = np.full((places[-1] + 1, places[-1] + 1), np.inf)
        np.fmin.at(least, (places, column), value)
        least = np.minimum.accumulate(least[::-1], axis=0)[::-1]
        return Corner(budget[order][::step], np.minimum.accumulate(least, axis=1), n, step)

    def within(self, capacity_at: Array, budget: Array) -> Array:
        """Least value from a place in the order of capacity on; inf when no light is within the budget."""
        place = np.searchsorted(self.budget, budget, side="right") - 1
        known = (place >= 0) & (capacity_at < self.size)
        row = np.minimum(capacity_at, self.size - 1) // self.step
        return np.where(known, self.least[row, np.maximum(place, 0)], np.inf)


@dataclass(frozen=True)
class LampsOfKind:
    """The lamps of one kind in one lighting, those that give least first."""

    kind: int
    lamps: LampChoices
    lead_s: float  # least that any is on before its light counts, between images of which it may be off; inf: none
    dimmest: float  # the least that any draws at its lowest level: W, or J a flash
    least: dict[str, Array]  # by column, of each lamp and all that give as much; inf beyond the last
    _corners: dict[str, Corner] = field(default_factory=dict)

    @staticmethod
    def each(problem: Problem, table: LampChoices) -> Iterator[LampsOfKind]:
        """Every kind that a lighting has."""
        for kind in np.unique(table.kind):
            own = table.take(table.kind == kind)
            yield LampsOfKind.of(problem, int(kind), own.take(np.argsort(own.effective)))

    @staticmethod
    def of(problem: Problem, kind: int, lamps: LampChoices) -> LampsOfKind:
        """Of lamps in this order."""
        rows = problem.lights.take(lamps.light)
        vehicles = [scene.view.vehicle for scene in problem.scenes]
        switched = np.any([switching.are_switched(vehicle, rows) for vehicle in vehicles], axis=0)
        steps = np.fmin.reduce(rows.levels, axis=1)
        level = np.where(rows.dims_freely, rows.min_level, np.where(np.isnan(steps), 1.0, steps))
        drawn = level * lamps.effective * lamps.power_per_light
        least = {
            name: np.append(suffix_min(getattr(lamps, name)), np.inf)
            for name in ("power_per_light", "cost", "limit_cost", "mass_kg")
        }
        return LampsOfKind(
            kind, lamps, float(np.where(switched, rows.warm_up_s, np.inf).min(initial=np.inf)),
            float(np.fmin.reduce(drawn, initial=np.inf)), least,  # a lamp without light has no number
        )  # fmt: skip

    @property
    def capacity(self) -> Array:
        """Light at full level, rising: lm, or lm s a pulse."""
        return self.lamps.effective

    def from_capacity(self, wanted: Array) -> Array:
        """The first that give as much, by place; beyond the last where none does."""
        return np.searchsorted(self.capacity, wanted * AS_MUCH)

    def keep_up(self, place: Array, rate_hz: Array) -> Array:
        """Whether any lamp from a place on keeps up with the images, to rounding."""
        return rate_hz <= np.append(-suffix_min(-self.lamps.max_rate_hz), -np.inf)[place] * COARSE_ROUND

    def least_within(self, name: str, budget: str, place: Array, most: Array) -> Array:
        """Least of a column from a place on of lamps that take no more of another; inf where there is none."""
        if name not in self._corners:
            self._corners[name] = Corner.of(getattr(self.lamps, name), getattr(self.lamps, budget))
        return self._corners[name].within(place, most)

    def on_share(self, rate_hz: Array, time_s: Array | float) -> Array:
        """Least share of the time that any of them burns for a time of light; 1 where they burn on."""
        if not np.isfinite(self.lead_s):
            return np.ones_like(rate_hz)
        return np.minimum(1.0, rate_hz * (self.lead_s + time_s))

    def used(self, rate_hz: Array, longest_s: Array, light_time: Array, wanted: Array) -> Array:
        """Mean light [lm] that is paid for at least: all that burns, for as long as it is on."""
        if self.kind != CONTINUOUS:
            return np.asarray(light_time * rate_hz)
        return np.asarray(wanted * self.on_share(rate_hz, longest_s))


def suffix_min(values: Array) -> Array:
    """Least of each value and all after it."""
    return np.fmin.accumulate(values[::-1])[::-1]


def quickest(flashes: FlashTimes) -> Iterator[FlashTimes]:
    """Of flashes that fade, and of those that do not, the one that gives the greatest share of its light first."""
    fades = np.isfinite(flashes.decay_s)
    for mine in (fades, ~fades):
        if mine.any():
            yield flashes.take(np.argmin(np.where(mine, flashes.whole_s, np.inf), keepdims=True))
