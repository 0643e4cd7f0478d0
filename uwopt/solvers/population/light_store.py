"""Light, sun and sharpness of the imagers that a population meets, each worked out once.

Imagers whose views are alike see the same light per collecting area: one integral serves all lenses of a
focal length on all cameras with the same sensor behind a port. What is known is kept as arrays with an index.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.columns import Columns
from uwopt.forward.floor_light import uniformity
from uwopt.forward.lamp_light import ImageLight, SunLight
from uwopt.forward.lamp_views import keeps_clear, lamps_refused
from uwopt.forward.sharpness import SharpRows, sharpness_of
from uwopt.forward.sun_light import sun_light
from uwopt.solvers.exact.search import Search

Array = NDArray[Any]
Stored = TypeVar("Stored", bound=Columns)


def appended(old: Stored | None, new: Stored) -> Stored:
    """Rows of one kind after the others."""
    return new if old is None else new.joined([old, new])


class Store(Generic[Stored]):
    """Rows by an integer key, made when first asked for."""

    def __init__(self, make: Callable[[Array], Stored | None]):
        self.make: Callable[[Array], Stored | None] = make
        self.keys, self.place = np.empty(0, int), np.empty(0, int)
        self.columns: Stored | None = None
        self.nothing = False  # there is no such light

    def rows(self, keys: Array) -> Stored | None:
        """The rows of these keys, (n,); None where there is no such light at all."""
        if self.nothing:
            return None
        wanted = np.unique(keys)
        new = wanted[~np.isin(wanted, self.keys)]
        if len(new):
            made = self.make(new)
            if made is None:
                self.nothing = True
                return None
            places = np.arange(len(self.keys), len(self.keys) + len(new))
            self.columns = appended(self.columns, made)
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
    sharp: SharpRows | None
    even: Array | None  # whether the floor is lit evenly enough; None: nobody asks


class LightStore:
    """Constants of imagers under lightings, by scene."""

    def __init__(self, search: Search, *, sharp: bool):
        self.search, self.problem, self.imagers = search, search.problem, search.imagers
        self.sharp = sharp
        self.n_counts = self.problem.count_range[1] + 1
        self.images, self.image_of = search.tables.images
        scenes = range(len(self.problem.scenes))
        self.signals = [Store[ImageLight](partial(self._signals, s)) for s in scenes]
        self.lights = [Store[ImageLight](partial(self._lights, s)) for s in scenes]
        self.pixels = [Store[ImageLight](partial(self._pixels, s)) for s in scenes]
        self.suns = [Store[SunLight](partial(self._suns, s)) for s in scenes]
        self.sharps = [Store[SharpRows](partial(self._sharps, s)) for s in scenes]
        self.evens: list[dict[int, bool]] = [{} for _ in scenes]

    def seen(self, scene_index: int, imager: Array, lighting: Array, count: Array) -> SeenLight:
        """What these designs see; `lighting` is an index into the tables' list."""
        problem = self.problem
        scene = problem.scenes[scene_index]
        image = self.image_of[imager]
        key = lighting * len(self.images) + image
        by_count = key * self.n_counts + count
        light = self.lights[scene_index].rows(key)
        assert light is not None
        sun = None
        if scene.sunlit and problem.effects.sunlight:
            sun = self.suns[scene_index].rows(by_count if scene.at_worst else image)
        if scene.at_worst:
            there = self.pixels[scene_index].rows(by_count)
            assert there is not None
            light = light.with_pixels(there)
        view = self.imagers.scenes[scene_index].view
        area = view.collecting_m2[imager] / view.collecting_m2[self.images[image]]
        optics = np.array([item.optics for item in self.search.tables.lightings])[lighting]
        return SeenLight(
            light.scaled(area), None if sun is None else sun.scaled(area),
            self.sharps[scene_index].rows(optics * len(self.imagers) + imager) if self.sharp else None,
            self._even(scene_index, by_count),
        )  # fmt: skip

    def signal(self, scene_index: int, imager: Array, lighting: Array) -> ImageLight:
        """Image-forming light alone, which costs a fraction: no veil makes a design better."""
        image = self.image_of[imager]
        light = self.signals[scene_index].rows(lighting * len(self.images) + image)
        assert light is not None
        view = self.imagers.scenes[scene_index].view
        return light.scaled(view.collecting_m2[imager] / view.collecting_m2[self.images[image]])

    # ------------------------------------------------------------ making

    def _split(self, keys: Array) -> list[tuple[int, Array, Array]]:
        """Keys of (lighting, image) as groups of one lighting: its index, the keys' places, imagers."""
        lighting, image = np.divmod(keys, len(self.images))
        return [
            (int(k), np.nonzero(lighting == k)[0], self.images[image[lighting == k]])
            for k in np.unique(lighting)
        ]

    def _signals(self, scene_index: int, keys: Array) -> ImageLight:
        """Image means under each lighting without veils."""
        tables = self.search.tables
        parts = [
            (mine, tables.exact(scene_index, tables.lightings[k], imager, veils="none"))
            for k, mine, imager in self._split(keys)
        ]
        return ImageLight.in_places(parts, len(keys))

    def _lights(self, scene_index: int, keys: Array) -> ImageLight:
        """Image means under each lighting, veils included."""
        signal = self.signals[scene_index].rows(keys)
        if not self.problem.effects.veils:
            assert signal is not None
            return signal
        tables = self.search.tables
        parts = []
        for k, mine, imager in self._split(keys):
            known = None if signal is None or self.problem.paper else signal.take(mine)
            parts.append(
                (mine, tables.exact(scene_index, tables.lightings[k], imager, known=known, veils="all"))
            )
        return ImageLight.in_places(parts, len(keys))

    def _pixels(self, scene_index: int, keys: Array) -> ImageLight:
        """Light at the pixels that the SNR is asked of, by number of lamps."""
        tables, (pairs, count) = self.search.tables, np.divmod(keys, self.n_counts)
        pixels = self.problem.scenes[scene_index].pixels
        parts = []
        for k, mine, imager in self._split(pairs):
            for number in np.unique(count[mine]):
                own = count[mine] == number
                light = tables.exact(
                    scene_index, tables.lightings[k], imager[own], count=int(number), pixels=pixels, means=False,
                )  # fmt: skip
                parts.append((mine[own], light))
        return ImageLight.in_places(parts, len(keys))

    def _suns(self, scene_index: int, keys: Array) -> SunLight | None:
        """The sun's light; by lighting and number of lamps where the worst pixels count."""
        scene, lightings = self.problem.scenes[scene_index], self.search.tables.lightings
        if not scene.at_worst:
            return self._sun(scene_index, self.images[keys], pixels=None)
        pairs, count = np.divmod(keys, self.n_counts)
        parts: SunLight | None = None
        order = []
        for k, mine, imager in self._split(pairs):
            for number in np.unique(count[mine]):
                own = count[mine] == number
                sun = self._sun(
                    scene_index, imager[own], pixels=scene.pixels, mount=lightings[k].mount, count=int(number)
                )
                if sun is None:
                    return None
                parts = appended(parts, sun)
                order.append(mine[own])
        assert parts is not None
        return parts.take(np.argsort(np.concatenate(order)))

    def _sun(self, scene_index: int, imager: Array, **where: Any) -> SunLight | None:
        """The sun's light in these images."""
        imagers = self.imagers
        return sun_light(
            self.problem, scene_index, imagers.scenes[scene_index].view.take(imager), imagers.camera[imager],
            port_index=imagers.port[imager], **where,
        )  # fmt: skip

    def _sharps(self, scene_index: int, keys: Array) -> SharpRows:
        """What MTF and information depend on, by light optics."""
        imagers, seen = self.imagers, self.imagers.scenes[scene_index]
        optics, imager = np.divmod(keys, len(imagers))
        made: SharpRows | None = None
        for one in np.unique(optics):
            some = imager[optics == one]  # keys are sorted, so groups follow each other
            part = sharpness_of(
                self.problem, scene_index, seen.view.take(some), camera=imagers.camera[some], lens=imagers.lens[some],
                port=imagers.port[some], optics=int(one), dioptre_per_m=seen.focused.dioptre_per_m[some],
            )  # fmt: skip
            made = appended(made, part if part.spreads else replace(part, spread_index=0 * part.spread_index))
        assert made is not None
        return made

    def _even(self, scene_index: int, keys: Array) -> Array | None:
        """Whether floors are lit evenly enough by lamps out of view; one integral an image and number of lamps."""
        wanted = self.problem.scenes[scene_index].view.requirements.min_uniformity
        watched = lamps_refused(self.problem, scene_index)
        if wanted is None and not watched:
            return None
        known = self.evens[scene_index]
        view = self.imagers.scenes[scene_index].view
        unique, back = np.unique(keys, return_inverse=True)
        for key in unique:
            if int(key) in known:
                continue
            pair, number = divmod(int(key), self.n_counts)
            k, image = divmod(pair, len(self.images))
            imager, lighting = self.images[image], self.search.tables.lightings[k]
            one, port = view.take(np.array([imager])), self.imagers.port[imager]
            known[int(key)] = not watched or bool(keeps_clear(
                self.problem, scene_index, one, port=np.array([port]), mount=lighting.mount, count=number
            )[0])  # fmt: skip
            if wanted is not None and known[int(key)]:
                least = uniformity(
                    self.problem, scene_index, one, port_index=int(port), optics=lighting.optics, mount=lighting.mount,
                    count=number,
                ).min()  # fmt: skip
                known[int(key)] = bool(least >= wanted * (1 - 1e-9))
        return np.array([known[int(key)] for key in unique])[back.reshape(-1)]
