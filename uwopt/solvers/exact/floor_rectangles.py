"""Upper bounds of the lamps' light on floor rectangles, and the rectangles that hold images."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.lamps import one_side
from uwopt.forward.problem import Problem
from uwopt.model import beam as beams
from uwopt.model.imaging import Lamps, PortShape, flat_slope_m, levelled
from uwopt.model.port import flat_floor_derivative
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import Lighting
from uwopt.solvers.exact.oblique import PlaneReach, crowding, deepest_m, path_and_field, reach_of

EDGES = 129  # rectangle edges a side in the bound's table
EDGE_RATIO = 1.04


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
        scene = problem.scenes[scene_index]
        beam = problem.floor_lobe(scene_index, lighting.optics, lighting.mount, float(scene.range_m[altitude]))
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
        range_m = float(scene.range_m[altitude])
        beam = problem.floor_lobe(scene_index, lighting.optics, lighting.mount, range_m)
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
        light = np.minimum(summed(cells, along, across), beams.flux_per_lm(beam))  # no more than all the light
        return FloorLightBound(along, across, light, peak)

    @staticmethod
    def oblique(
        problem: Problem, scene_index: int, lighting: Lighting, altitude: int, widest: Rectangles
    ) -> FloorLightBound:
        """The same on a tilted plane, over which the lamps stand as `levelled` has them, ahead and behind apart."""
        scene = problem.scenes[scene_index]
        range_m = float(scene.range_m[altitude])
        beam = problem.floor_lobe(scene_index, lighting.optics, lighting.mount, range_m)
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
            light = np.minimum(summed(cells, along, across), beams.flux_per_lm(beam) * most)
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

    Intensity is taken from the beam's falling envelope.
    """
    _, envelope = beams.falling_envelope(beam)
    cells = np.zeros((len(along) - 1, len(across) - 1))
    for one in cells_seen(lamps, along.tobytes(), across.tobytes(), range_m, ways):
        cells += one.share * envelope[one.at] * one.spread_per_m2 * np.exp(-least_k_per_m * one.longer_m)
    return cells


class CellsSeen(NamedTuple):
    """Cells as one lamp sees them, in one quadrant or in several that are alike to it."""

    share: float  # of the light, times the quadrants
    at: Array  # the next smaller of the angles of falling envelopes
    spread_per_m2: Array  # light per area and intensity at the least distance; 0 behind the lamp
    longer_m: Array  # that distance less the lamp's height


@lru_cache(maxsize=64)  # the water and all beams at one place share it: 0.3 MB a quadrant
def cells_seen(
    lamps: Lamps, along: bytes, across: bytes, range_m: float, ways: tuple[int, ...]
) -> tuple[CellsSeen, ...]:
    """The cells between these edges [m] from each lamp in each quadrant; those that are mirror images once.

    Seen from a lamp at height h, a cell of half diagonal q lies within the angle q / h of its middle, and
    no nearer than its middle less q.
    """
    along_m, across_m = np.frombuffer(along), np.frombuffer(across)
    x = 0.5 * (along_m[1:] + along_m[:-1])[:, None]
    y = 0.5 * (across_m[1:] + across_m[:-1])[None, :]
    reach = 0.5 * np.hypot(np.diff(along_m)[:, None], np.diff(across_m)[None, :])
    made, step = list[CellsSeen](), beams.ENVELOPE_RAD[1]
    for index, share in enumerate(lamps.share):
        height = range_m - lamps.z_m[index]
        ways_x, times_x = distinct_ways(ways, lamps.x_m[index], lamps.aim[index][0])
        ways_y, times_y = distinct_ways((1, -1), lamps.y_m[index], lamps.aim[index][1])
        for sign_x, sign_y in product(ways_x, ways_y):
            cos_middle = cos_beam_of(sign_x * x, sign_y * y, lamps, index, height)
            nearest_angle = np.maximum(np.arccos(np.clip(cos_middle, -1.0, 1.0)) - reach / height, 0.0)
            at = np.minimum(nearest_angle / step, len(beams.ENVELOPE_RAD) - 1).astype(np.int16)
            aside = np.hypot(sign_x * x - lamps.x_m[index], sign_y * y - lamps.y_m[index])
            distance = np.sqrt(height**2 + np.square(np.maximum(aside - reach, 0.0)))
            spread = np.where(nearest_angle <= np.pi / 2, height / distance**3, 0.0)
            made.append(CellsSeen(share * times_x * times_y, at, spread, distance - height))
    return tuple(made)


def distinct_ways(ways: tuple[int, ...], place_m: float, aim: float) -> tuple[tuple[int, ...], int]:
    """Those ways from the axis that a lamp sees apart, and how many each stands for: it may stand and aim along it."""
    is_alike = len(ways) == 2 and place_m == 0.0 and aim == 0.0
    return (ways[:1], 2) if is_alike else (ways, 1)


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
    steep = flat_floor_derivative(corner, **shape.plates, range_m=range_m)
    spread = flat_slope_m(corner, shape=shape, range_m=range_m) * steep
    return np.asarray(along_m * across_m / (tan_along * tan_across * spread))


def edges_to(largest_m: float) -> Array:
    """Rectangle edges from 0 to the largest, 4 % apart beyond the first."""
    return np.concatenate(
        [[0.0], largest_m * (1 + 1e-12) * np.geomspace(EDGE_RATIO ** -(EDGES - 2), 1.0, EDGES - 1)]
    )
