"""The axes of a front: two or three terms of an objective, turned so that less is better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.documents.faults import nearest
from uwopt.errors import MissionError
from uwopt.objectives.objective import MAXIMISED, UNITS, Objective, Terms

LOGARITHMIC = ("power", "cost", "mass")  # compared by ratio, where they are above 0
OF_SETTINGS = ("snr_db", "information")  # qualities that the settings of given hardware change
DEFAULT = ("power", "cost", "information")
FEWEST, MOST = 2, 3


def plain_names(names: Sequence[str]) -> list[str]:
    """Names of terms as uwopt writes them; a MissionError tells of the unknown and the repeated."""
    plain = [str(name).strip().casefold().replace("-", "_") for name in names]
    faults = []
    for given, name in zip(names, plain, strict=True):
        if name not in UNITS:
            near = nearest(name, UNITS)
            hint = f"did you mean {near}?" if near else f"there are {', '.join(UNITS)}."
            faults.append(f"objectives: {str(given).strip()!r} is no figure that can be best; {hint}")
    twice = sorted({name for name in plain if plain.count(name) > 1 and name in UNITS})
    faults += [f"objectives: {name} stands twice; name each once." for name in twice]
    if faults:
        raise MissionError(faults)
    return plain


@dataclass(frozen=True)
class Axes:
    """Names of the terms, in the order of the columns of every array of values (n, n_axes)."""

    names: tuple[str, ...]

    @staticmethod
    def of(names: Sequence[str]) -> Axes:
        """Axes by name; a MissionError says what is wrong with them."""
        plain = plain_names(names)
        if not FEWEST <= len(plain) <= MOST:
            number = "one objective has" if len(plain) == 1 else f"{len(plain)} objectives have"
            other = "`uwopt solve` finds the best of one" if len(plain) == 1 else "leave some out"
            raise MissionError(
                f"objectives: {number} no front that can be shown; name two or three of {', '.join(UNITS)}, or {other}."
            )
        return Axes(tuple(plain))

    def __len__(self) -> int:
        return len(self.names)

    @property
    def objective(self) -> Objective:
        """All axes with weight 1: what a search must know about."""
        return Objective(dict.fromkeys(self.names, 1.0))

    @property
    def signs(self) -> Array:
        """-1 for what is maximised."""
        return np.array([-1.0 if name in MAXIMISED else 1.0 for name in self.names])

    def minimised(self, terms: Terms) -> Array:
        """Values (n, n_axes), less is better."""
        columns = [np.broadcast_to(getattr(terms, name), np.shape(terms.power)) for name in self.names]
        return np.stack(columns, axis=1) * self.signs

    def index(self, name: str) -> int | None:
        """Column of a term, None where it is no axis."""
        return self.names.index(name) if name in self.names else None

    def logarithmic(self, values: Array) -> Array:
        """Which axes are compared by ratio, (n_axes,): those that ask for it and are above 0 in all values."""
        asked = np.array([name in LOGARITHMIC for name in self.names])
        return np.asarray(asked & (values > 0.0).all(axis=0))


@dataclass(frozen=True)
class Frame:
    """The box in which fronts are compared: from their best corner to 1.1 times their range, logarithms where apt.

    Hypervolumes are shares of that box.
    """

    log: Array  # (n_axes,) whether an axis is compared by ratio
    ideal: Array  # in scaled values
    span: Array
    margin: float = 0.1

    @staticmethod
    def of(axes: Axes, values: Array) -> Frame:
        """The frame of a front's values (n, n_axes), less is better."""
        log = axes.logarithmic(values)
        scaled = scale(values, log)
        ideal = scaled.min(axis=0)
        span = scaled.max(axis=0) - ideal
        flat = 1e-9 * np.maximum(np.abs(ideal), 1.0)  # an axis on which all points agree
        return Frame(log, ideal, np.where(span > flat, span, np.maximum(np.abs(ideal), 1.0)))

    def unit(self, values: Array) -> Array:
        """Values with the best corner at 0 and the worst of the front at 1."""
        return np.asarray((scale(values, self.log) - self.ideal) / self.span)

    @property
    def reference(self) -> Array:
        """The corner that hypervolumes are measured from, in units of `unit`."""
        return np.full(len(self.span), 1.0 + self.margin)

    def values(self, unit: Array) -> Array:
        """Values of places in the frame: the inverse of `unit`."""
        scaled = unit * self.span + self.ideal
        return np.where(self.log, np.exp(np.where(self.log, scaled, 0.0)), scaled)


def scale(values: Array, log: Array) -> Array:
    """Logarithms of the axes that are compared by ratio; what is 0 there is far below all."""
    positive = np.maximum(values, 1e-300)
    return np.where(log, np.log(np.where(log, positive, 1.0)), values)
