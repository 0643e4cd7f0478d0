"""Work and precision of the integrals over the image and along rays: orders against adaptive quadrature."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.bench import quadrature_exact as exact
from uwopt.bench.quadrature_exact import ImageCase, Water
from uwopt.bench.suite import BenchRow, BenchTable, Budget, Suite, least_size, timed
from uwopt.model import beam as beams
from uwopt.model.image_mean import cells_needed, field_mean, orders_needed
from uwopt.model.imaging import Lamps, PortShape, floor_point
from uwopt.model.path_table import PathTable, build_path_table
from uwopt.model.veil.geometry import Scatterer, path_ranges_m
from uwopt.model.veil.mean import mean_backscatter
from uwopt.model.veil.ray import backscatter_gain

NAME = "quadrature"
SIGNAL, IMAGE_VEIL, PIXEL_VEIL = "signal of an image", "veil of an image", "veil of a pixel"
TARGETS = (SIGNAL, IMAGE_VEIL, PIXEL_VEIL)
GAUSS, CELLS, AS_USED = "Gauss-Legendre", "cells", "as used"
TARGET = 1e-4  # what the project asks of every reported figure

SMOOTH_ORDERS = (4, 6, 8, 10, 14, 20, 28, 40, 56, 80, 112)
CELL_ORDERS = (16, 32, 64, 128, 256, 384)
RAY_ORDERS = (4, 6, 8, 10, 12, 16, 24, 32, 48)
MOST_VEIL_ORDER = {True: 28, False: 56}  # in a quick run, and in a full one
IMAGES, NODES_TOGETHER = 16, 20_000  # timed together, unless they have more nodes than that
PIXELS = ((0.0, 0.0), (1.0, 1.0), (-0.45, -0.9), (0.2, 0.9), (-0.7, 0.3))  # in half widths of the image

DOME = PortShape(is_dome=True, outer_radius_m=0.07, thickness_m=0.005, n_glass=1.5, gap_m=0.0, n_water=1.34)
FLAT = PortShape(is_dome=False, outer_radius_m=0.0, thickness_m=0.01, n_glass=1.5, gap_m=0.02, n_water=1.34)


def particles(cos: Any) -> Any:
    """Henyey-Greenstein's phase function, g = 0.9 [1/sr]."""
    return 0.19 / (4.0 * math.pi) / (1.81 - 1.8 * cos) ** 1.5


def molecules(cos: Any) -> Any:
    """Rayleigh's phase function [1/sr]."""
    return 3.0 / (16.0 * math.pi) * (1.0 + cos * cos)


def water(c_most_per_m: float) -> Water:
    """Nine colours, the clearest with 0.3 of the greatest attenuation; particles and molecules."""
    x = np.linspace(0.0, 1.0, 9)
    c = c_most_per_m * (1.0 - 0.7 * x * (2.0 - x))
    green = np.exp(-(((x - 0.4) / 0.3) ** 2))
    return Water(0.6 * c, c, green, (green, 0.05 * (0.2 + x)), (particles, molecules))


def lamp(
    x: float = 0.0, y: float = 0.5, z: float = 0.0, outward_deg: float = 0.0, share: float = 1.0
) -> Lamps:
    """One lamp, in the port's plane unless said, tilted across the motion."""
    tilt = math.radians(outward_deg)
    return Lamps((x,), (y,), (z,), ((0.0, math.sin(tilt), math.cos(tilt)),), (share,))


def both(first: Lamps, second: Lamps) -> Lamps:
    """Two lamps."""
    return Lamps(*(a + b for a, b in zip(vars(first).values(), vars(second).values(), strict=True)))


def lobe(full_deg: float) -> beams.Beam:
    """A cosine-power lobe of this full angle at half power."""
    return beams.cosine_power_beam(math.radians(full_deg))


@cache
def flood() -> beams.Beam:
    """A measured flood of the catalogue, behind its own window."""
    from uwopt.catalog.tables import built_in_rows

    rows = [r for r in built_in_rows("beam_profiles.csv") if r["profile_id"] == FLOOD]
    return beams.tabulated_beam(
        np.deg2rad([float(r["angle_deg"]) for r in rows]),
        [float(r["intensity"]) for r in rows],
        medium="water",
        n_w=1.34,
    )


FLOOD = "dspl-sealite-flood"
WIDE = (0.35, 0.45)  # half the field of view, as tangents in air along and across


@cache
def cases(quick: bool) -> tuple[ImageCase, ...]:
    """What is integrated: few for a quick run."""
    first = (
        ImageCase("wide lobe, dome, 2 m", WIDE, DOME, 2.0, lamp(), lobe(75), water(1.0)),
        ImageCase(
            "narrow lobe inwards, dome, 2 m", WIDE, DOME, 2.0, lamp(outward_deg=-8), lobe(10), water(1.0)
        ),
        ImageCase("disc's edge in the image, dome, 2 m", WIDE, DOME, 2.0, lamp(y=0.6), disc(25), water(1.0)),
    )
    if quick:
        return first
    around = both(lamp(x=0.2, y=0.4, share=0.5, outward_deg=10), lamp(x=-0.3, y=0.2, share=0.5))
    return (
        *first,
        ImageCase("wide lobe, flat port, 0.4 m", WIDE, FLAT, 0.4, lamp(y=0.2), lobe(120), water(1.0)),
        ImageCase("wide lobe, dome, 20 m", WIDE, DOME, 20.0, lamp(y=1.5), lobe(75), water(0.15)),
        ImageCase("spot of 6 deg, flat port, 10 m", WIDE, FLAT, 10.0, lamp(y=1.0), lobe(6), water(0.2)),
        ImageCase("wide lobe, thick water, dome, 2 m", WIDE, DOME, 2.0, lamp(), lobe(75), water(20.0)),
        ImageCase(
            "cone, flat port, 1 m", WIDE, FLAT, 1.0, lamp(y=0.5, outward_deg=-20), cone(20), water(1.0)
        ),
        ImageCase("cone's edge across, dome, 2 m", WIDE, DOME, 2.0, lamp(y=1.0, z=0.3), cone(40), water(1.0)),
        ImageCase("two lamps tilted, flat port, 2 m", WIDE, FLAT, 2.0, around, lobe(120), water(2.0)),
        ImageCase("narrow cone, dome, 5 m", WIDE, DOME, 5.0, lamp(y=0.4), cone(5), water(0.4)),
        ImageCase("measured flood, dome, 2 m", WIDE, DOME, 2.0, lamp(), flood(), water(1.0)),
    )


def disc(half_deg: float) -> beams.Beam:
    """An even disc."""
    return beams.disc_beam(math.radians(half_deg))


def cone(half_deg: float) -> beams.Beam:
    """A cone of even intensity."""
    return beams.cone_beam(math.radians(half_deg))


# ---------------------------------------------------------------- what the model does


def signal_table(light: ImageCase) -> PathTable:
    """Water's loss for the image's paths, as a search tabulates it."""
    u, v = (np.linspace(-half, half, 33) for half in light.half)
    x_m, y_m, path_m = floor_point(u[:, None], v, shape=light.shape, range_m=light.range_m)
    legs = [
        np.sqrt((x_m - x) ** 2 + (y_m - y) ** 2 + (light.range_m - z) ** 2)
        for x, y, z in zip(light.lamps.x_m, light.lamps.y_m, light.lamps.z_m, strict=True)
    ]
    nearest = min(light.range_m - z for z in light.lamps.z_m)
    return build_path_table(
        light.water.signal_weight,
        wavelength_nm=None,
        k_lamp_per_m=light.water.k_per_m,
        c_camera_per_m=light.water.c_per_m,
        lamp_range_m=(0.999 * nearest, 1.001 * float(np.max(legs))),
        camera_range_m=(0.999 * light.range_m, 1.001 * float(path_m.max())),
    )


def scatterers(light: ImageCase) -> tuple[Scatterer, ...]:
    """Particles and molecules with their tables of loss."""
    along, across = (np.array([half]) for half in light.half)
    lamp_range_m, camera_range_m = path_ranges_m(
        along, across, shape=light.shape, range_m=light.range_m, lamps=light.lamps,
        least_attenuation_per_m=(float(light.water.k_per_m.min()), float(light.water.c_per_m.min())),
    )  # fmt: skip
    return tuple(
        Scatterer(
            phase,
            build_path_table(
                weight,
                wavelength_nm=None,
                k_lamp_per_m=light.water.k_per_m,
                c_camera_per_m=light.water.c_per_m,
                lamp_range_m=lamp_range_m,
                camera_range_m=camera_range_m,
            ),
        )
        for phase, weight in zip(light.water.phases, light.water.scatter_weights, strict=True)
    )


Rule = Callable[[Array, Array, int | None], Array]


def model_of(light: ImageCase, target: str) -> Rule:
    """The model's function of images (half tangents) or pixels, and order; None is its own choice."""
    common: dict[str, Any] = dict(
        shape=light.shape, range_m=light.range_m, lamps=light.lamps, beam=light.beam
    )
    if target == SIGNAL:
        table = signal_table(light)
        return lambda u, v, order: field_mean(u, v, table=table, order=order, **common)
    common["scatterers"] = scatterers(light)
    if target == IMAGE_VEIL:
        return lambda u, v, order: mean_backscatter(u, v, order=order, **common)
    return lambda u, v, order: backscatter_gain(u, v, order=order, **common)


def places_of(light: ImageCase, target: str) -> tuple[Array, Array]:
    """The image, or the pixels at which a veil is compared."""
    points = PIXELS if target == PIXEL_VEIL else ((1.0, 1.0),)
    u, v = np.array(points).T
    return u * light.half[0], v * light.half[1]


def reference(light: ImageCase, target: str) -> Array:
    """The same by adaptive quadrature."""
    if target == SIGNAL:
        return np.array([exact.mean_signal(light)])
    if target == IMAGE_VEIL:
        return np.array([exact.mean_veil(light)])
    return np.array([exact.ray_veil(u, v, light) for u, v in zip(*places_of(light, target), strict=True)])


# ---------------------------------------------------------------- the suite


def orders_of(light: ImageCase, target: str, quick: bool) -> tuple[str, Sequence[int]]:
    """The rule that the model uses there, and the orders to try."""
    if target == PIXEL_VEIL:
        return GAUSS, RAY_ORDERS
    if target == SIGNAL and beams.has_sharp_edge(light.beam):
        return CELLS, CELL_ORDERS[:-1] if quick else CELL_ORDERS
    most = MOST_VEIL_ORDER[quick] if target == IMAGE_VEIL else SMOOTH_ORDERS[-1]
    return GAUSS, [n for n in SMOOTH_ORDERS if n <= most]


def chosen_order(light: ImageCase, target: str) -> float | None:
    """The order that the default takes, where it is one for the image."""
    if target != SIGNAL:
        return None
    along, across = (np.array([half]) for half in light.half)
    needed = cells_needed if beams.has_sharp_edge(light.beam) else orders_needed
    return float(needed(along, across, light.shape, light.range_m, light.lamps, light.beam)[0])


def measured_row(
    light: ImageCase, target: str, how: str, order: int | None, truth: Array, *, quick: bool
) -> BenchRow:
    """Greatest relative error, and time of one image or pixel among several."""
    model, (u, v) = model_of(light, target), places_of(light, target)
    nodes = (order or 20) ** (1 if target == PIXEL_VEIL else 2)
    copies = max(1, min(IMAGES, NODES_TOGETHER // (nodes * len(u))))
    shrink = np.linspace(1.0, 0.97, copies)[:, None]
    many_u, many_v = ((shrink * part).ravel() for part in (u, v))
    _, took_s = timed(
        lambda: model(many_u, many_v, order),
        at_least_s=0.004 if quick else 0.006,
        repeats=1 if quick else 2,
    )
    value = model(u, v, order)
    lit = truth > 0.0
    error = float(np.max(np.abs(value[lit] / truth[lit] - 1.0), initial=0.0))
    size = chosen_order(light, target) if order is None else float(order)
    dark = "" if np.all(value[~lit] == 0.0) else "light where there is none"
    return BenchRow(
        NAME, light.name, f"{target}, {how}", size, time_s=took_s / len(many_u), error=error, note=dark
    )


def measure(budget: Budget) -> Iterator[BenchRow]:
    """All targets of all cases, as far as the time goes."""
    todo = [(light, target) for light in cases(budget.quick) for target in TARGETS]
    for i, (light, target) in enumerate(todo):
        if budget.left_s <= 0.0:
            return
        budget.tell(i / len(todo), f"{light.name}: {target}")
        truth = reference(light, target)
        yield measured_row(light, target, AS_USED, None, truth, quick=budget.quick)
        how, orders = orders_of(light, target, budget.quick)
        for order in orders:
            if budget.left_s <= 0.0:
                return
            yield measured_row(light, target, how, order, truth, quick=budget.quick)
    budget.tell(1.0, "done")


def tables(rows: Sequence[BenchRow]) -> Sequence[BenchTable]:
    """By case: the default's error and time, and the least order that reaches 1e-4."""
    return [target_table(target, [row for row in rows if row.method.startswith(target)]) for target in TARGETS]


def target_table(target: str, rows: Sequence[BenchRow]) -> BenchTable:
    """One target."""
    lines = []
    for case in dict.fromkeys(row.case for row in rows):
        of_case = [row for row in rows if row.case == case]
        used = [row for row in of_case if row.method.endswith(AS_USED)]
        tried = [row for row in of_case if not row.method.endswith(AS_USED)]
        cells = [f"{used[0].error:.1e}", f"{used[0].time_s:.1e}", order_text(used[0])] if used else [""] * 3
        rule = tried[0].method.removeprefix(f"{target}, ") if tried else ""
        lines.append([case, *cells, rule, least_size(tried, TARGET)])
    return BenchTable(
        f"{target.capitalize()}: the default, and the least order for 1e-4",
        ["case", "error as used", "time as used, s", "order as used", "rule", "least order"],
        lines,
        "Least order: from which on all errors stay within 1e-4; more than: none of those tried.",
    )


def order_text(row: BenchRow) -> str:
    """An order for a cell; empty where the default raises it until the value stands still."""
    return "" if row.size is None else f"{row.size:g}"


SUITE = Suite(
    name=NAME,
    title="Integrals over the image and along rays",
    text=(
        "Three integrals: the signal's mean over the image, the veil of light scattered back along a pixel's ray, "
        "and that veil's mean over the image. Each is taken with a fixed order (nodes or cells a side of the image, "
        "nodes along a ray) and as used, with the order that the model chooses. They are compared with adaptive "
        "quadrature of integrands written separately: QUADPACK within QUADPACK over the image, split where a "
        "beam's edge lies, and the double exponential rule along rays; each colour is attenuated by itself, so the "
        "model's loss tables are part of the error. Lobes wide and narrow, beams with a sharp edge and a measured "
        "profile (its mean veil to 3e-5 only); near and far, dome and flat "
        "port, clear and thick water. Time is that of one image, or of one "
        "pixel, among several. To be read off: the order that 1e-4 takes for each kind of beam, and what the choice "
        "of the default costs beyond it."
    ),
    chart="precision",
    measure=measure,
    quick_s=8.0,
    full_s=90.0,
    size_name="order",
    time_name="time per image or pixel, s",
    tables=tables,
)
