"""What a lens's aberrations do to the figures of an image, by the ratio to those of a perfect lens."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

import uwopt

MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "full",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 50},
    "vehicle": {"altitude_m": 2, "speed_m_s": 0.0},
    "requirements": {"frame_interval_s": 1.0},
}  # fmt: skip


@cache
def figures(aberration_um: float, f_number: float) -> dict[str, Any]:
    """An F2 lens in front of pixels of 3.45 um, in a dome."""
    system = {
        "camera": {
            "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
            "quantum_efficiency": 0.6, "bit_depth": 12, "saturation_e": 10000,
        },
        "lens": {"focal_length_mm": 8, "f_number_min": 2.0, "aberration_pitch_um": aberration_um},
        "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10},
        "light": {"flux_lm": 4000, "power_w": 40, "beam_half_angle_deg": 40},
        "settings": {"f_number": f_number, "exposure_ms": 1.0, "gain": 1.0},
    }  # fmt: skip
    return uwopt.evaluate(MISSION, system).design.scenes[0].figures


@pytest.mark.parametrize(
    ("f_number", "power"),
    # At half Nyquist 0.5^((2 x 0.25 x q)^2) with q = 2 pixels wide open: 0.5^1; two stops down the square
    # of the blur is an eighth; in the corner it is 1.8^2 of that on the axis.
    [(2.0, 1.0), (4.0, 1.0 / 8.0)],
)
def test_aberrations_take_contrast_wide_open_and_in_the_corner(f_number: float, power: float) -> None:
    real, perfect = figures(6.9, f_number), figures(0.0, f_number)
    for name, wider in (("mtf_half_nyquist", 1.0), ("mtf_half_nyquist_corner", 1.8**2)):
        assert real[name] / perfect[name] == pytest.approx(0.5 ** (power * wider), rel=1e-9), name
    assert real["snr_db"] == perfect["snr_db"]


def test_fine_detail_suffers_from_an_open_iris_where_a_perfect_lens_gains() -> None:
    perfect, real = (
        [figures(pitch, n)["mtf50_cyc_per_px"] for n in (2.0, 4.0)] for pitch in (0.0, 6.9)
    )
    assert perfect[0] > perfect[1]  # diffraction alone
    assert real[0] < 0.7 * real[1]
