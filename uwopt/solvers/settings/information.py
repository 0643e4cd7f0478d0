"""Information of given settings, and the least blur of any."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.part_columns import PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.solvers.settings import closed_form, windows
from uwopt.solvers.settings.closed_form import Chosen


def least_blur_s(rows: SceneRows) -> Array:
    """Steady light that blurs no more than any settings; under the sun for as long as the shutter is open."""
    if not rows.sunlit:
        return rows.blur_s(rows.time_min_s)
    least_s = rows.min_exposure_s + rows.exposure_offset_s
    return np.where(rows.kind == PULSED, least_s, np.minimum(rows.time_min_s, least_s))


def information_of(
    rows: list[SceneRows], chosen: list[Chosen], which: Array, *, orders: tuple[int, int] | None = None
) -> Array:
    """Information [bit/m2] of settings, worst scene; nan where there are none.

    orders : nodes in radius and angle, as of `model.information`; None: as many as figures have
    """
    out = np.full(len(which), np.nan)
    index = np.nonzero(which)[0]
    if len(index) == 0:
        return out
    values = []
    for r, c in zip(rows, chosen, strict=True):
        some = closed_form.with_exposure(r, c).take(index)
        f_number, blur = c.f_number[index], some.blur_s(c.time_s[index])
        working = f_number * some.working_factor
        if some.sunlit and c.exposure_s is not None:  # the sun shines as long as the shutter is open
            from uwopt.solvers.settings.cell_windows import figures_at

            some = replace(some, dark_time_s=c.exposure_s[index])
            blur = some.open_s(c.exposure_s[index])
            sun = windows.Sun.at(some, blur / np.square(working))
            snr, _, _ = figures_at(some, c.light_x[index], c.gain[index], sun)
        else:
            snr = closed_form.nominal_snr(some, c.light_x[index])
        assert some.sharp is not None
        values.append(some.sharp.information_bit_per_m2(
            snr, f_number=f_number, working_f_number=working, blur_s=blur, orders=orders
        ))  # fmt: skip
    out[index] = np.min(values, axis=0)
    return out
