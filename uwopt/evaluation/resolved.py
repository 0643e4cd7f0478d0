"""What designs resolve: frequencies at which a share of the contrast is left, of many designs at once.

Each is a root, and the roots of settings of one hardware are found together: one takes nearly as long as many.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.bars import Field
from uwopt.forward.figures import Figures, SettingRows, bars_contrast_at
from uwopt.forward.sharpness import SharpRows
from uwopt.model import sharpness
from uwopt.model.sharpness import NUMBERS, Sharpness


@dataclass(frozen=True)
class Measured:
    """A design with its settings and the figures that are columns, scene by scene."""

    model: DesignModel
    settings: list[SettingRows]
    figures: list[Figures]

    def sharp_rows(self, index: int) -> SharpRows:
        """What sharpness depends on in one scene; one and the same record for all settings at a focus."""
        return self.model.sharp_rows(index, float(self.settings[index].dioptre_per_m[0]))

    def blur(self, index: int, field: Field) -> Sharpness:
        """What blurs in one scene at a place of the image."""
        rows, figures = self.sharp_rows(index), self.figures[index]
        (group, table), *_ = rows.groups(field)
        return rows.at(
            group, table, f_number=self.settings[index].f_number, working_f_number=figures.working_f_number,
            blur_s=figures.smear_s, field=field,
        )  # fmt: skip


@dataclass(frozen=True)
class Resolved:
    """What is resolved in one scene, (1,) each: MTF50, one cycle at a tenth of contrast, and the narrowest bars."""

    at: Sharpness  # where the mission wants the image sharp
    at_corner: Sharpness
    mtf50_cyc_per_px: Array
    resolution_10_m: Array
    bars_m: Array


def resolved(designs: Sequence[Measured]) -> list[list[Resolved | None]]:
    """Of each design, scene by scene; None in physics `paper`, which knows no sharpness."""
    found: list[list[Resolved | None]] = [[None] * len(one.settings) for one in designs]
    alike: dict[int, list[tuple[int, int]]] = {}
    for n, one in enumerate(designs):
        for index, scene in enumerate(one.model.problem.scenes):
            if not scene.paper:
                alike.setdefault(id(one.sharp_rows(index)), []).append((n, index))
    for places in alike.values():
        together = _together([(designs[n], index) for n, index in places])
        for (n, index), made in zip(places, together, strict=True):
            found[n][index] = made
    return found


def _together(many: Sequence[tuple[Measured, int]]) -> list[Resolved]:
    """Of designs of one hardware at one focus in one scene."""
    (first, index), count = many[0], len(many)
    ats, corners = ([one.blur(i, field) for one, i in many] for field in ("place", "corner"))
    at, at_corner, sample_m = joined(ats), joined(corners), first.model.views[index].gsd_m[:, 1]
    contrast = [
        bars_contrast_at(one.model.rows[i], one.settings[i], one.figures[i])[:, one.model.problem.scenes[i].nominal]
        for one, i in many
    ]
    mtf50 = sharpness.mtf50_cyc_per_px(at)
    cycle_m = sharpness.resolution_10_m(at, ground_sample_m=sample_m)
    bars_m = sharpness.smallest_bars_m(
        at_corner, contrast=np.concatenate(contrast), ground_sample_m=sample_m,
        detail=first.sharp_rows(index).detail_gain_of(np.zeros(count, int), np.ones(count, int)),
    )  # fmt: skip
    return [
        Resolved(ats[n], corners[n], mtf50[n : n + 1], cycle_m[n : n + 1], bars_m[n : n + 1]) for n in range(count)
    ]


def joined(many: Sequence[Sharpness]) -> Sharpness:
    """Records (1,) that share their spread of colours as one, (n,)."""
    columns = {name: np.concatenate([np.broadcast_to(getattr(one, name), (1,)) for one in many]) for name in NUMBERS}
    return Sharpness(**columns, spread=many[0].spread)
