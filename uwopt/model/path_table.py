"""A spectrum's mean transmission over two paths, lamp -> floor -> camera, contracted into a polynomial.

A design's signal is an integral over wavelength of weight * exp(-K r_lamp - c r_camera). For one lamp, water
and camera only the two path lengths change, so the logarithm of that integral is tabulated once as a
polynomial of both (`PathTable`): tens of nanoseconds a design instead of a sum over the spectrum.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from uwopt.arrays import FloatArray
from uwopt.errors import RangeError
from uwopt.model.spectrum import trapezoid_weights_nm

BLOCK = 2048  # points evaluated together: the powers of one block stay in the processor's cache
MOST_PRODUCTS = 500_000  # of a product of matrices: from 2^19 on OpenBLAS wakes threads that wait for one another
PROBE_ORDER = 32  # of the one-dimensional trial fits that choose order and warp
# How strongly the nodes crowd towards short ranges, where the spectrum changes most.
WARPS = (0.0, 0.2, 0.4, 0.6, 0.8)
LEAST_SHARE = 1e-290  # in place of 0: its logarithm is finite
LARGEST_EXPONENT = 200.0  # of a factor, so that products of three neither overflow nor vanish
LEAST_SUM = 1e-200  # below it what was rounded away may count
RANGE_SLACK = 1e-9  # of the upper end: rounding of a range that was computed another way

Box = tuple[float, float]
Boxes = tuple[Box, Box]


@dataclass(frozen=True, slots=True, eq=False)
class PathTable:
    """The spectrally averaged transmission of two paths, as a polynomial of both lengths.

    ln(mean transmission) = sum c_ij x^i y^j - lamp_slope r_lamp - camera_slope r_camera, with x and y the
    ranges mapped to -1..1. Leading dimensions are those of the weight, e.g. the channels of a sensor.
    """

    lamp_range_m: tuple[float, float]
    camera_range_m: tuple[float, float]
    weight_integral: FloatArray  # (...,), the integral of the weight over wavelength
    coefficients: FloatArray  # (..., order_lamp + 1, order_camera + 1)
    lamp_slope_per_m: FloatArray  # (...,), attenuation at the far corner, taken out before fitting
    camera_slope_per_m: FloatArray  # (...,)
    lamp_warp: float
    camera_warp: float
    max_error_log: float  # found on a grid finer than the nodes, ends included

    @property
    def order(self) -> tuple[int, int]:
        """Degree of the polynomial along lamp and camera range."""
        return self.coefficients.shape[-2] - 1, self.coefficients.shape[-1] - 1


def build_path_table(
    weight: ArrayLike,
    *,
    wavelength_nm: ArrayLike | None,
    k_lamp_per_m: ArrayLike,
    c_camera_per_m: ArrayLike,
    lamp_range_m: tuple[float, float],
    camera_range_m: tuple[float, float],
    k_camera_per_m: ArrayLike | None = None,
    order: int | None = None,
    max_order: int = 16,
    tolerance_log: float = 1e-6,
) -> PathTable:
    """Tabulate the mean transmission of lamp -> floor -> camera for fast evaluation.

        T(r_l, r_c) = integral of w exp(-K r_l - c r_c) d lambda / integral of w d lambda

    Parameters
    ----------
    weight : (..., n) [any unit per nm], zero or more, e.g. S eta M lambda
    wavelength_nm : (n,) [nm]; None when the weight already holds the steps of a quadrature
    k_lamp_per_m, c_camera_per_m : (n,) [1/m]
    lamp_range_m, camera_range_m : least and greatest range [m]; they may be equal
    k_camera_per_m : (n,) [1/m], at most c: T then counts what arrives without forming an image, with
        exp(-k r_c) - exp(-c r_c) in place of exp(-c r_c); no small difference of two tables is taken
    order : fixed degree along both ranges; None raises it until the tolerance is met or max_order reached
    tolerance_log : wanted error of ln T, hence the relative error of T

    Returns
    -------
    PathTable, with the achieved error on record

    Notes
    -----
    Interpolates ln T at Chebyshev nodes of warped ranges. ln T is smooth, nearly linear, and bends most at
    short range while the strongly absorbed colours die out: a linear part is taken out, nodes crowd there.
    A weight that is zero throughout has no mean; the plain mean of the spectrum then keeps the result finite.

    References
    ----------
    Trefethen (2013), Approximation Theory and Approximation Practice (conformal maps).
    """
    integrand = _Integrand(weight, wavelength_nm, k_lamp_per_m, c_camera_per_m, k_camera_per_m)
    boxes = (_checked_range(lamp_range_m, "lamp"), _checked_range(camera_range_m, "camera"))
    orders, warps = _choose_orders(integrand, boxes, max_order, tolerance_log)
    if order is not None:
        orders = (order, order)
    while True:
        coefficients, error = _fit(integrand, boxes, orders, warps)
        if order is not None or error <= tolerance_log or min(orders) >= max_order:
            break
        orders = (min(orders[0] + 2, max_order), min(orders[1] + 2, max_order))
    batch = integrand.batch_shape
    lamp_slope, camera_slope = integrand.slopes(boxes)
    return PathTable(
        lamp_range_m=boxes[0],
        camera_range_m=boxes[1],
        weight_integral=integrand.total.reshape(batch),
        coefficients=coefficients.reshape((*batch, *coefficients.shape[-2:])),
        lamp_slope_per_m=lamp_slope.reshape(batch),
        camera_slope_per_m=camera_slope.reshape(batch),
        lamp_warp=warps[0],
        camera_warp=warps[1],
        max_error_log=error,
    )


def product(left: Any, right: Any) -> Any:
    """A product of matrices, in parts of rows that wake no threads of BLAS, which would wait for one another.

        (left @ right)_ij = sum over k of left_ik right_kj

    Parameters
    ----------
    left : (n, k)
    right : (k, m)

    Returns
    -------
    (n, m)

    Notes
    -----
    Valid for any; of small matrices it is one product. Parts agree with the whole to rounding.

    References
    ----------
    Definition of the product; OpenBLAS, `interface/gemm.c`, for the size from which it takes threads.
    """
    rows = max(MOST_PRODUCTS // right.size, 1)
    if len(left) <= rows:
        return left @ right
    whole = np.empty((len(left), right.shape[1]), np.result_type(left, right))
    for start in range(0, len(left), rows):  # in place: putting parts together takes as long as all products
        np.matmul(left[start : start + rows], right, out=whole[start : start + rows])
    return whole


def log_mean_transmission(table: PathTable, lamp_range_m: ArrayLike, camera_range_m: ArrayLike) -> Any:
    """ln of the mean transmission of a table at given ranges.

    Ranges broadcast to (...) [m]; returns (batch..., ...), batch the leading dimensions of the weight.
    Ranges outside the table's raise RangeError.
    """
    return log_mean_transmissions((table,), lamp_range_m, camera_range_m)[0]


def log_mean_transmissions(
    tables: tuple[PathTable, ...], lamp_range_m: ArrayLike, camera_range_m: ArrayLike
) -> list[Any]:
    """`log_mean_transmission` of several tables at the same ranges."""
    lamp, camera = _same_shape(lamp_range_m, camera_range_m)
    for lamp_box, camera_box in {(table.lamp_range_m, table.camera_range_m) for table in tables}:
        _require_inside(lamp, lamp_box, "lamp")
        _require_inside(camera, camera_box, "camera")
    return _look_up(tables, lamp, camera)


def log_transmissions_anywhere(
    tables: tuple[PathTable, ...], lamp_range_m: ArrayLike, camera_range_m: ArrayLike
) -> list[Any]:
    """`log_mean_transmission` of several tables, for any ranges (...) [m].

    Beyond the table's ranges: ln T = ln T(nearest range inside) - slope * excess, with the attenuation at
    the table's far corner. Good to some per cent of the excess; meant for what is too dark to matter.
    """
    return _look_up(tables, *_same_shape(lamp_range_m, camera_range_m))


def _same_shape(one: ArrayLike, other: ArrayLike) -> list[FloatArray]:
    both = [np.asarray(one, dtype=float), np.asarray(other, dtype=float)]
    return both if both[0].shape == both[1].shape else list(np.broadcast_arrays(*both))


class _Stack(NamedTuple):
    """Polynomials of tables that map their ranges alike, row under row: look-ups share all but the coefficients."""

    rows: FloatArray  # (n_camera * n_weights, n_lamp + 2): coefficients of x^i y^j; last those of the ranges themselves
    n_camera: int
    boxes: Boxes
    warps: tuple[float, float]
    of_table: tuple[tuple[int, slice], ...]  # which tables, and which of the weights are theirs


@functools.lru_cache(maxsize=256)
def _stacks(tables: tuple[PathTable, ...]) -> tuple[_Stack, ...]:
    """Tables put together where they map their ranges alike, shorter polynomials filled up with zeros."""
    groups: dict[Any, list[int]] = {}
    for index, table in enumerate(tables):
        maps = ((table.lamp_range_m, table.camera_range_m), (table.lamp_warp, table.camera_warp))
        groups.setdefault(maps, []).append(index)
    stacks = []
    for (boxes, warps), members in groups.items():
        n_lamp, n_camera = (1 + max(tables[m].order[axis] for m in members) for axis in (0, 1))
        ends = np.cumsum([0, *(tables[m].weight_integral.size for m in members)]).tolist()
        rows = np.zeros((n_camera, ends[-1], n_lamp + 2))
        of_table = []
        for member, first, last in zip(members, ends[:-1], ends[1:], strict=True):
            table, own = tables[member], slice(first, last)
            count = table.coefficients.shape[-2:]
            rows[: count[1], own, : count[0]] = np.moveaxis(table.coefficients.reshape(-1, *count), 2, 0)
            rows[0, own, -2] = -table.lamp_slope_per_m.reshape(-1)
            rows[0, own, -1] = -table.camera_slope_per_m.reshape(-1)
            of_table.append((member, own))
        stacks.append(_Stack(rows.reshape(-1, n_lamp + 2), n_camera, boxes, warps, tuple(of_table)))
    return tuple(stacks)


def _look_up(tables: tuple[PathTable, ...], lamp: FloatArray, camera: FloatArray) -> list[Any]:
    """ln of the mean transmission of each table, the polynomials held at the ends of their ranges."""
    found: list[Any] = [None] * len(tables)
    flat_lamp, flat_camera = lamp.reshape(-1), camera.reshape(-1)
    for stack in _stacks(tables):
        result = np.empty((len(stack.rows) // stack.n_camera, flat_lamp.size))
        block = max(min(BLOCK, MOST_PRODUCTS // stack.rows.size), 1)
        for start in range(0, flat_lamp.size, block):
            rows = slice(start, start + block)
            result[:, rows] = _polynomials(stack, flat_lamp[rows], flat_camera[rows])
        for index, own in stack.of_table:
            found[index] = result[own].reshape((*tables[index].weight_integral.shape, *lamp.shape))[()]
    return found


def _polynomials(stack: _Stack, lamp: FloatArray, camera: FloatArray) -> FloatArray:
    """ln of the mean transmissions at some points (n_weights, n): powers of x at once, Horner's rule in y."""
    powers = np.empty((stack.rows.shape[1], lamp.size))
    powers[-2], powers[-1] = lamp, camera
    _fill_powers(_to_unit(lamp, stack.boxes[0], stack.warps[0]), powers[:-2])
    terms = (stack.rows @ powers).reshape(stack.n_camera, -1, lamp.size)
    value = terms[-1]
    if stack.n_camera > 1:
        y = _to_unit(camera, stack.boxes[1], stack.warps[1])
        for lower in terms[-2::-1]:
            value *= y
            value += lower
    return np.asarray(value)


class _Integrand:
    """The discretised integral: normalised weights (batch, n) and the two attenuations (n,)."""

    def __init__(
        self, weight: ArrayLike, wavelength_nm: ArrayLike | None, k_lamp: ArrayLike, c_camera: ArrayLike,
        k_camera: ArrayLike | None = None,
    ):  # fmt: skip
        raw = np.asarray(weight, dtype=float)
        steps = np.ones(raw.shape[-1:]) if wavelength_nm is None else trapezoid_weights_nm(wavelength_nm)
        if raw.shape[-1:] != steps.shape or not (np.all(np.isfinite(raw)) and np.all(raw >= 0)):
            raise RangeError("a spectral weight must be finite, not negative, and given for each wavelength")
        self.batch_shape = raw.shape[:-1]
        share = (raw * steps).reshape(-1, steps.size)
        self.total = share.sum(axis=-1)
        share = np.where(self.total[:, None] > 0, share, steps)
        self.share = share / share.sum(axis=-1, keepdims=True)
        self.k_lamp = np.broadcast_to(np.asarray(k_lamp, dtype=float), steps.shape)
        self.c_camera = np.broadcast_to(np.asarray(c_camera, dtype=float), steps.shape)
        self._slopes: dict[Boxes, tuple[FloatArray, FloatArray]] = {}
        self.excess: FloatArray | None = None  # c - k, where only what is scattered forward counts
        if k_camera is not None:
            excess = self.c_camera - np.asarray(k_camera, dtype=float)
            self.excess, self.c_camera = np.maximum(excess, 0.0), self.c_camera - excess

    def log_mean(self, lamp: FloatArray, camera: FloatArray) -> FloatArray:
        """(batch, *shape of the ranges), by log-sum-exp: no underflow, however long the path."""
        result = np.empty((self.share.shape[0], *lamp.shape))
        for i, share in enumerate(self.share):
            lit = share > 0
            exponent = np.log(share[lit]) - np.multiply.outer(lamp, self.k_lamp[lit])
            exponent -= np.multiply.outer(camera, self.c_camera[lit])
            if self.excess is not None:
                exponent += _log_scattered(np.multiply.outer(camera, self.excess[lit]))
            top = exponent.max(axis=-1, keepdims=True)
            result[i] = np.log(np.exp(exponent - top).sum(axis=-1)) + top[..., 0]
        return result

    def slopes(self, boxes: Boxes) -> tuple[FloatArray, FloatArray]:
        """Mean attenuations (batch,) of the light that is left at the far corner."""
        if boxes not in self._slopes:
            self._slopes[boxes] = self._slopes_of(boxes)
        return self._slopes[boxes]

    def _slopes_of(self, boxes: Boxes) -> tuple[FloatArray, FloatArray]:
        with np.errstate(divide="ignore"):
            exponent = np.log(self.share) - self.k_lamp * boxes[0][1] - self.c_camera * boxes[1][1]
        if self.excess is not None:
            exponent += _log_scattered(self.excess * boxes[1][1])
        left = np.exp(exponent - exponent.max(axis=-1, keepdims=True))
        left /= left.sum(axis=-1, keepdims=True)
        return left @ self.k_lamp, left @ self.c_camera

    def remainder(self, boxes: Boxes, lamp: FloatArray, camera: FloatArray) -> FloatArray:
        """ln of the mean transmission without its linear part: (batch, *shape of the ranges)."""
        lamp_slope, camera_slope = self.slopes(boxes)
        linear = np.multiply.outer(lamp_slope, lamp) + np.multiply.outer(camera_slope, camera)
        return np.asarray(self.log_mean(lamp, camera) + linear)

    def remainder_on_probes(self, boxes: Boxes, axis: int) -> FloatArray:
        """`remainder` at `_probes_m` of one range, the other at its shortest: (batch, n_probes)."""
        probes, shortest = _probes_m(boxes[axis]), np.array([boxes[1 - axis][0]])
        lamp, camera = (probes, shortest) if axis == 0 else (shortest, probes)
        if max((self.k_lamp * lamp.max()).max(), (self.c_camera * camera.max()).max()) < LARGEST_EXPONENT:
            along, across = (self.k_lamp, self.c_camera) if axis == 0 else (self.c_camera, self.k_lamp)
            by_probe, by_other = _decay_at_probes(along.tobytes(), boxes[axis]), np.exp(-across * shortest)
            if self.excess is not None and axis == 0:
                by_other *= -np.expm1(-self.excess * shortest)
            elif self.excess is not None:
                by_probe = by_probe * _scattered_at_probes(self.excess.tobytes(), boxes[axis])
            mean = (self.share * by_other) @ by_probe.T
            if mean.min() > LEAST_SUM:
                lamp_slope, camera_slope = self.slopes(boxes)
                linear = np.multiply.outer(lamp_slope, lamp) + np.multiply.outer(camera_slope, camera)
                return np.asarray(np.log(mean) + linear)
        return self.remainder_on_grid(boxes, lamp, camera).reshape(len(self.share), -1)

    def remainder_on_grid(self, boxes: Boxes, lamp: FloatArray, camera: FloatArray) -> FloatArray:
        """`remainder` over all pairs of a lamp's and a camera's ranges, (batch, n_lamp, n_camera).

        exp(-K r_l - c r_c) is a product of two factors, one a range: their sum over the spectrum is a product
        of matrices. Where a factor leaves what a number can hold, the slower logarithms serve.
        """
        slopes = self.slopes(boxes)
        centres = [slope.mean() for slope in slopes]  # one for all weights, so that factors are shared
        to_lamp = np.multiply.outer(lamp, centres[0] - self.k_lamp)
        to_camera = np.multiply.outer(camera, centres[1] - self.c_camera)
        if max(np.abs(to_lamp).max(), np.abs(to_camera).max()) < LARGEST_EXPONENT:
            by_lamp, by_camera = np.exp(to_lamp), np.exp(to_camera)
            if self.excess is not None:
                by_camera *= -np.expm1(-np.multiply.outer(camera, self.excess))
            mean = np.stack([product(share * by_lamp, by_camera.T) for share in self.share])
            if mean.min() > LEAST_SUM:
                lamp_left, camera_left = (
                    np.multiply.outer(slope - centre, ranges)
                    for slope, centre, ranges in zip(slopes, centres, (lamp, camera), strict=True)
                )
                return np.asarray(np.log(mean) + lamp_left[:, :, None] + camera_left[:, None, :])
        return self.remainder(boxes, *np.meshgrid(lamp, camera, indexing="ij"))


@functools.lru_cache(maxsize=8)
def _probes_m(box: Box) -> FloatArray:
    """Where trial fits read a range, warp after warp."""
    nodes = chebyshev.chebpts1(PROBE_ORDER + 1)
    return np.concatenate([_from_unit(nodes, box, warp) for warp in WARPS])


@functools.lru_cache(maxsize=8)
def _decay_at_probes(attenuation_per_m: bytes, box: Box) -> FloatArray:
    """exp(-K r) there, (n_probes, n): tables of one water share it."""
    return np.exp(-np.multiply.outer(_probes_m(box), np.frombuffer(attenuation_per_m)))


@functools.lru_cache(maxsize=4)
def _scattered_at_probes(excess_per_m: bytes, box: Box) -> FloatArray:
    """1 - exp(-(c - k) r) there, (n_probes, n)."""
    return np.asarray(-np.expm1(-np.multiply.outer(_probes_m(box), np.frombuffer(excess_per_m))))


def _log_scattered(optical: FloatArray) -> FloatArray:
    """ln(1 - exp(-x)), that of the least number where nothing is scattered."""
    return np.asarray(np.log(np.maximum(-np.expm1(-optical), LEAST_SHARE)))


def _choose_orders(
    integrand: _Integrand, boxes: Boxes, max_order: int, tolerance_log: float
) -> tuple[tuple[int, int], tuple[float, float]]:
    """Order and warp along each range, from one-dimensional fits where the other range is shortest."""
    orders, warps = [], []
    for axis in (0, 1):
        lo, hi = boxes[axis]
        if hi == lo:
            orders.append(0)
            warps.append(0.0)
            continue
        values = integrand.remainder_on_probes(boxes, axis).reshape(-1, len(WARPS), PROBE_ORDER + 1)
        series = np.abs(values @ _to_series(PROBE_ORDER).T)
        # tail[..., k]: sum of what is left out when the series ends at degree k
        tail = np.cumsum(series[..., ::-1], axis=-1)[..., ::-1] - series
        degree = np.argmax(tail.max(axis=0) <= tolerance_log / 8, axis=-1)
        best = int(np.argmin(degree))
        orders.append(min(int(degree[best]), max_order))
        warps.append(WARPS[best])
    return (orders[0], orders[1]), (warps[0], warps[1])


def _fit(
    integrand: _Integrand, boxes: Boxes, orders: tuple[int, int], warps: tuple[float, float]
) -> tuple[FloatArray, float]:
    """Coefficients (batch, n_lamp, n_camera) in powers, and the error on a finer grid."""
    x, y = (chebyshev.chebpts1(n + 1) for n in orders)
    values = integrand.remainder_on_grid(boxes, *_ranges(x, y, boxes, warps))
    series = _to_series(orders[0]) @ values @ _to_series(orders[1]).T
    coefficients = _to_powers(orders[0]) @ series @ _to_powers(orders[1]).T
    # Extrema of a higher Chebyshev polynomial: between the nodes, the ends included.
    x, y = (np.cos(np.linspace(0, np.pi, 2 * n + 3)) for n in orders)
    fitted = _powers(x, orders[0] + 1).T @ coefficients @ _powers(y, orders[1] + 1)
    exact = integrand.remainder_on_grid(boxes, *_ranges(x, y, boxes, warps))
    return coefficients, float(np.abs(fitted - exact).max())


def _ranges(
    x: FloatArray, y: FloatArray, boxes: Boxes, warps: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Lamp's and camera's ranges at places of -1..1."""
    return _from_unit(x, boxes[0], warps[0]), _from_unit(y, boxes[1], warps[1])


@functools.cache
def _to_series(order: int) -> FloatArray:
    """Matrix from values at Chebyshev nodes to coefficients of the Chebyshev series."""
    nodes = chebyshev.chebpts1(order + 1)
    matrix = 2.0 / (order + 1) * chebyshev.chebvander(nodes, order).T
    matrix[0] /= 2
    return np.asarray(matrix, dtype=float)


@functools.cache
def _to_powers(order: int) -> FloatArray:
    """Matrix from a Chebyshev series to powers; harmless for the quickly falling series of these tables."""
    matrix = np.zeros((order + 1, order + 1))
    for k in range(order + 1):
        matrix[: k + 1, k] = chebyshev.cheb2poly(np.eye(k + 1)[k])
    return matrix


def _powers(x: FloatArray, n: int) -> FloatArray:
    rows = np.empty((n, x.size))
    _fill_powers(x, rows)
    return rows


def _fill_powers(x: FloatArray, rows: FloatArray) -> None:
    """x^i in row i."""
    rows[0] = 1.0
    if len(rows) > 1:
        rows[1] = x
    for i in range(2, len(rows)):
        np.multiply(rows[i - 1], x, out=rows[i])


def _to_unit(range_m: FloatArray, box: Box, warp: float) -> FloatArray:
    """Range, held within its box, to -1..1 by x = (s + warp)/(1 + warp s), s linear in range: short ranges spread out.

    x = 1/warp - (1/warp - warp)/(1 + warp s)
    """
    lo, hi = box
    if hi == lo:
        return np.zeros_like(range_m)
    x = np.maximum(range_m, lo)
    np.minimum(x, hi, out=x)
    x *= 2.0 * (warp or 1.0) / (hi - lo)
    x += (1.0 if warp else 0.0) - (warp or 1.0) * (hi + lo) / (hi - lo)
    if warp:
        np.divide(1.0 / warp - warp, x, out=x)
        np.subtract(1.0 / warp, x, out=x)
    return x


def _from_unit(x: FloatArray, box: Box, warp: float) -> FloatArray:
    s = (x - warp) / (1 - warp * x)
    return np.asarray((box[0] + box[1] + s * (box[1] - box[0])) / 2)


def _checked_range(range_m: tuple[float, float], which: str) -> Box:
    lo, hi = float(range_m[0]), float(range_m[1])
    if not 0 <= lo <= hi < np.inf:
        raise RangeError(f"{which} range {lo:g}-{hi:g} m must be finite, ordered and not negative")
    return lo, hi


def _require_inside(range_m: FloatArray, box: Box, which: str) -> None:
    if not range_m.size:
        return
    lo, hi = range_m.min(), range_m.max()
    slack = RANGE_SLACK * max(box[1], 1e-300)
    if not (lo >= box[0] - slack and hi <= box[1] + slack):
        raise RangeError(
            f"{which} range {lo:g}-{hi:g} m is outside the table's {box[0]:g}-{box[1]:g} m; "
            "build a wider table"
        )
