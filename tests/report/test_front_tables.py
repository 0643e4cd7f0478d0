"""A front as text: what its named points are at settings that a person can type in."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from uwopt.report.text.console import print_blocks
from uwopt.report.text.front_tables import front_blocks
from uwopt.report.text.layout import Text, columns
from uwopt.results.design import SettableCheck
from uwopt.results.front import FrontResult

Make = Callable[..., Any]


def printed(front: FrontResult) -> str:
    """What is printed, on one line."""
    stream = io.StringIO()
    print_blocks(front_blocks(front), stream)
    return " ".join(stream.getvalue().split())


@pytest.fixture
def rounded(make_front: Make) -> FrontResult:
    """A front by power and information, each point with settings to type in: 1 W more, 12 % less information."""
    front = make_front("power", "information")
    points = []
    for point in front.points:
        design, scene = point.design, point.design.scenes[0]
        figures = scene.figures | {"information_bit_per_m2": 0.88 * point.values["information"]}
        totals = replace(design.totals, power_w=point.values["power"] + 1.0)
        check = SettableCheck(True, None, [], totals.power_w, totals)
        made = replace(design, rounded=check, scenes=[replace(scene, figures_as_set=figures)])
        points.append(replace(point, design=made))
    return replace(front, points=points)


def test_what_settings_to_type_in_cost_is_told_of_each_named_point(rounded: FrontResult) -> None:
    """p1 has 40 W and 1 Mbit/m2: 41 W are 2.5 % more; p8 19 W and 5.9 Mbit/m2: 20 W are 5.3 % more."""
    text = printed(rounded)
    _, _, told = text.partition("The same at settings to type in")
    told, _, rest = told.partition("The front, at exact settings")
    assert "Irises stand at marked stops" in told and "p8" in rest
    assert "cheapest 41.00 W (+2.5 %) 880.0 kbit/m² (-12.0 %)" in told
    assert "least power 20.00 W (+5.3 %) 5.192 Mbit/m² (-12.0 %)" in told


def test_decibels_are_told_apart_by_decibels_and_no_change_without_a_sign_of_less(rounded: FrontResult) -> None:
    objectives = [replace(rounded.objectives[1], name="snr_db", unit="dB"), rounded.objectives[0]]
    points = []
    for point in rounded.points:
        exact = {"snr_db": point.design.scenes[0].figures["snr_db"] + 0.38, "power": point.values["power"] + 1.00001}
        points.append(replace(point, values=exact))
    text = printed(replace(rounded, objectives=objectives, points=points))
    assert "cheapest 30.00 dB (-0.38 dB) 41.00 W (+0.0 %)" in text


def test_a_named_point_that_cannot_be_set_says_so(rounded: FrontResult, make_front: Make) -> None:
    first, *others = rounded.points
    none = replace(first.design, rounded=SettableCheck(False, None, ["min_snr_db"]))
    text = printed(replace(rounded, points=[replace(first, design=none), *others]))
    assert "cheapest no settings to type in were found" in text
    assert "The same at settings to type in" not in printed(make_front())  # of an earlier version


def test_ids_break_at_their_hyphens_where_a_column_is_narrow() -> None:
    """`raspberry-pi-16-mm-telephoto-hq-c` and `amera` stood on two lines."""
    grid = columns(("", "left"), ("", "right"))
    grid.add_row(Text("raspberry-pi-16-mm-telephoto-hq-camera + a lens"), Text("9 " * 35))
    stream = io.StringIO()
    print_blocks([grid], stream)
    lines = [line.partition("   ")[0] for line in stream.getvalue().splitlines() if line.strip()]
    assert lines == ["raspberry-pi-16-mm-", "telephoto-hq-camera + a lens"]


def test_a_front_that_was_stopped_without_a_system_says_so_first(make_front: Make) -> None:
    """It read "before the proof was complete, so better may exist and no system was found"."""
    told = printed(make_front(points=0, status="stopped"))
    assert "stopped Stopped by a limit before a system was found. Give it more time (--seconds 60), or" in told
    cut = printed(make_front(points=0, status="interrupted"))
    assert "Interrupted before a system was found" in cut and "at least two" not in cut
    assert "Let it run to its end" in cut


def test_a_front_that_was_stopped_says_before_its_systems_that_better_may_exist(make_front: Make) -> None:
    told = printed(make_front(status="stopped"))
    assert "stopped Stopped by a limit, so better may exist. 3 choices of hardware are found so far" in told
    assert "Give it more time (--seconds 60). Named points" in told
    assert "better may exist" not in printed(make_front()) and "--seconds" not in printed(make_front())
