"""Bounds of quality and its price at the same settings, attacked by random search (`settings_attack`)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hand_made_rows import FADING, FLASHES, STEPS
from numpy.typing import NDArray
from settings_attack import detail, lit, sharp

from uwopt.forward.part_columns import PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.sharpness import SharpRows
from uwopt.model import lateral, sharpness
from uwopt.objectives.objective import Objective
from uwopt.solvers.settings import joint
from uwopt.solvers.settings.cells import best_by_cells
from uwopt.solvers.settings.question import Question
from uwopt.units import db_to_ratio

Array = NDArray[Any]
DEAR = Objective.best_image("information", per_w=0.03, per_money=0.0)
NM = np.linspace(400.0, 700.0, 61)
WHITE = lateral.spread_table(  # two humps over an index that falls by 0.006, about as sea water's does
    NM, electrons_per_nm=np.exp(-(((NM - 520.0) / 60.0) ** 2)) + 0.4 * np.exp(-(((NM - 450.0) / 12.0) ** 2)),
    n_water=1.345 - 2e-5 * (NM - 400.0),
)  # fmt: skip


def slow(**changed: float) -> SharpRows:
    """With little motion, which the bound leaves out."""
    return sharp(**{"blur": 100.0, **changed})


def coloured(k: float) -> SharpRows:
    """Behind a flat port."""
    angle = np.radians(25.0)
    one = np.ones(1)
    return replace(
        slow(), rms_k_along=k * np.cos(angle) * one, rms_k_across=k * np.sin(angle) * one, spreads=(WHITE,)
    )  # fmt: skip


CASES: dict[str, dict[str, Any]] = {
    "burning": {},
    "pulses": dict(kind=PULSED),
    "steps": STEPS,
    "flashes": FLASHES,
    "a flash that fades": FADING,
    "a veil": dict(veil=60.0),
    "a veil that shows detail": dict(veil=60.0, sharpness=slow(scattered=2.0)),
    "defocus": dict(sharpness=slow(rms=30.0)),
    "a coarse lens": dict(sharpness=slow(rated=2.0, aberration=6.0)),
    "some colour": dict(sharpness=coloured(2000.0)),
    "much colour": dict(sharpness=coloured(12000.0)),
}


def best_of(rows: SceneRows, objective: Objective) -> float:
    """The best of all settings by cells, which attacks of their own hold (`test_cells`)."""
    found = best_by_cells(Question.of([rows], np.array([False]), objective, np.zeros(1), np.inf))
    assert found.feasible[0]
    quality = np.log(found.information[0]) if objective.by_ratio else found.snr_db[0]
    weight = objective.weight("information") + objective.weight("snr_db")
    return float(objective.weight("power") * found.chosen[0].light_power_w[0] - weight * quality)


@pytest.mark.parametrize("case", CASES)
def test_no_settings_beat_the_bound_and_it_is_near(case: str) -> None:
    rows = lit(**{"sharpness": slow(), **CASES[case]})
    bound, best = joint.joint_bound_of_designs([rows], DEAR, np.array([np.inf]), 0.0)[0], best_of(rows, DEAR)
    assert bound <= best
    assert best - bound < 0.85  # of ln information: the intervals of the f-number are that wide


def test_of_signal_to_noise_too() -> None:
    objective = Objective.best_image("snr_db", per_w=0.03, per_money=0.0)
    rows = lit(slow(), kind=PULSED)
    bound = joint.joint_bound_of_designs([rows], objective, np.array([np.inf]), 0.0)[0]
    assert best_of(rows, objective) - 0.2 < bound <= best_of(rows, objective)


def test_a_limit_of_power_is_kept() -> None:
    free, held, none = (
        joint.joint_bound_of_designs([lit(slow())], DEAR, np.array([limit_w]), 0.0)[0]
        for limit_w in (np.inf, 2.0, 1e-9)
    )
    assert free < held and np.isinf(none)


@pytest.mark.parametrize("shows", [False, True], ids=["even veil", "veil with detail"])
def test_the_table_holds_every_transfer_of_the_model(shows: bool) -> None:
    """Drawn between its nodes: no blur, SNR or colour has more information than the table says."""
    rng, count = np.random.default_rng(0), 400
    n, disc, rated = rng.uniform(1.4, 16.0, count), rng.uniform(0.0, 40.0, count), rng.uniform(0.0, 3.0, count)
    k, snr_db = 10.0 ** rng.uniform(1.5, 4.2, count), rng.uniform(0.0, 55.0, count)
    one, three = np.ones(count), np.ones((count, 3))
    rows = replace(
        sharp().take(np.zeros(count, int)), rms_disc_px=disc[:, None] * three, rated_pitch_px=rated,
        aberration_px=0.0 * one, blur_px_per_s=three, rms_k_along=0.8 * k, rms_k_across=0.6 * k, spreads=(WHITE,),
    )  # fmt: skip
    if shows:
        many = detail(1.0).take(np.zeros(count, int))
        rows = replace(rows, detail=replace(many, texture_gain=rng.uniform(1.0, 1.1, count)))
    exact = rows.information_bit_per_m2(
        db_to_ratio(snr_db), f_number=n, working_f_number=1.3 * n, blur_s=0.0 * one
    )
    ends = np.stack([n, n], axis=1)
    level = np.searchsorted(joint.LEVELS_DB, snr_db)
    most = joint.information_by_level(rows, 1.3 * one, ends, joint.snr_in_levels(snr_db))
    share = exact / most[np.arange(count), 0, level]
    assert share.max() <= 1.0
    assert np.median(share) > 0.85


def test_a_lens_of_the_disc_s_pitch_is_sharper_than_the_disc() -> None:
    """2 J1(a)/a < e^(-a^2/8) up to the first null of J1, from both functions as tabulated in the model."""
    nu = np.linspace(0.01, 0.5, 50)
    disc, lens = (
        sharpness.round_mtf(nu, sharpness=sharpness.Sharpness(
            working_f_number=0.0, wavelength_nm=500.0, pixel_pitch_m=1e-6, **{name: value}))
        for name, value in (("defocus_px", 3.0), ("lens_pitch_px", 3.0 * joint.DISC_PITCH))
    )  # fmt: skip
    assert (disc <= lens).all()
    assert disc[5] == pytest.approx(lens[5], rel=5e-3)
