"""What feeds and fires lamps: a vehicle's cable, their own battery, a trigger."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from uwopt.catalog.choose import Choice, Selection, select
from uwopt.catalog.compatibility import explain_pair
from uwopt.catalog.estimates import class_table
from uwopt.catalog.load import read_catalog
from uwopt.catalog.parts.kinds import FAVOURED
from uwopt.catalog.records import Camera, Lens, Light
from uwopt.errors import MissionError
from uwopt.evaluation.outside import other_parts
from uwopt.forward.assembly import selected
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system

HEADER = (
    "id,kind,flux_lm,power_w,beam_angle_deg,beam_medium,supply,run_time_min,trigger,switchable,depth_rating_m,"
    "flash_energy_j\n"
)
LAMPS = """\
my-lamp,continuous,1000,10,90,water,external,,,,300,
my-torch,continuous,1000,10,90,water,battery,50,none,,300,
my-tank-lamp,continuous,1000,10,90,water,battery,600,none,yes,300,
my-plain-lamp,continuous,1000,10,90,water,,,,,300,
my-riddle,continuous,1000,10,90,water,unknown,,,,300,
my-shapeless-lamp,continuous,1000,10,,water,external,,,,300,
my-flash,flash,,,90,water,external,,electrical,,300,20
my-slave,flash,,,90,water,external,,optical,,300,20
my-lonely-flash,flash,,,90,water,external,,none,,300,20
"""
SYSTEM = {
    "camera": "flir-bfs-u3-51s5m", "lens": "kowa-lm8jc10m", "port": "teledyne-benthos-2040-17v-sphere-17-in",
    "light": "my-lamp", "settings": {"f_number": 4.0, "exposure_ms": 1.0},
}  # fmt: skip


def catalog(folder: Path, lamps: str = LAMPS) -> Any:
    """The built-in catalogue with these lamps."""
    file = folder / "lights.csv"
    file.write_text(HEADER + lamps, encoding="utf-8")
    return read_catalog([file])


def own(selection: Selection) -> list[str]:
    """The lamps of this file that are left, without their first syllable."""
    return [light.id.removeprefix("my-") for light in selection.lights if light.id.startswith("my-")]


def reasons(selection: Selection) -> dict[str, str]:
    """Rule by lamp of this file."""
    return {e.part_id.removeprefix("my-"): e.rule for e in selection.excluded if e.part_id.startswith("my-")}


def test_lamps_are_chosen_by_what_feeds_them(tmp_path):
    known = catalog(tmp_path)
    fed = own(select(known, lamp_supply="external"))
    carried = own(select(known, lamp_supply="battery"))
    assert fed == ["lamp", "plain-lamp", "flash", "slave"]
    assert carried == ["torch", "tank-lamp"]
    assert own(select(known)) == ["lamp", "torch", "tank-lamp", "plain-lamp", "riddle", "flash", "slave"]


def test_each_lamp_that_is_left_out_is_counted_by_its_own_rule(tmp_path):
    found = reasons(select(catalog(tmp_path), lamp_supply="external"))
    assert found == {
        "torch": "lamp supply", "tank-lamp": "lamp supply", "riddle": "lamp supply",
        "shapeless-lamp": "vital facts", "lonely-flash": "trigger",
    }  # fmt: skip


def test_a_torch_that_is_named_or_owned_may_be_used(tmp_path):
    known = catalog(tmp_path)
    assert own(select(known, Choice(lights=["my_torch"]), lamp_supply="external")) == ["torch"]
    assert "torch" in own(select(known, Choice(owned=["my-torch"]), lamp_supply="external"))
    assert own(select(known, Choice(lights=["my-t*"]), lamp_supply="external")) == []


def test_a_battery_must_last_as_long_as_the_mission(tmp_path):
    known = catalog(tmp_path)  # 50 and 600 minutes at full
    assert own(select(known, lamp_supply="battery", duration_h=5 / 6)) == ["torch", "tank-lamp"]
    assert own(select(known, lamp_supply="battery", duration_h=0.84)) == ["tank-lamp"]
    assert reasons(select(known, lamp_supply="battery", duration_h=0.84))["torch"] == "run time"


def test_a_torch_of_which_nobody_says_how_long_it_lasts_lasts_as_those_that_tell_it(tmp_path):
    known = catalog(tmp_path, "my-torch,continuous,1000,10,90,water,battery,,none,,300,\n")
    told = [light.run_time_min for light in known.lights if light.flux_lm and light.flux_lm.value >= 5000.0]
    shown = [minutes for minutes in told if minutes]
    assert len(shown) == 2  # the two video lights that tell it: else the class is to be worked out anew
    hours = math.sqrt(math.prod(shown)) / 60.0
    assert own(select(known, duration_h=hours)) == ["torch"]
    assert reasons(select(known, duration_h=hours + 0.02))["torch"] == "run time"
    assert reasons(select(known, duration_h=2.0))["torch"] == "run time"
    assert own(select(known, Choice(lights=["my_torch"]), duration_h=2.0)) == ["torch"]


def test_a_torch_is_not_switched_between_images_unless_it_says_so(tmp_path):
    known = catalog(tmp_path)
    told = {name: known.part(f"my-{name}").switchable for name in ("lamp", "torch", "tank-lamp")}
    assert told == {"lamp": "yes", "torch": "no", "tank-lamp": "yes"}


@pytest.mark.parametrize(
    ("light", "rule", "severity"),
    [
        (Light(id="a", supply="battery", run_time_min=50), "lamp supply", "warning"),
        (Light(id="a", kind="flash", trigger="none"), "trigger", "fault"),
        (Light(id="a", kind="pulsed_led", trigger="optical"), "trigger", "warning"),
    ],
)
def test_what_a_lamp_lacks_is_told_of_a_system(light, rule, severity):
    parts = Camera(id="c", mounts=("C",), inline=True), Lens(id="l", mounts=("C",), inline=True)
    assert [(f.rule, f.severity) for f in explain_pair(*parts, light=light)] == [(rule, severity)]


@pytest.mark.parametrize("light", [Light(id="a"), Light(id="a", trigger="none"), Light(id="a", kind="flash")])
def test_of_other_lamps_nothing_is_told(light):
    parts = Camera(id="c", mounts=("C",), inline=True), Lens(id="l", mounts=("C",), inline=True)
    assert explain_pair(*parts, light=light) == []


def test_every_built_in_torch_is_fed_by_its_own_battery_and_every_strobe_is_fired():
    lights = read_catalog().lights
    assert {light.id for light in lights if light.trigger == "none"} == {
        light.id for light in lights if light.supply == "battery" and light.kind == "continuous"
    }
    assert all(light.trigger == "electrical" for light in lights if light.kind == "pulsed_led")
    assert not [light.id for light in lights if light.generic and light.supply != "external"]


def test_no_built_in_lamp_without_a_beam_is_searched():
    known = read_catalog()
    searched = {light.id for light in select(known, Choice(generic="allow")).lights}
    assert "deepsea-power-light-led-multi-sealite" not in searched
    assert "deepsea-power-light-led-sealite-lsl-flood" in searched  # its measured profile tells the beam


def test_options_of_a_strobe_are_lamps_of_their_own():
    # The sheet: 2 Hz and 100 degrees as standard, 10 Hz and 65 degrees as options.
    known = read_catalog()
    found = {
        (light.max_rate_hz.value, light.beam_angle_deg.value)
        for light in known.lights
        if light.id.startswith("arctic-rays-dragonfish-mini-strobe")
    }
    assert found == {(2, 100), (10, 100), (2, 65), (10, 65)}


def test_no_estimate_is_at_the_end_that_favours_a_design():
    # Longest field names first: `f-number-max` before none, so that each key is judged by its own field.
    at_the_good_end = [
        key
        for key, row in class_table().items()
        for field, sign in FAVOURED.items()
        if key.startswith(tuple(f"{kind}-{field.replace('_', '-')}-" for kind in ("camera", "lens", "port", "light")))
        and row.low < row.high
        and row.central == (row.high if sign > 0 else row.low)
    ]
    assert at_the_good_end == []
    strobe = class_table()["light-efficacy-lm-per-w-pulsed-led"]
    assert strobe.central == pytest.approx((19 * 94) ** 0.5, rel=0.01)


def mission(practice: str, **vehicle: Any) -> Any:
    """A survey of few words."""
    return load_mission({
        "practice": practice, "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, **vehicle}, "requirements": {"overlap": 0.6, "min_snr_db": 20},
    })  # fmt: skip


def test_good_practice_takes_lamps_that_the_vehicle_feeds():
    assert mission("recommended").vehicle.lamp_supply == "external"
    assert mission("recommended", lamp_supply="battery").vehicle.lamp_supply == "battery"
    assert mission("bare").vehicle.lamp_supply == "any"


def test_a_mission_hands_supply_and_duration_to_the_choice_of_parts(tmp_path):
    known = catalog(tmp_path)
    asked = mission("bare", lamp_supply="battery", duration_h=0.84)
    assert own(selected(asked, known, generic="never")) == ["tank-lamp"]
    told = {d.path: d.message for d in other_parts(asked, known, load_system(SYSTEM))}
    assert "takes its power from outside, battery is wanted" in told["light"]


def test_another_supply_is_told_with_those_there_are():
    with pytest.raises(MissionError, match=r"lamp_supply = 'mains'.*external"):
        mission("bare", lamp_supply="mains")
