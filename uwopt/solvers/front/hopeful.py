"""Designs that a front may hold: their light is known, their settings are not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from hashlib import blake2b

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.scene_rows import SceneRows
from uwopt.solvers.settings import dark
from uwopt.solvers.settings.mean_limit import MeanLimit


@dataclass(frozen=True)
class Hopeful(Columns):
    """n designs whose light is known: rows of settings by scene, and what no setting changes."""

    lighting: Array
    imager: Array
    light: Array
    count: Array
    rows: list[SceneRows]
    motorised: Array
    camera_power_w: Array
    fixed: Array  # (n, n_axes) values of the axes, those of the settings left at 0
    power_limit_w: float
    mean_limit: MeanLimit | None = None

    def __len__(self) -> int:
        return len(self.imager)

    def of_scene(self, index: int) -> Hopeful:
        """The same in one scene alone, which may have more than all scenes together."""
        return self if len(self.rows) == 1 else replace(self, rows=[self.rows[index]], mean_limit=None)

    def what_decides(self) -> list[bytes]:
        """A digest of all that decides each design's curve of quality against power: like ones have like curves."""
        columns: list[Array] = []

        def gathered(column: Array) -> Array:
            columns.append(column.reshape(len(self), -1).astype(float))
            return column

        for column in (self.camera_power_w, self.motorised):
            gathered(column)
        for r in self.rows:
            if r.sharp is not None:  # tables of colour by what they are, not by their place in a list
                marks = [hash((t.magnitude.tobytes(), t.step, t.index_rms)) for t in r.sharp.spreads] or [0]
                place = np.minimum(r.sharp.spread_index, len(marks) - 1)
                r = replace(r, sharp=replace(r.sharp, spread_index=np.array(marks, float)[place]))
            r.with_arrays(gathered)
        return [blake2b(row, digest_size=16).digest() for row in np.ascontiguousarray(np.concatenate(columns, axis=1))]

    @property
    def sunlit(self) -> bool:
        """Whether settings have no closed form for the sun."""
        return any(r.sunlit for r in self.rows)

    @property
    def full_power_w(self) -> Array:
        """Power with the lights at full level for the longest time, cameras included; the worst scene's."""
        drawn = []
        for r in self.rows:
            share = r.on_share(r.time_max_s)
            lamps_w = r.full_draw_w * np.minimum(r.max_level, 1.0) * np.maximum(share, 0.0) + r.idle
            drawn.append(lamps_w + r.exposing_w(r.longest_exposure_s))
        return np.minimum(self.camera_power_w + np.max(drawn, axis=0), self.power_limit_w)

    @property
    def stepped(self) -> Array:
        """Whether only the steps of the lights change the power, in every scene."""
        return np.asarray(np.logical_and.reduce([~r.dims_freely & ~r.timed for r in self.rows]))


def unhindered(rows: list[SceneRows]) -> list[SceneRows]:
    """Rows with least dark current and no wanted sharpness, which have a closed form: no settings do better."""
    return [replace(dark.relaxed(r), min_mtf=0.0, resolve_m=0.0) for r in rows]
