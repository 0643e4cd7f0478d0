"""Operation: what one image covers on the floor, and how motion limits exposure and frame rate.

Ground distances are along the floor; "along" is the direction of motion, "across" the other. Tangents
are those of the angle in air, u = tan along and v = tan across, at a pixel's place on the sensor
divided by the focal length. Functions marked [sym] also take CasADi scalars.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Numeric = Any  # float, array that broadcasts, or (where marked [sym]) a CasADi scalar

# ---------------------------------------------------------------- coverage


def flat_largest_pixel_m(
    range_m: Numeric,
    *,
    gap_m: Numeric,
    thickness_m: Numeric,
    n_glass: Numeric,
    n_water: Numeric,
    pixel_pitch_m: Numeric,
    focal_length_m: Numeric,
) -> Numeric:
    """Largest floor per pixel behind a flat port, at the centre of the image.

        GSD = (p / f) (e + t_g / n_g + d / n_w)                                                      [sym]

    Parameters
    ----------
    range_m : (...,) [m], d from the outer face
    gap_m, thickness_m : broadcast [m], e and t_g
    n_glass, n_water : broadcast
    pixel_pitch_m, focal_length_m : broadcast [m], the lens's own focal length

    Returns
    -------
    (...,) [m]. Refraction shrinks pixels away from the axis, in both directions.

    References
    ----------
    Physics page, sections 4 and 7.
    """
    return pixel_pitch_m / focal_length_m * (gap_m + thickness_m / n_glass + range_m / n_water)


def _slope_along(along2: Numeric, across2: Numeric, *, n: Numeric) -> Numeric:
    """dx/du per metre of a medium, (n^2 + k v^2) / (n^2 + k (u^2 + v^2))^(3/2) with k = n^2 - 1."""
    n2 = n**2
    at_axis = n2 + (n2 - 1.0) * across2
    square = at_axis + (n2 - 1.0) * along2
    return at_axis / (square * np.sqrt(square))


def flat_smallest_pixel_along_m(
    tan_along_edge: Numeric,
    *,
    tan_across_edge: Numeric,
    gap_m: Numeric,
    thickness_m: Numeric,
    n_glass: Numeric,
    n_water: Numeric,
    range_m: Numeric,
    pixel_pitch_m: Numeric,
    focal_length_m: Numeric,
) -> Numeric:
    """Smallest floor per pixel along the motion, over the image behind a flat port; it decides motion blur.

        GSD = (p / f) min over the edge's middle and the corner of dx/du
        x = u h(rho),   dx/du = e + sum over glass and water of t (n^2 + k v^2) / (n^2 + k rho^2)^(3/2)

    Parameters
    ----------
    tan_along_edge, tan_across_edge : (...,) half the sensor's side along and across the motion, over f
    gap_m, thickness_m, n_glass, n_water, range_m : broadcast, as in `flat_largest_pixel_m`
    pixel_pitch_m, focal_length_m : broadcast [m]

    Returns
    -------
    (...,) [m].

    Notes
    -----
    k = n^2 - 1, rho^2 = u^2 + v^2. Each term falls with u, so the least is on the edge, u = tan_along_edge.
    There, as a function of a = n^2 + k v^2 with b = k u^2, a / (a + b)^(3/2) rises while a < 2 b and falls
    after: no least inside, hence the middle (v = 0) or the corner. Glass and water turn at different v; for
    ports much thinner than the range the sum behaves like the water's term. Below u^2 = n^2 / (2 k), half
    angles under 43 degrees in air, it is always the corner, exactly.

    References
    ----------
    Physics page, section 7 (10).
    """
    along2, across2 = tan_along_edge**2, tan_across_edge**2

    def metres_per_tangent(v2: Numeric) -> Numeric:
        glass_m = thickness_m * _slope_along(along2, v2, n=n_glass)
        return gap_m + glass_m + range_m * _slope_along(along2, v2, n=n_water)

    least_m = np.minimum(metres_per_tangent(0.0), metres_per_tangent(across2))
    return pixel_pitch_m / focal_length_m * least_m


# ---------------------------------------------------------------- motion


def floor_speed_m_s(
    speed_m_s: Numeric, *, rotation_rate_rad_s: Numeric = 0.0, lever_m: Numeric = 0.0
) -> Numeric:
    """Speed at which the floor passes below the camera, v + omega L; L is d, or d + R behind a dome [sym]."""
    return speed_m_s + rotation_rate_rad_s * lever_m


def blur_exposure_s(
    blur_px: Numeric,
    *,
    ground_sample_m: Numeric,
    speed_m_s: Numeric,
    rotation_rate_rad_s: Numeric = 0.0,
    lever_m: Numeric = 0.0,
) -> Numeric:
    """Longest exposure for an allowed motion blur.

        t_blur = blur GSD_along / (v + omega L)                                                      (10)

    Parameters
    ----------
    blur_px : (...,) [px] along the motion
    ground_sample_m : broadcast [m per px], the smallest along the motion
    speed_m_s, rotation_rate_rad_s : broadcast [m/s], [rad/s], not negative
    lever_m : broadcast [m], d for a flat port, d + R for a dome

    Returns
    -------
    (...,) [s], inf where nothing moves. The exposure offset of the sensor counts: t + t_0 <= t_blur.

    References
    ----------
    Physics page, section 7.
    """
    pass_speed_m_s = floor_speed_m_s(speed_m_s, rotation_rate_rad_s=rotation_rate_rad_s, lever_m=lever_m)
    allowed_m = blur_px * ground_sample_m
    moving_m_s = np.where(pass_speed_m_s > 0.0, pass_speed_m_s, 1.0)
    return np.where(pass_speed_m_s > 0.0, allowed_m / moving_m_s, np.inf)[()]


def blur_px(
    exposure_s: Numeric,
    *,
    ground_sample_m: Numeric,
    speed_m_s: Numeric,
    rotation_rate_rad_s: Numeric = 0.0,
    lever_m: Numeric = 0.0,
) -> Numeric:
    """Motion blur [px] of an exposure, t (v + omega L) / GSD_along; see `blur_exposure_s` (10) [sym]."""
    pass_speed_m_s = floor_speed_m_s(speed_m_s, rotation_rate_rad_s=rotation_rate_rad_s, lever_m=lever_m)
    return exposure_s * pass_speed_m_s / ground_sample_m


def skew_px(
    readout_s: Numeric,
    *,
    ground_sample_m: Numeric,
    speed_m_s: Numeric,
    rotation_rate_rad_s: Numeric = 0.0,
    lever_m: Numeric = 0.0,
) -> Numeric:
    """Shift [px] between the first and last row of a rolling shutter, t_readout (v + omega L) / GSD [sym]."""
    return blur_px(
        readout_s,
        ground_sample_m=ground_sample_m,
        speed_m_s=speed_m_s,
        rotation_rate_rad_s=rotation_rate_rad_s,
        lever_m=lever_m,
    )


def frame_rate_hz(speed_m_s: Numeric, *, footprint_along_m: Numeric, overlap: Numeric) -> Numeric:
    """Least frame rate at which successive images overlap by a wanted share.

        f_min = v / (FOV_along (1 - OVR))                                                            (8) [sym]

    speed_m_s : (...,) [m/s]; footprint_along_m : broadcast [m]; overlap : broadcast, 0 <= OVR < 1.
    Returns (...,) [Hz], 0 at rest. Physics page, section 7.
    """
    return speed_m_s / (footprint_along_m * (1.0 - overlap))


def overlap_at_rate(frame_rate_hz: Numeric, *, speed_m_s: Numeric, footprint_along_m: Numeric) -> Numeric:
    """Share by which successive images overlap, 1 - v / (FOV f), for f > 0; inverse of `frame_rate_hz` [sym].

    Negative where the images leave gaps. Arguments broadcast. Physics page, section 7 (8).
    """
    return 1.0 - speed_m_s / (footprint_along_m * frame_rate_hz)
