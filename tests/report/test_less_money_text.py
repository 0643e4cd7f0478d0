"""A system that costs much less, in words."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from uwopt.api.risks.told import risks_of
from uwopt.report.text.console import print_blocks
from uwopt.report.text.short import full_text_blocks, short_text_blocks
from uwopt.results.basis import LessMoney
from uwopt.results.result import Result

Make = Callable[..., Any]
PARTS = {"camera": "acme-cam", "lens": "cheap-[red]lens", "port": "acme-dome", "light": "acme-lamp"}


def with_cheaper(make_result: Make, **changes: Any) -> Result:
    """A result with such a system; 40 W and 7 206 USD are the best system's."""
    values: dict[str, Any] = {
        "hardware": PARTS, "light_count": 9, "price": 3895.0, "price_of_best": 7206.0, "currency": "USD", "value": 40.4,
        "value_of_best": 40.0, "cost_limit": 3894.2,
    }  # fmt: skip
    made: Result = replace(make_result(), less_money=LessMoney(**values | changes))
    return made


def said(make_result: Make, blocks: Callable[[Result], Any] = short_text_blocks, **changes: Any) -> str:
    """What is printed of it, on one line."""
    stream = io.StringIO()
    print_blocks(blocks(with_cheaper(make_result, **changes)), stream)
    return " ".join(stream.getvalue().split())


def test_what_is_saved_and_given_up_is_told_with_the_limit_that_asks_for_it(make_result: Make) -> None:
    expected = (
        "For less money With lens cheap-[red]lens and 9 lights: 3 300 USD less (46 %) for 1 % more power, "
        "40.40 W by exact settings; limits.cost: 3895 asks for it, or better."
    )
    assert expected in said(make_result) and expected in said(make_result, full_text_blocks)


@pytest.mark.parametrize(("even", "told"), [(0.57, True), (0.85, False), (None, False)])
def test_light_that_is_less_even_is_told_and_then_it_is_not_as_good(
    make_result: Make, make_design: Make, make_scene: Make, even: float | None, told: bool
) -> None:
    lit = make_design(scenes=[replace(make_scene("reef"), figures={"snr_db": 30.0, "uniformity": 0.91})])
    made = replace(with_cheaper(make_result, uniformity=even, value=40.1), recommendation=lit)
    stream = io.StringIO()
    print_blocks(short_text_blocks(made), stream)
    text = " ".join(stream.getvalue().split())
    assert ("Its light is less even: 57 % of the mean in the darkest place, not 91 %." in text) == told
    assert ("it costs more than it must" in [risk.what for risk in risks_of(made)]) != told


def test_over_scenarios_it_is_told_by_medians(make_result: Make) -> None:
    assert (
        "for 2.5 % less power, 39.00 W by medians; it holds in 98 % of the scenarios of the choice. It was found once "
        "the choice was made, and betters it: take it instead."
    ) in said(make_result, value=39.0, cost_limit=None, held=0.98)
    assert "betters it" not in said(make_result, value=40.1, cost_limit=None, held=0.98)


def test_where_nothing_saves_enough_nothing_is_said(make_result: Make) -> None:
    stream = io.StringIO()
    print_blocks(short_text_blocks(make_result()), stream)
    assert "For less money" not in stream.getvalue()


def test_what_is_as_good_for_much_less_is_a_great_risk(make_result: Make) -> None:
    def risks(value: float) -> list[str]:
        return [f"{one.what}: {one.figure}" for one in risks_of(with_cheaper(make_result, value=value))]

    told = "it costs more than it must: 7 200 USD against 3 900 USD"
    assert told in risks(40.3)[:2] and told in risks(39.8)
    assert told not in risks(40.5)
    assert told in risks(30.0)[:2]  # for much less money and much less power
