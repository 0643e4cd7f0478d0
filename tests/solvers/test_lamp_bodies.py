"""Lamps have bodies: none may stand in another, in the port's, or with it in the view; search and margins agree."""

from __future__ import annotations

from typing import Any

import brute_force as brute
import pytest
from agreement import agree
from one_of_each import one
from random_cases import ranked

from uwopt.errors import MissionError
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.mission import load_mission

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


def test_at_one_baseline_two_lamps_have_room() -> None:
    assert counts(light_baseline_m=0.5, light_count=[2, 4], lamp_size_m=SIZE_M) == {2}
    assert not counts(light_baseline_m=0.5, light_count=3, lamp_size_m=SIZE_M)
    assert counts(light_baseline_m=0.5, light_count=3) == {3}


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
    assert "at one baseline no more than two lamps of lamp_size_m have room" in fault_of(light_count=3)
