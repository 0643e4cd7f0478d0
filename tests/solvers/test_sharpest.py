"""How sharp anything can be is known by bounds, and told where more is asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_least_change import POWER, mission

from uwopt.catalog.catalogue import Catalog
from uwopt.forward.sharpness import sharpness_of
from uwopt.mission.mission import Mission
from uwopt.results.basis import WhyNothing
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.infeasible.sharpest import SHARP, Sharpest, most_of_imagers, most_of_parts
from uwopt.solvers.infeasible.trials import Trials
from uwopt.solvers.infeasible.why_nothing import why_nothing
from uwopt.solvers.recommend import Sought, seek

LENSES = ("zz-lens", "zz-wide", "zz-corner")


def sharp(parts: Path, asked: float | None, **more: float) -> Mission:
    """A survey with so much contrast at half the Nyquist frequency, by the whole physics."""
    return mission(parts, LENSES, **{SHARP: asked}, **more).with_changes(physics="full")


def sought(wanted: Mission, catalog: Catalog) -> Sought:
    return seek(wanted, catalog, POWER, generic="never", top=1)


def reference(f_number: np.ndarray, *, wavelength_m: float, pitch_m: float, lens_pitch_m: np.ndarray) -> np.ndarray:
    """Box, circular pupil and Gaussian at a quarter cycle per pixel: sinc, overlap of two discs, half at Nyquist."""
    s = 0.25 * wavelength_m * f_number / pitch_m
    discs = 2.0 / np.pi * (np.arccos(s) - s * np.sqrt(1.0 - s * s))
    return np.sinc(0.25) * discs * 0.5 ** ((0.25 / (0.5 * pitch_m / lens_pitch_m)) ** 2)


def test_no_camera_with_a_lens_leaves_more_than_its_pixels_its_pupil_and_its_glass(parts, catalog):
    problem = sought(sharp(parts, None), catalog).problem
    most = most_of_parts(problem, np.zeros(3, int), np.arange(3))[:, 0]
    columns = problem.lenses
    for lens in range(3):
        n = np.linspace(columns.f_number_min[lens], columns.f_number_max[lens], 2001)
        soft = columns.aberration_f1_m[lens] ** 2 * n ** -columns.aberration_exponent[lens]
        square = columns.rated_pitch_m[lens] ** 2 + soft
        left = reference(
            n, wavelength_m=problem.scenes[0].wavelength_nm[0] * 1e-9, pitch_m=5.86e-6, lens_pitch_m=np.sqrt(square)
        )  # fmt: skip
        assert left.max() <= most[lens] < 1.03 * left.max()


def test_what_an_imager_reaches_at_any_f_number_is_within_its_bound(parts, catalog):
    found = sought(sharp(parts, None), catalog)
    problem, imagers, bounds = found.problem, found.outcome.imagers, Sharpest(found.problem, found.outcome.imagers)
    assert len(imagers) > 1
    focused, most = imagers.scenes[0].focused, bounds.first(len(imagers))
    reached = sharpness_of(
        problem, 0, imagers.scenes[0].view, camera=imagers.camera, lens=imagers.lens, port=imagers.port, optics=0,
        dioptre_per_m=focused.dioptre_per_m,
    )  # fmt: skip
    left = np.max([
        reached.mtf_half_nyquist(f_number=n, working_f_number=n * focused.working_factor, blur_s=np.zeros(len(imagers)))
        .min(axis=1)
        for n in np.geomspace(focused.n_low, focused.n_high, 40)
    ], axis=0)  # fmt: skip
    bound = most_of_imagers(problem, 0, imagers)
    assert (left <= bound).all() and (bound <= bounds.of_parts[:, 0]).all() and (bound < 1.05 * left).all()
    assert bounds.most == pytest.approx([bound.max()]) and list(most) == list(np.argsort(-bound, kind="stable"))
    for asked in (0.5, 0.99 * left.max(), 1.0):
        assert set(np.flatnonzero(left >= asked)) <= set(bounds.at_least(sharp(parts, min(asked, 0.9))))
    assert len(bounds.at_least(sharp(parts, 0.9))) == 0


def explained(wanted: Mission, catalog: Catalog) -> tuple[WhyNothing, Trials]:
    """Why nothing fits, as far as is known without a limit of time."""
    found = sought(wanted, catalog)
    assert not found.outcome.best
    trials = Trials(wanted, catalog, POWER, "never", like=found)
    return why_nothing(trials, certificate(found.selection, found.problem, found.outcome, POWER)), trials


def test_detail_that_no_parts_show_is_told_to_have_to_give_without_a_search_for_all_else(parts, catalog, monkeypatch):
    """0.89 where pixels alone leave 0.90: what is told does, 3 % of the change less does not, nor all else."""
    asked, seek_one = list[set[str]](), Relaxer.seek

    def heard(self: Relaxer, wanted: Mission, goal: Any, freed: Any, **more: Any) -> Sought:
        asked.append(set(freed))
        return seek_one(self, wanted, goal, freed, **more)

    monkeypatch.setattr(Relaxer, "seek", heard)
    why, trials = explained(sharp(parts, 0.89), catalog)
    (told,) = why.relaxations
    assert told.name == SHARP and told.nearest and why.unmet == why.contradiction == [SHARP]
    assert sought(sharp(parts, told.needed), catalog).outcome.best
    assert not sought(sharp(parts, told.needed + 0.03 * (0.89 - told.needed)), catalog).outcome.best
    assert {one.name for one in why.no_help} >= trials.limits.keys() - {SHARP} | {"speed_m_s", "altitude_m", "water"}
    assert not why.not_known and all(SHARP in some for some in asked)


def test_where_some_parts_would_be_sharp_enough_other_requirements_are_asked(parts, catalog):
    """The one lens that sees so far to the side is soft; another one is not."""
    why, _ = explained(sharp(parts, 0.7, min_swath_m=3.0), catalog)
    assert SHARP not in why.unmet and "min_swath_m" in {one.name for one in why.relaxations}
