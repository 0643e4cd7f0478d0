"""Connectors, cables, electronics, spares and the pressure test: in cost and bill, by hand from the class estimates."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from priced_system import PRICED

import uwopt
from uwopt.catalog.rest import DISK_GB, RestNeeds, rest_items, whole_disks_gb
from uwopt.errors import MissionError
from uwopt.forward.assembly import system_problem
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system
from uwopt.solvers.exact.imager_rules import totals

# To 1000 m, in USD: a connection 300 (120 to 750), lamp control 150 (50 to 450), spares 100 (40 to 250), test 600
# (300 to 1200). One camera and two lamps: 3 x 300 + 850 = 1750 (3 x 120 + 390 = 750, 3 x 750 + 1900 = 4150).
# At 1.25 USD a euro: 1400 EUR (600 to 3320).

LONG: dict[str, Any] = {
    "practice": "bare", "physics": "paper", "scene": {"water": "II", "seafloor": 0.2, "depth_m": 300.0},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0, "duration_h": 15_000.0, "orientation": "landscape"},
    "requirements": {"frame_interval_s": 100.0, "circle_of_confusion_px": 2.0}, "limits": {"cost_basis": "high"},
    "catalog": {"rest": "estimate"},
}  # fmt: skip


def design(
    rest: str = "estimate", *, cameras: int = 1, lamps: int = 2, basis: str = "central",
    vehicle: dict[str, Any] | None = None, limits: dict[str, Any] | None = None,
) -> Any:  # fmt: skip
    """What `evaluate` says of the system."""
    mission = mission_with(rest, cameras=cameras, basis=basis, vehicle=vehicle, limits=limits)
    found = uwopt.evaluate(mission, {**PRICED, "camera_count": cameras, "light_count": lamps}).design
    assert found is not None
    return found


def mission_with(
    rest: str = "estimate", *, cameras: int = 1, basis: str = "central", vehicle: dict[str, Any] | None = None,
    limits: dict[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """A mission that counts the rest."""
    return {
        "practice": "bare", "name": "with the rest", "physics": "paper",
        "scene": {"water": "II", "seafloor": 0.2, "depth_m": 300.0},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0, "light_count": [1, 2], "camera_count": cameras,
                    **(vehicle or {})},
        "requirements": {"frame_interval_s": 100.0, "circle_of_confusion_px": 2.0},
        "limits": {"currency": "EUR", "rates": {"EUR": 1.25}, "cost": 2300.0, "cost_basis": basis, **(limits or {})},
        "catalog": {"rest": rest},
    }  # fmt: skip


def cost_margin(found: Any) -> float:
    """What is left of the cost limit."""
    return float(next(m.margin for m in found.scenes[0].margins if m.requirement == "cost"))


def test_the_rest_counts_in_cost_and_bill() -> None:
    found, without = design(), design("none")
    assert without.totals.cost.value == pytest.approx(800.0)
    cost = found.totals.cost
    assert (cost.value, cost.low, cost.high) == pytest.approx((2200.0, 1400.0, 4120.0))
    assert cost.estimated == pytest.approx(1400.0)
    assert found.scenes[0].figures["cost"] == pytest.approx(2200.0)
    extras = {row.id: row.count for row in found.bom if row.kind == "extra"}
    assert extras == {
        "rest-camera-connection": 1, "rest-lamp-connection": 2, "rest-lamp-control": 1, "rest-spares": 1,
        "rest-pressure-test": 1,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("lamp", "cost", "wired"),
    [  # 2 x 300 + 150 USD are 600 EUR less; what flashes must be fired by a cable, whatever feeds it
        ({"kind": "continuous", "supply": "battery"}, 1600.0, False),
        ({"kind": "continuous", "supply": "external"}, 2200.0, True),
        ({"supply": "battery"}, 2200.0, True),
    ],
    ids=["torch", "fed", "fired"],
)
def test_torches_have_neither_cables_nor_electronics(lamp: dict[str, Any], cost: float, wired: bool) -> None:
    system = {**PRICED, "light": {**PRICED["light"], **lamp}, "light_count": 2}
    if lamp.get("kind"):
        system["settings"] = {"f_number": 4.0, "exposure_ms": 50.0, "gain": 1.0}
    found = uwopt.evaluate(mission_with(), system).design
    assert found is not None and found.totals.cost.value == pytest.approx(cost)
    assert found.scenes[0].figures["cost"] == pytest.approx(cost)  # of the columns that the search reads
    assert {"rest-lamp-connection", "rest-lamp-control"}.isdisjoint(row.id for row in found.bom) is not wired


def test_two_cameras_share_what_is_bought_once() -> None:
    # 2 x 800 + (2 + 1) x 240 + 680 EUR, and 120 USD for what fires both together
    found = design(cameras=2, lamps=1)
    assert found.totals.cost.value == pytest.approx(3096.0)  # of the bill
    assert found.scenes[0].figures["cost"] == pytest.approx(3096.0)  # of the columns that the search reads


@pytest.mark.parametrize(("basis", "left"), [("central", 100.0), ("high", -1820.0)])
def test_a_cost_limit_holds_for_the_rest_at_the_end_that_it_asks_for(basis: str, left: float) -> None:
    assert cost_margin(design(basis=basis)) == pytest.approx(left)


def test_the_data_cable_is_paid_by_its_length() -> None:
    # above 150 m 13 USD a metre (6 to 30): 20 m are 260 USD or 208 EUR (96 to 480)
    (row,) = (row for row in design(vehicle={"cable_m": 20.0}).bom if row.id == "rest-data-cable")
    assert (row.unit_price, row.unit_price_low, row.unit_price_high) == pytest.approx((208.0, 96.0, 480.0))
    assert row.model == "data cable of a camera, 20 m"
    assert design(vehicle={"cable_m": 20.0}).totals.cost.value == pytest.approx(2200.0 + 208.0)


def test_modems_stand_where_no_network_cable_reaches() -> None:
    def modems(cable_m: float) -> list[str]:
        return [item.id for item in rest_items(RestNeeds(10.0, cable_m=cable_m)) if item.id == "rest-link"]

    assert modems(100.0) == []
    assert modems(101.0) == ["rest-link"]


def test_a_battery_of_the_system_costs_weighs_and_limits() -> None:
    # above 150 m 4.9 USD a watt-hour: 500 Wh are 2450 USD or 1960 EUR; 14 g each: 7 kg
    own = {"duration_h": 10.0, "battery_wh": 500.0}
    carried, brought = (design(vehicle={**own, "supply": supply}) for supply in ("vehicle", "battery"))
    assert brought.totals.cost.value - carried.totals.cost.value == pytest.approx(1960.0)
    assert brought.totals.mass_kg - carried.totals.mass_kg == pytest.approx(7.0)
    limits = {m.requirement: m.limit for m in brought.scenes[0].margins}
    assert limits["energy_wh"] == pytest.approx(500.0)
    assert "energy_wh" not in {m.requirement for m in carried.scenes[0].margins}


def test_the_search_counts_the_disks_that_the_bill_has() -> None:
    # 1370 GB as below, in six disks of 250 GB at 0.15 USD a gigabyte; against a budget at 0.4 USD
    problem = system_problem(load_mission(LONG), load_system(PRICED))[0]
    disks_gb = problem.disks_gb(problem.cameras, [np.array([0.01])])
    with_disks, without = (
        totals(problem, problem.cameras, problem.lenses, np.zeros(1), 0, gigabytes) for gigabytes in (disks_gb, 0.0)
    )
    assert [float((a - b)[0]) for a, b in zip(with_disks, without, strict=True)] == pytest.approx(
        [1500 * 0.15, 1500 * 0.4, 0.0]
    )


@pytest.mark.parametrize(("limit_wh", "held_wh"), [(300.0, 300.0), (900.0, 500.0)])
def test_of_battery_and_limit_the_smaller_holds(limit_wh: float, held_wh: float) -> None:
    own = {"duration_h": 10.0, "battery_wh": 500.0, "supply": "battery"}
    found = design(vehicle=own, limits={"energy_wh": limit_wh})
    assert next(m.limit for m in found.scenes[0].margins if m.requirement == "energy_wh") == pytest.approx(held_wh)


@pytest.mark.parametrize(("limit_wh", "held_wh", "kept_wh"), [
    (None, 400.0, 100.0),  # a fifth of 500 Wh
    (450.0, 400.0, 50.0),
    (300.0, 300.0, 0.0),  # a limit is taken as it stands
])  # fmt: skip
def test_of_a_battery_its_reserve_is_kept(limit_wh: float | None, held_wh: float, kept_wh: float) -> None:
    own = {"duration_h": 10.0, "battery_wh": 500.0, "supply": "battery"}
    mission = {**mission_with(vehicle=own, limits={"energy_wh": limit_wh}), "reserve": {"energy": 0.2}}
    found = uwopt.evaluate(mission, {**PRICED, "light_count": 2}).design
    assert found is not None
    (margin,) = (one for one in found.scenes[0].margins if one.requirement == "energy_wh")
    assert (margin.limit, margin.reserve) == pytest.approx((held_wh, kept_wh))


def test_a_battery_of_the_system_must_say_what_it_holds() -> None:
    with pytest.raises(MissionError, match="supply = battery needs the energy that it holds"):
        design(vehicle={"supply": "battery"})


def test_disks_beyond_those_of_the_computer_are_bought() -> None:
    # 2000 x 1000 px of 12 bit every 100 s for 15 000 h: 1.62 TB, 1370 GB more than the computer has, for which six
    # disks of 250 GB are bought at 0.15 USD or 0.12 EUR a gigabyte; what the mission would allow does not matter
    found, bare = (design(rest, vehicle={"duration_h": 15_000.0}, limits={"storage_gb": 2000.0, "cost": 4000.0})
                   for rest in ("estimate", "none"))  # fmt: skip
    rows = {row.id: row for row in found.bom}
    assert rows["rest-storage"].unit_price == pytest.approx(1500 * 0.12)
    assert rows["rest-storage"].model == "disks of 1 500 GB beyond the 250 GB of the computer"
    assert found.scenes[0].figures["cost"] - bare.scenes[0].figures["cost"] == pytest.approx(1400.0 + 1500 * 0.12)
    brief = design(vehicle={"duration_h": 2000.0}, limits={"storage_gb": 2000.0})
    assert "rest-storage" not in {row.id for row in brief.bom}  # 216 GB


def test_disks_hold_the_images_of_the_rate_that_is_set() -> None:
    # twice as many images as every 100 s: 3.24 TB, 2990 GB more than the computer has, on twelve disks of 250 GB in
    # the place of six; half as many fill what is asked
    vehicle, limits = {"duration_h": 15_000.0}, {"storage_gb": 4000.0, "cost": 4000.0}
    mission = {**LONG, "vehicle": LONG["vehicle"] | vehicle, "limits": LONG["limits"] | limits}
    found = {}
    for rate_hz in (0.005, 0.01, 0.02):
        system = {**PRICED, "settings": {**PRICED["settings"], "frame_rate_hz": rate_hz}}
        found[rate_hz] = uwopt.evaluate(mission, system).design
    costs = [found[rate].scenes[0].figures["cost"] for rate in (0.005, 0.01, 0.02)]
    assert costs[0] == costs[1]
    assert costs[2] - costs[1] == pytest.approx((3000 - 1500) * 0.15)
    row = next(row for row in found[0.02].bom if row.id == "rest-storage")
    assert row.model == "disks of 3 000 GB beyond the 250 GB of the computer"


@pytest.mark.parametrize(
    ("interface", "computers", "bought_gb", "words"),
    [  # two cameras fill 3780 GB together, 3530 GB beyond one disk or twice 1640 GB beyond two; disks are bought whole
        ("GigE", 1, 3750.0, "disks of 3 750 GB beyond the 250 GB of the computer"),
        ("CSI-2", 2, 3500.0, "disks of 1 750 GB beyond the 250 GB of each computer"),
    ],
)
def test_each_computer_brings_its_own_disk(interface: str, computers: int, bought_gb: float, words: str) -> None:
    vehicle = {"duration_h": 17_500.0, "camera_count": 2}
    mission = {**LONG, "vehicle": LONG["vehicle"] | vehicle}
    system = {**PRICED, "camera": PRICED["camera"] | {"interface": interface}, "camera_count": 2}
    made = uwopt.evaluate(mission, system).design
    brief = uwopt.evaluate({**mission, "vehicle": mission["vehicle"] | {"duration_h": 1.0}}, system).design
    (row,) = (row for row in made.bom if row.id == "rest-storage")
    assert (row.count, row.model, row.count * row.unit_price) == (computers, words, pytest.approx(bought_gb * 0.15))
    for cost in (lambda design: design.totals.cost.value, lambda design: design.scenes[0].figures["cost"]):
        assert cost(made) - cost(brief) == pytest.approx(bought_gb * 0.15)  # of the bill, and of the search's columns


@pytest.mark.parametrize(("hours", "bought_gb"), [(2314.0, 0.0), (2316.0, 250.0), (4629.0, 250.0), (4631.0, 500.0)])
def test_a_disk_is_bought_whole(hours: float, bought_gb: float) -> None:
    # 3 MB every 100 s are 0.108 GB in an hour: 250 GB after 2314.8 h, 500 GB after 4629.6 h; nobody sells 0.1 GB
    rows = {row.id: row for row in design(vehicle={"duration_h": hours}, limits={"storage_gb": 2000.0}).bom}
    bought = rows["rest-storage"].unit_price / 0.12 if "rest-storage" in rows else 0.0
    assert bought == pytest.approx(bought_gb)


def test_disks_of_more_computers_are_no_dearer_than_of_one() -> None:
    # what bounds lean on: a group of cameras of which some share one computer counts as if each had its own
    filled_gb = np.arange(1.0, 20_000.0)[:, None]
    computers = np.arange(1.0, 9.0)
    bought = computers * whole_disks_gb(np.maximum(filled_gb - computers * DISK_GB, 0.0) / computers)
    assert (bought <= bought[:, :1]).all()


def test_without_lamps_nothing_is_wired_to_them() -> None:
    assert [item.id for item in rest_items(RestNeeds(10.0, lit=False))] == [
        "rest-camera-connection", "rest-spares", "rest-pressure-test"
    ]  # fmt: skip


@pytest.mark.parametrize(("depth_m", "test_usd"), [(150, 200), (151, 600), (1000, 600), (1001, 1600)])
def test_the_pressure_test_is_that_of_the_depth(depth_m: float, test_usd: float) -> None:
    assert rest_items(RestNeeds(depth_m))[-1].price.value == test_usd


def recommended(**catalog: Any) -> Any:
    """A survey of few words, in good practice."""
    return load_mission({
        "practice": "recommended", "scene": {"water": "II", "seafloor": "sand", "depth_m": 20}, "catalog": catalog,
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5}, "requirements": {"overlap": 0.6, "min_snr_db": 20},
    }).catalog  # fmt: skip


def test_good_practice_counts_the_rest_unless_extras_hold_it() -> None:
    assert recommended().rest == "estimate"
    assert recommended(rest="none").rest == "none"
    assert recommended(extras=[{"name": "cables", "cost": 500}]).rest == "none"
