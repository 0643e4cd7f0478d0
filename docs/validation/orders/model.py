"""What uwopt's model makes of a case of the table: grey water, one lamp, a pinhole (a dome of no size) in water.

The water's K_d is not given by a case; it is what Kirk's (1984) formula makes of a and b under a sun that stands 31 deg
from the vertical in water, mu0 = 0.86: between 1 and 2 times a + b_b, as in the tables of Jerlov types.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uwopt.model import beam as beams
from uwopt.model import phase_formulas, scattering
from uwopt.model.image_mean import field_mean
from uwopt.model.imaging import Lamps, PortShape, local_gain
from uwopt.model.path_table import PathTable, build_path_table
from uwopt.model.veil.geometry import Scatterer
from uwopt.model.veil.mean import mean_backscatter
from uwopt.model.veil.ray import backscatter_gain
from uwopt.model.veil.spots import floor_spots
from uwopt.model.veil.wide import kernel_shares, mean_wide_gain, wide_gain
from uwopt.model.water import illumination_attenuation_per_m

from .cases import PLACES, TALLIES, Case
from .walk import phase_of

PINHOLE = PortShape(is_dome=True, outer_radius_m=0.0, thickness_m=0.0, n_glass=1.5, gap_m=0.0, n_water=1.34)
MU0 = 0.86
FIRST_DEG = 0.01  # angles at which uwopt is told the phase function
_PHASES: dict[str, Any] = {}


def phase_table(name: str) -> scattering.PhaseTable:
    """A phase function as uwopt holds it."""
    if name not in _PHASES:
        kind, _, rest = name.partition(" ")
        if kind == "ff":
            index, slope = phase_formulas.fournier_forand_for_backscatter(float(rest))
            made = scattering.phase_table_of(
                lambda psi: phase_formulas.fournier_forand_per_sr(psi, index=index, slope=slope)
            )
        elif kind == "hg":
            made = scattering.phase_table_of(
                lambda psi: phase_formulas.henyey_greenstein_per_sr(np.cos(psi), asymmetry=float(rest))
            )
        else:
            phase = phase_of(name)
            keep = phase.angle >= np.deg2rad(FIRST_DEG)
            made = scattering.phase_table(phase.angle[keep], np.exp(phase.log[keep]) / phase.total)
        _PHASES[name] = made
    return _PHASES[name]


def kd_per_m(a: float, b: float) -> float:
    """K_d = sqrt(a^2 + (0.425 mu0 - 0.19) a b) / mu0: Kirk (1984), Limnol. Oceanogr. 29, 350."""
    return float(np.sqrt(a * a + (0.425 * MU0 - 0.19) * a * b) / MU0)


def backscatter_ratio(table: scattering.PhaseTable) -> float:
    """Share of a table scattered beyond 90 degrees: b_b/b [1]."""
    return scattering.share_beyond(np.pi / 2, table)


class Legs(NamedTuple):
    """Attenuations of a model [1/m]; c is left to light that is not scattered on its way to the camera."""

    lamp: float  # from the lamp to the floor
    near: float  # from the floor to the camera, of what comes near its straight way, image or veil
    veil: float  # and of all; what lies between comes from elsewhere on the floor
    back_lamp: float  # of backscatter: from the lamp to where it is sent back
    back_camera: float  # and from there to the camera
    lobes: tuple[beams.Beam, beams.Beam] | None = None  # of light on the floor and of backscatter; None: the lamp's own
    phase: scattering.PhaseTable | None = None  # that light meets which is sent back; None: the water's own


def single(case: Case) -> Legs:
    """Without light scattered more than once: K on lamp legs and of the forward veil, c for backscatter."""
    b = case.c_per_m * case.albedo
    a, ratio = case.c_per_m - b, backscatter_ratio(phase_table(case.phase))
    k = illumination_attenuation_per_m(a, b_per_m=b, kd_per_m=kd_per_m(a, b), backscatter_ratio=ratio)
    return Legs(float(k), float(k), float(k), float(k), case.c_per_m)


def lost(case: Case) -> Legs:
    """Single scattering to the letter: what is scattered is lost on every leg."""
    c = case.c_per_m
    return Legs(c, c, c, c, c)


def uwopt_light(case: Case, place: str, legs: Legs) -> dict[str, float]:
    """Signal, forward veil and backscatter in the table's unit, by uwopt's own functions."""
    tilt = np.deg2rad(case.tilt_deg)
    lamps = Lamps((0.0,), (case.baseline_m,), (0.0,), ((0.0, float(np.sin(tilt)), float(np.cos(tilt))),), (1.0,))
    beam, back_beam = legs.lobes or [beams.cosine_power_beam(np.deg2rad(2 * case.lobe_half_deg))] * 2
    common: dict[str, Any] = dict(shape=PINHOLE, range_m=case.altitude_m, lamps=lamps, beam=beam)
    sent_back: dict[str, Any] = common | dict(beam=back_beam)

    def table(lamp: float, camera: float, least_m: tuple[float, float], less: float | None = None) -> PathTable:
        longest = 20.0 * case.altitude_m
        return build_path_table(
            np.ones(1), wavelength_nm=None, k_lamp_per_m=np.array([lamp]), c_camera_per_m=np.array([camera]),
            k_camera_per_m=None if less is None else np.array([less]), lamp_range_m=(least_m[0], longest),
            camera_range_m=(least_m[1], longest),
        )  # fmt: skip

    near = (0.999 * case.altitude_m,) * 2
    floor, phase = case.reflectance / np.pi, legs.phase or phase_table(case.phase)
    signal = table(legs.lamp, case.c_per_m, near)
    forward = table(legs.lamp, case.c_per_m, near, min(legs.near, case.c_per_m))
    elsewhere = table(legs.lamp, legs.near, near, min(legs.veil, legs.near))
    shares = kernel_shares(max(legs.near - legs.veil, 0.0) * case.altitude_m)
    wide: dict[str, Any] = dict(table=elsewhere, spots=floor_spots(**common), shape=PINHOLE, shares=shares)
    back_table = table(legs.back_lamp, legs.back_camera, (1e-3, 0.0))
    scatterers = (Scatterer(lambda cos: scattering.look_up(cos, phase), back_table),)
    half = np.array([case.tangent])
    if place == "mean":
        gains = [field_mean(half, half, table=loss, **common)[0] for loss in (signal, forward)]
        gains[1] += mean_wide_gain(half, half, **wide)[0]
        back = mean_backscatter(half, half, scatterers=scatterers, **sent_back)[0]
    else:
        u, v = PLACES[place] or (0.0, 0.0)
        at = u * half, v * half
        gains = [local_gain(*at, table=loss, **common)[0] for loss in (signal, forward)]
        gains[1] += wide_gain(*at, **wide)[0]
        back = backscatter_gain(*at, scatterers=scatterers, **sent_back)[0]
    shares = (floor, floor, case.c_per_m * case.albedo)
    values = (float(gain) * share for gain, share in zip((*gains, back), shares, strict=True))
    return dict(zip(TALLIES, values, strict=True))
