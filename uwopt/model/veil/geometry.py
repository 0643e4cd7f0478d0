"""The veil's geometry: the camera's rays in water, and a lamp as seen from a ray."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.model import beam as beams
from uwopt.model import port
from uwopt.model.imaging import Lamps, PortShape, axial_range_m
from uwopt.model.path_table import PathTable

LEAST_DISTANCE_M = 1e-9  # a ray through the lamp itself has no finite veil; this keeps it a number
OPTICAL_REACH = 60.0  # attenuation lengths behind which light no longer counts; see `path_ranges_m`


@dataclass(frozen=True)
class Scatterer:
    """One component of the water that scatters: how it spreads light, and what the way leaves of it."""

    phase: Callable[[Array], Array]  # of the cosine of the scattering angle [1/sr], over the sphere 1
    table: PathTable  # of the signal weight times b(lambda) [weight / m], lamp and camera leg

    def take(self, images: Any) -> Scatterer:
        """The same as some of the images see it."""
        return replace(self, phase=self.phase.take(images)) if isinstance(self.phase, PhaseOfEach) else self


@dataclass(frozen=True)
class PhaseOfEach:
    """Phase functions of images, each its own: of cosines (n, ...) those of image i by `phases[of[i]]`."""

    phases: tuple[Callable[[Array], Array], ...]
    of: Array  # (n,)

    def __call__(self, cos_scatter: Array) -> Array:
        made = np.empty(cos_scatter.shape)
        for place in np.unique(self.of):
            mine = self.of == place
            made[mine] = self.phases[place](cos_scatter[mine])
        return made

    def take(self, images: Any) -> PhaseOfEach:
        """Those of some of the images."""
        return replace(self, of=self.of[images])


def of_each(every: Sequence[tuple[Scatterer, ...]], of: Array) -> tuple[Scatterer, ...]:
    """Components of the water as each image sees them, image i as `every[of[i]]` has it; their tables are the same."""
    if len(every) == 1:
        return every[0]
    alike = [tuple(one.phase for one in parts) for parts in zip(*every, strict=True)]
    return tuple(Scatterer(PhaseOfEach(phases, of), one.table) for phases, one in zip(alike, every[0], strict=True))


class Rays(NamedTuple):
    """The pixels' rays in water: where they start, unit directions to the floor, lengths; vehicle frame."""

    x_m: Array
    y_m: Array
    z_m: Array
    along_x: Array
    along_y: Array
    along_z: Array
    path_m: Array


class _View(NamedTuple):
    """A lamp as a ray sees it."""

    distance_m: Array  # D, of the lamp from the ray's line
    closest_m: Array  # delta, along the ray
    aim_across: Array  # A
    aim_along: Array  # B
    low: Array  # the lit part of the ray, in y
    high: Array


def camera_rays(tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float | Array) -> Rays:
    """The rays of field points (tangents in air), from the port's outer face to the floor.

    Dome: from its outer surface, on a line through its centre (0, 0, -R). Flat: from the outer face at
    gap * tan_air + thickness * tan_glass off the axis, at the angle in water.

    Returns
    -------
    Rays of broadcast shape [m]; `path_m` is that of `imaging.floor_point`
    """
    along, across = np.broadcast_arrays(np.asarray(tan_along, float), np.asarray(tan_across, float))
    square = along * along + across * across
    range_m = axial_range_m(along, across, shape=shape, range_m=range_m)
    if shape.is_dome:
        length = np.sqrt(1.0 + square)
        u_x, u_y, u_z = along / length, across / length, 1.0 / length
        radius_m = shape.outer_radius_m
        path_m = (range_m + radius_m) * length - radius_m
        return Rays(radius_m * u_x, radius_m * u_y, radius_m * (u_z - 1.0), u_x, u_y, u_z, path_m)
    tangent = np.maximum(np.sqrt(square), 1e-9)
    in_water = port.water_tangent(tangent, n=shape.n_water)
    in_glass = port.water_tangent(tangent, n=shape.n_glass)
    offset_m = shape.gap_m + shape.thickness_m * in_glass / tangent
    length = np.sqrt(1.0 + in_water * in_water)
    bend = in_water / (tangent * length)
    return Rays(
        offset_m * along,
        offset_m * across,
        np.zeros_like(along),
        bend * along,
        bend * across,
        1.0 / length,
        range_m * length,
    )


def _lamp_view(rays: Rays, *, lamps: Lamps, index: int, beam: beams.Beam) -> _View:
    """How each ray sees one lamp, and which part of the ray it lights."""
    aim = lamps.aim[index]
    from_lamp = (rays.x_m - lamps.x_m[index], rays.y_m - lamps.y_m[index], rays.z_m - lamps.z_m[index])
    direction = (rays.along_x, rays.along_y, rays.along_z)
    closest_m = -_dot(from_lamp, direction)
    across = tuple(q + closest_m * u for q, u in zip(from_lamp, direction, strict=True))
    distance_m = np.maximum(np.sqrt(_dot(across, across)), LEAST_DISTANCE_M)
    aim_across, aim_along = _dot(across, aim) / distance_m, _dot(direction, aim)
    first, last = _lit_angles(aim_across, aim_along, beam)
    low = np.maximum(np.arcsinh(-closest_m / distance_m), np.arcsinh(np.tan(first)))
    high = np.minimum(np.arcsinh((rays.path_m - closest_m) / distance_m), np.arcsinh(np.tan(last)))
    return _View(distance_m, closest_m, aim_across, aim_along, low, np.maximum(low, high))


def _dot(a: tuple[Array, ...], b: tuple[Any, ...]) -> Array:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _lit_angles(aim_across: Array, aim_along: Array, beam: beams.Beam) -> tuple[Array, Array]:
    """Where a line enters and leaves the beam, as alpha: |alpha - alpha_0| <= arccos(cos(edge) / M)."""
    centre = np.arctan2(aim_along, aim_across)
    cos_edge = np.cos(beams.edge_half_angle_rad(beam))
    reach = np.arccos(np.minimum(cos_edge / np.maximum(np.hypot(aim_across, aim_along), 1e-300), 1.0))
    quarter = 0.5 * np.pi
    return np.clip(centre - reach, -quarter, quarter), np.clip(centre + reach, -quarter, quarter)


def nearest_approach_m(
    tan_along_half: Array, tan_across_half: Array, *, shape: PortShape, range_m: float, lamps: Lamps
) -> Array:
    """Least distance of any lamp from any ray of each image [m].

    At or under the radius of the lamp's front the point lamp, and with it the integral, means nothing.

    Returns
    -------
    (n,) [m]; 0 to about 1e-4 of the field's width where a lamp stands in the field of view

    Notes
    -----
    Searched on a grid over the image, again around the best point; distances to the rays' finite lengths.
    """
    along, across = np.atleast_1d(np.asarray(tan_along_half, float), np.asarray(tan_across_half, float))
    least = np.full(len(along), np.inf)
    for index in range(len(lamps.share)):
        centre_u = centre_v = np.zeros(len(along))
        reach = 1.0
        for _ in range(6):
            steps = np.linspace(-reach, reach, 17)
            u = np.clip(centre_u[:, None, None] + steps[:, None], -1.0, 1.0)
            v = np.clip(centre_v[:, None, None] + steps, -1.0, 1.0)
            u, v = (part.reshape(len(along), -1) for part in np.broadcast_arrays(u, v))
            rays = camera_rays(along[:, None] * u, across[:, None] * v, shape=shape, range_m=range_m)
            distance = _ray_distance_m(rays, lamps, index)
            best = np.argmin(distance, axis=-1)[:, None]
            centre_u, centre_v = (np.take_along_axis(part, best, -1)[:, 0] for part in (u, v))
            least = np.minimum(least, np.take_along_axis(distance, best, -1)[:, 0])
            reach /= 5.0
    return least


def _ray_distance_m(rays: Rays, lamps: Lamps, index: int) -> Array:
    """Distance of a lamp from the rays' finite lengths [m]."""
    q_x, q_y, q_z = (
        rays.x_m - lamps.x_m[index],
        rays.y_m - lamps.y_m[index],
        rays.z_m - lamps.z_m[index],
    )
    closest = np.clip(-(q_x * rays.along_x + q_y * rays.along_y + q_z * rays.along_z), 0.0, rays.path_m)
    return np.asarray(
        np.sqrt(
            (q_x + closest * rays.along_x) ** 2
            + (q_y + closest * rays.along_y) ** 2
            + (q_z + closest * rays.along_z) ** 2
        )
    )


def path_ranges_m(
    tan_along_half: Array, tan_across_half: Array, *, shape: PortShape, range_m: float, lamps: Lamps,
    least_attenuation_per_m: tuple[float, float] = (0.0, 0.0),
) -> tuple[tuple[float, float], tuple[float, float]]:  # fmt: skip
    """Lamp and camera ranges [m] that tables for these images should span.

    Parameters
    ----------
    least_attenuation_per_m : least K (lamp leg) and c (camera leg) over the weight's spectrum

    Returns
    -------
    (least, greatest) from any lamp to any point of any ray; (0, longest ray). Both end 60 attenuation
    lengths behind their start: a `PathTable` is accurate over some 200, nothing visible comes from beyond,
    and what is asked there is continued with the far corner's attenuation.
    """
    along, across = np.atleast_1d(np.asarray(tan_along_half, float), np.asarray(tan_across_half, float))
    steps = np.linspace(-1.0, 1.0, 9)
    rays = camera_rays(
        along[:, None, None] * steps[:, None], across[:, None, None] * steps, shape=shape, range_m=range_m
    )
    nearest = float(
        nearest_approach_m(along, across, shape=shape, range_m=range_m, lamps=lamps).min(initial=np.inf)
    )
    farthest = 0.0
    for x, y, z in zip(lamps.x_m, lamps.y_m, lamps.z_m, strict=True):
        for r in (0.0, rays.path_m):  # the distance is convex along a ray
            squares = (rays.x_m + r * rays.along_x - x) ** 2 + (rays.y_m + r * rays.along_y - y) ** 2
            squares = squares + (rays.z_m + r * rays.along_z - z) ** 2
            farthest = max(farthest, float(np.sqrt(squares.max())))
    lamp_end = min(farthest, nearest + OPTICAL_REACH / max(least_attenuation_per_m[0], 1e-300))
    camera_end = min(float(rays.path_m.max()), OPTICAL_REACH / max(least_attenuation_per_m[1], 1e-300))
    return (0.999 * nearest, max(lamp_end, nearest)), (0.0, camera_end)
