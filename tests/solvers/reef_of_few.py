"""The reef of problems/ with few parts and one altitude: solved in a second."""

from __future__ import annotations

from pathlib import Path

from uwopt.mission.mission import Mission, load_mission

PROBLEMS = Path(__file__).parents[2] / "problems"
FEW = {
    "cameras": ["avt-alvium-1800-c-040m", "avt-alvium-1800-c-234m"], "generic": "never",
    "lenses": ["computar-m1214-mp2", "thorlabs-mvl16m1"], "lights": ["arctic-rays-dragonfish-mini-strobe-65deg*"],
    "ports": ["blue-robotics-4-in-acrylic-end-cap-2026", "blue-robotics-4-in-dome-plastic-ring-2026"],
}  # fmt: skip


def reef_of_few_parts() -> Mission:
    """Its mission."""
    base = load_mission(PROBLEMS / "reef-mosaic.yaml").to_dict()
    vehicle = base["vehicle"] | {"altitude_tolerance_m": 0.0}
    return load_mission(base | {"catalog": base["catalog"] | FEW, "vehicle": vehicle})
