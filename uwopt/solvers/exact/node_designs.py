"""Designs of nodes, and those that wait for their turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import distinct
from uwopt.forward.light_columns import ImageLight
from uwopt.forward.problem import Problem
from uwopt.forward.scene_rows import SceneRows
from uwopt.mission.sections.limits import Limits
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.exact.imager_rules import limit
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import LampChoices, Under
from uwopt.solvers.settings.mean_limit import MeanLimit
from uwopt.solvers.settings.question import Best, Question
from uwopt.tolerances import ROUND

FIRST_VEILS, LARGEST_VEILS = 8, 256  # imagers whose veils are worked out together


class WithLamps(NamedTuple):
    """What imagers cost and weigh with their lamps, (n,) each."""

    cost: Array
    limit_cost: Array  # what counts against the budget
    mass_kg: Array

    @staticmethod
    def of(problem: Problem, imagers: Imagers, imager: Array, light: Array, count: Array) -> WithLamps:
        """Of these imagers, each with so many lamps of a light."""
        return WithLamps(
            imagers.cost[imager] + problem.lamps_cost(light, count),
            imagers.limit_cost[imager] + problem.lamps_cost(light, count, "limit_price"),
            imagers.mass_kg[imager] + count * problem.lights.mass_kg[light],
        )


@dataclass(frozen=True)
class NodeDesigns:
    """Designs as (node, light, count): `node` points into the nodes, an imager under a lighting each."""

    imager: Array
    under: Under
    node: Array
    light: Array
    count: Array
    cost: Array
    limit_cost: Array  # what counts against the budget
    mass_kg: Array

    @staticmethod
    def of(
        problem: Problem, imagers: Imagers, imager: Array, under: Under, node: Array, light: Array, count: Array
    ) -> NodeDesigns:  # fmt: skip
        """These designs, priced and weighed."""
        return NodeDesigns(
            imager, under, node, light, count, *WithLamps.of(problem, imagers, imager[node], light, count)
        )

    @staticmethod
    def every(imagers: Imagers, imager: Array, under: Under, tables: Sequence[LampChoices]) -> NodeDesigns:
        """Each of these nodes with each of the lamps of its lighting, in every number; `tables`: of each lighting."""
        used, back = distinct(under.index)
        some = [tables[int(k)] for k in used]
        lamps, sizes = LampChoices.joined(some), np.array([len(table.light) for table in some], int)
        node = np.repeat(np.arange(len(imager)), sizes[back])
        first, begin = np.cumsum(sizes) - sizes, np.cumsum(sizes[back]) - sizes[back]  # lamps of a lighting, of a node
        item = (first[back] - begin)[node] + np.arange(len(node))
        row = imager[node]
        return NodeDesigns(
            imager, under, node, lamps.light[item], lamps.count[item], imagers.cost[row] + lamps.cost[item],
            imagers.limit_cost[row] + lamps.limit_cost[item], imagers.mass_kg[row] + lamps.mass_kg[item],
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.node)

    @property
    def row(self) -> Array:
        """The imager of each design."""
        return np.asarray(self.imager[self.node])

    @property
    def lit(self) -> Under:
        """The lighting of each design."""
        return self.under.take(self.node)

    def take(self, index: Array) -> NodeDesigns:
        """These designs only; the list of nodes stays."""
        own = {f.name: getattr(self, f.name)[index] for f in fields(self) if f.name not in ("imager", "under")}
        return replace(self, **own)

    def alone(self, index: Array) -> tuple[NodeDesigns, Array]:
        """These designs only, without nodes of no design, and which of the nodes are left."""
        used, back = distinct(self.node[index])
        return replace(self.take(index), imager=self.imager[used], under=self.under.take(used), node=back), used

    def kept_limits(self, limits: Limits) -> list[tuple[str, Array]]:
        """The limits that the price and the mass of designs keep, by name."""
        return [
            ("cost", self.limit_cost <= limit(limits.cost) * ROUND),
            ("mass_kg", self.mass_kg <= limit(limits.mass_kg) * ROUND),
        ]

    def asked(
        self, problem: Problem, imagers: Imagers, objective: Objective, rows: list[SceneRows], **more: Any
    ) -> Question:
        """The question for the best settings of these designs; rows by scene, `more` as in `Question`."""
        row = self.row
        camera_w, none = imagers.camera_power_w[row], np.zeros(len(row))
        constant = objective.constant(Terms(camera_w, self.cost, self.mass_kg, none, imagers.gsd_mm[row]))
        return Question.of(
            rows, problem.lenses.motorised[imagers.lens[row]], objective, camera_w, problem.scene_power_limit_w,
            constant=constant, mean_limit=MeanLimit.of(problem), **more,
        )  # fmt: skip

    def worth(self, imagers: Imagers, question: Question, best: Best) -> tuple[Array, Terms]:
        """Minimised objective with these settings, feasible or not, and its terms."""
        power = question.camera_power_w + np.max([c.light_power_w for c in best.chosen], axis=0)
        gsd_mm = imagers.gsd_mm[self.row]
        terms = Terms(power, self.cost, self.mass_kg, best.snr_db, gsd_mm, best.contrast, best.information)
        with np.errstate(invalid="ignore"):
            return np.asarray(question.objective.cost_to_minimise(terms)), terms

    def within(self, limits: Limits) -> Array:
        """Whether designs keep them both."""
        return np.logical_and.reduce([kept for _, kept in self.kept_limits(limits)])


@dataclass(frozen=True)
class Waiting:
    """Designs that are bounded and not solved, their nodes in the order of the least bound of each."""

    pairs: NodeDesigns
    bound: Array
    lights: list[ImageLight]
    least: Array  # bound of each node
    order: Array  # of the nodes that wait
    batch: int = FIRST_VEILS

    @staticmethod
    def of(pairs: NodeDesigns, bound: Array, lights: list[ImageLight]) -> Waiting:
        """All of a group: nodes by the best of their designs, of equals the cheapest first."""
        least = np.full(len(pairs.imager), np.inf)
        np.minimum.at(least, pairs.node, bound)
        nodes, first = np.unique(pairs.node[np.lexsort((pairs.cost, bound))], return_index=True)
        return Waiting(pairs, bound, lights, least, nodes[np.argsort(first)])

    @property
    def lowest(self) -> float:
        """The least bound that waits."""
        return float(self.least[self.order[0]]) if len(self.order) else np.inf

    def taken(self, most: float, left: Array) -> tuple[NodeDesigns, Waiting]:
        """Of the designs that are left those of the next nodes with no more than some bound, and the group without."""
        order = self.order[np.isin(self.order, self.pairs.node[left])]
        count = int((self.least[order[: self.batch]] <= most).sum())
        some = self.pairs.take(np.flatnonzero(left & np.isin(self.pairs.node, order[:count])))
        return some, replace(self, order=order[count:], batch=min(2 * self.batch, LARGEST_VEILS))

    def left(self) -> Array:
        """Which designs wait."""
        return np.isin(self.pairs.node, self.order)
