"""Physics `auto` against `full`: what is left out may not matter more than the tolerance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uwopt.api import evaluate
from uwopt.effects import choose
from uwopt.model.fidelity import Effects

CASES_A_CHUNK, CHUNKS = 25, 20  # 500 random scenes and systems
RATIOS = (
    "overlap",
    "saturation_fraction",
    "mean_level",
    "min_contrast",
    "min_uniformity",
    "min_mtf_half_nyquist",
)


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number, even in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_mission(rng: np.random.Generator) -> dict[str, Any]:
    """Clear and turbid, near and far, day and night; every requirement that an effect could touch."""
    altitude = between(rng, 0.1, 8.0)
    requirements: dict[str, Any] = {
        "frame_interval_s": 2.0, "min_snr_db": 20.0, "max_gsd_mm": 5.0, "min_swath_m": 0.1,
        "snr_at": rng.choice(["mean", "mean", "worst"]).item(), "min_dof_m": 0.1 * altitude,
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
        "scene": scene, "requirements": requirements, "tolerance": between(rng, 1e-3, 0.1),
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


def distance(name: str, one: float | None, other: float | None) -> float:
    """Change of a figure in the contract's measure: ratios absolutely, decibels by a tenth, the rest relatively."""
    if one is None or other is None:
        return 0.0 if one == other else np.inf
    if name.endswith("_db"):
        return abs(one - other) / 10.0
    if name in (*RATIOS, "contrast"):  # shares; a saturation beyond 1 is no share and counts relatively
        return abs(one - other) / max(1.0, abs(other))
    return abs(one - other) / max(abs(other), 1e-12)


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_auto_stays_within_its_tolerance_of_full(chunk: int) -> None:
    left_out = 0
    for number in range(CASES_A_CHUNK):
        rng = np.random.default_rng([chunk, number])
        mission, system = random_mission(rng), random_system(rng)
        if mission["objective"] == "information":
            mission["requirements"]["min_swath_m"] = 0.1
        full, auto = (evaluate(mission, system, physics=physics) for physics in ("full", "auto"))
        assert full.design is not None and auto.design is not None
        left_out += sum(not e["kept"] and e["bound"] > 0 for e in auto.physics["effects"])
        assert sum(e["bound"] for e in auto.physics["effects"] if not e["kept"]) <= mission["tolerance"] * (
            1 + 1e-12
        )
        objective = mission["objective"]
        pairs = [(objective, auto.design.objective_value, full.design.objective_value)]
        for ours, theirs in zip(auto.design.scenes, full.design.scenes, strict=True):
            values = {m.requirement: m.value for m in theirs.margins}
            pairs += [(m.requirement, m.value, values[m.requirement]) for m in ours.margins]
        for name, ours_value, theirs_value in pairs:
            moved = distance(name, ours_value, theirs_value)
            assert moved <= mission["tolerance"] * (1 + 1e-9), (number, name, ours_value, theirs_value)
    assert left_out > 0  # a contract that never leaves anything out says nothing


def test_an_effect_left_out_has_no_figure_of_its_own() -> None:
    rng = np.random.default_rng(1)
    mission, system = random_mission(rng), random_system(rng)
    mission["scene"].update(water="I", sun_lux=0.0)
    mission["vehicle"]["altitude_m"], mission["tolerance"] = 0.2, 0.4
    mission["requirements"] = {"frame_interval_s": 2.0}
    mission["objective"] = "power"
    result = evaluate(mission, system, physics="auto")
    kept = {e["name"]: e["kept"] for e in result.physics["effects"]}
    assert not kept["backscatter"] and not kept["forward_veil"]
    figures = result.design.scenes[0].figures  # type: ignore[union-attr]
    assert figures["electrons_backscatter"] is None and figures["electrons_forward"] is None
    assert figures["defocus_corner_px"] is None


def test_smallest_bounds_are_left_out_until_the_tolerance_is_spent() -> None:
    bounds = {"forward_veil": 0.003, "backscatter": 0.0015, "window_angle": 0.001, "sunlight": 0.0,
              "image_curvature": float("inf"), "lateral_colour": 0.0}  # fmt: skip
    kept = {i.name: i.kept for i in choose({name: (b, 0.0) for name, b in bounds.items()}, 0.004)}
    assert kept == {"forward_veil": True, "backscatter": False, "sunlight": False, "window_angle": False,
                    "image_curvature": True, "lateral_colour": False}  # fmt: skip


def test_every_effect_is_listed_in_the_lights_order() -> None:
    assert [i.name for i in choose(dict.fromkeys(Effects.names(), (0.0, 0.0)), 0.005)] == list(
        Effects.names()
    )
