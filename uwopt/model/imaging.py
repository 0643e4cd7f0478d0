"""The stages put in a row: what one lumen second at the lamps becomes in the pixels.

For given hardware and scene the mean signal of the image is

    mu_e = C * X,      X = light * time / N_w^2   [lm s]

with C [electrons / (lm s)] free of the settings: the spectrum contracted once, times the mean over
the image of geometry and water's loss. C is what a search tabulates; X is what settings choose.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from uwopt.arrays import Array
from uwopt.model import beam as beams
from uwopt.model import lens, light, port, seafloor, sensor
from uwopt.model.path_table import PathTable, log_mean_transmissions
from uwopt.model.spectrum import trapezoid_weights_nm

LEAST_STARTS, LEAST_ZOOMS = 12, 7  # of the search for the darkest place
FARTHEST = 5.0  # times as far along the axis as the middle of a frame: beyond it a tilted plane runs to the horizon


class PortShape(NamedTuple):
    """Ports of one geometry, the water in front of them and how the target's plane lies there, in SI.

    The port's four numbers are scalars, or columns (n,) with one port for each of n images.
    """

    is_dome: bool
    outer_radius_m: port.Numeric
    thickness_m: port.Numeric
    n_glass: port.Numeric
    gap_m: port.Numeric
    n_water: float
    window_angle: bool = False  # count that a flat window passes less off its axis
    slope: float = 0.0  # of the plane z = d + slope x that is looked at, tan of the pitch; 0: square to the axis

    @property
    def plates(self) -> dict[str, Any]:
        """What a ray goes through behind a flat port, as the formulas of `port` take it."""
        return dict(gap_m=self.gap_m, thickness_m=self.thickness_m, n_glass=self.n_glass, n_water=self.n_water)

    def take(self, rows: Array | slice) -> PortShape:
        """The ports of some of the images."""
        return self._with_columns(lambda column: column[rows])

    def over(self, axes: int) -> PortShape:
        """With so many axes behind each column, for field points or ranges of each image."""
        return self._with_columns(lambda column: column.reshape(*column.shape, *[1] * axes))

    def _with_columns(self, change: Callable[[Array], Array]) -> PortShape:
        """With each column changed; scalars are for all images and points alike."""
        numbers = (self.outer_radius_m, self.thickness_m, self.n_glass, self.gap_m)
        if not any(isinstance(number, np.ndarray) for number in numbers):
            return self
        radius, thickness, glass, gap = (change(n) if isinstance(n, np.ndarray) else n for n in numbers)
        return self._replace(outer_radius_m=radius, thickness_m=thickness, n_glass=glass, gap_m=gap)


@dataclass(frozen=True)
class Lamps:
    """Where lamps stand and aim in the frame that they share with the camera, and the share of the light of each.

    Arrays of equal length; aims are unit vectors, z along the optical axis; shares add up to 1.
    """

    x_m: tuple[float, ...]
    y_m: tuple[float, ...]
    z_m: tuple[float, ...]
    aim: tuple[tuple[float, float, float], ...]
    share: tuple[float, ...]


def signal_weight(
    relative_spectrum: Array,
    *,
    wavelength_nm: Array,
    photopic: Array,
    reflectance: Array,
    quantum_efficiency: Array,
    n_water: Array | float,
) -> Array:
    """Electrons per (lm s) and m^2 of pixel, by wavelength, for 1 lm/m^2 on the floor and N_w = 1.

        w(lambda) = Phi(lambda)/lm * M/pi * 1/n_w^2 * pi/4 * eta lambda/(h c) * d lambda

    The stages (1), (2), the radiance theorem, (4) and (5), with trapezoid weights in place of the
    integral, so that the sum over wavelengths is the integral and water can be put in between.

    Returns
    -------
    (n_wavelength,) [electrons m^-2 (lm s m^-2)^-1], not negative

    References
    ----------
    Physics page, sections 1 to 6; Billings et al. 2020, equations (1) to (5).
    """
    flux = light.spectral_flux_w_nm(
        1.0, relative_spectrum=relative_spectrum, wavelength_nm=wavelength_nm, photopic=photopic
    )
    radiance = seafloor.lambertian_radiance(flux, reflectance=reflectance)
    return radiance_weight(
        radiance, wavelength_nm=wavelength_nm, quantum_efficiency=quantum_efficiency, n_water=n_water
    )


def scatter_weight(
    relative_spectrum: Array,
    *,
    wavelength_nm: Array,
    photopic: Array,
    scattering_per_m: Array,
    quantum_efficiency: Array,
    n_water: Array | float,
) -> Array:
    """The same for light that water scatters towards the camera, phase function and geometry apart.

        w(lambda) = Phi(lambda)/lm * b(lambda) * 1/n_w^2 * pi/4 * eta lambda/(h c) * d lambda

    Returns
    -------
    (n_wavelength,) [electrons m^-2 (lm s m^-2)^-1 m^-1 sr]; physics page, section 8.
    """
    flux = light.spectral_flux_w_nm(
        1.0, relative_spectrum=relative_spectrum, wavelength_nm=wavelength_nm, photopic=photopic
    )
    return radiance_weight(
        flux * scattering_per_m, wavelength_nm=wavelength_nm, quantum_efficiency=quantum_efficiency,
        n_water=n_water,
    )  # fmt: skip


def radiance_weight(
    radiance_in_water: Array, *, wavelength_nm: Array, quantum_efficiency: Array, n_water: Array | float
) -> Array:
    """Electrons per second and m^2 of pixel, by wavelength, of a radiance in water, for N_w = 1.

    L / n_w^2 * pi/4 * eta lambda/(h c) * d lambda,   trapezoid weights in place of the integral
    """
    irradiance = lens.image_irradiance(
        radiance_in_water / np.square(n_water), transmission=1.0, working_f_number=1.0
    )
    density = sensor.electron_rate_per_m2_s_nm(
        irradiance, wavelength_nm=wavelength_nm, quantum_efficiency=quantum_efficiency
    )
    return np.asarray(density * trapezoid_weights_nm(wavelength_nm))


def floor_point(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: Any
) -> tuple[Array, Array, Array]:
    """Where the ray of a field point meets the floor, and its path in water.

    Field points are tangents of the angle in air along and across the motion; the floor is flat,
    `range_m` before the port along the axis. Dome: x = (d + R) tan; flat: exact Snell ray (section 4).

    Returns
    -------
    x_m (forward), y_m (starboard) off the axis, path_m from the port's face to the floor; z = range_m + slope x
    """
    square = np.square(tan_along) + np.square(tan_across)
    range_m = axial_range_m(tan_along, tan_across, shape=shape, range_m=range_m)
    if shape.is_dome:
        reach_m = range_m + shape.outer_radius_m
        return (
            reach_m * tan_along,
            reach_m * tan_across,
            reach_m * np.sqrt(1.0 + square) - shape.outer_radius_m,
        )
    radius = np.sqrt(square)
    slope = flat_slope_m(radius, shape=shape, range_m=range_m)
    water_tangent = port.water_tangent(radius, n=shape.n_water)
    return slope * tan_along, slope * tan_across, range_m * np.sqrt(1.0 + np.square(water_tangent))


def axial_range_m(tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: Any) -> Any:
    """How far along the axis rays meet the target's plane [m]: the same for all where it is square to the axis.

        z = (d + s A u) / (1 - s u W),   rays at (x, y) = (u, v) (A + z W) before the port, plane z = d + s x

    Parameters
    ----------
    tan_along, tan_across : (...,) tangents in air u, v
    range_m : d, of the plane along the axis [m], broadcasting

    Notes
    -----
    Rays that would meet it beyond `FARTHEST` times d, or never, end there: such views are refused.

    References
    ----------
    Plane geometry; A and W of `ray_spread`. Physics page, sections 4 and 7.
    """
    if shape.slope == 0.0:
        return range_m
    start_m, per_m = ray_spread(np.square(tan_along) + np.square(tan_across), shape)
    return (range_m + shape.slope * start_m * tan_along) / descent(tan_along, per_m, shape.slope)


def descent(tan_along: Array, per_m: Any, slope: float) -> Any:
    """How much nearer a ray comes to the target's plane for each metre along the axis, 1 - s u W: 1 where it is square.

    per_m : W of `ray_spread`. No less than 1 / `FARTHEST`, where a ray hardly descends or never does.
    """
    return np.maximum(1.0 - slope * tan_along * per_m, 1.0 / FARTHEST)


def ray_spread(square: Array, shape: PortShape) -> tuple[Any, Any]:
    """Distance of rays from the axis over their tangent in air: A at the port's face [m], W more for each metre.

        dome: A = R, W = 1;   flat: A = e + t_g / sqrt(n_g^2 + (n_g^2 - 1) q),   W = 1 / sqrt(n_w^2 + (n_w^2 - 1) q)

    square : (...,) q, the tangent in air squared. Snell's law; physics page, section 4.
    """
    if shape.is_dome:
        return shape.outer_radius_m, 1.0
    glass, water = (1.0 / port.bend(square, n=n) for n in (shape.n_glass, shape.n_water))
    return shape.gap_m + shape.thickness_m * glass, water


def levelled(lamps: Lamps, slope: float, range_m: float) -> tuple[Lamps, float]:
    """Lamps as they stand over the target's plane, and the port's height above it [m].

    x runs along the plane from where the optical axis meets it, z from the port towards it.
    """
    if slope == 0.0:
        return lamps, range_m
    cos, sin = 1.0 / np.hypot(1.0, slope), slope / np.hypot(1.0, slope)

    def turned(x: float, z: float) -> tuple[float, float]:
        return float(cos * x + sin * z), float(cos * z - sin * x)

    places = [turned(x, z) for x, z in zip(lamps.x_m, lamps.z_m, strict=True)]
    aims = [(turned(x, z), y) for x, y, z in lamps.aim]
    over = Lamps(
        x_m=tuple(x - float(sin) * range_m for x, _ in places), y_m=lamps.y_m, z_m=tuple(z for _, z in places),
        aim=tuple((x, y, z) for (x, z), y in aims), share=lamps.share,
    )  # fmt: skip
    return over, float(cos) * range_m


def flat_slope_m(tan_air: Array, *, shape: PortShape, range_m: float | Array) -> Array:
    """Floor distance over tangent in air, behind a flat port; finite on the axis."""
    safe = np.maximum(tan_air, 1e-9)
    return np.asarray(port.flat_floor_distance_m(safe, **shape.plates, range_m=range_m) / safe)


def lamp_light(
    x_m: Array, y_m: Array, *, lamps: Lamps, index: int, beam: beams.Beam, range_m: float | Array, slope: float = 0.0,
    lobe: Any = 0.0,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Illuminance per lumen [1/m^2] that one lamp would give in vacuum, range and cos of beam angle.

    On the plane z = range_m + slope x. `lobe`: which of beams side by side lights each place.
    """
    range_lamp, cos_beam, cos_incidence = beams.lamp_rays(
        x_m,
        y_m,
        lamp_x_m=lamps.x_m[index],
        lamp_y_m=lamps.y_m[index],
        lamp_height_m=range_m - lamps.z_m[index] + slope * x_m if slope else range_m - lamps.z_m[index],
        aim_x=lamps.aim[index][0],
        aim_y=lamps.aim[index][1],
        aim_z=lamps.aim[index][2],
        slope=slope,
    )
    intensity = beams.intensity_per_sr(cos_beam, beam, lobe)
    return intensity * cos_incidence / np.square(range_lamp), range_lamp, cos_beam


def local_gain(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float | Array, lamps: Lamps, beam: beams.Beam,
    table: PathTable, edge_share: bool = False, lobe: Any = 0.0,
) -> Array:  # fmt: skip
    """cos^4 times illuminance per lumen times water's loss at each field point [1/m^2].

    The loss is relative to `signal_weight` summed over wavelengths. With `edge_share`, points are
    cells of a regular grid and a beam that ends sharply counts by the share of the cell it covers.
    `lobe`: which of beams side by side lights each point, broadcasting.
    """
    return local_gains(
        tan_along, tan_across, shape=shape, range_m=range_m, lamps=lamps, beam=beam, tables=(table,),
        edge_share=edge_share, lobe=lobe,
    )[0]  # fmt: skip


def local_gains(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float | Array, lamps: Lamps, beam: beams.Beam,
    tables: tuple[PathTable, ...], edge_share: bool = False, lobe: Any = 0.0,
) -> list[Array]:  # fmt: skip
    """`local_gain` under the losses of several tables, which cover the same ranges."""
    x_m, y_m, path_m = floor_point(tan_along, tan_across, shape=shape, range_m=range_m)
    totals = [np.zeros(np.broadcast(x_m, y_m).shape) for _ in tables]
    plane: dict[str, Any] = dict(range_m=range_m, slope=shape.slope, lobe=lobe)
    for index, share in enumerate(lamps.share):
        if edge_share:
            open_beam = beams.without_edge(beam)
            vacuum, range_lamp, cos_beam = lamp_light(
                x_m, y_m, lamps=lamps, index=index, beam=open_beam, **plane
            )
            vacuum = vacuum * covered_share(cos_beam, np.cos(beams.edge_half_angle_rad(beam)))
        else:
            vacuum, range_lamp, _ = lamp_light(x_m, y_m, lamps=lamps, index=index, beam=beam, **plane)
        lit = share * vacuum
        for total, loss in zip(totals, log_mean_transmissions(tables, range_lamp, path_m), strict=True):
            total += lit * np.exp(loss)
    passed = field_loss(tan_along, tan_across, shape=shape)
    return [np.asarray(total * passed) for total in totals]


def field_loss(tan_along: Array, tan_across: Array, *, shape: PortShape) -> Array:
    """What lens and window pass off the axis, as a share of what they pass on it.

    cos^4(theta), behind a flat port times T_port(theta) / T_port(0)
    """
    loss = lens.cos4_field(tan_along, tan_across)
    if shape.is_dome or not shape.window_angle:
        return np.asarray(loss)
    oblique = port.flat_port_transmittance(
        np.hypot(tan_along, tan_across), n_water=shape.n_water, n_glass=shape.n_glass
    )
    return np.asarray(
        loss * oblique / port.normal_port_transmittance(n_water=shape.n_water, n_glass=shape.n_glass)
    )


def covered_share(level: Array, edge: float) -> Array:
    """Share of each cell of a regular grid (last two axes) where a smooth level lies above an edge.

    The level is taken as linear within a cell: share = clip(1/2 + (level - edge) / (|d_u| + |d_v|)),
    d_u and d_v the change across one cell. Second order in the cell's size.
    """
    d_u = np.abs(np.gradient(level, axis=-2))
    d_v = np.abs(np.gradient(level, axis=-1))
    return np.clip(0.5 + (level - edge) / np.maximum(d_u + d_v, 1e-12), 0.0, 1.0)
