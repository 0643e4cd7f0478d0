"""Result files read back: what is right comes back as it was, what is wrong is told with a way out."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import FrozenInstanceError, asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from uwopt.errors import ResultError
from uwopt.results.reading import read_result

Make = Callable[..., Any]


@pytest.fixture
def put(tmp_path: Path) -> Callable[[str | bytes], Path]:
    """Write a file to read."""

    def write(content: str | bytes) -> Path:
        file = tmp_path / "result.json"
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        return file

    return write


def refused(file: Path) -> str:
    with pytest.raises(ResultError) as told:
        read_result(file)
    text = str(told.value)
    assert str(file) in text and "Traceback" not in text
    return text


def changed(result: Any, *path: str | int, value: Any) -> str:
    """The JSON of a result with one value replaced, or left out where the value is ..."""
    data = json.loads(result.to_json())
    place = data
    for key in path[:-1]:
        place = place[key]
    if value is ...:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return json.dumps(data)


def test_results_come_back_as_they_were(put: Any, make_result: Make, make_front: Make) -> None:
    assert read_result(put(make_result().to_json())) == make_result()
    assert read_result(put(make_front().to_json())) == make_front()
    assert read_result(put(make_front(points=0).to_json())) == make_front(points=0)


def test_byte_order_mark_is_no_fault(put: Any, make_result: Make) -> None:
    assert read_result(put(b"\xef\xbb\xbf" + make_result().to_json().encode())) == make_result()


def test_missing_file_and_folder_are_told(tmp_path: Path) -> None:
    assert "no such file" in refused(tmp_path / "none.json")
    assert "is a folder" in refused(tmp_path)
    (tmp_path / "front.json").touch()
    assert f"name {tmp_path / 'front.json'}" in refused(tmp_path)


@pytest.mark.parametrize(("content", "words"), [
    ("", "is empty"),
    ("{'a': 1}", "is not JSON"),
    ("name: Reef\n", "is not JSON"),
    ("[1, 2]", "holds no result but a list"),
    ("{}", "has no schema"),
    ('{"schema": "other/1"}', "schema is 'other/1', so it is no result of uwopt"),
    ('{"schema": "uwopt.result/2"}', "schema is 'uwopt.result/2', this uwopt reads uwopt.result/1"),
    ('{"schema": ["uwopt.result/1"]}', "no result of uwopt"),
    ('{"schema": "uwopt.front/1"}', "objectives is missing"),
    ('{"schema": NaN}', "NaN is no number"),
    (b"\xff\xfe\x00", "not text in UTF-8"),
    ("[" * 100_000, "is not JSON"),
])  # fmt: skip
def test_other_files_are_told_from_results(put: Any, content: str | bytes, words: str) -> None:
    assert words in refused(put(content))


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 0.999])
def test_file_that_was_cut_off_is_told(put: Any, make_result: Make, share: float) -> None:
    text = make_result().to_json()
    assert "cut off" in refused(put(text[: int(share * len(text))]))


@pytest.mark.parametrize(("path", "value", "words"), [
    (("status",), ..., "status is missing"),
    (("timing_s", "total"), "long", 'timing_s.total is "long", not a number'),
    (("timing_s", "total"), "2.5", 'timing_s.total is "2.5", not a number'),
    (("recommendation", "scenes"), {}, "recommendation.scenes is an object, not a list"),
    (("recommendation", "scenes"), [], "recommendation.scenes is empty"),
    (("recommendation", "scenes", 0, "margins", 1, "value"), True,
     "recommendation.scenes[0].margins[1].value is true, not a number"),
    (("recommendation", "scenes", 0, "margins", 1, "colour"), "red",
     "recommendation.scenes[0].margins[1].colour is not known"),
    (("recommendation", "hardware", "lens"), ..., "recommendation.hardware.lens is missing"),
    (("recommendation", "hardware", "light_count"), "two", "recommendation.hardware.light_count is \"two\""),
    (("recommendation", "hardware", "light_mounts", 0, "y_m"), None, "light_mounts[0].y_m is null, not a number"),
    (("recommendation", "totals", "cost"), 5, "recommendation.totals.cost is 5, not an object"),
    (("recommendation", "bom", 0, "count"), 1.5, "recommendation.bom[0].count is 1.5, not a whole number"),
    (("certificate", "loaded"), None, "certificate.loaded is null, not a whole number"),
    (("assumptions",), "none", 'assumptions is "none", not a list'),
])  # fmt: skip
def test_wrong_values_are_named_with_their_path(
    put: Any, make_result: Make, path: tuple[str | int, ...], value: Any, words: str
) -> None:
    text = refused(put(changed(make_result(), *path, value=value)))
    assert words in text
    assert "changed by hand" in text


@pytest.mark.parametrize(("path", "value", "words"), [
    (("picks", 0, "point"), "p99", 'picks[0].point is "p99", no point of the front'),
    (("points", 2, "values", "cost"), ..., "points[2].values.cost is missing"),
    (("points", 1, "values", "power"), "much", 'points[1].values.power is "much", not a number'),
    (("points", 1, "design"), None, "points[1].design is null, not an object"),
    (("methods", 0, "seconds"), "2 s", 'methods[0].seconds is "2 s", not a number'),
    (("certificate", "parts_left"), {"cameras": "two"}, 'certificate.parts_left.cameras is "two", not a whole number'),
    (("certificate", "parts_left"), [3], "certificate.parts_left is a list, not an object"),
])  # fmt: skip
def test_wrong_values_of_a_front_are_named(
    put: Any, make_front: Make, path: tuple[str | int, ...], value: Any, words: str
) -> None:
    assert words in refused(put(changed(make_front(), *path, value=value)))


def test_many_faults_are_summed_up(put: Any, make_front: Make) -> None:
    data = json.loads(make_front().to_json())
    for point in data["points"]:
        point["curve"] = 1
        point["method"] = 2
    text = refused(put(json.dumps(data)))
    assert text.count("\n") < 12 and "more" in text


def test_results_that_do_not_tell_what_parts_are_left_are_read(put: Any, make_result: Make, make_front: Make) -> None:
    data = json.loads(make_result().to_json())
    del data["certificate"]["parts_left"]  # versions until now wrote none
    assert read_result(put(json.dumps(data))).parts_left is None
    assert read_result(put(make_front().to_json())).parts_left is None
    assert read_result(put(changed(make_front(), "certificate", value=None))).parts_left is None


def test_key_of_a_later_version_at_the_top_is_no_fault(put: Any, make_result: Make) -> None:
    assert read_result(put(changed(make_result(), "novelty", value=1))) == make_result()


def test_nearest_miss_is_held_against_the_layout_of_a_design(
    put: Any, make_result: Make, make_design: Make
) -> None:
    why = {"requirements": [], "relaxations": [], "nearest_miss": make_design()}
    result = make_result(status="infeasible", recommendation=None, infeasible=why)
    assert read_result(put(result.to_json())) == result
    text = refused(put(changed(result, "infeasible", "nearest_miss", "totals", "power_w", value="much")))
    assert 'infeasible.nearest_miss.totals.power_w is "much", not a number' in text


def test_numbers_of_numpy_come_back_as_plain_ones(put: Any, make_result: Make, make_design: Make) -> None:
    design = make_design(np.float64(40.0))
    scene = replace(design.scenes[0], figures={"snr_db": np.float32(30.5), "dof_far_m": np.inf})
    result = make_result(recommendation=replace(design, scenes=[scene]), seed=np.int64(7))
    again = read_result(put(result.to_json()))
    assert type(result.recommendation.objective_value) is float and type(result.seed) is int
    assert again.recommendation.scenes[0].figures == {"snr_db": 30.5, "dof_far_m": None}


def test_record_tells_its_fields_by_key_and_cannot_be_changed(make_result: Make) -> None:
    result = make_result()
    assert result.objective["value"] == result.objective.value == 40.0
    with pytest.raises(KeyError):
        result.objective["adds_up"]
    with pytest.raises(FrozenInstanceError):
        result.objective.value = 3.0
    with pytest.raises(ValidationError, match="colour"):
        replace(result, objective={**asdict(result.objective), "colour": "red"})
