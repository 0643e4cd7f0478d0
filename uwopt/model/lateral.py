"""Lateral colour of a flat port: each wavelength lands at its own radius, a spectrum is drawn out radially.

A far floor point at theta_w in water is imaged at r(lambda) = f tan(asin(n_w(lambda) sin theta_w)). The
index moves by a few thousandths only, so to first order r spreads by (dr/dn) times the spread of n_w, and
the Fourier transform of every such spread is one function of one number. `spread_table` tabulates that
function for a detected spectrum; `spread_mtf` looks it up.

Angles are those in air at the design wavelength (550 nm), the pixel's own, given by their tangent. A dome
with the pupil at its centre has no lateral colour. Functions marked [sym] also take CasADi scalars.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uwopt.arrays import Array
from uwopt.model.port import flat_floor_derivative
from uwopt.model.spectrum import trapezoid_weights_nm

Numeric = Any  # float, array that broadcasts, or (where marked [sym]) a CasADi scalar

_STEP = 1.0 / 500.0  # of the table, in k times the rms of n: linear look-up errs by step^2 / 8 = 5e-7
_TABLE_END = 24.0  # in the same unit; 24 is a spread of 7.6 px rms at 0.5 cycles per px
_MOST_PHASE = 1.0  # largest k times the change of n in a segment, for four nodes
_TURN = 2.0 * np.pi / 2**20  # k times the spacing d of the grid in n that the transform is taken on, a step of k
_LARGEST_SINE = 1.0 - 1e-12  # a wavelength that would be totally reflected is held at grazing


# ---------------------------------------------------------------- where wavelengths land


def colour_radius_m(
    tan_air: Numeric, *, n_water: Numeric, n_design: Numeric, focal_length_m: Numeric
) -> Numeric:
    """Where a wavelength lands, off the axis of the image.

        r = f tan(asin(n_w sin theta_w)),   sin theta_w = sin theta_a / n_design                     [sym]

    Parameters
    ----------
    tan_air : (...,) tangent of the field point's angle in air at the design wavelength
    n_water : broadcast, index of the water at the wavelength, relative to air
    n_design : broadcast, the same at the design wavelength
    focal_length_m : broadcast [m], the lens's own

    Returns
    -------
    (...,) [m]; f tan_air at the design wavelength.

    Notes
    -----
    Distortion-free lens without colour of its own, floor far against the gap between pupil and glass (see
    `finite_range_share`). The glass is a plane plate: its dispersion drops out as well.

    References
    ----------
    Physics page, section 4 (lateral colour).
    """
    sine = n_water / n_design * tan_air / np.sqrt(1.0 + tan_air**2)
    sine = np.minimum(np.maximum(sine, -_LARGEST_SINE), _LARGEST_SINE)
    return focal_length_m * sine / np.sqrt(1.0 - sine**2)


def lateral_colour_px(
    tan_air: Numeric,
    *,
    n_water: ArrayLike,
    n_design: Numeric,
    electrons: ArrayLike,
    focal_length_m: Numeric,
    pixel_pitch_m: Numeric,
) -> Numeric:
    """Width of the spectrum that a flat port draws out of a point, electron-weighted rms.

        sigma^2 = sum w (r - mean r)^2 / p^2,   w = electrons / sum of electrons

    Parameters
    ----------
    tan_air : (...,) as in `colour_radius_m`
    n_water : (n_wavelength,) index of the water
    n_design : scalar, index at the design wavelength
    electrons : (n_wavelength,) electrons that each wavelength gives, any scale: spectral density times the
        weights of the grid (`spectrum.trapezoid_weights_nm`)
    focal_length_m, pixel_pitch_m : broadcast [m]

    Returns
    -------
    (...,) [px], exact in the angle; 0 if there are no electrons. Without meaning where `some_reflected`.

    References
    ----------
    Physics page, section 4 (lateral colour).
    """
    share = _shares(np.asarray(electrons, dtype=float))
    tangent = np.asarray(tan_air, dtype=float)[..., np.newaxis]
    radius = colour_radius_m(tangent, n_water=np.asarray(n_water), n_design=n_design, focal_length_m=1.0)
    offset = radius - tangent  # small against the radius: the variance below does not cancel
    mean = offset @ share
    rms = np.sqrt((offset - mean[..., np.newaxis]) ** 2 @ share)
    return (rms * focal_length_m / pixel_pitch_m)[()]


def some_reflected(
    tan_air: Numeric, *, n_water: ArrayLike, n_design: Numeric, electrons: ArrayLike
) -> Numeric:
    """Whether a flat port totally reflects a colour that would give electrons: its image lies at infinity.

    Arguments as in `lateral_colour_px`; (...,) bool.
    """
    seen = np.asarray(electrons, dtype=float) > 0.0
    steepest = np.max(np.where(seen, n_water, 0.0)) / n_design
    return np.abs(tan_air) * steepest >= _LARGEST_SINE * np.sqrt(1.0 + np.square(tan_air))


def radius_slope_px(
    tan_air: Numeric, *, n_design: Numeric, focal_length_m: Numeric, pixel_pitch_m: Numeric
) -> Numeric:
    """How fast the image of a point moves outward with the index of the water.

        (1/p) dr/dn = (f/p) sin theta_w / cos^3 theta_a = (f/p) tan_a (1 + tan_a^2) / n_design       [sym]

    Arguments as in `lateral_colour_px`; returns (...,) [px per unit of index]. Times 2 pi it is the number
    k per cycle per px that `spread_mtf` takes; times the rms of the index it is the spread to first order,
    0.2 % low at 40 degrees in air (1 % at 60) under a white lamp. Physics page, section 4.
    """
    return focal_length_m / pixel_pitch_m * tan_air * (1.0 + tan_air**2) / n_design


def finite_range_share(
    tan_air: Numeric,
    *,
    gap_m: Numeric,
    thickness_m: Numeric,
    n_glass: Numeric,
    n_water: Numeric,
    range_m: Numeric,
) -> Numeric:
    """Share of the far-field spread that is left when the floor is near.

        share = d tan_w' / (e + t_g tan_g' + d tan_w'),   ' = derivative by tan_a                    [sym]

    Arguments as in `port.flat_floor_distance_m`; (...,) 0..1, multiplies `radius_slope_px`. All wavelengths
    come from one floor point; what the ray travels in gap and glass does not disperse, and holds it back.
    From the implicit derivative of the floor distance at constant x. Physics page, section 4.
    """
    ray: dict[str, Numeric] = {"n_glass": n_glass, "n_water": n_water, "range_m": range_m}
    water_m = flat_floor_derivative(tan_air, gap_m=0.0, thickness_m=0.0, **ray)
    return water_m / flat_floor_derivative(tan_air, gap_m=gap_m, thickness_m=thickness_m, **ray)


# ---------------------------------------------------------------- transform of the spread


@dataclass(frozen=True)
class SpreadTable:
    """|Phi(k)| of one detected spectrum on equidistant k >= 0, ready for look-up."""

    magnitude: Array  # (n,) from 1 at k = 0 on
    least_so_far: Array  # (n,) the lowest magnitude up to k: the same, but never rising
    step: float  # of k, in 1 / index
    index_rms: float  # electron-weighted rms of n_water: |Phi| = 1 - (k index_rms)^2 / 2 at small k


@dataclass(frozen=True)
class SpreadRows:
    """Tables of many spectra, one after another, and of each design (n,) its own."""

    magnitude: Array  # (n_tables * size,)
    least_so_far: Array
    step: Array  # (n,); inf where nothing is spread
    first: Array  # (n,) where its table begins
    size: int  # of each

    @classmethod
    def of(cls, tables: Sequence[SpreadTable], index: Array) -> SpreadRows:
        """Designs by the index of their table."""
        size = max(table.magnitude.size for table in tables)
        there = [table.magnitude.size == size and table.index_rms > 0.0 for table in tables]
        ones, steps = np.ones(size), [t.step if spread else np.inf for t, spread in zip(tables, there, strict=True)]

        def joined(columns: Sequence[Array]) -> Array:
            return np.concatenate([one if spread else ones for one, spread in zip(columns, there, strict=True)])

        return cls(
            joined([t.magnitude for t in tables]), joined([t.least_so_far for t in tables]), np.array(steps)[index],
            size * index, size,
        )  # fmt: skip

    def take(self, rows: Array) -> SpreadRows:
        """Some designs."""
        return replace(self, step=self.step[rows], first=self.first[rows])


_NO_SPREAD = SpreadTable(np.ones(2), np.ones(2), step=1.0, index_rms=0.0)


def spread_table(wavelength_nm: ArrayLike, *, electrons_per_nm: ArrayLike, n_water: ArrayLike) -> SpreadTable:
    """Fourier transform of the detected spectrum over the index of the water.

        |Phi(k)| = | integral of w exp(i k n_w) d lambda |,   w = electrons per nm / their integral

    Parameters
    ----------
    wavelength_nm : (n,) [nm], increasing
    electrons_per_nm : (n,) spectral density of the electrons, any scale
    n_water : (n,) index of the water

    Returns
    -------
    SpreadTable; all ones for a single wavelength or without light.

    Notes
    -----
    Density and index are linear between samples, and each segment is integrated in closed form: a sum over
    samples alone would come back to 1 at large k. The two humps of a white lamp make |Phi| rise a little
    after its first dips (by 0.04); `least_so_far` is for those who need a falling transfer.

    References
    ----------
    Physics page, section 8.
    """
    wavelength = np.asarray(wavelength_nm, dtype=float)
    density, index = np.asarray(electrons_per_nm, dtype=float), np.asarray(n_water, dtype=float)
    if wavelength.size < 2 or not np.any(density > 0.0):
        return _NO_SPREAD
    share = _shares(density * trapezoid_weights_nm(wavelength))
    centred = index - index @ share
    index_rms = float(np.sqrt(centred**2 @ share))
    if index_rms == 0.0:
        return _NO_SPREAD
    step = _STEP / index_rms
    n_k = round(_TABLE_END / _STEP) + 1
    magnitude = np.minimum(_transform_magnitude(n_k, step, wavelength, density, centred), 1.0)
    magnitude[0] = 1.0
    return SpreadTable(magnitude, np.minimum.accumulate(magnitude), step, index_rms)


def never_rising(table: SpreadTable) -> SpreadTable:
    """max |Phi(k')| over k' >= k: nowhere below a table, and falling all along."""
    return replace(table, magnitude=np.maximum.accumulate(table.magnitude[::-1])[::-1])


def rms_px(k_along: Numeric, k_across: Numeric, index_rms: Numeric) -> Numeric:
    """Lateral colour [px rms] to first order, of k per cycle per px; all broadcast."""
    return np.hypot(k_along, k_across) * (index_rms / (2.0 * np.pi))


def spread_mtf(k: Numeric, *, table: SpreadTable | SpreadRows, falling: bool = False) -> Numeric:
    """Modulation that lateral colour leaves.

        |Phi(k)|,   k = 2 pi nu . e_r radius_slope_px

    Parameters
    ----------
    k : (...,) [1 / index], either sign
    table : of the detected spectrum, or of those of n designs, k (n,)
    falling : give the least of |Phi| up to k instead

    Returns
    -------
    (...,) 0..1, linear in the table (error 5e-7); beyond its end falling as 1/k, the slowest that the
    transform of a spectrum cut off at an edge of the grid can fall.

    References
    ----------
    Physics page, section 8.
    """
    place = np.abs(k) / table.step
    if isinstance(table, SpreadTable) and table.index_rms == 0.0:
        return np.ones_like(place)[()]
    magnitude = table.least_so_far if falling else table.magnitude
    size, first = (table.size, table.first) if isinstance(table, SpreadRows) else (magnitude.size, 0)
    last = size - 1
    inside = np.minimum(place, float(last))
    below = np.minimum(np.asarray(inside).astype(np.int64), last - 1)
    value = magnitude[below + first]
    value = value + (inside - below) * (magnitude[below + (first + 1)] - value)
    return (value * (last / np.maximum(place, last)))[()]


def _shares(electrons: Array) -> Array:
    """Electrons over their sum; all 0 if there are none."""
    total = float(np.sum(electrons))
    return electrons / total if total > 0.0 else np.zeros_like(electrons)


def _transform_magnitude(n_k: int, step: float, wavelength: Array, density: Array, index: Array) -> Array:
    """|integral of density exp(i k n)| / integral of density at k = 0, step, 2 step ..., of n_k values.

    Density and index are linear in each segment: four Gauss nodes there, wide ones cut in pieces. Each
    node's electrons are shared by the two neighbours of an even grid in n, a triangle whose transform
    sinc^2(k d/2) is divided out again; what aliases is under (k d / 2 pi)^2 / 6, with k d at most 0.072.
    """
    pieces = max(1, int(np.ceil(n_k * step * np.abs(np.diff(index)).max() / _MOST_PHASE)))
    if pieces > 1:
        at = np.arange(pieces * (wavelength.size - 1) + 1) / pieces
        wavelength, density, index = (
            np.interp(at, np.arange(wavelength.size), part) for part in (wavelength, density, index)
        )
    nodes, weights = np.polynomial.legendre.leggauss(4)
    share = 0.5 * (nodes + 1.0)[:, np.newaxis]
    electrons = ((density[:-1] + share * np.diff(density)) * np.diff(wavelength) * 0.5 * weights[:, np.newaxis]).ravel()
    place = (index[:-1] + share * np.diff(index)).ravel()
    cell, rest = np.divmod((place - place.min()) * (step / _TURN), 1.0)
    below = cell.astype(np.int64)
    grid = np.bincount(below, electrons * (1.0 - rest), minlength=below.max() + 2)
    grid += np.bincount(below + 1, electrons * rest, minlength=grid.size)
    return _chirp_magnitude(grid, n_k) / (_triangle(n_k) * electrons.sum())


@cache
def _triangle(n_k: int) -> Array:
    """sinc^2 of half the phases 0, turn, 2 turn ..., (n_k,)."""
    return np.square(np.sinc(np.arange(n_k) * (0.5 * _TURN / np.pi)))


def _chirp_magnitude(values: Array, n_k: int) -> Array:
    """|sum over m of values[m] exp(i j m turn)| at j = 0 ... n_k - 1, values (n,) -> (n_k,).

    By Bluestein's chirp, j m = (j^2 + m^2 - (j - m)^2) / 2: a convolution, and so three Fourier transforms as long as
    values and results together. Errs by 1e-12 of the sum of |values| at j m turn to 1e6. Bluestein, IEEE Trans. Audio
    Electroacoust. 18, 451 (1970).
    """
    length = 1 << (n_k + values.size - 1).bit_length()
    phase = 0.5 * _TURN * np.square(np.arange(values.size, dtype=float))
    spread = np.fft.fft(values * np.exp(1j * phase), length)
    return np.abs(np.fft.ifft(spread * _chirp_transform(length, n_k))[:n_k])


@lru_cache(maxsize=4)
def _chirp_transform(length: int, n_k: int) -> Array:
    """Transform of exp(-i turn m^2 / 2), m from n_k - length to n_k - 1 around a circle, (length,)."""
    place = np.arange(length, dtype=float)
    place[n_k:] -= length
    return np.asarray(np.fft.fft(np.exp(-0.5j * _TURN * np.square(place))))
