"""Bounds of camera x lens pairs behind whole groups of ports: how a large catalogue is pruned before its imagers.

A row of an outline is camera x lens x orientation x a group of ports of one geometry, at first with groups of cameras
and of lenses in their place. Every number that a bound needs is taken at the end of the group that favours the design:
the smallest image for the light, the largest for the frame rate, the cheapest port for the cost. What no part of the
group can bear is discarded with all of them; what may be best is split into smaller groups, down to single pairs
behind ports of the same optics, whose imagers are searched together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.breathing import covered_sides
from uwopt.forward.columns import Columns
from uwopt.forward.enclosures import bodies_of
from uwopt.forward.focus import Focused
from uwopt.forward.motion import blur_time_s, required_rate_hz
from uwopt.forward.part_columns import Lenses
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.forward.views import (
    PAPER_PORT,
    Views,
    altitudes_m,
    circle_of_confusion_m,
    edge_m,
    field_of_view,
    footprints,
    largest_pixel_m,
    pair_of,
    port_shapes,
)
from uwopt.model.enclosure import tube_needed_m
from uwopt.model.imaging import PortShape, ray_spread
from uwopt.solvers.exact.floor_rectangles import Rectangles, crowding_of
from uwopt.solvers.exact.imager_rules import below_horizon, focus_rules, limit, sight_rules
from uwopt.solvers.exact.imagers import Imagers, SceneImagers
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.oblique import (
    PlaneReach,
    deepest_m,
    least_oblique_pixel_m,
    most_oblique_pixels_m,
    reach_of,
)
from uwopt.solvers.exact.pair_groups import PairGroups
from uwopt.solvers.exact.port_groups import PortGroups, empty_views, lens_focus
from uwopt.tolerances import COARSE_ROUND

WIDE = (  # (n, 3)
    "footprint_along_m", "footprint_across_m", "covered_along_m", "covered_across_m", "area_m2", "gsd_m",
    "pixel_along_m", "pixel_across_m",
)  # fmt: skip
COVERED = ("covered_along_m", "covered_across_m")
NARROW = ("tan_along", "tan_across", "farthest")


@dataclass(frozen=True)
class OutlineScene(SceneImagers):
    """One scene behind groups of ports: `view` has images at their smallest and pixels at their largest, `most` has
    images and pixels at their largest; (n, 3) at near, nominal and far altitude, as imagers have them."""

    most: Views

    @property
    def most_area_m2(self) -> Array:
        """As `SceneImagers`."""
        return self.most.area_m2

    @property
    def ends(self) -> tuple[Views, ...]:
        """As `SceneImagers`."""
        return self.view, self.most


@dataclass(frozen=True)
class OutlineRows(Columns):
    """Camera x lens x orientation x group of ports at one level of the tree; of either, too, it may be a group."""

    camera: Array
    lens: Array
    landscape: Array
    group: Array

    def __len__(self) -> int:
        return len(self.camera)


class Level:
    """One level of the tree, ready to bound rows: of ports, and of pairs where these are in groups."""

    def __init__(self, problem: Problem, groups: PortGroups, pairs: PairGroups | None = None):
        self.problem, self.short, self.groups, self.pairs = problem, problem.lenses, groups, pairs
        self.lens_focus = lens_focus(problem, groups)
        if pairs is not None:
            self.problem, self.short = pairs.problem, pairs.short
            self.lens_focus = self.lens_focus.grouped(pairs.lens_order, pairs.lens_start)

    def imagers_in(self, rows: OutlineRows) -> Array:
        """How many imagers these rows hold."""
        size = self.groups.size[rows.group]
        return size if self.pairs is None else size * self.pairs.count[rows.camera, rows.lens]

    def one_of(self, rows: OutlineRows, row: int) -> tuple[int, int, int, bool]:
        """Camera, lens, port and orientation of the first imager of a row."""
        pair = int(rows.camera[row]), int(rows.lens[row])
        if self.pairs is not None:
            pair = self.pairs.one_of(*pair)
        return *pair, int(self.groups.order[self.groups.start[rows.group[row]]]), bool(rows.landscape[row])

    def view(self, index: int, rows: OutlineRows, *, most: bool) -> Views:
        """What these rows see in one scene, at the end of their groups that sees least or most; only what bounds look
        at."""
        scene, n = self.problem.scenes[index], len(rows)
        ports, every_lens = (self.groups.most, self.short) if most else (self.groups.least, self.problem.lenses)
        columns = {name: np.empty((n, 3) if name in WIDE else n) for name in (*WIDE, *NARROW)}
        for mine, shape in port_shapes(ports, rows.group, scene):
            some = rows.take(mine)
            along, across, focal, pitch = self.seen(scene, some, shape, every_lens)
            altitudes = altitudes_m(scene)
            seen = footprints(scene, shape, along, across, pitch, focal, altitudes)
            if scene.slope:  # places of the least and most pixels differ from port to port
                most_m = most_oblique_pixels_m(along[:, None], most=shape.over(1), range_m=altitudes)
                pixel_along_m, pixel_across_m = ((pitch / focal)[:, None] * each for each in most_m)
                seen |= dict(
                    gsd_m=self.gsd_m(index, some), pixel_along_m=pixel_along_m, pixel_across_m=pixel_across_m
                )
            seen |= dict(tan_along=along, tan_across=across)
            sides = np.zeros((2, len(mine), 3))  # at least
            if most:
                factor = self.lens_focus.factor[index][some.lens, some.group]
                sides = np.array(covered_sides(scene, shape, along, across, factor, seen))
            seen |= dict(zip(COVERED, sides, strict=True))
            for name, column in columns.items():
                column[mine] = seen[name]
        return empty_views(n, **columns)

    def gsd_m(self, index: int, rows: OutlineRows) -> Array:
        """The least that the largest pixels can be at near, nominal and far altitude, (n, 3)."""
        scene, gsd_m = self.problem.scenes[index], np.empty((len(rows), 3))
        altitudes = altitudes_m(scene)
        for mine, shape in port_shapes(self.groups.least, rows.group, scene):
            along, _, focal, pitch = self.seen(scene, rows.take(mine), shape)
            if scene.slope:
                least_m = least_oblique_pixel_m(along[:, None], least=shape.over(1), range_m=altitudes)
                gsd_m[mine] = (pitch / focal)[:, None] * least_m
            else:
                gsd_m[mine] = largest_pixel_m(scene, shape, pitch, focal, altitudes)
        return gsd_m

    def reach(self, scene: SceneOptics, rows: OutlineRows, range_m: float) -> PlaneReach:
        """How far images may reach on a tilted plane behind any port of the group, and how densely sample it."""
        columns = np.ones((len(PlaneReach._fields), len(rows)))
        for mine, least, most in self.ends(scene, rows.group):
            tangents = self.tangents(scene, rows.take(mine), least)
            columns[:, mine] = reach_of(*tangents, least=least, most=most, range_m=range_m)
        return PlaneReach(*columns)

    def ends(self, scene: SceneOptics, group: Array) -> Iterator[tuple[Array, PortShape, PortShape]]:
        """Both ends of the rows' groups as columns, by geometry, with the places of its rows."""
        both = (port_shapes(ports, group, scene) for ports in (self.groups.least, self.groups.most))
        for (mine, least), (_, most) in zip(*both, strict=True):
            yield mine, least, most

    def seen(
        self, scene: SceneOptics, rows: OutlineRows, shape: PortShape, every_lens: Lenses | None = None
    ) -> tuple[Array, Array, Array, Array]:
        """Tangents in air of the half angles of view along and across the motion, focal length and pixel pitch; of the
        longest lenses by default."""
        cameras = self.problem.cameras.take(rows.camera)
        lenses = (self.problem.lenses if every_lens is None else every_lens).take(rows.lens)
        return *field_of_view(scene, cameras, lenses, shape, rows.landscape), cameras.pixel_pitch_m

    def tangents(
        self, scene: SceneOptics, rows: OutlineRows, shape: PortShape, every_lens: Lenses | None = None
    ) -> tuple[Array, Array]:
        """Those tangents alone."""
        return self.seen(scene, rows, shape, every_lens)[:2]

    # ------------------------------------------------------------ rules and columns

    def imagers(self, rows: OutlineRows) -> Imagers:
        """These rows as if they were imagers, every column at its best."""
        problem, g = self.problem, self.groups
        cameras, lenses = problem.cameras, problem.lenses
        count = problem.mission.vehicle.camera_count
        extra_cost, extra_mass, _ = problem.extras

        def total(name: str) -> Array:
            kinds = (cameras, rows.camera), (lenses, rows.lens), (g.least, rows.group)
            return np.asarray(count * sum(getattr(kind, name)[at] for kind, at in kinds))

        scenes: list[SceneImagers] = [self.scene_imagers(index, rows) for index in range(len(problem.scenes))]
        gsd_m = np.max([scene.view.gsd_m[:, 1] for scene in scenes], axis=0)
        rates = [scene.focused.rate_hz for scene in scenes]
        power_w = problem.least_camera_power_w(cameras.take(rows.camera), rates)
        return Imagers(
            rows.camera, rows.lens, g.order[g.start][rows.group], rows.landscape,
            total("price") + extra_cost, total("limit_price") + extra_cost, total("mass_kg") + extra_mass, power_w,
            gsd_m * 1e3, scenes,
        )  # fmt: skip

    def scene_imagers(self, index: int, rows: OutlineRows) -> OutlineScene:
        """Views and focus of these rows in one scene; only what bounds look at."""
        problem, scene = self.problem, self.problem.scenes[index]
        cameras, lenses = problem.cameras.take(rows.camera), problem.lenses.take(rows.lens)
        needs = scene.view.requirements
        passed = 1.0 if scene.paper else self.groups.transmission[index][rows.group]
        view, most = (self.view(index, rows, most=end) for end in (False, True))
        collecting_m2 = np.square(cameras.pixel_pitch_m) * lenses.transmission * passed * cameras.qe_scale
        blur_s = np.empty(len(rows))
        for mine, least, _ in self.ends(scene, rows.group):
            blur_s[mine] = blur_time_s(scene, least, empty_views(
                len(mine), pixel_along_m=most.pixel_along_m[mine], pixel_across_m=most.pixel_across_m[mine]
            ))  # fmt: skip
        n_depth = self.lens_focus.cover_m[index][rows.lens, rows.group] / circle_of_confusion_m(scene, cameras)
        rate = required_rate_hz(needs, scene.view.vehicle.speed_m_s, most.covered_along_m[:, 0])
        nothing = np.zeros(len(rows))
        focused = Focused(
            nothing, self.lens_focus.factor[index][rows.lens, rows.group],
            np.maximum(self.lens_focus.closed[index][rows.lens], n_depth),
            lenses.f_number_max, rate, blur_s, nothing, nothing, nothing,
        )  # fmt: skip
        return OutlineScene(replace(view, collecting_m2=collecting_m2), focused, most)

    def rules(self, rows: OutlineRows, imagers: Imagers) -> list[tuple[str, Array]]:
        """Each imagers' rule with the rows that some port of the group may pass, in the imagers' order."""
        problem, limits, at = self.problem, self.problem.mission.limits, rows.group
        tie = problem.ties[0][rows.camera]
        seen = [self.best_seen(index, rows, one) for index, one in enumerate(imagers.scenes)]
        focused = [one.focused for one in imagers.scenes]
        passes = {
            "complete": (self.groups.tie_low[at] <= tie) & (tie <= self.groups.tie_high[at]),
            "horizon": below_horizon(seen, COARSE_ROUND),
            "focus": self.lens_focus.focuses[rows.lens, at],
            **dict(sight_rules(problem, seen, COARSE_ROUND)),
            **dict(focus_rules(problem, rows.camera, rows.lens, focused, COARSE_ROUND)),
            "housing": self.may_fit(rows),
            "cost": imagers.limit_cost <= limit(limits.cost) * COARSE_ROUND,
            "mass_kg": imagers.mass_kg <= limit(limits.mass_kg) * COARSE_ROUND,
            "power_w": imagers.camera_power_w <= limit(limits.power_w) * COARSE_ROUND,
            "energy_wh": imagers.camera_power_w <= problem.duration.mean_power_limit_w * COARSE_ROUND,
        }
        passes["lens_stop_down"] = self.lens_focus.closes[rows.lens]  # of any lens of a group
        return list(passes.items())

    def best_seen(self, index: int, rows: OutlineRows, seen: SceneImagers) -> Views:
        """What rules look at of these rows in one scene, at the end of their groups that passes sooner.

        Of a stereo pair that is turned inward nothing is known; its imagers are asked. Else the strip is the footprint
        less the baseline. Behind domes the error is the same all over it; behind a flat port no pixel in it is smaller
        than on the image's edge, and the rays to its middle meet at B / d at most.
        """
        assert isinstance(seen, OutlineScene)
        scene, covered_m = self.problem.scenes[index], seen.most.covered_across_m
        needs, pair = scene.view.requirements, pair_of(scene)
        common_m, error_m = np.full((len(rows), 1), np.inf), np.zeros((len(rows), 1))
        if pair is not None and pair.turn_rad <= 0.0:
            common_m = covered_m[:, :1] - pair.baseline_m
            if needs.max_depth_error_mm is not None:
                error_m[:, 0] = self.least_depth_error_m(scene, rows, pair.baseline_m)
        return replace(seen.view, covered_across_m=covered_m, common_across_m=common_m, depth_error_m=error_m)

    def least_depth_error_m(self, scene: SceneOptics, rows: OutlineRows, baseline_m: float) -> Array:
        """No image measures a distance better by a pair with parallel axes, (n,)."""
        range_m, error_m = float(scene.range_m[-1]), np.empty(len(rows))
        for mine, shape in port_shapes(self.groups.least, rows.group, scene):
            _, across, focal, pitch = self.seen(scene, rows.take(mine), shape)
            at = PAPER_PORT if scene.paper else shape
            square = np.square(range_m + at.outer_radius_m)
            if not at.is_dome:
                square = range_m**2 * scene.n_water**2 * ray_spread(np.square(across), at)[1] ** 3
            disparity_m = scene.view.requirements.disparity_error_px * pitch
            error_m[mine] = disparity_m / focal * square / baseline_m
        return error_m

    def may_fit(self, rows: OutlineRows) -> Array:
        """Whether the roomiest housing of the group is wide enough, and as long as what lies behind the pupil.

        That is what a tube behind a dome needs, the least of all: a flat port leaves room for the lens's front too, and
        a sphere's diameter is more than either; a spacer ring makes it longer.
        """
        bodies = bodies_of(self.problem.cameras.take(rows.camera), self.problem.lenses.take(rows.lens), 0.0)
        room = self.groups.least.take(rows.group)
        wide, long = tube_needed_m(bodies, is_dome=True, gap_m=0.0)
        return np.asarray((wide <= room.room_diameter_m * COARSE_ROUND) & (long <= room.room_length_m * COARSE_ROUND))


class OutlineTables(FieldTables):
    """Bounds of the light of rows of an outline."""

    def __init__(self, level: Level, rows: OutlineRows, imagers: Imagers, like: FieldTables):
        super().__init__(level.problem, imagers, like=like)
        self.level, self.outline = level, rows
        if level.pairs is not None:
            self.problem = like.problem.having(cameras=level.problem.cameras, lenses=level.problem.lenses)

    def most_sun(self, scene_index: int, rows: Array) -> Array:
        """No bound: ports of a group differ."""
        return np.full((len(rows), len(self.problem.scenes[scene_index].range_m)), np.inf)

    def rectangles(self, scene_index: int, altitude: int, rows: Array) -> Rectangles:
        """The largest rectangle for the light, the smallest for the area it is spread over."""
        scene, some = self.problem.scenes[scene_index], self.outline.take(rows)
        range_m = float(scene.range_m[altitude])
        if scene.slope:
            return Rectangles.tilted(self.level.reach(scene, some, range_m), deepest_m(self.problem, scene_index))
        along_m, across_m, area_m2, crowding = np.ones((4, len(rows)))
        for mine, least, most in self.level.ends(scene, some.group):
            both = [self.level.tangents(scene, some.take(mine), least, end) for end in (None, self.level.short)]
            low, high = (
                [edge_m(scene, shape, tangent, np.array([range_m]))[:, 0] for tangent in tangents]
                for shape, tangents in zip((least, most), both, strict=True)
            )
            along_m[mine], across_m[mine] = high
            area_m2[mine] = low[0] * low[1]
            if not least.is_dome:  # of the narrowest image, its samples as dense as in the corner of the widest
                area_m2[mine] = high[0] * high[1]
                wider = both[1][0] * both[1][1] / (both[0][0] * both[0][1])
                crowding[mine] = crowding_of(*both[1], *high, shape=least, range_m=range_m) * wider
        behind_m, share = Rectangles.paths(self.problem, scene_index, range_m)
        return Rectangles(along_m, across_m, area_m2, crowding, behind_m, share)
