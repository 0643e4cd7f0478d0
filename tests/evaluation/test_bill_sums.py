"""The rows of a bill add up to the totals: cost, mass and power, of one system that has everything that counts."""

from __future__ import annotations

from typing import Any

import pytest
from priced_system import PRICED

import uwopt

MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "paper",
    "scenes": [
        {"name": "slow", "water": "II", "seafloor": 0.2, "depth_m": 300.0, "requirements": {"frame_interval_s": 20.0}},
        {"name": "quick", "water": "II", "seafloor": 0.2, "depth_m": 300.0, "requirements": {"frame_interval_s": 10.0}},
    ],
    "vehicle": {"altitude_m": 0.25, "speed_m_s": 0.0, "light_count": [2, 2], "camera_count": 2, "duration_h": 10.0,
                "battery_wh": 500.0, "supply": "battery", "camera_between_images": "off"},
    "requirements": {"circle_of_confusion_px": 2.0},
    "catalog": {"rest": "estimate", "host": "estimate", "spacers": "allow", "owned": [],
                "extras": [{"name": "frame", "cost": 900.0, "mass_kg": 2.5, "power_w": 1.5}]},
}  # fmt: skip
SYSTEM: dict[str, Any] = {
    **PRICED, "camera_count": 2, "light_count": 2, "light_baseline_m": 0.5, "spacer_mm": 0.25,
    "camera": {**PRICED["camera"], "mass_g": 120.0},
    "lens": {**PRICED["lens"], "mass_g": 60.0, "min_object_distance_m": 0.26, "spacers_mm": [0.25]},
    "port": {"geometry": "dome", "radius_mm": 90.0, "thickness_mm": 10.0, "mass_g": 800.0},
    "housing": {"inner_diameter_mm": 100.0, "inner_length_mm": 250.0, "outer_diameter_mm": 114.0, "mass_g": 2500.0,
                "depth_rating_m": 500.0, "ports": ["any"], "price": 700.0},
    "light": {**PRICED["light"], "power_w": 100.0, "mass_g": 500.0, "price": 400.0},
}  # fmt: skip


def test_rows_of_a_bill_add_up_to_cost_mass_and_power() -> None:
    design = uwopt.evaluate(MISSION, SYSTEM).design
    assert design is not None
    rows = {row.id: row for row in design.bom}
    assert {"adapter-flange", "spacer-ring", "rest-battery", "host-computer", "frame"} <= set(rows)
    paid = sum(row.to_buy * (row.unit_price or 0.0) for row in design.bom)
    assert paid == pytest.approx(design.scenes[0].figures["cost"]) == pytest.approx(design.totals.cost.value)
    assert sum(row.count * (row.unit_mass_kg or 0.0) for row in design.bom) == pytest.approx(design.totals.mass_kg)
    assert sum(row.power_w or 0.0 for row in design.bom) == pytest.approx(design.totals.power_w)
    # 2 (120 + 60 + 800 + 2500 + 3 g, flange 1730 g (180 / 200)^2), 2 x 500 g, battery 500 Wh x 14 g, frame 2.5 kg
    assert design.totals.mass_kg == pytest.approx(2 * (3.483 + 1.4013) + 1.0 + 7.0 + 2.5)
