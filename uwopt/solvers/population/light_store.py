"""Light, sun and sharpness of the imagers that a population meets, each worked out once.

Imagers whose views are alike see the same light per collecting area: one integral serves all lenses of a
focal length on all cameras with the same sensor behind a port. What is known is kept as arrays with an index.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic, TypeVar

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.light_columns import ImageLight, SunLight
from uwopt.forward.sharpness import SharpRows
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.search import Search

Stored = TypeVar("Stored", bound=Columns)


class Store(Generic[Stored]):
    """Rows by an integer key, made when first asked for."""

    def __init__(self, make: Callable[[Array], Stored]):
        self.make: Callable[[Array], Stored] = make
        self.keys, self.place = np.empty(0, int), np.empty(0, int)
        self.columns: Stored | None = None

    def rows(self, keys: Array) -> Stored:
        """The rows of these keys, (n,)."""
        wanted = np.unique(keys)
        new = wanted[~np.isin(wanted, self.keys)]
        if len(new):
            made, places = self.make(new), np.arange(len(self.keys), len(self.keys) + len(new))
            self.columns = made if self.columns is None else made.joined([self.columns, made])
            keys_, places = np.concatenate([self.keys, new]), np.concatenate([self.place, places])
            order = np.argsort(keys_)
            self.keys, self.place = keys_[order], places[order]
        assert self.columns is not None
        return self.columns.take(self.place[np.searchsorted(self.keys, keys)])


@dataclass(frozen=True)
class SeenLight(Columns):
    """What designs see in one scene, before their lamp's output factor."""

    light: ImageLight
    sun: SunLight | None
    even: Array | None  # whether the floor is lit evenly enough by lamps out of view; None: nobody asks
    sharp: SharpRows | None = None


class LightStore:
    """Constants of imagers under lightings, by scene."""

    def __init__(self, search: Search, *, sharp: bool):
        self.search, self.problem, self.imagers, self.sharp = search, search.problem, search.imagers, sharp
        self.n_counts = self.problem.count_range[1] + 1
        self.images, self.image_of = search.tables.images
        scenes = range(len(self.problem.scenes))
        self.signals = [Store[ImageLight](partial(self._signals, s)) for s in scenes]
        self.lights = [Store[SeenLight](partial(self._lights, s)) for s in scenes]
        self.sharps = [Store[SharpRows](partial(self._sharps, s)) for s in scenes]

    def seen(self, scene_index: int, imager: Array, lighting: Array, count: Array) -> SeenLight:
        """What these designs see; `lighting` is an index into the tables' list."""
        number = count if self.search.design_rows.asks_of_image(scene_index) else 0
        key = (lighting * len(self.images) + self.image_of[imager]) * self.n_counts + number
        seen, area = self.lights[scene_index].rows(key), self._area(scene_index, imager)
        optics = np.array([item.optics for item in self.search.tables.lightings])[lighting]
        return replace(
            seen, light=seen.light.scaled(area), sun=None if seen.sun is None else seen.sun.scaled(area),
            sharp=self.sharps[scene_index].rows(optics * len(self.imagers) + imager) if self.sharp else None,
        )  # fmt: skip

    def signal(self, scene_index: int, imager: Array, lighting: Array) -> ImageLight:
        """Image-forming light alone, which costs a fraction: no veil makes a design better."""
        light = self.signals[scene_index].rows(lighting * len(self.images) + self.image_of[imager])
        return light.scaled(self._area(scene_index, imager))

    def _area(self, scene_index: int, imager: Array) -> Array:
        """Collecting area over that of the imager that stands for the image."""
        collecting_m2 = self.imagers.scenes[scene_index].view.collecting_m2
        return np.asarray(collecting_m2[imager] / collecting_m2[self.images[self.image_of[imager]]])

    # ------------------------------------------------------------ making

    def _places(self, keys: Array) -> tuple[Array, Under]:
        """Imagers and their lightings by keys of (lighting, image)."""
        lighting, image = np.divmod(keys, len(self.images))
        return self.images[image], Under(self.search.tables.lightings, lighting)

    def _signals(self, scene_index: int, keys: Array) -> ImageLight:
        """Image means under each lighting without veils."""
        imager, under = self._places(keys)
        return self.search.tables.in_scene(scene_index, under, imager, veils="none")

    def _lights(self, scene_index: int, keys: Array) -> SeenLight:
        """All light under each lighting, by number of lamps where that matters."""
        pairs, count = np.divmod(keys, self.n_counts)
        rows, (imager, under) = self.search.design_rows, self._places(pairs)
        known, where = self.signals[scene_index].rows(pairs), (scene_index, imager, count, under)
        light = self.search.tables.in_scene(scene_index, under, imager, known=None if self.problem.paper else known)
        if self.problem.scenes[scene_index].at_worst:
            light = rows.with_pixels(*where, light, veils="all")
        even = rows.lamps_keep_rules(*where) if rows.has_rules(scene_index) else None
        return SeenLight(light, rows.sun(*where), even)

    def _sharps(self, scene_index: int, keys: Array) -> SharpRows:
        """What MTF and information depend on, by light optics."""
        optics, imager = np.divmod(keys, len(self.imagers))
        made = [
            self.search.imagers.sharpness(self.problem, scene_index, imager[optics == one], int(one))
            for one in np.unique(optics)
        ]  # keys are sorted, so groups follow each other
        return SharpRows.joined([
            part if part.spreads else replace(part, spread_index=0 * part.spread_index) for part in made
        ])  # fmt: skip
