"""From a front's points to designs: few enough to show, evaluated again through the forward model, named."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from uwopt.arrays import Array
from uwopt.objectives.axes import Axes, Frame
from uwopt.objectives.dominance import NEAR, unlike_rows
from uwopt.objectives.objective import MAXIMISED, UNITS
from uwopt.quantities import TERMS
from uwopt.results.front import FrontObjective, FrontPoint, Pick
from uwopt.solvers.exact.node_designs import WithLamps
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.front.search import Front
from uwopt.units import listed

MOST_POINTS = 160  # of a front that are shown
KNEE = "the point nearest to the best corner, axes scaled to the front's range"
IN_WORDS = {term: one.best for term, one in TERMS.items() if one.best}
BEST_IMAGE = ("information", "snr_db", "contrast", "gsd_mm")


def found_of(search: Search, front: Front, place: int) -> Found:
    """One point of a front as the search's record of a design."""
    some, answers, at = front.designs[place]
    d, imagers = int(answers.design[at]), search.imagers
    imager, k = int(some.imager[d]), int(some.lighting[d])
    own = WithLamps.of(search.problem, imagers, *(each[d : d + 1] for each in (some.imager, some.light, some.count)))
    return Found.of(
        imagers, imager, [chosen.of_row(at) for chosen in answers.chosen], light=int(some.light[d]),
        count=int(some.count[d]), lighting=search.tables.lightings[k], minimised=0.0,
        power_w=float(answers.power_w[at]), cost=float(own.cost[0]), mass_kg=float(own.mass_kg[0]), snr_db=math.nan,
    )  # fmt: skip


def few(values: Array, frame: Frame) -> Array:
    """Places of points that stand for all: the best of every axis and the knee, then those that lie farthest apart.

    No two of them are within 0.1 % of each other in every objective.
    """
    order = unlike_rows(values, frame.log)
    unit = frame.unit(values[order])
    chosen = list(dict.fromkeys([*(int(i) for i in unit.argmin(axis=0)), knee(unit)]))
    gap = np.min([np.abs(unit - unit[place]).max(axis=1) for place in chosen], axis=0)
    while len(chosen) < min(MOST_POINTS, len(order)):
        chosen.append(int(gap.argmax()))
        gap = np.minimum(gap, np.abs(unit - unit[chosen[-1]]).max(axis=1))
    return order[np.array(sorted(set(chosen)))]


def knee(unit: Array) -> int:
    """The point nearest to the best corner."""
    return int(np.square(unit).sum(axis=1).argmin())


def picks_of(points: Sequence[FrontPoint], objectives: Sequence[FrontObjective], frame: Frame) -> list[Pick]:
    """The points that people ask for by name; within 0.1 % the better in the other objectives is taken."""
    if not points:
        return []
    signs = np.array([o.sign for o in objectives])
    names = [o.name for o in objectives]
    values = np.array([[p.values[name] for name in names] for p in points]) * signs
    unit = frame.unit(values)
    found = []
    quality = next((name for name in BEST_IMAGE if name in names), None)
    for title, name, text in (
        ("cheapest", "cost", "the point of least cost"),
        ("least power", "power", "the point of least power"),
        ("best image", quality, f"the point of {IN_WORDS.get(str(quality), str(quality))}"),
    ):
        if name is None or name not in names:
            continue
        column = values[:, names.index(name)]
        tied = np.nonzero(column <= column.min() + NEAR * abs(column.min()))[0]
        best = tied[unit[tied].sum(axis=1).argmin()]
        among = ", and of those within 0.1 % of it the best in the other objectives" if len(tied) > 1 else ""
        found.append(Pick(title, points[int(best)].id, text + among))
    by_log = [name for name, log in zip(names, frame.log, strict=True) if log]
    logs = listed([TERMS[name].words if name in TERMS else name for name in by_log])
    return [*found, Pick("knee", points[knee(unit)].id, KNEE + (f" (logarithms of {logs})" if logs else ""))]


def objectives_of(axes: Axes, currency: str) -> list[FrontObjective]:
    """The axes as a result names them."""
    return [
        FrontObjective(
            name, "maximise" if name in MAXIMISED else "minimise", currency if name == "cost" else UNITS[name]
        )
        for name in axes.names
    ]
