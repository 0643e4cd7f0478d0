"""Between which numbers a part can lie at all: a hundred times beyond anything made, and within what floats hold.

A number outside has a wrong unit, or is none of a part. Zero is left to the columns and keys themselves.
"""

from __future__ import annotations

SMALLEST, LARGEST = 1e-12, 1e12  # of any number but 0

#: Least and greatest by column or key, the same in files of own parts and in inline records.
PHYSICAL: dict[str, tuple[float, float]] = {
    "pixel_pitch_um": (0.05, 100.0),
    "resolution_x_px": (1.0, 1e5),
    "resolution_y_px": (1.0, 1e5),
    "read_noise_e": (SMALLEST, 1e6),
    "saturation_e": (1.0, 1e10),
    "dark_current_e_s": (SMALLEST, 1e9),
    "gain_dn_per_e": (1e-9, 1e9),
    "max_gain_db": (SMALLEST, 120.0),
    "max_frame_rate_hz": (1e-6, 1e9),
    "min_exposure_us": (1e-6, 1e10),
    "max_exposure_us": (1e-6, 1e10),
    "focal_length_mm": (0.05, 1e4),
    "f_number_min": (0.4, 128.0),
    "f_number_max": (0.4, 128.0),
    "image_circle_mm": (0.01, 1e5),
    "outer_radius_mm": (0.1, 1e6),
    "thickness_mm": (1e-3, 1e6),
    "clear_diameter_mm": (0.01, 1e6),
    "gap_mm": (SMALLEST, 1e6),
    "flux_lm": (1e-3, 1e10),
    "power_w": (1e-9, 1e9),
    "mean_power_w": (1e-9, 1e9),
    "peak_candela": (1e-6, 1e12),
    "guide_number_m": (1e-3, 1e5),
    "beam_angle_deg": (0.05, 179.9),
    "beam_half_angle_deg": (0.05, 89.95),
    "min_pulse_us": (1e-6, 1e10),
    "max_pulse_us": (1e-6, 1e10),
    "max_rate_hz": (1e-6, 1e9),
    "flash_energy_j": (1e-9, 1e9),
    "flash_efficacy_lm_s_per_j": (1e-6, 1e4),
    "flash_duration_us": (1e-6, 1e10),
    "front_radius_mm": (1e-3, 1e5),
    "transmission_frac": (1e-9, 1.0),
    "quantum_efficiency": (1e-9, 1.0),
    "qe": (1e-9, 1.0),
    "output_factor": (1e-9, 1.0),
    "max_duty_frac": (1e-9, 1.0),
    "charging_efficiency_frac": (1e-9, 1.0),
}


def beyond(name: str, value: float) -> str:
    """What is wrong with a number of this name: `is below 0.05`; empty where nothing is."""
    least, most = PHYSICAL.get(name, (SMALLEST, LARGEST))
    if value == 0.0 or least <= abs(value) <= most:
        return ""
    return f"is below {least:g}" if abs(value) < least else f"is above {most:g}"
