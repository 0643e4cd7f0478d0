"""A pair of cameras: what both see and how well they tell a distance, against rays traced by Snell's law in vectors.

The tracing shares nothing with the model: ports are planes and spheres, rays refract at each by the vector form of
Snell's law, a place in an image is found by bisection, and errors are drawn.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import uwopt
from uwopt.model.imaging import PortShape
from uwopt.model.stereo import Pair, common_width_m, depth_error_m, largest_step_m

DOME = PortShape(True, 0.08, 0.01, 1.5, 0.0, 1.34)
FLAT = PortShape(False, 0.0, 0.012, 1.52, 0.04, 1.34)
TAN_PER_PX = 3.45e-6 / 8e-3
SHAPES = pytest.mark.parametrize("shape", [DOME, FLAT], ids=["dome", "flat"])
Vector = np.ndarray


def refracted(way: Vector, normal: Vector, ratio: float) -> Vector:
    """Snell's law for unit vectors; `normal` along the light, `ratio` of the indices before and behind."""
    cos = float(way @ normal)
    return ratio * way + (math.sqrt(1.0 - ratio**2 * (1.0 - cos**2)) - ratio * cos) * normal


def in_water(u: float, shape: PortShape) -> tuple[Vector, Vector]:
    """A point of the ray in water and its direction, in the camera's frame: y across, z along the axis, port at 0.

    A dome bends no ray through its middle, where the pupil is.
    """
    way = np.array([u, 1.0]) / math.hypot(u, 1.0)
    if shape.is_dome:
        return np.array([0.0, -shape.outer_radius_m]), way
    axis = np.array([0.0, 1.0])
    at = np.array([0.0, -shape.gap_m - shape.thickness_m])
    at = at + way * shape.gap_m / way[1]
    glass = refracted(way, axis, 1.0 / shape.n_glass)
    at = at + glass * shape.thickness_m / glass[1]
    return at, refracted(glass, axis, shape.n_glass / shape.n_water)


def ray(u: float, shape: PortShape, pair: Pair, side: int) -> tuple[Vector, Vector]:
    """The same in the frame of the pair; the camera of side +1 stands at -B/2 and turns towards +y."""
    at, way = in_water(u, shape)
    sin, cos = math.sin(pair.turn_rad), math.cos(pair.turn_rad)
    turn = np.array([[cos, sin], [-sin, cos]])
    at, way = turn @ at, turn @ way
    at = at + np.array([-0.5 * pair.baseline_m, 0.0])
    return at * np.array([side, 1.0]), way * np.array([side, 1.0])


def across_at(u: float, shape: PortShape, pair: Pair, side: int, range_m: float) -> float:
    """Where the ray meets the plane."""
    at, way = ray(u, shape, pair, side)
    return float(at[0] + way[0] * (range_m - at[1]) / way[1])


def place_in_image(y_m: float, shape: PortShape, pair: Pair, side: int, range_m: float) -> float:
    """Tangent in air at which a camera sees a place of the plane."""
    return float(brentq(lambda u: across_at(u, shape, pair, side, range_m) - y_m, -1.5, 1.5, xtol=1e-13))


def met_at(first: tuple[Vector, Vector], second: tuple[Vector, Vector]) -> float:
    """How far along z two rays meet."""
    steps = np.linalg.solve(np.stack([first[1], -second[1]], axis=1), second[0] - first[0])
    return float((first[0] + steps[0] * first[1])[1])


@SHAPES
@pytest.mark.parametrize(
    ("baseline_m", "turn_deg", "range_m", "y_m"),
    [(0.3, 0.0, 2.0, 0.0), (0.7, 4.0, 3.5, 0.4), (0.5, 15.0, 0.9, 0.1), (0.4, 0.0, 1.0, -0.15)],
)
def test_error_of_a_distance_is_the_spread_of_rays_with_shifted_pixels(
    shape: PortShape, baseline_m: float, turn_deg: float, range_m: float, y_m: float
) -> None:
    pair, rng, sigma_px = Pair(baseline_m, math.radians(turn_deg)), np.random.default_rng(5), 0.5
    seen = [place_in_image(y_m, shape, pair, side, range_m) for side in (1, -1)]
    shifts = rng.normal(0.0, sigma_px / math.sqrt(2.0), (2000, 2)) * TAN_PER_PX
    found = [
        met_at(ray(seen[0] + one, shape, pair, 1), ray(seen[1] + other, shape, pair, -1)) for one, other in shifts
    ]
    told = depth_error_m(
        np.array(y_m), shape=shape, range_m=range_m, pair=pair, tan_per_px=TAN_PER_PX, disparity_error_px=sigma_px
    )
    # The spread of 2000 draws is known to 1.6 % (one sigma): 5 %
    assert float(np.std(found)) == pytest.approx(float(told), rel=0.05)
    assert float(np.mean(found)) == pytest.approx(range_m, abs=4.0 * float(told) / math.sqrt(len(found)))


@SHAPES
@pytest.mark.parametrize(("baseline_m", "turn_deg", "y_m"), [(0.3, 0.0, 0.2), (0.7, 4.0, 0.3), (0.5, 15.0, -0.2)])
def test_error_of_a_distance_is_the_slope_of_traced_rays(
    shape: PortShape, baseline_m: float, turn_deg: float, y_m: float
) -> None:
    """Without draws: how far the meeting moves when each image's place does, by central differences."""
    pair, range_m, step = Pair(baseline_m, math.radians(turn_deg)), 2.0, 1e-6
    one, other = (place_in_image(y_m, shape, pair, side, range_m) for side in (1, -1))

    def met(a: float, b: float) -> float:
        return met_at(ray(one + a, shape, pair, 1), ray(other + b, shape, pair, -1))

    slopes = (met(step, 0) - met(-step, 0)) / (2 * step), (met(0, step) - met(0, -step)) / (2 * step)
    told = depth_error_m(
        np.array(y_m), shape=shape, range_m=range_m, pair=pair, tan_per_px=TAN_PER_PX, disparity_error_px=1.0
    )
    assert float(told) == pytest.approx(math.hypot(*slopes) / math.sqrt(2.0) * TAN_PER_PX, rel=1e-5)


def test_a_pair_that_is_not_turned_errs_by_the_textbook() -> None:
    """Z^2 / (B f) times the disparity's error, 0.5 px of 3.45 um, behind 8 mm at 2 m: from the dome's middle."""
    told = depth_error_m(
        np.array([0.0, 0.3]), shape=DOME, range_m=2.0, pair=Pair(0.4), tan_per_px=TAN_PER_PX, disparity_error_px=0.5
    )
    assert told == pytest.approx([2.08**2 / (0.4 * 8e-3) * 0.5 * 3.45e-6] * 2, rel=1e-12)


def test_behind_a_flat_port_the_focal_length_is_longer_by_the_index() -> None:
    """On the axis of a narrow pair, Z counted from the pupil as the water shows it."""
    pair, z_m = Pair(1e-4), 2.0 + 1.34 * (0.04 + 0.012 / 1.52)
    told = depth_error_m(
        np.array(0.0), shape=FLAT, range_m=2.0, pair=pair, tan_per_px=TAN_PER_PX, disparity_error_px=0.5
    )
    assert float(told) == pytest.approx(z_m**2 / (1e-4 * 1.34 * 8e-3) * 0.5 * 3.45e-6, rel=1e-6)


def test_a_converged_pair_errs_by_the_closed_form_in_the_middle() -> None:
    """sigma (p / f) (Z^2 + B^2 / 4) cos^2(alpha - phi) / B with pupils at the ports: a dome of no size."""
    point = PortShape(True, 0.0, 0.0, 1.0, 0.0, 1.34)
    told = depth_error_m(
        np.array(0.0), shape=point, range_m=1.5, pair=Pair(0.8, 0.2), tan_per_px=TAN_PER_PX, disparity_error_px=0.5
    )
    alpha = math.atan(0.4 / 1.5)
    by_hand = 0.5 * TAN_PER_PX * (1.5**2 + 0.4**2) * math.cos(alpha - 0.2) ** 2 / 0.8
    assert float(told) == pytest.approx(by_hand, rel=1e-12)


@SHAPES
@pytest.mark.parametrize(("baseline_m", "turn_deg"), [(0.3, 0.0), (0.7, 4.0), (0.7, 25.0), (3.0, 0.0)])
def test_common_width_is_where_both_traced_images_reach(shape: PortShape, baseline_m: float, turn_deg: float) -> None:
    """Places a tenth of a millimetre apart, each seen by a camera whose image goes to a tangent of 0.5 in air."""
    pair, range_m, edge = Pair(baseline_m, math.radians(turn_deg)), 1.5, 0.5
    ends: list[tuple[float, float]] = []
    for side in (1, -1):
        low, high = sorted(across_at(u, shape, pair, side, range_m) for u in (-edge, edge))
        ends.append((low, high))
    places = np.arange(-3.0, 3.0, 1e-4)
    both = np.all([(places >= low) & (places <= high) for low, high in ends], axis=0)
    told: Any = common_width_m(np.array([[edge]]), shape=shape, range_m=np.array([range_m]), pair=pair)
    assert float(told[0, 0]) == pytest.approx(1e-4 * both.sum(), abs=3e-4)


@SHAPES
@pytest.mark.parametrize("turn_deg", [2.0, 8.0])
def test_pixels_of_a_turned_camera_are_largest_where_traced_rays_move_most(shape: PortShape, turn_deg: float) -> None:
    """What a step between two rays moves the end across, the most from the middle to the edge that looks farthest."""
    pair, edge, range_m, step = Pair(0.0, math.radians(turn_deg)), 0.45, 1.4, 1e-5
    most_m = max(
        (across_at(u, shape, pair, 1, range_m) - across_at(u - step, shape, pair, 1, range_m)) / step
        for u in np.linspace(0.0, edge, 181)
    )
    found = largest_step_m(np.array([[edge]]), shape=shape, range_m=np.array([range_m]), turn_rad=pair.turn_rad)
    assert found[0, 0] == pytest.approx(most_m, rel=1e-3)
    if shape.is_dome:  # (d + R cos phi) / (cos phi - u sin phi)^2
        fall = math.cos(pair.turn_rad) - edge * math.sin(pair.turn_rad)
        assert found[0, 0] == pytest.approx((range_m + 0.08 * math.cos(pair.turn_rad)) / fall**2, rel=1e-9)


def test_a_turned_pair_is_held_to_its_largest_pixels() -> None:
    """5 degrees each: 0.63 mm at the edge that looks farthest, where square on the wall it would be 0.575 mm."""
    wanted = {"practice": "bare", "confidence": "central", "physics": "full",
              "scene": {"target": "wall", "water": "II", "seafloor": 0.1, "depth_m": 1700},
              "vehicle": {"distance_m": 1.4, "speed_m_s": 0, "camera_count": 2, "camera_baseline_m": 0.3,
                          "camera_convergence_deg": 10},
              "requirements": {"frame_interval_s": 60, "max_gsd_mm": 0.6}}  # fmt: skip
    system = {"camera": "basler-a2a2464-77ucpro", "lens": "fujinon-hf9ha-1b", "port": "generic-dome-bk7-100mm",
              "light": "generic-flash-100j", "light_count": 2, "camera_count": 2,
              "settings": {"f_number": 4, "exposure_ms": 1.5, "gain": 2, "dim_frac": 0.5}}  # fmt: skip
    design = uwopt.evaluate(wanted, system).design
    assert design is not None
    (margin,) = [one for one in design.scenes[0].margins if one.requirement == "max_gsd_mm"]
    turn, edge = math.radians(5.0), 2448 * 3.45 / 2 / 9e3
    fall = math.cos(turn) - edge * math.sin(turn)
    assert margin.value == pytest.approx(1.5 * 3.45 / 9.0 / fall**2, rel=1e-3) and not margin.satisfied
