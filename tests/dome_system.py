"""A system of inline parts behind a dome, of round numbers: a pixel is 5 um over 8 mm, its pinhole in the middle."""

from __future__ import annotations

from typing import Any

BEHIND_DOME: dict[str, Any] = {
    "camera": {
        "resolution_x_px": 1000, "resolution_y_px": 800, "pixel_pitch_um": 5.0, "saturation_e": 10_000,
        "read_noise_e": 3.0, "quantum_efficiency": 0.5, "shutter": "global", "max_frame_rate_hz": 50.0,
    },
    "lens": {"focal_length_mm": 8, "f_number_min": 1.4, "f_number_max": 16},
    "port": {"geometry": "dome", "outer_radius_mm": 50, "thickness_mm": 5},
    "light": {"luminous_flux_lm": 10_000, "power_w": 100, "beam": "cosine-power", "beam_angle_deg": 90},
    "orientation": "landscape", "settings": {"exposure_ms": 5.0, "f_number": 4.0},
}  # fmt: skip
