"""Light scattered more than once in a scene: K by lobe, tables apart, and what a result says of thick water."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import uwopt
from uwopt.catalog.records import Curve
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.assembly import system_problem
from uwopt.forward.effects import orders_bound
from uwopt.forward.lamp_light import LampField
from uwopt.forward.lamps import LampGroup, LightOptics
from uwopt.forward.scene import SceneOptics, scatterers_of, scene_optics
from uwopt.forward.spectra import Contraction
from uwopt.forward.sun_light import SunField
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system
from uwopt.model.beam import cosine_power_beam
from uwopt.model.multiple import LOST_FACTORS, lamp_angle_rad
from uwopt.model.path_table import log_mean_transmission
from uwopt.model.phase_formulas import molecular_per_sr
from uwopt.model.scattering import look_up, share_beyond

CURVES = [{"mono": Curve((400.0, 700.0), (0.5, 0.5))}]


def scene_of(**scene: Any) -> SceneOptics:
    keys = {"water": "3C", "seafloor": 0.2, "depth_m": 50} | scene
    mission = load_mission(
        {
            "name": "m", "scene": keys, "vehicle": {"altitude_m": 2.0, "speed_m_s": 0},
            "requirements": {"frame_interval_s": 1.0},
        }
    )
    return scene_optics(mission.scene_view(0), paper=False, base_dir=Path())


def contraction_of(scene: SceneOptics, *half_angles_deg: float, multiple: bool = True) -> Contraction:
    optics = [LightOptics((cosine_power_beam(np.deg2rad(2 * half)),), "generic-led", None) for half in half_angles_deg]
    return Contraction(scene, optics, CURVES, multiple=multiple).reaching(4.0, 4.0)


def test_lamps_of_unlike_lobes_have_tables_of_their_own() -> None:
    scene = scene_of()
    both = contraction_of(scene, 15.0, 60.0, 15.0)
    assert both.spectrum_of.tolist() == [0, 1, 0]
    narrow, wide = (log_mean_transmission(both.table(n, 0, nearest_m=2.0), 2.0, 2.0) for n in (0, 1))
    alone = contraction_of(scene_of(), 60.0)
    assert wide == pytest.approx(log_mean_transmission(alone.table(0, 0, nearest_m=2.0), 2.0, 2.0), rel=1e-6)
    assert narrow < wide - 0.05


def test_attenuations_lie_between_absorption_and_c_and_grow_with_what_is_lost() -> None:
    scene = scene_of()
    made = contraction_of(scene, 10.0, 40.0, 70.0)
    a = scene.attenuation_per_m - sum(one.scattering_per_m for one in scene.scattering)
    k = np.stack([made.lamp_leg_per_m(n) for n in range(3)])
    assert np.all(a < k) and np.all(k < scene.attenuation_per_m) and np.all(np.diff(k, axis=0) < 0)
    veil = np.stack([made.veil_leg_per_m(way_m) for way_m in (0.5, 2.0, 8.0)])  # longer ways round bear more
    assert np.all(veil > a) and np.all(np.diff(veil, axis=0) > 0) and np.all(veil <= made.near_leg_per_m())
    for n in range(3):
        lamp, camera = made.back_legs_per_m(n)
        assert np.all(lamp >= 0.49 * a) and np.all(camera < scene.attenuation_per_m)


def test_the_veil_from_elsewhere_is_never_less_than_none() -> None:
    """However far the floor: what would go round is absorbed at last."""
    scene = scene_of()
    near, far = scene.near_leg_per_m(), scene.veil_leg_per_m(200.0)
    assert np.all(far <= near) and np.any(far == near) and np.any(scene.veil_leg_per_m(2.0) < near)


def test_single_scattering_is_what_the_scene_or_the_model_asks_for() -> None:
    for scene, multiple in ((scene_of(multiple_scattering=False), True), (scene_of(), False)):
        made = contraction_of(scene, 40.0, 60.0, multiple=multiple)
        assert made.spectrum_of.tolist() == [0, 0]
        assert made.lamp_leg_per_m(0) is scene.lamp_attenuation_per_m
        assert made.back_legs_per_m(0)[1] is scene.attenuation_per_m
        assert made.counting(False) is made


def test_what_orders_change_is_bounded_at_the_corners_too() -> None:
    """Lobes of 24 deg in rather clear water: corners live from what it moves there."""
    mission = load_mission({
        "name": "m", "scene": {"water": "IB", "seafloor": 0.2, "depth_m": 50}, "practice": "bare",
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0},
        "requirements": {"frame_interval_s": 1.0, "min_snr_db": 1.0, "snr_at": "worst_px"},
    })  # fmt: skip
    light = {
        "flux_lm": 4000, "power_w": 40, "spectrum": "generic-led", "beam": "cosine-power", "beam_half_angle_deg": 12,
    }  # fmt: skip
    system = load_system({
        "camera": {
            "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
            "quantum_efficiency": 0.5, "gain_dn_per_e": 0.35, "bit_depth": 12,
        },
        "lens": {"focal_length_mm": 6, "transmission": 0.85}, "light": light,
        "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10, "refractive_index": 1.5},
        "light_mounts": [{"x_m": 0, "y_m": 0.3}], "orientation": "landscape",
        "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": 4000},
    })  # fmt: skip
    model = DesignModel(*system_problem(mission, system))
    problem, view, hardware = model.problem, model.views[0], model.hardware
    many, once = (
        LampField(each, 0, port_index=hardware.port, lit=LampGroup(0, hardware.mount, 1), efficiency=0)
        for each in (problem, problem.with_effects(problem.effects.without(["multiple_scattering"])))
    )
    corner = view.tan_along[:, None], -view.tan_across[:, None]
    there = [field.at_pixels(view, *corner, veils=False)[0] for field in (many, once)]
    changed = float(np.max(np.abs(there[0] / there[1] - 1.0)))
    assert changed > 0.5
    assert orders_bound(many, once, view, many.light(view, veils="none").signal_e) >= changed


@pytest.mark.parametrize("water", ["IB", "II", "III", "1C", "3C", "5C"])
def test_the_page_on_water_has_the_attenuations_of_the_model(water: str) -> None:
    page = (Path(__file__).parents[2] / "docs" / "water.md").read_text(encoding="utf-8")
    row = next(line for line in page.splitlines() if line.startswith(f"| {water} | 0."))
    shown = [float(number) for number in row.replace(" to ", " | ").split("|")[2:-1]]
    scene = scene_of(water=water)
    least, most = (replace(scene, lamp_lost=factor, cache={}) for factor in LOST_FACTORS)
    a = scene.attenuation_per_m - sum(one.scattering_per_m for one in scene.scattering)
    backward = sum(one.scattering_per_m * one.share_beyond(np.pi / 2) for one in scene.scattering)
    lobes = [scene.lamp_leg_per_m(float(np.deg2rad(half))) for half in (20, 40, 60)]
    doubt = [one.lamp_leg_per_m(float(np.deg2rad(40))) for one in (least, most)]
    spectra = [a + backward, *lobes, *doubt, scene.diffuse_attenuation_per_m, scene.attenuation_per_m]
    found = [np.interp(530.0, scene.wavelength_nm, spectrum) for spectrum in spectra]
    assert shown == pytest.approx(found, abs=6e-4)  # rounded to 0.001 1/m


@pytest.mark.parametrize("half_deg", [10.0, 25.0, 40.0])
def test_doubt_of_what_is_lost_covers_the_phase_functions_of_the_sea(half_deg: float) -> None:
    # Fournier-Forand of b_b/b 0.005 to 0.03, over the default's 0.0183
    angle = float(lamp_angle_rad(np.deg2rad(half_deg)))
    low, usual, high = (
        share_beyond(angle, scatterers_of(np.array([530.0]), np.ones(1), load_scene(ratio), Path())[0].table)
        for ratio in (0.005, 0.0183, 0.03)
    )
    assert LOST_FACTORS[0] * 0.9 <= low / usual and high / usual <= LOST_FACTORS[1]


def test_daylight_in_murky_water_is_that_of_all_orders() -> None:
    # a ray straight down: B E_d / (2 pi mu) (1 - e^(-(a + K) d)) / (a + K), wavelength by wavelength
    sunny = {"sun_lux": 80_000.0, "depth_m": 6.0}
    field, plain = sun_field(**sunny), sun_field(**sunny, multiple_scattering=False)
    many, once = (float(one.path_electrons(np.array([2.0]), np.ones(1))[0]) for one in (field, plain))
    scene = field.scene
    a, kd = scene.absorption_per_m(), np.asarray(scene.diffuse_attenuation_per_m)
    back = sum(one.scattering_per_m * one.share_beyond(np.pi / 2) for one in scene.scattering)
    mu = np.sqrt(1 - (np.cos(np.deg2rad(60.0)) / scene.n_water) ** 2)
    phases = [molecular_per_sr(-mu) if one.table is None else look_up(-mu, one.table) for one in scene.scattering]
    turned = sum(one.scattering_per_m * float(p) for one, p in zip(scene.scattering, phases, strict=True))
    source = 0.897 * turned + 1.10 * np.maximum(kd / a - 1.0, 0.0) * back / (2 * np.pi)
    at_port = field.surface() * 0.95 * np.exp(-kd * 4.0)
    expected = field.electrons(source * at_port / mu * -np.expm1(-2.0 * (a + kd)) / (a + kd)).sum()
    assert many == pytest.approx(expected, rel=1e-9)
    assert many > 1.2 * once


def sun_field(**scene: Any) -> SunField:
    keys = {"water": "3C", "seafloor": 0.2, "depth_m": 50} | scene
    mission = load_mission(
        {
            "name": "m", "scene": keys, "vehicle": {"altitude_m": 2.0, "speed_m_s": 0},
            "requirements": {"frame_interval_s": 1.0},
        },
    )
    problem, hardware = system_problem(mission, load_system(system()))
    return SunField(problem, 0, port_index=hardware.port, efficiency=0)


def load_scene(ratio: float) -> Any:
    return scene_of(backscatter_ratio=ratio).view.scene


def system() -> dict[str, Any]:
    return {
        "camera": {"resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
                   "quantum_efficiency": 0.6, "gain_dn_per_e": 0.35, "bit_depth": 12},
        "lens": {"focal_length_mm": 8, "transmission": 0.9},
        "port": {"thickness_mm": 5, "refractive_index": 1.5, "geometry": "dome", "outer_radius_mm": 70},
        "light": {"flux_lm": 10_000, "power_w": 100, "spectrum": "generic-led", "beam": "cosine-power",
                  "beam_half_angle_deg": 40},
        "light_mounts": [{"y_m": 0.5}],
        "settings": {"f_number": 4.0, "exposure_ms": 10.0, "gain": 1.0, "flux_lm": 10_000},
    }  # fmt: skip


@pytest.mark.parametrize(("half_deg", "water", "warned"), [(40, "3C", False), (6, "3C", True), (6, "I", False)])
def test_a_result_says_that_lobes_are_beyond_those_tested(half_deg: float, water: str, warned: bool) -> None:
    # c at 550 nm of I is 0.06 1/m: 0.12 lengths at 2 m, where nothing of it matters
    lamp = system()
    lamp["light"]["beam_half_angle_deg"] = half_deg
    mission = {"name": "t", "physics": "full", "practice": "bare",
               "scene": {"water": water, "seafloor": 0.2, "depth_m": 50},
               "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 1.0}}  # fmt: skip
    assert ("untested_lobe" in str(uwopt.evaluate(mission, lamp).to_dict())) is warned


@pytest.mark.parametrize(("water", "orders", "warned"), [("9C", True, True), ("9C", False, False), ("II", True, False)])
def test_a_result_says_that_it_leaves_the_tested_range(water: str, orders: bool, warned: bool) -> None:
    # c at 550 nm of 9C is 3.4 1/m: 6.8 lengths at 2 m; of II 0.45: 0.9
    scene = {"water": water, "seafloor": 0.2, "depth_m": 50, "multiple_scattering": orders}
    mission = {"name": "t", "physics": "full", "practice": "bare", "scene": scene,
               "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 1.0}}  # fmt: skip
    notes = uwopt.evaluate(mission, system()).to_dict()
    assert ("thick_water" in str(notes)) is warned
