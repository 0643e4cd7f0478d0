"""Reports of walls and of targets in mid-water speak of these and of their distance."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from uwopt.report.text.looked_at import in_figure, in_page, wording, wording_of

WALL = wording({"scenes": [{"target": "wall"}]})
CEILING = wording({"scenes": [{"target": "ceiling"}]})
WATER = wording({"scenes": [{"target": "mid_water"}]})


def test_a_wall_has_a_distance() -> None:
    assert WALL("pixel on the floor at the nominal altitude") == "pixel on the wall at the nominal distance"
    assert WALL("Floor and altitudes; at_altitude_m") == "Wall and distances; at_altitude_m"
    assert WALL("aimed straight down") == "aimed straight ahead"
    assert CEILING("over the floor, aimed straight down") == "over the ceiling, aimed straight up"
    assert WATER("Test chart on textured sea floor") == "Test chart on textured target"


def test_keys_are_told_by_the_name_that_a_wall_has_for_them() -> None:
    assert WALL("altitude (altitude_m) 5.00 m -> 3.15 m") == "distance (distance_m) 5.00 m -> 3.15 m"
    assert WATER("vary altitude_tolerance_m or altitude_m") == "vary distance_tolerance_m or distance_m"


@pytest.mark.parametrize(("text", "told"), [
    ("vehicle:\n  altitude_m: 2.0\n  altitude_tolerance_m: 0.1", "distance (altitude_m), altitude_tolerance_m"),
    ("vehicle: {altitude_m: 2.0, distance_tolerance_m: 0.1}", "distance (altitude_m), distance_tolerance_m"),
    ("vehicle:\n  distance_m: 2.0  # once altitude_m: 3", "distance (distance_m), distance_tolerance_m"),
    (None, "distance (distance_m), distance_tolerance_m"),
])  # fmt: skip
def test_a_key_is_told_as_the_missions_file_has_it(text: str | None, told: str) -> None:
    made = cast(Any, SimpleNamespace(mission={"scenes": [{"target": "wall"}]}, mission_file=text and {"text": text}))
    assert wording_of(made)("altitude (altitude_m), altitude_tolerance_m") == told


def test_of_a_floor_too() -> None:
    made = cast(Any, SimpleNamespace(mission={"scenes": [{}]}, mission_file={"text": "vehicle: {distance_m: 2}"}))
    assert wording_of(made)("Floor, altitude (altitude_m)    2") == "Floor, altitude (distance_m)    2"
    made.mission_file["text"] = "vehicle: {altitude_m: 2}"
    assert wording_of(made)("Floor, altitude (altitude_m)") == "Floor, altitude (altitude_m)"


def test_columns_of_a_table_stay_in_line() -> None:
    assert WALL("the floor     1.0") == "the wall      1.0"
    assert WATER("the floor     1.0") == "the target    1.0"


def test_floors_and_mixtures_keep_their_words() -> None:
    for scenes in ([{}], [{"target": "floor"}], [{"target": "wall"}, {"target": "floor"}]):
        assert wording({"scenes": scenes})("floor, altitude") == "floor, altitude"
    mixed = wording({"scenes": [{"target": "mid_water"}, {}]})  # the lamps of a lander that looks down and ahead
    assert mixed("lights aimed straight down") == "lights aimed where the camera looks"


def test_only_the_texts_of_a_page_change() -> None:
    page = '<p class="floor">the floor</p><script>Math.floor(1)</script><pre>seafloor: sand # floor</pre>'
    assert in_page(page, WALL) == page.replace("the floor", "the wall")
    drawn = in_figure({"data": [{"name": "on the floor", "x": [1.0]}]}, WALL)
    assert drawn == {"data": [{"name": "on the wall", "x": [1.0]}]}
