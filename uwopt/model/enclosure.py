"""Room that a camera with its lens needs in a housing, when the entrance pupil stands where the port wants it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.arrays import Array

CLEARANCE_M = 0.002  # to any wall, for a frame and for building it in


@dataclass(frozen=True)
class Bodies:
    """Sizes of cameras with their lenses, (n,) [m]; 0 for what is not known and not checked."""

    camera_width_m: Array
    camera_height_m: Array
    camera_length_m: Array  # from the mount's face to the back
    plug_m: Array  # room behind it
    lens_diameter_m: Array
    lens_length_m: Array
    pupil_m: Array  # entrance pupil behind the lens's front
    least_pupil_m: Array | None = None  # the least that it may be, where `pupil_m` is the most; None: it is known

    @property
    def diagonal_m(self) -> Array:
        """Diagonal of the camera's cross section."""
        return np.asarray(np.hypot(self.camera_width_m, self.camera_height_m))

    @property
    def behind_pupil_m(self) -> Array:
        """From the entrance pupil, where it lies farthest in front, to the end of the plug."""
        return np.asarray(self.lens_length_m - self.frontmost_m + self.camera_length_m + self.plug_m)

    @property
    def frontmost_m(self) -> Array:
        """The least distance of the entrance pupil behind the lens's front: how far that stands out of the tube."""
        return self.pupil_m if self.least_pupil_m is None else self.least_pupil_m


def tube_needed_m(bodies: Bodies, *, is_dome: Any, gap_m: Any) -> tuple[Array, Array]:
    """Inner diameter and length that a tube needs.

        D = max(sqrt(w^2 + h^2), D_lens) + 2 c
        L = L_lens - p + l + plug  + p' + c,     p' = gap behind a dome, max(p, gap) behind a flat port

    Parameters
    ----------
    bodies : (n,) [m]
    is_dome, gap_m : of the port; the gap is from its inner face, or a dome's rim, to the entrance pupil [m]

    Returns
    -------
    two (n,) [m]

    Notes
    -----
    Valid for: camera and tube on one axis; a dome with its rim at the tube's mouth, so that the pupil, at the centre of
    its sphere, stands in the mouth behind a hemisphere, and deeper behind a spherical cap. Behind a flat port the
    lens's front is not beyond the glass.

    References
    ----------
    Geometry.
    """
    width = np.maximum(bodies.diagonal_m, bodies.lens_diameter_m) + 2.0 * CLEARANCE_M
    before = np.where(is_dome, gap_m, np.maximum(bodies.frontmost_m, gap_m))  # L falls with p: the least decides
    return np.asarray(width), np.asarray(bodies.behind_pupil_m + before + CLEARANCE_M)


def mouth_needed_m(tan_corner: Any, *, gap_m: Any) -> Array:
    """Inner diameter that the mouth of a tube needs, for the corner's ray to pass it.

        D = 2 g tan(theta)

    Parameters
    ----------
    tan_corner : (n,) [1], of the angle between the axis and the ray to the image's corner, inside the port
    gap_m : from the entrance pupil to the mouth, where the port's rim or inner face lies [m]

    Returns
    -------
    (n,) [m]; 0 behind a hemisphere, whose pupil stands in the mouth.

    Notes
    -----
    Valid for: a pupil that is a point. What matters where the mouth is narrower than the port's own opening.

    References
    ----------
    Geometry.
    """
    return np.asarray(2.0 * np.asarray(gap_m) * np.where(np.asarray(gap_m) > 0.0, tan_corner, 0.0))


def dome_needed_m(bodies: Bodies) -> Array:
    """Inner radius that a dome needs, for the front of a lens whose pupil is at its centre.

        R = sqrt((D_lens / 2)^2 + p^2) + c

    Parameters
    ----------
    bodies : (n,) [m]

    Returns
    -------
    (n,) [m]; 0 where the lens's size is not known.

    Notes
    -----
    Valid for: lenses no wider behind than in front. What stands free in a sphere of radius R beyond the rim of a
    spherical cap, h > 0 from its centre, passes the rim: p > h gives D_lens / 2 < sqrt((R - c)^2 - h^2) < a - c, a the
    opening's half.

    References
    ----------
    Geometry.
    """
    reach = np.hypot(0.5 * bodies.lens_diameter_m, bodies.pupil_m)
    return np.where(reach > 0.0, reach + CLEARANCE_M, 0.0)


def sphere_needed_m(bodies: Bodies) -> Array:
    """Inner diameter that a sphere needs, with the entrance pupil at its centre.

        D = 2 (max(sqrt(b^2 + (w^2 + h^2) / 4), sqrt((D_lens / 2)^2 + p^2)) + c),     b: from pupil to plug

    Parameters
    ----------
    bodies : (n,) [m]

    Returns
    -------
    (n,) [m]. Valid for: a plug that is as wide as the camera.

    References
    ----------
    Geometry.
    """
    back = np.hypot(bodies.behind_pupil_m, 0.5 * bodies.diagonal_m)
    front = np.hypot(0.5 * bodies.lens_diameter_m, bodies.pupil_m)
    return np.asarray(2.0 * (np.maximum(back, front) + CLEARANCE_M))
