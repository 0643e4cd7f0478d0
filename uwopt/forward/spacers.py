"""Spacer rings behind lenses: which one a focus needs, and between which distances a lens focuses on it.

One rule for search, bounds, evaluation and audit: the least ring of those that may stand behind a lens, none where it
focuses without. A focus that no ring reaches has the length nan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.compatibility import canonical_mount
from uwopt.catalog.estimates import required_class
from uwopt.catalog.readers.read_lens import focal_class
from uwopt.catalog.records import Lens
from uwopt.catalog.spacers import stacks_of_mounts_mm
from uwopt.forward.once import once_each
from uwopt.forward.part_columns import Lenses
from uwopt.model.extension import extended_distance_m, extension_m, focus_range_m
from uwopt.tolerances import ROUND


@once_each
def lens_with_spacers(lens: Lens) -> Lens:
    """A lens with the rings that may stand behind it and what it bears, that of its class where it does not say."""
    spacers_mm = stacks_of_mounts_mm(lens.mounts) if lens.spacers_mm is None else lens.spacers_mm
    board = {canonical_mount(mount) for mount in lens.mounts} == {"S"}
    travel = required_class("lens-thread-travel-mm", "spacer-s-mount").quantity() if board else None
    bears = required_class("lens-max-magnification", f"spacer-{focal_class(lens.focal_length_mm)}").quantity()
    extended = bool(spacers_mm) or board or lens.thread_travel_mm is not None
    return replace(
        lens,
        spacers_mm=spacers_mm,
        thread_travel_mm=lens.thread_travel_mm or travel,
        max_magnification=lens.max_magnification or (bears if extended else None),
    )


@once_each
def without_spacers(lens: Lens) -> Lens:
    """A lens that stands on its camera as it is made."""
    if lens.spacers_mm is None and lens.thread_travel_mm is None and lens.max_magnification is None:
        return lens
    return replace(lens, spacers_mm=(), thread_travel_mm=None, max_magnification=None)


def ring_range_m(lenses: Lenses, spacer_m: Array | float) -> tuple[Array, Array]:
    """Nearest and farthest distance in air at which lenses focus on rings of this length."""
    return focus_range_m(
        lenses.focal_length_m, nearest_m=lenses.min_object_distance_m, spacer_m=spacer_m,
        thread_m=lenses.thread_travel_m, max_magnification=lenses.max_magnification,
    )  # fmt: skip


def needed_spacer_m(
    lenses: Lenses, dioptre_per_m: Array, *, slack: float = ROUND, rows: Array | None = None
) -> Array:
    """The least ring on which each lens focuses at a dioptre, (n,) [m]: 0 without one, nan where none does.

    rows : which of the lenses each dioptre is of, (n,); without them one dioptre a lens, or one for all
    """
    with np.errstate(divide="ignore"):
        distance = 1.0 / np.asarray(dioptre_per_m, float)
    distance, of = np.broadcast_arrays(distance, np.arange(len(lenses.focal_length_m)) if rows is None else rows)
    needed = np.full(distance.shape, np.nan)
    left = np.flatnonzero(distance > lenses.focal_length_m[of])  # those without a ring yet
    for length in [np.zeros(len(lenses.focal_length_m)), *lenses.spacers_m.T]:
        (near, far), lens, at = ring_range_m(lenses, length), of[left], distance[left]
        reached = (at * slack >= near[lens]) & (at <= far[lens] * slack)
        needed[left[reached]] = length[lens[reached]]
        left = left[~reached]
        if len(left) == 0:
            break
    return needed


def ring_behind_m(lenses: Lenses, dioptres_per_m: Sequence[Array]) -> Array:
    """The ring that serves one focus in all scenes, (n,) [m]: 0 where none is needed or none helps."""
    needed = np.max([needed_spacer_m(lenses, dioptre) for dioptre in dioptres_per_m], axis=0)
    return np.nan_to_num(needed)


def scale_distance_m(lenses: Lenses, dioptre_per_m: Array, spacer_m: Array | float) -> Array:
    """Distance in air to set on the lens's own scale when it stands on a ring; inf at its far end."""
    with np.errstate(divide="ignore"):
        distance = 1.0 / np.asarray(dioptre_per_m, float)
    x = extension_m(distance, focal_length_m=lenses.focal_length_m) - spacer_m
    return np.asarray(extended_distance_m(np.maximum(x, 0.0), focal_length_m=lenses.focal_length_m))
