"""Lamps have bodies: none may stand in another, in the port's, or with it in the view; search and margins agree."""

from __future__ import annotations

from typing import Any

import brute_force as brute
import numpy as np
import pytest
from agreement import agree
from one_of_each import one
from random_cases import ranked

from uwopt.errors import MissionError
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.assembly import system_problem
from uwopt.forward.lamp_views import bodies_fit, lamps_apart_m
from uwopt.forward.lamps import LampGroup, in_rows
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system

SIZE_M = 0.1
NEAR, BESIDE = 0.128, 0.132  # the dome's radius is 0.08 m, and half a lamp 0.05 m: 0.13 m from axis to axis


def counts(**vehicle: Any) -> set[int]:
    """Numbers of lamps of the designs that the search finds."""
    return {found.count for found in one(vehicle=vehicle, wanted={"min_snr_db": 5.0}).solve()[1].best}


@pytest.mark.parametrize(("baseline_m", "size_m", "fits"), [
    (NEAR, SIZE_M, False), (BESIDE, SIZE_M, True), (NEAR, 0.09, True), (NEAR, None, True),
])  # fmt: skip
def test_no_lamp_stands_in_the_port(baseline_m: float, size_m: float | None, fits: bool) -> None:
    assert bool(counts(light_baseline_m=baseline_m, light_count=2, lamp_size_m=size_m)) == fits


def test_lamps_of_a_side_stand_in_a_row_about_the_middle_of_the_port() -> None:
    row = in_rows(5, baseline_m=0.5, tilt_deg=10.0, spacing_m=0.1)
    expected = [(-0.1, 0.5), (-0.05, -0.5), (0.0, 0.5), (0.05, -0.5), (0.1, 0.5)]
    assert [(lamp.x_m, lamp.y_m) for lamp in row] == [pytest.approx(place) for place in expected]
    assert {(lamp.z_m, lamp.tilt_x_deg, lamp.tilt_y_deg) for lamp in row} == {(0.0, 0.0, 10.0)}


@pytest.mark.parametrize(("count", "size_m"), [(3, SIZE_M), (4, SIZE_M), (2, SIZE_M), (3, None)])
def test_more_than_two_lamps_with_bodies_stand_in_rows(count: int, size_m: float | None) -> None:
    vehicle = {"light_baseline_m": 0.5, "light_count": [count, max(count, 3)], "lamp_size_m": size_m}
    found = one(vehicle=vehicle, wanted={"min_snr_db": 5.0}).solve()[1].best
    assert count in {best.count for best in found}
    for best in found:
        rows = size_m is not None and best.count > 2
        assert len(best.lighting.mount.explicit) == (best.count if rows else 0)


def test_a_row_is_for_its_own_number_of_lamps() -> None:
    vehicle = {"light_baseline_m": 0.5, "light_count": [2, 3], "lamp_size_m": SIZE_M}
    problem = one(vehicle=vehicle).problem()
    beside, row = problem.mounts
    for mount, own in ((beside, 2), (row, 3)):
        groups = [LampGroup(0, mount, count) for count in (2, 3)]
        fits = {one.count for one in groups if bodies_fit(problem, port=np.array([0]), lit=one).all()}
        assert fits == {own}


def test_a_system_of_four_lamps_has_them_in_rows() -> None:
    scene = {"water": "II", "seafloor": 0.2, "depth_m": 30}
    carried = {"altitude_m": 2.0, "speed_m_s": 0.3, "light_count": 4, "light_baseline_m": 0.5, "lamp_size_m": SIZE_M}
    system = load_system(SYSTEM)
    for physics, apart_m in (("full", 0.1), ("paper", 0.0)):
        mission = load_mission({"practice": "bare", "physics": physics, "scene": scene, "vehicle": carried})
        _, hardware = system_problem(mission, system)
        assert lamps_apart_m(hardware.mount, 4) == pytest.approx(apart_m, abs=1e-12)


#: A camera with four lamps, of which nothing matters here but their number.
SYSTEM: dict[str, Any] = {
    "camera": {
        "resolution_x_px": 1000, "resolution_y_px": 800, "pixel_pitch_um": 5.0, "saturation_e": 10_000,
        "read_noise_e": 3.0, "quantum_efficiency": 0.5, "max_frame_rate_hz": 50.0,
    },
    "lens": {"focal_length_mm": 8, "f_number_min": 1.4, "f_number_max": 16},
    "port": {"geometry": "dome", "outer_radius_mm": 50, "thickness_mm": 5},
    "light": {"luminous_flux_lm": 10_000, "power_w": 100, "beam": "disc", "beam_half_angle_deg": 45},
    "light_count": 4, "orientation": "landscape", "settings": {"exposure_ms": 5.0, "f_number": 4.0},
}  # fmt: skip


def test_the_body_not_the_front_must_be_clear_of_the_view() -> None:
    # 1 m down the view is 0.54 m wide a side: 0.04 m beside it a front of 0.02 m is clear, half a body is not
    mounts = [{"y_m": 0.59, "z_m": 1.0}]
    for size_m, fits in ((None, True), (SIZE_M, False), (0.08, True)):
        case = one(
            vehicle={"light_mounts": mounts, "light_count": 1, "lamp_size_m": size_m},
            wanted={"refuse": ["lamp"], "min_snr_db": 5.0},
        )
        assert bool(case.solve()[1].best) == fits


def test_search_among_places_with_and_without_room_equals_enumeration() -> None:
    vehicle = {"light_baseline_m": [0.1, 0.15], "light_count": [1, 4], "lamp_size_m": SIZE_M}
    made = one(vehicle=vehicle, wanted={"min_snr_db": 5.0})
    found = ranked(brute.enumerate_all(brute.Bench(made.problem()), made.objective))
    assert found
    agree(made, made.solve()[1], found)


def test_physics_paper_has_no_bodies() -> None:
    vehicle = {"light_baseline_m": NEAR, "light_count": 2, "lamp_size_m": SIZE_M}
    assert one(vehicle=vehicle, wanted={"min_snr_db": 5.0}, physics="paper").solve()[1].best


def test_margins_tell_how_much_room_is_left() -> None:
    problem = one(vehicle={"light_baseline_m": 0.2, "light_count": 2, "lamp_size_m": SIZE_M}).problem()
    model = DesignModel(problem, next(iter(brute.buildable(problem))))
    margins = {m.requirement: float(m.margin[0]) for m in model.lamp_margins(0)}
    assert margins == {"lamp_beside_port_m": pytest.approx(0.07), "lamps_apart_m": pytest.approx(0.3)}


def fault_of(**vehicle: Any) -> str:
    scene = {"water": "II", "seafloor": 0.2, "depth_m": 30}
    carried = {"altitude_m": 2.0, "speed_m_s": 0.3, "lamp_size_m": SIZE_M, **vehicle}
    with pytest.raises(MissionError) as caught:
        check_physical(load_mission({"practice": "bare", "physics": "full", "scene": scene, "vehicle": carried}))
    return str(caught.value)


def test_mounts_in_one_another_are_named() -> None:
    told = fault_of(light_mounts=[{"y_m": 0.5}, {"y_m": 0.5, "x_m": 0.06}, {"y_m": -0.5}])
    assert "vehicle.light_mounts[1] is 0.06 m from light_mounts[0], less than lamp_size_m = 0.1 m" in told
    assert "light_mounts[2]" not in told
