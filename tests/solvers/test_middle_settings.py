"""Where the objective does not care, settings to set stand in the middle of what is allowed, not at an edge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml

import uwopt
from uwopt.forward.figures import SettingRows
from uwopt.objectives.requirements import MarginRows
from uwopt.report.write import system_yaml
from uwopt.results.design import Margin
from uwopt.results.result import Result
from uwopt.solvers.settable.scene import FULL, ROOMY, Tried, least_first, note_room

MISSION: dict[str, Any] = {
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


def assert_no_other_exposure_has_more(mission: dict[str, Any], solved: Result) -> float:
    """What is in hand of blur and signal to noise: no other exposure, with the gain that keeps the level, has more."""
    assert solved.best is not None
    ours = least_share(solved.best.as_set.scenes[0].margins)
    system = yaml.safe_load(system_yaml(solved))
    settings = system["scenes"]["scene 1"]
    for factor in (0.9, 0.97, 0.99, 1.01, 1.03, 1.1):
        other = {**settings, "exposure_ms": factor * settings["exposure_ms"], "gain": settings["gain"] / factor}
        tried = uwopt.evaluate(mission, system | {"scenes": {"scene 1": other}})
        assert tried.best is not None
        assert least_share(tried.best.scenes[0].margins) < ours + 1e-3  # a microsecond of a few thousand
    return ours


def test_no_other_exposure_has_more_in_hand(solved: Result) -> None:
    assert assert_no_other_exposure_has_more(MISSION, solved) > 0.1


def test_what_the_darkest_of_the_frame_have_in_hand_counts() -> None:
    mission = {**MISSION, "requirements": {**MISSION["requirements"], "snr_at": "worst", "min_snr_db": 20}}
    assert assert_no_other_exposure_has_more(mission, uwopt.solve(mission, quick=True)) > 0.03


def test_of_several_models_the_one_that_leaves_least_counts() -> None:
    # 1 px are asked: lamps as they should be leave 0.4 px, leaning in 0.1 px, leaning out 0.3 px
    left = np.full((1, len(ROOMY)), 0.5)
    for blur_px in (0.6, 0.9, 0.7):
        note_room(left, MarginRows("max_blur_px", np.array([blur_px]), np.ones(1), "<=", "px"))
    assert left[0, ROOMY.index("max_blur_px")] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("margin", "noted"),
    [
        # 22 dB are asked: 1.738 dB in hand are 10^(1.738 / 20) - 1 = 22.2 %, less than the 3 dB that are enough
        (MarginRows("min_snr_mean_db", np.array([23.738]), np.array([22.0]), ">=", "dB"), 0.2215),
        # 3 dB of them are kept in the limit already: the same margin is 4.738 dB of what is asked
        (MarginRows("min_snr_mean_db", np.array([26.738]), np.array([25.0]), ">=", "dB", reserve=3.0), 1.2215),
        # 0.9 of 1 px are used, then 0.75 of 0.8 px, of which a fifth of the pixel is kept unused
        (MarginRows("max_blur_px", np.array([0.9]), np.ones(1), "<=", "px"), 0.1),
        (MarginRows("max_blur_px", np.array([0.75]), np.array([0.8]), "<=", "px", reserve=0.2), 1.0625),
        (MarginRows("dof_near_m", np.array([1.0]), np.array([1.2]), "<=", "m"), 1.1667),
        # of a battery of 150 Wh a fifth is to be left
        (MarginRows("energy_wh", np.array([121.0]), np.array([150.0]), "<=", "Wh"), 0.1933),
        (MarginRows("energy_wh", np.array([120.0]), np.array([150.0]), "<=", "Wh"), 1.2),
        # a tenth of the scale above the highlights; of more than that no setting is chosen
        (MarginRows("saturation_fraction", np.array([0.94]), np.ones(1), "<=", ""), 0.06),
        (MarginRows("saturation_fraction", np.array([0.9]), np.ones(1), "<=", ""), FULL),
    ],
    ids=[
        "little light", "light with a reserve", "much blur", "blur with a reserve", "sharp ahead", "battery nearly out",
        "battery with a fifth left", "bright highlights", "room for highlights",
    ],
)
def test_enough_is_what_good_practice_keeps_in_reserve(margin: MarginRows, noted: float) -> None:
    left = np.full((1, len(ROOMY)), FULL)
    note_room(left, margin)
    assert left[0, ROOMY.index(margin.requirement)] == pytest.approx(noted, abs=1e-4)


def test_highlights_have_room_that_costs_next_to_no_signal(solved: Result) -> None:
    """A drift video stood at 99.85 % of saturation: 17 % more light, as another floor sends back, spoilt it.

    A tenth in hand costs a gain lower by 20 log10(1 / 0.9) = 0.92 dB, and what rounding to 4096 levels adds to noise.
    """
    assert solved.best is not None
    scene = solved.best.as_set.scenes[0]
    assert 0.88 <= scene.figures["saturation_fraction"] <= 0.9
    system = yaml.safe_load(system_yaml(solved))
    settings = system["scenes"]["scene 1"]
    brighter = uwopt.evaluate(MISSION, system | {"scenes": {"scene 1": settings | {"gain": settings["gain"] / 0.9}}})
    assert brighter.best is not None
    assert brighter.best.scenes[0].figures["snr_db"] - scene.figures["snr_db"] < 0.01


def test_with_enough_in_hand_the_least_power_decides() -> None:
    """A flash over an export cable burned 146 W, 1 750 Wh in a watch, where 43 W keep every reserve, too.

    Of equals by the goal: much in hand at 146 W; enough at 43 W, twice, once with more; too little at 20 W.
    """
    rooms = np.array([[1.4, 1.5], [1.02, 1.3], [1.1, 1.3], [0.3, 1.5]])
    power_w, none, one = np.array([146.0, 43.0, 43.0, 20.0]), np.zeros(4), np.ones(4)
    tried = Tried(
        SettingRows(one, one, one, one, one, one, one), none, none, least_first(rooms), none, power_w, none, none, none
    )
    assert tried.best_of_each(np.zeros(4, np.intp)).tolist() == [2]


def test_nothing_is_given_up_for_a_thousandth_of_a_limit() -> None:
    """A year at a vent was told 50 J for 0.22 ms at 12 dB: 0.3078 of contrast, where 25 J for 2.3 ms show 0.3068.

    Of equals by the goal, contrast with 0.0262, 0.0258 and 0.0226 of its limit in hand, beside signal to noise.
    """
    rooms = np.array([[0.0262, 1.002], [0.0258, 1.06], [0.0226, 1.4]])
    power_w, none, one = np.array([0.0521, 0.04220785, 0.04220791]), np.zeros(3), np.ones(3)
    tried = Tried(
        SettingRows(one, one, one, one, one, one, one), none, none, least_first(rooms), none, power_w, none, none, none
    )
    assert tried.best_of_each(np.zeros(3, np.intp)).tolist() == [2]


def test_certified_value_is_what_it_was(solved: Result) -> None:
    best, proof = solved.best, solved.certificate
    assert best is not None and proof is not None
    assert best.as_set.objective_value == best.objective_value == proof.best_value
