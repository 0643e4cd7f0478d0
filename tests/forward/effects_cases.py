"""Random missions and systems that physics `auto` and estimated errors are tested on."""

from __future__ import annotations

from typing import Any

import numpy as np


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number, even in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_mission(rng: np.random.Generator) -> dict[str, Any]:
    """Clear and turbid, near and far, day and night; every requirement that an effect could touch."""
    altitude = between(rng, 0.1, 8.0)
    requirements: dict[str, Any] = {
        "frame_interval_s": 2.0, "min_snr_db": 20.0, "max_gsd_mm": 5.0, "min_swath_m": 0.1,
        "snr_at": rng.choice(["mean", "mean", "worst_px"]).item(), "min_dof_m": 0.1 * altitude,
        "dof_at": rng.choice(["axis", "corner"]).item(),
    }  # fmt: skip
    if rng.random() < 0.5:
        requirements["max_blur_px"] = 2.0
    asked = {"min_contrast": 0.3, "min_uniformity": 0.2, "min_mtf_half_nyquist": 0.2}
    requirements |= {key: value for key, value in asked.items() if rng.random() < 0.3}
    if rng.random() < 0.4:
        requirements["mean_level"] = 0.2
    scene: dict[str, Any] = {
        "water": rng.choice(["I", "IA", "IB", "II", "III", "1C", "3C", "5C"]).item(), "depth_m": between(rng, 9, 200),
        "seafloor": float(rng.uniform(0.03, 0.6)), "backscatter_ratio": between(rng, 0.005, 0.05),
        "salinity_psu": float(rng.choice([0.0, 35.0])),
    }  # fmt: skip
    if rng.random() < 0.3:
        scene.update(sun_lux=between(rng, 1e-3, 1e5), sun_elevation_deg=float(rng.uniform(5, 90)))
    return {
        "practice": "bare", "scene": scene, "requirements": requirements, "tolerance": between(rng, 1e-3, 0.1),
        "objective": rng.choice(["power", "snr_db", "contrast", "information"]).item(),
        "vehicle": {
            "altitude_m": altitude, "altitude_tolerance_m": float(rng.choice([0.0, 0.2])) * altitude,
            "speed_m_s": float(rng.choice([0.0, 0.5])),
            "light_baseline_m": between(rng, 0.05, 1.5), "light_tilt_deg": float(rng.uniform(-10, 20)),
        },
    }  # fmt: skip


def random_system(rng: np.random.Generator) -> dict[str, Any]:
    """A camera, lens, port and lamps that need not be good."""
    dome = {
        "geometry": "dome",
        "outer_radius_mm": between(rng, 30, 150),
        "thickness_mm": 4.0,
        "glass": "n_bk7",
    }
    flat = {
        "geometry": "flat",
        "gap_mm": between(rng, 5, 80),
        "thickness_mm": between(rng, 3, 20),
        "glass": "pmma",
    }
    return {
        "camera": {
            "resolution_x_px": 2000, "resolution_y_px": 1500, "pixel_pitch_um": 3.45, "quantum_efficiency": 0.6,
            "read_noise_e": 3.0, "saturation_e": 10000.0, "bit_depth": 12, "power_w": 3.0, "max_gain_db": 24.0,
        },
        "lens": {"focal_length_mm": between(rng, 4, 25), "f_number_min": 1.4, "f_number_max": 16, "transmission": 0.9},
        "port": dome if rng.random() < 0.5 else flat,
        "light": {
            "kind": rng.choice(["continuous", "pulsed_led"]).item(), "flux_lm": between(rng, 1e3, 1e5),
            "power_w": 100.0,
            "beam": rng.choice(["cosine-power", "cosine-power", "cone"]).item(),
            "beam_half_angle_deg": float(rng.uniform(25, 60)),
        },
        "light_count": int(rng.integers(1, 5)),
        "settings": {"f_number": between(rng, 1.4, 11), "exposure_ms": between(rng, 0.1, 10), "pulse_ms": 0.1},
    }  # fmt: skip
