"""Maps of which system wins where: regions and strips have the sizes that their switches say, by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from uwopt.report.pictures.system_maps import (
    COLOURS,
    NOTHING,
    RimPiece,
    cells,
    in_legend,
    labels,
    parted,
    stretches,
    system_map,
)
from uwopt.report.pictures.whatif_plots import whatif_figures
from uwopt.results.basis import ObjectiveValue
from uwopt.results.whatif import KeyValue, SpiderLine, Switch, VariedKey, WhatIf, WhatIfPoint, WinningSystem


def table(keys: dict[str, list[KeyValue]], best: dict[Any, int | None], switches: list[Switch], **more: Any) -> WhatIf:
    """A table of points with the systems that win there."""
    points = [
        WhatIfPoint(list(at), "infeasible" if one is None else "optimal", one, None if one is None else 1.0 + one)
        for at, one in best.items()
    ]
    systems = [WinningSystem(f"camera {n}", "lens", "port", "light", 2, False) for n in range(3)]
    varied = [VariedKey(key, "m/s", values, 1) for key, values in keys.items()]
    goal = ObjectiveValue("power", "minimise", None, "W")
    return WhatIf("complete", {}, goal, "", varied, points, systems, switches, **more)


def switch(key: str, at: float, first: int | None, second: int | None, *others: KeyValue | None) -> Switch:
    """One that is known to a hundredth."""
    return Switch(key, list(others), at - 0.005, at + 0.005, first, second, True)


def area(corners: list[tuple[float, float]]) -> float:
    """Of a polygon, by the shoelace formula."""
    sides = zip(corners, [*corners[1:], corners[0]], strict=True)
    return abs(sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in sides)) / 2


def areas(of: WhatIf) -> dict[int | None, float]:
    """What each system has of the map."""
    found: dict[int | None, float] = {}
    for pieces in cells(of):
        for system, corners in parted(pieces)[0]:
            found[system] = found.get(system, 0.0) + area(corners)
    return found


SQUARE: dict[str, list[KeyValue]] = {"a": [0.0, 1.0], "b": [0.0, 1.0]}
LEFT = {(0.0, 0.0): 0, (0.0, 1.0): 0, (1.0, 0.0): 1, (1.0, 1.0): 1}


def test_a_straight_boundary_parts_a_cell_where_it_runs():
    """From (0.2, 0) to (0.6, 1): 0.4 of the square on its left."""
    found = areas(table(SQUARE, LEFT, [switch("a", 0.2, 0, 1, None, 0.0), switch("a", 0.6, 0, 1, None, 1.0)]))
    assert found == {0: pytest.approx(0.4), 1: pytest.approx(0.6)}


def test_a_system_between_two_has_a_band_of_its_own():
    """From 0.25 to 0.5 at the bottom and from 0.25 to 0.75 at the top: 3/8, and 3/8 beyond."""
    ends = {0.0: (0.25, 0.5), 1.0: (0.25, 0.75)}
    begun = [switch("a", low, 0, 2, None, y) for y, (low, _) in ends.items()]
    ended = [switch("a", high, 2, 1, None, y) for y, (_, high) in ends.items()]
    found = areas(table(SQUARE, LEFT, begun + ended))
    assert found == {0: pytest.approx(0.25), 2: pytest.approx(0.375), 1: pytest.approx(0.375)}


def test_three_systems_meet_in_the_middle_of_their_switches():
    """At (0.5, 0), (1, 0.5) and (0.5, 1), so at (2/3, 1/2): 1/2 and 1/12 to the first, by hand."""
    best = {**LEFT, (1.0, 0.0): 1, (1.0, 1.0): 2}
    at = [switch("a", 0.5, 0, 1, None, 0.0), switch("a", 0.5, 0, 2, None, 1.0), switch("b", 0.5, 1, 2, 1.0, None)]
    found = areas(table(SQUARE, best, at))
    assert found == {0: pytest.approx(7 / 12), 1: pytest.approx(5 / 24), 2: pytest.approx(5 / 24)}


@pytest.mark.parametrize("right", [False, True])
def test_a_corner_alone_is_cut_off_by_its_own_switches(right):
    """Nothing fits in an upper corner of 0.5 by 0.4: a tenth of the square."""
    best = dict.fromkeys(LEFT, 0) | {(float(right), 1.0): None}
    along = switch("a", 0.5, *((0, None) if right else (None, 0)), None, 1.0)
    found = areas(table(SQUARE, best, [along, switch("b", 0.6, 0, None, float(right), None)]))
    assert found == {0: pytest.approx(0.9), None: pytest.approx(0.1)}


def test_where_no_switch_was_found_the_boundary_runs_halfway():
    assert areas(table(SQUARE, LEFT, [])) == {0: pytest.approx(0.5), 1: pytest.approx(0.5)}


def test_a_cell_with_a_point_that_is_not_solved_is_left_white():
    best = {at: one for at, one in LEFT.items() if at != (1.0, 1.0)}
    assert [*cells(table(SQUARE, best, []))] == []


def test_a_cell_of_one_system_is_its_rectangle():
    of = table(SQUARE, dict.fromkeys(LEFT, 2), [])
    assert [*cells(of)] == [[RimPiece(2, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])]]
    assert [label["text"] for label in labels(of)] == ["3"]


STRIPS: dict[str, list[KeyValue]] = {"speed": [1.0, 2.0, 3.0], "water": ["I", "II"]}
WINS = {(1.0, "I"): 0, (2.0, "I"): 0, (3.0, "I"): 1, (1.0, "II"): 1, (2.0, "II"): None, (3.0, "II"): None}
SWITCHES = [switch("speed", 2.25, 0, 1, None, "I"), switch("speed", 1.75, 1, None, None, "II")]


def test_strips_end_where_another_system_takes_over():
    of = table(STRIPS, WINS, SWITCHES)
    found = {water: [(one.low, one.high, one.system) for one in stretches(of, 0, water)] for water in ("I", "II")}
    assert found == {"I": [(1.0, 2.25, 0), (2.25, 3.0, 1)], "II": [(1.0, 1.75, 1), (1.75, 3.0, None)]}


def test_a_system_has_one_colour_in_all_plots_of_a_table():
    drawn = whatif_figures(table(STRIPS, WINS, SWITCHES))
    bars = {bar["name"].partition(":")[0]: bar["marker"]["color"] for bar in drawn["map"]["data"]}
    marks = [trace for trace in drawn["optimum"]["data"] if trace["mode"] == "lines+markers"]
    assert bars == {"1": COLOURS[0], "2": COLOURS[1], "nothing fits": NOTHING}
    assert [mark["marker"]["color"] for mark in marks] == [
        [COLOURS[0], COLOURS[0], COLOURS[1]], [COLOURS[1], NOTHING, NOTHING]
    ]  # fmt: skip
    diamonds = [trace for trace in drawn["optimum"]["data"] if trace["mode"] == "markers+text"]
    assert [text for trace in diamonds for text in trace["text"]] == ["1 → 2", "2 → –"]


def test_a_legend_is_shown_whole_on_a_telephone_and_names_those_that_win_most():
    """Long names ended at the rim, and 28 systems made 28 lines."""
    won = {(float(n), 0.0): n for n in range(28)} | {(float(n), 1.0): n for n in range(20, 28)}
    many = table({"a": [float(n) for n in range(28)], "b": [0.0, 1.0]}, won, [])
    ids = [f"a-camera-of-a-maker-with-a-very-long-name-{n}" for n in range(28)]
    systems = [replace(many.systems[0], camera=ids[n]) for n in range(28)]
    named = [in_legend(replace(many, systems=systems), n) for n in range(28)]
    assert all(len(line) <= 42 for one in named for line in one["name"].split("<br>"))
    assert "".join(named[3]["name"].split("<br>")).startswith(f"4: {ids[3]}")
    assert [n for n, one in enumerate(named) if one["showlegend"]] == list(range(20, 28))


def test_words_of_one_key_have_no_map():
    assert system_map(table({"water": ["I", "II"]}, {("I",): 0, ("II",): 1}, [])) is None


def test_what_moves_nothing_shares_one_line_of_the_spider():
    def line(key: str, *values: float) -> SpiderLine:
        points = [WhatIfPoint([f], "optimal", n, v) for n, (f, v) in enumerate(zip((0.9, 1.0), values, strict=True))]
        return SpiderLine(key, "", 1.0, points)

    of = table({}, {}, [], spider=[line("still", 2.0, 2.0), line("steep", 1.0, 2.0), line("firm", 2.0, 2.0)])
    steep, still = whatif_figures(of)["spider"]["data"]
    assert (steep["name"], steep["marker"]["symbol"]) == ("steep", ["circle-open", "circle"])
    assert still["name"] == "2 more, which move nothing"
    spokes = [line(f"key {n}", 1.0, 2.0 + n) for n in range(28)]
    many = whatif_figures(table({}, {}, [], spider=spokes))["spider"]["data"]
    assert [trace["name"] for trace in many if trace.get("showlegend", True)] == [
        "18 more, which move less", *(f"key {n}" for n in range(27, 17, -1))
    ]  # fmt: skip
    assert len(many) == 28
