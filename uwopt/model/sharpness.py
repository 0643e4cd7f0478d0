"""Sharpness: how much of a detail's contrast arrives in the pixels, and what detail costs on the ground.

The modulation transfer of the image-forming light is a product of factors, each a function of the
frequency nu in cycles per pixel: pixel, diffraction, motion, defocus, lens, lateral colour. The
first five are 1 at nu = 0, fall, and are 0 beyond their first null, so that they are monotone in frequency
and in their cause: contrast that comes back with reversed sign is no resolution. Lateral colour has no
null but humps; where a falling transfer is needed its least value so far counts. Light scattered forward counts as a
veil and has no factor in the transfer; what detail shows in it all the same is a factor of its own (`detail`) on the
contrast in all light.

"Along" is the direction of motion, "across" the other. Functions marked [sym] also take CasADi scalars;
beyond a null "0" means below 1e-15, so that derivatives stay finite there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.model.falling_root import falling_roots
from uwopt.model.lateral import SpreadRows, SpreadTable, spread_mtf

Numeric = Any  # float, array that broadcasts, or (where marked [sym]) a CasADi scalar
Gain = Callable[[Array], Array]  # a factor by frequency [cycles per px]
GainOfSome = Callable[[Array, Array], Array]  # the same by frequency (m,), and of which designs it is

RESOLVED_CONTRAST = 0.1  # of bars that count as resolved, of all light that arrives (MTF10)
#: SNR from which a tenth of the light equals a pixel's noise. Two bars of n pixels then differ by sqrt(2 n) times the
#: noise of their means, Rose's 5 for n = 12.5: bars 1.6 px wide and, as on the USAF chart, five times as long.
RESOLVED_SNR = 1.0 / RESOLVED_CONTRAST
NYQUIST_CYC_PER_PX = 0.5
HALF_NYQUIST_CYC_PER_PX = 0.25

# First zero of J1. Source: Abramowitz and Stegun, table 9.5.
J1_ZERO = 3.8317059702075123
# Both transforms as their first factor times an entire function g of u = (x / first zero)^2, interpolated in
# the Chebyshev nodes of 0 <= u <= 1 with 40 digits (mpmath.chebyfit); errors under 5e-16 and exactly 0 at the null:
# sin(x)/x = (1 - u) (g0 + g1 u + ... + g9 u^9), first zero pi
_SINC = (
    1.0,
    -0.6449340668482253,
    0.166808358435089,
    -0.023943465686467654,
    0.0022043821275129897,
    -0.0001416988928454464,
    6.729861121066238e-06,
    -2.45947023644184e-07,
    7.1034871836109255e-09,
    -1.5264822109561645e-10,
)
# 2 J1(x)/x = (1 - u) (g0 + g1 u + ... + g9 u^9), first zero J1_ZERO
_JINC = (
    1.0,
    -0.8352463302654585,
    0.28746336731789346,
    -0.055944774743414395,
    0.007079078419381147,
    -0.0006318742384973343,
    4.2005674928998e-05,
    -2.1619128140998263e-06,
    8.804238184890142e-08,
    -2.5918481989620593e-09,
)

_BEFORE_CUTOFF = 1.0 - 1e-12  # of a frequency over the cut-off: acos has an infinite slope at 1
_HUGE = 1e300  # a blur that is called infinite: 0 at every frequency but 0
_BLOCK_ROOTS = 12_000  # frequencies that are looked for together, so that arrays stay in the cache


# ---------------------------------------------------------------- factors


def sinc_mtf(frequency_cyc_per_px: Numeric, *, width_px: Numeric = 1.0) -> Numeric:
    """Transfer of a box: of the pixel (width 1, 100 % fill), or of uniform motion.

        MTF = |sin(pi nu w) / (pi nu w)|, 0 from nu w = 1 on                                         [sym]

    frequency_cyc_per_px : (...,), either sign; width_px : broadcast [px], >= 0. Returns (...,) 0..1.
    Physics page, section 8.
    """
    return _to_first_null(frequency_cyc_per_px * np.minimum(width_px, _HUGE), _SINC)


def diffraction_mtf(frequency_cyc_per_px: Numeric, *, cycle_px: Numeric) -> Numeric:
    """Transfer of a perfect lens with a circular pupil, incoherent light.

        MTF = (2/pi) (acos s - s sqrt(1 - s^2)),   s = nu lambda N_w / p, 0 from s = 1 on            [sym]

    frequency_cyc_per_px : (...,) >= 0; cycle_px : broadcast [px], lambda N_w / p, the period at the cut-off
    (`Sharpness.diffraction_px`). Returns (...,) 0..1. Goodman, Introduction to Fourier Optics, section 6.3.
    """
    s = np.minimum(frequency_cyc_per_px * np.minimum(cycle_px, _HUGE), _BEFORE_CUTOFF)
    return (2.0 / np.pi) * (np.arccos(s) - s * np.sqrt(1.0 - s**2))


def defocus_mtf(frequency_cyc_per_px: Numeric, *, disc_px: Numeric) -> Numeric:
    """Transfer of a uniform disc, the geometric image of a point out of focus.

        MTF = |2 J1(pi c nu) / (pi c nu)|, 0 from the first zero on, c nu = 1.2197                   [sym]

    frequency_cyc_per_px : (...,) >= 0; disc_px : broadcast [px], diameter c >= 0. Returns (...,) 0..1.
    Physics page, section 8.
    """
    return _to_first_null(np.pi / J1_ZERO * frequency_cyc_per_px * np.minimum(disc_px, _HUGE), _JINC)


def lens_mtf(frequency_cyc_per_px: Numeric, *, lens_pitch_px: Numeric) -> Numeric:
    """Transfer of a lens that is good for a pixel pitch: one half at the Nyquist frequency of that pitch.

        MTF = 0.5^((nu / nu_r)^2),   nu_r = 1 / (2 pitch)                                            [sym]

    frequency_cyc_per_px : (...,); lens_pitch_px : broadcast, of `aberration.lens_pitch` over the camera's pitch;
    the factor is 1 at 0. Returns (...,) 0..1. An assumption: makers do not say what a rating means.
    Physics page, section 8.
    """
    return np.exp(-np.log(2.0) * (2.0 * frequency_cyc_per_px * lens_pitch_px) ** 2)


def _to_first_null(ratio: Numeric, coefficients: tuple[float, ...]) -> Numeric:
    """(1 - u) g(u) with u the square of a frequency over its first null, held at 1 from there on [sym]."""
    u = np.minimum(np.abs(ratio), 1.0) ** 2
    value = coefficients[-1] * u + coefficients[-2]
    for coefficient in coefficients[-3::-1]:
        value *= u  # in place where it is an array
        value += coefficient
    return (1.0 - u) * value


def sinc_and_slope(cycles: Array) -> tuple[Array, Array]:
    """`sinc_mtf` and the slope of its logarithm in ln of its argument; (0, some number) from the first null on.

    cycles : (...,) nu w, frequency times width, >= 0. Returns (...,), (...,). Physics page, section 8.
    """
    return _with_slope(cycles, _SINC)


def jinc_and_slope(cycles: Array) -> tuple[Array, Array]:
    """`defocus_mtf` and the slope of its logarithm in ln of its argument; (0, some number) from the first null on.

    cycles : (...,) nu c, frequency times diameter, >= 0. Returns (...,), (...,). Physics page, section 8.
    """
    return _with_slope(cycles * (np.pi / J1_ZERO), _JINC)


def pupil_and_slope(cycles: Array) -> tuple[Array, Array]:
    """`diffraction_mtf` and the slope of its logarithm in ln of its argument; (0, some number) from the cut-off on.

    cycles : (...,) frequency times the period at the cut-off, >= 0. Returns (...,), (...,). Physics page, section 8.
    """
    s = np.minimum(cycles, _BEFORE_CUTOFF)
    root = np.sqrt(1.0 - s**2)
    value = (2.0 / np.pi) * (np.arccos(s) - s * root)
    return value, (-4.0 / np.pi) * s * root / np.maximum(value, 1e-30)


def _with_slope(ratio: Array, coefficients: tuple[float, ...]) -> tuple[Array, Array]:
    """`_to_first_null` of a ratio >= 0 with d ln value / d ln ratio: (1 - u) g(u), by Horner's rule for g and g'."""
    u = np.square(np.minimum(ratio, 1.0))
    value = np.full_like(u, coefficients[-1])
    rising = np.zeros_like(u)
    for coefficient in coefficients[-2::-1]:
        rising *= u
        rising += value
        value *= u
        value += coefficient
    left = 1.0 - u
    slope = 2.0 * u * (rising / value - 1.0 / np.maximum(left, 1e-300))
    return left * value, slope


# ---------------------------------------------------------------- product


@dataclass(frozen=True)
class Sharpness:
    """All that decides the transfer at one field point; numbers or arrays over designs that broadcast.

    Lateral colour smears along the radius from the image's centre. Its k per cycle per px,
    2 pi `lateral.radius_slope_px`, is given as a vector: times the radius's direction along and across.
    """

    working_f_number: Numeric
    wavelength_nm: Numeric  # electron-weighted mean
    pixel_pitch_m: Numeric
    motion_blur_px: Numeric = 0.0  # along
    defocus_px: Numeric = 0.0  # diameter of the blur disc
    lens_pitch_px: Numeric = 0.0  # pitch the lens is good for over the camera's; 0: it blurs nothing
    lateral_k_along: Numeric = 0.0
    lateral_k_across: Numeric = 0.0
    spread: SpreadTable | SpreadRows | None = None  # shared by all designs, or one a row; None: no lateral colour

    @property
    def diffraction_px(self) -> Numeric:
        """Period of the finest detail that passes the pupil, lambda N_w / p [px] [sym]."""
        return self.working_f_number * (self.wavelength_nm * 1e-9 / self.pixel_pitch_m)


def round_mtf(frequency_cyc_per_px: Numeric, *, sharpness: Sharpness) -> Numeric:
    """Product of the factors that are the same in all directions: diffraction, defocus, lens [sym].

    frequency_cyc_per_px : (...,) >= 0, broadcast with the fields; returns 0..1. Physics page, section 8.
    """
    return (
        diffraction_mtf(frequency_cyc_per_px, cycle_px=sharpness.diffraction_px)
        * defocus_mtf(frequency_cyc_per_px, disc_px=sharpness.defocus_px)
        * lens_mtf(frequency_cyc_per_px, lens_pitch_px=sharpness.lens_pitch_px)
    )


def mtf(along_cyc_per_px: Numeric, *, across_cyc_per_px: Numeric, sharpness: Sharpness) -> Numeric:
    """Transfer of the whole chain at a frequency vector.

        MTF = sinc(nu_al) sinc(nu_ac) sinc(b nu_al) D(|nu|) B(|nu|) R(|nu|) |Phi(k . nu)|            [sym]

    along_cyc_per_px, across_cyc_per_px : (...,), broadcast with the fields of sharpness. Returns (...,) 0..1. [sym]
    without `spread`. Physics page, section 8.
    """
    frequency = np.sqrt(along_cyc_per_px**2 + across_cyc_per_px**2)
    value = round_mtf(frequency, sharpness=sharpness) * sinc_mtf(along_cyc_per_px)
    value = value * sinc_mtf(across_cyc_per_px)
    value = value * sinc_mtf(along_cyc_per_px, width_px=sharpness.motion_blur_px)
    if sharpness.spread is None:
        return value
    k = sharpness.lateral_k_along * along_cyc_per_px + sharpness.lateral_k_across * across_cyc_per_px
    return value * spread_mtf(k, table=sharpness.spread)


def mtf_axes(
    frequency_cyc_per_px: Numeric, *, sharpness: Sharpness, falling: bool = False
) -> tuple[Numeric, Numeric]:
    """Transfer of detail along and across the motion, 0..1, with what both share worked out once [sym]."""
    still = round_mtf(frequency_cyc_per_px, sharpness=sharpness) * sinc_mtf(frequency_cyc_per_px)
    moved = still * sinc_mtf(frequency_cyc_per_px, width_px=sharpness.motion_blur_px)
    if sharpness.spread is None:
        return moved, still
    along, across = (
        spread_mtf(k * frequency_cyc_per_px, table=sharpness.spread, falling=falling)
        for k in (sharpness.lateral_k_along, sharpness.lateral_k_across)
    )
    return moved * along, still * across


def mtf_half_nyquist(sharpness: Sharpness) -> Numeric:
    """Transfer at 0.25 cycles per px, the worse of along and across, 0..1 [sym]. Physics page, section 12."""
    return np.minimum(*mtf_axes(HALF_NYQUIST_CYC_PER_PX, sharpness=sharpness))


# ---------------------------------------------------------------- frequencies of a level


def highest_frequency_cyc_per_px(
    level: Numeric, *, sharpness: Sharpness, detail: GainOfSome | None = None, most_cyc_per_px: float = 1.0
) -> Array:
    """The highest frequency at which the transfer along and that across both reach a level.

        F(nu) min(MTF_along(nu), MTF_across(nu)) = level

    Parameters
    ----------
    level : broadcast, > 0
    sharpness : fields broadcast to (...,)
    detail : F, a factor that falls with the frequency; None: 1
    most_cyc_per_px : higher ones are not looked for; 1: the first null of the pixel

    Returns
    -------
    (...,) [cycles per px]; 0 where the blur is infinite or the level F(0) or more. Relative error 1e-12.

    Notes
    -----
    Both fall, so the lesser of them does, from F(0) to 0 between nu = 0 and the first null: one root, held between two
    bounds by false position after Illinois, every fourth step a bisection.
    """
    shape = common_shape(sharpness, level)
    flat, level, still, null = _falling_ranges(level, sharpness, shape, detail)

    def left(nu: Array, some: Array) -> Array:
        both = np.minimum(*mtf_axes(nu, sharpness=_some(flat, some), falling=True))
        return np.asarray(both if detail is None else both * detail(nu, some))

    ends, found = np.minimum(null, most_cyc_per_px), np.empty(len(level))
    for start in range(0, len(level), _BLOCK_ROOTS):
        rows = np.arange(start, min(start + _BLOCK_ROOTS, len(level)))

        def of_block(nu: Array, some: Array, rows: Array = rows) -> Array:
            return left(nu, rows[some])

        end = ends[rows]
        found[rows] = falling_roots(
            of_block, level=level[rows], start=still[rows], end=end, at_end=np.where(end > 0.0, left(end, rows), 0.0)
        )
    return found.reshape(shape)[()]


def _falling_ranges(
    level: Numeric, sharpness: Sharpness, shape: tuple[int, ...], detail: GainOfSome | None
) -> tuple[Sharpness, Array, Array, Array]:
    """Columns (n,) of all, levels that are reached, F(0), and where the first transfer ends; 0: level missed."""
    flat = as_columns(sharpness, shape, (-1,))
    level = np.broadcast_to(np.asarray(level, dtype=float), shape).reshape(-1)
    disc_null = 1.0 / np.maximum(np.minimum(flat.defocus_px, _HUGE) * (np.pi / J1_ZERO), 1.0)
    pupil_null = 1.0 / np.maximum(np.minimum(flat.diffraction_px, _HUGE), 1.0)
    motion_null = 1.0 / np.maximum(np.minimum(flat.motion_blur_px, _HUGE), 1.0)
    null = np.minimum(np.minimum(disc_null, pupil_null), motion_null)
    still = np.ones(len(level)) if detail is None else detail(np.zeros(len(level)), np.arange(len(level)))
    return flat, np.minimum(level, still), still, np.where((null > 2.0 / _HUGE) & (level < still), null, 0.0)


def mtf50_cyc_per_px(sharpness: Sharpness) -> Array:
    """Frequency at which half the contrast is left, the worse of along and across [cycles per px]."""
    return highest_frequency_cyc_per_px(0.5, sharpness=sharpness)


def smallest_bars_m(
    sharpness: Sharpness, *, contrast: Numeric, ground_sample_m: Numeric, detail: GainOfSome | None = None
) -> Array:
    """Narrowest bars on the floor of which a tenth of the contrast arrives, veil counted.

        b = GSD / (2 nu),   nu the highest at which C F MTF is 0.1 at least, 1/2 at most

    sharpness : fields (...,); contrast : broadcast, C, image-forming over all light; ground_sample_m : broadcast [m per
    px]; detail : F by frequency, what bars have in light scattered forward (`detail.detail_gain`), falling, 1 without.
    Returns (...,) [m], the width of one bar, the worse of along and across; inf where nothing is resolved. Bars
    are no narrower than a pixel: below, the image shows aliases. The transfer is that of a sine; black and white
    bars, whose first harmonic is 4 / pi, have more.
    """
    with np.errstate(divide="ignore", over="ignore"):
        level = RESOLVED_CONTRAST / np.asarray(contrast, dtype=float)
        highest = highest_frequency_cyc_per_px(
            level, sharpness=sharpness, detail=detail, most_cyc_per_px=NYQUIST_CYC_PER_PX
        )
        return np.asarray(ground_sample_m / (2.0 * highest))


def resolution_10_m(sharpness: Sharpness, *, ground_sample_m: Numeric) -> Array:
    """Smallest detail with a tenth of its contrast left: the ground length of one full cycle.

        resolution = GSD / nu_10, the worse of along and across

    sharpness : fields (...,); ground_sample_m : broadcast [m per px] at the field point. Returns (...,) [m], a
    dark and a bright stripe together (a line pair); inf where nothing is resolved. Frequencies beyond Nyquist count
    as such: below 2 px per cycle the image shows aliases. Physics page, section 12.
    """
    with np.errstate(divide="ignore", over="ignore"):
        return np.asarray(ground_sample_m / highest_frequency_cyc_per_px(0.1, sharpness=sharpness))


NUMBERS = tuple(field.name for field in fields(Sharpness) if field.name != "spread")  # all but the spread by colour


def common_shape(sharpness: Sharpness, *others: Numeric) -> tuple[int, ...]:
    """Common shape of the fields that are numbers, and of others: (...,), as they broadcast [sizes]."""
    numbers = [getattr(sharpness, name) for name in NUMBERS]
    return np.broadcast_shapes(*(np.shape(number) for number in (*numbers, *others)))


def as_columns(sharpness: Sharpness, shape: tuple[int, ...], into: tuple[int, ...]) -> Sharpness:
    """All designs of a shape as columns of another, each [unit] its own."""
    columns = {
        name: np.broadcast_to(np.asarray(getattr(sharpness, name), dtype=float), shape).reshape(into)
        for name in NUMBERS
    }
    return Sharpness(**columns, spread=sharpness.spread)


def _some(table: Sharpness, rows: Array) -> Sharpness:
    """Some designs of a table of columns; spreads of rows are taken with them."""
    spread = table.spread
    return sharpness_rows(table, rows, spread=spread.take(rows) if isinstance(spread, SpreadRows) else spread)


def sharpness_rows(table: Sharpness, rows: Array, *, spread: SpreadTable | SpreadRows | None) -> Sharpness:
    """Some designs of a table of columns, by their rows (m,) [numbers]."""
    return Sharpness(**{name: getattr(table, name)[rows] for name in NUMBERS}, spread=spread)
