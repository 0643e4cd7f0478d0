"""Pixels of an image that may decide its SNR at some exposure: few, where there were hundreds.

Dark current asks for more light the longer the exposure, of every pixel a little. Which pixel is the (k + 1)-th most
demanding, so that all but k reach the SNR, is then settled between a few of them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.light_columns import ImageLight
from uwopt.forward.scene_rows import SceneRows
from uwopt.model.image_mean import needed_by_most
from uwopt.solvers.settings import windows
from uwopt.tolerances import SLACK

Lit = TypeVar("Lit", SceneRows, ImageLight)


def deciding_pixels(rows: SceneRows) -> SceneRows:
    """The rows with those pixels alone of which one decides, at whatever exposure the designs may have.

    The light x_p that pixel p asks for grows with dark electrons, from a_p at the shortest exposure to b_p at the
    longest, and so does the (k + 1)-th greatest of all, from A to B. A pixel of b_p < A is never that one, nor is one
    of a_p > B, which counts as one of the k: as many of these are left out as every design has, at every altitude.
    """
    worst = rows.worst_e
    if worst is None or worst.shape[2] == 1 or rows.worst_sun_signal_e_s is not None or rows.resolve_m > 0.0:
        return rows  # bars must arrive at other pixels than those that decide the SNR
    least, most = (_asked(replace(rows, dark_time_s=time)) for time in rows.lit_exposures_s)
    return with_those_between(rows, least, most)


def with_those_between(light: Lit, least: Array, most: Array) -> Lit:
    """Rows or light with those pixels alone of which one decides, where each asks for `least` to `most` of light."""
    assert light.worst_e is not None
    pick, may_miss = may_decide(least, most, light.may_miss)
    veil = light.worst_veil_e
    return replace(
        light,
        worst_e=np.take_along_axis(light.worst_e, pick, axis=2),
        worst_veil_e=None if veil is None else np.take_along_axis(veil, pick, axis=2),
        may_miss=may_miss,
    )


def may_decide(least: Array, most: Array, may_miss: int) -> tuple[Array, int]:
    """Places (n, n_altitudes, n_few) of the pixels that may be the (k + 1)-th most demanding, and the k of these few.

    What pixels ask for is from `least` to `most` (n, n_altitudes, n_pixels), and grows from one to the other together.
    """
    low, high = (needed_by_most(asked, may_miss)[:, :, None] for asked in (least, most))
    above, below = least > high * (1 + SLACK), most < low * (1 - SLACK)
    order = np.argsort(np.where(above, 0, np.where(below, 2, 1)), axis=2, kind="stable")
    first = min(int(above.sum(axis=2).min(initial=may_miss)), may_miss)
    last = max(int((~below).sum(axis=2).max(initial=0)), may_miss + 1)
    return order[:, :, first:last], may_miss - first


def _asked(rows: SceneRows) -> Array:
    """Light that each pixel asks for at every altitude, (n, n_altitudes, n_pixels); inf: no light is enough."""
    assert rows.worst_e is not None
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        each = [windows.light_of_each(rows, a, rows.min_snr, of="worst") for a in range(-rows.worst_e.shape[1], 0)]
    asked = np.stack(each, axis=1)
    return np.where(np.isfinite(asked), asked, np.inf)
