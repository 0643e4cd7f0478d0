"""Defocus over the image: a port shows the flat floor as a curved surface, the lens focuses on a plane.

Everything is in dioptres of the axial distance z from the entrance pupil, 1/z: a distortion-free lens
focused at D images a point at 1/z as a disc of diameter f^2 / (N (1 - f D)) |1/z - D|, wherever in the field.
A dome's image is curved but, by symmetry about its centre, free of astigmatism; a flat port's image is
curved less and astigmatic. Functions marked [sym] also take CasADi scalars.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uwopt.model.lens import blur_disc_m
from uwopt.model.port import FocusMap, bend, field_dioptre_per_m, flat_floor_derivative, lens_dioptre_per_m

Numeric = Any  # float, array that broadcasts, or (where marked [sym]) a CasADi scalar


# ---------------------------------------------------------------- where the image of the floor lies


def flat_field_dioptres_per_m(
    range_m: Numeric,
    *,
    tan_air: Numeric,
    gap_m: Numeric,
    thickness_m: Numeric,
    n_glass: Numeric,
    n_water: Numeric,
) -> tuple[Numeric, Numeric]:
    """Axial dioptres of a flat floor's two images behind a flat port, at a field angle.

        z_t = dx / d tan a = e + t_g tan_g' + d tan_w'
        z_s = x / tan a    = e + t_g tan_g / tan_a + d tan_w / tan_a                                 [sym]

    Parameters
    ----------
    range_m : (...,) [m], d, from the outer face to the floor
    tan_air : broadcast, tangent of the chief ray's angle in air
    gap_m, thickness_m, n_glass, n_water : broadcast, as in `port.flat_floor_distance_m`

    Returns
    -------
    tangential, sagittal : (...,) [1/m], 1/z_t and 1/z_s; on the axis both `port.lens_dioptre_per_m`.
    The tangential image blurs along the radius, the sagittal one across it.

    Notes
    -----
    Exact for narrow pencils. A ray's height over the floor point, produced backwards in air, is
    x - z tan a: neighbouring rays of the meridional fan cross where its derivative is 0; a sagittal fan
    turns about the normal through the floor point, and the chief ray meets that normal at x / tan a.

    References
    ----------
    Physics page, sections 4 and 8; checked by tracing fans.
    """
    tangential_m = flat_floor_derivative(
        tan_air,
        gap_m=gap_m,
        thickness_m=thickness_m,
        n_glass=n_glass,
        n_water=n_water,
        range_m=range_m,
    )
    tan2 = tan_air**2
    glass_m = thickness_m / bend(tan2, n=n_glass)
    water_m = range_m / bend(tan2, n=n_water)
    return 1.0 / tangential_m, 1.0 / (gap_m + glass_m + water_m)


# ---------------------------------------------------------------- blur discs


def defocus_px(
    dioptre_per_m: Numeric,
    *,
    f_number: Numeric,
    focal_length_m: Numeric,
    pixel_pitch_m: Numeric,
    focus_dioptre_per_m: Numeric,
) -> Numeric:
    """Diameter of the blur disc in pixels.

        c = f^2 / (N (1 - f D)) |1/z - D| / p                                                        [sym]

    Parameters
    ----------
    dioptre_per_m : (...,) [1/m], 1/z of the point's image at the entrance pupil
    f_number : broadcast, N as engraved, not the working one: the bracket holds the extension
    focal_length_m, pixel_pitch_m : broadcast [m]
    focus_dioptre_per_m : broadcast [1/m], D

    Returns
    -------
    (...,) [px]. Geometric optics: use it beside the diffraction factor.

    References
    ----------
    Physics page, sections 4 and 8 (there without the bracket: 5 % less for 8 mm behind R = 50 mm).
    """
    disc_m = blur_disc_m(
        dioptre_per_m,
        f_number=f_number,
        focal_length_m=focal_length_m,
        focus_dioptre_per_m=focus_dioptre_per_m,
    )
    return disc_m / pixel_pitch_m


# ---------------------------------------------------------------- one focus for centre and corner


# ---------------------------------------------------------------- a pupil that is not at the dome's centre


class Decentring(NamedTuple):
    """What a displaced pupil does at a field point, beyond a shift and a change of scale of the whole image."""

    across_distortion_px: Numeric  # pupil off sideways, in the direction it moved
    axial_distortion_px: Numeric  # pupil off along the axis, radially
    axial_defocus_px: Numeric  # the same: blur beyond what refocusing on the axis takes away


def dome_decentring(
    range_m: Numeric,
    *,
    cos_field: Numeric,
    focus_map: FocusMap,
    f_number: Numeric,
    focal_length_m: Numeric,
    pixel_pitch_m: Numeric,
    displacement_m: Numeric = 1e-3,
) -> Decentring:
    """Distortion and defocus when the entrance pupil is off the dome's centre.

        across: f delta (1/z - 1/z_0) / p,      along: tan theta times that, and
        blur:   f^2 / N delta |1/z^2 - 1/z_0^2| / p,       z_0 = z on the axis                       [sym]

    Parameters
    ----------
    range_m : (...,) [m], of the floor on the axis
    cos_field : broadcast, of the field angle
    focus_map : of `port.dome_focus_map`
    f_number, focal_length_m, pixel_pitch_m : broadcast
    displacement_m : broadcast [m], delta, of the pupil from the centre, across or along the axis

    Returns
    -------
    Decentring, [px] each.

    Notes
    -----
    First order in delta: the dome's image of the floor stays where it is, since it belongs to rays near the
    line through the centre, and the pupil sees it from another place. So a sideways step shifts the image by
    f delta / z, which differs over the field because z does; it neither defocuses nor brings astigmatism to
    this order (both come with delta^2). What the common shift f delta / z_0, the scale and a new focus take up is left
    out. Traced rays (8 mm, R 50 mm, 35 degrees) agree within 3 % at 1 mm; see the tests.

    References
    ----------
    Physics page, section 4.
    """
    edge_per_m = field_dioptre_per_m(range_m, cos_field=cos_field, focus_map=focus_map)
    axis_per_m = lens_dioptre_per_m(range_m, focus_map=focus_map)
    across_px = focal_length_m * displacement_m * (edge_per_m - axis_per_m) / pixel_pitch_m
    tan_field = np.sqrt(1.0 - cos_field**2) / cos_field
    blur_m = focal_length_m**2 / f_number * displacement_m * np.abs(edge_per_m**2 - axis_per_m**2)
    return Decentring(across_px, across_px * tan_field, blur_m / pixel_pitch_m)
