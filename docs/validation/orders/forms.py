"""Effective attenuations that stand for all orders of scattering: fitted on half of the table, judged on the other.

The forms are those of `uwopt.model.multiple`, whose constants were fitted here and rounded.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from uwopt.forward.spectra import ENDLESS
from uwopt.model import beam as beams
from uwopt.model import multiple, scattering
from uwopt.model.sent_back import mean_way_m, widened_phase
from uwopt.model.widened import Turned, arriving_share, ways_m, widened

from .cases import TALLIES, Case, Light, read
from .model import Legs, backscatter_ratio, phase_table, uwopt_light

PLACE_SHARE, LEAST_RATIO = 1.0 / 3.0, 1e-3
SCALE = 0.05  # error from which a case counts less in the fit: no single one may bend it


class Constants(NamedTuple):
    """As in `uwopt.model.multiple`: angles in degrees, `back_by_lobe` by radian of the lobe."""

    lamp: float
    lamp_by_lobe: float
    near: float
    veil: float
    back: float
    back_by_lobe: float
    back_way: float


USED = Constants(
    multiple.LAMP_DEG, multiple.LAMP_BY_LOBE, multiple.NEAR_DEG, multiple.VEIL_DEG, multiple.BACK,
    multiple.BACK_BY_LOBE, multiple.BACK_WAY,
)  # fmt: skip
BY_TALLY = {
    "signal": ("lamp", "lamp_by_lobe"), "veil": ("near", "veil"), "backscatter": ("back", "back_by_lobe", "back_way"),
}  # fmt: skip


def attenuations(case: Case, constants: Constants = USED) -> Legs:
    """The attenuations of a case, with the lamp's own lobe."""
    now, b, lobe = constants, case.c_per_m * case.albedo, case.lobe_half_deg

    def leg(lost: float) -> float:
        return float(multiple.effective_attenuation_per_m(case.c_per_m, scattering_per_m=b, lost_share=lost))

    def beyond(angle_deg: float) -> float:
        return scattering.share_beyond(float(np.deg2rad(np.clip(angle_deg, 1.0, 180.0))), phase_table(case.phase))

    back = leg((now.back - now.back_by_lobe * np.deg2rad(lobe)) * beyond(90.0))
    least = multiple.LEAST_OF_ABSORPTION * (case.c_per_m - b)
    lamp, near = (leg(beyond(angle)) for angle in (now.lamp + now.lamp_by_lobe * lobe, now.near))
    within = float(np.deg2rad(np.clip(now.veil, 1.0, 89.0)))
    absorbed = (case.c_per_m - b) * case.altitude_m
    veil = min(leg(1.0 - float(arriving_share(phase_table(case.phase), absorbed, within_rad=within)[0])), near)
    return Legs(lamp, near, veil, max(back, least), max(back, least))


def effective(case: Case, constants: Constants = USED) -> Legs:
    """The same with what scattering on its way widens: the lobe, and the phase function that sends it back."""
    legs = attenuations(case, constants)
    lobes = floor_lobe(case, legs.lamp), back_lobe(case, legs.lamp)
    return legs._replace(lobes=lobes, phase=met(case, constants.back_way))


def no_farther(case: Case) -> Legs:
    """As if light that goes round had no longer way."""
    legs = attenuations(case)
    near, within = legs.near, float(np.deg2rad(USED.veil))
    lost = 1.0 - float(arriving_share(phase_table(case.phase), 0.0, within_rad=within)[0])
    veil = case.c_per_m - scattered(case)[1] * (1.0 - lost)
    straight = floor_lobe(case, legs.lamp, longer=False), back_lobe(case, legs.lamp, longer=False)
    return legs._replace(veil=min(veil, near), lobes=straight)


def never_again(case: Case) -> Legs:
    """As if nothing that turned back fell on the floor again."""
    legs = attenuations(case)
    lost = floor_lobe(case, legs.lamp, again=False), back_lobe(case, legs.lamp, again=False)
    return legs._replace(lobes=lost)


@cache
def floor_lobe(case: Case, lamp_per_m: float, *, longer: bool = True, again: bool = True) -> beams.Beam:
    """A case's lobe on the floor, over what K leaves of it."""
    a, b, backward = scattered(case)
    way, lost = case.altitude_m, 1.0 - (case.c_per_m - lamp_per_m) / b
    gain = multiple.returned_gain(a * way, turned_back=again * backward * way, reflectance=case.reflectance)
    turned = [Turned(b * way, lost, phase_table(case.phase))]
    return widened(own_lobe(case), turned, way, absorbed=longer * a * way, returned=gain)


@cache
def back_lobe(case: Case, lamp_per_m: float, *, longer: bool = True, again: bool = True) -> beams.Beam:
    """A case's lobe as the water sends it back, over what K leaves of it."""
    a, b, backward = scattered(case)
    reach_m, lost = ENDLESS / (case.c_per_m + lamp_per_m), 1.0 - (case.c_per_m - lamp_per_m) / b
    ways = ways_m(reach_m)
    gain = multiple.returned_gain(a * ways, turned_back=again * backward * ways, reflectance=0.0)
    turned = [Turned(b * ways, lost, phase_table(case.phase))]
    return widened(own_lobe(case), turned, reach_m, absorbed=longer * a * ways, returned=gain, sent_back=True)


@lru_cache(maxsize=256)
def met(case: Case, share: float) -> scattering.PhaseTable:
    """A case's phase function as light meets it that is sent back."""
    table, way_m = phase_table(case.phase), float(mean_way_m(case.altitude_m, case.c_per_m))
    return widened_phase(table, [(share * scattered(case)[1] * way_m, table)])


def scattered(case: Case) -> tuple[float, float, float]:
    """a, b and b_b [1/m]."""
    b = case.c_per_m * case.albedo
    return case.c_per_m - b, b, b * backscatter_ratio(phase_table(case.phase))


def own_lobe(case: Case) -> beams.Beam:
    """As the lamp sends it out."""
    return beams.cosine_power_beam(np.deg2rad(2 * case.lobe_half_deg))


def rows_of(use: str, *, thin: bool = True) -> list[Light]:
    """All places of one half of the table, up to c d = 4 or beyond."""
    return [
        row for row in read()
        if row.case.use == use and (row.case.thickness <= multiple.TESTED_THICKNESS) == thin
    ]  # fmt: skip


def means(use: str, *, thin: bool = True) -> list[Light]:
    """Image means of one half of the table."""
    return [row for row in rows_of(use, thin=thin) if row.place == "mean"]


@cache
def fitted() -> Constants:
    """The constants, from `fit` cases up to c d = 4: one tally after the other, each with its own.

    Of the veils corners count beside the means, each a third. Those of the lamps' leg are of means under the lamps' own
    lobes: beside a widened lobe, which stands over what K leaves, K drops out but for longer ways than straight down.
    """
    found = USED
    for tally, names in BY_TALLY.items():
        rows = [row for row in rows_of("fit") if row.place != "centre"] if tally != "signal" else means("fit")
        form = attenuations if tally == "signal" else effective
        share = [1.0 if row.place == "mean" else PLACE_SHARE for row in rows]

        def off(
            x: np.ndarray, tally: str = tally, known: Constants = found, rows: list[Light] = rows,
            share: list[float] = share, form: Callable[[Case, Constants], Legs] = form,
        ) -> np.ndarray:  # fmt: skip
            now = known._replace(**dict(zip(BY_TALLY[tally], map(float, x), strict=True)))
            errors = np.array([error(row, form(row.case, now), tally) for row in rows])
            return np.log(np.maximum(1.0 + errors, LEAST_RATIO)) * share if tally != "signal" else errors

        start = [getattr(found, name) for name in names]
        best = least_squares(off, start, x_scale=np.abs(start), diff_step=0.02, loss="soft_l1", f_scale=SCALE)
        found = found._replace(**dict(zip(names, map(float, best.x), strict=True)))
    return found


def error(row: Light, legs: Legs, tally: str) -> float:
    """Relative error of one tally."""
    return uwopt_light(row.case, row.place, legs)[tally] / row.value[tally] - 1.0


def errors(row: Light, legs_of: Callable[[Case], Legs]) -> dict[str, float]:
    """Relative errors of all tallies and of contrast."""
    found = uwopt_light(row.case, row.place, legs_of(row.case))
    off = {tally: found[tally] / row.value[tally] - 1.0 for tally in TALLIES}
    contrast = [light["signal"] / sum(light[tally] for tally in TALLIES) for light in (found, row.value)]
    return off | {"contrast": contrast[0] / contrast[1] - 1.0}
