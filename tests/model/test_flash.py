"""A flash that fades: what a shutter lets in of it, how long it takes, how much it blurs."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from uwopt.model import flash
from uwopt.model.sharpness import sinc_mtf

TAU_S = 1e-3
OF_TAU = np.array([1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 3.0, np.log(100.0)])


def share_in(open_s: float, duration_s: float, at_frac: float) -> float:
    """Share of all the light of a flash."""
    tau_s = float(flash.decay_s(duration_s, at_frac=at_frac))
    return float(flash.light_time_s(open_s, decay_s=tau_s)) / tau_s


@pytest.mark.parametrize(
    ("at_frac", "share"),
    [
        (0.5, 1.0 - 0.5**0.3),  # 0.188: t0.5 = 2 ms, 0.6 ms are 0.3 half-lives
        (0.1, 1.0 - 0.1**0.3),  # 0.499
        (0.07, 1.0 - 0.07**0.3),  # 0.550
    ],
)
def test_a_flash_of_2_ms_cut_at_0_6_ms_gives_what_its_fading_leaves(at_frac: float, share: float) -> None:
    assert share_in(0.6e-3, 2e-3, at_frac) == pytest.approx(share, rel=1e-12)


def test_half_of_the_light_is_out_after_t05_and_nine_tenths_after_t01() -> None:
    assert share_in(2e-3, 2e-3, 0.5) == pytest.approx(0.5)
    assert share_in(2e-3, 2e-3, 0.1) == pytest.approx(0.9)


def test_a_flash_is_over_with_a_hundredth_left() -> None:
    # t0.1 = 2 ms: two decades take twice as long as one
    assert flash.whole_s(2e-3, at_frac=0.1) == pytest.approx(4e-3)
    assert flash.whole_s(2e-3, at_frac=0.01) == pytest.approx(2e-3)


def test_light_that_stays_as_bright_as_it_begins_is_its_own_time() -> None:
    assert flash.decay_s(2e-3, at_frac=1.0) == np.inf and flash.whole_s(2e-3, at_frac=1.0) == 2e-3
    for formula in (flash.light_time_s, flash.open_time_s, flash.fading_blur_time_s, flash.open_time_of_blur_s):
        assert formula(0.7e-3, decay_s=np.inf) == 0.7e-3
        both = formula(np.full(2, 0.7e-3), decay_s=np.array([np.inf, 1e3]))
        assert both == pytest.approx(0.7e-3, rel=1e-6)  # of a very slow one: nearly


@pytest.mark.parametrize("of_tau", OF_TAU)
def test_the_blur_is_that_of_steady_light_of_the_same_variance(of_tau: float) -> None:
    if of_tau < 0.01:
        assert flash.fading_blur_time_s(of_tau * TAU_S, decay_s=TAU_S) == pytest.approx(of_tau * TAU_S, rel=1e-6)
        return

    def moment(n: int) -> float:
        return float(quad(lambda t: t**n * np.exp(-t), 0.0, of_tau, epsabs=0.0, epsrel=1e-13)[0])

    variance = moment(2) / moment(0) - (moment(1) / moment(0)) ** 2
    expected = TAU_S * np.sqrt(12.0 * variance)
    assert flash.fading_blur_time_s(of_tau * TAU_S, decay_s=TAU_S) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("of_tau", [0.2, 1.0, 2.3, np.log(100.0)])
def test_the_transfer_of_the_flash_is_nowhere_below_that_of_its_blur(of_tau: float) -> None:
    blur = flash.fading_blur_time_s(of_tau * TAU_S, decay_s=TAU_S) / TAU_S
    frequency = np.linspace(1e-3, 1.0 / blur, 200)  # to the box's first null
    # |integral of e^(-t - i w t)| from 0 to x over that without w, in closed form
    w = 2.0 * np.pi * frequency
    transfer = np.abs((1.0 - np.exp(-(1.0 + 1j * w) * of_tau)) / (1.0 + 1j * w)) / (1.0 - np.exp(-of_tau))
    assert (transfer >= sinc_mtf(frequency, width_px=blur) - 1e-12).all()


def test_the_inverses_are_those_of_bisection() -> None:
    times, taus = OF_TAU * TAU_S, np.full(len(OF_TAU), TAU_S)
    light, blur = flash.light_time_s(times, decay_s=taus), flash.fading_blur_time_s(times, decay_s=taus)
    assert flash.open_time_s(light, decay_s=taus) == pytest.approx(times, rel=1e-9)
    assert flash.open_time_of_blur_s(blur, decay_s=taus) == pytest.approx(times, rel=1e-9)
    for wanted in (0.3e-3, 2e-3, 3e-3):
        found = brentq(lambda t, b: float(flash.fading_blur_time_s(t, decay_s=TAU_S)) - b, 1e-6, 8e-3, args=(wanted,))
        assert flash.open_time_of_blur_s(wanted, decay_s=TAU_S) == pytest.approx(found, rel=1e-6)
    assert flash.open_time_of_blur_s(4e-3, decay_s=TAU_S) == np.inf  # more than 2 sqrt(3) tau
    assert flash.open_time_s(TAU_S, decay_s=TAU_S) == np.inf


def test_the_logarithm_of_the_blur_is_convex_in_that_of_the_light() -> None:
    """What bounds over cells of times rest on, with the slope that they take."""
    times = TAU_S * np.geomspace(1e-3, np.log(100.0), 4000)
    taus = np.full(len(times), TAU_S)
    log_s, log_b = (np.log(f(times, decay_s=taus)) for f in (flash.light_time_s, flash.fading_blur_time_s))
    slope = flash.blur_elasticity(times, decay_s=taus)
    assert (slope >= 1.0 - 1e-9).all() and (np.diff(slope) > -1e-9).all()
    assert slope[1:-1] == pytest.approx(np.gradient(log_b, log_s)[1:-1], rel=1e-4)


def test_the_open_time_runs_on_symbols() -> None:
    mode = casadi.GlobalOptions.getNumpyMode()
    casadi.GlobalOptions.setNumpyMode(1)
    try:
        symbol = casadi.MX.sym("s")
        formula = casadi.Function("f", [symbol], [flash.open_time_s(symbol, decay_s=TAU_S)])
        assert float(formula(0.5e-3)) == pytest.approx(TAU_S * np.log(2.0), rel=1e-12)
    finally:
        casadi.GlobalOptions.setNumpyMode(mode)
