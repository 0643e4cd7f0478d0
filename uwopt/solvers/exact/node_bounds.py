"""What bounds of nodes are made of: the bounds as columns, and the rules that they keep or miss."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.model import information, sharpness
from uwopt.objectives.objective import Terms
from uwopt.units import db_to_ratio

NODE_RULES = (
    "light", "cost", "mass_kg", "power_w", "energy_wh", "max_white_balance", "min_mtf_half_nyquist", "resolve_mm",
    "bound",
)  # fmt: skip


@dataclass(frozen=True)
class NodeBounds(Columns):
    """Bounds of every imager under one lighting; `rule` names why a node cannot be feasible, -1: it may be."""

    value: Array
    power: Array
    mean_power_w: Array  # over the scenes' shares of time
    cost: Array
    mass: Array
    snr_db: Array
    rule: Array
    information: Array  # bit/m2, worst scene
    contrast: Array

    @staticmethod
    def none(n: int) -> NodeBounds:
        """No bound at all: everything may be best."""
        low, most = np.full(n, -1e300), np.full(n, np.inf)
        return NodeBounds(low, low, low, low, low, most, np.full(n, -1), most, np.ones(n))

    @staticmethod
    def missing(n: int, rule: str) -> NodeBounds:
        """Nothing can be reached, for one rule."""
        least, most, none = np.full(n, np.inf), np.full(n, -np.inf), np.zeros(n)
        return NodeBounds(least, least, least, least, least, most, np.full(n, NODE_RULES.index(rule)), most, none)

    def but_for(self, rule: str, lost: Array) -> NodeBounds:
        """The same where some that no rule before has discarded fall by one more."""
        fall = (self.rule < 0) & lost
        return replace(
            self, rule=np.where(fall, NODE_RULES.index(rule), self.rule), value=np.where(fall, np.inf, self.value)
        )

    def better_of(self, other: NodeBounds) -> NodeBounds:
        """The lower bound of two groups of lights; a node fails only if both fail, by the later rule."""
        both = (self.rule >= 0) & (other.rule >= 0)
        least, most = (
            {name: better(getattr(self, name), getattr(other, name)) for name in names}
            for better, names in ((np.minimum, LEAST), (np.maximum, MOST))
        )
        return NodeBounds(rule=np.where(both, np.maximum(self.rule, other.rule), -1), **least, **most)

    def terms(self, rows: Array | slice, gsd_mm: Array) -> Terms:
        """The best of each term at some rows, of which the pixels are these."""
        at = self.take(rows)
        return Terms(at.power, at.cost, at.mass, at.snr_db, gsd_mm, at.contrast, at.information)


LEAST, MOST = ("value", "power", "mean_power_w", "cost", "mass"), ("snr_db", "information", "contrast")


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
