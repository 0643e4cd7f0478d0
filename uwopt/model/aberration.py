"""What lenses do to fine detail beside diffraction: worst wide open and in the corner, better as the iris closes.

A lens's blur is told as a pixel pitch: that at whose Nyquist frequency the lens alone leaves half the contrast, as
a maker's rating does (`sharpness.lens_mtf`). Squares of pitches add up as those of independent blurs do.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Numeric = Any  # float, array that broadcasts, or (where marked [sym]) a CasADi scalar

#: Power of N_min / N in the square of the blur: 2 for field curvature, astigmatism and axial colour (blur as 1/N),
#: 4 for coma, 6 for spherical aberration. Measured on the axis of 30 lenses of F1.8 to 2.8: 3 (2.6 to 3.9), of 9 that
#: open to F1.4 or more: 1.9 (1.6 to 2.1) (docs/lenses.md).
ABERRATION_POWER, FAST_POWER = 3.0, 2.0
FAST_F_NUMBER = 1.6  # a lens that opens wider is a fast one; none of the measured ones stands between 1.4 and 1.8
#: Blur at 80 % of the half diagonal over that on the axis. Measured 1.5 to 2.0 wide open and 1.7 stopped down, makers'
#: centre and edge 160 and 100 lp/mm, 1.6; 1.2 to 3 (docs/lenses.md).
CORNER_BLUR = 1.8


def aberration_exponent(f_number_min: Numeric) -> Numeric:
    """Exponent of N_min / N with which the square of a lens's blur falls.

        P = 2 where N_min < 1.6 (F1.4 and faster), else 3

    f_number_min : broadcast, as engraved. Returns (...,).
    """
    return np.where(np.asarray(f_number_min) < FAST_F_NUMBER, FAST_POWER, ABERRATION_POWER)


def aberration_at_f1(aberration_pitch_m: Numeric, *, f_number_min: Numeric) -> Numeric:
    """Pitch of the aberrations as if the lens opened to F1: what `lens_pitch` scales to any opening.

        q_1 = q_a N_min^(P/2)

    aberration_pitch_m : broadcast [m], wide open on the axis; f_number_min : broadcast. Returns [m]. A number to
    compute with: no lens is used wider than N_min.
    """
    return aberration_pitch_m * f_number_min ** (aberration_exponent(f_number_min) / 2.0)


def lens_pitch(
    rated_pitch_px: Numeric, *, aberration_f1_px: Numeric, f_number: Numeric, exponent: Numeric = ABERRATION_POWER,
    field_blur: Numeric = 1.0,
) -> Numeric:
    """Pixel pitch that a lens is good for at an opening and a field point.

        q = B sqrt(q_r^2 + q_a^2 (N_min / N)^P),   P = 3, of fast lenses 2                            [sym]

    Parameters
    ----------
    rated_pitch_px : broadcast [px], q_r, what the lens is rated for over the camera's pitch; 0 unknown
    aberration_f1_px : broadcast [px], of `aberration_at_f1`, over the camera's pitch
    f_number : broadcast, N as engraved, at least N_min
    exponent : broadcast, P, of `aberration_exponent`
    field_blur : broadcast, B, of `field_blur`

    Returns
    -------
    (...,) [px], falling with N. ln MTF = -ln 2 (2 nu q)^2 is concave in ln N.

    Notes
    -----
    Valid for: the classes of lenses in class_estimates.csv, on average; single lenses differ by their design.
    The same blur along and across: astigmatism is not told apart.

    References
    ----------
    docs/lenses.md: measured MTF50 against aperture, and what it gives.
    """
    return field_blur * np.sqrt(rated_pitch_px**2 + aberration_f1_px**2 * f_number**-exponent)


def field_blur(field_over_corner: Numeric) -> Numeric:
    """How much wider a lens blurs off the axis.

        B = sqrt(1 + (B_c^2 - 1) (h / h_c)^2),   B_c = 1.8 at h_c, 80 % of the half diagonal

    field_over_corner : broadcast, h / h_c >= 0. Returns (...,) 1 on the axis. The square of the blur grows with
    that of the field as the mean of third-order astigmatism and coma does; an assumption between axis and corner.
    """
    return np.sqrt(1.0 + (CORNER_BLUR**2 - 1.0) * field_over_corner**2)
