"""Records of results: each refuses what it does not know, and every field says what it means."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from pydantic import TypeAdapter

from uwopt.results.front import FrontResult
from uwopt.results.record import Record, plain
from uwopt.results.result import Result


def records(kind: type[Record] = Record) -> Iterator[type[Record]]:
    """All kinds of record that have fields."""
    for below in kind.__subclasses__():
        yield from records(below)
        if "__pydantic_fields__" in vars(below):
            yield below


@pytest.mark.parametrize("kind", sorted(records(), key=lambda kind: kind.__name__))
def test_every_field_of_a_record_says_what_it_means(kind: Any):
    assert kind.__dataclass_params__.frozen
    assert kind.__pydantic_config__["extra"] == "forbid"
    assert [name for name, field in kind.__pydantic_fields__.items() if not field.description] == []


@pytest.mark.parametrize("kind", [Result, FrontResult])
def test_layout_of_a_file_can_be_told_as_a_json_schema(kind: Any):
    schema = TypeAdapter(kind).json_schema()
    assert schema["properties"]["status"]["type"] == "string"
    assert schema["$defs"]["Margin"]["additionalProperties"] is False
    json.dumps(schema)


def test_what_is_not_finite_is_absent_at_any_depth():
    assert plain({"a": [1.0, float("nan")], "b": {"c": (float("inf"), 2)}}) == {
        "a": [1.0, None],
        "b": {"c": [None, 2]},
    }
