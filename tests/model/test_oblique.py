"""Oblique views: rays, footprints and light on a tilted plane, against closed forms, ray tracing and plain sums."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from uwopt.model import beam as beams
from uwopt.model.footprint import (
    floor_area_ratio,
    floor_illuminance_per_lm,
    floor_steps,
    footprint_illuminance_per_lm,
)
from uwopt.model.image_mean import field_mean
from uwopt.model.imaging import Lamps, PortShape, axial_range_m, floor_point, local_gain
from uwopt.model.path_table import build_path_table
from uwopt.model.veil.geometry import Scatterer, camera_rays
from uwopt.model.veil.mean import mean_backscatter

Array = np.ndarray
PITCH = np.deg2rad(40.0)
DOME = PortShape(True, 0.07, 0.005, 1.5, 0.0, 1.34, slope=float(np.tan(PITCH)))
FLAT = PortShape(False, 0.0, 0.01, 1.5, 0.03, 1.34, slope=float(np.tan(PITCH)))
HEIGHT_M = 1.6
RANGE_M = HEIGHT_M / float(np.cos(PITCH))
U, V = 0.45, 0.6
LAMPS = Lamps((0.0, 0.1), (0.5, -0.4), (0.0, 0.05), ((0.0, 0.0, 1.0), (0.1, 0.2, 0.9746794)), (0.6, 0.4))


def down_to_earth(x: Any, y: Any, z: Any) -> tuple[Any, Any, Any]:
    """A point of the camera's frame in one whose z points straight down: turned about the athwartships axis."""
    return x * np.cos(PITCH) + z * np.sin(PITCH), y, z * np.cos(PITCH) - x * np.sin(PITCH)


def traced(u: float, v: float, shape: PortShape) -> tuple[float, float, float]:
    """Where a ray meets the level floor, and its way in water: by Snell's law in the earth's frame, for one ray."""
    radius = np.hypot(u, v)
    if shape.is_dome:
        start = down_to_earth(0.0, 0.0, -shape.outer_radius_m)
        way = np.array(down_to_earth(u, v, 1.0)) / np.sqrt(1.0 + radius**2)
        length = (HEIGHT_M - start[2]) / way[2]
        hit = np.array(start) + length * way
        return float(hit[0]), float(hit[1]), float(length - shape.outer_radius_m)
    air = np.arctan(radius)
    glass, water = (np.arcsin(np.sin(air) / n) for n in (shape.n_glass, shape.n_water))
    off = shape.gap_m * np.tan(air) + shape.thickness_m * np.tan(glass)
    toward = np.array([u, v]) / radius
    start_point = np.array(down_to_earth(*(off * toward), 0.0))
    way = np.array(down_to_earth(*(np.sin(water) * toward), np.cos(water)))
    length = (HEIGHT_M - start_point[2]) / way[2]
    hit = start_point + length * way
    return float(hit[0]), float(hit[1]), float(length)


@pytest.mark.parametrize("shape", [DOME, FLAT], ids=["dome", "flat"])
@pytest.mark.parametrize(("u", "v"), [(U, V), (-U, V), (0.2, -0.5), (-0.3, 0.01)])
def test_rays_meet_the_level_floor_where_snell_and_a_turned_camera_send_them(
    shape: PortShape, u: float, v: float
) -> None:
    x, y, path = floor_point(np.array(u), np.array(v), shape=shape, range_m=RANGE_M)
    z = RANGE_M + shape.slope * x
    earth = down_to_earth(x, y, z)
    expected = traced(u, v, shape)
    assert earth[2] == pytest.approx(HEIGHT_M, rel=1e-12)  # on the floor
    assert (float(earth[0]), float(earth[1]), float(path)) == pytest.approx(expected, rel=1e-12)
    assert float(camera_rays(np.array(u), np.array(v), shape=shape, range_m=RANGE_M).path_m) == pytest.approx(
        expected[2], rel=1e-12
    )


def test_dome_sees_the_trapezoid_of_plane_geometry() -> None:
    """h (tan(pitch + a) - tan(pitch - a)) deep from the dome's centre; half its edges h cos(a) v / cos(pitch +- a)."""
    height, half = HEIGHT_M + 0.07 * np.cos(PITCH), np.arctan(U)
    sides = np.array([0.0, V])
    far, near = (floor_point(np.full(2, s * U), sides, shape=DOME, range_m=RANGE_M) for s in (1.0, -1.0))
    depth = (far[0][0] - near[0][0]) / np.cos(PITCH)
    assert depth == pytest.approx(height * (np.tan(PITCH + half) - np.tan(PITCH - half)), rel=1e-12)
    for edge, angle in ((far, PITCH + half), (near, PITCH - half)):
        assert edge[1][1] == pytest.approx(height / np.cos(angle) * np.cos(half) * V, rel=1e-12)


@pytest.mark.parametrize("shape", [DOME, FLAT], ids=["dome", "flat"])
def test_steps_on_the_floor_are_the_derivatives_of_its_points(shape: PortShape) -> None:
    u, v, small = np.array([U, -U, 0.1]), np.array([V, V, -0.3]), 1e-6

    def place(u: Array, v: Array) -> tuple[Array, Array]:
        x, y, _ = floor_point(u, v, shape=shape, range_m=RANGE_M)
        return x / np.cos(PITCH), y

    steps = floor_steps(u, v, shape=shape, range_m=RANGE_M)
    for by_u, (along, across) in ((1.0, (steps.along_u, steps.across_u)), (0.0, (steps.along_v, steps.across_v))):
        du, dv = small * by_u, small * (1.0 - by_u)
        after, before = place(u + du, v + dv), place(u - du, v - dv)
        assert along == pytest.approx((after[0] - before[0]) / (2 * small), rel=1e-7, abs=1e-8)
        assert across == pytest.approx((after[1] - before[1]) / (2 * small), rel=1e-7, abs=1e-8)


@pytest.mark.parametrize("shape", [DOME, FLAT], ids=["dome", "flat"])
def test_moving_the_floor_by_the_least_way_moves_the_image_by_one_tangent(shape: PortShape) -> None:
    """The image of a point that the floor carries along its motion, found by solving for its ray."""
    u, v, way = -U, V, 1e-6
    steps = floor_steps(np.array(u), np.array(v), shape=shape, range_m=RANGE_M)
    for axis, least in enumerate(steps.least_moved_m):
        jacobian = np.array([[steps.along_u, steps.along_v], [steps.across_u, steps.across_v]])
        moved = np.linalg.solve(jacobian, way * np.eye(2)[axis])
        assert np.hypot(*moved) * float(least) == pytest.approx(way, rel=1e-9)


def test_without_pitch_a_plane_is_square_and_all_rays_meet_it_at_its_range() -> None:
    for shape in (DOME, FLAT):
        square = shape._replace(slope=0.0)
        assert axial_range_m(np.array([U]), np.array([V]), shape=square, range_m=RANGE_M) == RANGE_M
        nearly = shape._replace(slope=1e-9)
        by_limit, own = (
            floor_area_ratio(np.array(U), np.array(V), shape=one, range_m=RANGE_M) for one in (nearly, square)
        )
        assert by_limit == pytest.approx(own, rel=1e-7)


K, C = 0.4, 0.7
LOBE = beams.cosine_power_beam(np.deg2rad(70.0))
GREY = build_path_table(
    np.ones(3), wavelength_nm=None, k_lamp_per_m=np.full(3, K), c_camera_per_m=np.full(3, C),
    lamp_range_m=(0.2, 30.0), camera_range_m=(0.2, 30.0),
)  # fmt: skip


def expected_gain(u: float, v: float, shape: PortShape) -> float:
    """Light of a pixel by hand: Lambert's cosine at the level floor, both legs, cos^4 in air."""
    x, y, path = traced(u, v, shape)
    total = 0.0
    for n, share in enumerate(LAMPS.share):
        lamp = np.array(down_to_earth(LAMPS.x_m[n], LAMPS.y_m[n], LAMPS.z_m[n]))
        aim = np.array(down_to_earth(*LAMPS.aim[n]))
        ray = np.array([x, y, HEIGHT_M]) - lamp
        r = float(np.linalg.norm(ray))
        m = np.log(0.5) / np.log(np.cos(np.deg2rad(35.0)))
        intensity = (m + 1) / (2 * np.pi) * max(ray @ aim / r, 0.0) ** m
        total += share * intensity * (ray[2] / r) / r**2 * np.exp(-K * r)
    return float(total * np.exp(-C * path) / (1 + u**2 + v**2) ** 2)


@pytest.mark.parametrize("shape", [DOME, FLAT], ids=["dome", "flat"])
@pytest.mark.parametrize(("u", "v"), [(U, V), (-U, -V), (0.1, 0.3)])
def test_light_of_a_pixel_is_that_of_lambert_on_the_tilted_plane(shape: PortShape, u: float, v: float) -> None:
    gain = local_gain(
        np.array([u]), np.array([v]), shape=shape, range_m=RANGE_M, lamps=LAMPS, beam=LOBE, table=GREY
    )
    assert gain[0] == pytest.approx(expected_gain(u, v, shape), rel=2e-6)


@pytest.mark.parametrize("shape", [DOME, FLAT], ids=["dome", "flat"])
def test_mean_over_an_oblique_image_is_that_of_a_fine_grid(shape: PortShape) -> None:
    u, v = ((np.arange(30) + 0.5) / 15 - 1) * U, ((np.arange(30) + 0.5) / 15 - 1) * V
    grid = np.mean([[expected_gain(a, b, shape) for b in v] for a in u])
    mean = field_mean(np.array([U]), np.array([V]), shape=shape, range_m=RANGE_M, lamps=LAMPS, beam=LOBE, table=GREY)
    assert mean[0] == pytest.approx(grid, rel=2e-3)  # the grid's own error


CONE = beams.cone_beam(np.deg2rad(14.0))


def disc_mean(shape: PortShape, n: int = 700) -> float:
    """Mean of a cone's light over a dome's image by many points, in the camera's frame, by hand."""
    u, v = np.meshgrid(((np.arange(n) + 0.5) * 2 / n - 1) * U, ((np.arange(n) + 0.5) * 2 / n - 1) * V, indexing="ij")
    z = (RANGE_M + shape.slope * shape.outer_radius_m * u) / (1 - shape.slope * u)
    x, y = u * (z + shape.outer_radius_m), v * (z + shape.outer_radius_m)
    total = np.zeros_like(u)
    normal = np.array([-np.sin(PITCH), 0.0, np.cos(PITCH)])
    for k, share in enumerate(LAMPS.share):
        ray = np.stack([x - LAMPS.x_m[k], y - LAMPS.y_m[k], z - LAMPS.z_m[k]])
        r = np.sqrt((ray**2).sum(axis=0))
        lit = np.einsum("i,ijk->jk", np.array(LAMPS.aim[k]), ray) / r >= np.cos(np.deg2rad(14.0))
        intensity = lit / (2 * np.pi * (1 - np.cos(np.deg2rad(14.0))))
        total += share * intensity * np.einsum("i,ijk->jk", normal, ray) / r**3 * np.exp(-K * r)
    path = (z + shape.outer_radius_m) * np.sqrt(1 + u**2 + v**2) - shape.outer_radius_m
    return float((total * np.exp(-C * path) / (1 + u**2 + v**2) ** 2).mean())


def test_narrow_cones_on_an_oblique_floor_are_found_where_they_are() -> None:
    mean = field_mean(np.array([U]), np.array([V]), shape=DOME, range_m=RANGE_M, lamps=LAMPS, beam=CONE, table=GREY)
    assert mean[0] == pytest.approx(disc_mean(DOME), rel=2e-3)  # of points on the cones' edges


@pytest.mark.parametrize("slope", [0.0, DOME.slope])
def test_a_tilted_plane_catches_all_the_light_that_a_lamp_sends_down_to_it(slope: float) -> None:
    """Energy: an isotropic-cone lamp of 20 deg, all of whose rays meet the plane, loses nothing in clear water."""
    lamp = Lamps((0.0,), (0.0,), (0.0,), ((0.0, 0.0, 1.0),), (1.0,))
    cone, edge = beams.cone_beam(np.deg2rad(20.0)), np.tan(np.deg2rad(20.0))
    angle, tangent = (np.arange(720) + 0.5) * np.pi / 360, (np.arange(400) + 0.5) / 400 * edge
    u, v = np.outer(tangent, np.cos(angle)), np.outer(tangent, np.sin(angle))
    z = RANGE_M / (1 - slope * u)
    lit = floor_illuminance_per_lm(
        u * z, v * z, lamps=lamp, beam=cone, range_m=RANGE_M, slope=slope, weight=np.ones(2),
        attenuation_per_m=np.zeros(2),
    )  # fmt: skip
    pixel = PortShape(True, 0.0, 0.0, 1.5, 0.0, 1.34, slope=slope)
    area = floor_area_ratio(u, v, shape=pixel, range_m=RANGE_M) * tangent[:, None] * (edge / 400) * (np.pi / 360)
    assert (lit * area).sum() == pytest.approx(1.0, rel=1e-4)


def test_evenness_of_an_oblique_footprint_is_that_of_its_floor() -> None:
    """Mean over the floor's area, not over the image, and the darkest place; by points through the dome."""
    n = 400
    u, v = np.meshgrid(((np.arange(n) + 0.5) * 2 / n - 1) * U, ((np.arange(n) + 0.5) * 2 / n - 1) * V, indexing="ij")
    z = (RANGE_M + DOME.slope * 0.07 * u) / (1 - DOME.slope * u)
    x, y = u * (z + 0.07), v * (z + 0.07)
    light = np.zeros_like(u)
    m = np.log(0.5) / np.log(np.cos(np.deg2rad(35.0)))
    for k, share in enumerate(LAMPS.share):
        ray = np.stack([x - LAMPS.x_m[k], y - LAMPS.y_m[k], z - LAMPS.z_m[k]])
        r = np.sqrt((ray**2).sum(axis=0))
        cos_beam = np.einsum("i,ijk->jk", np.array(LAMPS.aim[k]), ray) / r
        cos_floor = (np.cos(PITCH) * ray[2] - np.sin(PITCH) * ray[0]) / r
        light += share * (m + 1) / (2 * np.pi) * cos_beam**m * cos_floor / r**2 * np.exp(-K * r)
    area = 1.0 / (1 - DOME.slope * u) ** 3
    mean, least = footprint_illuminance_per_lm(
        U, V, shape=DOME, range_m=RANGE_M, lamps=LAMPS, beam=LOBE, weight=np.ones(2), attenuation_per_m=np.full(2, K)
    )
    assert mean == pytest.approx(float((light * area).sum() / area.sum()), rel=1e-4)
    assert least == pytest.approx(float(light.min()), rel=2e-2) and least <= light.min()


def test_backscatter_of_an_oblique_image_ends_at_the_tilted_floor() -> None:
    """Isotropic scattering, one lamp beside the camera: each ray's integral by quadrature, the image's by a grid."""
    lamp = Lamps((0.0,), (0.6,), (0.0,), ((0.0, 0.0, 1.0),), (1.0,))
    table = build_path_table(
        np.ones(3), wavelength_nm=None, k_lamp_per_m=np.full(3, K), c_camera_per_m=np.full(3, C),
        lamp_range_m=(0.02, 30.0), camera_range_m=(0.0, 30.0),
    )  # fmt: skip
    m = np.log(0.5) / np.log(np.cos(np.deg2rad(35.0)))

    def ray_sum(u: float, v: float) -> float:
        length = np.sqrt(1 + u**2 + v**2)
        way = np.array([u, v, 1.0]) / length
        start = 0.07 * way - np.array([0.0, 0.0, 0.07])
        path = traced(u, v, DOME)[2]

        def at(r: float) -> float:
            there = start + r * way - np.array([0.0, 0.6, 0.0])
            s = float(np.linalg.norm(there))
            return float((m + 1) / (2 * np.pi) * max(there[2] / s, 0.0) ** m / s**2 * np.exp(-K * s - C * r))

        return quad(at, 0.0, path, epsabs=0, epsrel=1e-7)[0] / length**4 / (4 * np.pi)

    nodes, weights = np.polynomial.legendre.leggauss(7)
    grid = sum(
        a * b * ray_sum(x * U, y * V) / 4
        for x, a in zip(nodes, weights, strict=True) for y, b in zip(nodes, weights, strict=True)
    )  # fmt: skip
    scatterer = Scatterer(lambda cos: 0 * cos + 1 / (4 * np.pi), table)
    mean = mean_backscatter(
        np.array([U]), np.array([V]), shape=DOME, range_m=RANGE_M, lamps=lamp, beam=LOBE, scatterers=(scatterer,)
    )
    assert mean[0] / 3.0 == pytest.approx(grid, rel=2e-3)
