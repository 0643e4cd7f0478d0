"""Bars on the floor that must arrive: the figure against closed forms, and what the key asks for beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import itj0y0, j1

import uwopt
from uwopt.catalog.curves.spectra import water_profile
from uwopt.errors import MissionError
from uwopt.evaluation.design import evaluate_design, evaluate_designs
from uwopt.forward.assembly import system_problem
from uwopt.forward.designs import SceneSettings
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system
from uwopt.model.phase_formulas import fournier_forand_for_backscatter, fournier_forand_per_sr
from uwopt.objectives.objective import Objective

MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "full",
    "scene": {"water": "III", "seafloor": 0.2, "depth_m": 50},
    "vehicle": {"altitude_m": 2, "speed_m_s": 0.3, "light_baseline_m": 0.5},
}  # fmt: skip
SYSTEM: dict[str, Any] = {
    "camera": {
        "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
        "quantum_efficiency": 0.6, "bit_depth": 12, "saturation_e": 10000,
    },
    "lens": {"focal_length_mm": 8, "f_number_min": 2.0, "rated_pixel_pitch_um": 3.45, "aberration_pitch_um": 6.9},
    "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10},
    "light": {"flux_lm": 40000, "power_w": 400, "beam_half_angle_deg": 40},
    "light_baseline_m": 0.5, "settings": {"f_number": 2.8, "exposure_ms": 1.0, "gain": 1.0},
}  # fmt: skip


def requirements(**wanted: Any) -> Any:
    return load_mission({**MISSION, "requirements": {"overlap": 0.3, **wanted}}).views[0].requirements


def share_that_shows(cycles_per_rad: float) -> float:
    """chi of the default phase function: integral of p(psi) (1/y) integral of J0 from 0 to y = 2 pi f psi."""
    psi = np.geomspace(1e-8, np.pi, 200_001)
    index, slope = fournier_forand_for_backscatter(0.0183)
    y = 2.0 * np.pi * cycles_per_rad * psi
    shown = fournier_forand_per_sr(psi, index=index, slope=slope) * itj0y0(y)[0] / y
    return float(np.trapezoid(2.0 * np.pi * np.sin(psi) * psi * shown, np.log(psi)))


def test_narrowest_bars_have_a_tenth_of_the_contrast_by_the_closed_forms() -> None:
    mission = {**MISSION, "requirements": {"overlap": 0.3, "resolve_mm": 20.0}}
    scene = uwopt.evaluate(mission, SYSTEM).design.scenes[0]
    found = scene.figures
    nu = found["gsd_mm"] / (2.0 * found["resolve_mm"])  # one altitude; a cycle is two bars
    s = nu * 0.53e-3 * found["working_f_number"] / 3.45e-3  # blue-green light: 530 nm to 5 %
    pupil = 2.0 / np.pi * (np.arccos(s) - s * np.sqrt(1.0 - s * s))
    disc = np.pi * found["defocus_corner_px"] * nu
    pitch2_px = 1.8**2 * (1.0 + (6.9 / 3.45) ** 2 * (2.0 / 2.8) ** 3)  # rated and aberrations, in the corner
    # Light that particles scatter nearly forward shows detail too, exp(b r chi): b of the table, without the molecules'
    # 0.002 1/m; chi of 1 / (2 b) cycles per metre of floor by plain quadrature of Fournier and Forand's function
    profile = water_profile("III")
    assert profile.b_per_m is not None
    b = np.interp(530.0, profile.wavelength_nm, profile.b_per_m) - 0.002
    found["contrast"] *= np.exp(2.0 * b * share_that_shows(2.0 / (2e-3 * found["resolve_mm"])))
    left = found["contrast"] * np.sinc(nu) * np.sinc(nu * found["blur_px"]) * pupil * 2.0 * j1(disc) / disc
    assert left * 0.5 ** ((2.0 * nu) ** 2 * pitch2_px) == pytest.approx(0.1, rel=5e-3)
    margin = {m.requirement: m for m in scene.margins}["resolve_mm"]
    assert (margin.value, margin.limit, margin.unit) == (pytest.approx(found["resolve_mm"]), 20.0, "mm")


def test_designs_evaluated_together_are_as_each_alone() -> None:
    mission = load_mission({**MISSION, "requirements": {"overlap": 0.3, "resolve_mm": 20.0}})
    many, goal = [], Objective({"power": 1.0})
    for systems in ({}, {"orientation": "portrait"}):
        problem, hardware = system_problem(mission, load_system(SYSTEM | systems))
        settings = [(2.8, 1.0, 0.5), (5.6, 3.0, 0.5), (2.8, 2.0, 0.4)]  # two at one focus
        many += [
            (hardware, [SceneSettings(f_number=n, exposure_s=1e-3 * ms, gain=1.0, dioptre_per_m=dioptre)])
            for n, ms, dioptre in settings
        ]
    together = evaluate_designs(problem, many, goal)
    assert len({one.scenes[0].figures["resolve_mm"] for one in together}) == 6
    for one, (hardware, given) in zip(together, many, strict=True):
        assert one == evaluate_design(problem, hardware, given, goal)


def test_bars_arrive_at_the_darkest_pixel_through_the_veil_that_is_there(tmp_path: Path) -> None:
    # Water that sends nothing back: e^-Kr - e^-cr of each lamp's light arrives as a veil, e^-cr as image, whatever lamp
    # lit the floor. The corner's ray is (d + R) / cos - R = 2.1 m * 1.2138 - 0.1 m long, its tangent 5.506 mm / 8 mm.
    (tmp_path / "w.csv").write_text("wavelength_nm,attenuation_per_m,kd_per_m\n380,1,0.3\n780,1,0.3\n")
    half_mm = np.hypot(2448, 2048) * 3.45e-3 / 2.0
    corner_m = 2.1 * np.hypot(1.0, half_mm / 8.0) - 0.1
    found = {}
    for at in ("mean", "worst_px", "worst"):
        mission = {
            **MISSION, "scene": {**MISSION["scene"], "water": str(tmp_path / "w.csv")},
            "requirements": {"overlap": 0.3, "resolve_mm": 50.0, "snr_at": at},
        }  # fmt: skip
        found[at] = uwopt.evaluate(mission, SYSTEM).design.scenes[0]
    figures = found["worst_px"].figures
    nu = figures["gsd_mm"] / (2.0 * figures["resolve_mm"])
    s = nu * 0.53e-3 * figures["working_f_number"] / 3.45e-3
    pupil = 2.0 / np.pi * (np.arccos(s) - s * np.sqrt(1.0 - s * s))
    disc, pitch2_px = np.pi * figures["defocus_corner_px"] * nu, 1.8**2 * (1.0 + (6.9 / 3.45) ** 2 * (2.0 / 2.8) ** 3)
    mtf = np.sinc(nu) * np.sinc(nu * figures["blur_px"]) * pupil * 2.0 * j1(disc) / disc
    left = np.exp(-(1.0 - 0.3) * corner_m) * mtf * 0.5 ** ((2.0 * nu) ** 2 * pitch2_px)
    assert left == pytest.approx(0.1, rel=5e-3)
    values = [{m.requirement: m.value for m in found[at].margins}["resolve_mm"] for at in ("mean", "worst", "worst_px")]
    assert values == sorted(values) and values[0] < 0.99 * values[1] < 0.99 * values[2]
    assert values[2] == pytest.approx(figures["resolve_mm"])


def test_bars_ask_for_pixels_no_wider_and_an_snr_of_twenty_decibels() -> None:
    wanted = requirements(resolve_mm=2.0)
    assert (wanted.max_gsd_mm, wanted.min_snr) == (2.0, pytest.approx(10.0))
    stricter = requirements(resolve_mm=2.0, max_gsd_mm=1.0, min_snr_db=26.0)
    assert (stricter.max_gsd_mm, stricter.min_snr_db) == (1.0, 26.0)
    weaker = requirements(resolve_mm=2.0, max_gsd_mm=5.0, min_snr=3.0)
    assert (weaker.max_gsd_mm, weaker.min_snr) == (2.0, pytest.approx(10.0))


@pytest.mark.parametrize("wrong", [0, -1, "fine"])
def test_a_wrong_width_of_bars_is_told_once(wrong: Any) -> None:
    with pytest.raises(MissionError, match="resolve_mm") as caught:
        requirements(resolve_mm=wrong)
    assert len(caught.value.faults) == 1
