"""NLopt's algorithms one by one: each comes to the certified value, or says honestly that it did not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hand_made_rows import FLASHES, STEPS, scene
from thorough import drawn

from uwopt.bench.nlopt_peers import OTHERS, Reduced
from uwopt.bench.peers import OF_NLOPT
from uwopt.forward.part_columns import CONTINUOUS, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.continuous import nlopt_algorithms
from uwopt.solvers.continuous.pieces import SmoothDesign, SmoothScene, smooth_pieces
from uwopt.solvers.continuous.program import Program, names_of_rules
from uwopt.solvers.continuous.solve_settings import FEASIBLE, Verdict, solve_settings
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.question import Question

AGREE = 1e-4
CAMERA_W, COST, MASS_KG, GSD_MM = 3.0, 5.0, 1.0, 2.0
POWER, SNR = Objective.of("power"), Objective.of("snr_db")
PATIENCE = drawn(20, 200)  # evaluations for each unknown; an algorithm that needs more has to say so
PATIENCE_S = {"ccsaq": 0.05, "direct_l": 0.05}  # of those that look at the number seldom
#: These settle smooth convex programs; the others are there to be compared with.
LOCAL = ("slsqp", "mma", "lbfgs", "cobyla")

ROWS: dict[str, list[SceneRows]] = {
    "burning lamp that dims": [scene()],
    "pulsed LED": [scene(kind=PULSED, max_level=0.8)],
    "flash of three steps": [scene(signal_e=[30.0], **FLASHES)],
    "mean level": [scene(mean_level=0.3, black_level_dn=60.0, dark_current_e_s=5.0, exposure_offset_s=1e-5)],
    "mean level without gain": [scene(mean_level=0.3, max_gain=1.0, min_snr=5.0)],
    "two scenes with a mean level": [scene(mean_level=0.3), scene(signal_e=[60.0], mean_level=0.3)],
}


def random_rows(seed: int) -> list[SceneRows]:
    """A design at random, as `test_continuous` draws them."""
    rng = np.random.default_rng(seed)
    ranges = dict(
        signal_e=(2.0, 9.0), read_noise_e=(0.0, 3.0), gain_dn_per_e=(-4.0, 0.7), max_gain=(0.0, 4.0),
        well_e=(6.5, 10.5), time_max_s=(-9.0, -3.0),
    )  # fmt: skip
    values: dict[str, Any] = {name: float(np.exp(rng.uniform(*ends))) for name, ends in ranges.items()}
    signal = values.pop("signal_e") * np.array([1.0, 0.8, 0.6])
    lamp = [dict(min_level=0.0), dict(min_level=0.2), STEPS][int(rng.integers(3))]
    kind = [CONTINUOUS, PULSED][int(rng.integers(2))]
    mean_level = [None, 0.3][int(rng.integers(2))]
    values.update(lamp, kind=kind, mean_level=mean_level, min_snr=float(rng.uniform(2.0, 25.0)), nominal=1)
    return [scene(signal_e=list(signal), **values)]


def closed_form(rows: list[SceneRows], objective: Objective) -> float | None:
    """The exact search's value for one design; None when it finds it infeasible."""
    best = best_settings(Question.of(rows, np.array([False]), objective, np.array([CAMERA_W]), np.inf))
    if not best.feasible[0]:
        return None
    power = CAMERA_W + np.max([c.light_power_w for c in best.chosen], axis=0)
    terms = Terms(power, np.array([COST]), np.array([MASS_KG]), best.snr_db, np.array([GSD_MM]))
    return float(objective.cost_to_minimise(terms)[0])


def solved(
    rows: list[SceneRows], objective: Objective, method: Any, *, max_seconds: float = np.inf
) -> Verdict:
    return solve_settings(
        SmoothDesign.of(
            rows, motorised=False, camera_power_w=CAMERA_W, cost=COST, mass_kg=MASS_KG, gsd_mm=GSD_MM
        ),
        objective=objective, power_limit_w=np.inf, method=OTHERS.get(method, method), max_seconds=max_seconds,
    )  # fmt: skip


def assert_honest(found: Verdict, value: float | None) -> None:
    """An optimum is one, feasible is feasible, and nobody is better than the certificate."""
    if found.status == "optimal":
        assert value is not None and found.objective_value == pytest.approx(value, rel=AGREE), found
    if found.status in ("optimal", "feasible"):
        assert found.max_violation is not None and found.max_violation <= FEASIBLE, found
        assert value is not None and found.objective_value is not None
        # rules met to 1e-6 buy as much of the value, or a few times of it where several meet
        assert found.objective_value >= value - 2e-5 * abs(value), found
    if found.status == "infeasible":
        assert value is None, found


@pytest.fixture
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few evaluations for all that would go on for long."""
    for ways in (nlopt_algorithms.WAYS, OTHERS):
        for name, how in ways.items():
            monkeypatch.setitem(ways, name, replace(how, most=min(how.most, PATIENCE)))


@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize("method", OF_NLOPT)
@pytest.mark.parametrize("name", ROWS)
def test_each_algorithm_is_right_or_honest(name: str, method: str) -> None:
    value = closed_form(ROWS[name], POWER)
    found = solved(ROWS[name], POWER, method, max_seconds=PATIENCE_S.get(method, np.inf))
    assert_honest(found, value)
    if method in ("slsqp", "cobyla"):  # they settle soon
        assert found.status == "optimal", found


@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize("method", OF_NLOPT)
def test_each_algorithm_is_right_or_honest_on_random_designs(method: str) -> None:
    for seed in range(drawn(2, 5)):
        for objective in (POWER, SNR):
            rows = random_rows(seed)
            found = solved(rows, objective, method, max_seconds=PATIENCE_S.get(method, np.inf))
            assert_honest(found, closed_form(rows, objective))


@pytest.mark.parametrize("method", LOCAL)
def test_local_algorithms_find_the_least_power(method: str) -> None:
    found = solved(ROWS["burning lamp that dims"], POWER, method)
    assert found.objective_value == pytest.approx(
        closed_form(ROWS["burning lamp that dims"], POWER), rel=AGREE
    )


@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize("method", drawn(["direct_l", "mlsl"], ["isres", "ags", "direct_l", "mlsl"]))
def test_global_algorithms_find_settings_that_hold(method: str) -> None:
    found = solved(ROWS["burning lamp that dims"], POWER, method)
    assert found.status in ("optimal", "feasible"), found


def program_of(rows: list[SceneRows]) -> Program:
    scenes = tuple(SmoothScene.of(row) for row in rows)
    return Program(scenes, tuple(smooth_pieces(s)[0] for s in scenes), False, "power", 1.0, 0.0, np.inf)


@pytest.mark.parametrize("worst_scene", [True, False])
def test_program_without_equalities_holds_the_mean_level_at_every_point(worst_scene: bool) -> None:
    program = program_of(ROWS["two scenes with a mean level"])
    reduced = Reduced(program, worst_scene=worst_scene)
    assert set(reduced.solved.values()) == {"gain[0]", "gain[1]"} and not set(reduced.solved.values()) & set(
        reduced.names
    )
    low, high = reduced.bounds
    for share in (0.3, 0.5, 0.7):
        x = low + share * (high - low)
        full = reduced._expanded(list(x))
        assert np.allclose([*program.rules(full).equalities.values()], 0.0, atol=1e-12)
        assert reduced.rules(list(x)).equalities == {}


def test_mean_level_without_gain_is_solved_for_the_light_level() -> None:
    reduced = Reduced(program_of(ROWS["mean level without gain"]), worst_scene=True)
    assert reduced.solved == {0: "level[0]"}


def test_mean_level_that_nothing_free_determines_becomes_a_pair() -> None:
    rows = scene(mean_level=0.3, max_gain=1.0, min_snr=5.0, dims_freely=False, levels=[1.0])
    reduced = Reduced(program_of([rows]), worst_scene=True)
    assert reduced.solved == {} and len(reduced.paired) == 1
    names, none = names_of_rules(reduced)
    assert not none and {f"{reduced.paired[0]} {side}" for side in ("above", "below")} <= set(names)
