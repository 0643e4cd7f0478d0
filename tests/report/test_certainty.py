"""How certain a recommendation is, in words: against sentences written by hand."""

from __future__ import annotations

import io
from collections.abc import Callable

from uwopt.report.text.certainty import certainty_block
from uwopt.report.text.console import print_blocks
from uwopt.report.text.doubts import robustness_block
from uwopt.report.text.layout import Block
from uwopt.results.result import Result

COUNTED = {
    "asked": 0.9, "enough": True, "held": 0.95, "held_low": 0.94, "held_high": 0.96, "scenarios": 1024,
    "held_in_choice": 0.97, "scenarios_in_choice": 256, "p50_in_choice": 61.0, "objective_p50": 62.0,
    "objective_p90": 90.0, "f_number": 4.0, "lost_to": [], "drawn": ["reflectance of the floor"],
    "central_objective": 30.0, "central_held": 0.8, "central_p50": None,
}  # fmt: skip


def text_of(some: Block) -> str:
    """A block as it is printed, in one line."""
    stream = io.StringIO()
    print_blocks([some], stream)
    return " ".join(stream.getvalue().split())


def test_what_is_best_by_central_numbers_stands_beside_what_is_recommended(make_result: Callable[..., Result]) -> None:
    """Both in the scenarios of the choice; of its parts those that differ, or all; the same parts are told once."""
    best = make_result().best
    assert best is not None
    ours = best.hardware.ids
    for hardware, named in (
        (["acme-cam-9", *ours[1:]], "with acme-cam-9 instead;"),
        (["acme-cam-9", "acme-lens-9"], "with acme-cam-9 and acme-lens-9;"),
    ):
        result = make_result(confidence=COUNTED | {"central_hardware": hardware})
        (block,) = certainty_block(result)
        text = text_of(block)
        assert f"30.00 W {named} of the 256 scenarios of the choice it holds in 80 %" in text
        assert "what is recommended holds in 97 %, in half of all with 61.00 W" in text
        assert "reflectance" not in text  # all that is drawn stands with what else was assumed
        assert "scenarios draw reflectance of the floor" in text_of(robustness_block(result))
    (block,) = certainty_block(make_result(confidence=COUNTED | {"central_hardware": ours}))
    assert "30.00 W with the same parts" in text_of(block) and "of the choice" not in text_of(block)
