"""Designs as integer vectors, for searches that evaluate populations.

Every vector is an imager that passes all rules without light, under a lamp that its bound does not rule out,
with settings at shares of what requirements leave open (`population_settings`). So few vectors are infeasible,
and those by a measure that leads back. Genes are sorted so that neighbours are alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.dominance import nondominated
from uwopt.objectives.own import OwnObjective
from uwopt.solvers.exact.node_designs import WithLamps
from uwopt.solvers.exact.search import Search
from uwopt.solvers.population.decoding import Decoded, Shares, log_excess, on_curve, one_by_one
from uwopt.tolerances import ROUND

KINDS = (CONTINUOUS, PULSED, FLASH)
BEST_UNITS = 500  # whose lamps are looked at one by one for the first population
DRAWS = 20  # of each vector of the first population
GRID = 1000  # steps of genes that are shares
MOST_BOUNDED = 3_000_000  # imagers times lightings: bounding more of them takes longer than it saves


# ---------------------------------------------------------------- hardware


@dataclass(frozen=True)
class CodedHardware(Columns):
    """Hardware of n designs; `lighting` is an index into the tables' list."""

    imager: Array
    light: Array
    count: Array
    lighting: Array

    def with_lamps(self, search: Search) -> WithLamps:
        """What it costs and weighs."""
        return WithLamps.of(search.problem, search.imagers, self.imager, self.light, self.count)


@dataclass(frozen=True)
class BoundedNodes:
    """What bounds say of imagers under lightings, without any integral.

    Where mounts are many, some of them stand for all, and nothing is known of the others.
    """

    alive: Array  # (n_imagers, n_optics): whether it may be feasible at some mount
    row_of: Array  # (n_lightings, n_kinds): row of `wanted`, -1 unknown
    wanted: Array  # (n_known, n_imagers): capacity that lamps of a kind need at least, lm or lm s
    best_imager: Array  # nodes with the best ideals on the axes, by layers of dominance
    best_lighting: Array
    best_ideal: Array  # (n_best, n_axes), less is better

    @staticmethod
    def of(search: Search, axes: Sequence[str | OwnObjective]) -> BoundedNodes:
        """Bound as many nodes as is worth it."""
        tables, n, none = search.tables, len(search.imagers), np.empty(0, int)
        n_optics, n_mounts = len(search.problem.optics), max(1, len(search.problem.mounts))
        row_of = np.full((len(tables.lightings), len(KINDS)), -1)
        room = MOST_BOUNDED // max(1, n * n_optics) if n else 0  # in less than one nothing is bounded, and all may be
        some = np.unique(np.linspace(0, n_mounts - 1, min(room, n_mounts)).round().astype(int))
        alive = np.full((n, n_optics), room == 0)
        wanted: list[Array] = []
        ideals, imager, lighting = [], [], []
        every = np.arange(n)
        for k in [optics * n_mounts + int(mount) for optics in range(n_optics) for mount in some]:
            bounds = search.bounds.of_nodes(k, every)
            may = np.nonzero(bounds.rule < 0)[0]
            if len(may) == 0:
                continue
            alive[may, tables.lightings[k].optics] = True
            for kind in np.unique(search.bounds.light_tables[k].kind):
                row_of[k, kind] = len(wanted)
                wanted.append(np.full(n, np.inf))
                wanted[-1][may] = capacity_needed(search, k, int(kind), may)
            columns = [ideal_of(search, bounds, axis, may) for axis in axes]
            ideals.append(np.stack(columns, axis=1))
            imager.append(may)
            lighting.append(np.full(len(may), k))
        if not ideals:
            return BoundedNodes(alive, row_of, np.empty((0, n)), none, none, np.empty((0, len(axes))))
        ideal = np.concatenate(ideals)
        best = layers(ideal, BEST_UNITS)
        return BoundedNodes(
            alive,
            row_of,
            np.stack(wanted),
            np.concatenate(imager)[best],
            np.concatenate(lighting)[best],
            ideal[best],
        )

    def lacking(self, imager: Array, lighting: Array, kind: Array, capacity: Array) -> Array:
        """By how much lamps surely give too little light, in logarithms; 0 where they may be enough."""
        row = self.row_of[lighting, kind]
        if len(self.wanted) == 0:
            return np.zeros(len(imager))
        known = row >= 0
        need = np.where(known, self.wanted[np.maximum(row, 0), imager], 0.0)
        return log_excess(need, capacity * (1 + 1e-9))


def layers(values: Array, most: int) -> Array:
    """Rows that nothing dominates, then those that nothing else dominates, and so on; at most so many."""
    if values.shape[1] == 1:  # on one axis that is their order
        return np.argsort(values[:, 0], kind="stable")[:most]
    found, rest = [np.empty(0, int)], np.arange(len(values))
    while len(rest) and sum(map(len, found)) < most:
        best = nondominated(values[rest])
        found.append(rest[best])
        rest = rest[~best]
    return np.concatenate(found)[:most]


def capacity_needed(search: Search, k: int, kind: int, rows: Array) -> Array:
    """Light at full level that lamps of a kind need at least under one lighting, in lm or lm s, worst scene."""
    bounds, lighting = search.bounds, search.tables.lightings[k]
    wanted = np.zeros(len(rows))
    for index in range(len(search.imagers.scenes)):
        need = bounds.needs.of(index, rows)
        wanted = np.maximum(wanted, bounds.light_needed(index, lighting, need, kind, rows)[1])
    return wanted


def ideal_of(search: Search, bounds: Any, axis: str | OwnObjective, rows: Array) -> Array:
    """The best that nodes could be on one axis; 0 where no bound is known."""
    imagers = search.imagers
    known = {"power": bounds.power, "cost": bounds.cost, "mass": bounds.mass, "snr_db": -bounds.snr_db,
             "information": -bounds.information,
             "gsd_mm": imagers.gsd_mm}  # fmt: skip
    if not isinstance(axis, str) or axis not in known:
        return np.zeros(len(rows))
    return np.nan_to_num(known[axis][rows], posinf=1e300, neginf=-1e300)


class Coding:
    """What each gene of an integer vector means."""

    def __init__(self, search: Search, axes: Sequence[str | OwnObjective]):
        self.search, self.axes = search, list(axes)
        self.nodes = BoundedNodes.of(search, axes)
        self._order_imagers()
        self._order_lights()
        self._order_mounts()
        self.low, self.high = search.problem.count_range
        self._settings_genes(axes)
        names, tops = zip(*self.genes, strict=True)
        self.names: tuple[str, ...] = names
        self.upper = np.array(tops, int)
        self.n_hardware = self.names.index("tilt") + 1  # the genes before these are settings

    @property
    def empty(self) -> bool:
        """Whether bounds rule out everything."""
        return len(self.cameras) == 0

    # ------------------------------------------------------------ tables

    def _order_imagers(self) -> None:
        """Cameras by price; of each the imagers with the finest ground sample first, then fast, then cheap."""
        imagers = self.search.imagers
        may = np.nonzero(self.nodes.alive.any(axis=1))[0]
        camera = imagers.camera[may]
        self.cameras = np.unique(camera)
        price = self.search.problem.cameras.price[self.cameras]
        self.cameras = self.cameras[np.argsort(price, kind="stable")]
        rank = np.full(len(self.search.problem.parts.cameras), -1)
        rank[self.cameras] = np.arange(len(self.cameras))
        n_low = imagers.scenes[0].focused.n_low[may] if imagers.scenes else np.zeros(len(may))
        keys = (imagers.cost[may], n_low, imagers.gsd_mm[may], rank[camera])
        self.imagers = may[np.lexsort(keys)]
        self.size = np.bincount(rank[imagers.camera[self.imagers]], minlength=len(self.cameras))
        self.start = np.cumsum(self.size) - self.size

    def _order_lights(self) -> None:
        """Lamps by kind and light; to each imager those that may be enough."""
        lights = self.search.problem.lights
        lumens = lights.full_light * lights.output_factor
        order = np.lexsort((lights.price, lumens, lights.kind))
        masks, back = np.unique(self.nodes.alive[self.imagers], axis=0, return_inverse=True)
        self.mask_of = np.zeros(len(self.nodes.alive), int)
        self.mask_of[self.imagers] = back.reshape(-1)
        lists = [order[mask[lights.optics_index[order]]] for mask in masks]
        self.light_size = np.array([len(one) for one in lists], int)
        self.light_start = np.cumsum(self.light_size) - self.light_size
        self.lights = np.concatenate(lists) if lists else np.empty(0, int)
        self.light_rank = np.full((len(lists), len(order)), -1)
        for mask, own in enumerate(lists):
            self.light_rank[mask, own] = np.arange(len(own))

    def _order_mounts(self) -> None:
        """Baseline and tilt as genes of their own, where the mounts are their grid."""
        mounts = self.search.problem.mounts
        baselines = sorted({m.baseline_m for m in mounts})
        tilts = sorted({m.tilt_deg for m in mounts})
        at = {(m.baseline_m, m.tilt_deg): i for i, m in enumerate(mounts)}
        if len(at) == len(mounts) == len(baselines) * len(tilts):
            self.mounts = np.array([[at[b, t] for t in tilts] for b in baselines], int)
        else:
            self.mounts = np.arange(len(mounts))[:, None]

    def _settings_genes(self, axes: Sequence[str | OwnObjective]) -> None:
        """Genes of hardware, and of the settings that the axes depend on."""
        search = self.search
        problem, scenes = search.problem, search.problem.scenes
        tops = [
            ("camera", max(len(self.cameras) - 1, 0)),
            ("imager", max(GRID, int(self.size.max(initial=1)) - 1)),
        ]
        tops += [("light", max(int(self.light_size.max(initial=1)) - 1, 0)), ("count", self.high - self.low)]
        tops += [("baseline", self.mounts.shape[0] - 1), ("tilt", self.mounts.shape[1] - 1)]
        needs_more = any(s.sunlit or s.view.requirements.asks_sharpness for s in scenes)
        own = any(not isinstance(axis, str) for axis in axes)
        self.curve = problem.paper or not (needs_more or own or "information" in axes)
        if problem.paper and own:
            self.curve = False
        self.level_counts = "snr_db" in axes
        self.power_counts = "power" in axes
        if self.curve:
            if self.level_counts and self.power_counts:
                tops.append(("level", GRID))
        else:
            motorised = len(scenes) > 1 and bool(search.motorised[self.imagers].any())
            shutter = any(s.sunlit for s in scenes) and bool(np.any(problem.lights.kind != CONTINUOUS))
            for index in range(len(scenes)):
                if index == 0 or motorised:
                    tops.append((f"aperture {index}", GRID))
                tops += [(f"time {index}", GRID), (f"level {index}", GRID)]
                if shutter:
                    tops.append((f"shutter {index}", GRID))
        self.genes = tops

    # ------------------------------------------------------------ vectors

    def column(self, vectors: Array, name: str) -> Array | None:
        """One gene of all vectors, None where there is no such gene."""
        return vectors[:, self.names.index(name)] if name in self.names else None

    def share(self, vectors: Array, name: str, default: float) -> Array:
        """A gene as a share between 0 and 1."""
        gene = self.column(vectors, name)
        return np.full(len(vectors), default) if gene is None else gene / GRID

    def built(self, vectors: Array) -> CodedHardware:
        """Hardware of vectors."""
        gene = {name: vectors[:, i] for i, name in enumerate(self.names)}
        top = dict(self.genes)
        camera = gene["camera"]
        imager = self.imagers[self.start[camera] + gene["imager"] * self.size[camera] // (top["imager"] + 1)]
        mask = self.mask_of[imager]
        at = gene["light"] * self.light_size[mask] // (top["light"] + 1)
        light = self.lights[self.light_start[mask] + at]
        mount = self.mounts[gene["baseline"], gene["tilt"]]
        optics = self.search.problem.lights.optics_index[light]
        lighting = optics * len(self.search.problem.mounts) + mount
        return CodedHardware(imager, light, self.low + gene["count"], lighting)

    def genes_of(self, built: CodedHardware, rng: np.random.Generator) -> Array:
        """Vectors with this hardware and settings at random."""
        vectors = self.random(len(built.imager), rng)
        top, column = dict(self.genes), {name: i for i, name in enumerate(self.names)}
        place = np.full(len(self.nodes.alive), -1)
        place[self.imagers] = np.arange(len(self.imagers))
        at = place[built.imager]
        camera = np.searchsorted(self.start, at, side="right") - 1
        vectors[:, column["camera"]] = camera
        vectors[:, column["imager"]] = middle(at - self.start[camera], self.size[camera], top["imager"])
        mount = built.lighting % len(self.search.problem.mounts)
        flat = np.argsort(self.mounts, axis=None)[mount]
        vectors[:, column["baseline"]], vectors[:, column["tilt"]] = np.divmod(flat, self.mounts.shape[1])
        vectors[:, column["count"]] = built.count - self.low
        mask = self.mask_of[built.imager]
        rank = self.light_rank[mask, built.light]
        vectors[:, column["light"]] = middle(rank, self.light_size[mask], top["light"])
        return vectors

    def random(self, n: int, rng: np.random.Generator) -> Array:
        """Vectors at random."""
        return rng.integers(0, self.upper + 1, size=(n, len(self.upper)))

    def first(self, n: int, rng: np.random.Generator) -> Array:
        """A first population: half of it of the designs that are best by their bounds, half drawn at random."""
        seeds = self.seeds(n // 2)
        first = self.genes_of(seeds, rng) if len(seeds.imager) else self.random(0, rng)
        drawn = self.drawn(n - len(first), rng)
        # in turn, so that whoever has time for some of them has some of both
        turn = np.concatenate([2.0 * np.arange(len(first)), 2.0 * np.arange(len(drawn)) + 1.0])
        return np.concatenate([first, drawn])[np.argsort(turn, kind="stable")]

    def seeds(self, most: int) -> CodedHardware:
        """Designs of the best nodes with any lamps: what nothing dominates by cost, mass and the nodes' bounds."""
        built, ideal = self.bounded()
        return built.take(layers(ideal, most))

    def bounded(self) -> tuple[CodedHardware, Array]:
        """All designs of the best nodes with any lamps that limits allow, and the best that each could be."""
        nodes, problem = self.nodes, self.search.problem
        own = [np.nonzero(problem.lights.optics_index == optics)[0] for optics in range(len(problem.optics))]
        optics = nodes.best_lighting // len(problem.mounts)
        n_counts = self.high - self.low + 1
        node = np.repeat(np.arange(len(optics)), [len(own[o]) * n_counts for o in optics])
        if len(node) == 0:
            return CodedHardware(node, node, node, node), np.empty((0, len(self.axes)))
        light = np.concatenate([np.repeat(own[o], n_counts) for o in optics])
        count = np.tile(np.arange(self.low, self.high + 1), len(node) // n_counts)
        built = CodedHardware(nodes.best_imager[node], light, count, nodes.best_lighting[node])
        may = np.nonzero(self.beyond(built) <= 0.0)[0]
        built, ideal = built.take(may), nodes.best_ideal[node[may]].copy()
        own = built.with_lamps(self.search)
        for column, axis in enumerate(self.axes):
            if axis in ("cost", "mass"):
                ideal[:, column] = own.cost if axis == "cost" else own.mass_kg
        return built, ideal

    def drawn(self, n: int, rng: np.random.Generator) -> Array:
        """Vectors at random, each the likeliest of several."""
        return self.likeliest([self.random(n, rng) for _ in range(DRAWS)])

    def likeliest(self, draws: Sequence[Array]) -> Array:
        """Of several draws of each row the one that limits and bounds speak against least; of equals the first."""
        missing = np.stack([self.beyond(self.built(vectors)) for vectors in draws])
        return np.stack(draws)[missing.argmin(axis=0), np.arange(len(draws[0]))]

    def beyond(self, built: CodedHardware) -> Array:
        """By how much hardware misses what can be told without its light: budgets, and light by its bound."""
        limits, lights = self.search.problem.mission.limits, self.search.problem.lights
        own = built.with_lamps(self.search)
        capacity = built.count * (lights.full_light * lights.output_factor)[built.light]
        missing = self.nodes.lacking(built.imager, built.lighting, lights.kind[built.light], capacity)
        for value, most in ((own.limit_cost, limits.cost), (own.mass_kg, limits.mass_kg)):
            if most is not None:
                missing = missing + log_excess(value, np.full(len(value), most * ROUND))
        return missing

    # ------------------------------------------------------------ settings

    def decoded(
        self, vectors: Array, rows: list[SceneRows], motorised: Array, light_limit_w: Array
    ) -> Decoded:
        """Settings of vectors whose designs have these rows."""
        if self.curve:
            share: Array | None = None
            if self.level_counts:
                share = self.share(vectors, "level", 1.0)
            return on_curve(rows, motorised, light_limit_w, share)
        shares = [
            Shares(
                self.share(vectors, f"aperture {i}", 0.0), self.share(vectors, f"time {i}", 1.0),
                self.share(vectors, f"shutter {i}", 0.0), self.share(vectors, f"level {i}", 0.0),
            )
            for i in range(len(rows))
        ]  # fmt: skip
        return one_by_one(rows, motorised, light_limit_w, shares)


def middle(index: Array | int, size: Array | int, top: int) -> Any:
    """The least gene that is read as this index of a list."""
    return -(-index * (top + 1) // size)
