"""Bars of which a share of the contrast is asked for, and how much of it some f-number leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.model.lateral import spread_mtf
from uwopt.model.sharpness import NYQUIST_CYC_PER_PX, Sharpness, round_mtf, sinc_mtf

if TYPE_CHECKING:
    from uwopt.forward.sharpness import SharpRows

Field = Literal["place", "corner", "rms"]
MAY_SHOW = 1.0 - 1e-8  # of a contrast that is asked for, below what any judge takes for met
NYQUIST_ROUND = 1e-9  # of a frequency: bars as wide as a pixel are just allowed


@dataclass(frozen=True)
class Bars(Columns):
    """Bars of which a share of the contrast must be left, at near, nominal and far altitude: one mechanism for all."""

    frequency_cyc_per_px: Array  # (n, 3), along and across alike
    field: Field
    least: float
    veiled: bool = False  # of all light; else of the light that forms the image. Coarser bars must be left then, too
    detail: Array | float = 1.0  # (n, 3) what light scattered nearly forward adds to it, as a factor

    def still(self, transfer: Any, frequency: Array) -> Array:
        """A transfer by frequency, where the pixels can show such bars: two a cycle are needed of veiled ones."""
        aliased = self.veiled & (frequency > NYQUIST_CYC_PER_PX * (1.0 + NYQUIST_ROUND))
        return np.where(aliased, 0.0, transfer)

    def detail_at(self, rows: Array, altitude: int | slice = slice(None)) -> Array | float:
        """The factor at some rows."""
        return self.detail[rows, altitude] if isinstance(self.detail, np.ndarray) else self.detail


@dataclass(frozen=True)
class StillBars:
    """Bars of n designs with those factors of their transfer that no setting changes, (n, 3) each."""

    bars: Bars
    sharp: SharpRows
    along: Array
    across: Array

    @staticmethod
    def of(bars: Bars, sharp: SharpRows) -> StillBars:
        """Pixel and lateral colour of bars, and what light scattered nearly forward adds."""
        nu = bars.frequency_cyc_per_px
        still = bars.still(sinc_mtf(nu), nu) * bars.detail
        found = [np.array(still), np.array(still)]
        for mine, spread in sharp.groups(bars.field):
            if spread is not None:
                for one, k in zip(found, sharp.colour(bars.field), strict=True):
                    one[mine] *= spread_mtf(k[mine, None] * nu[mine], table=spread, falling=bars.veiled)
        return StillBars(bars, sharp, *found)

    def best_between(self, rows: Array, low: Array, high: Array, *, working_factor: Array) -> tuple[Array, Array]:
        """Most that f-numbers between two leave of some rows' bars while nothing moves, along and across, (m, 3).

        Diffraction grows with the f-number, defocus and the lens's own blur fall with it: each is taken at the end
        where it is least.
        """
        sharp, field = self.sharp, self.bars.field
        at_best = Sharpness(
            working_f_number=(low * working_factor)[:, None], wavelength_nm=sharp.wavelength_nm[rows, None],
            pixel_pitch_m=sharp.pixel_pitch_m[rows, None], defocus_px=sharp.disc_px(field)[rows] / high[:, None],
            lens_pitch_px=sharp.lens_pitch_px(field, f_number=high, rows=rows)[:, None],
        )  # fmt: skip
        left = round_mtf(self.bars.frequency_cyc_per_px[rows], sharpness=at_best)
        return self.along[rows] * left, self.across[rows] * left
