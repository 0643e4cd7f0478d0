"""The continuous solvers against the closed form, each other, and derivatives from elsewhere.

The closed form (`solvers.settings.closed_form`) and the program (`solvers.continuous.program`) share the
sensor's and the lamp's formulas only: windows, f-number ranges and levels are nowhere in the program. Solvers are
compared by objective and feasibility, never by settings, which need not be unique.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
from hand_made_rows import FADING, FLASHES, STEPS, scene
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from thorough import drawn

from uwopt.errors import SolverError
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.continuous.optimality import derivatives
from uwopt.solvers.continuous.pieces import SmoothDesign, SmoothScene, smooth_pieces
from uwopt.solvers.continuous.program import Program, names_of_rules
from uwopt.solvers.continuous.solve_settings import Method, Verdict, solve_settings
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.question import Question

METHODS: tuple[Method, ...] = ("casadi", "slsqp", "cobyla", "global")  # those that settle what they are given
AGREE = 1e-4  # what a second opinion is asked for; the solvers reach about 1e-9
CAMERA_W, COST, MASS_KG, GSD_MM = 3.0, 5.0, 1.0, 2.0
POWER, SNR, SUM = Objective.of("power"), Objective.of("snr_db"), Objective.of({"power": 1.0, "snr_db": 2.0})


ALTITUDES: dict[str, Any] = dict(signal_e=[150.0, 100.0, 60.0], nominal=1, min_snr=20.0)

TABLE: dict[str, list[SceneRows]] = {
    "burning lamp that dims": [scene()],
    "least level above the need, so that the aperture closes": [scene(min_level=0.3, signal_e=[3000.0])],
    "pulsed LED": [scene(kind=PULSED, max_level=0.8)],
    "flash of three steps": [scene(signal_e=[30.0], **FLASHES)],
    "flash far too bright": [scene(signal_e=[600.0], well_e=4000.0, **FLASHES)],
    "lamp that is only on": [scene(dims_freely=False, levels=[1.0])],
    "mean level asked for, dark current counted": [
        scene(mean_level=0.3, black_level_dn=60.0, dark_current_e_s=5.0, exposure_offset_s=1e-5)
    ],
    "band of altitudes": [scene(**ALTITUDES)],
    "band of altitudes with a mean level": [scene(mean_level=0.3, **ALTITUDES)],
    "darkest pixel": [scene(worst_e=[20.0])],
    "two scenes, one aperture": [scene(), scene(signal_e=[25.0], min_level=0.1, min_snr=20.0)],
    "two scenes with steps": [scene(signal_e=[2000.0], **STEPS), scene(signal_e=[300.0], **STEPS)],
    "full well just above the need": [scene(well_e=300.0, min_snr=13.9, gain_dn_per_e=3.0)],
    "no gain to turn": [scene(max_gain=1.0, gain_dn_per_e=0.02)],
    "eight bits": [scene(full_scale_dn=255.0, gain_dn_per_e=0.023, min_snr=30.0)],
    "one aperture only": [scene(n_low=4.0, n_high=4.0)],
    "pixels that differ": [scene(prnu_frac=0.01)],
    "red that needs more than the mean": [
        replace(scene(), colour_e=np.array([[[20.0]]]), red_veil_e=np.array([[5.0]]), min_snr_red=20.0)
    ],
    "mean that needs more than the darkest pixel": [replace(scene(worst_e=[90.0]), min_snr_mean=20.0)],
    "vehicle at rest": [scene(time_max_s=0.2, rate_hz=0.01, kind=PULSED)],
}


def closed_form(
    rows: list[SceneRows], objective: Objective, *, motorised: bool = False, limit_w: float = np.inf
) -> float | None:
    """The exact search's value for one design; None when it finds it infeasible."""
    best = best_settings(Question.of(rows, np.array([motorised]), objective, np.array([CAMERA_W]), limit_w))
    chosen, feasible, snr_db = best.chosen, best.feasible, best.snr_db
    power = CAMERA_W + np.max([c.light_power_w for c in chosen], axis=0)
    if not feasible[0] or power[0] > limit_w * (1 + 1e-9):
        return None
    constants = (np.array([COST]), np.array([MASS_KG]))
    return float(objective.cost_to_minimise(Terms(power, *constants, snr_db, np.array([GSD_MM])))[0])


def solved(
    rows: list[SceneRows],
    objective: Objective = POWER,
    *,
    method: Any = "casadi",
    motorised: bool = False,
    limit_w: float = np.inf,
    **more: Any,
) -> Verdict:
    """The continuous answer for the same design."""
    return solve_settings(
        SmoothDesign.of(
            rows, motorised=motorised, camera_power_w=CAMERA_W, cost=COST, mass_kg=MASS_KG, gsd_mm=GSD_MM
        ),
        objective=objective, power_limit_w=limit_w, method=method, **more,
    )  # fmt: skip


# ---------------------------------------------------------------- agreement


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", TABLE)
def test_least_power_agrees_with_the_closed_form(name: str, method: str) -> None:
    found = solved(TABLE[name], method=method)
    assert found.status == "optimal", found
    assert found.objective_value == pytest.approx(closed_form(TABLE[name], POWER), rel=AGREE)


@pytest.mark.parametrize("method", ["casadi", "slsqp"])
def test_a_flash_that_fades_agrees_with_the_search(method: str) -> None:
    """Its level is least where dark electrons begin to outrun its light."""
    rows = [scene(**{**FADING, "light_lm": 1e5, "dark_current_e_s": 1e5, "min_level": 0.05, "min_snr": 20.0})]
    found = solved(rows, method=method)
    assert found.status == "optimal", found
    assert found.settings[0].time_s < 0.98e-3  # of 0.99 ms: it is cut
    assert found.objective_value == pytest.approx(closed_form(rows, POWER), rel=AGREE)


# With steps the highest SNR has its own test below.
SMOOTH = [name for name in TABLE if "step" not in name and name != "flash far too bright"]


ASKED = ((SNR, "casadi"), (SUM, "slsqp"), (SNR, "slsqp"), (SUM, "casadi"))


@pytest.mark.parametrize(("name", "objective", "method"), [
    (name, *asked) for place, name in enumerate(SMOOTH) for asked in drawn(ASKED[place % 2 : place % 2 + 1], ASKED)
], ids=str)  # fmt: skip
def test_snr_and_sums_agree_with_the_closed_form(name: str, objective: Objective, method: str) -> None:
    found = solved(TABLE[name], objective, method=method)
    assert found.status == "optimal", found
    assert found.objective_value == pytest.approx(closed_form(TABLE[name], objective), rel=AGREE)


@pytest.mark.parametrize("method", ["cobyla", "global"])
@pytest.mark.parametrize(
    ("name", "objective"),
    [("burning lamp that dims", SNR), ("no gain to turn", SUM), ("two scenes, one aperture", SNR)],
)
def test_snr_and_sums_without_gradients_agree(name: str, objective: Objective, method: str) -> None:
    found = solved(TABLE[name], objective, method=method)
    assert found.objective_value == pytest.approx(closed_form(TABLE[name], objective), rel=AGREE)


@pytest.mark.parametrize("method", ["casadi", "slsqp"])
@pytest.mark.parametrize("motorised", [False, True])
def test_power_limit_caps_the_snr(method: str, motorised: bool) -> None:
    rows = TABLE["two scenes, one aperture"]
    value = closed_form(rows, SNR, motorised=motorised, limit_w=150.0)
    found = solved(rows, SNR, method=method, motorised=motorised, limit_w=150.0)
    assert found.objective_value == pytest.approx(value, rel=AGREE)
    assert found.light_power_w <= (150.0 - CAMERA_W) * (1 + 1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_brighter_step_behind_a_smaller_aperture_gives_more_snr(method: str) -> None:
    # At F2 the half step saturates within the shortest flash, and the quarter step stays below full scale;
    # stopped down, the half step fills it: 1.5 K mu = 255 gives mu = 2355.4 e at K = 0.072175, by hand
    # SNR = 2355.4 / sqrt(18.874^2 + 1/(12 K^2) + 2355.4) = 45.09, 33.08 dB.
    rows = scene(
        signal_e=[2010.07], read_noise_e=18.874, gain_dn_per_e=0.072175, full_scale_dn=255.0, max_gain=1.0,
        well_e=np.inf, kind=FLASH, light_lm=289781.0, pulse_energy_j=29.0, rate_hz=1.0, time_min_s=4.504e-5,
        time_max_s=7.947e-5, n_low=2.2, n_high=4.4, working_factor=1.045, min_snr=3.0, **STEPS,
    )  # fmt: skip
    found = solved([rows], SNR, method=method)
    electrons = 255.0 / 1.5 / 0.072175
    variance = 18.874**2 + 1.0 / 12.0 / 0.072175**2 + electrons
    assert found.objective_value == pytest.approx(-20.0 * np.log10(electrons / np.sqrt(variance)), rel=1e-6)
    assert found.settings[0].level == 0.5


LOGS = dict(
    signal_e=st.floats(2.0, 9.0), read_noise_e=st.floats(0.0, 3.0), gain_dn_per_e=st.floats(-4.0, 0.7),
    max_gain=st.floats(0.0, 4.0), well_e=st.floats(6.5, 10.5), time_max_s=st.floats(-9.0, -3.0),
)  # fmt: skip


@settings(
    max_examples=drawn(20, 200), deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True
)
@given(
    logs=st.fixed_dictionaries(LOGS),
    far=st.floats(0.5, 1.0),
    kind=st.sampled_from([CONTINUOUS, PULSED, FLASH]),
    lamp=st.sampled_from([dict(min_level=0.0), dict(min_level=0.2), STEPS]),
    mean_level=st.sampled_from([None, 0.3]),
    min_snr=st.floats(2.0, 25.0),
    second=st.floats(0.3, 3.0),
    motorised=st.booleans(),
)
def test_any_design_agrees_with_the_closed_form(
    logs: dict[str, float], far: float, kind: int, lamp: dict[str, Any], mean_level: float | None, min_snr: float,
    second: float, motorised: bool,
) -> None:  # fmt: skip
    values: dict[str, Any] = {name: float(np.exp(value)) for name, value in logs.items()}
    signal = values.pop("signal_e") * np.array([1.0, 0.5 * (1.0 + far), far])
    values.update(lamp, kind=kind, mean_level=mean_level, min_snr=min_snr, pulse_energy_j=2.0, nominal=1)
    rows = [scene(signal_e=list(signal), **values), scene(signal_e=list(second * signal), **values)]
    value = closed_form(rows, POWER, motorised=motorised)
    for method in ("casadi", "slsqp"):
        found = solved(rows, method=method, motorised=motorised)
        if value is None:
            assert found.status in ("infeasible", "failed"), found
        else:
            assert found.status == "optimal", found
            assert found.objective_value == pytest.approx(value, rel=AGREE)


# ---------------------------------------------------------------- honesty

IMPOSSIBLE: dict[str, tuple[list[SceneRows], float]] = {
    "too dark": ([scene(signal_e=[1e-3])], np.inf),
    "always saturated": ([scene(signal_e=[1e9], min_level=0.5)], np.inf),
    "too little power": ([scene(signal_e=[25.0], min_snr=20.0)], CAMERA_W + 1.0),
    "full well below the need": ([scene(well_e=150.0)], np.inf),
    "mean level that hides the signal": ([scene(mean_level=0.3, min_snr=300.0)], np.inf),
    "apertures that do not meet": ([scene(n_low=8.0), scene(n_high=4.0)], np.inf),
    "bright scene and dark scene, one aperture": (
        [scene(signal_e=[30000.0], min_level=0.5, time_min_s=1e-3), scene(signal_e=[5.0])], np.inf
    ),
    "no step of the flash fits both": (
        [scene(signal_e=[9000.0], well_e=400.0, **FLASHES), scene(signal_e=[1.0], n_high=2.0, **FLASHES)], np.inf
    ),
    "light that may not be used": ([scene(time_max_s=-1.0)], np.inf),
}  # fmt: skip


SLOW_TO_TELL = ["full well below the need", "bright scene and dark scene, one aperture"]


@pytest.mark.parametrize(
    ("name", "method"),
    [(n, m) for n in IMPOSSIBLE for m in METHODS if n not in SLOW_TO_TELL or m in ("casadi", "slsqp")],
)
def test_what_cannot_be_met_is_never_called_solved(name: str, method: str) -> None:
    rows, limit_w = IMPOSSIBLE[name]
    assert closed_form(rows, POWER, limit_w=limit_w) is None
    found = solved(rows, method=method, limit_w=limit_w)
    assert found.status in ("infeasible", "failed"), found


def test_interior_point_proves_the_infeasible_cases() -> None:
    assert {solved(rows, limit_w=limit).status for rows, limit in IMPOSSIBLE.values()} == {"infeasible"}


def test_settings_returned_meet_the_rules_when_computed_by_hand() -> None:
    rows = scene(**ALTITUDES)
    found = solved([rows])
    (at,) = found.settings
    light = 20000.0 * at.level * at.time_s / (at.f_number * 1.02) ** 2
    electrons = np.array(ALTITUDES["signal_e"]) * light
    gain = 0.37 * at.gain
    snr = electrons / np.sqrt(2.3**2 + 1.0 / 12.0 / gain**2 + electrons)
    # IPOPT meets its rules to 1e-9 or better.
    assert snr.min() >= 20.0 * (1 - 1e-7)
    assert 1.5 * gain * electrons.max() <= 4095.0 * (1 + 1e-7)


def test_multiplier_says_what_more_snr_costs() -> None:
    # 0.1 % more SNR, solved again: the difference quotient meets the multiplier to its second-order term.
    base, more = solved([scene()]), solved([scene(min_snr=10.01)])
    assert base.objective_value is not None and more.objective_value is not None
    slope = (more.objective_value - base.objective_value) / np.log(1.001)
    assert base.multipliers["min_snr[0]"] == pytest.approx(slope, rel=2e-3)
    assert base.kkt_residual is not None and base.kkt_residual < 1e-8


def test_solver_stopped_early_does_not_claim_an_optimum(monkeypatch: pytest.MonkeyPatch) -> None:
    from uwopt.solvers.continuous import nlopt_algorithms as nlopt_solvers

    monkeypatch.setitem(nlopt_solvers.WAYS, "cobyla", replace(nlopt_solvers.WAYS["cobyla"], most_in_all=5))
    assert solved([scene()], method="cobyla").status in ("feasible", "failed")


@pytest.mark.parametrize("method", METHODS)
def test_time_limit_ends_the_search_with_an_honest_status(method: str) -> None:
    found = solved(TABLE["two scenes with steps"], method=method, max_seconds=0.0)
    value = closed_form(TABLE["two scenes with steps"], POWER)
    assert found.status != "infeasible"
    assert found.status != "optimal" or found.objective_value == pytest.approx(value, rel=AGREE)


def test_point_that_misses_the_optimum_is_not_called_optimal(monkeypatch: pytest.MonkeyPatch) -> None:
    from uwopt.solvers.continuous import casadi_ipopt

    honest = casadi_ipopt.solve_by_ipopt

    def early(program: Program, start: Any, *, max_seconds: float = np.inf) -> Any:
        found = honest(program, start, max_seconds=max_seconds)
        return replace(found, x=0.5 * (found.x + program.middle()), kkt_residual=1.0)

    monkeypatch.setattr(casadi_ipopt, "solve_by_ipopt", early)
    assert solved([scene()]).status in ("feasible", "failed")


def test_bounds_and_tables_are_refused() -> None:
    with pytest.raises(SolverError, match="one design at a time"):
        solved([replace(scene(), optimistic=True)])
    with pytest.raises(SolverError, match="not one of casadi"):
        solved([scene()], method="guess")


# ---------------------------------------------------------------- derivatives


def one_program(rows: SceneRows, objective: Objective) -> Program:
    """The program of a design of one scene and one piece."""
    view = SmoothScene.of(rows)
    goal: Any = "sum" if objective is SUM else "snr"
    return Program((view,), (smooth_pieces(view)[0],), False, goal, 1.0, 2.0, np.inf)


@pytest.mark.parametrize("log_point", [(0.4, -6.0, -1.0, 0.5), (1.9, -9.0, -3.0, 2.0)])
def test_casadi_differentiates_the_snr_like_mpmath(log_point: tuple[float, ...]) -> None:
    from uwopt.solvers.continuous.casadi_ipopt import SymbolicProgram

    rows = scene(prnu_frac=0.01, dark_current_e_s=20.0, exposure_offset_s=1e-5)

    def log_snr(f_number: Any, time_s: Any, level: Any, gain: Any) -> Any:
        """Equation (7) in 50 digits, with PRNU; dark current over time minus offset."""
        electrons = 100 * 20000 * mpmath.exp(level + time_s - 2 * f_number) / mpmath.mpf("1.02") ** 2
        dark = 20 * (mpmath.exp(time_s) - mpmath.mpf("1e-5"))
        quantised = (mpmath.mpf("0.37") * mpmath.exp(gain)) ** -2 / 12
        noise = mpmath.mpf("2.3") ** 2 + quantised + dark + electrons + (electrons / 100) ** 2
        return mpmath.log(electrons / mpmath.sqrt(noise))

    program = one_program(rows, SNR)
    assert program.names == ("f_number", "time_s[0]", "level[0]", "gain[0]", "snr")
    x = np.array([*log_point, 0.0])
    found = SymbolicProgram(program).derivatives(x)
    row = names_of_rules(program)[0].index("snr[0]")  # snr - ln SNR(settings) <= 0
    with mpmath.workdps(50):
        wanted = [
            float(mpmath.diff(log_snr, log_point, tuple(int(i == k) for i in range(4)))) for k in range(4)
        ]
        value = float(log_snr(*log_point))
    assert -found.values[row] == pytest.approx(value, abs=1e-12)
    # Rounding of doubles only: both are exact derivatives.
    np.testing.assert_allclose(-found.jacobian[row, :4], wanted, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ["pulsed LED", "band of altitudes with a mean level", "pixels that differ"])
def test_casadi_and_complex_steps_agree_on_every_rule(name: str) -> None:
    from uwopt.solvers.continuous.casadi_ipopt import SymbolicProgram

    program = one_program(TABLE[name][0], SUM)
    low, high = program.bounds
    for share in (0.3, 0.6, 0.9):
        x = low + share * (high - low)
        ours, theirs = derivatives(program, x), SymbolicProgram(program).derivatives(x)
        np.testing.assert_allclose(ours.values, theirs.values, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(ours.jacobian, theirs.jacobian, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(ours.gradient, theirs.gradient, rtol=1e-9, atol=1e-12)


# ---------------------------------------------------------------- manners


def test_solvers_are_loaded_when_first_asked_for() -> None:
    code = "import sys, uwopt.solvers.continuous; print({'casadi', 'nlopt'} & set(sys.modules))"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "set()"


@pytest.mark.parametrize("method", METHODS)
def test_solvers_print_nothing(method: str, capfd: pytest.CaptureFixture[str]) -> None:
    solved([scene()], method=method)
    solved(IMPOSSIBLE["full well below the need"][0], method=method)
    assert capfd.readouterr() == ("", "")
