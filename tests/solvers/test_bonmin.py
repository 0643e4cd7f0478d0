"""Bonmin against the closed form and the exact search: the choice of hardware, steps of light and settings together.

What it returns is checked in the rules' own terms and by the forward model; what it says of itself counts for
nothing. It is exact in theory where rules are convex, so agreement is expected on small catalogues, and a
point that misses the optimum must not be called one.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import random_cases as rc
from hand_made_rows import STEPS, scene
from thorough import drawn

import uwopt
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import Objective, Terms
from uwopt.results.basis import Opinion
from uwopt.solvers.continuous import casadi_ipopt, opinions
from uwopt.solvers.continuous.casadi_ipopt import solve_mixed
from uwopt.solvers.continuous.mixed import MixedProgram, Picked
from uwopt.solvers.continuous.pieces import SmoothDesign
from uwopt.solvers.recommend import Sought
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.question import Question

AGREE = 1e-4
GENEROUS_S = 1e6  # the clock ends none of these
COST, MASS_KG, GSD_MM = 5.0, 1.0, 2.0
#: One hardware each: rows by scene and the camera's power.
HARDWARE: dict[str, tuple[list[SceneRows], float]] = {
    "dims": ([scene()], 3.0),
    "dims, dark": ([scene(signal_e=[40.0])], 2.5),
    "steps": ([scene(signal_e=[300.0], **STEPS)], 4.0),
    "too dark": ([scene(signal_e=[1e-3])], 1.0),
    "mean level": ([scene(mean_level=0.3, black_level_dn=60.0)], 2.0),
}
OBJECTIVES = ["power", "snr_db", {"power": 1.0, "snr_db": 2.0}, "cost"]


def candidate(rows: list[SceneRows], camera_power_w: float, *, motorised: bool = False) -> SmoothDesign:
    return SmoothDesign.of(
        rows, motorised=motorised, camera_power_w=camera_power_w, cost=COST + camera_power_w, mass_kg=MASS_KG,
        gsd_mm=GSD_MM,
    )  # fmt: skip


def closed_value(rows: list[SceneRows], camera_power_w: float, objective: Objective, limit_w: float) -> float:
    """The best value of one hardware in closed form; inf where it has none."""
    best = best_settings(Question.of(rows, np.array([False]), objective, np.array([camera_power_w]), limit_w))
    power = camera_power_w + np.max([c.light_power_w for c in best.chosen], axis=0)
    if not best.feasible[0] or power[0] > limit_w * (1 + 1e-9):
        return np.inf
    terms = Terms(
        power, np.array([COST + camera_power_w]), np.array([MASS_KG]), best.snr_db, np.array([GSD_MM])
    )
    return float(objective.cost_to_minimise(terms)[0])


def chosen(
    hardware: list[tuple[list[SceneRows], float]], objective: Objective, limit_w: float = np.inf
) -> Picked | None:
    """What Bonmin picks; None when nothing was open to choice."""
    program = MixedProgram([candidate(*one) for one in hardware], objective, limit_w)
    if not program.options:
        return None
    return program.picked(solve_mixed(program, max_seconds=GENEROUS_S).x)


@pytest.mark.parametrize(("wanted", "limit_w"), drawn(
    [*((wanted, 60.0) for wanted in OBJECTIVES[:3]), ("power", np.inf), ("cost", np.inf)],
    [*itertools.product(OBJECTIVES, (np.inf, 60.0))],
), ids=str)  # fmt: skip
def test_bonmin_chooses_what_enumeration_in_closed_form_finds_best(wanted: Any, limit_w: float) -> None:
    objective, hardware = Objective.of(wanted), list(HARDWARE.values())
    values = [closed_value(*one, objective, limit_w) for one in hardware]
    picked = chosen(hardware, objective, limit_w)
    assert picked is not None and picked.max_violation <= opinions.FEASIBLE
    assert picked.value == pytest.approx(min(values), rel=AGREE)


def test_bonmin_chooses_one_aperture_for_two_scenes() -> None:
    objective = Objective.of("power")
    pair = [scene(), scene(signal_e=[25.0], min_level=0.1, min_snr=20.0)]
    hardware = [(pair, 3.0), ([scene(signal_e=[2000.0], **STEPS), scene(signal_e=[300.0], **STEPS)], 9.0)]
    picked = chosen(hardware, objective)
    assert picked is not None
    assert picked.value == pytest.approx(
        min(closed_value(*one, objective, np.inf) for one in hardware), rel=AGREE
    )
    assert picked.settings[0].f_number == pytest.approx(picked.settings[1].f_number, rel=1e-6)


def test_hardware_that_cannot_work_is_not_open_to_choice() -> None:
    program = MixedProgram(
        [candidate(*HARDWARE["too dark"]), candidate(*HARDWARE["dims"])], Objective.of("power"), np.inf
    )
    assert program.open_to_choice == [1]
    assert chosen([HARDWARE["too dark"]], Objective.of("power")) is None


def test_a_rule_is_let_go_by_as_much_as_it_can_be_missed() -> None:
    # Big M must leave every point of the box to the options that are not taken: no rule may exceed it anywhere.
    program = MixedProgram([candidate(*one) for one in HARDWARE.values()], Objective.of("power"), 60.0)
    low, high = program.bounds
    rng = np.random.default_rng(1)
    for _ in range(50):
        x = low + rng.random(len(low)) * (high - low)
        logs = dict(zip(program.ranges, x, strict=False))
        for option, room in zip(program.options, program.room, strict=True):
            assert np.all(np.array(program.rules_of(option, logs)) <= np.array(room))


def test_bonmin_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    chosen(list(HARDWARE.values()), Objective.of("power"))
    assert capfd.readouterr() == ("", "")


def test_no_relaxation_of_bonmin_lasts_longer_than_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bonmin looks at its own limit between nodes alone: one of eight systems took 142 s where 1 s was given."""
    given: dict[str, Any] = {}

    def asked(name: str, plugin: str, problem: Any, options: dict[str, Any]) -> Any:
        given.update(options)
        raise InterruptedError

    monkeypatch.setattr(casadi_ipopt.casadi, "nlpsol", asked)
    with pytest.raises(InterruptedError):
        chosen(list(HARDWARE.values()), Objective.of("power"))
    assert given["bonmin.max_cpu_time"] == given["bonmin.time_limit"] == GENEROUS_S


# ---------------------------------------------------------------- small catalogues

#: Random cases that have designs and whose settings are a smooth program.
CASES = drawn((7, 9, 10), (3, 7, 9, 10))


@cache
def sought_of(seed: int) -> Sought:
    """A case searched, once for all tests."""
    search, outcome = rc.case(seed).solve()
    return Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]


@cache
def told_of(seed: int) -> Opinion:
    """What Bonmin says of it."""
    return opinions.mixed_opinion(sought_of(seed), max_seconds=opinions.BONMIN_S)


@pytest.mark.parametrize("seed", CASES)
def test_bonmin_agrees_with_the_exact_search_or_says_that_it_failed(seed: int) -> None:
    sought, told = sought_of(seed), told_of(seed)
    value = rc.case(seed).objective.reported(sought.outcome.best[0].minimised)
    if told["status"] == "optimal":
        assert told["objective_value"] == pytest.approx(value, rel=AGREE, abs=1e-9)
        assert told["max_violation"] <= opinions.FEASIBLE
    else:
        assert told["status"] in ("feasible", "failed", "not applicable") and not told["agrees"]
    assert "open to choice" in told["message"] or told["status"] == "not applicable"


def test_most_small_catalogues_are_confirmed() -> None:
    # Not a promise of Bonmin's, which may fail on any of them, but a check that failing is no habit.
    told = [told_of(seed)["status"] for seed in CASES]
    assert sum(status == "optimal" for status in told) >= len(CASES) / 2, told


def test_rivals_with_other_numbers_of_lamps_keep_their_own_price() -> None:
    seed = next(s for s in CASES if np.diff(sought_of(s).problem.count_range)[0] > 0)
    sought = sought_of(seed)
    search, lights = sought.search, sought.problem.lights
    for one, other in itertools.pairwise(opinions.shortlist(sought)):
        for found in (one, other):
            price = float(search.imagers.cost[found.imager]) + found.count * float(lights.price[found.light])
            mass = float(search.imagers.mass_kg[found.imager]) + found.count * float(
                lights.mass_kg[found.light]
            )
            assert (found.cost, found.mass_kg) == pytest.approx((price, mass))


def test_missions_outside_its_program_are_told_so_and_do_not_fail() -> None:
    other = SimpleNamespace(objective=Objective.of({"power": 1.0, "contrast": 1.0}))
    told = opinions.mixed_opinion(replace(sought_of(CASES[0]), search=cast(Any, other)), max_seconds=opinions.BONMIN_S)
    assert told["status"] == "not applicable" and not told["agrees"] and "not run" in told["message"]


def test_solve_tells_of_bonmin_like_of_other_opinions() -> None:
    result = uwopt.solve("problems/paper-tool-window.yaml", solver="bonmin", top=2)
    (told,) = result.solvers
    assert told["method"] == "bonmin" and len(told["hardware"]) == 4
    assert told["status"] in ("optimal", "feasible", "failed")
    assert told["agrees"] == (told["status"] == "optimal")
    assert "not of the catalogue" in told["message"] and "convex" in told["message"]
