"""What the sharpness of designs drawn from the catalogue depends on."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.designs import Hardware
from uwopt.forward.figures import SettingRows
from uwopt.forward.problem import Problem
from uwopt.forward.views import field_dioptres_per_m
from uwopt.mission.mission import load_mission
from uwopt.model.sharpness import mtf

MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "full",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30.0, "sun_lux": 2e4},
    "vehicle": {"altitude_m": 1.5, "altitude_tolerance_m": 0.2, "speed_m_s": 0.2, "light_baseline_m": 0.4},
    "requirements": {
        "overlap": 0.5, "max_blur_px": 2.0, "min_snr_db": 20.0, "min_mtf_half_nyquist": 0.1,
        "min_dof_m": 0.1, "dof_at": "corner",
    },
}  # fmt: skip
N = 14


@pytest.fixture(scope="module")
def problem() -> Problem:
    mission = load_mission(MISSION)
    return build_problem(mission, selected(mission, load_catalog(mission), generic="never"))


def drawn(problem: Problem) -> list[Hardware]:
    """Hardware at random under lamps of a known angle."""
    rng, parts = np.random.default_rng(5), problem.parts
    wide = np.nonzero([(light.beam_angle_deg is not None) for light in parts.lights])[0]
    columns = (
        rng.integers(len(parts.cameras), size=N), rng.integers(len(parts.lenses), size=N),
        rng.integers(len(parts.ports), size=N), rng.random(N) < 0.5, rng.choice(wide, size=N),
        rng.integers(1, 4, size=N),
    )  # fmt: skip
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [Hardware(*row, problem.mounts[0]) for row in rows]


def test_transfer_is_the_models_at_each_focus(problem: Problem) -> None:
    """The worse of both axes, out of focus by the farther of both images of the centre and the corner."""
    coloured = 0
    for hardware, f_number in zip(drawn(problem), np.linspace(2.0, 8.0, N).tolist(), strict=True):
        model, scene = DesignModel(problem, hardware), problem.scenes[0]
        view = model.views[0]
        for focus in (1.0 / 1.1, 0.5):
            given = SettingRows(*(np.array([one]) for one in (f_number, 2e-3, 1e-3, 2.0, 0.7, 1.0, focus)))
            figures, sharp = model.figures(0, given), model.sharp_rows(0, focus)
            aperture = {"f_number": given.f_number, "working_f_number": figures.working_f_number}
            ((one, table),) = sharp.groups("place")
            coloured += table is not None
            least = []
            for k, range_m in enumerate(scene.range_m[[0, scene.nominal, -1]]):
                at = sharp.at(one, table, **aperture, blur_s=figures.smear_s, field="place", altitude=k)
                images = [field_dioptres_per_m(places, range_m) for places in (view.axis_image, view.corner_image)]
                focal = view.focal_length_m[:, None]
                discs = focal**2 / (f_number * (1.0 - focal * focus)) * np.abs(
                    np.concatenate(images, axis=1) - focus
                ) / at.pixel_pitch_m[:, None]  # fmt: skip
                at = replace(at, defocus_px=discs.max(axis=1))
                both = [mtf(u, across_cyc_per_px=0.25 - u, sharpness=at) for u in (0.0, 0.25)]
                least.append(float(np.min(both)))
            assert figures.mtf_half_nyquist[0] == pytest.approx(least, rel=1e-12, abs=1e-15)
    assert coloured
