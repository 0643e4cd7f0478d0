"""Where lenses focus: dioptres of the wanted depth, depth of field, working f-number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.scene import SceneOptics
from uwopt.forward.views import Views, field_dioptres_per_m
from uwopt.model import lens, port


@dataclass(frozen=True)
class Focus:
    """Common focus of an imager over its scenes, and by scene the f-number that keeps what it wants sharp."""

    dioptre_per_m: list[Array]  # by scene, at the lens
    n_depth: list[Array]  # by scene, smallest f-number; 0 where any will do


def place_focus(scenes: Sequence[SceneOptics], maps: Sequence[port.FocusMap], seen: Sequence[Views]) -> Focus:
    """Put the focus where what must be sharp needs the smallest f-number.

    One focus serves all scenes, because behind a sealed port it cannot be touched.
    """
    dioptre = common_dioptre(scenes, maps, seen)
    n_depth = [
        depth_f_number(scene, at, view, dioptre) for scene, at, view in zip(scenes, maps, seen, strict=True)
    ]
    return Focus([dioptre] * len(scenes), n_depth)


def common_dioptre(scenes: Sequence[SceneOptics], maps: Sequence[port.FocusMap], seen: Sequence[Views]) -> Array:
    """The focus that serves all scenes, (n,) [1/m] at the lens.

    Where no depth of field is asked for, the nominal altitude must be sharp: an image is wanted, and of one that
    must be sharp in its corners too neither they nor the centre are in focus. Physics `paper` focuses at the
    altitude of its one scene.
    """
    count = len(seen[0].tan_along)
    if is_at_nominal(scenes):
        at_altitude = port.lens_dioptre_per_m(scenes[0].range_m[scenes[0].nominal], focus_map=maps[0])
        return np.broadcast_to(at_altitude, count)
    return middle_focus(sharp_intervals(scenes, maps, seen), [view.coc_m for view in seen])


def is_at_nominal(scenes: Sequence[SceneOptics]) -> bool:
    """Whether the nominal altitude alone must be sharp, so that the focus lies there."""
    needs = scenes[0].view.requirements
    return len(scenes) == 1 and (scenes[0].paper or (needs.min_dof_m is None and not held_at_corner(scenes[0])))


def default_dioptres_per_m(
    scenes: Sequence[SceneOptics], maps: Sequence[port.FocusMap], seen: Sequence[Views]
) -> list[Array]:
    """Where the focus of a system lies that does not say: at the nominal altitude, of several scenes as searched."""
    if len(scenes) > 1:
        return list(place_focus(scenes, maps, seen).dioptre_per_m)
    at_nominal = port.lens_dioptre_per_m(scenes[0].range_m[scenes[0].nominal], focus_map=maps[0])
    return [np.full(len(seen[0].tan_along), float(at_nominal))]


def middle_focus(intervals: Sequence[tuple[Array, Array]], coc_m: Sequence[Array]) -> Array:
    """The focus that covers all intervals of dioptres (near, far) with the smallest common f-number.

        N = (f^2 / c) max(D_n - D, D - D_f) / (1 - f D) of each; near ends ask for less as D grows, far ends for more

    They meet at the pair of a near and a far end that asks for most, (D_n - D_f) / (c_n + c_f): in the dioptric
    middle where all circles of confusion c are the same.
    """
    best, most = np.zeros_like(coc_m[0]), np.full_like(coc_m[0], -np.inf)
    for (near, _), coc_near in zip(intervals, coc_m, strict=True):
        for (_, far), coc_far in zip(intervals, coc_m, strict=True):
            share = coc_near / (coc_near + coc_far)
            asked = (near - far) / (coc_near + coc_far)
            focus = near - share * (near - far)
            best, most = np.where(asked > most, focus, best), np.maximum(asked, most)
    return best


def held_at_corner(scene: SceneOptics) -> bool:
    """Whether what must be sharp must be so in the corners too: a depth of field, or the nominal altitude."""
    return scene.view.requirements.dof_at == "corner" and not scene.paper


def sharp_ends_m(scene: SceneOptics, start_m: Array | float = np.inf) -> tuple[Array, Array]:
    """Nearest and farthest distance that must be sharp: the nominal altitude, or the depth of field asked for.

    `start_m`: where a depth of field begins that other scenes need nearer than this one. One of each, or of each row.
    """
    depth = scene.view.requirements.min_dof_m
    if depth is None:
        nominal = scene.range_m[scene.nominal]
        return nominal, nominal
    near, far = scene.range_m[0], scene.range_m[-1]
    return near, np.maximum(far, np.minimum(near, start_m) + depth)


def corner_dioptres_per_m(view: Views, ends_m: tuple[Array, Array]) -> Array:
    """Dioptres of both images of the corners at two distances, of all or of each row, (n, 2, 2)."""
    places, ends = view.corner_image, np.stack(ends_m, axis=-1)
    if ends.ndim == 1:
        return field_dioptres_per_m(places, ends)
    return np.asarray(places[..., :1] + places[..., 1:2] / (ends[:, None, :] + places[..., 2:3]))


def sharp_intervals(
    scenes: Sequence[SceneOptics], maps: Sequence[port.FocusMap], seen: Sequence[Views]
) -> list[tuple[Array, Array]]:
    """Dioptres at the lens of the nearest and the farthest distance that must be sharp, by scene."""
    count = len(seen[0].tan_along)
    nearest = reduce(np.maximum, (
        port.lens_dioptre_per_m(sharp_ends_m(scene)[0], focus_map=at) for scene, at in zip(scenes, maps, strict=True)
    ))  # fmt: skip
    found = []
    for scene, at, view in zip(scenes, maps, seen, strict=True):
        ends_m = sharp_ends_m(scene, port.water_distance_m(nearest, focus_map=at))
        near, far = (np.broadcast_to(port.lens_dioptre_per_m(end, focus_map=at), count) for end in ends_m)
        if held_at_corner(scene):
            ends = corner_dioptres_per_m(view, sharp_ends_m(scene))
            near, far = np.maximum(near, ends.max(axis=(1, 2))), np.minimum(far, ends.min(axis=(1, 2)))
        found.append((near, far))
    return found


def depth_f_number(scene: SceneOptics, at: port.FocusMap, view: Views, dioptre_per_m: Array) -> Array:
    """The smallest f-number that keeps sharp what one scene wants sharp, at a given focus."""
    near_m, far_m = sharp_ends_m(scene)
    common = dict(focal_length_m=view.focal_length_m, circle_of_confusion_m=view.coc_m)
    if held_at_corner(scene):
        ends = corner_dioptres_per_m(view, (near_m, far_m))
        axis = [port.lens_dioptre_per_m(end, focus_map=at) for end in (near_m, far_m)]
        return np.asarray(
            lens.f_number_to_reach(
                np.maximum(axis[0], ends.max(axis=(1, 2))),
                far_dioptre_per_m=np.minimum(axis[1], ends.min(axis=(1, 2))),
                focus_dioptre_per_m=dioptre_per_m,
                **common,
            )
        )
    depth = scene.view.requirements.min_dof_m
    return np.asarray(
        lens.f_number_for_interval(
            dioptre_per_m,
            near_m=near_m,
            far_m=near_m if depth is None else scene.range_m[-1],
            min_dof_m=depth or 0.0,
            focus_map=at,
            **common,
        )
    )


def working_factor(scene: SceneOptics, focal_length_m: Array, dioptre_per_m: Array) -> Array:
    """N_w / N = 1 + m at the focus; 1 in physics `paper`."""
    if scene.paper:
        return np.ones(len(focal_length_m))
    return np.asarray(
        lens.working_f_number(1.0, focal_length_m=focal_length_m, object_distance_m=1.0 / dioptre_per_m)
    )


@dataclass(frozen=True)
class Focused(Columns):
    """What an imager brings to one scene beside its view: focus, f-numbers, rate and longest times."""

    dioptre_per_m: Array
    working_factor: Array
    n_low: Array
    n_high: Array
    rate_hz: Array
    blur_time_s: Array
    skew_px: Array  # of a rolling shutter under lamps that burn; 0 for a global one
    spacer_m: Array  # of the ring that the focus needs behind the lens; nan where none reaches it
    beside_w: Array  # what its cameras draw here beyond the scene where they draw least
