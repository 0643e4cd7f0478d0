"""Curved images of ports against rays traced through their surfaces, which know of no focal length."""

from __future__ import annotations

import math
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt.model import defocus, port

N_WATER, N_GLASS = 1.34, 1.49
DOME = {"outer_radius_m": 0.05, "thickness_m": 0.005, "n_glass": N_GLASS, "n_water": N_WATER}
DOME_MAP = port.dome_focus_map(**DOME)
PLATE = {"gap_m": 0.02, "thickness_m": 0.012, "n_glass": N_GLASS, "n_water": N_WATER}
IMX = {"f_number": 2.8, "focal_length_m": 8e-3, "pixel_pitch_m": 3.45e-6}

angles = st.floats(0.0, 0.9)
ranges = st.floats(0.3, 10.0)


# ---------------------------------------------------------------- rays in three dimensions, from air to floor


def refract(direction: np.ndarray, normal: np.ndarray, ratio: float) -> np.ndarray:
    """Snell's law for unit vectors; normal along the ray, ratio of the index before to that behind."""
    cosine = float(direction @ normal)
    behind = math.sqrt(1.0 - ratio**2 * (1.0 - cosine**2))
    return ratio * direction + (behind - ratio * cosine) * normal


def through_dome(origin: np.ndarray, direction: np.ndarray, floor_z: float) -> np.ndarray:
    """Where a ray that starts in air meets a floor at a height; concentric spheres about (0, 0, 0)."""
    point, index = origin, 1.0
    for radius, beyond in ((0.045, N_GLASS), (0.05, N_WATER)):
        b = float(point @ direction)
        point = point + (-b + math.sqrt(b * b - float(point @ point) + radius**2)) * direction
        direction = refract(direction, point / radius, index / beyond)
        index = beyond
    return point + (floor_z - point[2]) / direction[2] * direction


def through_plate(origin: np.ndarray, direction: np.ndarray, floor_z: float) -> np.ndarray:
    """The same for a flat port, 20 mm before the pupil at (0, 0, 0) and 12 mm thick."""
    normal = np.array([0.0, 0.0, 1.0])
    for z, ratio in ((0.02, 1.0 / N_GLASS), (0.032, N_GLASS / N_WATER)):
        origin = origin + (z - origin[2]) / direction[2] * direction
        direction = refract(direction, normal, ratio)
    return origin + (floor_z - origin[2]) / direction[2] * direction


def unit(x: float, y: float) -> np.ndarray:
    return np.array([x, y, 1.0]) / math.sqrt(1.0 + x * x + y * y)


def slope_to(trace: Any, pupil: np.ndarray, target: np.ndarray, guess: float) -> np.ndarray:
    """Slopes (x, y) in air of the ray from a point of the pupil to a floor point: Newton, differences."""
    slope, h = np.array([guess, 0.0]), 1e-6
    for _ in range(12):
        miss = (trace(pupil, unit(*slope), target[2]) - target)[:2]
        columns = [
            (trace(pupil, unit(*(slope + move)), target[2]) - trace(pupil, unit(*(slope - move)), target[2]))[
                :2
            ]
            for move in h * np.eye(2)
        ]
        slope = slope - np.linalg.solve(np.array(columns).T / (2 * h), miss)
    return slope


def image_dioptres(trace: Any, tan_field: float, floor_z: float) -> tuple[float, float]:
    """1/z of the tangential and the sagittal image: how rays from one floor point cross behind the port.

    A narrow fan through that floor point: for a small step in the pupil the slope that still meets the point
    changes by -1/z times the step.
    """
    target = trace(np.zeros(3), unit(tan_field, 0.0), floor_z)
    step = 1e-4
    dioptres = []
    for axis in (0, 1):
        move = np.eye(3)[axis] * step
        ends = [slope_to(trace, sign * move, target, tan_field)[axis] for sign in (-1.0, 1.0)]
        dioptres.append(float(ends[0] - ends[1]) / (2 * step))
    return dioptres[0], dioptres[1]


@pytest.mark.parametrize("angle_deg", [0.5, 10.0, 25.0, 35.0, 50.0])
@pytest.mark.parametrize("range_m", [0.5, 2.0])
def test_image_behind_a_dome_is_where_traced_rays_cross(angle_deg: float, range_m: float) -> None:
    angle = math.radians(angle_deg)
    tangential, sagittal = image_dioptres(through_dome, math.tan(angle), range_m + 0.05)
    got = port.field_dioptre_per_m(range_m, cos_field=math.cos(angle), focus_map=DOME_MAP)
    assert got == pytest.approx(tangential, rel=1e-5)
    assert got == pytest.approx(sagittal, rel=1e-5)  # no astigmatism


@pytest.mark.parametrize("angle_deg", [0.5, 10.0, 25.0, 35.0, 50.0])
@pytest.mark.parametrize("range_m", [0.5, 2.0])
def test_images_behind_a_flat_port_are_where_traced_rays_cross(angle_deg: float, range_m: float) -> None:
    tan_air = math.tan(math.radians(angle_deg))
    expected = image_dioptres(through_plate, tan_air, range_m + 0.032)
    got = defocus.flat_field_dioptres_per_m(range_m, tan_air=tan_air, **PLATE)
    assert got == pytest.approx(expected, rel=1e-5)


# ---------------------------------------------------------------- blur


def spot_px(trace: Any, tan_field: float, floor_z: float, focus_per_m: float) -> tuple[float, float]:
    """Widths of the spot of a floor point, radially and across: rays through the rim of the pupil f / N.

    Behind an ideal lens focused at z_f a ray (pupil h, slope u) lands at (u + h / z_f) times the image distance.
    """
    target = trace(np.zeros(3), unit(tan_field, 0.0), floor_z)
    image_distance_m = 1.0 / (1.0 / 8e-3 - focus_per_m)
    widths = []
    for axis in (0, 1):
        hits = []
        for sign in (-1.0, 1.0):
            pupil = np.eye(3)[axis] * sign * 8e-3 / 2.8 / 2
            slope = slope_to(trace, pupil, target, tan_field)
            hits.append((slope + pupil[:2] * focus_per_m)[axis] * image_distance_m)
        widths.append(abs(hits[1] - hits[0]) / 3.45e-6)
    return widths[0], widths[1]


def dome_defocus_px(range_m: Any, *, cos_field: Any, focus_map: Any, **optics: Any) -> Any:
    """Blur disc of a floor point behind a dome, pupil at its centre."""
    return defocus.defocus_px(
        port.field_dioptre_per_m(range_m, cos_field=cos_field, focus_map=focus_map), **optics
    )


def flat_defocus_px(range_m: Any, *, tan_air: Any, **optics: Any) -> Any:
    """Longer axis of the elliptic blur of a floor point behind the flat port."""
    images = defocus.flat_field_dioptres_per_m(range_m, tan_air=tan_air, **PLATE)
    return np.maximum(*(defocus.defocus_px(image, **optics) for image in images))


def test_blur_of_the_physics_page() -> None:
    # physics page, section 4: 8.5 px for 8 mm F2.8 behind R = 50 mm at 35 degrees; floor at 2 m, focused on axis
    focus = port.lens_dioptre_per_m(2.0, focus_map=DOME_MAP)
    got = dome_defocus_px(
        2.0, cos_field=math.cos(math.radians(35.0)), focus_map=DOME_MAP, focus_dioptre_per_m=focus, **IMX
    )
    without_extension = got * (1.0 - 8e-3 * focus)
    assert without_extension == pytest.approx(8.5, abs=0.4)  # wall and pitch are not named there
    radial, across = spot_px(through_dome, math.tan(math.radians(35.0)), 2.05, focus)
    assert radial == pytest.approx(
        got, rel=0.02
    )  # a real pupil is not narrow: spherical aberration of the dome
    assert across == pytest.approx(got, rel=0.02)


@pytest.mark.parametrize(("range_m", "expected_px"), [(2.0, 1.0), (0.5, 4.0)])
def test_flat_port_blurs_the_corner_a_little(range_m: float, expected_px: float) -> None:
    # at 30 degrees in air; about 1 px at 2 m and 4 px at 0.5 m, as the traced spot has it
    tan_air = math.tan(math.radians(30.0))
    focus = port.lens_dioptre_per_m(range_m, focus_map=port.flat_focus_map(**PLATE))
    got = flat_defocus_px(range_m, tan_air=tan_air, focus_dioptre_per_m=focus, **IMX)
    radial, across = spot_px(through_plate, tan_air, range_m + 0.032, focus)
    assert got == pytest.approx(max(radial, across), rel=0.01)
    assert got == pytest.approx(expected_px, rel=0.12)
    assert radial > 3.0 * across  # astigmatism


@given(range_m=ranges)
def test_on_the_axis_both_ports_show_one_image_in_focus(range_m: float) -> None:
    flat_map = port.flat_focus_map(**PLATE)
    flat_focus = port.lens_dioptre_per_m(range_m, focus_map=flat_map)
    assert defocus.flat_field_dioptres_per_m(range_m, tan_air=0.0, **PLATE) == pytest.approx([flat_focus] * 2)
    assert flat_defocus_px(range_m, tan_air=0.0, focus_dioptre_per_m=flat_focus, **IMX) == pytest.approx(
        0.0, abs=1e-9
    )
    dome_focus = port.lens_dioptre_per_m(range_m, focus_map=DOME_MAP)
    assert (
        dome_defocus_px(range_m, cos_field=1.0, focus_map=DOME_MAP, focus_dioptre_per_m=dome_focus, **IMX)
        == 0.0
    )


@given(angle=angles, more=st.floats(0.0, 0.3), range_m=ranges)
def test_images_come_nearer_toward_the_corner(angle: float, more: float, range_m: float) -> None:
    one, other = (
        defocus.flat_field_dioptres_per_m(range_m, tan_air=math.tan(a), **PLATE)
        for a in (angle, angle + more)
    )
    assert other[0] >= one[0] * (1 - 1e-12) and other[1] >= one[1] * (1 - 1e-12)
    assert one[0] >= one[1] * (1 - 1e-12)  # the tangential image is the nearer one


# ---------------------------------------------------------------- off the centre


@pytest.mark.parametrize("angle_deg", [15.0, 25.0, 35.0])
@pytest.mark.parametrize("range_m", [0.7, 2.0])
def test_decentred_pupil_distorts_as_traced_rays_do(angle_deg: float, range_m: float) -> None:
    tan_field = math.tan(math.radians(angle_deg))
    floor_z, px_per_slope = range_m + 0.05, 8e-3 / 3.45e-6
    got = defocus.dome_decentring(
        range_m, cos_field=math.cos(math.radians(angle_deg)), focus_map=DOME_MAP, **IMX
    )
    centre, edge = (through_dome(np.zeros(3), unit(t, 0.0), floor_z) for t in (0.0, tan_field))

    def shift(move: np.ndarray, target: np.ndarray, tangent: float) -> float:
        """Half the difference between a pupil moved there and back [px]: what is odd in the move."""
        there, back = (slope_to(through_dome, sign * move, target, tangent)[0] for sign in (1.0, -1.0))
        return float(there - back) / 2 * px_per_slope

    aside = np.array([1e-3, 0.0, 0.0])
    across_px = shift(aside, edge, tan_field) - shift(aside, centre, 0.0)
    assert got.across_distortion_px == pytest.approx(-across_px, rel=0.03)
    # along the axis: what a change of scale does not take up, the scale being that at a small field angle
    ahead = np.array([0.0, 0.0, 1e-3])
    small = through_dome(np.zeros(3), unit(0.01, 0.0), floor_z)
    axial_px = shift(ahead, edge, tan_field) - tan_field * shift(ahead, small, 0.01) / 0.01
    assert got.axial_distortion_px == pytest.approx(axial_px, rel=0.03)


@pytest.mark.parametrize("angle_deg", [15.0, 35.0])
def test_decentred_pupil_defocuses_as_traced_fans_do(angle_deg: float) -> None:
    tan_field, floor_z = math.tan(math.radians(angle_deg)), 2.05
    f2_over_n_px = 8e-3**2 / 2.8 / 3.45e-6

    def dioptre(tangent: float, move: np.ndarray) -> float:
        """Tangential 1/z from the displaced pupil, of the floor point that the centred one sees there."""
        target = through_dome(np.zeros(3), unit(tangent, 0.0), floor_z)
        step = np.array([1e-5, 0.0, 0.0])
        slopes = [slope_to(through_dome, move + s * step, target, tangent)[0] for s in (-1.0, 1.0)]
        return float(slopes[0] - slopes[1]) / 2e-5

    def change(tangent: float, move: np.ndarray) -> float:
        return (dioptre(tangent, move) - dioptre(tangent, -move)) / 2

    got = defocus.dome_decentring(2.0, cos_field=math.cos(math.radians(angle_deg)), focus_map=DOME_MAP, **IMX)
    ahead = np.array([0.0, 0.0, 1e-3])
    traced_px = abs(change(tan_field, ahead) - change(1e-3, ahead)) * f2_over_n_px
    assert got.axial_defocus_px == pytest.approx(traced_px, rel=0.03, abs=0.005)
    # sideways: no defocus to first order, whatever the field
    aside = np.array([1e-3, 0.0, 0.0])
    assert abs(change(tan_field, aside)) * f2_over_n_px < 0.02


# ---------------------------------------------------------------- limits and symbols


def test_total_reflection_limits_the_field_in_water() -> None:
    # asin(1 / 1.34) = 48.27 degrees; a ray just inside leaves the water, near grazing in air
    limit = math.asin(1.0 / 1.34)
    assert port.water_tangent(1e6, n=1.34) == pytest.approx(math.tan(limit), rel=1e-9)


def test_defocus_accepts_symbols(symbol: Any) -> None:
    def figures(x: Any) -> list[Any]:
        tangential, sagittal = defocus.flat_field_dioptres_per_m(2.0, tan_air=x, **PLATE)
        flat = flat_defocus_px(2.0, tan_air=x, focus_dioptre_per_m=0.7, **IMX)
        dome = dome_defocus_px(1.0 + x, cos_field=0.8, focus_map=DOME_MAP, focus_dioptre_per_m=6.0, **IMX)
        off = defocus.dome_decentring(1.0 + x, cos_field=0.8, focus_map=DOME_MAP, **IMX)
        return [tangential, sagittal, flat, dome, *off]

    function = casadi.Function("defocus", [symbol], figures(symbol))
    assert [float(value) for value in function(0.4)] == pytest.approx(
        [float(v) for v in figures(0.4)], rel=1e-9
    )
