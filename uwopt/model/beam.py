"""How a lamp's light is spread over directions, and where it meets the floor.

A `Beam` is luminous intensity per lumen of the lamp, I/Phi [1/sr], by the angle from the beam's axis,
in water. Four shapes: `disc` (even light on a plane across the axis), `cone` (even intensity),
`cosine-power` (a lobe), `tabulated` (a measured profile). Nothing shines behind the front plane (90 deg).

Light that is scattered on its way from the lamp widens each of them (`model.halo`, `model.widened`): a share keeps the
shape, and a smooth halo of what was turned comes on top, alike for all ways or by the way.
"""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.errors import RangeError
from uwopt.model.halo import ROUNDING, Widening, flux

N_CELLS = 4096  # of the look-up of a tabulated beam, even in sqrt(1 - cos): 0.02 deg or finer up to 90 deg
AIR_STEP_RAD = np.deg2rad(0.5)  # a profile in air is sampled at least this densely before it is bent
GRAZING_AIR_RAD = np.deg2rad(80.0)
DISC_CONTINUED = 0.8  # an edgeless disc follows its formula down to this share of the edge's cosine
NARROWEST_WITH_HALO = 200.0  # exponent of cosine powers, 4.8 deg at half power: of a narrower spot the halo is apart


@dataclass(frozen=True, slots=True)
class Beam:
    """A beam shape in water; hashable, so that what is computed from it can be remembered."""

    kind: Literal["disc", "cone", "cosine-power", "tabulated"]
    half_angle_water_rad: float | None = None  # disc and cone: the edge
    exponent: float | None = None  # cosine-power
    table_angle_rad: tuple[float, ...] = ()  # tabulated, increasing, up to 90 deg
    table_intensity_per_sr: tuple[float, ...] = ()  # tabulated, I/Phi
    edgeless: bool = False  # the intensity inside, continued smoothly beyond the edge; see `without_edge`
    widening: Widening | None = None  # by scattering on the way; all else is of the lamp's own beam


def disc_beam(half_angle_water_rad: float) -> Beam:
    """Even illuminance on a plane across the axis, within the half-angle."""
    half = half_angle_water_rad
    _require(0 < half < np.pi / 2, "half-angle of a disc beam", half, "0 to 90")
    return Beam("disc", half_angle_water_rad=float(half))


def cone_beam(half_angle_water_rad: float) -> Beam:
    """Even intensity within the half-angle."""
    half = half_angle_water_rad
    _require(0 < half <= np.pi / 2, "half-angle of a cone beam", half, "0 to 90")
    return Beam("cone", half_angle_water_rad=float(half))


def cosine_power_beam(full_width_half_power_water_rad: float) -> Beam:
    """A lobe cos^m, half as strong at half the given full angle: m = ln 1/2 / ln cos(FWHM/2)."""
    full = full_width_half_power_water_rad
    _require(0 < full < np.pi, "full angle at half power of a beam", full, "0 to 180")
    # log1p(-2 sin^2(x/2)) is log cos x without the cancellation of narrow beams.
    log_cos = np.log1p(-2 * np.sin(full / 4) ** 2)
    return Beam("cosine-power", exponent=float(np.log(0.5) / log_cos))


def tabulated_beam(
    angle_rad: ArrayLike,
    intensity: ArrayLike,
    *,
    medium: Literal["air", "water"],
    n_w: float,
    total_flux_lm: float | None = None,
) -> Beam:
    """A measured profile.

        in air behind a flat window: I_w = I_a n_w^2 cos(t_w) / cos(t_a), sin(t_a) = n_w sin(t_w)

    Parameters
    ----------
    angle_rad : (m,) [rad], from the axis, increasing from 0 or more; what is beyond 90 deg is left out
    intensity : (m,) [cd], or any unit when relative; zero or more
    medium : where angle and intensity were measured
    n_w : scalar [1], refractive index of the water; not used for a profile in water
    total_flux_lm : scalar [lm], the flux that the caller's lumens stand for; None: the profile is relative
        and is scaled so that it holds all of the lamp's flux

    Returns
    -------
    Beam; an absolute one integrates to (measured flux / total_flux_lm), which may differ from 1

    Notes
    -----
    Monotone cubic (PCHIP) between the entries, hence never above the highest or below the lowest of two
    neighbours; held from the first entry to the axis; zero beyond the last.
    Beyond 80 deg in air an intensity may fall no slower than the cosine: the window's last face sends
    nothing out at grazing angles, and the factor 1/cos would blow a digitiser's noise floor up.
    """
    angle = np.asarray(angle_rad, dtype=float)
    values = np.asarray(intensity, dtype=float)
    _check_table(angle, values)
    if angle[0] > 0:
        angle, values = np.r_[0.0, angle], np.r_[values[0], values]
    if angle[-1] > np.pi / 2:
        at_rim = _pchip(np.array([np.pi / 2]), angle, values)
        keep = angle < np.pi / 2
        angle, values = np.r_[angle[keep], np.pi / 2], np.r_[values[keep], at_rim]
    if medium == "air":
        angle, values = _air_to_water(angle, values, n_w)
    held = flux(_uniform_table(tuple(angle.tolist()), tuple(values.tolist())))
    if total_flux_lm is not None:
        _require(total_flux_lm > 0, "total flux of a profile", total_flux_lm, "above 0", unit="lm")
    if not held > 0:
        raise RangeError("a beam profile holds no light between 0 and 90 deg")
    values = values / (held if total_flux_lm is None else total_flux_lm)
    return Beam(
        "tabulated", table_angle_rad=tuple(angle.tolist()), table_intensity_per_sr=tuple(values.tolist())
    )


def half_angle_in_water_rad(half_angle_air_rad: Any, *, n_w: Any) -> Any:
    """The angle in water of a ray that leaves a flat window at this angle in air: sin(w) = sin(a) / n_w.

    Angles above 90 deg in air count as 90: behind a flat window nothing goes further.
    """
    return np.arcsin(np.sin(np.minimum(half_angle_air_rad, np.pi / 2)) / n_w)


def intensity_per_sr(cos_angle: ArrayLike, beam: Beam, way_m: ArrayLike = 0.0) -> FloatArray:
    """Luminous intensity per lumen of the lamp.

        disc          1 / (pi tan^2(b) cos^3(t))      t <= b
        cone          1 / (2 pi (1 - cos(b)))         t <= b
        cosine-power  (m + 1) / (2 pi) cos^m(t)
        tabulated     look-up
        widened       share times the beam's own, plus the halo's look-up

    Parameters
    ----------
    cos_angle : (...,) [1], cosine of the angle t from the beam's axis, in water
    beam : Beam
    way_m : (...,) [m], length of the light's way, of which a beam may know that it widens along it; or which of beams
        `numbered`, numbers

    Returns
    -------
    (...,) [sr^-1]; 0 behind the front plane (cos <= 0) and outside the beam

    Notes
    -----
    The look-up is linear in 4096 cells of sqrt(1 - cos): within 1e-4 of the peak for knots 0.5 deg or more
    apart (the flux is exact); the jump at the end of a table that does not end at zero is spread over one
    cell (0.02 deg).
    """
    cos = np.asarray(cos_angle, dtype=float)
    if beam.widening is not None:
        share, halo = beam.widening.at(cos, np.asarray(way_m))
        if beam.widening.part == "halo":
            return np.asarray(halo)
        unturned = share * intensity_per_sr(cos, own(beam))
        return np.asarray(unturned if beam.widening.part == "own" else unturned + halo)
    if beam.kind == "tabulated":
        return _look_up(cos, beam)
    if beam.kind == "cosine-power":
        m = _exponent(beam)
        return np.asarray((m + 1) / (2 * np.pi) * np.maximum(cos, 0.0) ** m * (cos > 0))
    cos_edge = float(np.cos(_half_angle(beam)))
    inside = (cos > 0) if beam.edgeless else (cos >= cos_edge) & (cos > 0)
    if beam.kind == "cone":
        return np.asarray(inside * _cone_intensity(beam), dtype=float)
    cos_inside = np.maximum(cos, cos_edge * (DISC_CONTINUED if beam.edgeless else 1.0))
    axial = 1 / (np.pi * np.tan(_half_angle(beam)) ** 2)
    return np.asarray(inside * (axial / (cos_inside * cos_inside * cos_inside)))


def peak_intensity_per_sr(beam: Beam) -> float:
    """An upper bound of what `intensity_per_sr` returns over all angles, tight to rounding."""
    if beam.widening is not None:
        halo = float(beam.widening.most_per_sr.max()) * (1 + ROUNDING)
        share = beam.widening.most_share
        return halo + (share * peak_intensity_per_sr(own(beam)) if share else 0.0)
    if beam.kind == "disc":
        b = _half_angle(beam)
        cos_least = np.cos(b) * (DISC_CONTINUED if beam.edgeless else 1.0)
        peak = 1 / (np.pi * np.tan(b) ** 2 * cos_least**3)
    elif beam.kind == "cone":
        peak = _cone_intensity(beam)
    elif beam.kind == "cosine-power":
        peak = (_exponent(beam) + 1) / (2 * np.pi)
    else:
        peak = max(beam.table_intensity_per_sr)
    return float(peak * (1 + ROUNDING))


def own(beam: Beam) -> Beam:
    """The lamp's own beam I, as if nothing had widened share I + halo [1/sr]."""
    return beam if beam.widening is None else dataclasses.replace(beam, widening=None)


def widened_by(beam: Beam, widening: Widening) -> Beam:
    """The beam I with what scattering makes of it, share I + halo [1/sr]."""
    return dataclasses.replace(beam, widening=widening)


@functools.lru_cache(maxsize=64)
def numbered(lobes: tuple[Beam, ...]) -> Beam:
    """One beam after several ways to a floor as one: `intensity_per_sr` [1/sr] takes numbers for ways."""
    return widened_by(lobes[0], Widening.of_several([one.widening for one in lobes if one.widening is not None]))


@functools.lru_cache(maxsize=1024)
def parts(beam: Beam) -> tuple[Beam, ...]:
    """Beams that add up to one: its share that is left, and its halo, where one ends sharply or is far narrower.

    For quadratures that treat the edge, or seek the bright part, themselves. The halo counts as a measured profile.
    """
    is_apart = has_sharp_edge(beam) or (beam.exponent or 0.0) > NARROWEST_WITH_HALO
    if beam.widening is None or beam.widening.part != "both" or not is_apart:
        return (beam,)
    return widened_by(beam, beam.widening.alone("own")), Beam("tabulated", widening=beam.widening.alone("halo"))


@functools.lru_cache(maxsize=1024)
def flux_per_lm(beam: Beam) -> float:
    """An upper bound of a beam's flux per lumen of the lamp, tight to rounding where it is the same for all ways.

    Over what the water's K leaves, which widened beams are relative to, more than all may come.
    """
    if beam.widening is None:
        return 1.0
    return beam.widening.most_share + flux(beam.widening.most_per_sr) * (1 + ROUNDING)


def has_sharp_edge(beam: Beam) -> bool:
    """True where the intensity jumps at the edge (a table's end: by over 1 % of the peak).

    Quadratures converge slowly across such an edge; `without_edge` gives them the smooth part.
    """
    if beam.edgeless or _is_halo(beam):
        return False
    if beam.kind == "tabulated":
        return beam.table_intensity_per_sr[-1] > 0.01 * max(beam.table_intensity_per_sr)
    return beam.kind in ("disc", "cone")


def is_smooth(beam: Beam) -> bool:
    """Whether the intensity has neither an edge nor the bends of a measured profile, so that light has no creases."""
    return beam.kind == "cosine-power"


def _is_halo(beam: Beam) -> bool:
    return beam.widening is not None and beam.widening.part == "halo"


def edge_half_angle_rad(beam: Beam) -> float:
    """The angle from the axis beyond which no light goes [rad], at most 90 deg."""
    if beam.widening is not None and beam.widening.part != "own":
        return float(np.pi / 2)
    if beam.kind == "cosine-power" or beam.edgeless:
        return float(np.pi / 2)
    if beam.kind == "tabulated":
        lit = np.flatnonzero(beam.table_intensity_per_sr)
        last = min(int(lit[-1]) + 1, len(beam.table_angle_rad) - 1)
        return beam.table_angle_rad[last]
    return _half_angle(beam)


@functools.lru_cache(maxsize=1024)
def half_power_angle_rad(beam: Beam) -> float:
    """Greatest angle from the axis with half the peak intensity [rad]; the edge of a disc or cone.

    Of a widened beam that of the lamp's own, the sharpest in it; of a halo alone where it is widest.
    """
    if beam.widening is not None and not _is_halo(beam):
        return half_power_angle_rad(own(beam))
    if beam.kind in ("disc", "cone"):
        return _half_angle(beam)
    if beam.exponent:  # cos^m = 1/2; from 1 - cos, which a needle's cosine has no digits for
        return float(2.0 * np.arcsin(np.sqrt(-0.5 * np.expm1(-np.log(2.0) / beam.exponent))))
    angle = np.linspace(0.0, np.pi / 2, 18001)
    reach_m = 0.0 if beam.widening is None else beam.widening.reach_m
    intensity = intensity_per_sr(np.cos(angle), beam, reach_m)
    return float(angle[np.flatnonzero(intensity >= 0.5 * intensity.max())[-1]])


ENVELOPE_RAD = np.linspace(0.0, np.pi / 2, 18001)  # of all falling envelopes


@functools.lru_cache(maxsize=256)
def falling_envelope(beam: Beam) -> tuple[FloatArray, FloatArray]:
    """`ENVELOPE_RAD`, and the greatest intensity at that angle or any larger one [rad], [1/sr].

    A bound for proofs: it never rises, and lies nowhere below the beam. Between its angles take the
    value at the smaller one. Of a widened beam the sum of its parts' envelopes.
    """
    angle = ENVELOPE_RAD
    if beam.widening is not None:
        halo, share = beam.widening.envelope(angle), beam.widening.most_share
        return angle, share * falling_envelope(own(beam))[1] + halo if share else halo
    intensity = intensity_per_sr(np.cos(angle), beam)
    middle = intensity_per_sr(np.cos(angle[:-1] + 0.5 * (angle[1] - angle[0])), beam)
    seen = np.maximum(intensity, np.append(middle, 0.0))
    seen[:-1] = np.maximum(seen[:-1], intensity[1:])
    if has_sharp_edge(beam):  # a jump between two angles is covered up to its upper end
        at = int(np.searchsorted(angle, edge_half_angle_rad(beam)))
        seen[: at + 1] = np.maximum(seen[: at + 1], 0.0)
        seen[max(at - 1, 0)] = max(seen[max(at - 1, 0)], peak_intensity_per_sr(beam))
    return angle, np.maximum.accumulate(seen[::-1])[::-1] * (1 + ROUNDING)


def without_edge(beam: Beam) -> Beam:
    """The same intensity inside, continued smoothly beyond the edge up to the front plane.

    For quadratures that treat the edge themselves, by the share of each cell that it leaves lit.
    A beam without a sharp edge is returned as it is.
    """
    return dataclasses.replace(beam, edgeless=True) if has_sharp_edge(beam) else beam


def lamp_aim(
    tilt_x_rad: ArrayLike, tilt_y_rad: ArrayLike, *, lamp_x_m: ArrayLike, lamp_y_m: ArrayLike
) -> Any:
    """Unit vector of a lamp's axis in the vehicle frame (x forward, y starboard, z down).

        aim ~ (s_x tan(tilt_x), s_y tan(tilt_y), 1),  s the sign of the lamp's coordinate, + at 0

    Tilts are outward: positive turns the beam away from the camera along that axis. Shapes broadcast.
    """
    x = np.where(np.asarray(lamp_x_m) < 0, -1.0, 1.0) * np.tan(tilt_x_rad)
    y = np.where(np.asarray(lamp_y_m) < 0, -1.0, 1.0) * np.tan(tilt_y_rad)
    x, y = np.broadcast_arrays(x, y)
    length = np.sqrt(x * x + y * y + 1.0)
    return x / length, y / length, 1.0 / length


def lamp_rays(
    floor_x_m: Any,
    floor_y_m: Any,
    *,
    lamp_x_m: Any,
    lamp_y_m: Any,
    lamp_height_m: Any,
    aim_x: Any,
    aim_y: Any,
    aim_z: Any,
    slope: float = 0.0,
) -> Any:
    """The rays from a lamp to points of a floor, level or z = d + slope x.

        cos(incidence) = (h - slope (x - x_lamp)) / (r sqrt(1 + slope^2)), not below 0

    Parameters
    ----------
    floor_x_m, floor_y_m : (...,) [m], points of the floor, vehicle frame (x forward, y starboard, z down)
    lamp_x_m, lamp_y_m : broadcasting [m]
    lamp_height_m : broadcasting [m], h, z of the floor there minus z of the lamp, above 0 over a level floor
    aim_x, aim_y, aim_z : broadcasting [1], unit vector of the beam's axis

    Returns
    -------
    range_m, cos_beam_angle, cos_incidence : (...,) [m], [1], [1]
        Length; cosine of the angle from the beam's axis; cosine of the angle from the floor's normal.
    """
    x = floor_x_m - lamp_x_m
    y = floor_y_m - lamp_y_m
    range_m = np.sqrt(x * x + y * y + lamp_height_m * lamp_height_m)
    cos_incidence = lamp_height_m / range_m
    if slope:
        cos_incidence = np.maximum(cos_incidence - slope * x / range_m, 0.0) / np.hypot(1.0, slope)
    cos_beam_angle = (x * aim_x + y * aim_y + lamp_height_m * aim_z) / range_m
    return range_m, cos_beam_angle, cos_incidence


def _half_angle(beam: Beam) -> float:
    if beam.half_angle_water_rad is None:
        raise RangeError(f"a {beam.kind} beam needs half_angle_water_rad")
    return beam.half_angle_water_rad


def _exponent(beam: Beam) -> float:
    if beam.exponent is None:
        raise RangeError("a cosine-power beam needs an exponent")
    return beam.exponent


def _cone_intensity(beam: Beam) -> float:
    # 1 - cos(b) = 2 sin^2(b/2), without cancellation in narrow beams
    return float(1 / (4 * np.pi * np.sin(_half_angle(beam) / 2) ** 2))


def _look_up(cos: FloatArray, beam: Beam) -> FloatArray:
    table, slope = _fine_table(beam)
    # cos <= 0 lands on the last knot, whose value and slope are zero.
    position = np.sqrt(np.clip(1.0 - cos, 0.0, 1.0)) * N_CELLS
    cell = position.astype(np.int32)
    position -= cell
    return np.asarray(table[cell] + position * slope[cell])


@functools.lru_cache(maxsize=64)
def _fine_table(beam: Beam) -> tuple[FloatArray, FloatArray]:
    table = _uniform_table(beam.table_angle_rad, beam.table_intensity_per_sr, hold=beam.edgeless)
    slope = np.r_[np.diff(table), 0.0]
    table.setflags(write=False)
    slope.setflags(write=False)
    return table, slope


def _uniform_table(
    angle_rad: tuple[float, ...], intensity: tuple[float, ...], *, hold: bool = False
) -> FloatArray:
    """Values at knots even in u = sqrt(1 - cos), 0..1: cheap to index, dense where the axis is."""
    u = np.linspace(0.0, 1.0, N_CELLS + 1)
    knot_rad = 2 * np.arcsin(u / np.sqrt(2))
    angle = np.asarray(angle_rad)
    values = _pchip(knot_rad, angle, np.asarray(intensity))
    if not hold:
        values[knot_rad > angle[-1]] = 0.0
    values[-1] = 0.0  # the front plane itself is dark
    return values


def _air_to_water(angle: FloatArray, values: FloatArray, n_w: float) -> tuple[FloatArray, FloatArray]:
    _require(n_w >= 1, "refractive index of water", n_w, "1 or more", unit="")
    # The two-step union keeps the entries of the table and adds what the bending needs.
    n_even = int(np.ceil(angle[-1] / AIR_STEP_RAD)) + 1
    air = np.union1d(angle, np.linspace(0.0, angle[-1], n_even))
    i_air = _pchip(air, angle, values)
    i_grazing = float(_pchip(np.array([min(GRAZING_AIR_RAD, angle[-1])]), angle, values)[0])
    # With a cap I_a <= I_80 cos(t)/cos(80 deg), I_a/cos(t) stays finite up to 90 deg.
    per_cos = i_air / np.maximum(np.cos(air), np.cos(GRAZING_AIR_RAD))
    beyond = air > GRAZING_AIR_RAD
    rim = i_air[beyond] / np.maximum(np.cos(air[beyond]), 1e-300)
    per_cos[beyond] = np.minimum(rim, i_grazing / np.cos(GRAZING_AIR_RAD))
    water = np.arcsin(np.sin(air) / n_w)
    # Close to 90 deg in air, angles in water bunch up to the critical angle: keep them distinct.
    keep = np.r_[True, np.diff(water) > 1e-9]
    return water[keep], (per_cos * n_w**2 * np.cos(water))[keep]


def _pchip(x: FloatArray, knots: FloatArray, values: FloatArray) -> FloatArray:
    """Monotone piecewise cubic (Fritsch and Butland 1984), held beyond the ends."""
    h = np.diff(knots)
    secant = np.diff(values) / h
    slope = np.zeros_like(values)
    if values.size == 2:
        slope[:] = secant[0]
    else:
        w1, w2 = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
        same = secant[1:] * secant[:-1] > 0
        left, right = np.where(same, secant[:-1], 1.0), np.where(same, secant[1:], 1.0)
        with np.errstate(over="ignore"):  # beside a rise next to nothing the slope is nothing
            slope[1:-1] = np.where(same, (w1 + w2) / (w1 / left + w2 / right), 0.0)
        slope[0] = _end_slope(h[0], h[1], secant[0], secant[1])
        slope[-1] = _end_slope(h[-1], h[-2], secant[-1], secant[-2])
    x = np.clip(x, knots[0], knots[-1])
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, h.size - 1)
    t = (x - knots[i]) / h[i]
    rise = values[i + 1] - values[i]
    bend = t * (1 - t) * ((slope[i] * h[i] - rise) * (1 - t) - (slope[i + 1] * h[i] - rise) * t)
    # Rounding must not leave the interval of the two neighbours: the peak is a bound used in proofs.
    low, high = np.minimum(values[i], values[i + 1]), np.maximum(values[i], values[i + 1])
    return np.asarray(np.clip(values[i] + t * rise + bend, low, high))


def _end_slope(h0: float, h1: float, secant0: float, secant1: float) -> float:
    """One-sided three-point slope, limited so that the end cell stays monotone."""
    slope = ((2 * h0 + h1) * secant0 - h0 * secant1) / (h0 + h1)
    if slope * secant0 <= 0:
        return 0.0
    if secant0 * secant1 <= 0 and abs(slope) > 3 * abs(secant0):
        return 3 * secant0
    return float(slope)


def _check_table(angle: FloatArray, values: FloatArray) -> None:
    if angle.ndim != 1 or angle.shape != values.shape or angle.size < 2:
        raise RangeError("a beam profile needs two or more angles and as many intensities, one row each")
    if not (np.all(np.diff(angle) > 0) and angle[0] >= 0 and angle[-1] <= np.pi * (1 + 1e-12)):
        raise RangeError("the angles of a beam profile must increase within 0-180 deg")
    if angle[0] >= np.pi / 2:
        raise RangeError("a beam profile must begin before 90 deg; turn the lamp so that 0 is its axis")
    if not (np.all(np.isfinite(values)) and np.all(values >= 0)):
        raise RangeError("the intensities of a beam profile must be finite and not negative")


def _require(ok: bool, what: str, value: float, allowed: str, unit: str = "deg") -> None:
    if not ok:
        shown = np.rad2deg(value) if unit == "deg" else value
        raise RangeError(f"{what} is {shown:g} {unit}; allowed: {allowed} {unit}".strip())
