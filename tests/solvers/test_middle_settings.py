"""Where the objective does not care, settings to set stand in the middle of what is allowed, not at an edge."""

from __future__ import annotations

import pytest

import uwopt
from uwopt.report.write import system_yaml
from uwopt.results.design import Margin
from uwopt.results.result import Result

MISSION = {
    "practice": "bare", "name": "cheapest", "objective": "cost", "confidence": "central",
    "scene": {"water": "II", "seafloor": "coral", "depth_m": 30},
    "vehicle": {"altitude_m": 2.0, "altitude_tolerance_m": 0.25, "speed_m_s": 0.5, "light_baseline_m": 0.8,
                "light_count": [1, 2]},
    "requirements": {"overlap": 0.6, "max_blur_px": 1.0, "min_snr_db": 25, "min_dof_m": 0.6},
    "limits": {"power_w": 150, "depth_rating_m": 100},
    "catalog": {"cameras": ["allied*"], "generic": "never"},
}  # fmt: skip


@pytest.fixture(scope="module")
def solved() -> Result:
    """The cheapest system: its lamp burns on, so that exposure moves neither cost nor power."""
    return uwopt.solve(MISSION, quick=True)


def least_share(margins: list[Margin]) -> float:
    """The least that is in hand of blur and signal to noise, as a share of each limit; of decibels as a ratio."""
    held = {m.requirement: m for m in margins}
    blur, snr = held["max_blur_px"], held["min_snr_db"]
    assert blur.margin is not None and blur.limit is not None and snr.margin is not None
    return min(blur.margin / blur.limit, 10.0 ** (snr.margin / 20.0) - 1.0)


def test_no_other_exposure_has_more_in_hand(solved: Result) -> None:
    import yaml

    assert solved.best is not None
    shown = solved.best.as_set
    ours = least_share(shown.scenes[0].margins)
    assert ours > 0.1
    system = yaml.safe_load(system_yaml(solved))
    settings = system["scenes"]["scene 1"]
    for factor in (0.9, 0.97, 0.99, 1.01, 1.03, 1.1):  # exposure and gain together, which keep the level as it is
        other = {**settings, "exposure_ms": factor * settings["exposure_ms"], "gain": settings["gain"] / factor}
        tried = uwopt.evaluate(MISSION, system | {"scenes": {"scene 1": other}})
        assert tried.best is not None
        assert least_share(tried.best.scenes[0].margins) < ours + 1e-3  # a microsecond of a few thousand


def test_certified_value_is_what_it_was(solved: Result) -> None:
    best, proof = solved.best, solved.certificate
    assert best is not None and proof is not None
    assert best.as_set.objective_value == best.objective_value == proof.best_value
