"""Groups of cameras and groups of lenses, each as one part that none of its members beats in anything.

So pairs of a very large catalogue are bounded together, as ports are behind which they stand. Cameras of a group share
their pixels and curve; lenses of a group have two ends, the longest and the shortest of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.part_columns import Lenses
from uwopt.forward.problem import Problem
from uwopt.forward.views import pair_of
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.imagers import FittingPairs

SIZES = (16, 4)  # cameras, and lenses, that a group holds at most, level by level
ALIKE = (  # cameras of a group agree in these
    "resolution_x_px", "resolution_y_px", "pixel_pitch_m", "bits", "black_level_dn", "qe_index", "fires_lamps",
)  # fmt: skip
LEAST_OF_CAMERAS = (
    "read_noise_e", "prnu_frac", "min_exposure_s", "readout_s", "frame_mb", "price", "limit_price", "mass_kg",
    "power_w", "standby_w", "awake_s", "body_width_m", "body_height_m", "body_length_m", "plug_m", "most_body_m",
)  # fmt: skip
MOST_OF_CAMERAS = (
    "saturation_e", "gain_dn_per_e", "max_gain", "max_exposure_s", "exposure_offset_s", "dark_current_e_s",
    "max_rate_hz", "qe_scale", "storage_gb", "disk_gb",
)  # fmt: skip
LEAST_OF_LENSES = (
    "f_number_min", "min_object_distance_m", "rated_pitch_m", "length_m", "diameter_m", "most_body_m", "price",
    "limit_price", "mass_kg",
)  # fmt: skip
MOST_OF_LENSES = ("focal_length_m", "f_number_max", "transmission", "pupil_m", "pupil_ends_m")


@dataclass(frozen=True)
class PairGroups:
    """Cameras and lenses at one level of the tree, in groups: places `start` to the next in `order`, of either."""

    camera_order: Array
    camera_start: Array
    lens_order: Array
    lens_start: Array
    count: Array  # (n_camera_groups, n_lens_groups) pairs that fit
    fits: Array  # (n_cameras, n_lenses)
    problem: Problem  # of which each camera and lens stands for a group, the lens with the longest focal length
    short: Lenses  # the same with the shortest

    @staticmethod
    def levels(problem: Problem, pairs: FittingPairs, objective: Objective) -> list[PairGroups]:
        """All cameras that see alike with single lenses; then ever smaller groups of either, of lenses with nearly one
        focal length, where bounds know how to take several at once."""
        cameras, lenses, (of_camera, of_lens, _) = problem.cameras, problem.lenses, problem.ties
        asks_both_ways = bool(objective.weight("snr_db") or objective.weight("information"))
        alike = (*ALIKE, "gain_dn_per_e") if asks_both_ways else ALIKE
        camera_order, camera_starts = grouped([getattr(cameras, name) for name in alike] + [of_camera], cameras.power_w)
        lens_order, lens_starts = grouped([of_lens], lenses.focal_length_m)
        single = np.arange(len(lens_order))
        lens_starts = [single, *(lens_starts[1:] if have_two_ends(problem) else [single] * len(SIZES))]
        fits = np.zeros((len(camera_order), len(lens_order)), bool)
        fits[pairs.camera, pairs.lens] = True
        orders = camera_order, lens_order
        return [PairGroups.of(problem, fits, orders, both) for both in zip(camera_starts, lens_starts, strict=True)]

    @staticmethod
    def of(problem: Problem, fits: Array, orders: tuple[Array, Array], starts: tuple[Array, Array]) -> PairGroups:
        """The groups of cameras, and of lenses, that begin at these places of their orders."""
        cameras, lenses, own = problem.cameras, problem.lenses, problem.ties
        (camera_order, lens_order), (camera_start, lens_start) = orders, starts
        count = np.add.reduceat(fits[camera_order].astype(np.int32), camera_start, axis=0)[:, lens_order]
        stands_for = problem.having(
            cameras=at_best(cameras, camera_order, camera_start, LEAST_OF_CAMERAS, MOST_OF_CAMERAS),
            lenses=at_best(lenses, lens_order, lens_start, LEAST_OF_LENSES, MOST_OF_LENSES),
            ties=(own[0][camera_order[camera_start]], own[1][lens_order[lens_start]], own[2]),
        )
        shortest_m = np.minimum.reduceat(lenses.focal_length_m[lens_order], lens_start)
        return PairGroups(
            camera_order, camera_start, lens_order, lens_start, np.add.reduceat(count, lens_start, axis=1), fits,
            stands_for, replace(stands_for.lenses, focal_length_m=shortest_m),
        )  # fmt: skip

    def parted(self, camera: Array, lens: Array, finer: PairGroups | None = None) -> tuple[Array, Array, Array]:
        """What some pairs of groups hold that fits: single pairs, or pairs of finer groups. Of each its row, camera
        and lens."""
        cameras, lenses = (None, None) if finer is None else (finer.camera_start, finer.lens_start)
        row, at_camera = every_between(*self._places(self.camera_start, self.camera_order, cameras, camera))
        again, at_lens = every_between(*self._places(self.lens_start, self.lens_order, lenses, lens[row]))
        row, at_camera = row[again], at_camera[again]
        if finer is None:
            one, other = self.camera_order[at_camera], self.lens_order[at_lens]
            fit = self.fits[one, other]
        else:
            one, other = at_camera, at_lens
            fit = finer.count[one, other] > 0
        return row[fit], one[fit], other[fit]

    @staticmethod
    def _places(start: Array, order: Array, finer: Array | None, groups: Array) -> tuple[Array, Array]:
        """The first part of each group, or the first finer group, and that after its last."""
        ends = np.append(start, len(order))
        if finer is not None:
            ends = np.searchsorted(finer, ends)
        return ends[groups], ends[groups + 1]

    def one_of(self, camera: int, lens: int) -> tuple[int, int]:
        """The first pair that fits in a pair of groups."""
        _, one, other = self.parted(np.array([camera]), np.array([lens]))
        return int(one[0]), int(other[0])


def have_two_ends(problem: Problem) -> bool:
    """Whether bounds of views know how to take lenses of several focal lengths at once."""
    return not any(scene.slope or pair_of(scene) is not None for scene in problem.scenes)


def grouped(keys: list[Array], by: Array) -> tuple[Array, list[Array]]:
    """An order of parts, and where groups begin, level by level: alike in all keys, then neighbours in a column."""
    order = np.lexsort([by, *keys])
    fresh = np.any([np.diff(key[order]) != 0 for key in keys], axis=0)
    begin = np.append(0, np.flatnonzero(fresh) + 1)
    starts = [begin]
    for size in SIZES:
        ends = [*begin.tolist(), len(order)]
        begin = np.array([place for a, b in pairwise(ends) for place in range(a, b, size)], int)
        starts.append(begin)
    return order.astype(np.int32), starts


def at_best(columns: Any, order: Array, start: Array, least: tuple[str, ...], most: tuple[str, ...]) -> Any:
    """One part a group: of some columns the least, of others the most, of the rest its first part's."""
    changes = {name: np.minimum.reduceat(getattr(columns, name)[order], start) for name in least}
    changes |= {name: np.maximum.reduceat(getattr(columns, name)[order], start) for name in most}
    return replace(columns.take(order[start]), **changes)


def every_between(first: Array, end: Array) -> tuple[Array, Array]:
    """All whole numbers from each first to before each end, with the place of the pair that they come from."""
    counts = end - first
    row = np.repeat(np.arange(len(first)), counts)
    return row, np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts) + first[row]
