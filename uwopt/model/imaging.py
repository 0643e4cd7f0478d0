"""The stages put in a row: what one lumen second at the lamps becomes in the pixels.

For given hardware and scene the mean signal of the image is

    mu_e = C * X,      X = light * time / N_w^2   [lm s]

with C [electrons / (lm s)] free of the settings: the spectrum contracted once, times the mean over
the image of geometry and water's loss. C is what a search tabulates; X is what settings choose.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwopt.model import beam as beams
from uwopt.model import lens, light, port, seafloor, sensor
from uwopt.model.fineness import DEFAULT, Fineness, scaled
from uwopt.model.spectrum import trapezoid_weights_nm
from uwopt.model.water import PathTable, log_mean_transmission

Array = NDArray[Any]

SMOOTH_ORDER = 14  # Gauss-Legendre nodes a side for lobes given by a formula
TABLE_ORDER = 48  # for measured profiles, whose knots are half a degree apart
EDGE_CELLS = 96  # midpoint cells a side, with the edge's share of each cell, for beams that end sharply
SPOT_CELLS = 128  # the same where the cells lie on the spot alone
CELLS_PER_SPOT = 64.0  # a side, for each half axis of a spot: where tilted lamps make it long
WIDEST_SPOT_RAD = np.deg2rad(85.0)  # a beam that reaches further from the vertical lights all of the floor
MOST_ORDER = 768
MAX_NODES_AT_ONCE = 400_000
LAMP_RANGES = 257  # between which the loss of the lamp's leg is interpolated
LEAST_STARTS, LEAST_ZOOMS = 12, 7  # of the search for the darkest place
FOOTPRINT_CELLS = 60  # a side of the grid on which the darkest place of the floor is looked for
PIXELS_A_SIDE = 17  # of the grid on which the worst pixel is looked for


class PortShape(NamedTuple):
    """One port and the water in front of it, as scalars in SI."""

    is_dome: bool
    outer_radius_m: float
    thickness_m: float
    n_glass: float
    gap_m: float
    n_water: float
    window_angle: bool = False  # count that a flat window passes less off its axis


@dataclass(frozen=True)
class Lamps:
    """Where lamps stand and aim in the vehicle frame, and the share of the total light each gives.

    Arrays of equal length; aims are unit vectors, z down; shares add up to 1.
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
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float
) -> tuple[Array, Array, Array]:
    """Where the ray of a field point meets the floor, and its path in water.

    Field points are tangents of the angle in air along and across the motion; the floor is flat,
    `range_m` below the port. Dome: x = (d + R) tan; flat: exact Snell ray (section 4).

    Returns
    -------
    x_m (forward), y_m (starboard), path_m from the port's face to the floor
    """
    square = np.square(tan_along) + np.square(tan_across)
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


def flat_slope_m(tan_air: Array, *, shape: PortShape, range_m: float | Array) -> Array:
    """Floor distance over tangent in air, behind a flat port; finite on the axis."""
    safe = np.maximum(tan_air, 1e-9)
    distance = port.flat_floor_distance_m(
        safe,
        gap_m=shape.gap_m,
        thickness_m=shape.thickness_m,
        n_glass=shape.n_glass,
        n_water=shape.n_water,
        range_m=range_m,
    )
    return np.asarray(distance / safe)


def lamp_light(
    x_m: Array, y_m: Array, *, lamps: Lamps, index: int, beam: beams.Beam, range_m: float
) -> tuple[Array, Array, Array]:
    """Illuminance per lumen [1/m^2] that one lamp would give in vacuum, range and cos of beam angle."""
    range_lamp, cos_beam, cos_incidence = beams.lamp_rays(
        x_m,
        y_m,
        lamp_x_m=lamps.x_m[index],
        lamp_y_m=lamps.y_m[index],
        lamp_height_m=range_m - lamps.z_m[index],
        aim_x=lamps.aim[index][0],
        aim_y=lamps.aim[index][1],
        aim_z=lamps.aim[index][2],
    )
    intensity = beams.intensity_per_sr(cos_beam, beam)
    return intensity * cos_incidence / np.square(range_lamp), range_lamp, cos_beam


def local_gain(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    table: PathTable, edge_share: bool = False,
) -> Array:  # fmt: skip
    """cos^4 times illuminance per lumen times water's loss at each field point [1/m^2].

    The loss is relative to `signal_weight` summed over wavelengths. With `edge_share`, points are
    cells of a regular grid and a beam that ends sharply counts by the share of the cell it covers.
    """
    x_m, y_m, path_m = floor_point(tan_along, tan_across, shape=shape, range_m=range_m)
    total = np.zeros(np.broadcast(x_m, y_m).shape)
    for index, share in enumerate(lamps.share):
        if edge_share:
            open_beam = beams.without_edge(beam)
            vacuum, range_lamp, cos_beam = lamp_light(
                x_m, y_m, lamps=lamps, index=index, beam=open_beam, range_m=range_m
            )
            vacuum = vacuum * covered_share(cos_beam, np.cos(beams.edge_half_angle_rad(beam)))
        else:
            vacuum, range_lamp, _ = lamp_light(x_m, y_m, lamps=lamps, index=index, beam=beam, range_m=range_m)
        total += share * vacuum * np.exp(log_mean_transmission(table, range_lamp, path_m))
    return np.asarray(total * field_loss(tan_along, tan_across, shape=shape))


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


def field_mean(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    table: PathTable, order: int | None = None, fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Mean over the image rectangle of `local_gain`, for many images at once [1/m^2].

    Parameters
    ----------
    tan_along, tan_across : (n,) tangents in air of the half angles of view along and across the motion
    order : nodes a side of the image (smooth beams: Gauss-Legendre), or cells a side of each lamp's spot in it
        (sharp ones: midpoint, extrapolated)
    fineness : factor on the order that is chosen where none is given

    Notes
    -----
    Images are symmetric about the axis, so lamps that mirror each other give the same mean.
    When no lamp stands or leans along the motion, half of the image stands for the whole.
    """
    needed = cells_needed if beams.has_sharp_edge(beam) else orders_needed
    orders = (
        np.full(len(tan_along), order)
        if order
        else needed(tan_along, tan_across, shape, range_m, lamps, beam, fineness)
    )
    mean = np.empty(len(tan_along))
    for n in np.unique(orders):
        rows = np.nonzero(orders == n)[0]
        mean[rows] = mean_of_order(
            int(n),
            tan_along[rows],
            tan_across[rows],
            shape=shape,
            range_m=range_m,
            lamps=lamps,
            beam=beam,
            table=table,
        )
    return mean


def orders_needed(
    tan_along: Array, tan_across: Array, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Nodes or cells a side for each image: more where a lamp's spot is small in it.

    Gauss-Legendre resolves a spot of standard deviation s, in half widths of the image, with about
    2.7 / s nodes to 1e-6; cells on the whole image follow a sharp edge of radius a to some 1e-4 with 32 / a.
    """
    half_m = (range_m + shape.outer_radius_m + shape.gap_m + shape.thickness_m) * np.maximum(
        tan_along, tan_across
    )
    height = min(range_m - z for z in lamps.z_m)
    spot_m = np.tan(beams.half_power_angle_rad(beam)) * height
    if beams.has_sharp_edge(beam):
        least, wanted = EDGE_CELLS, 32.0 * half_m / spot_m
    else:
        least = TABLE_ORDER if beam.kind == "tabulated" else SMOOTH_ORDER
        wanted = 2.7 * 1.18 * half_m / spot_m
    steps = np.ceil(np.log2(np.maximum(wanted / least, 1.0)) * 2.0)
    orders = np.minimum(2 * np.round(0.5 * least * 2.0 ** (0.5 * steps)), MOST_ORDER)
    return np.maximum(2 * np.round(0.5 * fineness * orders), 2).astype(int)


def cells_needed(
    tan_along: Array, tan_across: Array, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Cells a side of each lamp's spot in an image, for beams that end sharply: (n,), more for long spots.

    128 follow an edge to 2e-5 of the mean or better as a rule, whatever part of the image the spot takes.
    """
    wanted = np.full(len(tan_along), float(SPOT_CELLS))
    for lamp in each_lamp(lamps):
        box = spot_box(tan_along, tan_across, shape=shape, range_m=range_m, lamps=lamp, beam=beam)
        scale_m = range_m + shape.outer_radius_m + shape.gap_m + shape.thickness_m
        long_m = 0.5 * scale_m * np.maximum((box[1] - box[0]) * tan_along, (box[3] - box[2]) * tan_across)
        spot_m = np.tan(beams.edge_half_angle_rad(beam)) * (range_m - lamp.z_m[0])
        wanted = np.maximum(wanted, CELLS_PER_SPOT * long_m / spot_m)
    steps = np.ceil(np.log2(wanted / SPOT_CELLS) * 2.0)
    orders = np.minimum(SPOT_CELLS * 2.0 ** (0.5 * steps), MOST_ORDER)
    return np.maximum(4 * np.round(0.25 * fineness * orders), 4).astype(int)


def each_lamp(lamps: Lamps) -> list[Lamps]:
    """Lamps one by one, each with its share."""
    rows = zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, lamps.share, strict=True)
    return [Lamps((x,), (y,), (z,), (aim,), (share,)) for x, y, z, aim, share in rows]


def spot_box(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam
) -> Array:
    """The part of each image that holds one lamp's spot: (4, n) = u from, to, v from, to, in half widths.

    On the floor the edge of a beam is an ellipse: half axes a = h (tan(t + b) - tan(t - b)) / 2 along the tilt t
    and a sqrt(1 - sin^2(t) / cos^2(b)) across it. Empty (to = from) where the spot lies outside.
    """
    edge, aim = beams.edge_half_angle_rad(beam), lamps.aim[0]
    tilt = float(np.arctan2(np.hypot(aim[0], aim[1]), aim[2]))
    box = np.repeat([[-1.0], [1.0], [-1.0], [1.0]], len(tan_along), axis=1)
    if tilt + edge >= WIDEST_SPOT_RAD:
        return box
    height_m = range_m - lamps.z_m[0]
    far_m, near_m = height_m * np.tan(tilt + edge), height_m * np.tan(tilt - edge)
    long_m, centre_m = 0.5 * (far_m - near_m), 0.5 * (far_m + near_m)
    short_m = long_m * np.sqrt(max(1.0 - (np.sin(tilt) / np.cos(edge)) ** 2, 0.0))
    across_tilt = max(float(np.hypot(aim[0], aim[1])), 1e-300)
    lean = (aim[0] / across_tilt, aim[1] / across_tilt) if tilt > 0.0 else (1.0, 0.0)
    if shape.is_dome:
        scales_m = [np.full(len(tan_along), range_m + shape.outer_radius_m)]
    else:
        corner = np.hypot(tan_along, tan_across)
        scales_m = [flat_slope_m(t, shape=shape, range_m=range_m) for t in (0.0 * corner, corner)]
    for axis, (foot_m, half) in enumerate(((lamps.x_m[0], tan_along), (lamps.y_m[0], tan_across))):
        reach_m = np.hypot(long_m * lean[axis], short_m * lean[1 - axis])
        middle_m = foot_m + centre_m * lean[axis]
        first, last = (
            [end_m / (s * half) for s in scales_m] for end_m in (middle_m - reach_m, middle_m + reach_m)
        )
        box[2 * axis] = np.clip(np.min(first, axis=0), -1.0, 1.0)
        box[2 * axis + 1] = np.clip(np.max(last, axis=0), -1.0, 1.0)
    return box


def edge_mean(
    n: int, tan_along: Array, tan_across: Array, *, shape: PortShape, lamps: Lamps, **common: Any
) -> Array:
    """`field_mean` with n cells a side of each lamp's spot: midpoint rule, extrapolated from n and n/2 [1/m^2]."""
    mean = np.zeros(len(tan_along))
    for lamp in each_lamp(lamps):
        box = spot_box(
            tan_along, tan_across, shape=shape, lamps=lamp, range_m=common["range_m"], beam=common["beam"]
        )
        along_cells = 2 if along_symmetric(lamp) else 1  # half of the image stands for the whole
        if along_cells == 2:
            box[0] = 0.0
        area = along_cells * 0.25 * np.maximum(box[1] - box[0], 0.0) * np.maximum(box[3] - box[2], 0.0)
        rows = np.nonzero(area > 0.0)[0]
        fine, half = (
            box_mean(
                (max(k // along_cells, 2), max(k, 2)),
                tan_along[rows],
                tan_across[rows],
                box[:, rows],
                shape=shape,
                lamps=lamp,
                **common,
            )
            for k in (n, n // 2)
        )
        # the midpoint rule's error is quadratic in the cell
        mean[rows] += area[rows] * np.maximum((4.0 * fine - half) / 3.0, 0.0)
    return mean


def box_mean(count: tuple[int, int], tan_along: Array, tan_across: Array, box: Array, **common: Any) -> Array:
    """Mean of `local_gain` over a part of each image, (4, n) as `spot_box` gives it, by even cells [1/m^2]."""
    (u, _), (v, _) = cells(count[0]), cells(count[1])
    mean = np.empty(len(tan_along))
    step = max(1, MAX_NODES_AT_ONCE // (count[0] * count[1]))
    for start in range(0, len(tan_along), step):
        rows = slice(start, start + step)
        low, high, left, right = (side[rows, None] for side in box)
        along = tan_along[rows, None] * (0.5 * (low + high) + 0.5 * (high - low) * u)
        across = tan_across[rows, None] * (0.5 * (left + right) + 0.5 * (right - left) * v)
        gain = local_gain(
            *np.broadcast_arrays(along[:, :, None], across[:, None, :]), edge_share=True, **common
        )
        mean[rows] = gain.mean(axis=(1, 2))
    return mean


def mean_of_order(
    n: int, tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    table: PathTable,
) -> Array:  # fmt: skip
    """`field_mean` with n nodes or cells a side."""
    common: dict[str, Any] = dict(shape=shape, range_m=range_m, lamps=lamps, beam=beam, table=table)
    if beams.has_sharp_edge(beam):
        return edge_mean(n, tan_along, tan_across, **common)
    along_rule = gauss(n)
    if along_symmetric(lamps):
        nodes, weights = gauss(max(4, n // 2))
        along_rule = (0.5 * (nodes + 1.0), weights)
    return rule_mean(tan_along, tan_across, along_rule, gauss(n), **common)


def rule_mean(
    tan_along: Array, tan_across: Array, along_rule: tuple[Array, Array], across_rule: tuple[Array, Array],
    **common: Any,
) -> Array:  # fmt: skip
    """Mean of `local_gain` over images by a product rule on [-1, 1], a few images at a time."""
    along_nodes, along_weights = along_rule
    across_nodes, across_weights = across_rule
    mean = np.empty(len(tan_along))
    step = max(1, MAX_NODES_AT_ONCE // (len(along_nodes) * len(across_nodes)))
    for start in range(0, len(tan_along), step):
        rows = slice(start, start + step)
        along, across = np.broadcast_arrays(
            tan_along[rows, None, None] * along_nodes[:, None], tan_across[rows, None, None] * across_nodes
        )
        mean[rows] = (local_gain(along, across, **common) @ across_weights) @ along_weights
    return mean


def pixel_grid(
    tan_along: Array, tan_across: Array, *, n_points: int = PIXELS_A_SIDE, half: bool = False
) -> tuple[Array, Array]:
    """Field points on a regular grid over each image, corners and edges included: tangents [1], (n, n_pixels) each.

    `half` leaves out what mirrors along the motion: enough when no lamp stands or leans along it.
    """
    nodes = np.linspace(-1.0, 1.0, n_points)
    along_nodes = nodes[n_points // 2 :] if half else nodes
    along, across = (g.ravel() for g in np.meshgrid(along_nodes, nodes, indexing="ij"))
    return tan_along[:, None] * along, tan_across[:, None] * across


def along_symmetric(lamps: Lamps) -> bool:
    """Whether no lamp stands or leans along the motion, so that half of an image stands for the whole."""
    return all(x == 0.0 for x in lamps.x_m) and all(aim[0] == 0.0 for aim in lamps.aim)


@cache
def gauss(order: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes on [-1, 1] and weights of the mean."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    return nodes, weights / 2.0


def cells(count: int) -> tuple[Array, Array]:
    """Midpoints of equal cells on [-1, 1] and weights of the mean."""
    return (np.arange(count) + 0.5) * (2.0 / count) - 1.0, np.full(count, 1.0 / count)


def floor_illuminance_per_lm(
    x_m: Array, y_m: Array, *, lamps: Lamps, beam: beams.Beam, range_m: float, weight: Array, attenuation_per_m: Array,
    edge_share: bool = False, n_ranges: int = LAMP_RANGES,
) -> Array:  # fmt: skip
    """Illuminance on the floor per lumen of all lamps [1/m^2], water's loss on the lamp leg included.

        E / Phi = sum over lamps of share * I/Phi * cos(theta_i) / r^2 * mean of exp(-K r) over V S

    Parameters
    ----------
    x_m, y_m : (...,) floor points
    weight : (n,) V(lambda) times the lamp's spectrum and the steps; attenuation_per_m : (n,) K(lambda)
    edge_share : points are cells of a regular grid, and a sharp beam counts by the share it covers
    n_ranges : of `lamp_leg_loss`

    References
    ----------
    Physics page, sections 1 and 2.
    """
    total = np.zeros(np.broadcast(x_m, y_m).shape)
    share_of_wave = weight / weight.sum()
    shape = beams.without_edge(beam) if edge_share else beam
    for index, share in enumerate(lamps.share):
        vacuum, range_lamp, cos_beam = lamp_light(
            x_m, y_m, lamps=lamps, index=index, beam=shape, range_m=range_m
        )
        if edge_share:
            vacuum = vacuum * covered_share(cos_beam, np.cos(beams.edge_half_angle_rad(beam)))
        total += share * vacuum * lamp_leg_loss(range_lamp, share_of_wave, attenuation_per_m, n_ranges)
    return total


def lamp_leg_loss(
    range_m: Array, share_of_wave: Array, attenuation_per_m: Array, n_ranges: int = LAMP_RANGES
) -> Array:
    """Mean of exp(-K r) over a spectrum, its logarithm interpolated linearly between even ranges.

    The second difference of the logarithm is at most the variance of K times the step squared / 8:
    under 1e-5 for a footprint a few metres deep.
    """
    ranges = np.linspace(float(range_m.min()), float(range_m.max()), n_ranges)
    lit = share_of_wave > 0.0  # what the lamp does not emit may be attenuated far less
    optical = ranges[:, None] * attenuation_per_m[lit]
    least = optical.min(axis=1)
    with np.errstate(under="ignore"):
        log_mean = np.log(np.exp(-(optical - least[:, None])) @ share_of_wave[lit]) - least
        return np.exp(np.interp(range_m, ranges, log_mean))


def footprint_illuminance_per_lm(
    tan_along: float, tan_across: float, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    weight: Array, attenuation_per_m: Array, fineness: Fineness = DEFAULT,
) -> tuple[float, float]:  # fmt: skip
    """Mean and least illuminance per lumen over the image's footprint on the floor [1/m^2].

    The footprint is traced through the port: behind a flat one its corners are drawn in. The mean is
    over floor area, each field point weighted with |d(x, y) / d(u, v)| = (r/t) dr/dt of the radial map.
    """
    common: dict[str, Any] = dict(
        lamps=lamps, beam=beam, range_m=range_m, weight=weight, attenuation_per_m=attenuation_per_m,
        n_ranges=scaled(LAMP_RANGES, fineness.spectrum),
    )  # fmt: skip
    cells_a_side = scaled(FOOTPRINT_CELLS, fineness.places)
    needed = cells_needed if beams.has_sharp_edge(beam) else orders_needed
    images = np.array([tan_along]), np.array([tan_across])
    order = int(needed(*images, shape, range_m, lamps, beam, fineness.image)[0])

    def part(u: Array, v: Array, **of_lamps: Any) -> tuple[Array, Array]:
        along, across = np.meshgrid(tan_along * u, tan_across * v, indexing="ij")
        x_m, y_m, _ = floor_point(along, across, shape=shape, range_m=range_m)
        area = floor_area_ratio(along, across, shape=shape, range_m=range_m)
        return area, floor_illuminance_per_lm(x_m, y_m, **(common | of_lamps))

    mean = footprint_mean(part, order, *images, shape=shape, range_m=range_m, lamps=lamps, beam=beam)
    grid = np.linspace(-1.0, 1.0, cells_a_side + 1)

    def there(u: Array, v: Array) -> Array:
        x_m, y_m, _ = floor_point(tan_along * u, tan_across * v, shape=shape, range_m=range_m)
        return floor_illuminance_per_lm(x_m, y_m, **common)

    u, v = np.meshgrid(grid, grid, indexing="ij")
    return mean, least_of(there, u.ravel(), v.ravel(), 2.0 / cells_a_side)


def footprint_mean(
    part: Callable[..., tuple[Array, Array]], order: int, tan_along: Array, tan_across: Array, *, shape: PortShape,
    range_m: float, lamps: Lamps, beam: beams.Beam,
) -> float:  # fmt: skip
    """Mean over the footprint of what `part` gives: floor area and illuminance at field points in half widths [1/m^2].

    Beams that end sharply: cells on each lamp's spot, extrapolated, as in `edge_mean`.
    """
    nodes, weights = gauss(max(SMOOTH_ORDER, 1 if beams.has_sharp_edge(beam) else order))
    rule = np.outer(weights, weights)
    if not beams.has_sharp_edge(beam):
        area, light_there = part(nodes, nodes)
        return float((light_there * area * rule).sum() / (area * rule).sum())
    total, whole = 0.0, float((part(nodes, nodes)[0] * rule).sum())
    for lamp in each_lamp(lamps):
        box = spot_box(tan_along, tan_across, shape=shape, range_m=range_m, lamps=lamp, beam=beam)[:, 0]
        lit = 0.25 * max(box[1] - box[0], 0.0) * max(box[3] - box[2], 0.0)
        if lit > 0.0:
            means = []
            for k in (order, max(order // 2, 2)):
                u, v = (0.5 * (low + high + (high - low) * cells(k)[0]) for low, high in (box[:2], box[2:]))
                area, light_there = part(u, v, lamps=lamp, edge_share=True)
                means.append(float((light_there * area).mean()))
            total += lit * max((4.0 * means[0] - means[1]) / 3.0, 0.0)
    return total / whole


def least_of(function: Callable[[Array, Array], Array], u: Array, v: Array, cell: float) -> float:
    """Least value of a function over the square |u|, |v| <= 1: on a grid, then ever closer about its lowest points.

    Narrow beams leave dark wedges between the grid's points; a few of the lowest are followed down.
    """
    values = function(u, v)
    steps = np.linspace(-1.0, 1.0, 7)
    step_u, step_v = (part.ravel() for part in np.meshgrid(steps, steps))
    for _ in range(LEAST_ZOOMS):
        low = np.argsort(values, kind="stable")[:LEAST_STARTS]
        u = np.clip(u[low, None] + cell * step_u, -1.0, 1.0).ravel()
        v = np.clip(v[low, None] + cell * step_v, -1.0, 1.0).ravel()
        values, cell = function(u, v), cell / 3.0
    return float(values.min())


def floor_area_ratio(tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float) -> Array:
    """Floor area per area of field tangents, |d(x, y) / d(u, v)| [m^2]; constant behind a dome."""
    if shape.is_dome:
        return np.full(np.broadcast(tan_along, tan_across).shape, (range_m + shape.outer_radius_m) ** 2)
    radius = np.hypot(tan_along, tan_across)
    steep = port.flat_floor_derivative(
        radius,
        gap_m=shape.gap_m,
        thickness_m=shape.thickness_m,
        n_glass=shape.n_glass,
        n_water=shape.n_water,
        range_m=range_m,
    )
    return np.asarray(flat_slope_m(radius, shape=shape, range_m=range_m) * steep)
