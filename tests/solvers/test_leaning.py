"""Lamps that lean as far as the mission's reserve: what is printed to set holds for them, or other parts are taken."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import random_cases as rc
from front_cases import ON, STEPS

from uwopt.evaluation.design import evaluate_design
from uwopt.evaluation.leaning import leaning
from uwopt.forward.problem import Problem
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL
from uwopt.results.design import Design
from uwopt.solvers.recommend import Sought, best_settable
from uwopt.solvers.settable.rounding import Rounded, rounded_design

NARROW = replace(ON, id="narrow", beam_angle_deg=replace(ON.beam_angle_deg, value=14.0, low=14.0, high=14.0))
FLOOD = replace(ON, id="flood", power_w=replace(ON.power_w, value=250.0, low=250.0, high=250.0))
OFF_DEG = 20.0
FAR_OFF_DEG = 30.0  # from 2 m a spot moves by more than a metre, out of the image


def case(lights: tuple[Any, ...], off_deg: float, *, tilt_deg: float = 0.0, **asked: Any) -> rc.Case:
    """One camera with these lamps at a tilt, off which they may be by an angle."""
    made = rc.planted("power", lights, {"max_blur_px": 2.0, **asked}, light_tilt_deg=tilt_deg)
    return replace(made, mission=made.mission.with_changes(reserve={"tilt_deg": off_deg}))


def found(made: rc.Case) -> tuple[Problem, Any]:
    """The problem of a case and its optimum."""
    search, outcome = made.solve(top=1)
    return search.problem, outcome.best[0]


def missed(made: rc.Case, problem: Problem, best: Any, set_: Rounded, by_deg: float) -> list[str]:
    """What these settings miss when the lamps are built in with another tilt, by the forward model of that design."""
    hardware = best.hardware
    hardware = replace(hardware, mount=leaning(hardware.mount, by_deg))
    plain = Problem(made.mission.with_changes(reserve={"tilt_deg": 0.0}), made.parts, paper=False)
    design = evaluate_design(
        plain.with_mount(hardware.mount), hardware, set_.given, made.objective, level_tolerance_rel=LEVEL_TOLERANCE_REL
    )
    return [m.requirement for scene in design.scenes for m in scene.margins if not m.satisfied]


@pytest.mark.parametrize(
    "asked", [{"min_snr_db": 20.0}, {"min_snr_db": 15.0, "snr_at": "worst"}, {"min_snr_db": 20.0, "tilt_deg": -20.0}],
    ids=["mean", "frame", "inward"],
)
def test_settings_to_set_hold_with_lamps_that_lean(asked: dict[str, Any]) -> None:
    """Without the reserve the same lamps lose something when they lean; with it nothing either way."""
    lost = {}
    for off_deg in (0.0, OFF_DEG):
        made = case((STEPS,), off_deg, **asked)
        problem, best = found(made)
        set_ = rounded_design(problem, best.hardware, best.settings, made.objective)
        assert set_.design.feasible
        assert set_.design.objective_value >= best.minimised * (1 - 1e-9)  # the bound of the search holds
        lost[off_deg] = [missed(made, problem, best, set_, by_deg) for by_deg in (-OFF_DEG, 0.0, OFF_DEG)]
    assert any(lost[0.0]) and not any(lost[OFF_DEG])


def recommended(off_deg: float, lights: tuple[Any, ...]) -> tuple[Design, list[str]]:
    """What is recommended of lamps that burn as they do, with the codes of its warnings."""
    made = case(lights, off_deg, min_snr_db=20.0)
    search, outcome = made.solve(top=2)
    design = best_settable(Sought(None, search.problem, search, outcome))[1]  # type: ignore[arg-type]
    return design, [note.code for note in design.warnings]


def test_hardware_whose_lamps_may_lean_is_taken_before_better_that_may_not() -> None:
    design, codes = recommended(0.0, (NARROW, FLOOD))
    assert design.hardware["light"]["id"] == "narrow" and "tilt_reserve" not in codes
    design, codes = recommended(FAR_OFF_DEG, (NARROW, FLOOD))
    assert design.hardware["light"]["id"] == "flood"
    assert "better_unsettable" in codes and "tilt_reserve" not in codes


def test_where_no_lamps_may_lean_the_best_is_told_with_a_warning() -> None:
    design, codes = recommended(FAR_OFF_DEG, (NARROW,))
    assert design.hardware["light"]["id"] == "narrow" and design.is_settable
    assert "tilt_reserve" in codes
    upright = recommended(0.0, (NARROW,))[0]
    assert design.scenes[0].settings_to_set == upright.scenes[0].settings_to_set
