"""What a part must fulfil: limits by hand, and held against systems evaluated just within and beyond."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from priced_system import PRICED

from uwopt.api.evaluating import evaluate
from uwopt.evaluation.recompute import Replay, replay
from uwopt.objectives.goal import goal_of
from uwopt.solvers.explain.specification import (
    Asked,
    PartTrial,
    PropertyLimit,
    corners,
    holds,
    specification,
    worse,
)

NEEDS = {"overlap": 0.6, "max_blur_px": 1.0, "min_snr_db": 26.5}
MISSION: dict[str, Any] = {
    "physics": "paper", "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_count": 2}, "requirements": NEEDS,
    "limits": {"power_w": 20.0},
}  # fmt: skip
SETTINGS = {"f_number": 4.0, "exposure_ms": 3.0, "pulse_ms": 1.0, "gain": 4.0, "frame_rate_hz": 2.0}
SYSTEM = PRICED | {
    "camera": PRICED["camera"] | {"mounts": ["C"]}, "lens": PRICED["lens"] | {"mounts": ["C"]},
    "light": PRICED["light"] | {"flux_lm": 30_000.0}, "light_count": 2, "settings": SETTINGS,
}  # fmt: skip


@pytest.fixture(scope="module")
def made() -> Replay:
    result = evaluate(MISSION, SYSTEM)
    assert result.status == "feasible"
    return replay(result.mission, result.best, physics=result.physics, system=result.system)


@pytest.fixture(scope="module")
def limits(made: Replay) -> dict[tuple[str, str], PropertyLimit]:
    problem = made.model.problem
    goal = goal_of(problem.mission)
    return {
        (kind, one.name): one
        for kind in ("camera", "lens")
        for one in specification(problem, made.model.hardware, goal, kind, rival=5.0)
    }


def test_slowest_camera_is_that_of_the_overlap(limits: dict[tuple[str, str], PropertyLimit]) -> None:
    # by hand: turned, 2000 rows of 2 m x 5 um / 13.3 mm are 1.504 m; 60 % overlap at 0.5 m/s: 0.5 / (0.4 x 1.504)
    rate = limits["camera", "max_frame_rate_hz"]
    assert rate.more_is_better
    assert rate.feasible == pytest.approx(0.83125, rel=2e-3)  # n = 1.33 of the hand value, and the bisection


def test_of_what_may_be_as_bad_as_it_likes_nothing_is_asked(made: Replay) -> None:
    """Makers of a camera that is set to 12 dB were told that 37.5 dB are the least that suits."""
    problem = made.model.problem
    every = specification(problem, made.model.hardware, goal_of(problem.mission), "camera", rival=1e-9)
    assert all((one.together is None) == (one.feasible is None) for one in every)
    gain = next(one for one in every if one.name == "max_gain_db")  # no level is asked for that a gain would reach
    assert gain.feasible is None


def test_power_is_limited_by_the_mission_and_by_the_rival(limits: dict[tuple[str, str], PropertyLimit]) -> None:
    # the lamps take nothing: a camera may take the 20 W of the mission, and 5 W as long as it is to be the best
    power = limits["camera", "power_w"]
    assert power.feasible == pytest.approx(20.0, rel=2e-3)
    assert power.best == pytest.approx(5.0, rel=2e-3)
    assert power.best <= 5.0


def test_limit_of_a_lens_is_where_evaluate_finds_too_little_light(limits: dict[tuple[str, str], PropertyLimit]) -> None:
    # wide open, pulse as long as blur allows: 1 px / 0.665 px x 1 ms, nothing brighter can be set
    widest = limits["lens", "f_number_min"].feasible
    assert widest is not None
    for step, held in ((-2e-3, True), (2e-3, False)):
        settings = SETTINGS | {"f_number": widest * (1.0 + step), "pulse_ms": 1.0 / 0.665, "exposure_ms": 3.0}
        again = evaluate(MISSION, SYSTEM | {"settings": settings})
        snr = next(m for m in again.best.scenes[0].margins if m.requirement == "min_snr_db")
        assert snr.satisfied is held


def test_all_numbers_together_still_do_and_lie_within_their_limits(
    made: Replay, limits: dict[tuple[str, str], PropertyLimit]
) -> None:
    problem = made.model.problem
    lens = [one for (kind, _), one in limits.items() if kind == "lens"]
    trial = PartTrial(problem, made.model.hardware, goal_of(problem.mission), "lens")
    assert math.isfinite(trial.values([{one.name: one.together for one in lens if one.together is not None}])[0])
    for one in lens:
        if one.feasible is not None and one.together is not None:
            low, high = sorted((one.value, one.feasible))
            assert low <= one.together <= high


def test_every_limit_holds_within_and_not_beyond(made: Replay, limits: dict[tuple[str, str], PropertyLimit]) -> None:
    problem = made.model.problem
    trial = PartTrial(problem, made.model.hardware, goal_of(problem.mission), "camera")
    camera = [one for (kind, _), one in limits.items() if kind == "camera" and one.feasible is not None]
    within = trial.values([{one.name: one.feasible} for one in camera])
    beyond = trial.values([{one.name: one.feasible * (0.99 if one.more_is_better else 1.01)} for one in camera])
    assert np.isfinite(within).all()
    assert np.isinf(beyond).all()


def test_worse_stays_within_what_a_part_may_be() -> None:
    assert worse(Asked("beam_angle_deg", 90.0, -1), 3.0) == pytest.approx(180.0 * 0.99)
    assert worse(Asked("flux_lm", 1000.0, 1), math.log(10.0)) == pytest.approx(100.0)


def test_a_rival_that_is_as_good_ends_the_claim() -> None:
    assert holds(4.0, math.inf)
    assert not holds(math.inf, math.inf)
    assert not holds(4.0, 4.0)
    assert holds(4.0, 4.1)


# ---------------------------------------------------------------- both ends


BOTH = MISSION | {"requirements": NEEDS | {"max_gsd_mm": 0.9, "min_swath_m": 1.3}}


def test_a_focal_length_has_two_ends() -> None:
    # by hand: pixels of 2 m x 5 um / (1.33 f) are 0.9 mm at 8.354 mm, and 2000 of them 1.3 m wide at 11.567 mm
    result = evaluate(BOTH, SYSTEM)
    assert result.status == "feasible"
    again = replay(result.mission, result.best, physics=result.physics, system=result.system)
    problem, hardware = again.model.problem, again.model.hardware
    found = specification(problem, hardware, goal_of(problem.mission), "lens", rival=math.inf)
    low, high = (one for one in found if one.name == "focal_length_mm")
    assert low.more_is_better and not high.more_is_better
    assert low.feasible == pytest.approx(2.0 * 5e-3 / (1.33 * 0.9e-3), rel=2e-3)
    assert high.feasible == pytest.approx(2000 * 2.0 * 5e-3 / (1.33 * 1.3), rel=2e-3)
    assert low.feasible <= low.together <= 10.0 <= high.together <= high.feasible
    trial = PartTrial(problem, hardware, goal_of(problem.mission), "lens")
    others = {one.name: one.together for one in found if one.name != "focal_length_mm"}
    for end in (low.together, 10.0, high.together):
        assert math.isfinite(trial.values([others | {"focal_length_mm": end}])[0])


def test_a_part_of_a_system_that_does_not_fit_has_no_limits() -> None:
    result = evaluate(BOTH | {"requirements": NEEDS | {"max_gsd_mm": 0.5}}, SYSTEM)
    assert result.status == "violated"
    again = replay(result.mission, result.best, physics=result.physics, system=result.system)
    problem, goal = again.model.problem, goal_of(again.model.problem.mission)
    assert specification(problem, again.model.hardware, goal, "lens", rival=math.inf) == []


def test_every_end_is_tried_with_every_other() -> None:
    asked = [Asked("a", 1.0, 1), Asked("b", 2.0, 1), Asked("b", 2.0, -1), Asked("c", 3.0, 1), Asked("c", 3.0, -1)]
    made = corners(asked, [0.5, 1.5, 2.5, 2.0, 4.0])
    assert made == [{"a": 0.5, "b": b, "c": c} for b in (1.5, 2.5) for c in (2.0, 4.0)]
