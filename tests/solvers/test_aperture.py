"""CasADi's aperture for information against a plain search over the model's own integral."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hand_made_rows import scene
from settings_attack import detail
from thorough import drawn

from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.sharpness import SharpRows
from uwopt.model import sensor
from uwopt.objectives.objective import Objective
from uwopt.solvers.continuous.aperture import ApertureProgram, confirmed
from uwopt.solvers.continuous.opinions import aperture_opinions
from uwopt.solvers.settings.closed_form import Chosen


def rows_with(defocus_px: float, *, light: float = 1.0) -> SceneRows:
    """A scene of test_continuous with a blur disc at f-number 1 and plenty of light."""
    one, three = np.ones(1), np.ones((1, 3))
    sharp = SharpRows(
        wavelength_nm=550 * one, pixel_pitch_m=3.45e-6 * one, rated_pitch_px=0.8 * one,
        aberration_px=1.5 * one, aberration_exponent=3.0 * one, blur_px_per_s=10 * three,
        place_disc_px=defocus_px * three,
        corner_disc_px=defocus_px * three, rms_disc_px=defocus_px * three, gsd_m=1e-3 * three, place_k_along=0 * one,
        place_k_across=0 * one, corner_k_along=0 * one, corner_k_across=0 * one,
        rms_k_along=0 * one, rms_k_across=0 * one,
        spread_index=np.zeros(1, int), pixel_area_m2=1e-6 * one, spreads=(), detail=detail(1.0),
    )  # fmt: skip
    plain = scene(signal_e=[100.0 * light], n_low=1.4, n_high=22.0)
    return replace(plain, sharp=sharp)


def chosen_at(rows: SceneRows, f_number: float, most: float = np.inf) -> tuple[Chosen, float]:
    """The light that passes this aperture or that the pixels hold, and its information by the model's quadrature."""
    time_s = float(rows.time_max_s[0])
    level = min(float(rows.max_level[0]), 1.0)
    light_x = float(rows.light_lm[0]) * level * time_s / (f_number * float(rows.working_factor[0])) ** 2
    level, light_x = level * min(1.0, most / light_x), min(light_x, most)
    one = np.ones(1)
    chosen = Chosen(f_number * one, level * one, time_s * one, one, light_x * one, one, one)
    snr = sensor.snr(
        float(rows.signal_e[0, rows.nominal]) * light_x,
        read_noise_e=rows.read_noise_e,
        gain_dn_per_e=rows.gain_dn_per_e,
    )
    assert rows.sharp is not None
    bits = rows.sharp.information_bit_per_m2(
        snr, f_number=f_number * one, working_f_number=f_number * rows.working_factor, blur_s=time_s * one
    )
    return chosen, float(bits[0])


@pytest.mark.parametrize("defocus_px", drawn([0.0, 20.0], [0.0, 5.0, 20.0, 60.0]))
def test_the_confirmed_aperture_is_the_best_of_a_plain_search(defocus_px: float) -> None:
    rows = rows_with(defocus_px, light=3.0)
    start = ApertureProgram(rows, chosen_at(rows, 4.0)[0])
    low, high = start.bounds
    tried = np.exp(np.linspace(low[0], high[0], 400))
    most = float(np.exp(high[1]))
    values = [chosen_at(rows, n, most)[1] for n in tried]
    tried = float(tried[int(np.argmax(values))]) * np.linspace(0.99, 1.01, 41)  # where pixels are full is a kink
    tried = tried[tried >= 1.4]
    values = [chosen_at(rows, n, most)[1] for n in tried]
    best = float(tried[int(np.argmax(values))])
    word = confirmed(rows, chosen_at(rows, best, most)[0])
    assert word is not None
    assert word["kkt_residual"] < 1e-6
    assert abs(word["gain_rel"]) < 2e-4  # 41 steps of 0.05 %: a parabola's top is missed by 1e-5
    if defocus_px >= 20.0:  # between defocus and diffraction: not the widest opening
        assert word["f_number"] > 1.4 * 1.05
        assert word["f_number"] == pytest.approx(best, rel=0.02)


def test_the_program_has_the_information_of_the_model() -> None:
    rows = rows_with(5.0, light=0.01)
    chosen, bits = chosen_at(rows, 4.0)
    found = ApertureProgram(rows, chosen).log_information(np.log(4.0), np.log(chosen.light_x[0]))
    assert np.exp(found) == pytest.approx(bits, rel=2e-4)  # rules of quadrature


def test_a_wrong_aperture_is_not_confirmed() -> None:
    rows = rows_with(20.0, light=3.0)
    word = confirmed(rows, chosen_at(rows, 20.0)[0])
    assert word is not None and word["gain_rel"] > 0.01


def test_no_aperture_for_information_is_told_where_power_counts() -> None:
    """It takes more light than is worth its power: a quadrat frame is worth 2.4 % less so."""
    image = Objective.best_image("information", per_w=0.01, per_money=0.0)
    assert aperture_opinions(cast(Any, SimpleNamespace(goal=image)), cast(Any, None)) == []
