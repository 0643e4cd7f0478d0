"""The computer that takes the images: power and cost by the camera's interface, by hand from the class estimates."""

from __future__ import annotations

from typing import Any

import pytest
from priced_system import PRICED

import uwopt

MISSION: dict[str, Any] = {
    "practice": "bare", "name": "with a computer", "physics": "paper",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 300.0},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0, "light_count": 1, "camera_count": 1},
    "requirements": {"frame_interval_s": 100.0, "circle_of_confusion_px": 2.0},
    "limits": {"max_exposure_ms": 100.0, "currency": "EUR", "rates": {"EUR": 1.25}}, "catalog": {"host": "estimate"},
}  # fmt: skip
SYSTEM: dict[str, Any] = {**PRICED, "camera": {**PRICED["camera"], "wake_up_s": 4.8, "standby_w": 0.002}}
# A computer for GigE: 5 W (2.4 to 10), 200 USD (100 to 500); at 1.25 USD a euro 160 EUR (80 to 400).


def design(
    *, vehicle: dict[str, Any] | None = None, host: str = "estimate", count: int = 1, **camera: Any
) -> Any:
    """What `evaluate` says of the system with some keys changed."""
    mission = {
        **MISSION, "catalog": {"host": host},
        "vehicle": {**MISSION["vehicle"], "camera_count": count, **(vehicle or {})},
    }  # fmt: skip
    system = {**SYSTEM, "camera": {**SYSTEM["camera"], **camera}, "camera_count": count}
    result = uwopt.evaluate(mission, system)
    assert result.design is not None
    return result.design


def test_the_computer_of_an_interface_counts_in_power_and_cost() -> None:
    found, without = design(), design(host="none")
    assert (without.totals.power_w, without.totals.cost.value) == pytest.approx((4.0, 800.0))
    assert (found.totals.power_w, found.totals.cost.value) == pytest.approx((9.0, 960.0))
    assert (found.totals.cost.low, found.totals.cost.high) == pytest.approx((880.0, 1200.0))
    assert found.totals.cost.estimated == pytest.approx(160.0)
    assert found.scenes[0].figures["cost"] == pytest.approx(960.0)
    assert [row.id for row in found.bom if row.kind == "extra"] == ["host-computer"]
    assert "host-computer" not in [row.id for row in without.bom]


def test_two_cameras_share_one_computer() -> None:
    found = design(count=2)
    assert (found.totals.power_w, found.totals.cost.value) == pytest.approx(
        (2 * 4.0 + 5.0, 2 * 800.0 + 160.0)
    )


def test_the_computer_is_off_with_the_camera_between_images() -> None:
    # On for 4.8 s to wake up, 0.05 s of exposure and 0.1 s of transfer in 100 s.
    found = design(vehicle={"camera_between_images": "off"})
    assert found.totals.power_w == pytest.approx((4.0 + 5.0) * 4.95 / 100.0 + 0.002)


def test_a_camera_waits_for_its_computer_to_start_unless_it_says_how_long_it_takes() -> None:
    # 18 s for a computer to start (class estimate, from measured starts of 8 to 40 s), else as above; 10 mW of standby.
    found = design(vehicle={"camera_between_images": "off"}, wake_up_s=None, standby_w=None)
    assert found.totals.power_w == pytest.approx((4.0 + 5.0) * 18.15 / 100.0 + 0.010)
    # Without a computer in the count the camera alone wakes up, in 5 s.
    alone = design(vehicle={"camera_between_images": "off"}, wake_up_s=None, standby_w=None, host="none")
    assert alone.totals.power_w == pytest.approx(4.0 * 5.15 / 100.0 + 0.010)


def test_a_single_camera_of_an_interface_that_leaves_no_housing_has_its_computer_in_it() -> None:
    (row,) = (row for row in design(interface="CSI-2").bom if row.id == "host-computer")
    assert (row.count, row.note) == (1, "in the camera's housing, for CSI-2 reaches 0.3 m")


def test_what_a_camera_says_of_its_computer_counts_instead() -> None:
    found = design(host_power_w=1.5, host_price=50.0)
    assert (found.totals.power_w, found.totals.cost.value) == pytest.approx((5.5, 800.0 + 40.0))


def test_an_interface_that_no_class_knows_takes_the_class_of_any() -> None:
    assert design(interface="coax").totals.power_w == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("interface", "cable_m", "computers", "cost", "power_w"),
    [  # two cameras of 800 EUR and 4 W; computers: GigE 160 EUR, 5 W; USB3 250 USD = 200 EUR, 6 W
        ("GigE", 20.0, 1, 1760.0, 13.0),
        ("USB3", 20.0, 2, 2000.0, 20.0),  # 5 m of cable at most: each has its own
        ("USB3", 5.0, 1, 1800.0, 14.0),
        ("USB3", None, 1, 1800.0, 14.0),
        ("GigE", 120.0, 2, 1920.0, 18.0),
        ("CSI-2", None, 2, 1840.0, 15.0),  # 150 USD = 120 EUR, 3.5 W; 0.3 m of flat cable leave no housing
    ],
)
def test_where_the_cable_does_not_reach_each_camera_has_its_computer(interface, cable_m, computers, cost, power_w):
    found = design(count=2, interface=interface, vehicle={"cable_m": cable_m})
    (row,) = (row for row in found.bom if row.id == "host-computer")
    assert row.count == computers
    assert (f"{interface} reaches" in row.note) == (computers == 2)
    assert (found.totals.cost.value, found.totals.power_w) == pytest.approx((cost, power_w))
    assert found.scenes[0].figures["cost"] == pytest.approx(cost)  # of the columns that the search reads


HOUSING: dict[str, Any] = {
    "shape": "tube", "material": "acrylic", "inner_diameter_mm": 89.0, "inner_length_mm": 200.0,
    "outer_diameter_mm": 101.6, "depth_rating_m": 400.0, "ports": ["any"], "price": 100.0, "currency": "EUR",
}  # fmt: skip


@pytest.mark.parametrize(("interface", "cable_m", "heat_w"), [("GigE", 20.0, 4.0), ("GigE", 120.0, 9.0)])
def test_a_computer_heats_the_housing_that_it_stands_in(interface: str, cable_m: float, heat_w: float) -> None:
    """Of two cameras: 4 W in 0.0621 m2, air to wall 5 to 12, 6.3 mm of acrylic 0.17 to 0.2, to water 100 to 1000."""
    mission = {
        **MISSION, "catalog": {"host": "estimate", "housing": "required"},
        "vehicle": {**MISSION["vehicle"], "camera_count": 2, "cable_m": cable_m},
    }  # fmt: skip
    system = {
        **SYSTEM, "camera": {**SYSTEM["camera"], "interface": interface}, "camera_count": 2, "housing": HOUSING,
    }  # fmt: skip
    result = uwopt.evaluate(mission, system)
    assert result.design is not None
    totals = result.design.totals
    assert totals.housing_heat_w == pytest.approx(heat_w)
    coolest, warmest = heat_w / 0.06214 * (1 / 12 + 0.0063 / 0.2 + 1 / 1000), heat_w / 0.06214 * (
        1 / 5 + 0.0063 / 0.17 + 1 / 100
    )
    assert totals.housing_warmer_k == pytest.approx([coolest, warmest], rel=1e-3)


def test_without_a_housing_nothing_is_said_of_its_heat() -> None:
    totals = design().totals
    assert totals.housing_heat_w is None and totals.housing_warmer_k is None
