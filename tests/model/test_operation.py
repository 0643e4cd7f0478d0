"""Footprint, pixel size on the floor and motion: hand values, the paper's tool, and traced rays."""

import json
import math
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt.model import operation, port

REFERENCE = Path(__file__).parents[1] / "reference"
TOOL_RUNS = json.loads((REFERENCE / "paper_tool_runs.json").read_text())["cases"]
TOOL_N_WATER = 1.33
# Width, height [px] and pitch [m] of the tool's sensor files; 2488 is a slip for 2448 and part of its runs.
TOOL_SENSORS = {
    "icx285ALM": (1360, 1024, 6.45e-6),
    "imx178M": (3072, 2048, 2.4e-6),
    "imx249M": (1920, 1200, 5.86e-6),
    "imx250C": (2488, 2048, 3.45e-6),
    "imx250M": (2448, 2048, 3.45e-6),
    "imx252M": (2048, 1536, 3.45e-6),
    "imx264C": (2448, 2048, 3.45e-6),
}
FLAT = {"gap_m": 0.02, "thickness_m": 0.012, "n_glass": 1.49, "n_water": 1.34}
PIXEL = {"pixel_pitch_m": 3.45e-6, "focal_length_m": 8e-3}

speeds = st.floats(0.01, 5.0)
footprints = st.floats(0.1, 20.0)


# ---------------------------------------------------------------- coverage


def footprint_m(*, range_m: float, sensor_size_m: float, focal_length_m: float) -> float:
    """Floor that one side of the sensor sees, FOV = d SS / f (11)."""
    return range_m * sensor_size_m / focal_length_m


@pytest.mark.parametrize("number", range(len(TOOL_RUNS)))
def test_geometry_of_the_paper_tools_runs(number: int) -> None:
    case, expect = TOOL_RUNS[number], TOOL_RUNS[number]["expect"]
    width_px, height_px, pitch_m = TOOL_SENSORS[case["sensor"]]
    focal_m = case["focal_length_mm"] * 1e-3 * (1.0 if case["housing"] == "domed" else TOOL_N_WATER)
    view = {"range_m": case["altitude_m"], "focal_length_m": focal_m}
    fov_x_m = footprint_m(sensor_size_m=width_px * pitch_m, **view)
    fov_y_m = footprint_m(sensor_size_m=height_px * pitch_m, **view)
    along_m, along_px = (fov_x_m, width_px) if case["axis"] == "x" else (fov_y_m, height_px)
    exposure_s = operation.blur_exposure_s(
        case["max_blur_px"],
        ground_sample_m=along_m / along_px,
        speed_m_s=case["speed_m_s"],
    )
    rate_hz = operation.frame_rate_hz(case["speed_m_s"], footprint_along_m=along_m, overlap=case["overlap"])
    # the same formulas in both programs: rounding only
    assert fov_x_m == pytest.approx(expect["fov_x_m"], rel=1e-9)
    assert fov_y_m == pytest.approx(expect["fov_y_m"], rel=1e-9)
    assert exposure_s == pytest.approx(expect["exposure_max_s"], rel=1e-9)
    assert rate_hz == pytest.approx(expect["frame_rate_hz"], rel=1e-9)


def test_geometry_of_the_paper_tools_window() -> None:
    # the window shows 2.11 m x 1.77 m, 0.86 ms and 0.63 Hz: IMX250, 8 mm, 2 m, 1 px at 1 m/s, overlap 0.25
    view = {"range_m": 2.0, "focal_length_m": 8e-3}
    fov_x_m = footprint_m(sensor_size_m=2448 * 3.45e-6, **view)
    fov_y_m = footprint_m(sensor_size_m=2048 * 3.45e-6, **view)
    assert (fov_x_m, fov_y_m) == (pytest.approx(2.11, abs=5e-3), pytest.approx(1.77, abs=5e-3))
    sample_m = fov_x_m / 2448
    exposure_s = operation.blur_exposure_s(1.0, ground_sample_m=sample_m, speed_m_s=1.0)
    assert exposure_s == pytest.approx(0.86e-3, abs=5e-6)
    rate_hz = operation.frame_rate_hz(1.0, footprint_along_m=fov_x_m, overlap=0.25)
    assert rate_hz == pytest.approx(0.63, abs=5e-3)


def test_flat_pixel_on_the_axis_by_hand() -> None:
    # (0.02 + 0.012/1.5 + 2/1.333..) = 1.528 m of air; * 3.45 um / 8 mm = 0.65895 mm
    got = operation.flat_largest_pixel_m(
        2.0, gap_m=0.02, thickness_m=0.012, n_glass=1.5, n_water=4.0 / 3.0, **PIXEL
    )
    assert got == pytest.approx(0.65895e-3, rel=1e-12)


def traced_along_m(u: np.ndarray, v: float, *, port_shape: dict[str, float], range_m: float) -> np.ndarray:
    """Along-motion floor coordinate of rays with tangents (u, v) in air, by Snell's law with angles."""
    radial = np.hypot(u, v)
    sine = np.sin(np.arctan(radial))
    floor_m = port_shape["gap_m"] * radial
    for depth_m, n in (
        (port_shape["thickness_m"], port_shape["n_glass"]),
        (range_m, port_shape["n_water"]),
    ):
        floor_m = floor_m + depth_m * np.tan(np.arcsin(sine / n))
    return floor_m * u / radial


@pytest.mark.parametrize(
    ("tan_along", "tan_across"), [(0.2, 0.3), (0.5, 0.7), (1.0, 0.8), (1.4, 0.1), (1.4, 1.2), (2.5, 2.5)]
)
@pytest.mark.parametrize("gap_m", [0.0, 0.02])
def test_no_pixel_of_the_image_is_smaller_along_the_motion(
    tan_along: float, tan_across: float, gap_m: float
) -> None:
    shape = FLAT | {"gap_m": gap_m}
    step = 1e-5
    along = np.linspace(step, tan_along, 150)
    scale = PIXEL["pixel_pitch_m"] / PIXEL["focal_length_m"]
    rows = []
    for across in np.linspace(0.0, tan_across, 80):
        ends = [
            traced_along_m(along + half, across, port_shape=shape, range_m=1.5)
            for half in (-0.5 * step, 0.5 * step)
        ]
        rows.append((ends[1] - ends[0]) / step)
    smallest_m = scale * np.min(rows)
    got = operation.flat_smallest_pixel_along_m(
        tan_along, tan_across_edge=tan_across, range_m=1.5, **shape, **PIXEL
    )
    assert got == pytest.approx(smallest_m, rel=1e-6)  # differences over 1e-5: (1e-5)^2 and 1e-16/1e-5


@given(u=st.floats(0.0, 2.0), v=st.floats(0.0, 2.0), range_m=st.floats(0.1, 10.0))
def test_refraction_makes_edge_pixels_smaller_than_the_centre(u: float, v: float, range_m: float) -> None:
    smallest = operation.flat_smallest_pixel_along_m(u, tan_across_edge=v, range_m=range_m, **FLAT, **PIXEL)
    assert smallest <= operation.flat_largest_pixel_m(range_m, **FLAT, **PIXEL) * (1 + 1e-12)


@given(u=st.floats(0.0, 2.0))
def test_on_the_middle_line_the_pixel_is_the_slope_of_the_floor_distance(u: float) -> None:
    got = operation.flat_smallest_pixel_along_m(u, tan_across_edge=0.0, range_m=1.5, **FLAT, **PIXEL)
    slope = port.flat_floor_derivative(u, range_m=1.5, **FLAT)
    assert got == pytest.approx(slope * 3.45e-6 / 8e-3, rel=1e-12)


def test_without_refraction_all_pixels_are_equal() -> None:
    air = {"gap_m": 0.1, "thickness_m": 0.2, "n_glass": 1.0, "n_water": 1.0, "range_m": 1.7}
    got = operation.flat_smallest_pixel_along_m(0.8, tan_across_edge=0.6, **air, **PIXEL)
    assert got == pytest.approx(2.0 * 3.45e-6 / 8e-3)


# ---------------------------------------------------------------- motion


def test_rotation_adds_to_the_speed_over_the_floor() -> None:
    # 0.5 m/s + 0.1 rad/s * 2 m = 0.7 m/s; 2 px of 0.35 mm: 1 ms
    got = operation.blur_exposure_s(
        2.0, ground_sample_m=0.35e-3, speed_m_s=0.5, rotation_rate_rad_s=0.1, lever_m=2.0
    )
    assert got == pytest.approx(1e-3)


def test_at_rest_blur_sets_no_limit() -> None:
    got = operation.blur_exposure_s(1.0, ground_sample_m=1e-3, speed_m_s=np.array([0.0, 1.0]))
    np.testing.assert_array_equal(got, [np.inf, 1e-3])
    assert operation.blur_exposure_s(1.0, ground_sample_m=1e-3, speed_m_s=0.0) == math.inf


@given(blur=st.floats(0.1, 5.0), sample_m=st.floats(1e-5, 1e-2), v=speeds, rate=st.floats(0.0, 1.0))
def test_blur_and_exposure_are_inverse(blur: float, sample_m: float, v: float, rate: float) -> None:
    motion = {"ground_sample_m": sample_m, "speed_m_s": v, "rotation_rate_rad_s": rate, "lever_m": 2.0}
    exposure_s = operation.blur_exposure_s(blur, **motion)
    assert operation.blur_px(exposure_s, **motion) == pytest.approx(blur, rel=1e-12)


def test_skew_of_a_rolling_shutter_by_hand() -> None:
    # 1 m/s * 20 ms / 1 mm = 20 px
    assert operation.skew_px(20e-3, ground_sample_m=1e-3, speed_m_s=1.0) == pytest.approx(20.0)


@given(v=speeds, footprint_m=footprints, overlap=st.floats(0.0, 0.95))
def test_overlap_and_frame_rate_are_inverse(v: float, footprint_m: float, overlap: float) -> None:
    rate_hz = operation.frame_rate_hz(v, footprint_along_m=footprint_m, overlap=overlap)
    back = operation.overlap_at_rate(rate_hz, speed_m_s=v, footprint_along_m=footprint_m)
    assert back == pytest.approx(overlap, abs=1e-12)


def test_images_leave_gaps_below_the_rate_of_no_overlap() -> None:
    # 1 m/s at 0.25 Hz: 4 m apart, 2 m seen
    assert operation.overlap_at_rate(0.25, speed_m_s=1.0, footprint_along_m=2.0) == pytest.approx(-1.0)


def test_operation_accepts_symbols(symbol: Any) -> None:
    function = casadi.Function(
        "operation",
        [symbol],
        [
            operation.blur_px(symbol, ground_sample_m=1e-3, speed_m_s=0.5),
            operation.frame_rate_hz(symbol, footprint_along_m=2.0, overlap=0.5),
            operation.overlap_at_rate(symbol, speed_m_s=0.5, footprint_along_m=2.0),
            operation.flat_largest_pixel_m(symbol, **FLAT, **PIXEL),
        ],
    )
    got = [float(value) for value in function(2.0)]
    largest_m = operation.flat_largest_pixel_m(2.0, **FLAT, **PIXEL)
    assert got == pytest.approx([1000.0, 2.0, 0.875, largest_m], rel=1e-12)
