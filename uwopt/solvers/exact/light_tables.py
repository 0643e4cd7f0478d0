"""Signal of imagers under light optics: a cheap upper bound for all, the exact field mean for survivors.

A *lighting* is a pair (light optics, mount): lights that share beam and spectrum share every signal
per lumen. The bound needs no integral per imager: the mean over an image of a non-negative light is
at most the light that falls on the image's floor rectangle over its area, and that grows with the
rectangle, so a table of rectangles, rounded up, bounds every image.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.deadline import NEVER, Deadline
from uwopt.forward.lamp_light import ImageLight, Veils, image_light
from uwopt.forward.lamps import Mount, on_axis_gain, one_side
from uwopt.forward.problem import Problem
from uwopt.forward.remembered import RememberedField, RememberedSunField
from uwopt.forward.scene import Pixels
from uwopt.forward.spectra import sees_colours
from uwopt.forward.views import table_reach_m
from uwopt.model import beam as beams
from uwopt.model.imaging import Lamps, PortShape, flat_slope_m, levelled
from uwopt.model.port import flat_floor_derivative
from uwopt.solvers.exact.balance import least_white_balance
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.oblique import PlaneReach, crowding, deepest_m, path_and_field, reach_of

Array = NDArray[Any]
EDGES = 129  # rectangle edges a side in the bound's table
EDGE_RATIO = 1.04
SUN_SLACK = 1e-6  # of polynomials in place of the sun's light


@dataclass(frozen=True)
class Lighting:
    """One light optics at one mount."""

    optics: int
    mount_index: int
    mount: Mount


def lightings(problem: Problem) -> list[Lighting]:
    """All pairs of light optics and mount."""
    return [
        Lighting(optics, index, mount)
        for optics in range(len(problem.optics))
        for index, mount in enumerate(problem.mounts)
    ]


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
        self._likely: dict[Any, Array] = {}
        self._balance: dict[tuple[int, Lighting], Array] = {}
        self._chunk: tuple[Array, dict[tuple[int, int], Rectangles], Array, Array] | None = None

    def bound(
        self, scene_index: int, lighting: Lighting, altitude: int, rows: Array, *, channel: str | None = None
    ) -> Array:
        """Upper bound on the electrons per lm s of these imagers at one altitude, (n,); of one colour channel, which a
        mono sensor has not."""
        problem, imagers = self.problem, self.imagers
        rectangles, curves, back = self._of_chunk(rows)
        contraction = problem.contractions[scene_index]
        spectrum = int(contraction.spectrum_of[lighting.optics])
        collecting = imagers.scenes[scene_index].view.collecting_m2[rows]
        if problem.paper:  # knows no field, so the bound is exact
            beam, ranges = problem.beam(scene_index, lighting.optics), problem.scenes[scene_index].range_m
            axis = on_axis_gain(beam, ranges)[altitude]
            loss = [contraction.straight_loss(spectrum, int(q), channel)[altitude] for q in curves]
        else:
            loss = [self._least_loss(scene_index, lighting, altitude, int(q), channel) for q in curves]
        response = np.array([contraction.response(spectrum, int(q), channel) for q in curves]) * np.array(loss)
        if channel is not None:
            response = response * np.array([sees_colours(problem.efficiencies[int(q)]) for q in curves])
        if problem.paper:
            return np.asarray(collecting * response[back] * axis)
        key = (scene_index, altitude)
        if key not in rectangles:
            rectangles[key] = self.rectangles(scene_index, altitude, rows)
        rectangle = rectangles[key]
        light = self._light_table(scene_index, lighting, altitude).most_light(rectangle)
        return np.asarray(collecting * response[back] * light * rectangle.samples_per_m2)

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
            curves, back = np.unique(efficiency, return_inverse=True)
            self._chunk = (rows, {}, curves, back)
        return self._chunk[1:]

    def _least_loss(
        self, scene_index: int, lighting: Lighting, altitude: int, efficiency: int, channel: str | None
    ) -> float:
        """Water's loss over the shortest possible paths."""
        key = (scene_index, lighting.optics, lighting.mount_index, altitude, efficiency, channel)
        if key not in self._losses:
            contraction = self.problem.contractions[scene_index]
            spectrum = int(contraction.spectrum_of[lighting.optics])
            lamp_m, camera_m = self._shortest_m(scene_index, lighting, altitude)
            known = self.problem.scenes[scene_index].cache
            place = ("least loss", *contraction.key(spectrum, efficiency, channel), lamp_m, camera_m)
            if place not in known:
                known[place] = contraction.mean_loss(spectrum, efficiency, channel, lamp_m=lamp_m, camera_m=camera_m)
            self._losses[key] = known[place]
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
        if key not in scene.cache:
            scene.cache[key] = least_white_balance(
                contraction, spectrum, efficiency, lamp_m=(lamp_m, reach[0]), camera_m=(camera_m, reach[1])
            )
        return float(scene.cache[key])

    def _light_table(self, scene_index: int, lighting: Lighting, altitude: int) -> FloorLightBound:
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
        for value in np.unique(port):
            deadline.check()
            mine = np.nonzero(port == value)[0]
            light = image_light(
                problem, scene_index, view.take(rows[mine]), imagers.camera[rows[mine]], port_index=int(value),
                optics=lighting.optics, mount=lighting.mount, count=count, pixels=pixels, veils=veils,
                means=means, known=None if known is None else known.take(mine), field_type=RememberedField,
            )  # fmt: skip
            parts.append((mine, light))
        return ImageLight.in_places(parts, len(rows))

    def likely_pixel(self, scene_index: int, lighting: Lighting, rows: Array, *, count: int, pixels: Pixels) -> Array:
        """Upper bound on the electrons per lm s of the pixel that decides, at the farthest altitude, (n,)."""
        images, image_of = self.images
        key = (scene_index, lighting.optics, lighting.mount.lamps(count), pixels)
        known = self._likely.setdefault(key, np.full(len(images), np.nan))
        collecting, image = self.imagers.scenes[scene_index].view.collecting_m2, image_of[rows]
        new = np.unique(image[np.isnan(known[image])])
        for lit, mine in self._fields(scene_index, lighting, images[new], count):
            view = self.imagers.scenes[scene_index].view.take(images[new[mine]])
            known[new[mine]] = lit.at_likely_pixels(view, pixels) / view.collecting_m2
        return np.asarray(known[image] * collecting[rows])

    def balance(self, scene_index: int, lighting: Lighting, rows: Array) -> Array:
        """White balance of the means over these images at the farthest altitude, (n,); 1 of mono sensors."""
        images, image_of = self.images
        known = self._balance.setdefault((scene_index, lighting), np.full(len(images), np.nan))
        image = image_of[rows]
        new = np.unique(image[np.isnan(known[image])])
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
                problem, scene_index, port_index=int(port), optics=lighting.optics, mount=lighting.mount, count=count,
                efficiency=int(efficiency),
            )  # fmt: skip
            yield field, np.nonzero((keys[0] == port) & (keys[1] == efficiency))[0]

    @cached_property
    def images(self) -> tuple[Array, Array]:
        """One imager of each image that differs by more than its collecting area, and each imager's image."""
        return alike(self.problem, self.imagers)


def alike(problem: Problem, imagers: Imagers) -> tuple[Array, Array]:
    """One imager of each image that differs by more than its collecting area, and each imager's image."""
    keys = [problem.like_port[imagers.port].astype(float), problem.cameras.qe_index[imagers.camera].astype(float)]
    for scene in imagers.scenes:
        keys += [scene.view.tan_along, scene.view.tan_across]
    order = np.lexsort(keys)
    columns = np.stack(keys)[:, order]
    fresh = np.ones(len(order), bool)
    fresh[1:] = (columns[:, 1:] != columns[:, :-1]).any(axis=0)
    image_of = np.empty(len(order), int)
    image_of[order] = np.cumsum(fresh) - 1
    return order[fresh], image_of


@dataclass(frozen=True)
class FloorLightBound:
    """Upper bound of the light per lumen that falls on rectangles about the axis, by half widths.

    On a tilted plane light counts by how densely images sample it there, and the part behind the axis has a table
    of its own.
    """

    along_m: Array
    across_m: Array
    light: Array  # (n_along, n_across), grows with both
    peak_per_m2: float
    behind: FloorLightBound | None = None

    @staticmethod
    def known(
        problem: Problem, scene_index: int, lighting: Lighting, altitude: int, widest: Rectangles
    ) -> FloorLightBound:
        """One that another search in this scene has built and that reaches as far as these rectangles, or a new one."""
        scene, beam = problem.scenes[scene_index], problem.beam(scene_index, lighting.optics)
        nearest_m = problem.nearest_m(scene_index, altitude)
        place = beam, lighting.mount, altitude, widest.deepest_m, widest.path_share, nearest_m
        built: list[FloorLightBound] = scene.cache.setdefault(("light on rectangles", *place), [])
        for table in built:
            if table.reaches(widest):
                return table
        built.append(FloorLightBound.build(problem, scene_index, lighting, altitude, widest))
        return built[-1]

    def reaches(self, widest: Rectangles) -> bool:
        """Whether no rectangle goes beyond the table."""
        fits = self.along_m[-1] >= widest.half_along_m.max(initial=0.0)
        fits &= self.across_m[-1] >= widest.half_across_m.max(initial=0.0)
        if self.behind is not None:
            fits &= self.behind.along_m[-1] >= widest.behind_m.max(initial=0.0)
            fits &= self.behind.across_m[-1] >= widest.across_behind_m.max(initial=0.0)
        return bool(fits)

    @staticmethod
    def build(
        problem: Problem, scene_index: int, lighting: Lighting, altitude: int, widest: Rectangles
    ) -> FloorLightBound:
        """Sum cells outward from the axis, all four quadrants folded into one."""
        scene = problem.scenes[scene_index]
        beam, range_m = problem.beam(scene_index, lighting.optics), float(scene.range_m[altitude])
        if scene.slope:
            return FloorLightBound.oblique(problem, scene_index, lighting, altitude, widest)
        lamps = one_side(lighting.mount.lamps(2))
        peak = beams.peak_intensity_per_sr(beam) / min(range_m - z for z in lamps.z_m) ** 2
        along = edges_to(float(widest.half_along_m.max(initial=1e-6)))
        across = edges_to(float(widest.half_across_m.max(initial=1e-6)))
        cells = most_in_cells(beam, lamps, along, across, range_m,
                              float(problem.lamp_leg_per_m(scene_index, lighting.optics).min()))  # fmt: skip
        radius = np.square(along[:-1, None]) + np.square(across[None, :-1])  # of the corner next to the axis
        depth = range_m + widest.deepest_m
        least_c = float(scene.attenuation_per_m.min())
        cells *= np.exp(-least_c * (np.sqrt(depth**2 + radius) - depth) * widest.path_share)
        cells /= np.square(1.0 + radius / depth**2)
        light = np.minimum(summed(cells, along, across), 1.0)  # no more than all the light
        return FloorLightBound(along, across, light, peak)

    @staticmethod
    def oblique(
        problem: Problem, scene_index: int, lighting: Lighting, altitude: int, widest: Rectangles
    ) -> FloorLightBound:
        """The same on a tilted plane, over which the lamps stand as `levelled` has them, ahead and behind apart."""
        scene = problem.scenes[scene_index]
        beam, range_m = problem.beam(scene_index, lighting.optics), float(scene.range_m[altitude])
        lamps, port_m = levelled(one_side(lighting.mount.lamps(2)), scene.slope, range_m)
        peak = beams.peak_intensity_per_sr(beam) / min(port_m - z for z in lamps.z_m) ** 2
        least_k, least_c = (
            float(least.min())
            for least in (problem.lamp_leg_per_m(scene_index, lighting.optics), scene.attenuation_per_m)
        )
        plane: dict[str, Any] = dict(slope=scene.slope, range_m=range_m, deepest_m=widest.deepest_m)
        halves = []
        for sign, far_m, wide_m in (
            (1, widest.half_along_m, widest.half_across_m), (-1, widest.behind_m, widest.across_behind_m),
        ):  # fmt: skip
            along = edges_to(float(far_m.max(initial=1e-6)))
            across = edges_to(float(wide_m.max(initial=1e-6)))
            cells = most_in_cells(beam, lamps, along, across, port_m, least_k, ways=(sign,))
            ends = sorted([sign * along[:-1, None], sign * along[1:, None]], key=lambda edge: float(edge[0, 0]))
            path_m, field2 = path_and_field((ends[0], ends[1]), across[None, :-1], **plane)
            cells *= np.exp(-least_c * np.maximum(path_m - problem.nearest_m(scene_index, altitude), 0.0))
            cells *= crowding(ends[0], **plane) / np.square(1.0 + field2)
            most = crowding(np.minimum(sign * along, 0.0), **plane)[:, None]  # were all of the light there
            light = np.minimum(summed(cells, along, across), most)
            halves.append(FloorLightBound(along, across, light, peak))
        return replace(halves[0], behind=halves[1])

    def most_light(self, rectangle: Rectangles) -> Array:
        """Upper bound for each rectangle: the next larger one of the table, or the peak over its area."""
        i, j = rectangle.cell(self.along_m, self.across_m)
        light = self.light[i, j]
        if self.behind is not None:
            light = light + self.behind.light[rectangle.cell_behind(self.behind.along_m, self.behind.across_m)]
        return np.asarray(np.minimum(light, 4.0 * self.peak_per_m2 * rectangle.area_m2))


def summed(cells: Array, along: Array, across: Array) -> Array:
    """Light on rectangles from the axis to these edges, by that per area in the cells between them."""
    total = np.zeros((len(along), len(across)))
    total[1:, 1:] = (cells * np.diff(along)[:, None] * np.diff(across)[None, :]).cumsum(axis=0).cumsum(axis=1)
    return total


def most_in_cells(
    beam: beams.Beam, lamps: Lamps, along: Array, across: Array, range_m: float, least_k_per_m: float,
    *, ways: tuple[int, ...] = (1, -1),
) -> Array:  # fmt: skip
    """Upper bound of the light per lumen and area in each cell and its three mirror images, added up.

    `ways` along the motion: of both, or of the cells ahead (1) or behind (-1) with those across from them alone.

    Seen from a lamp at height h, a cell of half diagonal q lies within the angle q / h of its middle, and
    no nearer than its middle less q. Intensity is taken from the beam's falling envelope.
    """
    angle, envelope = beams.falling_envelope(beam)
    x = 0.5 * (along[1:] + along[:-1])[:, None]
    y = 0.5 * (across[1:] + across[:-1])[None, :]
    reach = 0.5 * np.hypot(np.diff(along)[:, None], np.diff(across)[None, :])
    cells = np.zeros((len(along) - 1, len(across) - 1))
    for sign_x, sign_y in product(ways, (1, -1)):
        for index, share in enumerate(lamps.share):
            height = range_m - lamps.z_m[index]
            cos_middle = cos_beam_of(sign_x * x, sign_y * y, lamps, index, height)
            nearest_angle = np.maximum(np.arccos(np.clip(cos_middle, -1.0, 1.0)) - reach / height, 0.0)
            at = np.minimum((nearest_angle / angle[1]).astype(int), len(angle) - 1)
            intensity = np.where(nearest_angle <= np.pi / 2, envelope[at], 0.0)
            aside = np.hypot(sign_x * x - lamps.x_m[index], sign_y * y - lamps.y_m[index])
            distance = np.sqrt(height**2 + np.square(np.maximum(aside - reach, 0.0)))
            cells += share * intensity * height / distance**3 * np.exp(-least_k_per_m * (distance - height))
    return cells


def cos_beam_of(x_m: Array, y_m: Array, lamps: Lamps, index: int, height_m: float) -> Array:
    """Cosine of the angle from a lamp's axis at floor points."""
    aim_x, aim_y, aim_z = lamps.aim[index]
    _, cosine, _ = beams.lamp_rays(
        x_m, y_m, lamp_x_m=lamps.x_m[index], lamp_y_m=lamps.y_m[index], lamp_height_m=height_m,
        aim_x=aim_x, aim_y=aim_y, aim_z=aim_z,
    )  # fmt: skip
    return np.asarray(cosine)


@dataclass(frozen=True)
class Rectangles:
    """The floor rectangle that holds each image, and how densely the image samples it.

    `crowding` bounds the image's density of samples over the uniform one (1 behind a dome, more behind
    a flat port).
    """

    half_along_m: Array
    half_across_m: Array
    area_m2: Array  # product of the half widths
    crowding: Array
    deepest_m: float  # how far behind the port's face rays may start; sets the mildest cos^4
    path_share: float  # the least share of the extra path that any ray really has
    behind_m: Array = field(default_factory=lambda: np.empty(0))  # on a tilted plane; the others are of the part ahead
    across_behind_m: Array = field(default_factory=lambda: np.empty(0))
    _cells: dict[tuple[float, float], tuple[Array, Array]] = field(default_factory=dict)

    @property
    def samples_per_m2(self) -> Array:
        """Largest density of image samples on the floor, for an image of one sample."""
        return self.crowding / (4.0 * self.area_m2)

    def cell(self, along_m: Array, across_m: Array) -> tuple[Array, Array]:
        """Indices of the next larger rectangle in a table; the same for all tables of one place."""
        key = (float(along_m[-1]), float(across_m[-1]))
        if key not in self._cells:
            i = np.minimum(np.searchsorted(along_m, self.half_along_m), len(along_m) - 1)
            j = np.minimum(np.searchsorted(across_m, self.half_across_m), len(across_m) - 1)
            self._cells[key] = (i, j)
        return self._cells[key]

    def cell_behind(self, along_m: Array, across_m: Array) -> tuple[Array, Array]:
        """The same of the part behind the axis."""
        i = np.minimum(np.searchsorted(along_m, self.behind_m), len(along_m) - 1)
        return i, np.minimum(np.searchsorted(across_m, self.across_behind_m), len(across_m) - 1)

    @staticmethod
    def tilted(reach: PlaneReach, deepest_m: float) -> Rectangles:
        """Of images on a tilted plane; the area is that over which samples lie as densely as at the axis."""
        one = np.ones(len(reach.ahead_m))
        return Rectangles(
            reach.ahead_m, reach.across_ahead_m, 0.25 / reach.samples_per_m2, one, deepest_m, 1.0,
            reach.behind_m, reach.across_behind_m,
        )  # fmt: skip

    @staticmethod
    def oblique(problem: Problem, imagers: Imagers, scene_index: int, range_m: float, rows: Array) -> Rectangles:
        """Those of imagers on a tilted plane."""
        view, columns = imagers.scenes[scene_index].view, np.ones((len(PlaneReach._fields), len(rows)))
        for mine, shape in problem.shapes(imagers.port[rows], scene_index):
            along, across = view.tan_along[rows[mine]], view.tan_across[rows[mine]]
            columns[:, mine] = reach_of(along, across, least=shape, most=shape, range_m=range_m)
        return Rectangles.tilted(PlaneReach(*columns), deepest_m(problem, scene_index))

    @staticmethod
    def of(problem: Problem, imagers: Imagers, scene_index: int, altitude: int, rows: Array) -> Rectangles:
        """Rectangles of these imagers at one altitude."""
        scene, view = problem.scenes[scene_index], imagers.scenes[scene_index].view
        near, far, range_m = (float(scene.range_m[i]) for i in (0, -1, altitude))
        if scene.slope:
            return Rectangles.oblique(problem, imagers, scene_index, range_m, rows)
        weight = 0.0 if far == near else (range_m - near) / (far - near)
        along, across = (
            0.5 * ((1 - weight) * width[rows, 0] + weight * width[rows, 2])
            for width in (view.footprint_along_m, view.footprint_across_m)
        )
        crowding = np.ones(len(rows))
        for mine, shape in problem.shapes(imagers.port[rows], scene_index):
            tangents = view.tan_along[rows[mine]], view.tan_across[rows[mine]]
            crowding[mine] = crowding_of(*tangents, along[mine], across[mine], shape=shape, range_m=range_m)
        deepest, share = Rectangles.paths(problem, scene_index, range_m)
        return Rectangles(along, across, along * across, crowding, deepest, share)

    @staticmethod
    def paths(problem: Problem, scene_index: int, range_m: float) -> tuple[float, float]:
        """`deepest_m` and `path_share` of a problem's ports."""
        ports = problem.ports
        deepest = float((ports.outer_radius_m + ports.gap_m + ports.thickness_m).max(initial=0.0))
        # A flat port with a gap, or glass thinner than water, may bend rays so far that no share is sure.
        thin = ports.refractive_index < problem.scenes[scene_index].n_water
        odd = ~ports.is_dome & ((ports.gap_m > 0) | thin)
        return deepest, 0.0 if odd.any() else range_m / (range_m + deepest)


def crowding_of(
    tan_along: Array, tan_across: Array, along_m: Array, across_m: Array, *, shape: PortShape, range_m: float
) -> Array:
    """Most samples per floor area of images, (n,), over those were they spread evenly: 1 behind a dome.

        (U V / (u v)) / (F(rho) dF/drho / rho),   rho = sqrt(u^2 + v^2): the corner's, where a flat port crowds most

    tan_along, tan_across : u, v of the half angles in air; along_m, across_m : U, V, no less than half the footprint
    shape : ports that take rays no farther from the axis than their own
    """
    if shape.is_dome:
        return np.ones(len(tan_along))
    corner = np.hypot(tan_along, tan_across)
    steep = flat_floor_derivative(
        corner, gap_m=shape.gap_m, thickness_m=shape.thickness_m, n_glass=shape.n_glass, n_water=shape.n_water,
        range_m=range_m,
    )  # fmt: skip
    spread = flat_slope_m(corner, shape=shape, range_m=range_m) * steep
    return np.asarray(along_m * across_m / (tan_along * tan_across * spread))


def edges_to(largest_m: float) -> Array:
    """Rectangle edges from 0 to the largest, 4 % apart beyond the first."""
    return np.concatenate(
        [[0.0], largest_m * (1 + 1e-12) * np.geomspace(EDGE_RATIO ** -(EDGES - 2), 1.0, EDGES - 1)]
    )
