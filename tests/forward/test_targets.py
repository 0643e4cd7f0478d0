"""Walls and targets in open water: what the camera sees behind its targets, against quadrature over the ray."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from scipy.integrate import quad

import uwopt

A_PER_M, B_PER_M = 0.2, 0.8
C_PER_M, K_PER_M = A_PER_M + B_PER_M, 0.5
BACKWARD = 0.3  # so much that what the sea's molecules send back hardly counts beside it
BASELINE_M, TILT_DEG, HALF_POWER_DEG = 0.5, -30.0, 30.0
DISTANCE_M = 0.4


def mean_cosine() -> float:
    """g of a Henyey-Greenstein function of which 30 % go backward: (1 - g)/(2 g) ((1 + g)/sqrt(1 + g^2) - 1)."""
    low, high = 1e-6, 1.0 - 1e-9
    for _ in range(60):
        g = 0.5 * (low + high)
        back = (1 - g) / (2 * g) * ((1 + g) / math.sqrt(1 + g * g) - 1)
        low, high = (g, high) if back > BACKWARD else (low, g)
    return low


def sent_back(until_m: float) -> float:
    """Veil on the axis between the port and a distance: integral of I p exp(-K s - c r) / s^2, I of the axis 1."""
    g, tilt = mean_cosine(), math.radians(TILT_DEG)
    exponent = math.log(0.5) / math.log(math.cos(math.radians(HALF_POWER_DEG)))

    def at(r: float) -> float:
        s = math.hypot(BASELINE_M, r)
        aim = (math.sin(tilt) * -BASELINE_M + math.cos(tilt) * r) / s  # tilted outward: negative is inward
        turned = -r / s  # of the light's way out along the ray to the way back
        phase = (1 - g * g) / (4 * math.pi * (1 + g * g - 2 * g * turned) ** 1.5)
        return max(aim, 0.0) ** exponent * phase * math.exp(-K_PER_M * s - C_PER_M * r) / s**2

    value, _ = quad(at, 0.0, until_m, limit=200)
    return float(value)


def rig(folder: Path, target: str, **scene: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """A camera of four pixels behind a dome, one lamp beside it, grey water."""
    water = folder / "grey.csv"
    rows = "".join(f"{nm},{A_PER_M},{B_PER_M},{C_PER_M},{K_PER_M}\n" for nm in (380, 780))
    water.write_text("wavelength_nm,a_per_m,b_per_m,attenuation_per_m,kd_per_m\n" + rows, encoding="utf-8")
    mission = {
        "physics": "full", "practice": "bare",
        "scene": {
            "water": str(water), "seafloor": 0.05, "depth_m": 30, "target": target, "backscatter_ratio": BACKWARD,
            "phase_function": "henyey-greenstein", "multiple_scattering": False, **scene,
        },
        "vehicle": {"distance_m": DISTANCE_M, "speed_m_s": 0.0, "light_count": 1},
        "requirements": {"frame_interval_s": 1.0},
    }  # fmt: skip
    system = {
        "camera": {
            "resolution_x_px": 2, "resolution_y_px": 2, "pixel_pitch_um": 3.45, "read_noise_e": 2.0,
            "quantum_efficiency": 0.6, "saturation_e": 1e7, "bit_depth": 16,
        },
        "lens": {"focal_length_mm": 50.0, "transmission": 0.9},
        "port": {"geometry": "dome", "outer_radius_mm": 50, "thickness_mm": 5, "refractive_index": 1.5},
        "light": {
            "flux_lm": 4000, "power_w": 40, "spectrum": "generic-led", "beam": "cosine-power",
            "beam_half_angle_deg": HALF_POWER_DEG,
        },
        "light_mounts": [{"y_m": BASELINE_M, "tilt_y_deg": TILT_DEG}],
        "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": 4000},
    }  # fmt: skip
    return mission, system


def figures(folder: Path, target: str, **scene: Any) -> dict[str, Any]:
    return dict(uwopt.evaluate(*rig(folder, target, **scene)).design.scenes[0].figures)  # type: ignore[union-attr]


def test_open_water_sends_back_the_light_of_the_whole_ray(tmp_path: Path) -> None:
    got = figures(tmp_path, "mid_water")
    expected = sent_back(200.0) / sent_back(DISTANCE_M)
    assert expected > 1.2
    # sea water's own molecules scatter some parts in a thousand of this b, otherwise than particles
    assert got["electrons_background"] / got["electrons_backscatter"] == pytest.approx(expected, rel=5e-3)


def test_before_a_wall_the_target_counts_alone(tmp_path: Path) -> None:
    wall, water = figures(tmp_path, "wall"), figures(tmp_path, "mid_water")
    assert "background_level" not in wall
    seen = wall.keys() - {"saturation_fraction"}  # of the same target at the same distance
    assert {name: water[name] for name in seen} == {name: wall[name] for name in seen}


def test_the_brighter_of_target_and_water_is_what_must_not_saturate(tmp_path: Path) -> None:
    bright, dark = figures(tmp_path, "mid_water", seafloor=0.5), figures(tmp_path, "mid_water", seafloor=0.0)
    assert bright["background_level"] < bright["mean_level"]
    assert bright["saturation_fraction"] == pytest.approx(1.5 * bright["mean_level"])
    assert dark["background_level"] > dark["mean_level"]
    assert dark["saturation_fraction"] == pytest.approx(1.5 * dark["background_level"])


def test_auto_keeps_backscatter_where_open_water_is_the_brightest(tmp_path: Path) -> None:
    mission, system = rig(tmp_path, "mid_water", seafloor=0.4)
    mission["vehicle"]["distance_m"] = 0.1  # hardly any water before the target, and little of the beam
    result = uwopt.evaluate(mission | {"physics": "auto", "tolerance": 0.5}, system)
    assert result.design is not None
    assert result.design.scenes[0].figures["background_level"] > 0.0
