"""Batches of designs against the same designs one at a time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.batch import Batch
from uwopt.forward.designs import Designs, Hardware
from uwopt.forward.effects import effects_kept
from uwopt.forward.figures import SettingRows
from uwopt.forward.views import field_dioptres_per_m
from uwopt.mission.mission import load_mission
from uwopt.model.effects import Effects
from uwopt.model.sharpness import mtf

MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "full",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30.0, "sun_lux": 2e4},
    "vehicle": {"altitude_m": 1.5, "altitude_tolerance_m": 0.2, "speed_m_s": 0.2, "light_baseline_m": 0.4},
    "requirements": {
        "overlap": 0.5, "max_blur_px": 2.0, "min_snr_db": 20.0, "snr_at": "worst_px", "min_mtf_half_nyquist": 0.1,
        "min_dof_m": 0.1, "dof_at": "corner",
    },
}  # fmt: skip
N = 14
SAME = 2e-4  # ray nodes follow the longest ray of a group: see model.veil


@pytest.fixture(scope="module")
def batch() -> Batch:
    mission = load_mission(MISSION)
    catalog = load_catalog(mission)
    problem = build_problem(mission, selected(mission, catalog, generic="never"))
    rng, parts = np.random.default_rng(5), problem.parts
    wide = np.nonzero([(light.beam_angle_deg is not None) for light in parts.lights])[0]
    return Batch(
        problem,
        Designs(
            rng.integers(len(parts.cameras), size=N), rng.integers(len(parts.lenses), size=N),
            rng.integers(len(parts.ports), size=N), rng.random(N) < 0.5, rng.choice(wide, size=N),
            rng.integers(1, 4, size=N), problem.mounts[0],
        ),
    )  # fmt: skip


def settings(n: int) -> SettingRows:
    """The same for every design but the f-number."""
    one = np.ones(n)
    return SettingRows(
        np.linspace(2, 8, n), 2e-3 * one, 1e-3 * one, 2.0 * one, 0.7 * one, 1.0 * one, 1.0 / 1.1 * one
    )


def test_a_batch_gives_what_one_design_at_a_time_gives(batch: Batch) -> None:
    given, d = settings(N), batch.designs
    many = batch.figures(0, batch.rows(0), given, information=True)
    for i in range(N):
        hardware = Hardware(
            int(d.camera[i]), int(d.lens[i]), int(d.port[i]), bool(d.landscape[i]), int(d.light[i]), int(d.count[i]),
            d.mount,
        )  # fmt: skip
        one = DesignModel(batch.problem, hardware).figures(0, given.take(np.array([i])), information=True)
        for name in ("electrons_signal", "electrons_forward", "electrons_backscatter", "electrons_sun", "snr",
                     "snr_pixels", "mean_level", "contrast", "blur_px", "overlap", "mtf_half_nyquist",
                     "information_bit_per_m2", "light_power_w", "dof_near_m"):  # fmt: skip
            np.testing.assert_allclose(
                getattr(many, name)[i], getattr(one, name)[0], rtol=SAME, atol=1e-9, err_msg=f"{name} of {i}"
            )


def test_transfer_of_a_batch_is_the_models_of_each_design(batch: Batch) -> None:
    assert any(not batch.problem.ports.is_dome[port] for port in batch.designs.port)  # some have lateral colour
    rows = batch.rows(0)
    for dioptre in (1.0 / 1.1, 0.5):  # one batch, at one focus and then another
        given = replace(settings(N), dioptre_per_m=np.full(N, dioptre))
        figures = batch.figures(0, rows, given)
        sharp = batch.sharp_rows(0, given.dioptre_per_m)
        aperture = {"f_number": given.f_number, "working_f_number": figures.working_f_number}
        least = np.full((N, 3), np.nan)
        for some, table in sharp.groups("place"):
            focus = given.dioptre_per_m[some, None]
            for k, range_m in enumerate(batch.problem.scenes[0].range_m[[0, batch.problem.scenes[0].nominal, -1]]):
                at = sharp.at(some, table, **aperture, blur_s=figures.smear_s, field="place", altitude=k)
                images = [
                    field_dioptres_per_m(places[some], range_m)
                    for places in (batch.views[0].axis_image, batch.views[0].corner_image)
                ]
                focal = batch.views[0].focal_length_m[some, None]
                discs = focal**2 / (given.f_number[some, None] * (1 - focal * focus)) * np.abs(
                    np.concatenate(images, axis=1) - focus
                ) / at.pixel_pitch_m[:, None]  # fmt: skip
                at = replace(at, defocus_px=discs.max(axis=1))
                least[some, k] = np.minimum(
                    mtf(0.25, across_cyc_per_px=0.0, sharpness=at), mtf(0.0, across_cyc_per_px=0.25, sharpness=at)
                )
        assert figures.mtf_half_nyquist == pytest.approx(least, rel=1e-12, abs=1e-15)


def test_what_a_few_designs_need_is_kept_for_all(batch: Batch) -> None:
    influences = batch.influences(1e-3, [settings(N)])
    kept = effects_kept(influences)
    assert kept.forward_veil and kept.backscatter and kept.sunlight
    assert {i.name for i in influences} == set(Effects.names())


def test_effects_left_out_of_a_batch_leave_the_image_forming_light_as_it_is(batch: Batch) -> None:
    lean = batch.with_effects(Effects.none())
    plain, whole = lean.rows(0).light, batch.rows(0).light
    assert plain.forward_e is None and plain.backscatter_e is None
    np.testing.assert_allclose(plain.signal_e, whole.signal_e, rtol=1e-12)
