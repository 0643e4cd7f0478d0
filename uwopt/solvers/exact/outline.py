"""Bounds of camera x lens pairs behind whole groups of ports: how a large catalogue is pruned before its imagers.

A row of an outline is camera x lens x orientation x a group of ports of one geometry. Every number that a
bound needs is taken at the end of the group that favours the design: the smallest image for the light, the
largest for the frame rate, the cheapest port for the cost. What no port of the group can bear is discarded
with all its ports; what may be best is split into smaller groups, down to ports of the same optics,
whose imagers are searched together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.columns import Columns
from uwopt.forward.enclosures import bodies_of
from uwopt.forward.focus import Focused, held_at_corner, place_focus, sharp_ends_m
from uwopt.forward.motion import motion_across, motion_along, required_rate_hz
from uwopt.forward.problem import Problem
from uwopt.forward.scene import PAPER_N_WATER, SceneOptics
from uwopt.forward.spacers import needed_spacer_m
from uwopt.forward.views import Views, focus_map, pair_of, port_transmission
from uwopt.model import lens, operation, port
from uwopt.model.enclosure import tube_needed_m
from uwopt.model.imaging import FARTHEST, PortShape
from uwopt.solvers.exact.imagers import Imagers, SceneImagers, limit, stops_down
from uwopt.solvers.exact.light_tables import FieldTables, Rectangles
from uwopt.solvers.exact.oblique import PlaneReach, deepest_m, reach_of
from uwopt.tolerances import COARSE_ROUND

Array = NDArray[Any]
BRANCHES = 8  # ports, or groups of them, that a group is split into


@dataclass(frozen=True)
class PortGroups:
    """Groups of ports of one geometry: the range of each number, by group. `start:stop` are places in `order`."""

    order: Array  # all ports, the same at every level
    start: Array
    stop: Array
    is_dome: Array
    tie_low: Array  # of the complete cameras that its ports belong to; 0 of none
    tie_high: Array
    radius_low_m: Array
    radius_high_m: Array
    gap_low_m: Array
    gap_high_m: Array
    glass_low_m: Array
    glass_high_m: Array
    index_low: Array
    index_high: Array
    transmission: Array  # the most, by scene: (n_scenes, n)
    room_diameter_m: Array  # inside the housing, the most; inf without one
    room_length_m: Array
    price: Array  # the least
    limit_price: Array
    mass_kg: Array

    @property
    def size(self) -> Array:
        """Number of ports in each group."""
        return self.stop - self.start

    @staticmethod
    def of(problem: Problem, order: Array, start: Array) -> PortGroups:
        """The groups that begin at these places."""
        ports = problem.ports
        stop = np.append(start[1:], len(order))

        def low(column: Array) -> Array:
            return np.asarray(np.minimum.reduceat(column[order], start))

        def high(column: Array) -> Array:
            return np.asarray(np.maximum.reduceat(column[order], start))

        passed = []
        for index in range(len(problem.scenes)):
            known = {int(p): port_transmission(problem.shape(int(p), index)) for p in np.unique(problem.like_port)}
            passed.append(np.array([known[int(p)] for p in problem.like_port]))
        radius = ports.outer_radius_m * (0.0 if problem.paper else 1.0)
        return PortGroups(
            order, start, stop, ports.is_dome[order[start]], low(problem.ties[2]), high(problem.ties[2]), low(radius),
            high(radius), low(ports.gap_m), high(ports.gap_m), low(ports.thickness_m), high(ports.thickness_m),
            low(ports.refractive_index),
            high(ports.refractive_index), np.array([high(column) for column in passed]), high(ports.room_diameter_m),
            high(ports.room_length_m), low(ports.price),
            low(ports.limit_price), low(ports.mass_kg),
        )  # fmt: skip


def port_tree(problem: Problem) -> list[PortGroups]:
    """Groups of ports, level by level: each geometry as a whole, then parts of it, at last ports of the same optics.

    The last differ by their housings alone, of which one may beat another: only together can that be seen.
    """
    ports, alike = problem.ports, problem.port_groups
    first = np.array([group[0] for group in alike])
    depth = np.where(
        ports.is_dome, ports.outer_radius_m, ports.gap_m + ports.thickness_m / ports.refractive_index
    )
    kind = 2 * (problem.ties[2] > 0) + ports.is_dome  # ports of complete cameras stand apart from the others
    rank = np.lexsort((depth[first], kind[first]))
    order = np.concatenate([alike[group] for group in rank])
    begin = np.cumsum([0, *(len(alike[group]) for group in rank)])  # of each optics, in ports
    starts = [0, *(np.flatnonzero(np.diff(kind[first][rank])) + 1).tolist()]
    levels = [PortGroups.of(problem, order, begin[starts])]
    while len(starts) < len(rank):
        starts = sorted({
            a + (b - a) * i // BRANCHES for a, b in pairwise([*starts, len(rank)]) for i in range(BRANCHES)
        })  # fmt: skip
        levels.append(PortGroups.of(problem, order, begin[starts]))
    return levels


@dataclass(frozen=True)
class LensFocus:
    """What lenses bring to groups of ports, (n_lenses, n_groups): whether any port of the group lets the lens
    focus, and by scene, (n_scenes, n_lenses, n_groups), the least f-number times circle of confusion that keeps
    sharp what must be, and the least working factor."""

    focuses: Array
    cover_m: Array
    factor: Array


def lens_focus(problem: Problem, groups: PortGroups) -> LensFocus:
    """The best of each group's ports for every lens."""
    known = {int(p): focus_behind(problem, int(p)) for p in np.unique(problem.like_port)}
    by_port = [known[int(problem.like_port[p])] for p in groups.order]
    focuses = np.stack([one[0] for one in by_port], axis=1)
    cover = np.where(focuses, np.stack([one[1] for one in by_port], axis=2), np.inf)
    factor = np.where(focuses, np.stack([one[2] for one in by_port], axis=2), np.inf)
    return LensFocus(
        np.logical_or.reduceat(focuses, groups.start, axis=1),
        np.minimum.reduceat(cover, groups.start, axis=2),
        np.minimum.reduceat(factor, groups.start, axis=2),
    )


def focus_behind(problem: Problem, port_index: int) -> tuple[Array, Array, Array]:
    """Whether each lens focuses behind one port, and by scene the f-number that its depth needs times the circle
    of confusion and the working factor; lower bounds where the place of the focus depends on the camera."""
    lenses, scenes = problem.lenses, problem.scenes
    n = len(lenses.price)
    focal = focal_lengths_m(problem, bool(problem.ports.is_dome[port_index]))
    maps = [focus_map(scene, problem.shape(port_index, i)) for i, scene in enumerate(scenes)]
    relative = [scene.view.requirements.circle_of_confusion_px for scene in scenes]
    mixed = None in relative and len(set(relative)) > 1  # some by the pixel, some by the sensor
    if mixed or any(held_at_corner(scene) for scene in scenes):
        return np.ones(n, bool), own_covers_m(scenes, maps, focal), np.ones((len(scenes), n))
    coc = [np.full(n, wanted or 1.0) for wanted in relative]
    focus = place_focus(scenes, maps, [empty_views(n, coc_m=own, focal_length_m=focal) for own in coc])
    ok, factors = np.ones(n, bool), []
    for scene, dioptre in zip(scenes, focus.dioptre_per_m, strict=True):
        with np.errstate(divide="ignore", invalid="ignore"):
            factor = lens.working_f_number(1.0, focal_length_m=focal, object_distance_m=1.0 / dioptre)
        ok &= np.isfinite(needed_spacer_m(lenses, dioptre, slack=COARSE_ROUND))
        factors.append(np.ones(n) if scene.paper else factor)
    return ok, np.array(focus.n_depth) * np.array(coc), np.array(factors)


def own_covers_m(scenes: Sequence[SceneOptics], maps: Sequence[port.FocusMap], focal_m: Array) -> Array:
    """The f-number times circle of confusion that each scene would need if the focus were its own, on the axis."""
    covers = []
    for scene, at in zip(scenes, maps, strict=True):
        near, far = (float(port.lens_dioptre_per_m(end, focus_map=at)) for end in sharp_ends_m(scene))
        covers.append(
            lens.f_number_to_cover(
                near, far_dioptre_per_m=far, focal_length_m=focal_m, circle_of_confusion_m=1.0
            )
        )
    return np.array(covers)


def focal_lengths_m(problem: Problem, dome: bool) -> Array:
    """Effective focal lengths of all lenses behind a port."""
    longer = PAPER_N_WATER if problem.paper and not dome else 1.0
    return np.asarray(problem.lenses.focal_length_m * longer)


def empty_views(n: int, **columns: Array) -> Views:
    """Views of which only some columns mean something."""
    nothing = {name: np.zeros(n) for name in Views.__dataclass_fields__}
    return Views(**(nothing | columns))


@dataclass(frozen=True)
class Extent:
    """Half widths of images on the floor, the least and the most that the ports of a group give, (n,)."""

    along_low_m: Array
    along_high_m: Array
    across_low_m: Array
    across_high_m: Array


@dataclass(frozen=True)
class OutlineRows(Columns):
    """Camera x lens x orientation x group of ports at one level of the tree."""

    camera: Array
    lens: Array
    landscape: Array
    group: Array

    def __len__(self) -> int:
        return len(self.camera)


class Level:
    """One level of the tree of ports, ready to bound rows."""

    def __init__(self, problem: Problem, groups: PortGroups):
        self.problem, self.groups = problem, groups
        self.lens_focus = lens_focus(problem, groups)

    def pixel_per_range(self, rows: OutlineRows) -> Array:
        """Pixel pitch over effective focal length."""
        problem = self.problem
        focal = problem.lenses.focal_length_m[rows.lens]
        if problem.paper:
            focal = np.where(self.groups.is_dome[rows.group], focal, focal * PAPER_N_WATER)
        return np.asarray(problem.cameras.pixel_pitch_m[rows.camera] / focal)

    def tangents(self, rows: OutlineRows) -> tuple[Array, Array]:
        """Tangents in air of the half angles of view along and across the motion."""
        cameras, scale = self.problem.cameras, 0.5 * self.pixel_per_range(rows)
        half_x = cameras.resolution_x_px[rows.camera] * scale
        half_y = cameras.resolution_y_px[rows.camera] * scale
        return np.where(rows.landscape, half_y, half_x), np.where(rows.landscape, half_x, half_y)

    def path_m(self, scene: SceneOptics, rows: OutlineRows, range_m: float, *, high: bool) -> Array:
        """Metres of floor per tangent in air on the axis: what the range counts for behind these ports."""
        if scene.paper:
            return np.full(len(rows), range_m)
        g, at = self.groups, rows.group
        if high:
            flat = g.gap_high_m + g.glass_high_m / g.index_low + range_m / scene.n_water
            return np.where(g.is_dome, range_m + g.radius_high_m, flat)[at]
        flat = g.gap_low_m + g.glass_low_m / g.index_high + range_m / scene.n_water
        return np.where(g.is_dome, range_m + g.radius_low_m, flat)[at]

    def edges_m(
        self, scene: SceneOptics, rows: OutlineRows, tangent: Array, range_m: float
    ) -> tuple[Array, Array]:
        """Least and most distance on the floor of rays at these tangents: grows with radius, gap and glass,
        falls with the glass's index."""
        if scene.paper:
            return tangent * range_m, tangent * range_m
        g, at = self.groups, rows.group
        dome = g.is_dome[at]
        water = range_m * port.water_tangent(tangent, n=scene.n_water)
        ends = []
        for gap, glass, index, radius in (
            (g.gap_low_m, g.glass_low_m, g.index_high, g.radius_low_m),
            (g.gap_high_m, g.glass_high_m, g.index_low, g.radius_high_m),
        ):
            flat = gap[at] * tangent + glass[at] * port.water_tangent(tangent, n=index[at]) + water
            ends.append(np.where(dome, (range_m + radius[at]) * tangent, flat))
        return ends[0], ends[1]

    def extent(self, scene: SceneOptics, rows: OutlineRows, range_m: float) -> Extent:
        """Half widths of the images at one range; on a tilted plane half their depth, and half their near edge."""
        along, across = self.tangents(rows)
        if scene.slope:
            corner = np.hypot(along, across)
            near = 1.0 + scene.slope * along * self.per_metre(scene, rows, corner)
            deep = [half * self.deepening(scene, rows) for half in self.edges_m(scene, rows, along, range_m)]
            wide = [ray * across / (corner * near) for ray in self.edges_m(scene, rows, corner, range_m)]
            return Extent(*deep, *wide)
        return Extent(*self.edges_m(scene, rows, along, range_m), *self.edges_m(scene, rows, across, range_m))

    def per_metre(self, scene: SceneOptics, rows: OutlineRows, tangent: Array) -> Array:
        """Tangents in water of rays at these tangents in air, over the latter: 1 behind a dome."""
        bent = port.water_tangent(tangent, n=scene.n_water) / tangent
        return np.where(self.groups.is_dome[rows.group], 1.0, bent)

    def descents(self, scene: SceneOptics, rows: OutlineRows) -> tuple[Array, Array]:
        """How much faster rays come to a tilted plane than to a square one, in the middle of the near and far edge."""
        along, _ = self.tangents(rows)
        slope = scene.slope * along * self.per_metre(scene, rows, along)
        return 1.0 + slope, 1.0 - slope

    def deepening(self, scene: SceneOptics, rows: OutlineRows) -> Array:
        """Depth of an image on a tilted plane over that on a square one."""
        near, far = self.descents(scene, rows)
        return 0.5 * np.hypot(1.0, scene.slope) * (1.0 / near + 1.0 / np.maximum(far, 1.0 / FARTHEST))

    def pixel_path_m(self, scene: SceneOptics, rows: OutlineRows, range_m: float) -> Array:
        """The least that the largest pixel can be, over its tangent: in the middle, or far on a tilted plane.

        At the far edge it is sqrt(1 + s^2) (A' + d W' + s u (W' A - W A')) / D^2, at least without what the port adds.
        """
        middle = self.path_m(scene, rows, range_m, high=False)
        if not scene.slope:
            return middle
        along, _ = self.tangents(rows)
        far = np.maximum(self.descents(scene, rows)[1], 1.0 / FARTHEST)
        in_water = range_m * scene.n_water**2 * self.per_metre(scene, rows, along) ** 3
        edge = np.where(self.groups.is_dome[rows.group], middle, in_water) / np.square(far)
        return np.asarray(np.hypot(1.0, scene.slope) * np.maximum(middle, edge))

    def oblique_pixels_m(self, scene: SceneOptics, rows: OutlineRows, range_m: float) -> tuple[Array, Array]:
        """What `smallest_pixels_m` is of a tilted plane: no more than in the middle of its near edge."""
        scale, dome = self.pixel_per_range(rows), self.groups.is_dome[rows.group]
        along, _ = self.tangents(rows)
        near, per_m = self.descents(scene, rows)[0], self.per_metre(scene, rows, along)
        whole = self.path_m(scene, rows, range_m, high=True)
        port_m = (self.groups.gap_high_m + self.groups.glass_high_m / self.groups.index_low)[rows.group]
        flat = port_m / near + range_m * scene.n_water**2 * per_m**3 / np.square(near)
        deep = np.hypot(1.0, scene.slope) * np.where(dome, whole / np.square(near), flat)
        return scale * deep, scale * np.where(dome, whole, port_m + range_m * per_m) / near

    def blur_time_s(self, scene: SceneOptics, rows: OutlineRows) -> Array:
        """The most time that the blur leaves, at the nearest altitude: no less than at the worst one."""
        blur_px = scene.view.requirements.max_blur_px
        if blur_px is None:
            return np.full(len(rows), np.inf)
        range_m = float(scene.range_m[0])
        lever = range_m + self.groups.radius_low_m[rows.group]
        pixel_along, pixel_across = self.smallest_pixels_m(scene, rows, range_m)
        time = np.full(len(rows), np.inf)
        for pixel, motion in (
            (pixel_along, motion_along(scene, lever)),
            (pixel_across, motion_across(scene, lever)),
        ):
            time = np.minimum(time, operation.blur_exposure_s(blur_px, ground_sample_m=pixel, **motion))
        return time

    def smallest_pixels_m(self, scene: SceneOptics, rows: OutlineRows, range_m: float) -> tuple[Array, Array]:
        """The most that the smallest ground samples along and across can be.

        Behind a flat port the glass's term, t (n^2 + k v^2) / (n^2 + k rho^2)^(3/2), is at most t / n.
        """
        if scene.slope:
            return self.oblique_pixels_m(scene, rows, range_m)
        scale, whole = self.pixel_per_range(rows), self.path_m(scene, rows, range_m, high=True)
        if scene.paper:
            return scale * whole, scale * whole
        g, at = self.groups, rows.group
        dome = g.is_dome[at]
        along, across = self.tangents(rows)
        port_m = (g.gap_high_m + g.glass_high_m / g.index_low)[at]
        n2 = scene.n_water**2
        pixels = []
        for u2, v2 in ((along**2, across**2), (across**2, along**2)):
            middle = n2 / (n2 + (n2 - 1.0) * u2) ** 1.5
            corner = (n2 + (n2 - 1.0) * v2) / (n2 + (n2 - 1.0) * (u2 + v2)) ** 1.5
            flat = port_m + range_m * np.minimum(middle, corner)
            pixels.append(scale * np.where(dome, whole, flat))
        return pixels[0], pixels[1]

    def crowding(self, scene: SceneOptics, rows: OutlineRows, extent: Extent, range_m: float) -> Array:
        """The most that flat ports crowd samples at the corner; see `fields.crowding_of`."""
        g, at = self.groups, rows.group
        along, across = self.tangents(rows)
        corner = np.hypot(along, across)
        distance, _ = self.edges_m(scene, rows, corner, range_m)
        n_water, n_glass = scene.n_water, g.index_high[at]
        steep = g.gap_low_m[at] + sum(
            length * n**2 / (n**2 + (n**2 - 1.0) * corner**2) ** 1.5
            for length, n in ((g.glass_low_m[at], n_glass), (range_m, n_water))
        )
        flat = extent.along_high_m * extent.across_high_m / (along * across * (distance / corner) * steep)
        return np.where(g.is_dome[at], 1.0, flat)

    def reach(self, scene: SceneOptics, rows: OutlineRows, range_m: float) -> PlaneReach:
        """How far images may reach on a tilted plane behind any port of the group, and how densely sample it."""
        g, (along, across) = self.groups, self.tangents(rows)
        columns = np.ones((len(PlaneReach._fields), len(rows)))
        for is_dome in (True, False):
            mine = np.nonzero(g.is_dome[rows.group] == is_dome)[0]
            at = rows.group[mine]
            least, most = (
                PortShape(
                    is_dome, *cast(tuple[float, float, float, float], tuple(column[at] for column in ends)),
                    scene.n_water, slope=scene.slope,
                )
                for ends in (
                    (g.radius_low_m, g.glass_low_m, g.index_high, g.gap_low_m),
                    (g.radius_high_m, g.glass_high_m, g.index_low, g.gap_high_m),
                )
            )  # fmt: skip
            columns[:, mine] = reach_of(along[mine], across[mine], least=least, most=most, range_m=range_m)
        return PlaneReach(*columns)

    # ------------------------------------------------------------ rules and columns

    def imagers(self, rows: OutlineRows) -> Imagers:
        """These rows as if they were imagers, every column at its best."""
        problem, g = self.problem, self.groups
        cameras, lenses = problem.cameras, problem.lenses
        count = problem.mission.vehicle.camera_count
        extra_cost, extra_mass, _ = problem.extras

        def total(name: str, ports: Array) -> Array:
            return np.asarray(
                count
                * (getattr(cameras, name)[rows.camera] + getattr(lenses, name)[rows.lens] + ports[rows.group])
            )

        scenes = [self.scene_imagers(index, rows) for index in range(len(problem.scenes))]
        gsd_m = np.max([scene.view.gsd_m for scene in scenes], axis=0)
        rates = [scene.focused.rate_hz for scene in scenes]
        power_w = problem.least_camera_power_w(cameras.take(rows.camera), rates)
        return Imagers(
            rows.camera, rows.lens, g.order[g.start][rows.group], rows.landscape,
            total("price", g.price) + extra_cost, total("limit_price", g.limit_price) + extra_cost,
            total("mass_kg", g.mass_kg) + extra_mass, power_w,
            gsd_m * 1e3, scenes, {}, {},
        )  # fmt: skip

    def scene_imagers(self, index: int, rows: OutlineRows) -> SceneImagers:
        """Views and focus of these rows in one scene; only what bounds look at."""
        problem, scene = self.problem, self.problem.scenes[index]
        cameras, lenses = problem.cameras, problem.lenses
        nominal_m = float(scene.range_m[scene.nominal])
        needs = scene.view.requirements
        at_nominal = self.extent(scene, rows, nominal_m)
        nearest = self.extent(scene, rows, float(scene.range_m[0]))
        pitch = cameras.pixel_pitch_m[rows.camera]
        passed = 1.0 if scene.paper else self.groups.transmission[index][rows.group]
        low = np.stack([2.0 * at_nominal.along_low_m] * 2, axis=1)  # bounds look at the nominal altitude, 1
        across_low = np.stack([2.0 * at_nominal.across_low_m] * 2, axis=1)
        view = empty_views(
            len(rows), footprint_along_m=low, footprint_across_m=across_low, area_m2=low * across_low,
            gsd_m=self.pixel_per_range(rows) * self.pixel_path_m(scene, rows, nominal_m),
            collecting_m2=np.square(pitch) * lenses.transmission[rows.lens] * passed * cameras.qe_scale[rows.camera],
        )  # fmt: skip
        n_depth = self.lens_focus.cover_m[index][rows.lens, rows.group] / self.coc_m(scene, rows)
        nothing = np.zeros(len(rows))
        rate = required_rate_hz(needs, scene.view.vehicle.speed_m_s, 2.0 * nearest.along_high_m)
        return SceneImagers(view, Focused(
            nothing, self.lens_focus.factor[index][rows.lens, rows.group],
            np.maximum(lenses.f_number_from(needs.lens_stop_down)[rows.lens], n_depth),
            lenses.f_number_max[rows.lens], rate, self.blur_time_s(scene, rows), nothing, nothing, nothing,
        ))  # fmt: skip

    def coc_m(self, scene: SceneOptics, rows: OutlineRows) -> Array:
        """Circle of confusion of the cameras."""
        from uwopt.forward.views import PAPER_COC_PER_DIAGONAL

        cameras, wanted_px = self.problem.cameras, scene.view.requirements.circle_of_confusion_px
        pitch = cameras.pixel_pitch_m[rows.camera]
        if wanted_px is not None:
            return np.asarray(wanted_px * pitch)
        diagonal = (
            np.hypot(cameras.resolution_x_px[rows.camera], cameras.resolution_y_px[rows.camera]) * pitch
        )
        return np.asarray(diagonal * PAPER_COC_PER_DIAGONAL)

    def rules(self, rows: OutlineRows, imagers: Imagers) -> list[tuple[str, Array]]:
        """Each imagers' rule with the rows that some port of the group may pass, in the imagers' order."""
        problem, limits = self.problem, self.problem.mission.limits
        cameras, count = problem.cameras, problem.mission.vehicle.camera_count
        tie, at = problem.ties[0][rows.camera], rows.group
        every = np.ones(len(rows), bool)
        passes: dict[str, Array] = {
            "complete": (self.groups.tie_low[at] <= tie) & (tie <= self.groups.tie_high[at]), "horizon": every.copy(),
            "focus": self.lens_focus.focuses[rows.lens, rows.group],
        }  # fmt: skip
        for name in (
            "max_gsd_mm", "min_swath_m", "min_common_swath_m", "max_depth_error_mm", "frame_rate", "data_rate_mb_s",
            "storage_gb", "card_gb",
        ):  # fmt: skip
            passes[name] = every.copy()
        duration, rates = problem.duration, []
        passes["lens_stop_down"] = stops_down(problem, problem.lenses)[rows.lens]
        passes["min_dof_m"] = every.copy()
        for scene, seen in zip(problem.scenes, imagers.scenes, strict=True):
            needs, focused = scene.view.requirements, seen.focused
            passes["horizon"] &= self.descents(scene, rows)[1] * FARTHEST * COARSE_ROUND >= 1.0
            far = self.pixel_path_m(scene, rows, float(scene.range_m[-1]))
            gsd_mm = self.pixel_per_range(rows) * far * 1e3
            passes["max_gsd_mm"] &= gsd_mm <= limit(needs.max_gsd_mm) * COARSE_ROUND
            if needs.min_swath_m is not None:
                nearest = self.extent(scene, rows, float(scene.range_m[0]))
                passes["min_swath_m"] &= 2.0 * nearest.across_high_m * COARSE_ROUND >= needs.min_swath_m
            self.pair_rules(passes, scene, rows)
            passes["frame_rate"] &= focused.rate_hz <= cameras.max_rate_hz[rows.camera] * COARSE_ROUND
            data = focused.rate_hz * cameras.frame_mb[rows.camera] * count
            passes["data_rate_mb_s"] &= data <= limit(limits.data_rate_mb_s) * COARSE_ROUND
            rates.append(data)
            passes["min_dof_m"] &= np.isfinite(focused.n_low) & (
                focused.n_low <= focused.n_high * COARSE_ROUND
            )
        passes["card_gb"] = duration.mean(rates) <= COARSE_ROUND * count * duration.mean_rate_into(
            cameras.storage_gb[rows.camera]
        )
        passes["storage_gb"] = duration.mean(rates) <= duration.mean_data_limit_mb_s * COARSE_ROUND
        passes["max_blur_px"] = cameras.min_exposure_s[rows.camera] <= limits.max_exposure_ms * 1e-3
        passes["housing"] = self.may_fit(rows)
        passes["cost"] = imagers.limit_cost <= limit(limits.cost) * COARSE_ROUND
        passes["mass_kg"] = imagers.mass_kg <= limit(limits.mass_kg) * COARSE_ROUND
        passes["power_w"] = imagers.camera_power_w <= limit(limits.power_w) * COARSE_ROUND
        passes["energy_wh"] = imagers.camera_power_w <= duration.mean_power_limit_w * COARSE_ROUND
        return list(passes.items())


    def pair_rules(self, passes: dict[str, Array], scene: SceneOptics, rows: OutlineRows) -> None:
        """What a stereo pair that is not turned inward may see and measure at best; turned, its imagers are asked.

        The strip is the footprint less the baseline. Behind domes the error is the same all over it; behind a flat port
        no pixel in it is smaller than on the image's edge, and the rays to its middle meet at B / d at most.
        """
        needs, pair = scene.view.requirements, pair_of(scene)
        if pair is None or pair.turn_rad > 0.0:
            return
        nearest = self.extent(scene, rows, float(scene.range_m[0]))
        if needs.min_common_swath_m is not None:
            strip_m = 2.0 * nearest.across_high_m * COARSE_ROUND - pair.baseline_m
            passes["min_common_swath_m"] &= strip_m >= needs.min_common_swath_m
        if needs.max_depth_error_mm is not None:
            range_m = float(scene.range_m[-1])
            square = np.square(self.path_m(scene, rows, range_m, high=False))
            if not scene.paper:
                bent = self.per_metre(scene, rows, self.tangents(rows)[1])
                flat = range_m**2 * scene.n_water**2 * bent**3
                square = np.where(self.groups.is_dome[rows.group], square, flat)
            least_m = needs.disparity_error_px * self.pixel_per_range(rows) * square / pair.baseline_m
            passes["max_depth_error_mm"] &= least_m * 1e3 <= needs.max_depth_error_mm * COARSE_ROUND

    def may_fit(self, rows: OutlineRows) -> Array:
        """Whether the roomiest housing of the group is wide enough, and as long as what lies behind the pupil.

        That is what a tube behind a dome needs, the least of all: a flat port leaves room for the lens's front too, and
        a sphere's diameter is more than either; a spacer ring makes it longer.
        """
        bodies = bodies_of(self.problem.cameras.take(rows.camera), self.problem.lenses.take(rows.lens), 0.0)
        width, length = self.groups.room_diameter_m[rows.group], self.groups.room_length_m[rows.group]
        wide, long = tube_needed_m(bodies, is_dome=True, gap_m=0.0)
        return np.asarray((wide <= width * COARSE_ROUND) & (long <= length * COARSE_ROUND))


class OutlineTables(FieldTables):
    """Bounds of the light of rows of an outline."""

    def __init__(self, level: Level, rows: OutlineRows, imagers: Imagers, like: FieldTables):
        super().__init__(level.problem, imagers, like=like)
        self.level, self.outline = level, rows

    def rectangles(self, scene_index: int, altitude: int, rows: Array) -> Rectangles:
        """The largest rectangle for the light, the smallest for the area it is spread over."""
        scene, some = self.problem.scenes[scene_index], self.outline.take(rows)
        range_m = float(scene.range_m[altitude])
        if scene.slope:
            return Rectangles.tilted(self.level.reach(scene, some, range_m), deepest_m(self.problem, scene_index))
        extent = self.level.extent(scene, some, range_m)
        crowding = self.level.crowding(scene, some, extent, range_m)
        behind_m, share = Rectangles.paths(self.problem, scene_index, range_m)
        area = extent.along_low_m * extent.across_low_m
        return Rectangles(extent.along_high_m, extent.across_high_m, area, crowding, behind_m, share)
