"""Cameras by the interfaces that the host has."""

from __future__ import annotations

from typing import Any

import pytest

from uwopt.catalog.choose import Choice, select
from uwopt.catalog.load import load_catalog
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
    known = load_catalog([tmp_path / "cameras.csv"])

    def own(made: Any) -> list[str]:
        return [camera.id for camera in made.cameras if camera.id.startswith("my-")]

    assert own(select(known)) == ["my-usb", "my-network", "my-board", "my-riddle"]
    asked = selected(mission(["usb3", "csi2"]), known, generic="never")
    assert own(asked) == ["my-usb", "my-board"]
    told = {e.part_id: (e.rule, e.reason) for e in asked.excluded}
    assert told["my-riddle"] == ("interface", "interface unknown, USB3 or CSI-2 is wanted")
    assert own(select(known, Choice(interfaces=["GigE"]))) == ["my-network"]


def test_every_interface_of_the_catalogue_can_be_asked_for():
    assert {camera.interface for camera in load_catalog().cameras} - {""} <= set(INTERFACES)


@pytest.mark.parametrize("given", ["gige", ["GigE"], ["gig-e", "GigE"]])
def test_interfaces_are_taken_in_any_spelling_once(given):
    assert mission(given).catalog.interfaces == ("GigE",)


def test_another_interface_is_told_with_those_there_are():
    with pytest.raises(MissionError, match=r"interfaces.*FireWire.*USB3"):
        mission(["FireWire"])
