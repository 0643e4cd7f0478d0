"""Curves of a design: at the design's own place they are the figures, elsewhere the paper's equations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwopt.report.pictures.curves import (
    Operation,
    depth_of_field,
    operation_curves,
    rig_measures,
    spectrum_way,
)
from uwopt.report.pictures.design_pictures import light_picture
from uwopt.report.pictures.maps import channel_fields, image_points

PROBLEMS = Path(__file__).parents[2] / "problems"


@pytest.fixture(
    scope="module", params=["nui-acfr", "whoi-abe", "awi-ofobs", "paper-tank", "paper-tool-window"]
)
def case(request, replayed):
    return replayed(PROBLEMS / f"{request.param}.yaml", PROBLEMS / f"{request.param}.system.yaml")


def test_electrons_of_the_spectrum_are_the_image_forming_ones(case):
    design, figures = case
    way, model = spectrum_way(design), design.model
    scene = model.problem.scenes[0]
    if scene.paper:
        assert way.electrons == pytest.approx(figures["electrons_signal"], rel=1e-12)
    else:  # contracted another way; water's loss there comes from a table good to 1e-6
        centre = model.light_at_centre(0).signal_e[0, scene.nominal] * design.figures().light_x[0]
        assert way.electrons == pytest.approx(centre, rel=1e-6)


def test_flux_of_the_lamps_adds_up_to_their_lumens(case):
    design, _ = case
    way, scene = spectrum_way(design), design.model.problem.scenes[0]
    lights, settings = design.model.lights, design.settings[0]
    # what is on for a time gives lumens; a flash that fades with tau its lumen seconds over tau (1 - exp(-T / tau))
    flux = lights.full_light[0] * settings.level[0] * lights.output_factor[0] * design.model.hardware.count
    if lights.flash_duration_s[0] > 0 and lights.kind[0] == 2:
        tau, whole = lights.flash_decay_s[0], lights.flash_duration_s[0]
        flux /= whole if np.isinf(tau) else tau * (1.0 - np.exp(-whole / tau))
    lumens = 683.002 * np.trapezoid(way.source * scene.photopic, way.wavelength_nm)
    assert lumens == pytest.approx(flux, rel=1e-12)


def test_light_of_a_flash_is_said_to_be_that_of_its_peak(case):
    design, _ = case
    way, lights, settings = spectrum_way(design), design.model.lights, design.settings[0]
    tau, whole = float(lights.flash_decay_s[0]), float(lights.flash_duration_s[0])
    fades = lights.kind[0] == 2 and np.isfinite(tau)
    said = light_picture(way).caption
    assert ("at the peak of a flash" in said) is bool(fades)
    if fades:  # exp(-t / tau), as long as the shutter is open
        seconds = tau * -np.expm1(-min(float(settings.exposure_s[0]), whole) / tau)
        assert f"as many as {1e3 * seconds:.3g} ms at its peak would give" in said


def test_depth_of_field_goes_through_the_figures(case):
    design, figures = case
    curve = depth_of_field(design)
    # between the curve's points the reciprocals of the limits are linear in N to second order
    near = np.interp(curve.chosen_f_number, curve.f_number, 1 / curve.near_m)
    far = np.interp(curve.chosen_f_number, curve.f_number, 1 / curve.far_m)
    assert 1 / near == pytest.approx(figures["dof_near_m"], rel=1e-3)
    assert far == pytest.approx(0.0 if figures["dof_far_is_infinite"] else 1 / figures["dof_far_m"], abs=1e-3)
    assert np.all(np.diff(curve.near_m) < 0)
    assert np.all(np.diff(curve.near_by_focus_m) > 0)


def at_mission(curves: Operation, values: Any) -> float:
    row = int(np.argmin(np.abs(curves.altitude_m - curves.mission_altitude_m)))
    return float(values[row, int(np.argmin(np.abs(curves.speed_m_s - curves.mission_speed_m_s)))])


def test_rate_and_exposure_go_through_the_figures(case):
    design, figures = case
    curves = operation_curves(design)
    assert at_mission(curves, curves.frame_rate_hz) == pytest.approx(figures["frame_rate_min_hz"])
    if (
        figures["exposure_max_ms"] is not None
        and design.model.problem.scenes[0].view.requirements.max_blur_px
    ):
        assert at_mission(curves, curves.exposure_s) * 1e3 == pytest.approx(figures["exposure_max_ms"])
    assert np.all(np.diff(curves.frame_rate_hz, axis=0) <= 0)  # higher up, an image covers more


def test_channels_are_those_of_the_figures(replayed, colour_system):
    design, figures = replayed(PROBLEMS / "nui-acfr.yaml", colour_system)
    way = spectrum_way(design)
    mean = sum(weight * way.channel_electrons_per_nm[name] for name, weight in
               (("red", 0.25), ("green", 0.5), ("blue", 0.25)))  # fmt: skip
    assert way.electrons_per_nm == pytest.approx(mean)
    along, across = image_points(design, 24, 18)
    fields = channel_fields(design, along, across)
    red, green = (fields[name].signal_e.mean() for name in ("red", "green"))
    assert green / red == pytest.approx(figures["white_balance_red"], rel=1e-3)


def test_rig_is_drawn_from_the_figures(case):
    design, figures = case
    rig = rig_measures(design)
    sides = (2 * rig.half_along_m, 2 * rig.half_across_m)
    wanted = (figures["fov_x_m"], figures["fov_y_m"])
    assert sides == pytest.approx(wanted if rig.image_width_is_along else wanted[::-1])
    if rig.advance_m is not None:
        assert rig.overlap == pytest.approx(1 - rig.advance_m / sides[0])
        assert rig.overlap == pytest.approx(figures["overlap"])
