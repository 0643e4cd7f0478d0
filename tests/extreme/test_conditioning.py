"""Solvers on designs whose numbers span twelve orders of magnitude, and derivatives in arbitrary precision.

Truth is an mpmath solution of the same design (`exact_settings`), which shares no code with `uwopt`. A method may
fail; it must not say optimal of what is not, nor infeasible of what is feasible.
"""

from __future__ import annotations

import math
from typing import Any

import exact_settings as exact
import mpmath as mp
import numpy as np
import pytest
from exact_settings import CONTINUOUS, FLASH, PULSED, Truth
from hand_made_rows import scene
from thorough import THOROUGH

from uwopt.bench.nlopt_peers import OTHERS
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import Objective
from uwopt.solvers.continuous.optimality import derivatives
from uwopt.solvers.continuous.pieces import SmoothDesign, SmoothScene, smooth_pieces
from uwopt.solvers.continuous.program import Program, names_of_rules
from uwopt.solvers.continuous.solve_settings import Verdict, solve_settings
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.question import Question

TRUE_REL = 1e-6  # of a value called optimal; the proofs ask for residuals of 1e-6 to 1e-4 in logarithms
#: Methods that settle every design below within their means; all others may only fail honestly.
SURE = ("casadi", "slsqp")
SLOW = ("global", "isres", "ags", "direct_l", "mlsl", "lbfgs", "cobyla", "mma", "ccsaq")
METHODS = sorted((*SURE, *SLOW))
POWER, SNR = Objective.of("power"), Objective.of("snr_db")


def spread(rng: np.random.Generator, low: float, high: float) -> float:
    """A number, evenly spread in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def design(rng: np.random.Generator, kind: int) -> Truth:
    """A design over twelve orders of magnitude whose lamp reaches between a thousandth and a hundred of its need."""
    min_snr, noise = spread(rng, 0.1, 1e4), float(rng.choice([0.0, spread(rng, 1e-3, 1e6)]))
    bits, prnu = (
        int(rng.choice([8, 12, 16])),
        float(rng.choice([0.0, 0.3 / min_snr if min_snr > 1 else 0.01])),
    )
    electrons = min_snr**2 + noise * min_snr
    well = electrons * spread(rng, 3.0, 1e6)
    time_s, n_low, signal = spread(rng, 1e-6, 60.0), spread(rng, 0.95, 16.0), spread(rng, 1e-6, 1e6)
    light = electrons * n_low**2 / (signal * time_s) * spread(rng, 1.5, 100.0)
    return Truth(
        kind=kind, signal_e=signal, read_noise_e=noise, gain_dn_per_e=(2.0**bits - 1) / well,
        max_gain=spread(rng, 1.0, 1e3),
        full_scale_dn=2.0**bits - 1, well_e=well, prnu_frac=prnu, highlight_ratio=1.5, min_snr=min_snr, light_lm=light,
        power_w=spread(rng, 1e-6, 1e6), rate_hz=0.5 / time_s, time_min_s=time_s if kind == FLASH else time_s * 1e-3,
        time_max_s=time_s, min_level=float(rng.choice([1e-9, 0.01])), max_level=1.0, n_low=n_low, n_high=4 * n_low,
        working_factor=1.02,
    )  # fmt: skip


def rows_of(truth: Truth) -> SceneRows:
    """The same numbers as the search sees them."""
    flash = truth.kind == FLASH
    return scene(
        kind=truth.kind, signal_e=[truth.signal_e], read_noise_e=truth.read_noise_e, gain_dn_per_e=truth.gain_dn_per_e,
        max_gain=truth.max_gain, full_scale_dn=truth.full_scale_dn, well_e=truth.well_e, prnu_frac=truth.prnu_frac,
        highlight_ratio=truth.highlight_ratio, min_snr=truth.min_snr, light_lm=truth.light_lm, rate_hz=truth.rate_hz,
        full_power_w=0.0 if flash else truth.power_w, pulse_energy_j=truth.power_w / truth.rate_hz if flash else 0.0,
        time_min_s=truth.time_min_s, time_max_s=truth.time_max_s, min_level=truth.min_level, max_level=truth.max_level,
        n_low=truth.n_low, n_high=truth.n_high, working_factor=truth.working_factor, flash_duration_s=truth.time_max_s,
        min_exposure_s=truth.time_min_s,
    )  # fmt: skip


def solved(truths: list[Truth], objective: Objective, method: Any, **more: Any) -> Verdict:
    """The answer for lights alone: a camera's power would hide theirs."""
    return solve_settings(
        SmoothDesign.of(
            [rows_of(one) for one in truths], motorised=False, camera_power_w=0.0, cost=0.0, mass_kg=0.0, gsd_mm=0.0
        ),
        objective=objective, power_limit_w=math.inf, method=OTHERS.get(method, method), **more,
    )  # fmt: skip


def assert_honest(found: Verdict, truths: list[Truth], best: Any, *, absolute: float = 0.0) -> None:
    """Settings that are called feasible are so in arbitrary precision, and none is better than the truth."""
    if found.status == "infeasible":
        assert best is None, found
        return
    if found.status == "failed":
        return
    assert best is not None, found
    for index, truth in enumerate(truths):
        own = found.settings[index]
        at = [mp.mpf(number) for number in (own.f_number, own.level, own.time_s, own.gain)]
        mu = truth.electrons(*at[:3])
        gain = mp.mpf(truth.gain_dn_per_e) * at[3]
        variance = (
            mp.mpf(truth.read_noise_e) ** 2 + 1 / (12 * gain**2) + mu + (mp.mpf(truth.prnu_frac) * mu) ** 2
        )
        assert mu / mp.sqrt(variance) >= truth.min_snr * (1 - 2e-6)  # FEASIBLE is 1e-6, relative
        assert truth.highlight_ratio * gain * mu <= truth.full_scale_dn * (1 + 2e-6)
        assert truth.highlight_ratio * mu <= truth.well_e * (1 + 2e-6)
        assert truth.n_low * (1 - 1e-9) <= at[0] <= truth.n_high * (1 + 1e-9)
        assert truth.min_level * (1 - 1e-9) <= at[1] <= truth.max_level * (1 + 1e-9)
    room = TRUE_REL * abs(best) + absolute
    assert found.objective_value is not None
    assert found.objective_value >= best - 5 * room, (found, mp.nstr(best, 12))  # rules may be missed by 1e-6
    if found.status == "optimal":
        assert found.objective_value <= best + room, (found, mp.nstr(best, 12))


def seeds_for(method: str) -> range:
    """Few designs for methods that take long."""
    return range(40) if THOROUGH else range(1) if method in SLOW else range(4)


# ---------------------------------------------------------------- claims


@pytest.mark.parametrize("kind", [CONTINUOUS, PULSED, FLASH], ids=["burning", "pulsed", "flash"])
@pytest.mark.parametrize("method", METHODS)
def test_least_power_over_twelve_orders_of_magnitude(method: str, kind: int) -> None:
    for seed in seeds_for(method):
        truth = design(np.random.default_rng(seed), kind)
        best = exact.least_power_w([truth])
        found = solved([truth], POWER, method)
        assert_honest(found, [truth], best)
        if method in SURE and best is not None:
            assert found.status == "optimal", (seed, found)


@pytest.mark.parametrize("method", METHODS)
def test_least_power_of_two_scenes_that_share_an_aperture(method: str) -> None:
    """The scenes' light differs by up to 1e6; the f-number that suits the bright one costs the dark one light."""
    for seed in seeds_for(method)[:6]:
        rng = np.random.default_rng(100 + seed)
        one = design(rng, CONTINUOUS)
        other = exact.replace(design(rng, CONTINUOUS), n_low=one.n_low, n_high=one.n_high)
        best = exact.least_power_w([one, other])
        found = solved([one, other], POWER, method)
        assert_honest(found, [one, other], best)
        if method in SURE and best is not None:
            assert found.status == "optimal", (seed, found)


@pytest.mark.parametrize("method", METHODS)
def test_greatest_snr_over_twelve_orders_of_magnitude(method: str) -> None:
    for seed in seeds_for(method):
        truth = design(np.random.default_rng(200 + seed), (CONTINUOUS, PULSED, FLASH)[seed % 3])
        reached = exact.greatest_snr(truth)
        best = None if reached is None else -20 * mp.log10(reached)
        found = solved([truth], SNR, method)
        # 1e-6 of a ratio is 9e-6 dB, and near 0 dB no relative tolerance means anything.
        assert_honest(found, [truth], best, absolute=1e-5)
        if method in SURE and best is not None:
            assert found.status == "optimal", (seed, found)


@pytest.mark.parametrize("method", METHODS)
def test_sums_whose_weights_span_twelve_orders_of_magnitude(method: str) -> None:
    for seed in seeds_for(method):
        rng = np.random.default_rng(300 + seed)
        truth = design(rng, CONTINUOUS)
        weights = spread(rng, 1e-3, 1e3) / truth.power_w, spread(rng, 1e-3, 1e3)
        best = exact.least_sum(truth, *weights)
        found = solved([truth], Objective.of({"power": weights[0], "snr_db": weights[1]}), method)
        # The terms cancel: the tolerance is that of each, 1e-6 of watts and of the SNR's ratio.
        size = weights[0] * truth.power_w + weights[1]
        assert_honest(found, [truth], best, absolute=1e-5 * size)
        if method in SURE and best is not None:
            assert found.status == "optimal", (seed, found)


def test_the_closed_form_is_exact_over_twelve_orders_of_magnitude() -> None:
    """What `solve` certifies, to 1e-9."""
    for seed in range(400 if THOROUGH else 30):
        truth = design(np.random.default_rng(seed), (CONTINUOUS, PULSED, FLASH)[seed % 3])
        best = exact.least_power_w([truth])
        found = best_settings(Question.of([rows_of(truth)], np.array([False]), POWER, np.array([0.0]), math.inf))
        assert bool(found.feasible[0]) == (best is not None), (seed, truth)
        if best is not None:
            assert abs(mp.mpf(float(found.chosen[0].light_power_w[0])) / best - 1) < 1e-9, (seed, truth)
        reached = exact.greatest_snr(truth)
        seen = best_settings(Question.of([rows_of(truth)], np.array([False]), SNR, np.array([0.0]), math.inf))
        assert bool(seen.feasible[0]) == (reached is not None), (seed, truth)
        if reached is not None:
            assert abs(float(seen.snr_db[0]) - 20 * mp.log10(reached)) < 1e-8, (seed, truth)


@pytest.mark.parametrize("method", METHODS)
def test_an_impossible_design_is_never_called_solved(method: str) -> None:
    """An SNR of 1e4 behind a well of 1e2, and one missed by a part in 1e4 only."""
    base = design(np.random.default_rng(1), CONTINUOUS)
    for wanted, well in ((1e4, 1e2), (base.min_snr, base.well_e)):
        truth = exact.replace(base, min_snr=wanted, well_e=well, gain_dn_per_e=base.full_scale_dn / well)
        if wanted == base.min_snr:
            truth = exact.replace(truth, min_snr=float(truth.snr(truth.most_e()) * (1 + mp.mpf("1e-4"))))
        assert exact.least_power_w([truth]) is None
        assert solved([truth], POWER, method).status in ("infeasible", "failed")


# ---------------------------------------------------------------- derivatives


def programs(seed: int) -> list[Program]:
    """Programs of one design: every goal, with a mean level and dark current too."""
    rng = np.random.default_rng(seed)
    truth = design(rng, (CONTINUOUS, PULSED, FLASH)[seed % 3])
    plain = rows_of(truth)
    made = []
    for rows in (plain, extended(plain, truth)):
        view = SmoothScene.of(rows)
        pieces = smooth_pieces(view)
        goals: Any = ("power", "snr", "sum", "restore") if pieces else ()
        made += [
            Program((view,), (pieces[-1],), False, goal, 1.0 / truth.power_w, 2.0, math.inf) for goal in goals
        ]
    return made


def extended(rows: SceneRows, truth: Truth) -> SceneRows:
    """The same with a wanted mean level and dark current of a tenth of the image's electrons."""
    dark = 0.1 * float(truth.min_snr) ** 2 / truth.time_max_s
    return exact.replace(rows, mean_level=0.3, dark_current_e_s=np.array([dark]))


@pytest.mark.parametrize("seed", range(60 if THOROUGH else 6))
def test_derivatives_equal_those_of_arbitrary_precision(seed: int) -> None:
    """CasADi's and the complex step's, at random points and at the corners of all ranges: relative error 1e-9."""
    from uwopt.solvers.continuous.casadi_ipopt import SymbolicProgram

    rng = np.random.default_rng(seed)
    for program in programs(seed):
        low, high = program.bounds
        shares = [np.zeros(len(low)), np.ones(len(low)), *rng.uniform(0.0, 1.0, (2, len(low)))]
        for share in shares:
            x = low + share * (high - low)
            values, gradients = exact.exact_rules(program, x)
            n, cut = len(x), len(names_of_rules(program)[0])
            for found in (SymbolicProgram(program).derivatives(x), derivatives(program, x)):
                got = np.concatenate([found.jacobian[:cut], found.jacobian[cut + 2 * n :]])
                for row, wanted in zip([found.gradient, *got], gradients, strict=True):
                    compare(row, wanted)
                kept = np.concatenate([found.values[:cut], found.values[cut + 2 * n :]])
                # a rule is a difference of logarithms of up to 1e2: 1e-12 is some rounding of those
                for one, wanted in zip([found.objective, *kept], values, strict=True):
                    assert abs(one - wanted) <= 1e-12 * max(1.0, abs(wanted))


def compare(row: Any, wanted: list[Any]) -> None:
    """Each component to 1e-9; what is below 1e-20 of the largest is zero in doubles."""
    largest = max((abs(w) for w in wanted), default=0)
    for one, exactly in zip(row, wanted, strict=True):
        assert abs(mp.mpf(float(one)) - exactly) <= mp.mpf("1e-9") * abs(exactly) + mp.mpf("1e-20") * largest
