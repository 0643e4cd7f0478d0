"""Settings that a mission fixes: the search chooses the rest, as well as anybody can by trying."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from thorough import drawn

import uwopt
from uwopt.api.evaluating import evaluate
from uwopt.errors import MissionError
from uwopt.evaluation.design_model import design_model
from uwopt.forward.assembly import system_problem
from uwopt.forward.figures import SettingRows
from uwopt.mission.system import load_system

#: A lamp that burns and dims freely, so that every setting is free; light is wanted, and a level of the image.
MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "paper",
    "scene": {"water": "I", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 1.5, "speed_m_s": 0.1, "orientation": "portrait", "light_count": 1},
    "requirements": {"overlap": 0.3, "max_blur_px": 2.0, "min_snr_db": 22},
    "catalog": {"cameras": ["avt-alvium-1800-c-040m"], "lenses": ["computar-m1214-mp2"],
                "ports": ["blue-robotics-4-in"], "lights": ["blue-robotics-lumen-r2"]},
}  # fmt: skip
LEVELLED = {**MISSION, "requirements": {**MISSION["requirements"], "mean_level": 0.2}}
ONE_BY_ONE = ({"f_number": 2.5}, {"exposure_ms": 1.3}, {"gain": 3.0}, {"dim_frac": 0.4})


def with_fixed(mission: dict[str, Any], fixed: dict[str, float]) -> dict[str, Any]:
    return {**mission, "fixed": fixed}


def best(mission: dict[str, Any]) -> Any:
    made = uwopt.solve(mission, quick=True)
    assert made.best is not None and made.certificate is not None and made.certificate.gap_rel == pytest.approx(0.0)
    return made.best


def unset(system: dict[str, Any]) -> dict[str, Any]:
    return {key: part for key, part in system.items() if key not in ("settings", "scenes")}


def tried(mission: dict[str, Any], design: Any, fixed: dict[str, float], goal: str, count: int = 20_000) -> float:
    """The best of many random settings of a design's hardware by the rules of the evaluation."""
    loaded = uwopt.load_mission(mission)
    problem, hardware = system_problem(loaded, load_system(design.as_system()))
    model, chance = design_model(problem, hardware), np.random.default_rng(5)

    def spread(name: str, low: float, high: float, scale: float = 1.0) -> np.ndarray:
        if name in fixed:
            return np.full(count, fixed[name] * scale)
        beyond = 0.3 * np.log(high / low)  # many at either end
        drawn_from = chance.uniform(np.log(low) - beyond, np.log(high) + beyond, count)
        return np.asarray(np.clip(np.exp(drawn_from), low, high))

    own = design.scenes[0].settings
    rows = SettingRows(
        spread("f_number", 1.4, 16), spread("exposure_ms", 1e-4, 0.02, 1e-3), np.full(count, np.inf),
        spread("gain", 1, 100), spread("dim_frac", 1e-3, 1), np.full(count, own["frame_rate_hz"]),
        np.full(count, model.searched_dioptre_per_m(0)),
    )  # fmt: skip
    figures = model.figures(0, rows)
    held = np.logical_and.reduce([m.satisfied for m in model.margins(0, rows, figures, level_tolerance_rel=0.05)])
    assert held.sum() > 20  # it is a trial
    value = model.totals(figures)["power_w"] if goal == "power" else -figures.snr[:, 0]
    return float(np.min(np.where(held, np.broadcast_to(value, (count,)), np.inf)))


@pytest.mark.parametrize("goal", ["power", "snr_db"])
@pytest.mark.parametrize("fixed", [*ONE_BY_ONE, {"f_number": 2.5, "gain": 70.0}], ids=str)
def test_nothing_that_is_tried_is_better_than_what_is_found(fixed: dict[str, float], goal: str) -> None:
    mission = with_fixed(MISSION, fixed) | {"objective": goal}
    design = best(mission)
    assert design.scenes[0].settings_to_set
    assert design.scenes[0].settings.items() >= {name: pytest.approx(v) for name, v in fixed.items()}.items()
    assert design.scenes[0].settings_to_set.items() >= {n: pytest.approx(v) for n, v in fixed.items()}.items()
    assert design.feasible
    value = design.objective_value if goal == "power" else -(10 ** (design.objective_value / 20))
    least = tried(mission, design, fixed, goal)
    assert value <= least + 1e-9 * abs(least)
    assert value == pytest.approx(least, rel=0.1)  # twenty thousand come near


@pytest.mark.parametrize(
    ("fixed", "holds"),
    [({"f_number": 1.4, "exposure_ms": 12.0, "gain": 20.0, "dim_frac": 0.06}, True),
     ({"f_number": 1.4, "exposure_ms": 12.0, "gain": 74.0, "dim_frac": 1.0}, False),  # saturated, unless any is less
     ({"f_number": 8.0, "exposure_ms": 1.0, "gain": 1.0, "dim_frac": 0.1}, False)],  # dark, unless any is more
)  # fmt: skip
def test_what_is_fixed_altogether_is_what_evaluate_says(fixed: dict[str, float], holds: bool) -> None:
    made = uwopt.solve(with_fixed(MISSION, fixed), quick=True).best
    system = unset(best(MISSION).as_system()) | {"settings": fixed}
    stated = evaluate(MISSION, system).design
    assert stated is not None and stated.feasible is holds
    assert (made is not None) is holds
    assert made is None or made.objective_value == pytest.approx(stated.objective_value, rel=1e-9)


@pytest.mark.parametrize("mission", [MISSION, LEVELLED], ids=["free", "levelled"])
@pytest.mark.parametrize("physics", drawn(["paper"], ["paper", "full"]))
def test_what_is_best_stays_best_when_it_is_fixed(mission: dict[str, Any], physics: str) -> None:
    free = best(mission | {"physics": physics})
    own = free.scenes[0].settings
    for name in ("f_number", "gain", "dim_frac"):
        again = best(with_fixed(mission, {name: own[name]}) | {"physics": physics})
        assert again.objective_value == pytest.approx(free.objective_value, rel=1e-6)
    for fixed in ONE_BY_ONE:
        made = uwopt.solve(with_fixed(mission, fixed) | {"physics": physics}, quick=True).best
        assert made is None or made.objective_value >= free.objective_value * (1 - 1e-9)


def test_parts_that_cannot_be_set_so_are_left_out() -> None:
    fixed = {"f_number": 1.0, "exposure_ms": 1e5, "gain": 1e5, "dim_frac": 0.5}
    other = {**MISSION["catalog"], "lights": ["blue-robotics-lumen-r2", "arctic-rays-dragonfish-mini-strobe-65deg"]}
    for name, value in fixed.items():
        made = uwopt.solve({**MISSION, "catalog": other, "fixed": {name: value}}, quick=True)
        assert (made.best is None) is (name != "dim_frac")
        if name == "dim_frac":
            assert made.best is not None and made.best.hardware.parts["light"].id == "blue-robotics-lumen-r2"
        rules = {each.rule for each in made.certificate.discarded} if made.certificate else set()
        assert any("setting" in rule for rule in rules)


def test_a_system_that_is_set_otherwise_misses_it() -> None:
    free = best(MISSION)
    system = free.as_system()
    for name, value in {"f_number": 2.5, "exposure_ms": 0.9, "gain": 2.0, "dim_frac": 0.7}.items():
        mission = with_fixed(MISSION, {name: value})
        design = evaluate(mission, system).design
        assert design is not None
        held = {m.requirement: m.satisfied for m in design.scenes[0].margins if m.requirement.startswith("fixed")}
        assert held == {f"fixed_{name}": False}
        left = evaluate(mission, unset(system)).design  # settings that are left out stand as fixed
        assert left is not None
        assert left.scenes[0].settings[name] == pytest.approx(value)


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [("exposure_ms", 0.86251, "whole number of microseconds"), ("gain", 0.5, "below 1"), ("dim_frac", 1.5, "above 1")],
)
def test_settings_that_nothing_has_are_refused(name: str, value: float, why: str) -> None:
    with pytest.raises(MissionError, match=why):
        uwopt.load_mission(with_fixed(MISSION, {name: value}))
