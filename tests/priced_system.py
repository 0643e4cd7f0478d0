"""A system of inline parts of which the camera alone has a price, for what is counted beside the parts."""

from __future__ import annotations

from typing import Any

PRICED: dict[str, Any] = {
    "camera": {"resolution_x_px": 2000, "resolution_y_px": 1000, "pixel_pitch_um": 5.0, "read_noise_e": 5.0,
               "quantum_efficiency": 0.5, "bit_depth": 12, "max_frame_rate_hz": 10.0, "power_w": 4.0,
               "interface": "GigE", "price": 1000.0, "currency": "USD"},
    "lens": {"focal_length_mm": 10.0, "f_number_min": 1.4, "f_number_max": 16.0},
    "port": {"geometry": "flat", "gap_mm": 5.0, "thickness_mm": 10.0},
    "light": {"kind": "pulsed_led", "flux_lm": 3_000, "power_w": 0.0, "beam": "cosine-power",
              "beam_half_angle_deg": 40.0},
    "settings": {"f_number": 4.0, "exposure_ms": 50.0, "pulse_ms": 1.0, "gain": 1.0},
}  # fmt: skip
