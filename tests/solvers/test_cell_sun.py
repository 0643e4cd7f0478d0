"""Lamps and sun together in boxes of settings: no mixture is better than the bound, and one is as good.

Mixtures are drawn at random; electrons and noise are the physics page's equation (7), written out again here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import front_cases as fc
import numpy as np
import pytest
from settings_attack import lit

from uwopt.forward.sun_light import SunField
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.imagers import enumerate_imagers
from uwopt.solvers.settings.cell_sun import Mixture, longest_open_s
from uwopt.solvers.settings.cell_windows import light_beside_most_sun

#: Electrons of the lamps a lm s and of the sun a second, their veils, and PRNU.
MIXTURES = {
    "clear lamps": dict(veil=5.0, sun=(3e5, 9e5), well_e=9000.0),
    "clear sun": dict(veil=300.0, sun=(3e5, 1e4), well_e=9000.0),
    "uneven pixels": dict(veil=100.0, sun=(3e5, 2e5), well_e=9000.0, prnu_frac=0.05),
    "at a level": dict(veil=100.0, sun=(3e5, 2e5), well_e=9000.0, mean_level=0.4),
}


FINE = dict(gain_dn_per_e=1e4, full_scale_dn=1.5e8)  # so that no quantisation counts


def snr_of(rows: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """SNR at the nominal altitude without quantisation or dark current, and whether no pixel overflows."""
    signal = rows.signal_e[0, 1] * x + rows.sun_signal_e_s[0, 1] * y
    every = signal + rows.veil_e[0, 1] * x + rows.sun_veil_e_s[0, 1] * y
    noise = np.square(rows.read_noise_e[0]) + every + np.square(rows.prnu_frac[0] * every)
    fits = rows.highlight_ratio * every <= rows.well_e[0]
    if rows.mean_level is not None:
        fits &= rows.gain_dn_per_e[0] * every <= rows.mean_level * rows.full_scale_dn[0] - rows.black_level_dn[0]
    return signal / np.sqrt(noise), fits


@pytest.mark.parametrize("name", MIXTURES)
def test_no_mixture_has_a_higher_snr_than_the_bound_and_some_has_it(name: str) -> None:
    rows, rng = lit(**MIXTURES[name], **FINE), np.random.default_rng(3)
    reached = []
    for _ in range(20):
        (x_lo, y_lo), (x_hi, y_hi) = np.sort(np.exp(rng.uniform(np.log([1e-1, 1e-4]), np.log([60.0, 0.02]), (2, 2))), 0)
        ends = [np.array([end]) for end in (x_lo, x_hi, y_lo, y_hi)]
        bound = Mixture(*ends, np.zeros(1), np.full(1, np.inf)).brightest(rows).snr[0]
        side = np.linspace(0.0, 1.0, 301)
        x, y = np.meshgrid(x_lo + side * (x_hi - x_lo), y_lo + side * (y_hi - y_lo))
        snr, fits = snr_of(rows, x, y)
        if not fits.any():
            continue
        best = snr[fits].max()
        assert best <= bound * (1 + 1e-9)
        reached.append(best / bound)
    assert len(reached) > 8
    assert max(reached) > 0.99 and np.median(reached) > 0.95  # a grid of 1/300 does not meet the cap


@pytest.mark.parametrize("veil", [5.0, 100.0, 900.0])
def test_no_lamps_are_enough_that_give_less_than_is_asked_for_over_a_range_of_the_sun(veil: float) -> None:
    """The sun all but gives the SNR by itself; X of a grid, with the noise of equation (7), at altitudes one by one."""
    rows = lit(veil=veil, sun=(3e5, 4e5), well_e=1e6, prnu_frac=0.02, **FINE)
    lamps, other, sun, murk = rows.signal_e[0], rows.veil_e[0], rows.sun_signal_e_s[0], rows.sun_veil_e_s[0]
    y_lo, y_hi = 2e-3, 3e-3
    x, y = np.meshgrid(np.geomspace(1e-3, 1e2, 4001), np.linspace(y_lo, y_hi, 41))

    def least_snr(x: Any, y: Any) -> Any:
        x, y = np.broadcast_arrays(x, y)
        signal = np.multiply.outer(lamps, x) + np.multiply.outer(sun, y)
        every = signal + np.multiply.outer(other, x) + np.multiply.outer(murk, y)
        return (signal / np.sqrt(np.square(rows.read_noise_e[0]) + every + np.square(0.02 * every))).min(axis=0)

    rows = replace(rows, min_snr=1.01 * float(least_snr(0.0, y_hi)))
    bound = light_beside_most_sun(rows, np.array([y_lo]), np.array([y_hi]))[0]
    enough = x[least_snr(x, y) >= rows.min_snr].min(initial=np.inf)
    assert bound <= enough * (1 + 1e-9)
    at_most = x[0][least_snr(x[0], y_hi) >= rows.min_snr].min(initial=np.inf)
    if np.isfinite(at_most):  # the grid is fine to 1/400
        assert bound == pytest.approx(at_most * y_lo / y_hi, rel=0.01)


def test_shutter_fills_the_pixel_and_no_more() -> None:
    rows = lit(veil=50.0, sun=(3e5, 2e5), well_e=6000.0, highlight_ratio=1.0)
    square, x = np.array([4.0]), np.array([7.0])
    open_s = longest_open_s(rows, square, x, np.zeros(1))
    # the near altitude is the brightest: 1.2 * 7 * 100 of the lamps, (3e5 * 1.2 + 2e5 * 0.8) / 4 a second of the sun
    lamps = 7.0 * (120.0 + 50.0 * 0.8)
    assert lamps + open_s[0] / 4.0 * (3e5 * 1.2 + 2e5 * 0.8) == pytest.approx(6000.0, rel=1e-9)
    burning = longest_open_s(rows, square, np.zeros(1), np.array([1e3]))
    per_y = 1e3 * (120.0 + 50.0 * 0.8) + 3e5 * 1.2 + 2e5 * 0.8
    assert burning[0] / 4.0 * per_y == pytest.approx(6000.0, rel=1e-9)


def test_no_image_has_more_of_the_sun_than_its_bound() -> None:
    problem = fc.PLANTED["sun"].problem()
    imagers = enumerate_imagers(problem)
    assert len(imagers)
    view = imagers.scenes[0].view
    for place in range(len(imagers)):
        one = view.take(np.array([place]))
        field = SunField(problem, 0, port_index=int(imagers.port[place]),
                         efficiency=int(problem.cameras.qe_index[imagers.camera[place]]))  # fmt: skip
        mean, most = field.light(one).signal_e_s, field.most_signal(one)
        assert (mean <= most * (1 + 1e-7)).all()
        assert (mean > 0.5 * most).all()  # 30 degrees off the axis cos^4 alone leaves 0.56


def test_node_bounds_know_how_much_the_sun_gives() -> None:
    search, outcome = replace(fc.PLANTED["sun"], objective=Objective.of("snr_db")).solve(top=1)
    bounds, every = search.bounds, np.arange(len(search.imagers))
    seen = bounds.of_nodes(0, every).snr_db
    assert -outcome.best[0].minimised <= seen.max() + 1e-9
    assert (seen <= bounds.snr_ceiling(0, bounds.tables.lightings, every) + 1e-9).all()
