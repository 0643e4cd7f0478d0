"""Of a kind of part of which none is left it is told what took how many out, and how deep the deepest may go."""

from __future__ import annotations

from pathlib import Path

import pytest
from test_least_change import FILES, mission, written

from uwopt.api.solving import solve
from uwopt.mission.mission import Mission
from uwopt.report.text.helps import depth_lines
from uwopt.report.text.layout import Grid, Text
from uwopt.report.text.nothing_fits import none_left_lines
from uwopt.report.text.short import short_text_blocks
from uwopt.results.basis import NoneLeft
from uwopt.results.result import Result

#: Beside ports for 300 m and 500 m one without a rating, and a dome for 11 000 m of which no radius is told.
PORTS = FILES["ports"] + "zz-unrated,flat,1.49,20,0,200,,2500,900,USD\nzz-trench,dome,1.49,20,,200,11000,2500,900,USD\n"


@pytest.fixture
def deep(tmp_path: Path) -> Mission:
    """A dive to 6 000 m, for which the lamp is rated and no port is, with four of the ports named."""
    parts = written(tmp_path)
    (parts / "ports.csv").write_text(PORTS, encoding="utf-8")
    asked = mission(parts, depth_m=6000.0)
    return asked.with_changes(catalog=asked.to_dict()["catalog"] | {"ports": ["zz-*"]})


def solved(asked: Mission) -> tuple[Result, NoneLeft]:
    """What is told, and of the one kind of which none is left."""
    told = solve(asked, confidence="central", quick=True)
    assert told.infeasible is not None
    (none,) = told.infeasible.none_left
    return told, none


def test_each_rule_tells_how_many_parts_it_takes_out_and_the_deepest_rating_is_named(deep: Mission) -> None:
    told, none = solved(deep)
    assert none.kind == "port" and none.too_shallow is not None
    assert (none.by_rule["depth rating"], none.too_shallow.unrated) == (3, 1)  # 300 m, 500 m, and without a rating
    assert (none.too_shallow.needed_m, none.too_shallow.deepest, none.too_shallow.deepest_m) == (6000.0, "zz-deep", 500)
    head, table, *_ = none_left_lines(told)
    assert isinstance(table, Grid) and isinstance(head, Text)
    rows = {why.plain: int(count.plain) for count, why in table.rows}
    assert rows["rated for less than 6 000 m"] == 2 and rows["without a known depth rating"] == 1
    assert head.plain.endswith(f"of the {sum(rows.values())} in the catalogue:")
    (said,) = map(str, depth_lines(told))
    assert "No port that the mission allows otherwise reaches the 6 000 m" in said
    assert "Deepest: port zz-deep, 500.0 m." in said


def test_a_part_that_is_rated_deep_enough_is_named_with_the_fact_that_it_lacks(deep: Mission) -> None:
    """No ports are named, so that of more than a hundred only what a fact keeps out is worth a line."""
    told, none = solved(deep.with_changes(catalog=deep.to_dict()["catalog"] | {"ports": []}))
    assert [*none.reasons] == ["zz-trench"]
    last = none_left_lines(told)[-1]
    assert isinstance(last, Text) and last.plain.startswith("Rated deep enough, but zz-trench: ")


def test_where_no_lamp_is_named_that_exists_that_is_told_at_once(tmp_path: Path) -> None:
    """Red lamps for a fish farm at night: no search tells more, and none is made; nor is good practice to blame."""
    asked = mission(written(tmp_path), depth_m=8.0)
    lamps = {"lights": ["*660nm*", "*orcatorch*"]}
    asked = asked.with_changes(catalog=asked.to_dict()["catalog"] | lamps, practice="recommended")
    told, none = solved(asked)
    assert none.kind == "light" and told.infeasible is not None
    assert not told.infeasible.no_help and not told.infeasible.not_known
    (block,) = [one for one in short_text_blocks(told) if getattr(one, "title", "") == "What would help"]
    said = "\n".join(str(line) for line in block.lines)
    assert "No light is left to choose of the" in said
    assert "catalog.lights: pattern '*660nm*' matches no part; uwopt catalog list --kind light prints all ids." in said
    assert "practice" not in said
