"""Cameras by the interfaces that the host has."""

from __future__ import annotations

from typing import Any

import pytest

from uwopt.catalog.choose import Choice, select
from uwopt.catalog.interfaces import does_reach, reaches_m
from uwopt.catalog.load import read_catalog
from uwopt.catalog.tables import built_in_rows
from uwopt.errors import MissionError
from uwopt.forward.assembly import selected
from uwopt.mission.keys import INTERFACES
from uwopt.mission.mission import load_mission

CAMERAS = """\
id,resolution_x_px,resolution_y_px,pixel_pitch_um,mounts,interface,qe,colour,shutter
my-usb,2000,1000,3.45,C,USB3,0.6,mono,global
my-network,2000,1000,3.45,C,GigE,0.6,mono,global
my-board,2000,1000,3.45,C,CSI-2,0.6,mono,global
my-riddle,2000,1000,3.45,C,,0.6,mono,global
"""


def mission(interfaces: Any) -> Any:
    """A survey of few words."""
    return load_mission({
        "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5}, "requirements": {"overlap": 0.6},
        "catalog": {"interfaces": interfaces},
    })  # fmt: skip


def test_cameras_are_chosen_by_the_interfaces_that_the_host_has(tmp_path):
    (tmp_path / "cameras.csv").write_text(CAMERAS, encoding="utf-8")
    known = read_catalog([tmp_path / "cameras.csv"])

    def own(made: Any) -> list[str]:
        return [camera.id for camera in made.cameras if camera.id.startswith("my-")]

    assert own(select(known)) == ["my-usb", "my-network", "my-board", "my-riddle"]
    asked = selected(mission(["usb3", "csi2"]), known, generic="never")
    assert own(asked) == ["my-usb", "my-board"]
    told = {e.part_id: (e.rule, e.reason) for e in asked.excluded}
    assert told["my-riddle"] == ("interface", "interface unknown, USB3 or CSI-2 is wanted")
    assert own(select(known, Choice(interfaces=["GigE"]))) == ["my-network"]


def test_every_interface_of_the_catalogue_can_be_asked_for():
    assert {camera.interface for camera in read_catalog().cameras} - {""} <= set(INTERFACES)


@pytest.mark.parametrize("given", ["gige", ["GigE"], ["gig-e", "GigE"]])
def test_interfaces_are_taken_in_any_spelling_once(given):
    assert mission(given).catalog.interfaces == ("GigE",)


def test_another_interface_is_told_with_those_there_are():
    with pytest.raises(MissionError, match=r"interfaces.*FireWire.*USB3"):
        mission(["FireWire"])


@pytest.mark.parametrize(
    ("interface", "longest_m"),  # of passive cables, by the makers and magazines that interfaces.csv names
    [("CSI-2", 0.3), ("USB3", 5.0), ("Camera Link", 4.0), ("CoaXPress", 40.0), ("GigE", 100.0), ("10GigE", 100.0)],
)
def test_a_cable_carries_images_as_far_as_its_interface_reaches(interface, longest_m):
    assert does_reach(interface, longest_m) and not does_reach(interface, 1.01 * longest_m)


def test_an_unknown_interface_reaches_only_a_computer_beside_it():
    assert does_reach("", None) and does_reach("coax", None)
    assert not does_reach("", 0.1) and not does_reach("coax", 0.1)


def test_every_reach_has_its_source_and_every_interface_its_row():
    rows = list(built_in_rows("interfaces.csv"))
    assert all(row["source_url"].startswith("https://") and row["source_date"] for row in rows if row["reach_m"])
    assert set(INTERFACES) <= {row["interface"] for row in rows}
    assert "coax" not in reaches_m()


def test_without_a_computer_beside_them_cameras_must_reach_over_the_cable(tmp_path):
    (tmp_path / "cameras.csv").write_text(CAMERAS, encoding="utf-8")
    known = read_catalog([tmp_path / "cameras.csv"])

    def own(host: str) -> list[str]:
        plain = mission(None).to_dict()
        changed = {"vehicle": plain["vehicle"] | {"cable_m": 20.0}, "catalog": plain["catalog"] | {"host": host}}
        made = selected(load_mission({**plain, **changed}), known, generic="never")
        return [camera.id for camera in made.cameras if camera.id.startswith("my-")]

    assert own("none") == ["my-network"]
    assert own("estimate") == ["my-usb", "my-network", "my-board", "my-riddle"]


def test_parts_of_which_nobody_says_that_they_are_sold_can_be_left_out():
    known = read_catalog()
    told = {e.part_id: e for e in select(known, Choice(availability="known")).excluded}
    unsure = [camera.id for camera in known.cameras if camera.availability == "unknown"]
    assert unsure and all(told[name].rule == "availability" for name in unsure)
    assert not any(told[name].reason.startswith("nobody says") for name in told if name not in {
        part.id for kind in ("camera", "lens", "port", "light", "housing") for part in known.parts(kind)
        if part.availability == "unknown" and not part.generic
    })  # fmt: skip
    named = select(known, Choice(cameras=[unsure[0]], availability="known"))
    assert "availability" not in {e.rule for e in named.excluded if e.part_id == unsure[0]}
