"""What cameras with lenses see behind a port: views, their common focus, and the rings that it needs.

What is the same of like sensors behind lenses of one focal length is worked out once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.breathing import at_focus
from uwopt.forward.columns import distinct, rows_alike
from uwopt.forward.focus import common_dioptre
from uwopt.forward.problem import Problem
from uwopt.forward.spacers import needed_spacer_m
from uwopt.forward.views import Views, collecting_m2, focus_map, views
from uwopt.model.imaging import PortShape
from uwopt.model.port import lens_dioptre_per_m


@dataclass(frozen=True)
class SeenOfKinds:
    """What kinds of pairs see of every scene behind a port, but for how much light; and of which kind each pair is."""

    views: list[Views]
    dioptre_per_m: Array  # their common focus, by kind
    of: Array  # (n,)

    def of_pairs(self, problem: Problem, camera: Array, lens: Array, port: int, pairs: Array) -> list[Views]:
        """What some of the pairs see, with their light; camera, lens : of these."""
        cameras, lenses, of = problem.cameras.take(camera), problem.lenses.take(lens), self.of[pairs]
        return [
            replace(view.take(of), collecting_m2=collecting_m2(scene, cameras, lenses, problem.shape(port, index)))
            for index, (scene, view) in enumerate(zip(problem.scenes, self.views, strict=True))
        ]

    def spacers_m(self, problem: Problem, lens: Array) -> Array:
        """The ring that the focus of each pair needs behind its lens, (n,) [m]; nan where none does."""
        foci, focus_of = np.unique(self.dioptre_per_m, return_inverse=True)
        alike, back = distinct(lens * len(foci) + focus_of[self.of])
        few = needed_spacer_m(problem.lenses, foci[alike % len(foci)], rows=alike // len(foci))
        return np.asarray(few[back])


def kinds_behind(problem: Problem, camera: Array, lens: Array, port: int, landscape: bool) -> SeenOfKinds:
    """What these pairs see behind a port, by kind."""
    shapes = [problem.shape(port, index) for index in range(len(problem.scenes))]
    if callable(problem.meant_m) or any(scene.range_m.ndim > 1 for scene in problem.scenes):  # each pair its own
        of = np.arange(len(camera))
    else:
        camera, lens, of = pairs_alike(problem, camera, lens)
    views_of_kinds, dioptre = seen_in_focus(problem, camera, lens, shapes, landscape)
    return SeenOfKinds(views_of_kinds, dioptre, of)


def seen_behind(
    problem: Problem, camera: Array, lens: Array, port: int, landscape: bool
) -> tuple[list[Views], Array, Array]:
    """What these pairs see of every scene behind a port, their common focus [1/m] and the rings that it needs [m]."""
    kinds = kinds_behind(problem, camera, lens, port, landscape)
    seen = kinds.of_pairs(problem, camera, lens, port, np.arange(len(camera)))
    return seen, kinds.dioptre_per_m[kinds.of], kinds.spacers_m(problem, lens)


def pairs_alike(problem: Problem, camera: Array, lens: Array) -> tuple[Array, Array, Array]:
    """One camera and lens of each kind that sees alike but for how much light, and of which kind each pair is.

    Some hundred kinds of many thousand pairs: like sensors behind lenses of one focal length.
    """
    cameras = problem.cameras
    one_camera, of_camera = rows_alike(cameras.resolution_x_px, cameras.resolution_y_px, cameras.pixel_pitch_m)
    one_lens, of_lens = rows_alike(problem.lenses.focal_length_m)
    kinds, of = distinct(of_camera[camera] * len(one_lens) + of_lens[lens])
    return one_camera[kinds // len(one_lens)], one_lens[kinds % len(one_lens)], of


def seen_in_focus(
    problem: Problem, camera: Array, lens: Array, shapes: Sequence[PortShape], landscape: bool
) -> tuple[list[Views], Array]:
    """What these pairs see of every scene behind a port, and their common focus [1/m]."""
    cameras, lenses, scenes = problem.cameras.take(camera), problem.lenses.take(lens), problem.scenes_of(camera)
    seen = [
        views(scene, cameras, lenses, shape, landscape=landscape) for scene, shape in zip(scenes, shapes, strict=True)
    ]
    maps = [focus_map(scene, shape) for scene, shape in zip(scenes, shapes, strict=True)]
    meant_m = problem.meant_m
    if meant_m is None:
        dioptre = common_dioptre(scenes, maps, seen)
    else:
        distance_m = meant_m(camera, lens) if callable(meant_m) else np.full(len(camera), meant_m)
        dioptre = np.asarray(lens_dioptre_per_m(distance_m, focus_map=maps[0]))
    return [
        at_focus(scene, shape, view, cameras.pixel_pitch_m, dioptre)
        for scene, shape, view in zip(scenes, shapes, seen, strict=True)
    ], dioptre
