"""By which way from the lamp a lobe is widened that lights a floor: several, each with constants fitted for it.

What of light has not gone this way yet when it has gone straight to its place, exp(-K (r - way)) leaves, with K of the
lamps' way; so that each way asks for constants of its own. Signal alone: that is what it changes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from uwopt.model import beam as beams
from uwopt.model import multiple, scattering
from uwopt.model.widened import Turned, ways_m, widened

from . import forms
from .cases import PLACES, Case, Light
from .model import phase_table

NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
REACH = 12.0  # heights up to which lobes are worked out
BEHIND = 0.05  # of the height: the shortest way of a place beside or behind the lobe


class Rays(NamedTuple):
    """From a lamp to places of the floor."""

    straight_m: np.ndarray
    along_m: np.ndarray  # the same, along the lobe's axis
    height_m: float
    slant_m: float  # of the axis, from the lamp to the floor


def power(share: float) -> Callable[[Rays], np.ndarray]:
    """Between the height and the straight way, even in logarithms."""
    return lambda rays: rays.height_m ** (1.0 - share) * rays.straight_m**share


WAYS: dict[str, Callable[[Rays], np.ndarray]] = {
    "the lamp's height": power(0.0),
    "a quarter on to the straight way": power(0.25),
    "half on, their geometric mean": power(0.5),
    "the straight way to the place": power(1.0),
    "that way's part along the lobe's axis": lambda rays: rays.along_m,
    "along the lobe's axis to the floor": lambda rays: np.full_like(rays.straight_m, rays.slant_m),
}


class Found(NamedTuple):
    """Relative errors of the signal with constants of its own, up to c d = 4: by half, of means and of corners."""

    constants: tuple[float, float]
    means: dict[str, np.ndarray]
    corners: dict[str, np.ndarray]


@cache
def judged(name: str, constants: tuple[float, float] | None = None) -> Found:
    """A way by `WAYS` on both halves, with constants of the lamps' way that are fitted for it, or given."""
    own = constants or fitted(name)
    off = {use: (rows_of(use), errors(rows_of(use), name, own)) for use in ("fit", "held out")}
    parts = [
        {use: e[[(row.place == "mean") == mean for row in rows]] for use, (rows, e) in off.items()}
        for mean in (True, False)
    ]
    return Found(own, *parts)


def fitted(name: str) -> tuple[float, float]:
    """Constants of the lamps' way from signals of the fit half up to c d = 4; corners count a third of means."""
    rows = rows_of("fit")
    share = np.array([1.0 if row.place == "mean" else forms.PLACE_SHARE for row in rows])
    start = np.array([forms.USED.lamp, forms.USED.lamp_by_lobe])
    best = least_squares(
        lambda x: np.log(np.maximum(1.0 + errors(rows, name, tuple(x)), forms.LEAST_RATIO)) * share, start,
        x_scale=start, diff_step=0.02, loss="soft_l1", f_scale=forms.SCALE, max_nfev=30,
    )  # fmt: skip
    return float(best.x[0]), float(best.x[1])


def rows_of(use: str) -> list[Light]:
    """Means and corners of one half up to c d = 4."""
    return [row for row in forms.rows_of(use) if row.place != "centre"]


def errors(rows: list[Light], name: str, constants: tuple[float, ...]) -> np.ndarray:
    """Relative errors of the signal."""
    return np.array([signal(row.case, row.place, name, constants) / row.value["signal"] - 1.0 for row in rows])


def signal(case: Case, place: str, name: str, constants: tuple[float, ...]) -> float:
    """Signal of a pinhole over a level floor, in the table's unit."""
    lit, further_m, weight = floor_light(case, place, name)
    lost = lost_share(case, *constants)
    k = case.c_per_m - forms.scattered(case)[1] * (1.0 - lost)
    return float((lit * np.exp(-k * further_m)) @ weight)


@cache
def floor_light(case: Case, place: str, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What forms the image at nodes of it if K took nothing, how much longer the straight way is than the other, and
    weights."""
    u, v, weight = places(place)
    h, tilt = case.altitude_m, float(np.deg2rad(case.tilt_deg))
    square = 1.0 + case.tangent**2 * (u * u + v * v)
    straight_m, cos_beam, cos_in = beams.lamp_rays(
        u * case.tangent * h, v * case.tangent * h, lamp_x_m=0.0, lamp_y_m=case.baseline_m, lamp_height_m=h,
        aim_x=0.0, aim_y=np.sin(tilt), aim_z=np.cos(tilt),
    )  # fmt: skip
    along_m = np.maximum(straight_m * cos_beam, BEHIND * h)
    way_m = WAYS[name](Rays(straight_m, along_m, h, h / float(np.cos(tilt))))
    lobe, k = lobe_by_way(case)
    intensity = beams.intensity_per_sr(cos_beam, lobe, way_m)
    lit = intensity * cos_in / straight_m**2 * np.exp(-k * way_m - case.c_per_m * h * np.sqrt(square))
    return lit * case.reflectance / np.pi / square**2, straight_m - way_m, weight


def places(place: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares of the half widths, and weights of the mean."""
    at = PLACES[place]
    if at is not None:
        return np.array([at[0]]), np.array([at[1]]), np.ones(1)
    u, v = np.meshgrid(NODES, NODES)
    return u.ravel(), v.ravel(), np.outer(WEIGHTS, WEIGHTS).ravel() / 4.0


@cache
def lobe_by_way(case: Case) -> tuple[beams.Beam, float]:
    """A lobe on the floor, widened by each way up to `REACH` heights over what some K leaves, and that K [1/m]."""
    a, b, backward = forms.scattered(case)
    lost = lost_share(case, forms.USED.lamp, forms.USED.lamp_by_lobe)
    ways = ways_m(REACH * case.altitude_m)
    gain = multiple.returned_gain(a * ways, turned_back=backward * ways, reflectance=case.reflectance)
    turned = [Turned(b * ways, lost, phase_table(case.phase))]
    lobe = widened(forms.own_lobe(case), turned, float(ways[-1]), absorbed=a * ways, returned=gain)
    return lobe, case.c_per_m - b * (1.0 - lost)


def lost_share(case: Case, lamp_deg: float, by_lobe: float) -> float:
    """s of the lamps' way."""
    angle = float(np.deg2rad(np.clip(lamp_deg + by_lobe * case.lobe_half_deg, 1.0, 180.0)))
    return scattering.share_beyond(angle, phase_table(case.phase))
