"""What a reading of the water does to the answer: as its type, monotone in clarity, and its range among the doubts."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from one_of_each import one
from random_cases import Case

import uwopt
from uwopt.api.common import base_result
from uwopt.forward.scene import scene_optics
from uwopt.mission.mission import load_mission
from uwopt.report.text.doubts import robustness_block
from uwopt.solvers.explain.assumptions import assumptions
from uwopt.solvers.explain.other_waters import in_other_waters
from uwopt.solvers.recommend import Sought

C_PER_M = {
    "IB": 0.0519 + 0.124,
    "III": 0.0806 + 0.291,
    "1C": 0.0948 + 0.432,
}  # at 530 nm, Williamson and Hollins (2022)
STRONG = {"dim_min_frac": 0.0001, "flux_lm": 3e6, "power_w": 30_000.0}


def case(**scene: Any) -> Case:
    """One design whose power says how much light the water takes."""
    return one(light=STRONG, wanted={"max_blur_px": 1.0}, scenes=({"water": None, **scene},))


def power_w(**scene: Any) -> float:
    return float(case(**scene).solve()[1].best[0].minimised)


@cache
def sought(key: str, value: float) -> Sought:
    search, outcome = case(**{key: value}).solve(top=1)
    return Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", C_PER_M)
def test_the_attenuation_of_a_type_gives_the_answer_of_that_type(name: str):
    assert power_w(c_per_m=C_PER_M[name]) == pytest.approx(power_w(water=name), rel=1e-6)


@pytest.mark.parametrize(
    ("key", "clearest_first"),
    [("c_per_m", (0.06, 0.2, 0.5, 1.0)), ("visibility_m", (40.0, 15.0, 8.0, 5.0)),
     ("secchi_m", (40.0, 20.0, 12.0, 8.0)), ("turbidity_ntu", (0.05, 0.2, 0.5, 1.0))],
)  # fmt: skip
def test_clearer_water_takes_less_light(key: str, clearest_first: tuple[float, ...]):
    powers = [power_w(**{key: value}) for value in clearest_first]
    assert powers == sorted(powers)
    assert powers[-1] > powers[0]


def test_the_same_water_by_three_readings_gives_one_answer():
    # 1C: c 0.0948 + 0.432 = 0.5268; K_d 0.1266: visibility 4.8 / c = 9.11 m; Secchi 8.69 / (c + K_d) = 13.3 m
    by_c, visibility, secchi = (
        power_w(c_per_m=0.5268),
        power_w(visibility_m=9.1116),
        power_w(secchi_m=13.2999),
    )
    assert (visibility, secchi) == pytest.approx((by_c, by_c), rel=1e-4)


def test_the_ends_of_a_reading_are_solved_again():
    # 4.1 / 10 m = 0.41, 5.5 / 10 m = 0.55
    found = sought("visibility_m", 10.0)
    told = in_other_waters(found)[:2]
    ends = [entry["case"]["reading"] for entry in told]
    assert ends[0] == "clearest water that fits visibility_m 10 (c = 0.41 1/m at 530 nm)"
    assert ends[1] == "murkiest water that fits visibility_m 10 (c = 0.55 1/m at 530 nm)"
    values = [entry["objective_value"] for entry in told]
    assert values == pytest.approx([power_w(c_per_m=0.41), power_w(c_per_m=0.55)], rel=1e-9)


def test_a_type_has_no_ends_of_a_reading():
    search, outcome = case(water="II").solve(top=1)
    found = Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]
    assert not [w for w in in_other_waters(found) if "reading" in w["case"]]


def test_the_other_table_is_tried_with_the_same_reading():
    cases = [entry["case"] for entry in in_other_waters(sought("c_per_m", 0.5))]
    assert {"solonenko-mobley", "measured"} == {one["water_table"] for one in cases}


def test_a_clearer_scene_leaves_the_others_as_they_are():
    mission = load_mission(
        {
            "practice": "bare", "scenes": [
                {"water": "II", "seafloor": 0.2, "depth_m": 30, "name": "a"},
                {"secchi_m": 10, "seafloor": 0.2, "depth_m": 30, "name": "b"},
            ],
            "vehicle": {"altitude_m": 2, "speed_m_s": 0.3},
        }
    )
    plain, read = (scene_optics(view, paper=False, water_end="high") for view in mission.views)
    assert plain.clarity is None and read.clarity is not None
    assert read.attenuation_per_m[300] > scene_optics(mission.views[1], paper=False).attenuation_per_m[300]


def test_the_result_names_the_water_given_and_derived():
    found = sought("visibility_m", 10.0)
    result = base_result("solve", found.problem.mission, case(visibility_m=10.0).objective, found.problem)
    water = result.to_dict()["physics"]["waters"][0]
    assert (water["scene"], water["key"], water["given"]) == ("scene 0", "visibility_m", 10.0)
    assert [water[k] for k in ("c_per_m", "c_low_per_m", "c_high_per_m")] == pytest.approx([0.48, 0.41, 0.55])
    assert "Davies-Colley 1988 doi:10.4319/lo.1988.33.4.0616" in water["source"]
    assert result.to_dict()["mission"]["scenes"][0]["visibility_m"] == 10.0


def test_the_assumptions_hold_relation_range_and_what_is_measured_best():
    found = sought("visibility_m", 10.0)
    told = assumptions(found.problem, found.outcome.best[0])
    made = next(item for item in told if item.path == "scene 0: visibility_m")
    assert (made.value, made.low, made.high) == pytest.approx((0.48, 0.41, 0.55))
    assert (made.unit, made.status) == ("1/m", "derived")
    assert "measure c at 530 nm with a transmissometer" in made.source


def test_the_text_says_what_to_measure():
    found = sought("visibility_m", 10.0)
    result = base_result("solve", found.problem.mission, case(visibility_m=10.0).objective, found.problem)
    doubts = {"waters": in_other_waters(found)[:1]}
    assert "transmissometer" in repr(robustness_block(replace(result, robustness=doubts)))


def test_evaluate_takes_a_reading_and_says_so():
    mission = {
        "practice": "bare", "scene": {"secchi_m": 10, "seafloor": 0.2, "depth_m": 30},
        "vehicle": {"altitude_m": 2, "speed_m_s": 0.3}, "requirements": {"overlap": 0.3},
    }  # fmt: skip
    system = {
        "camera": {"resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
                   "quantum_efficiency": 0.6, "gain_dn_per_e": 0.35, "bit_depth": 12},
        "lens": {"focal_length_mm": 8.0, "transmission": 0.9},
        "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10, "refractive_index": 1.5},
        "light": {"flux_lm": 4000, "power_w": 40, "spectrum": "generic-led", "beam": "cosine-power",
                  "beam_half_angle_deg": 40},
        "light_mounts": [{"x_m": 0.0, "y_m": 0.5, "z_m": 0.0}],
        "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": 4000},
    }  # fmt: skip
    found = uwopt.evaluate(mission, system)
    water = found.physics.waters[0]
    assert (water.key, water.given) == ("secchi_m", 10.0)
    assert water.c_low_per_m < water.c_per_m < water.c_high_per_m
