"""A cap of gain that yields: held while anything fits below it, lifted with a warning where nothing does."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

import uwopt
from uwopt.mission.mission import load_mission

HARDWARE = {"cameras": ["flir-bfs-u3-120s4m"], "lenses": ["kowa"], "lights": ["deepsea"], "generic": "never"}
CAP_DB = 20.0


@cache
def solved(cap_db: float | None, *, dark: bool) -> Any:
    """A survey with one camera, from so near that there is light enough, or from farther and faster."""
    mission: dict[str, Any] = {
        "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30}, "physics": "paper",
        "vehicle": {
            "altitude_m": 2.0 if dark else 1.0, "speed_m_s": 0.3 if dark else 0.1, "light_count": [1, 4 if dark else 8],
        },
        "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "mean_level": 0.3 if dark else 0.15, "min_snr_db": 10},
        "catalog": HARDWARE, "reserve": {} if cap_db is None else {"max_gain_db": cap_db},
    }  # fmt: skip
    return uwopt.solve(mission, top=1, quick=True)


def gain_db(result: Any) -> float:
    """Of the recommendation."""
    return float(result.recommendation.scenes[0].settings["gain_db"])


def test_a_gain_that_is_not_needed_stays_below_its_cap() -> None:
    free, held = solved(None, dark=False), solved(CAP_DB, dark=False)
    assert gain_db(free) > CAP_DB >= gain_db(held) - 1e-6
    assert "gain_cap" not in [note.code for note in held.warnings]


def test_a_cap_below_which_nothing_fits_is_lifted_with_a_warning() -> None:
    free, held = solved(None, dark=True), solved(CAP_DB, dark=True)
    assert gain_db(held) == pytest.approx(gain_db(free))
    told = [note.message for note in held.warnings if note.code == "gain_cap"]
    assert told == [f"gain {gain_db(free):.3g} dB, beyond 20 dB, below which nothing fits: light is out of reach"]


def test_a_number_of_the_requirements_is_hard() -> None:
    mission = load_mission({
        "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30}, "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3},
        "requirements": {"overlap": 0.3, "max_gain_db": 0}, "reserve": "recommended",
    })  # fmt: skip
    assert mission.views[0].requirements.max_gain_db == 0.0
    assert mission.without_gain_cap.views[0].requirements.max_gain_db == 0.0
    assert mission.reserve.max_gain_db == 12.0
