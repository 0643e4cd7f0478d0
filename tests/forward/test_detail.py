"""Detail in light scattered nearly forward, in missions: where it counts, what it changes, and what bounds it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import itj0y0

import uwopt
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.assembly import system_problem
from uwopt.forward.detail import most_scattering_per_m, texture_gain
from uwopt.forward.effects import forward_bound
from uwopt.forward.lamp_light import LampField
from uwopt.forward.sharpness import SharpRows
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system
from uwopt.model import phase_formulas, sharpness

SYSTEM: dict[str, Any] = {
    "camera": {
        "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
        "quantum_efficiency": 0.6, "bit_depth": 12, "saturation_e": 10000,
    },
    "lens": {"focal_length_mm": 8, "f_number_min": 2.0, "rated_pixel_pitch_um": 3.45},
    "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10},
    "light": {"flux_lm": 40000, "power_w": 400, "beam_half_angle_deg": 40},
    "light_baseline_m": 0.5, "settings": {"f_number": 2.8, "exposure_ms": 1.0, "gain": 1.0},
}  # fmt: skip


def model_of(altitude_m: float = 2.0, **scene: Any) -> DesignModel:
    keys = {"water": "3C", "seafloor": 0.2, "depth_m": 50} | scene
    mission = load_mission({
        "practice": "bare", "physics": "full", "scene": keys, "objective": "information",
        "vehicle": {"altitude_m": altitude_m, "speed_m_s": 0.3, "light_baseline_m": 0.5},
        "requirements": {"overlap": 0.3, "resolve_mm": 20.0},
    })  # fmt: skip
    return DesignModel(*system_problem(mission, load_system(SYSTEM)))


def rows_of(model: DesignModel) -> SharpRows:
    return model.sharp_rows(0, 1.0)


def chi(frequency: float) -> float:
    """Of the default phase function, by plain quadrature."""
    index, slope = phase_formulas.fournier_forand_for_backscatter(0.0183)

    def shown(log_psi: float) -> float:
        psi = np.exp(log_psi)
        y = 2 * np.pi * frequency * psi
        p = phase_formulas.fournier_forand_per_sr(np.array(psi), index=index, slope=slope)
        return float(2 * np.pi * np.sin(psi) * psi * p * itj0y0(y)[0] / y)

    return quad(shown, np.log(1e-8), np.log(np.pi), limit=2000, epsabs=1e-7)[0]


def test_bars_of_a_width_have_what_the_water_scatters_nearly_forward() -> None:
    # bars of 5 mm at 2 m: 200 cycles per radian; grey enough that the colour hardly matters
    model = model_of()
    scene, rows = model.problem.scenes[0], rows_of(model)
    at = rows.gsd_m / (2 * 5e-3)
    particles = scene.scattering[0].scattering_per_m
    seen = (scene.wavelength_nm > 480) & (scene.wavelength_nm < 620)
    low, high = (float(np.exp(2.0 * b * chi(200.0))) for b in (particles[seen].min(), particles[seen].max()))
    assert rows.detail is not None
    assert low * 0.998 <= float(rows.detail.gain(at)[0, 1]) <= high * 1.002 and low > 1.1


def test_detail_is_lost_where_scattering_is_counted_once_or_not_at_all() -> None:
    assert rows_of(model_of()).detail is not None
    assert rows_of(model_of(multiple_scattering=False)).detail is None
    problem = model_of().problem
    for left_out in ("forward_veil", "multiple_scattering"):
        changed = problem.with_effects(problem.effects.without([left_out]))
        assert rows_of(DesignModel(changed, model_of().hardware)).detail is None


def test_information_by_one_frequency_is_no_more_than_that_of_all_frequencies() -> None:
    # (1/2) log2(1 + (C_t SNR F(nu) MTF(nu))^2) over the Nyquist square, by a plain sum, dim and bright
    for altitude_m, water in ((1.5, "3C"), (1.0, "5C"), (4.0, "II")):
        rows = rows_of(model_of(altitude_m, water=water))
        assert rows.detail is not None
        one = np.ones(1)
        given = dict(f_number=5.6 * one, working_f_number=5.6 * one, blur_s=1e-4 * one)
        at = rows.at(np.array([0]), None, field="rms", **given)
        nu = (np.arange(60) + 0.5) / 120.0
        along, across = np.meshgrid(nu, nu)
        transfer = sharpness.mtf(along, across_cyc_per_px=across, sharpness=at)
        cycles = np.hypot(along, across) * np.sqrt(rows.gsd_m[0, 1] ** 2 / rows.pixel_area_m2[0])
        gain = np.exp(
            rows.detail.scattered[0, 1]
            * np.interp(np.log(cycles * rows.detail.cycles_per_rad[0, 1]), *vars(rows.detail.table).values())
        )
        for snr in (3.0, 30.0, 200.0):
            exact = np.mean(0.5 * np.log2(1 + (0.1 * snr * gain * transfer) ** 2)) / rows.pixel_area_m2[0]
            found = float(rows.information_bit_per_m2(snr * one, **given)[0])
            without = float(replace(rows, detail=None).information_bit_per_m2(snr * one, **given)[0])
            assert without < found <= exact  # a prudent frequency
            assert exact - found < 0.75 * (exact - without)
            assert found == pytest.approx(exact, rel={3.0: 0.25, 30.0: 0.1, 200.0: 0.05}[snr])


def test_no_colour_and_no_smaller_pixel_has_more_than_bounds_say() -> None:
    model = model_of()
    rows, scene, view = rows_of(model), model.problem.scenes[0], model.views[0]
    pixels = np.array([2448.0 * 2048.0])
    most = texture_gain(
        scene, area_m2=1.3 * view.area_m2[:, 1], pixels=pixels, scattering_per_m=most_scattering_per_m(scene)
    )
    assert 1.0 < float(rows.texture_gain[0]) < float(most[0])


@pytest.mark.parametrize(("water", "altitude_m"), [("I", 4.0), ("II", 1.0), ("3C", 2.0), ("9C", 0.5)])
def test_leaving_out_the_forward_veil_is_told_to_change_more_than_detail_in_it(water: str, altitude_m: float) -> None:
    model = model_of(altitude_m, water=water)
    rows, view, hardware = rows_of(model), model.views[0], model.hardware
    field = LampField(model.problem, 0, port_index=hardware.port, lit=model.lit, efficiency=0)
    bound = forward_bound(field, view, field.light(view, veils="none").signal_e)
    assert rows.detail is not None
    bars = rows.detail.gain(rows.gsd_m / (2 * 0.1))  # as coarse as 10 cm
    assert float(bars.max()) - 1.0 <= bound and float(rows.texture_gain[0]) ** 2 - 1.0 <= bound


def test_evaluate_resolves_finer_bars_with_detail_in_the_veil() -> None:
    mission: dict[str, Any] = {
        "practice": "bare", "physics": "full", "vehicle": {"altitude_m": 2, "speed_m_s": 0.3, "light_baseline_m": 0.5},
        "requirements": {"overlap": 0.3, "resolve_mm": 20.0},
    }  # fmt: skip
    scene = {"water": "3C", "seafloor": 0.2, "depth_m": 50}
    found = uwopt.evaluate({**mission, "scene": scene}, SYSTEM).design.scenes[0]
    rows = rows_of(model_of())
    plain = replace(rows, detail=None)
    assert found.figures["resolve_mm"] is not None
    contrast = np.full((1, 3), found.figures["contrast"])
    given = dict(f_number=np.array([2.8]), working_f_number=np.array([2.8]), blur_s=np.array([1e-3]))
    assert np.all(rows.smallest_bars_m(contrast, **given) < plain.smallest_bars_m(contrast, **given))
