"""Lobes that water widens, in the search: bounds hold where light was moved sideways, and so do waters in doubt."""

from __future__ import annotations

from typing import Any

import brute_force as brute
import numpy as np
import pytest
from one_of_each import one, with_parts
from random_cases import Case

from uwopt.forward.lamps import relative_spectrum
from uwopt.model import beam as beams
from uwopt.solvers.confidence.panels import best_scene
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.exact.imagers import enumerate_imagers
from uwopt.solvers.exact.light_tables import FieldTables

TURBID = {"water": "5C", "water_table": "measured"}
LAMPS = {
    "lobe of 20 deg": {"beam_angle_deg": 20.0}, "disc": {"beam": "disc", "beam_angle_deg": 30.0},
    "cone": {"beam": "cone", "beam_angle_deg": 24.0}, "wide lobe": {"beam_angle_deg": 110.0},
}  # fmt: skip
MOUNTS: dict[str, dict[str, Any]] = {
    "beside": {"light_baseline_m": 0.6}, "leaning out": {"light_baseline_m": 0.5, "light_tilt_deg": 25.0},
    "lowered": {"light_mounts": [{"x_m": 0.2, "y_m": 0.5, "z_m": 0.4, "tilt_y_deg": -10.0}]},
    "looking ahead": {"light_baseline_m": 0.6, "pitch_deg": 20.0},
}  # fmt: skip


def case_of(lamp: str, mount: str, **more: Any) -> Case:
    """Four lenses over a band of altitudes in turbid water."""
    made = one(
        light=LAMPS[lamp], scenes=(TURBID,), vehicle={"altitude_m": 1.5, "altitude_tolerance_m": 0.2, **MOUNTS[mount]},
        **more,
    )  # fmt: skip
    return with_parts(
        made, lenses=[{"focal_length_mm": f} for f in (5.0, 12.0, 25.0)], ports=[{"outer_radius_mm": 50.0}]
    )


@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("lamp", LAMPS)
def test_no_image_gets_more_light_than_its_bounds_where_lobes_are_widened(lamp: str, mount: str) -> None:
    problem = case_of(lamp, mount).problem()
    assert problem.contractions[0].multiple
    imagers = enumerate_imagers(problem)
    assert len(imagers)
    tables, rows = FieldTables(problem, imagers), np.arange(len(imagers))
    for lighting in tables.lightings:
        found = tables.exact(0, lighting, rows, veils="none").signal_e
        for altitude in range(len(problem.scenes[0].range_m)):
            assert np.all(tables.bound(0, lighting, altitude, rows) >= found[:, altitude] * (1 - 1e-9))


def test_the_best_in_turbid_water_is_that_of_enumeration() -> None:
    """Narrow lobes beside wide ones, an SNR over the frame: corners live from light that water moved there."""
    made = case_of("lobe of 20 deg", "beside", wanted={"min_snr_db": -5.0, "snr_at": "worst", "max_blur_px": 1.0})
    made = with_parts(made, lights=[{"beam_angle_deg": 60.0, "beam": "cosine-power", "price": 900.0}])
    outcome = made.solve(top=1)[1]
    bench = brute.Bench(made.problem())
    values = [brute.best_of(bench, hw, made.objective) for hw in brute.buildable(bench.problem)]
    best = min(values, key=lambda one_: one_.value)
    assert np.isfinite(best.value)
    assert outcome.best[0].minimised == pytest.approx(best.value, rel=1e-4)


def test_the_best_of_waters_has_the_brightest_lobe_of_all_and_the_faintest_that_is_sent_back() -> None:
    made = case_of("lobe of 20 deg", "beside")
    problem = made.problem()
    doubt = problem.mission.with_changes(doubt={"clarity": True, "lamp_leg": True, "other_water_table": 0.3}).doubt
    scenarios = Scenarios.drawn(problem.mission, problem.scenes, doubt, seed=2, count=12)
    states = [scenes[0] for scenes in scenarios.scenes]
    assert len({float(state.attenuation_per_m.max()) for state in states}) > 1
    best, own = best_scene(states), problem.beam(0, 0)
    spectrum = relative_spectrum(("generic-led", None), best.wavelength_nm)
    cos, lobe_rad = np.cos(np.linspace(0.0, 0.5 * np.pi, 100)), beams.half_power_angle_rad(own)
    for way_m, back in ((1.5, False), (0.7, True)):
        easiest = beams.intensity_per_sr(cos, best.widened_lobe(own, spectrum, way_m=way_m, back=back), way_m)
        each = [
            beams.intensity_per_sr(cos, state.widened_lobe(own, spectrum, way_m=way_m, back=back), way_m)
            for state in states
        ]
        assert np.any(np.ptp(each, axis=0) > 0.01 * np.mean(each, axis=0))
        if back:
            assert np.all(easiest <= np.array(each) * (1 + 1e-12))
            continue
        for state, there in zip(states, each, strict=True):  # with K in each colour, on the shortest way and on longer
            for length_m in (way_m, 1.4 * way_m):
                losses = [np.exp(-one_.lamp_leg_per_m(lobe_rad) * length_m) for one_ in (best, state)]
                light = [np.multiply.outer(*pair) for pair in zip((easiest, there), losses, strict=True)]
                assert np.all(light[0] >= light[1] * (1 - 1e-12))


def test_the_best_of_waters_sends_back_no_more_than_any_at_any_angle() -> None:
    problem = case_of("wide lobe", "beside").problem()
    doubt = problem.mission.with_changes(doubt={"clarity": True, "other_water_table": 0.3}).doubt
    scenarios = Scenarios.drawn(problem.mission, problem.scenes, doubt, seed=2, count=12)
    states = [scenes[0] for scenes in scenarios.scenes]
    best = best_scene(states)
    spectrum = relative_spectrum(("generic-led", None), best.wavelength_nm)
    for range_m in (0.3, 1.5, 40.0):
        easiest = best.sent_back(spectrum, range_m)[0]
        every = [state.sent_back(spectrum, range_m)[0] for state in states]
        assert easiest is not None
        values = np.array([one_.phase_per_sr for one_ in every if one_ is not None])
        assert len(values) == len(states) and np.all(easiest.phase_per_sr <= values * (1 + 1e-12))
        assert np.any(np.ptp(values, axis=0) > 1e-3 * values.mean(axis=0))
