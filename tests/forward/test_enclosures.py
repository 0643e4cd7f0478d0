"""Ports in housings: what goes on what, and what an enclosure costs, weighs and bears."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from uwopt.catalog.choose import select
from uwopt.catalog.load import read_catalog
from uwopt.catalog.parts.doubts import taken_as
from uwopt.catalog.records import Camera, Curve, Housing, Lens, Light, Port, Quantity, exact
from uwopt.errors import MissionError
from uwopt.evaluation.bill import bill_of_materials
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import Hardware
from uwopt.forward.enclosures import (
    beaten,
    camera_with_size,
    enclosed,
    fits_inside,
    lens_with_size,
    takes,
    tight_at_worst,
)
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.mission.mission import load_mission
from uwopt.mission.practice import with_practice
from uwopt.report.order.tender_lines import room_at_limits
from uwopt.solvers.explain.specification import PropertyLimit

CATALOG = read_catalog()
MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "paper", "scene": {"water": "II", "seafloor": 0.2, "depth_m": 100.0},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "camera_count": 2}, "requirements": {"overlap": 0.3},
    "catalog": {"housing": "required"},
}  # fmt: skip
PORT = Port(
    "dome", geometry="dome", outer_radius_mm=50.0, thickness_mm=exact(5.0), price=exact(200.0), mass_g=exact(300.0),
    depth_rating_m=1000.0,
)  # fmt: skip
TUBE = Housing(
    "tube", inner_diameter_mm=100.0, inner_length_mm=250.0, outer_diameter_mm=exact(110.0),
    outer_length_mm=exact(300.0), price=exact(700.0), mass_g=exact(2500.0), depth_rating_m=300.0, ports=("dome",),
)  # fmt: skip

GUESS = exact(90.0, "estimated", "0.8 of its size")  # of a clear width: that of a hemisphere all the same


def model(port: Port, mission: dict[str, Any] = MISSION) -> DesignModel:
    """One design behind a port."""
    camera = Camera(
        "camera", resolution_x_px=2000, resolution_y_px=1000, pixel_pitch_um=5.0, mounts=("C",), inline=True,
        qe_curves={"mono": Curve((380.0, 780.0), (0.5, 0.5))}, read_noise_e=exact(5.0), saturation_e=exact(1e4),
        price=exact(1000.0), mass_g=exact(100.0), interface="USB3",
    )  # fmt: skip
    lens = Lens("lens", focal_length_mm=10.0, price=exact(300.0), mass_g=exact(80.0), inline=True)
    lamp = Light("lamp", flux_lm=exact(1e4), power_w=exact(100.0), beam_angle_deg=exact(80.0), depth_rating_m=500.0)
    problem = Problem(load_mission(mission), Parts((camera,), (lens,), (port,), (lamp,)), paper=True)
    return DesignModel(problem, Hardware(0, 0, 0, True, 0, 1, problem.mounts[0]))


def test_port_goes_where_it_is_named_and_on_ends_made_for_it_unless_it_is_wider():
    other, any_end = replace(TUBE, ports=("acme*",)), replace(TUBE, ports=("any",))
    assert takes(TUBE, PORT) and not takes(other, PORT)
    assert takes(any_end, PORT)  # 100 mm on 110 mm
    assert not takes(any_end, replace(PORT, outer_radius_mm=56.0))
    assert takes(any_end, replace(PORT, outer_radius_mm=56.0, clear_diameter_mm=90.0))
    assert [one.enclosure_id for one in enclosed([PORT], [TUBE, other, any_end])] == ["dome in tube", "dome in tube"]


def test_enclosure_costs_and_weighs_as_port_and_housing():
    bare, built = model(PORT), model(replace(PORT, housing=TUBE))
    for name, each in (("cost", 700.0), ("mass_kg", 2.5)):
        figures = [one.totals(one.figures(0, one.settings(0, given()), information=False)) for one in (bare, built)]
        assert figures[1][name][0] - figures[0][name][0] == pytest.approx(2 * each)  # of two cameras


def given() -> Any:
    """Any settings."""
    from uwopt.forward.designs import SceneSettings

    return SceneSettings(gain=1.0)


def test_rating_of_an_enclosure_is_the_least_of_port_and_housing():
    built = model(replace(PORT, housing=TUBE))
    margins = built.margins(0, (rows := built.settings(0, given())), built.figures(0, rows, information=False))
    ratings = {m.requirement: float(m.value[0]) for m in margins if m.requirement.startswith("depth_rating_m")}
    assert ratings == {"depth_rating_m (dome)": 1000.0, "depth_rating_m (tube)": 300.0, "depth_rating_m (lamp)": 500.0}


def test_bill_names_a_housing_for_each_camera():
    built = model(replace(PORT, housing=TUBE))
    (row,) = [row for row in bill_of_materials(built.problem, built.hardware) if row.kind == "housing"]
    assert (row.id, row.count, row.unit_price) == ("tube", 2, 700.0)


def test_mass_in_water_and_size_of_a_tube_with_a_dome():
    # 2 x (0.1 + 0.08 + 0.3 + 2.5 kg less 1025 kg/m3 x (pi / 4 0.11^2 0.3 + 2 / 3 pi 0.05^3 m3)) = -0.421 kg
    built = model(replace(PORT, housing=TUBE))
    assert built.mass_in_water_kg()[0] == pytest.approx(2 * (2.98 - 1025 * (0.00285100 + 0.00026180)), rel=1e-4)
    ports = built.problem.ports
    assert (ports.outer_length_m[0], ports.outer_diameter_m[0]) == pytest.approx((0.350, 0.110))


def test_a_spherical_cap_stands_out_less_than_a_hemisphere_and_displaces_less():
    # 45 mm inside, open over 54 mm: the middle lies sqrt(45^2 - 27^2) = 36 mm behind the rim, the cap is 14 mm high
    # and displaces pi 14^2 (3 50 - 14) / 3 = 27 914 mm3
    built = model(replace(PORT, clear_diameter_mm=54.0, housing=TUBE))
    assert built.mass_in_water_kg()[0] == pytest.approx(2 * (2.98 - 1025 * (0.00285100 + 0.0000279140)), abs=5e-5)
    assert built.problem.ports.outer_length_m[0] == pytest.approx(0.314)
    assert built.problem.ports.rim_gap_m[0] == pytest.approx(0.036)


def test_a_battery_in_its_own_housing_is_no_mass_in_water_of_the_cameras():
    vehicle = {**MISSION["vehicle"], "duration_h": 10.0, "battery_wh": 2000.0, "supply": "battery"}
    asked = {**MISSION, "vehicle": vehicle, "catalog": {"housing": "required", "rest": "estimate"}}
    built = model(replace(PORT, housing=TUBE), asked)
    assert any(item.id == "rest-battery" for item in built.problem.rest)
    assert built.mass_in_water_kg()[0] == pytest.approx(2 * (2.98 - 1025 * (0.00285100 + 0.00026180)), rel=1e-4)


def test_needless_is_what_another_housing_that_fits_does_for_no_more():
    # Prices 3, 1, 2 and masses 1, 2, 2 of housings a, b, c: b makes c needless where it fits; a is the lightest.
    fits = np.array([[True, True, True], [True, False, True], [False, True, False]])
    price, mass = np.array([3.0, 1.0, 2.0]), np.array([1.0, 2.0, 2.0])
    left_out = beaten(fits, [price, mass], ["a", "b", "c"])
    assert left_out.tolist() == [[False, False, True], [False, False, False], [False, False, False]]
    alike = beaten(np.ones((1, 2), bool), [np.ones(2)], ["a", "b"])
    assert alike.tolist() == [[False, True]]  # of two alike one stays
    variants = beaten(np.ones((1, 2), bool), [np.array([1.0, 2.0])], ["a", "a"])
    assert not variants.any()  # the same housing at two prices


def test_needless_of_many_pairs_is_that_of_each() -> None:
    """A hundred housings, more than bits of a word; pairs fit into some of them, many pairs into the same."""
    rng = np.random.default_rng(3)
    fits = (rng.random((12, 100)) < 0.3)[rng.integers(12, size=400)]
    worth, names = [rng.integers(1, 6, 100).astype(float) for _ in range(2)], [f"h{k // 2}" for k in range(100)]
    together = beaten(fits, worth, names)
    for pair in range(0, 400, 23):
        assert together[pair].tolist() == beaten(fits[pair : pair + 1], worth, names)[0].tolist()
    price, mass = worth
    for pair, one in np.argwhere(fits)[::97]:
        rivals = [k for k in np.flatnonzero(fits[pair]) if names[k] != names[one]]
        better = [k for k in rivals if price[k] <= price[one] and mass[k] <= mass[one]
                  and (price[k] < price[one] or mass[k] < mass[one] or k < one)]  # fmt: skip
        assert bool(together[pair, one]) == bool(better)


def test_port_of_a_photo_housing_has_a_housing_of_its_own():
    (bare,) = enclosed([replace(PORT, mount="nauticam-n120")], [TUBE, replace(TUBE, ports=("any",))])
    assert bare.housing is None


def test_sizes_that_nobody_states_are_those_of_the_class_and_inline_ones_are_not_checked():
    bare = Camera("camera", interface="USB3")
    assert camera_with_size(bare).body_width_mm.value == 29.0
    assert camera_with_size(replace(bare, body_width_mm=exact(44.0))).body_width_mm.value == 44.0
    assert camera_with_size(replace(bare, inline=True)).body_width_mm is None
    lens = lens_with_size(Lens("lens", length_mm=exact(60.0)))
    assert (lens.length_mm.value, lens.pupil_mm.value) == (60.0, 24.0)  # two fifths of the length


def test_housing_that_is_too_shallow_is_left_out():
    chosen = select(CATALOG, {"generic": "allow"}, required_depth_m=2000.0).housings
    assert {housing.depth_rating_m for housing in chosen} == {3000.0, 7000.0}


def test_enclosure_of_the_first_generation_weighs_in_water_as_its_maker_says():
    # Blue Robotics, 2 in series: 500 g in air, -326 g in fresh water; 322 mm long and 57.2 mm wide
    housing = CATALOG.part("blue-robotics-2-in-enclosure-first-generation", "housing")
    assert isinstance(housing, Housing)
    displaced_g = 1e-3 * 0.7854 * housing.outer_diameter_mm.value**2 * housing.outer_length_mm.value
    assert housing.mass_g.value - displaced_g == pytest.approx(-326.0, abs=3.0)


def test_walls_of_housings_to_be_made_grow_with_depth():
    walls = [CATALOG.part(f"generic-housing-titanium-110x250-{m}m").wall_mm.value for m in (3000, 7000)]
    assert 6.0 < walls[0] < walls[1] < 10.0


def test_good_practice_asks_for_housings_unless_they_are_among_the_extras():
    mission = {"practice": "recommended", "vehicle": {}}
    assert with_practice(mission)["catalog"]["housing"] == "required"
    for name, wanted in (("Pressure housing", None), ("cables", "required")):
        made = with_practice({**mission, "catalog": {"extras": [{"name": name}]}})
        assert made["catalog"].get("housing") == wanted


def test_limits_of_a_housing_need_one():
    asked = {**MISSION, "catalog": {}, "limits": {"size_mm": 400, "diameter_mm": 200, "mass_water_kg": 2}}
    with pytest.raises(MissionError) as told:
        load_mission(asked)
    assert len(told.value.faults) == 3
    assert "limits.size_mm is of the housing; add catalog.housing: required" in str(told.value)


@pytest.mark.parametrize(
    ("changes", "flange_usd"),
    [
        ({}, None),  # a dome of 100 mm on a tube of 110 mm
        ({"outer_radius_mm": 60.0, "clear_diameter_mm": GUESS}, 400.0 * (120 / 200) ** 2),  # to 300 m
        ({"outer_radius_mm": 60.0, "clear_diameter_mm": 90.0}, None),  # a cap: 2 sqrt(60^2 - 55^2 + 45^2) = 102 mm wide
        ({"outer_radius_mm": 60.0, "id": "acme-dome"}, None),  # named: it has its own
    ],
)
def test_a_dome_that_is_wider_than_its_tube_stands_on_a_flange_that_is_paid_for(changes: Any, flange_usd: float | None):
    tube = replace(TUBE, ports=("any", "acme*"))
    bare = model(replace(PORT, **changes))
    built = model(replace(PORT, **changes, housing=tube))
    extra = float(built.problem.ports.price[0] - bare.problem.ports.price[0]) - 700.0
    rows = [row for row in bill_of_materials(built.problem, built.hardware) if row.id == "adapter-flange"]
    assert extra == pytest.approx(flange_usd or 0.0)
    paid = [] if flange_usd is None else [(2, pytest.approx(flange_usd))]
    assert [(row.count, row.unit_price) for row in rows] == paid


@pytest.mark.parametrize(("to_be_made", "width_mm", "length_mm"), [(False, 46.43, 111.0), (True, 56.31, 151.0)])
def test_a_housing_to_be_made_is_ordered_for_the_largest_camera(
    to_be_made: bool, width_mm: float, length_mm: float
) -> None:
    # by hand: 40 - 16 behind the pupil, body and plug, 2 of clearance: 24 + 40 + 45 + 2, at most 24 + 55 + 70 + 2;
    # across sqrt(30^2 + 30^2) + 4, at most sqrt(37^2 + 37^2) + 4
    tube = replace(TUBE, inner_length_mm=150.0, generic=to_be_made)
    built = model(replace(PORT, housing=tube))
    parts = built.problem.parts
    camera = replace(
        parts.cameras[0], body_width_mm=Quantity(30.0, 29.0, 37.0), body_height_mm=Quantity(30.0, 29.0, 37.0),
        body_length_mm=Quantity(40.0, 30.0, 55.0), plug_mm=Quantity(45.0, 25.0, 70.0),
    )  # fmt: skip
    lens = replace(parts.lenses[0], length_mm=exact(40.0), diameter_mm=exact(30.0), pupil_mm=exact(16.0))
    problem = Problem(built.problem.mission, replace(parts, cameras=(camera,), lenses=(lens,)), paper=True)
    sized = DesignModel(problem, built.hardware)
    needed = {row.requirement: float(row.value[0]) for row in sized.housing_margins()}
    assert needed["housing_length_mm"] == pytest.approx(length_mm)
    assert needed["housing_diameter_mm"] == pytest.approx(width_mm, abs=0.02)
    fits = fits_inside(problem.cameras, problem.lenses, 0.0, problem.ports)
    assert fits.item() is not to_be_made  # 151 mm do not go into 150
    told = tight_at_worst(camera, lens, 0.0, problem.ports)
    assert told["housing_length_mm"] == pytest.approx((0.151, 0.15))


@pytest.mark.parametrize(("to_be_made", "length_mm", "radius_mm"), [(False, 111.0, 23.93), (True, 117.0, 28.63)])
def test_a_housing_to_be_made_has_room_wherever_the_pupil_lies(
    to_be_made: bool, length_mm: float, radius_mm: float
) -> None:
    # by hand: 40 - 16 + 40 + 45 + 2 behind the pupil, at most 40 - 10; ahead sqrt(15^2 + 16^2) + 2, at most of 22
    built = model(replace(PORT, housing=replace(TUBE, inner_length_mm=115.0, generic=to_be_made)))
    parts = built.problem.parts
    camera = replace(
        parts.cameras[0], body_width_mm=exact(20.0), body_height_mm=exact(20.0), body_length_mm=exact(40.0),
        plug_mm=exact(45.0),
    )  # fmt: skip
    lens = replace(
        parts.lenses[0], length_mm=exact(40.0), diameter_mm=exact(30.0), pupil_mm=Quantity(16.0, 10.0, 22.0)
    )
    problem = Problem(built.problem.mission, replace(parts, cameras=(camera,), lenses=(lens,)), paper=True)
    needed = {row.requirement: float(row.value[0]) for row in DesignModel(problem, built.hardware).housing_margins()}
    assert needed["housing_length_mm"] == pytest.approx(length_mm)
    assert needed["dome_radius_mm"] == pytest.approx(radius_mm, abs=0.01)
    assert fits_inside(problem.cameras, problem.lenses, 0.0, problem.ports).item() is not to_be_made
    assert tight_at_worst(camera, lens, 0.0, problem.ports)["housing_length_mm"] == pytest.approx((0.117, 0.115))


@pytest.mark.parametrize(("lens_mm", "asked_mm"), [(80.0, 84.0), (None, 74.7107), (300.0, 90.0)])
def test_a_housing_is_asked_for_with_room_for_what_other_makers_may_send(
    lens_mm: float | None, asked_mm: float
) -> None:
    """Makers of a lander were told of a lens of 74.8 mm at most, and of a housing of 50 mm inside at least."""
    built = model(replace(PORT, housing=replace(TUBE, inner_length_mm=150.0, inner_diameter_mm=90.0)))
    parts = built.problem.parts
    body = {name: exact(size) for name, size in (
        ("body_width_mm", 29.0), ("body_height_mm", 29.0), ("body_length_mm", 40.0), ("plug_mm", 45.0),
    )}  # fmt: skip
    camera = replace(parts.cameras[0], **body)
    lens = replace(parts.lenses[0], length_mm=exact(40.0), diameter_mm=exact(30.0), pupil_mm=exact(16.0))
    problem = Problem(built.problem.mission, replace(parts, cameras=(camera,), lenses=(lens,)), paper=True)

    def told(kind: Any, **most: float | None) -> list[PropertyLimit]:
        return [PropertyLimit(kind, name, 1.0, False, 400.0, None, size) for name, size in most.items()]

    found = {
        "camera": told("camera", body_width_mm=50.0, body_height_mm=50.0, plug_mm=None, power_w=5.0),
        "lens": told("lens", diameter_mm=lens_mm, length_mm=60.0),
    }
    room = room_at_limits(DesignModel(problem, built.hardware), found)
    # by hand: across the lens, else across the corners of the body, sqrt(50^2 + 50^2), and 4; no more than there is
    assert room["housing_diameter_mm"] == pytest.approx(asked_mm, abs=1e-3)
    assert room["housing_length_mm"] == pytest.approx(60.0 - 16.0 + 40.0 + 45.0 + 2.0)


def test_a_flange_weighs_in_air_and_in_water() -> None:
    # to 300 m 1730 g at 200 mm, of which it displaces 0.3: at 120 mm 622.8 g and 186.84 g
    tube = replace(TUBE, ports=("any", "acme*"))
    wide = replace(PORT, outer_radius_mm=60.0, clear_diameter_mm=GUESS, housing=tube)
    without, built = model(replace(wide, id="acme-dome")), model(wide)
    totals = [one.totals(one.figures(0, one.settings(0, given()), information=False)) for one in (without, built)]
    assert totals[1]["mass_kg"][0] - totals[0]["mass_kg"][0] == pytest.approx(2 * 0.6228)
    in_water_kg = built.mass_in_water_kg()[0] - without.mass_in_water_kg()[0]
    assert in_water_kg == pytest.approx(2 * (0.6228 - 0.18684))
    rows = {row.id: row.unit_mass_kg for row in bill_of_materials(built.problem, built.hardware)}
    assert rows["adapter-flange"] == pytest.approx(0.6228)


def test_a_size_that_is_drawn_smaller_orders_no_shorter_housing() -> None:
    # a plug of 25 to 70 mm, drawn as 30 mm: the housing was ordered for 70 mm before anybody knew
    drawn = taken_as("plug_mm", Quantity(45.0, 25.0, 70.0, "estimated"), 30.0)
    assert (drawn.value, drawn.high) == (30.0, 70.0)
    pupil = taken_as("pupil_mm", Quantity(16.0, 10.0, 22.0, "estimated"), 12.0)
    assert (pupil.value, pupil.low, pupil.high) == (12.0, 10.0, 22.0)
