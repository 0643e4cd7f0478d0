"""Backscatter: lamp light that the water sends to the camera before it has seen the floor.

Single scattering along each pixel's ray, r counted from where the ray enters the water,

    L_b(u) = integral of  sum over lamps of share * I(theta_s) / r_s^2 * beta(psi) * exp(-K r_s - c r)  dr

with the spectrum contracted as in `imaging`: the weight times the scattering of each component of the
water (particles, molecules) gives a weight integral and a `PathTable`, and geometry does the rest.

Seen from a ray, a lamp is three numbers: its distance D from the ray's line, the place delta of closest
approach, and its aim. With r = delta + D sinh(y)

    r_s = D cosh(y),   dr / r_s^2 = dy / (D cosh(y)),   cos(psi) = -tanh(y),
    cos(theta_s) = (A + B sinh(y)) / cosh(y) = M cos(alpha - alpha_0),   tan(alpha) = sinh(y)

(A, B: components of the aim from the lamp square to the ray, and along the ray; M^2 = A^2 + B^2). The
singular 1/r_s^2 is gone, the lit part of a ray is one interval of alpha, and water's loss ends the
integrand within about one unit of y, thin or thick. What is left is smooth: Gauss-Legendre in y.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from uwopt.model import beam as beams
from uwopt.model import port
from uwopt.model.fineness import scaled
from uwopt.model.imaging import Lamps, PortShape, field_loss, gauss
from uwopt.model.path_table import PathTable, log_mean_transmission

Array = NDArray[Any]

NODES_AT_ONCE = 20_000  # along rays: some twenty arrays of them stay in the processor's cache
LEAST_DISTANCE_M = 1e-9  # a ray through the lamp itself has no finite veil; this keeps it a number
STEEPEST_END = 6.0  # exponent of a lobe up to which the end of the lit part is rough
PHASE_NODES = 48  # along a ray, where phase functions are read: Petzold's have a knot every 5 deg
TABLE_NODES = 512  # along a ray, where a measured profile is read
TABLE_NODES_IN_MEAN = 256  # its wiggles average out over the rays of an image
N_PROBES = 17  # along a ray, to find where it shines
CUT_LOG = 13.0  # what is fainter than the brightest probe by this is left out
MOST_ZOOMS = 8
WIDE_EXPONENT = 6.0  # cosine-power lobes of 55 deg or more, and
EVEN_LOG = 5.0  # water that leaves e^-5 or more, are integrated without probing
FIELD_ORDERS = (4, 6, 8, 12, 18, 26, 38, 56, 80, 112, 160, 224)
BOX_POINTS = 25  # a side of the grid that finds the lit part of an image
BISECTIONS = 12  # of one cell of that grid: what is missed counts with the square
MOST_RUNG = 4  # of the ladder, to begin at
SPOT_ORDER = 18  # a beam that ends sharply may leave a lit spot that lower orders miss
SMOOTH_CHANGE = 5e-4  # of the mean between two orders: a smooth integrand's error is then under 5e-5
EDGE_CHANGE = 1.2e-4  # where a beam's edge crosses the image, errors fall with the square of the order only
OPTICAL_REACH = 60.0  # attenuation lengths behind which light no longer counts; see `path_ranges_m`


@dataclass(frozen=True)
class Scatterer:
    """One component of the water that scatters: how it spreads light, and what the way leaves of it."""

    phase: Callable[[Array], Array]  # of the cosine of the scattering angle [1/sr], over the sphere 1
    table: PathTable  # of the signal weight times b(lambda) [weight / m], lamp and camera leg


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


def camera_rays(tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float) -> Rays:
    """The rays of field points (tangents in air), from the port's outer face to the floor.

    Dome: from its outer surface, on a line through its centre (0, 0, -R). Flat: from the outer face at
    gap * tan_air + thickness * tan_glass off the axis, at the angle in water.

    Returns
    -------
    Rays of broadcast shape [m]; `path_m` is that of `imaging.floor_point`
    """
    along, across = np.broadcast_arrays(np.asarray(tan_along, float), np.asarray(tan_across, float))
    square = along * along + across * across
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


def backscatter_gain(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    scatterers: tuple[Scatterer, ...], order: int | None = None, fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Veil of single scattering at field points, for one lumen of all lamps.

        cos^4 * sum over components j of W_j * sum over lamps of share
              * integral of I(theta_s)/r_s^2 * p_j(psi) * T_j(r_s, r) dr

    Parameters
    ----------
    tan_along, tan_across : (...,) tangents of the field angles in air, along and across the motion
    shape, range_m, lamps, beam : as in `imaging.local_gain`
    scatterers : components of the water; W_j and T_j are weight integral and transmission of their tables
    order : Gauss-Legendre nodes along each ray; None chooses
    fineness : factor on the nodes chosen, and on those at which curves are read

    Returns
    -------
    (...,) [weight integral / (m sr)]: with tables over w b (w the signal weight without the floor's M/pi)
    the same unit as `imaging.local_gain` times the integral of its weight

    Notes
    -----
    Lamps are points: valid where rays pass them at their front's radius or further; `nearest_approach_m`
    tells. The field point's ray stands for the pupil. Relative error 1e-4 or less by default.
    0 where it falls below the least floating-point number; `log_backscatter_gain` goes on.

    References
    ----------
    Jaffe (1990), IEEE J. Oceanic Eng. 15(2), 101-111; physics page, section 8.
    """
    return np.exp(
        log_backscatter_gain(
            tan_along,
            tan_across,
            shape=shape,
            range_m=range_m,
            lamps=lamps,
            beam=beam,
            scatterers=scatterers,
            order=order,
            fineness=fineness,
        )
    )


def log_backscatter_gain(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    scatterers: tuple[Scatterer, ...], order: int | None = None, fineness: float = 1.0,
) -> Array:  # fmt: skip
    """ln of `backscatter_gain` (same arguments), (...,) [ln of weight integral / (m sr)].

    -inf where no lamp lights the ray; finite where e^x underflows.
    """
    return _log_gain(
        tan_along,
        tan_across,
        shape=shape,
        range_m=range_m,
        lamps=lamps,
        beam=beam,
        scatterers=scatterers,
        ray_nodes=order,
        table_nodes=scaled(TABLE_NODES, fineness),
        fineness=fineness,
    )


def _log_gain(
    tan_along: Array, tan_across: Array, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam,
    scatterers: tuple[Scatterer, ...], ray_nodes: int | None, table_nodes: int, fineness: float,
) -> Array:  # fmt: skip
    rays = camera_rays(tan_along, tan_across, shape=shape, range_m=range_m)
    total = np.full(rays.path_m.shape, -np.inf)
    with np.errstate(divide="ignore", under="ignore"):
        for index, share in enumerate(lamps.share):
            view = _lamp_view(rays, lamps=lamps, index=index, beam=beam)
            from_lamp = _log_ray_integral(
                view, beam=beam, scatterers=scatterers, order=ray_nodes, table_nodes=table_nodes,
                fineness=fineness,
            )  # fmt: skip
            total = np.logaddexp(total, from_lamp + np.log(share))
        return np.asarray(total + np.log(field_loss(tan_along, tan_across, shape=shape)))


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


def _log_ray_integral(
    view: _View, *, beam: beams.Beam, scatterers: tuple[Scatterer, ...], order: int | None, table_nodes: int,
    fineness: float,
) -> Array:  # fmt: skip
    """ln of sum of W_j * integral of I/r_s^2 p_j T_j dr over the lit part of each ray."""
    open_beam = beams.without_edge(beam)  # the interval ends at the edge exactly
    low, high = view.low, view.high
    if _is_uneven(view, beam, scatterers):
        low, high = _bright_part(view, open_beam, scatterers)
    n = order or scaled(_ray_order(low, high, beam), fineness)
    span = high - low
    steps, slopes = _steps(n, beam)
    cosh, sinh = _hyperbolic(low[..., None] + span[..., None] * steps)
    smooth = 1.0 / cosh if beam.kind == "tabulated" else _intensity(cosh, sinh, view, open_beam) / cosh
    smooth = smooth * slopes
    logs = _log_losses(cosh, sinh, view, scatterers)
    top = np.max([log.max(axis=-1) for log in logs], axis=0)
    top = np.where(np.isneginf(top), 0.0, top)  # nothing scatters
    n_fine = max(n, table_nodes if beam.kind == "tabulated" else scaled(PHASE_NODES, fineness))
    read = _measured_curves(n_fine, low, span, view, open_beam, scatterers)
    total = sum(
        (smooth * np.exp(log - top[..., None]) * (curve @ _to_coarse(n, n_fine))).sum(axis=-1)
        for log, curve in zip(logs, read, strict=True)
    )
    return np.asarray(np.log(np.maximum(total, 0.0) * span / view.distance_m) + top)


def _steps(n: int, beam: beams.Beam) -> tuple[Array, Array]:
    """Where the n nodes lie on a ray's lit part, as shares of it, and the derivative of that map.

    A wide lobe falls to 0 like cos^m where a ray starts in the lamp's front plane, m near 1 or below: nodes
    crowd there with the square, which makes it s^2m.
    """
    s = 0.5 * (gauss(n)[0] + 1.0)
    if beam.kind == "cosine-power" and (beam.exponent or 0.0) < STEEPEST_END:
        return s * s, 2.0 * s
    return s, np.ones_like(s)


def _measured_curves(
    n: int, low: Array, span: Array, view: _View, beam: beams.Beam, scatterers: tuple[Scatterer, ...]
) -> list[Array]:
    """Phase functions, times the intensity of a measured beam, at n nodes along each ray.

    Curves that are known at knots are read at more places than the smooth rest needs. That rest is
    taken as the polynomial through its nodes; `_to_coarse` adds each reading to their weights.
    """
    cosh, sinh = _hyperbolic(low[..., None] + span[..., None] * _steps(n, beam)[0])
    cos_scatter = -sinh / cosh
    curves = [scatterer.phase(cos_scatter) for scatterer in scatterers]
    if beam.kind != "tabulated":
        return curves
    profile = _intensity(cosh, sinh, view, beam)
    return [profile * curve for curve in curves]


@cache
def _to_coarse(n: int, n_fine: int) -> Array:
    """Matrix that turns readings at n_fine Gauss nodes into weights of n."""
    fine, weights = gauss(n_fine)
    coarse, coarse_weights = gauss(n)
    degrees = 2 * np.arange(n) + 1  # the Legendre series through the coarse nodes, P_k norm 2/(2k+1)
    series = legendre.legvander(coarse, n - 1).T * coarse_weights * degrees[:, None]
    return np.asarray((weights[:, None] * legendre.legvander(fine, n - 1)) @ series)


def _hyperbolic(y: Array) -> tuple[Array, Array]:
    """cosh and sinh from one exponential."""
    grown = np.exp(y)
    shrunk = 1.0 / grown
    return 0.5 * (grown + shrunk), 0.5 * (grown - shrunk)


def _intensity(cosh: Array, sinh: Array, view: _View, beam: beams.Beam) -> Array:
    cos_beam = (view.aim_across[..., None] + view.aim_along[..., None] * sinh) / cosh
    return beams.intensity_per_sr(np.minimum(cos_beam, 1.0), beam)


def _log_losses(cosh: Array, sinh: Array, view: _View, scatterers: tuple[Scatterer, ...]) -> list[Array]:
    """ln(W_j T_j) of each component at the nodes."""
    lamp_range_m = view.distance_m[..., None] * cosh
    path_m = np.maximum(view.closest_m[..., None] + view.distance_m[..., None] * sinh, 0.0)
    return [
        np.log(s.table.weight_integral) + log_transmission_anywhere(s.table, lamp_range_m, path_m)
        for s in scatterers
    ]


def log_transmission_anywhere(table: PathTable, lamp_range_m: Array, camera_range_m: Array) -> Array:
    """`log_mean_transmission` [ln], for any ranges (...,) [m].

    Beyond the table's ranges: ln T = ln T(nearest range inside) - slope * excess, with the attenuation at
    the table's far corner. Good to some per cent of the excess; meant for what is too dark to matter.
    """
    lamp = np.clip(lamp_range_m, *table.lamp_range_m)
    camera = np.clip(camera_range_m, *table.camera_range_m)
    inside = log_mean_transmission(table, lamp, camera)
    return np.asarray(
        inside
        - table.lamp_slope_per_m * (lamp_range_m - lamp)
        - table.camera_slope_per_m * (camera_range_m - camera)
    )


def _is_uneven(view: _View, beam: beams.Beam, scatterers: tuple[Scatterer, ...]) -> bool:
    """True where the rays may be much darker at one end: by the lobe's shape, or by the water."""
    if beam.kind == "tabulated" or (beam.exponent or 0.0) > WIDE_EXPONENT:
        return True
    cosh = np.cosh(np.maximum(np.abs(view.low), np.abs(view.high)))
    farthest_m = float(np.max(view.distance_m * cosh, initial=0.0))
    longest_m = float(np.max(view.closest_m + view.distance_m * np.sinh(view.high), initial=0.0))
    ends = (
        np.array([farthest_m, float(np.min(view.distance_m, initial=farthest_m))]),
        np.array([longest_m, 0.0]),
    )
    return any(np.ptp(log_transmission_anywhere(s.table, *ends)) > EVEN_LOG for s in scatterers)


def _bright_part(view: _View, beam: beams.Beam, scatterers: tuple[Scatterer, ...]) -> tuple[Array, Array]:
    """The part of each lit interval outside which the integrand is e^-13 of its peak or less.

    Found by probing, again within what was found, until little is cut off: thick water and narrow
    lobes leave a part that no fixed rule would hit.
    """
    low, high = view.low, view.high
    steps = np.linspace(0.0, 1.0, N_PROBES)
    middle = steps[1:] - 0.5 * steps[1]  # the ends themselves may be dark: on the beam's edge
    for _ in range(MOST_ZOOMS):
        span = high - low
        cosh, sinh = _hyperbolic(low[..., None] + span[..., None] * middle)
        level = np.log(_intensity(cosh, sinh, view, beam) / cosh)
        level = level + np.max(_log_losses(cosh, sinh, view, scatterers), axis=0)
        bright = level >= level.max(axis=-1, keepdims=True) - CUT_LOG
        first = np.maximum(np.argmax(bright, axis=-1) - 1, 0)
        last = np.minimum(N_PROBES - np.argmax(bright[..., ::-1], axis=-1), N_PROBES - 1)
        low, high = low + span * steps[first], low + span * steps[last]
        if not np.any(high - low < 0.6 * span):
            break
    return low, high


def _ray_order(low: Array, high: Array, beam: beams.Beam) -> int:
    """Gauss-Legendre nodes along the rays: more for long bright parts and for narrow lobes.

    Measured: 1e-5 or better against composite rules of 10^4 nodes, over lobes of 10-120 deg, altitudes of
    0.05-50 m, lamps 0.02-5 m off and c r up to 2000.
    """
    span = float(np.max(high - low, initial=0.0))
    exponent = beam.exponent if beam.kind == "cosine-power" and beam.exponent else 1.0
    crowded = 3.0 if beam.kind == "cosine-power" and exponent < STEEPEST_END else 0.0
    return int(np.ceil(9.0 + crowded + 1.5 * span + 1.9 * np.log(max(exponent, 1.0))))


def mean_backscatter(
    tan_along_half: Array, tan_across_half: Array, *, shape: PortShape, range_m: float, lamps: Lamps,
    beam: beams.Beam, scatterers: tuple[Scatterer, ...], order: int | None = None, fineness: float = 1.0,
) -> Array:  # fmt: skip
    """Mean over the image rectangle of `backscatter_gain`, for many images at once.

    Parameters
    ----------
    tan_along_half, tan_across_half : (n,) tangents in air of the half angles of view
    order : nodes a side of the image; None raises it for each image until the mean stands still
    fineness : factor on all nodes; the change that counts as standing still falls with its square

    Returns
    -------
    (n,) [weight integral / (m sr)]

    Notes
    -----
    Lamps that mirror each other across track give the same mean: one side, with both shares, will do.
    Half of the image stands for the whole along each direction in which no lamp stands or leans.
    For a beam that ends sharply the nodes are laid within the part of the image that it lights.
    Default: relative error 1e-4 or less, judged by the change between orders; the last order is 224.

    References
    ----------
    Jaffe (1990), IEEE J. Oceanic Eng. 15(2), 101-111; physics page, section 8.
    """
    return np.exp(
        log_mean_backscatter(
            tan_along_half,
            tan_across_half,
            shape=shape,
            range_m=range_m,
            lamps=lamps,
            beam=beam,
            scatterers=scatterers,
            order=order,
            fineness=fineness,
        )
    )


def log_mean_backscatter(
    tan_along_half: Array, tan_across_half: Array, *, shape: PortShape, range_m: float, lamps: Lamps,
    beam: beams.Beam, scatterers: tuple[Scatterer, ...], order: int | None = None, fineness: float = 1.0,
) -> Array:  # fmt: skip
    """ln of `mean_backscatter` (same arguments), (n,) [ln of weight integral / (m sr)].

    -inf where no lamp lights the water before the image; finite where e^x underflows.
    """
    along, across = np.atleast_1d(np.asarray(tan_along_half, float), np.asarray(tan_across_half, float))
    common: dict[str, Any] = dict(
        shape=shape, range_m=range_m, lamps=lamps, beam=beam, scatterers=scatterers, ray_nodes=None,
        table_nodes=scaled(TABLE_NODES_IN_MEAN, fineness), fineness=fineness,
    )  # fmt: skip
    if order:
        return _log_means((order,), along, across, _lit_boxes(along, across, **common), **common)[0]
    first = _first_rung(along, across, shape, range_m, lamps, beam)
    ladder = tuple(2 * scaled(n // 2, fineness) for n in FIELD_ORDERS[first:])
    steep = _has_steep_flank(beam)
    allowed = (EDGE_CHANGE if steep else SMOOTH_CHANGE) / fineness**2
    together = 3 if steep or _front_plane_may_show(lamps, beam) else 2
    boxes = _lit_boxes(along, across, **common)
    recent = _log_means(ladder[:together], along, across, boxes, **common)
    mean = recent[-1].copy()
    pending = np.nonzero(~_settled(recent, allowed, may_hide=steep))[0]
    recent = recent[:, pending]
    for n in ladder[together:]:
        if not pending.size:
            break
        finer = _log_means((n,), along[pending], across[pending], boxes[:, :, pending], **common)
        recent = np.concatenate([recent[1:], finer])
        mean[pending] = finer[0]
        moving = ~_settled(recent, allowed, may_hide=steep and n < SPOT_ORDER)
        pending, recent = pending[moving], recent[:, moving]
    return mean


def _has_steep_flank(beam: beams.Beam) -> bool:
    """True where the mean over an image converges slowly: sharp edges and measured profiles."""
    return beams.has_sharp_edge(beam) or beam.kind == "tabulated"


def _front_plane_may_show(lamps: Lamps, beam: beams.Beam) -> bool:
    """True where a wide lobe is tilted or stands in front of the port: it ends in the image with a kink."""
    wide = beam.kind == "cosine-power" and (beam.exponent or 0.0) < WIDE_EXPONENT
    return wide and (any(z > 0.0 for z in lamps.z_m) or any(aim[2] < 0.999 for aim in lamps.aim))


def _first_rung(
    along: Array, across: Array, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam
) -> int:
    """Where on the ladder of orders to begin: one below what spot and place of the lamps ask for."""
    u, v = float(np.max(along, initial=0.0)), float(np.max(across, initial=0.0))
    depth_m = range_m + shape.outer_radius_m + shape.gap_m + shape.thickness_m
    height_m = max(range_m - max(lamps.z_m), 1e-3 * range_m)
    spot_m = np.tan(min(_half_power_angle_rad(beam), 1.5)) * height_m
    wanted = 2.7 * 1.18 * max(u, v) * depth_m / spot_m  # as in `imaging.orders_needed`
    for x, y, z in zip(lamps.x_m, lamps.y_m, lamps.z_m, strict=True):
        if z > 0.0:  # in front of the port the veil is nearly singular beside the field of view
            if shape.is_dome:
                half_x, half_y = (t * (z + shape.outer_radius_m) for t in (u, v))
            else:
                half_x, half_y = (
                    t * shape.gap_m + shape.thickness_m * t + z * port.water_tangent(t, n=shape.n_water)
                    for t in (u, v)
                )
            beside = np.hypot(max(abs(x) - half_x, 0.0), max(abs(y) - half_y, 0.0)) / max(half_x, half_y)
            # Gauss-Legendre falls like rho^(-2 n), rho the ellipse through the singularity
            wanted = max(wanted, 8.0 / np.arcsinh(max(beside, 0.05)))
    rung = int(np.searchsorted(FIELD_ORDERS, wanted)) - 1
    return min(max(rung, 0), MOST_RUNG)


@lru_cache(maxsize=256)
def _half_power_angle_rad(beam: beams.Beam) -> float:
    return beams.half_power_angle_rad(beam)


def _settled(recent: Array, allowed: float, *, may_hide: bool) -> Array:
    """Whether the means (rungs, n) of the last orders agree; an image dark throughout does, if nothing may
    hide between the nodes."""
    with np.errstate(invalid="ignore"):
        steady = np.all(np.abs(np.diff(recent, axis=0)) <= allowed, axis=0)
    return np.asarray(steady | (np.all(np.isneginf(recent), axis=0) & (not may_hide)))


def _log_means(orders: tuple[int, ...], along: Array, across: Array, boxes: Array, **common: Any) -> Array:
    """ln of the mean over each image by product rules: (orders, images), a few images at a time.

    The rules' nodes are evaluated together, which for few images costs little more than one of them.
    With boxes, each lamp has nodes of its own, all where it shines.
    """
    lamps = common["lamps"]
    if len(boxes):
        by_lamp = [
            _log_means_of_nodes(
                [_lit_rule(n, along, across, box, lamp, **common) for n in orders],
                along, across, **(common | dict(lamps=lamp)),
            )
            for lamp, box in zip(_each_lamp(lamps), boxes, strict=True)
        ]  # fmt: skip
        return np.asarray(np.logaddexp.reduce(by_lamp, axis=0))
    return _log_means_of_nodes([_image_rule(n, lamps) for n in orders], along, across, **common)


def _log_means_of_nodes(
    rules: list[tuple[Array, Array, Array]], along: Array, across: Array, **common: Any
) -> Array:
    """ln of the means by rules (nodes u, v and weights), each of shape (k,) or (images, k)."""
    ends = np.cumsum([0, *(weight.shape[-1] for _, _, weight in rules)])
    u, v, weight = (np.concatenate(parts, axis=-1) for parts in zip(*rules, strict=True))
    u, v, weight = (np.broadcast_to(part, (len(along), ends[-1])) for part in (u, v, weight))
    mean = np.empty((len(rules), len(along)))
    step = max(1, NODES_AT_ONCE // (int(ends[-1]) * N_PROBES))
    for start in range(0, len(along), step):
        rows = slice(start, start + step)
        log_gain = _log_gain(along[rows, None] * u[rows], across[rows, None] * v[rows], **common)
        with np.errstate(divide="ignore"):
            log_gain = log_gain + np.log(weight[rows])
        for i in range(len(rules)):
            mean[i, rows] = _log_sum(log_gain[:, ends[i] : ends[i + 1]])
    return mean


def _each_lamp(lamps: Lamps) -> list[Lamps]:
    return [
        Lamps((x,), (y,), (z,), (aim,), (share,))
        for x, y, z, aim, share in zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, lamps.share, strict=True)
    ]


def _is_lit(u: Array, v: Array, along: Array, across: Array, lamp: Lamps, **common: Any) -> Array:
    """Whether field points (images, ...) see water that the lamp lights."""
    lead = (-1, *([1] * (u.ndim - 1)))
    rays = camera_rays(
        along.reshape(lead) * u, across.reshape(lead) * v, shape=common["shape"], range_m=common["range_m"]
    )
    view = _lamp_view(rays, lamps=lamp, index=0, beam=common["beam"])
    return np.asarray(view.high > view.low)


def _lit_boxes(along: Array, across: Array, **common: Any) -> Array:
    """The part of each image that each lamp lights, for beams that end sharply: (lamps, 4, images).

    First and last u with lit points, and the v between which they lie, in half widths of the image. Empty
    where nothing is to be cut: smooth beams, or images that are lit all over.
    """
    if not beams.has_sharp_edge(common["beam"]):
        return np.empty((0, 4, len(along)))
    boxes = [_lit_box(along, across, lamp, **common) for lamp in _each_lamp(common["lamps"])]
    whole = all(np.all(found) for _, found in boxes)
    return np.empty((0, 4, len(along))) if whole else np.array([box for box, _ in boxes])


def _lit_box(along: Array, across: Array, lamp: Lamps, **common: Any) -> tuple[Array, Array]:
    """(4, images): u from, u to, v from, v to; and whether all of the grid was lit."""
    box = np.repeat([[-1.0], [1.0], [-1.0], [1.0]], len(along), axis=1)
    steps = np.linspace(0.0, 1.0, BOX_POINTS)
    lit_all = np.zeros(len(along), dtype=bool)
    for turn in range(2):
        u = (box[0] + np.multiply.outer(steps, box[1] - box[0])).T[:, :, None]
        v = (box[2] + np.multiply.outer(steps, box[3] - box[2])).T[:, None, :]
        lit = _is_lit(u, v, along, across, lamp, **common)
        if turn == 0:
            lit_all = np.asarray(lit.all(axis=(1, 2)))
        for axis, (low, high) in ((2, (0, 1)), (1, (2, 3))):
            some = np.asarray(lit.any(axis=axis))
            first = np.argmax(some, axis=-1)
            last = BOX_POINTS - 1 - np.argmax(some[:, ::-1], axis=-1)
            span, start = box[high] - box[low], box[low].copy()
            box[low] = start + span * steps[np.maximum(first - 1, 0)]
            box[high] = start + span * steps[np.minimum(last + 1, BOX_POINTS - 1)]
    return box, lit_all


def _lit_rule(
    n: int, along: Array, across: Array, box: Array, lamp: Lamps, **common: Any
) -> tuple[Array, Array, Array]:
    """Nodes u, v and weights (images, n * n): Gauss in u over the box, and in v over the lit part of each u.

    Behind a dome the lit part of an image is convex (a convex beam seen from a point), so it is one
    interval of v; its ends are found by bisection.
    """
    nodes, weights = gauss(n)
    u = box[0][:, None] + (box[1] - box[0])[:, None] * (0.5 * (nodes + 1.0))
    steps = np.linspace(0.0, 1.0, BOX_POINTS)
    grid = (box[2] + np.multiply.outer(steps, box[3] - box[2])).T[:, None, :]
    lit = _is_lit(u[:, :, None], grid, along, across, lamp, **common)
    grid = np.broadcast_to(grid, lit.shape)
    first = np.argmax(lit, axis=-1)
    last = BOX_POINTS - 1 - np.argmax(lit[..., ::-1], axis=-1)
    dark_at = np.stack([np.maximum(first - 1, 0), np.minimum(last + 1, BOX_POINTS - 1)], axis=-1)
    inside, outside = (np.take_along_axis(grid, at, -1) for at in (np.stack([first, last], axis=-1), dark_at))
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        is_in = _is_lit(np.repeat(u[:, :, None], 2, -1), middle, along, across, lamp, **common)
        inside, outside = np.where(is_in, middle, inside), np.where(is_in, outside, middle)
    span = np.where(lit.any(axis=-1), inside[..., 1] - inside[..., 0], 0.0)
    v = inside[..., :1] + span[..., None] * (0.5 * (nodes + 1.0))
    weight = 0.25 * (box[1] - box[0])[:, None, None] * (weights[:, None] * span[..., None]) * weights
    u = np.broadcast_to(u[:, :, None], v.shape)
    flat = (len(along), -1)
    return u.reshape(flat), v.reshape(flat), weight.reshape(flat)


def _image_rule(n: int, lamps: Lamps) -> tuple[Array, Array, Array]:
    """Gauss-Legendre over the image [-1, 1]^2, or over its half where nothing breaks the symmetry."""
    no_x = all(x == 0.0 for x in lamps.x_m) and all(aim[0] == 0.0 for aim in lamps.aim)
    no_y = all(y == 0.0 for y in lamps.y_m) and all(aim[1] == 0.0 for aim in lamps.aim)
    return _product_rule(n, no_x, no_y)


@cache
def _product_rule(n: int, half_along: bool, half_across: bool) -> tuple[Array, Array, Array]:
    (u, u_weight), (v, v_weight) = (_half_rule(n) if half else gauss(n) for half in (half_along, half_across))
    u, v = (part.ravel() for part in np.meshgrid(u, v, indexing="ij"))
    return u, v, np.multiply.outer(u_weight, v_weight).ravel()


def _half_rule(n: int) -> tuple[Array, Array]:
    """Gauss-Legendre on 0..1, for one half of a symmetric image."""
    nodes, weights = gauss(max(2, n // 2))
    return 0.5 * (nodes + 1.0), weights


def _log_sum(log: Array) -> Array:
    top = log.max(axis=-1)
    finite = np.where(np.isfinite(top), top, 0.0)
    with np.errstate(divide="ignore", under="ignore"):
        return np.asarray(np.log(np.exp(log - finite[..., None]).sum(axis=-1)) + finite)


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
