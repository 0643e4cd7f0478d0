"""A design's light, worked out in parts, is the light worked out at once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import uwopt
from uwopt.api.common import prepared
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.assembly import system_problem
from uwopt.forward.lamp_light import LampField, image_light, kind_of_field
from uwopt.forward.remembered import LoneField, RememberedField
from uwopt.forward.views import Views
from uwopt.mission.system import load_system

PROBLEMS = Path(__file__).parents[2] / "problems"


def tank(tolerance_m: float = 0.0) -> DesignModel:
    """The system of the tank in its mission, at altitudes so far from its own."""
    written = yaml.safe_load((PROBLEMS / "paper-tank.yaml").read_text(encoding="utf-8"))
    written["vehicle"]["altitude_tolerance_m"] = tolerance_m
    mission = prepared(written, "full", None)
    return DesignModel(*system_problem(mission, load_system(PROBLEMS / "paper-tank.system.yaml")))


def test_light_with_pixels_has_the_means_and_pixels_of_light_taken_at_once() -> None:
    model = tank()
    hardware = model.hardware
    at_once = image_light(
        model.problem,
        0,
        model.views[0],
        np.array([hardware.camera]),
        port_index=hardware.port,
        lit=model.lit,
        pixels="darkest",
    ).scaled(model.lights.output_factor)
    in_parts = model.image_light(0, pixels="darkest")
    for name in ("signal_e", "forward_e", "backscatter_e", "worst_e", "worst_veil_e"):
        assert np.array_equal(getattr(in_parts, name), getattr(at_once, name)), name
    assert in_parts.worst_e is not None
    assert in_parts.worst_e.min() < in_parts.signal_e.min()  # pixels and mean differ here


@pytest.mark.parametrize(("asked", "figure"), [("worst", "snr_db_p05"), ("worst_px", "snr_db_min")])
@pytest.mark.parametrize("sun_lux", [None, 3000.0])
def test_pixels_at_the_nominal_altitude_are_those_that_a_mission_asks_for_at_all(asked, figure, sun_lux) -> None:
    # who asks for them has them at every altitude of 5 +- 1 m; who does not, at 5 m alone
    mission = yaml.safe_load((PROBLEMS / "whoi-abe.yaml").read_text(encoding="utf-8"))
    mission["vehicle"]["altitude_tolerance_m"] = 1.0
    mission["scene"] |= {} if sun_lux is None else {"sun_lux": sun_lux, "depth_m": 15.0}

    def told(needs: dict[str, str]) -> dict[str, float]:
        varied = mission | {"requirements": mission["requirements"] | needs}
        return uwopt.evaluate(varied, PROBLEMS / "whoi-abe.system.yaml").design.scenes[0].figures

    plain, every = told({}), told({"snr_at": asked})
    assert plain[figure] == pytest.approx(every[figure], rel=1e-12)
    assert plain[figure] < plain["snr_db"] - 0.5


def test_pixels_that_were_asked_for_at_one_altitude_are_asked_for_again_at_all() -> None:
    # the nominal altitude alone first; then all of them, of the same image in the same scene
    model = tank(tolerance_m=0.1)
    hardware, scene = model.hardware, model.problem.scenes[0]

    def frame(kind: type[LampField], altitude: int | None) -> np.ndarray[Any, Any]:
        light = image_light(
            model.problem, 0, model.views[0], np.array([hardware.camera]), port_index=hardware.port, lit=model.lit,
            pixels="frame", means=False, field_type=kind, altitude=altitude,
        )  # fmt: skip
        assert light.worst_e is not None
        return light.worst_e.min(axis=2)

    plain, at = frame(LampField, None), scene.nominal
    assert not np.allclose(plain[0, 0], plain[0, -1], rtol=1e-3)
    assert frame(LoneField, at)[0, at] == pytest.approx(plain[0, at], rel=1e-12)
    assert frame(LoneField, None) == pytest.approx(plain, rel=1e-12)


#: Three metres of murky water before a wide lens behind a dome, under lamps of a wide lobe.
MURKY: dict[str, Any] = {
    "practice": "bare", "scene": {"water": "1C", "seafloor": 0.2, "depth_m": 100},
    "vehicle": {"altitude_m": 3.0, "speed_m_s": 0.5, "light_count": 2, "light_baseline_m": 0.8},
    "requirements": {"overlap": 0.3},
}  # fmt: skip
WIDE: dict[str, Any] = {
    "camera": {"resolution_x_px": 2000, "resolution_y_px": 2000, "pixel_pitch_um": 5.0, "read_noise_e": 5.0,
               "quantum_efficiency": 0.5, "bit_depth": 12, "max_frame_rate_hz": 10.0, "power_w": 4.0},
    "lens": {"focal_length_mm": 6.0, "f_number_min": 1.4, "f_number_max": 16.0},
    "port": {"geometry": "dome", "radius_mm": 75.0, "thickness_mm": 7.5},
    "light": {"kind": "continuous", "flux_lm": 10_000, "power_w": 100.0, "beam": "cosine-power",
              "beam_half_angle_deg": 45.0},
    "light_count": 2, "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0},
}  # fmt: skip


def test_pixels_of_an_image_are_the_same_whatever_image_is_worked_out_beside_it() -> None:
    """In murky water a search and the evaluation of its design differed by 5e-6 of the veil: a wider image stood by."""
    model = DesignModel(*system_problem(prepared(MURKY, "full", None), load_system(WIDE)))
    problem, hardware, view = model.problem, model.hardware, model.views[0]
    kind, efficiency = kind_of_field(problem, model.lit.optics, LampField), int(model.cameras.qe_index[0])
    field = kind(problem, 0, port_index=hardware.port, lit=model.lit, efficiency=efficiency)
    narrow, wide = (np.linspace(0.0, end, 7) for end in (0.1, 0.8))
    _, alone = field.at_pixels(view, narrow[None], narrow[None], veils=True)
    _, beside = field.at_pixels(view.take(np.array([0, 0])), *2 * [np.stack([narrow, wide])], veils=True)
    assert alone is not None and beside is not None
    assert beside[0] == pytest.approx(alone[0], rel=1e-11)


def test_light_of_a_design_is_that_of_its_image_alone_whatever_was_searched_before() -> None:
    """A mean's nodes are those of all images in one integral: a wider one beside it moves it by some 1e-6."""

    def mean(kind: type[RememberedField], model: DesignModel, view: Views) -> Any:
        lit, efficiency = model.lit, int(model.cameras.qe_index[0])
        field = kind(model.problem, 0, port_index=model.hardware.port, lit=lit, efficiency=efficiency)
        return field.mean_backscatter(view)[0]

    fresh, searched = (DesignModel(*system_problem(prepared(MURKY, "full", None), load_system(WIDE))) for _ in "ab")
    view = searched.views[0]
    two = view.take(np.array([0, 0]))
    wider = replace(two, **{name: getattr(two, name) * np.array([1.0, 1.5]) for name in ("tan_along", "tan_across")})
    beside, alone = mean(RememberedField, searched, wider), mean(LoneField, fresh, fresh.views[0])
    assert np.array_equal(mean(LoneField, searched, view), alone)
    assert 1e-9 < abs(beside[0] / alone[0] - 1.0) < 1e-4
