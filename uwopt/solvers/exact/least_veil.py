"""Lower bounds of the forward veil over the light that forms the image, before any field is integrated.

What comes near its straight way holds at every pixel: the same place on the floor sends both. What comes from elsewhere
on the floor is bounded in the mean of the image alone, by what the image's own floor sends into it
(`veil.wide.least_within`): however a lamp lights it, no light in the image is without this veil.

Where rows stand for groups, the images between two ends are meant: of one sensor behind lenses of ever wider angle, so
that both sides grow by one factor, behind whichever of the ports. A larger image holds the smaller, in water too: none
between the two gets less than the smaller one's floor sends to the worst place of the larger. The way from end to end
goes in steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import distinct, groups_alike
from uwopt.forward.problem import Problem
from uwopt.forward.views import Views
from uwopt.model import port
from uwopt.model.veil.wide import POWERS, least_within
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import Lighting
from uwopt.tolerances import ROUND

SIDE_STEP, ASIDE_STEP = 0.02, 0.02  # of a side's logarithm, and of the share by which places lie aside
STEPS = 4  # from the smallest to the largest image that a row stands for
WORTH = 0.1  # of the light near its way: less from elsewhere, a third of it the image's own, is not worth its bound


class LeastVeil:
    """Bounds of the veil of some imagers."""

    def __init__(self, problem: Problem, imagers: Imagers):
        self.problem, self.imagers = problem, imagers
        self._within: dict[int, Array] = {}

    def least(self, scene_index: int, lightings: Sequence[Lighting], rows: Array, altitude: int) -> Array:
        """Least veil over signal of imagers under any of some lightings at one altitude, (n,).

        Where an SNR is asked of pixels, near their straight ways alone: the veil from elsewhere may be less there.
        """
        problem = self.problem
        contraction = problem.contractions[scene_index]
        curves, back = distinct(problem.cameras.qe_index[self.imagers.camera[rows]])
        spectra = {int(contraction.spectrum_of[lighting.optics]) for lighting in lightings}
        ways_m = problem.nearest_m(scene_index, altitude), self._lowest_m(scene_index, altitude)
        veil = np.zeros(len(rows))
        for k, curve in enumerate(curves):
            each = [contraction.least_veil(s, int(curve), altitude, *ways_m) for s in spectra]
            mine = back == k
            veil[mine] = min((near for near, _ in each), default=0.0)
            if self.counts_elsewhere(scene_index) and any(wide.sum() > WORTH * (1.0 + near) for near, wide in each):
                within = self.within(scene_index)[rows[mine]]
                veil[mine] = np.min([near + within @ wide for near, wide in each], axis=0)
        return veil

    def _lowest_m(self, scene_index: int, altitude: int) -> float:
        """No lamp stands lower over the floor than this at one altitude."""
        rise_m = np.diff(self.problem.scenes[scene_index].altitude_m[[0, altitude]])
        return self.problem.lowest_m(scene_index) + float(rise_m[0])

    def counts_elsewhere(self, scene_index: int) -> bool:
        """Whether what comes from elsewhere is bounded: of means, over a level floor."""
        scene = self.problem.scenes[scene_index]
        return self.problem.contractions[scene_index].multiple and scene.pixels is None and not scene.slope

    def within(self, scene_index: int) -> Array:
        """What each imager's floor sends into its image at least, by kernel (n, 4)."""
        if scene_index not in self._within:
            ends = self.imagers.scenes[scene_index].ends
            smallest, largest = ends[0], ends[-1]
            aside, farther_m = self._aside(scene_index, largest)
            lost = float(self.problem.contractions[scene_index].near_leg_per_m().max()) * farther_m
            kept = self._passed(scene_index, largest) * np.exp(-lost)
            self._within[scene_index] = self._sent(scene_index, smallest, largest, aside) * kept[:, None]
        return self._within[scene_index]

    def _sent(self, scene_index: int, smallest: Views, largest: Views, aside: Array) -> Array:
        """`least_within` of the images between two ends.

        Sides are rounded outward to one series of lengths, so that images nearly alike share what is worked out.
        """
        grows = np.maximum(largest.tan_along / smallest.tan_along, largest.tan_across / smallest.tan_across)
        sides = np.log(np.sort([smallest.tan_along, smallest.tan_across], axis=0)) / SIDE_STEP
        longer = np.log(np.maximum(grows, 1.0)) / SIDE_STEP
        beside = np.ceil(aside / ASIDE_STEP)
        n_steps = STEPS if (grows > ROUND).any() else 1
        sent = []
        for step in range(n_steps):
            low, high = (sides + longer * share / n_steps for share in (step, step + 1))
            columns = *np.floor(low), *(np.floor(high) + 1.0), beside, self._is_dome.astype(float)
            first, back = groups_alike(*columns)
            sent.append(self._known(scene_index, np.stack([column[first] for column in columns], axis=1))[back])
        return np.asarray(np.min(sent, axis=0))

    def _known(self, scene_index: int, rows: Array) -> Array:
        """`least_within` by steps of the smallest sides and the largest ones, steps aside, and whether a dome; kept."""
        scene, keys = self.problem.scenes[scene_index], [("within", *row) for row in rows.tolist()]
        fresh = [place for place, key in enumerate(keys) if key not in scene.cache]
        if fresh:
            along, across, most_along, most_across = np.exp(SIDE_STEP * rows[fresh, :4].T)
            found = least_within(
                along, across, index=np.where(rows[fresh, 5] > 0.0, 1.0, scene.n_water), most_along=most_along,
                most_across=most_across, aside=ASIDE_STEP * rows[fresh, 4],
            )  # fmt: skip
            scene.cache.update(zip((keys[place] for place in fresh), found, strict=True))
        return np.array([scene.cache[key] for key in keys]).reshape(-1, len(POWERS))

    def _aside(self, scene_index: int, view: Views) -> tuple[Array, Array]:
        """By how much farther aside than a ray from the middle of its window an image's corner falls, at most, and how
        much longer the way to there from the middle is [m].

        Aside of its middle a ray leaves a window by e tan a + t tan g: over tan w that grows no more than tan a does.
        """
        scene = self.problem.scenes[scene_index]
        nearest_m, n_water = float(scene.range_m[0]), scene.n_water
        corner = np.hypot(view.tan_along, view.tan_across)
        at_corner, most = port.bend(np.square(corner), n=n_water), np.zeros(len(corner))
        for tangent, wide_m in ((view.tan_along, view.footprint_along_m), (view.tan_across, view.footprint_across_m)):
            at_edge = port.bend(np.square(tangent), n=n_water)
            straight_m = nearest_m * tangent / at_edge
            most = np.maximum(most, (0.5 * wide_m[:, 0] / straight_m - 1.0) * at_corner / at_edge)
        most = np.where(self._is_dome, 0.0, most)
        beside_m = most * nearest_m * corner / at_corner
        far_m = 0.5 * np.hypot(view.footprint_along_m[:, -1], view.footprint_across_m[:, -1])
        return most, beside_m * far_m / np.hypot(far_m, nearest_m)

    def _passed(self, scene_index: int, view: Views) -> Array:
        """What a flat window passes in the image's corner over what it passes on the axis."""
        problem, n_water = self.problem, self.problem.scenes[scene_index].n_water
        if not problem.effects.window_angle or self._is_dome.all():
            return np.ones(len(self._is_dome))
        tangent, glass = np.hypot(view.tan_along, view.tan_across), problem.ports.refractive_index
        each = [
            port.flat_port_transmittance(tangent, n_water=n_water, n_glass=n)
            / port.normal_port_transmittance(n_water=n_water, n_glass=n)
            for n in (float(glass.min()), float(glass.max()))
        ]
        return np.where(self._is_dome, 1.0, np.min(each, axis=0))

    @cached_property
    def _is_dome(self) -> Array:
        return np.asarray(self.problem.ports.is_dome[self.imagers.port])
