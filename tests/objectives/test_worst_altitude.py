"""Requirements over a band of altitudes: the worst of missions that fly at each of them alone."""

from __future__ import annotations

from typing import Any

import pytest

import uwopt
from uwopt.results.design import Margin

ALTITUDE_M, TOLERANCE_M = 2.0, 0.5
LIMITS: dict[str, float] = {
    "max_blur_px": 1.0, "max_skew_px": 100.0, "overlap": 0.3, "max_gsd_mm": 2.0, "min_swath_m": 1.0,
    "min_snr_db": 10.0, "min_mtf_half_nyquist": 0.1, "min_contrast": 0.1,
    "resolve_mm": 50.0, "min_common_swath_m": 0.5, "max_depth_error_mm": 10.0,
}  # fmt: skip
WORST_NEAR = ("max_blur_px", "max_skew_px", "overlap", "min_swath_m", "min_common_swath_m")
SYSTEM: dict[str, Any] = {
    "camera": {"resolution_x_px": 2000, "resolution_y_px": 1000, "pixel_pitch_um": 5.0, "read_noise_e": 5.0,
               "quantum_efficiency": 0.5, "gain_dn_per_e": 0.5, "shutter": "rolling", "max_frame_rate_hz": 10.0},
    "lens": {"focal_length_mm": 10.0, "f_number_min": 1.4, "f_number_max": 16.0},
    "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10, "refractive_index": 1.5},
    "light": {"flux_lm": 10_000, "power_w": 100.0, "beam": "cosine-power", "beam_half_angle_deg": 40.0},
    "camera_count": 2, "settings": {"f_number": 4.0, "exposure_ms": 1.0, "frame_rate_hz": 2.0, "focus_distance_m": 2.0},
}  # fmt: skip


def margins_at(altitude_m: float, tolerance_m: float) -> dict[str, Margin]:
    mission = {
        "practice": "bare", "scene": {"water": "II", "seafloor": 0.2, "depth_m": 300.0},
        "vehicle": {"altitude_m": altitude_m, "altitude_tolerance_m": tolerance_m, "speed_m_s": 0.5,
                    "light_baseline_m": 0.5, "camera_count": 2, "camera_baseline_m": 0.3,
                    "camera_convergence_deg": 5.0},
        "requirements": LIMITS,
    }  # fmt: skip
    design = uwopt.evaluate(mission, SYSTEM, physics="full").design
    assert design is not None
    return {margin.requirement: margin for margin in design.scenes[0].margins}


@pytest.fixture(scope="module")
def band() -> dict[str, Margin]:
    """Margins over the band."""
    return margins_at(ALTITUDE_M, TOLERANCE_M)


@pytest.fixture(scope="module")
def near() -> dict[str, Margin]:
    """Margins at the lower end alone."""
    return margins_at(ALTITUDE_M - TOLERANCE_M, 0.0)


@pytest.fixture(scope="module")
def far() -> dict[str, Margin]:
    """Margins at the upper end alone."""
    return margins_at(ALTITUDE_M + TOLERANCE_M, 0.0)


@pytest.mark.parametrize("name", LIMITS)
def test_margin_is_that_of_the_worst_altitude(
    name: str, band: dict[str, Margin], near: dict[str, Margin], far: dict[str, Margin]
) -> None:
    ends = {1.5: near[name], 2.5: far[name]}
    where = min(ends, key=lambda altitude_m: ends[altitude_m].margin or 0.0)
    assert where == (1.5 if name in WORST_NEAR else 2.5) or name in ("min_mtf_half_nyquist", "resolve_mm")
    # Sharpness takes the colours of the light that returns from the nominal altitude: 3e-3
    assert band[name].value == pytest.approx(ends[where].value, rel=3e-3)
    assert band[name].at_altitude_m == where


def test_ends_differ_so_that_the_worst_can_be_told(near: dict[str, Margin], far: dict[str, Margin]) -> None:
    for name in LIMITS:
        assert near[name].value != pytest.approx(far[name].value, rel=1e-2), name
