"""Backscatter: against adaptive quadrature, closed forms and Monte Carlo, none of which share its variables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from thorough import drawn

from uwopt.model import beam as beams
from uwopt.model.imaging import Lamps, PortShape, floor_point
from uwopt.model.path_table import build_path_table
from uwopt.model.veil.geometry import Scatterer, camera_rays, nearest_approach_m, of_each, path_ranges_m
from uwopt.model.veil.mean import log_mean_backscatter, mean_backscatter
from uwopt.model.veil.ray import backscatter_gain, log_backscatter_gain

Array = np.ndarray
Phase = Callable[[Any], Any]

DOME = PortShape(is_dome=True, outer_radius_m=0.07, thickness_m=0.005, n_glass=1.5, gap_m=0.0, n_water=1.34)
FLAT = PortShape(is_dome=False, outer_radius_m=0.0, thickness_m=0.01, n_glass=1.5, gap_m=0.02, n_water=1.34)
SEALITE = pd.read_csv(Path(__file__).parents[1] / "reference" / "beam_profile_dspl_sealite.csv", comment="#")
BEAMS = {
    "disc 45": beams.disc_beam(np.deg2rad(45)),
    "cone 40": beams.cone_beam(np.deg2rad(40)),
    "cone 90": beams.cone_beam(np.pi / 2),
    "lobe 10": beams.cosine_power_beam(np.deg2rad(10)),
    "lobe 75": beams.cosine_power_beam(np.deg2rad(75)),
    "lobe 120": beams.cosine_power_beam(np.deg2rad(120)),
    "flood": beams.tabulated_beam(
        np.deg2rad(SEALITE.angle_deg.to_numpy()), SEALITE.flood_rel.to_numpy(), medium="water", n_w=1.34
    ),
}


def isotropic(cos: Any) -> Any:
    return 0 * cos + 1 / (4 * np.pi)


def particles(cos: Any) -> Any:
    """Henyey-Greenstein, g = 0.9."""
    return 0.19 / (4 * np.pi) / (1.81 - 1.8 * cos) ** 1.5


def molecules(cos: Any) -> Any:
    return 3 / (16 * np.pi) * (1 + cos * cos)


PHASES: tuple[Phase, ...] = (particles, molecules)


class Water:
    """A few wavelengths: weights of the components, K and c."""

    def __init__(self, c_most_per_m: float, grey: bool = False) -> None:
        x = np.zeros(1) if grey else np.linspace(0, 1, 9)
        self.c = c_most_per_m * (1 - 0.7 * x * (2 - x))
        self.k = 0.6 * self.c
        self.weights = (np.exp(-(((x - 0.4) / 0.3) ** 2)), 0.05 * (0.2 + x))

    def scatterers(
        self, half: tuple[float, float], phases: tuple[Phase, ...] = PHASES, **scene: Any
    ) -> tuple[Scatterer, ...]:
        lamp_range_m, camera_range_m = path_ranges_m(
            np.array([half[0]]),
            np.array([half[1]]),
            **scene,
            least_attenuation_per_m=(self.k.min(), self.c.min()),
        )
        common = dict(
            wavelength_nm=None,
            k_lamp_per_m=self.k,
            c_camera_per_m=self.c,
            lamp_range_m=lamp_range_m,
            camera_range_m=camera_range_m,
        )
        return tuple(
            Scatterer(phase, build_path_table(w, **common))  # type: ignore[arg-type]
            for phase, w in zip(phases, self.weights, strict=False)
        )


def lamp(x: float = 0.0, y: float = 0.5, z: float = 0.0, tilt_deg: float = 0.0, share: float = 1.0) -> Lamps:
    tilt = np.deg2rad(tilt_deg)
    return Lamps((x,), (y,), (z,), ((0.0, np.sin(tilt), np.cos(tilt)),), (share,))


def two(first: Lamps, second: Lamps) -> Lamps:
    return Lamps(*(a + b for a, b in zip(vars(first).values(), vars(second).values(), strict=True)))


# ---------------------------------------------------------------- the ray, by vectors and adaptive quadrature


def traced_ray(u: float, v: float, shape: PortShape, range_m: float) -> tuple[Array, Array, float]:
    """Start, direction and length of a pixel's ray, by angles."""
    theta = np.arctan(np.hypot(u, v))
    radial = np.array([u, v]) / max(np.hypot(u, v), 1e-300)
    if shape.is_dome:
        direction = np.r_[np.sin(theta) * radial, np.cos(theta)]
        start = np.array([0, 0, -shape.outer_radius_m]) + shape.outer_radius_m * direction
    else:
        in_glass, in_water = (
            np.arcsin(np.sin(theta) / shape.n_glass),
            np.arcsin(np.sin(theta) / shape.n_water),
        )
        direction = np.r_[np.sin(in_water) * radial, np.cos(in_water)]
        start = np.r_[(shape.gap_m * np.tan(theta) + shape.thickness_m * np.tan(in_glass)) * radial, 0.0]
    return start, direction, (range_m - start[2]) / direction[2]


def log_by_quadrature(
    u: float, v: float, *, shape: PortShape, range_m: float, lamps: Lamps, beam: beams.Beam, water: Water,
    phases: tuple[Phase, ...] = PHASES,
) -> float:  # fmt: skip
    """ln of the integral over r by scipy's adaptive quadrature, between places that a scan finds interesting."""
    start, direction, length = traced_ray(u, v, shape, range_m)
    cos_edge = np.cos(beams.edge_half_angle_rad(beam))
    total = -np.inf
    for x, y, z, aim, share in zip(*vars(lamps).values(), strict=True):
        lamp_at, lamp_axis = np.array([x, y, z]), np.array(aim)

        def seen(r: Any, place: Array = lamp_at, axis: Array = lamp_axis) -> Any:
            way = start + np.multiply.outer(r, direction) - place
            lamp_range_m = np.sqrt((way * way).sum(axis=-1))
            return lamp_range_m, way @ axis / lamp_range_m, -(way @ direction) / lamp_range_m

        def log_integrand(r: Any, seen: Any = seen) -> Any:
            lamp_range_m, cos_beam, cos_scatter = seen(r)
            loss = -np.multiply.outer(lamp_range_m, water.k) - np.multiply.outer(r, water.c)
            top = loss.max(axis=-1)
            intensity = beams.intensity_per_sr(np.minimum(cos_beam, 1.0), beams.without_edge(beam))
            scattered = sum(
                p(cos_scatter) * (np.exp(loss - top[..., None]) @ w)
                for p, w in zip(phases, water.weights, strict=False)
            )
            with np.errstate(divide="ignore"):
                return np.log(intensity * scattered / lamp_range_m**2) + top

        closest = float(np.clip((np.array([x, y, z]) - start) @ direction, 0, length))
        distance = float(seen(closest)[0])
        scan = np.r_[
            np.linspace(0, length, 80),
            np.geomspace(1e-6 * length, length, 80),
            closest + distance * np.sinh(np.linspace(-9, 9, 80)),
        ]
        scan = np.unique(np.clip(scan, 0, length))
        inside = seen(scan)[1] - cos_edge
        edges = [
            brentq(lambda r, seen=seen: float(seen(r)[1] - cos_edge), scan[i], scan[i + 1], xtol=1e-15)
            for i in np.nonzero(inside[1:] * inside[:-1] < 0)[0]
        ]
        scan = np.unique(np.r_[scan, edges])
        middle = 0.5 * (scan[1:] + scan[:-1])
        lit = seen(middle)[1] > cos_edge
        if not lit.any():
            continue
        levels = np.where(lit, log_integrand(middle), -np.inf) + np.log(np.diff(scan))
        top = levels.max()
        integral = 0.0
        for low, high, level in zip(scan[:-1], scan[1:], levels, strict=True):
            if level > top - 30:
                scaled = lambda r: float(np.exp(log_integrand(np.float64(r)) - top))  # noqa: B023, E731
                integral += quad(scaled, low, high, epsabs=1e-9, epsrel=1e-9, limit=100)[0]
        total = np.logaddexp(total, np.log(integral) + top + np.log(share))
    return float(total - 2 * np.log(1 + u * u + v * v))


UNEQUAL = two(lamp(share=0.7, tilt_deg=15), lamp(x=0.1, y=-0.3, share=0.3))
# beam, port, altitude, largest c r, lamps
RAY_CASES = {
    "ordinary": ("lobe 75", DOME, 2.0, 2.0, lamp()),
    "two lamps, tilted, unequal": ("lobe 120", DOME, 2.0, 2.0, UNEQUAL),
    "flat port": ("lobe 75", FLAT, 2.0, 5.0, lamp(y=0.3, tilt_deg=-20)),
    "lamp below the port": ("lobe 120", DOME, 3.0, 3.0, lamp(y=1.2, z=0.4)),
    "lamp above the port": ("cone 40", FLAT, 1.0, 1.0, lamp(y=0.2, z=-0.3)),
    "at the lamp's front radius": ("cone 90", FLAT, 10.0, 10.0, lamp(y=0.045)),
    "near floor": ("disc 45", FLAT, 0.06, 0.1, lamp(y=0.05)),
    "high": ("lobe 10", DOME, 50.0, 30.0, lamp(y=5.0)),
    "narrow lobe, inwards": ("lobe 10", DOME, 2.0, 2.0, lamp(y=0.5, tilt_deg=-14)),
    "cone, inwards": ("cone 40", DOME, 2.0, 2.0, lamp(y=0.5, tilt_deg=-30)),
    "cone from behind the image": ("cone 40", DOME, 5.0, 2.0, lamp(y=3.0, tilt_deg=-65)),
    "clear water": ("lobe 75", DOME, 2.0, 1e-6, lamp()),
    "thick water": ("lobe 75", DOME, 2.0, 100.0, lamp()),
    "very thick water": ("lobe 120", FLAT, 10.0, 2000.0, lamp(y=0.1)),
}  # fmt: skip


#: What others show at more telling numbers: clear and very thick water, a flat port before a lamp that is nearer.
IMPLIED = ("ordinary", "flat port", "cone, inwards", "thick water")


@pytest.mark.parametrize("name", drawn([name for name in RAY_CASES if name not in IMPLIED], list(RAY_CASES)))
def test_a_pixels_veil_agrees_with_adaptive_quadrature(name: str) -> None:
    beam, shape, range_m, optical, lamps = RAY_CASES[name]
    water = Water(optical / range_m)
    scene = dict(shape=shape, range_m=range_m, lamps=lamps)
    scatterers = water.scatterers((0.45, 0.45), **scene)
    pixels = drawn([(0.0, 0.0), (0.45, 0.45), (-0.2, -0.4)], [(0.0, 0.0), (0.45, 0.45), (-0.2, -0.4), (0.1, 0.4)])
    u, v = np.array(pixels).T
    ours = log_backscatter_gain(u, v, **scene, beam=BEAMS[beam], scatterers=scatterers)  # type: ignore[arg-type]
    exact = [log_by_quadrature(*p, **scene, beam=BEAMS[beam], water=water) for p in pixels]  # type: ignore[arg-type]
    assert np.any(np.isfinite(exact))
    np.testing.assert_array_equal(np.isneginf(ours), np.isneginf(exact))
    np.testing.assert_allclose(np.exp(ours - np.maximum(exact, -1e9)), np.isfinite(exact), rtol=1e-5)


def test_rays_end_where_the_signals_rays_meet_the_floor() -> None:
    u, v = np.array([0.0, 0.3, -0.5]), np.array([0.0, 0.6, 0.2])
    for shape in (DOME, FLAT):
        rays = camera_rays(u, v, shape=shape, range_m=2.0)
        x_m, y_m, path_m = floor_point(u, v, shape=shape, range_m=2.0)
        np.testing.assert_allclose(rays.path_m, path_m, rtol=1e-12)
        np.testing.assert_allclose(rays.x_m + path_m * rays.along_x, x_m, atol=1e-9)
        np.testing.assert_allclose(rays.y_m + path_m * rays.along_y, y_m, atol=1e-9)
        np.testing.assert_allclose(rays.z_m + path_m * rays.along_z, 2.0, rtol=1e-12)


# ---------------------------------------------------------------- closed forms


@pytest.mark.parametrize("baseline_m", [0.02, 0.5, 5.0])
def test_even_light_in_clear_water_gives_an_arctangent(baseline_m: float) -> None:
    # axis of a flat port, I = 1/(2 pi), p = 1/(4 pi): integral of dr/(b^2 + r^2) = arctan(d/b)/b
    scene = dict(shape=FLAT, range_m=3.0, lamps=lamp(y=baseline_m))
    scatterers = Water(0.0, grey=True).scatterers((0.1, 0.1), phases=(isotropic,), **scene)
    ours = backscatter_gain(
        np.array([0.0]), np.array([0.0]), **scene, beam=BEAMS["cone 90"], scatterers=scatterers  # type: ignore[arg-type]
    )  # fmt: skip
    weight = np.exp(-((0.4 / 0.3) ** 2))
    assert ours[0] == pytest.approx(
        weight * np.arctan(3 / baseline_m) / baseline_m / (8 * np.pi**2), rel=1e-7
    )


@pytest.mark.parametrize("u", [0.0, 0.6])
def test_a_lamp_far_above_gives_the_plane_parallel_veil(u: float) -> None:
    # I/H^2 p exp(-K H) (1 - exp(-(K cos + c) l)) / (K cos + c), to the order of l/H = 1e-6
    height_m, range_m, water = 2e6, 2.0, Water(0.5, grey=True)
    scene = dict(shape=FLAT, range_m=range_m, lamps=lamp(y=0.0, z=-height_m))
    scatterers = water.scatterers((0.7, 0.7), phases=(isotropic,), **scene)
    ours = log_backscatter_gain(
        np.array([u]), np.array([0.0]), **scene, beam=BEAMS["cone 90"], scatterers=scatterers
    )  # type: ignore[arg-type]
    cos = np.cos(np.arcsin(np.sin(np.arctan(u)) / FLAT.n_water))
    slope = 0.3 * cos + 0.5
    plane = (1 - np.exp(-slope * range_m / cos)) / slope / (2 * np.pi * height_m**2) / (4 * np.pi)
    expected = np.log(plane * np.exp(-((0.4 / 0.3) ** 2))) - 0.3 * height_m - 2 * np.log(1 + u * u)
    assert ours[0] == pytest.approx(expected, abs=1e-4)


def test_a_deep_thick_sea_keeps_its_logarithm() -> None:
    # K = 120, c = 200 1/m over 10 m, lamp 3 m off: the veil comes from the first centimetres: e^-360,
    # and some e^-20 for a lamp seen at a grazing angle, 1/r_s^2, p and 1/c
    water, scene = Water(200.0, grey=True), dict(shape=FLAT, range_m=10.0, lamps=lamp(y=3.0))
    scatterers = water.scatterers((0.3, 0.3), **scene)
    common = dict(**scene, beam=BEAMS["lobe 120"], scatterers=scatterers)
    ours = log_backscatter_gain(np.array([0.0]), np.array([0.0]), **common)  # type: ignore[arg-type]
    exact = log_by_quadrature(0.0, 0.0, **scene, beam=BEAMS["lobe 120"], water=water)  # type: ignore[arg-type]
    assert exact == pytest.approx(-380, abs=5)
    assert ours[0] == pytest.approx(exact, abs=1e-5)
    half = np.array([0.3])
    assert np.isfinite(log_mean_backscatter(half, half, **common)[0])  # type: ignore[arg-type]
    assert 0 <= mean_backscatter(half, half, **common)[0] < 1e-100  # type: ignore[arg-type]


# ---------------------------------------------------------------- Monte Carlo


def test_photons_scattered_once_give_the_same_mean() -> None:
    # Photons leave the lamp by its lobe, travel a free path, scatter once; each sends its share to the
    # pinhole in the dome's centre: mean of cos^4 L over tangents = 1/area * sum of cos(field) p exp(-c r)/l^2.
    n, half, range_m, k, c, scatter = 3_000_000, (0.3, 0.45), 1.5, 0.5, 0.8, 0.4
    exponent = 3.0
    beam = beams.cosine_power_beam(2 * np.arccos(0.5 ** (1 / exponent)))
    lamps = lamp(y=0.4, tilt_deg=-10)
    rng = np.random.default_rng(7)
    cos, turn = rng.random(n) ** (1 / (exponent + 1)), 2 * np.pi * rng.random(n)
    sin, tilt = np.sqrt(1 - cos * cos), np.deg2rad(-10)
    local = sin * np.cos(turn), sin * np.sin(turn), cos
    way = np.array(
        [local[0], np.cos(tilt) * local[1] + np.sin(tilt) * local[2], np.cos(tilt) * local[2] - np.sin(tilt) * local[1]]
    )  # fmt: skip
    free_m = rng.exponential(1 / k, n)
    place = way * free_m + np.array([0.0, 0.4, 0.0])[:, None]
    to_centre = -place - np.array([0, 0, DOME.outer_radius_m])[:, None]
    length = np.sqrt((to_centre**2).sum(axis=0))
    height = -to_centre[2]
    seen = (place[2] < range_m) & (height > 0) & (length > DOME.outer_radius_m)
    seen &= (np.abs(to_centre[0]) < half[0] * height) & (np.abs(to_centre[1]) < half[1] * height)
    cos_scatter = (way * to_centre).sum(axis=0) / length
    scores = np.where(
        seen,
        scatter
        / k
        * particles(cos_scatter)
        * np.exp(-c * (length - DOME.outer_radius_m))
        * height
        / length**3,
        0.0,
    ) / (4 * half[0] * half[1])
    mean, sigma = scores.mean(), scores.std() / np.sqrt(n)
    assert sigma < 0.01 * mean
    table = build_path_table(
        [scatter], wavelength_nm=None, k_lamp_per_m=[k], c_camera_per_m=[c],
        lamp_range_m=(0.1, 3), camera_range_m=(0, 3),
    )  # fmt: skip
    ours = mean_backscatter(
        np.array([half[0]]), np.array([half[1]]), shape=DOME, range_m=range_m, lamps=lamps, beam=beam,
        scatterers=(Scatterer(particles, table),),
    )  # fmt: skip
    assert ours[0] == pytest.approx(mean, abs=3 * sigma)


# ---------------------------------------------------------------- means over images


def mean_by_brute_force(
    half: tuple[float, float], n: int, n_ray: int, *, water: Water, **scene: Any
) -> float:
    """Product of Gauss rules in the field, midpoints along rays in asinh of the distance from the lamp's foot."""
    lamps, beam, shape, range_m = scene["lamps"], scene["beam"], scene["shape"], scene["range_m"]
    nodes, weights = np.polynomial.legendre.leggauss(n)
    total = 0.0
    for u, u_weight in zip(nodes * half[0], weights / 2, strict=True):
        for v, v_weight in zip(nodes * half[1], weights / 2, strict=True):
            start, direction, length = traced_ray(u, v, shape, range_m)
            gain = 0.0
            for x, y, z, aim, share in zip(*vars(lamps).values(), strict=True):
                place = np.array([x, y, z])
                foot = (place - start) @ direction
                scale = np.linalg.norm(start + foot * direction - place)
                low, high = np.arcsinh(-foot / scale), np.arcsinh((length - foot) / scale)
                step = (high - low) / n_ray
                q = low + step * (np.arange(n_ray) + 0.5)
                r, dr = foot + scale * np.sinh(q), scale * np.cosh(q) * step
                way = start + r[:, None] * direction - place
                lamp_range_m = np.sqrt((way * way).sum(axis=1))
                intensity = beams.intensity_per_sr(way @ np.array(aim) / lamp_range_m, beam)
                cos_scatter = -(way @ direction) / lamp_range_m
                loss = np.exp(-np.outer(lamp_range_m, water.k) - np.outer(r, water.c))
                beta = sum(p(cos_scatter) * (loss @ w) for p, w in zip(PHASES, water.weights, strict=True))
                gain += share * float((intensity / lamp_range_m**2 * beta * dr).sum())
            total += u_weight * v_weight * gain / (1 + u * u + v * v) ** 2
    return total


def test_a_measured_profiles_veil_on_the_axis_agrees_with_brute_force() -> None:
    water, scene = Water(0.5), dict(shape=DOME, range_m=2.0, lamps=lamp())
    scatterers = water.scatterers((0.4, 0.4), **scene)
    axis = np.array([0.0])
    ours = backscatter_gain(axis, axis, **scene, beam=BEAMS["flood"], scatterers=scatterers)  # type: ignore[arg-type]
    exact = mean_by_brute_force((1e-9, 1e-9), 1, 200_000, water=water, **scene, beam=BEAMS["flood"])
    assert ours[0] == pytest.approx(exact, rel=1e-4)  # the digitised curve has a kink every half degree


ALL_ROUND = two(lamp(x=0.2, y=0.4, share=0.5, tilt_deg=10), lamp(x=-0.3, y=0.2, share=0.5))
MEAN_CASES = {  # beam, port, altitude, c r, lamps, nodes of the brute force: field, ray
    "ordinary": ("lobe 75", DOME, 2.0, 2.0, two(lamp(share=0.5), lamp(y=-0.5, share=0.5)), 12, 3000),
    "lamps all round": ("lobe 120", FLAT, 2.0, 4.0, ALL_ROUND, 12, 3000),
    "narrow lobe": ("lobe 10", DOME, 2.0, 2.0, lamp(tilt_deg=-8), 30, 1000),
    "thick water": ("lobe 75", DOME, 2.0, 80.0, lamp(), 14, 6000),
    "cone's edge across the image": ("cone 40", DOME, 2.0, 2.0, lamp(y=1.0, z=0.3), 60, 1500),
    "measured profile": ("flood", DOME, 2.0, 2.0, lamp(), 30, 3000),
}  # fmt: skip


@pytest.mark.parametrize("name", MEAN_CASES)
def test_an_images_mean_agrees_with_brute_force(name: str) -> None:
    beam, shape, range_m, optical, lamps, n, n_ray = MEAN_CASES[name]
    water, half = Water(optical / range_m), (0.35, 0.45)
    scene = dict(shape=shape, range_m=range_m, lamps=lamps)
    scatterers = water.scatterers(half, **scene)
    ours = mean_backscatter(
        np.array([half[0]]), np.array([half[1]]), **scene, beam=BEAMS[beam], scatterers=scatterers  # type: ignore[arg-type]
    )  # fmt: skip
    exact = mean_by_brute_force(half, n, n_ray, water=water, **scene, beam=BEAMS[beam])
    # a cone's edge leaves 2e-4 in the brute force itself
    assert ours[0] == pytest.approx(exact, rel=4e-4 if beam == "cone 40" else 1e-4)


def ordinary(lamps: Lamps, half: tuple[float, float] = (0.3, 0.4), **changed: Any) -> dict[str, Any]:
    scene: dict[str, Any] = dict(shape=DOME, range_m=2.0, lamps=lamps) | changed
    scatterers = Water(1.0).scatterers(half, **scene)
    return scene | dict(beam=BEAMS["lobe 75"], scatterers=scatterers)


HALF = np.array([0.3]), np.array([0.4])


def test_the_veil_is_linear_in_the_lamps_shares() -> None:
    first, second = lamp(share=1.0), lamp(x=0.3, y=-0.8, tilt_deg=20)
    both = ordinary(two(first, second))
    a, b = (backscatter_gain(*HALF, **(both | dict(lamps=one))) for one in (first, second))
    shared = two(lamp(share=0.3), lamp(x=0.3, y=-0.8, tilt_deg=20, share=0.7))
    ours = backscatter_gain(*HALF, **(both | dict(lamps=shared)))
    # as close as the numbers of nodes, chosen for each lamp, allow
    np.testing.assert_allclose(ours, 0.3 * a + 0.7 * b, rtol=1e-9)


def test_mirrored_lamps_veil_mirrored_pixels_alike() -> None:
    right, left = lamp(y=0.5, tilt_deg=20), lamp(y=-0.5, tilt_deg=-20)
    u, v = np.array([0.2, -0.1]), np.array([0.3, 0.35])
    scene = ordinary(right)
    here = backscatter_gain(u, v, **scene)
    np.testing.assert_allclose(here, backscatter_gain(u, -v, **(scene | dict(lamps=left))), rtol=1e-12)
    np.testing.assert_allclose(here, backscatter_gain(-u, v, **scene), rtol=1e-12)
    sides = two(lamp(y=0.5, tilt_deg=20, share=0.5), lamp(y=-0.5, tilt_deg=-20, share=0.5))
    one_side = mean_backscatter(*HALF, **scene)
    np.testing.assert_allclose(one_side, mean_backscatter(*HALF, **(scene | dict(lamps=sides))), rtol=1e-12)


def test_half_an_image_stands_for_the_whole() -> None:
    whole = lamp(x=1e-13)  # too little to change anything, enough to break the symmetry
    halved = mean_backscatter(*HALF, **ordinary(lamp()))
    np.testing.assert_allclose(mean_backscatter(*HALF, **ordinary(whole)), halved, rtol=2e-5)


@pytest.mark.parametrize("beam", ["lobe 75", "lobe 10", "cone 40"])
def test_many_images_at_once_are_as_each_alone(beam: str) -> None:
    along, across = np.linspace(0.05, 0.5, 40), np.linspace(0.6, 0.1, 40)
    scene = ordinary(lamp(), half=(0.5, 0.6)) | dict(beam=BEAMS[beam])
    together = mean_backscatter(along, across, **scene)
    alone = [float(mean_backscatter(along[i : i + 1], across[i : i + 1], **scene)[0]) for i in range(40)]
    np.testing.assert_allclose(together, alone, rtol=1e-8)  # as the nodes along rays, chosen for all, allow


@pytest.mark.parametrize("beam", ["lobe 75", "cone 40"])
def test_images_at_altitudes_each_with_its_own_particles_are_as_each_alone(beam: str) -> None:
    along, across = np.array([0.1, 0.5, 0.2, 0.4]), np.array([0.6, 0.1, 0.3, 0.4])
    range_m = np.array([2.0, 1.0, 3.0, 1.5])
    scene = ordinary(lamp(), half=(0.5, 0.6), range_m=3.5) | dict(beam=BEAMS[beam])
    grains, gas = scene.pop("scatterers")
    waters = ((grains, gas), (replace(grains, phase=isotropic), replace(gas, phase=isotropic)))
    of = np.array([0, 1, 1, 0])
    together = mean_backscatter(along, across, **(scene | dict(range_m=range_m, scatterers=of_each(waters, of))))
    alone = [
        float(mean_backscatter(*one, **(scene | dict(range_m=float(way), scatterers=waters[own])))[0])
        for *one, way, own in zip(along[:, None], across[:, None], range_m, of, strict=True)
    ]
    np.testing.assert_allclose(together, alone, rtol=1e-7)  # as the nodes along rays, chosen for all, allow


def test_a_small_image_sees_the_axis() -> None:
    tiny, scene = np.array([1e-4]), ordinary(lamp())
    axis = backscatter_gain(np.array([0.0]), np.array([0.0]), **scene)
    np.testing.assert_allclose(mean_backscatter(tiny, tiny, **scene), axis, rtol=1e-6)


def test_clear_water_is_the_limit_of_thin_water() -> None:
    gains = []
    for c in (0.0, 5e-7):
        scene = dict(shape=DOME, range_m=2.0, lamps=lamp())
        scatterers = Water(c).scatterers((0.3, 0.4), **scene)
        gains.append(mean_backscatter(*HALF, **scene, beam=BEAMS["lobe 75"], scatterers=scatterers)[0])  # type: ignore[arg-type]
    assert gains[1] == pytest.approx(gains[0], rel=5e-6)  # c r + K r_s = 2e-6 to 3e-6
    assert gains[1] < gains[0]


def test_the_veil_falls_as_the_lamp_moves_away() -> None:
    # Jaffe (1990): separation of lamp and camera is what raises contrast
    baselines = (0.15, 0.3, 0.6, 1.0, 1.6, 2.5)
    means = [mean_backscatter(*HALF, **ordinary(lamp(y=b)))[0] for b in baselines]
    assert np.all(np.diff(means) < 0)


def test_lamps_that_light_no_ray_leave_no_veil() -> None:
    away = Lamps((0.0,), (0.5,), (-0.1,), ((0.0, 0.0, -1.0),), (1.0,))
    assert mean_backscatter(*HALF, **ordinary(away))[0] == 0.0
    assert log_mean_backscatter(*HALF, **ordinary(away))[0] == -np.inf


def test_water_that_does_not_scatter_leaves_no_veil() -> None:
    table = build_path_table(
        [0.0], wavelength_nm=None, k_lamp_per_m=[1.0], c_camera_per_m=[1.0],
        lamp_range_m=(0.1, 9), camera_range_m=(0, 9),
    )  # fmt: skip
    clean = ordinary(lamp()) | dict(scatterers=(Scatterer(isotropic, table),))
    assert mean_backscatter(*HALF, **clean)[0] == 0.0


# ---------------------------------------------------------------- helpers


def test_nearest_approach_is_the_distance_to_the_outermost_ray() -> None:
    # dome: the ray at 0.4 across starts at the centre (0, -R); distance of (b, 0) from it is b cos - R sin
    angle = np.arctan(0.4)
    expected = 0.5 * np.cos(angle) - DOME.outer_radius_m * np.sin(angle)
    ours = nearest_approach_m(*HALF, shape=DOME, range_m=2.0, lamps=lamp())
    assert ours[0] == pytest.approx(expected, rel=1e-6)
    in_view = nearest_approach_m(*HALF, shape=DOME, range_m=2.0, lamps=lamp(y=0.2, z=0.9))
    assert in_view[0] < 1e-3


@pytest.mark.parametrize("shape", [DOME, FLAT])
def test_path_ranges_hold_every_point_of_every_ray(shape: PortShape) -> None:
    lamps = two(lamp(y=0.4, z=-0.2), lamp(x=0.3, y=-0.7))
    scene = dict(shape=shape, range_m=2.0, lamps=lamps)
    (least, most), (start, end) = path_ranges_m(*HALF, **scene)  # type: ignore[arg-type]
    rng = np.random.default_rng(1)
    seen = []
    for u, v in [*rng.uniform(-1, 1, (300, 2)) * [0.3, 0.4], (0.3, 0.4), (-0.3, -0.4), (0.3, -0.4)]:
        origin, direction, length = traced_ray(u, v, shape, 2.0)
        points = origin + np.linspace(0, length, 200)[:, None] * direction
        assert start <= length <= end * (1 + 1e-12)
        places = np.array([lamps.x_m, lamps.y_m, lamps.z_m]).T
        seen.extend(np.linalg.norm(points - place, axis=1) for place in places)
    assert least <= np.min(seen)
    assert np.max(seen) <= most * (1 + 1e-12)


def test_tables_end_where_thick_water_shows_nothing() -> None:
    lamp_range_m, camera_range_m = path_ranges_m(
        *HALF, shape=DOME, range_m=20.0, lamps=lamp(), least_attenuation_per_m=(10.0, 20.0)
    )
    assert camera_range_m == (0.0, 3.0)  # 60 / 20
    assert lamp_range_m[1] == pytest.approx(lamp_range_m[0] + 6.0, abs=1e-3)  # 60 / 10
