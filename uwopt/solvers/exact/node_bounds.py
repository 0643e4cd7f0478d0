"""What bounds of nodes are made of: the lamps to choose from, what imagers need, and the bounds as columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.columns import Columns
from uwopt.forward.flash_times import FlashTimes
from uwopt.forward.part_columns import CONTINUOUS, FLASH, Cameras
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.model import information, sharpness
from uwopt.model.image_mean import FRAME_SHARE
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.lightings import Lighting
from uwopt.units import db_to_ratio

Array = NDArray[Any]
MOST_PLACES = 1024  # rows and columns of a table of lights
LATTICE_MARGIN = 0.95  # of a share of the image that is counted at places: discs are met to 0.01 of the image
NODE_RULES = ("light", "cost", "mass_kg", "power_w", "energy_wh", "max_white_balance", "bound")


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
class Needs:
    """What imagers need in one scene before any light is chosen."""

    by_snr_e: Array  # electrons of the mean, at the farthest altitude and the nominal one, (n, 2)
    by_pixel_e: Array  # of the pixel that must reach the SNR, at the farthest altitude
    by_red_e: Array | None  # of the red channel, at every altitude; None: nothing is asked of it
    by_gain_e: Array  # electrons, at the nominal altitude
    sun_e: Array  # electrons of the sun's signal at most, at the farthest altitude and the nominal one, (n, 2)
    square: Array  # of the smallest working f-number
    longest_s: Array
    rate_hz: Array


@dataclass
class NodeBounds:
    """Bounds of every imager under one lighting; `rule` names why a node cannot be feasible, -1: it may be."""

    value: Array
    power: Array
    mean_power_w: Array  # over the scenes' shares of time
    cost: Array
    mass: Array
    snr_db: Array
    rule: Array
    information: Array | float = np.inf  # bit/m2, worst scene
    contrast: Array | float = 1.0
    slack: Array | float = np.inf  # how many times as much light and power as is needed there is at most

    @staticmethod
    def none(n: int) -> NodeBounds:
        """No bound at all: everything may be best."""
        low = np.full(n, -1e300)
        return NodeBounds(low, low, low, low, low, np.full(n, np.inf), np.full(n, -1))

    @staticmethod
    def empty(n: int) -> NodeBounds:
        """No light yet: nothing can be reached."""
        inf = np.full(n, np.inf)
        lowest = np.full(n, -np.inf)
        power, mean_power, cost, mass = (inf.copy() for _ in range(4))
        none = np.zeros(n)
        return NodeBounds(
            inf, power, mean_power, cost, mass, lowest, np.zeros(n, int), lowest.copy(), none.copy(), none
        )  # fmt: skip

    def with_rows(self, index: Array, other: NodeBounds) -> NodeBounds:
        """With the bounds of others in these rows."""
        columns = {}
        for field in fields(NodeBounds):
            column = np.array(np.broadcast_to(getattr(self, field.name), self.value.shape))
            column[index] = getattr(other, field.name)
            columns[field.name] = column
        return NodeBounds(**columns)

    def better_of(self, other: NodeBounds) -> NodeBounds:
        """The lower bound of two groups of lights; a node fails only if both fail, by the later rule."""
        both = (self.rule >= 0) & (other.rule >= 0)
        rule = np.where(both, np.maximum(self.rule, other.rule), -1)
        return NodeBounds(
            np.minimum(self.value, other.value),
            np.minimum(self.power, other.power),
            np.minimum(self.mean_power_w, other.mean_power_w),
            np.minimum(self.cost, other.cost),
            np.minimum(self.mass, other.mass),
            np.maximum(self.snr_db, other.snr_db),
            rule,
            np.maximum(self.information, other.information),
            np.maximum(self.contrast, other.contrast),
            np.maximum(self.slack, other.slack),
        )

    def terms(self, rows: Array, gsd_mm: Array) -> Terms:
        """The best of each term at some rows, of which the pixels are these."""
        information, contrast = (
            np.broadcast_to(each, len(self.value))[rows] for each in (self.information, self.contrast)
        )
        return Terms(
            self.power[rows], self.cost[rows], self.mass[rows], self.snr_db[rows], gsd_mm, contrast, information
        )


def first_missed(rules: Sequence[tuple[str, Array]]) -> Array:
    """The first of some rules that each row misses, as a place among `NODE_RULES`; -1: it keeps them all."""
    rule = np.full(np.shape(rules[0][1]), -1, np.int8)
    for name, kept in rules:
        rule = np.where((rule < 0) & ~kept, np.int8(NODE_RULES.index(name)), rule)
    return rule


def by_rule(rule: Array) -> Iterator[tuple[str, Array]]:
    """The rows that each of `NODE_RULES` discards, by its place there."""
    for index, name in enumerate(NODE_RULES):
        yield name, np.flatnonzero(rule == index)


def suffix_min(values: Array) -> Array:
    """Least of each value and all after it."""
    return np.fmin.accumulate(values[::-1])[::-1]


@cache
def information_table() -> tuple[Array, Array, Array]:
    """Bit per px by SNR [dB] and rated pitch [px], blurred by pixel and lens rating alone."""
    snr_db, rated = np.linspace(-60.0, 120.0, 361), np.linspace(0.0, 4.0, 41)
    at = sharpness.Sharpness(
        working_f_number=0.0, wavelength_nm=500.0, pixel_pitch_m=1e-6, lens_pitch_px=rated
    )
    gains = information.TEXTURE_CONTRAST * db_to_ratio(snr_db)
    return snr_db, rated, information.information_of_gains(gains, sharpness=at).T


def bit_per_px_bound(snr_db: Array, rated_pitch_px: Array) -> Array:
    """Upper bound from the table: the next SNR up, the next rating down; its quadrature errs by 1e-4 at most."""
    levels, ratings, table = information_table()
    above = np.searchsorted(levels, snr_db)
    row = np.minimum(above, len(levels) - 1)
    column = np.clip(np.searchsorted(ratings, rated_pitch_px, side="right") - 1, 0, len(ratings) - 1)
    return np.where(above < len(levels), table[row, column] * (1 + 1e-4), np.inf)


def quickest(flashes: FlashTimes) -> Iterator[FlashTimes]:
    """Of flashes that fade, and of those that do not, the one that gives the greatest share of its light first."""
    fades = np.isfinite(flashes.decay_s)
    for mine in (fades, ~fades):
        if mine.any():
            yield flashes.take(np.argmin(np.where(mine, flashes.whole_s, np.inf), keepdims=True))


def least_mean_frac(scene: SceneOptics) -> float:
    """Least mean signal of an image over that of the pixel that must reach the SNR.

    No mean is below its darkest pixel. Where a share of the image may be dark, the mean has at least the rest's.
    """
    return FRAME_SHARE * LATTICE_MARGIN if scene.pixels == "frame" else 1.0


def most_held_e(cameras: Cameras, scene: SceneOptics) -> Array:
    """The most electrons of all light that sensors hold as a mean at the nominal altitude, (n,)."""
    needs, full_scale = scene.view.requirements, 2.0**cameras.bits - 1.0
    share = 1.0 / needs.highlight_ratio if needs.mean_level is None else needs.mean_level
    by_level = (share * full_scale - cameras.black_level_dn) / cameras.gain_dn_per_e
    return np.asarray(np.minimum(cameras.saturation_e / needs.highlight_ratio, by_level))
