"""Signal of imagers under light optics: a cheap upper bound for all, the exact field mean for survivors.

A *lighting* is a pair (light optics, mount): lights that share beam and spectrum share every signal
per lumen. The bound needs no integral per imager: the mean over an image of a non-negative light is
at most the light that falls on the image's floor rectangle over its area, and that grows with the
rectangle, so a table of rectangles, rounded up, bounds every image.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.columns import distinct, rows_alike
from uwopt.forward.lamp_light import Veils, image_light
from uwopt.forward.lamps import on_axis_gain
from uwopt.forward.light_columns import ImageLight
from uwopt.forward.problem import Problem
from uwopt.forward.remembered import RememberedField, RememberedSunField
from uwopt.forward.scene import Pixels
from uwopt.forward.spectra import sees_colours
from uwopt.forward.views import table_reach_m
from uwopt.model.imaging import levelled
from uwopt.solvers.exact.balance import least_white_balance
from uwopt.solvers.exact.floor_rectangles import FloorLightBound, Rectangles
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import Lighting, Under, lightings

SUN_SLACK = 1e-6  # of polynomials in place of the sun's light


class FieldTables:
    """Bounds and exact values of the electrons per lm s of every imager under every lighting."""

    def __init__(
        self, problem: Problem, imagers: Imagers, *, like: FieldTables | None = None,
        widest_m: Sequence[float] | None = None,
    ):  # fmt: skip
        """Tables that reach as far as these imagers look, as far as is said, or as those of others do."""
        self.problem: Problem
        if like is None:
            self.problem = problem.reaching(
                widest_m or [table_reach_m(scene.view) for scene in imagers.scenes]
            )
        else:
            self.problem = like.problem
        self.imagers = imagers
        self.lightings: list[Lighting] = lightings(problem) if like is None else like.lightings
        self._light_tables: dict[tuple[int, Lighting, int], FloorLightBound] = (
            {} if like is None else like._light_tables
        )
        self._widest: dict[tuple[int, int], Rectangles] = {} if like is None else like._widest
        self._losses: dict[tuple[int, int, int, int, int, str | None], float] = {} if like is None else like._losses
        self.brightest: dict[tuple[int, int, int], list[FloorLightBound]] = {} if like is None else like.brightest
        self._likely: dict[Any, Array] = {}
        self._balance: dict[tuple[int, Lighting], Array] = {}
        self._chunk: tuple[Array, dict[tuple[int, int], Rectangles], Array, Array] | None = None

    def bound(
        self, scene_index: int, lighting: Lighting, altitude: int, rows: Array, *, channel: str | None = None
    ) -> Array:
        """Upper bound on the electrons per lm s of these imagers at one altitude, (n,); of one colour channel, which a
        mono sensor has not."""
        collecting, problem = self.imagers.scenes[scene_index].view.collecting_m2[rows], self.problem
        response = self.most_response(scene_index, [lighting], altitude, rows, channel=channel)
        if problem.paper:  # knows no field, so the bound is exact
            axis = on_axis_gain(problem.beam(scene_index, lighting.optics), problem.scenes[scene_index].range_m)
            return np.asarray(collecting * response * axis[altitude])
        rectangle = self.rectangles_of_chunk(scene_index, altitude, rows)
        light = self.light_table(scene_index, lighting, altitude).most_light(rectangle)
        return np.asarray(collecting * response * light * rectangle.samples_per_m2)

    def most_response(
        self, scene_index: int, some: Sequence[Lighting], altitude: int, rows: Array, *, channel: str | None = None
    ) -> Array:
        """The most that light of the same optics at any of some mounts becomes in these imagers, (n,)."""
        _, curves, back = self._of_chunk(rows)
        contraction, optics = self.problem.contractions[scene_index], some[0].optics
        spectrum, response = int(contraction.spectrum_of[optics]), np.zeros(len(curves))
        for place, q in enumerate(curves.tolist()):
            if channel is None or sees_colours(self.problem.efficiencies[q]):
                loss = max(self._least_loss(scene_index, one, altitude, q, channel) for one in some)
                response[place] = contraction.response(spectrum, q, channel) * loss
        return response[back]

    def rectangles_of_chunk(self, scene_index: int, altitude: int, rows: Array) -> Rectangles:
        """The floor rectangles of these imagers at one altitude, which all lightings share."""
        rectangles, key = self._of_chunk(rows)[0], (scene_index, altitude)
        if key not in rectangles:
            rectangles[key] = self.rectangles(scene_index, altitude, rows)
        return rectangles[key]

    def most_sun(self, scene_index: int, rows: Array) -> Array:
        """Upper bound of the sun's electrons a second, image-forming, of these imagers' means, (n, n_altitudes)."""
        problem, camera = self.problem, self.imagers.camera[rows]
        windows, curves = problem.like_port[self.imagers.port[rows]], problem.cameras.qe_index[camera]
        view = self.imagers.scenes[scene_index].view
        most = np.empty((len(rows), len(problem.scenes[scene_index].range_m)))
        for window, curve in np.unique(np.stack([windows, curves]), axis=1).T:
            mine = np.nonzero((windows == window) & (curves == curve))[0]
            field = RememberedSunField(problem, scene_index, port_index=int(window), efficiency=int(curve))
            most[mine] = field.most_signal(view.take(rows[mine])) * (1.0 + SUN_SLACK)
        return most

    def set_widest(self, scene_index: int, altitude: int, widest: Rectangles) -> None:
        """Say what rectangle the lights' tables must hold at one altitude."""
        self._widest[scene_index, altitude] = widest

    def rectangles(self, scene_index: int, altitude: int, rows: Array) -> Rectangles:
        """The floor rectangles of these imagers at one altitude."""
        return Rectangles.of(self.problem, self.imagers, scene_index, altitude, rows)

    def _of_chunk(self, rows: Array) -> tuple[dict[tuple[int, int], Rectangles], Array, Array]:
        """What all lightings share for the same imagers: their rectangles and efficiency curves."""
        if self._chunk is None or self._chunk[0] is not rows:
            efficiency = self.problem.cameras.qe_index[self.imagers.camera[rows]]
            curves, back = distinct(efficiency)
            self._chunk = (rows, {}, curves, back)
        return self._chunk[1:]

    def _least_loss(
        self, scene_index: int, lighting: Lighting, altitude: int, efficiency: int, channel: str | None
    ) -> float:
        """Water's loss over the shortest possible paths; physics `paper` knows the way on the axis alone."""
        if self.problem.paper:
            contraction = self.problem.contractions[scene_index]
            spectrum = int(contraction.spectrum_of[lighting.optics])
            return float(contraction.straight_loss(spectrum, efficiency, channel)[altitude])
        key = (scene_index, lighting.optics, lighting.mount_index, altitude, efficiency, channel)
        if key not in self._losses:
            contraction = self.problem.contractions[scene_index]
            spectrum = int(contraction.spectrum_of[lighting.optics])
            lamp_m, camera_m = self._shortest_m(scene_index, lighting, altitude)
            place = ("least loss", *contraction.key(spectrum, efficiency, channel), lamp_m, camera_m)
            self._losses[key] = self.problem.scenes[scene_index].once(place, lambda: contraction.mean_loss(
                spectrum, efficiency, channel, lamp_m=lamp_m, camera_m=camera_m
            ))  # fmt: skip
        return self._losses[key]

    def _shortest_m(self, scene_index: int, lighting: Lighting, altitude: int) -> tuple[float, float]:
        """No path from a lamp, nor one to a camera, is shorter at one altitude."""
        scene = self.problem.scenes[scene_index]
        lamps, port_m = levelled(lighting.mount.lamps(2), scene.slope, float(scene.range_m[altitude]))
        return min(port_m - z for z in lamps.z_m), self.problem.nearest_m(scene_index, altitude)

    def least_balance(self, scene_index: int, lighting: Lighting, efficiency: int) -> float:
        """Lower bound of the white balance of every image at the farthest altitude under one lighting alone."""
        scene, contraction = self.problem.scenes[scene_index], self.problem.contractions[scene_index]
        spectrum, far = int(contraction.spectrum_of[lighting.optics]), len(scene.range_m) - 1
        lamp_m, camera_m = self._shortest_m(scene_index, lighting, far)
        reach = contraction.reach_m
        if self.problem.paper:  # knows the axis alone
            lamp_m = camera_m = float(scene.range_m[far])
            reach = (lamp_m, camera_m)
        key = ("least balance", *contraction.key(spectrum, efficiency, None), lamp_m, camera_m, reach)
        return scene.once(key, lambda: least_white_balance(
            contraction, spectrum, efficiency, lamp_m=(lamp_m, reach[0]), camera_m=(camera_m, reach[1])
        ))  # fmt: skip

    def light_table(self, scene_index: int, lighting: Lighting, altitude: int) -> FloorLightBound:
        """Upper bounds of the light on rectangles, built once for the widest image of all."""
        key = (scene_index, lighting, altitude)
        if key not in self._light_tables:
            place = (scene_index, altitude)
            if place not in self._widest:
                self._widest[place] = self.rectangles(scene_index, altitude, np.arange(len(self.imagers)))
            self._light_tables[key] = FloorLightBound.known(
                self.problem, scene_index, lighting, altitude, self._widest[place]
            )
        return self._light_tables[key]

    # ------------------------------------------------------------ exact

    def exact(
        self, scene_index: int, lighting: Lighting, rows: Array, *, count: int = 2, pixels: Pixels | None = None,
        veils: Veils = "all", means: bool = True, known: ImageLight | None = None, deadline: Deadline = NEVER,
    ) -> ImageLight:  # fmt: skip
        """Electrons per lm s of these imagers at every altitude; see `image_light`.

        Raises OutOfTimeError past the deadline.
        """
        problem, imagers = self.problem, self.imagers
        view = imagers.scenes[scene_index].view
        port = np.zeros(len(rows), int) if problem.paper else problem.like_port[imagers.port[rows]]
        parts = []
        for value in distinct(port)[0]:
            deadline.check()
            mine = np.nonzero(port == value)[0]
            light = image_light(
                problem, scene_index, view.take(rows[mine]), imagers.camera[rows[mine]], port_index=int(value),
                lit=lighting.of(count), pixels=pixels, veils=veils, means=means,
                known=None if known is None else known.take(mine), field_type=RememberedField,
            )  # fmt: skip
            parts.append((mine, light))
        return ImageLight.in_places(parts, len(rows))

    def in_scenes(
        self, under: Under, rows: Array, *, veils: Veils = "all", known: Sequence[ImageLight] | None = None,
        deadline: Deadline = NEVER,
    ) -> list[ImageLight]:  # fmt: skip
        """`exact` in every scene of imagers under a lighting each, beside what is known of each."""
        given = known or [None] * len(self.problem.scenes)
        return [
            self.in_scene(index, under, rows, veils=veils, known=one, deadline=deadline)
            for index, one in enumerate(given)
        ]

    def in_scene(
        self, scene_index: int, under: Under, rows: Array, *, veils: Veils = "all", known: ImageLight | None = None,
        deadline: Deadline = NEVER,
    ) -> ImageLight:  # fmt: skip
        """The same in one scene."""
        parts = []
        for lighting, mine in under.each():
            before = None if known is None else known.take(mine)
            light = self.exact(scene_index, lighting, rows[mine], veils=veils, known=before, deadline=deadline)
            parts.append((mine, light))
        return parts[0][1] if len(parts) == 1 else ImageLight.in_places(parts, len(rows))

    def likely_pixel(self, scene_index: int, lighting: Lighting, rows: Array, *, count: int, pixels: Pixels) -> Array:
        """Upper bound on the electrons per lm s of the pixel that decides, at the farthest altitude, (n,)."""
        images, image_of = self.images
        key = (scene_index, lighting.optics, lighting.mount.lamps(count), pixels)
        known = self._likely.setdefault(key, np.full(len(images), np.nan))
        collecting, image = self.imagers.scenes[scene_index].view.collecting_m2, image_of[rows]
        new = distinct(image[np.isnan(known[image])])[0]
        for lit, mine in self._fields(scene_index, lighting, images[new], count):
            view = self.imagers.scenes[scene_index].view.take(images[new[mine]])
            known[new[mine]] = lit.at_likely_pixels(view, pixels) / view.collecting_m2
        return np.asarray(known[image] * collecting[rows])

    def balance(self, scene_index: int, lighting: Lighting, rows: Array) -> Array:
        """White balance of the means over these images at the farthest altitude, (n,); 1 of mono sensors."""
        images, image_of = self.images
        known = self._balance.setdefault((scene_index, lighting), np.full(len(images), np.nan))
        image = image_of[rows]
        new = distinct(image[np.isnan(known[image])])[0]
        for lit, mine in self._fields(scene_index, lighting, images[new], 2):
            view = self.imagers.scenes[scene_index].view.take(images[new[mine]])
            known[new[mine]] = lit.far_balance(view)
        return np.asarray(known[image])

    def _fields(
        self, scene_index: int, lighting: Lighting, rows: Array, count: int
    ) -> Iterator[tuple[RememberedField, Array]]:
        """The lighting as imagers of one port and one efficiency curve see it, with their places."""
        problem = self.problem
        port_of = problem.like_port[self.imagers.port[rows]]
        keys = np.stack([port_of, problem.cameras.qe_index[self.imagers.camera[rows]]])
        for port, efficiency in np.unique(keys, axis=1).T:
            field = RememberedField(
                problem, scene_index, port_index=int(port), lit=lighting.of(count), efficiency=int(efficiency)
            )
            yield field, np.nonzero((keys[0] == port) & (keys[1] == efficiency))[0]

    @cached_property
    def images(self) -> tuple[Array, Array]:
        """One imager of each image that differs by more than its collecting area, and each imager's image."""
        problem, imagers = self.problem, self.imagers
        views = [scene.view for scene in imagers.scenes]
        return rows_alike(
            problem.like_port[imagers.port], problem.cameras.qe_index[imagers.camera],
            *(tangents for view in views for tangents in (view.tan_along, view.tan_across)),
        )  # fmt: skip
