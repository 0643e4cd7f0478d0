"""Area per hour: what it asks of the swath, and what a design covers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import uwopt
from uwopt.errors import MissionError

ABE = str(Path(__file__).parents[2] / "problems" / "whoi-abe")


def changed(**wanted: Any) -> uwopt.Mission:
    """A survey at 0.3 m/s with other requirements."""
    return uwopt.load_mission({
        "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 30},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3}, "requirements": {"overlap": 0.5, **wanted},
    })  # fmt: skip


def test_area_in_an_hour_asks_for_a_swath() -> None:
    # 1000 m2/h at 0.3 m/s: 0.9259 m between lines; a fifth of sidelap: 1.1574 m of swath
    assert changed(min_area_m2_h=1000).views[0].requirements.min_swath_m == pytest.approx(0.925926, rel=1e-6)
    held = changed(min_area_m2_h=1000, sidelap=0.2).views[0].requirements.min_swath_m
    assert held == pytest.approx(1.157407, rel=1e-6)


def test_wider_swath_that_is_asked_stays() -> None:
    assert changed(min_area_m2_h=1000, min_swath_m=3.0).views[0].requirements.min_swath_m == 3.0


def test_design_tells_its_lines_and_area() -> None:
    mission = uwopt.load_mission(f"{ABE}.yaml").with_changes(requirements={"sidelap": 0.25})
    design = uwopt.evaluate(mission, f"{ABE}.system.yaml").design
    assert design is not None
    figures, speed_m_s = design.scenes[0].figures, mission.views[0].vehicle.speed_m_s
    assert figures["line_spacing_m"] == pytest.approx(0.75 * figures["swath_m"], rel=1e-12)
    assert figures["area_m2_h"] == pytest.approx(0.75 * figures["swath_m"] * speed_m_s * 3600, rel=1e-12)


def test_lines_overlap_where_the_vehicle_flies_lowest() -> None:
    """An AUV at 5 m, give or take 1.5 m, was told lines 5.4 m apart, 20 % overlap: of strips 4.7 m wide at 3.5 m."""

    def seen(**vehicle: Any) -> dict[str, Any]:
        mission = uwopt.load_mission(f"{ABE}.yaml")
        changes = {"requirements": {"sidelap": 0.2}, "vehicle": vehicle}
        made = {key: mission.to_dict()[key] | more for key, more in changes.items()}
        mission = mission.with_changes(**made)
        design = uwopt.evaluate(mission, f"{ABE}.system.yaml").design
        assert design is not None
        return dict(design.scenes[0].figures)

    level, banded, lowest = seen(), seen(altitude_tolerance_m=1.5), seen(altitude_m=3.5)
    narrower = banded["line_spacing_m"] / level["line_spacing_m"]
    assert narrower == pytest.approx(3.5 / 5.0, rel=0.02)  # similar triangles, but for the port's own few centimetres
    assert banded["line_spacing_m"] == pytest.approx(0.8 * lowest["swath_m"], rel=0.01)  # focused for 5 m, not 3.5
    assert banded["area_m2_h"] == pytest.approx(0.4 * 3600.0 * banded["line_spacing_m"])
    assert banded["swath_m"] == pytest.approx(level["swath_m"])  # of images where the vehicle mostly flies


def test_area_at_rest_is_a_fault() -> None:
    with pytest.raises(MissionError, match="nothing is covered"):
        uwopt.load_mission({
            "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 30},
            "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0},
            "requirements": {"frame_interval_s": 10, "min_area_m2_h": 5},
        })  # fmt: skip
