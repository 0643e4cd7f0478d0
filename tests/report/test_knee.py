"""The knee of the best image in words: what more would buy, in the short page, in full, and as a risk."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from uwopt.api.risks.told import risks_of
from uwopt.report.text.console import print_blocks
from uwopt.report.text.short import full_text_blocks, short_text_blocks
from uwopt.results.basis import Bought, Knee, ObjectiveValue
from uwopt.results.result import Result

Make = Callable[..., Any]
PARTS = {"camera": "cam-2", "lens": "lens-2", "port": "dome", "light": "lamp"}
WATT = Bought("power_w", 1.0, "W", 0.0123, PARTS, True)
MONEY = Bought("cost", 80.0, "EUR", 0.0, {}, False)


def best_image(make_result: Make, **changes: Any) -> Result:
    """A result of 2.5 Mbit/m2 whose limit of power is in the way."""
    knee = Knee("information", 2.5e6, "bit/m2", 0.01, 0.02, [WATT, MONEY])
    goal = ObjectiveValue("best_image", "maximise", 1.2e6, "bit/m2")
    made: Result = replace(make_result(), objective=goal, knee=replace(knee, **changes))
    return made


def text_of(blocks: Any) -> str:
    """What is printed, on one line."""
    stream = io.StringIO()
    print_blocks(blocks, stream)
    return " ".join(stream.getvalue().split())


def test_goal_says_what_a_watt_and_money_buy(make_result: Make) -> None:
    assert (
        "Goal: best image for its price: information 2.50 Mbit/m². One more watt beyond your limit buys 1.2 % more "
        "information, 80.0 EUR more buys nothing; whatever buys more than 1 % for a watt or 2 % for 100 USD is taken "
        "already."
    ) in text_of(short_text_blocks(best_image(make_result)))


def test_signal_to_noise_is_told_in_decibels(make_result: Make) -> None:
    # a ratio of 100 is 40 dB; 1.23 %: 20 log10(1.0123) = 0.106 dB
    text = text_of(short_text_blocks(best_image(make_result, quality="snr", value=100.0, unit="")))
    assert "best image for its price: signal to noise 40.0 dB." in text
    assert "buys 0.11 dB more signal to noise" in text


def test_full_text_names_the_system_that_more_would_buy(make_result: Make) -> None:
    text = text_of(full_text_blocks(best_image(make_result)))
    assert "buys 1.2 % more information, with cam-2 + lens-2 + dome + lamp." in text


def test_a_limit_below_the_knee_is_a_risk(make_result: Make) -> None:
    said = [risk.what for risk in risks_of(best_image(make_result))]
    assert "your limit of power holds the image back" in said
    free = replace(WATT, beyond_limit=False)
    assert "your limit of power holds the image back" not in [
        risk.what for risk in risks_of(best_image(make_result, bought=[free, MONEY]))
    ]


def test_without_time_for_the_knee_the_goal_stands_alone(make_result: Make) -> None:
    text = text_of(short_text_blocks(replace(best_image(make_result), knee=None)))
    assert "Goal: best image for its price. Images:" in text
