"""The lens: brightness of its image, and which distances it shows sharply.

Depth of field is written in dioptres, D = 1/s with s the object distance in air (the port's virtual
image, see `uwopt.model.port`): a thin lens focused at D is sharp on the symmetric interval D - delta to
D + delta, exactly. What a port does to distances is monotone in D, so every question about depth of
field in water has a closed form. Functions marked [sym] also take CasADi scalars.

All formulas for depth of field hold for f D < 1: the object lies farther away than the focal length.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from uwopt.model.port import FocusMap, lens_dioptre_per_m, water_distance_m

Numeric = Any  # float, array that broadcasts, or (where marked [sym]) a CasADi scalar

AIRY_FACTOR = 2.44  # diameter of the first dark ring over lambda N: 2 * 3.8317 / pi, rounded as usual
_SMALLEST_REACH = 1e-30  # stands in for 1 - f D <= 0 where the answer is replaced by inf


# ---------------------------------------------------------------- brightness


def magnification(focal_length_m: Numeric, *, object_distance_m: Numeric) -> Numeric:
    """Size of the image over size of the object, m = f / (s - f), for s > f; 0 at s = inf [sym]."""
    return focal_length_m / (object_distance_m - focal_length_m)


def working_f_number(f_number: Numeric, *, focal_length_m: Numeric, object_distance_m: Numeric) -> Numeric:
    """F-number that the image sees when the lens is focused near, N_w = N (1 + m) = N s / (s - f).

    Symmetric lens (pupil magnification 1). Arguments broadcast [sym]. Physics page, section 5.
    """
    return f_number * (1.0 + magnification(focal_length_m, object_distance_m=object_distance_m))


def cos4_field(tan_air_x: Numeric, tan_air_y: Numeric) -> Numeric:
    """Natural fall-off cos^4 of the angle in air: 1 / (1 + tan_x^2 + tan_y^2)^2 [sym]."""
    return 1.0 / (1.0 + tan_air_x**2 + tan_air_y**2) ** 2


def image_irradiance(radiance: Numeric, *, transmission: Numeric, working_f_number: Numeric) -> Numeric:
    """Irradiance of the image of an extended source on the axis; `cos4_field` of it elsewhere.

        E_I = (pi / 4) L T_lens / N_w^2                                                              (4) [sym]

    Parameters
    ----------
    radiance : (...,) [W m^-2 sr^-1, or per nm], in the air before the lens: T_port L_water / n_w^2
    transmission : broadcast, T_lens, 0..1
    working_f_number : broadcast, N (1 + m)

    Returns
    -------
    (...,) [W m^-2, or per nm].

    Notes
    -----
    Small-aperture form: exact for a lens that obeys the sine condition focused at infinity. No vignetting.

    References
    ----------
    Physics page, section 5.
    """
    return (np.pi / 4.0) * radiance * transmission / working_f_number**2


def airy_diameter_m(wavelength_nm: Numeric, *, working_f_number: Numeric) -> Numeric:
    """Diameter of the first dark ring of the diffraction disc on the sensor, 2.44 lambda N_w [sym]."""
    return AIRY_FACTOR * wavelength_nm * 1e-9 * working_f_number


# ---------------------------------------------------------------- depth of field in air


def half_depth_per_m(
    f_number: Numeric,
    *,
    focal_length_m: Numeric,
    circle_of_confusion_m: Numeric,
    focus_dioptre_per_m: Numeric,
) -> Numeric:
    """Half the depth of field, in dioptres.

        delta = N c (1 - f D) / f^2                                                                  (9) [sym]

    Parameters
    ----------
    f_number : (...,) N
    focal_length_m, circle_of_confusion_m : broadcast [m], f and the largest blur disc c on the sensor
    focus_dioptre_per_m : broadcast [1/m], D = 1/s; f D < 1

    Returns
    -------
    (...,) [1/m]: sharp from D - delta to D + delta.

    Notes
    -----
    Thin lens, no approximation: the same as s (H - f) / (H -+ s ...) with H = f^2/(N c) + f.

    References
    ----------
    Physics page, section 7 (9).
    """
    reach = 1.0 - focal_length_m * focus_dioptre_per_m
    return f_number * circle_of_confusion_m * reach / focal_length_m**2


def near_far_dioptre_per_m(
    f_number: Numeric,
    *,
    focal_length_m: Numeric,
    circle_of_confusion_m: Numeric,
    focus_dioptre_per_m: Numeric,
) -> tuple[Numeric, Numeric]:
    """Near and far end of the depth of field in dioptres, D + delta and D - delta (may be < 0) [sym]."""
    half = half_depth_per_m(
        f_number,
        focal_length_m=focal_length_m,
        circle_of_confusion_m=circle_of_confusion_m,
        focus_dioptre_per_m=focus_dioptre_per_m,
    )
    return focus_dioptre_per_m + half, focus_dioptre_per_m - half


def blur_disc_m(
    dioptre_per_m: Numeric, *, f_number: Numeric, focal_length_m: Numeric, focus_dioptre_per_m: Numeric
) -> Numeric:
    """Diameter on the sensor of the blur disc of a point at another dioptre than the focus.

        disc = f^2 / (N (1 - f D)) |D_point - D|                                                     [sym]

    Equal to the circle of confusion at both ends of the depth of field. Arguments broadcast; thin lens,
    geometric optics. Physics page, sections 4 and 7 (9).
    """
    reach = 1.0 - focal_length_m * focus_dioptre_per_m
    return focal_length_m**2 / (f_number * reach) * np.abs(dioptre_per_m - focus_dioptre_per_m)


# ---------------------------------------------------------------- depth of field in water


def near_far_water_m(
    f_number: Numeric,
    *,
    focal_length_m: Numeric,
    circle_of_confusion_m: Numeric,
    focus_dioptre_per_m: Numeric,
    focus_map: FocusMap,
) -> tuple[Numeric, Numeric]:
    """Depth of field in water: nearest and farthest sharp distance from the port.

        q_near = q(D + delta),   q_far = q(D - delta),   q the port's focus map                      (9) [sym]

    Parameters
    ----------
    f_number, focal_length_m, circle_of_confusion_m, focus_dioptre_per_m : as in `half_depth_per_m`
    focus_map : of the port, see `uwopt.model.port`

    Returns
    -------
    near, far : (...,) [m]; far is inf where the lens is sharp to infinity, near 0 where sharp up to the port.

    References
    ----------
    Physics page, section 7 (9).
    """
    near_per_m, far_per_m = near_far_dioptre_per_m(
        f_number,
        focal_length_m=focal_length_m,
        circle_of_confusion_m=circle_of_confusion_m,
        focus_dioptre_per_m=focus_dioptre_per_m,
    )
    near_m = water_distance_m(near_per_m, focus_map=focus_map)
    return near_m, water_distance_m(far_per_m, focus_map=focus_map)


def focus_for_interval(near_dioptre_per_m: Numeric, *, far_dioptre_per_m: Numeric) -> Numeric:
    """Focus that covers an interval with the least stopping down: its dioptric middle [sym].

    In distances the harmonic mean, s = 2 s_n s_f / (s_n + s_f). Physics page, section 7.
    """
    return 0.5 * (near_dioptre_per_m + far_dioptre_per_m)


def _f_number_or_inf(
    half_per_m: Numeric,
    *,
    focal_length_m: Numeric,
    circle_of_confusion_m: Numeric,
    focus_dioptre_per_m: Numeric,
) -> Numeric:
    """F-number of a half depth, delta f^2 / (c (1 - f D)): inf where the focus lies at or within the focal length."""
    reach = 1.0 - focal_length_m * focus_dioptre_per_m
    open_reach = np.maximum(reach, _SMALLEST_REACH)
    f_number = half_per_m * focal_length_m**2 / (circle_of_confusion_m * open_reach)
    return np.where(reach > 0.0, f_number, np.inf)[()]


def f_number_to_cover(
    near_dioptre_per_m: Numeric,
    *,
    far_dioptre_per_m: Numeric,
    focal_length_m: Numeric,
    circle_of_confusion_m: Numeric,
) -> Numeric:
    """Smallest f-number that is sharp over an interval of dioptres, the focus being free.

        N = (f^2 / c) (D_n - D_f)/2 / (1 - f (D_n + D_f)/2)

    Parameters
    ----------
    near_dioptre_per_m, far_dioptre_per_m : broadcast [1/m], D_n >= D_f, of what must be sharp through the
        port's map; of several scenes the largest D_n and the smallest D_f
    focal_length_m, circle_of_confusion_m : broadcast [m]

    Returns
    -------
    (...,) with the focus at `focus_for_interval`; inf where the lens cannot focus so near.

    Notes
    -----
    For a focus D inside the interval the near end asks for (D_n - D)/(1 - f D), which falls with D, the far
    end for (D - D_f)/(1 - f D), which rises: they meet at the least N, in the middle.

    References
    ----------
    Physics page, section 7.
    """
    return _f_number_or_inf(
        0.5 * (near_dioptre_per_m - far_dioptre_per_m),
        focal_length_m=focal_length_m,
        circle_of_confusion_m=circle_of_confusion_m,
        focus_dioptre_per_m=focus_for_interval(near_dioptre_per_m, far_dioptre_per_m=far_dioptre_per_m),
    )


def f_number_to_reach(
    near_dioptre_per_m: Numeric,
    *,
    far_dioptre_per_m: Numeric,
    focus_dioptre_per_m: Numeric,
    focal_length_m: Numeric,
    circle_of_confusion_m: Numeric,
) -> Numeric:
    """Smallest f-number that is sharp over an interval of dioptres, for a given focus.

        N = (f^2 / c) max(D_n - D, D - D_f) / (1 - f D)

    Arguments broadcast, [1/m] and [m]. Returns (...,), 0 or less where the interval is the focus itself; inf where
    f D >= 1. Physics page, section 7.
    """
    return _f_number_or_inf(
        np.maximum(near_dioptre_per_m - focus_dioptre_per_m, focus_dioptre_per_m - far_dioptre_per_m),
        focal_length_m=focal_length_m,
        circle_of_confusion_m=circle_of_confusion_m,
        focus_dioptre_per_m=focus_dioptre_per_m,
    )


def half_depth_for_length_per_m(
    focus_dioptre_per_m: Numeric, *, min_dof_m: Numeric, focus_map: FocusMap
) -> Numeric:
    """Half depth in dioptres whose depth of field in water has a wanted length, for a given focus.

        q(D - delta) - q(D + delta) = 2 g delta / (E^2 - delta^2) = L,   E = D - infinity, g = scale
        delta = L E^2 / (g + sqrt(g^2 + L^2 E^2))                                                    [sym]

    the root of L delta^2 + 2 g delta - L E^2 = 0 between 0 and E, written without cancellation.
    Arguments broadcast, [1/m] and [m]; 0 for a focus at or beyond the image of infinity, whose depth of
    field has no end. Physics page, section 7.
    """
    excess_per_m = np.maximum(focus_dioptre_per_m - focus_map.infinity_per_m, 0.0)
    stretch = min_dof_m * excess_per_m
    return stretch * excess_per_m / (focus_map.scale + np.sqrt(focus_map.scale**2 + stretch**2))


def f_number_for_interval(
    focus_dioptre_per_m: Numeric,
    *,
    near_m: Numeric,
    far_m: Numeric,
    min_dof_m: Numeric,
    focal_length_m: Numeric,
    circle_of_confusion_m: Numeric,
    focus_map: FocusMap,
) -> Numeric:
    """Smallest f-number whose depth of field in water meets three wishes, for a given focus.

        near end <= near_m,   far end >= far_m,   far end - near end >= min_dof_m

    Parameters
    ----------
    focus_dioptre_per_m : (...,) [1/m], D
    near_m, far_m : broadcast [m] from the port, > 0; far_m may be inf
    min_dof_m : broadcast [m], finite, >= 0
    focal_length_m, circle_of_confusion_m : broadcast [m]
    focus_map : of the port; fields broadcast

    Returns
    -------
    (...,) f-number, may be below any real stop; inf where f D >= 1.

    Notes
    -----
    The largest of three half depths: D(near_m) - D, D - D(far_m), and that of
    `half_depth_for_length_per_m`. Water ends at the port, so far >= min_dof_m is part of the third wish.

    References
    ----------
    Physics page, section 7 (9).
    """
    far_end_m = np.maximum(far_m, min_dof_m)
    to_near_per_m = lens_dioptre_per_m(near_m, focus_map=focus_map) - focus_dioptre_per_m
    to_far_per_m = focus_dioptre_per_m - lens_dioptre_per_m(far_end_m, focus_map=focus_map)
    length_per_m = half_depth_for_length_per_m(focus_dioptre_per_m, min_dof_m=min_dof_m, focus_map=focus_map)
    half_per_m = np.maximum(np.maximum(to_near_per_m, to_far_per_m), length_per_m)
    return _f_number_or_inf(
        half_per_m,
        focal_length_m=focal_length_m,
        circle_of_confusion_m=circle_of_confusion_m,
        focus_dioptre_per_m=focus_dioptre_per_m,
    )
