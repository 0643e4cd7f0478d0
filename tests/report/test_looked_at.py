"""Reports of walls and of targets in mid-water speak of these and of their distance."""

from __future__ import annotations

from uwopt.report.text.looked_at import in_figure, in_page, wording

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


def test_columns_of_a_table_stay_in_line() -> None:
    assert WALL("the floor     1.0") == "the wall      1.0"
    assert WATER("the floor     1.0") == "the target    1.0"


def test_floors_and_mixtures_keep_their_words() -> None:
    for scenes in ([{}], [{"target": "floor"}], [{"target": "wall"}, {"target": "floor"}]):
        assert wording({"scenes": scenes})("floor, altitude") == "floor, altitude"


def test_only_the_texts_of_a_page_change() -> None:
    page = '<p class="floor">the floor</p><script>Math.floor(1)</script><pre>seafloor: sand # floor</pre>'
    assert in_page(page, WALL) == page.replace("the floor", "the wall")
    drawn = in_figure({"data": [{"name": "on the floor", "x": [1.0]}]}, WALL)
    assert drawn == {"data": [{"name": "on the wall", "x": [1.0]}]}
